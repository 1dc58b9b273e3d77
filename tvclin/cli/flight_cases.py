"""Cases that `tvclin fly` flies, from its options, and its answer with any engine."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from tvclin.ascent.nominal_flight import FlightCondition
from tvclin.base.errors import InputError, one_of
from tvclin.base.lines import Table
from tvclin.base.quantities import NOMINAL, survival
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.case.flexible_autopilot import textbook_notes
from tvclin.cli.inputs import chosen
from tvclin.cli.options import ShownCurves
from tvclin.cli.output import print_answer, print_json, say
from tvclin.cli.wind import note_one_sign, wind_words, zero_words
from tvclin.control.laws.law import Law
from tvclin.control.laws.registry import AUTOPILOT, DEAD_BAND, LAWS, design_law
from tvclin.design.gain_designs import specified_autopilot
from tvclin.flights.engine_interface import ReportControl, verdict_time
from tvclin.flights.flown_boundary import ENGINES, flown_boundary
from tvclin.flights.theory_comparison import (
    PEAKS,
    FlightComparison,
    compare_flight,
    linear_boundary,
)
from tvclin.linear.modes import all_modes
from tvclin.linear.plant import DEFAULT_MODEL, Plant
from tvclin.requirement.case_requirement import CaseRequirement, study_requirement
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.linear_vehicle import complete_vehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.wind_angles import linear_notes


@dataclass(frozen=True, eq=False)
class Compared:
    """A flight, compared with the linear theory or the rigid vehicle; deflections in rad.

    `flying`: plan, wind, law and engine, a `Flying`. `reference`: name of the comparison, "linear"
    or "rigid". `boundary`: smallest limits that survive, of flight and comparison; None where
    neither was sought, the first None where that was not. `verdict` stands above the table, `title`
    and `columns` in it, `flight_notes` below it, and `setting_lines`, on vehicle, wind, control and
    assumptions, among the details; `facts` are for JSON alone.
    """

    flying: Any
    flight: FlightComparison
    limit: float
    reference: str
    columns: tuple[str, ...]
    boundary: tuple[float | None, float] | None
    setting_lines: list[str]
    verdict: str
    flight_notes: tuple[str, ...]
    title: str
    facts: dict[str, Any] = field(default_factory=dict)

    def both(self, values: Any) -> dict[str, Any]:
        """Return the values of the flight and of its comparison, by name.

        `values`: the two in this order.
        """
        return dict(zip(("flown", self.reference), values, strict=True))

    def show(self, shown: ShownCurves, more: bool) -> bool:
        """Print the flight, write its files, and return whether it survived.

        `shown`: options of JSON, CSV file and figure. `more`: print details too, `setting_lines`.
        """
        self.write(shown)
        if shown.as_json:
            print_json(self.document())
        else:
            details = partial(say, "\n".join(self.setting_lines))
            print_answer(self.verdict, self.table(), notes=self.notes, more=more, details=details)
        return bool(self.flight.survived)

    def write(self, shown: ShownCurves) -> None:
        """Write the CSV file and the figure of the flight, beside its linear or rigid reference."""
        from tvclin.plots import flight_chart, flight_curves

        title = f"{self.flying.title}, limit {np.degrees(self.limit):.3f} deg, {self.flying.engine}"
        title += zero_words(self.flying.plan)
        shown.write(
            lambda: flight_curves(
                self.flight, self.limit, "fly", title.replace("\n", ", "), self.reference
            ),
            lambda numbers: flight_chart(numbers, title),
        )

    def table(self) -> Table:
        """Return the table of the flight, its comparison and both boundaries."""
        return self.flight.table(self.title, self.columns, self.boundary)

    @cached_property
    def required(self) -> CaseRequirement | None:
        """The required deflection of a study of the plan that is flown."""
        plan = self.flying.study_plan
        return study_requirement(plan, chosen(self.flying.dead_band, plan.dead_band))

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the wind angle, on the flight, and on the required deflection of the study."""
        required = () if self.required is None else (self.required.see_study,)
        angle = linear_notes(float(self.flying.wind.peak))
        # of the flights shown, the first or both, those that leave the range of their model
        beyond = [
            f"the largest values, {name}, are until the attitude reaches {np.degrees(limit):.0f}"
            " deg, before the wind ends"
            for name, limit, ended in zip(
                self.columns, self.flight.ranges, self.flight.ended, strict=False
            )
            if ended
        ]
        return (*angle, *self.flight_notes, *beyond, *required)

    def document(self) -> dict[str, Any]:
        """Return the flight and its comparison with the boundary, for JSON.

        Values of `both` are a pair by name: of the flight ("flown") and of its comparison, whose
        name is `reference`.
        """
        flying = self.flying
        peaks = {name: np.degrees(self.flight.peaks(name)).tolist() for name in PEAKS}
        boundaries = self.boundary and [
            None if boundary is None else float(np.degrees(boundary)) for boundary in self.boundary
        ]
        return {
            "vehicle": flying.plan.vehicle.name,
            "engine": flying.engine,
            "plane": flying.plan.plane,
            "law": flying.law,
            "dead_band": flying.dead_band,
            "wind": {"shape": flying.shape, **flying.wind.as_dict()},
            "limit_deg": np.degrees(self.limit),
            "survived": self.flight.survived,
            "peaks_over_the_wind_deg": {k: self.both(v) for k, v in peaks.items()},
            "ended_in_the_wind": self.both(self.flight.ended),
            "boundary_deg": None if boundaries is None else self.both(boundaries),
            "pressure": self.flying.pressure,
            "required_deflection_deg": self.required
            and float(np.degrees(self.required.known_deflection)),
            "notes": linear_notes(float(self.flying.wind.peak)),
            **self.facts,
        }


def flight_title(flying: "Flying") -> str:
    """Return the title of a flight to be flown: its vehicle, if named, below it wind and law."""
    plan, wind = flying.plan, wind_words(flying.shape, flying.plan)
    line = f"{wind}, {plan.plane}, law {flying.law}"
    return f"{plan.vehicle.name}\n{line}" if plan.vehicle.name else line


_BOUNDARY_TOLERANCE_OVER_TRIM = 5e-4
"""Tolerance of a flown boundary, over the largest trim deflection."""
MAX_LIMIT_OVER_TRIM = 4.0
"""Largest limit tried for a boundary, over the largest trim deflection."""
REPORT = "report"
"""The report's control, which is no feedback of a sampled law."""
_LAWS_WITH_DEAD_BAND = (REPORT, "dead-band")
"""Names of the controls that take a dead band."""
LIMIT_OVER_BOUNDARY = 1.1
"""Limit of a flight without --limit-deg, over its boundary."""
FROZEN_VEHICLE = "vehicle frozen"
"""Of a flight whose mass, forces and speed are constant."""
_MAX_DURATION_OVER_MODE = 1000.0
"""Longest flight over the time of its fastest mode; the solver takes about as many steps."""
_NO_BOUNDARY = (
    "a flight with the nonlinear equations is shown beside the linear boundary, which an"
    " unstable vehicle alone has; --engine linear --law autopilot flies this one"
)
"""Refusal of a vehicle that is stable, of which no deflection is required."""
_MIN_PEAK_RAD = 2.5e-7
"""Peak [rad] at which the solver's tolerance, 1e-9 of it, is the rounding of the equations."""


@dataclass(frozen=True, eq=False)
class Flying:
    """A plan whose wind is one history, the name of that wind, and the name of the law."""

    plan: StudyPlan
    shape: str
    law: str
    dead_band: float | None

    pressure = "nominal"

    @property
    def study_plan(self) -> StudyPlan:
        """The plan of the study, with the model of its required deflection."""
        return self.plan

    @property
    def wind(self) -> History:
        """The wind [rad]; for the report's control, which needs it, the part of one sign."""
        return self.plan.one_sign_history if self.law == REPORT else self.plan.history

    @property
    def unknown_suffix(self) -> str:
        """End of the verdict: why survival is not known in a sounding with gaps; often empty."""
        return f"; {self.plan.unknown_wind}" if self.plan.unknown_wind else ""

    def designed(self, plant: Plant) -> ReportControl | Law:
        """Return the report's control, or the law designed on a plant, with dead band or gains.

        A law is designed for the peak of the wind [rad] and the rate limit. `InputError` for a dead
        band of a law that has none.
        """
        one_of("--law", self.law, [REPORT, *LAWS])
        parameters: dict[str, Any] = {} if self.dead_band is None else {"dead_band": self.dead_band}
        if parameters and self.law not in (REPORT, DEAD_BAND):
            raise InputError(f"--dead-band belongs to the laws {REPORT} and {DEAD_BAND}")
        if self.law == REPORT:
            return ReportControl(**parameters)
        if self.law == AUTOPILOT:
            criteria = self.plan.margin_criteria
            parameters = {AUTOPILOT: specified_autopilot(self.plan, self.wind, criteria=criteria)}
        parameters["rate_limit"] = self.plan.hardware["rate_limit"]
        return design_law(self.law, plant, float(self.wind.peak), **parameters)


@dataclass(frozen=True, eq=False)
class FlightCase(Flying):
    """A flight, its linear boundary, and the minimum over all unstable poles [rad].

    `boundary`: smallest limit with which the control survives in linear theory. `minimum`: smallest
    peak deflection of any control, with the wind known. `limit`: limit of the flight. All in rad.
    `study_model`: model of the study; the linear theory beside the flight is of `DEFAULT_MODEL`.
    """

    engine: str
    control: ReportControl | Law
    condition: FlightCondition | None
    boundary: float
    minimum: float
    limit: float
    study_model: str
    direction: str = ""

    @property
    def study_plan(self) -> StudyPlan:
        """The plan of the study, with the model of its required deflection."""
        return replace(self.plan, model=self.study_model)

    @property
    def vehicle(self) -> Vehicle:
        """The vehicle."""
        return complete_vehicle(self.plan.vehicle, "a flight")

    @property
    def title(self) -> str:
        """The vehicle, and in a second line the wind and the control."""
        band = self.dead_band
        return flight_title(self) + ("" if band is None else f", K = {band:g}")

    @property
    def setting_lines(self) -> list[str]:
        """Lines on the engine of the flight and its assumptions.

        With a `condition` (altitude, specific impulse) the vehicle varies along a gravity turn.
        """
        assumed = f"parameters frozen {NOMINAL}, flat planet at rest, rigid, no actuator"
        if self.condition is not None:
            assumed = (
                "gravity turn, standard atmosphere, constant thrust, mass falling"
                f"\nwith a specific impulse of {self.condition.specific_impulse:g} s, wind about"
                " the vehicle's own\ntime, flat planet at rest, rigid, no actuator"
            )
        flown = f"flown: {ENGINES[self.engine].words}"
        linear = f"linear: model {DEFAULT_MODEL}, parameters frozen {NOMINAL}"
        return [self.title, flown, f"assumed: {assumed}", linear]

    @property
    def pressure(self) -> str:  # type: ignore[override]
        """The dynamic pressure of the flight: the nominal one, or that encountered in the wind."""
        return "nominal" if self.condition is None else "encountered"

    @property
    def conditions(self) -> str:
        """Direction of the wind, dynamic pressure and parameters of the flight, in words."""
        if self.condition is None:
            return f"{NOMINAL}, {FROZEN_VEHICLE}"
        wind = f"in a {self.direction} wind at {self.pressure} dynamic pressure"
        return f"{wind}, vehicle varying along its flight"

    @property
    def options(self) -> dict[str, Any]:
        """Arguments of every flight of the case."""
        return {"engine": self.engine, "plane": self.plan.plane, "condition": self.condition}


def flight_case(
    flying: Flying,
    engine: str,
    condition: FlightCondition | None,
    length: float,
    direction: str = "",
) -> FlightCase:
    """Return the case of a nonlinear flight; its default limit is 1.1 times the boundary.

    `flying`: plan, wind and law. `engine`: name of the engine. `condition`: altitude and specific
    impulse for parameters that vary in flight, None for frozen ones. `length`: its length [s].
    `direction`: of the wind, of parameters that vary.
    """
    study_model = flying.plan.model
    flying = replace(flying, plan=replace(flying.plan, model=""))  # empty: the default model
    plant, wind = flying.plan.plant.rigid, flying.wind
    _check_flight(plant, wind, length)
    if flying.law == REPORT:
        note_one_sign(flying.plan.wind, flying.plan, "the report's control")
    control = flying.designed(plant)
    boundary = linear_boundary(plant, control, wind)
    if boundary == 0.0:  # damping and path keep an almost neutral vehicle stable
        raise InputError(_NO_BOUNDARY)
    limit = flying.plan.nozzle.limit or LIMIT_OVER_BOUNDARY * boundary
    if np.isinf(limit):
        raise InputError("no limit is sufficient with this dead band; give --limit-deg")
    minimum = float(optimum_deflection(plant, wind, float(wind.onset)).peak)
    fields = vars(flying)
    if flying.law in _LAWS_WITH_DEAD_BAND:
        # the dead band of the control, which has a default where the option is not given
        fields = vars(replace(flying, dead_band=getattr(control, "dead_band", None)))
    return FlightCase(
        **fields,
        engine=engine,
        control=control,
        condition=condition,
        boundary=boundary,
        minimum=minimum,
        limit=limit,
        study_model=study_model,
        direction=direction,
    )


def _check_flight(plant: Plant, wind: Any, length: float) -> None:
    """Raise `InputError` for a flight that no solver follows, and for a vehicle without boundary.

    `length`: length of the flight [s]. A flight is watched for some time after its wind before it
    is judged. The fastest mode sets the steps of the solver.
    """
    if float(plant.coefficients.mu_alpha) <= 0.0:
        raise InputError(_NO_BOUNDARY)
    pole = float(plant.coefficients.pole)
    if abs(float(wind.peak)) < _MIN_PEAK_RAD:
        raise InputError(
            f"the peak of the wind must be at least {np.degrees(_MIN_PEAK_RAD):.3g} deg: below, the"
            " flight is lost in the rounding of its equations; got"
            f" {abs(np.degrees(float(wind.peak))):.3g} deg (the boundary is proportional to it)"
        )
    longest = _MAX_DURATION_OVER_MODE / float(np.abs(all_modes(plant).poles).max())
    flown = max(length, verdict_time(wind, pole) - float(wind.onset))
    if flown > longest:
        raise InputError(
            f"a flight must be at most {longest:.4g} s long, {_MAX_DURATION_OVER_MODE:g} times that"
            f" of its fastest mode; got {flown:.4g} s: give a shorter --duration"
        )


def fly_nonlinear(case: FlightCase, boundary: bool, length: float, points: int) -> Compared:
    """Return a flight with its linear theory, and with `boundary` also the flown boundary.

    `length`: length of the flight [s]. `points`: number of its times. A rate limit of the nozzle is
    not flown, as the verdict says. Pairs are of the flight and of the theory; `let_go_s` are the
    times [s] at which the limit is released.
    """
    start, limit = float(case.wind.onset), case.limit
    times = np.linspace(start, start + length, points)
    arguments = {"deflection_limit": limit, "boundary": case.boundary, **case.options}
    flight = compare_flight(case.vehicle, case.control, case.wind, times, **arguments)
    flight = flight.in_unknown_wind() if case.plan.unknown_wind else flight
    ratio_text = f"{limit / case.boundary:.4g} times the linear boundary"
    rate = "" if case.plan.nozzle.rate_limit is None else " and no rate limit"
    return Compared(
        flying=case,
        flight=flight,
        limit=limit,
        reference="linear",
        columns=("flown", "linear"),
        boundary=(_flown_boundary(case) if boundary else None, case.boundary),
        setting_lines=case.setting_lines,
        verdict=(
            f"{survival(flight.survived)} with {np.degrees(limit):.3f} deg{rate} {case.conditions};"
            f" linear theory: {survival(flight.predicted)}{case.unknown_suffix}"
        ),
        flight_notes=tuple(_flight_notes(case, flight)),
        title=f"{case.title}; limit {np.degrees(limit):.3f} deg, {ratio_text}".replace("\n", ": "),
        facts={
            "along_trajectory": case.condition is not None,
            **({"direction": case.direction} if case.direction else {}),
            "linear_model": DEFAULT_MODEL,
            "predicted": flight.predicted,
            "let_go_s": dict(zip(("flown", "linear"), flight.let_go, strict=True)),
            "minimum_deg": np.degrees(case.minimum),
        },
    )


def worst_of(flights: dict[str, Compared]) -> Compared:
    """Return the worst of the flights of a case, by the direction of the wind, with a note.

    A flight that does not survive is worse than others; then a larger flown boundary counts, where
    boundaries were sought, then a larger attitude.
    """

    def order(name: str) -> tuple[bool, float, float]:
        """Return divergence, flown boundary [rad] and peak attitude [rad] in the `name` wind.

        Compared in this order, the larger is worse. The boundary is zero where it is not known.
        """
        flown = flights[name]
        flown_boundary, _ = flown.boundary or (None, None)  # of flights, and of linear theory
        peak_attitude, _ = flown.flight.peaks("attitude")
        return flown.flight.survived is not True, flown_boundary or 0.0, peak_attitude

    worst = max(flights, key=order)
    notes = tuple(
        f"in a {name} wind: {survival(flown.flight.survived)}; the worse of the directions counts"
        for name, flown in flights.items()
        if name != worst
    )
    flown = flights[worst]
    return replace(flown, flight_notes=(*notes, *flown.flight_notes))


def _flight_notes(case: FlightCase, flight: FlightComparison) -> Iterator[str]:
    """Yield notes on unspecified gains, on the model, on a limit below the minimum, on its release.

    The minimum is that of any control.
    """
    if case.law == AUTOPILOT:
        yield from textbook_notes(case.plan)
    if case.study_model != DEFAULT_MODEL:
        yield f"linear theory is of {DEFAULT_MODEL} here, the study of {case.study_model}"
    if case.limit < case.minimum and (flight.survived or flight.predicted):
        yield (
            f"{np.degrees(case.minimum):.3f} deg is the minimum of any control by linear theory;"
            " with less a mode goes on growing, more slowly than this flight shows"
        )
    let_go, _ = flight.let_go  # of the flight, and of the linear theory [s]
    if np.isfinite(let_go):
        yield (
            f"the limit is let go at t = {let_go:.4g} s, as the attitude is back at zero"
            " or beyond; the flight, and what is largest in it, is shown until then"
        )


def _flown_boundary(case: FlightCase) -> float:
    """Return the boundary of the case's control [rad], a magnitude, from flights."""
    chosen: dict[str, Any] = {"law": case.control}
    if isinstance(case.control, ReportControl):
        chosen = {"dead_band": case.control.dead_band}
    result = flown_boundary(
        case.vehicle,
        case.wind,
        frozen=case.condition is None,
        tolerance=_BOUNDARY_TOLERANCE_OVER_TRIM,
        highest=MAX_LIMIT_OVER_TRIM,
        **chosen,
        **case.options,
    )
    return abs(float(result.deflection))
