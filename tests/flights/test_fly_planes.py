"""Flights of both planes with one stop, against one plane, and against an integration by scipy."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tvclin as tv
from tests.turns import by_turns, usual
from tests.whole_flight import autopilot, flight
from tvclin.kernels import choice

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


@pytest.mark.thorough
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


@pytest.mark.thorough
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


@pytest.mark.thorough
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


FROZEN_TIME = 60.0


@pytest.mark.thorough
@by_turns("shape,degrees", ["round", "square", "square-45"], [0, 180], each=2)
def test_a_frozen_flight_in_both_planes_is_that_of_the_frozen_vehicle(shape, degrees) -> None:
    """To rounding, with a delay, an actuator and a rate limit."""
    made, span = flight(flexible=False), np.array([50.0, 120.0])
    vehicle = made.at(FROZEN_TIME).rigid
    still = tv.FlightSchedule(vehicle.replace(time=span))
    servo = tv.Actuator(natural_frequency=20.0, damping=None)
    law = tv.Autopilot(attitude_gain=0.5, rate_gain=0.6, delay=0.01, sample_rate=RATE)
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=8.0).shift(60.003)
    wind = tv.winds.PlaneWind.veering(wind, np.radians(30.0), np.radians(degrees) / 8.0)
    plants = [tv.Plant.from_vehicle(vehicle, "fixed-path", plane) for plane in ("pitch", "yaw")]
    statuses = set()
    for limit in np.radians([0.3, 0.6]):
        options = {"deflection_limit": limit, "limit_shape": shape, "rate_limit": np.radians(2.0)}
        frozen = tv.flights.fly_planes(
            plants[0],
            tv.SaturatedLaw(tv.Autopilot(attitude_gain=0.5, rate_gain=0.6)),
            wind,
            yaw_plant=plants[1],
            saturate="each plane" if shape == "square" else "radial",
            actuator=servo,
            sample_rate=RATE,
            delay=0.01,
            **options,
        )
        along = tv.flights.fly_planes_along(
            still,
            replace(law, actuator=servo),
            wind,
            sign="frozen",
            model="fixed-path",
            start=60.003,
            **options,
        )
        pitch, yaw = (along.planes[plane] for plane in ("pitch", "yaw"))
        count = min(frozen.time.size, along.times.size, 800)
        for name, expected in (("attitude", frozen.attitude), ("deflection", frozen.deflection)):
            got = (pitch.outputs[name] + 1j * yaw.outputs[name])[:count]
            size = np.abs(expected[:count]).max()
            np.testing.assert_allclose(got, expected[:count], rtol=0.0, atol=1e-11 * size)
        assert along.status == frozen.status
        statuses.add(along.status)
    assert len(statuses) == 2


@pytest.mark.thorough
def test_a_varying_flight_in_both_planes_is_the_solution_of_its_equations() -> None:
    """A veering wind, the pressure of its triangle, and the vector limit, in small steps: 1e-5."""
    made, h = flight(flexible=False), 0.02
    laws = autopilot(sample_rate=50.0, delay=0.0, actuator=None)
    pulse = tv.TriangularWind(peak=np.radians(5.0), duration=6.0).shift(52.0)
    wind = tv.winds.PlaneWind.veering(pulse, np.radians(30.0), np.radians(20.0))
    limit = np.radians(0.35)
    flown = tv.flights.fly_planes_along(
        made, laws, wind, deflection_limit=limit, start=52.0, stop=56.0
    )
    size = {plane: np.abs(along.outputs["attitude"]).max() for plane, along in flown.planes.items()}

    grid = 52.0 + h / 4 * np.arange(801)
    path, angle = np.interp(grid, made.times, made.vehicle.attitude), wind(grid)
    ratio = (np.sin(path) / np.sin(path + angle.real) / np.cos(angle.imag)) ** 2
    at = made.at(grid)
    forces = {n: getattr(at, n) * ratio for n in ("normal_force_slope", "axial_force")}
    system = [
        tv.Plant.from_vehicle(at.replace(**forces), "drift-exact", plane).matrices()[:2]
        for plane in ("pitch", "yaw")
    ]

    def slope(j, x, u):
        inputs = ([u.real, angle[j].real], [u.imag, angle[j].imag])
        return np.concatenate(
            [
                A[j] @ state + B[..., :2][j if B.ndim > 2 else ...] @ values
                for (A, B), state, values in zip(system, np.split(x, 2), inputs, strict=True)
            ]
        )

    x, limited = np.zeros(6), 0
    for k in range(200):
        t = 52.0 + k * h
        for first, plane in ((0, "pitch"), (3, "yaw")):
            got = flown.planes[plane].outputs["attitude"][k]
            assert got == pytest.approx(x[first], abs=1e-5 * size[plane]), (plane, t)
        gains = laws.along(made, t)
        u = gains.attitude_gain * (x[0] + 1j * x[3]) + gains.rate_gain * (x[1] + 1j * x[4])
        limited += abs(u) > limit
        u *= min(1.0, limit / abs(u)) if u else 1.0
        for j in (4 * k, 4 * k + 2):
            k1 = slope(j, x, u)
            k2 = slope(j + 1, x + h / 4 * k1, u)
            k3 = slope(j + 1, x + h / 4 * k2, u)
            x = x + h / 12 * (k1 + 2 * k2 + 2 * k3 + slope(j + 2, x + h / 2 * k3, u))
    assert limited > 20


@pytest.mark.thorough
@pytest.mark.parametrize("gust", usual([None, tv.TriangularWind(peak=0.02, duration=3.0)], 0))
def test_planes_in_a_sounding_without_limits_are_flights_of_one_plane(gust) -> None:
    made, law = flight(flexible=False), autopilot(sample_rate=50.0)
    height, speed = [0.0, 8e3, 9e3, 3e4], np.array([0.0, 40.0, 10.0, 0.0])
    profile = tv.WindProfile(height=height, east=speed, north=0.5 * speed)
    options = {"deflection_limit": 0.5, "start": 45.0, "stop": 75.0}
    options["gust_time"] = None if gust is None else 55.0
    sounding = {"azimuth": np.pi / 2, "gust": gust}
    wind = tv.fly_through(profile, made, plane="both", **sounding)
    both = tv.flights.fly_planes_along(made, law, wind, **options)
    for plane, along in both.planes.items():
        part = wind.component(plane, made.at(55.0).rigid)
        alone = tv.flights.fly_along(made, law, part, plane=plane, **options)
        for name, values in alone.outputs.items():
            np.testing.assert_allclose(
                along.outputs[name], values, rtol=0.0, atol=1e-13, err_msg=name
            )
    assert both.status == "survived"


@pytest.mark.thorough
def test_a_wind_in_pitch_alone_is_the_flight_of_that_plane_to_its_limit() -> None:
    made, law = flight(), autopilot(sample_rate=50.0)
    gust = tv.TriangularWind(peak=np.radians(4.0), duration=6.0).shift(52.0)
    head = tv.winds.PlaneWind.towards(-gust, 0.0)
    for limit, status in ((1.0, "survived"), (0.2, "lost")):
        options = {"deflection_limit": np.radians(limit), "start": 52.0, "rate_limit": 0.3}
        both = tv.flights.fly_planes_along(made, law, head, **options)
        alone = tv.flights.fly_along(made, law, -gust, sign="head", **options)
        assert both.status == alone.status == status
        pitch = both.planes["pitch"].outputs["deflection"]
        np.testing.assert_allclose(pitch, alone.outputs["deflection"], rtol=0.0, atol=1e-13)
        assert not np.any(both.planes["yaw"].outputs["attitude"])


@pytest.mark.thorough
def test_a_nozzle_that_overshoots_its_limit_shape_is_not_known_to_survive() -> None:
    """A square limits each plane at the nozzle too; a circle limits its commands alone."""
    made = flight(flexible=False)
    law = autopilot(sample_rate=50.0, actuator=tv.Actuator(natural_frequency=9.0, damping=0.3))
    wind = tv.TriangularWind(peak=np.radians(5.0), duration=1.5).shift(52.0)
    wind = tv.winds.PlaneWind.towards(wind, np.radians(30.0))
    statuses = {}
    for shape, limit in (("round", 0.3), ("round-each-plane", 0.3), ("round", 2.0)):
        flown = tv.flights.fly_planes_along(
            made, law, wind, limit_shape=shape, deflection_limit=np.radians(limit), start=52.0
        )
        statuses[shape, limit] = flown.status
        above = flown.largest("deflection").value > np.radians(limit) * (1.0 + 1e-9)
        assert above == (flown.status == "outside")
    assert statuses == {
        ("round", 0.3): "outside",
        ("round-each-plane", 0.3): "survived",
        ("round", 2.0): "survived",
    }


@pytest.mark.parametrize(
    ("autopilots", "options", "message"),
    [
        ({"pitch": 50.0}, {}, "autopilot must be one for both planes"),
        ({"pitch": 50.0, "yaw": 25.0}, {}, "the same sample_rate in both planes"),
        ({"pitch": 50.0, "yaw": 50.0}, {"sign": "head"}, "sign must be"),
        ({"pitch": 50.0, "yaw": 50.0}, {"wind": GUST}, "wind must be a PlaneWind"),
        ({"pitch": None, "yaw": None}, {}, "give the autopilot a sample_rate"),
    ],
)
def test_flights_in_both_planes_that_cannot_be(autopilots, options, message) -> None:
    laws = {plane: autopilot(sample_rate=rate) for plane, rate in autopilots.items()}
    wind = tv.winds.PlaneWind.towards(GUST.shift(52.0), 0.5)
    options = {"wind": wind, "deflection_limit": 0.1} | options
    with pytest.raises(tv.InputError, match=message):
        tv.flights.fly_planes_along(flight(flexible=False), laws, **options)


@pytest.mark.thorough
@pytest.mark.skipif(not choice.available(), reason="machine code needs numba")
def test_machine_code_flies_both_planes_as_plain_python_does() -> None:
    wind = tv.winds.PlaneWind.towards(GUST.shift(52.0), 0.5)
    options = {"deflection_limit": 0.006, "limit_shape": "square-45", "start": 52.0, "stop": 56.0}
    flown = []
    for compiled in (False, True):
        with choice.pinned(compiled):
            law = autopilot(sample_rate=25.0)
            flown.append(tv.flights.fly_planes_along(flight(flexible=False), law, wind, **options))
    plain, machine = (along.outputs["deflection"] for along in flown)
    np.testing.assert_allclose(machine, plain, rtol=0.0, atol=1e-13)
