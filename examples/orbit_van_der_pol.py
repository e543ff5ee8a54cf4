"""
A relaxation oscillation
========================

The limit cycle of van der Pol's equation x'' - mu (1 - x^2) x' + x = 0, from nearly harmonic to one with slow and fast
phases, with its period and its multiplier.
"""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr


def van_der_pol(t: Any, x: Any, mu: float) -> Any:
    """Return the rates of x and x'."""
    return x[1], mu * (1 - x[0] ** 2) * x[1] - x[0]


system = fr.NonlinearSystem(van_der_pol, parameters={"mu": 0.2})
orbits = [fr.periodic_orbit(system.with_parameters(mu=mu), [2.0, 0.0]) for mu in (0.2, 1.0, 5.0)]
for orbit in orbits:
    print(orbit, end="\n\n")

# %%
# The mesh is fine where the oscillation jumps: dots are its points.
figure, axes = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
for orbit, style in zip(orbits, (":", "--", "-"), strict=True):
    share = np.linspace(0.0, 1.0, 2000)
    states = orbit(share * orbit.period)
    name = f"mu = {orbit.system.parameters['mu']:g}"
    axes[0].plot(share, states[:, 0], color="black", linestyle=style, label=name)
    axes[1].plot(states[:, 0], states[:, 1], color="black", linestyle=style)
axes[0].plot(orbit.times / orbit.period, orbit.states[:, 0], ".", color="black", markersize=4)
axes[0].set_xlabel("t, part of the period")
axes[0].set_ylabel("x")
axes[0].set_ylim(-2.2, 3.0)
axes[0].legend(fontsize="small", frameon=False, loc="upper right", ncols=3)
axes[1].set_xlabel("x")
axes[1].set_ylabel("x'")

# %%
# Followed over mu, the period grows from 2 pi towards (3 - 2 log 2) mu, and the one multiplier besides the trivial 1
# falls faster than exponentially: the area under the logarithm is the damping over a period.
branch = fr.follow(orbits[0], over={"mu": (0.05, 5.0)})
figure, axes = plt.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained")
branch.plot(axes[0], quantity="period")
axes[0].plot([0.05, 5.0], [2.0 * np.pi] * 2, color="0.6", linewidth=0.8)
axes[1].semilogy(branch.values, np.abs(branch.multipliers[:, 0]), color="black")
axes[1].set_xlabel("mu")
axes[1].set_ylabel("multiplier")
print(branch)
