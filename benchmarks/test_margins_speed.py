"""Margins of ten thousand dispersed loops of order 6, beside a loop over python-control's."""

import control
import numpy as np
import pytest
from peers import ratio

import tvclin as tv

CASES, OF_PEER = 10_000, 50
OMEGA = np.geomspace(1e-3, 1e3, 500)


def dispersed(delays):
    """Return the loops of attitude, rate and integral feedback around dispersed vehicles."""
    rng = np.random.default_rng(0)
    spread = 1.0 + 0.1 * rng.standard_normal((6, CASES))
    c = tv.Coefficients(
        mu_alpha=0.28 * spread[0],
        mu_delta=2.6 * spread[1],
        C1=0.049 * spread[2],
        C2=0.0036,
        b1=0.03 * spread[3],
        b2=0.0284,
        q=0.0005,
    )
    autopilot = tv.Autopilot(
        attitude_gain=0.5,
        rate_gain=0.55,
        integral_gain=0.02,
        actuator=tv.Actuator(natural_frequency=25.1 * spread[4], damping=0.7 * spread[5]),
        delay=rng.choice(delays, CASES),
    )
    return autopilot.rational_loop(tv.Plant(c, "drift"))


def systems(loop):
    """Return the first loops for python-control, without their delays."""
    return [control.tf(*pair) for pair in zip(loop.numerator, loop.denominator, strict=True)][
        :OF_PEER
    ]


@pytest.mark.parametrize("delays", [[0.0], [0.0, 0.02, 0.04]], ids=["no delay", "some delayed"])
def test_margins(benchmark, delays):
    loop = dispersed(delays)
    some = systems(loop.take(range(OF_PEER)))
    ratio(
        benchmark,
        lambda: tv.control.loop_margins(loop),
        lambda: [control.margin(one) for one in some],
        peer_name="control.margin in a loop, without delay",
        per=CASES,
        peer_per=OF_PEER,
        floor="eight hundred frequencies for each loop; roots of five polynomials",
    )


def test_margins_beside_those_of_a_disk_too(benchmark):
    loop = dispersed([0.0])
    some = systems(loop.take(range(OF_PEER)))

    def peer():
        for one in some:
            control.margin(one)
            control.disk_margins(one, OMEGA)

    ratio(
        benchmark,
        lambda: tv.control.loop_margins(loop),
        peer,
        peer_name="control.margin and disk_margins in a loop",
        per=CASES,
        peer_per=OF_PEER,
        floor="the same",
    )
