"""The linear models: plant, modes, verdict, deflections, the exact response and what it loads."""

from tvclin.base.doors import door

__getattr__, __dir__, __all__ = door(__name__, __file__)
