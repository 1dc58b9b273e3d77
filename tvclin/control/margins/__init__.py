"""Stability margins that are also valid on an unstable plant.

Files: `loop`, polynomials or matrices with a delay, also sampled; `margins` of the whole loop;
`bands`, the margins of the rigid body and of each mode; `criteria`, which judge them. The
arithmetic is in `numerics.loop_margins`.
"""
