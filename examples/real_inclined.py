"""
An inclined rod
===============

A rod in a channel that is tilted from the horizontal: less of its weight holds it to the floor, and the rest adds to
the force along it, so that its modes are coupled.  Which shape grows, and where along the rod?
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

rod = fr.Rod.nitinol()
unit = rod.critical_force  # of the horizontal rod
load = fr.AxialLoad(mean=0.2 * unit, amplitude=0.2 * unit, frequency=150.0)

# %%
# Growth from horizontal (90 degrees from the vertical) to steep, with the mean force given at the upper end, the middle
# or the lower end, and with the weight along the rod neglected.
degrees = np.linspace(90.0, 20.0, 36)
places = {"middle": 0.5, "upper end": 0.0, "lower end": 1.0, "anywhere, the weight along the rod neglected": None}
growth = {}
for place, mean_at in places.items():
    like = fr.AxialLoad(0.0, 0.0, 1.0, mean_at=mean_at)
    tilted = [rod.replace(inclination=np.radians(angle)) for angle in degrees]
    growth[place] = [
        one.growth_rate(like, mean=load.mean, amplitude=load.amplitude, frequency=load.frequency) for one in tilted
    ]

# %%
# Given at the middle, the weight along the rod changes little; given at an end, the load is another one.
for mean_at in places.values():
    given = fr.AxialLoad(load.mean, load.amplitude, load.frequency, mean_at=mean_at)
    print(f"60 degrees, mean_at = {mean_at}:", rod.replace(inclination=np.radians(60.0)).stability(given))

# %%
# On a rod four times as long the compression differs more from end to end, and the motion grows where it suits the
# frequency best.
long = rod.replace(length=4.0 * rod.length, inclination=np.radians(30.0))
verdict = long.stability(load)
print(verdict)

_, (above, below) = plt.subplots(2, 1, figsize=(7.5, 6.0), layout="constrained")
above.fill_between(degrees, 0.0, growth["middle"], color=palette.UNSTABLE, linewidth=0.0)
for (place, rates), line in zip(growth.items(), ("-", "--", "-.", ":"), strict=True):
    above.plot(degrees, rates, color="black", linestyle=line, label=place)
above.set(xlabel="inclination from the vertical / degree", ylabel="growth rate / (1/s)", xlim=(90.0, 20.0))
above.set_ylim(0.0, 8.5)
above.legend(fontsize="small", loc="upper center", ncols=2, title="mean force given at", title_fontsize="small")
verdict.plot(below)
below.set_title(
    f"{long.length:g} m at 30 degrees: growth {verdict.growth_rate:.3g} 1/s; shaded: over a period", fontsize="small"
)
plt.show()
