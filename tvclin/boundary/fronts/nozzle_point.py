"""The nozzle's point compared with a front: lower bound, available and remaining."""

from __future__ import annotations

import numpy as np

from tvclin.base.lines import Table, degrees, minimum_limit

Quantity = tuple[str, str, float, float | None]
"""Label, key, lower bound and available quantity [rad, rad/s]."""


def left_of(there: float | None, needed: float) -> float | None:
    """Return what remains of an available quantity; None where it is not given."""
    return None if there is None else there - needed


def lower_bound(name: str, deflection: float) -> str:
    """Return a lower bound [rad] of the limit in words."""
    if np.isinf(deflection):
        return f"{name}: no limit is sufficient"
    return f"{name}: {np.degrees(deflection):.3f} deg; a limit below it is never sufficient"


def point_table(title: str, *quantities: Quantity) -> Table:
    """Return the table of a nozzle's quantities, in degrees."""
    rows = []
    for label, key, needed, there in quantities:
        left = left_of(there, needed)
        rows.append(
            (
                (label,),
                minimum_limit(degrees(f"nozzle.{key}.needed", needed)),
                degrees(f"nozzle.{key}.there", np.nan if there is None else there),
                degrees(f"nozzle.{key}.left", np.nan if left in (None, -np.inf) else left),
            )
        )
    return Table(title, ("", "lower bound", "available", "remaining"), tuple(rows))
