"""
Your own rod, from a TOML file
==============================

Which frequencies of a vibration tool keep the rod straight?  The rod is described by six lines in a file, which
`floquetrod example my_rod.toml` writes::

    youngs_modulus = "200GPa"
    density = 7850.0 # kg/m3
    diameter = "3mm" # a tube: wall_thickness or inner_diameter, too
    length = "6m"
    channel_diameter = "24mm"
    damping_rate = 0.05 # 1/s, optional
"""

import math
from importlib.resources import files

import matplotlib.pyplot as plt

import floquetrod as fr
from floquetrod.plotting import palette

here = files("floquetrod") / "examples"  # `floquetrod example` writes these files
rod = fr.Rod.from_toml(here / "my_rod.toml")
mean, amplitude = 0.3 * rod.critical_force, 0.15 * rod.critical_force
print(f"critical force {rod.critical_force:.3g} N, critical mode {rod.critical_mode:.3g}")

# %%
# The answer is complete: no window is missed, and nothing inside one grows by more than the tolerance.
windows = rod.ranges("frequency", mean=mean, amplitude=amplitude, bounds=("5Hz", "30Hz"), growth_tolerance=0.01)
print(windows)

widest = max(windows, key=lambda window: window.high - window.low)
choice = 0.5 * (widest.low + widest.high) / (2.0 * math.pi)  # Hz, from rad/s
verdict = rod.stability(fr.AxialLoad(mean, amplitude, f"{choice}Hz"), growth_tolerance=0.01)
print(f"choose {choice:.2f} Hz: {verdict}")

# %%
# The same load at every frequency and mean force, the choice marked.
chart = fr.stability_map(
    rod,
    mean=(0.0, 0.6 * rod.critical_force, 200),
    amplitude=amplitude,
    frequency=("5Hz", "30Hz", 300),
    growth_tolerance=0.01,
)
axes = chart.in_units(mean="N", frequency="Hz", amplitude="N").plot()
axes.plot([choice], [mean], **palette.POINT, markersize=8)
box = palette.BOX | {"edgecolor": "none"}
axes.annotate(
    f"{choice:.2f} Hz",
    (choice, mean),
    xytext=(-8, 10),
    textcoords="offset points",
    ha="right",
    bbox=box,
)
plt.show()
