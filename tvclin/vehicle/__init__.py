"""Vehicle: its files, its structure, and the coefficients of its motion.

- What is the vehicle? `load_vehicle` by name or from a file, `list_vehicles`; by hand a `Vehicle`.
- Where only its coefficients are known? A `LinearVehicle`; `load_any_vehicle` reads both kinds of
  files.
- How does it turn? `Coefficients`: beta, B, drift and damping.
- How much do air and jet damp? `aerodynamic_damping`, `jet_damping`.
- How does it bend and slosh? A `Structure` of `BendingMode`, `SloshTank` and `Engine`.
- What lies between sensors and commands? A `Filter`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
