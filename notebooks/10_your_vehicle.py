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
# # What does my own vehicle require?
#
# A vehicle is a small file, in which every key carries its unit. This notebook writes one, reads
# it, says what it requires, and what happens when a number is wrong. Put your own numbers in.
#
# The theory makes two numbers of them, how fast the vehicle falls over and how much deflection
# holds one radian of wind:
#
# $$\beta = \sqrt{\frac{N l_a}{I}}, \qquad B = \frac{N l_a}{T l_c}, \qquad
# N = \bar q\,S\,C_{N\alpha} .$$

# %%
import tempfile
from pathlib import Path

import numpy as np

import tvclin as tv
from tvclin.plots import study_chart

# %%
text = """
[vehicle]
name = "My booster"
weight_kN = 6000.0
moment_of_inertia_kg_m2 = 6.0e7
thrust_kN = 8500.0
control_arm_m = 14.0
aerodynamic_arm_m = 6.5
velocity_m_per_s = 470.0
attitude_deg = 52.0
dynamic_pressure_kPa = 33.0
reference_area_m2 = 11.0
normal_force_coefficient_slope_per_rad = 4.5
axial_force_coefficient = 0.5
"""
file = Path(tempfile.mkdtemp()) / "my.toml"
file.write_text(text, encoding="utf-8")
vehicle = tv.load_vehicle(file)
vehicle

# %% [markdown]
# The whole answer in one value: boundaries without and with drift, the minimum, what a law
# without a forecast requires, and whether the part of the nozzle's limit that remains for the wind
# is sufficient. The wind is a tail wind that comes and goes within a few seconds; its angle follows
# from its speed and the flight path.

# %%
speed, duration, limit = 30.0, 6.0, np.radians(0.2)
angle = tv.angle_from_speed(speed, vehicle.velocity, vehicle.attitude)
print(f"{np.degrees(float(angle)):.2f} deg")

# %%
study = tv.Study.from_vehicle(vehicle, duration=duration, peak=float(angle), limit=limit)
study

# %%
for note in study.notes:
    print(note)
for sign, need in study.encountered.items():
    print(f"{sign} wind: {np.degrees(need):.3f} deg, with the dynamic pressure met in it")

# %%
print("dead band  ", study.dead_bands)
for model, boundary in study.boundaries.items():
    print(f"{model:11s}", np.degrees(np.abs(boundary.deflection)).round(3), "deg")

# %% [markdown]
# The same over the duration of the wind. Where the limit lies above the curve of a dead band, it is
# sufficient for that control.

# %%
_ = study_chart(study)

# %%
peak = np.degrees(study.survivable_peak)
print(f"{np.degrees(limit):g} deg survive a wind of up to {peak:.1f} deg of this duration")

# %% [markdown]
# A mistake is named in one sentence, with its correction.

# %%
file.write_text(text.replace("control_arm_m", "control_arn_m"), encoding="utf-8")
try:
    tv.load_vehicle(file)
except tv.InputError as error:
    print(str(error).replace(f"{file.parent}", "..."))

# %% [markdown]
# **Try:** the same on the command line: `tvclin init my.toml`, then `tvclin study my.toml`. And
# many vehicles at once: every number of a `Vehicle` may be an array.

# %%
B = abs(float(study.coefficients.B * study.wind.peak))
with_drift = study.boundaries[study.model]
full = float(np.abs(with_drift.deflection)[study.dead_bands == 1.0][0])
worst = np.degrees(study.required_deflection)
verdict = "SUFFICIENT" if study.sufficient else "NOT SUFFICIENT"
answer = (
    f"{vehicle.name} needs {np.degrees(full):.2f} deg with trim in {speed:g} m/s of wind within "
    f"{duration:g} s ({full / B:.2f} of full trim), and {worst:.2f} deg where it is a head "
    f"wind, so {np.degrees(limit):g} deg are {verdict}."
)
print(answer)
