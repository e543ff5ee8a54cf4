"""
Sweeping uncertainty
====================

A rod's stiffness and a drive's speed are never known exactly.  A million samples of both, classified in about a second,
turn a verdict into a probability.
"""

import time

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr

rod, samples = fr.Rod.nitinol(), 1_000_000
rng = np.random.default_rng(2016)

# %%
# Load: known to a few per cent.  Stable at its nominal value.
nominal = {"mean": 0.34 * rod.critical_force, "amplitude": 0.2 * rod.critical_force, "frequency": 150.0}
spread = {"mean": 0.10, "amplitude": 0.10, "frequency": 0.03}
print("nominal:", rod.stability(fr.AxialLoad(**nominal)))

# %%
# The rod: its modulus to 3 %, its radial clearance to 5 %.  Each of 400 rods meets 2500 loads of its own.
rods = 400
size = (rods, samples // rods)
drawn = {name: value * (1.0 + spread[name] * rng.standard_normal(size)) for name, value in nominal.items()}
stable = np.empty(size, dtype=bool)
start = time.perf_counter()
for i, (modulus, clearance) in enumerate(1.0 + np.array([0.03, 0.05]) * rng.standard_normal((rods, 2))):
    one = rod.replace(
        youngs_modulus=rod.youngs_modulus * modulus, channel_radius=rod.radius + rod.radial_clearance * clearance
    )
    stable[i] = one.is_stable(*(values[i] for values in drawn.values()), growth_tolerance=0.01)
seconds = time.perf_counter() - start

# %%
# Loads on the same rod are correlated through it, so the error is that of a mean over rods.
unstable = 1.0 - stable.mean(axis=1)
print(f"unstable: {100.0 * unstable.mean():.2f} +- {100.0 * unstable.std() / np.sqrt(rods):.2f} %")
print(f"{stable.size:,} samples took {seconds:.1f} s")

# %%
# What to do about it: the probability given each quantity of the load tells which one to control, and where to put it.
_, panels = plt.subplots(1, 3, figsize=(9.0, 3.2), sharey=True, layout="constrained")
names = {
    "mean": r"mean force $F_\mathrm{ave}$ / N",
    "amplitude": r"amplitude $\Delta F$ / N",
    "frequency": r"frequency $\omega$ / rad/s",
}
for axes, (name, label) in zip(panels, names.items(), strict=True):
    edges = nominal[name] * (1.0 + spread[name] * np.linspace(-2.5, 2.5, 51))
    count, _ = np.histogram(drawn[name], edges)
    bad, _ = np.histogram(drawn[name][~stable], edges)
    axes.stairs(bad / count, edges, baseline=None, color="black")
    axes.axvline(nominal[name], color="black", linestyle="--", linewidth=0.8)
    axes.set_xlabel(label)
panels[0].set(ylabel="probability of instability", ylim=(0.0, 1.0))
panels[1].set_title("dashed: the nominal load, itself stable", fontsize="small")
plt.show()
