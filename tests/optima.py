"""Plants, winds and bare conditions that the tests of the minimum-peak control share."""

import numpy as np

import tvclin
from tvclin import Plant, TriangularWind
from tvclin.boundary.optimum.dual import best_multipliers
from tvclin.boundary.optimum.minimum_peak import certify
from tvclin.boundary.optimum.moments import Constraints, Window

NAMES = ("configuration-i", "configuration-ii")


def plant_of(name="configuration-i", model="drift-exact"):
    return Plant.from_vehicle(tvclin.load_vehicle(name), model)


def triangle(plant, tau_beta, peak=-0.1):
    return TriangularWind(peak=peak, duration=tau_beta / plant.coefficients.beta)


def solved(poles, demands, horizon=np.inf):
    """Return limit, switches and certificate of bare conditions, without a plant."""
    window = Window(Constraints(np.asarray(poles), np.asarray(demands, float), horizon))
    best = best_multipliers(window)
    return best, certify(window, best.multipliers, best.zeros, best.norm * best.signs[0])
