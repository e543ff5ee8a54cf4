"""
Vibration reduces drag
======================

Dry friction opposes the velocity.  A string that vibrates along its channel faster than it is pushed slides backwards
for a part of every period, which reduces its drag, so much that a string can be pushed past its lock-up length.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

rod = fr.Rod(0.2e9, 1000.0, diameter=20e-3, length=2.0, channel_diameter=30e-3, damping_rate=5.0)
unit = rod.critical_force
weight = rod.mass_per_length * rod.effective_gravity

# %%
# First a short straight rod, too weakly pushed to buckle.  Its upper end is fed at v, a force of 10 Hz vibrates its
# lower end, and at s the rod vibrates with the speed A(s).  Coulomb's law, averaged over a period, gives a drag of 2/pi
# asin(v / A) of its full value where A > v.  (The simulated drag is 2 % smaller: the hinges carry the rod's ends.)
friction, hertz, segments = 0.05, 10.0, 48
load = fr.AxialLoad.hertz(0.1 * unit, 0.25 * unit, hertz)
kappa, s = load.frequency / rod.wave_speed, np.linspace(0.0, rod.length, 2001)[1:]
speeds = (
    load.amplitude * rod.wave_speed / (rod.youngs_modulus * rod.area) * np.sin(kappa * s) / np.cos(kappa * rod.length)
)
still = fr.Perturbation.modes({})


def drag(ratio: float) -> float:
    """Return the mean drag over mu w L, that of the fluid taken away, at v = the largest A over ``ratio``."""
    speed = speeds[-1] / ratio
    options = {"friction": friction, "feed_speed": speed, "segments": segments, "perturbation": still}
    run = fr.simulate(rod, load, duration=2.0, frames=21, **options)
    held_back = (run.end_forces[11:, 0] - run.end_forces[11:, 1]).mean()
    fluid = 2.0 * rod.damping_rate * rod.density * rod.area * rod.length * speed
    return (held_back - fluid) / (friction * weight * rod.length)


ratios = np.geomspace(0.4, 30.0, 6)
simulated = [drag(ratio) for ratio in ratios]
fine = np.geomspace(0.4, 30.0, 200)
averaged = [np.mean(2.0 / np.pi * np.arcsin(np.minimum(1.0, speeds[-1] / ratio / speeds))) for ratio in fine]
at_ratios = np.interp(ratios, fine, averaged)
print(f"largest difference from the average: {np.abs(simulated - at_ratios).max():.3f} of mu w L")

# %%
# Now a string wound into a helix, 1.2 times as long as can be pushed against 3 F_p at its lower end.  Without vibration
# its far end stays while the force climbs past 20 F_p.  A vibration of that end with 1 F_p at 10 Hz, one of 0.22 m/s
# against the 0.05 m/s at which the string is fed, lets it slide.
string = rod.replace(damping_rate=3.0)
formula = string.lock_up(friction=0.3, far_force=3.0 * unit)
string = string.replace(length=1.2 * formula.length)
print(formula)
runs = {}
for amplitude in (0.0, 1.0):
    runs[amplitude] = run = fr.simulate(
        string,
        fr.AxialLoad.hertz(3.0 * unit, amplitude * unit, hertz),
        feed_speed=0.05,
        friction=0.3,
        duration=0.006 * string.length / 0.05,
        segments=int(40.0 * string.critical_mode),
        frames=37,
        perturbation=fr.Perturbation.random(1e-2, seed=1),
    )
    moved = run.positions[-1, -1, 0] - run.positions[0, -1, 0]
    last = run.end_forces[-10:, 0].mean() / unit
    print(f"vibration {amplitude:g} F_p: {last:.1f} F_p at the top, far end moved by {1e3 * moved:.0f} mm of 156 mm")

# %%
# Left, drag against the speed of the vibration.  Right, the force at the upper end and how far the lower one has come.
figure, panels = plt.subplot_mosaic([["left", "right"], ["left", "below"]], figsize=(9.0, 4.8), layout="constrained")
left, right, below = (panels[name] for name in ("left", "right", "below"))
left.plot(fine, averaged, color=palette.NEUTRAL, linewidth=4.0, label="Coulomb's law, averaged")
left.plot(ratios, simulated, linestyle="", **palette.POINT, label="simulated")
left.set(
    xscale="log", xlabel="largest speed of vibration / feed speed", ylabel=r"mean drag / $\mu w L$", ylim=(0.0, 1.1)
)
left.set_xticks([0.5, 1.0, 2.0, 5.0, 10.0, 20.0], labels=["0.5", "1", "2", "5", "10", "20"])
left.legend(fontsize="small")
for (amplitude, run), line in zip(runs.items(), ("--", "-"), strict=True):
    fed = 1e3 * 0.05 * run.time
    right.plot(fed, run.end_forces[:, 0] / unit, color="black", linestyle=line, label=f"{amplitude:g} $F_p$")
    below.plot(fed, 1e3 * (run.positions[:, -1, 0] - run.positions[0, -1, 0]), color="black", linestyle=line)
right.set(ylabel="force at the top / $F_p$", ylim=(0.0, 30.0), xlim=(0.0, 156.0))
right.legend(fontsize="small", title="vibration", title_fontsize="small", loc="upper left")
below.plot(fed, fed, color=palette.NEUTRAL, linewidth=4.0, zorder=0, label="as fed")
below.set(xlabel="fed at the upper end / mm", ylabel="far end moved / mm", xlim=(0.0, 156.0))
below.legend(fontsize="small", loc="upper left")
plt.show()
