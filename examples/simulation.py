"""
Does the rod do what the theory says?
=====================================

The verdict on a rod rests on one linear equation for each mode.  This example simulates the whole nonlinear rod, with
bending and contact with the channel, and compares it with the verdict.
"""

import matplotlib.pyplot as plt

import floquetrod as fr

rod = fr.Rod.nitinol()
force = rod.critical_force
load = fr.AxialLoad(mean=0.2 * force, amplitude=0.2 * force, frequency=150.0)
verdict = rod.stability(load)
print(verdict)

# %%
# Every node starts with its own small speed across the channel, so that no mode is favoured.  How many segments the rod
# has follows from the load.
start = fr.Perturbation.random(1e-3, seed=1)
run = fr.simulate(rod, load, duration=2.0, perturbation=start)
print(run)

# %%
# The mode that wins is the one predicted, and it grows as predicted.  The verdict takes the force to be the same all
# along the rod; the simulated rod has mass along it, too, and is compared with the wave that both ends send.
fit = run.growth_rate()
wave = fr.AxialWave(load.mean, load.amplitude, load.frequency, far_end="driven")
print(f"mode {run.dominant_mode}: simulated {fit}")
print(f"predicted {rod.stability(wave).growth_rate:.5g} 1/s, with a uniform force {verdict.growth_rate:.5g} 1/s")

# %%
# Seen from above, the scale across stretched, the rod has buckled.  Below, the amplitudes of its leading modes: other
# modes follow only once angles are large.
_, (above, below) = plt.subplots(2, 1, figsize=(7.0, 7.0), layout="constrained")
run.plot(above)
run.plot_growth(below)
plt.show()

# %%
# A little more mean force, and nothing grows: the next stable window.
calm = fr.AxialLoad(mean=0.34 * force, amplitude=0.2 * force, frequency=150.0)
quiet = fr.simulate(rod, calm, duration=1.0, perturbation=start)
print(
    rod.stability(calm, growth_tolerance=0.01).status,
    "in theory;",
    "buckled" if quiet.buckled else "quiet",
    "simulated",
)
