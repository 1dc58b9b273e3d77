"""Whether an oscillation persists between the limits after a flight has been brought back.

Where the loop is damped near rest it may still swing for ever once it is large enough: a nozzle at
its rate limit lags, and one at its stop does less than is asked of it. That is seen only by flying
on in still air. What swings on so meets a limit again and again.
"""

from __future__ import annotations

import numpy as np

from tvclin.base.arrays import BoolArray, IndexArray
from tvclin.flights.closed_loop.law_batch import LawBatch
from tvclin.flights.closed_loop.outcomes import SETTLING, WAITING
from tvclin.flights.closed_loop.sampled import finish
from tvclin.kernels.flight_arrays import NEVER, SURVIVED, UNDECIDED, Flights

_STRETCH = 0.5
"""A stretch is this part of the time in which a flight settles."""
_QUIET = 2
"""After so many stretches without a limit a nozzle is at rest."""
_FULL_RATE = 0.999
"""A rate above this part of its limit is bounded by it."""

_SHARED = {"memory", "seen", "told"}
"""One for each flight, or one for all."""
_OF_EACH = (
    *("vehicle", "wind", "law", "gain", "limit", "rate_limit", "start", "finish", "ends"),
    *("waiting", "settling", "sequence", "y", "states", "here", "sensed", "measured", "next"),
    *("series", "commands", "mode", "bounded", "peaks", "piece", "settled", "outcome", "ended"),
)
"""Arrays of `Flights` with a row for each flight."""


def swings_on(f: Flights, laws: LawBatch) -> BoolArray:
    """Return which of the flights that were brought back still meet limits long afterwards.

    `f`: at their ends. `laws`: of the flights; those of a law with noise are not flown on.
    """
    silent = np.array([not level for level, _ in laws.noise])[f.law]
    left = np.flatnonzero((f.outcome == SURVIVED) & silent & (f.settling > 0))
    quiet, g = np.zeros(left.size, dtype=int), f
    where = left
    for _ in range(int(WAITING / (SETTLING * _STRETCH))):
        if not left.size:
            break
        g = _flown_on(g, where, laws)
        limited = (g.peaks[:, 5] > 0.0) | (g.peaks[:, 3] >= _FULL_RATE * g.rate_limit)
        quiet = np.where(limited, 0, quiet + 1)
        where = np.flatnonzero(quiet < _QUIET)
        left, quiet = left[where], quiet[where]
    found = np.zeros(f.limit.size, dtype=bool)
    found[left] = True
    return found


def _flown_on(f: Flights, where: IndexArray, laws: LawBatch) -> Flights:
    """Some flights from where they ended through a stretch of still air."""
    own = {name for name in _SHARED if len(getattr(f, name)) > 1}
    rows = {name: getattr(f, name)[where] for name in {*_OF_EACH, *own}}
    g = f._replace(pieces=np.zeros_like(f.pieces), **rows)
    ring = g.commands.shape[1]
    turned = (g.ended[:, np.newaxis] + np.arange(ring)) % ring  # samples count from zero again
    g.commands[:] = np.take_along_axis(g.commands, turned, axis=1)
    g.start[:] += g.ended * g.lengths[g.vehicle, 0]
    g.finish[:] = np.maximum(np.ceil(_STRETCH * g.settling), 1)
    g.ends[:] = NEVER
    g.outcome[:], g.ended[:], g.peaks[:] = UNDECIDED, -1, 0.0
    finish(g, laws)
    return g
