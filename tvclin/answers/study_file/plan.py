"""What a study file asks for: one frozen value that says everything its numbers depend on."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Self

from tvclin.answers.campaign.draws import METHODS
from tvclin.answers.case import DEFAULT_WIND, Case
from tvclin.answers.case_requirement import pulse_of
from tvclin.answers.document import Document
from tvclin.answers.study import Study
from tvclin.base.declared import count, quantity, word
from tvclin.base.errors import InputError, between, fraction, instance
from tvclin.linear.deflections import SWITCHES
from tvclin.winds.histories import History
from tvclin.winds.shaped import ShapedWind

if TYPE_CHECKING:
    from tvclin.answers.availability.request import AvailabilityRequest
    from tvclin.answers.campaign.dispersions import Dispersions
    from tvclin.answers.load import LoadBound
    from tvclin.answers.sizing.request import SizingRequest
    from tvclin.answers.trials import LawsRequest
    from tvclin.control.margins.criteria import Criteria


@dataclass(frozen=True, kw_only=True)
class StudyPlan(Case):
    """Everything that a study and its page depend on: a case, and what is asked of it.

    The structure of the vehicle counts for the margins and flights of the autopilot and of laws;
    boundaries are those of the rigid vehicle.

    Attributes
    ----------
    dead_band : float
        Dead band K of the verdict, from 0 to 1; only 1 needs no forecast of the wind.
    switch : str
        What is compared with the dead band, in the boundaries shown: trim (literal) or the wind
        (report).
    laws : LawsRequest, optional
        Laws to be flown.
    criteria : Criteria, optional
        What its margins are held to.
    dispersions : Dispersions, optional
        What is uncertain.
    cases : int
        Number of dispersed cases.
    seed : int
        Seed of the dispersed cases.
    method : str
        Sampling of the dispersed cases: "plain", "sobol" or "latin", as of `draw`.
    probability : float
        Fraction of dispersed flights that the deflection is to cover.
    confidence : float
        Confidence with which it does.
    sizing : SizingRequest, optional
        What is asked of the whole flight.
    availability : AvailabilityRequest, optional
        An archive of soundings: on how many days it flies.
    load : LoadBound, optional
        What the structure bears.
    document : Document, optional
        Project, author, date and revision, for the head of its page.

    Raises
    ------
    InputError
        As `Case`, and for an ensemble of winds.
    """

    wind: ShapedWind | History = DEFAULT_WIND
    dead_band: float = quantity("number", 1.0, between(0.0, 1.0))
    switch: str = word(SWITCHES, "literal")
    laws: LawsRequest | None = None
    criteria: Criteria | None = None
    dispersions: Dispersions | None = None
    cases: int = count(2000)
    seed: int = count(0)
    method: str = word(METHODS, "plain")
    probability: float = quantity("number", 0.99865, fraction)
    confidence: float = quantity("number", 0.9, fraction)
    sizing: SizingRequest | None = None
    availability: AvailabilityRequest | None = None
    load: LoadBound | None = None
    document: Document | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.wind, History):
            pulse_of(self)
        self._check_parts()

    def _check_parts(self) -> None:
        """What may be asked besides; its kinds are imported only where something is."""
        if self.document is not None:
            instance("document", self.document, Document, "for the head of the page")
        names = ("laws", "criteria", "dispersions", "sizing", "availability", "load")
        if all(getattr(self, name) is None for name in names):
            return
        from tvclin.answers.availability.request import AvailabilityRequest
        from tvclin.answers.campaign.dispersions import Dispersions
        from tvclin.answers.load import LoadBound
        from tvclin.answers.sizing.request import SizingRequest
        from tvclin.answers.trials import LawsRequest
        from tvclin.control.margins.criteria import Criteria

        kinds = LawsRequest, Criteria, Dispersions, SizingRequest, AvailabilityRequest, LoadBound
        makers = (
            "of the standard laws",
            "see Criteria.custom",
            "of Dispersion values",
            "see load_sizing",
            "see load_study",
            "of one bound",
        )
        for name, kind, maker in zip(names, kinds, makers, strict=True):
            if getattr(self, name) is not None:
                instance(name, getattr(self, name), kind, maker)
        if self.criteria is not None and self.criteria.has_mode_limits and not self._modes:
            raise InputError(
                "mode_gain_margin_dB and mode_phase_margin_deg are asked of modes: the vehicle"
                " needs [[bending]] or [[slosh]] in its file"
            )

    @property
    def held_to(self) -> Criteria:
        """What margins are held to: the classic criteria where nothing is said."""
        from tvclin.control.margins.criteria import CRITERIA

        return self.criteria or CRITERIA["classic"]

    @property
    def _modes(self) -> bool:
        own = self.vehicle.structure
        return own is not None and bool(own.bending or own.slosh)

    @classmethod
    def of_study(cls, study: Study) -> Self:
        """Return the plan of a study that has been made."""
        instance("study", study, Study, "see Study.from_vehicle")
        case: Any = {one.name: getattr(study.case, one.name) for one in fields(Case)}
        asked: Any = {name: getattr(study, name) for name in ("dead_band", "switch")}
        return cls(**case, **asked)

    def study(self) -> Study:
        """Return the study; raise `InputError` as `Study.of`."""
        return Study.of(self, self.dead_band, self.switch)
