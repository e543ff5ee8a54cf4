"""What pictures say, for tests."""

from __future__ import annotations

from typing import Any


def note(ax: Any) -> str:
    """Return the note below the axes of a chart, in one line."""
    return str(ax.get_legend().get_title().get_text()).replace("\n", " ")
