"""Plant from a state space with named signals, as a finite-element tool or MATLAB writes it.

Poles and residues are those of eigenvectors, l A = p l and A r = p r with l r = 1: the residue of
an output is (c r)(l b). The trim of a wind follows from the coefficients of the moment, which are
given or are the output `moment`; what depends on them says so where they are not known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, ComplexArray, FloatArray, IndexArray
from tvclin.base.cards import card, lines
from tvclin.base.errors import InputError, broadcast, instance, number, one_of, positive
from tvclin.linear.named_systems import (
    check_hidden_modes,
    eigenvectors,
    named_system,
    require_signals,
)
from tvclin.linear.plant import INPUTS, LATERAL_SIGNALS, STATION_RANGE, Plant
from tvclin.linear.system import LinearSystem
from tvclin.numerics.modal import ModalSystem
from tvclin.vehicle.coefficients import Coefficients

if TYPE_CHECKING:
    from tvclin.linear.named_systems import AnySystem

MOMENT = "moment"
"""Output of the angular acceleration [1/s^2], from whose direct terms the coefficients follow."""
_ACCELERATION = "deflection_acceleration"
_LATERAL_OUTPUTS = {"drift_rate": "drift_rate", "acceleration": "lateral_acceleration"}
"""Name of the output of each lateral signal."""
_MEASURED = ("attitude", "attitude_rate", "flight_path_angle", "angle_of_attack")
_MAX_DAMPING = 0.3
"""Largest damping ratio of a pole pair that is a mode with a band of its own."""
_MAX_POLYNOMIAL_ORDER = 8
"""Highest order of a plant that has polynomials: their rounding grows with the order."""
_ZERO_POLE = 1e-12
"""Size of a pole that counts as zero, over the largest pole."""


class SystemPlant(Plant):
    """Plant from a continuous state space or transfer function with named signals.

    Poles, residues, the verdict (4b), the minimum peak, responses, margins and flights take it like
    a `Plant`. Static trim, boundary limits and quantities relative to trim need its coefficients.

    Parameters
    ----------
    system : control.StateSpace or control.TransferFunction
        Inputs deflection and wind [rad]; outputs attitude [rad], attitude_rate [rad/s] and
        angle_of_attack [rad], or flight_path_angle [rad], from which the angle of attack follows
        as attitude - flight_path_angle - wind. Sensors show sensed_attitude and
        sensed_attitude_rate, where it has these outputs. Further outputs may have any name. The
        input deflection_acceleration is that of an engine with inertia, as in `FlexiblePlant`.
        Transfer functions have one denominator.
    coefficients : Coefficients, optional
        Coefficients of the moment, mu_alpha and mu_delta at least. Without them an output moment
        [1/s^2], the angular acceleration, gives them: mu_delta and mu_alpha are minus its direct
        terms from deflection and wind.
    inputs, outputs : sequence of str, optional
        Names of the signals, in place of the system's.

    Raises
    ------
    InputError
        For a missing signal, a sample time, an improper transfer function, sizes that do not fit,
        an attitude, rate or angle that follows the deflection at once, and an unstable mode that
        the deflection does not reach or the attitude does not show.

    Examples
    --------
    >>> import tvclin as tv
    >>> vehicle = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
    >>> plant = tv.linear.SystemPlant(vehicle.ss())
    >>> tv.unstable_modes(plant).poles.round(5)
    array([0.5102 , 0.01285])
    >>> tv.trim_then_hold(plant, tv.TriangularWind(peak=-0.1, duration=8.0), 0.01)
    Traceback (most recent call last):
        ...
    tvclin.base.errors.InputError: this depends on the trim of the wind, ...
    """

    def __init__(
        self,
        system: AnySystem,
        coefficients: Coefficients | None = None,
        *,
        inputs: Sequence[str] | None = None,
        outputs: Sequence[str] | None = None,
    ) -> None:
        """Check a system with named signals and its coefficients, and set the fields.

        `inputs`, `outputs`: names of the signals, in place of the system's.
        """
        named = named_system("plant", system, inputs, outputs)
        if named.period is not None:
            raise InputError(
                f"plant must be continuous; this one has a sample time of {float(named.period):g} s"
            )
        if coefficients is not None:
            instance("coefficients", coefficients, Coefficients, "of mu_alpha and mu_delta")
            broadcast(system=named.batch, coefficients=coefficients.batch)
        title = str(getattr(system, "name", "") or "")
        # "sys[0]" is the name that python-control gives a system without a name
        model = "state space" if not title or title.startswith("sys[") else title
        self._set(_with_angle_of_attack(named), coefficients, model)
        self._check()

    _system: LinearSystem
    _coefficients: Coefficients | None

    __eq__ = object.__eq__
    __hash__ = object.__hash__

    def _set(self, system: LinearSystem, coefficients: Coefficients | None, model: str) -> None:
        """Set the fields of the frozen record; missing coefficients follow from an output moment.

        `system`: system with the signals of a plant, first deflection and wind. The direct terms of
        its output moment, the moment over the inertia [1/s^2], from these two are minus the
        coefficients mu_delta and mu_alpha. `model`: name of the model.
        """
        if coefficients is None and MOMENT in system.outputs:
            row = system.D[..., system.outputs.index(MOMENT), :]
            from_deflection, from_wind = row[..., 0], row[..., 1]
            if not np.all(from_deflection):
                raise InputError(
                    "plant must have a moment that follows the deflection; its output moment does"
                    " not"
                )
            coefficients = Coefficients(mu_alpha=0.0 - from_wind, mu_delta=0.0 - from_deflection)
        A, B, C, D = (np.broadcast_to(m, (*system.batch, *m.shape[-2:])) for m in system.matrices())
        system = replace(system, A=A, B=B, C=C, D=D)
        for name, value in (("_system", system), ("_coefficients", coefficients)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "model", model)

    def _check(self) -> None:
        """Raise `InputError` for an output that follows the deflection at once, or a hidden mode.

        Hidden are unstable modes that the deflection does not reach or the attitude does not show.
        """
        system = self._system
        # attitude, rate, path angle and angle of attack, and attitude and rate of sensors
        names = [name for name in system.outputs if name.removeprefix("sensed_") in _MEASURED]
        for name in names:
            if np.any(system.D[..., system.outputs.index(name), 0]):  # input 0: deflection
                raise InputError(
                    f"{name} of the plant must not follow the deflection at once: feedback of it"
                    " would be an algebraic loop"
                )
        attitude = system.outputs.index("attitude")
        check_hidden_modes(
            "plant",
            self._eigenvectors,
            B=system.B[..., :1],
            C=system.C[..., attitude : attitude + 1, :],
            faults=("the deflection does not reach", "the attitude does not show"),
        )

    def _repr_html_(self) -> str:
        """Return name, number of states and signals as an HTML table."""
        return card("SystemPlant", self._rows())

    def __repr__(self) -> str:
        """Return name, number of states and signals as lines of text."""
        return lines("SystemPlant", self._rows())

    def _rows(self) -> list[tuple[str, Any, str]]:
        """Return name, number of states and signals as rows of a card: label, value and unit."""
        return [
            ("name", self.model, ""),
            ("states", len(self.states), ""),
            ("inputs", ", ".join(self.inputs), ""),
            ("outputs", ", ".join(self.outputs), ""),
        ]

    @property
    def coefficients(self) -> Coefficients:
        """Coefficients of the moment; `InputError` where they are not known."""
        if self._coefficients is None:
            raise InputError(
                "this depends on the trim of the wind, which a plant from a state space does not"
                " have: give its coefficients mu_alpha and mu_delta, or an output moment"
            )
        return self._coefficients

    @property
    def coefficients_known(self) -> bool:
        """Whether the coefficients of the moment are known."""
        return self._coefficients is not None

    @property
    def coordinate_scale(self) -> Any:
        """Trim deflection B per angle of attack, by which flights scale unstable modes.

        The coordinate of one [rad] is recoverable while it is below the deflection limit over |B|.
        B counts as one where the coefficients are not known.
        """
        return self._coefficients.B if self._coefficients is not None else 1.0

    @property
    def is_rigid(self) -> bool:
        """False: the plant may have bending modes, and is analysed by its matrices."""
        return False

    @property
    def has_modes(self) -> bool:
        """Whether it has lightly damped modes, which may have a limit cycle with the nozzle."""
        names, _ = self.named_modes()
        return bool(names)

    @property
    def name(self) -> str:
        """Name of the system."""
        return self.model

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one plant."""
        return self._system.batch

    def cases(self, index: IndexArray | int, shape: tuple[int, ...]) -> SystemPlant:
        """Return the plants at flat positions `index` ``(k,)`` of a batch, as `Plant.cases`."""
        c = self._coefficients
        if c is not None:  # selected by `Plant`, which selects cases of coefficients
            c = Plant(c, "fixed-path").cases(index, shape).coefficients
        return self._changed(self._system.cases(np.asarray(index), shape), c)

    def _changed(self, system: LinearSystem, coefficients: Coefficients | None) -> SystemPlant:
        """Return a plant of this class and model with another system and coefficients, unchecked.

        `__init__`, which checks them, is omitted.
        """
        plant = type(self).__new__(type(self))
        plant._set(system, coefficients, self.model)
        return plant

    def with_effectiveness(self, factor: ArrayLike) -> SystemPlant:
        """Return the plant with `factor` on the forces and moments of the deflection.

        The first columns of B and D are multiplied; the inertia of the engine stays. `InputError`
        for a factor that is not positive.
        """
        multiple, system = positive("factor", factor), self._system
        with np.errstate(over="ignore"):  # an overflow is refused below
            others = [np.ones_like(multiple)] * (len(self.inputs) - 1)
            scale = np.stack([multiple, *others], axis=-1)[..., np.newaxis, :]
            changed = replace(system, B=system.B * scale, D=system.D * scale)
            c = self._coefficients
            moment = None if c is None else c.replace(mu_delta=multiple * np.asarray(c.mu_delta))
        return self._changed(changed, moment)

    @property
    def sensed(self) -> tuple[str, str]:
        """Names of the sensor outputs: attitude and attitude rate."""
        names = ("sensed_attitude", "sensed_attitude_rate")
        return names if set(names) <= set(self.outputs) else ("attitude", "attitude_rate")

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return self._system.inputs

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return self._system.outputs

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return self._system.states

    @property
    def system(self) -> LinearSystem:
        """The plant as a `LinearSystem` with named signals."""
        return self._system

    def lateral_rows(self, signal: str, station: float) -> tuple[FloatArray, FloatArray]:
        """Return the rows of C ``(..., n)`` and D ``(..., inputs)`` of a lateral signal.

        The signal is the output drift_rate [m/s] or lateral_acceleration [m/s^2], at the station of
        its own sensor; without an output drift_rate it is the speed of the coefficients times the
        flight_path_angle. `signal`: "drift_rate" or "acceleration". `station`: position of the
        accelerometer [m], without effect here. `InputError` for an output that the plant does not
        have, and a drift rate that follows the deflection at once.
        """
        name, factor = self._lateral_output(signal, station)
        k = self.outputs.index(name)
        direct = self._system.D[..., k, :]
        # of the deflection (0) and its acceleration (2), not of the wind (1)
        if signal == "drift_rate" and np.any(direct[..., [0, *range(2, len(self.inputs))]]):
            raise InputError("drift_rate of the plant must not follow the deflection at once")
        return factor * self._system.C[..., k, :], factor * direct

    def lateral_numerator(self, signal: str, input: str, station: float) -> FloatArray:
        """Return the numerator from `input` to a lateral signal, highest power of s first.

        Shape ``(..., k)``. `signal`: "drift_rate" [m/s] or "acceleration" [m/s^2]. `station`:
        position of the accelerometer [m], without effect here. `InputError` for an output that the
        plant does not have, and for an order above eight.
        """
        name, factor = self._lateral_output(signal, station)
        return factor * self.numerator(name, input)

    def _lateral_output(self, signal: str, station: float) -> tuple[str, FloatArray]:
        """Return the name of the output from which a lateral signal follows, and its factor.

        The factor is 1 or the speed [m/s], ``(..., 1)``. `signal`: "drift_rate" or "acceleration".
        `station`: position of the accelerometer [m], which is checked. `InputError` for a plant
        without such an output.
        """
        one_of("signal", signal, LATERAL_SIGNALS)
        number("station", station, STATION_RANGE, "m")
        name, c = _LATERAL_OUTPUTS[signal], self._coefficients
        if name in self.outputs:
            return name, np.ones(1)
        speed = np.asarray(0.0 if c is None else c.velocity)[..., np.newaxis]
        if signal == "drift_rate" and "flight_path_angle" in self.outputs and np.all(speed):
            return "flight_path_angle", speed
        raise InputError(f"plant has no output {name}, which the autopilot feeds back")

    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return A, B, C, D with the leading axes of the batch."""
        return self._system.matrices()

    @cached_property
    def _eigenvectors(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Poles p ``(..., n)`` by falling real part, rows l and columns r, ``(..., n, n)``.

        They are eigenvectors of the state matrix A of n states: l A = p l and A r = p r.
        """
        return eigenvectors(self._system.A)

    @cached_property
    def poles(self) -> AnyArray:
        """All poles [1/s] by falling real part, ``(..., order)``; real where all are."""
        poles, _, _ = self._eigenvectors
        return poles.real if not np.any(poles.imag) else poles

    @cached_property
    def _modal_matrices(self) -> tuple[AnyArray, AnyArray]:
        """Gain of each input in each mode ``(..., n, inputs)``, and of each mode in each output.

        With the left and right eigenvectors l and r of a mode, the gains are l B/(l r), and the
        outputs C r, ``(..., n, outputs)``. Both are real where all poles are.
        """
        _, rows, right = self._eigenvectors  # l in rows, r in columns
        with np.errstate(all="ignore"):
            gains = rows @ self._system.B
            gains = gains / np.einsum("...ij,...ji->...i", rows, right)[..., np.newaxis]
            outputs = np.swapaxes(self._system.C @ right, -1, -2)
        real = not np.iscomplexobj(self.poles)
        return (gains.real, outputs.real) if real else (gains, outputs)

    @property
    def modal(self) -> ModalSystem:
        """The plant as a sum of modes and direct terms D; invalid for repeated poles.

        `InputError` for a plant with the inertia of its engine.
        """
        if _ACCELERATION in self.inputs:
            raise InputError(
                "a response takes a deflection without its acceleration; leave the input"
                " deflection_acceleration out of the plant"
            )
        gains, outputs = self._modal_matrices  # of each input in a mode, of a mode in each output
        # the wind in the angle of attack is one of the direct terms
        direct = self._system.D[..., :2]
        return ModalSystem(self.poles, gains, outputs, less_wind=False, direct=direct)

    @property
    def _attitude_residues(self) -> AnyArray:
        """Residues of the attitude at all n poles, for each input, ``(..., n, inputs)``."""
        gains, outputs = self._modal_matrices  # of each input in a mode, of a mode in each output
        return gains * outputs[..., self.outputs.index("attitude"), np.newaxis]

    def attitude_fractions(self, poles: AnyArray) -> tuple[AnyArray, AnyArray, AnyArray]:
        """Return N_deflection(p), N_wind(p) and D'(p) of the attitude at poles, each ``(..., N)``.

        N are the numerators and D the denominator, up to a factor: the residues and ones. `poles`:
        poles of the plant [1/s], ``(..., N)``; NaN stays NaN.
        """
        residues = self._attitude_residues  # from deflection, wind, and with an engine delta''
        if _ACCELERATION in self.inputs:  # delta'' = p^2 delta in the mode e^(p t)
            inertia = residues[..., 2] * self.poles**2
            residues = np.stack([residues[..., 0] + inertia, residues[..., 1]], axis=-1)
        distance = np.abs(self.poles[..., np.newaxis, :] - poles[..., np.newaxis])
        nearest = np.argmin(np.where(np.isnan(distance), np.inf, distance), axis=-1)
        at_poles = np.take_along_axis(residues, nearest[..., np.newaxis], axis=-2)
        with np.errstate(invalid="ignore"):
            at_poles = np.where(np.isnan(poles)[..., np.newaxis], np.nan, at_poles)
        if not np.iscomplexobj(poles):
            at_poles = np.real(at_poles)
        return at_poles[..., 0], at_poles[..., 1], np.ones_like(poles)

    def low_order_terms(self) -> list[FloatArray]:
        """Return the coefficients of s and 1, ``(..., 2)``, of D, N_deflection and N_wind.

        D is the denominator of the attitude, N its numerators, up to a factor: D is one, or s with
        a pole at zero, or zero with several. N/D is the series in s of the sum of residue/(s -
        pole) and the direct term: the poles at zero give residue/s, each other pole -residue/pole -
        s residue/pole^2. A pole at zero counts only where its residue is not zero.
        """
        residues = self._attitude_residues[..., :2]  # at n poles, from deflection and wind
        poles = self.poles[..., np.newaxis]
        size = np.abs(self.poles).max(axis=-1, initial=0.0)[..., np.newaxis, np.newaxis]
        at_zero = np.abs(poles) <= _ZERO_POLE * size
        away = np.where(at_zero, 1.0, poles)
        # coefficients of 1/s, 1 and s in the series, for each input, ``(..., 2)``
        inverse = np.real(np.where(at_zero, residues, 0.0).sum(axis=-2))
        sizes = np.where(at_zero, 0.0, np.abs(residues)).sum(axis=-2)
        inverse = np.where(np.abs(inverse) <= _ZERO_POLE * sizes, 0.0, inverse)
        constant = np.real(np.where(at_zero, 0.0, -residues / away).sum(axis=-2))
        constant = constant + self._system.D[..., self.outputs.index("attitude"), :2]
        slope = np.real(np.where(at_zero, 0.0, -residues / away**2).sum(axis=-2))
        integrates = np.any(inverse, axis=-1)
        repeated = at_zero.sum(axis=(-2, -1)) > 1
        denominator = np.stack(
            [np.where(integrates & ~repeated, 1.0, 0.0), np.where(integrates, 0.0, 1.0)], axis=-1
        )
        numerators = np.where(  # (..., input, 2)
            integrates[..., np.newaxis, np.newaxis],
            np.stack([constant, inverse], axis=-1),
            np.stack([slope, constant], axis=-1),
        )
        return [denominator, *np.moveaxis(numerators, -2, 0)]

    @cached_property
    def denominator(self) -> FloatArray:
        """Characteristic polynomial, ``(..., order + 1)``, highest power first.

        `InputError` for a plant of an order above eight.
        """
        order = len(self.states)
        if order > _MAX_POLYNOMIAL_ORDER:  # whose polynomials lose their digits
            raise InputError(
                f"exact trim and transfer functions are for plants of order"
                f" {_MAX_POLYNOMIAL_ORDER} or less; this one is of order {order}: take"
                " Plant.from_coefficients(plant.coefficients) for trim, and ss() for the rest"
            )
        polynomial = np.ones((*self.batch, 1), complex)
        poles, _, _ = self._eigenvectors
        for pole in np.moveaxis(poles, -1, 0):
            # times (s - pole): a zero behind, less the pole times the coefficient before
            polynomial = np.pad(polynomial, [(0, 0)] * (polynomial.ndim - 1) + [(0, 1)])
            polynomial[..., 1:] -= pole[..., np.newaxis] * polynomial[..., :-1]
        return np.real(polynomial)

    def numerator(self, output: str, input: str) -> FloatArray:
        """Return the numerator from `input` to `output`, over the common denominator.

        It follows from the Markov parameters D, C B, C A B, ..., the coefficients of the transfer
        function in 1/s: times the denominator they are the numerator. Shape ``(..., k)``, highest
        power first, without leading zeros. `InputError` for an output or an input that the plant
        does not have, and a plant of an order above eight.
        """
        one_of("output", output, self.outputs)
        one_of("input", input, self.inputs)
        A, B, C, D = self._system.select((input,), (output,)).matrices()
        denominator, column, markov = self.denominator, B, [D[..., 0, 0]]
        for _ in range(denominator.shape[-1] - 1):
            markov.append((C @ column)[..., 0, 0])
            column = A @ column
        products = [  # the coefficients of the product, highest power first
            sum((denominator[..., k] * markov[i - k] for k in range(i + 1)), np.zeros(()))
            for i in range(denominator.shape[-1])
        ]
        terms = np.stack(products, axis=-1)
        first = next((k for k in range(terms.shape[-1] - 1) if np.any(terms[..., k])), -1)
        return terms[..., first:]

    @property
    def trim_filter(self) -> tuple[Any, Any, Any]:
        """Coefficients b1, b2 [1/s] and q [1/s^2] of the filter from a wind to its trim.

        The filter is -B (s^2 + b2 s + q)/(s^2 + b1 s + q), with the given coefficients and the trim
        deflection B per angle of attack; without an output flight_path_angle they are zero, and
        trim is -B times the wind.
        """
        if "flight_path_angle" not in self.outputs:
            return 0.0, 0.0, 0.0
        return super().trim_filter

    def named_modes(self) -> tuple[tuple[str, ...], ComplexArray]:
        """Return the names of lightly damped modes, and their poles with Im > 0 [1/s].

        They are "mode 1", .. by rising frequency, of a damping ratio below 0.3; poles ``(..., n)``,
        NaN where a plant of a batch has fewer.
        """
        poles, _, _ = self._eigenvectors
        with np.errstate(invalid="ignore", divide="ignore"):
            light = (poles.imag > 0.0) & (np.abs(poles.real) < _MAX_DAMPING * np.abs(poles))
        order = np.argsort(np.where(light, np.abs(poles), np.inf), axis=-1)
        count = int(light.sum(axis=-1).max(initial=0))
        modes = np.take_along_axis(np.where(light, poles, np.nan), order, axis=-1)[..., :count]
        return tuple(f"mode {k}" for k in range(1, count + 1)), modes


def _with_angle_of_attack(system: LinearSystem) -> LinearSystem:
    """Return the system with deflection and wind as first inputs, and an angle of attack.

    Where the system has no output angle_of_attack, it is attitude - flight_path_angle - wind.
    `InputError` for a missing signal, and for an input that a plant does not have; the third may be
    deflection_acceleration.
    """
    remedy = "; name them with inputs=, or in a file by InputName and OutputName"
    require_signals("plant", "input", INPUTS, system.inputs, remedy)
    unknown = [name for name in system.inputs if name not in (*INPUTS, _ACCELERATION)]
    if unknown:
        raise InputError(
            f"plant has an input {unknown[0]}, which nothing drives: it may have deflection, wind"
            f" and {_ACCELERATION}"
        )
    attitude, rate, path, angle = _MEASURED
    remedy = "; name them with outputs="
    require_signals("plant", "output", (attitude, rate), system.outputs, remedy)
    further = tuple(name for name in system.inputs if name == _ACCELERATION)
    system = system.select((*INPUTS, *further), system.outputs)
    if angle in system.outputs:
        return system
    remedy = ", nor angle_of_attack: one of the two is needed"
    require_signals("plant", "output", (path,), system.outputs, remedy)
    row = np.zeros(len(system.outputs))
    row[system.outputs.index(attitude)], row[system.outputs.index(path)] = 1.0, -1.0
    wind = np.eye(len(system.inputs))[1]  # the second input
    return system.with_outputs({angle: (row @ system.C, row @ system.D - wind)})
