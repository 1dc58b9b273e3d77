"""Flights of laws that are computed at a sample rate, each stepped exactly from sample to sample.

The element is any linear system. From one sample to the next its states y, those of the vehicle
and then those of the nozzle, the command c, and the wind as a polynomial w0 + w1 u + ... about
the start of the step make

    y <- J [y, c, w0, w1, ...],

which is exact while the nozzle meets no limit. A command that takes effect between two samples, by
a computing delay, parts each step in two. Where the nozzle is quick beside the samples of the law a
part is walked in substeps, unless the nozzle goes through all of it without a limit. In a substep
in which its rate or its stop bounds it, the deflection goes evenly from where it begins to where it
ends.
"""

from tvclin.base.arrays import FloatArray
from tvclin.kernels.control_laws import asked, slow_ends, switched
from tvclin.kernels.flight_arrays import LOST, MEASURED, NEVER, SURVIVED, UNDECIDED, Flights
from tvclin.kernels.source import bare, inlined

SETTLED = 0.3
"""Saved: every unstable coordinate is below this part of the reach for a while."""
LOOK = 8
"""Samples between two looks at a flight."""
_BEYOND = 1.0 + 1e-9
"""Over the stop: a nozzle that rests on it is not told apart from one that is just leaving."""
_TERMS, _FAR = 24, 2.0
"""Of the series of a wind that begins within a step, and how far it goes: 2^24/24! is 3e-17."""


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
    """Write the coefficients of a piece of a wind about a time; zeros before the first."""
    terms = here.size
    if j < 0:
        for r in range(terms):
            here[r] = 0.0
        return
    for r in range(terms):
        here[r] = pieces[w, j, r]
    shifted(here, now - knots[w, j])


@inlined
def shifted(c: FloatArray, u: float) -> None:
    """Make of a polynomial the same about a point u later, by Horner's scheme again and again."""
    for low in range(c.size - 1):
        for r in range(c.size - 2, low - 1, -1):
            c[r] += c[r + 1] * u


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
        through(f, i, part, k, now, begin, stop)
        if part > 0:
            about(f, i, stop)
        begin = stop
    learnt(f, i)
    n = f.A.shape[1]
    deflection = min(max(f.y[i, n], -limit), limit)
    raised(f.peaks[i], 2, deflection)
    raised(f.peaks[i], 3, (deflection - sensed[4]) / f.lengths[p, 0])


@inlined
def through(f: Flights, i: int, part: int, k: int, c: float, begin: float, end: float) -> None:
    """Move vehicle and nozzle through a part of a step, with the command c."""
    p = f.vehicle[i]
    length, count = f.lengths[p, 1 + part], f.substeps[p, part]
    whole = count > 1 and unbounded(f, i, part, c)
    first, steps = begin, 1 if whole else count
    for step in range(steps):
        last = begin + length * (step + 1) / count if step < steps - 1 else end
        if step > 0:
            about(f, i, first)
        moved(f, i, part, whole, c)
        written(f, i, part, k, step, c, first)
        for r in range(f.y.shape[1]):
            f.y[i, r] = f.next[i, r]
        blown(f, i, first, last)
        first = last


@inlined
def unbounded(f: Flights, i: int, part: int, c: float) -> bool:
    """Return whether the nozzle, which moves by itself, meets no limit in any substep of a part."""
    p, n, size = f.vehicle[i], f.A.shape[1], f.y.shape[1]
    J, s, v, rate = f.fine[p, part], f.y[i, n], 0.0, 0.0
    if size > n + 1:
        v = f.y[i, n + 1]
    widest, quickest = 0.0, 0.0
    for _ in range(f.substeps[p, part]):
        later = J[n, n] * s + J[n, size] * c
        if size > n + 1:
            later += J[n, n + 1] * v
            rate = J[n + 1, n] * s + J[n + 1, n + 1] * v + J[n + 1, size] * c
        if meets(f, i, part, c, s, v, later, rate):
            return False
        widest, quickest = max(widest, abs(later)), max(quickest, abs(later - s))
        s, v = later, rate
    raised(f.peaks[i], 2, min(widest, f.limit[i]))
    raised(f.peaks[i], 3, quickest * f.substeps[p, part] / f.lengths[p, 1 + part])
    return True


@inlined
def moved(f: Flights, i: int, part: int, whole: bool, c: float) -> None:
    """Write where vehicle and nozzle come to: through a whole part, or a substep of it."""
    p, n, y, new = f.vehicle[i], f.A.shape[1], f.y[i], f.next[i]
    limit, f.bounded[i] = f.limit[i], False
    if whole:
        freely(f, i, f.joint[p, part], c)
        return
    freely(f, i, f.fine[p, part], c)
    f.bounded[i] = held_back(f, i, part, c)
    first, last = min(max(y[n], -limit), limit), min(max(new[n], -limit), limit)
    if f.bounded[i]:
        evenly(f, i, f.fine[p, part], f.ramp[p, part], first, last)
        if f.ramp.shape[3] > 2:
            jerked(f, i, f.ramp[p, part])
    if f.substeps[p, part] > 1:
        raised(f.peaks[i], 2, last)
        raised(f.peaks[i], 3, (last - first) * f.substeps[p, part] / f.lengths[p, 1 + part])


@inlined
def written(f: Flights, i: int, part: int, k: int, step: int, c: float, begin: float) -> None:
    """Write a row of the track: where a substep begins, and what moves it."""
    rows = f.track.shape[0]
    if rows == 0:
        return
    p, y, size, limit, whole, before = f.vehicle[i], f.y[i], f.y.shape[1], f.limit[i], 0, 0
    for one in range(f.joint.shape[1]):
        whole += f.substeps[p, one]
        if one > part:
            before += f.substeps[p, one]
    row = k * whole + before + step
    if row >= rows:
        return
    for r in range(size):
        f.track[row, r] = y[r]
    f.track[row, size] = c
    f.track[row, size + 1] = min(max(f.next[i, f.A.shape[1]], -limit), limit)
    f.track[row, size + 2] = 1.0 if f.bounded[i] else 0.0
    f.track[row, size + 3] = begin


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
def meets(
    f: Flights, i: int, part: int, c: float, s: float, v: float, later: float, rate: float
) -> bool:
    """Return whether rate or stop bound the nozzle in a substep from s, v to later, rate.

    One of first order sets out with omega (c - s) and is slower ever after: `quick` is omega times
    the length of the substep, so that it is compared with what the limited rate covers in it.
    """
    p, most = f.vehicle[i], f.rate_limit[i]
    reach = most * f.lengths[p, 1 + part] / f.substeps[p, part]
    if abs(c - s) * f.quick[p, part] > reach or abs(later - s) > reach:
        return True
    if max(abs(later), abs(s)) > _BEYOND * f.limit[i]:
        return True
    return f.y.shape[1] > f.A.shape[1] + 1 and max(abs(rate), abs(v)) >= most


@inlined
def held_back(f: Flights, i: int, part: int, c: float) -> bool:
    """Return whether rate or stop bound the nozzle in a substep, and bound where it comes to."""
    p, n, y, new, most = f.vehicle[i], f.A.shape[1], f.y[i], f.next[i], f.rate_limit[i]
    second = y.size > n + 1
    v, rate = (y[n + 1], new[n + 1]) if second else (0.0, 0.0)
    if not meets(f, i, part, c, y[n], v, new[n], rate):
        return False
    reach = most * f.lengths[p, 1 + part] / f.substeps[p, part]
    if abs(new[n] - y[n]) > reach:
        new[n] = y[n] + (reach if new[n] > y[n] else -reach)
    if second and max(abs(rate), abs(v)) >= most:
        new[n + 1] = min(max(rate, -most), most)
    return True


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

    The terms about the start of a stretch t are x_(k+1) = (A x_k t + gust w_k t^(k+1))/(k + 1),
    x_0 being what came of the stretch before.
    """
    p, n, w = f.vehicle[i], f.A.shape[1], f.wind[i]
    more, old, term, found = f.here[i], f.series[i, 0], f.series[i, 1], f.series[i, 2]
    j = f.piece[i] + 1
    polynomial(f.pieces, f.knots, w, j - 1, knot, more)
    for r in range(more.size):
        more[r] = f.pieces[w, j, r] - more[r]
    for r in range(n):
        found[r] = 0.0
    stretches = 1 + int(f.fastest[p] * time / _FAR)
    for stretch in range(stretches):
        if stretch > 0:
            shifted(more, time / stretches)
        for r in range(n):
            term[r] = found[r]
        added(f.A[p], f.gust[p], more, time / stretches, old, term, found)
    for r in range(n):
        f.y[i, r] += found[r]


@inlined
def added(
    A: FloatArray,
    gust: FloatArray,
    more: FloatArray,
    length: float,
    old: FloatArray,
    term: FloatArray,
    found: FloatArray,
) -> None:
    """Add the terms of a stretch that follow the first."""
    n, power = found.size, length
    for k in range(_TERMS):
        pushed = power * more[k] if k < more.size else 0.0
        for r in range(n):
            old[r] = term[r]
        for r in range(n):
            total = 0.0
            for q in range(n):
                total += A[r, q] * old[q]
            term[r] = (length * total + gust[r] * pushed) / (k + 1)
            found[r] += term[r]
        power *= length
