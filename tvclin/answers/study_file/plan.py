"""What a study file asks for: one frozen value that says everything its numbers depend on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

from tvclin.answers.campaign.dispersions import Dispersions
from tvclin.answers.campaign.winds import ShapedWind
from tvclin.answers.study import SHAPES, Study
from tvclin.answers.trials import STANDARD_LAWS, standard_winds
from tvclin.base.errors import (
    InputError,
    between,
    different,
    fraction,
    instance,
    nonnegative,
    number,
    one_of,
    positive,
    whole_number,
)
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import GAINS
from tvclin.control.autopilot.rules import DESIGNS, designed_autopilot
from tvclin.control.margins.criteria import Criteria
from tvclin.linear.deflections import SWITCHES
from tvclin.linear.plant import MODELS, Plant
from tvclin.vehicle.coefficients import PLANES
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.histories import History

if TYPE_CHECKING:
    from tvclin.answers.study_file.sizing import SizingAsked

_RULE = ("natural_frequency", "damping")
DEFAULT_WIND = ShapedWind("triangular", float(np.radians(5.0)), 7.5)


@dataclass(frozen=True, kw_only=True)
class LawsAsked:
    """The laws that are to be flown, and in which winds.

    Attributes
    ----------
    names, winds : tuple of str
        Of `standard_laws` and `standard_winds`.
    sample_rate : float
        Samples of the laws in a second [Hz].
    model : str
        The model that they fly.
    """

    names: tuple[str, ...] = STANDARD_LAWS
    winds: tuple[str, ...] = ("triangle",)
    sample_rate: float = 50.0
    model: str = "drift-exact"

    def __post_init__(self) -> None:
        for what, given, known in (
            ("names", self.names, STANDARD_LAWS),
            ("winds", self.winds, tuple(standard_winds(1.0, 1.0))),
        ):
            for name in different(f"{what} of the laws", given):
                one_of(f"{what} of the laws", name, known)
        rate = number("sample rate of the laws", self.sample_rate, positive, "Hz")
        object.__setattr__(self, "sample_rate", rate)
        one_of("model of the laws", self.model, MODELS)


@dataclass(frozen=True, kw_only=True)
class GainsAsked:
    """The autopilot that is to be judged; the gains are given, or follow from a rule.

    Attributes
    ----------
    model : str
        The model that is controlled.
    design, natural_frequency, damping, attitude_gain, rate_gain, alpha_gain
        As of `designed_autopilot`.
    integral_gain : float
        On the integrated attitude [1/s].
    actuator_frequency, actuator_damping : float
        As of `designed_autopilot`.
    delay : float
        Between sensors and actuator [s].
    """

    model: str = "drift"
    design: str | None = None
    natural_frequency: float | None = None
    damping: float | None = None
    attitude_gain: float | None = None
    rate_gain: float | None = None
    alpha_gain: float | None = None
    integral_gain: float = 0.0
    actuator_frequency: float = 25.1
    actuator_damping: float = 0.7
    delay: float = 0.0

    def __post_init__(self) -> None:
        one_of("model of the autopilot", self.model, MODELS)
        if self.design is not None:
            one_of("design", self.design, DESIGNS)
        for name in ("actuator_frequency", "delay"):
            object.__setattr__(self, name, number(name, getattr(self, name), nonnegative))
        for name in (*_RULE, *GAINS, "actuator_damping"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, number(name, getattr(self, name)))

    def autopilot(self, plant: Plant) -> Autopilot:
        """Return the autopilot for a plant; raise `InputError` as `designed_autopilot`."""
        asked = {name: value for name, value in vars(self).items() if name != "model"}
        return designed_autopilot(plant, **asked)


_PARTS = {
    "gust": (History, "such as OneMinusCosineGust"),
    "laws": (LawsAsked, "of the standard laws"),
    "gains": (GainsAsked, "or a rule for them"),
    "criteria": (Criteria, "see Criteria.own"),
    "dispersions": (Dispersions, "of Dispersion values"),
}
"""What may be asked besides, and how to get it."""


@dataclass(frozen=True, kw_only=True)
class StudyPlan:
    """Everything that a study and its page depend on.

    Attributes
    ----------
    vehicle : Vehicle
        The vehicle, one.
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

    Raises
    ------
    InputError
        For numbers out of range, unknown names, and a wind that is not of one shape.
    """

    vehicle: Vehicle
    model: str = "fixed-path"
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

    def __post_init__(self) -> None:
        instance("vehicle", self.vehicle, Vehicle, "see load_vehicle")
        if not isinstance(self.wind, ShapedWind):
            raise InputError(
                "a study needs a wind of one shape: give shape, peak and duration in [wind]"
            )
        one_of("shape of the wind of a study", self.wind.shape, SHAPES)
        one_of("model", self.model, MODELS)
        one_of("plane", self.plane, PLANES)
        one_of("switch", self.switch, SWITCHES)
        number("dead_band", self.dead_band, between(0.0, 1.0))
        if self.limit is not None:
            number("limit", self.limit, positive, "rad")
        for name, (kind, maker) in _PARTS.items():
            if getattr(self, name) is not None:
                instance(name, getattr(self, name), kind, maker)
        if self.sizing is not None:
            from tvclin.answers.study_file.sizing import SizingAsked

            instance("sizing", self.sizing, SizingAsked, "see load_sizing")
        for name in ("cases", "seed"):
            whole_number(name, getattr(self, name))
        for name in ("probability", "confidence"):
            fraction(name, getattr(self, name))

    @classmethod
    def of_study(cls, study: Study) -> Self:
        """Return the plan of a study that has been made."""
        instance("study", study, Study, "see Study.from_vehicle")
        return cls(
            vehicle=study.vehicle,
            model=study.model,
            plane=study.plane,
            wind=ShapedWind(study.shape, float(study.wind.peak), float(study.wind.duration)),
            gust=study.gust,
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
            limit=self.limit,
            dead_band=self.dead_band,
            model=self.model,
            plane=self.plane,
            switch=self.switch,
        )
