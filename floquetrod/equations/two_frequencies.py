"""Equations and systems whose coefficients have a second frequency, not commensurate with the first."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.calling import TellsAttributes, constructor_hints
from floquetrod._util.content import ByContent
from floquetrod.equations import matrices
from floquetrod.equations.base import Equation, require
from floquetrod.equations.delay_system import DelaySystem
from floquetrod.equations.hill_system import HillSystem
from floquetrod.equations.periodic_system import PeriodicSystem

_RATIO = 1e6  # of the two frequencies at most, either way


@constructor_hints(omega="the second frequency is frequency, in radians per unit of time")
@dataclass(frozen=True, eq=False, repr=False)
class TwoFrequencies(TellsAttributes, ByContent):
    """An equation or system whose coefficients have a second frequency beside their own.

    Of A'' + 2 c A' = (p(tau) + sum_k a_k cos(k w tau) + b_k sin(k w tau)) A for a scalar equation; a_k and b_k are
    matrices, added to K(t) of a `HillSystem` and to A(t) of a `PeriodicSystem`.

    Parameters
    ----------
    equation : Equation, HillSystem or PeriodicSystem
        The equation with its own frequency, one Fourier series.
    frequency : float
        w, the second one, in radians per unit of time; within 1e-6 and 1e6 times the first.
    cosines : sequence of float or array_like (n, n)
        a_k, from the first harmonic on; none by default.  Those of a `PeriodicSystem` may be complex.
    sines : sequence of float or array_like (n, n)
        b_k, likewise.

    Raises
    ------
    TypeError, ValueError
        For delays, for coefficients in several pieces, for matrices that do not fit, and without a second frequency.

    Examples
    --------
    x'' + (1/4 + 0.2 cos t + 0.2 cos(sqrt(2) t)) x = 0:

    >>> import floquetrod as fr
    >>> TwoFrequencies(fr.Hill(-0.25, cosines=(-0.2,)), 2.0**0.5, cosines=(-0.2,))
    <Hill of frequency 1 with a second frequency 1.41421>

    A qubit with two drives, A = -i H:

    >>> import numpy as np
    >>> qubit = fr.PeriodicSystem(-0.5j * np.diag([1, -1]), cosines=[-0.25j * np.array([[0, 1], [1, 0]])])
    >>> TwoFrequencies(qubit, 2.0**0.5, cosines=[-0.25j * np.diag([1, -1])])
    <PeriodicSystem of frequency 1 with a second frequency 1.41421>
    """

    equation: Equation | HillSystem | PeriodicSystem
    frequency: float
    cosines: Any = ()
    sines: Any = ()

    def __post_init__(self) -> None:
        """Check and copy the parameters."""
        problem: Any = self.equation
        if isinstance(problem, DelaySystem):
            raise TypeError(f"equation must be without delays for two frequencies, got {validate.short(problem)}")
        if isinstance(problem, HillSystem | PeriodicSystem):
            matrices.require_one(problem, "equation")
        else:
            require(problem, hint="or a HillSystem or PeriodicSystem")
        if not problem.is_smooth:
            raise ValueError(
                "equation must be one Fourier series beside a second frequency, and this one has several pieces"
            )
        frequency = validate.positive("frequency", self.frequency)
        if not 1.0 / _RATIO <= frequency / self.first <= _RATIO:
            raise ValueError(
                f"frequency must be within 1e-6 and 1e6 times that of the equation, {self.first:g}, got {frequency:g}"
            )
        object.__setattr__(self, "frequency", frequency)
        for name in ("cosines", "sines"):
            given = validate.sequence(name, getattr(self, name))
            listed = validate.listed(name, given, matrices.MOST_HARMONICS, "harmonics")
            complex_too = isinstance(problem, PeriodicSystem)
            checked = tuple(_matrix(f"{name}[{k}]", a, self.order, complex_too) for k, a in enumerate(listed))
            object.__setattr__(self, name, checked)
        if not self.cosines and not self.sines:
            raise ValueError("cosines or sines of the second frequency must be given, got none; without, use stability")

    @property
    def order(self) -> int:
        """Number of equations, 1 of a scalar one."""
        return 1 if isinstance(self.equation, Equation) else self.equation.order

    @property
    def first(self) -> float:
        """The frequency of the equation itself, in radians per unit of time."""
        return 2.0 * math.pi / float(self.equation.period)

    @property
    def time(self) -> str:
        """Name of the unit of time in which growth rates are given."""
        return self.equation.time if isinstance(self.equation, Equation) else "unit of time"

    def __repr__(self) -> str:
        """Return the kind of equation and both frequencies."""
        kind = type(self.equation).__name__
        return f"<{kind} of frequency {self.first:.6g} with a second frequency {self.frequency:.6g}>"


def _matrix(name: str, value: Any, order: int, complex_too: bool) -> NDArray[Any]:
    """Return a matrix of the order of a problem, or the number of a scalar equation."""
    array = validate.complex_array(name, value) if complex_too else validate.array(name, value)
    if array.shape not in ((order, order), *(((),) if order == 1 else ())):
        raise ValueError(f"{name} must be {order} x {order}, got shape {array.shape}")
    matrix = np.array(array).reshape(order, order)
    matrix.flags.writeable = False
    return matrix
