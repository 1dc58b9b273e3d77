"""Whatever a public name is given, it answers, or says in one sentence what is wrong."""

from __future__ import annotations

import inspect
import os
import random
import re
import secrets
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
import pytest

import tvclin as tv
from tests.clock import Endless, ending
from tests.doors import ANSWERS, BARE, INSIDE, NO_CALLS, TOLD, Door, doors, flaws, hostile, public
from tvclin.flights.theory_comparison import NOT_KNOWN
from tvclin.winds.wind_angles import BEYOND_LINEAR

for extra in ("ipywidgets", "jinja2", "jsbsim", "latex2mathml", "pyarrow"):
    pytest.importorskip(extra)

MORE = int(os.environ.get("TVCLIN_HOSTILE", "0"))
"""As of the other search: so many at random."""
LONGEST_SENTENCE = 400
CALLED = ("__call__", "__getitem__")
FUNCTIONS = ("rule", "engine", "shape", "progress", "winds")
"""A function in place of another raises what it raises."""


@pytest.fixture(scope="module")
def every(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Door]:
    return doors(tmp_path_factory.mktemp("doors"))


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files with the names of hostile values are nobody's."""
    monkeypatch.chdir(tmp_path)


def complaint(name: str, door: Door, argument: str, value: Any) -> str | None:
    """Return what is wrong with the answer to one argument; None if nothing is."""
    try:
        with ending(), warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # the package's own, which are shown
            answer = door.call(**(door.good | {argument: value}))
            repr(answer)
            lost = set(flaws(answer)) - set(TOLD.get(name, ()))
            lost = lost and lost - set(flaws(door.call(**door.good)))
    except tv.InputError as error:
        said = str(error)
        good = 0 < len(said) < LONGEST_SENTENCE and "\n" not in said
        return None if good else f"its message is no short sentence: {said[:500]!r}"
    except (Exception, Endless) as error:
        return f"{type(error).__name__}: {str(error)[:200]}"
    return f"a silent NaN in {sorted(lost)}" if lost and not beyond(answer) else None


def beyond(answer: Any) -> bool:
    """Whether a record says that its wind is beyond linear aerodynamics: its NaN is the answer."""
    said = (str(getattr(answer, name, "")) for name in ("beyond", "notes", "verdict"))
    return any(BEYOND_LINEAR in one for one in said) or getattr(answer, "status", "") == NOT_KNOWN


DIRECTIONS = {"attitude", "azimuth", "flight_path_angle", "heading", "latitude", "rotation"} | {
    ("PlaneWind.towards", "angle"), ("PlaneWind.veering", "angle"),
}  # fmt: skip
"""Angles that may be up to a turn; all others are within 90 degrees."""
BEYOND = {
    ("BangBang", "limit"), ("ConstantDeflection", "limit"), ("compare_flight", "boundary"),
    ("fly_turbulence", "rate_limit"), ("fly_turbulence_along", "rate_limit"),
    ("fly_along", "rate_limit"), ("fly_many", "rate_limit"), ("fly_many_along", "rate_limit"),
    ("total_deflection", "dispersion"), ("total_deflection", "wind"),
    ("Nozzle", "travel_limit"),
}  # fmt: skip
"""What the package has computed may be more, where the trim of a wind takes more; a limit that is
never reached; rates; and a travel, which is a sum."""


def angles(call: Any) -> set[str]:
    """Return the arguments of which a docstring says that they are in radians."""
    said = inspect.getdoc(call) or ""
    result = re.search(r"(?:Parameters|Attributes)\n-+\n(.*?)(?:\n\n\w+\n-+\n|\Z)", said, re.DOTALL)
    rows = re.findall(
        r"^(\w[\w, ]*?) : [^\n]*\n((?:    .*\n?|\n)*)", result[1] if result else "", re.M
    )
    return {
        name for names, description in rows if "[rad]" in description for name in names.split(", ")
    }


@pytest.mark.thorough
def test_an_angle_that_was_meant_in_degrees_is_refused(every: dict[str, Door]) -> None:
    """4 rad of a deflection or a wind, 7 rad of a direction: of every public function."""
    request, taken, known = 0, [], public()
    for name, door in every.items():
        first, _, method = name.partition(".")
        called = getattr(known[first], method) if method else known[first]
        for argument in angles(called) & set(door.good):
            turns = argument in DIRECTIONS or (name, argument) in DIRECTIONS
            value = np.full(np.shape(door.good[argument]), 7.0 if turns else 4.0)[()]
            request += 1
            try:
                door.call(**(door.good | {argument: value}))
                taken.append((name, argument))
            except tv.InputError:
                pass
    assert request > 40
    assert set(taken) == BEYOND


def test_every_public_name_has_its_door(every: dict[str, Door]) -> None:
    others = ANSWERS | INSIDE | NO_CALLS
    assert {name for name in every if "." not in name} | others == set(public())
    assert not others & set(every)


def test_every_public_method_has_its_door(every: dict[str, Door]) -> None:
    for name, kind in public().items():
        if not inspect.isclass(kind):
            continue
        for method, what in vars(kind).items():
            call = getattr(what, "__func__", what)
            if not inspect.isfunction(call) or (method[0] == "_" and method not in CALLED):
                continue
            if method in BARE or len(inspect.signature(call).parameters) < 2:
                continue
            assert f"{name}.{method}" in every


def test_every_argument_of_a_door_is_tried(every: dict[str, Door]) -> None:
    for name, door in every.items():
        known = inspect.signature(door.call).parameters.values()
        request = {
            one.name for one in known if one.kind not in {one.VAR_KEYWORD, one.VAR_POSITIONAL}
        }
        assert request <= set(door.good), name


@pytest.mark.thorough
def test_every_door_opens_to_its_good_call(every: dict[str, Door]) -> None:
    for name, door in every.items():
        try:
            door.call(**door.good)
        except tv.InputError as error:
            pytest.fail(f"{name}: {error}")


@pytest.mark.parametrize(
    "by_turns",
    [True, pytest.param(False, marks=pytest.mark.thorough)],
    ids=["by turns", "the rest"],
)
@pytest.mark.parametrize("what", sorted(hostile()))
def test_a_hostile_value_is_answered_or_refused_in_one_sentence(
    every: dict[str, Door], what: str, by_turns: bool
) -> None:
    """Of all pairs of a value and an argument one in 144, and the rest, with values by default."""
    value = hostile()[what]

    def in_turn(name: str, door: Door, argument: str) -> bool:
        request = inspect.signature(door.call).parameters.get(argument)
        usual = request is not None and request.default is value
        return not usual and crc32(f"{name} {argument} {what}".encode()) % 144 == 0

    pairs = [
        (name, argument)
        for name, door in every.items()
        for argument in door.good
        if not (argument in FUNCTIONS and callable(value))
        and in_turn(name, door, argument) == by_turns
    ]
    said = {pair: complaint(pair[0], every[pair[0]], pair[1], value) for pair in pairs}
    assert not {pair: one for pair, one in said.items() if one}


def test_so_is_any_number_and_any_text(every: dict[str, Door]) -> None:
    seed = secrets.randbits(32) if MORE else 5  # of a search another one; the message says which
    drawn = random.Random(seed)
    for _ in range(MORE or 100):
        name = drawn.choice(sorted(every))
        argument = drawn.choice(sorted(every[name].good))
        value = drawn.choice(DRAWS)(drawn)
        said = complaint(name, every[name], argument, value)
        assert said is None, f"seed {seed}: {name}({argument}={value!r}): {said}"


def size(drawn: random.Random) -> float:
    """Return a number of any size, of both signs."""
    return drawn.choice((-1.0, 1.0)) * 10.0 ** drawn.uniform(-320.0, 308.0)


DRAWS: tuple[Callable[[random.Random], Any], ...] = (
    size,
    lambda drawn: int(size(drawn)),
    lambda drawn: drawn.randint(-20, 20),
    lambda drawn: [size(drawn) for _ in range(drawn.randint(0, 5))],
    lambda drawn: complex(size(drawn), size(drawn)),
    lambda drawn: "".join(chr(drawn.randint(0, 0xD7FF)) for _ in range(drawn.randint(0, 20))),
)


@pytest.mark.parametrize("depth", [20, 300, 900, 5000])
@pytest.mark.parametrize("key", ["vehicle", "schedule", "study", "campaign", "wind", "size", "x"])
def test_a_file_of_tables_in_tables_is_refused_in_one_sentence(
    key: str, depth: int, tmp_path: Path
) -> None:
    file = tmp_path / "deep.toml"
    loads = (tv.load_vehicle, tv.load_schedule, tv.load_study, tv.studyfile.load_sizing)
    loads += (tv.studyfile.load_campaign,)
    deep = "[" * depth + "]" * depth, "{a=" * depth + "1" + "}" * depth
    for text in (
        *(f"{key} = {one}\n" for one in deep),
        *(f"[{key}]\nname = {one}\n" for one in deep),
    ):
        file.write_text(text)
        for load in loads:
            said = complaint(
                "file", Door(load, {}), next(iter(inspect.signature(load).parameters)), file
            )
            assert said is None, f"{load.__name__}: {said}"
