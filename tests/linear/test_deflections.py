"""Deflections: held, bang-bang, trim, and trim then hold against the report's equation (17)."""

import mpmath as mp
import numpy as np
import pytest

import tvclin as tv

EPS = np.finfo(float).eps
MODELS = ["fixed-path", "drift", "drift-exact", "drift-and-speed"]
PEAK, DURATION = -0.1, 7.5
WIND = tv.TriangularWind(peak=PEAK, duration=DURATION)
ONE = {"beta": 0.52928, "B": 0.107229, "C1": 0.0250613, "C2": 0.0035948, "b1": 0.0283514,
     "b2": 0.0168588, "q": 1.6660e-4}  # fmt: skip
TWO = {"beta": 0.39570, "B": 0.0965056, "C1": 0.0338274, "C2": 0.0015226, "b1": 0.0375151,
      "b2": 0.0273860, "q": 1.6035e-4}  # fmt: skip
TIMES = np.array([-1.0, 0.0, 0.4, 1.0, 2.0, 3.0, 3.75, 5.0, 7.5, 20.0])


def plant(model="drift", **changes):
    return tv.Plant.from_coefficients(tv.Coefficients.from_beta(**(ONE | changes)), model)


def full_limit(numbers=ONE, peak=PEAK):
    """Return the limit that is the trim deflection at the peak of the wind: y = 1."""
    return -numbers["B"] * peak


def switch_time(control):
    return control.knots[..., -1]


@pytest.mark.parametrize("start", [0.0, 2.5, -4.0])
def test_a_held_deflection_is_constant_from_its_start_on(start):
    held = tv.linear.ConstantDeflection(limit=-0.03, start=start)
    times = [start - 1.0, np.nextafter(start, -np.inf), start, start + 1e6]
    np.testing.assert_array_equal(held(times), [0.0, 0.0, -0.03, -0.03])
    assert (held.onset, held.end, held.final_value, held.peak) == (start, np.inf, -0.03, -0.03)


@pytest.mark.parametrize("s", [0.53, 1e-6, 2.0 - 3j])
@pytest.mark.parametrize("start", [0.0, 2.5, -4.0])
def test_the_transform_of_a_held_deflection_is_the_closed_form(start, s):
    expected = -0.03 * np.exp(-s * start) / s
    held = tv.linear.ConstantDeflection(limit=-0.03, start=start)
    # A rounding of each operation, and e^x has that of its argument.
    rounding = (4.0 + abs(s * start)) * np.finfo(float).eps
    np.testing.assert_allclose(held.laplace(s), expected, rtol=rounding)


def test_a_bang_bang_deflection_changes_sign_at_each_switch():
    control = tv.linear.BangBang(limit=0.02, switch_times=[1.0, 3.0, 3.0, 4.5], start=-2.0)
    expected = [0.0, 0.02, 0.02, -0.02, -0.02, 0.02]
    np.testing.assert_array_equal(control([-2.1, -2.0, 0.99, 1.0, 4.4, 4.5]), expected)
    opposite = tv.linear.BangBang(limit=-0.02, switch_times=[1.0, 3.0, 3.0, 4.5], start=-2.0)
    np.testing.assert_array_equal(opposite(TIMES), -control(TIMES))


@pytest.mark.parametrize("s", [0.53, 0.05, 1.0 - 3j])
def test_the_transform_of_a_bang_bang_deflection_adds_twice_each_switch(s):
    start, times = -2.0, np.array([1.0, 3.0, 4.5])
    terms = np.exp(-s * start) + 2 * np.sum(np.array([-1, 1, -1]) * np.exp(-s * times))
    control = tv.linear.BangBang(limit=0.02, switch_times=times, start=start)
    rounding = 4 * EPS * control.laplace_magnitude(s)
    assert abs(control.laplace(s) - 0.02 * terms / s) <= rounding


def test_a_bang_bang_deflection_that_never_switches_is_held():
    held = tv.linear.ConstantDeflection(limit=0.02, start=1.0)
    control = tv.linear.BangBang(limit=0.02, switch_times=[], start=1.0)
    np.testing.assert_array_equal(control(TIMES), held(TIMES))
    assert control.laplace(0.5) == held.laplace(0.5)


def test_batches_of_held_and_bang_bang_deflections_are_the_loop():
    limits, starts, switches = [0.1, -0.2], [[0.0], [-1.0], [2.0]], [[2.0, 3.0], [4.0, 4.5]]
    held = tv.linear.ConstantDeflection(limit=limits, start=starts)
    control = tv.linear.BangBang(limit=limits, switch_times=switches, start=starts)
    assert held.batch == control.batch == (3, 2)
    for i in range(3):
        for j in range(2):
            one = {"limit": limits[j], "start": starts[i][0]}
            single = tv.linear.BangBang(switch_times=switches[j], **one)
            np.testing.assert_array_equal(
                held(TIMES)[i, j], tv.linear.ConstantDeflection(**one)(TIMES)
            )
            np.testing.assert_array_equal(control(TIMES)[i, j], single(TIMES))


@pytest.mark.parametrize(
    ("kind", "bad", "message"),
    [
        (
            tv.linear.ConstantDeflection,
            {"limit": 0.0},
            r"^limit must be other than zero; got 0 rad$",
        ),
        (tv.linear.ConstantDeflection, {"start": np.nan}, r"^start must be finite; got nan s$"),
        (
            tv.linear.ConstantDeflection,
            {"limit": [1.0, 2.0], "start": [0.0] * 3},
            r"limit .* start",
        ),
        (tv.linear.BangBang, {"limit": 0.0}, r"^limit must be other than zero; got 0 rad$"),
        (tv.linear.BangBang, {"switch_times": [2.0, 1.0]}, r"^switch_times must not decrease"),
        (tv.linear.BangBang, {"start": 1.5}, r"^switch_times .* before start \(1\.5 s\)"),
        (tv.linear.BangBang, {"switch_times": [np.inf]}, r"^switch_times must be finite"),
    ],
)
def test_bad_deflections_are_refused_in_one_sentence(kind, bad, message):
    good = {"limit": 0.1, "switch_times": [1.0, 2.0]}
    good = good if kind is tv.linear.BangBang else {"limit": 0.1}
    with pytest.raises(tv.InputError, match=message) as caught:
        kind(**good | bad)
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize("numbers", [ONE, TWO, ONE | {"b1": 1e-9, "b2": 0.0}, ONE | {"B": -0.2}])
@pytest.mark.parametrize("model", MODELS)
def test_trim_keeps_the_attitude_nominal(model, numbers):
    p, rng = plant(model, **numbers), np.random.default_rng(3)
    winds = [WIND, tv.RectangularWind(peak=0.2, duration=3.0).shift(-1.0)]
    winds.append(tv.SampledWind(time=[0, 1, 1, 5, 40], angle=[0, 0.1, -0.1, 0.05, 0.0]))
    for wind in winds:
        trim = tv.trim_deflection(p, wind)
        for s in rng.uniform(0.1, 2.0, 4) + 1j * rng.uniform(-3.0, 3.0, 4):
            from_wind = np.polyval(p.numerator("attitude", "wind"), s) * wind.laplace(s)
            by_trim = np.polyval(p.numerator("attitude", "deflection"), s) * trim.laplace(s)
            assert abs(by_trim + from_wind) <= 1e-12 * abs(from_wind)


def test_trim_without_drift_is_minus_b_times_the_wind():
    trim = tv.trim_deflection(plant("fixed-path"), WIND)
    np.testing.assert_allclose(trim(TIMES), -ONE["B"] * WIND(TIMES), rtol=4e-16)


@pytest.mark.parametrize("model", MODELS)
def test_trim_is_continuous_where_the_wind_is_and_jumps_by_minus_b_where_it_jumps(model):
    knots = np.array([0.0, DURATION / 2, DURATION])
    trim = tv.trim_deflection(plant(model), WIND)
    before = trim(np.nextafter(knots, -np.inf))
    np.testing.assert_allclose(before, trim(knots), rtol=1e-14, atol=1e-17)
    wind = tv.RectangularWind(peak=PEAK, duration=DURATION)
    trim, jump = tv.trim_deflection(plant(model), wind), -ONE["B"] * PEAK
    ends = np.array([0.0, DURATION])
    np.testing.assert_allclose(
        trim(ends) - trim(np.nextafter(ends, -np.inf)), [jump, -jump], rtol=1e-14
    )


def drifting_ramp(t, numbers):
    """Return the trim deflection for a wind of slope 1, over -B: eq before (17), in time."""
    b1, b2 = mp.mpf(numbers["b1"]), mp.mpf(numbers["b2"])
    return b2 / b1 * t - (b1 - b2) / b1**2 * mp.expm1(-b1 * t)


def equation_17(s, y, K, duration, numbers):
    """Return the transform (17) over B times the peak of the wind."""
    b1, b2, tau = mp.mpf(numbers["b1"]), mp.mpf(numbers["b2"]), mp.mpf(duration)
    a = y * tau / 2 * K
    drift = mp.exp(-b1 * a) / (s + b1) + b1 / s**2 + b1 * a / s - 1 / s
    held = 1 / s**2 - tau / 2 * y * (1 - K) / s + (b2 - b1) / b1**2 * drift
    braces = (s + b2) / (s**2 * (s + b1)) - held * mp.exp(-a * s)
    return -2 / tau * braces


@pytest.mark.parametrize("K", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("tau_beta", [0.5, 4.0, 20.0])
@pytest.mark.parametrize("numbers", [ONE, TWO])
def test_the_transform_of_trim_then_hold_is_equation_17(numbers, tau_beta, K):
    duration, y = tau_beta / numbers["beta"], 0.66
    wind = tv.TriangularWind(peak=PEAK, duration=duration)
    limit = y * full_limit(numbers)
    control = tv.trim_then_hold(plant(**numbers), wind, limit, K)
    for s in (numbers["beta"], 0.05, 3.0, 0.4 + 2j):
        with mp.workdps(40):
            exact = equation_17(mp.mpmathify(s), mp.mpf(y), mp.mpf(K), duration, numbers)
        expected = complex(exact) * numbers["B"] * PEAK
        # The switch time is rounded by s a epsilon, the rest by a few.
        np.testing.assert_allclose(control.laplace(s), expected, rtol=1e-13)


@pytest.mark.parametrize("K", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("model", MODELS)
def test_the_reports_switch_time_is_equation_10_on_every_model(model, K):
    limit = 0.66 * full_limit()
    expected = -limit / (ONE["B"] * PEAK) * DURATION / 2 * K
    control = tv.trim_then_hold(plant(model), WIND, limit, K)
    assert switch_time(control) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize("K", [0.25, 0.5, 1.0])
def test_the_literal_switch_is_where_the_trim_deflection_is_k_times_the_limit(K):
    y = 0.66
    level = y * K * DURATION / 2
    expected = float(mp.findroot(lambda t: drifting_ramp(t, ONE) - level, level))
    control = tv.trim_then_hold(plant(), WIND, y * full_limit(), K, switch="literal")
    assert switch_time(control) == pytest.approx(expected, rel=1e-14)
    assert expected > level
    left = control([np.nextafter(expected * (1 - 1e-13), 0.0)])[0]
    assert left == pytest.approx(K * y * full_limit(), rel=1e-12)


def test_without_drift_both_switches_are_one():
    for K in (0.0, 0.5, 1.0):
        made = [
            tv.trim_then_hold(plant("fixed-path"), WIND, 0.007, K, switch=switch)
            for switch in ("report", "literal")
        ]
        np.testing.assert_array_equal(made[0](TIMES), made[1](TIMES))


@pytest.mark.parametrize("model", MODELS)
def test_trim_then_hold_is_trim_before_the_switch_and_the_limit_after(model):
    limit = 0.66 * full_limit()
    control = tv.trim_then_hold(plant(model), WIND, limit, 0.5)
    a = 0.66 * DURATION / 4
    trim = tv.trim_deflection(plant(model), WIND)(TIMES)
    expected = np.where(TIMES < a, trim, limit)
    np.testing.assert_allclose(control(TIMES), expected, rtol=1e-14)
    assert control([1e5])[0] == pytest.approx(limit, rel=1e-15)
    assert control.final_value == pytest.approx(limit, rel=1e-15)


@pytest.mark.parametrize("model", MODELS)
def test_a_wind_the_other_way_needs_the_limit_the_other_way(model):
    control = tv.trim_then_hold(plant(model), WIND, 0.007, 0.5)
    mirrored = tv.trim_then_hold(plant(model), -WIND, -0.007, 0.5)
    np.testing.assert_array_equal(mirrored(TIMES), -control(TIMES))
    forward = tv.trim_then_hold(plant(model, B=-ONE["B"]), WIND, -0.007, 0.5)
    np.testing.assert_allclose(forward(TIMES), -control(TIMES), rtol=1e-14)


@pytest.mark.parametrize("switch", ["report", "literal"])
@pytest.mark.parametrize("onset", [0.0, 2.0, -3.0])
def test_a_dead_band_of_zero_holds_from_the_onset_of_the_wind(onset, switch):
    control = tv.trim_then_hold(plant(), WIND.shift(onset), 0.007, 0.0, switch=switch)
    held = tv.linear.ConstantDeflection(limit=0.007, start=onset)
    np.testing.assert_array_equal(control(TIMES), held(TIMES))


def test_a_dead_band_of_zero_waits_through_a_calm():
    wind = tv.SampledWind(time=[0.0, 2.0, 4.0, 5.0], angle=[0.0, 0.0, -0.1, 0.0])
    assert switch_time(tv.trim_then_hold(plant(), wind, 0.007, 0.0)) == 2.0


def test_a_wind_that_jumps_out_of_the_dead_band_switches_at_the_jump():
    wind = tv.SampledWind(time=[0.0, 2.0, 2.0, 5.0], angle=[0.0, -0.02, -0.09, 0.0])
    control = tv.trim_then_hold(plant(), wind, 0.007, 1.0)
    assert switch_time(control) == 2.0


@pytest.mark.parametrize("switch", ["report", "literal"])
@pytest.mark.parametrize("model", MODELS)
def test_a_limit_that_trim_never_reaches_leaves_trim_throughout(model, switch):
    control = tv.trim_then_hold(plant(model), WIND, 1.01 * full_limit(), 1.0, switch=switch)
    trim = tv.trim_deflection(plant(model), WIND)
    np.testing.assert_allclose(control(TIMES), trim(TIMES), rtol=1e-14)
    np.testing.assert_allclose(control.laplace(0.5), trim.laplace(0.5), rtol=1e-13)


def test_a_late_wind_is_met_by_the_same_control_later():
    control = tv.trim_then_hold(plant(), WIND, 0.007, 0.5)
    later = tv.trim_then_hold(plant(), WIND.shift(64.0), 0.007, 0.5)
    np.testing.assert_allclose(later(TIMES + 64.0), control(TIMES), rtol=1e-13)


def test_trim_then_hold_refuses_what_it_cannot_use():
    for limit, wind in ((-0.007, WIND), (0.007, -WIND), ([0.007, -0.007], WIND)):
        with pytest.raises(tv.InputError, match=r"^limit must oppose the wind, with the sign of"):
            tv.trim_then_hold(plant(), wind, limit)
    with pytest.raises(tv.InputError, match=r"^limit must be other than zero; got 0 rad$"):
        tv.trim_then_hold(plant(), WIND, 0.0)
    for K in (-0.01, 1.01):
        with pytest.raises(tv.InputError, match=r"^dead_band must be between 0 and 1; got"):
            tv.trim_then_hold(plant(), WIND, 0.007, K)
    with pytest.raises(tv.InputError, match=r"^switch must be one of report, literal; .*'literal'"):
        tv.trim_then_hold(plant(), WIND, 0.007, switch="literaly")


@pytest.mark.parametrize("late", [0.0, [3.0, -1.0]])
@pytest.mark.parametrize("switch", ["report", "literal"])
@pytest.mark.parametrize("model", MODELS)
def test_a_batch_of_plants_limits_and_dead_bands_is_the_loop(model, switch, late):
    changes = {"beta": [0.53, 0.4], "B": [0.107, 0.13], "b1": [0.03, 0.05]}
    limits, bands = np.array([[0.007], [0.03], [0.001]]), np.array([[[1.0]], [[0.0]], [[0.4]]])
    wind = WIND.shift(late) if late else WIND
    batch = tv.trim_then_hold(plant(model, **changes), wind, limits, bands, switch=switch)
    assert batch.batch == (3, 3, 2)
    for k, i, j in np.ndindex(3, 3, 2):
        one = plant(model, **{name: values[j] for name, values in changes.items()})
        single = WIND.shift(late[j]) if late else WIND
        control = tv.trim_then_hold(one, single, limits[i, 0], bands[k, 0, 0], switch=switch)
        np.testing.assert_allclose(batch(TIMES)[k, i, j], control(TIMES), rtol=1e-13, atol=1e-17)


@pytest.mark.parametrize(("model", "count"), [("fixed-path", 1), ("drift", 2), ("drift-exact", 2)])
def test_the_control_of_the_report_has_each_rate_once(model: str, count: int) -> None:
    """Zero, of wind and limit, and with drift that of the trim filter, -b1."""
    c = tv.Coefficients.from_beta(beta=0.5, B=0.1, b1=0.03, b2=0.02, C1=0.025, C2=0.002)
    wind = tv.TriangularWind(peak=0.1, duration=7.0)
    control = tv.trim_then_hold(tv.Plant(c, model), wind, -0.005)

    assert control.pieces.rates.size == count
