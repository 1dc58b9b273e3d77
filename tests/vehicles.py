"""The two vehicles of Table I, as numbers in SI."""

import numpy as np

_TABLE_I = {
    "weight": (1.48e6, 1.393e7),
    "moment_of_inertia": (0.225e8, 1.033e9),
    "normal_force_slope": (0.667e6, 0.562e7),
    "thrust": (2.495e6, 3.334e7),
    "aerodynamic_arm": (9.45, 28.78),
    "control_arm": (23.56, 50.27),
    "axial_force": (0.807e5, 0.962e6),
    "velocity": (538.81, 614.23),
    "attitude": (np.radians(44.83), np.radians(37.52)),
    "time": (66.0, 85.0),
}
CONFIGURATION_I, CONFIGURATION_II = (
    {name: numbers[k] for name, numbers in _TABLE_I.items()} for k in range(2)
)
