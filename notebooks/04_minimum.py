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
# # What is the minimum deflection of any control?
#
# If the whole wind were known beforehand, which limit would suffice? Appendix C of the report seeks
#
# $$\min_\delta\ \max_t |\delta(t)| \quad\text{such that}\quad
# (p_k + b_1)\int_{t_0}^\infty e^{-p_k t}\,\delta\,dt
# = -B\,(p_k + b_2)\int_0^\infty e^{-p_k t}\,\alpha_w\,dt$$
#
# for every unstable pole $p_k$ (here without the small gravity term $q$). The answer comes with its
# own proof, and everything else is compared with it.

# %%
import numpy as np

import tvclin as tv
from tvclin.plots import response_chart

# %%
vehicle = tv.load_vehicle("configuration-i")
plant = tv.Plant.from_vehicle(vehicle, model="drift-exact")
wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
start = 0.0
best = tv.optimum_deflection(plant, wind, start=start)
best

# %% [markdown]
# The peak that this control reaches, and a lower bound that no control can go below. They agree
# to rounding: that is the proof.

# %%
proof = best.certificate
print(
    f"reached {np.degrees(proof.primal):.6f} deg, impossible below {np.degrees(proof.dual):.6f} deg"
)

# %% [markdown]
# In comparison: the boundary limits of trim with a dead band, and the lower bound of every law
# without a forecast that must survive the wind even if it stops for good at any instant.

# %%
B = plant.coefficients.B * wind.peak
rows = {
    "trim, then hold, K = 1": abs(tv.boundary_limit(plant, wind, dead_band=1.0).deflection),
    "trim, then hold, K = 0.5": abs(tv.boundary_limit(plant, wind, dead_band=0.5).deflection),
    "lower bound, no forecast": abs(B * tv.forecast_free_limit(plant, wind).limit),
    "the whole wind known": best.peak,
}
for name, peak in rows.items():
    print(f"{name:28s} {np.degrees(peak):.4f} deg")

# %% [markdown]
# A long wind excites the slow mode of the flight path as well. Then one constant deflection is not
# sufficient: the control switches once, between its two limits.

# %%
long = tv.TriangularWind(peak=np.radians(5.0), duration=40.0)
switching = tv.optimum_deflection(plant, long)
print(f"peak {np.degrees(switching.peak):.4f} deg, switches at {switching.switch_times.round(3)} s")
print(f"nothing is left that grows: {tv.is_stable(plant, switching.deflection, long)}")

# %%
times = np.linspace(0.0, 60.0, 601)
response = tv.attitude_response(plant, switching.deflection, long, times)
_ = response_chart(response, "The least peak deflection in a wind of 40 s", limit=switching.peak)

# %% [markdown]
# Where does the theory of one pole end? Up to this duration of a triangular wind the slow pole
# costs nothing.

# %%
edge = float(tv.boundary.single_pole_validity(plant.coefficients))
print(f"{edge:.1f} s")

# %% [markdown]
# A nozzle cannot jump. With a limit on its rate the least peak is a little larger.

# %%
rate = np.radians(0.5)
limited = tv.boundary.optimum_with_rate_limit(plant, wind, rate_limit=rate, start=start)
print(f"{limited.peak / best.peak:.3f} times as much with {np.degrees(rate):g} deg/s")

# %% [markdown]
# **Try:** `start=-2.0`, a control that acts two seconds before the wind comes; or a start after
# it.

# %%
answer = (
    f"{np.degrees(best.peak):.3f} deg: no control whatever that acts from {start:g} s on can "
    f"survive this wind with less, and trim takes "
    f"{np.degrees(rows['trim, then hold, K = 1']):.3f} deg."
)
print(answer)
