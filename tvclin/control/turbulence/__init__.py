"""The loop of an autopilot in turbulence, by covariance: linear, without limits.

`driven_loop` joins loop and shaping filter; `loop_covariance` is its stationary covariance, and
`covariance_history` that about the response to a known wind, of one vehicle or along a flight,
by the steps of `covariance_march`.
"""
