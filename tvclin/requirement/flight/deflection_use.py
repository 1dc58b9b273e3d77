"""Required, used and remaining deflection by flight time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import table
from tvclin.base.columns import Column, Columns, Tabled
from tvclin.base.errors import (
    InputError,
    each,
    instance,
    number,
    numbers,
    positive,
    small_angle,
)
from tvclin.base.fields import spec
from tvclin.base.lines import Line, Table, degrees, significant
from tvclin.flights.closed_loop.fly_along import FlightAlong
from tvclin.requirement.flight.autopilot_along import AutopilotRequirements
from tvclin.requirement.flight.sizing import Sizing
from tvclin.requirement.required_quantity import heading_of


@dataclass(frozen=True, eq=False)
class DeflectionUse(Tabled):
    """Deflections by flight time: required, lower bounds, used by an autopilot, and remaining.

    Attributes
    ----------
    times : ndarray
        Flight times of the sizing [s], rising, ``(n,)``.
    required : dict of str to ndarray
        Requirements and lower bounds [rad] by their labels, the worst wind at each time, ``(n,)``;
        "autopilot" is that of the autopilot, for every limit above which it survives.
    used : ndarray
        Largest deflection [rad] of the flight from the middle between two times to the next,
        ``(n,)``; NaN where it does not fly.
    remaining : ndarray
        Available deflection [rad] minus the largest of these, ``(n,)``; NaN where one is not known.
    limit : float
        Available deflection [rad].
    reasons : tuple of str
        Reasons why autopilot requirements are not known; often none.
    """

    times: FloatArray = field(metadata=spec("time"))
    required: dict[str, FloatArray]
    used: FloatArray = field(metadata=spec("angle"))
    remaining: FloatArray = field(metadata=spec("angle"))
    limit: float = field(metadata=spec("angle"))
    reasons: tuple[str, ...] = field(default=(), metadata=spec())

    @property
    def by_heading(self) -> dict[str, FloatArray]:
        """Requirements, used and remaining deflection [rad] by their headings, ``(n,)``."""
        required = {heading_of(label): values for label, values in self.required.items()}
        return {**required, "used": self.used, "remaining": self.remaining}

    def table(self) -> Table:
        """Return the table of all times, in degrees."""
        values = self.by_heading
        rows: list[tuple[Line, ...]] = [
            (
                significant(f"use.{k}.time", time),
                *(degrees(f"use.{k}.{name}", column[k]) for name, column in values.items()),
            )
            for k, time in enumerate(self.times)
        ]
        return Table("Deflection by flight time, in deg", ("time [s]", *values), tuple(rows))

    def _repr_html_(self) -> str:
        return table(self.table())

    def _columns(self) -> Columns:
        columns = [
            Column(f"required_{label.replace(' ', '_')}", values, "rad")
            for label, values in self.required.items()
        ]
        columns += [Column(name, getattr(self, name), "rad") for name in ("used", "remaining")]
        return Columns((Column("time", self.times, "s"),), tuple(columns), {"limit": self.limit})


AUTOPILOT = "autopilot"
"""Label of the autopilot requirement."""


def deflection_use(
    sizing: Sizing,
    flown: FlightAlong | ArrayLike,
    limit: float,
    requirements: AutopilotRequirements | None = None,
    labels: Sequence[str] | None = None,
) -> DeflectionUse:
    """Return required, used and remaining deflection by flight time.

    Parameters
    ----------
    sizing : Sizing
        Requirements at two or more flight times.
    flown : FlightAlong or array_like
        Flight of an autopilot through the wind; or its largest deflection [rad] in the wind of each
        flight time, ``(n,)``, NaN where not known.
    limit : float
        Available deflection [rad], within 90 degrees.
    requirements : AutopilotRequirements, optional
        Autopilot requirements at the times of the sizing, with the label "autopilot".
    labels : sequence of str, optional
        Labels of the requirements and lower bounds of the sizing that count, by default all.

    Raises
    ------
    InputError
        For a sizing of one flight time, a limit out of range, unknown labels, and requirements or
        deflections at other times.
    """
    instance("sizing", sizing, Sizing, "see size")
    available = number("limit", limit, small_angle("a deflection", positive), "rad")
    if sizing.times.size < 2:
        raise InputError("deflections over the flight need two or more flight times; got 1")
    order = np.argsort(sizing.times)
    times = sizing.times[order]
    every = tuple(r.label for r in sizing.required)
    names = every if labels is None else each("labels", labels, str, "of sizing.required")
    required = {str(name): sizing.at_times(name)[order] for name in names}
    reasons: tuple[str, ...] = ()
    if requirements is not None:
        instance("requirements", requirements, AutopilotRequirements, "see autopilot_requirements")
        if not np.array_equal(requirements.times, sizing.times):
            raise InputError("requirements must be at the flight times of the sizing")
        required[AUTOPILOT], reasons = requirements.at_times[order], requirements.reasons
    if isinstance(flown, FlightAlong):
        used = used_around(flown, times)
    else:
        used = numbers("flown", flown)
        if used.shape != times.shape:
            raise InputError(
                f"flown must be a flight, see fly_along, or a deflection for each of the"
                f" {times.size} flight times; got shape {used.shape}"
            )
        used = used[order]
    largest = np.max([*required.values(), used], axis=0)  # NaN where one is not known
    return DeflectionUse(times, required, used, available - largest, available, reasons)


def used_around(flown: FlightAlong, times: FloatArray) -> FloatArray:
    """Return the largest deflection [rad] of a flight around each of rising flight times ``(n,)``.

    From the middle between two times to the next; NaN where the flight does not fly.
    """
    edges = np.concatenate([[-np.inf], 0.5 * (times[1:] + times[:-1]), [np.inf]])
    sizes = np.abs(flown.outputs["deflection"])
    inside = np.searchsorted(edges, flown.times, side="right") - 1
    used = np.array([sizes[inside == k].max(initial=-np.inf) for k in range(times.size)])
    within = (times >= flown.times[0]) & (times <= flown.times[-1])
    return np.where(within & np.isfinite(used), used, np.nan)
