"""
Which frequency should I choose?
================================

The safe windows of a rod: every interval of the frequency in which no mode grows, without a grid, so that none is
missed.  The widest one allows the largest variation of the drive's speed.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

rod = fr.Rod.nitinol()
mean, amplitude = 0.35 * rod.critical_force, 0.2 * rod.critical_force
bounds, tolerance = (60.0, 260.0), 0.02

# %%
# Growth of up to 0.02 per second is accepted here: tenfold in two minutes, less than the slightest damping removes.
windows = rod.ranges("frequency", mean=mean, amplitude=amplitude, bounds=bounds, growth_tolerance=tolerance)
print(windows)

# %%
# Take the middle of the window with the largest room relative to its frequency, and ask how far the load may vary.
best = max(windows, key=lambda window: window.high / window.low)
choice = 0.5 * (best.low + best.high)
verdict = rod.stability(fr.AxialLoad(mean, amplitude, choice), growth_tolerance=tolerance)
print(verdict)
room = min(choice - best.low, best.high - choice)
print(f"choose {choice:.1f} rad/s: it may drift by {room:.1f} rad/s, {100.0 * room / choice:.1f} %, either way")

# %%
# The growth rate over the frequency agrees with the windows; each peak is one mode in one of its tongues.
frequency = np.linspace(*bounds, 4000)
growth, mode = rod.growth_rate(mean=mean, amplitude=amplitude, frequency=frequency, return_mode=True)
_, axes = plt.subplots(figsize=(8.0, 4.0), layout="constrained")
axes.plot(frequency, growth, color="black", linewidth=0.8)
axes.set_facecolor(palette.UNSTABLE)
for window in windows:
    axes.axvspan(window.low, window.high, color=palette.STABLE, linewidth=0.0)
axes.axvline(choice, color="black", linestyle="--", linewidth=0.9)
style = {"xytext": (4, 0), "textcoords": "offset points", "bbox": palette.BOX | {"edgecolor": "none"}}
axes.annotate(f"{choice:.0f} rad/s", (choice, 0.93 * growth.max()), **style)
for number in np.unique(mode[growth > 1.0]):
    peak = np.argmax(np.where(mode == number, growth, 0.0))
    if mode[peak - 1] == number == mode[peak + 1]:  # no peak of its own where another mode is as fast
        axes.annotate(f"{number}", (frequency[peak], growth[peak]), ha="center", va="bottom", fontsize="small")
axes.set(
    xlim=bounds, ylim=(0.0, 1.1 * growth.max()), xlabel=r"frequency $\omega$ / (rad/s)", ylabel="growth rate / (1/s)"
)
axes.set_title("growth of the fastest mode, its number at the peaks; safe windows white", fontsize="small")
plt.show()
