"""The laws as formulas: each demand against scalar algebra written here."""

import warnings
from pathlib import Path

import control
import numpy as np
import pytest

import tvclin as tv
from tvclin import Actuator, Autopilot, Coefficients, InputError, Plant
from tvclin.control.laws.autopilot_law import SaturatedLaw
from tvclin.control.laws.estimator import WindEstimator
from tvclin.control.laws.law import Measurement
from tvclin.control.laws.recoverable import RecoverableAttitudeLaw as LeanLaw
from tvclin.control.laws.trim import DeadBandLaw, TrimLaw

MODELS = ("fixed-path", "drift", "drift-exact")
EACH_MODEL = pytest.mark.parametrize("model", MODELS)
COEFFICIENTS = Coefficients(
    mu_alpha=0.28, mu_delta=2.6, C1=0.025, C2=0.0036, b1=0.0284, b2=0.0169, q=1.7e-4
)
AHEAD = COEFFICIENTS.replace(mu_delta=-2.6)
NONE = np.zeros((0,))


def plant_of(model="fixed-path", coefficients=COEFFICIENTS):
    return Plant.from_coefficients(coefficients, model)


def random_seen(rng, model, size=None, scale=0.05):
    """Return what is seen, and the wind that makes its angle of attack."""
    attitude, rate, path, wind = rng.normal(scale=scale, size=(4,) if size is None else (4, *size))
    path = 0.0 * path if model == "fixed-path" else path
    return Measurement(attitude, rate, path, attitude - path - wind, *[0.0 * wind] * 4), wind


def coordinates(model, coefficients):
    """Return poles, rows and K1 of the unstable modes: left eigenvectors from numpy."""
    A, inputs, _, _ = plant_of(model, coefficients).matrices()
    poles, vectors = np.linalg.eig(A.T)
    order = [k for k in np.argsort(-poles.real) if poles[k].real > 1e-9]
    poles = poles[order].real
    rows = [
        v.real * -p / coefficients.B / (v.real @ inputs[:, 0])
        for v, p in zip(vectors.T[order], poles, strict=True)
    ]
    path = model != "fixed-path"
    strength = (poles + path * coefficients.b2) / (poles + path * coefficients.b1)
    return poles, rows, strength


def by_hand(model, coefficients, seen, wind, limit, law):
    """The recoverable-attitude law, one number after the other; returns u and Z."""
    poles, rows, k1 = coordinates(model, coefficients)
    if abs(wind) <= law.dead_band:
        wind = 0.0
    elif law.dead_band:
        wind -= np.copysign(law.dead_band, wind)
    measured = [seen.attitude, seen.attitude_rate, seen.flight_path_angle]
    z = [sum(c * m for c, m in zip(row, measured, strict=False)) for row in rows]
    D, felt = limit / abs(coefficients.B), k1[0] * wind
    reach = law.reach * D
    L = reach
    if law.design_peak is not None:
        L = min(L, max(0.0, k1[0] * max(abs(law.design_peak), 1.1 * abs(wind)) - law.trust * D))
    slow = 3.0 * z[1] if len(z) == 2 else 0.0
    Z = felt + slow
    Z = max(-L + min(slow, 0.0), min(Z, L + max(slow, 0.0)))
    if felt > 0.0:
        Z = max(Z, felt - 0.9 * D)
    if felt < 0.0:
        Z = min(Z, felt + 0.9 * D)
    low, high = -reach, reach
    if len(z) == 2:
        x, power = min(max(z[1] / reach, -0.9999), 0.9999), poles[0] / poles[1]
        low = reach * (2.0 * ((1.0 + x) / 2.0) ** power - 1.0)
        high = reach * (1.0 - 2.0 * ((1.0 - x) / 2.0) ** power)
    Z = min(max(Z, low), high)
    return z[0] - felt + law.gain * (z[0] - Z), Z


@EACH_MODEL
@pytest.mark.parametrize("alpha_gain", [0.0, 0.07])
@pytest.mark.parametrize("integral_gain", [0.0, 0.05])
def test_the_saturated_law_is_the_feedback_of_its_autopilot(model, alpha_gain, integral_gain):
    gains = {"attitude_gain": 0.3, "rate_gain": 0.4}
    law = SaturatedLaw(Autopilot(**gains, alpha_gain=alpha_gain, integral_gain=integral_gain))
    F, G = law.states
    assert len(F) == len(G) == bool(integral_gain)
    if integral_gain:  # the integral of the attitude and of nothing else
        np.testing.assert_array_equal(F, [[0.0]])
        np.testing.assert_array_equal(G, [[1.0, 0.0, 0.0, 0.0, 0.0]])
    rng = np.random.default_rng(1)
    for _ in range(5):
        seen, _ = random_seen(rng, model)
        integral = rng.normal()
        states = np.array([integral]) if integral_gain else NONE
        expected = 0.3 * seen.attitude + 0.4 * seen.attitude_rate
        expected += alpha_gain * seen.angle_of_attack + integral_gain * integral
        for limit in (1e-3, 10.0):
            assert law.demand(seen, states, limit) == pytest.approx(expected, rel=1e-12)


@EACH_MODEL
@pytest.mark.parametrize("coefficients", [COEFFICIENTS, AHEAD], ids=["behind", "ahead"])
@pytest.mark.parametrize("kind", [TrimLaw, DeadBandLaw])
def test_the_trim_laws_ask_for_trim_and_the_feedback_of_the_fast_mode(model, coefficients, kind):
    law = kind(plant_of(model, coefficients), gain=4.0)
    _, rows, _ = coordinates(model, coefficients)
    rng = np.random.default_rng(2)
    for _ in range(5):
        seen, _ = random_seen(rng, model)
        z = sum(c * m for c, m in zip(rows[0], seen[:3], strict=False))
        if model == "fixed-path":
            assert z == pytest.approx(seen.attitude + seen.attitude_rate / coefficients.beta)
        expected = coefficients.B * (seen.angle_of_attack + 4.0 * z)
        assert law.demand(seen, NONE, 0.01) == pytest.approx(expected, rel=1e-9)
    at_rest = Measurement(0.0, 0.0, 0.0, -0.05, 0.0)  # a wind of 0.05 rad
    assert law.demand(at_rest, NONE, 0.01) == pytest.approx(-coefficients.B * 0.05)
    assert (TrimLaw(law.plant).gain, DeadBandLaw(law.plant).gain) == (10.0, 1.0)


def test_the_dead_band_engages_at_K_and_lets_go_just_below():
    law = DeadBandLaw(plant_of(), dead_band=0.4)
    assert law.engage == 0.4
    assert 0.0 < law.release < law.engage
    assert law.release == pytest.approx(0.36)
    assert (TrimLaw(plant_of()).engage, TrimLaw(plant_of()).release) == (1.0, 1.0)


OPTIONS = {
    "as it comes": {},
    "short reach": {"reach": 0.6, "gain": 3.0},
    "a design peak": {"design_peak": 0.06},
    "full trust": {"design_peak": 0.06, "trust": 1.0},
    "a low design peak": {"design_peak": -0.01, "reach": 1.0},
    "a dead band": {"dead_band": 0.02, "design_peak": 0.1},
}
EACH_OPTION = pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS)


@EACH_MODEL
@EACH_OPTION
@pytest.mark.parametrize("coefficients", [COEFFICIENTS, AHEAD], ids=["behind", "ahead"])
def test_the_recoverable_law_is_its_formula(model, options, coefficients):
    law = LeanLaw(plant_of(model, coefficients), **options)
    rng = np.random.default_rng(3)
    for _ in range(200):
        seen, wind = random_seen(rng, model)
        limit = abs(coefficients.B) * rng.uniform(0.01, 0.15)
        u, _ = by_hand(model, coefficients, seen, wind, limit, law)
        result = law.demand(seen, NONE, limit)
        assert result == pytest.approx(coefficients.B * u, rel=1e-7, abs=1e-10)


def leans(law, model, count=20000, seed=4):
    """Return Z as the demand shows it, with felt wind, wind and D, for many states at once."""
    c = law.plant.coefficients
    rng = np.random.default_rng(seed)
    seen, wind = random_seen(rng, model, (count,))
    D = rng.uniform(0.01, 0.15, count)
    _, rows, k1 = coordinates(model, c)
    z = sum(r * m for r, m in zip(rows[0], seen[:3], strict=False))
    u = law.demand(seen, NONE, D * abs(c.B)) / c.B
    return z - (u - z + k1[0] * wind) / law.gain, k1[0] * wind, wind, D


@pytest.mark.thorough
@EACH_MODEL
@pytest.mark.parametrize("reach", [0.5, 0.9, 1.0])
def test_it_never_leans_beyond_its_reach(model, reach):
    for peak in (None, 0.05):
        law = LeanLaw(plant_of(model), reach=reach, design_peak=peak)
        Z, _, _, D = leans(law, model)
        assert np.all(np.abs(Z) <= reach * D * (1.0 + 1e-9))
        assert np.any(np.abs(Z) > 0.999 * reach * D)


@pytest.mark.thorough
@pytest.mark.parametrize("trust", [1.0, 0.8, 0.4])
def test_it_leans_no_further_than_the_design_wind_asks(trust):
    law = LeanLaw(plant_of(), design_peak=0.05, trust=trust)
    Z, felt, wind, D = leans(law, "fixed-path")
    request = np.maximum(np.maximum(0.05, 1.1 * np.abs(wind)) - trust * D, 0.0)
    most = np.maximum(request, np.abs(felt) - 0.9 * D)  # less would lose the fast mode
    assert np.all(np.abs(Z) <= most + 1e-12)
    assert np.all(Z * wind >= -1e-15)
    assert np.any((request == 0.0) & (Z == 0.0) & (np.abs(wind) > 0.01))
    free, *_ = leans(LeanLaw(plant_of()), "fixed-path")
    assert np.all(np.abs(Z) <= np.abs(free) + 1e-12)
    assert np.mean(np.abs(Z) < 0.5 * np.abs(free)) > 0.1


@EACH_MODEL
@EACH_OPTION
def test_the_demand_of_minus_everything_is_minus_the_demand(model, options):
    for kind in (LeanLaw, TrimLaw):
        law = kind(plant_of(model), **(options if kind is LeanLaw else {}))
        seen, _ = random_seen(np.random.default_rng(5), model, (500,))
        mirrored = Measurement(*(-value for value in seen))
        computed = [law.demand(one, NONE, 0.005) for one in (seen, mirrored)]
        np.testing.assert_allclose(computed[1], -computed[0], rtol=1e-12, atol=1e-15)


@EACH_MODEL
def test_near_rest_it_is_linear(model):
    """It follows the wind down, or where D is ample holds the attitude but for the slow mode."""
    _, rows, k1 = coordinates(model, COEFFICIENTS)
    rng = np.random.default_rng(6)
    for _ in range(20):
        seen, wind = random_seen(rng, model, scale=1e-4)
        z = [sum(c * m for c, m in zip(row, seen[:3], strict=False)) for row in rows]
        slow, felt = 3.0 * z[1] if len(z) == 2 else 0.0, k1[0] * wind
        held = np.clip(felt + slow, min(slow, 0.0), max(slow, 0.0))
        for peak, Z in ((None, felt + slow), (0.1, felt + slow), (0.02, held)):
            law = LeanLaw(plant_of(model), gain=7.0, design_peak=peak)
            computed = law.demand(seen, NONE, 0.05 * COEFFICIENTS.B) / COEFFICIENTS.B
            assert computed == pytest.approx(z[0] - felt + 7.0 * (z[0] - Z), rel=1e-7, abs=1e-11)


@EACH_MODEL
@EACH_OPTION
def test_many_flights_at_once_are_as_one_by_one(model, options):
    rng = np.random.default_rng(8)
    plant = plant_of(model)
    estimator = WindEstimator(bandwidth=5.0)
    seen, _ = random_seen(rng, model, (3, 4))
    limit = rng.uniform(0.001, 0.02, size=(3, 4))
    laws = [
        LeanLaw(plant, **options),
        LeanLaw(plant, **options, estimator=estimator),
        TrimLaw(plant),
        SaturatedLaw(Autopilot(attitude_gain=0.3, rate_gain=0.4, integral_gain=0.1)),
    ]
    for law in laws:
        states = rng.normal(scale=0.05, size=(len(law.states[0]), 3, 4))
        result = law.demand(seen, states, limit)
        assert result.shape == (3, 4)
        for i, j in np.ndindex(3, 4):
            one = Measurement(*(m[i, j].item() for m in seen))
            single = law.demand(one, states[:, i, j], limit[i, j].item())
            assert single == pytest.approx(result[i, j], rel=1e-12, abs=1e-15)


@EACH_MODEL
@pytest.mark.parametrize("bandwidth", [0.8, 10.0])
def test_the_estimate_follows_the_wind_as_a_second_order_lag(model, bandwidth):
    """Beside the plant d^ is d = gamma + alpha_w behind w^2/(s^2 + 1.4 w s + w^2), always."""
    plant = plant_of(model)
    A, inputs, _, _ = plant.matrices()
    F, G = WindEstimator(bandwidth=bandwidth).states(plant)
    n, wind_row = len(A), np.array([0.0, 1.0])
    shown = np.zeros((5, n))
    shown[: min(n, 3), : min(n, 3)] = np.eye(min(n, 3))
    shown[3] = shown[0] - shown[2]
    direct = np.zeros((5, 2))
    direct[3, 1], direct[4, 0] = -1.0, 1.0
    together = np.block([[A, np.zeros((n, 2))], [G @ shown, F]])
    outputs = np.zeros((2, n + 2))
    outputs[0, -1] = 1.0
    outputs[1, :n] = shown[2]
    driven = np.vstack([inputs, G @ direct])
    system = control.ss(together, driven, outputs, [[0.0, 0.0], wind_row])
    rng = np.random.default_rng(9)
    for s in rng.normal(size=4) + 2j * rng.normal(size=4):
        computed, true = system(s)
        lag = bandwidth**2 / (s**2 + 1.4 * bandwidth * s + bandwidth**2)
        np.testing.assert_allclose(computed, lag * true, rtol=1e-8, atol=1e-9)
    assert np.abs(np.linalg.eigvals(F)) == pytest.approx(bandwidth)
    assert -np.linalg.eigvals(F).real / bandwidth == pytest.approx(0.7)


def test_the_estimator_by_hand_algebra_and_its_steady_state():
    plant, w = plant_of(), 6.0
    F, G = WindEstimator(bandwidth=w).states(plant)
    np.testing.assert_allclose(F, [[-8.4, -0.28], [36.0 / 0.28, 0.0]])
    np.testing.assert_allclose(G, [[0.28, 8.4, 0, 0, -2.6], [0, -36.0 / 0.28, 0, 0, 0]])
    for attitude, wind in ((0.02, 0.07), (0.0, -0.05)):  # held by the deflection B alpha
        seen = [attitude, 0.0, 0.0, attitude - wind, COEFFICIENTS.B * (attitude - wind)]
        rate, estimate = np.linalg.solve(-F, G @ seen)
        assert rate == pytest.approx(0.0, abs=1e-15)
        assert estimate == pytest.approx(wind, rel=1e-12)


@EACH_MODEL
def test_the_law_believes_its_estimator_and_nothing_else(model):
    plant, estimator = plant_of(model), WindEstimator(bandwidth=5.0, rate_noise=1e-3, seed=4)
    law = LeanLaw(plant, design_peak=0.1, estimator=estimator)
    exact = LeanLaw(plant, design_peak=0.1)
    for mine, theirs in zip(law.states, estimator.states(plant), strict=True):
        np.testing.assert_array_equal(mine, theirs)
    assert law.rate_noise == (1e-3, 4)
    assert exact.rate_noise == (0.0, 0)
    assert exact.states[0].shape == (0, 0)
    seen, wind = random_seen(np.random.default_rng(10), model)
    states = np.array([seen.attitude_rate, seen.flight_path_angle + wind])
    blind = seen._replace(attitude_rate=np.nan, angle_of_attack=np.nan)
    assert law.demand(blind, states, 0.01) == pytest.approx(exact.demand(seen, NONE, 0.01))


def test_a_slow_estimator_is_called_so():
    plant = plant_of()
    with pytest.warns(
        UserWarning, match=r"bandwidth = 0\.5 rad/s, is slower than the unst"
    ) as seen:
        LeanLaw(plant, estimator=WindEstimator(bandwidth=0.5))
    assert len(seen) == 1
    assert Path(seen[0].filename).name == Path(__file__).name
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        LeanLaw(plant, estimator=WindEstimator(bandwidth=0.54))


@pytest.mark.parametrize("kind", [int, np.int64, np.uint8])
def test_any_whole_number_is_a_seed(kind):
    estimator = WindEstimator(bandwidth=5.0, rate_noise=1e-3, seed=kind(3))
    assert estimator.seed == 3
    assert type(estimator.seed) is int


def made(kind, **arguments):
    return lambda: kind(plant_of(), **arguments)


def saturated(**arguments):
    return lambda: SaturatedLaw(Autopilot(**{"attitude_gain": 0.3, "rate_gain": 0.4} | arguments))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (made(LeanLaw, reach=0.0), "reach must be between 0.001 and 1"),
        (made(LeanLaw, reach=1.1), "reach must be between"),
        (made(LeanLaw, trust=0.0), "trust must be between 0.001 and 1"),
        (made(LeanLaw, gain=0.0), "gain must be positive"),
        (made(LeanLaw, design_peak=np.inf), "design_peak must be finite"),
        (made(LeanLaw, design_peak=[0.1, 0.2]), "design_peak must be one number"),
        (made(LeanLaw, dead_band=-0.1), "dead_band must be zero or positive"),
        (made(LeanLaw, estimator=5.0), "estimator must be a WindEstimator"),
        (made(TrimLaw, gain=-1.0), "gain must be zero or positive"),
        (made(DeadBandLaw, dead_band=0.0), "dead_band must be between 0.01 and 1"),
        (made(DeadBandLaw, dead_band=1.01), "dead_band must be between 0.01 and 1"),
        (lambda: WindEstimator(bandwidth=0.0), "bandwidth must be positive"),
        (lambda: WindEstimator(bandwidth=5.0, rate_noise=-1.0), "rate_noise must be zero or"),
        (
            lambda: WindEstimator(bandwidth=5.0, seed=-1),
            "seed must be an integer, zero or",
        ),
        (lambda: WindEstimator(bandwidth=5.0, seed=1.5), "seed must be"),
        (lambda: WindEstimator(bandwidth=5.0, seed=True), "seed must be"),
        (lambda: SaturatedLaw(plant_of()), "autopilot must be an Autopilot"),
        (saturated(actuator=Actuator()), "filters only: give actuator, delay and sample_rate to"),
        (saturated(delay=0.1), "gains and filters only"),
        (
            saturated(attitude_gain=[0.3, 0.4]),
            r"autopilot must be one autopilot; got a batch of shape \(2,\)",
        ),
    ],
)
def test_laws_that_cannot_be(make, message):
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize("kind", [TrimLaw, DeadBandLaw, LeanLaw])
def test_laws_need_one_plant_with_a_real_unstable_pole(kind):
    stable = plant_of(coefficients=COEFFICIENTS.replace(mu_alpha=-0.28))
    speed = Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-and-speed")
    for plant in (stable, speed):
        with pytest.raises(InputError, match="real unstable poles"):
            kind(plant)
    many = plant_of(coefficients=COEFFICIENTS.replace(mu_delta=[2.0, 3.0]))
    with pytest.raises(InputError, match="one plant; got a batch"):
        kind(many)


@pytest.mark.parametrize("kind", [TrimLaw, DeadBandLaw, LeanLaw])
def test_a_speed_that_moves_nothing_need_not_be_seen(kind):
    """In the yaw plane gravity does not tie the speed to the path, so the demand is the same."""
    booster = tv.load_vehicle("configuration-i")
    with_speed, without = (
        kind(Plant.from_vehicle(booster, model, "yaw"))
        for model in ("drift-and-speed", "drift-exact")
    )
    seen, _ = random_seen(np.random.default_rng(11), "drift-exact", (40,))
    computed, expected = (law.demand(seen, NONE, 0.005) for law in (with_speed, without))
    np.testing.assert_allclose(computed, expected, rtol=1e-9, atol=1e-15)
    descending = plant_of("drift-and-speed", COEFFICIENTS.replace(C2=-0.0036))
    with pytest.raises(InputError, match="does not measure the speed.*law on .drift-exact"):
        kind(descending)
