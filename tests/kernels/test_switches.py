"""The kernel of boundaries, against the residue condition (4b), matrix exponentials and itself."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import expm
from scipy.optimize import brentq

import tvclin as tv
from tests.turns import by_turns
from tvclin.boundary.limit import boundary_limit
from tvclin.boundary.optimum.minimum_peak import minimum_peaks
from tvclin.kernels import choice, excess
from tvclin.kernels.choice import pinned
from tvclin.linear.deflections import SWITCHES
from tvclin.linear.plant import MODELS

FIELDS = ("limit", "deflection", "switch_time", "status")


def plants(rng, model, count):
    """Return vehicles about like the report's."""
    shape = (count,) if count else ()
    c = tv.Coefficients.from_beta(
        beta=rng.uniform(0.3, 0.7, shape),
        B=rng.uniform(0.08, 0.14, shape),
        C1=rng.uniform(0.02, 0.03, shape),
        C2=rng.uniform(0.002, 0.005, shape),
        b1=rng.uniform(0.02, 0.04, shape),
        b2=rng.uniform(-0.02, 0.018, shape),
        q=rng.uniform(1e-4, 3e-4, shape),
    )
    return tv.Plant(c, model)


def wind_of(kind, rng):
    duration = rng.uniform(3.0, 20.0)
    if kind == "gust":
        return tv.OneMinusCosineGust(peak=-0.05, duration=duration)
    if kind == "two":
        return tv.TriangularWind(peak=0.03, duration=4.0) + tv.OneMinusCosineGust(
            peak=0.06, duration=duration
        ).shift(rng.uniform(1.0, 8.0))
    time = np.concatenate([[0.0], np.cumsum(rng.uniform(0.3, 3.0, 6))])
    return tv.SampledWind(time=time, angle=0.08 * np.append(0.0, rng.uniform(0.0, 1.0, 6)))


def largest_root(plant, wind, dead_band, switch):
    """Return the largest limit whose residue (4b) at the fastest mode is zero, by brentq."""
    full = -plant.coefficients.B * float(wind.peak)

    def residue(y):
        constant = tv.trim_then_hold(plant, wind, y * full, dead_band, switch)
        return np.real(tv.residues(plant, constant, wind)[..., 0]) * np.sign(full)

    tried = np.geomspace(1e-3, 1.0, 400)
    left = residue(tried)
    tried = tried[np.abs(left) > 1e-8 * np.abs(left).max()]  # else it is trimmed throughout
    side = np.sign(residue(tried))
    last = np.flatnonzero(side[:-1] != side[1:])[-1]
    return brentq(lambda y: float(residue(y)), tried[last], tried[last + 1], xtol=1e-16, rtol=1e-15)


@by_turns("model,kind,dead_band", MODELS, ["sampled", "gust", "two"], [0.15, 0.6, 0.95], each=8)
def test_the_limit_is_the_largest_root_of_the_residue_of_the_whole_control(model, kind, dead_band):
    rng = np.random.default_rng(int(100 * dead_band))
    plant, wind = plants(rng, model, 0), wind_of(kind, rng)
    for switch in ("report", "literal"):
        boundary = tv.boundary_limit(plant, wind, dead_band, switch)
        assert not boundary.status.startswith("no limit")
        expected = largest_root(plant, wind, dead_band, switch)
        # Residues of a history of many exponentials are known to some hundred roundings.
        assert boundary.limit == pytest.approx(expected, rel=1e-12)


def winds_of(rng, kind, count):
    if kind == "triangle":
        return tv.TriangularWind(
            peak=rng.uniform(0.03, 0.1, count), duration=rng.uniform(3.0, 30.0, count)
        )
    if kind == "gust":
        return tv.OneMinusCosineGust(peak=0.1, duration=rng.uniform(3.0, 30.0, count))
    angle = rng.uniform(0.0, 0.1, (count, 12)) * np.append(0.0, np.ones(11))
    return tv.SampledWind(time=np.cumsum(rng.uniform(0.2, 2.0, 12)), angle=angle)


@pytest.mark.parametrize("kind", ["triangle", "gust", "sampled"])
@pytest.mark.parametrize("model", MODELS)
def test_plain_python_and_machine_code_solve_alike(model, kind):
    pytest.importorskip("numba")
    computed = []
    for compiled in (False, True):
        rng = np.random.default_rng(4)
        plant, wind, K = plants(rng, model, 6), winds_of(rng, kind, 6), rng.random(6)
        with pinned(compiled):
            computed.append([boundary_limit(plant, wind, K, switch) for switch in SWITCHES])
    for plain, fast in zip(*computed, strict=True):
        # A last digit of an exponential is multiplied by what the demand is a difference of.
        np.testing.assert_allclose(fast.limit, plain.limit, rtol=1e-13)
        np.testing.assert_allclose(fast.switch_time, plain.switch_time, rtol=1e-12, atol=1e-13)
        assert plain.status.tolist() == fast.status.tolist()


@pytest.mark.parametrize("model", MODELS[:3])
def test_a_case_has_the_same_bits_wherever_it_stands_and_in_any_number_of_threads(
    model, monkeypatch
):
    pytest.importorskip("numba")
    rng = np.random.default_rng(8)
    plant, wind, K = plants(rng, model, 300), winds_of(rng, "triangle", 300), rng.random(300)
    monkeypatch.setattr(choice, "_MIN_SECONDS_PER_THREAD", 1e-9)
    with pinned(True):
        monkeypatch.setattr(choice, "thread_count", lambda: 2)
        whole = tv.boundary_limit(plant, wind, K)
        monkeypatch.setattr(choice, "thread_count", lambda: 1)
        for case in (0, 1, 77, 299):
            one = plant.case(case, (300,)), wind.case(case, (300,)), K[case]
            single = tv.boundary_limit(*one)
            for name in FIELDS:
                assert getattr(single, name) == getattr(whole, name)[case], name


@pytest.mark.parametrize("seed", range(3))
def test_the_state_of_the_filter_is_that_of_a_matrix_exponential(seed):
    """Swift, slow, swinging and repeated modes, driven by ramps and by half waves."""
    rng = np.random.default_rng(seed)
    for b1, q in ((0.03, 0.0), (0.03, 2e-4), (0.03, 2.25e-4), (40.0, 9.0), (0.4, 30.0), (0.0, 0.0)):
        for rate in (0.0, -0.7, 1.3j):
            kind = complex if rate else float
            c = rng.normal(size=(1, 2)).astype(kind)
            x, y, u = *rng.normal(size=2), rng.uniform(0.1, 9.0)
            # The forcing is e^(rate v) (c0 + c1 v): two more states of an autonomous system.
            A = np.array([[0, 1, 0, 0], [-q, -b1, 1, 0], [0, 0, rate, 1], [0, 0, 0, rate]], kind)
            expected = np.real(expm(A * u) @ np.array([0, 0, *c[0]]))[:2]
            expected += np.real(expm(A * u) @ np.array([x, y, 0, 0]))[:2]
            work = np.empty((2, 2), kind)
            result = excess.advance_filter(c, np.array([rate], kind), u, x, y, b1, q, work)
            np.testing.assert_allclose(result, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("degree", [0, 1, 3, 14])
@pytest.mark.parametrize("pole", [0.01, 0.5, 20.0, 0.1 + 0.3j])
def test_the_future_of_a_piece_is_the_integral(degree, pole):
    c = np.random.default_rng(degree).uniform(0.5, 1.0, (1, degree + 1))
    for u, left in ((0.0, 1.3), (0.7, 0.01), (0.4, 1.1)):

        def integrand(v, u=u):
            return np.polyval(c[0, ::-1], u + v) * np.exp(-pole * v)

        expected = quad(lambda v: integrand(v).real, 0.0, left, epsabs=0.0, epsrel=1e-13)[0]
        result = excess.piece_integral(c, np.zeros(1), u, left, pole)
        assert result.real == pytest.approx(expected, rel=1e-12)


@pytest.mark.thorough
def test_where_a_pair_needs_trim_for_ever_its_largest_may_come_after_the_wind():
    """Filters that swing on after a short wind, looked at closely."""
    c = tv.Coefficients.from_beta(beta=0.05, B=0.1, b1=0.02, b2=[2.0, -1.5], q=0.9)
    plant = tv.Plant(c.replace(C1=-0.4, C2=0.0), "drift-and-speed")
    wind = tv.RectangularWind(peak=0.1, duration=3.3)
    boundary = tv.boundary_limit(plant, wind)
    assert all(word.startswith("two unstable poles are a pair") for word in boundary.status)
    trim = tv.trim_deflection(plant, wind)(np.linspace(0.0, 40.0, 400_001))
    np.testing.assert_allclose(np.abs(boundary.deflection), np.abs(trim).max(axis=-1), rtol=1e-7)


@pytest.mark.thorough
def test_what_is_proved_to_be_enough_for_three_poles_is_no_less_than_the_least_peak():
    rng = np.random.default_rng(2)
    plant, wind = plants(rng, "drift-and-speed", 12), winds_of(rng, "triangle", 12)
    minimum = minimum_peaks(plant, wind)
    for part in (0.9, 0.999, 1.001, 1.1, 2.0):
        given = part * minimum
        taken = minimum_peaks(plant, wind, given)
        proved = taken == given
        np.testing.assert_allclose(taken[~proved], minimum[~proved], rtol=1e-12)
        assert not np.any(proved) if part < 1.0 else np.mean(proved) > 0.5 * (part > 1.05)
