"""What the trim law needs in flight, where the condition (4b) does not hold for it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tvclin.boundary.limit import COMPARABLE, ROUNDING, leading_pole
from tvclin.linear.deflections import trim_deflection
from tvclin.linear.modes import unstable_poles
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History

FloatArray = NDArray[np.float64]

_GAIN = 10.0
"""Of the attitude feedback of the trim law that is flown, over that of trim; as of `TrimLaw`."""
_SAMPLES = 250.0
"""Of that law in the time in which the fastest mode grows by e: it is late by a part of 0.002."""
_COARSE = 50.0
"""In a first flight: a law that is late by 0.01 and yet survives is not lost when it is quicker."""
_FEWEST_SAMPLES, _MOST_SAMPLES = 25.0, 5e5
"""At least so many, in a wind so long that the others would be more than `_MOST_SAMPLES` in all."""
_RATES = (0.01, 1e6)
"""Sample rates that can be flown [Hz]."""
_QUICK = 0.1
"""A path that answers with more than this part of the fastest rate has a say beside it."""
_TINY = 1e-12
"""A limit [rad] in place of none, where nothing is needed and nothing asked."""
_HIGHEST = 4.0
"""Over the trim deflection without drift: where trim grows without end no more is tried."""
_TRIES, _MANY_TRIES = 12, 48
"""Limits in a round; with b1 < 0 the law may be lost in a narrow band above limits that survive."""
_ROUNDS = 3
"""Of tries, each in the step where the one before found the edge: 1/1331 of the first range."""
_MORE = 1e-6
"""Above the largest trim deflection, with which the law is not limited."""


def trim_law_flown(
    plant: Plant, wind: History, flies: NDArray[np.bool_], least: FloatArray
) -> FloatArray:
    """Return what the trim law needs flown [rad], at least `least`, where it flies; else 0."""
    shape = least.shape
    found = np.zeros(shape)
    if not np.any(flies):
        return found
    trim = np.broadcast_to(np.abs(trim_deflection(plant, wind).peak), shape)
    grows = np.asarray(plant.coefficients.b1) < 0.0
    for group, tries in ((flies & ~grows, _TRIES), (flies & grows, _MANY_TRIES)):
        which = np.flatnonzero(np.broadcast_to(group, shape))
        if which.size:
            some, winds = plant.some(which, shape), wind.some(which, shape)
            low, high = least.ravel()[which], trim.ravel()[which]
            found.ravel()[which] = _least_flown(some, winds, low, high, tries)
    return found


def can_fly(plant: Plant) -> NDArray[np.bool_]:
    """Return whether flights of the trim law can be judged: something grows, and no pair does."""
    rate, paired = leading_pole(plant)
    return np.asarray(~paired & ~np.isnan(rate))


def comes_back(wind: History) -> NDArray[np.bool_]:
    """Return whether a wind rises again after it has fallen: the trim law has let go meanwhile."""
    size = np.abs(wind.peak)[..., np.newaxis]
    change = np.diff(np.abs(wind.looked_at), axis=-1)
    fallen = np.logical_or.accumulate(change < -ROUNDING * size, axis=-1)
    return np.asarray(np.any(fallen & (change > ROUNDING * size), axis=-1))


def path_counts(plant: Plant) -> NDArray[np.bool_]:
    """Return whether the path has a say beside the fastest mode: in a second, or by its pace."""
    poles = unstable_poles(plant)
    if plant.model == "fixed-path" or not poles.shape[-1]:
        return np.zeros(plant.batch, dtype=bool)
    fast, b1 = np.real(poles[..., 0]), np.asarray(plant.coefficients.b1)
    with np.errstate(invalid="ignore"):  # NaN stands for a pole that is not there
        counts = (b1 < 0.0) | (b1 > _QUICK * fast)
        if poles.shape[-1] > 1:
            counts = counts | (np.real(poles[..., 1]) > COMPARABLE * fast)
    return np.asarray(counts)


def lost_flown(
    plant: Plant, wind: History, limit: FloatArray, asked: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return which of the trim laws that are asked for are lost with limits [rad]."""
    shape = asked.shape
    lost = np.array(asked)
    for samples in (_COARSE, _SAMPLES):
        which = np.flatnonzero(lost)
        if which.size:
            some, winds = plant.some(which, shape), wind.some(which, shape)
            lost.ravel()[which] = ~_survives(some, winds, limit.ravel()[which], samples)
    return lost


def _survives(
    plant: Plant, wind: History, limit: FloatArray, samples: float = _SAMPLES
) -> NDArray[np.bool_]:
    """Whether delta = B alpha + ``|B|`` gain (theta + theta'/(p + d)) survives with limits [rad].

    p + d is the pace of the other pole on a fixed path, beta without damping. The speed of a plant
    is left out. What is too long to be flown does not survive.
    """
    from tvclin.control.autopilot.autopilot import Autopilot
    from tvclin.flights.closed_loop.many import fly_many

    c = plant.coefficients
    gain, half = _GAIN * np.abs(c.B), np.asarray(c.damping) / 2.0
    pace = half + np.hypot(half, np.sqrt(np.abs(c.mu_alpha)))
    with np.errstate(divide="ignore", invalid="ignore"):  # without a moment nothing is flown
        rate_gain = np.where(pace > 0.0, gain / pace, 0.0)
    law = Autopilot(attitude_gain=gain, rate_gain=rate_gain, alpha_gain=c.B)
    model = "drift-exact" if plant.model == "drift-and-speed" else plant.model
    limits = np.where(limit > 0.0, limit, _TINY)
    with np.errstate(invalid="ignore", divide="ignore"):
        pole, span = leading_pole(plant)[0], wind.end - wind.onset
        asked = np.maximum(np.minimum(samples * pole, _MOST_SAMPLES / span), _FEWEST_SAMPLES * pole)
        rate = np.clip(asked, *_RATES)
        flyable = span * rate <= 2.0 * _MOST_SAMPLES
        limits = np.where(flyable, limits, np.nan)
    flown = fly_many(Plant(c, model), law, wind, deflection_limit=limits, sample_rate=rate)
    return np.asarray(flown.status == "survived")


def _least_flown(
    plant: Plant, wind: History, low: FloatArray, high: FloatArray, tries: int
) -> FloatArray:
    """The least limit [rad] above which all that are tried survive, from `low` to `high`.

    The law is not limited by `high`. With b1 < 0 trim itself grows without end: no more is tried
    than a few times the wind's, and where that is lost no limit is enough.
    """
    c = plant.coefficients
    grows = np.asarray(c.b1) < 0.0
    high = np.where(grows, np.minimum(high, _HIGHEST * np.abs(c.B * wind.peak)), high)
    parts = np.linspace(0.0, 1.0, tries)[:, np.newaxis]
    high = np.maximum(high * (1.0 + _MORE), low)
    never = np.zeros(low.shape, dtype=bool)
    for _ in range(_ROUNDS):
        tried = low + parts * (high - low)
        lost = lost_flown(plant, wind, tried, np.ones(tried.shape, dtype=bool))
        never |= grows & lost[-1]
        last = np.where(lost.any(axis=0), tries - 1 - np.argmax(lost[::-1], axis=0), -1)
        everyone = np.arange(low.size)
        high = tried[np.minimum(last + 1, tries - 1), everyone]
        low = tried[np.maximum(last, 0), everyone]
    return np.where(never, np.inf, high)
