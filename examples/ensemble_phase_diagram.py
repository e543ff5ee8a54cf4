"""
Simulated rods on the exact map
===============================

A map of a rod's stability comes from one equation for each mode.  This example simulates a whole nonlinear rod at each
of many points of the map; those that buckle within 1.2 s are black.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

rod = fr.Rod.nitinol()
unit = rod.critical_force
load = fr.AxialLoad(mean=0.3 * unit, amplitude=0.2 * unit, frequency=150.0)

# %%
# The problem holds what all rods have in common: no friction, and a small random speed of every node.  A run ends once
# its rod has clearly buckled, which saves half of the time.
problem = fr.SimulationProblem(
    rod, load, duration=1.2, segments=48, stop_early=True, perturbation=fr.Perturbation.random(0.01, seed=1)
)
over = {"mean": np.linspace(0.05, 0.6, 6) * unit, "amplitude": np.linspace(0.05, 0.4, 3) * unit}
runs = fr.ensemble(problem, over=over)
buckled = runs["buckled"].values
print(f"{buckled.sum()} of {buckled.size} rods buckled, in {float(runs['wall_time'].sum()):.0f} s of computing")

# %%
# The same loads by the mode equations.  No rod buckles where nothing grows, and all do where growth is fast enough for
# that time: a factor of 50 takes 3.3 per second.
growth = np.array(
    [
        [rod.stability(fr.AxialLoad(mean, amplitude, 150.0)).growth_rate for amplitude in over["amplitude"]]
        for mean in over["mean"]
    ]
)
print(f"slowest growth that buckled a rod {growth[buckled].min():.2f} 1/s")
print(f"fastest growth that did not {growth[~buckled].max():.2f} 1/s")

# %%
# Both together.  The edges of the bands are exact; the shades say how fast growth is.
chart = fr.stability_map(
    rod, mean=(0.03 * unit, 0.62 * unit, 100), amplitude=(0.03 * unit, 0.42 * unit, 80), frequency=150.0, growth=True
)
figure, axes = plt.subplots(figsize=(8.0, 4.6), layout="constrained")
chart.in_units(mean="Fcr", amplitude="Fcr").plot(axes)
mean, amplitude = (values / unit for values in np.meshgrid(*over.values(), indexing="ij"))
style = {"linestyle": "none", "marker": "o", "markersize": 6.0, "zorder": 5}
axes.plot(
    mean[buckled], amplitude[buckled], markerfacecolor="black", markeredgecolor=palette.STABLE, label="buckled", **style
)
axes.plot(
    mean[~buckled],
    amplitude[~buckled],
    markerfacecolor=palette.STABLE,
    markeredgecolor="black",
    label="not within 1.2 s",
    **style,
)
figure.legend(loc="outside lower center", ncols=2, fontsize="small")
plt.show()
