"""The worst case in a box against brute force, and why corners suffice for K = 1."""

from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual
from tvclin.control.margins.margins import loop_margins
from tvclin.design import worst_case

VEHICLE = tv.load_vehicle("configuration-i")
COEFFICIENTS = tv.Coefficients.from_vehicle(VEHICLE)
LOOP = tv.design_gains(
    COEFFICIENTS, natural_frequency=1.0, damping=0.7, actuator=tv.Actuator(), delay=0.02
)
WIND = tv.ShapedWind("triangular", 0.09, 7.5)


def part(name, spread):
    value = getattr(VEHICLE, name)
    return (1.0 - spread) * value, (1.0 + spread) * value


def test_the_limit_rises_with_tau_beta_in_every_wind_of_one_peak():
    """What the proof says, in shapes of the package and in winds of random samples."""
    x = np.geomspace(0.2, 40.0, 120)
    plants = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=x, B=1.0))
    winds = [
        tv.TriangularWind(peak=0.05, duration=1.0),
        tv.RectangularWind(peak=0.05, duration=1.0),
        tv.OneMinusCosineGust(peak=0.05, duration=1.0),
        tv.winds.AsymmetricTriangularWind(peak=0.05, duration=1.0, peak_time=0.1),
    ]
    random = np.random.default_rng(3)
    for _ in range(12):
        up, down = (np.sort(random.random(random.integers(2, 6))) for _ in range(2))
        shape = 0.05 * np.concatenate([[0.0], up, [1.0], down[::-1], [0.0]])
        winds.append(tv.SampledWind(time=np.linspace(0.0, 1.0, shape.size), angle=shape))
    for wind in winds:
        limit = tv.boundary_limit(plants, wind).limit
        assert np.all(np.diff(limit) > -1e-9 * limit[1:]), wind


def test_what_a_limit_leaves_over_grows_with_beta():
    """The integral of e^(-beta s) (w - y) is zero at the boundary, and positive for more beta."""
    from scipy.integrate import quad

    wind = tv.winds.AsymmetricTriangularWind(peak=1.0, duration=4.0, peak_time=1.0)

    def final_motion(beta, y):
        start, end = y * 1.0, 4.0  # where w = y, on the way up
        inside = quad(lambda t: np.exp(-beta * t) * (float(wind(t)) - y), start, end, points=[1.0])
        return inside[0] - y * np.exp(-beta * end) / beta

    for beta in (0.3, 0.8, 2.0):
        plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=beta, B=1.0))
        y = float(tv.boundary_limit(plant, wind).limit)
        assert final_motion(beta, y) == pytest.approx(0.0, abs=1e-9)
        assert final_motion(1.1 * beta, y) > 1e-4


def test_with_a_dead_band_nothing_is_proved():
    worst = tv.worst_case(
        COEFFICIENTS,
        LOOP,
        {"wind_duration": (5.0, 20.0)},
        model="fixed-path",
        wind=WIND,
        dead_band=0.5,
    )
    assert worst.deflection.method == "searched"


@pytest.mark.thorough
def test_the_worst_deflection_of_a_box_is_at_the_proved_corner():
    box = {
        "thrust": part("thrust", 0.05),
        "normal_force_slope": part("normal_force_slope", 0.1),
        "moment_of_inertia": part("moment_of_inertia", 0.05),
        "control_arm": part("control_arm", 0.02),
        "wind_duration": (5.0, 10.0),
        "wind_peak": (0.07, 0.1),
    }
    result = tv.worst_case(VEHICLE, LOOP, box, model="fixed-path", wind=WIND)
    worst = result.deflection
    assert (worst.method, worst.corner) == ("corners (proved)", True)
    minimum, most = (dict(zip(box, ends, strict=True)) for ends in zip(*box.values(), strict=True))
    rises = {"normal_force_slope", "wind_duration", "wind_peak"}
    assert worst.at == {name: (most if name in rises else minimum)[name] for name in box}
    random = np.random.default_rng(1)
    draws = {name: random.uniform(*ends, size=2000) for name, ends in box.items()}
    plants = tv.Plant.from_vehicle(
        VEHICLE.replace(**{k: v for k, v in draws.items() if not k.startswith("wind")}),
        "fixed-path",
    )
    winds = tv.TriangularWind(peak=draws["wind_peak"], duration=draws["wind_duration"])
    inside = np.abs(tv.boundary_limit(plants, winds).deflection).max()
    assert 0.8 * worst.value < inside < worst.value


@pytest.mark.thorough
@pytest.mark.parametrize("model", usual(["fixed-path", "drift-exact"], 1))
def test_no_margin_of_a_random_point_is_worse(model):
    box = {
        "thrust": part("thrust", 0.05),
        "aerodynamic_arm": part("aerodynamic_arm", 0.1),
        "delay": (0.0, 0.1),
        "actuator_frequency": (15.0, 30.0),
        "gain": (0.7, 1.4),
    }
    worst = tv.worst_case(VEHICLE, LOOP, box, model=model)
    assert worst.stable
    assert worst.deflection is None
    random = np.random.default_rng(2)
    drawn = {name: random.uniform(*ends, size=600) for name, ends in box.items()}
    plants = tv.Plant.from_vehicle(
        VEHICLE.replace(thrust=drawn["thrust"], aerodynamic_arm=drawn["aerodynamic_arm"]), model
    )
    loops = replace(
        LOOP,
        attitude_gain=LOOP.attitude_gain * drawn["gain"],
        rate_gain=LOOP.rate_gain * drawn["gain"],
        delay=drawn["delay"],
        actuator=tv.Actuator(natural_frequency=drawn["actuator_frequency"], damping=0.7),
    )
    margins = loop_margins(loops.exact_loop(plants))
    for name, margin in worst.margins.items():
        assert margin.value <= np.min(getattr(margins, name)) < margin.nominal, name


def test_a_worst_point_inside_is_found():
    """The phase margin has its crossover between two others: the least lies inside the box."""
    gains = tv.Autopilot(attitude_gain=0.3, rate_gain=0.3)
    box = {"gain": (0.4, 30.0)}
    worst = tv.worst_case(COEFFICIENTS, gains, box, model="fixed-path")
    scan = np.linspace(0.4, 30.0, 2001)
    loops = tv.Autopilot(attitude_gain=0.3 * scan, rate_gain=0.3 * scan)
    plant = tv.Plant.from_coefficients(COEFFICIENTS, "fixed-path")
    margins = loop_margins(loops.exact_loop(plant))
    for name in ("phase_margin_deg", "disk_margin"):
        assert worst.margins[name].value <= np.min(getattr(margins, name)) + 1e-6


def test_the_margins_of_a_sampled_loop_are_in_samples():
    """Corners of a box of delays have the margins of these autopilots, which samples lower."""
    sampled, ends = replace(LOOP, sample_rate=10.0), (0.0, 0.08)
    plant = tv.Plant.from_vehicle(VEHICLE, "fixed-path")
    with (
        patch.object(worst_case, "_INTERIOR_POINTS", 2),
        patch.dict(worst_case._SEARCH_OPTIONS, rounds=1, per_round=2),
    ):
        worst = tv.worst_case(VEHICLE, sampled, {"delay": ends}, model="fixed-path")
    margins = replace(sampled, delay=np.array(ends)).margins(plant)
    for name, margin in worst.margins.items():
        assert margin.value == pytest.approx(np.min(getattr(margins, name)), rel=1e-9), name
    continuous = replace(LOOP, delay=ends[1]).margins(plant).phase_margin_deg
    assert worst.margins["phase_margin_deg"].value < continuous - 2.0


def test_a_box_in_which_the_loop_falls_over_has_no_margins():
    worst = tv.worst_case(VEHICLE, LOOP, {"gain": (0.05, 1.0)})
    assert not worst.stable
    assert worst.margins["disk_margin"].value == 0.0
    assert worst.margins["disk_margin"].at == {"gain": 0.05}


@pytest.mark.parametrize(
    ("box", "words"),
    [
        ({}, "1 to 10 numbers"),
        ({"thrst": (1.0, 2.0)}, "thrust"),
        ({"delay": (0.1, 0.1)}, "a least and a larger value"),
        ({"wind_peak": (0.05, 0.1)}, "a number in box"),
        ({"mu_alpha": (0.1, 0.2)}, "a number in box"),
        ({"thrust": (-1.0, 1.0)}, "thrust"),
    ],
)
def test_a_box_that_is_none_is_refused(box, words):
    with pytest.raises(tv.InputError, match=words):
        tv.worst_case(VEHICLE, LOOP, box)
    with pytest.raises(tv.InputError, match="actuator"):
        tv.worst_case(VEHICLE, replace(LOOP, actuator=None), {"actuator_damping": (0.5, 0.9)})
