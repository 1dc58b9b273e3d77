"""What rows of gains need with a stop, flown: each only as closely as the search needs it.

A row is flown with falling limits until one is lost, so that what counts is the highest limit that
is lost, as in `closed_loop_boundary`. A row that loses above what is already known is left there.
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
"""Limits among which it is sought, over the largest trim deflection; as `closed_loop_boundary`."""
_COARSE = 0.9
"""From one of the falling limits to the next."""
_AT_ONCE = 4
"""So many of them are flown together."""
_PARTS, _FINER = 8, 3
"""The last step is cut in so many parts, and the lost one of them again, so often: 1/512 of it."""
_ABOVE = 1.5
"""Up to so many times what was found no window of losses may lie."""


def stopped(winds: tuple[History, ...], stops: int) -> History:
    """Return winds and the same with so many sudden stops, at even instants, as one batch."""
    one = reduce(add, (wind * row for wind, row in zip(winds, np.eye(len(winds)), strict=True)))
    times = np.linspace(one.onset, one.end, stops + 2)[1:]
    whole = one.before(times)
    return whole.cases(np.arange(times.size), times.shape)


def needs(question: Question, points: FloatArray, goal: float, clean: int) -> FloatArray:
    """Return the limit that each row of gains needs, over the largest trim, ``(n,)``.

    `points`: of the unit box, ``(n, axes)``. `goal`: above it a limit need not be known closely.
    `clean`: so many limits above what was found are flown as well: windows of losses lie there.
    """
    rows = question.autopilot(points)
    winds = stopped(question.winds, question.stops)
    steps = int(np.ceil(np.log(LOWEST / HIGHEST) / np.log(_COARSE)))
    falling = HIGHEST * _COARSE ** np.arange(steps + 1)
    above = int(np.sum(falling > goal)) + 1
    lost, survived = np.full(len(points), np.inf), np.full(len(points), np.inf)
    going, first, size = np.arange(len(points)), 0, max(_AT_ONCE, above)
    while going.size and first < falling.size:
        limits = falling[first : first + size]
        outcome = _survive(question, rows, going, winds, np.tile(limits, (going.size, 1)))
        at = np.where(outcome.all(axis=1), limits.size, np.argmin(outcome, axis=1))
        lasts = np.where(at > 0, limits[at - 1], survived[going])
        survived[going] = lasts
        ends = at < limits.size
        lost[going[ends]] = limits[at[ends]]
        going, first, size = going[~ends], first + size, _AT_ONCE
    survived[going] = lost[going] = falling[-1]  # whatever was tried is enough
    close = np.flatnonzero(np.isfinite(survived) & (lost < goal) & (lost < survived))
    for _ in range(_FINER):
        if not close.size:
            break
        parts = np.linspace(survived[close], lost[close], _PARTS + 1, axis=1)
        outcome = _survive(question, rows, close, winds, parts[:, 1:-1])
        at = np.where(outcome.all(axis=1), _PARTS - 1, np.argmin(outcome, axis=1))
        survived[close], lost[close] = (
            np.take_along_axis(parts, (at + k)[:, np.newaxis], axis=1)[:, 0] for k in (0, 1)
        )
    near = np.flatnonzero(survived < goal)
    if near.size:
        scan = survived[near, np.newaxis] * np.linspace(1.0, _ABOVE, clean + 1)
        lossy = ~_survive(question, rows, near, winds, scan)
        highest = clean - np.argmax(lossy[:, ::-1], axis=1)  # the last that is lost
        above = scan[np.arange(near.size), np.minimum(highest + 1, clean)]
        survived[near] = np.where(lossy.any(axis=1), above, survived[near])
    return survived


def _survive(
    question: Question, rows: Autopilot, which: IndexArray, winds: History, limits: FloatArray
) -> BoolArray:
    """Which of the limits ``(k, n)``, over the largest trim, the rows survive in all winds."""
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
