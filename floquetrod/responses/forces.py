"""Forces beside the parametric one: constant, Fourier series, pieces between jumps, or of a frequency of their own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Complexes, Floats
from floquetrod._util.content import ByContent
from floquetrod.equations import Equation, PeriodicSystem, matrices, sampling
from floquetrod.equations import pieces as by_pieces
from floquetrod.floquet.problems import Problem

MOST_FREQUENCY = 1e12
"""Largest frequency of a force, in radians per period of the coefficients (a choice)."""


MOST_LISTED = 4000
"""Most coordinates of a system of first order."""


@dataclass(frozen=True, eq=False)
class Force(ByContent):
    """The right-hand side f(t) of M q'' + (C + G) q' + K(t) q = f, of x' = A(t) x + f, or of A'' + 2 c A' = p A + f.

    f = mean + sum_k Re(harmonics[k-1] exp(i k W t)), W = 2 pi / period; with a ``frequency`` w it is mean exp(i w t).

    Attributes
    ----------
    frequency : float or None
        w, in radians per unit of time; None for a force of the period of the coefficients.
    mean : ndarray (n,)
        Constant part; with a frequency the complex amplitudes.
    harmonics : ndarray (H, n)
        Amplitudes of the harmonics.
    pieces : tuple
        Of a force that jumps, its pieces as diagonal matrices; the mean and harmonics are then not used.
    error : float
        Error of f(t), entry by entry.
    """

    frequency: float | None
    mean: Complexes
    harmonics: Complexes
    pieces: tuple[by_pieces.TimedPiece, ...] = ()
    error: float = 0.0

    @property
    def order(self) -> int:
        """Number of coordinates."""
        return len(self.mean)

    @property
    def amplitudes(self) -> Complexes:
        """Amplitudes (2 H + 1, n) of exp(i (w + k W) t), k from -H to H."""
        halves = 0.5 * self.harmonics
        return np.concatenate([halves[::-1].conj(), self.mean[None], halves])

    @property
    def largest(self) -> float:
        """Bound of the magnitude of the force."""
        if self.pieces:
            return max(float(piece.size.max()) for piece in self.pieces)
        return float(np.abs(self.mean).max() + np.abs(self.harmonics).sum(axis=0).max(initial=0.0))

    def __str__(self) -> str:
        """Return the force in words."""
        if self.frequency is not None:
            return f"{_listed(self.mean)} exp(i {self.frequency:.6g} t)"
        if self.pieces:
            return f"a function in {len(self.pieces)} pieces"
        if not len(self.harmonics):
            return f"constant {_listed(self.mean.real)}"
        count = len(self.harmonics)
        return f"mean {_listed(self.mean.real)}, {count} harmonic{'' if count == 1 else 's'} of the period"


def _is_complex(value: Any) -> bool:
    """Return whether a number, or one of a sequence, is complex."""
    if isinstance(value, tuple | list):  # of numbers: nested sequences are no force
        return any(not isinstance(each, tuple | list) and _is_complex(each) for each in value[:MOST_LISTED])
    kind = value.dtype.kind if isinstance(value, np.ndarray) else ""
    return kind == "c" or isinstance(value, complex | np.complexfloating)


def _listed(vector: Any) -> str:
    texts = [f"{value.real:.6g}" if value.imag == 0.0 else f"({value:.6g})" for value in vector.tolist()[:4]]
    return texts[0] if len(vector) == 1 else f"({', '.join(texts)}{', ...' if len(vector) > 4 else ''})"


def force_of(
    problem: Problem, force: Any, frequency: Any = None, cosines: Any = (), sines: Any = (), jumps: Any = ()
) -> Force:
    """Return the force of the arguments of `floquetrod.response`, checked."""
    if isinstance(problem, PeriodicSystem) and problem.is_complex:
        raise TypeError(
            f"equation must be real for responses to forces, got {validate.short(problem)}; its real form, "
            ".doubled, has the real parts of its unknowns and then the imaginary ones"
        )
    n = 1 if isinstance(problem, Equation) else problem.order
    series = {"cosines": cosines, "sines": sines, "jumps": jumps}
    given = [name for name, value in series.items() if not is_empty(value)]
    if frequency is not None:
        if callable(force) or given:
            what = f"and {given[0]}" if given else f"and force a function, {validate.short(force)}"
            raise TypeError(
                f"frequency goes with one amplitude for each coordinate, not with a force of the period; got "
                f"frequency={validate.short(frequency)} {what}"
            )
        turns = validate.finite("frequency", frequency, "radians per unit of time")
        if not abs(turns) * float(problem.period) <= MOST_FREQUENCY:
            raise ValueError(
                f"frequency must be at most {MOST_FREQUENCY:g} / period, got {turns:g} with a period of "
                f"{float(problem.period):g}"
            )
        return Force(turns, _amplitudes("force", force, n), np.zeros((0, n), dtype=complex))
    if callable(force):
        if given and given != ["jumps"]:
            raise TypeError(f"{given[0]} goes with the mean of a Fourier series, not with a function as force")
        return _of_function(force, float(problem.period), jumps, n)
    if "jumps" in given:
        raise TypeError(f"jumps goes with a function as force, got force={validate.short(force)}")
    if _is_complex(force):
        raise TypeError(
            f"force must be real without a frequency, got {validate.short(force)}; a complex amplitude has its "
            "frequency, which is 0 where it is constant"
        )
    parts = [[_vector(f"{name}[{k}]", v, n) for k, v in enumerate(_series(name, series[name]))] for name in
             ("cosines", "sines")]  # fmt: skip
    harmonics = np.zeros((max(map(len, parts)), n), dtype=complex)
    for values, factor in zip(parts, (1.0, -1j), strict=True):
        for k, value in enumerate(values):
            harmonics[k] += factor * value
    return Force(None, _vector("force", force, n).astype(complex), harmonics)


def is_empty(value: Any) -> bool:
    """Return whether an argument is a sequence of nothing."""
    return isinstance(value, tuple | list) and not value


def _series(name: str, values: Any) -> list[Any]:
    """Return the coefficients of a series, one for each harmonic."""
    if isinstance(values, np.ndarray) and values.ndim == 2:
        values = list(values)
    return validate.listed(name, validate.sequence(name, values), matrices.MOST_HARMONICS, "harmonics")


def _vector(name: str, value: Any, n: int) -> Floats:
    """Return a number for each coordinate."""
    array = validate.array(name, value)
    _require_shape(name, array, n)
    return np.array(array, dtype=float).reshape(n)


def _amplitudes(name: str, value: Any, n: int) -> Complexes:
    """Return a complex number for each coordinate."""
    if isinstance(value, complex | np.complexfloating) or (isinstance(value, np.ndarray) and value.dtype.kind == "c"):
        raw = np.array(value, dtype=complex)
        validate.array(f"{name} (real part)", raw.real)
        validate.array(f"{name} (imaginary part)", raw.imag)
    elif validate.iterable(value) and not isinstance(value, str | bytes | np.ndarray):
        entries = validate.listed(name, value, max(n, 1) + 1, "amplitudes")
        raw = np.array([_amplitudes(f"{name}[{i}]", entry, 1)[0] for i, entry in enumerate(entries)], dtype=complex)
    else:
        raw = validate.array(name, value).astype(complex)
    _require_shape(name, raw, n)
    return raw.reshape(n)


def _require_shape(name: str, array: Any, n: int) -> None:
    if array.shape != (n,) and not (n == 1 and array.shape == ()):
        wanted = "one number" if n == 1 else f"{n} numbers, one for each coordinate"
        raise ValueError(f"{name} must be {wanted}, got shape {array.shape}")


def _of_function(function: Callable[[float], Any], period: float, jumps: Any, n: int) -> Force:
    """Return the force that a function computes, by the expansions of coefficients: it is a diagonal matrix."""

    def diagonal(t: float) -> Floats:
        return np.diag(_vector(f"force({t:g})", function(t), n))

    try:
        expansion = sampling.expanded(diagonal, period, jumps, n)
    except ValueError as error:
        raise ValueError(str(error).replace("function", "force", 1)) from None
    system = PeriodicSystem.from_pieces(expansion.pieces, coefficient_error=expansion.error)
    mean = np.diagonal(system.mean).astype(complex)
    if system.pieces:
        return Force(None, mean, np.zeros((0, n), dtype=complex), by_pieces.in_time(system), expansion.error)
    harmonics = np.diagonal(system.harmonics, axis1=-2, axis2=-1)
    return Force(None, mean, np.array(harmonics).reshape(-1, n), (), expansion.error)
