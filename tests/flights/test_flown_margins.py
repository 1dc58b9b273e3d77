"""Flown margins: linear margins far from the stop, boundaries near it, and brute scans between."""

import pickle
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from scipy.linalg import expm

import tvclin as tv
from tests.turns import usual
from tvclin.flights.closed_loop.batch import Hardware, one_flight
from tvclin.flights.closed_loop.flown_margins import CHANGES, LinearMargins, LostFlightError
from tvclin.flights.closed_loop.sampled_stability import (
    dominant_pole,
    linear_delay_margin,
    linear_gain_margins,
)

PEAK = np.radians(5.0)
SERVO = tv.Actuator(natural_frequency=20.0, damping=0.7)
STEP = 1.0 / 4096.0
"""Of a scan, to which edges are known."""


def plant_of(model="fixed-path"):
    return tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), model)


PLANT = plant_of()
C = PLANT.coefficients
BETA, TRIM = float(C.beta), float(C.B) * PEAK
WIND = tv.TriangularWind(peak=PEAK, duration=4.0 / BETA)
GAINS = tv.design_gains(C, natural_frequency=1.0, damping=0.7)
LAWS = {
    "attitude and rate": tv.SaturatedLaw(GAINS),
    "trim": tv.TrimLaw(PLANT),
    "dead band": tv.control.DeadBandLaw(PLANT, dead_band=0.5),
    "recoverable": tv.RecoverableAttitudeLaw(PLANT, design_peak=PEAK),
}
EACH_LAW = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)


@cache
def boundary(law, rate=100.0, model="fixed-path"):
    plant = plant_of(model)
    return tv.closed_loop_boundary(plant, law, WIND, sample_rate=rate, actuator=SERVO).limit


def margins(law, times, rate=100.0, **options):
    """Flown margins at so many times the law's own boundary."""
    limit = times * boundary(law, rate) * TRIM
    options = {"limit": limit, "actuator": SERVO, "sample_rate": rate} | options
    return tv.flights.flown_margins(PLANT, law, WIND, **options)


def by_scipy(gains, gain, effectiveness, delay, h):
    """The step of plant, servo and commands to come, from exponentials of the whole."""
    n = int(np.floor(delay / h + 1e-9))
    F = np.zeros((5, 5))  # attitude, rate, nozzle and its rate, command
    F[0, 1], F[1, 0], F[1, 2] = 1.0, C.mu_alpha, -effectiveness * C.mu_delta
    F[2, 3], F[3, 2:] = 1.0, [-400.0, -28.0, 400.0]
    rest = max(delay - n * h, 0.0)
    early, late = expm(F * rest)[:4], expm(F * (h - rest))[:4]
    size = 4 + n + 1  # commands c_(k-n-1), ..., c_(k-1)
    step, row = np.zeros((size, size)), np.zeros(size)
    row[:2] = gain * gains.attitude_gain, gain * gains.rate_gain
    step[:4, :4] = late[:, :4] @ early[:, :4]
    step[:4, 4] += late[:, :4] @ early[:, 4]
    step[:4] += np.outer(late[:, 4], row if n == 0 else np.eye(size)[5])
    step[4:-1, 5:], step[-1] = np.eye(n), row
    return step


def radius(*args):
    return np.abs(np.linalg.eigvals(by_scipy(GAINS, *args))).max()


@pytest.mark.parametrize("delay", usual([0.0, 0.0137, 0.05], 1))
def test_margins_near_rest_bring_an_eigenvalue_of_another_step_to_the_circle(delay):
    law, h = LAWS["attitude and rate"], 0.02
    one = one_flight(PLANT, law, WIND, 2.0 * TRIM, Hardware(h, delay, SERVO))
    assert dominant_pole(one).real == pytest.approx(
        np.log(radius(1.0, 1.0, delay, h)) / h, abs=1e-8
    )
    late = linear_delay_margin(one, BETA)
    changed = []
    for place, name in enumerate(("gain", "effectiveness")):
        fall, rise = linear_gain_margins(one, name, BETA)
        for factor, inside in ((1.0 / fall, 1.001), (rise, 0.999)):
            for part in (1.0, inside, 1.0 / inside):
                change = [1.0, 1.0, delay, h]
                change[place] = part * factor
                changed.append(radius(*change))
    for part in (1.0, 0.999, 1.001):
        changed.append(radius(1.0, 1.0, delay + part * late, h))
    on, inside, outside = np.array(changed).reshape(-1, 3).T
    # An eigenvalue moves by its condition, here below 1e3, times the rounding of expm.
    np.testing.assert_allclose(on, 1.0, atol=1e-10)
    assert np.all(inside < 1.0)
    assert np.all(outside > 1.0)


def test_the_effectiveness_of_a_law_that_sees_the_nozzle_is_not_its_gain():
    """The observer takes the deflection from the nozzle: only the effect of it is misjudged."""
    estimator = tv.control.WindEstimator(bandwidth=5.0)
    law = tv.RecoverableAttitudeLaw(PLANT, design_peak=PEAK, estimator=estimator)
    one = one_flight(PLANT, law, WIND, TRIM, Hardware(0.01, 0.03, SERVO))
    gain, effect = (linear_gain_margins(one, name, BETA) for name in ("gain", "effectiveness"))
    assert abs(gain[1] / effect[1] - 1.0) > 0.05
    for edge in (1.0 / gain[0], gain[1]):
        assert abs(dominant_pole(replace(one, gain=np.asarray(edge))).real) < 1e-8
    for edge in (1.0 / effect[0], effect[1]):
        changed = replace(one, plant=PLANT.with_effectiveness(edge))
        assert abs(dominant_pole(changed).real) < 1e-8
    late = 0.03 + linear_delay_margin(one, BETA)
    assert abs(dominant_pole(one.delayed(late)).real) < 1e-8


@pytest.mark.parametrize("late", usual([0.0, 0.0263], 1))
def test_far_from_the_stop_they_are_the_linear_margins_of_the_sampled_loop(late):
    """A hold is half a sample late; its error is of the order (omega h)^2, 2e-4 at crossover."""
    result = tv.flights.flown_margins(
        PLANT, LAWS["attitude and rate"], WIND, limit=150.0 * TRIM, actuator=SERVO, delay=late
    )
    linear = replace(GAINS, actuator=SERVO, delay=late + 0.005).margins(PLANT)
    assert result.gain_fall.value == pytest.approx(linear.aero_margin, rel=1e-3)
    assert result.gain_rise.value == pytest.approx(linear.gain_increase, rel=5e-3)
    assert result.delay.value == pytest.approx(linear.delay_margin, abs=1e-5)
    for name in CHANGES:
        one = getattr(result, name)
        assert one.value == pytest.approx(one.linear, rel=1e-3)
        assert one.cause in ("rings", "undecided")
    assert result.linear == LinearMargins(
        result.gain_fall.linear, result.gain_rise.linear, result.delay.linear
    )


@pytest.mark.thorough
def test_the_course_booster_has_426_ms_in_continuous_time_and_half_a_sample_less_here():
    plant = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=0.228, mu_delta=1.317))
    gains = tv.Autopilot(attitude_gain=1.88, rate_gain=1.59)
    nozzle = tv.Actuator(natural_frequency=8.0 * np.pi, damping=0.7)
    wind = tv.TriangularWind(peak=PEAK, duration=4.0 / float(plant.coefficients.beta))
    limit = 1.2 * 0.7922 * float(plant.coefficients.B) * PEAK
    result = tv.flights.flown_margins(
        plant, tv.SaturatedLaw(gains), wind, limit=limit, actuator=nozzle
    )
    assert result.spare == pytest.approx(1.2, abs=2e-4)
    assert result.delay.linear == pytest.approx(0.4206, abs=5e-5)
    assert replace(gains, actuator=nozzle).margins(plant).delay_margin == pytest.approx(
        result.delay.linear + 0.005, abs=1e-5
    )
    assert result.delay.cause == "rings"
    assert result.delay.loss == pytest.approx(0.470, abs=1e-3)
    assert result.gain_fall.value == pytest.approx(2.175, abs=1e-3)
    assert result.gain_fall.linear == pytest.approx(10.859, abs=5e-4)
    assert result.effectiveness_fall.value == pytest.approx(1.170, abs=1e-3)


@pytest.mark.thorough
@pytest.mark.parametrize("law", usual(LAWS.values(), 3), ids=LAWS)
def test_at_the_boundary_no_effectiveness_may_be_lost(law):
    """F y_b(1/f) = L, and y_b does not fall with falling gain: f is at most the spare."""
    result = margins(law, 1.003, rate=50.0)
    assert 1.0 < result.effectiveness_fall.value <= result.spare * (1.0 + STEP)
    assert result.effectiveness_fall.cause == "lost"
    assert result.gain_fall.value < 1.12


# Of another program, in whose steps the deflection always goes evenly: gain and effectiveness that
# may fall until a flight is lost, and the delay that it bears; 100 Hz. The gain of (trim, 5)
# falls up to the stability limit of NEAR_REST: that program waits for 60 time constants only, and
# beyond 10.88 the flight settles more slowly, within its limits.
TABLE = {
    ("attitude and rate", 1.01): (1.032, 1.008, 0.064),
    ("attitude and rate", 1.2): (1.601, 1.147, 0.617),
    ("attitude and rate", 2.0): (3.350, 1.645, 0.704),
    ("trim", 1.05): (1.479, 1.045, np.inf),
    ("trim", 5.0): (11.0, 3.771, np.inf),
    ("dead band", 1.2): (1.380, 1.129, 0.319),
    ("recoverable", 1.05): (2.068, 1.048, 0.092),
    ("recoverable", 5.0): (10.79, 2.528, np.inf),
}
NEAR_REST = {
    "attitude and rate": (4.570, 16.58, 0.6175),
    "trim": (11.0, 4.4895, 0.2008),
    "dead band": (2.0, 43.41, 0.7834),
    "recoverable": (11.0, 4.0964, 0.1788),
}


@pytest.mark.parametrize(("case", "expected"), usual(TABLE.items(), 1), ids=str)
def test_margins_are_those_of_the_table(case, expected):
    name, times = case
    result = margins(LAWS[name], times)
    lost = (result.gain_fall.loss, result.effectiveness_fall.loss, result.delay.loss)
    np.testing.assert_allclose(lost, expected, rtol=1e-3, atol=6e-4)
    np.testing.assert_allclose(result.linear, NEAR_REST[name], rtol=1e-3)
    for change in CHANGES:
        one = getattr(result, change)
        assert one.value == min(one.loss, one.linear)
        assert (one.cause == "rings") == (one.linear <= one.loss)
    assert result.gain_rise.cause == result.effectiveness_rise.cause == "rings"


def flown(change, value, law, limit, rate):
    options = {"deflection_limit": limit, "actuator": SERVO, "sample_rate": rate}
    if change == "gain":
        gains = replace(law.autopilot, attitude_gain=value * law.autopilot.attitude_gain)
        law = tv.SaturatedLaw(replace(gains, rate_gain=value * gains.rate_gain))
        return tv.fly_many(PLANT, law, WIND, **options)
    if change == "effectiveness":
        plant = tv.Plant(C.replace(mu_delta=value * C.mu_delta), "fixed-path")
        return tv.fly_many(plant, law, WIND, **options)
    return tv.fly_many(PLANT, law, WIND, delay=value, **options)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "change"),
    usual([("gain_fall", "gain"), ("effectiveness_fall", "effectiveness"), ("delay", "delay")], 0),
)
def test_brute_flights_of_changed_gains_plants_and_delays_find_the_same(name, change):
    law, rate, times = LAWS["attitude and rate"], 50.0, 1.08
    limit = times * boundary(law, rate) * TRIM
    result = getattr(margins(law, times, rate), name)
    assert result.cause == "lost"
    assert not result.survives_beyond
    parts = np.concatenate([np.linspace(0.02, 0.98, 25), [0.999, 1.0, 1.002, 1.1, 1.2]])
    for part in parts:
        value = part * result.value if change == "delay" else result.value**-part
        status = str(flown(change, value, law, limit, rate).status)
        assert status == ("survived" if part <= 1.0 else "lost")
    np.testing.assert_array_equal(result.survives, result.scan <= result.value * (1.0 + 1e-12))
    assert result.scan[0] == (0.0 if change == "delay" else 1.0)


@pytest.mark.parametrize("kind", ["numbers", "python"])
@pytest.mark.parametrize("factor", [0.5, 4.0])
def test_a_gain_is_ahead_of_switch_and_limit(kind, factor):
    """Powers of two leave digits as they are: flights of scaled gains are the same to the last."""
    gains = replace(GAINS, alpha_gain=0.1)
    times = {name: factor * getattr(gains, name) for name in ("attitude_gain", "rate_gain")}
    scaled = replace(gains, alpha_gain=factor * gains.alpha_gain, **times)
    make = Written if kind == "python" else Switched
    options = {"deflection_limit": TRIM, "sample_rate": 20.0, "until": 12.0, "actuator": None}
    one = tv.fly_many(PLANT, make(scaled), WIND, **options)
    other = tv.fly_many(PLANT, make(gains), WIND, gain=[1.0, factor], **options)
    for name in ("peak_attitude", "peak_deflection", "final_attitude", "saturated_time_fraction"):
        assert getattr(other, name)[1] == getattr(one, name)
    assert other.peak_attitude[0] != one.peak_attitude


@dataclass(frozen=True)
class Switched(tv.SaturatedLaw):
    """With a dead band: the whole limit from 0.6 of it on."""

    engage = 0.6
    release = 0.5

    @property
    def numbers(self):
        return super().numbers._replace(engage=self.engage, release=self.release)


@dataclass(frozen=True)
class Written(Switched):
    """A law that only Python can evaluate."""

    numbers = None

    def demand(self, measured, states, limit):
        return Switched(self.autopilot).demand(measured, states, limit)


@EACH_LAW
def test_effectiveness_with_a_stop_is_gain_with_a_stop_so_many_times_as_far(law):
    """Equal for laws that do not know their limit; one that leans believes in the whole stop."""
    e, rate = 0.83, 0.02
    plant = tv.Plant(C.replace(mu_delta=e * C.mu_delta), "fixed-path")
    options = {"actuator": SERVO, "sample_rate": 50.0, "until": 14.0}
    limits = np.array([0.7, 1.1]) * TRIM
    real = tv.fly_many(plant, law, WIND, deflection_limit=limits, rate_limit=rate, **options)
    moments = tv.fly_many(
        PLANT, law, WIND, deflection_limit=e * limits, rate_limit=e * rate, gain=e, **options
    )
    knows = isinstance(law, tv.RecoverableAttitudeLaw)
    # Rounding grows with the unstable mode, e^(beta 14 s) = 1.6e3, over the flight.
    same = np.isclose(real.peak_attitude, moments.peak_attitude, rtol=1e-11)
    assert np.all(same) != knows
    if not knows:
        np.testing.assert_allclose(e * real.peak_deflection, moments.peak_deflection, rtol=1e-11)
        np.testing.assert_array_equal(real.status, moments.status)


@pytest.mark.thorough
def test_margins_can_be_read_from_the_map():
    law, times = LAWS["attitude and rate"], 1.08
    result = margins(law, times, rate=50.0)
    at = {"fall": 1.0 / result.gain_fall.value, "effect": 1.0 / result.effectiveness_fall.value}
    gains = sorted([*at.values(), 1.0])
    chart = tv.flights.boundary_map(
        PLANT, law, WIND, gains, [0.0, result.delay.value], sample_rate=50.0, actuator=SERVO
    )
    known = 2.0 * 1.98 / 60.0 * STEP  # of both: by gain and delay the boundary moves slowly
    assert chart.full_trim == pytest.approx(TRIM)
    assert chart.limit[gains.index(at["fall"]), 0] == pytest.approx(result.limit, abs=known)
    effect = chart.limit[gains.index(at["effect"]), 0]
    assert effect / at["effect"] == pytest.approx(result.limit, abs=known)
    assert chart.limit[2, 1] == pytest.approx(result.limit, abs=known)
    assert chart.limit[2, 0] == result.boundary
    assert np.all(chart.growth < 0.0)


@pytest.mark.thorough
def test_filters_of_a_law_are_in_its_margins():
    """Far from the stop those of the filtered loop; a bilinear filter is exact at its frequency."""
    shelf = tv.vehicle.Filter.low_pass(6.0, 0.7)
    law = tv.control.FilteredLaw(LAWS["attitude and rate"], filters=(shelf,))
    result = tv.flights.flown_margins(PLANT, law, WIND, limit=150.0 * TRIM, actuator=SERVO)
    linear = replace(GAINS, filters=(shelf,), actuator=SERVO, delay=0.005).margins(PLANT)
    assert result.gain_fall.value == pytest.approx(linear.aero_margin, rel=2e-3)
    assert result.gain_rise.value == pytest.approx(linear.gain_increase, rel=5e-3)
    assert result.delay.value == pytest.approx(linear.delay_margin, abs=1e-4)


@pytest.mark.thorough
def test_sudden_stops_and_a_slow_nozzle_leave_no_more():
    law = tv.RecoverableAttitudeLaw(PLANT, reach=1.0, gain=6.0)
    wind = tv.SampledWind(time=[0.0, 3.0, 6.0, 9.0], angle=PEAK * np.array([0.0, 1.0, 1.0, 0.1]))
    options = {"limit": 0.8 * TRIM, "sample_rate": 20.0}
    whole, stopped = (tv.flights.flown_margins(PLANT, law, wind, cuts=n, **options) for n in (0, 3))
    assert stopped.spare < whole.spare
    assert stopped.effectiveness_fall.value < whole.effectiveness_fall.value
    gains = LAWS["attitude and rate"]
    free, slow = (
        margins(gains, 1.5, rate=50.0, rate_limit=rate) for rate in (np.inf, np.radians(0.3))
    )
    assert slow.linear == pytest.approx(free.linear, rel=1e-9)
    assert slow.delay.loss < 0.7 * free.delay.loss
    assert slow.effectiveness_fall.loss < 0.9 * free.effectiveness_fall.loss
    assert slow.gain_rise.loss < free.gain_rise.loss == np.inf  # a ringing nozzle is dear


@pytest.mark.thorough
def test_a_switch_may_lose_earlier_than_the_loop_grows_and_survive_again():
    result = margins(LAWS["dead band"], 1.5)
    assert result.delay.value == pytest.approx(0.583, abs=1e-3)
    assert result.delay.linear == pytest.approx(0.7834, abs=1e-4)
    assert result.delay.survives_beyond
    assert result.delay.cause == "undecided"
    assert result.notes == (
        "delay 0.5831: beyond it flights stay undecided",
        "delay 0.5831: some larger changes survive again",
    )


def test_what_cannot_have_margins_is_refused():
    trim, limit = LAWS["trim"], 0.9 * TRIM
    usual = {"plant": PLANT, "law": trim, "wind": WIND, "limit": limit, "sample_rate": 50.0}
    noisy = tv.RecoverableAttitudeLaw(
        PLANT, estimator=tv.control.WindEstimator(bandwidth=10.0, rate_noise=1e-4)
    )
    drifting = plant_of("drift-exact")
    stable = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=-0.2, mu_delta=1.0))
    batch = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=[0.2, 0.3], mu_delta=1.0))
    words = {
        f"needs {np.degrees(0.6887 * TRIM):.3f}.* got {np.degrees(0.6 * TRIM):.4g} deg": {
            "limit": 0.6 * TRIM
        },
        "a mode of this loop grows with": {"plant": drifting, "law": tv.TrimLaw(drifting)},
        "law must be without rate_noise": {"law": noisy},
        "sample_rate": {"sample_rate": None},
        "one or two real unstable poles": {"plant": stable},
        "got batches of shape": {"plant": batch},
        "wind must end": {"wind": tv.linear.ConstantDeflection(limit=0.05)},
        "delay must be zero or positive": {"delay": -0.1},
        "limit must be positive": {"limit": 0.0},
        f"needs more than {np.degrees(2.0 * TRIM):.4g} deg; got": {"rate_limit": np.radians(0.01)},
    }
    for said, changed in words.items():
        with pytest.raises(tv.InputError, match=said):
            tv.flights.flown_margins(**usual | changed)
    with pytest.raises(tv.InputError, match="gains must rise"):
        tv.flights.boundary_map(PLANT, trim, WIND, [1.0, 0.5], [0.0])
    with pytest.raises(tv.InputError, match="at most 2000 boundaries"):
        tv.flights.boundary_map(
            PLANT, trim, WIND, np.linspace(0.5, 2.0, 50), np.linspace(0.0, 1.0, 50)
        )


@pytest.mark.thorough
def test_figures_show_the_margins_and_the_map():
    import matplotlib.pyplot as plt

    law = LAWS["attitude and rate"]
    computed = [margins(law, times, rate=50.0) for times in (3.0, 1.1)]
    drawn = tv.plots.flown_margins_chart(computed).curves
    np.testing.assert_array_equal(drawn.abscissa, [computed[1].spare, computed[0].spare])
    shown = {column.label: column.values for column in drawn.columns}
    np.testing.assert_allclose(
        shown["gain fall"], [computed[1].gain_fall.dB, computed[0].gain_fall.dB]
    )
    assert shown["delay: grows near rest"][0] == computed[1].linear.delay
    chart = tv.flights.boundary_map(PLANT, law, WIND, [0.7, 1.0, 1.4], [0.0, 0.7], sample_rate=20.0)
    plot = tv.plots.boundary_map_chart(chart, limit=TRIM)
    assert chart.growth[-1, -1] > 0.0 > chart.growth[-1, 0]
    np.testing.assert_array_equal(plot.curves.columns[0].values, chart.limit[:, 0])
    texts = [text.get_text() for text in plot.figure.legends[0].get_texts()]
    assert texts == ["boundary, of full trim", "limit, 1 of full trim", "grows near rest"]
    assert "limit over boundary" in computed[0]._repr_html_()
    assert "limit over trim" in chart._repr_html_()
    with pytest.raises(tv.InputError, match="two or more gains"):
        tv.plots.boundary_map_chart(replace(chart, limit=chart.limit[:1]))
    plt.close("all")


def test_an_integral_leaves_no_edge_where_the_loop_stands_still():
    """At z = 1 the loop is infinite, and its real part there is rounding; gain and nozzle agree."""
    gains = tv.Autopilot(
        attitude_gain=1.5565827369878802, rate_gain=1.8483319840166301, integral_gain=0.02
    )
    plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "fixed-path")
    wind = tv.TriangularWind(peak=0.05, duration=6.0)
    hardware = Hardware(0.01, 0.0, tv.Actuator())
    one = one_flight(plant, tv.SaturatedLaw(gains), wind, 0.05, hardware)
    pace = float(plant.poles[0])
    gain, effectiveness = (
        linear_gain_margins(one, name, pace) for name in ("gain", "effectiveness")
    )
    # Both are roots of the same loop; the integrator takes four digits of sixteen.
    np.testing.assert_allclose(effectiveness, gain, rtol=1e-9)


@pytest.mark.thorough
def test_a_trim_law_that_lets_the_path_creep_is_refused_with_its_remedy():
    plant = plant_of("drift-exact")
    nozzle = {"limit": 2.0 * TRIM, "sample_rate": 50.0}
    with pytest.raises(tv.InputError, match="design it on the fixed path"):
        tv.flights.flown_margins(plant, tv.TrimLaw(plant), WIND, **nozzle)
    assert tv.flights.flown_margins(
        plant, tv.TrimLaw(plant_of("fixed-path")), WIND, **nozzle
    ).gain_fall


def test_the_error_of_a_lost_flight_is_the_same_in_another_process():
    error = LostFlightError(0.01, "more than 1.5 deg")
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.sentence) == (str(error), error.sentence)
    assert "this needs more than 1.5 deg; got 0.573 deg" in str(again)
