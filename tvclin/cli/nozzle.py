"""`tvclin nozzle`: limits over rate or load in a wind, and the duty of the nozzle over a flight."""

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, one_of
from tvclin.base.fields import document
from tvclin.base.lines import Table, listed
from tvclin.base.quantities import FROZEN_ALONG, NOMINAL, REQUIRED, REQUIRED_RATE, sufficiency
from tvclin.boundary.limit_over_load import LoadTradeOff, load_trade_off
from tvclin.boundary.limit_over_rate import RateTradeOff, rate_trade_off, required_rate_table
from tvclin.case.flexible_autopilot import textbook_notes
from tvclin.case.load import FlownLoad
from tvclin.cli.ascent import PlaneOptions, case_over_flight
from tvclin.cli.fly_autopilot import limited_law
from tvclin.cli.inputs import case_of, note_nominal_pressure, note_omissions, only_with
from tvclin.cli.margins import print_autopilot
from tvclin.cli.options import (
    BOTH_LIMITS,
    DESIGN,
    GROUP,
    MODEL,
    SIZING,
    SOURCE_HELP,
    STUDY,
    At,
    FlownLaw,
    GainOptions,
    More,
    Options,
    ShownCurves,
    option,
    switch,
    to_draw,
    to_write,
)
from tvclin.cli.output import answer, bar, print_answer, print_tables, waiting
from tvclin.cli.wind import FlightOptions, WindOptions, cut_condition, with_gust_for
from tvclin.control.laws.registry import AUTOPILOT, LAWS
from tvclin.design.gain_designs import specified_autopilot
from tvclin.nozzle.data_sheet import FlightDuty
from tvclin.nozzle.duty_over_flight import FlownDuty, flight_duty, frozen_design
from tvclin.nozzle.flown_trade_off import FlownTradeOff, flown_required_rate, flown_trade_offs
from tvclin.requirement.autopilot_requirement import at_largest_pressure
from tvclin.requirement.case_requirement import CaseRequirement, study_requirement
from tvclin.requirement.nominal_requirement import covers
from tvclin.studyfile.read import is_flight
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.coefficients import BOTH, PLANE_TEXTS
from tvclin.winds.wind_angles import beyond_linear

if TYPE_CHECKING:
    from control import ControlPlot

    from tvclin.plots.curves import Curves

RATE, LOAD, FLIGHT = "rate", "load", "flight"
IN_A_WIND = f"--over {RATE} or {LOAD}"
"""Option of the answers at one flight time."""
_DRAWN = f"{IN_A_WIND}; --csv FILE writes the duty over a flight, of which there is no figure"
"""What a figure needs."""


@dataclass(frozen=True)
class NozzleOptions:
    """Options of the case of a nozzle; `grouped` gives them to a command."""

    winds: FlightOptions = GROUP
    limits: Options = BOTH_LIMITS
    load: Options = Options("case.load.LoadBound", ("load",), "load")
    law: list[str] | None = option(
        f"Fly this law with the limits too: {listed(LAWS, 'or')}. May be given several times"
        f" with {IN_A_WIND}.",
        shown=f"none; with --over {FLIGHT} the law or the autopilot of the study file, else trim",
    )
    laws: bool = switch(
        "--laws",
        "Fly every law, of a study file those of its laws, at each rate limit, for the limit that"
        " it needs; it takes about a minute.",
    )
    gains: GainOptions = GainOptions(DESIGN, ("natural_frequency",))
    times: Options = Options(SIZING, ("start", "stop", "every"), "sizing")
    model: Options = MODEL
    planes: PlaneOptions = GROUP
    dead_band: Options = Options(STUDY, ("dead_band",))

    @property
    def names(self) -> list[str]:
        """Names of the flown laws."""
        return [one_of("--law", item, LAWS) for item in self.law or ()]


@dataclass(frozen=True)
class _ShownNozzle(ShownCurves):
    """Options for showing what a nozzle must do: the duty over a flight has no figure."""

    plot: Annotated[
        Path | None,
        typer.Option(
            help=f"Also draw the curves of {IN_A_WIND} into this file (png, pdf, svg).",
            callback=to_draw,
        ),
    ] = None
    csv: Annotated[
        Path | None,
        typer.Option(
            help=f"Also write what --plot draws into this CSV file; with --over {FLIGHT} the duty"
            " of each flight.",
            callback=to_write,
        ),
    ] = None


def nozzle(
    vehicle: Annotated[
        str,
        typer.Argument(metavar="VEHICLE|STUDY|SCHEDULE", help=SOURCE_HELP),
    ] = "configuration-i",
    over: str | None = option(
        f"What the deflection is traded for: its {RATE}, or the {LOAD} on the structure, in one"
        f" wind; or the duty of the nozzle over a {FLIGHT}: angle, rate, travel, torque.",
        shown=f"{RATE}; {FLIGHT} for a flight schedule without --at",
    ),
    time: At = None,
    options: NozzleOptions = GROUP,
    more: More = False,
    shown: _ShownNozzle = GROUP,
) -> None:
    """Print what a nozzle must do: deflection over its rate or over the load, or duty of a flight.

    Over rate or load bounds are at nominal dynamic pressure: a limit below the lower bound is never
    sufficient; of one above it tvclin study is the verdict. With a dead band below 1, which has a
    forecast of the wind, a limit below the required deflection is not sufficient either, and the
    bound without a forecast does not count.

    Over rate a law is flown a second time, with the largest dynamic pressure in the wind
    throughout, where that counts: limits sufficient at the nominal one alone are NOT KNOWN.

    --law autopilot with --limit-deg also prints the smallest rate limit from which on the autopilot
    survives them all, flown with samples, delay, actuator, filters and bending.

    Over a flight, a law is flown at each flight time in each wind, and judged by the limits of the
    data sheet; torque, power and energy need what turns and what resists, in a table named nozzle.

    Exit code 0: no limit is below its lower bound, and flights survive within limits and load; 1:
    NOT SUFFICIENT, NOT SURVIVED, NOT MET, or NOT KNOWN; 2: bad input.
    """
    flight = over is None and time is None and is_flight(vehicle)
    over = one_of("--over", over or (FLIGHT if flight else RATE), (RATE, LOAD, FLIGHT))
    if over != LOAD:
        options.load.only_with(f"--over {LOAD}")
    if over != RATE:
        only_with(f"--over {RATE}", laws=options.laws)
    if over == FLIGHT:
        only_with(IN_A_WIND, at=time)
        only_with(_DRAWN, plot=shown.plot)
        options.dead_band.only_with(IN_A_WIND)
        print_duty(vehicle, options, more, shown)
    else:
        _print_in_a_wind(vehicle, over, time, options, more, shown)


def _print_in_a_wind(
    vehicle: str,
    over: str,
    time: float | None,
    options: NozzleOptions,
    more: bool,
    shown: ShownCurves,
) -> None:
    """Print the deflection over its rate or over the load in one wind; with `more`, the details.

    `vehicle`: name of a vehicle or of a file. `over`: rate or load. `time`: flight time [s] of a
    schedule. `options`: winds, laws and limits. `shown`: options of JSON, CSV file and figure.
    """
    winds, names = options.winds.at_one_time(vehicle), options.names
    case = _case_in_a_wind(vehicle, over, time, options, winds)
    title, required = winds.title(case, vehicle), study_requirement(case, case.dead_band)
    result = (
        over_rate(case, title, names, options.laws, required)
        if over == RATE
        else over_load(case, title, names)
    )
    shown.write(result.curves, result.chart)
    note_nominal_pressure(case)
    flown = (*names, *(_every_law(case) if options.laws else ()))
    gain_notes = textbook_notes(case) if AUTOPILOT in flown else ()
    answer(
        shown.as_json,
        lambda: winds.document(case, required) | result.document,
        lambda: print_answer(
            result.verdict(required) + cut_condition(case),
            *result.tables,
            notes=(*gain_notes, *result.notes),
            more=more,
            details=lambda: _print_details(result.further, case if AUTOPILOT in names else None),
        ),
        result.satisfied,
    )


def _print_details(further: Iterable[Table], flown: StudyPlan | None) -> None:
    """Print the `further` tables of an answer and the autopilot of a `flown` case, None without."""
    print_tables(*further)
    if flown is not None:
        autopilot = specified_autopilot(flown, flown.history, criteria=flown.margin_criteria)
        time, rate = getattr(flown.vehicle, "time", None), flown.hardware["sample_rate"]
        at = "" if time is None else f" of {float(time):.6g} s"
        print_autopilot(f"Autopilot{at}, {NOMINAL}, flown at {rate:g} Hz", autopilot, flown.plant)


def _case_in_a_wind(
    vehicle: str, over: str, time: float | None, options: NozzleOptions, winds: WindOptions
) -> StudyPlan:
    """Return the plan of a study with the case of a trade-off in one wind.

    `vehicle`: name of a vehicle, or of a vehicle or study file. `over`: rate or load. `time`:
    flight time [s] of a schedule. `options`: with the `names` of laws to fly, or all `laws`.
    `InputError` for options that only `--over flight` takes.
    """
    question = "nozzle" if over == RATE else f"nozzle --over {over}"
    options.times.only_with(f"--over {FLIGHT}")
    if options.planes.plane == BOTH:
        raise InputError(f"--plane {BOTH} needs tvclin nozzle --over {FLIGHT}")
    if AUTOPILOT not in options.names and not options.laws:
        FlownLaw(gains=options.gains).only_with_autopilot(vehicle)
    groups = (options.limits, options.load, options.model, options.planes, options.dead_band)
    # functions that put options into a plan
    changes = [group.applied_to for group in (*groups, options.gains)]
    case = case_of(vehicle, *changes, wind=winds.applied_to, questions=(question,), time=time)
    if not options.names and not options.laws:
        note_omissions(case, f"{question} without --law")
        return with_gust_for(case, case.dead_band)  # bounds of the control of the study
    return case


@dataclass(frozen=True, kw_only=True)
class TradeOffAnswer:
    """A trade-off with its flights: what is printed, drawn and written.

    `outcomes`: the outcomes of the flights, in words. `rate`: the required rate in words. `tables`:
    the answer; `further`: the others. `judged`: why the limit is not sufficient, in words; empty
    where it may be. `satisfied`: whether no limit is below its lower bound, and the flights satisfy
    the limits.
    """

    trade_off: RateTradeOff | LoadTradeOff
    judged: str
    document: dict[str, Any]
    outcomes: list[str]
    rate: str = ""
    tables: tuple[Table, ...]
    further: tuple[Table, ...]
    notes: tuple[str, ...]
    satisfied: bool
    curves: "Callable[[], Curves]"
    chart: "Callable[[Curves], ControlPlot]"

    def verdict(self, required: CaseRequirement | None) -> str:
        """Return the verdict: why the limit is not sufficient, the outcomes of flights, and bounds.

        The bounds, within the linear range alone, are the study's `required` deflection, the
        required rate, and the lower bound of the trade-off.
        """
        trade_off, bounds = self.trade_off, [""]
        if not trade_off.beyond_linear:
            study = "" if required is None else required.see_study
            bounds = [study, self.rate, trade_off.bound_text]
        return "; ".join(filter(None, [self.judged, *self.outcomes, *bounds]))


def over_rate(
    case: StudyPlan,
    title: str,
    names: list[str],
    every_law: bool,
    required: CaseRequirement | None,
) -> TradeOffAnswer:
    """Return the deflection limit over the rate limit, with the duty of laws by their names.

    `title`: vehicle and wind, above the first table. `every_law`: whether laws are flown for the
    limit that they need at each rate limit. `required`: requirement of the study, at which the
    required rate is stated where the case has no limit. With laws flown at each rate their limits
    are the first table and the figure, and the curve of the theory is a further one.
    """
    from tvclin import plots

    limit, rate_limit = case.nozzle.limit, case.nozzle.rate_limit
    flown, autopilot_rates = _flown_laws(case, names, required)
    with waiting("angle over rate"):
        trade_off = _rate_trade_off(case, limit)
        theory = None if trade_off.beyond_linear else _at_limit(case, trade_off, required)
    laws = _flown_limits(case) if every_law else None  # limit of each law over the rate limit
    drawn = laws or trade_off
    first, *further = (*(laws.tables() if laws else ()), *trade_off.tables())
    rate_words, rates, rate_tables = _required_rates(limit, theory, autopilot_rates)
    if rate_limit is None:  # the verdict has the required rate, and nothing remains of a limit
        further, rate_tables = [*rate_tables, *further], ()
    judged = _judged(case, trade_off, required)  # empty where the limit may be sufficient
    limited = limit is not None or rate_limit is not None
    of_laws = {"laws": laws} if laws else {}
    return TradeOffAnswer(
        trade_off=trade_off,
        judged=judged,
        document={"trade_off": trade_off, "flown": flown} | rates | of_laws,
        outcomes=[f"{duty.law} flown: {duty.verdict.words}" for duty in flown],
        rate=rate_words,
        tables=_titled(title, *rate_tables, first),
        further=(*further, *(table for duty in flown for table in duty.tables())),
        notes=tuple(note for result in (drawn, *flown) for note in result.notes),
        satisfied=not (limited and judged) and all(bool(duty.verdict.satisfied) for duty in flown),
        curves=lambda: plots.rate_curves(drawn),
        chart=lambda _: plots.rate_chart(drawn, title.replace(": ", "\n")),
    )


def _flown_laws(
    case: StudyPlan, names: list[str], required: CaseRequirement | None
) -> tuple[list[FlownDuty], tuple[float, float] | None]:
    """Return the duty of laws by their `names`, and the required rates of the autopilot.

    The rates are those of `_autopilot_rates`. Verdicts count the largest pressure in the wind. A
    limit shape does not count here: without it the requirement is of this plane alone. `required`:
    requirement of the study, None where it has none.
    """
    single_plane_case = replace(case, nozzle=replace(case.nozzle, limit_shape=None))
    need = required or study_requirement(single_plane_case, case.dead_band)
    with waiting("flying"):
        denser, counts = at_largest_pressure(single_plane_case, need) if names else (None, False)
        flown = [_flown_duty(case, name, denser, counts) for name in names]
        return flown, _autopilot_rates(case, names, denser, counts)


def _flown_duty(case: StudyPlan, name: str, denser: StudyPlan | None, counts: bool) -> FlownDuty:
    """Return the duty of a law, by `name`, whose verdict counts the pressure in the wind.

    `denser`: the case at the largest dynamic pressure in its wind, None where that is not known, or
    does not count (`counts`). An autopilot keeps its gains there, other laws are designed for it.
    """
    duty, at_largest = FlownDuty.of(case, name, limited_law(case, name)), None
    if not counts:
        return duty
    if denser is not None:
        with suppress(InputError):  # a plant or law that is not defined at that pressure
            law = limited_law(case if name == AUTOPILOT else denser, name)
            at_largest = FlownDuty.of(denser, name, law)
    return duty.bounded_by(at_largest)


def _autopilot_rates(
    case: StudyPlan, names: list[str], denser: StudyPlan | None, counts: bool
) -> tuple[float, float] | None:
    """Return the smallest rate limits [rad/s] with which a case's autopilot survives.

    At the largest dynamic pressure in the wind (`denser`, as in `_flown_duty`), NaN where that is
    not known, and at the nominal one; where the former does not count (`counts`), both are the
    latter. None where the autopilot is not among the laws, by their `names`, beyond linear
    aerodynamics, and in a wind that is not known throughout.
    """
    if AUTOPILOT not in names or beyond_linear(float(case.history.peak)) or case.unknown_wind:
        return None
    law = limited_law(case, AUTOPILOT)
    nominal, at_largest = flown_required_rate(case, law), np.nan
    if not counts:
        return nominal, nominal
    if denser is not None:
        with suppress(InputError):  # a plant that is not defined at that pressure
            at_largest = flown_required_rate(denser, law)
    return at_largest, nominal


def _judged(case: StudyPlan, trade_off: RateTradeOff, required: CaseRequirement | None) -> str:
    """Return why a limit is not sufficient, in words; empty where it may be.

    It is below its lower bound; or with a dead band below 1, which has a forecast of the wind,
    below the required deflection of the study. `trade_off`: trade-off of the case with its limit.
    """
    has_forecast = case.dead_band < 1.0
    if trade_off.verdict or trade_off.limit is None or required is None or not has_forecast:
        return trade_off.verdict
    sufficient = covers(trade_off.limit, required.required_deflection)
    return "" if sufficient else f"{sufficiency(False)}, below the {REQUIRED}"


def _at_limit(
    case: StudyPlan, trade_off: RateTradeOff, required: CaseRequirement | None
) -> RateTradeOff | None:
    """Return the trade-off at the limit, or else at the required deflection, with its rate.

    `trade_off`: of the case with its limit. None where neither is a deflection above zero.
    """
    if trade_off.limit is not None:
        return trade_off
    deflection = 0.0 if required is None else required.required_deflection
    if not 0.0 < deflection < np.pi / 2:
        return None
    # the required rate does not depend on the rates of the curve: one is enough
    return _rate_trade_off(case, deflection, trade_off.rates[:1])


def _rate_trade_off(
    case: StudyPlan, limit: float | None, rates: FloatArray | None = None
) -> RateTradeOff:
    """Return the trade-off of a case with a deflection limit [rad] and its own rate limit.

    `rates`: rate limits [rad/s] of the curve, ``(n,)``; None: 1.1 to 20 times the smallest.
    """
    return rate_trade_off(
        case.plant.rigid,
        case.history,
        rates,
        limit=limit,
        rate_limit=case.nozzle.rate_limit,
        forecast=case.dead_band < 1.0,
    )


def _required_rates(
    limit: float | None, theory: RateTradeOff | None, autopilot: tuple[float, float] | None
) -> tuple[str, dict[str, Any], tuple[Table, ...]]:
    """Return the required rates of autopilot and theory in words, for JSON, and in a table.

    They are those with the `limit` [rad], or without one with the required deflection. `theory`:
    trade-off with its rate there; None without one. `autopilot`: required rates of the autopilot,
    flown, [rad/s] at the largest dynamic pressure in the wind and at the nominal one; None where it
    is not flown.
    """
    words, at = list[str](), REQUIRED if limit is None else "limit"
    rates: dict[str, Any] = {}
    if theory is not None:
        rates["required_rate"] = document(theory, "limit", "required_rate")
    if autopilot is not None:
        keys = ("autopilot_required_rate", "autopilot_required_rate_nominal")
        of_keys = zip(keys, np.degrees(autopilot).tolist(), strict=True)
        rates |= {f"{key}_deg_per_s": rate for key, rate in of_keys}
        (at_largest, nominal), flown = autopilot, f"the {AUTOPILOT}, flown,"
        if at_largest != nominal and not np.isnan(at_largest):
            largest = f"{at} at the largest pressure in this wind"
            words.append(_rate_text(at_largest, largest, flown))
        at_nominal = at if at_largest == nominal else f"{at} {NOMINAL}"
        words.append(_rate_text(nominal, at_nominal, flown))
    if theory is None:
        return "; ".join(words), rates, ()
    words.append(_rate_text(theory.required_rate, at, theory.bounded_laws, "at least "))
    return "; ".join(words), rates, (required_rate_table(theory, at),)


def _rate_text(required_rate: float, at: str, law: str, least: str = "") -> str:
    """Return a required rate [rad/s] in words; `law`: the flown law, or the laws that it bounds.

    `at`: deflection with which the rate is required, in words: "limit", or the required one.
    `least`: words before a rate that is a lower bound.
    """
    if np.isinf(required_rate):
        return f"no rate is sufficient for {law} with the {at}"
    rate = f"{np.degrees(required_rate):.3f} deg/s"
    return f"{REQUIRED_RATE} of {law} with the {at} {least}{rate}"


def _flown_limits(case: StudyPlan) -> FlownTradeOff:
    """Return the limits that the laws of a case require in flight, over the rate limit."""
    with bar("boundaries") as progress:
        return flown_trade_offs({"": case}, laws=_every_law(case), progress=progress)[""]


def _every_law(case: StudyPlan) -> tuple[str, ...]:
    """Return the names of the laws that --laws flies: those of a study file, or all."""
    return tuple(LAWS) if case.laws is None else case.laws.names


def over_load(case: StudyPlan, title: str, names: list[str]) -> TradeOffAnswer:
    """Return the answer on deflection limit over load, with flights of laws by their `names`.

    `title`: vehicle and wind, above the table. It is satisfied if the trade-off has no objection to
    the limit or load that is given (its verdict is empty), and all flights survive within the load.
    """
    from tvclin import plots

    with waiting("flying"):
        flown = [FlownLoad.of(case, name, limited_law(case, name), case.load) for name in names]
    with waiting("angle over load"):
        if case.load is None:  # the load is the angle of attack
            rate = np.inf if case.nozzle.rate_limit is None else case.nozzle.rate_limit
            trade_off = load_trade_off(
                case.plant.rigid, case.history, limit=case.nozzle.limit, rate_limit=rate
            )
        else:
            trade_off = case.load.trade_off(case)
    curve, point = trade_off.tables()
    return TradeOffAnswer(
        trade_off=trade_off,
        judged=trade_off.verdict,
        document={"trade_off": trade_off, "flown": flown},
        outcomes=[f"flown, {load.words}" for load in flown],
        tables=_titled(title, curve),
        further=(point,),
        notes=tuple(trade_off.notes),
        satisfied=not (
            (trade_off.limit is not None or trade_off.load is not None) and trade_off.verdict
        )
        and all(load.survives_within for load in flown),
        curves=lambda: plots.load_curves(trade_off, flown),
        chart=lambda _: plots.load_chart(trade_off, flown, title.replace(": ", "\n")),
    )


def _titled(title: str, table: Table, *others: Table) -> tuple[Table, ...]:
    """Return tables below the title of their case."""
    return (replace(table, caption=f"{title}\n{table.caption}"), *others)


_QUESTION = "nozzle --over flight"
_FROZEN_DUTY = (
    f"is flown {FROZEN_ALONG}, in a head wind at its largest dynamic pressure throughout, and"
    " through the dynamics of the nozzle; tvclin ascent judges the ideal trim law, with pressure"
    " and vehicle varying, and may find a limit sufficient that does not survive here"
)
_USED = (
    "used is what the law uses in its samples, within the limits, at least the lower bound; the"
    " required deflection is that of tvclin ascent or study"
)


def print_duty(source: str, options: NozzleOptions, more: bool, shown: ShownCurves) -> None:
    """Print the duty of the nozzle in a whole flight of a law, and the verdict on its limits.

    `source`: name of the file. `options`: winds, times, limits, model, planes, law and gains.
    `shown`: options of JSON and CSV. `more`: whether all tables and notes are printed.
    """
    groups = (options.limits, options.model, options.planes, options.gains)
    case = case_over_flight(_QUESTION, source, options.winds, options.times, *groups)
    law, request = _duty_law(case, options.names), case.sizing
    assert request is not None
    if law != AUTOPILOT:
        FlownLaw(gains=options.gains).only_with_autopilot(source)  # refuses options of gains
        note_omissions(case, f"{_QUESTION} without the law {AUTOPILOT}")
    with bar("flight times and winds") as progress:
        duty = flight_duty(case, request, law, turbulence=case.turbulence, progress=progress)
    gains = textbook_notes(case) if law == AUTOPILOT else ()
    notes = [f"{law} {_FROZEN_DUTY}", *gains, *request.warnings, *request.notes, *duty.notes]
    duty.to_csv(shown.csv)  # written where the option names a file
    title = f"{duty.vehicle or source}, {PLANE_TEXTS[case.planes]}, {law} flown"
    sheet, *further = _titled(title, *duty.tables())
    frozen = "" if duty.verdict.satisfied is None else f", {FROZEN_ALONG}"
    answer(
        shown.as_json,
        lambda: duty.as_dict() | {"notes": notes},
        lambda: print_answer(
            f"{duty.verdict.words}{frozen}",
            sheet,
            notes=[*notes, _USED],
            more=more,
            details=lambda: _print_details(further, _at_worst_time(case, duty)),
        ),
        bool(duty.verdict.satisfied),
    )


def _duty_law(case: StudyPlan, names: list[str]) -> str:
    """Return the name of the law that is flown: of `names`, of a table [size], or the default.

    The default is the autopilot of the case where one is specified, else trim. `InputError` for
    more than one name.
    """
    if len(names) > 1:
        raise InputError(f"--law may be given once with --over flight; got {len(names)}")
    assert case.sizing is not None
    default = "trim" if case.autopilot_design.unspecified else AUTOPILOT
    return names[0] if names else case.sizing.duty_law or default


def _at_worst_time(case: StudyPlan, duty: FlightDuty) -> StudyPlan | None:
    """Return a case with its vehicle at the time of the first lost flight, or the largest angle.

    `duty`: flights of a law over the flight. None where the autopilot was not flown.
    """
    assert case.sizing is not None
    flights = [point for point in duty.points if point.status]
    if duty.law != AUTOPILOT or not flights:
        return None
    worst = max(flights, key=lambda x: np.inf if x.duty is None else abs(float(x.duty.angle.value)))
    return StudyPlan(
        vehicle=case.sizing.schedule.at(worst.time).replace(structure=None),
        model=case.law_model,
        plane=worst.plane,
        nozzle=case.nozzle,
        design=frozen_design(case, case.sizing, worst.time),
        controller=case.controller,
    )
