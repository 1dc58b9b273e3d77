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
# # Which motions of this booster grow, and how fast?
#
# A booster whose aerodynamic force acts ahead of its centre of gravity falls over by itself. This
# notebook takes one vehicle from its data to its unstable poles, and shows what a deflection and
# a wind do to them. Change the name of the vehicle, or any number, and run on.

# %%
import control
import numpy as np

import tvclin as tv
from tvclin.plots import pole_map, response_chart

# %%
vehicle = tv.load_vehicle("configuration-i")
vehicle

# %% [markdown]
# The linear theory needs few numbers of the vehicle, on a fixed flight path only two:
#
# $$\ddot\theta = \mu_\alpha (\theta - \alpha_w) - \mu_\delta\,\delta, \qquad
# \mu_\alpha = \frac{N l_a}{I} = \beta^2, \qquad
# \mu_\delta = \frac{T l_c}{I} = \frac{\beta^2}{B} .$$
#
# $\mu_\alpha$ is the angular acceleration of one radian of angle of attack, $\mu_\delta$ that of
# one radian of deflection. $\beta$ is how fast the vehicle falls over, and
# $B = \mu_\alpha/\mu_\delta$ is the deflection that holds one radian of wind.

# %%
coefficients = tv.Coefficients.from_vehicle(vehicle)
coefficients

# %% [markdown]
# Four models, from the simplest to the one with all degrees of freedom of the plane. Each has one
# fast pole on the right, near beta. Those with a flight path have a slow one as well.

# %%
for model in tv.linear.available_models(coefficients):
    plant = tv.Plant.from_coefficients(coefficients, model=model)
    print(f"{model:16s}", np.round(tv.linear.all_modes(plant).poles, 4))

# %%
_ = pole_map(coefficients)

# %% [markdown]
# A mode grows with what excites it: its residues say how strongly. The residue of the attitude to
# a short push of the nozzle and that to a short gust differ by the factor B only, on a fixed
# path.

# %%
plant = tv.Plant.from_coefficients(coefficients, model="drift-exact")
modes = tv.unstable_modes(plant)
modes

# %%
for pole, push, gust in zip(
    modes.poles, modes.deflection_residues, modes.wind_residues, strict=True
):
    print(f"pole {pole:.4f} 1/s: residue {push:8.4f} of a push, {gust:8.4f} of a gust")

# %% [markdown]
# The plant is an ordinary python-control system: everything of python-control works on it. One
# degree of deflection, held in still air, turns the vehicle over; after two e-folding times of the
# fast pole the angles are too large for a linear model.

# %%
fast, slow = float(np.max(modes.poles.real)), float(np.min(modes.poles.real))
held = np.radians([[1.0], [0.0]])  # deflection, wind


def response(length):
    """Return the response to the deflection, for so many e-folding times."""
    times = np.linspace(0.0, length / fast, 401)
    return control.forced_response(plant.ss(), times, np.broadcast_to(held, (2, times.size)))


_ = response_chart(response(2.0), "One degree of deflection, held in still air")

# %% [markdown]
# On paper it goes on: the attitude grows as the fast pole says, once the other modes have fallen
# behind.

# %%
long = response(10.0)
late = long.time > 0.75 * long.time[-1]
measured = np.polyfit(long.time[late], np.log(np.abs(long.outputs["attitude"][late])), 1)[0]
print(f"fastest pole {fast:.4f} 1/s; the attitude grows at {measured:.4f} 1/s in the end")

# %% [markdown]
# **Try:** make the vehicle stable with `vehicle.replace(aerodynamic_arm=-1.0)`; then the fast pole
# is gone, `coefficients.beta` says so, and on a fixed path no wind requires any deflection.
# The slow pole of the flight path stays.

# %%
kind = "unstable" if coefficients.mu_alpha > 0.0 else "stable"
answer = (
    f"{vehicle.name} is aerodynamically {kind}: its fastest unstable pole is at {fast:.4f} 1/s, so "
    f"an error doubles in {np.log(2) / fast:.2f} s; its slowest is at {slow:.4f} 1/s."
)
print(answer)
