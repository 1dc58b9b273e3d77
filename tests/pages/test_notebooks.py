"""Every notebook asks a question, runs to its last cell, and ends with the answer."""

import runpy
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[2] / "notebooks").glob("*.py"))


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(notebook: Path) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    names = runpy.run_path(str(notebook))
    plt.close("all")

    assert names["answer"].endswith(".")


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_opens_with_its_question_and_ends_with_its_answer(notebook: Path) -> None:
    cells = notebook.read_text(encoding="utf-8").split("# %%")[1:]

    assert cells[0].startswith(" [markdown]\n# # ")
    assert "?" in cells[0].split("\n# # ")[1].splitlines()[0]
    assert cells[-1].rstrip().endswith("\nprint(answer)")
