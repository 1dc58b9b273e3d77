"""Case: a vehicle in a wind, with its nozzle, its autopilot and the load on its structure.

- What is judged? A `Case`, with its `Nozzle`; the data sheet of the nozzle is `NozzleData`.
- What does the structure bear? A `LoadBound`; the load in the flight of a law is a `FlownLoad`.
- In which turbulence? A `TurbulenceRequest`; an autopilot in it is a `LoopInTurbulence`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
