"""What a batch of flights is made of, as rows of one table, and what comes out of them."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

(
    MU,
    MU_PATH,
    MOMENT,
    GUST,
    PATH_ATTITUDE,
    PATH_PATH,
    PATH_SPEED,
    PATH_DEFLECTION,
    PATH_GUST,
    SPEED_PATH,
    STIFFNESS,
    DRAG,
    LIMIT,
    RATE_LIMIT,
    K_ATTITUDE,
    K_RATE,
    K_PATH,
    K_ALPHA,
    K_MEMORY,
    ENGAGE,
    RELEASE,
    SCALE,
    SERVO_SCALE,
    ACCURACY,
    START,
    END,
    UNTIL,
    FAST,
    FAST_RATE,
    FAST_PATH,
    FAST_SPEED,
    SLOW,
    SLOW_RATE,
    SLOW_PATH,
    SLOW_SPEED,
    REACH,
    RATIO,
    CALM,
    PATIENCE,
    LEAN,
    LEAN_ATTITUDE,
    LEAN_RATE,
    LEAN_PATH,
    LEAN_SLOW,
    LEAN_SLOW_RATE,
    LEAN_SLOW_PATH,
    LEAN_RATIO,
    LEAN_WIND,
    LEAN_B,
    LEAN_REACH,
    LEAN_GAIN,
    LEAN_PEAK,
    LEAN_TRUST,
    LEAN_BAND,
    LEAN_ESTIMATES,
) = range(55)
"""Rows of `FlightTable.rows`."""
ROWS = 55

UNDECIDED, SURVIVED, LOST = range(3)
"""What became of a flight."""

(
    PEAK_ATTITUDE,
    PEAK_RATE,
    PEAK_DEFLECTION,
    PEAK_DEFLECTION_RATE,
    PEAK_ALPHA,
    FINAL_ATTITUDE,
    ENDED,
    SATURATED,
    FATE,
) = range(9)
"""Rows of what comes out."""
RESULTS = 9

SETTLED = 0.3
"""Saved: every unstable coordinate is below this part of the reach for a while."""
LOOK = 8
"""Samples between two looks at a sampled flight."""
LOOKS = 8
"""Looks at a flight without pause, after its wind, in the time for which it must be calm; one
that has an end is looked at there alone.
"""
NEARLY = 1.0 - 1e-9
"""Of a time that is a sum of other times, and so off by rounding."""
ORDER = 11
"""Of the Taylor series of flights without pause."""
TOLERANCE = 1e-8
"""Of the last terms of a series, over the peak of the wind or over a larger attitude: what
accuracy is, where none is asked for.
"""
SERVO_SHARE = 0.1
"""What an error of the nozzle, over a large deflection, counts beside one of the attitude."""
LARGE = 10.0
"""A limit that is above so many times what holds the peak of the wind is not what counts."""
SLACK = 1e-7
"""The nozzle is at its stop when it is beyond by this part: it swings in without end."""
GRAZE = 1e-13
"""A summit that is beyond a bound by less than this part of it only touches it; and a flight
that turns away from a bound, from this near, is beyond it already.
"""
FINE, NEAR, SUMMIT = 1e-9, 5e-4, 5e-4
"""Of the step, how near is near enough: to a root after a round, before a round of Halley, which
trebles the digits, and before one of Newton to a summit, whose value has three times its digits.
"""
ROUNDS = 60
ONE = 0x3FF0000000000000
"""The bits of the number one."""
SAFE, GROWTH = 0.95, 4.0
"""A step is so much shorter than it might be, and at most so many times as long as the last."""
BEGIN = 0.01
"""Length of the first step that is tried [s]."""
MOST = 200_000
"""Steps of a flight."""
STEP, SHARE = 0.005, 0.04
"""Longest fixed step [s], and over the fastest rate of nozzle, estimator and feedback."""
HEADROOM = 1.1
"""A wind felt beyond the design peak is taken for so many times as strong."""
SLOW_LOOP = 3.0
"""Gain of the slow mode's outer loop, in units of its coordinate."""
FAST_FIRST = 0.9
"""Part of the limit that the fast mode may need against the felt wind."""
EDGE = 0.9999
"""The slow coordinate is taken for no nearer than this to the end of its reach."""


@dataclass(frozen=True, eq=False)
class FlightTable:
    """A batch of m flights.

    Attributes
    ----------
    rows : ndarray
        ``(55, m)``, each row named above: the equations of the plant

            theta'' = MU theta + MU_PATH gamma + MOMENT delta + GUST w
            gamma' = PATH_ATTITUDE theta + PATH_PATH gamma + PATH_SPEED v
                     + PATH_DEFLECTION delta + PATH_GUST w,    v' = SPEED_PATH gamma

        of the nozzle (natural frequency squared, and twice damping times it; of first order its
        bandwidth), the limits [rad, rad/s], the gains of a law that is linear, the deflections at
        which it engages and lets go [rad], one over the peak of the wind and over the deflection
        that counts as large, the accuracy, the times [s] at which the flight begins, its wind ends
        and it must end (or inf), and how it is judged: the rows of the unstable coordinates, their
        reach [rad] (NaN where there are none), slow over fast pole, and the times [s] that a flight
        must be calm and may be open. The last rows are those of a recoverable-attitude law: one if
        it is one, its unstable coordinates, the ratio of their poles (zero for one mode), the
        strength of the wind, B, reach, gain, design peak (inf without one), its trust, dead band,
        and one if it estimates the wind.
    order, servo : int
        Number of states of the plant, 2 to 4, and of the nozzle, 0 to 2.
    knots : ndarray
        Of the winds [s], ``(winds, k)``; the last repeated where a wind has fewer.
    wind : ndarray
        Polynomial coefficients of each piece in its own time, lowest power first,
        ``(winds, k, degree + 1)``.
    which : ndarray of int
        The wind of each flight, ``(m,)``.
    free, driven : ndarray
        Of the laws' own states, ``(m, 2, 2)``, and of what they see, ``(m, 2, 5)`` [1/s].
    """

    rows: FloatArray
    order: int
    servo: int
    knots: FloatArray
    wind: FloatArray
    which: NDArray[np.int64]
    free: FloatArray
    driven: FloatArray

    def take(self, index: NDArray[np.bool_]) -> "FlightTable":
        """Return some of the flights."""
        if np.all(index):
            return self
        rows = np.ascontiguousarray(self.rows[:, index])
        own = {name: getattr(self, name)[index] for name in ("which", "free", "driven")}
        return replace(self, rows=rows, **own)


@dataclass(frozen=True, eq=False)
class SampledSteps:
    """What takes m flights from one sample of their law to the next.

    Attributes
    ----------
    length : float
        Of a step [s].
    plant : tuple of ndarray
        A ``(m, n, n)`` and the column of the wind ``(m, n)``, for gusts that begin in a step.
    free, first, last : ndarray
        Of the states, ``(m, n, n)``, and of the deflection at both ends, ``(m, n)``.
    gust : ndarray
        Of the coefficients of the wind about the start of the step, ``(m, n, degree + 1)``.
    servo : tuple of ndarray
        Of the nozzle's states ``(m, 2, 2)`` and of the command ``(m, 2)``.
    memory : tuple of ndarray
        Of the law's own states ``(m, 2, 2)`` and of what it sees ``(m, 2, 5)``.
    noise : ndarray
        Of the measured attitude rate [rad/s], ``(sequences, samples)``.
    hears : ndarray of int
        The sequence of each flight, ``(m,)``.
    """

    length: float
    plant: tuple[FloatArray, FloatArray]
    free: FloatArray
    first: FloatArray
    last: FloatArray
    gust: FloatArray
    servo: tuple[FloatArray, FloatArray]
    memory: tuple[FloatArray, FloatArray]
    noise: FloatArray
    hears: NDArray[np.int64]
