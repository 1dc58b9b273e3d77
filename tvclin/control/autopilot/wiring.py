"""The loop of an autopilot around a plant: state space, polynomials, and difference equations.

All three forms wire the blocks of `LOOP_DIAGRAM`; tests compare them with each other. The sampled
loop is exact: at t_k = k h the law reads the outputs y_k, and its command reaches the actuator one
delay later and is held (zero-order hold); vehicle, actuator and sensor lags become
`LinearSystem.to_steps`. Filters become difference equations by the bilinear rule, each exact at its
own frequency; the integral is that of the held samples. With z = (1 + w h/2)/(1 - w h/2) the
sampled L(z) is a rational function of w, with the same values at w = j nu, nu = (2/h) tan(omega
h/2), so that its margins are computed like those of a continuous loop (Franklin, Powell and
Workman, Digital Control of Dynamic Systems).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from inspect import cleandoc
from textwrap import indent
from typing import Any, TypeVar

import numpy as np

from tvclin.base.arrays import ComplexArray, FloatArray, IndexArray
from tvclin.base.errors import InputError
from tvclin.control.autopilot.actuator import Matrices, actuated, pade_delay
from tvclin.control.autopilot.feedback import CHAINS, Feedback
from tvclin.control.margins.loop import Loop, SampledLoop
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.plant import Plant
from tvclin.linear.system import LinearSystem, connect, gain
from tvclin.numerics import polynomials, state_space
from tvclin.numerics.loops import StateLoop
from tvclin.vehicle.filters import Filter

_Documented = TypeVar("_Documented", bound=Callable[..., Any])

LOOP_DIAGRAM = """\
attitude_command                          deflection_disturbance               wind
       | -                                                    |                  |
       v     +-----------+                                    |                  v
 +-->( + )-->| a0 + aI/s |--+                                 |              +-------+
 |           +-----------+  v     +-------+   +----------+    v              |       |
 |  +------->|    a1     |>(+)-x->| delay |-->| actuator |-->(+)-deflection->| plant |
 |  |        +-----------+  ^     +-------+   +----------+                   |       |
 |  |  +---->|    b0     |--+                                                +-------+
 |  |  |     +-----------+                                                     | | |
 |  |  +---------------------------- angle_of_attack --------------------------+ | |
 |  +------------------------------- attitude_rate ------------------------------+ |
 +---------------------------------- attitude -------------------------------------+

 x  deflection_command: loop() is broken here, and L is minus what returns"""


def with_diagram(documented: _Documented) -> _Documented:
    """Put the loop diagram where the docstring says LOOP_DIAGRAM."""
    text = cleandoc(documented.__doc__ or "")
    documented.__doc__ = text.replace("LOOP_DIAGRAM", "::\n\n" + indent(LOOP_DIAGRAM, "    "))
    return documented


COMMAND, RETURNED = "deflection_command", "returned_command"
DISTURBANCES = ("wind", "attitude_command", "deflection_disturbance")
_LATE = "late_command"
SEEN = ("attitude_error", "seen_rate", "flight_path_angle", "angle_of_attack", "deflection")
"""What a law sees behind its filters."""
ASKED, INTEGRAL = "asked", "attitude_error_integral"


def open_loop(autopilot: Feedback, plant: AnyPlant, *, pade: bool = False) -> LinearSystem:
    """Return the broken loop of one or of a batch, from the command to what returns.

    Its inputs are `DISTURBANCES` and the command, its outputs those of the plant, the deflection
    and the returned command. The states are those of the plant, of the actuator, of the delay as
    its Pade approximation if that is asked for, of the integrator and of the filters.
    """
    vehicle = actuated(plant, autopilot.actuator)
    late = pade_delay(float(autopilot.delay) if pade else 0.0, autopilot.pade_order)
    waiting = tuple(f"delay_{k}" for k in range(1, len(late[0]) + 1))
    blocks = [
        vehicle.renamed({COMMAND: _LATE}),
        LinearSystem(*late, (COMMAND,), (_LATE,), waiting),
        *law_of(autopilot, plant),
    ]
    return connect(blocks, (*DISTURBANCES, COMMAND), (*vehicle.outputs, RETURNED))


def closed_loop(autopilot: Feedback, plant: AnyPlant) -> LinearSystem:
    """Return the closed loop from the disturbances to the outputs of the plant and the deflection.

    Its delay is a Pade approximation.
    """
    loop = open_loop(autopilot, plant, pade=True).feedback(RETURNED, COMMAND)
    return loop.select(DISTURBANCES, (*plant.outputs, "deflection"))


def exact_loop(autopilot: Feedback, plant: AnyPlant) -> Loop:
    """Return the loop with its exact delay: of a `Plant` as polynomials, else in state space."""
    if isinstance(plant, Plant):
        return rational_loop(autopilot, plant)
    loop = open_loop(autopilot, plant).select((COMMAND,), (RETURNED,))
    return Loop.from_matrices(loop.A, loop.B, 0.0 - loop.C, delay=autopilot.delay)


def law_of(
    autopilot: Feedback, plant: AnyPlant, period: FloatArray | None = None
) -> list[LinearSystem]:
    """Return the blocks from what sensors give, less the attitude command, to the command.

    With a period [s] they are in steps.
    """
    chains = {name: getattr(autopilot, name) for name in CHAINS}
    integral = bool(np.any(np.asarray(autopilot.integral_gain)))
    gains = {
        SEEN[0]: autopilot.attitude_gain,
        SEEN[1]: autopilot.rate_gain,
        SEEN[3]: autopilot.alpha_gain,
    }
    if integral:
        gains[INTEGRAL] = autopilot.integral_gain
    own = integral_of_attitude(integral)
    asked = [gain(SEEN[0], {"attitude_command": -1.0}), gain(ASKED, gains)]
    return [*law_blocks(chains, own, plant.sensed, period), *asked]


def integral_of_attitude(there: bool) -> LinearSystem:
    """Return the integral of the attitude error from `SEEN`, or nothing."""
    n, name = int(there), (INTEGRAL,) if there else ()
    return LinearSystem(
        np.zeros((n, n)), np.eye(n, 5), np.eye(n), np.zeros((n, 5)), SEEN, name, name
    )


def law_blocks(
    chains: Mapping[str, Sequence[Filter]],
    own: LinearSystem,
    sensed: tuple[str, str],
    period: FloatArray | None = None,
) -> list[LinearSystem]:
    """Return the states of a law and its filters: from what is sensed to `SEEN`, and from `ASKED`.

    `chains`: the filters of each of `CHAINS`. `own`: of the law's own states, from `SEEN`.
    `sensed`: names of attitude and attitude rate ahead of the filters. `period`: with one [s] all
    are in steps: the filters by the bilinear rule, each exact at its own frequency, the states with
    what is seen held from sample to sample.
    """
    ends = ((sensed[0], SEEN[0]), (sensed[1], SEEN[1]), (ASKED, RETURNED))
    blocks = [own if period is None else own.to_steps(period)] if own.states else []
    for name, (source, target) in zip(CHAINS, ends, strict=True):
        chain = chains[name]
        if not chain and source != target:
            blocks.append(gain(target, {source: 1.0}))
        passed = [source, *(f"{name} {k}" for k in range(1, len(chain))), target]
        for k, one in enumerate(chain, start=1):
            states = (f"{name.removesuffix('s')}_{k}_{j}" for j in range(1, one.order + 1))
            found = one.matrices() if period is None else in_steps(one, period, f"{name} {k}")
            blocks.append(
                LinearSystem(*found, (passed[k - 1],), (passed[k],), tuple(states), period)
            )
    return blocks


def in_steps(one: Filter, period: FloatArray, name: str) -> Matrices:
    """Return a filter in steps by s = c (z - 1)/(z + 1), c = w/tan(w h/2): exact at its own w.

    That is the geometric mean of its poles; c = 2/h where it has none. `name` is for messages.

    `InputError` for a filter whose own frequency is not below half the sample rate.
    """
    if not one.order:
        return one.matrices()
    half = 0.5 * period
    own = np.abs(one.denominator[..., -1]) ** (1.0 / one.order)
    turned = own * half  # half the phase of a step
    if np.any(turned >= 0.5 * np.pi):
        raise InputError(
            f"{name} has its own frequency at {np.max(own):.6g} rad/s, which must lie below half"
            f" the sample rate, {np.pi / np.max(period):.6g} rad/s; raise sample_rate"
        )
    own, turned = np.broadcast_arrays(own, turned)
    c = np.where(own > 0.0, own / np.tan(np.where(own > 0.0, turned, 1.0)), 1.0 / half)
    return state_space.to_steps(one.matrices(), c)


def rational_loop(autopilot: Feedback, plant: Plant) -> Loop:
    """Return the loop as polynomials and an exact delay."""
    asked, integrators = _feedback(autopilot, plant, "deflection")
    above, below = _engine(autopilot)
    denominator = polynomials.times_variable(plant.denominator, integrators)
    for name in CHAINS:
        if getattr(autopilot, name):
            denominator = polynomials.multiply(denominator, _chain(autopilot, name)[1])
    return Loop(
        polynomials.multiply(-asked, above),
        polynomials.multiply(denominator, below),
        autopilot.delay,
    )


def wind_numerator(autopilot: Feedback, plant: Plant) -> FloatArray:
    """Return the numerator ``(..., n)`` from wind to deflection with the loop left open.

    It stands over the denominator of `rational_loop`, and has the same delay.
    """
    return polynomials.multiply(_feedback(autopilot, plant, "wind")[0], _engine(autopilot)[0])


def _feedback(autopilot: Feedback, plant: Plant, source: str) -> tuple[FloatArray, int]:
    """The numerator from a source to the command, and how many integrators there are.

    It stands over the denominator of the plant times s, if there is an integrator, and times those
    of all filters.
    """
    integrators = int(np.any(np.asarray(autopilot.integral_gain)))
    gains = [autopilot.rate_gain, autopilot.attitude_gain, autopilot.integral_gain]
    on_angle = np.asarray(autopilot.alpha_gain)[..., np.newaxis] * np.eye(1, 1 + integrators)[0]
    angle = polynomials.multiply(on_angle, plant.numerator("angle_of_attack", source))
    on_attitude = np.stack(np.broadcast_arrays(*gains[: 2 + integrators]), axis=-1)
    if autopilot.attitude_filters or autopilot.rate_filters:
        # (a1 s F_r + (a0 + aI/s) F_a) theta + b0 alpha over the denominators of both filters
        (above_a, below_a), (above_r, below_r) = (_chain(autopilot, name) for name in CHAINS[:2])
        rate = polynomials.multiply(on_attitude[..., :1], np.eye(1, 2 + integrators)[0])
        rate = polynomials.multiply(polynomials.multiply(rate, above_r), below_a)
        rest = polynomials.multiply(polynomials.multiply(on_attitude[..., 1:], above_a), below_r)
        on_attitude = polynomials.add(rate, rest)
        angle = polynomials.multiply(angle, polynomials.multiply(below_a, below_r))
    attitude = polynomials.multiply(on_attitude, plant.numerator("attitude", source))
    asked = polynomials.add(attitude, angle)
    if autopilot.filters:
        asked = polynomials.multiply(asked, _chain(autopilot, "filters")[0])
    return asked, integrators


def _chain(autopilot: Feedback, name: str) -> tuple[FloatArray, FloatArray]:
    """Numerator and denominator of a chain of filters."""
    above, below = np.ones(1), np.ones(1)
    for one in getattr(autopilot, name):
        above = polynomials.multiply(above, one.numerator)
        below = polynomials.multiply(below, one.denominator)
    return above, below


def _engine(autopilot: Feedback) -> tuple[FloatArray, FloatArray]:
    if autopilot.actuator is None:
        return np.ones(1), np.ones(1)
    below = autopilot.actuator.denominator
    return below[..., -1:], below


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
