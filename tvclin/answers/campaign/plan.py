"""What a campaign is: one frozen value that says everything its numbers depend on."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tvclin.answers.campaign.dispersions import DEFAULT_DISPERSIONS, Dispersions
from tvclin.answers.campaign.draws import METHODS
from tvclin.answers.campaign.structures import modes_nominal
from tvclin.answers.case import Case
from tvclin.answers.sizing.wind_sign import FROZEN, SIGNS, own_sign
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
    whole_number,
)
from tvclin.base.tables import FileTable
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.feedback import GAINS
from tvclin.control.laws.registry import AUTOPILOT, LAWS
from tvclin.linear.plant import Plant
from tvclin.vehicle.linear_vehicle import whole_vehicle
from tvclin.vehicle.vehicle import NUMBERS, Vehicle
from tvclin.winds.shaped import ShapedWind, WindEnsemble

OUTPUTS = ("required", "forecast-free", "minimum", "margins", "flight", "flown")
CAMPAIGN_TABLE = FileTable(
    "[campaign]",
    {"until": "part"},
    words=("vehicle", "model", "plane", "sign", "cases", "seed", "method", "chunk"),
)
OUTPUTS_TABLE = FileTable("[outputs]", words=("law",), lists=("names", "dead_bands"))
QUESTION_TABLE = FileTable("[question]", words=("probability", "confidence"))
_MOST_CASES = 10**10
_MOST_LATIN_CASES = 10**7


@dataclass(frozen=True, kw_only=True)
class Campaign(Case):
    """Many dispersed cases of one vehicle, to be run chunk by chunk: of a case, the nominal one.

    The structure of its vehicle counts for "margins" and "flight", and all else is of the rigid
    one. Autopilot and law are designed on the nominal rigid vehicle; the filters of the autopilot
    stand in every law, and its gains may be dispersed.

    Attributes
    ----------
    vehicle : Vehicle
        The nominal vehicle, one.
    wind : ShapedWind or WindEnsemble
        Its winds, in the plane.
    dispersions : Dispersions
        What is uncertain; the default ones are assumed, not any programme's.
    cases : int
        How many cases at most.
    seed : int
        Case i is drawn from the seed and i alone.
    outputs : tuple of str
        What is computed for each case: "required" (`required_deflection` at each dead band),
        "forecast-free" (the least of any law without a forecast), "minimum" (appendix C),
        "margins" (whether the loop of the autopilot is stable, its margins, and the peak of each
        mode of a flexible vehicle),
        "flight" (what comes of flying the law with its nozzle), "flown" (the boundary at each dead
        band by flights with six degrees of freedom, some tenths of a second for each).
    dead_bands : tuple of float
        K of "required" and "flown", each in [0, 1].
    method : str
        How cases are drawn: "plain", "sobol" or "latin", as of `draw`.
    chunk : int
        Cases in one file.
    probability, confidence : float
        Of the deflection asked for, as of `quantile_bound`.
    law : str
        The law of "flight", one of `LAWS`; "autopilot" is the autopilot of the case.
    sign : {"head", "tail", "frozen"}, optional
        Which sign of a wind along the path "required" counts, with the dynamic pressure met in it,
        or that of calm air; the worst of these without it. Winds of a file have their own.
    until : float, optional
        Stop when both bounds of the first output lie within this part of its quantile.

    Raises
    ------
    InputError
        As `Case`, for a wind with a direction or a stop of both planes, and for a parameter that is
        dispersed but has no nominal value.
    """

    vehicle: Vehicle
    wind: ShapedWind | WindEnsemble
    dispersions: Dispersions = DEFAULT_DISPERSIONS
    cases: int
    seed: int = 0
    outputs: tuple[str, ...] = ("required",)
    dead_bands: tuple[float, ...] = (1.0,)
    method: str = "plain"
    chunk: int = 1024
    probability: float = 0.99865
    confidence: float = 0.9
    law: str = AUTOPILOT
    sign: str | None = None
    until: float | None = None

    def __post_init__(self) -> None:
        instance("vehicle", whole_vehicle(self.vehicle, "a campaign"), Vehicle, "see load_vehicle")
        super().__post_init__()
        single("vehicle", self.vehicle.batch)
        if not isinstance(self.wind, ShapedWind | WindEnsemble):
            raise InputError(f"wind must be a ShapedWind or a WindEnsemble; got {shown(self.wind)}")
        if self.nozzle.stop is not None or getattr(self.wind, "heading", None) is not None:
            raise InputError("a campaign is in one plane; give the part there, wind.in_plane(...)")
        instance("dispersions", self.dispersions, Dispersions, "of Dispersion values")
        self._check_outputs()
        self._check_numbers()
        self.dispersions.apply(self.nominal, np.zeros((0, len(self.dispersions.each))))

    def _check_outputs(self) -> None:
        different("outputs", self.outputs)
        for name in self.outputs:
            one_of("outputs", name, OUTPUTS)
        if one_of("law", self.law, LAWS) != AUTOPILOT and "flight" not in self.outputs:
            raise InputError(
                'a law is flown by the output "flight"; add that, or leave out the law'
            )
        if "flight" in self.outputs and self.nozzle.limit is None:
            raise InputError('the output "flight" needs the limit of the nozzle: limit_deg')
        if self.sign is not None:
            one_of("sign", self.sign, (*SIGNS, FROZEN))
            if isinstance(self.wind, WindEnsemble):
                own_sign(self.sign)
        _ = self.gains  # refuses a rule that cannot be
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
        if self.until is not None:
            object.__setattr__(self, "until", number("until", self.until, positive))

    @property
    def nominal(self) -> dict[str, Any]:
        """Nominal values [SI] of everything that can be dispersed here."""
        held: dict[str, Any] = {name: getattr(self.vehicle, name) for name in NUMBERS}
        held |= {"control_force_slope": self.vehicle.control_force}
        structure = self.vehicle.structure
        modes = {} if structure is None else modes_nominal(structure)
        return held | self.wind.nominal | self.gains | modes

    @property
    def gains(self) -> dict[str, float]:
        """The nominal gains of the autopilot; nothing where no output depends on them."""
        flown = "flight" in self.outputs and self.law == AUTOPILOT
        if not flown and "margins" not in self.outputs:
            return {}
        return {name: float(getattr(self.autopilot, name)) for name in GAINS}

    @property
    def rigid_plant(self) -> Plant:
        """The nominal plant without structure, on which laws are designed."""
        return Plant.from_vehicle(self.vehicle, self.model, self.plane)

    @cached_property
    def autopilot(self) -> Autopilot:
        """The autopilot, designed on `rigid_plant`."""
        return self.asked.autopilot(self.rigid_plant, self.nozzle.actuator)

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
