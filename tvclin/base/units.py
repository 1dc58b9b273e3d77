"""Units of keys: the suffixes that keys of files may carry, and their factors to SI."""

from math import pi

POUND = 0.45359237
"""kg, exact (international pound)."""
FOOT = 0.3048
"""m, exact (international foot)."""
POUND_FORCE = POUND * 9.80665
"""N, exact."""
DEGREE = pi / 180

UNITS: dict[str, dict[str, float]] = {
    "force": {"N": 1.0, "kN": 1e3, "MN": 1e6, "lbf": POUND_FORCE},
    "inertia": {"kg_m2": 1.0, "slug_ft2": POUND_FORCE * FOOT, "lb_ft2": POUND * FOOT**2},
    "mass": {"kg": 1.0, "lb": POUND, "slug": POUND_FORCE / FOOT},
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
    "per length": {"per_m": 1.0, "per_ft": 1.0 / FOOT, "per_in": 12 / FOOT},
    "speed": {"m_per_s": 1.0, "km_per_s": 1e3, "ft_per_s": FOOT, "kt": 1852 / 3600},
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
    """Return the suffix of a key as a unit of tables: lbf/deg, slug ft2."""
    return suffix.replace("_per_", "/").replace("per_", "1/").replace("_", " ")


def si_unit(kind: str) -> str:
    """Return the SI unit of a kind of quantity in tables, as N/rad; "" for a fraction."""
    first = next(iter(UNITS[kind]))
    return "" if kind in _DIMENSIONLESS_KINDS else written(first)


_IN_DEGREES = {
    "angle": "deg",
    "angular rate": "deg_per_s",
    "angular acceleration": "deg_per_s2",
}
_OPTION_UNITS = {**_IN_DEGREES, "delay": "ms"}
"""Units of options that are not SI units, by kind of quantity."""
_DOCUMENT_UNITS = {**_IN_DEGREES, "gain": "dB"}
"""Units of documents that are not SI units, by kind of quantity."""
_OPTION_SUFFIXES = {
    "angle": "_deg",
    "angular rate": "_deg",
    "angular acceleration": "_deg",
    "delay": "_ms",
    "length": "_m",
}
"""Suffixes of the names of options, by kind of quantity."""


def optional_unit(kind: str) -> tuple[str, str, float]:
    """Return the unit of an option: suffix of its name, text, and factor to SI."""
    suffix = _OPTION_UNITS.get(kind, "")
    if not suffix:
        return _OPTION_SUFFIXES.get(kind, ""), si_unit(kind), 1.0
    return _OPTION_SUFFIXES[kind], written(suffix), UNITS[kind][suffix]


def document_unit(kind: str) -> str:
    """Return the unit at the end of a key of a document; "" for what has no unit."""
    return _DOCUMENT_UNITS.get(kind) or next(iter(UNITS.get(kind, ("",))))
