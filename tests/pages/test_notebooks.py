"""Every notebook asks, runs to its answer, and says what the stored one beside it says."""

import base64
import io
import os
from collections.abc import Callable, Iterator
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image

from tvclin.plots.style import COLOURS

ROOT = Path(__file__).parents[2]
SOURCES = sorted((ROOT / "notebooks").glob("[0-9]*.py"))
QUICK = ("03_edge_of_stability",)
"""Which a usual run executes; a thorough one all."""
every = pytest.mark.parametrize("source", SOURCES, ids=lambda path: path.stem)


@pytest.fixture(scope="module")
def notebooks() -> Iterator[ModuleType]:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "notebooks")
        yield import_module("execute")


@pytest.fixture(scope="module")
def executed(notebooks: ModuleType) -> Iterator[Callable[[Path], Any]]:
    path = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", os.pathsep.join(path))
        with notebooks.kernel() as run:
            yield run


@cache
def stored(source: Path):
    import nbformat  # late: it takes seconds, and only who runs these tests needs it

    return nbformat.read(source.with_suffix(".ipynb"), as_version=4)


@pytest.mark.parametrize(
    "source",
    [pytest.param(s, marks=() if s.stem in QUICK else pytest.mark.thorough) for s in SOURCES],
    ids=lambda path: path.stem,
)
def test_a_notebook_says_what_it_said_when_it_was_stored(
    notebooks: ModuleType, executed: Callable[[Path], Any], source: Path
) -> None:
    new = executed(source)

    said = [o for cell in new.cells for o in cell.get("outputs", [])]
    warned = [o.text for o in said if o.output_type == "stream" and o.name == "stderr"]
    assert all("without numba" in text or "a kernel was compiled" in text for text in warned)
    assert notebooks.texts(new.cells[-1])[-1].rstrip().endswith(".")
    if "find_spec" in source.read_text(encoding="utf-8") and not find_spec("jsbsim"):
        pytest.skip("it was stored with JSBSim, which is not here")
    assert notebooks.differences(stored(source), new) == []


@every
def test_a_stored_notebook_is_made_of_its_source(notebooks: ModuleType, source: Path) -> None:
    shown, text = stored(source), notebooks.cells_of(source)

    assert [cell.source for cell in shown.cells] == [cell.source for cell in text.cells]
    assert [cell.metadata for cell in shown.cells] == [cell.metadata for cell in text.cells]
    assert set(shown.metadata) == {"kernelspec", "language_info"}


@every
def test_a_stored_notebook_is_small_and_shows_no_machine_and_no_address(
    notebooks: ModuleType, source: Path
) -> None:
    raw = source.with_suffix(".ipynb").read_text(encoding="utf-8")
    said = "\n".join(text for cell in stored(source).cells for text in notebooks.texts(cell))

    assert len(raw) < 300_000
    assert " at 0x" not in said
    for part in ("/tmp/", "/home/", "/Users/", str(Path.home()), str(ROOT)):
        assert part not in said


@every
def test_a_notebook_has_its_question_an_equation_a_picture_something_to_try_and_an_answer(
    source: Path,
) -> None:
    cells = stored(source).cells
    words = "\n".join(cell.source for cell in cells if cell.cell_type == "markdown")
    shown = [o.get("data", {}) for cell in cells for o in cell.get("outputs", [])]

    assert cells[0].source.startswith("# ")
    assert "?" in cells[0].source.splitlines()[0]
    assert "$$" in words
    assert any("image/png" in data for data in shown)
    assert "**Try:**" in words
    assert cells[-1].source.endswith("\nprint(answer)")


def test_thin_lines_keep_their_colours_when_a_figure_is_made_small(notebooks: ModuleType) -> None:
    shades = np.linspace(0, 255, 200)[:, None, None] * np.ones((1, 200, 3))
    for row, colour in enumerate(COLOURS):
        shades[20 * row] = 255.0 * np.array(to_rgb(colour))
    raw = io.BytesIO()
    Image.fromarray(shades.astype(np.uint8)).save(raw, "png")
    data = {"image/png": base64.b64encode(raw.getvalue()).decode(), "text/plain": "<Figure>"}
    notebooks.reduce(data)
    small = np.asarray(Image.open(io.BytesIO(base64.b64decode(data["image/png"]))).convert("RGB"))

    assert set(data) == {"image/png"}
    # 64 colours over the whole range are 4 apart in each channel if they are grey
    assert np.abs(small - shades.astype(int)).max() <= 12


def test_there_is_a_stored_notebook_for_each_source_and_no_other() -> None:
    assert {path.stem for path in (ROOT / "notebooks").glob("*.ipynb")} == {s.stem for s in SOURCES}


@pytest.mark.parametrize(
    ("one", "other", "error"),
    [
        ("0.356 deg", "0.357 deg", 0.0),  # one in the last digit
        ("[0.1  -2e-17]", "[ 0.1 3e-18]", 0.0),  # rounding
        ("0.68873339", "0.68900000", 1e-3),
        ("4000 cases", "4000 cases", 0.0),
        ("off by 2.9e+01", "off by 7.5e+03", float("inf")),
    ],
)
def test_numbers_agree_within_what_is_shown_and_what_is_allowed(
    notebooks, one, other, error
) -> None:
    assert notebooks.agree(one, other, error)


@pytest.mark.parametrize(
    ("one", "other", "error"),
    [
        ("0.356 deg", "0.358 deg", 0.0),
        ("0.356 deg", "-0.356 deg", 0.0),
        ("0.356 deg", "0.356 rad", float("inf")),
        ("4000 cases", "4001 cases", 0.0),
        ("1, 2", "1, 2, 3", 0.0),
        ("0.68873339", "0.69500000", 1e-3),
        ("True", "False", float("inf")),
        ("0.5", "nan", 0.0),
    ],
)
def test_what_is_different_is_told(notebooks, one, other, error) -> None:
    assert not notebooks.agree(one, other, error)
