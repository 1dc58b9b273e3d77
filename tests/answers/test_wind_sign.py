"""What a head and a tail wind need, beside integration and flights of the nonlinear equations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tvclin as tv
from tvclin.answers.wind_sign import pressure_ratio, signed_need
from tvclin.flights.condition import load_flight_condition

PULSES = {"triangular": tv.TriangularWind, "rectangular": tv.RectangularWind}


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("shape", PULSES)
def test_a_limit_held_from_the_onset_leaves_nothing_that_grows(configuration_i, shape, sign):
    """Theta'' = beta^2 r (theta - alpha_w) - (beta^2/B) delta, with r = q/q_n, to the end.

    The growing part then, theta' + beta (theta - delta/B), is linear in delta. Between its rows
    the engine interpolates r to about 1e-5.
    """
    wind = PULSES[shape](peak=sign * np.radians(5), duration=7.5)
    c = tv.Coefficients.from_vehicle(configuration_i)
    V, path = float(configuration_i.velocity), float(configuration_i.attitude)

    def ratio(angle):
        blows = V * np.sin(angle) / np.sin(path + angle)  # horizontal, from behind
        return ((V * np.cos(path) - blows) ** 2 + (V * np.sin(path)) ** 2) / V**2

    def rates(t, x, delta):
        angle = float(wind(t))
        return [x[1], c.beta**2 * (ratio(angle) * (x[0] - angle) - delta / c.B)]

    def grows(delta: float) -> float:
        state = np.zeros(2)
        for half in ((0.0, 3.75), (3.75, np.nextafter(7.5, 0.0))):
            state = solve_ivp(rates, half, state, args=(delta,), rtol=1e-11, atol=1e-14).y[:, -1]
        return float(state[1] + c.beta * (state[0] - delta / c.B))

    zero, one = grows(0.0), grows(1.0)
    held = abs(zero / (zero - one))
    assert signed_need(configuration_i, wind, "fixed-path", 0.0) == pytest.approx(held, rel=1e-4)


@pytest.mark.parametrize("name", ["configuration-i", "configuration-ii"])
def test_head_and_tail_winds_need_what_flights_need(name) -> None:
    """Of flights along the nominal trajectory, over that of a small wind of either sign.

    They also vary mass, speed and path, and trim by the B of calm air: within two percent.
    """
    vehicle, condition = tv.load_vehicle(name).rigid, load_flight_condition(name)
    plant = tv.Plant.from_vehicle(vehicle, "drift-exact")

    def flown(deg: float) -> float:
        wind = tv.TriangularWind(peak=np.radians(deg), duration=7.5)
        middle = wind.shift(float(vehicle.time) - 3.75)
        given = {"frozen": False, "condition": condition, "tolerance": 1e-3, "highest": 4.0}
        return abs(tv.flown_boundary(vehicle, middle, **given).deflection) / abs(deg)

    def said(deg: float) -> float:
        wind = tv.TriangularWind(peak=np.radians(deg), duration=7.5)
        frozen = abs(tv.boundary_limit(plant, wind, switch="literal").deflection)
        return signed_need(vehicle, wind, "drift-exact", 1.0) / frozen

    small = flown(0.05)
    for deg in (-5.0, 5.0):
        assert said(deg) == pytest.approx(flown(deg) / small, rel=0.02)


def test_the_dynamic_pressure_is_that_of_the_air_met(configuration_i) -> None:
    """Straight up a wind of either sign adds to the speed: 1/cos(alpha_w)^2."""
    up = configuration_i.replace(attitude=np.pi / 2)
    angles = np.radians([-5.0, 5.0])
    np.testing.assert_allclose(pressure_ratio(up, angles), 1.0 / np.cos(angles) ** 2, rtol=1e-12)
    head, tail = pressure_ratio(configuration_i, angles)
    assert head > 1.0 > tail
    with pytest.raises(tv.InputError, match="no horizontal wind turns it so far"):
        pressure_ratio(configuration_i.replace(attitude=np.radians(3.0)), angles)
