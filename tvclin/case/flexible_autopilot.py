"""Autopilot of a case: margins by band, detuned modes, and a flight with limits.

Notes name gains and actuators that are assumed, and a rule whose gains satisfy the criteria.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.errors import InputError
from tvclin.base.lines import Line, number
from tvclin.case.case import Case
from tvclin.case.nozzle import USUAL_ACTUATOR
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.design_rules import (
    GIVEN_GAINS,
    LEAST_NOZZLE,
    POLE_PLACEMENT_RULES,
    RULE_KEYS,
    AutopilotDesign,
)
from tvclin.control.autopilot.detuning import Detuned, detuned
from tvclin.control.laws.autopilot_law import SaturatedLaw
from tvclin.control.laws.law import FilteredLaw, Law
from tvclin.control.laws.registry import AUTOPILOT, design_law
from tvclin.control.margins.bands import BandMargins
from tvclin.control.margins.criteria import Criteria
from tvclin.flights.closed_loop.survival_limit import ClosedLoopBoundary, closed_loop_boundary
from tvclin.linear.flexible import AnyPlant, FlexiblePlant, Shift, plant_of
from tvclin.linear.plant import DEFAULT_MODEL
from tvclin.vehicle.linear_vehicle import AnyVehicle
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from tvclin.flights.theory_comparison import SampledFlight

_FLIGHT_DURATIONS, _FLIGHT_POINTS = 2.0, 401
"""Duration of a flight in durations of its wind, and number of its times."""


@dataclass(frozen=True, eq=False)
class FlexibleAnswer:
    """Margins, boundaries and flight of an autopilot with a flexible vehicle.

    `bands`: its margins. `detuned`: margins with detuned modes; None without modes. `sample_rate`:
    samples of the law in flights [Hz]. `boundaries`: minimum limits of the autopilot in the wind,
    for the flexible and for the rigid vehicle. `flight`: a flight with the specified limit; None
    without a limit.
    """

    plant: FlexiblePlant
    autopilot: Autopilot
    bands: BandMargins
    detuned: Detuned | None
    sample_rate: float
    boundaries: tuple[ClosedLoopBoundary, ClosedLoopBoundary]
    flight: SampledFlight | None


def flexible_answer(
    plant: FlexiblePlant,
    autopilot: Autopilot,
    criteria: Criteria,
    wind: History,
    limit: float | None,
    **hardware: Any,
) -> FlexibleAnswer:
    """Return margins, boundaries and flight of an autopilot with a flexible vehicle in one wind.

    A boundary is the smallest deflection limit with which the autopilot survives the wind; that of
    the rigid vehicle shows how much bending and slosh add. `autopilot`: with its gains, usually
    designed on the rigid plant. `criteria`: criteria for detuned modes. `limit`: deflection limit
    of the flight [rad], None for no flight. `hardware`: actuator, rate limit, delay and sample rate
    of flights, by name. `InputError` where margins or boundaries cannot be computed.
    """
    from tvclin.flights.theory_comparison import fly_sampled  # late, with its engines

    bands = autopilot.band_margins(plant)
    law = SaturatedLaw.of(autopilot)
    # boundary of the nozzle's stop (its deflection limit), sought at least up to `limit`
    flexible, rigid = (
        stop_boundary(vehicle, law, wind, limit or 0.0, hardware)
        for vehicle in (plant, plant.rigid)
    )
    start, end = float(wind.onset), float(wind.end)
    times = np.linspace(start, start + _FLIGHT_DURATIONS * (end - start), _FLIGHT_POINTS)
    return FlexibleAnswer(
        plant=plant,
        autopilot=autopilot,
        bands=bands,
        detuned=detuned(autopilot, plant, criteria=criteria) if bands.modes else None,
        sample_rate=hardware["sample_rate"],
        boundaries=(flexible, rigid),
        flight=None
        if limit is None
        else fly_sampled(plant, law, wind, times, deflection_limit=limit, **hardware),
    )


def stop_boundary(
    plant: AnyPlant, law: Law, wind: History, limit: float, hardware: dict[str, Any]
) -> ClosedLoopBoundary:
    """Return the minimum limit of a law in one wind, sought up to `limit` [rad] if none is lower.

    A first scan ends at some multiples of static trim, the deflection ``|B| peak`` at the peak of
    the wind (B: trim deflection over wind angle). Only where none of these limits survives and
    `limit` lies above, a second scan goes on to it.
    `hardware`: actuator, rate limit, delay and sample rate of flights, by name. `InputError` where
    flights have no boundary, as in an endless wind.
    """
    boundary = closed_loop_boundary(plant, law, wind, **hardware)
    scanned = float(boundary.scan[-1])  # limits over static trim, as `highest`
    highest = limit / abs(float(plant.coefficients.B) * float(wind.peak))
    if np.isfinite(boundary.limit) or highest <= scanned:
        return boundary
    return closed_loop_boundary(plant, law, wind, lowest=scanned, highest=highest, **hardware)


def specified_law(case: Case, name: str, rate_limit: float, **parameters: Any) -> Law:
    """Return the law with a name for a case, with the filters of its autopilot.

    The law is designed by `design_law` on the rigid vehicle of the case, for its wind; "autopilot"
    has the gains of the case. `rate_limit`: limit of the deflection rate [rad/s]. `parameters`:
    further parameters of `design_law`. `InputError` for a law that cannot be designed.
    """
    if name == AUTOPILOT:
        parameters = {AUTOPILOT: case.autopilot} | parameters
    peak = float(case.history.peak)
    law = design_law(name, case.plant.rigid, peak, rate_limit=rate_limit, **parameters)
    return with_filters(law, case.autopilot_design)


def with_filters(law: Law, design: AutopilotDesign) -> Law:
    """Return a law with the filters of an autopilot `design`, or the law itself without filters."""
    return FilteredLaw(law, **design.chains) if any(design.chains.values()) else law


def shift_of(plant: AnyPlant) -> Shift | None:
    """Return the shift of fast pole and trim of a plant by its structure [%].

    How far bending and slosh move them from the poles of the rigid plant. None for a rigid plant,
    and for one without an unstable mode.
    """
    if plant.structure is None:
        return None
    try:
        return plant.shift()
    except InputError:
        return None


def shift_lines(plant: AnyPlant) -> tuple[Line, Line] | None:
    """Return the shifts of fast pole and trim of a plant by its structure [%], for a table.

    Trim is the deflection per wind angle at the fast pole, `trim_price`. None for a rigid plant,
    and for one without an unstable mode.
    """
    moved = shift_of(plant)
    if moved is None:
        return None
    return (
        number("flexible.shift.fast_pole", moved.fast_pole, 1, "%"),
        number("flexible.shift.trim_price", moved.trim_price, 1, "%"),
    )


def shift_words(vehicle: AnyVehicle, plane: str) -> str:
    """Return the shift of fast pole and deflection by the structure of a vehicle, in words.

    `plane`: "pitch" or "yaw". Empty for a rigid vehicle, and for one without an unstable mode.
    """
    shift = shift_of(plant_of(vehicle, DEFAULT_MODEL, plane))
    if shift is None:
        return ""
    # `trim_price`: change of the deflection per wind angle at the fast pole [%]
    pole, deflection = (_percent(float(x)) for x in (shift.fast_pole, shift.trim_price))
    return f"would move the fast pole by {pole} and the required deflection by {deflection}"


def _percent(change: float) -> str:
    """Return a change [%] in words; below the two decimals shown it has no sign."""
    return "less than 0.01 percent" if abs(change) < 0.005 else f"{change:+.2f} percent"


_FREQUENCY_RATIOS = (1.5, 2.0, 3.0, 4.0, 6.0)
"""Natural frequencies that are tried, normalised by the unstable pole."""
_TRIED_RULES = ("poles", "canonical", "half-relief", "drift-minimum", "load-minimum", "lqr")
"""Rules that are tried, those with fewer sensors first; lqr last, for it loads python-control."""


def gain_notes(
    case: Case, criteria: Criteria, satisfied: bool, delay_margin: float
) -> Iterator[str]:
    """Yield notes on unspecified gains or actuator, and on gains that satisfy the criteria.

    `case`: the vehicle and its autopilot. `satisfied`: whether the gains of the case satisfy the
    criteria. `delay_margin`: delay margin [s] of these gains.
    """
    yield from textbook_notes(case)
    half_sample = 0.5 / case.hardware["sample_rate"]
    if not satisfied:
        yield _better_gains(case, criteria)
    elif delay_margin < half_sample:
        yield (
            f"the delay margin, {1e3 * delay_margin:.3g} ms, is below half a sample of the flights,"
            f" {1e3 * half_sample:.3g} ms, and no criterion bounds it (criteria.delay_margin_ms)"
        )
    yield from actuator_notes(case)


def textbook_notes(case: Case, *, over_flight: bool = False) -> Iterator[str]:
    """Yield a note if neither the file nor an option of a case specifies the gains.

    By default the gain on attitude a0 = 2 B and that on attitude rate a1 [s] = B/beta: B the trim
    deflection over wind angle, beta the unstable pole [1/s]. `over_flight`: whether the autopilot
    has such gains at each flight time.
    """
    if case.autopilot_design.unspecified and case.controller is None:
        times, table = (
            (" at each flight time", " (--set autopilot.schedule FILE: a table of them)")
            if over_flight
            else ("", "")
        )
        yield (
            f"these are textbook gains{times}, a0 = 2 B and a1 = B/beta, since no option and no"
            f" file specifies others{table}"
        )


def actuator_notes(case: Case) -> Iterator[str]:
    """Yield a note if neither the file nor an option of a case specifies its actuator."""
    if case.nozzle.actuator is USUAL_ACTUATOR:
        yield (
            f"an actuator of {USUAL_ACTUATOR.natural_frequency:g} rad/s and damping"
            f" {USUAL_ACTUATOR.damping:g} is assumed"
            " (actuator_frequency_rad_per_s in [nozzle] gives another; 0: none)"
        )


def _better_gains(case: Case, criteria: Criteria) -> str:
    """Return the note on a rule with gains that satisfy the criteria, or on the search for them.

    `case`: the vehicle and its autopilot, whose gains do not satisfy them.
    """
    rule = satisfying_rule(case, criteria)
    if rule is None:
        structure = case.plant.structure
        bends = case.plant.has_modes if structure is None else bool(structure.bending)
        searched = case.autopilot_design.design == LEAST_NOZZLE
        search = "" if searched else "; tvclin design --least seeks them"
        filtered = any(case.autopilot_design.chains.values())
        need = "another notch" if filtered else "a notch"
        turned = ", or sensor slopes of the other sign" if filtered else ""
        notch = f", and a bending mode may need {need} ([[autopilot.filter]]){turned}"
        return (
            f"no design rule has gains that satisfy the criteria {criteria.name} (poles at 1.5 to 6"
            f" times the unstable one are tried){search}{notch if bends else ''}"
        )
    option, key = f"--design {rule.design}", f'design = "{rule.design}"'
    if rule.natural_frequency is not None:
        option += f" --natural-frequency {rule.natural_frequency:g}"
        key += f" and natural_frequency_rad_per_s = {rule.natural_frequency:g}"
    alpha = replace(case, design=rule, controller=None).autopilot.alpha_gain
    sensor = " (they feed back the angle of attack too)" if np.any(alpha) else ""
    return (
        f"gains that satisfy the criteria {criteria.name}: {option}, or in [autopilot] {key}, in"
        f" place of other gains{sensor}"
    )


def satisfying_rule(case: Case, criteria: Criteria) -> AutopilotDesign | None:
    """Return the first design whose gains satisfy the criteria; None if none does.

    The designs are those of the rules that need no wind and at most one pole pair, which lies at
    multiples of the unstable pole or at the natural frequency of the case; with the actuator,
    delay, filters and sample rate of the case.
    """
    no_gains: Any = dict.fromkeys((*RULE_KEYS, *GIVEN_GAINS))  # None for each
    base = replace(case.autopilot_design, **no_gains)
    frequencies = []
    with suppress(InputError):  # a stable vehicle has no such pole
        pole = float(case.plant.rigid.coefficients.pole)
        # two digits, as the note prints them
        frequencies = [float(f"{ratio * pole:.2g}") for ratio in _FREQUENCY_RATIOS]
    if (specified := case.autopilot_design.natural_frequency) is not None:
        frequencies.append(specified)
    for name in _TRIED_RULES:
        placed = frequencies if name in POLE_PLACEMENT_RULES else [None]
        for frequency in placed:
            rule = replace(base, design=name, natural_frequency=frequency)
            if _satisfies(replace(case, design=rule, controller=None), criteria):
                return rule
    return None


def _satisfies(case: Case, criteria: Criteria) -> bool:
    """Return whether the loop of a case is stable and satisfies the criteria, of modes too.

    False for gains that cannot be designed, or whose margins cannot be computed.
    """
    plant = case.plant
    with suppress(InputError, np.linalg.LinAlgError, ArithmeticError):
        margins = case.autopilot.margins(plant)
        if not isinstance(plant, FlexiblePlant):
            return bool(criteria.are_satisfied(margins))
        return bool(margins.stable) and bool(
            criteria.are_satisfied(case.autopilot.band_margins(plant))
        )
    return False
