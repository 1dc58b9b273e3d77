"""The linear models: plant, modes, verdict, deflections, the exact response and what it loads."""
