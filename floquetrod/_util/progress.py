"""What a long search calls to tell how far it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

Progress: TypeAlias = Callable[[int, int], None]
"""Called with the numbers of things searched and to search."""


def shifted(progress: Progress | None, before: int, others: int) -> Progress | None:
    """Return what reports a part of a search that has ``others`` besides, ``before`` of them searched already."""
    return None if progress is None else lambda done, total: progress(before + done, others + total)
