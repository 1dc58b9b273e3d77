"""What a campaign is: one frozen value that says everything its numbers depend on."""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from tvclin.answers.campaign.dispersions import DEFAULT_DISPERSIONS, Dispersions
from tvclin.answers.campaign.draws import METHODS
from tvclin.answers.campaign.flights import Flight
from tvclin.answers.campaign.structures import modes_nominal
from tvclin.base.errors import (
    InputError,
    between,
    different,
    fraction,
    instance,
    number,
    one_of,
    positive,
    shown,
    single,
    small_angle,
    whole_number,
)
from tvclin.base.tables import Table
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.rules import GainsAsked
from tvclin.linear.models import MODELS, USUAL_MODEL
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.structure import Structure
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.shaped import ShapedWind, WindEnsemble

OUTPUTS = ("required", "forecast-free", "minimum", "margins", "flight", "flown")
CAMPAIGN_TABLE = Table(
    "[campaign]",
    {"until": "part"},
    words=("vehicle", "structure", "model", "plane", "cases", "seed", "method", "chunk"),
)
OUTPUTS_TABLE = Table("[outputs]", lists=("names", "dead_bands"))
QUESTION_TABLE = Table("[question]", {"limit": "angle"}, words=("probability", "confidence"))
_MOST_CASES = 10**10
_MOST_LATIN_CASES = 10**7


@dataclass(frozen=True, kw_only=True)
class Campaign:
    """Many dispersed cases of one vehicle, to be run chunk by chunk.

    Attributes
    ----------
    vehicle : Vehicle
        The nominal vehicle, one.
    wind : ShapedWind or WindEnsemble
        Its winds.
    structure : Structure, optional
        What bends and sloshes in the vehicle: for "margins" and "flight"; all else is of the rigid
        one.
    gains : GainsAsked, optional
        The autopilot of "margins", designed on the nominal rigid vehicle; its filters stand in the
        law of "flight" too.
    dispersions : Dispersions
        What is uncertain; the default ones are assumed, not any programme's.
    cases : int
        How many cases at most.
    seed : int
        Case i is drawn from the seed and i alone.
    model, plane : str
        Of the plant, as of `Plant.from_vehicle`.
    outputs : tuple of str
        What is computed for each case: "required" (`required_deflection` at each dead band),
        "forecast-free" (the least of any law without a forecast), "minimum" (appendix C),
        "margins" (whether the loop of the autopilot is stable, its margins, and the peak of each
        mode of a flexible vehicle),
        "flight" (what comes of flying it, as `flight` says), "flown" (the boundary at each dead
        band by flights with six degrees of freedom, some tenths of a second for each).
    dead_bands : tuple of float
        K of "required" and "flown", each in [0, 1].
    method : str
        How cases are drawn: "plain", "sobol" or "latin", as of `draw`.
    chunk : int
        Cases in one file.
    limit : float, optional
        A capability [rad] to be judged.
    probability, confidence : float
        Of the deflection asked for, as of `quantile_bound`.
    flight : Flight, optional
        How every case is flown; needed for the output "flight".
    until : float, optional
        Stop when both bounds of the first output lie within this part of its quantile.

    Raises
    ------
    InputError
        For numbers out of range, unknown names, and a parameter that is dispersed but has no
        nominal value.
    """

    vehicle: Vehicle
    wind: ShapedWind | WindEnsemble
    structure: Structure | None = None
    gains: GainsAsked | None = None
    dispersions: Dispersions = DEFAULT_DISPERSIONS
    cases: int
    seed: int = 0
    model: str = USUAL_MODEL
    plane: str = "pitch"
    outputs: tuple[str, ...] = ("required",)
    dead_bands: tuple[float, ...] = (1.0,)
    method: str = "plain"
    chunk: int = 1024
    limit: float | None = None
    probability: float = 0.99865
    confidence: float = 0.9
    flight: Flight | None = None
    until: float | None = None

    def __post_init__(self) -> None:
        instance("vehicle", self.vehicle, Vehicle, "see load_vehicle")
        single("vehicle", Coefficients.from_vehicle(self.vehicle, self.plane).batch)
        one_of("model", self.model, MODELS)
        if not isinstance(self.wind, ShapedWind | WindEnsemble):
            raise InputError(f"wind must be a ShapedWind or a WindEnsemble; got {shown(self.wind)}")
        if isinstance(self.wind, ShapedWind) and self.wind.heading is not None:
            raise InputError("a campaign is in one plane; give the part there, wind.in_plane(...)")
        instance("dispersions", self.dispersions, Dispersions, "of Dispersion values")
        if self.structure is not None:
            instance("structure", self.structure, Structure, "see load_structure")
            single("structure", self.structure.batch)
        if self.gains is not None:
            instance("gains", self.gains, GainsAsked, "or a rule for them")
        if self.flight is not None:
            instance("flight", self.flight, Flight, "which says how each case is flown")
        self._check_outputs()
        self._check_numbers()
        self.dispersions.apply(self.nominal, np.zeros((0, len(self.dispersions.each))))

    def _check_outputs(self) -> None:
        different("outputs", self.outputs)
        for name in self.outputs:
            one_of("outputs", name, OUTPUTS)
        if ("flight" in self.outputs) != (self.flight is not None):
            raise InputError('the output "flight" and a [flight] belong together: give both')
        if "margins" in self.outputs:
            self.autopilot()  # refuses a rule that cannot be
        different("dead_bands", self.dead_bands)
        bands = tuple(number("dead_bands", K, between(0.0, 1.0)) for K in self.dead_bands)
        object.__setattr__(self, "dead_bands", bands)

    def _check_numbers(self) -> None:
        one_of("method", self.method, METHODS)
        whole_number("seed", self.seed)
        for name in ("cases", "chunk"):
            if not 0 < whole_number(name, getattr(self, name)) <= _MOST_CASES:
                raise InputError(f"{name} must be from 1 to 1e10; got {shown(getattr(self, name))}")
        if self.method == "latin" and self.cases > _MOST_LATIN_CASES:
            raise InputError("a Latin hypercube is drawn as a whole: take at most 1e7 cases")
        for name in ("probability", "confidence"):
            fraction(name, getattr(self, name))
        for name, check in (("limit", small_angle("a deflection", positive)), ("until", positive)):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, number(name, getattr(self, name), check))

    @property
    def nominal(self) -> dict[str, Any]:
        """Nominal values [SI] of everything that can be dispersed here."""
        held = {f.name: getattr(self.vehicle, f.name) for f in fields(Vehicle)}
        held |= {"control_force_slope": self.vehicle.control_force}
        gains = {} if self.flight is None else self.flight.gains(self.plant)
        modes = {} if self.structure is None else modes_nominal(self.structure)
        return held | self.wind.nominal | gains | modes

    @property
    def plant(self) -> Plant:
        """The nominal plant, on which laws are designed."""
        return Plant.from_vehicle(self.vehicle, self.model, self.plane)

    def autopilot(self) -> Autopilot:
        """Return the autopilot of the margins: that asked for, or the canonical one."""
        return (self.gains or GainsAsked()).autopilot(self.plant)

    @property
    def chunks(self) -> int:
        """How many chunks make up all cases."""
        return -(-self.cases // self.chunk)

    def span(self, chunk: int) -> tuple[int, int]:
        """Return the first case of a chunk and how many it has."""
        if whole_number("chunk", chunk) >= self.chunks:
            raise InputError(f"chunk must be below {self.chunks}; got {shown(chunk)}")
        first = chunk * self.chunk
        return first, min(self.chunk, self.cases - first)


def checkpoints(chunks: int) -> Iterator[int]:
    """Yield after how many chunks it is asked whether the answer has converged.

    They grow by a tenth, so that asking costs no more than a part of the work.
    """
    end = 0
    while end < chunks:
        end = min(max(end + 1, end + end // 10), chunks)
        yield end
