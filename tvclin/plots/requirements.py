"""Required deflection over the flight time, and the fraction of soundings over the limit."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tvclin.base.errors import InputError, instance, limit_angle
from tvclin.base.lines import plural
from tvclin.ensembles.availability.availability_record import Availability
from tvclin.plots.curves import Column, Curves
from tvclin.plots.style import COLOURS, INK, LINES, WARM, Look, Style, called, cycle, draw
from tvclin.requirement.flight.deflection_use import DeflectionUse
from tvclin.requirement.flight.sizing import Sizing
from tvclin.requirement.required_quantity import MINIMUM, NO_FORECAST, TRIM, Requirement, heading_of
from tvclin.vehicle.coefficients import PLANE_TEXTS

if TYPE_CHECKING:
    from control import ControlPlot


_LIMIT = "available limit"
_MARKS = {"head": "^", "tail": "v", "cross": "x"}
_COLOURS = tuple(colour for colour in COLOURS if colour != WARM)  # that of the limit


def sizing_chart(sizing: Sizing, limit: float | None = None, name: str = "") -> "ControlPlot":
    """Draw the required deflections over the flight time, and the available deflection.

    Lines are for parameters frozen at each flight time; rings, if the sizing has them, for
    parameters that vary during the wind; triangles for head and tail winds.

    Parameters
    ----------
    sizing : Sizing
        Sizing at two or more flight times; of several winds the worst counts at each.
    limit : float, optional
        Available deflection [rad].
    name : str
        Name of a vehicle without one.

    Raises
    ------
    InputError
        For a sizing of one flight time.
    """
    instance("sizing", sizing, Sizing, "see size")
    if sizing.times.size < 2:
        raise InputError("a figure over the flight needs two or more flight times; got 1")
    order = np.argsort(sizing.times)
    rows = {
        heading_of(requirement.label): np.degrees(sizing.at_times(requirement))[order]
        for requirement in sizing.required
    }
    columns = [Column(label, row, "deg") for label, row in rows.items() if np.isfinite(row).any()]
    styles = _styles(sizing)
    if limit is not None:
        largest = np.degrees(limit_angle(limit, "limit"))
        columns.append(Column(_LIMIT, np.full(order.size, largest), "deg"))
        styles[_LIMIT] = {"color": WARM, "ls": "-", "lw": 1.4}
    winds = sizing.winds[0] if len(sizing.winds) == 1 else f"the worst of {len(sizing.winds)} winds"
    words = f"{sizing.model}, {PLANE_TEXTS[sizing.plane]}, {winds}"
    curves = Curves("sizing", words, "flight time [s]", sizing.times[order], tuple(columns))
    top = 1.05 * max(float(np.nanmax(column.values)) for column in columns)
    title = called(sizing.schedule.vehicle.name or name, f"required deflection: {words}")
    both = "lines: vehicle frozen\nmarks: vehicle varying" if sizing.freezing_error else ""
    limits = {"": (0.0, top or 1.0)}
    return draw(curves, Look(title, "deflection [deg]", styles, legend=both, limits=limits))


def _styles(sizing: Sizing) -> dict[str, Style]:
    """Return the line style of each requirement of a sizing, by its heading.

    The colour is the same for frozen and varying parameters and for all directions of the wind.
    Requirements are trim, each dead band K, the bound without a forecast, and the minimum.
    """
    bands = [Requirement(dead_band=K) for K in sizing.dead_bands]
    colours = dict(zip([TRIM, NO_FORECAST, MINIMUM, *bands], (INK, *cycle(_COLOURS)), strict=False))
    lines = dict(zip([TRIM, *bands, NO_FORECAST, MINIMUM], cycle(LINES), strict=False))
    styles: dict[str, Style] = {}
    for requirement in sizing.required:
        kind = replace(requirement, varying=False, direction="")
        style: Style = {"color": colours[kind], "lw": 1.8, "ls": lines[kind]}
        if requirement.direction:
            style |= {"ls": "", "marker": _MARKS[requirement.direction], "ms": 4.5}
        elif requirement.varying:
            style |= {"ls": "", "marker": "o", "ms": 4.5, "mfc": "none"}
        styles[heading_of(requirement.label)] = style
    return styles


def deflection_use_chart(use: DeflectionUse, name: str = "") -> "ControlPlot":
    """Draw required, used and remaining deflection over the flight time, and the limit.

    Parameters
    ----------
    use : DeflectionUse
        Deflections by flight time, see `deflection_use`.
    name : str
        Name of the vehicle.
    """
    instance("use", use, DeflectionUse, "see deflection_use")
    rows = use.by_heading
    columns = [Column(heading, np.degrees(values), "deg") for heading, values in rows.items()]
    columns.append(Column(_LIMIT, np.full(use.times.size, np.degrees(use.limit)), "deg"))
    styles: dict[str, Style] = {
        heading: {"color": colour, "lw": 1.6, "ls": line}
        for heading, colour, line in zip(rows, cycle(_COLOURS), cycle(LINES), strict=False)
    }
    styles |= {
        "used": {"color": INK, "lw": 2.0},
        "remaining": {"color": "0.45", "lw": 2.0},
        _LIMIT: {"color": WARM, "lw": 1.4},
    }
    words = "required, used and remaining deflection"
    curves = Curves("deflection-use", words, "flight time [s]", use.times, tuple(columns))
    return draw(curves, Look(called(name, words), "deflection [deg]", styles))


_LIMITS = 121
"""Number of limits on the abscissa."""
_WIDER = 1.1
"""End of the abscissa, over the largest requirement and the specified limit."""
_FLOWN, _LOWER, _UPPER = "flown", "interval, lower end", "interval, upper end"
_STEPS: Style = {"drawstyle": "steps-post"}


def availability_chart(availability: Availability, name: str = "") -> "ControlPlot":
    """Draw the fraction of an archive's soundings with which the vehicle flies, over the limit.

    One azimuth is drawn with its confidence interval, several with a line each. A vertical line is
    the specified limit. Soundings without a verdict are not counted.

    Parameters
    ----------
    availability : Availability
        Availability with one judged sounding or more.
    name : str
        Name of a vehicle without one.

    Raises
    ------
    InputError
        Where no sounding is judged, or none needs a deflection.
    """
    instance("availability", availability, Availability, "see availability")
    largest = np.nanmax(availability.upper, initial=0.0)
    if not largest > 0.0:
        raise InputError("availability must hold a sounding that asks for deflection, to be drawn")
    limits = np.linspace(0.0, _WIDER * max(float(largest), availability.limit), _LIMITS)
    azimuths = np.degrees(np.atleast_1d(availability.azimuth)).tolist()
    multiple = len(azimuths) > 1
    # by limit, then by azimuth, of which a single one has no tuple: fraction with its interval
    parts = [
        by_azimuth if isinstance(by_azimuth, tuple) else (by_azimuth,)
        for by_azimuth in availability.curve(limits)
    ]
    if multiple:
        values = {
            f"{azimuth:.4g} deg": [by_azimuth[a].fraction for by_azimuth in parts]
            for a, azimuth in enumerate(azimuths)
        }
    else:
        values = {
            _UPPER: [by_azimuth[0].upper for by_azimuth in parts],
            _FLOWN: [by_azimuth[0].fraction for by_azimuth in parts],
            _LOWER: [by_azimuth[0].lower for by_azimuth in parts],
        }
    columns = tuple(Column(k, 100.0 * np.array(v, dtype=float), "%") for k, v in values.items())
    station = availability.soundings.station or "an archive"
    planes = PLANE_TEXTS[availability.plane]
    if not multiple:
        planes += f", towards {azimuths[0]:.4g} deg"
    words = f"{plural(len(availability.soundings), 'sounding')} of {station}, {planes}"
    curves = Curves("availability", words, "deflection limit [deg]", np.degrees(limits), columns)
    title = called(availability.judge.flight.vehicle.name or name, f"launch availability: {words}")
    look = Look(
        title,
        "soundings survived [%]",
        _availability_styles(list(values)),
        legend="flown, towards" if multiple else "",
        limits={"": (0.0, 102.0)},
    )
    plot = draw(curves, look)
    axes = plot.axes[0, 0]
    limit, beside = (
        np.degrees(availability.limit),
        {"xytext": (4, 0), "textcoords": "offset points"},
    )
    axes.axvline(limit, color=WARM, lw=1.4)
    axes.annotate("limit", (limit, 2.0), color=WARM, **beside)
    return plot


def _availability_styles(names: list[str]) -> dict[str, Style]:
    """Return the line styles by name: a full line with its interval, or a style for each azimuth.

    `names`: names of the curves: azimuths, or with a single azimuth `_FLOWN`, the fraction of
    soundings that fly, and the ends `_LOWER` and `_UPPER` of its confidence interval.
    """
    if _FLOWN not in names:
        kinds = zip(names, cycle(_COLOURS), cycle(LINES), strict=False)
        return {name: _STEPS | {"color": c, "ls": line, "lw": 1.6} for name, c, line in kinds}
    interval = _STEPS | {"color": _COLOURS[0], "lw": 1.1}
    return {
        _FLOWN: _STEPS | {"color": INK, "lw": 1.8},
        _LOWER: interval | {"ls": "--"},
        _UPPER: interval | {"ls": ":"},
    }
