"""
A measured force record
=======================

A drive never pushes with a pure sine.  Its recorded force, some periods of it with noise, becomes a Fourier series;
each mode of the rod then obeys Hill's equation instead of Mathieu's, and the harmonics have tongues of their own.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

rod = fr.Rod.nitinol()
omega, periods, per_period = 150.0, 40, 256
rng = np.random.default_rng(7)

# %%
# The record, made up here: a mean, a fundamental, a second harmonic that is nearly as strong, a weak third, and noise.
t = np.arange(periods * per_period) * (2.0 * np.pi / omega / per_period)
record = rod.critical_force * (
    0.36
    + 0.08 * np.sin(omega * t)
    + 0.07 * np.cos(2.0 * omega * t + 0.4)
    + 0.01 * np.sin(3.0 * omega * t)
    + 0.02 * rng.standard_normal(t.size)
)

# %%
# Over a whole number of periods the discrete Fourier transform gives the coefficients; harmonics below the noise are
# dropped: those less than five times what noise alone makes of a coefficient (its median, which is 0.83 of its rms).
spectrum = np.fft.rfft(record)[::periods] * 2.0 / record.size
noise = np.median(np.abs(np.fft.rfft(record))) * 2.0 / record.size / 0.83  # median to rms
harmonics = spectrum[1 : 1 + np.flatnonzero(np.abs(spectrum[1:9]) > 5.0 * noise).max() + 1]
mean = 0.5 * spectrum[0].real
print("mean force", mean, "N; amplitudes", np.abs(harmonics), "N; noise", noise, "N")


# %%
# Force to equation: a unit of force adds w_m^2 / (rho A omega^2) to the coefficient of mode m, Eq. (4).
def mode_equation(mode: int, harmonics: np.ndarray) -> fr.Hill:
    """Return Hill's equation of a mode under the recorded force."""
    (unit,) = rod.modal_system(fr.AxialLoad(mean, 1.0, omega), [mode]).equations
    z = unit.alpha * harmonics
    return fr.Hill(unit.beta, cosines=tuple(z.real), sines=tuple(-z.imag))


modes = range(1, 16)
full = {mode: fr.stability(mode_equation(mode, harmonics)) for mode in modes}
pure = {mode: fr.stability(mode_equation(mode, harmonics[:1])) for mode in modes}
for mode in modes:
    if "unstable" in (full[mode].status, pure[mode].status):
        print(
            f"mode {mode}: grows at {omega * full[mode].growth_rate:.3f} 1/s, "
            f"at {omega * pure[mode].growth_rate:.3f} 1/s with the fundamental alone"
        )

# %%
# The mode that grows does so in its second tongue, which the second harmonic drives directly: with the fundamental
# alone one would have called this load safe.
_, (above, below) = plt.subplots(2, 1, figsize=(7.0, 5.5), layout="constrained")
shown = slice(0, 3 * per_period)
series = mean + sum((z * np.exp(1j * k * omega * t)).real for k, z in enumerate(harmonics, start=1))
above.plot(1e3 * t[shown], record[shown], color=palette.NEUTRAL, linewidth=0.6, label="record")
above.plot(1e3 * t[shown], series[shown], color="black", linewidth=1.2, label=f"{len(harmonics)} harmonics")
above.set(xlabel="time $t$ / ms", ylabel="force $F$ / N")
above.legend(fontsize="small", loc="upper right")
for rates, name, shift, shade in (
    (full, "all harmonics", -0.2, "black"),
    (pure, "fundamental alone", 0.2, palette.NEUTRAL),
):
    below.bar([m + shift for m in modes], [omega * r.growth_rate for r in rates.values()], 0.4, color=shade, label=name)
below.set(xlabel="mode $m$", ylabel="growth rate / 1/s", xticks=list(modes))
below.legend(fontsize="small")
plt.show()
