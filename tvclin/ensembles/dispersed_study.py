"""The deflection that covers a dispersed vehicle, within seconds and without a file."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.base.cards import Shown, table
from tvclin.base.errors import InputError, fraction, instance, shown, whole_number
from tvclin.base.fields import Field, derived, spec, specs
from tvclin.base.lines import Row, Table, degrees, number, quantities, significant
from tvclin.base.quantities import sufficiency
from tvclin.boundary.limit_shapes import limit_shape_of
from tvclin.case.case import Case
from tvclin.ensembles.campaign.campaign_plan import Campaign
from tvclin.ensembles.campaign.cases import BEYOND, divide, evaluate
from tvclin.ensembles.campaign.outputs import required_name
from tvclin.ensembles.dispersions import DEFAULT_DISPERSIONS, WIND, Dispersions
from tvclin.ensembles.random_numbers import draw
from tvclin.ensembles.statistics import (
    Quantile,
    Success,
    quantile_bound,
    sensitivities,
    shares,
    success_probability,
)
from tvclin.linear.plant import Plant
from tvclin.requirement.case_requirement import pulse_of
from tvclin.requirement.nominal_requirement import covers, required_deflection
from tvclin.requirement.plane_requirement import (
    rectangle,
    separate_requirements,
    two_plane_requirement,
)
from tvclin.requirement.study import Study
from tvclin.vehicle.coefficients import PLANES
from tvclin.vehicle.linear_vehicle import complete_vehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.wind_angles import within_linear

_QUICK_CASES = 2000
"""Number of cases of `relative_increase_in_wind`."""
_VECTOR_CASES = 32
"""Number of cases whose vectors are solved between two checks of `raise_to_vectors`."""
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
        of both planes where the study judges both; NaN where a case has no answer. At the wind
        angle and dynamic pressure that each case encounters.
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
    seed: int = field(metadata=spec())
    values: dict[str, FloatArray]
    deflection: FloatArray
    status: AnyArray
    required: Quantile = field(
        metadata=specs(
            Field(name="cases", of="required.cases"),
            Field(name="probability", of="required.probability", card=False),
            Field(name="confidence", of="required.confidence", card=False),
            Field(kind="angle", name="estimate", of="required.estimate"),
            Field(kind="angle", name="upper", of="required.upper"),
            Field(kind="angle", name="lower", of="required.lower", card=False),
        )
    )
    success: Success | None = field(metadata=spec(card=False))
    drivers: dict[str, float] = field(metadata=spec())

    def _repr_html_(self) -> str:
        return "".join(map(table, self.tables()))

    def tables(self) -> tuple[Table, Table]:
        """Return the tables of the covering deflection and of its drivers."""
        r = self.required
        of_cases, of_flights = shares(r.probability, r.confidence)
        covers = degrees("dispersed.upper", r.upper, unit="deg")
        rows: list[Row] = [
            ("cases", significant("dispersed.cases", r.cases, 9)),
            ("seed", significant("dispersed.seed", self.seed, 9)),
            ("median", degrees("dispersed.median", self.median, unit="deg")),
            (of_cases, degrees("dispersed.estimate", r.estimate, unit="deg")),
            (of_flights, (f"too few cases to say{r.few_cases}",) if np.isinf(r.upper) else covers),
        ]
        if self.success is not None:
            rows.append(
                (f"the limit is {sufficiency(True)} in", self.success.line("dispersed.success"))
            )
        drivers = tuple(
            ((name.replace("_", " "),), number(f"dispersed.driver.{name}", rank, 2))
            for name, rank in self.drivers.items()
        )
        return (
            quantities("Deflection that covers the dispersions", rows),
            Table("Drivers", ("parameter", "rank correlation"), drivers),
        )

    @property
    def spreads(self) -> str:
        """The dispersed parameters and their distributions, in sentences."""
        return (
            f"Dispersed are {self.dispersions.words}. The number is one standard deviation, of a"
            " uniform distribution half its width; a truncated one is normal and cut at three"
            f" standard deviations.{self._beyond}"
        )

    @property
    def _beyond(self) -> str:
        """Sentence on cases beyond linear aerodynamics; empty without any."""
        count = int(np.sum(self.status == BEYOND))
        return f" In {count} of {self.status.size} cases: {BEYOND}." if count else ""

    @property
    @derived("angle")
    def median(self) -> float:
        """The median [rad] of the deflections of cases that have an answer."""
        return float(np.nanmedian(self.deflection))

    @property
    def relative_increase(self) -> float:
        """Relative increase of the requirement by dispersions; infinite if not known."""
        nominal = self.nominal.required_deflection
        if nominal == 0.0:
            return 0.0 if self.required.upper == 0.0 else np.inf
        return self.required.upper / nominal - 1.0


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
    campaign = _campaign(study, dispersions, cases, seed, method)
    for name, value in (("probability", probability), ("confidence", confidence)):
        fraction(name, value)
    columns = evaluate(campaign, 0, cases)
    deflection = columns[required_name(study.dead_band)] * study.plane_ratio
    has_answer = ~np.isnan(deflection)
    if not np.any(has_answer):
        raise InputError(f"no case has an answer; the first is: {columns['status'][0]}")
    values = {name: columns[name] for name in dispersions.parameters}
    if study.case.heading is not None:
        peaks = columns.get("wind_peak", np.full(cases, study.placed.peak))
        vectors = has_answer & ~within_linear(
            np.abs(peaks / pulse_of(study.case).peak) * study.wind_angle
        )
        deflection[vectors], columns["status"][vectors] = np.inf, BEYOND
    counted, limit = deflection[has_answer], study.limit
    sufficient = 0 if limit is None else int(np.sum(covers(limit, counted)))
    return DispersedStudy(
        nominal=study,
        dispersions=dispersions,
        seed=int(seed),
        values=values,
        deflection=deflection,
        status=columns["status"].astype(str),
        required=quantile_bound(counted, probability, confidence),
        success=None
        if limit is None
        else success_probability(sufficient, counted.size, confidence),
        drivers=sensitivities({k: v[has_answer] for k, v in values.items()}, counted),
    )


def _campaign(
    study: Study, dispersions: Dispersions, cases: int, seed: int, method: str
) -> Campaign:
    """Return the campaign of a study: its vehicle and placed wind, dispersed."""
    instance("study", study, Study, "see Study.from_vehicle")
    if not 1 <= whole_number("cases", cases) <= _MAX_CASES:
        raise InputError(f"cases must be from 1 to {_MAX_CASES}; got {shown(cases)}")
    return Campaign(
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


def relative_increase_in_wind(
    vehicle: Vehicle, wind: History | PlaneWind, case: Case, dead_band: float
) -> float:
    """Return the relative increase of the required deflection by default dispersions of a vehicle.

    `wind` is of any shape, and not dispersed. Of 2000 cases, relative to the nominal requirement,
    as `DispersedStudy.relative_increase`: in the plane of the case, or of the vector in both with
    its stop.
    """
    dispersions = Dispersions(
        tuple(x for x in DEFAULT_DISPERSIONS.distributions if x.parameter not in WIND)
    )
    nominal_values = {name: getattr(vehicle, name) for name in dispersions.parameters}
    numbers = draw(0, 0, _QUICK_CASES, len(dispersions.distributions))
    cases = dispersions.apply(nominal_values, numbers)
    required = np.full(_QUICK_CASES, np.nan)

    def vehicles(which: IndexArray) -> Vehicle:
        return vehicle.replace(**{name: values[which] for name, values in cases.values.items()})

    def answer(which: IndexArray) -> None:
        required[which] = _required_deflections(vehicles(which), wind, case, dead_band)

    divide(answer, lambda *_: None, np.flatnonzero(cases.possible))
    if isinstance(wind, PlaneWind):
        vector = wind
        raise_to_vectors(
            required, lambda which: _vector_deflections(vehicles(which), vector, case, dead_band)
        )
    answers = required[~np.isnan(required)]
    if not answers.size:
        raise InputError("no dispersed case of this flight time has an answer in this wind")
    nominal = (
        _vector_deflections(vehicle, wind, case, dead_band)
        if isinstance(wind, PlaneWind)
        else _required_deflections(vehicle, wind, case, dead_band)
    )
    return _upper(answers) / float(nominal) - 1.0


def _upper(required: FloatArray) -> float:
    """Return the upper bound [rad] of the quantile that covers a campaign by default."""
    return quantile_bound(required, Campaign.probability, Campaign.confidence).upper


def raise_to_vectors(required: FloatArray, vectors: Callable[[IndexArray], FloatArray]) -> None:
    """Raise the largest requirements [rad] of separate planes to the requirements of the vector.

    `required`: ``(n,)``, changed in place. `vectors`: from indices of cases to the requirements of
    the vector [rad]. Vectors are solved from the largest requirement downwards, until even twice
    the largest relative excess so far does not raise the next case to the quantile.
    """
    order = np.argsort(-required)[: int(np.sum(~np.isnan(required)))]
    excess = 0.0
    for first in range(0, order.size, _VECTOR_CASES):
        which = order[first : first + _VECTOR_CASES]
        if first and required[which[0]] * (1.0 + 2.0 * excess) <= _upper(required[order]):
            return
        separate, required[which] = required[which], vectors(which)
        excess = max(excess, float(np.max(required[which] / separate)) - 1.0)


def _required_deflections(
    vehicle: Vehicle, wind: History | PlaneWind, case: Case, dead_band: float
) -> FloatArray:
    """Return required deflections [rad] in a wind, both planes computed separately, ``(n,)``."""
    if isinstance(wind, PlaneWind):
        separate = separate_requirements(_plants(vehicle, case), wind, dead_band)
        return rectangle(limit_shape_of(case.nozzle.stop or ""), separate["pitch"], separate["yaw"])
    plant = Plant.from_vehicle(vehicle, case.model, case.plane)
    return np.abs(required_deflection(plant, wind, dead_band).deflection)


def _vector_deflections(
    vehicle: Vehicle, wind: PlaneWind, case: Case, dead_band: float
) -> FloatArray:
    """Return required deflections [rad] of both planes in a wind with its vectors, ``(n,)``."""
    stop = limit_shape_of(case.nozzle.stop or "")
    return np.asarray(
        two_plane_requirement(_plants(vehicle, case), wind, stop, dead_band).deflection
    )


def _plants(vehicle: Vehicle, case: Case) -> dict[str, Plant]:
    """Return the plants of vehicles by plane."""
    return {plane: Plant.from_vehicle(vehicle, case.model, plane) for plane in PLANES}
