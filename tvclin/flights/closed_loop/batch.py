"""What is flown at a sample rate: vehicles with their hardware, laws and winds, many at once."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray, IntArray
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.law_batch import LawBatch, law_batch
from tvclin.linear.flexible import AnyPlant
from tvclin.winds.histories import History


@dataclass(frozen=True, eq=False)
class Hardware:
    """What stands between a law and the deflection.

    `length`, `delay`: of a sample and of computing [s]. `actuator`: one or a batch, which
    broadcasts with them. `rate_limit`: of the deflection [rad/s], of the shape of the flights.
    """

    length: float | FloatArray
    delay: float | FloatArray
    actuator: Actuator | None = None
    rate_limit: float | FloatArray = np.inf

    @property
    def batch(self) -> tuple[int, ...]:
        """The shape of all but the rate limit."""
        own = () if self.actuator is None else self.actuator.batch
        return np.broadcast_shapes(own, np.shape(self.length), np.shape(self.delay))

    def some(
        self, which: IntArray, shape: tuple[int, ...], flights: IntArray, flown: tuple[int, ...]
    ) -> Hardware:
        """Return that of vehicles of a batch of a shape, and of flights of theirs."""
        actuator = self.actuator
        if actuator is not None:
            damping = None if actuator.damping is None else some(actuator.damping, shape, which)
            frequency = some(actuator.natural_frequency, shape, which)
            actuator = Actuator(natural_frequency=frequency, damping=damping)
        length, delay = (some(a, shape, which) for a in (self.length, self.delay))
        return Hardware(length, delay, actuator, some(self.rate_limit, flown, flights))


@dataclass(frozen=True, eq=False)
class Batch:
    """What is flown: all of one shape, which is flattened, but for plants, hardware and winds.

    `plant`, `hardware`, `wind`: one each or a batch, which broadcast with the shape; or as
    `vehicle` and `met` say. `laws`: of the flights. `limit`: of the deflection [rad], of the shape
    of the batch. `shape`: of the batch. `gain`: factor on what each asks for, of the same shape.
    `until`: when flights end [s]; infinite for when they are decided. `vehicle`, `met`: the vehicle
    (plant with hardware) and the wind of each flight, by their places in their own batches,
    ``(m,)``.
    """

    plant: AnyPlant
    hardware: Hardware
    wind: History
    laws: LawBatch
    limit: float | FloatArray
    shape: tuple[int, ...]
    gain: float | FloatArray = 1.0
    until: float = np.inf
    vehicle: IntArray | None = None
    met: IntArray | None = None

    @property
    def vehicles(self) -> tuple[int, ...]:
        """The shape of the batch of vehicles."""
        return np.broadcast_shapes(self.plant.batch, self.hardware.batch)

    @property
    def places(self) -> tuple[IntArray, IntArray]:
        """The vehicle and the wind of each flight, ``(m,)``."""
        vehicle, met = self.vehicle, self.met
        if vehicle is None or met is None:
            vehicle, met = (places_in(a, self.shape) for a in (self.vehicles, self.wind.batch))
        return vehicle, met

    def delayed(self, delay: float | FloatArray) -> Batch:
        """Return the same with another delay of computing [s]."""
        return replace(self, hardware=replace(self.hardware, delay=delay))

    def only(self, good: BoolArray) -> Batch:
        """Return those flights of the batch, each vehicle and wind that they need once."""
        own, where = self.vehicles, np.flatnonzero(good)
        (fleet, vehicle), (winds, met) = (
            np.unique(a[where], return_inverse=True) for a in self.places
        )
        return replace(
            self,
            plant=self.plant.cases(fleet, own),
            hardware=self.hardware.some(fleet, own, where, self.shape),
            wind=self.wind.cases(winds, self.wind.batch),
            laws=replace(self.laws, which=self.laws.which[where]),
            limit=some(self.limit, self.shape, where),
            shape=where.shape,
            gain=some(self.gain, self.shape, where),
            vehicle=vehicle,
            met=met,
        )


def one_flight(
    plant: AnyPlant,
    law: Law,
    wind: History,
    limit: float,
    hardware: Hardware,
    gain: float = 1.0,
    until: float = np.inf,
) -> Batch:
    """Return the batch of a single flight; the arguments are those of `Batch`."""
    return Batch(plant, hardware, wind, law_batch(law, ()), limit, (), gain, until)


def some(array: float | FloatArray, shape: tuple[int, ...], which: IntArray) -> FloatArray:
    """Return those elements of an array that broadcasts to a shape, flat."""
    return np.asarray(np.broadcast_to(array, shape).ravel()[which])


def places_in(own: tuple[int, ...], shape: tuple[int, ...]) -> IntArray:
    """Return the position of each element of a batch in a smaller one that broadcasts to it."""
    index = np.arange(int(np.prod(own)), dtype=np.int64).reshape(own)
    return np.broadcast_to(index, shape).flatten()
