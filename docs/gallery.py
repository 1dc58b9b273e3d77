"""The gallery: every figure of the report, and the package's own, each beside its numbers."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import tvclin as tv

PEAK, DURATION = np.radians(5.0), 7.5
"""The wind of the package's own figures [rad], [s]."""


@dataclass(frozen=True)
class Figure:
    """One figure.

    Attributes
    ----------
    name : str
        Name of its files.
    words : str
        What it shows, in a sentence.
    draw : callable
        Draws it.
    call : str
        How a reader draws it.
    """

    name: str
    words: str
    draw: Callable[[], Any]
    call: str


def of_the_report() -> list[Figure]:
    """Return the figures that `tvclin reproduce` writes."""
    from tvclin.show.reproduce import FIGURES

    return [
        Figure(name, "", draw, f"tv.plots.{getattr(draw, '__name__', name)}()")
        for name, draw in FIGURES.items()
    ]


def of_the_package() -> list[Figure]:
    """Return the figures of the command line, for configuration I and one wind."""
    vehicle = tv.load_vehicle("configuration-i")
    exact = tv.Plant.from_vehicle(vehicle, "drift-exact")
    c, wind, plots = exact.coefficients, tv.TriangularWind(peak=PEAK, duration=DURATION), tv.plots
    gains = tv.design_gains(c, natural_frequency=1.5, damping=0.7)
    servo = tv.Actuator(natural_frequency=25.1, damping=0.7)
    autopilot = replace(gains, actuator=servo, delay=0.02)
    study = tv.Study.from_vehicle(vehicle, duration=DURATION, peak=PEAK, limit=np.radians(0.45))
    return [
        Figure(
            "study",
            "How much deflection winds of 5 degrees need, over their duration, and the limit in"
            " question.",
            lambda: plots.study_chart(study),
            "tvclin study --plot",
        ),
        Figure(
            "boundary",
            "The boundary limit with drift, rectangular and triangular winds.",
            lambda: plots.boundary_chart(coefficients=c),
            "tvclin boundary --plot",
        ),
        Figure(
            "poles",
            "The poles of the four models, and the residues at them.",
            lambda: plots.pole_map(c),
            "tvclin poles --plot",
        ),
        Figure(
            "respond",
            "The exact response on the boundary, dead band 0.5.",
            lambda: _response(exact, wind),
            "tvclin respond --plot",
        ),
        Figure(
            "autopilot",
            "Deflection that an autopilot needs, beside trim, the boundaries and the minimum.",
            lambda: plots.comparison_chart(tv.compare_with_trim(exact, autopilot, wind)),
            "tv.plots.comparison_chart(tv.compare_with_trim(plant, autopilot, wind))",
        ),
        Figure(
            "wind",
            "The same autopilot in that wind: angles, deflection, wind.",
            lambda: plots.wind_chart(autopilot, exact, wind),
            "tv.plots.wind_chart(autopilot, plant, wind)",
        ),
        Figure(
            "step",
            "The same autopilot after a step of its command.",
            lambda: plots.step_chart(autopilot, exact),
            "tv.plots.step_chart(autopilot, plant)",
        ),
        Figure(
            "nichols",
            "Its loop in a Nichols chart, with the box of the criteria.",
            lambda: plots.nichols_chart(autopilot, exact),
            "tvclin margins --plot",
        ),
        Figure(
            "bode",
            "Its loop against frequency, with both gain margins.",
            lambda: plots.bode_chart(autopilot, exact),
            "tvclin margins --chart bode --plot",
        ),
        Figure(
            "nyquist",
            "Its Nyquist curve: the whole, and the surroundings of -1.",
            lambda: plots.nyquist_chart(autopilot, exact),
            "tvclin margins --chart nyquist --plot",
        ),
        Figure(
            "root-locus",
            "Where the closed-loop poles go when a factor multiplies the loop gain.",
            lambda: plots.root_locus_chart(autopilot, exact),
            "tvclin margins --chart root-locus --plot",
        ),
        *_of_a_flexible_vehicle(),
    ]


def _of_a_flexible_vehicle() -> list[Figure]:
    structure, plots = tv.load_vehicle("made-up-booster").structure, tv.plots
    vehicle = tv.load_vehicle("made-up-booster")
    plant = tv.FlexiblePlant.from_vehicle(vehicle, structure, model="drift-exact")
    autopilot = tv.Autopilot(
        attitude_gain=0.36,
        rate_gain=0.56,
        delay=0.02,
        actuator=tv.Actuator(natural_frequency=22.0, damping=0.8),
        filters=(tv.vehicle.Filter.low_pass(13.0, 0.95), tv.vehicle.Filter.notch(32.0, 0.06, 0.6)),
    )
    return [
        Figure(
            "bode-flexible",
            "The loop of a vehicle that bends and sloshes, sampled at 25 Hz, with each mode and its"
            " margin.",
            lambda: plots.bode_chart(replace(autopilot, sample_rate=25.0), plant),
            "tv.plots.bode_chart(autopilot, flexible_plant)",
        ),
        Figure(
            "root-locus-flexible",
            "Where its modes go with the loop gain.",
            lambda: plots.root_locus_chart(autopilot, plant),
            "tv.plots.root_locus_chart(autopilot, flexible_plant)",
        ),
    ]


def _response(plant: tv.Plant, wind: tv.TriangularWind) -> Any:
    limit = tv.boundary_limit(plant, wind, dead_band=0.5).deflection
    held = tv.trim_then_hold(plant, wind, limit, dead_band=0.5)
    response = tv.attitude_responses(plant, held, wind, np.linspace(0.0, 15.0, 601))
    words = "triangular wind of 5 deg and 7.5 s, drift-exact, K = 0.5, on the boundary"
    curves = tv.plots.response_curves(response, "respond", words, deflection=held, wind=wind)
    return tv.plots.response_chart(curves, "Exact response on the boundary, K = 0.5")


def write(folder: Path) -> str:
    """Draw all figures that are older than the package, and return the page that shows them.

    Parameters
    ----------
    folder : Path
        Of the figures, beside the page; made if it is missing.

    Returns
    -------
    str
        The page, in Markdown.
    """
    folder.mkdir(parents=True, exist_ok=True)
    parts = {"The report's figures": of_the_report(), "The package's own": of_the_package()}
    for figures in parts.values():
        for one in figures:
            if _is_old(folder / f"{one.name}.png"):
                _draw(one, folder)
    return "\n".join(_lines(parts, folder))


def _lines(parts: dict[str, list[Figure]], folder: Path) -> Iterator[str]:
    yield from ("# Gallery", "")
    yield "`tvclin reproduce` writes the report's figures as PNG, with their numbers as CSV. All"
    yield "are drawn in one style: lines stay apart in grey print, and units stand on the axes."
    for heading, figures in parts.items():
        yield from ("", f"## {heading}")
        for one in figures:
            yield from ("", f"### {one.name}", "", f"{one.words} `{one.call}`".strip(), "")
            yield f"![{one.words or one.name}](figures/{one.name}.png)"
            if (folder / f"{one.name}.csv").exists():
                yield from ("", f"{{download}}`Its numbers <figures/{one.name}.csv>` (CSV)")
    yield from ("", "What five laws with limits need is drawn in [](../laws.md).", "")


def _is_old(picture: Path) -> bool:
    sources = [*Path(tv.__file__).parent.rglob("*.py"), Path(__file__)]
    newest = max(source.stat().st_mtime for source in sources)
    return not picture.exists() or picture.stat().st_mtime < newest


def _draw(one: Figure, folder: Path) -> None:
    from tvclin.base.files import write_text

    plot = one.draw()
    curves = getattr(plot, "curves", None)
    if curves is not None:
        write_text(folder / f"{one.name}.csv", curves.csv())
    tv.plots.save_figure(plot, folder / f"{one.name}.png")
