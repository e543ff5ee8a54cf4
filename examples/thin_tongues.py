"""
Thin tongues: what a test over 100 periods cannot see
=====================================================

A mode that has not grown a millionfold in 100 periods may still be unstable.  Thin tongues lie between the broad ones
of a rod, and in them a mode grows slowly and without end.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr
from floquetrod.plotting import palette

rod, omega = fr.Rod.nitinol(), 85.0
amplitude = 0.2 * rod.critical_force
test = fr.FiniteTimeCriterion()

# %%
# Sweep the mean force: the verdict of the test, and the exact one.
share = np.linspace(0.25, 0.47, 4401)
mean = share * rod.critical_force
passes = rod.is_stable(mean=mean, amplitude=amplitude, frequency=omega, criterion=test)
growth, mode = rod.growth_rate(mean=mean, amplitude=amplitude, frequency=omega, return_mode=True)
missed = passes & (growth > 0.0)
modes = ", ".join(map(str, np.unique(mode[missed])))
print(f"{100.0 * missed.mean():.1f} % of these loads pass the test and are unstable, in modes {modes}")
print(f"{np.count_nonzero(~passes & (growth == 0.0))} fail it and are stable: it errs one way only")

# %%
# A grid finds only tongues wider than its steps.  Without one, none is missed, however thin:
ranges = rod.ranges("mean", amplitude=amplitude, frequency=omega, bounds=(0.0, 0.47 * rod.critical_force))
gaps = [(right.low - left.high, left.high_end) for left, right in zip(ranges, list(ranges)[1:], strict=False)]
for width, (number, tongue) in sorted(gaps, reverse=True)[:8]:
    print(f"mode {number:2d} in tongue {tongue:2d}: {width / rod.critical_force:.1e} F_cr wide")

# %%
# Growth over the mean force.  The dashed line is what reaches the limit in 100 periods.
_, axes = plt.subplots(figsize=(8.0, 4.0), layout="constrained")
axes.fill_between(share, 1e-2, np.where(missed, growth, np.nan), color=palette.UNSEEN, label="passes the test")
seen = ~passes & (growth > 0.0)
axes.fill_between(share, 1e-2, np.where(seen, growth, np.nan), color=palette.UNSTABLE, label="fails the test")
axes.semilogy(share, np.where(growth > 0.0, growth, np.nan), color="black", linewidth=0.9, label="growth rate")
axes.axhline(test.threshold * omega, color="black", linestyle="--", linewidth=0.9, label="limit of the test")
for number in np.unique(mode[growth > 0.1]):
    peak = np.argmax(np.where(mode == number, growth, 0.0))
    where = {"xytext": (-4, 3), "textcoords": "offset points", "ha": "right"}
    axes.annotate(f"mode {number}", (share[peak], growth[peak]), **where)
axes.set(xlim=(share[0], share[-1]), ylim=(1e-2, 10.0))
axes.set(xlabel=r"mean force $F_\mathrm{ave} / F_\mathrm{cr}$", ylabel="growth rate / (1/s)")
axes.set_title(f"amplitude 0.2 $F_\\mathrm{{cr}}$, {omega:g} rad/s", fontsize="small")
axes.legend(fontsize="small", loc="lower center")
plt.show()
