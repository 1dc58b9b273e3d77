"""Option of the criteria of margins, and the criteria that it names."""

from dataclasses import dataclass, replace

from tvclin.base.errors import one_of
from tvclin.cli.options import asked
from tvclin.control.margins.criteria import CRITERIA
from tvclin.studyfile.study_plan import StudyPlan

MODES = "modes: a vehicle file with [[bending]] or [[slosh]], and no --rigid"


@dataclass(frozen=True)
class CriteriaOptions:
    """The option; `grouped` gives it to a command."""

    criteria: str | None = asked(
        "classic (6 dB, 30 deg) or aircraft (6 dB, 45 deg); numbers: --set criteria.KEY VALUE.",
        shown="classic",
    )
    panel = "Criteria"

    def over(self, plan: StudyPlan) -> StudyPlan:
        """Return a plan with the named criteria."""
        if self.criteria is None:
            return plan
        return replace(plan, criteria=CRITERIA[one_of("--criteria", self.criteria, CRITERIA)])
