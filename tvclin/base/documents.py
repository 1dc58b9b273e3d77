"""A record as a document that JSON can hold: its values by key, each in the unit of its key."""

import re
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from functools import reduce
from typing import Any

import numpy as np

from tvclin.base.errors import plain as plain_number

_IN_DEGREES = re.compile(r"(^|_)deg(_per_s2?|_s)?$")


def keyed(keys: str) -> Callable[[Any], dict[str, Any]]:
    """Return the method `as_dict` of a record, with values by keys as of `picked`."""

    def as_dict(record: Any) -> dict[str, Any]:
        """Return the record as the command line prints it as JSON, angles in degrees."""
        return picked(record, keys)

    return as_dict


def picked(record: Any, keys: str) -> dict[str, Any]:
    """Return attributes of a record by the keys of a document.

    `record`: holds angles in radians. `keys`: with blanks between. Each is an attribute, "status",
    or one with its unit, "peak_deg", or says which it is, of attributes too:
    "required_deg=requirement.deflection"; in bars, "deflection_deg=|deflection|", it is a size. A
    key in degrees is converted, each value of a mapping too, and a factor by a key in dB, unless
    the attribute itself has that unit in its name.
    """
    known = set(dir(record))
    found = {}
    for key in keys.split():
        name, elsewhere, path = key.partition("=")
        path = path or name
        while not elsewhere and path not in known and "_" in path:
            path = path.rpartition("_")[0]
        value = reduce(getattr, path.strip("|").split("."), record)
        if path.startswith("|") and value is not None:
            value = np.abs(value)
        if _IN_DEGREES.search(name) and not _IN_DEGREES.search(path):
            value = _degrees(value)
        elif name.endswith("_dB") and not path.endswith("_dB"):
            value = decibels(value)
        found[name] = {str(k): v for k, v in value.items()} if isinstance(value, dict) else value
    return found


def plain(value: Any) -> Any:
    """Return what JSON can hold of a value: a record as its document, or else by its fields.

    Numbers that do not exist become None.
    """
    if hasattr(value, "as_dict"):
        value = value.as_dict()
    elif is_dataclass(value):
        value = {one.name: getattr(value, one.name) for one in fields(value)}
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


def _degrees(value: Any) -> Any:
    if value is None:
        return None
    if isinstance(value, dict):
        return {name: _degrees(each) for name, each in value.items()}
    return np.degrees(1.0) * np.asarray(value) if np.iscomplexobj(value) else np.degrees(value)
