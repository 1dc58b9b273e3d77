"""The memory of a block of flights: 32 lanes of everything in two flat arrays, series and rows.

Lanes are innermost, and within each array the compiler knows how far apart things are, so that
loops over the lanes become vector instructions with hardly a test for overlap: where a term of a
series and a row lie in one array, every pair of them is tested. Indices are unsigned because a
signed one would be tested for counting from the end.
"""

import numpy as np

from tvclin.kernels import flight_table as table
from tvclin.kernels.compiled.compiler import lean
from tvclin.kernels.ringing import RINGING

LANES = 32
ALL = np.uint64(LANES)
ORDER = table.ORDER
TERMS = ORDER + 2
TOGETHER = 4
"""Terms of the series that are written in one loop over the lanes; they divide `ORDER` + 1."""

THETA, RATE, PATH, SPEED, SERVO, SPIN, MEMORY, WIND, DEMAND, ALPHA, WATCH = range(11)
"""The series: states, wind, and what is made of them: the demand, the angle of attack, and what
the rate limit watches. Of these three the first two terms are kept, the others written at need.
"""
SERIES = 11

_FIRST = table.ROWS
(
    NOW,
    LEFT,
    KNOT,
    LOOK,
    TRIAL,
    STEP,
    MODE,
    STOP,
    HOLD,
    COMMANDED,
    COMMAND,
    MOVING,
    STOPPED,
    FREE,
    HELD,
    PULL_ATTITUDE,
    PULL_RATE,
    PULL_PATH,
    PULL_SERVO,
    PULL_SPIN,
    PULL_MEMORY,
    PULL_GUST,
    PULL,
    TURN_SERVO,
    TURN,
    DRIFT_SERVO,
    DRIFT,
    WATCH_ASKED,
    WATCH_SERVO,
    WATCH_SPIN,
    WATCHED,
    DEMAND_LOW,
    DEMAND_HIGH,
    SERVO_LOW,
    SERVO_HIGH,
    WATCH_LOW,
    WATCH_HIGH,
    FLAG,
    ALIVE,
    MET,
    SIDE,
    TOP_THETA,
    TOP_RATE,
    TOP_SERVO,
    TOP_WATCH,
    TOP_ALPHA,
    FULL,
    QUIET,
    FATE,
    VALUE,
) = range(_FIRST, _FIRST + 50)
"""Rows beside those of the table: time, regions, the equations that hold in them (what moves the
nozzle, how it turns vehicle and path, what the rate limit watches), bounds, and peaks.
"""
SLOPE = VALUE + SERIES
DRIVEN = SLOPE + SERIES
OWN = DRIVEN + 2
SERIES_SIZE, SIZE = SERIES * TERMS * LANES, (OWN + 2 * RINGING) * LANES


@lean
def at(series: int, k: int) -> np.uint64:
    """Return where the k-th term of a series begins, among the series."""
    return np.uint64((series * TERMS + k) * LANES)


@lean
def row(number: int) -> np.uint64:
    """Return where a row of numbers begins, among the rows."""
    return np.uint64(number * LANES)
