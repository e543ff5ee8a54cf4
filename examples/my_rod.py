"""Your own rod, from a TOML file: which frequencies of a vibration tool keep it straight?"""

import math
from pathlib import Path

import floquetrod as fr

rod = fr.Rod.from_toml(Path(__file__).with_name("rod.toml"))
mean, amplitude = 0.3 * rod.critical_force, 0.15 * rod.critical_force
print(f"critical force {rod.critical_force:.3g} N, critical mode {rod.critical_mode:.3g}")

# Complete: no window is missed, and nothing inside one grows by more than the tolerance.
hertz = 2.0 * math.pi
windows = rod.stable_frequencies(mean, amplitude, between=(5.0 * hertz, 30.0 * hertz), growth_tolerance=0.01)
for window in windows:
    print(f"safe from {window.low / hertz:7.3f} to {window.high / hertz:7.3f} Hz")

widest = max(windows, key=lambda window: window.high - window.low)
choice = 0.5 * (widest.low + widest.high)
verdict = rod.stability(fr.AxialLoad(mean, amplitude, choice), growth_tolerance=0.01)
print(f"choose {choice / hertz:.2f} Hz: {verdict}")
