"""The schedule of a specified autopilot along a flight, and its specification at a flight time."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tvclin.ascent.flight_variables import flight_variable
from tvclin.ascent.schedule import FlightSchedule
from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError
from tvclin.control.autopilot.actuator import Actuator
from tvclin.control.autopilot.autopilot import Autopilot
from tvclin.control.autopilot.design_rules import LEAST_NOZZLE, AutopilotDesign
from tvclin.control.autopilot.feedback import GAINS
from tvclin.control.autopilot.gain_schedule import GainSchedule
from tvclin.control.autopilot.gain_table import GainTable


def flight_autopilot(
    design: AutopilotDesign,
    flight: FlightSchedule,
    times: FloatArray,
    *,
    actuator: Actuator | None,
    model: str,
    plane: str,
) -> GainSchedule:
    """Return the schedule of a specified autopilot along a flight.

    Parameters
    ----------
    design : AutopilotDesign
        Gains over the flight, constant gains, or a rule, which is applied to the rigid vehicle at
        each of the times.
    flight : FlightSchedule
        The flight.
    times : ndarray
        Times of flight [s], rising, ``(n,)``, two or more: breakpoints of a rule.
    actuator : Actuator, optional
        Actuator of the nozzle; that of a flight that has one over time takes its place.
    model, plane
        Model and plane of the plants.

    Raises
    ------
    InputError
        For a rule that needs a wind, gains both over the flight and constant, and as
        `GainSchedule`.
    """
    table = design.schedule or GainTable()
    constant = replace(design, schedule=None)
    if table.gains:
        if not constant.unspecified:
            raise InputError("give a schedule of gains, or gains or a rule for them, not both")
        autopilot = Autopilot(**constant.options(actuator) | table.gains)
        return GainSchedule(table.breakpoints, autopilot, table.variable, table.notches)
    if design.design == LEAST_NOZZLE:
        raise InputError(
            f"design {LEAST_NOZZLE} is of one flight time: give --at, or a table of its gains, see"
            " minimum_gain_schedule in Python"
        )
    plants = flight.plants(times, model, plane)
    laws = [constant.autopilot(plants.case(k, plants.batch), actuator) for k in range(len(times))]
    gains: dict[str, Any] = {name: np.array([getattr(a, name) for a in laws]) for name in GAINS}
    return GainSchedule(np.asarray(times), replace(laws[0], **gains), notches=table.notches)


def design_at(design: AutopilotDesign, flight: FlightSchedule, time: float) -> AutopilotDesign:
    """Return the specification with the gains and notches of a flight time [s], constant."""
    table = design.schedule
    if table is None:
        return design
    constant = replace(design, schedule=None)
    notches = tuple(notch.at(flight, time) for notch in table.notches)
    constant = replace(constant, filters=(*design.filters, *notches))
    if not table.gains:
        return constant
    value = float(flight_variable(flight, table.variable, time))
    gains: dict[str, Any] = {
        k: float(np.interp(value, table.breakpoints, v)) for k, v in table.gains.items()
    }
    return replace(constant, **gains)
