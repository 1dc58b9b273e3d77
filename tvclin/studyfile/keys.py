"""All keys of study and vehicle files, each with its unit, default and line of help.

They come from the declarations of the tables and from the docstrings of the records that the
tables make.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from tvclin.ascent.schedule_file import FLIGHT_COLUMNS
from tvclin.base.fields import help_lines, parameters
from tvclin.base.lines import Table, listed, words
from tvclin.base.tables import FileTable
from tvclin.base.units import UNITS, written
from tvclin.case.nozzle import NozzleData
from tvclin.control.autopilot.design_rules import AutopilotDesign
from tvclin.control.autopilot.gain_table import COLUMN_PREFIX, FILTER_TABLE, GAIN_COLUMNS
from tvclin.control.laws.registry import LAWS
from tvclin.design.standard_trials import WINDS
from tvclin.ensembles.campaign.campaign_plan import OUTPUTS
from tvclin.ensembles.dispersions import Dispersion
from tvclin.studyfile.settings import STUDY_TABLES, VEHICLE_TABLES
from tvclin.vehicle.structure import Structure
from tvclin.vehicle.vehicle import Vehicle
from tvclin.winds.shaped import ShapedWind
from tvclin.winds.wind_file import SOUNDING_TABLE

_RECORDS = {
    "wind": ShapedWind,
    "gust": ShapedWind,
    "nozzle": NozzleData,
    "dispersion": Dispersion,
    "vehicle": Vehicle,
    "structure": Structure,
    "gains": AutopilotDesign,
}
"""Records with help on keys, by table, besides `FileTable.record`."""
_HELP = {
    "study.vehicle": "A vehicle of the package, or a vehicle file beside this one.",
    "study.rigid": "Whether the structure of the vehicle is omitted: true or false.",
    "study.time": "Time of flight, where the vehicle is a flight schedule.",
    "campaign.vehicle": "A vehicle of the package, or a vehicle file beside this one.",
    "campaign.time": "Time of flight, where the vehicle is a flight schedule.",
    "wind.peak": "Peak wind angle of attack.",
    "wind.duration": "Duration.",
    "wind.peak_speed": "Peak wind speed, in place of the angle.",
    "wind.direction": "Direction from which the wind blows, from north, clockwise.",
    "wind.azimuth": "Direction of flight, from north, clockwise.",
    "wind.file": "A file of sampled winds, for campaigns.",
    "wind.unit": f"Unit of the angles in that file: {listed(UNITS['angle'], 'or')}.",
    "wind.sounding": "A sounding in place of a pulse, beside this file.",
    "wind.above_ground": "Elevation of the site, for heights above the ground.",
    "wind.name": "Name of the sounding.",
    "wind.format": "Format of the sounding, as sounding.format; by default found from its content.",
    "wind.time": "Time of the sounding in a file of several, as 2024-02-15 12.",
    "wind.units": "Units of a table that names none, as ft,mph.",
    "gust.peak": "Peak wind angle of attack of the gust on top of the wind.",
    "gust.duration": "Duration of the gust.",
    "gust.peak_speed": "Peak wind speed of the gust, in place of the angle.",
    "gust.plateau": "Part of its duration at its peak.",
    "gust.peak_time": "Time of its peak in a pulse; by default that of the largest requirement.",
    "plant.system": "A .mat or .npz file of the plant of margins and flights.",
    "controller.system": "A .mat or .npz file of a controller, in place of gains.",
    "nozzle.actuator_frequency": "Natural frequency of the actuator; 0: no actuator.",
    "nozzle.actuator_damping": "Damping ratio of the actuator.",
    "nozzle.mass": "Mass that turns, for torque and power.",
    "nozzle.arm": "Distance of its centre of mass aft of the hinge.",
    "nozzle.inertia": "Moment of inertia about that centre.",
    "nozzle.limit_shape": "Limit in both planes: round, round-each-plane, square or square-45.",
    "turbulence.file": "A file of intensity and scale length over altitude, beside this one.",
    "turbulence.level": "Intensity and scale length at an altitude; a table for each level.",
    "autopilot.schedule": "CSV of gains and filters over the flight; its columns stand at the end.",
    "autopilot.filter.mode": "Bending mode of the flight that a notch follows.",
    "autopilot.filter.ratio": "Frequency of a notch over that of the mode that it follows.",
    "autopilot.filter.kind": "Kind of a filter: notch, low-pass, lead-lag or rational.",
    "autopilot.filter.on": "Signal of the filter: sum, attitude or rate.",
    "autopilot.filter.frequency": "Frequency of a notch or a low-pass filter.",
    "autopilot.filter.damping": "Damping ratio of a low-pass filter of second order.",
    "autopilot.filter.zero_damping": "Damping ratio of the zeros of a notch filter.",
    "autopilot.filter.pole_damping": "Damping ratio of the poles of a notch filter.",
    "autopilot.filter.zero": "Zero of a lead-lag filter.",
    "autopilot.filter.pole": "Pole of a lead-lag filter.",
    "autopilot.filter.numerator": "Coefficients of a rational filter, highest power first.",
    "autopilot.filter.denominator": "Coefficients of a rational filter, highest power first.",
    "size.dispersion": "Addition by dispersions to the requirement of the wind.",
    "size.reserve": "Part of the limit that stays unused.",
    "size.duty_law": f"Law that is flown for the duty of the nozzle: {listed(LAWS, 'or')}.",
    "size.count": "Column that enters the total, such as trim or K = 0.5.",
    "laws.names": "Names of the laws, of those in the default.",
    "laws.winds": f"Names of standard winds: {listed(map(repr, WINDS))}.",
    "availability.persistence": "Increase of the wind angle between balloon and launch.",
    "dispersion.parameter": "Key of the vehicle, wind_peak, wind_duration, a gain or a mode.",
    "criteria.name": "Standard set that the numbers change: classic or aircraft.",
    "criteria.aero_margin_dB": "Smallest gain margin down.",
    "criteria.gain_increase_dB": "Smallest gain margin up.",
    "criteria.phase_margin_deg": "Smallest phase margin.",
    "criteria.delay_margin": "Smallest delay margin.",
    "criteria.disk_margin": "Smallest disk margin.",
    "criteria.peak_sensitivity": "Largest peak of the sensitivity.",
    "criteria.peak_complementary_sensitivity": "Largest peak of the complementary sensitivity.",
    "criteria.mode_gain_margin_dB": "Smallest gain margin of each gain-stabilised mode.",
    "criteria.mode_phase_margin_deg": "Smallest phase margin of each phase-stabilised mode.",
    "schedule.structure": "Table of the structure at each flight time, beside this file.",
    "schedule.source": "Flight schedule (CSV), or a vehicle with a table [flight].",
    "availability.archive": "Station file of IGRA, folder of soundings, or a list of them.",
    "availability.station": "Station of the soundings.",
    "availability.in_order": "Whether the soundings of a file are in the order of time.",
    "availability.dates": "File of launch dates that count.",
    "availability.months": "Months that count, from 1 to 12.",
    "availability.years": "Years that count.",
    "availability.persistence_hours": "Time between balloon and launch, in hours.",
    "availability.utc_offset_hours": "Local time minus UTC, in hours.",
    "outputs.names": f"Outputs of a campaign: {listed(OUTPUTS)}.",
    "dispersion.part": "Spread as a fraction of the nominal value.",
    "dispersion.percent": "Spread in percent of the nominal value.",
    "correlation.between": "Two dispersed parameters.",
    "correlation.coefficient": "Coefficient of their correlation.",
    "vehicle.mass": "Mass, in place of the weight.",
    "vehicle.dynamic_pressure": "Dynamic pressure of the aerodynamic coefficients.",
    "vehicle.reference_area": "Reference area of the aerodynamic coefficients.",
    "vehicle.normal_force_coefficient_slope": "Normal force coefficient per angle of attack.",
    "vehicle.axial_force_coefficient": "Axial force coefficient.",
    "vehicle.pitch_damping_coefficient": "C_mq, negative, about the centre of gravity.",
    "vehicle.reference_length": "Reference length of C_mq.",
    "vehicle.jet_mass_flow": "Mass flow of the jet, for its damping.",
    "vehicle.inertia_rate": "Rate of the moment of inertia.",
    "vehicle.exit_arm": "Distance of the nozzle's exit aft of the centre of gravity.",
    "sensors.attitude_sensor_frequency": "Natural frequency of the lag of the attitude sensor.",
    "sensors.attitude_sensor_damping": "Damping ratio of that lag; without it of first order.",
    "sensors.rate_gyro_frequency": "Natural frequency of the lag of the rate gyro.",
    "sensors.rate_gyro_damping": "Damping ratio of that lag; without it of first order.",
    "bending.tank_displacements": "Displacements at the tanks, in the order of [[slosh]].",
    "bending.tank_slopes_per_m": "Slopes at the tanks, in the order of [[slosh]].",
    "bending.tank_slopes_per_ft": "Slopes at the tanks, in the order of [[slosh]].",
    "bending.tank_slopes_per_in": "Slopes at the tanks, in the order of [[slosh]].",
    "flight schedule.nominal_deflection": "Deflection of the nominal flight.",
    "flight schedule.altitude": "Altitude.",
    "flight schedule.actuator_frequency": "Natural frequency of the actuator; one in [nozzle]"
    " counts more.",
    "flight schedule.actuator_damping": "Damping ratio of the actuator.",
    "gains.time": "Time of flight, rising.",
    "gains.speed": "Speed, rising, in place of the time.",
    "gains.altitude": "Altitude, rising, in place of the time.",
    "gains.mach": "Mach number, rising, in place of the time.",
    "gains.dynamic_pressure": "Dynamic pressure, rising, in place of the time.",
    "coefficients.name": "Name of the vehicle.",
    "coefficients.mu_alpha": "Angular acceleration per angle of attack.",
    "coefficients.mu_delta": "Angular acceleration per deflection.",
    "coefficients.beta": "Square root of mu_alpha.",
    "coefficients.B": "Trim deflection per angle of attack.",
    "coefficients.damping": "Damping of the attitude rate.",
    "coefficients.velocity": "Speed, for lateral drift and acceleration.",
    **{
        f"coefficients.{name}": f"Coefficient {name} of the path."
        for name in ["C1", "C2", "b1", "b2", "q"]
    },
}
"""Help of keys that are no attribute of a record, or have another meaning in the file."""
_DEFAULTS = {
    "wind.shape": "triangular",
    "wind.peak": "5",
    "wind.duration": "7.5",
    "nozzle.actuator_frequency": "25.1",
    "nozzle.actuator_damping": "0.7",
    "criteria.name": "classic",
}
"""Defaults of keys that are no fields."""
_UNIT = re.compile(r" \[[^\]]+\]")
"""Unit in a docstring, as in "Time of flight [s]"."""
_SENTENCE = re.compile(r"(?<=[^A-Z])\.(?: |$)")
"""End of a sentence; a full stop after a capital belongs to a name."""


@dataclass(frozen=True)
class Key:
    """A key with its table, its other units, its default and its line of help."""

    name: str
    others: tuple[str, ...] = ()
    default: str = ""
    help: str = ""

    @property
    def meaning(self) -> str:
        """Line of help with the default and the other units."""
        default = self.default and f"default {self.default}"
        others = ", ".join(self.others)
        more = "; ".join(filter(None, (default, others and f"also in {others}")))
        return f"{self.help} ({more})" if more else self.help


@cache
def all_keys() -> tuple[Key, ...]:
    """Return all keys of study and vehicle files, in the order of the tables."""
    tables = STUDY_TABLES | VEHICLE_TABLES
    keys = [key for name, table in tables.items() for key in _keys(name, table)]
    names = [key.name for key in keys]
    # keys of a wind by soundings and of filters; some of them are keys of the tables above too
    extra = [*_keys("wind", SOUNDING_TABLE), *_keys("autopilot.filter", FILTER_TABLE)]
    return (*keys, *(key for key in extra if key.name not in names))


def key_tables() -> list[Table]:
    """Return a table of the keys of each table of a file; a key is named TABLE.KEY."""
    homes = dict.fromkeys(key.name.rpartition(".")[0] for key in all_keys())
    return [
        words(
            f"[{home}]",
            ["key", "meaning"],
            [[key.name, key.meaning] for key in all_keys() if key.name.rpartition(".")[0] == home],
        )
        for home in homes
    ]


def column_tables() -> list[Table]:
    """Return tables of the columns of CSV files: of a flight, of its structure, and of gains.

    A column is named by a key of a study file without its table: thrust_N, not vehicle.thrust_N;
    columns of a filter in a table of gains have the filter's number in place of its table.
    """
    # a schedule's vehicles have file and flight time as `numbers_from`, which is no column
    vehicle = [
        key
        for key in all_keys()
        if key.name.startswith("vehicle.") and key.name != "vehicle.numbers_from"
    ]
    others = [
        Key(".structure", help="File of the structure at each flight time, beside this one"),
        *_keys("flight schedule", FLIGHT_COLUMNS),
    ]
    structure = [
        Key(".time_s", help="Time of flight"),
        Key(".name", help="Name of the mode or tank, the same at each time"),
        Key(".keys of [[bending]]", help="As above, of a mode"),
        Key(".keys of [[slosh]]", help="As above, of a tank"),
    ]
    # only numbers of a filter vary along a flight; its words and lists stay in the study file
    numbers = FileTable(FILTER_TABLE.heading, FILTER_TABLE.quantities)
    filters = [
        replace(key, name=key.name.replace("autopilot.filter.", f".{COLUMN_PREFIX}N."))
        for key in _keys("autopilot.filter", numbers)
    ]
    schedule = "Columns of a flight schedule (CSV): a line for each time, time_s among them"
    modes = (
        "Columns of a table of the structure (CSV), schedule.structure: a line for each mode (modal"
        " mass) and each tank (mass) at each time"
    )
    gains = (
        "Columns of a table of gains (CSV), autopilot.schedule: one variable of the flight,"
        " attitude_gain and rate_gain_s; N: number of an [[autopilot.filter]], or mode of its notch"
    )
    return [
        words(caption, ["column", "meaning"], [[k.name.partition(".")[2], k.meaning] for k in keys])
        for caption, keys in (
            (schedule, [*vehicle, *others]),
            (modes, structure),
            (gains, [*_keys("gains", GAIN_COLUMNS), *filters]),
        )
    ]


def _keys(name: str, table: FileTable) -> Iterator[Key]:
    """Yield the keys of a table, each with help, unit and default; `name`: name of the table.

    A quantity in several units is one key, spelled with the first; angles are shown in degrees. The
    help is the first sentence on the attribute, without its unit, unless `_HELP` has another.
    """
    helps: dict[str, str] = {}
    specified: dict[str, Any] = {}
    for record in filter(None, (table.record, _RECORDS.get(name))):
        for kind in reversed(record.__mro__):
            helps |= help_lines(kind)
        specified |= parameters(record)
    for quantity in (*table.quantities, *table.words, *table.lists):
        full = f"{name}.{quantity}"
        if full == "autopilot.filter":  # a table with keys of its own
            continue
        field = table.fields.get(quantity, quantity)
        item = specified.get(field)
        spelled = [key for key, (of, _) in table.keys.items() if of == quantity]
        first = (spelled or [quantity])[0]  # key with the SI unit; a word has none
        if table.quantities.get(quantity, "").startswith("ang"):  # angle, angular rate
            first = first.replace("_rad", "_deg")
        default = _DEFAULTS.get(full, "")
        if not default and item is not None:
            default = _default(item, table.keys[first][1] if item.numeric and spelled else None)
        sentence = _HELP.get(full) or _SENTENCE.split(_UNIT.sub("", helps.get(field, "")))[0]
        others = tuple(written(k.removeprefix(quantity).strip("_")) for k in spelled if k != first)
        plain = sentence.replace("`", "").rstrip(".")
        yield Key(f"{name}.{first}", others=others, default=default, help=plain)


def _default(item: Any, factor: float | None) -> str:
    """Return the default of a field as text in the unit of its key; empty where there is none.

    `item`: the field, with its text `shown` if that stands for the default; `many`: whether it
    holds several values. `factor`: value in SI of that unit; None for a key without a unit.
    """
    if item.shown or item.default is None:
        return item.shown
    values = item.default if item.many else (item.default,)
    return ", ".join(
        f"{value / (factor or 1.0):g}" if factor or isinstance(value, float) else str(value)
        for value in values
    )
