"""Stability margins that are also valid on an unstable plant.

The files inside: `loop` is what has margins, `sampled_loop` the same of a law in steps, `record`
holds the answer, `bands` that of each mode (`band_terms` its arithmetic), and `criteria` judges
them. The arithmetic is in `numerics.loop_margins`.
"""
