"""tvclin: how much thrust-vector deflection a booster needs to survive a wind.

The names of an ordinary week are here, all others in their chapters:

- `tvclin.vehicle`: vehicles, their files, structure and filters
- `tvclin.winds`: winds, gusts, soundings
- `tvclin.linear`: plants, poles and residues, exact responses
- `tvclin.ascent`: a vehicle over its flight, from files and other tools; winds along it
- `tvclin.boundary`: boundary limits, limit shapes, the minimum-peak control
- `tvclin.control`: autopilots, laws, margins
- `tvclin.flights`: flights of laws, in one plane, in two, with six degrees of freedom
- `tvclin.case`: a vehicle in a wind, with its nozzle and autopilot
- `tvclin.requirement`: required deflection of a wind, a study, and over a flight
- `tvclin.nozzle`: duty of a nozzle: angle, rate, travel, torque, power
- `tvclin.ensembles`: dispersions, campaigns, archives of winds
- `tvclin.design`: gains for the minimum deflection, trials of laws, the worst case in a box
- `tvclin.studyfile`: study files, with all questions about a vehicle
- `tvclin.plots`: figures

A name is loaded when it is first used, so that ``import tvclin`` is quick.
"""

from tvclin.base.public_names import public_names

__version__ = "0.1.0"
__getattr__, __dir__, __all__ = public_names(__name__, __file__)
