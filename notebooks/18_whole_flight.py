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
# # Is my autopilot sufficient for the whole flight?
#
# From a trajectory file to a scheduled autopilot: the sweep of its margins, a notch that follows a
# bending mode, and a flight through a jet stream. The launcher and all its numbers are made up; put
# your own files in their place.

# %%
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

import tvclin as tv
from tvclin.base.lines import text
from tvclin.plots import deflection_use_chart, flight_along_chart, sweep_chart
from tvclin.studyfile import load_sizing
from tvclin.studyfile.flight_loop import FlightLoop
from tvclin.vehicle import Filter

folder = Path(tempfile.mkdtemp())


def show(table):
    """Print a table."""
    rows = [table.head, *([text(cell) for cell in row] for row in table.rows)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = (cell.rjust(width) for cell, width in zip(row, widths, strict=True))
        print("  ".join(cells).rstrip())


# %% [markdown]
# ## The files
#
# The trajectory is a table with a line for each time; a number that does not change stands in the
# first line only. It names the table of its bending modes, which has a line for each mode at each
# time. Rows belong together by the name of the mode.

# %%
(folder / "flight.csv").write_text(
    """\
time_s,weight_N,moment_of_inertia_kg_m2,normal_force_slope_N_per_rad,thrust_N,aerodynamic_arm_m,\
control_arm_m,axial_force_N,velocity_m_per_s,attitude_deg,altitude_m,structure
30,1.90e6,2.80e7,3.8e5,2.5e6,11.0,23.6,8.1e4,240,80,2700,modes.csv
50,1.70e6,2.45e7,6.2e5,,10.2,,,400,66,7500,
70,1.50e6,2.10e7,5.4e5,,9.5,,,560,52,14700,
90,1.30e6,1.75e7,2.6e5,,8.8,,,720,39,24300,
110,1.10e6,1.40e7,0.9e5,,8.0,,,880,25,36300,
""",
    encoding="utf-8",
)
(folder / "modes.csv").write_text(
    """\
time_s,name,frequency_Hz,damping,modal_mass_kg,gimbal_displacement,gimbal_slope_per_m,\
attitude_slope_per_m,rate_slope_per_m
30,first,2.4,0.005,5.1e4,1,-0.07,-0.013,-0.012
70,first,3.0,0.005,4.6e4,1,-0.07,-0.014,-0.013
110,first,4.0,0.005,4.0e4,1,-0.07,-0.016,-0.014
30,second,6.5,0.005,2.6e4,1,-0.09,-0.009,-0.008
70,second,7.2,0.005,2.4e4,1,-0.09,-0.009,-0.008
110,second,8.0,0.005,2.1e4,1,-0.09,-0.009,-0.008
""",
    encoding="utf-8",
)
flight = tv.load_schedule(folder / "flight.csv")
print(f"{flight.span[0]:g} to {flight.span[1]:g} s, modes: {', '.join(flight.structure.modes)}")

# %% [markdown]
# ## Gains over the Mach number
#
# A rule gives gains for the rigid vehicle at each time; between them lie straight lines. Gains may
# be scheduled on a variable with one value for each time: the dynamic pressure of this flight rises
# and falls, and has one value for two times with different gains.

# %%
times = np.arange(30.0, 111.0, 5.0)
plants = flight.plants(times, "drift-exact", "pitch")
rule = {"natural_frequency": 1.0, "damping": 0.7, "actuator": tv.Actuator(), "delay": 0.01}
by_rule = tv.design_gains(plants.coefficients, **rule)
show(tv.control.equal_values(flight, "dynamic_pressure", times, by_rule).table())
mach = tv.ascent.flight_variable(flight, "mach", times)
schedule = tv.control.GainSchedule.design(
    mach, plants.coefficients, tv.design_gains, "mach", **rule
)
sampled = replace(schedule.autopilot, sample_rate=50.0, filters=(Filter.low_pass(45.0, 0.7),))
schedule = replace(schedule, autopilot=sampled)

# %% [markdown]
# ## The sweep, and a notch that follows its mode
#
# The margins at each time, as if the vehicle were frozen there, with the frequency of one mode at a
# time 10 percent off too. A notch at the frequency $\omega(t)$ of its mode is
#
# $$ N(s, t) = \frac{s^2 + 2\zeta_z\,\omega(t)\,s + \omega(t)^2}
# {s^2 + 2\zeta_p\,\omega(t)\,s + \omega(t)^2}. $$
#
# First without a notch, then with one at the frequency that the first mode
# has at 70 s, then with one that follows it.

# %%
notch = {"zero_damping": 0.1, "pole_damping": 0.6}
frequency = flight.at(70.0).structure.bending[0].frequency
fixed = replace(sampled, filters=(*sampled.filters, Filter.notch(frequency, **notch)))
follows = tv.control.ModeNotch(mode="first", **notch)
autopilots = {
    "no notch": schedule,
    "notch at 70 s": replace(schedule, autopilot=fixed),
    "notch that follows": replace(schedule, notches=(follows,)),
}
sweeps = {name: tv.control.sweep(flight, one, times) for name, one in autopilots.items()}
for name, swept in sweeps.items():
    print(f"{name}: {swept.verdict}")

# %%
followed = sweeps["notch that follows"]
show(followed.time_table(9))
chart = sweep_chart(followed, "made-up launcher")

# %% [markdown]
# Good margins at every time do not prove the flight, for the vehicle changes during its motion.
#
# ## Through a jet stream
#
# The wind over height, as a balloon measures it, becomes wind angles along the flight. The linear
# loop flies from start to end, with samples, delay, filters, bending, and the nozzle's limits, at
# the dynamic pressure that it encounters.

# %%
jet = tv.WindProfile(
    height=[0, 5e3, 9e3, 11e3, 13e3, 17e3, 40e3], east=[0, 12, 35, 60, 40, 12, 0], north=[0] * 7
)
wind = tv.fly_through(jet, flight, azimuth=np.radians(90.0))
limits = {"deflection_limit": np.radians(2.0), "rate_limit": np.radians(10.0)}
flown = tv.flights.fly_along(flight, autopilots["notch that follows"], wind, **limits)
print(f"{flown.status}: {flown.reason}")
show(flown.table())
chart = flight_along_chart(flown, np.radians(2.0), "made-up launcher, jet stream")

# %% [markdown]
# ## Required, used, remaining
#
# What the wind requires of any control with a dead band of K = 1, what this autopilot uses, and
# what remains of the limit.

# %%
sizing = tv.size(flight, wind, times=times[1:-1:2])
labels = ["K = 1", "minimum"]
use = tv.requirement.deflection_use(sizing, flown, np.radians(2.0), labels=labels)
show(use.table())
chart = deflection_use_chart(use, "made-up launcher, jet stream")

# %% [markdown]
# ## The same by commands
#
# A study of the flight holds all of it: a table of gains, a notch that follows its mode, limits.

# %%
a0, a1 = schedule.autopilot.attitude_gain, schedule.autopilot.rate_gain
gains = [f"{m:.6g},{x:.6g},{y:.6g}" for m, x, y in zip(mach, a0, a1, strict=True)]
(folder / "gains.csv").write_text("\n".join(["mach,attitude_gain,rate_gain_s", *gains]))
written = (folder / "study.toml").write_text(
    """\
[study]
vehicle = "flight.csv"

[nozzle]
limit_deg = 2.0
rate_limit_deg_per_s = 10.0

[autopilot]
schedule = "gains.csv"
delay_ms = 10
sample_rate_Hz = 50

[[autopilot.filter]]
kind = "low-pass"
frequency_rad_per_s = 45.0
damping = 0.7

[[autopilot.filter]]
kind = "notch"
mode = "first"
zero_damping = 0.1
pole_damping = 0.6
""",
    encoding="utf-8",
)

# %% [markdown]
# ```
# tvclin margins study.toml --plot sweep.png
# tvclin fly study.toml --winds jet.csv --azimuth-deg 90 --plot flight.png
# tvclin ascent study.toml --winds jet.csv --azimuth-deg 90 --plot deflection.png
# ```
#
# The first of them, here from Python.
#
# **Try:** a notch of half that width (`pole_damping` 0.3), or one at each mode: what becomes of the
# detuned margins?

# %%
study = FlightLoop.of(load_sizing(folder / "study.toml")).sweep()
used = np.degrees(abs(flown.largest("deflection").value))
answer = f"{study.verdict}; {flown.status} in the jet stream with {used:.2f} of 2 deg."
print(answer)
