"""Two planes that share a deflection limit: boundary, minimum, and bound without a forecast.

`pair` has the demands of both planes of a vehicle in one wind; `limit`, `optimum` and `unforeseen`
compute the three quantities.
"""
