"""Flights of control laws at a sample rate, each stepped exactly from sample to sample.

A fractional computing delay divides each step into two intervals, in which the command c is
constant. From the start to the end of an interval the states y of a flight, those of the vehicle
and then those of the nozzle, the command, and the wind as a polynomial w0 + w1 u + ... about the
start make

    y <- J [y, c, w0, w1, ...],

which is exact while the nozzle is not limited. For a nozzle that is fast relative to the samples of
the law an interval is divided into substeps, unless the nozzle is not limited in any of them. In a
substep in which rate or deflection limit act, the deflection is linear between its end values.

In both planes each plane is a flight: at each sample the demands (x, y) behind the filters are
scaled by min(1, limit/g(x, y)), g the gauge of the limit shape.
"""

import math

from tvclin.base.arrays import FloatArray
from tvclin.kernels.control_laws import law_demand, next_mode, slow_edges
from tvclin.kernels.flight_arrays import (
    LOST,
    MEASURED,
    NEVER,
    PEAK_ANGLE_OF_ATTACK,
    PEAK_ATTITUDE,
    PEAK_ATTITUDE_RATE,
    PEAK_DEFLECTION,
    PEAK_DEFLECTION_RATE,
    SAMPLES_AT_LIMIT,
    SENSED_ALPHA,
    SENSED_DEFLECTION,
    SENSED_RATE,
    SURVIVED,
    UNDECIDED,
    Flights,
)
from tvclin.kernels.source import allocation_free, inlined

_SERIES_TERMS, _MAX_SERIES_ARGUMENT = 24, 2.0
"""Terms of the series of a wind that begins within a step, and its argument: 2^24/24! is 3e-17."""
_LIMIT_TOLERANCE = 1.0 + 1e-9
"""Factor on the deflection limit within which a nozzle at the limit may be leaving it."""
PLAIN, COMPILED = 3e-5, 5e-8
"""Seconds per sample of a flight, in plain Python and as machine code."""
SETTLED_FRACTION = 0.3
"""Fraction of the reach below which every unstable coordinate is settled."""
JUDGED_SAMPLES = 8
"""Samples between two judgements of a flight."""


@inlined
def expand_wind(f: Flights, i: int, now: float) -> None:
    """Write the polynomial of flight i's wind about the time `now` [s], in its current piece.

    `f`: batch of flights, whose `now.here`, ``(m, terms)``, it is written to, lowest power first.
    """
    here, w, j = f.now.here[i], f.cases.wind[i], f.now.piece[i]
    expand_piece(f.winds.pieces, f.winds.knots, w, j, now, here)


@inlined
def expand_piece(
    pieces: FloatArray, knots: FloatArray, w: int, j: int, now: float, here: FloatArray
) -> None:
    """Write the coefficients of piece j of wind w about the time `now` [s]; zeros for j < 0.

    `pieces`, `knots`: coefficients ``(w, k, terms)``, lowest power first, and knots [s] of the
    winds. `here`: written, ``(terms,)``.
    """
    terms = here.size
    if j < 0:
        for r in range(terms):
            here[r] = 0.0
        return
    for r in range(terms):
        here[r] = pieces[w, j, r]
    shift_polynomial(here, now - knots[w, j])


@inlined
def shift_polynomial(c: FloatArray, u: float) -> None:
    """Replace a polynomial c ``(terms,)`` by its expansion about a point u later, in place.

    Lowest power first, by repeated Horner schemes.
    """
    for low in range(c.size - 1):
        for r in range(c.size - 2, low - 1, -1):
            c[r] += c[r + 1] * u


@inlined
def pass_knots(f: Flights, i: int, begin: float, end: float) -> None:
    """Add the effect of the wind's knots in an interval of flight i, and set the piece at its end.

    A knot is a time at which a wind goes over to its next polynomial piece; the current one is
    `f.now.piece[i]`, -1 before the first. `begin`, `end`: of the interval [s]. At a knot inside,
    the response of the states to the change of the wind is added.
    """
    knots = f.winds.knots[f.cases.wind[i]]
    while f.now.piece[i] + 1 < knots.size and knots[f.now.piece[i] + 1] <= end:
        knot = knots[f.now.piece[i] + 1]
        if begin < knot < end:
            add_gust_response(f, i, knot, end - knot)
        f.now.piece[i] += 1


@inlined
def add_gust_response(f: Flights, i: int, knot: float, time: float) -> None:
    """Add to the states of flight i the response to the change of its wind at a knot, by series.

    `knot`: time of the knot [s]; from there on the next piece differs from the current one. `time`:
    from the knot to the end of the interval [s]. x' = A x + gust w is integrated for the difference
    w in parts in which ``|A| t`` stays below `_MAX_SERIES_ARGUMENT`; the terms about the start of a
    part of length t are x_(k+1) = (A x_k t + gust w_k t^(k+1))/(k + 1), x_0 being the response
    before.
    """
    p, w = f.cases.vehicle[i], f.cases.wind[i]
    A, gust, n = f.vehicles.A[p], f.vehicles.gust[p], f.vehicles.A.shape[1]
    difference, j = f.now.here[i], f.now.piece[i] + 1  # j: the next piece
    previous, term, response = f.now.series[i, 0], f.now.series[i, 1], f.now.series[i, 2]
    expand_piece(f.winds.pieces, f.winds.knots, w, j - 1, knot, difference)
    for r in range(difference.size):
        difference[r] = f.winds.pieces[w, j, r] - difference[r]
    for r in range(n):
        response[r] = 0.0
    parts = 1 + int(f.vehicles.fastest[p] * time / _MAX_SERIES_ARGUMENT)
    for k in range(parts):
        if k > 0:
            shift_polynomial(difference, time / parts)
        for r in range(n):
            term[r] = response[r]
        add_series(A, gust, difference, time / parts, previous, term, response)
    for r in range(n):
        f.now.y[i, r] += response[r]


@inlined
def add_series(
    A: FloatArray,
    gust: FloatArray,
    difference: FloatArray,
    length: float,
    previous: FloatArray,
    term: FloatArray,
    response: FloatArray,
) -> None:
    """Add to the state `response` ``(n,)`` its change over an interval, as a power series.

    Of x' = A x + gust w. `A`, `gust`: ``(n, n)`` and ``(n,)``. `difference`: w, a polynomial in the
    time since the start, lowest power first. `length`: of the interval [s]. `previous`: work array
    ``(n,)``. `term`: the first term, which is the state at the start; overwritten.
    """
    n, power = response.size, length  # power: length^(k + 1)
    for k in range(_SERIES_TERMS):
        forcing = power * difference[k] if k < difference.size else 0.0
        for r in range(n):
            previous[r] = term[r]
        for r in range(n):
            total = 0.0
            for q in range(n):
                total += A[r, q] * previous[q]
            term[r] = (length * total + gust[r] * forcing) / (k + 1)
            response[r] += term[r]
        power *= length


@inlined
def keep_peak(peaks: FloatArray, row: int, value: float) -> None:
    """Replace the peak number `row` of a flight by the size of a value, if that is larger.

    `peaks`: of a flight, ``(6,)``. `row`: index, as `PEAK_DEFLECTION`. `value`: [rad] or [rad/s].
    """
    peaks[row] = max(peaks[row], abs(value))


@inlined
def move_interval(
    f: Flights, i: int, interval: int, k: int, c: float, begin: float, end: float
) -> None:
    """Move vehicle and nozzle of flight i through an interval of sample k, at the command c [rad].

    A delayed command divides a sample into two intervals. `interval`: index, 0 after the arrival of
    the command. `begin`, `end`: its times [s]. In substeps where the nozzle may reach a limit, else
    in one step; the states `now.y` become those at its end, `now.next`, and the times of substeps
    and their states are kept for plots (`write_track_row`).
    """
    p = f.cases.vehicle[i]
    substep, count = f.steps.short[p, interval], f.steps.substeps[p, interval]  # length, number
    unlimited = count > 1 and is_unlimited(f, i, interval, c)
    first, steps = begin, 1 if unlimited else count
    for step in range(steps):
        last = begin + substep * (step + 1) if step < steps - 1 else end
        if step > 0:
            expand_wind(f, i, first)
        move_substep(f, i, interval, unlimited, c)
        write_track_row(f, i, interval, k, step, c, first)
        for r in range(f.now.y.shape[1]):
            f.now.y[i, r] = f.now.next[i, r]
        pass_knots(f, i, first, last)
        first = last


@inlined
def is_unlimited(f: Flights, i: int, interval: int, c: float) -> bool:
    """Return whether the nozzle of flight i reaches no limit in any substep of an interval.

    If so, its peaks of deflection and rate are kept. `interval`: index of the interval of a sample.
    `c`: command [rad], constant in it. The nozzle's deflection s [rad] and, of second order, its
    rate v [rad/s] do not depend on the vehicle: they are states number n and n + 1, behind the
    vehicle's n. These are their rows and columns in the transition matrix J of a substep, whose
    column behind all states is the command's.
    """
    p, n, size = f.cases.vehicle[i], f.vehicles.A.shape[1], f.now.y.shape[1]
    J, s, v, next_v = f.steps.fine[p, interval], f.now.y[i, n], 0.0, 0.0
    if size > n + 1:  # of second order
        v = f.now.y[i, n + 1]
    largest, largest_change = 0.0, 0.0  # deflection, and its change in a substep [rad]
    for _ in range(f.steps.substeps[p, interval]):
        next_s = J[n, n] * s + J[n, size] * c
        if size > n + 1:
            next_s += J[n, n + 1] * v
            next_v = J[n + 1, n] * s + J[n + 1, n + 1] * v + J[n + 1, size] * c
        if is_limited(f, i, interval, c, s, v, next_s, next_v):
            return False
        largest, largest_change = max(largest, abs(next_s)), max(largest_change, abs(next_s - s))
        s, v = next_s, next_v
    peaks, duration = f.now.peaks[i], f.steps.short[p, interval]  # of a substep [s]
    keep_peak(peaks, PEAK_DEFLECTION, min(largest, f.cases.limit[i]))
    keep_peak(peaks, PEAK_DEFLECTION_RATE, largest_change / duration)
    return True


@inlined
def move_substep(f: Flights, i: int, interval: int, unlimited: bool, c: float) -> None:
    """Write the next states of vehicle and nozzle of flight i, over an interval or a substep.

    `interval`: its index in the sample. `unlimited`: whether it is one step over the whole
    interval, without limits of the nozzle. `c`: command [rad]. In a substep in which the nozzle is
    limited its deflection is linear between the values at both ends. Peaks are kept if there are
    several substeps.
    """
    p, n, y, new = f.cases.vehicle[i], f.vehicles.A.shape[1], f.now.y[i], f.now.next[i]
    limit, f.now.bounded[i] = f.cases.limit[i], False
    if unlimited:
        free_step(f, i, f.steps.joint[p, interval], c)  # the matrix J of the whole interval
        return
    free_step(f, i, f.steps.fine[p, interval], c)  # that of a substep
    f.now.bounded[i] = limit_nozzle(f, i, interval, c)
    # deflection before and after: state number n, within the limit
    first, last = min(max(y[n], -limit), limit), min(max(new[n], -limit), limit)
    if f.now.bounded[i]:
        ramp_step(f, i, f.steps.fine[p, interval], f.steps.ramp[p, interval], first, last)
        if f.steps.ramp.shape[3] > 2:  # also columns for the nozzle's rates: engine with inertia
            add_engine_impulses(f, i, f.steps.ramp[p, interval])
    if f.steps.substeps[p, interval] > 1:
        keep_peak(f.now.peaks[i], PEAK_DEFLECTION, last)
        keep_peak(f.now.peaks[i], PEAK_DEFLECTION_RATE, (last - first) / f.steps.short[p, interval])


@inlined
def write_track_row(
    f: Flights, i: int, interval: int, k: int, step: int, c: float, begin: float
) -> None:
    """Write the row of the track of a substep of flight i: states, command, limits and start.

    The track ``(rows, N + 4)`` records a single flight; it is empty for others. A row has N states
    and the command at the start, the deflection at the end, one if the nozzle was limited, and the
    start. `interval`: index of the interval of sample k, the later of two being 0. `step`: number
    of the substep in it. `c`: command [rad]. `begin`: start of the substep [s].
    """
    rows = f.track.shape[0]
    if rows == 0:
        return
    p, y, limit, size = f.cases.vehicle[i], f.now.y[i], f.cases.limit[i], f.now.y.shape[1]
    total, previous = 0, 0  # substeps of a sample, and of its earlier interval
    for j in range(f.steps.joint.shape[1]):
        total += f.steps.substeps[p, j]
        if j > interval:
            previous += f.steps.substeps[p, j]
    row = k * total + previous + step
    if row >= rows:
        return
    for r in range(size):
        f.track[row, r] = y[r]
    f.track[row, size] = c
    f.track[row, size + 1] = min(max(f.now.next[i, f.vehicles.A.shape[1]], -limit), limit)
    f.track[row, size + 2] = 1.0 if f.now.bounded[i] else 0.0
    f.track[row, size + 3] = begin


@inlined
def free_step(f: Flights, i: int, J: FloatArray, c: float) -> None:
    """Write the next states J [y, c, w0, w1, ...] of flight i, without limits of the nozzle.

    `J`: transition matrix ``(N, N + 1 + terms)`` on the states y, the command c [rad], and the
    coefficients of the wind's polynomial.
    """
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
def is_limited(
    f: Flights, i: int, interval: int, c: float, s: float, v: float, next_s: float, next_v: float
) -> bool:
    """Return whether rate or deflection limit act in a substep of flight i.

    `interval`: index of the interval of a sample. `c`: command [rad]. `s`, `v`: deflection [rad]
    and rate [rad/s] at the start, `next_s`, `next_v`: without limits at the end. A first-order
    nozzle starts with the rate omega (c - s) and is slower afterwards: `f.steps.quick` is omega
    times the length of the substep, so that their product is compared with the travel at the rate
    limit.
    """
    p, max_rate = f.cases.vehicle[i], f.cases.rate_limit[i]
    travel = max_rate * f.steps.short[p, interval]  # the largest in a substep [rad]
    if abs(c - s) * f.steps.quick[p, interval] > travel or abs(next_s - s) > travel:
        return True
    if max(abs(next_s), abs(s)) > _LIMIT_TOLERANCE * f.cases.limit[i]:
        return True
    return f.now.y.shape[1] > f.vehicles.A.shape[1] + 1 and max(abs(next_v), abs(v)) >= max_rate


@inlined
def limit_nozzle(f: Flights, i: int, interval: int, c: float) -> bool:
    """Return whether rate or deflection limit act in a substep, and if so limit the next states.

    `f`, `i`: flight, whose next states are without limits before. Deflection and, of a second-order
    nozzle, rate are states number n and n + 1. The travel is limited to that at the rate limit; the
    deflection at its limit is the caller's. `interval`: index of the interval of a sample. `c`:
    command [rad].
    """
    p, n, max_rate = f.cases.vehicle[i], f.vehicles.A.shape[1], f.cases.rate_limit[i]
    y, new = f.now.y[i], f.now.next[i]
    second = y.size > n + 1
    v, next_v = (y[n + 1], new[n + 1]) if second else (0.0, 0.0)
    if not is_limited(f, i, interval, c, y[n], v, new[n], next_v):
        return False
    travel = max_rate * f.steps.short[p, interval]  # the largest in a substep [rad]
    if abs(new[n] - y[n]) > travel:
        new[n] = y[n] + (travel if new[n] > y[n] else -travel)
    if second and max(abs(next_v), abs(v)) >= max_rate:
        new[n + 1] = min(max(next_v, -max_rate), max_rate)
    return True


@inlined
def ramp_step(
    f: Flights, i: int, J: FloatArray, ramp: FloatArray, first: float, last: float
) -> None:
    """Write the next states of the vehicle of flight i, for a deflection that is linear in time.

    x <- Phi x + ramp [first, last] + the wind's terms of J. `J`: transition matrix ``(N, N + 1 +
    terms)``, whose first rows and columns are Phi, its last columns of the wind's polynomial.
    `ramp`: effect of the deflection at both ends, ``(n, 2)`` or more columns. `first`, `last`:
    deflection at both ends [rad].
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
def add_engine_impulses(f: Flights, i: int, ramp: FloatArray) -> None:
    """Add the effect on the vehicle of an engine with inertia when its rate jumps, at both ends.

    In a substep whose nozzle is limited its rate v is constant, between the rates `before` and
    `after` it: its acceleration is the impulses v - before and after - v. `f`, `i`: batch, and
    index of the flight. `ramp`: effects on the n states, ``(n, 4)``: of the deflection at both
    ends, which have the terms of v too, since v is their difference over the time; and of the rates
    before and after.
    """
    n, y, new, limit = f.vehicles.A.shape[1], f.now.y[i], f.now.next[i], f.cases.limit[i]
    before, after = nozzle_rate(y, n, limit), nozzle_rate(new, n, limit)
    for r in range(n):
        new[r] += ramp[r, 2] * before + ramp[r, 3] * after


@inlined
def nozzle_rate(y: FloatArray, n: int, limit: float) -> float:
    """Return the rate of a second-order nozzle [rad/s]: zero at its deflection limit.

    `y`: states, of which numbers n and n + 1 are deflection [rad] and rate. `limit`: [rad].
    """
    return y[n + 1] if abs(y[n]) <= limit else 0.0


@allocation_free
def fly(f: Flights, first: int, last: int) -> None:
    """Fly the cases from `first` up to `last` of the batch f, each until its outcome is decided."""
    for i in range(first, last):
        for k in range(NEVER):
            if not measure_sample(f, i, k):
                break
            law = f.laws.numbers[f.cases.law[i]]
            demand = law_demand(law, f.now.measured[i], f.now.states[i], f.cases.limit[i])
            step_sample(f, i, k, demand, law.engage, law.release)


@allocation_free
def fly_in_planes(
    pitch: Flights, yaw: Flights, normals: FloatArray, limit: FloatArray, first: int, last: int
) -> None:
    """Fly cases from `first` up to `last` in both planes, the vector of their demands limited.

    `pitch`, `yaw`: flights of each plane, of the same number m of cases, which end at the same
    sample. The demands (x, y) behind the filters are scaled by min(1, limit/g) with the gauge g of
    the limit shape; each plane has its own limit besides. `normals`: n of the edges of the shape,
    over their distance from zero, ``(k, 2)``, so that g is the largest of n.(x, y); none for a
    circle. `limit`: scale of the shape [rad], ``(m,)``.
    """
    for i in range(first, last):
        for k in range(NEVER):
            flies = measure_sample(pitch, i, k)
            if not (measure_sample(yaw, i, k) and flies):
                break
            x, y = autopilot_demand(pitch, i), autopilot_demand(yaw, i)
            gauge = math.hypot(x, y) if normals.shape[0] == 0 else 0.0
            for r in range(normals.shape[0]):
                gauge = max(gauge, normals[r, 0] * x + normals[r, 1] * y)
            scale = limit[i] / gauge if gauge > limit[i] else 1.0
            move_sample(pitch, i, k, scale * x)
            move_sample(yaw, i, k, scale * y)


@inlined
def autopilot_demand(f: Flights, i: int) -> float:
    """Return the demand [rad] of the law of flight i, behind its filters.

    `f`: batch of flights, of laws without a mode in which the whole limit is commanded. The demand
    before the filters is stored among the sensed values (`filtered_demand`).
    """
    law = f.laws.numbers[f.cases.law[i]]
    demand = law_demand(law, f.now.measured[i], f.now.states[i], f.cases.limit[i])
    return filtered_demand(f, i, demand)


@allocation_free
def measure_flights(f: Flights, k: int) -> int:
    """Write the measurements of all flights of the batch f that have not ended, at sample k.

    Returns the number of those that continue.
    """
    count = 0
    for i in range(f.cases.limit.size):
        if f.now.ended[i] < 0 and measure_sample(f, i, k):
            count += 1
    return count


@allocation_free
def move_flights(
    f: Flights, k: int, demand: FloatArray, engage: FloatArray, release: FloatArray
) -> None:
    """Move all flights of the batch f that have not ended by sample k, for laws written in Python.

    `demand`: deflections that the laws demand [rad]. `engage`, `release`: sizes of the demand over
    the limit at which the whole limit is commanded, and released. All ``(m,)``.
    """
    for i in range(f.cases.limit.size):
        if f.now.ended[i] < 0:
            step_sample(f, i, k, demand[i], engage[i], release[i])


@inlined
def measure_sample(f: Flights, i: int, k: int) -> bool:
    """Write the measurements of flight i's law at sample k; return whether the flight continues.

    Sensed are the outputs of the vehicle from its n states x and the wind, and the deflection,
    which is state number n, within its limit; measured is the same behind the filters of the law.
    After the wind the outcome is decided every `JUDGED_SAMPLES`; the flight ends once it is, or at
    a given sample.
    """
    if 0 < k < f.cases.stages[i]:  # a vehicle and a law for each sample
        take_next_stage(f, i)
    p, peaks, sensed, x = f.cases.vehicle[i], f.now.peaks[i], f.now.sensed[i], f.now.y[i]
    n = f.vehicles.A.shape[1]
    expand_wind(f, i, f.cases.start[i] + f.steps.lengths[p, 0] * k)
    wind = f.now.here[i, 0]  # [rad], at this sample
    for r in range(f.vehicles.shown.shape[1]):  # rows of the outputs
        total = f.vehicles.shown[p, r, n] * wind
        for j in range(n):
            total += f.vehicles.shown[p, r, j] * x[j]
        sensed[r if r < SENSED_DEFLECTION else r + 1] = total
    sensed[SENSED_DEFLECTION] = min(max(x[n], -f.cases.limit[i]), f.cases.limit[i])
    keep_peak(peaks, PEAK_ATTITUDE, x[0])
    keep_peak(peaks, PEAK_ATTITUDE_RATE, x[1])
    keep_peak(peaks, PEAK_ANGLE_OF_ATTACK, sensed[SENSED_ALPHA])
    after = k - f.cases.ends[i]  # samples since the end of the wind
    if after > 0 and after % JUDGED_SAMPLES == 0 and f.now.outcome[i] != LOST:
        judge_states(f, i)
    undecided = f.now.outcome[i] == UNDECIDED and after < f.cases.waiting[i]
    if k >= f.cases.finish[i] or (not undecided and f.cases.finish[i] == NEVER):
        f.now.ended[i] = k
        return False
    if k < f.laws.noise.shape[1]:
        sensed[SENSED_RATE] += f.laws.noise[f.cases.sequence[i], k]
    for r in range(MEASURED):
        f.now.measured[i, r] = sensed[r]
    if f.laws.input_rows.shape[0]:
        for r in range(MEASURED):
            f.now.measured[i, r] = row_product(f, i, f.laws.input_rows[f.cases.memory[i], r])
    return True


@inlined
def take_next_stage(f: Flights, i: int) -> None:
    """Write the indices of vehicle, law and memory of the next stage of flight i.

    A flight along an ascent has a vehicle and a law for each sample, one behind the other; the
    memory, the transition matrix of the law's states, is also one for each sample, or a single one.
    """
    f.cases.vehicle[i] += 1
    f.cases.law[i] += 1
    if f.laws.memory.shape[0] > 1:
        f.cases.memory[i] += 1


@inlined
def row_product(f: Flights, i: int, row: FloatArray) -> float:
    """Return the product of a row ``(s + 9,)`` with the law's states and sensed values of flight i.

    The s states belong to the law and its filters; the 9 sensed values are 8 sensor outputs and the
    demand of the law.
    """
    s, total = f.now.states.shape[1], 0.0
    for j in range(s):
        total += row[j] * f.now.states[i, j]
    for j in range(MEASURED + 1):
        total += row[s + j] * f.now.sensed[i, j]
    return total


@inlined
def judge_states(f: Flights, i: int) -> None:
    """Decide the outcome of flight i after its wind, if its states show it.

    Its unstable coordinates z1 (`fast`) and z2 (`slow`), rows of `judges` times the states, are
    lost outside the recoverable set, ``|z1| < D`` and z2 between the `slow_edges` at z1, where D =
    reach limit is the largest z1 that the limit brings back. It survives when both have stayed
    below a fraction of D for long enough; without such a criterion a vehicle's reach is NaN.
    """
    p = f.cases.vehicle[i]
    reach, ratio = f.vehicles.reach[p] * f.cases.limit[i], f.vehicles.ratio[p]
    if not reach > 0.0:
        return
    fast, slow = 0.0, 0.0
    for j in range(f.vehicles.judges.shape[2]):
        fast += f.vehicles.judges[p, 0, j] * f.now.y[i, j]
        slow += f.vehicles.judges[p, 1, j] * f.now.y[i, j]
    recoverable = abs(fast) < reach
    if recoverable and ratio > 0.0:
        low, high = slow_edges(fast / reach, ratio)
        recoverable = low * reach < slow < high * reach
    if not recoverable:
        f.now.outcome[i] = LOST
        return
    settled = max(abs(fast), abs(slow)) < SETTLED_FRACTION * reach
    f.now.settled[i] = f.now.settled[i] + JUDGED_SAMPLES if settled else 0
    if f.now.settled[i] >= f.cases.settling[i]:
        f.now.outcome[i] = SURVIVED


@inlined
def step_sample(f: Flights, i: int, k: int, demand: float, engage: float, release: float) -> None:
    """Move flight i by sample k, with the demand [rad] of its law before the filters.

    `engage`, `release`: sizes of the filtered demand over the limit at which the whole limit is
    commanded, with its sign (mode +1 or -1), and released.
    """
    limit, demand = f.cases.limit[i], filtered_demand(f, i, demand)
    mode = next_mode(engage * limit, release * limit, demand, f.now.mode[i])
    f.now.mode[i] = mode
    move_sample(f, i, k, mode * limit if mode != 0.0 else demand)


@inlined
def filtered_demand(f: Flights, i: int, demand: float) -> float:
    """Return the demand [rad] of the law of flight i, times the case's gain, behind the filters.

    The demand before the filters becomes the last of the sensed values, on which the filters act.
    """
    demand = f.cases.gain[i] * demand
    f.now.sensed[i, MEASURED] = demand
    if f.laws.command_rows.shape[0]:
        demand = row_product(f, i, f.laws.command_rows[f.cases.memory[i]])
    return demand


@inlined
def move_sample(f: Flights, i: int, k: int, demand: float) -> None:
    """Move flight i by sample k, with the demand [rad], limited, as its command.

    The command acts from sample k + late on; for a fractional delay within that sample, whose first
    interval (1) still has the command before, its second (0) this one. The wind is a polynomial in
    the time since the begin of an interval, expanded anew between the two. States of the law and
    its filters are updated, and peaks of deflection and rate are kept. `f`: batch of flights, with
    their states `now.y` (the deflection after those of the vehicle).
    """
    p, limit, sensed = f.cases.vehicle[i], f.cases.limit[i], f.now.sensed[i]
    command = min(max(demand, -limit), limit)
    if abs(command) >= limit:
        f.now.peaks[i, SAMPLES_AT_LIMIT] += 1.0
    # `lengths` are those of a sample, and then of its intervals 0 and 1
    begin = f.cases.start[i] + f.steps.lengths[p, 0] * k
    end = f.cases.start[i] + f.steps.lengths[p, 0] * (k + 1)
    # number of intervals of a sample, of which `joint` has the transition matrices; length of the
    # buffer of commands; sample of the command
    intervals, ring, since = f.steps.joint.shape[1], f.now.commands.shape[1], k - f.steps.late[p]
    if ring > 1:  # delayed commands, in a ring buffer
        f.now.commands[i, k % ring] = command
    for interval in range(intervals - 1, -1, -1):
        delayed = f.now.commands[i, (since - interval) % ring] if ring > 1 else command
        stop = begin + f.steps.lengths[p, 2] if interval > 0 else end
        move_interval(f, i, interval, k, delayed, begin, stop)
        if interval > 0:
            expand_wind(f, i, stop)
        begin = stop
    update_law_states(f, i)
    n = f.vehicles.A.shape[1]
    deflection = min(max(f.now.y[i, n], -limit), limit)  # after the n states of the vehicle
    keep_peak(f.now.peaks[i], PEAK_DEFLECTION, deflection)
    rate = (deflection - sensed[SENSED_DEFLECTION]) / f.steps.lengths[p, 0]  # mean of the sample
    keep_peak(f.now.peaks[i], PEAK_DEFLECTION_RATE, rate)


@inlined
def update_law_states(f: Flights, i: int) -> None:
    """Update the states of the law of flight i, and of its filters, by a sample.

    Each next state is a row of the law's memory times present states and sensed values.
    """
    s = f.now.states.shape[1]
    for r in range(s):
        f.now.next[i, r] = row_product(f, i, f.laws.memory[f.cases.memory[i], r])
    for r in range(s):
        f.now.states[i, r] = f.now.next[i, r]
