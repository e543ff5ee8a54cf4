"""What the bits of a run depend on beside its problem, named so that a file tells where it can be continued."""

from __future__ import annotations

import functools
import platform
from importlib import metadata

import numpy as np

VERSION = 5
"""Of the arithmetic of a simulation: of all that makes its frames, and the results of an ensemble, from a problem.

Raised by hand with every change after which some problem comes out in other bits; `tests/simulation/test_arithmetic.py`
keeps the code that computes and notices when it changes.
"""


@functools.cache
def arithmetic() -> dict[str, str]:
    """Return what a run that continues must share with the one that began, beside the processor's own rounding."""
    import numba

    return {
        "simulator": str(VERSION),
        "numba": numba.__version__,
        "llvmlite": metadata.version("llvmlite"),
        "numpy": np.__version__,
        "machine": f"{platform.system()} {platform.machine()}",
    }
