"""Records as documents for JSON."""

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from tvclin.base.errors import plain as plain_number


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
