"""How a simulated rod is set moving, as people write it: "8:50mm/s", "1mm/s", "C:6"."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from floquetrod import units
from floquetrod.simulation.start import Perturbation


def read_perturbation(given: Mapping[str, Any], named: Callable[[str], str] = str) -> Perturbation:
    """Return the sum of the perturbations given: a list of ``kick``, ``random``, ``case`` and a ``seed``.

    Messages call them as ``named`` does.
    """
    parts = []
    for text in given["kick"]:
        mode, colon, speed = text.partition(":")
        if not (colon and re.fullmatch(r"\s*\d{1,6}\s*", mode, re.ASCII)):
            raise ValueError(f"{named('kick')} must be a mode and a speed such as 8:50mm/s, got {text!r}")
        parts.append(Perturbation.modes({int(mode): units.quantity(speed, named("kick"), "speed")}))
    random, case = given["random"], given["case"]
    seed, drawn = 1 if given["seed"] is None else given["seed"], random is not None
    if case is not None:
        match = re.fullmatch(r"([ABCD])(?::(\d{1,6}))?", case, re.ASCII)
        if match is None or (match[2] and match[1] in "BD"):
            raise ValueError(f"{named('case')} must be A, B, C or D, A and C with a mode as in A:6, got {case!r}")
        drawn = drawn or match[1] in "CD"
        parts.append(Perturbation.case(match[1], mode=int(match[2] or 8), seed=seed))
    if random is not None or not parts:
        parts.append(
            Perturbation.random(units.quantity("1mm/s" if random is None else random, named("random"), "speed"), seed)
        )
    elif given["seed"] is not None and not drawn:
        where = ", ".join([named("random"), f"{named('case')} C and {named('case')} D"])
        raise ValueError(f"{named('seed')} draws nothing here: it belongs to {where}")
    return sum(parts, Perturbation())
