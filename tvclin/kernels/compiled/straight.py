"""Modes with real poles that straight lines drive, of several cases side by side.

Between two knots such a mode is

    a + b u + A e^(p u),

u being the time since the knot. A is carried from knot to knot, forward where the mode decays and
backward where it grows. Nothing cancels as long as p times the width of a span is not small.

Everything lies in two flat arrays, in rows of which the lanes are innermost (as in `lanes`); what
comes before and after is in `straight_cases`.
"""

import numpy as np

from tvclin.kernels.compiled.compiler import lean
from tvclin.kernels.compiled.exponentials import exponential

LANES = 16
"""The fewest that the compiler thinks worth vectors, where overlaps are to be tested."""
ALL = np.uint64(LANES)

KNOT, WIDTH, BEGIN, DEFLECTION, WIND = 0, 1, 2, 3, 6
"""Rows of a span: its knot, its width, its first time since the knot, then those of each input."""
VALUE, SLOPE, SIZE = 0, 1, 2
"""Rows of an input: its value at the knot, its slope, and the size of what the value is made of."""
SPAN = 9

POLE, GAINS, ROUNDINGS, RESIDUE = 0, 1, 3, 4
"""Rows of a mode: its pole, both its gains, the roundings in its residue, and the residue."""
HEAD = 5
CONSTANT, LINEAR, ENDING, DECAY, EDGE, OWN, STATE, SCALE = range(8)
"""Rows of a mode in a span: a, b, a + b u at the end, and e^(-|p| width); at the knot, where it
must be so as not to grow for ever, the size of what that is summed from, and where it comes to if
it decays; A e^(p u) at the first time.
"""
PART = 8

FAR = 700.0
"""e^-700 is nothing."""
_EPS = float(np.finfo(float).eps)


@lean
def row(number: int) -> np.uint64:
    """Return where a row begins."""
    return np.uint64(number * LANES)


@lean
def head(mode, count):  # type: ignore[no-untyped-def]
    """Return how many rows stand before those of a mode, with `count` spans and an end for each."""
    return mode * (HEAD + PART * (count + 1))


@lean
def part(mode, i, count):  # type: ignore[no-untyped-def]
    """Return how many rows stand before those of a mode in span `i`."""
    return head(mode, count) + HEAD + PART * i


@lean
def solve(spans, modes, mode, count):  # type: ignore[no-untyped-def]
    """Write what one mode does in each of `count` spans."""
    own = row(head(mode, count))
    for i in range(count):
        _follow(spans, modes, row(SPAN * i), own, row(part(mode, i, count)))
    for i in range(count - 1, -1, -1):
        _come_back(spans, modes, row(SPAN * i), own, row(part(mode, i, count)))
    _keep_residue(modes, own, row(part(mode, 0, count)))
    for i in range(count):
        _go_on(spans, modes, row(SPAN * i), own, row(part(mode, i, count)))


@lean
def _follow(spans, modes, span, mode, here):  # type: ignore[no-untyped-def]
    """Write the straight line that a mode follows, and how it decays beside it."""
    for i in range(ALL):
        pole, width = modes[mode + row(POLE) + i], spans[span + row(WIDTH) + i]
        first, second = modes[mode + row(GAINS) + i], modes[mode + row(GAINS + 1) + i]
        value = first * spans[span + row(DEFLECTION + VALUE) + i]
        value += second * spans[span + row(WIND + VALUE) + i]
        slope = first * spans[span + row(DEFLECTION + SLOPE) + i]
        slope += second * spans[span + row(WIND + SLOPE) + i]
        linear = -slope / pole
        constant = (linear - value) / pole
        modes[here + row(CONSTANT) + i] = constant
        modes[here + row(LINEAR) + i] = linear
        modes[here + row(ENDING) + i] = linear * width + constant
        modes[here + row(DECAY) + i] = exponential(max(-abs(pole) * width, -FAR))


@lean
def _come_back(spans, modes, span, mode, here):  # type: ignore[no-untyped-def]
    """Carry a mode that grows to the beginning of a span, with the size of what is summed."""
    after = here + row(PART)
    for i in range(ALL):
        size, width = abs(modes[mode + row(POLE) + i]), spans[span + row(WIDTH) + i]
        first, second = abs(modes[mode + row(GAINS) + i]), abs(modes[mode + row(GAINS + 1) + i])
        decay = modes[here + row(DECAY) + i]
        whole = (1.0 - decay) / size
        rising = (whole - width * decay) / size
        level = first * spans[span + row(DEFLECTION + SIZE) + i]
        level += second * spans[span + row(WIND + SIZE) + i]
        slope = first * abs(spans[span + row(DEFLECTION + SLOPE) + i])
        slope += second * abs(spans[span + row(WIND + SLOPE) + i])
        next_own, next_edge = modes[after + row(OWN) + i], modes[after + row(EDGE) + i]
        own = whole * level + rising * slope + decay * next_own
        edge = decay * (next_edge - modes[here + row(ENDING) + i]) + modes[here + row(CONSTANT) + i]
        modes[here + row(OWN) + i] = own if width > 0.0 else next_own
        modes[here + row(EDGE) + i] = edge if width > 0.0 else next_edge


@lean
def _keep_residue(modes, mode, here):  # type: ignore[no-untyped-def]
    """Write the residue of a mode that grows; one within the rounding of its sum is zero."""
    for i in range(ALL):
        edge, own = modes[here + row(EDGE) + i], modes[here + row(OWN) + i]
        large = abs(edge) > _EPS * modes[mode + row(ROUNDINGS) + i] * own
        grows = modes[mode + row(POLE) + i] > 0.0
        modes[mode + row(RESIDUE) + i] = -edge if large and grows else 0.0


@lean
def _go_on(spans, modes, span, mode, here):  # type: ignore[no-untyped-def]
    """Carry a mode that decays to the end of a span, and write what either is at its first time."""
    after = here + row(PART)
    for i in range(ALL):
        pole, width = modes[mode + row(POLE) + i], spans[span + row(WIDTH) + i]
        begin, knot = spans[span + row(BEGIN) + i], spans[span + row(KNOT) + i]
        state, ending = modes[here + row(STATE) + i], modes[here + row(ENDING) + i]
        free = state - modes[here + row(CONSTANT) + i]
        there = ending + modes[here + row(DECAY) + i] * free
        modes[after + row(STATE) + i] = there if width > 0.0 else state
        grows = pole > 0.0
        amplitude = modes[after + row(EDGE) + i] - ending if grows else free
        far = pole * (begin - width if grows else begin)
        scale = amplitude * exponential(max(far, -FAR))
        since = knot - spans[row(KNOT) + i] + begin
        lift = modes[mode + row(RESIDUE) + i] * exponential(max(pole * since, -FAR))
        modes[here + row(SCALE) + i] = scale + lift
