"""The autopilot: attitude and rate feedback, with filters, actuator and delay, around one plant.

    delta = a0 (theta - command) + a1 theta' + b0 alpha + aI * integral of (theta - command)
            + d1 z' + d0 z + g n,

z' = V gamma being the lateral drift rate and n a measured lateral acceleration. Positive deflection
pitches the nose down, so positive gains are negative feedback. `loop` and `close` wire the same
blocks and give python-control's own systems with named signals.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import ComplexArray, FloatArray
from tvclin.base.errors import InputError, broadcast, instance, times_row
from tvclin.control.autopilot import wiring
from tvclin.control.autopilot.feedback import Feedback
from tvclin.control.autopilot.wind_response import WindResponse, peaks_in_winds, wind_response_of
from tvclin.control.margins.bands import BandMargins, band_margins
from tvclin.control.margins.loop import Loop
from tvclin.control.margins.margins import Margins, loop_margins
from tvclin.linear.flexible import AnyPlant, FlexiblePlant, check_plant, named_modes
from tvclin.linear.modes import unstable_poles
from tvclin.linear.plant import Plant
from tvclin.linear.response import time_response
from tvclin.linear.system import LinearSystem
from tvclin.linear.system_plant import SystemPlant
from tvclin.numerics.loop_margins import stability
from tvclin.numerics.state_space import pade_keeps_stability
from tvclin.winds.histories import History

if TYPE_CHECKING:
    import control


def warn_of_feedback(autopilot: Feedback, plant: AnyPlant, stacklevel: int = 3) -> None:
    """Warn of zero gains, positive feedback, and an actuator slower than the unstable pole.

    `autopilot`, `plant`: the two parts of the loop, one each or batches. `stacklevel`: as in
    `warnings.warn`; 3 points at the caller of the calling method. There is no warning for a
    controller in state space, or a plant without known coefficients.
    """
    plant = plant.rigid
    if not plant.coefficients_known or autopilot.controller is not None:
        return
    mu_delta = np.asarray(plant.coefficients.mu_delta)
    stiffness = np.asarray(autopilot.attitude_gain) + autopilot.alpha_gain
    name = "attitude_gain + alpha_gain" if np.any(autopilot.alpha_gain) else "attitude_gain"
    # A stable vehicle has an aerodynamic stiffness. Feedback of the angle of attack may reduce it;
    # feedback of the attitude alone is not meant to.
    aerodynamic = np.maximum(-np.asarray(plant.coefficients.mu_alpha), 0.0)
    attitude_only = (stiffness != 0.0) & (np.asarray(autopilot.alpha_gain) == 0.0)
    # Name of a gain, the gain, the vehicle's own stiffness or damping, and what both do.
    gains: list[tuple[str, Any, Any, str]] = [
        (name, stiffness, np.where(attitude_only, 0.0, aerodynamic), "holds"),
        ("rate_gain", np.asarray(autopilot.rate_gain), plant.coefficients.damping, "damps"),
    ]
    others = ("integral_gain", "drift_rate_gain", "drift_gain")
    gains += [(gain, np.asarray(getattr(autopilot, gain)), 0.0, "") for gain in others]
    for name, values, of_vehicle, verb in gains:
        gain, slope, bare = np.broadcast_arrays(values, mu_delta, of_vehicle)
        worst = np.unravel_index(np.argmin(gain * slope + bare), gain.shape)  # of the batch
        if gain[worst] * slope[worst] + bare[worst] < 0.0:
            warnings.warn(
                f"{name} = {gain[worst]:.6g} is positive feedback on a plant with"
                f" mu_delta = {slope[worst]:.6g} 1/s^2; give it the sign of mu_delta",
                stacklevel=stacklevel,
            )
        elif verb and gain[worst] == bare[worst] == 0.0:
            warnings.warn(f"{name} is zero: nothing {verb} the attitude", stacklevel=stacklevel)
    if autopilot.actuator is None:
        return
    poles = np.real(unstable_poles(plant))
    fastest = np.nan_to_num(poles).max(axis=-1, initial=0.0)
    slow = np.asarray(autopilot.actuator.natural_frequency) < fastest
    if np.any(slow):
        frequency = np.min(autopilot.actuator.natural_frequency)
        warnings.warn(
            f"the actuator, natural_frequency = {frequency:.6g} rad/s, is slower than the"
            f" fastest unstable pole of the plant, {np.max(fastest):.6g} 1/s",
            stacklevel=stacklevel,
        )


def warn_of_sampling(autopilot: Feedback, plant: AnyPlant) -> None:
    """Warn, at the caller's caller, of modes of a plant above half the sample rate.

    `autopilot`: nothing is done without a sample rate [Hz]. `plant`: one or a batch; its modes have
    poles [1/s] with positive imaginary parts.
    """
    if autopilot.sample_rate is None or not plant.has_modes:
        return
    names, poles = named_modes(plant)
    if not names:
        return
    rate = np.asarray(autopilot.sample_rate)[..., np.newaxis]
    frequency = np.imag(poles) / (2.0 * np.pi)  # [Hz], of each mode
    aliased = np.any(np.atleast_2d(rate < 2.0 * frequency).reshape(-1, len(names)), axis=0)
    if np.any(aliased):
        modes = ", ".join(
            name for name, is_aliased in zip(names, aliased, strict=True) if is_aliased
        )
        warnings.warn(
            f"sample_rate = {np.min(rate):.6g} Hz is below twice the frequency of {modes}, which"
            " sampling aliases to another frequency (see band_margins)",
            stacklevel=3,
        )


def pade_misleads(autopilot: Feedback, plant: AnyPlant, loop: LinearSystem) -> bool:
    """Return whether the Pade approximation of a delay gives a wrong number of unstable poles.

    `autopilot`: its delay is approximated. `plant`: one plant, or a batch with one delay, for which
    True means that any loop is wrong. `loop`: the closed loop of both with Pade approximation,
    which has a command as an input and the returned command as an output. The poles with the exact
    delay are counted only where no bound proves that the approximation is good enough.
    """
    if not (delay := float(autopilot.delay)):
        return False
    returned = loop.select((wiring.COMMAND,), (wiring.RETURNED,))
    A, B, C = loop.A, returned.B[..., 0], returned.C[..., 0, :]
    if np.all(pade_keeps_stability(A, B, C, delay, autopilot.pade_order)):
        return False
    exact = stability(wiring.exact_loop(autopilot, plant).form)
    unstable = np.sum(np.real(loop.poles) > 0.0, axis=-1)
    return bool(np.any(~exact.marginal & (unstable != exact.unstable_poles)))


def require_pade(autopilot: Feedback, plants: AnyPlant) -> None:
    """Raise `InputError` where a Pade approximation adds or hides an unstable pole of a loop.

    `autopilot`: one autopilot around one plant, or around each of a batch.
    """
    if pade_misleads(autopilot, plants, wiring.closed_loop(autopilot, plants, command=True)):
        raise InputError(PADE_WARNING.format(autopilot.pade_order))


PADE_WARNING = (
    "pade_order = {} is too low for this delay: with the exact delay the loop has another number"
    " of unstable poles"
)


@dataclass(frozen=True, kw_only=True)
class Autopilot(Feedback):
    """Feedback of attitude and its rate and integral, angle of attack, drift and acceleration.

    Gains, delay and actuator may be arrays, which broadcast with each other and with a batch of
    plants: gains over the flight, or a thousand dispersed loops. `loop` and `close` take one loop.

    ::

        attitude_command                          deflection_disturbance               wind
               | -                                                    |                  |
               v     +-----------+                                    |                  v
         +-->( + )-->| a0 + aI/s |--+                                 |              +-------+
         |           +-----------+  v     +-------+   +----------+    v              |       |
         |  +------->|    a1     |>(+)-x->| delay |-->| actuator |-->(+)-deflection->| plant |
         |  |        +-----------+  ^     +-------+   +----------+                   |       |
         |  |  +---->|    b0     |--+                                                +-------+
         |  |  |     +-----------+  ^                                                  | | | |
         |  |  |  +->| d1, d0, g |--+                                                  | | | |
         |  |  |  |  +-----------+                                                     | | | |
         |  |  |  +------------------------- drift and acceleration -------------------+ | | |
         |  |  +---------------------------- angle_of_attack ----------------------------+ | |
         |  +------------------------------- attitude_rate --------------------------------+ |
         +---------------------------------- attitude ---------------------------------------+

         x  deflection_command: loop() is broken here, and L is minus what returns

    Parameters
    ----------
    attitude_gain : array_like
        a0 [rad/rad]; positive is negative feedback, where mu_delta is positive.
    rate_gain : array_like
        a1 [s].
    alpha_gain : array_like
        b0 [rad/rad], on the angle of attack, which includes the wind.
    integral_gain : array_like
        aI [1/s], on the integral of attitude minus command; in a batch zero for all or for none.
    drift_rate_gain : array_like
        d1 [rad s/m], on the velocity normal to the nominal path, V gamma.
    drift_gain : array_like
        d0 [rad/m], on its integral, the lateral drift; in a batch zero for all or for none, and not
        with an integral_gain.
    acceleration_gain : array_like
        g [rad s^2/m], on the acceleration normal to the body that an accelerometer measures,
        (N alpha + T_c delta)/m + x theta'', without gravity.
    acceleration_station : float
        Position x of the accelerometer ahead of the centre of gravity [m].
    accelerometer_bandwidth : float
        Bandwidth of the accelerometer [rad/s], a first-order lag.
    actuator : Actuator, optional
        Without it the deflection equals its command.
    delay : array_like
        Delay [s] between the sum of the feedbacks and the actuator.
    pade_order : int
        Order of the Pade approximation of the delay in `loop`, `close` and `wind_response`, 1 to
        10. `frequency_response` and `margins` have the exact delay.
    filters : tuple of Filter
        Filters in series behind the sum of all feedbacks.
    attitude_filters, rate_filters : tuple of Filter
        Filters of the sensed attitude, before its command is subtracted, and of the sensed rate.
    sample_rate : array_like, optional
        Samples per second [Hz]. With it, gains and filters are difference equations, and `delay` is
        the time from a sample until its command arrives at the actuator, up to 25 periods, a whole
        number of them or not. `exact_loop`, `margins`, `frequency_response` and `loop` are exact;
        `close` and wind responses take continuous autopilots only.

    Raises
    ------
    InputError
        For gains that are all zero or of magnitude beyond 1e-30 to 1e9, a delay below zero or
        beyond 1e-9 to 1e9 s, filters of another type, a sample rate beyond 1e-9 to 1e9 Hz, and
        shapes that do not broadcast.

    Examples
    --------
    >>> import tvclin as tv
    >>> c = tv.Coefficients(mu_alpha=0.228, mu_delta=1.317)
    >>> plant = tv.Plant.from_coefficients(c)
    >>> tv.Autopilot(attitude_gain=1.88, rate_gain=1.59).close(plant).poles().round(3)
    array([-1.047+1.073j, -1.047-1.073j])
    """

    def loop(self, plant: AnyPlant) -> control.StateSpace:
        """Return the loop L of `Autopilot`, broken at the deflection command.

        Parameters
        ----------
        plant : Plant or FlexiblePlant
            One plant of any model.

        Returns
        -------
        control.StateSpace
            From deflection_command to returned_command [rad]. The sign is such that the closed loop
            is 1 + L = 0: on a fixed path, eq (5) of Borsody and Teren, L = (a0 + a1 s)
            mu_delta/(s^2 - mu_alpha), with the moments mu_alpha per angle of attack and mu_delta
            per deflection, over the inertia. With a sample rate it is the loop in steps of a
            sample, in which the delay is exact.

        Raises
        ------
        InputError
            For a batch.

        Warns
        -----
        UserWarning
            If a gain that should stiffen or damp is zero or positive feedback on this plant, and
            if the actuator is slower than the fastest unstable pole.
        """
        self._require_single("loop", plant, sampled=True)
        warn_of_feedback(self, plant)
        if self.sample_rate is None:
            loop = wiring.open_loop(self, plant, pade=True).select(
                (wiring.COMMAND,), (wiring.RETURNED,)
            )
        else:
            loop = wiring.loop_in_steps(self, plant)
        # L is minus the returned command
        return replace(loop, C=0.0 - loop.C, D=0.0 - loop.D).to_control(f"{plant.model} loop")

    def close(self, plant: AnyPlant) -> control.StateSpace:
        """Return the plant with this autopilot around it, the closed loop of `Autopilot`.

        Same parameters, exceptions and warnings as `loop`; none for an unstable closed loop, see
        its poles.

        Returns
        -------
        control.StateSpace
            Inputs wind, attitude_command and deflection_disturbance [rad]; outputs of the plant
            [rad, rad/s], and the deflection [rad] that acts on it, disturbance included.
        """
        return self._closed("close", plant).to_control(f"{plant.model} with autopilot")

    def closed_loop_poles(self, plant: AnyPlant) -> ComplexArray:
        """Return the poles [1/s] of `close`, ``(n,)``, without python-control.

        `plant`: one plant of any model. `InputError` for a batch, and the warnings of `close`.
        """
        return self._closed("closed_loop_poles", plant).poles

    def rational_loop(self, plant: Plant) -> Loop:
        """Return the loop L as polynomials and an exact delay, for one plant or a batch.

        `plant`: rigid, one or a batch of any model, which broadcasts with the gains. `InputError`
        for a flexible plant and an autopilot with a sample rate, which `exact_loop` takes.
        """
        instance("plant", plant, Plant, "of a FlexiblePlant see exact_loop")
        self._require_continuous("rational_loop")
        if self.controller is not None or not plant.is_rigid:
            raise InputError(
                "rational_loop() is for gains around a rigid plant; of a state space see exact_loop"
            )
        broadcast(autopilot=self.batch, plant=plant.batch)
        return wiring.rational_loop(self, plant)

    def exact_loop(self, plant: AnyPlant) -> Loop:
        """Return the loop L with its exact delay and sampling, for one plant or a batch.

        It has polynomials around a `Plant`, and matrices around a `FlexiblePlant`; with a sample
        rate it is the loop in steps, at frequencies up to half the sample rate. `plant`: one or a
        batch of any model, which broadcasts with the gains. `InputError` for an engine with inertia
        behind an actuator that is not of second order, and a filter that is too fast for the sample
        rate.
        """
        check_plant(plant)
        broadcast(autopilot=self.batch, plant=plant.batch)
        if self.sample_rate is not None:
            return wiring.sampled_loop(self, plant)
        return wiring.exact_loop(self, plant)

    def margins(self, plant: AnyPlant) -> Margins:
        """Return the margins of the loop around one plant, or around each of a batch.

        Parameters
        ----------
        plant : Plant or FlexiblePlant
            One plant or a batch of any model; it broadcasts with the gains.

        Returns
        -------
        Margins
            Margins by name. A loop with unstable closed-loop poles has none, and `reason` says so.

        Warns
        -----
        UserWarning
            For gains that are zero or positive feedback, an actuator slower than the fastest
            unstable pole, and a mode above half the sample rate.

        Examples
        --------
        >>> import tvclin as tv
        >>> plant = tv.Plant.from_coefficients(tv.Coefficients(mu_alpha=0.228, mu_delta=1.317))
        >>> m = tv.Autopilot(attitude_gain=1.88, rate_gain=1.59).margins(plant)
        >>> round(m.crossover_frequency, 3), round(m.phase_margin_deg, 1)
        (2.262, 62.4)
        >>> round(m.aero_margin_dB, 1)
        20.7
        """
        loop = self.exact_loop(plant)
        warn_of_feedback(self, plant)
        warn_of_sampling(self, plant)
        return loop_margins(loop)

    def band_margins(self, plant: FlexiblePlant | SystemPlant) -> BandMargins:
        """Return the margins by band: of the rigid body, and of each bending and slosh mode.

        They include the margins of the whole loop, which decide. `plant`: flexible, one or a batch
        of any model, which broadcasts with the gains. It warns of zero gains, positive feedback, a
        slow actuator and modes above half the sample rate, as `margins` does.
        """
        if not isinstance(plant, SystemPlant):
            instance("plant", plant, FlexiblePlant, "see FlexiblePlant.from_vehicle")
        loop = self.exact_loop(plant)
        warn_of_feedback(self, plant)
        warn_of_sampling(self, plant)
        return band_margins(loop, *named_modes(plant))

    def frequency_response(self, plant: AnyPlant, omega: ArrayLike) -> ComplexArray:
        """Return L(j omega) of `loop`, with the exact delay e^(-j omega delay).

        `plant`: one or a batch of any model. `omega`: frequencies [rad/s] of any shape; the result
        has ``batch + omega.shape``, and is infinite at a pole of the loop. `InputError` for
        frequencies that are not finite.
        """
        return self.exact_loop(plant).response(omega)

    def wind_response(self, plant: AnyPlant, wind: History) -> WindResponse:
        """Return the response of the closed loop to a wind, without limits, at any time.

        It has the outputs of `close` and their peaks, exact at any time. A delay enters as its Pade
        approximation. `plant`: one plant of any model. `wind`: one wind angle of attack [rad].
        `InputError` for a batch, and for a Pade approximation whose loop has another number of
        unstable poles than the loop with the exact delay.
        """
        return self.wind_response_function(plant)(wind)

    def wind_response_function(self, plant: AnyPlant) -> Callable[[History], WindResponse]:
        """Return the function from a wind angle [rad] to its `wind_response`, for many winds.

        `plant`: one plant of any model. `InputError` for a batch, and for a Pade approximation with
        a wrong number of unstable poles.
        """
        A, B, C, D, labels = self._wind_system(plant)
        return partial(wind_response_of, A, B, C, D, labels)

    def deflection_peaks_function(
        self, plant: AnyPlant
    ) -> Callable[[Sequence[History]], FloatArray]:
        """Return the function from winds to the largest deflection [rad] in each, ``(winds,)``.

        `plant`: one plant of any model, around which the closed loop is stable. The largest of all
        winds is exact; in winds that cannot have the largest it may be too small. `InputError` for
        a batch, and for a Pade approximation with a wrong number of unstable poles.
        """
        A, B, C, D, labels = self._wind_system(plant)
        row = labels.index("deflection")
        return partial(peaks_in_winds, A, B, (C[row], float(D[row])))

    def _wind_system(
        self, plant: AnyPlant
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, tuple[str, ...]]:
        """Return A, B, C, D of the closed loop from the wind to m outputs, and the outputs' names.

        Shapes ``(n, n)``, ``(n,)``, ``(m, n)`` and ``(m,)``, for this autopilot around one plant.
        `InputError` for a batch, and for a Pade approximation with a wrong number of unstable
        poles.
        """
        self._require_single("wind_response", plant)
        loop = wiring.closed_loop(self, plant, command=True)
        if pade_misleads(self, plant, loop):
            raise InputError(PADE_WARNING.format(self.pade_order))
        outputs = loop.outputs[:-1]  # all but the returned command
        A, B, C, D = loop.select(("wind",), outputs).matrices()
        return A, B[:, 0], C, D[:, 0], outputs

    def respond(
        self, plant: AnyPlant, wind: History, timepts: ArrayLike
    ) -> control.TimeResponseData:
        """Return the exact response of the closed loop to a wind as `control.TimeResponseData`.

        It has the outputs of `close` [rad, rad/s] and the input wind [rad]. `plant`: one plant of
        any model. `wind`: one wind angle of attack [rad]. `timepts`: times [s], ``(n,)``;
        breakpoints of the wind need not be among them. `InputError` for a batch, and for times that
        are not finite or not one row.
        """
        times = times_row("timepts", timepts)
        self._require_single("respond", plant)
        response = self.wind_response(plant, wind)
        name = f"{plant.model} with autopilot"
        title = f"Response to wind, {name}"
        outputs, labels = response(times), response.labels
        return time_response(times, outputs, labels, name=name, title=title, wind=wind)

    def _closed(self, method: str, plant: AnyPlant) -> LinearSystem:
        """Return the closed loop around a plant; warnings point at the caller of the public method.

        `method`: name of the public method, for messages. Inputs: wind, attitude command and
        deflection disturbance. Outputs: the plant's and the deflection.
        """
        self._require_single(method, plant)
        warn_of_feedback(self, plant, stacklevel=4)
        loop = wiring.closed_loop(self, plant, command=True)
        if pade_misleads(self, plant, loop):
            warnings.warn(f"{PADE_WARNING} (see margins)".format(self.pade_order), stacklevel=3)
        return loop.select(wiring.DISTURBANCES, loop.outputs[:-1])  # all but the returned command

    def _require_single(self, method: str, plant: AnyPlant, *, sampled: bool = False) -> None:
        """Raise `InputError` for a batch, and for a sampled autopilot unless `sampled` allows it.

        `method`: name of the calling method, for the message. `plant`: the plant of its loop.
        """
        check_plant(plant)
        if not sampled:
            self._require_continuous(method)
        if self.batch or plant.batch:
            raise InputError(
                f"{method}() is for one autopilot and one plant; got batches of shape"
                f" {self.batch} and {plant.batch} (use margins(), or take one at a time)"
            )

    def _require_continuous(self, method: str) -> None:
        """Raise `InputError` for a sampled autopilot, in the name of a calling `method`."""
        if self.sample_rate is not None:
            raise InputError(
                f"{method}() is for continuous autopilots; this one has a sample_rate (use"
                " margins() or exact_loop(), or replace sample_rate by None)"
            )
