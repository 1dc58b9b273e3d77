"""Many flights at once: beside `fly`, beside scipy's solver, beside closed forms, case by case."""

import itertools
from functools import lru_cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import tvclin as tv
from tvclin import Actuator, Autopilot, Coefficients, InputError, Plant, SampledWind, TriangularWind
from tvclin.kernels.choice import available, pinned

PEAK = 0.08
COEFFICIENTS = Coefficients.from_vehicle(tv.load_vehicle("configuration-i"))
BETA, B = float(COEFFICIENTS.beta), float(COEFFICIENTS.B)
WIND = SampledWind(
    time=[0.013, 2.0, 7.577, 7.577, 11.0], angle=PEAK * np.array([0, 0.3, 1, 0.8, 0])
)
GAINS = {"attitude_gain": 3 * B, "rate_gain": 3 * B / BETA}
MORE = {"alpha_gain": 0.03, "integral_gain": 0.02}
SERVO, LAG = Actuator(natural_frequency=20.0), Actuator(natural_frequency=8.0, damping=None)
GYRO = tv.WindEstimator(bandwidth=6.0, rate_noise=1e-4, seed=3)
LAWS = {
    "gains": lambda plant: tv.SaturatedLaw(Autopilot(**GAINS)),
    "all gains": lambda plant: tv.SaturatedLaw(Autopilot(**GAINS, **MORE)),
    "trim": lambda plant: tv.TrimLaw(plant_of(), gain=4.0),
    "dead band": lambda plant: tv.DeadBandLaw(plant_of()),
    "lean": lambda plant: tv.RecoverableAttitudeLaw(plant, gain=5.0, design_peak=PEAK),
    "estimated": lambda plant: tv.RecoverableAttitudeLaw(
        plant, reach=0.7, gain=4.0, estimator=tv.WindEstimator(bandwidth=6.0)
    ),
    "noisy": lambda plant: tv.RecoverableAttitudeLaw(plant, dead_band=0.001, estimator=GYRO),
}
HARDWARE = ({}, {"actuator": SERVO, "rate_limit": 0.006}, {"actuator": LAG, "rate_limit": 0.01})
NEEDS_NUMBA = pytest.mark.skipif(not available(), reason="needs numba")
EACH_TWIN = pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=NEEDS_NUMBA)])


def plant_of(model="fixed-path", coefficients=COEFFICIENTS):
    return Plant.from_coefficients(coefficients, model)


def shown(flown):
    """Return the largest sizes and the last attitude of `fly`, in the order of `numbers`."""
    outputs = np.abs(flown.outputs)
    return np.array([*outputs[[0, 1, -1, -2]].max(axis=1), flown.outputs[0, -1]])


def numbers(flown):
    return np.stack(
        [
            flown.peak_attitude,
            flown.peak_attitude_rate,
            flown.peak_deflection,
            flown.peak_angle_of_attack,
            flown.final_attitude,
        ]
    )


@EACH_TWIN
@pytest.mark.parametrize("hardware", [*HARDWARE, {"rate_limit": 0.006}])
@pytest.mark.parametrize("model", ["fixed-path", "drift-exact"])
@pytest.mark.parametrize("name", LAWS)
def test_one_sampled_flight_is_that_of_fly(name, model, hardware, compiled):
    plant, rate, start = plant_of(model), 50.0, float(WIND.onset)
    law, limit, stop = LAWS[name](plant), 0.8 * B * PEAK, start + 600 / rate
    # A deflection without a nozzle jumps at the samples, where rounding chooses the side.
    late = 1e-12 if not hardware else 0.0
    times = np.array([*(start + np.arange(600) / rate + late), stop])
    flown = tv.fly(plant, law, WIND, times, deflection_limit=limit, sample_rate=rate, **hardware)
    with pinned(compiled):
        many = tv.fly_many(
            plant, law, WIND, deflection_limit=limit, sample_rate=rate, until=stop, **hardware
        )
    assert many.peak_attitude.shape == ()
    expected = shown(flown)
    np.testing.assert_allclose(numbers(many), expected, rtol=1e-10, atol=1e-10 * expected[0])


@pytest.mark.parametrize("hardware", HARDWARE)
@pytest.mark.parametrize("model", ["fixed-path", "drift", "drift-exact"])
@pytest.mark.parametrize(
    ("name", "compiled"),
    [
        *((name, False) for name in ("all gains", "trim", "dead band")),
        # Of the lean numpy's twin, the same to rounding, is slow for one flight.
        *(
            pytest.param(name, True, marks=NEEDS_NUMBA)
            for name in ("all gains", "trim", "dead band", "lean", "estimated")
        ),
    ],
)
def test_one_flight_without_pause_is_that_of_fly(name, model, hardware, compiled):
    plant, limit = plant_of(model), 0.9 * B * PEAK
    # That of fly, where limits leave corners; the lean is followed in fixed steps.
    law, accuracy = LAWS[name](plant), 1e-5 if name == "lean" and hardware else 2e-6
    flown = tv.fly(plant, law, WIND, [5.0, 20.0], deflection_limit=limit, **hardware)
    for k, stop in enumerate((5.0, 20.0)):
        with pinned(compiled):
            many = tv.fly_many(plant, law, WIND, deflection_limit=limit, until=stop, **hardware)
        expected = flown.outputs[0, k]
        assert float(many.final_attitude) == pytest.approx(
            expected, abs=accuracy * max(PEAK, abs(expected))
        )


def saturated(limit, most, gains, wind, times):
    """Return attitude and deflection of gains behind limits, with scipy's solver."""
    w, damping, c = SERVO.natural_frequency, SERVO.damping, COEFFICIENTS

    def rates(t, y):
        command = np.clip(gains["attitude_gain"] * y[0] + gains["rate_gain"] * y[1], -limit, limit)
        pull = w * w * (command - y[2]) - 2 * damping * w * y[3]
        if abs(y[3]) >= most and pull * y[3] > 0.0:
            pull = 0.0
        turn = c.mu_alpha * (y[0] - float(wind(t))) - c.mu_delta * np.clip(y[2], -limit, limit)
        return [y[1], turn, np.clip(y[3], -most, most), pull]

    edges, y, found = [*np.unique(wind.knots), times[-1]], np.zeros(4), []
    for a, b in itertools.pairwise(edges):
        here = times[(times >= a) & (times < b)]
        run = solve_ivp(
            rates,
            (a, np.nextafter(b, a)),
            y,
            method="DOP853",
            max_step=0.02,
            rtol=1e-12,
            atol=1e-14,
            dense_output=True,
        )
        found.append(run.sol(here))
        y = run.y[:, -1]
    return np.concatenate([*found, y[:, np.newaxis]], axis=1)


@EACH_TWIN
@pytest.mark.parametrize(("part", "most"), [(1.25, 0.02), (1.25, 0.0045), (3.0, 1.0)])
def test_gains_with_all_limits_are_flown_to_2e_8_of_the_peak(part, most, compiled):
    limit, wind = part * B * PEAK, TriangularWind(peak=PEAK, duration=12.0)
    times = np.linspace(0.0, 24.0, 24001)
    states = saturated(limit, most, GAINS, wind, times)
    with pinned(compiled):
        flown = tv.fly_many(
            plant_of(),
            tv.SaturatedLaw(Autopilot(**GAINS)),
            wind,
            deflection_limit=limit,
            rate_limit=most,
            actuator=SERVO,
            until=24.0,
        )
    peak = np.abs(states[0]).max()
    # The largest of 24,000 samples is below the summit by theta'' h^2/8.
    below = np.abs(np.diff(states[1])).max() * 1e-3 / 8
    assert -2e-8 * peak <= float(flown.peak_attitude) - peak <= 2e-8 * peak + below
    assert float(flown.final_attitude) == pytest.approx(states[0, -1], abs=2e-8 * peak)
    assert float(flown.peak_deflection) == pytest.approx(
        min(np.abs(states[2]).max(), limit), rel=1e-5
    )
    assert float(flown.peak_deflection_rate) == pytest.approx(
        min(np.abs(states[3]).max(), most), rel=1e-5
    )


@lru_cache
def solved(limit, most):
    """Return the attitude after 24 s by a solver that knows no limits, and the largest."""
    wind = TriangularWind(peak=PEAK, duration=12.0)
    theta = saturated(limit, most, GAINS, wind, np.linspace(0.0, 24.0, 2401))[0]
    return theta[-1], np.abs(theta).max()


@EACH_TWIN
@pytest.mark.parametrize(("accuracy", "off"), [(1e-11, 1e-10), (2e-7, 5e-7), (1e-5, 1e-4)])
def test_flights_are_as_exact_as_asked(accuracy, off, compiled):
    most, limits = 0.02, np.array([1.25, 1.4, 1.6]) * B * PEAK
    wind = TriangularWind(peak=PEAK, duration=12.0)
    with pinned(compiled):
        flown = tv.fly_many(
            plant_of(),
            tv.SaturatedLaw(Autopilot(**GAINS)),
            wind,
            deflection_limit=limits,
            rate_limit=most,
            actuator=SERVO,
            until=24.0,
            accuracy=accuracy,
        )
    true = [solved(limit, most) for limit in limits]
    last, peak = np.transpose(true)
    assert np.max(np.abs(flown.final_attitude - last) / peak) < off


def test_the_errors_of_peaks_are_those_that_are_stated():
    part = np.random.default_rng(1).uniform(1.2, 1.6, 200)

    def flown(accuracy):
        return tv.fly_many(
            plant_of(),
            tv.SaturatedLaw(Autopilot(**GAINS)),
            TriangularWind(peak=PEAK, duration=12.0),
            deflection_limit=part * B * PEAK,
            rate_limit=0.02,
            actuator=SERVO,
            until=24.0,
            accuracy=accuracy,
        )

    exact = flown(1e-11)
    for accuracy, off, rate_off in ((1e-10, 1e-9, 1e-6), (1e-8, 2e-8, 1e-5), (2e-7, 5e-7, 5e-4)):
        found = flown(accuracy)
        np.testing.assert_allclose(found.peak_attitude, exact.peak_attitude, rtol=off)
        rates = found.peak_deflection_rate, exact.peak_deflection_rate
        np.testing.assert_allclose(*rates, rtol=rate_off)


@EACH_TWIN
def test_a_late_short_gust_is_an_impulse_that_is_not_missed(compiled):
    width, size, late, stop = 1e-3, 0.5, 30.0037, 30.525
    gust = SampledWind(time=[late, late, late + width, late + width], angle=[0, size, size, 0])
    calm = TriangularWind(peak=0.01, duration=5.0)
    plant, law, c = plant_of(), LAWS["gains"](None), COEFFICIENTS
    closed = np.zeros((3, 3))  # attitude, rate, wind
    closed[0, 1], closed[1, 2] = 1.0, -c.mu_alpha
    closed[1, 0] = c.mu_alpha - c.mu_delta * GAINS["attitude_gain"]
    closed[1, 1] = -c.mu_delta * GAINS["rate_gain"]
    hit = expm(width * closed) @ [0.0, 0.0, size]
    expected = (expm((stop - late - width) * closed[:2, :2]) @ hit[:2])[0]
    limits = {"deflection_limit": 1.0}
    with pinned(compiled):
        before, after = (
            tv.fly_many(plant, law, wind, **limits, until=stop).final_attitude
            for wind in (calm, calm + gust)
        )
        sampled = tv.fly_many(plant, law, calm + gust, **limits, sample_rate=40.0, until=stop)
    assert abs(expected) > 1e-5
    assert float(after - before) == pytest.approx(expected, abs=1e-8 * size)
    flown = tv.fly(plant, law, calm + gust, [stop], **limits, sample_rate=40.0)
    assert float(sampled.final_attitude) == pytest.approx(flown.outputs[0, 0], rel=1e-9)


@EACH_TWIN
def test_without_limits_a_flight_is_the_linear_closed_loop(compiled):
    gains = Autopilot(**GAINS, **MORE)
    c = COEFFICIENTS
    closed = np.zeros((4, 4))  # attitude, rate, integral, wind
    closed[0, 1] = closed[2, 0] = 1.0
    closed[1, 0] = c.mu_alpha - c.mu_delta * (GAINS["attitude_gain"] + MORE["alpha_gain"])
    closed[1, 1] = -c.mu_delta * GAINS["rate_gain"]
    closed[1, 2] = -c.mu_delta * MORE["integral_gain"]
    closed[1, 3] = -c.mu_alpha + c.mu_delta * MORE["alpha_gain"]
    begun = expm(6.0 * closed) @ [0, 0, 0, PEAK]
    expected = expm(3.0 * closed[:3, :3]) @ begun[:3]
    wind = tv.RectangularWind(peak=PEAK, duration=6.0)
    with pinned(compiled):
        flown = tv.fly_many(
            plant_of(), tv.SaturatedLaw(gains), wind, deflection_limit=10.0, until=9.0
        )
    assert float(flown.final_attitude) == pytest.approx(expected[0], abs=1e-8 * PEAK)
    assert float(flown.saturated_time_fraction) == 0.0


@EACH_TWIN
@pytest.mark.parametrize("name", ["trim", "lean"])
@pytest.mark.parametrize("model", ["fixed-path", "drift-exact"])
def test_fates_are_those_of_the_boundary(name, model, compiled):
    plant, wind = plant_of(model), TriangularWind(peak=PEAK, duration=8.0)
    law = LAWS[name](plant)
    found = tv.closed_loop_boundary(plant, law, wind, sample_rate=40.0)
    limits = found.scan * B * PEAK
    with pinned(compiled):
        sampled = tv.fly_many(plant, law, wind, deflection_limit=limits, sample_rate=40.0)
        flown = tv.fly_many(plant, law, wind, deflection_limit=limits)
    np.testing.assert_array_equal(sampled.status == "survived", found.survives)
    assert set(sampled.status) == {"survived", "lost"}
    apart = np.flatnonzero((flown.status == "survived") != found.survives)
    within = np.ptp(found.scan[apart]) if apart.size else 0.0
    assert within < (found.scan[-1] - found.scan[0]) / 60  # the edge, computed without pause
    assert np.all(sampled.peak_deflection <= limits)


@EACH_TWIN
def test_every_case_has_its_own_plant_wind_gains_and_limit(compiled):
    rng = np.random.default_rng(5)
    factors = rng.uniform(0.9, 1.1, (4, 3, 2))
    coefficients = Coefficients.from_vehicle(
        tv.load_vehicle("configuration-i").replace(thrust=2.495e6 * factors[0])
    )
    plant = plant_of("drift-exact", coefficients)
    wind = TriangularWind(peak=PEAK * factors[1], duration=8.0)
    gains = Autopilot(attitude_gain=3 * B * factors[2], rate_gain=3 * B / BETA)
    limit = B * PEAK * factors[3]
    with pinned(compiled):
        flown = tv.fly_many(plant, gains, wind, deflection_limit=limit, until=12.0)
        for place in np.ndindex(3, 2):
            one = plant_of(
                "drift-exact",
                Coefficients.from_vehicle(
                    tv.load_vehicle("configuration-i").replace(thrust=2.495e6 * factors[0][place])
                ),
            )
            alone = tv.fly_many(
                one,
                tv.SaturatedLaw(
                    Autopilot(attitude_gain=3 * B * factors[2][place], rate_gain=3 * B / BETA)
                ),
                TriangularWind(peak=PEAK * factors[1][place], duration=8.0),
                deflection_limit=limit[place],
                until=12.0,
            )
            np.testing.assert_allclose(
                numbers(flown)[(slice(None), *place)], numbers(alone), rtol=1e-12
            )
            assert flown.status[place] == alone.status


def test_laws_may_be_an_array():
    plant, wind = plant_of(), TriangularWind(peak=PEAK, duration=8.0)
    laws = np.array([LAWS[name](plant) for name in ("gains", "dead band", "lean", "noisy")])
    limit = 0.8 * B * PEAK
    every = tv.fly_many(plant, laws, wind, deflection_limit=limit, sample_rate=50.0)
    for k, law in enumerate(laws):
        alone = tv.fly_many(plant, law, wind, deflection_limit=limit, sample_rate=50.0)
        np.testing.assert_array_equal(numbers(every)[:, k], numbers(alone))
        assert every.status[k] == alone.status


@EACH_TWIN
def test_a_curved_gust_is_that_of_fly(compiled):
    wind = tv.OneMinusCosineGust(peak=PEAK, duration=7.0)
    plant, law, limit = plant_of(), LAWS["trim"](plant_of()), 0.9 * B * PEAK
    expected = tv.fly(plant, law, wind, [6.0], deflection_limit=limit).outputs[0, -1]
    with pinned(compiled):
        flown = tv.fly_many(plant, law, wind, deflection_limit=limit, until=6.0)
    assert float(flown.final_attitude) == pytest.approx(expected, abs=1e-8 * PEAK)


@EACH_TWIN
@pytest.mark.parametrize("sample_rate", [None, 50.0])
def test_a_bad_case_has_its_status_and_the_others_go_on(sample_rate, compiled):
    plant, law = plant_of(), LAWS["trim"](plant_of())
    wind = TriangularWind(peak=PEAK, duration=8.0) * np.array([1.0, 0.0, 1.0, 1.0, 1.0])
    limits = B * PEAK * np.array([0.9, 0.9, np.nan, -1.0, 0.3])
    with pinned(compiled):
        flown = tv.fly_many(plant, law, wind, deflection_limit=limits, sample_rate=sample_rate)
        alone = tv.fly_many(
            plant, law, wind * np.ones(5), deflection_limit=limits[0], sample_rate=sample_rate
        )
    expected = ["survived", "no flight", "no flight", "no flight", "lost"]
    assert flown.status.tolist() == expected
    assert np.isnan(numbers(flown)[:, 1:4]).all()
    np.testing.assert_array_equal(numbers(flown)[:, 0], numbers(alone)[:, 0])


@EACH_TWIN
def test_a_gust_of_many_powers_is_that_of_fly(compiled):
    """A wind that is filtered again and again is a polynomial of the 50th degree."""
    once = TriangularWind(peak=PEAK, duration=6.0)
    wind = once.filter([1.0], np.poly([-1.0] * 4)).before(12.0)
    law = tv.SaturatedLaw(Autopilot(**GAINS))
    with pinned(compiled):
        found = tv.fly_many(plant_of(), law, wind, deflection_limit=B * PEAK, until=14.0)
    flown = tv.fly(plant_of(), law, wind, [14.0], deflection_limit=B * PEAK)
    assert float(found.final_attitude) == pytest.approx(flown.outputs[0, 0], abs=1e-7 * PEAK)


@EACH_TWIN
def test_a_flight_that_grows_again_after_a_calm_is_not_saved(compiled):
    """Too small a gain leaves a slow mode that grows, from next to nothing, to beyond return."""
    law = tv.SaturatedLaw(Autopilot(attitude_gain=0.9 * B, rate_gain=GAINS["rate_gain"]))
    wind = TriangularWind(peak=1e-3 * PEAK, duration=8.0)
    ends = np.array([60.0, 700.0])
    with pinned(compiled):
        early, late = (
            tv.fly_many(plant_of(), law, wind, deflection_limit=B * PEAK, until=end) for end in ends
        )
    assert early.status == "survived"
    assert late.status == "lost"
    assert abs(late.final_attitude) > PEAK > 10.0 * abs(early.final_attitude)


def test_a_stable_plant_flies_to_a_time_but_has_no_fate():
    stable = plant_of(coefficients=Coefficients(mu_alpha=-0.2, mu_delta=1.0))
    law = tv.SaturatedLaw(Autopilot(attitude_gain=0.1, rate_gain=0.5))
    wind = TriangularWind(peak=PEAK, duration=8.0)
    assert tv.fly_many(stable, law, wind, deflection_limit=0.1).status == "no flight"
    flown = tv.fly_many(stable, law, wind, deflection_limit=0.1, until=9.0)
    expected = tv.fly(stable, law, wind, [9.0], deflection_limit=0.1).outputs[0, -1]
    assert flown.status == "undecided"
    assert float(flown.final_attitude) == pytest.approx(expected, abs=1e-8 * PEAK)


class Odd(tv.Law):
    """A law that is not linear."""

    def demand(self, seen, states, limit):
        return seen.attitude**3


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"law": Odd()}, "neither linear"),
        ({"law": "trim"}, "law must be a Law"),
        ({"law": Autopilot(**GAINS, delay=0.1)}, "gains only"),
        ({"deflection_limit": -1.0}, "deflection_limit must be positive"),
        ({"deflection_limit": np.ones(3), "rate_limit": np.ones(2)}, "broadcast"),
        ({"rate_limit": 0.1}, "needs an actuator or a sample_rate"),
        ({"law": LAWS["noisy"](plant_of())}, "give a sample_rate"),
        ({"actuator": SERVO, "sample_rate": 10.0}, "sample_rate must be at least 40"),
        ({"plant": 1}, "plant must be a Plant"),
        ({"wind": 1}, "wind must be a History"),
        ({"until": np.nan}, "until must be finite"),
        ({"accuracy": 0.0}, "accuracy must be between 1e-11 and 0.0001; got 0"),
        ({"accuracy": [1e-8]}, "accuracy must be one number"),
    ],
)
def test_what_cannot_be_flown_is_refused_in_one_sentence(change, message):
    wind = TriangularWind(peak=PEAK, duration=8.0)
    given = {"plant": plant_of(), "law": LAWS["gains"](plant_of()), "wind": wind}
    with pytest.raises(InputError, match=message):
        tv.fly_many(**{**given, "deflection_limit": 0.01} | change)


@pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=NEEDS_NUMBA)])
def test_a_flight_that_leaves_all_numbers_is_lost_without_a_warning(compiled):
    """It grows by e^1000 while the wind blows."""
    wind, limits = TriangularWind(peak=PEAK, duration=2000.0), B * PEAK * np.array([0.02, 1.02])
    with pinned(compiled):
        law = LAWS["trim"](plant_of())
        found = tv.fly_many(plant_of(), law, wind, deflection_limit=limits, sample_rate=4.0)
    assert found.status.tolist() == ["lost", "survived"]
    assert found.peak_attitude[0] == np.inf
    assert found.peak_deflection[0] == limits[0]
