"""Flights of laws that are computed at a sample rate: their numbers for the kernel, and its answer.

Between samples the deflection moves as the nozzle does. All of a step is linear and exact while the
nozzle meets no limit. Where it meets one, and samples are far apart for it, the step is walked in
substeps; in one in which its rate or its stop bounds it the deflection goes evenly from where it
begins to where it ends.
"""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np

from tvclin.base.arrays import FloatArray, IntArray
from tvclin.control.laws.law import Measurement
from tvclin.flights.closed_loop.batch import Batch
from tvclin.flights.closed_loop.batch_arrays import flights
from tvclin.flights.closed_loop.law_batch import LawBatch
from tvclin.kernels import choice
from tvclin.kernels import flights as kernel
from tvclin.kernels.control_laws import LawNumbers
from tvclin.kernels.flight_arrays import NEVER, Flights
from tvclin.kernels.threads import in_slices

_TYPES = {float: np.float64, bool: np.bool_}


def flown(batch: Batch, *, track: bool = False) -> Flights:
    """Return the flights of a batch at their ends; of one alone with its track if asked for."""
    f = flights(batch, track=track)
    finish(f, batch.laws)
    return f


def finish(f: Flights, laws: LawBatch) -> None:
    """Fly flights of such laws to their ends."""
    if any(one is None for one in laws.numbers):
        _in_python(f, laws)
        return
    cases = f.cases.limit.size
    samples, first = float(_last(f).sum()), 0
    seconds = samples * kernel.PLAIN
    with np.errstate(all="ignore"):  # a lost flight may leave all numbers
        fly = choice.swiftest(kernel.fly, seconds)
        while first < cases and fly is kernel.fly:
            begun = perf_counter()  # one that stays open takes longer than was thought
            fly(f, first, first + 1)
            fly, first = choice.chosen(kernel.fly, perf_counter() - begun), first + 1
    if first < cases:
        compact = _compact(f)
        work = samples * kernel.COMPILED
        in_slices(lambda a, b: fly(compact, first + a, first + b), cases - first, work)


def _in_python(f: Flights, laws: LawBatch) -> None:
    """Fly laws that Python must be asked for, all flights of a law at once."""
    stepper, k = Stepper(f), 0
    engage, release = (
        np.array([getattr(law, name) for law in laws.laws], float)[f.cases.law]
        for name in ("engage", "release")
    )
    with np.errstate(all="ignore"):  # a lost flight may leave all numbers
        while stepper.look(k):
            going, demand = f.now.ended < 0, np.zeros(f.cases.limit.size)
            for place, law in enumerate(laws.laws):
                mine = np.flatnonzero(going & (f.cases.law == place))
                if mine.size:
                    demand[mine] = _asked(law, f, mine)
            stepper.advance(k, demand, engage, release)
            k += 1


class Stepper:
    """Flights that are moved by what stands beside them, a sample at a time."""

    def __init__(self, f: Flights) -> None:
        seconds = float(_last(f).sum()) * kernel.PLAIN / 2.0
        looks, moves = (choice.swiftest(one, seconds) for one in (kernel.look, kernel.advance))
        self._look, self._advance = looks, moves
        self._flights = f if looks is kernel.look else _compact(f)

    def look(self, k: int) -> int:
        """Look at all flights at a sample; return how many go on."""
        return self._look(self._flights, k)

    def advance(self, k: int, demand: FloatArray, engage: FloatArray, release: FloatArray) -> None:
        """Move all that go on by a sample, with what is asked of them [rad], each ``(m,)``."""
        self._advance(self._flights, k, demand, engage, release)


def _last(f: Flights) -> IntArray:
    """The samples that flights take at the least."""
    return np.where(f.cases.finish < NEVER, f.cases.finish, f.cases.ends + f.cases.settling)


def _asked(law: Any, f: Flights, mine: IntArray) -> FloatArray:
    """What a law asks for; one flight is told in plain numbers, which take half the time."""
    own = len(law.states[0])
    states, limit = f.now.states[mine, :own], f.cases.limit[mine]
    if mine.size > 1:
        asked = law.demand(Measurement(*f.now.measured[mine].T), states.T, limit)
    else:
        measured = Measurement(*f.now.measured[mine[0]].tolist())
        asked = law.demand(measured, states[0], float(limit[0]))
    return np.asarray(asked, dtype=float)


def _compact(f: Flights) -> Flights:
    """Flights whose laws are an array with their fields, for machine code."""
    kinds = [(name, _TYPES[type(value)]) for name, value in LawNumbers()._asdict().items()]
    numbers = np.array([tuple(one) for one in f.laws.numbers], dtype=kinds)
    return f._replace(laws=f.laws._replace(numbers=numbers))
