"""
A noisy tongue
==============

White noise in addition to the periodic force widens a resonance tongue, and lowers its tip: the stable forcing
decreases, and above some intensity there is none.  The verdicts are in mean square.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette


def system(omega: float, epsilon: float) -> fr.HillSystem:
    """Return an oscillator of frequency 1, damped, with a stiffness that varies."""
    return fr.HillSystem([[1.0]], [[[epsilon]]], damping=[[0.1]], period=2.0 * np.pi / omega)


noises = {0.0: "-", 0.2: "--", 0.35: "-.", 0.43: ":"}
critical = fr.critical_noise(system(2.0, 0.0), [([[1.0]], 1.0)]).factor
print(f"without forcing, the system is stable up to a noise intensity of {critical:.9f}, the root of 4 c w^2 = 0.2")

# %%
# Left: the tongue at twice the frequency, for four intensities.  Right: the largest intensity that is stable at
# resonance and beside it, over the forcing.
figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.2), layout="constrained")
for noise, line in noises.items():

    def family(omega: float, epsilon: float, noise: float = noise) -> fr.results.SecondMoments:
        """Return its second moments."""
        return fr.second_moments(system(omega, epsilon), [([[1.0]], noise)])

    bands = fr.chart(family, over={"omega": (1.6, 2.4, 11), "epsilon": (0.0, 0.6, 7)}).find_bands(accuracy=4e-3)
    for band in bands.bands:
        left.plot([*band.x, band.x[0]], [*band.y, band.y[0]], line, color="black", label=f"$s = {noise:g}$")
left.set(xlabel=r"frequency $\omega$", ylabel=r"forcing $\varepsilon$", xlim=(1.6, 2.4), ylim=(0.0, 0.6))
left.legend(loc="upper center")

for omega, line in ((2.0, "-"), (2.1, "--"), (2.2, "-.")):
    stable = [e for e in np.linspace(0.0, 0.6, 11) if fr.stability(system(omega, e)).decay_rate > 0.0]
    largest = [fr.critical_noise(system(omega, e), [([[1.0]], 1.0)]).factor for e in stable]
    right.plot(stable, largest, line, color="black", label=rf"$\omega = {omega:g}$")
right.plot(0.0, critical, linestyle="none", **palette.POINT)
right.set(xlabel=r"forcing $\varepsilon$", ylabel="largest intensity $s$", ylim=(0.0, None))
right.legend()
plt.show()
