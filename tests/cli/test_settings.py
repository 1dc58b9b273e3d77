"""--set KEY VALUE: the plan of a study file that has the key, in every command with a case."""

import json
import re
import tomllib
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import tvclin as tv
from tvclin.ascent.schedule_file import FLIGHT_COLUMNS
from tvclin.base.errors import InputError
from tvclin.base.lines import text
from tvclin.cli.app import app
from tvclin.cli.settings import _completed
from tvclin.control.autopilot.gain_table import load_gains
from tvclin.control.laws.registry import LAWS
from tvclin.design.standard_trials import WINDS
from tvclin.ensembles.campaign.campaign_plan import OUTPUTS
from tvclin.ensembles.dispersions import METHODS
from tvclin.studyfile.campaign_file import load_campaign
from tvclin.studyfile.keys import all_keys, column_tables
from tvclin.studyfile.read import example, load_sizing
from tvclin.studyfile.settings import STUDY_TABLES, VEHICLE_TABLES, with_settings
from tvclin.winds.soundings.sounding_files import READERS

V, BENDS = "configuration-i", "made-up-booster"
SOUNDING = Path(__file__).parents[1] / "soundings" / "wyoming.txt"
STUDY = """
[study]
vehicle = "configuration-i"
[wind]
shape = "triangular"
peak_deg = 5.0
duration_s = 7.5
"""


def ran(*arguments):
    result = CliRunner().invoke(app, arguments)
    return result.exit_code, result.stdout, result.stderr


def study_of(tmp_path, more="", text=STUDY):
    file = tmp_path / "study.toml"
    file.write_text(text + more)
    return str(file)


def same(plan, other):
    """Whether two plans are equal, their vehicles by their numbers."""

    def plain(p):
        return {k: repr(v) for k, v in vars(p).items() if k not in ("vehicle", "plant", "sizing")}

    return plain(plan) == plain(other) and repr(plan.vehicle) == repr(other.vehicle)


@pytest.mark.parametrize(
    ("settings", "more"),
    [
        ([("autopilot.rate_gain_s", "0.8"), ("autopilot.attitude_gain", "1")],
         "[autopilot]\nrate_gain_s = 0.8\nattitude_gain = 1"),
        ([("nozzle.limit_deg", "0.5"), ("nozzle.rate_limit_deg_per_s", "5")],
         "[nozzle]\nlimit_deg = 0.5\nrate_limit_deg_per_s = 5"),
        ([("gust.peak_deg", "1"), ("gust.duration_s", "2")],
         "[gust]\npeak_deg = 1\nduration_s = 2"),
        ([("laws.names", "trim,dead-band")], '[laws]\nnames = ["trim", "dead-band"]'),
        ([("laws.names", '["trim"]')], '[laws]\nnames = ["trim"]'),
        ([("criteria.name", "aircraft"), ("criteria.disk_margin", ".5")],
         '[criteria]\nname = "aircraft"\ndisk_margin = 0.5'),
        ([("criteria.phase_margin_deg", "35")], "[criteria]\nphase_margin_deg = 35"),
        ([("document.revision", "3")], '[document]\nrevision = "3"'),
        ([("dispersion.thrust.percent", "4")],
         '[[dispersion]]\nparameter = "thrust"\npercent = 4'),
        ([("autopilot.filter.1.kind", "low-pass"), ("autopilot.filter.1.frequency_Hz", "9")],
         '[[autopilot.filter]]\nkind = "low-pass"\nfrequency_Hz = 9'),
        ([("question.confidence", "0.95")], "[question]\nconfidence = 0.95"),
    ],
)  # fmt: skip
def test_a_key_that_is_set_is_that_of_the_file(settings, more, tmp_path):
    wanted = tv.load_study(study_of(tmp_path, more))
    assert same(tv.load_study(with_settings(V, settings)), wanted)
    assert same(tv.load_study(with_settings(study_of(tmp_path), settings)), wanted)


def test_another_spelling_of_the_quantity_is_replaced_and_none_takes_it_out(tmp_path):
    file = study_of(tmp_path, "[autopilot]\ndesign = 'lqr'\ndelay_ms = 30")
    plan = tv.load_study(with_settings(file, [("wind.peak_rad", "0.1")]))
    assert plan.wind.peak == 0.1
    plan = tv.load_study(with_settings(file, [("wind.peak_speed_m_per_s", "30")]))
    assert plan.wind.speed == 30.0
    plan = tv.load_study(with_settings(file, [("autopilot.rate_gain_s", "2")]))
    assert (plan.design.design, plan.design.rate_gain, plan.design.delay) == (None, 2.0, 0.03)
    plan = tv.load_study(with_settings(file, [("autopilot.delay_s", "none")]))
    assert (plan.design.design, plan.design.delay) == ("lqr", 0.0)
    assert tv.load_study(with_settings(file, [("autopilot", "none")])).design is None


def test_rows_of_lists_have_numbers_and_names(tmp_path):
    text = example().replace("# [[wind]]                   # measured", "# ", 1)
    file = study_of(tmp_path, text=text)
    before = {d.parameter: d for d in tv.load_study(file).dispersions.distributions}
    plan = tv.load_study(
        with_settings(
            file,
            [
                ("dispersion.thrust.percent", "3"),
                ("dispersion.2.percent", "7"),
                ("dispersion.wind_duration", "none"),
                ("wind.2.peak_deg", "2"),
                ("wind.2.duration_s", "3"),
                ("wind.1.shape", "rectangular"),
            ],
        )
    )
    after = {d.parameter: d for d in plan.dispersions.distributions}
    assert (after["thrust"].spread, after["moment_of_inertia"].spread) == (0.03, 0.07)
    assert before.keys() - after.keys() == {"wind_duration"}
    assert plan.wind.shape == "rectangular"
    assert [np.degrees(other.peak) for other in plan.sizing.others] == [pytest.approx(2.0)]


@pytest.mark.parametrize("flight", [False, True])
def test_a_vehicle_is_changed_wherever_it_is_read(flight, tmp_path):
    settings = [("vehicle.thrust_N", "3e6")]
    more = '[schedule]\nsource = "configuration-i"' if flight else ""
    for source in (V, study_of(tmp_path, more)):
        edited = with_settings(source, settings)
        assert tv.load_study(edited).vehicle.thrust == 3e6
        if flight or source == V:
            plan = load_sizing(edited)
            assert plan.sizing.schedule.at(66.0).thrust == pytest.approx(3e6)
    edited = with_settings(BENDS, [("bending.1.damping", "0.02"), ("nozzle.limit_deg", "1")])
    assert tv.load_study(edited).vehicle.structure.bending[0].damping == 0.02


def test_a_vehicle_with_keys_has_its_flight():
    plan = load_sizing(with_settings(V, [("size.every_s", "20"), ("wind.peak_deg", "4")]))
    bare = load_sizing(V)
    assert plan.sizing.every == 20.0
    assert plan.wind.peak == pytest.approx(np.radians(4.0))
    assert plan.sizing.schedule.span == bare.sizing.schedule.span


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("autopilot.rate_gian_s", "1", "did you mean rate_gain_s"),
        ("autopilto.rate_gain_s", "1", "did you mean autopilot"),
        ("rate_gain_s", "1", "needs its table: autopilot.rate_gain_s"),
        ("wind.peak", "1", "write peak_rad or peak_deg"),
        ("wind.3.peak_deg", "1", "the file has 1 of [[wind]]"),
        ("vehicle.trust_N", "1", "did you mean thrust_N"),
        ("study.model", "drfit", "did you mean 'drift'"),
        ("nozzle.limit_deg", "much", "must be a number"),
        ("laws.names", "[", "no value of a TOML file"),
        ("wind", "5", "write wind.KEY"),
        ("wind..peak_deg", "5", "such as autopilot.rate_gain_s"),
        ("nozzle.limit_deg.deg", "5", "limit_deg.deg are several"),
        ("autopilot.rate_gain", "1", "rate_gain: rate_gain has no known unit"),
        ("autopilot.rate_gian_s", "1", "did you mean rate_gain_s or attitude_gain?"),
        ("vehicle.thrust_kN", "abc", "Error: --set vehicle.thrust_kN: thrust_kN must be a number"),
        ("vehicle.thrust_kN", "-1", "Error: --set vehicle.thrust_kN: thrust must be positive"),
        ("wind.peak_rad", "6", "Error: --set wind.peak_rad: peak must be a wind angle within"),
        ("wind.peak_deg", "none", "Error: --set wind.peak_deg: [wind] needs its peak"),
        (
            "wind.sounding",
            "x.csv",
            "Error: --set wind.sounding: a key is missing in [[wind]]: azimuth_rad or azimuth_deg",
        ),
        (
            "gust.peak_deg",
            "3",
            "Error: --set gust.peak_deg: a key is missing in [gust]: duration_s",
        ),
        ("gust.peak_deg", "x", "Error: --set gust.peak_deg: peak_deg must be a number"),
    ],
)
def test_a_key_that_is_wrong_is_said_in_one_sentence(key, value, said):
    code, _, error = ran("margins", V, "--set", key, value)
    assert code == 2
    assert said in error
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("study", "--limit", "3"), "did you mean --limit-deg?"),
        (("study", "--time", "60"), "tvclin study takes no --time: did you mean --at?"),
        (("ascent", "--at", "60"), "tvclin ascent takes no --at: --from TIME --to TIME gives one"),
        (("study", "--kp", "1"), "tvclin study takes no --kp: did you mean --attitude-gain?"),
        (("fly", "--kd", "1"), "tvclin fly takes no --kd: did you mean --rate-gain?"),
        (("study", "--plane", "both"), "--plane must be one of pitch, yaw; tvclin study judges"),
        (("study", "--shape", "triangular"), "takes no --shape: did you mean --wind?"),
        (("study", "--gust", "3"), "Error: --gust takes 2 values, DEG S"),
        (("study", "--gust", "3deg", "2s"), "Error: --gust takes 2 values, DEG S"),
        (("margins", "--delay", "0.05"), "did you mean --delay-ms?"),
        (("fly", "--rate-limit-deg", "5"), "--set nozzle.rate_limit_deg_per_s VALUE gives it"),
        (("nozzle", "--rate-gain", "5"), "--set autopilot.rate_gain_s VALUE gives it"),
        (
            ("design", "--box", "thrust_kN=200..180"),
            "--box must have a smaller and a larger value",
        ),
        (("disperse", "--seed", "4"), "tvclin disperse takes no --seed: --set campaign.seed VALUE"),
        (("fly", "--duration", "7.5s"), "Error: --duration must be a number"),
        (
            ("study", "--winds", "x.csv", "--azimuth-deg", "60"),
            "tvclin ascent VEHICLE --winds FILE --azimuth-deg DEG answers for a sounding",
        ),
        (("nozzle", "--delay-ms", "5"), "--set autopilot.delay_ms VALUE gives it"),
        (("nozzle", "--sample-rate", "5"), "--set autopilot.sample_rate_Hz VALUE gives it"),
        (("ascent", "--limit-shape", "round"), "--set nozzle.limit_shape VALUE gives it"),
    ],
)
def test_an_option_that_is_wrong_is_answered_with_what_is_right(arguments, said):
    code, _, error = ran(arguments[0], V, *arguments[1:])
    assert code == 2
    assert said in error


def test_gains_that_lack_one_are_said_by_keys_where_keys_gave_them():
    error = ran("margins", V, "--set", "autopilot.rate_gain_s", "0.8")[2]
    assert "need --set autopilot.attitude_gain and --set autopilot.rate_gain_s, both" in error


@pytest.mark.thorough
def test_a_sounding_that_is_set_is_the_wind_in_place_of_the_pulse():
    sounding = ("--set", "wind.sounding", str(SOUNDING), "--azimuth-deg", "30")
    by_key = ran("respond", V, *sounding, "--limit-deg", "3", "--json")
    option = ("--winds", str(SOUNDING), "--azimuth-deg", "30")
    assert by_key[0] == 0
    assert by_key[:2] == ran("respond", V, *option, "--limit-deg", "3", "--json")[:2]
    error = ran("study", V, *sounding)[2]
    assert "a study needs a wind of one shape, a [wind] with a peak and no sounding" in error


def test_keys_that_exclude_each_other_are_refused():
    for pair in (
        [("wind.peak_deg", "4"), ("wind.peak_speed_m_per_s", "3")],
        [("autopilot.design", "lqr"), ("autopilot.rate_gain_s", "3")],
        [("wind.peak_deg", "4"), ("wind.sounding", "wind.csv")],
        [("gust.peak_deg", "4"), ("gust", "none")],
    ):
        first, second = (key for key, _ in pair)
        # a third key, which excludes neither, is not blamed
        with pytest.raises(InputError, match=f"{first} and {second} exclude each other"):
            with_settings(V, [*pair, ("nozzle.limit_deg", "5")])
    with pytest.raises(InputError, match="given twice"):
        with_settings(V, [("wind.peak_deg", "4"), ("wind.peak_deg", "5")])


@pytest.mark.parametrize(
    ("command", "option", "key"),
    [
        ("study", ("--peak-speed", "20"), ("wind.peak_deg", "6")),
        ("study", ("--dead-band", "0.5"), ("study.dead_band", "0.4")),
        ("study", ("--limit-deg", "1"), ("nozzle.limit_rad", "0.01")),
        ("margins", ("--rate-gain", "1"), ("autopilot.rate_gain_s", "2")),
        ("margins", ("--delay-ms", "1"), ("autopilot.delay_s", "2")),
        ("ascent", ("--every", "20"), ("size.every_s", "10")),
        ("margins", ("--natural-frequency", "1"), ("autopilot.rate_gain_s", "2")),
        ("margins", ("--attitude-gain", "1"), ("autopilot.design", "lqr")),
        ("margins", ("--design", "poles"), ("autopilot.damping", "0.5")),
        ("respond", ("--winds", "wind.csv"), ("wind.peak_deg", "5")),
    ],
)
def test_a_key_beside_its_own_option_is_refused(command, option, key):
    code, _, error = ran(command, V, *option, "--set", *key)
    assert (code, error) == (2, f"Error: give {option[0]} or --set {key[0]}, not both\n")


@pytest.mark.parametrize(
    "command",
    [
        ("fly", "--law", "trim"),
        ("nozzle", "--over", "flight", "--law", "trim"),
        ("nozzle", "--law", "trim"),
    ],
)
def test_gains_of_another_law_than_the_autopilot_are_refused_by_key_as_by_option(command):
    option = ("--attitude-gain", "1")
    for gain in (("--set", "autopilot.attitude_gain", "1"), *[option] * (command[0] == "fly")):
        code, _, error = ran(command[0], V, *command[1:], "--limit-deg", "2", *gain)
        assert (code, error) == (2, f"Error: {' '.join(gain[:-1])} needs --law autopilot\n")


def test_an_option_and_its_key_answer_the_same():
    by_option = ran("respond", V, "--peak-deg", "-3", "--limit-deg", "1", "--json")
    keys = ("--set", "wind.peak_deg", "-3", "--set", "nozzle.limit_deg", "1")
    by_key = ran("respond", V, *keys, "--json")
    assert by_key[:2] == by_option[:2]  # not what is said while a kernel is compiled
    assert json.loads(by_key[1])["wind"]["peak_deg"] == pytest.approx(-3.0)


def test_a_key_of_the_wind_is_taken_where_no_sounding_is_given():
    wind = ("--plane", "yaw", "--set", "wind.direction_deg", "250", "--azimuth-deg", "45")
    code, out, error = ran("fly", V, *wind, "--limit-deg", "2", "--json")
    assert (code, json.loads(out)["plane"]) == (0, "yaw"), error


@pytest.mark.thorough
def test_a_flight_schedule_has_no_keys_of_a_vehicle(tmp_path):
    file = tmp_path / "flight.csv"
    row = "1.48e6,2.25e7,6.67e5,2.495e6,9.45,23.56,80700,538.81,0.78"
    head = "weight_N,moment_of_inertia_kg_m2,normal_force_slope_N_per_rad,thrust_N"
    head += ",aerodynamic_arm_m,control_arm_m,axial_force_N,velocity_m_per_s,attitude_rad"
    file.write_text(f"time_s,{head}\n50,{row}\n80,{row}\n")
    code, _, error = ran("poles", str(file), "--at", "60", "--set", "vehicle.thrust_N", "3e6")
    assert code == 2
    assert "flight schedule" in error
    assert ran("poles", str(file), "--at", "60", "--set", "study.plane", "yaw")[0] == 0
    sized = ("ascent", str(file), "--limit-deg", "1", "--json")
    assert ran(*sized, "--set", "size.every_s", "15") == ran(*sized, "--every", "15")


def test_the_list_of_keys_has_each_key_once_with_its_help():
    names = [key.name for key in all_keys()]
    assert len(names) == len(set(names))
    assert all(key.help for key in all_keys())
    for key in all_keys():  # no empty item of a list, and no function or field of Python
        assert not re.search(r", *$", key.help), key
        assert not re.search(r"[A-Z]\w+\.[a-z]|standard_|flight_duty", key.help), key
        assert not re.search(r"; see |\bNone\b|\b[A-Z]{4}S\b|^In place of these", key.help), key
    for name, table in (STUDY_TABLES | VEHICLE_TABLES).items():
        for quantity in {*table.quantities, *table.words, *table.lists} - {"filter"}:
            spelled = {f"{name}.{key}" for key, (of, _) in table.keys.items() if of == quantity}
            assert (spelled or {f"{name}.{quantity}"}) & set(names), (name, quantity)
    code, shown, _ = ran("init", "--keys")
    assert code == 0
    assert "autopilot.rate_gain_s" in shown


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("sounding.format", READERS),
        ("outputs.names", OUTPUTS),
        ("outputs.law", LAWS),
        ("size.duty_law", LAWS),
        ("laws.winds", WINDS),
        ("campaign.method", METHODS),
    ],
)
def test_the_help_of_a_key_has_the_words_that_it_takes(name, values):
    (key,) = (key for key in all_keys() if key.name == name)
    assert not [value for value in values if value not in key.help]


def test_the_list_of_keys_ends_with_the_columns_of_a_flight_its_structure_and_gains(tmp_path):
    """Tables of these columns are read, and a flight schedule has no others."""
    flight, structure, gains = ([text(row[0]) for row in table.rows] for table in column_tables())
    assert {"time_s", "thrust_N", "nominal_deflection_deg", "structure"} <= set(flight)
    assert {"mach", "attitude_gain", "rate_gain_s"} <= set(gains)
    assert structure == ["time_s", "name", "keys of [[bending]]", "keys of [[slosh]]"]
    known = {*VEHICLE_TABLES["vehicle"].every_key, *FLIGHT_COLUMNS.keys, "name", "structure"}
    assert set(flight) <= known
    file = tmp_path / "gains.csv"
    filters = {key.replace(".N.", ".1.") for key in gains if ".N." in key}
    columns = [key for key in gains[5:] if ".N." not in key] + sorted(filters)
    for variable in gains[:5]:
        file.write_text(
            f"{variable},{','.join(columns)}\n"
            + "".join(f"{k},{','.join('1' for _ in columns)}\n" for k in (1, 2))
        )
        table, of_filters = load_gains(file)
        assert table.gains.keys() >= {"attitude_gain", "rate_gain"}
        assert of_filters.keys() == filters
    said = " ".join(ran("init", "--keys")[1].split())
    assert "Columns of a table of gains (CSV)" in said


def test_each_key_of_the_list_is_known():
    rows = dict.fromkeys(("wind", "bending", "slosh", "correlation", "dispersion"), ".1")
    for home, _, key in (item.name.rpartition(".") for item in all_keys()):
        place = f"{home}{'.1' if home == 'autopilot.filter' else rows.get(home, '')}"
        with_settings(BENDS, [(f"{place}.{key}", "none")])


def test_the_shell_completes_keys():
    assert "autopilot.rate_gain_s" in dict(_completed("autopilot.ra"))
    assert not dict(_completed("nothing"))


def test_a_campaign_takes_keys_too(tmp_path):
    file = study_of(
        tmp_path, "[campaign]\ncases = 8\n[[dispersion]]\nparameter = 'thrust'\npercent = 1"
    )
    code, said, error = ran(
        "disperse", file, "-o", str(tmp_path / "r"), "--set", "campaign.cases", "4"
    )
    assert code == 0, error
    assert "4 of 4" in said


def test_a_vehicle_in_the_table_of_a_campaign_takes_keys(tmp_path):
    """They are set there, and not in a table [study] with all other keys of the campaign."""
    shipped = resources.files("tvclin.vehicle").joinpath("shipped", "configuration-i.toml")
    numbers = tomllib.loads(shipped.read_text(encoding="utf-8"))["vehicle"]
    lines = "".join(f"{key} = {json.dumps(value)}\n" for key, value in numbers.items())
    file = tmp_path / "campaign.toml"
    head = "[wind]\npeak_deg = 5.0\nduration_s = 7.5\n[campaign]\ncases = 8\nseed = 1\n"
    file.write_text(f"{head}[campaign.vehicle]\n{lines}")
    plan = load_campaign(with_settings(str(file), [("vehicle.thrust_N", "2.6e6")]))
    assert plan.vehicle.thrust == 2.6e6


SPEEDS = STUDY.replace("peak_deg = 5.0", "peak_speed_m_per_s = 40") + (
    "[gust]\npeak_speed_m_per_s = 30\nduration_s = 2\n"
)
"""A study whose wind and gust are speeds, with other angles in each plane."""


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("option", "key"),
    [
        (("--plane", "yaw"), "study.plane=yaw"),
        (("--peak-deg", "8"), "wind.peak_deg=8"),
        (("--peak-speed", "20"), "wind.peak_speed_m_per_s=20"),
    ],
)
@pytest.mark.parametrize("question", [("study",), ("boundary",), ("ascent", "--from", "66")])
def test_an_option_over_the_speeds_of_a_file_says_what_its_key_says(
    tmp_path, question, option, key
):
    command, *more = question
    text = SPEEDS + "[nozzle]\nlimit_deg = 0.6\n"
    text += "[size]\nto_s = 66\n" if command == "ascent" else ""
    arguments = (command, study_of(tmp_path, text=text), *more, "--json")
    by_option, by_key = (ran(*arguments, *given) for given in (option, ("--set", key)))
    assert by_option[:2] == by_key[:2]
    assert by_option[:2] != ran(*arguments)[:2]  # it counts


def test_the_plane_of_an_option_is_that_of_the_gust_on_a_sounding(tmp_path):
    sounding = f'[[wind]]\nsounding = "{SOUNDING}"\nazimuth_deg = 90\n'
    gust = "[gust]\npeak_speed_m_per_s = 9\nduration_s = 2\n"
    head = '[study]\nvehicle = "configuration-i"\ntime_s = 66\n'
    file = study_of(tmp_path, text=head + sounding + gust)
    by_option, by_key = (
        ran("boundary", file, "--json", *given)
        for given in (("--plane", "yaw"), ("--set", "study.plane=yaw"))
    )
    assert by_option[0] == 0
    assert by_option[:2] == by_key[:2]


def test_a_gust_without_a_time_is_where_the_dead_band_of_the_file_requires_most(tmp_path):
    gust = "[gust]\npeak_deg = 1.0\nduration_s = 1.5\n"
    text = STUDY.replace("[study]", "[study]\ndead_band = 0.5").replace("= 5.0", "= 1.0") + gust
    file = study_of(tmp_path, text=text)
    study = json.loads(ran("study", file, "--json")[1])
    rows = study["boundaries"]["drift-exact"]
    required = rows["required_deflection_deg"][rows["dead_band"].index(0.5)]
    assert required == pytest.approx(study["verdict"]["nominal_deflection_deg"], rel=1e-12)
    less = str(0.97 * required)  # suffices for the gust where K = 1 requires most
    for command in (("respond",), ("fly", "--law", "report")):
        answered = json.loads(ran(*command, file, "--limit-deg", less, "--json")[1])
        assert answered["survived"] is False
    bound = json.loads(ran("boundary", file, "--json")[1])["peak_deg"]
    assert bound == pytest.approx(study["minimum_deg"]["drift-exact"], rel=1e-9)
    trade_off = json.loads(ran("nozzle", file, "--json")[1])["trade_off"]
    assert trade_off["minimum_deflection_deg"] == pytest.approx(bound, rel=1e-9)
