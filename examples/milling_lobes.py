"""
Chatter of a milling cutter
===========================

The stability lobes of a slotting cutter with two teeth: the depth of cut that is stable at each spindle speed.
"""

import matplotlib.pyplot as plt

import floquetrod as fr

mode = fr.ToolMode("922Hz", damping_ratio=0.011, mass="39.93g")
slot = fr.Milling(x=[mode], teeth=2, tangential="600MPa", radial="200MPa")

lobes = slot.lobes(speed=("9000rpm", "25000rpm", 100), depth=("0mm", "3mm", 30))
print(lobes.report())

axes = lobes.plot()
axes.set_title("slotting with two teeth: where it chatters", fontsize="medium")
plt.show()
