"""
A tapered string
================

Tubing of two walls with a tool at its end, in casing above and open hole below.  Where along the string does
lateral vibration grow, and does one of the sections alone tell?
"""

from importlib.resources import files

import matplotlib.pyplot as plt

import floquetrod as fr

here = files("floquetrod") / "examples"  # `floquetrod example` writes these files
string = fr.Rod.from_toml(here / "string.toml")
for part in string.uniform_parts:
    print(f"section {part.section + 1}, {part.start:g} to {part.end:g} m: F_cr {part.rod.critical_force / 1e3:.2f} kN")

# %%
# Under two loads the string grows in different sections.  Dashed, another section begins; dotted, another bore.
loads = fr.AxialLoad("6kN", "3kN", "3.5Hz"), fr.AxialLoad("9kN", "1.5kN", "3.3Hz")
figure, axes = plt.subplots(2, 1, figsize=(7.5, 6.5), layout="constrained")
for ax, load in zip(axes, loads, strict=True):
    verdict = string.stability(load)
    verdict.plot(ax)
    print(verdict, f"most at {verdict.shape.position:.1f} m")
plt.show()

# %%
# Each part alone, as long as the whole string, gives another growth under the first load.
load = loads[0]
for part in string.uniform_parts:
    alone = part.rod.replace(length=string.length)
    print(f"from {part.start:g} m: {alone.growth_rate(load):.3f} 1/s alone")
print(f"the string: {string.growth_rate(load):.3f} 1/s")
