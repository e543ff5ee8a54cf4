"""
Sweeping uncertainty
====================

A rod's stiffness and a drive's speed are never known exactly.  A million samples of both, decided in about a second,
turn a verdict into a probability, and say which quantity is worth knowing better.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.stats import norm

import floquetrod as fr

rod = fr.Rod.nitinol()
unit = rod.critical_force

# %%
# The nominal load is stable, but nothing about it is known to better than a few per cent.
load = fr.AxialLoad(mean=0.34 * unit, amplitude=0.2 * unit, frequency=150.0)
print("nominal:", rod.stability(load, growth_tolerance=0.01))

# %%
# Distributions by name, of the load and of the rod: a pair of bounds, or a distribution of SciPy's.  A mode that grows
# tenfold in less than four minutes counts as unstable.
known = {
    "mean": norm(load.mean, 0.10 * load.mean),
    "amplitude": norm(load.amplitude, 0.10 * load.amplitude),
    "frequency": norm(load.frequency, 0.03 * load.frequency),
    "youngs_modulus": norm(rod.youngs_modulus, 0.03 * rod.youngs_modulus),
    "channel_radius": (4.5e-3, 4.9e-3),
}
found = fr.probability_of_instability(rod, load, known, growth_tolerance=0.01, seed=2016)
print(found)

# %%
# Which of them matters most?  The total Sobol index is the share of the variance of the verdict that would stay if all
# other quantities were known; the first-order index the share that would go if this one were.
for name, index in found.importance.items():
    print(f"{name:15} first {index.first:5.3f}, total {index.total:5.3f}")
print("most important:", found.most_important)

# %%
# A drive ten times as steady:
steady = known | {"frequency": norm(load.frequency, 0.003 * load.frequency)}
print(fr.probability_of_instability(rod, load, steady, growth_tolerance=0.01, seed=2016))

# %%
# And where to put the mean force?  What is not known blurs the tongues, but some forces remain better than others.
means = np.linspace(0.1, 0.5, 25) * unit


def probability(mean: float, distributions: dict[str, object]) -> float:
    """Return the probability of instability about another mean force."""
    moved = distributions | {"mean": norm(mean, 0.10 * load.mean)}
    return fr.probability_of_instability(rod, load, moved, samples=10_000, growth_tolerance=0.01, seed=1).probability


_, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained")
names = list(found.importance)
for shift, kind, color in ((-0.2, "first", "0.75"), (0.2, "total", "0.35")):
    values = np.array([getattr(found.importance[name], kind) for name in names])
    ends = np.array([getattr(found.importance[name], f"{kind}_interval") for name in names])
    left.barh(np.arange(len(names)) + shift, values, 0.4, xerr=abs(ends.T - values), color=color, label=kind)
left.set(
    yticks=range(len(names)),
    yticklabels=[name.replace("_", " ").replace("youngs", "Young's") for name in names],
    xlabel="Sobol index",
    xlim=(0.0, 1.0),
)
left.invert_yaxis()
left.legend()
for distributions, style, label in ((known, "-", "as known"), (steady, "--", "drive ten times as steady")):
    right.plot(means, [probability(mean, distributions) for mean in means], style, color="black", label=label)
right.axvline(load.mean, color="0.6", linewidth=0.8, label="the load above")
right.set(
    xlabel=r"nominal mean force $F_\mathrm{ave}$ / N",
    ylabel="probability of instability",
    ylim=(0.0, 1.0),
    xlim=means[[0, -1]],
)
right.legend()
plt.show()
