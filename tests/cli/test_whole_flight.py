"""Commands on a whole flight: the same numbers as Python, their exit codes, and bad input."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.whole_flight import TIMES, autopilot, flight, write_flight
from tvclin.cli.app import app
from tvclin.vehicle import Filter
from tvclin.winds.wind_angles import angles_from_vector_size


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with a flight, its structure, its gains and a study of it."""
    made = tmp_path_factory.mktemp("flight")
    write_flight(made)
    return made


def run(*words):
    """Return the result of a command."""
    return CliRunner().invoke(app, [f"{word}" for word in words], env={"COLUMNS": "80"})


def notched() -> tv.control.GainSchedule:
    """Return the autopilot of the study, made in Python."""
    low_pass = Filter.low_pass(40.0, 0.7)
    notches = tuple(
        tv.control.ModeNotch(mode=name, zero_damping=0.1, pole_damping=0.6)
        for name in ("first", "second")
    )
    return replace(autopilot(filters=(low_pass,), sample_rate=50.0), notches=notches)


def read(folder) -> tv.FlightSchedule:
    """Return the flight of the folder."""
    return tv.load_schedule(folder / "flight.csv")


def test_margins_of_a_flight_are_the_sweep_of_the_schedule_in_its_file(folder, tmp_path) -> None:
    file, csv = folder / "study.toml", tmp_path / "sweep.csv"
    result = run("margins", file, "--json", "--csv", csv)
    document = json.loads(result.stdout)
    swept = tv.control.sweep(read(folder), notched(), np.arange(30.0, 111.0, 20.0))
    for name in ("aero_margin_dB", "gain_increase_dB", "phase_margin_deg"):
        np.testing.assert_allclose(
            document["margins"][name], getattr(swept.margins, name), rtol=1e-9
        )
    assert document["satisfied"] == swept.satisfied.tolist() == [False, *4 * [True]]
    assert result.exit_code == 1
    assert len(csv.read_text(encoding="utf-8").splitlines()) == 6
    printed = run("margins", file).stdout
    assert printed.startswith("Criteria classic: NOT MET, gain may rise, second x 0.9: 4.41 dB at")
    assert max(map(len, printed.partition("Note")[0].splitlines()[1:])) <= 80
    answer = run("margins", file, "--set", "size.from_s", "50")
    assert (answer.exit_code, answer.stdout[:22]) == (0, "Criteria classic: MET ")


def test_one_time_of_the_flight_has_the_gains_and_notches_of_that_time(folder) -> None:
    document = json.loads(run("margins", folder / "study.toml", "--at", 60, "--json").stdout)
    made = read(folder)
    vehicle = made.at(60.0)
    plant = tv.FlexiblePlant.from_vehicle(vehicle.rigid, vehicle.structure)
    margins = notched().along(made, 60.0).margins(plant)
    got = document["margins"]["phase_margin_deg"]
    assert got == pytest.approx(margins.phase_margin_deg, rel=1e-9)


def test_options_take_the_place_of_the_schedule_and_a_rule_is_applied_at_each_time(folder) -> None:
    words = ("--natural-frequency", "1.1", "--delay-ms", "10", "--sample-rate", "50", "--json")
    words = (*words, "--set", "size.every_s", "20", "--set", "study.rigid", "true")
    document = json.loads(run("margins", folder / "flight.csv", *words).stdout)
    plain = flight(flexible=False)
    times = np.arange(30.0, 111.0, 20.0)
    made = tv.control.GainSchedule.design(
        times,
        plain.plants(times, "drift-exact", "pitch").coefficients,
        tv.design_gains,
        natural_frequency=1.1,
        damping=0.7,
        actuator=tv.Actuator(),
        delay=0.01,
        sample_rate=50.0,
    )
    assert document["modes"] == []
    swept = tv.control.sweep(plain, made, times)
    np.testing.assert_allclose(
        document["margins"]["phase_margin_deg"], swept.margins.phase_margin_deg, rtol=1e-9
    )


FILTERED = """
[size]
every_s = 20

[[autopilot.filter]]
kind = "low-pass"
damping = 0.7

[[autopilot.filter]]
kind = "low-pass"
on = "rate"
frequency_rad_per_s = 150.0

[[autopilot.filter]]
kind = "notch"
mode = "first"
zero_damping = 0.1

[[autopilot.filter]]
kind = "notch"
mode = "second"
zero_damping = 0.1
pole_damping = 0.6
"""


@pytest.fixture(scope="module")
def filtered(folder):
    """Return a study whose filters have columns over the flight, and its autopilot in Python."""
    law = autopilot().autopilot
    corner, width, ratio = (
        np.linspace(*ends, 5) for ends in ((10.0, 14.0), (0.4, 0.8), (0.95, 1.05))
    )
    columns = ("filter.1.frequency_Hz", "filter.3.pole_damping", "filter.first.ratio")
    rows = np.stack([TIMES, law.attitude_gain, law.rate_gain, corner, width, ratio], axis=-1)
    head = ",".join(("time_s", "attitude_gain", "rate_gain_s", *columns))
    np.savetxt(folder / "filtered.csv", rows, "%.17g", ",", header=head, comments="")
    text = (folder / "study.toml").read_text(encoding="utf-8").partition("[[autopilot.filter]]")[0]
    study = folder / "filtered.toml"
    study.write_text(text.replace("gains.csv", "filtered.csv") + FILTERED, encoding="utf-8")
    lags = (Filter.low_pass(2.0 * np.pi * corner, 0.7),)
    notch = tv.control.ModeNotch(mode="first", zero_damping=0.1, pole_damping=width, ratio=ratio)
    made = autopilot(filters=lags, rate_filters=(Filter.low_pass(150.0),), sample_rate=50.0)
    return study, replace(made, notches=(notch, notched().notches[1]))


@pytest.mark.thorough
def test_filters_with_columns_over_the_flight_are_those_of_python(folder, filtered) -> None:
    study, made = filtered
    document = json.loads(run("margins", study, "--json").stdout)
    swept = tv.control.sweep(read(folder), made, np.arange(30.0, 111.0, 20.0))
    got = document["margins"]["phase_margin_deg"]
    np.testing.assert_allclose(got, swept.margins.phase_margin_deg, rtol=1e-9)
    at_60 = json.loads(run("margins", study, "--at", 60, "--json").stdout)
    vehicle = read(folder).at(60.0)
    plant = tv.FlexiblePlant.from_vehicle(vehicle.rigid, vehicle.structure)
    margins = made.along(read(folder), 60.0).margins(plant)
    got = at_60["margins"]["phase_margin_deg"]
    assert got == pytest.approx(margins.phase_margin_deg, rel=1e-9)


@pytest.mark.parametrize(
    ("column", "message"),
    [
        (
            "filter.5.damping",
            "filter.5.damping must name a filter .*; 1, 2, 3, 4, first and second are known",
        ),
        ("filter.1.damping", "filter.1.damping is given twice; keep one"),
        ("filter.1.frequency", "filter 1 of the autopilot: frequency has no known unit"),
        ("filter.2.zero_damping", "filter 2 .*: a low-pass filter takes frequency, damping; got"),
        ("filter.1.corner_Hz", "unknown key in .*'corner_Hz'"),
        ("corner_Hz", "line 1: unknown key in a table of gains.*numbers of filters are filter.N.K"),
    ],
)
def test_a_column_of_no_filter_is_refused_in_one_sentence(
    folder, filtered, column, message
) -> None:
    text = (folder / "filtered.csv").read_text(encoding="utf-8")
    wrong = text.replace("filter.first.ratio", column, 1)
    (folder / "wrong.csv").write_text(wrong, encoding="utf-8")
    result = run("margins", filtered[0], "--set", "autopilot.schedule", "wrong.csv")
    assert (result.exit_code, result.stderr.count("Error")) == (2, 1), result.output
    assert re.search(message, " ".join(result.stderr.split())), result.stderr


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        ("time_s,attitude_gain\n30,1\n60,1\n", "needs attitude_gain and rate_gain_s, both"),
        ("attitude_gain,rate_gain_s\n1,1\n1,1\n", "needs one column of time_s, .*; got none"),
        ("time_s,mach,attitude_gain,rate_gain_s\n30,1,1,1\n", "got time, mach"),
        ("time_s,attitude_gain,rate_gain_s\n30,1,1\n30,1,1\n", "two or more values, which rise"),
        ("time_s,attitude_gain,rate_gain_s\n30,1,x\n", "line 2: rate_gain_s must be a number"),
        ("time_s,attitude_gain,rate_gain_s,yaw\n30,1,1,1\n", "unknown key in a table of gains"),
    ],
)
def test_a_wrong_table_of_gains_is_refused_in_one_sentence(folder, gains, message) -> None:
    (folder / "wrong.csv").write_text(gains, encoding="utf-8")
    result = run("margins", folder / "study.toml", "--set", "autopilot.schedule", "wrong.csv")
    assert result.exit_code == 2
    assert re.search(message, " ".join(result.stderr.split())), result.stderr


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--limit-deg", "3"), "--limit-deg needs a single flight time: --at TIME"),
        (("--set", "autopilot.attitude_gain", "0.5"), "gains or a rule for them, not both"),
        (("--set", "autopilot.filter.2.mode", "third"), "mode must be one of first, second"),
        (
            ("--set", "autopilot.schedule", "none", "--design", "least-nozzle"),
            "design least-nozzle is of one flight time",
        ),
        (("--set", "size.from_s", "10"), "size.from_s must be between 30 and 110; got 10 s"),
    ],
)
def test_what_a_sweep_cannot_take_is_refused(folder, words, message) -> None:
    result = run("margins", folder / "study.toml", *words)
    assert (result.exit_code, result.stderr.count("Error")) == (2, 1), result.output
    assert message in " ".join(result.stderr.split())


PULSE = ("--wind", "triangular", "--peak-deg", "4", "--duration", "8")


def at(time):
    """Return the options of one flight time [s]."""
    return ("--set", "size.from_s", time, "--set", "size.to_s", time)


def test_a_flight_through_a_pulse_is_that_of_python_with_its_exit_code(folder, tmp_path) -> None:
    csv = tmp_path / "flown.csv"
    result = run("fly", folder / "study.toml", *PULSE, *at(50), "--csv", csv, "--json")
    document = json.loads(result.stdout)
    wind = tv.TriangularWind(peak=np.radians(4.0), duration=8.0).shift(46.0)
    flown = tv.flights.fly_along(
        read(folder),
        notched(),
        wind,
        deflection_limit=np.radians(5.0),
        rate_limit=np.radians(20.0),
        start=46.0,
    )
    (flight_at_50,) = document["flights"]
    assert (result.exit_code, document["survived"]) == (0, True)
    deflection = flown.largest("deflection")
    assert flight_at_50["peak_deflection_deg"] == pytest.approx(
        abs(np.degrees(deflection.value)), rel=1e-9
    )
    assert flight_at_50["peak_time_s"] == pytest.approx(deflection.time, rel=1e-9)
    for name, largest in document["worst"].items():
        assert largest["value"] == pytest.approx(flown.largest(name).value, rel=1e-6), name
    assert len(csv.read_text(encoding="utf-8").splitlines()) == flown.times.size + 1


@pytest.mark.thorough
def test_a_pulse_is_flown_in_the_worse_of_head_and_tail_wind(folder) -> None:
    result = run("fly", folder / "study.toml", *PULSE, *at(50), "--json")
    ((worst,), notes) = (json.loads(result.stdout)[key] for key in ("flights", "notes"))
    wind = tv.TriangularWind(peak=np.radians(4.0), duration=8.0).shift(46.0)
    limits = {"deflection_limit": np.radians(5.0), "rate_limit": np.radians(20.0), "start": 46.0}
    peaks = {}
    for sign in ("head", "tail"):
        flown = tv.flights.fly_along(read(folder), notched(), wind, sign=sign, **limits)
        peaks[sign] = abs(np.degrees(flown.largest("deflection").value))
    assert worst["sign"] == max(peaks, key=peaks.get)
    assert worst["peak_deflection_deg"] == pytest.approx(max(peaks.values()), rel=1e-9)
    assert any(
        note.startswith("each pulse is flown as a head and as a tail wind") for note in notes
    )
    words = (*PULSE, *at(50), "--json", "--set", "study.sign", "tail")
    (tail,) = json.loads(run("fly", folder / "study.toml", *words).stdout)["flights"]
    assert tail["sign"] == "tail"
    assert tail["peak_deflection_deg"] == pytest.approx(peaks["tail"], rel=1e-9)


def test_a_limit_too_small_is_no_survival(folder) -> None:
    lost = run("fly", folder / "study.toml", *PULSE, *at(50), "--limit-deg", "0.15")
    assert (lost.exit_code, lost.stdout[:12]) == (1, "NOT SURVIVED")
    assert "until attitude or angle of attack exceed 30 deg" in " ".join(lost.output.split())


@pytest.mark.thorough
def write_sounding(file, speed, top=40000, distance=1000):
    """Write a jet of a speed [m/s] at 12 km, with levels up to `top` [m] at equal distances [m]."""
    heights = np.arange(0, top + 1, distance)
    east = np.interp(heights, [0, 5e3, 9e3, 12e3, 16e3, top], [0, 10, 35, speed, 20, 0])
    rows = [f"{h},{v},0" for h, v in zip(heights, east, strict=True)]
    text = "\n".join(["height_m,east_m_per_s,north_m_per_s", *rows, ""])
    file.write_text(text, encoding="utf-8")


@pytest.mark.thorough
def test_a_flight_through_gaps_of_a_sounding_is_not_known_to_survive(folder, tmp_path) -> None:
    """In one plane and in both; a limit too small stays so."""
    winds = tmp_path / "jet.csv"
    write_sounding(winds, 55, distance=3000)
    words = ("fly", folder / "study.toml", "--winds", winds, "--azimuth-deg", "80")
    for limit, survived in (("0.6", None), ("0.1", False)):
        for plane in ("pitch", "both"):
            shape = ("--set", "nozzle.limit_shape", "round") * (plane == "both")
            done = run(*words, "--limit-deg", limit, *shape, "--json")
            (flown,) = json.loads(done.stdout)["flights"]
            assert (done.exit_code, flown["survived"]) == (1, survived), (limit, plane)
            if survived is None:
                assert flown["reason"].startswith("the wind is not known from ")
    (tmp_path / "known").mkdir()
    write_sounding(tmp_path / "known" / "jet.csv", 55)
    known = run(*words[:3], tmp_path / "known" / "jet.csv", *words[4:], "--limit-deg", "0.6")
    assert (known.exit_code, known.stdout[:8]) == (0, "SURVIVED")


@pytest.mark.thorough
def test_a_sounding_that_is_calm_in_one_plane_is_flown_in_both(folder, tmp_path) -> None:
    """As in the other plane alone: the calm plane requires nothing."""
    winds = tmp_path / "jet.csv"
    write_sounding(winds, 55)
    flown = {}
    for name, keys in {"both": "nozzle.limit_shape=round", "pitch": "study.plane=pitch"}.items():
        options = ("--azimuth-deg", "90", "--limit-deg", "0.6", "--set", keys, "--json")
        done = run("fly", folder / "study.toml", "--winds", winds, *options)
        assert done.exit_code == 0, done.output
        (flown[name],) = json.loads(done.stdout)["flights"]
    for key in ("peak_deflection_deg", "peak_attitude_deg"):
        assert flown["both"][key] == pytest.approx(flown["pitch"][key], rel=1e-9)


@pytest.mark.thorough
def test_several_soundings_have_a_fraction_and_a_row_each(folder) -> None:
    archive = folder / "soundings"
    archive.mkdir(exist_ok=True)
    for day, speed in (("01", 55), ("02", 95)):
        write_sounding(archive / f"2024-01-{day}T00.csv", speed)
    words = ("--winds", archive, "--azimuth-deg", "90", "--limit-deg", "0.4")
    result = run("fly", folder / "study.toml", *words)
    assert result.exit_code == 1
    printed = " ".join(result.stdout.split())
    assert printed.startswith("NOT SURVIVED with 0.400 deg in 1 of 2 winds: 2024-01-02T00,")
    assert "; 1 of 2 winds survived, 50.00 % (2.53 to 97.47 %, two-sided 90 %)" in printed
    assert max(map(len, result.output.partition("study.toml")[2].splitlines()[1:10])) <= 80


@pytest.mark.thorough
def test_dispersed_vehicles_fly_along_the_flight_in_drawn_soundings(folder, tmp_path) -> None:
    days = (("01", 55, 40000), ("02", 95, 40000), ("03", 55, 18000), ("04", 55, 40000, 3000))
    for day, *jet in days:  # the last has gaps
        write_sounding(tmp_path / f"2024-01-{day}T00.csv", *jet)
    study = folder / "dispersed.toml"
    text = (folder / "study.toml").read_text(encoding="utf-8")
    further = '[campaign]\nalong = true\nmethod = "latin"\n'  # which draws each sounding once
    further += '[[dispersion]]\nparameter = "thrust"\npercent = 0.1\n'
    study.write_text(
        text.replace("[nozzle]", f"time_s = 60\n\n{further}\n[nozzle]"), encoding="utf-8"
    )
    words = ("--azimuth-deg", "90", "--limit-deg", "0.6")
    csv = folder / "cases.txt"
    done = run("disperse", study, "--winds", tmp_path, *words, "--cases", "4", "--csv", csv)
    assert (done.exit_code, "in each wind" in done.output) == (1, True), done.output
    survived = {True: "1.0", False: "0.0", None: "nan"}
    flown = json.loads(
        run("fly", folder / "study.toml", "--winds", tmp_path, *words, "--json").stdout
    )
    expected = [survived[flight["survived"]] for flight in flown["flights"]]
    assert expected == ["1.0", "0.0", "nan", "nan"]
    cases = [line.split(",") for line in csv.read_text(encoding="utf-8").splitlines()[1:]]
    assert {int(case[2]) for case in cases} == {0, 1, 2, 3}
    assert all((case[3] or "nan") == expected[int(case[2])] for case in cases)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--set", "nozzle.limit_deg", "none"), "needs the deflection limit: --limit-deg"),
        (("--law", "trim", "--limit-deg", "1"), "--law needs a single flight time: --at TIME"),
        (("--engine", "planar"), "--engine needs a single flight time: --at TIME"),
        (("--dead-band", "1"), "--dead-band needs a single flight time"),
        (("--winds", "no-such.csv"), "--winds needs --azimuth-deg"),
        (
            ("--set", "nozzle.limit_shape", "round", *PULSE),
            "both planes need a wind with a direction",
        ),
    ],
)
def test_what_a_flight_of_the_loop_cannot_take_is_refused(folder, words, message) -> None:
    result = run("fly", folder / "study.toml", *words)
    assert (result.exit_code, result.stderr.count("Error")) == (2, 1), result.output
    assert message in " ".join(result.stderr.split())


@pytest.mark.thorough
def test_ascent_lists_required_used_and_remaining_deflection_of_the_flown_autopilot(folder) -> None:
    words = ("--from", "50", "--to", "70", "--every", "20")
    result = run("ascent", folder / "study.toml", *PULSE, *words, "--json")
    document = json.loads(result.stdout)
    use = document["deflection_use"]
    wind = tv.TriangularWind(peak=np.radians(4.0), duration=8.0)
    used = []
    for time in (50.0, 70.0):
        flown = tv.flights.fly_along(
            read(folder),
            notched(),
            wind.shift(time - 4.0),
            deflection_limit=np.radians(5.0),
            rate_limit=np.radians(20.0),
            start=time - 4.0,
        )
        used.append(abs(np.degrees(flown.largest("deflection").value)))
    required = np.ravel(document["required_deg"]["K = 1, varying, head wind"])
    np.testing.assert_allclose(use["used_deg"], used, rtol=1e-9)
    np.testing.assert_allclose(use["remaining_deg"], 5.0 - np.maximum(required, used), rtol=1e-9)
    assert result.exit_code == 0
    lost = run("ascent", folder / "study.toml", *PULSE, *words, "--limit-deg", "0.31")
    printed = " ".join(lost.output.split())
    assert lost.exit_code == 1
    # the bound of a frozen vehicle is none along the flight
    assert "no forecast" not in lost.output.partition("Note")[0]
    assert printed.startswith("Limit 0.310 deg: budget SUFFICIENT, 0.015 deg"), printed
    assert "remaining; autopilot NOT SURVIVED in 1 of 2 flights; " in printed
    assert "flown by the autopilot: NOT SURVIVED" in printed


def in_both_planes(**keys):
    """Return the words of a pulse with a direction, flown in both planes."""
    keys = {"shape": "triangular", "peak_deg": 4, "duration_s": 8, "direction_deg": 250} | keys
    both = [word for key, value in keys.items() for word in ("--set", f"wind.{key}", value)]
    return ("--azimuth-deg", "90", *both)


@pytest.mark.thorough
def test_ascent_and_fly_in_both_planes_are_of_the_autopilot_flown_in_both(folder) -> None:
    """The same flights in Python: the vector of 4 deg by its direction at each flight time."""
    words = ("--from", 50, "--to", 50, "--plane", "both", *in_both_planes(), "--json")
    result = run("ascent", folder / "study.toml", *words)
    document, made = json.loads(result.stdout), read(folder)
    at_50 = made.at(50.0).rigid
    angles = angles_from_vector_size(np.radians(4.0), np.radians(160.0), at_50.attitude)
    pulse = tv.TriangularWind(peak=1.0, duration=8.0).shift(46.0)
    pitch, yaw = (pulse * float(angle) for angle in angles)
    wind = tv.winds.PlaneWind(pitch=pitch, yaw=yaw)
    options = {"rate_limit": np.radians(20.0), "start": 46.0}
    flown = tv.flights.fly_planes_along(
        made, notched(), wind, deflection_limit=np.radians(5.0), **options
    )
    largest = np.degrees(flown.largest("deflection").value)
    assert document["verdict"]["autopilot"] == "SURVIVED in 1 wind"
    assert document["deflection_use"]["used_deg"] == pytest.approx([largest], rel=1e-9)
    assert (result.exit_code, document["verdict"]["satisfied"]) == (0, True)
    words = (*at(50), "--set", "nozzle.limit_shape", "round", *in_both_planes())
    small = run("fly", folder / "study.toml", *words, "--limit-deg", 0.2, "--json")
    document = json.loads(small.stdout)
    expected = tv.flights.fly_planes_along(
        made, notched(), wind, deflection_limit=np.radians(0.2), **options
    )
    assert (small.exit_code, document["survived"], document["plane"]) == (1, False, "both")
    assert document["flights"][0]["status"] == expected.status == "lost"
    assert "angles are magnitudes of the vectors of both planes" in " ".join(document["notes"])


@pytest.mark.thorough
def test_the_autopilot_is_flown_at_a_single_flight_time(folder) -> None:
    words = (*PULSE, "--from", "60", "--to", "60", "--json")
    single = json.loads(run("ascent", folder / "study.toml", *words).stdout)
    assert single["verdict"]["autopilot"] == "SURVIVED in 1 wind"


@pytest.mark.thorough
def test_a_pulse_at_the_end_of_the_flight_settles_on_the_vehicle_of_its_end(folder) -> None:
    late = run("fly", folder / "study.toml", *PULSE, *at(109), "--json")
    document = json.loads(late.stdout)
    assert (late.exit_code, document["survived"]) == (0, True), late.output


def test_the_duty_of_a_flight_without_a_name_has_that_of_its_file(folder) -> None:
    words = ("--from", "60", "--to", "60", "--limit-deg", "5")
    result = run("nozzle", folder / "plain.csv", *PULSE, *words)
    assert "plain.csv, pitch, trim flown" in result.stdout


@pytest.mark.thorough
def test_the_page_of_a_study_has_the_autopilot_over_the_flight(folder, tmp_path) -> None:
    text = (folder / "study.toml").read_text(encoding="utf-8")
    text = text.replace("[study]", "[study]\ntime_s = 60").replace(
        "every_s = 20", "every_s = 20\nfrom_s = 50\nto_s = 70"
    )
    wind = '[wind]\nshape = "triangular"\npeak_deg = 4\nduration_s = 8\n'
    (folder / "at-60.toml").write_text(f"{text}\n{wind}", encoding="utf-8")
    page = tmp_path / "page.html"
    result = run("report", folder / "at-60.toml", "-o", page)
    assert result.exit_code == 0, result.output
    html = page.read_text(encoding="utf-8")
    section = html[html.index('<section id="loop"') :].partition("</section>")[0]
    assert "Criteria classic: MET at 2 flight times." in section
    assert "SURVIVED with 5.000 deg in 2 flights" in section
    assert section.count("<figure>") == 2
    assert "margins over the flight" in html
    assert "autopilot along the flight" in html


@pytest.mark.thorough
def test_a_table_of_gains_that_ends_within_the_flight_is_noted(folder) -> None:
    gains = folder / "short.csv"
    gains.write_text("time_s,attitude_gain,rate_gain_s\n30,0.4,0.5\n70,0.5,0.6\n")
    flight = ("margins", folder / "study.toml", "--set", "autopilot.schedule", gains, "--more")
    noted = " ".join(run(*flight).stdout.split())
    assert "gains are given for time 30 to 70 s and constant beyond, at 2 of 5 flight" in noted
    assert "gains are given for" not in run("margins", folder / "study.toml", "--more").stdout


@pytest.mark.thorough
def test_a_table_of_some_flight_times_says_of_how_many(folder) -> None:
    every = ("--set", "size.every_s", "3.5")
    swept = " ".join(run("margins", folder / "study.toml", *every).stdout.split())
    which = r"(\d+) of 24: 20 about evenly, and the worst of each margin"
    count = int(re.search(rf"margins by flight time, {which}", " ".join(swept.split()))[1])
    assert 20 <= count < 24
    assert "margins by flight time, " not in run("margins", folder / "study.toml").stdout


def test_a_notch_at_a_mode_of_a_rigid_vehicle_has_no_mode(folder) -> None:
    result = run("margins", folder / "study.toml", "--set", "study.rigid", "true")
    assert result.exit_code == 2
    assert "a notch at first has no mode" in result.stderr


def test_gains_of_the_file_are_flown_by_the_autopilot(tmp_path) -> None:
    study = tmp_path / "study.toml"
    study.write_text(
        '[study]\nvehicle = "configuration-i"\n[wind]\npeak_deg = 5\nduration_s = 7.5\n'
        "[nozzle]\nlimit_deg = 1\n[autopilot]\nattitude_gain = 0.4\nrate_gain_s = 0.5\n"
    )
    assert "law autopilot" in run("fly", study).stdout
    assert "law report" in run("fly", study, "--law", "report").stdout
    assert "law report" in run("fly", study, "--engine", "planar").stdout


@pytest.mark.thorough
def test_the_headline_names_the_planes_that_are_judged() -> None:
    headline = run("ascent", "configuration-i", "--every", "40").stdout.partition("\n\n")[0]
    assert "pitch alone judged (--plane both judges both)" in " ".join(headline.split())


@pytest.mark.thorough
def test_a_flight_that_survives_an_unstable_mode_says_at_which_times_it_is_unstable(folder) -> None:
    """With a shallower notch the first mode is unstable at 30 s, by the eigenvalues there."""
    file = folder / "shallow.toml"
    study = (folder / "study.toml").read_text()
    file.write_text(study.replace("zero_damping = 0.1", "zero_damping = 0.3"))
    answer = json.loads(run("fly", file, "--limit-deg", "3", "--json").stdout)
    assert answer["verdict"].startswith("SURVIVED")
    notes = " ".join(answer["notes"])
    assert "frozen at 30 s the loop has an unstable oscillation" in notes
    shallow = tuple(replace(notch, zero_damping=0.3) for notch in notched().notches)
    vehicle = read(folder).at(30.0)
    plant = tv.FlexiblePlant.from_vehicle(vehicle.rigid, vehicle.structure)
    loop = replace(notched(), notches=shallow).along(read(folder), 30.0)
    assert not loop.margins(plant).stable
    stable = json.loads(run("fly", folder / "study.toml", "--limit-deg", "3", "--json").stdout)
    assert "unstable oscillation" not in " ".join(stable["notes"])


def test_the_duty_over_a_flight_is_of_the_autopilot_of_its_file(folder) -> None:
    """At 50 s that is its table's row of 50 s, not the gains of the time of the vehicle."""
    head, *rows = (folder / "gains.csv").read_text().split()
    (row,) = (row for row in rows if row.startswith("50.0,"))
    gains = row.removeprefix("50.0,")
    (folder / "constant.csv").write_text(f"{head}\n30,{gains}\n110,{gains}\n")
    given = ("nozzle", folder / "study.toml", "--over", "flight", "--from", 50, "--to", 50)
    varying = json.loads(run(*given, "--json").stdout)
    constant = ("--set", "autopilot.schedule", folder / "constant.csv")
    same = json.loads(run(*given, *constant, "--json").stdout)
    assert varying["law"] == same["law"] == "autopilot"
    assert varying["largest"] == pytest.approx(same["largest"], rel=1e-9)
    assert json.loads(run(*given, "--law", "trim", "--json").stdout)["law"] == "trim"
