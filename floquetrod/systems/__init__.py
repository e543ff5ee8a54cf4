"""Systems of equations beyond one verdict."""

from __future__ import annotations

from floquetrod.systems.first_order import FirstOrderTongue, first_order_tongues

__all__ = ["FirstOrderTongue", "first_order_tongues"]
