"""
A string in a bending well
==========================

Where a well builds, compression presses the string onto its floor; where it drops, compression lifts it.  What
force buckles a string in a bend, and how far can it be pushed into a well, without and with a vibration tool?
"""

from importlib.resources import files

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

here = files("floquetrod") / "examples"  # `floquetrod example` writes these files
tubing = fr.Rod.from_toml(here / "tubing.toml")
well = fr.WellPath.from_csv(here / "survey.csv")
print(well)

# %%
# First this 2 inch tubing, horizontal, in channels of various curvatures.  The force from which it buckles solves F^2 =
# 4 E I (q + F k), with k the curvature and q the weight of a length, each over the radial clearance (He and Kyllingstad
# 1995).  Independently, verdicts show whether any mode of 600 m grows; the onset is found by bisection.
level = tubing.replace(inclination="90deg")
bending, gap, weight = level.flexural_rigidity, level.radial_clearance, level.weight_per_length
curvatures = np.linspace(-0.006, 0.006, 121)
limits = np.array([level.replace(curvature=each).critical_force for each in curvatures])
k, q = curvatures / gap, weight / gap
criterion = np.array([np.roots([1.0, -4.0 * bending * each, -4.0 * bending * q]).max() for each in k])
print(f"largest difference from the criterion: {np.abs(limits / criterion - 1.0).max():.1e} of the force")


def onset(curvature: float) -> float:
    """Return the constant force in N from which on a mode of 600 m grows."""
    section = level.replace(curvature=curvature, length=600.0)
    low, high = 0.0, 1.5 * section.critical_force
    if curvature < 0.0:
        high = min(high, 0.9999 * weight / -curvature)  # beyond, it is off the floor
    while high - low > 4.0:
        middle = 0.5 * (low + high)
        low, high = (
            (low, middle) if section.growth_rate(mean=middle, amplitude=0.0, frequency=1.0) > 0.0 else (middle, high)
        )
    return high


some = curvatures[::12]
found = np.array([onset(each) for each in some])
print(f"largest difference of verdicts from it: {100.0 * np.abs(found / criterion[::12] - 1.0).max():.2f} %")

# %%
# In a drop the limit comes close to the force that lifts the string off the floor, weight over curvature, and stays
# below it: the string buckles first.
figure, axes = plt.subplots(figsize=(7.5, 4.2), layout="constrained")
axes.plot(curvatures, 1e-3 * limits, color="black", label="buckles")
axes.plot(some, 1e-3 * found, linestyle="none", label="a mode of 600 m begins to grow", **palette.POINT)
drops = curvatures[curvatures < -0.001]
axes.plot(drops, 1e-3 * weight / -drops, color="black", linestyle=":", label="is lifted off the floor")
axes.axvline(0.0, color=palette.NEUTRAL, linewidth=0.8, zorder=0)
axes.set(xlabel="curvature / (1/m): drops, and builds", ylabel="force / kN", xlim=(-0.006, 0.006), ylim=(0.0, 35.0))
degrees = 30.0 * 180.0 / np.pi
above = axes.secondary_xaxis("top", functions=(lambda k: degrees * k, lambda d: d / degrees))
above.set_xlabel("degrees in 30 m")
axes.legend(fontsize="small", loc="upper left")
plt.show()

# %%
# The well of the survey: vertical to 900 m, a build to 1800 m, an undulating lateral. With friction 0.3 the string is
# pushed in until it is stuck, first without and then with a tool of 5 kN and 18 Hz at its end, whose wave moves it
# faster than it slides and so reduces friction.
tool = fr.VibrationTool("5kN", "18Hz")
depths = {0.2: [3000.0, 4500.0], 0.3: np.linspace(400.0, 4500.0, 14), 0.4: [2000.0, 4500.0]}
frictions = np.array(list(depths))
reaches = [tubing.reach(well, each, tool=tool, depth=depths[each]) for each in frictions]
for friction, each in zip(frictions, reaches, strict=True):
    print(f"friction {friction:g}: {each}")

figure, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.8), layout="constrained")
chosen = reaches[1]
cases = {
    "without the tool": ("-", chosen.bit, chosen.reach, [each.reach for each in reaches]),
    "with the tool": ("--", chosen.bit_shaken, chosen.reach_shaken, [each.reach_shaken for each in reaches]),
}
for label, (line, force, deepest, reached) in cases.items():
    arrives = np.isfinite(force)  # elsewhere nothing does, and where the string is stuck no force is left
    bit = np.append(chosen.bit_depth[arrives], deepest), 1e-3 * np.append(force[arrives], 0.0)
    left.plot(*bit, color="black", linestyle=line, label=label)
    right.plot(frictions, reached, color="black", linestyle=line, marker="o", label=label)
left.set(xlabel="measured depth of the bit / m", ylabel="greatest force at the bit / kN", xlim=(0.0, 4500.0))
left.set_ylim(0.0, 45.0)
left.set_title("friction 0.3", fontsize="small")
left.legend(fontsize="small", loc="upper right")
right.axhline(well.end, color=palette.NEUTRAL, linewidth=3.0, zorder=0, label="end of the well")
right.set(xlabel="friction", ylabel="reach / m", xlim=(0.19, 0.41), ylim=(0.0, 5000.0))
right.legend(fontsize="small", loc="lower left")
plt.show()

# %%
# Where the string of friction 0.3 is buckled when it is stuck with the tool: where the force in it exceeds the local
# limit. That limit is drawn between stations with the bend of the survey, and for a straight well. Above, it hangs in
# the vertical hole and hardly touches the wall: there the vibration makes lateral waves grow.
print(dict(chosen.report().lines)["waves"])
edges = well.depth[well.depth >= 600.0]
middles = 0.5 * (edges[1:] + edges[:-1])
bent = [tubing.replace(path=well, depth=each - 5.0, length=10.0).critical_force for each in middles]
fine = np.linspace(600.0, 4500.0, 201)
slopes = well.inclination_at(fine)
levelled = np.minimum(slopes, np.pi - slopes)  # critical forces are those of a hole that falls as much
straight = [tubing.replace(inclination=each).critical_force for each in levelled]
along = chosen.along
figure, axes = plt.subplots(figsize=(7.5, 4.2), layout="constrained")
axes.plot(along.depth, 1e-3 * along.force, color="black", linewidth=2.0, label="force in the string")
axes.stairs(1e-3 * np.array(bent), edges, baseline=None, color="black", linewidth=0.8, label="limit in the bend")
axes.plot(fine, 1e-3 * np.array(straight), color="black", linestyle=":", label="limit if it were straight")
axes.fill_between(
    along.depth,
    0.0,
    1.0,
    where=along.is_snaking,
    transform=axes.get_xaxis_transform(),
    color=palette.NEUTRAL,
    alpha=0.5,
    linewidth=0.0,
    zorder=0,
    label="buckled",
)
axes.set(xlabel="measured depth / m", ylabel="compression / kN", xlim=(600.0, 4500.0), ylim=(0.0, 35.0))
axes.legend(fontsize="small", loc="upper right")
plt.show()
