"""The least deflection limits: closed forms, any wind, the optimum, recoverable states."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
