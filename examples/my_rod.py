"""Your own rod, from a TOML file: which frequencies of a vibration tool keep it straight?"""

from pathlib import Path

import numpy as np

import floquetrod as fr

rod = fr.Rod.from_toml(Path(__file__).with_name("rod.toml"))
mean, amplitude = 0.3 * rod.critical_force, 0.15 * rod.critical_force
frequencies = np.arange(5.0, 31.0, 1.0)  # Hz
stable = rod.is_stable(mean, amplitude, 2.0 * np.pi * frequencies)
print(f"critical force {rod.critical_force:.3g} N, critical mode {rod.critical_mode:.3g}")
print("stable at", ", ".join(f"{f:.0f}" for f in frequencies[stable]), "Hz")
print("unstable at", ", ".join(f"{f:.0f}" for f in frequencies[~stable]), "Hz")
