"""Closed-loop flights with limits, beside one call of a solver for each."""

from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from peers import ratio
from scipy.integrate import solve_ivp

import tvclin as tv

PEAK, DURATION, STOP = 0.08, 12.0, 24.0
MANY, FEW = 4096, 1024
C = tv.Coefficients.from_vehicle(tv.load_vehicle("configuration-i"))
B, BETA = float(C.B), float(C.beta)
SERVO = tv.Actuator(natural_frequency=25.1, damping=0.7)
LIMIT, RATE = 1.25 * B * PEAK, 0.02
GAINS = tv.Autopilot(attitude_gain=3 * B, rate_gain=3 * B / BETA)
WIND = tv.TriangularWind(peak=PEAK, duration=DURATION)
PLANT = tv.Plant.from_coefficients(C)


def rates(t: float, y: Any) -> list[float]:
    """The nominal flight, in plain Python: the quickest that a solver can be given."""
    wind = max(0.0, PEAK * (1.0 - abs(2.0 * t / DURATION - 1.0)))
    asked = GAINS.attitude_gain * y[0] + GAINS.rate_gain * y[1]
    command = min(max(asked, -LIMIT), LIMIT)
    w = SERVO.natural_frequency
    pull = w * w * (command - y[2]) - 2.0 * SERVO.damping * w * y[3]
    if abs(y[3]) >= RATE and pull * y[3] > 0.0:
        pull = 0.0
    deflection = min(max(y[2], -LIMIT), LIMIT)
    turn = C.mu_alpha * (y[0] - wind) - C.mu_delta * deflection
    return [y[1], turn, min(max(y[3], -RATE), RATE), pull]


def lsoda(**options: float) -> Any:
    return solve_ivp(rates, (0.0, STOP), np.zeros(4), method="LSODA", max_step=0.5, **options)


def control_system() -> Any:
    import control

    def update(t: float, x: Any, u: Any, params: Any) -> list[float]:
        return rates(t, x)

    return control.NonlinearIOSystem(
        update, lambda t, x, u, params: x[0], inputs=1, outputs=1, states=4
    )


def dispersed(cases: int) -> tuple[tv.Plant, tv.History, Any]:
    factors = np.random.default_rng(1).uniform(0.97, 1.03, (4, cases))
    coefficients = tv.Coefficients(
        mu_alpha=C.mu_alpha * factors[0], mu_delta=C.mu_delta * factors[1]
    )
    wind = tv.TriangularWind(peak=PEAK * factors[2], duration=DURATION)
    return tv.Plant.from_coefficients(coefficients), wind, LIMIT * factors[3]


@lru_cache
def exact() -> Any:
    """The attitude by scipy's solver at its tightest, as a function of the time."""
    options = {"method": "DOP853", "max_step": 0.01, "rtol": 1e-12, "atol": 1e-14}
    return solve_ivp(rates, (0.0, STOP), np.zeros(4), dense_output=True, **options).sol


def off(times: Any, attitude: Any) -> str:
    """Say how far an attitude is off, over the largest."""
    true = exact()(np.atleast_1d(times))[0]
    largest = np.abs(exact()(np.linspace(0.0, STOP, 2401))[0]).max()
    return f"off by {np.max(np.abs(attitude - true)) / largest:.0e}"


def floor(**options: Any) -> str:
    options |= {"deflection_limit": LIMIT, "rate_limit": RATE, "actuator": SERVO, "until": STOP}
    flown = tv.fly_many(PLANT, tv.SaturatedLaw(GAINS), WIND, **options)
    ends = off(STOP, flown.final_attitude)
    return f"short steps until the nozzle has ceased to swing; roots at limits; {ends}"


def flights(cases: tuple[tv.Plant, tv.History, Any], law: Any, **options: Any) -> Any:
    plant, wind, limit = cases
    return tv.fly_many(plant, law, wind, deflection_limit=limit, until=STOP, **options)


@pytest.mark.parametrize("rtol", [1e-6, 1e-8])
def test_all_limits_and_an_actuator_beside_lsoda(benchmark: Any, rtol: float) -> None:
    cases, hardware = dispersed(MANY), {"rate_limit": RATE, "actuator": SERVO}
    peer = lsoda(rtol=rtol, atol=1e-3 * rtol)
    ratio(
        benchmark,
        lambda: flights(cases, tv.SaturatedLaw(GAINS), **hardware),
        lambda: lsoda(rtol=rtol, atol=1e-3 * rtol),
        peer_name=f"solve_ivp LSODA, {off(peer.t, peer.y[0])}",
        per=MANY,
        floor=floor(),
    )


@pytest.mark.parametrize("rtol", [1e-3, 3e-7], ids=["as it is", "3e-7"])
@pytest.mark.parametrize("accuracy", [1e-8, 2e-7])
def test_all_limits_and_an_actuator_beside_python_control(
    benchmark: Any, accuracy: float, rtol: float
) -> None:
    import control

    system, times = control_system(), np.linspace(0.0, STOP, 2401)
    cases, hardware = dispersed(MANY), {"rate_limit": RATE, "actuator": SERVO}

    def peer() -> Any:
        tight = {"solve_ivp_kwargs": {"rtol": rtol, "atol": min(1e-6, 1e-3 * rtol)}}
        return control.input_output_response(system, times, 0.0, np.zeros(4), **tight)

    ratio(
        benchmark,
        lambda: flights(cases, tv.SaturatedLaw(GAINS), accuracy=accuracy, **hardware),
        peer,
        peer_name=f"control.input_output_response, 2401 times, {off(times, peer().outputs)}",
        per=MANY,
        floor=floor(accuracy=accuracy),
    )


@pytest.mark.parametrize("name", ["dead band", "lean", "sampled"])
def test_other_flights_beside_lsoda(benchmark: Any, name: str) -> None:
    lean = tv.RecoverableAttitudeLaw(PLANT, design_peak=PEAK)
    laws = {
        "dead band": (MANY, tv.DeadBandLaw(PLANT), {}),
        "lean": (FEW, lean, {"actuator": SERVO}),
        "sampled": (FEW, tv.TrimLaw(PLANT), {"sample_rate": 100.0, "actuator": SERVO}),
    }
    count, law, options = laws[name]
    cases = dispersed(count)
    ratio(
        benchmark,
        lambda: flights(cases, law, **options),
        lambda: lsoda(rtol=1e-6, atol=1e-9),
        peer_name="solve_ivp LSODA of gains, rtol 1e-6",
        per=count,
        floor="steps of the series" if name == "dead band" else "one flight after the other",
    )
