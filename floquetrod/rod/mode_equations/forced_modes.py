"""Motion of the modes of a rod that is not straight: which force its natural shape is, and the periodic response to it.

With y = sum q_j phi_j, phi_j orthonormal functions of x = s / L, bending that the natural shape y_0 does not bend is

    q'' + 2 c q' + K(t) q = f,    f_j = (1 / m L^4) int E I (d^2 y_0 / dx^2) phi_j'' dx,

E I relative to its value at the upper end where the rod has several sections.  Of hinged ends the amplitudes a_j of y_0
itself have f_j = (E I k_j^4 / m L^4) a_j, and y = y_0 + sum (q_j - a_j) phi_j converges like n^-5, which sums of q_j of
a bend with a moment at its ends do not.  The response is found in harmonics of the load: `floquetrod.responses`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod._util.arguments import wrong_value
from floquetrod._util.arrays import Bools, Complexes, Floats
from floquetrod._util.content import ByContent
from floquetrod.responses.harmonic_balance import MOST_ROWS, TooManyRows
from floquetrod.responses.hill_arrays import hill_arrays
from floquetrod.responses.many import respond_to_many, scalar_responses
from floquetrod.rod.loads.load import Load, Loads
from floquetrod.rod.mode_equations.coupled_matrices import CoupledModes
from floquetrod.rod.model.natural_shape import NaturalShape

_ROUNDING = 1e-13  # part of the largest amplitude of a shape up to which others are rounding


@dataclass(frozen=True, eq=False)
class ForcedModes(ByContent):
    """The periodic motion of a rod in some modes, and its natural shape, at the nodes of their quadrature.

    Amplitudes are complex, of exp(i k w t), k from -K to K; the natural shape is one pattern, a
    random one several.

    Attributes
    ----------
    modes : CoupledModes
    shape : NaturalShape
    amplitudes : ndarray (patterns, 2 K + 1, n)
        Of the functions of the modes, in m.
    straight : ndarray (patterns, n)
        Amplitudes a_j of the natural shape that y_0 stands for, zero where it does not.
    error : float
        Estimate of the error of the amplitudes over the largest one, without modes left out.
    """

    modes: CoupledModes
    shape: NaturalShape
    amplitudes: Complexes
    straight: Floats
    error: float

    @classmethod
    def of(cls, modes: CoupledModes, load: Load, shape: NaturalShape) -> ForcedModes:
        """Return the response of some modes under a load; ValueError where its period is too long beside theirs."""
        try:
            return cls._of(modes, load, shape)
        except TooManyRows as error:
            least = load.frequency * error.rows / MOST_ROWS
            raise wrong_value(
                "frequency",
                f"must be at least about {least:.2g} rad/s for the response of {modes.size} modes, got "
                f"{load.frequency:.4g} rad/s: the highest mode swings too often in a period of the load",
            ) from error

    @classmethod
    def _of(cls, modes: CoupledModes, load: Load, shape: NaturalShape) -> ForcedModes:
        forces, straight = shape_force(modes, shape)
        system = modes.system(Loads.single(load))
        if are_independent(modes):
            stiffness, waves = (
                np.diagonal(each, axis1=-2, axis2=-1).T for each in (system.stiffness, system.harmonics)
            )
            one_by_one = scalar_responses(-stiffness, -waves, modes.damping_rate, load.frequency, 1.0)
            amplitudes = forces[:, None, :] * one_by_one.amplitudes[..., 0].T
            error = float(one_by_one.error[is_driven(straight)].max(initial=0.0))
        else:
            together = respond_to_many(hill_arrays(system), forces[:, None, :].astype(complex))
            amplitudes, error = together.amplitudes, float(together.error.max())
        return cls(modes, shape, amplitudes, straight, error)

    @property
    def middle(self) -> int:
        """Index of the harmonic 0."""
        return int(self.amplitudes.shape[1]) // 2

    @property
    def _moved(self) -> Complexes:
        """Amplitudes q - a of the functions added to the natural shape."""
        moved = self.amplitudes.copy()
        moved[:, self.middle] -= self.straight
        return moved

    def along(self, functions: Floats, base: Floats) -> Complexes:
        """Return the amplitudes (patterns, 2 K + 1, p) of a sum of functions (n, p) and a shape (patterns, p)."""
        series = self._moved @ functions
        if self.straight.any():
            series[:, self.middle] += base
        return np.asarray(series)

    def deflection(self, x: Floats) -> Complexes:
        """Return the amplitudes of the deflection in m at places x = s / L."""
        return self.along(self.modes.shapes(x), self.shape.patterns(x, self.modes.rod.length).deflection)

    def bending(self) -> Complexes:
        """Return the amplitudes of d^2 (y - y_0) / dx^2 in m at the nodes."""
        bends = self._moved @ self.modes.basis.bends
        if not self.straight.any():
            bends[:, self.middle] -= self.shape.patterns(self.modes.basis.nodes, self.modes.rod.length).bend
        return np.asarray(bends)


def are_independent(modes: CoupledModes) -> bool:
    """Return whether the equations of modes are independent: uniform rods with hinged ends under a uniform force."""
    rod = modes.rod
    is_uniform = not rod.varies and rod.path is None and modes.template.is_uniform
    return is_uniform and rod.end_conditions.are_hinged and not modes._added.any()


def shape_force(modes: CoupledModes, shape: NaturalShape) -> tuple[Floats, Floats]:
    """Return the forces f_j in m/s^2 (patterns, n), and the amplitudes a_j in m of y_0 for hinged ends, else zeros."""
    rod, basis = modes.rod, modes.basis
    patterns = shape.patterns(basis.nodes, rod.length)
    rigidity: Any = 1.0
    if rod.varies:
        rigidity = rod.along(basis.nodes).rigidity / rod.along(0.0).rigidity
    integrals = (patterns.bend * (basis.weights * rigidity)) @ basis.bends.T
    forces = modes.constants.bending / math.pi**4 * integrals
    if rod.varies or not rod.end_conditions.are_hinged:
        return forces, np.zeros_like(forces)
    return forces, integrals / np.diagonal(basis.bending)


def is_driven(straight: Floats) -> Bools:
    """Return which functions a natural shape with amplitudes (patterns, n) in these drives, beyond rounding."""
    sizes = np.abs(straight).max(axis=0)
    return np.asarray(sizes > _ROUNDING * sizes.max(initial=0.0))
