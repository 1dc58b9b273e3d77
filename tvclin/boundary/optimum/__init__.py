"""The minimum-peak control of appendix C: the minimum deflection with which a wind can be survived.

    min peak |delta|   with   integral of e^(-beta_i t) delta(t) dt = D_i,   eq (C1)

for every unstable pole, not only the fastest; `boundary_limit` requires less, and for a given kind
of control. The files inside: `moments` states the conditions, `two_poles` has (C5) to (C9), `dual`
solves the general problem, `minimum_peak` returns the deflection with its proof, or the peak for a
batch, `rate_limit` adds a limit of the deflection rate, and `load_program` one of the load, which
`load_case` computes and bounds.
"""
