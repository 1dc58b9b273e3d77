"""Autopilots around flexible plants: check cases, margins by band, detuned modes, filters."""

from dataclasses import replace

import control
import numpy as np
import pytest

import tvclin as tv
from tests.flexible import BOOSTER, STRUCTURE, transfer
from tests.turns import usual
from tvclin.base.lines import text
from tvclin.control.autopilot.actuator import plant_with_actuator
from tvclin.control.autopilot.detuning import StableRange
from tvclin.control.comparison import wind_gain

FILTERS = (tv.vehicle.Filter.low_pass(13.0, 0.95), tv.vehicle.Filter.notch(32.0, 0.06, 0.6))
AUTOPILOT = tv.Autopilot(
    attitude_gain=0.36,
    rate_gain=0.56,
    actuator=tv.Actuator(natural_frequency=22.0, damping=0.8),
    delay=0.02,
    filters=FILTERS,
)


def booster(model="drift-exact", **changes):
    return tv.FlexiblePlant.from_vehicle(BOOSTER, replace(STRUCTURE, **changes), model)


def to_margin(number, **more):
    """Compare with a number that was computed in another way, to six digits."""
    return pytest.approx(number, abs=1.01e-6, **more)


# A course example: fixed path, mu_alpha = 1, mu_delta = 10, one mode that adds
# k w^2/(s^2 + 2 zeta w s + w^2) to mu_delta/(s^2 - mu_alpha).
COURSE = tv.Vehicle(
    weight=9.80665e4,
    moment_of_inertia=1e6,
    normal_force_slope=1e5,
    thrust=1e6,
    aerodynamic_arm=10.0,
    control_arm=10.0,
    axial_force=0.0,
    velocity=500.0,
    attitude=0.0,
)
NOTCH = tv.vehicle.Filter.notch(24.0 * np.pi, 0.05, 0.5)


def course(hertz, k=5e-4, filters=()):
    frequency, mass = 2.0 * np.pi * hertz, 1e4
    slope = -k * frequency**2 * mass / COURSE.thrust
    mode = tv.vehicle.BendingMode(
        frequency=frequency,
        damping=0.005,
        modal_mass=mass,
        gimbal_displacement=1.0,
        gimbal_slope=0.0,
        attitude_slope=slope,
        rate_slope=slope,
    )
    plant = tv.FlexiblePlant.from_vehicle(
        COURSE, tv.Structure(bending=(mode,), thrust_follows=False), "fixed-path"
    )
    autopilot = tv.Autopilot(
        attitude_gain=5.0,
        rate_gain=1.26,
        actuator=tv.Actuator(natural_frequency=20.0 * np.pi, damping=0.7),
        filters=filters,
    )
    return autopilot.band_margins(plant)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("hertz", "k", "filters", "unstable", "peak", "at", "closed"),
    [
        (12.0, 5e-4, (), 2, 8.7606, 12.0017, 0.013569 + 76.445033j),
        (12.0, 5e-4, (NOTCH,), 0, -11.2394, 12.0017, -0.349562 + 75.489167j),
        (13.2, 5e-4, (NOTCH,), 0, -5.0782, 13.2040, -0.533833 + 83.141470j),
        (3.0, 5e-4, (), 0, 3.6043, None, -0.236727 + 18.832807j),
        (3.0, -5e-4, (), 2, 3.6194, None, 0.046225 + 18.863751j),
    ],
)
def test_the_course_example(hertz, k, filters, unstable, peak, at, closed):
    result = course(hertz, k, filters)
    mode = result.mode("bending 1")
    assert result.margins.unstable_poles == unstable
    assert mode.peak_dB == pytest.approx(peak, abs=0.51e-4)
    if at is not None:
        assert mode.peak_frequency / (2 * np.pi) == pytest.approx(at, abs=0.51e-4)
    assert mode.closed_pole == pytest.approx(closed, abs=1e-6)
    assert (mode.stabilised == "unstable") == (unstable > 0)


def test_the_margins_of_the_course_example():
    hertz = course(12.0).margins.crossings.gain_frequencies / (2 * np.pi)
    np.testing.assert_allclose(hertz, [2.06624, 11.85995, 12.16750], atol=0.51e-5)
    m = course(12.0, filters=(NOTCH,)).margins
    assert m.phase_margin_deg == pytest.approx(47.28655, abs=0.51e-5)
    assert m.crossover_frequency / (2 * np.pi) == pytest.approx(2.03827, abs=0.51e-5)
    assert m.gain_increase_dB == pytest.approx(12.67744, abs=0.51e-5)
    assert m.gain_increase_frequency / (2 * np.pi) == pytest.approx(6.0967, abs=0.51e-4)
    assert course(3.0).margins.phase_margin_deg == pytest.approx(56.2096, abs=0.51e-4)


def test_the_loop_of_the_booster():
    loop = AUTOPILOT.exact_loop(booster())
    expected = [-1.98274061 - 1.02175840j, -0.40067520 - 0.01350961j, -1.14316925 - 4.95323008j]
    np.testing.assert_allclose(loop.response([0.5, 5.0, 14.0]), expected, rtol=0, atol=1e-8)
    assert loop.poles.size == 17 + 4
    # All roots of 1 + L with the exact delay in the box, by the argument around them.
    assert winding(loop, -38.0, 0.0, 300.0) == 1 + 2 * 9
    poles = [
        *(-0.04781783, -1.08802251 + 0.20137190j, -0.04639328 + 2.84229635j),
        *(-0.05497001 + 3.05482508j, -6.48217077 + 3.74295039j, -21.10030933 + 12.53243234j),
        *(-0.97433769 + 14.72192906j, -19.25582974 + 26.61464422j),
        *(-0.18125870 + 31.02518228j, -0.38159174 + 64.98426496j),
    ]
    near = np.array(poles)[np.newaxis]
    step = -(1.0 + loop.form.value(near)) / loop.form.slope(near)  # Newton's to the root beside
    np.testing.assert_allclose(np.abs(step), 0.0, atol=1.5e-8)


def winding(loop, left, right, top):
    """Return zeros less poles of 1 + L in a box, by the argument around it."""
    sides = [left - 1j * top, right - 1j * top, right + 1j * top, left + 1j * top]
    path = [
        np.linspace(a, b, 20_001)[:-1] for a, b in zip(sides, sides[1:] + sides[:1], strict=True)
    ]
    s = np.concatenate([*path, sides[:1]])
    values = 1.0 + loop.form.value(s[np.newaxis])[0]
    turns = np.angle(values[1:] / values[:-1]).sum() / (2.0 * np.pi)
    inside = (loop.poles.real > left) & (loop.poles.real < right) & (np.abs(loop.poles.imag) < top)
    return round(turns) + int(np.sum(inside))


def test_the_margins_of_the_booster():
    m = AUTOPILOT.margins(booster())
    assert m.aero_margin_dB == to_margin(9.958725)
    assert m.aero_frequency == to_margin(0.173008)
    assert m.gain_increase_dB == to_margin(8.057026)
    assert m.gain_increase_frequency == to_margin(5.134358)
    assert m.phase_margin_deg == to_margin(42.306172)
    assert m.crossover_frequency == to_margin(1.411959)
    assert m.delay_margin == pytest.approx(0.06117709, abs=1e-8)
    assert m.delay_margin_frequency == to_margin(14.830743)
    assert m.disk_margin == pytest.approx(0.66305900, abs=1e-8)
    assert m.disk_frequency == to_margin(3.146026)
    assert m.peak_sensitivity == to_margin(1.868418)
    assert m.peak_complementary_sensitivity == to_margin(1.590427)


def test_the_bands_of_the_booster():
    result = AUTOPILOT.band_margins(booster())
    assert [mode.name for mode in result.modes] == [
        *("bending 1", "bending 2", "bending 3", "slosh 1", "slosh 2")
    ]
    words = [mode.stabilised for mode in result.modes]
    assert words == ["phase", "gain", "gain", "with the rigid body", "with the rigid body"]
    one = result.mode("bending 1")
    assert (one.peak_dB, one.peak_frequency) == (to_margin(24.220428), to_margin(13.789344))
    assert np.degrees(one.lag_margin) == to_margin(51.984558)
    assert np.degrees(one.lead_margin) == to_margin(105.386982)
    assert 20 * np.log10(one.gain_increase) == to_margin(17.355766)
    assert one.phase_margin_deg == to_margin(51.984558)
    assert np.isnan(one.gain_margin_dB)
    margins = [result.mode(f"bending {k}").gain_margin_dB for k in (2, 3)]
    assert margins == [to_margin(16.816351), to_margin(19.243885)]
    distances = [result.mode(f"slosh {k}").distance for k in (1, 2)]
    assert distances == [to_margin(0.640864), to_margin(0.535212)]
    assert one.closed_pole == pytest.approx(-0.97433769 + 14.72192906j, abs=1e-8)
    assert result.rigid.gain_increase_dB == result.margins.gain_increase_dB
    assert "bending 3, stabilised" in result._repr_html_()
    with pytest.raises(tv.InputError, match="name must be one of bending 1, bending 2"):
        result.mode("bending")


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("plant", "margin", "number"),
    [
        (booster(engine=None), "gain_increase_dB", 7.953497),
        (
            booster(
                slosh=(),
                bending=tuple(
                    replace(m, tank_displacements=(), tank_slopes=()) for m in STRUCTURE.bending
                ),
            ),
            "gain_increase_dB",
            8.314347,
        ),
        (booster(bending=()), "gain_increase_dB", 11.800283),
        (tv.Plant.from_vehicle(BOOSTER, "drift-exact"), "gain_increase_dB", 12.280650),
        (tv.Plant.from_vehicle(BOOSTER, "drift-exact"), "aero_margin_dB", 10.047997),
        (booster(thrust_follows=False), "aero_margin_dB", 10.076278),
        (booster("fixed-path"), "aero_margin_dB", 10.433832),
        (booster("drift-and-speed"), "aero_margin_dB", 9.956537),
    ],
)
def test_what_each_part_of_the_booster_does(plant, margin, number):
    autopilot = AUTOPILOT
    if isinstance(plant, tv.Plant):  # the same lag of the gyro
        autopilot = replace(autopilot, rate_filters=(STRUCTURE.rate_gyro,))
    assert getattr(autopilot.margins(plant), margin) == to_margin(number)


@pytest.mark.thorough
def test_detuned_modes_of_the_booster():
    result = tv.control.detuned(AUTOPILOT, booster())
    m, row = result.margins, result.row
    assert m.gain_increase_dB[row("bending 1 x 0.8")] == pytest.approx(5.603, abs=0.51e-3)
    far = row("bending 1 x 1.2")
    assert m.phase_margin_deg[far] == pytest.approx(26.700, abs=0.51e-3)
    assert m.crossover_frequency[far] == pytest.approx(17.227, abs=0.51e-3)
    assert result.critical_margin[far] == "phase_margin_deg"
    assert result.critical_margin[row("bending 1 x 0.8")] == "gain_increase_dB"
    turned = [row(f"bending {k}, sensor slopes of opposite sign") for k in (1, 2)]
    assert m.unstable_poles[turned[0]] == 2
    assert result.critical_margin[turned[0]] == "unstable"
    assert m.gain_increase_dB[turned[1]] == pytest.approx(5.657, abs=0.51e-3)
    plant = booster(
        bending=(
            STRUCTURE.bending[0],
            replace(STRUCTURE.bending[1], frequency=0.9 * 30.18),
            STRUCTURE.bending[2],
        )
    )
    assert AUTOPILOT.band_margins(plant).mode("bending 2").peak_dB == pytest.approx(
        -4.861, abs=0.51e-3
    )
    assert all(np.isnan([edge.lower, edge.upper]).all() for edge in result.stable_ranges)
    (stays,) = result.stability_lines
    assert text(stays) == "The loop is stable with any one mode from 0.8 to 1.2 of its frequency."
    assert "bending 1 x 0.8" in result._repr_html_()


@pytest.mark.thorough
def test_detuned_modes_are_held_to_what_is_asked_of_modes():
    """4.861 dB are left of the second mode at 0.9 of its frequency, of 16.816 dB at its place."""
    criteria = tv.control.Criteria.custom(mode_gain_margin_dB=10.0, aero_margin_dB=1.0)
    result = tv.control.detuned(AUTOPILOT, booster(), factors=[0.9, 1.0], criteria=criteria)
    off, home = result.row("bending 2 x 0.9"), result.row("bending 2 x 1")
    assert (
        result.critical_margin[off]
        == result.critical_margin[home]
        == "mode_gain_margin_dB of bending 2"
    )
    assert not result.satisfied[off]
    assert result.satisfied[home]
    assert result.satisfied[result.row("nominal")]
    lower = tv.control.detuned(
        AUTOPILOT, booster(), [0.9], tv.control.Criteria.custom(mode_gain_margin_dB=4.8)
    )
    assert lower.satisfied[lower.row("bending 2 x 0.9")]
    turned = result.row("bending 1, sensor slopes of opposite sign")
    assert result.critical_margin[turned] == "unstable"
    assert not result.satisfied[turned]


@pytest.mark.parametrize(
    ("lower", "upper", "words"),
    [
        (0.9664, 1.1081, "bending 1 is stable from 0.966 to 1.108 of its frequency"),
        (0.9664, np.nan, "bending 1 is unstable at 0.966 of its frequency"),
        (np.nan, 1.1081, "bending 1 is unstable at 1.108 of its frequency"),
        (np.nan, np.nan, ""),
        (1.0, 1.0, ""),  # unstable without a change: not of this mode
    ],
)
def test_a_stable_range_in_words(lower, upper, words):
    assert text(StableRange("bending 1", lower, upper).line()) == words


@pytest.mark.thorough
def test_a_loop_that_is_unstable_without_a_change_has_no_stable_range():
    wild = replace(AUTOPILOT, attitude_gain=0.01)
    (line,) = tv.control.detuned(wild, booster(), factors=[0.8]).stability_lines
    assert text(line) == "The loop is unstable with all modes at their frequencies."


@pytest.mark.thorough
def test_the_edge_of_a_detuned_loop_is_where_its_mode_leaves_the_left_half_plane():
    loud = replace(AUTOPILOT, delay=0.07)
    result = tv.control.detuned(loud, booster(), factors=[0.8, 1.3])
    upper = result.stable_ranges[0].upper
    assert 1.0 < upper < 1.3
    mode = STRUCTURE.bending[0]
    for factor, unstable in ((upper * (1 - 1e-5), 0), (upper * (1 + 1e-5), 2)):
        moved = replace(mode, frequency=factor * mode.frequency)
        m = loud.margins(booster(bending=(moved, *STRUCTURE.bending[1:])))
        assert m.unstable_poles == unstable


def test_the_exact_loop_is_the_product_of_its_blocks():
    extra = tv.vehicle.Filter.lead_lag(-8.0, 11.0)
    autopilot = replace(
        AUTOPILOT,
        alpha_gain=0.1,
        integral_gain=0.05,
        attitude_filters=(extra, FILTERS[1]),
        rate_filters=FILTERS[:1],
    )
    for plant in (booster(), tv.Plant.from_vehicle(BOOSTER, "drift-exact")):
        seen = plant_with_actuator(plant, autopilot.actuator)
        sensed = isinstance(plant, tv.FlexiblePlant) * "sensed_"
        names = (f"{sensed}attitude", f"{sensed}attitude_rate", "angle_of_attack")
        for omega in (0.3, 4.0, 14.0, 40.0):
            s = 1j * omega
            attitude, rate, angle = (
                transfer(seen.matrices(), s)[seen.outputs.index(name), 0] for name in names
            )
            request = (0.36 + 0.05 / s) * attitude * extra(s) * FILTERS[1](s)
            request += 0.56 * rate * FILTERS[0](s) + 0.1 * angle
            expected = -request * FILTERS[0](s) * FILTERS[1](s) * np.exp(-0.02 * s)
            result = autopilot.frequency_response(plant, omega)
            assert result == pytest.approx(expected, rel=1e-9)
            system = replace(autopilot, delay=0.0).loop(plant)
            assert system(s) == pytest.approx(expected / np.exp(-0.02 * s), rel=1e-9)


def test_python_control_closes_the_same_loop():
    plant, autopilot = booster(), replace(AUTOPILOT, delay=0.0)
    closed = autopilot.close(plant)
    assert closed.state_labels[-4:] == ["filter_1_1", "filter_1_2", "filter_2_1", "filter_2_2"]
    mine = np.sort_complex(autopilot.exact_loop(plant).form.closed_poles()[0])
    theirs = np.sort_complex(control.feedback(autopilot.loop(plant), 1).poles())
    np.testing.assert_allclose(mine, np.sort_complex(closed.poles()), atol=1e-9 * 120.0)
    np.testing.assert_allclose(mine, theirs, atol=1e-9 * 120.0)


def test_filters_reach_the_answer_to_a_wind():
    wind = tv.TriangularWind(peak=0.02, duration=7.5)
    plant = tv.Plant.from_vehicle(BOOSTER, "drift-exact")
    autopilot = replace(AUTOPILOT, delay=0.0)
    times = np.linspace(0.0, 12.0, 2401)
    expected = (
        control.forced_response(autopilot.close(plant)[:, "wind"], times, wind(times))
        .outputs[-1]
        .ravel()
    )
    computed = autopilot.wind_response(plant, wind)(times)[-1]
    np.testing.assert_allclose(computed, expected, atol=1e-7)


@pytest.mark.thorough
def test_criteria_know_bands():
    criteria = tv.control.Criteria.custom(
        aero_margin_dB=6.0, mode_gain_margin_dB=18.0, mode_phase_margin_deg=45.0
    )
    result = AUTOPILOT.band_margins(booster())
    judged = {(one.criterion.margin, one.band): one for one in criteria.judge(result)}
    assert len(judged) == 1 + 2 * 5
    assert not judged["mode_gain_margin_dB", "bending 2"].satisfied
    assert judged["mode_gain_margin_dB", "bending 2"].surplus == to_margin(16.816351 - 18.0)
    assert judged["mode_gain_margin_dB", "bending 3"].satisfied
    assert judged["mode_gain_margin_dB", "bending 1"].surplus == np.inf
    assert judged["mode_phase_margin_deg", "bending 1"].satisfied
    assert judged["aero_margin_dB", ""].satisfied
    assert not criteria.are_satisfied(result)
    just = judged["mode_gain_margin_dB", "bending 2"].value
    for spare, satisfied in ((0.1, True), (0.0, True), (-0.1, False)):
        every = tv.control.Criteria.custom(mode_gain_margin_dB=just - spare).judge(result)
        assert [one.satisfied for one in every if one.band == "bending 2"] == [satisfied]
    with pytest.raises(tv.InputError, match="is a criterion of modes"):
        criteria.judge(result.margins)
    turned = replace(STRUCTURE.bending[0], attitude_slope=-0.2724, rate_slope=-0.2548)
    lost = AUTOPILOT.band_margins(booster(bending=(turned, *STRUCTURE.bending[1:])))
    assert not any(one.satisfied for one in criteria.judge(lost))
    assert lost.mode("bending 1").stabilised == "unstable"


def test_a_mode_in_a_loop_that_is_large_is_not_held_by_gain():
    """Liquid that sloshes below the crossover: the whole peak lies above one, and near -1."""
    tank = tv.vehicle.SloshTank(mass=7000.0, station=-5.0, damping=0.005, frequency=0.5)
    plant = tv.FlexiblePlant.from_vehicle(BOOSTER, tv.Structure(slosh=(tank,)), "drift-exact")
    gains = tv.Autopilot(attitude_gain=0.54, rate_gain=0.84, actuator=AUTOPILOT.actuator)
    bands = gains.band_margins(plant)
    slosh = bands.mode("slosh 1")
    around = slosh.frequency * (1.0 + np.linspace(-0.01, 0.01, 2001))
    loop = np.abs(gains.frequency_response(plant, around))
    assert loop.min() > 1.0
    assert bands.margins.status == "ok"
    assert slosh.stabilised == "phase"
    assert np.isnan(slosh.gain_margin_dB)
    assert np.isnan(slosh.phase_margin_deg)
    assert slosh.lag_margin == slosh.lead_margin == np.inf


@pytest.mark.thorough
def test_a_batch_of_plants_is_each_of_them():
    factors = np.array([0.9, 1.0, 1.1])
    first = STRUCTURE.bending[0]
    many = booster(bending=(replace(first, frequency=factors * 13.58), *STRUCTURE.bending[1:]))
    result = AUTOPILOT.band_margins(many)
    for k, factor in enumerate(factors):
        one = booster(bending=(replace(first, frequency=factor * 13.58), *STRUCTURE.bending[1:]))
        single = AUTOPILOT.band_margins(one)
        assert result.margins.gain_increase[k] == pytest.approx(
            single.margins.gain_increase, rel=1e-9
        )
        for name in ("peak", "lag_margin", "closed_pole", "distance"):
            pair = [getattr(b.mode("bending 1"), name) for b in (result, single)]
            assert pair[0][k] == pytest.approx(pair[1], rel=1e-8)
        assert result.mode("slosh 2").stabilised[k] == single.mode("slosh 2").stabilised


def test_what_does_not_go_together_is_refused():
    with pytest.raises(tv.InputError, match="actuator of second order"):
        tv.Autopilot(attitude_gain=1.0, rate_gain=1.0).margins(booster())
    with pytest.raises(tv.InputError, match="plant must be a Plant or a FlexiblePlant"):
        AUTOPILOT.margins("booster")
    with pytest.raises(tv.InputError, match="filters"):
        replace(AUTOPILOT, filters=("notch",))
    with pytest.raises(tv.InputError, match="plant with a bending mode or a tank"):
        tv.control.detuned(AUTOPILOT, booster(bending=(), slosh=(), engine=None))
    rigid = tv.Plant.from_vehicle(BOOSTER, "fixed-path")
    with pytest.raises(tv.InputError, match="plant must be a FlexiblePlant"):
        AUTOPILOT.band_margins(rigid)


@pytest.mark.thorough
def test_the_worst_wind_of_a_loop_with_filters_is_that_of_a_fine_grid():
    plant = tv.Plant.from_vehicle(BOOSTER, "drift-exact")
    autopilot = replace(AUTOPILOT, delay=0.0, alpha_gain=0.1, rate_filters=(FILTERS[0],))
    omega = np.geomspace(1e-3, 1e2, 20_001)
    highest = np.abs(autopilot.close(plant)["deflection", "wind"](1j * omega)).max()
    result = wind_gain(plant, autopilot)
    assert highest <= result * (1.0 + 1e-12)
    assert highest == pytest.approx(result, rel=1e-6)  # the grid's step, squared


@pytest.mark.thorough
@pytest.mark.parametrize("factor", usual([0.5, 1.0, 3.5], 1))
def test_the_distance_of_a_mode_is_the_least_of_a_much_finer_look(factor):
    """Polished between frequencies; with a high gain some modes come close to -1."""
    plant = booster()
    gains = {"attitude_gain": 0.36 * factor, "rate_gain": 0.56 * factor}
    autopilot = replace(AUTOPILOT, **gains)
    result = autopilot.band_margins(plant)
    for mode in result.modes:
        half = 8.0 * abs(mode.pole.real)
        omega = np.linspace(mode.pole.imag - half, mode.pole.imag + half, 400_001)
        brute = np.abs(1.0 + autopilot.frequency_response(plant, omega)).min()
        assert mode.distance <= brute * (1.0 + 1e-9)
        assert mode.distance == pytest.approx(brute, rel=1e-6)
