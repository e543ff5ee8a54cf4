"""Scalar equations in exact numbers: of values from their pieces, of classes from parameters of any numeric type."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from decimal import Decimal
from fractions import Fraction
from itertools import zip_longest
from typing import Any, NamedTuple, TypeGuard

from floquetrod._util import validate
from floquetrod.equations import Equation, Hill, HillSystem, Mathieu, MathieuAQ, Meissner, Piece

MOST_DIGITS = 10_000
"""Most digits of an exact number, and of the arithmetic of a proof (a choice)."""

_HALF = Fraction(1, 2)


class ExactWave(NamedTuple):
    """Coefficients of cos(k W tau) and sin(k W tau), W = 2 pi / period."""

    cosine: Fraction
    sine: Fraction


class ExactPiece(NamedTuple):
    """A share of the period over which the coefficient is a finite Fourier series, with waves k = 1, 2, ..."""

    share: Fraction
    mean: Fraction
    waves: tuple[ExactWave, ...] = ()


@dataclass(frozen=True)
class ExactProblem:
    """A'' + 2 c A' = p(tau) A with exact numbers."""

    equation: Equation | HillSystem  # with the nearest doubles
    pieces: tuple[ExactPiece, ...]  # of p over a period, from tau = 0 on
    damping: Fraction  # c, zero or more
    period: Fraction | None  # of p; None is the exact 2 pi
    inexact: tuple[tuple[str, Fraction], ...]  # the parameters that are not doubles, by name

    @property
    def constant(self) -> Fraction | None:
        """Value of a constant coefficient; None for any other."""
        first = self.pieces[0]
        return first.mean if len(self.pieces) == 1 and not first.waves else None

    @property
    def halves(self) -> tuple[Fraction, Fraction] | None:
        """Values of a coefficient that is constant over each half of the period 2 pi; None for any other."""
        if self.period is None and [(piece.share, piece.waves) for piece in self.pieces] == [(_HALF, ())] * 2:
            return self.pieces[0].mean, self.pieces[1].mean
        return None

    @property
    def sinusoid(self) -> tuple[Fraction, Fraction] | None:
        """Mean and amplitude of a coefficient mean + amplitude sin tau; None for any other."""
        first = self.pieces[0]
        if self.period is None and len(self.pieces) == len(first.waves) == 1 and not first.waves[0].cosine:
            return first.mean, first.waves[0].sine
        return None


Parameters = dict[str, Any]
"""Exact parameters of an equation, Fraction or tuple of Fraction, by name."""


def exact_problem(kind: type[Equation], parameters: Parameters) -> ExactProblem:
    """Return the problem of a class of equations with parameters of any numeric type."""
    return _read(kind, parameters)


def is_readable(value: Any) -> TypeGuard[type[Equation]]:
    """Return whether this is a class of equations whose parameters may be given exactly."""
    return isinstance(value, type) and any(issubclass(value, kind) for kind in _READERS)


def problem_of(equation: Equation) -> ExactProblem | None:
    """Return the problem of an equation whose coefficient is one Fourier series, or has two values over halves of 2 pi.

    None for any other.  Time is scaled so that a period that is an exact multiple of pi is 2 pi.
    """
    if isinstance(equation, MathieuAQ):  # exactly: a / 4, q / 2 and k / 2
        exact = {"alpha": Fraction(equation.q) / 2, "beta": -Fraction(equation.a) / 4}
        return ExactProblem(equation, _mathieu(exact), Fraction(equation.damping) / 2, None, ())
    level, multiple = equation.level, equation.period_over_pi
    scale = Fraction(1) if multiple is None else multiple / 2
    given = equation.pieces() if level is None else (Piece(Fraction(1), level),)
    if any(piece.slope for piece in given):
        return None
    pieces = tuple(ExactPiece(p.share, Fraction(p.start) * scale**2, _waves(p.harmonics, scale**2)) for p in given)
    period = Fraction(equation.period) if multiple is None else None
    problem = ExactProblem(equation, pieces, Fraction(equation.damping) * scale, period, ())
    return problem if len(pieces) == 1 or problem.halves is not None else None


def _waves(harmonics: tuple[complex, ...], factor: Fraction) -> tuple[ExactWave, ...]:
    """Return harmonics times a factor, exactly, without zeros at the end."""
    waves = [ExactWave(factor * Fraction(z.real), -factor * Fraction(z.imag)) for z in harmonics]
    while waves and not any(waves[-1]):
        waves.pop()
    return tuple(waves)


def problem_of_one(system: HillSystem) -> ExactProblem | None:
    """Return the problem of a system of one equation, one exact series, not anti-damped; None for any other."""
    inexact = system.pieces or system.coefficient_error
    if system.order > 1 or inexact or (system.damping is not None and system.damping[0, 0] < 0.0):
        return None
    mass = Fraction(1) if system.mass is None else Fraction(float(system.mass[0, 0]))
    damping = Fraction(0) if system.damping is None else Fraction(float(system.damping[0, 0]))
    amplitudes = system.harmonics[:, 0, 0].tolist()
    waves = tuple(ExactWave(-Fraction(z.real) / mass, Fraction(z.imag) / mass) for z in amplitudes)
    piece = ExactPiece(Fraction(1), -Fraction(float(system.stiffness[0, 0])) / mass, waves)
    return ExactProblem(system, (piece,), damping / mass / 2, Fraction(system.period), ())


def _read(kind: Any, parameters: Parameters) -> ExactProblem:
    """Return the problem with these parameters, of any numeric type, of a class of equations."""
    names = [field.name for field in fields(kind)]
    unknown = [name for name in parameters if name not in names]
    if unknown:
        raise TypeError(f"{', '.join(unknown)} is not a parameter of {kind.__name__}; they are {', '.join(names)}")
    exact = {name: _exact(name, value, several=name in LISTS) for name, value in parameters.items()}
    equation: Equation = kind(**{name: _nearest(name, value) for name, value in exact.items()})
    if exact.get("damping", 0) < 0:  # by less than a double shows
        raise ValueError("damping must be zero or more, got less; growth of the free motion is not damping")
    for field in fields(kind):
        exact.setdefault(field.name, _exact(field.name, getattr(equation, field.name), several=field.name in LISTS))
    given = [
        (f"{name}[{i}]" if name in LISTS else name, value)
        for name in parameters
        for i, value in enumerate(exact[name] if name in LISTS else (exact[name],))
    ]
    inexact = tuple((name, value) for name, value in given if value != Fraction(float(value)))
    reader = next(reader for base, reader in _READERS.items() if issubclass(kind, base))
    return ExactProblem(equation, reader(exact), exact["damping"], exact.get("period"), inexact)


LISTS = ("cosines", "sines")
"""Parameters that are sequences of numbers."""


def _mathieu(parameters: Parameters) -> tuple[ExactPiece, ...]:
    waves = (ExactWave(Fraction(0), parameters["alpha"]),) if parameters["alpha"] else ()
    return (ExactPiece(Fraction(1), parameters["beta"], waves),)


def _meissner(parameters: Parameters) -> tuple[ExactPiece, ...]:
    alpha, beta = parameters["alpha"], parameters["beta"]
    if not alpha:
        return (ExactPiece(Fraction(1), beta),)
    return ExactPiece(_HALF, beta + alpha), ExactPiece(_HALF, beta - alpha)


def _hill(parameters: Parameters) -> tuple[ExactPiece, ...]:
    pairs = zip_longest(parameters["cosines"], parameters["sines"], fillvalue=Fraction(0))
    waves = [ExactWave(cosine, sine) for cosine, sine in pairs]
    while waves and not any(waves[-1]):
        waves.pop()
    return (ExactPiece(Fraction(1), parameters["mean"], tuple(waves)),)


_READERS: dict[type, Callable[[Parameters], tuple[ExactPiece, ...]]] = {
    Mathieu: _mathieu,
    Meissner: _meissner,
    Hill: _hill,
}
"""The classes of equations whose parameters may be given exactly, with the pieces of their coefficient."""


# --- exact numbers ---


def _exact(name: str, value: Any, *, several: bool) -> Any:
    """Return a parameter as an exact number, or a sequence of them as a tuple."""
    if not several:
        return exact_number(name, value)
    listed = validate.sequence(name, value)
    return tuple(exact_number(f"{name}[{i}]", entry) for i, entry in enumerate(listed))


def _nearest(name: str, value: Fraction | tuple[Fraction, ...]) -> float | tuple[float, ...]:
    """Return the nearest doubles."""
    if isinstance(value, tuple):
        return tuple(validate.finite(f"{name}[{i}]", entry) for i, entry in enumerate(value))
    return validate.finite(name, value)


def exact_number(name: str, value: Any) -> Fraction:
    """Return an int, float, Fraction, Decimal or text such as "1/3" or "-0.1" as the exact fraction it is."""
    if isinstance(value, str):
        if len(value) > MOST_DIGITS:
            raise ValueError(f"{name} must have at most {MOST_DIGITS} digits, got {len(value)}")
        top, slash, bottom = value.partition("/")
        try:
            return Fraction(int(top), int(bottom)) if slash else exact_number(name, Decimal(value))
        except (ArithmeticError, ValueError) as error:
            if isinstance(error, ZeroDivisionError) or not str(error).startswith(name):
                raise ValueError(f"{name} must be a number such as '1/3' or '-0.1', got {value!r}") from None
            raise
    if isinstance(value, Fraction):
        return value
    if isinstance(value, Decimal):
        if not value.is_finite() or (value and abs(value.adjusted()) > MOST_DIGITS):
            raise ValueError(f"{name} must be finite, its exponent at most {MOST_DIGITS}, got {value}")
        return Fraction(value)
    if isinstance(value, int) and not isinstance(value, bool):
        return Fraction(value)
    number = validate.finite(name, value, "give a number, or text such as '1/3'")
    if value != number:
        raise ValueError(f"{name} = {value!r} is not taken exactly; give a Fraction, a Decimal or text such as '1/3'")
    return Fraction(number)
