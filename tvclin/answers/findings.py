"""Everything that a plan asks for, found before anything is written.

What answers a part is imported where that part is asked for.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache, partial
from hashlib import sha256
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from tvclin.answers.case_requirement import survived_size
from tvclin.answers.study import Study
from tvclin.answers.study_file.plan import StudyPlan
from tvclin.base.errors import InputError
from tvclin.base.warned import warned

if TYPE_CHECKING:
    from tvclin.answers.autopilot_requirement import AutopilotRequirement
    from tvclin.answers.availability.record import Availability
    from tvclin.answers.campaign.dispersions import Dispersions
    from tvclin.answers.campaign.quick import DispersedStudy
    from tvclin.answers.flexible import FlexibleAnswer
    from tvclin.answers.nozzle_cards.record import FlightCard
    from tvclin.answers.sizing.record import Sizing
    from tvclin.answers.sizing.request import SizingRequest
    from tvclin.answers.sizing.total import DeflectionTotal
    from tvclin.answers.trials import LawsRequest, LawTrial
    from tvclin.boundary.fronts.load_record import LoadFront
    from tvclin.boundary.fronts.rate_record import RateFront
    from tvclin.control.autopilot.autopilot import Autopilot
    from tvclin.control.comparison import TrimComparison
    from tvclin.control.margins.bands import BandMargins
    from tvclin.control.margins.criteria import Criteria
    from tvclin.control.margins.margins import Margins
    from tvclin.flights.closed_loop.flown_margins import FlownMargins
    from tvclin.flights.closed_loop.survival_limit import ClosedLoopBoundary
    from tvclin.linear.flexible import AnyPlant

Told = Callable[[float, float], None]
"""Is told how much of a part is done, and how much there is."""
Loop: TypeAlias = "Callable[[], tuple[Any, Autopilot]]"
"""Of the plant that flies and its autopilot."""
Flying: TypeAlias = "FlexibleAnswer | TrimComparison"
"""What has both."""
_LATER = (
    *("availability", "gust_at", "sign", "gust_speed", "data", "card"),
    *("acceleration_limit", "travel_limit", "torque_limit", "power_limit", "load"),
)
MOST_CASES = 20_000
"""Dispersed cases of a page; more are for a campaign."""


@dataclass(frozen=True, eq=False)
class HeadWind:
    """The same answers in the dynamic pressure at the peak of a head wind, held throughout.

    `stop` and `rates` are as of `Findings`, None where there is no answer.
    """

    stop: ClosedLoopBoundary | None
    rates: RateFront | None


@dataclass(frozen=True, eq=False)
class Findings:
    """A plan and all that was found for it; None, or empty, where that is not asked for.

    `trials` are the laws, each in each wind; `comparison` is the autopilot in the wind, with its
    margins; `flexible` the same around a flexible vehicle. `stop` is the least limit with which the
    autopilot, flown with it as a stop, survives the wind, `flown` what the limit leaves of the
    margins there. `flight` is the whole flight, and the worst of all that its nozzle has to do;
    `card` what a law asks of the nozzle there. `availability` says on how many days of an archive
    it flies, `rates` what limit and rate limit leave in the wind, `loads` the limit over what the
    structure bears. `head` has `stop` and `rates` in a head wind, where that counts in what the
    wind needs. Of what has no answer `reasons` has the reason, by the name of its field;
    `warnings` is what was said on the way.
    """

    plan: StudyPlan
    study: Study
    trials: tuple[LawTrial, ...]
    comparison: TrimComparison | None
    flexible: FlexibleAnswer | None
    stop: ClosedLoopBoundary | None
    flown: FlownMargins | None
    dispersed: DispersedStudy | None
    flight: tuple[Sizing, DeflectionTotal] | None
    card: FlightCard | None
    availability: Availability | None
    rates: RateFront | None
    loads: LoadFront | None
    head: HeadWind | None
    reasons: dict[str, str]
    warnings: tuple[str, ...]

    @property
    def criteria(self) -> Criteria:
        """What the margins are held to."""
        return self.plan.held_to

    @property
    def margins(self) -> Margins | BandMargins | None:
        """The margins that are judged: those by band of a flexible vehicle."""
        if self.flexible is not None:
            return self.flexible.bands
        return None if self.comparison is None else self.comparison.margins

    @property
    def autopilot_requirement(self) -> AutopilotRequirement | None:
        """The autopilot requirement; None where it is not flown."""
        from tvclin.answers.autopilot_requirement import AutopilotRequirement, counts_head

        if self.stop is None:
            return None
        head = None if self.head is None else self.head.stop
        return AutopilotRequirement(self.stop, head, counts_head(self.study), self.study.of_both)

    @property
    def autopilot_survives(self) -> float:
        """How many times the wind the autopilot survives, flown with the limit as its stop.

        At nominal dynamic pressure a flight scales with its wind; a larger head wind raises that
        too. NaN where it is not flown.
        """
        limit, stop, s = self.study.limit, self.stop, self.study
        if stop is None or limit is None:
            return np.nan
        part, head = limit / s.of_both, None if self.head is None else self.head.stop
        if head is None or not np.isfinite(head.deflection):
            least = abs((head or stop).deflection)
            return part / least if least else np.inf
        loop = self.flexible or self.comparison
        assert loop is not None

        from tvclin.answers.autopilot_requirement import at_peak_pressure, autopilot_boundary

        def need(size: float) -> float:
            with suppress(InputError):
                denser = at_peak_pressure(self.plan, s, size)
                flown = autopilot_boundary(denser, denser.plant, loop.autopilot, s.of_both)
                return size * abs(float(flown.deflection))
            return np.inf

        return survived_size(part, need)

    @property
    def seal(self) -> str:
        """SHA-256 of the inputs, in SI units and in one order."""
        asked = asdict(self.plan, dict_factory=_known)
        del asked["document"]  # no number depends on it
        return sha256(json.dumps(asked, sort_keys=True, default=_plain).encode()).hexdigest()


def _known(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """What is given: the seals of what could be asked before stay what they were."""
    pairs = [pair for pair in pairs if pair[0] != "numbers_from"]  # no number depends on it
    return {key: value for key, value in pairs if value is not None or key not in _LATER}


def _plain(value: Any) -> Any:
    """What arrays and histories are in JSON: lists, complex numbers as pairs, times as text."""
    array = np.asarray(value)
    if np.iscomplexobj(array):
        return [array.real.tolist(), array.imag.tolist()]
    if array.dtype.kind == "M":
        return array.astype(str).tolist()
    return array.tolist()


def find(plan: StudyPlan, progress: Callable[[float, float], None] | None = None) -> Findings:
    """Return everything that a plan asks for, and tell how many of its parts are found.

    A part that cannot be answered for this vehicle, such as margins of laws for one that is stable,
    has its reason in place of an answer. `InputError` as `StudyPlan.study`.
    """
    said: list[str] = []
    with warned(said.append):
        study = plan.study()
        reasons: dict[str, str] = {}
        asked = _asked(plan)

        def part(name: str, compute: Callable[[Any, Told], Any]) -> Any:
            if name not in asked:
                return None

            def told(done: float, total: float) -> None:
                if progress is not None:
                    progress(list(asked).index(name) + done / total, len(asked))

            try:
                return compute(asked[name], told)
            except InputError as error:
                reasons[name] = str(error)
                return None
            finally:
                told(1, 1)

        loop = cache(partial(_loop, plan, study))  # gains for the least nozzle take a search
        trials = part("trials", partial(_trials, plan, study, loop)) or ()
        comparison = part("comparison", lambda *_: _comparison(study, loop))
        flexible = part("flexible", lambda *_: _flexible(plan, study, loop))
        flying = flexible or comparison
        return Findings(
            plan=plan,
            study=study,
            trials=trials,
            comparison=comparison,
            flexible=flexible,
            stop=flying and part("stop", lambda *_: _stop(plan, study, flying)),
            flown=flying and part("flown", lambda limit, _: _flown(plan, study, flying, limit)),
            dispersed=part("dispersed", lambda asked, _: _dispersed(plan, study, asked)),
            flight=part("flight", partial(_flight, plan)),
            card=part("card", partial(_card, plan)),
            availability=part("availability", lambda asked, told: asked.availability(plan, told)),
            rates=part("rates", lambda limit, _: _rates(plan, study, limit)),
            loads=part("loads", lambda asked, _: asked.front(plan, 1.0 / study.of_both)),
            head=part("head", lambda limit, _: _in_a_head_wind(plan, study, flying, limit)),
            reasons=reasons,
            warnings=tuple(said),
        )


def _asked(plan: StudyPlan) -> dict[str, Any]:
    """What a plan asks for, and of what, by the names of fields of `Findings`."""
    loop = plan.design or plan.criteria
    wanted = {
        "trials": plan.laws,
        "comparison": loop,
        "flexible": plan.vehicle.structure and loop,
        "stop": loop and plan.nozzle.limit,
        "flown": loop and plan.nozzle.limit,
        "dispersed": plan.dispersions,
        "flight": plan.sizing,
        "card": plan.sizing if plan.sizing and plan.sizing.card else None,
        "availability": plan.availability,
        "rates": plan.nozzle.rate_limit and plan.nozzle.limit,
        "loads": plan.load,
        "head": plan.nozzle.limit if loop or plan.nozzle.rate_limit else None,
    }
    return {name: one for name, one in wanted.items() if one is not None}


def _trials(
    plan: StudyPlan, study: Study, loop: Loop, asked: LawsRequest, told: Told
) -> tuple[LawTrial, ...]:
    from tvclin.answers.trials import law_trials, standard_laws, standard_winds
    from tvclin.linear.flexible import plant_of

    plant = plant_of(plan.vehicle, plan.law_model, plan.plane)
    nozzle = plan.hardware | {"sample_rate": asked.sample_rate}
    own = None if plan.design is None else loop()[1]
    laws = standard_laws(plant.rigid, study.wind.peak, own, nozzle["rate_limit"])
    winds = standard_winds(study.wind.peak, study.wind.duration)
    if plan.vehicle.structure is None:  # beside boundaries, which have none
        nozzle |= {"actuator": None, "delay": 0.0}
    else:
        from tvclin.answers.flexible import with_filters

        laws = {name: with_filters(law, plan.asked) for name, law in laws.items()}
    return law_trials(
        plant,
        {name: laws[name] for name in asked.names},
        {name: winds[name] for name in asked.winds},
        loads=False,
        progress=told,
        **nozzle,
    )


def _comparison(study: Study, loop: Loop) -> TrimComparison:
    from tvclin.control.comparison import compare_with_trim

    return compare_with_trim(*loop(), study.history)


def _flexible(plan: StudyPlan, study: Study, loop: Loop) -> FlexibleAnswer:
    from tvclin.answers.flexible import flexible_answer

    (plant, autopilot), criteria = loop(), plan.held_to
    # along a straight wind the stop leaves this plane its part
    limit = None if plan.nozzle.limit is None else plan.nozzle.limit / study.of_both
    return flexible_answer(plant, autopilot, criteria, study.history, limit, **plan.hardware)


def _flown(plan: StudyPlan, study: Study, loop: Flying, limit: float) -> FlownMargins:
    """The margins that the limit leaves in the wind, of an autopilot and its plant."""
    from tvclin.control.laws.attitude import SaturatedLaw
    from tvclin.flights.closed_loop.flown_margins import flown_margins

    law, part = SaturatedLaw.of(loop.autopilot), limit / study.of_both
    return flown_margins(loop.plant, law, study.history, limit=part, **plan.hardware)


def _stop(plan: StudyPlan, study: Study, loop: Flying) -> ClosedLoopBoundary:
    """The autopilot requirement at nominal pressure; that of a flexible vehicle is known."""
    from tvclin.answers.autopilot_requirement import autopilot_boundary
    from tvclin.answers.flexible import FlexibleAnswer

    if isinstance(loop, FlexibleAnswer):
        return loop.boundaries[0]
    return autopilot_boundary(plan, loop.plant, loop.autopilot, study.of_both)


def _in_a_head_wind(
    plan: StudyPlan, study: Study, loop: Flying | None, limit: float
) -> HeadWind | None:
    """The answers at the dynamic pressure of a head wind, where that sets the requirement."""
    from tvclin.answers.autopilot_requirement import at_peak_pressure, head_wind_boundary

    if study.ratio_to_nominal <= 1.0:
        return None
    stop = head_wind_boundary(plan, loop.autopilot, study, study.of_both) if loop else None
    rates = None
    with suppress(InputError):
        denser = at_peak_pressure(plan, study)
        rates = _rates(denser, study, limit) if plan.nozzle.rate_limit else None
    return HeadWind(stop, rates)


def _loop(plan: StudyPlan, study: Study) -> tuple[AnyPlant, Autopilot]:
    """The plant and the autopilot that is asked for; gains that are sought meet the criteria."""
    from tvclin.answers.least_gains.asked import autopilot_asked

    return plan.plant, autopilot_asked(plan, study.history, plan.held_to)


def _flight(plan: StudyPlan, asked: SizingRequest, told: Told) -> tuple[Sizing, DeflectionTotal]:
    found = asked.sizing(plan, told)
    return found, asked.total(plan, found)


def _card(plan: StudyPlan, asked: SizingRequest, told: Told) -> FlightCard:
    from tvclin.answers.nozzle_cards.whole import flight_card

    return flight_card(plan, asked, str(asked.card), progress=told)


def _rates(plan: StudyPlan, study: Study, limit: float) -> RateFront:
    from tvclin.boundary.fronts.rates import rate_front

    part = limit / study.of_both  # the stop leaves this plane its part
    rate = plan.nozzle.rate_limit
    return rate_front(plan.plant.rigid, study.history, limit=part, rate_limit=rate)


def _dispersed(plan: StudyPlan, study: Study, asked: Dispersions) -> DispersedStudy:
    from tvclin.answers.campaign.quick import disperse_study

    return disperse_study(
        study,
        asked,
        cases=min(plan.cases, MOST_CASES),
        seed=plan.seed,
        probability=plan.probability,
        confidence=plan.confidence,
        method=plan.method,
    )
