"""Answer of `tvclin boundary` in a wind: required deflection by dead band, and the minimum."""

from typing import TYPE_CHECKING, Any

import numpy as np
import typer

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.boundary.optimum.minimum_peak import NOT_CONVERGED
from tvclin.cli.inputs import chosen
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

    plant, wind = case.plant.rigid, case.history
    begin, horizon = chosen(control[0], float(wind.onset)), control[1]
    known_wind = KnownWind.of(plant, wind, begin, horizon, case.nozzle.rate_limit)
    shown.write(
        lambda: _curves(plant, known_wind.deflection, wind, title),
        lambda curves: plots.response_chart(curves, f"Minimum-peak control\n{title}"),
    )
    required = study_requirement(case, case.dead_band)
    by_dead_band, notes = _required(plant, wind, dead_bands)
    verdict = "; ".join([known_wind.verdict, *([required.see_study] if required else [])])
    answer(
        shown.as_json,
        lambda: (
            winds.document(case, required)
            | known_wind.as_dict()
            | {"boundaries": _document(dead_bands, by_dead_band), "notes": notes}
        ),
        lambda: print_answer(
            verdict,
            known_wind.dead_band_table(title, dead_bands, by_dead_band),
            notes=notes,
            more=more,
            details=lambda: print_tables(known_wind.table("The control that knows the wind")),
        ),
    )
    if known_wind.best.status == NOT_CONVERGED:
        say("Error: the optimum was not reached; only the lower bound is proved", err=True)
        raise typer.Exit(1)


def _required(
    plant: Plant, wind: History, dead_bands: FloatArray
) -> tuple[RequiredDeflection | None, list[str]]:
    """Return the required deflection of each dead band, None if there is none, and notes."""
    notes = [*linear_notes(float(wind.peak))]
    try:
        return required_deflection(plant, wind, dead_bands), notes
    except InputError as error:
        return None, [*notes, f"there is no boundary limit: {error}"]


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
