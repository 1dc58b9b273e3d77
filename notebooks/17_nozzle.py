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
# # What must this nozzle be able to do?
#
# Who builds the nozzle of a launcher wants a data sheet: how far, how fast, how often, with
# what torque. This notebook goes there from a wind, for a launcher that is made up, as is its
# nozzle: angle and rate that the wind requires, a law that flies with them, and the data sheet of
# the whole flight.

# %%
from dataclasses import replace

import numpy as np

import tvclin as tv
from tvclin.plots import rate_chart

# %% [markdown]
# ## One wind: angle over rate
#
# A nozzle that turns at most at a rate $r$ needs more angle than one without a limit. With the
# unstable pole $p$ and the least angle $d_0$ a ramp and a hold are the best it can do,
#
# $$ d = -\frac{r}{p}\,\ln\Big(1 - \frac{p\,d_0}{r}\Big), $$
#
# and at $r = p\,d_0$ no angle is sufficient.

# %%
vehicle = tv.load_vehicle("made-up-launcher").rigid
plant = tv.Plant.from_vehicle(vehicle)
wind = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
limit, rate = np.radians(1.5), np.radians(5.0)
trade_off = tv.boundary.rate_trade_off(plant, wind, limit=limit, rate_limit=rate)
trade_off

# %%
_ = rate_chart(trade_off, "Made-up launcher, a triangle of 5 deg and 7.5 s")

# %% [markdown]
# The nozzle's point lies far to the right: wind alone takes little rate. Gains, noise, and steps
# of the command take more.
#
# ## One flight: what the motion takes
#
# The law flies through an actuator; rate and acceleration are those of its equation. With what
# turns and what resists there are torque and power as well.

# %%
hinge = tv.case.NozzleData(
    engine=tv.vehicle.Engine(mass=250.0, arm=0.5, moment_of_inertia=30.0),
    stiffness=2e4,
    damping=500.0,
    friction=100.0,
    offset=0.002,
)
nozzle = tv.Nozzle(
    limit=limit,
    rate_limit=rate,
    acceleration_limit=np.radians(500.0),
    travel_limit=np.radians(60.0),
    torque_limit=3e3,
    power_limit=200.0,
    data=hinge,
)
times = np.linspace(0.0, 20.0, 8001)
law = tv.TrimLaw(tv.Plant(plant.coefficients, "fixed-path"))
flown = tv.fly(
    plant,
    law,
    wind,
    times,
    deflection_limit=limit,
    rate_limit=rate,
    actuator=nozzle.actuator,
    sample_rate=100.0,
).outputs
moves = {name: flown[name] for name in ("angle_of_attack", "attitude")}
tv.nozzle.nozzle_duty(
    times, flown["deflection"], limit=limit, nozzle=hinge, vehicle=vehicle, **moves
)

# %% [markdown]
# ## The whole flight
#
# At each flight time the same wind, from ahead and from behind, and a gust on top.

# %%
gust = tv.OneMinusCosineGust(peak=np.radians(1.0), duration=2.0)
case = tv.Case(
    vehicle=vehicle,
    wind=tv.ShapedWind("triangular", np.radians(5.0), 7.5, gust=gust),
    nozzle=nozzle,
)
flight = tv.requirement.SizingRequest(
    schedule=tv.load_schedule("made-up-launcher"), start=40.0, stop=90.0, every=10.0
)
card = tv.nozzle.flight_duty(case, flight)
card

# %% [markdown]
# ## Noise is the duty
#
# A gyro with a noise of 0.05 deg/s a sample keeps the nozzle moving through the whole flight.
# It takes far more travel than the wind does.

# %%
loud = tv.nozzle.flight_duty(case, replace(flight, rate_noise=np.radians(0.05)))
for name, one in (("quiet", card), ("with noise", loud)):
    duty = max(one.duties, key=lambda each: each.travel)
    print(f"{name}: travel {np.degrees(duty.travel):.1f} deg, energy {duty.energy:.1f} J")

# %% [markdown]
# ## The data sheet
#
# Required, available and remaining: the line of which the largest part is required comes first.

# %%
loud.verdict

# %% [markdown]
# **Try:** a gyro with a tenth of this noise, or a nozzle twice as stiff: which line of the data
# sheet heads it then?

# %%
answer = f"The data sheet: {loud.verdict.words}."
print(answer)
