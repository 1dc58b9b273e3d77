"""Flights of both planes with one stop, against one plane, and against an integration by scipy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tvclin as tv
from tests.turns import by_turns, usual

BETA, B = 0.5, 0.1
PLANT = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=BETA, B=B))
GUST = tv.TriangularWind(peak=0.08, duration=8.0)
TRIM = GUST.peak * B
RATE = 50.0


def veering(degrees: float) -> tv.winds.PlaneWind:
    return tv.winds.PlaneWind.veering(GUST, angle=0.0, rate=np.radians(degrees) / GUST.duration)


def flown(
    law: tv.control.Law, wind: tv.winds.PlaneWind, limits: object, **options: object
) -> tv.flights.FlownPlanes:
    limit = TRIM * np.asarray(limits)
    options = {"sample_rate": RATE, **options}
    return tv.flights.fly_planes(PLANT, law, wind, deflection_limit=limit, **options)


LAWS = {
    "trim": tv.TrimLaw(PLANT),
    "lean": tv.RecoverableAttitudeLaw(PLANT, design_peak=0.08),
    "gains": tv.SaturatedLaw(tv.Autopilot(attitude_gain=0.3, rate_gain=0.5, alpha_gain=0.1)),
    "estimates": tv.RecoverableAttitudeLaw(
        PLANT, estimator=tv.control.WindEstimator(bandwidth=5.0)
    ),
}


@by_turns("name,nozzle", LAWS, ["at once", "late"], each=4)
def test_in_a_straight_wind_it_is_the_flight_of_one_plane(name, nozzle) -> None:
    """In any direction; rates are limited in each plane, so that none is here."""
    law, limits = LAWS[name], np.array([0.35, 0.6, 0.75, 0.95])
    options = {} if nozzle == "at once" else {
        "actuator": tv.Actuator(natural_frequency=20.0, damping=None), "delay": 0.03
    }  # fmt: skip
    one = tv.fly_many(PLANT, law, GUST, deflection_limit=TRIM * limits, sample_rate=RATE, **options)
    for degrees in (33, 250):
        both = flown(law, tv.winds.PlaneWind.towards(GUST, np.radians(degrees)), limits, **options)
        assert both.status.tolist() == one.status.tolist()
        saved = one.status == "survived"
        assert np.any(saved)
        for key in ("peak_attitude", "peak_deflection"):
            values = getattr(one, key)[saved]
            assert getattr(both, key)[saved] == pytest.approx(values, rel=1e-9), key


@by_turns("stop,saturate", ["round", "square"], ["radial", "each plane"], each=2)
def test_a_flight_is_the_solution_of_its_equations(stop, saturate) -> None:
    """In both planes theta'' = beta^2 alpha - (beta^2/B) delta, with delta held over a sample."""
    wind, limit, gain = veering(180.0), 0.75 * TRIM, 10.0
    result = flown(tv.TrimLaw(PLANT, gain=gain), wind, 0.75, limit_shape=stop, saturate=saturate)
    inner = limit if stop == "square" else limit / np.sqrt(2.0)
    x, t = np.zeros(2, complex), 0.0
    for k in range(int(GUST.duration * RATE)):
        assert result.attitude[k] == pytest.approx(x[0], abs=1e-9)
        u = B * (x[0] - wind(t) + gain * (x[0] + x[1] / BETA))
        if saturate == "each plane":
            u = np.clip(u.real, -inner, inner) + 1j * np.clip(u.imag, -inner, inner)
        else:
            size = abs(u) if stop == "round" else max(abs(u.real), abs(u.imag))
            u *= min(1.0, limit / size) if size else 1.0

        def moved(t, x, u=u):
            return np.array([x[1], BETA**2 * (x[0] - wind(t)) - BETA**2 / B * u])

        step = solve_ivp(moved, (t, t + 1.0 / RATE), x, rtol=1e-10, atol=1e-14)
        x, t = step.y[:, -1], t + 1.0 / RATE


@pytest.mark.parametrize(
    ("name", "degrees", "lost", "saved"),
    usual([("trim", 90, 0.67, 0.70), ("trim", 180, 0.66, 0.69), ("lean", 180, 0.44, 0.49)], 2),
)
def test_what_a_turning_wind_asks_of_a_flight(name, degrees, lost, saved) -> None:
    """More than the boundary of both planes, whose control must know where the wind turns to."""
    wind = veering(degrees)
    assert flown(LAWS[name], wind, [lost, saved]).status.tolist() == ["lost", "survived"]
    needed = tv.plane_limit(PLANT, wind)
    assert saved > (needed.limit if name == "trim" else needed.no_forecast_bound)


def test_each_plane_by_itself_costs_what_the_square_inside_costs() -> None:
    """sqrt(2) times the larger part of the direction, 30 degrees from pitch."""
    wind = tv.winds.PlaneWind.towards(GUST, np.radians(30))
    edge = 0.6885 * np.sqrt(2.0) * np.cos(np.radians(30))
    result = flown(LAWS["trim"], wind, [0.98 * edge, 1.02 * edge], saturate="each plane")
    assert result.status.tolist() == ["lost", "survived"]
    assert flown(LAWS["trim"], wind, 0.70).status == "survived"
    assert np.all(result.peak_deflection <= np.array([0.98, 1.02]) * edge * TRIM * (1 + 1e-12))


@pytest.mark.thorough
def test_the_limit_of_a_law_is_found_as_in_one_plane() -> None:
    """Both scan alike: of a straight wind the edges are the same."""
    short = tv.TriangularWind(peak=0.08, duration=4.0)
    options = {"sample_rate": 25.0, "lowest": 0.2, "highest": 1.0}
    one = tv.closed_loop_boundary(PLANT, LAWS["trim"], short, **options)
    wind = tv.winds.PlaneWind.towards(short, 1.0)
    both = tv.flights.flown_plane_limit(PLANT, LAWS["trim"], wind, **options)
    assert both.limit == pytest.approx(one.limit, abs=1e-5)
    assert both.deflection == pytest.approx(abs(one.deflection), rel=1e-4)


def test_what_cannot_be_flown_in_two_planes_is_refused() -> None:
    wind = veering(90.0)
    noisy = tv.control.WindEstimator(bandwidth=5.0, rate_noise=1e-4)
    bad = {
        "wind must have a direction": {"wind": GUST},
        "must not switch": {"law": tv.control.DeadBandLaw(PLANT, dead_band=0.5)},
        "filters and noise": {"law": tv.RecoverableAttitudeLaw(PLANT, estimator=noisy)},
        "first order": {"actuator": tv.Actuator(natural_frequency=20.0, damping=0.7)},
        "limit_shape must be one of": {"limit_shape": "oval"},
        "saturate must be one of": {"saturate": "never"},
        "deflection_limit must be positive": {"deflection_limit": 0.0},
    }
    good = {"law": LAWS["trim"], "wind": wind, "deflection_limit": TRIM, "sample_rate": RATE}
    for words, changes in bad.items():
        with pytest.raises(tv.InputError, match=words):
            tv.flights.fly_planes(PLANT, **{**good, **changes})
    with pytest.raises(tv.InputError, match="highest must be above lowest"):
        tv.flights.flown_plane_limit(PLANT, LAWS["trim"], wind, lowest=1.0, highest=0.5)
