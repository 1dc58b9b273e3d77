"""The nozzle's point beside a front: what is needed, what is there, what is left."""

from __future__ import annotations

import numpy as np

from tvclin.base.lines import Table, degrees, least

Quantity = tuple[str, str, float, float | None]
"""Label, key, what is needed, and what is there [rad, rad/s]."""


def left_of(there: float | None, needed: float) -> float | None:
    """Return what is left of what is there; None where nothing is given."""
    return None if there is None else there - needed


def point_table(title: str, *quantities: Quantity) -> Table:
    """Return the table of a nozzle's quantities, in degrees."""
    rows = []
    for label, key, needed, there in quantities:
        left = left_of(there, needed)
        rows.append(
            (
                (label,),
                least(degrees(f"nozzle.{key}.needed", needed)),
                degrees(f"nozzle.{key}.there", np.nan if there is None else there),
                degrees(f"nozzle.{key}.left", np.nan if left in (None, -np.inf) else left),
            )
        )
    return Table(title, ("", "needed", "there", "left"), tuple(rows))
