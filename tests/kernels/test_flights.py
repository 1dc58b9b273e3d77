"""The kernel of flights: plain Python and machine code, and cases that mind nobody's business."""

import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual
from tvclin import Actuator, Autopilot, Coefficients, Plant
from tvclin.flights.closed_loop import fly_many
from tvclin.flights.closed_loop.outcomes import outcome_criteria
from tvclin.kernels import choice, flights
from tvclin.kernels.choice import available, pinned
from tvclin.kernels.control_laws import bounded_coordinate, slow_edges
from tvclin.numerics.pieces import polynomial_pieces
from tvclin.numerics.propagation import matrix_exponentials

VEHICLE = tv.load_vehicle("configuration-i")
PEAK = 0.08
SERVO = Actuator(natural_frequency=20.0)
EACH_WAY = pytest.mark.parametrize(
    "compiled",
    [False, pytest.param(True, marks=pytest.mark.skipif(not available(), reason="needs numba"))],
)
KINDS = [
    ("gains", {"actuator": SERVO, "rate_limit": 0.01}),
    ("gains", {"actuator": SERVO, "rate_limit": 0.01, "delay": 0.047}),
    ("dead band", {}),
    ("lean", {"actuator": SERVO}),
    ("lean", {}),
]
EACH_KIND = pytest.mark.parametrize(("name", "options"), usual(KINDS, 3))


def case(name, size, model="drift-exact"):
    """Return plants, a law of the nominal plant, winds and limits of a dispersed batch."""
    rng = np.random.default_rng(11)
    factors = rng.uniform(0.95, 1.05, (3, size))
    vehicle = VEHICLE.replace(
        thrust=VEHICLE.thrust * factors[0], aerodynamic_arm=VEHICLE.aerodynamic_arm * factors[1]
    )
    nominal = Plant.from_vehicle(VEHICLE, model)
    B, beta = float(nominal.coefficients.B), float(nominal.coefficients.beta)
    law = {
        "gains": tv.SaturatedLaw(Autopilot(attitude_gain=3 * B, rate_gain=3 * B / beta)),
        "dead band": tv.control.DeadBandLaw(nominal),
        "lean": tv.RecoverableAttitudeLaw(nominal, design_peak=PEAK),
    }[name]
    angle = PEAK * rng.uniform(-0.2, 1.0, (size, 9))
    wind = tv.SampledWind(time=np.linspace(0.3, 9.1, 9), angle=angle)
    limit = B * PEAK * rng.uniform(0.3, 1.2, size)
    return Plant.from_vehicle(vehicle, model), law, wind, limit


def fields(flown):
    return np.stack([np.asarray(v) for k, v in vars(flown).items() if k != "status"])


def part(case, index):
    """Return some of a batch."""
    plant, law, wind, limit = case
    numbers = {
        name: np.broadcast_to(getattr(plant.coefficients, name), limit.shape)[index]
        for name in ("mu_alpha", "mu_delta", "C1", "C2", "b1", "b2", "q")
    }
    angle = wind.angle[index]
    plant = Plant.from_coefficients(Coefficients(**numbers), plant.model)
    return plant, law, tv.SampledWind(time=wind.time, angle=angle), limit[index]


def flown(case, **options):
    plant, law, wind, limit = case
    return tv.fly_many(plant, law, wind, deflection_limit=limit, **{"sample_rate": 50.0} | options)


@EACH_KIND
def test_machine_code_flies_as_plain_python_does(name, options):
    pytest.importorskip("numba")
    every = case(name, 20)
    with pinned(False):
        slow = flown(every, **options)
    with pinned(True):
        fast = flown(every, **options)
    assert set(slow.status) >= {"survived", "lost"}
    np.testing.assert_array_equal(slow.status, fast.status)
    # They differ at most in the last digit of powers, which a lost flight multiplies.
    np.testing.assert_allclose(fields(fast), fields(slow), rtol=1e-9, atol=1e-10)


class LawInPython(tv.control.Law):
    """Gains in Python: their flights go sample by sample, by `look` and `advance`."""

    def demand(self, measured, states, limit):
        return 0.3 * measured.attitude + 0.6 * measured.attitude_rate


@pytest.mark.thorough
def test_machine_code_moves_by_a_sample_as_plain_python_does():
    """Behind the kernel of whole flights, whose parts it shares, so that these compile once."""
    pytest.importorskip("numba")
    plant, _, wind, limit = case("gains", 10)
    computed = []
    for compiled in (False, True):
        with pinned(compiled):
            flight = flown((plant, LawInPython(), wind, limit), actuator=SERVO, delay=0.047)
        computed.append(flight)
    np.testing.assert_array_equal(*(one.status for one in computed))
    np.testing.assert_allclose(fields(computed[1]), fields(computed[0]), rtol=1e-9, atol=1e-10)


def test_both_kernels_of_a_sample_run_alike_if_one_alone_is_cached(monkeypatch):
    """As after the end of a process between their two compilations."""
    plant, _, wind, limit = case("gains", 2)
    with pinned(False):
        expected = flown((plant, LawInPython(), wind, limit))
    monkeypatch.setattr(choice, "_MIN_LOADING_SECONDS", 0.0)
    monkeypatch.setattr(choice, "_is_cached", lambda kernel: kernel is flights.move_flights)
    computed = flown((plant, LawInPython(), wind, limit))
    np.testing.assert_array_equal(fields(computed), fields(expected))


@pytest.mark.thorough
@EACH_WAY
@EACH_KIND
def test_a_case_does_not_depend_on_its_batch(name, options, compiled):
    size = 70 if compiled else 10
    every = case(name, size)
    order = np.random.default_rng(3).permutation(size)
    until = 12.0 if compiled else 9.2
    with pinned(compiled):
        whole = flown(every, until=until, **options)
        mixed = flown(part(every, order), until=until, **options)
        few = flown(part(every, np.array([size - 4, 2, 5])), until=until, **options)
    np.testing.assert_array_equal(fields(mixed), fields(whole)[:, order])
    np.testing.assert_array_equal(fields(few), fields(whole)[:, [size - 4, 2, 5]])


def test_arrays_have_one_layout_whatever_the_wind(monkeypatch):
    """Of another layout the kernel would be compiled once more, for half a minute."""
    made, flights = [], fly_many.flights
    monkeypatch.setattr(
        fly_many,
        "flights",
        lambda *given, **request: made.append(flights(*given, **request)) or made[-1],
    )
    plant, law, _, limit = case("gains", 2)
    wind = tv.TriangularWind(peak=PEAK, duration=7.5).before([np.inf, 3.0])
    flown((plant, law, wind, limit))

    every = [one for group in made[0][:-1] for one in group] + [made[0].track]
    arrays = [one for one in every if isinstance(one, np.ndarray)]
    assert len(arrays) > 30
    assert all(array.flags.c_contiguous for array in arrays)


def test_threads_change_nothing(monkeypatch):
    pytest.importorskip("numba")
    every = case("gains", 900)
    computed = []
    for threads in ("1", "2"):
        monkeypatch.setenv("TVCLIN_NUM_THREADS", threads)
        with pinned(True):
            computed.append(fields(flown(every, sample_rate=50.0)))
    np.testing.assert_array_equal(*computed)


@pytest.mark.parametrize("model", ["fixed-path", "drift", "drift-exact"])
def test_the_rows_that_judge_are_left_eigenvectors_scaled_to_the_deflection(model):
    """By `numpy.linalg.eig`: z' = s (z - delta/B) in calm air, of the fastest pole first."""
    plant = Plant.from_vehicle(VEHICLE, model)
    judges, (A, inputs) = outcome_criteria(plant), plant.matrices()[:2]
    poles, vectors = np.linalg.eig(A.T)
    unstable = sorted(np.flatnonzero(poles.real > 1e-9), key=lambda k: -poles[k].real)
    s, rows = poles[unstable].real, vectors[:, unstable].real.T
    rows *= (-s / plant.coefficients.B / (rows @ inputs[:, 0]))[:, np.newaxis]
    states = rows.shape[1]
    np.testing.assert_allclose(judges.rows[0, : s.size, :states], rows, rtol=1e-9, atol=1e-12)
    assert not np.any(judges.rows[..., states:])
    assert not np.any(judges.rows[0, s.size :])
    assert judges.ratio[0] == pytest.approx(s[1] / s[0] if s.size == 2 else 0.0, rel=1e-9)


def test_a_plant_with_a_pair_or_without_an_unstable_pole_is_not_judged():
    pair = Plant.from_vehicle(VEHICLE, "drift-and-speed")
    assert np.isnan(outcome_criteria(pair).reach[0])
    mixed = Plant.from_coefficients(Coefficients(mu_alpha=np.array([0.2, -0.2]), mu_delta=1.0))
    np.testing.assert_array_equal(np.isnan(outcome_criteria(mixed).reach), [False, True])


@pytest.mark.parametrize("power", [1.3, 3.0, 4.0, 40.0])
def test_a_lean_stays_within_the_ends_that_go_with_the_slow_coordinate(power):
    """The ends are the inverse of those of the slow coordinate, and powers left out change none."""
    for fast in np.linspace(-0.99, 0.99, 23).tolist():
        low, high = slow_edges(fast, 1.0 / power)
        assert bounded_coordinate(1.0, float(high), power) >= fast - 1e-12
        assert bounded_coordinate(-1.0, float(high), power) == pytest.approx(fast, abs=1e-9)
        assert bounded_coordinate(1.0, float(low), power) == pytest.approx(fast, abs=1e-9)
    for lean in np.linspace(-1.0, 1.0, 41).tolist():
        for slow in np.linspace(-1.0, 1.0, 41).tolist():
            ends = 2 * ((1 + slow) / 2) ** power - 1, 1 - 2 * ((1 - slow) / 2) ** power
            expected = min(max(lean, ends[0]), ends[1])
            assert bounded_coordinate(lean, slow, power) == pytest.approx(expected, abs=1e-15)


def test_exponentials_of_a_batch_are_scipys():
    from scipy.linalg import expm

    matrices = np.random.default_rng(1).normal(size=(6, 5, 5)) * 3
    np.testing.assert_allclose(
        matrix_exponentials(matrices, np.full(6, 0.7)), expm(0.7 * matrices), rtol=1e-11
    )


@pytest.mark.parametrize(
    "wind",
    [
        tv.OneMinusCosineGust(peak=np.array([0.05, -0.1]), duration=np.array([3.0, 8.0])),
        tv.winds.LayeredGust(peak=0.05, blend=2.0, plateau=3.0),
        tv.TriangularWind(peak=0.1, duration=3.0),
    ],
)
def test_polynomial_pieces_are_the_wind(wind):
    knots, c = polynomial_pieces(wind.pieces)
    for k, (row, pieces) in enumerate(zip(knots, c, strict=True)):
        times = np.linspace(row[0], row[-1], 500)
        index = np.searchsorted(row, times, side="right") - 1
        u = times - row[index]
        result = sum(pieces[index, j] * u**j for j in range(c.shape[-1]))
        expected = np.atleast_2d(wind(times))[k]
        np.testing.assert_allclose(result, expected, atol=1e-11 * np.abs(expected).max())


def test_flights_of_all_shapes_are_one_kind_of_arrays_so_that_they_are_compiled_once(monkeypatch):
    kinds, made = set(), fly_many.flights

    def noted(*arguments, **options):
        f = made(*arguments, **options)
        arrays = [one for one in f if isinstance(one, np.ndarray)]
        kinds.add(tuple((a.dtype, a.ndim, a.flags.carray) for a in arrays))
        return f

    monkeypatch.setattr(fly_many, "flights", noted)
    one = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "fixed-path")
    many = tv.Plant(tv.Coefficients.from_beta(beta=np.array([0.5, 0.4]), B=0.1), "fixed-path")
    law = tv.SaturatedLaw(tv.Autopilot(attitude_gain=0.3, rate_gain=0.5))
    wind = tv.TriangularWind(peak=0.05, duration=0.1)
    winds = tv.TriangularWind(peak=[0.05, -0.02], duration=0.1)
    short = {"sample_rate": 50, "until": 0.2}
    for plant, laws, blown, limit in (
        (one, law, wind, 0.02),
        (one, law, winds, 0.02),
        (one, law, wind, [0.02, 0.01]),
        (one, law, winds, [[0.02], [0.01]]),
        (one, np.array([law, tv.TrimLaw(one)]), wind, 0.02),
        (many, law, wind, 0.02),
        (many, law, winds, [[0.02], [0.01]]),
    ):
        tv.fly_many(plant, laws, blown, deflection_limit=limit, **short)
    assert len(kinds) == 1
    assert all(writable for *_, writable in kinds.pop())
