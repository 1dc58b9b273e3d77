"""The least reach on whose edge two unstable coordinates lie, case by case (`recoverable`)."""

from typing import Any

from tvclin.kernels.source import bare, kernel

_STEPS = 100
"""Of Newton, which from above takes ten or so; more only where the path is nearly an edge."""
_ARRIVED = 2.0**-51
"""A last step of two roundings."""


PLAIN, COMPILED = 5e-5, 5e-7
"""About how many seconds a reach takes, in plain Python and as machine code."""


@kernel
def least_reaches(fast: Any, slow: Any, ratio: Any, out: Any, first: int, last: int) -> None:
    """Write the reach to ``out (n,)``; arguments as of `recoverable.least_reach`, ``(n,)`` each."""
    for case in range(first, last):
        z, w = fast[case], slow[case]
        size = max(abs(z), abs(w))
        out[case] = size
        if size > 0.0:
            z, w, power = z / size, w / size, 1.0 / ratio[case]
            out[case] = size / min(_part(z, w, power), _part(-z, -w, power))


@bare
def _part(z: float, w: float, power: float) -> float:
    """Return the largest part of (z, w), at most one, that is on the right side of a path.

    That is z > 2 ((1 + w)/2)^power - 1. What is spare is concave in the part and first positive, so
    Newton's steps from beyond come down to the end of it and never pass it.
    """
    part = 1.0
    for _ in range(_STEPS):
        base = 0.5 * (1.0 + part * w)
        below = base ** (power - 1.0) if base > 0.0 else 0.0
        spare = 1.0 + part * z - 2.0 * below * base
        slope = z - power * below * w
        if spare >= 0.0 or slope >= 0.0:
            break
        step = spare / slope
        part -= step
        if step <= _ARRIVED * part:
            break
    return part
