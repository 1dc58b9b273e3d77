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
from tvclin.base.errors import InputError, broadcast, finite, flag, nonnegative, number, within
from tvclin.linear.named_systems import named_system
from tvclin.linear.system import LinearSystem, split_delay
from tvclin.numerics import state_space
from tvclin.numerics.loop_margins import LoopAnalysis, analyse_loops
from tvclin.numerics.loops import AnyLoop, Rational, StateLoop, rightmost_poles

if TYPE_CHECKING:
    import control


_MAX_FREQUENCY = 1e15
"""Largest frequency [rad/s] and entry of A [1/s]: beyond, polynomials overflow."""
_MAX_INPUT_OUTPUT = 1e60
"""Largest entry of B and C; their squares must not overflow."""


@dataclass(frozen=True, eq=False)
class Loop:
    """One loop L(s) = numerator(s)/denominator(s) e^(-s delay), or a batch of them.

    The closed loop is 1 + L = 0. The delay is exact in all results. For high order, or modes that
    lie close together, use matrices: `from_system` or `from_matrices`.

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
        The flattened batch of loops, for the arithmetic of margins.
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
        """Check the polynomials N and D and the delay T, and set the flattened batch.

        N is filled with zeros in front to the length of D.
        """
        N = np.atleast_1d(finite("numerator", numerator))
        D = np.atleast_1d(finite("denominator", denominator))
        T = nonnegative("delay", delay, "s")
        if not D.shape[-1]:
            raise InputError("denominator must have a coefficient")
        if np.any(D[..., 0] == 0.0):
            raise InputError("denominator must not begin with a zero")
        while N.shape[-1] > 1 and not np.any(N[..., 0]):
            N = N[..., 1:]
        if N.shape[-1] >= D.shape[-1]:
            raise InputError(
                "this is an algebraic loop: its command feeds back without lag (numerator of degree"
                f" {N.shape[-1] - 1} over {D.shape[-1] - 1}); put an actuator into it"
            )
        shape = broadcast(numerator=N.shape[:-1], denominator=D.shape[:-1], delay=T.shape)
        missing = D.shape[-1] - N.shape[-1]
        N = np.pad(N, [(0, 0)] * (N.ndim - 1) + [(missing, 0)])
        N, D = (_flat(array, shape, 1) for array in (N, D))  # one axis of coefficients
        self._set(Rational(N, D, _flat(T, shape, 0)), shape)

    @classmethod
    def from_system(
        cls, system: control.StateSpace | control.TransferFunction, delay: ArrayLike = 0.0
    ) -> Self:
        """Return the loop of a python-control system with one input and one output.

        A transfer function becomes polynomials, a state space keeps its matrices.

        Parameters
        ----------
        system : control.StateSpace or control.TransferFunction
            The open loop with the sign of 1 + L = 0, in continuous time, or in steps of a sample
            time: then a `SampledLoop`. How the plant moves between samples is not known: a delay
            margin is the phase over the frequency. Whole samples of further delay below it keep
            the loop stable; at fractions of a sample see `Autopilot.exact_loop`.
        delay : array_like
            A delay [s] in series with it; of a loop in steps a whole number of samples.

        Raises
        ------
        InputError
            For another type: margins need the poles, which frequency data do not have; for several
            inputs or outputs, an improper transfer function, and an algebraic loop.
        """
        import control

        if not isinstance(system, control.StateSpace | control.TransferFunction):
            raise InputError(
                "a loop must be a control.StateSpace or control.TransferFunction, whose poles are"
                f" known; got a {type(system).__name__}"
            )
        if not system.issiso():
            raise InputError("a loop must have one input and one output")
        if system.isdtime(strict=True):
            return discrete_loop(named_system("loop", system), delay)  # type: ignore[return-value]
        if isinstance(system, control.StateSpace):
            return cls.from_matrices(system.A, system.B, system.C, system.D, delay)
        ((numerator,),), ((denominator,),) = system.num, system.den  # one output, one input
        return cls(numerator, denominator, delay)

    @classmethod
    def from_matrices(
        cls, A: ArrayLike, B: ArrayLike, C: ArrayLike, D: ArrayLike = 0.0, delay: ArrayLike = 0.0
    ) -> Self:
        """Return the loop L(s) = C (s I - A)^-1 B e^(-s delay), or a batch of loops.

        `A`, `B`, `C`: ``(..., n, n)``, ``(..., n, 1)`` and ``(..., 1, n)``; the leading axes
        broadcast. `D`: zero, of shape ``()`` or ``(..., 1, 1)``. `delay`: [s], ``(...)``.
        `InputError` for shapes of more than one input or output, numbers that are not finite or
        beyond 1e15 (A) and 1e60 (B, C), a negative delay, and D other than zero, an algebraic loop.
        """
        limits = (_MAX_FREQUENCY, _MAX_INPUT_OUTPUT, _MAX_INPUT_OUTPUT)
        entries = zip("ABC", (A, B, C), limits, strict=True)
        arrays = [within(name, array, -limit, limit) for name, array, limit in entries]
        direct, T = finite("D", D), nonnegative("delay", delay, "s")
        n = arrays[0].shape[-1] if arrays[0].ndim else 0
        for name, array, size in zip("ABC", arrays, ((n, n), (n, 1), (1, n)), strict=True):
            if not n or array.shape[-2:] != size:
                raise InputError(
                    "a loop needs A (..., n, n), B (..., n, 1) and C (..., 1, n), with n of 1 or"
                    f" more; got {name} of shape {array.shape}"
                )
        if np.any(direct):
            raise InputError(
                "this is an algebraic loop: its command feeds back without lag (D ="
                f" {direct[direct != 0.0].flat[0]:.6g}); put an actuator into it"
            )
        shapes = {name: array.shape[:-2] for name, array in zip("ABC", arrays, strict=True)}
        shape = broadcast(**shapes, delay=T.shape)
        a, b, c = (_flat(array, shape, 2) for array in arrays)
        form = StateLoop.balanced(a, b[..., 0], c[:, 0], np.zeros(len(a)), _flat(T, shape, 0))
        loop = cls.__new__(cls)  # not by __init__, which takes polynomials
        loop._set(form, shape)
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
        """Delay [s] of each loop, in the shape of the batch."""
        return self.form.delay.reshape(self.batch)

    @property
    def poles(self) -> ComplexArray:
        """Poles without the delay [1/s], ``(..., n)``."""
        return self.form.open_poles().astype(complex).reshape((*self.batch, -1))

    @property
    def closed_loop_poles(self) -> ComplexArray:
        """Poles of 1 + L = 0 [1/s] with the exact delay, by falling real part, ``(..., n)``.

        With a delay there are infinitely many; these are the rightmost, 20 or more, without a gap.
        NaN fills the rows of a batch.
        """
        rows = [self._rightmost(k) for k in range(self.form.delay.size)]
        padded = np.full((len(rows), max((row.size for row in rows), default=0)), np.nan, complex)
        for target, row in zip(padded, rows, strict=True):
            target[: row.size] = row
        return padded.reshape((*self.batch, -1))

    def _rightmost(self, k: int) -> ComplexArray:
        """Return the rightmost closed-loop poles [1/s] of the k-th loop of the flattened batch."""
        form = self.form.take(np.array([k]))  # a batch of this one loop
        delay = form.delay.item()
        if delay:
            A, B, C = _matrices(form)
            return rightmost_poles(A, B, C, delay, lambda s: form.value(s[np.newaxis])[0])
        poles = form.closed_poles()[0].astype(complex)
        return poles[np.argsort(-poles.real, kind="stable")]

    def response(self, omega: ArrayLike) -> ComplexArray:
        """Return the open loop L(j omega), shape ``batch + omega.shape``; infinite at a pole.

        `omega`: frequencies [rad/s], of any shape. `InputError` for frequencies that are not
        finite, or beyond 1e15 rad/s.
        """
        frequencies = within("omega", omega, -_MAX_FREQUENCY, _MAX_FREQUENCY, "rad/s")
        values = self._values(frequencies.reshape(1, -1))
        return values.reshape((*self.batch, *frequencies.shape))

    def analysis(self, *, delays: bool = True) -> LoopAnalysis:
        """Return verdict, crossings and peaks of the flattened batch of loops.

        `delays`: whether the delay margins of a sampled loop are computed, which is most of its
        work; else they are NaN. Delay margins of a continuous loop are always computed.
        """
        flag("delays", delays)  # without effect on a continuous loop
        return analyse_loops(self.form)

    def s_to_w(self, s: AnyArray) -> AnyArray:
        """Return the variable w of L at values s [1/s], in their shape: s, unless sampled."""
        return s

    def w_to_s(self, w: AnyArray) -> AnyArray:
        """Return s [1/s] at values w of the variable of L, in their shape: w, unless sampled."""
        return w

    def max_frequency(self) -> FloatArray:
        """Return the highest frequency [rad/s], ``(k, 1)``: infinite, half the rate if sampled."""
        return np.full((self.form.delay.size, 1), np.inf)

    def aliases(self, omega: FloatArray) -> FloatArray:
        """Return NaN in the shape of the frequencies `omega`: only a sampled loop has aliases."""
        return np.full(np.shape(omega), np.nan)

    def take(self, index: Any) -> Loop:
        """Return the loops at positions of the flattened batch, in the shape of `index`."""
        form = self.form.take(np.atleast_1d(index))
        loop = type(self).__new__(type(self))
        loop._set(form, np.shape(index))
        return loop

    def _values(self, omega: FloatArray) -> ComplexArray:
        """Return L ``(k, m)`` of k loops at `omega` ``(k, m)``; infinite at a pole.

        `omega`: imaginary part of the variable of `form`: frequency [rad/s] of a continuous loop;
        of a sampled one the frequency of w = (2/h)(z - 1)/(z + 1), h being the sample period [s].
        """
        numerator, denominator = self.form.parts(omega)
        pole = (denominator == 0.0) & (numerator != 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.where(pole, np.inf, numerator / denominator))

    def _set(self, form: AnyLoop, batch: tuple[int, ...]) -> None:
        """Set the flattened batch of loops, `form`, and its shape in the frozen record."""
        object.__setattr__(self, "form", form)
        object.__setattr__(self, "batch", batch)

    @property
    def _polynomials(self) -> Rational:
        """Polynomial form of the loop; `InputError` for matrices."""
        if isinstance(self.form, Rational):
            return self.form
        raise InputError(
            "this loop is held as matrices and has no polynomials; use response() and poles"
        )


def _flat(array: FloatArray, batch: tuple[int, ...], axes: int) -> FloatArray:
    """Return the array broadcast over the batch, with the batch flattened to the first axis.

    `axes`: number of trailing axes that are not of the batch.
    """
    trailing = array.shape[array.ndim - axes :]
    return np.broadcast_to(array, (*batch, *trailing)).reshape((-1, *trailing))


def _matrices(form: AnyLoop) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return A ``(n, n)``, B ``(n,)`` and C ``(n,)`` of the first loop of a batch.

    Of polynomials the companion form. `form`: the loops as polynomials or matrices.
    """
    if isinstance(form, StateLoop):
        k = form.case[0]  # a case is the index of a loop's matrices, which several may share
        return form.A[k], form.B[k], form.C[k]
    numerator, denominator = form.numerator[0], form.denominator[0]
    A = np.eye(denominator.size - 1, k=-1)
    A[0] = -denominator[1:] / denominator[0]
    return A, np.eye(len(A))[0], numerator[1:] / denominator[0]


_MAX_NEWTON_STEPS = 30
"""Largest number of Newton steps to a delay margin."""
_MAX_STEP_OVER_FREQUENCY = 0.05
"""Largest Newton step of a frequency, relative."""
_DELAY_TOLERANCE = 1e-11
"""Tolerance of the Newton iteration, relative to the frequency and in phase [rad], and of the
modulus of a pole z that counts as outside the unit circle."""
_POLE_TOLERANCE = 1e-12
"""Distance of a pole z from -1 that counts as zero."""
_DELAYS_PER_PERIOD = 48.0
"""Number of trial delays in a sample period in the search for the first instability."""
_TRIAL_DELAYS = (8, 192)
"""Smallest and largest number of trial delays in a round of that search."""
_MAX_SEARCHED_PERIODS = 100
"""Longest further delay, in sample periods, with which closed-loop poles are computed: each period
is a state. An instability that depends on the fraction of a sample lies near half the sample rate,
where the phase turns within a few samples."""
_ROUNDS = 14
"""Number of rounds of that search: its resolution is 8^-13 of the first spacing."""
_BEYOND_MARGIN = 1.0 + 1e-6
"""Factor on a delay margin at which the loop is tested for instability."""


@dataclass(frozen=True, eq=False)
class SampledLoop(Loop):
    """Loop of a sampled autopilot, from the command to minus the returned command.

    Made by `Autopilot.exact_loop` and `Loop.from_system`. Frequencies are of the s plane,
    from zero to half the sample rate; `form` is in the variable w, z = (1 + w h/2)/(1 - w h/2).

    `period`: h [s], ``(...)``. `loop_delay`: delay [s], ``(...)``. `delayed_form`: function of
    delays below h [s] ``(k,)`` and indices ``(k,)`` in the flattened batch; it returns these loops
    with those delays. `delayed_closed_poles`: function of any delays and indices; it returns the
    closed-loop poles z. Both are None where only the loop in steps is known, without the motion
    between them: a delay margin is then the phase over the frequency.
    """

    period: FloatArray
    loop_delay: FloatArray
    delayed_form: Callable[[FloatArray, IndexArray], StateLoop] | None = None
    delayed_closed_poles: Callable[[FloatArray, IndexArray], AnyArray] | None = None

    def response(self, omega: ArrayLike) -> AnyArray:
        """Return the open loop L(e^(j omega h)), shape ``batch + omega.shape``; infinite at a pole.

        `omega`: frequencies [rad/s] up to half the sample rate; `InputError` for higher ones.
        """
        highest = float(np.pi / np.max(self.period))
        frequencies = within("omega", omega, -highest, highest, "rad/s")
        half = 0.5 * self.period.reshape(-1, 1)
        with np.errstate(over="ignore"):  # w = j nu with nu = (2/h) tan(omega h/2)
            values = self._values(np.tan(frequencies.reshape(1, -1) * half) / half)
        return values.reshape((*self.batch, *frequencies.shape))

    @property
    def poles(self) -> AnyArray:
        """Poles z of the open loop, ``(..., n)``."""
        return self._z(self.form.open_poles()).reshape((*self.batch, -1))

    @property
    def closed_loop_poles(self) -> AnyArray:
        """Poles z of the closed loop, ``(..., n)``; inside the unit circle it is stable."""
        return self._z(self.form.closed_poles()).reshape((*self.batch, -1))

    def analysis(self, *, delays: bool = True) -> LoopAnalysis:
        """Return verdict, crossings and peaks at frequencies of the s plane [rad/s].

        `delays`: whether delay margins are computed, which is most of the work; else they are NaN.
        """
        w_plane = super().analysis(delays=delays)
        half = 0.5 * self.period.reshape(-1)

        def frequency(nu: FloatArray) -> FloatArray:
            """Return frequencies (2/h) arctan(nu h/2) [rad/s] of nu, where w = j nu, ``(k, ...)``.

            nu has a row for each of k loops, and h is their sample period, twice `half`.
            """
            column = half.reshape(-1, *(1,) * (nu.ndim - 1))
            return np.arctan(nu * column) / column

        peaks = w_plane.peaks.copy()  # (..., 2): a peak, and its frequency, which is converted
        peaks[..., 1] = frequency(peaks[..., 1])
        omega = frequency(w_plane.gain_frequencies)
        margins = np.full_like(omega, np.nan)
        if delays:
            margins = self._delay_margins(omega, w_plane.phases, w_plane.stable)
        return replace(
            w_plane,
            gain_frequencies=omega,
            delays=margins,
            phase_frequencies=frequency(w_plane.phase_frequencies),
            peaks=peaks,
        )

    def _delay_margins(
        self, omega: FloatArray, phases: FloatArray, stable: BoolArray
    ) -> FloatArray:
        """Return the further delays [s] with which L = -1, ``(k, n)``; the smallest is exact.

        `omega` [rad/s], `phases` [rad]: gain crossovers and phase margins of k loops, ``(k, n)``.
        `stable`: of each, ``(k,)``. Other delays than whole samples, factors 1/z, change |L| too:
        Newton's iteration solves ln L(omega, T) = ln(-1) for frequency and delay. Without the
        motion between samples (`delayed_form` is None) a margin is the phase over the frequency.
        """
        margins = phases % (2.0 * np.pi) / omega
        delayed_form = self.delayed_form  # loops by delays below a period, and their indices
        if not margins.shape[1] or delayed_form is None:
            return margins
        # one entry for each crossover of a stable loop: index of the loop, frequency w, margin
        case, column = np.nonzero(stable[:, np.newaxis] & np.isfinite(margins))
        h, delay = self.period.ravel()[case], self.loop_delay.ravel()[case]
        w, margin = omega[case, column], margins[case, column]
        converged = np.zeros(case.size, dtype=bool)
        for _ in range(_MAX_NEWTON_STEPS if case.size else 0):
            samples, rest = split_delay(delay + margin, h)  # whole samples, and a rest below h [s]
            nu = np.tan(0.5 * w * h) / (0.5 * h)  # frequency of the w plane
            form, w_plane = delayed_form(rest, case), 1j * nu[:, np.newaxis]
            L, slope = form.value(w_plane)[:, 0], form.slope(w_plane)[:, 0]
            rate = 1j * slope / L * (1.0 + (0.5 * nu * h) ** 2)  # d ln L/d omega
            max_step = _MAX_STEP_OVER_FREQUENCY * w
            step = np.clip(-np.log(np.abs(L)) / rate.real, -max_step, max_step)
            w = np.minimum(w + step, np.pi / h)  # half the sample rate
            phase = np.angle(-L) + rate.imag * step - samples * h * w  # of L, beyond -1
            phase -= 2.0 * np.pi * np.round(phase / (2.0 * np.pi))
            margin = np.maximum(margin + phase / w, 0.0)
            converged = (np.abs(step) < _DELAY_TOLERANCE * w) & (np.abs(phase) < _DELAY_TOLERANCE)
            if np.all(converged):
                break
        margins[case[converged], column[converged]] = margin[converged]
        # A smaller delay than any of these may make |L| reach one at another frequency: the first
        # of them with unstable poles, or beyond the search, bounds the search for the smallest.
        for k in np.flatnonzero(stable & np.any(np.isfinite(margins), axis=1)):
            candidates = np.sort(margins[k, np.isfinite(margins[k])])
            unstable = candidates > _MAX_SEARCHED_PERIODS * self.period.ravel()[k]
            unstable[~unstable] = self._is_unstable(int(k), _BEYOND_MARGIN * candidates[~unstable])
            smallest = self._first_unstable_delay(int(k), float(candidates[np.argmax(unstable)]))
            first = int(np.nanargmin(margins[k]))
            margins[k] = np.maximum(margins[k], smallest)
            margins[k, first] = smallest
        return margins

    def _is_unstable(self, case: int, delays: FloatArray) -> BoolArray:
        """Return whether a loop has a pole z outside the unit circle with further delays, ``(m,)``.

        `case`: index of the loop in the flattened batch. `delays`: [s], added to the loop's own.
        """
        assert self.delayed_closed_poles is not None  # else no delay margin asks for it
        loop_delay = self.loop_delay.ravel()[case]
        z = self.delayed_closed_poles(loop_delay + delays, np.full(delays.size, case))
        return np.asarray(np.any(np.abs(z) > 1.0 + _DELAY_TOLERANCE, axis=-1))

    def _first_unstable_delay(self, case: int, maximum: float) -> float:
        """Return the smallest further delay [s] that makes a loop unstable, at most `maximum`.

        `case`: index of the loop in the flattened batch. Near half the sample rate |L| depends on
        the delay's fraction of a sample, so that it may become one at a frequency at which the
        present |L| is smaller. So delays are tried, and the interval before the first unstable one
        is divided again.
        """
        h = float(self.period.ravel()[case])
        last = min(maximum, _MAX_SEARCHED_PERIODS * h)
        fewest, most = _TRIAL_DELAYS
        count = int(np.clip(np.ceil(_DELAYS_PER_PERIOD * last / h), fewest, most))
        low, high = 0.0, last
        for _ in range(_ROUNDS):  # trials between low and high, the last one just below high
            fractions = np.append(np.arange(1, count) / count, 2.0 - _BEYOND_MARGIN)
            delays = low + (high - low) * fractions
            unstable = self._is_unstable(case, delays)
            if high == last and not np.any(unstable):
                return maximum
            first = int(np.argmax(unstable)) if np.any(unstable) else delays.size
            bounds = np.concatenate([[low], delays, [high]])
            low, high, count = float(bounds[first]), float(bounds[first + 1]), fewest
        return high

    def s_to_w(self, s: AnyArray) -> AnyArray:
        """Return w = (2/h) tanh(s h/2) [1/s], ``(k, m)``, of k loops with sample periods h [s]."""
        half = 0.5 * self.period.reshape(-1, 1)
        return np.tanh(s * half) / half

    def w_to_s(self, w: AnyArray) -> AnyArray:
        """Return s = (2/h) artanh(w h/2) ``(k, m)`` [1/s], on the branch nearest to zero.

        h: sample period [s] of each of k loops. `w`: ``(k, m)`` [1/s].
        """
        half = 0.5 * self.period.reshape(-1, 1)
        return np.arctanh(np.asarray(w, complex) * half) / half

    def max_frequency(self) -> FloatArray:
        """Return half the sample rate [rad/s], ``(k, 1)``."""
        return np.pi / self.period.reshape(-1, 1)

    def aliases(self, omega: FloatArray) -> FloatArray:
        """Return the alias [rad/s] of `omega` [rad/s] above half the sample rate, else NaN.

        Of k loops at m frequencies each, ``(k, m)``.
        """
        rate = 2.0 * np.pi / self.period.reshape(-1, 1)
        folded = np.abs(omega - rate * np.round(omega / rate))
        return np.where(omega > 0.5 * rate, folded, np.nan)

    def _z(self, w: AnyArray) -> AnyArray:
        """Return z = (1 + w h/2)/(1 - w h/2), ``(k, m)``, h being the sample period of a loop.

        `w`: variable of L [1/s], ``(k, m)``, a row for each of k loops.
        """
        half = 0.5 * self.period.reshape(-1, 1)
        z = (1.0 + w * half) / (1.0 - w * half)
        return z + 0.0  # no imaginary part of -0, which would turn the logarithm of a real z < 0


def discrete_loop(system: LinearSystem, delay: ArrayLike = 0.0) -> SampledLoop:
    """Return the sampled loop of an open loop L(z), with a delay of whole samples [s].

    `system`: difference equations with one input and output. `InputError` for another delay, and
    for an algebraic loop.
    """
    assert system.period is not None
    T = number("delay", delay, nonnegative, "s")
    samples, fraction = split_delay(np.asarray(T), system.period)
    if fraction:
        raise InputError(
            f"delay must be a whole number of samples of {float(system.period):.6g} s; got"
            f" {float(T):.6g} s"
        )
    count = int(samples)
    if not count and np.any(system.D):
        raise InputError(
            "this is an algebraic loop: its command feeds back within the sample (D ="
            f" {system.D.item():.6g}); give it a delay of a sample"
        )
    # A delay of `count` samples, as states that shift.
    shift = (np.eye(count, k=-1), np.eye(count, 1), np.eye(1, count)[:, ::-1], np.zeros((1, 1)))
    matrices = state_space.series(shift, system.matrices()) if count else system.matrices()
    if np.any(np.abs(system.poles + 1.0) < _POLE_TOLERANCE):  # at infinity in the w plane
        raise InputError("loop must not have a pole at z = -1, half the sample rate")
    form = w_plane_loop(matrices, np.reshape(system.period, 1))
    return SampledLoop(form, batch=(), period=system.period, loop_delay=np.asarray(T))


def poles_in_s(loop: Loop) -> ComplexArray:
    """Return the closed-loop poles [1/s] of loops ``(..., n)``; of sampled loops log(z)/h.

    A real z < 0 has the imaginary part pi/h, without a conjugate pole.
    """
    poles = loop.closed_loop_poles
    if isinstance(loop, SampledLoop):
        with np.errstate(divide="ignore"):
            poles = np.log(poles.astype(complex)) / np.asarray(loop.period)[..., np.newaxis]
    return poles


def w_plane_loop(matrices: tuple[FloatArray, ...], period: FloatArray) -> StateLoop:
    """Return loops in w = (2/h)(z - 1)/(z + 1) of open loops L(z) = C (z - A)^-1 B + D.

    w = j v is a point z = e^(j omega h) of the unit circle, with v = (2/h) tan(omega h/2) [rad/s];
    so margins are computed as in continuous time. The batch ``(...)`` is flattened to k loops.
    `matrices`: A, B, C and D of one input and output. `period`: h [s], ``(...)``.
    """
    A, B, C, D = state_space.from_steps(matrices, 0.5 * period)  # type: ignore[arg-type]
    A, B, C, D = (
        np.broadcast_to(m, (*period.shape, *m.shape[-2:])).reshape(period.size, *m.shape[-2:])
        for m in (A, B, C, D)
    )
    return StateLoop.balanced(A, B[..., 0], C[:, 0], D[:, 0, 0], delay=np.zeros(len(A)))
