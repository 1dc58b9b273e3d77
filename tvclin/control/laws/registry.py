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
    """Return the law of an autopilot without its filters, by default of a plant's canonical gains.

    `peak` and `rate_limit` are not used; the design functions of all laws have them.
    """
    if autopilot is None:
        return SaturatedLaw(canonical_gains(plant.coefficients))
    instance("autopilot", autopilot, Autopilot, "see design_gains")
    if isinstance(autopilot, SystemAutopilot):
        no_filters: Any = dict.fromkeys(CHAINS, ())
        return SystemLaw(replace(autopilot, **no_filters))
    names = (*GAINS, *ACCELEROMETER)
    return SaturatedLaw(Autopilot(**{name: getattr(autopilot, name) for name in names}))


def _fixed_path(plant: Plant) -> Plant:
    """Return the plant of the same coefficients on a fixed path."""
    return Plant(plant.coefficients, "fixed-path")


LAWS: Mapping[str, Callable[..., Law]] = MappingProxyType(
    {
        AUTOPILOT: _feedback,
        "trim": lambda plant, peak, rate_limit: TrimLaw.suited(
            _fixed_path(plant), peak, rate_limit
        ),
        DEAD_BAND: lambda plant, peak, rate_limit, dead_band=0.5: DeadBandLaw(
            _fixed_path(plant), dead_band=dead_band
        ),
        "half-relief": lambda plant, peak, rate_limit: SaturatedLaw(
            half_relief_gains(plant.coefficients)
        ),
        "recoverable-attitude": lambda plant, peak, rate_limit: RecoverableAttitudeLaw(
            plant, design_peak=peak, rate_limit=rate_limit
        ),
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
        if key != _OPTIONS.get(name):  # of two laws that have one option each
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
    """Yield a note for the reader of a flight if a rate limit has reduced the gain of trim."""
    law = law.law if isinstance(law, FilteredLaw) else law
    if type(law) is TrimLaw and law.gain < TrimLaw.gain:
        yield _TRIM_NOTE.format(law.gain, TrimLaw.gain)
