"""Summary of a campaign: the deflection that covers it, its drivers, and its confidence."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tvclin.base.arrays import BoolArray, FloatArray
from tvclin.base.cards import Shown
from tvclin.base.fields import derived, document, spec
from tvclin.base.lines import (
    Line,
    Row,
    Table,
    degrees,
    number,
    plural,
    quantities,
    significant,
    text,
)
from tvclin.base.quantities import REQUIRED as REQUIRED_DEFLECTION
from tvclin.base.quantities import sufficiency, survival
from tvclin.ensembles.campaign.cases import NOT_KNOWN
from tvclin.ensembles.campaign.outputs import REQUIRED, column_label, plane_columns, required_name
from tvclin.ensembles.campaign.results import CampaignResults
from tvclin.ensembles.statistics import Quantile, Success, covers_quantile, shares
from tvclin.requirement.case_requirement import study_requirement
from tvclin.vehicle.coefficients import BOTH
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_angles import FROZEN

_MAX_SHOWN = 5
"""Largest number of cases and of drivers that are shown."""
_MAX_SHOWN_CONFIDENCE = 0.999
"""Largest confidence that is shown as a number; a higher one is "above 99.9 %"."""


@dataclass(frozen=True, eq=False)
class CampaignSummary(Shown):
    """Statistics of an output of a campaign, over all finished cases; make it with `of`.

    `results`: the results. `output`: name of the angle. `limit`: deflection limit [rad].
    `required`: quantile of the output [rad] at the specified probability. `answers`: the output of
    the cases that have an answer [rad], ``(n,)``. `unknown`: whether it is not known, and counts as
    infinite, ``(n,)``. `success`, `survival`, `loss`: probabilities that
    the limit is sufficient, that a flight survives, and that it is lost.
    """

    results: CampaignResults
    output: str = field(metadata=spec())
    limit: float | None = field(metadata=spec("angle", card=False))
    required: Quantile = field(metadata=spec())
    answers: FloatArray
    unknown: BoolArray
    success: Success | None = field(metadata=spec())
    survival: Success | None = field(metadata=spec())
    loss: Success | None

    @classmethod
    def of(
        cls,
        results: CampaignResults,
        output: str | None = None,
        limit: float | None = None,
        probability: float | None = None,
        confidence: float | None = None,
    ) -> CampaignSummary:
        """Return the summary of an output over the finished cases of `results`.

        `output`: name of an angle, by default the first. `limit`: deflection limit [rad], and
        `probability`, `confidence`: of its quantile; by default the campaign's. Same exceptions as
        `CampaignResults.quantile` and `success`.
        """
        required = results.quantile(output, probability, confidence)
        name = output or results.angles[0]
        has_answer = ~np.isnan(results.column(name))
        return cls(
            results=results,
            required=required,
            success=results.success(limit, output, confidence),
            survival=results.survival(confidence),
            loss=results.loss(confidence),
            output=name,
            limit=results.campaign.nozzle.limit if limit is None else limit,
            answers=results.answers(output),
            unknown=np.isin(results.column("status")[has_answer].astype(str), NOT_KNOWN),
        )

    @property
    def sufficient(self) -> bool | None:
        """Whether the limit covers the quantile with its confidence; None where not known."""
        if self.limit is None or self.success is None:
            return None
        level = self.required.probability, self.required.confidence
        return covers_quantile(self.limit, self.answers, self.unknown, *level)

    @property
    def _why_unknown(self) -> str:
        """Reason why the requirement of cases is not known, in words; empty if it is known.

        It begins with the reason that holds for the nominal vehicle, if there is one.
        """
        count = int(np.sum(self.unknown))
        if not count:
            return ""
        campaign = self.results.campaign
        nominal = study_requirement(campaign)
        of_nominal = campaign.unknown_wind or ("" if nominal is None else nominal.unknown)
        of_cases = f"in {count} of {self.unknown.size} cases the requirement is not known"
        return "; ".join(filter(None, (of_nominal, of_cases)))

    @property
    def verdict(self) -> str:
        """Whether the limit is sufficient, and the covering deflection with its confidence.

        `required` is the quantile at a probability, with an `estimate` and, for a confidence, an
        `upper` bound, infinite with too few cases; then the upper bound of `success`, the
        probability that the limit is sufficient, may still say no. `unknown` has all cases.
        """
        r = self.required
        kind = REQUIRED_DEFLECTION if REQUIRED in self.output else column_label(self.output)
        share = f"{100 * r.probability:g} % of flights, with {100 * r.confidence:g} % confidence"
        of = f"{kind} of {plural(self.unknown.size, 'case')}"
        angle = text(self._bound("verdict", r.upper))
        words = f"{angle} covers {share}" if np.isfinite(r.upper) else f"{angle} ({share})"
        if self.limit is None or self.success is None:
            return f"{of}: {words}"
        if self.sufficient is None:
            words = self._why_unknown or words
        few_cases = np.isfinite(r.estimate) and not np.isfinite(r.upper)  # for an upper bound
        if self.sufficient is False and few_cases:
            most = f"{100 * self.success.upper:.4g} %"
            words = f"sufficient in at most {most} of flights, not in {100 * r.probability:g} %"
        limit = f"limit {np.degrees(self.limit):.3f} deg: {sufficiency(self.sufficient)}"
        return f"{limit}; {of}: {words}"

    @property
    @derived("part")
    def increase(self) -> float | None:
        """Relative increase of the nominal output by dispersions, 0.3 for 30 percent, or None.

        The output with dispersions is the upper confidence bound of its quantile. None if one of
        both is not known, or the nominal output is zero.
        """
        nominal, dispersed = self.results.nominal.get(self.output), self.required.upper
        comparable = nominal and np.isfinite(nominal) and np.isfinite(dispersed)
        return dispersed / nominal - 1.0 if nominal and comparable else None

    @property
    def trusts_a_forecast(self) -> bool:
        """Whether the output is a boundary with a dead band K < 1, for which the wind is known."""
        bands = {required_name(K): K for K in self.results.campaign.dead_bands}
        bands |= {k: K for name, K in bands.items() for k in plane_columns(name).values()}
        return bands.get(self.output, 1.0) < 1.0

    @property
    def pressure(self) -> str:
        """The dynamic pressure at which the output is computed, in words: nominal or encountered.

        A requirement is at the encountered one, and so is each output along a whole flight
        (`along`); a wind across the path alone, at a single time, is at the nominal one. `sign`:
        head or tail, `FROZEN` for the nominal pressure, None for the worse of both.
        """
        plan = self.results.campaign
        encountered = self.output.startswith(REQUIRED) or plan.along is not None
        both_planes = plan.planes == BOTH
        across = plan.plane != "pitch" and not both_planes
        if plan.sign == FROZEN or not encountered or (across and plan.along is None):
            return "nominal"
        if both_planes or across:
            return "in each wind"
        if plan.sign is not None:
            return f"in a {plan.sign} wind"
        return (
            "in each wind"
            if not isinstance(plan.wind, ShapedWind)
            else "in a head or tail wind, the worse"
        )

    @property
    @derived("angle")
    def median(self) -> float:
        """The median of the answers [rad]."""
        return float(np.median(self.answers))

    @property
    def worst(self) -> dict[int, float]:
        """The largest answers [rad] by index of the case, the worst first."""
        cases = self.results.worst(_MAX_SHOWN, self.output).tolist()
        return dict(zip(cases, np.sort(self.answers)[::-1].tolist(), strict=False))

    @property
    def convergence(self) -> tuple[Quantile, ...]:
        """The quantiles of the first parts of the cases, at the probability of `required`."""
        r = self.required
        return self.results.convergence(self.output, r.probability, r.confidence)

    def as_dict(self) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON, angles in degrees."""
        results, flights = self.results, self.results.flights
        nominal = results.nominal.get(self.output)
        return {
            **document(results, "vehicle", "model", "cases", "complete"),
            "cases_planned": results.campaign.cases,
            **document(self, "output", "limit", "success", "survival", "median"),
            "trusts_a_forecast": self.trusts_a_forecast,
            "statuses": results.statuses(),
            **document(self.required, "probability", "confidence"),
            "nominal_deg": None if nominal is None else np.degrees(nominal),
            **self.required.angles,
            "increase": self.increase,
            "flights": flights and dict(zip(("survived", "lost"), flights, strict=True)),
            "loss": self.loss,
            "loss_drivers": results.loss_drivers(),
            "drivers": results.drivers(self.output),
            "worst": [{"case": k, "deg": np.degrees(v)} for k, v in self.worst.items()],
            "convergence": [
                {"cases": quantile.cases, **quantile.angles} for quantile in self.convergence
            ],
        }

    def tables(self) -> tuple[Table, Table]:
        """Return the tables of the answer with its drivers, and of its convergence.

        The second has a row for each of some numbers of first cases: the quantile of the sample and
        its bounds with the confidence, not below and not above which that of all cases lies.
        """
        plan, required = self.results.campaign, self.required
        planes = f", both planes, {plan.nozzle.limit_shape} stop" if plan.planes == BOTH else ""
        caption = (
            f"{plan.vehicle.name or 'vehicle'}, {plan.model}{planes}: {column_label(self.output)}"
        )
        rows = tuple(
            (
                significant(f"convergence.{quantile.cases}", quantile.cases, 9),
                *(
                    self._bound(f"convergence.{quantile.cases}.{name}", getattr(quantile, name))
                    for name in _BOUNDS
                ),
            )
            for quantile in self.convergence
        )
        converges = (
            f"Convergence of {100 * required.probability:g} %,"
            f" each bound {100 * required.confidence:g} % sure"
        )
        head = ("cases", "not below", "sample", "not above")
        return quantities(caption, self._rows()), Table(converges, head, rows)

    def _rows(self) -> list[Row]:
        """Return the rows of the answer with its drivers."""
        results, flights = self.results, self.results.flights
        # labels of the estimate, and of the upper bound with its confidence
        of_cases, of_flights = shares(self.required.probability, self.required.confidence)
        done = f"{results.cases} of {results.campaign.cases}"
        rows: list[Row] = [("cases", (done if results.complete else f"{done}, unfinished",))]
        # the status of cases up to a semicolon, behind which it is explained
        rows += [(f"  {k.split(';')[0]}", (str(count),)) for k, count in results.statuses().items()]
        if results.nominal:
            rows.append(("nominal", self._angle("nominal", results.nominal[self.output])))
        rows += [
            ("median", self._angle("median", self.median)),
            (of_cases, self._angle("estimate", self.required.estimate)),
            (of_flights, self._bound("upper", self.required.upper)),
        ]
        if self.increase is not None:
            percent = number("increase", 100.0 * self.increase, 1)
            rows.append(("increase over nominal", (*percent, " % (size.dispersion_percent)")))
        limit = f"{np.degrees(self.limit or 0.0):.3f} deg is {sufficiency(True)} in"
        probabilities = {
            limit: self.success,
            survival(True): self.survival,
            survival(False): self.loss,
        }
        rows += [
            (k, probability.line(k))
            for k, probability in probabilities.items()
            if probability is not None
        ]
        if flights is not None:
            survived, losses = flights  # numbers of flights
            rows += [
                ("flights", (f"{survived} {survival(True)}, {losses} {survival(False)}",)),
                ("loss is driven by", (self._driven(survived, losses),)),
            ]
        rows.append(("dynamic pressure", (self.pressure,)))
        if self.trusts_a_forecast:
            rows.append(("this dead band", ("trusts a forecast of the wind; K = 1 needs none",)))
        drivers = list(results.drivers(self.output).items())[:_MAX_SHOWN]
        worst = [
            _with_name(str(k), self._angle(f"worst.{k}", angle)) for k, angle in self.worst.items()
        ]
        driven = [_with_name(k, (*number(f"driver.{k}", rank, 2),)) for k, rank in drivers]
        return [
            *rows,
            ("driven by (rank correlation)", _joined(driven)),
            ("worst cases", _joined(worst)),
        ]

    def _angle(self, name: str, angle: float) -> Line:
        """Return the text of an angle [rad] of the cases; infinite it is lost, or not known."""
        if np.isinf(angle) and np.any(self.unknown):
            return ("lost or not known",)
        return _angle(name, angle)

    def _bound(self, name: str, angle: float) -> Line:
        """Return the text of a bound `angle` [rad] of the output's quantile, or why it is infinite.

        `name`: of the number, for JSON. Any bound is infinite if unknown or with too few cases;
        lost flights make an upper one infinite, not a lower one.
        """
        if not np.isinf(angle):
            return _angle(name, angle)
        flights = self.results.flights  # numbers of survived and of lost flights
        if np.any(self.unknown):
            return ("not known",)
        diverged = self.output.startswith("flight_") and flights is not None and flights[1] > 0
        return (
            f"none, flights are {survival(False)}"
            if diverged and angle > 0.0  # a lower bound is minus infinity
            else f"too few cases to say{self.required.few_cases}",
        )

    def _driven(self, survived: int, losses: int) -> str:
        """Return the parameters that correlate most with the loss of flights, in words.

        Each has its rank correlation, positive where larger values are lost more often, and the
        confidence that this is no chance, not below the confidence of the required deflection.
        `survived`, `losses`: numbers of flights that survived and that are lost.
        """
        if not losses or not survived:
            return "nothing: every flight is lost" if losses else "nothing: no flight is lost"
        shown = []
        for name, driver in self.results.loss_drivers().items():
            if driver.confidence >= self.required.confidence:
                sure = f"{100 * driver.confidence:.1f} %"
                if driver.confidence > _MAX_SHOWN_CONFIDENCE:
                    sure = f"above {100 * _MAX_SHOWN_CONFIDENCE:g} %"
                shown.append(f"{name} ({driver.rank:+.2f}, {sure} sure)")
        return ", ".join(shown[:_MAX_SHOWN]) or "nothing that stands out from chance"


_BOUNDS = ("lower", "estimate", "upper")
"""Fields of `Quantile` in the table of convergence."""


def _angle(name: str, angle: float) -> Line:
    """Return the line of an angle [rad] in degrees; "lost" for an infinite one.

    `name`: name of the number, after "campaign.".
    """
    if np.isnan(angle):
        return ("not known",)
    return ("lost",) if np.isinf(angle) else degrees(f"campaign.{name}", angle, unit="deg")


def _with_name(name: str, line: Line) -> Line:
    """Return a name with a value, a line of text, in brackets behind it."""
    return (f"{name} (", *line, ")")


def _joined(lines: list[Line]) -> Line:
    """Return lines as a single line, separated by commas."""
    return tuple(cell for k, line in enumerate(lines) for cell in ((", ",) if k else ()) + line)
