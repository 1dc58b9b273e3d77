"""The least deflection limits: closed forms, any wind, the optimum, recoverable states."""

from tvclin.base.doors import door

__getattr__, __dir__, __all__ = door(__name__, __file__)
