"""A load moved by sliders, and pictures of a rod under it, drawn at once and when there is time."""

from __future__ import annotations

from floquetrod.explorer.explorer import Explorer

__all__ = ["Explorer"]
