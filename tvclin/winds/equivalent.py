"""The triangle that stands for a real wind."""

from __future__ import annotations

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, instance
from tvclin.winds.histories import History
from tvclin.winds.pulses import TriangularWind

_CANCELLED = 1e-12
"""An area this small against the sum of its parts is what rounding leaves of none."""


def equivalent_triangle(wind: History) -> History:
    """Return the triangular wind with the area and the peak of a wind, from the same start on.

    Its duration is twice the area over the peak.

    Parameters
    ----------
    wind : History
        Wind angle of attack, one or a batch, that ends.

    Returns
    -------
    History
        A `TriangularWind`, or one shifted (a plain history) where the wind does not start at
        t = 0.

    Raises
    ------
    InputError
        For a wind that never ends, one whose area has not the sign of its peak (that of opposite
        lobes which cancel, or of no wind at all), and a peak beyond 90 degrees.

    Notes
    -----
    The report, under "Results": "reasonable results can be obtained by approximating the real
    wind with a triangle of the same area and maximum velocity". `triangle_error` says how
    reasonable, for a given plant.

    Examples
    --------
    >>> from tvclin.winds.gusts import OneMinusCosineGust
    >>> from tvclin.winds.equivalent import equivalent_triangle
    >>> equivalent_triangle(OneMinusCosineGust(peak=0.08, duration=6.0))
    TriangularWind(peak=0.08, duration=6.0)
    """
    instance("wind", wind, History, "such as OneMinusCosineGust")
    if np.any(wind.end == np.inf):
        raise InputError("wind must end: the last piece of its history must be zero")
    peak, area = np.asarray(wind.peak), wind.laplace(0.0)
    _check_area(area, peak, _CANCELLED * wind.laplace_magnitude(0.0))
    triangle = TriangularWind(peak=peak, duration=2.0 * area / peak)
    return triangle.shift(wind.onset) if np.any(wind.onset != 0.0) else triangle


def _check_area(area: FloatArray, peak: FloatArray, least: FloatArray) -> None:
    area, peak, least = np.broadcast_arrays(area, peak, least)
    bad = np.sign(peak) * area <= least
    if np.any(bad):
        which = int(np.argmax(bad))
        raise InputError(
            f"wind must have a time integral with the sign of its peak; got {area.flat[which]:.6g}"
            f" rad s with a peak of {peak.flat[which]:.6g} rad"
        )
