"""The laws of a batch of flights, each told apart and written down once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IntArray
from tvclin.base.errors import MOST_AXES, InputError
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import CHAINS
from tvclin.control.autopilot.wiring import (
    LAW_INPUTS,
    LAW_OUTPUT,
    RETURNED,
    attitude_integral,
    law_blocks,
)
from tvclin.control.laws.law import Chains, Law
from tvclin.kernels.control_laws import LawNumbers
from tvclin.kernels.flight_arrays import MEASURED
from tvclin.linear.system import LinearSystem, connect
from tvclin.numerics.state_space import beside

SENSED = ("sensed_attitude", "sensed_attitude_rate", *LAW_INPUTS[2:])
"""What the sensors give, as of `Measurement`."""


class Memory(NamedTuple):
    """What a step makes of the s states of laws with their filters, for each flight or for all.

    Each row acts on the states, then on what is sensed, five numbers, and what a law asks for.

    `moved`: the next states, ``(l, s, s + 6)``. `seen`: what the laws see, ``(l, 5, s + 6)``; of no
    length without filters. `told`: what the limit is told, ``(l, s + 6)``; likewise.
    """

    moved: FloatArray
    seen: FloatArray
    told: FloatArray


@dataclass(frozen=True, eq=False)
class LawBatch:
    """The laws of m flights.

    `laws`: those that there are; none where a batch of gains stands for them. `numbers`: of each;
    None where Python must be asked. `chains`: the filters of each law; of all at once where a batch
    of gains stands for them. `which`: the law of each flight, ``(m,)``.
    """

    laws: tuple[Law, ...]
    numbers: list[LawNumbers | None]
    chains: list[Chains]
    which: IntArray

    @property
    def noise(self) -> list[tuple[float, int]]:
        """The noise of each law: a level [rad/s] and a seed."""
        return [law.rate_noise for law in self.laws] or [(0.0, 0)] * len(self.numbers)

    def memory(self, lengths: FloatArray) -> Memory:
        """Return what steps [s] ``(m,)`` make of the states of the laws and their filters."""
        integral = any(one is not None and one.first_state for one in self.numbers)
        systems = [law.state_space for law in self.laws] or [attitude_integral(integral)]
        which = self.which if self.laws else np.zeros(lengths.size, np.int64)
        size = max(
            len(own.states) + sum(one.order for chain in chains for one in chain)
            for own, chains in zip(systems, self.chains, strict=True)
        )
        wide = size + MEASURED + 1
        filtered = any(any(chains) for chains in self.chains)
        if not size and not filtered:
            return Memory(
                np.zeros((1, 0, wide)), np.zeros((0, MEASURED, wide)), np.zeros((0, wide))
            )
        moved = np.zeros((lengths.size, size, wide))
        seen = np.zeros((lengths.size if filtered else 0, MEASURED, wide))
        told = np.zeros((lengths.size if filtered else 0, wide))
        for k, (own, chains) in enumerate(zip(systems, self.chains, strict=True)):
            mine = np.flatnonzero(which == k)
            one = _with_filters(own, chains, lengths[mine], size)
            moved[mine] = one.moved
            if filtered:
                seen[mine], told[mine] = one.seen, one.told
        return Memory(moved, seen, told)


def shape_of(law: Any) -> tuple[int, ...]:
    """Return the shape of a law, a batch of gains, or an array of laws."""
    if isinstance(law, Law):
        return ()
    return law.batch if isinstance(law, Autopilot) else np.shape(_array(law))


def law_batch(law: Any, shape: tuple[int, ...]) -> LawBatch:
    """Return the laws of a batch of flights of this shape.

    `InputError` for what is no law, and for an autopilot with an actuator or a delay.
    """
    if isinstance(law, Autopilot):
        return _gains(law, shape)
    laws = _array(law)
    different = {id(one): one for one in laws.flat}
    places = {key: k for k, key in enumerate(different)}
    index = np.array([places[id(one)] for one in laws.flat], dtype=np.int64).reshape(laws.shape)
    every = tuple(different.values())
    numbers = [one.numbers for one in every]
    chains = [one.chains for one in every]
    return LawBatch(every, numbers, chains, np.broadcast_to(index, shape).ravel())


def _array(law: Any) -> AnyArray:
    laws = np.asarray(law, dtype=object)
    if not laws.size or laws.ndim > MOST_AXES or not all(isinstance(one, Law) for one in laws.flat):
        raise InputError(
            "law must be a Law such as TrimLaw, an array of them, or an Autopilot with a batch of"
            f" gains; got {type(law).__name__}"
        )
    return laws


def _gains(gains: Autopilot, shape: tuple[int, ...]) -> LawBatch:
    late = gains.actuator is not None or np.any(np.asarray(gains.delay))
    if late or gains.sample_rate is not None:
        raise InputError(
            "an autopilot is flown for its gains and filters only: give actuator, delay and"
            " sample_rate to the flight"
        )
    chains = Chains(gains.attitude_filters, gains.rate_filters, gains.filters)
    if any(one.batch for chain in chains for one in chain):
        raise InputError(
            "an autopilot with a batch of filters is flown as an array of SaturatedLaw, one each"
        )
    fields = (gains.attitude_gain, gains.rate_gain, gains.alpha_gain, gains.integral_gain)
    rows = zip(*(np.broadcast_to(one, gains.batch).ravel().tolist() for one in fields), strict=True)
    numbers: list[LawNumbers | None] = [
        LawNumbers(attitude=a, attitude_rate=r, angle_of_attack=b, first_state=i)
        for a, r, b, i in rows
    ]
    index = np.arange(len(numbers)).reshape(gains.batch)
    return LawBatch((), numbers, [chains], np.broadcast_to(index, shape).ravel())


def _with_filters(own: LinearSystem, chains: Chains, lengths: FloatArray, size: int) -> Memory:
    """The memory of one law in steps of the lengths [s] ``(m,)``, with rows for `size` states.

    Its own states first, then those of each chain.
    """
    blocks = law_blocks(dict(zip(CHAINS, chains, strict=True)), own, SENSED[:2], lengths)
    law = connect(blocks, (*SENSED, LAW_OUTPUT), (*LAW_INPUTS, RETURNED))
    n, wide = len(law.states), size + MEASURED + 1
    columns = [*range(n), *range(size, wide)]
    rows = np.zeros((lengths.size, size + MEASURED + 1, wide))
    rows[:, :n, columns] = beside(law.A, law.B)
    rows[:, size:, columns] = beside(law.C, law.D)
    return Memory(rows[:, :size], rows[:, size:-1], rows[:, -1])
