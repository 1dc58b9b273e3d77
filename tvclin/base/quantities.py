"""The quantities of a verdict, each with its one sentence, and the words of verdicts."""

from __future__ import annotations

FORECAST_FREE = (
    "law without a forecast that must survive the wind even if it stops for good at any instant"
)
"""Laws of which the lower bound without a forecast holds; another one may require less."""
QUANTITIES = {
    "static trim": "the largest size of B alpha_w at nominal dynamic pressure, without drift",
    "trim along the path": "the largest deflection of ideal trim, unlimited, with drift, at the"
    " dynamic pressure encountered",
    "boundary limit": "y(K) of eq (4b) at nominal dynamic pressure, a ratio to static trim",
    "required deflection": "the smallest limit from which on every limit survives, for the ideal"
    " trim law, in the wind's own angle and dynamic pressure, the worst of what is not known; the"
    " verdict stands on it",
    "lower bound, wind known": "the minimum peak of appendix C: no control needs less",
    "lower bound, no forecast": f"no {FORECAST_FREE} requires less",
    "autopilot requirement": "the smallest limit from which on every limit survives, for one"
    " autopilot as it is modelled: samples, delay, actuator, filters, bending, rate limit",
    "budget": "the required deflection with nominal flight, offsets, dispersions and reserve",
    "available": "the deflection limit of the nozzle",
    "remaining": "the available deflection minus what is required",
    "survivable peak": "the largest peak of a wind of this shape and duration that the limit"
    " survives, up to a wind angle of 30 deg; of a wind by its speed the nominal angle of the"
    " largest speed, which is smaller or larger than the peak that survives as an angle",
    "required rate": "the smallest rate limit with which a control that knows the wind survives"
    " with the deflection limit, with K = 1 a lower bound of laws without a forecast; along a"
    " flight, that of a ramp for the required deflection",
    "controllability ratio": "the available deflection over static trim with all that adds up; it"
    " takes the wind for lasting",
}
"""The quantities, by name; each sentence stands here alone."""

STATIC_TRIM = "static trim"
WIND_KNOWN, NO_FORECAST = "lower bound, wind known", "lower bound, no forecast"
REQUIRED, REQUIREMENT, BUDGET = "required deflection", "autopilot requirement", "budget"
REQUIRED_RATE = "required rate"
OF_RAMP = f"of a ramp for the {REQUIRED}"
"""Definition of the required rate along a flight: not that of a control that knows the wind."""
NOMINAL = "at nominal dynamic pressure"
"""Of an answer that leaves out the dynamic pressure that the wind itself makes."""
FROZEN_ALONG = "with the vehicle frozen at each flight time"
"""Of an answer over a flight: flights with varying parameters may answer otherwise."""
NO_LIMIT = "no limit is sufficient, the largest that was tried is lost"
"""Of an autopilot that some limits may survive, but none from which on every limit does."""


def sufficiency(answer: bool | None) -> str:
    """Return the verdict on a deflection limit: SUFFICIENT, NOT SUFFICIENT or NOT KNOWN.

    `answer`: whether it is sufficient; None where that is not known.
    """
    return _word(answer, "SUFFICIENT")


def satisfaction(answer: bool | None) -> str:
    """Return whether criteria are satisfied, `answer`: MET, NOT MET, or NOT KNOWN for None."""
    return _word(answer, "MET")


def survival(answer: bool | None) -> str:
    """Return the outcome of a flight, `answer`: SURVIVED, NOT SURVIVED, or NOT KNOWN for None."""
    return _word(answer, "SURVIVED")


def _word(answer: bool | None, word: str) -> str:
    """Return `word` for the `answer` True, NOT `word` for False, and NOT KNOWN for None."""
    return {True: word, False: f"NOT {word}", None: "NOT KNOWN"}[answer]
