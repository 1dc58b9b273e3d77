"""The sections of closed loops and dispersed cases."""

from dataclasses import replace

import numpy as np

from tvclin.answers.campaign.statistics import shares
from tvclin.answers.findings import Findings, gains_of
from tvclin.answers.flexible import nozzle_of
from tvclin.answers.trials import LawTrial, standard_winds
from tvclin.base.errors import InputError
from tvclin.base.lines import Line, degrees, number, significant
from tvclin.boundary.forecast_free import forecast_free_limit
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.control.comparison.trim import TrimComparison
from tvclin.control.margins.record import Margins
from tvclin.flights.closed_loop.edges import OK
from tvclin.flights.closed_loop.flown_record import CHANGES, FlownMargin
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.plant import Plant
from tvclin.plots import comparison_chart, nichols_chart
from tvclin.show.report.blocks import Block, Figure, Paragraph, Section, Table, no_answer, pairs
from tvclin.show.report.figures import inline_svg


def laws(found: Findings) -> Section | None:
    """Return what each law needs in each wind, beside trim and the minimum."""
    if "trials" in found.reasons:
        return no_answer("laws", "Control laws", found.reasons["trials"])
    if not found.trials or found.plan.laws is None:
        return None
    asked, s = found.plan.laws, found.study
    plant = Plant(s.coefficients, asked.model)
    every = standard_winds(s.wind.peak, s.wind.duration)
    trials = {(one.law, one.wind): one for one in found.trials}
    trim = s.trim_deflection
    rows: list[tuple[Line, ...]] = [
        (("ideal trim",), *_both("laws.trim", [1.0] * len(asked.winds), trim))
    ]
    for i, law in enumerate(asked.names):
        cells: list[Line] = []
        for j, wind in enumerate(asked.winds):
            cells += _trial(f"laws.{i}.{j}", trials[law, wind], trim)
        rows.append(((law,), *cells))
    free, least = [], []
    for wind in asked.winds:
        free.append(_no_forecast(plant, every[wind]))
        least.append(optimum_deflection(plant, every[wind]).peak / trim if trim else np.nan)
    rows.append((("no forecast, any law",), *_both("laws.no_forecast", free, trim)))
    rows.append((("minimum, wind known",), *_both("laws.minimum", least, trim)))
    head = ("law", *(h for wind in asked.winds for h in (f"{wind}: over trim", f"{wind} [deg]")))
    said = [f"{one.law}, {one.wind}: {one.status}." for one in found.trials if one.status != OK]
    said += [
        f"{one.law}, {one.wind}: some lower limits survive as well."
        for one in found.trials
        if not one.monotone
    ]
    flown, rate = f"the {asked.model} model", asked.sample_rate
    if found.plan.structure is not None:
        rate = nozzle_of(gains_of(found.plan), rate)["sample_rate"]
        flown += " of the flexible vehicle, with filters, actuator and delay of the autopilot"
    words = (
        f"Each law is flown with limits on {flown}, sampled at {rate:g} Hz, in winds with the peak"
        " and duration of this study. The number"
        " is the least deflection limit above which every limit that was tried survives. Trim and"
        " dead band hold the attitude and are designed on a fixed path."
        + (" The gust is left out here." if s.gust is not None else "")
    )
    table = Table("Deflection limit that each law needs", head, tuple(rows))
    blocks: tuple[Block, ...] = (table, Paragraph((" ".join([words, *said]),)))
    return Section("laws", "Control laws", blocks)


def autopilot(found: Findings) -> Section | None:
    """Return gains, margins beside their criteria, and what the autopilot asks of the nozzle."""
    if "comparison" in found.reasons:
        return no_answer("margins", "Autopilot and margins", found.reasons["comparison"])
    c = found.comparison
    if c is None:
        return None
    f, judged = found.flexible, found.margins or c.margins
    plant: AnyPlant = c.plant if f is None else f.plant
    margins = c.margins if f is None else f.bands.whole
    met = found.criteria.are_met(judged)
    verdict = "met" if met else "not met"
    whose = "" if f is None else ", flexible"
    words = (
        f"Criteria {found.criteria.name}: {verdict}. The loop is that of the {plant.model}"
        f" model{whose}."
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
                "What the autopilot, which has no limits here, asks of the nozzle in this wind.",
                inline_svg(comparison_chart(c), "comparison", label),
            )
        )
    blocks += _flown(found)
    return Section("margins", "Autopilot and margins", tuple(blocks))


def _flown(found: Findings) -> list[Block]:
    """What the limit leaves of the margins in this wind; nothing without a limit."""
    if "flown" in found.reasons:
        return [Paragraph((f"Nothing is left of the margins: {found.reasons['flown']}.",))]
    f = found.flown
    if f is None:
        return []
    rows = []
    for name in CHANGES:
        one: FlownMargin = getattr(f, name)
        cells = [
            number(f"flown.{name}.{key}", 1000.0 * value, 1, "ms")
            if name == "delay"
            else number(f"flown.{name}.{key}", replace(one, value=value).dB, 2, "dB")
            for key, value in (("value", one.value), ("near_rest", one.near_rest))
        ]
        cause = "is lost" if one.cause == "lost" else one.cause
        rows.append(((name.replace("_", " "),), cells[0], (cause,), cells[1]))
    said = (
        "So much may change before a flight through this wind with the limit in question is lost,"
        " or the loop grows near rest. The limit is "
    )
    spare = number("flown.spare", f.spare, 2)
    words = (said, *spare, " times the least that this autopilot survives with.", *f.notes)
    title = "What the limit leaves of the margins in this wind"
    head = ("may change", "by", "then it", "near rest")
    return [Table(title, head, tuple(rows)), Paragraph(words)]


def dispersed(found: Findings) -> Section | None:
    """Return what covers a dispersed vehicle in a dispersed wind."""
    title = "Dispersed vehicle and wind"
    if "dispersed" in found.reasons:
        return no_answer("dispersed", title, found.reasons["dispersed"])
    d = found.dispersed
    if d is None:
        return None
    r = d.required
    of_cases, of_flights = shares(r.probability, r.confidence)
    rows: list[tuple[Line, ...]] = [
        (("cases",), significant("dispersed.cases", r.cases, 9)),
        (("seed",), significant("dispersed.seed", d.seed, 9)),
        (("median",), degrees("dispersed.median", d.median, unit="deg")),
        (
            (of_cases,),
            degrees("dispersed.estimate", r.estimate, unit="deg"),
        ),
        (
            (of_flights,),
            ("too few cases to say",)
            if np.isinf(r.upper)
            else degrees("dispersed.upper", r.upper, unit="deg"),
        ),
    ]
    if d.success is not None:
        rows += [
            ((label,), number(f"dispersed.{key}", 100.0 * part, 2, "%"))
            for label, key, part in (
                ("the limit is enough in", "success", d.success.estimate),
                ("at least in", "success_lower", d.success.lower),
                ("at most in", "success_upper", d.success.upper),
            )
        ]
    drivers = tuple(
        ((name.replace("_", " "),), number(f"dispersed.driver.{name}", rank, 2))
        for name, rank in d.drivers.items()
    )
    spreads = "; ".join(
        f"{one.parameter.replace('_', ' ')}: {one.shape},"
        f" {f'{100 * one.spread:g} %' if one.relative else f'{one.spread:g} in its SI unit'}"
        for one in d.dispersions.each
    )
    blocks = (
        Table("Deflection that covers the dispersions", ("quantity", "value"), tuple(rows)),
        Table("What drives it", ("parameter", "rank correlation"), drivers),
        Paragraph(
            (
                f"Dispersed: {spreads}. The spread is one standard deviation, of a uniform"
                " distribution half its width.",
            )
        ),
    )
    return Section("dispersed", title, blocks)


def _both(key: str, parts: list[float], trim: float) -> list[Line]:
    """Cells of a deflection in each wind: over trim, and in degrees."""
    cells: list[Line] = []
    for j, part in enumerate(parts):
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
    asked = found.criteria.judge(found.margins or whole)
    judged = {one.requirement.margin: one for one in asked if not one.band}
    rows: list[tuple[Line, ...]] = []
    for name, label, value, unit, at in whole.rows():
        row = [
            (label,),
            number(f"margin.{name}", value, 3, unit),
            number(f"margin.{name}.rad_per_s", at, 3),
        ]
        one = judged.get(name)
        if one is None:
            rows.append((*row, ("",), ("",)))
            continue
        limit = significant(f"criteria.{name}", one.requirement.shown[0], 4, unit)
        most = ("at most ",) if one.requirement.at_most else ()
        rows.append((*row, (*most, *limit), ("met" if one.met else "not met",)))
    return Table("Margins", ("margin", "value", "at [rad/s]", "asked", "criterion"), tuple(rows))


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
    title = "The autopilot in this wind"
    if found.flexible is not None:
        peak = degrees("wind.flexible", found.flexible.peak_deflection, unit="deg")
        rows.insert(1, (("the same, flexible vehicle",), peak))
        title += ", rigid vehicle"
    return Table(title, ("quantity", "value"), tuple(rows))
