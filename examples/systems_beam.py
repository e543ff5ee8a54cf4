"""
A clamped strip under a pulsating axial force
=============================================

A steel strip, clamped at both ends, under an axial force that pulsates.  Because the force couples modes 1 and 3, they
also grow together, at the sum of their frequencies.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import floquetrod as fr
from floquetrod.plotting import palette

# %%
# Galerkin's method with the first four modes of the strip without a force.  Lengths are in units of the strip's, forces
# of EI / L^2; time is in milliseconds.
length, thickness, wave_speed = 0.30, 1.0e-3, 5100.0  # m, m, m/s
unit = 1e3 * length**2 / (wave_speed * thickness / np.sqrt(12.0))  # ms, so that frequencies are b^2 / unit
b = np.array([brentq(lambda x: np.cos(x) - 1.0 / np.cosh(x), x - 0.3, x + 0.3) for x in (np.arange(4) + 1.5) * np.pi])
s = (np.cosh(b) - np.cos(b)) / (np.sinh(b) - np.sin(b))
geometric = np.diag(s * b * (s * b - 2.0))
for i, j in ((0, 2), (1, 3)):  # modes of one symmetry; no others are coupled
    geometric[i, j] = geometric[j, i] = 8.0 * (b[i] * b[j]) ** 2 * (s[j] * b[j] - s[i] * b[i]) / (b[j] ** 4 - b[i] ** 4)


def strip(hertz: float, mean: float = 10.0, amplitude: float = 8.0) -> fr.HillSystem:
    """Return the strip under mean + amplitude cos(2 pi hertz t); it buckles at 39.5 of these units."""
    stiffness = (np.diag(b**4) - mean * geometric) / unit**2
    return fr.HillSystem(stiffness, cosines=[-amplitude * geometric / unit**2], period=1e3 / hertz)


tongues = fr.systems.first_order_tongues(strip(1.0))
for tongue in tongues:
    print(f"{1e3 * tongue.frequency / (2.0 * np.pi):6.1f} Hz", tongue)

# %%
# Growth over the frequency.  First order knows the large peaks; resonances of second order lie at half their frequency.
hertz = np.concatenate([np.linspace(60.0, 560.0, 201), [1e3 * t.frequency / (2.0 * np.pi) for t in tongues]])
hertz = np.sort(hertz[hertz < 560.0])
verdicts = [fr.stability(strip(f)) for f in hertz]
growth = 1e3 * np.array([verdict.growth_rate for verdict in verdicts])
undecided = sum(verdict.status == "undecided" for verdict in verdicts)
print(f"{np.count_nonzero(growth > 0.0)} of {hertz.size} frequencies unstable, {undecided} undecided")

figure, axes = plt.subplots(figsize=(8.0, 4.2), layout="constrained")
axes.fill_between(hertz, 0.0, growth, color=palette.UNSTABLE)
axes.plot(hertz, growth, color="black", linewidth=0.9)
peaks = {}
for f, rate, verdict in zip(hertz, growth, verdicts, strict=True):
    if verdict.resonances:
        kind, modes, order, _ = verdict.resonances[0]
        name = f"{kind} {' + '.join(map(str, modes))}" + (f", order {order}" if order > 1 else "")
        peaks[name] = max(peaks.get(name, (0.0, 0.0)), (rate, f))
for name, (rate, f) in peaks.items():
    axes.annotate(name, (f, rate), (0, 4), textcoords="offset points", ha="center", rotation=90, fontsize="small")
axes.set(xlabel="forcing frequency / Hz", ylabel="growth rate / (1/s)", xlim=(hertz[0], hertz[-1]))
axes.set_ylim(0.0, 1.3 * growth.max())
axes.set_title(
    "force $10 + 8\\,\\cos wt$ in units of $EI/L^2$; orange: unstable, below the name of the resonance",
    fontsize="small",
)
plt.show()
