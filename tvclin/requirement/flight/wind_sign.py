"""Requirements of pulses at the dynamic pressure encountered, by direction, in a sizing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.case.case import Case
from tvclin.requirement.case_requirement import case_requirement, pulse_of
from tvclin.requirement.encountered_requirement import directions_of, encountered_wind
from tvclin.requirement.flight.flight_requirement import FlightMode, requirements_along
from tvclin.requirement.flight.sizing import Sizing
from tvclin.requirement.required_quantity import Requirement
from tvclin.vehicle.linear_vehicle import complete_vehicle
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_angles import EncounteredWind


def base_requirement(sizing: Sizing) -> Requirement:
    """Return the requirement of the largest dead band, with varying parameters if these are known.

    They must be known wherever the requirement with frozen parameters is.
    """
    frozen = Requirement(dead_band=sizing.dead_bands[0])
    varying = replace(frozen, varying=True)
    frozen_is_known, values = ~np.isnan(sizing.required[frozen]), sizing.required.get(varying)
    if values is None or np.isnan(values).all() or np.any(np.isnan(values) & frozen_is_known):
        return frozen
    return varying


def with_directions(
    sizing: Sizing, pulses: int, case_at: Callable[[float, int], Case], mode: FlightMode | None
) -> Sizing:
    """Return a sizing with the requirements of pulses at the dynamic pressure encountered.

    Columns are added by the possible directions of the pulses, for the largest dead band; a
    sounding has its own direction, and the same requirement in all.

    Parameters
    ----------
    sizing : Sizing
        The sizing at nominal dynamic pressure of its first winds.
    pulses : int
        Number of the first winds, which are pulses.
    case_at : callable
        From a flight time [s] and the number of a pulse to its case.
    mode : FlightMode or None
        The flight, where parameters vary.
    """
    unknown, why, K = np.zeros(sizing.known.shape, dtype=bool), "", float(sizing.dead_bands[0])
    base = base_requirement(sizing)
    columns: dict[Requirement, FloatArray] = {}
    along: list[tuple[FloatArray, int, int, EncounteredWind]] = []
    for i, j in np.argwhere(sizing.known[:, :pulses]).tolist():
        try:
            case = case_at(float(sizing.times[i]), j)
            if base.varying and mode is not None:
                winds = _winds_along(mode, case, K, float(sizing.begins[i, j]))
                factors = dict.fromkeys(winds, 1.0)
            else:
                winds, factors = {}, _encountered_over_nominal(case, K)
            for direction, factor in factors.items():
                requirement = replace(base, direction=direction)
                column = columns.setdefault(requirement, sizing.required[base].copy())
                column[i, j] *= factor
                if direction in winds:
                    along.append((column, i, j, winds[direction]))
        except InputError as error:  # no such wind at this path, too long a wind: as it stands
            unknown[i, j], why = True, why or f"{sizing.times[i]:g} s: {error}"
    if along and mode is not None:
        required = requirements_along(mode, [wind for *_, wind in along], K)[:, 0]
        for (column, i, j, _), value in zip(along, required.tolist(), strict=True):
            column[i, j] = value
    arises = dict(sizing.arises)
    if base in arises:
        arises |= dict.fromkeys(columns, arises[base])
    sizing = replace(sizing, required=sizing.required | columns, arises=arises)
    unknown &= sizing.required[base] != 0.0
    if not unknown.any():
        return sizing
    note = f"the dynamic pressure encountered in a pulse is not known at {why}"
    return replace(sizing, unsigned=unknown, notes=(*sizing.notes, note))


def _encountered_over_nominal(case: Case, K: float) -> dict[str, float]:
    """Return the ratios of encountered to nominal requirement of a case, by direction."""
    need = case_requirement(case, K)
    if need.encountered_unknown:
        raise InputError(need.encountered_unknown)
    nominal = need.nominal_deflection
    return {
        direction: required / nominal if nominal > 0.0 else 1.0
        for direction, required in need.encountered.items()
    }


def _winds_along(
    mode: FlightMode, case: Case, K: float, begins: float
) -> dict[str, EncounteredWind]:
    """Return the pulse of a case along the flight from time `begins` [s], by direction."""
    vehicle = complete_vehicle(case.vehicle, "the dynamic pressure encountered").rigid
    flown = mode.schedule.vehicle
    paths, speeds = (
        np.broadcast_to(x, mode.schedule.times.shape) for x in (flown.attitude, flown.velocity)
    )
    flight = mode.schedule.times, paths, speeds / float(np.asarray(vehicle.velocity))
    in_plane, winds = case.wind_in_plane_at(K), {}
    assert isinstance(in_plane, ShapedWind)
    placed = replace(pulse_of(case), gust_at=in_plane.gust_at)
    for direction in directions_of(case):
        wind = encountered_wind(placed, vehicle, case.plane, direction)
        wind = replace(wind.shift(begins - float(wind.history.onset)), flight=flight)
        wind.check_possible()
        winds[direction] = wind
    return winds
