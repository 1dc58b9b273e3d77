"""Results of a study plan, computed before anything is written.

The engine of a result is imported where the plan requests that result.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import cache, partial
from hashlib import sha256
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from tvclin.base.errors import InputError
from tvclin.base.package_warnings import pass_warnings
from tvclin.requirement.case_requirement import survived_size
from tvclin.requirement.study import Study
from tvclin.studyfile.study_plan import StudyPlan

if TYPE_CHECKING:
    from tvclin.boundary.limit_over_load import LoadTradeOff
    from tvclin.boundary.limit_over_rate import RateTradeOff
    from tvclin.case.flexible_autopilot import FlexibleAnswer
    from tvclin.case.turbulence import LoopInTurbulence, TurbulenceRequest
    from tvclin.control.autopilot.autopilot import Autopilot
    from tvclin.control.autopilot.sweep import Sweep
    from tvclin.control.comparison import TrimComparison
    from tvclin.control.margins.bands import BandMargins
    from tvclin.control.margins.criteria import Criteria
    from tvclin.control.margins.margins import Margins
    from tvclin.design.standard_trials import LawsRequest, LawTrial
    from tvclin.ensembles.availability.availability_record import Availability
    from tvclin.ensembles.dispersed_study import DispersedStudy
    from tvclin.ensembles.dispersions import Dispersions
    from tvclin.flights.closed_loop.flown_margins import FlownMargins
    from tvclin.flights.closed_loop.survival_limit import ClosedLoopBoundary
    from tvclin.linear.flexible import AnyPlant
    from tvclin.nozzle.data_sheet import FlightDuty
    from tvclin.requirement.autopilot_requirement import AutopilotRequirement
    from tvclin.requirement.flight.flight_turbulence import FlightTurbulence
    from tvclin.requirement.flight.request import SizingRequest
    from tvclin.requirement.flight.sizing import Sizing
    from tvclin.requirement.flight.total import DeflectionTotal
    from tvclin.studyfile.flight_loop import FlightLoop, FlightsOfLoop

Progress = Callable[[float, float], None]
"""Progress of a result: called with the steps done and the steps in total."""
Loop: TypeAlias = "Callable[[], tuple[Any, Autopilot]]"
"""Function that returns the plant that flies and its autopilot."""
Flying: TypeAlias = "FlexibleAnswer | TrimComparison"
"""Results with a plant and an autopilot."""
_UNSEALED_IF_NONE = (
    *("availability", "gust_at", "sign", "gust_speed", "data", "duty"),
    *("acceleration_limit", "travel_limit", "torque_limit", "power_limit", "load", "turbulence"),
    *("schedule", "scheduled_design"),
)
"""Inputs that a seal omits where they are None, so that seals of older studies are unchanged."""
MOST_CASES = 20_000
"""Largest number of dispersed cases of a page; a campaign computes more."""
_FLOWN_SIZE_TOLERANCE = 1e-5
"""Tolerance of the logarithm of the largest factor on the wind that the autopilot survives: flights
give its requirement to 1/4096 of a step of their scan, 5e-6 of it at most."""
_MAX_SAMPLES = 100_000
"""Largest number of samples of a wind of flown margins: some thousand flights through it."""


@dataclass(frozen=True, eq=False)
class HeadWind:
    """Answers at a constant dynamic pressure, that at the peak of a head wind.

    `stop`, `rates`, `loads` and `turbulence` have the meaning of those fields of `Findings`; None
    where not computed.
    """

    stop: ClosedLoopBoundary | None
    rates: RateTradeOff | None
    loads: LoadTradeOff | None = None
    turbulence: LoopInTurbulence | None = None


@dataclass(frozen=True, eq=False)
class Findings:
    """A plan and its results; None, or empty, where the plan does not request a result.

    `trials` are the laws, each in each wind; `comparison` is the autopilot in the wind, with its
    margins; `flexible` the autopilot and margins of a flexible vehicle. `stop` is the minimum limit
    with which the autopilot, flown with it as a stop, survives the wind, `flown` the margins with
    the limit in that wind. `flight` is the sizing of the whole flight, and its worst total;
    `flight_turbulence` the autopilot in turbulence along it, or why that is not known;
    `duty` the nozzle duty of a law along it. `availability` is the fraction of the days of an
    archive that fly, `rates` the trade-off of limit and rate limit in the wind, `loads` that of
    limit and load; `turbulence` the autopilot in the wind and turbulence. `head` has `stop`,
    `rates`, `loads` and `turbulence` in a head wind, where that sets the requirement. `sweep`:
    margins of an autopilot that varies over the flight; `use`: deflection that it uses beside the
    required one, and its flights. `reasons` says why a result is missing, by the name of its field;
    `warnings` are those of the computation.
    """

    plan: StudyPlan
    study: Study
    trials: tuple[LawTrial, ...]
    comparison: TrimComparison | None
    flexible: FlexibleAnswer | None
    stop: ClosedLoopBoundary | None
    flown: FlownMargins | None
    dispersed: DispersedStudy | None
    flight: tuple[Sizing, DeflectionTotal] | None
    flight_turbulence: FlightTurbulence | str | None
    duty: FlightDuty | None
    availability: Availability | None
    rates: RateTradeOff | None
    loads: LoadTradeOff | None
    turbulence: LoopInTurbulence | None
    head: HeadWind | None
    reasons: dict[str, str]
    warnings: tuple[str, ...]
    sweep: Sweep | None = None
    flights: FlightsOfLoop | None = None

    @property
    def criteria(self) -> Criteria:
        """Criteria of the margins."""
        return self.plan.margin_criteria

    @property
    def margins(self) -> Margins | BandMargins | None:
        """The margins that are judged: those by band of a flexible vehicle.

        Of a rigid one they are of the autopilot that `comparison` compares with trim; None where
        the study has no autopilot.
        """
        if self.flexible is not None:
            return self.flexible.bands
        return None if self.comparison is None else self.comparison.margins

    @property
    def autopilot_requirement(self) -> AutopilotRequirement | None:
        """Minimum limits with which the autopilot survives the wind; None where it is not flown.

        `stop` is at nominal dynamic pressure, `head.stop` at the pressure at a head wind's peak.
        """
        from tvclin.requirement.autopilot_requirement import AutopilotRequirement, counts_head

        if self.stop is None:
            return None
        in_head_wind = None if self.head is None else self.head.stop
        counts, ratio = counts_head(self.study), self.study.plane_ratio
        return AutopilotRequirement(self.stop, in_head_wind, head_counts=counts, plane_ratio=ratio)

    @property
    def autopilot_survives(self) -> float:
        """Largest factor on the wind that the autopilot survives, flown with the deflection limit.

        At nominal dynamic pressure a flight scales with its wind, so that the factor is the limit
        over the autopilot requirement (`stop`) [rad]; a larger head wind raises the pressure too,
        and the factor is searched for. NaN where it is not flown.
        """
        study, stop = self.study, self.stop
        limit = study.limit
        if stop is None or limit is None:
            return np.nan
        limit /= study.plane_ratio  # from the limit of both planes to that of the study's plane
        in_head_wind = None if self.head is None else self.head.stop
        required = abs(float((in_head_wind or stop).deflection))
        if in_head_wind is None or not np.isfinite(required):
            return limit / required if required else np.inf
        loop = self.flexible or self.comparison  # either has the autopilot
        assert loop is not None

        from tvclin.requirement.autopilot_requirement import at_peak_pressure, autopilot_boundary

        def requirement(size: float) -> float:
            """Return the autopilot requirement [rad] in `size` times the head wind.

            The plan's own wind is flown, at the dynamic pressure at the peak of `size` times it; at
            constant pressure the larger wind requires `size` times its limit. `plane_ratio` [-]:
            limit of both planes over the plane's. Infinite where the pressure cannot be computed.
            """
            with suppress(InputError):
                denser = at_peak_pressure(self.plan, study, size)
                flown = autopilot_boundary(denser, denser.plant, loop.autopilot, study.plane_ratio)
                return size * abs(float(flown.deflection))
            return np.inf

        return survived_size(limit, required, requirement, tolerance=_FLOWN_SIZE_TOLERANCE)

    @property
    def seal(self) -> str:
        """SHA-256 of the inputs, in SI units and in one order."""
        inputs = asdict(self.plan, dict_factory=_sealed)
        del inputs["document"]  # no number depends on it
        return sha256(json.dumps(inputs, sort_keys=True, default=_plain).encode()).hexdigest()


def _sealed(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return the inputs of a record that its seal covers, by name.

    Inputs that older studies had not are omitted where they are None, so that old seals stay.
    `pairs`: names and values of all its inputs.
    """
    pairs = [pair for pair in pairs if pair[0] != "numbers_from"]  # no number depends on it
    return {key: value for key, value in pairs if value is not None or key not in _UNSEALED_IF_NONE}


def _plain(value: Any) -> Any:
    """Return a value, an array or history, as JSON lists.

    Complex numbers are two lists, of real and of imaginary parts; dates (kind "M") are text.
    """
    array = np.asarray(value)
    if np.iscomplexobj(array):
        return [array.real.tolist(), array.imag.tolist()]
    if array.dtype.kind == "M":
        return array.astype(str).tolist()
    return array.tolist()


def find(
    plan: StudyPlan,
    progress: Callable[[float, float], None] | None = None,
    *,
    omitted: tuple[str, ...] = (),
) -> Findings:
    """Return all results that a plan requests, but for those `omitted`, by field of `Findings`.

    `progress` is called with results done and in total.

    A result that is not defined for this vehicle, such as margins of laws for a stable vehicle,
    has its reason in place of an answer. `InputError` for a wind or vehicle that allows no study,
    for gains that exclude or lack each other, and for turbulence of an altitude that is not known.
    """
    if plan.design is not None and plan.design.schedule is None:
        plan.design.check_gains()
    if plan.turbulence is not None and plan.sizing is None:
        _ = plan.turbulence.at()  # refuses an intensity over altitude without an altitude
    messages: list[str] = []
    with pass_warnings(messages.append):
        study = plan.study()
        reasons: dict[str, str] = {}
        requests = {k: request for k, request in _requests(plan).items() if k not in omitted}

        def result(name: str, compute: Callable[[Any, Progress], Any]) -> Any:
            """Return the result of a field of `Findings`, by its name; None if not in `requests`.

            `compute`: function from the request of this field and a progress to the result; of its
            `InputError` the message is kept in `reasons`, and the result is None.
            """
            if name not in requests:
                return None

            def report(done: float, total: float) -> None:
                """Report the steps of this result that are done, of a total, as results done."""
                if progress is not None:
                    progress(list(requests).index(name) + done / total, len(requests))

            try:
                return compute(requests[name], report)
            except InputError as error:
                reasons[name] = str(error)
                return None
            finally:
                report(1, 1)

        loop = cache(partial(_loop, plan))  # gains for the smallest nozzle take a search
        trials = result("trials", partial(_trials, plan, study, loop)) or ()
        comparison = result("comparison", lambda *_: _comparison(plan, loop))
        flexible = result("flexible", lambda *_: _flexible(plan, study, loop))
        flying = flexible or comparison  # the autopilot with its plant, of flights with a limit
        flight = result("flight", partial(_flight, plan))  # sizing, worst total, and turbulence
        return Findings(
            plan=plan,
            study=study,
            trials=trials,
            comparison=comparison,
            flexible=flexible,
            stop=flying and result("stop", lambda *_: _nominal_boundary(plan, study, flying)),
            flown=flying and result("flown", lambda limit, _: _flown(plan, study, flying, limit)),
            dispersed=result("dispersed", lambda request, _: _dispersed(plan, study, request)),
            flight=flight and flight[:2],
            flight_turbulence=flight and flight[2],
            duty=result("duty", partial(_duty, plan)),
            availability=result(
                "availability", lambda request, progress: request.availability(plan, progress)
            ),
            rates=result("rates", lambda limit, _: _rates(plan, study, limit)),
            loads=result(
                "loads", lambda request, _: request.trade_off(plan, 1.0 / study.plane_ratio)
            ),
            turbulence=result(
                "turbulence", lambda request, _: _turbulence(plan, study, loop, request)
            ),
            head=result("head", lambda limit, _: _in_a_head_wind(plan, study, flying, loop, limit)),
            sweep=result("sweep", lambda *_: _flight_loop(plan).sweep()),
            flights=flight
            and result(
                "flights",
                lambda _, progress: _flight_loop(plan).use(flight[0], progress=progress),
            ),
            reasons=reasons,
            warnings=tuple(messages),
        )


def _requests(plan: StudyPlan) -> dict[str, Any]:
    """Return the requests of a plan, each an input of its result, by field of `Findings`.

    A result that the plan does not request is left out. Results of the autopilot need its design,
    or criteria for its margins. Where a result needs the deflection limit [rad], the limit stands
    for the request: `find` looks only whether there is a value.
    """
    loop = plan.design or plan.criteria  # not None where the autopilot is judged
    loop_over_flight = plan.sizing and (plan.sizing.scheduled_design or plan.design)
    requests = {  # None where one of several inputs, joined by "and", is None
        "trials": plan.laws,
        "comparison": loop,
        "flexible": plan.vehicle.structure and loop,
        "stop": loop and plan.nozzle.limit,
        "flown": loop and plan.nozzle.limit,
        "dispersed": plan.dispersions,
        "flight": plan.sizing,
        "duty": plan.sizing if plan.sizing and plan.sizing.duty_law else None,
        "availability": plan.availability,
        "rates": plan.nozzle.rate_limit and plan.nozzle.limit,
        "loads": plan.load,
        "turbulence": plan.turbulence,
        # results at the pressure of a head wind, of which `HeadWind` has four
        "head": plan.nozzle.limit
        if loop or plan.nozzle.rate_limit or plan.load is not None or plan.turbulence is not None
        else None,
        "sweep": loop_over_flight,
        "flights": loop_over_flight and plan.nozzle.limit,
    }
    return {name: request for name, request in requests.items() if request is not None}


def _trials(
    plan: StudyPlan, study: Study, loop: Loop, request: LawsRequest, progress: Progress
) -> tuple[LawTrial, ...]:
    """Return the trials of the requested laws in the standard winds, a trial for each law and wind.

    `loop`: function that returns plant and autopilot. `request`: names of laws and winds, sample
    rate, and number of sudden ends of each wind (`cuts`), with which it is flown too.
    `progress`: called with trials done and in total. The laws are compared with boundaries, which
    have no actuator and no delay: a rigid vehicle flies without them too, a vehicle with a
    structure with both and with the filters of its plan.
    """
    from tvclin.design.standard_trials import law_trials, standard_laws, standard_winds
    from tvclin.linear.flexible import plant_of

    plant = plant_of(plan.vehicle, plan.law_model, plan.plane)
    nozzle = plan.hardware | {"sample_rate": request.sample_rate}
    _, autopilot = (None, None) if plan.design is None else loop()
    laws = standard_laws(plant.rigid, study.wind.peak, autopilot, nozzle["rate_limit"])
    winds = standard_winds(study.wind.peak, study.wind.duration)
    if plan.vehicle.structure is None:
        nozzle |= {"actuator": None, "delay": 0.0}
    else:
        from tvclin.case.flexible_autopilot import with_filters

        laws = {name: with_filters(law, plan.autopilot_design) for name, law in laws.items()}
    return law_trials(
        plant,
        {name: laws[name] for name in request.names},
        {name: winds[name] for name in request.winds},
        loads=False,
        cuts=request.cuts,
        progress=progress,
        **nozzle,
    )


def _comparison(plan: StudyPlan, loop: Loop) -> TrimComparison:
    """Return the autopilot of a loop in the wind of a plan, compared with trim and bounds."""
    from tvclin.control.comparison import compare_with_trim

    return compare_with_trim(*loop(), plan.history)


def _flexible(plan: StudyPlan, study: Study, loop: Loop) -> FlexibleAnswer:
    """Return margins, boundaries and flight of the autopilot with the flexible vehicle of a plan.

    `study`: the study of the plan. `loop`: function that returns plant and autopilot.
    """
    from tvclin.case.flexible_autopilot import flexible_answer

    (plant, autopilot), criteria = loop(), plan.margin_criteria
    # share of this plane in a limit of both
    limit = None if plan.nozzle.limit is None else plan.nozzle.limit / study.plane_ratio
    return flexible_answer(plant, autopilot, criteria, plan.history, limit, **plan.hardware)


def _flown(plan: StudyPlan, study: Study, loop: Flying, limit: float) -> FlownMargins:
    """Return the margins of a flight through the wind of a study with a deflection limit [rad].

    `plan`: plan of the study. `loop`: result with the plant that flies and its autopilot.
    `InputError` for a wind of more than `_MAX_SAMPLES` samples.
    """
    from tvclin.control.laws.autopilot_law import SaturatedLaw
    from tvclin.flights.closed_loop.flown_margins import flown_margins

    duration = float(plan.history.end - plan.history.onset)  # of the wind [s]
    samples = duration * plan.hardware["sample_rate"]
    if samples > _MAX_SAMPLES:
        raise InputError(
            f"flown margins take winds of at most {_MAX_SAMPLES} samples, this one has"
            f" {samples:.0f}: shorten it"
        )
    law, limit = SaturatedLaw.of(loop.autopilot), limit / study.plane_ratio  # of this plane
    return flown_margins(loop.plant, law, plan.history, limit=limit, **plan.hardware)


def _nominal_boundary(plan: StudyPlan, study: Study, loop: Flying) -> ClosedLoopBoundary:
    """Return the autopilot requirement at nominal dynamic pressure, as a boundary of flights.

    It is the smallest deflection limit with which the autopilot survives the wind. `study` has
    `plane_ratio`, the limit of both planes over the share of the plane that flies. `loop`: result
    with the plant that flies and its autopilot; of a flexible vehicle it has the boundary already.
    """
    from tvclin.case.flexible_autopilot import FlexibleAnswer
    from tvclin.requirement.autopilot_requirement import autopilot_boundary

    if isinstance(loop, FlexibleAnswer):
        flexible, _ = loop.boundaries  # the second is that of the rigid vehicle
        return flexible
    return autopilot_boundary(plan, loop.plant, loop.autopilot, study.plane_ratio)


def _in_a_head_wind(
    plan: StudyPlan, study: Study, flying: Flying | None, loop: Loop, limit: float
) -> HeadWind | None:
    """Return answers at the pressure of a head wind; None where that sets no requirement.

    The dynamic pressure is that at the peak of the wind, held throughout: an upper bound. An answer
    that is not defined at that pressure is None.

    `plan`, `study`: the study plan, and its study. `flying`: result with plant and autopilot, None
    without an autopilot. `loop`: function that returns both. `limit`: deflection limit [rad].
    """
    from tvclin.requirement.autopilot_requirement import at_largest_pressure, autopilot_boundary

    if not study.ratio_to_nominal > 1.0:  # NaN in a wind beyond linear aerodynamics
        return None
    stop = rates = loads = turbulence = None
    denser, _counts = at_largest_pressure(plan, study)
    if denser is None:  # that pressure is not known
        return HeadWind(stop, rates)
    if plan.load is not None:
        # the slope N [N/rad] goes with the dynamic pressure; a vehicle of coefficients has none
        higher, nominal = (getattr(x.vehicle, "normal_force_slope", 1.0) for x in (denser, plan))
        denser = replace(denser, load=plan.load.at_pressure(float(higher / nominal)))
    if flying is not None:
        with suppress(InputError):
            ratio = study.plane_ratio
            stop = autopilot_boundary(denser, denser.plant, flying.autopilot, ratio)
    with suppress(InputError):
        rates = _rates(denser, study, limit) if plan.nozzle.rate_limit else None
        if denser.load is not None:
            fraction = 1.0 / study.plane_ratio  # share of the limit that this plane has
            loads = denser.load.trade_off(denser, fraction, only_bound=True)  # at the load limit
    if plan.turbulence is not None:
        with suppress(InputError):
            plant, (_, autopilot) = denser.plant, loop()  # flown with the plant at this pressure
            turbulence = _turbulence(denser, study, lambda: (plant, autopilot), plan.turbulence)
    return HeadWind(stop=stop, rates=rates, loads=loads, turbulence=turbulence)


def _loop(plan: StudyPlan) -> tuple[AnyPlant, Autopilot]:
    """Return the plant of a plan and its autopilot, whose optimised gains satisfy the criteria.

    Optimised gains have the minimum deflection in the plan's wind; others do not depend on it.
    """
    from tvclin.design.gain_designs import specified_autopilot

    return plan.plant, specified_autopilot(plan, plan.history, criteria=plan.margin_criteria)


def _turbulence(
    plan: StudyPlan, study: Study, loop: Loop, request: TurbulenceRequest
) -> LoopInTurbulence:
    """Return the autopilot in the wind of a study and in turbulence, in one plane.

    `plan`: plan of the study. `loop`: function that returns plant and autopilot. `request`: the
    turbulence, and how many standard deviations count. `InputError` where both planes are judged.
    """
    from tvclin.case.turbulence import LoopInTurbulence

    if study.judges_both_planes:
        raise InputError("turbulence is answered in one plane; leave out the limit of both planes")
    altitude, time = None, getattr(plan.vehicle, "time", None)  # [m], [s]
    if request.needs_altitude and time is not None and plan.sizing is not None:
        schedule = plan.sizing.schedule
        if schedule.altitude is not None:
            altitude = float(np.interp(float(np.asarray(time)), schedule.times, schedule.height))
    plant, autopilot = loop()
    return LoopInTurbulence.of(
        request,
        plan.vehicle,
        plant,
        autopilot,
        plan.history,
        limit=plan.nozzle.limit,
        altitude=altitude,
        load=plan.load,
    )


def _flight(
    plan: StudyPlan, request: SizingRequest, progress: Progress
) -> tuple[Sizing, DeflectionTotal, FlightTurbulence | str | None]:
    """Return the sizing of the flight of a plan, its worst total, and its turbulence.

    The turbulence is a text with the reason if it is not known, and None without turbulence.
    `request`: flight, winds and dead bands. `progress`: called with steps done and in total. The
    total is that at the flight time at which it is largest, with turbulence as one of its parts.
    """
    sizing = request.sizing(plan, progress)
    turbulence = request.turbulence(plan, plan.turbulence)
    return sizing, request.total(plan, sizing, turbulence), turbulence


def _flight_loop(plan: StudyPlan) -> FlightLoop:
    """Return the autopilot of a plan along its flight."""
    from tvclin.studyfile.flight_loop import FlightLoop

    return FlightLoop.of(plan)


def _duty(plan: StudyPlan, request: SizingRequest, progress: Progress) -> FlightDuty:
    """Return the duty of the nozzle over the flight of a plan, with the law of a sizing `request`.

    `progress`: called with steps done and in total.
    """
    from tvclin.nozzle.duty_over_flight import flight_duty

    law = str(request.duty_law)
    return flight_duty(plan, request, law, turbulence=plan.turbulence, progress=progress)


def _rates(plan: StudyPlan, study: Study, limit: float) -> RateTradeOff:
    """Return the trade-off of deflection limit and rate limit in the wind of a study.

    `plan`: plan of the study, with its plant and rate limit [rad/s]. `limit`: deflection limit
    [rad].
    """
    from tvclin.boundary.limit_over_rate import rate_trade_off

    limit /= study.plane_ratio  # from the limit of both planes to that of the study's plane
    rate = plan.nozzle.rate_limit
    forecast = plan.dead_band < 1.0  # a dead band K = 1 needs no forecast of the wind
    plant, wind = plan.plant.rigid, study.history
    return rate_trade_off(plant, wind, limit=limit, rate_limit=rate, forecast=forecast)


def _dispersed(plan: StudyPlan, study: Study, request: Dispersions) -> DispersedStudy:
    """Return the dispersed study of a plan: `study` with the dispersions of `request`."""
    from tvclin.ensembles.dispersed_study import disperse_study

    return disperse_study(
        study,
        request,
        cases=min(plan.cases, MOST_CASES),
        seed=plan.seed,
        probability=plan.probability,
        confidence=plan.confidence,
        method=plan.method,
    )
