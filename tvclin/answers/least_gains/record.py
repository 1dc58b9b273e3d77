"""Record of gains for the least nozzle, with the active criteria and notes."""

from __future__ import annotations

from dataclasses import dataclass

from tvclin.answers.least_gains.question import Question
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.documents import keyed
from tvclin.base.lines import Table, degrees, number
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.margins.margins import Margins

PEAK, BOUNDARY = "peak", "boundary"
"""Meanings of the deflection of `LeastGains`."""


@dataclass(frozen=True, eq=False)
class LeastGains(Shown):
    """Gains with the minimum deflection of all gains with the specified margins.

    Attributes
    ----------
    question : Question
        Specification: plant, winds, criteria, nozzle.
    autopilot : Autopilot
        The gains, with actuator and delay.
    meaning : str
        "peak": the deflection is the peak of the linear loop, without a limit. "boundary": it is
        the minimum limit with which flights survive, as of `closed_loop_boundary`; it is lower, by
        0.15 to 0.4 of trim as a rule.
    deflection : float
        Largest deflection over the winds [rad], in size.
    relative : float
        The deflection normalised by the trim ``|B alpha_w,max|`` of the worst wind.
    each : ndarray
        The deflection [rad] of each wind, ``(winds,)``.
    worst_wind : int
        Index of the wind with the largest deflection.
    margins : Margins
        Margins of the loop.
    active : tuple of str
        Active constraints of the minimum: names of margins within 0.5 percent of their limits,
        "crossover", and the winds, by peak and duration, where several require the same
        deflection. Empty where more gain and less gain both require more.
    unseen : float
        With limits, the boundary [rad] in the same winds with 23 sudden ends, most of which the
        search did not use; else None.
    notes : tuple of str
        Limitations of these gains.
    """

    question: Question
    autopilot: Autopilot
    meaning: str
    deflection: float
    relative: float
    each: FloatArray
    worst_wind: int
    margins: Margins
    active: tuple[str, ...]
    unseen: float | None
    notes: tuple[str, ...]

    as_dict = keyed(
        "meaning deflection_deg part_of_trim=relative worst_wind each_deg active"
        " unseen_stops_deg=unseen notes"
    )

    def table(self) -> Table:
        """Return the table of the deflection in each wind."""
        words = {
            "peak": "largest deflection of the linear loop",
            "boundary": "least limit with which flights survive",
        }
        q = self.question
        rows = tuple(
            ((name,), degrees(f"least.{name}", angle), number(f"least.{name}.part", angle / trim))
            for name, angle, trim in zip(q.names, self.each, q.trims, strict=True)
        )
        caption = f"Least nozzle: {words[self.meaning]}"
        return Table(caption, ("wind", "[deg]", "of trim"), rows)

    _keys = (
        "attitude_gain=autopilot.attitude_gain rate_gain_s=autopilot.rate_gain"
        " alpha_gain=autopilot.alpha_gain meaning deflection_deg over_trim=relative"
        " disk_margin=margins.disk_margin held_by=active notes"
    )
