"""The ringing of nozzles, taken out of the states of 32 flights once it is too small to count."""

import numpy as np

from tvclin.kernels import flight_table as table
from tvclin.kernels import ringing as own
from tvclin.kernels.compiled import lanes
from tvclin.kernels.compiled.compiler import lean, merged
from tvclin.kernels.compiled.lanes import ALL, at, row

_STATES = lanes.MEMORY + 1
_POLE = own.RIGHT + lanes.SPIN
_nozzles, _ringing = merged(own.nozzles), merged(own.ringing)


@lean
def _part(number):  # type: ignore[no-untyped-def]
    """Return the row of the real parts of one number of `ringing`; the imaginary ones follow."""
    return row(lanes.OWN + 2 * number)


@lean
def begin_ringing(w, rows):  # type: ignore[no-untyped-def]
    """Write the ringing of all lanes; rows of zeros where nothing is taken out.

    The rows come in one and in two dimensions: a column of these is what `ringing` reads.
    """
    pole = _part(_POLE)
    for i in range(ALL):
        nozzle = _nozzles(rows[:, i])
        w[pole + i], w[pole + ALL + i] = nozzle.real, nozzle.imag
    for _ in range(own.NEARER):
        for i in range(ALL):
            near = complex(w[pole + i], w[pole + ALL + i])
            near -= _ringing(rows[:, i], near)[own.STEP]
            w[pole + i], w[pole + ALL + i] = near.real, near.imag
    for i in range(ALL):
        parts = _ringing(rows[:, i], complex(w[pole + i], w[pole + ALL + i]))
        good = parts[own.CALM].real > 0.0
        for k in range(own.RINGING):
            w[_part(k) + i] = parts[k].real if good else 0.0
            w[_part(k) + ALL + i] = parts[k].imag if good else 0.0


@lean
def settle(s, w, degree):  # type: ignore[no-untyped-def]
    """Take ringing out that is too small to count; let nozzles rest at commands that stand."""
    _driven(s, w, degree)
    real, other = row(lanes.DRIVEN), row(lanes.DRIVEN + 1)
    felt, left, right = _part(own.FELT), _part(own.LEFT), _part(own.RIGHT)
    position, spin = at(lanes.SERVO, 0), at(lanes.SPIN, 0)
    for i in range(ALL):
        a = w[felt + i] * w[real + i] - w[felt + ALL + i] * w[other + i]
        b = w[felt + i] * w[other + i] + w[felt + ALL + i] * w[real + i]
        for k in range(_STATES):
            y, there = s[at(k, 0) + i], np.uint64(2 * k * lanes.LANES) + i
            a += w[left + there] * y
            b += w[left + there + ALL] * y
        calm = w[_part(own.CALM) + i]
        free = w[row(lanes.COMMANDED) + i] * w[row(lanes.MOVING) + i] * w[row(lanes.FREE) + i]
        quiet = (free != 0.0) & (a * a + b * b <= calm * calm)
        a, b = 2.0 * a if quiet else 0.0, 2.0 * b if quiet else 0.0
        for k in range(_STATES):
            there = np.uint64(2 * k * lanes.LANES) + i
            s[at(k, 0) + i] -= a * w[right + there] - b * w[right + there + ALL]
        stiff, large = w[row(table.STIFFNESS) + i], w[row(table.SERVO_SCALE) + i]
        command, rate = w[row(lanes.COMMAND) + i], s[spin + i]
        off = s[position + i] - command
        least = w[row(table.ACCURACY) + i] / (table.SERVO_SHARE * large)
        rests = (w[row(lanes.COMMANDED) + i] == 0.0) & (w[row(lanes.FREE) + i] != 0.0)
        rests &= stiff * off * off + rate * rate <= stiff * least * least
        s[position + i] -= off if rests else 0.0
        s[spin + i] -= rate if rests else 0.0


@merged
def _driven(s, w, degree):  # type: ignore[no-untyped-def]
    """Write what the wind and its slopes drive, each slope over one more power of the pole."""
    real, other, inverse = row(lanes.DRIVEN), row(lanes.DRIVEN + 1), _part(own.INVERSE)
    for j in range(max(degree, 1) - 1, -1, -1):
        wind, factor = at(lanes.WIND, j), j + 1.0
        for i in range(ALL):
            a, b = factor * w[inverse + i], factor * w[inverse + ALL + i]
            c, d = w[real + i], w[other + i]
            if j + 1 >= degree:
                c, d = s[at(lanes.WIND, j + 1) + i], 0.0
            w[real + i] = s[wind + i] + a * c - b * d
            w[other + i] = a * d + b * c
