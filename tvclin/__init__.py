"""tvclin: how much thrust-vector deflection a booster needs to survive a wind.

Everything public stands in ``__init__.pyi``; what is behind it is loaded when it is first used, so
that ``import tvclin`` costs next to nothing.
"""

import lazy_loader

__version__ = "0.1.0"
__getattr__, __dir__, _names = lazy_loader.attach_stub(__name__, __file__)
__all__ = [name for name in _names if name not in {"boundary", "plots"}]
