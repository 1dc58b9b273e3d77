"""Launch availability: what each sounding asks for, and how many fly."""

import csv
import io
from itertools import pairwise

import numpy as np
import pytest

import tvclin as tv
from tests.archives import Balloon, days, jet, write
from tests.requirement.test_sizing_varying import trim_law_is_lost
from tests.turns import usual
from tvclin.ascent.measured_wind import FlightWind, GustOfSpeed
from tvclin.ensembles.statistics import effective_number, survival_fraction
from tvclin.flights.closed_loop.survival_limit import FINE, LAST_PARTS
from tvclin.requirement.flight.flight_requirement import FlightMode
from tvclin.time_varying.requirements import SteppedWinds
from tvclin.time_varying.steps import encountered_at_steps

EAST = np.radians(90.0)
PITCH = {"azimuth": EAST, "plane": "pitch", "sign": "frozen"}
"""In the dynamic pressure of calm air, in which the equations are the same as those of `size`."""
JETS, ROUGH = 1e-4, 1e-3
"""Of needs: levels of winds are not ends of the even steps, within which a demand is a cubic. Where
its slope turns by t that is off by t h/16 at the most; in jets by some parts in 1e5, in winds that
change by 20 m/s from level to level by some in 1e4."""
CLOSE = 1e-6
"""Limits and times are multiplied, divided and rounded."""
STRAIGHT = 1e-4
"""Even steps of a flight and of a part of it have other ends."""
EDGE = FINE + FINE / LAST_PARTS
"""Error of edges of flights: the finest step in which limits are tried, here from two starts."""


@pytest.fixture(scope="module")
def flight():
    return tv.load_schedule("configuration-i")


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """Return jets of 5, 10 ... 100 m/s, twice a day."""
    balloons = [
        Balloon(time, jet(5.0 * (i + 1))) for i, time in enumerate(days("2023-02-01T00", 20))
    ]
    return tv.read_soundings(write(tmp_path_factory.mktemp("a") / "s-data.txt", balloons))


def profile(seed, top=35e3):
    """Return a wind that wanders, from all sides."""
    rng = np.random.default_rng(seed)
    height = np.linspace(0.0, top, 40)
    height[1:-1] += rng.uniform(-400.0, 400.0, 38)
    strength = 50.0 * np.exp(-(((height - 11e3) / 5e3) ** 2))
    east, north = (strength * rng.uniform(-0.3, 1.0) + rng.normal(0, 8, 40) for _ in range(2))
    return tv.WindProfile(height=height, east=east, north=north)


def one(wind):
    return tv.winds.Soundings.from_profiles([wind], ["2024-02-01"])


def size_says(flight, wind, gust=None, plane="pitch", azimuth=EAST, pressure=False):
    """Return what `size` says with varying parameters, frozen parts at the peak of the wind."""
    encountered = tv.fly_through(
        wind, flight, azimuth=azimuth, plane=plane, gust=gust, pressure=pressure
    )
    peak = float(encountered.wind.time[np.argmax(np.abs(encountered.wind.angle))])
    sizing = tv.size(flight, encountered, times=[peak], dead_bands=1.0, varying=True, plane=plane)
    return float(sizing.required["K = 1, varying"][0, 0])


@pytest.mark.parametrize("i", usual([2, 14], 1))
def test_each_sounding_needs_what_size_says(flight, archive, i) -> None:
    result = tv.availability(flight, archive, limit=0.01, **PITCH)
    assert result.lower[i] == pytest.approx(size_says(flight, archive[i]), rel=JETS)


@pytest.mark.parametrize("azimuth", usual([EAST, -EAST], 1), ids=["tail", "head"])
@pytest.mark.parametrize("plane", usual(["pitch", "yaw"], 0))
def test_the_dynamic_pressure_met_counts_as_in_size(flight, archive, azimuth, plane) -> None:
    """Within what different steps leave of the ratio of two bounds, less than a thousandth."""
    where = {"azimuth": azimuth + (plane == "yaw"), "plane": plane}
    result = tv.availability(flight, archive, limit=0.01, **where)
    calm = tv.availability(flight, archive, limit=0.01, sign="frozen", **where)
    for i in (2, 14):
        said = size_says(flight, archive[i], pressure=True, **where)
        assert result.lower[i] == pytest.approx(said, rel=1e-3)
    assert np.all((result.lower > calm.lower) == (azimuth < 0.0))
    with pytest.raises(tv.InputError, match="have their own sign"):
        tv.availability(flight, archive, limit=0.01, sign="head", **where)


def lost_flown(flight, wind, azimuth, plane, limits, feedback=10.0):
    """Fly the ideal trim law with limits, in the wind's own angle and dynamic pressure.

    By Runge and Kutta's rule in steps of 0.02 s between the times of levels and rows. `feedback`:
    that of the unstable component of the attitude, over trim.
    """
    height, time = flight.height, flight.times
    levels = wind.height[(wind.height > height[0]) & (wind.height < height[-1])]
    knots = np.unique(np.concatenate([time, np.interp(levels, height, time)]))
    along, across = wind.in_plane(azimuth), wind.cross_plane(azimuth)
    x = None
    for low, high in pairwise(knots.tolist()):
        steps = int(np.ceil((high - low) / 0.02))
        t, h = np.linspace(low, high, 2 * steps + 1), (high - low) / steps
        at, held = np.interp(t, time, height), flight.clamped_at(t)
        w, c = (np.interp(at, wind.height, v) / held.velocity for v in (along, across))
        ratio = (np.cos(held.attitude) - w) ** 2 + np.sin(held.attitude) ** 2 + c**2
        angle = np.arcsin((w * np.sin(held.attitude) if plane == "pitch" else c) / np.sqrt(ratio))
        force, axial = (
            getattr(held, name) * ratio for name in ("normal_force_slope", "axial_force")
        )
        blown = held.replace(normal_force_slope=force, axial_force=axial)
        A, B = tv.Plant.from_vehicle(blown, "drift-exact", plane).matrices()[:2]
        x = np.zeros((np.size(limits), A.shape[-1])) if x is None else x

        def rates(k, x, A=A, B=B, angle=angle):
            stiff = A[k, 1, 0]
            felt = x @ A[k, 1] + B[k, 1, 1] * angle[k]
            felt += feedback * stiff * (x[:, 0] + x[:, 1] / np.sqrt(stiff))
            delta = np.clip(-felt / B[k, 1, 0], -limits, limits)
            return x @ A[k].T + np.outer(delta, B[k, :, 0]) + angle[k] * B[k, :, 1]

        for k in range(0, 2 * steps, 2):
            first = rates(k, x)
            second = rates(k + 1, x + 0.5 * h * first)
            third = rates(k + 1, x + 0.5 * h * second)
            last = rates(k + 2, x + h * third)
            x = x + h / 6.0 * (first + 2.0 * (second + third) + last)
    A, B = (matrix[0] for matrix in flight.plants(time[-1:], "drift-exact", plane).matrices()[:2])
    poles, rows = np.linalg.eig(A.T)
    fastest = int(np.argmax(np.where(np.abs(poles.imag) < 1e-9, poles.real, -np.inf)))
    row = rows[:, fastest].real
    return np.abs(x @ row) > np.abs(row @ B[:, 0]) / poles[fastest].real * limits


@pytest.mark.thorough
@pytest.mark.parametrize("tried", usual([[2, 4], [0, 1, 2, 3, 4]], 0))
def test_a_wind_that_turns_where_the_path_is_quick_is_lost_as_its_flights_are(tried) -> None:
    """Trim meets the limit to one side alone; the path that the limited flight leaves counts."""
    booster = tv.load_schedule("configuration-ii")
    given = np.array([0.0, 5.2, 6.3, 8.0, 9.9, 11.8, 37.2]) * 1e3
    height = np.unique(np.append(given, np.arange(0.0, 37e3, 500.0)))
    cross = np.interp(height, given, [0.0, 19.0, 8.0, 0.0, -6.1, -2.0, 0.0])
    wind = tv.WindProfile(height=height, east=0.0 * height, north=-cross)
    limits = np.radians([0.0840, 0.0866, 0.0874, 0.0879, 0.0884, 0.09])
    lost = lost_flown(booster, wind, EAST, "yaw", limits)
    assert lost.tolist() == [True, True, True, True, False, False]
    # a law with a feedback of a hundred times trim, and not of ten, is lost up to less
    stiffer = lost_flown(booster, wind, EAST, "yaw", limits, feedback=100.0)
    assert stiffer.tolist() == [True, True, True, False, False, False]
    for limit, flies in zip(limits[tried], ~lost[tried], strict=True):
        options = {"limit": float(limit), "azimuth": EAST, "plane": "yaw"}
        result = tv.availability(booster, one(wind), **options)
        assert result.flies[0] == flies
        edge = result.lower[0] if not flies else result.upper[0]
        assert edge == pytest.approx(np.radians(0.08815), rel=3e-3)
    # with gaps above two kilometres it is not known, and never said to fly
    gaps = tv.WindProfile(height=given, east=0.0 * given, north=-np.interp(given, height, cross))
    for limit in limits[tried[:-1]].tolist():
        result = tv.availability(booster, one(gaps), limit=limit, azimuth=EAST, plane="yaw")
        assert result.flies[0] != 1.0


@pytest.mark.thorough
def test_a_narrow_window_of_losses_above_a_limit_that_survives_is_seen(flight) -> None:
    """In a cross wind that turns about, flights with 1.004 to 1.0075 of the bound are lost."""
    given = np.array([0.0, 5.0, 9.7, 13.1, 16.7, 19.2, 22.7, 25.3, 27.2, 42.0]) * 1e3
    cross = np.array([0.0, 2.3, 11.6, -11.6, 10.1, 13.5, -15.8, -8.0, -15.0, -0.5])
    height = np.unique(np.append(given, np.arange(0.0, 42e3, 500.0)))
    wind = tv.WindProfile(height=height, east=0.0 * height, north=-np.interp(height, given, cross))
    options = {"azimuth": EAST, "plane": "yaw"}
    bound = tv.availability(flight, one(wind), limit=1e-4, **options).lower[0]
    limits = bound * np.array([1.002, 1.006, 1.01])
    assert lost_flown(flight, wind, EAST, "yaw", limits).tolist() == [False, True, False]
    for limit, flies in zip(limits.tolist(), (0.0, 0.0, 1.0), strict=True):
        assert tv.availability(flight, one(wind), limit=limit, **options).flies[0] == flies


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "plane", "seed"),
    usual(
        [
            (name, plane, seed)
            for name in ("configuration-i", "configuration-ii")
            for plane in ("pitch", "yaw")
            for seed in range(3)
        ],
        10,
    ),
)
def test_rough_soundings_are_judged_as_size_and_own_flights_say(name, plane, seed) -> None:
    """Winds along and across in any direction; none is too good by more than 0.3 percent."""
    booster, rng = tv.load_schedule(name), np.random.default_rng(100 + seed)
    height = np.arange(0.0, 40e3, rng.choice([250.0, 500.0, 1000.0]))
    shape = np.exp(-(((height - 11e3) / 5e3) ** 2))
    roughness = rng.uniform(4.0, 20.0)
    east, north = (
        rng.uniform(-50.0, 50.0) * shape + rng.normal(0.0, roughness, height.size) * np.sqrt(shape)
        for _ in range(2)
    )
    wind = tv.WindProfile(height=height, east=east, north=north)
    where = {"azimuth": float(rng.uniform(0.0, 2.0 * np.pi)), "plane": plane}
    needed = size_says(booster, wind, pressure=True, **where)
    parts = np.array([0.98, 1.003, 1.01, 1.03, 1.06, 1.1])
    lost = lost_flown(booster, wind, where["azimuth"], plane, parts * needed)
    assert lost.tolist() == [True, *(5 * [False])]
    for part, flies in ((0.98, 0.0), (1.02, 1.0)):
        result = tv.availability(booster, one(wind), limit=part * needed, **where)
        assert result.flies[0] == flies


@pytest.mark.thorough
def test_rough_winds_need_what_size_says_or_are_doubted(flight) -> None:
    """A law that lets go meets the limit more than once: what it needs is known to some percent."""
    height = np.arange(0.0, 34e3, 1000.0)
    shape = np.exp(-(((height - 11e3) / 5e3) ** 2))
    winds = []
    for seed in (0, 32, 8, 17, 23):
        noise = np.random.default_rng(seed).normal(0, 20, height.size) * np.sqrt(shape)
        winds.append(tv.WindProfile(height=height, east=40.0 * shape + noise, north=0.0 * height))
    rough = tv.winds.Soundings.from_profiles(winds, days("2023-02-01T00", 5))
    needed = np.array([size_says(flight, wind) for wind in winds])
    result = tv.availability(flight, rough, limit=1e-4, **PITCH)
    doubted = result.upper > result.lower
    assert np.any(doubted)
    assert not np.all(doubted)
    assert result.lower[~doubted] == pytest.approx(needed[~doubted], rel=ROUGH)
    assert np.all(needed <= result.upper)
    # what flights need less than trim and demand say is seen where the limit is judged
    fewer = np.flatnonzero(needed < result.lower * (1.0 - ROUGH))
    assert fewer.size == 1
    for limit, flies in ((1.01 * needed[fewer[0]], 1.0), (0.99 * needed[fewer[0]], 0.0)):
        assert tv.availability(flight, rough, limit=limit, **PITCH).flies[fewer[0]] == flies
    doubted[fewer] = False
    # near the limit the others are flown
    limit = 1.001 * needed[doubted][0]
    near = tv.availability(flight, rough, limit=limit, **PITCH)
    assert near.lower[doubted][0] == pytest.approx(needed[doubted][0], rel=EDGE)
    (flown,) = (note for note in near.notes if "flown with trim: " in note)
    assert flown.endswith(
        "higher limits are flown every 0.2 to 2 %, and one between these may be lost"
    )
    between = result.with_limit(1.001 * result.lower[doubted][0])
    assert "was not flown" in np.array(between.why)[doubted][0]
    # so what one sounding asks for depends on the limit
    assert np.isnan(between.flies[doubted][0])
    assert result.lower[doubted][0] <= near.lower[doubted][0] * (1.0 + EDGE)
    assert near.lower[doubted][0] <= result.upper[doubted][0]
    assert near.today(winds[int(np.argmax(needed))]).go is bool(limit > needed.max())
    fixed = tv.availability(flight, rough, limit=1e-4, model="fixed-path", **PITCH)
    assert np.array_equal(fixed.lower, fixed.upper)  # there nothing needs to be flown


@pytest.mark.thorough
@pytest.mark.parametrize("model", usual(["fixed-path", "drift-exact"], 1))
def test_a_wind_that_turns_about_flies_with_less_than_its_bound(model) -> None:
    """As a flight by other steps says; with half of the bound that is lost."""
    booster = tv.load_schedule("configuration-ii")
    height = np.unique(np.append(np.arange(0.0, 40e3, 500.0), [9.2e3, 9.201e3, 10.001e3, 10.8e3]))
    east = np.where((height > 9.2e3) & (height <= 10e3), -44.0, 0.0)
    east[(height > 10e3) & (height < 10.8e3)] = 50.0
    wind = tv.WindProfile(height=height, east=east, north=0.0 * height)
    request = PITCH | {"model": model}
    bound = tv.availability(booster, one(wind), limit=1e-4, **request).lower[0]
    encountered = tv.fly_through(wind, booster, azimuth=EAST).wind
    parts = np.array([0.55, 0.9, 0.95, 1.0])
    lost = trim_law_is_lost(booster, encountered, model, parts * bound)
    assert lost.tolist() == [True, False, False, False]
    for part, flies in ((0.9, True), (0.55, False), (0.4, False)):
        result = tv.availability(booster, one(wind), limit=part * bound, **request)
        assert result.flies[0] == flies
        assert result.lower[0] == pytest.approx(bound * (part if flies else 1.0), rel=CLOSE)
        assert any("a flight of the trim law survives" in note for note in result.notes) == flies
        assert result.today(wind).go is flies
    for stop in ("square", "round"):
        turned = tv.WindProfile(height=height, east=east / 2**0.5, north=east / 2**0.5)
        result = tv.availability(
            booster, one(turned), limit=0.0, azimuth=EAST, limit_shape=stop, model=model
        ).lower[0]
        again = tv.availability(
            booster, one(turned), limit=0.9 * result, azimuth=EAST, limit_shape=stop, model=model
        )
        assert again.flies[0] == 1.0


def test_a_flight_in_few_rows_is_looked_at_between_them_as_well(archive) -> None:
    """As with the rows that lie between."""
    coarse = tv.load_schedule("configuration-i", step=15.0)
    times = np.linspace(*coarse.span, 151)
    height = np.interp(times, coarse.times, coarse.height)
    fine = tv.FlightSchedule(coarse.clamped_at(times), altitude=height)
    result = tv.availability(coarse, archive[6:7], limit=0.01, **PITCH)

    assert result.lower[0] == pytest.approx(size_says(fine, archive[6]), rel=JETS)


def test_of_the_two_sides_of_a_wind_the_one_counts_that_needs_more(flight) -> None:
    """The jet is a head wind below and a tail wind above; alone each needs what it did."""
    height = np.linspace(0.0, 35e3, 71)
    hump = 40.0 * np.exp(-(((height - 6e3) / 1.5e3) ** 2))
    jet_ = 42.0 * np.exp(-(((height - 14e3) / 1.5e3) ** 2))
    low, high, both = (
        tv.availability(
            flight, one(tv.WindProfile(height=height, east=east, north=0.0 * east)),
            limit=1.0, **PITCH,
        ).lower[0]
        for east in (-hump, jet_, jet_ - hump)
    )  # fmt: skip
    assert low > high
    assert both == pytest.approx(low, rel=1e-3)


def test_the_part_of_a_known_archive_is_known(flight, archive) -> None:
    """Jets that differ by their strength alone: a limit between two of them parts them there."""
    for flown in (0, 7):
        weak, strong = archive[max(flown - 1, 0)], archive[flown]
        limit = 0.5 * size_says(flight, weak) + 0.5 * size_says(flight, strong) if flown else 1e-4
        part = tv.availability(flight, archive, limit=limit, **PITCH).fraction()

        assert (part.flown, part.judged, part.unknown) == (flown, 20, 0)
        assert part.bounds == (flown / 20, flown / 20)


@pytest.mark.thorough
def test_a_placard_is_the_limit_with_which_so_many_fly(flight, archive) -> None:
    result = tv.availability(flight, archive, limit=0.01, **PITCH)
    parts = np.array([0.05, 0.5, 0.9, 1.0])
    for part, limit in zip(parts, result.placard(parts), strict=True):
        assert result.with_limit(limit).fraction().fraction >= part
        assert result.with_limit(limit * (1 - 1e-9)).fraction().fraction < part
    assert [p.fraction for p in result.curve(result.placard(parts))] == parts.tolist()


def test_a_balloon_that_burst_below_the_jet_is_unknown_and_not_calm(flight, archive) -> None:
    burst = archive[11].between(0.0, 5.9e3)
    both = tv.winds.Soundings.from_profiles([*archive, burst], days("2023-02-01T00", 21))
    result = tv.availability(flight, both, limit=np.radians(0.3), **PITCH)

    assert size_says(flight, burst) < np.radians(0.2) < np.radians(0.3) < result.lower[11]
    assert np.isnan(result.flies[20])
    assert result.why[20] == "its wind is not known far enough"
    assert result.fraction().unknown == 1
    below, above = result.fraction().bounds
    assert below < result.fraction().fraction < above
    assert result.today(burst).go is None
    # where even the strongest wind does not matter, it is known again
    assert result.with_limit(np.radians(20.0)).fraction().unknown == 0


@pytest.mark.parametrize("top", [np.inf, 15e3, 11.5e3], ids=["above the end", "gap", "small gap"])
@pytest.mark.parametrize("speed", usual([-130.0, 120.0], 1))
def test_no_wind_where_none_was_measured_requires_more_than_the_upper_bound(
    flight, speed, top
) -> None:
    """Though no other sounding of the archive was so strong; `size` says what it requires."""
    height = np.arange(0.0, 35e3, 250.0)
    seen = (height <= 9e3) | (height >= top)
    whole, part = (
        tv.WindProfile(height=height[keep], east=east[keep], north=0.0 * height[keep])
        for east, keep in (
            (np.where(seen, 20.0, speed), np.ones(height.size, dtype=bool)),
            (np.full(height.size, 20.0), seen),
        )
    )
    required = size_says(flight, whole, pressure=True)
    options = {"limit": 0.9 * required, "azimuth": EAST, "plane": "pitch"}
    result = tv.availability(flight, one(part), **options)

    assert result.lower[0] < options["limit"] < required <= result.upper[0] * (1.0 + JETS)
    assert result.fraction().unknown == 1
    assert result.today(part).go is None


def test_what_ends_below_the_largest_dynamic_pressure_is_never_judged(archive) -> None:
    flight = tv.load_schedule("configuration-ii")
    low = archive[3].between(0.0, 8e3)
    result = tv.availability(flight, one(low), limit=1.0, **PITCH)

    assert result.why == ("the sounding ends below the height of the largest dynamic pressure",)
    high = archive[3].between(14e3, 30e3)
    result = tv.availability(flight, one(high), limit=1.0, **PITCH)
    assert result.why == ("the sounding begins above the height of the largest dynamic pressure",)
    assert np.isnan(result.fraction().fraction)
    assert str(result.fraction()) == "none judged, 1 unknown"
    assert np.all(np.isnan(result.placard()))


@pytest.mark.thorough
def test_old_balloons_that_end_at_16_km_are_judged_where_it_does_not_matter(
    flight, archive
) -> None:
    cut = [wind.between(0.0, 16e3) for wind in archive]
    old = tv.winds.Soundings.from_profiles(cut, archive.times)
    whole, computed = (
        tv.availability(flight, some, limit=np.radians(0.3), **PITCH) for some in (archive, old)
    )

    assert np.all(computed.lower <= computed.upper)
    assert np.all((computed.lower - CLOSE <= whole.lower) & (whole.lower <= computed.upper + CLOSE))
    # lost where they are lost below; flown where any wind above is survived
    assert np.array_equal(computed.flies, np.where(whole.flies == 0.0, 0.0, np.nan), equal_nan=True)
    flown = computed.with_limit(np.radians(0.56)).flies
    assert np.sum(flown == 1.0) > 10
    assert np.array_equal(flown == 1.0, computed.upper < np.radians(0.56))
    further = tv.availability(flight, old, limit=np.radians(0.3), known_to=20e3, **PITCH)
    assert set(further.why) == {"the sounding ends below known_to"}


def test_a_gap_of_kilometres_is_unknown_and_a_small_one_is_bridged(flight, archive) -> None:
    wind = archive[11]
    for low, high, known in ((9.1e3, 10.4e3, True), (9.1e3, 11.4e3, False)):
        keep = (wind.height <= low) | (wind.height >= high)
        gappy = tv.WindProfile(
            height=wind.height[keep], east=wind.east[keep], north=wind.north[keep]
        )
        result = tv.availability(flight, one(gappy), limit=1.0, **PITCH)
        assert (result.lower[0] == pytest.approx(result.upper[0], rel=1e-3)) == known
        assert any("in gaps of more than 2 km" in note for note in result.notes) != known
        result = result.with_limit(0.5 * (result.lower[0] + result.upper[0]) + 1e-6 * known)
        assert known == (result.fraction().unknown == 0)


@pytest.mark.parametrize("azimuth", [5e-324, 1e-308, 1e-160])
def test_a_cross_wind_whose_square_is_below_all_numbers_is_calm(flight, azimuth) -> None:
    height = np.arange(0.0, 49e3, 1e3)
    north = 40.0 * np.exp(-(((height - 12e3) / 5e3) ** 2))
    south = one(tv.WindProfile(height=height, east=0.0 * height, north=north))
    gust = tv.OneMinusCosineGust(peak=0.02, duration=2.0)
    calm, faint = (
        tv.availability(flight, south, limit=1.0, azimuth=x, plane="both", gust=gust).lower[0]
        for x in (0.0, azimuth)
    )
    assert faint == calm > 0.0


def test_heights_without_a_measurement_are_noted_with_the_wind_assumed_there(
    flight, archive
) -> None:
    """Of a balloon that reaches over all of the flight there is no note."""
    whole = archive[0]
    low = whole.between(float(whole.height[0]), 9e3)
    notes = {}
    for name, wind in (("whole", whole), ("low", low)):
        result = tv.availability(flight, one(wind), limit=1.0, **PITCH)
        notes[name] = [note for note in result.notes if "is not measured" in note]
    assert whole.height[-1] > flight.height[-1]
    assert notes["whole"] == []
    (note,) = notes["low"]
    assert note.startswith("the wind is not measured above 9 km: ")
    assert "130 m/s against the vehicle" in note


def test_a_calm_flies_with_no_limit_at_all(flight) -> None:
    height = np.linspace(0.0, 40e3, 21)
    calm = tv.WindProfile(height=height, east=0.0 * height, north=0.0 * height)
    result = tv.availability(flight, one(calm), limit=0.0, azimuth=EAST)

    assert result.lower == [0.0]
    assert result.fraction().flown == 1


@pytest.mark.parametrize("ground", [5.0, 300.0, 1400.0])
def test_ground_above_the_start_of_the_flight_changes_little(flight, archive, ground) -> None:
    """Below the first level the wind is not known either; there it is weak in this archive."""
    wind = archive[7]
    whole = tv.availability(flight, one(wind), limit=0.01, **PITCH)
    result = tv.availability(flight, one(wind.between(ground, 31e3)), limit=0.01, **PITCH)

    assert result.fraction().unknown == 0
    assert result.lower[0] == pytest.approx(whole.lower[0], rel=1e-3)


def test_both_planes_go_together_as_the_stop_is_round_or_square(flight, archive) -> None:
    wind = one(archive[8])
    pitch, yaw = (
        tv.availability(flight, wind, limit=1.0, azimuth=0.7, plane=plane, sign="frozen").lower[0]
        for plane in ("pitch", "yaw")
    )
    round_, square = (
        tv.availability(
            flight, wind, limit=1.0, azimuth=0.7, limit_shape=stop, sign="frozen"
        ).lower[0]
        for stop in ("round", "square")
    )

    assert round_ == pytest.approx(np.hypot(pitch, yaw), rel=1e-12)
    assert square == pytest.approx(max(pitch, yaw), rel=1e-12)
    assert yaw == pytest.approx(size_says(flight, wind[0], plane="yaw", azimuth=0.7), rel=JETS)


@pytest.mark.thorough
def test_several_azimuths_are_as_each_alone(flight, archive) -> None:
    azimuths = np.radians([40.0, 90.0, 100.0])
    result = tv.availability(flight, archive, limit=np.radians(0.4), azimuth=azimuths)
    for a, azimuth in enumerate(azimuths):
        single = tv.availability(flight, archive, limit=np.radians(0.4), azimuth=azimuth)
        assert np.array_equal(result.lower[a], single.lower)
        assert result.fraction()[a] == single.fraction()
        assert result.by_month()[2][a] == single.by_month()[2]
        assert np.array_equal(result.placard()[a], single.placard())


@pytest.mark.thorough
def test_a_gust_costs_what_it_costs_at_the_peak_of_the_wind_or_more(flight, archive) -> None:
    gust = tv.OneMinusCosineGust(peak=np.radians(0.5), duration=3.0)
    wind = archive[9]
    need = tv.availability(flight, one(wind), limit=1.0, gust=gust, **PITCH).lower[0]
    bare = tv.availability(flight, one(wind), limit=1.0, **PITCH).lower[0]
    # sixty-four straight lines are off by a part of (pi/64)^2/6 = 4e-4 of what the gust adds
    assert need >= size_says(flight, wind, gust) - 4e-4 * (need - bare)
    assert need > bare


@pytest.mark.thorough
def test_a_gust_by_its_speed_is_met_at_the_angle_of_its_time(flight, archive) -> None:
    gust, wind, speed = tv.OneMinusCosineGust(peak=0.01, duration=3.0), archive[9], 9.0
    options = {"limit": 1.0, "gust": gust, "gust_speed": speed}
    for plane in ("pitch", "yaw"):
        towards = EAST if plane == "pitch" else EAST + np.pi / 2
        where = {"plane": plane, "azimuth": towards, "sign": "frozen"}
        need = tv.availability(flight, one(wind), **options, **where).lower[0]
        bare = tv.availability(flight, one(wind), limit=1.0, **where).lower[0]
        each = size_says(flight, wind, GustOfSpeed(gust, speed, plane), plane, towards)
        assert need >= each - 4e-4 * (need - bare)
        assert need > bare


@pytest.mark.parametrize("sign", usual([-1.0, 1.0], 0))
def test_a_gust_by_its_speed_costs_what_a_sounding_with_it_costs_where_it_is_worst(
    flight, sign
) -> None:
    """Head and tail winds of 45 m/s with 9 m/s more for 3 s, in steps of a second."""
    height = np.arange(0.0, 34e3, 250.0)
    east = sign * 45.0 * np.exp(-(((height - 11e3) / 4e3) ** 2))
    where = {"limit": 1.0, "azimuth": EAST, "plane": "pitch"}
    gust = tv.OneMinusCosineGust(peak=0.01, duration=3.0)
    wind = tv.WindProfile(height=height, east=east, north=0.0 * height)
    need = tv.availability(flight, one(wind), gust=gust, gust_speed=9.0, **where).lower[0]
    needs = []
    for middle in np.arange(55.0, 65.0):
        own = np.interp(middle + np.linspace(-1.5, 1.5, 65), flight.times, flight.height)
        levels = np.unique(np.concatenate([height, own]))
        times = np.interp(levels, flight.height, flight.times)
        more = sign * 9.0 * gust(times - middle + 1.5) / 0.01
        gusty = np.interp(levels, height, east) + more
        with_it = tv.WindProfile(height=levels, east=gusty, north=0.0 * levels)
        needs.append(tv.availability(flight, one(with_it), **where).lower[0])
    # it is placed where trim reaches the need of the wind alone, not where it costs most
    assert 0.995 * max(needs) <= need <= max(needs) * (1.0 + 2e-3)


@pytest.mark.thorough
def test_where_the_speed_stays_a_gust_of_it_is_one_of_an_angle(archive) -> None:
    vehicle = tv.load_vehicle("configuration-i").replace(
        time=[40.0, 80.0], velocity=[500.0, 500.0], attitude=[1.0, 1.0]
    )
    even = tv.FlightSchedule(vehicle, altitude=[8e3, 25e3])
    for plane, across in (("pitch", np.sin(1.0)), ("yaw", 1.0)):
        gust = tv.OneMinusCosineGust(peak=np.arcsin(9.0 / 500.0 * across), duration=3.0)
        options = {"limit": 1.0, "azimuth": 0.7, "plane": plane, "sign": "frozen"}
        by_angle = tv.availability(even, archive, gust=gust, **options).lower
        other = gust * 0.3
        by_speed = tv.availability(even, archive, gust=other, gust_speed=9.0, **options).lower
        # an angle and its sine are not proportional: by a part of angle^2/6 of the gust
        assert by_speed == pytest.approx(by_angle, rel=(9.0 / 500.0) ** 2 / 6.0)


def test_the_speed_of_a_gust_needs_a_gust_and_is_no_zero(flight, archive) -> None:
    gust = tv.OneMinusCosineGust(peak=0.01, duration=3.0)
    with pytest.raises(tv.InputError, match="gust_speed is the speed of a gust"):
        tv.availability(flight, archive, limit=1.0, gust_speed=9.0, **PITCH)
    for speed in (0.0, -1000.1):
        with pytest.raises(tv.InputError, match="gust_speed must be"):
            tv.availability(flight, archive, limit=1.0, gust=gust, gust_speed=speed, **PITCH)


def test_a_gust_that_no_horizontal_wind_makes_is_not_judged() -> None:
    """A path 2 deg above the horizontal, which no head wind turns by 3 deg; a tail wind does."""
    vehicle = tv.load_vehicle("configuration-i").replace(
        time=[40.0, 80.0], velocity=[500.0, 500.0], attitude=np.radians([2.0, 2.0])
    )
    flat = tv.FlightSchedule(vehicle, altitude=[8e3, 8.7e3])
    height = np.arange(7e3, 10e3, 500.0)
    gust = tv.OneMinusCosineGust(peak=np.radians(3.0), duration=3.0)
    options = {"limit": 1.0, "azimuth": EAST, "plane": "pitch", "gust": gust}
    for east, known in ((-20.0, False), (20.0, True)):
        wind = tv.WindProfile(height=height, east=0.0 * height + east, north=0.0 * height)
        result = tv.availability(flat, one(wind), **options)
        assert np.isfinite(result.lower[0]) == known
        assert (result.why[0] == "") == known
        assert known or "no horizontal wind turns the flight so far" in result.why[0]


def test_nothing_is_judged_where_wind_and_gust_are_too_steep() -> None:
    vehicle = tv.load_vehicle("configuration-i").replace(
        time=[5.0, 60.0, 80.0], velocity=[10.0, 500.0, 700.0]
    )
    flight = tv.FlightSchedule(vehicle, altitude=[20.0, 12e3, 22e3])
    height = np.arange(0.0, 40e3, 100.0)
    steady = tv.WindProfile(height=height, east=np.full(400, 6.0), north=np.zeros(400))
    gust = tv.OneMinusCosineGust(peak=0.01, duration=3.0)
    result = tv.availability(flight, one(steady), limit=1.0, gust=gust, gust_speed=-9.0, **PITCH)
    calm = np.interp(2.0 * (6.0 + 9.0), flight.speed, flight.time)  # 30 deg: half of the speed
    # judged from the first level on, of which the flight meets one in less than half a second
    assert calm <= result.judged[0, 0] <= calm + 0.5


@pytest.mark.thorough
def test_persistence_is_an_angle_or_a_wind_against_the_vehicle(flight, archive) -> None:
    bare, angle, speed = (
        tv.availability(flight, archive, limit=np.radians(0.3), persistence=one_, **PITCH)
        for one_ in (None, 0.001, tv.ensembles.WindGrowth(speed=[5.0, 5.0], height=[0.0, 40e3]))
    )
    assert np.allclose(angle.lower, bare.lower + 0.001, rtol=1e-14, atol=0.0)
    for i in (3, 9):
        wind = archive[i]
        more = tv.WindProfile(height=wind.height, east=wind.east + 5.0, north=wind.north)
        assert speed.lower[i] == pytest.approx(size_says(flight, more), rel=JETS)
    assert angle.today(archive[3]).upper == pytest.approx(angle.upper[3], rel=1e-12)


@pytest.mark.thorough
def test_pairs_of_the_archive_say_how_needs_grow(flight, archive) -> None:
    """The jets grow by 5 m/s in 12 h, and needs nearly in proportion."""
    bare = tv.availability(flight, archive, limit=np.radians(0.3), **PITCH)
    grown = tv.availability(
        flight,
        archive,
        limit=np.radians(0.3),
        persistence=tv.ensembles.PairGrowth(1.5, 0.5),
        **PITCH,
    )
    expected = 0.5 * np.median(np.diff(bare.lower))  # (1.5/12)^(1/3) is a half

    assert grown.persistence[0] == pytest.approx(expected, rel=1e-12)
    assert any("19 pairs 12 h apart" in note for note in grown.notes)
    with pytest.raises(tv.InputError, match="needs soundings 12 h apart"):
        tv.availability(flight, archive[::2], limit=0.01, persistence="pairs", **PITCH)


def test_months_are_counted_by_local_time_and_empty_ones_are_not_there(flight) -> None:
    wind = profile(1)
    times = days("2024-02-28T12", 5)
    some = tv.winds.Soundings.from_profiles([wind] * 5, times)
    utc, cape = (
        tv.availability(flight, some, limit=1.0, utc_offset=hours, **PITCH).by_month()
        for hours in (None, -5.0)
    )

    assert {month: part.judged for month, part in utc.items()} == {2: 3, 3: 2}
    assert {month: part.judged for month, part in cape.items()} == {2: 4, 3: 1}


def test_what_cannot_be_used_is_unknown_with_its_reason(flight, tmp_path) -> None:
    good, bad = (
        Balloon(time, jet(v)) for time, v in (("2024-02-01T00", 40.0), ("2024-02-01T12", 400.0))
    )
    soundings = tv.read_soundings(write(tmp_path / "a-data.txt", [good, bad]))
    result = tv.availability(flight, soundings, limit=1.0, **PITCH)

    assert (result.fraction().flown, result.fraction().unknown) == (1, 1)
    assert "above 130" in result.why[1]


def test_a_wind_too_steep_at_the_largest_dynamic_pressure_is_unknown(flight) -> None:
    height = np.linspace(0.0, 40e3, 41)
    storm = tv.WindProfile(height=height, east=900.0 + 0.0 * height, north=0.0 * height)
    result = tv.availability(flight, one(storm), limit=1.0, azimuth=EAST)

    assert "more than 30 deg" in result.why[0]
    assert np.all(np.isnan(result.judged))
    assert result.today(storm).go is None


def test_where_a_wind_is_too_steep_the_rest_of_the_flight_is_judged(archive) -> None:
    """From a speed of 20 m/s on, the wind near the ground decides of which part it can be said."""
    booster = tv.load_vehicle("configuration-i")
    times, heights = [10.0, 60.0, 80.0], [100.0, 12e3, 22e3]
    slow = tv.FlightSchedule(
        booster.replace(time=times, velocity=[20.0, 500.0, 700.0]), altitude=heights
    )
    levels = np.arange(0.0, 41e3, 1000.0)
    winds = [
        tv.WindProfile(height=levels, east=np.where(levels > 0.0, 5.0, v), north=0.0 * levels)
        for v in (9.0, 15.0, 60.0)
    ]
    some = tv.winds.Soundings.from_profiles(winds, days("2023-02-01T00", 3))
    result = tv.availability(slow, some, limit=1.0, **PITCH)
    assert result.why == ("", "", "")
    assert result.judged[0].tolist() == [10.0, 80.0]
    # the wind is straight over height, and known at the levels: at the first of them it is weak
    first = float(np.interp(1000.0, heights, times))
    assert result.judged[1:, 0] == pytest.approx(first, rel=1e-12)
    assert result.judged_in_all == (pytest.approx(first, rel=1e-12), 80.0)
    (note,) = [one for one in result.notes if "30 deg" in one]
    assert "2 of 3 soundings" in note
    later = tv.availability(slow.between(first), some, limit=1.0, **PITCH)
    assert result.lower[1:] == pytest.approx(later.lower[1:], rel=STRAIGHT)
    assert result.today(winds[2]).judged == tuple(result.judged[2])


def test_a_schedule_without_altitude_is_refused(archive) -> None:
    booster = tv.load_vehicle("configuration-i")
    flight = tv.FlightSchedule(booster.replace(time=[60.0, 70.0]))
    with pytest.raises(tv.InputError, match="no altitude"):
        tv.availability(flight, archive, limit=0.01, azimuth=EAST)


@pytest.mark.parametrize(
    ("flown", "judged", "lower", "upper"), [(9, 17, 27.8, 77.0), (37, 50, 59.7, 85.4)]
)
def test_the_interval_of_independent_days_is_that_of_clopper_and_pearson(
    flown, judged, lower, upper
) -> None:
    flies = np.ones(judged)
    flies[2 * np.arange(judged - flown) + 1] = 0.0  # no two that are lost follow each other
    times = np.array(days("2024-01-01T00", judged), dtype="datetime64[m]")
    part = survival_fraction(flies, flies, times, np.ones(judged, dtype=int), 0.95)

    assert part.effective == judged
    assert [100 * part.lower, 100 * part.upper] == pytest.approx([lower, upper], abs=0.05)


def test_the_effective_number_is_that_of_a_process_with_memory() -> None:
    """Of x' = r x + noise it is n (1 - r)/(1 + r); estimates of so many vary by a few percent."""
    r, n = 0.8, 40_000
    rng = np.random.default_rng(7)
    noise = rng.normal(size=n)
    x = np.empty(n)
    x[0] = noise[0] / np.sqrt(1 - r**2)
    for i in range(1, n):
        x[i] = r * x[i - 1] + noise[i]
    times = np.array(days("1950-01-01T00", n), dtype="datetime64[m]")

    assert effective_number(x, times, np.ones(n, dtype=int)) == pytest.approx(n / 9, rel=0.1)
    assert effective_number(noise, times, np.ones(n, dtype=int)) == pytest.approx(n, rel=0.1)


def test_the_interval_holds_the_truth_where_days_are_alike() -> None:
    """Ten Februaries of two a day, of which one is like the next: 200 archives, 85 % or more."""
    from scipy.special import ndtri

    rng = np.random.default_rng(3)
    r, truth = 0.8, 0.85
    times = np.concatenate([days(f"{year}-02-01T00", 56) for year in range(2001, 2011)])
    times = times.astype("datetime64[m]")
    season = np.repeat(np.arange(10), 56)
    held = single = 0
    for _ in range(200):
        x = np.empty((10, 56))
        x[:, 0] = rng.normal(size=10)
        noise = np.sqrt(1 - r**2) * rng.normal(size=(10, 56))
        for i in range(1, 56):
            x[:, i] = r * x[:, i - 1] + noise[:, i]
        flies = (x < ndtri(truth)).astype(float).ravel()
        part = survival_fraction(flies, x.ravel(), times, season, 0.95)
        held += part.lower <= truth <= part.upper
        apart = survival_fraction(flies, x.ravel(), times, np.arange(560), 0.95)
        single += apart.lower <= truth <= apart.upper
    assert held >= 170
    assert single < held  # counted as independent


def test_no_flight_lost_and_none_flown_still_have_an_interval() -> None:
    times = np.array(days("2024-01-01T00", 50), dtype="datetime64[m]")
    need = np.sin(np.arange(50) / 5.0)
    ones = np.ones(50)
    for flies, ends in ((ones, (None, 1.0)), (0.0 * ones, (0.0, None))):
        part = survival_fraction(flies, need, times, ones.astype(int), 0.95)
        assert part.effective < 25
        assert ends[0] is None or part.lower == ends[0]
        assert ends[1] is None or part.upper == ends[1]
        end = 0.025 ** (1.0 / part.effective)  # so many of so many
        assert part.upper - part.lower == pytest.approx(1.0 - end, rel=1e-12)


@pytest.mark.thorough
def test_a_csv_and_a_dataset_hold_every_number(flight, archive, tmp_path) -> None:
    pytest.importorskip("xarray")
    result = tv.availability(
        flight, archive, limit=np.radians(0.4), azimuth=np.radians([60.0, 90.0])
    )
    rows = list(csv.DictReader(io.StringIO(result.to_csv(tmp_path / "all.csv"))))
    data = result.to_xarray()

    assert (tmp_path / "all.csv").read_text() == result.to_csv()
    needs = np.radians([float(row["lower_deg"]) for row in rows]).reshape(2, 20)
    assert np.allclose(needs, result.lower, rtol=1e-15, atol=0.0)
    assert np.array_equal(data["flies"], result.flies)
    assert np.array_equal(data["time"].values.astype("datetime64[m]"), archive.times)
    assert "Launch availability" in result._repr_html_()


def test_today_is_judged_as_the_archive_is(flight, archive) -> None:
    result = tv.availability(flight, archive, limit=np.radians(0.4), **PITCH)
    for i in (2, 18):
        said = result.today(archive[i])
        assert said.go == bool(result.flies[i])
        assert said.archive_fraction == pytest.approx(i / 20)


@pytest.mark.parametrize("plane", usual(["pitch", "yaw"], 0))
def test_even_steps_require_what_steps_between_all_levels_do(flight, plane) -> None:
    """Winds with independent changes of 20 m/s every 250 m: within the thousandth that is said."""
    height = np.arange(0.0, 40e3, 250.0)
    shape = np.exp(-(((height - 11e3) / 5e3) ** 2))
    motion = FlightMode(flight, "drift-exact", plane, flight.span)
    for seed in range(4):
        rng = np.random.default_rng(seed)
        east, north = (
            speed * shape + rng.normal(0.0, 20.0, height.size) * np.sqrt(shape)
            for speed in (40.0, 15.0)
        )
        wind = tv.WindProfile(height=height, east=east, north=north)
        where = {"azimuth": np.radians(80.0), "plane": plane}
        encountered = tv.fly_through(wind, flight, **where)
        steps = encountered_at_steps(
            motion, FlightWind(encountered.wind, plane, encountered.speeds)
        )
        equations = motion.at_steps(steps[0])
        paired = np.broadcast_to(equations.paired, steps[1].shape)
        winds = SteppedWinds(equations, *steps)
        between_levels = winds.curves().limit_of_trim_law(paired)[0]
        even = tv.availability(flight, one(wind), limit=1e-4, **where).lower
        assert even == pytest.approx(between_levels, rel=1e-3)
