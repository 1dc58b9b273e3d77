"""Effects of a structure: margins by band, detuned modes, and a flight with limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.errors import InputError
from tvclin.base.lines import Line, number
from tvclin.case.case import Case
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.detuning import Detuned, detuned
from tvclin.control.laws.attitude import SaturatedLaw
from tvclin.control.laws.law import FilteredLaw, Law
from tvclin.control.laws.registry import AUTOPILOT, design_law
from tvclin.control.margins.bands import BandMargins
from tvclin.flights.closed_loop.survival_limit import ClosedLoopBoundary, closed_loop_boundary
from tvclin.flights.theory_comparison import SampledFlight, fly_sampled
from tvclin.linear.flexible import AnyPlant, FlexiblePlant, Shift, plant_of
from tvclin.linear.plant import DEFAULT_MODEL
from tvclin.vehicle.linear_vehicle import AnyVehicle
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from tvclin.control.autopilot.design_rules import AutopilotDesign
    from tvclin.control.margins.criteria import Criteria

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
    """Return margins, boundaries and flight of an autopilot with a flexible vehicle.

    The autopilot is designed on the rigid plant, except for gains by a search, such as gains for
    the minimum deflection. `criteria`: criteria for detuned modes. `limit`: deflection limit of the
    flight [rad]. `hardware`: items of `Case.hardware`. Same exceptions as `Autopilot.band_margins`
    and `closed_loop_boundary`.
    """
    bands = autopilot.band_margins(plant)
    law = SaturatedLaw.of(autopilot)
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
    """Return the minimum limit of a law in a wind, sought up to `limit` [rad] if none is lower.

    `hardware`: items of `Case.hardware`. Same exceptions as `closed_loop_boundary`.
    """
    boundary = closed_loop_boundary(plant, law, wind, **hardware)
    scanned = float(boundary.scan[-1])
    highest = limit / abs(float(plant.coefficients.B) * float(wind.peak))
    if np.isfinite(boundary.limit) or highest <= scanned:
        return boundary
    return closed_loop_boundary(plant, law, wind, lowest=scanned, highest=highest, **hardware)


def specified_law(case: Case, name: str, rate_limit: float, **parameters: Any) -> Law:
    """Return the law with a name for a case, with the filters of its autopilot.

    The law is designed by `design_law` on the rigid vehicle of the case, for its wind; "autopilot"
    has the gains of the case. `parameters`: further parameters of `design_law`. Same exceptions as
    `design_law` and `Case.autopilot`.
    """
    if name == AUTOPILOT:
        parameters = {AUTOPILOT: case.autopilot} | parameters
    peak = float(case.history.peak)
    law = design_law(name, case.plant.rigid, peak, rate_limit=rate_limit, **parameters)
    return with_filters(law, case.autopilot_design)


def with_filters(law: Law, design: AutopilotDesign) -> Law:
    """Return a law with the filters of an autopilot."""
    return FilteredLaw(law, **design.chains) if any(design.chains.values()) else law


def shift_of(plant: AnyPlant) -> Shift | None:
    """Return the shift of the rigid theory by the structure; None without an unstable mode."""
    if plant.structure is None:
        return None
    try:
        return plant.shift()
    except InputError:
        return None


def shift_lines(plant: AnyPlant) -> tuple[Line, Line] | None:
    """Return the shifts [%] of fast pole and deflection by the structure; None as of `shift_of`."""
    moved = shift_of(plant)
    if moved is None:
        return None
    return (
        number("flexible.shift.fast_pole", moved.fast_pole, 1, "%"),
        number("flexible.shift.trim_price", moved.trim_price, 1, "%"),
    )


def shift_words(vehicle: AnyVehicle, plane: str) -> str:
    """Return the shift of fast pole and deflection by the structure, in words."""
    shift = shift_of(plant_of(vehicle, DEFAULT_MODEL, plane))
    if shift is None:
        return ""
    return (
        f"would move the fast pole by {shift.fast_pole:+.2f} percent and the required deflection"
        f" by {shift.trim_price:+.2f} percent"
    )
