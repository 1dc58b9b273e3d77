"""Requirements of pulses at the dynamic pressure encountered, by direction, in a sizing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tvclin.answers.case import Case
from tvclin.answers.case_need import CaseNeed, case_need
from tvclin.answers.encountered import encountered_wind
from tvclin.answers.sizing.flight_mode import FlightMode
from tvclin.answers.sizing.flight_requirement import requirement_of_parts
from tvclin.answers.sizing.record import IN_A, VARYING, Sizing
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.vehicle.linear_vehicle import whole_vehicle


def base_of(found: Sizing) -> str:
    """Return the largest dead band: with varying parameters, if known wherever frozen ones are."""
    name = f"K = {found.dead_bands[0]:g}"
    frozen, along = found.required[name], found.required.get(f"{name}{VARYING}")
    if along is None or np.isnan(along).all() or np.any(np.isnan(along) & ~np.isnan(frozen)):
        return name
    return f"{name}{VARYING}"


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
    name = base_of(found)
    columns: dict[str, FloatArray] = {}
    for i, j in np.argwhere(found.known[:, :pulses]).tolist():
        try:
            need = case_need(case_at(float(found.times[i]), j), K)
            if need.encountered_unknown:
                raise InputError(need.encountered_unknown)
            for direction in need.encountered:
                column = columns.setdefault(name + IN_A[direction], found.required[name].copy())
                along = name.endswith(VARYING) and mode is not None and not need.in_both
                if along and mode is not None:
                    column[i, j] = _along(mode, need, direction, float(found.begins[i, j]))
                elif need.nominal_deflection > 0.0:
                    column[i, j] *= need.encountered[direction] / need.nominal_deflection
        except InputError as error:  # no such wind at this path, no real pole: as it stands
            unknown[i, j], why = True, why or f"{found.times[i]:g} s: {error}"
    arises = dict(found.arises)
    if name in arises:
        arises |= dict.fromkeys(columns, arises[name])
    found = replace(found, required=found.required | columns, arises=arises)
    if not (why and columns):
        return found
    said = f"the dynamic pressure encountered in a pulse is not known at {why}"
    return replace(found, unsigned=unknown, notes=(*found.notes, said))


def _along(mode: FlightMode, need: CaseNeed, direction: str, begins: float) -> float:
    """The required deflection [rad] along the flight of a pulse that begins at a time [s]."""
    vehicle = whole_vehicle(need.vehicle, "the dynamic pressure encountered").rigid
    wind = encountered_wind(need.placed, vehicle, need.plane, direction)
    flown = mode.schedule.vehicle
    paths, speeds = (
        np.broadcast_to(x, mode.schedule.times.shape) for x in (flown.attitude, flown.velocity)
    )
    flight = mode.schedule.times, paths, speeds / float(np.asarray(vehicle.velocity))
    wind = replace(wind.shift(begins - float(wind.history.onset)), flight=flight)
    wind.check_possible()
    return requirement_of_parts(mode, wind, need.dead_band)[0]
