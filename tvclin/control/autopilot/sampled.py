"""The loop of a sampled autopilot, exactly: a law in steps, and a vehicle that moves between them.

At t_k = k h the law sees y_k, and its command u_k arrives d h + f later and is held. Actuator,
vehicle and sensor lags move together,

    x[k+1] = F x[k] + G0 u[k-d] + G1 u[k-d-1],    e^([A, B; 0, 0] t) = [.., P(t); 0, 1],
    F = e^(A h),    G0 = P(h - f),    G1 = P(h) - G0,

and commands that have not arrived are states. Filters become differences by the bilinear rule, each
exact at its own frequency; the integral is that of the samples as they are held. The variable w of
z = (1 + w h/2)/(1 - w h/2) makes of L(z) a function of continuous time with the same values, at
nu = (2/h) tan(omega h/2), of which margins are found as of any other (Franklin, Powell and Workman,
Digital Control of Dynamic Systems).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tvclin.base.errors import InputError
from tvclin.control.autopilot.actuated import actuated
from tvclin.control.autopilot.feedback import CHAINS, Feedback
from tvclin.control.autopilot.wiring import sensed_places
from tvclin.control.margins.sampled_loop import SampledLoop
from tvclin.kernels import state_space
from tvclin.kernels.propagation import driven
from tvclin.kernels.state_loop import StateLoop
from tvclin.kernels.state_space import Matrices
from tvclin.linear.flexible import AnyPlant
from tvclin.vehicle.filters import Filter

FloatArray = NDArray[np.float64]

_WHOLE = 1e-9
"""So near to a whole number of periods the delay is one."""
_MOST_PERIODS, _MOST_GROWTH = 25, 50.0
"""The longest delay in periods, and the largest exponent by which a vehicle may grow in one."""


@dataclass(frozen=True, eq=False)
class Steps:
    """What actuator, vehicle and sensor lags do from one sample to the next.

    Attributes
    ----------
    F, G0, G1 : ndarray
        Of x[k+1] = F x[k] + G0 u[k-d] + G1 u[k-d-1]; ``(..., n, n)`` and ``(..., n, 1)``.
    C : ndarray
        Sensed attitude, sensed attitude rate and angle of attack of the states, ``(..., 3, n)``.
    whole : ndarray of int
        d, the whole periods of the delay, ``(...)``.
    period : ndarray
        h [s], ``(...)``.
    states : tuple of str
        Names of the states.
    """

    F: FloatArray
    G0: FloatArray
    G1: FloatArray
    C: FloatArray
    whole: NDArray[np.intp]
    period: FloatArray
    states: tuple[str, ...]


def sampled_loop(autopilot: Feedback, plant: AnyPlant) -> SampledLoop:
    """Return the loop of an autopilot that has a sample rate.

    Parameters
    ----------
    autopilot : Feedback
        With a sample_rate [Hz]. Its delay is that from the sample to the command at the actuator,
        up to 25 periods, whole or not.
    plant : Plant or FlexiblePlant
        One or a batch.

    Raises
    ------
    InputError
        For a filter whose own frequency is not below half the sample rate, a delay above 25
        periods, and a vehicle that grows beyond all bounds in one.
    """
    steps = vehicle_steps(autopilot, plant)
    law = law_steps(autopilot, steps.period)
    # The commands on their way: u[k-1], u[k-2], .., as many as the longest delay asks for.
    late = np.any(steps.G1 != 0.0, axis=(-1, -2))
    count = int((steps.whole + late).max(initial=0))
    waiting = np.eye(1 + count, k=-1)[1:]  # each takes the place of the one before
    places = np.arange(1 + count)
    now = (places == steps.whole[..., np.newaxis]).astype(float)[..., np.newaxis, :]
    before = (places == steps.whole[..., np.newaxis] + 1).astype(float)[..., np.newaxis, :]
    pushed = steps.G0 * now + steps.G1 * before  # of u[k], u[k-1], ..
    n = steps.F.shape[-1]
    motion = state_space.stacked(
        state_space.beside(steps.F, pushed),
        state_space.beside(np.zeros((count, n)), waiting),
    )
    A = np.delete(motion, n, axis=-1)
    B = motion[..., n : n + 1]
    C = state_space.beside(steps.C, np.zeros((3, count)))
    whole = state_space.series((A, B, C, np.zeros((3, 1))), law)
    half = 0.5 * steps.period
    A, B, C, D = state_space.from_steps(whole, half)
    batch = np.broadcast_shapes(A.shape[:-2], steps.period.shape)
    A, B, C, D = (
        np.broadcast_to(m, (*batch, *m.shape[-2:])).reshape(-1, *m.shape[-2:]) for m in (A, B, C, D)
    )
    form = StateLoop.balanced(A, B[..., 0], -C[:, 0], -D[:, 0, 0], np.zeros(len(A)))
    return SampledLoop(form, batch, np.broadcast_to(steps.period, batch))


def vehicle_steps(autopilot: Feedback, plant: AnyPlant) -> Steps:
    """Return actuator, vehicle and sensor lags from sample to sample under a held command."""
    from scipy.linalg import expm  # late: it takes 0.1 s to import

    period = 1.0 / np.asarray(autopilot.sample_rate)
    A, B, C, _, names, _ = actuated(plant, autopilot.actuator)
    n, B = A.shape[-1], B[..., :1]
    growth = np.linalg.eigvals(A).real.max(axis=-1) * period
    if np.any(growth > _MOST_GROWTH):
        raise InputError(
            f"sample_rate = {np.min(1.0 / period):.6g} Hz is too low for a vehicle whose motion"
            f" grows by e^{np.max(growth):.3g} from one sample to the next"
        )
    periods = np.asarray(autopilot.delay) / period
    if np.any(periods > _MOST_PERIODS):
        raise InputError(
            f"delay must be at most {_MOST_PERIODS} sample periods; got {np.max(periods):.6g}"
            " (lower sample_rate, or leave it out: so fast a law is continuous)"
        )
    whole, rest = delay_parts(np.asarray(autopilot.delay), period)
    held = driven(A, B)
    full = expm(held * period[..., np.newaxis, np.newaxis])
    part = expm(held * (period - rest)[..., np.newaxis, np.newaxis])
    batch = np.broadcast_shapes(full.shape[:-2], part.shape[:-2])
    full, part = (np.broadcast_to(m, (*batch, n + 1, n + 1)) for m in (full, part))
    G0 = part[..., :n, n:]
    G1 = np.where(
        np.broadcast_to(rest, batch)[..., np.newaxis, np.newaxis] > 0.0, full[..., :n, n:] - G0, 0.0
    )
    C = np.broadcast_to(C[..., list(sensed_places(plant)), :], (*batch, 3, n))
    whole = np.broadcast_to(whole, batch)
    return Steps(full[..., :n, :n], G0, G1, C, whole, np.broadcast_to(period, batch), names)


def delay_parts(delay: FloatArray, period: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
    """Return the whole periods of a delay, and the rest [s] of it."""
    periods = delay / period
    whole = np.floor(periods + _WHOLE)
    rest = np.where(periods - whole > _WHOLE, periods - whole, 0.0) * period
    return whole.astype(np.intp), rest


def law_steps(autopilot: Feedback, period: FloatArray) -> Matrices:
    """Return A, B, C, D of the law in steps, from attitude, rate and angle of attack."""
    half = 0.5 * period
    attitude, rate, sums = (filter_steps(getattr(autopilot, name), half, name) for name in CHAINS)
    gain, integral = (
        state_space.gain(getattr(autopilot, f"{n}_gain")) for n in ("attitude", "integral")
    )
    if np.any(np.asarray(autopilot.integral_gain)):
        # the integral of what is held, s[k+1] = s[k] + h m[k], as a flight has it
        one, step = np.ones((1, 1)), period[..., np.newaxis, np.newaxis]
        summing = one, step, one, np.zeros((1, 1))
        gain = state_space.parallel(gain, state_space.series(summing, integral))
    rows = (
        state_space.series(attitude, gain),
        state_space.series(rate, state_space.gain(autopilot.rate_gain)),
        state_space.gain(autopilot.alpha_gain),
    )
    return state_space.series(state_space.summed(rows), sums)


def filter_steps(chain: tuple[Filter, ...], half: FloatArray, name: str) -> Matrices:
    """Return a chain of filters in steps of twice `half` [s]; `name` is that for messages.

    Raises
    ------
    InputError
        For a filter whose own frequency is not below half the sample rate.
    """
    found = state_space.gain(1.0)
    for k, one in enumerate(chain, start=1):
        found = state_space.series(found, _differences(f"{name} {k}", one, half))
    return found


def _differences(name: str, one: Filter, half: FloatArray) -> Matrices:
    """A filter by s = c (z - 1)/(z + 1), with c = w/tan(w h/2): exact at its own frequency w.

    That is the geometric mean of its poles; c = 2/h where it has none.
    """
    if not one.order:
        return one.matrices()
    own = np.abs(one.denominator[..., -1]) ** (1.0 / one.order)
    turned = own * half  # half the phase of a step
    if np.any(turned >= 0.5 * np.pi):
        raise InputError(
            f"{name} has its own frequency at {np.max(own):.6g} rad/s, which must lie below half"
            f" the sample rate, {np.pi / np.max(2.0 * half):.6g} rad/s; raise sample_rate"
        )
    own, turned = np.broadcast_arrays(own, turned)
    c = np.where(own > 0.0, own / np.tan(np.where(own > 0.0, turned, 1.0)), 1.0 / half)
    return state_space.to_steps(one.matrices(), c)
