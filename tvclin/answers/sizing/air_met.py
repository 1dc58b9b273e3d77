"""What winds need with the dynamic pressure that is met in them, in batches.

With r = q/q_n of the air that is met, normal and axial force are r times those of calm air, and A
and the columns of the inputs are linear in r (but for b1/B of the drift model, nearly). The
condition of varying parameters (`sizing.varying`) is integrated by the rule of Runge and Kutta:
backwards the growing part p, p' = -A^T p, its reach and the wind to come; forwards the path under
ideal trim. What counts is the ratio to the same in calm air, in which errors of the steps cancel.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tvclin.answers.sizing.collocation import mesh
from tvclin.answers.sizing.least_met import ModesMet, least_met, modes_met
from tvclin.base.arrays import BoolArray, FloatArray, IndexArray
from tvclin.boundary.limit import leading_pole
from tvclin.linear.plant import Plant
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from tvclin.answers.sizing.growing import GrowingMode


_MORE = 0.2
"""Of the dynamic pressure, over which what it adds is taken as linear."""
_SLOWEST, _FEWEST = 0.25, 32
"""The slowest rate [1/s] that sets the steps along a flight, of 1 s; and how many there are."""
_SLACK = 1e-9


def denser_air(vehicle: Vehicle) -> Vehicle:
    """Return a vehicle in the denser air of `AirMet`."""
    return in_air(vehicle, 1.0 + _MORE)


def in_air(vehicle: Vehicle, ratio: FloatArray | float) -> Vehicle:
    """Return a vehicle where the dynamic pressure is so many times that of calm air."""
    return vehicle.replace(
        normal_force_slope=vehicle.normal_force_slope * ratio,
        axial_force=vehicle.axial_force * ratio,
    )


def met_pressure(climb: FloatArray, along: FloatArray, across: FloatArray | float) -> FloatArray:
    """Return the dynamic pressure in winds along and across a climb [rad], over that of calm air.

    Winds are parts of the speed of flight, and positive from behind.
    """
    return np.asarray((np.cos(climb) - along) ** 2 + np.sin(climb) ** 2 + across**2)


@dataclass(frozen=True, eq=False)
class AirMet:
    """Vehicles while winds blow, and what more dynamic pressure adds to their equations.

    `calm` is A beside the columns of deflection and wind in calm air, `more` what the dynamic
    pressure adds for each part of it, ``(k, m, m + 2, n)`` of times and vehicles, each of which may
    be one for all. `end` is the growing part p at the end and the reach of a deflection there, ``(m
    + 1, n)``, NaN where nothing grows. Where two modes grow as a pair, `paired`, ``(k, n)``, trim
    must never be limited. `modes` are all that grow, where slower ones count as well.
    """

    calm: FloatArray
    more: FloatArray
    end: FloatArray
    paired: BoolArray
    modes: tuple[ModesMet, ...] = ()

    @classmethod
    def held(cls, calm: Plant, denser: Plant) -> AirMet:
        """Return that of frozen plants ``(n,)`` in calm air, and of the same in `denser_air`."""
        both, more = _equations(calm, denser)
        shape = (-1, *both.shape[-2:])
        every = [np.moveaxis(one.reshape(shape), 0, -1)[np.newaxis] for one in (both, more)]
        A = both.reshape(shape)[..., : shape[-2]]
        end, paired = _held(both.reshape(shape)).T, leading_pole(calm)[1]
        return cls(every[0], every[1], end, np.reshape(paired, (1, -1)), modes_met(A))

    @classmethod
    def along(cls, mode: GrowingMode, times: FloatArray) -> AirMet:
        """Return that of a flight at times [s] ``(k,)``; what grows at the last goes on."""
        flight, t = mode.schedule, np.minimum(times, mode.bends[-1])
        denser = replace(flight, vehicle=denser_air(flight.vehicle))
        calm = flight.plants(t, mode.model, mode.plane)
        both, more = _equations(calm, denser.plants(t, mode.model, mode.plane))
        row, reach = mode.at(times[-1])
        every = [np.broadcast_to(one, (t.size, *one.shape[-2:]))[..., None] for one in (both, more)]
        paired = np.broadcast_to(leading_pole(calm)[1], t.shape)[:, np.newaxis]
        end = np.append(row, reach)[:, np.newaxis]
        last = every[0][-1:, :, : row.size, 0]
        return cls(every[0], every[1], end, paired, modes_met(last))

    def taken(self, cases: IndexArray) -> AirMet:
        """Return that of some of its vehicles."""

        def of(one: Any) -> Any:
            return one if one.shape[-1] == 1 else one[..., cases]

        calm = of(self.calm)
        modes = modes_met(np.moveaxis(calm[-1], -1, 0)[..., : calm.shape[1]])
        return AirMet(calm, of(self.more), of(self.end), of(self.paired), modes)

    def equations(self, ratio: FloatArray) -> FloatArray:
        """Return the equations where the dynamic pressures are ``(k, n)`` times those of calm."""
        found = np.asarray((ratio - 1.0)[:, np.newaxis, np.newaxis] * self.more)
        found += self.calm
        return found


def _equations(calm: Plant, denser: Plant) -> tuple[FloatArray, FloatArray]:
    both, more = (np.concatenate(one.matrices()[:2], axis=-1) for one in (calm, denser))
    return both, (more - both) / _MORE


def need_ratio(
    met: AirMet,
    times: FloatArray,
    ratio: FloatArray,
    wind: FloatArray,
    dead_band: float,
    blows: FloatArray | None = None,
) -> FloatArray:
    """Return what winds need, and the largest trim, in the air met over the same in calm air.

    ``(2, n)``, NaN where nothing grows, or is needed. `times` are ends of steps [s] and their
    middles by turns, ``(n, k)``, k odd, or one row for all. At these are `ratio`, the dynamic
    pressure over that of calm air, the `wind` [rad], with a dead band below 1 of one sign, and, of
    winds that have a speed, `blows`, the angles in the air met: by eq (B1e) less in a head wind.
    """
    calm = np.ones((times.shape[-1], 1))
    here = _need(met, times.T, calm, wind.T, dead_band)
    there = _need(met, times.T, ratio.T, (wind if blows is None else blows).T, dead_band)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(there / here)


def left_between(
    met: AirMet, times: FloatArray, ratio: FloatArray, wind: FloatArray, dead_band: float
) -> FloatArray:
    """Return the ends of the step [s] in which the dead band is left at what is needed, ``(2, n)``.

    As `need_ratio`, in the air met, of all growing modes; the last step where it is never left.
    """
    trim, demand, least = _course(met, times.T, ratio.T, wind.T, dead_band)
    most = np.argmax(np.abs(trim), axis=0)[np.newaxis]
    side = np.sign(np.take_along_axis(trim, most, axis=0))
    ends = _left(side * trim, side * demand if least is None else least, dead_band)[:2]
    places = np.clip(np.concatenate(ends), 0, len(trim) - 1)
    return np.take_along_axis(times.T[::2], places, axis=0)


def flight_ratio(
    mode: GrowingMode,
    wind: History,
    pressure: tuple[FloatArray, FloatArray],
    dead_bands: FloatArray,
) -> FloatArray:
    """Return `need_ratio` of one wind in flight time at dead bands, ``(k,)``; one where NaN.

    The wind has its angles in calm air's speed; `pressure` is times [s], and the dynamic pressure
    there over that of calm air.
    """
    times = even_steps(mode, (float(wind.onset), float(wind.end)))[np.newaxis]
    met, ratio = AirMet.along(mode, times[0]), np.interp(times, *pressure, 1.0, 1.0)
    angle = wind(times[0])[np.newaxis]
    blows = angle / np.sqrt(ratio)
    found = [need_ratio(met, times, ratio, angle, K, blows)[0, 0] for K in dead_bands.tolist()]
    return np.where(np.isnan(found), 1.0, found)


def even_steps(mode: GrowingMode, span: tuple[float, float]) -> FloatArray:
    """Return ends and middles of even steps over a span [s], ``(k,)``, half the fastest mode's."""
    ends = mesh(np.array(span), max(mode.quickest, _SLOWEST))
    return np.linspace(*span, 2 * max(ends.size - 1, _FEWEST) + 1)


def _need(
    met: AirMet, times: FloatArray, ratio: FloatArray, wind: FloatArray, dead_band: float
) -> FloatArray:
    trim, demand, least = _course(met, times, ratio, wind, dead_band)
    largest = np.abs(trim).max(axis=0)
    paired = np.broadcast_to(met.paired, (len(times), met.paired.shape[1]))[::2]
    if dead_band < 1.0:
        most = np.argmax(np.abs(trim), axis=0)[np.newaxis]
        side = np.sign(np.take_along_axis(trim, most, axis=0))
        kept = np.where(paired, side * trim, 0.0).max(axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            need = np.fmax(_leaves(side * trim, side * demand, dead_band), kept / dead_band)
        if least is not None:
            need = np.fmax(need, np.fmax(least[0], _leaves(side * trim, least, dead_band)))
        return np.stack([need, largest])
    both = np.maximum(np.minimum(trim, demand), np.minimum(-trim, -demand))
    over = trim - demand
    meets, part = over[:-1] * over[1:] < 0.0, np.zeros(over[1:].shape)
    np.divide(over[:-1], over[:-1] - over[1:], where=meets, out=part)
    level = np.where(meets, np.abs(demand[:-1] + part * np.diff(demand, axis=0)), 0.0)
    most = np.where(paired, np.abs(trim), both).max(axis=0)
    return np.stack([np.maximum(most, level.max(axis=0)), largest])


def _leaves(driver: FloatArray, demand: FloatArray, K: float) -> FloatArray:
    """The limit at which the dead band is left just when the limit, held from then on, is enough.

    As in `switching`: only new heights of the driver leave it, and of several solutions the last
    has the largest limit.
    """
    if K == 0.0:
        return np.asarray(demand[0])
    last, after, highest = _left(driver, demand, K)
    ends = [np.clip(one, 0, len(driver) - 1) for one in (last, after)]
    (d0, d1), (L0, L1) = ([np.take_along_axis(x, k, 0) for k in ends] for x in (driver, demand))
    over, part = d0 - K * L0, np.zeros(d0.shape)
    gap = over - (d1 - K * L1)
    np.divide(over, gap, where=gap != 0.0, out=part)
    found = np.where(last < 0, L1, L0 + part * (L1 - L0))
    never = np.maximum(highest[-1] / K, driver.max(axis=0))
    return np.asarray(np.where(after == len(driver), never, found)[0])


def _left(
    driver: FloatArray, demand: FloatArray, K: float
) -> tuple[IndexArray, IndexArray, FloatArray]:
    """The last new height that is short of the dead band, and the next, ``(1, n)``; all heights."""
    highest, place = np.maximum.accumulate(driver), np.arange(len(driver))[:, np.newaxis]
    new = (driver >= highest * (1.0 - _SLACK)) & (driver > 0.0)
    short = (new | (place == 0)) & (driver < K * demand)
    last = np.where(short, place, -1).max(axis=0, keepdims=True)
    after = np.where(new & (place > last), place, place.size).min(axis=0, keepdims=True)
    return last, after, highest


def _course(
    met: AirMet, times: FloatArray, ratio: FloatArray, wind: FloatArray, dead_band: float
) -> tuple[FloatArray, FloatArray, FloatArray | None]:
    """Trim, and the limit that is enough when it is held from then on [rad], ``(ends, n)``.

    And for a dead band below 1 the least peak over all modes from then on, if slower ones grow.
    """
    both = met.equations(ratio)
    m, count = both.shape[1], len(times)
    cases = max(wind.shape[1], both.shape[-1])
    both = np.broadcast_to(both, (count, *both.shape[1:]))
    others = [*range(2, m), m + 1]
    trims = both[:, 1, others] / both[:, 1, [m]]
    path = both[:, 2:][:, :, others] - both[:, 2:, [m]] * trims[:, np.newaxis]

    def ahead(j: int, y: FloatArray) -> FloatArray:
        """A^T p, b.p and w.p alpha_w, of p, reach and the wind to come."""
        found = np.einsum("ij...,i...->j...", both[j], y[:m])
        found[-1] *= wind[j]
        return np.asarray(found)

    def drifts(j: int, x: FloatArray) -> FloatArray:
        blows = np.einsum("ij...,j...->i...", path[j, :, :-1], x)
        return np.asarray(blows + path[j, :, -1] * wind[j])

    end = np.broadcast_to(met.end, (m + 1, cases))
    end = np.concatenate([end, 0.0 * end[:1]])
    order = range(count - 1, -1, -1)
    rest = np.stack(list(_walked(ahead, times, order, end, slice(m))))[::-1]
    x = np.stack(list(_walked(drifts, times, range(count), np.zeros((m - 2, cases)))))
    at = slice(None, None, 2)
    trim = np.einsum("tin,tin->tn", *np.broadcast_arrays(trims[at, :-1], x))
    trim = -(trim + trims[at, -1] * wind[at])
    kept = np.sum(rest[:, 2:m] * x, axis=1) + rest[:, m + 1]
    if not met.modes or dead_band == 1.0:
        return trim, -kept / rest[:, m], None
    least = np.zeros((x.shape[0] if dead_band else 1, cases))
    for modes in met.modes:
        some = modes.cases if met.calm.shape[-1] > 1 else np.arange(cases)
        of = [
            np.broadcast_to(one, (*one.shape[:-1], cases))[..., some]
            for one in (times, both, wind, x)
        ]
        least[:, some] = least_met(
            modes, of[0], _cases_first(of[1]), of[2], _cases_first(of[3]), dead_band > 0.0
        )
    return trim, -kept / rest[:, m], least


def _cases_first(of: FloatArray) -> FloatArray:
    """The same with the axis of the cases behind that of the times."""
    return np.ascontiguousarray(np.moveaxis(of, -1, 1))


def _walked(
    rates: Callable[[int, FloatArray], FloatArray],
    times: FloatArray,
    order: Sequence[int],
    y: FloatArray,
    unit: slice = slice(0),
) -> Iterator[FloatArray]:
    """Yield y at the ends of steps, some of its rows kept at a length of one."""
    yield y
    for a, b, c in zip(order[:-2:2], order[1::2], order[2::2], strict=True):
        h = np.abs(times[c] - times[a])
        first = rates(a, y)
        second = rates(b, y + 0.5 * h * first)
        third = rates(b, y + 0.5 * h * second)
        y = y + h / 6.0 * (first + 2.0 * (second + third) + rates(c, y + h * third))
        if unit.stop:
            y = y / np.sqrt(np.sum(y[unit] ** 2, axis=0))
        yield y


def _held(both: FloatArray) -> FloatArray:
    """Return p and the reach of vehicles that stay as they are; NaN where nothing grows."""
    m = both.shape[-2]
    values, rows = np.linalg.eig(np.swapaxes(both[..., :m], -1, -2))
    pole = np.where((values.imag == 0.0) & (values.real > 0.0), values.real, -np.inf)
    best = np.argmax(pole, axis=-1)[..., np.newaxis]
    rate = np.take_along_axis(pole, best, axis=-1)
    p = np.take_along_axis(rows.real, best[..., np.newaxis, :], axis=-1)[..., 0]
    p = np.where(np.isfinite(rate), p * np.sign(p[..., 1:2]), np.nan)
    pushed = np.sum(p * both[..., m], axis=-1, keepdims=True)
    return np.concatenate([p, pushed / rate], axis=-1)
