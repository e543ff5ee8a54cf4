"""
The first stability region of a quadrupole ion trap
===================================================

An ion in a quadrupole filter obeys Mathieu's equation in two directions, with opposite signs.  It stays where both are
stable: a triangle, at whose apex the filter separates masses.
"""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import floquetrod as fr
from floquetrod.plotting import palette


def trap(a: float, q: float) -> fr.HillSystem:
    """Return x'' + (a - 2 q cos 2t) x = 0 and y'' - (a - 2 q cos 2t) y = 0 as one system."""
    return fr.HillSystem(np.diag([a, -a]), cosines=[np.diag([-2.0 * q, 2.0 * q])], period=np.pi)


# %%
# The two directions are independent, so the chart is that of two equations.
q, a = np.linspace(0.0, 1.0, 1001), np.linspace(0.0, 0.3, 50)[:, None]
stable = {
    "x": fr.mathieu.is_stable(*fr.conventions.from_aq(a=a, q=q)),
    "y": fr.mathieu.is_stable(*fr.conventions.from_aq(a=-a, q=-q)),
}
both = stable["x"] & stable["y"]

# %%
# The triangle ends where the boundaries meet: y loses stability at a = -a_0(q), x at a = b_1(q).


def edge_x(q: Any) -> Any:
    """Return the a beyond which x is unstable."""
    return fr.mathieu.characteristic_values(1, q, "b")


def edge_y(q: Any) -> Any:
    """Return the a beyond which y is unstable."""
    return -fr.mathieu.characteristic_values(0, q, "a")


edge = np.minimum(edge_x(q), edge_y(q))
clear = np.abs(a - edge) > 1e-9
print("verdicts on a grid agree with the boundaries:", bool((both == (a < edge))[clear].all()))
apex_q = brentq(lambda q: edge_x(q) - edge_y(q), 0.5, 0.9, xtol=1e-14)
apex_a = edge_x(apex_q)
print(f"apex at q = {apex_q:.4f}, a = {apex_a:.4f}")
for factor in (0.99, 1.01):
    print(f"{factor} times that a:", fr.stability(trap(factor * apex_a, apex_q)))

# %%
# At one setting of the filter all masses lie on a line through the origin, because a and q are both inversely
# proportional to the mass.  A line just below the apex lets a narrow range of masses through.
slope = 0.98 * apex_a / apex_q
x, y = fr.conventions.from_aq(a=slope * q, q=q), fr.conventions.from_aq(a=-slope * q, q=-q)
passed = q[fr.mathieu.is_stable(*x) & fr.mathieu.is_stable(*y) & (q > 0.0)]
print(f"on the line of 0.98 of the apex's slope: stable from q = {passed[0]:.3f} to {passed[-1]:.3f}")
_, axes = plt.subplots(figsize=(8.0, 4.6), layout="constrained")
axes.fill_between(q, edge, 0.3, color=palette.UNSTABLE, linewidth=0.0)
axes.plot(q, edge_x(q), color="black", label="boundary of $x$, $a = b_1(q)$")
axes.plot(q, edge_y(q), color="black", linestyle="--", label="boundary of $y$, $a = -a_0(q)$")
axes.plot(q, slope * q, color="black", linestyle=":", label="one setting, all masses")
axes.plot([apex_q], [apex_a], **palette.POINT, markersize=7, linestyle="none")
text = f"apex: $q = {apex_q:.4f}$, $a = {apex_a:.4f}$"
axes.annotate(text, (apex_q, apex_a), (12, 14), textcoords="offset points", fontsize="small", bbox=palette.BOX)
axes.text(0.62, 0.05, "$x$ and $y$ stable", ha="center", fontsize="small")
axes.set(xlabel="$q$", ylabel="$a$", xlim=(0.0, 1.0), ylim=(0.0, 0.3))
axes.set_title("ion trap; orange: unstable in $x$, in $y$ or in both", fontsize="small")
axes.legend(fontsize="small", loc="upper left")
plt.show()
