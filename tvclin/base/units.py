"""Units: suffixes of keys with their factors to SI, and units as other programs write them.

Other programs write units after a column's name, also with damaged characters; they may have all
units of keys and some more.
"""

import re
from dataclasses import dataclass
from math import pi

POUND = 0.45359237
"""kg, exact (international pound)."""
FOOT = 0.3048
"""m, exact (international foot)."""
POUND_FORCE = POUND * 9.80665
"""N, exact."""
SLUG = POUND_FORCE / FOOT
"""kg."""
DEGREE = pi / 180

UNITS: dict[str, dict[str, float]] = {
    "force": {"N": 1.0, "kN": 1e3, "MN": 1e6, "lbf": POUND_FORCE},
    "inertia": {"kg_m2": 1.0, "slug_ft2": POUND_FORCE * FOOT, "lb_ft2": POUND * FOOT**2},
    "mass": {"kg": 1.0, "lb": POUND, "slug": SLUG},
    "force slope": {
        "N_per_rad": 1.0,
        "kN_per_rad": 1e3,
        "lbf_per_rad": POUND_FORCE,
        "N_per_deg": 1.0 / DEGREE,
        "lbf_per_deg": POUND_FORCE / DEGREE,
    },
    "inertia rate": {"kg_m2_per_s": 1.0, "slug_ft2_per_s": POUND_FORCE * FOOT},
    "damping moment": {
        "N_m_s_per_rad": 1.0,
        "lbf_ft_s_per_rad": POUND_FORCE * FOOT,
        "N_m_s_per_deg": 1.0 / DEGREE,
    },
    "damping coefficient": {"per_qL_over_V": 1.0, "per_qL_over_2V": 0.5},
    "moment": {"N_m": 1.0, "kN_m": 1e3, "lbf_ft": POUND_FORCE * FOOT},
    "moment slope": {
        "N_m_per_rad": 1.0,
        "N_m_per_deg": 1.0 / DEGREE,
        "lbf_ft_per_rad": POUND_FORCE * FOOT,
        "lbf_ft_per_deg": POUND_FORCE * FOOT / DEGREE,
    },
    "power": {"W": 1.0},
    "energy": {"J": 1.0},
    "mass flow": {"kg_per_s": 1.0, "lb_per_s": POUND},
    "length": {"m": 1.0, "ft": FOOT, "in": FOOT / 12},
    "altitude": {"m": 1.0, "km": 1e3, "ft": FOOT, "in": FOOT / 12},
    "per length": {"per_m": 1.0, "per_ft": 1.0 / FOOT, "per_in": 12 / FOOT},
    "speed": {"m_per_s": 1.0, "km_per_s": 1e3, "ft_per_s": FOOT, "kt": 1852 / 3600},
    "acceleration": {"m_per_s2": 1.0, "ft_per_s2": FOOT},
    "angle": {"rad": 1.0, "deg": DEGREE},
    "angular rate": {"rad_per_s": 1.0, "deg_per_s": DEGREE},
    "angular acceleration": {"rad_per_s2": 1.0, "deg_per_s2": DEGREE},
    "natural frequency": {"rad_per_s": 1.0, "Hz": 2 * pi},
    "sample rate": {"Hz": 1.0},
    "time": {"s": 1.0},
    "delay": {"s": 1.0, "ms": 1e-3},
    "per time": {"per_s": 1.0},
    "per time squared": {"per_s2": 1.0},
    "per time cubed": {"per_s3": 1.0},
    "pressure": {"Pa": 1.0, "kPa": 1e3, "psf": POUND_FORCE / FOOT**2},
    "pressure angle": {"Pa_rad": 1.0, "Pa_deg": DEGREE, "kPa_rad": 1e3, "kPa_deg": 1e3 * DEGREE},
    "angle per speed": {"rad_s_per_m": 1.0, "deg_s_per_m": DEGREE},
    "angle per length": {"rad_per_m": 1.0, "deg_per_m": DEGREE},
    "angle per acceleration": {"rad_s2_per_m": 1.0, "deg_s2_per_m": DEGREE},
    "area": {"m2": 1.0, "ft2": FOOT**2},
    "per angle": {"per_rad": 1.0, "per_deg": 1.0 / DEGREE},
    "percent": {"percent": 0.01},
    "hundredths": {"": 0.01},
    "part": {"part": 1.0, "percent": 0.01},
    "number": {"": 1.0},
}
"""For each kind of quantity the suffixes of its keys and their factors to SI."""
_DIMENSIONLESS_KINDS = ("percent", "part", "hundredths")
"""Kinds of fractions, which have no unit."""


def written(suffix: str) -> str:
    """Return the `suffix` of a key as a unit of tables: of lbf_per_deg lbf/deg."""
    return suffix.replace("_per_", "/").replace("per_", "1/").replace("_", " ")


def si_unit(kind: str) -> str:
    """Return the SI unit of a kind of quantity in tables, as N/rad; "" for a fraction."""
    first = next(iter(UNITS[kind]))
    return "" if kind in _DIMENSIONLESS_KINDS else written(first)


_IN_DEGREES = {"angle": "deg", "angular rate": "deg_per_s", "angular acceleration": "deg_per_s2"}
_OPTION_UNITS = {**_IN_DEGREES, "delay": "ms"}
"""Units of options that are not SI units, by kind of quantity."""
_NO_UNIT = ("", "text", "flag", "count")
"""Kinds of fields that are no quantity."""
_DOCUMENT_UNITS = {**_IN_DEGREES, "gain": "dB", "degrees": "deg", "decibels": "dB"}
"""Units of documents that are not SI units, by kind of quantity; in the last two it is given."""
_OPTION_SUFFIXES = {
    "angle": "_deg",
    "angular rate": "_deg",
    "angular acceleration": "_deg",
    "delay": "_ms",
    "length": "_m",
}
"""Suffixes of the names of options, by kind of quantity."""


def optional_unit(kind: str) -> tuple[str, str, float]:
    """Return the unit of an option of a `kind`: suffix of its name, text, and factor to SI.

    Of an angle that is ("_deg", "deg", pi/180). Most options are in SI units.
    """
    unit = _OPTION_UNITS.get(kind, "")  # as in names, "deg_per_s"
    if not unit:
        return _OPTION_SUFFIXES.get(kind, ""), si_unit(kind), 1.0
    return _OPTION_SUFFIXES[kind], written(unit), UNITS[kind][unit]


def document_unit(kind: str) -> str:
    """Return the unit of a `kind` at the end of a key of a document; "" for what has no unit.

    It is the SI unit, the first of `UNITS`, but degrees for angles and dB for gains.
    """
    return "" if kind in _NO_UNIT else _DOCUMENT_UNITS.get(kind) or next(iter(UNITS[kind]))


_INCH = FOOT / 12
_MILE, _OUNCE = 5280 * FOOT, POUND / 16
_LENGTHS = {
    **{"mm": 1e-3, "cm": 1e-2, "km": 1e3},
    **{"in/64": _INCH / 64, "yd": 3 * FOOT, "mi": _MILE, "nmi": 1852.0},
}
_OTHER_UNITS: dict[str, dict[str, float]] = {
    "time": {"ms": 1e-3, "min": 60.0},
    "length": _LENGTHS,
    "altitude": _LENGTHS,
    "mass": {"g": 1e-3, "t": 1e3, "oz": _OUNCE},
    "inertia": {
        **{"kg cm2": 1e-4, "oz in2": _OUNCE * _INCH**2, "lb in2": POUND * _INCH**2},
        **{"lbf ft s2": POUND_FORCE * FOOT},
    },
    "force": {"kgf": 9.80665},
    "speed": {"km/h": 1 / 3.6, "mph": _MILE / 3600},
    "area": {"mm2": 1e-6, "cm2": 1e-4, "in2": _INCH**2},
    "angle": {"°": DEGREE, "arcmin": DEGREE / 60},
    "pressure": {
        **{"hPa": 100.0, "mbar": 100.0, "bar": 1e5, "atm": 101_325.0},
        **{"mmHg": 133.322, "inHg": 3386.39, "psi": POUND_FORCE / _INCH**2},
    },
    "density": {
        **{"g/cm3": 1e3, "kg/dm3": 1e3, "kg/m3": 1.0},
        **{"oz/in3": _OUNCE / _INCH**3, "lb/ft3": POUND / FOOT**3, "slug/ft3": SLUG / FOOT**3},
    },
    "damping moment": {"kg m2/s": 1.0, "N m s": 1.0, "lbf ft s": POUND_FORCE * FOOT},
    "per angle": {"": 1.0, "per rad": 1.0, "per deg": 1.0 / DEGREE},
    "temperature": {"K": 1.0, "°C": 1.0, "°F": 5.0 / 9.0},
}
"""Units that only other programs write, by kind of quantity; `lb` is a mass."""
WRITTEN = {
    kind: {written(suffix): factor for suffix, factor in UNITS.get(kind, {}).items()}
    | _OTHER_UNITS.get(kind, {})
    for kind in {**UNITS, **_OTHER_UNITS}
}
"""Known units of each kind of quantity as other programs write them, and their factors to SI."""
_WORDS = {
    **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("hr", "hrs", "hour", "hours"), "h"),
    **dict.fromkeys(("meter", "meters", "metre", "metres"), "m"),
    **dict.fromkeys(("kilometer", "kilometers", "kilometre", "kilometres"), "km"),
    **dict.fromkeys(("foot", "feet"), "ft"),
    **dict.fromkeys(("inch", "inches"), "in"),
    **dict.fromkeys(("mile", "miles"), "mi"),
    **dict.fromkeys(("kn", "kts", "knot", "knots"), "kt"),
    **dict.fromkeys(("degree", "degrees", "degs"), "deg"),
    **dict.fromkeys(("radian", "radians"), "rad"),
    **dict.fromkeys(("pound", "pounds", "lbs"), "lb"),
    **{"mps": "m/s", "fps": "ft/s", "kph": "km/h", "kmh": "km/h", "kmph": "km/h"},
}
"""Alternative spellings of components of a unit."""
_SPEEDS = {"ms1": "m/s", "fts1": "ft/s", "kmh1": "km/h", "kms1": "km/s", "mi/h": "mph"}
"""Alternative spellings of complete units, without signs: of m s-1."""
_ZERO = {"°C": 273.15, "°F": 459.67 * 5.0 / 9.0}
"""Zero points in SI of units with an offset."""


@dataclass(frozen=True)
class Unit:
    """Recognised unit.

    `factor`: to SI. `spelling`: its correct spelling. `damaged`: whether characters were damaged,
    as by another encoding, and the unit was identified as the only similar one of its quantity.
    """

    factor: float
    spelling: str
    damaged: bool

    @property
    def zero(self) -> float:
        """Zero point of the unit in SI."""
        return _ZERO.get(self.spelling, 0.0)


def unit_of(written: str, candidates: dict[str, float]) -> Unit | None:
    """Return the unit whose text is `written`; None where no candidate fits, or two do.

    `candidates`: factors to SI by spelling, of one kind of quantity. All but letters, digits and
    strokes is ignored, since other encodings damage it; then alternative spellings of its
    components are tried: m/sec, feet, m s-1, m_per_s. If none fits, powers are ignored as well:
    within a quantity the remainder identifies the unit.
    """
    written = written.translate(_SIGNS)
    key = _key(written)
    text = re.sub(r"[\s_]+", " ", written.lower()).replace(" per ", "/")
    respelled = _key("".join(_WORDS.get(word, word) for word in re.split(r"([^a-z]+)", text)))
    respelled = _SPEEDS.get(respelled, respelled)
    # 1. the same letters and digits; 2. after alternative spellings; 3. without powers, if unique
    for spelling, factor in candidates.items():
        if key == _key(spelling):
            return Unit(factor, spelling, damaged=_bare(written) != _bare(spelling))
    for spelling, factor in candidates.items():
        if respelled == _key(spelling):
            return Unit(factor, spelling, damaged=False)
    powerless = re.sub(r"\d", "", key)
    fits = [
        Unit(factor, spelling, damaged=True)
        for spelling, factor in candidates.items()
        if re.sub(r"\d", "", _key(spelling)) == powerless
    ]
    return fits[0] if len(fits) == 1 else None


def factor_of(written: str, kind: str) -> float | None:
    """Return the factor to SI of a unit of a `kind` of quantity, whose text is `written`.

    None for an unknown unit, and for one with damaged characters.
    """
    unit = unit_of(written, WRITTEN[kind])
    return None if unit is None or unit.damaged else unit.factor


_SIGNS = str.maketrans("¹²³⁻\u2212º˚", "123--°°")


def _key(unit: str) -> str:
    """Return the ASCII letters, digits and strokes of a unit, in lower case."""
    ascii_characters = (c for c in unit.translate(_SIGNS).lower() if c.isascii())
    return "".join(c for c in ascii_characters if c.isalnum() or c == "/")


def _bare(unit: str) -> str:
    """Return a unit without separators of its components: kg m^2 equals kg·m²."""
    return "".join(c for c in unit.translate(_SIGNS).lower() if c not in " *^._-·")
