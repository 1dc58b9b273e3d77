"""The report's control as a feedback: trim inside its dead band, then the whole limit."""

from __future__ import annotations

from dataclasses import dataclass

from tvclin.base.errors import between, number
from tvclin.control.laws.trim import TrimLaw

_LETTING_GO = 0.9
"""Of the dead band, at which the whole limit is let go."""


@dataclass(frozen=True)
class DeadBandLaw(TrimLaw):
    """The report's control as a feedback: trim inside the dead band, then the whole limit.

    When the deflection asked for reaches K times the limit, the whole limit is used until it has
    fallen to 0.9 K of the limit: the work is done, and trim and attitude feedback have the nozzle
    again. It switches on the deflection asked for, so with drift it meets the
    literal dead band, not that of (18).

    Parameters
    ----------
    plant : Plant
        The plant it is designed on.
    gain : float
        Gain of the feedback on z, over that of trim. One places the poles about where
        the canonical gains do; with more, the attitude feedback undoes the lean that the dead band
        is for.
    dead_band : float
        K, from 0.01 to one.

    Raises
    ------
    InputError
        As `TrimLaw`, and for a dead band outside [0.01, 1]: zero would switch on any rounding.
    """

    gain: float = 1.0
    dead_band: float = 0.5

    _keys = "model=plant.model gain dead_band"

    def __post_init__(self) -> None:
        super().__post_init__()
        K = number("dead_band", self.dead_band, between(0.01, 1.0))
        object.__setattr__(self, "dead_band", K)

    @property
    def engage(self) -> float:  # type: ignore[override]
        """K."""
        return self.dead_band

    @property
    def release(self) -> float:  # type: ignore[override]
        """A little less than K, so that the nozzle does not chatter on the edge."""
        return _LETTING_GO * self.dead_band
