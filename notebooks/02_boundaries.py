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
# # How much deflection does this wind require, and what does a dead band save?
#
# This is the report's question. The nozzle trims the wind's moment until that takes a part K of its
# limit, the dead band. Then it goes to its limit. Which limit is just sufficient?
#
# The attitude has one growing mode, $e^{pt}$. The vehicle survives if the deflection leaves nothing
# of it behind, eq (4b). With drift, as here, that reads
#
# $$(p + b_1)\int_0^\infty e^{-pt}\,\delta(t)\,dt
# + B\,(p + b_2)\int_0^\infty e^{-pt}\,\alpha_w(t)\,dt = 0 ,$$
#
# with $p = \beta$ in the report's model; on a fixed path $b_1 = b_2 = 0$. What comes early counts
# most.

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
# Is that so? At the boundary limit the growing mode has no residue. With a tenth less deflection
# it has one, and grows.

# %%
boundary = tv.boundary_limit(plant, wind, dead_band=K)
on_it = tv.trim_then_hold(plant, wind, boundary.deflection, dead_band=K)
below = tv.trim_then_hold(plant, wind, 0.9 * boundary.deflection, dead_band=K)
for name, held in {"on the boundary": on_it, "a tenth less": below}.items():
    print(f"{name}: {'survives' if tv.linear.judge(plant, held, wind).stable else 'is lost'}")

# %% [markdown]
# One number decides, $\tau\beta$: the duration of the wind in units of the time in which the
# vehicle falls over. The chart is of the model *with drift*, eq (18). There the vehicle moves with
# the wind, so that even $K = 1$ never needs the whole of trim: its curve has a maximum and falls.
# With a small $K$ long winds need little, because the vehicle has leaned into the wind early.

# %%
_ = boundary_chart(coefficients=plant.coefficients)

# %% [markdown]
# On a *fixed path*, eq (12), nothing relieves the vehicle. There long winds do need the whole of
# trim if $K = 1$:

# %%
fixed = tv.Plant.from_coefficients(plant.coefficients, model="fixed-path")
for tau_beta in (4.0, 14.0, 40.0, 200.0):
    long = tv.TriangularWind(peak=wind.peak, duration=tau_beta / float(fixed.coefficients.beta))
    limits = [float(tv.boundary_limit(model, long).limit) for model in (fixed, plant)]
    print("tau*beta = {:5.1f}: fixed path {:.3f}, with drift {:.3f}".format(tau_beta, *limits))

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
