"""Flights of sampled laws: the run of the kernel, and the history of one flight at any time.

A step is linear and exact while the nozzle reaches no limit. If it reaches one, and samples are far
apart for it, the step is divided into substeps; in a substep bounded by the rate or deflection
limit the deflection is a straight line from its start to its end. `tracked` evaluates one flight
at any time from the start of the substep that contains it.
"""

from __future__ import annotations

from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray, IntArray
from tvclin.control.autopilot.actuator import INPUTS, Actuator, plant_with_actuator
from tvclin.control.laws.law import Measurement
from tvclin.flights.closed_loop.batch import Batch, flights
from tvclin.flights.closed_loop.checks import LOST, check_not_lost
from tvclin.flights.closed_loop.law_batch import LawBatch, law_rows
from tvclin.kernels import choice
from tvclin.kernels import flights as kernel
from tvclin.kernels.choice import in_slices
from tvclin.kernels.control_laws import LawNumbers
from tvclin.kernels.flight_arrays import NEVER, Flights
from tvclin.kernels.source import machine_code
from tvclin.linear.plant import INPUTS as VEHICLE_INPUTS
from tvclin.linear.system import LinearSystem, connect, polynomial_input
from tvclin.numerics.propagation import input_states, matrix_exponentials, piece_matrix
from tvclin.winds.histories import History


def finish(f: Flights, laws: LawBatch) -> None:
    """Step flights of laws to their ends, in place.

    They run in plain Python until the time that the kernel would take, the estimated and then the
    elapsed one, is worth compiling it; the rest runs as machine code, in several threads if it is
    long. `f`: the flights, changed in place. `laws`: their laws; one without numbers is evaluated
    by Python.
    """
    # an array of numbers has those of all laws; else None stands for a law without numbers
    if not isinstance(f.laws.numbers, np.ndarray) and None in laws.numbers:
        _finish_in_python(f, laws)
        return
    cases = f.cases.limit.size
    samples, first = float(_minimum_samples(f).sum()), 0
    seconds = samples * kernel.PLAIN  # estimated run time: decides between compiled and plain code
    with np.errstate(all="ignore"):  # a lost flight may overflow
        fly = choice.fastest(kernel.fly, seconds)
        plain = f if fly is not kernel.fly else _with_law_list(f)
        while first < cases and fly is kernel.fly:
            start = perf_counter()  # an undecided flight takes longer than the estimate
            fly(plain, first, first + 1)
            fly, first = choice.fastest_uncounted(kernel.fly, perf_counter() - start), first + 1
    if first < cases:
        compact = _with_law_array(f)
        work = samples * kernel.COMPILED  # estimated run time [s], for the number of threads
        in_slices(lambda a, b: fly(compact, first + a, first + b), cases - first, work)


def finish_in_planes(pitch: Flights, yaw: Flights, normals: FloatArray, limit: FloatArray) -> None:
    """Step m flights in both planes to their common ends, in place; see `kernels.flights`.

    `pitch`, `yaw`: flights of both planes, changed in place. `normals`: normals of the limit shape,
    ``(k, 2)``; empty for a circle. `limit`: deflection limits [rad], ``(m,)``. Plain Python takes
    the numbers of the laws as a list, machine code as an array.
    """
    # estimated run time, which decides between compiled and plain code: of both planes' samples
    fly = choice.fastest(
        kernel.fly_in_planes, 2.0 * float(_minimum_samples(pitch).sum()) * kernel.PLAIN
    )
    take = _with_law_list if fly is kernel.fly_in_planes else _with_law_array
    with np.errstate(all="ignore"):  # a lost flight may overflow
        fly(take(pitch), take(yaw), normals, limit, 0, limit.size)  # all flights, from 0 to m


def _finish_in_python(f: Flights, laws: LawBatch) -> None:
    """Step flights to their ends, in place; Python evaluates each law for all its flights at once.

    `f`: the flights, changed in place. `laws`: their laws, without numbers for the kernel.
    """
    stepper, k = Stepper(f), 0
    # demands over the limit at which a law commands the full limit, and at which it ends that
    engage, release = (
        np.array([getattr(law, name) for law in laws.laws], float)[f.cases.law]
        for name in ("engage", "release")
    )
    with np.errstate(all="ignore"):  # a lost flight may overflow
        while stepper.look(k):  # measures sample k of the flights that are still active
            # `ended`: the last sample of a flight, negative until it has ended
            active, demand = f.now.ended < 0, np.zeros(f.cases.limit.size)
            for index, law in enumerate(laws.laws):
                flights = np.flatnonzero(active & (f.cases.law == index))
                if flights.size:
                    demand[flights] = _demand(law, f, flights)
            stepper.advance(k, demand, engage, release)
            k += 1


class Stepper:
    """Kernel of the flights `f`, whose demands are computed outside, one sample at a time."""

    def __init__(self, f: Flights) -> None:
        """Choose plain Python or machine code for both kernels, which change `f` in place."""
        # estimated run time, which decides between compiled and plain code
        seconds = float(_minimum_samples(f).sum()) * kernel.PLAIN
        self._measure = choice.fastest(kernel.measure_flights, seconds)
        compiled = self._measure is not kernel.measure_flights
        # both kernels together, as machine code takes other arrays
        self._advance = machine_code(kernel.move_flights) if compiled else kernel.move_flights
        self._flights = _with_law_array(f) if compiled else f

    def look(self, k: int) -> int:
        """Evaluate measurements and outcomes at sample `k`; return the number of active flights."""
        return self._measure(self._flights, k)

    def advance(self, k: int, demand: FloatArray, engage: FloatArray, release: FloatArray) -> None:
        """Step the flights that have not ended by the sample with number `k`, in place.

        The kernel limits the demands and steps vehicle and nozzle; `look` measured before.
        `demand`: demands [rad] of m flights. `engage`, `release`: demands over the limit at which
        the full limit is commanded, and is no longer, ``(m,)``.
        """
        self._advance(self._flights, k, demand, engage, release)


def _minimum_samples(f: Flights) -> IntArray:
    """Return the smallest number of samples that each of the flights `f` can have, ``(m,)``.

    Up to a fixed end, or to the end of the wind and the time that a flight must be settled after
    it.
    """
    return np.where(f.cases.finish < NEVER, f.cases.finish, f.cases.ends + f.cases.settling)


def _demand(law: Any, f: Flights, flights: IntArray) -> FloatArray:
    """Return the demands [rad] of a law written in Python, in k of the flights `f`, ``(k,)``.

    The law gets their measurements at the present sample, its states and the deflection limits
    [rad]. `flights`: indices of the k flights. A single flight is evaluated with plain floats, in
    half the time.
    """
    order = len(law.states[0])
    states, limit = f.now.states[flights, :order], f.cases.limit[flights]
    if flights.size > 1:
        demand = law.demand(Measurement(*f.now.measured[flights].T), states.T, limit)
    else:
        measured = Measurement(*f.now.measured[flights[0]].tolist())
        demand = law.demand(measured, states[0], float(limit[0]))
    return np.asarray(demand, dtype=float)


def _with_law_list(f: Flights) -> Flights:
    """Return the flights `f` with the numbers of their laws as a list, for plain Python."""
    numbers = f.laws.numbers
    if isinstance(numbers, np.ndarray):
        numbers = [LawNumbers._make(row) for row in numbers.tolist()]
    return f._replace(laws=f.laws._replace(numbers=numbers))


def _with_law_array(f: Flights) -> Flights:
    """Return the flights `f` with the numbers of their laws as an array, for machine code."""
    if isinstance(f.laws.numbers, np.ndarray):
        return f
    return f._replace(laws=f.laws._replace(numbers=law_rows(f.laws.numbers)))


_TIME_DECIMALS = 12
"""Decimals of a time within a substep [s]; times on a grid then have few different values."""
_MAX_LOOPED_TIMES = 64
"""Largest number of different times within a substep that are evaluated in a loop."""
_MAX_NUMBERS = 4_000_000
"""Largest number of matrix entries that are gathered at once, 32 or 64 MB."""


class Tracked(NamedTuple):
    """One sampled flight at m times, zero before its start.

    `rows`: states of the plant and the deflection, ``(n + 1, m)``. `rate`, `acceleration`: rate and
    acceleration of the actuator right after the times [rad/s, rad/s^2], from its equation; None
    without an actuator. In a substep in which rate or deflection are limited the rate is constant;
    impulses of acceleration at the limits, and those of a first-order actuator, are not included.
    """

    rows: FloatArray
    rate: FloatArray | None
    acceleration: FloatArray | None


def tracked(flight: Batch, times: FloatArray) -> Tracked:
    """Return states, deflection and nozzle motion of one sampled flight at times [s] up to its end.

    `flight`: batch of this flight. `InputError` if its states exceed `LOST`. Times are within
    substeps of the nozzle (`_Substeps`): there the rate is constant if it is limited, else that of
    the actuator's equation.
    """
    actuator, f = flight.hardware.actuator, flights(flight, track=True)
    finish(f, flight.laws)
    n = len(flight.system.states)
    system = plant_with_actuator(flight.plant, actuator, flight.laws.sensors)
    with np.errstate(invalid="ignore"):  # NaN exceeds it too
        track = _recorded_rows(f)
        beyond = ~(np.abs(track[:, :n]).max(axis=1) <= LOST)
    if np.any(beyond):
        first = track[np.argmax(beyond)]
        check_not_lost(float(first[-1]), first[:n])  # its last number is the time
    # substep of each time: whether it is limited, and the states without limits
    at = _substeps(f, system, n, times)
    rows = _rows(at, flight.system, actuator, flight.wind, times)
    if actuator is None:
        return Tracked(rows, rate=None, acceleration=None)
    # state n is the nozzle, after those of the plant; the first input is the command
    derivatives = system.A @ at.unlimited + system.B[:, :1] * at.command
    before = times < at.onset  # at rest
    # a limited substep has a constant rate, its `slope`, and no acceleration
    rate = np.where(before, 0.0, np.where(at.bounded, at.slope, derivatives[n]))
    return Tracked(rows, rate, np.where(before | at.bounded, 0.0, system.A[n] @ derivatives))


def outputs_of(plant: LinearSystem, rows: FloatArray, gusts: FloatArray) -> FloatArray:
    """Return the outputs of a plant at m times, ``(outputs, m)``.

    `rows`: n states and deflection [rad], ``(n + 1, m)``. `gusts`: wind angles [rad], ``(m,)``.
    """
    direct = plant.D[:, : len(VEHICLE_INPUTS)] @ np.stack([rows[-1], gusts])
    return np.asarray(plant.C @ rows[:-1] + direct)


def _rows(
    at: _Substeps, bare: LinearSystem, actuator: Actuator | None, wind: History, times: FloatArray
) -> FloatArray:
    """Return the n states of the plant and the deflection [rad] at m times, ``(n + 1, m)``.

    They are zero before the onset of the wind. Without a limit the state follows the matrices of
    plant and nozzle from the start of the substep; where the nozzle is limited, the plant follows a
    deflection that is a straight line. The response to the wind is added to both. `at`: substeps of
    the times. `bare`: the plant without its `actuator`. `times`: flight times [s].
    """
    # state at the start of the substep; deflection there [rad] and its constant rate if limited
    y, first, slope = at.y, at.first, at.slope
    n = len(bare.states)
    vehicle = y[:, :n]
    if "deflection_acceleration" in bare.inputs:
        # where the constant rate starts the rate jumps, so that its acceleration is an impulse;
        # y[:, n + 1] is the nozzle rate, zero at the deflection limit; input 2 the acceleration
        before = np.where(np.abs(y[:, n]) <= at.limit, y[:, n + 1], 0.0)
        vehicle = vehicle + (slope - before)[:, np.newaxis] * bare.B[:, 2]
    rows = np.zeros((n + 1, times.size))
    rows[:n] = at.unlimited[:n]
    if np.any(at.bounded):  # states of the plant, and value and slope of the deflection
        ramp = connect([bare, polynomial_input("deflection", 2)], (), ()).to_steps(at.distinct).A
        limited = _stepped(ramp, at.which, np.column_stack([vehicle, first, slope]))[:n]
        rows[:n] = np.where(at.bounded, limited, rows[:n])
    gust = bare.B[:, 1]  # column of the wind
    rows[:n] += _wind_response(bare.A, gust, wind, at)
    position = at.command if actuator is None else np.clip(at.unlimited[n], -at.limit, at.limit)
    rows[n] = np.where(at.bounded, first + slope * at.u, position)  # u: time in the substep [s]
    return np.where(times < at.onset, 0.0, rows)


class _Substeps(NamedTuple):
    """Substep of each of m times, and the time `u` [s] since its start.

    `begins`: starts of the substeps [s]. `distinct`, `which`: distinct values of `u` [s], and their
    index for each time. `y`: state at the start. `command`: command [rad] of the substep.
    `bounded`: whether rate or deflection are limited. `first`, `slope`: deflection [rad] at the
    start and its constant rate [rad/s] if limited. `unlimited`: state at the time without limits
    and wind.
    """

    onset: float
    limit: float
    begins: FloatArray
    u: FloatArray
    distinct: FloatArray
    which: IndexArray
    y: FloatArray
    command: FloatArray
    bounded: BoolArray
    first: FloatArray
    slope: FloatArray
    unlimited: FloatArray


def _stepped(steps: AnyArray, which: IndexArray, states: AnyArray) -> AnyArray:
    """Return the products of step matrices and states at m times, as columns ``(n, m)``.

    `steps`: matrices ``(d, n, n)`` over the d distinct times since a substep's start. `which`:
    index of that of each time, ``(m,)``. `states`: ``(m, n)``. With few distinct times a matrix is
    multiplied by all of its states at once; otherwise one by one, in blocks of limited memory.
    """
    columns = np.empty((steps.shape[1], len(states)), np.result_type(steps, states))
    if len(steps) > _MAX_LOOPED_TIMES:
        width = max(_MAX_NUMBERS // max(steps[0].size, 1), 1)
        for k in range(0, len(states), width):
            block = slice(k, k + width)
            columns[:, block] = np.einsum("mij,mj->im", steps[which[block]], states[block])
        return columns
    for k, step in enumerate(steps):
        same = which == k
        columns[:, same] = step @ states[same].T
    return columns


def _substeps(f: Flights, system: LinearSystem, n: int, times: FloatArray) -> _Substeps:
    """Return the substeps that contain m times [s] of a recorded flight.

    A row of the track is a substep: its state, command, deflection at the end, whether the nozzle
    was limited, and its start [s]. `f`: arrays of the flight with its track. `system`: plant with
    nozzle, whose first `n` states are the plant's. The states without limits and wind follow from
    the start of each substep by matrices for each of the `distinct` times since it.
    """
    N = f.now.y.shape[1]  # columns of the state in a row; the deflection is column n
    limit, track = float(f.cases.limit[0]), _recorded_rows(f)
    begins = track[:, -1]
    row = np.clip(np.searchsorted(begins, times, side="right") - 1, 0, len(begins) - 1)
    u = np.maximum(times - begins[row], 0.0)
    rounded, which = np.unique(np.round(u, _TIME_DECIMALS), return_inverse=True)
    distinct = np.asarray(rounded, dtype=np.float64)
    y, (command, last, bounded) = track[row, :N], track[row, N:-1].T
    # the last row ends with the last of the samples, whose number is `ended`
    period = f.steps.lengths[0, 0]  # of a sample, before the lengths of its parts [s]
    end = f.cases.start[0] + period * f.now.ended[0]
    lengths = np.diff(begins, append=end)[row]
    first = np.clip(y[:, n], -limit, limit)
    steps = system.select(INPUTS[:1], ()).to_steps(distinct)
    matrices = np.concatenate([steps.A, steps.B], axis=2)
    return _Substeps(
        onset=float(begins[0]),
        limit=limit,
        begins=begins[row],
        u=u,
        distinct=distinct,
        which=which,
        y=y,
        command=command,
        bounded=bounded > 0.0,
        first=first,
        slope=(last - first) / lengths,
        unlimited=_stepped(matrices, which, np.column_stack([y[:, : len(system.states)], command])),
    )


def _recorded_rows(f: Flights) -> FloatArray:
    """Return the rows of the track of a single flight `f` that were written, ``(k, N + 4)``.

    Each is a substep: N states, command, deflection at the end, 1 if the nozzle was limited, and
    the start [s], which is NaN in rows that were not written.
    """
    return f.track[~np.isnan(f.track[:, -1])]


def _wind_response(A: FloatArray, gust: FloatArray, wind: History, at: _Substeps) -> FloatArray:
    """Return the response of n states to the wind since the start of the substep, ``(n, m)``.

    The wind is a piece of its history, generated by further states; in a substep with a breakpoint
    the pieces are joined one after the other. `A`: matrix of the plant, ``(n, n)``. `gust`: its
    column for the wind, ``(n,)``. `at`: substeps of m times: `begins`, times `u` since, and their
    `distinct` values [s].
    """
    n, pieces = len(A), wind.pieces
    matrix, begins = piece_matrix(A, gust, pieces), at.begins
    steps = matrix_exponentials(matrix, at.distinct)[:, :n, n:]
    # each step matrix times the states of the wind's piece at the start of its substep
    added = np.real(_stepped(steps, at.which, input_states(pieces, begins)))
    knots = pieces.knots[:, np.newaxis]
    ends = begins + at.u
    for k in np.flatnonzero(np.any((begins < knots) & (knots < ends), axis=0)):
        inside = pieces.knots[(begins[k] < pieces.knots) & (pieces.knots < ends[k])]
        edges = np.concatenate([begins[k : k + 1], inside, ends[k : k + 1]])
        state = np.zeros(n, dtype=complex)
        for step, inputs in zip(
            matrix_exponentials(matrix, np.diff(edges)),
            input_states(pieces, edges[:-1]),
            strict=True,
        ):
            state = step[:n, :n] @ state + step[:n, n:] @ inputs
        added[:, k] = np.real(state)
    return np.asarray(added)
