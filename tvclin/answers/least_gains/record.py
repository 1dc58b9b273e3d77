"""The gains that need the least nozzle, what holds them, and what is to be known about them."""

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


@dataclass(frozen=True, eq=False)
class LeastGains(Shown):
    """Of all gains that have the margins asked for, those that need the least deflection.

    Attributes
    ----------
    question : Question
        What was asked: plant, winds, criteria, nozzle.
    autopilot : Autopilot
        The gains, with actuator and delay.
    meaning : str
        "peak": the deflection is the largest of the linear loop, without a stop. "boundary": it is
        the least limit with which flights survive, as of `closed_loop_boundary`; it is lower, by
        0.15 to 0.4 of trim as a rule.
    deflection : float
        The largest over the winds [rad], in size.
    relative : float
        The same over ``|B alpha_w,max|`` of the wind that asks it.
    each : ndarray
        The deflection [rad] of each wind, ``(winds,)``.
    worst_wind : int
        The place of the wind that asks most.
    margins : Margins
        Of the loop.
    active : tuple of str
        What keeps the deflection from being less: names of margins that are met with less than 0.5
        percent to spare, "crossover", and the winds, by peak and duration, where several ask the
        same. Empty where more gain and less gain both ask more.
    unseen : float
        With limits the boundary [rad] in the same winds with 23 sudden stops, most of which the
        search did not know; else None.
    notes : tuple of str
        What is to be known before these gains are believed.
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
        """Return what each wind asks."""
        words = {
            "peak": "largest deflection of the linear loop",
            "boundary": "least limit with which flights survive",
        }
        q = self.question
        rows = tuple(
            ((name,), degrees(f"least.{name}", one), number(f"least.{name}.part", one / trim))
            for name, one, trim in zip(q.names, self.each, q.trims, strict=True)
        )
        caption = f"Least nozzle: {words[self.meaning]}"
        return Table(caption, ("wind", "[deg]", "of trim"), rows)

    _keys = (
        "attitude_gain=autopilot.attitude_gain rate_gain_s=autopilot.rate_gain"
        " alpha_gain=autopilot.alpha_gain meaning deflection_deg over_trim=relative"
        " disk_margin=margins.disk_margin held_by=active notes"
    )
