"""The type of the function that long searches call with their progress."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

Progress: TypeAlias = Callable[[int, int], None]
"""(number done, number in all) -> None."""


def shifted(progress: Progress | None, before: int, others: int) -> Progress | None:
    """Return the progress of one part of a search that has ``others`` besides, ``before`` of them done."""
    return None if progress is None else lambda done, total: progress(before + done, others + total)
