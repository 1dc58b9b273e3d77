"""The deflection of minimum peak that survives a known wind, its proof, and its peak for a batch.

    min peak |delta|   with   integral of e_i(u) delta du = d_i,   eq (C1)

`optimum_deflection` gives the deflection of one case, with a certificate. For a batch, the peak
alone has a formula for one pole, for two real ones and for one pair; with z_i = p_i d_i and the
control from the onset of the wind on it is

    |z|,    the reach on whose edge (z_1, z_2) lies, eqs (C5) and (C6),    and
    max over phi of  |Re(d e^(-j phi))| / integral e^(-sigma u) |cos(omega u + phi)| du.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tvclin.base.cards import Record, Shown
from tvclin.base.errors import broadcast, instance
from tvclin.base.fields import spec
from tvclin.boundary.limit import OK, STABLE
from tvclin.boundary.optimum import two_poles
from tvclin.boundary.optimum.dual import best_multipliers
from tvclin.boundary.optimum.moments import Constraints, Window, conditions, constraints_of
from tvclin.kernels.choice import run
from tvclin.kernels.control_laws import REACH_COMPILED, REACH_PLAIN, minimum_reaches
from tvclin.kernels.remaining_integrals import ONSET_COMPILED, ONSET_PLAIN, onset_integrals
from tvclin.linear.deflections import BangBang, ConstantDeflection
from tvclin.linear.modes import separated_poles, unstable_poles, wind_over_deflection
from tvclin.linear.plant import PLANT_HINT, Plant
from tvclin.numerics.pieces import kernel_arrays
from tvclin.numerics.searches import grid_minimum
from tvclin.winds.histories import History, Piecewise, linear_pieces
from tvclin.winds.pulses import check_end

NOT_EXCITED = "the wind excites no unstable pole: no deflection is required"
NOT_CONVERGED = "not converged: the certificate says how far off it is"
_MAX_GAP = 1e-9
"""Largest relative gap and residual of a certificate that proves a peak; else the status says
so."""
_RELATIVE_ROUNDING = 1e-14
"""Relative distance to the horizon below which a switch is omitted."""
_SPANS = (3.0, 5.0, 8.0, 12.0, 18.0, 25.0)
"""Normalised times p T that are tried for a proof that a peak is sufficient."""
_FINER_SPANS = tuple(float(span) for span in range(1, 31))
"""Normalised times p T that are tried where `_SPANS` prove nothing."""
_RELATIVE_PEAK_ROUNDING = 1e-10
"""Rounding of a proved peak, relative to it."""
_DIRECTIONS = 128
"""Directions of lambda on a grid for the dual of a pair, before the best is refined."""


@dataclass(frozen=True, eq=False)
class Certificate(Record):
    """A lower bound of every peak, and the peak of the deflection that it proves optimal.

    `primal`: peak [rad] of the deflection. `dual`: lambda . d over the L1 norm of lambda . e: no
    deflection that satisfies the conditions has a peak [rad] below it, whatever its shape. `gap`:
    (primal - dual)/primal. `residual`: largest violation of a condition (4b), relative to the sizes
    of its terms. `tail`: bound of the L1 norm that a truncated window omits, relative to it; it is
    included in `dual`. Zero where nothing is truncated.
    """

    primal: float
    dual: float = field(metadata=spec("angle", "dual bound"))
    gap: float = field(metadata=spec())
    residual: float = field(metadata=spec())
    tail: float = field(metadata=spec())


@dataclass(frozen=True, eq=False)
class Optimum(Shown):
    """The deflection of minimum peak for one plant in one wind.

    Attributes
    ----------
    peak : float
        Largest size [rad]; zero where no deflection is required. Where the optimum was not
        reached, at least the proved lower bound: look at `status`.
    deflection : History
        The deflection [rad]: constant, or always at one of two limits, zero from a finite
        horizon on.
    switch_times : ndarray
        Times [s] at which the deflection changes its sign, ``(k,)``.
    multipliers : ndarray
        lambda [1/s], ``(n,)``, with an L1 norm of one: the derivatives of the peak by d_i. The
        functions of time e_i start at the start of the control; one for each real pole in the
        order of `unstable_modes`, two (cosine, sine) for each pair.
    certificate : Certificate
        A lower bound of every peak, and the residuals.
    status : str
        "ok", or the reason why it is not.
    """

    peak: float = field(metadata=spec("angle"))
    deflection: History
    switch_times: FloatArray = field(metadata=spec("time"))
    multipliers: FloatArray
    certificate: Certificate = field(
        metadata=spec("angle", name="lower_bound", of="certificate.dual")
    )
    status: str = field(metadata=spec())


def optimum_deflection(
    plant: Plant, wind: History, start: float = 0.0, horizon: float | None = None
) -> Optimum:
    """Return the deflection of minimum peak that cancels every unstable mode (appendix C).

    Its peak is the lower bound with the wind known, by linear theory at nominal dynamic pressure.

    Parameters
    ----------
    plant : Plant
        One plant of any model, with any number of unstable poles.
    wind : History
        One wind that ends; it is known beforehand.
    start : float
        Start of the control t1 [s]. A late start costs a factor e^(beta t1) with one pole, an
        early one (negative) gains as much.
    horizon : float, optional
        Time [s] from which the deflection is zero again; by default it is never.

    Returns
    -------
    Optimum
        With a certificate. Compare it with `boundary_limit`, which satisfies the condition of
        the fastest real pole only.

    Raises
    ------
    InputError
        For a batch, a wind that is zero or never ends, a horizon that is not after the start or
        before the end of the wind, a start too late to be made up for, and unstable poles that
        the deflection does not reach.

    Notes
    -----
    With one pole beta the deflection is constant, delta = beta e^(beta t1) D, D being the integral
    of e^(-beta t) delta dt by eq (C1) of the report; with two real ones it changes its sign once,
    eqs (C5) and (C6); with N real ones at most N - 1 times, and without end for a complex pair,
    which is followed until the rest is below 1e-12 of the norm (the deflection is zero from there
    on). In general it is the peak times the sign of a sum of the poles' exponentials e^(-p t).

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"), "drift-exact")
    >>> best = tv.optimum_deflection(plant, tv.TriangularWind(peak=-0.1, duration=37.787))
    >>> round(best.peak / (0.1 * plant.coefficients.B), 4), best.switch_times.round(3)
    (0.1391, array([0.284]))
    """
    return optimum_under(constraints_of(plant, wind, start, horizon), float(start))


def optimum_under(constraints: Constraints, start: float = 0.0) -> Optimum:
    """Return the deflection of minimum peak that satisfies `constraints`, from `start` [s] on.

    It has one size and changes its sign at the switch times. The multipliers of the poles'
    exponentials, of which it has the sign of the sum, give a lower bound (`certify`).
    """
    if not np.any(constraints.demands):
        zero, conditions = Piecewise(linear_pieces([start], [0.0], 0.0)), constraints.demands.size
        proof = Certificate(primal=0.0, dual=0.0, gap=0.0, residual=0.0, tail=0.0)
        status = NOT_EXCITED if conditions else STABLE
        return Optimum(
            peak=0.0,
            deflection=zero,
            switch_times=np.zeros(0),
            multipliers=np.zeros(conditions),
            certificate=proof,
            status=status,
        )
    window = Window(constraints)
    switches, multipliers = _solve(window)
    switches, limit = _polished(window, switches)  # times [s] from the start, and deflection [rad]
    deflection: History = (
        BangBang(limit=limit, switch_times=switches + start, start=start)
        if switches.size
        else ConstantDeflection(limit=limit, start=start)
    )
    if np.isfinite(window.end):
        deflection = deflection.before(window.end + start)
    certificate = certify(window, multipliers, switches, limit)
    norm = window.signed(multipliers).norm
    proved = abs(certificate.gap) < _MAX_GAP and certificate.residual < _MAX_GAP
    return Optimum(
        peak=abs(limit) if proved else max(abs(limit), certificate.dual),
        deflection=deflection,
        switch_times=switches + start,
        multipliers=multipliers / norm,
        certificate=certificate,
        status=OK if proved else NOT_CONVERGED,
    )


def certify(
    window: Window, multipliers: FloatArray, switches: FloatArray, limit: float
) -> Certificate:
    """Return the certificate of a deflection that switches between two limits.

    `window`: the conditions, moments of the poles' exponentials. `multipliers`: lambda, ``(n,)``;
    any of them bounds every peak from below. `switches`: switch times [s] after the start,
    ``(k,)``. `limit`: first deflection [rad].
    """
    norm = window.signed(multipliers).norm  # L1 norm of lambda . e within the window
    beyond = window.tail(multipliers)  # bound of the norm after a truncated window
    dual = float(multipliers @ window.constraints.demands / (norm + beyond))
    return Certificate(
        primal=abs(limit),
        dual=dual,
        gap=(abs(limit) - dual) / abs(limit),
        residual=window.violation(switches, limit),
        tail=beyond / norm,
    )


def _solve(window: Window) -> tuple[FloatArray, FloatArray]:
    """Return switch times [s] after the start, and multipliers lambda of any scale, lambda . d > 0.

    The deflection of minimum peak has the sign of the sum lambda . e, and switches at its zeros.
    `window`: the poles' exponentials e_i, and their demands d_i. One pole needs no switch, two real
    ones at most one, by eqs (C5) of the report; else the dual is maximised.
    """
    c = window.constraints
    if c.demands.size == 1:
        return np.zeros(0), np.sign(c.demands)
    if not c.real or c.demands.size > 2:
        best = best_multipliers(window)
        return best.zeros, best.multipliers
    poles, demands = np.real(c.poles), c.demands
    time = two_poles.switch_time(tuple(poles), tuple(demands), c.horizon)
    # Without a switch before the end one constant deflection satisfies both conditions; with the
    # signs of the demands as multipliers the sum has no zero.
    if np.isinf(time) or time >= c.horizon * (1.0 - _RELATIVE_ROUNDING):
        return np.zeros(0), np.sign(demands)
    # of a sum proportional to e^(-p1 (u - time)) - e^(-p2 (u - time)), zero at the switch alone
    growth = np.exp((poles - poles.max()) * time)
    multipliers = np.array([growth[0], -growth[1]])
    return np.array([time]), multipliers * np.sign(multipliers @ demands)


def _polished(window: Window, switches: FloatArray) -> tuple[FloatArray, float]:
    """Return switch times [s] and limit [rad] after Newton's iteration on the conditions.

    The deflection is the limit, whose sign changes at each switch. `window`: the conditions,
    moments of the poles' exponentials. `switches`: times [s], ``(k,)``, from nearly dependent
    conditions (a short horizon); they are made exact to rounding. A step that leaves their order or
    does not reduce the violation ends the iteration.
    """
    # The moments of the deflection, limit sum of (-1)^k integral e, change with switch j by
    # 2 limit (-1)^j e(t_j), and with the limit by themselves for each relative change of it.
    fitted, demands = window.piece_moments(switches).sum(axis=1), window.constraints.demands
    # of the least-squares fit of the limit; `sizes` bound the L1 norms of the exponentials
    weights = fitted / window.sizes**2
    limit = float(weights @ demands / (weights @ fitted))
    violation = window.violation(switches, limit)
    for _ in range(3 if switches.size else 0):
        signs = (-1.0) ** np.arange(switches.size)
        by_switches = 2.0 * limit * signs * window.constraints.basis(switches)
        moments = limit * window.piece_moments(switches).sum(axis=1)  # also the change by the limit
        rows = np.column_stack([by_switches, moments]) / window.sizes[:, np.newaxis]
        missing = window.constraints.demands - moments
        step = np.linalg.lstsq(rows, missing / window.sizes, rcond=None)[0]
        trial, trial_limit = switches + step[:-1], limit * (1.0 + step[-1])
        if np.any(np.diff(trial, prepend=0.0, append=window.end) < 0.0):
            break
        trial_violation = window.violation(trial, trial_limit)
        if trial_violation >= violation:
            break
        switches, limit, violation = trial, trial_limit, trial_violation
    return switches, float(limit)


def minimum_peaks(plant: Plant, wind: History, sufficient: FloatArray | None = None) -> FloatArray:
    """Return the peak [rad] of `optimum_deflection` from the onset of the wind on, for each case.

    `plant`: one or a batch. `wind`: one wind or a batch, of winds that end; batches broadcast.
    `sufficient`: peaks [rad], which broadcast with the batch. With three poles, where this peak is
    proved to be no less than the minimum, it is returned in its place: the search takes a tenth of
    a second. Returned: of the shape of the batch; zero without an unstable pole, and infinite where
    the deflection does not reach one. `InputError` for a wind that is zero or never ends.
    """
    instance("plant", plant, Plant, PLANT_HINT)
    instance("wind", wind, History, "such as TriangularWind")
    shape = broadcast(plant=plant.batch, wind=wind.batch)
    check_end(wind)
    poles = separated_poles(unstable_poles(plant))
    count = poles.shape[-1]
    if not count:
        return np.zeros(shape)
    peaks = None
    if sufficient is not None and count > 2:
        shape = np.broadcast_shapes(shape, np.shape(sufficient))
        peaks = np.broadcast_to(sufficient, shape).ravel()
    wind_ratios, poles = (  # of the residues at each pole, wind over deflection; and the poles
        np.broadcast_to(values, (*shape, count)).reshape(-1, count)
        for values in (wind_over_deflection(plant, poles), poles)
    )
    winds, which = kernel_arrays(wind.pieces, shape)  # knots, coefficients, rates; wind of a case
    filled = np.where(np.isnan(poles), 1.0, poles)  # NaN stands for a pole that is not there
    # integrals of e^(-p u) times the wind, u being the time since its onset
    transforms = np.empty(filled.shape, dtype=np.result_type(filled, winds[1]))
    knots = transforms.size * winds[0].shape[-1]
    work = (winds, which, np.ascontiguousarray(filled), transforms)
    # estimated run time, which decides between compiled and plain code
    run(onset_integrals, work, which.size, ONSET_PLAIN * knots, ONSET_COMPILED * knots)
    with np.errstate(invalid="ignore"):
        demands = -wind_ratios * (transforms if np.iscomplexobj(filled) else np.real(transforms))
    return peaks_for_demands(poles, demands, peaks).reshape(shape)


def minimum_reach(fast: FloatArray, slow: FloatArray, ratio: FloatArray) -> FloatArray:
    """Return the minimum peak of deflection/B [rad] that brings two real modes to equilibrium.

    Of each of n cases, ``(n,)``: the limit whose recoverable set has the coordinates on its edge.
    `fast`, `slow`: coordinates z of the two unstable modes [rad], ``(n,)`` each. `ratio`: the slow
    pole over the fast one, in (0, 1), ``(n,)``. B is trim deflection per angle of attack.
    """
    reaches = np.empty(fast.size)  # written by the kernel
    columns = [np.require(values, float, ["C", "W"]) for values in (fast, slow, ratio)]
    count = reaches.size
    # estimated run time, which decides between compiled and plain code
    run(minimum_reaches, (*columns, reaches), count, REACH_PLAIN * count, REACH_COMPILED * count)
    return reaches


def peaks_for_demands(
    poles: AnyArray, demands: AnyArray, sufficient: FloatArray | None = None
) -> FloatArray:
    """Return the minimum peaks [rad] that satisfy the demands of modes, ``(n,)``.

    `poles`: `separated_poles` [1/s], the fastest first, ``(n, m)``; NaN for no pole; a pair has
    both. `demands`: d from the start of the control on [rad s], ``(n, m)``, see below; infinite
    where the deflection does not reach a pole. `sufficient`: limits [rad], ``(n,)``, of
    callers that count the larger of limit and minimum: returned for three poles where it is proved
    to be no less than the minimum, without a search.

    A demand d, eq (C1) of the report, is the integral of e^(-p t) delta dt that cancels the mode of
    the pole p. One pole requires ``|p d|``; two real poles and a pair have formulas; more take a
    search, unless `sufficient` is proved to be enough.
    """
    present = ~np.isnan(poles)
    unreachable = np.any(present & ~np.isfinite(demands), axis=-1)
    number = present.sum(axis=-1)
    pair = (number == 2) & (np.imag(poles[:, 0]) != 0.0)
    peaks = np.where(unreachable, np.inf, 0.0)
    single = (number == 1) & ~unreachable
    peaks[single] = np.abs(np.real(poles[single, 0] * demands[single, 0]))
    two = (number == 2) & ~pair & ~unreachable
    if np.any(two):
        p, d = np.real(poles[two, :2]), np.real(demands[two, :2])
        z = p * d  # constant deflection that each mode requires by itself [rad]
        peaks[two] = minimum_reach(z[:, 0], z[:, 1], p[:, 1] / p[:, 0])
    pair &= ~unreachable
    if np.any(pair):
        peaks[pair] = _pair_peaks(poles[pair, 0], demands[pair, 0])
    search = (number > 2) & ~unreachable
    if sufficient is not None and np.any(search):
        candidates = np.flatnonzero(search & (number == 3) & (np.imag(poles[:, 0]) == 0.0))
        proved = _is_sufficient(poles[candidates], demands[candidates], sufficient[candidates])
        peaks[candidates[proved]] = sufficient[candidates[proved]]
        search[candidates[proved]] = False
    for k in np.flatnonzero(search):
        upper = present[k] & (np.imag(poles[k]) >= 0.0)
        case_poles, case_demands = poles[k, upper], demands[k, upper]
        if not np.any(np.imag(case_poles)):  # of a batch with pairs
            case_poles, case_demands = np.real(case_poles), np.real(case_demands)
        peaks[k] = optimum_under(conditions(case_poles, case_demands)).peak
    return peaks


def _is_sufficient(poles: AnyArray, demands: AnyArray, peak: FloatArray) -> BoolArray:
    """Return whether a `peak` [rad] is proved to suffice for a pole p and two others, ``(n,)``.

    Of n cases `poles` [1/s] and `demands` [rad s], the values that the moments of the deflection,
    its integrals times e^(-pole t), must have: ``(n, 3)``, the real pole p first. Let a constant
    deflection c act up to T, and the optimal one of the two other poles from then on, whose moment
    at p is at most peak e^(-p T)/p. That bounds c to an interval. If at both its ends the two other
    poles require no more than the peak, a c of the interval satisfies all conditions.
    """
    # first few T with cheap upper bounds of the peak of a pair, then more T with the peak itself
    proved = _proved(poles, demands, peak, _SPANS, _pair_peak_bounds)
    unproved = np.flatnonzero(~proved)
    proved[unproved] = _proved(
        poles[unproved], demands[unproved], peak[unproved], _FINER_SPANS, _pair_peaks
    )
    return proved


def _proved(
    poles: AnyArray,
    demands: AnyArray,
    peak: FloatArray,
    spans: tuple[float, ...],
    pair_peaks: Callable[[AnyArray, AnyArray], FloatArray],
) -> BoolArray:
    """Return whether the proof of `_is_sufficient` succeeds with one of T = span/p, ``(n,)``.

    `poles` s [1/s], `demands` [rad s], the integral of e^(-s t) times the deflection for each:
    ``(n, 3)``, the real pole p first. `peak`: to be proved sufficient [rad], ``(n,)``; it is if the
    two other poles require no more, from T on, after either of two constant deflections up to T.
    `spans`: tried values of p T. `pair_peaks`: function of poles and demands of complex pairs to
    bounds of their minimum peaks [rad].
    """
    p, others = np.real(poles[:, 0]), poles[:, 1:]  # the two others are real, or a pair
    rate, paired = np.real(others), np.imag(others[:, 0]) != 0.0
    proved = np.zeros(p.shape, dtype=bool)
    for span in spans:
        # e^(-p T), and e^(-s T) of the others
        decay, propagated = np.exp(-span), np.exp(-others * (span / p)[:, np.newaxis])
        fits = np.ones(p.shape, dtype=bool)
        for sign in (-1.0, 1.0):
            # Ends of the interval of c, the constant deflection up to T, with the demand d of p:
            # c (1 - e^(-p T))/p = d +/- peak e^(-p T)/p. Up to T it does c (1 - e^(-s T))/s of the
            # other demands; the rest of them, over e^(-s T), is for a deflection from T on.
            c = (p * np.real(demands[:, 0]) + sign * peak * decay) / (1.0 - decay)
            with np.errstate(all="ignore"):  # what is no number is not proved
                done = c[:, np.newaxis] * (1.0 - propagated) / others
                rest = (demands[:, 1:] - done) / propagated
            z = rate * np.real(rest)  # constant deflections that cancel the two [rad], if real
            later = minimum_reach(z[:, 0], z[:, 1], rate[:, 1] / rate[:, 0])
            later[paired] = pair_peaks(others[paired, 0], rest[paired, 0])
            fits &= np.maximum(np.abs(c), later) <= peak * (1.0 + _RELATIVE_PEAK_ROUNDING)
        proved |= fits
    return proved


def _pair_peak_bounds(poles: AnyArray, demands: AnyArray) -> FloatArray:
    """Return upper bounds [rad] of `_pair_peaks`, ``(n,)``: demands over a bound of their norms.

    `poles`: s = sigma + j omega [1/s], ``(n,)``. `demands`: integrals of e^(-s t) delta dt that
    cancel the modes [rad s], complex ``(n,)``. The norm, the integral of ``|Re(e^(-s u - j phi))|``
    over all u >= 0, is at least ``(1/sigma - 1/|sigma + 2j omega|)/2`` at every phase phi, since
    ``|cos x| >= cos(x)^2``.
    """
    sigma, omega = np.real(poles), np.imag(poles)
    return np.abs(demands) / (0.5 * (1.0 / sigma - 1.0 / np.hypot(sigma, 2.0 * omega)))


def _pair_peaks(poles: AnyArray, demands: AnyArray) -> FloatArray:
    """Return the minimum peaks [rad] of complex pairs ``(n,)``, by the dual.

    `poles`: s = sigma + j omega [1/s], ``(n,)``. `demands`: d, integrals of e^(-s t) delta dt that
    cancel the modes [rad s], complex ``(n,)``. Each phase phi gives a lower bound of the peak,
        |Re(d e^(-j phi))| / integral e^(-sigma u) |cos(omega u + phi)| du, and the largest is it.
    """
    k = np.real(poles) / np.imag(poles)  # decay sigma/omega, with x = omega u

    def negative(zero: FloatArray, i: IndexArray) -> FloatArray:
        """Return minus the lower bounds of the peak, over omega (1 + k^2), at m phases, ``(c, m)``.

        `i`: indices of c pairs. `zero`: first zero of cos(x + phi), x = pi/2 - phi, for each phase
        phi, ``(m,)`` or ``(c, m)``.
        """
        minus_phase = zero - 0.5 * np.pi
        projected = np.abs(np.real(demands[i, np.newaxis] * np.exp(1j * minus_phase)))
        # integral of e^(-k x) |cos(x + phi)| over x > 0, times 1 + k^2: up to the zero of the
        # cosine, and from there on a geometric series of half waves
        decay = k[i, np.newaxis]
        series = (1.0 + np.exp(-decay * np.pi)) / -np.expm1(-decay * np.pi)
        norm = np.exp(-decay * zero) * (1.0 + series) - np.cos(zero) + decay * np.sin(zero)
        return -projected / norm

    # Of pairs that are nearly real the bound turns within about 1/k of phi = pi/2, the zero x = 0.
    fine = np.geomspace(1e-8, np.pi, _DIRECTIONS)
    grid = np.sort(np.concatenate([np.linspace(0.0, np.pi, _DIRECTIONS), fine]))
    pairs = np.arange(k.size)
    values = negative(grid, pairs)
    best = np.argmin(values, axis=-1)
    value = values[pairs, best]
    inner = np.flatnonzero((best > 0) & (best < grid.size - 1))
    if inner.size:
        ends = (grid[best[inner] + step] for step in (-1, 1))
        _, refined = grid_minimum(lambda zero: negative(zero, inner), *ends)
        value[inner] = np.minimum(value[inner], refined)
    return -value * np.imag(poles) * (1.0 + k**2)
