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


class Flights(NamedTuple):
    """A batch of m flights of p vehicles, with N states of which n are the vehicle's.

    Attributes
    ----------
    vehicle, wind, law : ndarray of int
        Those of each flight, ``(m,)``.
    joint : ndarray
        J of each part of a step, the part after the delay first, ``(p, parts, N, N + 1 + terms)``.
    fine : ndarray
        J of a substep of each part, likewise.
    substeps : ndarray of int
        How many a part has, ``(p, parts)``.
    ramp : ndarray
        What the deflection at both ends of a substep does to the vehicle, ``(p, parts, n, 2)``;
        where its acceleration is an input, then what its rates before and after do, ``(p, parts, n,
        4)``.
    lengths : ndarray
        Of a step, and of its parts [s], ``(p, 1 + parts)``.
    quick : ndarray
        What a nozzle of first order would move in a substep with the rate it begins with, over the
        way that is left; infinite without one, zero for one of second order, ``(p, parts)``.
    late : ndarray of int
        Whole samples by which a command is late, ``(p,)``.
    shown : ndarray
        Attitude, rate, flight path angle and angle of attack of the states and of the wind,
        ``(p, 4, n + 1)``.
    A, gust : ndarray
        Of x' = A x + gust w, for winds that begin in a step, ``(p, n, n)`` and ``(p, n)``.
    fastest : ndarray
        Size of the largest eigenvalue of A [1/s], ``(p,)``.
    judges : ndarray
        Rows of the fast and of the slow unstable coordinate, ``(p, 2, N)``.
    reach, ratio : ndarray
        Of the coordinates over the deflection limit, NaN where nothing judges; and of their
        poles, ``(p,)``.
    knots, pieces : ndarray
        Of the winds [s], ``(w, k)``, and their polynomials, lowest power first,
        ``(w, k, terms)``.
    laws : sequence of LawNumbers
        Or an array with their fields; `law` says whose.
    memory : ndarray
        What a step makes of the states of a law with its filters: rows on these states and on what
        is sensed, ``(l, s, s + 6)``; one for each flight, or one for all.
    seen, told : ndarray
        With filters, what a law sees and what the limit is told, likewise ``(l, 5, s + 6)`` and
        ``(l, s + 6)``; of no length without filters.
    gain : ndarray
        Factors on what laws ask for, ``(m,)``.
    limit, rate_limit : ndarray
        Of the deflection, ``(m,)``.
    start : ndarray
        When flights begin [s], ``(m,)``.
    finish, ends, waiting, settling : ndarray of int
        Samples: of a flight that has an end, up to the end of the wind, after it, and in which a
        flight must be settled to be saved, ``(m,)``.
    noise : ndarray
        Of the measured attitude rate [rad/s], ``(sequences, samples)``.
    sequence : ndarray of int
        The sequence of each flight, ``(m,)``.
    y, states, here : ndarray
        Where flights are: states of the system ``(m, N)`` and of the law ``(m, s)``, and the wind
        about now ``(m, terms)``.
    sensed, measured : ndarray
        What sensors give, and last what the law asks for, ``(m, 6)``; and what the law sees,
        behind its filters, ``(m, 5)``.
    next, series : ndarray
        Room for the next states, ``(m, max(N, s))``, and for a series, ``(m, 3, n)``.
    commands : ndarray
        The last ones, ``(m, largest late + parts)``.
    mode : ndarray
        +1 or -1 while the whole limit is commanded, ``(m,)``.
    bounded : ndarray of bool
        Whether the nozzle met a limit in its last substep, ``(m,)``.
    peaks : ndarray
        See `PEAKS`, ``(m, 6)``.
    piece, settled, outcome, ended : ndarray of int
        The piece of the wind, for how many samples it is settled, outcomes, and the sample at which
        a flight ended or -1, ``(m,)``.
    track : ndarray
        Of a single flight: y, command, deflection at the end, one where a limit was met, and when
        it begins [s], for each substep, ``(substeps, N + 4)``; NaN where a part went by in one.
        Of no length if not asked for.
    """

    vehicle: IntArray
    wind: IntArray
    law: IntArray
    joint: FloatArray
    fine: FloatArray
    substeps: IntArray
    ramp: FloatArray
    lengths: FloatArray
    quick: FloatArray
    late: IntArray
    shown: FloatArray
    A: FloatArray
    gust: FloatArray
    fastest: FloatArray
    judges: FloatArray
    reach: FloatArray
    ratio: FloatArray
    knots: FloatArray
    pieces: FloatArray
    laws: Any
    memory: FloatArray
    seen: FloatArray
    told: FloatArray
    gain: FloatArray
    limit: FloatArray
    rate_limit: FloatArray
    start: FloatArray
    finish: IntArray
    ends: IntArray
    waiting: IntArray
    settling: IntArray
    noise: FloatArray
    sequence: IntArray
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
    track: FloatArray
