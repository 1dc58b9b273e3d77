"""The laws by name: how each is designed on a plant, and what of its own it takes.

Trim and dead band hold the attitude, as the report means it, whatever the plant: designed with
drift they would let its slow mode grow. Of a rate limit trim takes the gain that suits it, and the
recoverable-attitude law how far it may turn.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from tvclin.base.errors import InputError, instance, number, one_of, small_angle, unlimited
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import GAINS
from tvclin.control.autopilot.gains import canonical_gains, half_relief_gains
from tvclin.control.laws.attitude import SaturatedLaw
from tvclin.control.laws.law import RATES, FilteredLaw, Law
from tvclin.control.laws.recoverable import RecoverableAttitudeLaw
from tvclin.control.laws.trim import DeadBandLaw, TrimLaw
from tvclin.linear.plant import RIGID, Plant

AUTOPILOT, DEAD_BAND = "autopilot", "dead-band"


def _feedback(plant: Plant, _: float, __: float, autopilot: Autopilot | None = None) -> Law:
    if autopilot is None:
        return SaturatedLaw(canonical_gains(plant.coefficients))
    instance("autopilot", autopilot, Autopilot, "see design_gains")
    return SaturatedLaw(Autopilot(**{name: getattr(autopilot, name) for name in GAINS}))


def _trim(plant: Plant, peak: float, rate_limit: float) -> Law:
    return TrimLaw.suited(Plant(plant.coefficients, "fixed-path"), peak, rate_limit)


def _dead_band(plant: Plant, _: float, __: float, dead_band: float = 0.5) -> Law:
    return DeadBandLaw(Plant(plant.coefficients, "fixed-path"), dead_band=dead_band)


def _half_relief(plant: Plant, _: float, __: float) -> Law:
    return SaturatedLaw(half_relief_gains(plant.coefficients))


def _recoverable(plant: Plant, peak: float, rate_limit: float) -> Law:
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
"""The design of each: of a plant, the peak of a wind [rad], a rate limit [rad/s], and its own."""
_TRIM_NOTE = (
    "trim has a gain of {:.3g}, which suits the rate limit; its usual gain of {:g} asks for a"
    " nozzle five times as quick as the wind, or for more angle"
)
_OWN = {AUTOPILOT: AUTOPILOT, DEAD_BAND: "dead_band"}


def design_law(
    name: str, plant: Plant, peak: float, *, rate_limit: float = np.inf, **own: Any
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
        What the nozzle turns at most [rad/s]: "trim" and "recoverable-attitude" suit it.
    **own
        What the law takes of its own: `autopilot`, whose gains the law "autopilot" has in place of
        the canonical ones, and `dead_band`, K of the law "dead-band" in place of 0.5.

    Raises
    ------
    InputError
        For another name, what the law does not take, and as the law.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> tv.control.design_law("dead-band", plant, peak=0.09, dead_band=0.8).dead_band
    0.8
    """
    design = LAWS[one_of("law", name, LAWS)]
    instance("plant", plant, Plant, RIGID)
    for key in own:
        if key != _OWN.get(name):
            raise InputError(f"{key} is not of the law {name}; leave it out")
    most = unlimited("rate_limit", rate_limit, RATES, "rad/s")
    return design(plant, number("peak", peak, small_angle("a wind angle"), "rad"), most, **own)


def design_notes(law: Law) -> Iterator[str]:
    """Return what the reader of a flight should know of the design of its law."""
    law = law.law if isinstance(law, FilteredLaw) else law
    if type(law) is TrimLaw and law.gain < TrimLaw.gain:
        yield _TRIM_NOTE.format(law.gain, TrimLaw.gain)
