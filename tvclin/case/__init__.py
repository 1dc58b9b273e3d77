"""A case: a vehicle in a wind, with its nozzle, its autopilot and the load on its structure.

`Case` and `Nozzle`; the bound on a load, `LoadBound` and `FlownLoad`; the numbers of a nozzle's
data sheet, `NozzleData`; turbulence, `TurbulenceRequest`, and an autopilot in it,
`LoopInTurbulence`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
