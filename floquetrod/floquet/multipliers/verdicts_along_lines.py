"""Many systems u'' + (K_0(t) + x K_1(t)) u = 0 of one period, x from -1 to 1: their maps by interpolation in x.

The map is an entire function of x.  Therefore the polynomial of degree d through the maps at d + 1 Chebyshev points is
at most 4 M / ((rho - 1) rho^d) from it, in the 2-norm, where M bounds the map for complex x inside the ellipse about -1
and 1 whose semi-axes add up to rho > 1 (L. N. Trefethen, Approximation Theory and Approximation Practice, 2013, theorem
8.2).  In the coordinates (R^(1/2) u, R^(-1/2) u'), R any diagonal matrix of rates, the logarithmic norm of the equation
is half the 2-norm of R - R^(-1/2) K R^(-1/2), whose integral over time is the bound of log M.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import EPS, Floats, norms
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent
from floquetrod._util.interpolation import chebyshev_points, chebyshev_weights
from floquetrod.equations import HillSystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.floquet.kernels.system_even import half_period_map
from floquetrod.floquet.multipliers import half_period_maps, many_verdicts, whole_period_maps
from floquetrod.floquet.multipliers.classification import MOST_SECONDS
from floquetrod.floquet.multipliers.many_verdicts import ManyVerdicts
from floquetrod.floquet.multipliers.whole_period_maps import PeriodMaps
from floquetrod.floquet.problems import undamped_pairs

_ACCURACY = 1e-12  # of maps at nodes, and of the polynomial between them
_WORTH = 0.5  # nodes over places, up to which the polynomial saves time (measured)
_TOGETHER = 1e-12  # periods between instants that are one up to rounding
_MOST_DEGREE = 64  # of a polynomial (a choice)
_AT_ONCE = 1 << 18  # entries of all maps in memory at a time (heuristic)
_SUMS = np.exp(np.linspace(0.05, 6.0, 240))  # of semi-axes among which the best one is sought


class Nodes(NamedTuple):
    """Maps (N, 2 n, 2 n) at Chebyshev points in the coordinates of the line, and their largest error."""

    maps: Floats
    error: float


@dataclass(frozen=True, eq=False)
class SystemLine(ByContent):
    """Systems with uniform damping removed, without mass and gyroscopic matrices, K symmetric."""

    stiffness: Floats  # (2, n, n), the mean of K at x = -1 and at x = 1
    harmonics: NDArray[Any]  # (2, H, n, n), Z_k of K(t) = mean + Re sum_k Z_k exp(i k w t) there; real where K is even
    period: float
    damping: float  # the rate c that was removed
    error: float  # bound of the error of K in the 2-norm
    is_even: bool  # whether half a period is enough

    @classmethod
    def between(cls, ends: HillSystem) -> SystemLine | None:
        """Return the line between two systems, a batch of the shape (2,); None for systems of another form."""
        freed, damping = undamped_pairs(ends) or (None, 0.0)
        if not isinstance(freed, HillSystem) or freed.structure != "hamiltonian":
            return None
        if freed.mass is not None or freed.gyroscopic is not None or freed.pieces or np.ptp(freed.period) > 0.0:
            return None
        form, period = freed.even_form, float(np.max(freed.period))
        apart = math.inf if form is None else float(np.ptp(form.start)) / period
        if form is not None and apart < _TOGETHER:  # between ends that are even about one instant all are
            orders = np.arange(1.0, form.amplitudes.shape[1] + 1.0)
            error = form.error + 2.0 * math.pi * apart * (norms(form.amplitudes) @ orders).max()
            return cls(form.stiffness, form.amplitudes, period, damping, float(error.max()), is_even=True)
        stiffness = np.broadcast_to(freed.stiffness, (2, freed.order, freed.order))
        harmonics = np.broadcast_to(freed.harmonics, (2, *freed.harmonics.shape[-3:]))
        return cls(stiffness, harmonics, period, damping, float(np.max(freed.error_norm)), is_even=False)

    @property
    def duration(self) -> float:
        """How long the maps last."""
        return 0.5 * self.period if self.is_even else self.period

    @cached_property
    def basis(self) -> tuple[Floats, Floats]:
        """Columns Q R^(-1/2) of the coordinates, u = basis v, Q the modes in the middle, and the rates R."""
        squared, modes = np.linalg.eigh(self.stiffness.mean(axis=0))
        forcing = np.abs(modes.T @ self.harmonics.mean(axis=0) @ modes)
        slow = 0.5 * math.pi / self.period
        rates = np.sqrt(np.abs(squared) + np.einsum("kii->i", forcing) + slow * slow)
        return modes / np.sqrt(rates), rates

    @cached_property
    def _exponents(self) -> Floats:
        """Logarithms of M, of each ellipse of `_SUMS`."""
        basis, rates = self.basis

        def size(matrix: Floats) -> float:
            return float(np.linalg.norm(basis.T @ matrix @ basis, 2))

        def middle_and_half(ends: Floats) -> tuple[Floats, Floats]:
            return 0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0])

        middle, half = middle_and_half(self.stiffness)
        waves = [middle_and_half(ends) for ends in np.moveaxis(self._waves, 1, 0)]
        share = 2.0 / math.pi  # mean magnitude of a cosine
        fixed = float(np.linalg.norm(np.diag(rates) - basis.T @ middle @ basis, 2))
        fixed += share * sum(size(middle_wave) for middle_wave, _ in waves)
        moved = size(half) + share * sum(size(half_wave) for _, half_wave in waves)
        return np.asarray(0.5 * self.duration * (fixed + 0.5 * (_SUMS + 1.0 / _SUMS) * moved))

    def left_out(self, degree: int) -> float:
        """Return a bound of the error of the polynomial of a degree, in the 2-norm and the line's coordinates."""
        logs = self._exponents + math.log(4.0) - np.log(_SUMS - 1.0) - degree * np.log(_SUMS)
        return math.exp(min(float(logs.min()), 700.0))

    def degree(self) -> int:
        """Return the lowest degree whose error is below the accuracy, at most `_MOST_DEGREE`."""
        return next((d for d in range(1, _MOST_DEGREE) if self.left_out(d) <= _ACCURACY), _MOST_DEGREE)

    @property
    def _waves(self) -> Floats:
        """Cosines and sines (2, W, n, n) at the ends."""
        return np.concatenate([self.harmonics.real, self.harmonics.imag][: 1 if self.is_even else 2], axis=1)

    def nodes(self, degree: int) -> Nodes | None:
        """Return the maps at degree + 1 Chebyshev points; None where they would take too long."""
        share = 0.5 * (1.0 + chebyshev_points(degree + 1))
        weights = np.stack([1.0 - share, share])
        stiffness = np.tensordot(weights, self.stiffness, (0, 0))
        harmonics = np.tensordot(weights, self.harmonics, (0, 0))
        maps = (_half_maps if self.is_even else _whole_maps)(stiffness, harmonics, np.full(degree + 1, self.period))
        if maps is None:
            return None
        columns, rates = self.basis
        turn = np.asarray(rates[:, None] * columns.T @ maps.scaling)
        back = np.asarray(np.linalg.inv(turn), dtype=float)
        stretch = np.maximum(*(np.linalg.norm(matrix, 2, axis=(1, 2)) for matrix in (turn, back))) ** 2
        turned = _both(turn, back) @ maps.matrix @ _both(back, turn)
        rounding = 8.0 * len(rates) * EPS * norms(maps.matrix)
        return Nodes(turned, float(((maps.error + rounding) * stretch).max()))

    @cached_property
    def uncertainty(self) -> float:
        """The error of K in the coordinates of the line, its rounding included, times the duration."""
        rounding = 4.0 * EPS * (norms(self.stiffness).sum() + norms(self._waves).sum())
        return self.duration * (self.error + float(rounding)) / float(self.basis[1].min())


def verdicts_along(ends: HillSystem, places: Floats) -> ManyVerdicts | None:
    """Return verdicts by the quick rules on systems between two ends, at places x (p,) from -1 to 1.

    None where there is no such line, or its polynomial would not save time.
    """
    line = SystemLine.between(ends)
    if line is None:
        return None
    degree = line.degree()
    nodes = line.nodes(degree) if degree < min(_MOST_DEGREE, _WORTH * places.size) else None
    if nodes is None or not math.isfinite(nodes.error):
        return None
    step = max(1, _AT_ONCE // nodes.maps[0].size)
    chunks = [_judged(line, nodes, places[start : start + step]) for start in range(0, places.size, step)]
    return ManyVerdicts(*(np.concatenate(column) for column in zip(*chunks, strict=True)))


@np.errstate(over="ignore", under="ignore", invalid="ignore")  # such a verdict is undecided
def _judged(line: SystemLine, nodes: Nodes, places: Floats) -> ManyVerdicts:
    """Return verdicts at places."""
    maps, error = maps_along(line, nodes, places)
    n, period = maps.shape[-1] // 2, np.full(places.size, line.period)
    if line.is_even:
        pairs = half_period_maps.products(maps[:, :n, n:].swapaxes(1, 2), error, maps[:, n:, :n], error)
        return many_verdicts.pair_verdicts(many_verdicts.many_discs(*pairs), period, line.damping)
    return many_verdicts.multiplier_verdicts(
        many_verdicts.many_discs(maps, error), period, paired=True, damping=line.damping
    )


def maps_along(line: SystemLine, nodes: Nodes, places: Floats) -> tuple[Floats, Floats]:
    """Return maps (p, 2 n, 2 n) at places, polynomials through the maps at nodes, and their errors (p,)."""
    count = len(nodes.maps)
    weights = chebyshev_weights(count, places)
    maps = (weights @ nodes.maps.reshape(count, -1)).reshape(-1, *nodes.maps.shape[1:])
    rounding = count * EPS * float(norms(nodes.maps).max())
    error = np.abs(weights).sum(axis=1) * (nodes.error + rounding) + line.left_out(count - 1)
    return maps, error + line.uncertainty * norms(maps) ** 2


def _half_maps(stiffness: Floats, amplitudes: Floats, period: Floats) -> PeriodMaps | None:
    """Return maps over half a period of even systems; their scaling is of positions, as matrices (N, n, n)."""
    if half_period_maps.seconds_needed(stiffness, amplitudes, period).sum() > MOST_SECONDS:
        return None
    half = half_period_map(stiffness, amplitudes, period, _ACCURACY)
    return PeriodMaps(half_period_maps.joined(half), half.error, half.basis)


def _whole_maps(stiffness: Floats, harmonics: Floats, period: Floats) -> PeriodMaps | None:
    """Return maps over a period, with scalings as in `_half_maps`."""
    cosines, sines = (list(np.moveaxis(amplitudes, 1, 0)) for amplitudes in (harmonics.real, -harmonics.imag))
    pieces = by_pieces.of_batch(HillSystem(stiffness, cosines, sines, period=period).as_periodic_system())
    if whole_period_maps.seconds_needed(pieces).sum() > MOST_SECONDS:
        return None
    maps = whole_period_maps.period_maps(pieces, 0.0, _ACCURACY, paired=True)
    n = stiffness.shape[-1]
    return maps._replace(scaling=maps.scaling[:, :n, None] * np.eye(n))


def _both(positions: Floats, inverse: Floats) -> Floats:
    """Return the matrices diag(T, T^-T) that transform (u, u'), from T (N, n, n) and its inverses."""
    n = positions.shape[-1]
    matrices = np.zeros((len(positions), 2 * n, 2 * n))
    matrices[:, :n, :n], matrices[:, n:, n:] = positions, inverse.swapaxes(1, 2)
    return matrices
