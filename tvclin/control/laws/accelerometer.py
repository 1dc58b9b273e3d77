"""Load relief by a body-mounted accelerometer instead of a vane.

At a station x ahead of the centre of gravity the accelerometer measures, without gravity,

    n = (N alpha + T delta)/m + x theta'' = n_alpha alpha + n_delta delta - x d theta',

with n_alpha = N/m + x mu_alpha, n_delta = T/m - x mu_delta and the damping d of the vehicle. At the
centre of percussion of the nozzle, x = T/(m mu_delta), n_delta vanishes and the measurement depends
on the angle of attack alone. At other stations the measured deflection closes a second loop.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, instance, positive, single
from tvclin.base.fields import checked, quantity, spec, word
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.laws.autopilot_law import SaturatedLaw
from tvclin.control.laws.law import Chains, LinearLaw
from tvclin.kernels.control_laws import LawNumbers
from tvclin.vehicle.coefficients import PLANES, Coefficients
from tvclin.vehicle.vehicle import Vehicle


@dataclass(frozen=True)
class AccelerometerLaw(LinearLaw):
    """Feedback of attitude, rate and a measured acceleration instead of the angle of attack.

    With an ideal nozzle and an ideal sensor the loop equals that of the autopilot with a vane: with
    the gain g on the acceleration, a0, a1 and b0 are the law's gains over 1 - g n_delta.

    Parameters
    ----------
    autopilot : Autopilot
        One autopilot with a gain b0 on the angle of attack and none on the integral, such as
        `half_relief_gains`.
    vehicle : Vehicle
        One vehicle, for which the gains are computed.
    station : float
        Position of the accelerometer ahead of the centre of gravity [m]; negative behind it.
    bandwidth : float
        Bandwidth of the accelerometer, a first-order lag [rad/s].
    plane : {"pitch", "yaw"}
        Plane of the measured acceleration.

    Raises
    ------
    InputError
        In the same cases as `SaturatedLaw`, for an autopilot without b0 or with an integral, and
        for a station whose measurement is dominated by the law's deflection, not the wind.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> vehicle = tv.load_vehicle("configuration-i")
    >>> gains = tv.control.half_relief_gains(vehicle)
    >>> law = tv.control.AccelerometerLaw(gains, vehicle, station=10.0)
    >>> round(float(np.degrees(law.gain)), 3)  # deg for each m/s2
    7.381
    """

    autopilot: Autopilot = field(metadata=spec())
    vehicle: Vehicle
    station: float = quantity("length", 0.0)
    bandwidth: float = quantity("natural frequency", 100.0, positive)
    plane: str = word(PLANES, "pitch")

    def __post_init__(self) -> None:
        """Check autopilot, vehicle and sensor, and that the wind dominates the measurement."""
        SaturatedLaw(self.autopilot)  # raises for an autopilot that is not of gains alone
        instance("vehicle", self.vehicle, Vehicle, "see load_vehicle")
        single("vehicle", self.vehicle.batch)
        checked(self, "plane", "station", "bandwidth")
        if not self.autopilot.alpha_gain or self.autopilot.integral_gain:
            raise InputError(
                "autopilot must have a gain on the angle of attack, which an accelerometer stands"
                " for, and none on the integral; see half_relief_gains"
            )
        # n_alpha must exceed -b0 n_delta, what the law's own deflection b0 alpha adds.
        n_alpha, n_delta, _ = self.sensitivities
        if n_alpha <= 0.0 or n_alpha + float(self.autopilot.alpha_gain) * n_delta <= 0.0:
            raise InputError(
                f"station {self.station:g} m is no place for the accelerometer: it would feel less"
                " of the wind than of the deflection that it asks for"
            )

    @property
    def sensitivities(self) -> tuple[float, float, float]:
        """Sensitivities of the acceleration: n_alpha, n_delta [m/s2/rad], and -x d [m/s].

        To angle of attack, deflection and attitude rate, at the station x [m] ahead of the centre
        of gravity; d is the damping [1/s] of the attitude rate.
        """
        v, x = self.vehicle, self.station
        c = Coefficients.from_vehicle(v, self.plane)
        n_alpha = v.normal_force_slope / v.mass + x * c.mu_alpha
        n_delta = v.control_force / v.mass - x * c.mu_delta
        return float(n_alpha), float(n_delta), float(-x * c.damping)

    @property
    def gain(self) -> float:
        """Gain g on the acceleration [rad s2/m], so that the law has the autopilot's b0 on alpha.

        g = b0/(n_alpha + b0 n_delta), as g (n_alpha alpha + n_delta delta) = b0 alpha at delta =
        b0 alpha, with the sensitivities n of the acceleration to angle of attack and deflection.
        """
        n_alpha, n_delta, _ = self.sensitivities
        b0 = float(self.autopilot.alpha_gain)
        return b0 / (n_alpha + b0 * n_delta)

    @property
    def states(self) -> tuple[FloatArray, FloatArray]:
        """F ``(1, 1)`` and G ``(1, 5)`` of s' = F s + G m, s the acceleration [m/s^2] measured.

        s is the state of the sensor's lag, and m are attitude, its rate, flight path angle, angle
        of attack and deflection. Without lag the sensor measures the sum of their `sensitivities`,
        n_alpha alpha + n_delta delta + n_rate theta'.
        """
        n_alpha, n_delta, n_rate = self.sensitivities
        row = np.array([[0.0, n_rate, 0.0, n_alpha, n_delta]])
        return np.array([[-self.bandwidth]]), self.bandwidth * row

    @property
    def chains(self) -> Chains:
        """Filter chains of the autopilot."""
        return SaturatedLaw(self.autopilot).chains

    @cached_property
    def numbers(self) -> LawNumbers:
        """Gains on attitude, its rate and the acceleration, which is the law's first state.

        With them the loop of an ideal nozzle has the autopilot's a0 and a1: the deflection that the
        acceleration measures too is taken out by the factor 1 - g n_delta, with the gain g and the
        sensitivity n_delta of the acceleration, and the attitude rate likewise.
        """
        _, n_delta, n_rate = self.sensitivities
        factor = 1.0 - self.gain * n_delta
        return LawNumbers(
            attitude=float(self.autopilot.attitude_gain) * factor,
            attitude_rate=float(self.autopilot.rate_gain) * factor - self.gain * n_rate,
            first_state=self.gain,
        )
