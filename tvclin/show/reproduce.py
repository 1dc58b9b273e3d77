"""The report's figures and sketches, each with its numbers and its differences from the print."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from tvclin import plots
from tvclin.base.files import make_directory, write_text
from tvclin.plots.curves import curves_of

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

DIFFERENCES = {
    "figure-2": "it shows (7) and (12); the text says (8), which is a definition, and (12)",
    "figure-5": "it shows (12) and (18), for the text's (17) is a transform; at tau beta = 20 drift"
    " takes 14.7 (I) and 15.8 percent (II) off the boundary, where the text says 24",
    "figures 6 to 9": "they show (B9) corrected, which as printed is not the inverse transform of"
    " (B8)",
    "figures 6 to 11": "their flights are flown here; those of 1968 are not printed as numbers",
    "sketch-c": "the form printed for large y, (y - 1)/(2 y), is not a solution of (C6)",
}
"""Differences of figures and their numbers from the print, by figure."""


def reproduce(output: Path, progress: Callable[[float, float], None] | None = None) -> list[Path]:
    """Write every figure as PNG, and as CSV the numbers from which it is drawn; return the files.

    `output`: directory of the files, made if it is missing; files of the same names are replaced,
    and each is complete or absent. `progress` receives the number of finished figures and of all
    figures.
    """
    make_directory(output)
    written = []
    for done, (name, figure) in enumerate(FIGURES.items(), start=1):
        picture, numbers = output / f"{name}.png", output / f"{name}.csv"
        plot = figure()
        plots.save_figure(plot, picture)
        write_text(numbers, curves_of(plot).csv())
        written += [picture, numbers]
        if progress is not None:
            progress(done, len(FIGURES))
    return written
