"""Checks of the arguments of flights with limits."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.batch import SUBSTEPS, frequency
from tvclin.linear.flexible import AnyPlant, check_plant
from tvclin.winds.histories import History

LOST = 1e100
"""Magnitude of a state beyond which a flight ends as lost."""
_SAMPLE_RATES = (0.01, 1e6)
"""Smallest and largest sample rate of a law [Hz]."""
MAX_SAMPLES = 1_000_000
"""Largest number of samples of a flight; more are a rate or a time in the wrong unit."""
MAX_POLE_TIMES_SAMPLE = 100.0
"""Largest pole of a plant times the sample period."""
_MAX_DURATION = 1e5
"""Longest flight [s]."""
MAX_DELAY_SAMPLES = 10_000
"""Largest delay of a command, in samples."""
_MAX_SUBSTEPS = 1000.0
"""Largest number of substeps of the nozzle in a sample of the law."""


def check_flight(plant: AnyPlant, law: Law, wind: History) -> None:
    """Raise `InputError` unless the arguments are one plant, a law, and one wind that ends."""
    check_plant(plant)
    errors.instance("law", law, Law, "such as TrimLaw")
    errors.instance("wind", wind, History, "such as TriangularWind")
    if plant.batch or wind.batch:
        raise errors.InputError(
            f"a flight is of one plant in one wind; got batches of shape {plant.batch} and"
            f" {wind.batch}"
        )
    errors.ending("wind", wind.end)


def check_sample_rate(sample_rate: float, actuator: Actuator | None) -> float:
    """Return the sample rate [Hz] of a law; `InputError` if it is too low for the actuator."""
    errors.number("sample_rate", sample_rate, errors.positive, "Hz")
    check_actuator(actuator)
    return float(check_sample_rates(sample_rate, actuator))


def check_sample_rates(sample_rate: ArrayLike, actuator: Actuator | None) -> FloatArray:
    """Return sample rates [Hz] of laws; `InputError` if one is too low for its actuator.

    It is too low where a sample would have more than a thousand substeps of 1/8 of 1/omega.
    """
    rates = errors.within(
        "sample_rate", errors.positive("sample_rate", sample_rate, "Hz"), *_SAMPLE_RATES, "Hz"
    )
    if actuator is not None:
        errors.instance("actuator", actuator, Actuator, "see Actuator")
        minimum = SUBSTEPS / _MAX_SUBSTEPS * frequency(actuator)
        errors.together(sample_rate=rates, actuator=minimum)
        if np.any(rates < minimum):
            raise errors.InputError(
                f"sample_rate must be at least {minimum.max():.6g} Hz for an actuator"
                f" of {frequency(actuator).max():.6g} rad/s; got"
                f" {errors.shown(errors.plain(rates))} Hz"
            )
    return rates


def check_delays(delay: ArrayLike, period: FloatArray) -> FloatArray:
    """Return computing delays [s]; `InputError` if one is negative or longer than 10000 samples.

    `period`: sample periods [s], which broadcast with the delays.
    """
    delays = errors.nonnegative("delay", delay, "s")
    errors.together(delay=delays, sample_rate=period)
    if np.any(delays > MAX_DELAY_SAMPLES * period):
        raise errors.InputError(
            f"delay must be at most {MAX_DELAY_SAMPLES} samples; got"
            f" {errors.shown(errors.plain(delays))} s at {1.0 / float(period.min()):.6g} Hz"
        )
    return delays


def check_samples(span: float, period: float) -> None:
    """Raise `InputError` if a time `span` [s] has too many samples of a period `period` [s]."""
    if not span / period <= MAX_SAMPLES:
        raise errors.InputError(
            f"a flight may have at most {MAX_SAMPLES} samples; {span:.6g} s at"
            f" {1.0 / period:.6g} Hz are more: take a lower sample_rate, or an earlier end"
        )


def check_fastest_pole(plant: AnyPlant, period: float) -> None:
    """Raise `InputError` if a pole of a plant is too fast for a sample period `period` [s]."""
    pole = float(fastest_poles(plant))
    if not pole * period <= MAX_POLE_TIMES_SAMPLE:
        raise errors.InputError(
            f"sample_rate must be at least {pole / MAX_POLE_TIMES_SAMPLE:.6g} Hz for a plant that"
            f" moves with {pole:.6g} 1/s; got {1.0 / period:.6g} Hz"
        )


def fastest_poles(plant: AnyPlant) -> FloatArray:
    """Return the magnitude of the fastest pole [1/s] of each plant, ``(...)``."""
    return np.asarray(np.abs(plant.poles).max(axis=-1))


def check_span(start: float, stop: float) -> None:
    """Raise `InputError` if a flight from `start` to `stop` [s] is too long."""
    if not stop - start <= _MAX_DURATION:
        raise errors.InputError(
            f"a flight may last at most {_MAX_DURATION:g} s; got one from {start:.6g} to"
            f" {stop:.6g} s"
        )


def check_rate_limit(rate_limit: float) -> float:
    """Return the rate limit [rad/s], positive or infinite."""
    return errors.unlimited("rate_limit", rate_limit, unit="rad/s")


def check_not_lost(time: float, states: FloatArray) -> None:
    """Raise `InputError` if the size of a state of a flight at a time [s] exceeds `LOST`."""
    if not np.abs(states).max() <= LOST:
        raise errors.InputError(
            f"the flight is lost and grows without bounds; ask for times before t = {time:.6g} s"
        )


def check_actuator(actuator: Actuator | None) -> None:
    """Raise `InputError` unless `actuator` is None or a single actuator, not a batch."""
    if actuator is None:
        return
    errors.instance("actuator", actuator, Actuator, "of one natural frequency")
    errors.single("actuator", actuator.batch)
