"""Trim and demand over a wind, beside the exact theory, integration and numbers of flights."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tvclin as tv
from tests.turns import usual
from tvclin.ensembles.campaign.cases import nominal
from tvclin.kernels import choice
from tvclin.requirement.encountered_requirement import encountered_requirements
from tvclin.requirement.flight.flight_requirement import (
    FlightMode,
    flight_requirements,
    requirements_along,
)
from tvclin.time_varying import steps
from tvclin.time_varying.curves import at_substeps
from tvclin.time_varying.equations import Equations, at_pressure
from tvclin.time_varying.requirements import SteppedWinds, varying_requirement
from tvclin.winds.wind_angles import NominalWind, along_from_angle, pressure_ratio, wind_triangle

MODELS = ["fixed-path", "drift", "drift-exact", "drift-and-speed"]
PULSES = {"triangular": tv.TriangularWind, "rectangular": tv.RectangularWind}
FOURTH_ORDER = 1e-6
"""Error of the march at its usual step, over the largest trim."""


@pytest.mark.parametrize("dead_band", usual([1.0, 0.75, 0.5, 0.25, 0.0], 0, 2, 4))
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("shape", PULSES)
def test_frozen_vehicles_require_what_the_exact_theory_says(
    configuration_i, shape, model, dead_band
):
    """Of (4b) with exact switching, at nominal dynamic pressure."""
    for duration in (7.5, 30.0):
        wind = PULSES[shape](peak=np.radians(5.0), duration=duration)
        plant = tv.Plant.from_vehicle(configuration_i, model)
        exact = abs(float(tv.required_deflection(plant, wind, dead_band).deflection))
        equations = Equations.frozen(configuration_i.rigid, model, "pitch")
        computed = varying_requirement(equations, NominalWind(wind), dead_band).required[0]
        trim = abs(float(plant.coefficients.B * wind.peak))
        assert computed == pytest.approx(exact, abs=FOURTH_ORDER * trim)


def test_a_short_gust_in_a_long_wind_has_short_steps_of_its_own(configuration_i) -> None:
    """A gust of a fiftieth of a second in a wind of two minutes, beside the exact theory."""
    gust = tv.OneMinusCosineGust(peak=np.radians(1.0), duration=0.02)
    wind = tv.TriangularWind(peak=np.radians(3.0), duration=120.0) + gust.shift(58.0)
    plant = tv.Plant.from_vehicle(configuration_i, "fixed-path")
    equations = Equations.frozen(configuration_i.rigid, "fixed-path", "pitch")
    trim = abs(float(plant.coefficients.B * wind.peak))
    for dead_band in (1.0, 0.5):
        exact = abs(float(tv.required_deflection(plant, wind, dead_band).deflection))
        computed = varying_requirement(equations, NominalWind(wind), dead_band).required[0]
        assert computed == pytest.approx(exact, abs=FOURTH_ORDER * trim)


@pytest.mark.parametrize(
    ("model", "cells"), usual([("drift-exact", 2e-5), ("drift-and-speed", 6e-4)], 0)
)
def test_slow_modes_require_the_minimum_over_all_modes(configuration_i, model, cells) -> None:
    """A minute of wind; the deflection of the dual is constant in steps, never too good by that."""
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=60.0)
    plant = tv.Plant.from_vehicle(configuration_i, model)
    equations = Equations.frozen(configuration_i.rigid, model, "pitch")
    trim = abs(float(plant.coefficients.B * wind.peak))
    for dead_band in (0.5, 0.0):
        exact = tv.required_deflection(plant, wind, dead_band)
        computed = varying_requirement(equations, NominalWind(wind), dead_band).required[0]
        assert "minimum over all unstable poles" in exact.governs
        over = (computed - abs(float(exact.deflection))) / trim
        assert -FOURTH_ORDER < over < cells


@pytest.mark.thorough
def test_a_wind_of_any_duration_has_its_last_value_up_to_its_end(configuration_i) -> None:
    """Rectangles whose step ends round beyond the jump would lose a part of the last step."""
    equations = Equations.frozen(configuration_i.rigid, "fixed-path", "pitch")
    plant = tv.Plant.from_vehicle(configuration_i, "fixed-path")
    for duration in [3.20487, *np.random.default_rng(7).uniform(0.5, 9.0, 60)]:
        wind = tv.RectangularWind(peak=np.radians(5.0), duration=float(duration))
        exact = abs(float(tv.boundary_limit(plant, wind, 1.0, "literal").deflection))
        computed = varying_requirement(equations, NominalWind(wind)).required[0]
        assert computed == pytest.approx(exact, rel=2e-6)


def test_a_flight_that_overflows_has_diverged(configuration_i) -> None:
    """A constant wind of nine hundred time constants, with a limit far too small."""
    equations = Equations.frozen(configuration_i.rigid, "drift-exact", "pitch")
    span = 900.0 / float(equations.fastest[0])
    ends = np.linspace(0.0, span, 9001)
    times = np.stack([ends[:-1], 0.5 * (ends[:-1] + ends[1:]), ends[1:]], axis=-1)[np.newaxis]
    wind, ratio = np.full(times.shape, 0.05), np.ones(times.shape)
    limits = np.array([[1e-4]])
    assert SteppedWinds(equations, times, wind, ratio).diverge(limits).all()


def test_the_march_is_of_fourth_order(configuration_i, monkeypatch) -> None:
    """Half the step, a sixteenth of the error, within the third that the next order adds."""
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
    plant = tv.Plant.from_vehicle(configuration_i, "drift-exact")
    exact = abs(float(tv.boundary_limit(plant, wind, 0.5, "literal").deflection))
    equations = Equations.frozen(configuration_i.rigid, "drift-exact", "pitch")
    errors = []
    for step in (0.496, 0.248, 0.124):  # 8, 16 and 32 steps
        monkeypatch.setattr(steps, "STEP", step)
        result = varying_requirement(equations, NominalWind(wind), 0.5)
        errors.append(abs(float(result.required[0]) - exact))
    ratios = np.array(errors[:-1]) / errors[1:]
    np.testing.assert_allclose(ratios, 16.0, rtol=1 / 3)


@pytest.mark.thorough
@pytest.mark.parametrize("model", usual(["fixed-path", "drift-exact"], 0))
def test_along_a_flight_the_held_limit_leaves_no_unstable_component(model) -> None:
    """LSODA with the vehicle of each time, from the onset to the end, and the costate there."""
    flight = tv.load_schedule("configuration-i")
    mode = FlightMode(flight, model, "pitch", flight.span)
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5).shift(62.0)
    *costate, reach, _absolute = mode.costates_and_reaches(69.5)

    def rates(t, x, delta):
        A, inputs = (
            np.squeeze(matrix) for matrix in flight.plants(t, model, "pitch").matrices()[:2]
        )
        return A @ x + inputs @ [delta, float(wind(min(t, 69.5 - 1e-9)))]

    def component(delta: float) -> float:
        state = np.zeros(len(costate))
        for span in ((62.0, 65.75), (65.75, 69.5)):
            options = {"method": "LSODA", "rtol": 1e-10, "atol": 1e-14, "max_step": 0.5}
            state = solve_ivp(rates, span, state, args=(delta,), **options).y[:, -1]
        return float(np.dot(costate, state) + reach * delta)

    free, unit = component(0.0), component(1.0)
    held = abs(free / (free - unit))
    result = varying_requirement(mode, NominalWind(wind), 0.0)
    assert result.required[0] == pytest.approx(held, abs=FOURTH_ORDER * result.trim[0])


def test_both_ways_of_running_the_kernels_agree(configuration_i) -> None:
    """Plain Python and machine code of one source, but for the last digits."""
    if not choice.available():
        pytest.skip("needs numba")
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
    equations = Equations.frozen(configuration_i.rigid, "drift-exact", "pitch")
    computed = []
    for compiled in (False, True):
        with choice.pinned(compiled):
            computed.append(varying_requirement(equations, NominalWind(wind), 1.0))
    for name in ("trim", "required", "minimum"):
        plain, machine = (getattr(one, name) for one in computed)
        np.testing.assert_allclose(plain, machine, rtol=1e-13)


@pytest.mark.thorough
def test_limits_with_which_the_law_diverges_are_those_of_an_integration(configuration_i) -> None:
    """The ideal trim law with a limit, by LSODA: 0.2 percent to either side of what is required."""
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
    equations = Equations.frozen(configuration_i.rigid, "drift-exact", "pitch")
    edge = float(varying_requirement(equations, NominalWind(wind)).required[0])
    matrix, end = equations.nominal[0, 0, 0], equations.end[0]
    A, b, w = matrix[:, :-2], matrix[:, -2], matrix[:, -1]
    rate = np.sqrt(A[1, 0])

    def flown(limit: float) -> bool:
        def rates(t, x):
            angle = float(wind(min(t, 7.5 - 1e-9)))
            felt = A[1] @ x + w[1] * angle + 10.0 * A[1, 0] * (x[0] + x[1] / rate)
            return A @ x + b * np.clip(-felt / b[1], -limit, limit) + w * angle

        state = np.zeros(3)
        for span in ((0.0, 3.75), (3.75, 7.5)):
            state = solve_ivp(rates, span, state, rtol=1e-9, atol=1e-13, max_step=0.05).y[:, -1]
        return bool(abs(end[:-1] @ state) > limit * abs(end[-1]))

    limits = edge * np.array([[0.998, 1.002]])
    times, angles, ratio = steps.encountered_at_steps(equations, NominalWind(wind), 4)
    diverged = SteppedWinds(equations, times, angles, ratio).diverge(limits)
    assert diverged.tolist() == [[flown(limit) for limit in limits[0].tolist()]] == [[True, False]]


@pytest.mark.parametrize("compiled", [False, True])
def test_the_range_of_trim_is_that_of_its_parabolas(configuration_i, compiled) -> None:
    """Of a gust that changes its sign between the samples; sampled anew, 64 times in each step."""
    gust = tv.winds.OneMinusCosineGust(peak=0.05, duration=3.0)
    wind = gust - gust.shift(3.1) * 0.7
    equations = Equations.frozen(configuration_i.rigid, "drift-exact", "pitch")
    times, angles, ratio = steps.encountered_at_steps(equations, NominalWind(wind), 0.25)
    with choice.pinned(compiled):
        curves = SteppedWinds(equations, times, angles, ratio).curves()
    fine = at_substeps(curves.trim, 64)
    assert curves.trim_range[0] == pytest.approx([fine.min(), fine.max()], rel=1e-5)
    assert curves.trim_range[0, 0] < curves.trim.min() < 0.0 < curves.trim.max()
    assert curves.trim_range[0, 1] > curves.trim.max()
    angles = np.where(np.arange(angles.shape[1])[:, np.newaxis] == 2, np.nan, angles)
    with choice.pinned(compiled):
        unknown = SteppedWinds(equations, times, angles, ratio).curves()
    assert np.isnan(unknown.trim_range).all()


FLOWN = 3e-3
"""What nonlinear and stepped flights, of a program of its own, are good to."""


@pytest.mark.parametrize(("sign", "needed"), [("tail", 0.2945), ("head", 0.3390)])
def test_a_wind_known_by_its_speed_stays_a_velocity(configuration_i, sign, needed) -> None:
    """60 m/s, in degrees; angle and dynamic pressure are those of its triangle."""
    wind = tv.ShapedWind("triangular", 0.05, 7.5).with_speed(60.0, configuration_i, "pitch")
    result = tv.Study.of(tv.Case(vehicle=configuration_i, wind=wind, sign=sign))
    assert np.degrees(result.required_deflection) == pytest.approx(needed, rel=FLOWN)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("shape", "deg", "needed"),
    [
        ("rectangular", 5.0, 0.5172),
        ("rectangular", 8.0, 0.8374),
        ("rectangular", 12.0, 1.2873),
        ("triangular", 12.0, 0.8672),
    ],
)
def test_a_cross_wind_has_its_own_dynamic_pressure(configuration_i, shape, deg, needed) -> None:
    """One over the square of the cosine of its angle."""
    study = tv.Study.from_vehicle(
        configuration_i, wind=shape, duration=7.5, peak=np.radians(deg), plane="yaw"
    )
    assert np.degrees(study.required_deflection) == pytest.approx(needed, rel=FLOWN)
    assert study.governs == "the dynamic pressure in a cross wind"


@pytest.mark.parametrize(
    ("duration", "sign", "needed"),
    usual([(14.2, "head", 0.8592), (14.2, "tail", 0.4386), (20.0, "tail", 0.4599)], 0),
)
def test_along_a_flight_the_wind_triangle_is_that_of_each_time(duration, sign, needed) -> None:
    """Configuration II at 93.5 s, whose path falls by ten degrees within the wind."""
    plan = tv.studyfile.load_sizing("configuration-ii")
    pulse = tv.ShapedWind("rectangular", np.radians(6.5), duration)
    plan = replace(plan, sign=sign, wind=pulse)
    request = replace(plan.sizing, start=93.5, stop=93.5, dead_bands=(1.0,))
    computed = request.sizing(plan).required[f"K = 1, varying, {sign} wind"][0, 0]
    assert np.degrees(computed) == pytest.approx(needed, rel=FLOWN)


def test_a_sounding_of_both_signs_has_the_dynamic_pressure_of_each() -> None:
    """Configuration I through a head wind at 8 to 10 km and a tail wind at 12.4 km."""
    flight = tv.load_schedule("configuration-i")
    east = [0.0, -40.0, -40.0, 0.0, 0.0, 75.0, 0.0]
    height = np.array([6.0, 8.0, 10.0, 12.0, 12.2, 12.4, 12.6]) * 1e3
    sounding = tv.WindProfile(height=height, east=east, north=np.zeros(7))
    encountered = tv.fly_through(sounding, flight, azimuth=np.radians(90.0))
    sizing = tv.size(flight, encountered, times=[66.0], dead_bands=[1.0])
    needed = np.degrees(sizing.required["K = 1, varying"][0, 0])
    assert needed == pytest.approx(0.4711, rel=FLOWN)


SMALL = tv.Vehicle(
    name="small",
    weight=1414762.1,
    moment_of_inertia=25633540.66,
    normal_force_slope=824925.94,
    thrust=2700102.35,
    aerodynamic_arm=10.67752,
    control_arm=25.00668,
    axial_force=40670.82,
    velocity=281.219,
    attitude=0.65366,
    pitch_damping=730431.5,
)
LARGE = tv.Vehicle(
    name="large",
    weight=14314629.0,
    moment_of_inertia=672425158.6,
    normal_force_slope=5514677.6,
    thrust=42188100.6,
    aerodynamic_arm=39.71267,
    control_arm=40.56819,
    axial_force=1206493.8,
    velocity=439.75493,
    attitude=0.6422277,
)


def test_constant_parameters_along_a_flight_require_what_frozen_ones_do() -> None:
    """A schedule of one vehicle at all times, in the model with drift: 0.14774 deg."""
    wind = tv.RectangularWind(peak=np.radians(2.129), duration=1.4226)
    frozen = abs(tv.required_deflection(tv.Plant.from_vehicle(SMALL, "drift"), wind).deflection)
    times = np.array([0.0, 0.5, 1.0, 2.0, 30.0])
    flight = tv.FlightSchedule(SMALL.replace(time=times, weight=np.full(5, SMALL.weight)))
    sizing = tv.size(flight, wind, times=[1.0], model="drift", dead_bands=[1.0])
    along = sizing.required["K = 1, varying"][0, 0]
    assert along == pytest.approx(frozen, rel=1e-6)
    assert np.degrees(along) == pytest.approx(0.14774, rel=FLOWN)


def test_a_campaign_of_one_case_requires_what_a_study_does() -> None:
    """0.56744 deg in the model drift, whose b1/B is not linear in the dynamic pressure."""
    wind = tv.ShapedWind("rectangular", np.radians(5.79583), 21.629)
    case = {"vehicle": LARGE, "wind": wind, "model": "drift", "sign": "tail"}
    study = tv.Study.of(tv.Case(**case))
    campaign = tv.ensembles.Campaign(**case, cases=1)
    assert nominal(campaign)["required_K1"] == pytest.approx(study.required_deflection, rel=1e-9)
    assert np.degrees(study.required_deflection) == pytest.approx(0.56744, rel=2e-5)
    half = encountered_requirements(tv.Case(**case), wind, 0.5)["tail"]["pitch"]
    ratio = float(pressure_ratio(LARGE.attitude, wind.peak))  # constant in a rectangle
    there = Equations.frozen(at_pressure(LARGE, ratio), "drift", "pitch")
    there = replace(there, end=Equations.frozen(LARGE, "drift", "pitch").end)
    exact = varying_requirement(there, NominalWind(wind.history({})), 0.5).required[0]
    assert half == pytest.approx(exact, rel=1e-9)


def test_the_wind_triangle_is_that_of_its_vectors() -> None:
    """The angle between two velocities in space, and the square of one of them."""
    path, along, across = np.radians(44.8), -0.11, 0.07
    ground = np.array([np.cos(path), 0.0, np.sin(path)])
    air = ground - np.array([along, across, 0.0])
    pitch, yaw, ratio = wind_triangle(path, along, across)
    assert ratio == pytest.approx(air @ air)
    in_plane = np.array([air[0], 0.0, air[2]])
    assert np.cos(pitch) == pytest.approx(in_plane @ ground / np.linalg.norm(in_plane))
    assert np.cos(yaw) == pytest.approx(air @ in_plane / np.linalg.norm(in_plane) / np.sqrt(ratio))
    assert wind_triangle(path, along_from_angle(path, 0.05))[0] == pytest.approx(0.05)


def test_dead_bands_of_a_wind_of_two_signs_are_not_defined() -> None:
    flight = tv.load_schedule("configuration-i")
    mode = FlightMode(flight, "drift-exact", "pitch", flight.span)
    time = np.array([60.0, 62.0, 64.0, 66.0])
    wind = tv.SampledWind(time=time, angle=np.array([0.0, 0.02, -0.02, 0.0]))
    (computed,) = flight_requirements(mode, [NominalWind(wind)], np.array([1.0, 0.5]))
    assert np.isfinite(computed.required[0])
    assert np.isnan(computed.required[1])


@pytest.mark.thorough
@pytest.mark.parametrize("dead_band", [1.0, 0.5])
@pytest.mark.parametrize("quick", [False, True])
def test_a_wind_along_a_flight_requires_the_same_among_others_as_alone(quick, dead_band) -> None:
    flight = tv.load_schedule("configuration-ii" if quick else "configuration-i")
    first, last = flight.span
    mode = FlightMode(flight, "drift-exact", "pitch", flight.span)
    times = np.linspace(first + 8.0, last - 8.0, 5)
    winds = [NominalWind(tv.TriangularWind(peak=0.05, duration=7.5).shift(t - 3.75)) for t in times]
    winds.append(NominalWind(tv.RectangularWind(peak=-0.03, duration=15.0).shift(first)))
    together = requirements_along(mode, winds, dead_band)
    single = np.concatenate([requirements_along(mode, [wind], dead_band) for wind in winds])
    assert mode.quick_path == quick
    assert np.all(together[:, 0] > 0.0)
    assert together.tolist() == single.tolist()
