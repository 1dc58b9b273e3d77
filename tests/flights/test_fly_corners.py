"""Flights without pause of a nozzle at its limits, against an integration from corner to corner."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tvclin as tv
from tests.turns import usual
from tvclin import Actuator, Plant, TriangularWind

PEAK = np.radians(5.0)
PLANT = Plant.from_vehicle(tv.load_vehicle("configuration-i"), "fixed-path")
GAINS = tv.design_gains(PLANT.coefficients, natural_frequency=1.2, damping=0.7)
WIND = TriangularWind(peak=PEAK, duration=8.0)
TIMES = np.linspace(0.5, 15.0, 59)


def rising(function):
    function.terminal, function.direction = True, 1.0
    return function


def corners(now, limit, most, order, demand, pull):
    """Return what rises through zero where a part of the regime changes, and that change."""
    rate = pull if order == 1 else (lambda y: y[3])
    quantities = {
        "command": (demand, demand, limit, limit),
        "rate": (rate, pull, most, most if order == 1 else 0.0),
        "stop": (lambda y: y[2], lambda y: y[2], limit * (1.0 + 1e-12), limit),
    }
    events, changes = [], []
    for what, (enters, leaves, above, below) in quantities.items():
        for side in (1, -1):
            if now[what] == 0:
                events.append(rising(lambda t, y, f=enters, s=side, b=above: s * f(y) - b))
                changes.append((what, side))
            elif now[what] == side:
                events.append(rising(lambda t, y, f=leaves, s=side, b=below: b - s * f(y)))
                changes.append((what, 0))
    return events, changes


def from_corner_to_corner(limit, most, actuator, times=TIMES):
    """Return attitude and rate, and how often the stop was hit.

    Command, rate and stop are each free or held on one side; all is linear from one change to the
    next, where a new integration begins.
    """
    A, inputs, _, _ = PLANT.matrices()
    w, zeta = float(actuator.natural_frequency), actuator.damping
    order = 1 if zeta is None else 2
    y, held = np.zeros(2 + order), {"command": 0, "rate": 0, "stop": 0}
    runs, starts, stops = [], [], 0
    knots = np.unique([*WIND.knots[WIND.knots < times[-1]], times[-1]])

    def demand(y):
        return GAINS.attitude_gain * y[0] + GAINS.rate_gain * y[1]

    def pull(y, now):
        command = now["command"] * limit if now["command"] else demand(y)
        free = w * (command - y[2])
        return free if order == 1 else w * free - 2.0 * zeta * w * y[3]

    for first, last in pairwise(knots):
        wind = WIND([first, np.nextafter(last, first)])
        slope, t = (wind[1] - wind[0]) / (last - first), first
        while t < last:
            now = dict(held)

            def rates(t, y, now=now, start=wind[0], slope=slope, first=first):
                servo = [pull(y, now)] if order == 1 else [y[3], pull(y, now)]
                if now["rate"]:
                    servo = [now["rate"] * most, 0.0][:order]
                delta = now["stop"] * limit if now["stop"] else y[2]
                return [*(A @ y[:2] + inputs @ [delta, start + slope * (t - first)]), *servo]

            events, changes = corners(now, limit, most, order, demand, lambda y, n=now: pull(y, n))
            run = solve_ivp(
                rates, (t, last), y, "DOP853", rtol=3e-14, atol=1e-17, max_step=0.02,
                dense_output=True, events=events,
            )  # fmt: skip
            runs.append(run.sol)
            starts.append(t)
            t, y = run.t[-1], run.y[:, -1]
            if run.status == 1:
                what, side = next(c for c, e in zip(changes, run.t_events, strict=True) if e.size)
                held[what] = side
                stops += what == "stop" and side != 0
                if what == "rate" and side and order == 2:
                    y[3] = side * most
    index = np.searchsorted(starts, times, side="right") - 1
    return np.stack([runs[k](t)[:2] for k, t in zip(index, times, strict=True)], -1), stops


@pytest.mark.parametrize(
    ("part", "most", "actuator"),
    usual(
        [
            (1.1, 0.004, Actuator(natural_frequency=20.0, damping=0.7)),
            (1.2, 0.006, Actuator(natural_frequency=12.0, damping=0.6)),
            (1.5, 0.003, Actuator(natural_frequency=20.0, damping=0.7)),
            (1.1, 0.005, Actuator(natural_frequency=8.0, damping=None)),
        ],
        1,
    ),
)
def test_after_rate_limit_and_stop_a_flight_is_exact_as_stated(part, most, actuator):
    """To 1e-9 of the largest attitude, for many seconds and whether it is lost or not."""
    limit = part * PLANT.coefficients.B * PEAK
    expected, stops = from_corner_to_corner(limit, most, actuator)
    assert stops > 0 or actuator.damping is None
    flown = tv.fly(
        PLANT, tv.SaturatedLaw(GAINS), WIND, TIMES,
        deflection_limit=limit, rate_limit=most, actuator=actuator,
    )  # fmt: skip
    exact = 1e-9 * np.abs(expected[0]).max()
    np.testing.assert_allclose(flown.outputs[:2], expected, rtol=0, atol=exact)
