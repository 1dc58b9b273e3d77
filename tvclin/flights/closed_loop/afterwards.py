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
from tvclin.kernels.flight_arrays import NEVER, SURVIVED, UNDECIDED, Cases, Flights, Now

_STRETCH = 0.5
"""A stretch is this part of the time in which a flight settles."""
_QUIET = 2
"""After so many stretches without a limit a nozzle is at rest."""
_FULL_RATE = 0.999
"""A rate above this part of its limit is bounded by it."""


def swings_on(f: Flights, laws: LawBatch) -> BoolArray:
    """Return which of the flights that were brought back still meet limits long afterwards.

    `f`: at their ends. `laws`: of the flights; those of a law with noise are not flown on.
    """
    silent = np.array([not level for level, _ in laws.noise])[f.cases.law]
    left = np.flatnonzero((f.now.outcome == SURVIVED) & silent & (f.cases.settling > 0))
    quiet, g = np.zeros(left.size, dtype=int), f
    where = left
    for _ in range(int(WAITING / (SETTLING * _STRETCH))):
        if not left.size:
            break
        g = _flown_on(g, where, laws)
        limited = (g.now.peaks[:, 5] > 0.0) | (g.now.peaks[:, 3] >= _FULL_RATE * g.cases.rate_limit)
        quiet = np.where(limited, 0, quiet + 1)
        where = np.flatnonzero(quiet < _QUIET)
        left, quiet = left[where], quiet[where]
    found = np.zeros(f.cases.limit.size, dtype=bool)
    found[left] = True
    return found


def _flown_on(f: Flights, where: IndexArray, laws: LawBatch) -> Flights:
    """Some flights from where they ended through a stretch of still air."""
    rows = {name: getattr(f.laws, name) for name in ("memory", "seen", "told")}
    rows = {name: one[where] if len(one) > 1 else one for name, one in rows.items()}
    g = f._replace(
        winds=f.winds._replace(pieces=np.zeros_like(f.winds.pieces)),
        laws=f.laws._replace(**rows),
        cases=Cases._make(one[where] for one in f.cases),
        now=Now._make(one[where] for one in f.now),
    )
    ring = g.now.commands.shape[1]
    turned = (g.now.ended[:, np.newaxis] + np.arange(ring)) % ring  # samples count from zero again
    g.now.commands[:] = np.take_along_axis(g.now.commands, turned, axis=1)
    g.cases.start[:] += g.now.ended * g.steps.lengths[g.cases.vehicle, 0]
    g.cases.finish[:] = np.maximum(np.ceil(_STRETCH * g.cases.settling), 1)
    g.cases.ends[:] = NEVER
    g.now.outcome[:], g.now.ended[:], g.now.peaks[:] = UNDECIDED, -1, 0.0
    finish(g, laws)
    return g
