"""Milling: the vibration of a cutter whose teeth cut what the last one left."""

from __future__ import annotations

from floquetrod.milling.cutter import ToolMode, read_depth, read_speed
from floquetrod.milling.milling import Milling

__all__ = ["Milling", "ToolMode", "read_depth", "read_speed"]
