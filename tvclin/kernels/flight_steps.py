"""Vehicle and nozzle of a flight through a part of a sample, with the command that is held.

From the start to the end of it its states y, those of the vehicle and then those of the nozzle, the
command c, and the wind as a polynomial w0 + w1 u + ... about the start make

    y <- J [y, c, w0, w1, ...],

which is exact while the nozzle meets no limit. Where the nozzle is quick beside the samples of the
law a part is walked in substeps, unless the nozzle goes through all of it without a limit. In a
substep in which its rate or its stop bounds it, the deflection goes evenly from where it begins to
where it ends.
"""

from tvclin.base.arrays import FloatArray
from tvclin.kernels.flight_arrays import Flights
from tvclin.kernels.flight_winds import about, blown
from tvclin.kernels.source import inlined

_BEYOND = 1.0 + 1e-9
"""Over the stop: a nozzle that rests on it is not told apart from one that is just leaving."""


@inlined
def raised(peaks: FloatArray, row: int, value: float) -> None:
    """Keep the largest size."""
    peaks[row] = max(peaks[row], abs(value))


@inlined
def through(f: Flights, i: int, part: int, k: int, c: float, begin: float, end: float) -> None:
    """Move vehicle and nozzle through a part of a step, with the command c."""
    p = f.cases.vehicle[i]
    short, count = f.steps.short[p, part], f.steps.substeps[p, part]
    whole = count > 1 and unbounded(f, i, part, c)
    first, steps = begin, 1 if whole else count
    for step in range(steps):
        last = begin + short * (step + 1) if step < steps - 1 else end
        if step > 0:
            about(f, i, first)
        moved(f, i, part, whole, c)
        written(f, i, part, k, step, c, first)
        for r in range(f.now.y.shape[1]):
            f.now.y[i, r] = f.now.next[i, r]
        blown(f, i, first, last)
        first = last


@inlined
def unbounded(f: Flights, i: int, part: int, c: float) -> bool:
    """Return whether the nozzle, which moves by itself, meets no limit in any substep of a part."""
    p, n, size = f.cases.vehicle[i], f.vehicles.A.shape[1], f.now.y.shape[1]
    J, s, v, rate = f.steps.fine[p, part], f.now.y[i, n], 0.0, 0.0
    if size > n + 1:
        v = f.now.y[i, n + 1]
    widest, quickest = 0.0, 0.0
    for _ in range(f.steps.substeps[p, part]):
        later = J[n, n] * s + J[n, size] * c
        if size > n + 1:
            later += J[n, n + 1] * v
            rate = J[n + 1, n] * s + J[n + 1, n + 1] * v + J[n + 1, size] * c
        if meets(f, i, part, c, s, v, later, rate):
            return False
        widest, quickest = max(widest, abs(later)), max(quickest, abs(later - s))
        s, v = later, rate
    raised(f.now.peaks[i], 2, min(widest, f.cases.limit[i]))
    raised(f.now.peaks[i], 3, quickest / f.steps.short[p, part])
    return True


@inlined
def moved(f: Flights, i: int, part: int, whole: bool, c: float) -> None:
    """Write where vehicle and nozzle come to: through a whole part, or a substep of it."""
    p, n, y, new = f.cases.vehicle[i], f.vehicles.A.shape[1], f.now.y[i], f.now.next[i]
    limit, f.now.bounded[i] = f.cases.limit[i], False
    if whole:
        freely(f, i, f.steps.joint[p, part], c)
        return
    freely(f, i, f.steps.fine[p, part], c)
    f.now.bounded[i] = held_back(f, i, part, c)
    first, last = min(max(y[n], -limit), limit), min(max(new[n], -limit), limit)
    if f.now.bounded[i]:
        evenly(f, i, f.steps.fine[p, part], f.steps.ramp[p, part], first, last)
        if f.steps.ramp.shape[3] > 2:
            jerked(f, i, f.steps.ramp[p, part])
    if f.steps.substeps[p, part] > 1:
        raised(f.now.peaks[i], 2, last)
        raised(f.now.peaks[i], 3, (last - first) / f.steps.short[p, part])


@inlined
def written(f: Flights, i: int, part: int, k: int, step: int, c: float, begin: float) -> None:
    """Write a row of the track: where a substep begins, and what moves it."""
    rows = f.track.shape[0]
    if rows == 0:
        return
    p, y, limit, size = f.cases.vehicle[i], f.now.y[i], f.cases.limit[i], f.now.y.shape[1]
    whole, before = 0, 0
    for one in range(f.steps.joint.shape[1]):
        whole += f.steps.substeps[p, one]
        if one > part:
            before += f.steps.substeps[p, one]
    row = k * whole + before + step
    if row >= rows:
        return
    for r in range(size):
        f.track[row, r] = y[r]
    f.track[row, size] = c
    f.track[row, size + 1] = min(max(f.now.next[i, f.vehicles.A.shape[1]], -limit), limit)
    f.track[row, size + 2] = 1.0 if f.now.bounded[i] else 0.0
    f.track[row, size + 3] = begin


@inlined
def freely(f: Flights, i: int, J: FloatArray, c: float) -> None:
    """Write J [y, c, w0, w1, ...]."""
    y, here, new = f.now.y[i], f.now.here[i], f.now.next[i]
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
    p, most = f.cases.vehicle[i], f.cases.rate_limit[i]
    reach = most * f.steps.short[p, part]
    if abs(c - s) * f.steps.quick[p, part] > reach or abs(later - s) > reach:
        return True
    if max(abs(later), abs(s)) > _BEYOND * f.cases.limit[i]:
        return True
    return f.now.y.shape[1] > f.vehicles.A.shape[1] + 1 and max(abs(rate), abs(v)) >= most


@inlined
def held_back(f: Flights, i: int, part: int, c: float) -> bool:
    """Return whether rate or stop bound the nozzle in a substep, and bound where it comes to."""
    p, n, most = f.cases.vehicle[i], f.vehicles.A.shape[1], f.cases.rate_limit[i]
    y, new = f.now.y[i], f.now.next[i]
    second = y.size > n + 1
    v, rate = (y[n + 1], new[n + 1]) if second else (0.0, 0.0)
    if not meets(f, i, part, c, y[n], v, new[n], rate):
        return False
    reach = most * f.steps.short[p, part]
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
    n, y, here, new = f.vehicles.A.shape[1], f.now.y[i], f.now.here[i], f.now.next[i]
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
    n, y, new, limit = f.vehicles.A.shape[1], f.now.y[i], f.now.next[i], f.cases.limit[i]
    before, after = turning(y, n, limit), turning(new, n, limit)
    for r in range(n):
        new[r] += ramp[r, 2] * before + ramp[r, 3] * after


@inlined
def turning(y: FloatArray, n: int, limit: float) -> float:
    """Return the rate of a nozzle of second order [rad/s]: zero on its stop."""
    return y[n + 1] if abs(y[n]) <= limit else 0.0
