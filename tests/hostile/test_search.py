"""A search for files and options that end in a traceback, in no number, or never.

Every case is one command, run here with mutated files and random options. It takes some hundred
cases, always the same, a sixteenth of them in a usual run; TVCLIN_HOSTILE=5000 looks at so many of
each kind, at random.
"""

import os
import re
import tempfile
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import typer
from hypothesis import HealthCheck, Phase
from hypothesis import strategies as st
from typer.testing import CliRunner

import tvclin as tv
from tests.clock import THERE, ending
from tests.studies import FLIGHT as FLIGHT_STUDY
from tests.turns import drawn
from tvclin.cli.app import app
from tvclin.studyfile.campaign_file import template as campaign_template
from tvclin.studyfile.read import example as study_example
from tvclin.vehicle.vehicle_file import read_vehicle_text

SOUNDINGS = Path(__file__).parents[1] / "soundings"
MORE = int(os.environ.get("TVCLIN_HOSTILE", "0"))
LONG = "x" * 300

VEHICLE = read_vehicle_text("configuration-i")[0]
SCHEDULE = """[schedule]
time_s = [60, 70, 80]
weight_N = [1.5e6, 1.48e6, 1.4e6]
moment_of_inertia_kg_m2 = 2.25e7
normal_force_slope_N_per_rad = [6e5, 6.67e5, 6e5]
thrust_N = 2.495e6
aerodynamic_arm_m = 9.45
control_arm_m = 23.56
axial_force_N = 8e4
velocity_m_per_s = [500, 540, 600]
attitude_deg = [46, 44.8, 43]
altitude_m = [10000, 12000, 14000]
"""
ROWS = [line.split(" = ") for line in SCHEDULE.splitlines()[1:]]
CSV = "\n".join(
    ",".join(cells)
    for cells in zip(
        *([key, *(values.strip("[]").split(", ") * 3)[:3]] for key, values in ROWS), strict=True
    )
)
STUDY = study_example()
FLIGHT = FLIGHT_STUDY.replace("wyoming.txt", str(SOUNDINGS / "wyoming.txt"))
CAMPAIGN = campaign_template()

NUMBERS = (
    *("0", "-0.0", "-1", "1e-300", "1e-18", "1e-9", "1e-6", "1e-3", "0.5", "1", "2", "7.5", "30"),
    *("45", "89.999", "90", "1e3", "1e4", "1e6", "1e9", "1e18", "1e150", "1e300", "1e400"),
    *("nan", "inf", "-inf", "10_0", "0x10"),
)
NAMES = (
    *("configuration-i", "configuration-ii", "triangular", "rectangular", "one-minus-cosine"),
    *("fixed-path", "drift", "drift-exact", "drift-and-speed", "all", "pitch", "yaw", "report"),
    *("literal", "canonical", "poles", "drift-minimum", "load-minimum", "lqr", "classic"),
    *("aircraft", "nichols", "bode", "nyquist", "root-locus", "planar", "trim", "dead-band"),
    *(
        "autopilot",
        "recoverable-attitude",
        "flown",
        "K = 1",
        "",
        " ",
        ".",
        "..",
        "/",
        "none.toml",
        "~",
    ),
    *(LONG, f"{LONG}.toml", "half-relief"),
)
numbers = st.one_of(
    st.sampled_from(NUMBERS),
    st.floats(1e-3, 1e3).map(repr),
    st.floats(1e-3, 1e3).map(repr),
    st.floats().map(repr),
    st.integers(-3, 10**30).map(str),
)
words = st.one_of(
    st.sampled_from(NAMES),
    st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=12),
)
values = st.one_of(
    numbers,
    numbers,
    st.sampled_from(
        [
            "true",
            "[]",
            "[1]",
            "[[1]]",
            "{}",
            "{a = 1}",
            '[{a = "b"}]',
            "1979-05-27",
            "07:32:00",
            "1" * 5000,
            "0x" + "f" * 5000,
            "[" * 50 + "]" * 50,
            '"a\\u0000b"',
            f'"{LONG}"',
            '"' + "y" * 5000 + '"',
            '"../"',
            '"\\n"',
        ]
    ),
    words.map(lambda word: '"' + word.replace("\\", "").replace('"', "") + '"'),
)


pytestmark = pytest.mark.skipif(not THERE, reason="timers of POSIX")
BESIDE = ("Note: ", "Warning: ")
"""What may stand before an error: of doubtful numbers, the reason for it."""
NO_NUMBER = re.compile(r"(?<![\w./-])[-+]?(nan|inf)(?![\w.-])", re.IGNORECASE)


def check(*arguments: str) -> None:
    """Assert that a command ends, with tables of numbers or in one sentence."""
    with ending():
        result = CliRunner().invoke(app, list(arguments))
    assert result.exit_code in (0, 1, 2)
    assert result.exception is None or isinstance(result.exception, SystemExit)
    assert "encountered in" not in result.stderr.split("Error:")[0]
    if result.exit_code == 2 and not result.stderr.startswith("Usage:"):
        said = [one for one in result.stderr.splitlines() if not one.startswith(BESIDE)]
        assert said[0].startswith("Error: ")
        # a line for each fault of a file, such as of the heads of a CSV
        assert all(re.search(r"\.toml: |\.csv, line \d+: ", one) for one in said[1:])
        assert all(len(one) < 1200 for one in said)
        assert not result.stdout
    elif result.exit_code != 2:
        assert not NO_NUMBER.search(result.stdout), NO_NUMBER.search(result.stdout)


@contextmanager
def away():
    """Go to an empty folder."""
    here = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            yield Path(folder)
        finally:
            os.chdir(here)


def searched(count: int, *strategies: Any) -> Callable:
    """Return what searches among so many cases where it is thorough, else among a fortieth."""
    more = {"max_examples": MORE, "derandomize": False} if MORE else {}
    return drawn(
        -(-count // 40),
        count,
        *strategies,
        database=None,
        phases=[Phase.explicit, Phase.generate],
        suppress_health_check=list(HealthCheck),
        print_blob=True,
        **more,
    )


CHEAP = ("study", "boundary", "respond", "poles", "margins", "vehicles", "doctor")
DEAR = {
    "design": (),
    "ascent": ("--every", "30"),
    "fly": (),
}
"""Commands that take a second or more, with options to make them short."""


def _options(name: str) -> dict[str, Any]:
    """The options of a command by the name that they have in a shell."""
    command = typer.main.get_command(app).commands[name]
    options = {
        param.opts[-1]: param for param in command.params if param.param_type_name == "option"
    }
    return {said: option for said, option in options.items() if said not in ("--plot", "--csv")}


OPTIONS = {name: _options(name) for name in (*CHEAP, *DEAR)}


@st.composite
def one_option(draw: Callable, name: str) -> list[str]:
    """An option with a value, more often a number than a word."""
    option = draw(st.sampled_from(sorted(OPTIONS[name])))
    taken = 0 if OPTIONS[name][option].is_flag else OPTIONS[name][option].nargs
    return [option, *(draw(st.one_of(numbers, numbers, words)) for _ in range(taken))]


@st.composite
def command_lines(draw: Callable, names: list[str], first: Any) -> list[str]:
    """A command with up to four options."""
    name = draw(st.sampled_from(names))
    line = [name, *DEAR.get(name, ())]
    if name not in ("vehicles", "doctor"):
        line[1:1] = draw(first)
    for _ in range(draw(st.integers(0, 4))):
        line += draw(one_option(name))
    return line


sources = st.one_of(
    st.just([]),
    st.sampled_from([["configuration-i"], ["configuration-ii"]]),
    words.map(lambda w: [w]),
)


@pytest.mark.thorough
@searched(120, command_lines(list(CHEAP), sources))
def test_no_option_is_a_traceback_or_no_number(line: list[str]) -> None:
    with away():
        check(*line)


@pytest.mark.thorough
@searched(25, command_lines(list(DEAR), st.just([])))
def test_no_option_of_a_long_command_is_a_traceback_or_an_endless_wait(line: list[str]) -> None:
    with away():
        check(*line)


@st.composite
def mutated(draw: Callable, text: str) -> str:
    """A text in which one to three lines have been changed."""
    lines = text.splitlines()
    for _ in range(draw(st.integers(1, 3))):
        lines = lines or [""]
        at = draw(st.integers(0, len(lines) - 1))
        what = draw(st.sampled_from(["value", "value", "value", "value", "gone", "twice", "text"]))
        if what == "value":
            keyed = [i for i, line in enumerate(lines) if re.match(r"#? ?\w+ = ", line)]
            if keyed:
                at = draw(st.sampled_from(keyed))
                key = lines[at].removeprefix("# ").split(" = ")[0]
                lines[at] = f"{key} = {draw(values)}"
        elif what == "gone":
            del lines[at]
        elif what == "twice":
            lines.insert(draw(st.integers(0, len(lines))), lines[at])
        else:
            lines[at] = draw(words) + lines[at][draw(st.integers(0, 40)) :]
    return "\n".join(lines)


@st.composite
def mutated_cells(draw: Callable, text: str) -> str:
    """A table in which one to three cells have been changed."""
    parts = re.split(r"([,\n ]+)", text)
    for _ in range(draw(st.integers(1, 3))):
        at = draw(st.integers(0, len(parts) - 1))
        parts[at] = draw(st.one_of(numbers, words, st.sampled_from(["\n", ",", '"', "1" * 5000])))
    return "".join(parts)


def _written(name: str, text: str) -> None:
    Path(name).write_bytes(text.encode("utf-8", "replace"))


VEHICLE_COMMANDS = ["study", "respond", "poles", "boundary", "margins", "ascent", "fly"]


@pytest.mark.thorough
@searched(
    100,
    mutated(VEHICLE),
    st.sampled_from(VEHICLE_COMMANDS),
    st.sampled_from(["fixed-path", "drift", "drift-exact", "drift-and-speed"]),
)
def test_no_vehicle_file_is_a_traceback_or_no_number(text: str, name: str, model: str) -> None:
    with away():
        _written("my.toml", text)
        options = {"ascent": ["--every", "30", "--model", model], "fly": []}
        check(name, "my.toml", *options.get(name, ["--model", model]))


@st.composite
def far_off(draw: Callable) -> str:
    """A vehicle whose numbers are those of configuration I, many of them by many powers of ten."""
    widest = draw(st.sampled_from([1.0, 3.0, 10.0, 40.0, 300.0]))

    def changed(line: re.Match) -> str:
        power = draw(st.one_of(st.just(0.0), st.floats(-widest, widest)))
        sign = draw(st.sampled_from(["", "", "", "-"])) if "_m =" in line[0] else ""
        mantissa = draw(st.floats(1.0, 9.99))
        number = (
            float(line[2]) * mantissa / 3.0 * 10.0**power if "attitude" not in line[1] else 44.8
        )
        return f"{line[1]}{sign}{number!r}"

    text = "\n".join(line.split("#")[0] for line in VEHICLE.splitlines())
    return re.sub(r"(?m)^(\w+ = )([0-9.e+]+)", changed, text)


@pytest.mark.thorough
@searched(
    100,
    far_off(),
    st.sampled_from([*VEHICLE_COMMANDS, "respond", "design"]),
    st.sampled_from(["fixed-path", "drift", "drift-exact", "drift-and-speed"]),
    st.sampled_from([[], ["--plane", "yaw"], ["--duration", "0.1"], ["--duration", "60"]]),
)
def test_no_vehicle_far_off_is_a_traceback_or_no_number(text, name, model, more) -> None:
    with away():
        _written("my.toml", text)
        options = {"ascent": ["--every", "30", "--model", model], "fly": []}
        if name in ("poles", "boundary", "margins"):
            more = []
        check(name, "my.toml", *options.get(name, ["--model", model]), *more)


@searched(10, mutated(VEHICLE))
def test_no_flight_along_the_trajectory_is_a_traceback(text: str) -> None:
    with away():
        _written("my.toml", text)
        check("fly", "my.toml", "--engine", "planar-varying")


@searched(60, st.one_of(mutated(STUDY), mutated(FLIGHT)), st.sampled_from(["study", "ascent"]))
def test_no_study_file_is_a_traceback_or_no_number(text: str, name: str) -> None:
    with away():
        _written("my.toml", text)
        check(name, "my.toml")


@searched(30, st.one_of(mutated(SCHEDULE), mutated_cells(CSV)), st.booleans())
def test_no_schedule_is_a_traceback_or_no_number(text: str, varying: bool) -> None:
    with away():
        name = "my.toml" if text.startswith("[") else "my.csv"
        _written(name, text)
        check("ascent", name, "--every", "10", *["--varying"] * varying)


@searched(40, st.sampled_from(sorted(SOUNDINGS.iterdir())), st.data())
def test_no_sounding_is_a_traceback(file: Path, data) -> None:
    text = "\n".join(file.read_text(errors="replace").splitlines()[:60])
    with away():
        _written(file.name, data.draw(mutated_cells(text)))
        check("ascent", "--every", "60", "--winds", file.name, "--azimuth-deg", "90")


@searched(40, mutated(CAMPAIGN))
def test_no_campaign_file_is_a_traceback(text: str) -> None:
    pytest.importorskip("pyarrow")
    with away():
        _written("my.toml", re.sub(r"^cases = \d+", "cases = 20", text, flags=re.MULTILINE))
        try:
            plan = tv.studyfile.load_campaign("my.toml")
        except tv.InputError:
            plan = None
        if plan is None or plan.cases <= 100:
            check("campaign", "run", "my.toml", "-o", "results")
        if plan is not None and plan.cases <= 100 and Path("results").exists():
            check("campaign", "show", "results")
            check("campaign", "replay", "results", "0")
        check("study", "my.toml")
