"""The load of a plant in a wind, and a lower bound of the peak of every deflection within a load.

The load is alpha + M delta [rad], M being a ratio of moments. It is computed relative to a
reference deflection delta_0 that survives. The modes of eta = delta - delta_0 are scaled to
z' = s z + |s| eta and must not diverge. Unstable ones are summed backward in time, the others
forward, so that no number overflows:

    z(t) = -|s| INT_t^inf e^(-s (u - t)) eta du,      z(t) = |s| INT_0^t e^(s (t - u)) eta du,
    load = load_0 + M eta + sum of c z.

For any weights w of the load, and the density h for which INT h eta = INT w (load - load_0),

    peak >= (INT w load_0 - INT h delta_0 - bound INT |w| - rate INT |K|) / INT |h - K'|,

K(t) being the multiplier of the rate limit (not the dead band), zero without one. In h each
unstable mode may have a price, the multiplier of the condition that its state is zero at the end.
The weights and multipliers of a linear program are close to the best.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import AnyArray, BoolArray, ComplexArray, FloatArray
from tvclin.linear.modes import unstable_poles
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.numerics.pieces import moments
from tvclin.winds.histories import History

_NEGLIGIBLE_SHARE = 1e-12
"""Share of the load, relative to the largest, below which a stable mode is neglected."""
_NAME = "angle_of_attack"
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)  # of Gauss quadrature on (-1, 1)
_GAUSS_FRACTIONS, _GAUSS_WEIGHTS = (_NODES + 1.0) / 2.0, _WEIGHTS / 2.0  # on (0, 1)


@dataclass(frozen=True, eq=False)
class LoadCase:
    """A plant in a wind, and a deflection delta_0 [rad] that survives it, constant between nodes.

    `reference`: delta_0. `ratio`: M, the load of a unit deflection. `rate`: the rate limit [rad/s];
    infinite if none.
    """

    plant: Plant
    wind: History
    reference: History
    ratio: float = 0.0
    rate: float = np.inf

    @property
    def poles(self) -> AnyArray:
        """Poles s [1/s], ``(k,)``: unstable ones first; of a pair only the upper, Im s > 0."""
        return self._modes[0]

    @property
    def shares(self) -> AnyArray:
        """Coefficients c of the load alpha + M delta in the modes' states z, complex ``(k,)``.

        A mode contributes c z to the load [rad], a conjugate pair the real part of c z.
        """
        return self._modes[1]

    @property
    def unstable(self) -> BoolArray:
        """Whether each mode is unstable, ``(k,)``; unstable modes are the first."""
        return self._modes[2]

    @cached_property
    def rates(self) -> AnyArray:
        """Decay rates [1/s] of modes, ``(k,)``: s of unstable ones, summed backward; else -s."""
        return np.where(self.unstable, self.poles, -self.poles)

    @cached_property
    def sizes(self) -> FloatArray:
        """Sizes |s| [1/s] of the poles, ``(k,)``; 1 for a pole at zero.

        They scale the modes, z' = s z + |s| eta, so that all states are in rad, as eta, the
        deflection less the reference.
        """
        return np.where(self.poles == 0.0, 1.0, np.abs(self.poles))

    @cached_property
    def step_states(self) -> AnyArray:
        """States -z, ``(k,)``, that a constant unit deflection from then on requires; else 0.

        z is the scaled state of an unstable mode, z' = s z + |s| eta, at rest with z = -|s|/s eta.
        """
        return np.where(self.unstable, self.sizes / np.where(self.unstable, self.poles, 1.0), 0.0)

    @property
    def fastest(self) -> float:
        """The largest size |s| [1/s] of the poles of the modes."""
        return float(np.abs(self.poles).max())

    @cached_property
    def oscillating_zeros(self) -> ComplexArray:
        """Complex zeros [1/s] from deflection to load: a control without load oscillates there.

        The load is the last output of the plant, the angle of attack, plus M delta. Zeros are the
        poles with the deflection that keeps the load zero; one of each pair, with Im s > 0.
        """
        A, B, C, D = self.plant.matrices()
        through = D[-1, 0] + self.ratio
        if through == 0.0:
            return np.zeros(0, complex)
        zeros = np.linalg.eigvals(A - np.outer(B[:, 0], C[-1]) / through)
        return np.asarray(zeros[zeros.imag > 0.0], dtype=complex)

    def column(self, values: AnyArray) -> FloatArray:
        """Return complex values of modes ``(..., k)`` as reals ``(..., m)``, two for a pair.

        A conjugate pair counts as one mode; of a real mode the imaginary part, which is zero, is
        omitted.
        """
        components = np.stack([values.real, values.imag], axis=-1)
        return components.reshape(*values.shape[:-1], -1)[..., self.components]

    def matrix(self, values: AnyArray) -> FloatArray:
        """Return matrices ``(..., m, m)`` that multiply the modes by complex `values` ``(..., k)``.

        They act on the m real numbers of the k modes: the real part, and for a pair the imaginary
        part behind it. Rows and columns of imaginary parts that are no state are removed.
        """
        k = values.shape[-1]
        product = np.zeros((*values.shape[:-1], 2 * k, 2 * k))
        even = 2 * np.arange(k)
        product[..., even, even] = product[..., even + 1, even + 1] = values.real
        product[..., even + 1, even], product[..., even, even + 1] = values.imag, -values.imag
        return product[..., self.components, :][..., self.components]

    def load(self, times: FloatArray) -> FloatArray:
        """Return the load alpha + M delta [rad] at `times` [s], in their shape.

        It is under the reference deflection; M is `ratio`, alpha the angle of attack.
        """
        flat = times.ravel()
        angle = attitude_responses(self.plant, self.reference, self.wind, flat, [_NAME])[_NAME]
        return (angle + self.ratio * self.reference(flat)).reshape(times.shape)

    def load_in(
        self, reference_load: FloatArray, widths: FloatArray, ends: FloatArray
    ) -> FloatArray:
        """Return the load [rad] of a deflection within cells, at q even points with both ends.

        `reference_load`: load of the reference deflection at these points, ``(n, q)``. `widths`: of
        the cells [s], ``(n,)``. `ends`: the deflection at start and end of each cell, minus the
        reference [rad], ``(2, n)``. Returned: ``(n, q)``.

        It is the reference's load, plus M (`ratio`) times the difference, plus the sum of c z over
        the modes (`shares`): z is summed from node to node, unstable ones backward from their final
        state, and from the node to each point of the cell.
        """
        n, unstable = widths.size, self.unstable
        x = np.linspace(0.0, 1.0, reference_load.shape[1])  # fractions of a cell
        column, (start, end) = widths[:, np.newaxis], ends[:, :, np.newaxis]
        # over a cell, in the direction of the sum: decay of z, and weights of the deflection at the
        # node that is reached and at the other
        decay, reached, other = convolution_weights(self.rates, column)
        increment = self.sizes * np.where(
            unstable, -(reached * start + other * end), other * start + reached * end
        )
        z = np.zeros((n + 1, unstable.size), dtype=complex)  # at the nodes
        z[n] = -self.step_states * ends[1, -1]
        for k in range(n - 1, 0, -1):
            z[k] = np.where(unstable, decay[k] * z[k + 1] + increment[k], 0.0)
        for k in range(n):
            z[k + 1] = np.where(unstable, z[k + 1], decay[k] * z[k] + increment[k])
        eta = start * (1.0 - x) + end * x  # deflection at the points, minus the reference
        load = reference_load + self.ratio * eta
        for i in range(unstable.size):
            # from a node to the points: the end of the cell backward, or its start
            distance = 1.0 - x if unstable[i] else x
            decay_to, at_point, at_node = convolution_weights(self.rates[i], column * distance)
            node, eta_node, sign = (z[1:, i], end, -1.0) if unstable[i] else (z[:-1, i], start, 1.0)
            added = sign * self.sizes[i] * (at_point * eta + at_node * eta_node)
            load = load + (self.shares[i] * (decay_to * node[:, np.newaxis] + added)).real
        return load

    @cached_property
    def _modes(self) -> tuple[AnyArray, AnyArray, BoolArray]:
        """Poles of k modes [1/s], their coefficients in the load, and which are unstable, ``(k,)``.

        Stable modes that are not seen in the load are omitted, and the lower pole of each pair. A
        mode contributes its coefficient times its state z to the load [rad], with z' = s z + |s|
        delta; a pair the real part of that.
        """
        A, B, C, _ = self.plant.matrices()
        poles, right = np.linalg.eig(A)
        order = np.argsort(-poles.real, kind="stable")  # unstable modes first
        poles, right = poles[order].astype(complex), right[:, order]
        driven = np.linalg.solve(right, B[:, 0])  # x = right z, so z' = s z + driven delta
        # The angle of attack is the last output, C[-1] right z; with z scaled by |s|/driven:
        share = (C[-1] @ right) * driven / np.where(poles == 0.0, 1.0, np.abs(poles))
        unstable = np.arange(poles.size) < unstable_poles(self.plant).size
        seen = np.abs(share) > _NEGLIGIBLE_SHARE * np.abs(share).max()
        retained = (poles.imag >= 0.0) & (unstable | seen)
        coefficients = np.where(poles.imag > 0.0, 2.0, 1.0) * share  # 2: for the conjugate too
        return poles[retained], coefficients[retained], unstable[retained]

    @cached_property
    def components(self) -> BoolArray:
        """Whether each real and imaginary part is a state, ``(2 k,)``: both for a pair."""
        pairs = self.poles.imag > 0.0
        return np.stack([np.ones_like(pairs), pairs], axis=-1).ravel()


def convolution_weights(
    rates: ArrayLike, widths: FloatArray
) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Return the decay e^(-rate width) over cells, and two weights of a line's convolution.

    INT_0^width e^(-rate y) line(y) dy is start_weights line(0) + end_weights line(width), with the
    distance y [s] from the node at which it is taken. Both weights are in s.
    """
    integrals = moments(np.asarray(rates) * widths, 1)
    end_weights = widths * integrals[..., 1]
    start_weights = widths * integrals[..., 0] - end_weights
    return np.exp(-np.asarray(rates) * widths), start_weights, end_weights


@dataclass(frozen=True, eq=False)
class LoadWeights:
    """Weights of the load at nodes and within cells, and prices of the unstable modes.

    `widths`: of the cells [s], ``(n,)``. `node_weights`: weights at the nodes, ``(n + 1,)``.
    `density_ends`: the weight density [1/s] at start and end of each cell, linear between, ``(2,
    n)``. `prices`: of the unstable modes at the first node, ``(k,)``; zero for the others.
    """

    case: LoadCase
    widths: FloatArray
    node_weights: FloatArray
    density_ends: FloatArray
    prices: ComplexArray

    def proof(self, reference: FloatArray, ramp: BoolArray | None) -> tuple[float, float]:
        """Return the numbers A and N of the lower bound (weighted load - A)/N of the peak.

        A = INT h delta_0 dt + rate INT |K| dt [rad] and N = INT |h - K'| dt, to infinity. INT h eta
        dt is the weighted sum of the loads of a deflection eta, so that h [1/s] (`_density`) weighs
        eta; delta_0 is the reference deflection, and K the multiplier of the rate limit (not the
        dead band). `reference`: delta_0 in the n cells [rad], ``(n,)``; its last value stays.
        `ramp`: whether the rate limit binds in each cell, ``(n,)``; None without a rate limit.
        """
        n = self.widths.size
        edge = self._density(np.tile([0.0, 1.0], (n, 1)))  # h at both ends of each cell
        crosses = edge[:, 0] * edge[:, 1] < 0.0
        root = np.where(crosses, edge[:, 0] / np.where(crosses, edge[:, 0] - edge[:, 1], 1.0), 1.0)
        # in each cell: integral of h before and after its change of sign at the fraction `root`,
        # and of h times the time since the begin of the cell [s]
        areas, first = np.zeros((2, n)), np.zeros(n)
        for k, (low, high) in enumerate(((np.zeros(n), root), (root, np.ones(n)))):
            x = low[:, np.newaxis] + (high - low)[:, np.newaxis] * _GAUSS_FRACTIONS
            h = self._density(x) * _GAUSS_WEIGHTS * ((high - low) * self.widths)[:, np.newaxis]
            areas[k] = h.sum(axis=1)
            first += (h * x).sum(axis=1) * self.widths
        # integrals of h and |h| in each cell; rate INT |K| dt
        area, size, of_rate = areas.sum(axis=0), np.abs(areas).sum(axis=0), 0.0
        if ramp is not None:
            of_rate = self._apply_ramps(area, first, size, ramp)  # size: INT |h - K'| dt from here
        # Integral of h after the last node, by unstable mode: a unit deflection that stays constant
        # from there on requires the state -step_states at that node, which has the factor `_before`
        # in the weighted load. The reference stays constant too.
        later = (self._before[-1] * -self.case.step_states)[self.case.unstable]
        of_reference = float(area @ reference) + float(later.real.sum() * reference[-1])
        return of_reference + of_rate, float(size.sum() + np.abs(later).sum())

    @cached_property
    def _before(self) -> ComplexArray:
        """Factor of each unstable mode's state at n + 1 nodes in the weighted load, ``(n + 1, k)``.

        The weighted load is the integral of the load times its weights, the multipliers of the
        bounds. The state is a sum backward in time, so that a deflection changes the load before
        it: the factor adds up the weights there, decayed to the node, and the price (multiplier) of
        the condition on the mode at the first node. Of the k columns only unstable ones are used.
        """
        start, end = self.density_ends  # weight per time [1/s]; the end is near the node reached
        return self._decayed_weights(self.prices, end, start, self.node_weights[1:], self.widths)

    @cached_property
    def _after(self) -> ComplexArray:
        """Weights of the load from each of n + 1 nodes on, decayed to it, by mode ``(n + 1, k)``.

        Stable modes use them. Each is the mode's coefficient in the load, of `shares`, times the
        weights of cells (their `density_ends`) and of nodes. `_decayed_weights` goes forward in
        time: nodes and cells are reversed, from the last node on, and so is the result.
        """
        (start, end), nodes = self.density_ends[:, ::-1], self.node_weights[::-1]
        at_last_node = self.case.shares * nodes[0]
        return self._decayed_weights(at_last_node, start, end, nodes[1:], self.widths[::-1])[::-1]

    def _decayed_weights(
        self,
        first: ComplexArray,
        near_ends: FloatArray,
        far_ends: FloatArray,
        nodes: FloatArray,
        widths: FloatArray,
    ) -> ComplexArray:
        """Return w of k modes at n + 1 nodes in the order of a march, ``(n + 1, k)``.

        A march over a cell of width h to the next node is w <- e^(-rate h) w + c (W + node weight),
        with the mode's coefficient c in the load and W, the weights within the cell, decayed to
        that node. `first`: w at the first node, ``(k,)``. `near_ends`, `far_ends`: weight density
        [1/s] at the end of each cell that is this next node, and at the other, ``(n,)``. `nodes`:
        weights of the next nodes, ``(n,)``. `widths`: of the cells [s], ``(n,)``.
        """
        decay, near, far = convolution_weights(self.case.rates, widths[:, np.newaxis])
        of_cells = near * near_ends[:, np.newaxis] + far * far_ends[:, np.newaxis]
        weights = np.zeros((widths.size + 1, first.size), dtype=complex)
        weights[0] = first
        for k in range(widths.size):
            weights[k + 1] = decay[k] * weights[k] + self.case.shares * (of_cells[k] + nodes[k])
        return weights

    def _density(self, x: FloatArray) -> FloatArray:
        """Return h [1/s], the weight of a deflection at a time in the weighted load, ``(n, q)``.

        It has a direct part, M (`ratio`, the load alpha + M delta per deflection) times the weight
        per time of the load then, and one by each mode, of the weights of the load that it changes,
        decayed to that time: of the load before it by unstable modes, after it by stable ones. `x`:
        fractions of the n cells, ``(n, q)``. Of a mode, `shares` is the load of its state, and
        `sizes` |s| [1/s] the gain from deflection to that state.
        """
        c = self.case
        # weight per time [1/s] of the load at start and end of each cell, linear between them
        column, (start, end) = self.widths[:, np.newaxis], self.density_ends[:, :, np.newaxis]
        here = start * (1.0 - x) + end * x  # at the time of the deflection
        density = c.ratio * here
        for i in range(c.poles.size):
            if c.unstable[i]:
                distance, origin, node, sign = x, start, self._before[:-1, i], -1.0
            else:
                distance, origin, node, sign = 1.0 - x, end, self._after[1:, i], 1.0
            # `node`: weights beyond the cell, decayed to its node; `origin`: weight per time there;
            # `near`, `far`: factors of the weight per time at the deflection's time and at the node
            decay, near, far = convolution_weights(c.rates[i], column * distance)
            weight = decay * node[:, np.newaxis] + c.shares[i] * (near * here + far * origin)
            density = density + sign * c.sizes[i] * weight.real
        return density

    def _apply_ramps(
        self, area: FloatArray, first: FloatArray, size: FloatArray, ramp: BoolArray
    ) -> float:
        """Return the rate limit times INT |K| dt, and write INT |h - K'| dt on ramps into `size`.

        h is the weight of a deflection in the load, K the multiplier of the rate limit (not the
        dead band). On a ramp, successive cells in which that binds, K' is h minus a constant, so
        that K is zero at both its ends; at the onset, where the deflection is zero, it need not be.

        `area`, `first`, `size`: integrals over each cell of h, of h times the time [s] from its
        start, and of |h|, ``(n,)``. `ramp`: whether the rate limit binds in each cell, ``(n,)``.
        """
        integral = 0.0  # INT |K| dt
        edges = np.flatnonzero(np.diff(np.concatenate([[0], ramp, [0]])))
        for begin, end in edges.reshape(-1, 2):  # cells of each ramp
            w, areas = self.widths[begin:end], area[begin:end]
            mean = areas.sum() / w.sum() if begin else 0.0  # of h: the constant; none at the onset
            K = -np.append(np.cumsum((areas - mean * w)[::-1])[::-1], 0.0)  # at the nodes
            # INT K dt = K_end w - INT t (h - mean) dt in a cell; trapezoid where K changes its sign
            by_parts = np.abs(K[1:] * w - first[begin:end] + mean * w**2 / 2.0)
            trapezoid = w * (np.abs(K[1:]) + np.abs(K[:-1])) / 2.0
            integral += float(np.where(K[1:] * K[:-1] < 0.0, trapezoid, by_parts).sum())
            size[begin:end] = abs(mean) * w  # |h - K'| is the constant
        return self.case.rate * integral
