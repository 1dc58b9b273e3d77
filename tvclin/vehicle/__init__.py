"""A vehicle, its files, and the coefficients of its motion.

- A vehicle: `load_vehicle` by name or from a file, `list_vehicles`, or by hand `Vehicle`.
- Where only coefficients are known: `LinearVehicle`; `load_any_vehicle` takes both kinds of files.
- Of its motion: `Coefficients`.
- Flexible bodies, liquids and engines: a `Structure` of `BendingMode`, `SloshTank` and `Engine`.
- Damping from tables of coefficients: `aerodynamic_damping`, `jet_damping`.
- Of sensors and commands: `Filter`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
