"""Records as documents for JSON: their values by key, each in the unit of its key."""

import re
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from functools import reduce
from typing import Any

import numpy as np

from tvclin.base.errors import plain as plain_number

_IN_DEGREES = re.compile(r"(^|_)deg(_per_s2?|_s)?$")


def keyed(keys: str) -> Callable[[Any], dict[str, Any]]:
    """Return the method `as_dict` of a record, with values by keys as in `picked`."""

    def as_dict(record: Any) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON, angles in degrees."""
        return picked(record, keys)

    return as_dict


def picked(record: Any, keys: str) -> dict[str, Any]:
    """Return attributes of a record by the keys of a document.

    `record`: with angles in radians. `keys`: separated by blanks. Each key is an attribute, or one
    with its unit, "peak_deg", or names an attribute or a nested one,
    "required_deg=requirement.deflection"; in bars, "deflection_deg=|deflection|", it is an absolute
    value. A key in degrees is converted, also in a mapping, and a factor by a key in dB, unless the
    attribute itself has that unit in its name.
    """
    attributes = set(dir(record))
    document = {}
    for key in keys.split():
        name, elsewhere, path = key.partition("=")
        path = path or name
        while not elsewhere and path not in attributes and "_" in path:
            path = path.rpartition("_")[0]
        value = reduce(getattr, path.strip("|").split("."), record)
        if path.startswith("|") and value is not None:
            value = np.abs(value)
        if _IN_DEGREES.search(name) and not _IN_DEGREES.search(path):
            value = _degrees(value)
        elif name.endswith("_dB") and not path.endswith("_dB"):
            value = decibels(value)
        document[name] = {str(k): v for k, v in value.items()} if isinstance(value, dict) else value
    return document


def plain(value: Any) -> Any:
    """Return a value as JSON can hold it: a record as its document, or by its fields.

    Numbers that are not finite become None.
    """
    if hasattr(value, "as_dict"):
        value = value.as_dict()
    elif is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in fields(value)}
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, complex):
        return {"real": value.real, "imag": value.imag}
    return None if isinstance(value, float) and not np.isfinite(value) else value


def decibels(factor: Any) -> Any:
    """Return a positive factor on an amplitude in dB."""
    with np.errstate(divide="ignore"):
        return plain_number(20.0 * np.log10(np.asarray(factor)))


def degrees(value: Any) -> Any:
    """Return angles [rad], also complex ones, in degrees."""
    return np.degrees(1.0) * np.asarray(value) if np.iscomplexobj(value) else np.degrees(value)


def _degrees(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _degrees(angle) for name, angle in value.items()}
    return None if value is None else degrees(value)
