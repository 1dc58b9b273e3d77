"""The ringing of a nozzle: its own swift swing, which dies away while it follows its command.

Taylor steps stay as short as the nozzle is swift even when nothing is left of its ringing, since
rounding starts it anew. So where the flight is linear, and no limit is met, the ringing is told
apart as what it is, a pair of modes of plant, nozzle and law together, and taken out of the state
once it is smaller than what the series leave off.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.kernels import flight_table as table

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

INVERSE, FELT, LEFT, RIGHT, CALM = 0, 1, 2, 9, 16
"""What `ringing` returns: one over the pole, what a gust moves, the row that tells the ringing
from the state, the state of a ringing of size one, and the largest that is left out.
"""
RINGING = 17
"""So many numbers are kept."""
STEP = 17
"""The number that follows them: the step of Newton to a nearer pole."""
NEARER = 4
"""Steps of Newton to the pole; the next must be small."""
_DECAYS, _SWINGS = 0.1, 0.1
"""Least parts of the pole's size that are decay and frequency: else nothing is left out."""
_MISSED = 1e-9
"""The last step of Newton over the pole; a larger one leaves nothing out either."""


def ringings(rows: FloatArray) -> ComplexArray:
    """Return the ringing of nozzles that follow their laws, ``(17, m)``, of a table's rows."""
    pole = nozzles(rows)
    for _ in range(NEARER):
        pole = pole - ringing(rows, pole)[STEP]
    return np.array(ringing(rows, pole)[:RINGING])


def nozzles(rows: Any) -> Any:
    """Return the poles of nozzles alone, from which those of the ringing are looked for."""
    pull, drag = rows[table.STIFFNESS], rows[table.DRAG]
    return -0.5 * drag + 1j * np.sqrt(np.maximum(pull - 0.25 * drag * drag, 0.0))


def ringing(rows: Any, pole: Any) -> tuple[Any, ...]:
    """Return the ringing of nozzles of second order about poles, and Newton's step to true ones.

    The same for the rows of a table ``(55, m)`` and for one column of it, for which it is
    compiled. The product of a pole's vectors, in which the nozzle's share is one, is the slope of
    the characteristic equation.
    """
    pull, drag = rows[table.STIFFNESS], rows[table.DRAG]
    turn, drift = rows[table.MU_PATH], rows[table.PATH_ATTITUDE]
    seen = pull * (rows[table.K_PATH] - rows[table.K_ALPHA])
    held = pull * (rows[table.K_ATTITUDE] + rows[table.K_ALPHA])
    swings, memory = pull * rows[table.K_RATE], pull * rows[table.K_MEMORY]
    level = rows[table.PATH_SPEED] * rows[table.SPEED_PATH]
    inverse = pole.conjugate() * (1.0 / (pole.real**2 + pole.imag**2))
    lag = pole - rows[table.PATH_PATH] - level * inverse
    lag = lag.conjugate() * (1.0 / (lag.real**2 + lag.imag**2))
    stiff = pole * pole - rows[table.MU] - turn * drift * lag
    stiff = stiff.conjugate() * (1.0 / (stiff.real**2 + stiff.imag**2))
    theta = (rows[table.MOMENT] + turn * rows[table.PATH_DEFLECTION] * lag) * stiff
    path = (drift * theta + rows[table.PATH_DEFLECTION]) * lag
    to_rate = (held + swings * pole + memory * inverse + drift * seen * lag) * stiff
    to_path = (to_rate * turn + seen) * lag
    to_theta = pole * to_rate - swings
    missed = pole * (pole + drag) + pull
    missed = missed - to_rate * rows[table.MOMENT] - to_path * rows[table.PATH_DEFLECTION]
    slope = (to_theta + to_rate * pole + memory * inverse * inverse) * theta
    slope = slope + to_path * path * (1.0 + level * inverse * inverse) + 2.0 * pole + drag
    share = slope.conjugate() * (1.0 / (slope.real**2 + slope.imag**2))
    step = missed * share
    size = np.sqrt(pole.real**2 + pole.imag**2)
    good = (pole.imag > _SWINGS * size) & (pole.real < -_DECAYS * size)
    good = good & (step.real**2 + step.imag**2 < (_MISSED * size) ** 2)
    moved = np.sqrt(theta.real**2 + theta.imag**2) * rows[table.SCALE]
    moved = moved + table.SERVO_SHARE * rows[table.SERVO_SCALE]
    felt = to_rate * rows[table.GUST] + to_path * rows[table.PATH_GUST]
    felt = felt - pull * rows[table.K_ALPHA]
    return (
        inverse, felt * share * inverse,
        to_theta * share, to_rate * share, to_path * share,
        to_path * rows[table.PATH_SPEED] * inverse * share,
        (pole + drag) * share, share, memory * inverse * share,
        theta, pole * theta, path, rows[table.SPEED_PATH] * path * inverse,
        1.0 + 0.0 * pole, pole, theta * inverse,
        good * (0.5 * rows[table.ACCURACY] / moved) + 0.0 * pole, step,
    )  # fmt: skip


def settled(
    rows: FloatArray, own: ComplexArray, y: FloatArray, wind: FloatArray, regions: FloatArray
) -> FloatArray:
    """Return states ``(7, m)`` without ringing that is too small to count.

    `own` is what `ringings` returns, ``(17, m)``. A nozzle whose command stands still, at the
    limit, comes to rest.
    """
    free = np.all(regions == 0.0, axis=0)
    driven = np.zeros_like(own[0])
    for j in range(len(wind) - 1, -1, -1):
        driven = wind[j] + (j + 1) * own[INVERSE] * driven
    size = np.sum(own[LEFT:RIGHT] * y, axis=0) + own[FELT] * driven
    quiet = free & (np.abs(size) <= own[CALM].real)
    y = np.where(quiet, y - 2.0 * (size * own[RIGHT:CALM]).real, y)
    command, spin = regions[0] * rows[table.LIMIT], y[5]
    left = rows[table.STIFFNESS] * (y[4] - command) ** 2 + spin**2
    near = rows[table.ACCURACY] / (table.SERVO_SHARE * rows[table.SERVO_SCALE])
    least = rows[table.STIFFNESS] * near**2
    rests = (regions[0] != 0.0) & (regions[2] == 0.0) & (left <= least)
    y[4], y[5] = np.where(rests, command, y[4]), np.where(rests, 0.0, spin)
    return y
