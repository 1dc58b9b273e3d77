"""Vehicles with damping of the attitude rate, and their pole written out by hand."""

import numpy as np

import tvclin as tv


def damped(name="configuration-i", damping=0.03):
    """Return a shipped vehicle with a damping M_q/I [1/s]."""
    vehicle = tv.load_vehicle(name)
    return vehicle.replace(pitch_damping=damping * vehicle.moment_of_inertia)


def plant_of(mu_alpha=0.28, damping=0.25, model="fixed-path", **others):
    """Return a plant of coefficients with a drift of about configuration I."""
    drift = {"C1": 0.025, "C2": 0.0036, "b1": 0.0284, "b2": 0.0169, "q": 1.7e-4}
    c = tv.Coefficients(mu_alpha=mu_alpha, mu_delta=2.6, damping=damping, **drift | others)
    return tv.Plant.from_coefficients(c, model)


def fast_pole(mu_alpha, damping):
    """Return the positive root of s^2 + d s - mu_alpha."""
    return float(np.roots([1.0, damping, -mu_alpha]).max())
