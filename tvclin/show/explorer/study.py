"""The choices as a study file: `tvclin study` and `tvclin report` make the same numbers of it."""

import json
import re
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from tvclin.base.files import exists, write_new
from tvclin.control.laws.registry import AUTOPILOT
from tvclin.show.explorer.choices import HALF_RELIEF, Choices
from tvclin.vehicle.file import VEHICLE_TABLE
from tvclin.vehicle.vehicle import NUMBERS


def study_text(choices: Choices) -> str:
    """Return the text of a study file: vehicle, wind, limit, and the gains of a law that has some.

    The vehicle stands in it with all its numbers, without what bends and sloshes: the numbers are
    those of the panel, wherever the file is read.
    """
    c = choices
    name, numbers = c.vehicle.name, {key: getattr(c.vehicle, key) for key in NUMBERS}
    known = {key: float(value) for key, value in numbers.items() if value is not None}
    tables: dict[str, dict[str, Any]] = {
        "study": {"model": c.model, "plane": c.plane, "dead_band": c.dead_band},
        "study.vehicle": ({"name": name} if name else {}) | VEHICLE_TABLE.write(known),
        "wind": {"shape": c.shape, "peak_deg": _deg(c.peak), "duration_s": c.duration},
        "nozzle": {"limit_deg": _deg(c.limit)},
    }
    gains: dict[str, Any] = {}
    if c.law == AUTOPILOT and (c.attitude_gain or c.rate_gain):
        gains = {"attitude_gain": c.attitude_gain, "rate_gain_s": c.rate_gain}
    elif c.law == HALF_RELIEF:
        gains = {"design": "half-relief"}
    if gains:
        tables["autopilot"] = gains | {"delay_ms": _short(1e3 * c.delay)}
    return f"# Written by tvclin explore, where the law {c.law} was flown.\n" + "".join(
        f"\n[{heading}]\n"
        + "".join(f"{key} = {json.dumps(value)}\n" for key, value in table.items())
        for heading, table in tables.items()
    )


def write_study(choices: Choices, name: str) -> Path:
    """Write ``study-NAME.toml``, or with the next number that is free, and return its path.

    Raises
    ------
    InputError
        Where it cannot be written.
    """
    stem = re.sub(r"[^\w.-]+", "-", f"study-{Path(name).stem}")
    numbered = (f"{stem}{f'-{k}' if k > 1 else ''}.toml" for k in count(1))
    path = next(path for path in map(Path, numbered) if not exists(path))
    write_new(path, study_text(choices))
    return path.resolve()


def _deg(angle: float) -> float:
    return _short(float(np.degrees(angle)))


def _short(value: float) -> float:
    """A number as the panel shows it, without the rounding of its unit."""
    return float(f"{value:.12g}")
