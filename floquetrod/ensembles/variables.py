"""Arrays of an ensemble, with the names of their dimensions, and the status of a run."""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import NDArray

PENDING, DONE, FAILED = 0, 1, 2
"""Values of ``status``."""


class Variable(NamedTuple):
    """An array with the names of its dimensions and its attributes: "units" and "long_name" among them."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attrs: dict[str, Any]
