"""Four linear models of the attitude, as transfer functions and in state space.

    model               denominator, d being the damping                   report, where d = 0
    fixed-path          s^2 + d s - beta^2                                 eq (5)
    drift               s (s^2 + d s - beta^2)                             eqs (14), (B8)
    drift-exact         s^3 + (C1 + d) s^2 + (C1 d - beta^2) s + C2        eq (B7)
    drift-and-speed     s^4 + (C1 + d) s^3 + (q + C1 d - beta^2) s^2       from (B5)
                            + (C2 + q d) s - q beta^2

Inputs are the deflection and the wind angle of attack; outputs are the attitude, its rate, the
flight path angle (where the model has one) and the angle of attack. Everything is a deviation
from the nominal flight. `Plant.tf` and `Plant.ss` convert to python-control.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.base.cards import card_rows, lines
from tvclin.base.errors import InputError, between, instance, number, one_of, positive
from tvclin.base.public_names import Hinted
from tvclin.linear.system import LinearSystem
from tvclin.numerics import polynomials
from tvclin.numerics.modal import ModalSystem
from tvclin.vehicle.coefficients import NUMBERS, Coefficients
from tvclin.vehicle.linear_vehicle import FIXED_PATH, AnyVehicle, LinearVehicle, coefficients_of

if TYPE_CHECKING:
    import control

DEFAULT_MODEL = "drift-exact"
"""Default model: the exact flight path, without an approximation."""
MODELS = (FIXED_PATH, "drift", DEFAULT_MODEL, "drift-and-speed")
ONE_POLE = (FIXED_PATH, "drift")
"""Models that omit the slow mode of the flight path."""
INPUTS = ("deflection", "wind")
PLANT_HINT = "see Plant.from_vehicle; a FlexiblePlant has .rigid, and .shift() says what that omits"
"""Hint on making a `Plant`, for messages where a flexible plant has no answer."""
LATERAL_SIGNALS = ("drift_rate", "acceleration")
"""Signals of `lateral_rows`."""
STATION_RANGE = between(-1e9, 1e9)
"""Check of the station of an accelerometer [m]."""
_OUTPUTS = ("attitude", "attitude_rate", "flight_path_angle", "angle_of_attack")


def available_models(coefficients: Coefficients) -> list[str]:
    """Return names of the models of coefficients: "drift" only with a moment of the air."""
    instance("coefficients", coefficients, Coefficients, "see Coefficients.from_vehicle")
    without_moment = np.any(np.asarray(coefficients.mu_alpha) == 0.0)
    return [name for name in MODELS if name != "drift" or not without_moment]


def default_model(vehicle: AnyVehicle | Coefficients) -> str:
    """Return the default model of a vehicle, or "fixed-path" for an unknown flight path.

    It is `DEFAULT_MODEL`, "drift-exact". The path of `Coefficients` is unknown where its own
    coefficients, C1, C2, b1, b2 and q of eq (B7), are all zero.
    """
    if isinstance(vehicle, LinearVehicle):
        return DEFAULT_MODEL if vehicle.path_known else FIXED_PATH
    if isinstance(vehicle, Coefficients):
        path = (vehicle.C1, vehicle.C2, vehicle.b1, vehicle.b2, vehicle.q)
        return DEFAULT_MODEL if any(np.any(number) for number in path) else FIXED_PATH
    return DEFAULT_MODEL


def flexible_model(structure: object, model: str) -> str:
    """Return the `model` by name, but "drift-exact" in place of "drift" with a structure.

    `structure`: of the vehicle; None for a rigid one.
    """
    return DEFAULT_MODEL if model == "drift" and structure is not None else model


def models_of(vehicle: AnyVehicle) -> list[str]:
    """Return names of the models that exist for the known data of a vehicle, linear or whole."""
    if isinstance(vehicle, LinearVehicle) and not vehicle.path_known:
        return [FIXED_PATH]
    return available_models(coefficients_of(vehicle))


class WithCoefficients(Hinted):
    """Properties of a plant that follow from the coefficients of its rigid vehicle."""

    if TYPE_CHECKING:

        @property
        def coefficients(self) -> Coefficients:
            """Coefficients of the rigid vehicle."""

    @property
    def name(self) -> str:
        """Name of the vehicle; empty without one."""
        return self.coefficients.name

    @property
    def coordinate_scale(self) -> Any:
        """Trim deflection B per angle of attack, by which flights scale unstable modes.

        The coordinate of one [rad] is recoverable while it is below the deflection limit over |B|.
        """
        return self.coefficients.B

    @property
    def coefficients_known(self) -> bool:
        """Whether the coefficients of the moment are known; not of every `SystemPlant`."""
        return True


@dataclass(frozen=True)
class Plant(WithCoefficients):
    """Linear model of a vehicle, or of a batch of vehicles.

    Make it with `from_coefficients` or `from_vehicle`.

    Attributes
    ----------
    coefficients : Coefficients
        Coefficients of the model.
    model : str
        "fixed-path", "drift", "drift-exact" or "drift-and-speed".
    """

    coefficients: Coefficients
    model: str

    def __post_init__(self) -> None:
        """Check the fields."""
        instance("coefficients", self.coefficients, Coefficients, "see Coefficients.from_vehicle")
        one_of("model", self.model, MODELS)
        if self.model == "drift" and np.any(np.asarray(self.coefficients.mu_alpha) == 0.0):
            raise InputError(
                'model "drift" needs an aerodynamic moment, mu_alpha other than zero; use'
                ' "fixed-path", which is then exact'
            )

    @classmethod
    def from_coefficients(cls, coefficients: Coefficients, model: str | None = None) -> Self:
        """Return the plant of coefficients and a model by name, see `Plant`.

        The default model is `default_model(coefficients)`.
        """
        return cls(coefficients, default_model(coefficients) if model is None else model)

    @classmethod
    def from_vehicle(
        cls, vehicle: AnyVehicle, model: str | None = None, plane: str = "pitch"
    ) -> Self:
        """Return the plant of a vehicle in the pitch or the yaw plane.

        The default model is `default_model(vehicle)`. A `LinearVehicle` has the same coefficients
        in either plane.
        """
        model = default_model(vehicle) if model is None else model
        if isinstance(vehicle, LinearVehicle):
            return cls(vehicle.coefficients_for(one_of("model", model, MODELS)), model)
        return cls(Coefficients.from_vehicle(vehicle, plane), model)

    def _repr_html_(self) -> str:
        """Return the coefficients as an HTML table, with the model in its title."""
        return self.coefficients._repr_html_().replace("Coefficients", f"Plant, {self.model}", 1)

    def __repr__(self) -> str:
        """Return the coefficients as lines of text, with the model in the first."""
        c = self.coefficients
        return lines(f"Plant, {self.model} {c.name}".strip(), card_rows(c))

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape of the batch; ``()`` for one vehicle."""
        return self.coefficients.batch

    def case(self, index: int, shape: tuple[int, ...]) -> Plant:
        """Return the plant at the flat position `index` of a batch of the shape `shape`.

        The batch of the plant broadcasts to this shape.
        """
        return self.cases(index, shape)

    def cases(self, index: IndexArray | int, shape: tuple[int, ...]) -> Plant:
        """Return the plants at flat positions `index` ``(k,)`` of a batch of the shape `shape`.

        The batch of the plant broadcasts to this shape. A scalar position returns a single plant.
        """
        numbers = {
            name: np.broadcast_to(getattr(self.coefficients, name), shape).ravel()[index]
            for name in NUMBERS
        }
        return Plant(Coefficients(**numbers, name=self.coefficients.name), self.model)

    @property
    def rigid(self) -> Plant:
        """The plant itself; for a `FlexiblePlant`, the plant without its structure."""
        return self

    @property
    def structure(self) -> None:
        """None; a `FlexiblePlant` has a structure."""

    @property
    def is_rigid(self) -> bool:
        """Whether the plant is a rigid vehicle, whose transfer functions are polynomials."""
        return True

    @property
    def has_modes(self) -> bool:
        """False: a rigid plant has no lightly damped modes."""
        return False

    @property
    def sensed(self) -> tuple[str, str]:
        """Names of the sensor outputs: attitude and attitude rate."""
        return "attitude", "attitude_rate"

    def with_effectiveness(self, factor: ArrayLike) -> Plant:
        """Return the plant with control moment and control force multiplied by `factor`.

        Only mu_delta, the moment per deflection over the inertia, is multiplied: the control force
        T is proportional to it in the plant, by T/(m V_n) = (b1 - C1) mu_delta/mu_alpha, eq (B7).
        `InputError` for a factor that is not positive.
        """
        c, multiple = self.coefficients, positive("factor", factor)
        with np.errstate(over="ignore"):  # an overflow is refused below
            moment = multiple * np.asarray(c.mu_delta)
        return Plant(c.replace(mu_delta=moment), self.model)

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return INPUTS

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs; the fixed-path model has no flight path angle."""
        path = () if self.model == "fixed-path" else ("flight_path_angle",)
        return ("attitude", "attitude_rate", *path, "angle_of_attack")

    @cached_property
    def denominator(self) -> FloatArray:
        """Characteristic polynomial, ``(..., order + 1)``, highest power first.

        Of the coefficients mu_alpha = beta^2 [1/s^2], damping d [1/s], C1 [1/s] and C2 [1/s^3] of
        eq (B7), and the gravity term q = (g cos(Theta_n)/V_n)^2 [1/s^2], with attitude Theta_n and
        speed V_n of the nominal flight.
        """
        c, d = self.coefficients, self.coefficients.damping
        stiffness = c.C1 * d - c.mu_alpha
        polynomials_by_model = {
            "fixed-path": (1.0, d, -c.mu_alpha),
            "drift": (1.0, d, -c.mu_alpha, 0.0),
            "drift-exact": (1.0, c.C1 + d, stiffness, c.C2),
            "drift-and-speed": (1.0, c.C1 + d, c.q + stiffness, c.C2 + c.q * d, -c.q * c.mu_alpha),
        }
        return self._stack(polynomials_by_model[self.model])

    def numerator(self, output: str, input: str) -> FloatArray:
        """Return the numerator from `input` to `output`, over the common denominator.

        Shape ``(..., k)``, coefficients with the highest power of s first. `output`, `input`: names
        of the signals, of `outputs` and of `inputs`; `InputError` for one that the model does not
        have.
        """
        one_of("output", output, _OUTPUTS)
        if output not in self.outputs:
            raise InputError(
                f'model "{self.model}" has no flight_path_angle; {", ".join(MODELS[1:])} have it'
            )
        one_of("input", input, INPUTS)
        if output == "attitude":
            return self._attitude(input)
        if output == "attitude_rate":
            return polynomials.times_variable(self._attitude(input))
        if output == "flight_path_angle":
            return self._flight_path(input)
        # angle of attack = attitude - flight path angle - wind
        angle = self._attitude(input)
        if self.model != "fixed-path":
            angle = polynomials.add(angle, -self._flight_path(input))
        return polynomials.add(angle, -self.denominator) if input == "wind" else angle

    @cached_property
    def poles(self) -> AnyArray:
        """All poles [1/s] by falling real part, ``(..., order)``; real where all are."""
        poles = polynomials.roots(self.denominator)
        order = np.lexsort((-np.imag(poles), -np.real(poles)), axis=-1)
        return np.take_along_axis(poles, order, axis=-1)

    def attitude_fractions(self, poles: AnyArray) -> tuple[AnyArray, AnyArray, AnyArray]:
        """Return N_deflection(p), N_wind(p) of the attitude and D'(p) at poles, each ``(..., N)``.

        N are the numerators, from deflection and wind, and D' is the slope of the denominator.
        `poles`: poles of the plant [1/s], ``(..., N)``; NaN stays NaN.
        """
        from_deflection, from_wind = (
            polynomials.value(self.numerator("attitude", i), poles) for i in INPUTS
        )
        slope = polynomials.value(polynomials.derivative(self.denominator), poles)
        return from_deflection, from_wind, slope

    def low_order_terms(self) -> list[FloatArray]:
        """Return D, N_deflection and N_wind of the attitude without a common zero at s = 0.

        D is the denominator, N the numerators, ``(..., k)`` each, highest power of s first. Where s
        divides all of them (as for "drift-and-speed" in yaw) they are divided by it: the last
        coefficient, which is zero, moves to the front.
        """
        terms = [self.denominator, *(self.numerator("attitude", i) for i in INPUTS)]
        common = np.all([term[..., -1] == 0.0 for term in terms], axis=0)
        common = common[..., np.newaxis]
        return [np.where(common, np.roll(term, 1, axis=-1), term) for term in terms]

    @cached_property
    def modal(self) -> ModalSystem:
        """Plant as a sum of modes e^(p t); gains are NaN where poles are repeated.

        The gains are residues of the attitude; the outputs of a mode are per attitude.
        """
        poles = polynomials.roots(self.denominator)
        # from deflection and from wind; slope of the denominator
        *numerators, slope = self.attitude_fractions(poles)
        slope = np.where(slope == 0.0, np.nan, slope)
        gains = [numerator / slope for numerator in numerators]
        outputs = [np.ones_like(poles), poles]  # attitude and its rate
        if "flight_path_angle" in self.outputs:
            # the equation gamma' + h gamma = a theta + .. of the flight path has in a free mode the
            # solution gamma = p a/(p (p + h) + q) theta, q being the gravity term of the speed
            gravity_term = self.coefficients.q if self.model == "drift-and-speed" else 0.0
            a, h, *_ = self._path
            a, h, q = (np.asarray(term)[..., np.newaxis] for term in (a, h, gravity_term))
            divisor = poles * (poles + h) + q
            constant = divisor == 0.0  # p = 0 in the drift model: gamma equals theta
            path = np.where(constant, 1.0, poles * a / np.where(constant, 1.0, divisor))
            outputs += [path, 1.0 - path]  # and the angle of attack, but for the wind
        else:  # a fixed path: the angle of attack is the attitude, but for the wind
            outputs.append(outputs[0])
        return ModalSystem(
            poles, gains=np.stack(gains, axis=-1), outputs=np.stack(outputs, axis=-1)
        )

    @property
    def trim_filter(self) -> tuple[Any, Any, Any]:
        """Coefficients b1, b2 [1/s] and q [1/s^2] of the filter from a wind to its trim.

        The filter, eq before (17), is -B (s^2 + b2 s + q)/(s^2 + b1 s + q), the ratio of the
        numerators of wind and deflection to the attitude, with the trim deflection B per angle of
        attack; in the models without q it is -B (s + b2)/(s + b1), and on a fixed path -B, with
        coefficients of zero.
        """
        c = self.coefficients
        if self.model == "fixed-path":
            return 0.0, 0.0, 0.0
        return c.b1, c.b2, c.q if self.model == "drift-and-speed" else 0.0

    def tf(self, output: str = "attitude", input: str = "deflection") -> control.TransferFunction:
        """Return a transfer function as `control.TransferFunction`.

        From the deflection to the attitude it is -(beta^2/B)/(s^2 - beta^2) for eq (5) and
        -(beta^2/B)(s + b1)/(s (s^2 - beta^2)) for eq (B8), without damping: unstable pole beta and
        b1 of the flight path [1/s], trim deflection B per angle of attack. Ask for one pair of
        signals at a time: sums of transfer functions of one plant repeat its poles, `ss` does not.
        `output`, `input`: names of the signals, of `outputs` and of `inputs`. `InputError` for a
        batch, and for signals that the model does not have.
        """
        import control

        if self.batch:
            raise InputError(
                f"tf() is for one vehicle; this plant is a batch of shape {self.batch} (use"
                " denominator and numerator())"
            )
        numerator = np.trim_zeros(self.numerator(output, input), "f")
        return control.TransferFunction(
            numerator if numerator.size else [0.0],
            self.denominator,
            dt=0,  # continuous
            name=f"{self.model}: {input} to {output}",
            inputs=[input],
            outputs=[output],
        )

    def ss(self) -> control.StateSpace:
        """Return the whole plant as `control.StateSpace` with named signals.

        Inputs deflection and wind [rad]; outputs as `outputs` [rad, rad/s]. The states are the
        attitude, its rate, the flight path angle, and in "drift-and-speed" the change of speed over
        the nominal speed, V/V_n. `InputError` for a batch.
        """
        return self.system.to_control(self.model)

    @property
    def system(self) -> LinearSystem:
        """The plant as a `LinearSystem` with named signals."""
        return LinearSystem(*self.matrices(), self.inputs, self.outputs, self.states)

    def lateral_rows(self, signal: str, station: float) -> tuple[FloatArray, FloatArray]:
        """Return the rows of C ``(..., n)`` and D ``(..., inputs)`` of a lateral signal.

        `signal`: "drift_rate", the velocity normal to the nominal path, V gamma [m/s]; or
        "acceleration", which a body-mounted accelerometer measures, (N alpha + T_c delta)/m + x
        theta'' [m/s^2]. `station`: position x of the accelerometer ahead of the centre of gravity
        [m]. N, T_c: normal force per angle of attack and control thrust. `InputError` for
        coefficients without velocity, a model without flight path angle (drift rate), and a vehicle
        with mu_alpha = 0.
        """
        station = number("station", station, STATION_RANGE, "m")
        A, B, C, D = self.matrices()
        speed = self._velocity(signal)
        if signal == "drift_rate":
            return speed * C[..., 2, :], speed * D[..., 2, :]  # output 2: flight path angle
        normal, thrust = (speed * force for force in self._normal_forces)  # N/m, T_c/m [m/s^2]
        rate, alpha, deflection = 1, -1, 0  # of the states, the outputs and the inputs
        direct = normal * D[..., alpha, :] + station * B[..., rate, :]
        direct[..., deflection] += thrust[..., 0]
        return normal * C[..., alpha, :] + station * A[..., rate, :], direct

    def lateral_numerator(self, signal: str, input: str, station: float) -> FloatArray:
        """Return the numerator from `input` to a lateral signal, highest power of s first.

        Shape ``(..., k)``. `signal`: "drift_rate" [m/s] or "acceleration" [m/s^2]. `input`:
        "deflection" or "wind". `station`: position x of the accelerometer ahead of the centre of
        gravity [m]. `InputError` for a signal that the model or the coefficients do not have.
        """
        station = number("station", station, STATION_RANGE, "m")
        one_of("input", input, INPUTS)
        speed = self._velocity(signal)
        if signal == "drift_rate":
            return speed * self.numerator("flight_path_angle", input)
        # (N alpha + T_c delta)/m + x theta'', with theta'' = s^2 theta; N/m and T_c/m [m/s^2] are
        # accelerations by the normal force per angle of attack, and by the control thrust
        normal, thrust = (speed * force for force in self._normal_forces)
        forces = normal * self.numerator("angle_of_attack", input)
        if input == "deflection":
            forces = polynomials.add(forces, thrust * self.denominator)
        rotation = polynomials.times_variable(self._attitude(input), 2)  # numerator of theta''
        return polynomials.add(forces, station * rotation)

    def _velocity(self, signal: str) -> FloatArray:
        """Return the speed V of the vehicle [m/s], ``(..., 1)``, on which a lateral signal depends.

        `signal`: "drift_rate" or "acceleration". `InputError` for coefficients without a speed, and
        for a drift rate in a model without flight path angle.
        """
        one_of("signal", signal, LATERAL_SIGNALS)
        if signal == "drift_rate" and self.model == "fixed-path":
            raise InputError(
                f'model "fixed-path" has no lateral drift; {", ".join(MODELS[1:])} have it'
            )
        speed = np.asarray(self.coefficients.velocity)
        if np.any(speed == 0.0):
            raise InputError(
                "lateral drift and acceleration need the speed of the vehicle; give velocity to its"
                " coefficients"
            )
        return speed[..., np.newaxis]

    @property
    def _normal_forces(self) -> tuple[FloatArray, FloatArray]:
        """N/(m V) and T_c/(m V) [1/s], ``(..., 1)``: forces normal to the body per angle.

        N is the normal force per angle of attack and T_c the control force per deflection, both in
        N/rad, m the mass and V the speed. From the coefficients of eq (B7): N/(m V) = C1 - b2, and
        T_c/(m V) = (b1 - C1)/B. `InputError` for mu_alpha = 0, where B is zero.
        """
        c = self.coefficients
        if np.any(np.asarray(c.mu_alpha) == 0.0):
            raise InputError(
                "the lateral acceleration does not follow from the coefficients of a vehicle with"
                " mu_alpha = 0; give it an aerodynamic_arm other than zero"
            )
        normal, thrust = np.asarray(c.C1 - c.b2), np.asarray((c.b1 - c.C1) / c.B)
        return normal[..., np.newaxis], thrust[..., np.newaxis]

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states, as many of these four as the order of the model."""
        names = ("attitude", "attitude_rate", "flight_path_angle", "relative_speed")
        return names[: self.denominator.shape[-1] - 1]

    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return A, B, C, D in the order of `states`, `inputs` and `outputs`, with the batch first.

        Notes
        -----
        For attitude theta, path angle gamma, wind alpha_w and deflection delta, with the report's
        coefficients C1, b1, b2 [1/s], C2 [1/s^3] and B = mu_alpha/mu_delta (`Coefficients`; the mu
        are moments over the inertia per angle of attack and per deflection),
        theta'' = mu_alpha (theta - gamma - alpha_w) - mu_delta delta - damping theta', and
        gamma' = (C1 + w) theta - C1 gamma + d delta - n alpha_w (+ sqrt(q) V/V_n), with
        w = g sin(Theta_n)/V_n = C2/mu_alpha, d = T/(m V_n) = (b1 - C1)/B,
        n = N/(m V_n) = C1 - b2 and q = (g cos(Theta_n)/V_n)^2; in the drift model
        gamma' = (b1/B) delta + b2 alpha_w instead. "drift-and-speed" has the relative speed V/V_n
        as state, with (V/V_n)' = -sqrt(q) gamma.
        """
        c, order = self.coefficients, self.denominator.shape[-1] - 1
        A, B = np.zeros((*self.batch, order, order)), np.zeros((*self.batch, order, 2))
        # rows of A and B: attitude, its rate, flight path angle, relative speed; inputs 0 and 1:
        # deflection and wind
        A[..., 0, 1] = 1.0
        A[..., 1, 0], A[..., 1, 1] = c.mu_alpha, 0.0 - np.asarray(c.damping)
        B[..., 1, 0], B[..., 1, 1] = -c.mu_delta, -c.mu_alpha
        if order > 2:
            A[..., 1, 2] = -c.mu_alpha
            a, h, d, w = self._path  # gamma' + h gamma = a theta + d delta - w alpha_w
            A[..., 2, 0], A[..., 2, 2] = a, -h
            B[..., 2, 0], B[..., 2, 1] = d, -w
        if order > 3:
            A[..., 2, 3] = np.sqrt(c.q)
            A[..., 3, 2] = -np.sqrt(c.q)
        C = np.zeros((*self.batch, len(self.outputs), order))
        C[..., :-1, : len(self.outputs) - 1] = np.eye(len(self.outputs) - 1)
        C[..., -1, 0] = 1.0  # angle of attack, theta - gamma - alpha_w
        if order > 2:
            C[..., -1, 2] = -1.0
        D = np.zeros((*self.batch, len(self.outputs), 2))
        D[..., -1, 1] = -1.0
        return A, B, C, D

    def _attitude(self, input: str) -> FloatArray:
        """Return the numerator from `input` to the attitude, ``(..., k)``, highest power first.

        It is -mu_delta (s + b1) from the deflection and -mu_alpha (s + b2) from the wind, eq (B7),
        with mu the moments over the inertia per angle: both pitch the nose down. On a fixed path
        the zero is missing, and in "drift-and-speed" the factor is s^2 + b s + q, with the gravity
        term q = (g cos(Theta_n)/V_n)^2 [1/s^2] for both.
        """
        c = self.coefficients
        gain, zero = (c.mu_delta, c.b1) if input == "deflection" else (c.mu_alpha, c.b2)
        factors: dict[str, tuple[Any, ...]] = {
            "fixed-path": (1.0,),
            "drift": (1.0, zero),
            "drift-exact": (1.0, zero),
            "drift-and-speed": (1.0, zero, c.q),
        }
        return self._stack(factors[self.model]) * -np.asarray(gain)[..., np.newaxis]

    def _flight_path(self, input: str) -> FloatArray:
        """Return the numerator from `input` to the flight path angle, highest power of s first.

        gamma' + h gamma = a theta + d delta - w alpha_w, with the model's coefficients a, h, d and
        w [1/s], is put into theta'' = mu_alpha alpha - mu_delta delta - damping theta', the moment
        equation, with alpha = theta - gamma - alpha_w, and solved for gamma.
        """
        c, (a, _, d, w) = self.coefficients, self._path
        if input == "deflection":
            terms = (d, c.damping * d, -c.mu_alpha * d - a * c.mu_delta)
        else:
            terms = (-w, -c.damping * w, c.mu_alpha * (w - a))
        numerator = self._stack(terms)
        # the relative speed of "drift-and-speed" adds a factor s
        return polynomials.times_variable(numerator, int(self.model == "drift-and-speed"))

    @property
    def _path(self) -> tuple[Any, Any, Any, Any]:
        """Coefficients a, h, d, w [1/s] of gamma' + h gamma = a theta + d delta - w alpha_w.

        Equation of the flight path angle gamma, with attitude theta and deflection delta: eq (B7),
        in the model "drift" eq (B8). `InputError` for no aerodynamic moment, mu_alpha = 0.
        """
        c = self.coefficients
        if self.model == "drift":
            return 0.0, 0.0, c.b1 / c.B, -c.b2
        if np.any(np.asarray(c.mu_alpha) == 0.0):
            raise InputError(
                "the flight path does not follow from the coefficients of a vehicle with mu_alpha"
                ' = 0; use model "fixed-path" or an aerodynamic_arm other than zero'
            )
        gravity = c.C2 / c.mu_alpha  # g sin(Theta_n)/V_n
        return c.C1 + gravity, c.C1, (c.b1 - c.C1) / c.B, c.C1 - c.b2

    def _stack(self, polynomial: tuple[Any, ...]) -> FloatArray:
        """Return k coefficients, each a number or of the batch, as one array ``(*batch, k)``."""
        columns = [np.broadcast_to(np.asarray(p, float), self.batch) for p in polynomial]
        return np.stack(columns, axis=-1)
