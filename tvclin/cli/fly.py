"""`tvclin fly`: one flight in one wind, compared with the linear theory."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import typer

from tvclin.ascent.flight_condition import load_flight_condition
from tvclin.base.errors import Faults, one_of, within
from tvclin.base.lines import listed
from tvclin.cli.flight_cases import REPORT, Flying, flight_case, fly_nonlinear
from tvclin.cli.fly_linear import LinearCase, fly_linear
from tvclin.cli.gains import FlownLaw
from tvclin.cli.inputs import case_of, chosen, note_left_out, only_with
from tvclin.cli.options import (
    GROUP,
    LIMIT,
    PLANE,
    RATE_LIMIT,
    At,
    Given,
    Points,
    Rigid,
    ShownCurves,
    Source,
    Until,
    asked,
    switch,
)
from tvclin.cli.progress import waiting
from tvclin.cli.wind import WindOptions
from tvclin.control.laws.registry import AUTOPILOT, LAWS
from tvclin.flights.flown_boundary import ENGINES
from tvclin.studyfile.read import vehicle_source
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.vehicle.linear_vehicle import complete_vehicle

_MAX_UNTIL = 20.0
"""Largest --until, in durations of the wind."""


@dataclass(frozen=True)
class WhatFlies:
    """Options of the engine, the law and its dead band; `grouped` gives them to a command."""

    engine: str | None = asked(
        "planar: nonlinear equations in one plane; sixdof: JSBSim, six degrees of freedom;"
        " linear: linear equations with bending and slosh, a sampled law and an actuator.",
        shown="linear for a flexible vehicle, else planar",
    )
    law: str | None = asked(
        f"Control law: {listed((REPORT, *LAWS), 'or')}; gains below are of {AUTOPILOT}.",
        shown="autopilot for --engine linear, else report",
    )
    dead_band: float | None = asked(
        "Dead band K of the laws report and dead-band.", shown="1 for report, 0.5 for dead-band"
    )

    def __post_init__(self) -> None:
        if self.engine is not None:
            one_of("--engine", self.engine, (*ENGINES, "linear"))
        one_of("--law", self.law or REPORT, [REPORT, *LAWS])

    def on(
        self,
        source: str,
        case: StudyPlan,
        along: bool,
        flies: FlownLaw,
        rate_limit: Given,
        rigid: bool,
    ) -> tuple[str, str, Any]:
        """Return engine, law and dead band for a case, and print what they neglect of its file.

        Options of another engine or law are refused first.
        """
        bends = complete_vehicle(case.vehicle, "a flight").structure is not None
        engine = self.engine or ("linear" if bends and not along else "planar")
        law = self.law or (AUTOPILOT if engine == "linear" else REPORT)
        if law != AUTOPILOT:
            flies.only_with_autopilot(source)
        if engine == "linear":
            only_with("--engine planar or sixdof", along_trajectory=along)
        else:
            unused = rigid and self.engine is not None
            only_with("--engine linear", rigid=unused)
            for group in (flies.timing, rate_limit):
                group.only_with("--engine linear")
        aside = ["fly without --law autopilot"] * (law != AUTOPILOT)
        note_left_out(case, "fly", *aside, *["fly --engine planar"] * (engine != "linear"))
        return engine, law, chosen(self.dead_band, case.dead_band if law == REPORT else None)


def fly(
    vehicle: Source = "configuration-i",
    time: At = None,
    winds: WindOptions = GROUP,
    what: WhatFlies = GROUP,
    limit: Given = replace(LIMIT, shown={"limit": "1.1 times the linear boundary"}),
    rate_limit: Given = RATE_LIMIT,
    flies: FlownLaw = GROUP,
    rigid: Rigid = False,
    along_trajectory: bool = switch(
        "--along-trajectory", "Let mass, speed and dynamic pressure change in flight."
    ),
    boundary: bool = switch("--boundary", "Also find, by flights, the least limit that survives."),
    plane: Given = PLANE,
    until: Until = 2.0,
    points: Points = 401,
    shown: ShownCurves = GROUP,
) -> None:
    """Fly a vehicle through a wind with a control law, beside the prediction of the linear theory.

    A vehicle file with bending, slosh, engine inertia or sensor lags makes a flexible vehicle: that
    is flown with a sampled law, beside the rigid one. --rigid leaves all that out.

    It is at nominal dynamic pressure, and with --along-trajectory at that encountered in the wind;
    tvclin study is the verdict on a limit.

    Exit code 0: SURVIVED; 1: NOT SURVIVED, or NOT KNOWN, in a wind of more than 30 deg; 2: bad
    input.
    """
    within("--until", until, 1.0, _MAX_UNTIL, "durations of the wind")
    within("--points", points, 2, 1_000_000)
    changes = [options.over for options in (limit, rate_limit, plane, flies)]
    case = case_of(vehicle, *changes, rigid=rigid, time=time)
    engine, *law = what.on(vehicle, case, along_trajectory, flies, rate_limit, rigid)
    name = winds.name(case)
    condition, faults = None, Faults()
    with faults.kept():
        case = (winds.in_flight if along_trajectory else winds.over)(case, vehicle)
    with faults.kept():
        condition = load_flight_condition(vehicle_source(vehicle)) if along_trajectory else None
    faults.tell()
    start, length = float(case.history.onset), until * float(case.history.end - case.history.onset)
    if engine == "linear":
        with waiting("flying"):
            flying = LinearCase(case, name, *law)
            comparison = fly_linear(flying, boundary, start + np.linspace(0.0, length, points))
    else:
        nonlinear = flight_case(Flying(case, name, *law), engine, condition, length)
        with waiting("flying"):
            comparison = fly_nonlinear(nonlinear, boundary, length, points)
    if not comparison.show(shown):
        raise typer.Exit(1)
