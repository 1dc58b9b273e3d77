"""The first answer: how much deflection covers a dispersed vehicle, in seconds, without a file."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tvclin.answers.campaign.batch import required_name
from tvclin.answers.campaign.cases import BEYOND, divide, evaluate
from tvclin.answers.campaign.dispersions import DEFAULT_DISPERSIONS, WIND, Dispersions
from tvclin.answers.campaign.draws import draw
from tvclin.answers.campaign.plan import Campaign
from tvclin.answers.campaign.statistics import (
    Quantile,
    Success,
    quantile_bound,
    sensitivities,
    shares,
    success_probability,
)
from tvclin.answers.case import Case
from tvclin.answers.case_requirement import pulse_of
from tvclin.answers.planes import alone_needed, planes_needed, rectangle
from tvclin.answers.requirement import covers, required_deflection
from tvclin.answers.study import Study
from tvclin.base.arrays import AnyArray, FloatArray, IndexArray
from tvclin.base.cards import Shown, table
from tvclin.base.documents import keyed
from tvclin.base.errors import InputError, fraction, instance, shown, whole_number
from tvclin.base.lines import Row, Table, degrees, number, quantities, significant
from tvclin.base.quantities import sufficiency
from tvclin.boundary.stops import stop_of
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import PLANES
from tvclin.vehicle.linear_vehicle import complete_vehicle
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.plane_wind import PlaneWind
from tvclin.winds.wind_angles import within_linear

_QUICK_CASES, _VECTORS = 2000, 32
"""Cases of `part_in_a_wind`, and of these whose vectors are solved before it looks again."""
_MOST_CASES = 10_000_000
"""Cases that are held in memory at once; a campaign has more."""


@dataclass(frozen=True, eq=False)
class DispersedStudy(Shown):
    """A study with its vehicle and wind dispersed.

    Attributes
    ----------
    nominal : Study
        The study itself.
    dispersions : Dispersions
        What was uncertain.
    seed : int
        Case i is drawn from the seed and i alone.
    values : dict of str to ndarray
        Dispersed parameters [SI], ``(n,)`` each.
    deflection : ndarray
        Required deflection [rad] of each case at the model and dead band of the study, ``(n,)``;
        of both planes where the study judges both; NaN where there is none. At the wind angle and
        dynamic pressure that each case encounters.
    status : ndarray of str
        Of each case: "ok", "no unstable pole" (nothing is needed), or why there is no answer.
    required : Quantile
        The deflection [rad] that covers the probability asked for.
    success : Success or None
        How probable the limit of the study is sufficient.
    drivers : dict of str to float
        Rank correlation of each parameter with the required deflection, the strongest first.
    """

    nominal: Study
    dispersions: Dispersions
    seed: int
    values: dict[str, FloatArray]
    deflection: FloatArray
    status: AnyArray
    required: Quantile
    success: Success | None
    drivers: dict[str, float]

    _keys = (
        "cases=required.cases seed median_deg estimate_deg=required.estimate"
        " upper_deg=required.upper drivers"
    )

    as_dict = keyed(
        "cases=required.cases seed probability=required.probability confidence=required.confidence"
        " median_deg estimate_deg=required.estimate upper_deg=required.upper"
        " lower_deg=required.lower drivers success dispersions=dispersions.each"
    )

    def _repr_html_(self) -> str:
        return "".join(map(table, self.tables()))

    def tables(self) -> tuple[Table, Table]:
        """Return what covers the dispersions, and what drives it."""
        r = self.required
        of_cases, of_flights = shares(r.probability, r.confidence)
        covers = degrees("dispersed.upper", r.upper, unit="deg")
        rows: list[Row] = [
            ("cases", significant("dispersed.cases", r.cases, 9)),
            ("seed", significant("dispersed.seed", self.seed, 9)),
            ("median", degrees("dispersed.median", self.median, unit="deg")),
            (of_cases, degrees("dispersed.estimate", r.estimate, unit="deg")),
            (of_flights, ("too few cases to say",) if np.isinf(r.upper) else covers),
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
            Table("What drives it", ("parameter", "rank correlation"), drivers),
        )

    @property
    def spreads(self) -> str:
        """What is dispersed, and by how much, in sentences."""
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
    def median(self) -> float:
        """The median [rad] of the deflections that are known."""
        return float(np.nanmedian(self.deflection))

    @property
    def part(self) -> float:
        """What dispersions add, as a part of the nominal requirement; infinite if not known."""
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
        What is uncertain; the default ones are assumed, not any programme's.
    cases : int
        How many.
    seed : int
        Of the random numbers.
    probability, confidence : float
        Of the deflection asked for, as of `quantile_bound`.
    method : {"plain", "sobol", "latin"}
        As of `draw`. Order statistics hold for plain numbers; the others converge faster, and
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
    >>> found = tv.answers.disperse_study(nominal, cases=2000, seed=1)
    >>> bool(found.required.upper > nominal.required_deflection)
    True
    """
    campaign = _campaign(study, dispersions, cases, seed, method)
    for name, part in (("probability", probability), ("confidence", confidence)):
        fraction(name, part)
    found = evaluate(campaign, 0, cases)
    deflection = found[required_name(study.dead_band)] * study.of_both
    good = ~np.isnan(deflection)
    if not np.any(good):
        raise InputError(f"no case has an answer; the first is: {found['status'][0]}")
    values = {name: found[name] for name in dispersions.parameters}
    if study.case.heading is not None:
        peaks = found.get("wind_peak", np.full(cases, study.placed.peak))
        vectors = good & ~within_linear(
            np.abs(peaks / pulse_of(study.case).peak) * study.wind_angle
        )
        deflection[vectors], found["status"][vectors] = np.inf, BEYOND
    counted, limit = deflection[good], study.limit
    sufficient = 0 if limit is None else int(np.sum(covers(limit, counted)))
    return DispersedStudy(
        nominal=study,
        dispersions=dispersions,
        seed=int(seed),
        values=values,
        deflection=deflection,
        status=found["status"].astype(str),
        required=quantile_bound(counted, probability, confidence),
        success=None
        if limit is None
        else success_probability(sufficient, counted.size, confidence),
        drivers=sensitivities({k: v[good] for k, v in values.items()}, counted),
    )


def _campaign(
    study: Study, dispersions: Dispersions, cases: int, seed: int, method: str
) -> Campaign:
    instance("study", study, Study, "see Study.from_vehicle")
    if not 1 <= whole_number("cases", cases) <= _MOST_CASES:
        raise InputError(f"cases must be from 1 to {_MOST_CASES}; got {shown(cases)}")
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


def part_in_a_wind(
    vehicle: Vehicle, wind: History | PlaneWind, case: Case, dead_band: float
) -> float:
    """Return what default dispersions of a vehicle add in a wind that is none of the standard ones.

    As a part of what the nominal vehicle needs, of 2000 cases, as `DispersedStudy.part`: in the
    plane of the case, or of the vector in both with its stop.
    """
    own = Dispersions(tuple(one for one in DEFAULT_DISPERSIONS.each if one.parameter not in WIND))
    held = {name: getattr(vehicle, name) for name in own.parameters}
    cases = own.apply(held, draw(0, 0, _QUICK_CASES, len(own.each)))
    needs = np.full(_QUICK_CASES, np.nan)

    def of(which: IndexArray) -> Vehicle:
        return vehicle.replace(**{name: one[which] for name, one in cases.values.items()})

    def answer(which: IndexArray) -> None:
        needs[which] = _needed(of(which), wind, case, dead_band)

    divide(answer, lambda *_: None, np.flatnonzero(cases.possible))
    if isinstance(wind, PlaneWind):
        blows = wind
        raise_to_vectors(needs, lambda one: _of_vectors(of(one), blows, case, dead_band))
    known = needs[~np.isnan(needs)]
    if not known.size:
        raise InputError("no dispersed case of this flight time has an answer in this wind")
    nominal = (
        _of_vectors(vehicle, wind, case, dead_band)
        if isinstance(wind, PlaneWind)
        else _needed(vehicle, wind, case, dead_band)
    )
    return _upper(known) / float(nominal) - 1.0


def _upper(needs: FloatArray) -> float:
    return quantile_bound(needs, Campaign.probability, Campaign.confidence).upper


def raise_to_vectors(needs: FloatArray, vectors: Callable[[IndexArray], FloatArray]) -> None:
    """Raise the largest needs of each plane by itself to those of the vector.

    Vectors are solved one by one; the others are left where even twice the largest excess that was
    found would not bring them to what is covered.
    """
    order = np.argsort(-needs)[: int(np.sum(~np.isnan(needs)))]
    excess = 0.0
    for first in range(0, order.size, _VECTORS):
        which = order[first : first + _VECTORS]
        if first and needs[which[0]] * (1.0 + 2.0 * excess) <= _upper(needs[order]):
            return
        alone, needs[which] = needs[which], vectors(which)
        excess = max(excess, float(np.max(needs[which] / alone)) - 1.0)


def _needed(
    vehicle: Vehicle, wind: History | PlaneWind, case: Case, dead_band: float
) -> FloatArray:
    """What vehicles require [rad] in one wind, in both planes what each by itself does."""
    if isinstance(wind, PlaneWind):
        alone = alone_needed(_plants(vehicle, case), wind, dead_band)
        return rectangle(stop_of(case.nozzle.stop or ""), alone["pitch"], alone["yaw"])
    plant = Plant.from_vehicle(vehicle, case.model, case.plane)
    return np.abs(required_deflection(plant, wind, dead_band).deflection)


def _of_vectors(vehicle: Vehicle, wind: PlaneWind, case: Case, dead_band: float) -> FloatArray:
    """What vehicles require [rad] of both planes in one wind with its vectors."""
    stop = stop_of(case.nozzle.stop or "")
    found = planes_needed(_plants(vehicle, case), wind, stop, dead_band)
    return np.asarray(found.deflection)


def _plants(vehicle: Vehicle, case: Case) -> dict[str, Plant]:
    return {plane: Plant.from_vehicle(vehicle, case.model, plane) for plane in PLANES}
