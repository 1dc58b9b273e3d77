"""The minimum-peak control of appendix C: the least deflection with which a wind can be survived.

    min peak |delta|   with   integral of e^(-beta_i t) delta(t) dt = D_i,   eq (C1)

for every unstable pole, not only the fastest; `boundary_limit` asks less, and for a given kind
of control. The rooms inside: `constraints` states the moments, `two_poles` holds (C5) to (C9),
`dual` solves the general problem, `minimum_peak` puts the answers together, `least_peaks` finds the
peak alone for a batch, and `rate_limit` adds a limit of the deflection rate.
"""

from tvclin.optimum.least_peaks import least_peaks
from tvclin.optimum.minimum_peak import (
    NOT_CONVERGED,
    Certificate,
    Optimum,
    optimum_deflection,
)
from tvclin.optimum.rate_limit import RateLimitedOptimum, optimum_with_rate_limit
from tvclin.optimum.two_poles import (
    early_switch,
    late_switch,
    longest_single_pole_duration,
    neglecting_the_fast_pole,
    single_pole_validity,
    switch_variable,
    switching_ratio,
)

__all__ = [
    "NOT_CONVERGED",
    "Certificate",
    "Optimum",
    "RateLimitedOptimum",
    "early_switch",
    "late_switch",
    "least_peaks",
    "longest_single_pole_duration",
    "neglecting_the_fast_pole",
    "optimum_deflection",
    "optimum_with_rate_limit",
    "single_pole_validity",
    "switch_variable",
    "switching_ratio",
]
