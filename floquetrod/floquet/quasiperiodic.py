"""Two incommensurate frequencies: growth as the limit of periodic approximants.

With coefficients of the frequencies w_1 and w_2 the maps over a period of the first depend on the phase y of the
second, and y advances by 2 pi phi from one period to the next, phi = w_2 / w_1.  Where phi is replaced by a fraction
p / q the maps repeat after q periods.  Growth depends smoothly on the fraction inside a tongue: a polynomial in
p / q - phi through the last fractions, at 0, is the answer, and its change from one fraction to the next the error.
Next to an edge growth is no smooth function of the fraction, and the error says so.  A tongue about phi that no
fraction meets is narrower than their distance from phi, and so is the growth in it: where no approximant grows, the
error is w_1 abs(p / q - phi).  Where that leaves a verdict open the norms of products of a few maps, at all phases,
bound growth from above: beside damping a weak second frequency is harmless, however near the ratio is to a fraction.

Maps over the phase are a Fourier series, from maps at equally spaced phases: all fractions share it.

Where A(t) and the matrices of the second frequency are skew-Hermitian, entry by entry, every solution keeps its norm:
the rate is 0, without approximants.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import EPS, Bools, Complexes, Floats
from floquetrod._util.compilation import over_chunks
from floquetrod.equations import Equation, HillSystem, PeriodicSystem, TwoFrequencies
from floquetrod.equations.complex_form import real_matrix
from floquetrod.equations.matrices import mass_matrix, velocity_matrix
from floquetrod.floquet.kernels.phase_maps import modulated_maps_fill, orbit_products_fill, phase_maps_fill
from floquetrod.floquet.status import STABLE, UNDECIDED, UNSTABLE, Status

_FIRST = 4  # smallest denominator that counts: of smaller ones the polynomial is not one yet (a choice)
_DEGREE = 3  # of the polynomial at most
_SHARE = 1e-7  # error over the growth, or the tolerance, at which it is enough (a choice)
_FACTOR = 2.0  # error over the change from the fraction before (a choice)
_LONGEST = 2000  # denominator at most
_MOST = 144  # denominator at most, by default
_ACCURACY = 1e-11  # last terms of the series of a step, relative to the map (a choice)
_FEW_PHASES, _MOST_PHASES = 24, 768  # of the maps over a period
_NEGLIGIBLE = 1e-10  # last harmonics of the maps over the phase, relative (a choice)
_ROUNDED = 8.0 * EPS  # of a ratio, up to which it is a fraction: both frequencies are rounded
_SEVERAL = 4  # equations, from which waves of few matrices are found (a choice)
_LAGS = 9.5  # products of a power of a series, on average
_WORTH = 0.7  # of the work, at most, that is done where they share it (a choice)
_SECONDS_PER_PRODUCT = 1.5e-7  # in a period, for each unit of the fastest rate (measured)
_PHASES, _PERIODS = 64, 64  # of the second frequency, and of the first, at which growth is bounded (a choice)
_AT_ONCE = 2048  # problems whose growth is bounded together, some 10 MB of maps (a choice)
_FLAT = 1e-6  # logarithm of a multiplier up to which an approximant does not grow: the root of the rounding (a choice)


class QuasiperiodicGrowth(NamedTuple):
    """The growth of solutions under two frequencies, from periodic approximants.

    Attributes
    ----------
    rate : float
        Largest rate of growth per unit of time, the Lyapunov exponent; negative where solutions decay.
    error : float
        Estimate: twice the change from one fraction to the next, and the error of the exponents; the distance to
        the farther of two bounds of the growth where these decide that it is below the tolerance; 0 where every
        solution keeps its norm.
    tolerance : float
        Growth per unit of time up to which it counts as none.
    approximants : tuple of (Fraction, float)
        Fractions p / q in place of the ratio of the frequencies, and the growth rate with each; none where every
        solution keeps its norm.
    """

    rate: float
    error: float
    tolerance: float
    approximants: tuple[tuple[Fraction, float], ...]

    @property
    def status(self) -> Status:
        """Unstable where it grows faster than the tolerance, stable where it does not.

        Tongues are everywhere: where growth is below the tolerance, a thinner one may be there.  Only where every
        solution keeps its norm, ``error`` 0, does nothing grow at all.
        """
        if self.rate - self.error > self.tolerance:
            return "unstable"
        return "stable" if self.rate + self.error <= self.tolerance else "undecided"

    def __repr__(self) -> str:
        """Return the answer as a sentence."""
        if self.error == 0.0:
            return "<keeps its norm: nothing grows>"
        ratio = self.approximants[-1][0] if self.approximants else None
        bounded = f"does not grow faster than {self.tolerance:.3g}"
        words = {
            "unstable": f"grows at {self.rate:.9g} +- {self.error:.1g} per unit of time",
            "stable": f"{bounded if self.rate + self.error >= 0.0 else self._decay} per unit of time",
            "undecided": f"growth {self.rate:.3g} +- {self.error:.1g} per unit of time, tolerance {self.tolerance:.3g}"
            f"{self._more}",
        }[self.status]
        return f"<{words}; ratio of frequencies taken as {ratio}>"

    @property
    def _more(self) -> str:
        """The largest denominator whose error would decide, if it falls like the square of the denominator."""
        apart = abs(self.tolerance - self.rate)
        if not self.approximants or not 0.0 < self.error < math.inf or not apart > 0.0:
            return ""
        denominator = self.approximants[-1][0].denominator * math.sqrt(2.0 * self.error / apart)
        most = math.ceil(2.0 * denominator)  # the next fraction of the golden ratio has 1.6 times the denominator
        return f"; try most={most}" if most <= _LONGEST else f"; most={_LONGEST} may not decide, try another tolerance"

    @property
    def _decay(self) -> str:
        """How fast solutions decay, to the second digit of the error."""
        digits = math.ceil(math.log10(-self.rate / self.error)) + 2
        return f"decays at {-self.rate:.{min(max(digits, 2), 9)}g} +- {self.error:.2g}"


def quasiperiodic_growth(
    equation: TwoFrequencies, *, tolerance: float = 1e-4, most: int = _MOST
) -> QuasiperiodicGrowth:
    """Return how fast solutions grow whose coefficients have two incommensurate frequencies.

    Parameters
    ----------
    equation : TwoFrequencies
        An equation or a system with a second frequency.
    tolerance : float
        Growth rate per unit of time up to which solutions count as not growing, greater than 0.
    most : int
        Largest denominator q of a fraction, 10 to 2,000: the error where nothing grows falls like its square.

    Returns
    -------
    QuasiperiodicGrowth
        Rate, its estimated error, and the approximants.  Where the frequencies are commensurate, with a denominator
        that small, the last approximant is exact, for the phases given; elsewhere phases do not matter.  Where A(t)
        and the second matrices are skew-Hermitian every solution keeps its norm: rate and error are 0.

    Raises
    ------
    TypeError, ValueError
        For anything else, and tolerances of zero.

    Notes
    -----
    A. Ya. Gordon's and Y. Last's periodic approximants; the Lyapunov exponent is continuous in the frequency where
    coefficients are analytic (J. Bourgain and S. Jitomirskaya, J. Stat. Phys. 108 (2002) 1203,
    DOI 10.1023/A:1019751801035).

    Examples
    --------
    x'' + (1/4 + 0.2 cos t + 0.2 cos(phi t)) x = 0, phi the golden ratio:

    >>> import floquetrod as fr
    >>> golden = (1.0 + math.sqrt(5.0)) / 2.0
    >>> fr.quasiperiodic_growth(fr.TwoFrequencies(fr.Hill(-0.25, cosines=(-0.2,)), golden, cosines=(-0.2,)))
    <grows at 0.09813918... +- ... per unit of time; ratio of frequencies taken as ...>
    """
    validate.instance("equation", equation, TwoFrequencies, "give fr.TwoFrequencies(equation, frequency, cosines=...)")
    tolerance = require_tolerance("tolerance", tolerance)
    most = validate.integer("most", most, 10, _LONGEST)
    return growth_of_many([equation], tolerance, most).single(0)


def require_tolerance(name: str, value: Any) -> float:
    """Return a growth rate that counts as none, greater than zero."""
    hint = "give a small one such as 1e-3: 0 has no answer under two frequencies, tongues are everywhere"
    return validate.positive(name, value, hint)


class ManyGrowths(NamedTuple):
    """Growth rates of many problems with two frequencies, and their errors, per unit of time.

    Attributes
    ----------
    rate, error : ndarray (b,)
        As of `QuasiperiodicGrowth`; an infinite error where nothing is known.
    tolerance : ndarray (b,)
        Growth per unit of time up to which it counts as none.
    fractions : list of list of Fraction
        Of each problem, those used.
    values : ndarray (b, r)
        Growth with each.
    """

    rate: Floats
    error: Floats
    tolerance: Floats
    fractions: list[list[Fraction]]
    values: Floats

    @property
    def status(self) -> NDArray[np.int8]:
        """1 where growth is at most the tolerance, 0 where it is more, -1 where that is undecided."""
        status = np.full(self.rate.shape, UNDECIDED, dtype=np.int8)
        with np.errstate(invalid="ignore"):
            status[self.rate - self.error > self.tolerance] = UNSTABLE
            status[self.rate + self.error <= self.tolerance] = STABLE
        return status

    def single(self, i: int) -> QuasiperiodicGrowth:
        """Return one of them."""
        approximants = tuple(zip(self.fractions[i], self.values[i].tolist(), strict=False))
        return QuasiperiodicGrowth(float(self.rate[i]), float(self.error[i]), float(self.tolerance[i]), approximants)


def growth_of_many(
    problems: Sequence[TwoFrequencies],
    tolerance: Any,
    most: int = _MOST,
    *,
    precise: bool = True,
    workers: int | None = None,
) -> ManyGrowths:
    """Return the growth of each problem; unless ``precise``, with as many fractions as the verdict needs.

    The tolerance is one number, or of each problem (b,).
    """
    count = len(problems)
    tolerance = np.broadcast_to(np.asarray(tolerance, dtype=float), (count,))
    ratio = np.array([problem.frequency / problem.first for problem in problems])
    first = np.array([problem.first for problem in problems])
    listed = {value: list(_fractions(value, most)) for value in set(ratio.tolist())}
    apart = {value: [float(each - Fraction(value)) for each in listed[value]] for value in listed}
    fractions = [listed[value] for value in ratio.tolist()]
    longest = max(map(len, fractions), default=0)
    left = np.array([not _keeps_norm(problem) for problem in problems], dtype=np.bool_)
    series, map_errors = _phase_series(problems, ratio, left, workers)
    x, values = np.full((count, longest), np.nan), np.full((count, longest), np.nan)
    counted, flat = np.zeros((count, longest), dtype=np.bool_), np.zeros((count, longest), dtype=np.bool_)
    rate, error = np.where(left, np.nan, 0.0), np.where(left, np.inf, 0.0)
    used = np.zeros(count, dtype=np.intp)
    for k in range(longest):
        here = np.flatnonzero(left & np.array([len(each) > k for each in fractions]))
        if not here.size:
            break
        chosen = [fractions[i][k] for i in here]
        q = np.array([each.denominator for each in chosen])
        logarithm, relative = _logarithms(series, map_errors, here, chosen, workers)
        values[here, k] = logarithm * first[here] / (2.0 * math.pi * q)
        flat[here, k] = logarithm < _FLAT
        counted[here, k] = q >= _FIRST
        x[here, k] = [apart[value][k] for value in ratio[here].tolist()]
        rate[here] = _at_zero(x[here, : k + 1], values[here, : k + 1], counted[here, : k + 1])
        change = np.full(here.size, np.inf)
        if k:
            change = np.abs(rate[here] - _at_zero(x[here, :k], values[here, :k], counted[here, :k]))
        recent = flat[here, max(0, k - _DEGREE) : k + 1].any(axis=1)
        distance = np.abs(x[here, k])
        change = np.where(recent, np.maximum(change, first[here] * distance), change)
        exact = distance <= _ROUNDED * ratio[here]
        rate[here] = np.where(exact, values[here, k], rate[here])
        change = np.where(exact, 0.0, change)
        # Next to an edge a multiplier is about 1 + sqrt(x), x off by the relative error e of the product, so that its
        # logarithm l is off by about e / l, at most by the root of e.
        relative = np.maximum(relative, _FLAT**2)
        slip = relative / np.clip(np.where(recent, 0.0, logarithm), np.sqrt(relative), 1.0)
        error[here] = _FACTOR * change + np.where(relative < 1.0, slip, np.inf) * first[here] / (2.0 * math.pi * q)
        error[here[np.isnan(rate[here])]] = np.inf
        used[here] = k + 1
        enough = error[here] < _SHARE * np.maximum(np.abs(rate[here]), tolerance[here]) if precise else True
        decided = np.abs(rate[here] - tolerance[here]) > error[here]
        left[here] &= ~((k >= _DEGREE) & decided & enough & (counted[here, : k + 1].sum(axis=1) > _DEGREE))
    unsure = np.flatnonzero(np.abs(rate - tolerance) <= error)
    low, high = _growth_bounds(series, map_errors, unsure, (ratio, first, tolerance), precise)
    low, high = np.fmax(low, rate[unsure] - error[unsure]), np.fmin(high, rate[unsure] + error[unsure])
    # The rate of approximants stays, between the bounds, unless its error to the farther one would reach the tolerance.
    near = np.clip(rate[unsure], low, high)
    near = np.where(near + np.maximum(high - near, near - low) < tolerance[unsure], near, 0.5 * (low + high))
    within = high < tolerance[unsure]
    rate[unsure[within]], error[unsure[within]] = near[within], np.maximum(high - near, near - low)[within]
    return ManyGrowths(rate, error, tolerance, [f[:n] for f, n in zip(fractions, used, strict=True)], values)


def _at_zero(x: Floats, values: Floats, counted: Bools) -> Floats:
    """Return polynomials through the last values that count (b, k), at x = 0, by Neville's scheme.

    Of none that counts, the last value.
    """
    x, values, counted = x[:, -_DEGREE - 1 :], values[:, -_DEGREE - 1 :].copy(), counted[:, -_DEGREE - 1 :]
    for step in range(1, x.shape[1]):
        for i in range(x.shape[1] - step):
            apart = x[:, i + step] - x[:, i]
            with np.errstate(divide="ignore", invalid="ignore"):
                joined = (x[:, i + step] * values[:, i] - x[:, i] * values[:, i + 1]) / apart
            values[:, i] = np.where(counted[:, i] & (apart != 0.0), joined, values[:, i + 1])
    return np.asarray(values[:, 0])


def _keeps_norm(problem: TwoFrequencies) -> bool:
    """Return whether A(t) and the matrices of the second frequency are skew-Hermitian, entry by entry."""
    subject = problem.equation
    second = [*problem.cosines, *problem.sines]
    return isinstance(subject, PeriodicSystem) and subject.keeps_norm and all((a == -a.conj().T).all() for a in second)


class _FirstOrder(NamedTuple):
    """x' = A x in time scaled to a first frequency of 1: mean (N, N), waves (2, H, N, N) of both frequencies.

    Waves have rows from ``top`` and columns below ``right`` alone.
    """

    mean: Floats
    own: Floats
    second: Floats
    top: int
    right: int
    few: _FewShapes | None = None


class _FewShapes(NamedTuple):
    """Waves of few matrices: these (R, rows, columns), and factors (2, H, R, 1) of the waves of both frequencies."""

    shapes: Floats
    own: Floats
    second: Floats

    @classmethod
    def of(cls, own: Floats, second: Floats) -> _FewShapes | None:
        """Return the waves (2, H, n, n) so, to rounding; None where that takes no less time."""
        shapes: list[Floats] = []
        factors = [np.zeros((2, waves.shape[1], own.shape[-1])) for waves in (own, second)]
        for waves, part in zip((own, second), factors, strict=True):
            for at in np.ndindex(*waves.shape[:2]):
                wave = waves[at]
                if not wave.any():
                    continue
                for which, shape in enumerate(shapes):
                    factor = float((wave * shape).sum() / (shape * shape).sum())
                    if np.abs(wave - factor * shape).max() <= _ROUNDED * np.abs(wave).max():
                        part[*at, which] = factor
                        break
                else:
                    if (len(shapes) + 1) * (_LAGS + own.shape[-1]) > _WORTH * _LAGS * own.shape[-1]:
                        return None
                    part[*at, len(shapes)] = 1.0
                    shapes.append(wave)
        if not shapes:
            return None
        return cls(np.array(shapes), *(part[..., : len(shapes), None] for part in factors))


def _first_order(problem: TwoFrequencies) -> _FirstOrder:
    """Return a problem in first order, velocities over the root of the largest stiffness."""
    subject: Any = problem.equation
    second = _side_by_side(problem.cosines, problem.sines, problem.order)
    if not isinstance(subject, Equation | HillSystem):
        if subject.is_complex or second.dtype.kind == "c":
            subject, second = subject.doubled, real_matrix(second)
        own = _side_by_side(subject.cosines, subject.sines, subject.order)
        mean, own, second = (each / problem.first for each in (subject.mean, own, second))
        return _FirstOrder(mean, own, second, 0, subject.order)
    n, few = problem.order, None
    if isinstance(subject, Equation):
        piece = subject.pieces()[0]
        harmonics = np.array(piece.harmonics, dtype=complex).reshape(-1, 1, 1)
        force, own = np.array([[float(piece.start)]]), np.stack([harmonics.real, -harmonics.imag])
        drag = np.array([[-2.0 * subject.damping]])
    else:
        inverse = np.linalg.inv(mass_matrix(subject))
        drag = -inverse @ velocity_matrix(subject)
        own = -inverse @ _side_by_side(subject.cosines, subject.sines, n)
        force, second = -inverse @ subject.stiffness, -inverse @ second
        if n >= _SEVERAL and subject.mass is None and (force == force.T).all():
            # In the modes of the mean stiffness most of the matrix is zero.
            rates, modes = np.linalg.eigh(force)
            drag, own, second = (modes.T @ each @ modes for each in (drag, own, second))
            force = np.diag(rates)
            few = _FewShapes.of(own, second)
    strongest = sum(float(np.abs(each).sum(axis=-1).max(initial=0.0)) for each in (force, own, second))
    scale = math.sqrt(strongest) or 1.0

    def lower(block: Floats) -> Floats:
        whole = np.zeros((*block.shape[:-2], 2 * n, 2 * n))
        whole[..., n:, :n] = block / (scale * problem.first)
        return whole

    mean = lower(force)
    mean[:n, n:], mean[n:, n:] = np.eye(n) * (scale / problem.first), drag / problem.first
    form = _FirstOrder(mean, lower(own), lower(second), n, n)
    return form if few is None else form._replace(few=few._replace(shapes=few.shapes / (scale * problem.first)))


def seconds_of_maps(problem: TwoFrequencies) -> float:
    """Return about how long the maps of a system of second order take, which is most of the time of its growth."""
    fastest = max(float(np.abs(_first_order(problem).mean).sum(axis=1).max()), 1.0, problem.frequency / problem.first)
    n = problem.order
    return _SECONDS_PER_PRODUCT * _FEW_PHASES * fastest * (_LAGS + n) * 2 * n * n


def _side_by_side(cosines: Sequence[Any], sines: Sequence[Any], order: int) -> NDArray[Any]:
    """Return two lists of matrices, the shorter one filled up with zeros, (2, H, n, n)."""
    series = np.zeros((2, max(len(cosines), len(sines)), order, order), dtype=np.result_type(0.0, *cosines, *sines))
    for row, values in zip(series, (cosines, sines), strict=True):
        for k, value in enumerate(values):
            row[k] = value
    return series


def _phase_series(
    problems: Sequence[TwoFrequencies], ratio: Floats, wanted: Bools, workers: int | None
) -> tuple[list[Complexes], Floats]:
    """Return the maps over a period of the first frequency, Fourier series (K, N, N) in the phase, and their errors.

    The errors (b,), of the largest entry at any phase, are of the last harmonics and of rounding.  A series is empty
    where it is not ``wanted`` (b,), where it needs more than `_MOST_PHASES` harmonics, and where the maps overflow.
    """
    forms = [_first_order(problem) for problem in problems]
    series: list[Complexes] = [np.zeros((0, *form.mean.shape), dtype=complex) for form in forms]
    errors = np.full(len(forms), np.inf)
    groups: dict[tuple[int, int, int], list[int]] = {}
    for i in np.flatnonzero(wanted).tolist():
        few = forms[i].few
        groups.setdefault((len(forms[i].mean), forms[i].top, 0 if few is None else len(few.shapes)), []).append(i)
    for (n, top, shapes), members in groups.items():
        phases, left = _FEW_PHASES, np.array(members)
        while left.size and phases <= _MOST_PHASES:
            out = np.empty((left.size, phases * n * n + 1))
            holders: list[Any] = [forms[i].few if shapes else forms[i] for i in left]
            waves = (_padded([getattr(each, name) for each in holders]) for name in ("own", "second"))
            inputs = [np.array([forms[i].mean for i in left]), *waves, ratio[left]]
            limits: dict[str, Any] = {"workers": workers, "chunk": 1 if shapes else 16, "interpret_up_to": 0}
            if shapes:
                inputs.insert(3, np.array([each.shapes for each in holders]))
                over_chunks(modulated_maps_fill, inputs, out, phases, top, _ACCURACY, **limits)
            else:
                over_chunks(phase_maps_fill, inputs, out, phases, top, forms[left[0]].right, _ACCURACY, **limits)
            maps = out[:, :-1].reshape(-1, n, n, phases)
            harmonics = np.moveaxis(np.fft.rfft(maps, axis=-1) / phases, -1, 1)
            sizes = np.abs(harmonics).max(axis=(2, 3))
            with np.errstate(invalid="ignore"):
                last = sizes[:, -4:].max(axis=1)
                ends = last < _NEGLIGIBLE * sizes.max(axis=1)
            known = np.isfinite(out[:, -1])
            harmonics[:, 1:] *= 2.0
            for place in np.flatnonzero(ends & known):
                series[left[place]] = harmonics[place, :-1]
                errors[left[place]] = 4.0 * last[place] + (4.0 * EPS + out[place, -1]) * sizes[place].sum()
            left, phases = left[~ends & known], 2 * phases
    return series, errors


def _padded(arrays: Sequence[Floats]) -> Floats:
    """Return series (2, H, N, N) as one array, the shorter ones filled up with zeros."""
    longest = max(each.shape[1] for each in arrays)
    out = np.zeros((len(arrays), 2, longest, *arrays[0].shape[2:]))
    for row, each in zip(out, arrays, strict=True):
        row[:, : each.shape[1]] = each
    return out


def _by_shape(series: Sequence[Complexes], places: NDArray[np.intp]) -> dict[tuple[int, ...], list[int]]:
    """Return, for each shape of the series at some places that are known, which of the places have it."""
    groups: dict[tuple[int, ...], list[int]] = {}
    for at, i in enumerate(places.tolist()):
        if len(series[i]):
            groups.setdefault(series[i].shape, []).append(at)
    return groups


def _logarithms(
    series: Sequence[Complexes],
    errors: Floats,
    places: NDArray[np.intp],
    fractions: Sequence[Fraction],
    workers: int | None,
) -> tuple[Floats, Floats]:
    """Return logarithms of the largest multipliers of approximants, and the products' errors over these multipliers.

    A logarithm is NaN, and its error infinite, where the product is not known.
    """
    logarithms, relative = np.full(places.size, np.nan), np.full(places.size, np.inf)
    for (_, n, _), members in _by_shape(series, places).items():
        waves = np.array([series[places[at]] for at in members])
        pairs = np.array([[fractions[at].numerator, fractions[at].denominator] for at in members], dtype=float)
        out = np.empty((len(members), n * n + 2))
        inputs = [waves.real.copy(), waves.imag.copy(), pairs]
        over_chunks(orbit_products_fill, inputs, out, n, workers=workers, chunk=64, interpret_up_to=0)
        products, taken, stretch = out[:, :-2].reshape(-1, n, n), out[:, -2], out[:, -1]
        known = np.isfinite(taken) & np.isfinite(products).all(axis=(1, 2))
        radius = np.abs(np.linalg.eigvals(np.where(known[:, None, None], products, 0.0))).max(axis=1)
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            logarithms[members] = np.where(known, np.log(radius) + taken, np.nan)
            relative[members] = errors[places[members]] * np.exp(stretch - logarithms[members])
    return logarithms, relative


def _growth_bounds(
    series: Sequence[Complexes],
    errors: Floats,
    places: NDArray[np.intp],
    problem: tuple[Floats, Floats, Floats],
    precise: bool,
) -> tuple[Floats, Floats]:
    """Return bounds of the growth per unit of time of some problems, infinite where none is known.

    ``problem`` holds the ratio of the frequencies, the first of them and the tolerance of all problems; unless
    ``precise``, a bound below the tolerance is enough.
    """
    # Products of q = 1, 2, 4, ... maps at the phases y, y + 2 pi phi, ... have the largest norms r_q over all y.
    # Growth over q periods is at most log(r_q), in any norm: here the largest sum of a row, in coordinates in which the
    # mean map is diagonal.  Where the second frequency is weak, r_1 is little more than the largest of its eigenvalues.
    # The fastest of N solutions grows no less than all do on average, log abs(det) / N.
    low, high = np.full(places.size, -np.inf), np.full(places.size, np.inf)
    some = (
        (shape, np.array(group[k : k + _AT_ONCE]))
        for shape, group in _by_shape(series, places).items()
        for k in range(0, len(group), _AT_ONCE)
    )
    for (count, n, _), at in some:
        ratio, first, tolerance = (values[places[at]] for values in problem)
        waves = np.array([series[i] for i in places[at]]).reshape(at.size, count, n * n)
        order = np.arange(count)
        angles = np.outer(2.0 * math.pi * np.arange(_PHASES) / _PHASES, order)
        turns = np.concatenate([np.cos(angles), -np.sin(angles)], axis=1)
        with np.errstate(all="ignore"):
            basis = np.linalg.eig(waves[:, 0].real.reshape(-1, n, n))[1]
            inverse = np.linalg.inv(basis)
            stretch = np.abs(basis).sum(axis=2).max(axis=1) * np.abs(inverse).sum(axis=2).max(axis=1)
            off = n * stretch * (errors[places[at]] + _ROUNDED)
            product = np.broadcast_to(np.eye(n), (at.size, _PHASES, n, n))
            for k in range(_PERIODS):
                turned = waves * np.exp(2j * math.pi * k * ratio[:, None] * order)[:, :, None]
                maps = (turns @ np.concatenate([turned.real, turned.imag], axis=1)).reshape(-1, _PHASES, n, n)
                if k == 0:
                    volume = np.linalg.slogdet(maps)[1].mean(axis=1) / n - off
                    low[at] = volume * first / (2.0 * math.pi)
                product = inverse[:, None] @ maps @ basis[:, None] @ product
                if k & (k + 1):  # k + 1 is no power of two
                    continue
                sizes = np.abs(product).sum(axis=3).max(axis=2)
                most = sizes.max(axis=1)
                between = most - np.minimum(sizes[:, ::2].max(axis=1), sizes[:, 1::2].max(axis=1))
                found = np.log(most + between) / (k + 1) + off
                high[at] = np.fmin(high[at], found * first / (2.0 * math.pi))
                left = np.ones(at.size, dtype=np.bool_) if precise else ~(high[at] < tolerance)
                if not left.any():
                    break
                at, ratio, first, tolerance, waves, basis, inverse, off, product = (
                    values[left] for values in (at, ratio, first, tolerance, waves, basis, inverse, off, product)
                )
    return low, np.maximum(high, low)


def _fractions(ratio: float, most: int) -> Iterator[Fraction]:
    """Yield convergents of a ratio, and of those between two the last ones, with growing denominators up to ``most``.

    The fractions (p_(k-1) + j p_k) / (q_(k-1) + j q_k) between two convergents are taken where these lie far apart.
    """
    p, q, p_before, q_before = 1, 0, 0, 1
    rest = Fraction(ratio)
    last = 0
    while True:
        whole = math.floor(rest)
        for j in sorted({max(1, whole // 2), max(1, whole - 1), whole} if whole > 1 and q else {whole}):
            numerator, denominator = p_before + j * p, q_before + j * q
            if denominator > most:
                break
            if numerator > 0 and denominator > last:
                last = denominator
                yield Fraction(numerator, denominator)
                if abs(Fraction(numerator, denominator) - Fraction(ratio)) <= _ROUNDED * ratio:
                    return  # the ratio itself
        if q_before + whole * q > most:
            # The largest denominator that is left: two frequencies nearly commensurate beat slowly.
            j = (most - q_before) // q if q else 0
            if j > 0 and q_before + j * q > last and p_before + j * p > 0:
                yield Fraction(p_before + j * p, q_before + j * q)
            return
        p, q, p_before, q_before = p_before + whole * p, q_before + whole * q, p, q
        if rest == whole:
            return
        rest = 1 / (rest - whole)
