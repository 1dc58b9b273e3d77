"""A vehicle, its files, and the coefficients of its motion."""

from tvclin.base.doors import door

__getattr__, __dir__, __all__ = door(__name__, __file__)
