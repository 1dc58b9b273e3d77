"""The answer of `tvclin autopilot --least`: gains for the least nozzle."""

from dataclasses import dataclass, replace

from tvclin.base.errors import InputError
from tvclin.case.case import Case
from tvclin.cli.gains import with_gains
from tvclin.cli.inputs import chosen, only_with
from tvclin.cli.options import asked, switch
from tvclin.cli.output import print_tables, say, say_notes
from tvclin.control.autopilot.design_rules import LEAST_NOZZLE
from tvclin.control.margins.criteria import Criteria
from tvclin.design.least_gains import LeastGains
from tvclin.design.least_gains_curves import least_asked
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.winds.shaped import ShapedWind

_DURATION_RATIOS = (1.0, 0.5, 2.0)
"""Durations of the winds, over that of the case; a single wind would be overfitted."""


@dataclass(frozen=True)
class LeastOptions:
    """Options of the search for gains; `grouped` gives them to a command."""

    least: bool = switch(
        "--least",
        "Find the gains that need the least deflection of all that meet the criteria: in"
        " the wind, and in winds half and twice as long.",
    )
    three_gains: bool = switch("--three-gains", "With --least: also feed back the angle of attack.")
    crossover: float | None = asked("With --least: highest gain crossover, in rad/s.")
    limits: bool = switch(
        "--limits", "With --least: find the least limit that flights survive, not the least peak."
    )
    stops: int | None = asked(
        "With --least --limits: number of sudden ends of each wind to survive as well.", shown="0"
    )

    panel = "Gains for the least nozzle"

    def over(self, plan: StudyPlan) -> StudyPlan:
        """Return a plan whose design is this search, where --least is given."""
        if not self.least:
            only_with("--least", **vars(self))
            return plan
        crossover = chosen(self.crossover, plan.asked.crossover)
        design = with_gains(plan.asked, design=LEAST_NOZZLE, crossover=crossover)
        return replace(plan, design=design)

    def found(self, case: Case, criteria: Criteria) -> LeastGains | None:
        """Return the gains for the least nozzle; None without --least."""
        design, wind = case.asked, case.wind_in_plane
        if not self.least:
            return None
        if design.design != LEAST_NOZZLE:
            raise InputError("give --least, or gains and a rule for them, not both")
        if not isinstance(wind, ShapedWind):
            raise InputError(
                "gains for the least nozzle are sought in pulses of three durations: give no"
                " --winds; with its gains tvclin autopilot and fly go through a sounding"
            )
        winds = [
            wind.history({"wind_duration": ratio * wind.duration}) for ratio in _DURATION_RATIOS
        ]
        return least_asked(
            case,
            winds,
            criteria,
            gains=("attitude", "rate", "alpha") if self.three_gains else ("attitude", "rate"),
            limits=self.limits,
            stops=self.stops or 0,
        )


def print_least(gains: LeastGains) -> None:
    """Print the gains, the active constraints of the optimum, and notes."""
    print_tables(gains.table())
    say(f"Held by: {', '.join(gains.active) or 'no constraint, a flat minimum'}")
    say_notes(gains.notes)
