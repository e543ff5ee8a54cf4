"""
Damping that destabilises
=========================

Equal damping narrows a combination resonance.  Unequal damping widens it, and can destabilise a system that is stable
without any damping.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette


def family(omega: float, damping: tuple[float, float]) -> fr.HillSystem:
    """Return oscillators of frequencies 1 and 2, coupled by the forcing; each has its own decay rate."""
    forcing = 0.2 * np.array([[0.5, 1.0], [1.0, 0.8]])
    friction = 2.0 * np.diag(damping)
    return fr.HillSystem(np.diag([1.0, 4.0]), cosines=[forcing], damping=friction, period=2.0 * np.pi / omega)


cases = {(0.0, 0.0): "-", (0.02, 0.02): "--", (0.002, 0.2): "-."}
for damping in cases:
    print(f"decay rates {damping}:", fr.stability(family(3.1, damping)))

# %%
# Left: growth about the sum of the frequencies, 3; the circles are the first-order approximation.  Right: beside the
# undamped tongue, at w = 3.1, over the damping of the second mode.  A little of it destabilises, and much more
# is needed to stabilise again.
omega = np.linspace(2.75, 3.25, 61)
figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.2), layout="constrained")
for damping, line in cases.items():
    growth = [fr.stability(family(w, damping)).growth_rate for w in omega]
    left.plot(omega, growth, color="black", linestyle=line, label=f"$c_1 = {damping[0]:g}$, $c_2 = {damping[1]:g}$")
    tongue = next(one for one in fr.systems.first_order_tongues(family(3.0, damping)) if one.kind == "sum")
    estimate = tongue.growth_rate_at(omega)
    shown = np.flatnonzero(estimate > 0.0)[::2]
    left.plot(omega[shown], estimate[shown], linestyle="none", **palette.POINT, markersize=4)
    print(tongue)
left.axvline(3.1, color="black", linewidth=0.5)
left.annotate("right", (3.1, 0.02), xytext=(3, 0), textcoords="offset points", fontsize="small")
left.set(
    xlabel="forcing frequency $w$", ylabel="growth rate per unit time", xlim=(omega[0], omega[-1]), ylim=(0.0, 0.04)
)
left.set_title("lines: computed, circles: first order", fontsize="small")
left.legend(fontsize="x-small", loc="upper left")

second = np.geomspace(0.002, 2.0, 31)
exponents = np.array([max(e.real for e in fr.stability(family(3.1, (0.002, c))).exponents) for c in second])
right.fill_between(second, 0.0, exponents, where=exponents > 0.0, color=palette.UNSTABLE, interpolate=True)
right.semilogx(second, exponents, color="black")
right.axhline(0.0, color="black", linewidth=0.5)
right.set(
    xlabel="decay rate $c_2$ of the second mode",
    ylabel="largest real part, per unit time",
    xlim=(second[0], second[-1]),
)
right.set_title("exponents, $w = 3.1$, $c_1 = 0.002$; orange: unstable", fontsize="small")
plt.show()
print(f"unstable from c_2 = {second[exponents > 0.0][0]:.3f} to {second[exponents > 0.0][-1]:.2f}")
