"""Winds: histories of the wind angle of attack alpha_w.

A positive wind angle lowers the angle of attack (alpha = theta - gamma - alpha_w): it is a tail
wind, or the downwind part of a cross wind.
"""

from tvclin.base.doors import door

__getattr__, __dir__, __all__ = door(__name__, __file__)
