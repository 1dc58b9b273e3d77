"""What a file says of the filters of an autopilot: [[autopilot.filter]], once for each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from tvclin.base.errors import InputError, naming, number, one_of, shown
from tvclin.base.tables import FileTable
from tvclin.vehicle.filters import Filter

PLACES = {"sum": "filters", "attitude": "attitude_filters", "rate": "rate_filters"}
"""What a filter may stand on, and the name of that chain in an `Autopilot`."""
_NEEDED = {
    "notch": ("frequency", "zero_damping", "pole_damping"),
    "low-pass": ("frequency",),
    "lead-lag": ("zero", "pole"),
    "rational": ("numerator", "denominator"),
}
_ALLOWED = _NEEDED | {"low-pass": ("frequency", "damping")}
_MAKERS: dict[str, Callable[..., Filter]] = {
    "notch": Filter.notch,
    "low-pass": Filter.low_pass,
    "lead-lag": Filter.lead_lag,
    "rational": Filter.from_coefficients,
}
FILTER_TABLE = FileTable(
    "[[autopilot.filter]]",
    {
        "frequency": "natural frequency",
        "damping": "number",
        "zero_damping": "number",
        "pole_damping": "number",
        "zero": "natural frequency",
        "pole": "natural frequency",
    },
    words=("kind", "on"),
    lists=("numerator", "denominator"),
    required=("kind",),
)


def filter_chains(rows: Sequence[Mapping[str, Any]]) -> dict[str, tuple[Filter, ...]]:
    """Return the filters of tables, by the names of the chains of an `Autopilot`.

    `InputError` for rows that are no tables, an unknown kind or place, and a key that is missing or
    that the kind does not take; it says of which filter.
    """
    chains: dict[str, list[Filter]] = {chain: [] for chain in PLACES.values()}
    for k, row in enumerate(rows, start=1):
        if not isinstance(row, Mapping):
            raise InputError(f"filter must be given as {FILTER_TABLE.heading}; got {shown(row)}")
        with naming(f"filter {k} of the autopilot"):
            place, made = _filter(row)
        chains[PLACES[place]].append(made)
    return {chain: tuple(filters) for chain, filters in chains.items()}


def _filter(row: Mapping[str, Any]) -> tuple[str, Filter]:
    found = FILTER_TABLE.read(row)
    place = one_of("on", found.pop("on", "sum"), PLACES)
    kind = one_of("kind", found.pop("kind"), _MAKERS)
    FILTER_TABLE.need(found, _NEEDED[kind])
    for name in found:
        if name not in _ALLOWED[kind]:
            raise InputError(f"a {kind} filter takes {', '.join(_ALLOWED[kind])}; got {name}")
    for name in ("numerator", "denominator"):
        if name in found:
            found[name] = [number(f"{name}[{k}]", one) for k, one in enumerate(found[name])]
    return place, _MAKERS[kind](**found)
