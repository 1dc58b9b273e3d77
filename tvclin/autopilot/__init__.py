"""The autopilot: attitude and rate feedback, with actuator and delay, around one plant.

The rooms inside: `actuator` holds what lies between a command and the deflection, `feedback` wires
the loop that `diagram` shows, and `gains` finds gains from poles.
"""

from tvclin.autopilot.actuator import Actuator
from tvclin.autopilot.diagram import LOOP_DIAGRAM
from tvclin.autopilot.feedback import Autopilot
from tvclin.autopilot.gains import canonical_gains, design_gains

__all__ = ["LOOP_DIAGRAM", "Actuator", "Autopilot", "canonical_gains", "design_gains"]
