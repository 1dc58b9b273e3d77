"""A random walk: an option of a command changes the answer, or is refused in one sentence."""

import json
import random
from functools import cache
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from tvclin.cli.app import app

SOUNDING = str(Path(__file__).parents[1] / "soundings" / "wyoming.txt")
SHOWN = (
    "settings",
    "as_json",
    "plot",
    "csv",
    "points",
    "chart",
    "system",
    "until",
    "explain",
    "more",
    "help",
)
"""Options that say how an answer is shown."""
V = "configuration-i"
TIMES = ("--from", "70", "--to", "71")
F = "study.toml"
STUDY = """
[study]
vehicle = "configuration-i"
dead_band = 0.5
[wind]
peak_deg = 4.0
duration_s = 6.0
[gust]
peak_deg = 0.5
duration_s = 1.0
peak_time_s = 2.5
[nozzle]
limit_deg = 1.0
rate_limit_deg_per_s = 20
[autopilot]
natural_frequency_rad_per_s = 1.2
delay_ms = 10
[laws]
names = ["trim"]
"""
GUST = ("--set", "gust.peak_deg=1", "--set", "gust.duration_s=2")
STARTS = {
    "respond": [(V,), (V, "--winds", SOUNDING, "--azimuth-deg", "90"), (F,)],
    "design": [(V,), ("made-up-launcher", "--natural-frequency", "1.2"), (V, *GUST), (F,)],
    "margins": [
        (V,),
        (V, "--limit-deg", "2"),
        ("made-up-launcher", "--natural-frequency", "1.2"),
        (F,),
    ],
    "fly": [
        (V, "--engine", "linear", "--limit-deg", "2"),
        (V, "--limit-deg", "2"),
        (F,),
        (F, "--law", "all"),
    ],
    "nozzle": [
        (V, "--law", "autopilot", "--limit-deg", "2"),
        (V,),
        (F,),
        (V, "--over", "load", "--law", "autopilot", "--limit-deg", "2"),
        (F, "--over", "load"),
        (V, "--over", "flight", *TIMES, "--law", "autopilot", "--limit-deg", "1"),
    ],
    "poles": [(V,), (F,)],
    "boundary": [
        (V,),
        (V, *GUST),
        (F,),
        (V, "--tau-beta", "3"),
        (F, "--tau-beta", "3"),
    ],
    "study": [(V,), (V, "--limit-deg", "0.4", "--gust", "1", "2")],
    "ascent": [(V, "--from", "70", "--to", "71", "--limit-deg", "0.5")],
}
VALUES = {
    "wind": ["rectangular"],
    "duration": ["4.7"],
    "peak_deg": ["3.3"],
    "peak_speed": ["21"],
    "gust": ["1.5 3"],
    "sign": ["tail", "frozen"],
    "winds": [SOUNDING],
    "azimuth_deg": ["77"],
    "dead_band": ["0.4"],
    "capability": ["1.3"],
    "limit_deg": ["1.4"],
    "load_deg": ["3.7"],
    "model": ["drift"],
    "plane": ["yaw"],
    "start": ["-1"],
    "horizon": ["30"],
    "rate_limit_deg": ["0.3"],
    "over": ["load", "flight"],
    "tau_beta": ["5"],
    "design": ["lqr", "half-relief"],
    "natural_frequency": ["1.7"],
    "damping": ["0.9"],
    "attitude_gain": ["1.1"],
    "rate_gain": ["1.1"],
    "delay_ms": ["15"],
    "criteria": ["aircraft"],
    "three_gains": [None],
    "crossover": ["3"],
    "rigid": [None],
    "detuned": [None],
    "box": ["thrust=-2%..2%"],
    "sample_rate": ["40"],
    "engine": ["linear", "planar-varying"],
    "law": ["trim", "dead-band"],
    "limit_shape": ["square"],
    "switch": ["report"],
    "seed": ["3"],
    "time": ["70"],
    "from_": ["69"],
    "to": ["73"],
    "every": ["0.4"],
}
SLOW = ("least", "flown", "varying", "laws")
"""Searches, which `test_least` and the tests of flown margins ask for."""


@pytest.fixture(scope="module", autouse=True)
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("walk")
    (path / F).write_text(STUDY)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(path)
        yield


def options_of(command):
    group = typer.main.get_command(app)
    return {
        param.name: param
        for param in group.commands[command].params
        if param.param_type_name == "option"
    }


@cache
def answer_of(command, arguments):
    result = CliRunner().invoke(app, [command, *arguments, "--json"])
    return result.exit_code, result.stdout, result.stderr


def draws(seed, count):
    at = random.Random(seed)
    for _ in range(count):
        command = at.choice(list(STARTS))
        start = at.choice(STARTS[command])
        option = at.choice([k for k in options_of(command) if k not in (*SHOWN, *SLOW)])
        yield command, start, option, at.choice(VALUES[option])


def given(command, option, value):
    flag = options_of(command)[option].opts[-1]
    return (flag,) if value is None else (flag, *(value.split() if "gust" in option else [value]))


def ignored(command, start, option, value):
    """What is wrong with a draw; nothing where the option counts or is refused."""
    more = given(command, option, value)
    if more[0] in start or (option == "rigid" and start[0] in (V, F)):  # which is rigid anyway
        return ""
    before, after = answer_of(command, start), answer_of(command, (*start, *more))
    messages = [line for line in after[2].splitlines() if line.startswith("Error: ")]
    if after[0] == 2:
        return "" if len(messages) == 1 else f"refused without a sentence: {after[2]}"
    if after[0] not in (0, 1):
        return f"ends with {after[0]}: {after[2]}"
    return "ignored" if before[:2] == after[:2] and before[2] == after[2] else ""


@pytest.mark.parametrize("command", STARTS)
def test_each_option_of_a_command_has_a_value_to_try(command):
    assert options_of(command).keys() <= {*VALUES, *SHOWN, *SLOW}


@pytest.mark.parametrize(
    "count", [1, pytest.param(80, marks=pytest.mark.thorough)], ids=["few", "many"]
)
def test_an_option_changes_the_answer_or_is_refused(count):
    wrong = {
        f"{command} {' '.join((*start, *given(command, option, value)))}: {said}"
        for command, start, option, value in draws(1, count)
        if (said := ignored(command, start, option, value))
    }
    assert not wrong, "\n".join(sorted(wrong))


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("command", "start", "option", "value"),
    [("fly", (*STARTS["fly"][0], "--peak-speed", "21"), "delay_ms", "15")],
)
def test_what_was_once_ignored_counts(command, start, option, value):
    assert not ignored(command, start, option, value)


@pytest.mark.thorough
def test_the_starts_are_answered():
    for command, starts in STARTS.items():
        for start in starts:
            code, out, said = answer_of(command, start)
            assert code in (0, 1), (command, start, said)
            assert json.loads(out)
