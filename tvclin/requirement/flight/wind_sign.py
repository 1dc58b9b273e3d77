"""Requirements of pulses at the dynamic pressure encountered, by direction, in a sizing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.case.case import Case
from tvclin.requirement.case_requirement import CaseRequirement, case_requirement
from tvclin.requirement.encountered_requirement import encountered_wind
from tvclin.requirement.flight.flight_requirement import FlightMode, requirement_of_parts
from tvclin.requirement.flight.sizing import Sizing
from tvclin.requirement.required_quantity import Requirement
from tvclin.vehicle.linear_vehicle import complete_vehicle


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
    for i, j in np.argwhere(sizing.known[:, :pulses]).tolist():
        try:
            need = case_requirement(case_at(float(sizing.times[i]), j), K)
            if need.encountered_unknown:
                raise InputError(need.encountered_unknown)
            for direction in need.encountered:
                requirement = replace(base, direction=direction)
                column = columns.setdefault(requirement, sizing.required[base].copy())
                if base.varying and mode is not None and not need.judges_both_planes:
                    column[i, j] = _requirement_along(
                        mode, need, direction, float(sizing.begins[i, j])
                    )
                elif need.nominal_deflection > 0.0:
                    column[i, j] *= need.encountered[direction] / need.nominal_deflection
        except InputError as error:  # no such wind at this path, no real pole: as it stands
            unknown[i, j], why = True, why or f"{sizing.times[i]:g} s: {error}"
    arises = dict(sizing.arises)
    if base in arises:
        arises |= dict.fromkeys(columns, arises[base])
    sizing = replace(sizing, required=sizing.required | columns, arises=arises)
    if not (why and columns):
        return sizing
    note = f"the dynamic pressure encountered in a pulse is not known at {why}"
    return replace(sizing, unsigned=unknown, notes=(*sizing.notes, note))


def _requirement_along(
    mode: FlightMode, need: CaseRequirement, direction: str, begins: float
) -> float:
    """Return the required deflection [rad] along the flight, of a pulse from time `begins` [s]."""
    vehicle = complete_vehicle(need.vehicle, "the dynamic pressure encountered").rigid
    wind = encountered_wind(need.placed, vehicle, need.plane, direction)
    flown = mode.schedule.vehicle
    paths, speeds = (
        np.broadcast_to(x, mode.schedule.times.shape) for x in (flown.attitude, flown.velocity)
    )
    flight = mode.schedule.times, paths, speeds / float(np.asarray(vehicle.velocity))
    wind = replace(wind.shift(begins - float(wind.history.onset)), flight=flight)
    wind.check_possible()
    return requirement_of_parts(mode, wind, need.dead_band)[0]
