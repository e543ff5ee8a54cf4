"""Draw the picture of the README: a rod's map of safe loads, and why one load is not safe.

python docs/make_picture.py
"""

from __future__ import annotations

import io
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import numpy as np
from matplotlib import pyplot
from PIL import Image

import floquetrod as fr
from floquetrod.plotting import palette

rod = fr.Rod.nitinol()
unit = rod.critical_force
load = fr.AxialLoad(mean=0.2 * unit, amplitude=0.2 * unit, frequency=150.0)
verdict = rod.stability(load)

figure, (left, right) = pyplot.subplots(1, 2, figsize=(9.6, 3.9), layout="constrained", width_ratios=(1.35, 1.0))
chart = fr.stability_map(
    rod,
    mean=(0.0, 1.1 * unit, 250),
    amplitude=load.amplitude,
    frequency=(20.0, 200.0, 300),
    growth=True,
    growth_tolerance=0.1,
)
chart.in_units(mean="Fcr", frequency="Hz").plot(left)
left.set_title("Which loads are safe?  White ones.  (7·1: mode 7, tongue 1)", fontsize="medium")

fr.mathieu.chart((0.0, 0.2, 2), (-0.8, 0.1, 2)).plot(right)  # bands are not made of points
alpha, beta = np.array([(mode.alpha, mode.beta) for mode in verdict.mode_equations]).T
shown = (alpha < 0.14) & (beta > -0.8)
right.plot(alpha[shown], beta[shown], **palette.POINT, linewidth=0.6)
grown = verdict.fastest_mode - 1
right.plot(alpha[grown], beta[grown], "o", color="black")
style = {"textcoords": "offset points", "fontsize": "small", "bbox": palette.BOX}
right.annotate(
    f"mode {verdict.fastest_mode} grows at {verdict.growth_rate:.2f} 1/s",
    (alpha[grown], beta[grown]),
    xytext=(4, 42),
    arrowprops={"arrowstyle": "-", "linewidth": 0.6},
    **style,
)
right.set(xlim=(0.0, 0.2), ylim=(-0.8, 0.1), xlabel=r"$\alpha$", ylabel=r"$\beta$")
right.set_title("Why is this one not?", fontsize="medium")
here = load.frequency / (2.0 * np.pi), load.mean / unit
left.plot(*here, **palette.POINT, markersize=8)
left.annotate("this load", here, xytext=(10, 12), **style)

drawn = io.BytesIO()
figure.savefig(drawn, dpi=150)
# So many colours are enough, and small.
Image.open(drawn).convert("RGB").quantize(96).save(Path(__file__).with_name("picture.png"), optimize=True)
