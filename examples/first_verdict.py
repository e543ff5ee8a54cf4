"""
A first verdict
===============

Verdicts on one equation, and on one rod under five loads.  Each states its method and its error.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

equation = fr.Mathieu(alpha=0.5, beta=-0.25)
print(fr.stability(equation))
print(fr.certify(equation))

# %%
# A rod is stable when all its modes are.  Here the mean force rises while the vibration stays as it is.
rod = fr.Rod.nitinol()
amplitude = 0.2 * rod.critical_force
verdicts = {}
for share in (0.05, 0.20, 0.34, 0.52, 0.63):
    verdicts[share] = rod.stability(fr.AxialLoad(share * rod.critical_force, amplitude, frequency=150.0))
    print(f"mean force {share:.2f} F_cr:", verdicts[share])

# %%
# Why stability comes and goes: each mode is a point on the chart of Mathieu's equation, and a larger mean force moves
# all points up. Mode 7 has passed through the first tongue when mode 8 enters it, and so on.
axes = fr.mathieu.chart((0.0, 0.2, 100), (-0.8, 0.1, 100)).plot()
for (share, verdict), marker in zip(verdicts.items(), "os^Dv", strict=True):
    alpha, beta = np.array([(mode.alpha, mode.beta) for mode in verdict.mode_equations]).T
    style = palette.POINT | {"marker": marker, "linestyle": "none", "markersize": 5}
    axes.plot(alpha, beta, **style, label=f"{share:.2f} $F_\\mathrm{{cr}}$, {verdict.status}")
    growing = [mode - 1 for mode in verdict.unstable_modes]
    axes.plot(alpha[growing], beta[growing], **style | {"markerfacecolor": "black"})
axes.set(xlim=(0.0, 0.2), ylim=(-0.8, 0.1))
axes.set_title("modes under five mean forces; orange: unstable, filled: the mode grows", fontsize="medium")
axes.legend(fontsize="small", loc="lower right")
plt.show()
