"""Units as other programs write them after a column's name, also with damaged characters."""

import re
from dataclasses import dataclass

from tvclin.base.units import DEGREE, FOOT, POUND, POUND_FORCE

_INCH = FOOT / 12
_MILE, _NAUTICAL_MILE = 5280 * FOOT, 1852.0
_OUNCE, _KILOPOND = POUND / 16, 9.80665
_ATMOSPHERE = 101_325.0
_SLUG = POUND_FORCE / FOOT

WRITTEN: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "min": 60.0},
    "length": {
        **{"mm": 1e-3, "cm": 1e-2, "m": 1.0, "km": 1e3},
        **{"in": _INCH, "in/64": _INCH / 64, "ft": FOOT, "yd": 3 * FOOT},
        **{"mi": _MILE, "nmi": _NAUTICAL_MILE},
    },
    "mass": {"g": 1e-3, "kg": 1.0, "t": 1e3, "oz": _OUNCE, "lb": POUND, "slug": _SLUG},
    "inertia": {
        **{"kg·cm²": 1e-4, "kg·m²": 1.0},
        **{"oz·in²": _OUNCE * _INCH**2, "lb·in²": POUND * _INCH**2, "lb·ft²": POUND * FOOT**2},
        **{"lbf·ft·s²": POUND_FORCE * FOOT, "slug·ft²": _SLUG * FOOT**2},
    },
    "force": {"N": 1.0, "kN": 1e3, "lbf": POUND_FORCE, "kgf": _KILOPOND, "MN": 1e6},
    "speed": {
        **{"m/s": 1.0, "km/s": 1e3, "km/h": 1 / 3.6, "kt": _NAUTICAL_MILE / 3600},
        **{"ft/s": FOOT, "mph": _MILE / 3600},
    },
    "area": {"mm²": 1e-6, "cm²": 1e-4, "m²": 1.0, "in²": _INCH**2, "ft²": FOOT**2},
    "angle": {"°": DEGREE, "deg": DEGREE, "rad": 1.0, "arcmin": DEGREE / 60},
    "pressure": {
        **{"Pa": 1.0, "hPa": 100.0, "kPa": 1e3, "mbar": 100.0, "bar": 1e5, "atm": _ATMOSPHERE},
        **{"mmHg": 133.322, "inHg": 3386.39, "psi": POUND_FORCE / _INCH**2},
        **{"psf": POUND_FORCE / FOOT**2},
    },
    "density": {
        **{"g/cm³": 1e3, "kg/dm³": 1e3, "kg/m³": 1.0},
        **{"oz/in³": _OUNCE / _INCH**3, "lb/ft³": POUND / FOOT**3, "slug/ft³": _SLUG / FOOT**3},
    },
    "force slope": {
        **{"N/rad": 1.0, "kN/rad": 1e3, "lbf/rad": POUND_FORCE},
        **{"N/deg": 1.0 / DEGREE, "lbf/deg": POUND_FORCE / DEGREE},
    },
    "damping moment": {
        **{"kg·m²/s": 1.0, "N·m·s": 1.0, "N·m·s/rad": 1.0, "N·m·s/deg": 1.0 / DEGREE},
        **{"lbf·ft·s": POUND_FORCE * FOOT, "lbf·ft·s/rad": POUND_FORCE * FOOT},
    },
    "per angle": {
        **{"": 1.0, "1/rad": 1.0, "per rad": 1.0},
        **{"1/deg": 1.0 / DEGREE, "per deg": 1.0 / DEGREE},
    },
    "temperature": {"K": 1.0, "°C": 1.0, "°F": 5.0 / 9.0},
    "number": {"": 1.0},
}
"""Known units of each quantity, and their factors to SI; `lb` is a mass."""

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

    `factor`: to SI. `spelling`: its correct spelling. `mangled`: whether characters were damaged,
    and the unit was identified by the quantity.
    """

    factor: float
    spelling: str
    mangled: bool

    @property
    def zero(self) -> float:
        """Zero point of the unit in SI."""
        return _ZERO.get(self.spelling, 0.0)


def unit_of(written: str, candidates: dict[str, float]) -> Unit | None:
    """Return the unit of a text; None where no candidate fits, or two do.

    All but letters, digits and strokes is ignored, since other encodings damage it; then
    alternative spellings of its components are tried: m/sec, feet, m s-1, m_per_s. If none fits,
    powers are ignored as well: within a quantity the remainder identifies the unit.
    """
    written = written.translate(_SIGNS)
    key = _key(written)
    respelled = _respelled(written)
    for spelling, factor in candidates.items():
        if key == _key(spelling):
            return Unit(factor, spelling, _bare(written) != _bare(spelling))
    for spelling, factor in candidates.items():
        if respelled == _key(spelling):
            return Unit(factor, spelling, False)
    fits = [
        Unit(factor, spelling, True)
        for spelling, factor in candidates.items()
        if _powerless(key) == _powerless(_key(spelling))
    ]
    return fits[0] if len(fits) == 1 else None


_SIGNS = str.maketrans("¹²³⁻\u2212º˚", "123--°°")


def _key(unit: str) -> str:
    ascii_characters = (c for c in unit.translate(_SIGNS).lower() if c.isascii())
    return "".join(c for c in ascii_characters if c.isalnum() or c == "/")


def _respelled(unit: str) -> str:
    """Return the key of a unit whose components have their usual spelling."""
    text = re.sub(r"[\s_]+", " ", unit.lower()).replace(" per ", "/")
    words = (_WORDS.get(word, word) for word in re.split(r"([^a-z]+)", text))
    key = _key("".join(words))
    return _SPEEDS.get(key, key)


def _powerless(key: str) -> str:
    return "".join(c for c in key if not c.isdigit())


def _bare(unit: str) -> str:
    """Return a unit without separators of its components: kg m^2 equals kg·m²."""
    return "".join(c for c in unit.translate(_SIGNS).lower() if c not in " *^._-·")
