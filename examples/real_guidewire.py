"""
A guidewire in a catheter
=========================

A wire in a catheter filled with saline is clamped where it is driven, and vibrated along its axis.  At which frequencies
does it begin to snake across the catheter, and what does the hold of its tip matter?
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

# %%
# A wire of nitinol of 0.014 in in a catheter of 0.040 in; between them a narrow gap of saline, in which much more mass
# moves with the wire than it displaces: the coefficient of a concentric annulus, (D_h^2 + D^2) / (D_h^2 - D^2).
wire_diameter, bore = 0.36e-3, 1.0e-3  # m
guided = fr.Rod(
    68e9,
    6500.0,
    diameter=wire_diameter,
    length=0.30,
    channel_diameter=bore,
    fluid_outside=1005.0,
    added_mass_coefficient=(bore**2 + wire_diameter**2) / (bore**2 - wire_diameter**2),
    damping_rate=5.0,
    ends="clamped-guided",
)
unit = guided.critical_force
print(f"critical force {1e3 * unit:.1f} mN, half wave {1e3 * guided.critical_half_wave:.0f} mm")

# %%
# A tip that is held straight counts as guided, a loose one as free; a free tip also buckles at half the force.
hertz = 2.0 * np.pi
figure, panels = plt.subplots(1, 2, figsize=(9.0, 3.8), sharey=True, layout="constrained")
for axes, ends in zip(panels, ("clamped-guided", "clamped-free"), strict=True):
    wire = guided.replace(ends=ends)
    chart = fr.stability_map(
        wire,
        mean=(0.0, 0.45 * unit, 30),
        amplitude=0.3 * unit,
        frequency=(20.0 * hertz, 120.0 * hertz, 50),
        growth=True,
        growth_tolerance=0.1,
    )
    chart.in_units(frequency="Hz", mean="mN", amplitude="mN").plot(axes)
    axes.set_title(f"{ends}, amplitude {0.3e3 * unit:.1f} mN", fontsize="small")
    verdict = wire.stability(fr.AxialLoad.hertz(0.3 * unit, 0.3 * unit, 60.0))
    print(f"{ends}: {verdict}; stable at any damping rate above {verdict.damping_to_stabilise:.3g} 1/s")
plt.show()
