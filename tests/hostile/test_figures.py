"""Whatever a figure is given, it is drawn, or one sentence says what is wrong."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any
from zlib import crc32

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

import tvclin as tv
from tests.doors import Door, Rude, hostile
from tests.figure_doors import figures
from tests.hostile.test_arguments import complaint
from tvclin import plots

mpl.use("Agg")
FIGURES = {name for name in plots.__all__ if callable(getattr(plots, name))}
VALUES = {"text": "x", "object": object(), "rude": Rude(), "nan": np.nan, "table": {"a": 1}}


@pytest.fixture(autouse=True)
def no_figure_stays_open() -> Any:
    """Close what was drawn."""
    yield
    plt.close("all")


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files with the names of hostile values are nobody's."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def every(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Door]:
    return figures(tmp_path_factory.mktemp("figures"))


def arguments(name: str) -> dict[str, inspect.Parameter]:
    """Return the named parameters of a figure."""
    known = inspect.signature(getattr(plots, name)).parameters
    return {
        key: one
        for key, one in known.items()
        if one.kind not in {one.VAR_KEYWORD, one.VAR_POSITIONAL}
    }


@pytest.mark.thorough
@pytest.mark.parametrize("name", sorted(FIGURES))
def test_what_a_figure_cannot_be_drawn_of_is_refused_in_one_sentence(name: str) -> None:
    """Each value in place of all that a figure needs; of one that needs nothing, of each option."""
    known = arguments(name)
    needed = [key for key, one in known.items() if one.default is one.empty]
    for value in VALUES.values():
        for group in [needed] if needed else [[key] for key in known]:
            with pytest.raises(tv.InputError) as refused:
                getattr(plots, name)(**dict.fromkeys(group, value))
            assert "\n" not in str(refused.value)


@pytest.mark.thorough
def test_a_figure_is_saved_under_a_name_that_is_a_text(tmp_path: Path) -> None:
    plots.save_figure(plots.sketch_a(), str(tmp_path / "a.png"))
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.thorough
def test_every_public_figure_has_its_door_with_each_argument(every: dict[str, Door]) -> None:
    assert {name for name in every if "." not in name} == FIGURES
    for name in FIGURES:
        assert set(arguments(name)) <= set(every[name].good), name
        every[name].call(**every[name].good)
        plt.close("all")


@pytest.mark.thorough
@pytest.mark.parametrize("what", sorted(hostile()))
def test_a_hostile_value_is_drawn_or_refused_in_one_sentence(
    every: dict[str, Door], what: str
) -> None:
    """Each value at one argument in four."""
    value = hostile()[what]
    pairs = [
        (name, argument)
        for name, door in every.items()
        for argument in door.good
        if not (argument == "flights" and callable(value))
        and crc32(f"{name} {argument} {what}".encode()) % 4 == 0
    ]
    said = {pair: complaint(pair[0], every[pair[0]], pair[1], value) for pair in pairs}
    assert not {pair: one for pair, one in said.items() if one}


def test_an_odd_number_of_panels_is_drawn() -> None:
    plot = plots.figure_5([2.0, 4.0], (1.0, 0.5, 0.25))
    assert [axes.get_visible() and axes.axison for axes in plot.axes.flat] == [True] * 3 + [False]


def test_an_array_without_axes_names_no_files() -> None:
    with pytest.raises(tv.InputError, match=r"source must be .*; got array\(5\)"):
        tv.read_soundings(np.array(5))
