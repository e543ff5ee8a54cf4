"""`fr.output_noise`: covariance over the period, and spectrum, of motion under noise beside the parametric force."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Complexes, Floats, shaped
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.result_report import Report, Reported
from floquetrod.equations import DelaySystem, Equation, HillSystem, PeriodicSystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.equations.hill_system import in_first_order, states
from floquetrod.equations.second_moments import MOST_UNKNOWNS, linear_moments
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.problems import Problem, require_problem
from floquetrod.floquet.references import NOISE, THEORY, references
from floquetrod.responses.forces import Force, force_of
from floquetrod.responses.harmonic_balance import balanced
from floquetrod.responses.hill_arrays import HillArrays, hill_arrays
from floquetrod.responses.methods import BY_NAME

WHITE = 1.0 / math.pi
"""One-sided density per radian per unit of time of white noise with E[xi(t) xi(u)] = delta(t - u)."""

_SMALL = 10  # second moments up to which Hill's matrix is solved for them (heuristic)
_INSTANTS = 64  # of the period
_FAR = 40.0  # frequencies of solutions beyond which a power series in 1 / w serves (a choice)
_ACCURACY = 1e-11
_ROUNDS, _MOST_INTERVALS = 40, 20_000
_CHUNK = 600


class _Rule(NamedTuple):
    """Kronrod's rule of 15 nodes from -1 to 1, and Gauss's of 7 of them."""

    nodes: Floats
    weights: Floats
    gauss: Floats


def _kronrod() -> _Rule:
    half = np.array([
        0.991455371120812639206854697526329, 0.949107912342758524526189684047851, 0.864864423359769072789712788640926,
        0.741531185599394439863864773280788, 0.586087235467691130294144691693013, 0.405845151377397166906606412076961,
        0.207784955007898467600689403773245,
    ])  # fmt: skip
    outer = np.array([
        0.022935322010529224963732008058970, 0.063092092629978553290700663189204, 0.104790010322250183839876322541518,
        0.140653259715525918745189590510238, 0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
        0.204432940075298892414161999234649,
    ])  # fmt: skip
    gauss = np.array([0.129484966168869693270611432679082, 0.279705391489276667901467771423780,
                      0.381830050505118944950369775488975])  # fmt: skip
    coarse = np.zeros(7)
    coarse[1::2] = gauss
    nodes = np.concatenate([-half, [0.0], half[::-1]])
    weights = np.concatenate([outer, [0.209482141084727828012999174891714], outer[::-1]])
    return _Rule(nodes, weights, np.concatenate([coarse, [0.417959183673469387755102040816327], coarse[::-1]]))


_RULE = _kronrod()


@dataclass(frozen=True, eq=False, repr=False)
class OutputNoise(ByContent, NoTruthValue, Reported):
    """The covariance of the coordinates under noise that is a force beside the parametric one, after a long time.

    Attributes
    ----------
    equation : Equation, HillSystem or PeriodicSystem
        The problem.
    sources : ndarray (n, r)
        B of the force B eta(t), eta r independent sources.
    method : str
        "lyapunov", the periodic Lyapunov equation, for white noise; or "transfer", the sum over transfer functions.
    period : float
        T, the period of the coefficients.
    error : float
        Estimate of the error of the covariance as a fraction of the largest variance.
    """

    ask = ".variance or .covariance"

    equation: Problem
    sources: Floats
    method: str
    period: float
    error: float
    _waves: Complexes = field(repr=False)  # (2 L + 1, n, n), of exp(i l W t), l from -L to L
    _density: Callable[[float], Any] | None = field(repr=False, compare=False)

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite, in plain text with DOI, floquetrod first, then the sources of the method."""
        return references(NOISE if self.method == "lyapunov" else (THEORY,))

    def covariance(self, time: Any) -> Any:
        """Return E[q q^T] at times, periodic: numbers for a scalar equation, else (n, n) in the last axes.

        Parameters
        ----------
        time : array_like
            Any times, in the unit of the equation.

        Returns
        -------
        float or ndarray
            In the shape of ``time``, of a system (..., n, n).

        Raises
        ------
        TypeError, ValueError
            For times other than finite numbers.
        """
        limit = 1e14 * self.period
        times = validate.array("time", time, least=-limit, largest=limit)
        most = len(self._waves) // 2
        turns = np.outer(times.ravel() / self.period % 1.0, np.arange(-most, most + 1))
        values = np.einsum("tl,lij->tij", np.exp(2j * math.pi * turns), self._waves).real
        if isinstance(self.equation, Equation):
            return shaped(values[:, 0, 0], times.shape)
        return shaped(values, (*times.shape, *values.shape[1:]))

    @property
    def variance(self) -> Any:
        """Mean over the period of E[q^2], a number, of a system (n,)."""
        means = np.diagonal(self._waves[len(self._waves) // 2].real).copy()
        return means.item() if isinstance(self.equation, Equation) else means

    @property
    def rms(self) -> Any:
        """Root of the mean variance, a number, of a system (n,)."""
        root = np.sqrt(np.maximum(np.atleast_1d(self.variance), 0.0))
        return root.item() if isinstance(self.equation, Equation) else root

    def density(self, frequency: Any, out: int = 0) -> Any:
        """Return the one-sided spectral density of a coordinate, averaged over the period, at frequencies w.

        Its integral from 0 on is the mean variance.  Per radian per unit of time: 2 pi times it is that per turn.

        Parameters
        ----------
        frequency : array_like
            w, zero or more, in radians per unit of time.
        out : int
            The coordinate, from 0.

        Returns
        -------
        float or ndarray
            In the shape of ``frequency``.

        Raises
        ------
        TypeError, ValueError
            For negative frequencies, a coordinate that is not there, and an equation given in pieces.
        """
        largest = 1e9 / self.period
        w = validate.array("frequency", frequency, least=0.0, largest=largest)
        target = validate.integer("out", out, 0, self.sources.shape[0] - 1)
        if not self._smooth:
            raise TypeError("equation must be one Fourier series for a spectral density, got one of several pieces")
        arrays, turn = hill_arrays(self.equation), 2.0 * math.pi / self.period
        most = math.ceil(3.0 * float(arrays.reach[0]) / turn) + 12
        flat, shifts = w.ravel(), np.arange(-most, most + 1)
        inputs = flat[:, None] - shifts * turn
        total = np.zeros(inputs.shape)
        for column in self.sources.T:
            values = _amplitudes(arrays, column, inputs.ravel())
            middle = values.shape[1] // 2
            for j, k in enumerate(shifts.tolist()):
                if abs(k) <= middle:
                    total[:, j] += np.abs(values[j :: len(shifts), middle + k, target]) ** 2
        return shaped((total * _densities(self._density, np.abs(inputs))).sum(axis=1), w.shape)

    @property
    def _smooth(self) -> bool:
        return BY_NAME["hill"].refusal(self.equation, force_of(self.equation, np.zeros(len(self.sources)))) is None

    def plot(self, ax: Any = None) -> Any:
        """Draw the variances over a period, and their means, on ``ax`` or on new axes.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.

        Examples
        --------
        >>> import floquetrod as fr
        >>> fr.output_noise(fr.Mathieu(0.3, -0.6, 0.1), 1.0).plot().get_ylabel()
        'variance'
        """
        from floquetrod.plotting.response_plot import draw_variance

        return draw_variance(self, ax)

    def report(self) -> Report:
        """Return the variance, its extremes over the period, and the method."""
        times = np.linspace(0.0, self.period, 257)
        whole = np.asarray(self.covariance(times)).reshape(len(times), len(self.sources), -1)
        variances = np.diagonal(whole, axis1=1, axis2=2)
        lines = [
            ("equation", repr(self.equation)),
            ("noise", "white, the same density at all frequencies" if self._density is None else "of a given density"),
        ]
        for i, row in enumerate(variances.T[:6]):
            lines.append(("variance", f"{_mean(self.variance, i):.6g}, from {row.min():.6g} to {row.max():.6g}"))
        lines.append(("method", f"{self.method}, error {self.error:.1g} of the largest variance"))
        return Report(f"rms {', '.join(f'{value:.6g}' for value in np.atleast_1d(self.rms)[:6])}", lines)

    def as_dict(self) -> dict[str, Any]:
        """Return the covariance at 64 instants, and its mean, as numbers for JSON."""
        times = np.arange(_INSTANTS) * (self.period / _INSTANTS)
        return {
            "method": self.method,
            "period": self.period,
            "variance": np.asarray(self.variance).tolist(),
            "time": times.tolist(),
            "covariance": np.asarray(self.covariance(times)).tolist(),
            "error": self.error,
        }

    def __repr__(self) -> str:
        """Return the rms as a sentence."""
        return f"<noise: rms {', '.join(f'{v:.6g}' for v in np.atleast_1d(self.rms)[:6])}; {self.method}>"


def _mean(variance: Any, i: int) -> float:
    return float(np.atleast_1d(variance)[i])


def output_noise(
    equation: Problem,
    intensity: Any,
    *,
    density: Callable[[float], float] | None = None,
    method: str = "auto",
) -> OutputNoise:
    """Return the covariance of the motion under additive noise: a random force on the right-hand side.

    Of M q'' + (C + G) q' + K(t) q = B eta(t), of x' = A(t) x + B eta and of A'' + 2 c A' = p A + s eta.  It changes no
    verdict on stability.  Noise *in the coefficients* does: the argument ``noise`` of `floquetrod.stability`, of
    `AxialLoad` and of `floquetrod.second_moments`.

    Parameters
    ----------
    equation : Equation, HillSystem or PeriodicSystem
        A problem whose free motion decays.
    intensity : float, array_like (n,) or (n, r)
        B: s of a scalar equation; of a system one intensity for each coordinate, each with its own source, or a matrix
        with a column for each source.
    density : callable (w) -> float, optional
        One-sided spectral density of every source, per radian per unit of time: the mean square of eta is its integral
        from 0 on.  By default white noise, E[eta(t) eta(u)] = delta(t - u), whose density is 1 / pi.
    method : {"auto", "lyapunov", "transfer"}
        The periodic Lyapunov equation P' = A P + P A^T + B B^T, for white noise; or the integral over all frequencies
        of the sum over harmonic transfer functions, for coefficients that are Fourier series.

    Returns
    -------
    OutputNoise

    Raises
    ------
    TypeError, ValueError
        For intensities that do not fit, for systems with delays, for free motion that does not decay, and for densities
        that are negative or not finite.

    Examples
    --------
    Without forcing the variance of A'' + 2 c A' + w^2 A = s xi is s^2 / (4 c w^2):

    >>> import floquetrod as fr
    >>> found = fr.output_noise(fr.Mathieu(alpha=0.0, beta=-4.0, damping=0.1), 0.5)
    >>> round(found.variance, 12), round(fr.output_noise(found.equation, 0.5, method="transfer").variance, 9)
    (0.15625, 0.15625)
    """
    require_problem(equation)
    if isinstance(equation, DelaySystem):
        raise TypeError("equation must be without delays for output noise, got a DelaySystem")
    n = 1 if isinstance(equation, Equation) else equation.order
    silent = force_of(equation, np.zeros(n))
    sources = _sources(intensity, n)
    if density is not None:
        validate.function("density", density)
    method = validate.choice("method", method, ("auto", "lyapunov", "transfer"))
    name = ("lyapunov" if density is None else "transfer") if method == "auto" else method
    if name == "lyapunov" and density is not None:
        raise TypeError("density is of noise that is not white, for method='transfer'")
    if name == "transfer" and (refused := BY_NAME["hill"].refusal(equation, silent)):
        raise TypeError(refused.replace("method='hill'", "method='transfer'"))
    verdict = stability(equation)
    if not verdict.decay_rate > 0.0:
        raise ValueError(
            f"equation must have free motion that decays, or the variance grows without bound, got one that is "
            f"{verdict.status} and decays at {verdict.decay_rate:g}"
        )
    waves, error = (
        _by_lyapunov(equation, sources) if name == "lyapunov" else _by_transfer(equation, sources, density, verdict)
    )
    return OutputNoise(equation, sources, name, float(equation.period), error, waves, density)


def _sources(intensity: Any, n: int) -> Floats:
    """Return B (n, r)."""
    array = validate.array("intensity", intensity)
    if n == 1 and array.shape in ((), (1,)):
        array = array.reshape(1, 1)
    elif array.shape == (n,):
        array = np.diag(array)
    if array.ndim != 2 or len(array) != n or not array.shape[1]:
        wanted = "one number" if n == 1 else f"{n} numbers, or a matrix of {n} rows"
        raise ValueError(f"intensity must be {wanted}, got shape {np.shape(intensity)}")
    return np.array(array, dtype=float)


def _by_lyapunov(equation: Any, sources: Floats) -> tuple[Complexes, float]:
    """Return the harmonics of the covariance from the response of second moments to the constant force B B^T."""
    system = equation.as_system() if isinstance(equation, Equation) else equation
    if states(system) > MOST_UNKNOWNS:
        raise ValueError(f"equation must have at most {MOST_UNKNOWNS} equations of first order, got {states(system)}")
    first, n = in_first_order(system), system.order
    into, back = np.eye(n), np.eye(n)
    if isinstance(system, HillSystem) and system.mass is not None:
        into = np.linalg.inv(np.linalg.cholesky(system.mass))
        back = into.T
    driving = np.zeros((first.order, sources.shape[1]))
    driving[first.order - n :] = into @ sources
    size = first.order
    upper = np.triu_indices(size)
    error = 2.0 * first.coefficient_error
    moments = by_pieces.mapped(PeriodicSystem, first, linear_moments, linear_moments, coefficient_error=error)
    constant = (driving @ driving.T)[upper].astype(complex)
    force = Force(None, constant, np.zeros((0, len(constant)), dtype=complex))
    hill = moments.is_smooth and len(constant) <= _SMALL
    with np.errstate(all="ignore"):
        motion, relative = BY_NAME["hill" if hill else "monodromy"].call(moments, force)
    values = np.zeros((len(motion.amplitudes), size, size), dtype=complex)
    values[:, upper[0], upper[1]] = motion.amplitudes
    values[:, upper[1], upper[0]] = motion.amplitudes
    covariance: Any = back @ values[:, :n, :n] @ back.T
    inner = float(np.abs(motion.amplitudes).max(initial=0.0))
    outer = float(np.abs(np.diagonal(covariance, axis1=1, axis2=2)).max(initial=0.0))
    return covariance, relative if hill or not outer else relative * max(1.0, inner / outer)


def _densities(density: Callable[[float], Any] | None, frequencies: Floats) -> Floats:
    """Return the density of the sources at frequencies, zero or more, checked."""
    if density is None:
        return np.full(frequencies.shape, WHITE)
    values = [validate.nonnegative(f"density({w:g})", density(w)) for w in frequencies.ravel().tolist()]
    return np.array(values).reshape(frequencies.shape)


def _amplitudes(arrays: HillArrays, column: Floats, frequencies: Floats) -> Complexes:
    """Return the amplitudes (m, 2 K + 1, n) of one source at frequencies."""
    force = np.broadcast_to(column.astype(complex), (len(frequencies), 1, len(column)))
    return balanced(arrays, np.ascontiguousarray(force), frequencies).values


def _by_transfer(
    equation: Any, sources: Floats, density: Callable[[float], Any] | None, verdict: Any
) -> tuple[Complexes, float]:
    """Return the harmonics of the covariance by the integral over frequencies, with an estimate of its error."""
    arrays = hill_arrays(equation)
    period, n = float(equation.period), len(sources)
    power = 4 if arrays.mass.any() else 2
    far = _FAR * max(float(arrays.reach[0]), 2.0 * math.pi / period)
    edges = _edges(verdict, period, far)
    total = np.zeros((_INSTANTS, n, n))
    error, low, high = 0.0, edges[:-1], edges[1:]
    for _ in range(_ROUNDS):
        if not len(low):
            break
        fine, coarse = _integrals(arrays, sources, density, low, high)
        gaps = np.abs(fine - coarse).max(axis=(1, 2, 3))
        size = max(float(np.abs(total + fine.sum(axis=0)).max()), 1e-300)
        done = gaps <= _ACCURACY * size * np.maximum((high - low) / far, 1.0 / len(edges))
        total += fine[done].sum(axis=0)
        error += float(gaps[done].sum())
        middle = 0.5 * (low + high)[~done]
        low, high = np.concatenate([low[~done], middle]), np.concatenate([middle, high[~done]])
        if len(low) > _MOST_INTERVALS:
            break
    if len(low):
        raise ValueError(
            "density must be smooth, or equation damped more: the integral over frequencies did not converge"
        )
    tail, doubt = _beyond(arrays, sources, density, far, power)
    total += tail
    size = float(np.abs(total).max()) or 1.0
    waves = np.fft.fft(total, axis=0) / _INSTANTS
    most = _INSTANTS // 2 - 1
    waves = np.concatenate([waves[-most:], waves[: most + 1]])
    unresolved = float(np.abs(waves[:2]).max() + np.abs(waves[-2:]).max())
    return waves, (error + doubt + 4.0 * unresolved) / size + 1e-12


def _edges(verdict: Any, period: float, far: float) -> Floats:
    """Return where intervals of the first round end: about the resonances, which are as wide as motion decays fast."""
    turn = 2.0 * math.pi / period
    points = {0.0, far, *np.geomspace(far / 256.0, far, 9)[:-1].tolist()}
    for exponent in verdict.exponents:
        for j in range(-4, 5):
            centre, width = abs(exponent.imag + j * turn), max(abs(exponent.real), 1e-12)
            points |= {w for s in (-30.0, -4.0, 0.0, 4.0, 30.0) if 0.0 < (w := centre + s * width) < far}
    edges = np.array(sorted(points))
    return np.asarray(edges[np.concatenate([[True], np.diff(edges) > 1e-12 * far])])


def _integrals(
    arrays: HillArrays, sources: Floats, density: Callable[[float], Any] | None, low: Floats, high: Floats
) -> tuple[Floats, Floats]:
    """Return the integrals over intervals (intervals, instants, n, n) by both rules."""
    half = 0.5 * (high - low)
    nodes = (low + half)[:, None] + half[:, None] * _RULE.nodes
    values = _squares(arrays, sources, density, nodes.ravel()).reshape(*nodes.shape, _INSTANTS, *(2 * [len(sources)]))
    fine, coarse = (np.einsum("j,ijtab->itab", w, values) * half[:, None, None, None] for w in _RULE[1:])
    return fine, coarse


def _squares(
    arrays: HillArrays, sources: Floats, density: Callable[[float], Any] | None, frequencies: Floats
) -> Floats:
    """Return Re(u u^*) (m, instants, n, n) at instants of the period, times the density, summed over sources."""
    n = len(sources)
    result = np.empty((len(frequencies), _INSTANTS, n, n))
    weights = _densities(density, frequencies)
    order = np.argsort(frequencies, kind="stable")
    for start in range(0, len(order), _CHUNK):
        chosen = order[start : start + _CHUNK]
        total = np.zeros((len(chosen), _INSTANTS, n, n))
        for column in sources.T:
            values = _amplitudes(arrays, column, frequencies[chosen])
            most = values.shape[1] // 2
            turns = np.exp(2j * math.pi / _INSTANTS * np.outer(np.arange(_INSTANTS), np.arange(-most, most + 1)))
            motion = turns @ values
            total += np.einsum("mta,mtb->mtab", motion, motion.conj()).real
        result[chosen] = total * weights[chosen][:, None, None, None]
    return result


def _beyond(
    arrays: HillArrays, sources: Floats, density: Callable[[float], Any] | None, far: float, power: int
) -> tuple[Floats, float]:
    """Return the integral beyond a frequency, from a power series in 1 / w of the squares, and its doubt."""
    places = far * np.array([1.0, 1.25, 1.6, 2.0])
    plain = _squares(arrays, sources, None, places) / WHITE * places[:, None, None, None] ** power
    series = np.linalg.solve(np.vander(far / places, 4, increasing=True), plain.reshape(4, -1))
    nodes, weights = np.polynomial.legendre.leggauss(40)
    share = 0.5 * (nodes + 1.0)  # far / w
    strengths = _densities(density, far / share) * 0.5 * weights * share ** (power - 2) / far ** (power - 1)
    moments = np.vander(share, 4, increasing=True).T @ strengths
    tail = (moments @ series).reshape(plain.shape[1:])
    return tail, float(np.abs(moments[-1] * series[-1]).max())
