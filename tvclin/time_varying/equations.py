"""Linear equations of vehicles over the steps of their winds, at any dynamic pressure.

Normal and axial force go with r = q/q_n, so that A and the columns of deflection and wind are

    [A b w] = E + (r - 1) E_1 + (1/r - 1) E_2,

linear in r but for b1/B of the model drift, where b1 has a part without the air and B has none.

After a wind the parameters are constant: there the unstable modes, and the minimum peak over all of
them of any control.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tvclin.boundary.limit import COMPARABLE, leading_pole
from tvclin.kernels import minimum_peaks as marches
from tvclin.kernels.choice import run
from tvclin.kernels.trim_and_demand import VaryingSteps
from tvclin.linear.modes import left_eigenvectors, unstable_poles
from tvclin.linear.plant import Plant
from tvclin.vehicle.vehicle import Vehicle, at_pressure

_CELL_ENDS = np.expm1(np.linspace(0.0, 8.0, 256)) / np.expm1(8.0)
"""Ends of the cells of a deflection after the wind, over `_CELL_SPAN` times the time constant of
the slowest mode; the last cell has no end."""
_CELL_SPAN = 30.0
"""Length of the cells that end, over the time constant of the slowest mode."""


@dataclass(frozen=True, eq=False)
class UnstableModes:
    """Unstable modes of constant equations after a wind, of cases with the same kinds of modes.

    Attributes
    ----------
    cases : ndarray of int
        Positions in the batch, ``(n,)``.
    poles, costates : ndarray
        Poles s [1/s] ``(n, k)`` and left eigenvectors ``(n, k, m)``, A^T p = s p; of a complex pair
        the pole of positive frequency.
    """

    cases: IndexArray
    poles: AnyArray
    costates: AnyArray

    def of(self, cases: IndexArray) -> UnstableModes:
        """Return the modes of a selection `cases` of the batch, without cases that lack the modes.

        `cases`: positions in the batch, ``(c,)``. In the result positions count in this selection.
        """
        # row of each case among those with these modes, whose positions rise
        row = np.minimum(np.searchsorted(self.cases, cases), len(self.cases) - 1)
        which = self.cases[row] == cases  # whether a case has these modes
        rows = row[which]
        return UnstableModes(
            cases=np.flatnonzero(which), poles=self.poles[rows], costates=self.costates[rows]
        )

    def after(self, end: FloatArray, column: FloatArray) -> tuple[FloatArray, ...]:
        """Return real costates, control reaches, poles, and integrals of p.b over cells.

        They are the arguments of `kernels.minimum_peaks`, ``(n, k, m)``, ``(n, 2)``, ``(n, 2)`` and
        ``(n, k, cells)``; a complex mode counts twice in k, by its real and its imaginary part. The
        control reach of a mode p with the pole s is p.b/s, the integral of p.b e^(-s t) over all
        time after the wind. Cells divide this time; in each the deflection is constant. Of one or
        two real modes there are no cells, since integrals after the wind have closed forms.

        Parameters
        ----------
        end : ndarray
            Costate and control reach of the fastest mode, ``(n, m + 1)``: over the rest of a
            flight, which varies, they differ from the left eigenvector's.
        column : ndarray
            Column b of the deflection, ``(n, m)``.
        """
        n, k = len(end), self.poles.shape[1]
        complex_modes = np.imag(self.poles[0]) != 0.0  # the same modes in each case
        costates = np.broadcast_to(self.costates, (n, *self.costates.shape[1:]))
        # vecdot conjugates its first argument: this is p.b/s, without a conjugate
        reach = np.vecdot(np.conj(costates), column[:, np.newaxis]) / self.poles
        costates = np.concatenate([costates.real, costates.imag[:, complex_modes]], axis=1)
        costates[:, 0], reach[:, 0] = end[:, :-1], end[:, -1]  # with the rest of the flight
        reaches, poles = np.zeros((n, 2)), np.zeros((n, 2))
        if k <= 2 and not np.any(complex_modes):
            reaches[:, :k], poles[:, :k] = reach, self.poles
            return costates, reaches, poles, np.zeros((n, k, 0))
        slowest = np.real(self.poles).min(axis=-1, keepdims=True)
        ends = _CELL_ENDS * _CELL_SPAN / slowest  # [s] after the wind
        decay = np.exp(-self.poles[..., np.newaxis] * ends[:, np.newaxis])
        decay[..., -1] = 0.0  # the last cell has no end
        cells = -reach[..., np.newaxis] * np.diff(decay, axis=-1)
        cells = np.concatenate([cells.real, cells.imag[:, complex_modes]], axis=1)
        return costates, reaches, poles, cells


def sign_changes(nominal: FloatArray) -> BoolArray:
    """Return whether the aerodynamic moment mu_alpha of n vehicles changes its sign, ``(n,)``.

    `nominal`: equations E = [A b w] at begin, middle and end of each step, ``(n, S, 3, m, m + 2)``.
    """
    moment = nominal[..., 1, 0]  # mu_alpha [1/s^2]: row of the attitude rate, column of attitude
    low, high = moment.min(axis=(1, 2)), moment.max(axis=(1, 2))  # over all steps
    return np.asarray(np.minimum(-low, high) > _ZERO_MOMENT_FRACTION * np.maximum(-low, high))


def unstable_modes_of(values: AnyArray, vectors: AnyArray) -> tuple[UnstableModes, ...]:
    """Return the unstable modes of n vehicles, two or three of them, the fastest one real.

    Cases with the same numbers of real modes and of pairs are in one record; cases with another
    number of modes, or a pair as the fastest, are omitted. `values`, `vectors`: poles [1/s] ``(n,
    m)`` and costates ``(n, m, m)`` of all modes, see `left_eigenvectors`.
    """
    unstable = (np.real(values) > 0.0) & (np.imag(values) >= 0.0)
    pairs = unstable & (np.imag(values) > 0.0)
    kinds = np.add(unstable, pairs, dtype=int)  # 0, 1 of a real mode, 2 of a pair
    groups = []
    for kind in np.unique(kinds, axis=0):
        if kind[0] != 1 or not 2 <= kind.sum() <= 3:  # the fastest is first, a pair counts twice
            continue
        cases = np.flatnonzero(np.all(kinds == kind, axis=-1))
        poles, costates = values[cases][:, kind > 0], vectors[cases][:, kind > 0]
        if not np.any(kind == 2):
            poles, costates = np.real(poles), np.real(costates)
        groups.append(UnstableModes(cases, poles, costates))
    return tuple(groups)


def minimum_peaks(
    modes: UnstableModes,
    steps: VaryingSteps,
    end: FloatArray,
    path: FloatArray,
    limits: FloatArray | None = None,
) -> FloatArray:
    """Return the minimum peaks [rad] of all control from the begin of steps on, ``(n, S + 1)``.

    They are the smallest peaks of any deflection that brings all unstable modes to zero in the
    end, from a vehicle in trim at the begin of a step. Zero where they are not computed: without
    `limits` from the second step on.

    Parameters
    ----------
    modes : UnstableModes
        Of these cases.
    steps : VaryingSteps
        Steps, equations and winds of these cases.
    end : ndarray
        Costate p and control reach R of the fastest mode at the end, ``(n, m + 1)``.
    path : ndarray
        States beyond attitude and rate that trim has led to at the ends of steps,
        ``(n, S + 1, m - 2)``.
    limits : ndarray, optional
        Trim over the dead band K [rad], the limit with which trim ends there, at the begin and the
        ends of steps, ``(n, S + 1)``. Peaks are computed from the last step backwards, down to the
        first that exceeds its limit; not where it is NaN.
    """
    # b, the column before the last of [A b w], at the end of the last step
    column = steps.equations[:, -1, 2, :, -2]
    column = np.broadcast_to(column, (len(end), column.shape[-1]))
    # costates p, control reaches and poles, and integrals of p.b over cells of the time after it
    costates, reaches, poles, cells = modes.after(end, column)
    peaks = np.zeros(path.shape[:2])
    if limits is None:
        limits = np.full(peaks.shape, np.nan)
    arrays = costates, reaches, poles, cells, path, limits
    # estimated run time, which decides between compiled and plain code, by numbers of operations
    count = costates.shape[1]  # modes
    work = peaks.size * count
    computed = len(path) + np.sum(
        ~np.isnan(limits)
    )  # at most so many peaks, each a minimum of sums
    sums = computed * marches.TANGENTS ** (count - 1) * float(path.shape[1] + cells.shape[-1])
    run(
        marches.minimum_peaks,
        (steps, *(np.require(x, float, ["C", "W"]) for x in arrays), peaks),
        cases=len(peaks),
        seconds=marches.PLAIN * work + marches.CELL_PLAIN * sums,
        compiled_seconds=marches.COMPILED * work + marches.CELL_COMPILED * sums,
    )
    return peaks


PRESSURES = (1.0, 1.25, 2.0)
"""q/q_n at which equations are computed; three of them determine E, E_1 and E_2."""
_ZERO_MOMENT_FRACTION = 1e-6
"""Fraction of the largest mu_alpha below which one of the opposite sign counts as zero."""
_QUICK_PATH_FRACTION = 0.1
"""Fraction of the fastest rate from which on the rate b1 of the path is comparable with it."""


@dataclass(frozen=True, eq=False)
class Equations:
    """Linear equations ``[A b w]`` of vehicles over the steps of their winds.

    Attributes
    ----------
    nominal : ndarray
        E at begin, middle and end of each step, ``(n, S, 3, m, m + 2)``; n or S is one where a
        single entry holds for all.
    slopes : ndarray
        E_1 and E_2 there, ``(n, S, 3, 2, m, m + 2)``.
    end : ndarray
        Costate p and control reach R at the end, ``(n, m + 1)``; NaN without an unstable real mode.
    paired : ndarray of bool
        Whether two unstable modes are a pair there, so that trim must never be limited, of the
        shape of the steps; axes of length one hold for all.
    quick_path : ndarray of bool
        Whether flights of the limited law decide, since b1 is negative, or b1 or a second pole is
        comparable with the fastest, ``(n,)``.
    modes : tuple of UnstableModes
        Those of vehicles with several unstable modes at the end, and the fastest mode alone of
        those whose deflection `reverses`.
    reverses : ndarray of bool
        Whether mu_alpha changes its sign, or the effect p.b of a deflection on the fastest mode,
        from the begin of the steps on, ``(n,)``: the limit that is sufficient when it is held is
        then no lower bound.
    absolute_reach : ndarray
        Integral of ``|p.b|`` after the end, of the costate in `end`, ``(n,)``.
    """

    nominal: FloatArray
    slopes: FloatArray
    end: FloatArray
    paired: BoolArray
    quick_path: BoolArray
    modes: tuple[UnstableModes, ...]
    reverses: BoolArray
    absolute_reach: FloatArray

    @classmethod
    def frozen(cls, vehicle: Vehicle, model: str, plane: str) -> Self:
        """Return the constant equations of vehicles, one or ``(n,)``, of a model in a plane."""
        return cls._of(
            [Plant.from_vehicle(at_pressure(vehicle, r), model, plane) for r in PRESSURES]
        )

    @classmethod
    def of_plant(cls, plant: Plant) -> Self:
        """Return the constant equations of plants, one or ``(n,)``, the same at any pressure."""
        return cls._of([plant] * len(PRESSURES))

    @classmethod
    def _of(cls, plants: Sequence[Plant]) -> Self:
        """Return the constant equations of plants, given at each pressure q/q_n of `PRESSURES`.

        A plant may be a batch ``(n,)``. Constant equations have a single step, with the same E =
        [A b w] at its begin, middle and end: state matrix, columns of deflection and of wind.
        """
        E, slopes = of_pressure(plants)  # slopes: E_1 and E_2, the change of E with q/q_n
        order, columns = E.shape[-2:]  # m states, m + 2 columns of [A b w]
        E = E.reshape(-1, order, columns)
        slopes = slopes.reshape(-1, 1, 1, 2, order, columns)
        _pole, paired = leading_pole(plants[0])  # whether the fastest unstable poles are a pair
        modes = left_eigenvectors(E[..., :order])  # all of them
        end = unstable_end(E, modes)  # costate, and in the last column the control reach
        return cls(
            nominal=np.repeat(E[:, np.newaxis, np.newaxis], 3, axis=2),
            slopes=np.repeat(slopes, 3, axis=2),
            end=end,
            paired=np.reshape(paired, (-1, 1, 1)),
            quick_path=np.ravel(has_quick_path(plants[0])),
            modes=unstable_modes_of(*modes),
            reverses=np.zeros(len(end), dtype=bool),
            absolute_reach=np.abs(end[:, -1]),
        )

    def at_steps(self, times: FloatArray) -> Self:
        """Return these equations: `times` [s] of steps are not used, the vehicle is constant."""
        return self

    @property
    def breakpoints(self) -> FloatArray:
        """Breakpoints [s] of the equations, in addition to the breakpoints of the wind: none."""
        return np.empty(0)

    def judged_at(self, ends: FloatArray) -> FloatArray:
        """Return the times [s] at which flights are judged: at the ends [s] of their winds."""
        return ends

    @property
    def has_real_mode(self) -> BoolArray:
        """Whether a real mode is unstable at the end of the steps, ``(n,)``."""
        return ~np.isnan(self.end[:, -1])

    @property
    def drifts(self) -> bool:
        """Whether the flight path is a state, beside attitude and rate: more rows of [A b w]."""
        return self.nominal.shape[-2] > 2

    @property
    def changes_sign(self) -> BoolArray:
        """Whether mu_alpha, in the matrices `nominal`, changes its sign over the steps, ``(n,)``.

        It is the aerodynamic moment per angle of attack over the inertia [1/s^2].
        """
        return sign_changes(self.nominal)

    def of(self, cases: IndexArray) -> Equations:
        """Return the equations of selected cases."""

        def selected(x: Any) -> Any:
            """Return the rows of the cases, or a single row that all cases share."""
            return x if len(x) == 1 else x[cases]

        # a single vehicle has the same modes in all cases
        modes = (group if len(self.end) == 1 else group.of(cases) for group in self.modes)
        return Equations(
            nominal=selected(self.nominal),
            slopes=selected(self.slopes),
            end=selected(self.end),
            paired=selected(self.paired),
            quick_path=selected(self.quick_path),
            modes=tuple(group for group in modes if group.cases.size),
            reverses=selected(self.reverses),
            absolute_reach=selected(self.absolute_reach),
        )

    @property
    def fastest(self) -> FloatArray:
        """Largest rate [1/s] of the attitude over the steps of n vehicles, ``(n,)``.

        It is sqrt(abs(mu_alpha)), mu_alpha [1/s^2] being the aerodynamic moment over the inertia.
        """
        # (n, S, 3), of begin, middle and end of S steps: row of the rate, column of attitude
        mu_alpha = self.nominal[..., 1, 0]
        return np.asarray(np.sqrt(np.abs(mu_alpha).max(axis=(1, 2))))

    @property
    def end_pole(self) -> FloatArray:
        """Growth rate p.A p [1/s] at the end of each vehicle's steps, ``(n,)``.

        The costate p, of the fastest mode, is of length one: where the vehicle is constant this is
        the mode's pole. `end` has p, and behind it the control reach; `nominal` the equations E =
        [A b w] at begin, middle and end of each step, ``(n, S, 3, m, m + 2)``.
        """
        order = self.nominal.shape[-2]
        costate, A = self.end[:, :order], self.nominal[:, -1, 2, :, :order]  # of the last step
        return np.asarray(np.einsum("ni,nij,nj->n", costate, A, costate))


def has_quick_path(plant: Plant) -> BoolArray:
    """Return whether the flight path of plants is about as fast as the attitude, ``(...)``.

    It is where b1 [1/s], the turn rate of the path per angle that the deflection trims (gamma' = b1
    delta/B), is negative or comparable with the fastest unstable pole, or a second unstable pole is
    comparable with it.
    """
    poles = unstable_poles(plant)
    if plant.model == "fixed-path" or not poles.shape[-1]:
        return np.zeros(plant.batch, dtype=bool)
    fast, b1 = np.real(poles[..., 0]), np.asarray(plant.coefficients.b1)
    with np.errstate(invalid="ignore"):  # NaN stands for a pole that is not there
        quick = (b1 < 0.0) | (b1 > _QUICK_PATH_FRACTION * fast)
        if poles.shape[-1] > 1:
            quick = quick | (np.real(poles[..., 1]) > COMPARABLE * fast)
    return np.asarray(quick)


def unstable_end(
    equations: FloatArray, modes: tuple[AnyArray, AnyArray] | None = None
) -> FloatArray:
    """Return costate and control reach, its last column, of constant equations, ``(n, m + 1)``.

    `equations`: [A b w] of n vehicles with m states, ``(n, m, m + 2)``: state matrix, columns of
    deflection and wind. The costate p is the left eigenvector of the fastest real unstable mode, of
    length one and with a positive component of the attitude rate; the control reach is p.b over the
    pole. NaN without such a mode. `modes`: poles [1/s] and costates of all modes, which are
    computed without them.
    """
    order = equations.shape[-2]
    values, rows = modes or left_eigenvectors(equations[..., :order])  # the fastest first
    unstable = (np.imag(values) == 0.0) & (np.real(values) > 0.0)
    fastest = np.argmax(unstable, axis=-1)[..., np.newaxis]
    exists = np.any(unstable, axis=-1, keepdims=True)
    pole = np.where(exists, np.real(np.take_along_axis(values, fastest, axis=-1)), np.nan)
    costate = np.real(np.take_along_axis(rows, fastest[..., np.newaxis], axis=-2)[..., 0, :])
    costate = costate * np.where(costate[..., 1:2] < 0.0, -1.0, 1.0)
    deflection_column = equations[..., order]  # b
    reach = np.vecdot(costate, deflection_column)[..., np.newaxis] / pole
    return np.where(exists, np.concatenate([costate, reach], axis=-1), np.nan)


def of_pressure(plants: Sequence[Plant]) -> tuple[FloatArray, FloatArray]:
    """Return E ``(..., m, m + 2)``, and E_1 and E_2 ``(..., 2, m, m + 2)``, of m states.

    With the dynamic pressure q, over q_n of the nominal flight, r = q/q_n, a plant's matrices A and
    columns b of deflection and w of wind are [A b w] = E + (r - 1) E_1 + (1/r - 1) E_2. `plants`:
    the plant at each of the ratios `PRESSURES`, of which the first is one.
    """
    nominal, *others = (np.concatenate(plant.matrices()[:2], axis=-1) for plant in plants)
    changes = np.stack([varied - nominal for varied in others], axis=-3)
    factors = np.array([[r - 1.0, 1.0 / r - 1.0] for r in PRESSURES[1:]])
    return nominal, np.einsum("kl,...lij->...kij", np.linalg.inv(factors), changes)
