"""
Does a large motion stop where the rod at rest becomes stable?
==============================================================

A vibration makes a rod buckle, and is then reduced in steps. Every simulation starts from the last state of the one
before, so that the motion, the time and the phase of the vibration go on.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

rod = fr.Rod.nitinol().replace(damping_rate=8.0)
force = rod.critical_force
mean, frequency = 0.85 * force, 150.0
kick = fr.Perturbation.random(5e-2, seed=1)
sizes = [0.45, 0.35, 0.3, 0.25, 0.225, 0.18, 0.15]  # of the vibration, over the critical force

# %%
# ``start`` is the run before, or its file; segments and perturbation are those of that run. For comparison each load
# also acts on a rod that lies on the floor and is kicked.
steps, alone = [], []
for size in sizes:
    load = fr.AxialLoad(mean=mean, amplitude=size * force, frequency=frequency)
    first = {"perturbation": kick, "segments": 60}
    steps.append(fr.simulate(rod, load, duration=1.2, **({"start": steps[-1]} if steps else first)))
    alone.append(fr.simulate(rod, load, duration=1.2, **first))
    print(f"{size:.3f} Fcr, rest {rod.stability(load).status}: {steps[-1].outcome.words};", alone[-1].outcome.words)

# %%
# The rod at rest is stable below 0.25 of the critical force, but the large motion lasts at 0.225: in between it depends
# on the past which of the two is seen. (At 0.3 the kicked rod still grows when its run ends.) Angles are measured from
# the rest on the floor in every run, never from where a run starts.
stable = rod.ranges("amplitude", mean=mean, frequency=frequency, bounds=(0.1 * force, 0.5 * force))
edge = stable.intervals[-1].high / force
figure, (above, below) = plt.subplots(2, 1, figsize=(7.0, 7.0), layout="constrained")
above.axvspan(edge, 0.47, color=palette.UNSEEN, label="rod at rest unstable")
for runs, colour, marker, label in (
    (steps, "black", "o", "from the run before"),
    (alone, palette.NEUTRAL, "s", "kicked on the floor"),
):
    angles = [np.degrees(run.outcome.angle) for run in runs]
    above.plot(sizes, angles, color=colour, marker=marker, linestyle=":", label=label)
above.set_xlim(0.13, 0.47)
above.set_xlabel(r"amplitude $\Delta F / F_\mathrm{cr}$")
above.set_ylabel("largest angle / degree")
above.legend(loc="upper left")
for size, run in zip(sizes, steps, strict=True):
    below.plot(run.time, np.degrees(run.largest_angle), color="black", linewidth=0.6)
    below.axvline(run.time[0], color="0.7", linewidth=0.8)
    below.annotate(f"{size:g}", (run.time.mean(), 52.0), ha="center")
below.set_ylim(0.0, 57.0)
below.set_xlim(0.0, steps[-1].time[-1])
below.set_xlabel("time $t$ / s")
below.set_ylabel("largest angle / degree")
below.set_title(r"amplitude $\Delta F / F_\mathrm{cr}$ of each step, above the angle of the rod", fontsize="medium")
plt.show()
