"""
Which kick buckles a rod held by friction?
==========================================

Dry friction holds a rod that would buckle without it, up to a critical kick.  This kick depends on the load and is
largest between the tongues of two modes.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

import floquetrod as fr
from floquetrod.plotting import palette

rod, mu, omega = fr.Rod.nitinol(), 0.1, 150.0
amplitude = 0.7 * rod.critical_force

# %%
# One load.  Without friction four modes grow; a kick of 50 mm/s destabilises two of them.
load = fr.AxialLoad(0.825 * rod.critical_force, amplitude, omega)
verdict = rod.stability(load, friction=mu, kick=0.05)
print(verdict)
for mode, kick in verdict.critical_kicks.items():
    print(f"mode {mode:2d} is destabilised by {1e3 * kick:.1f} mm/s")
smallest, first, none_up_to = verdict.critical_kick
print(f"the smallest kick found to buckle the rod is {1e3 * smallest:.2f} mm/s, into mode {first}")
print(f"proved: none up to {1e3 * none_up_to:.2f} mm/s does")

# %%
# The same over the mean force, at this amplitude and at a smaller one.  Modes that grow by less than 0.01 per second
# are left out: no kick of interest destabilises them.
share = np.linspace(0.0, 1.0, 101)
_, panels = plt.subplots(2, 1, figsize=(8.0, 5.6), sharex=True, layout="constrained")
for axes, part in zip(panels, (0.7, 0.3), strict=True):
    kick, mode, _ = rod.critical_kick(
        mean=share * rod.critical_force,
        amplitude=part * rod.critical_force,
        frequency=omega,
        friction=mu,
        growth_tolerance=0.01,
    )
    often, never = 100.0 * (kick < 0.05).mean(), 100.0 * np.isinf(kick).mean()
    print(
        f"amplitude {part} F_cr: 50 mm/s buckle it at {often:.0f} % of the mean forces, no kick does at {never:.0f} %"
    )
    for number, marker in zip(np.unique(mode[mode > 0]), "os^Dv<>pPX*", strict=False):
        here = mode == number
        axes.plot(share[here], 1e3 * kick[here], marker, color="black", markersize=3)
        lowest = np.flatnonzero(here)[np.argmin(kick[here])]
        offset = {"xytext": (0, -12), "textcoords": "offset points", "ha": "center", "fontsize": "small"}
        axes.annotate(f"{number}", (share[lowest], 1e3 * kick[lowest]), **offset)
    for calm in share[np.isinf(kick)]:
        axes.axvspan(calm - 0.005, calm + 0.005, **palette.NO_KICK)
    axes.axhline(50.0, color="black", linestyle="--", linewidth=0.9)
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 150.0), ylabel="critical kick / (mm/s)")
    axes.set_title(f"amplitude {part:g} $F_\\mathrm{{cr}}$, {omega:g} rad/s, friction {mu:g}", fontsize="small")
panels[1].set_xlabel(r"mean force $F_\mathrm{ave} / F_\mathrm{cr}$")
marks = [Line2D([], [], color="black", linestyle="--", linewidth=0.9), Patch(**palette.NO_KICK)]
panels[0].legend(
    marks, ["50 mm/s", "no kick buckles it"], title="numbers: modes", ncols=2, fontsize="small", title_fontsize="small"
)
plt.show()
