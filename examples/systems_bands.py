"""
Bands and gaps
==============

Waves of some energies travel in a periodic potential, waves of others do not.
"""

import matplotlib.pyplot as plt
import numpy as np

import floquetrod as fr

# %%
# A row of walls of height 8 and width 1/2, one in every 2 units: Kronig and Penney's crystal.
walls = fr.bands(lambda t: 8.0 if t % 2.0 < 0.5 else 0.0, period=2.0, jumps=[0.0, 0.5], below=40.0)
print(walls.report())
axes = walls.plot()
axes.set_title("walls of height 8")

# %%
# Each edge is proved to lie within its error of the number given.
proofs = walls.certify()
print(f"{sum(edge.proved for edge in proofs)} of {len(proofs)} edges proved")


# %%
# Two chains: their bands cross where nothing couples them, and repel each other where something does.  A gap may then
# begin at a phase between 0 and pi.
def chains(coupling: float) -> fr.HillSystem:
    """Return -V of two chains with different potentials."""
    own, both = np.diag([1.0, 0.4]), coupling * np.array([[0.0, 1.0], [1.0, 0.0]])
    return fr.HillSystem(-np.diag([0.0, 0.7]) - both, cosines=[-own])


for coupling in (0.0, 0.3):
    bands = fr.bands(chains(coupling), below=3.0)
    print(f"coupling {coupling}:", bands)
    bands.plot().set_title(f"two chains, coupling {coupling}")

plt.show()
