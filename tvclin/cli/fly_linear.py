"""`tvclin fly --engine linear`: a sampled law, with the nozzle's limits, rigid or flexible."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.answers.flexible import with_filters
from tvclin.answers.study_file.plan import StudyPlan
from tvclin.base.errors import InputError
from tvclin.base.quantities import NOMINAL, survival
from tvclin.cli.flight_cases import REPORT, Flying
from tvclin.cli.fly_shown import Compared, wind_line
from tvclin.cli.margin_tables import parts_line
from tvclin.control.laws.law import Law
from tvclin.flights.closed_loop.survival_limit import ClosedLoopBoundary, closed_loop_boundary
from tvclin.flights.theory_comparison import NOT_KNOWN, OUTCOME_WORDS, SampledFlight, fly_sampled
from tvclin.linear.flexible import AnyPlant

_SPARE, _HIGHEST = 1.1, 4.0
"""Of the limit over the boundary, and of the limits tried for that over the largest trim."""


@dataclass(frozen=True, eq=False)
class LinearCase(Flying):
    """What is flown in steps."""

    engine = "linear"

    @property
    def plant(self) -> AnyPlant:
        """What flies."""
        return self.case.plant

    @property
    def bends(self) -> bool:
        """Whether the vehicle is flexible."""
        return self.case.vehicle.structure is not None

    @cached_property
    def control(self) -> Law:
        """The law, with the filters that were asked for."""
        if self.law == REPORT:
            raise InputError(
                f"--law {REPORT} has no actuator and no samples: fly it by --engine planar or"
                " sixdof, or give --law trim"
            )
        chosen = self.designed(self.plant.rigid)
        assert isinstance(chosen, Law)
        return with_filters(chosen, self.case.asked)

    def boundary(self, plant: AnyPlant) -> ClosedLoopBoundary:
        """Return the boundary of the law on a plant."""
        hardware = self.case.hardware
        return closed_loop_boundary(plant, self.control, self.wind, highest=_HIGHEST, **hardware)

    @property
    def title(self) -> str:
        """The vehicle, the wind, and what flies, in lines."""
        structure = self.case.vehicle.structure
        servo, delay = self.case.nozzle.actuator, 1000.0 * self.case.asked.delay
        rate = self.case.hardware["sample_rate"]
        with_servo = f"{servo.natural_frequency:g} rad/s" if servo else "none"
        said = [
            wind_line(self),
            *([parts_line(structure)] if structure else []),
            f"linear equations, {self.plant.model}, {NOMINAL}; law at {rate:g} Hz,"
            f" delay {delay:g} ms, actuator {with_servo}",
        ]
        return "\n".join(said)


def law_with_a_stop(case: StudyPlan, name: str) -> Law:
    """Return the law of --law, whose flight takes the limit as the stop of the nozzle."""
    if case.nozzle.limit is None:
        raise InputError("--law needs --limit-deg, the stop of the nozzle")
    return LinearCase(case, "", name, None).control


def fly_linear(case: LinearCase, boundary: bool, times: Any) -> Compared:
    """Return the flight of a case; without a limit that has a tenth to spare."""
    least = None
    limit = case.case.nozzle.limit
    if limit is None or boundary:
        plants = (case.plant, case.plant.rigid) if case.bends else (case.plant,)
        least = tuple(case.boundary(plant) for plant in plants)
    if limit is None:
        assert least is not None
        limit = _SPARE * abs(least[0].deflection)
        if not np.isfinite(limit):
            raise InputError(f"{least[0].status}: give --limit-deg, or another law")
    flight = fly_sampled(
        case.plant, case.control, case.wind, times, deflection_limit=limit, **case.case.hardware
    )
    return _compared(case, limit, flight, least)


def _compared(
    case: LinearCase,
    limit: float,
    flight: SampledFlight,
    least: tuple[ClosedLoopBoundary, ...] | None,
) -> Compared:
    """A flight and its boundaries, where they were asked for, beside those of the rigid vehicle."""
    both, rates = ("flown", "rigid"), np.degrees(flight.peak_rates).tolist()
    rate = case.case.nozzle.rate_limit
    turning = "" if rate is None else f", rate limit {np.degrees(rate):.3f} deg/s"
    return Compared(
        case=case,
        flight=flight,
        limit=limit,
        beside="rigid",
        columns=("flexible", "rigid") if case.bends else ("flown",),
        boundary=(abs(least[0].deflection), abs(least[-1].deflection)) if least else None,
        heads=[case.title],
        ends=list(_ends(case, flight, least or ())),
        title=f"Limit {np.degrees(limit):.3f} deg{turning}",
        facts={
            "flexible": case.bends,
            "linear_model": case.plant.model,
            "sample_rate_Hz": case.case.hardware["sample_rate"],
            "rate_limit_deg_per_s": None if rate is None else float(np.degrees(rate)),
            "delay_s": case.case.asked.delay,
            "status": dict(zip(both, flight.status, strict=True)),
            "peak_deflection_rate_deg_s": dict(zip(both, rates, strict=True)),
        },
    )


def _ends(
    case: LinearCase, flight: SampledFlight, least: Iterable[ClosedLoopBoundary]
) -> Iterator[str]:
    """Whether the flights survive, and what is odd about their boundaries."""
    flown, rigid = map(_word, flight.status)
    yield f"Flown {NOMINAL}: {flown}." + (f" Rigid: {rigid}." if case.bends else "")
    if "rings" in flight.status:
        yield RINGS_MEANS
    for name, one in zip(("flexible", "rigid")[not case.bends :], least, strict=False):
        if one.status != "ok":
            yield f"Note: boundary, {name}: {one.status}"


RINGS_MEANS = (
    "It rings: the vehicle is brought back, and the nozzle keeps oscillating: an oscillation of the"
    " loop, mostly of bending or slosh, grows near rest or persists between the limits."
)


def _word(status: str) -> str:
    if status == NOT_KNOWN:
        return survival(None)
    fate = {"survived": "", "lost": "", "rings": ", it rings"}.get(
        status, f", it {OUTCOME_WORDS[status]}"
    )
    return f"{survival(status == 'survived')}{fate}"
