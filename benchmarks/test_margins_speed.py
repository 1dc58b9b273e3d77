"""Margins of thousands of dispersed loops of order 6, beside python-control's of one."""

import control
import numpy as np
import pytest
from peers import ratio

import tvclin as tv
from tvclin.kernels.loop_margins import classical_margins, loop_crossings
from tvclin.kernels.rational import Rational
from tvclin.kernels.threads import VARIABLE
from tvclin.margins import loop_margins

CASES, MANY = 5000, 40_000
OMEGA = np.geomspace(1e-3, 1e3, 500)


def dispersed(delays, count=CASES):
    """Return the loops of attitude, rate and integral feedback around dispersed vehicles."""
    rng = np.random.default_rng(0)
    spread = 1.0 + 0.1 * rng.standard_normal((6, count))
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
        delay=rng.choice(delays, count),
    )
    return autopilot.rational_loop(tv.Plant(c, "drift"))


def system(loop):
    """Return the first loop for python-control, without its delay."""
    return control.tf(np.trim_zeros(loop.numerator[0], "f"), loop.denominator[0])


@pytest.mark.parametrize("delays", [[0.0], [0.0, 0.02, 0.04]], ids=["no delay", "some delayed"])
def test_classical_margins(benchmark, delays):
    pytest.importorskip("numba")
    loop = dispersed(delays)
    rational = Rational(*(np.array(a) for a in (loop.numerator, loop.denominator, loop.delay)))
    one = system(loop)
    ratio(
        benchmark,
        lambda: classical_margins(loop_crossings(rational)),
        lambda: control.margin(one),
        peer_name="control.margin, without delay",
        per=CASES,
        floor="real roots of polynomials, sixteen searches side by side; then steps on L itself",
    )


@pytest.mark.parametrize("delays", [[0.0], [0.0, 0.02, 0.04]], ids=["no delay", "some delayed"])
def test_the_whole_record(benchmark, delays):
    pytest.importorskip("numba")
    loop = dispersed(delays)
    one = system(loop)

    def peer():
        control.margin(one)
        control.disk_margins(one, OMEGA)

    ratio(
        benchmark,
        lambda: loop_margins(loop),
        peer,
        peer_name="control.margin and disk_margins, without delay",
        per=CASES,
        floor="sizes of S and T between the roots",
    )


def test_two_threads_beside_one(benchmark, monkeypatch):
    pytest.importorskip("numba")
    loop = dispersed([0.0], MANY)

    def margins(threads):
        monkeypatch.setenv(VARIABLE, str(threads))
        loop_margins(loop)

    ratio(
        benchmark,
        lambda: margins(2),
        lambda: margins(1),
        peer_name="one thread",
        per=MANY,
        peer_per=MANY,
        floor="what is done before and after the kernels; one processor's neighbours",
    )
