"""
Two coupled oscillators
=======================

Forced near the sum of their frequencies, two coupled oscillators grow together though neither would alone.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette


def family(omega: float, epsilon: float) -> fr.HillSystem:
    """Return oscillators of frequencies 1 and 2; the forcing acts on each and couples them."""
    forcing = epsilon * np.array([[0.5, 1.0], [1.0, 0.8]])
    return fr.HillSystem(np.diag([1.0, 4.0]), cosines=[forcing], period=2.0 * np.pi / omega)


for omega in (3.0, 2.0, 1.0):
    print(f"w = {omega:g}:", fr.stability(family(omega, 0.2)))

# %%
# Growth over frequency and strength of the forcing.
chart = fr.chart(family, over={"omega": (1.65, 4.5, 121), "epsilon": (0.0, 0.8, 41)}, growth=True)
print(chart)

# %%
# To first order a tongue is a wedge about 2 w_1, w_1 + w_2 or 2 w_2: dashed, an approximation and no verdict.  There is
# none about w_2 - w_1 = 1, since the coupling is symmetric.
figure, axes = plt.subplots(figsize=(8.0, 4.6), layout="constrained")
chart.plot(axes)
epsilon = chart.y.values
for tongue in fr.systems.first_order_tongues(family(1.0, 1.0)):
    for side in (-1.0, 1.0):
        edge = tongue.frequency + side * tongue.half_width * epsilon
        axes.plot(edge, epsilon, color="black", linestyle="--", linewidth=0.9)
    name = f"{tongue.kind} {' + '.join(map(str, tongue.modes))}"
    axes.annotate(name, (tongue.frequency, 0.04), ha="center", fontsize="small", bbox=palette.BOX)
axes.set(xlim=(1.65, 4.5), ylim=(0.0, 0.8), xlabel="forcing frequency $w$", ylabel=r"forcing $\epsilon$")
axes.set_title("two coupled modes; dashed: boundaries to first order", fontsize="small")
plt.show()
