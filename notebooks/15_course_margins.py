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
# # Course, second hour: what do margins promise, and what remains with a limit?
#
# From gains by hand to margins, and from margins to a flight with a limited nozzle. The
# vehicle is the report's configuration I, on a fixed path, so that every number can be checked
# with a pencil. Three exercises; their answers, at the end, are computed.

# %%
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import tvclin as tv
from tvclin.plots import nyquist_chart

# %%
vehicle = tv.load_vehicle("configuration-i")
plant = tv.Plant.from_vehicle(vehicle, model="fixed-path")
c = plant.coefficients

# %% [markdown]
# Attitude and rate are fed back, $\delta = a_0\theta + a_1\dot\theta$. The closed loop is
#
# $$s^2 + \mu_\delta a_1 s + (\mu_\delta a_0 - \mu_\alpha) = s^2 + 2\zeta\omega s + \omega^2 ,$$
#
# so two wishes, $\omega$ and $\zeta$, are two gains.

# %%
omega, zeta = 1.2, 0.7
a0 = (omega**2 + c.mu_alpha) / c.mu_delta
a1 = 2.0 * zeta * omega / c.mu_delta
rule = tv.design_gains(plant, natural_frequency=omega, damping=zeta)
print(f"by hand a0 = {a0:.4f}, a1 = {a1:.4f} s")
print(f"package a0 = {rule.attitude_gain:.4f}, a1 = {rule.rate_gain:.4f} s")

# %% [markdown]
# With a delay the loop is $L(s) = \mu_\delta (a_0 + a_1 s)\,e^{-sT}/(s^2 - \mu_\alpha)$, and has
# margins on two sides. At rest $|L(0)| = a_0/B$ must stay above one, or air is the stronger: the
# aero margin. At high frequency the delay eats the phase: the gain must not rise too far.

# %%
delay = 0.1
autopilot = tv.Autopilot(attitude_gain=a0, rate_gain=a1, delay=delay)
margins = autopilot.margins(plant)
by_hand = 20.0 * np.log10(a0 / c.B)
print(f"aero margin by hand {by_hand:.3f} dB, package {margins.aero_margin_dB:.3f} dB")
margins

# %%
_ = nyquist_chart(autopilot, plant)

# %% [markdown]
# Margins are of small motions. A nozzle has a limit, and in a wind it reaches it. Then a larger
# gain turns it no further, and the vehicle flies on with less gain than it has: it is the aero
# margin that a limit reduces. Flights say how much remains.

# %% tags=["within 2e-3"]
wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
trim = abs(c.B * wind.peak)
law = tv.SaturatedLaw(tv.Autopilot(attitude_gain=a0, rate_gain=a1))
least = tv.closed_loop_boundary(plant, law, wind, delay=delay)
bound = abs(float(tv.boundary_limit(plant, wind, dead_band=1.0).deflection))
minimum = float(tv.optimum_deflection(plant, wind).peak)
print(f"full trim                   {np.degrees(trim):.3f} deg")
print(f"trim while there is some    {np.degrees(bound):.3f} deg")
print(f"this autopilot needs        {abs(np.degrees(least.deflection)):.3f} deg")
print(f"the least of all            {np.degrees(minimum):.3f} deg")

# %%
stops = np.linspace(1.02, 1.6, 6) * abs(float(least.deflection))
falls = []
for stop in stops:
    flown = tv.flights.flown_margins(plant, law, wind, limit=stop, delay=delay)
    falls.append(flown.gain_fall.dB)
figure, axes = plt.subplots(layout="constrained")
axes.plot(np.degrees(stops), falls, "o-", label="flown in the wind")
axes.axhline(margins.aero_margin_dB, linestyle="--", color="C1", label="linear")
axes.set(xlabel="stop of the nozzle [deg]", ylabel="the gain may fall by [dB]")
_ = axes.legend()

# %% [markdown]
# ## Exercises
#
# 1. Which delay makes this loop unstable? Find crossover and phase by hand, then with the package.
# 2. A criterion wants 6 dB of aero margin, and the damping shall stay. Which attitude gain and
#    which frequency are the least?
# 3. Somebody doubles both gains to bring the vehicle back faster. Does it then require less
#    deflection?
#
# **Try:** each before you read on; the first needs one root of one equation.

# %% [markdown]
# ## Answers
#
# **1.** $|L(j\omega)| = 1$ is $\mu_\delta^2(a_0^2 + a_1^2\omega^2) = (\omega^2 + \mu_\alpha)^2$.
# There the lead of the rate gain, $\arctan(a_1\omega/a_0)$, is what a delay $\omega T$ may eat.

# %%
crossover = brentq(
    lambda w: c.mu_delta * np.hypot(a0, a1 * w) - (w**2 + c.mu_alpha), 0.5 * omega, 50.0 * omega
)
longest = np.arctan(a1 * crossover / a0) / crossover
both = [tv.Autopilot(attitude_gain=a0, rate_gain=a1, delay=f * longest) for f in (0.999, 1.001)]
print(f"by hand {longest:.4f} s, package {margins.delay_margin + delay:.4f} s")
print("a thousandth less and more:", [one.margins(plant).status for one in both])

# %% [markdown]
# **2.** $a_0/B = 10^{6/20}$, so $\omega^2 = \mu_\delta a_0 - \mu_\alpha = \mu_\alpha(10^{0.3} -
# 1)$: nearly $\beta$ itself. A loop slower than the vehicle falls cannot have 6 dB.

# %%
slowest = np.sqrt(c.mu_alpha * (10.0 ** (6.0 / 20.0) - 1.0))
slow = tv.design_gains(plant, natural_frequency=slowest, damping=zeta)
print(f"a0 = {slow.attitude_gain:.4f} at {slowest:.3f} rad/s, where beta is {c.beta:.3f} 1/s")
print(f"aero margin {slow.margins(plant).aero_margin_dB:.3f} dB")

# %% [markdown]
# **3.** Less: an attitude that is held more stiffly turns the nozzle sooner, as trim would. It is
# paid for with the other margin, as the delay leaves less and less room above.

# %% tags=["within 2e-3"]
needs = []
for times in (1.0, 2.0, 4.0):
    gains = {"attitude_gain": times * a0, "rate_gain": times * a1}
    one = tv.closed_loop_boundary(plant, tv.SaturatedLaw(tv.Autopilot(**gains)), wind, delay=delay)
    room = tv.Autopilot(**gains, delay=delay).margins(plant).gain_increase_dB
    needs.append(abs(float(np.degrees(one.deflection))))
    print(f"{times:g} times: {needs[-1]:.3f} deg, and the gain may rise by {room:.1f} dB")

# %% tags=["within 1e-2"]
answer = (
    f"{margins.aero_margin_dB:.1f} dB of linear aero margin become {falls[2]:.1f} dB in a "
    f"wind of {np.degrees(wind.peak):g} deg with a stop of {np.degrees(stops[2]):.2f} deg, "
    f"and nothing below {needs[0]:.2f} deg."
)
print(answer)
