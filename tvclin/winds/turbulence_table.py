"""Turbulence over altitude from a table: altitude, intensity and, on request, scale length.

In a text file the columns have their units in the name, as altitude_m,intensity_m_per_s,length_m or
altitude [ft]; intensity [kt]. In a study file each row is a table [[turbulence.level]].
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

import numpy as np

from tvclin.base.errors import InputError, naming
from tvclin.base.sheet import Heading, Headings, read_sheet
from tvclin.base.tables import FileTable
from tvclin.base.units import WRITTEN, factor_of
from tvclin.winds.turbulence import COMPONENTS, SPECTRA, Turbulence

LEVEL_TABLE = FileTable(
    "[[turbulence.level]]",
    {"altitude": "altitude", "intensity": "speed", "length": "length"},
    required=("altitude", "intensity"),
)
_COLUMNS = {
    **dict.fromkeys(("altitude", "alt", "height"), "altitude"),
    **dict.fromkeys(("intensity", "sigma", "rms"), "intensity"),
    **dict.fromkeys(("length", "scale length", "l"), "length"),
}
"""Columns by the words of their names."""


def read_turbulence(
    path: str | PathLike[str], *, spectrum: str = SPECTRA[0], component: str = COMPONENTS[0]
) -> Turbulence:
    r"""Return the turbulence over altitude of a text file.

    Parameters
    ----------
    path : path_like
        Table with the columns altitude (or height), intensity (or sigma) and, on request, length,
        each with its unit in the name: altitude_m, intensity_m_per_s, length_m. Altitudes rise.
    spectrum, component : str
        "dryden" or "von-karman"; "transverse" (across the path) or "along" it. Without the column
        of lengths these are by MIL-F-8785C above 2000 ft.

    Raises
    ------
    InputError
        For a file without these columns, a unit that is missing or unknown, a cell that is no
        number, and as `Turbulence`.

    Examples
    --------
    >>> import tempfile, pathlib, tvclin as tv
    >>> folder = tempfile.TemporaryDirectory()
    >>> file = pathlib.Path(folder.name) / "turbulence.csv"
    >>> _ = file.write_text("altitude_km,intensity_m_per_s\n0,2.5\n12,5\n20,1\n")
    >>> tv.winds.read_turbulence(file).at(6000.0).intensity
    3.75
    >>> folder.cleanup()
    """
    missing = "names such as altitude_m,intensity_m_per_s,length_m"
    sheet = read_sheet(path, "a table of turbulence over altitude", _fit, missing)
    columns: dict[str, Any] = {}
    for heading in sheet.headings:
        name, factor = _column(heading)
        if name is None:
            continue
        if name in columns:
            raise sheet.error(f"it has two columns of the {name}; keep one")
        if factor is None:
            units = ", ".join(filter(None, WRITTEN[LEVEL_TABLE.quantities[name]]))
            raise sheet.error(f"the column {heading.text} has no known unit; give it in {units}")
        columns[name] = factor * sheet.complete_numbers(heading)
    with naming(sheet.text.source):
        return Turbulence(**columns, spectrum=spectrum, component=component)


def turbulence_of_levels(rows: Sequence[Any], spectrum: str, component: str) -> Turbulence:
    """Return the turbulence over altitude of the tables [[turbulence.level]] of a study file.

    `rows`: the tables. `spectrum`: "dryden" or "von-karman". `component`: "transverse" or "along".
    """
    levels: list[Mapping[str, float]] = [LEVEL_TABLE.read(row) for row in rows]
    if any(level.keys() != levels[0].keys() for level in levels):
        raise InputError("[[turbulence.level]] must have a length in each level, or in none")
    # altitude [m], intensity [m/s] and perhaps length [m], an array each
    columns: dict[str, Any] = {
        name: np.array([level[name] for level in levels]) for name in levels[0]
    }
    return Turbulence(**columns, spectrum=spectrum, component=component)


def _fit(headings: Headings) -> float:
    """Return how many columns of turbulence the headings of a line name: most in the header.

    Zero unless altitude and intensity are among them.
    """
    names = {name for name, _ in map(_column, headings)} - {None}
    return float(len(names)) if {"altitude", "intensity"} <= names else 0.0


def _column(heading: Heading) -> tuple[str | None, float | None]:
    """Return the name of the column of a heading, and the factor of its unit to SI.

    Each is None where it is not known.
    """
    words = heading.words
    for size in (2, 1):  # names of two words first
        name = _COLUMNS.get(" ".join(words[:size]))
        if name is not None and len(words) >= size:
            return name, factor_of(" ".join(words[size:]), LEVEL_TABLE.quantities[name])
    return None, None
