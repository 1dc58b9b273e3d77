"""Arrays of a batch of flights: what the kernels of `flights` read, and what they change.

A step of a flight, from one sample of its law to the next, is divided into one or two intervals
where a delayed command arrives. The N states y are the n of the vehicle and then those of the
nozzle: its deflection [rad] and, of second order, its rate [rad/s]. J of an interval maps [y,
command, wind polynomial] to y at its end; the wind is a polynomial of `terms` coefficients.
"""

from typing import Any, NamedTuple

from tvclin.base.arrays import BoolArray, FloatArray, IntArray

UNDECIDED, SURVIVED, LOST = range(3)
"""Outcome of a flight."""
MEASURED = 8
"""Number of measurements of a law."""
PEAKS = 6
"""Number of peaks of a flight: attitude, its rate, deflection, its rate, angle of attack, and, not
a peak, the number of samples at the deflection limit."""
PEAK_ATTITUDE, PEAK_ATTITUDE_RATE, PEAK_DEFLECTION, PEAK_DEFLECTION_RATE = range(4)
PEAK_ANGLE_OF_ATTACK, SAMPLES_AT_LIMIT = 4, 5
"""Index of each peak."""
SENSED_RATE, SENSED_ALPHA, SENSED_DEFLECTION = 1, 3, 4
"""Index of attitude rate, angle of attack and deflection in the sensed values of a flight."""
NEVER = 1 << 60
"""Number of samples of a flight that ends when its outcome is decided."""


class Steps(NamedTuple):
    """Transition matrices of a step of p vehicles with N states, n of them without the nozzle.

    `joint`: J of each interval of a step, the interval after the delay first, ``(p, intervals, N, N
    + 1 + terms)``. `fine`: J of a substep of each interval, likewise. `substeps`: number of
    substeps of an interval, ``(p, intervals)``. `ramp`: effect on the vehicle of the deflection at
    both ends of a substep, ``(p, intervals, n, 2)``; where its acceleration is an input, then of
    its rates before and after, ``(p, intervals, n, 4)``. `lengths`: of a step, and of its intervals
    [s], ``(p, 1 + intervals)``. `short`: of a substep of each interval [s], ``(p, intervals)``.
    `quick`: travel of a first-order nozzle in a substep at its initial rate, over the remaining
    travel; infinite without a nozzle, zero for a second-order one, ``(p, intervals)``. `late`:
    whole samples of the delay of a command, ``(p,)``.
    """

    joint: FloatArray
    fine: FloatArray
    substeps: IntArray
    ramp: FloatArray
    lengths: FloatArray
    short: FloatArray
    quick: FloatArray
    late: IntArray


class Vehicles(NamedTuple):
    """Further numbers of p vehicles.

    `shown`: attitude, rate, flight path angle and angle of attack from states and wind, ``(p, 4, n
    + 1)``; with lateral sensors also drift rate, drift and acceleration, ``(p, 7, n + 1)``. `A`,
    `gust`: of x' = A x + gust w, for winds that begin in a step, ``(p, n, n)`` and ``(p, n)``.
    `fastest`: size of the largest eigenvalue of A [1/s], ``(p,)``. `judges`: rows of
    the fast and of the slow unstable coordinate, ``(p, 2, N)``. `reach`, `ratio`: reach of the
    coordinates over the deflection limit, NaN without a criterion; and ratio of their poles,
    ``(p,)``.
    """

    shown: FloatArray
    A: FloatArray
    gust: FloatArray
    fastest: FloatArray
    judges: FloatArray
    reach: FloatArray
    ratio: FloatArray


class Winds(NamedTuple):
    """Winds: knots [s], ``(w, k)``, and polynomials, lowest power first, ``(w, k, terms)``."""

    knots: FloatArray
    pieces: FloatArray


class Laws(NamedTuple):
    """Laws, with their states and filters.

    `numbers`: a sequence of `LawNumbers`, or an array with their fields. `memory`: next states of a
    law with its filters: rows on these s states and on the sensed values, ``(l, s, s + 9)``, of the
    l indices in `Cases.memory`. `input_rows`, `command_rows`: with filters, rows of the law's
    inputs and of the command to the limiter, ``(l, 8, s + 9)`` and ``(l, s + 9)``; empty without
    filters. `noise`: of the measured attitude rate [rad/s], ``(sequences, samples)``.
    """

    numbers: Any
    memory: FloatArray
    input_rows: FloatArray
    command_rows: FloatArray
    noise: FloatArray


class Cases(NamedTuple):
    """Indices and numbers of each of m flights, ``(m,)``.

    `vehicle`, `wind`, `law`, `memory`, `sequence`: indices; `memory` that of the states of the law,
    the last that of its noise. `stages`: number of vehicles, laws and memories that follow each
    other, one for each sample, from these indices on, which are then those of the present sample;
    one for a flight with constant matrices, and a single memory is that of all samples. `gain`:
    factor on the demand of the law. `limit`, `rate_limit`: of the deflection. `start`: start time
    [s]. `finish`, `ends`, `waiting`, `settling`: numbers of samples of a flight with a fixed end,
    up to the end of the wind, after it, and for which a flight must be settled to survive.
    """

    vehicle: IntArray
    wind: IntArray
    law: IntArray
    memory: IntArray
    sequence: IntArray
    stages: IntArray
    gain: FloatArray
    limit: FloatArray
    rate_limit: FloatArray
    start: FloatArray
    finish: IntArray
    ends: IntArray
    waiting: IntArray
    settling: IntArray


class FlightStates(NamedTuple):
    """Current states of m flights, and work arrays.

    `y`, `states`, `here`: states of the system ``(m, N)`` and of the law ``(m, s)``, and the wind's
    polynomial about the current time ``(m, terms)``. `sensed`, `measured`: sensor outputs, and last
    the demand of the law, ``(m, 9)``; and the inputs of the law, behind its filters, ``(m, 8)``.
    `next`, `series`: work arrays for the next states, ``(m, max(N, s))``, and for a series, ``(m,
    3, n)``. `commands`: the last commands, ``(m, largest late + intervals)``. `mode`: +1 or -1
    while the whole limit is commanded, ``(m,)``. `bounded`: whether the nozzle was limited in its
    last substep, ``(m,)``. `peaks`: see `PEAKS`, ``(m, 6)``. `piece`, `settled`, `outcome`,
    `ended`: piece of the wind, number of settled samples, outcome, and the sample at which a flight
    ended or -1, ``(m,)``.
    """

    y: FloatArray
    states: FloatArray
    here: FloatArray
    sensed: FloatArray
    measured: FloatArray
    next: FloatArray
    series: FloatArray
    commands: FloatArray
    mode: FloatArray
    bounded: BoolArray
    peaks: FloatArray
    piece: IntArray
    settled: IntArray
    outcome: IntArray
    ended: IntArray


class Flights(NamedTuple):
    """Batch of m flights.

    `track`: of a single flight y, command, deflection at the end, one where the nozzle was limited,
    and the start [s], for each substep, ``(substeps, N + 4)``; NaN where an interval was one step.
    Empty by default.
    """

    steps: Steps
    vehicles: Vehicles
    winds: Winds
    laws: Laws
    cases: Cases
    now: FlightStates
    track: FloatArray
