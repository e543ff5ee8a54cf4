"""
A measured force record
=======================

A drive never pushes with a pure sine.  A force record, some periods of it with noise, becomes a Fourier series with
errors; under it each mode of the rod has tongues that the harmonics drive directly.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

rod = fr.Rod.nitinol()
omega, periods, rate = 150.0, 12.4, 3000.0
rng = np.random.default_rng(7)

# %%
# The record, which is synthetic here, does not cover a whole number of periods: a mean, a fundamental, a second
# harmonic nearly as strong, a weak third, and noise.  From a file it would be ``fr.ForceRecord.from_csv("force.csv")``.
t = np.arange(0.0, periods * 2.0 * np.pi / omega, 1.0 / rate)
force = rod.critical_force * (
    0.36
    + 0.08 * np.sin(omega * t)
    + 0.07 * np.cos(2.0 * omega * t + 0.4)
    + 0.01 * np.sin(3.0 * omega * t)
    + 0.02 * rng.standard_normal(t.size)
)

# %%
# The period is found, and the harmonics are kept that noise alone is very unlikely to produce.
record = fr.ForceRecord(t, force)
print(record)
print(f"frequency {record.frequency:.3f} +- {record.frequency_error:.3f} rad/s")
for k in record.harmonic_numbers:
    print(f"harmonic {k}: {abs(record.harmonics[k - 1]):.4f} +- {record.harmonic_errors[k - 1]:.4f} N")

# %%
# It is a load like any other. Its fundamental alone would have been called safe.
load = fr.AxialLoad(record.mean, record.amplitude, record.frequency, waveform=record.waveform)
verdict = rod.stability(load)
alone = fr.AxialLoad(record.mean, abs(record.harmonics[0]), record.frequency)
print("as recorded:", verdict)
print("fundamental alone:", rod.stability(alone))

# %%
# The growth over the frequency at which the same force is repeated.
frequency = np.linspace(142.0, 162.0, 61)
full = rod.growth_rate(load, frequency=frequency)
pure = rod.growth_rate(mean=alone.mean, amplitude=alone.amplitude, frequency=frequency)
_, (*upper, below) = plt.subplots(3, 1, figsize=(7.5, 8.0), layout="constrained")
record.plot(upper)
below.fill_between(frequency, 0.0, full, color=palette.UNSTABLE, linewidth=0.0)
below.plot(frequency, full, color="black", linewidth=1.0, label="all harmonics")
below.plot(frequency, pure, color="black", linestyle=":", label="fundamental alone")
below.axvline(record.frequency, color="black", linestyle="--", linewidth=0.9)
below.set(xlabel=r"frequency $\omega$ / (rad/s)", ylabel="growth rate / (1/s)", xlim=(142.0, 162.0), ylim=(0.0, None))
below.legend(fontsize="small", loc="upper left")
plt.show()
