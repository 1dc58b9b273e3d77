"""The linear program of the minimum peak, or the minimum load, of a deflection on given nodes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base.arrays import ComplexArray, FloatArray, IndexArray
from tvclin.boundary.optimum.load_case import LoadCase, LoadWeights, convolution_weights
from tvclin.boundary.optimum.moments import separate_nodes

PEAK, LOAD = "peak", "load"
_INSIDE = np.linspace(0.0, 1.0, 9)
"""Fractions of a cell at which the load is computed."""
_SIMPSON = np.array([1.0, 4.0, 2.0, 4.0, 2.0, 4.0, 2.0, 4.0, 1.0]) / 24.0
"""Weights of the mean over `_INSIDE`, by Simpson's rule."""
_ACTIVE_DISTANCE = 1e-6
"""Relative distance at which a limit counts as active: a linear program's tolerance is 1e-7."""
_MAX_WIDTH_OVER_TIME_CONSTANT = 0.25
"""Cell width, relative to the fastest time constant, above which the static load is bounded."""
_STATIC_LOAD_FRACTION = 0.98
"""Largest static load in such cells, relative to the load bound."""
_SPLIT_EXCESS_FRACTION = 0.2
"""Excess of the load, relative to the largest, above which a cell is split too."""
_CELL_DIVISIONS = 4
"""Even parts of a cell that is split."""
_MAX_ITERATIONS_PER_VARIABLE = 50
"""Iterations of a program over its variables, which are two or three unless numbers are extreme."""


@dataclass(frozen=True, eq=False)
class Solution:
    """A deflection that survives, and the lower bound that the prices of its program prove.

    `peak`, `load`: the largest size [rad] of the deflection and of its load, between the nodes too.
    `bound`, `slope`: no deflection has a peak below ``bound - slope * load`` [rad]. `finer`: nodes
    [s] of a program that may do better.
    """

    peak: float
    load: float
    bound: float
    slope: float
    finer: FloatArray


@dataclass(frozen=True, eq=False)
class LoadProgram:
    """A case on nodes [s], ``(n + 1,)``, the onset first; the last value stays constant.

    In a cell the deflection is constant; linear where it contributes to the load; and continuous,
    from zero on, where its rate is limited.
    """

    case: LoadCase
    nodes: FloatArray

    @cached_property
    def widths(self) -> FloatArray:
        """Lengths of the cells [s], ``(n,)``."""
        return np.diff(self.nodes)

    @cached_property
    def reference(self) -> FloatArray:
        """Reference deflection of the case [rad] in the middle of each cell, ``(n,)``."""
        return self.case.reference(0.5 * (self.nodes[1:] + self.nodes[:-1]))

    @cached_property
    def reference_load(self) -> FloatArray:
        """Load ``alpha + M delta`` [rad] under the reference deflection, ``(n, 9)``.

        M is `case.ratio`, the bending moment per deflection over that per angle of attack. In each
        cell the load is taken at nine times, fractions `_INSIDE` of the cell; the last is just
        before the next node, where it may jump.
        """
        times = self.nodes[:-1, np.newaxis] + self.widths[:, np.newaxis] * _INSIDE
        times[:, -1] = np.nextafter(self.nodes[1:], -np.inf)
        return self.case.load(times)

    def solve(self, aim: str, bound: float) -> Solution | None:
        """Return the deflection of minimum peak at a load bound, or of minimum load at a peak.

        The load is alpha + M delta [rad], angle of attack and deflection with the weight M of the
        case. None if infeasible. `aim`: which is minimised, `PEAK` or `LOAD`. `bound`: of the other
        [rad].
        """
        from scipy.optimize import linprog  # late: it takes 0.3 s to import

        below, upper = self._limits(aim, bound)  # inequalities of load, peak and rate
        equal, right = self._states  # equations of motion of the modes, in units of `_unit` [rad]
        free = np.full(equal.shape[1], np.inf)
        # bounds of the variables: deflections, states of the modes at the nodes, and the minimised
        if aim == LOAD:
            free[: self._variables] = bound / self._unit
        else:  # the load could oscillate in wide cells, so that deflections are bounded there too
            in_wide_cells, fraction = self._static_bounds
            free[in_wide_cells] = fraction * bound / self._unit
        bounds, cost = np.column_stack([-free, free]), np.append(np.zeros(free.size - 1), 1.0)
        for method in ("highs-ds", "highs-ipm"):
            # with presolve two modes far apart end "unknown"
            options = {"presolve": False, "maxiter": _MAX_ITERATIONS_PER_VARIABLE * free.size}
            result = linprog(
                cost, below, upper, equal, right, bounds, method=method, options=options
            )
            if result.status == 0:
                load = bound if aim == PEAK else float(result.fun) * self._unit
                return self._solution(result, load)
            if result.status == 2:  # infeasible
                break
        return None

    @cached_property
    def _unit(self) -> float:
        """Unit of the deflection [rad] in the program: the reference's peak, or static trim."""
        c = self.case
        # B: trim deflection per angle of attack
        static_trim = abs(float(c.plant.coefficients.B) * float(c.wind.peak))
        return float(np.abs(self.reference).max()) or static_trim

    @cached_property
    def _levels(self) -> tuple[Any, Any]:
        """Sparse matrices from the variables to the deflection at start and at end of each cell.

        With a rate limit the variables are the deflections at the ends of the cells, and each
        cell starts at the end of its predecessor, the first at zero. Otherwise, where the
        deflection contributes to the load (`case.ratio`, M, is not zero), they are the deflections
        at all starts, then at all ends; else one constant for each cell.
        """
        from scipy import sparse  # late: it takes 0.1 s to import

        n = self.widths.size
        identity, none = sparse.identity(n, format="csr"), sparse.csr_matrix((n, n))
        if np.isfinite(self.case.rate):
            return sparse.diags([np.ones(n - 1)], [-1], shape=(n, n), format="csr"), identity
        if self.case.ratio == 0.0:
            return identity, identity
        return sparse.hstack([identity, none]).tocsr(), sparse.hstack([none, identity]).tocsr()

    @property
    def _variables(self) -> int:
        """Number of the program's variables that are values of the deflection, the first ones."""
        to_starts, _ = self._levels
        return int(to_starts.shape[1])

    @cached_property
    def _static_bounds(self) -> tuple[IndexArray, float]:
        """Indices of the deflection's variables in wide cells, and their bound over the load bound.

        Wide cells are much longer than the fastest time constant. With rows at the nodes alone the
        load could oscillate between them; so the load of the deflection in equilibrium, delta (1 +
        M B)/B, is within the bound there: B is the trim deflection per angle of attack, and M the
        load per deflection.
        """
        B, M = float(self.case.plant.coefficients.B), self.case.ratio
        wide = np.flatnonzero(self.widths * self.case.fastest > _MAX_WIDTH_OVER_TIME_CONSTANT)
        variables = np.concatenate([level[wide].indices for level in self._levels])
        return np.unique(variables), _STATIC_LOAD_FRACTION * abs(B / (1.0 + M * B))

    @cached_property
    def _states(self) -> tuple[Any, FloatArray]:
        """Equality rows, sparse, of the modes' states, and their right sides ``(rows,)``.

        Variables: the deflections, the states z at the nodes but the first, where z is zero, and
        the minimised one. Rows join the states at neighbouring nodes, and set the final ones. An
        unstable mode s is z(start) = decay z(end) - |s| (w_start eta(start) + w_end eta(end)), a
        stable one z(end) = decay z(start) + |s| (...), with `convolution_weights` w [s] and eta,
        the deflection minus the reference. `column` and `matrix` make reals of complex pairs; all
        is divided by `_unit` [rad], the size of the solution.
        """
        from scipy import sparse

        case, n = self.case, self.widths.size
        to_starts, to_ends = self._levels  # variables to deflections, start and end of cells
        decay, start_weights, end_weights = convolution_weights(
            case.rates, self.widths[:, np.newaxis]
        )
        start = case.column(case.sizes * np.where(case.unstable, start_weights, -end_weights))
        end = case.column(case.sizes * np.where(case.unstable, end_weights, -start_weights))
        # coefficients of the states at the start and at the end of each cell
        of_start = case.matrix(np.where(case.unstable, 1.0, -decay))
        of_end = case.matrix(np.where(case.unstable, -decay, 1.0))
        unstable = np.repeat(case.unstable, 2)[case.components]  # of each real number of the states
        final_states, m = case.column(case.step_states)[unstable], unstable.size
        driven = _diagonal(start[..., np.newaxis]) @ to_starts
        driven = driven + _diagonal(end[..., np.newaxis]) @ to_ends
        # without the columns of the first node: a cell's end is on the diagonal, its start before
        between = sparse.hstack([driven, _diagonal(of_end) + _diagonal(of_start, 1)])
        # final state of each unstable mode, from which the last deflection, held, returns it
        final = sparse.hstack(
            [
                sparse.csr_matrix(final_states[:, np.newaxis]) @ to_ends[n - 1],
                sparse.csr_matrix((final_states.size, (n - 1) * m)),
                sparse.csr_matrix(np.eye(m)[unstable]),
            ]
        )
        rows = sparse.vstack([between, final])
        # no row contains the minimised variable, the last one
        rows = sparse.hstack([rows, sparse.csr_matrix((rows.shape[0], 1))]).tocsr()
        right = (start + end) * self.reference[:, np.newaxis]
        return rows, np.append(right.ravel(), final_states * self.reference[-1]) / self._unit

    @cached_property
    def _loads(self) -> tuple[Any, FloatArray, FloatArray]:
        """Rows of the load over all variables, and its largest and smallest value if all are zero.

        Variables: deflections, states z of the modes at the nodes but the first, and the minimised
        one. Rows are at these nodes; the wind may jump there, so that the load without variables
        has two values. Where the deflection adds M delta and may jump, rows are at the starts of
        the cells, then at their ends. A mode adds c z (`shares` of the case). Loads are in `_unit`.
        """
        from scipy import sparse

        n, M = self.widths.size, self.case.ratio
        c = self.case.column(np.conj(self.case.shares))  # Re(c z) in real and imaginary part of z
        at_ends = sparse.kron(sparse.identity(n), c[np.newaxis], format="csr")  # load of the modes
        start, end = self.reference_load[:, 0] / self._unit, self.reference_load[:, -1] / self._unit
        if M == 0.0:
            after = np.append(start[1:], end[-1])
            rows = [sparse.csr_matrix((n, self._variables)), at_ends, sparse.csr_matrix((n, 1))]
            return sparse.hstack(rows).tocsr(), np.maximum(end, after), np.minimum(end, after)
        to_starts, to_ends = self._levels  # variables to deflections, start and end of cells
        at_starts = sparse.vstack([sparse.csr_matrix((1, at_ends.shape[1])), at_ends[:-1]])
        blocks = [sparse.vstack([M * to_starts, M * to_ends]), sparse.vstack([at_starts, at_ends])]
        rows = sparse.hstack([*blocks, sparse.csr_matrix((2 * n, 1))]).tocsr()
        # the variables are whole deflections, so M delta of the reference is taken from its load
        base = np.concatenate([start, end]) - M * np.tile(self.reference, 2) / self._unit
        return rows, base, base

    def _limits(self, aim: str, bound: float) -> tuple[Any, FloatArray]:
        """Return inequality rows, sparse, and their upper bounds ``(rows,)``: load, peak and rate.

        Variables and bounds are in units of `_unit` [rad]. `aim`: the quantity minimised, also the
        last variable: `PEAK`, with `bound` [rad] on the load, or `LOAD`, without. A minimised
        load also bounds deflections in wide cells (`_static_bounds`): a fraction of the load is
        the largest deflection there.
        """
        from scipy import sparse

        # load = loads @ variables + what the reference deflection and the wind add on both sides of
        # each node, of which `high` is the larger and `low` the smaller
        loads, high, low = self._loads
        count, unknowns = loads.shape[1], self._variables  # the first variables are deflections

        def under(rows: Any, minimised: bool) -> Any:
            """Return sparse `rows`, from which the last variable is subtracted if `minimised`."""
            return sparse.hstack([rows[:, :-1], np.full((rows.shape[0], 1), -float(minimised))])

        identity = sparse.eye(unknowns, count, format="csr")
        parts = [under(rows, minimised=aim == LOAD) for rows in (loads, -loads)]
        load_bound = bound / self._unit if aim == PEAK else 0.0
        values = [load_bound - high, load_bound + low]
        if aim == PEAK:
            parts += [under(rows, minimised=True) for rows in (identity, -identity)]
            values += [np.zeros(2 * unknowns)]
        else:
            wide, fraction = self._static_bounds
            static = identity[wide] * (1.0 / fraction)
            parts += [under(rows, minimised=True) for rows in (static, -static)]
            values += [np.zeros(2 * wide.size)]
        if np.isfinite(self.case.rate):
            to_starts, to_ends = self._levels  # variables to deflections, both ends of cells
            rest = sparse.csr_matrix((to_ends.shape[0], count - unknowns))
            change = sparse.hstack([to_ends - to_starts, rest])
            parts += [change, -change]
            values += [np.tile(self.case.rate * self.widths / self._unit, 2)]
        return sparse.vstack(parts).tocsr(), np.concatenate(values)

    def _solution(self, result: Any, bound: float) -> Solution:
        """Return the solution of a solved program, `result` of linprog, at a load `bound` [rad].

        Its deflection, the first variables in units of `_unit`, is corrected to satisfy the
        conditions to rounding, and its load computed between the nodes too. `_proof` gives the
        lower bound from the prices of the constraints, `_finer` the nodes of the next program.
        """
        to_starts, to_ends = self._levels  # variables to deflections, start and end of cells
        deflection = self._corrected(result.x[: self._variables] * self._unit)
        ends = np.stack([to_starts @ deflection, to_ends @ deflection])
        inside = self.case.load_in(self.reference_load, self.widths, ends - self.reference)
        # prices of the inequalities in the order of `_limits`: load above, load below, .., rate
        _, high, _ = self._loads
        n, rows, prices = self.widths.size, high.size, result.ineqlin.marginals
        rate_prices = None
        if np.isfinite(self.case.rate):
            rate_prices = prices[-n:] - prices[-2 * n : -n]
        lower, slope = self._proof(
            prices[rows : 2 * rows] - prices[:rows], result.eqlin.marginals, rate_prices
        )
        return Solution(
            peak=float(np.abs(ends).max()),
            load=float(np.abs(inside).max()),
            bound=lower,
            slope=slope,
            finer=self._finer(ends, inside, bound),
        )

    def _corrected(self, u: FloatArray) -> FloatArray:
        """Return the variables [rad] after the smallest change that satisfies the conditions.

        `u`: deflections at ends of cells or in them [rad], as the program has them to its
        tolerance. The condition of each unstable mode s, times its size |s|, is that the integral
        of e^(-s t) eta dt from the first node on is zero, eta being the deflection minus the
        reference. The least-squares solution of smallest size is added.
        """
        case = self.case
        to_starts, to_ends = self._levels  # from `u` to the deflection, start and end of cells
        _, *ends = convolution_weights(case.rates, self.widths[:, np.newaxis])
        decayed = np.exp(
            -np.where(case.unstable, case.rates, 0.0) * (self.nodes - self.nodes[0])[:, np.newaxis]
        )
        # factors of the deflection at start and end of each cell in each condition
        of_start, of_end = (decayed[:-1] * weights * case.sizes for weights in ends)
        # |s|/s times the last value, which stays constant: the integral behind the last node
        of_end[-1] += decayed[-1] * case.step_states
        unstable = np.repeat(case.unstable, 2)[case.components]  # of each real number of the states
        of_start, of_end = (case.column(x)[:, unstable].T for x in (of_start, of_end))
        # rows @ u is the integral of the deflection, by real condition; scales normalise them
        rows = of_start @ to_starts + of_end @ to_ends
        scales = np.abs(of_start).sum(axis=1) + 1e-300
        lacking = ((of_start + of_end) @ self.reference - rows @ u) / scales
        return u + np.linalg.lstsq(rows / scales[:, np.newaxis], lacking, rcond=None)[0]

    def _proof(
        self, weights: FloatArray, prices: FloatArray, rate_prices: FloatArray | None
    ) -> tuple[float, float]:
        """Return b [rad] and s: no deflection whose largest load is L has a peak below b - s L.

        By duality: a sum of loads with weights w is at most L times the sum of |w|. It is at least
        W - A - N times the peak, with W the sum for the reference deflection, and A and N those of
        `LoadWeights.proof`. So b = (W - A)/N and s is the sum of |w| over N.
        `weights`: multipliers of the load rows at the nodes; with M, of both ends of each cell.
        `prices`: multipliers of the unstable modes' conditions. `rate_prices`: of the rate limit by
        cell, or None.
        """
        case, n = self.case, self.widths.size
        if case.ratio == 0.0:  # M: the load is the angle of attack alone
            _, high, low = self._loads  # largest and smallest load with variables of zero
            node_weights, density_ends = np.append(0.0, weights), np.zeros((2, n))
            # at a jump of the wind a positive weight has the larger load, a negative the smaller
            weighted_load = float(weights @ np.where(weights > 0.0, high, low)) * self._unit
        else:
            # weights at both ends of a cell as a density [1/s], straight in the cell, of the same
            # sum and first moment; the clip keeps it of one sign, and any weights prove a bound
            node_weights, (start, end) = np.zeros(n + 1), weights.reshape(2, n) / self.widths
            total = start + end
            weight_share = np.where(total == 0.0, 0.5, start / np.where(total == 0.0, 1.0, total))
            density_share = np.clip(3.0 * weight_share - 1.0, 0.0, 1.0)  # both of the start
            density_ends = 2.0 * total * np.stack([density_share, 1.0 - density_share])
            first, last = density_ends[:, :, np.newaxis]
            density = first * (1.0 - _INSIDE) + last * _INSIDE  # at nine times of each cell
            weighted_load = float(self.widths @ (self.reference_load * density @ _SIMPSON))
        weighed = LoadWeights(
            case=case,
            widths=self.widths,
            node_weights=node_weights,
            density_ends=density_ends,
            prices=_complex(case, prices),
        )
        # the rate limit binds where its price is not zero
        ramp = None if rate_prices is None else rate_prices != 0.0
        A, N = weighed.proof(self.reference, ramp)
        if N == 0.0:
            return 0.0, 0.0
        return (weighted_load - A) / N, float(np.abs(weights).sum()) / N

    def _finer(self, ends: FloatArray, inside: FloatArray, bound: float) -> FloatArray:
        """Return the nodes [s], with further ones in cells next to which a limit begins to bind.

        Cells beside a node at which a limit begins or ceases to bind, or with much load beyond its
        bound, are split. `ends`: deflection [rad] at start and end of each of n cells, ``(2, n)``.
        `inside`: load at q times in each cell [rad], ``(n, q)``. `bound`: its bound [rad].
        """
        peak, rate, largest = np.abs(ends).max(), self.case.rate, np.abs(inside).max(axis=1)
        # sign of the limit that binds in each cell, else 0: peak at both its ends, load, and rate
        binding = [
            np.where(np.abs(end) > peak * (1.0 - _ACTIVE_DISTANCE), np.sign(end), 0.0)
            for end in ends
        ]
        binding.append(np.where(largest > bound * (1.0 - _ACTIVE_DISTANCE), 1.0, 0.0))
        slope = (ends[1] - ends[0]) / self.widths
        at_rate = np.abs(slope) > rate * (1.0 - _ACTIVE_DISTANCE)
        binding.append(np.where(at_rate, np.sign(slope), 0.0))
        changes = np.any(np.diff(np.stack(binding), axis=1) != 0.0, axis=0)  # at each inner node
        excess = largest - bound
        split = np.append(changes, False) | np.append(False, changes)
        split |= excess > max(_SPLIT_EXCESS_FRACTION * excess.max(), _ACTIVE_DISTANCE * bound)
        start, width, (first, last) = self.nodes[:-1][split], self.widths[split], ends[:, split]
        fractions = [np.full(width.size, k / _CELL_DIVISIONS) for k in range(1, _CELL_DIVISIONS)]
        # a cell of the constant deflection `first` has its mean by a switch from peak to -peak, or
        # back, at this fraction
        switch = 0.5 * (1.0 + first / (peak or 1.0))
        fractions += [switch, 1.0 - switch]
        for level in (peak, -peak):  # where a line of full rate through an end comes to the peak
            fractions.append(np.clip(np.abs(level - first) / (rate * width), 0.0, 1.0))
            fractions.append(np.clip(1.0 - np.abs(level - last) / (rate * width), 0.0, 1.0))
        new_nodes = np.concatenate([self.nodes, *(start + width * x for x in fractions)])
        return separate_nodes(new_nodes, 1e-6 / self.case.fastest)


def _complex(case: LoadCase, prices: FloatArray) -> ComplexArray:
    """Return the complex prices of the k modes of a `case`, multipliers of their states, ``(k,)``.

    `prices`: multipliers of the real conditions at the onset: one of a real unstable mode, and of a
    pair of the real part x and the imaginary part y, whose sum is Re((p1 - j p2) (x + j y)). Stable
    modes have no condition, and zero.
    """
    parts, unstable = np.zeros(2 * case.poles.size), np.repeat(case.unstable, 2) & case.components
    parts[unstable] = prices[: np.count_nonzero(unstable)]
    return np.asarray(parts[::2] - 1j * parts[1::2])


def _diagonal(blocks: FloatArray, behind: int = 0) -> Any:
    """Return the sparse block-diagonal matrix ``(n m, n q)`` of blocks ``(n, m, q)``.

    `behind`: number of block columns by which blocks move to the left; the first ones leave it.
    """
    from scipy import sparse

    n, m, q = blocks.shape
    # index of the first block of each block row, and their number; the first rows are empty
    starts = np.concatenate([np.zeros(behind, dtype=int), np.arange(n - behind + 1)])
    parts = (blocks[behind:], np.arange(n - behind), starts)
    matrix = sparse.bsr_matrix(parts, shape=(n * m, n * q)).tocsr()
    matrix.eliminate_zeros()
    return matrix
