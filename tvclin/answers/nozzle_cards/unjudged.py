"""Flights and winds that a card cannot judge, with the reason and a remedy."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from tvclin.answers.nozzle_cards.record import CardPoint
from tvclin.answers.sizing.notes import flight_times, hundredths
from tvclin.ascent.measured_wind import MeasuredPlanes, MeasuredWind
from tvclin.ascent.schedule import FlightSchedule
from tvclin.flights.closed_loop.fly_many import NO_FLIGHT, UNDECIDED
from tvclin.flights.closed_loop.outcomes import decidable
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.modes import select_unstable

_PAIR = "two unstable poles are a pair, for which no test of loss is known"
"""Reason for a complex pair of unstable poles."""
_FIXED_PATH = "fixed-path"
"""Model without drift, in which there is no pair."""


def flight_reason(plant: AnyPlant, status: str) -> str:
    """Return why the flight of a plant cannot be judged; empty where it can."""
    if status == UNDECIDED:
        return "it is neither lost nor settled when it ends"
    if status != NO_FLIGHT:
        return ""
    if decidable(plant):
        return "its wind lasts for more than a million samples"
    poles = select_unstable(plant.poles)
    poles = poles[~np.isnan(poles)]
    if np.iscomplexobj(poles) and np.any(np.imag(poles) != 0.0):
        return _PAIR
    return (
        f"a test of loss is known for one or two unstable poles and a moment; it has {poles.size}"
    )


def unjudged_flights(law: str, points: Iterable[CardPoint], model: str) -> Iterator[str]:
    """Yield notes on flights of a law that cannot be judged: times, winds, reason and options."""
    rows = list(points)
    reasons: dict[str, list[CardPoint]] = {}
    for point in rows:
        if point.why:
            reasons.setdefault(point.why, []).append(point)
    unjudged = {point.time for affected in reasons.values() for point in affected}
    judged = {point.time for point in rows} - unjudged
    for reason, affected in reasons.items():
        remedies = []
        if judged and max(unjudged) < min(judged):
            remedies.append(f"--from {min(judged):.6g} leaves these times out")
        elif judged and min(unjudged) > max(judged):
            remedies.append(f"--to {max(judged):.6g} leaves these times out")
        if reason == _PAIR and model != _FIXED_PATH:
            remedies.append(f"--model {_FIXED_PATH} judges them without drift")
        winds = list(dict.fromkeys(point.wind for point in affected))
        where = winds[0] if len(winds) == 1 else f"{len(winds)} winds"
        remedy = f" ({', '.join(remedies)})" if remedies else ""
        times = flight_times({point.time for point in affected})
        yield f"the flight of {law} at {times} in {where}: {reason}{remedy}"


def unknown_winds(
    schedule: FlightSchedule, winds: Mapping[str, Any], unknown: Mapping[str, dict[float, str]]
) -> Iterator[str]:
    """Yield notes on winds that are not known at some heights, and options that omit these.

    `unknown`: by wind, the flight times [s] at which it is not known, with the reason; an empty
    reason for the end of a sounding.
    """
    for name, times in unknown.items():
        wind = winds[name]
        if isinstance(wind, MeasuredWind | MeasuredPlanes):
            first, last = wind.known
            early, late = min(times) < first, max(times) > last
            if early:
                yield (
                    f"{name} is not known below {schedule.altitude_text(first)}:"
                    f" --from {hundredths(first, up=True)} begins there"
                )
            if late:
                yield (
                    f"{name} is not known above {schedule.altitude_text(last)}:"
                    f" --to {hundredths(last, up=False)} ends there"
                )
        reasons = {time: why for time, why in times.items() if why}
        if reasons:
            yield f"{name} at {flight_times(reasons)}: {reasons[min(reasons)]}"
