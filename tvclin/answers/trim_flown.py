"""What the trim law needs in flight, where the condition (4b) does not hold for it."""

from __future__ import annotations

from functools import partial

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.boundary.limit import COMPARABLE, leading_pole
from tvclin.boundary.open_loop import ROUNDING
from tvclin.linear.deflections import trim_deflection
from tvclin.linear.modes import unstable_poles
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History

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
_TOGETHER = 64
"""Cases of which the largest trim deflection is sought, and which are flown, at a time: each takes
four megabytes where wind and gust have many pieces."""
_MORE = 1e-6
"""Above the largest trim deflection, with which the law is not limited."""


def trim_law_flown(plant: Plant, wind: History, flies: BoolArray, least: FloatArray) -> FloatArray:
    """Return what the trim law needs flown [rad], at least `least`, where it flies; else 0.

    The law is not limited by the largest trim deflection. With b1 < 0 trim itself grows without
    end: no more is tried than a few times the wind's, and where that is lost no limit is enough.
    """
    shape = least.shape
    found = np.zeros(shape)
    which = np.flatnonzero(np.broadcast_to(flies, shape))
    if not which.size:
        return found
    from tvclin.flights.closed_loop.survival_limit import (
        edges_above_losses,  # late: with all flights
    )

    low = np.maximum(least.ravel()[which], _TINY)
    for k in range(0, which.size, _TOGETHER):
        part = slice(k, k + _TOGETHER)
        some, winds = plant.cases(which[part], shape), wind.cases(which[part], shape)
        c, most = some.coefficients, np.abs(trim_deflection(some, winds).peak)
        grows = np.broadcast_to(np.asarray(c.b1) < 0.0, most.shape)
        most = np.where(grows, np.minimum(most, _HIGHEST * np.abs(c.B * winds.peak)), most)
        lost = partial(_all_lost, some, winds)
        top = np.maximum(most * (1.0 + _MORE), low[part])
        edge, never = edges_above_losses(lost, low[part], top)
        found.ravel()[which[part]] = np.where(grows & never, np.inf, edge)
    return found


def _all_lost(plant: Plant, wind: History, limits: FloatArray) -> BoolArray:
    """Return which limits [rad], ``(k, n)``, a trim law flown with each of them is lost with."""
    return lost_flown(plant, wind, limits, np.ones(limits.shape, dtype=bool))


def can_fly(plant: Plant) -> BoolArray:
    """Return whether flights of the trim law can be judged: something grows, and no pair does."""
    rate, paired = leading_pole(plant)
    return np.asarray(~paired & ~np.isnan(rate))


def comes_back(wind: History) -> BoolArray:
    """Return whether a wind rises again after it has fallen: the trim law has let go meanwhile."""
    size = np.abs(wind.peak)[..., np.newaxis]
    change = np.diff(np.abs(wind.shape_samples), axis=-1)
    fallen = np.logical_or.accumulate(change < -ROUNDING * size, axis=-1)
    return np.asarray(np.any(fallen & (change > ROUNDING * size), axis=-1))


def path_counts(plant: Plant) -> BoolArray:
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


def lost_flown(plant: Plant, wind: History, limit: FloatArray, asked: BoolArray) -> BoolArray:
    """Return which of the trim laws that are asked for are lost with limits [rad]."""
    lost = np.array(asked)
    for samples in (_COARSE, _SAMPLES):
        if np.any(lost):
            lost &= ~_survives(plant, wind, np.where(lost, limit, np.nan), samples)
    return lost


def _survives(
    plant: Plant, wind: History, limit: FloatArray, samples: float = _SAMPLES
) -> BoolArray:
    """Whether delta = B alpha + b gain (theta + theta'/(p + d)) survives with limits [rad].

    b is |B| with the sign of mu_delta, so that the feedback brings the attitude back, and p + d the
    pace of the other pole on a fixed path, beta without damping. A plant whose speed changes is
    flown by itself where flights of it can be decided, and else without the change of its speed.
    What is too long to be flown does not survive, nor does what has no limit (NaN).
    """
    from tvclin.control.autopilot.autopilot import Autopilot
    from tvclin.flights.closed_loop.fly_many import fly_many
    from tvclin.flights.closed_loop.outcomes import decidable

    c = plant.coefficients
    gain, half = _GAIN * np.copysign(c.B, c.mu_delta), np.asarray(c.damping) / 2.0
    pace = half + np.hypot(half, np.sqrt(np.abs(c.mu_alpha)))
    with np.errstate(divide="ignore", invalid="ignore"):  # without a moment nothing is flown
        rate_gain = np.where(pace > 0.0, gain / pace, 0.0)
    law = Autopilot(attitude_gain=gain, rate_gain=rate_gain, alpha_gain=c.B)
    limits = np.where(limit <= 0.0, _TINY, limit)
    with np.errstate(invalid="ignore", divide="ignore"):
        pole, span = leading_pole(plant)[0], wind.end - wind.onset
        asked = np.maximum(np.minimum(samples * pole, _MOST_SAMPLES / span), _FEWEST_SAMPLES * pole)
        rate = np.clip(asked, *_RATES)
        flyable = span * rate <= 2.0 * _MOST_SAMPLES
        limits = np.where(flyable, limits, np.nan)
    if np.all(np.isnan(limits)):
        return np.zeros(limits.shape, dtype=bool)
    fly = partial(fly_many, law=law, wind=wind, deflection_limit=limits, sample_rate=rate)
    survived = fly(plant).status == "survived"
    if plant.model == "drift-and-speed" and not np.all(own := decidable(plant)):
        steady = fly(Plant(c, "drift-exact")).status == "survived"
        survived = np.where(own, survived, steady)
    return np.asarray(survived)
