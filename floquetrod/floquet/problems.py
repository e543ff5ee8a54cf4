"""What verdicts are on: a scalar equation or a system, one and not a batch."""

from __future__ import annotations

from typing import Any

from floquetrod.equations import Equation, HillSystem, PeriodicSystem, matrices
from floquetrod.equations import require as require_equation

Problem = Equation | HillSystem | PeriodicSystem
"""A scalar equation, or a system."""


def require_problem(problem: Any) -> None:
    """Raise TypeError for what is neither an equation nor a system, ValueError for a batch."""
    if isinstance(problem, HillSystem | PeriodicSystem):
        matrices.require_one(problem, "equation")
    else:
        require_equation(problem, hint="or a HillSystem or PeriodicSystem")
