"""The least deflection over a second quantity: the nozzle's rate, or the load of the structure.

The files inside: `ramps` (closed forms of one pole under a rate limit), `rates` and its
`rate_record`, `loads`, its `load_record` and `load_limits`, and the `nozzle_point` of both records.
"""
