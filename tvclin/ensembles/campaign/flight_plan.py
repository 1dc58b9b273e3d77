"""Flights of a campaign along a whole flight: dispersed flights, autopilots and winds of cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from tvclin.ascent.measured_wind import MeasuredWind
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, each, instance
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.detuning import structure_with_mode_factors
from tvclin.control.autopilot.feedback import GAINS
from tvclin.control.autopilot.gain_schedule import GainSchedule, autopilot_along
from tvclin.ensembles.dispersions import Dispersions, is_mode_factor, mode_names
from tvclin.vehicle.structure import Structure
from tvclin.vehicle.vehicle import NUMBERS
from tvclin.winds.shaped import WindEnsemble


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
        super().__post_init__()
        each("soundings", self.soundings, MeasuredWind, "see fly_through")

    @classmethod
    def of(cls, soundings: Sequence[MeasuredWind]) -> Self:
        """Return the ensemble of soundings, each of `fly_through` for one plane, without a gust.

        Raises
        ------
        InputError
            For no sounding, another type, and a sounding with a gust.
        """
        winds = each("soundings", soundings, MeasuredWind, "see fly_through")
        if not winds:
            raise InputError("soundings must be one or more; got none")
        if any(wind.gust is not None for wind in winds):
            raise InputError("soundings of an ensemble must have no gust")
        time = np.unique(np.concatenate([wind.wind.time for wind in winds]))
        rows = [np.interp(time, wind.wind.time, wind.wind.angle, 0.0, 0.0) for wind in winds]
        return cls(time, np.stack(rows), winds)


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
        Ends of the flights [s], by default the onset of the wind and the end of the flight.

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
        instance("flight", self.flight, FlightSchedule, "see load_schedule")
        if not isinstance(self.autopilot, GainSchedule):
            instance("autopilot", self.autopilot, Autopilot, "or a GainSchedule")
        if self.law.sample_rate is None:
            raise InputError("flights of a campaign need samples: give the autopilot a sample_rate")
        self.flight.between(self.start, self.stop)

    @property
    def law(self) -> Autopilot:
        """Autopilot at the breakpoints of a schedule, or the autopilot of all times."""
        made = self.autopilot
        return made.autopilot if isinstance(made, GainSchedule) else made


def nominal_gains(plan: FlightPlan, time: float) -> dict[str, float]:
    """Return the nominal gains of a plan at a time of flight [s], by name."""
    law = autopilot_along(plan.autopilot, plan.flight, np.asarray(time))
    return {name: float(getattr(law, name)) for name in GAINS}


def dispersed_plan(
    plan: FlightPlan,
    dispersions: Dispersions,
    nominal: Mapping[str, Any],
    values: Mapping[str, float],
) -> FlightPlan:
    """Return the plan of a case.

    `nominal`, `values`: nominal and dispersed values of the parameters at the time of the vehicle
    of the campaign, by name.
    """
    relative = {d.parameter: d.relative for d in dispersions.distributions}

    def changed(name: str, base: Any) -> Any:
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
    modes = {name: values[name] for name in relative if is_mode_factor(name)}
    if modes:
        flight = _with_modes(flight, modes)
    gains = {name: changed(name, getattr(law, name)) for name in relative if name in GAINS}
    law, made = replace(law, **gains), plan.autopilot
    autopilot = replace(made, autopilot=law) if isinstance(made, GainSchedule) else law
    return replace(plan, flight=flight, autopilot=autopilot)


def _with_modes(flight: FlightSchedule, factors: Mapping[str, float]) -> FlightSchedule:
    """Return a flight with factors on its modes, by name as in `Dispersion`."""
    if flight.structure is None:
        raise InputError("factors on modes need a flight with a structure over time")
    made = flight.structure
    structure = structure_with_mode_factors(
        made.structure,
        *(mode_factors(made.structure, factors, number) for number in ("frequency", "damping")),
    )
    return replace(flight, structure=replace(made, structure=structure))


def mode_factors(structure: Structure | None, values: Mapping[str, Any], number: str) -> FloatArray:
    """Return the factors on frequencies or dampings of the modes, ``(..., modes)``.

    `values`: factors by name, as in `Dispersion`. `number`: "frequency" or "damping".
    """
    ones = np.ones(np.shape(next((v for k, v in values.items() if is_mode_factor(k)), 1.0)))
    return np.stack(
        [
            values.get(f"{kind}_{number}", 1.0) * values.get(f"{name}_{number}", ones)
            for kind, names in mode_names(structure).items()
            for name in names
        ],
        axis=-1,
    )
