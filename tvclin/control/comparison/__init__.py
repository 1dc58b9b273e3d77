"""An autopilot in a wind beside trim, the boundaries and the minimum, and its worst wind."""
