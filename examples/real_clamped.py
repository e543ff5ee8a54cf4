"""
A clamped wire
==============

A wire in a tube whose ends are hinged, clamped, guided or free.  Ends move frequencies and buckling loads, and couple
the modes: two of them may then grow together, at the sum of their frequencies.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

wire = fr.Rod(200e9, 7850.0, diameter=2e-3, length=2.4, channel_diameter=12e-3, damping_rate=0.3)
unit = wire.critical_force
print(f"critical force {unit:.2f} N, half wave {wire.critical_half_wave:.3f} m")

# %%
# The constant force that buckles it, by its ends: for so short a wire, of three half waves, the ends matter.
kinds = ("hinged", "clamped-hinged", "clamped", "clamped-guided", "clamped-free")
for ends in kinds:
    least = wire.replace(ends=ends).critical("mean", amplitude=0.0, frequency=1.0)
    print(f"{ends:15} buckles at {least / unit:.4f} F_cr")

# %%
# Growth over the frequency.
mean, amplitude = 0.4 * unit, 0.4 * unit
hertz = np.linspace(14.0, 40.0, 105)
figure, panels = plt.subplots(len(kinds), 1, figsize=(8.0, 8.0), sharex=True, sharey=True, layout="constrained")
for axes, ends in zip(panels, kinds, strict=True):
    held = wire.replace(ends=ends)
    growth = held.growth_rate(mean=mean, amplitude=amplitude, frequency=2.0 * np.pi * hertz)
    axes.fill_between(hertz, 0.0, growth, color=palette.UNSTABLE, linewidth=0.0)
    axes.plot(hertz, growth, color="black", linewidth=0.9)
    peaks = np.flatnonzero((growth[1:-1] > growth[:-2]) & (growth[1:-1] >= growth[2:])) + 1
    for peak in peaks[growth[peaks] > 0.5]:
        verdict = held.stability(fr.AxialLoad.hertz(mean, amplitude, hertz[peak]))
        name = "+".join(map(str, verdict.resonances[0].modes))
        axes.annotate(
            name, (hertz[peak], growth[peak]), (0, 2), textcoords="offset points", ha="center", fontsize="small"
        )
    axes.set_ylabel(ends, fontsize="small")
figure.supylabel("growth rate / (1/s), by ends")
panels[-1].set(xlabel="forcing frequency / Hz", xlim=(hertz[0], hertz[-1]))
panels[0].set_ylim(0.0, 1.3 * max(axes.lines[0].get_ydata().max() for axes in panels))
panels[0].set_title("numbers at the peaks: the mode, or the two modes, that grow", fontsize="small")
plt.show()
