"""An autopilot in a wind beside trim, the boundaries and the minimum, and its worst wind."""

from tvclin.comparison.duration import WorstDuration, worst_duration
from tvclin.comparison.trim import TrimComparison, compare_with_trim

__all__ = ["TrimComparison", "WorstDuration", "compare_with_trim", "worst_duration"]
