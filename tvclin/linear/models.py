"""The names of the linear models, and which of them a vehicle has.

`tvclin.linear.plant` says what each of them is.
"""

from __future__ import annotations

import numpy as np

from tvclin.base.errors import instance
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.linear_vehicle import FIXED_PATH, AnyVehicle, LinearVehicle, coefficients_of

USUAL_MODEL = "drift-exact"
"""The model where none is named: the path as it moves, without an approximation."""
MODELS = (FIXED_PATH, "drift", USUAL_MODEL, "drift-and-speed")
ONE_POLE = (FIXED_PATH, "drift")
"""Models that leave the slow mode of the flight path out."""


def available_models(coefficients: Coefficients) -> list[str]:
    """Return the models that exist for these coefficients: (B8) needs an aerodynamic moment."""
    instance("coefficients", coefficients, Coefficients, "see Coefficients.from_vehicle")
    without_moment = np.any(np.asarray(coefficients.mu_alpha) == 0.0)
    return [name for name in MODELS if name != "drift" or not without_moment]


def usual_model(known: AnyVehicle | Coefficients) -> str:
    """Return the model where none is named: `USUAL_MODEL`, or of an unknown path "fixed-path".

    The path of `Coefficients` is unknown where C1, C2, b1, b2 and q are all zero.
    """
    if isinstance(known, LinearVehicle):
        return USUAL_MODEL if known.path_known else FIXED_PATH
    if isinstance(known, Coefficients):
        path = (known.C1, known.C2, known.b1, known.b2, known.q)
        return USUAL_MODEL if any(np.any(one) for one in path) else FIXED_PATH
    return USUAL_MODEL


def flexible_model(vehicle: AnyVehicle, model: str) -> str:
    """Return the model that a vehicle flies: "drift" is "drift-exact" where it bends or sloshes."""
    return USUAL_MODEL if model == "drift" and vehicle.structure is not None else model


def models_of(vehicle: AnyVehicle) -> list[str]:
    """Return the models that exist for a vehicle, with what is known of it."""
    if isinstance(vehicle, LinearVehicle) and not vehicle.path_known:
        return [FIXED_PATH]
    return available_models(coefficients_of(vehicle))
