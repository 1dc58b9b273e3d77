"""What a flight is refused for."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import (
    InputError,
    ending,
    instance,
    nonnegative,
    number,
    plain,
    positive,
    shown,
    single,
    together,
    unlimited,
    within,
)
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.batch import SUBSTEPS, frequency
from tvclin.linear.flexible import AnyPlant, check_plant
from tvclin.winds.histories import History

LOST = 1e100
"""A state beyond this is not flown on."""
_RATES = (0.01, 1e6)
"""Sample rates of a law [Hz]."""
MOST = 1_000_000
"""Samples of one flight; more are a rate or a time that was given in the wrong unit."""
FASTEST = 100.0
"""Most e-foldings of a plant in a sample of the law."""
_LONGEST = 1e5
"""Longest flight [s]."""
LATE = 10_000
"""Samples by which a command may be late."""
_MOST_SUBSTEPS = 1000.0
"""Of the hardware in a sample of the law."""


def check_flight(plant: AnyPlant, law: Law, wind: History) -> None:
    """Raise `InputError` unless these are one plant, a law, and one wind that ends."""
    check_plant(plant)
    instance("law", law, Law, "such as TrimLaw")
    instance("wind", wind, History, "such as TriangularWind")
    if plant.batch or wind.batch:
        raise InputError(
            f"a flight is of one plant in one wind; got batches of shape {plant.batch} and"
            f" {wind.batch}"
        )
    ending("wind", wind.end)


def check_sample_rate(sample_rate: float, actuator: Actuator | None) -> float:
    """Return the rate [Hz] of a law; `InputError` if its samples hold too many substeps."""
    number("sample_rate", sample_rate, positive, "Hz")
    check_actuator(actuator)
    return float(check_sample_rates(sample_rate, actuator))


def check_sample_rates(sample_rate: ArrayLike, actuator: Actuator | None) -> FloatArray:
    """Return the rates [Hz], one or many; `InputError` if one is far too slow for its actuator."""
    rates = within("sample_rate", positive("sample_rate", sample_rate, "Hz"), *_RATES, "Hz")
    if actuator is not None:
        instance("actuator", actuator, Actuator, "see Actuator")
        least = SUBSTEPS / _MOST_SUBSTEPS * frequency(actuator)
        together(sample_rate=rates, actuator=least)
        if np.any(rates < least):
            raise InputError(
                f"sample_rate must be at least {least.max():.6g} Hz for an actuator of"
                f" {frequency(actuator).max():.6g} rad/s; got {shown(plain(rates))} Hz"
            )
    return rates


def check_delays(delay: ArrayLike, length: FloatArray) -> FloatArray:
    """Return the delays [s]; `InputError` if one is below zero or of too many samples [s]."""
    delays = nonnegative("delay", delay, "s")
    together(delay=delays, sample_rate=length)
    if np.any(delays > LATE * length):
        raise InputError(
            f"delay must be at most {LATE} samples; got {shown(plain(delays))} s at"
            f" {1.0 / float(length.min()):.6g} Hz"
        )
    return delays


def check_samples(span: float, length: float) -> None:
    """Raise `InputError` when a time [s] takes too many samples of a length [s]."""
    if not span / length <= MOST:
        raise InputError(
            f"a flight may have at most {MOST} samples; {span:.6g} s at {1.0 / length:.6g} Hz are"
            " more: take a lower sample_rate, or an earlier end"
        )


def check_pace(plant: AnyPlant, length: float) -> None:
    """Raise `InputError` when a plant moves by far more than a law can follow in a sample [s]."""
    pace = float(paces(plant))
    if not pace * length <= FASTEST:
        raise InputError(
            f"sample_rate must be at least {pace / FASTEST:.6g} Hz for a plant that moves with"
            f" {pace:.6g} 1/s; got {1.0 / length:.6g} Hz"
        )


def paces(plant: AnyPlant) -> FloatArray:
    """Return the size of the fastest pole [1/s] of each plant."""
    return np.asarray(np.abs(plant.poles).max(axis=-1))


def check_span(start: float, stop: float) -> None:
    """Raise `InputError` when a flight from one time to another [s] is longer than any."""
    if not stop - start <= _LONGEST:
        raise InputError(
            f"a flight may last at most {_LONGEST:g} s; got one from {start:.6g} to {stop:.6g} s"
        )


def check_rate_limit(rate_limit: float) -> float:
    """Return the rate limit [rad/s], positive or infinite."""
    return unlimited("rate_limit", rate_limit, unit="rad/s")


def check_not_lost(time: float, states: FloatArray) -> None:
    """Raise `InputError` when states at a time [s] have grown beyond all meaning."""
    if not np.abs(states).max() <= LOST:
        raise InputError(
            f"the flight is lost and grows without bounds; ask for times before t = {time:.6g} s"
        )


def check_actuator(actuator: Actuator | None) -> None:
    """Raise `InputError` unless there is no actuator, or one."""
    if actuator is None:
        return
    instance("actuator", actuator, Actuator, "of one natural frequency")
    single("actuator", actuator.batch)
