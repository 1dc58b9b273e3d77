"""TOML files of a synthetic wind: an envelope, the shear that builds up to it, and gusts on top."""

from __future__ import annotations

from typing import Any

import numpy as np

from tvclin.base.errors import InputError, finite
from tvclin.base.files import tables_of
from tvclin.base.tables import FileTable, known
from tvclin.base.text import Text
from tvclin.winds.soundings.levels import Found, Levels
from tvclin.winds.soundings.synthetic import add_gust, synthetic_profile

_WIND = FileTable(
    "[synthetic]",
    {
        **dict.fromkeys(("height", "thickness", "peak_height"), "length"),
        **dict.fromkeys(("speed", "change"), "speed"),
        "direction": "angle",
    },
)
_GUST = FileTable(
    "[[gust]]",
    {
        **dict.fromkeys(("base", "blend", "thickness"), "length"),
        "amplitude": "speed",
        "direction": "angle",
    },
)
HEADING = _WIND.heading


def soundings_in(text: Text) -> list[Found]:
    """Return the wind of [synthetic], with each [[gust]], as `synthetic_profile` and `add_gust`.

    Directions are those from which they blow.
    """
    return [Found(lambda: _read(text))]


def _read(text: Text) -> Levels:
    document = tables_of("\n".join(text.lines), text.source)
    known(f"table in {text.source}", document, [_WIND.name, _GUST.name])
    profile = synthetic_profile(**_towards(_WIND, _WIND.one(document)))
    for one in _GUST.each(document):
        profile = add_gust(profile, **_towards(_GUST, one))
    return Levels(
        text=text,
        line=np.ones(profile.height.size, dtype=np.int64),
        height=profile.height,
        east=profile.east,
        north=profile.north,
        title=profile.source,
        notes=profile.notes,
    )


def _towards(table: FileTable, given: dict[str, Any]) -> dict[str, Any]:
    """What a table gives, in SI units, with the azimuth that its direction blows towards."""
    known(f"key in {table.heading}", given, table.keys)
    found: dict[str, Any] = {}
    for key, value in given.items():
        name, factor = table.keys[key]
        if name in found:
            raise InputError(f"{name} is given twice in {table.heading}; keep one")
        found[name] = finite(f"{key} in {table.heading}", value) * factor
    missing = [table.spelled(name) for name in table.quantities if name not in found]
    if missing:
        raise InputError(f"{table.heading} needs {', '.join(missing)}")
    return {"azimuth": found.pop("direction") - np.pi, **found}
