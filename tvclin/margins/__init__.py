"""Stability margins that mean what they say, also on an unstable plant.

The rooms inside: `loop` is what has margins, `stability` comes first, `frequencies` says where to
look, `crossings` finds and refines, `record` holds the answer, and `criteria` judges it.
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
