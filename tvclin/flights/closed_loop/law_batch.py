"""The laws of a batch of flights, each told apart and written down once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tvclin.base.errors import MOST_AXES, InputError
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.laws.law import Law
from tvclin.kernels.control_laws import LawNumbers
from tvclin.kernels.flights import MEASURED
from tvclin.kernels.propagation import driven, exponentials

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LawBatch:
    """The laws of m flights.

    Attributes
    ----------
    laws : tuple of Law
        Those that there are; none where a batch of gains stands for them.
    numbers : list of LawNumbers or None
        Of each; None where Python must be asked.
    which : ndarray of int
        The law of each flight, ``(m,)``.
    """

    laws: tuple[Law, ...]
    numbers: list[LawNumbers | None]
    which: NDArray[np.int64]

    @property
    def noise(self) -> list[tuple[float, int]]:
        """The noise of each law: a level [rad/s] and a seed."""
        return [law.rate_noise for law in self.laws] or [(0.0, 0)] * len(self.numbers)

    def steps(self, lengths: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what steps [s] ``(m,)`` make of the laws' own states, and of what they see.

        ``(m, s, s)`` and ``(m, s, 6)``, the last what a law asks for, which moves none of them; of
        one flight where no law has states.
        """
        systems = [law.states for law in self.laws] or [self._integral()]
        size = max(len(F) for F, _ in systems)
        if not size:
            return np.zeros((1, 0, 0)), np.zeros((1, 0, MEASURED + 1))
        which = self.which if self.laws else np.zeros(lengths.size, np.int64)
        kept = np.zeros((lengths.size, size, size))
        learnt = np.zeros((lengths.size, size, MEASURED + 1))
        for k, (F, G) in enumerate(systems):
            own, mine = len(F), np.flatnonzero(which == k)
            whole = exponentials(driven(F, G), lengths[mine])
            kept[mine, :own, :own] = whole[:, :own, :own]
            learnt[mine, :own, :MEASURED] = whole[:, :own, own:]
        return kept, learnt

    def _integral(self) -> tuple[FloatArray, FloatArray]:
        some = any(one is not None and one.first_state for one in self.numbers)
        return np.zeros((int(some), int(some))), np.eye(int(some), MEASURED)


def shape_of(law: Any) -> tuple[int, ...]:
    """Return the shape of a law, a batch of gains, or an array of laws."""
    if isinstance(law, Law):
        return ()
    return law.batch if isinstance(law, Autopilot) else np.shape(_array(law))


def law_batch(law: Any, shape: tuple[int, ...]) -> LawBatch:
    """Return the laws of a batch of flights of this shape.

    Raises
    ------
    InputError
        For what is no law, and for an autopilot with an actuator or a delay.
    """
    if isinstance(law, Autopilot):
        return _gains(law, shape)
    laws = _array(law)
    different = {id(one): one for one in laws.flat}
    places = {key: k for k, key in enumerate(different)}
    index = np.array([places[id(one)] for one in laws.flat], dtype=np.int64).reshape(laws.shape)
    every = tuple(different.values())
    numbers = [one.numbers for one in every]
    return LawBatch(every, numbers, np.broadcast_to(index, shape).ravel())


def _array(law: Any) -> NDArray[Any]:
    laws = np.asarray(law, dtype=object)
    if not laws.size or laws.ndim > MOST_AXES or not all(isinstance(one, Law) for one in laws.flat):
        raise InputError(
            "law must be a Law such as TrimLaw, an array of them, or an Autopilot with a batch of"
            f" gains; got {type(law).__name__}"
        )
    return laws


def _gains(gains: Autopilot, shape: tuple[int, ...]) -> LawBatch:
    gains.require_plain("a flight")
    if gains.actuator is not None or np.any(np.asarray(gains.delay)):
        raise InputError(
            "an autopilot is flown for its gains only: give actuator and delay to the flight"
        )
    fields = (gains.attitude_gain, gains.rate_gain, gains.alpha_gain, gains.integral_gain)
    rows = zip(*(np.broadcast_to(one, gains.batch).ravel().tolist() for one in fields), strict=True)
    numbers: list[LawNumbers | None] = [
        LawNumbers(attitude=a, attitude_rate=r, angle_of_attack=b, first_state=i)
        for a, r, b, i in rows
    ]
    index = np.arange(len(numbers)).reshape(gains.batch)
    return LawBatch((), numbers, np.broadcast_to(index, shape).ravel())
