"""
A rotor blade that flaps
========================

In forward flight the air resists flapping more on the advancing side than on the retreating one.  Beyond some advance
ratio the blade's flapping grows.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette


def blade(m: float, lock: float = 12.0, p: float = 1.0) -> fr.PeriodicSystem:
    """Return the system of flapping angle and rate over the azimuth, without tip loss and reversed flow.

    b'' + g/8 (1 + 4/3 m sin t) b' + (p^2 + g/8 (4/3 m cos t + m^2 sin 2t)) b = 0, with the Lock number g.
    """
    k = lock / 8.0
    mean = [[0.0, 1.0], [-p * p, -k]]
    cosines = [[[0.0, 0.0], [-4.0 / 3.0 * k * m, 0.0]]]
    sines = [[[0.0, 0.0], [0.0, -4.0 / 3.0 * k * m]], [[0.0, 0.0], [-k * m * m, 0.0]]]
    return fr.PeriodicSystem(mean, cosines, sines, period=2.0 * np.pi)


for m in (1.0, 1.5):
    print(f"advance ratio {m}:", fr.stability(blade(m)))

# %%
# The two characteristic exponents over the advance ratio.  Where their frequency is held at 0 or 1/2 per turn, one of
# them loses damping and the other gains it; their sum is always -g/8.
ratio = np.linspace(0.0, 1.8, 73)
exponents = np.array([fr.stability(blade(m)).exponents for m in ratio])
print(f"sum of the exponents: {exponents.sum(axis=1).real.min():.9f} to {exponents.sum(axis=1).real.max():.9f}")

figure, (damping, frequency) = plt.subplots(2, 1, figsize=(8.0, 5.6), sharex=True, layout="constrained")
fastest = exponents[:, 0].real
damping.fill_between(ratio, 0.0, fastest, where=fastest > 0.0, color=palette.UNSTABLE, interpolate=True)
damping.plot(ratio, exponents[:, 0].real, color="black")
damping.plot(ratio, exponents[:, 1].real, color="black", linestyle="--")
damping.axhline(0.0, color="black", linewidth=0.5)
damping.set(ylabel="real parts, per radian", xlim=(ratio[0], ratio[-1]))
damping.set_title("flapping exponents, Lock number 12; orange: unstable", fontsize="small")
frequency.plot(ratio, np.abs(exponents[:, 0].imag), ".", color="black", markersize=4)
frequency.set(xlabel="advance ratio $m$", ylabel="frequency, per turn, modulo 1", ylim=(-0.05, 0.55))
plt.show()
first = np.interp(0.0, fastest[fastest > -0.3], ratio[fastest > -0.3])
print(f"unstable from an advance ratio of {first:.2f} on")
