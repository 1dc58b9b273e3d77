"""Two planes flown in step: each by the kernel of one plane, with one stop between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tvclin.base.arrays import FloatArray, IntArray
from tvclin.boundary.stops import Stop, Vectors
from tvclin.control.laws.both_planes import LawInPlanes
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.batch import Batch, Hardware
from tvclin.flights.closed_loop.batch_arrays import flights
from tvclin.flights.closed_loop.law_batch import law_batch
from tvclin.flights.closed_loop.many import LOST, STATUS, SURVIVED, UNDECIDED
from tvclin.flights.closed_loop.sampled import Stepper
from tvclin.kernels.flight_arrays import Flights
from tvclin.kernels.flights import LOOK
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind

_LONGEST = 20_000
"""Samples after its wind in which a flight may be decided; then it stays undecided."""
_INSIDE = 0.999
"""Of what can be returned from: a flight that is saved is inside with both planes together."""


def ready(
    plant: Plant,
    law: Law,
    wind: PlaneWind,
    part: History,
    limit: FloatArray,
    hardware: Hardware,
) -> Flights:
    """The flights of one plane at rest, which begin with the whole wind and end with it."""
    laws, length = law_batch(law, limit.shape), float(hardware.length)
    batch = Batch(plant, hardware, part, laws, limit, limit.shape)
    with np.errstate(invalid="ignore"):  # a plane without wind
        f = flights(batch)
    onset = float(wind.onset)
    ends = int(np.ceil((float(wind.end) - onset) / length - 1e-9))
    f.cases.start[:], f.cases.ends[:] = onset, ends
    f.cases.finish[:] = ends + np.minimum(f.cases.waiting, _LONGEST)
    f.now.piece[:] = (f.winds.knots[f.cases.wind] <= onset).sum(axis=1) - 1
    return f


@dataclass(frozen=True, eq=False)
class Course:
    """What was kept of flights on their way."""

    attitude: FloatArray
    deflection: FloatArray
    saturated: FloatArray
    ended: IntArray
    outcome: IntArray
    shown: list[tuple[complex, complex]]


def flown_in_step(pair: list[Flights], law: LawInPlanes, limit: FloatArray) -> Course:
    """Fly both planes in step until all is decided."""
    m, own, stop = limit.size, len(law.law.states[0]), law.shape
    course = Course(np.zeros(m), np.zeros(m), np.zeros(m), np.full(m, -1), np.zeros(m, int), [])
    steppers, plain = [Stepper(f) for f in pair], np.ones(m)
    last = int(max(f.cases.finish.max(initial=-1) for f in pair))
    for f in pair:
        f.cases.finish[:] = last
    for k in range(last + 1):
        going = np.flatnonzero(course.ended < 0)
        with np.errstate(all="ignore"):  # a lost flight may leave all numbers
            for stepper in steppers:
                stepper.look(k)
        x = _both(pair, lambda f: f.now.y[:, 0])[going]
        s = _both(pair, lambda f: f.now.y[:, f.vehicles.A.shape[1]])[going]
        course.attitude[going] = np.maximum(course.attitude[going], np.abs(x))
        course.deflection[going] = np.maximum(course.deflection[going], stop.gauge(s))
        if m == 1:
            course.shown.append((complex(x[0]), complex(s[0])))
        if k % LOOK == 0 or k == last:
            _decide(pair, stop, limit, course, k, k == last)
            going = np.flatnonzero(course.ended < 0)
            if not going.size:
                break
        measured = _both(pair, lambda f: f.now.measured)[going]
        states = _both(pair, lambda f: f.now.states)[going, :own]
        demand, command = law.demand(measured, states, limit[going]), np.zeros(m, complex)
        command[going], at_stop = law.limited(demand, limit[going])
        course.saturated[going] += at_stop
        for stepper, part in zip(steppers, (command.real, command.imag), strict=True):
            stepper.advance(k, np.ascontiguousarray(part), plain, plain)
    return course


def _both(pair: list[Flights], part: Callable[[Flights], FloatArray]) -> Vectors:
    """The vectors of both planes."""
    pitch, yaw = (part(f) for f in pair)
    return np.asarray(pitch + 1j * yaw)


def _decide(
    pair: list[Flights], stop: Stop, limit: FloatArray, course: Course, k: int, last: bool
) -> None:
    """End flights of which one plane is lost, or both are saved."""
    pitch, yaw = (f.now.outcome for f in pair)
    lost = (pitch == STATUS.index(LOST)) | (yaw == STATUS.index(LOST))
    saved = (pitch == STATUS.index(SURVIVED)) & (yaw == STATUS.index(SURVIVED))
    if np.any(saved):
        z = [f.now.y @ f.vehicles.judges[0, 0] / f.vehicles.reach[0] for f in pair]
        with np.errstate(all="ignore"):
            near = stop.gauge(np.where(saved, z[0] + 1j * z[1], 0.0))
        saved &= near < _INSIDE * limit
    done = (lost | saved | last) & (course.ended < 0)
    course.outcome[done] = np.where(
        lost[done],
        STATUS.index(LOST),
        np.where(saved[done], STATUS.index(SURVIVED), STATUS.index(UNDECIDED)),
    )
    course.ended[done] = k
    for f in pair:
        f.now.ended[done] = k
