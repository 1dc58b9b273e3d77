"""The laws by name: how each is designed on a plant, and what of its own it takes.

Trim and dead band hold the attitude, as the report means it, whatever the plant: designed with
drift they would let its slow mode grow.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from tvclin.base.errors import InputError, instance, number, one_of, small_angle
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import GAINS
from tvclin.control.autopilot.gains import canonical_gains, half_relief_gains
from tvclin.control.laws.attitude import SaturatedLaw
from tvclin.control.laws.dead_band import DeadBandLaw
from tvclin.control.laws.law import Law
from tvclin.control.laws.recoverable import RecoverableAttitudeLaw
from tvclin.control.laws.trim import TrimLaw
from tvclin.linear.plant import RIGID, Plant

AUTOPILOT, DEAD_BAND = "autopilot", "dead-band"


def _feedback(plant: Plant, _: float, autopilot: Autopilot | None = None) -> Law:
    if autopilot is None:
        return SaturatedLaw(canonical_gains(plant.coefficients))
    instance("autopilot", autopilot, Autopilot, "see design_gains")
    return SaturatedLaw(Autopilot(**{name: getattr(autopilot, name) for name in GAINS}))


def _trim(plant: Plant, _: float) -> Law:
    return TrimLaw(Plant(plant.coefficients, "fixed-path"))


def _dead_band(plant: Plant, _: float, dead_band: float = 0.5) -> Law:
    return DeadBandLaw(Plant(plant.coefficients, "fixed-path"), dead_band=dead_band)


def _half_relief(plant: Plant, _: float) -> Law:
    return SaturatedLaw(half_relief_gains(plant.coefficients))


def _recoverable(plant: Plant, peak: float) -> Law:
    return RecoverableAttitudeLaw(plant, design_peak=peak)


LAWS: Mapping[str, Callable[..., Law]] = MappingProxyType(
    {
        AUTOPILOT: _feedback,
        "trim": _trim,
        DEAD_BAND: _dead_band,
        "half-relief": _half_relief,
        "recoverable-attitude": _recoverable,
    }
)
"""The design of each: of a plant, the peak of a wind [rad], and what it takes of its own."""
_OWN = {AUTOPILOT: AUTOPILOT, DEAD_BAND: "dead_band"}


def design_law(name: str, plant: Plant, peak: float, **own: Any) -> Law:
    """Return a law by its name, designed on a plant and for the peak of a wind.

    Parameters
    ----------
    name : str
        One of `LAWS`.
    plant : Plant
        One plant.
    peak : float
        Peak of the wind [rad], which the law "recoverable-attitude" is designed for.
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
    return design(plant, number("peak", peak, small_angle("a wind angle"), "rad"), **own)
