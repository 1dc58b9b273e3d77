"""Half relief: why one half, and what its gains do with a stop, a slow nozzle and no vane."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tvclin as tv
from tests.flying import BETA, COEFFICIENTS, PEAK, SERVO, WIND, B, plant_of
from tests.turns import usual

HALF = tv.control.half_relief_gains(COEFFICIENTS)
RATIOS = pytest.mark.parametrize("ratio", [0.4, 0.5, 0.6])


def saturated(value, y):
    return min(max(value, -y), y)


def test_the_gains_are_three_numbers_over_the_unstable_pole():
    damped, ahead = COEFFICIENTS.replace(damping=0.2), COEFFICIENTS.replace(mu_delta=-2.6)
    for coefficients in (COEFFICIENTS, damped, ahead):
        A, inputs, _, _ = plant_of(coefficients=coefficients).matrices()
        pole = np.linalg.eigvals(A).real.max()
        gains = tv.control.half_relief_gains(coefficients)
        row = np.array([gains.attitude_gain + gains.alpha_gain, gains.rate_gain])
        closed = np.sort(np.linalg.eigvals(A + np.outer(inputs[:, 0], row)))
        w, zeta = 2.4 * pole, 1.2
        far = w * np.sqrt(zeta**2 - 1.0)
        assert closed == pytest.approx([-zeta * w - far, -zeta * w + far], rel=1e-9)
        # at rest in a wind of one: 0 = mu_alpha (theta - 1) - mu_delta (a0 theta + b0 (theta - 1))
        c = coefficients
        stiffness = c.mu_delta * row[0] - c.mu_alpha
        theta = (c.mu_delta * gains.alpha_gain - c.mu_alpha) / stiffness
        assert theta == pytest.approx(0.5, rel=1e-9)
        assert row[0] * theta - gains.alpha_gain == pytest.approx(-0.5 * c.B, rel=1e-9)


def test_a_batch_has_gains_of_its_own():
    many = COEFFICIENTS.replace(mu_alpha=np.array([0.1, 0.3]))
    batch = tv.control.half_relief_gains(many, delay=0.01)
    for k, mu_alpha in enumerate((0.1, 0.3)):
        one = tv.control.half_relief_gains(COEFFICIENTS.replace(mu_alpha=mu_alpha))
        for name in ("attitude_gain", "rate_gain", "alpha_gain"):
            assert getattr(batch, name)[k] == pytest.approx(getattr(one, name), rel=1e-12)
    assert batch.delay == 0.01


def test_a_stable_vehicle_has_no_pole_to_begin_with():
    stable = COEFFICIENTS.replace(mu_alpha=np.array([0.2, -0.1]))
    with pytest.raises(tv.InputError, match="aerodynamically unstable vehicle.*got -0.1"):
        tv.control.half_relief_gains(stable)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", usual(range(6), 0, 1))
def test_what_rests_within_the_reach_comes_back_and_its_energy_falls(seed):
    """Any k > 1, d > 0: theta'' = theta - sat(k theta + d theta') from rest, time in 1/beta."""
    draw = np.random.default_rng(seed)
    k, d, y = 1.0 + draw.uniform(0.2, 8.0), draw.uniform(0.2, 6.0), draw.uniform(0.1, 2.0)

    def rates(_, state):
        return [state[1], state[0] - saturated(k * state[0] + d * state[1], y)]

    def potential(theta):  # of V' = sat(k theta) - theta
        inner = 0.5 * k * min(abs(theta), y / k) ** 2
        return inner + y * max(abs(theta) - y / k, 0.0) - 0.5 * theta**2

    for part, returns in ((0.97, True), (1.03, False)):
        span = 60.0 if returns else 12.0
        options = {"rtol": 1e-9, "atol": 1e-12, "max_step": 0.02}
        computed = solve_ivp(rates, (0.0, span), [part * y, 0.0], **options).y
        energy = 0.5 * computed[1] ** 2 + [potential(theta) for theta in computed[0]]
        assert np.all(np.diff(energy[: np.argmax(np.abs(computed[0]) > 1.1 * y) or None]) < 1e-8)
        assert (np.abs(computed[0, -1]) < y) == returns
        if returns:
            assert np.abs(computed[0]).max() <= part * y * (1.0 + 1e-9)
            assert energy[-1] < 0.2 * energy[0]


@RATIOS
@pytest.mark.parametrize("tau_beta", [100.0, 400.0])
def test_in_slow_winds_the_larger_of_ratio_and_lean_is_needed(ratio, tau_beta):
    """To hold takes r, to come back 1 - r, but for what the wind changes until the loop rests.

    The loop lags by 2/2.4 of a time constant, in which the wind changes by 2/tau_beta of its peak
    each, and then a sample may pass until it sees the stop, in which z moves by h beta.
    """
    rate = 25.0
    wind = tv.TriangularWind(peak=PEAK, duration=tau_beta / BETA)
    gains = tv.control.relief_gains(
        COEFFICIENTS, natural_frequency=2.4 * BETA, damping=1.2, alpha_ratio=ratio
    )
    doubt = 2.0 / tau_beta + BETA / rate
    needed = max(ratio, 1.0 - ratio)
    limits = np.array([needed - doubt, needed + doubt, 0.9]) * B * PEAK
    both = wind.before([[np.inf], [wind.duration / 2.0]])
    flights = tv.fly_many(plant_of(), gains, both, deflection_limit=limits, sample_rate=rate)
    whole, stopped = flights.status == "survived"

    assert (whole & stopped).tolist() == [False, True, True]
    assert whole[0] == (ratio < 0.5)  # more lean than half: only the stop is lost
    free = tv.forecast_free_limit(plant_of(), wind).limit
    assert free == pytest.approx(0.5, abs=2.0 / tau_beta)
    assert (needed == 0.5) == (ratio == 0.5)


def test_the_lean_follows_a_steady_rise_by_the_formula():
    """z/w = (1 - r)(1 + (1 - 2 zeta/omega) s + ...): in a ramp it runs ahead by that, or not."""
    ramp = tv.winds.AsymmetricTriangularWind(peak=PEAK, duration=40.0 / BETA, peak_time=40.0 / BETA)
    late = np.array([20.0, 30.0]) / BETA
    for frequency, damping in ((2.4, 1.2), (2.83, 0.85)):
        gains = tv.control.relief_gains(
            COEFFICIENTS, natural_frequency=frequency * BETA, damping=damping, alpha_ratio=0.4
        )
        flown = tv.fly(plant_of(), tv.SaturatedLaw(gains), ramp, late, deflection_limit=1.5)
        lean = flown.outputs["attitude"] + flown.outputs["attitude_rate"] / BETA
        ahead = (1.0 - 2.0 * damping / frequency) / 40.0
        assert lean / PEAK == pytest.approx(0.6 * (BETA * late / 40.0 + ahead), abs=1e-7)


@pytest.mark.thorough
@pytest.mark.parametrize("compiled", [False, True])
def test_a_gain_is_that_of_many_flights_to_the_last_digit(compiled):
    from tvclin.kernels.choice import available, pinned

    if compiled and not available():
        pytest.skip("needs numba")
    plant, law = plant_of("drift-exact"), tv.SaturatedLaw(HALF)
    options = {"actuator": SERVO, "sample_rate": 50.0, "delay": 0.03, "deflection_limit": 0.6 * B}
    until = float(WIND.onset) + 600 / 50.0
    times = float(WIND.onset) + np.arange(601.0) / 50.0
    for gain in (0.5, 1.0, 1.7):
        with pinned(compiled):
            one = tv.fly(plant, law, WIND, times, gain=gain, **options)
            many = tv.fly_many(plant, law, WIND, gain=[gain, 3.0], until=until, **options)
        assert one.outputs["attitude"][-1] == many.final_attitude[0]
        assert np.abs(one.outputs["attitude"]).max() == many.peak_attitude[0]


@pytest.mark.thorough
def test_without_pause_a_gain_is_that_of_the_gains():
    plant, times, gain = plant_of("drift-exact"), np.linspace(0.0, 15.0, 40), 1.3
    louder = tv.Autopilot(
        **{
            name: gain * getattr(HALF, name)
            for name in ("attitude_gain", "rate_gain", "alpha_gain")
        }
    )
    options = {"deflection_limit": 0.4 * B * PEAK, "actuator": SERVO}
    first = tv.fly(plant, tv.SaturatedLaw(HALF), WIND, times, gain=gain, **options)
    other = tv.fly(plant, tv.SaturatedLaw(louder), WIND, times, **options)
    size = np.abs(other.outputs["attitude"]).max()
    np.testing.assert_allclose(first.outputs, other.outputs, rtol=0, atol=1e-7 * size)
    with pytest.raises(tv.InputError, match="gain must be positive"):
        tv.fly(plant, tv.SaturatedLaw(HALF), WIND, times, gain=0.0, **options)
    switched = tv.control.DeadBandLaw(plant_of())
    levels = [
        tv.fly(plant, switched, WIND, [2.0], deflection_limit=0.5 * B * PEAK, gain=g)
        for g in (0.5, 1.0)
    ]
    assert np.abs(levels[0].outputs["deflection"][0]) < 0.5 * B * PEAK
    assert np.abs(levels[1].outputs["deflection"][0]) == 0.5 * B * PEAK


def observed(law):
    return tv.control.EstimatedLaw(
        law, tv.control.WindEstimator(bandwidth=6.0), plant_of("drift-exact")
    )


def test_an_estimated_law_sees_what_its_estimator_says():
    draw = np.random.default_rng(3)
    law = tv.SaturatedLaw(tv.Autopilot(attitude_gain=0.3, rate_gain=0.4, alpha_gain=0.07))
    theta, rate, path, alpha, delta, seen_rate, wind = draw.normal(size=7)
    shown = tv.control.Measurement(theta, rate, path, alpha, delta)
    request = observed(law).demand(shown, np.array([seen_rate, wind]), 1.0)
    assert request == pytest.approx(
        0.3 * theta + 0.4 * seen_rate + 0.07 * (theta - wind), rel=1e-12
    )


class Written(tv.control.Law):
    """The same loop as one law in Python: gains on an observer that is written out here."""

    def __init__(self, integral):
        self.integral = integral

    @property
    def states(self):
        c, w = COEFFICIENTS, 6.0
        F, G = np.zeros((3, 3)), np.zeros((3, 5))
        # q^' = mu_alpha (theta - d^) - mu_delta delta + 1.4 w (q - q^)
        # d^' = -w^2/mu_alpha (q - q^)
        F[0, :2], G[0, [0, 1, 4]] = (-1.4 * w, -c.mu_alpha), (c.mu_alpha, 1.4 * w, -c.mu_delta)
        F[1, 0], G[1, 1] = w**2 / c.mu_alpha, -(w**2) / c.mu_alpha
        G[2, 0] = 1.0
        return F, G

    def demand(self, measured, states, limit):
        theta = measured.attitude
        request = HALF.attitude_gain * theta + HALF.rate_gain * states[0]
        return request + HALF.alpha_gain * (theta - states[1]) + self.integral * states[2]


@pytest.mark.thorough
@pytest.mark.parametrize("integral", [0.0, 0.02])
@pytest.mark.parametrize("compiled", [False, True])
def test_an_estimated_law_flies_as_its_loop_written_out(integral, compiled):
    from dataclasses import replace

    from tvclin.kernels.choice import available, pinned

    if compiled and not available():
        pytest.skip("needs numba")
    plant, times = plant_of("drift-exact"), np.linspace(0.1, 20.0, 60)
    options = {"deflection_limit": 0.55 * B * PEAK, "actuator": SERVO, "sample_rate": 50.0}
    law = observed(tv.SaturatedLaw(replace(HALF, integral_gain=integral)))
    with pinned(compiled):
        flown = tv.fly(plant, law, WIND, times, **options)
    with pinned(False):
        other = tv.fly(plant, Written(integral), WIND, times, **options)
    size = np.abs(other.outputs["attitude"]).max()
    np.testing.assert_allclose(flown.outputs, other.outputs, rtol=0, atol=1e-9 * size)


def test_a_law_that_estimates_needs_no_second_estimator():
    observer = tv.control.WindEstimator(bandwidth=6.0)
    lean = tv.RecoverableAttitudeLaw(plant_of(), estimator=observer)
    for law in (lean, observed(tv.TrimLaw(plant_of()))):
        with pytest.raises(tv.InputError, match="law has an estimator already"):
            observed(law)
    noisy = tv.control.WindEstimator(bandwidth=6.0, rate_noise=1e-3, seed=2)
    band = tv.control.EstimatedLaw(
        tv.control.DeadBandLaw(plant_of(), dead_band=0.4), noisy, plant_of()
    )
    assert (band.engage, band.rate_noise) == (0.4, (1e-3, 2))


def test_estimated_the_lean_law_is_its_own_with_that_estimator():
    """A law that leans, given an estimator from outside, takes the same measurements."""
    plant, observer = plant_of(), tv.control.WindEstimator(bandwidth=6.0)
    inside = tv.RecoverableAttitudeLaw(plant, reach=0.7, estimator=observer)
    outside = tv.control.EstimatedLaw(tv.RecoverableAttitudeLaw(plant, reach=0.7), observer, plant)
    assert inside.numbers == outside.numbers
    shown = tv.control.Measurement(0.02, 0.01, 0.0, 0.5, 0.001)
    states = np.array([0.012, 0.05])
    assert outside.demand(shown, states, 0.01) == pytest.approx(inside.demand(shown, states, 0.01))
