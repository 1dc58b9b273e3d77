"""Flexible plant: a vehicle with bending, slosh and engine inertia, in state space.

`motions` has the equations of motion; flight path and sensors are added here,

    gamma' = (z'' - V' gamma)/V,    V' = (T - F_A)/m - g sin Theta_n,
    sensed attitude = theta + sum sigma_i(x) eta_i,

with the methods of `Plant`. Everything is a deviation from the nominal flight.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import ComplexArray, FloatArray, IndexArray
from tvclin.base.cards import Shown
from tvclin.base.fields import spec
from tvclin.base.lines import Line, Table, significant, upper_pole
from tvclin.linear.modes import left_eigenvector, unstable_poles, wind_over_deflection
from tvclin.linear.motions import Motions, axial_acceleration, motions, tank_frequency
from tvclin.linear.plant import (
    DEFAULT_MODEL,
    INPUTS,
    LATERAL_SIGNALS,
    MODELS,
    STATION_RANGE,
    Plant,
    WithCoefficients,
)
from tvclin.linear.system import LinearSystem
from tvclin.linear.system_plant import SystemPlant
from tvclin.numerics.state_space import Matrices
from tvclin.vehicle.coefficients import PLANES, Coefficients
from tvclin.vehicle.filters import Filter
from tvclin.vehicle.linear_vehicle import AnyVehicle, LinearVehicle
from tvclin.vehicle.structure import Structure, select_cases
from tvclin.vehicle.vehicle import STANDARD_GRAVITY, Vehicle

if TYPE_CHECKING:
    import control


class Shift(NamedTuple):
    """Relative change [percent] by a structure of the fast pole and of the trim per wind angle.

    The latter is the deflection per wind angle at the fast pole, B K1.
    """

    fast_pole: float | FloatArray
    trim_price: float | FloatArray


@dataclass(frozen=True)
class FlexiblePlant(Shown, WithCoefficients):
    """Linear model of a flexible vehicle, or of a batch of flexible vehicles.

    Make it with `from_vehicle`. Without structure it is the `Plant` of the same model.

    Attributes
    ----------
    vehicle : Vehicle
        The whole vehicle, liquid and engine included.
    structure : Structure
        Bending, slosh and engine inertia, and the lags of the sensors.
    model : str
        "fixed-path", "drift-exact" or "drift-and-speed". In "fixed-path" the path angle is not
        part of the angle of attack, as at infinite speed; the vehicle still moves sideways.
    plane : str
        "pitch" or "yaw".
    """

    vehicle: Vehicle = field(metadata=spec(of="vehicle.name"))
    structure: Structure
    model: str = field(default=DEFAULT_MODEL, metadata=spec())
    plane: str = field(default="pitch", metadata=spec())

    def __post_init__(self) -> None:
        """Check the fields and the masses of the structure."""
        errors.instance("vehicle", self.vehicle, Vehicle, "see load_vehicle")
        errors.instance("structure", self.structure, Structure, "Structure(bending=..., slosh=...)")
        if errors.one_of("model", self.model, MODELS) == "drift":
            raise errors.InputError(
                'model "drift" leaves out forces that move liquid and structure; use "drift-exact"'
            )
        errors.one_of("plane", self.plane, PLANES)
        _ = self._motions  # raises for impossible masses

    @classmethod
    def from_vehicle(
        cls,
        vehicle: Vehicle,
        structure: Structure,
        model: str = DEFAULT_MODEL,
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
            As in `Plant`.
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
        return errors.broadcast(vehicle=self.vehicle.batch, structure=self.structure.batch)

    @cached_property
    def rigid(self) -> Plant:
        """Plant of the vehicle without its structure."""
        return Plant.from_vehicle(self.vehicle, self.model, self.plane)

    @property
    def coefficients(self) -> Coefficients:
        """Coefficients of the rigid vehicle."""
        return self.rigid.coefficients

    @property
    def is_rigid(self) -> bool:
        """False: the plant is analysed by its matrices."""
        return False

    @property
    def has_modes(self) -> bool:
        """True: bending and slosh may have a limit cycle with the nozzle."""
        return True

    def cases(self, index: IndexArray | int, shape: tuple[int, ...]) -> FlexiblePlant:
        """Return the plants at flat positions `index` ``(k,)`` of a batch of the shape `shape`.

        A scalar position returns a single plant.
        """
        return replace(
            self,
            vehicle=select_cases(self.vehicle, index, shape),
            structure=select_cases(self.structure, index, shape),
        )

    @property
    def sensed(self) -> tuple[str, str]:
        """Names of the sensor outputs: attitude and attitude rate."""
        return "sensed_attitude", "sensed_attitude_rate"

    def with_effectiveness(self, factor: ArrayLike) -> FlexiblePlant:
        """Return the plant with control moment and control force multiplied by `factor`.

        The inertia of its engine stays. `InputError` for a factor that is not positive.
        """
        multiple = errors.positive("factor", factor)
        with np.errstate(over="ignore"):  # an overflow is refused below
            slope = multiple * np.asarray(self.vehicle.control_force)
        return replace(self, vehicle=self.vehicle.replace(control_force_slope=slope))

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs; with an engine, the third is the acceleration of the deflection."""
        engine = () if self.structure.engine is None else ("deflection_acceleration",)
        return (*INPUTS, *engine)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs: outputs of `Plant`, then of the sensors."""
        return (*self.rigid.outputs, "sensed_attitude", "sensed_attitude_rate")

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states: of `Plant`, of each mode and tank with its rate, and of sensors."""
        counts = {"bending": len(self.structure.bending), "slosh": len(self.structure.slosh)}
        bodies = [f"{name}_{k}" for name, count in counts.items() for k in range(1, count + 1)]
        motion = [state for body in bodies for state in (body, f"{body}_rate")]
        lags = [
            f"{name}_{k}" for name, lag in self._sensors.items() for k in range(1, lag.order + 1)
        ]
        return (*self.rigid.states, *motion, *lags)

    @cached_property
    def poles(self) -> ComplexArray:
        """The n poles of the airframe [1/s], without the sensors', ``(..., n)``, fastest first."""
        A, _ = self._airframe  # without sensors
        poles = np.linalg.eigvals(A).astype(complex)
        order = np.lexsort((-poles.imag, -poles.real), axis=-1)
        return np.take_along_axis(poles, order, axis=-1)

    def matrices(self) -> Matrices:
        """Return A, B, C, D with the leading axes of the batch.

        The order is the same as in `states`, `inputs` and `outputs`. The lags of the sensors are in
        series behind the airframe: their inputs are its sensed attitude and rate.
        """
        airframe_A, airframe_B = self._airframe
        airframe_C, D = self._output_matrices(airframe_A.shape[-1])
        n, count = airframe_A.shape[-1], len(self.states)
        A = np.zeros((*self.batch, count, count))
        B = np.zeros((*self.batch, count, airframe_B.shape[-1]))
        C = np.zeros((*self.batch, len(self.outputs), count))
        A[..., :n, :n], B[..., :n, :], C[..., :n] = airframe_A, airframe_B, airframe_C
        start = n
        for name, lag in self._sensors.items():
            output = -2 if name == "attitude_sensor" else -1  # sensed attitude, or its rate
            row, states = airframe_C[..., output, :], slice(start, start + lag.order)
            a, b, c, d = lag.matrices()
            A[..., states, states], A[..., states, :n] = a, b * row[..., np.newaxis, :]
            C[..., output, :n], C[..., output, states] = d[..., 0] * row, c[..., 0, :]
            start += lag.order
        return A, B, C, D

    def ss(self) -> control.StateSpace:
        """Return the whole plant as `control.StateSpace` with named signals [rad, rad/s].

        `InputError` for a batch.
        """
        return self.system.to_control(f"{self.model}, flexible")

    @property
    def system(self) -> LinearSystem:
        """The plant as a `LinearSystem` with named signals."""
        return LinearSystem(*self.matrices(), self.inputs, self.outputs, self.states)

    def shift(self) -> Shift:
        """Return the relative change of the fast pole and of the trim per wind angle [percent].

        The fast pole is the fastest unstable pole; the trim is the deflection per wind angle that
        cancels the effect of the wind on this mode. The open-loop theory has these two numbers from
        the rigid vehicle. `InputError` for a rigid vehicle without an unstable mode.

        Notes
        -----
        With the left eigenvector l at the pole p, the deflection per wind angle is l b_wind over
        l b_deflection, b being columns of B; for the rigid vehicle it is trim B per angle of attack
        times K1 = (p + b2)/(p + b1), eq (15b), with b1 and b2 [1/s] of its flight path.
        """
        unstable = unstable_poles(self.rigid)
        if not unstable.shape[-1] or np.any(np.isnan(unstable[..., 0])):
            raise errors.InputError(
                "shift() needs a vehicle with a growing mode; this one has none"
            )
        rigid_pole = unstable[..., 0]  # the fastest
        A, B = self._airframe
        pole, row = left_eigenvector(A, rigid_pole)
        # effects l b on the mode of deflection, wind, and with an engine delta'' = p^2 delta
        effects = np.einsum("...i,...ij->...j", row, B)
        from_wind, from_acceleration = effects[..., 1], effects[..., 2:].sum(axis=-1)
        from_deflection = effects[..., 0] + pole**2 * from_acceleration
        rigid_ratio = wind_over_deflection(self.rigid, rigid_pole[..., np.newaxis])[..., 0]
        relative_trim = np.abs(from_wind / from_deflection) / np.abs(rigid_ratio)
        return Shift(
            fast_pole=errors.plain(100.0 * (np.abs(pole) / np.abs(rigid_pole) - 1.0)),
            trim_price=errors.plain(100.0 * (relative_trim - 1.0)),
        )

    def lateral_rows(self, signal: str, station: float) -> tuple[FloatArray, FloatArray]:
        """Return the rows of C ``(..., n)`` and D ``(..., inputs)`` of a lateral signal.

        `signal`: "drift_rate" [m/s] or "acceleration" [m/s^2]. `station`: position x of the
        accelerometer ahead of the centre of gravity [m]. `InputError` for a drift rate in a model
        without flight path. Sensors measure the bending too: the sums are over the modes, with
        amplitude eta [m], displacement phi and slope sigma [1/m] at the sensor; z'' is the
        acceleration normal to the path, and a = (thrust - axial force)/m the axial one [m/s^2];
        V, gamma, theta are speed, flight path angle and attitude:

            drift rate     V gamma + sum phi eta'
            acceleration   z'' + x theta'' + sum phi eta'' - a (theta + sum sigma eta)
        """
        errors.one_of("signal", signal, LATERAL_SIGNALS)
        station = errors.number("station", station, STATION_RANGE, "m")
        rigid, modes = len(self.rigid.states), self.structure.bending
        columns = rigid + 2 * np.arange(len(modes))  # states eta of the modes, each before its rate
        C = np.zeros((*self.batch, len(self.states)))
        if signal == "drift_rate":
            if rigid < 3:
                self.rigid.lateral_rows(signal, station)  # raises: no flight path angle
            C[..., 2] = self.vehicle.velocity  # state 2 is the flight path angle
            for column, mode in zip(columns, modes, strict=True):
                C[..., column + 1] = mode.drift_displacement
            return C, np.zeros((*self.batch, len(self.inputs)))
        # displacements at the sensor of translation z, rotation theta and modes
        displacements = (1.0, station, *(mode.accelerometer_displacement for mode in modes))
        per_state, per_input = self._accelerations  # rows: of translation, rotation, modes
        D = np.zeros((*self.batch, len(self.inputs)))
        for body, displacement in enumerate(displacements):
            factor = np.asarray(displacement)[..., np.newaxis]
            C[..., : per_state.shape[-1]] += factor * per_state[..., body, :]
            D += factor * per_input[..., body, :]
        axial = axial_acceleration(self.vehicle)
        C[..., 0] -= axial  # state 0 is the attitude
        for column, mode in zip(columns, modes, strict=True):
            C[..., column] -= axial * mode.accelerometer_slope
        return C, D

    @property
    def _sensors(self) -> dict[str, Filter]:
        """Lags of attitude sensor and rate gyro by name, where the structure has them."""
        lags = {name: getattr(self.structure, name) for name in ("attitude_sensor", "rate_gyro")}
        return {name: lag for name, lag in lags.items() if lag is not None}

    @cached_property
    def _motions(self) -> Motions:
        """Accelerations [rad/s^2, m/s^2] of attitude, modes and tanks, per state and per input."""
        return motions(self.vehicle, self.structure)

    @cached_property
    def _positions(self) -> IndexArray:
        """Positions among the states of the attitude and of the k modes and tanks, ``(k + 1,)``.

        Behind the states of the rigid plant come amplitude and rate of each mode and tank.
        """
        rigid, bodies = len(self.rigid.states), len(self.structure.bending + self.structure.slosh)
        return np.concatenate([[0], rigid + 2 * np.arange(bodies)])

    @cached_property
    def _accelerations(self) -> tuple[FloatArray, FloatArray]:
        """Accelerations of drift, attitude, modes and tanks per state and per input.

        Shapes ``(..., bodies + 2, states)`` and ``(..., bodies + 2, inputs)``, bodies being modes
        and tanks; the states are plant, modes and tanks, without sensors. Forces of the air are per
        angle of attack: here attitude minus flight path angle minus wind angle.
        """
        accelerations, positions = self._motions, self._positions
        rigid, bodies = len(self.rigid.states), positions.size - 1
        # `positions`: the attitude, state 0, and the amplitudes, each before its rate
        per_state = np.zeros((*self.batch, bodies + 2, rigid + 2 * bodies))
        per_state[..., positions] = accelerations.displacement[..., 1:]  # without the drift
        per_state[..., positions + 1] = accelerations.rate[..., 1:]
        per_state[..., 0] += accelerations.angle_of_attack
        if rigid > 2:  # the model has a flight path angle gamma, state 2
            per_state[..., 2] = -accelerations.angle_of_attack
        per_input = [
            accelerations.deflection,
            -accelerations.angle_of_attack,  # the wind
            accelerations.deflection_acceleration,  # an input with an engine alone
        ]
        return per_state, np.stack(per_input[: len(self.inputs)], axis=-1)

    @cached_property
    def _airframe(self) -> tuple[FloatArray, FloatArray]:
        """A ``(..., n, n)`` and B ``(..., n, inputs)`` of the vehicle without its sensors.

        The n states are the attitude, its rate, and of the models that have them the flight path
        angle gamma (state 2) and the relative speed (state 3), then each mode and tank with its
        rate. gamma' = (z'' - V' gamma)/V, with the acceleration z'' normal to the path and the rate
        V' of the speed.
        """
        # per state and per input: accelerations of drift (row 0), attitude, modes and tanks
        v, (per_state, per_input) = self.vehicle, self._accelerations
        rigid, count = len(self.rigid.states), per_state.shape[-1]
        A = np.zeros((*self.batch, count, count))
        B = np.zeros((*self.batch, count, len(self.inputs)))
        amplitudes = self._positions  # of the attitude, modes and tanks, each before its rate
        rates = amplitudes + 1
        A[..., amplitudes, rates] = 1.0
        A[..., rates, :], B[..., rates, :] = per_state[..., 1:, :], per_input[..., 1:, :]
        if rigid > 2:
            speed = np.asarray(v.velocity)
            acceleration = axial_acceleration(v) - STANDARD_GRAVITY * np.sin(v.attitude)  # V'
            A[..., 2, :] = per_state[..., 0, :] / speed[..., np.newaxis]
            A[..., 2, 2] -= acceleration / speed
            B[..., 2, :] = per_input[..., 0, :] / speed[..., np.newaxis]
        if rigid > 3:
            path_rate = np.sqrt(self.rigid.coefficients.q)  # g cos(Theta_n)/V [1/s]
            A[..., 2, 3], A[..., 3, 2] = path_rate, -path_rate
        return A, B

    def _output_matrices(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Return C and D of all outputs, before the lags of the sensors.

        The first outputs are the states 0, 1 and, if the model has it, 2: attitude, its rate, and
        flight path angle. The last three are the angle of attack, and the sensed attitude and rate,
        with the slope of each mode at the sensor.

        `count`: number of states without sensors, the columns of C.
        """
        count_rigid, rigid_states = len(self.outputs) - 3, len(self.rigid.states)
        C = np.zeros((*self.batch, count_rigid + 3, count))
        D = np.zeros((*self.batch, count_rigid + 3, len(self.inputs)))
        C[..., :count_rigid, :count_rigid] = np.eye(count_rigid)
        # after the rigid states alpha = theta - gamma - alpha_w, the wind alpha_w being input 1
        C[..., count_rigid, 0], D[..., count_rigid, 1] = 1.0, -1.0
        if count_rigid > 2:
            C[..., count_rigid, 2] = -1.0
        C[..., -2, 0] = C[..., -1, 1] = 1.0
        for k, mode in enumerate(self.structure.bending):
            C[..., -2, rigid_states + 2 * k] = mode.attitude_slope
            C[..., -1, rigid_states + 2 * k + 1] = mode.rate_slope
        return C, D


AnyPlant = Plant | FlexiblePlant
"""Rigid or flexible plant of autopilots and flights."""


def mode_tables(plant: AnyPlant) -> list[Table]:
    """Return the table of poles of one plant, by mode, with frequency and damping of named modes.

    In a list: empty for a plant without named modes. One row per conjugate pair, with Im >= 0.
    """
    names, poles = named_modes(plant)
    rows: list[tuple[Line, ...]] = []
    # first the other poles, of the rigid body, without frequency and damping
    for k, pole in enumerate(p for p in plant.poles if p.imag >= 0.0 and p not in poles):
        rows.append((("" if k else "rigid body",), upper_pole(f"flexible.rigid.{k}", pole), *_NONE))
    for k, (name, pole) in enumerate(zip(names, poles, strict=True)):
        size, key = abs(pole), f"flexible.mode.{k}"
        damping = -pole.real / size if size else np.nan
        rows.append(
            (
                (name,),
                upper_pole(f"{key}.pole", pole),
                significant(f"{key}.rad_per_s", size, 3),
                significant(f"{key}.Hz", size / (2.0 * np.pi), 3),
                significant(f"{key}.damping", damping, 3),
            )
        )
    head = ("mode", "pole [1/s]", "[rad/s]", "[Hz]", "damping")
    caption = f"Poles of the coupled vehicle, without an autopilot, {plant.model}"
    return [Table(caption, head, tuple(rows))] if names else []


_NONE: tuple[Line, ...] = (("-",), ("-",), ("-",))
"""Cells of frequency and damping of a pole that belongs to no named mode."""


def plant_of(vehicle: AnyVehicle, model: str | None = None, plane: str = "pitch") -> AnyPlant:
    """Return the plant of a vehicle, flexible if the vehicle has a structure.

    Parameters
    ----------
    vehicle : Vehicle or LinearVehicle
        The vehicle; its `rigid` has no structure.
    model : str, optional
        See `Plant`; `default_model` of the vehicle where it is not given.
    plane : {"pitch", "yaw"}
        The plane of motion.

    Raises
    ------
    InputError
        For another type or model, and a structure that weighs more than the vehicle.

    Examples
    --------
    >>> import tvclin as tv
    >>> booster = tv.load_vehicle("made-up-booster")
    >>> type(tv.linear.plant_of(booster)).__name__, type(tv.linear.plant_of(booster.rigid)).__name__
    ('FlexiblePlant', 'Plant')
    """
    if not isinstance(vehicle, LinearVehicle):
        errors.instance("vehicle", vehicle, Vehicle, "see load_vehicle")
    if isinstance(vehicle, LinearVehicle) or vehicle.structure is None:
        return Plant.from_vehicle(vehicle, model, plane)
    model = DEFAULT_MODEL if model is None else model
    return FlexiblePlant.from_vehicle(vehicle, vehicle.structure, model, plane)


def check_plant(plant: object) -> None:
    """Raise `InputError` unless `plant` is a plant, rigid or flexible."""
    if not isinstance(plant, AnyPlant):
        raise errors.InputError(
            f"plant must be a Plant or a FlexiblePlant; got {errors.shown(plant)} (see"
            " Plant.from_vehicle, or linear.SystemPlant of a control.StateSpace)"
        )


def named_modes(plant: AnyPlant) -> tuple[tuple[str, ...], ComplexArray]:
    """Return the names of bending modes and tanks, and their poles in the airframe.

    The names are "bending 1", .., "slosh 1", .., as in the structure, of a `SystemPlant` "mode 1",
    .. by frequency; the poles have Im > 0 [1/s], ``(..., n)``, NaN if a mode does not oscillate.

    Coupling moves the frequencies, and hardly ever changes their order: poles are matched in it to
    the frequencies of the structure. An oscillation of the rigid vehicle is omitted, where there
    are more pairs than modes and tanks: the poles nearest to the rigid poles.
    """
    if isinstance(plant, SystemPlant):
        return plant.named_modes()
    if isinstance(plant, Plant):
        return (), np.zeros((*plant.batch, 0), dtype=complex)
    structure = plant.structure
    bending = {f"bending {k}": mode.frequency for k, mode in enumerate(structure.bending, start=1)}
    a = axial_acceleration(plant.vehicle)
    slosh = {f"slosh {k}": tank_frequency(t, a) for k, t in enumerate(structure.slosh, start=1)}
    names = (*bending, *slosh)
    frequencies = [np.broadcast_to(f, plant.batch) for f in (*bending.values(), *slosh.values())]
    if not frequencies:
        return (), np.zeros((*plant.batch, 0), dtype=complex)
    poles = np.where(plant.poles.imag > 0.0, plant.poles, np.nan)
    # omit the pole nearest to each oscillating rigid pole, while there are more than the modes
    for rigid in np.moveaxis(plant.rigid.poles.astype(complex), -1, 0):
        distance = np.abs(poles - rigid[..., np.newaxis])
        nearest = distance <= np.nanmin(
            np.where(np.isnan(distance), np.inf, distance), -1, keepdims=True
        )
        surplus = np.sum(~np.isnan(poles), axis=-1, keepdims=True) > len(names)
        oscillates = rigid.imag[..., np.newaxis] > 0.0
        poles = np.where(nearest & surplus & oscillates, np.nan, poles)
    order = np.argsort(np.where(np.isnan(poles), np.inf, poles.imag), axis=-1)
    poles = np.take_along_axis(poles, order, axis=-1)[..., : len(names)]  # by rising frequency
    rank = np.argsort(np.argsort(np.stack(frequencies, axis=-1), axis=-1), axis=-1)
    return names, np.take_along_axis(poles, rank, axis=-1)
