"""Stability margins that mean what they say, also on an unstable plant.

The files inside: `loop` is what has margins, `record` holds the answer, and `criteria` judges it.
The arithmetic is in `kernels.loop_margins`.
"""
