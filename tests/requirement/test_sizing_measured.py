"""Measured winds in a sizing: levels across the flight, and heights where the wind is not known."""

import numpy as np
import pytest

import tvclin as tv
from tests.turns import usual
from tvclin.ascent.measured_wind import FlightWind, GustOfSpeed
from tvclin.base.lines import text
from tvclin.base.quantities import WIND_KNOWN
from tvclin.requirement.flight.sizing_tables import legend, time_tables, wind_columns_table
from tvclin.requirement.flight.total import total_table
from tvclin.requirement.required_quantity import heading_of
from tvclin.winds.soundings.levels import wind_components

EAST = np.radians(90)


@pytest.fixture(scope="module")
def flight() -> tv.FlightSchedule:
    return tv.load_schedule("configuration-i")


def test_a_level_exactly_across_the_flight_is_one_without_wind(flight) -> None:
    """To rounding: neither sine nor cosine of a whole degree is exactly zero."""
    height = np.linspace(0.0, 45e3, 31)
    for seed in range(20):
        rng = np.random.default_rng(seed)
        speed, come = rng.uniform(5.0, 50.0, 31), rng.integers(0, 361, 31)
        come[::3] = rng.choice([0, 180, 360], 11)
        east, north = wind_components(speed, np.radians(come))
        exact = np.where(come % 180 == 0, 0.0, east)
        encountered, clean = (
            tv.fly_through(tv.WindProfile(height=height, east=e, north=north), flight, azimuth=EAST)
            for e in (east, exact)
        )
        for time in (50.0, 66.0, 90.0):
            vehicle, at = flight.at(time), np.linspace(41.0, 116.0, 301)
            assert encountered(vehicle)(at) == pytest.approx(clean(vehicle)(at), abs=1e-13), seed


def low(flight: tv.FlightSchedule, **options: object) -> tv.ascent.MeasuredWind:
    """Return what the flight meets in a wind that is known from 5 to 15 km: 46.5 to 73.9 s."""
    profile = tv.WindProfile(height=[5e3, 10e3, 15e3], east=[10, 40, 30], north=[0, 0, 0])
    return tv.fly_through(profile, flight, azimuth=EAST, **options)


def test_where_the_wind_is_not_known_nothing_is(flight) -> None:
    encountered = low(flight)
    first, last = encountered.known
    times = [first - 1.0, first, 60.0, last, last + 1.0, flight.span[1]]
    gust = tv.OneMinusCosineGust(peak=0.01, duration=2.0)
    for wind in (encountered, low(flight, window=8.0), low(flight, window=8.0, gust=gust)):
        sizing = tv.size(flight, wind, times=times, dead_bands=1.0, varying=True)
        known = [False, True, True, True, False, False]

        assert sizing.known[:, 0].tolist() == known
        assert sizing.known_times.tolist() == [[first, last]]
        assert np.isfinite(sizing.change[:, 0]).tolist() == known
        for name, values in sizing.required.items():
            assert np.isfinite(values[:, 0]).tolist() == known, name
    assert np.interp([first, last], flight.times, flight.height) == pytest.approx([5e3, 15e3])


def test_a_wind_from_below_the_schedule_on_is_unknown_above_its_last_level_alone(flight) -> None:
    profile = tv.WindProfile(height=[0.0, 9e3, 12.5e3], east=[4, 42, 48], north=[0, 0, 0])
    encountered = tv.fly_through(profile, flight, azimuth=EAST)
    sizing = tv.size(flight, encountered, times=[45.0, 60.0, 80.0], dead_bands=1.0, varying=True)
    first, largest = (next(n for n in sizing.notes if w in n) for w in ("is known", "largest at"))
    table = next(
        one for one in time_tables(sizing, next(iter(sizing.required))) if "frozen" in one.caption
    )
    errors = [text(row[table.head.index("K = 1 off by [%]")]) for row in table.rows]

    assert "is known to 12.5 km (67.44 s) only" in first
    assert largest.startswith("with the vehicle frozen at each flight time, largest at the first")
    assert (errors[0] != "-", errors[2]) == (True, "-")
    assert "K = 1 off by [%]: by how much it is larger with the vehicle frozen" in legend(sizing)


@pytest.mark.parametrize(("limit", "verdict"), usual([(None, None), (0.9, None), (0.2, False)], 1))
def test_a_flight_above_the_last_level_is_never_called_sized(flight, limit, verdict) -> None:
    """Not beside a wind that is known throughout either; what is too little stays too little."""
    winds = {"balloon": low(flight), "pulse": tv.TriangularWind(peak=0.05, duration=7.5)}
    sizing = tv.size(flight, winds, times=[50.0, 60.0, 80.0], dead_bands=1.0)
    total = tv.worst_total(sizing, "K = 1", limit=limit and np.radians(limit))
    within = tv.size(flight, winds, times=[50.0, 60.0], dead_bands=1.0)

    assert np.isfinite(sizing.at_times("K = 1")).all()
    assert total.not_sized == sizing.not_sized("K = 1") == ("above 15.0 km (73.92 s)",)
    assert total.sufficient is verdict
    assert "balloon is known from 5.0 km" in " | ".join(sizing.notes)
    all_known = tv.worst_total(within, "K = 1", limit=limit and np.radians(limit))
    assert (all_known.not_sized, all_known.total) == ((), total.total)
    assert all_known.sufficient is (None if limit is None else limit > 0.5)


def test_a_requirement_that_is_not_defined_at_a_time_is_not_called_covered(flight) -> None:
    turns = tv.SampledWind(time=[40.0, 60.0, 62.0, 66.0, 70.0], angle=[0.1, 0.1, 0.0, -0.1, 0.0])
    sizing = tv.size(flight, turns, times=[50.0, 62.0, 63.0], placing="flight", window=10.0)
    total = tv.worst_total(sizing, "K = 1", limit=1.0)

    assert (total.not_sized, total.sufficient) == (("from 62 to 63 s",), None)


def test_each_wind_has_its_own_worst(flight) -> None:
    winds = {k: tv.TriangularWind(peak=p, duration=7.5) for k, p in (("a", 0.02), ("b", -0.06))}
    sizing = tv.size(flight, winds, times=[60.0, 80.0], dead_bands=1.0)

    for j, wind in enumerate(winds):
        alone = tv.size(flight, winds[wind], times=[60.0, 80.0], dead_bands=1.0)
        for name, worst in sizing.worst_in(wind).items():
            assert worst.deflection == alone.worst[name].deflection == sizing.required[name][0, j]
            assert (worst.time, worst.wind) == (60.0, wind)
    assert sizing.worst["K = 1"] == sizing.worst_in("b")["K = 1"]
    with pytest.raises(tv.InputError, match="wind must be one of a, b"):
        sizing.worst_in("c")


def test_what_is_largest_at_the_first_or_the_last_time_may_be_larger_beyond(flight) -> None:
    wind = tv.TriangularWind(peak=0.05, duration=7.5)
    falls = tv.size(flight, wind, times=[80.0, 60.0, 70.0], dead_bands=1.0)
    vehicle = tv.load_vehicle("configuration-i")
    rises = tv.FlightSchedule(vehicle.replace(time=[40.0, 90.0], aerodynamic_arm=[5.0, 9.0]))
    still = tv.FlightSchedule(vehicle.replace(time=[40.0, 90.0]))

    assert falls.notes[-1].startswith("largest at the first flight time, 60 s; before it, these")
    varying = tv.size(flight, wind, times=[80.0, 60.0, 70.0], dead_bands=1.0, varying=True)
    shown = [heading_of(key.name) for key in varying.required if key.varying and not key.direction]
    assert varying.notes[-1].endswith(f"may be larger: {'; '.join(shown)}")
    assert "after it" in tv.size(rises, wind, times=[50.0, 60.0]).notes[-1]
    for none in (tv.size(still, wind, times=[50.0, 60.0]), tv.size(flight, wind, times=60.0)):
        assert not [note for note in none.notes if "largest at" in note]


def test_a_sounding_has_one_requirement_for_the_flight_at_the_time_at_which_it_arises(
    flight,
) -> None:
    """On a fixed path the dead band is left where B(t) alpha_w(t) of (B1e) is K times the limit."""
    encountered = low(flight, pressure=False)
    bands, options = np.array([1.0, 0.9]), {"model": "fixed-path", "varying": True}
    computed, again = (
        tv.size(flight, encountered, times=times, dead_bands=bands, **options)
        for times in ([50.0, 60.0, 70.0, 80.0], [60.0])
    )
    vehicle, profile = (
        flight.vehicle,
        tv.WindProfile(height=[5e3, 10e3, 15e3], east=[10, 40, 30], north=[0, 0, 0]),
    )
    for K in bands.tolist():
        name = f"K = {K:g}, varying"
        needs = computed.required[name][:3, 0]
        assert np.all(needs == needs[0])
        assert again.required[name][0, 0] == needs[0]
        assert np.isnan(computed.required[name][3, 0])
        worst = computed.worst[name]
        assert worst.time == computed.arising(name)[0] == again.worst[name].time
        assert 46.5 < worst.time < 73.9
        slope, arm, force, lever, speed, path, height = (
            np.interp(worst.time, flight.times, np.broadcast_to(values, flight.times.shape))
            for values in (
                vehicle.normal_force_slope,
                vehicle.aerodynamic_arm,
                vehicle.control_force,
                vehicle.control_arm,
                flight.speed,
                flight.flight_path_angle,
                flight.height,
            )
        )
        wind = np.interp(height, profile.height, profile.in_plane(EAST))
        trim = slope * arm / (force * lever) * np.arcsin(wind * np.sin(path) / speed)
        assert K * worst.deflection == pytest.approx(abs(trim), rel=2e-3)
    total = tv.worst_total(computed, "K = 1, varying")
    assert total.time == computed.worst["K = 1, varying"].time
    nominal = abs(float(flight.nominal_at(total.time)))
    assert total.total == pytest.approx(computed.largest["K = 1, varying"] + nominal)


def test_of_a_sounding_no_row_is_repeated(flight) -> None:
    pulse = tv.TriangularWind(peak=0.05, duration=7.5)
    both = tv.size(flight, {"jet": low(flight), "pulse": pulse}, times=[50.0, 60.0], varying=True)
    alone = tv.size(flight, low(flight), times=[50.0, 60.0], varying=True)
    whole, frozen = time_tables(alone, "K = 1, varying")
    assert "over the whole flight" in whole.caption
    assert [text(row[0]) for row in whole.rows] == ["trim", "K = 1", "K = 0.5", WIND_KNOWN]
    assert ("frozen" in frozen.caption, len(frozen.rows)) == (True, 2)
    assert wind_columns_table(both, "K = 1, varying") == []
    rows = time_tables(both, "K = 1, varying")[
        0
    ].rows  # of the pulse, which has a row for each time
    needs = np.degrees(both.required["K = 1, varying"][:, 1])
    assert [text(row[2]) for row in rows] == [f"{need:.3f}" for need in needs]


def test_a_worst_time_at_an_end_of_the_flight_is_said_beside_it(flight) -> None:
    wind = tv.TriangularWind(peak=0.05, duration=7.5)
    first = tv.size(flight, wind, times=[60.0, 70.0], dead_bands=1.0)
    start = flight.span[0]
    whole = tv.size(flight, wind, times=[start, 70.0], dead_bands=1.0)
    for computed, word in (
        (first, "the first that is sized"),
        (whole, "the first of the schedule"),
    ):
        caption = total_table(tv.worst_total(computed, "K = 1")).caption
        assert caption.endswith(f" s, {word}: more may be needed before")
        ratio = tv.requirement.controllability_ratio(computed, 0.02)
        assert ratio.table.caption.endswith("more may be needed before")
    single = tv.size(flight, wind, times=60.0, dead_bands=1.0)
    assert total_table(tv.worst_total(single, "K = 1")).caption.endswith("time, 60 s")


@pytest.mark.parametrize("plane", ["pitch", "yaw"])
def test_a_gust_of_a_speed_has_at_each_time_the_angle_of_that_time(plane: str) -> None:
    flight = tv.load_schedule("configuration-i")
    wind = tv.WindProfile(height=[4e3, 12e3, 25e3], east=[5.0, 40.0, 5.0], north=[5.0, 30.0, 5.0])
    gust, where = tv.OneMinusCosineGust(peak=0.01, duration=2.0), {"azimuth": 1.0, "plane": plane}
    speed = GustOfSpeed(gust, 9.0, plane)
    result = tv.fly_through(wind, flight, gust=speed, **where)
    for time in (55.0, 80.0):
        vehicle = flight.at(time)
        angle = tv.angle_from_speed(
            9.0, vehicle.velocity, vehicle.attitude if plane == "pitch" else np.pi / 2
        )
        own = tv.OneMinusCosineGust(peak=float(angle), duration=2.0)
        alone = tv.fly_through(wind, flight, gust=own, **where)
        times = np.linspace(time - 2.0, time + 2.0, 41)
        np.testing.assert_allclose(result(vehicle)(times), alone(vehicle)(times), atol=1e-15)


@pytest.mark.parametrize("plane", ["pitch", "yaw"])
def test_a_sounding_has_its_own_wind_triangle_in_both_planes(plane) -> None:
    """Angles and squares of velocities in space; with a bias, the angle beyond that of its wind."""
    flight = tv.load_schedule("configuration-i")
    height = np.linspace(0.0, 40e3, 41)
    whole = tv.WindProfile(height=height, east=-20.0 - height / 1e3, north=50.0 + 0.0 * height)
    mean = tv.WindProfile(height=height, east=-10.0 + 0.0 * height, north=15.0 + 0.0 * height)

    def own(profile: tv.WindProfile, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        speed, path, at = (np.interp(t, flight.times, x) for x in
                           (flight.speed, flight.flight_path_angle, flight.height))  # fmt: skip
        east, north = profile.at(at)
        air = np.array([speed * np.cos(path) - east, -north, speed * np.sin(path)])
        in_plane = np.hypot(air[0], air[2])
        pitch, yaw = np.arctan2(air[2], air[0]) - path, np.arctan2(north, in_plane)
        return (pitch if plane == "pitch" else yaw), (air**2).sum(axis=0) / speed**2

    for bias in (None, mean):
        encountered = tv.fly_through(
            whole, flight, azimuth=np.radians(90.0), plane=plane, bias=bias
        )
        times = encountered.wind.time[:-1]  # none at its end
        angle, ratio = FlightWind(encountered.wind, plane, encountered.speeds).at(times[np.newaxis])
        expected, pressure = own(whole, times)
        if bias is not None:
            expected = expected - own(mean, times)[0]
        assert angle[0] == pytest.approx(expected, abs=1e-12)
        assert ratio[0] == pytest.approx(pressure, rel=1e-12)


@pytest.mark.thorough
@pytest.mark.parametrize("levels", usual([np.arange(0.0, 31e3, 1e3), np.arange(0.0, 31e3, 3e3)], 1))
def test_a_gap_between_levels_leaves_a_sufficient_limit_unknown(flight, levels) -> None:
    """A smaller limit is insufficient with either; only gaps at the flight times count."""
    east = np.interp(levels, [0.0, 12e3, 30e3], [0.0, 40.0, 0.0])
    profile = tv.WindProfile(height=levels, east=east, north=0.0 * levels)
    request = tv.requirement.SizingRequest(
        schedule=flight,
        start=60.0,
        stop=66.0,
        every=3.0,
        soundings={"jet": tv.requirement.SoundingRequest(profile, EAST)},
    )
    verdicts = []
    for limit in np.radians([5.0, 0.01]):
        case = tv.Case(vehicle=flight.at(60.0), nozzle=tv.Nozzle(limit=limit))
        verdicts.append(request.total(case, request.sizing(case)).sufficient)
    has_gaps = levels[1] > 2e3
    assert verdicts == [None if has_gaps else True, False]


@pytest.mark.thorough
def test_a_requirement_that_a_wind_before_the_gust_sets_is_noted(flight) -> None:
    """At late flight times the gust on a sounding does not count, and its rows are the same."""
    height = np.arange(0.0, 49e3, 1e3)
    jet = tv.WindProfile(
        height=height, east=np.interp(height, [0, 9e3, 2e4], [0, 40, 5]), north=0 * height
    )
    gust = tv.OneMinusCosineGust(peak=0.02, duration=3.0)
    late = [90.0, 95.0, 100.0, 105.0]
    wind = tv.fly_through(jet, flight, azimuth=EAST, gust=gust)
    sizing = tv.size(flight, {"jet": wind}, times=[50.0, *late], dead_bands=1.0)
    assert np.ptp(sizing.required["K = 1, varying"][1:, 0]) < 1e-6
    (note,) = [note for note in sizing.notes if "is the same from" in note]
    assert note.startswith("jet: K = 1, varying is the same from 90 to 105 s")
    backwards = tv.size(flight, {"jet": wind}, times=[*late[::-1], 50.0], dead_bands=1.0)
    assert note in backwards.notes
    changing = tv.size(flight, {"jet": wind}, times=[45.0, 50.0, 55.0], dead_bands=1.0)
    assert not any("is the same from" in note for note in changing.notes)


@pytest.mark.thorough
def test_a_sounding_that_ends_is_noted_up_to_its_end_and_a_pulse_never(flight) -> None:
    height = np.arange(0.0, 18.1e3, 1e3)
    jet = tv.WindProfile(
        height=height, east=np.interp(height, [0, 9e3, 1.8e4], [0, 40, 5]), north=0 * height
    )
    gust = tv.OneMinusCosineGust(peak=0.02, duration=3.0)
    wind = tv.fly_through(jet, flight, azimuth=EAST, gust=gust)
    end = float(wind.known[1])
    late = [end - 6.0, end - 4.0, end - 2.0]
    sizing = tv.size(flight, {"jet": wind}, times=[50.0, *late, end + 2.0], dead_bands=1.0)
    same = np.ptp(sizing.required["K = 1, varying"][1:4, 0]) < 1e-6
    assert any("is the same from" in note for note in sizing.notes) == same
    held = tv.FlightSchedule(flight.at(66.0).replace(time=[40.0, 100.0]))
    pulse = tv.TriangularWind(peak=0.05, duration=5.0)
    alike = tv.size(held, {"pulse": pulse}, times=[60.0, 70.0, 80.0], dead_bands=1.0)
    assert np.ptp(alike.required["K = 1, varying"]) < 1e-9
    assert not any("is the same from" in note for note in alike.notes)
