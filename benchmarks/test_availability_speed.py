"""Ten thousand soundings, from a station file to the part of them that flies, in both planes."""

import resource
from time import process_time

import numpy as np
import pytest

import tvclin as tv
from tvclin.requirement.flight.flight_requirement import FlightMode
from tvclin.time_varying.requirements import SteppedWinds

SOUNDINGS = 10_000
LEVELS = 128


@pytest.fixture(scope="module")
def station(tmp_path_factory):
    """Write a made-up station file, two balloons a day, 68 MB."""
    rng = np.random.default_rng(1)
    heights = np.linspace(0, 32e3, LEVELS).astype(int)
    shape = 10.0 * np.exp(-(((heights - 11e3) / 4e3) ** 2))
    path = tmp_path_factory.mktemp("archive") / "ZZM00088801-data.txt"
    with path.open("w", encoding="utf-8") as file:
        for i in range(SOUNDINGS):
            time = np.datetime64("2005-01-01T00") + np.timedelta64(12 * i, "h")
            date = str(time)[:13].replace("-", " ").replace("T", " ")
            file.write(f"#ZZM00088801 {date} 9999 {LEVELS:4d} made-up  made-up   285000  -806000\n")
            speeds = np.abs(rng.normal(45, 15) * shape + rng.normal(0, 15, LEVELS)).astype(int)
            file.writelines(
                f"30 -9999  -9999 {h:5d} -9999 -9999 -9999 {255 + i % 30:5d} {v:5d} \n"
                for h, v in zip(heights.tolist(), speeds.tolist(), strict=True)
            )
    return path


def test_file_to_soundings_10000(benchmark, station):
    found = benchmark.pedantic(tv.read_soundings, (station,), rounds=1)
    assert len(found) == SOUNDINGS


def test_soundings_to_availability_10000_both_planes(benchmark, station):
    """Beside `size`, which integrates each wind by itself: processor time of one sounding."""
    flight, soundings = tv.load_schedule("configuration-i"), tv.read_soundings(station)
    azimuth = np.radians(80.0)

    def peer():
        for plane in ("pitch", "yaw"):
            met = tv.fly_through(soundings[0], flight, azimuth=azimuth, plane=plane)
            tv.size(flight, met, times=[60.0], dead_bands=1.0, varying=True, plane=plane)

    peer()
    start = process_time()
    peer()
    between = process_time()
    found = benchmark.pedantic(
        tv.availability,
        (flight, soundings),
        {"limit": np.radians(0.5), "azimuth": azimuth},
        rounds=1,
    )
    ours = (process_time() - between) / SOUNDINGS
    march = march_alone(flight)
    assert found.fraction().judged > 0.9 * SOUNDINGS
    benchmark.extra_info.update(
        peer="`size` with varying parameters",
        ours_seconds=ours,
        peer_seconds=between - start,
        ratio=(between - start) / ours,
        floor="the march of each wind; flights of trim near the limit",
    )
    benchmark.extra_info["over the march of a wind in both planes, steps of 0.1"] = ours / march
    benchmark.extra_info["largest memory, MB"] = (
        resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    )


def march_alone(flight):
    """Return the processor time [s] in which trim and demand of one wind are marched, twice."""
    motion = FlightMode(flight, "drift-exact", "pitch", flight.span)
    count = int(np.ceil((flight.span[1] - flight.span[0]) * motion.fastest[0] / 0.1))
    ends = np.linspace(*flight.span, count + 1)
    times = np.stack([ends[:-1], 0.5 * (ends[:-1] + ends[1:]), ends[1:]], axis=-1)[np.newaxis]
    wind = np.random.default_rng(0).normal(0.0, 0.05, (500, *times.shape[1:]))
    winds = SteppedWinds(motion.at_steps(times), times, wind, 1.0 + wind)
    winds.curves()
    start = process_time()
    winds.curves()
    return 2.0 * (process_time() - start) / len(wind)
