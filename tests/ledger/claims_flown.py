"""The report's words on figures 6 to 11: the theory against flights, frozen and along a trajectory.

The report's flights are not printed as numbers. Those here are flown with its equations of motion,
frozen at the time of Table I or along a trajectory that is reconstructed from it: `flown`.
"""

from collections.abc import Callable
from functools import partial

from tests.ledger.cases import FULL, HALF, band, both, on_model, with_drift
from tests.ledger.computed import Computed, Value
from tests.ledger.flown import Attitudes, Boundaries, attitudes, boundaries
from tvclin.vehicle.coefficients import Coefficients

EXCESS = "percent, (18) above the flown boundary"
SHARE = "cases in which the theory is the worse"


def _limits(along: bool, verdict: Callable[[Boundaries], tuple[bool, ...]]) -> Computed:
    computed = [boundary for boundary in boundaries() if boundary.along is along]
    values = [Value(one.gust.name, *one.excess) for one in computed]
    if not along:
        values += [
            both(f"exact cubic, {band(K)}, tau beta = {b:g}", partial(_excess, tau_beta=b, K=K))
            for K in (FULL, HALF)
            for b in (4.0, 8.0, 20.0)
        ]
    return Computed(tuple(values), all(all(verdict(one)) for one in computed), EXCESS)


def _excess(c: Coefficients, tau_beta: float, K: float) -> float:
    """As for flights, whose dead band is left by trim itself, but without flying."""
    exact = on_model(c, tau_beta, K, switch="literal")
    return 100.0 * (with_drift(c, tau_beta, K) / exact - 1.0)


def _errors(along: bool, verdict: Callable[[Attitudes], tuple[bool, ...]]) -> Computed:
    computed = [attitude for attitude in attitudes() if attitude.along is along]
    groups = {SHARE: computed}
    for plane in ("pitch", "yaw"):
        for K in (FULL, HALF):
            group = [one for one in computed if (one.gust.plane, one.dead_band) == (plane, K)]
            groups[f"{plane}, {band(K)}"] = group
    values = []
    for label, group in groups.items():
        held = [verdict(one) for one in group]
        counts = (f"{sum(column)} of {len(column)}" for column in zip(*held, strict=True))
        values.append(Value(label, *counts))
    return Computed(tuple(values), all(all(verdict(one)) for one in computed))


_CLAIMS: dict[str, Callable[[bool], Computed]] = {
    "agreement": lambda along: _limits(along, lambda one: one.agree),
    "conservative_boundary": lambda along: _limits(along, lambda one: one.conservative),
    "divergence": lambda along: _errors(along, lambda one: one.diverges_faster),
    "convergence": lambda along: _errors(along, lambda one: one.converges_slower),
}
"""Eq (18), K = 1: within 5 percent of every flown boundary, and nowhere below it. The attitude of
(B9) is the larger at t = tau: at 0.9 times eq (18), and at 1.1 times."""

COMPUTATIONS: dict[str, Callable[[], Computed]] = {
    f"{name}_{flown}": partial(claim, along)
    for name, claim in _CLAIMS.items()
    for flown, along in (("frozen", False), ("along_the_trajectory", True))
}
"""Each claim of flights with frozen parameters, and of flights along the trajectory."""
