"""
A clamped strip under a pulsating axial force
=============================================

A steel strip, clamped at both ends, under an axial force that pulsates.  Because the force couples modes 1 and 3, they
also grow together, at the sum of their frequencies: a combination resonance, after Bolotin and Iwatsubo.
"""

from functools import cache

import matplotlib.pyplot as plt
import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq

import floquetrod as fr
from floquetrod.plotting import palette

# %%
# Galerkin's method with the modes of the strip without a force, the first four of them.  Lengths are in units of the
# strip's, forces of EI / L^2; time is in milliseconds.
length, thickness, wave_speed = 0.30, 1.0e-3, 5100.0  # m, m, m/s
unit = 1e3 * length**2 / (wave_speed * thickness / np.sqrt(12.0))  # ms, so that frequencies are b^2 / unit


@cache
def galerkin(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the bending stiffness of n modes, and what one unit of force takes from it."""
    middle = (np.arange(n) + 1.5) * np.pi
    b = np.array([brentq(lambda x: np.cos(x) - 1.0 / np.cosh(x), x - 0.3, x + 0.3) for x in middle])
    s = (np.cosh(b) - np.cos(b)) / (np.sinh(b) - np.sin(b))
    geometric = np.diag(s * b * (s * b - 2.0))
    for i in range(n):
        for j in range(i + 2, n, 2):  # modes of one symmetry; no others are coupled
            coupling = -8.0 * (b[i] * b[j]) ** 2 * (s[j] * b[j] - s[i] * b[i]) / (b[j] ** 4 - b[i] ** 4)
            geometric[i, j] = geometric[j, i] = coupling
    return np.diag(b**4), geometric


def strip(hertz: float, mean: float = 10.0, amplitude: float = 8.0, modes: int = 4) -> fr.HillSystem:
    """Return the strip under mean + amplitude cos(2 pi hertz t); it buckles at 39.5 of these units."""
    bending, geometric = galerkin(modes)
    stiffness = (bending - mean * geometric) / unit**2
    return fr.HillSystem(stiffness, cosines=[-amplitude * geometric / unit**2], period=1e3 / hertz)


for w in (40.0, 80.0, 136.25):  # in units of the strip's; growth is then, too
    verdict = fr.stability(strip(1e3 * w / (2.0 * np.pi * unit)))
    print(f"w = {w:g}: growth {verdict.growth_rate * unit:.9g}, {verdict}")

# %%
# Are four modes enough?  More of them make the strip softer: its buckling force comes down to 4 pi^2, never below, and
# the growth rate settles.
for n in (4, 8, 16, 32):
    bending, geometric = galerkin(n)
    buckling = 1.0 / eigh(geometric, bending, eigvals_only=True)[-1]
    growth = fr.stability(strip(1e3 * 136.25 / (2.0 * np.pi * unit), modes=n)).growth_rate * unit
    print(f"{n:2} modes: buckles at 4 pi^2 + {buckling - 4.0 * np.pi**2:.1e}, growth at w = 136.25 {growth:.6f}")

# %%
# Where first order expects resonances:
tongues = fr.systems.first_order_tongues(strip(1.0))
for tongue in tongues:
    print(f"{1e3 * tongue.frequency / (2.0 * np.pi):6.1f} Hz", tongue)

# %%
# Growth over the frequency, 0.1 Hz apart.  First order knows the large peaks; resonances of second order lie near half
# the frequencies of those, and are much narrower.
hertz = np.linspace(60.0, 400.0, 3401)
growth = 1e3 * fr.systems.growth_rate(fr.systems.stack([strip(f) for f in hertz]))  # 1/s

figure, axes = plt.subplots(figsize=(8.0, 4.2), layout="constrained")
axes.fill_between(hertz, 0.0, growth, color=palette.UNSTABLE)
axes.plot(hertz, growth, color="black", linewidth=0.9)
for peak in np.flatnonzero((growth[1:-1] > growth[:-2]) & (growth[1:-1] > growth[2:])) + 1:
    resonance = fr.stability(strip(hertz[peak])).resonances[0]
    name = f"{resonance.kind} {' + '.join(map(str, resonance.modes))}"
    name += f", order {resonance.order}" if resonance.order > 1 else ""
    print(f"{hertz[peak]:.1f} Hz: {name}, {growth[peak]:.3g} 1/s")
    place = (hertz[peak], growth[peak])
    axes.annotate(name, place, (0, 4), textcoords="offset points", ha="center", rotation=90, fontsize="small")
axes.set(xlabel="forcing frequency / Hz", ylabel="growth rate / (1/s)", xlim=(hertz[0], hertz[-1]))
axes.set_ylim(0.0, 1.3 * growth.max())
axes.set_title(
    "force $10 + 8\\,\\cos wt$ in units of $EI/L^2$; orange: unstable, below the name of the resonance",
    fontsize="small",
)
plt.show()
