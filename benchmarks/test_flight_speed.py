"""Closed-loop flights with limits at 100 Hz, beside one call of a solver for each."""

from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from peers import ratio
from scipy.integrate import solve_ivp

import tvclin as tv

PEAK, DURATION, STOP = 0.08, 12.0, 24.0
MANY, RATE_HZ = 1024, 100.0
C = tv.Coefficients.from_vehicle(tv.load_vehicle("configuration-i"))
B, BETA = float(C.B), float(C.beta)
SERVO = tv.Actuator(natural_frequency=25.1, damping=0.7)
LIMIT, RATE = 1.25 * B * PEAK, 0.02
GAINS = tv.Autopilot(attitude_gain=3 * B, rate_gain=3 * B / BETA)
WIND = tv.TriangularWind(peak=PEAK, duration=DURATION)
PLANT = tv.Plant(C, "fixed-path")


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


def dispersed(cases: int) -> tuple[tv.Plant, tv.winds.History, Any]:
    factors = np.random.default_rng(1).uniform(0.97, 1.03, (4, cases))
    coefficients = tv.Coefficients(
        mu_alpha=C.mu_alpha * factors[0], mu_delta=C.mu_delta * factors[1]
    )
    wind = tv.TriangularWind(peak=PEAK * factors[2], duration=DURATION)
    return tv.Plant(coefficients, "fixed-path"), wind, LIMIT * factors[3]


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


def flights(cases: tuple[tv.Plant, tv.winds.History, Any], law: Any, **options: Any) -> Any:
    plant, wind, limit = cases
    options = {"deflection_limit": limit, "sample_rate": RATE_HZ, "until": STOP} | options
    return tv.fly_many(plant, law, wind, **options)


def sampled_floor() -> str:
    """Say how far the flight is from one whose law is computed without pause, which is the rate."""
    options = {"deflection_limit": LIMIT, "rate_limit": RATE, "actuator": SERVO, "until": STOP}
    law = tv.SaturatedLaw(GAINS)
    flown = [
        tv.fly_many(PLANT, law, WIND, sample_rate=rate, **options).final_attitude
        for rate in (RATE_HZ, 10.0 * RATE_HZ)
    ]
    apart = f"{off(STOP, flown[0])} at 100 Hz, {off(STOP, flown[1])} at 1 kHz"
    return f"one sample after the other; {apart}"


@pytest.mark.parametrize("rtol", [1e-6, 1e-8])
def test_all_limits_and_an_actuator_beside_lsoda(benchmark: Any, rtol: float) -> None:
    cases, hardware = dispersed(MANY), {"rate_limit": RATE, "actuator": SERVO}
    peer = lsoda(rtol=rtol, atol=1e-3 * rtol)
    ratio(
        benchmark,
        lambda: flights(cases, tv.SaturatedLaw(GAINS), **hardware),
        lambda: lsoda(rtol=rtol, atol=1e-3 * rtol),
        peer_name=f"solve_ivp LSODA without samples, {off(peer.t, peer.y[0])}",
        per=MANY,
        floor=sampled_floor(),
    )


def test_all_limits_and_an_actuator_beside_python_control(benchmark: Any) -> None:
    import control

    system, times = control_system(), np.linspace(0.0, STOP, 2401)
    cases, hardware = dispersed(MANY), {"rate_limit": RATE, "actuator": SERVO}

    def peer() -> Any:
        return control.input_output_response(system, times, 0.0, np.zeros(4))

    ratio(
        benchmark,
        lambda: flights(cases, tv.SaturatedLaw(GAINS), **hardware),
        peer,
        peer_name=f"control.input_output_response, 2401 times, {off(times, peer().outputs)}",
        per=MANY,
        floor=sampled_floor(),
    )


@pytest.mark.parametrize("name", ["trim", "dead band", "lean", "lean with drift"])
def test_other_laws_beside_lsoda(benchmark: Any, name: str) -> None:
    plant, wind, limit = dispersed(MANY)
    drift = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
    laws = {
        "trim": (plant, tv.TrimLaw(PLANT)),
        "dead band": (plant, tv.control.DeadBandLaw(PLANT)),
        "lean": (plant, tv.RecoverableAttitudeLaw(PLANT, design_peak=PEAK)),
        "lean with drift": (drift, tv.RecoverableAttitudeLaw(drift, design_peak=PEAK)),
    }
    flies, law = laws[name]
    ratio(
        benchmark,
        lambda: flights((flies, wind, limit), law, actuator=SERVO),
        lambda: lsoda(rtol=1e-6, atol=1e-9),
        peer_name="solve_ivp LSODA of gains, rtol 1e-6",
        per=MANY,
        floor="one sample after the other",
    )


def test_the_boundary_of_a_law_beside_one_flight_of_lsoda_for_each_limit(benchmark: Any) -> None:
    """It flies some 250 limits; a bisection flies a dozen, and can miss a window of losses."""
    ratio(
        benchmark,
        lambda: tv.closed_loop_boundary(PLANT, tv.TrimLaw(PLANT), WIND, sample_rate=RATE_HZ),
        lambda: lsoda(rtol=1e-6, atol=1e-9),
        peer_name="solve_ivp LSODA, one of a dozen flights",
        floor="250 flights, of which survivors go on until they are calm",
    )


def test_the_card_of_a_flight(benchmark: Any) -> None:
    """25 flight times, three winds from ahead and from behind, with torque and power."""
    schedule = tv.load_schedule("configuration-i")
    engine = tv.vehicle.Engine(mass=1200.0, arm=1.35, moment_of_inertia=400.0)
    hinge = tv.case.NozzleData(engine=engine, stiffness=8e5, damping=1e4, friction=2000.0)
    nozzle = tv.Nozzle(limit=np.radians(1.0), rate_limit=np.radians(10.0), data=hinge)
    case = tv.Case(vehicle=schedule.vehicle, nozzle=nozzle)
    others = [("triangular", 4.0, 12.0), ("rectangular", 3.0, 4.0)]
    asked = tv.requirement.SizingRequest(
        schedule=schedule,
        others=tuple(tv.ShapedWind(shape, np.radians(deg), tau) for shape, deg, tau in others),
        start=50.0,
        stop=98.0,
        every=2.0,
    )
    found = benchmark(lambda: tv.nozzle.flight_duty(case, asked))
    assert len(found.points) == 150
