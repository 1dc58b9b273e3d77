"""The plan of a study file: a frozen value of its inputs, and the head of its page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from datetime import date
from typing import TYPE_CHECKING, Any, Self

from tvclin.base.errors import InputError, between, fraction, instance
from tvclin.base.fields import checked, count, file_table, quantity, text, word
from tvclin.case.case import DEFAULT_WIND, Case
from tvclin.ensembles.dispersions import METHODS
from tvclin.linear.deflections import SWITCHES
from tvclin.requirement.case_requirement import pulse_of
from tvclin.requirement.study import Study
from tvclin.winds.histories import History, VehicleWind
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.soundings.sounding_files import NO_READING, SoundingReading

if TYPE_CHECKING:
    from tvclin.case.load import LoadBound
    from tvclin.case.turbulence import TurbulenceRequest
    from tvclin.control.margins.criteria import Criteria
    from tvclin.design.standard_trials import LawsRequest
    from tvclin.ensembles.availability.availability import AvailabilityRequest
    from tvclin.ensembles.dispersions import Dispersions
    from tvclin.requirement.flight.request import SizingRequest


@dataclass(frozen=True, kw_only=True)
class Document:
    """The head of a page: project, author, date and revision. No number depends on it.

    Attributes
    ----------
    project, author, date, revision : str
        Text at the head of the page; empty where nothing is given.
    """

    project: str = text("")
    author: str = text("")
    date: str = text("")
    revision: str = text("")

    def __post_init__(self) -> None:
        """Check the fields by their specifications."""
        checked(self)

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> Self:
        """Return the head of a page from a table [document]; its date may be one of TOML.

        `InputError` for an unknown key, and a value that is no text.
        """
        values = DOCUMENT_TABLE.read(table)
        if isinstance(values.get("date"), date):
            values["date"] = values["date"].isoformat()
        return cls(**values)


DOCUMENT_TABLE = file_table("[document]", Document)


@dataclass(frozen=True, kw_only=True)
class StudyPlan(Case):
    """Specification of a study and its page: a case, with the requests about it.

    The structure of the vehicle counts for the margins and flights of the autopilot and of laws;
    boundaries are for the rigid vehicle.

    Attributes
    ----------
    dead_band : float
        Dead band K of the verdict, from 0 to 1; only 1 needs no forecast of the wind.
    switch : str
        Exit of the dead band in the boundaries shown: on trim (literal) or on the wind (report).
    laws : LawsRequest, optional
        Laws to be flown.
    criteria : Criteria, optional
        Criteria for the margins.
    dispersions : Dispersions, optional
        Uncertain parameters.
    cases : int
        Number of dispersed cases.
    seed : int
        Seed of the dispersed cases.
    method : str
        Sampling of the dispersed cases: "plain", "sobol" or "latin"; see `draw`.
    probability : float
        Fraction of dispersed flights that the deflection is to cover.
    confidence : float
        Confidence of each bound of that deflection.
    sizing : SizingRequest, optional
        Sizing of the whole flight.
    availability : AvailabilityRequest, optional
        Archive of soundings, for the fraction of days on which the case flies.
    load : LoadBound, optional
        Bound of the load on the structure.
    turbulence : TurbulenceRequest, optional
        Turbulence on top of the wind, for the autopilot.
    reading : SoundingReading
        Format, units, window and bias of soundings.
    document : Document, optional
        Project, author, date and revision, for the head of its page.

    Raises
    ------
    InputError
        As `Case`, and for an ensemble of winds.
    """

    wind: ShapedWind | VehicleWind | History = DEFAULT_WIND
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
    turbulence: TurbulenceRequest | None = None
    reading: SoundingReading = NO_READING
    document: Document | None = None

    def __post_init__(self) -> None:
        """Check the fields, and that the parts of the plan suit each other."""
        super().__post_init__()
        if not isinstance(self.wind, VehicleWind | History):
            pulse_of(self)  # raises for a wind of another type
        instance("reading", self.reading, SoundingReading, "of the table [sounding]")
        self._check_parts()

    def _check_parts(self) -> None:
        """Raise `InputError` for requests of another type; their modules are imported on use.

        Criteria of modes also need a vehicle with bending or slosh.
        """
        if self.document is not None:
            instance("document", self.document, Document, "for the head of the page")
        names = ("laws", "criteria", "dispersions", "sizing", "availability", "load", "turbulence")
        if all(getattr(self, name) is None for name in names):
            return
        from tvclin.case.load import LoadBound
        from tvclin.case.turbulence import TurbulenceRequest
        from tvclin.control.margins.criteria import Criteria
        from tvclin.design.standard_trials import LawsRequest
        from tvclin.ensembles.availability.availability import AvailabilityRequest
        from tvclin.ensembles.dispersions import Dispersions
        from tvclin.requirement.flight.request import SizingRequest

        types = (
            (LawsRequest, "of the standard laws"),
            (Criteria, "see Criteria.custom"),
            (Dispersions, "of Dispersion values"),
            (SizingRequest, "see load_sizing"),
            (AvailabilityRequest, "see load_study"),
            (LoadBound, "of one bound"),
            (TurbulenceRequest, "of an intensity or a severity"),
        )
        for name, (type_, hint) in zip(names, types, strict=True):
            if getattr(self, name) is not None:
                instance(name, getattr(self, name), type_, hint)
        if self.criteria is not None and self.criteria.has_mode_limits and not self._modes:
            raise InputError(
                "mode_gain_margin_dB and mode_phase_margin_deg are criteria of modes: the vehicle"
                " needs [[bending]] or [[slosh]] in its file"
            )

    @property
    def margin_criteria(self) -> Criteria:
        """Criteria for the margins; the classic criteria by default."""
        from tvclin.control.margins.criteria import CRITERIA

        return self.criteria or CRITERIA["classic"]

    @property
    def omitted_structure(self) -> str:
        """Why answers along the flight omit the structure of the vehicle; empty if they do not."""
        vehicle, sizing = self.vehicle, self.sizing
        if sizing is None or vehicle.structure is None or sizing.schedule.structure is not None:
            return ""
        return (
            "the vehicle has a structure, and its flight none, so that the loop is rigid along it"
            " (structure in [schedule] gives modes over the flight, rigid in [study] omits them)"
        )

    @property
    def _modes(self) -> bool:
        """Whether the vehicle has bending or slosh modes."""
        if self.sizing is not None and self.sizing.schedule.structure is not None:
            return True
        structure = self.vehicle.structure
        return structure is not None and bool(structure.bending or structure.slosh)

    @classmethod
    def of_study(cls, study: Study) -> Self:
        """Return the plan of a finished study."""
        instance("study", study, Study, "see Study.from_vehicle")
        case: Any = {field.name: getattr(study.case, field.name) for field in fields(Case)}
        options: Any = {name: getattr(study, name) for name in ("dead_band", "switch")}
        return cls(**case, **options)

    def study(self) -> Study:
        """Return the study of the plan; `InputError` where its wind or vehicle allows none."""
        return Study.of(self, self.dead_band, self.switch)


def named_vehicle(document: Mapping[str, Any]) -> Any:
    """Return the vehicle of [study] or [campaign] in a document: name, path or table; or None."""
    tables = (document.get(name, {}) for name in ("study", "campaign"))
    return next((keys["vehicle"] for keys in tables if "vehicle" in keys), None)


STUDY_TABLE = file_table(
    "[study]",
    StudyPlan,
    ("model", "plane", "dead_band", "switch", "sign"),
    quantities={"time": "time"},
    words=("vehicle", "rigid"),
)
