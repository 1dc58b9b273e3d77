"""The autopilot: feedback of attitude, rate and angle of attack, with actuator and delay.

Files, lowest first: `actuator` between command and deflection; `feedback`, the checked numbers of
an autopilot; `wiring`, its loop in state space and polynomials, sampled or not; `wind_response` of
the closed loop; `autopilot` itself; `gains` by design methods, and over the flight; `design_rules`,
as files name them; `margin_bounds` of any autopilot; `detuning` of bending modes and tanks.
"""
