"""Draw the picture of the README and of the first page: how far a string can be pushed, without and with a tool.

Well, string and tool are those of the first page's code; its two panels are two pictures, which a phone stacks.

python docs/make_picture.py
"""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

mpl.use("Agg")

from matplotlib import pyplot
from PIL import Image

from floquetrod.plotting import palette

HERE = Path(__file__).parent
COLOURS = 48  # which are enough, and keep the files small


def save(figure: Any, name: str, panel: Any = None) -> None:
    """Save a figure, or one panel of it, with few colours."""
    drawn, box = io.BytesIO(), None
    if panel is not None:
        box = panel.get_tightbbox().padded(8.0).transformed(figure.dpi_scale_trans.inverted())
    figure.savefig(drawn, dpi=150, bbox_inches=box)
    Image.open(drawn).convert("RGB").quantize(COLOURS).save(HERE / name, optimize=True)


(code,) = re.findall(r"^```\{code-cell\}\n(import.*?)^```", (HERE / "index.md").read_text("utf-8"), re.M | re.S)
*defined, last = code.splitlines()
names: dict[str, Any] = {}
exec("\n".join(defined), names)
found = eval(last, names)
# What arrives is found at a dozen of the depths asked for, here at other ones each time.
curves = [
    names["tubing"].reach(names["well"], 0.3, tool=names["tool"], depth=np.linspace(first, 4500.0, 12))
    for first in np.linspace(150.0, 500.0, 5)
]

figure, (left, right) = pyplot.subplots(1, 2, figsize=(9.6, 3.6), layout="constrained")
for kind, reach, line, label in (
    ("bit", found.reach, "-", "pushed"),
    ("bit_shaken", found.reach_shaken, "--", "pushed, with the tool"),
):
    depth, force = (np.concatenate([getattr(each, name) for each in curves]) for name in ("bit_depth", kind))
    arrives = np.flatnonzero(np.isfinite(force) & (depth < reach))
    kept = arrives[depth[arrives].argsort()]
    at = np.append(depth[kept], reach)  # where the string is stuck nothing is left
    left.plot(1e-3 * at, 1e-3 * np.append(force[kept], 0.0), line, color="black", label=label)
for depth, text in ((found.reach, "stuck"), (found.reach_shaken, "stuck, with the tool")):
    left.annotate(
        f"{text}\n{depth:.0f} m",
        (1e-3 * depth, 0.0),
        xytext=(-84, 14) if text == "stuck" else (8, 84),
        textcoords="offset points",
        ha="center",
        fontsize="small",
        bbox=palette.BOX,
        arrowprops={"arrowstyle": "->", "linewidth": 0.8},
    )
left.set(xlim=(0.0, 4.5), ylim=(0.0, 45.0), xlabel="measured depth / km", ylabel="force at the lower end / kN")
left.set_title("How far can I push it?", fontsize="medium")
left.legend(loc="upper right", fontsize="small", frameon=False)

along = found.along
right.plot(1e-3 * along.depth, 1e-3 * along.force, color="black")
right.axhline(0.0, color="0.5", linewidth=0.6)
tall = {"transform": right.get_xaxis_transform(), "linewidth": 0.0, "zorder": 0}
buckled = (along.is_snaking | along.is_helix) & (found.growth <= 0.0)
right.fill_between(1e-3 * along.depth, 0.0, 1.0, where=buckled, color=palette.UNKNOWN, label="buckled", **tall)
grows = found.growth > 0.0
right.fill_between(1e-3 * along.depth, 0.0, 1.0, where=grows, color=palette.UNSTABLE, label="vibration grows", **tall)
right.set(xlim=(0.0, 4.5), xlabel="measured depth / km", ylabel="force in the string / kN")
right.set_title(f"Where does it buckle or vibrate, at {found.reach_shaken:.0f} m?", fontsize="medium")
right.legend(loc="best", fontsize="small", frameon=False)

save(figure, "picture.png")
for name, panel in (("picture_left.png", left), ("picture_right.png", right)):
    save(figure, name, panel)
