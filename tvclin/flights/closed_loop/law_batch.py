"""Laws of a batch of sampled flights: their numbers and filters for the kernel.

A law between samples is its gains, the states of its filters and of its controller; with the
sensors' outputs y and the demand d, the states of the next sample are x+ = F [x, y, d].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IntArray
from tvclin.base.errors import MAX_AXES, InputError
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import CHAINS
from tvclin.control.autopilot.system_autopilot import SystemAutopilot
from tvclin.control.autopilot.wiring import (
    CONTROLLER,
    LAW_INPUTS,
    LAW_OUTPUT,
    RETURNED,
    attitude_integral,
    law_blocks,
)
from tvclin.control.laws.autopilot_law import SystemLaw, gain_numbers
from tvclin.control.laws.law import Chains, Law
from tvclin.kernels.control_laws import LawNumbers
from tvclin.kernels.flight_arrays import MEASURED
from tvclin.linear.lateral import NO_LATERAL_SENSORS, LateralSensors
from tvclin.linear.system import LinearSystem, connect
from tvclin.numerics.state_space import join_columns

SENSED = ("sensed_attitude", "sensed_attitude_rate", *LAW_INPUTS[2:])
"""Names of the sensor outputs, in the order of `Measurement`."""


class Memory(NamedTuple):
    """Step matrices of the s states of laws with their filters, for each of l flights or for all.

    l is 1 where all flights have the same matrix. Each row acts on the states, the eight sensor
    outputs, and the demand of the law.

    `states`: rows of the next states, ``(l, s, s + 9)``. `inputs`: rows of the law's inputs behind
    the filters, ``(l, 8, s + 9)``; empty without filters. `demand`: row of the filtered demand,
    ``(l, s + 9)``; empty without filters.
    """

    states: FloatArray
    inputs: FloatArray
    demand: FloatArray


@dataclass(frozen=True, eq=False)
class LawBatch:
    """The laws of m flights.

    `laws`: the different laws; empty for a batch of gains. `numbers`: parameters of each for the
    kernel; None for a law that Python evaluates. `chains`: filters of each law; one entry for a
    batch of gains. `which`: index of the law of each flight, ``(m,)``. `sensors`: lateral sensors
    of all laws.
    """

    laws: tuple[Law, ...]
    numbers: Sequence[LawNumbers | None]
    chains: list[Chains]
    which: IntArray
    sensors: LateralSensors = NO_LATERAL_SENSORS

    @property
    def noise(self) -> list[tuple[float, int]]:
        """Noise level [rad/s] and seed of each law."""
        return [law.rate_noise for law in self.laws] or [(0.0, 0)] * len(self.numbers)

    def memory(self, lengths: FloatArray) -> Memory:
        """Return the step matrices of the states of laws with their filters, for each of m flights.

        Rows give the next states, `size` of them as the largest law has, and with filters (or a
        controller in state space) the law's inputs and its command. Columns, `wide`, are these
        states, the sensor outputs (`MEASURED` of them), and the demand of the law. Without states
        and filters they are empty, one for all. `lengths`: step of each flight [s], ``(m,)``.
        """
        # a batch of gains has no `laws`: its single system is the integral of the attitude, if any
        # has a gain on this first state
        integral = any(law is not None and law.first_state for law in self.numbers)
        systems = [law.state_space for law in self.laws] or [attitude_integral(integral)]
        which = self.which if self.laws else np.zeros(lengths.size, np.int64)
        size = max(  # number of states of the largest law with its filters
            len(system.states) + sum(filter_.order for chain in chains for filter_ in chain)
            for system, chains in zip(systems, self.chains, strict=True)
        )
        wide = size + MEASURED + 1
        filtered = any(any(chains) for chains in self.chains) or any(
            CONTROLLER in system.outputs for system in systems
        )
        if not size and not filtered:
            return Memory(
                np.zeros((1, 0, wide)), np.zeros((0, MEASURED, wide)), np.zeros((0, wide))
            )
        states = np.zeros((lengths.size, size, wide))
        inputs = np.zeros((lengths.size if filtered else 0, MEASURED, wide))
        demand = np.zeros((lengths.size if filtered else 0, wide))
        for k, (system, chains) in enumerate(zip(systems, self.chains, strict=True)):
            flights = np.flatnonzero(which == k)
            memory = memory_of(system, chains, lengths[flights], size)
            states[flights] = memory.states
            if filtered:
                inputs[flights], demand[flights] = memory.inputs, memory.demand
        return Memory(states, inputs, demand)


_TYPES = {float: np.float64, bool: np.bool_}


def law_rows(numbers: Sequence[LawNumbers]) -> AnyArray:
    """Return the numbers of laws as a structured array, ``(laws,)``, with fields of `LawNumbers`.

    Compiled kernels take an array in place of a list of tuples.
    """
    kinds = [(name, _TYPES[type(value)]) for name, value in LawNumbers()._asdict().items()]
    return np.array(numbers, dtype=kinds)


def shape_of(law: Any) -> tuple[int, ...]:
    """Return the batch shape of a law, an autopilot with a batch of gains, or an array of laws."""
    if isinstance(law, Law):
        return ()
    return law.batch if isinstance(law, Autopilot) else np.shape(_array(law))


def law_batch(law: Any, shape: tuple[int, ...]) -> LawBatch:
    """Return the laws of a batch of flights of a shape.

    `law`: a law, an array of laws, or an autopilot with a batch of gains, which broadcast to the
    shape. `InputError` for another type, and for an autopilot with an actuator or a delay.
    """
    if isinstance(law, SystemAutopilot):
        law = SystemLaw(law)
    if isinstance(law, Autopilot):
        return _batch_of_gains(law, shape)
    laws = _array(law)
    different = {id(element): element for element in laws.flat}  # one entry for each object
    position = {key: k for k, key in enumerate(different)}
    index = np.array([position[id(element)] for element in laws.flat], dtype=np.int64)
    distinct = tuple(different.values())
    # numbers of each law for the kernel, and its filters; `which` is its index for each flight
    numbers = [element.numbers for element in distinct]
    chains = [element.chains for element in distinct]
    which = np.broadcast_to(index.reshape(laws.shape), shape).ravel()
    sensors = reduce(LateralSensors.joined, (element.lateral_sensors for element in distinct))
    return LawBatch(distinct, numbers=numbers, chains=chains, which=which, sensors=sensors)


def _array(law: Any) -> AnyArray:
    """Return a law, or an array of laws, as an array of laws; `InputError` for another type."""
    laws = np.asarray(law, dtype=object)
    if not laws.size or laws.ndim > MAX_AXES or not all(isinstance(x, Law) for x in laws.flat):
        raise InputError(
            "law must be a Law such as TrimLaw, an array of them, or an Autopilot with a batch of"
            f" gains; got {type(law).__name__}"
        )
    return laws


def _batch_of_gains(gains: Autopilot, shape: tuple[int, ...]) -> LawBatch:
    """Return the laws of an autopilot with a batch of gains, for flights of a batch `shape`.

    `gains`: the autopilot. `InputError` for an actuator, a delay, a sample rate, and a batch of
    filters.
    """
    has_hardware = gains.actuator is not None or np.any(np.asarray(gains.delay))
    if has_hardware or gains.sample_rate is not None:
        raise InputError(
            "an autopilot is flown for its gains and filters only: give actuator, delay and"
            " sample_rate to the flight"
        )
    chains = Chains(gains.attitude_filters, gains.rate_filters, gains.filters)
    if any(filter_.batch for chain in chains for filter_ in chain):
        raise InputError(
            "an autopilot with a batch of filters is flown as an array of SaturatedLaw, one each"
        )
    fields = gain_numbers(gains)
    columns = (np.broadcast_to(gain, gains.batch).ravel().tolist() for gain in fields.values())
    numbers: list[LawNumbers | None] = [
        LawNumbers(**dict(zip(fields, row, strict=True))) for row in zip(*columns, strict=True)
    ]
    index = np.broadcast_to(np.arange(len(numbers)).reshape(gains.batch), shape).ravel()
    sensors = gains.lateral_sensors
    return LawBatch(laws=(), numbers=numbers, chains=[chains], which=index, sensors=sensors)


def memory_of(system: LinearSystem, chains: Chains, lengths: FloatArray, size: int) -> Memory:
    """Return the step matrices of one law and its filters, padded to `size` states.

    `system`: the law in state space. `chains`: filters of attitude, rate and demand. `lengths`:
    lengths of the steps [s], ``(m,)``. Columns are the states x, the `MEASURED` sensor outputs and
    the demand. Rows give `states`, the next ones, of the law and then of each chain; `inputs`, the
    law's `MEASURED` inputs behind the filters, of which a controller's output takes the first
    place; and `demand`, the filtered one.
    """
    attitude_and_rate = SENSED[:2]  # the sensor outputs that have filters
    chain_of = dict(zip(CHAINS, chains, strict=True))
    blocks = law_blocks(chain_of, system, attitude_and_rate, lengths)
    first_input = CONTROLLER if CONTROLLER in system.outputs else LAW_INPUTS[0]
    # from sensor outputs and demand (`LAW_OUTPUT`) to filtered inputs and demand (`RETURNED`)
    law = connect(blocks, (*SENSED, LAW_OUTPUT), (first_input, *LAW_INPUTS[1:], RETURNED))
    n, wide = len(law.states), size + MEASURED + 1
    columns = [*range(n), *range(size, wide)]  # of the states without the padding, and the inputs
    rows = np.zeros((lengths.size, wide, wide))
    rows[:, :n, columns] = join_columns(law.A, law.B)
    rows[:, size:, columns] = join_columns(law.C, law.D)
    return Memory(rows[:, :size], rows[:, size:-1], rows[:, -1])
