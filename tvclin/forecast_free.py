"""The least deflection of any law that does not know when the wind will stop.

Let W(t) be the wind still to come, discounted with the unstable pole p,

    W(t) = p * integral from t to infinity of e^(-p (r - t)) alpha_w(r) dr.

A law that is told the whole wind needs sup-norm W(onset), appendix C. One that must be able to
survive when the wind stops for good at any instant needs

    y* = max{ W(onset), sup W / 2 }

and a law that leans into the felt wind as far as it can still return from reaches it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.cards import card
from tvclin.errors import InputError, ending, instance, nonnegative, number, single
from tvclin.histories import History
from tvclin.kernels.crossings import roots_between
from tvclin.plant import Plant
from tvclin.recoverable import unstable_coordinates

FloatArray = NDArray[np.float64]

EXACT = "exact"
BOUND = "bound of the fast mode"


@dataclass(frozen=True)
class ForecastFreeLimit:
    """What no law without a forecast can do without.

    Attributes
    ----------
    limit : float
        y*, over the trim deflection B alpha_w,max without drift.
    deflection : float
        The same as a deflection [rad], -limit B alpha_w,max; its sign opposes the wind.
    kind : str
        "exact", or for models with drift "bound of the fast mode": no law needs less.
    foresight : float
        W(onset) over the peak: what is needed when the whole wind is known.
    worst_stop : float
        The instant [s] from which most is still to come: W is largest there, and a law must lean
        by W - y* at least. What a stop then leaves to be done is another matter.
    """

    limit: float
    deflection: float
    kind: str
    foresight: float
    worst_stop: float

    def _repr_html_(self) -> str:
        rows = [
            ("limit, of full trim", self.limit, "-"),
            ("deflection", np.degrees(self.deflection), "deg"),
            ("kind", self.kind, ""),
            ("with foresight", self.foresight, "-"),
            ("worst stop", self.worst_stop, "s"),
        ]
        return card("Least limit without a forecast", rows)


def forecast_free_limit(plant: Plant, wind: History, reversal: float = 0.0) -> ForecastFreeLimit:
    """Return the least deflection of any law that does not know when the wind will stop.

    Parameters
    ----------
    plant : Plant
        One plant with one or two real unstable poles.
    wind : History
        One wind of one sign, which ends.
    reversal : float
        R, the discounted impulse of a wind of the other sign that may come at any instant instead
        of a stop, over the peak: ``p * integral of e^(-p r) |alpha_w(r)| dr``, counted from the
        reversal. Then y = max{W(onset), (sup W + R)/2, R}. One is a full reversal for ever.

    Raises
    ------
    InputError
        For a wind that changes its sign (y* is not defined for it: give the part of one sign and
        the reversal), is zero or never ends, and for a plant without a real unstable pole.

    Notes
    -----
    Without drift it is exact: the law that deflects fully until z = D and then holds z = D keeps
    the largest z that a stop allows, needs no forecast, and survives exactly above y*. With drift
    it is a bound, of the fast mode alone; the slow mode adds a little.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> found = tv.forecast_free_limit(plant, tv.TriangularWind(peak=0.1, duration=40.0))
    >>> round(found.limit, 4), round(found.foresight, 4)
    (0.4653, 0.1)
    """
    modes = unstable_coordinates(plant)
    instance("wind", wind, History, "such as TriangularWind")
    R = number("reversal", reversal, nonnegative)
    single("wind", wind.batch)
    ending("wind", wind.end)
    peak, pole = float(wind.peak), float(modes.poles[0])
    times = wind.probe_times(16)
    _check_one_signed(wind(times) / peak)
    ahead, when = _largest_future(wind, times, pole, peak)
    foresight = pole * float(wind.future(pole, wind.onset)) / peak
    limit = abs(float(modes.wind[0])) * max(foresight, (ahead + R) / 2.0, R)
    kind = EXACT if plant.model == "fixed-path" else BOUND
    B = float(plant.coefficients.B)
    scaled = abs(float(modes.wind[0])) * foresight
    return ForecastFreeLimit(limit, -limit * B * peak, kind, scaled, when)


def _largest_future(
    wind: History, times: FloatArray, pole: float, peak: float
) -> tuple[float, float]:
    """Sup W over the peak and its instant: W' = p (W - w) falls through zero there."""

    def excess(t: FloatArray, _: Any = None) -> FloatArray:
        return (wind(t) - pole * wind.future(pole, t)) / peak

    values = excess(times)
    rising = np.flatnonzero((values[:-1] < 0.0) & (values[1:] > 0.0))
    inner = roots_between(times[rising], times[rising + 1], excess)
    every = np.concatenate([times, inner])
    future = pole * wind.future(pole, every) / peak
    best = int(np.argmax(future))
    return float(future[best]), float(every[best])


def _check_one_signed(values: FloatArray) -> None:
    if values.min() < -1e-12:
        raise InputError(
            "a limit without forecast is not defined for a wind that changes its sign; give the"
            " wind of one sign, and what may follow it as reversal"
        )
