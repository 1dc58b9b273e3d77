"""`tvclin autopilot`: the deflection that an autopilot needs in a wind, beside trim."""

from dataclasses import replace
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tvclin.cli.bands import parts_line
from tvclin.cli.criteria import CriteriaOptions
from tvclin.cli.gains import GainOptions, LoopOptions
from tvclin.cli.inputs import case_of
from tvclin.cli.least import LeastOptions, draw_front, print_least
from tvclin.cli.margin_tables import MarginsFound, poles, poles_document, print_bounds
from tvclin.cli.options import (
    AsJson,
    Model,
    Plane,
    Plot,
    Rigid,
    SampleRate,
    Source,
    grouped,
)
from tvclin.cli.output import print_tables, say, say_notes
from tvclin.cli.progress import waiting
from tvclin.cli.wind import WindOptions, wind_words

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tvclin.base.lines import Row
    from tvclin.control.comparison.duration import WorstDuration
    from tvclin.control.comparison.trim import TrimComparison
    from tvclin.control.margins.criteria import Criteria
    from tvclin.vehicle.linear_vehicle import AnyVehicle

_SHORTEST, _LONGEST = 0.2, 8.0
"""Of the durations among which the worst is sought, in units of the one that was given."""


@grouped
def autopilot(
    vehicle: Source = "configuration-i",
    blows: WindOptions = WindOptions(),
    limit_deg: Annotated[
        float | None, typer.Option(help="Deflection limit, in deg, to be judged.")
    ] = None,
    gains: GainOptions = GainOptions(),
    loop: LoopOptions = LoopOptions(),
    sample_rate: SampleRate = None,
    criteria: CriteriaOptions = CriteriaOptions(),
    least: LeastOptions = LeastOptions(),
    rigid: Rigid = False,
    model: Model = None,
    plane: Plane = None,
    as_json: AsJson = False,
    plot: Plot = None,
) -> None:
    """Print the deflection that an autopilot needs in a wind, beside trim and the boundaries.

    A vehicle file with bending, slosh, engine inertia or sensor lags makes a flexible vehicle:
    gains, margins and peaks are of that, boundaries and minimum of the rigid one. --rigid leaves
    all that out.

    --plot draws deflection and attitude of a stable loop; with --least, what a disk margin costs.

    Exit code 0: the loop is stable, and meets criteria and limit; 1: it does not; 2: bad input.
    """
    from tvclin.answers.least_gains.asked import autopilot_asked
    from tvclin.cli.output import print_json
    from tvclin.control.comparison.trim import compare_with_trim

    case = case_of(
        vehicle,
        *(criteria.over, least.over, gains.over, loop.over),
        blows=blows.over,
        told=("autopilot",),
        rigid=rigid,
        model=model,
        plane=plane,
        limit_deg=limit_deg,
        sample_rate=sample_rate,
    )
    loaded, plant, asked = case.vehicle, case.plant, case.held_to
    limit = None if case.nozzle.limit is None else degrees(case.nozzle.limit)
    with waiting("seeking gains"):
        sought = least.found(case, asked)
    autopilot = autopilot_asked(case, case.history, asked) if sought is None else sought.autopilot
    found = compare_with_trim(plant, autopilot, case.history)
    worst = _worst(found, case.blows)
    if plot is not None:
        with waiting("drawing"):
            _draw(found, plot) if sought is None else draw_front(sought, plot)
    document = _document(loaded, found, worst, limit, asked)
    if sought is not None:
        document["least"] = sought
    if as_json:
        print_json({"vehicle": loaded.name, "model": plant.model, "plane": case.plane, **document})
    else:
        _print(loaded, found, worst, document, wind_words(blows.name(case), case), limit)
        if sought is not None:
            print_least(sought)
    if not document["met"]:
        raise typer.Exit(1)


def _worst(found: "TrimComparison", wind: Any) -> "WorstDuration | None":
    """The worst duration of a pulse; a sounding has the one that it has."""
    from tvclin.control.comparison.duration import worst_duration
    from tvclin.winds.shaped import ShapedWind

    if not isinstance(wind, ShapedWind) or not found.margins.stable or not wind.peak:
        return None
    return worst_duration(
        found.plant,
        replace(found.autopilot, sample_rate=None),
        peak=wind.peak,
        shortest=_SHORTEST * wind.duration,
        longest=_LONGEST * wind.duration,
        shape=lambda peak, duration: wind.history({"wind_peak": peak, "wind_duration": duration}),
    )


def _draw(found: "TrimComparison", plot: Path) -> None:
    from tvclin.plots import comparison_chart, save_figure

    if not found.margins.stable:
        say(f"No figure is written to {plot}: an unstable loop has no response to draw.", err=True)
        return
    save_figure(comparison_chart(found), plot)


def _document(
    vehicle: "AnyVehicle",
    found: "TrimComparison",
    worst: "WorstDuration | None",
    limit_deg: float | None,
    asked: "Criteria",
) -> dict[str, Any]:
    import numpy as np

    from tvclin.base.documents import picked
    from tvclin.vehicle.vehicle import Vehicle

    within = limit_deg is None or np.degrees(found.peak_deflection) <= limit_deg
    criteria = MarginsFound.of(found.autopilot, found.plant, asked).met
    slope = speed = float("nan")  # of a vehicle that is known by its coefficients
    if isinstance(vehicle, Vehicle):
        slope, speed = abs(float(vehicle.normal_force_slope)), float(vehicle.velocity)
    return {
        "autopilot": found.autopilot,
        **poles_document(found.autopilot, found.plant),
        **picked(
            found,
            "wind_peak_deg=wind.peak stable=margins.stable peak_deflection_deg"
            " part_of_trim=relative peak_deflection_rate_deg_s peak_angle_of_attack_deg",
        ),
        "peak_normal_force_N": slope * found.peak_angle_of_attack,
        **picked(found, "peak_attitude_deg peak_flight_path_angle_deg"),
        "peak_lateral_speed_m_s": found.peak_flight_path_angle * speed,
        **picked(found, "trim_deg=trim_deflection"),
        "boundaries_deg": {f"{K:g}": np.degrees(one) for K, one in found.boundaries.items()},
        **picked(found, "minimum_deg wind_gain"),
        "worst_duration": worst,
        "criteria": {"name": asked.name, "met": criteria},
        "limit_deg": limit_deg,
        "within_limit": None if limit_deg is None else bool(within),
        "met": bool(found.margins.stable and criteria and within),
        "notes": found.notes,
    }


def _print(
    vehicle: "AnyVehicle",
    found: "TrimComparison",
    worst: "WorstDuration | None",
    document: dict[str, Any],
    wind: str,
    limit_deg: float | None,
) -> None:
    import numpy as np

    from tvclin.base.lines import quantities

    rows = found.autopilot.rows()
    if found.plant.structure is not None:
        say(parts_line(found.plant.structure))
    elif found.autopilot.sample_rate is None:
        rows.append(("closed-loop poles [1/s]", (poles(found.autopilot, found.plant),)))
    print_tables(quantities(f"{vehicle.name}, {found.plant.model}: {wind}", rows))
    if not found.margins.stable:
        say(f"NO NUMBERS: {found.margins.reason}")
        return
    print_tables(found.deflections("Largest deflection in this wind"))
    print_tables(quantities("In this wind", [*found.motions(), *_more(document, worst)]))
    print_bounds(found.autopilot, found.plant)
    say_notes(found.notes)
    word = "MET" if document["criteria"]["met"] else "NOT MET (tvclin margins says by how much)"
    say(f"Criteria {document['criteria']['name']}: {word}")
    if limit_deg is not None:
        word = "ENOUGH" if document["within_limit"] else "NOT ENOUGH for this autopilot"
        if worst is not None and document["within_limit"]:
            longer = limit_deg < float(np.degrees(worst.peak_deflection))
            word += f" in this wind, but not in one of {worst.duration:.3g} s" if longer else ""
        say(f"Limit {limit_deg:g} deg: {word}")


def _more(document: dict[str, Any], worst: "WorstDuration | None") -> "Iterator[Row]":
    """Yield what takes the whole vehicle, and the wind that asks most."""
    import numpy as np

    from tvclin.base.lines import degrees, significant

    force, across = document["peak_normal_force_N"], document["peak_lateral_speed_m_s"]
    if np.isfinite(force):
        yield "N times the angle of attack", significant("wind.normal_force", force, 4, "N")
    if np.isfinite(across):
        yield "drift across", significant("wind.lateral_speed", across, 4, "m/s")
    if worst is not None:
        end = ", an end of the range tried" * worst.at_the_end
        asks = degrees("wind.worst", worst.peak_deflection, unit="deg")
        yield "worst duration", (f"{worst.duration:.3g} s, ", *asks, end)
