"""The sections of closed loops and dispersed cases."""

import numpy as np

from tvclin.answers.campaign.statistics import shares
from tvclin.answers.findings import Findings
from tvclin.answers.trials import LawsAsked, LawTrial, standard_winds
from tvclin.base.errors import InputError
from tvclin.base.lines import Line, Table, degrees, least, number, significant
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.control.comparison.trim import TrimComparison
from tvclin.control.margins.record import Margins
from tvclin.control.margins.tables import margin_table
from tvclin.flights.closed_loop.edges import OK
from tvclin.flights.closed_loop.flown_record import flown_table
from tvclin.linear.plant import Plant
from tvclin.plots import comparison_chart, nichols_chart
from tvclin.show.report.blocks import (
    Block,
    Figure,
    Paragraph,
    Section,
    checks,
    pairs,
    section_of,
)
from tvclin.show.report.figures import inline_svg
from tvclin.show.report.sections import LEAST

_ACROSS = 3
"""Winds beside each other in a table of laws."""


def laws(found: Findings) -> Section | None:
    """Return what each law needs in each wind, beside trim and the minimum."""
    return section_of(found, "trials", "laws", "Control laws", _laws)


def _laws(found: Findings) -> list[Block]:
    asked, s = found.plan.laws, found.study
    assert asked is not None
    flown, rate = f"the {found.plan.law_model} model", asked.sample_rate
    if found.plan.vehicle.structure is not None:
        flown += " of the flexible vehicle, with filters, actuator and delay of the autopilot"
    words = (
        f"Each law is flown with a stop on {flown}, sampled at {rate:g} Hz, in winds with the peak"
        " and duration of this study. The number is the least stop above which every one that was"
        " tried survives. The laws trim and dead band hold the attitude, and are designed on a"
        " fixed path." + (" The gust is left out here." if s.gust is not None else "")
    )
    odd = [f'"{one.law}" in "{one.wind}": {one.status}' for one in found.trials if one.status != OK]
    odd += [
        f'"{one.law}" in "{one.wind}": some lower limits survive as well'
        for one in found.trials
        if not one.monotone
    ]
    parts = [range(j, len(asked.winds))[:_ACROSS] for j in range(0, len(asked.winds), _ACROSS)]
    tables = [_needed(found, asked, part) for part in parts]
    return [*tables, Paragraph((words,)), *checks(odd)]


def _needed(found: Findings, asked: LawsAsked, part: range) -> Table:
    """What each law needs in some of the winds."""
    s = found.study
    plant = Plant(s.coefficients, found.plan.law_model)
    every = standard_winds(s.wind.peak, s.wind.duration)
    trials = {(one.law, one.wind): one for one in found.trials}
    trim, winds = s.trim_deflection, {j: asked.winds[j] for j in part}
    full = dict.fromkeys(winds, 1.0)
    rows: list[tuple[Line, ...]] = [(("ideal trim",), *_both("laws.trim", full, trim))]
    for i, law in enumerate(asked.names):
        cells: list[Line] = []
        for j, wind in winds.items():
            cells += _trial(f"laws.{i}.{j}", trials[law, wind], trim)
        rows.append(((law,), *cells))
    free = {j: _no_forecast(plant, every[wind]) for j, wind in winds.items()}
    known = {
        j: optimum_deflection(plant, every[wind]).peak / trim if trim else np.nan
        for j, wind in winds.items()
    }
    rows.append(((LEAST["forecast_free"],), *_both("laws.no_forecast", free, trim)))
    rows.append(((LEAST["minimum"],), *_both("laws.minimum", known, trim)))
    names = (h for wind in winds.values() for h in (f"{wind}: over trim", f"{wind} [deg]"))
    return Table("Deflection limit that each law needs", ("law", *names), tuple(rows))


def autopilot(found: Findings) -> Section | None:
    """Return gains, margins beside their criteria, and what the autopilot asks of the nozzle."""
    return section_of(found, "comparison", "margins", "Autopilot and margins", _autopilot)


def _autopilot(found: Findings) -> list[Block]:
    c, f = found.comparison, found.flexible
    assert c is not None
    plant = c.plant
    margins = c.margins if f is None else f.bands.whole
    verdict = "met" if found.criteria.are_met(found.margins or c.margins) else "not met"
    whose = "" if f is None else " of the flexible vehicle"
    words = (
        f'The criteria "{found.criteria.name}" are {verdict}. The loop is that of the'
        f" {plant.model} model{whose}, without a stop."
    )
    blocks: list[Block] = [
        Paragraph((words,)),
        Table("Autopilot", ("quantity", "value"), pairs(c.autopilot.rows())),
        _margins(found, margins),
    ]
    if margins.stable:
        label = f"Nichols chart of the loop; criteria {found.criteria.name} {verdict}"
        blocks.append(
            Figure(
                label,
                "Nichols chart of the loop with its margins and the box of the criteria.",
                inline_svg(nichols_chart(c.autopilot, plant, found.criteria), "nichols", label),
            )
        )
    blocks.append(_in_the_wind(found, c))
    if c.margins.stable:
        label = "Deflection of the autopilot over time beside trim, boundaries and minimum"
        blocks.append(
            Figure(
                label,
                "Deflection that the autopilot without a stop asks for in this wind.",
                inline_svg(comparison_chart(c), "comparison", label),
            )
        )
    if f is None and found.stop is not None and found.stop.status != OK:
        blocks += checks([f"flown with a stop: {found.stop.status}"])
    return blocks + _flown(found)


def _flown(found: Findings) -> list[Block]:
    """What the limit leaves of the margins in this wind; nothing without a limit."""
    if "flown" in found.reasons:
        return [Paragraph((f"With this limit no margin is left in this wind: {_lost(found)}.",))]
    f = found.flown
    if f is None:
        return []
    words = (
        "How much each quantity alone may change before a flight through this wind, with the limit"
        " as its stop, is lost, or the loop becomes unstable near rest. The limit is ",
        *number("flown.spare", f.spare, 2),
        " times the least with which this autopilot survives.",
    )
    return [
        flown_table(f, "Margins that the limit leaves in this wind"),
        Paragraph(words),
        *checks(f.notes),
    ]


def _lost(found: Findings) -> str:
    """Why the flight with the limit has no margins."""
    stop, limit = found.stop, found.study.limit
    if stop is None or limit is None or not abs(stop.deflection) * found.study.of_both > limit:
        return found.reasons["flown"]
    least, have = np.degrees(abs(stop.deflection) * found.study.of_both), np.degrees(limit)
    if np.isinf(least):
        return f"flown with a stop of {have:.3f} deg or more, the autopilot does not survive"
    return f"the autopilot needs a stop of {least:.3f} deg, flown, and has {have:.3f} deg"


def dispersed(found: Findings) -> Section | None:
    """Return what covers a dispersed vehicle in a dispersed wind."""
    title = "Dispersed vehicle and wind"
    return section_of(found, "dispersed", "dispersed", title, _dispersed)


def _dispersed(found: Findings) -> list[Block]:
    d = found.dispersed
    assert d is not None
    r = d.required
    of_cases, of_flights = shares(r.probability, r.confidence)
    rows: list[tuple[Line, ...]] = [
        (("cases",), significant("dispersed.cases", r.cases, 9)),
        (("seed",), significant("dispersed.seed", d.seed, 9)),
        (("median",), degrees("dispersed.median", d.median, unit="deg")),
        ((of_cases,), degrees("dispersed.estimate", r.estimate, unit="deg")),
        (
            (of_flights,),
            ("too few cases to say",)
            if np.isinf(r.upper)
            else degrees("dispersed.upper", r.upper, unit="deg"),
        ),
    ]
    if d.success is not None:
        rows += [
            ((label,), number(f"dispersed.{key}", 100.0 * part, 1, "%"))
            for label, key, part in (
                ("the limit is enough in", "success", d.success.estimate),
                ("interval of that: from", "success_lower", d.success.lower),
                ("to", "success_upper", d.success.upper),
            )
        ]
    drivers = tuple(
        ((name.replace("_", " "),), number(f"dispersed.driver.{name}", rank, 2))
        for name, rank in d.drivers.items()
    )
    spreads = ", ".join(
        f"{one.parameter.replace('_', ' ')} ({one.shape},"
        f" {f'{100 * one.spread:.4g} %' if one.relative else f'{one.spread:.4g} in its SI unit'})"
        for one in d.dispersions.each
    )
    words = (
        f"Dispersed are {spreads}. The number is one standard deviation, of a uniform distribution"
        " half its width; a truncated one is normal and cut at three standard deviations."
    )
    return [
        Table("Deflection that covers the dispersions", ("quantity", "value"), tuple(rows)),
        Table("What drives it", ("parameter", "rank correlation"), drivers),
        Paragraph((words,)),
    ]


def _both(key: str, parts: dict[int, float], trim: float) -> list[Line]:
    """Cells of a deflection in each wind: over trim, and in degrees."""
    cells: list[Line] = []
    for j, part in parts.items():
        cells += [number(f"{key}.{j}.part", part), degrees(f"{key}.{j}", part * trim)]
    return cells


def _trial(key: str, one: LawTrial, trim: float) -> list[Line]:
    if one.limit > one.highest:
        return [(f"above {one.highest:g}",), ("-",)]
    if one.limit <= one.lowest:
        return [(f"below {one.lowest:g}",), ("-",)]
    return [number(f"{key}.part", one.limit), degrees(key, one.limit * trim)]


def _no_forecast(plant: Plant, wind: object) -> float:
    try:
        return float(forecast_free_limit(plant, wind).limit)  # type: ignore[arg-type]
    except InputError:
        return float(np.nan)


def _margins(found: Findings, whole: Margins) -> Block:
    if not whole.stable:
        return Paragraph((f"There are no margins: {whole.reason}.",))
    return margin_table(whole, found.criteria.judge(found.margins or whole))


def _in_the_wind(found: Findings, c: TrimComparison) -> Block:
    rows: list[tuple[Line, ...]] = [
        (("largest deflection",), degrees("wind.deflection", c.peak_deflection, unit="deg")),
        (("over ideal trim",), number("wind.relative", c.relative)),
        (
            ("largest rate of deflection",),
            degrees("wind.deflection_rate", c.peak_deflection_rate, unit="deg/s"),
        ),
        (
            ("largest angle of attack",),
            degrees("wind.angle_of_attack", c.peak_angle_of_attack, unit="deg"),
        ),
        (("largest attitude error",), degrees("wind.attitude", c.peak_attitude, unit="deg")),
        (("ideal trim",), degrees("wind.trim", c.trim_deflection, unit="deg")),
        (("minimum, wind known",), degrees("wind.minimum", c.minimum, unit="deg")),
    ]
    title = "The autopilot in this wind, without a stop"
    title += "" if found.flexible is None else ", flexible vehicle"
    if found.stop is not None:
        stop = abs(float(found.stop.deflection)) * found.study.of_both
        rows.append(
            (
                ("least stop that it survives with, flown",),
                least(degrees("wind.stop", stop, unit="deg")),
            )
        )
    return Table(title, ("quantity", "value"), tuple(rows))
