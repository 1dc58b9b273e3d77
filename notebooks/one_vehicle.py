# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # One booster, one wind: how much deflection does it need?
#
# Open this file as a notebook (Jupyter with jupytext), or run it cell by cell in an editor.
# Change a number and run on.

# %%
import control
import numpy as np

import tvclin as tv
from tvclin.plots import pole_map

# %% [markdown]
# The vehicle, and what the linear theory needs of it.

# %%
vehicle = tv.load_vehicle("configuration-i")
coefficients = tv.Coefficients.from_vehicle(vehicle)
coefficients

# %% [markdown]
# Its poles in four models, with the residues from the deflection to the attitude. The right half
# plane is shaded: what lies there grows.

# %%
poles = pole_map(coefficients)

# %% [markdown]
# The wind, and the least deflection that survives it when the vehicle is trimmed up to half of its
# limit and the whole limit is used beyond.

# %%
plant = tv.Plant.from_coefficients(coefficients, model="drift")
wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
boundary = tv.boundary_limit(plant, wind, dead_band=0.5)
boundary

# %% [markdown]
# On the boundary no growing exponential is left, eq (4b). What is left is told in words.

# %%
deflection = tv.trim_then_hold(plant, wind, boundary.deflection, dead_band=0.5)
verdict = tv.judge(plant, deflection, wind)
verdict.stable, str(verdict.left_over)

# %% [markdown]
# The exact response, as python-control's own record.

# %%
response = tv.attitude_response(plant, deflection, wind, np.linspace(0.0, 15.0, 301))
response.plot().figure.set_size_inches(7.0, 9.0)

# %% [markdown]
# The plant is an ordinary python-control system: its step response grows, as its poles say.

# %%
step = control.step_response(plant.ss()["attitude", "deflection"], np.linspace(0.0, 5.0, 101))
drawn = step.plot()

# %%
answer = f"{abs(np.degrees(boundary.deflection)):.3f} deg, {boundary.limit:.3f} of full trim"
answer
