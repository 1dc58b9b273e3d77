"""A question is answered, or refused, with every part of a case; a part not counted is named."""

import json
import re
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
from typer.testing import CliRunner

import tvclin as tv
from tests.archives import Balloon, jet, write
from tests.turns import usual
from tvclin.case.features import (
    NOTED,
    OPTIONS,
    QUESTIONS,
    REFUSED,
    computing_questions,
    omission_notes,
    use_of,
)
from tvclin.cli.app import app
from tvclin.ensembles.campaign.cases import evaluate
from tvclin.vehicle.linear_vehicle import load_any_vehicle
from tvclin.vehicle.vehicle_file import read_vehicle_text

PAGES = Path(__file__).parents[2] / "docs"
SOUNDING = Path(__file__).parents[1] / "soundings" / "table.csv"
BENDS = """
[[bending]]
frequency_rad_per_s = 38.0
damping = 0.005
modal_mass_kg = 2e5
gimbal_displacement = 1.0
gimbal_slope_per_m = -0.07
attitude_slope_per_m = 0.02
rate_slope_per_m = 0.02
"""
VALUES = {
    "gust": ("--set", "gust.peak_deg=1.5", "--set", "gust.duration_s=1"),
    "head wind": ("--peak-deg", -5),
    "sign that counts": ("--sign", "frozen"),
    "heading": ("--set", "wind.direction_deg=250", "--azimuth-deg", 45),
    "measured wind": ("--winds", SOUNDING, "--azimuth-deg", 90),
    "limit shape": ("--limit-shape", "square"),
    "actuator": ("--set", "nozzle.actuator_frequency_Hz=3"),
    "rate limit": ("--set", "nozzle.rate_limit_deg_per_s=0.2"),
    "delay": ("--delay-ms", 40),
    "sample rate": ("--sample-rate", 30),
    "filters": (
        "--set",
        'autopilot.filter=[{kind="notch", frequency_Hz=5, zero_damping=0.05, pole_damping=0.5}]',
    ),
    "gains": ("--set", "autopilot.integral_gain_per_s", 0.05),
    "dispersion": ("--set", "dispersion.thrust.percent=5"),
    "turbulence": ("--set", "turbulence.intensity_m_per_s=6"),
    "limit": ("--limit-deg", 0.3),
}
WORK = "torque, power, travel and acceleration limits"
"""They have no options."""
LINEAR = ("--engine", "linear", "--law", "autopilot", "--limit-deg", 2)
FLIGHT = ("--law", "autopilot", "--limit-deg", 2, "--from", 70, "--to", 70)
KEYS = {
    "delay": ("--set", "autopilot.delay_ms", 40),
    "sample rate": ("--set", "autopilot.sample_rate_Hz", 30),
    "sign that counts": ("--set", "study.sign", "frozen"),
}
BASE = {
    "boundary --tau-beta": (3,),
    "fly": LINEAR,
    "fly --law all": ("--wind", "triangular"),
    "nozzle": ("--law", "autopilot", "--limit-deg", 2),
    "nozzle --over flight": FLIGHT,
    "nozzle --over load": ("--law", "autopilot", "--limit-deg", 2),
    "ascent": ("--from", 70, "--to", 70),
    "availability": ("--limit-deg", 0.35, "--azimuth-deg", 45),
}
OTHERWISE = {
    ("boundary", "rate limit"): ("--set", "nozzle.rate_limit_deg_per_s", 0.2),
    **{
        ("margins", part): ("--limit-deg", 2, *VALUES[part])
        for part in ("gust", "head wind", "heading", "measured wind")
    },
    ("margins", "rate limit"): ("--limit-deg", 2, "--set", "nozzle.rate_limit_deg_per_s=1"),
    ("margins", "limit"): ("--limit-deg", 3),
    ("fly --law all", "measured wind"): VALUES["measured wind"],
    ("fly", "sign that counts"): (*LINEAR, *KEYS["sign that counts"]),
    ("ascent", "limit shape"): (
        *("--plane", "both", "--set", "nozzle.limit_shape=square", "--from", 70, "--to", 70),
        *VALUES["heading"],
    ),
    ("availability", "measured wind"): (SOUNDING, "--limit-deg", 0.35, "--azimuth-deg", 45),
    ("fly", "limit"): (*LINEAR[:-1], 1.5),
    ("nozzle", "limit"): ("--law", "autopilot", "--limit-deg", 1.5),
    ("nozzle --over flight", "limit"): (*FLIGHT[:3], 1.5, *FLIGHT[4:]),
    ("nozzle --over flight", "limit shape"): (
        *(*FLIGHT, "--plane", "both", "--set", "nozzle.limit_shape=square", *VALUES["heading"]),
    ),
    **{
        (question, part): (*BASE[question], *key)
        for question in BASE
        if question.startswith("nozzle")
        for part, key in KEYS.items()
    },
    **{
        (question, "limit shape"): ("--plane", "both", "--set", "nozzle.limit_shape=square")
        for question in ("nozzle", "nozzle --over load")
    },
    **{("ascent", part): (*BASE["ascent"], *KEYS[part]) for part in ("delay", "sample rate")},
    ("ascent", "rate limit"): ("--limit-deg", 1, "--rate-limit-deg", 2, *BASE["ascent"]),
    ("nozzle --over load", "limit"): ("--law", "autopilot", "--limit-deg", 1.5),
    ("ascent", "measured wind"): ("--winds", SOUNDING, "--azimuth-deg", 90),
    ("ascent", "sign that counts"): (*BASE["ascent"], *KEYS["sign that counts"]),
    ("ascent", "gust"): ("--set", "gust.peak_deg=1.5", "--set", "gust.duration_s=1"),
    **{
        ("availability", part): (*BASE["availability"], "--set", "study.sign=frozen")
        for part in ("head wind", "sign that counts")
    },
    ("availability", "gust"): (*BASE["availability"], *VALUES["gust"]),
    ("availability", "rate limit"): (*BASE["availability"], "--rate-limit-deg", 0.2),
    ("availability", "heading"): ("--limit-deg", 0.35, "--azimuth-deg", 90),
    ("availability", "limit"): ("--limit-deg", 0.3, "--azimuth-deg", 45),
    ("availability", "limit shape"): (
        *("--limit-deg", 0.35, "--azimuth-deg", 45),
        *("--plane", "both", "--set", "nozzle.limit_shape=square"),
    ),
}


class Files(NamedTuple):
    """The vehicle of a question, with a damping, and with a bending mode."""

    plain: Path
    damped: Path
    bent: Path
    station: Path


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("parts")
    text = read_vehicle_text("configuration-i")[0]
    damped = text.replace("[vehicle]", "[vehicle]\npitch_damping_N_m_s_per_rad = 4e6", 1)
    made = []
    for name, words in {"plain": text, "damped": damped, "bent": text + BENDS}.items():
        made.append(folder / f"{name}.toml")
        made[-1].write_text(words)
    days = [f"2023-02-{day:02d}T00" for day in range(1, 11)]
    station = write(
        folder / "s-data.txt", [Balloon(day, jet(6.0 * (k + 1))) for k, day in enumerate(days)]
    )
    return Files(*made, Path(station))


def answer_of(question, vehicle, station, *options):
    if question == "availability":
        options = (station, *options)
    command, *more = question.split()
    words = (command, vehicle, *more, *options, "--json")
    return CliRunner().invoke(app, [str(word) for word in words])


BY_FILE = ("study", "report", "disperse", "explore")


QUICK = ("poles", "boundary --tau-beta", "boundary", "design")
"""Questions of less than half a second, of which a usual run draws cells; the others fly."""
CELLS = [(q, part) for q in QUESTIONS if q not in BY_FILE for part in OPTIONS if part != WORK]
DRAWN = [
    k
    for k, (question, part) in enumerate(CELLS)
    if question in QUICK and part != "gust" and k % 5 == 0  # the worst time of a gust is sought
]


@pytest.fixture(scope="module")
def base(files):
    """The answer to a question without any part of the table, each made once."""

    @cache
    def answered(question):
        result = answer_of(question, files.plain, files.station, *BASE.get(question, ()))
        assert result.exit_code in (0, 1), result.output
        return result.stdout

    return answered


def asked_with(question, part, files):
    """Return the options of a part, and the answer to a question with them."""
    vehicle = {"structure": files.bent, "damping": files.damped}.get(part, files.plain)
    options = (*BASE.get(question, ()), *VALUES.get(part, ()))
    options = OTHERWISE.get((question, part), options)
    return options, answer_of(question, vehicle, files.station, *options)


@pytest.mark.parametrize(("question", "part"), usual(CELLS, *DRAWN))
def test_a_part_is_computed_told_or_refused(question, part, files, base):
    options, result = asked_with(question, part, files)
    changed = result.exit_code in (0, 1) and result.stdout != base(question)
    said = " ".join(result.output.split())
    # a key that is set is one of the file, whose notes say what is left out
    left_out = "--set" in options and "not counted here" in said
    kind = use_of(question, part)
    if kind == REFUSED:
        assert (result.exit_code == 2 and "tvclin" in said) or left_out, said[:300]
    elif kind == NOTED:
        vehicle = {"structure": files.bent, "damping": files.damped}.get(part, files.plain)
        sentences = omission_notes(tv.Case(vehicle=load_any_vehicle(vehicle)), question)
        assert all(sentence in " ".join(result.stderr.split()) for sentence in sentences), said[
            :300
        ]
    else:  # or neglected by an option: laws of a rigid vehicle have no actuator
        assert changed or left_out, said[:300]


@pytest.mark.parametrize("question", [q for q in QUESTIONS if q not in BY_FILE])
def test_every_part_that_the_table_refuses_is_refused_at_the_door(question, files):
    """By its option; a part that a key sets is not counted, as with a file, and is named."""
    refused = [
        option for option in OPTIONS if option != WORK and use_of(question, option) == REFUSED
    ]
    for part in refused:
        if "--set" in OTHERWISE.get((question, part), VALUES.get(part, ())):
            continue
        _, result = asked_with(question, part, files)
        assert result.exit_code == 2, (part, result.output)
        assert "tvclin" in " ".join(result.output.split()), (part, result.output)


WIND = {"shape": "triangular", "peak_deg": 5.0, "duration_s": 7.5}
DIRECTION = {"direction_deg": 250, "azimuth_deg": 45}
STUDY = {
    "study": {"vehicle": "plain.toml"},
    "wind": WIND,
    "nozzle": {"limit_deg": 1.0},
    "autopilot": {},
    "laws": {"names": ["autopilot"], "winds": ["triangle"]},
}
IN_FILES = {
    "damping": {"study": {"vehicle": "damped.toml"}},
    "gust": {"gust": {"peak_deg": 1.5, "duration_s": 1.0}},
    "head wind": {"wind": {"peak_deg": -5.0}},
    "sign that counts": {"study": {"sign": "frozen"}},
    "heading": {"wind": DIRECTION},
    "limit shape": {"wind": DIRECTION, "nozzle": {"limit_shape": "square"}},
    "actuator": {"nozzle": {"actuator_frequency_rad_per_s": 18.0}},
    "rate limit": {"nozzle": {"rate_limit_deg_per_s": 0.3}},
    "delay": {"autopilot": {"delay_ms": 40}},
    "sample rate": {"autopilot": {"sample_rate_Hz": 30}},
    "filters": {"autopilot": {"filter": [{"kind": "low-pass", "frequency_Hz": 5.0}]}},
    "gains": {"autopilot": {"integral_gain_per_s": 0.05}},
    "dispersion": {"dispersion": [{"parameter": "thrust", "shape": "uniform", "percent": 5}]},
    "turbulence": {"turbulence": {"intensity_m_per_s": 6.0}},
    "limit": {"nozzle": {"limit_deg": 0.5}},
    WORK: {"nozzle": {"mass_kg": 900, "arm_m": 1.0, "torque_limit_N_m": 4e3}},
}


def in_toml(tables):
    """Return tables of plain values, and of lists of such tables, as TOML."""

    def one(values):
        return "{" + ", ".join(f"{k} = {value(v)}" for k, v in values.items()) + "}"

    def value(item):
        if isinstance(item, list) and item and isinstance(item[0], dict):
            return f"[{', '.join(map(one, item))}]"
        return json.dumps(item)

    return "\n".join(
        f"{k} = {one(v) if isinstance(v, dict) else value(v)}" for k, v in tables.items()
    )


def changed_by(base, change):
    return base | {k: base.get(k, {}) | v if isinstance(v, dict) else v for k, v in change.items()}


@pytest.mark.thorough
def test_every_part_of_a_study_is_computed_or_named(files):
    folder = files.plain.parent

    def answer_to(tables):
        (folder / "study-file.toml").write_text(in_toml(tables))
        return CliRunner().invoke(app, ["study", str(folder / "study-file.toml"), "--json"])

    base = answer_to(STUDY)
    assert base.exit_code in (0, 1), base.output
    wrong = {}
    for part, change in IN_FILES.items():
        result = answer_to(changed_by(STUDY, change))
        named = f"not counted here: {part} (tvclin" in " ".join(result.stderr.split())
        if (
            result.exit_code == 2
            or (result.stdout == base.stdout) != (part == WORK)
            or named != (part == WORK)
        ):
            wrong[part] = result.output[:300]
    assert not wrong, wrong
    bent = answer_to(changed_by(STUDY, {"study": {"vehicle": "bent.toml"}}))
    assert "".join(
        omission_notes(tv.Case(vehicle=load_any_vehicle(files.bent)), "study")
    ) in " ".join(bent.stderr.split())


OF_ONE_TIME = {
    "respond": (),
    "boundary": (),
    "boundary --tau-beta": (3,),
    "poles": (),
    "margins": (),
    "design": (),
    "fly": ("--engine", "linear"),
    "fly --law all": (),
    "nozzle": ("--law", "autopilot"),
    "nozzle --over load": ("--law", "autopilot"),
}
IN_FLIGHT = ("gust", "head wind", "heading", "limit shape", "rate limit")
"""Parts that count in flown margins alone."""


@pytest.mark.parametrize("question", usual(OF_ONE_TIME, 2, 3))
def test_every_part_of_a_study_file_is_computed_or_named(question, files):
    folder = files.plain.parent

    def answer_to(tables, *more):
        (folder / "one.toml").write_text(in_toml(tables))
        command, *mode = question.split()
        words = (command, folder / "one.toml", *mode, *OF_ONE_TIME[question], *more, "--json")
        return CliRunner().invoke(app, [str(word) for word in words])

    @cache
    def base(*more):
        return answer_to(STUDY | {"nozzle": {"limit_deg": 2.0}}, *more)

    def own(result):
        """The answer of the question itself, without that of the study beside it."""
        return re.sub(r'"required_deflection_deg": .*', "", result.stdout)

    assert base().exit_code in (0, 1), base().output
    wrong = {}
    in_files = IN_FILES | {"limit shape": {"nozzle": {"limit_shape": "square"}}}
    if question == "margins":  # with less the flight is lost
        in_files |= {
            "rate limit": {"nozzle": {"rate_limit_deg_per_s": 1.0}},
        }
    for part, change in in_files.items():
        more = ("--limit-deg", 2) if question == "margins" and part in IN_FLIGHT else ()
        result = answer_to(changed_by(STUDY | {"nozzle": {"limit_deg": 2.0}}, change), *more)
        changed = result.exit_code in (0, 1) and own(result) != own(base(*more))
        said = " ".join(result.stderr.split())
        listed = " ".join(re.findall(r"not counted here: (.*?) \(tvclin", said))
        named = part in listed
        if result.exit_code == 2 or changed == named or (use_of(question, part) == REFUSED) > named:
            wrong[part] = (result.exit_code, changed, said[:300])
    assert not wrong, wrong


CASES = {
    "campaign": {"vehicle": "plain.toml", "cases": 4, "seed": 1},
    "wind": WIND,
    "nozzle": {"limit_deg": 1.0},
    "outputs": {"names": ["required", "margins", "flight"]},
    "dispersion": [{"parameter": "thrust", "shape": "uniform", "percent": 5}],
}
IN_CAMPAIGNS = {
    name: change for name, change in IN_FILES.items() if name not in (WORK, "turbulence")
} | {
    "sign that counts": {"campaign": {"sign": "frozen"}},
    "measured wind": {"wind": {"file": "winds.csv", "unit": "deg"}},
    "dispersion": {"dispersion": [{"parameter": "thrust", "shape": "uniform", "percent": 9}]},
    "structure": {"campaign": {"vehicle": "bent.toml"}},
    "damping": {"campaign": {"vehicle": "damped.toml"}},
}


@pytest.fixture(scope="module")
def campaign(files):
    """Return the outputs of the cases of a campaign, with a change of its file."""
    folder = files.plain.parent
    (folder / "winds.csv").write_text("time_s,one\n0,0\n3,4\n6,0\n")

    @cache
    def outputs(part=""):
        change = IN_CAMPAIGNS.get(part, {})
        document = changed_by(CASES, change)
        if "file" in document["wind"]:
            document["wind"] = change["wind"]
        (folder / "campaign.toml").write_text(in_toml(document))
        columns = evaluate(tv.studyfile.load_campaign(folder / "campaign.toml"), 0, 4)
        return json.dumps({name: values.tolist() for name, values in columns.items()})

    return outputs


@pytest.mark.parametrize("part", usual(IN_CAMPAIGNS, 0, 3, 10))
def test_every_part_of_a_campaign_is_computed_or_refused(part, campaign):
    """Cases draw sizes of deflections, which the sign of a wind does not change."""
    if use_of("disperse", part) == REFUSED:
        with pytest.raises(tv.InputError):
            campaign(part)
    else:
        assert (campaign(part) != campaign()) == (part != "head wind")


def tables() -> str:
    """Return two tables in Markdown: questions by refused features, rare features by questions.

    A feature is rare that at most four questions compute; it is absent from the first table.
    """
    rare = [feature for feature in OPTIONS if len(computing_questions(feature)) <= 4]
    usual = [feature for feature in OPTIONS if feature not in rare]
    questions = [
        (f"`{q}`", ", ".join(f for f in usual if use_of(q, f) == REFUSED)) for q in QUESTIONS
    ]
    features = [
        (
            f"{feature} (note)" if feature == "structure" else feature,
            ", ".join(f"`{question}`" for question in computing_questions(feature)),
        )
        for feature in rare
    ]
    return "\n\n".join(
        "\n".join(f"| {' | '.join(row)} |" for row in [headings, ("---", "---"), *rows])
        for headings, rows in (
            (("question", "does not compute"), [row for row in questions if row[1]]),
            (("feature", "computed only by"), features),
        )
    )


def test_the_conventions_print_the_table():
    assert tables() in (PAGES / "conventions.md").read_text()


def test_the_page_answers_what_the_study_does():
    assert all(use_of("report", part) == use_of("study", part) for part in OPTIONS)
