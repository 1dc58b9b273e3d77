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


def base_of(found: Sizing) -> Requirement:
    """Return the largest dead band: with varying parameters, if known wherever frozen ones are."""
    frozen = Requirement(dead_band=found.dead_bands[0])
    varying = replace(frozen, varying=True)
    known, along = ~np.isnan(found.required[frozen]), found.required.get(varying)
    if along is None or np.isnan(along).all() or np.any(np.isnan(along) & known):
        return frozen
    return varying


def by_direction(
    found: Sizing, pulses: int, case_at: Callable[[float, int], Case], mode: FlightMode | None
) -> Sizing:
    """Return a sizing with what its first winds require at the dynamic pressure encountered.

    Columns are added by the possible directions of these winds, for the largest dead band; a
    sounding, which has its own, requires the same in all.

    Parameters
    ----------
    found : Sizing
        The sizing at nominal dynamic pressure of its first winds.
    pulses : int
        How many winds these are.
    case_at : callable
        From a flight time [s] and the number of a pulse to its case.
    mode : FlightMode or None
        The flight, where parameters vary.
    """
    unknown, why, K = np.zeros(found.known.shape, dtype=bool), "", float(found.dead_bands[0])
    base = base_of(found)
    columns: dict[Requirement, FloatArray] = {}
    for i, j in np.argwhere(found.known[:, :pulses]).tolist():
        try:
            need = case_requirement(case_at(float(found.times[i]), j), K)
            if need.encountered_unknown:
                raise InputError(need.encountered_unknown)
            for direction in need.encountered:
                one = replace(base, direction=direction)
                column = columns.setdefault(one, found.required[base].copy())
                if base.varying and mode is not None and not need.in_both:
                    column[i, j] = _along(mode, need, direction, float(found.begins[i, j]))
                elif need.nominal_deflection > 0.0:
                    column[i, j] *= need.encountered[direction] / need.nominal_deflection
        except InputError as error:  # no such wind at this path, no real pole: as it stands
            unknown[i, j], why = True, why or f"{found.times[i]:g} s: {error}"
    arises = dict(found.arises)
    if base in arises:
        arises |= dict.fromkeys(columns, arises[base])
    found = replace(found, required=found.required | columns, arises=arises)
    if not (why and columns):
        return found
    said = f"the dynamic pressure encountered in a pulse is not known at {why}"
    return replace(found, unsigned=unknown, notes=(*found.notes, said))


def _along(mode: FlightMode, need: CaseRequirement, direction: str, begins: float) -> float:
    """The required deflection [rad] along the flight of a pulse that begins at a time [s]."""
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
