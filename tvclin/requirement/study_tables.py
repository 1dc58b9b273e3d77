"""A study as tables, its verdict in words, and its exact response with trim and then the limit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import nan
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from tvclin.base.fields import Field, fields_of, rows
from tvclin.base.lines import (
    Line,
    Row,
    Table,
    degrees,
    minimum_limit,
    number,
    quantities,
    significant,
    upper_pole,
)
from tvclin.base.quantities import (
    NO_FORECAST,
    NOMINAL,
    QUANTITIES,
    STATIC_TRIM,
    WIND_KNOWN,
    sufficiency,
)
from tvclin.base.units import written
from tvclin.boundary.open_loop import ROUNDING, Reason
from tvclin.case.case import Case
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.extremes import (
    COMPLETE,
    OVERTURNED,
    OVERTURNED_NOTE,
    RELEASED,
    extremes,
    response_end,
    response_table,
    wind_loads,
)
from tvclin.linear.plant import Plant
from tvclin.linear.response import Responses, attitude_responses
from tvclin.requirement.case_requirement import pulse_of
from tvclin.requirement.study import Study
from tvclin.vehicle.linear_vehicle import AnyVehicle
from tvclin.winds.wind_angles import BEYOND_LINEAR, CROSS, FROZEN

if TYPE_CHECKING:
    from tvclin.linear.extremes import Extremes
    from tvclin.winds.histories import History


LEAST = {"forecast_free": NO_FORECAST, "minimum": WIND_KNOWN}
"""Labels of the lower bounds, below the boundaries of every control."""
LEGEND = (
    f"{NO_FORECAST[0].upper()}{NO_FORECAST[1:]}: {QUANTITIES[NO_FORECAST]}."
    f" {WIND_KNOWN[0].upper()}{WIND_KNOWN[1:]}: {QUANTITIES[WIND_KNOWN]}."
)
AIR = {
    None: "the worst of head and tail wind",
    "head": "encountered in a head wind",
    "tail": "encountered in a tail wind",
    "frozen": "nominal",
}
"""Words for the dynamic pressure, by the sign that counts."""
ACROSS = "encountered in a cross wind"
"""Words for the dynamic pressure in a wind across the path, which has no sign."""
LEFT_WHEN = {"literal": "reached by trim", "report": "reached by B times the wind angle"}
"""Words for the exit of the dead band, by switch."""
_WITHOUT_BETA = ("none (stable)",)
_VERDICT = " (verdict)"


def vehicle(
    study: Study,
    source: str = "unnamed",
    source_values: Mapping[str, tuple[float, str]] | None = None,
) -> Table:
    """Return the numbers of the vehicle, first in the units of its file where these differ.

    `source` is the title of a vehicle without a name, `source_values` the numbers as they stand in
    its file, and their units there, by name.
    """
    rows = [
        (item.title, _in_units(study.vehicle, item, source_values or {}))
        for item in fields_of(study.vehicle)
        if item.value(study.vehicle) is not None
    ]
    planes = "pitch and yaw" if study.judges_both_planes else study.plane
    return quantities(f"{study.vehicle.name or source}, {study.model}, {planes}", rows)


def coefficients(study: Study) -> Table:
    """Return the table of linear coefficients, with the coefficients of a known flight path."""
    damped = ("damping", "pole") if study.coefficients.damping else ()
    path = ("C1", "C2", "b1", "b2", "K1") if "drift-exact" in study.modes else ()
    groups = ("beta", "B", *damped), *((name,) for name in path)
    shown = [row for names in groups for row in rows(study.coefficients, "coefficients", *names)]
    if study.coefficients.mu_alpha <= 0.0:
        shown.insert(0, ("beta", _WITHOUT_BETA))  # sqrt(mu_alpha) is not real
    return quantities(f"Linear coefficients, {study.plane} plane", shown)


def poles(study: Study) -> Table:
    """Return the unstable poles of every model."""
    rows: list[Row] = []
    for model, modes in study.modes.items():
        line: Line = ()
        for k, pole in enumerate(pole for pole in modes.poles if pole.imag >= 0.0):
            line += ((", ",) if k else ()) + upper_pole(f"poles.{model}.{k}", pole)
        rows.append((model, line or ("none",)))
    return quantities("Unstable poles [1/s]", rows)


def boundaries(study: Study) -> Table:
    """Return static trim, the limit at every dead band, lower bounds, and survivable peaks.

    Limits are required deflections at nominal dynamic pressure or, where not trim but B times the
    wind angle leaves the dead band, boundary limits; B is the ratio of trim deflection to angle of
    attack. Rows without a dead band, of both planes or of head and tail winds, follow (`judged`),
    then the lower bounds (`study.needs`). The row of the verdict is marked. The last column, for a
    study with a limit, is the peak that it survives with the model of the verdict.
    """
    names, further = tuple(study.boundaries), _further_rows(study)
    row_label, limits = "K = ", study.nominal_requirements
    if study.switch == "report":
        row_label = "boundary limit, K = "
        limits = {name: np.abs(boundary.deflection) for name, boundary in study.boundaries.items()}
    rows: list[tuple[Line, ...]] = [((STATIC_TRIM,), *_cells(study, "trim", study.trim_deflection))]
    for i, K in enumerate(study.dead_bands):
        mark = _VERDICT if K == study.dead_band and not further and not study.unknown else ""
        sizes = {name: limit[i] for name, limit in limits.items()}
        cells = map(minimum_limit, _cells(study, f"boundary.{i}", sizes))
        rows.append(((row_label, *significant(f"boundary.{i}.K", K), mark), *cells))
    for row in further:
        mark, needs = _VERDICT if row.of_verdict else "", {study.model: row.required}
        rows.append(((row.label + mark,), *_cells(study, row.label.replace(" ", "_"), needs)))
    rows += [((LEAST[key],), *_cells(study, key, needs)) for key, needs in study.needs.items()]
    scope = ""
    head = ("control", *(h for name in names for h in (f"{name} [deg]", "over trim")))
    in_one_plane = not study.judges_both_planes and study.model in study.boundaries
    if study.limit is not None and not study.unknown and in_one_plane:
        peaks = _survived(study, study.limit, [row.survived for row in further])
        bound = abs(study.peak_bound)
        survived = [survivable(f"survived.{k}", peak, bound) for k, peak in enumerate(peaks)]
        head = (*head, "survivable peak [deg]")
        # NaN: the survivable peak of the other direction of the wind is not computed
        others = [row.survived for row in further if not row.of_verdict]
        if np.isnan(others).any() and not study.beyond_linear:
            scope = f"; survivable peak of the {study.direction} wind"
        rows = [(*row, cell) for row, cell in zip(rows, survived, strict=True)]
    peak, tau = float(np.degrees(study.wind.peak)), float(study.wind.duration)
    component = ""
    if study.slanting is not None:
        vector = abs(float(np.degrees(study.slanting.peak)))
        component = f", the part in the {study.plane} plane of a vector of {vector:.4g} deg"
    caption = (
        f"Least deflection limit that survives a {study.shape} wind of {peak:.4g} deg and {tau:g} s"
        f"{study.wind_in_plane.gust_text}{component}; K {NOMINAL}{scope}"
    )
    return Table(caption, head, tuple(rows))


def both_planes(study: Study) -> Table:
    """Return the required deflection of both planes with one limit, and of each plane."""
    assert study.planes is not None
    rows = (
        (("both planes, one stop",), degrees("planes.required", study.planes.deflection)),
        *(
            ((f"{plane} alone",), degrees(f"planes.{plane}", required))
            for plane, required in study.planes.separate.items()
        ),
    )
    caption = f"Required deflection of both planes, K = {study.dead_band:g}, {study.model}"
    return Table(caption, ("what turns the nozzle", "[deg]"), rows)


def heading_line(study: Study) -> Line:
    """Return the direction from which the wind comes, clockwise from the direction of flight."""
    assert study.slanting is not None
    assert study.slanting.heading is not None
    heading = float(np.degrees(study.slanting.heading)) % 360.0
    return number("planes.heading_deg", heading, 1, "deg")


def pitch_omitted_fraction(study: Study) -> Line:
    """Return the fraction [%] of the requirement of both planes that the pitch plane omits."""
    assert study.planes is not None
    return number("planes.missing_percent", 100.0 * study.planes.omitted_fraction("pitch"), 1, "%")


def question(study: Study, case: Case) -> Table:
    """Return the wind, the dead band, the limits and further inputs of a study of a case."""
    wind, nozzle = pulse_of(case), case.nozzle
    rows: list[Row] = [
        ("plane", ("pitch and yaw, one stop" if study.judges_both_planes else study.plane,)),
        ("model of the verdict", (study.model,)),
        ("wind shape", (wind.shape,)),
        ("peak wind angle", _angle_cell("wind.peak_deg", wind.peak)),
        ("wind duration", significant("wind.duration", wind.duration, 6, "s")),
        ("dead band of the verdict, K", significant("question.dead_band", study.dead_band)),
        ("left when K times the limit is", (LEFT_WHEN[study.switch],)),
    ]
    if wind.heading is not None:
        heading = _angle_cell("wind.heading_deg", float(wind.heading) % (2.0 * np.pi))
        rows.insert(4, ("direction of the wind, from the flight", heading))  # after the peak
    if study.encountered or study.sign is not None:
        across = study.direction == CROSS
        rows.append(("dynamic pressure", (ACROSS if across else AIR[study.sign],)))
    gust = (study.slanting or study.wind_in_plane).placed_gust
    if gust is not None:
        rows += [
            ("gust on top: peak", _angle_cell("gust.peak_deg", gust.peak)),
            ("gust begins", significant("gust.begins", gust.onset, 6, "s")),
            ("gust ends", significant("gust.ends", gust.end, 6, "s")),
        ]
    if nozzle.limit is not None:
        rows.append(("deflection limit", degrees("question.limit", nozzle.limit, unit="deg")))
    if nozzle.rate_limit is not None:
        rate = _angle_cell("question.rate_limit", nozzle.rate_limit, "deg/s")
        rows.append(("deflection rate limit", rate))
    return quantities("Wind and question", rows)


class _FurtherRow(NamedTuple):
    """Row below the dead bands: required deflection and survivable peak [rad].

    `of_verdict`: whether the verdict rests on it.
    """

    label: str
    required: float
    survived: float
    of_verdict: bool


def _further_rows(study: Study) -> list[_FurtherRow]:
    """Return the rows below the dead bands: by direction of the wind, or a row of both planes.

    With the switch "report", where rows of dead bands are boundary limits, the first is the
    requirement of the verdict's K. A survivable peak is NaN without a limit, and for a direction of
    the wind that does not set the required deflection.
    """
    survived = abs(study.survivable_peak or np.nan)
    if study.judges_both_planes:
        return [_FurtherRow("both planes", study.required_deflection, survived, of_verdict=True)]
    if study.model not in study.boundaries:  # no boundary limit of this model
        return []
    rows = []
    nominal = study.nominal_deflection
    if study.switch == "report" and nominal:
        # at nominal pressure the requirement is in proportion to the peak of the wind
        peak = abs(study.judged_peak) * (study.limit or np.nan) / nominal
        label = f"required, K = {study.dead_band:g}"
        rows.append(_FurtherRow(label, nominal, peak, of_verdict=study.at_nominal_pressure))
    for direction, required in study.encountered.items():
        governs = study.direction == direction
        peak = survived if governs else np.nan
        rows.append(_FurtherRow(f"{direction} wind", required, peak, of_verdict=governs))
    return rows


def requirement(study: Study) -> Line:
    """Return the required deflection with its basis, and the peak that the limit survives.

    The basis is the model, the dead band with its exit unless it is on trim ("literal", the
    default), the dynamic pressure, and what governs. The peak, where a limit was given, is a lower
    bound (`survives_bound`) at 30 deg; `peak_of` names it if it is of a vector.
    """
    switch = "" if study.switch == "literal" else f", left when {LEFT_WHEN[study.switch]}"
    air = f", dynamic pressure {AIR[study.sign]}" if study.sign and study.direction != CROSS else ""
    if study.at_nominal_pressure and study.sign != FROZEN:
        air = f", {NOMINAL}"
    line: Line = ("Required deflection: ", sufficiency(None))
    if study.unknown:
        nominal = minimum_limit(degrees("verdict.nominal", study.nominal_deflection, unit="deg"))
        line = (*line, f"; {NOMINAL} ", *nominal)
    elif not study.beyond_linear:
        required = minimum_limit(degrees("verdict.required", study.required_deflection, unit="deg"))
        basis = f" (model {study.model}, dead band {study.dead_band:g}{switch}{air})"
        reason = "none is needed" if study.governs == Reason.NOTHING else f"set by {study.governs}"
        if study.judges_both_planes:
            reason = f"of both planes, {study.governs}"
        line = ("Required deflection: ", *required, f"{basis}, {reason}")
    if study.survivable_peak is None:
        insufficient = study.limit is not None and study.sufficient is False
        return (*line, f"; the limit is too small {NOMINAL} too") if insufficient else line
    survived = degrees("verdict.survived", abs(study.survivable_peak), unit="deg")
    of = f", {study.peak_of}" if study.peak_of else ""
    bound = f" at least{of}; {BEYOND_LINEAR}" if study.survives_bound else of
    return (*line, "; survivable peak ", *survived, bound)


def survivable(name: str, peak: float, bound: float) -> Line:
    """Return the cell of a survivable peak [rad] in degrees, marked at its largest known value.

    `name`: name of the number. `bound`: peak [rad] up to which requirements are known.
    """
    if peak >= bound * (1.0 - ROUNDING):
        return ("≥ ", *degrees(name, bound))
    return degrees(name, peak)


def _in_units(
    vehicle: AnyVehicle, item: Field, source_values: Mapping[str, tuple[float, str]]
) -> Line:
    """Return the cell of a number of a vehicle in the unit of its file.

    `item`: field of the number; the value in the unit of tables follows in brackets where that
    differs. `source_values`: value and unit in the file, by key; "mass" may stand for the weight.
    """
    key, name = f"vehicle.{item.name}", item.name
    shown = significant(key, item.value(vehicle), 6, item.unit)
    source_key = "mass" if name == "weight" and "mass" in source_values else name
    value, unit = source_values.get(source_key, (0.0, ""))
    if not unit or unit == written(item.suffix):
        return shown
    return (*significant(f"{key}.own", value, 6, unit), " (", *shown, ")")


def _cells(study: Study, key: str, deflections: float | Mapping[str, float]) -> list[Line]:
    """Return the cells of a deflection for each model: in degrees, and normalised by trim.

    `key`: prefix of their names. `deflections`: [rad], of each model, or of all. NaN where static
    trim, by which they are normalised, is zero.
    """
    cells: list[Line] = []
    trim = study.trim_deflection
    for name in study.boundaries:
        angle = deflections.get(name, nan) if isinstance(deflections, Mapping) else deflections
        angle, ratio = (angle, angle / trim) if trim else (nan, nan)
        cells += [degrees(f"{key}.{name}", angle), number(f"{key}.{name}.part", ratio)]
    return cells


def _survived(study: Study, limit: float, judged: list[float]) -> list[float]:
    """Return the survivable peaks [rad] of a limit [rad], one for each row of the boundaries.

    Requirements of linear theory are in proportion to the wind, so that a limit survives the peak
    times limit over requirement: for static trim, the dead bands, and the lower bounds at the end.
    `judged`: peaks [rad] of the rows between them, which are not in proportion. For a
    requirement of zero the peak is infinite, for a bound that `study.needs` lacks NaN.
    """
    by_dead_band = study.nominal_requirements[study.model]
    bounds = [needs.get(study.model, np.nan) for needs in study.needs.values()]
    peak = abs(float(study.history.peak))
    with np.errstate(divide="ignore"):
        above, below = (
            [float(peak * limit / np.float64(required)) for required in column]
            for column in ((study.trim_deflection, *by_dead_band), bounds)
        )
    return [*above, *judged, *below]


def _angle_cell(name: str, angle: Any, unit: str = "deg") -> Line:
    """Return the cell of an angle [rad] or a rate [rad/s] in degrees, without padding zeros.

    `name`: name of the number. `unit`: unit in the cell.
    """
    return significant(name, np.degrees(angle), unit=unit)


_MAX_END_OVER_DURATION = 2.0
"""Longest time of a response, in durations of the wind."""
_POINTS = 401
"""Number of times of a response."""
_LIMIT_OVER_REQUIREMENT = 1.1
"""Limit of the response over the required deflection, where the study has no limit."""
_END_NOTES = {
    RELEASED: "It ends where the attitude is back at zero: there an autopilot lets go of the"
    " limit.",
    OVERTURNED: "It ends where the attitude error exceeds 90 degrees.",
    COMPLETE: "The attitude does not come back to zero in this time.",
}
"""Reason of the end of a response, in a sentence."""


@dataclass(frozen=True, eq=False)
class StudyResponse:
    """Response to the wind of a study: trim up to the dead band, then the limit.

    `limit`: deflection limit [rad]. `end`: time [s] up to which the response is shown; `why`:
    reason why no further, as `response_end` gives it.
    """

    study: Study
    plant: Plant
    deflection: History
    limit: float
    end: float
    why: str

    @property
    def extremes(self) -> Extremes:
        """Extremes of the attitude [rad] up to the time `end` [s] of the response."""
        return extremes(self.plant, self.deflection, self.study.history, self.end)

    @property
    def response(self) -> Responses:
        """Response at 401 times from the begin of the wind to the time `end` [s]."""
        times = np.linspace(0.0, self.end, _POINTS)
        return attitude_responses(self.plant, self.deflection, self.study.history, times)

    @property
    def limit_words(self) -> str:
        """Origin of the limit: the study, or a multiple of the required deflection."""
        if self.study.limit is not None:
            return "the limit in question"
        return f"{_LIMIT_OVER_REQUIREMENT:g} times the required deflection"

    @property
    def limit_line(self) -> Line:
        """Line with the deflection limit [deg] of the response."""
        return degrees("response.limit", self.limit, unit="deg")

    @property
    def note(self) -> str:
        """Reason why the shown response of the attitude ends, in sentences.

        A limit that turns the vehicle over when held, but is sufficient, is explained.
        """
        # attitude errors with the wind and against it
        largest = self.extremes
        if largest.with_wind is None and largest.against_wind is None:  # no attitude error
            return "Trim stays within the limit, and the attitude at zero."
        sufficient = self.study.limit is None or self.study.sufficient
        note = f" {OVERTURNED_NOTE}" if self.why == OVERTURNED and sufficient else ""
        return f"{_END_NOTES[self.why]}{note}"

    @property
    def table(self) -> Table:
        """Table of largest and last attitudes, with loads where the response covers the wind."""
        wind, loads = self.study.history, None
        if self.end >= wind.end:
            loads = wind_loads(self.plant, self.deflection, wind)
        return response_table("Largest and last values", self.extremes, loads)


def study_response(study: Study) -> StudyResponse | None:
    """Return the response of a study with its limit, by default 1.1 times the required deflection.

    None where that is zero or infinite.
    """
    required = abs(float(study.requirement.deflection))
    limit = study.limit if study.limit is not None else _LIMIT_OVER_REQUIREMENT * required
    if not limit or np.isinf(limit):
        return None
    plant, wind = Plant(study.coefficients, study.model), study.history
    trim_sign = -float(np.sign(study.coefficients.B * wind.peak)) or 1.0  # any without trim
    deflection = trim_then_hold(plant, wind, trim_sign * limit, study.dead_band, study.switch)
    shown = response_end(plant, deflection, wind, _MAX_END_OVER_DURATION * float(wind.end))
    return StudyResponse(
        study=study, plant=plant, deflection=deflection, limit=limit, end=shown.time, why=shown.why
    )
