"""The deflection that covers a dispersed vehicle, within seconds and without a file."""

from dataclasses import dataclass, field

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray
from tvclin.base.cards import Shown, table
from tvclin.base.errors import InputError, fraction, instance, shown, whole_number
from tvclin.base.fields import Field, derived, rows, spec, specs
from tvclin.base.lines import Table, degrees, number, quantities
from tvclin.base.quantities import sufficiency
from tvclin.ensembles import statistics
from tvclin.ensembles.campaign.campaign_plan import Campaign
from tvclin.ensembles.campaign.cases import NOT_KNOWN, evaluate
from tvclin.ensembles.campaign.outputs import required_name
from tvclin.ensembles.dispersions import DEFAULT_DISPERSIONS, Dispersions
from tvclin.requirement.nominal_requirement import covers
from tvclin.requirement.study import Study
from tvclin.vehicle.linear_vehicle import complete_vehicle

_MAX_CASES = 10_000_000
"""Largest number of cases in memory at once; a campaign may have more."""


@dataclass(frozen=True, eq=False)
class DispersedStudy(Shown):
    """A study with its vehicle and wind dispersed.

    Attributes
    ----------
    nominal : Study
        The nominal study.
    dispersions : Dispersions
        The uncertain parameters.
    seed : int
        Case i is drawn from the seed and i alone.
    values : dict of str to ndarray
        Dispersed parameters [SI], ``(n,)`` each.
    deflection : ndarray
        Required deflection [rad] of each case at the model and dead band of the study, ``(n,)``;
        of both planes where the study judges both; NaN where a case has no answer, infinite where
        it is not known. At the wind angle and dynamic pressure that each case encounters.
    status : ndarray of str
        Status of each case: "ok", "no unstable pole" (the required deflection is zero), or why it
        has no answer.
    required : Quantile
        The quantile of the deflection [rad] at the specified probability.
    success : Success or None
        Probability that the limit of the study is sufficient.
    drivers : dict of str to float
        Rank correlation of each parameter with the required deflection, the strongest first.
    """

    nominal: Study
    dispersions: Dispersions = field(metadata=spec(of="dispersions.distributions", card=False))
    seed: int = field(metadata=spec(significant=9))
    values: dict[str, FloatArray]
    deflection: FloatArray
    status: AnyArray
    required: statistics.Quantile = field(
        metadata=specs(
            Field(name="cases", of="required.cases", significant=9),
            Field(name="probability", of="required.probability", card=False),
            Field(name="confidence", of="required.confidence", card=False),
            Field(kind="angle", name="estimate", of="required.estimate"),
            Field(kind="angle", name="upper", of="required.upper"),
            Field(kind="angle", name="lower", of="required.lower", card=False),
        )
    )
    success: statistics.Success | None = field(metadata=spec(card=False))
    drivers: dict[str, float] = field(metadata=spec())

    def _repr_html_(self) -> str:
        """Return the tables of `tables` in HTML, for notebooks."""
        return "".join(map(table, self.tables()))

    def tables(self) -> tuple[Table, Table]:
        """Return the tables of the covering deflection [deg] and of the rank correlations."""
        r = self.required
        # labels of the quantile of the cases, and of its upper bound
        of_cases, of_flights = statistics.shares(r.probability, r.confidence)
        upper = degrees("dispersed.upper", r.upper, unit="deg")
        if np.isinf(r.upper):
            few = f"too few cases to say{r.few_cases}"
            upper = ("not known" if self.unknown_cases else few,)
        shown = [
            *rows(self, "dispersed", "cases", "seed", "median"),
            (of_cases, degrees("dispersed.estimate", r.estimate, unit="deg")),
            (of_flights, upper),
        ]
        if self.success is not None:
            shown.append(
                (f"the limit is {sufficiency(True)} in", self.success.line("dispersed.success"))
            )
        drivers = tuple(
            ((name.replace("_", " "),), number(f"dispersed.driver.{name}", rank, 2))
            for name, rank in self.drivers.items()
        )
        return (
            quantities("Deflection that covers the dispersions", shown),
            Table("Drivers", ("parameter", "rank correlation"), drivers),
        )

    @property
    def spreads(self) -> str:
        """The dispersed parameters and their distributions, in sentences."""
        return (
            f"Dispersed are {self.dispersions.words}. The number is one standard deviation, of a"
            " uniform distribution half its width; a truncated one is normal and cut at three"
            f" standard deviations. {self.unknown_cases}".rstrip()
        )

    @property
    def unknown_cases(self) -> str:
        """Sentences on cases whose requirement is not known; empty without any."""
        counts = {reason: int(np.sum(self.status == reason)) for reason in NOT_KNOWN}
        cases = self.status.size
        return " ".join(f"In {n} of {cases} cases: {why}." for why, n in counts.items() if n)

    @property
    def sufficient(self) -> bool | None:
        """Whether the limit covers the quantile with its confidence; None where not known."""
        if self.nominal.limit is None:
            return None
        has_answer = ~np.isnan(self.deflection)
        return statistics.covers_quantile(
            self.nominal.limit,
            self.deflection[has_answer],
            unknown=np.isin(self.status[has_answer], NOT_KNOWN),
            probability=self.required.probability,
            confidence=self.required.confidence,
        )

    @property
    @derived("angle")
    def median(self) -> float:
        """The median [rad] of the deflections of cases that have an answer."""
        return float(np.nanmedian(self.deflection))


def disperse_study(
    study: Study,
    dispersions: Dispersions = DEFAULT_DISPERSIONS,
    *,
    cases: int = 2000,
    seed: int = 0,
    probability: float = 0.99865,
    confidence: float = 0.9,
    method: str = "plain",
) -> DispersedStudy:
    """Return the deflection that covers a dispersed vehicle in a dispersed wind.

    Parameters
    ----------
    study : Study
        The nominal vehicle, wind, model and dead band, and the limit in question.
    dispersions : Dispersions
        Uncertain parameters; the default dispersions are assumed, not any programme's.
    cases : int
        Number of cases.
    seed : int
        Seed of the random numbers.
    probability, confidence : float
        Probability and confidence of the covering deflection; see `quantile_bound`.
    method : {"plain", "sobol", "latin"}
        Method of `draw`. Order statistics hold for plain numbers; the others converge faster, and
        their bounds are on the safe side.

    Raises
    ------
    InputError
        For numbers out of range, and when no case is possible.

    Examples
    --------
    >>> import numpy as np, tvclin as tv
    >>> nominal = tv.Study.from_vehicle(
    ...     tv.load_vehicle("configuration-i"), duration=7.5, peak=np.radians(5)
    ... )
    >>> dispersed = tv.ensembles.disperse_study(nominal, cases=2000, seed=1)
    >>> bool(dispersed.required.upper > nominal.required_deflection)
    True
    """
    instance("study", study, Study, "see Study.from_vehicle")
    if not 1 <= whole_number("cases", cases) <= _MAX_CASES:
        raise InputError(f"cases must be from 1 to {_MAX_CASES}; got {shown(cases)}")
    campaign = Campaign(
        vehicle=complete_vehicle(study.vehicle, "a dispersed study"),
        wind=study.placed,
        dispersions=dispersions,
        cases=cases,
        seed=seed,
        model=study.model,
        plane=study.plane,
        dead_bands=(study.dead_band,),
        method=method,
        sign=study.sign,
    )
    for name, value in (("probability", probability), ("confidence", confidence)):
        fraction(name, value)
    columns = evaluate(campaign, 0, cases)
    # of the plane; where both planes are judged, times the ratio of their limit to its limit
    deflection = columns[required_name(study.dead_band)] * study.plane_ratio
    has_answer = ~np.isnan(deflection)
    if not np.any(has_answer):
        raise InputError(f"no case has an answer; the first is: {columns['status'][0]}")
    values = {name: columns[name] for name in dispersions.parameters}
    counted, limit = deflection[has_answer], study.limit
    sufficient = 0 if limit is None else int(np.sum(covers(limit, counted)))
    return DispersedStudy(
        nominal=study,
        dispersions=dispersions,
        seed=int(seed),
        values=values,
        deflection=deflection,
        status=columns["status"].astype(str),
        required=statistics.quantile_bound(counted, probability, confidence),
        success=None
        if limit is None
        else statistics.success_probability(sufficient, counted.size, confidence),
        drivers=statistics.sensitivities({k: v[has_answer] for k, v in values.items()}, counted),
    )
