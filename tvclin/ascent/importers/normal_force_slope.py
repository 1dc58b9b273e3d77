"""The slope of the normal force coefficient: a number, over Mach, or from another tool's table."""

from __future__ import annotations

import re
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base.arrays import FloatArray
from tvclin.base.errors import InputError, nonnegative, number, one_row, shown
from tvclin.base.sheet import Column, Heading, Headings, Sheet, letters, read_sheet
from tvclin.base.units import DEGREE

MIN_SLOPE = 0.5
"""A slope below this [1/rad] is taken for one per degree: slender bodies have 2 per radian."""
MAX_SLOPE = 100.0
"""A slope above this [1/rad] has no meaning: large fins on a thin body make 40."""
_MAX_CONSTANT_MACH = 0.3
"""Mach number up to which a slope hardly changes: below a table its first slope counts."""
_SLOPE = re.compile(r"c_?n_?([^\x00-\x7f]+|a|alpha)( .*)?", flags=re.IGNORECASE)

Slope = ArrayLike | str | PathLike[str] | tuple[ArrayLike, ArrayLike]


def slope_at_mach(given: Slope, mach: FloatArray) -> Column:
    """Return dC_N/dalpha [1/rad] at Mach numbers, of a number, a pair of rows over Mach, or a file.

    Straight lines between the Mach numbers of a pair or a file; `InputError` for some beyond them.
    """
    if isinstance(given, str | PathLike):
        at, slope = read_slopes(given)
    elif isinstance(given, tuple | list):
        if len(given) != 2:
            raise InputError(
                "normal_force_coefficient_slope must be a number [1/rad], a pair of Mach numbers"
                f" and slopes, or a file; got {shown(given)}"
            )
        row = one_row("the Mach numbers of normal_force_coefficient_slope", given[0])
        slopes = one_row("the slopes of normal_force_coefficient_slope", given[1], "1/rad")
        at, slope = _checked(row, slopes, "given over Mach")
    else:
        value = number("normal_force_coefficient_slope", given, nonnegative, "1/rad")
        return Column(np.full(mach.shape, value), f"given, {value:g} per rad")
    if mach.max() > at[-1] or mach.min() < at[0] > _MAX_CONSTANT_MACH:
        raise InputError(
            f"normal_force_coefficient_slope must cover the flight, Mach {mach.min():.3g} to"
            f" {mach.max():.3g}; got Mach {at[0]:.3g} to {at[-1]:.3g}"
        )
    return Column(np.interp(mach, at, slope.values), slope.origin)


def read_slopes(path: str | PathLike[str]) -> tuple[FloatArray, Column]:
    """Return Mach numbers and slopes [1/rad] of a table of RASAero II or of OpenRocket's analysis.

    Of RASAero it is CN Potential at the smallest angle of attack over that angle: the slope at
    zero. Its CNalpha (0 to 4 deg) is a secant that holds viscous lift. Of OpenRocket's tables it is
    the column of the whole rocket.
    """
    missing = (
        "names with Mach; give the table that RASAero II (aero plots) or OpenRocket (component"
        " analysis) exports over Mach"
    )
    sheet = read_sheet(path, "a table of slopes over Mach", _at_mach_numbers, missing)
    potential = sheet.find("CN Potential")
    return _potential(sheet, potential) if potential is not None else _analysed(sheet)


def _at_mach_numbers(headings: Headings) -> float:
    return float(any(set(component.names) & {"mach", "machnumber"} for component in headings[:2]))


def _potential(sheet: Sheet, heading: Heading) -> tuple[FloatArray, Column]:
    """Return the slope CN Potential/Alpha at the smallest Alpha above zero, over Mach."""
    angle = sheet.find("Alpha")
    if angle is None:
        raise InputError(f"{sheet.text.source} has no column Alpha beside {heading.text}")
    mach = sheet.numbers(_mach_of(sheet), "number").values
    alpha = sheet.numbers(angle, "angle", {"": DEGREE}).values
    force = sheet.numbers(heading, "number").values
    smallest = {m: min(alpha[(mach == m) & (alpha > 0.0)], default=np.nan) for m in np.unique(mach)}
    first = np.array([alpha[i] == smallest.get(mach[i]) for i in range(mach.size)])
    if not np.any(first):
        raise InputError(
            f"{sheet.text.source} holds no angle of attack above zero; export it with Alpha 0, 2, 4"
        )
    origin = f"{sheet.text.source}, column {heading.text} over the smallest Alpha"
    order = np.argsort(mach[first], kind="stable")
    return _checked(mach[first][order], (force[first] / alpha[first])[order], origin)


def _analysed(sheet: Sheet) -> tuple[FloatArray, Column]:
    """Return the slope of the whole rocket: the only column, or the sum of the others."""
    columns = [component for component in sheet.headings if _SLOPE.fullmatch(component.name)]
    if not columns:
        nearest = [
            component.text
            for component in sheet.headings
            if letters(component.name).startswith(("cn", "normal"))
        ]
        is_none = f"; {nearest[0]} is a coefficient, not its slope" if nearest else ""
        raise InputError(
            f"{sheet.text.source} has no slope of the normal force coefficient{is_none}: it must"
            " have a column CN Potential (RASAero II) or CN alpha (OpenRocket's component analysis)"
        )
    slopes = [sheet.numbers(component, "per angle").values for component in columns]
    if len(columns) > 1 and not np.allclose(slopes[0], np.sum(slopes[1:], axis=0), rtol=1e-2):
        raise InputError(
            f"{sheet.text.source} holds {len(columns)} columns CN alpha, the first of them not the"
            " sum of the others; export that of the whole rocket alone"
        )
    mach = sheet.numbers(_mach_of(sheet), "number").values
    return _checked(mach, slopes[0], f"{sheet.text.source}, column {columns[0].text}")


def _mach_of(sheet: Sheet) -> Heading:
    columns = sheet.find("Mach", "Mach number")
    assert columns is not None  # by `_at_mach_numbers`
    return columns


def _checked(mach: FloatArray, slope: FloatArray, origin: str) -> tuple[FloatArray, Column]:
    if mach.shape != slope.shape or mach.size < 2:
        raise InputError(
            "normal_force_coefficient_slope must hold as many slopes as Mach numbers, two or more;"
            f" got {slope.size} and {mach.size}"
        )
    is_known = np.isfinite(mach) & np.isfinite(slope)
    if not np.all(is_known) or np.any(np.diff(mach) <= 0.0) or np.any(slope < 0.0):
        raise InputError(
            "the Mach numbers of normal_force_coefficient_slope must rise, and no slope may be"
            f" missing or negative; got another row in what is {origin}"
        )
    return mach, Column(slope, origin)
