"""What commands the deflection: autopilot, margins, laws, and how they compare with trim."""

from tvclin.base.doors import door

__getattr__, __dir__, __all__ = door(__name__, __file__)
