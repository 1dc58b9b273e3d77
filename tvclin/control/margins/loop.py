"""A loop with margins: polynomials or state space with a delay, and sampled loops.

L(s) = numerator(s)/denominator(s) e^(-s delay), or C (s I - A)^-1 B e^(-s delay); the closed loop
is 1 + L = 0. A `SampledLoop` has its matrices in the w plane, z = (1 + w h/2)/(1 - w h/2), and
gives its margins in the s plane.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, BoolArray, ComplexArray, FloatArray, IndexArray
from tvclin.base.errors import InputError, broadcast, finite, flag, nonnegative, within
from tvclin.linear.system import delay_parts
from tvclin.numerics.loop_margins import LoopAnalysis, analyse_loops
from tvclin.numerics.loops import AnyLoop, Rational, StateLoop, rightmost_poles

if TYPE_CHECKING:
    import control


_FASTEST = 1e15
"""Frequencies beyond this [rad/s] would overflow in polynomials."""
_LARGEST = 1e60
"""Of what a loop takes in and gives out; its squares must not overflow."""


@dataclass(frozen=True, eq=False)
class Loop:
    """One loop L(s) = numerator(s)/denominator(s) e^(-s delay), or a batch of them.

    The closed loop is 1 + L = 0. The delay is exact wherever a loop is looked at. Of high order, or
    with modes that lie close together, take matrices: `from_system` or `from_matrices`.

    Parameters
    ----------
    numerator, denominator : array_like
        Polynomial coefficients, highest power first, ``(..., m)`` and ``(..., n)``; the leading
        axes broadcast. The denominator is of higher degree.
    delay : array_like
        Delay [s], ``(...)``.

    Attributes
    ----------
    form : Rational or StateLoop
        The loops on one axis, which answer what margins ask.
    batch : tuple of int
        Shape of the batch; ``()`` for one loop.

    Raises
    ------
    InputError
        For numbers that are not finite, a delay below zero, a denominator that begins with zero,
        and an algebraic loop: a numerator of the same degree as the denominator, or higher.
    """

    form: AnyLoop
    batch: tuple[int, ...]

    def __init__(
        self, numerator: ArrayLike, denominator: ArrayLike, delay: ArrayLike = 0.0
    ) -> None:
        above = np.atleast_1d(finite("numerator", numerator))
        below = np.atleast_1d(finite("denominator", denominator))
        late = nonnegative("delay", delay, "s")
        if not below.shape[-1]:
            raise InputError("denominator must have a coefficient")
        if np.any(below[..., 0] == 0.0):
            raise InputError("denominator must not begin with a zero")
        while above.shape[-1] > 1 and not np.any(above[..., 0]):
            above = above[..., 1:]
        if above.shape[-1] >= below.shape[-1]:
            raise InputError(
                "this is an algebraic loop: its command feeds back without lag (numerator of degree"
                f" {above.shape[-1] - 1} over {below.shape[-1] - 1}); put an actuator into it"
            )
        shape = broadcast(
            numerator=above.shape[:-1], denominator=below.shape[:-1], delay=late.shape
        )
        missing = below.shape[-1] - above.shape[-1]
        above = np.pad(above, [(0, 0)] * (above.ndim - 1) + [(missing, 0)])
        above, below = (_flat(array, shape, 1) for array in (above, below))
        self._hold(Rational(above, below, _flat(late, shape, 0)), shape)

    @classmethod
    def from_system(
        cls, system: control.StateSpace | control.TransferFunction, delay: ArrayLike = 0.0
    ) -> Self:
        """Return the loop of a python-control system with one input and one output.

        A transfer function is held as polynomials, a state space as its matrices.

        Parameters
        ----------
        system : control.StateSpace or control.TransferFunction
            The open loop in continuous time, with the sign of 1 + L = 0.
        delay : array_like
            A delay [s] in series with it.

        Raises
        ------
        InputError
            For anything else: margins rest on the poles, which frequency data do not have.
        """
        import control

        if not isinstance(system, control.StateSpace | control.TransferFunction):
            raise InputError(
                "a loop must be a control.StateSpace or control.TransferFunction, whose poles are"
                f" known; got a {type(system).__name__}"
            )
        if not system.issiso() or system.isdtime(strict=True):
            raise InputError("a loop must have one input and one output, in continuous time")
        if isinstance(system, control.StateSpace):
            return cls.from_matrices(system.A, system.B, system.C, system.D, delay)
        return cls(system.num[0][0], system.den[0][0], delay)

    @classmethod
    def from_matrices(
        cls, A: ArrayLike, B: ArrayLike, C: ArrayLike, D: ArrayLike = 0.0, delay: ArrayLike = 0.0
    ) -> Self:
        """Return the loops x' = A x + B u, L: u to C x, with a delay, or a batch of them.

        Parameters
        ----------
        A, B, C : array_like
            ``(..., n, n)``, ``(..., n, 1)`` and ``(..., 1, n)``; the leading axes broadcast.
        D : array_like
            Zero, of shape ``()`` or ``(..., 1, 1)``.
        delay : array_like
            Delay [s], ``(...)``.

        Raises
        ------
        InputError
            For shapes that are not those of one input and one output, numbers that are not
            finite or beyond 1e15 (A) and 1e60 (B, C), a delay below zero, and an algebraic
            loop, D other than zero.
        """
        arrays = [
            within(name, array, -largest, largest)
            for name, array, largest in (("A", A, _FASTEST), ("B", B, _LARGEST), ("C", C, _LARGEST))
        ]
        through, late = finite("D", D), nonnegative("delay", delay, "s")
        n = arrays[0].shape[-1] if arrays[0].ndim else 0
        for name, array, size in zip("ABC", arrays, ((n, n), (n, 1), (1, n)), strict=True):
            if not n or array.shape[-2:] != size:
                raise InputError(
                    "a loop needs A (..., n, n), B (..., n, 1) and C (..., 1, n), with n of 1 or"
                    f" more; got {name} of shape {array.shape}"
                )
        if np.any(through):
            raise InputError(
                "this is an algebraic loop: its command feeds back without lag (D ="
                f" {through[through != 0.0].flat[0]:.6g}); put an actuator into it"
            )
        shape = broadcast(
            **{name: a.shape[:-2] for name, a in zip("ABC", arrays, strict=True)}, delay=late.shape
        )
        spread = [_flat(array, shape, 2) for array in arrays]
        held = StateLoop.balanced(
            spread[0],
            spread[1][:, :, 0],
            spread[2][:, 0],
            np.zeros(len(spread[0])),
            _flat(late, shape, 0),
        )
        loop = cls.__new__(cls)
        loop._hold(held, shape)
        return loop

    @property
    def numerator(self) -> FloatArray:
        """Coefficients of the numerator, highest power first; `InputError` for matrices."""
        return self._polynomials.numerator.reshape((*self.batch, -1))

    @property
    def denominator(self) -> FloatArray:
        """Coefficients of the denominator, highest power first; `InputError` for matrices."""
        return self._polynomials.denominator.reshape((*self.batch, -1))

    @property
    def delay(self) -> FloatArray:
        """Delay [s], ``(...)``."""
        return self.form.delay.reshape(self.batch)

    @property
    def poles(self) -> ComplexArray:
        """Poles without the delay [1/s], ``(..., n)``."""
        return self.form.open_poles().astype(complex).reshape((*self.batch, -1))

    @property
    def closed_loop_poles(self) -> ComplexArray:
        """Poles of 1 + L = 0 [1/s] with the exact delay, falling, ``(..., n)``.

        With a delay there are infinitely many: those furthest right, as far as all of them are
        known, some 20 and more. NaN fills the rows of a batch.
        """
        rows = [self._rightmost(k) for k in range(self.form.delay.size)]
        found = np.full((len(rows), max((one.size for one in rows), default=0)), np.nan, complex)
        for row, one in zip(found, rows, strict=True):
            row[: one.size] = one
        return found.reshape((*self.batch, -1))

    def _rightmost(self, k: int) -> ComplexArray:
        one = self.form.take(np.array([k]))
        late = float(one.delay[0])
        if late:
            return rightmost_poles(*_matrices(one), late, lambda s: one.value(s[np.newaxis])[0])
        poles = one.closed_poles()[0].astype(complex)
        return poles[np.argsort(-poles.real, kind="stable")]

    def response(self, omega: ArrayLike) -> ComplexArray:
        """Return L(j omega), shape ``batch + omega.shape``; infinite at a pole.

        Parameters
        ----------
        omega : array_like
            Frequencies [rad/s], of any shape.

        Raises
        ------
        InputError
            For frequencies that are not finite, or beyond 1e15 rad/s.
        """
        frequencies = within("omega", omega, -_FASTEST, _FASTEST, "rad/s")
        found = self._values(frequencies.reshape(1, -1))
        return found.reshape((*self.batch, *frequencies.shape))

    def findings(self, *, delays: bool = True) -> LoopAnalysis:
        """Return verdict, crossings and peaks of the loops on one axis.

        Parameters
        ----------
        delays : bool
            Whether the delay margins of a sampled loop are computed, most of its work; they are NaN
            if not. Those of a continuous loop always are.
        """
        flag("delays", delays)
        return analyse_loops(self.form)

    def in_plane(self, s: AnyArray) -> AnyArray:
        """Return the variable of `form` for s ``(k, m)`` [1/s]: s itself, unless it is sampled."""
        return s

    def from_plane(self, w: AnyArray) -> AnyArray:
        """Return the s ``(k, m)`` [1/s] of the variable of `form`."""
        return w

    def highest(self) -> FloatArray:
        """Return the highest frequency ``(k, 1)`` [rad/s]: of a sampled loop half its rate."""
        return np.full((self.form.delay.size, 1), np.inf)

    def aliases(self, omega: FloatArray) -> FloatArray:
        """Return where frequencies ``(k, m)`` [rad/s] appear when sampled; NaN: where they are."""
        return np.full(np.shape(omega), np.nan)

    def take(self, index: Any) -> Loop:
        """Return the loops at the positions `index` of the flattened batch."""
        held = self.form.take(np.atleast_1d(index))
        loop = type(self).__new__(type(self))
        loop._hold(held, np.shape(index))
        return loop

    def _values(self, omega: FloatArray) -> ComplexArray:
        """The values ``(k, m)`` at frequencies of `form`; infinite at a pole."""
        above, below = self.form.parts(omega)
        pole = (below == 0.0) & (above != 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.where(pole, np.inf, above / below))

    def _hold(self, form: AnyLoop, batch: tuple[int, ...]) -> None:
        object.__setattr__(self, "form", form)
        object.__setattr__(self, "batch", batch)

    @property
    def _polynomials(self) -> Rational:
        if isinstance(self.form, Rational):
            return self.form
        raise InputError(
            "this loop is held as matrices and has no polynomials; use response() and poles"
        )


def _flat(array: FloatArray, batch: tuple[int, ...], axes: int) -> FloatArray:
    """The array spread over the batch, and the batch on one axis."""
    own = array.shape[array.ndim - axes :]
    return np.broadcast_to(array, (*batch, *own)).reshape((-1, *own))


def _matrices(form: AnyLoop) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A, B and C of the first of some loops; of polynomials as their companion."""
    if isinstance(form, StateLoop):
        k = form.case[0]
        return form.A[k], form.B[k], form.C[k]
    below, above = form.denominator[0], form.numerator[0]
    A = np.eye(below.size - 1, k=-1)
    A[0] = -below[1:] / below[0]
    return A, np.eye(len(A))[0], above[1:] / below[0]


_STEPS, _LONGEST, _NEAR = 30, 0.05, 1e-11
"""Newton's steps to a delay, how long over the frequency, and how near is there."""
_PER_SAMPLE, _LOOKS, _ROUNDS = 48.0, (8, 192), 14
"""Delays in a sample with which a loop is looked at, how few and how many they may be in all, and
how often it is looked again where it begins to grow: to 8^-13 of their distance."""
_BEYOND = 1.0 + 1e-6
"""So far beyond a delay that is an edge a loop grows."""


@dataclass(frozen=True, eq=False, init=False)
class SampledLoop(Loop):
    """The loop of a sampled autopilot, from the command to minus what the law returns.

    Made by `Autopilot.exact_loop`. Frequencies are those of the s plane, from zero to half the
    sample rate; `form` is in the variable w, z = (1 + w h/2)/(1 - w h/2).

    `period`, `late`: h, and the delay [s], ``(...)``. `later`: takes delays below h [s] ``(k,)``
    and the positions ``(k,)`` of loops in the flattened batch, and gives these loops with those
    delays. `closed_later`: takes any delays and positions, and gives the closed-loop poles z.
    """

    period: FloatArray
    late: FloatArray
    later: Callable[[FloatArray, IndexArray], StateLoop]
    closed_later: Callable[[FloatArray, IndexArray], AnyArray]

    def __init__(
        self,
        form: StateLoop,
        batch: tuple[int, ...],
        period: FloatArray,
        late: FloatArray,
        later: Callable[[FloatArray, IndexArray], StateLoop],
        closed_later: Callable[[FloatArray, IndexArray], AnyArray],
    ) -> None:
        self._hold(form, batch)
        own = {"period": period, "late": late, "later": later, "closed_later": closed_later}
        for name, value in own.items():
            object.__setattr__(self, name, value)

    def response(self, omega: ArrayLike) -> AnyArray:
        """Return L(e^(j omega h)) below half the sample rate [rad/s], as of `Loop`."""
        highest = float(np.pi / np.max(self.period))
        frequencies = within("omega", omega, -highest, highest, "rad/s")
        half = 0.5 * self.period.reshape(-1, 1)
        with np.errstate(over="ignore"):
            found = self._values(np.tan(frequencies.reshape(1, -1) * half) / half)
        return found.reshape((*self.batch, *frequencies.shape))

    @property
    def poles(self) -> AnyArray:
        """Poles z of the open loop, ``(..., n)``."""
        return self._z(self.form.open_poles()).reshape((*self.batch, -1))

    @property
    def closed_loop_poles(self) -> AnyArray:
        """Poles z of the closed loop, ``(..., n)``; inside the unit circle it is stable."""
        return self._z(self.form.closed_poles()).reshape((*self.batch, -1))

    def findings(self, *, delays: bool = True) -> LoopAnalysis:
        """Return verdict, crossings and peaks at frequencies of the s plane, as of `Loop`."""
        found = super().findings(delays=delays)
        half = 0.5 * self.period.reshape(-1)

        def turned(nu: FloatArray) -> FloatArray:
            rows = half.reshape(-1, *(1,) * (nu.ndim - 1))
            return np.arctan(nu * rows) / rows

        peaks = found.peaks.copy()
        peaks[..., 1] = turned(peaks[..., 1])
        omega = turned(found.gain_frequencies)
        return replace(
            found,
            gain_frequencies=omega,
            delays=self._delays(omega, found.phases, found.stable)
            if delays
            else np.full_like(omega, np.nan),
            phase_frequencies=turned(found.phase_frequencies),
            peaks=peaks,
        )

    def _delays(self, omega: FloatArray, phases: FloatArray, stable: BoolArray) -> FloatArray:
        """How much later L may be until it is -1 [s], ``(k, n)``, the least exactly.

        A delay that is no whole number of samples changes |L| as well. By Newton's steps on
        ln L(omega, T) = ln(-1), a whole sample being a factor of 1/z.
        """
        found = phases % (2.0 * np.pi) / omega
        if not found.shape[1]:
            return found
        case, place = np.nonzero(stable[:, np.newaxis] & np.isfinite(found))
        h, late = self.period.ravel()[case], self.late.ravel()[case]
        w, more = omega[case, place], found[case, place]
        arrived = np.zeros(case.size, dtype=bool)
        for _ in range(_STEPS if case.size else 0):
            whole, rest = delay_parts(late + more, h)
            nu = np.tan(0.5 * w * h) / (0.5 * h)
            form = self.later(rest, case)
            L, slope = (of(1j * nu[:, np.newaxis])[:, 0] for of in (form.value, form.slope))
            rate = 1j * slope / L * (1.0 + (0.5 * nu * h) ** 2)  # d ln L/d omega
            step = np.clip(-np.log(np.abs(L)) / rate.real, -_LONGEST * w, _LONGEST * w)
            w = np.minimum(w + step, np.pi / h)
            ahead = np.angle(-L) + rate.imag * step - whole * h * w
            ahead -= 2.0 * np.pi * np.round(ahead / (2.0 * np.pi))
            more = np.maximum(more + ahead / w, 0.0)
            arrived = (np.abs(step) < _NEAR * w) & (np.abs(ahead) < _NEAR)
            if np.all(arrived):
                break
        found[case[arrived], place[arrived]] = more[arrived]
        for k in np.flatnonzero(stable & np.any(np.isfinite(found), axis=1)):
            edges = np.sort(found[k, np.isfinite(found[k])])
            grows = self._grows(int(k), _BEYOND * edges)
            edge = edges[np.argmax(grows)]  # what is none is left out, if another is one
            least = self._grows_within(int(k), float(edge))
            first = int(np.nanargmin(found[k]))
            found[k] = np.maximum(found[k], least)
            found[k, first] = least
        return found

    def _grows(self, case: int, more: FloatArray) -> BoolArray:
        """Whether a loop grows with so much more delay [s], ``(m,)``."""
        late = self.late.ravel()[case]
        z = self.closed_later(late + more, np.full(more.size, case))
        return np.asarray(np.any(np.abs(z) > 1.0 + _NEAR, axis=-1))

    def _grows_within(self, case: int, most: float) -> float:
        """The delay [s] below `most` with which a loop begins to grow; `most` where it does not.

        Beside half the sample rate |L| changes with the part of a sample that a delay ends with,
        and may be one where now it is not.
        """
        count = int(np.clip(np.ceil(_PER_SAMPLE * most / self.period.ravel()[case]), *_LOOKS))
        low, high = 0.0, most
        for _ in range(_ROUNDS):
            looks = low + (high - low) * np.append(np.arange(1, count) / count, 2.0 - _BEYOND)
            grows = self._grows(case, looks)
            if high == most and not np.any(grows):
                return most
            first = int(np.argmax(grows)) if np.any(grows) else looks.size
            ends = np.concatenate([[low], looks, [high]])
            low, high, count = float(ends[first]), float(ends[first + 1]), _LOOKS[0]
        return high

    def in_plane(self, s: AnyArray) -> AnyArray:
        """Return w = (2/h) tanh(s h/2) of s ``(k, m)`` [1/s]."""
        half = 0.5 * self.period.reshape(-1, 1)
        return np.tanh(s * half) / half

    def from_plane(self, w: AnyArray) -> AnyArray:
        """Return the s ``(k, m)`` [1/s] of w, of all that have it the nearest to zero."""
        half = 0.5 * self.period.reshape(-1, 1)
        return np.arctanh(np.asarray(w, complex) * half) / half

    def highest(self) -> FloatArray:
        """Return half the sample rate [rad/s], ``(k, 1)``."""
        return np.pi / self.period.reshape(-1, 1)

    def aliases(self, omega: FloatArray) -> FloatArray:
        """Return where frequencies ``(k, m)`` [rad/s] above half the rate appear, else NaN."""
        whole = 2.0 * np.pi / self.period.reshape(-1, 1)
        folded = np.abs(omega - whole * np.round(omega / whole))
        return np.where(omega > 0.5 * whole, folded, np.nan)

    def _z(self, w: AnyArray) -> AnyArray:
        half = 0.5 * self.period.reshape(-1, 1)
        return (1.0 + w * half) / (1.0 - w * half)
