"""`tvclin optimum`: the minimum peak deflection that survives a wind (appendix C)."""

from typing import TYPE_CHECKING

import numpy as np
import typer

from tvclin.boundary.optimum.minimum_peak import NOT_CONVERGED
from tvclin.cli.inputs import case_of
from tvclin.cli.options import GROUP, MOTION, RATE_LIMIT, At, Given, ShownCurves, Source, asked
from tvclin.cli.output import print_json, print_tables, say, say_notes, say_required
from tvclin.cli.wind import WindOptions
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.requirement.case_requirement import study_requirement
from tvclin.requirement.nominal_requirement import KnownWind
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import linear_notes

if TYPE_CHECKING:
    from tvclin.plots.curves import Curves


def optimum(
    vehicle: Source = "configuration-i",
    time: At = None,
    winds: WindOptions = GROUP,
    start: float | None = asked(
        "Start of the control, in s; negative: before the wind.", shown="the onset of the wind"
    ),
    horizon: float | None = asked("Time after which the deflection must be zero again, in s."),
    rate_limit: Given = RATE_LIMIT,
    motion: Given = MOTION,
    shown: ShownCurves = GROUP,
) -> None:
    """Print the least peak deflection that survives a wind known beforehand, a lower bound.

    It is at nominal dynamic pressure. No control needs less; tvclin study is the verdict.

    Exit code 0: found; 1: only a lower bound was found; 2: bad input.
    """
    from tvclin import plots

    changes = rate_limit.over, motion.over
    case = case_of(vehicle, *changes, wind=winds.over, told=("optimum",), time=time)
    plant, wind, title = case.plant.rigid, case.history, winds.title(case, vehicle)
    start = float(wind.onset) if start is None else start
    known_wind = KnownWind.of(plant, wind, start, horizon, case.nozzle.rate_limit)
    shown.write(
        lambda: _curves(plant, known_wind.deflection, wind, title),
        lambda curves: plots.response_chart(curves, f"Minimum-peak control\n{title}"),
    )
    required, notes = study_requirement(case), linear_notes(float(wind.peak))
    if shown.as_json:
        print_json(winds.document(case, required) | known_wind.as_dict() | {"notes": notes})
    else:
        print_tables(known_wind.table(title))
        say_required(required)
        say_notes(notes)
    if known_wind.best.status == NOT_CONVERGED:
        say("Error: the optimum was not reached; only the lower bound is proved", err=True)
        raise typer.Exit(1)


def _curves(plant: Plant, deflection: History, wind: History, title: str) -> "Curves":
    """Return the curves of the response, until three times the end of the wind."""
    from tvclin.plots import response_curves

    first = min(0.0, float(deflection.onset), float(wind.onset))
    times = np.linspace(first, 3.0 * float(wind.end), 601)
    response = attitude_responses(plant, deflection, wind, times)
    return response_curves(response, "optimum", title, deflection=deflection, wind=wind)
