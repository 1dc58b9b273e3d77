"""`tvclin boundary`: boundary limits over the dead band, in one wind or over its duration."""

from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from tvclin.ascent.wind_along import SoundingWind
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, one_of, positive, within
from tvclin.base.quantities import NOMINAL
from tvclin.boundary.limit import OK, boundary_limit
from tvclin.boundary.open_loop import with_larger_requirements
from tvclin.boundary.optimum.minimum_peak import NOT_CONVERGED
from tvclin.cli.inputs import case_of, chosen, only_with
from tvclin.cli.options import (
    GROUP,
    MODEL_AND_PLANE,
    SOURCE_HELP,
    At,
    More,
    Options,
    ShownCurves,
    option,
)
from tvclin.cli.output import answer, draw, print_answer, print_tables, say
from tvclin.cli.wind import WindOptions, cut_condition, note_one_sign, with_gust_for
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.requirement.case_requirement import study_requirement
from tvclin.requirement.nominal_requirement import (
    KnownWind,
    RequiredDeflection,
    required_deflection,
)
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.coefficients import Coefficients
from tvclin.winds.histories import History
from tvclin.winds.shaped import SHAPES
from tvclin.winds.wind_angles import linear_notes

if TYPE_CHECKING:
    from tvclin.plots.curves import Curves

TAU_BETA = [0.5, 1.0, 2.0, 4.0, 6.0, 8.0, 12.0, 16.0, 20.0]
DEAD_BANDS = [1.0, 0.75, 0.5, 0.25, 0.0]
_IN_WIND = "a vehicle and no --tau-beta (tvclin boundary VEHICLE)"
"""What an answer in the wind of a case takes."""
_CUT = "this part of the sounding, cut to {:g} s with steps at its ends,"


def boundary(
    vehicle: Annotated[
        str | None,
        typer.Argument(
            metavar="VEHICLE|STUDY",
            help=f"{SOURCE_HELP} Without one the flight path is held fixed.",
        ),
    ] = None,
    time: At = None,
    winds: WindOptions = GROUP,
    dead_band: list[float] | None = option(
        "Dead band K, from 0 to 1; may be given several times.", shown="1, 0.75, 0.5, 0.25 and 0"
    ),
    tau_beta: list[float] | None = option(
        "Duration of the wind times beta (with damping, times the pole), in place of the wind of"
        " the vehicle; may be given several times.",
        shown="without a vehicle, 0.5 to 20",
    ),
    start: float | None = option(
        "Start of the control that knows the wind, in s; negative: before the wind.",
        shown="the onset of the wind",
    ),
    horizon: float | None = option("Time after which its deflection must be zero again, in s."),
    model: Options = MODEL_AND_PLANE,
    more: More = False,
    shown: ShownCurves = GROUP,
) -> None:
    """Print the boundary limit for each dead band, and the lower bound of any control: no verdict.

    Of a vehicle it is in its wind, and the minimum, of a wind known beforehand, is a lower bound:
    no control needs less. Without a vehicle, or with --tau-beta, it is over the duration of the
    wind, as y_BR in figure 2, a ratio to static trim. All of it is at nominal dynamic pressure, and
    no verdict; tvclin study has that.

    Exit code 0: the minimum is proved; 1: only a lower bound of it is; 2: bad input.
    """
    dead_bands = within("--dead-band", dead_band or DEAD_BANDS, 0.0, 1.0)
    if vehicle is not None and tau_beta is None:
        case = case_of(
            vehicle, model.applied_to, wind=winds.applied_to, questions=("boundary",), time=time
        )
        case = with_gust_for(case, case.dead_band)
        title = winds.title(case, vehicle)
        print_in_wind(case, winds, title, dead_bands, (start, horizon), more, shown)
        return
    pulse = {name: value for name, value in vars(winds).items() if name != "wind"}
    only_with(_IN_WIND, **pulse, start=start, horizon=horizon, csv=shown.csv)
    x = within("--tau-beta", positive("--tau-beta", tau_beta or TAU_BETA), 1e-6, 1e6)
    _print_over_duration(_subject(vehicle, time, model), winds.wind, x, dead_bands, more, shown)


def _print_over_duration(
    subject: tuple[str, Plant, str, str],
    shape: str | None,
    x: FloatArray,
    K: FloatArray,
    more: bool,
    shown: ShownCurves,
) -> None:
    """Print boundary limits y_BR over duration tau beta, `x` ``(n,)``, and dead band K, ``(k,)``.

    y_BR is a ratio to static trim, tau the duration, and beta the unstable pole on a fixed path.

    `subject`: name of the vehicle, plant, plane and wind shape. `shape`: shape of --wind, None
    without it. `more`: whether all notes are printed.
    """
    from tvclin import plots

    name, plant, plane, file_shape = subject
    wind = one_of("--wind", chosen(shape, file_shape), SHAPES)
    pulse: Any = SHAPES[wind]
    # of one unit of peak: the boundary limit does not depend on it
    pulses = pulse(peak=1.0, duration=x[:, None] / plant.coefficients.pole)
    # with the status of limits above which some limits do not survive
    limits = with_larger_requirements(plant, pulses, K, boundary_limit(plant, pulses, K))
    coefficients = plant.coefficients if name else None
    axis = "tau*beta" if coefficients is None else f"tau*{coefficients.pole_symbol}"
    curve = np.linspace(0.05, max(float(x.max()), 1.0), 200)
    draw(shown.plot, lambda: plots.boundary_chart(curve, K.tolist(), coefficients))
    title = f"{name}, {plant.model}, {plane}" if name else "Any vehicle, flight path fixed"
    case = {"vehicle": name or None, "wind": wind, "model": plant.model, "plane": plane}
    document = case | {axis.replace("*", "_"): x, "dead_band": K, "limit": limits.limit}
    answer(
        shown.as_json,
        lambda: document | {"status": limits.status.tolist()},
        lambda: print_answer(
            f"{_largest(axis, x, K, limits.limit)}: boundary limit {NOMINAL}, no verdict",
            limits.table(f"{title}: boundary limit y_BR, {wind} wind", axis, x, K),
            notes=_notes(axis, x, K, limits.status),
            more=more,
        ),
    )


def _largest(axis: str, x: FloatArray, K: FloatArray, limit: FloatArray) -> str:
    """Return the largest limit ``(n, k)`` of a table in words, with its duration and dead band.

    `axis`: name of the abscissa. `x`: abscissas, ``(n,)``. `K`: dead bands, ``(k,)``.
    """
    finite = np.where(np.isfinite(limit), limit, -1.0)  # below every limit
    n, k = np.unravel_index(np.argmax(finite), finite.shape)
    return f"at most {finite[n, k]:.3f} of static trim, at {axis} = {x[n]:g} and K = {K[k]:g}"


def _subject(
    vehicle: str | None, time: float | None, model: Options
) -> tuple[str, Plant, str, str]:
    """Return name, plant, plane and wind shape of a file, or of a vehicle with beta = B = 1.

    `time`: flight time [s] of a schedule. `model`: options of model and plane. Without a vehicle
    the flight path is fixed and the name empty: the boundary limit over static trim, y_BR, is then
    the same function of tau beta, duration times unstable pole, for all beta [1/s] and all B, the
    trim deflection per angle of attack.
    """
    if vehicle is None:
        model.only_with("a vehicle")
        only_with("a vehicle", at=time)
        plant = Plant(Coefficients.from_beta(beta=1.0, B=1.0), "fixed-path")
        return "", plant, "pitch", "triangular"
    # `questions`: name of this question, for notes on what it neglects of the file
    case = case_of(vehicle, model.applied_to, time=time, questions=("boundary --tau-beta",))
    return case.vehicle.name or vehicle, case.plant.rigid, case.plane, case.shape


def _notes(axis: str, x: FloatArray, K: FloatArray, status: Any) -> list[str]:
    """Return notes on irregular entries of a table, with their K and range of the abscissa.

    `axis`: name of the abscissa. `x`: abscissas, ``(n,)``. `K`: dead bands, ``(k,)``. `status`:
    statuses, ``(n, k)``.
    """
    where: dict[tuple[str, str], list[str]] = {}
    for k, column in zip(K, status.T, strict=True):
        for irregular in dict.fromkeys(column[column != OK].tolist()):
            odd = x[column == irregular]  # abscissas of this status
            span = f"{odd.min():g} to {odd.max():g}" if odd.size > 1 else f"{odd[0]:g}"
            where.setdefault((irregular, span), []).append(f"{k:g}")
    return [
        f"K = {', '.join(bands)}, {axis} {span}: {irregular}"
        for (irregular, span), bands in where.items()
    ]


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

    `winds`: options of the wind. `title`: vehicle and wind, above the table. `dead_bands`: K,
    ``(k,)``. `control`: start and horizon [s] of the control that knows the wind. `more`: whether
    the details are printed. `shown`: options of JSON, CSV file and figure.
    """
    from tvclin import plots

    plant, wind, (start, horizon) = case.plant.rigid, case.history, control
    begin = chosen(start, float(wind.onset))
    known_wind = KnownWind.of(plant, wind, begin, horizon, case.nozzle.rate_limit)
    shown.write(
        lambda: _curves(plant, known_wind.deflection, wind, title),
        lambda curves: plots.response_chart(curves, f"Minimum-peak control\n{title}"),
    )
    required = study_requirement(case, case.dead_band)
    by_dead_band, notes = _required(case, dead_bands)
    verdict = _verdict(known_wind, case) + (f"; {required.see_study}" if required else "")
    of_dead_bands = {"boundaries": _document(dead_bands, by_dead_band), "notes": notes}
    answer(
        shown.as_json,
        lambda: winds.document(case, required) | known_wind.as_dict() | of_dead_bands,
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


def _verdict(known_wind: KnownWind, case: StudyPlan) -> str:
    """Return the verdict on the minimum peak; of a sounding the wind in its time window counts.

    Where the window cuts a wind that is not calm, the verdict says that it has a step there.
    """
    if not isinstance(case.wind, SoundingWind):
        return known_wind.verdict("this wind")
    if condition := cut_condition(case):
        return known_wind.verdict(_CUT.format(case.wind.window)) + condition
    return known_wind.verdict("this part of the sounding")


def _required(
    case: StudyPlan, dead_bands: FloatArray
) -> tuple[RequiredDeflection | None, list[str]]:
    """Return the required deflection by dead band, ``(k,)``, None without a boundary, and notes.

    K = 1 counts the wind with both signs, K < 1 the part with the sign of its peak.
    """
    plant, wind = case.plant.rigid, case.history
    notes = [*linear_notes(float(wind.peak))]
    if np.any(dead_bands < 1.0):
        note_one_sign(case.wind, case, "K < 1")
    try:
        one_sign, two_sided = case.one_sign_history, None if wind.constant_sign else wind
        return required_deflection(plant, one_sign, dead_bands, two_sided=two_sided), notes
    except InputError as error:
        return None, [*notes, f"there is no boundary limit: {error}"]


def _document(dead_bands: FloatArray, required: RequiredDeflection | None) -> list[dict[str, Any]]:
    """Return limit, deflection and reason for each dead band, ``(k,)``, for JSON.

    `required`: required deflections, ``(k,)``; None without any.
    """
    if required is None:
        return []
    names = "dead_band", "limit", "deflection_deg", "governed_by"
    columns = dead_bands, required.limit, np.degrees(np.abs(required.deflection)), required.governs
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return [dict(zip(names, row, strict=True)) for row in rows]


def _curves(plant: Plant, deflection: History, wind: History, title: str) -> "Curves":
    """Return the curves of the response to a deflection [rad], until three times the wind's end.

    `title`: vehicle and wind, in the file of the curves.
    """
    from tvclin.plots import response_curves

    first = min(0.0, float(deflection.onset), float(wind.onset))
    times = np.linspace(first, 3.0 * float(wind.end), 601)
    response = attitude_responses(plant, deflection, wind, times)
    return response_curves(response, "boundary", title, deflection=deflection, wind=wind)
