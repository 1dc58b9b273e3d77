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
from tvclin.cli.output import say
from tvclin.cli.wind import WindOptions, wind_words

if TYPE_CHECKING:
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
    sought = least.found(case, asked)
    autopilot = autopilot_asked(case, case.history, asked) if sought is None else sought.autopilot
    found = compare_with_trim(plant, autopilot, case.history)
    worst = _worst(found, case.blows)
    if plot is not None and sought is None:
        _draw(found, plot)
    elif plot is not None:
        draw_front(sought, plot)
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

    from tvclin.cli.output import print_pairs, print_table, shown

    title = f"{vehicle.name}, {found.plant.model}: {wind}"
    pairs = shown(found.autopilot.rows())
    if found.plant.structure is not None:
        say(parts_line(found.plant.structure))
    elif found.autopilot.sample_rate is None:
        pairs.append(("closed-loop poles [1/s]", poles(found.autopilot, found.plant)))
    print_pairs(title, pairs, columns=1)
    if not found.margins.stable:
        say(f"NO NUMBERS: {found.margins.reason}")
        return
    print_table("", ["deflection", "[deg]", "of trim"], _deflections(document))
    print_pairs("", _loads(document, worst), columns=1)
    print_bounds(found.autopilot, found.plant)
    for note in found.notes:
        say(f"Note: {note}")
    word = "MET" if document["criteria"]["met"] else "NOT MET (tvclin margins says by how much)"
    say(f"Criteria {document['criteria']['name']}: {word}")
    if limit_deg is not None:
        word = "ENOUGH" if document["within_limit"] else "NOT ENOUGH for this autopilot"
        if worst is not None and document["within_limit"]:
            longer = limit_deg < float(np.degrees(worst.peak_deflection))
            word += f" in this wind, but not in one of {worst.duration:.3g} s" if longer else ""
        say(f"Limit {limit_deg:g} deg: {word}")


def _deflections(document: dict[str, Any]) -> list[list[str]]:
    from tvclin.cli.output import limit_cell

    trim = document["trim_deg"]
    rows = [
        ("this autopilot", document["peak_deflection_deg"]),
        ("ideal trim, |B alpha_w,max|", trim),
        *(
            (f"boundary, dead band K = {K}", limit)
            for K, limit in document["boundaries_deg"].items()
        ),
        ("least of all, wind known beforehand", document["minimum_deg"]),
    ]
    return [
        [name, limit_cell(value), limit_cell(value / trim, 3) if trim else "-"]
        for name, value in rows
    ]


def _loads(document: dict[str, Any], worst: "WorstDuration | None") -> list[tuple[str, str]]:
    import numpy as np

    pairs = [
        ("largest deflection rate", f"{document['peak_deflection_rate_deg_s']:.4g} deg/s"),
        ("largest angle of attack", f"{document['peak_angle_of_attack_deg']:.4g} deg"),
        ("largest attitude error", f"{document['peak_attitude_deg']:.4g} deg"),
    ]
    if np.isfinite(document["peak_normal_force_N"]):
        pairs.insert(2, ("N times it", f"{document['peak_normal_force_N']:.4g} N"))
    if np.isfinite(document["peak_flight_path_angle_deg"]):
        drift = document["peak_lateral_speed_m_s"]
        across = f", {drift:.4g} m/s across" if np.isfinite(drift) else ""
        angle = f"{document['peak_flight_path_angle_deg']:.4g} deg"
        pairs.append(("largest drift", f"{angle}{across}"))
    pairs.append(("H-infinity, wind to deflection", f"{document['wind_gain']:.4g}"))
    if worst is not None:
        asks = np.degrees(worst.peak_deflection)
        end = ", an end of the range tried" if worst.at_the_end else ""
        pairs.append(("worst duration", f"{worst.duration:.3g} s, {asks:.4g} deg{end}"))
    return pairs
