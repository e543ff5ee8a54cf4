"""Constant forces at which the literature has a rod in a channel buckle."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

from floquetrod.wells.helix_criteria import HELIX_RATIOS


class BucklingForce(NamedTuple):
    """A constant compression by one criterion of the literature.

    Attributes
    ----------
    force : float
        In N; of rods in fluids the effective force.
    meaning : str
        Meaning of the force, or the range of the criterion.
    source : str
        Authors and year.
    """

    force: float
    meaning: str
    source: str


def buckling_forces(sinusoidal: float, rigidity: float, weight: float) -> dict[str, BucklingForce]:
    """Return every criterion by name, from F_p in N, E I in N m^2 and the weight in fluid w_e in N/m."""
    return {
        "sinusoidal": BucklingForce(
            sinusoidal, "F_p = 2 sqrt(E I w_e sin(inclination) / R): the rod begins to snake", "Dawson & Paslay 1984"
        ),
        "helical, energy": BucklingForce(
            math.sqrt(HELIX_RATIOS["energy"]) * sinusoidal,
            "sqrt(2) F_p: a helix is possible; snake or helix from here to 2 sqrt(2) F_p",
            "Chen, Lin & Cheatham 1990",
        ),
        "helical, loading": BucklingForce(
            math.sqrt(HELIX_RATIOS["loading"]) * sinusoidal,
            "1.83 F_p: a helix forms as the force grows",
            "Wu & Juvkam-Wold 1993",
        ),
        "helical, alone": BucklingForce(
            math.sqrt(HELIX_RATIOS["alone"]) * sinusoidal, "2 sqrt(2) F_p: beyond it only a helix", "Mitchell 1996"
        ),
        "vertical": BucklingForce(
            1.94 * (rigidity * weight**2) ** (1.0 / 3.0),
            "1.94 (E I w_e^2)^(1/3): at the lower end of a rod 8 (E I / w_e)^(1/3) long that hangs in a vertical well, "
            "less of a longer one; whatever the inclination of this one",
            "Lubinski 1950",
        ),
    }


def buckling_forces_in_a_bend(
    straight: Mapping[str, BucklingForce], force_at: Callable[[float], float]
) -> dict[str, BucklingForce]:
    """Return the criteria where the channel bends.

    ``force_at`` returns the force in N at a ratio of F^2 R / (4 E I) to the contact force.
    """
    found = {
        "sinusoidal": BucklingForce(
            straight["sinusoidal"].force,
            "F^2 = 4 E I N / R, N the contact force: the rod begins to snake",
            "He & Kyllingstad 1995",
        )
    }
    for criterion, ratio in HELIX_RATIOS.items():
        name = f"helical, {criterion}"
        meaning = f"F^2 = {ratio:.4g} times that; in a straight channel {straight[name].meaning}"
        found[name] = BucklingForce(force_at(ratio), meaning, straight[name].source)
    return found
