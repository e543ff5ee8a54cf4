"""
The same tool at 60 m and at 600 m
==================================

A vibration tool on coiled tubing.  Its force travels along the string as a wave: over 60 m that hardly differs from a
force that is the same everywhere, over 600 m it does.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

warnings.simplefilter("ignore", fr.UniformForceWarning)  # what this page is about
string = fr.Rod.catalogue(
    "2.00x0.156", bore="4.778in", length=60.0, fluid_inside=1000.0, fluid_outside=1000.0, damping_rate=0.2
)
unit, hertz = string.critical_force, 5.0
print(f"critical force {unit:.0f} N; wave length of the tool's force {string.wave_speed / hertz:.0f} m")

# %%
# The same mean force and amplitude, uniform and as a wave with more and more axial damping, the far end held.
numbers = (0.5 * unit, 0.15 * unit, hertz)
cases = {
    "uniform": fr.AxialLoad.hertz(*numbers),
    "wave": fr.AxialWave.hertz(*numbers, axial_damping=0.5),
    "damped wave": fr.AxialWave.hertz(*numbers, axial_damping=6.0),
}
verdicts = {}
for length in (60.0, 600.0):
    for name, load in cases.items():
        verdict = verdicts[name, length] = string.replace(length=length).stability(load)
        print(f"{length:g} m, {name}: growth {verdict.growth_rate:.4f} 1/s, {verdict}")

# %%
# What grows on 600 m, and beneath it the size of the vibration that drives it.
figure, panels = plt.subplots(3, 1, figsize=(8.0, 6.5), sharex=True, layout="constrained", height_ratios=[2, 2, 1.3])
for axes, name in zip(panels, ("wave", "damped wave"), strict=False):
    verdict = verdicts[name, 600.0]
    verdict.plot(axes)
    axes.set_title(f"{name}: growth {verdict.growth_rate:.3g} 1/s", fontsize="small")
    axes.set_xlabel("")
panels[0].get_legend().remove()  # that of the next panel says the same
places = np.linspace(0.0, 600.0, 601)
styles = {"uniform": ("-", palette.NEUTRAL), "wave": ("-", "black"), "damped wave": ("--", "black")}
for name, (line, shade) in styles.items():
    load = cases[name]
    size = 0.15 * np.abs(load.profile(string.wave_speed, 600.0, places, load.frequency))
    panels[2].plot(places, size, linestyle=line, color=shade, label=name)
panels[2].set(xlabel="position from the driven end $s$ / m", ylabel=r"size / $F_\mathrm{cr}$", ylim=(0.0, None))
panels[2].legend(fontsize="x-small", loc="lower left", ncols=3)
plt.show()
