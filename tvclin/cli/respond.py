"""`tvclin respond`: how the attitude of one vehicle answers a wind, exactly."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tvclin.cli.held import Held, held
from tvclin.cli.inputs import case_of, chosen
from tvclin.cli.options import (
    AsJson,
    Csv,
    Model,
    Plane,
    Plot,
    Points,
    Source,
    Until,
    grouped,
)
from tvclin.cli.output import print_tables, say
from tvclin.cli.wind import WindOptions, wind_words

if TYPE_CHECKING:
    from tvclin.linear.extremes import Extremes, Shown
    from tvclin.linear.loads import Loads
    from tvclin.linear.verdict import Verdict

_LONGEST = 1000.0
"""Of --until: nothing in a flight lasts that long."""


@grouped
def respond(
    vehicle: Source = "configuration-i",
    blows: WindOptions = WindOptions(),
    dead_band: Annotated[
        float | None,
        typer.Option(
            help="Dead band K, from 0 to 1: trim up to K times the limit.", show_default="1.0"
        ),
    ] = None,
    capability: Annotated[
        float | None,
        typer.Option(
            help="Deflection limit over what is required: 1 is the boundary.", show_default="1"
        ),
    ] = None,
    limit_deg: Annotated[
        float | None, typer.Option(help="Deflection limit, in deg, in place of --capability.")
    ] = None,
    model: Model = None,
    plane: Plane = None,
    until: Until = 3.0,
    points: Points = 301,
    csv: Csv = None,
    as_json: AsJson = False,
    plot: Plot = None,
) -> None:
    """Print the attitude response to a wind, with trim up to the dead band and then the limit held.

    Exit code 0: answered; 2: bad input.
    """
    from tvclin.base.errors import within
    from tvclin.cli.output import print_json
    from tvclin.linear.extremes import extremes, shown_until
    from tvclin.linear.loads import wind_loads
    from tvclin.linear.verdict import judge

    within("--until", until, 1e-3, _LONGEST)
    within("--points", points, 2, 1_000_000)
    asked = case_of(
        vehicle, blows=blows.over, told=("respond",), model=model, plane=plane, limit_deg=limit_deg
    )
    if capability is not None and limit_deg is None:
        asked = replace(asked, nozzle=replace(asked.nozzle, limit=None))
    K = chosen(dead_band, asked.dead_band)
    case = held(asked, blows.name(asked), K, capability, until)
    length = until * float(case.wind.end)
    verdict = judge(case.plant, case.deflection, case.wind)
    lets_go = case.sufficient and not verdict.stable
    shown = shown_until(case.plant, case.deflection, case.wind, length, lets_go=lets_go)
    found = extremes(case.plant, case.deflection, case.wind, shown.time)
    if shown.back_at_zero is not None:
        found = replace(found, back_at_zero=shown.back_at_zero)
    loads = wind_loads(case.plant, case.deflection, case.wind)
    if csv is not None or plot is not None:
        _write(case, shown.time, points, csv, plot)
    if as_json:
        print_json(_document(case, found, loads, verdict, shown))
    else:
        _print(case, found, loads, verdict, shown)


def _write(case: Held, length: float, points: int, csv: Path | None, plot: Path | None) -> None:
    import numpy as np

    from tvclin.base.files import write_text
    from tvclin.linear.response import attitude_responses
    from tvclin.plots import response_chart, response_curves, save_figure

    times = np.linspace(0.0, length, points)
    response = attitude_responses(case.plant, case.deflection, case.wind, times)
    what = f"{case.case.vehicle.name}: {_what(case)}"
    numbers = response_curves(response, case.deflection, case.wind, "respond", what)
    if csv is not None:
        write_text(csv, numbers.csv())
    if plot is not None:
        title = f"{case.case.vehicle.name or 'Response'}: exact response\n{_what(case)}"
        save_figure(response_chart(numbers, title, float(case.wind.end)), plot)


def _what(case: Held) -> str:
    import numpy as np

    return (
        f"{wind_words(case.name, case.case)}, model {case.plant.model}, K = {case.dead_band:g},"
        f" limit {np.degrees(case.limit):.3f} deg"
    )


def _print(
    case: Held, found: "Extremes", loads: "Loads", verdict: "Verdict", shown: "Shown"
) -> None:
    import numpy as np

    from tvclin.linear.extremes import FALLEN, LET_GO, TURNED_OVER
    from tvclin.linear.loads import response_table

    say(_what(case))
    caption = f"{case.case.vehicle.name}: exact response"
    whole = _covers_the_wind(case, shown)
    print_tables(response_table(caption, found, loads if whole else None))
    word = "SUFFICIENT" if case.sufficient else "NOT SUFFICIENT"
    part = f", {case.limit / case.required:.4g} times that" if case.required else ""
    needed = f"Required {np.degrees(case.required):.3f} deg by {case.governs}"
    say(f"{needed}; limit {np.degrees(case.limit):.3f} deg{part}: {word}")
    stable = "stable by (4b)" if verdict.stable else "not stable by (4b)"
    if not verdict.stable and np.isnan(verdict.left_over.e_folding_times[0]):
        stable = "stable by (4b) but for the slow mode of the flight path"
    say(f"Held for ever, this deflection is {stable}; it leaves {verdict.left_over}")
    if shown.why == LET_GO:
        say(
            "An autopilot lets go of the limit when the attitude is back at zero, or beyond; the"
            f" response is shown until then, {shown.time:.3f} s."
        )
    elif shown.why == FALLEN:
        say(f"The response is shown until it exceeds 90 deg, {shown.time:.3f} s.")
        if case.sufficient:
            say(TURNED_OVER)


def _covers_the_wind(case: Held, shown: "Shown") -> bool:
    from tvclin.linear.extremes import WHOLE

    return shown.why == WHOLE or shown.time >= float(case.wind.end)


def _document(
    case: Held, found: "Extremes", loads: "Loads", verdict: "Verdict", shown: "Shown"
) -> dict[str, Any]:
    from tvclin.base.documents import picked

    left, whole = verdict.left_over, _covers_the_wind(case, shown)
    angle = picked(loads, "deg=peak_angle_of_attack time_s=peak_time relative_to_wind=relative")
    return {
        **picked(case, "vehicle=case.vehicle.name model=plant.model plane=case.plane"),
        "wind": {"shape": case.name, **picked(case.wind, "peak_deg duration_s=end")},
        **picked(case, "dead_band required_deg governed_by=governs limit_deg sufficient"),
        "shown_until": picked(shown, "time_s why"),
        "attitude": found,
        "peak_angle_of_attack": angle if whole else None,
        "verdict": {
            **picked(verdict, "stable residues_rad"),
            "left_over": str(left),
            **picked(left, "offset_deg rate_deg_per_s"),
        },
    }
