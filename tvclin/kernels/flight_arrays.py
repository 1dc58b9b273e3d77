"""The arrays of a batch of flights, as the kernel steps them."""

from typing import Any, NamedTuple

from tvclin.base.arrays import BoolArray, FloatArray, IntArray

UNDECIDED, SURVIVED, LOST = range(3)
"""What became of a flight."""
MEASURED = 5
"""Numbers that a law is shown."""
PEAKS = 6
"""Largest attitude, its rate, deflection, its rate, angle of attack; and samples at the limit."""
NEVER = 1 << 60
"""Samples of a flight that ends when it is decided."""


class Steps(NamedTuple):
    """What a step does to each of p vehicles with N states, of which n are not its nozzle's.

    `joint`: J of each part of a step, the part after the delay first, ``(p, parts, N, N + 1 +
    terms)``. `fine`: J of a substep of each part, likewise. `substeps`: how many a part has, ``(p,
    parts)``. `ramp`: what the deflection at both ends of a substep does to the vehicle, ``(p,
    parts, n, 2)``; where its acceleration is an input, then what its rates before and after do,
    ``(p, parts, n, 4)``. `lengths`: of a step, and of its parts [s], ``(p, 1 + parts)``. `short`:
    of a substep of each part [s], ``(p, parts)``. `quick`: what a nozzle of first order would move
    in a substep with the rate it begins with, over the way that is left; infinite without one, zero
    for one of second order, ``(p, parts)``. `late`: whole samples by which a command is late,
    ``(p,)``.
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
    """What else is known of each of p vehicles.

    `shown`: attitude, rate, flight path angle and angle of attack of the states and of the wind,
    ``(p, 4, n + 1)``. `A`, `gust`: of x' = A x + gust w, for winds that begin in a step, ``(p, n,
    n)`` and ``(p, n)``. `fastest`: size of the largest eigenvalue of A [1/s], ``(p,)``. `judges`:
    rows of the fast and of the slow unstable coordinate, ``(p, 2, N)``. `reach`, `ratio`: of the
    coordinates over the deflection limit, NaN where nothing judges; and of their poles, ``(p,)``.
    """

    shown: FloatArray
    A: FloatArray
    gust: FloatArray
    fastest: FloatArray
    judges: FloatArray
    reach: FloatArray
    ratio: FloatArray


class Winds(NamedTuple):
    """Knots [s], ``(w, k)``, and polynomials, lowest power first, ``(w, k, terms)``."""

    knots: FloatArray
    pieces: FloatArray


class Laws(NamedTuple):
    """Laws, with their states and filters.

    `numbers`: a sequence of LawNumbers, or an array with their fields. `memory`: what a step makes
    of the states of a law with its filters: rows on these states and on what is sensed, ``(l, s, s
    + 6)``; one for each flight, or one for all. `seen`, `told`: with filters, what a law sees and
    what the limit is told, likewise ``(l, 5, s + 6)`` and ``(l, s + 6)``; of no length without
    filters. `noise`: of the measured attitude rate [rad/s], ``(sequences, samples)``.
    """

    numbers: Any
    memory: FloatArray
    seen: FloatArray
    told: FloatArray
    noise: FloatArray


class Cases(NamedTuple):
    """What each of m flights is of, ``(m,)``.

    `vehicle`, `wind`, `law`, `sequence`: their places; the last of its noise. `gain`: factor on
    what the law asks for. `limit`, `rate_limit`: of the deflection. `start`: when it begins [s].
    `finish`, `ends`, `waiting`, `settling`: samples of a flight that has an end, up to the end of
    the wind, after it, and in which a flight must be settled to be saved.
    """

    vehicle: IntArray
    wind: IntArray
    law: IntArray
    sequence: IntArray
    gain: FloatArray
    limit: FloatArray
    rate_limit: FloatArray
    start: FloatArray
    finish: IntArray
    ends: IntArray
    waiting: IntArray
    settling: IntArray


class Now(NamedTuple):
    """Where m flights are, and room to move them.

    `y`, `states`, `here`: states of the system ``(m, N)`` and of the law ``(m, s)``, and the wind
    about now ``(m, terms)``. `sensed`, `measured`: what sensors give, and last what the law asks
    for, ``(m, 6)``; and what the law sees, behind its filters, ``(m, 5)``. `next`, `series`: room
    for the next states, ``(m, max(N, s))``, and for a series, ``(m, 3, n)``. `commands`: the last
    ones, ``(m, largest late + parts)``. `mode`: +1 or -1 while the whole limit is commanded,
    ``(m,)``. `bounded`: whether the nozzle met a limit in its last substep, ``(m,)``. `peaks`: see
    `PEAKS`, ``(m, 6)``. `piece`, `settled`, `outcome`, `ended`: the piece of the wind, for how many
    samples it is settled, outcomes, and the sample at which a flight ended or -1, ``(m,)``.
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
    """A batch of m flights.

    `track`: of a single flight y, command, deflection at the end, one where a limit was met, and
    when it begins [s], for each substep, ``(substeps, N + 4)``; NaN where a part went by in one. Of
    no length if not asked for.
    """

    steps: Steps
    vehicles: Vehicles
    winds: Winds
    laws: Laws
    cases: Cases
    now: Now
    track: FloatArray
