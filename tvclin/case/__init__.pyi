from .case import Case as Case
from .load import FlownLoad as FlownLoad
from .load import LoadBound as LoadBound
from .nozzle import Nozzle as Nozzle
from .nozzle import NozzleData as NozzleData
