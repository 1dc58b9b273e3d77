"""Sizing of both planes with one limit shape, from each plane and from the winds' vectors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from tvclin.answers.planes import VectorNeed, rectangle, vector_need
from tvclin.answers.quantity import MINIMUM, NO_FORECAST, TRIM, Requirement
from tvclin.answers.sizing.placing import PlacedWind
from tvclin.answers.sizing.record import Sizing, beyond_one_pole
from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.boundary.limit_shapes import LimitShape
from tvclin.linear.plant import ONE_POLE, Plant
from tvclin.vehicle.coefficients import BOTH, PLANES
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.plane_wind import PlaneWind


def in_both_planes(
    parts: dict[str, Sizing],
    vehicles: list[Vehicle],
    placed: list[list[dict[str, PlacedWind]]],
    stop: LimitShape,
    counted: Callable[[Any], Any],
) -> Sizing:
    """Return the sizing of both planes from the sizings of each, without notes.

    `vehicles` has one for each flight time, and `placed` for each the winds by planes. `counted`
    returns its argument and counts it for the progress.
    """
    pitch, yaw = (parts[plane] for plane in PLANES)
    beyond = pitch.beyond_one_pole | yaw.beyond_one_pole
    bands = pitch.dead_bands
    needs = [
        [
            counted(_vector(vehicle, pitch.model, wind, bool(beyond[i, j]), stop, bands))
            for j, wind in enumerate(row)
        ]
        for i, (vehicle, row) in enumerate(zip(vehicles, placed, strict=True))
    ]
    arises = {name: _arises(pitch, yaw, name) for name in {**pitch.arises, **yaw.arises}}
    required, more = _required(pitch, yaw, needs, stop, arises)
    refused = [[bool(one.said) and not one.trim for one in row] for row in needs]
    spoken = [one for i, j in np.argwhere(more | np.array(refused)) for one in needs[i][j].said]
    said = (*pitch.said, *yaw.said, *spoken)
    slow = np.where(beyond_one_pole(yaw.slow_mode), yaw.slow_mode, pitch.slow_mode)
    return Sizing(
        **{name: getattr(pitch, name) for name in ("schedule", "times", "winds", "dead_bands")},
        **{name: getattr(pitch, name) for name in ("law", "model", "known_times", "known")},
        required=required,
        plane=BOTH,
        begins=np.fmin(pitch.begins, yaw.begins),
        ends=np.fmax(pitch.ends, yaw.ends),
        change=np.maximum(pitch.change, yaw.change),
        covered=pitch.covered & yaw.covered,
        slow_mode=slow,
        edge=np.fmin(pitch.edge, yaw.edge),
        said=tuple(dict.fromkeys(said)),
        notes=(),
        alone=parts,
        arises=arises,
        stop=stop,
    )


def _arises(pitch: Sizing, yaw: Sizing, name: Requirement) -> FloatArray:
    """Return when a number of a fixed wind arises [s]: in the plane of the larger, ``(m,)``."""
    times = [one.arising(name) for one in (pitch, yaw)]
    sizes = [np.nanmax(one.required[name], axis=0, initial=0.0) for one in (pitch, yaw)]
    in_pitch = np.isnan(times[1]) | ((sizes[0] >= sizes[1]) & ~np.isnan(times[0]))
    return np.where(in_pitch, *times)


def _required(
    pitch: Sizing,
    yaw: Sizing,
    needs: list[list[VectorNeed]],
    stop: LimitShape,
    arises: dict[Requirement, FloatArray],
) -> tuple[dict[Requirement, FloatArray], BoolArray]:
    """Return the requirements [rad] of both planes, and where the wind vector requires more.

    Of the trim, the minimum and the bound without a forecast the larger of both planes counts, of
    dead bands the corner of both; and the requirement of the wind's vector, if it is larger.
    """
    known = [name for name in pitch.required if name in yaw.required]
    held = {name: rectangle(stop, pitch.required[name], yaw.required[name]) for name in known}
    sides = stop.support(np.array([1.0, 1j, -1.0, -1j])).reshape(2, 2).max(axis=0)
    alone = {  # a stop reaches no further in a plane than its support
        name: np.maximum(pitch.required[name] / sides[0], yaw.required[name] / sides[1])
        for name in known
    }
    required = dict(held)
    required[TRIM] = _larger(alone[TRIM], needs, lambda one: one.trim)
    required[MINIMUM] = _larger(alone[MINIMUM], needs, lambda one: one.minimum)
    if pitch.law == "bound":
        required[NO_FORECAST] = _larger(alone[NO_FORECAST], needs, lambda one: one.no_forecast)
    names = [Requirement(dead_band=K) for K in pitch.dead_bands]
    for k, name in enumerate(names):
        required[name] = _larger(held[name], needs, lambda one, k=k: one.required[k])
        if (along := replace(name, varying=True)) in held:  # what the vector requires besides
            beyond_planes = np.divide(
                required[name], held[name], out=np.ones(held[name].shape), where=held[name] > 0.0
            )
            fixed = (
                ~np.isnan(arises[along]) if along in arises else np.zeros(len(pitch.winds), bool)
            )
            whole = np.nanmax(beyond_planes, axis=0, initial=1.0)  # one number for the flight
            required[along] = held[along] * np.where(fixed, whole, beyond_planes)
    return required, np.any([required[name] > held[name] for name in names], axis=0)


def _vector(
    vehicle: Vehicle,
    model: str,
    wind: dict[str, PlacedWind],
    beyond: bool,
    stop: LimitShape,
    bands: FloatArray,
) -> VectorNeed:
    """Return the requirements of the wind vector; zeros where one plane alone has wind."""
    if any(one.calm for one in wind.values()):
        nothing = np.zeros(bands.shape)
        return VectorNeed(0.0, nothing, 0.0, 0.0, ())
    pitch, yaw = (Plant.from_vehicle(vehicle, model, plane) for plane in PLANES)
    both = PlaneWind(**{plane: one.history for plane, one in wind.items()})
    found = vector_need(pitch, yaw, both, stop, bands)
    if not (beyond and model in ONE_POLE):
        return found
    pitch, yaw = (Plant.from_vehicle(vehicle, "drift-exact", plane) for plane in PLANES)
    exact = vector_need(pitch, yaw, both, stop, bands)
    required = np.maximum(found.required, exact.minimum)
    return VectorNeed(found.trim, required, found.no_forecast, exact.minimum, found.said)


def _larger(values: FloatArray, needs: list[list[VectorNeed]], value: Any) -> FloatArray:
    """Return the larger of the planes' values [rad] and the vector's; NaN is propagated."""
    return np.asarray(np.maximum(values, [[value(one) for one in row] for row in needs]))
