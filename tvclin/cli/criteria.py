"""Options of the criteria of margins, and the criteria that they specify."""

from dataclasses import dataclass, replace

from tvclin.base.errors import nonnegative, one_of
from tvclin.cli.inputs import only_with
from tvclin.cli.options import asked
from tvclin.control.margins.criteria import CRITERIA
from tvclin.studyfile.study_plan import StudyPlan

MODES = "modes: a vehicle file with [[bending]] or [[slosh]], and no --rigid"


@dataclass(frozen=True)
class CriteriaOptions:
    """The options in one place; `grouped` gives them to a command."""

    criteria: str | None = asked(
        "classic (6 dB, 30 deg) or aircraft (6 dB, 45 deg).", shown="classic"
    )
    gain_db: float | None = asked(
        "Required gain margin, up and down, in dB, in place of that of --criteria."
    )
    phase_deg: float | None = asked(
        "Required phase margin, in deg, in place of that of --criteria."
    )
    delay_margin_ms: float | None = asked("Required delay margin, in ms.")
    mode_gain_db: float | None = asked("Required gain margin of each gain-stabilised mode, in dB.")
    mode_phase_deg: float | None = asked(
        "Required phase margin of each phase-stabilised mode, in deg."
    )

    panel = "Criteria"

    def over(self, plan: StudyPlan) -> StudyPlan:
        """Return a plan with the named criteria, or with numbers of the user's."""
        if plan.vehicle.structure is None:
            only_with(MODES, mode_gain_db=self.mode_gain_db, mode_phase_deg=self.mode_phase_deg)
        limits: dict[str, float] = {}
        for option, names, value, unit in (
            ("--gain-db", ("aero_margin_dB", "gain_increase_dB"), self.gain_db, "dB"),
            ("--phase-deg", ("phase_margin_deg",), self.phase_deg, "deg"),
            ("--delay-margin-ms", ("delay_margin",), self.delay_margin_ms, "ms"),
            ("--mode-gain-db", ("mode_gain_margin_dB",), self.mode_gain_db, "dB"),
            ("--mode-phase-deg", ("mode_phase_margin_deg",), self.mode_phase_deg, "deg"),
        ):
            if value is not None:
                minimum = float(nonnegative(option, value, unit)) / (
                    1000.0 if unit == "ms" else 1.0
                )
                limits |= dict.fromkeys(names, minimum)
        named = plan.held_to
        if self.criteria is not None:
            named = CRITERIA[one_of("--criteria", self.criteria, CRITERIA)]
        return replace(plan, criteria=named.with_limits("the command line", **limits))
