"""The verdict on flights of an autopilot along a flight, of which some are not known."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tvclin.studyfile.flight_loop import FlightOutcome, FlightsOfLoop


def outcome(wind: str, time: float, survived: bool | None) -> FlightOutcome:
    reason = {True: "", False: "diverges", None: "no structure"}[survived]
    return FlightOutcome(wind, time, None, "survived", survived, reason, 0.01, 0.0, 0.0, 0.0, time)


def flights(*outcomes: FlightOutcome) -> FlightsOfLoop:
    worst: Any = SimpleNamespace(units={}, largest=None)  # the outputs over time, which no word has
    return FlightsOfLoop(outcomes, worst, np.radians(1.2), np.array([]), np.array([]))


def test_what_is_not_known_is_neither_survived_nor_lost() -> None:
    """Wind a is lost at one time, b not known at one, c survived at both."""
    a = outcome("a", 50.0, None), outcome("a", 60.0, False)
    b = outcome("b", 50.0, None), outcome("b", 60.0, True)
    c = outcome("c", 50.0, True), outcome("c", 60.0, True)
    of_all = "flights: a at 60 s, diverges; NOT KNOWN in 2 of 6 flights: b at 50 s, no structure"
    counts = "1 of 3 winds survived, 1 NOT KNOWN"
    mixed = flights(*a, *b, *c)
    unknown = flights(*b, outcome("a", 60.0, None))

    assert mixed.verdict == f"NOT SURVIVED with 1.200 deg in 1 of 6 {of_all}; {counts}"
    assert mixed.reason == mixed.verdict.removeprefix("NOT SURVIVED ")
    assert mixed.document()["fraction"] is unknown.fraction is None
    assert unknown.verdict.startswith("NOT KNOWN with 1.200 deg in 2 of 3 flights: ")
    assert unknown.verdict.endswith(", no structure; 0 of 2 winds survived, 2 NOT KNOWN")
    assert flights(*b).verdict.endswith(" in 1 of 2 flights: b at 50 s, no structure")


def test_the_fraction_of_known_winds_has_its_interval() -> None:
    """Of two, one survived: the ends are 1 - sqrt(1 - 0.05) and its complement."""
    lost, good = outcome("a", 50.0, False), outcome("b", 50.0, True)
    fraction = flights(lost, good).fraction

    assert fraction.estimate == 0.5
    assert fraction.lower == pytest.approx(1.0 - np.sqrt(0.95))
    assert fraction.upper == pytest.approx(np.sqrt(0.95))
    assert flights(lost, good).outcome == "NOT SURVIVED in 1 of 2 winds"
    assert (
        flights(good).verdict
        == "SURVIVED with 1.200 deg in 1 wind, largest deflection 0.573 deg at 50 s"
    )
