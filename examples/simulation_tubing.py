"""
Sixty metres of tubing, simulated
=================================

A vibration tool sends its force down a string of coiled tubing full of water, in an inclined hole full of water.  In
theory the modes of such a string are coupled.  This example simulates the whole string and compares it with theory.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

string = fr.Rod.catalogue(
    "2.00x0.156",
    bore="4.778in",
    length=60.0,
    fluid_inside=1000.0,
    fluid_outside=1000.0,
    inclination=math.radians(60),
    damping_rate=0.2,
)
unit = string.critical_force
load = fr.AxialWave.hertz(0.5 * unit, 0.3 * unit, 4.0, axial_damping=0.5)  # the lower end held
verdict = string.stability(load)
print(f"critical force {unit:.0f} N; {verdict}")

# %%
# The string is simulated for 40 periods, from small random speeds.  Its segments follow from the load.
period = 2.0 * math.pi / load.frequency
start = fr.Perturbation.random(1e-4, seed=1)
run = fr.simulate(string, load, duration=40 * period, frames=40 * 16 + 1, perturbation=start)
fit = run.growth_rate()
print(run)
print(f"growth: simulated {fit}; predicted {verdict.growth_rate:.4g} 1/s")

# %%
# The growing shape is that of theory. The shape of theory is that at its largest instant, with its growth removed; the
# simulated one is the instant of largest deflection of the last two periods of the vibration in which angles are small.
shape = verdict.shape
end = int(np.argmax(run.largest_angle > 0.1))
instant = end - 32 + int(run.largest_angle[end - 32 : end].argmax())
across = run.positions[instant, :, 1]
across = across / across[np.abs(across).argmax()]
places = np.linspace(0.0, string.length, across.size)
across *= np.sign(across @ np.interp(places, shape.s, shape.deflection))

figure, (above, below) = plt.subplots(2, 1, figsize=(8.0, 6.5), layout="constrained")
above.plot(shape.s, shape.deflection, color=palette.NEUTRAL, linewidth=4.0, label="theory")
above.plot(places, across, color="black", linewidth=1.2, label=f"simulated, at {run.time[instant]:.2f} s")
above.set(
    xlabel="position from the upper end $s$ / m",
    ylabel="deflection / largest",
    xlim=(0.0, string.length),
    ylim=(-1.1, 1.4),
)
above.legend(fontsize="small", loc="upper right", ncols=2)
run.plot_growth(below)
plt.show()

# %%
# In a real hole friction decides. With friction 0.3 the same string, with the same start, comes to rest.
rough = fr.simulate(string, load, duration=20 * period, friction=0.3, perturbation=start)
print(rough)
