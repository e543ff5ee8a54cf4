"""
How large a vibrated rod moves
==============================

A verdict says where a rod at rest is unstable; how large its motion gets there follows from finite angles.  Bending
stiffens the rod, so that motion bends over to higher frequencies, where the rod at rest is stable again.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

rod = fr.Rod.nitinol().replace(damping_rate=3.0)
unit = rod.critical_force
over = (134.0, 168.0)

# %%
# Both branches of mode 7 for two amplitudes of the force: the stable one begins at the lower edge of its tongue, the
# unstable one at the upper edge.  Crosses are where the rod is about to leave its wall.
figure, axes = plt.subplots(figsize=(7.0, 4.6), layout="constrained")
for amplitude, height in ((0.25, 0.0), (0.15, 1.0)):
    load = fr.AxialLoad(mean=0.2 * unit, amplitude=amplitude * unit, frequency=146.0)
    branches = rod.follow(load, over={"frequency": over}, mode=7)
    print(branches, end="\n\n")
    branches.plot(axes)
    low, high = (part.rests[0] for part in branches.parts)
    axes.plot([low, high], [height, height], color=palette.UNSTABLE, linewidth=5.0, solid_capstyle="butt", alpha=0.5)
    axes.annotate(f"{amplitude:g} $F_{{cr}}$", (high, height), (6, 3), textcoords="offset points", fontsize="small")

# %%
# At a frequency above the tongue the rod at rest is stable, and so is a large motion.  The unstable motion between the
# two is about how far a kick has to swing the rod; :doc:`/how_to/how_large` scans kicks for how hard that is.
for angle, status in branches.at(150.8):
    print(f"{np.degrees(angle):5.1f} degrees, {status}")
print(rod.stability(load.varied("frequency", 150.8)).status, "at rest")
