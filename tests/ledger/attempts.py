"""What was tried for the claims that are not reproduced: each other reading, computed."""

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations

from tests.ledger.cases import (
    FULL,
    NAMES,
    NONE,
    PEAK,
    both,
    drift_points,
    drift_reduction,
    gust,
    on_model,
    vehicles,
    with_drift,
    without_drift,
    zero,
)
from tests.ledger.claims_appendices import FAST, SLOW, single_pole_duration
from tests.ledger.computed import Value
from tvclin.linear.deflections import trim_deflection
from tvclin.linear.modes import unstable_modes
from tvclin.linear.plant import Plant
from tvclin.vehicle.coefficients import Coefficients
from tvclin.vehicle.vehicle import STANDARD_GRAVITY
from tvclin.vehicle.vehicle_file import load_vehicle

Reading = Callable[[Coefficients], float]

CLAIMS = (
    "drift-24-percent-at-20",
    "single-pole-28-s",
    "single-pole-tau-beta-14",
    "tri-no-band-reduction",
    "tri-no-band-4",
)
"""The claims for which there are other readings."""
LONG = 20.0
"""tau beta of the claim of 24 percent."""
FORCES = {
    "W": "weight",
    "I": "moment_of_inertia",
    "N": "normal_force_slope",
    "T": "thrust",
    "F_A": "axial_force",
}
"""What in Table I looks ten times too small together."""


def reductions_by_drift() -> list[Value]:
    """Return the reduction by drift [percent] at tau beta = 20 and K = 1 in other readings."""
    return [both(label, reading) for label, reading in _readings().items()]


def reductions_with_factors_of_ten() -> list[Value]:
    """Return the same where only some of W, I, N, T and F_A are ten times what Table I says.

    All five together change nothing. The one nearest to the claim comes first.
    """
    some = [subset for n in range(1, len(FORCES)) for subset in combinations(FORCES, n)]
    return sorted(map(_ten_times, some), key=lambda v: max(abs(x - 24.0) for x in v.numbers))


def _readings() -> dict[str, Reading]:
    def changed(**values: Callable[[Coefficients], float]) -> Reading:
        def reduction(c: Coefficients) -> float:
            return drift_reduction(c.replace(**{k: f(c) for k, f in values.items()}), LONG, FULL)

        return reduction

    def scaled(factor: float) -> Reading:
        return changed(b1=lambda c: factor * float(c.b1), b2=lambda c: factor * float(c.b2))

    def model(name: str, switch: str = "report") -> Reading:
        return lambda c: _percent(on_model(c, LONG, FULL, name, switch))

    return {
        "(18) as printed, relative to (12)": lambda c: drift_reduction(c, LONG, FULL),
        "normalisation: difference in points of trim": lambda c: drift_points(c, LONG, FULL),
        "normalisation: (12) relative to (18)": _excess_of_12,
        "normalisation: (18) over the largest trim deflection with drift": _of_trim_with_drift,
        "a: the dead band of the trim deflection, literally": model("drift", "literal"),
        "model: exact cubic (B7)": model("drift-exact"),
        "model: exact cubic, literally": model("drift-exact", "literal"),
        "model: quartic": model("drift-and-speed"),
        "abscissa: duration times the fast root of (B7)": _times_fast_root,
        "abscissa: tau = 20 s": lambda c: drift_reduction(c, 20.0 * float(c.beta), FULL),
        "abscissa: tau beta/2 = 20": lambda c: drift_reduction(c, 2.0 * LONG, FULL),
        "misprint: b1 without its moment arms, b1 = C1": changed(b1=lambda c: float(c.C1)),
        "misprint: b2 = 0": changed(b2=lambda _: 0.0),
        "misprint: b1 - b2 doubled": changed(b1=lambda c: float(2.0 * c.b1 - c.b2)),
        "unit slip: W for the mass W/g in b1 and b2": scaled(1.0 / STANDARD_GRAVITY),
        "unit slip: b1 and b2 doubled": scaled(2.0),
        "unit slip: b1 and b2 ten times": scaled(10.0),
    }


def single_pole_ends() -> list[Value]:
    """Return the durations [s] at which y = 1 in each reading of appendix C."""
    values = list(single_pole_duration().values)
    second = SLOW / FAST
    root = second**0.5
    to_second = Value("(C9), logarithm to second order", 2.0 / SLOW * (root + second / 2.0))
    return [*values, to_second]


def rounds_to_38_below() -> float:
    """Return the tau beta below which eq (12) at K = 0 is above 37.5 percent."""
    return zero(lambda b: 100.0 * without_drift(b, NONE) - 37.5, 3.0, 4.0)


def least_limits() -> list[Value]:
    """Return the limits [percent] without dead band near tau beta = 4, in other readings."""
    first = 7.5 * float(vehicles()[0].beta)
    return [
        Value("(12) at tau beta = 4", 100.0 * without_drift(4.0, NONE)),
        Value("(12) for I at 7.5 s", 100.0 * without_drift(first, NONE), "-"),
        both("(18) at tau beta = 4", lambda c: 100.0 * with_drift(c, 4.0, NONE)),
        both("exact cubic at tau beta = 4", lambda c: 100.0 * on_model(c, 4.0, NONE)),
    ]


def _percent(limit: float) -> float:
    return 100.0 * (1.0 - limit / without_drift(LONG, FULL))


def _excess_of_12(c: Coefficients) -> float:
    return 100.0 * (without_drift(LONG, FULL) / with_drift(c, LONG, FULL) - 1.0)


def _of_trim_with_drift(c: Coefficients) -> float:
    trim = trim_deflection(Plant(c, "drift"), gust(c, LONG))
    return 100.0 * (1.0 - with_drift(c, LONG, FULL) / float(trim.peak / (-c.B * PEAK)))


def _times_fast_root(c: Coefficients) -> float:
    fast = float(unstable_modes(Plant(c, "drift-exact")).poles[0])
    return _percent(on_model(c, LONG * float(c.beta) / fast, FULL))


def _ten_times(symbols: tuple[str, ...]) -> Value:
    computed = []
    for name in NAMES:
        vehicle = load_vehicle(name)
        larger = {FORCES[symbol]: 10.0 * getattr(vehicle, FORCES[symbol]) for symbol in symbols}
        c = Coefficients.from_vehicle(replace(vehicle, **larger))
        computed.append(drift_reduction(c, LONG, FULL))
    return Value(f"Table I: {', '.join(symbols)} ten times", *computed)
