"""The fastest solutions of many equations u'' + K(t) u = 0, and a bound of all others, without the whole map.

Let S be the map over a period, V orthonormal columns, H = V^T S V and R = S V - V H.  A left eigenvector w^H of S with
the multiplier mu has w^H V (mu - H) = w^H R, so that with q columns V E of V

    |w^H V E| <= G(mu),  G(z) = |R (z - H)^-1 E|,  |w| = 1.

Where V E spans a subspace of N dimensions drawn at random, |w^H V E|^2 of a real w is distributed as Beta(q / 2,
(N - q) / 2), and less than x with a chance of at most (x N / 2)^(q / 2) / (q / 2)!.  Of a complex w the real or the
imaginary part has half its square, and at most N / 2 of the multipliers, which come in mu, 1 / mu, lie outside a circle
|z| = r >= 1: with a chance of 1 - 1e-10 the left-hand side is above `_shortest_projection` for one left eigenvector
of each of them, however near to one another these are, and there is no multiplier where G is below that.

Eigenvalues of H outside the circle are taken out of G as poles, each with a disc within which G may be larger; the
rest has its maximum for |z| >= r on the circle.  X and Y, the eigenvectors of H and their inverse as computed, give G
except for |X Y - I| and H X - X Lambda, which are added to the bound: where H is nearly defective, G is too large to
say anything.

V is a Krylov space of the random columns, and holds the growing solutions of a window of modes alone, the modes which
the fastest solutions consist of.
Saad, Numerical Methods for Large Eigenvalue Problems, SIAM 2011, chapter 6; for random starts Dixon, SIAM J. Numer.
Anal. 20 (1983) 812.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Complexes, Floats
from floquetrod.equations import HillSystem
from floquetrod.floquet.kernels.system_large import ModalEquations
from floquetrod.floquet.kernels.system_maps_large import period_map_large
from floquetrod.floquet.kernels.system_march import March
from floquetrod.floquet.multipliers.classification import LogDiscs, classify_multipliers
from floquetrod.floquet.multipliers.spectra import log_distances, touching
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.verdict import Cost

_FEWEST = 200  # equations: the map of fewer takes no longer (measured)
_COLUMNS = 8  # drawn at random (measured)
_SEED = 20151101
_CHANCE = 1e-10  # that of any multiplier outside the circle w^H V E is shorter than `_shortest_projection`
_ACCURACY = 1e-10  # of the map over a period
_PROBED = 6  # periods after which it shows whether anything grows, and after as many more of which modes (measured)
_FOLD = 20.0  # logarithm of the growth after which other solutions are shown to be slower (measured)
_LEFT_OUT = 0.01  # share of the growing motion that the modes beyond either end of a window have
_ANGLES = 240  # on half a circle at which G is computed
_BETWEEN = 1.2  # largest value on the circle over that at these angles, of poles 4 of their distances away (a choice)
_LEVELS = 0.9, 0.6
"""Growth down to which solutions are sought, over that of the fastest, in turn."""
_GROWING = 0.5  # growth in a window over its largest from which solutions are taken along (a choice)
_FAINT = 1e-4  # part of R, over the bound of G, that is bounded without regard to phases (a choice)
_SMALL = 1e-13  # length of a column of R that is rounding
_ROUNDING = 2.2e-16
_STANDING_OUT = 0.8, 0.95  # growth over the fastest, from which solutions determine the window, in turn (a choice)
_WIDEST = 0.6  # share of all modes in a window: the map of more takes long (a choice)
_CORRECTED = 5  # fastest solutions whose residuals are added to the space (a choice)
_ENOUGH = 1e-6  # error of the fastest growth, relative (a choice)
_EVERY = 5  # blocks of columns between two looks


class FastSolutions(NamedTuple):
    """The multipliers outside a circle of a system with damping removed."""

    logs: LogDiscs  # logarithms of these multipliers and of their inverses, last of all two that stand for all others
    rest: float  # bound of the real parts of the logarithms of all others
    start: Complexes | None  # (2 n,), (u, u') at the beginning of the fastest solution
    partner: Complexes | None  # (2 n,), about that of the one that decays as fast
    columns: int  # solutions that were carried over a period

    def verdict(self, system: HillSystem) -> SystemStability:
        """Return the verdict that follows on the system, damping included."""
        rest = self.rest / float(system.period)
        damping = 0.0 if system.damping is None else 0.5 * float(system.damping[0, 0])
        note = (
            f"only solutions that grow faster than {rest - damping:.3g} per unit time were searched for; that one was "
            f"missed has a chance of {_CHANCE:.0e}"
        )
        cost = Cost(self.columns, "solutions over a period")
        return classify_multipliers(system, "monodromy", self.logs, cost=cost, note=note)


class _Space(NamedTuple):
    """V and S V, the random columns first; ``last`` of them were added last of the Krylov space."""

    basis: Floats
    images: Floats
    last: slice

    def with_columns(self, march: March, added: Floats, krylov: int) -> _Space:
        """Return the space with more columns; the first ``krylov`` continue the Krylov space."""
        for _ in range(2):
            added = added - self.basis @ (self.basis.T @ added)
            added = np.linalg.qr(added)[0]
        count = self.basis.shape[1]
        last = slice(count, count + krylov) if krylov else self.last
        return _Space(np.hstack([self.basis, added]), np.hstack([self.images, march(added)]), last)


class _Spectrum(NamedTuple):
    """Eigenvalues of H and their terms in G(z) = |sum_i right_i left_i / (z - value_i)|.

    ``right`` is R x_i in coordinates of fewer rows, ``left`` is y_i E.  ``rounding`` is the size of H x_i - value_i x_i
    and of what R x_i is wrong by, ``defect`` the distance of sum_i x_i y_i E from E.
    """

    values: Complexes
    vectors: Complexes
    right: Complexes
    left: Complexes
    rounding: float
    defect: float

    @classmethod
    def of(cls, space: _Space) -> _Spectrum:
        """Return the eigenvalues of a space."""
        projected = space.basis.T @ space.images
        values, vectors = np.linalg.eig(projected)
        rest = space.images - space.basis @ projected
        large = np.linalg.norm(rest, axis=0) > _SMALL  # of the last columns and of the window
        right = np.linalg.qr(rest[:, large], mode="r") @ vectors[large]
        left = np.linalg.inv(vectors)[:, :_COLUMNS]
        rounding = float(np.linalg.norm(projected @ vectors - vectors * values, axis=0).max())
        defect = float(np.linalg.norm(vectors @ left - np.eye(len(values), _COLUMNS)))
        rounding += _SMALL * math.sqrt(len(values))
        values, vectors, right, left = (array.astype(complex) for array in (values, vectors, right, left))
        return cls(values, vectors, right, left, rounding, defect)

    @property
    def fastest(self) -> int:
        """Index of the largest eigenvalue."""
        return int(np.abs(self.values).argmax())

    def radii(self, radius: float, shortest: float, error: float) -> Floats | None:
        """Return the radii of discs about eigenvalues that hold all multipliers beyond a circle.

        A disc apart from all others holds one; radii are 0 well inside.  None where G is too large on the circle.
        """
        sizes, error = np.abs(self.values), error + self.rounding
        residuals = np.linalg.norm(self.right, axis=0) + error
        weights = np.linalg.norm(self.left, axis=1)
        far = sizes < radius * (1.0 - 4.0 * math.pi / _ANGLES)  # G hardly changes between two angles
        circle = radius * np.exp(1j * np.linspace(0.0, math.pi, _ANGLES))[:, None] - self.values[far]
        turned, strengths, _ = np.linalg.svd(self.right[:, far], full_matrices=False)
        few = turned[:, strengths > shortest * _FAINT].conj().T @ self.right[:, far]
        along = [float(np.linalg.norm((few / distances) @ self.left[far])) for distances in circle]
        faint = error + float(strengths[strengths <= shortest * _FAINT].max(initial=0.0))
        largest = (
            _BETWEEN * max([0.0, *along]) + faint * float(weights[far] @ (1.0 / (radius - sizes[far]))) + self.defect
        )
        if not largest < shortest:
            return None
        count = max(2, int(np.count_nonzero(~far)))
        return np.where(far, 0.0, 2.0 * count / (shortest - largest) * residuals * weights)


def fast_solutions(system: HillSystem, damping: float) -> FastSolutions | None:
    """Return the solutions of q'' + K(t) q = 0, K symmetric, that grow fastest, or that none grows faster than damping.

    None for other systems, and where the search takes as long as the whole map: where growth hardly exceeds the
    damping, or many solutions grow about as fast as the fastest.
    """
    # The space V grows until G (head of the file) is below its bound outside a circle: first random columns and six
    # periods of them (does anything grow faster than the damping?), then six more, which show the window of modes that
    # the fastest consist of; the growing solutions of these modes alone join the space at once, since blocks of a
    # Krylov space would need many periods to separate solutions of like growth.  From then on blocks are added, a
    # period of the march each, and the bound is tried every few of them.
    n, period = system.order, float(system.period)
    more = system.gyroscopic is not None or system.mass is not None or bool(system.pieces)
    if n < _FEWEST or more or system.structure != "hamiltonian":
        return None
    start = np.linalg.qr(np.random.default_rng(_SEED).standard_normal((2 * n, _COLUMNS)))[0]
    modes = ModalEquations.of(system.stiffness, system.harmonics)
    march = March.of(modes, period, _ACCURACY, start)
    if march is None:
        return None
    limit, error = damping * period, march.error + n * _ROUNDING
    space = _probed(march, _Space(start, march(start), slice(0, _COLUMNS)))
    if _is_slow(_Spectrum.of(space), limit, n):
        return None
    space = _probed(march, space)
    spectrum, partner = _Spectrum.of(space), None
    window = None if float(np.abs(spectrum.values).max()) < math.exp(limit) else _window(spectrum, space, n)
    if window is not None:
        added, partner = _alone(modes, march, period, window)
        space = space.with_columns(march, added, 0)
    while (columns := space.basis.shape[1]) <= n // 2 + 60:
        spectrum = _Spectrum.of(space)
        outside = _outside(spectrum, error, 2 * n, limit)
        if outside is not None and partner is not None:
            outside = _sharpened(outside[0], limit, *_condition(spectrum, space, partner, march.error)), outside[1]
        if outside is not None and _is_sharp(outside[0], limit):
            state = space.basis @ spectrum.vectors[:, spectrum.fastest]
            decaying = None if partner is None else march.motion(partner)
            return FastSolutions(*outside, None if partner is None else march.motion(state), decaying, columns)
        residual = _residual(spectrum, space)
        for _ in range(max(_EVERY, columns // (8 * _COLUMNS))):
            space = _longer(march, space, residual)
            residual = residual[:, :0]
    return None


def _probed(march: March, space: _Space) -> _Space:
    """Return a Krylov space of some periods more."""
    for _ in range(_PROBED):
        space = _longer(march, space)
    return space


def _is_slow(spectrum: _Spectrum, limit: float, n: int) -> bool:
    """Return whether no solution grows or decays fast enough to stand out in a space of n columns."""
    fastest = max(limit, math.log(float(np.abs(spectrum.values).max())))
    return not fastest * n > _FOLD * 10.0


def _is_sharp(logs: LogDiscs, limit: float) -> bool:
    """Return whether the fastest growing solution, if there is one, is known well enough."""
    fastest = int(logs.values.real.argmax())
    growth = float(logs.values[fastest].real) + limit
    return growth <= 0.0 or float(logs.radii[fastest]) < _ENOUGH * growth


def _longer(march: March, space: _Space, added: Floats | None = None) -> _Space:
    """Return the space with another block of the Krylov space, and with the columns ``added``."""
    block = space.images[:, space.last]
    krylov = block.shape[1]
    return space.with_columns(march, block if added is None else np.hstack([block, added]), krylov)


def _residual(spectrum: _Spectrum, space: _Space) -> Floats:
    """Return the residuals S x - mu x of the fastest solutions, real and imaginary parts."""
    sizes = np.abs(spectrum.values)
    fast = np.flatnonzero((sizes > sizes.max() ** _LEVELS[0]) & (spectrum.values.imag >= 0.0))
    fast = fast[np.argsort(-sizes[fast])[:_CORRECTED]]
    x = spectrum.vectors[:, fast]
    lack = space.images @ x - space.basis @ (x * spectrum.values[fast])
    return np.hstack([lack.real, lack.imag[:, lack.imag.any(axis=0)]])


def _window(spectrum: _Spectrum, space: _Space, n: int) -> slice | None:
    """Return the modes of growing solutions, or of the fastest; None where they are most modes."""
    growth = np.log(np.maximum(np.abs(spectrum.values), 1.0))
    motion = np.square(np.abs(space.basis @ spectrum.vectors))
    for share_of_fastest in _STANDING_OUT:
        share = np.cumsum((motion[:n] + motion[n:]) @ np.where(growth > share_of_fastest * growth.max(), growth, 0.0))
        low, high = np.searchsorted(share, np.array([_LEFT_OUT, 1.0 - _LEFT_OUT]) * share[-1]).tolist()
        wider = 2 * (high - low) // 3 + 1
        low, high = max(0, low - wider), min(n, high + wider + 1)
        if high - low <= _WIDEST * n:
            return slice(low, high)
    return None


def _alone(modes: ModalEquations, march: March, period: float, window: slice) -> tuple[Floats, Complexes]:
    """Return growing solutions of some modes alone, real columns, and the one that decays as the fastest grows."""
    n, count = len(modes.rates), window.stop - window.start
    harmonics = np.zeros((len(modes.norms), count, count), dtype=complex)
    for matrix, order, turn in zip(modes.matrices, modes.orders, modes.turns, strict=True):
        harmonics[order - 1] += (1j if turn else 1.0) * matrix[window, window]
    full, _, basis = period_map_large(np.diag(modes.rates[window]), harmonics, period, 0.0, _ACCURACY)
    values, vectors = np.linalg.eig(full)
    scales = march.scaling[window, None] * basis.diagonal()[:, None]
    states = np.zeros((2, n, 2 * count), dtype=complex)
    states[0, window], states[1, window] = vectors[:count] * scales, vectors[count:] / scales
    states = states.reshape(2 * n, -1)
    fastest = values[np.abs(values).argmax()]
    partner = states[:, np.abs(values * np.conj(fastest) - 1.0).argmin()]
    growing = states[:, (np.abs(values) > abs(fastest) ** _GROWING) & (values.imag >= 0.0)]
    return np.hstack([growing.real, growing.imag[:, growing.imag.any(axis=0)]]), partner


def _shortest_projection(rows: int) -> float:
    """Return the length that some |w^H V E| of rows / 2 eigenvectors w is below with a chance of `_CHANCE` (above)."""
    half = _COLUMNS // 2
    return math.sqrt((_CHANCE * math.factorial(half) / (0.5 * rows)) ** (1.0 / half) / rows)


def _outside(spectrum: _Spectrum, error: float, rows: int, limit: float) -> tuple[LogDiscs, float] | None:
    """Return the multipliers outside a circle as in `FastSolutions`, and its logarithm; None where none serves."""
    shortest = _shortest_projection(rows)
    fastest = math.log(float(np.abs(spectrum.values).max()))
    levels = [limit] if fastest < limit else [share * fastest for share in _LEVELS if share * fastest > limit] + [limit]
    outside = None
    for level in levels:
        radii = spectrum.radii(math.exp(level), shortest, error)
        if radii is None:
            break
        outside = _discs(spectrum.values, radii, level, limit) or outside
    return outside


def _condition(spectrum: _Spectrum, space: _Space, partner: Complexes, error: float) -> tuple[complex, float]:
    """Return the logarithm of the largest multiplier and its error, if no other is near.

    The left eigenvector is J^T y, y nearly the solution that decays as fast.
    """
    i, n = spectrum.fastest, len(partner) // 2
    state = space.basis @ spectrum.vectors[:, i]
    left = np.concatenate([-partner[n:], partner[:n]]).conj()
    product = left @ state
    change = abs(left @ (space.images @ spectrum.vectors[:, i]) / product - spectrum.values[i])
    condition = np.linalg.norm(left) * np.linalg.norm(state) / abs(product)
    radius = change + 2.0 * condition * (np.linalg.norm(spectrum.right[:, i]) + error)
    return complex(np.log(spectrum.values[i])), float(radius / abs(spectrum.values[i]))


def _sharpened(logs: LogDiscs, limit: float, fastest: complex, radius: float) -> LogDiscs:
    """Return discs with another radius about the fastest solution, its conjugate and their inverses.

    Only where they touch no other disc.
    """
    radii = logs.radii.copy()
    for cluster in logs.clusters:
        value = logs.values[cluster[0]] + limit
        same = abs(abs(value.real) - fastest.real) + abs(abs(value.imag) - abs(fastest.imag)) < _SMALL
        if len(cluster) == 1 and same:
            radii[cluster] = np.minimum(radii[cluster], radius)
    return LogDiscs.about(logs.values, radii, logs.clusters)


def _discs(values: Complexes, radii: Floats, level: float, limit: float) -> tuple[LogDiscs, float] | None:
    """Return discs about logarithms less the damping, of multipliers, of their inverses and of two for all others.

    Also the bound of the others.  None where a disc is as large as its multiplier lies outside the circle.
    """
    sizes = np.abs(values)
    outside = sizes - radii > math.exp(level)
    rest = max(level, math.log(float((sizes + radii)[~outside & (radii > 0.0)].max(initial=1.0))))
    if rest > limit and not math.exp(rest) < float((sizes - radii).max()):
        return None
    outside_logs, errors = np.log(values[outside]), 2.0 * (radii / sizes)[outside]
    logs = np.concatenate([outside_logs, -outside_logs, np.zeros(2)])
    errors = np.concatenate([errors, errors, np.full(2, rest)])
    count = 2 * len(outside_logs)
    clusters = *touching(log_distances(logs[:count], logs[:count]), errors[:count]), np.array([count, count + 1])
    return LogDiscs.about(np.asarray(logs - limit, dtype=np.complex128), errors, clusters), rest
