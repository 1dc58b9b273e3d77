"""Choices of the panel: a case, and the law that is flown."""

from dataclasses import dataclass, replace
from typing import Any

from tvclin.case.nozzle import Nozzle
from tvclin.control.autopilot.design_rules import AutopilotDesign
from tvclin.control.laws.registry import AUTOPILOT, DEAD_BAND, LAWS
from tvclin.requirement.case_requirement import pulse_of
from tvclin.studyfile.study_plan import StudyPlan
from tvclin.winds.shaped import ShapedWind

REPORT, TRIM = "report (open loop)", "trim"
CONTROLS = (REPORT, *LAWS)


@dataclass(frozen=True, kw_only=True)
class Choices:
    """A case as a study file has it, with a limit, and its control: one of `CONTROLS`."""

    plan: StudyPlan
    law: str = TRIM

    @property
    def wind(self) -> ShapedWind:
        """The wind, with its gust and its direction."""
        return pulse_of(self.plan)

    @property
    def limit(self) -> float:
        """The deflection limit [rad]."""
        assert self.plan.nozzle.limit is not None  # a slider has it
        return self.plan.nozzle.limit

    @property
    def of_margins(self) -> StudyPlan:
        """Plan of the values on which the margins of the autopilot depend."""
        p = self.plan
        return _bare(p, vehicle=p.vehicle, nozzle=Nozzle(actuator=p.nozzle.actuator))

    @property
    def of_need(self) -> StudyPlan:
        """Plan of the values on which the required deflection depends."""
        p = self.plan
        inputs = {"wind": p.wind, "nozzle": Nozzle(stop=p.nozzle.stop), "design": None}
        return _bare(p, dead_band=p.dead_band, sign=p.sign, **inputs)

    @property
    def of_gust(self) -> StudyPlan:
        """Plan of the values on which the time of a gust in the response depends."""
        p = self.plan
        K = p.dead_band if self.law == REPORT else 1.0
        return _bare(p, wind=p.wind, dead_band=K, design=None)

    @property
    def of_motion(self) -> StudyPlan:
        """Plan of the values on which response or flight depend, except the time of the gust."""
        p, flown = self.plan, self.law != REPORT
        hardware = replace(p.nozzle, stop=None) if flown else Nozzle(limit=p.nozzle.limit)
        design = p.design if self.law == AUTOPILOT else loop_of(p.asked)
        return _bare(
            p,
            vehicle=p.vehicle if flown else p.vehicle.rigid,
            wind=p.wind,
            nozzle=hardware,
            design=design if flown else None,
            dead_band=p.dead_band if self.law in (REPORT, DEAD_BAND) else 1.0,
        )


def _bare(plan: StudyPlan, **fields: Any) -> StudyPlan:
    """Return a plan of the same rigid motion and autopilot, with defaults otherwise."""
    values: dict[str, Any] = {"vehicle": plan.vehicle.rigid, "design": plan.design} | fields
    return StudyPlan(model=plan.model, plane=plan.plane, **values)


def loop_of(design: AutopilotDesign) -> AutopilotDesign:
    """Return the delay, the samples and the filters of an autopilot, without its gains."""
    chains: Any = design.chains
    return AutopilotDesign(delay=design.delay, sample_rate=design.sample_rate, **chains)
