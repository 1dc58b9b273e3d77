"""Recoverable states, and the lower bound of laws that do not know when the wind will stop.

Each unstable mode of a plant has a coordinate z, a sum of its states scaled such that

    z' = s (z - u - k alpha_w),    u = deflection/B,    |u| <= D = limit/B,

s being the pole and k the strength of the wind in it. Without wind one mode is recoverable when
|z| < D; two real modes are recoverable together when they lie between the two paths that end at
equilibrium with one switch of the full deflection. No control returns a state outside.

Let W(t) be the remaining wind integral, discounted with the unstable pole p,

    W(t) = p * integral from t to infinity of e^(-p (r - t)) alpha_w(r) dr.

A law that knows the whole wind requires W(onset), appendix C. A law whose state must be recoverable
if the wind stops at any instant requires

    y* = max{ W(onset), sup W / 2 }

and a law that moves the state into the measured wind as far as it is still recoverable attains it.
With several unstable modes no control needs less than the minimum over all of them, and y* of the
fastest is a bound as well: the larger counts.
A wind that may turn by an angle phi instead, with the discounted impulse R, allows less: where W is
largest, a state must lie within y of zero, of W, and of R e^(j phi) and R e^(-j phi).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.fields import Field, spec, specs
from tvclin.boundary.optimum.minimum_peak import minimum_peaks
from tvclin.kernels.choice import run
from tvclin.kernels.remaining_integrals import COMPILED, PLAIN, largest_remaining_integrals
from tvclin.linear.flexible import AnyPlant
from tvclin.linear.modes import left_eigenvector, poles_text, unstable_poles, wind_over_deflection
from tvclin.linear.plant import INPUTS, PLANT_HINT, Plant
from tvclin.numerics.pieces import kernel_arrays
from tvclin.winds.histories import History

MAX_MODES = 2
"""Unstable modes for which the set is known in closed form."""
EXACT = "exact"
BOUND = "bound of the fast mode"
BEFORE_THE_END = "bound: a turn at the end of the wind may require a little more"


@dataclass(frozen=True, eq=False)
class UnstableCoordinates:
    """The coordinates of the unstable modes of one plant, the fastest first.

    `poles`: s [1/s], ``(N,)``, N being one or two. `left_eigenvectors`: l, ``(N, n)``, with
    z = l @ states [rad]. `wind`: k, ``(N,)``, the coordinate at equilibrium in a steady wind over
    the wind angle: the report's K1 of each pole.
    """

    poles: FloatArray
    left_eigenvectors: FloatArray
    wind: FloatArray

    @cached_property
    def ratio(self) -> float:
        """Ratio of the slow pole to the fast one; zero with a single pole."""
        return float(self.poles[1] / self.poles[0]) if self.poles.size > 1 else 0.0


def unstable_coordinates(plant: Plant) -> UnstableCoordinates:
    """Return poles, left eigenvectors and wind strengths of the unstable modes of a plant.

    `plant`: one plant with one or two real unstable poles. `InputError` for a batch, a plant
    without an unstable pole, and one with more than two or a pair.

    Examples
    --------
    >>> import tvclin as tv
    >>> from tvclin.boundary.forecast_free import unstable_coordinates
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> unstable_coordinates(plant).left_eigenvectors  # attitude + rate/(p + damping)
    array([[1., 2.]])
    """
    errors.instance("plant", plant, Plant, PLANT_HINT)
    errors.single("plant", plant.batch)
    poles = unstable_poles(plant)
    if not poles.size or np.iscomplexobj(poles) or poles.size > MAX_MODES:
        raise errors.InputError(
            "plant must have one or two real unstable poles, as the models fixed-path, drift and"
            f" mostly drift-exact of an unstable vehicle have; {plant.model} has here:"
            f" {poles_text(poles)}"
        )
    A, inputs, _, _ = plant.matrices()
    # of a rigid plant: without the columns of the deflection and its rate
    rows = coordinate_rows(plant, poles, np.asarray(plant.coefficients.B))[:, : len(A)]
    from_wind = inputs[:, 1]
    # z' = p z + l w alpha_w without deflection: in a steady wind z = k alpha_w is at equilibrium
    return UnstableCoordinates(poles, left_eigenvectors=rows, wind=-(rows @ from_wind) / poles)


def coordinate_rows(plant: AnyPlant, pole: FloatArray, B: FloatArray) -> FloatArray:
    """Return the rows of z, a mode's coordinate, on states x, delta and delta', ``(p, n + 2)``.

    `plant`: a batch of p plants, or one, with n states. `pole`: an unstable pole s [1/s] of each,
    ``(p,)``. `B`: trim deflection per angle of attack, ``(p,)`` or a scalar. z is scaled such that
    z' = s (z - delta/B - k alpha_w), k alpha_w being the z of equilibrium in a steady wind without
    deflection. With the left eigenvector l, l A = s l, it is proportional to

        l x - l b3 (delta' + s delta),    on which delta acts with l b + s^2 l b3,

    b and b3 being the columns of the deflection and, of an engine with inertia, of delta''.
    """
    A, inputs, _, _ = plant.matrices()
    n, count = A.shape[-1], inputs.shape[-1]
    A = np.broadcast_to(A.reshape(-1, n, n), (pole.size, n, n))
    _, eigenvector = left_eigenvector(A, pole)
    row = np.real(eigenvector)  # l
    inputs = np.broadcast_to(inputs.reshape(-1, n, count), (pole.size, n, count))
    gains = np.einsum("mi,mij->mj", row, inputs)  # l b, l w of the wind, and l b3 if there is one
    engine_gain = gains[:, len(INPUTS) :].sum(axis=1)  # l b3; zero without inertia
    rows = np.column_stack([row, -pole * engine_gain, -engine_gain])
    with np.errstate(divide="ignore", invalid="ignore"):  # a plant without moments
        return rows * (-pole / B / (gains[:, 0] + pole**2 * engine_gain))[:, np.newaxis]


@dataclass(frozen=True)
class ForecastFreeLimit(Shown):
    """Lower bound of the limit of all laws without a forecast; for a batch, ``(...)``.

    Attributes
    ----------
    limit : float or ndarray
        Bound y*, normalised by the trim deflection B alpha_w,max without drift.
    deflection : float or ndarray
        Bound as a deflection [rad], -limit B alpha_w,max; its sign opposes the wind.
    kind : str
        "exact", or for models with drift "bound of the fast mode": no law requires less. With a
        turn of less than about a right angle it is a bound as well, and says so.
    wind_known : float or ndarray
        W(onset) of the fast mode, normalised by the peak: its requirement when the whole wind is
        known.
    worst_stop_time : float or ndarray
        Instant [s] of the largest remaining wind integral W, at which the state must be W - y* at
        least.
    """

    limit: Any = field(metadata=spec(label="limit over trim"))
    deflection: Any = field(
        metadata=specs(
            Field(kind="angle", document=False),
            Field(kind="angle", of=lambda found: np.abs(found.deflection), card=False),
        )
    )
    kind: str = field(metadata=spec())
    wind_known: Any = field(metadata=spec(document=False))
    worst_stop_time: Any = field(metadata=spec("time", document=False))


def forecast_free_limit(
    plant: Plant, wind: History, reversal: float = 0.0, turn: float = np.pi
) -> ForecastFreeLimit:
    """Return the lower bound of a law that survives if the wind stops for good at any instant.

    It is the lower bound without a forecast, by linear theory at nominal dynamic pressure. A law
    that survives this wind alone may require less.

    Parameters
    ----------
    plant : Plant
        One plant whose fastest unstable pole is real, or a batch.
    wind : History
        One wind of one sign, which ends, or a batch; batches broadcast.
    reversal : float
        R, the discounted impulse of a wind of another direction that may come at any instant
        instead of a stop, over the peak: ``p * integral of e^(-p r) |alpha_w(r)| dr``, counted from
        there. One is a full reversal for ever.
    turn : float
        phi [rad], largest change of direction then, to either side, in [0, pi]: pi, a reversal in
        one plane, by default. The deflection limit is round unless phi is pi. With W the remaining
        wind integral, discounted with the fast pole, and S = sup W, y = max{W(onset), S/2, R, ``|S
        - R e^(j phi)|^2 / (2 (S - R cos phi))``}, the last for cos(phi) < R/S only: turns of less
        than arccos(R/S) cost nothing. A reversal gives (S + R)/2, a turn at right angles (S^2 +
        R^2)/(2 S).

    Returns
    -------
    ForecastFreeLimit
        In a batch zero for a plant without an unstable pole, and NaN for one whose fastest
        unstable poles are a pair.

    Raises
    ------
    InputError
        For a wind that changes its sign (no bound is defined for it: give the part of one sign and
        the reversal), is zero or never ends, for a turn outside [0, pi], and for one plant without
        a real unstable pole or with a faster pair.

    Notes
    -----
    Without drift it is exact: the law that deflects fully until the unstable component of the state
    is the largest that can still be brought back after a stop, and then keeps it there, requires no
    forecast, and survives exactly above the bound. With drift it is a bound, of the fast mode alone
    or, where that is larger, the minimum over all unstable modes, `optimum_deflection`; the slow
    mode adds a little. With a turn it is a bound of every law; for cos(turn) <= -R/(2 y) a law
    attains it that knows, after the turn, how the wind goes on. A smaller turn may come when all is
    used up, at the end of the wind, and then a little more is required: the page on two planes has
    the proof.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> bound = tv.forecast_free_limit(plant, tv.TriangularWind(peak=0.1, duration=40.0))
    >>> round(bound.limit, 4), round(bound.wind_known, 4)
    (0.4653, 0.1)
    >>> wind = tv.TriangularWind(peak=0.1, duration=16.0)
    >>> for turn in (0.5, 1.0, 1.5, 3.0):
    ...     print(turn, round(tv.forecast_free_limit(plant, wind, 0.3, turn).limit, 4))
    0.5 0.4145
    1.0 0.4145
    1.5 0.4593
    3.0 0.5638
    """
    errors.instance("plant", plant, Plant, PLANT_HINT)
    errors.instance("wind", wind, History, "such as TriangularWind")
    R = errors.number("reversal", reversal, errors.nonnegative)
    turn_cosine = np.cos(errors.number("turn", turn, errors.between(0.0, np.pi), "rad"))
    errors.ending("wind", wind.end)
    shape = errors.broadcast(plant=plant.batch, wind=wind.batch)
    poles = unstable_poles(plant)
    if not shape and (not poles.size or np.imag(poles[0])):
        raise errors.InputError(
            f"plant must have real unstable poles, the fastest at least; it has {poles_text(poles)}"
        )
    fast = poles[..., :1] if poles.shape[-1] else np.full((*plant.batch, 1), np.nan)
    real = np.imag(fast) == 0.0
    stable = np.broadcast_to(np.isnan(fast[..., 0]), shape)
    pole = np.where(real & ~np.isnan(fast), np.real(fast), 1.0)
    B = np.asarray(plant.coefficients.B)[..., np.newaxis]
    # K1 of the fast pole, N_wind(p)/N_deflection(p) over B: factor from W to the bound
    strength = np.where(real, np.abs(wind_over_deflection(plant, pole) / B), np.nan)
    strength = np.where(stable, 0.0, np.broadcast_to(strength[..., 0], shape))
    pole = np.broadcast_to(pole[..., 0], shape)
    peak = wind.peak
    if not np.all(wind.constant_sign):
        raise errors.InputError(
            "a limit without forecast is not defined for a wind that changes its sign; give the"
            " wind of one sign, and what may follow it as reversal"
        )
    winds, which = kernel_arrays((wind * (1.0 / peak)).pieces, shape)
    results = np.empty((which.size, 3))
    knots, _, rates = winds
    terms = which.size * knots.shape[-1] * rates.shape[-1]
    work = (winds, which, pole.flatten(), results)
    # estimated run time, which decides between compiled and plain code
    run(largest_remaining_integrals, work, which.size, PLAIN * terms, COMPILED * terms)
    # W(onset), the largest W, and its time [s]
    wind_known, largest, when = np.moveaxis(results.reshape(*shape, 3), -1, 0)
    # |S - R e^(j phi)|^2 / (S - R cos phi) = S + R (R - S cos phi)/(S - R cos phi); R > S: R counts
    denominator = np.where(largest - R * turn_cosine > 0.0, largest - R * turn_cosine, np.inf)
    excess = R * np.maximum((R - largest * turn_cosine) / denominator, 0.0)
    stopped = np.maximum((largest + np.minimum(excess, R)) / 2.0, R)
    limit = strength * np.maximum(wind_known, stopped)
    if poles.shape[-1] > 1:
        trim = np.abs(np.asarray(plant.coefficients.B) * peak)
        with np.errstate(divide="ignore", invalid="ignore"):  # no moment, no wind angle to trim
            minimum = minimum_peaks(plant, wind, limit * trim) / trim
        limit = np.where(minimum > limit, minimum, limit)
    kind = EXACT if plant.model == "fixed-path" else BOUND
    if kind == EXACT and R > 0.0 and np.any(turn_cosine > -R / 2.0 / np.maximum(limit, R)):
        kind = BEFORE_THE_END
    return ForecastFreeLimit(
        limit=errors.plain(limit),
        deflection=errors.plain(-limit * np.asarray(plant.coefficients.B) * peak),
        kind=kind,
        wind_known=errors.plain(strength * wind_known),
        worst_stop_time=errors.plain(np.asarray(when)),
    )
