"""Many flights at once: beside `fly`, with pause and without, beside closed forms, case by case."""

from functools import cache

import numpy as np
import pytest
from scipy.linalg import expm

import tvclin as tv
from tests.flying import BETA, GAINS, LAG, MORE, PEAK, SERVO, WIND, B, plant_of
from tests.flying import LAWS as FLOWN
from tests.turns import by_turns, usual
from tvclin import Autopilot, Coefficients, InputError, SampledWind, TriangularWind
from tvclin.kernels.choice import available, pinned

LONG = 12.0
GYRO = tv.control.WindEstimator(bandwidth=6.0, rate_noise=1e-4, seed=3)
LAWS = FLOWN | {
    "dead band": lambda plant: tv.control.DeadBandLaw(plant_of()),
    "noisy": lambda plant: tv.RecoverableAttitudeLaw(plant, dead_band=0.001, estimator=GYRO),
}
HARDWARE = ({}, {"actuator": SERVO, "rate_limit": 0.006}, {"actuator": LAG, "rate_limit": 0.01})
NEEDS_NUMBA = pytest.mark.skipif(not available(), reason="needs numba")
EACH_WAY = pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=NEEDS_NUMBA)])


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


@EACH_WAY
@by_turns(
    "name,model,hardware",
    LAWS,
    ["fixed-path", "drift-exact"],
    [*HARDWARE, {"rate_limit": 0.006}],
    each=3,
)
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


def held(plant, rate):
    """Return what takes states, a held deflection and a wind that stays over a sample."""
    A, inputs, _, _ = plant.matrices()
    return expm(np.block([[A, inputs], [np.zeros((2, len(A) + 2))]]) / rate)[: len(A)]


@EACH_WAY
def test_a_late_short_gust_is_an_impulse_that_is_not_missed(compiled):
    rate, width, size, late, steps = 40.0, 1e-3, 0.5, 30.0037, 1221
    gust = SampledWind(time=[late, late, late + width, late + width], angle=[0, size, size, 0])
    calm = TriangularWind(peak=0.01, duration=5.0)
    plant, law = plant_of(), LAWS["gains"](None)
    with pinned(compiled):
        before, after = (
            tv.fly_many(
                plant, law, wind, deflection_limit=1.0, sample_rate=rate, until=steps / rate
            ).final_attitude
            for wind in (calm, calm + gust)
        )
    A, inputs, _, _ = plant.matrices()
    whole = np.block([[A, inputs], [np.zeros((2, 4))]])
    x = expm(width * whole)[:2] @ [0.0, 0.0, 0.0, size]
    x = expm((30.025 - late - width) * A) @ x
    for _ in range(20):
        x = held(plant, rate) @ [*x, GAINS["attitude_gain"] * x[0] + GAINS["rate_gain"] * x[1], 0.0]
    assert abs(x[0]) > 1e-5
    assert float(after - before) == pytest.approx(x[0], abs=1e-10 * size)


@EACH_WAY
def test_without_limits_a_flight_is_the_linear_sampled_loop(compiled):
    plant, rate = plant_of("drift-exact"), 50.0
    step, x, integral = held(plant, rate), np.zeros(3), 0.0
    for k in range(450):
        gust = PEAK if k < 300 else 0.0
        request = GAINS["attitude_gain"] * x[0] + GAINS["rate_gain"] * x[1]
        request += MORE["alpha_gain"] * (x[0] - x[2] - gust) + MORE["integral_gain"] * integral
        integral += x[0] / rate
        x = step @ [*x, request, gust]
    wind = tv.RectangularWind(peak=PEAK, duration=6.0)
    law = tv.SaturatedLaw(Autopilot(**GAINS, **MORE))
    with pinned(compiled):
        flown = tv.fly_many(plant, law, wind, deflection_limit=1.5, sample_rate=rate, until=9.0)
    assert float(flown.final_attitude) == pytest.approx(x[0], abs=1e-11 * PEAK)
    assert float(flown.saturated_time_fraction) == 0.0


@EACH_WAY
@pytest.mark.parametrize("samples", usual([0.3, 1.0, 2.0, 2.6], 0, 3))
@pytest.mark.parametrize("actuator", [None, SERVO, LAG])
def test_a_command_takes_effect_after_any_delay(samples, actuator, compiled):
    plant, rate = plant_of("drift"), 50.0
    A, inputs, _, _ = plant.matrices()
    n, order = len(A), 0 if actuator is None else actuator.denominator.size - 1
    whole = np.zeros((n + order + 2, n + order + 2))  # states, nozzle, command, wind
    whole[:n, :n], whole[:n, -1] = A, inputs[:, 1]
    whole[:n, n if order else -2] = inputs[:, 0]
    if order:
        F, G, _, _ = actuator.matrices()
        whole[n:-2, n:-2], whole[n:-2, [-2]] = F, G
    late, rest = int(samples + 1e-9), samples - int(samples + 1e-9)
    first, second = (expm(part / rate * whole)[:-2] for part in (rest, 1.0 - rest))
    y, commands = np.zeros(n + order), [0.0] * (late + 1)
    for k in range(400):
        gust = PEAK if k < 300 else 0.0
        commands.append(GAINS["attitude_gain"] * y[0] + GAINS["rate_gain"] * y[1])
        y = first @ [*y, commands[-2 - late], gust]
        y = second @ [*y, commands[-1 - late], gust]
    with pinned(compiled):
        flown = tv.fly_many(
            plant,
            LAWS["gains"](None),
            tv.RectangularWind(peak=PEAK, duration=6.0),
            deflection_limit=1.5,
            actuator=actuator,
            sample_rate=rate,
            delay=samples / rate,
            until=8.0,
        )
    assert float(flown.final_attitude) == pytest.approx(y[0], abs=1e-11 * max(PEAK, abs(y[0])))


def test_a_delay_is_flown_as_in_one_flight():
    options = {"sample_rate": 50.0, "delay": 0.031, "actuator": SERVO, "rate_limit": 0.05}
    options |= {"deflection_limit": 1.2 * B * PEAK}
    flown = tv.fly(plant_of(), LAWS["gains"](None), WIND, [9.0, 12.0], **options)
    many = tv.fly_many(plant_of(), LAWS["gains"](None), WIND, until=12.013, **options)
    assert float(many.final_attitude) != flown.outputs[0, -1]  # it ends on a sample, later
    later = tv.fly(plant_of(), LAWS["gains"](None), WIND, [float(many.end_time)], **options)
    assert float(many.final_attitude) == pytest.approx(later.outputs[0, 0], rel=1e-10)


@pytest.mark.parametrize("name", ["trim", "dead band", "all gains", "estimated", "noisy"])
def test_a_law_that_only_python_can_ask_is_flown_by_the_same_steps(name):
    plant, limits = plant_of("drift-exact"), B * PEAK * np.array([0.4, 0.7, 1.1])
    law = LAWS[name](plant)

    class Mine(tv.control.Law):
        engage, release, rate_noise = law.engage, law.release, law.rate_noise
        states = law.states

        def demand(self, seen, states, limit):
            return law.demand(seen, states, limit)

    options = {"deflection_limit": limits, "sample_rate": 50.0, "actuator": SERVO}
    every = tv.fly_many(plant, law, WIND, **options)
    mine = tv.fly_many(plant, Mine(), WIND, **options)
    assert mine.status.tolist() == every.status.tolist()
    saved = every.status == "survived"
    np.testing.assert_allclose(numbers(mine)[:, saved], numbers(every)[:, saved], rtol=1e-8)


@cache
def by_small_steps(which: int, rate: float, limit: float, until: float) -> tuple[float, float]:
    """The attitude at the end and its peak, by steps of a thousandth of a sample."""
    parts, hardware = 1000, HARDWARE[which]
    servo, most = hardware["actuator"], hardware["rate_limit"]
    w, zeta, h = servo.natural_frequency, servo.damping, 1.0 / rate / parts
    c = plant_of().coefficients
    up, down = float(c.mu_alpha), float(c.mu_delta)
    theta, turning, s, v, worst = 0.0, 0.0, 0.0, 0.0, 0.0

    def clipped(value: float, size: float) -> float:
        return min(max(value, -size), size)

    for k in range(int(until * rate)):
        request = GAINS["attitude_gain"] * theta + GAINS["rate_gain"] * turning
        command = clipped(request, limit)
        for j in range(parts):
            old = clipped(s, limit)
            if zeta is None:
                s += h * clipped(w * (command - s), most)
            else:
                v = clipped(v + h * (w * w * (command - s) - 2.0 * zeta * w * v), most)
                s += h * v
            middle = k / rate + (j + 0.5) * h
            blows = PEAK * max(0.0, 1.0 - abs(2.0 * middle / LONG - 1.0))
            push = -up * blows - down * 0.5 * (old + clipped(s, limit))
            half, half_turning = theta + 0.5 * h * turning, turning + 0.5 * h * (up * theta + push)
            theta, turning = theta + h * half_turning, turning + h * (up * half + push)
        worst = max(worst, abs(theta))
    return theta, worst


@pytest.mark.thorough
@EACH_WAY
@pytest.mark.parametrize("which", usual(range(1, len(HARDWARE)), 1))
def test_limits_of_the_nozzle_are_flown_to_a_hundredth_of_a_percent(which, compiled):
    """Beside small steps, in which the rate and the stop bound it."""
    rate, limit, until = 50.0, 1.25 * B * PEAK, 14.0
    final, worst = by_small_steps(which, rate, limit, until)
    with pinned(compiled):
        flown = tv.fly_many(
            plant_of(),
            LAWS["gains"](None),
            TriangularWind(peak=PEAK, duration=LONG),
            deflection_limit=limit,
            sample_rate=rate,
            until=until,
            **HARDWARE[which],
        )
    assert float(flown.final_attitude) == pytest.approx(final, abs=1e-4 * worst)
    assert float(flown.peak_attitude) == pytest.approx(worst, rel=1e-4)


@pytest.mark.parametrize("name", usual(["trim", "lean"], 0))
@pytest.mark.parametrize("model", usual(["fixed-path", "drift-exact"], 1))
def test_outcomes_are_those_of_flights_without_pause(name, model):
    """Just above the boundary a flight settles, just below it leaves for ever."""
    plant, wind = plant_of(model), TriangularWind(peak=PEAK, duration=8.0)
    law = LAWS[name](plant)
    boundary = tv.closed_loop_boundary(plant, law, wind, sample_rate=400.0)
    limits = boundary.scan * B * PEAK
    sampled = tv.fly_many(plant, law, wind, deflection_limit=limits, sample_rate=400.0)
    np.testing.assert_array_equal(sampled.status == "survived", boundary.survives)
    assert set(sampled.status) == {"survived", "lost"}
    assert np.all(sampled.peak_deflection <= limits)
    edge, late = boundary.limit * B * PEAK, [8.0, 30.0]
    above, below = (
        np.abs(tv.fly(plant, law, wind, late, deflection_limit=part * edge).outputs[0])
        for part in (1.02, 0.98)
    )
    assert above[1] < 0.5 * above[0]
    assert below[1] > 10.0 * below[0]


@pytest.mark.thorough
@EACH_WAY
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
        flown = tv.fly_many(
            plant, gains, wind, deflection_limit=limit, sample_rate=50.0, until=12.0
        )
        for place in np.ndindex(3, 2):
            one = plant_of(
                "drift-exact",
                Coefficients.from_vehicle(
                    tv.load_vehicle("configuration-i").replace(thrust=2.495e6 * factors[0][place])
                ),
            )
            single = tv.fly_many(
                one,
                tv.SaturatedLaw(
                    Autopilot(attitude_gain=3 * B * factors[2][place], rate_gain=3 * B / BETA)
                ),
                TriangularWind(peak=PEAK * factors[1][place], duration=8.0),
                deflection_limit=limit[place],
                sample_rate=50.0,
                until=12.0,
            )
            np.testing.assert_allclose(
                numbers(flown)[(slice(None), *place)], numbers(single), rtol=1e-12
            )
            assert flown.status[place] == single.status


def test_laws_may_be_an_array():
    plant, wind = plant_of(), TriangularWind(peak=PEAK, duration=8.0)
    laws = np.array([LAWS[name](plant) for name in ("gains", "dead band", "lean", "noisy")])
    limit = 0.8 * B * PEAK
    every = tv.fly_many(plant, laws, wind, deflection_limit=limit, sample_rate=50.0)
    for k, law in enumerate(laws):
        single = tv.fly_many(plant, law, wind, deflection_limit=limit, sample_rate=50.0)
        np.testing.assert_array_equal(numbers(every)[:, k], numbers(single))
        assert every.status[k] == single.status


@EACH_WAY
def test_a_bad_case_has_its_status_and_the_others_go_on(compiled):
    plant, law = plant_of(), LAWS["trim"](plant_of())
    wind = TriangularWind(peak=PEAK, duration=8.0) * np.array([1.0, 0.0, 1.0, 1.0, 1.0])
    limits = B * PEAK * np.array([0.9, 0.9, np.nan, -1.0, 0.3])
    with pinned(compiled):
        flown = tv.fly_many(plant, law, wind, deflection_limit=limits, sample_rate=50.0)
        single = tv.fly_many(
            plant, law, wind * np.ones(5), deflection_limit=limits[0], sample_rate=50.0
        )
    expected = ["survived", "no flight", "no flight", "no flight", "lost"]
    assert flown.status.tolist() == expected
    assert np.isnan(numbers(flown)[:, 1:4]).all()
    np.testing.assert_array_equal(numbers(flown)[:, 0], numbers(single)[:, 0])


@pytest.mark.thorough
@EACH_WAY
def test_a_flight_that_grows_again_after_a_calm_is_not_saved(compiled):
    """Too small a gain leaves a slow mode that grows, from next to nothing, to beyond return."""
    law = tv.SaturatedLaw(Autopilot(attitude_gain=0.9 * B, rate_gain=GAINS["rate_gain"]))
    wind = TriangularWind(peak=1e-3 * PEAK, duration=8.0)
    ends = np.array([60.0, 700.0])
    with pinned(compiled):
        early, late = (
            tv.fly_many(
                plant_of(), law, wind, deflection_limit=B * PEAK, sample_rate=25.0, until=end
            )
            for end in ends
        )
    assert early.status == "survived"
    assert late.status == "lost"
    assert abs(late.final_attitude) > PEAK > 10.0 * abs(early.final_attitude)


def test_a_stable_plant_flies_to_a_time_but_has_no_fate():
    stable = plant_of(coefficients=Coefficients(mu_alpha=-0.2, mu_delta=1.0))
    law = tv.SaturatedLaw(Autopilot(attitude_gain=0.1, rate_gain=0.5))
    wind = TriangularWind(peak=PEAK, duration=8.0)
    options = {"deflection_limit": 0.1, "sample_rate": 50.0}
    assert tv.fly_many(stable, law, wind, **options).status == "no flight"
    flown = tv.fly_many(stable, law, wind, until=9.0, **options)
    assert flown.status == "undecided"
    assert 0.0 < abs(flown.final_attitude) < PEAK


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"law": "trim"}, "law must be a Law"),
        ({"law": Autopilot(**GAINS, delay=0.1)}, "gains and filters only"),
        ({"deflection_limit": -1.0}, "deflection_limit must be positive"),
        ({"deflection_limit": 4.0}, "deflection_limit must be a deflection within 90 degrees"),
        ({"until": 5.0}, "until must not lie before the end of the wind"),
        ({"deflection_limit": np.ones(3), "rate_limit": np.ones(2)}, "broadcast"),
        ({"delay": -0.1}, "delay must be zero or positive"),
        ({"delay": 1e4}, "delay must be at most 10000 samples"),
        ({"sample_rate": np.ones(2), "delay": np.ones(3)}, "broadcast"),
        ({"sample_rate": None}, "sample_rate must"),
        ({"actuator": SERVO, "sample_rate": 0.1}, "sample_rate must be at least 0.16"),
        ({"plant": 1}, "plant must be a Plant"),
        ({"wind": 1}, "wind must be a History"),
        ({"until": np.nan}, "until must be finite"),
    ],
)
def test_what_cannot_be_flown_is_refused_in_one_sentence(change, message):
    wind = TriangularWind(peak=PEAK, duration=8.0)
    given = {"plant": plant_of(), "law": LAWS["gains"](plant_of()), "wind": wind}
    with pytest.raises(InputError, match=message):
        tv.fly_many(**{**given, "deflection_limit": 0.01, "sample_rate": 50.0} | change)


@pytest.mark.thorough
@pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=NEEDS_NUMBA)])
def test_a_flight_that_leaves_all_numbers_is_lost_without_a_warning(compiled):
    """It grows by e^1000 while the wind blows."""
    wind, limits = TriangularWind(peak=PEAK, duration=2000.0), B * PEAK * np.array([0.02, 1.02])
    with pinned(compiled):
        law = LAWS["trim"](plant_of())
        flights = tv.fly_many(plant_of(), law, wind, deflection_limit=limits, sample_rate=4.0)
    assert flights.status.tolist() == ["lost", "survived"]
    assert flights.peak_attitude[0] == np.inf
    assert flights.peak_deflection[0] == limits[0]


def test_of_many_limits_one_that_no_nozzle_has_is_no_flight():
    limits = np.array([0.1, np.pi / 2, 4.0])
    law = LAWS["gains"](None)
    flights = tv.fly_many(plant_of(), law, WIND, deflection_limit=limits, sample_rate=50.0)
    assert flights.status.tolist() == ["survived", "no flight", "no flight"]


def test_a_flight_beside_the_linear_theory_goes_on_to_the_end_of_its_wind():
    vehicle, wind = tv.load_vehicle("configuration-i"), TriangularWind(peak=0.02, duration=7.5)
    for engine in ("planar", "sixdof"):
        with pytest.raises(InputError, match=r"timepts must reach the end of the wind, 7\.5 s"):
            tv.flights.compare_flight(
                vehicle,
                tv.flights.ReportControl(),
                wind,
                [0.0, 5.0],
                deflection_limit=0.005,
                engine=engine,
            )
