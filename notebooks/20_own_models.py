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
# # Is the filter sufficient, with a plant and a controller from MATLAB?
#
# A finite-element tool gives a plant as matrices, the flight computer its law as difference
# equations, both as files. This notebook reads them, judges the loop by band, trades four filters
# against a mode that is off by up to ten percent, goes to the corners of what is uncertain, and
# flies the loop through a gust. All numbers are made up.

# %%
import pathlib
import tempfile

import control
import matplotlib.pyplot as plt
import numpy as np

import tvclin as tv
from tvclin.control import SystemAutopilot, SystemLaw
from tvclin.linear import SystemPlant, read_system, write_system
from tvclin.plots import nichols_chart

# %% [markdown]
# ## The files
#
# The next cell stands for the tools that make them. In your work it is `save -v7` of MATLAB or
# Octave, with `A`, `B`, `C`, `D`, `Ts` and cells of names. The attitude
# falls over with 0.5 1/s, the flight path moves slowly, and a bending mode at 14 rad/s is seen by
# the inertial unit.


# %%
def launcher(bending=1.0, aerodynamics=1.0, thrust=1.0):
    """Return the matrices, with factors on a frequency and on two coefficients."""
    A, B = np.zeros((5, 5)), np.zeros((5, 2))
    A[0, 1] = A[3, 4] = 1.0
    A[1, [0, 2]] = 0.26 * aerodynamics, -0.26 * aerodynamics
    A[2, [0, 2]] = 0.028, -0.021
    A[4, 3:] = -((14.0 * bending) ** 2), -2 * 0.005 * 14.0 * bending
    B[1] = -2.4 * thrust, -0.26 * aerodynamics
    B[2], B[4, 0] = (0.021, -0.012), 11.0
    C, D = np.zeros((4, 5)), np.zeros((4, 2))
    C[0, [0, 3]] = C[1, [1, 4]] = 1.0, 0.03
    C[2, 2], C[3, [0, 2]], D[3, 1] = 1.0, (1.0, -1.0), -1.0
    outputs = ["attitude", "attitude_rate", "flight_path_angle", "angle_of_attack"]
    return control.StateSpace(A, B, C, D, inputs=["deflection", "wind"], outputs=outputs)


folder = pathlib.Path(tempfile.mkdtemp())
law = control.StateSpace(
    [], [], [], [[0.6, 0.8]], 0.02, inputs=["attitude", "attitude_rate"], outputs=["command"]
)
write_system(launcher(), folder / "plant.mat")
write_system(law, folder / "controller.mat")

# %% [markdown]
# ## Poles and residues
#
# A mode with a positive real part grows. Its residue says how strongly the wind drives it, and the
# condition (4b) is that the deflection takes that away again.

# %%
moment = tv.Coefficients(mu_alpha=0.26, mu_delta=2.4)
plant = SystemPlant(read_system(folder / "plant.mat"), moment)
print("poles [1/s]:", np.round(plant.poles, 3))
modes = tv.unstable_modes(plant)
for pole, residue in zip(modes.poles, modes.wind_residues, strict=True):
    print(f"grows with {pole:.4f} 1/s, residue of the wind {residue:+.4f}")

# %% [markdown]
# ## The loop by band
#
# Around the difference equations stand a nozzle of 30 rad/s and a computing delay of 20 ms. Samples
# and delay are exact.

# %%
hardware = {"actuator": tv.Actuator(natural_frequency=30.0, damping=0.7), "delay": 0.02}
steps = read_system(folder / "controller.mat")
bare = SystemAutopilot(steps, **hardware)


def words(bands):
    """Return the margins of the rigid body and of the mode in a line."""
    rigid, mode = bands.rigid, bands.modes[0]
    return (
        f"rigid {rigid.aero_margin_dB:4.1f} dB down, {rigid.gain_increase_dB:4.1f} dB up,"
        f" {rigid.phase_margin_deg:4.1f} deg; mode {mode.peak_dB:5.1f} dB, by {mode.stabilised}"
    )


print(words(bare.band_margins(plant)))
_ = nichols_chart(bare, plant)

# %% [markdown]
# The rigid body has good margins. The mode stands above one, and is held by one degree of phase.
#
# ## Four filters
#
# A notch at the frequency $\omega$ of the mode takes it down by the ratio of its dampings,
#
# $$F(s) = \frac{s^2 + 2\zeta_z\omega s + \omega^2}{s^2 + 2\zeta_p\omega s + \omega^2},
# \qquad F(j\omega) = \zeta_z/\zeta_p .$$
#
# Each filter is put around the same controller: a lead-lag, a deep notch, three shallow notches
# side by side, and lead-lag with the deep notch. How high does the mode stand when it is off?

# %%
F = tv.vehicle.Filter
lag, deep = F.lead_lag(12.0, 4.0), F.notch(14.0, zero_damping=0.02, pole_damping=0.7)
three = tuple(F.notch(14.0 * k, zero_damping=0.1, pole_damping=0.5) for k in (0.9, 1.0, 1.1))
trade = {
    "no filter": (),
    "lead-lag": (lag,),
    "deep notch": (deep,),
    "three notches": three,
    "lead-lag and notch": (lag, deep),
}
off = np.linspace(0.9, 1.1, 21)
detuned = [SystemPlant(launcher(bending=factor), moment) for factor in off]
peaks, stable = {}, {}
for name, filters in trade.items():
    autopilot = SystemAutopilot(steps, **hardware, filters=filters)
    rows = [autopilot.band_margins(moved) for moved in detuned]
    peaks[name] = [row.modes[0].peak_dB for row in rows]
    stable[name] = all(row.margins.stable for row in rows)
    worst = f"worst {max(peaks[name]):5.1f} dB, {'stable' if stable[name] else 'UNSTABLE'}"
    print(f"{name:18} {words(rows[len(off) // 2])}; {worst}")

# %%
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
for name, values in peaks.items():
    axes.plot(100.0 * (off - 1.0), values, label=name)
axes.axhline(-6.0, color="0.5", linestyle=":")
axes.annotate("6 dB below one", (-10.0, -6.0), textcoords="offset points", xytext=(2, 3))
axes.set(xlabel="frequency of the mode off by [%]", ylabel="peak of the mode [dB]")
axes.legend(loc="lower left", bbox_to_anchor=(1.0, 0.3), frameon=False)
plt.show()

# %% [markdown]
# Without a filter the loop is lost where the mode is slower. The lead-lag is flat, as it must be,
# and too high. The deep notch is deepest at its middle; three shallow ones are level, and cost
# another eight degrees of the rigid body.

# %%
chosen = SystemAutopilot(steps, **hardware, filters=(deep,))
_ = nichols_chart(chosen, plant)

# %% [markdown]
# ## Corners
#
# The aerodynamic moment and the thrust are uncertain by 30 percent.

# %%
corners = {}
for aerodynamics in (0.7, 1.3):
    for thrust in (0.7, 1.3):
        corner = SystemPlant(launcher(aerodynamics=aerodynamics, thrust=thrust))
        m = corners[aerodynamics, thrust] = chosen.margins(corner)
        print(
            f"aerodynamics x {aerodynamics}, thrust x {thrust}: {m.aero_margin_dB:4.1f} dB down,"
            f" {m.gain_increase_dB:4.1f} dB up, {m.phase_margin_deg:4.1f} deg, {m.status}"
        )

# %% [markdown]
# ## A gust and its load
#
# Flown by the samples of the controller, with limits of the nozzle. The bending moment at a station
# is that of the slopes over angle of attack and deflection.

# %%
gust = tv.OneMinusCosineGust(peak=np.radians(4.0), duration=4.0)
times = np.linspace(0.0, 12.0, 601)
flights = {
    limit: tv.fly(
        plant,
        SystemLaw(chosen),
        gust,
        times,
        deflection_limit=np.radians(limit),
        sample_rate=50.0,
        **hardware,
    ).outputs
    for limit in (0.4, 1.0)
}
figure, axes = plt.subplots(3, 1, figsize=(7, 6), sharex=True, layout="constrained")
loads = {}
for limit, outputs in flights.items():
    loads[limit] = 6.0e6 * outputs["angle_of_attack"] - 2.5e6 * outputs["deflection"]
    series = (outputs["angle_of_attack"], outputs["deflection"])
    for ax, values in zip(axes, series, strict=False):
        ax.plot(times, np.degrees(values), label=f"limit {limit} deg")
    axes[2].plot(times, loads[limit] / 1e3)
axes[0].set_ylabel("angle of attack [deg]")
axes[1].set_ylabel("deflection [deg]")
axes[2].set(xlabel="time [s]", ylabel="bending moment [kN m]")
axes[0].legend(loc="lower right", frameon=False)
plt.show()

# %%
limits = np.radians([0.2, 0.4, 1.0])
flown = tv.fly_many(
    plant, SystemLaw(chosen), gust, sample_rate=50.0, deflection_limit=limits, **hardware
)
for limit, status in zip(np.degrees(limits), flown.status, strict=True):
    print(f"limit {limit:.1f} deg: {status}")

# %% [markdown]
# ## Back to MATLAB
#
# The opened loop in steps, and the closed one, as files:
# `s = load("loop.mat"); margin(ss(s.A, s.B, s.C, s.D, s.Ts))` draws the same margins.

# %%
write_system(chosen.loop(plant), folder / "loop.mat")
write_system(chosen.continuous.close(plant), folder / "closed.mat")
again = tv.control.loop_margins(
    tv.Loop.from_system(read_system(folder / "loop.mat").to_control(""))
)
print(f"{again.phase_margin_deg:.3f} deg, {chosen.margins(plant).phase_margin_deg:.3f} deg")

# %% [markdown]
# **Try:** your own two files. Then a notch of `pole_damping=0.2`, and where its curve leaves the
# line of 6 dB. And a controller that feeds back the drift too: inputs `drift_rate` and `drift`.

# %%
worst = min(m.phase_margin_deg for m in corners.values())
load = max(np.abs(loads[1.0])) / 1e3
answer = (
    f"The deep notch is: the mode stays {-max(peaks['deep notch']):.0f} dB below one when it is ten"
    f" percent off, the corners keep {worst:.0f} deg, and the gust loads the station with"
    f" {load:.0f} kN m."
)
print(answer)
