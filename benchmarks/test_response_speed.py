"""How fast exact responses are where users ask for them, one and many, and how exact.

All are of the report's control, trim and then the limit; with drift, trim is not straight between
its knots. The peers get every input on the grid, sampled beforehand.
"""

from itertools import pairwise
from typing import Any

import control
import mpmath as mp
import numpy as np
import pytest
from peers import ratio
from scipy import signal

import tvclin as tv
from tvclin.kernels.choice import VARIABLE

POINTS, WINDS, VEHICLES = 499, 10_000, 2_500
TIMES = np.linspace(0.0, 20.0, POINTS)
PEAK, DURATION = 0.09, 7.5
SHARE = 0.5
"""The limit, over that of trim at the peak: below the boundary, so that the attitude grows."""


def coefficients() -> tv.Coefficients:
    return tv.Coefficients.from_vehicle(tv.load_vehicle("configuration-i"))


def case(model: str, peak: Any = PEAK, duration: Any = DURATION, spread: Any = 1.0) -> tuple:
    """Plant, control and wind; `spread` disperses the aerodynamic moment of the vehicle."""
    c = coefficients()
    plant = tv.Plant(c.replace(mu_alpha=c.mu_alpha * spread), model)
    wind = tv.TriangularWind(peak=peak, duration=duration)
    limit = -SHARE * np.asarray(plant.coefficients.B) * peak
    return plant, tv.trim_then_hold(plant, wind, limit), wind


def sampled(
    plant: tv.Plant, deflection: tv.winds.History, wind: tv.winds.History
) -> tuple[Any, np.ndarray]:
    return plant.ss(), np.stack([deflection(TIMES), wind(TIMES)])


def exact(plant: tv.Plant, inputs: tuple[tv.winds.History, tv.winds.History], t: float) -> float:
    """The attitude at one time: of each mode, the integral of e^(p (t - v)) f(v) to 30 digits."""
    with mp.workdps(30):
        denominator, total = [mp.mpf(float(a)) for a in plant.denominator], mp.mpf(0)
        for name, history in zip(("deflection", "wind"), inputs, strict=True):
            numerator = [mp.mpf(float(a)) for a in plant.numerator("attitude", name)]
            edges = [*(float(k) for k in history.knots if k < t), t]
            for p in mp.polyroots(denominator, maxsteps=200, extraprec=100):
                gain = mp.polyval(numerator, p) / mp.diff(lambda s: mp.polyval(denominator, s), p)
                for i, ends in enumerate(pairwise(edges)):
                    total += gain * mp.quad(_discounted(history, i, p, t), ends)
        return float(mp.re(total))


def _discounted(history: tv.winds.History, i: int, p: Any, t: float) -> Any:
    """One piece times e^(p (t - v)), as a function of the time v."""
    start, rates = history.knots[i], history.pieces.rates
    rows = [[mp.mpf(c) for c in row[::-1]] for row in history.pieces.coefficients[i]]
    return lambda v: (
        mp.exp(p * (t - v))
        * sum(
            mp.polyval(row, v - start) * mp.exp(mp.mpf(rate) * (v - start))
            for row, rate in zip(rows, rates, strict=True)
        )
    )


def digits(found: float, expected: float) -> str:
    error = abs(found / expected - 1.0)
    return f"{min(16.0, -np.log10(error)) if error else 16.0:.1f} digits"


@pytest.mark.parametrize("model", ["fixed-path", "drift", "drift-exact"])
@pytest.mark.parametrize("what", ["arrays", "TimeResponseData"])
def test_one_response(benchmark: Any, what: str, model: str) -> None:
    plant, deflection, wind = case(model)
    system, inputs = sampled(plant, deflection, wind)
    matrices = (system.A, system.B, system.C, system.D)
    ours = {
        "arrays": lambda: tv.attitude_responses(plant, deflection, wind, TIMES).outputs,
        "TimeResponseData": lambda: tv.attitude_response(plant, deflection, wind, TIMES),
    }
    expected = exact(plant, (deflection, wind), TIMES[-1])
    peer = signal.lsim(matrices, inputs.T, TIMES)[1][-1, 0]
    mine = tv.attitude_responses(plant, deflection, wind, TIMES)["attitude"][-1]
    ratio(
        benchmark,
        ours[what],
        lambda: signal.lsim(matrices, inputs.T, TIMES),
        peer_name=f"scipy.signal.lsim, {digits(peer, expected)}",
        floor=f"{digits(mine, expected)}; calls from Python",
    )


def batches() -> dict[str, tuple]:
    rng = np.random.default_rng(0)
    peaks, durations = PEAK * rng.uniform(0.5, 1.5, WINDS), rng.uniform(3.0, 9.0, WINDS)
    return {
        "many winds": case("fixed-path", peaks, durations),
        "many winds, drift": case("drift", peaks, durations),
        "many vehicles, drift-exact": case("drift-exact", spread=rng.uniform(0.8, 1.2, VEHICLES)),
    }


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("outputs", [("attitude",), None], ids=["attitude", "all outputs"])
@pytest.mark.parametrize("name", ["many winds", "many winds, drift", "many vehicles, drift-exact"])
def test_many_responses(
    benchmark: Any,
    name: str,
    outputs: tuple[str, ...] | None,
    threads: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv(VARIABLE, str(threads))
    plant, deflection, winds = batches()[name]
    one, held, wind = case(plant.model)
    system, inputs = sampled(one, held, wind)
    system = system[list(outputs), :] if outputs else system
    expected = exact(one, (held, wind), TIMES[-1])
    peer = control.forced_response(system, TIMES, inputs).outputs.reshape(-1, POINTS)[0, -1]
    mine = tv.attitude_responses(one, held, wind, TIMES)["attitude"][-1]

    def ours() -> Any:
        fresh = tv.Plant(plant.coefficients, plant.model)  # its poles count too
        return tv.attitude_responses(fresh, deflection, winds, TIMES, outputs).outputs

    ratio(
        benchmark,
        ours,
        lambda: control.forced_response(system, TIMES, inputs),
        peer_name=f"control.forced_response, {digits(peer, expected)}",
        per=VEHICLES if "vehicles" in name else WINDS,
        floor=f"{digits(mine, expected)}; knots, modes and polynomials of each case, fresh memory",
    )
