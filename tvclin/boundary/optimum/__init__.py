"""The minimum-peak control of appendix C: the least deflection with which a wind can be survived.

    min peak |delta|   with   integral of e^(-beta_i t) delta(t) dt = D_i,   eq (C1)

for every unstable pole, not only the fastest; `boundary_limit` asks less, and for a given kind
of control. The files inside: `constraints` states the moments, `two_poles` holds (C5) to (C9),
`dual` solves the general problem, `minimum_peak` puts the answers together, `least_peaks` finds the
peak alone for a batch, and `rate_limit` adds a limit of the deflection rate.
"""
