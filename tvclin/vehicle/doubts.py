"""Numbers of a vehicle that are probably slips of the pen."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tvclin.vehicle.vehicle import Vehicle

_FEEBLE = 0.5
"""A booster's thrust over its weight is rather a slip of the pen below this."""
_HEAVY = 10.0
"""Above this a mass was rather typed as a weight: 1.05 at lift-off would be 10.3 then. Boosters fly
with 1.05 to 5 or so."""


def doubts(vehicle: Vehicle) -> Iterator[str]:
    """Say what is doubtful of a vehicle or a batch, each in a sentence without its full stop.

    A thrust far below or above the weight, and a centre of pressure behind that of gravity.
    """
    ratio = np.asarray(vehicle.thrust) / vehicle.weight
    arm = np.asarray(vehicle.aerodynamic_arm)
    if np.any(ratio < _FEEBLE):
        yield f"thrust is far below weight (T/W {ratio.min():.2g}): a power of ten may be missing"
    if np.any(ratio > _HEAVY):
        yield (
            f"thrust is far above weight (T/W {ratio.max():.2g}): if the weight is a mass, write it"
            " as mass_kg, mass_lb or mass_slug"
        )
    if np.any(arm < 0.0):
        yield (
            f"the aerodynamic arm l_a is negative ({arm.min():.4g} m): the centre of pressure"
            " lies behind the centre of gravity, and the air turns the vehicle back by itself; the"
            " arm is positive where it lies ahead"
        )
