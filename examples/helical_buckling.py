"""
Waves, a helix, and lock-up
===========================

Beyond the critical force a rod buckles into waves on the floor of its channel; pushed further, it forms a helix, whose
own contact force brakes it until it locks up.  The simulation is compared with formulas from drilling.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

# A polyethylene rod: soft, so that a slow push takes little time to simulate.
rod = fr.Rod(0.2e9, 1000.0, diameter=20e-3, length=8.5, channel_diameter=30e-3, damping_rate=2.0)
unit, gap, bending = rod.critical_force, rod.radial_clearance, rod.flexural_rigidity
weight = rod.mass_per_length * rod.effective_gravity
print(f"critical force {unit:.1f} N, half wave {rod.critical_half_wave:.2f} m, {rod.critical_mode:.1f} of them")

# %%
# Its upper end is pushed in at 2 mm/s, its lower end stands against a stop.
push = fr.AxialWave(0.9 * unit, 0.0, 1.0, far_end="held", axial_damping=2.0)
kick = fr.Perturbation.random(1e-2, seed=1)
runs = {
    friction: fr.simulate(
        rod, push, feed_speed=2e-3, friction=friction, duration=9.0, segments=240, frames=300, perturbation=kick
    )
    for friction in (0.0, 0.1)
}
for friction, run in runs.items():
    force = run.end_forces[:, 0] / unit
    waves = (run.largest_angle > np.radians(5.0)).argmax()
    helix = (np.abs(run.winding).max(axis=1) > np.pi).argmax()
    print(f"friction {friction}: waves at {force[:waves].max():.2f} F_p, over the top at {force[:helix].max():.2f} F_p")

# %%
# The force it takes, and the shape at three of its values without friction.  Textbooks have the waves from 1 F_p on and
# the helix between 1.41 and 1.83 F_p (shaded); friction delays both.
figure, (above, below) = plt.subplots(2, 1, figsize=(7.5, 7.0), layout="constrained")
above.axhspan(np.sqrt(2.0), 1.83, color=palette.NEUTRAL, alpha=0.5, linewidth=0.0, label="a helix forms (textbook)")
above.axhline(1.0, color="black", linewidth=0.7, linestyle=":", label="waves form (textbook)")
for (friction, run), line in zip(runs.items(), ("-", "--"), strict=True):
    above.plot(2.0 * run.time, run.end_forces[:, 0] / unit, color="black", linestyle=line, label=f"friction {friction}")
above.set(xlabel="pushed in / mm", ylabel="force at the upper end / $F_p$", xlim=(0.0, 18.0))
above.legend(fontsize="small", loc="upper left")
free, s = runs[0.0], np.linspace(0.0, rod.length, 241)
for level, shade, width in ((1.25, "0.65", 1.2), (1.45, "0.35", 1.8), (2.4, "black", 1.2)):
    frame = (free.end_forces[:, 0] > level * unit).argmax()
    below.plot(s, free.winding[frame] / (2.0 * np.pi), color=shade, linewidth=width, label=f"{level:g} $F_p$")
below.set(
    xlabel="position from the upper end $s$ / m", ylabel="angle around the channel / turns", xlim=(0.0, rod.length)
)
below.set_ylim(-1.6, 2.3)
below.legend(fontsize="small", loc="upper center", ncols=3, title="force, no friction", title_fontsize="small")
plt.show()

# %%
# A helix under a constant force of 4 F_p: its slope and its contact force along the rod.  Weight makes both swing about
# the values of the weightless helix, sqrt(F / 2EI) and R F^2 / 4EI.  At a reversal, where the winding changes its hand,
# the rod presses on the wall at one point and is off it on either side.
load = fr.AxialLoad(4.0 * unit, 0.0, 1.0)
wound = fr.simulate(rod.replace(ends="free", damping_rate=10.0), load, duration=3.0, frames=3, perturbation=kick)
s = np.linspace(0.0, rod.length, wound.problem.segments + 1)
slope, contact = np.gradient(wound.winding[-1], s), wound.contact_force[-1]
theory = {"slope": np.sqrt(load.mean / (2.0 * bending)), "contact": gap * load.mean**2 / (4.0 * bending)}
figure, (above, below) = plt.subplots(2, 1, figsize=(7.5, 5.5), sharex=True, layout="constrained")
above.plot(s, slope, color="black")
for sign in (-1.0, 1.0):
    above.axhline(sign * theory["slope"], color=palette.NEUTRAL, linewidth=3.0, linestyle="--", zorder=0)
above.set(ylabel=r"slope $d\theta/ds$ / (rad/m)", ylim=(-2.0 * theory["slope"], 2.0 * theory["slope"]))
below.plot(s, contact, color="black", label="simulated")
below.axhline(
    theory["contact"], color=palette.NEUTRAL, linewidth=3.0, linestyle="--", label="helix without weight", zorder=0
)
below.set(xlabel="position from the upper end $s$ / m", ylabel="contact force / (N/m)", xlim=(0.0, rod.length))
below.set_ylim(0.0, 2.2 * theory["contact"])
below.legend(fontsize="small", loc="upper center", bbox_to_anchor=(0.68, 1.0), ncols=2)
plt.show()

# %%
# Pushed along the channel against 4 F_p at its lower end, with friction 0.15: strings of 0.4 and 1.1 of the lock-up
# length.  The first one slides, and the force settles below the tangent formula, mainly because reversals press less on
# the wall.  The second one locks up: its far end does not move while the force rises.
slider = rod.replace(ends="free", damping_rate=60.0)
formula = slider.lock_up(friction=0.15, far_force=4.0 * unit)
print(formula)
pushed = {}
for part in (0.4, 1.1):
    string = slider.replace(length=part * formula.length)
    pushed[part] = fr.simulate(
        string,
        fr.AxialWave(4.0 * unit, 0.0, 1.0, far_end="free", axial_damping=2.0),
        feed_speed=0.05,
        friction=0.15,
        duration=0.006 * string.length / 0.05,
        segments=int(36.0 * string.critical_mode),
        frames=60,
        perturbation=kick,
    )
    force = pushed[part].end_forces[-1, 0]
    moved = pushed[part].positions[-1, -1, 0] - pushed[part].positions[0, -1, 0]
    print(f"{part:g} of the lock-up length: {force / unit:.2f} F_p at the top, formula ", end="")
    print(f"{formula.force(string.length) / unit:.2f} F_p; far end moved by {1e3 * moved:.0f} mm")

figure, axes = plt.subplots(figsize=(7.5, 4.0), layout="constrained")
for (part, run), line in zip(pushed.items(), ("-", "--"), strict=True):
    fed = 100.0 * 0.05 * run.time / run.rod.length
    axes.plot(fed, run.end_forces[:, 0] / unit, color="black", linestyle=line, label=f"{part:g} of the lock-up length")
    if part < 1.0:
        expected = formula.force(run.rod.length) / unit
        axes.axhline(
            expected, color=palette.NEUTRAL, linewidth=3.0, linestyle=line, label=f"{part:g}: tangent formula", zorder=0
        )
axes.set(
    xlabel="pushed in / % of the length", ylabel="force at the upper end / $F_p$", xlim=(0.0, 0.6), ylim=(0.0, 20.0)
)
axes.legend(fontsize="small", loc="upper left")
plt.show()
