"""The engine as it is used here, against published check cases and closed forms.

The cases are 2 and 8 of "Check-Cases for Verification of 6-Degree-of-Freedom Flight Vehicle
Simulations", NASA/TM-2015-218675; the rows are those of simulation 04.
"""

from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
import pytest
from scipy.special import ellipj, ellipkinc

from tvclin.base.units import FOOT, SLUG
from tvclin.flights.sixdof.airframe import Engine
from tvclin.flights.sixdof.model import mass_balance

pytest.importorskip("jsbsim")

EARTH_RATE = 7.292115e-5  # rad/s
BRICK = (0.00189422, 0.006211019, 0.007194665)  # slug ft^2
BALL_AREA, BALL_DRAG = 0.1963495, 0.1  # ft^2, C_D
TUMBLING = {  # s: body rates against inertial space deg/s, altitude ft
    10.0: ((-2.41890222177, -23.5525695195, 28.12859263), 28400.2040727),
    30.0: ((12.6183907757, -17.3974747619, 31.1195888868), 15598.9043522),
}
BLOWN = {  # s: altitude ft, longitude deg, speeds towards east and down ft/s
    10.0: (28408.5918443, 1.32628349529e-5, 1.31363488975, 316.737198488),
    30.0: (16290.9978743, 2.73579667279e-4, 8.73099985197, 863.694253332),
}


def body(mass, inertias, drag_area=0.0):
    """Return the XML of a body of a mass in slugs, inertias in slug ft^2 and S C_D in ft^2."""
    root = Element("fdm_config", name="body", version="2.0")
    SubElement(root, "metrics")
    mass_balance(root, mass * SLUG, tuple(i * SLUG * FOOT**2 for i in inertias))
    SubElement(root, "ground_reactions")
    aerodynamics = SubElement(root, "aerodynamics")
    SubElement(aerodynamics, "axis", name="ROLL")
    drag = SubElement(SubElement(aerodynamics, "axis", name="DRAG"), "function", name="drag")
    product = SubElement(drag, "product")
    SubElement(product, "property").text = "aero/qbar-psf"
    SubElement(product, "value").text = repr(drag_area)
    return tostring(root, encoding="unicode")


def tumbling(step):
    """Return the engine of case 2, and what reads its body rates against inertial space."""
    initial = {
        "h-sl-ft": 30000.0,
        "p-rad_sec": np.radians(10.0) - EARTH_RATE,  # those of the case are inertial, x is north
        "q-rad_sec": np.radians(20.0),
        "r-rad_sec": np.radians(30.0),
    }
    engine = Engine(body(0.155404754, BRICK), initial, step)
    readers = [engine.reader(f"velocities/{axis}i-rad_sec") for axis in "pqr"]
    return engine, lambda: np.degrees([read() for read in readers])


def advance(engine, steps):
    for _ in range(steps):
        engine.run()


def test_a_tumbling_brick_turns_and_falls_as_published():
    engine, rates = tumbling(0.001)
    altitude, before = engine.reader("position/h-sl-ft"), 0.0
    for time, (published, height) in TUMBLING.items():
        advance(engine, round((time - before) * 1000))
        before = time

        np.testing.assert_allclose(rates(), published, atol=1e-4)
        assert altitude() == pytest.approx(height, abs=1e-3)


def test_a_tumbling_brick_turns_as_a_free_body_does():
    """Euler's solution by Jacobi's functions; the error falls with the square of the step."""
    errors = []
    for step in (0.01, 0.005):
        engine, rates = tumbling(step)
        advance(engine, round(10.0 / step))
        errors.append(np.abs(rates() - np.degrees(free_rates(np.radians([10, 20, 30]), 10.0))))

    assert errors[1].max() < 4e-4
    assert np.log2(errors[0].max() / errors[1].max()) == pytest.approx(2.0, abs=0.1)


def free_rates(rates, time):
    """Return the rates of a free body with inertias `BRICK`, for L^2 > 2 T I2."""
    I1, I2, I3 = BRICK
    energy, momentum = (np.dot(np.power(BRICK, n), rates**2) for n in (1, 2))
    low, high = energy * I3 - momentum, momentum - energy * I1
    m = (I2 - I1) * low / ((I3 - I2) * high)
    pace = np.sqrt((I3 - I2) * high / (I1 * I2 * I3))
    across = np.sqrt(low / (I2 * (I3 - I2)))
    sn, cn, dn, _ = ellipj(ellipkinc(np.arcsin(rates[1] / across), m) + pace * time, m)
    return np.sqrt(low / (I1 * (I3 - I1))) * cn, across * sn, np.sqrt(high / (I3 * (I3 - I1))) * dn


def test_a_falling_sphere_is_blown_away_as_published():
    """A wind towards east that falls with the altitude, set before each step, moves the ball."""
    engine = Engine(body(1.0, (3.6, 3.6, 3.6), BALL_AREA * BALL_DRAG), {"h-sl-ft": 30000.0}, 0.01)
    blow, height = engine.writer("atmosphere/wind-east-fps"), engine.reader("position/geod-alt-ft")
    names = ("position/long-gc-deg", "velocities/v-east-fps", "velocities/v-down-fps")
    readers, steps = [height, *(engine.reader(name) for name in names)], 0
    for time, published in BLOWN.items():
        while steps < time * 100:
            blow(0.003 * height() - 20.0)
            engine.run()
            steps += 1

        np.testing.assert_allclose([read() for read in readers], published, rtol=5e-4)
        assert height() == pytest.approx(published[0], abs=0.01)
