"""
A parametric amplifier and its idler
====================================

An oscillator whose stiffness is pumped near twice its frequency amplifies a signal, and answers at the idler's
frequency too.  Towards the threshold the peak grows without bound and becomes as narrow as free motion decays slowly.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr

damping = 0.01


def amplifier(pump: float) -> fr.HillSystem:
    """Return x'' + 2 c x' + (1 + h sin 2t) x."""
    return fr.HillSystem([[1.0]], sines=[[[pump]]], damping=[[2.0 * damping]], period=np.pi)


# %%
# Left: the signal, wave 0, and the idler, wave -1, over the frequency of the signal.  Right: the gain of the force that
# the pump drives most, over the pump, with the limit of Rugar and Gruetter, 1 / (1 - h Q / 2).
figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.2), layout="constrained")
for pump, line in ((0.02, ":"), (0.035, "--"), (0.039, "-")):
    spectrum = fr.gain(amplifier(pump), frequency=(0.95, 1.05))
    left.plot(spectrum.frequency, spectrum.of(0), line, color="black", label=f"signal, $h = {pump:g}$")
    left.plot(spectrum.frequency, spectrum.of(-1), line, color="0.55", label=f"idler, $h = {pump:g}$")
    print(f"h = {pump}: peak {spectrum.peak[1]:.6g}, width {spectrum.width:.4g}")
left.set(xlabel=r"frequency of the signal $\omega$", ylabel="amplitude per amplitude of the force", yscale="log")
left.legend(fontsize="small")

pumps = np.linspace(0.0, 0.0396, 40)
gains = []
for pump in pumps:
    waves = fr.response(amplifier(pump), 1.0, frequency=1.0).harmonics
    gains.append(2.0 * damping * (abs(waves[0][0]) + abs(waves[-1][0])))
right.plot(pumps, gains, color="black", label="all harmonics")
right.plot(pumps, 1.0 / (1.0 - pumps / (4.0 * damping)), "o", color="0.55", markersize=3, label=r"$1 / (1 - h Q / 2)$")
right.axvline(4.0 * damping, color="black", linestyle=":", linewidth=0.8, label="threshold $h = 4 c$")
right.set(xlabel="pump $h$", ylabel="gain of the force driven most", yscale="log")
right.legend(fontsize="small")
plt.show()
