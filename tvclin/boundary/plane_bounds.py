"""Lower bounds of a limit that two planes share: the wind known, and without a forecast.

Demands of the modes of both planes are vectors pitch + j yaw. With the wind known, the conditions
are moments of the deflection from the onset on, integral p e^(-p t) delta dt = d for each pole of
each plane, delta anywhere in L S, S being the limit shape. With multipliers l, and axes a_k of 1 in
pitch and j in yaw, the vector l(t) = sum l_k a_k p_k e^(-p_k t) gives

    L = max over l of  l . d / N(l),        N(l) = integral of h_S(l(t)) dt

and the deflection is the point of L S that is furthest along l(t). With one pole, the same in both
planes, it is the gauge of d. Otherwise it is solved for a deflection that is constant in each of
many cells, which is feasible, and so from above; N by quadrature bounds it from below.

Without a forecast, let I(s, T) be the demand of the wind between s and T. z(T) must be in the
recoverable set y S when the wind stops at T, so z(s) - I(s, T) is in y S as well; z(0) = 0. Hence

    g_S(-I(0, T)) <= y,    I(s, T) in y (S - S)    for all s < T.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from tvclin.base.arrays import ComplexArray, FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, broadcast, ending, instance, single
from tvclin.base.fields import spec
from tvclin.boundary.limit import OK
from tvclin.boundary.limit_shapes import CircularShape, LimitShape, Vectors
from tvclin.boundary.optimum.minimum_peak import NOT_CONVERGED, Certificate, optimum_deflection
from tvclin.linear.deflections import trim_deflection
from tvclin.linear.modes import poles_text, unstable_poles, wind_over_deflection
from tvclin.linear.plant import Plant
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind, unit_vector

Height = Callable[[FloatArray, FloatArray], FloatArray]
"""Function of two times [s] that broadcast, of which a maximum is sought."""

_MIN_POLE_SEPARATION = 1e-4
"""Smallest distance between the two fastest poles, relative to the fastest."""
_MAX_TIMES = 8192
"""Largest number of times at which a wind is computed, in each plane."""
_TIMES = 80
"""Times of the first grid, about, in each of its two variables."""
_DIRECTIONS = 180
"""Directions in half a turn at which S - S is computed; it is symmetric."""
_GRID_POINTS = 33
"""Points of a refined grid in each of its two variables."""
_REFINEMENT_FACTOR = 8.0
"""Width of a refined grid relative to the next."""
_GRID_REFINEMENTS = 5
"""Number of refined grids."""
_CELLS = 500
"""Cells for each unstable pole."""
_MIN_WIDTH_OVER_TIME_CONSTANT = 1e-8
"""Smallest cell width over the fastest time constant: the moments of a smaller one are rounding."""
_NODES = 32
"""Quadrature nodes in each cell; at a kink of a polygon's support the error falls with their
square."""
_MAX_CUTTING_PLANES = 200
"""Largest number of steps of the cutting-plane method; some twenty suffice."""
_RELATIVE_GAP = 1e-7
"""Relative gap of the cutting-plane method at which it stops."""
_MAX_GAP = 1e-3
"""Largest relative gap of a certificate whose status is "ok"."""


@dataclass(frozen=True)
class PlanePair:
    """Plants of pitch and of yaw, the same one if they are equal, and a wind that ends."""

    plants: tuple[Plant, Plant]
    wind: PlaneWind

    @cached_property
    def poles(self) -> tuple[FloatArray, FloatArray]:
        """Unstable poles [1/s] in pitch and in yaw, ``(N,)`` each, the fastest first."""
        pitch, yaw = (np.real(unstable_poles(plant)) for plant in self.plants)
        return pitch, yaw

    @cached_property
    def equal(self) -> bool:
        """Whether the two planes are one plant."""
        first, second = self.plants
        if first.model != second.model:
            return False
        coefficients = [plant.coefficients for plant in self.plants]
        if first.model == "fixed-path":  # which has no gravity term
            coefficients = [replace(plane, q=0.0) for plane in coefficients]
        return first is second or coefficients[0] == coefficients[1]

    @cached_property
    def trim(self) -> PlaneWind:
        """Trim deflection [rad] over time in pitch and yaw, which keeps the attitude."""
        winds = self.wind.pitch, self.wind.yaw
        pitch, yaw = (trim_deflection(*plane) for plane in zip(self.plants, winds, strict=True))
        return PlaneWind(pitch=pitch, yaw=yaw)

    @cached_property
    def _strengths(self) -> tuple[FloatArray, FloatArray]:
        """Factors -B K1 p [1/s] from remaining wind integral to demand, ``(N,)`` in each plane.

        Of each of N unstable poles p; B K1, trim per wind angle times drift factor, is
        N_wind(p)/N_deflection(p) of the attitude. The remaining wind integral at t [s] is that of
        e^(-p (s - t)) alpha_w(s) over the times s from t on. The demand at t is the deflection
        [rad], constant from t on, that cancels the excitation of the mode by that wind.
        """
        pitch, yaw = (
            np.asarray(-wind_over_deflection(plant, poles) * poles)
            for plant, poles in zip(self.plants, self.poles, strict=True)
        )
        return pitch, yaw

    def required_constant(self, t: FloatArray) -> Vectors:
        """Return the constant deflection [rad] required after `t` [s] of trim, pitch + j yaw.

        By the residue condition (4b) of the report it is the mean of the remaining trim with the
        weight p e^(-p (r - t)) at times r, p being the fast pole of each plane.
        """
        return self._fast_demand(self.trim, self.poles, t)

    def wind_demand(self, t: FloatArray) -> Vectors:
        """Return the wind demand [rad] after `t` [s] of the fastest modes, pitch + j yaw.

        It is the constant deflection from `t` on that cancels the excitation of these modes by the
        wind from `t` on.
        """
        return self._fast_demand(self.wind, self._strengths, t)

    def _fast_demand(
        self, history: PlaneWind, factors: tuple[FloatArray, FloatArray], t: FloatArray
    ) -> Vectors:
        """Return the remaining integrals of trim or wind times factors [rad], pitch + j yaw.

        Of the fastest mode of each plane. `history`: of both planes [rad]. `factors`: from integral
        to demand [1/s], ``(N,)`` in each plane. `t`: times [s] from which the integral counts.
        """
        components = (history.pitch, history.yaw)
        pitch, yaw = (
            factor[0] * component.remaining_integral(poles[0], t)
            for factor, component, poles in zip(factors, components, self.poles, strict=True)
        )
        return np.asarray(pitch + 1j * yaw)

    def mode_demands(self, plane: int, t: float, after_trim: bool) -> FloatArray:
        """Return the demand [rad] of each mode of a plane from `t` [s] on, ``(N,)``.

        The demand of an unstable mode is the constant deflection from `t` on that leaves it without
        excitation. With I the remaining integral at its pole p it is p I of the trim deflection,
        since trim itself is such a deflection, and I of the wind times its factor in `_strengths`
        for a vehicle at rest at `t`. `plane`: 0 is pitch and 1 yaw. `after_trim`: whether the
        vehicle is trimmed up to then; else it is at rest.
        """
        history, factors = (self.trim, self.poles) if after_trim else (self.wind, self._strengths)
        component, poles = (history.pitch, history.yaw)[plane], self.poles[plane]
        return factors[plane] * np.asarray(component.remaining_integral(poles, np.array([t])))[:, 0]

    def demand_between(self, s: FloatArray, T: FloatArray) -> ComplexArray:
        """Return the demand [rad] of the wind from `s` to `T` [s], pitch + j yaw; zero for T < s.

        It is the constant deflection from `s` on that cancels the excitation of the fastest mode
        of each plane by this wind.
        """
        # less the demand of the wind after T, which has the factor e^(-p (T - s)) at s
        later, span = self.wind_demand(T), np.maximum(T - s, 0.0)
        pitch, yaw = (np.exp(-poles[0] * span) for poles in self.poles)
        demand = self.wind_demand(s) - (np.real(later) * pitch + 1j * np.imag(later) * yaw)
        return np.where(T > s, demand, 0.0)

    def moment_driver(self, t: FloatArray) -> Vectors:
        """Return the driver -B alpha_w [rad] of the report's exit on wind at `t` [s], complex.

        The exit of the dead band is where its gauge, the limit that just reaches it, is K times the
        limit; B is the trim deflection per angle of attack of each plane.
        """
        pitch, yaw = (plant.coefficients.B for plant in self.plants)
        w = self.wind(t)
        return np.asarray(-pitch * np.real(w) - 1j * yaw * np.imag(w))

    def times(self) -> FloatArray:
        """Return times [s] that resolve the wind: both sides of its breakpoints, and between them.

        In each piece at least 64 times, and eight for each radian or e-folding of its fastest term,
        within `_MAX_TIMES`.
        """
        times = []
        for history in (self.wind.pitch, self.wind.yaw):
            longest = np.diff(history.knots).max(initial=0.0)
            oscillation = np.abs(history.pieces.rates).max(initial=0.0) * longest
            max_points = max(_MAX_TIMES // history.knots.size, 8)
            points = int(np.clip(8.0 * oscillation, min(64, max_points), max_points))
            times.append(history.probe_times(points))
        merged = np.unique(np.concatenate(times))
        return merged[(merged >= self.wind.onset) & (merged <= self.wind.end)]


def checked_batch(
    plant: Plant, wind: PlaneWind, limit_shape: LimitShape, yaw_plant: Plant | None
) -> tuple[int, ...]:
    """Return the shape of the batch; `InputError` for a plant or wind without two-plane limits.

    `yaw_plant`: of the yaw plane; None where it is `plant`.
    """
    instance("plant", plant, Plant, "see Plant.from_vehicle")
    if isinstance(wind, History):
        raise InputError(
            "wind must have a direction: give PlaneWind.towards(wind, angle), or a pitch and a yaw"
            " history"
        )
    instance("wind", wind, PlaneWind, "see PlaneWind.towards")
    instance("limit_shape", limit_shape, LimitShape, "such as CircularShape")
    plants = {"plant": plant}
    if yaw_plant is not None:
        instance("yaw_plant", yaw_plant, Plant, "see Plant.from_vehicle")
        plants["yaw_plant"] = yaw_plant
    ending("wind", wind.end)
    for name, plane_plant in plants.items():
        poles = unstable_poles(plane_plant)
        real = poles.size > 0 and not np.any(np.imag(poles))
        if not real or np.any(np.isnan(poles[..., 0])):
            reason = "it has none" if not poles.size else "a pair in two planes is not treated"
            message = reason if plane_plant.batch else f"it has {poles_text(poles)}"
            raise InputError(f"{name} must have unstable poles, all real; {message}")
        if np.any(poles[..., 1:] > (1.0 - _MIN_POLE_SEPARATION) * poles[..., :1]):
            raise InputError(f"{name} must have a fastest pole that is single; two are together")
        if np.any(np.asarray(plane_plant.coefficients.B) == 0.0):
            raise InputError(f"{name} must have an aerodynamic moment, mu_alpha other than zero")
    return broadcast(
        wind=wind.batch, **{name: plane_plant.batch for name, plane_plant in plants.items()}
    )


def _difference_gauge(limit_shape: LimitShape) -> Callable[[ComplexArray], FloatArray]:
    """Return a function of vectors to a lower bound of their gauge of S - S, for the shape S.

    S - S are the differences of any two points of S, and the gauge is the factor by which it just
    contains a vector v. It is exact for a symmetric `limit_shape`, S, where S - S is 2 S. Else it
    is the largest d v/(h(d) + h(-d)) over some directions d, h(d) being the support of S, its
    extent along d, so that h(d) + h(-d) is the width of S along d.
    """
    if limit_shape.symmetric:
        return lambda vector: limit_shape.gauge(vector) / 2.0
    directions = np.exp(1j * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS)
    normals = directions / (limit_shape.support(directions) + limit_shape.support(-directions))
    components = np.stack([normals.real, normals.imag])
    return lambda v: np.abs(np.stack([v.real, v.imag], axis=-1) @ components).max(axis=-1)


def no_forecast_bound(pair: PlanePair, limit_shape: LimitShape) -> float:
    """Return the lower bound y [rad] for laws that know the wind, but not when it stops.

    The demand between two times is the constant deflection vector that cancels what the wind does
    to the fast modes of the planes of `pair` in between. From the onset to any time it must be in
    y S, between any two times in y (S - S), S being the `limit_shape`. The maximum is taken on a
    grid and refined. With planes that differ, it is computed for states from which a constant
    vector returns: up to two percent too large where the poles differ by half.
    """
    onset, end = float(pair.wind.onset), float(pair.wind.end)
    shown = pair.times()  # breakpoints of the wind, and times [s] that show its shape
    times = shown[:: max(1, shown.size // _TIMES)]
    times = np.union1d(np.append(times, [onset, end]), np.linspace(onset, end, _TIMES // 2))
    differences = _difference_gauge(limit_shape)
    # the scale y [rad] with which y (S - S) contains the demand from s to T [s], and y S that from
    # the onset to T, whatever s, S being the limit shape of a limit of 1 rad
    heights: list[Height] = [
        lambda s, T: differences(pair.demand_between(s, T)),
        lambda _, T: limit_shape.gauge(pair.demand_between(np.full((1, 1), onset), T)),
    ]
    step, bounds = float(np.diff(times).max()), []
    for height in heights:
        grid = height(times[:, np.newaxis], times)
        s, T = (float(times[i]) for i in np.unravel_index(np.argmax(grid), grid.shape))
        bounds += [float(grid.max()), _refined_maximum(height, (s, T), step, (onset, end))]
    return max(bounds)


def _refined_maximum(
    height: Height, start: tuple[float, float], step: float, ends: tuple[float, float]
) -> float:
    """Return the largest value of `height` near a `start`, by grids about the best point, or zero.

    `start`: both times. `step`: half width [s] of the first grid; each later one is narrower.
    `ends`: first and last time [s] of both. Zero if no value is positive.
    """
    s, T = start
    best = 0.0
    offsets = np.linspace(-1.0, 1.0, _GRID_POINTS)
    for _ in range(_GRID_REFINEMENTS):
        first, last = (np.clip(centre + step * offsets, *ends) for centre in (s, T))
        values = height(first[:, np.newaxis], last)
        i, k = np.unravel_index(np.argmax(values), values.shape)
        if values[i, k] > best:
            best, s, T = float(values[i, k]), float(first[i]), float(last[k])
        step /= _REFINEMENT_FACTOR
    return best


@dataclass(frozen=True, eq=False)
class PlaneOptimum(Shown):
    """The deflection of minimum limit for two planes in one wind.

    Attributes
    ----------
    limit : float
        Minimum limit, normalised by B alpha_w,max of the largest wind vector.
    peak : float
        Minimum limit [rad], in the measure of the limit shape.
    times : ndarray
        Times [s] from which each deflection is constant, ``(n,)``; the last does not end.
    deflections : ndarray of complex
        Constant deflections [rad], pitch + j yaw, ``(n,)``.
    certificate : Certificate
        The peak [rad] of the deflections, a lower bound [rad] of every peak, and the violation
        of the conditions. Its `tail` is zero.
    status : str
        "ok", or the reason why it is not.
    """

    limit: float = field(metadata=spec(label="limit over trim"))
    peak: float = field(metadata=spec("angle"))
    times: FloatArray
    deflections: Vectors
    certificate: Certificate = field(
        metadata=spec("angle", name="lower_bound", of="certificate.dual")
    )
    status: str = field(metadata=spec())


def plane_optimum(
    plant: Plant,
    wind: PlaneWind,
    limit_shape: LimitShape | None = None,
    yaw_plant: Plant | None = None,
) -> PlaneOptimum:
    """Return the deflection of minimum limit in both planes that cancels every unstable mode.

    Parameters
    ----------
    plant, wind, limit_shape, yaw_plant
        Parameters of `plane_limit`, but one plant and one wind. A cluster counts as the polygon
        `LimitShape.inscribed`, which is a little smaller.

    Returns
    -------
    PlaneOptimum
        From the onset of the wind on. With a certificate: for planes that differ, and models with
        two unstable poles, its gap is of a deflection that is constant in cells, about 1e-6.

    Raises
    ------
    InputError
        Where `plane_limit` raises it, and for a batch.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> gust = tv.TriangularWind(peak=0.08, duration=7.5)
    >>> wind = tv.winds.PlaneWind.veering(gust, angle=0.0, rate=np.pi / 7.5)
    >>> round(tv.boundary.plane_optimum(plant, wind).limit, 4)
    0.3122
    """
    limit_shape = CircularShape() if limit_shape is None else limit_shape
    single("plant, wind", checked_batch(plant, wind, limit_shape, yaw_plant))
    pair = PlanePair((plant, yaw_plant or plant), wind)
    return minimum_in_planes(pair, limit_shape.inside)


def minimum_in_planes(
    pair: PlanePair, limit_shape: LimitShape, exit_time: float | None = None
) -> PlaneOptimum:
    """Return `plane_optimum` of checked arguments: plants and wind of `pair` in a `limit_shape`.

    The control begins after trim up to `exit_time` [s]; without it, at the onset of the wind. Two
    cases need no program: a wind of one direction with a round shape is a scalar optimum, and with
    one pole, the same in both planes, the constant deflection that the wind demands is optimal.
    """
    starts_with_wind, onset = exit_time is None, float(pair.wind.onset)
    start = onset if exit_time is None else exit_time
    round_shape = isinstance(limit_shape, CircularShape)
    if starts_with_wind and pair.equal and pair.wind.unidirectional and round_shape:
        direction = pair.wind.direction
        best = optimum_deflection(pair.plants[0], pair.wind.component(direction), start=onset)
        times = np.append(onset, best.switch_times)
        deflections = best.deflection(times) * unit_vector(direction)
        return _optimum(pair, times, deflections, best.certificate)
    demands = [pair.mode_demands(plane, start, not starts_with_wind) for plane in (0, 1)]
    moments = _Moments(pair, limit_shape, np.concatenate(demands))
    if starts_with_wind and pair.equal and moments.poles.size == 2:
        deflection = pair.wind_demand(np.asarray([start]))
        peak = float(limit_shape.gauge(deflection)[0])
        proof = Certificate(primal=peak, dual=peak, gap=0.0, residual=0.0, tail=0.0)
        return _optimum(pair, np.asarray([start]), deflection, proof)
    return _optimum(pair, *_solved(moments, start))


def _optimum(
    pair: PlanePair, times: FloatArray, deflections: Vectors, proof: Certificate
) -> PlaneOptimum:
    """Return the record of a `pair` for `deflections` [rad] from `times` [s] on, with `proof`."""
    # trim [rad] in the wind's peak, by which limits are normalised; B: trim over wind angle
    trim_of_peak = abs(float(np.asarray(pair.plants[0].coefficients.B))) * float(pair.wind.peak)
    status = OK if proof.gap < _MAX_GAP else NOT_CONVERGED
    return PlaneOptimum(
        limit=proof.primal / trim_of_peak,
        peak=proof.primal,
        times=times,
        deflections=deflections,
        certificate=proof,
        status=status,
    )


@dataclass(frozen=True, eq=False)
class _Moments:
    """The conditions on a deflection within a limit shape, constant in cells.

    The cells are even in e^(-p t) for every pole. `demands`: of every mode of pitch and then of yaw
    [rad] from the start of the control, ``(k,)``.
    """

    pair: PlanePair
    limit_shape: LimitShape
    demands: FloatArray

    @cached_property
    def poles(self) -> FloatArray:
        """Unstable poles [1/s] of pitch and then of yaw, ``(k,)``."""
        return np.concatenate(self.pair.poles)

    @cached_property
    def axes(self) -> Vectors:
        """Unit vectors ``(k,)``: 1 for each pole of pitch, j for each pole of yaw."""
        pitch, yaw = (poles.size for poles in self.pair.poles)
        return np.repeat([1.0 + 0.0j, 1.0j], [pitch, yaw])

    @cached_property
    def edges(self) -> FloatArray:
        """Times [s] after the onset at which cells begin, ``(n + 1,)``; the last is infinite.

        They are even in e^(-p t) for each pole p; cells so narrow that their integrals are rounding
        are joined.
        """
        even = np.arange(_CELLS) / _CELLS
        times = [-np.log1p(-even) / p for p in np.unique(self.poles)]
        edges = np.unique(np.concatenate(times))
        separate = np.append(
            True, np.diff(edges) > _MIN_WIDTH_OVER_TIME_CONSTANT / self.poles.max()
        )
        return np.append(edges[separate], np.inf)

    @cached_property
    def cell_integrals(self) -> Vectors:
        """Integrals of a p e^(-p t) over each cell, complex ``(k, n)``, of k poles p and axes a.

        a is 1 for a pole of pitch and j for one of yaw; the cells are the n intervals of `edges`
        [s].
        """
        decayed = np.exp(-self.poles[:, np.newaxis] * self.edges)
        return self.axes[:, np.newaxis] * (decayed[:, :-1] - decayed[:, 1:])

    def norm(self, multipliers: FloatArray) -> float:
        """Return N(l), the integral of h_S(sum l a p e^(-p t)) over time, by quadrature.

        h_S(v) is the support function of the limit shape S: the largest scalar product of v and a
        point of S. `multipliers`: l, ``(k,)``, for the k poles p, each with its axis a, 1 in pitch
        and j in yaw. Nodes are Gauss-Legendre points of each cell in x = e^(-p t) of the slowest
        pole; the last cell, endless in time, ends at x = 0.
        """
        slow = self.poles.min()
        x = np.exp(-slow * self.edges)
        points, point_weights = np.polynomial.legendre.leggauss(_NODES)
        width = (x[:-1] - x[1:])[:, np.newaxis]
        inside = (x[1:, np.newaxis] + width * (1.0 + points) / 2.0).ravel()
        weights = (width * point_weights / 2.0).ravel() / (slow * inside)  # of the nodes [s]
        decay = np.exp(np.outer(self.poles / slow, np.log(inside)))
        values = (self.poles * self.axes)[:, np.newaxis] * decay  # a p e^(-p t) at the nodes
        return float(weights @ self.limit_shape.support(multipliers @ values))


def _solved(moments: _Moments, onset: float) -> tuple[FloatArray, Vectors, Certificate]:
    """Return times [s], deflections [rad] and certificate of the minimum, by cutting planes.

    `moments`: the conditions in cells, with the demands d of the poles. `onset`: start of the
    control [s]. It solves l . d -> max, N(l) <= 1 (Kelley 1960). N(l) is the largest l . m of the
    moments m of any deflection v within S, the limit shape, attained by the v furthest along l at
    each time. For the v_i of earlier steps a small linear program solves

        max of l . d with l . m_i <= 1   =   min of sum w_i with sum w_i m_i = d, w >= 0

    so that sum w_i v_i satisfies the conditions with the peak sum w_i, while l . d/N(l) is a lower
    bound. The next v_i are furthest along its l, and along the mean of it and the best l.
    """
    from scipy.optimize import linprog  # late: it takes 0.3 s to import

    limit_shape, cells = moments.limit_shape, moments.cell_integrals
    # The conditions, one for each pole, in another basis (`rows`): orthonormal over the cells and
    # divided by the largest deflection of S in the pole's plane (`reach`, along its unit vector, 1
    # or j, in `axes`). The numbers of l are then of one size, and N(l) bounds each of them by
    # `ends`. `triangle` leads back.
    q, triangle = np.linalg.qr(np.concatenate([cells.real, cells.imag], axis=1).T)
    reach = limit_shape.support(moments.axes)
    rows = (q[: cells.shape[1]] + 1j * q[cells.shape[1] :]).T / reach[:, np.newaxis]
    triangle = triangle * reach[:, np.newaxis]
    d = np.linalg.lstsq(triangle.T, moments.demands, rcond=None)[0]
    size = float(np.abs(d).max())
    d /= size
    ends = np.maximum(limit_shape.gauge(moments.axes), limit_shape.gauge(-moments.axes)) * reach
    best, trial, shares = np.zeros(d.size), d, np.zeros(0)
    extremes: list[Vectors] = []
    moments_of_extremes: list[FloatArray] = []
    for _ in range(_MAX_CUTTING_PLANES):
        for multipliers in (trial, 0.5 * (best + trial)):
            extremes.append(limit_shape.farthest(multipliers @ rows))
            moments_of_extremes.append(np.real(np.conj(rows) @ extremes[-1]))
            scaled = multipliers / (multipliers @ moments_of_extremes[-1])
            best = scaled if scaled @ d > best @ d else best
        result = linprog(
            -d,
            A_ub=np.array(moments_of_extremes),
            b_ub=np.ones(len(moments_of_extremes)),
            bounds=np.stack([-ends, ends], axis=1),
            method="highs",
            options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
        )
        if result.x is None:  # by rounding; earlier steps give a deflection too
            break
        trial, shares = result.x, -result.ineqlin.marginals
        if trial @ d <= (1.0 + _RELATIVE_GAP) * (best @ d):
            break
    deflections = np.asarray(extremes)[: shares.size].T @ shares
    multipliers = np.linalg.lstsq(triangle, best, rcond=None)[0]
    return _corrected(moments, onset, multipliers, deflections, size)


def _corrected(
    moments: _Moments, onset: float, multipliers: FloatArray, deflections: Vectors, size: float
) -> tuple[FloatArray, Vectors, Certificate]:
    """Return times [s], deflections [rad] that satisfy the conditions, and their certificate.

    The condition of a pole p is: the sum over the cells of deflection times p e^(-p t), integrated
    over the cell, is the pole's demand, in its plane. No deflection with a smaller peak than l .
    d/N(l) satisfies them, N(l) being the largest l . d that deflections of peak one attain.
    `moments`: the conditions of k poles, and n cells. `onset`: start of the control [s].
    `multipliers`: l ``(k,)`` with the best lower bound l . d/N(l). `deflections`: those to be
    corrected, over `size` [rad], ``(n,)``.
    """
    d, integrals = moments.demands / size, moments.cell_integrals
    # Corrections are combinations of the functions a e^(-p t) at the cells' starts, a being the
    # unit vector of the plane of the pole p (`axes`); Re(conj(u) v) is the product of two vectors
    basis = moments.axes[:, np.newaxis] * np.exp(-np.outer(moments.poles, moments.edges[:-1]))
    gram = np.real(np.conj(integrals) @ basis.T)
    for _ in range(2):  # the second time for the rounding of the first
        missing = d - np.real(np.conj(integrals) @ deflections)
        deflections = deflections + np.linalg.lstsq(gram, missing, rcond=None)[0] @ basis
    peak = float(moments.limit_shape.gauge(deflections).max())
    lower_bound = float(multipliers @ d) / moments.norm(multipliers)  # l . d/N(l), over `size`
    violation = np.abs(d - np.real(np.conj(integrals) @ deflections))
    residual = float((violation / (np.abs(integrals).sum(axis=1) * peak + np.abs(d))).max())
    proof = Certificate(
        primal=peak * size,
        dual=lower_bound * size,
        gap=(peak - lower_bound) / peak,
        residual=residual,
        tail=0.0,
    )
    return onset + moments.edges[:-1], deflections * size, proof
