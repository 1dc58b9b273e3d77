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
# # What does turbulence take of a nozzle?
#
# Turbulence is a random wind. It moves the nozzle all the time, and so sets much of its rate and
# travel. The loop is linear: no simulation is needed to say how much. This notebook goes the
# whole way for a launcher whose numbers are made up: spectrum, loop, a known wind on top, the
# whole flight, and flights in sampled turbulence as a check.

# %%
import matplotlib.pyplot as plt
import numpy as np

import tvclin as tv
from tvclin.plots import spectrum_chart

schedule = tv.load_schedule("made-up-launcher")
vehicle = schedule.at(55.0).rigid
height = float(np.interp(55.0, schedule.times, schedule.height))
print(f"at 55 s: {vehicle.velocity:.0f} m/s, {height / 1e3:.1f} km")

# %% [markdown]
# ## The wind
#
# MIL-F-8785C gives an intensity over altitude for a probability with which it is exceeded. Severe
# turbulence has a probability of one in 100,000. A launcher climbs along its path, so that the
# transverse component turns it. Its power falls with the square of frequency above $V/L$.

# %%
severe = tv.winds.Turbulence.mil_f_8785c("severe")
air = severe.at(height)
print(f"{air.intensity:.2f} m/s, scale length {air.length:.0f} m")
omega = np.geomspace(0.02, 30.0, 300)
figure, axes = plt.subplots(layout="constrained")
axes.loglog(omega, air.power_spectrum(omega, vehicle.velocity))
axes.axvline(vehicle.velocity / air.length, linestyle=":", color="black")
axes.annotate("$V/L$", (1.1 * vehicle.velocity / air.length, 0.1))
axes.set_xlabel("frequency [rad/s]")
axes.set_ylabel("power of the wind [m$^2$/s$^2$ per rad/s]")
_ = axes.set_title("Severe turbulence across the path, Dryden")

# %% [markdown]
# ## The loop
#
# Loop and wind are one linear system in white noise. Its covariance solves
#
# $$ A P + P A^T + N = 0, $$
#
# and each output $y = c\,x$ has the variance $c\,P\,c^T$. The deflection follows the wind up to the
# bandwidth of the loop, the deflection rate up to that of the actuator.

# %%
plant = tv.Plant.from_vehicle(vehicle, "drift-exact")
actuator = tv.Actuator(natural_frequency=25.0, damping=0.7)
autopilot = tv.design_gains(
    plant.coefficients, natural_frequency=1.5, damping=0.8, actuator=actuator
)
loop = tv.control.turbulence_covariance(autopilot, plant, air, float(vehicle.velocity))
loop

# %%
_ = spectrum_chart(loop, "Made-up launcher at 55 s in severe turbulence")

# %% [markdown]
# The nozzle's travel is the integral of the size of its rate: $\sqrt{2/\pi}$ standard deviations
# of the rate in each second. How often a limit is reached follows from Rice's formula.

# %%
print(f"travel {np.degrees(loop.travel_rate):.3f} deg in each second")
for limit in (0.5, 1.0, 1.5):
    rate = loop.crossing_rate(np.radians(limit))
    print(f"+-{limit:.1f} deg: met {rate:.2e} times a second")

# %% [markdown]
# ## A known wind on top
#
# About the response to a known wind the spread is the same. The largest of mean and three standard
# deviations is what a limit should cover; the rest is risk, and has a number.

# %%
wind = tv.TriangularWind(peak=np.radians(4.0), duration=7.5).shift(3.0)
duration = 20.0
motion = tv.control.turbulence_history(
    autopilot, plant, air, float(vehicle.velocity), duration, wind=wind, settled=True
)
largest, time = motion.largest(3.0)
print(f"wind + 3 sigma: {np.degrees(largest):.2f} deg at {time:.1f} s")
limit = np.radians(1.6)
print(
    f"a limit of 1.6 deg is not met in {100 * motion.probability_of_none(limit):.2f} % of flights"
)

# %% [markdown]
# Flights in sampled turbulence show the same. Each of the thin lines is the response to the wind
# and one sample.

# %%
times = np.arange(0.0, 60.0, 0.02)
samples = air.winds(times, float(vehicle.velocity), seed=1, runs=8)
figure, axes = plt.subplots(layout="constrained")
mean, spread = np.degrees(motion.mean()), np.degrees(motion.deviation())
axes.fill_between(motion.times, mean - 3 * spread, mean + 3 * spread, alpha=0.2)
axes.plot(motion.times, mean, linewidth=2.5)
shown = np.arange(0.0, duration, 0.05)
for run in range(8):
    gusty = tv.SampledWind(time=times - 40.0, angle=samples.angle[run])  # long before the wind
    response = autopilot.wind_response(plant, gusty + wind)
    row = response.labels.index("deflection")
    axes.plot(shown, np.degrees(response(shown)[row]), linewidth=0.6, color="black")
axes.set_xlabel("time [s]")
axes.set_ylabel("deflection [deg]")
_ = axes.set_title("Mean, three standard deviations, and eight flights")

# %% [markdown]
# ## The whole flight
#
# Along a flight speed, altitude, vehicle and gains change. The rigid vehicle is at rest when
# the flight begins, here at 40 s. The budget takes turbulence at its own quantile, as a random
# contribution, in addition to the wind.

# %%
design = tv.control.AutopilotDesign(natural_frequency=1.5, damping=0.8)
case = tv.studyfile.StudyPlan(
    vehicle=vehicle,
    wind=tv.ShapedWind("triangular", np.radians(4.0), 7.5),
    nozzle=tv.Nozzle(limit=np.radians(4.0), actuator=actuator),
    design=design,
)
flight = schedule.between(40.0, 105.0)
request = tv.requirement.SizingRequest(schedule=flight, start=45.0, stop=85.0)
random = request.turbulence(case, tv.case.TurbulenceRequest(severity="severe"))
random

# %%
total = request.total(case, request.sizing(case), random)
total

# %%
history = random.history
figure, (angle, rate) = plt.subplots(2, 1, sharex=True, layout="constrained")
angle.plot(history.times, np.degrees(history.deviation()))
angle.set_ylabel("deflection, rms [deg]")
rate.plot(history.times, np.degrees(history.deviation("deflection_rate")))
rate.set_ylabel("its rate, rms [deg/s]")
rate.set_xlabel("flight time [s]")
_ = angle.set_title("The nozzle in severe turbulence along the flight")

# %% [markdown]
# ## The travel
#
# What wears a bearing is the travel of the whole flight. It has an expected value, and from its
# variance a standard deviation over flights; both add to what the wind takes.

# %%
for largest_in_wind in random.winds:
    travel = largest_in_wind.travel
    print(
        f"{largest_in_wind.wind}: {np.degrees(travel.of_wind):.1f} deg without turbulence,"
        f" {np.degrees(travel.expected):.1f} +- {np.degrees(travel.deviation):.1f} deg with it"
    )

# %% [markdown]
# The data sheet of the nozzle counts it, for the law autopilot
# (`tvclin nozzle FLIGHT --over flight --law autopilot --set turbulence.severity severe`).

# %%
duty = tv.nozzle.flight_duty(
    case,
    request,
    "autopilot",
    turbulence=tv.case.TurbulenceRequest(severity="severe"),
)
duty.verdict

# %% [markdown]
# **Try:** moderate turbulence, or a loop of half the natural frequency: how much of the travel
# remains then?

# %%
answer = f"The data sheet in turbulence: {duty.verdict.words}."
print(answer)
