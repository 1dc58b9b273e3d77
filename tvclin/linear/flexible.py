"""The flexible plant: a vehicle with bending, slosh and engine inertia, in state space.

`motions` has the equations of motion; here they get the flight path and the sensors,

    gamma' = (z'' - V' gamma)/V,    V' = (T - F_A)/m - g sin Theta_n,
    sensed attitude = theta + sum sigma_i(x) eta_i,

and the doors of `Plant`. Everything is a deviation from the nominal flight.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import ComplexArray, FloatArray, IndexArray
from tvclin.base.cards import Shown
from tvclin.base.doors import Hinted
from tvclin.base.errors import InputError, broadcast, instance, one_of, plain, positive, shown
from tvclin.linear.models import MODELS, USUAL_MODEL
from tvclin.linear.modes import left_eigenvector, unstable_poles, wind_strength
from tvclin.linear.motions import Motions, axial_acceleration, motions
from tvclin.linear.plant import INPUTS, Plant
from tvclin.linear.system import LinearSystem
from tvclin.vehicle.coefficients import PLANES, Coefficients
from tvclin.vehicle.filters import Filter
from tvclin.vehicle.linear_vehicle import AnyVehicle, LinearVehicle
from tvclin.vehicle.structure import Structure, chosen
from tvclin.vehicle.vehicle import STANDARD_GRAVITY, Vehicle

if TYPE_CHECKING:
    import control

Matrices = tuple[FloatArray, FloatArray, FloatArray, FloatArray]


class Shift(NamedTuple):
    """By how many percent a structure moves what the open-loop theory rests on.

    That is the fast pole, and the deflection that the wind asks for there, B K1.
    """

    fast_pole: float | FloatArray
    trim_price: float | FloatArray


@dataclass(frozen=True)
class FlexiblePlant(Shown, Hinted):
    """One linear model of one flexible vehicle, or of a batch of them.

    Make it with `from_vehicle`. Without structure it is the `Plant` of the same model.

    Attributes
    ----------
    vehicle : Vehicle
        The whole vehicle, liquid and engine included.
    structure : Structure
        Its bending, slosh and engine inertia, and the lags of its sensors.
    model : str
        "fixed-path", "drift-exact" or "drift-and-speed". In "fixed-path" the path angle is not
        part of the angle of attack, as at infinite speed; the vehicle still moves sideways.
    plane : str
        "pitch" or "yaw".
    """

    vehicle: Vehicle
    structure: Structure
    model: str = USUAL_MODEL
    plane: str = "pitch"

    _keys = "vehicle=vehicle.name model plane"

    def __post_init__(self) -> None:
        instance("vehicle", self.vehicle, Vehicle, "see load_vehicle")
        instance("structure", self.structure, Structure, "Structure(bending=..., slosh=...)")
        if one_of("model", self.model, MODELS) == "drift":
            raise InputError(
                'model "drift" leaves out forces that move liquid and structure; use "drift-exact"'
            )
        one_of("plane", self.plane, PLANES)
        _ = self._motions  # refuses masses that cannot be

    @classmethod
    def from_vehicle(
        cls,
        vehicle: Vehicle,
        structure: Structure,
        model: str = USUAL_MODEL,
        plane: str = "pitch",
    ) -> Self:
        """Return the plant of a vehicle and its structure.

        Parameters
        ----------
        vehicle : Vehicle
            One vehicle or a batch.
        structure : Structure
            One structure or a batch; it broadcasts with the vehicle.
        model : {"fixed-path", "drift-exact", "drift-and-speed"}
            As of `Plant`.
        plane : {"pitch", "yaw"}
            The plane of motion.

        Raises
        ------
        InputError
            For the model "drift", a structure that weighs more than the vehicle, and a pendulum
            in a vehicle whose thrust is not above its axial force.

        Warns
        -----
        UserWarning
            For a mode or a tank without damping.

        Examples
        --------
        >>> import tvclin as tv
        >>> tank = tv.vehicle.SloshTank(
        ...     mass=2400.0, station=19.94, damping=0.01, pendulum_length=2.1)
        >>> vehicle = tv.load_vehicle("configuration-i")
        >>> plant = tv.FlexiblePlant.from_vehicle(vehicle, tv.Structure(slosh=(tank,)))
        >>> plant.poles.round(3)
        array([ 0.509+0.j   ,  0.013+0.j   , -0.029+2.846j, -0.029-2.846j,
               -0.547+0.j   ])
        """
        plant = cls(vehicle, structure, model, plane)
        modes = {f"bending mode {k}": mode for k, mode in enumerate(structure.bending, start=1)}
        tanks = {f"tank {k}": tank for k, tank in enumerate(structure.slosh, start=1)}
        for name, body in (modes | tanks).items():
            if np.any(np.asarray(body.damping) == 0.0):
                warnings.warn(f"{name} has no damping", stacklevel=2)
        return plant

    @cached_property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one vehicle."""
        return broadcast(vehicle=self.vehicle.batch, structure=self.structure.batch)

    @cached_property
    def rigid(self) -> Plant:
        """The same vehicle without its structure."""
        return Plant.from_vehicle(self.vehicle, self.model, self.plane)

    @property
    def coefficients(self) -> Coefficients:
        """Those of the rigid vehicle."""
        return self.rigid.coefficients

    def cases(self, index: IndexArray | int, shape: tuple[int, ...]) -> FlexiblePlant:
        """Return the plants at flat positions ``(k,)`` of the batch broadcast to `shape`.

        A scalar position returns a single plant.
        """
        return replace(
            self,
            vehicle=chosen(self.vehicle, index, shape),
            structure=chosen(self.structure, index, shape),
        )

    @property
    def sensed(self) -> tuple[str, str]:
        """Names of the outputs that sensors give: attitude and attitude rate."""
        return "sensed_attitude", "sensed_attitude_rate"

    def with_effectiveness(self, factor: ArrayLike) -> FlexiblePlant:
        """Return the plant whose deflection does `factor` times as much, moment and force alike.

        The inertia of its engine stays.

        Raises
        ------
        InputError
            For a factor that is not positive.
        """
        times = positive("factor", factor)
        with np.errstate(over="ignore"):  # what is beyond all numbers is refused as that
            slope = times * np.asarray(self.vehicle.control_force)
        return replace(self, vehicle=self.vehicle.replace(control_force_slope=slope))

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs; with an engine, the acceleration of the deflection is the third."""
        swinging = () if self.structure.engine is None else ("deflection_acceleration",)
        return (*INPUTS, *swinging)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs: those of `Plant`, then what the sensors say."""
        return (*self.rigid.outputs, "sensed_attitude", "sensed_attitude_rate")

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states: those of `Plant`, then of structure, liquids and sensors."""
        counts = {"bending": len(self.structure.bending), "slosh": len(self.structure.slosh)}
        bodies = [f"{name}_{k}" for name, count in counts.items() for k in range(1, count + 1)]
        moving = [state for body in bodies for state in (body, f"{body}_rate")]
        lags = [
            f"{name}_{k}" for name, lag in self._sensors.items() for k in range(1, lag.order + 1)
        ]
        return (*self.rigid.states, *moving, *lags)

    @cached_property
    def poles(self) -> ComplexArray:
        """Poles of the airframe [1/s], the fastest growing first, ``(..., n)``.

        Those of the sensors, which hang on it, are not among them.
        """
        poles = np.linalg.eigvals(self._airframe[0]).astype(complex)
        order = np.lexsort((-poles.imag, -poles.real), axis=-1)
        return np.take_along_axis(poles, order, axis=-1)

    def matrices(self) -> Matrices:
        """Return A, B, C, D with the leading axes of the batch; their rows as `states`.

        Columns of B and D as `inputs`, rows of C and D as `outputs`.
        """
        inner, forced = self._airframe
        seen, past = self._seen(inner.shape[-1])
        n, count = inner.shape[-1], len(self.states)
        A = np.zeros((*self.batch, count, count))
        B = np.zeros((*self.batch, count, forced.shape[-1]))
        C = np.zeros((*self.batch, len(self.outputs), count))
        A[..., :n, :n], B[..., :n, :], C[..., :n] = inner, forced, seen
        start = n
        for name, lag in self._sensors.items():
            row, own = (-2 if name == "attitude_sensor" else -1), slice(start, start + lag.order)
            a, b, c, d = lag.matrices()
            A[..., own, own], A[..., own, :n] = a, b * seen[..., np.newaxis, row, :]
            C[..., row, :n], C[..., row, own] = d[..., 0] * seen[..., row, :], c[..., 0, :]
            start += lag.order
        return A, B, C, past

    def ss(self) -> control.StateSpace:
        """Return the whole plant as `control.StateSpace` with named signals [rad, rad/s].

        Raises
        ------
        InputError
            For a batch.
        """
        if self.batch:
            raise InputError(
                f"ss() is for one vehicle; this plant is a batch of shape {self.batch} (use"
                " matrices())"
            )
        return self.system.to_control(f"{self.model}, flexible")

    @property
    def system(self) -> LinearSystem:
        """The plant with its signals by name."""
        return LinearSystem(*self.matrices(), self.inputs, self.outputs, self.states)

    def shift(self) -> Shift:
        """Return by how many percent the structure moves the fast pole, and the price of trim.

        The open-loop theory rests on these two.

        Raises
        ------
        InputError
            For a rigid vehicle without a growing mode.

        Notes
        -----
        With the left eigenvector l at the pole p, the wind asks l b_wind over l b_deflection of
        deflection; of the rigid vehicle that is B K1, eq (15b).
        """
        growing = unstable_poles(self.rigid)
        if not growing.shape[-1] or np.any(np.isnan(growing[..., 0])):
            raise InputError("shift() needs a vehicle with a growing mode; this one has none")
        stiff = growing[..., 0]
        A, B = self._airframe
        pole, row = left_eigenvector(A, stiff)
        reached = np.einsum("...i,...ij->...j", row, B)
        turned = reached[..., 0] + pole**2 * reached[..., 2:].sum(axis=-1)
        rigid = wind_strength(self.rigid, stiff[..., np.newaxis])[..., 0]
        price = np.abs(reached[..., 1] / turned) / np.abs(rigid)
        return Shift(
            plain(100.0 * (np.abs(pole) / np.abs(stiff) - 1.0)), plain(100.0 * (price - 1.0))
        )

    @property
    def _sensors(self) -> dict[str, Filter]:
        """The lags that there are, in the order of their states."""
        lags = {name: getattr(self.structure, name) for name in ("attitude_sensor", "rate_gyro")}
        return {name: lag for name, lag in lags.items() if lag is not None}

    @cached_property
    def _motions(self) -> Motions:
        return motions(self.vehicle, self.structure)

    @cached_property
    def _airframe(self) -> tuple[FloatArray, FloatArray]:
        """A and B without sensors."""
        v, found = self.vehicle, self._motions
        rigid, bodies = len(self.rigid.states), found.rate.shape[-1] - 2
        count = rigid + 2 * bodies
        places = np.concatenate([[0], rigid + 2 * np.arange(bodies)])  # of theta, eta, zeta
        A = np.zeros((*self.batch, count, count))
        B = np.zeros((*self.batch, count, len(self.inputs)))
        # Accelerations of all motions, from the states and from the inputs.
        drive = np.zeros((*self.batch, bodies + 2, count))
        drive[..., places], drive[..., places + 1] = (
            found.displacement[..., 1:],
            found.rate[..., 1:],
        )
        drive[..., 0] += found.angle_of_attack
        if rigid > 2:
            drive[..., 2] = -found.angle_of_attack
        forces = [found.deflection, -found.angle_of_attack, found.deflection_acceleration]
        forced = np.stack(forces[: B.shape[-1]], axis=-1)
        A[..., places, places + 1] = 1.0
        A[..., places + 1, :], B[..., places + 1, :] = drive[..., 1:, :], forced[..., 1:, :]
        if rigid > 2:
            speed = np.asarray(v.velocity)
            slowing = (axial_acceleration(v) - STANDARD_GRAVITY * np.sin(v.attitude)) / speed
            A[..., 2, :] = drive[..., 0, :] / speed[..., np.newaxis]
            A[..., 2, 2] -= slowing
            B[..., 2, :] = forced[..., 0, :] / speed[..., np.newaxis]
        if rigid > 3:
            turning = np.sqrt(self.rigid.coefficients.q)
            A[..., 2, 3], A[..., 3, 2] = turning, -turning
        return A, B

    def _seen(self, count: int) -> tuple[FloatArray, FloatArray]:
        """C and D of all outputs, before the lags of the sensors."""
        few, first = len(self.outputs) - 3, len(self.rigid.states)
        C = np.zeros((*self.batch, few + 3, count))
        D = np.zeros((*self.batch, few + 3, len(self.inputs)))
        C[..., :few, :few] = np.eye(few)
        C[..., few, 0], D[..., few, 1] = 1.0, -1.0  # alpha = theta - gamma - alpha_w
        if few > 2:
            C[..., few, 2] = -1.0
        C[..., -2, 0] = C[..., -1, 1] = 1.0
        for k, mode in enumerate(self.structure.bending):
            C[..., -2, first + 2 * k] = mode.attitude_slope
            C[..., -1, first + 2 * k + 1] = mode.rate_slope
        return C, D


AnyPlant = Plant | FlexiblePlant
"""What an autopilot controls, and what flies."""


def plant_of(vehicle: AnyVehicle, model: str | None = None, plane: str = "pitch") -> AnyPlant:
    """Return the plant of a vehicle, flexible where it bends, sloshes or swings.

    Parameters
    ----------
    vehicle : Vehicle or LinearVehicle
        The vehicle; `rigid` of it leaves its structure out.
    model : str, optional
        As of `Plant`; `usual_model` of the vehicle where it is not given.
    plane : {"pitch", "yaw"}
        The plane of motion.

    Raises
    ------
    InputError
        As `Plant.from_vehicle` and `FlexiblePlant.from_vehicle`.

    Examples
    --------
    >>> import tvclin as tv
    >>> booster = tv.load_vehicle("made-up-booster")
    >>> type(tv.linear.plant_of(booster)).__name__, type(tv.linear.plant_of(booster.rigid)).__name__
    ('FlexiblePlant', 'Plant')
    """
    if not isinstance(vehicle, LinearVehicle):
        instance("vehicle", vehicle, Vehicle, "see load_vehicle")
    if isinstance(vehicle, LinearVehicle) or vehicle.structure is None:
        return Plant.from_vehicle(vehicle, model, plane)
    return FlexiblePlant.from_vehicle(vehicle, vehicle.structure, model or USUAL_MODEL, plane)


def check_plant(plant: object) -> None:
    """Raise `InputError` unless it is a plant, rigid or flexible."""
    if not isinstance(plant, AnyPlant):
        raise InputError(
            f"plant must be a Plant or a FlexiblePlant; got {shown(plant)} (see Plant.from_vehicle)"
        )
