"""
How probable is buckling?
=========================

With friction buckling depends on the kick, which is not known in advance.  An ensemble simulates many random kicks and
gives the probability with its confidence interval.  The mode equation gives the kick that buckles one mode alone.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

rod, mu = fr.Rod.nitinol(), 0.1
unit = rod.critical_force
load = fr.AxialLoad(mean=0.825 * unit, amplitude=0.7 * unit, frequency=150.0)
needed, mode, none_up_to = rod.critical_kick(load, friction=mu)
print(f"mode {mode} alone: {1e3 * needed:.1f} mm/s buckle the rod; proved: up to {1e3 * none_up_to:.1f} mm/s do not")

# %%
# First that one mode: a kick in it alone, slower and faster than the critical one.
start = fr.Perturbation.modes({mode: needed})
problem = fr.SimulationProblem(
    rod, load, duration=0.4, friction=mu, segments=60, frames=101, perturbation=start, stop_early=True
)
alone = fr.ensemble(problem, over={"kick": np.array([0.7, 0.85, 0.95, 1.05, 1.15, 1.3]) * needed})
for kick, buckled in zip(1e3 * alone["kick"].values, alone["buckled"].values, strict=True):
    print(f"{kick:5.1f} mm/s: {'buckles' if buckled else 'comes to rest'}")

# %%
# Then every node at random: five speeds, eight kicks of each.  ``kick`` scales the perturbation, ``seed`` draws it.
random = problem.replace(perturbation=fr.Perturbation.random(0.1, seed=1))
runs = fr.ensemble(random, over={"kick": [0.05, 0.075, 0.1, 0.125, 0.15], "seed": range(8)})
found = runs.floquetrod.probability("buckled", over="seed", confidence=0.95)
print(found.to_dataframe().round(3))

# %%
# The random kick has to be larger, because it is spread over all modes. The dashed curve is the prediction of the mode
# equations, one mode at a time: how often one of them gets more than its own critical kick. The simulated rod buckles
# at smaller kicks, because all modes move at once, and friction, which opposes their sum, opposes each of them less.
speeds = np.linspace(0.03, 0.3, 55)
critical = {
    m: kick for m, kick in rod.stability(load, friction=mu, kick=0.3).critical_kicks.items() if np.isfinite(kick)
}
place = np.arange(61) * np.pi / 60
shares = []
for seed in range(250):
    drawn = fr.Perturbation.random(1.0, seed=seed).velocities(60)
    drawn /= abs(drawn).max()
    shares.append(max(abs(drawn @ np.sin(m * place)) / 30 / kick for m, kick in critical.items()))
apart = (np.array(shares) * speeds[:, None] > 1.0).mean(axis=1)

_, axes = plt.subplots(figsize=(7.5, 4.2), layout="constrained")
axes.axvspan(0.0, 1e3 * none_up_to, label="proved: buckles no mode alone", **palette.NO_KICK)
axes.axvline(1e3 * needed, color="black", linestyle=":", label=f"critical kick of mode {mode}, mode equation")
axes.plot(
    1e3 * alone["kick"],
    alone["buckled"],
    "s",
    color="black",
    markerfacecolor=palette.STABLE,
    label=f"mode {mode} alone, simulated",
)
axes.plot(1e3 * speeds, apart, "--", color="black", label="random kicks, mode by mode")
share, low, high = found["probability"], found["lower"], found["upper"]
axes.errorbar(
    1e3 * found["kick"],
    share,
    [share - low, high - share],
    fmt="o-",
    color="black",
    capsize=3,
    label="random kicks, simulated (95 %)",
)
axes.set(xlabel="kick: largest speed of any node / (mm/s)", ylabel="probability of buckling", xlim=(0.0, 250.0))
axes.set_title(
    f"mean 0.825 $F_\\mathrm{{cr}}$, amplitude 0.7 $F_\\mathrm{{cr}}$, 150 rad/s, friction {mu:g}",
    fontsize="small",
)
axes.legend(loc="center right", fontsize="small")
plt.show()
