from .case import Case as Case
from .load import FlownLoad as FlownLoad
from .load import LoadBound as LoadBound
from .nozzle import Nozzle as Nozzle
from .nozzle import NozzleData as NozzleData
from .turbulence import LoopInTurbulence as LoopInTurbulence
from .turbulence import TurbulenceRequest as TurbulenceRequest
