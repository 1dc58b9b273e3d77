"""The report's numbers on attitude responses, and on the theory against the simulation."""

from functools import partial

import numpy as np

from tests.ledger.cases import (
    FULL,
    HALF,
    NONE,
    PEAK,
    attitude,
    attitude_with_drift,
    band,
    both,
    crossing,
    gust,
    on_model,
    summit,
    vehicles,
    with_drift,
    without_drift,
    zero,
)
from tests.ledger.computed import Computed, Value, rounds_to
from tests.report_responses import rectangular_attitude
from tvclin.boundary.closed_forms import rectangular_limit
from tvclin.linear.deflections import trim_then_hold
from tvclin.linear.plant import Plant
from tvclin.linear.response import attitude_responses
from tvclin.vehicle.coefficients import Coefficients

ABOVE, BELOW = 1.1, 0.9
"""The deflections in question, over that of the boundary."""
AFTER = 1.5
"""The time t/tau at which theory and exact roots are compared."""


def beta_of_configuration_i() -> Computed:
    """Eq (B4)."""
    beta = vehicles()[0].beta
    return Computed((Value("", float(beta), "-"),), rounds_to(0.53, float(beta), last=0.01), "1/s")


def tau_beta_at_7_5_s() -> Computed:
    """7.5 s times beta of I."""
    tau_beta = 7.5 * float(vehicles()[0].beta)
    return Computed((Value("", tau_beta, "-"),), rounds_to(4, tau_beta))


def attitude_peak_at_1_1() -> Computed:
    """The peak of eq (13) before it falls through zero; eq (B9) as corrected beside it."""
    where, peak = _peak()
    drift = both(
        "(B9)",
        lambda c: summit(lambda x: attitude_with_drift(c, x, 4.0, ABOVE, FULL), 0.5, 1.0)[1],
    )
    values = (Value("", peak), Value("at t/tau", where), drift)
    return Computed(values, rounds_to(0.16, peak, last=0.01), "deg/deg")


def attitude_peak_at_1_1_in_5_deg() -> Computed:
    """Five times the former."""
    peak = 5.0 * _peak()[1]
    return Computed((Value("", peak),), rounds_to(0.8, peak, last=0.1), "deg")


def attitude_zero_at_1_1() -> Computed:
    """Where eq (13) falls through zero; eq (B9) as corrected beside it."""
    time = crossing(lambda x: attitude(x, 4.0, ABOVE, FULL))
    drift = both("(B9)", lambda c: crossing(lambda x: attitude_with_drift(c, x, 4.0, ABOVE, FULL)))
    return Computed((Value("t/tau", time), drift), rounds_to(1, time))


def attitude_zero_before_the_wind_ends() -> Computed:
    """Eq (13) is zero by t = tau; "mostly" is in more than half of the cases of figures 3 and 4."""
    cases = [(tau_beta, K) for tau_beta in (2.0, 4.0, 8.0, 20.0) for K in (FULL, HALF)]
    in_time = sum(_zero_by_the_end(*case) for case in cases)
    from_on = [Value(f"{band(K)}, tau beta above", _shortest(1.0, K)) for K in (FULL, HALF)]
    share = Value("figures 3 and 4", f"{in_time} of {len(cases)} cases")
    return Computed((share, *from_on), 2 * in_time > len(cases))


def attitude_zero_of_short_gusts() -> Computed:
    """Eqs (9) and (13) are zero by t = 2 tau; a gust of tau beta = 1 is short."""
    at = {
        b: (_rectangle_zero(b), _triangle_zero(b, FULL), _triangle_zero(b, HALF))
        for b in (1.0, 0.5)
    }
    values = (
        Value("1.1 times the boundary, tau beta = 1, t/tau from", min(at[1])),
        Value("to", max(at[1])),
        Value("tau beta = 0.5, t/tau from", min(at[0.5])),
        Value("2 durations suffice for tau beta above, rectangle", _shortest_rectangle(2.0)),
        *(Value(f"triangle, {band(K)}", _shortest(2.0, K)) for K in (FULL, HALF)),
    )
    return Computed(values, max(at[1]) <= 2.0)


def boundary_against_exact_roots() -> Computed:
    """Eq (18) over the boundary of the exact cubic: conservative where it nowhere asks for less."""
    cases = [(b, K) for b in (4.0, 8.0) for K in (FULL, HALF, NONE)]
    values = [
        both(f"{band(K)}, tau beta = {b:g}", partial(_excess, tau_beta=b, K=K)) for b, K in cases
    ]
    until = both(f"{band(FULL)}, more up to tau beta", _no_excess_from)
    holds = all(number >= 0.0 for value in values for number in value.numbers)
    return Computed((*values, until), holds, "percent above the exact cubic")


def divergence_against_exact_roots() -> Computed:
    """Below the boundary, eq (B9) as corrected is larger than the exact cubic."""
    pairs = [_against_exact_roots(BELOW, K) for K in (FULL, HALF)]
    faster = [np.greater(theory.numbers, exact.numbers) for theory, exact in pairs]
    return Computed(tuple(value for pair in pairs for value in pair), bool(np.all(faster)))


def convergence_against_exact_roots() -> Computed:
    """Above the boundary, eq (B9) as corrected has come down less than the exact cubic."""
    pairs = [_against_exact_roots(ABOVE, K) for K in (FULL, HALF)]
    slower = [np.greater(theory.numbers, exact.numbers) for theory, exact in pairs]
    return Computed(tuple(value for pair in pairs for value in pair), bool(np.all(slower)))


def _peak() -> tuple[float, float]:
    return summit(lambda x: attitude(x, 4.0, ABOVE, FULL), 0.5, 1.0)


def _zero_by_the_end(tau_beta: float, K: float) -> bool:
    """A limit that is never left, y K > 1, keeps the attitude zero throughout."""
    if ABOVE * without_drift(tau_beta, K) * K > 1.0:
        return True
    return bool(attitude(1.0, tau_beta, ABOVE, K) <= 0.0)


def _shortest(time: float, K: float) -> float:
    """The tau beta above which eq (13) is zero by this t/tau."""
    return zero(lambda b: attitude(time, b, ABOVE, K), 0.5, 8.0)


def _shortest_rectangle(time: float) -> float:
    return zero(lambda b: _rectangle(time, b), 0.5, 8.0)


def _rectangle(x: float, tau_beta: float) -> float:
    return float(rectangular_attitude(x, tau_beta, ABOVE * rectangular_limit(tau_beta)))


def _rectangle_zero(tau_beta: float) -> float:
    limit = ABOVE * rectangular_limit(tau_beta)
    return crossing(lambda x: rectangular_attitude(x, tau_beta, limit))


def _triangle_zero(tau_beta: float, K: float) -> float:
    return crossing(lambda x: attitude(x, tau_beta, ABOVE, K))


def _excess(c: Coefficients, tau_beta: float, K: float) -> float:
    return 100.0 * (with_drift(c, tau_beta, K) / on_model(c, tau_beta, K) - 1.0)


def _no_excess_from(c: Coefficients) -> float:
    return zero(lambda b: _excess(c, b, FULL), 4.0, 30.0)


def _against_exact_roots(factor: float, K: float) -> tuple[Value, Value]:
    """Attitude at t = 1.5 tau by eq (B9) and by the exact cubic with the same deflection."""

    def exact(c: Coefficients) -> float:
        wind = gust(c, 4.0)
        limit = -factor * with_drift(c, 4.0, K) * float(c.B) * PEAK
        constant = trim_then_hold(Plant(c, "drift"), wind, limit, K)
        times = [AFTER * float(wind.duration)]
        computed = attitude_responses(Plant(c, "drift-exact"), constant, wind, times)["attitude"]
        return float(computed[0]) / -PEAK

    case = f"{factor:g} times the boundary, {band(K)}, tau beta = 4, t/tau = {AFTER:g}"
    return (
        both(f"(B9), {case}", lambda c: attitude_with_drift(c, AFTER, 4.0, factor, K)),
        both("exact cubic", exact),
    )


FUNCTIONS = (
    beta_of_configuration_i,
    tau_beta_at_7_5_s,
    attitude_peak_at_1_1,
    attitude_peak_at_1_1_in_5_deg,
    attitude_zero_at_1_1,
    attitude_zero_before_the_wind_ends,
    attitude_zero_of_short_gusts,
    boundary_against_exact_roots,
    divergence_against_exact_roots,
    convergence_against_exact_roots,
)
