# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # How much deflection does this wind need, and what does a dead band save?
#
# The report's question. The nozzle trims the wind's moment until a part K of its limit is asked
# for, the dead band, and then goes to its limit. What limit is just enough?

# %%
import numpy as np

import tvclin as tv
from tvclin.plots import boundary_chart

# %%
vehicle = tv.load_vehicle("configuration-i")
plant = tv.Plant.from_vehicle(vehicle, model="drift")
wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
K = 0.5
trim = abs(np.degrees(plant.coefficients.B * wind.peak))
print(f"full trim takes {trim:.3f} deg")

# %% [markdown]
# The boundary limit is a part of full trim. K = 1 trims as long as it can; K = 0 uses the whole
# limit from the first moment on, which needs to know what wind will come.

# %%
for dead_band in (1.0, 0.75, 0.5, 0.25, 0.0):
    found = tv.boundary_limit(plant, wind, dead_band=dead_band)
    degrees = abs(np.degrees(found.deflection))
    print(f"K = {dead_band:4.2f}: {found.limit:.4f} of trim, {degrees:.3f} deg")

# %% [markdown]
# Where do these numbers come from? A growing exponential is left behind unless the deflection
# puts out what the wind has lit, eq (4b) of the report. On the boundary nothing is left:

# %%
boundary = tv.boundary_limit(plant, wind, dead_band=K)
on_it = tv.trim_then_hold(plant, wind, boundary.deflection, dead_band=K)
below = tv.trim_then_hold(plant, wind, 0.9 * boundary.deflection, dead_band=K)
tv.judge(plant, on_it, wind).stable, tv.judge(plant, below, wind).stable

# %% [markdown]
# One number, tau*beta, decides: the duration of the wind in units of the time in which the
# vehicle falls. Long winds need the whole of trim if K = 1, and little if K is small, for then
# the vehicle has been leaning into the wind in time.

# %%
boundary_chart(coefficients=plant.coefficients)

# %% [markdown]
# The same questions as arrays: a thousand durations in one call.

# %%
durations = np.linspace(1.0, 20.0, 1000)
winds = type(wind)(peak=wind.peak, duration=durations)
limits = tv.boundary_limit(plant, winds, dead_band=K).limit
worst = int(np.argmax(limits))
print(f"worst of the durations: {durations[worst]:.1f} s, with {limits[worst]:.3f} of trim")

# %% [markdown]
# A wind of your own has straight lines between its samples, and is answered as exactly.

# %%
measured = tv.SampledWind(
    time=[0.0, 2.0, 3.0, 5.0, 9.0], angle=np.radians([0.0, 3.0, 5.0, 2.0, 0.0])
)
own = tv.boundary_limit(plant, measured, dead_band=K)
print(f"{abs(np.degrees(own.deflection)):.3f} deg")

# %% [markdown]
# **Try:** a `tv.RectangularWind`, a head wind (a negative peak), another `K`. Which K needs
# least at 20 s, and would you dare to fly it? Notebook 6 says what it costs.

# %%
full = abs(np.degrees(tv.boundary_limit(plant, wind, dead_band=1.0).deflection))
answer = (
    f"In a {type(wind).__name__} of {np.degrees(wind.peak):g} deg and {wind.duration:g} s "
    f"{vehicle.name} needs {full:.3f} deg with trim (K = 1), and "
    f"{abs(np.degrees(boundary.deflection)):.3f} deg with K = {K:g}."
)
print(answer)
