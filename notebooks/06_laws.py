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
# # How near to the minimum can a law come that knows no forecast?
#
# Trim follows the wind, and needs much deflection. The minimum knows the wind beforehand. Between
# them are laws that know only what they measure now.

# %%
import numpy as np

import tvclin as tv
from tvclin.plots import response_chart

# %%
vehicle = tv.load_vehicle("configuration-i")
plant = tv.Plant.from_vehicle(vehicle, model="fixed-path")
beta, peak = plant.coefficients.beta, np.radians(5.0)
wind = tv.TriangularWind(peak=peak, duration=4.0 / beta)

# %% [markdown]
# Three limits to compare with, over full trim.

# %%
known = float(tv.optimum_deflection(plant, wind).peak / (peak * plant.coefficients.B))
blind = float(tv.forecast_free_limit(plant, wind).limit)
trim = float(tv.boundary_limit(plant, wind, dead_band=1.0).limit)
print(f"wind known {known:.3f}; no forecast {blind:.3f}; trim {trim:.3f}")

# %% [markdown]
# The recoverable-attitude law leans into the wind that it feels, but only as far as it could
# still come back from if the wind stopped at this moment:
#
# $$\frac{\delta}{B} = z - k w + g\,(z - Z), \qquad
# |Z| \le \min\big(r D,\ k \max(A, 1.1\,|w|) - \kappa D\big), \qquad D = \delta_{max}/B .$$
#
# $z$ is the coordinate of the growing mode, $w$ the wind that is felt and $Z$ the lean; $r$ is the
# part of the recoverable set that is used, $A$ the design peak and $\kappa$ the trust. Half
# relief is three constant gains that turn the vehicle by half of the wind.

# %% tags=["within 2e-3"]
laws = {
    "trim": tv.TrimLaw(plant),
    "dead band 0.5": tv.control.DeadBandLaw(plant, dead_band=0.5),
    "half relief": tv.SaturatedLaw(tv.control.half_relief_gains(plant.coefficients)),
    "recoverable attitude": tv.RecoverableAttitudeLaw(plant, design_peak=peak),
}
needs = {
    name: float(tv.closed_loop_boundary(plant, law, wind, sample_rate=50).limit)
    for name, law in laws.items()
}
for name, need in needs.items():
    print(f"{name:20s} {need:.4f} of full trim")

# %% [markdown]
# One flight of it, with 1.2 times what it needs: the nose goes into the wind before the wind is
# at its peak.

# %%
name = "recoverable attitude"
times = np.linspace(0.0, 2.5 * float(wind.duration), 401)
limit = 1.2 * needs[name] * plant.coefficients.B * peak
flown = tv.fly(plant, laws[name], wind, times, deflection_limit=limit)
_ = response_chart(flown, f"Law {name}, with 1.2 times the limit that it needs", limit=limit)

# %% [markdown]
# Now what it cannot do. A wind that jumps to its peak leaves no time to lean, and in one that
# turns round the vehicle leans the wrong way.

# %% tags=["within 2e-3"]
winds = tv.design.standard_winds(peak, float(wind.duration))
hard = {
    kind: [
        float(tv.closed_loop_boundary(plant, laws[law], winds[kind], sample_rate=25).limit)
        for law in ("trim", name)
    ]
    for kind in ("sawtooth, jumps first", "full reversal")
}
for kind, (by_trim, by_leaning) in hard.items():
    print(f"{kind:22s} trim {by_trim:.2f}, {name} {by_leaning:.2f}")

# %% [markdown]
# **Try:** `trust=1.0`, which gives up the reserve against a wrong B; or a
# `tv.control.WindEstimator(bandwidth=2)` in place of a measured angle of attack.

# %% tags=["within 2e-3"]
by_trim, by_leaning = hard["full reversal"]
answer = (
    f"In a triangular wind it needs {needs[name]:.2f} of full trim without a forecast, where "
    f"{blind:.2f} is the least possible and trim needs {needs['trim']:.2f}; in a wind that "
    f"reverses it needs {by_leaning:.2f}, and trim {by_trim:.2f}."
)
print(answer)
