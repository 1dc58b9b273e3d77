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
# # How much deflection does this real wind require?
#
# The report's winds are triangles. A balloon measures something else: a wind over height, from all
# sides. This notebook takes such a file, flies through it, and sizes every time of the flight.
#
# A horizontal wind $V_w$ makes an angle of attack, eq (B1e):
#
# $$\sin\alpha_w = \frac{V_w}{V_R}\,\sin\gamma ,$$
#
# with the speed $V_R$ relative to the air and the flight path angle $\gamma$: the faster and the
# flatter the flight, the less.

# %%
import tempfile
from pathlib import Path

import numpy as np

import tvclin as tv
from tvclin.plots import sizing_chart

# %% [markdown]
# A small sounding, made up, with the jet stream at 11 km. Every column says its unit, and a
# direction is where the wind comes from. Put your own levels in, or the name of a file: tables,
# the lists of Wyoming, IGRA and RocketPy are read.

# %%
text = """height_m, speed_kt, direction_deg
0,     8, 110
1500, 17, 200
3000, 31, 250
5500, 52, 265
8000, 78, 268
9500, 101, 270
11000, 124, 272
12500, 106, 274
14500, 62, 270
17000, 27, 255
20000, 9, 120
25000, 12, 90
"""
file = Path(tempfile.mkdtemp()) / "sounding.csv"
file.write_text(text, encoding="utf-8")
profile = tv.read_sounding(file)
profile

# %% [markdown]
# The flight: configuration I along its nominal flight, launched to the east. It passes the levels
# one after another; at each the wind makes an angle of attack.

# %%
flight = tv.load_schedule("configuration-i")
azimuth = np.radians(90.0)
met = tv.fly_through(profile, flight, azimuth=azimuth)
for time in np.arange(45.0, 91.0, 10.0):
    height = np.interp(time, flight.time, flight.height)
    print(f"{time:.0f} s, {height / 1e3:4.1f} km: {np.degrees(met.wind(time)):5.2f} deg")

# %% [markdown]
# The equivalent triangle: the same peak and the same area. The report would have used this one.

# %%
peak_time = float(met.wind.time[np.argmax(np.abs(met.wind.angle))])
triangle = tv.winds.equivalent_triangle(met(flight.at(peak_time)))
lasts = float(triangle.end - triangle.onset)
print(f"{np.degrees(triangle.peak):.2f} deg for {lasts:.1f} s, from {triangle.onset:.1f} s on")

# %% [markdown]
# What each requires. The vehicle is frozen at one flight time after the other, in the whole wind as
# the flight encountered it; the triangle's peak is moved to each time.

# %%
times = np.unique([*np.arange(45.0, 91.0, 5.0), peak_time])
found = tv.size(flight, {"real wind": met}, times=times, dead_bands=1.0)
like = tv.size(flight, {"triangle": triangle}, times=times, dead_bands=1.0)
need, beside = (np.degrees(one.at_times("K = 1")) for one in (found, like))
print("frozen at   real wind   triangle")
for row in zip(times, need, beside, strict=True):
    print("{:6.1f} s  {:7.3f} deg  {:.3f} deg".format(*row))

# %%
_ = sizing_chart(found)

# %% [markdown]
# A vehicle that changes during the wind needs no flight time: there is one answer. With it comes
# the error of freezing the vehicle at the peak of the wind, at nominal dynamic pressure.

# %%
both = tv.size(flight, {"real wind": met}, times=peak_time, dead_bands=1.0, varying=True)
true = float(np.degrees(both.required["K = 1, varying"][0, 0]))
error = 100.0 * float(both.freezing_error["K = 1"][0, 0])
print(f"{true:.3f} deg along the flight; frozen at {peak_time:.1f} s {error:+.1f} %")

# %% [markdown]
# What the theory says of itself: where the wind is known, and where one pole is not sufficient.

# %%
for note in both.notes:
    print(note)

# %% [markdown]
# **Try:** a launch to the north, `azimuth = 0`, which leaves little of this wind in the pitch
# plane; or a gust on top, `gust=tv.OneMinusCosineGust(peak=np.radians(1), duration=2)` in
# `fly_through`, at each time of the frozen vehicle. In a shell:
# `tvclin ascent configuration-i --winds sounding.csv --azimuth-deg 90`.

# %%
triangular = float(beside[times == peak_time][0])
answer = (
    f"{true:.2f} deg with trim, flown through towards {np.degrees(azimuth):g} deg, and up to "
    f"{np.max(need):.2f} deg frozen at one time after the other; the equivalent triangle says "
    f"{triangular:.2f} deg, and freezing at the peak of the wind is {abs(error):.0f} percent off."
)
print(answer)
