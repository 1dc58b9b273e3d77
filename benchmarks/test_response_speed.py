"""How fast exact responses are, one and many.

The peers get a case they answer well: every input on the grid, sampled beforehand. What they
give is the answer to the samples; ours is exact between them.
"""

from typing import Any

import control
import numpy as np
import pytest
from peers import ratio
from scipy import signal

import tvclin as tv
from tvclin.kernels import responses
from tvclin.kernels.threads import VARIABLE

CASES = 10_000
POINTS = 499
BETA, B, PEAK, DURATION = 0.53, 0.107, 0.09, 7.5


def case() -> tuple[tv.Plant, tv.History, tv.History]:
    plant = tv.Plant(tv.Coefficients.from_beta(beta=BETA, B=B))
    wind = tv.TriangularWind(peak=PEAK, duration=DURATION)
    return plant, tv.HeldDeflection(limit=tv.boundary_limit(plant, wind, 0.0).deflection), wind


def sampled(points: int) -> tuple[Any, np.ndarray, np.ndarray]:
    plant, deflection, wind = case()
    times = np.linspace(0.0, 20.0, points)
    return plant.ss(), times, np.stack([deflection(times), wind(times)])


@pytest.mark.parametrize("points", [499, 4999])
@pytest.mark.parametrize("what", ["TimeResponseData", "arrays", "kernel"])
def test_one_response(benchmark: Any, what: str, points: int) -> None:
    plant, deflection, wind = case()
    system, times, inputs = sampled(points)
    matrices = (system.A, system.B, system.C, system.D)
    pieces = (deflection.pieces, wind.pieces)
    ours = {
        "TimeResponseData": lambda: tv.attitude_response(plant, deflection, wind, times),
        "arrays": lambda: tv.attitude_responses(plant, deflection, wind, times).outputs,
        "kernel": lambda: responses.responses(plant.modal, pieces, times, ()),
    }
    ratio(
        benchmark,
        ours[what],
        lambda: signal.lsim(matrices, inputs.T, times),
        peer_name="scipy.signal.lsim",
        floor="calls from Python: checks, and passing arrays to the compiled code",
    )


def batches() -> dict[str, tuple[tv.Plant, tv.History, tv.History]]:
    plant, deflection, wind = case()
    rng = np.random.default_rng(0)
    peaks, durations = PEAK * rng.uniform(0.5, 1.5, CASES), rng.uniform(3.0, 9.0, CASES)
    betas = BETA * rng.uniform(0.8, 1.2, CASES)
    winds = tv.TriangularWind(peak=peaks, duration=durations)
    plants = tv.Coefficients.from_beta(beta=betas, B=B * rng.uniform(0.8, 1.2, CASES))
    drifting = tv.Coefficients.from_vehicle(tv.load_vehicle("configuration-i"))
    return {
        "many winds, one plant": (plant, deflection, winds),
        "many plants, one wind": (tv.Plant(plants), deflection, wind),
        "many plants, each its wind": (tv.Plant(plants), deflection, winds),
        "many winds, one plant, drift-exact": (
            tv.Plant(drifting, "drift-exact"),
            deflection,
            winds,
        ),
    }


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("outputs", [("attitude",), None], ids=["attitude", "all outputs"])
@pytest.mark.parametrize("name", list(batches()))
def test_many_responses(
    benchmark: Any,
    name: str,
    outputs: tuple[str, ...] | None,
    threads: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv(VARIABLE, str(threads))
    plant, deflection, winds = batches()[name]
    system, times, inputs = sampled(POINTS)
    if plant.model != "fixed-path":
        system = plant.ss()
    if outputs:
        system = system[list(outputs), :]

    def ours() -> Any:
        fresh = tv.Plant(plant.coefficients, plant.model)  # its poles count too
        return tv.attitude_responses(fresh, deflection, winds, times, outputs).outputs

    ratio(
        benchmark,
        ours,
        lambda: control.forced_response(system, times, inputs),
        peer_name="control.forced_response",
        per=CASES,
        floor="4 kB of fresh memory for each output; before it the knots and modes of each case",
    )
