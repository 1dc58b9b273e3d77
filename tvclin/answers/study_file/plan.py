"""What a study file asks for: one frozen value that says everything its numbers depend on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

from tvclin.answers.document import Document
from tvclin.answers.study import Study
from tvclin.base.errors import (
    InputError,
    between,
    fraction,
    instance,
    number,
    one_of,
    positive,
    small_angle,
    whole_number,
)
from tvclin.boundary.stops import Stop, stop_of
from tvclin.linear.deflections import SWITCHES
from tvclin.linear.models import MODELS, USUAL_MODEL, usual_model
from tvclin.vehicle.coefficients import PLANES
from tvclin.vehicle.linear_vehicle import AnyVehicle, LinearVehicle
from tvclin.vehicle.structure import Structure
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History
from tvclin.winds.shaped import PULSES, ShapedWind

if TYPE_CHECKING:
    from tvclin.answers.availability.asked import AvailabilityAsked
    from tvclin.answers.campaign.dispersions import Dispersions
    from tvclin.answers.sizing.asked import SizingAsked
    from tvclin.answers.trials import LawsAsked
    from tvclin.control.autopilot.rules import GainsAsked
    from tvclin.control.margins.criteria import Criteria

DEFAULT_WIND = ShapedWind("triangular", float(np.radians(5.0)), 7.5)


@dataclass(frozen=True, kw_only=True)
class StudyPlan:
    """Everything that a study and its page depend on.

    Attributes
    ----------
    vehicle : Vehicle or LinearVehicle
        The vehicle, one.
    structure : Structure, optional
        What bends and sloshes in it: for the margins and flights of the autopilot. Boundaries are
        those of the rigid vehicle.
    model, plane : str
        As of `Study.from_vehicle`.
    wind : ShapedWind
        The wind; 5 degrees for 7.5 seconds, a triangle, unless given.
    gust : History, optional
        As of `Study.from_vehicle`.
    limit : float, optional
        The capability [rad] in question.
    dead_band : float
        K of the verdict.
    switch : str
        As of `Study.from_vehicle`.
    laws : LawsAsked, optional
        Laws to be flown.
    gains : GainsAsked, optional
        The autopilot to be judged.
    criteria : Criteria, optional
        What its margins are held to.
    dispersions : Dispersions, optional
        What is uncertain.
    cases, seed : int
        How many dispersed cases are drawn, and from what.
    probability, confidence : float
        Of the deflection that covers them, as of `quantile_bound`.
    sizing : SizingAsked, optional
        What is asked of the whole flight.
    availability : AvailabilityAsked, optional
        An archive of soundings: on how many days it flies.
    nozzle_stop : Stop or str, optional
        As the `stop` of `Study.from_vehicle`: the verdict is on both planes.
    document : Document, optional
        Project, author, date and revision, for the head of its page.

    Raises
    ------
    InputError
        For numbers out of range, unknown names, and a wind that is not of one shape.
    """

    vehicle: AnyVehicle
    structure: Structure | None = None
    model: str = ""
    plane: str = "pitch"
    wind: ShapedWind = DEFAULT_WIND
    gust: History | None = None
    limit: float | None = None
    dead_band: float = 1.0
    switch: str = "literal"
    laws: LawsAsked | None = None
    gains: GainsAsked | None = None
    criteria: Criteria | None = None
    dispersions: Dispersions | None = None
    cases: int = 2000
    seed: int = 0
    probability: float = 0.99865
    confidence: float = 0.9
    sizing: SizingAsked | None = None
    availability: AvailabilityAsked | None = None
    nozzle_stop: Stop | str | None = None
    document: Document | None = None

    def __post_init__(self) -> None:
        self._check_subject()
        if not isinstance(self.wind, ShapedWind):
            raise InputError(
                "a study needs a wind of one shape: give shape, peak and duration in [wind]"
            )
        one_of("shape of the wind of a study", self.wind.shape, PULSES)
        one_of("switch", self.switch, SWITCHES)
        number("dead_band", self.dead_band, between(0.0, 1.0))
        if self.limit is not None:
            number("limit", self.limit, small_angle("a deflection", positive), "rad")
        if self.structure is not None:
            instance("structure", self.structure, Structure, "see load_structure")
        if self.gust is not None:
            instance("gust", self.gust, History, "such as OneMinusCosineGust")
        if self.nozzle_stop is not None:
            stop_of(self.nozzle_stop)
            if self.wind.heading is None:
                raise InputError(
                    "a stop of both planes needs a wind with a direction: give where it blows from,"
                    " and the azimuth of the flight"
                )
        self._check_parts()
        for name in ("cases", "seed"):
            whole_number(name, getattr(self, name))
        for name in ("probability", "confidence"):
            fraction(name, getattr(self, name))

    def _check_subject(self) -> None:
        if not isinstance(self.vehicle, LinearVehicle):
            instance("vehicle", self.vehicle, Vehicle, "see load_vehicle")
        if isinstance(self.model, str) and not self.model:
            object.__setattr__(self, "model", usual_model(self.vehicle))
        one_of("model", self.model, MODELS)
        one_of("plane", self.plane, PLANES)

    def _check_parts(self) -> None:
        """What may be asked besides; its kinds are imported only where something is."""
        if self.document is not None:
            instance("document", self.document, Document, "for the head of the page")
        names = ("laws", "gains", "criteria", "dispersions", "sizing", "availability")
        if all(getattr(self, name) is None for name in names):
            return
        from tvclin.answers.availability.asked import AvailabilityAsked
        from tvclin.answers.campaign.dispersions import Dispersions
        from tvclin.answers.sizing.asked import SizingAsked
        from tvclin.answers.trials import LawsAsked
        from tvclin.control.autopilot.rules import GainsAsked
        from tvclin.control.margins.criteria import Criteria

        kinds = LawsAsked, GainsAsked, Criteria, Dispersions, SizingAsked, AvailabilityAsked
        makers = (
            "of the standard laws",
            "or a rule for them",
            "see Criteria.own",
            "of Dispersion values",
            "see load_sizing",
            "see load_study",
        )
        for name, kind, maker in zip(names, kinds, makers, strict=True):
            if getattr(self, name) is not None:
                instance(name, getattr(self, name), kind, maker)
        if self.criteria is not None and self.criteria.of_modes and not self._modes:
            raise InputError(
                "mode_gain_margin_dB and mode_phase_margin_deg are asked of modes: the vehicle"
                " needs [[bending]] or [[slosh]] in its file"
            )

    @property
    def loop_model(self) -> str:
        """The model that the autopilot controls."""
        return (self.gains and self.gains.model) or self.model

    @property
    def law_model(self) -> str:
        """The model that laws fly; they are not shown a speed, and without it drift-exact is it."""
        own = (self.laws and self.laws.model) or self.model
        return USUAL_MODEL if own == "drift-and-speed" else own

    @property
    def _modes(self) -> bool:
        return self.structure is not None and bool(self.structure.bending or self.structure.slosh)

    @classmethod
    def of_study(cls, study: Study) -> Self:
        """Return the plan of a study that has been made."""
        instance("study", study, Study, "see Study.from_vehicle")
        wind, gust = study.slanting, study.gust
        if wind is None:
            wind = ShapedWind(study.shape, float(study.wind.peak), float(study.wind.duration))
        elif gust is not None:
            gust = gust * (wind.peak / float(study.wind.peak))
        return cls(
            vehicle=study.vehicle,
            model=study.model,
            plane=study.plane,
            wind=wind,
            gust=gust,
            nozzle_stop=study.planes.stop if study.planes is not None and study.in_both else None,
            limit=study.limit,
            dead_band=study.dead_band,
            switch=study.switch,
        )

    def study(self) -> Study:
        """Return the study; raise `InputError` as `Study.from_vehicle`."""
        return Study.from_vehicle(
            self.vehicle,
            wind=self.wind.shape,
            duration=self.wind.duration,
            peak=self.wind.peak,
            gust=self.gust,
            heading=self.wind.heading,
            stop=self.nozzle_stop,
            limit=self.limit,
            dead_band=self.dead_band,
            model=self.model,
            plane=self.plane,
            switch=self.switch,
        )
