"""
A resonance that bends over
===========================

A spring that stiffens bends the resonance of x'' + c x' + x + x^3 = cos(omega t) to higher frequencies, until between
two folds three motions are possible: two are stable, and the initial conditions decide between them.
"""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette


def duffing(t: Any, x: Any, omega: float, c: float) -> Any:
    """Return the rates of x and x'."""
    return x[1], np.cos(omega * t) - c * x[1] - x[0] - x[0] ** 3


system = fr.NonlinearSystem(duffing, period="2*pi/omega", parameters={"omega": 1.0, "c": 0.2})

# %%
# The branch is followed round its folds, through the unstable orbits between them; every orbit has its verdict.
branches = []
for c in (0.2, 0.4):
    orbit = fr.periodic_orbit(system.with_parameters(c=c), [0.5, 0.0])
    branches.append(fr.follow(orbit, over={"omega": (0.7, 2.6)}))
    print(branches[-1], end="\n\n")

figure, axes = plt.subplots(figsize=(7.0, 4.4), layout="constrained")
for branch in branches:
    branch.plot(axes)
axes.annotate("c = 0.2", (1.6, 2.0), ha="right", fontsize="small")
axes.annotate("c = 0.4", (1.5, 0.8), ha="right", fontsize="small")

# %%
# At a frequency between the folds, the three orbits: the unstable one separates the motions that end on one from those
# that end on the other.
omega = 1.9
crossings = np.flatnonzero(np.diff(np.sign(branches[0].values - omega)))
figure, axes = plt.subplots(figsize=(5.0, 4.2), layout="constrained")
for i in crossings:
    orbit = fr.periodic_orbit(system.with_parameters(omega=omega), branches[0].orbits[i])
    states = orbit(np.linspace(0.0, orbit.period, 800))
    colour, line = ("black", "-") if orbit.status == "stable" else (palette.UNSTABLE, "--")
    axes.plot(
        states[:, 0],
        states[:, 1],
        color=colour,
        linestyle=line,
        label=f"{orbit.status}, amplitude {0.5 * np.ptp(states[:, 0]):.2f}",
    )
axes.set_xlabel("x")
axes.set_ylabel("x'")
axes.set_ylim(-3.6, 5.4)
axes.legend(fontsize="small", frameon=False, loc="upper center")
