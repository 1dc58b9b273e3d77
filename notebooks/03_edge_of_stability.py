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
# # Does it survive? Why a simulation cannot judge the edge of stability
#
# On the boundary two numbers that grow as e^(pt) cancel. A simulation has sixteen digits, and loses
# them. This notebook computes responses on the edge, with python-control and exactly.
#
# Long after the wind the attitude is
#
# $$\theta(t) = R\,e^{pt} + \text{what does not grow}, \qquad
# R = -\frac{p}{2B}\int_0^\infty e^{-pt}\,\big[\delta(t) + B\,\alpha_w(t)\big]\,dt ,$$
#
# and on the boundary $R = 0$.
#
# A step of a simulation rounds off one part in $10^{16}$. That error is multiplied by $e^{pt}$ as
# well, and there is nothing to cancel it: at $pt = 37$ it is as large as the attitude itself.

# %%
import control
import matplotlib.pyplot as plt
import numpy as np

import tvclin as tv

# %%
plant = tv.Plant.from_coefficients(tv.Coefficients.from_beta(beta=0.5, B=0.1), model="fixed-path")
wind = tv.TriangularWind(peak=np.radians(5.0), duration=20.0)
limit = tv.boundary_limit(plant, wind, dead_band=0.0).deflection
edge = tv.linear.ConstantDeflection(limit=limit)

# %% [markdown]
# The same plant, the same wind, the same deflection, simulated on a grid that contains every knot
# (which is python-control's best case), and answered by `tvclin`. They are one curve, for a
# while.

# %%
times = np.linspace(0.0, 100.0, 1001)
exact = tv.attitude_response(plant, edge, wind, times)
inputs = np.stack([edge(times), wind(times)])
simulated = control.forced_response(plant.ss(), times, inputs)

fig, axes = plt.subplots()
axes.plot(times, np.degrees(exact.outputs[0]), label="exact")
axes.plot(times, np.degrees(simulated.outputs[0]), "--", label="simulated")
axes.set(xlabel="time [s]", ylabel="attitude error [deg]", ylim=(-6.0, 6.0))
_ = axes.legend()

# %% [markdown]
# How many digits remain?

# %% tags=["rounding"]
error = np.abs(simulated.outputs[0] - exact.outputs[0]) / np.max(np.abs(exact.outputs[0]))
for part in (0.2, 0.4, 0.6, 0.8, 1.0):
    point = int(part * (times.size - 1))
    print(f"t = {times[point]:5.1f} s: relative error {error[point]:.1e}")

# %% [markdown]
# Neither the plant nor the grid is to blame: any method that goes forward in time multiplies its
# rounding by e^(pt). `tvclin` integrates the growing mode backwards from its end, and judges by
# its residue.

# %%
verdict = tv.linear.judge(plant, edge, wind)
verdict

# %% [markdown]
# One part in a million below, and above: the residue has changed its sign, and after half a minute
# the responses diverge.

# %%
nearly = [tv.linear.ConstantDeflection(limit=(1.0 + e) * limit) for e in (-1e-6, 1e-6)]
for name, held in zip(("below", "above"), nearly, strict=True):
    response = tv.attitude_response(plant, held, wind, [20.0, 30.0, 40.0])
    print(name, tv.residues(plant, held, wind), np.degrees(response.outputs[0]).round(4))

# %% [markdown]
# **Try:** a shorter wind in a shorter time (4 s in 12 s), where the simulation is sufficient; or a
# grid on which the peak of the wind is not a point (`np.linspace(0, 100, 1000)`): then the
# simulation is wrong from the peak on, and lost three times as soon.

# %% tags=["rounding"]
wrong = error > 0.01
left = "survives, for nothing" if verdict.stable else "is lost, for something"
seen = (
    f"is wrong by one percent after {times[np.argmax(wrong)]:.1f} s, and cannot be believed from "
    f"there on"
    if np.any(wrong)
    else f"is within one percent up to {times[-1]:g} s"
)
answer = (
    f"In {wind.duration:g} s of wind it {left} is left at its unstable pole; a simulation in steps "
    f"of {times[1]:.4g} s {seen}."
)
print(answer)
