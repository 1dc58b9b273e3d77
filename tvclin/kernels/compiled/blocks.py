"""The outputs at some times of one span, for the compiled responses.

On an even grid the exponentials of a block are a table for the plant, times one number for the
block, so that a point costs a few multiplications.
"""

from typing import Any, NamedTuple

import numpy as np

from tvclin.kernels.compiled.compiler import compiled, lean, merged
from tvclin.kernels.compiled.exponentials import exponential

BLOCK = 512
"""Times in one block, at most."""
_STRIDE = 64
"""A real exponential in a table is a product of two: one for whole strides, one for the rest."""
_STRIDES = (16, 128, BLOCK)
"""A complex one is a product of at most three: one for steps up to the first stride, one for whole
strides up to the next, and so on.
"""
UNEVEN = 1e-14
"""A grid is even where its times, times the fastest exponent, are off by no more than this."""
LARGE = 600.0
"""No exponential in a table is beyond e^600."""


class Tables(NamedTuple):
    """Exponentials of one block.

    Of which exponents ``(E,)``; rows ``(2 E + 1, block)``, real parts, imaginary ones, and zeros;
    the same for uneven times. The rest is scratch for one block.
    """

    exponents: Any
    even: Any
    uneven: Any
    local: Any
    scale: Any
    factors: Any
    which: Any


@compiled
def room_for_tables(like, exponents, outputs):  # type: ignore[no-untyped-def]
    """Return tables with room for so many exponents, real or complex like `like`."""
    even = np.zeros((2 * exponents + 1, BLOCK))
    uneven = np.zeros((2 * exponents + 1, BLOCK))
    return Tables(
        np.full(exponents, np.nan, like.dtype),
        even,
        uneven,
        np.empty(BLOCK),
        np.zeros(exponents, like.dtype),
        np.zeros((outputs, 2 * exponents + 1)),
        np.zeros(2 * exponents + 1, np.int64),
    )


@compiled
def grid(times):  # type: ignore[no-untyped-def]
    """Return the step of the times, and the most by which one of them is off an even grid."""
    last = times.size - 1
    if last < 1:
        return 0.0, np.inf
    step, off = (times[last] - times[0]) / last, 0.0
    for j in range(last + 1):
        off = max(off, abs(times[j] - (times[0] + j * step)))
    return step, off


@merged
def fill(tables, poles, rates, step, off):  # type: ignore[no-untyped-def]
    """Write the exponentials of an even grid, where they are not there; False for another grid."""
    for e in range(poles.size + rates.size):
        exponent = poles[e] if e < poles.size else rates[e - poles.size]
        if exponent == 0.0 and e >= poles.size:
            continue
        if abs(exponent) * off > UNEVEN or abs(np.real(exponent)) * step * BLOCK > LARGE:
            return False
        if tables.exponents[e] != exponent:
            tables.exponents[e] = exponent
            if np.iscomplexobj(poles):
                _powers(exponent * step, tables.even[2 * e], tables.even[2 * e + 1])
            else:
                real_powers(np.real(exponent) * step, BLOCK, tables.local, tables.even[2 * e])
    return True


@lean
def _powers(z, real, imaginary):  # type: ignore[no-untyped-def]
    for j in range(_STRIDES[0]):
        fine = np.exp(z * j)
        real[j], imaginary[j] = np.real(fine), np.imag(fine)
    for level in range(1, len(_STRIDES)):
        stride = _STRIDES[level - 1]
        for i in range(stride, _STRIDES[level], stride):
            coarse = np.exp(z * i)
            a, b = np.real(coarse), np.imag(coarse)
            for j in range(stride):
                real[i + j] = a * real[j] - b * imaginary[j]
                imaginary[i + j] = a * imaginary[j] + b * real[j]


@lean
def real_powers(z, size, coarse, row):  # type: ignore[no-untyped-def]
    """Write e^(z j) for all j below `size`, and to the end of a stride; `coarse` is scratch."""
    for j in range(_STRIDE):
        row[j] = exponential(z * j)
    for i in range(BLOCK // _STRIDE):
        coarse[i] = exponential(z * (i * _STRIDE))
    for i in range(1, (size + _STRIDE - 1) // _STRIDE):
        _multiply(coarse[i], row[:_STRIDE], row[i * _STRIDE :])


@lean
def _multiply(factor, first, row):  # type: ignore[no-untyped-def]
    for j in range(_STRIDE):
        row[j] = factor * first[j]


@merged
def block(times, first, size, even, system, forces, i, length, span, tables, out):  # type: ignore[no-untyped-def]
    """Answer some times of one span."""
    here, begin, modes = forces.knots[i], forces.knots[0], system.poles.size
    local = tables.local[:size]
    for j in range(size):
        local[j] = times[first + j] - here
    _exponentials(local, even, system, forces, i, span, tables, here - begin)
    rows = tables.even if even else tables.uneven
    count, parts = 0, 2 if np.iscomplexobj(system.poles) else 1
    for e in range(tables.scale.size):
        if not span.live[e] or tables.scale[e] == 0.0:
            continue
        for part in range(parts):
            tables.which[count + part] = 2 * e + part
        for r in range(out.shape[0]):
            share = system.outputs[e, r] if e < modes else span.forced[r, e - modes, 0]
            factor = share * tables.scale[e] if share != 0.0 else share
            tables.factors[r, count] = np.real(factor)
            if parts == 2:
                tables.factors[r, count + 1] = -np.imag(factor)
        count += parts
    for r in range(out.shape[0]):
        line = out[r, first : first + size]
        _line(line, local, span.powers[r], length, tables.factors[r], rows, tables.which, count)
        for q in range(forces.rates.size):
            if not span.live[modes + q]:
                continue
            _rising(line, local, span.forced[r, q], modes + q, rows, tables)


@merged
def _exponentials(local, even, system, forces, i, span, tables, since):  # type: ignore[no-untyped-def]
    """Write the scale of each exponential at the block's beginning, or all of them."""
    modes, width = system.poles.size, forces.knots[i + 1] - forces.knots[i]
    for e in range(tables.scale.size):
        tables.scale[e] = 1.0
        if not span.live[e]:
            continue
        for j in range(1 if even else local.size):
            u = local[j]
            if e < modes:
                found = _amplitude(system.poles[e], e, u, width, since, span)
            else:
                found = np.exp(forces.rates[e - modes] * u)
            if even:
                tables.scale[e] = found
            else:
                tables.uneven[2 * e, j] = np.real(found)
                tables.uneven[2 * e + 1, j] = np.imag(found)


@merged
def _amplitude(pole, mode, u, width, since, span):  # type: ignore[no-untyped-def]
    """The exponential part of one mode; what would be nothing times infinity is nothing."""
    total = 0.0 * pole
    if span.start[mode] != 0.0:
        total += span.start[mode] * np.exp(pole * u)
    if span.end[mode] != 0.0:
        total += span.end[mode] * np.exp(pole * (u - width))
    if span.lift[mode] != 0.0:
        total += span.lift[mode] * np.exp(pole * (since + u))
    return total


@merged
def _line(line, u, powers, length, factors, rows, which, count):  # type: ignore[no-untyped-def]
    """Write a power series and a sum of exponentials, four and two of them at a time."""
    low = 4 * ((length - 1) // 4)
    c = powers[low : low + 4]
    fused = min(count, 2) if low == 0 else 0
    a = factors[0] if fused > 0 else 0.0
    b = factors[1] if fused > 1 else 0.0
    none = rows.shape[0] - 1
    first = rows[which[0] if fused > 0 else none]
    second = rows[which[1] if fused > 1 else none]
    if length <= 2:
        _straight(line, u, c[0], c[1], a, first, b, second)
    else:
        _begin(line, u, c[0], c[1], c[2], c[3], a, first, b, second)
    while low > 0:
        low -= 4
        _lower(line, u, powers[low], powers[low + 1], powers[low + 2], powers[low + 3])
    for k in range(fused, count, 2):
        two = k + 1 < count
        second = rows[which[k + 1] if two else none]
        add(line, factors[k], rows[which[k]], factors[k + 1] if two else 0.0, second)


@merged
def _straight(line, u, c0, c1, a, first, b, second):  # type: ignore[no-untyped-def]
    for j in range(line.size):
        line[j] = c1 * u[j] + c0 + (a * first[j] + b * second[j])


@merged
def _begin(line, u, c0, c1, c2, c3, a, first, b, second):  # type: ignore[no-untyped-def]
    for j in range(line.size):
        line[j] = ((c3 * u[j] + c2) * u[j] + c1) * u[j] + c0 + (a * first[j] + b * second[j])


@lean
def _lower(line, u, c0, c1, c2, c3):  # type: ignore[no-untyped-def]
    for j in range(line.size):
        line[j] = (((line[j] * u[j] + c3) * u[j] + c2) * u[j] + c1) * u[j] + c0


@lean
def add(line, a, first, b, second):  # type: ignore[no-untyped-def]
    """Add two rows, each times a factor."""
    for j in range(line.size):
        line[j] += a * first[j] + b * second[j]


@lean
def _rising(line, u, terms, e, rows, tables):  # type: ignore[no-untyped-def]
    """Add the higher powers of an input's own exponential."""
    for k in range(1, terms.size):
        if terms[k] != 0.0:
            factor = terms[k] * tables.scale[e]
            a, b = np.real(factor), np.imag(factor)
            for j in range(line.size):
                line[j] += (a * rows[2 * e, j] - b * rows[2 * e + 1, j]) * u[j] ** k
