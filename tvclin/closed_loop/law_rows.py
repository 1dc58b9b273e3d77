"""Laws as rows of numbers, for kernels that fly many cases at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.autopilot import Autopilot
from tvclin.errors import (
    MOST_AXES,
    InputError,
)
from tvclin.kernels import flight_table as table
from tvclin.laws import Law, RecoverableAttitudeLaw, Seen
from tvclin.laws.law import seen_coordinates

FloatArray = NDArray[np.float64]

_PROBES = 8


@dataclass(frozen=True, eq=False)
class LawRows:
    """The laws of a batch.

    Attributes
    ----------
    rows : ndarray
        ``(55, m)`` as of `FlightTable`, filled where they are the law's; engage and release over
        the deflection limit.
    free, driven : ndarray
        F and G of the laws' own states, ``(m, 2, 2)`` and ``(m, 2, 5)``.
    noise : list of tuple
        The noises that there are, each a level [rad/s] and a seed.
    hears : ndarray of int
        The noise of each law, ``(m,)``.
    """

    rows: FloatArray
    free: FloatArray
    driven: FloatArray
    noise: list[tuple[float, int]]
    hears: NDArray[np.int64]


def law_batch(law: Any) -> tuple[int, ...]:
    """Return the shape of a law, a batch of gains, or an array of laws."""
    if isinstance(law, Law):
        return ()
    return law.batch if isinstance(law, Autopilot) else np.shape(_laws(law))


def law_rows(law: Any, shape: tuple[int, ...]) -> LawRows:
    """Return the rows of laws, spread over the batch and flattened.

    Raises
    ------
    InputError
        For a law that is neither linear in what it sees nor a `RecoverableAttitudeLaw`, and for
        an autopilot with an actuator or a delay.
    """
    if isinstance(law, Autopilot):
        return _gains(law, shape)
    laws = _laws(law)
    different: dict[int, Law] = {id(one): one for one in laws.flat}
    places = {key: k for k, key in enumerate(different)}
    every = [_one(one) for one in different.values()]
    index = np.array([places[id(one)] for one in laws.flat]).reshape(laws.shape)
    which = np.broadcast_to(index, shape).ravel()
    noise = list(dict.fromkeys(one.rate_noise for one in different.values()))
    hears = np.array([noise.index(one.rate_noise) for one in different.values()])
    rows, free, driven = (np.stack(parts) for parts in zip(*every, strict=True))
    return LawRows(np.take(rows.T, which, axis=1), free[which], driven[which], noise, hears[which])


def _laws(law: Any) -> NDArray[Any]:
    laws = np.asarray(law, dtype=object)
    if not laws.size or laws.ndim > MOST_AXES or not all(isinstance(one, Law) for one in laws.flat):
        raise InputError(
            "law must be a Law such as TrimLaw, an array of them, or an Autopilot with a batch of"
            f" gains; got {type(law).__name__}"
        )
    return laws


def _gains(gains: Autopilot, shape: tuple[int, ...]) -> LawRows:
    if gains.actuator is not None or np.any(np.asarray(gains.delay)):
        raise InputError(
            "an autopilot is flown for its gains only: give the actuator to the flight"
        )
    size = int(np.prod(shape))
    rows = np.zeros((table.ROWS, size))
    places = {
        table.K_ATTITUDE: gains.attitude_gain,
        table.K_RATE: gains.rate_gain,
        table.K_ALPHA: gains.alpha_gain,
        table.K_MEMORY: gains.integral_gain,
        table.ENGAGE: 1.0,
        table.RELEASE: 1.0,
    }
    for place, value in places.items():
        rows[place] = np.broadcast_to(value, shape).ravel()
    rows[table.LEAN_PEAK] = np.inf
    driven = np.zeros((size, 2, 5))
    driven[:, 0, 0] = rows[table.K_MEMORY] != 0.0
    none = np.zeros(size, dtype=np.int64)
    return LawRows(rows, np.zeros((size, 2, 2)), driven, [(0.0, 0)], none)


def _one(law: Law) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rows, F and G of one law."""
    row, free, driven = np.zeros(table.ROWS), np.zeros((2, 2)), np.zeros((2, 5))
    F, G = law.states
    k = len(F)
    if k > len(free):
        raise InputError(f"a law with up to 2 states of its own can be flown so; got {k}")
    free[:k, :k], driven[:k] = F, G
    row[table.ENGAGE], row[table.RELEASE], row[table.LEAN_PEAK] = law.engage, law.release, np.inf
    if isinstance(law, RecoverableAttitudeLaw):
        _lean(row, law)
    else:
        _linear(row, law, k)
    return row, free, driven


def _linear(row: FloatArray, law: Law, k: int) -> None:
    """Gains are what a law answers to unit signals; that it is linear is tried."""

    def asked(signals: FloatArray, limit: float) -> FloatArray:
        found = law.demand(Seen(*signals[:5]), signals[5:], limit)
        return np.asarray(found, float) * np.ones(signals.shape[1])

    gains = asked(np.eye(5 + k), 1.0)
    probes = np.random.default_rng(1).normal(size=(5 + k, _PROBES))
    size = np.abs(gains) @ np.abs(probes)
    same = all(
        np.all(np.abs(asked(probes, limit) - gains @ probes) <= 1e-12 * size)
        for limit in (1e-3, 1.0)
    )
    if not same or gains[4] != 0.0 or (k > 1 and gains[6] != 0.0):
        raise InputError(
            f"{type(law).__name__} is no law whose batches can be flown: it is neither linear in"
            " what it sees nor a RecoverableAttitudeLaw; use fly"
        )
    row[table.K_ATTITUDE : table.K_ALPHA + 1] = gains[:4]
    row[table.K_MEMORY] = gains[5] if k else 0.0


def _lean(row: FloatArray, law: RecoverableAttitudeLaw) -> None:
    modes = seen_coordinates(law.plant)
    row[table.LEAN] = 1.0
    seen = min(modes.rows.shape[1], 3)
    row[table.LEAN_ATTITUDE : table.LEAN_ATTITUDE + seen] = modes.rows[0, :seen]
    if modes.poles.size > 1:
        row[table.LEAN_SLOW : table.LEAN_SLOW + seen] = modes.rows[1, :seen]
    row[table.LEAN_RATIO], row[table.LEAN_WIND] = modes.ratio, modes.wind[0]
    row[table.LEAN_B] = float(np.asarray(law.plant.coefficients.B))
    row[table.LEAN_REACH], row[table.LEAN_GAIN] = law.reach, law.gain
    row[table.LEAN_BAND], row[table.LEAN_TRUST] = law.dead_band, law.trust
    if law.design_peak is not None:
        row[table.LEAN_PEAK] = law.design_peak
    row[table.LEAN_ESTIMATES] = float(law.estimator is not None)
