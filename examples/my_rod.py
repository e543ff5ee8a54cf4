"""
Your own rod, from a TOML file
==============================

Which frequencies of a vibration tool keep the rod straight?  The rod is described by six lines in the file `rod.toml`,
beside this script::

    # A steel rod in a laboratory pipe.  Numbers are SI; strings may carry a unit.  Radii, not diameters.
    youngs_modulus = "200GPa"
    density = 7850.0
    radius = "1.5mm"
    length = "6m"
    channel_radius = "12mm"
    damping_rate = 0.05  # 1/s
"""

import math
import sys
from pathlib import Path

import matplotlib.pyplot as plt

import floquetrod as fr
from floquetrod.plotting import palette

rod = fr.Rod.from_toml(Path(sys.argv[0]).with_name("rod.toml"))
mean, amplitude = 0.3 * rod.critical_force, 0.15 * rod.critical_force
print(f"critical force {rod.critical_force:.3g} N, critical mode {rod.critical_mode:.3g}")

# %%
# The answer is complete: no window is missed, and nothing inside one grows by more than the tolerance.
hertz = 2.0 * math.pi
windows = rod.ranges(
    "frequency", mean=mean, amplitude=amplitude, bounds=(5.0 * hertz, 30.0 * hertz), growth_tolerance=0.01
)
for window in windows:
    print(f"safe from {window.low / hertz:7.3f} to {window.high / hertz:7.3f} Hz")

widest = max(windows, key=lambda window: window.high - window.low)
choice = 0.5 * (widest.low + widest.high)
verdict = rod.stability(fr.AxialLoad(mean, amplitude, choice), growth_tolerance=0.01)
print(f"choose {choice / hertz:.2f} Hz: {verdict}")

# %%
# The same load at every frequency and mean force, the choice marked.
chart = fr.stability_map(
    rod,
    mean=(0.0, 0.6 * rod.critical_force, 200),
    amplitude=amplitude,
    frequency=(5.0 * hertz, 30.0 * hertz, 300),
    growth_tolerance=0.01,
)
axes = chart.in_units(mean="N", frequency="Hz", amplitude="N").plot()
axes.plot([choice / hertz], [mean], **palette.POINT, markersize=8)
box = palette.BOX | {"edgecolor": "none"}
axes.annotate(
    f"{choice / hertz:.2f} Hz",
    (choice / hertz, mean),
    xytext=(-8, 10),
    textcoords="offset points",
    ha="right",
    bbox=box,
)
plt.show()
