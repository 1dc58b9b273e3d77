"""Two planes that share one stop: the limit, the minimum, and the bound without a forecast.

`pair` is what both planes of a vehicle ask for in one wind; `limit`, `optimum` and `unforeseen` are
three answers.
"""
