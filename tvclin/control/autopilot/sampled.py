"""The loop of a sampled autopilot, exactly: a law in steps, and a vehicle that moves between them.

At t_k = k h the law sees y_k, and its command arrives a delay later and is held: vehicle, actuator
and sensor lags are `LinearSystem.to_steps`. Filters become differences by the bilinear rule, each
exact at its own frequency; the integral is that of the samples as they are held. The variable w of
z = (1 + w h/2)/(1 - w h/2) makes of L(z) a function of continuous time with the same values, at
nu = (2/h) tan(omega h/2), of which margins are found as of any other (Franklin, Powell and Workman,
Digital Control of Dynamic Systems).
"""

from __future__ import annotations

import numpy as np

from tvclin.base.arrays import ComplexArray, FloatArray, IndexArray
from tvclin.base.errors import InputError
from tvclin.control.autopilot.actuated import actuated
from tvclin.control.autopilot.feedback import Feedback
from tvclin.control.autopilot.wiring import COMMAND, RETURNED, law_of
from tvclin.control.margins.sampled_loop import SampledLoop
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.system import LinearSystem, connect
from tvclin.numerics import state_space
from tvclin.numerics.state_loop import StateLoop

_MOST_PERIODS, _MOST_GROWTH = 25, 50.0
"""The longest delay in periods, and the largest exponent by which a vehicle may grow in one."""


def sampled_loop(autopilot: Feedback, plant: AnyPlant) -> SampledLoop:
    """Return the loop of an autopilot that has a sample rate.

    `autopilot`: with a sample_rate [Hz]. Its delay is that from the sample to the command at the
    actuator, up to 25 periods, whole or not. `plant`: one or a batch. `InputError` for a filter
    whose own frequency is not below half the sample rate, a delay above 25 periods, and a vehicle
    that grows beyond all bounds in one.
    """
    period, delay = 1.0 / np.asarray(autopilot.sample_rate), np.asarray(autopilot.delay)
    sensed = (*plant.sensed, "angle_of_attack")
    vehicle = actuated(plant, autopilot.actuator).select((COMMAND,), sensed)
    growth = vehicle.poles.real.max(axis=-1) * period
    if np.any(growth > _MOST_GROWTH):
        raise InputError(
            f"sample_rate = {np.min(1.0 / period):.6g} Hz is too low for a vehicle whose motion"
            f" grows by e^{np.max(growth):.3g} from one sample to the next"
        )
    if np.any(delay / period > _MOST_PERIODS):
        raise InputError(
            f"delay must be at most {_MOST_PERIODS} sample periods; got"
            f" {np.max(delay / period):.6g} (lower sample_rate, or leave it out: so fast a law is"
            " continuous)"
        )
    law = connect(law_of(autopilot, plant, period), sensed, (RETURNED,))
    batch = np.broadcast_shapes(vehicle.batch, law.batch, period.shape, delay.shape)
    h, late = (np.broadcast_to(one, batch) for one in (period, delay))

    def steps_later(delays: FloatArray, cases: IndexArray) -> LinearSystem:
        own, seen = (one.some(cases, batch) for one in (vehicle, law))
        return own.to_steps(h.ravel()[cases], delays).series(seen)

    def later(delays: FloatArray, cases: IndexArray) -> StateLoop:
        return _in_plane(steps_later(delays, cases), h.ravel()[cases])

    def closed_later(delays: FloatArray, cases: IndexArray) -> ComplexArray:
        return steps_later(delays, cases).feedback(RETURNED, COMMAND).poles

    open_loop = _in_plane(vehicle.to_steps(h, late).series(law), h)
    return SampledLoop(open_loop, batch, h, late, later, closed_later)


def _in_plane(steps: LinearSystem, period: FloatArray) -> StateLoop:
    """The loops in w of what goes round in steps of periods ``(...)``."""
    found = state_space.from_steps(steps.matrices(), 0.5 * period)
    A, B, C, D = (
        np.broadcast_to(m, (*period.shape, *m.shape[-2:])).reshape(period.size, *m.shape[-2:])
        for m in found
    )
    return StateLoop.balanced(A, B[..., 0], 0.0 - C[:, 0], 0.0 - D[:, 0, 0], np.zeros(len(A)))
