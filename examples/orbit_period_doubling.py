"""
Orbits that double
==================

As c grows, the orbit of Roessler's equations loses its stability to one that takes two rounds, that to one of four: the
first steps of the way to chaos, each located where a multiplier passes -1.
"""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr


def roessler(t: Any, x: Any, c: float) -> Any:
    """Return the rates of the three states."""
    return -x[1] - x[2], x[0] + 0.2 * x[1], 0.2 + x[2] * (x[0] - c)


system = fr.NonlinearSystem(roessler, parameters={"c": 2.5})
orbit = fr.periodic_orbit(system, [1.0, 1.0, 0.0], 5.75)

# %%
# From the point where a branch loses its stability, ``switch`` leads onto the branch of twice the period.
doublings, branches = [], []
for _ in range(3):
    branches.append(fr.follow(orbit, over={"c": (2.5, 4.15)}))
    doublings.append(branches[-1].special_points[-1])
    print(doublings[-1])
    orbit = doublings[-1].switch()
gaps = np.diff([point.value for point in doublings])
print(f"The gaps shrink by {gaps[0] / gaps[1]:.3f}; in the end it is Feigenbaum's 4.669.")

# %%
figure, axes = plt.subplots(1, 2, figsize=(9.5, 4.0), layout="constrained")
for branch in branches:
    branch.plot(axes[0], quantity="largest")
doubled = doublings[1].switch()
for each, style in ((doublings[0].orbit, "--"), (doubled, "-")):
    states = each(np.linspace(0.0, each.period, 2000))
    axes[1].plot(states[:, 0], states[:, 1], color="black", linestyle=style, linewidth=1.0)
axes[1].set_xlabel("x[0]")
axes[1].set_ylabel("x[1]")
axes[1].set_title("one round at the first doubling (dashed), four rounds", fontsize="small")
