"""Flights of laws that are computed at a sample rate, each stepped exactly from sample to sample.

The element is any linear system. From one sample to the next its states y, those of the vehicle
and then those of the nozzle, the command c, and the wind as a polynomial w0 + w1 u + ... about
the start of the step make

    y <- J [y, c, w0, w1, ...],

which is exact while the nozzle meets no limit. In a step in which its rate or its stop bounds it,
the deflection goes evenly from where it begins to where it ends. A command that takes effect
between two samples, by a computing delay, parts each step in two.
"""

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels.control_laws import asked, slow_ends, switched
from tvclin.kernels.flight_arrays import LOST, MEASURED, NEVER, SURVIVED, UNDECIDED, Flights
from tvclin.kernels.source import bare, inlined

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

SETTLED = 0.3
"""Saved: every unstable coordinate is below this part of the reach for a while."""
LOOK = 8
"""Samples between two looks at a flight."""
_BEYOND = 1.0 + 1e-9
"""Over the stop: a nozzle that rests on it is not told apart from one that is just leaving."""
_TERMS = 24
"""Of the series of a wind that begins within a step."""


@bare
def fly(f: Flights, first: int, last: int) -> None:
    """Fly the cases from `first` up to `last`, each to its end."""
    for i in range(first, last):
        law = f.laws[f.law[i]]
        for k in range(NEVER):
            if not looked(f, i, k):
                break
            demand = asked(law, f.measured[i], f.states[i], f.limit[i])
            stepped(f, i, k, demand, law.engage, law.release)


@bare
def look(f: Flights, k: int) -> int:
    """Look at all flights at a sample; return how many go on."""
    some = 0
    for i in range(f.limit.size):
        if f.ended[i] < 0 and looked(f, i, k):
            some += 1
    return some


@bare
def advance(
    f: Flights, k: int, demand: FloatArray, engage: FloatArray, release: FloatArray
) -> None:
    """Move all flights that go on by a sample, with what laws in Python ask for, ``(m,)``."""
    for i in range(f.limit.size):
        if f.ended[i] < 0:
            stepped(f, i, k, demand[i], engage[i], release[i])


@inlined
def looked(f: Flights, i: int, k: int) -> bool:
    """Write what a law is shown at a sample; return whether the flight goes on."""
    p, peaks, sensed, x = f.vehicle[i], f.peaks[i], f.sensed[i], f.y[i]
    n = f.A.shape[1]
    about(f, i, f.start[i] + f.lengths[p, 0] * k)
    for r in range(4):
        total = f.shown[p, r, n] * f.here[i, 0]
        for j in range(n):
            total += f.shown[p, r, j] * x[j]
        sensed[r] = total
    sensed[4] = min(max(x[n], -f.limit[i]), f.limit[i])
    raised(peaks, 0, x[0])
    raised(peaks, 1, x[1])
    raised(peaks, 4, sensed[3])
    after = k - f.ends[i]
    if after > 0 and after % LOOK == 0 and f.outcome[i] != LOST:
        judged(f, i)
    going = f.outcome[i] == UNDECIDED and after < f.waiting[i]
    if k >= f.finish[i] or (not going and f.finish[i] == NEVER):
        f.ended[i] = k
        return False
    if k < f.noise.shape[1]:
        sensed[1] += f.noise[f.sequence[i], k]
    for r in range(MEASURED):
        f.measured[i, r] = sensed[r]
    if f.seen.shape[0]:
        own = i if f.seen.shape[0] > 1 else 0
        for r in range(MEASURED):
            f.measured[i, r] = filtered(f, i, f.seen[own, r])
    return True


@inlined
def filtered(f: Flights, i: int, row: FloatArray) -> float:
    """Return what a row makes of the states of a law and of what is sensed."""
    s, total = f.states.shape[1], 0.0
    for j in range(s):
        total += row[j] * f.states[i, j]
    for j in range(MEASURED + 1):
        total += row[s + j] * f.sensed[i, j]
    return total


@inlined
def raised(peaks: FloatArray, row: int, value: float) -> None:
    """Keep the largest size."""
    peaks[row] = max(peaks[row], abs(value))


@inlined
def about(f: Flights, i: int, now: float) -> None:
    """Write the polynomial of the wind about a time in its piece."""
    here, w, j = f.here[i], f.wind[i], f.piece[i]
    polynomial(f.pieces, f.knots, w, j, now, here)


@inlined
def polynomial(
    pieces: FloatArray, knots: FloatArray, w: int, j: int, now: float, here: FloatArray
) -> None:
    """Write the coefficients of a piece of a wind about a time; zeros before the first.

    The Taylor shift c(v) -> c(u + v), by Horner's scheme again and again.
    """
    terms = here.size
    if j < 0:
        for r in range(terms):
            here[r] = 0.0
        return
    u = now - knots[w, j]
    for r in range(terms):
        here[r] = pieces[w, j, r]
    for low in range(terms - 1):
        for r in range(terms - 2, low - 1, -1):
            here[r] += here[r + 1] * u


@inlined
def judged(f: Flights, i: int) -> None:
    """Decide a flight after its wind, if that can be done; one that was saved may yet be lost.

    Lost outside the recoverable set |z1| < D, slow_ends(z1) about z2 (see `boundary.recoverable`,
    whose rows times the states are z1 and z2); saved when both stay below a part of D for a while.
    """
    p = f.vehicle[i]
    reach, ratio = f.reach[p] * f.limit[i], f.ratio[p]
    if not reach > 0.0:
        return
    fast, slow = 0.0, 0.0
    for j in range(f.judges.shape[2]):
        fast += f.judges[p, 0, j] * f.y[i, j]
        slow += f.judges[p, 1, j] * f.y[i, j]
    recoverable = abs(fast) < reach
    if recoverable and ratio > 0.0:
        low, high = slow_ends(fast / reach, ratio)
        recoverable = low * reach < slow < high * reach
    if not recoverable:
        f.outcome[i] = LOST
        return
    f.settled[i] = f.settled[i] + LOOK if max(abs(fast), abs(slow)) < SETTLED * reach else 0
    if f.settled[i] >= f.settling[i]:
        f.outcome[i] = SURVIVED


@inlined
def stepped(f: Flights, i: int, k: int, demand: float, engage: float, release: float) -> None:
    """Move a flight by a sample.

    The command of sample k acts from k + late on, or where the delay is no whole number of samples
    within that step: its first part (1) still has the command before, its second (0) this one.
    """
    p, limit, sensed = f.vehicle[i], f.limit[i], f.sensed[i]
    demand = f.gain[i] * demand
    sensed[MEASURED] = demand
    if f.told.shape[0]:
        demand = filtered(f, i, f.told[i if f.told.shape[0] > 1 else 0])
    mode = switched(engage * limit, release * limit, demand, f.mode[i])
    f.mode[i] = mode
    command = mode * limit if mode != 0.0 else min(max(demand, -limit), limit)
    if abs(command) >= limit:
        f.peaks[i, 5] += 1.0
    begin = f.start[i] + f.lengths[p, 0] * k
    end = f.start[i] + f.lengths[p, 0] * (k + 1)
    parts, ring, since = f.joint.shape[1], f.commands.shape[1], k - f.late[p]
    if ring > 1:
        f.commands[i, k % ring] = command
    for part in range(parts - 1, -1, -1):
        now = f.commands[i, (since - part) % ring] if ring > 1 else command
        stop = begin + f.lengths[p, 2] if part > 0 else end
        moved(f, i, part, parts * (k + 1) - 1 - part, now, begin, stop)
        if part > 0:
            about(f, i, stop)
        begin = stop
    learnt(f, i)
    n = f.A.shape[1]
    deflection = min(max(f.y[i, n], -limit), limit)
    raised(f.peaks[i], 2, deflection)
    raised(f.peaks[i], 3, (deflection - sensed[4]) / f.lengths[p, 0])


@inlined
def moved(f: Flights, i: int, part: int, row: int, c: float, begin: float, end: float) -> None:
    """Move vehicle and nozzle through a part of a step, with the command c."""
    p, n, y, new = f.vehicle[i], f.A.shape[1], f.y[i], f.next[i]
    freely(f, i, f.joint[p, part], c)
    bounded = held_back(f, i, part, c)
    limit = f.limit[i]
    last = min(max(new[n], -limit), limit)
    if bounded:
        first = min(max(y[n], -limit), limit)
        evenly(f, i, f.joint[p, part], f.ramp[p, part], first, last)
        if f.ramp.shape[3] > 2:
            jerked(f, i, f.ramp[p, part])
    size = y.size
    if row < f.track.shape[0]:
        for r in range(size):
            f.track[row, r] = y[r]
        f.track[row, size], f.track[row, size + 1] = c, last
        f.track[row, size + 2] = 1.0 if bounded else 0.0
    for r in range(size):
        y[r] = new[r]
    blown(f, i, begin, end)


@inlined
def freely(f: Flights, i: int, J: FloatArray, c: float) -> None:
    """Write J [y, c, w0, w1, ...]."""
    y, here, new = f.y[i], f.here[i], f.next[i]
    size = y.size
    for r in range(size):
        total = 0.0
        for j in range(here.size):
            total += J[r, size + 1 + j] * here[j]
        for j in range(size):
            total += J[r, j] * y[j]
        new[r] = total + J[r, size] * c


@inlined
def held_back(f: Flights, i: int, part: int, c: float) -> bool:
    """Return whether rate or stop bound the nozzle in a part, and bound where it comes to.

    One of first order sets out with omega (c - s) and is slower ever after: `quick` is omega times
    the length of the part, so that it is compared with what the limited rate covers in it.
    """
    p, n, y, new, most = f.vehicle[i], f.A.shape[1], f.y[i], f.next[i], f.rate_limit[i]
    reach = most * f.lengths[p, 1 + part]
    bounded = abs(c - y[n]) * f.quick[p, part] > reach
    if max(abs(new[n]), abs(y[n])) > _BEYOND * f.limit[i]:
        bounded = True
    if abs(new[n] - y[n]) > reach:
        bounded = True
        new[n] = y[n] + (reach if new[n] > y[n] else -reach)
    if y.size > n + 1 and max(abs(new[n + 1]), abs(y[n + 1])) >= most:
        bounded = True
        new[n + 1] = min(max(new[n + 1], -most), most)
    return bounded


@inlined
def evenly(f: Flights, i: int, J: FloatArray, ramp: FloatArray, first: float, last: float) -> None:
    """Write the states of the vehicle where the deflection goes evenly from first to last.

    x <- Phi x + ramp [first, last] + the wind's part of J.
    """
    n, y, here, new = f.A.shape[1], f.y[i], f.here[i], f.next[i]
    for r in range(n):
        total = ramp[r, 0] * first + ramp[r, 1] * last
        for j in range(here.size):
            total += J[r, y.size + 1 + j] * here[j]
        for j in range(n):
            total += J[r, j] * y[j]
        new[r] = total


@inlined
def jerked(f: Flights, i: int, ramp: FloatArray) -> None:
    """Add what an engine with inertia does to the vehicle when its rate jumps, at both ends.

    The even rate v of a part follows the rate before and is followed by that after: the
    acceleration is (v - before) and (after - v) as impulses. What v does is in the first columns.
    """
    y, new, limit = f.y[i], f.next[i], f.limit[i]
    before, after = turning(y, f.A.shape[1], limit), turning(new, f.A.shape[1], limit)
    for r in range(f.A.shape[1]):
        new[r] += ramp[r, 2] * before + ramp[r, 3] * after


@inlined
def turning(y: FloatArray, n: int, limit: float) -> float:
    """Return the rate of a nozzle of second order [rad/s]: zero on its stop."""
    return y[n + 1] if abs(y[n]) <= limit else 0.0


@inlined
def learnt(f: Flights, i: int) -> None:
    """Move the states of a law and of its filters, by what was sensed and asked for."""
    s = f.states.shape[1]
    own = i if f.memory.shape[0] > 1 else 0
    for r in range(s):
        f.next[i, r] = filtered(f, i, f.memory[own, r])
    for r in range(s):
        f.states[i, r] = f.next[i, r]


@inlined
def blown(f: Flights, i: int, begin: float, end: float) -> None:
    """Add what the knots of the wind within a part change, and find the piece at its end."""
    w = f.wind[i]
    while f.piece[i] + 1 < f.knots.shape[1] and f.knots[w, f.piece[i] + 1] <= end:
        knot = f.knots[w, f.piece[i] + 1]
        if begin < knot < end:
            answered(f, i, knot, end - knot)
        f.piece[i] += 1


@inlined
def answered(f: Flights, i: int, knot: float, time: float) -> None:
    """Add the answer to what the next piece of wind is more than this, by Taylor series.

    Its terms are x_(k+1) = (A x_k t + gust w_k t^(k+1))/(k + 1), with x_0 = 0.
    """
    p, n, w = f.vehicle[i], f.A.shape[1], f.wind[i]
    here, term, terms = f.here[i], f.next[i], f.here.shape[1]
    polynomial(f.pieces, f.knots, w, f.piece[i], knot, here)
    j = f.piece[i] + 1
    for r in range(n):
        term[r] = 0.0
    old = f.series[i]
    power = time
    for k in range(_TERMS):
        more = power * (f.pieces[w, j, k] - here[k]) if k < terms else 0.0
        for r in range(n):
            old[r] = term[r]
        for r in range(n):
            total = 0.0
            for q in range(n):
                total += f.A[p, r, q] * old[q]
            term[r] = (time * total + f.gust[p, r] * more) / (k + 1)
            f.y[i, r] += term[r]
        power *= time
