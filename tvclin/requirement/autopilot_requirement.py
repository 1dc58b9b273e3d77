"""Autopilot requirement: the smallest limit from which on an autopilot survives a wind, flown.

It is flown as it is modelled, with samples, delay, actuator, filters, bending and rate limit: at
nominal dynamic pressure and, where a head wind sets the required deflection, also at the pressure
of its peak, constant throughout, which is an upper bound of what it encounters. In a measured wind
it is also flown at the largest pressure of that, where it is above the nominal one.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TypeVar

from tvclin.base.errors import InputError
from tvclin.case.case import Case
from tvclin.case.flexible_autopilot import stop_boundary
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.laws.autopilot_law import SaturatedLaw
from tvclin.flights.closed_loop.survival_limit import ClosedLoopBoundary
from tvclin.linear.flexible import AnyPlant
from tvclin.requirement.case_requirement import CaseRequirement
from tvclin.requirement.encountered_requirement import largest_measured_pressure, largest_pressure
from tvclin.requirement.nominal_requirement import covers
from tvclin.vehicle.linear_vehicle import complete_vehicle
from tvclin.vehicle.vehicle import Vehicle, at_pressure
from tvclin.winds.shaped import ShapedWind

AnyCase = TypeVar("AnyCase", bound=Case)


@dataclass(frozen=True, eq=False)
class AutopilotRequirement:
    """The autopilot requirement of a case.

    Attributes
    ----------
    nominal : ClosedLoopBoundary
        Boundary of the autopilot at nominal dynamic pressure.
    head : ClosedLoopBoundary or None
        Boundary at the dynamic pressure at the peak of a head wind, or the largest of a measured
        wind; None where that does not count.
    head_counts : bool
        Whether a head wind sets the required deflection, or a measured wind raises the pressure;
        without `head` no limit is known then.
    plane_ratio : float
        Limit of both planes over the part that this plane has.
    """

    nominal: ClosedLoopBoundary
    head: ClosedLoopBoundary | None
    head_counts: bool
    plane_ratio: float = 1.0

    @property
    def nominal_deflection(self) -> float:
        """The autopilot requirement [rad] at nominal dynamic pressure, a size.

        As the limit of both planes, which is the limit in this plane times `plane_ratio`.
        """
        return abs(float(self.nominal.deflection)) * self.plane_ratio

    @property
    def deflection(self) -> float:
        """The autopilot requirement [rad], a size; infinite if it survives at no limit tried.

        As the limit of both planes, which is the limit in this plane times `plane_ratio`.
        """
        if self.head is None:
            return self.nominal_deflection
        return abs(float(self.head.deflection)) * self.plane_ratio

    def sufficient(self, limit: float) -> bool | None:
        """Return whether a limit [rad] is sufficient; None if that is not known.

        It is not known where the dynamic pressure in the wind counts (`head_counts`), for a limit
        that covers the requirement at nominal pressure, but not that at the pressure in the wind.
        """
        sufficient_nominal = bool(covers(limit, self.nominal_deflection))
        if sufficient_nominal and self.head_counts:
            return True if self.head is not None and covers(limit, self.deflection) else None
        return sufficient_nominal


def autopilot_requirement(
    case: Case, plant: AnyPlant, autopilot: Autopilot, need: CaseRequirement | None
) -> AutopilotRequirement:
    """Return the smallest deflection limits with which an autopilot survives, in one plane.

    `nominal` at nominal dynamic pressure; `head` at the pressure in the wind, where it counts.
    `plant` and `autopilot` are what flies; `need` is the required deflection without an autopilot,
    None where the case has none, as in a measured wind. `InputError` for a law or hardware that
    cannot be flown, in the same cases as `closed_loop_boundary`.
    """
    nominal = autopilot_boundary(case, plant, autopilot)
    denser, counts = at_largest_pressure(case, need)
    head = None
    if denser is not None:
        with suppress(InputError):  # a plant that is not defined at that pressure
            head = autopilot_boundary(denser, denser.plant, autopilot)
    return AutopilotRequirement(nominal=nominal, head=head, head_counts=counts)


def counts_head(need: CaseRequirement) -> bool:
    """Return whether a head wind sets the required deflection `need`, or may set it."""
    return need.ratio_to_nominal > 1.0 or bool(need.unknown)


def at_largest_pressure(case: AnyCase, need: CaseRequirement | None) -> tuple[AnyCase | None, bool]:
    """Return a case at the largest dynamic pressure in its wind, and whether that pressure counts.

    It is constant throughout, an upper bound of what a flight encounters. It counts where a head
    wind sets the requirement `need`, where a measured wind, of which `need` is None, raises the
    pressure above the nominal one, and where either is not known. The case is None where the
    pressure does not count, and where it is not known.
    """
    if need is None and isinstance(case.wind, ShapedWind):
        return None, False
    if need is not None and not counts_head(need):
        return None, False
    with suppress(InputError):  # the dynamic pressure in the wind is not known
        if need is not None:
            return at_peak_pressure(case, need), True
        ratio = largest_measured_pressure(case)  # over the nominal pressure
        if ratio <= 1.0:
            return None, False
        return replace(case, vehicle=at_pressure(_complete_vehicle(case), ratio)), True
    return None, True


def autopilot_boundary(
    case: Case, plant: AnyPlant, autopilot: Autopilot, plane_ratio: float = 1.0
) -> ClosedLoopBoundary:
    """Return the boundary of an autopilot, flown with the hardware and the wind of a case.

    `plant`: vehicle to be flown. `plane_ratio`: limit of both planes over the limit of this plane,
    by which the limit of the nozzle, up to which limits are tried, is divided.
    """
    highest_limit = (case.nozzle.limit or 0.0) / plane_ratio  # [rad]
    law = SaturatedLaw.of(autopilot)
    return stop_boundary(plant, law, case.history, highest_limit, case.hardware)


def at_peak_pressure(case: AnyCase, need: CaseRequirement, size: float = 1.0) -> AnyCase:
    """Return a case with its vehicle at the largest dynamic pressure encountered in its wind.

    `need`: requirement of the case, with the plane and direction of the wind that counts, and with
    the wind with its gust `placed` at the worst time for its dead band K. An autopilot is flown
    with the gust of `case.wind_in_plane`, at the worst time for K = 1: the pressure must be that of
    this wind. `size`: factor on the wind. `InputError` for a plant in state space, known at nominal
    pressure alone, and where `need` does not know the pressure encountered.
    """
    vehicle = _complete_vehicle(case)
    if need.unknown:  # a text with the reason
        raise InputError(need.unknown)
    in_plane = case.wind_in_plane
    assert isinstance(in_plane, ShapedWind)
    wind = replace(need.placed, gust_at=in_plane.gust_at)
    ratio = largest_pressure(wind, vehicle.rigid, need.plane, need.direction, size)
    return replace(case, vehicle=at_pressure(vehicle, ratio))


def _complete_vehicle(case: Case) -> Vehicle:
    """Return the vehicle of a case, with all forces, to be taken at another dynamic pressure.

    `InputError` for a vehicle of coefficients or a plant in state space, known at the nominal one.
    """
    if case.plant_system is not None:
        raise InputError("a plant in state space is known at nominal dynamic pressure alone")
    return complete_vehicle(case.vehicle, "a head wind")
