"""The report's figures and sketches: which there are, and writing them with their numbers."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from tvclin import plots
from tvclin.base.files import make_directory, write_text
from tvclin.plots.curves import curves_of
from tvclin.show.reproduce import ledger

if TYPE_CHECKING:
    from control import ControlPlot

FIGURES: dict[str, "Callable[[], ControlPlot]"] = {
    "figure-1": plots.figure_1,
    "sketch-a": plots.sketch_a,
    "figure-2": plots.figure_2,
    "sketch-b": plots.sketch_b,
    "figure-3": plots.figure_3,
    "figure-4": plots.figure_4,
    "figure-5": plots.figure_5,
    "figure-6": plots.figure_6,
    "figure-7": plots.figure_7,
    "figure-8": plots.figure_8,
    "figure-9": plots.figure_9,
    "figure-10": plots.figure_10,
    "figure-11": plots.figure_11,
    "sketch-c": plots.sketch_c,
}
"""Name of the files, and the function that draws them, in the order of the report."""


def write(name: str, output: Path) -> list[Path]:
    """Write a figure as PNG, and as CSV the numbers from which it is drawn.

    Parameters
    ----------
    name : str
        One of `FIGURES`.
    output : Path
        A directory that is there.

    Returns
    -------
    list of Path
        The PNG and the CSV.

    Raises
    ------
    InputError
        When a file cannot be written; each is there whole or not at all.
    """
    plot = FIGURES[name]()
    picture, numbers = output / f"{name}.png", output / f"{name}.csv"
    plots.save_figure(plot, picture)
    write_text(numbers, curves_of(plot).csv())
    return [picture, numbers]


WRITERS: tuple[Callable[[Path], list[Path]], ...] = (
    *(partial(write, name) for name in FIGURES),
    ledger.write_into,
)
"""What `reproduce` writes, in order: each takes the directory and returns the files."""


def reproduce(output: Path, progress: Callable[[float, float], None] | None = None) -> list[Path]:
    """Write everything there is to reproduce of the report into one directory.

    Parameters
    ----------
    output : Path
        The directory; made if it is missing. Files of the same names are replaced.
    progress : callable, optional
        Is told how many of `WRITERS` are done, and how many there are.

    Returns
    -------
    list of Path
        The files, in the order in which they were written.

    Raises
    ------
    InputError
        When a file stands in the directory's place, or something cannot be written.
    """
    make_directory(output)
    written = []
    for done, write_part in enumerate(WRITERS, start=1):
        written += write_part(output)
        if progress is not None:
            progress(done, len(WRITERS))
    return written
