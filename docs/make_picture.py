"""Draw the picture of the README: how far a string can be pushed into a well, without and with a vibration tool.

python docs/make_picture.py
"""

from __future__ import annotations

import io
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

from matplotlib import pyplot
from PIL import Image

import floquetrod as fr
from floquetrod.plotting import palette

ROOT = Path(__file__).parent.parent
well = fr.WellPath.from_csv(ROOT / "examples/survey.csv")
found = fr.Rod.from_toml(ROOT / "examples/tubing.toml").reach(well, 0.3, tool=fr.VibrationTool("5kN", "18Hz"))

figure, (left, right) = pyplot.subplots(1, 2, figsize=(9.6, 3.6), layout="constrained")
left.plot(1e-3 * found.bit_depth, 1e-3 * found.bit, color="black", label="pushed")
left.plot(1e-3 * found.bit_depth, 1e-3 * found.bit_shaken, "--", color="black", label="pushed, with the tool")
for depth, text in ((found.reach, "stuck"), (found.reach_shaken, "stuck, with the tool")):
    left.annotate(
        f"{text}\n{depth:.0f} m",
        (1e-3 * depth, 0.0),
        xytext=(-70, 20) if text == "stuck" else (0, 84),
        textcoords="offset points",
        ha="center",
        fontsize="small",
        bbox=palette.BOX,
        arrowprops={"arrowstyle": "->", "linewidth": 0.8},
    )
left.set(xlim=(0.0, 4.5), ylim=(0.0, 45.0), xlabel="measured depth of the bit / km", ylabel="force at the bit / kN")
left.set_title("How far can I push it?", fontsize="medium")
left.legend(loc="upper right", fontsize="small", frameon=False)

along = found.along
right.plot(1e-3 * along.depth, 1e-3 * along.force, color="black")
right.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
tall = {"transform": right.get_xaxis_transform(), "alpha": 0.4, "linewidth": 0.0}
buckled = (along.is_snaking | along.is_helix) & (found.growth <= 0.0)
right.fill_between(1e-3 * along.depth, 0.0, 1.0, where=buckled, color=palette.NEUTRAL, label="buckled", **tall)
grows = found.growth > 0.0
right.fill_between(1e-3 * along.depth, 0.0, 1.0, where=grows, color=palette.UNSTABLE, label="vibration grows", **tall)
right.set(xlim=(0.0, 4.5), xlabel="measured depth / km", ylabel="force in the string / kN")
right.set_title(f"Where does it buckle or shake, with the bit at {found.reach_shaken:.0f} m?", fontsize="medium")

right.legend(loc="best", fontsize="small", frameon=False)

drawn = io.BytesIO()
figure.savefig(drawn, dpi=150)
# So many colours are enough, and small.
Image.open(drawn).convert("RGB").quantize(48).save(Path(__file__).with_name("picture.png"), optimize=True)
