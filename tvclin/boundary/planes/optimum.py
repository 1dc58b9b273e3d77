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
from numpy.typing import NDArray

from tvclin.base.cards import card
from tvclin.base.errors import single
from tvclin.boundary.optimum.minimum_peak import Certificate, optimum_deflection
from tvclin.boundary.planes.pair import Pair, checked
from tvclin.boundary.stops import CircularStop, PolygonStop, Stop, Vectors, along
from tvclin.linear.plant import Plant
from tvclin.winds.plane_wind import PlaneWind, unit

FloatArray = NDArray[np.float64]

_CELLS = 500
_THINNEST = 1e-8
"""A cell that is thinner, times the fastest pole, has no moments but rounding."""
_NODES = 4
_STEPS = 400
_CELLS_GAP, _WIDEST_GAP = 1e-5, 1e-3
"""What cells leave of a gap, and the widest that is called solved."""
_FEW_CORNERS = 32
_BESIDE = np.array([-0.1, -0.03, -0.01, -0.003, 0.0, 0.003, 0.01, 0.03, 0.1])
"""Angles [rad] from the direction of a cell at which corners are looked for that share it."""
_EVERY = 16
"""Cells between instants from which on slow modes may be served alone."""
OK = "ok"
NOT_CONVERGED = "not converged: the certificate says how far off it is"


@dataclass(frozen=True, eq=False)
class PlaneOptimum:
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

    def _repr_html_(self) -> str:
        rows = [
            ("limit, of full trim", self.limit, "-"),
            ("peak", np.degrees(self.peak), "deg"),
            ("proved lower bound", np.degrees(self.certificate.dual), "deg"),
            ("status", self.status, ""),
        ]
        return card("Least limit in two planes", rows)


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
    >>> wind = tv.PlaneWind.veering(gust, angle=0.0, rate=np.pi / 7.5)
    >>> round(tv.plane_optimum(plant, wind).limit, 4)
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
    if pair.equal and pair.wind.one_direction and isinstance(stop, CircularStop):
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
    return _answer(pair, times, best.deflection(times) * unit(direction), best.certificate)


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
    """Minimise N^2/2 - l . d in cells; of few corners, by a linear program."""
    size = float(np.abs(moments.demands).max())
    d, cells, stop = moments.demands / size, moments.cells, moments.stop
    if isinstance(stop, PolygonStop) and stop.corners.size <= _FEW_CORNERS:
        solved = _by_corners(cells, d, stop.corners)
        if solved is not None:
            return _mended(moments, onset, *solved, size)
    dual, deflections = _by_dual(cells, d, stop)
    whole = _mended(moments, onset, dual, deflections, size)
    if isinstance(stop, PolygonStop) and whole[2].gap >= _WIDEST_GAP:
        # where a cell belongs to two corners the dual does not say how much of each
        near = stop.farthest((dual @ cells)[:, np.newaxis] * np.exp(1j * _BESIDE))
        solved = _by_corners(cells, d, near)
        if solved is not None:
            mended = _mended(moments, onset, dual, solved[1], size)
            whole = min(whole, mended, key=lambda one: one[2].primal)
    fast = np.concatenate([poles == poles.max() for poles in moments.pair.poles])
    if whole[2].gap < _CELLS_GAP or np.all(fast):
        return whole
    some, deflections = _by_dual(cells[fast], d[fast], stop)
    best = np.zeros(d.size)
    best[fast] = some
    late = [_late(moments, d, fast, deflections, k) for k in range(0, deflections.size, _EVERY)]

    def far(held: Vectors) -> float:
        missing = d - np.real(np.conj(cells) @ held)
        return float(stop.gauge(held).max() + np.abs(missing).sum())

    served = _mended(moments, onset, best, min(late, key=far), size)
    return min(whole, served, key=lambda one: one[2].primal)


def _late(
    moments: _Moments, d: FloatArray, fast: NDArray[np.bool_], early: Vectors, k: int
) -> Vectors:
    """What serves the fast modes up to a cell, and from there on holds what the slow ones lack.

    Where slow poles are far slower, they are served when the fast ones are long settled; their
    multipliers are then smaller than any number.
    """
    cells, found = moments.cells, early.copy()
    for axis in (1.0, 1j):
        mine = np.flatnonzero(~fast & (moments.axes == axis))
        row = np.real(np.conj(axis) * cells[mine[0]]) if mine.size else np.zeros(found.size)
        later = float(row[k:].sum())
        if later:  # else its share of these cells is below all numbers
            part = np.real(np.conj(axis) * found)
            held = (d[mine[0]] - row[:k] @ part[:k]) / later
            found[k:] += axis * (held - part[k:])
    return found


def _by_dual(cells: Vectors, d: FloatArray, stop: Stop) -> tuple[FloatArray, Vectors]:
    """The multipliers that minimise N^2/2 - l . d, and the deflections at the stop."""
    from scipy.optimize import minimize, root  # late: they take 0.3 s to import

    def height(multipliers: FloatArray) -> tuple[float, FloatArray]:
        summed = multipliers @ cells
        farthest = stop.farthest(summed)
        norm = float(along(summed, farthest).sum())
        turned = np.real(np.conj(cells) @ farthest)
        return float(0.5 * norm**2 - multipliers @ d), norm * turned - d

    options = {"gtol": 1e-11, "maxiter": _STEPS}
    best = minimize(height, d, jac=True, method="BFGS", options=options).x
    # a slow pole may have a multiplier many decades below the others: then slopes say more
    level = root(lambda multipliers: height(multipliers)[1], best, method="hybr", tol=1e-14)
    if np.abs(level.fun).max() < np.abs(height(best)[1]).max():
        best = level.x
    summed = best @ cells
    return best, float(stop.support(summed).sum()) * stop.farthest(summed)


def _by_corners(
    cells: Vectors, d: FloatArray, corners: Vectors
) -> tuple[FloatArray, Vectors] | None:
    """The multipliers and the deflections of the linear program for corners, of all or each cell.

    In each cell the deflection is a sum of corners with weights w >= 0, sum w <= L. None where no
    sum of these corners meets the conditions.
    """
    from scipy.optimize import linprog  # late: it takes 0.3 s to import
    from scipy.sparse import coo_array, eye_array, hstack, kron

    count, each = cells.shape[1], corners.shape[-1]
    moments = np.real(np.conj(cells)[:, :, np.newaxis] * corners).reshape(d.size, -1)
    sums = kron(eye_array(count), np.ones((1, each)))
    shared = hstack([sums, coo_array(-np.ones((count, 1)))]).tocsr()
    found = linprog(
        np.append(np.zeros(count * each), 1.0),
        A_ub=shared,
        b_ub=np.zeros(count),
        A_eq=np.hstack([moments, np.zeros((d.size, 1))]),
        b_eq=d,
        method="highs",
    )
    if found.x is None:
        return None
    weights = found.x[:-1].reshape(count, each)
    return found.eqlin.marginals, np.sum(weights * corners, axis=-1)


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
