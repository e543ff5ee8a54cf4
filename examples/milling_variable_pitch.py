"""
Variable pitch against chatter
==============================

Stability lobes of a cutter with four teeth, evenly spaced and with pitches of 70 and 110 degrees, side by side.
"""

import matplotlib.pyplot as plt

import floquetrod as fr

mode = fr.ToolMode("922Hz", damping_ratio=0.011, mass="39.93g")
cutter = {"x": [mode], "teeth": 4, "tangential": "600MPa", "radial": "200MPa", "immersion": 0.3, "direction": "down"}
mills = {
    "equal pitch": fr.Milling(**cutter),
    "pitch 70, 110, 70, 110 deg": fr.Milling(**cutter, pitch=["70deg", "110deg", "70deg", "110deg"]),
}

figure, axes = plt.subplots(1, 2, figsize=(11, 4.5), sharey=True, layout="constrained")
for ax, (title, mill) in zip(axes, mills.items(), strict=True):
    lobes = mill.lobes(speed=("4000rpm", "12000rpm", 60), depth=("0mm", "4mm", 24))
    print(lobes.report())
    lobes.plot(ax)
    ax.set_title(title, fontsize="medium")
plt.show()
