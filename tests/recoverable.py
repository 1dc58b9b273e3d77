"""Recoverable coordinates of the unstable modes, by the edges of their range."""

import numpy as np

from tvclin.kernels.control_laws import slow_edges


def slow_range(modes, fast, reach):
    """Return both ends [rad] of the slow coordinate's recoverable range at a fast coordinate."""
    # `slow_edges` takes and returns coordinates over `reach`, at a ratio of slow to fast pole
    return tuple(reach * end for end in slow_edges(np.clip(fast / reach, -1.0, 1.0), modes.ratio))


def are_recoverable(modes, z, reach):
    """Return whether coordinates z [rad], ``(..., N)``, are within the edges for a `reach`."""
    recoverable = np.abs(z[..., 0]) < reach
    if modes.poles.size == 1:
        return recoverable
    low, high = slow_range(modes, z[..., 0], reach)
    return recoverable & (low < z[..., 1]) & (z[..., 1] < high)
