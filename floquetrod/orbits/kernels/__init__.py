"""Compiled elimination of the linearised equations along branches of orbits, and errors of orbits on their meshes.

Branches take kernels, single orbits LAPACK and numpy for all intervals at once: a branch solves hundreds of systems,
and an orbit is found before numba is loaded.  So the digits of an answer do not depend on what a process has done
before.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from floquetrod._util.compilation import compiled

MOST_EQUATIONS = 4
"""Equations up to which kernels take less time than LAPACK does for all intervals at once (measured)."""

_IN_USE: set[Any] = set()


@functools.cache
def machine_code(function: Callable[..., Any]) -> Callable[..., Any] | None:
    """Return the machine code of a kernel; None where nothing is compiled, with NUMBA_DISABLE_JIT."""
    run = compiled(function)
    if not hasattr(run, "py_func"):
        return None
    _IN_USE.add(function)
    return run


def machine_code_in_use(function: Callable[..., Any]) -> Callable[..., Any] | None:
    """Return the machine code of a kernel whose results have the same bits as numpy's, where numba is loaded anyway."""
    return machine_code(function) if _IN_USE else None
