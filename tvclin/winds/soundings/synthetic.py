"""Synthetic wind profiles: an envelope with shear build-up, discrete gusts, and their TOML files.

A profile reaches the speed of an envelope at one height and falls off above and below it by a
given shear; a gust adds half cosines over height. A file has the tables [synthetic] and [[gust]].
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tvclin.base import errors
from tvclin.base.arrays import FloatArray
from tvclin.base.files import tables_of
from tvclin.base.sheet import Text
from tvclin.base.tables import FileTable, check_known
from tvclin.winds.soundings.levels import Levels, SoundingEntry
from tvclin.winds.soundings.profile import WindProfile

_FLANK_PIECES = 32
"""Linear pieces of a flank of a gust; they miss the cosine by 6e-4 of the gust."""
_MIN_BLEND, _MAX_BLEND = 1e-3, 1e6
"""Smallest and largest blend [m] of a gust."""
_SHEAR_LAYER, _SHEAR_EXPONENT = 1000.0, 0.7
"""Reference thickness [m] and exponent of the power law of shear."""
_SYNTHETIC_TABLE = FileTable(
    "[synthetic]",
    {
        **dict.fromkeys(("height", "thickness", "peak_height"), "length"),
        **dict.fromkeys(("speed", "change"), "speed"),
        "direction": "angle",
    },
)
_GUST_TABLE = FileTable(
    "[[gust]]",
    {
        **dict.fromkeys(("base", "blend", "thickness"), "length"),
        "amplitude": "speed",
        "direction": "angle",
    },
)
HEADING = _SYNTHETIC_TABLE.heading
"""Heading of the table by which such a file is recognised."""


def add_gust(
    profile: WindProfile,
    *,
    base: float,
    amplitude: float,
    blend: float,
    thickness: float,
    azimuth: float,
) -> WindProfile:
    """Return a profile with a discrete gust added: half cosines up and down, constant between.

        w = (amplitude/2) (1 - cos(pi (h - base)/blend)),    base <= h <= base + blend

    Parameters
    ----------
    profile : WindProfile
        Profile without the gust.
    base : float
        Height [m] of the lower end of the gust.
    amplitude : float
        Amplitude of the gust [m/s].
    blend : float
        Height interval [m] of the rise, and of the fall; positive.
    thickness : float
        Thickness [m] of the layer with the full amplitude, zero or positive.
    azimuth : float
        Direction [rad] towards which the gust blows, from north, clockwise.

    Raises
    ------
    InputError
        For a gust that does not lie within the profile, and a blend below a millimetre.

    Notes
    -----
    The shape is the same as in `LayeredGust`, over height. The package suggests no size: it is
    given by the design criteria.
    """
    errors.instance("profile", profile, WindProfile, "see read_sounding")
    low, angle = errors.number("base", base, unit="m"), errors.bearing("azimuth", azimuth)
    flank = errors.number("blend", blend, errors.between(_MIN_BLEND, _MAX_BLEND), "m")
    top = low + flank + errors.number("thickness", thickness, errors.nonnegative, "m")
    if low < profile.height[0] or top + flank > profile.height[-1]:
        raise errors.InputError(
            f"the gust from {low:.6g} to {top + flank:.6g} m must lie within the profile, which is"
            f" known from {profile.height[0]:.6g} to {profile.height[-1]:.6g} m"
        )
    steps = np.linspace(0.0, flank, _FLANK_PIECES + 1)
    height = np.unique(np.concatenate([profile.height, low + steps, top + steps]))
    inside = np.minimum(height - low, top + flank - height)  # distance to the nearer end
    rise = (1.0 - np.cos(np.pi * np.clip(inside / flank, 0.0, 1.0))) / 2
    gust = errors.number("amplitude", amplitude, unit="m/s") * rise
    east, north = profile.at(height)
    return WindProfile(
        height=height,
        east=east + gust * np.sin(angle),
        north=north + gust * np.cos(angle),
        source=profile.source,
        notes=(*profile.notes, f"gust of {amplitude:.6g} m/s added from {low:.6g} m on"),
    )


def power_law_shear(change: ArrayLike, thickness: ArrayLike) -> FloatArray:
    """Return the change of wind speed [m/s] over layers thinner than 1000 m.

        dV(dh) = dV(1000 m) (dh/1000 m)^0.7

    Parameters
    ----------
    change : array_like
        Change over 1000 m [m/s], zero or positive.
    thickness : array_like
        Thickness of the layer [m], from 0 to 1000; broadcasts with `change`.

    Raises
    ------
    InputError
        For a thickness beyond 1000 m, or a negative change.

    Notes
    -----
    G. H. Fichtl (1972), NTRS 19720036021: mean, standard deviation and percentiles of the shear
    over intervals below 1 km go with the 0.7 power of the interval.
    """
    change = errors.nonnegative("change", change, "m/s")
    layer = errors.nonnegative("thickness", thickness, "m")
    if np.any(layer > _SHEAR_LAYER):
        raise errors.InputError(
            f"thickness must be at most {_SHEAR_LAYER:g} m; got {layer.max():.6g} m"
        )
    return np.asarray(change * (layer / _SHEAR_LAYER) ** _SHEAR_EXPONENT)


def synthetic_profile(
    height: ArrayLike,
    speed: ArrayLike,
    *,
    peak_height: float,
    thickness: ArrayLike,
    change: ArrayLike,
    azimuth: float,
) -> WindProfile:
    """Return a wind that reaches an envelope at one height, with shear above and below it.

    Parameters
    ----------
    height, speed : array_like
        The envelope: heights [m], ascending, and wind speeds [m/s], ``(n,)``.
    peak_height : float
        Height [m] at which the wind reaches the envelope.
    thickness, change : array_like
        Shear: decrease of the speed [m/s] below the speed of the envelope over layers of a
        thickness [m], both positive and ascending, ``(m,)``. It applies below and above.
    azimuth : float
        Direction [rad] towards which the wind blows, from north, clockwise.

    Returns
    -------
    WindProfile
        Profile up to the end of the table of shear, or to the heights of zero speed.

    Raises
    ------
    InputError
        For tables that do not ascend, and a peak height outside the envelope.

    Notes
    -----
    The package has no envelopes or shears of its own.
    """
    z, w = errors.finite("height", height, "m"), errors.nonnegative("speed", speed, "m/s")
    layer = errors.positive("thickness", thickness, "m")
    drop = errors.positive("change", change, "m/s")
    _check_rows("height and speed", (z, w), ascending=(z,))
    _check_rows("thickness and change", (layer, drop), ascending=(layer, drop))
    centre = errors.number("peak_height", peak_height, unit="m")
    angle = errors.bearing("azimuth", azimuth)
    if not z[0] <= centre <= z[-1]:
        raise errors.InputError(
            f"peak_height must be within the envelope, {z[0]:.6g} to {z[-1]:.6g} m; got"
            f" {centre:.6g} m"
        )
    peak = float(np.interp(centre, z, w))
    layer, drop = np.append(0.0, layer), np.append(0.0, drop)
    # distance from the peak at which the wind is calm; the last layer where the table ends before
    distance_to_calm = np.interp(peak, drop, layer)
    distances = np.append(layer[layer < distance_to_calm], distance_to_calm)
    speeds = np.maximum(peak - np.interp(distances, layer, drop), 0.0)
    # below the peak in reverse order, and without the distance of zero
    heights = np.concatenate([centre - distances[:0:-1], centre + distances])
    profile_speeds = np.concatenate([speeds[:0:-1], speeds])
    return WindProfile(
        height=heights,
        east=profile_speeds * np.sin(angle),
        north=profile_speeds * np.cos(angle),
        source=f"synthetic profile with {peak:.6g} m/s at {centre:.6g} m",
    )


def _check_rows(
    names: str, rows: tuple[FloatArray, FloatArray], ascending: tuple[FloatArray, ...]
) -> None:
    """Raise `InputError` unless two rows have one length, and the rows `ascending` ascend.

    `names`: names of the rows in the error.
    """
    first, second = rows
    if first.ndim != 1 or first.shape != second.shape or not first.size:
        raise errors.InputError(
            f"{names} must be two lists of one length; got shapes {first.shape} and {second.shape}"
        )
    if any(np.any(np.diff(values) <= 0.0) for values in ascending):
        raise errors.InputError(f"{names} must ascend")


def soundings_in(text: Text) -> list[SoundingEntry]:
    """Return the wind of a text with [synthetic] and each [[gust]], as its only sounding.

    By `synthetic_profile` and `add_gust`; directions are those from which they blow.
    """
    return [SoundingEntry(lambda: _synthetic_levels(text))]


def _synthetic_levels(text: Text) -> Levels:
    """Return the levels of the profile of a text: of [synthetic] with each [[gust]]."""
    document = tables_of("\n".join(text.lines), text.source)
    check_known(f"table in {text.source}", document, [_SYNTHETIC_TABLE.name, _GUST_TABLE.name])
    profile = synthetic_profile(
        **_values_with_azimuth(_SYNTHETIC_TABLE, _SYNTHETIC_TABLE.one(document))
    )
    for gust in _GUST_TABLE.each(document):
        profile = add_gust(profile, **_values_with_azimuth(_GUST_TABLE, gust))
    return Levels(
        text=text,
        line=np.ones(profile.height.size, dtype=np.int64),
        height=profile.height,
        east=profile.east,
        north=profile.north,
        title=profile.source,
        notes=profile.notes,
    )


def _values_with_azimuth(table: FileTable, row: dict[str, Any]) -> dict[str, Any]:
    """Return the values of a table [SI] by name, with the azimuth towards which it blows [rad].

    `InputError` for unknown, missing and repeated quantities. `table`: specification of the keys.
    `row`: the table in the file, from keys to values.
    """
    check_known(f"key in {table.heading}", row, table.keys)
    values: dict[str, Any] = {}
    for key, value in row.items():
        name, factor = table.keys[key]
        if name in values:
            raise errors.InputError(f"{name} is given twice in {table.heading}; keep one")
        values[name] = errors.finite(f"{key} in {table.heading}", value) * factor
    missing = [table.spelled(name) for name in table.quantities if name not in values]
    if missing:
        raise errors.InputError(f"{table.heading} needs {', '.join(missing)}")
    azimuth = values.pop("direction") - np.pi  # files give where the wind blows from
    return {"azimuth": azimuth, **values}
