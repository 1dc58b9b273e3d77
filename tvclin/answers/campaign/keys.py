"""Keys of campaign and study files: how they carry units, and which ones a study's tables know."""

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import Any

from tvclin.base.errors import InputError, number, shown
from tvclin.base.units import UNITS

Units = dict[str, Mapping[str, float]]

SUBJECT = ("vehicle", "model", "plane")
"""What is studied: keys of [study], or of [campaign] where there is no [study]."""
PERCENT = 100.0

_ANGLE, _TIME = UNITS["angle"], UNITS["time"]
_DELAY = {"s": 1.0, "ms": 1e-3}
_PART = {"percent": 1.0 / PERCENT}

WORDS: dict[str, tuple[str, ...]] = {
    "study": (*SUBJECT, "dead_band", "switch"),
    "laws": ("names", "winds", "model"),
    "autopilot": ("design", "model"),
    "criteria": ("name",),
    "size": ("dead_bands", "model", "law", "varying", "count"),
}
"""Of each table that only studies read, the keys without a unit."""
QUANTITIES: dict[str, Units] = {
    "laws": {"sample_rate": {"Hz": 1.0}},
    "autopilot": {
        "natural_frequency": {"rad_per_s": 1.0},
        "damping": {"": 1.0},
        "attitude_gain": {"": 1.0},
        "rate_gain": {"s": 1.0},
        "alpha_gain": {"": 1.0},
        "integral_gain": {"per_s": 1.0},
        "actuator_frequency": {"rad_per_s": 1.0},
        "actuator_damping": {"": 1.0},
        "delay": _DELAY,
    },
    "criteria": {
        "aero_margin_dB": {"": 1.0},
        "gain_increase_dB": {"": 1.0},
        "phase_margin_deg": {"": 1.0},
        "delay_margin": _DELAY,
        "disk_margin": {"": 1.0},
        "peak_sensitivity": {"": 1.0},
        "peak_complementary_sensitivity": {"": 1.0},
    },
    "size": {
        "start": _TIME,
        "stop": _TIME,
        "every": _TIME,
        "window": _TIME,
        "peak_speed": UNITS["speed"],
        "dispersion": _PART,
        "thrust_offset": _ANGLE,
        "gravity_offset": UNITS["length"],
        "reserve": _PART,
    },
}
"""Of the same tables the numbers, with their units."""


def check_keys(document: Mapping[str, Any]) -> None:
    """Raise `InputError` for an unknown key in a table of `WORDS`, and offer the near ones."""
    for heading, words in WORDS.items():
        legal = (*words, *spellings(QUANTITIES.get(heading, {})))
        known(f"key in [{heading}]", document.get(heading, {}), legal)


def quantities_of(heading: str, table: dict[str, Any]) -> dict[str, float]:
    """Take the numbers of `QUANTITIES` that a table gives out of it, in SI units."""
    found = {
        name: quantity(f"[{heading}]", table, name, units, required=False)
        for name, units in QUANTITIES[heading].items()
    }
    return {name: value for name, value in found.items() if value is not None}


def quantity(
    where: str, table: dict[str, Any], name: str, units: Mapping[str, float], required: bool = True
) -> float | None:
    """Take a number with its unit in its key out of a table."""
    keys = dict(zip(spellings({name: units}), units.values(), strict=True))
    found = [key for key in keys if key in table]
    if len(found) > 1 or (required and not found):
        raise InputError(f"{where} must give {name} once, as {' or '.join(keys)}")
    return number(found[0], table.pop(found[0])) * keys[found[0]] if found else None


def known(what: str, given: Mapping[str, Any], names: Iterable[str]) -> None:
    """Raise `InputError` for a key that is not among the names, and offer the near ones."""
    legal = list(names)
    for key in given:
        if key not in legal:
            near = get_close_matches(key, legal, n=2, cutoff=0.5)
            hint = f"did you mean {' or '.join(near)}?" if near else f"known are {', '.join(legal)}"
            raise InputError(f"unknown {what}: {shown(key)}; {hint}")


def spellings(quantities: Mapping[str, Mapping[str, float]]) -> list[str]:
    """Return the keys of quantities, each with its unit."""
    return [f"{k}_{unit}" if unit else k for k, units in quantities.items() for unit in units]
