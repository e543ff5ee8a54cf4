"""
A rod that is not straight
==========================

A stable rod stays at rest only if it is straight.  The natural shape of a real one is a constant force on its modes,
and its motion has the period of the axial force: it grows without bound towards tongues of even order, and does not
notice the principal ones.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

rod = fr.Rod.nitinol().replace(damping_rate=0.3, natural_shape={6: "0.1mm"})
unit = rod.critical_force
load = fr.AxialLoad(mean=0.3 * unit, amplitude=0.3 * unit, frequency=30.0)

# %%
# The largest deflection over the frequency.  The frequency of free motion of mode 6 is where the tongue of second order
# begins; the motion there is large long before the rod is unstable.
frequency = np.linspace(12.0, 120.0, 900)
largest = np.full(frequency.size, np.nan)
for i, w in enumerate(frequency):
    try:
        largest[i] = 1e3 * rod.response(load.varied("frequency", w)).largest
    except ValueError:  # unstable
        continue
print(rod.response(load))

# %%
# Unstable frequencies, of any mode, are shaded.  The motion is large next to the band in which mode 6 grows with the
# period of the force, at 57 rad/s, and at fractions of it; at the edges of all other bands nothing warns of them.
ranges = rod.ranges("frequency", load, (12.0, 120.0))
figure, axes = plt.subplots(figsize=(7.0, 4.4), layout="constrained")
for band in ranges.unstable:
    axes.axvspan(band.low, band.high, color=palette.UNSTABLE, linewidth=0.0)
axes.semilogy(frequency, largest, color="black", linewidth=1.0)
axes.set_xlabel(r"frequency $\omega$ / (rad/s)")
axes.set_ylabel("largest deflection / mm")
axes.set_title("Deflection of a rod bent by 0.1 mm in mode 6; shaded: unstable", fontsize="medium")
