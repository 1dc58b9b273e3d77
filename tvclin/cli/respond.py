"""`tvclin respond`: the exact response of one vehicle's attitude to a wind."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.documents import picked
from tvclin.base.errors import within
from tvclin.base.quantities import NOMINAL, survival
from tvclin.cli.held import Held, held
from tvclin.cli.inputs import case_of, chosen, note_nominal_pressure
from tvclin.cli.options import (
    GROUP,
    LIMIT,
    MOTION,
    At,
    Given,
    Points,
    ShownCurves,
    Source,
    Until,
    asked,
)
from tvclin.cli.output import answer, print_tables, say, say_notes, say_required
from tvclin.cli.wind import WindOptions
from tvclin.linear.extremes import (
    COMPLETE,
    OVERTURNED,
    OVERTURNED_NOTE,
    RELEASED,
    Extremes,
    ResponseEnd,
    response_table,
)
from tvclin.linear.response import attitude_responses

if TYPE_CHECKING:
    from tvclin.plots.curves import Curves

_MAX_UNTIL = 1000.0
"""Largest --until, in durations of the wind."""


def respond(
    vehicle: Source = "configuration-i",
    time: At = None,
    blows: WindOptions = GROUP,
    dead_band: float | None = asked(
        "Dead band K, from 0 to 1: trim up to K times the limit.", shown="1.0"
    ),
    capability: float | None = asked(
        "Deflection limit over what is required: 1 is the boundary.", shown="1"
    ),
    limit: Given = LIMIT,
    motion: Given = MOTION,
    until: Until = 3.0,
    points: Points = 301,
    files: ShownCurves = GROUP,
) -> None:
    """Print the attitude response to a wind, with trim up to the dead band and then the limit held.

    It is at nominal dynamic pressure; tvclin study is the verdict on a limit.

    Exit code 0: answered; 2: bad input.
    """
    from tvclin import plots

    within("--until", until, 1e-3, _MAX_UNTIL)
    within("--points", points, 2, 1_000_000)
    plan = case_of(vehicle, limit.over, motion.over, blows=blows.over, told=("respond",), time=time)
    if capability is not None and not limit.values:
        plan = replace(plan, nozzle=replace(plan.nozzle, limit=None))
    K = chosen(dead_band, plan.dead_band)
    case = held(plan, blows.name(plan), K, capability, until)
    largest, shown = case.followed(until * float(case.wind.end))
    files.write(
        lambda: _curves(case, np.linspace(0.0, shown.time, points)),
        lambda curves: plots.response_chart(curves, _title(case)),
    )
    note_nominal_pressure(plan)
    answer(
        files.as_json, lambda: _document(case, largest, shown), lambda: _print(case, largest, shown)
    )


def _curves(case: Held, times: FloatArray) -> "Curves":
    """Return the curves of the response over times [s]."""
    from tvclin.plots import response_curves

    deflection, wind = case.deflection, case.wind
    response = attitude_responses(case.plant, deflection, wind, times)
    what = f"{case.case.vehicle.name}: {case.words}"
    return response_curves(
        response, "respond", what, limit=case.limit, deflection=deflection, wind=wind
    )


def _title(case: Held) -> str:
    return f"{case.case.vehicle.name or 'Response'}: exact response\n{case.words}"


def _print(case: Held, largest: Extremes, shown: ResponseEnd) -> None:
    say(case.words)
    caption = f"{case.case.vehicle.name}: exact response"
    wind_covered = _covers_the_wind(case, shown)
    print_tables(response_table(caption, largest, case.loads if wind_covered else None))
    ratio_text = f", {case.limit / case.nominal:.4g} times that" if case.nominal else ""
    needed = f"Required {NOMINAL}: {np.degrees(case.nominal):.3f} deg by {case.governs}"
    say(f"{needed}; limit {np.degrees(case.limit):.3f} deg{ratio_text}: {survival(case.survived)}")
    say_required(case.required)
    say_notes(case.notes)
    verdict = case.verdict
    stable = "stable by condition (4b)" if verdict.stable else "not stable by condition (4b)"
    if not verdict.stable and np.isnan(verdict.final_motion.e_folding_times[0]):
        stable = "by condition (4b) only the slow mode of the flight path is not stable"
    say(f"Held for ever, the deflection leaves {verdict.final_motion}: {stable}.")
    if case.survived and not verdict.stable:
        say("SURVIVED means with a control that lets go of the limit in time.")
    if shown.why == RELEASED:
        say(
            "An autopilot lets go of the limit when the attitude is back at zero, or beyond; the"
            f" response is shown until then, {shown.time:.3f} s."
        )
    elif shown.why == OVERTURNED:
        say(f"The response is shown until it exceeds 90 deg, {shown.time:.3f} s.")
        if case.survived:
            say(OVERTURNED_NOTE)


def _covers_the_wind(case: Held, shown: ResponseEnd) -> bool:
    return shown.why == COMPLETE or shown.time >= float(case.wind.end)


def _document(case: Held, largest: Extremes, shown: ResponseEnd) -> dict[str, Any]:
    verdict, wind_covered = case.verdict, _covers_the_wind(case, shown)
    needed = None if case.required is None else np.degrees(case.required.required_deflection)
    keys = "deg=peak_angle_of_attack time_s=peak_time relative_to_wind=relative"
    return {
        **picked(case, "vehicle=case.vehicle.name model=plant.model plane=case.plane"),
        "wind": {"shape": case.name, **picked(case.wind, "peak_deg duration_s=end")},
        "required_deflection_deg": needed,
        **picked(case, "dead_band nominal_deflection_deg=nominal governed_by=governs limit_deg"),
        **picked(case, "survived notes"),
        "shown_until": picked(shown, "time_s why"),
        "attitude": largest,
        "peak_angle_of_attack": picked(case.loads, keys) if wind_covered else None,
        "verdict": {
            **picked(verdict, "stable residues_rad"),
            "final_motion": str(verdict.final_motion),
            **picked(verdict.final_motion, "offset_deg rate_deg_per_s"),
        },
    }
