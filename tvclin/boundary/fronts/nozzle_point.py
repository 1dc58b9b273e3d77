"""The nozzle's point compared with a front: lower bound, available and remaining."""

from __future__ import annotations

import numpy as np

from tvclin.base.lines import Table, degrees, minimum_limit

Quantity = tuple[str, str, float, float | None]
"""Label, key, lower bound and available quantity [rad, rad/s]."""


def remaining(available: float | None, required: float) -> float | None:
    """Return what remains of an available quantity; None where it is not given."""
    return None if available is None else available - required


def lower_bound(name: str, deflection: float) -> str:
    """Return a lower bound [rad] of the limit in words."""
    if np.isinf(deflection):
        return f"{name}: no limit is sufficient"
    return f"{name}: {np.degrees(deflection):.3f} deg; a limit below it is never sufficient"


def point_table(title: str, *quantities: Quantity) -> Table:
    """Return the table of a nozzle's quantities, in degrees."""
    rows = []
    for label, key, required, available in quantities:
        margin = remaining(available, required)
        rows.append(
            (
                (label,),
                minimum_limit(degrees(f"nozzle.{key}.needed", required)),
                degrees(f"nozzle.{key}.there", np.nan if available is None else available),
                degrees(f"nozzle.{key}.left", np.nan if margin in (None, -np.inf) else margin),
            )
        )
    return Table(title, ("", "lower bound", "available", "remaining"), tuple(rows))
