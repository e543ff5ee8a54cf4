"""How a simulated rod is set moving, in the terminal and in study files."""

from __future__ import annotations

import argparse
import re

import floquetrod as fr
from floquetrod import units


def read_perturbation(options: argparse.Namespace) -> fr.Perturbation:
    """Return the sum of all perturbations given."""
    parts = []
    for text in options.kick:
        mode, colon, speed = text.partition(":")
        if not (colon and re.fullmatch(r"\s*\d{1,6}\s*", mode, re.ASCII)):
            raise ValueError(f"--kick must be a mode and a speed such as 8:50mm/s, got {text!r}")
        parts.append(fr.Perturbation.modes({int(mode): units.quantity(speed, "--kick", "speed")}))
    seed, drawn = 1 if options.seed is None else options.seed, options.random is not None
    if options.case is not None:
        match = re.fullmatch(r"([ABCD])(?::(\d{1,6}))?", options.case, re.ASCII)
        if match is None or (match[2] and match[1] in "BD"):
            raise ValueError(f"--case must be A, B, C or D, A and C with a mode as in A:6, got {options.case!r}")
        drawn = drawn or match[1] in "CD"
        parts.append(fr.Perturbation.case(match[1], mode=int(match[2] or 8), seed=seed))
    if options.random is not None or not parts:
        speed = units.quantity("1mm/s" if options.random is None else options.random, "--random", "speed")
        parts.append(fr.Perturbation.random(speed, seed))
    elif options.seed is not None and not drawn:
        raise ValueError("--seed draws nothing here: it belongs to --random, --case C and --case D")
    return sum(parts, fr.Perturbation())
