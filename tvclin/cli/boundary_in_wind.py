"""Answer of `tvclin boundary` in a wind: required deflection by dead band, and the minimum."""

from typing import TYPE_CHECKING, Any

import numpy as np
import typer

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.boundary.optimum.minimum_peak import NOT_CONVERGED
from tvclin.cli.options import ShownCurves
from tvclin.cli.output import answer, print_answer, print_tables, say
from tvclin.cli.wind import WindOptions
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.requirement.case_requirement import study_requirement
from tvclin.requirement.nominal_requirement import (
    KnownWind,
    RequiredDeflection,
    required_deflection,
)
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import linear_notes

if TYPE_CHECKING:
    from tvclin.plots.curves import Curves


def print_in_wind(
    case: StudyPlan,
    winds: WindOptions,
    title: str,
    dead_bands: FloatArray,
    control: tuple[float | None, float | None],
    more: bool,
    shown: ShownCurves,
) -> None:
    """Print the required deflection of a case at nominal dynamic pressure, and the minimum peak.

    `control`: start and horizon [s] of the control that knows the wind.
    """
    from tvclin import plots

    plant, wind, (start, horizon) = case.plant.rigid, case.history, control
    start = float(wind.onset) if start is None else start
    known_wind = KnownWind.of(plant, wind, start, horizon, case.nozzle.rate_limit)
    shown.write(
        lambda: _curves(plant, known_wind.deflection, wind, title),
        lambda curves: plots.response_chart(curves, f"Minimum-peak control\n{title}"),
    )
    required, notes = study_requirement(case, case.dead_band), [*linear_notes(float(wind.peak))]
    by_dead_band = None
    try:
        by_dead_band = required_deflection(plant, wind, dead_bands)
    except InputError as error:
        notes.append(f"there is no boundary limit: {error}")
    see = [] if required is None else [required.see_study]
    answer(
        shown.as_json,
        lambda: (
            winds.document(case, required)
            | known_wind.as_dict()
            | {"boundaries": _document(dead_bands, by_dead_band), "notes": notes}
        ),
        lambda: print_answer(
            "; ".join([known_wind.verdict, *see]),
            known_wind.dead_band_table(title, dead_bands, by_dead_band),
            notes=notes,
            more=more,
            details=lambda: print_tables(known_wind.table("The control that knows the wind")),
        ),
    )
    if known_wind.best.status == NOT_CONVERGED:
        say("Error: the optimum was not reached; only the lower bound is proved", err=True)
        raise typer.Exit(1)


def _document(dead_bands: FloatArray, required: RequiredDeflection | None) -> list[dict[str, Any]]:
    """Return limit, deflection and reason for each dead band, for JSON."""
    if required is None:
        return []
    names = "dead_band", "limit", "deflection_deg", "governed_by"
    columns = dead_bands, required.limit, np.degrees(np.abs(required.deflection)), required.governs
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return [dict(zip(names, row, strict=True)) for row in rows]


def _curves(plant: Plant, deflection: History, wind: History, title: str) -> "Curves":
    """Return the curves of the response, until three times the end of the wind."""
    from tvclin.plots import response_curves

    first = min(0.0, float(deflection.onset), float(wind.onset))
    times = np.linspace(first, 3.0 * float(wind.end), 601)
    response = attitude_responses(plant, deflection, wind, times)
    return response_curves(response, "boundary", title, deflection=deflection, wind=wind)
