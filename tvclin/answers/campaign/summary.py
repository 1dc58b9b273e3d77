"""What a campaign has found so far: which deflection covers it, what drives it, how sure it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tvclin.answers.campaign.batch import in_planes, required_name
from tvclin.answers.campaign.results import CampaignResults
from tvclin.answers.campaign.statistics import Quantile, Success, shares
from tvclin.answers.case import FROZEN
from tvclin.base.cards import Shown
from tvclin.base.documents import picked
from tvclin.base.lines import Line, Row, Table, degrees, number, quantities, significant
from tvclin.base.quantities import sufficiency, survival
from tvclin.vehicle.coefficients import BOTH

_MOST = 5
"""So many cases and drivers are shown."""
_SURE = 0.999


@dataclass(frozen=True, eq=False)
class CampaignSummary(Shown):
    """One output of a campaign, over all finished cases; make it with `of`.

    `output`: the angle in question. `limit`: the limit in question [rad]. `required`: what covers
    the probability asked for [rad]. `answers`: the output of the cases that have an answer [rad],
    ``(n,)``. `success`, `survival`, `loss`: how probable the limit is sufficient, a flight
    survives, and is lost.
    """

    found: CampaignResults
    output: str
    limit: float | None
    required: Quantile
    answers: np.ndarray[Any, np.dtype[np.float64]]
    success: Success | None
    survival: Success | None
    loss: Success | None

    _keys = "output median_deg required success survival"

    @classmethod
    def of(
        cls,
        found: CampaignResults,
        output: str | None = None,
        limit: float | None = None,
        probability: float | None = None,
        confidence: float | None = None,
    ) -> CampaignSummary:
        """Return the summary of an output; arguments and errors of `CampaignResults`."""
        return cls(
            found=found,
            required=found.quantile(output, probability, confidence),
            success=found.success(limit, output, confidence),
            survival=found.survival(confidence),
            loss=found.loss(confidence),
            output=output or found.angles[0],
            limit=found.campaign.nozzle.limit if limit is None else limit,
            answers=found.answers(output),
        )

    @property
    def trusts_a_forecast(self) -> bool:
        """Whether the output is a boundary with a dead band below one."""
        bands = {required_name(K): K for K in self.found.campaign.dead_bands}
        bands |= {of: K for name, K in bands.items() for of in in_planes(name).values()}
        return bands.get(self.output, 1.0) < 1.0

    @property
    def pressure(self) -> str:
        """Which dynamic pressure the output has, in words."""
        plan, required = self.found.campaign, self.output.startswith("required_")
        both = plan.planes == BOTH
        across = plan.plane != "pitch" and not both
        if across or plan.sign == FROZEN or not required:
            return "nominal"
        if both:
            return "in each wind"
        if plan.sign is not None:
            return f"in a {plan.sign} wind"
        return "in each wind" if plan.wind.count else "in a head or tail wind, the worse"

    @property
    def median(self) -> float:
        """The median of the answers [rad]."""
        return float(np.median(self.answers))

    @property
    def worst(self) -> dict[int, float]:
        """The cases that need the most [rad], the worst first."""
        cases = self.found.worst(_MOST, self.output).tolist()
        return dict(zip(cases, np.sort(self.answers)[::-1].tolist(), strict=False))

    def as_dict(self) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON, angles in degrees."""
        found, flights = self.found, self.found.flights
        nominal = found.nominal.get(self.output)
        return {
            **picked(found.campaign, "vehicle=vehicle.name model"),
            **picked(self, "output trusts_a_forecast"),
            **picked(found, "cases cases_planned=campaign.cases complete"),
            "statuses": found.statuses(),
            **picked(self.required, "probability confidence"),
            "nominal_deg": None if nominal is None else np.degrees(nominal),
            **picked(self, "median_deg"),
            **picked(self.required, "estimate_deg lower_deg upper_deg"),
            **picked(self, "limit_deg success survival"),
            "flights": flights and dict(zip(("survived", "lost"), flights, strict=True)),
            "loss": self.loss,
            "loss_drivers": found.loss_drivers(),
            "drivers": found.drivers(self.output),
            "worst": [{"case": k, "deg": np.degrees(v)} for k, v in self.worst.items()],
            "convergence": [
                picked(one, "cases lower_deg estimate_deg upper_deg")
                for one in found.convergence(self.output)
            ],
        }

    def tables(self) -> tuple[Table, Table]:
        """Return the answer with what drives it, and how it converges."""
        plan, r = self.found.campaign, self.required
        planes = f", both planes, {plan.nozzle.stop} stop" if plan.planes == BOTH else ""
        caption = f"{plan.vehicle.name}, {plan.model}{planes}: {self.output}"
        rows = tuple(
            (
                significant(f"convergence.{one.cases}", one.cases, 9),
                *(self._bound(f"convergence.{one.cases}.{k}", getattr(one, k)) for k in _BOUNDS),
            )
            for one in self.found.convergence(self.output)
        )
        converges = (
            f"Convergence of {100 * r.probability:g} %, each bound {100 * r.confidence:g} % sure"
        )
        head = ("cases", "not below", "sample", "not above")
        return quantities(caption, self._rows()), Table(converges, head, rows)

    def _rows(self) -> list[Row]:
        found, flights = self.found, self.found.flights
        of_cases, of_flights = shares(self.required.probability, self.required.confidence)
        done = f"{found.cases} of {found.campaign.cases}"
        rows: list[Row] = [("cases", (done if found.complete else f"{done}, unfinished",))]
        rows += [(f"  {k.split(';')[0]}", (str(count),)) for k, count in found.statuses().items()]
        if found.nominal:
            rows.append(("nominal", _angle("nominal", found.nominal[self.output])))
        rows += [
            ("median", _angle("median", self.median)),
            (of_cases, _angle("estimate", self.required.estimate)),
            (of_flights, self._bound("upper", self.required.upper)),
        ]
        limit = f"{np.degrees(self.limit or 0.0):.3f} deg is {sufficiency(True)} in"
        parts = {limit: self.success, survival(True): self.survival, survival(False): self.loss}
        rows += [(k, one.line(k)) for k, one in parts.items() if one is not None]
        if flights is not None:
            rows.append(
                ("flights", (f"{flights[0]} {survival(True)}, {flights[1]} {survival(False)}",))
            )
            rows.append(("loss is driven by", (self._driven(*flights),)))
        rows.append(("dynamic pressure", (self.pressure,)))
        if self.trusts_a_forecast:
            said = "trusts a forecast of the wind; K = 1 needs none"
            rows.append(("this dead band", (said,)))
        drivers = list(found.drivers(self.output).items())[:_MOST]
        worst = [_of(str(k), _angle(f"worst.{k}", one)) for k, one in self.worst.items()]
        driven = [_of(k, (*number(f"driver.{k}", one, 2),)) for k, one in drivers]
        return [*rows, ("driven by", _joined(driven)), ("worst cases", _joined(worst))]

    def _bound(self, name: str, angle: float) -> Line:
        """An angle; where flights are lost there may be no largest."""
        if not np.isinf(angle):
            return _angle(name, angle)
        flights = self.found.flights
        lost = self.output.startswith("flight_") and flights is not None and flights[1] > 0
        return (
            f"none, flights are {survival(False)}"
            if lost and angle > 0.0
            else "too few cases to say",
        )

    def _driven(self, survived: int, lost: int) -> str:
        """What drives the loss of flights, as far as the confidence asked for reaches."""
        if not lost or not survived:
            return "nothing: every flight is lost" if lost else "nothing: no flight is lost"
        known = {
            k: v for k, v in self.found.loss_drivers().items() if v.sure >= self.required.confidence
        }
        shown = [f"{k} ({v.rank:+.2f}, {_sure(v.sure)} sure)" for k, v in known.items()]
        return ", ".join(shown[:_MOST]) or "nothing that stands out from chance"


_BOUNDS = ("lower", "estimate", "upper")


def _angle(name: str, angle: float) -> Line:
    return ("lost",) if np.isinf(angle) else degrees(f"campaign.{name}", angle, unit="deg")


def _of(name: str, line: Line) -> Line:
    return (f"{name} (", *line, ")")


def _joined(lines: list[Line]) -> Line:
    return tuple(part for k, line in enumerate(lines) for part in ((", ",) if k else ()) + line)


def _sure(sure: float) -> str:
    return f"above {100 * _SURE:g} %" if sure > _SURE else f"{100 * sure:.1f} %"
