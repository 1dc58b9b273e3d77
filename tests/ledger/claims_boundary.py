"""The report's numbers on boundaries: summary, introduction, stability analysis, figure 5."""

from functools import partial

import numpy as np

from tests.ledger.cases import (
    FULL,
    HALF,
    NONE,
    both,
    drift_points,
    drift_reduction,
    gust,
    on_model,
    summit,
    vehicles,
    with_drift,
    without_drift,
    zero,
)
from tests.ledger.computed import Computed, Value, about, rounds_to
from tvclin.base.units import FOOT, POUND, UNITS
from tvclin.boundary.closed_forms import rectangular_limit
from tvclin.boundary.optimum.minimum_peak import optimum_deflection
from tvclin.linear.plant import Plant

PERCENT = "percent"


def triangular_half_band_at_4() -> Computed:
    """Eq (12) at K = 0.5."""
    y = 100.0 * without_drift(4.0, HALF)
    return Computed((Value("at tau beta = 4", y),), rounds_to(56, y), PERCENT)


def nautical_miles_100_in_km() -> Computed:
    """An exact conversion: a knot is a nautical mile per hour."""
    km = 100.0 * UNITS["speed"]["kt"] * 3600.0 / 1000.0
    return Computed((Value("", km),), rounds_to(184, km), "km")


def inches_260_in_cm() -> Computed:
    """An exact conversion."""
    cm = 260.0 * FOOT / 12.0 * 100.0
    return Computed((Value("", cm),), rounds_to(660, cm), "cm")


def beta_of_both() -> Computed:
    """Rounded to the one printed digit, beta is within the range."""
    beta = both("", lambda c: c.beta)
    return Computed((beta,), all(0.35 <= b <= 0.65 for b in beta.numbers), "1/s")


def tau_beta_at_10_s() -> Computed:
    """Rounded to the printed digit, tau beta is 4 or more."""
    tau_beta = both("", lambda c: 10.0 * c.beta)
    return Computed((tau_beta,), all(b >= 3.5 for b in tau_beta.numbers))


def triangular_full_band_reduction_at_4() -> Computed:
    """Eq (12) at K = 1, less than one."""
    reduction = 100.0 * (1.0 - without_drift(4.0, FULL))
    return Computed((Value("", reduction),), rounds_to(31, reduction), PERCENT)


def triangular_no_band_reduction_at_4() -> Computed:
    """Eq (12) at K = 0, less than one."""
    reduction = 100.0 * (1.0 - without_drift(4.0, NONE))
    longer = Value("at tau beta = 8", 100.0 * (1.0 - without_drift(8.0, NONE)))
    values = (Value("at tau beta = 4", reduction), longer)
    return Computed(values, rounds_to(62, reduction), PERCENT)


def k1_of_both() -> Computed:
    """Eq (15b): below one, and by less than five percent."""
    K1 = both("", lambda c: c.K1)
    return Computed((K1,), all(0.95 < k < 1.0 for k in K1.numbers))


def drift_reduction_full_band_at_4() -> Computed:
    """Eq (18) over eq (12) at K = 1; "about" is within one percent."""
    ratio = both("", lambda c: drift_reduction(c, 4.0, FULL))
    points = both("in points", lambda c: drift_points(c, 4.0, FULL))
    return Computed((ratio, points), about(4, *ratio.numbers), PERCENT)


def segments_of_the_optimum() -> Computed:
    """Segments of the optimum deflection for N = 2, the poles of (B7); claimed is N - 1."""
    segments, poles = [], 2
    for c in vehicles():
        best = optimum_deflection(Plant(c, "drift-exact"), gust(c, 4.0))
        segments.append(float(best.switch_times.size + 1))
    return Computed((Value("for N = 2", *segments),), all(n == poles - 1 for n in segments))


def pounds_1e6_in_kg() -> Computed:
    """An exact conversion, printed to hundreds."""
    kg = 1e6 * POUND
    return Computed((Value("", kg),), rounds_to(453_600, kg, last=100.0), "kg")


def rectangular_at_4() -> Computed:
    """Eq (7), and eq (16) beside it."""
    y = 100.0 * float(rectangular_limit(4.0))
    drift = both("with drift", lambda c: 100.0 * rectangular_limit(4.0, c.K1))
    return Computed((Value("", y), drift), rounds_to(98, y), PERCENT)


def triangular_full_band_at_4() -> Computed:
    """Eq (12) at K = 1."""
    y = 100.0 * without_drift(4.0, FULL)
    return Computed((Value("", y),), rounds_to(69, y), PERCENT)


def triangular_no_band_at_4() -> Computed:
    """Eq (12) at K = 0; eq (18) and the exact roots beside it."""
    y = 100.0 * without_drift(4.0, NONE)
    drift = both("(18)", lambda c: 100.0 * with_drift(c, 4.0, NONE))
    exact = both("exact roots", lambda c: 100.0 * on_model(c, 4.0, NONE))
    return Computed((Value("", y), drift, exact), rounds_to(38, y), PERCENT)


def triangular_half_band_maximum() -> Computed:
    """Eq (12) at K = 0.5, less than one, at tau beta = 4; and its largest value as a deflection."""
    reduction = 100.0 * (1.0 - without_drift(4.0, HALF))
    where, most = summit(lambda b: without_drift(b, HALF), 1.0, 20.0)
    values = (
        Value("at tau beta = 4", reduction),
        Value("most of (12)", 100.0 * most),
        Value("at tau beta", where),
        Value("(12) at tau beta = 20", 100.0 * without_drift(20.0, HALF)),
    )
    return Computed(values, rounds_to(56, reduction), PERCENT)


def drift_reduction_full_band_at_20() -> Computed:
    """Eq (18) over eq (12) at K = 1, where it is as printed, and with the dead band literally."""
    ratio = both("", lambda c: drift_reduction(c, 20.0, FULL))
    where = both(
        "24 percent at tau beta",
        lambda c: zero(lambda b: drift_reduction(c, b, FULL) - 24.0, 20.0, 30.0),
    )
    literal = both(
        "dead band literally",
        lambda c: 100.0 * (1.0 - on_model(c, 20.0, FULL, "drift", "literal") / _fixed_20()),
    )
    return Computed((ratio, where, literal), rounds_to(24, *ratio.numbers), PERCENT)


def _fixed_20() -> float:
    return without_drift(20.0, FULL)


def drift_reduction_half_band() -> Computed:
    """Eq (18) against eq (12) at K = 0.5; "negligible" is below one percent."""
    ratios = [
        both(f"at tau beta = {b:g}", partial(drift_reduction, tau_beta=b, dead_band=HALF))
        for b in (4.0, 20.0)
    ]
    points = [
        both(f"points at {b:g}", partial(drift_points, tau_beta=b, dead_band=HALF))
        for b in (4.0, 20.0)
    ]
    negligible = bool(np.all([np.abs(value.numbers) < 1.0 for value in ratios]))
    return Computed((*ratios, *points), negligible, PERCENT)


FUNCTIONS = (
    triangular_half_band_at_4,
    nautical_miles_100_in_km,
    inches_260_in_cm,
    beta_of_both,
    tau_beta_at_10_s,
    triangular_full_band_reduction_at_4,
    triangular_no_band_reduction_at_4,
    k1_of_both,
    drift_reduction_full_band_at_4,
    segments_of_the_optimum,
    pounds_1e6_in_kg,
    rectangular_at_4,
    triangular_full_band_at_4,
    triangular_no_band_at_4,
    triangular_half_band_maximum,
    drift_reduction_full_band_at_20,
    drift_reduction_half_band,
)
