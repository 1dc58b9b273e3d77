"""The boundary limit: the minimum deflection with which a wind can be survived, eq (4b).

    y_BR = -delta_max / (B alpha_w,max)

The report's control trims until the driver (B alpha_w, or the trim deflection) reaches K times the
limit, and the deflection is at the limit from then on. By eq (4b) it is on the boundary exactly
when the limit equals the demand, the discounted mean of the remaining trim deflection,

    delta_max = p * integral from a to infinity of e^(-p (t - a)) delta_T(t) dt,

where a is the exit time of the dead band and p the largest real unstable pole. So on the boundary

    driver(t) = K demand(t),    t being the first time at which the driver has this height.

Only new maxima of the driver are exits, for a lower height was reached before. Of several solutions
the last has the largest limit, and every larger limit is sufficient.

`boundary_limit` solves that for any wind of one sign and for every plant; the closed forms of
the report stand in `closed_forms`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import lines
from tvclin.base.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, broadcast, instance, one_of, plain, within
from tvclin.base.fields import Field, spec, specs
from tvclin.base.lines import Line, Table, number, significant
from tvclin.kernels import switches
from tvclin.kernels.choice import run
from tvclin.kernels.remaining_integrals import demands_at_heights
from tvclin.linear.deflections import SWITCHES
from tvclin.linear.modes import unstable_poles
from tvclin.linear.plant import PLANT_HINT, Plant
from tvclin.numerics.pieces import kernel_arrays
from tvclin.winds.histories import History
from tvclin.winds.pulses import check_end, equivalent_triangle

COMPARABLE = 0.05
"""Growth rate, relative to the fastest, above which another unstable mode is a second condition."""
_MIN_POLE_SEPARATION = 1e-4
"""Relative distance of two real poles below which one limit cannot satisfy both conditions."""

OK = "ok"
STABLE = "no unstable pole: no deflection is required"
PAIRED_POLES = (
    "two unstable poles are a pair or equal, and each has its own condition (4b), which no limit"
    " satisfies for both; this limit is so large that the dead band has no exit"
)
NO_EXIT = "trim never saturates: a lower limit does not satisfy (4b); this is the largest trim"
JUMP = "no limit satisfies (4b) exactly: every limit above this one exceeds its demand"


@dataclass(frozen=True)
class ExitProblem:
    """A plant in a wind, with the unstable pole and the dead band of condition (4b).

    `plant`, `wind`: batches; the wind ends. `pole`: the growth rate [1/s] whose condition (4b) is
    satisfied, positive. `dead_band`: K. All broadcast to `shape`. `shape`: of the batch.
    """

    plant: Plant
    wind: History
    pole: FloatArray
    dead_band: FloatArray
    shape: tuple[int, ...]

    def solve(self, literal: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return time [s], demand and status of the exit of the dead band, ``(...)`` each.

        The exit is the last time at which the driver, at a new maximum, is K times the demand. The
        driver is the trim deflection if `literal`, else B alpha_w, the trim without the drift, B
        being trim deflection per angle of attack. The demand is the constant deflection that
        satisfies eq (4b) of the report from then on. Both are over B alpha_w,max. Status
        `switches.UNREACHED`: the driver stays below K times the demand, there is no exit. Status
        `switches.JUMP`: no new maximum is K times the demand exactly. The driver is less before a
        dip, and more when it is as high again after the dip, in which the demand falls.
        """
        # `which`: the wind of each case. `numbers`: its pole, dead band and trim filter
        _, which, numbers = self._arrays
        out = np.empty((3, which.size))
        self._run(switches.switches, which, numbers, literal, out)
        time, demand, status = out.reshape(3, *self.shape)
        return time, demand, status

    def largest_trim(self, cases: BoolArray) -> FloatArray:
        """Return the largest trim over B alpha_w,max of the cases where `cases` is True; else zero.

        Both have the shape of the batch; B is trim deflection per angle of attack. It is
        infinite where trim grows without bound after the wind.
        """
        trims = np.zeros(self.shape)
        _, which, numbers = self._arrays  # of each case the wind's index and parameters
        selected = np.flatnonzero(cases)
        out = np.empty(selected.size)
        self._run(switches.largest_trims, which[selected], numbers[selected], out)
        trims.ravel()[selected] = out
        return trims

    def demands_after_trim(
        self, cases: IndexArray, heights: FloatArray, poles: AnyArray
    ) -> AnyArray:
        """Return the demand of m modes after trim up to a height, normalised by static trim.

        `cases`: indices in the flattened batch, ``(n,)``. `heights`: sizes of trim, positive,
        ``(n,)``. `poles`: of the modes [1/s], real or complex, ``(n, m)``. Returned: the constant
        deflection from then on that each mode requires by itself, ``(n, m)``.
        """
        winds, which, numbers = self._arrays
        # complex if a pole is, or a coefficient of the winds
        demands = np.empty(poles.shape, dtype=np.result_type(poles, winds[1]))
        # of each case b1, b2 and q of the filter -B (s^2 + b2 s + q)/(s^2 + b1 s + q) to trim
        trim_filters = np.ascontiguousarray(numbers[cases, 2:])
        work = (which[cases], trim_filters, np.ascontiguousarray(poles), heights, demands)
        self._run(demands_at_heights, *work, at_heights=True)
        return demands if np.iscomplexobj(poles) else np.real(demands)

    @cached_property
    def _arrays(self) -> tuple[Any, IndexArray, FloatArray]:
        """Winds over their peaks, the wind index of each of n cases, and its parameters.

        The parameters are pole [1/s], dead band K, and b1 [1/s], b2 [1/s] and q [1/s^2] of the
        filter (s^2 + b2 s + q)/(s^2 + b1 s + q) from -B alpha_w to trim, ``(n, 5)``, B being trim
        deflection per angle of attack.
        """
        winds, which = kernel_arrays((self.wind * (1.0 / self.wind.peak)).pieces, self.shape)
        filtering = self.plant.trim_filter
        numbers = (self.pole, self.dead_band, *filtering)
        columns = [np.broadcast_to(values, self.shape).ravel() for values in numbers]
        return winds, which, np.stack(columns, axis=-1)

    def _run(
        self, function: Any, which: IndexArray, *arrays: Any, at_heights: bool = False
    ) -> None:
        """Run a kernel `function` over n cases, compiled if that is faster.

        `which`: index of the wind of each case, ``(n,)``. `arrays`: its further arguments, ``(n,
        ...)``, the last of which it writes. `at_heights`: whether it takes the heights of trim;
        else it follows trim, longer where that is a filtered wind: on a fixed path the coefficients
        of the filter are zero.
        """
        winds, _, parameters = self._arrays
        knots, coefficients, rates = winds
        terms = knots.shape[-1] * rates.shape[-1] * which.size
        if not at_heights and np.any(parameters[:, 2:]):  # behind the pole and K
            terms *= switches.FILTERED[coefficients.dtype.kind]
        # estimated run time, which decides between compiled and plain code
        seconds = (switches.PLAIN * terms, switches.COMPILED * terms)
        run(function, (winds, which, *arrays), which.size, *seconds)


@dataclass(frozen=True, eq=False)
class BoundaryLimit(Shown):
    """The boundary of one plant in one wind, or of a batch; every field has the shape ``(...)``.

    Attributes
    ----------
    limit : float or ndarray
        y_BR, the minimum limit over the trim deflection B alpha_w,max without drift.
    deflection : float or ndarray
        Boundary limit as a deflection [rad], -y_BR B alpha_w,max; its sign opposes the wind.
    switch_time : float or ndarray
        Time a [s] of the exit of the dead band on the boundary; NaN without an exit.
    status : str or ndarray of str
        "ok", or the reason why the limit is not a solution of (4b).
    """

    limit: Any = field(metadata=spec(label="limit over trim"))
    deflection: Any = field(
        metadata=specs(
            Field(kind="angle", document=False),
            Field(kind="angle", of=lambda value: np.abs(value.deflection), card=False),
        )
    )
    switch_time: Any = field(metadata=spec("time"))
    status: Any = field(metadata=spec())

    def table(self, caption: str, axis: str, places: FloatArray, dead_bands: FloatArray) -> Table:
        """Return the table of limits ``(n, k)`` at n `places` on an axis, for each of k dead bands.

        `caption`: above the table. `axis`: heading of the column of the places.
        """
        rows: list[tuple[Line, ...]] = []
        for position, limits in zip(places, self.limit, strict=True):
            name, by_dead_band = f"limit.{position:g}", zip(dead_bands, limits, strict=True)
            cells = (lines.minimum_limit(number(f"{name}.{K:g}", y)) for K, y in by_dead_band)
            rows.append((significant(name, position), *cells))
        return Table(caption, (axis, *(f"K = {K:g}" for K in dead_bands)), tuple(rows))


def boundary_limit(
    plant: Plant, wind: History, dead_band: ArrayLike = 1.0, switch: str = "report"
) -> BoundaryLimit:
    """Return the boundary limit of a plant in any wind of one sign.

    It is y(K) of eq (4b) by linear theory at nominal dynamic pressure, a ratio to static trim, and
    no verdict.

    Parameters
    ----------
    plant : Plant
        One plant or a batch, of any model.
    wind : History
        Wind angle of attack that does not change its sign; batches broadcast.
    dead_band : array_like
        K, the fraction of the limit up to which the vehicle is trimmed, in [0, 1].
    switch : {"report", "literal"}
        Condition for the exit of the dead band, on the wind or on trim, as in `trim_then_hold`.
        With drift and 0 < K < 1 they differ: `Study` and commands take "literal", so that their
        rows are this function with ``switch="literal"``.

    Returns
    -------
    BoundaryLimit
        The condition (4b) is satisfied at the largest unstable pole, not at slower poles of the
        exact models; `judge` reports them. (A stable vehicle on an exact model may have only a
        slow one, of the flight path; then it is that.) Where several limits satisfy the condition
        (winds of several peaks) it is the largest. A complex pair that grows as fast requires
        two conditions, which one limit cannot satisfy: then it is the largest trim deflection over
        K, with which the dead band has no exit (infinite for K = 0), and the status says so.
        Whether a capability is sufficient is the question of `is_sufficient`, which compares it
        with `required_deflection`, the largest of several requirements; y_BR is one of them.

    Raises
    ------
    InputError
        For a wind that changes sign, never ends or is zero, and a dead band outside [0, 1].

    Notes
    -----
    Eqs (6) to (8), (12), (15a), (16) and (18) are its special cases.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> wind = tv.TriangularWind(peak=np.radians(5), duration=7.5)
    >>> for switch in ("report", "literal"):
    ...     print(switch, round(float(tv.boundary_limit(plant, wind, 0.75, switch).limit), 4))
    report 0.6223
    literal 0.6242
    """
    K = within("dead_band", dead_band, 0.0, 1.0)
    one_of("switch", switch, SWITCHES)
    instance("plant", plant, Plant, PLANT_HINT)
    instance("wind", wind, History, "such as TriangularWind")
    if not np.all(wind.constant_sign):
        low, high = wind.extent
        raise InputError(
            "wind must not change its sign for a boundary limit; got values from"
            f" {low.min():.6g} to {high.max():.6g} rad"
        )
    check_end(wind)
    pole, paired = leading_pole(plant)
    unstable = ~np.isnan(pole)
    if np.any(unstable & (np.asarray(plant.coefficients.B) == 0.0)):
        raise InputError(
            "plant must have an aerodynamic moment, mu_alpha other than zero, where its path grows:"
            " limits are relative to the deflection that trims the wind"
        )
    # deflection [rad] per limit y: -B alpha_w,max
    scale = np.where(unstable, -np.asarray(plant.coefficients.B), 1.0) * wind.peak
    shape = broadcast(dead_band=K.shape, plant=pole.shape, wind=wind.batch)
    growth_rate = np.where(unstable, pole, 1.0)
    problem = ExitProblem(plant, wind, pole=growth_rate, dead_band=K, shape=shape)
    unstable, paired, K = (np.broadcast_to(a, shape) for a in (unstable, paired, K))
    at_onset = unstable & (K == 0.0)
    time, demand, exit_status = problem.solve(switch == "literal")
    limit = np.where(unstable, demand, 0.0)
    never = unstable & (exit_status == switches.UNREACHED) & ~at_onset & ~paired
    if np.any(never | paired):
        largest_trim = problem.largest_trim(never | paired)
        with np.errstate(divide="ignore", invalid="ignore"):  # K = 0: none is enough
            limit = np.where(paired, largest_trim / K, np.where(never, largest_trim, limit))
    statuses = [~unstable, paired, never, (exit_status == switches.JUMP) & ~at_onset]
    # index of the first status that holds; the array is as wide as the longest text that occurs
    word = np.select(statuses, range(1, 1 + len(statuses)), 0)
    status = np.array([OK, STABLE, PAIRED_POLES, NO_EXIT, JUMP][: word.max(initial=0) + 1])[word]
    return BoundaryLimit(
        limit=plain(limit),
        deflection=plain(np.asarray(limit * scale)),
        switch_time=plain(np.where(unstable & ~never & ~paired, time, np.nan)),
        status=status if status.ndim else str(status),
    )


def triangle_error(plant: Plant, wind: History, dead_band: ArrayLike = 1.0) -> Any:
    """Return the relative error of the boundary when a wind is replaced by its equivalent triangle.

    It holds for the given plant: the triangle's boundary deflection relative to the wind itself,
    minus one. Negative where the triangle is optimistic; NaN where no deflection is required.

    Parameters
    ----------
    plant, wind, dead_band
        Same parameters as `boundary_limit`.

    Raises
    ------
    InputError
        Where `boundary_limit` or `equivalent_triangle` raises it.
    """
    winds = (wind, equivalent_triangle(wind))
    true, triangle = (np.asarray(boundary_limit(plant, w, dead_band).deflection) for w in winds)
    with np.errstate(invalid="ignore"):
        return plain(np.asarray(triangle / true - 1.0))


def leading_pole(plant: Plant) -> tuple[FloatArray, BoolArray]:
    """Return the growth rate [1/s] of a plant's leading pole, and whether a pair of poles counts.

    Both are ``(...)``. The rate is NaN where no mode is unstable. A pair counts where a complex
    pair grows faster than `COMPARABLE` times the fastest real pole, or two real poles coincide: one
    limit cannot satisfy the report's condition (4b) for both.
    """
    poles = unstable_poles(plant)
    if not poles.shape[-1]:
        return np.full(poles.shape[:-1], np.nan), np.zeros(poles.shape[:-1], dtype=bool)
    rates, present = np.real(poles), ~np.isnan(poles)
    complex_pole = present & (np.imag(poles) != 0.0)
    real_rates = np.sort(np.where(present & ~complex_pole, rates, 0.0), axis=-1)
    real, second = real_rates[..., -1], real_rates[..., :-1].max(axis=-1, initial=0.0)
    pair = np.where(complex_pole, rates, 0.0).max(axis=-1)
    paired = (pair > COMPARABLE * real) | (
        second > (1.0 - _MIN_POLE_SEPARATION) * np.maximum(real, 1e-300)
    )
    leading = np.maximum(real, pair)
    return np.where(leading > 0.0, leading, np.nan), paired
