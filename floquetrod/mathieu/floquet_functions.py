"""Floquet solutions: the Mathieu functions ce, se and me of real order, and both solutions of a Mathieu equation."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Complexes, Floats, broadcast, shaped
from floquetrod._util.content import ByContent
from floquetrod.equations import Mathieu, MathieuAQ, in_tau
from floquetrod.equations.base import require
from floquetrod.mathieu.array_functions import exponents
from floquetrod.mathieu.characteristic_curves import characteristic_values

_LONGEST = 1e6  # time (a choice: beyond it rounding of the phase costs more than ten digits)
_HIGHEST = 1e4  # order (a choice)
_LARGEST_Q = 1e7  # of a solution: some ten thousand coefficients (a choice)
_BEYOND = 24  # harmonics beyond the last that oscillates, at least (heuristic: each costs more than a digit)
_SWEEPS = 3  # of inverse iteration (heuristic: two suffice)


@dataclass(frozen=True, eq=False, repr=False)
class FloquetSolution(ByContent):
    """A solution y(t) = sum_k c_k exp((mu + i w_k) t): periodic apart from exp(mu t), and for me from exp(i nu z).

    Attributes
    ----------
    name : str
        Name, such as "ce_3(z, 10)".
    exponent : complex
        mu; its real part is the growth rate.  0 for ce, se and me.
    frequencies : ndarray (n,) of float
        w_k; for me they include the order nu.
    coefficients : ndarray (n,) of complex
        c_k.
    period : float
        Period of the equation: pi in z, 2 pi in tau.
    is_real : bool
        Whether its values are real: true for ce and se.

    Examples
    --------
    >>> ce = characteristic_function(3, 10.0, "a")
    >>> round(ce(0.5), 12), ce.exponent
    (0.96526954904, 0j)
    """

    name: str
    exponent: complex
    frequencies: Floats
    coefficients: Complexes
    period: float
    is_real: bool

    def __call__(self, time: Any, derivative: int = 0) -> Any:
        """Return the solution, or its first or second derivative, at times (array_like, up to 1e6 in magnitude)."""
        times = validate.array("time", time, least=-_LONGEST, largest=_LONGEST)
        order = validate.integer("derivative", derivative, 0, 2)
        rates = self.exponent + 1j * self.frequencies
        terms = self.coefficients * rates**order
        values = np.zeros(times.size, dtype=np.complex128)
        for place in range(0, times.size, 1024):  # so that memory stays in proportion to the answer
            part = slice(place, place + 1024)
            values[part] = np.exp(np.multiply.outer(times.ravel()[part], rates)) @ terms
        return shaped(values.real if self.is_real else values, times.shape)

    def plot(self, ax: Any = None, periods: float = 2.0) -> Any:
        """Draw it over some periods of the equation into matplotlib axes (new ones by default), which are returned."""
        from floquetrod.plotting.solution_plot import draw_solution

        return draw_solution(self, ax, validate.positive("periods", periods))

    def __repr__(self) -> str:
        """Return its name and exponent."""
        return f"<{self.name}, exponent {self.exponent:.6g}, {self.frequencies.size} harmonics>"


def real_order_values(order: Any, q: Any) -> Any:
    """Return the characteristic value lambda_nu(q) of y'' + (a - 2 q cos 2 z) y = 0 for real orders nu.

    The value of a at which solutions exp(i nu z) P(z), P of period pi, exist; continuous in q, nu^2 at q = 0.

    Parameters
    ----------
    order : array_like of float
        nu, magnitude at most 1e4; no whole numbers, at which the value has two limits, a_m and b_m:
        `characteristic_values` returns them.
    q : array_like of float
        Any real, magnitude at most 1e7; broadcasts with ``order``.

    Returns
    -------
    float or ndarray of float
        Absolute error within some units of rounding of max(1, abs(a), abs(q)).

    Raises
    ------
    TypeError, ValueError
        For whole numbers, for numbers out of these ranges, and for shapes that do not broadcast.

    Notes
    -----
    DLMF 28.12.

    Examples
    --------
    >>> round(real_order_values(0.5, 1.0), 12)
    -0.307285350632
    """
    given = {
        "order": validate.array("order", order, least=-_HIGHEST, largest=_HIGHEST),
        "q": validate.array("q", q, least=-_LARGEST_Q, largest=_LARGEST_Q),
    }
    whole = given["order"] == np.round(given["order"])
    if whole.any():
        raise ValueError(
            f"order must not be a whole number, got {given['order'][whole][0]:g}: there the value has two limits, "
            'those of characteristic_values with kind "a" and "b"'
        )
    shape, (orders, sizes) = broadcast(**given)
    return shaped(np.array([_real_order(abs(nu), x)[0] for nu, x in zip(orders, sizes, strict=True)]), shape)


def characteristic_function(order: float, q: float, kind: str = "floquet") -> FloquetSolution:
    """Return the Floquet solution of y'' + (a - 2 q cos 2 z) y = 0 whose order is given, as a function of real z.

    Parameters
    ----------
    order : int or float
        m = 0, 1, 2, ... for kind "a", from 1 for "b"; any real but whole numbers, up to 1e4, for "floquet".
    q : float
        Magnitude at most 1e7.
    kind : {"a", "b", "floquet"}
        ce_m with characteristic value a_m; se_m with b_m; me_nu with the value that `real_order_values` returns.

    Returns
    -------
    FloquetSolution
        Normalised and signed as DLMF 28.2(vi) and 28.12(ii): the integral of ce^2 or se^2 over 2 pi is pi, ce(0) > 0,
        se'(0) > 0; the integral of me_nu(z) me_nu(-z) over pi is pi, me_nu(0) > 0.

    Raises
    ------
    TypeError, ValueError
        For an order that the kind does not have, and for numbers out of these ranges.

    Examples
    --------
    >>> round(characteristic_function(50, 2000.0, "b")(1.0), 10)
    0.7670150891
    """
    kind = validate.choice("kind", kind, ("a", "b", "floquet"))
    size = validate.within("q", validate.finite("q", q), -_LARGEST_Q, _LARGEST_Q)
    if kind == "floquet":
        nu = validate.within("order", validate.finite("order", order), -_HIGHEST, _HIGHEST)
        if nu == round(nu):
            raise ValueError(
                f'order must not be a whole number for kind "floquet", got {nu:g}; "a" is ce and "b" is se'
            )
        value, shift, vector = real_order_values(nu, size), *_real_order(nu, size)[1:]
        frequencies = shift + 2.0 * (np.arange(vector.size) - vector.size // 2)
        frequencies, vector = _without_tails(frequencies, vector)
        scaled = vector * _sign_of_me(nu, frequencies, vector) / math.sqrt(float(vector @ vector))
        return FloquetSolution(f"me_{nu:g}(z, {size:g})", 0j, frequencies, scaled.astype(complex), math.pi, False)
    hint = 'kind "floquet" accepts other orders'
    m = validate.integer("order", order, 1 if kind == "b" else 0, int(_HIGHEST), hint)
    value = characteristic_values(m, size, kind)
    harmonics, vector = _periodic(m, size, kind, value)
    harmonics, vector = _without_tails(harmonics, vector)
    constant = harmonics == 0.0
    norm = math.sqrt(float(vector @ vector + np.sum(vector[constant] ** 2)))
    sign = _sign(kind, float(m), size, harmonics, vector)
    half = 0.5 * sign * vector / norm * (1.0 if kind == "a" else -1j)
    both = np.concatenate([half, np.conj(half) if kind == "b" else half])
    name = f"{'ce' if kind == 'a' else 'se'}_{m}(z, {size:g})"
    return FloquetSolution(name, 0j, np.concatenate([harmonics, -harmonics]), both.astype(complex), math.pi, True)


def floquet_solutions(equation: Mathieu | MathieuAQ, *, per: str | None = None) -> tuple[FloquetSolution, ...]:
    """Return the Floquet solutions A(tau) = exp(mu tau) P(tau) of Mathieu's equation, the faster growing first.

    Two of them; one where both exponents are equal, on a transition curve: the other solutions are no Floquet
    solutions there (but with alpha = 0).  Each is scaled so that the squares of its coefficients add up to one, and is
    real where its multiplier is.  ``per`` is "tau", or "z" for the solutions, and exponents, of
    y'' + 2 k y' + (a - 2 q cos 2 z) y = 0 as functions of z, where tau = 2 z + pi / 2; by default the time of the
    equation.

    Returns
    -------
    tuple of FloquetSolution
        One or two.

    Raises
    ------
    TypeError
        For another equation.
    ValueError
        For abs(alpha) above 5e6, and for another ``per``.

    Examples
    --------
    >>> import floquetrod as fr
    >>> growing, decaying = floquet_solutions(fr.Mathieu(alpha=0.5, beta=-0.25))
    >>> f"{growing.exponent:.10f}", f"{decaying.exponent:.10f}"
    ('0.2267267672+0.5000000000j', '-0.2267267672+0.5000000000j')
    """
    require(equation, (Mathieu, MathieuAQ), "floquet_solutions")
    in_z = validate.choice("per", equation.time if per is None else per, ("tau", "z")) == "z"
    same: Mathieu = in_tau(equation)
    alpha, beta, damping = same.alpha, same.beta, same.damping
    validate.within("alpha", alpha, -0.5 * _LARGEST_Q, 0.5 * _LARGEST_Q)
    level = beta + damping**2  # of the equation with its damping removed
    of = repr(same)
    if in_z:
        of = f"y'' + (a - 2 q cos 2 z) y = 0, a = {0.0 - 4.0 * beta:.6g}, q = {2.0 * alpha:.6g}"
        of = of.replace("''", f"'' + {4.0 * damping:.6g} y'") if damping else of
    name, solutions = f"Floquet solution of {of}", []
    for exponent in dict.fromkeys(_constant_exponents(level) if alpha == 0.0 else exponents(alpha, level).tolist()):
        if alpha == 0.0:
            turns = float(round(exponent.imag))
            exponent, frequencies, vector = exponent - 1j * turns, np.array([2.0 * turns]), np.ones(1, dtype=complex)
        else:
            frequencies, vector = _null_vector(-4.0 * level, 2.0 * alpha, 2.0 * exponent)
            if not in_z:  # z is half of tau less a quarter of pi
                vector = vector * np.exp(-(2.0 * exponent + 1j * frequencies) * (0.25 * math.pi))
        rate = exponent - damping
        vector, is_real = _real_where_possible(exponent, frequencies, vector / np.linalg.norm(vector))
        if in_z:
            solutions.append(FloquetSolution(name, 2.0 * rate, frequencies, vector, math.pi, is_real))
        else:
            solutions.append(FloquetSolution(name, rate, 0.5 * frequencies, vector, 2.0 * math.pi, is_real))
    return tuple(solutions)


def _real_where_possible(exponent: complex, frequencies: Floats, vector: Complexes) -> tuple[Complexes, bool]:
    """Return coefficients of norm 1 in the phase in which the solution is real, and whether there is one.

    There is where the multiplier is real: exp(2 pi exponent), the imaginary part a half or a whole number; but not of
    exp(i tau / 2), say, alone.  Of a real solution coefficients of opposite frequencies are conjugate.
    """
    shift = 2.0 * exponent.imag
    if shift not in (-1.0, 0.0, 1.0) or frequencies[0] != -frequencies[-1]:
        return vector, False
    paired = vector if shift == 0.0 else vector[:-1] if shift > 0.0 else vector[1:]
    square = complex(paired @ paired[::-1])
    if abs(square) < 0.5:
        return vector, False
    return vector * cmath.exp(-0.5j * cmath.phase(square)), True


def _constant_exponents(level: float) -> tuple[complex, complex]:
    """Return the exponents of A'' = level A, their imaginary parts in full."""
    root = cmath.sqrt(level)
    return root, 0.0 - root


def _harmonics(value: float, q: float) -> int:
    """Return how many harmonics on either side carry all digits of a solution."""
    oscillating = 0.5 * math.sqrt(max(value + 2.0 * abs(q), 0.0))
    return math.ceil(oscillating + _BEYOND + 4.0 * math.sqrt(math.sqrt(abs(q))))


def _real_order(nu: float, q: float) -> tuple[float, float, Floats]:
    """Return lambda_nu(q), the shift of the frequencies, and the coefficients of me_nu, from -K to K."""
    from scipy.linalg import eigh_tridiagonal

    shift = nu - 2.0 * round(0.5 * nu)
    count = _harmonics(nu * nu + 2.0 * abs(q), q)
    frequencies = shift + 2.0 * np.arange(-count, count + 1)
    rank = int(np.count_nonzero(np.abs(frequencies) < abs(nu)))
    _, vectors = eigh_tridiagonal(frequencies**2, np.full(2 * count, q), select="i", select_range=(rank, rank))
    vector = vectors[:, 0]
    # Rayleigh's quotient: the eigenvalue itself is rounded like the largest square of a frequency.
    value = (frequencies**2 @ vector**2 + 2.0 * q * (vector[1:] @ vector[:-1])) / (vector @ vector)
    return float(value), shift, vector


def _periodic(m: int, q: float, kind: str, value: float) -> tuple[Floats, Floats]:
    """Return harmonics and coefficients of ce_m or se_m, DLMF 28.4."""
    first = (2 if kind == "b" else 0) if m % 2 == 0 else 1
    harmonics = np.asarray(first + 2.0 * np.arange(_harmonics(max(value, float(m * m)), q) + m // 2), dtype=np.float64)
    diagonal, off = harmonics**2, np.full(harmonics.size - 1, q)
    scale = np.ones(harmonics.size)
    if first == 1:
        diagonal[0] += q if kind == "a" else -q
    elif first == 0:
        off[0] *= math.sqrt(2.0)
        scale[0] = math.sqrt(0.5)  # of the symmetric matrix' vector
    vector = np.real(_inverse_iteration(off.astype(complex), (diagonal - value).astype(complex)))
    return harmonics, vector * scale


def _null_vector(a: float, q: float, exponent: complex) -> tuple[Floats, Complexes]:
    """Return frequencies and coefficients of exp(mu z) P(z): a + (mu + i s_k)^2 on the diagonal, -q beside it."""
    count = _harmonics(abs(a), q)
    frequencies = np.asarray(2.0 * np.arange(-count, count + 1), dtype=np.float64)
    diagonal = a + (exponent + 1j * frequencies) ** 2
    return frequencies, _inverse_iteration(np.full(2 * count, -q, dtype=complex), diagonal)


def _sign(kind: str, order: float, q: float, frequencies: Floats, vector: Floats) -> float:
    """Return the sign that continues cos(m z) or sin(m z) from q = 0.

    ce(0) and se'(0) are never zero and keep their signs.  Where q > 0 solutions of low order are exponentially small
    at 0 and large at pi / 2, where the value (the slope, if the solution is odd about pi / 2) is never zero either.
    """
    odd = kind == "b"
    if q > 0.0:
        vector = _seen_from_half_period(order, frequencies, vector)
        odd = (kind == "b") == (order % 2.0 == 0.0)
    return math.copysign(1.0, float(frequencies @ vector if odd else vector.sum()))


def _sign_of_me(nu: float, frequencies: Floats, vector: Floats) -> float:
    """Return the sign that continues exp(i nu z) from q = 0.

    About 0 and about pi / 2, me_nu is an even solution plus i times an odd one.  For orders that are not whole numbers
    neither is ever zero, so value and slope at both points keep their signs from q = 0.  Some of these four sums may
    be exponentially small: the sign is taken from the sum with the least cancellation.
    """
    sums = []
    for seen in (vector, _seen_from_half_period(nu, frequencies, vector)):
        for terms in (seen, math.copysign(1.0, nu) * frequencies * seen):
            sums.append(float(terms.sum()) / float(np.abs(terms).sum()))
    return math.copysign(1.0, max(sums, key=abs))


def _seen_from_half_period(order: float, frequencies: Floats, vector: Floats) -> Floats:
    """Return coefficients about pi / 2 up to a common factor: exp(i s pi / 2) = (-1)^k exp(i order pi / 2)."""
    turns = np.round(0.5 * (frequencies - order))
    return np.where(turns % 2.0 == 0.0, vector, -vector)


def _inverse_iteration(off: Any, diagonal: Any) -> Complexes:
    """Return the null vector of a symmetric tridiagonal matrix that is singular up to rounding."""
    from scipy.linalg import solve_banded

    bands = np.zeros((3, diagonal.size), dtype=complex)
    bands[0, 1:], bands[2, :-1] = off, off
    bands[1] = diagonal + 1e-15 * np.abs(diagonal).min() + 1e-290
    vector = np.ones(diagonal.size, dtype=complex)
    for _ in range(_SWEEPS):
        vector = solve_banded((1, 1), bands, vector)
        vector /= np.abs(vector).max()
    return np.asarray(vector / vector[np.argmax(np.abs(vector))])


def _without_tails(frequencies: Any, vector: Any) -> tuple[Floats, Floats]:
    """Leave out coefficients too small to matter."""
    kept = np.abs(vector) > 1e-20 * np.abs(vector).max()
    return frequencies[kept], vector[kept]
