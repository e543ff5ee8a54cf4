"""
A guidewire in a catheter
=========================

A wire in a catheter filled with saline is clamped where it is driven, and vibrated along its axis.  At which
frequencies does it begin to snake across the catheter, and how much does the support of its tip matter?
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

# %%
# A wire of nitinol of 0.014 in, in a catheter of 0.040 in; between them a narrow gap of saline, in which more mass
# moves with the wire than it displaces: the coefficient of a concentric annulus, (D_h^2 + D^2) / (D_h^2 - D^2).
wire_diameter, bore = 0.36e-3, 1.0e-3  # m
wire = fr.Rod(
    68e9,
    6500.0,
    diameter=wire_diameter,
    length=0.30,
    channel_diameter=bore,
    fluid_outside=1005.0,
    added_mass_coefficient=(bore**2 + wire_diameter**2) / (bore**2 - wire_diameter**2),
    ends="clamped-guided",
)
unit = wire.critical_force
mean, amplitude = 0.3 * unit, 0.3 * unit
print(f"critical force {1e3 * unit:.1f} mN, half wave {1e3 * wire.critical_half_wave:.0f} mm")

# %%
# A tip that is held straight counts as guided, a loose one as free; a free tip also buckles at half the force.  Saline
# damps: a few rates in 1/s, as the true one is hard to know.
hertz = np.linspace(20.0, 120.0, 101)
rates = {2.0: "-", 5.0: "--", 15.0: ":"}
figure, panels = plt.subplots(2, 1, figsize=(8.0, 5.0), sharex=True, layout="constrained")
for axes, ends in zip(panels, ("clamped-guided", "clamped-free"), strict=True):
    for rate, line in rates.items():
        damped = wire.replace(ends=ends, damping_rate=rate)
        growth = damped.growth_rate(mean=mean, amplitude=amplitude, frequency=2.0 * np.pi * hertz)
        axes.plot(hertz, growth, color="black", linestyle=line, label=f"damping {rate:g} 1/s")
        if rate == min(rates):
            axes.fill_between(hertz, 0.0, growth, color=palette.UNSTABLE, linewidth=0.0)
    verdict = wire.replace(ends=ends).stability(fr.AxialLoad.hertz(mean, amplitude, hertz[growth.argmax()]))
    print(f"{ends}, undamped at {hertz[growth.argmax()]:g} Hz: {verdict}")
    print(f"    stable at any damping rate above {verdict.damping_to_stabilise:.3g} 1/s")
    axes.set_title(ends, fontsize="small")
    axes.set(ylabel="growth rate / (1/s)", ylim=(0.0, None), xlim=(hertz[0], hertz[-1]))
panels[0].legend(fontsize="small", loc="upper right")
panels[1].set_xlabel("forcing frequency / Hz")
plt.show()
