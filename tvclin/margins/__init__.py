"""Stability margins that mean what they say, also on an unstable plant.

The rooms inside: `loop` is what has margins, `record` holds the answer, and `criteria` judges it.
The arithmetic is in `kernels.loop_margins`.
"""

from tvclin.margins.criteria import CRITERIA, Criteria, Judgement, Requirement
from tvclin.margins.loop import Loop
from tvclin.margins.record import Crossings, Margins, loop_margins

__all__ = [
    "CRITERIA",
    "Criteria",
    "Crossings",
    "Judgement",
    "Loop",
    "Margins",
    "Requirement",
    "loop_margins",
]
