"""Limits that rows of gains require, by flights, only as accurately as the search needs them.

A row is flown with falling limits until a flight is lost, so that the highest lost limit counts, as
in `closed_loop_boundary`. A row with a loss above the goal is not bracketed any closer.
"""

from __future__ import annotations

from functools import reduce
from operator import add

import numpy as np

from tvclin.answers.least_gains.question import Question
from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.flights.closed_loop.fly_many import MAX_DEFLECTION_LIMIT, SURVIVED, fly_many
from tvclin.winds.histories import History

HIGHEST, LOWEST = 2.0, 0.02
"""Range of limits, normalised by the largest trim deflection; as of `closed_loop_boundary`."""
_LIMIT_RATIO = 0.9
"""Ratio of each falling limit to the limit before it."""
_LIMITS_TOGETHER = 4
"""Number of falling limits that are flown together."""
_SUBDIVISIONS, _REFINEMENTS = 8, 3
"""Parts of a bracket of the boundary, and number of subdivisions: to 1/512 of the last step."""
_MAX_SCAN_RATIO = 1.5
"""End of the scan for windows of losses, as a ratio to the required limit."""


def stopped(winds: tuple[History, ...], stops: int) -> History:
    """Return winds as a batch, each whole and with `stops` sudden ends at even instants."""
    combined = reduce(
        add, (wind * row for wind, row in zip(winds, np.eye(len(winds)), strict=True))
    )
    times = np.linspace(combined.onset, combined.end, stops + 2)[1:]
    return combined.before(times).cases(np.arange(times.size), times.shape)


def needs(question: Question, points: FloatArray, goal: float, clean: int) -> FloatArray:
    """Return the limit that each row of gains requires, normalised by the largest trim, ``(n,)``.

    `points`: in the unit box, ``(n, axes)``. `goal`: limit above which no accuracy is needed.
    `clean`: number of limits above the required limit that are flown as well, because windows of
    losses lie there.
    """
    rows = question.autopilot(points)
    winds = stopped(question.winds, question.stops)
    steps = int(np.ceil(np.log(LOWEST / HIGHEST) / np.log(_LIMIT_RATIO)))
    falling = HIGHEST * _LIMIT_RATIO ** np.arange(steps + 1)
    above = int(np.sum(falling > goal)) + 1
    lost, survived = np.full(len(points), np.inf), np.full(len(points), np.inf)
    open_rows, first, size = np.arange(len(points)), 0, max(_LIMITS_TOGETHER, above)
    while open_rows.size and first < falling.size:
        limits = falling[first : first + size]
        outcome = _survive(question, rows, open_rows, winds, np.tile(limits, (open_rows.size, 1)))
        at = np.where(outcome.all(axis=1), limits.size, np.argmin(outcome, axis=1))
        lasts = np.where(at > 0, limits[at - 1], survived[open_rows])
        survived[open_rows] = lasts
        ends = at < limits.size
        lost[open_rows[ends]] = limits[at[ends]]
        open_rows, first, size = open_rows[~ends], first + size, _LIMITS_TOGETHER
    survived[open_rows] = lost[open_rows] = falling[-1]  # the lowest limit is sufficient
    bracketed = np.flatnonzero(np.isfinite(survived) & (lost < goal) & (lost < survived))
    for _ in range(_REFINEMENTS):
        if not bracketed.size:
            break
        brackets = np.linspace(survived[bracketed], lost[bracketed], _SUBDIVISIONS + 1, axis=1)
        outcome = _survive(question, rows, bracketed, winds, brackets[:, 1:-1])
        at = np.where(outcome.all(axis=1), _SUBDIVISIONS - 1, np.argmin(outcome, axis=1))
        survived[bracketed], lost[bracketed] = (
            np.take_along_axis(brackets, (at + k)[:, np.newaxis], axis=1)[:, 0] for k in (0, 1)
        )
    candidates = np.flatnonzero(survived < goal)
    if candidates.size:
        scan = survived[candidates, np.newaxis] * np.linspace(1.0, _MAX_SCAN_RATIO, clean + 1)
        lossy = ~_survive(question, rows, candidates, winds, scan)
        highest = clean - np.argmax(lossy[:, ::-1], axis=1)  # index of the highest lost limit
        above = scan[np.arange(candidates.size), np.minimum(highest + 1, clean)]
        survived[candidates] = np.where(lossy.any(axis=1), above, survived[candidates])
    return survived


def _survive(
    question: Question, rows: Autopilot, which: IndexArray, winds: History, limits: FloatArray
) -> BoolArray:
    """Return whether rows survive all winds with limits relative to trim, ``(k, n)``."""
    law = Autopilot(
        attitude_gain=rows.attitude_gain[which, np.newaxis, np.newaxis],  # type: ignore[index]
        rate_gain=rows.rate_gain[which, np.newaxis, np.newaxis],  # type: ignore[index]
        alpha_gain=rows.alpha_gain[which, np.newaxis, np.newaxis],  # type: ignore[index]
        **question.chains,
    )
    flown = fly_many(
        question.plant,
        law,
        winds,
        deflection_limit=np.minimum(
            limits[..., np.newaxis] * question.trims.max(), MAX_DEFLECTION_LIMIT
        ),
        actuator=question.actuator,
        sample_rate=question.flown_rate,
        delay=question.delay,
    )
    return np.all(flown.status == SURVIVED, axis=-1)
