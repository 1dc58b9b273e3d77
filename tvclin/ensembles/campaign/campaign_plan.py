"""Specification of a campaign: all parameters on which its results depend.

Also of flights of dispersed vehicles along a whole flight: their autopilots and winds.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from tvclin.ascent.measured_wind import MeasuredWind
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.fields import count, file_table, quantity, word
from tvclin.boundary.limit_shapes import LIMIT_SHAPES
from tvclin.case.case import Case
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.detuning import structure_with_mode_factors
from tvclin.control.autopilot.feedback import GAINS
from tvclin.control.autopilot.gain_schedule import GainSchedule, autopilot_along
from tvclin.control.laws.autopilot_law import SaturatedLaw
from tvclin.control.laws.registry import AUTOPILOT, LAWS
from tvclin.ensembles.dispersions import (
    DEFAULT_DISPERSIONS,
    METHODS,
    Dispersions,
    is_mode_factor,
    mode_names,
    modes_nominal,
)
from tvclin.linear.plant import Plant
from tvclin.requirement.encountered_requirement import uses_encountered_pressure
from tvclin.vehicle.linear_vehicle import complete_vehicle
from tvclin.vehicle.structure import Structure
from tvclin.vehicle.vehicle import NUMBERS, Vehicle
from tvclin.winds.shaped import FixedWind, ShapedWind, WindEnsemble


@dataclass(frozen=True, eq=False)
class SoundingEnsemble(WindEnsemble):
    """Ensemble of soundings along a flight, from which each case draws one.

    `time`, `angle`: as in `WindEnsemble`, in flight time, zero where a sounding is not known.

    Attributes
    ----------
    soundings : tuple of MeasuredWind
        Soundings along the nominal flight, with their speeds.
    """

    soundings: tuple[MeasuredWind, ...] = ()

    def __post_init__(self) -> None:
        """Check the fields; `InputError` for a sounding of another type."""
        super().__post_init__()
        errors.each("soundings", self.soundings, MeasuredWind, "see fly_through")

    @classmethod
    def of(cls, soundings: Sequence[MeasuredWind]) -> Self:
        """Return the ensemble of n winds that a flight encounters in one plane, ``(n,)``.

        `soundings`: these winds, as `fly_through` returns them. Their angles [rad] are interpolated
        at the times of all. `InputError` for no wind, another type, and a wind with a gust.
        """
        winds = errors.each("soundings", soundings, MeasuredWind, "see fly_through")
        if not winds:
            raise errors.InputError("soundings must be one or more; got none")
        if any(wind.gust is not None for wind in winds):
            raise errors.InputError("soundings of an ensemble must have no gust")
        time = np.unique(np.concatenate([wind.wind.time for wind in winds]))
        angles = [  # [rad] at all times, zero where a sounding is not known
            np.interp(time, wind.wind.time, wind.wind.angle, left=0.0, right=0.0) for wind in winds
        ]
        return cls(time=time, angle=np.stack(angles), soundings=winds)


@dataclass(frozen=True, eq=False)
class FlightPlan:
    """Flight and autopilot of the output "flight" of a campaign, in place of a frozen vehicle.

    Attributes
    ----------
    flight : FlightSchedule
        Nominal flight, with its structure and actuator where it has them. A dispersed parameter
        with a relative spread has the same factor at all times, another the same difference;
        factors on modes as in `Dispersion`.
    autopilot : Autopilot or GainSchedule
        Autopilot with a sample rate, scheduled on the nominal flight, whose modes its notches
        follow.
    start, stop : float, optional
        Ends of the flights [s], by default the onset of the wind and the end of the flight. A
        sounding that is not known throughout is survived in no case.

    Raises
    ------
    InputError
        For another type, and an autopilot without a sample rate.
    """

    flight: FlightSchedule
    autopilot: Autopilot | GainSchedule
    start: float | None = None
    stop: float | None = None

    def __post_init__(self) -> None:
        """Check the fields; `InputError` as the class says."""
        errors.instance("flight", self.flight, FlightSchedule, "see load_schedule")
        if not isinstance(self.autopilot, GainSchedule):
            errors.instance("autopilot", self.autopilot, Autopilot, "or a GainSchedule")
        if self.law.sample_rate is None:
            raise errors.InputError(
                "flights of a campaign need samples: give the autopilot a sample_rate"
            )
        _ = self.span  # raises for times outside the flight

    @cached_property
    def span(self) -> tuple[float, float]:
        """First and last time of the flights [s], by default of the entire nominal flight."""
        return self.flight.between(self.start, self.stop).span

    @property
    def law(self) -> Autopilot:
        """Autopilot with its gains at the breakpoints of a schedule, or constant ones."""
        autopilot = self.autopilot
        return autopilot.autopilot if isinstance(autopilot, GainSchedule) else autopilot


def dispersed_flight(
    plan: FlightPlan,
    dispersions: Dispersions,
    nominal: Mapping[str, Any],
    values: Mapping[str, float],
) -> tuple[FlightSchedule, Autopilot | GainSchedule]:
    """Return the flight and the autopilot of one dispersed case.

    `plan`: nominal flight and autopilot. `dispersions`: dispersed parameters, and whether each is
    scaled or shifted. `nominal`, `values`: nominal and dispersed values [SI] at the time of the
    campaign's vehicle, by name. `InputError` for factors on modes of a flight without a structure.
    """
    relative = {d.parameter: d.relative for d in dispersions.distributions}

    def changed(name: str, base: Any) -> Any:
        """Return a number over the flight, scaled or shifted by the dispersion of the case.

        `name`: name of the parameter, which is scaled if it is `relative`. `base`: its nominal
        values over the flight [SI]. Factor and shift lead from `nominal` to the dispersed
        `values`, at the time of the campaign's vehicle.
        """
        centre = float(nominal[name])
        if relative[name]:
            return np.asarray(base) * (values[name] / centre)
        return np.asarray(base) + (values[name] - centre)

    flight, vehicle, law = plan.flight, plan.flight.vehicle, plan.law
    numbers = {name: getattr(vehicle, name) for name in NUMBERS}
    numbers["control_force_slope"] = vehicle.control_force
    changes = {name: changed(name, numbers[name]) for name in relative if name in numbers}
    if changes:
        flight = replace(flight, vehicle=vehicle.replace(**changes))
    factors = {name: values[name] for name in relative if is_mode_factor(name)}
    if factors:
        if flight.structure is None:
            raise errors.InputError("factors on modes need a flight with a structure over time")
        structure = flight.structure.structure
        frequencies = mode_factors(structure, factors, "frequency")
        dampings = mode_factors(structure, factors, "damping")
        structure = structure_with_mode_factors(structure, frequencies, dampings)
        flight = replace(flight, structure=replace(flight.structure, structure=structure))
    gains = {name: changed(name, getattr(law, name)) for name in relative if name in GAINS}
    if not gains:
        return flight, plan.autopilot
    law = replace(law, **gains)
    if isinstance(plan.autopilot, GainSchedule):
        return flight, replace(plan.autopilot, autopilot=law)
    return flight, law


def mode_factors(structure: Structure | None, values: Mapping[str, Any], number: str) -> FloatArray:
    """Return the factors on frequencies or dampings of the modes, ``(..., modes)``.

    `structure`: the modes, in whose order the factors are. `values`: factors by name, as in
    `Dispersion`. `number`: "frequency" or "damping".
    """
    # ones of the shape of a factor, ``(...)``, for modes that have none
    ones = np.ones(np.shape(next((v for k, v in values.items() if is_mode_factor(k)), 1.0)))
    return np.stack(
        [
            values.get(f"{kind}_{number}", 1.0) * values.get(f"{name}_{number}", ones)
            for kind, names in mode_names(structure).items()
            for name in names
        ],
        axis=-1,
    )


OUTPUTS = ("required", "forecast-free", "minimum", "margins", "flight", "flown")
_MAX_CASES = 10**10
"""Largest number of cases of a campaign."""
_MAX_LATIN_CASES = 10**7
"""Largest number of cases of a Latin hypercube, which is drawn at once."""


def _case_count(name: str, value: object) -> int:
    """Return a number of cases, `value`; `InputError` unless it is from 1 to `_MAX_CASES`.

    `name`: name of the argument in the error.
    """
    if 0 < (number := errors.whole_number(name, value)) <= _MAX_CASES:
        return number
    raise errors.InputError(f"{name} must be from 1 to 1e10; got {errors.shown(value)}")


@dataclass(frozen=True, kw_only=True)
class Campaign(Case):
    """Campaign of dispersed cases around a nominal case, to be run chunk by chunk.

    The structure of the vehicle counts for "margins" and "flight"; all other outputs are of the
    rigid vehicle. Autopilot and law are designed on the nominal rigid vehicle; the filters of the
    autopilot stand in every law, and its gains may be dispersed. A `controller` is the same in all
    cases.

    With a limit of both planes, which needs a wind with a direction, both are judged: autopilot and
    law are designed in each, and there are columns of each plane and of both. "margins" are
    the margins in `plane`.

    Attributes
    ----------
    vehicle : Vehicle
        The nominal vehicle, no batch.
    wind : ShapedWind, FixedWind or WindEnsemble
        The wind or winds, in the plane, or with a direction and a limit of both planes. A gust
        without a time is placed where the nominal vehicle requires most at the first of
        `dead_bands`, as in a study, and keeps its time from the middle of the wind in all cases.
    dispersions : Dispersions
        Uncertain parameters; the default dispersions are assumed, not any programme's.
    cases : int
        Largest number of cases.
    seed : int
        Case i is drawn from the seed and i alone.
    outputs : tuple of str
        Outputs computed for each case: "required" (`required_deflection` at each dead band),
        "forecast-free" (the lower bound without a forecast), "minimum" (of appendix C),
        "margins" (whether the loop of the autopilot is stable, its margins, and the peak of each
        mode of a flexible vehicle),
        "flight" (survival and peaks of a flight of the law with its nozzle), "flown" (the boundary
        at each dead band by flights with six degrees of freedom, some tenths of a second for each).
    dead_bands : tuple of float
        Dead bands K of "required" and "flown", each from 0 to 1.
    method : str
        Method of drawing cases: "plain", "sobol" or "latin". `draw` has more on each.
    chunk : int
        Cases in one file.
    probability : float
        Fraction of all flights that the quantile of the deflection is to cover.
    confidence : float
        Confidence of each bound of that quantile.
    law : str
        Law of the output "flight": autopilot (of the case), trim, dead-band, half-relief or
        recoverable-attitude.
    along : FlightPlan, optional
        Whole flight and its autopilot, along which the output "flight" is flown at the dynamic
        pressure encountered, in place of the frozen vehicle. A shaped wind has its peak at the time
        of the vehicle, and comes as head and tail wind unless its direction is known: the worse
        counts. Winds of an ensemble are in flight time.
    until : float, optional
        End the campaign when both bounds of the first output lie within this fraction of its
        quantile.

    Raises
    ------
    InputError
        Same exceptions as `Case`; also for a limit of both planes without a wind with a direction,
        a wind without a component in the plane, and a dispersed parameter without a nominal value.
    """

    vehicle: Vehicle
    wind: ShapedWind | FixedWind | WindEnsemble
    dispersions: Dispersions = DEFAULT_DISPERSIONS
    cases: int = count(check=_case_count)
    seed: int = count(0)
    outputs: tuple[str, ...] = word(OUTPUTS, ("required",), many=True)
    dead_bands: tuple[float, ...] = quantity("number", (1.0,), errors.between(0.0, 1.0), many=True)
    method: str = word(METHODS, "plain")
    chunk: int = count(1024, _case_count)
    probability: float = quantity("number", 0.99865, errors.fraction)
    confidence: float = quantity("number", 0.9, errors.fraction)
    law: str = word(LAWS, AUTOPILOT)
    along: FlightPlan | None = None
    until: float | None = quantity("part", None, errors.positive)

    def __post_init__(self) -> None:
        """Check the fields, and place a gust without a time; `InputError` as the class says."""
        errors.instance(
            "vehicle", complete_vehicle(self.vehicle, "a campaign"), Vehicle, "see load_vehicle"
        )
        super().__post_init__()
        if self.plant_system is not None:
            raise errors.InputError(
                "a campaign takes no plant_system, whose matrices are one vehicle; leave it out"
            )
        errors.single("vehicle", self.vehicle.batch)
        if not isinstance(self.wind, ShapedWind | FixedWind | WindEnsemble):
            raise errors.InputError(
                f"wind must be a ShapedWind or a WindEnsemble; got {errors.shown(self.wind)}"
            )
        self._check_planes()
        if isinstance(self.wind, ShapedWind) and self.wind.gust is not None:
            object.__setattr__(self, "wind", self.wind_at(self.dead_bands[0]))
        errors.instance("dispersions", self.dispersions, Dispersions, "of Dispersion values")
        self._check_outputs()
        if self.method == "latin" and self.cases > _MAX_LATIN_CASES:
            raise errors.InputError("a Latin hypercube is drawn as a whole: take at most 1e7 cases")
        # no cases: refuses a dispersed parameter that has no nominal value, or zero
        self.dispersions.apply(self.nominal, np.zeros((0, len(self.dispersions.distributions))))

    def _check_planes(self) -> None:
        """Raise `InputError` for a wind, a limit shape and outputs that do not fit together."""
        if self.nozzle.limit_shape is None:
            if isinstance(self.wind, ShapedWind) and self.heading is not None:
                # refuse a wind without a part in the plane, and a sign beside a direction
                self.wind.in_plane(self.plane, float(np.asarray(self.vehicle.attitude)))
                self.directions()
            return
        if self.heading is None:
            raise errors.InputError(
                "a limit of both planes needs a wind with a direction: give where it blows from,"
                " direction_deg in [wind], and the direction of flight, azimuth_deg"
            )
        errors.one_of("limit_shape of a campaign", self.nozzle.limit_shape, LIMIT_SHAPES)
        self.directions()
        if "flown" in self.outputs:
            raise errors.InputError(
                'the output "flown" is of one plane: leave it out, or the limit of both planes'
            )
        _ = self.plane_campaigns  # refuses a wind without a part in the plane

    @cached_property
    def plane_campaigns(self) -> dict[str, Self]:
        """Campaigns by plane, for planes with wind; this campaign itself without a limit shape.

        Each has the limit of one plane, without the shape of both. `InputError` for a wind without
        a component in `plane`.
        """
        if self.nozzle.limit_shape is None or not isinstance(self.wind, ShapedWind):
            return {self.plane: self}
        attitude = float(np.asarray(self.vehicle.attitude))
        nozzle = replace(self.nozzle, limit_shape=None)
        windy = [name for name, peak in self.wind.peaks(attitude).items() if peak]
        return {
            name: replace(self, plane=name, nozzle=nozzle, wind=self.wind.in_plane(name, attitude))
            for name in dict.fromkeys((self.plane, *windy))
        }

    def _check_outputs(self) -> None:
        """Raise `InputError` for outputs that lack a law, limit, sign or gains.

        `along`: flight with its autopilot, None for a single flight time. `controller`: autopilot
        in state space, in place of gains. Some results are not used: their computation raises.
        """
        if self.law != AUTOPILOT and "flight" not in self.outputs:
            raise errors.InputError(
                'a law is flown by the output "flight"; add that, or leave out the law'
            )
        if self.along is not None:
            self._check_along(self.along)
        if "flight" in self.outputs and self.nozzle.limit is None:
            raise errors.InputError('the output "flight" needs the limit of the nozzle: limit_deg')
        if not isinstance(self.wind, ShapedWind):
            uses_encountered_pressure(self.sign)  # refuses head and tail for a measured wind
        if self.controller is None:
            _ = self.gains  # refuses a design rule without a solution for the vehicle
        elif "flight" in self.outputs and self.law == AUTOPILOT:
            SaturatedLaw.of(self.autopilot)  # refuses an input that flights do not measure
        errors.different("dead_bands", self.dead_bands)

    def _check_along(self, plan: FlightPlan) -> None:
        """Raise `InputError` for outputs, vehicle and wind that do not fit to the flight of a plan.

        `plan`: the flight, its autopilot, and first and last time.
        """
        errors.instance("along", plan, FlightPlan, "of a flight and its autopilot")
        if "flight" not in self.outputs or "margins" in self.outputs or self.law != AUTOPILOT:
            raise errors.InputError(
                'a campaign along a flight has the output "flight", of its autopilot, and no'
                ' "margins" (see sweep)'
            )
        if self.controller is not None:
            raise errors.InputError("a controller in state space is of a single flight time")
        if self.nozzle.limit_shape is not None:
            raise errors.InputError(
                "a campaign along a flight is of one plane: leave out the limit shape"
            )
        if self.vehicle.time is None:
            raise errors.InputError("a campaign along a flight needs a vehicle with its time")
        plan.flight.at(self.vehicle.time)
        first, last = plan.span
        if isinstance(self.wind, SoundingEnsemble):
            for k, wind in enumerate(self.wind.soundings):
                if not max(first, wind.known[0]) < min(last, wind.known[1]):
                    raise errors.InputError(
                        f"sounding {k + 1} of {self.wind.count} must be known at times of the"
                        f" flight; it is known from {wind.known[0]:.6g} to {wind.known[1]:.6g} s"
                    )

    @cached_property
    def nominal(self) -> dict[str, Any]:
        """Nominal values [SI] of all parameters that can be dispersed, by name."""
        values: dict[str, Any] = {name: getattr(self.vehicle, name) for name in NUMBERS}
        values |= {"control_force_slope": self.vehicle.control_force}
        return values | self.wind.nominal | self.gains | modes_nominal(self.vehicle.structure)

    @property
    def gains(self) -> dict[str, float]:
        """The nominal gains of the autopilot by name; empty where no output depends on them.

        A controller has no gains by name.
        """
        if self.controller is not None:
            return {}
        flown = "flight" in self.outputs and self.law == AUTOPILOT
        if not flown and "margins" not in self.outputs:
            return {}
        if (plan := self.along) is None:
            autopilot = self.autopilot
        else:
            autopilot = autopilot_along(plan.autopilot, plan.flight, np.asarray(self.vehicle.time))
        return {name: float(getattr(autopilot, name)) for name in GAINS}

    @property
    def rigid_plant(self) -> Plant:
        """The nominal plant without structure, on which laws are designed."""
        return Plant.from_vehicle(self.vehicle, self.model, self.plane)

    @cached_property
    def autopilot(self) -> Autopilot:
        """The autopilot, designed on `rigid_plant`; with a controller, this controller."""
        if self.controller is not None:
            return super().autopilot
        return self.autopilot_design.autopilot(self.rigid_plant, self.nozzle.actuator)

    @property
    def chunks(self) -> int:
        """Number of chunks of all cases."""
        return -(-self.cases // self.chunk)  # rounded up

    def span(self, chunk: int) -> tuple[int, int]:
        """Return the number of the first case of a chunk, and how many cases it has.

        `chunk`: number of the chunk from zero; `InputError` if there is none of this number.
        """
        if errors.whole_number("chunk", chunk) >= self.chunks:
            raise errors.InputError(f"chunk must be below {self.chunks}; got {errors.shown(chunk)}")
        first = chunk * self.chunk
        return first, min(self.chunk, self.cases - first)


def checkpoints(chunks: int) -> Iterator[int]:
    """Yield the numbers of finished chunks after which convergence is checked.

    Each number is a tenth larger than the previous, so that checks cost a fraction of the work.
    `chunks`: number of chunks of the campaign, the last that is yielded.
    """
    end = 0
    while end < chunks:
        end = min(max(end + 1, end + end // 10), chunks)
        yield end


CAMPAIGN_TABLE = file_table(
    "[campaign]",
    Campaign,
    ("until", "model", "plane", "sign", "cases", "seed", "method", "chunk"),
    words=("vehicle", "along"),
    quantities={"time": "time"},
)
OUTPUTS_TABLE = file_table("[outputs]", Campaign, ("law", "dead_bands"), lists=("names",))
QUESTION_TABLE = file_table("[question]", Campaign, ("probability", "confidence"))
