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
# # Course, third hour: is the nozzle sufficient for the wind of this balloon?
#
# From a measured wind to a verdict over a whole flight. The sounding is made up, with a jet stream
# at 11 km; the flight is that of configuration I. Three exercises; their answers, at the end, are
# computed.

# %%
import tempfile
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

import tvclin as tv
from tvclin.plots import sizing_chart

# %%
levels = """height_m, speed_m_per_s, direction_deg
0,      4, 240
3000,  12, 255
6000,  24, 262
9000,  38, 268
11000, 46, 270
13000, 34, 272
17000, 12, 265
25000,  6, 90
"""
folder = Path(tempfile.mkdtemp())


def sounding(text):
    """Read levels as a file of them is read."""
    (folder / "balloon.csv").write_text(text, encoding="utf-8")
    return tv.read_sounding(folder / "balloon.csv")


profile, flight = sounding(levels), tv.load_schedule("configuration-i")
profile

# %% [markdown]
# The wind comes from 270 degrees and the vehicle flies to the east: a tail wind. What counts is
# its part across the path, against the speed relative to the air, eq (B1e):
#
# $$\sin\alpha_w = \frac{V_w}{V_R}\,\sin\gamma .$$

# %%
azimuth, time = np.radians(90.0), 60.0
met = tv.fly_through(profile, flight, azimuth=azimuth)
height, speed, path = (
    float(np.interp(time, flight.time, each))
    for each in (flight.height, flight.speed, flight.flight_path_angle)
)
wind_speed = np.interp(height, [9000.0, 11000.0], [38.0, 46.0])
print(f"{time:g} s: {height / 1e3:.2f} km, {speed:.0f} m/s, path {np.degrees(path):.1f} deg up")
print(f"{wind_speed:.1f} m/s there make {np.degrees(float(met.wind(time))):.3f} deg")

# %% [markdown]
# A vehicle that is frozen at one flight time after the other, in the whole wind as the flight
# encountered it, has as many answers as times. One whose parameters vary as it flies has one.

# %%
times, wanted = np.arange(44.0, 81.0, 4.0), "K = 1, varying"
found = tv.size(flight, {"balloon": met}, times=times, dead_bands=1.0, varying=True)
frozen, need = found.at_times("K = 1"), float(found.worst[wanted].deflection)
for row in zip(times, np.degrees(frozen), strict=True):
    print("frozen at {:g} s: {:.3f} deg".format(*row))
print(f"as it flies:    {np.degrees(need):.3f} deg")

# %%
_ = sizing_chart(found)

# %% [markdown]
# A nozzle has more to do than wind: an engine that stands askew, a centre of gravity off the
# axis. They are taken from its limit before the wind comes.

# %%
limit, askew = np.radians(0.55), np.radians(0.15)
total = tv.worst_total(found, wanted, thrust_offset=askew, limit=limit)
total

# %% [markdown]
# ## Exercises
#
# 1. Find the angle at 60 s by hand with (B1e), as it is used: $V_R$ is the speed in calm air. Then
#    draw the triangle of velocities. By how much are the angle and the moment, $V_R^2\alpha_w$,
#    another?
# 2. Into which azimuth would this wind require least in the pitch plane, and why is that no
#    advice?
# 3. By which factor may all winds of the balloon grow until the nozzle is just sufficient?
#
# **Try:** each before you read on. The third is a root of the whole chain.

# %% [markdown]
# ## Answers
#
# **1.** Relative to the air the velocity is that over ground less the wind. A tail wind takes from
# the speed: the angle is larger, and the moment smaller. A head wind does the opposite, so (B1e)
# is on the safe side here and not there; `tv.Study` counts that by the sign of the wind.

# %%
by_hand = np.arcsin(wind_speed * np.sin(path) / speed)
print(f"by hand {np.degrees(by_hand):.3f} deg, package {np.degrees(float(met.wind(time))):.3f} deg")
for name, along in {"tail": wind_speed, "head": -wind_speed}.items():
    relative = np.array([speed * np.cos(path) - along, speed * np.sin(path)])
    angle = abs(np.arctan2(relative[1], relative[0]) - path)
    moment = float(relative @ relative) * angle / (speed**2 * by_hand)
    print(f"{name} wind: angle {angle / by_hand - 1.0:+.1%}, moment {moment - 1.0:+.1%}")

# %% [markdown]
# **2.** To the north, across the wind: in pitch nearly nothing remains. But then all of it stands
# in yaw, where no inclined path makes the angle smaller, and one limit holds both planes. Frozen at
# 60 s:

# %%
for degrees in (0.0, 45.0, 90.0):
    needs = []
    for plane in ("pitch", "both"):
        through = tv.fly_through(profile, flight, azimuth=np.radians(degrees), plane=plane)
        sized = tv.size(flight, {"balloon": through}, times=time, dead_bands=1.0, plane=plane)
        needs.append(float(np.degrees(sized.worst["K = 1"].deflection)))
    print("azimuth {:2.0f} deg: pitch {:.3f} deg, both planes {:.3f} deg".format(degrees, *needs))

# %% [markdown]
# **3.** The sine of the angle is proportional to the wind, and for small angles the requirement to
# the angle; a root of the whole chain says it without "small", and with the dynamic pressure that
# the wind makes.

# %%
rows = [line.split(",") for line in levels.splitlines()[1:]]


def spare(factor):
    """What the limit leaves of a balloon with winds so many times as strong, in rad."""
    text = "\n".join(f"{h}, {factor * float(v)}, {d}" for h, v, d in rows)
    through = tv.fly_through(
        sounding(f"{levels.splitlines()[0]}\n{text}\n"), flight, azimuth=azimuth
    )
    sized = tv.size(flight, {"balloon": through}, times=time, dead_bands=1.0, varying=True)
    return limit - askew - float(sized.worst[wanted].deflection)


factor = brentq(spare, 0.5, 2.0, xtol=1e-6)
plain = (limit - askew) / need
print(f"by the root {factor:.3f}, in proportion {plain:.3f}")

# %%
verdict = "SUFFICIENT" if total.sufficient else "NOT SUFFICIENT"
answer = (
    f"The balloon asks for {np.degrees(need):.2f} deg with trim; with "
    f"{np.degrees(askew):g} deg of misalignment {np.degrees(limit):g} deg are {verdict}, and the "
    f"wind may be {factor:.2f} times as strong."
)
print(answer)
