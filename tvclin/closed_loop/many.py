"""Many flights at once, each of a plant, a law, a wind and limits of its own."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.autopilot import Actuator
from tvclin.cards import Row, card
from tvclin.closed_loop.checks import FASTEST, check_sample_rate, check_samples, check_span, paces
from tvclin.closed_loop.fates import judging_rows
from tvclin.closed_loop.gusts import polynomial_pieces
from tvclin.closed_loop.law_rows import LawRows, law_batch, law_rows
from tvclin.closed_loop.step_matrices import sampled_steps
from tvclin.errors import (
    LATEST,
    InputError,
    between,
    broadcast,
    instance,
    number,
    numbers,
    positive,
)
from tvclin.histories import History
from tvclin.kernels import flight_table as table
from tvclin.kernels.arcs import linear_flights
from tvclin.kernels.flight_table import FlightTable
from tvclin.kernels.leaning_flights import leaning_flights
from tvclin.kernels.sampled_flights import sampled_flights
from tvclin.plant import Plant

FloatArray = NDArray[np.float64]

STATUS = ("undecided", "survived", "lost", "no flight")
_WIDEST = 1e9
"""A limit of so many radians, or more, is none."""
_ACCURACIES = (1e-11, 1e-4)


@dataclass(frozen=True, eq=False, repr=False)
class FlownCases:
    """What came of many flights, each field in the shape of the batch.

    With a sample rate the largest values are those at samples, and rates are means over a step;
    without one they are those of the whole flight. All are sizes, and NaN where there was no
    flight.

    Attributes
    ----------
    peak_attitude, peak_attitude_rate : ndarray
        Largest attitude [rad] and attitude rate [rad/s].
    peak_deflection, peak_deflection_rate : ndarray
        Largest deflection [rad], and rate of the nozzle [rad/s]; without an actuator the jumps of
        the deflection do not count.
    peak_angle_of_attack : ndarray
        Largest angle of attack [rad].
    final_attitude : ndarray
        Attitude at the end [rad], with its sign.
    end_time : ndarray
        When the flight ended [s].
    saturated_time_fraction : ndarray
        Part of the flight in which the whole limit was asked for.
    status : ndarray of str
        "survived", "lost", "undecided", or "no flight" where a case cannot be flown.
    """

    peak_attitude: FloatArray
    peak_attitude_rate: FloatArray
    peak_deflection: FloatArray
    peak_deflection_rate: FloatArray
    peak_angle_of_attack: FloatArray
    final_attitude: FloatArray
    end_time: FloatArray
    saturated_time_fraction: FloatArray
    status: NDArray[np.str_]

    @property
    def counts(self) -> dict[str, int]:
        """How many flights have each status that occurs, the most frequent first."""
        return dict(Counter(self.status.ravel().tolist()).most_common())

    def __repr__(self) -> str:
        words = ", ".join(f"{count} {status}" for status, count in self.counts.items())
        return f"<FlownCases {self.status.shape}: {words}>"

    def _repr_html_(self) -> str:
        worst = [
            ("attitude", self.peak_attitude),
            ("deflection", self.peak_deflection),
            ("angle of attack", self.peak_angle_of_attack),
        ]
        rows: list[Row] = [(status, count, "flights") for status, count in self.counts.items()]
        rows += [(f"largest {name}", np.degrees(values), "deg") for name, values in worst]
        return card(f"{self.status.size} flights", rows)


def fly_many(
    plant: Plant,
    law: Any,
    wind: History,
    *,
    deflection_limit: ArrayLike,
    rate_limit: ArrayLike = np.inf,
    actuator: Actuator | None = None,
    sample_rate: float | None = None,
    until: float | None = None,
    accuracy: float = table.TOLERANCE,
) -> FlownCases:
    """Return what comes of many flights of laws with limits, each from rest.

    Plants, laws, winds, limits and actuators broadcast: one law, designed on the nominal plant,
    for a thousand dispersed plants and winds, or a thousand limits for one plant.

    Parameters
    ----------
    plant : Plant
        One plant or a batch.
    law : Law, array of Law, or Autopilot
        The laws of this package; an `Autopilot` with a batch of gains stands for a `SaturatedLaw`
        of each.
    wind : History
        One wind or a batch; each must end.
    deflection_limit, rate_limit : array_like
        Largest deflection [rad] and deflection rate [rad/s], positive. A rate limit needs an
        actuator or a sample rate.
    actuator : Actuator, optional
        One or a batch. Without one the deflection follows its command at once.
    sample_rate : float, optional
        Samples of the laws in a second [Hz], as of `fly`. Without one they are computed without
        pause.
    until : float, optional
        When the flights end [s]. Without it each ends when it is lost or saved, which needs one
        or two real unstable poles. Flights of gains and of a dead band without pause are judged
        at their end; others as soon as they are lost or saved, though they go on.
    accuracy : float, optional
        What a step of a flight without pause may leave off of the attitude, over the peak of the
        wind or over a larger attitude, 1e-11 to 1e-4; see the notes.

    Returns
    -------
    FlownCases
        Largest values and fates. A flight is lost when after its wind it leaves the recoverable
        set of its unstable modes, and survives when it has settled well inside. A case whose
        limit is not positive, or whose wind is nothing or never ends, is "no flight", and so is
        one that could never be decided; the others go on.

    Raises
    ------
    InputError
        For shapes that do not broadcast, laws that `fly` alone can fly, a single limit that is
        not positive, a sample rate too slow for the actuator, noise or a rate limit that need
        a sample rate, and an accuracy out of its range.

    Notes
    -----
    With a sample rate every step is exact. Without one the flight is a chain of Taylor series
    from limit to limit and from knot to knot, to about 1e-8 of the largest attitude, and 1e-5 of
    the largest rate of a nozzle. With an `accuracy` of 2e-7 it takes about a tenth less
    time, to 5e-7 of the attitude and 5e-4 of the rate; a flight that is nearly lost multiplies
    both. A recoverable-attitude law is integrated in fixed steps instead, whatever the accuracy,
    to about 1e-6, and 1e-5 with a nozzle that is often at its rate limit.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> wind = tv.TriangularWind(peak=0.1, duration=8.0)
    >>> limits = np.array([0.6, 0.68, 0.7, 0.9]) * 0.01
    >>> flown = tv.fly_many(plant, tv.TrimLaw(plant), wind, deflection_limit=limits)
    >>> flown.status.tolist()
    ['lost', 'lost', 'survived', 'survived']
    """
    instance("plant", plant, Plant, "see Plant.from_vehicle")
    instance("wind", wind, History, "such as TriangularWind")
    limits = {"deflection_limit": deflection_limit, "rate_limit": rate_limit}
    limit, most = (_limit(name, value) for name, value in limits.items())
    if actuator is not None:
        instance("actuator", actuator, Actuator, "see Actuator")
    shape = broadcast(
        plant=plant.batch,
        law=law_batch(law),
        wind=wind.batch,
        deflection_limit=limit.shape,
        rate_limit=most.shape,
        actuator=() if actuator is None else actuator.batch,
    )
    laws = law_rows(law, shape)
    stop = np.inf if until is None else number("until", until, between(-LATEST, LATEST), "s")
    if until is not None:
        check_span(float(np.min(wind.onset, initial=stop)), stop)
    exact = number("accuracy", accuracy, between(*_ACCURACIES))
    flights, good = _table(plant, laws, wind, (limit, most), actuator, stop, exact, shape)
    length = np.nan
    if sample_rate is not None:
        length = 1.0 / _sample_rate(sample_rate, actuator)
        good &= np.broadcast_to(paces(plant) * length <= FASTEST, shape).ravel()
        if until is not None:
            check_samples(stop - float(np.min(wind.onset, initial=stop)), length)
    out = np.full((table.RESULTS, good.size), np.nan)
    if np.any(good):
        some = flights.take(good)
        if sample_rate is None:
            _check_continuous(laws, most, actuator)
            out[:, good] = _continuous(some)
        else:
            steps = sampled_steps(plant, laws, actuator, some, shape, good, length)
            out[:, good] = sampled_flights(some, steps)
    return _flown_cases(out, good, shape)


def _flown_cases(out: FloatArray, good: NDArray[np.bool_], shape: tuple[int, ...]) -> FlownCases:
    fate = np.where(good, np.nan_to_num(out[table.FATE], nan=0.0), len(STATUS) - 1).astype(int)
    return FlownCases(
        peak_attitude=out[table.PEAK_ATTITUDE].reshape(shape),
        peak_attitude_rate=out[table.PEAK_RATE].reshape(shape),
        peak_deflection=out[table.PEAK_DEFLECTION].reshape(shape),
        peak_deflection_rate=out[table.PEAK_DEFLECTION_RATE].reshape(shape),
        peak_angle_of_attack=out[table.PEAK_ALPHA].reshape(shape),
        final_attitude=out[table.FINAL_ATTITUDE].reshape(shape),
        end_time=out[table.ENDED].reshape(shape),
        saturated_time_fraction=out[table.SATURATED].reshape(shape),
        status=np.array(STATUS)[fate].reshape(shape),
    )


def _continuous(flights: FlightTable) -> FloatArray:
    leans = flights.rows[table.LEAN] != 0.0
    if not np.any(leans):
        return linear_flights(flights)
    out = np.zeros((table.RESULTS, leans.size))
    for kind, fly in ((leans, leaning_flights), (~leans, linear_flights)):
        if np.any(kind):
            out[:, kind] = fly(flights.take(kind))
    return out


def _limit(name: str, value: ArrayLike) -> FloatArray:
    """A single limit must be positive; among many a bad one is the matter of its case."""
    array = numbers(name, value)
    if array.ndim or (name == "rate_limit" and array == np.inf):
        return array
    return positive(name, value)


def _sample_rate(rate: float, actuator: Actuator | None) -> float:
    if actuator is None or not actuator.batch:
        return check_sample_rate(rate, actuator)
    fastest = Actuator(natural_frequency=float(np.max(actuator.natural_frequency)))
    return check_sample_rate(rate, fastest)


def _check_continuous(laws: LawRows, most: FloatArray, actuator: Actuator | None) -> None:
    if any(level for level, _ in laws.noise):
        raise InputError("noise belongs to samples; give a sample_rate")
    if actuator is None and np.any(most < np.inf):
        raise InputError("a rate_limit needs an actuator or a sample_rate")


def _table(
    plant: Plant,
    laws: LawRows,
    wind: History,
    limits: tuple[FloatArray, FloatArray],
    actuator: Actuator | None,
    stop: float,
    accuracy: float,
    shape: tuple[int, ...],
) -> tuple[FlightTable, NDArray[np.bool_]]:
    """The table of all flights, and which of them can be flown."""
    rows = laws.rows
    limit, most = (np.broadcast_to(a, shape).ravel() for a in limits)
    limit = np.minimum(limit, _WIDEST)
    order = _plant_rows(rows, plant, shape)
    for row, judged in enumerate(judging_rows(plant), start=table.FAST):
        rows[row] = np.broadcast_to(judged, shape).ravel()
    rows[table.LIMIT], rows[table.RATE_LIMIT] = limit, most
    for row in (table.ENGAGE, table.RELEASE, table.REACH):
        rows[row] *= limit
    servo = 0
    if actuator is not None:
        terms = actuator.denominator
        servo = terms.shape[-1] - 1
        rows[table.STIFFNESS] = np.broadcast_to(terms[..., -1], shape).ravel()
        rows[table.DRAG] = np.broadcast_to(terms[..., -2], shape).ravel() if servo > 1 else 0.0
    knots, gust = polynomial_pieces(wind)
    which = np.arange(len(knots)).reshape(wind.batch)
    which = np.broadcast_to(which, shape).ravel().astype(np.int64)
    rows[table.START] = np.broadcast_to(wind.onset, shape).ravel()
    rows[table.END] = np.broadcast_to(wind.end, shape).ravel()
    rows[table.UNTIL] = stop
    size = np.abs(np.ascontiguousarray(gust[..., 0].T)).max(axis=0)[which]
    with np.errstate(divide="ignore", invalid="ignore"):
        rows[table.SCALE] = 1.0 / size
        held = table.LARGE * np.abs(rows[table.GUST] / rows[table.MOMENT]) * size
        rows[table.SERVO_SCALE] = 1.0 / np.where(held > 0.0, np.minimum(limit, held), limit)
    rows[table.ACCURACY] = accuracy
    good = (limit > 0.0) & (limit < _WIDEST) & (most > 0.0) & np.isfinite(rows[table.END])
    good &= ~np.isnan(rows[table.REACH]) | (stop < np.inf)
    return FlightTable(rows, order, servo, knots, gust, which, laws.free, laws.driven), good


def _plant_rows(rows: FloatArray, plant: Plant, shape: tuple[int, ...]) -> int:
    """Fill the rows of the plants; return their order."""
    A, inputs, _, _ = plant.matrices()
    order = A.shape[-1]
    entries = {table.MU: A[..., 1, 0], table.MOMENT: inputs[..., 1, 0]}
    entries[table.GUST] = inputs[..., 1, 1]
    if order > 2:
        entries |= {table.MU_PATH: A[..., 1, 2], table.PATH_ATTITUDE: A[..., 2, 0]}
        entries |= {table.PATH_PATH: A[..., 2, 2], table.PATH_DEFLECTION: inputs[..., 2, 0]}
        entries[table.PATH_GUST] = inputs[..., 2, 1]
    if order > 3:
        entries |= {table.PATH_SPEED: A[..., 2, 3], table.SPEED_PATH: A[..., 3, 2]}
    for row, entry in entries.items():
        rows[row] = np.broadcast_to(entry, shape).ravel()
    return order
