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
# # What deflection covers 99.865 percent of all flights, and how sure is that?
#
# Thrust, masses, aerodynamics and winds scatter. A campaign draws many cases, computes each of
# them, and says what the sample proves. Nothing that was finished is ever lost.

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import tvclin as tv
from tvclin.plots import response_chart

# %% [markdown]
# The first answer takes seconds, with dispersions that are assumed. It is for a head wind, which
# raises the dynamic pressure; a campaign below omits that.

# %%
vehicle = tv.load_vehicle("configuration-i")
study = tv.Study.from_vehicle(vehicle, duration=7.5, peak=np.radians(5.0))
first = tv.ensembles.disperse_study(study)
first

# %% [markdown]
# A campaign says everything itself: what is dispersed and how, what is to be computed, how many
# cases at most, and from which seed.

# %%
campaign = tv.Campaign(
    vehicle=vehicle,
    wind=tv.ShapedWind("triangular", peak=np.radians(5.0), duration=7.5),
    dispersions=tv.Dispersions(
        (
            tv.Dispersion("thrust", "truncated", 0.01),
            tv.Dispersion("normal_force_slope", "truncated", 0.05),
            tv.Dispersion("aerodynamic_arm", "truncated", 0.05),
            tv.Dispersion("wind_duration", "uniform", 0.3),
        )
    ),
    outputs=("required",),
    dead_bands=(1.0, 0.5),
    cases=4000,
    seed=1,
    nozzle=tv.Nozzle(limit=np.radians(0.45)),
)
found = tv.run_campaign(campaign, Path(tempfile.mkdtemp()) / "results")

# %% [markdown]
# The deflection that covers $P = 99.865$ percent. `upper` is what may be claimed with $C = 90$
# percent confidence, whatever the distribution. The largest of $n$ cases covers that part if
#
# $$1 - P^n \ge C, \qquad n \ge \frac{\ln(1 - C)}{\ln P} = \frac{\ln 0.1}{\ln 0.99865} = 1705$$
#
# cases; with more cases a smaller one does.

# %%
required = found.quantile()
for name in ("lower", "estimate", "upper"):
    print(f"{name:8s} {np.degrees(getattr(required, name)):.4f} deg")

# %%
deflections = np.degrees(np.sort(found.to_xarray()["required_K1"].values))
fig, axes = plt.subplots(figsize=(8.6, 5.0), layout="constrained")
axes.plot(deflections, 100.0 * np.arange(1, deflections.size + 1) / deflections.size, label="cases")
axes.axvline(np.degrees(required.upper), ls="--", color="0.4", label="99.865 %, 90 % confidence")
axes.axvline(np.degrees(campaign.nozzle.limit), color="tab:orange", label="limit")
axes.set(title=f"Required deflection of {campaign.cases} cases, K = 1")
axes.set(xlabel="required deflection [deg]", ylabel="cases that need no more [%]")
_ = axes.legend()

# %% [markdown]
# Which dispersion drives it? Rank correlations with the required deflection, the strongest first.

# %%
for name, value in found.drivers().items():
    print(f"{name.replace('_', ' '):20s} {value:+.2f}")

# %% [markdown]
# And the worst case, in full.

# %%
worst = found.replay(int(found.worst(1)[0]))
title = f"Case {worst.case}, with the limit that it needs"
_ = response_chart(worst.response(), title, limit=abs(worst.required))

# %% [markdown]
# **Try:** another seed, and look by how much the numbers move; then half the cases. On the
# command line it is `tvclin disperse`, on as many machines as you have.

# %%
driver = next(iter(found.drivers()))
answer = (
    f"{np.degrees(required.upper):.3f} deg cover 99.865 percent of the flights with 90 percent "
    f"confidence, by {campaign.cases} cases from seed {campaign.seed}; {driver.replace('_', ' ')} "
    f"drives it most."
)
print(answer)
