"""The choices as a study file: every command makes the same numbers of it."""

import json
import re
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from tvclin.base.errors import InputError
from tvclin.base.files import exists, write_new
from tvclin.control.autopilot.design_rules import CHAIN_OF_POSITION
from tvclin.show.explorer.choices import Choices
from tvclin.show.explorer.controls import plateau_of
from tvclin.vehicle.vehicle import Vehicle
from tvclin.vehicle.vehicle_file import vehicle_table
from tvclin.winds.shaped import ShapedWind

Table = dict[str, Any]


def study_text(choices: Choices, source: str | None = None) -> str:
    """Return the text of a study file with all choices but the law.

    A rigid vehicle is written with all its numbers; a flexible one, or one defined by its
    coefficients, is named by its source: `InputError` where it has none.
    """
    plan = choices.plan
    vehicle = plan.vehicle
    rigid = vehicle if isinstance(vehicle, Vehicle) and vehicle.structure is None else None
    named = rigid is None
    if named and source is None:
        raise InputError(
            "a vehicle that was made in Python stands in a study file without its structure:"
            " switch bending and slosh off, or explore a vehicle file"
        )
    question = {"model": plan.model, "plane": plan.plane, "dead_band": plan.dead_band}
    head = ({"vehicle": source} if named else {}) | question
    tables: list[tuple[str, Table]] = [
        ("[study]", head | ({"sign": plan.sign} if plan.sign else {})),
        *([] if rigid is None else [("[study.vehicle]", vehicle_table(rigid))]),
        *_wind(plan.wind),
        ("[nozzle]", _nozzle(choices)),
        *_autopilot(choices),
    ]
    return f"# Written by tvclin explore, where the law {choices.law} was flown.\n" + "".join(
        f"\n{heading}\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in table.items())
        for heading, table in tables
    )


def write_study(choices: Choices, name: str, source: str | None = None) -> Path:
    """Write ``study-NAME.toml``, numbered where that exists, and return its path."""
    text = study_text(choices, source)
    stem = re.sub(r"[^\w.-]+", "-", f"study-{Path(name).stem.removeprefix('study-')}")
    numbered = (f"{stem}{f'-{k}' if k > 1 else ''}.toml" for k in count(1))
    path = next(path for path in map(Path, numbered) if not exists(path))
    write_new(path, text)
    return path.resolve()


def _wind(wind: Any) -> list[tuple[str, Table]]:
    assert isinstance(wind, ShapedWind)
    peak = _peak(float(wind.peak), wind.speed)
    table: Table = {"shape": wind.shape, **peak, "duration_s": wind.duration}
    if wind.heading is not None:
        table |= {"direction_deg": _deg(wind.heading), "azimuth_deg": 0.0}
    gust = wind.gust
    if gust is None:
        return [("[wind]", table)]
    gust_table = {
        **_peak(float(gust.peak), wind.gust_speed),
        "duration_s": _short(float(gust.end - gust.onset)),
        "plateau_s": _short(plateau_of(gust)),
        "peak_time_s": wind.gust_at,
    }
    return [("[wind]", table), ("[gust]", _without_none(gust_table))]


def _peak(angle: float, speed: float | None) -> Table:
    """Return the peak of a wind or gust, by its speed [m/s] where it is known by that."""
    return {"peak_deg": _deg(angle)} if speed is None else {"peak_speed_m_per_s": speed}


def _nozzle(choices: Choices) -> Table:
    nozzle = choices.plan.nozzle
    servo = nozzle.actuator
    return _without_none(
        {
            "limit_deg": _deg(nozzle.limit),
            "stop": nozzle.stop,
            "rate_limit_deg_per_s": _deg(nozzle.rate_limit),
            "actuator_frequency_rad_per_s": servo.natural_frequency if servo else 0.0,
            "actuator_damping": servo.damping if servo else None,
        }
    )


def _autopilot(choices: Choices) -> list[tuple[str, Table]]:
    design = choices.plan.asked
    table = {
        "design": design.design,
        "natural_frequency_rad_per_s": design.natural_frequency,
        "damping": design.damping,
        "attitude_gain": design.attitude_gain,
        "rate_gain_s": design.rate_gain,
        "alpha_gain": design.alpha_gain,
        "integral_gain_per_s": design.integral_gain or None,
        "delay_ms": _short(1e3 * design.delay),
        "sample_rate_Hz": design.sample_rate,
    }
    filters = [
        {
            "kind": "rational",
            "numerator": filter_table.numerator.tolist(),
            "denominator": filter_table.denominator.tolist(),
            "on": position,
        }
        for position, chain in CHAIN_OF_POSITION.items()
        for filter_table in design.chains[chain]
    ]
    named = [("[[autopilot.filter]]", filter_table) for filter_table in filters]
    return [("[autopilot]", _without_none(table)), *named]


def _without_none(table: Table) -> Table:
    return {key: value for key, value in table.items() if value is not None}


def _deg(angle: float | None) -> float | None:
    return None if angle is None else _short(float(np.degrees(angle)))


def _short(value: float) -> float:
    """Return a number to twelve digits, as the panel shows it, without the rounding of its unit."""
    return float(f"{value:.12g}")
