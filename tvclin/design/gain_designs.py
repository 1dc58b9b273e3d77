"""Minimum deflection over the required disk margin, gains over a flight, and gains of a case."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.cards import Shown
from tvclin.base.errors import InputError, instance, one_row, positive, times_row
from tvclin.base.fields import spec
from tvclin.base.quantities import WIND_KNOWN
from tvclin.boundary.limit import boundary_limit
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.design_rules import GIVEN_GAINS, LEAST_NOZZLE
from tvclin.control.autopilot.feedback import GAINS
from tvclin.control.autopilot.gain_schedule import GainSchedule
from tvclin.control.margins.criteria import Criteria
from tvclin.design.minimum_gains import MinimumGains, minimum_deflection_gains, solve_problem
from tvclin.linear.plant import PLANT_HINT, Plant
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from tvclin.case.case import Case


def specified_autopilot(case: Case, wind: History, criteria: Criteria) -> Autopilot:
    """Return the autopilot of a case: by its rule, or for the minimum deflection in a wind.

    `criteria`: required margins of gains for the minimum deflection.
    """
    if case.autopilot_design.design != LEAST_NOZZLE:
        return case.autopilot
    return minimum_gains(case, wind, criteria).autopilot


def minimum_gains(
    case: Case, winds: History | Sequence[History], criteria: Criteria, **options: Any
) -> MinimumGains:
    """Return the gains for the minimum deflection with nozzle, delay and filters of a case.

    `winds`: one wind or several. `criteria`: required margins. `options`: further arguments of
    `minimum_deflection_gains`, whose exceptions apply. `InputError` for gains and numbers of other
    rules in the same design. `minimum` of the design is the minimised deflection: the peak of the
    linear loop, or the "limit" with which flights survive, also `sudden_ends` of each wind.
    """
    design = case.autopilot_design
    chains: dict[str, Any] = design.chains
    conflicting = [
        name
        for name in ("natural_frequency", "damping", *GAINS)
        if getattr(design, name) not in (None, 0.0)
    ]
    if conflicting:
        raise InputError(
            "gains for the minimum deflection are sought: give no"
            f" {', '.join(name.replace('_', ' ') for name in conflicting)} with them"
        )
    if design.sudden_ends and design.minimum != "limit":
        raise InputError('sudden_ends needs minimum = "limit" in [autopilot]')
    return minimum_deflection_gains(
        case.plant,
        winds,
        criteria=criteria,
        actuator=case.nozzle.actuator,
        delay=design.delay,
        crossover=design.crossover,
        sample_rate=design.sample_rate,
        limits=design.minimum == "limit",
        stops=design.sudden_ends,
        **chains,
        **options,
    )


DEAD_BANDS = (1.0, 0.5)
"""Dead bands K of the boundaries that are shown."""


@dataclass(frozen=True, eq=False)
class GainTradeOff(Shown):
    """Minimum deflection over the required disk margin, with the limits of the theory.

    Attributes
    ----------
    disk_margin : ndarray
        Required disk margins, rising, ``(n,)``.
    relative : ndarray
        Minimum deflection with each disk margin, normalised by the largest trim, ``(n,)``; infinite
        where no gains have the margin.
    designs : tuple of MinimumGains or None
        Gains for each disk margin; None where no gains have it.
    limits : dict of str to float
        Boundaries of the report and minimum of appendix C in the worst wind, normalised by the
        largest trim.
    """

    disk_margin: FloatArray = field(metadata=spec())
    relative: FloatArray = field(metadata=spec(label="over trim"))
    designs: tuple[MinimumGains | None, ...]
    limits: dict[str, float] = field(metadata=spec())

    @property
    def gains(self) -> tuple[str, ...]:
        """Names of the free gains, "attitude", "rate" and perhaps "alpha", of all designs."""
        return next(tuple(design.problem.gains) for design in self.designs if design is not None)

    @property
    def meaning(self) -> str:
        """Meaning of the deflection, "peak" or "boundary", of any of the designs.

        The largest deflection of the linear loop, or the minimum limit with which flights survive.
        """
        return next(design.meaning for design in self.designs if design is not None)


def gain_trade_off(
    gains: MinimumGains, disk_margin: ArrayLike = (0.4, 0.6, 0.8, 1.0, 1.2)
) -> GainTradeOff:
    """Return the minimum deflection of gains over the required disk margin.

    Parameters
    ----------
    gains : MinimumGains
        Gains for the minimum deflection; all their other specifications are kept.
    disk_margin : array_like
        Disk margins, rising, ``(n,)``.

    Returns
    -------
    GainTradeOff
        Minimum deflection and gains by disk margin, with the limits of the theory. The search at
        each disk margin begins near the gains of the previous disk margin.

    Raises
    ------
    InputError
        For disk margins that are not positive and rising, and when no gains have the smallest.

    Examples
    --------
    >>> import tvclin as tv
    >>> plant = tv.Plant.from_vehicle(tv.load_vehicle("configuration-i"))
    >>> wind = tv.TriangularWind(peak=0.05, duration=7.5)
    >>> gains = tv.minimum_deflection_gains(plant, wind, actuator=tv.Actuator(), delay=0.02)
    >>> tv.design.gain_trade_off(gains, [0.8, 1.2]).relative.round(2)
    array([1.03, 1.1 ])
    """
    instance("gains", gains, MinimumGains, "see minimum_deflection_gains")
    margins = positive("disk_margin", one_row("disk_margin", disk_margin))
    if not margins.size or np.any(np.diff(margins) <= 0.0):
        raise InputError("disk_margin must be one or more rising numbers")
    problem, start = gains.problem, gains.problem.point(gains.autopilot)
    designs: list[MinimumGains | None] = []
    for margin in margins.tolist():
        criteria = problem.criteria.with_limits("the front", disk_margin=margin)
        try:
            design = solve_problem(replace(problem, criteria=criteria), start[np.newaxis])
        except InputError:
            if not designs:
                raise
            break  # no gains have this disk margin, nor a larger one
        designs.append(design)
        start = problem.point(design.autopilot)
    designs += [None] * (margins.size - len(designs))
    trim = problem.trims.max()  # largest trim [rad] of the winds, without drift
    relative = [np.inf if design is None else design.deflection / trim for design in designs]
    plant, limits = problem.plant.rigid, {}
    for K in DEAD_BANDS:
        values: Any = [boundary_limit(plant, wind, K).deflection for wind in problem.winds]
        limits[f"boundary, K = {K:g}"] = float(np.max(np.abs(values)) / trim)
    peaks = [float(optimum_deflection(plant, wind).peak) for wind in problem.winds]
    limits[WIND_KNOWN] = max(peaks) / trim
    return GainTradeOff(margins, np.array(relative), tuple(designs), limits)


@dataclass(frozen=True, eq=False)
class MinimumGainSchedule:
    """Gains for the minimum deflection at several flight times.

    Attributes
    ----------
    schedule : GainSchedule
        The gains, straight lines between the times.
    designs : tuple of MinimumGains
        Gains for the minimum deflection at each time.
    """

    schedule: GainSchedule
    designs: tuple[MinimumGains, ...]

    @property
    def deflection(self) -> float:
        """Largest deflection of all times [rad], which the flight requires of the nozzle."""
        return max(gains.deflection for gains in self.designs)


def minimum_gain_schedule(
    time: ArrayLike, plants: Plant, winds: History | Sequence[History], **options: Any
) -> MinimumGainSchedule:
    """Return the gains for the minimum deflection at each time of a flight.

    Parameters
    ----------
    time : array_like
        Flight times [s], rising, ``(n,)``.
    plants : Plant
        Plant at each time, ``(n,)``.
    winds, **options
        Winds that may occur at any time; criteria, nozzle and other arguments of
        `minimum_deflection_gains`.

    Raises
    ------
    InputError
        For times that do not rise, another number of plants, and what `minimum_deflection_gains`
        refuses.

    Examples
    --------
    >>> import tvclin as tv
    >>> c = tv.Coefficients(mu_alpha=[0.1, 0.28], mu_delta=[2.0, 2.6])
    >>> wind = tv.TriangularWind(peak=0.05, duration=7.5)
    >>> schedule = tv.design.minimum_gain_schedule(
    ...     [40.0, 66.0], tv.Plant.from_coefficients(c), wind, actuator=tv.Actuator(), crossover=2.0
    ... )
    >>> [round(gains.relative, 2) for gains in schedule.designs]
    [1.03, 1.14]
    """
    instance("plants", plants, Plant, PLANT_HINT)
    times = times_row("time", time)
    if plants.batch != times.shape:
        raise InputError(
            f"plants must be one for each of the {times.size} times; got a batch of shape"
            f" {plants.batch}"
        )
    designs = tuple(
        minimum_deflection_gains(plants.case(k, plants.batch), winds, **options)
        for k in range(times.size)
    )
    gains: dict[str, Any] = {
        name: np.array([getattr(design.autopilot, name) for design in designs])
        for name in GIVEN_GAINS
    }
    autopilot = replace(designs[0].autopilot, **gains)
    return MinimumGainSchedule(GainSchedule(times, autopilot), designs)
