"""The door to all flights with limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tvclin.autopilot import Actuator
from tvclin.autopilot.systems import wind_response
from tvclin.closed_loop.airframe import Nozzle, gust_steps, steps
from tvclin.closed_loop.checks import (
    check_actuator,
    check_flight,
    check_not_lost,
    check_rate_limit,
    check_sample_rate,
    check_span,
)
from tvclin.closed_loop.continuous import ContinuousFlight
from tvclin.closed_loop.equations import LinearEquations
from tvclin.closed_loop.sampled import Sampler, at_rest
from tvclin.errors import InputError, number, positive, times_row
from tvclin.histories import History
from tvclin.kernels.propagation import driven, exponentials
from tvclin.laws import Law
from tvclin.plant import Plant

if TYPE_CHECKING:
    from control import TimeResponseData

FloatArray = NDArray[np.float64]


def fly(
    plant: Plant,
    law: Law,
    wind: History,
    timepts: ArrayLike,
    *,
    deflection_limit: float,
    rate_limit: float = np.inf,
    actuator: Actuator | None = None,
    sample_rate: float | None = None,
) -> TimeResponseData:
    """Return the flight of a law with limits, as `control.TimeResponseData`.

    It is at rest until the onset of the wind.

    Parameters
    ----------
    plant : Plant
        One plant of any model.
    law : Law
        The law, designed on this plant or on another.
    wind : History
        One wind that ends.
    timepts : array_like
        Times [s], ``(n,)``; knots and switches need not be among them.
    deflection_limit : float
        Largest deflection [rad], positive.
    rate_limit : float
        Largest deflection rate [rad/s]; it needs an actuator or a sample rate.
    actuator : Actuator, optional
        Without one the deflection follows its command at once.
    sample_rate : float, optional
        Samples of the law in a second [Hz], the first at the onset of the wind; the command is
        held between them, and the deflection goes evenly over each step. Without one the law is
        computed without pause.

    Returns
    -------
    control.TimeResponseData
        Outputs those of the plant, and the deflection [rad, rad/s]; input wind [rad].

    Raises
    ------
    InputError
        For batches, limits that are not positive, a wind that never ends, times long after the
        flight is lost, a sample rate too slow for the actuator, noise or a rate limit that need a
        sample rate, and a law that looks at the deflection where it has neither an actuator nor a
        sample before it.

    Notes
    -----
    Without pause, the knots of the wind, the limit, the switches of the law, and the rate limit and
    the stop of an actuator are hit by the solver, which runs anew from each to the next, however
    short the limit is touched. The attitude is exact to about 1e-9 of its largest value, to 1e-8
    with a law that leans; a flight that is nearly lost multiplies both. With a sample rate every
    step is exact. Either way a late gust is never missed.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1))
    >>> wind = tv.TriangularWind(peak=0.1, duration=8.0)
    >>> law = tv.RecoverableAttitudeLaw(plant, design_peak=0.1)
    >>> flown = tv.fly(plant, law, wind, np.linspace(0, 40, 9), deflection_limit=0.0045)
    >>> bool(abs(flown.outputs["attitude"][-1]) < 1e-6)
    True
    """
    check_flight(plant, law, wind)
    times = times_row("timepts", timepts)
    limit = number("deflection_limit", deflection_limit, positive, "rad")
    most = check_rate_limit(rate_limit)
    start = float(wind.onset)
    check_span(start, float(times.max()))
    if sample_rate is None:
        rows = _continuous(plant, law, wind, times, (limit, most), actuator, start)
    else:
        length = 1.0 / check_sample_rate(sample_rate, actuator)
        rows = _sampled(plant, law, wind, times, limit, Nozzle(actuator, most, length), start)
    return _response(plant, wind, times, rows)


def _continuous(
    plant: Plant,
    law: Law,
    wind: History,
    times: FloatArray,
    limits: tuple[float, float],
    actuator: Actuator | None,
    start: float,
) -> FloatArray:
    if law.rate_noise[0]:
        raise InputError("noise belongs to samples; give a sample_rate")
    if limits[1] < np.inf and actuator is None:
        raise InputError("a rate_limit needs an actuator or a sample_rate")
    check_actuator(actuator)
    flight = ContinuousFlight(LinearEquations(plant), law, wind, *limits, actuator)
    stop = float(np.nextafter(times.max(), np.inf))
    return flight.shown(flight.arcs(start, max(stop, start + 1e-9)), times)


def _sampled(
    plant: Plant,
    law: Law,
    wind: History,
    times: FloatArray,
    limit: float,
    nozzle: Nozzle,
    start: float,
) -> FloatArray:
    last = max(float(times.max()), start) + nozzle.length
    made = steps(plant, wind, start, last, nozzle.length)
    sampler = Sampler(law, made, nozzle)
    flights = at_rest(law, made, nozzle, np.array([limit]))
    every = [flights]
    for time, one in zip(made.times[1:], sampler.each(flights, 0, len(made.gusts)), strict=True):
        check_not_lost(float(time), one.airframe)
        every.append(one)
    x = np.stack([one.airframe[:, 0] for one in every])
    servo = np.clip([one.servo[0, 0] for one in every], -limit, limit)
    k = np.maximum(np.searchsorted(made.times, times, side="right") - 1, 0)
    first = servo[k + 1] if nozzle.jumps else servo[k]
    slope = (servo[k + 1] - first) / nozzle.length
    A, inputs, _, _ = plant.matrices()
    n = len(A)
    held_and_ramp = np.column_stack([inputs[:, 0], np.zeros(n)])
    matrix = driven(A, held_and_ramp, np.eye(2, k=1))
    u = np.maximum(times - made.times[k], 0.0)
    grown = exponentials(matrix, u)
    begun = np.concatenate([x[k], first[:, np.newaxis], slope[:, np.newaxis]], axis=1)
    rows = np.zeros((n + 1, times.size))
    rows[:n] = np.einsum("mij,mj->im", grown[:, :n], begun)
    for i, (j, t) in enumerate(zip(k, times, strict=True)):
        if t > made.times[j]:
            edges = np.array([made.times[j], t])
            rows[:n, i] += gust_steps(A, inputs[:, 1], wind, edges)[0]
    rows[n] = first + slope * u
    return np.where(times < start, 0.0, rows)


def _response(plant: Plant, wind: History, times: FloatArray, rows: FloatArray) -> TimeResponseData:
    _, _, C, D = plant.matrices()
    outputs = C @ rows[:-1] + D @ np.stack([rows[-1], wind(times)])
    return wind_response(
        times,
        np.vstack([outputs, rows[-1:]]),
        wind,
        (*plant.outputs, "deflection"),
        name=f"{plant.model} with limits",
        title=f"Flight with limits, {plant.model} model",
    )
