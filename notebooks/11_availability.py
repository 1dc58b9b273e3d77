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
# # Can we launch in February?
#
# A nozzle that is sufficient for the design's wind is not so for every day's. An archive of
# balloons says on how many days it is. This notebook reads one, flies through each sounding, and
# counts:
#
# $$P(\delta_{max}) = \frac{\#\{i : \delta_i \le \delta_{max}\}}{n},$$
#
# $\delta_i$ being what the day of sounding $i$ requires, and $n$ the soundings of which it is
# known.

# %%
import tempfile
from pathlib import Path

import numpy as np

import tvclin as tv
from tvclin.plots import availability_chart

# %% [markdown]
# The archive is made up: eight Februaries and Marches of two balloons a day, in the columns of a
# station file of NOAA's archive IGRA. The jet stream wanders in strength and direction, one day is
# like the next, and some balloons burst early. Put the name of a real file in its place.

# %%
rng = np.random.default_rng(8)
heights = np.arange(0, 31_001, 500)
shape = np.exp(-(((heights - 11_500) / 4_500) ** 2))
lines, strength, come = [], 42.0, 265.0
for year in range(2016, 2024):
    for half_day in range(2 * 59):
        strength += 0.2 * (42.0 - strength) + rng.normal(0.0, 7.0)
        come += 0.2 * (265.0 - come) + rng.normal(0.0, 8.0)
        day = np.datetime64(f"{year}-02-01T00") + np.timedelta64(12 * half_day, "h")
        top = heights.size if rng.random() > 0.04 else int(rng.integers(8, 30))
        date = str(day)[:13].replace("-", " ").replace("T", " ")
        lines.append(f"#ZZM00088801 {date} 9999 {top:4d} made-up  made-up   285000  -806000")
        speeds = np.abs(strength * shape + 5.0 + np.cumsum(rng.normal(0.0, 0.7, heights.size)))
        for height, speed in zip(heights[:top], speeds[:top], strict=True):
            lines.append(
                f"30 -9999  -9999 {height:5d} -9999 -9999 -9999 {round(come):5d} "
                f"{round(10 * speed):5d} "
            )
file = Path(tempfile.mkdtemp()) / "ZZM00088801-data.txt"
file.write_text("\n".join(lines) + "\n", encoding="utf-8")
soundings = tv.read_soundings(file)
soundings

# %% [markdown]
# The flight: configuration I along its nominal flight, launched to the east. Each sounding is flown
# through with parameters that vary; pitch and yaw are combined as for a round limit.

# %%
flight = tv.load_schedule("configuration-i")
limit, azimuth = np.radians(0.45), np.radians(90.0)
found = tv.availability(flight, soundings, limit=limit, azimuth=azimuth, utc_offset=-5.0)
for month, part in found.by_month().items():
    print(month, part)

# %% [markdown]
# What a balloon did not see is unknown, not calm. It is judged only where the limit is sufficient,
# or is not, in any wind there.

# %%
unknown = [f"{time}: {why}" for time, why in zip(soundings.times, found.why, strict=True) if why]
print(f"{len(unknown)} are unknown, the first at {unknown[0]}")

# %% [markdown]
# Which limit would be sufficient for more days? The curve, and what stands on a placard.

# %%
february = tv.availability(
    flight, soundings.with_utc_offset(-5.0).select(month=2), limit=limit, azimuth=azimuth
)
for part, need in zip((0.5, 0.8, 0.9, 0.95), february.placard([0.5, 0.8, 0.9, 0.95]), strict=True):
    print(f"{100 * part:.0f} % of the balloons need {np.degrees(need):.3f} deg or less")

# %%
_ = availability_chart(february)

# %% [markdown]
# The balloon flies some hours before the vehicle. The archive's own pairs say by how much a
# requirement grows in twelve hours; three and a half hours are less. And today?

# %%
later = tv.availability(
    flight,
    soundings.with_utc_offset(-5.0).select(month=2),
    limit=limit,
    azimuth=azimuth,
    persistence=tv.ensembles.PairGrowth(hours=3.5),
)
print(*later.notes, sep="\n")
print(later.fraction())
today = later.today(soundings[3])
print(f"today: {np.degrees(today.upper):.3f} deg of {np.degrees(today.limit):.3f}, go: {today.go}")

# %% [markdown]
# **Try:** other azimuths, several at once (`azimuth=np.radians([60, 90, 110])`); a square limit,
# `limit_shape="square"`; a gust, `gust=tv.OneMinusCosineGust(peak=np.radians(0.5), duration=2)`. In
# a shell: `tvclin availability configuration-i STATION.zip --azimuth-deg 90 --limit-deg 0.45`.

# %%
part, less = february.fraction(), later.fraction()
answer = (
    f"On {100 * part.fraction:.0f} percent of February's days, and between "
    f"{100 * part.lower:.0f} and {100 * part.upper:.0f} percent as far as eight years can say; "
    f"{part.unknown} of {part.judged + part.unknown} balloons do not tell. With 3.5 hours from the "
    f"balloon to the launch it is {100 * less.fraction:.0f} percent."
)
print(answer)
