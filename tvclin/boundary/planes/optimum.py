"""The least limit of two planes that know the whole wind, over all their modes, with its proof.

The conditions are moments of the deflection from the onset on, integral p e^(-p t) delta dt = d for
each pole of each plane, delta anywhere in L S. With multipliers l, and axes a_k of 1 in pitch and j
in yaw, the vector l(t) = sum l_k a_k p_k e^(-p_k t) gives

    L = max over l of  l . d / N(l),        N(l) = integral of h_S(l(t)) dt

and the deflection is the point of L S that is furthest along l(t). With one pole, the same in both
planes, it is the gauge of d. Otherwise it is solved for a deflection that is constant in each of
many cells, which is feasible, and so from above; N by quadrature bounds it from below.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import single
from tvclin.boundary.optimum.minimum_peak import Certificate, optimum_deflection
from tvclin.boundary.planes.pair import Pair, checked
from tvclin.boundary.stops import CircularStop, Stop, Vectors
from tvclin.linear.plant import Plant
from tvclin.winds.plane_wind import PlaneWind, unit_vector

_CELLS = 500
_THINNEST = 1e-8
"""A cell that is thinner, times the fastest pole, has no moments but rounding."""
_NODES = 32
"""In each cell: where a polygon's support has a kink the error falls with their square."""
_ROUNDS, _LEFT = 200, 1e-7
"""Of cutting planes at most, and what they may leave of a gap; some twenty do."""
_WIDEST_GAP = 1e-3
"""The widest gap that is called solved."""
OK = "ok"
NOT_CONVERGED = "not converged: the certificate says how far off it is"


@dataclass(frozen=True, eq=False)
class PlaneOptimum(Shown):
    """The deflection of least limit for two planes in one wind.

    Attributes
    ----------
    limit : float
        The least limit that is reached, over B alpha_w,max of the largest wind vector.
    peak : float
        The same [rad], in the measure of the stop.
    times : ndarray
        From when on each deflection is held [s], ``(n,)``; the last for ever.
    deflections : ndarray of complex
        What is held [rad], pitch + j yaw, ``(n,)``.
    certificate : Certificate
        The peak that is reached, the bound [rad] below which no deflection can be, and the
        violation of the conditions. Its `tail` is zero.
    status : str
        "ok", or in words what is different.
    """

    limit: float
    peak: float
    times: FloatArray
    deflections: Vectors
    certificate: Certificate
    status: str

    _keys = "limit_over_trim=limit peak_deg lower_bound_deg=certificate.dual status"


def plane_optimum(
    plant: Plant, wind: PlaneWind, stop: Stop | None = None, yaw_plant: Plant | None = None
) -> PlaneOptimum:
    """Return the deflection of least limit in both planes that leaves no growing exponential.

    Parameters
    ----------
    plant, wind, stop, yaw_plant
        As of `plane_limit`, but one plant and one wind. A cluster counts as the polygon
        `Stop.inscribed`, which is a little smaller.

    Returns
    -------
    PlaneOptimum
        From the onset of the wind on. With a certificate: of planes that differ and of models with
        two unstable poles the gap is that of cells, some 1e-6.

    Raises
    ------
    InputError
        As `plane_limit`, and for a batch.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> gust = tv.TriangularWind(peak=0.08, duration=7.5)
    >>> wind = tv.winds.PlaneWind.veering(gust, angle=0.0, rate=np.pi / 7.5)
    >>> round(tv.boundary.plane_optimum(plant, wind).limit, 4)
    0.3122
    """
    stop = CircularStop() if stop is None else stop
    single("plant, wind", checked(plant, wind, stop, yaw_plant))
    pair = Pair((plant, yaw_plant or plant), wind)
    return least_in_planes(pair, stop.inside)


def least_in_planes(pair: Pair, stop: Stop, left: float | None = None) -> PlaneOptimum:
    """Return `plane_optimum` of arguments that are checked; from `left` [s] on, trimmed until then.

    Without `left` it is from the onset of the wind on.
    """
    if left is not None:
        asked = np.concatenate([pair.left_at(plane, left) for plane in (0, 1)])
        return _answer(pair, *_solved(_Moments(pair, stop, asked), left))
    if pair.equal and pair.wind.unidirectional and isinstance(stop, CircularStop):
        return _along_a_line(pair)
    start = np.asarray([float(pair.wind.onset)])
    moments = _Moments(
        pair, stop, np.concatenate([pair.of_modes(plane, start)[:, 0] for plane in (0, 1)])
    )
    if pair.equal and moments.poles.size == 2:
        held = pair.demanded(start)
        peak = float(stop.gauge(held)[0])
        return _answer(pair, start, held, Certificate(peak, peak, 0.0, 0.0, 0.0))
    return _answer(pair, *_solved(moments, float(start[0])))


def _along_a_line(pair: Pair) -> PlaneOptimum:
    """The scalar answer: in a round stop nothing is gained by leaving the line."""
    direction = pair.wind.direction
    onset = float(pair.wind.onset)
    best = optimum_deflection(pair.plants[0], pair.wind.component(direction), start=onset)
    times = np.append(onset, best.switch_times)
    return _answer(pair, times, best.deflection(times) * unit_vector(direction), best.certificate)


def _answer(
    pair: Pair, times: FloatArray, deflections: Vectors, proof: Certificate
) -> PlaneOptimum:
    scale = abs(float(np.asarray(pair.plants[0].coefficients.B))) * float(pair.wind.peak)
    status = OK if proof.gap < _WIDEST_GAP else NOT_CONVERGED
    return PlaneOptimum(proof.primal / scale, proof.primal, times, deflections, proof, status)


@dataclass(frozen=True, eq=False)
class _Moments:
    """The conditions, in cells that are even in e^(-p t) for every pole.

    `demands` are what every mode of pitch and then of yaw asks for from the start of the control.
    """

    pair: Pair
    stop: Stop
    demands: FloatArray

    @cached_property
    def poles(self) -> FloatArray:
        return np.concatenate(self.pair.poles)

    @cached_property
    def axes(self) -> Vectors:
        """1 for each pole of the pitch plane, j for each of the yaw plane."""
        pitch, yaw = (one.size for one in self.pair.poles)
        return np.repeat([1.0 + 0.0j, 1.0j], [pitch, yaw])

    @cached_property
    def edges(self) -> FloatArray:
        """Times [s] after the onset at which cells begin, ``(n + 1,)``; the last ends never."""
        even = np.arange(_CELLS) / _CELLS
        every = [-np.log1p(-even) / p for p in np.unique(self.poles)]
        edges = np.unique(np.concatenate(every))
        apart = np.append(True, np.diff(edges) > _THINNEST / self.poles.max())
        return np.append(edges[apart], np.inf)

    @cached_property
    def cells(self) -> Vectors:
        """The moments of each cell, ``(k, n)``, of a deflection of one."""
        decayed = np.exp(-self.poles[:, np.newaxis] * self.edges)
        return self.axes[:, np.newaxis] * (decayed[:, :-1] - decayed[:, 1:])

    @cached_property
    def nodes(self) -> tuple[Vectors, FloatArray]:
        """Functions a p e^(-p t) at the nodes of a quadrature, ``(k, m)``; weights ``(m,)``.

        Gauss-Legendre in x = e^(-p t) of the slowest pole, in which the last cell ends too.
        """
        slow = self.poles.min()
        x = np.exp(-slow * self.edges)
        spots, parts = np.polynomial.legendre.leggauss(_NODES)
        width = (x[:-1] - x[1:])[:, np.newaxis]
        inside = (x[1:, np.newaxis] + width * (1.0 + spots) / 2.0).ravel()
        weights = (width * parts / 2.0).ravel() / (slow * inside)
        decay = np.exp(np.outer(self.poles / slow, np.log(inside)))
        return (self.poles * self.axes)[:, np.newaxis] * decay, weights

    def norm(self, multipliers: FloatArray) -> float:
        """N by quadrature."""
        values, weights = self.nodes
        return float(weights @ self.stop.support(multipliers @ values))


def _solved(moments: _Moments, onset: float) -> tuple[FloatArray, Vectors, Certificate]:
    """Solve l . d -> max, N(l) <= 1 in cells, by cutting planes (Kelley 1960).

    N(l) is the largest l . m of the moments m of any deflection v within S, and one that reaches it
    is furthest along l everywhere. Of the v_i of earlier rounds a small linear program knows

        max of l . d with l . m_i <= 1   =   min of sum w_i with sum w_i m_i = d, w >= 0

    so that sum w_i v_i meets the conditions with the peak sum w_i, while l . d/N(l) is below. What
    is furthest along its l comes next, and along what lies halfway from the best l to it.
    """
    from scipy.optimize import linprog  # late: it takes 0.3 s to import

    stop, cells = moments.stop, moments.cells
    # Functions that are orthonormal over the cells, each counted over the reach in its plane; N(l)
    # is at least what S holds of that plane, 1/g, times |l| of its functions, and so bounds these.
    even, triangle = np.linalg.qr(np.concatenate([cells.real, cells.imag], axis=1).T)
    reach = stop.support(moments.axes)
    rows = (even[: cells.shape[1]] + 1j * even[cells.shape[1] :]).T / reach[:, np.newaxis]
    triangle = triangle * reach[:, np.newaxis]
    d = np.linalg.lstsq(triangle.T, moments.demands, rcond=None)[0]
    size = float(np.abs(d).max())
    d /= size
    ends = np.maximum(stop.gauge(moments.axes), stop.gauge(-moments.axes)) * reach
    best, trial, shares = np.zeros(d.size), d, np.zeros(0)
    known: list[Vectors] = []
    met: list[FloatArray] = []
    for _ in range(_ROUNDS):
        for multipliers in (trial, 0.5 * (best + trial)):
            known.append(stop.farthest(multipliers @ rows))
            met.append(np.real(np.conj(rows) @ known[-1]))
            one = multipliers / (multipliers @ met[-1])
            best = one if one @ d > best @ d else best
        found = linprog(
            -d,
            A_ub=np.array(met),
            b_ub=np.ones(len(met)),
            bounds=np.stack([-ends, ends], axis=1),
            method="highs",
            options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
        )
        if found.x is None:  # by rounding; what is known so far is a deflection too
            break
        trial, shares = found.x, -found.ineqlin.marginals
        if trial @ d <= (1.0 + _LEFT) * (best @ d):
            break
    deflections = np.asarray(known)[: shares.size].T @ shares
    multipliers = np.linalg.lstsq(triangle, best, rcond=None)[0]
    return _mended(moments, onset, multipliers, deflections, size)


def _mended(
    moments: _Moments, onset: float, best: FloatArray, deflections: Vectors, size: float
) -> tuple[FloatArray, Vectors, Certificate]:
    """Meet the conditions to rounding, and say what is reached and what is proved."""
    d, cells, stop = moments.demands / size, moments.cells, moments.stop
    for _ in range(2):  # the second time for the rounding of the first
        missing = d - np.real(np.conj(cells) @ deflections)
        basis = moments.axes[:, np.newaxis] * np.exp(-np.outer(moments.poles, moments.edges[:-1]))
        gram = np.real(np.conj(cells) @ basis.T)
        deflections = deflections + np.linalg.lstsq(gram, missing, rcond=None)[0] @ basis
    peak = float(stop.gauge(deflections).max())
    dual = float(best @ d) / moments.norm(best)
    left = np.abs(d - np.real(np.conj(cells) @ deflections))
    residual = float((left / (np.abs(cells).sum(axis=1) * peak + np.abs(d))).max())
    gap = (peak - dual) / peak
    proof = Certificate(peak * size, dual * size, gap, residual, 0.0)
    return onset + moments.edges[:-1], deflections * size, proof
