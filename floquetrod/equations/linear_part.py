"""A linear system with a nonlinear force, in first order."""

from __future__ import annotations

from typing import Any

import numpy as np

from floquetrod.equations.hill_system import HillSystem
from floquetrod.equations.matrices import mass_matrix, velocity_matrix
from floquetrod.equations.pieces import value_at


class WithLinearPart:
    """M q'' + (C + G) q' + K(t) q = force(t, q, q', p) as a function of x = (q, q')."""

    def __init__(self, system: HillSystem, force: Any) -> None:
        """Take the linear part, and the force."""
        self.system, self.force = system, force
        self._inverse = np.linalg.inv(mass_matrix(system))
        self._friction = velocity_matrix(system)
        self._stiffness = system.stiffness if system.is_constant else None

    def __call__(self, t: Any, x: Any, **parameters: float) -> Any:
        """Return (q', q'') at one instant or at many, x (2 n, k)."""
        n = self.system.order
        q, velocity = x[:n], x[n:]
        force = self.force(t, q, velocity, **parameters)
        pushed = np.empty(q.shape, dtype=x.dtype)
        pushed[...] = np.asarray(force) if isinstance(force, np.ndarray) else np.broadcast_to(force, q.shape)
        if self._stiffness is not None:
            pull = self._stiffness @ q
        else:
            pull = np.einsum("...ij,j...->i...", value_at(self.system, t), q)
        return np.concatenate([velocity, self._inverse @ (pushed - self._friction @ velocity - pull)])

    def __eq__(self, other: object) -> bool:
        """Return whether both parts are the same."""
        return isinstance(other, WithLinearPart) and (other.system, other.force) == (self.system, self.force)

    def __hash__(self) -> int:
        return hash((self.system, self.force))

    def __repr__(self) -> str:
        """Return both parts."""
        return f"{self.system!r} with {getattr(self.force, '__name__', 'a force')}"
