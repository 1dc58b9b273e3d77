"""What tests of the panel ask for: the controls of a source, moved."""

from typing import Any

import tvclin as tv
from tvclin.show.explorer import choices
from tvclin.show.explorer.choices import Choices


def values(plan: tv.studyfile.StudyPlan) -> dict[str, Any]:
    """Return where the controls begin for a plan."""
    return {
        **{field: one[2] for field, one in choices.lists(plan, ["vehicle"]).items()},
        **{field: switch[1] for field, switch in choices.switches(plan).items()},
        **{field: slider.value for field, slider in choices.sliders(plan, [plan.vehicle]).items()},
    }


def moved(source: Any = "configuration-i", **changes: Any) -> Choices:
    """Return the choices of a panel on a source, with controls moved, in the units of labels."""
    plan = choices.with_numerical_gains(tv.load_study(source))
    return choices.choices_of(plan, plan.vehicle, values(plan) | changes)
