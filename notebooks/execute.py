"""The notebooks: executed and kept small, `make notebooks`; and whether two runs of one agree.

The text, `01_poles.py` and so on, is the source. What stands beside it, `01_poles.ipynb`, is
written from it with its outputs, so that it can be read where it cannot be run.
"""

import base64
import io
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent
COLOURS = 64
"""So many are kept of a figure: it looks the same, in a third of the bytes."""
ROUNDING = 1e-9
"""Relative, what processors may differ by; and what a number of order one leaves at zero."""

_FORGET = "get_ipython().reset(); get_ipython().execution_count = 1"
"""Lets a kernel be as at its beginning, but for the modules that it has loaded."""
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")


def sources() -> list[Path]:
    """Return the notebooks as text, in their order."""
    return sorted(FOLDER.glob("[0-9]*.py"))


def cells_of(source: Path) -> Any:
    """Return a notebook without outputs, with what Jupyter needs to open it and no more."""
    import jupytext
    from nbformat import NotebookNode

    notebook = jupytext.read(source, fmt="py:percent")
    notebook.metadata = NotebookNode(
        kernelspec=notebook.metadata.kernelspec, language_info=NotebookNode(name="python")
    )
    for number, cell in enumerate(notebook.cells):
        cell.id = f"cell-{number}"  # else a new one at random each time
    return notebook


@contextmanager
def kernel() -> Iterator[Callable[[Path], Any]]:
    """Give what executes notebooks, one after another, each as if it were the first.

    One kernel runs them all, which takes seconds to begin; it forgets all names in between.

    Yields
    ------
    callable
        Takes the text of a notebook and returns the notebook with its outputs, without times and
        with small figures; raises `nbclient.exceptions.CellExecutionError` when a cell fails.
    """
    from nbclient import NotebookClient
    from nbformat import NotebookNode
    from nbformat.v4 import new_code_cell, new_notebook

    client: Any = NotebookClient(
        new_notebook(),
        timeout=600,
        kernel_name="python3",
        record_timing=False,
        coalesce_streams=True,
    )

    def executed(source: Path) -> Any:
        notebook = cells_of(source)
        whole = [new_code_cell(_FORGET), *notebook.cells]
        client.nb = NotebookNode(notebook | {"cells": whole})
        client.reset_execution_trackers()
        for number, cell in enumerate(whole):
            client.execute_cell(cell, number)
        notebook.metadata.language_info = {"name": "python"}  # else with the version that ran it
        for cell in notebook.cells:
            for output in cell.get("outputs", []):
                reduce(output.get("data", {}))
        return notebook

    with client.setup_kernel():
        yield executed


def reduce(data: dict[str, str]) -> None:
    """Keep a table or a figure and not also its text, and of a figure few colours."""
    if "text/html" in data or "image/png" in data:
        data.pop("text/plain", None)
    if "image/png" in data:
        from PIL import Image

        picture = Image.open(io.BytesIO(base64.b64decode(data["image/png"]))).convert("RGB")
        small = io.BytesIO()
        most = Image.Quantize.MAXCOVERAGE  # keeps the colour of thin lines
        picture.quantize(COLOURS, most, dither=Image.Dither.NONE).save(small, "png", optimize=True)
        data["image/png"] = base64.b64encode(small.getvalue()).decode("ascii")


def texts(cell: Any) -> list[str]:
    """Return what a cell prints and answers, without its figures and warnings."""
    found = []
    for output in cell.get("outputs", []):
        data = output.get("data", {})
        if output.output_type == "stream" and output.name == "stdout":
            found.append(output.text)
        elif "image/png" not in data:
            found += [data[kind] for kind in ("text/html", "text/plain") if kind in data]
    return found


def differences(stored: Any, new: Any) -> list[str]:
    """Return where two runs of one notebook do not say the same.

    Words are the same to the letter. A number may differ by one in the last digit that is shown, by
    `ROUNDING`, and by what its cell allows with a tag: "within 1e-3", the relative error that the
    method states (of what minimises a peak, the root of that of the peak); "rounding", a cell that
    shows rounding itself, of which words alone count.

    Parameters
    ----------
    stored, new : nbformat.NotebookNode
        Of the same source.
    """
    found = []
    for number, (old, fresh) in enumerate(zip(stored.cells, new.cells, strict=True)):
        tags = old.metadata.get("tags", [])
        error = max([float(tag[7:]) for tag in tags if tag.startswith("within ")], default=0.0)
        before, after = "\n".join(texts(old)), "\n".join(texts(fresh))
        if not agree(before, after, inf if "rounding" in tags else error):
            found.append(f"cell {number}: stored {before!r}, now {after!r}")
    return found


def agree(stored: str, new: str, error: float = 0.0) -> bool:
    """Tell whether two texts are the same but for their numbers, and these nearly so.

    Parameters
    ----------
    stored, new : str
        The texts; white space does not count.
    error : float
        Relative error of the numbers beyond rounding and the last digit; infinite: any number.
    """
    words = [re.sub(r"\s", "", _NUMBER.sub("#", text)) for text in (stored, new)]
    if words[0] != words[1]:
        return False
    pairs = zip(_NUMBER.findall(stored), _NUMBER.findall(new), strict=True)
    return all(
        abs(float(one) - float(other))
        <= 1.001 * max(_last_digit(one), _last_digit(other))
        + (ROUNDING + error) * max(abs(float(one)), abs(float(other)))
        + ROUNDING
        for one, other in pairs
    )


def _last_digit(number: str) -> float:
    """What one in the last digit of a number as printed is worth; nothing if it is whole."""
    mantissa, _, power = number.lower().partition("e")
    decimals = mantissa.partition(".")[2]
    if not decimals and not power:
        return 0.0
    return float(10.0 ** (int(power or 0) - len(decimals)))


def write(chosen: list[Path]) -> Iterator[Path]:
    """Execute notebooks and write them beside their sources; give each file as it is written."""
    import nbformat

    with kernel() as executed:
        for source in chosen:
            path = source.with_suffix(".ipynb")
            path.write_text(nbformat.writes(executed(source), indent=1) + "\n", encoding="utf-8")
            yield path


if __name__ == "__main__":
    for written in write([Path(name) for name in sys.argv[1:]] or sources()):
        sys.stdout.write(f"{written}\n")
