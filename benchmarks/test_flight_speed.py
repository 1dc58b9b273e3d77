"""Closed-loop flights with limits, beside one call of a solver for each."""

from typing import Any

import numpy as np
import pytest
from peers import ratio
from scipy.integrate import solve_ivp

import tvclin as tv
from tvclin.kernels.choice import pinned

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


def error_of_the_peak() -> float:
    """Beside scipy's solver at its tightest."""
    exact = solve_ivp(
        rates, (0.0, STOP), np.zeros(4), method="DOP853", max_step=0.01, rtol=1e-12, atol=1e-14
    )
    law = tv.SaturatedLaw(GAINS)
    options = {"deflection_limit": LIMIT, "rate_limit": RATE, "actuator": SERVO, "until": STOP}
    flown = tv.fly_many(PLANT, law, WIND, **options)
    return float(abs(flown.final_attitude - exact.y[0, -1]) / flown.peak_attitude)


def flights(cases: tuple[tv.Plant, tv.History, Any], law: Any, **options: Any) -> Any:
    plant, wind, limit = cases
    with pinned(True):
        return tv.fly_many(plant, law, wind, deflection_limit=limit, until=STOP, **options)


FLOOR = "short steps until the nozzle has ceased to swing; roots where limits are met"


def test_all_limits_and_an_actuator_beside_lsoda(benchmark: Any) -> None:
    cases, hardware = dispersed(MANY), {"rate_limit": RATE, "actuator": SERVO}
    ratio(
        benchmark,
        lambda: flights(cases, tv.SaturatedLaw(GAINS), **hardware),
        lambda: lsoda(rtol=1e-6, atol=1e-9),
        peer_name="solve_ivp LSODA, rtol 1e-6",
        per=MANY,
        floor=FLOOR,
    )
    benchmark.extra_info["error"] = error_of_the_peak()


def test_all_limits_and_an_actuator_beside_python_control(benchmark: Any) -> None:
    import control

    system, times = control_system(), np.linspace(0.0, STOP, 2401)
    cases, hardware = dispersed(MANY), {"rate_limit": RATE, "actuator": SERVO}
    ratio(
        benchmark,
        lambda: flights(cases, tv.SaturatedLaw(GAINS), **hardware),
        lambda: control.input_output_response(system, times, 0.0, np.zeros(4)),
        peer_name="control.input_output_response, 2401 times",
        per=MANY,
        floor=FLOOR,
    )
    benchmark.extra_info["error"] = error_of_the_peak()


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
        floor="one flight after the other, without vector instructions",
    )
