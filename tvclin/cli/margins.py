"""`tvclin margins`: the stability margins of an autopilot, and whether they are enough."""

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tvclin.cli.flown import (
    Flown,
    FlownCase,
    FlownLimitDeg,
    SampleRate,
    flown_document,
    print_flown,
)
from tvclin.cli.gains import GainOptions, gains_document, takes_gains
from tvclin.cli.options import (
    MODELS_HELP,
    AsJson,
    Duration,
    PeakDeg,
    PeakSpeed,
    Plane,
    Plot,
    Vehicle,
    Wind,
)

if TYPE_CHECKING:
    from tvclin.control.autopilot.autopilot import Autopilot
    from tvclin.control.margins.criteria import Criteria, Judgement
    from tvclin.control.margins.record import Margins
    from tvclin.linear.plant import Plant

CriteriaName = Annotated[
    str, typer.Option("--criteria", help="classic (6 dB, 30 deg) or aircraft (6 dB, 45 deg).")
]
GainDb = Annotated[
    float | None, typer.Option(help="Gain margin asked for on both sides, in dB, in its place.")
]
PhaseDeg = Annotated[
    float | None, typer.Option(help="Phase margin asked for, in deg, in its place.")
]
DelayMarginMs = Annotated[float | None, typer.Option(help="Delay margin asked for as well, in ms.")]
_DIGITS = {"dB": 2, "deg": 2, "ms": 1, "": 3}
"""Behind the point, of a margin in each unit."""
_CHARTS = ("nichols", "bode", "nyquist", "root-locus")


@takes_gains
def margins(
    vehicle: Vehicle = "configuration-i",
    gains: GainOptions = GainOptions(),
    criteria: CriteriaName = "classic",
    gain_db: GainDb = None,
    phase_deg: PhaseDeg = None,
    delay_margin_ms: DelayMarginMs = None,
    model: Annotated[str, typer.Option(help=f"Model: {MODELS_HELP}")] = "drift",
    plane: Plane = "pitch",
    chart: Annotated[
        str, typer.Option(help="What --plot draws: nichols, bode, nyquist or root-locus.")
    ] = "nichols",
    flown: Flown = False,
    limit_deg: FlownLimitDeg = None,
    wind: Wind = "triangular",
    duration: Duration = 7.5,
    peak_deg: PeakDeg = None,
    peak_speed: PeakSpeed = None,
    sample_rate: SampleRate = 100.0,
    as_json: AsJson = False,
    plot: Plot = None,
) -> None:
    """Print the stability margins of an attitude and rate autopilot, and judge them.

    Exit code 0: the criteria are met; 1: they are not, or the loop is unstable; 2: bad input.
    With --flown also how much may change before a flight through the wind, with a deflection
    limit, is lost; the criteria judge the linear margins alone.
    """
    from tvclin.base.errors import one_of
    from tvclin.cli.output import print_json
    from tvclin.linear.plant import Plant
    from tvclin.vehicle.file import load_vehicle

    one_of("--chart", chart, _CHARTS)
    asked = wanted_criteria(criteria, gain_db, phase_deg, delay_margin_ms)
    loaded = load_vehicle(vehicle)
    plant = Plant.from_vehicle(loaded, model, plane)
    autopilot = gains.autopilot(plant)
    found = autopilot.margins(plant)
    case = FlownCase(limit_deg, wind, duration, peak_deg, peak_speed, sample_rate)
    in_wind = case.margins(loaded, plane, plant, autopilot) if flown and found.stable else None
    if plot is not None:
        _draw(chart, autopilot, plant, asked, plot)
    if as_json:
        head = {"vehicle": loaded.name, "model": model, "plane": plane}
        beside = {} if in_wind is None else {"flown": flown_document(in_wind)}
        print_json({**head, **margins_document(autopilot, plant, found, asked), **beside})
    else:
        _print(f"{loaded.name or vehicle}, {model}, {plane}", autopilot, plant, found, asked)
        if in_wind is not None:
            print_flown(in_wind, case.title)
    if not asked.are_met(found):
        raise typer.Exit(1)


def wanted_criteria(
    name: str, gain_db: float | None, phase_deg: float | None, delay_ms: float | None
) -> "Criteria":
    """Return the named criteria, or with other numbers those of the user."""
    from tvclin.base.errors import nonnegative, one_of
    from tvclin.control.margins.criteria import CRITERIA

    named = CRITERIA[one_of("--criteria", name, CRITERIA)]
    limits: dict[str, float] = {}
    if gain_db is not None:
        gain = float(nonnegative("--gain-db", gain_db, "dB"))
        limits |= {"aero_margin_dB": gain, "gain_increase_dB": gain}
    if phase_deg is not None:
        limits["phase_margin_deg"] = float(nonnegative("--phase-deg", phase_deg, "deg"))
    if delay_ms is not None:
        limits["delay_margin"] = float(nonnegative("--delay-margin-ms", delay_ms, "ms")) / 1000.0
    return named.changed("the command line", **limits)


def _draw(
    chart: str, autopilot: "Autopilot", plant: "Plant", asked: "Criteria", plot: Path
) -> None:
    from tvclin import plots

    draw = {
        "nichols": lambda: plots.nichols_chart(autopilot, plant, asked),
        "bode": lambda: plots.bode_chart(autopilot, plant),
        "nyquist": lambda: plots.nyquist_chart(autopilot, plant),
        "root-locus": lambda: plots.root_locus_chart(autopilot, plant),
    }
    plots.save_figure(draw[chart](), plot)


def _print(
    title: str, autopilot: "Autopilot", plant: "Plant", found: "Margins", asked: "Criteria"
) -> None:
    from tvclin.cli.output import print_pairs, print_table, shown

    pairs = [*shown(autopilot.rows()), ("closed-loop poles [1/s]", poles(autopilot, plant))]
    print_pairs(title, pairs, columns=1)
    if not found.stable:
        typer.echo(_lines(f"NO MARGINS: {found.reason}"))
        return
    judged = {one.requirement.margin: one for one in asked.judge(found)}
    headings = ["margin", "value", "at [rad/s]", "asked", "by"]
    print_table("", headings, [[*row, *_judged(judged.get(name))] for name, row in _rows(found)])
    for note in found.notes:
        typer.echo(_lines(f"Note: {note}"))
    met = asked.are_met(found)
    typer.echo(f"Criteria {asked.name}: {'MET' if met else 'NOT MET'}")
    if not met:
        typer.echo("Other gains: --natural-frequency and --damping, or gains of your own.")


def poles(autopilot: "Autopilot", plant: "Plant") -> str:
    """Return the closed-loop poles [1/s], those that only approximate the delay left out."""
    import numpy as np

    from tvclin.control.margins.loop import beside_exact

    every = np.sort_complex(autopilot.closed_loop_poles(plant))[::-1]
    if autopilot.delay:
        every = every[(every.real > 0.0) | beside_exact(every, autopilot.rational_loop(plant))]
    shown = [f"{p.real:.4g}" if p.imag == 0.0 else f"{p.real:.4g}±{p.imag:.4g}j" for p in every]
    return ", ".join(dict.fromkeys(text for text in shown if "±-" not in text))


def _lines(text: str) -> str:
    """Return a text in lines that fit a terminal."""
    return textwrap.fill(text, width=80, subsequent_indent="  ", break_on_hyphens=False)


def _rows(found: "Margins") -> list[tuple[str, list[str]]]:
    beside = {
        "aero_margin_dB": f" ({found.aero_margin:.3g}x)",
        "gain_increase_dB": f" ({found.gain_increase:.3g}x)",
    }
    rows = []
    for name, label, value, unit, at in found.rows():
        shown = f"{value:.{_DIGITS[unit]}f} {unit}".strip() + beside.get(name, "")
        when = f"{at:.4g}" if at >= 0.0 else "-"
        rows.append((name, [label, shown, when]))
        if name == "disk_margin":
            both = f"{found.disk_margin_dB:.2f} dB, {found.disk_phase_deg:.1f} deg"
            rows.append(("", ["  gain and phase", both, when]))
    return rows


def _judged(one: "Judgement | None") -> list[str]:
    from tvclin.control.margins.record import factor_to

    if one is None:
        return ["", ""]
    limit, unit = one.requirement.shown
    asked = f"{'at most ' if one.requirement.at_most else ''}{limit:g} {unit}"
    by = f"{factor_to(unit) * one.surplus:+.3g}"
    return [asked.strip(), f"{by} {'met' if one.met else 'NOT MET'}"]


def margins_document(
    autopilot: "Autopilot", plant: "Plant", found: "Margins", asked: "Criteria"
) -> dict[str, Any]:
    """Return gains, poles, margins and criteria for JSON; what does not exist becomes null."""
    numbers = {
        name: value for name, value in vars(found).items() if name not in {"crossings", "status"}
    }
    properties = ("aero_margin_dB", "gain_increase_dB", "phase_margin_deg", "disk_margin_dB")
    return {
        "autopilot": gains_document(autopilot),
        "closed_loop_poles": autopilot.closed_loop_poles(plant).tolist(),
        "stable": found.stable,
        "status": found.status,
        "reason": found.reason or None,
        "margins": numbers | {name: getattr(found, name) for name in properties},
        "criteria": {
            "name": asked.name,
            "met": asked.are_met(found),
            "requirements": [
                {
                    "margin": one.requirement.margin,
                    "limit": one.requirement.limit,
                    "value": one.value,
                    "surplus": one.surplus,
                    "met": one.met,
                    "source": one.requirement.source,
                }
                for one in asked.judge(found)
            ],
        },
        "notes": list(found.notes),
    }
