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
# # Does it matter where the wind blows from?
#
# A limit is counted in the pitch plane, and the nozzle turns in two. How much too small is it,
# and what does the shape of the limit change? The wind over height is made up; put your own
# sounding in its place (`tv.read_sounding`).

# %%
import numpy as np

import tvclin as tv
from tvclin.plots import plane_chart, sizing_chart

# %%
booster = tv.load_vehicle("configuration-i")
flight = tv.load_schedule("configuration-i")
height = np.linspace(0.0, 25e3, 51)
jet = 50.0 * np.exp(-(((height - 12e3) / 4e3) ** 2))
towards = np.radians(90) + (height - 12e3) / 10e3
sounding = tv.WindProfile(height=height, east=jet * np.sin(towards), north=jet * np.cos(towards))

# %% [markdown]
# A jet towards the east at 12 km, which turns by a radian in 10 km. A flight to the east has it in
# the back, one to the north from the left. In the pitch plane a horizontal wind counts with the
# sine of the path angle, in yaw in full, (B1e):

# %%
needs, misses = {}, {}
for azimuth in (0, 30, 60, 90):
    met = tv.fly_through(sounding, flight, azimuth=np.radians(azimuth), plane="both")
    found = tv.size(flight, met, times=[66.0], dead_bands=1.0, plane="both")
    pitch = found.separate["pitch"].required["K = 1"][0, 0]
    needs[azimuth] = np.degrees(found.required["K = 1"][0, 0])
    misses[azimuth] = found.pitch_omitted_fraction["K = 1"][0, 0]
    print(
        f"towards {azimuth:2d} deg: both {needs[azimuth]:.3f}, pitch alone {np.degrees(pitch):.3f}"
        f" deg, {misses[azimuth]:.0%} too little"
    )

# %% [markdown]
# Trim of this wind is a vector that turns. It is followed up to the limit; from there on the
# discounted mean of the future trim is held,
#
# $$g_S\big(w(a)\big) = K\,g_S\big(W(a)\big), \qquad W(t) = p\int_t^\infty e^{-p(r-t)}\,w(r)\,dr .$$

# %%
plant = tv.Plant.from_vehicle(booster)
_ = plane_chart(plant, sounding.to_winds(flight, azimuth=np.radians(30)), "round")

# %% [markdown]
# Two actuators at right angles have a square limit. Its orientation matters:

# %%
met = tv.fly_through(sounding, flight, azimuth=np.radians(30), plane="both")
stops = {}
for stop in ("round", "round-each-plane", "square", "square-45"):
    found = tv.size(flight, met, times=[66.0], dead_bands=1.0, plane="both", limit_shape=stop)
    stops[stop] = np.degrees(found.required["K = 1"][0, 0])
    print(f"{stop:16s} {stops[stop]:.3f} deg")

# %%
whole = tv.size(flight, met, times=[50.0, 66.0, 80.0], dead_bands=1.0, plane="both")
_ = sizing_chart(whole, limit=np.radians(1.0))

# %% [markdown]
# And flown? A pulse that turns by a right angle, with a law that does not know the wind to come:

# %%
gust = tv.TriangularWind(peak=np.radians(5.0), duration=7.5)
wind = tv.winds.PlaneWind.veering(gust, angle=0.3, rate=np.radians(90) / 7.5)
limit = tv.plane_limit(plant, wind)
law = tv.TrimLaw(plant)
for part in (0.95, 1.05):
    flown = tv.flights.fly_planes(
        plant, law, wind, deflection_limit=part * limit.deflection, sample_rate=50.0
    )
    print(f"{part:.2f} of the boundary: {flown.status}")

# %% [markdown]
# **Try:** other azimuths, `dead_bands=(1.0, 0.5)`, a wind that turns by 180 degrees (trim then
# requires more than the boundary), `saturate="each plane"`. In a shell: `tvclin ascent
# configuration-i --set nozzle.limit_shape square --winds FILE --azimuth-deg 30`.

# %%
worst = max(misses, key=misses.get)
answer = (
    f"Yes: at 66 s the pitch plane alone asks for {misses[worst]:.0%} too little towards"
    f" {worst} deg, and for {misses[90]:.0%} along the jet. Both planes need {needs[30]:.3f} deg"
    f" towards 30 deg with a round stop, {stops['square']:.3f} with a square one, and"
    f" {stops['round-each-plane']:.3f} if each plane is limited by itself within the round one."
)
print(answer)
