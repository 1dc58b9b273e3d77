"""`tvclin fly --engine linear`: a sampled law, with the nozzle's limits, rigid or flexible."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.base.errors import InputError
from tvclin.base.quantities import NOMINAL, survival
from tvclin.case.flexible_autopilot import with_filters
from tvclin.cli.flight_cases import (
    LIMIT_OVER_BOUNDARY,
    MAX_LIMIT_OVER_TRIM,
    REPORT,
    Compared,
    Flying,
    wind_line,
)
from tvclin.cli.margin_tables import parts_line
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.survival_limit import ClosedLoopBoundary, closed_loop_boundary
from tvclin.flights.theory_comparison import NOT_KNOWN, OUTCOME_WORDS, SampledFlight, fly_sampled
from tvclin.linear.flexible import AnyPlant
from tvclin.studyfile.study_plan import StudyPlan

LINEAR = "linear"
"""Name of the engine."""


@dataclass(frozen=True, eq=False)
class LinearCase(Flying):
    """A flight by the linear engine, in steps."""

    engine = LINEAR

    @property
    def plant(self) -> AnyPlant:
        """The plant that is flown."""
        return self.case.plant

    @property
    def bends(self) -> bool:
        """Whether the vehicle is flexible."""
        return self.case.vehicle.structure is not None

    @cached_property
    def control(self) -> Law:
        """The law, with the filters of the case."""
        if self.law == REPORT:
            raise InputError(
                f"--law {REPORT} has no actuator and no samples: fly it by --engine planar or"
                " sixdof, or give --law trim"
            )
        chosen = self.designed(self.plant.rigid)
        assert isinstance(chosen, Law)
        return with_filters(chosen, self.case.autopilot_design)

    def boundary(self, plant: AnyPlant) -> ClosedLoopBoundary:
        """Return the boundary of the law on a plant."""
        hardware = self.case.hardware
        return closed_loop_boundary(
            plant, self.control, self.wind, highest=MAX_LIMIT_OVER_TRIM, **hardware
        )

    @property
    def title(self) -> str:
        """Lines on the vehicle, the wind, the equations and the law."""
        structure = self.case.vehicle.structure
        servo, delay = self.case.nozzle.actuator, 1000.0 * self.case.autopilot_design.delay
        rate = self.case.hardware["sample_rate"]
        with_servo = f"{servo.natural_frequency:g} rad/s" if servo else "none"
        said = [
            wind_line(self),
            *([parts_line(structure)] if structure else []),
            f"linear equations, {self.plant.model}, {NOMINAL}; law at {rate:g} Hz,"
            f" delay {delay:g} ms, actuator {with_servo}",
        ]
        return "\n".join(said)


def limited_law(case: StudyPlan, name: str) -> Law:
    """Return the law of --law, whose flight keeps to the deflection limit."""
    if case.nozzle.limit is None:
        raise InputError("--law needs --limit-deg, the deflection limit of the nozzle")
    return LinearCase(case, "", name, None).control


def fly_linear(case: LinearCase, boundary: bool, times: Any) -> Compared:
    """Return the flight of a case; the default limit is 1.1 times the boundary."""
    boundaries = None
    limit = case.case.nozzle.limit
    if limit is None or boundary:
        plants = (case.plant, case.plant.rigid) if case.bends else (case.plant,)
        boundaries = tuple(case.boundary(plant) for plant in plants)
    if limit is None:
        assert boundaries is not None
        limit = LIMIT_OVER_BOUNDARY * abs(boundaries[0].deflection)
        if not np.isfinite(limit):
            raise InputError(f"{boundaries[0].status}: give --limit-deg, or another law")
    flight = fly_sampled(
        case.plant, case.control, case.wind, times, deflection_limit=limit, **case.case.hardware
    )
    return _compared(case, limit, flight, boundaries)


def _compared(
    case: LinearCase,
    limit: float,
    flight: SampledFlight,
    boundaries: tuple[ClosedLoopBoundary, ...] | None,
) -> Compared:
    """Return a flight and its boundaries, if any, compared with those of the rigid vehicle."""
    labels, rates = ("flown", "rigid"), np.degrees(flight.peak_rates).tolist()
    rate = case.case.nozzle.rate_limit
    rigid = f"; rigid: {_word(flight.status[1])}" if case.bends else ""
    turning = "" if rate is None else f", rate limit {np.degrees(rate):.3f} deg/s"
    return Compared(
        case=case,
        flight=flight,
        limit=limit,
        reference="rigid",
        columns=("flexible", "rigid") if case.bends else ("flown",),
        boundary=(abs(boundaries[0].deflection), abs(boundaries[-1].deflection))
        if boundaries
        else None,
        heads=[case.title],
        verdict=f"{_word(flight.status[0])} with {np.degrees(limit):.3f} deg {NOMINAL}{rigid}",
        flight_notes=tuple(_flight_notes(case, flight, boundaries or ())),
        title=(
            f"{wind_line(case)}; {case.plant.model}, limit {np.degrees(limit):.3f} deg{turning}"
        ).replace("\n", ": "),
        facts={
            "flexible": case.bends,
            "linear_model": case.plant.model,
            "sample_rate_Hz": case.case.hardware["sample_rate"],
            "rate_limit_deg_per_s": None if rate is None else float(np.degrees(rate)),
            "delay_s": case.case.autopilot_design.delay,
            "status": dict(zip(labels, flight.status, strict=True)),
            "peak_deflection_rate_deg_s": dict(zip(labels, rates, strict=True)),
        },
    )


def _flight_notes(
    case: LinearCase, flight: SampledFlight, boundaries: Iterable[ClosedLoopBoundary]
) -> Iterator[str]:
    """Yield notes on an oscillation of the nozzle, and on boundaries."""
    if "rings" in flight.status:
        yield RINGS_MEANS
    for name, boundary in zip(("flexible", "rigid")[not case.bends :], boundaries, strict=False):
        if boundary.status != "ok":
            yield f"boundary, {name}: {boundary.status}"


RINGS_MEANS = (
    "it rings: the vehicle is brought back, and the nozzle keeps oscillating: an oscillation of the"
    " loop, mostly of bending or slosh, grows near rest or persists between the limits"
)


def _word(status: str) -> str:
    """Return the outcome of a flight in words."""
    if status == NOT_KNOWN:
        return survival(None)
    fate = {"survived": "", "lost": "", "rings": ", it rings"}.get(
        status, f", it {OUTCOME_WORDS[status]}"
    )
    return f"{survival(status == 'survived')}{fate}"
