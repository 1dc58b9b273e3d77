"""Laws by name: the design of each on a plant, and its options.

Trim and dead band are designed on a fixed path whatever the plant, so that they hold the attitude
as the report defines it; designed with drift they would let the slow mode diverge. A rate limit
sets the gain of trim and the lean of the recoverable-attitude law.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from tvclin.base.errors import InputError, instance, number, one_of, small_angle
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.design_rules import GIVEN_GAINS
from tvclin.control.autopilot.feedback import ACCELEROMETER, CHAINS, GAINS
from tvclin.control.autopilot.gains import canonical_gains, half_relief_gains
from tvclin.control.autopilot.system_autopilot import SystemAutopilot
from tvclin.control.laws.autopilot_law import SaturatedLaw, SystemLaw
from tvclin.control.laws.law import FilteredLaw, Law, law_rate_limit
from tvclin.control.laws.recoverable import RecoverableAttitudeLaw
from tvclin.control.laws.trim import DeadBandLaw, TrimLaw
from tvclin.linear.plant import PLANT_HINT, Plant

AUTOPILOT, DEAD_BAND = "autopilot", "dead-band"


def _feedback(
    plant: Plant, peak: float, rate_limit: float, autopilot: Autopilot | None = None
) -> Law:
    """Return the law of an `autopilot` without filters, by default of a plant's canonical gains.

    `peak` and `rate_limit` are not used; all functions of `LAWS` have them.
    """
    if autopilot is None:
        return SaturatedLaw(canonical_gains(plant.coefficients))
    instance("autopilot", autopilot, Autopilot, "see design_gains")
    if isinstance(autopilot, SystemAutopilot):
        bare: Any = dict.fromkeys(CHAINS, ())
        return SystemLaw(replace(autopilot, **bare))
    names = (*GAINS, *ACCELEROMETER)
    return SaturatedLaw(Autopilot(**{name: getattr(autopilot, name) for name in names}))


def _trim(plant: Plant, peak: float, rate_limit: float) -> Law:
    """Return ideal trim of `plant` on a fixed path, with a gain that peak and rate limit allow."""
    return TrimLaw.suited(Plant(plant.coefficients, "fixed-path"), peak, rate_limit)


def _dead_band(plant: Plant, peak: float, rate_limit: float, dead_band: float = 0.5) -> Law:
    """Return the report's control with `dead_band` K on a fixed path.

    Trim inside K times the limit, then the full limit. `peak` and `rate_limit` are not used; all
    functions of `LAWS` have them.
    """
    return DeadBandLaw(Plant(plant.coefficients, "fixed-path"), dead_band=dead_band)


def _half_relief(plant: Plant, peak: float, rate_limit: float) -> Law:
    """Return the law of a plant's half-relief gains.

    `peak` and `rate_limit` are not used; all functions of `LAWS` have them.
    """
    return SaturatedLaw(half_relief_gains(plant.coefficients))


def _recoverable(plant: Plant, peak: float, rate_limit: float) -> Law:
    """Return the recoverable-attitude law for a wind peak [rad] and rate limit [rad/s]."""
    return RecoverableAttitudeLaw(plant, design_peak=peak, rate_limit=rate_limit)


LAWS: Mapping[str, Callable[..., Law]] = MappingProxyType(
    {
        AUTOPILOT: _feedback,
        "trim": _trim,
        DEAD_BAND: _dead_band,
        "half-relief": _half_relief,
        "recoverable-attitude": _recoverable,
    }
)
"""Design functions of a plant, a wind peak [rad], a rate limit [rad/s], and options of the law."""
_TRIM_NOTE = (
    "trim has a gain of {:.3g}, which suits the rate limit; its usual gain of {:g} asks for a"
    " nozzle five times as quick as the wind, or for more angle"
)
_OPTIONS = {AUTOPILOT: AUTOPILOT, DEAD_BAND: "dead_band"}
"""Name of the option of each law that has one."""


def design_law(
    name: str, plant: Plant, peak: float, *, rate_limit: float = np.inf, **options: Any
) -> Law:
    """Return a law by its name, designed on a plant and for the peak of a wind.

    Parameters
    ----------
    name : str
        One of `LAWS`.
    plant : Plant
        One plant.
    peak : float
        Peak of the wind [rad], which the law "recoverable-attitude" is designed for.
    rate_limit : float
        Rate limit of the nozzle [rad/s], which "trim" and "recoverable-attitude" respect.
    **options
        Options of the law: `autopilot`, with the gains of the law "autopilot" instead of canonical
        gains, and `dead_band`, K of the law "dead-band" instead of 0.5.

    Raises
    ------
    InputError
        For an unknown name, an option of another law, and in the same cases as the law.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> tv.control.design_law("dead-band", plant, peak=0.09, dead_band=0.8).dead_band
    0.8
    """
    design = LAWS[one_of("law", name, LAWS)]
    instance("plant", plant, Plant, PLANT_HINT)
    for key in options:
        if key != _OPTIONS.get(name):
            raise InputError(f"{key} is not of the law {name}; leave it out")
    rate = law_rate_limit("rate_limit", rate_limit, "rad/s")
    return design(plant, number("peak", peak, small_angle("a wind angle"), "rad"), rate, **options)


def linear_gains(law: Law) -> dict[str, float] | None:
    """Return the gains on attitude, attitude rate and angle of attack of a law, by name.

    None for other laws than trim and the gains of an autopilot, which are linear within the
    deflection limit; trim is designed on a fixed path, without a gain on the flight path angle.
    """
    if type(law) not in (TrimLaw, SaturatedLaw):
        return None
    numbers = law.numbers
    assert numbers is not None
    assert not numbers.flight_path_angle
    gains = (numbers.attitude, numbers.attitude_rate, numbers.angle_of_attack)
    return dict(zip(GIVEN_GAINS, gains, strict=True))


def design_notes(law: Law) -> Iterator[str]:
    """Yield notes on the design of a law for the reader of its flight."""
    law = law.law if isinstance(law, FilteredLaw) else law
    if type(law) is TrimLaw and law.gain < TrimLaw.gain:
        yield _TRIM_NOTE.format(law.gain, TrimLaw.gain)
