"""Responses by the kernel, as plain Python and as machine code: against many digits."""

from collections.abc import Callable, Iterator
from functools import cache
from itertools import pairwise
from typing import Any

import mpmath as mp
import numpy as np
import pytest

import tvclin as tv
from tests.sixty_digits import carried
from tests.turns import by_turns, usual
from tvclin.kernels.choice import VARIABLE, pinned
from tvclin.numerics.pieces import Pieces
from tvclin.winds.histories import Piecewise

MODELS = ("fixed-path", "drift", "drift-exact", "drift-and-speed")
AGREE = 1e-13
"""Of the largest value of each output, as `numerics.modal` states."""


@pytest.fixture(params=[False, True], ids=["plain Python", "machine code"])
def run(request: pytest.FixtureRequest) -> Iterator[None]:
    if request.param:
        pytest.importorskip("numba")
    with pinned(request.param):
        yield


def dispersed(model: str, seed: int, shape: tuple[int, ...] = ()) -> tv.Plant:
    rng = np.random.default_rng(seed)
    beta, b1 = rng.uniform(0.2, 1.0, shape), rng.uniform(0.01, 0.1, shape)
    c = tv.Coefficients.from_beta(
        beta=beta,
        B=rng.uniform(0.05, 0.5, shape),
        C1=0.9 * b1,
        C2=beta**2 * rng.uniform(0.005, 0.02, shape),
        b1=b1,
        b2=0.5 * b1,
        q=rng.uniform(1e-4, 4e-4, shape),
    )
    return tv.Plant(c, model)


def jumping_wind() -> tv.winds.History:
    return tv.SampledWind(time=[1.0, 2.5, 2.5, 4.0, 6.5], angle=[0.05, 0.02, -0.08, 0.1, 0.0])


def rising_exponentials(rates: list[float]) -> tv.winds.History:
    """Two pieces of c u^k e^(r u), k = 0 ... 2, for each rate."""
    rng = np.random.default_rng(5)
    terms = rng.uniform(-0.01, 0.01, (2, len(rates), 3))
    return Piecewise(Pieces(np.array([0.5, 3.0]), terms, np.array(rates)))


def high_powers() -> tv.winds.History:
    """One piece, c u^k e^(-u / 3) for k = 0 ... 9, none of them negligible in the first seconds."""
    terms = 0.01 * 0.5 ** np.arange(10)[np.newaxis, np.newaxis, :]
    return Piecewise(Pieces(np.array([0.5]), terms, np.array([-1.0 / 3.0])))


def histories(plant: tv.Plant) -> dict[str, tuple[tv.winds.History, tv.winds.History]]:
    triangle = tv.TriangularWind(peak=0.1, duration=7.0)
    limit = tv.boundary_limit(plant, triangle).deflection
    switching = tv.linear.BangBang(limit=0.01, switch_times=[1.5, 4.0], start=0.5)
    return {
        "on the boundary": (tv.trim_then_hold(plant, triangle, limit), triangle),
        "lost": (tv.trim_then_hold(plant, triangle, 0.8 * limit), triangle),
        "held": (tv.linear.ConstantDeflection(limit=-0.004), triangle),
        "late": (tv.linear.ConstantDeflection(limit=-0.004, start=201.0), triangle.shift(200.0)),
        "jumps": (switching, jumping_wind()),
        "short": (switching, tv.winds.TrapezoidalWind(peak=0.1, rise=1e-3, hold=0.02, fall=0.0)),
        "gust": (switching, tv.OneMinusCosineGust(peak=0.1, duration=3.0)),
        "exponentials": (rising_exponentials([-0.02, -1.7]), rising_exponentials([0.0, -3.0])),
        "high powers": (high_powers(), triangle),
        "resonant": (rising_exponentials([float(plant.modal.poles.real.min()) + 1e-3]), triangle),
    }


def both(
    plant: tv.Plant, deflection: tv.winds.History, wind: tv.winds.History, times: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The outputs by plain Python and by machine code."""
    pytest.importorskip("numba")
    with pinned(False):
        plain = tv.attitude_responses(plant, deflection, wind, times).outputs
    with pinned(True):
        return plain, tv.attitude_responses(plant, deflection, wind, times).outputs


@pytest.mark.thorough
@pytest.mark.parametrize("even", [True, False], ids=["even", "uneven"])
@pytest.mark.parametrize("model", MODELS)
def test_machine_code_says_what_plain_python_says(model: str, even: bool) -> None:
    plant = dispersed(model, 1)
    times = np.linspace(-1.0, 30.0, 300)
    times = times if even else times + 0.05 * np.sin(times)
    for name, (deflection, wind) in histories(plant).items():
        late = 200.0 if name == "late" else 0.0
        plain, fast = both(plant, deflection, wind, times + late)

        scale = np.max(np.abs(plain), axis=-1, keepdims=True)
        assert np.max(np.abs(fast - plain) / scale) < AGREE, name


@cache
def integrated(model: str, name: str, times: tuple[float, ...]) -> Any:
    """The attitude: for each pole and input the integral of e^(p (t - v)) f(v), by quadrature."""
    plant = dispersed(model, 1)
    computed = [mp.mpf(0)] * len(times)
    denominator = [mp.mpf(float(a)) for a in plant.denominator]
    slope = [a * k for a, k in zip(denominator, range(len(denominator) - 1, 0, -1), strict=False)]
    for label, history in zip(("deflection", "wind"), histories(plant)[name], strict=True):
        numerator = [mp.mpf(float(a)) for a in plant.numerator("attitude", label)]
        edges = [*(mp.mpf(float(k)) for k in history.knots), mp.inf]
        for p in mp.polyroots(denominator, maxsteps=200, extraprec=200):
            gain = mp.polyval(numerator, p) / mp.polyval(slope, p)
            for j, t in enumerate(mp.mpf(float(t)) for t in times):
                for i, (start, stop) in enumerate(pairwise(edges)):
                    if start < min(stop, t):
                        terms = exact_piece(history.pieces, i)
                        ends = [start, min(stop, t)]
                        computed[j] += gain * mp.quad(
                            lambda v, f=terms, u=start, p=p, t=t: mp.exp(p * (t - v)) * f(v - u),
                            ends,
                        )
    return np.array([float(mp.re(value)) for value in computed])


def exact_piece(pieces: Pieces, i: int) -> Callable[[Any], Any]:
    """One piece as a function of its local time."""
    rates = [mp.mpmathify(complex(rate)) for rate in pieces.rates]
    rows = [[mp.mpmathify(complex(c)) for c in row[::-1]] for row in pieces.coefficients[i]]
    return lambda u: sum(
        mp.polyval(row, u) * mp.exp(rate * u) for row, rate in zip(rows, rates, strict=True)
    )


@by_turns("model,name", MODELS, ["lost", "gust", "exponentials", "high powers", "resonant"], each=5)
def test_whatever_drives_it_the_attitude_is_its_integral(model: str, name: str, run: None) -> None:
    plant = dispersed(model, 1)
    inputs, times = histories(plant)[name], (0.9, 2.8, 5.5, 9.0)
    computed = tv.attitude_responses(plant, *inputs, np.array(times))["attitude"]

    with mp.workdps(40):
        expected = integrated(model, name, times)
    np.testing.assert_allclose(computed, expected, rtol=0, atol=AGREE * np.abs(expected).max())


@pytest.mark.parametrize("model", MODELS)
def test_beyond_all_numbers_a_lost_attitude_is_infinite(model: str, run: None) -> None:
    plant = dispersed(model, 1)
    constant, wind = (
        tv.linear.ConstantDeflection(limit=-1e-4),
        tv.TriangularWind(peak=0.1, duration=7.0),
    )
    computed = tv.attitude_responses(plant, constant, wind, [100.0, 5e3, 1e4])["attitude"]

    assert np.isfinite(computed[0])
    assert np.all(computed[1:] == np.copysign(np.inf, computed[0]))


@cache
def carried_one_by_one(model: str) -> tuple[Any, ...]:
    """Three plants, inputs, times, and the outputs of each plant with sixty digits."""
    plants = dispersed(model, 7, (3,))
    inputs = tv.linear.BangBang(limit=0.01, switch_times=[1.5, 4.0], start=0.5), jumping_wind()
    times = np.linspace(0.0, 12.0, 25)
    with mp.workdps(60):
        outputs = [carried([*inputs], times, [m[k] for m in plants.matrices()]) for k in range(3)]
    return plants, inputs, times, np.array(outputs)


@pytest.mark.thorough
@pytest.mark.parametrize("model", usual(MODELS, 2))
def test_dispersed_plants_keep_their_digits(model: str, run: None) -> None:
    plants, inputs, times, expected = carried_one_by_one(model)
    computed = tv.attitude_responses(plants, *inputs, times).outputs

    scale = np.max(np.abs(expected), axis=-1, keepdims=True)
    assert np.max(np.abs(computed - expected) / scale) < AGREE


@pytest.mark.parametrize("K", [1.0, 0.0])
def test_all_digits_stay_on_the_boundary_at_any_time(K: float, run: None) -> None:
    """Long after the wind the attitude of eq (5) is the held deflection over B, and stays it."""
    plant = tv.Plant(tv.Coefficients.from_beta(beta=0.5, B=0.1), "fixed-path")
    wind = tv.TriangularWind(peak=0.1, duration=20.0)
    limit = tv.boundary_limit(plant, wind, K).deflection
    constant = tv.trim_then_hold(plant, wind, limit, K)
    for times in (np.linspace(0.0, 2000.0, 401), np.array([100.0, 333.0, 5000.0])):
        computed = tv.attitude_responses(plant, constant, wind, times)["attitude"]

        np.testing.assert_allclose(computed[times >= 100.0], limit / 0.1, rtol=AGREE)


@pytest.mark.parametrize("mu_alpha", [1e-8, 1e-12])
def test_poles_nearly_alike_go_by_matrices(mu_alpha: float, run: None) -> None:
    """Without aerodynamic moment the attitude is the double integral of the deflection."""
    plants = tv.Plant(
        tv.Coefficients(mu_alpha=np.array([mu_alpha, 0.3]), mu_delta=1.0), "fixed-path"
    )
    constant, wind = (
        tv.linear.ConstantDeflection(limit=-0.005),
        tv.RectangularWind(peak=0.1, duration=5.0),
    )
    times = np.array([0.5, 3.0, 10.0])
    computed = tv.attitude_responses(plants, constant, wind, times)["attitude"]
    single = tv.attitude_responses(
        tv.Plant(tv.Coefficients(mu_alpha=0.3, mu_delta=1.0), "fixed-path"), constant, wind, times
    )

    np.testing.assert_allclose(computed[0], 0.0025 * times**2, rtol=1e3 * mu_alpha + 1e-13)
    np.testing.assert_allclose(computed[1], single["attitude"], rtol=AGREE)


def test_a_jump_is_seen_at_its_knot_and_nothing_before_the_first(run: None) -> None:
    plant, wind = dispersed("drift-exact", 2), jumping_wind()
    constant = tv.linear.ConstantDeflection(limit=-0.01, start=0.5)
    times = np.array([-3.0, 0.499, np.nextafter(2.5, 0.0), 2.5])
    result = tv.attitude_responses(plant, constant, wind, times)

    assert not np.any(result.outputs[:, :2])
    step = result["angle_of_attack"][3] - result["angle_of_attack"][2]
    assert step == pytest.approx(0.1, rel=1e-13)
    np.testing.assert_allclose(result["attitude"][3], result["attitude"][2], rtol=1e-13)


def test_the_order_of_the_times_does_not_matter(run: None) -> None:
    plant = dispersed("drift", 3)
    deflection, wind = histories(plant)["jumps"]
    times = np.linspace(-1.0, 20.0, 80)
    mixed = np.random.default_rng(0).permutation(80)
    rising = tv.attitude_responses(plant, deflection, wind, times).outputs
    computed = tv.attitude_responses(plant, deflection, wind, times[mixed]).outputs

    np.testing.assert_allclose(computed, rising[:, mixed], rtol=1e-13, atol=1e-17)


@pytest.mark.thorough
def test_a_case_needs_nothing_of_its_neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("numba")
    plants = dispersed("fixed-path", 4, (150, 1))
    winds = tv.TriangularWind(peak=0.1, duration=np.linspace(2.0, 9.0, 20))
    constant, times = tv.linear.ConstantDeflection(limit=-0.01), np.linspace(0.0, 20.0, 499)
    with pinned(True):
        together = tv.attitude_responses(plants, constant, winds, times).outputs
        monkeypatch.setenv(VARIABLE, "1")
        in_one_thread = tv.attitude_responses(plants, constant, winds, times).outputs
        c = plants.coefficients
        one = tv.Plant(
            tv.Coefficients.from_beta(beta=float(c.beta[77, 0]), B=float(c.B[77, 0])), "fixed-path"
        )
        wind = tv.TriangularWind(peak=0.1, duration=float(winds.duration[13]))
        single = tv.attitude_responses(one, constant, wind, times).outputs

    np.testing.assert_array_equal(in_one_thread, together)
    np.testing.assert_allclose(together[77, 13], single, rtol=1e-12, atol=1e-15)


def triangles(plants: tv.Plant, durations: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Responses to a wind for each plant, short to long: modes are slow in some, fast in others."""
    deflection = tv.linear.BangBang(limit=0.01, switch_times=[0.0], start=-4.0)
    wind = tv.TriangularWind(peak=0.1, duration=durations)
    return tv.attitude_responses(plants, deflection, wind, times).outputs


@pytest.mark.parametrize("points", usual([40, 150, 1300], 1))
def test_slow_and_fast_cases_share_a_batch(points: int) -> None:
    pytest.importorskip("numba")
    plants, durations = dispersed("fixed-path", 9, (40,)), np.geomspace(0.1, 25.0, 40)
    times = np.linspace(-5.0, 14.0, points)
    with pinned(False):
        plain = triangles(plants, durations, times)
    with pinned(True):
        fast = triangles(plants, durations, times)

    scale = np.max(np.abs(plain), axis=-1, keepdims=True)
    assert np.max(np.abs(fast - plain) / scale) < AGREE


@pytest.mark.thorough
@pytest.mark.parametrize("model", MODELS)
def test_each_vehicle_has_the_bits_it_has_alone_with_the_control_of_the_report(
    model: str, run: None
) -> None:
    plants, times = dispersed(model, 9, (12,)), np.linspace(-1.0, 14.0, 30)
    wind = tv.TriangularWind(peak=0.1, duration=7.0)
    control = tv.trim_then_hold(plants, wind, -0.05 * np.asarray(plants.coefficients.B))
    computed = tv.attitude_responses(plants, control, wind, times).outputs
    for k in (11, 4, 0):
        few = np.array([k])
        one = plants.cases(few, (12,)), control.cases(few, (12,))
        single = tv.attitude_responses(*one, wind, times).outputs
        np.testing.assert_array_equal(single[0], computed[k])


def test_a_case_has_the_same_bits_wherever_it_stands() -> None:
    pytest.importorskip("numba")
    plant, durations = dispersed("fixed-path", 9), np.geomspace(0.1, 25.0, 40)
    times = np.linspace(-5.0, 14.0, 150)
    with pinned(True):
        result = triangles(plant, durations, times)
        for some in (slice(None, None, -1), slice(7, 25), slice(30, 31)):
            np.testing.assert_array_equal(triangles(plant, durations[some], times), result[some])


@pytest.mark.thorough
@pytest.mark.parametrize("K", [1.0, 0.0])
def test_a_batch_on_the_boundary_keeps_its_digits(K: float, run: None) -> None:
    beta, B = np.linspace(0.3, 0.9, 40), np.linspace(0.05, 0.5, 40)
    plants = tv.Plant(tv.Coefficients.from_beta(beta=beta, B=B), "fixed-path")
    wind = tv.TriangularWind(peak=0.1, duration=20.0)
    limit = tv.boundary_limit(plants, wind, K).deflection
    constant = tv.trim_then_hold(plants, wind, limit, K)
    times = np.linspace(0.0, 600.0, 1201)
    computed = tv.attitude_responses(plants, constant, wind, times)["attitude"]

    expected = np.broadcast_to((limit / B)[:, np.newaxis], (40, np.sum(times >= 150.0)))
    np.testing.assert_allclose(computed[:, times >= 150.0], expected, rtol=AGREE)


@pytest.mark.parametrize(
    "names", [("attitude",), ("angle_of_attack",), ("attitude_rate", "attitude")]
)
@pytest.mark.parametrize("model", ["fixed-path", "drift-exact"])
def test_some_outputs_are_those_of_all(model: str, names: tuple[str, ...], run: None) -> None:
    plant, times = dispersed(model, 3, (5,)), np.linspace(-1.0, 20.0, 57)
    deflection, wind = tv.linear.BangBang(limit=0.01, switch_times=[1.5, 4.0]), jumping_wind()
    every = tv.attitude_responses(plant, deflection, wind, times)
    some = tv.attitude_responses(plant, deflection, wind, times, names)

    assert some.labels == tuple(label for label in plant.outputs if label in names)
    for label in names:
        np.testing.assert_allclose(
            some[label], every[label], rtol=0, atol=AGREE * np.abs(every[label]).max()
        )


def test_some_outputs_of_poles_nearly_alike() -> None:
    plant = tv.Plant(tv.Coefficients(mu_alpha=1e-12, mu_delta=1.0), "fixed-path")
    constant, wind = (
        tv.linear.ConstantDeflection(limit=0.01),
        tv.TriangularWind(peak=0.1, duration=7.0),
    )
    every = tv.attitude_responses(plant, constant, wind, [1.0, 9.0])
    some = tv.attitude_responses(plant, constant, wind, [1.0, 9.0], ["attitude_rate"])

    assert np.array_equal(some["attitude_rate"], every["attitude_rate"])


@pytest.mark.parametrize("names", ["attitude", (), ("attitude", "speed")])
def test_outputs_that_are_not_there_are_refused(names: object) -> None:
    constant, wind = (
        tv.linear.ConstantDeflection(limit=0.01),
        tv.TriangularWind(peak=0.1, duration=7.0),
    )

    with pytest.raises(tv.InputError, match="outputs must be"):
        tv.attitude_responses(dispersed("fixed-path", 0), constant, wind, [1.0], names)
