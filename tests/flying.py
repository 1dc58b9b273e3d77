"""The vehicle, the wind, the actuators and the laws that the tests of flights share."""

import numpy as np

import tvclin as tv
from tvclin import Actuator, Autopilot, Coefficients, Plant, SampledWind

PEAK = 0.08
COEFFICIENTS = Coefficients.from_vehicle(tv.load_vehicle("configuration-i"))
BETA, B = float(COEFFICIENTS.beta), float(COEFFICIENTS.B)
WIND = SampledWind(
    time=[0.013, 2.0, 7.577, 7.577, 11.0], angle=PEAK * np.array([0, 0.3, 1, 0.8, 0])
)
GAINS = {"attitude_gain": 3 * B, "rate_gain": 3 * B / BETA}
MORE = {"alpha_gain": 0.03, "integral_gain": 0.02}
SERVO, LAG = Actuator(natural_frequency=20.0), Actuator(natural_frequency=8.0, damping=None)
LAWS = {
    "gains": lambda plant: tv.SaturatedLaw(Autopilot(**GAINS)),
    "all gains": lambda plant: tv.SaturatedLaw(Autopilot(**GAINS, **MORE)),
    "trim": lambda plant: tv.TrimLaw(plant_of(), gain=4.0),
    "lean": lambda plant: tv.RecoverableAttitudeLaw(plant, gain=5.0, design_peak=PEAK),
    "estimated": lambda plant: tv.RecoverableAttitudeLaw(
        plant, reach=0.7, gain=4.0, estimator=tv.control.WindEstimator(bandwidth=6.0)
    ),
}


def plant_of(model="fixed-path", coefficients=COEFFICIENTS):
    return Plant.from_coefficients(coefficients, model)
