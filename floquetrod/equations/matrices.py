"""Matrices of a system's Fourier series: checks, common shapes, and conversions for the methods."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import Complexes, Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent
from floquetrod._util.result_report import Report, ShownInNotebook

Matrix = NDArray[np.float64]
"""Of float64; of a complex `PeriodicSystem` also of complex128."""
Structure = Literal["hamiltonian", "reversible", "unitary", "damped", "general"]

LARGEST_ENTRY = 1e30
"""Largest magnitude of a matrix entry, in any units."""

MOST_EQUATIONS = 2000
"""Most equations of a system (a choice): the map of more takes minutes."""

MOST_HARMONICS = 1024
"""Most harmonics of a system (a choice)."""

_MOST_ENTRIES = 1 << 28  # of a matrix over a whole batch, two gigabytes (a choice)
_LEAST_PERIOD = 1e-100


class PeriodicMatrixSystem(ByContent, ShownInNotebook):
    """Base of systems with a periodic matrix, a Fourier series or in pieces: ``MEAN`` names the field of its mean.

    Its arrays are closed to writing, as are the arrays of its copies, unpickled ones among them.
    """

    MEAN: ClassVar[str]
    MEANING: ClassVar[str] = ""
    """The kind of stability of another system that its stability means, such as "mean-square"; "" for its own."""
    cosines: tuple[Matrix, ...]
    sines: tuple[Matrix, ...]
    period: Any
    pieces: tuple[tuple[Any, Any], ...]

    def _take(self, values: dict[str, Any]) -> None:
        """Take over the fields, arrays closed to writing; ValueError where leading shapes do not fit."""
        vars(self).update(values)
        for value in (*values.values(), *(duration for duration, _ in self.pieces)):
            for array in value if isinstance(value, tuple) else (value,):
                if isinstance(array, np.ndarray):
                    array.flags.writeable = False
        _ = self.shape

    @property
    def order(self) -> int:
        """Number of equations."""
        return int(getattr(self, self.MEAN).shape[-1])

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Leading shape of a batch of systems, () of one."""
        return leading_shape(self.order, self.period, **{self.MEAN: getattr(self, self.MEAN)}, **named(self))

    @cached_property
    def harmonics(self) -> Complexes:
        """Amplitudes Z, complex (..., H, n, n), of mean + sum_k Re(Z_k exp(i k w t)); trailing zeros dropped.

        Raises TypeError for a system in pieces, which has no finite Fourier series.
        """
        if self.pieces:
            raise TypeError(
                f"system must be one finite Fourier series, got one of {len(self.pieces)} pieces; "
                "fr.stability, fr.certify, fr.solve and fr.chart take those too"
            )
        return harmonic_amplitudes(self.cosines, self.sines, self.shape, self.order)

    @property
    def _waves(self) -> int:
        """Number of harmonics."""
        return int(self.harmonics.shape[-3])

    @property
    def is_smooth(self) -> bool:
        """Whether the matrix is one Fourier series all over the period."""
        return not self.pieces

    @property
    def is_constant(self) -> bool:
        """Whether nothing depends on time."""
        if not self.pieces:
            return self._waves == 0
        first = self.pieces[0][1]
        return all(value.is_constant and np.array_equal(value.start, first.start) for _, value in self.pieces)

    @property
    def variation(self) -> str:
        """How the matrix varies, in words."""
        count = len(self.pieces) or self._waves
        what = "piece" if self.pieces else "harmonic"
        return f"{count} {what}{'' if count == 1 else 's'}" if count else "constant coefficients"

    @property
    def every_matrix(self) -> tuple[Matrix, ...]:
        """The mean and all coefficients of the periodic matrix; in pieces, of every piece."""
        if self.pieces:
            return tuple(matrix for _, value in self.pieces for matrix in value.matrices)
        return (getattr(self, self.MEAN), *self.cosines, *self.sines)

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields, without properties computed from them."""
        value: Any = self
        return {field.name: getattr(value, field.name) for field in fields(value)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take over the arrays, closed to writing."""
        self._take(state)

    def _at_hand(self) -> Report:
        """Return the matrices of the system for a notebook, large ones by their shape, pieces by their number."""
        value: Any = self
        names = [field.name for field in fields(value) if field.name != "pieces"]
        return Report(
            f"{type(self).__name__} of order {value.order}, {self.variation}", arguments_in_words(self, names)
        )

    def __repr__(self) -> str:
        """Return the call that makes the system, large matrices by their shape."""
        value: Any = self
        names = [field.name for field in fields(value)]
        if not self.pieces:
            return constructor_call(self, names[:-1])
        listed = []
        for duration, varying in self.pieces:
            text = described(duration) if isinstance(duration, np.ndarray) else repr(duration)
            listed.append(f"({text}, {described(varying.start) if varying.is_constant else repr(varying)})")
        made = [name for name in names if name not in (self.MEAN, "cosines", "sines", "period", "pieces")]
        others = constructor_call(self, made).partition("(")[2]
        return f"{type(self).__name__}.from_pieces([{', '.join(listed)}]{', ' if others != ')' else ''}{others}"


def remade(original: Any, **changes: Any) -> Any:
    """Return a copy of a system or of a `Varying` with other values of fields, which are not checked."""
    copy: Any = object.__new__(type(original))
    copy.__setstate__(original.__getstate__() | changes)
    return copy


def mass_matrix(system: Any) -> Matrix:
    """Return M of a system of second order, the identity where it has none."""
    return np.eye(system.order) if system.mass is None else np.asarray(system.mass)


def velocity_matrix(system: Any) -> Matrix:
    """Return C + G of a system of second order."""
    given = [matrix for matrix in (system.damping, system.gyroscopic) if matrix is not None]
    return np.asarray(sum(given, np.zeros((system.order, system.order))))


def flat(array: Any, shape: tuple[int, ...], tail: int) -> NDArray[Any]:
    """Return an array with the leading shape of a batch made one axis; its last ``tail`` axes stay as they are."""
    array = np.asarray(array)
    if not shape:
        single: NDArray[Any] = array[None]
        return single
    inner = array.shape[array.ndim - tail :]
    whole = np.broadcast_to(array, (*shape, *inner))
    return np.ascontiguousarray(whole).reshape(math.prod(shape), *inner)


def square(
    name: str,
    value: Any,
    order: int | None = None,
    reference: str = "",
    most: int = MOST_EQUATIONS,
    *,
    complex_too: bool = False,
) -> Matrix:
    """Return matrices of shape (..., n, n), n up to ``most``; ``order`` is the required n, as of ``reference``.

    With ``complex_too`` they may be complex; where all imaginary parts are zero they are real.
    """
    if isinstance(value, np.ndarray) or validate.is_sparse(value):  # before its entries are read, or it is filled
        _require_square(name, value, most)
    value = dense(value)
    if complex_too:
        array = validate.complex_array(name, value, LARGEST_ENTRY)
    else:
        array = validate.array(name, value, least=-LARGEST_ENTRY, largest=LARGEST_ENTRY)
    _require_square(name, array, most)
    if order is not None and array.shape[-1] != order:
        raise ValueError(f"{name} must be {order} x {order} as {reference} is, got shape {array.shape}")
    given = np.asarray(value)
    if given.dtype.kind == "c":
        _require_unrounded(name, given.real, array.real)
        _require_unrounded(name, given.imag, array.imag)
    else:
        _require_unrounded(name, given, array)
    return np.array(array)  # a copy of our own


def dense(value: Any) -> Any:
    """Return a sparse matrix as an array, anything else unchanged."""
    return value.toarray() if validate.is_sparse(value) else value


def _require_unrounded(name: str, given: NDArray[Any], array: Floats) -> None:
    """Raise ValueError where an entry is not the double it became: a verdict is on the matrix that was given."""
    if given.dtype.kind == "f" and given.dtype.itemsize <= array.dtype.itemsize:
        return
    doubtful = np.abs(array) >= 2.0**53 if given.dtype.kind in "iu" else np.ones(array.shape, dtype=bool)
    for index in map(tuple, np.argwhere(doubtful).tolist()):
        if given.item(index) != array[index].item():
            entry = f"{name}[{', '.join(map(str, index))}]" if index else name
            raise ValueError(
                f"{entry} = {validate.short(given.item(index))} is not a binary number of 53 digits; round it with "
                "float() or numpy's astype(float)"
            )


def _require_square(name: str, array: NDArray[Any], most: int) -> None:
    """Raise ValueError unless the array holds square matrices, none too large."""
    shape = array.shape
    if array.ndim < 2 or shape[-1] != shape[-2] or 0 in shape:
        hint = f"; for one equation give [[{array.item()}]]" if array.ndim == 0 else ""
        raise ValueError(f"{name} must be a square matrix, or an array of them, got shape {shape}{hint}")
    if shape[-1] > most:
        raise ValueError(f"{name} must be at most {most} x {most}, got shape {shape}")
    if array.size > _MOST_ENTRIES:
        raise ValueError(f"{name} must hold at most {_MOST_ENTRIES:,} entries, got shape {shape}; take fewer systems")


def by_harmonic(name: str, values: Any, order: int, reference: str, *, complex_too: bool = False) -> tuple[Matrix, ...]:
    """Return the matrices of a sequence, one for each harmonic."""
    if isinstance(values, np.ndarray) and values.ndim and not validate.is_masked(values):
        listed = list(values[: MOST_HARMONICS + 1])
    elif validate.is_sparse(values):
        raise TypeError(f"{name} must be a sequence of matrices, one for each harmonic; for one give {name}=[matrix]")
    else:
        listed = validate.sequence(name, values, "[matrix]")
    if len(listed) > MOST_HARMONICS:
        raise ValueError(f"{name} must hold at most {MOST_HARMONICS} harmonics, got more")
    stacked = _stacked(listed, order)
    if stacked is not None:
        return tuple(stacked)
    for k, value in enumerate(listed):
        if validate.is_sparse(value):
            _require_square(f"{name}[{k}]", value, 2 * MOST_EQUATIONS)
    listed = [dense(value) for value in listed]
    if listed and all(_is_flat(value) for value in listed):
        raise ValueError(f"{name} must be a sequence of matrices, one for each harmonic; for one give {name}=[matrix]")
    return tuple(
        square(f"{name}[{k}]", value, order, reference, 2 * MOST_EQUATIONS, complex_too=complex_too)
        for k, value in enumerate(listed)
    )


def _stacked(listed: list[Any], order: int) -> NDArray[np.float64] | None:
    """Return matrices in one array of their own; None where `square` has to look at them one by one."""
    arrays = [value for value in listed if type(value) is np.ndarray and value.dtype == np.float64]
    if not arrays or len(arrays) < len(listed) or len({value.shape for value in arrays}) > 1:
        return None
    first = arrays[0]
    if first.ndim < 2 or first.shape[-2:] != (order, order) or not 0 < first.size <= _MOST_ENTRIES:
        return None
    stacked = np.array(arrays)
    return stacked if np.abs(stacked).max() <= LARGEST_ENTRY else None


def _is_flat(value: Any) -> bool:
    """Return whether this is a number, or a sequence of numbers."""
    return not any(validate.iterable(element) for element in value) if validate.iterable(value) else True


def periods(value: Any, name: str = "period") -> float | Floats:
    """Return a period, or an array of them for a batch."""
    if not validate.iterable(value) or isinstance(value, str | bytes):
        number = validate.within(name, value, _LEAST_PERIOD, 1.0 / _LEAST_PERIOD)
        _require_unrounded(name, np.asarray(value), np.asarray(number))
        return number
    array = validate.array(name, value, least=-1.0 / _LEAST_PERIOD, largest=1.0 / _LEAST_PERIOD)
    if array.size == 0:
        raise ValueError(f"{name} must be one number, or an array of one for each system, got none")
    if not (array >= _LEAST_PERIOD).all():
        raise ValueError(f"{name} must be greater than zero, got {float(array.min())!r} among {array.size} values")
    return np.array(array)


def leading_shape(order: int, period: Any, **matrices: Matrix) -> tuple[int, ...]:
    """Return the common leading shape of matrices and periods; ValueError names them where they have none."""
    shapes = {name: matrix.shape[:-2] for name, matrix in matrices.items()} | {"period": np.shape(period)}
    try:
        shape = np.broadcast_shapes(*shapes.values())
    except ValueError:
        listed = ", ".join(f"{name} {shape}" for name, shape in shapes.items() if shape)
        raise ValueError(f"the leading shapes must broadcast to one, got {listed}") from None
    if math.prod(shape) * order * order > _MOST_ENTRIES:
        raise ValueError(f"the leading shapes must make at most {_MOST_ENTRIES // order**2:,} systems, got {shape}")
    return shape


def mirrored(matrix: NDArray[Any]) -> NDArray[Any]:
    """Return the symmetric parts of matrices (..., n, n), symmetric bit for bit."""
    return np.asarray(0.5 * (matrix + np.swapaxes(matrix, -1, -2)))


def symmetric(matrix: Matrix) -> bool:
    """Return whether every matrix equals its transpose, entry by entry."""
    return bool(np.array_equal(matrix, np.swapaxes(matrix, -1, -2)))


def harmonic_amplitudes(
    cosines: tuple[Matrix, ...], sines: tuple[Matrix, ...], shape: tuple[int, ...], order: int
) -> Complexes:
    """Return Z, complex (*shape, H, n, n), of sum_k Re(Z_k exp(i k w t)); trailing zeros are dropped."""
    count = max(len(cosines), len(sines))
    result = np.zeros((*shape, count, order, order), dtype=np.complex128)
    for k, matrix in enumerate(cosines):
        result.real[..., k, :, :] = matrix
    for k, matrix in enumerate(sines):
        result.imag[..., k, :, :] -= matrix
    while count and not result[..., count - 1, :, :].any():
        count -= 1
    result.flags.writeable = False
    return result[..., :count, :, :]


def described(value: Any) -> str:
    """Return the text of a matrix in a repr: in full while it is small."""
    matrix = np.asarray(value)
    return repr(matrix.tolist()) if matrix.size <= 9 else f"<{' x '.join(map(str, matrix.shape))} array>"


def named(system: Any) -> dict[str, Matrix]:
    """Return the matrices of a system beside its mean, by name."""
    series = {f"{name}[{k}]": m for name in ("cosines", "sines") for k, m in enumerate(getattr(system, name))}
    pieces = {
        f"pieces[{j}][1]" + f".matrices[{i}]" * (i > 0): matrix
        for j, (_, value) in enumerate(system.pieces)
        for i, matrix in enumerate(value.matrices)
    }
    others = {name: getattr(system, name, None) for name in ("mass", "damping", "gyroscopic")} | pieces
    return series | {name: matrix for name, matrix in others.items() if isinstance(matrix, np.ndarray)}


def require_one(system: Any, name: str = "system") -> None:
    """Raise ValueError for a batch of systems."""
    if system.shape:
        raise ValueError(
            f"{name} must be a single system, got a batch of shape {system.shape}; a batch is for functions such as "
            "floquetrod.systems.multipliers(batch)"
        )


def constructor_call(system: Any, names: list[str]) -> str:
    """Return the call that constructs a system, without arguments at their default."""
    arguments = (f"{name}={text}" for name, text in arguments_in_words(system, names))
    return f"{type(system).__name__}({', '.join(arguments)})"


def arguments_in_words(system: Any, names: list[str]) -> list[tuple[str, str]]:
    """Return arguments of a system by their names, those at their default left out, large matrices by their shape."""
    arguments = []
    for name in names:
        value = getattr(system, name)
        if isinstance(value, tuple):
            text = f"[{', '.join(map(described, value))}]" if value else ""
        elif isinstance(value, np.ndarray):
            text = described(value)
        else:
            text = "" if value in (None, 0.0) else f"{value:.17g}"
        arguments += [(name, text)] if text else []
    return arguments
