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
# # Course, first hour: how do nine numbers become a deflection?
#
# This hour goes from the data of a booster to the least deflection that survives a wind, by hand
# first, then with the package. Three exercises stand in the middle; their answers, at the
# end, are computed. The vehicle is made up: put your own in.

# %%
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

import tvclin as tv

# %%
vehicle = tv.Vehicle(
    weight=6.0e6,
    moment_of_inertia=6.0e7,
    normal_force_slope=1.6e6,
    thrust=8.5e6,
    aerodynamic_arm=6.5,
    control_arm=14.0,
    axial_force=1.8e5,
    velocity=470.0,
    attitude=np.radians(52.0),
    name="course vehicle",
)
vehicle

# %% [markdown]
# Two moments turn it, per radian of angle of attack and per radian of deflection:
#
# $$\mu_\alpha = \frac{N l_a}{I}, \qquad \mu_\delta = \frac{T l_c}{I}, \qquad
# \beta = \sqrt{\mu_\alpha}, \qquad B = \frac{\mu_\alpha}{\mu_\delta} .$$
#
# $\beta$ says how fast it falls over, $B$ how much deflection trims a radian of wind.

# %%
mu_alpha = vehicle.normal_force_slope * vehicle.aerodynamic_arm / vehicle.moment_of_inertia
mu_delta = vehicle.thrust * vehicle.control_arm / vehicle.moment_of_inertia
beta, B = np.sqrt(mu_alpha), mu_alpha / mu_delta
known = tv.Coefficients.from_vehicle(vehicle)
print(f"by hand beta = {beta:.4f} 1/s, B = {B:.4f}")
print(f"package beta = {known.beta:.4f} 1/s, B = {known.B:.4f}")

# %% [markdown]
# On a fixed path the attitude obeys $\ddot\theta = \beta^2(\theta - \alpha_w) -
# (\beta^2/B)\,\delta$. Its growing part stays at rest if, eq (4b),
#
# $$\int_0^\infty e^{-\beta t}\,\bigl(\delta(t) + B\,\alpha_w(t)\bigr)\,dt = 0 .$$
#
# Only the sizes count below: the wind requires trim $B\alpha_w$, the nozzle gives
# $\min(B\alpha_w, \delta_{max})$ until the limit is reached, and holds it from there on (K = 1).

# %%
peak, duration = np.radians(4.0), 6.0
wind = tv.TriangularWind(peak=peak, duration=duration)


def weighted(what, start, end):
    """What counts of a history of sizes between two times: the integral of (4b)."""
    whole = [start, *(t for t in (duration / 2, duration) if start < t < end), end]
    return sum(quad(lambda t: np.exp(-beta * t) * what(t), *part)[0] for part in pairwise(whole))


def short_by(limit):
    """What the wind asks for above what a limit gives."""
    leaves = limit / (B * peak) * duration / 2
    given = weighted(lambda t: B * float(wind(t)), 0.0, leaves)
    held = limit * np.exp(-beta * leaves) / beta
    return weighted(lambda t: B * float(wind(t)), 0.0, duration) - given - held


by_hand = brentq(short_by, 1e-4 * B * peak, B * peak)
fixed = tv.Plant.from_vehicle(vehicle, model="fixed-path")
found = abs(float(tv.boundary_limit(fixed, wind, dead_band=1.0).deflection))
print(f"by hand {np.degrees(by_hand):.6f} deg, package {np.degrees(found):.6f} deg")

# %%
limits = np.linspace(0.4, 1.0, 50) * B * peak
figure, axes = plt.subplots(layout="constrained")
axes.plot(np.degrees(limits), [np.degrees(short_by(one)) for one in limits])
axes.axhline(0.0, color="black", linewidth=0.8)
axes.axvline(np.degrees(found), linestyle="--", color="C1", label="boundary of the package")
axes.set(xlabel="deflection limit [deg]", ylabel="what is missing, weighted [deg s]")
_ = axes.legend()

# %% [markdown]
# ## Exercises
#
# 1. The centre of pressure moves a metre aft, to $l_a = 5.5$ m. Trim then takes 15 percent less.
#    Does the boundary fall by as much, by more, or by less?
# 2. A rectangular wind, and the whole limit from its first moment on (K = 0). Find the boundary as
#    a formula of $\beta\tau$.
# 3. With drift, the usual model, a longer wind need not be the worse one. Which duration requires
#    most with K = 1, and how much of trim? Does the report's exit, on the wind, say the same?
#
# **Try:** each before you read on. Paper is sufficient for the second.

# %% [markdown]
# ## Answers
#
# **1.** By more. $B$ falls in proportion to the arm, and with it trim. $\beta$ falls with its
# root: the wind is shorter in falling times, and a shorter wind requires a smaller part of trim.

# %%
aft = tv.Plant.from_vehicle(vehicle.replace(aerodynamic_arm=5.5), model="fixed-path")
after = abs(float(tv.boundary_limit(aft, wind, dead_band=1.0).deflection))
trim_part, need_part = aft.coefficients.B / B, after / found
print(f"trim to {trim_part:.3f}, the boundary to {need_part:.3f} of before")

# %% [markdown]
# **2.** $\int_0^\infty e^{-\beta t}\,y\,dt = \int_0^\tau e^{-\beta t}\,dt$, so
# $y = 1 - e^{-\beta\tau}$.

# %%
rectangle = tv.RectangularWind(peak=peak, duration=duration)
formula = 1.0 - np.exp(-beta * duration)
limit = float(tv.boundary_limit(fixed, rectangle, dead_band=0.0).limit)
print(f"formula {formula:.6f}, package {limit:.6f}")

# %% [markdown]
# **3.** All durations in one call. The maximum is flat, and longer winds require a little less: the
# vehicle drifts with them. A flight leaves the dead band when trim itself reaches the limit, and so
# does `tv.required_deflection`; `tv.boundary_limit` leaves it as the report does, when
# $B\alpha_w$ reaches the limit. Drift relieves trim, so the exit of a flight is later, nearer to
# the peak: in long winds the report's number lies far below what a flight requires.

# %%
drift = tv.Plant.from_vehicle(vehicle)
durations = np.arange(2.0, 121.0)
all_of_them = tv.TriangularWind(peak=peak, duration=durations)
needs = tv.required_deflection(drift, all_of_them, dead_band=1.0).limit
report = tv.boundary_limit(drift, all_of_them, dead_band=1.0).limit
for limits, exit_on in ((needs, "trim"), (report, "wind")):
    worst = int(np.argmax(limits))
    print(
        f"exit on {exit_on}: {durations[worst]:.0f} s, with {limits[worst]:.3f} of trim; "
        f"at 100 s {limits[durations == 100.0][0]:.3f}"
    )

# %%
answer = (
    f"{vehicle.name} falls over in 1/beta = {1 / beta:.2f} s and trims {np.degrees(peak):g} deg of "
    f"wind with {np.degrees(B * peak):.3f} deg; {np.degrees(found):.3f} deg survive a triangle of "
    f"{duration:g} s on a fixed path."
)
print(answer)
