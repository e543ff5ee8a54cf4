"""
How large a vibrated rod moves
==============================

A verdict says under which force a rod at rest is unstable; how large its motion becomes follows from finite angles.
Bending stiffens the rod, so that near the upper edge of a tongue a large motion outlasts the force that began it.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

rod = fr.Rod.nitinol().replace(damping_rate=3.0)
unit = rod.critical_force
load = fr.AxialLoad(mean=0.2 * unit, amplitude=0.15 * unit, frequency=150.0)

# %%
# The branch of mode 7 over the amplitude of the force, at 150 rad/s, near the upper edge of its tongue.  It leaves rest
# towards smaller forces, unstable up to its fold, and stable from there on; at the cross the rod is about to leave its
# wall.
branches = rod.follow(load, over={"amplitude": (0.06 * unit, 0.2 * unit)}, mode=7)
print(branches)
part = branches.parts[0]
onset, fold = part.rests[0], part.branch.special_points[0].value

figure, axes = plt.subplots(figsize=(7.0, 4.6), layout="constrained")
branches.plot(axes)
axes.axvspan(fold, onset, color=palette.NEUTRAL, alpha=0.5, linewidth=0.0)
axes.set_xlim(0.9 * fold, None)

# %%
# Between fold and onset, shaded, the rod at rest is stable, and so is a large motion: as the force rises the rod jumps
# to it at the onset, and as the force falls it jumps back at the fold.  The amplitude of the unstable motion between
# the two is about that to which a kick has to swing the rod; :doc:`/how_to/how_large` scans kicks, and shows branches
# over the frequency.
middle = 0.5 * (fold + onset)
print(f"onset {onset / unit:.4f} F_cr, fold {fold / unit:.4f} F_cr; between them")
print(rod.stability(load.varied("amplitude", middle)).status, "at rest")
for angle, status in branches.at(middle):
    print(f"{np.degrees(angle):5.1f} degrees, {status}")
