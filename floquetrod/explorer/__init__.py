"""A load moved by sliders: what is shown of a rod under it, at once and when there is time."""

from __future__ import annotations

from floquetrod.explorer.explorer import Explorer

__all__ = ["Explorer"]
