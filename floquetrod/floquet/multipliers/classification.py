"""The one place where a spectrum with errors becomes a verdict on a system.

Multipliers of a Hamiltonian or reversible system come in pairs mu, 1 / mu, and a pair is one number y: see
`floquetrod.floquet.multiplier_pairs`.  A real matrix has y real or in complex pairs, so that a y apart from all others
is real, and of several close ones the Krein form (where definite) or the discriminant (of two) says whether they are.
Of any other system the logarithms of the multipliers decide.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import EPS, Bools, Complexes, Floats
from floquetrod.equations import DelayedMoments, DelaySystem, HillSystem, PeriodicSystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.equations.batches import System
from floquetrod.equations.hill_system import in_first_order
from floquetrod.equations.pieces import TimedPiece
from floquetrod.floquet import multiplier_pairs
from floquetrod.floquet.multipliers import spectra
from floquetrod.floquet.multipliers.spectra import Discs
from floquetrod.floquet.multipliers.symplectic import krein_form
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.problems import undamped_pairs
from floquetrod.floquet.verdict import Cost, Status, static_status

Krein = Callable[[NDArray[np.intp]], int]
AnySystem = System | DelaySystem | DelayedMoments

_MIXED = "{} multipliers near {} cannot be distinguished, nor are their Krein signs known to be equal"
_CLUSTER = "{} multipliers that cannot be distinguished are within {:.1g} of the unit circle"
_EDGE = "a multiplier is within {:.1g} of {}"


class ManyDigits(NamedTuple):
    """The numbers y of the pairs beyond the digits of a double."""

    above: Complexes  # (n,), 1 + y, each correctly rounded
    net: Floats  # (n,), growth over a period less uniform damping, each correctly rounded
    discriminant: Callable[[NDArray[np.intp]], tuple[float, float]]  # ((y1 - y2) / 2)^2 of a cluster of two, and error


class _ClusterVerdict(NamedTuple):
    """A cluster's growth over a period less uniform damping, between bounds, and its Krein sign."""

    low: float
    high: float
    bounded: bool
    reason: str = ""
    krein: int = 0


def classify_pairs(
    system: System,
    method: str,
    discs: Discs | None,
    *,
    krein: Krein | None = None,
    digits: ManyDigits | None = None,
    cost: Cost,
) -> SystemStability:
    """Return the verdict on a system from the numbers y of its pairs, with uniform damping removed.

    Parameters
    ----------
    discs : Discs or None
        The numbers y with errors; None where they could not be computed.
    krein : callable (cluster) -> int, optional
        Krein sign of a cluster of y, of its multipliers on the upper half of the circle; 0 where mixed.
    digits : ManyDigits, optional
        The numbers y beyond the digits of a double; then only values, radii and clusters of ``discs`` are used.
    """
    freed = undamped_pairs(system)
    if freed is None:
        raise ValueError("system has no pairs of multipliers")
    if discs is None:
        return SystemStability.declined(system, method, cost, "the eigenvectors cannot be computed accurately enough")
    limit = freed[1] * float(system.period)
    if digits is None:
        net = np.abs(multiplier_pairs.logarithms(discs.values).real) - limit
        digits = ManyDigits(1.0 + discs.values, net, lambda cluster: spectra.discriminant(discs, cluster))
    logs = multiplier_pairs.upper_logarithms(discs.values, digits.above)
    errors = multiplier_pairs.log_errors(discs.values, digits.above, discs.radii)
    net, outside = digits.net.copy(), multiplier_pairs.outside(discs.values, digits.above)
    vague = _are_vague(discs.values, discs.radii)
    if vague.any():
        net[vague], errors[vague] = multiplier_pairs.vague_growth(discs.values[vague], discs.radii[vague])
        net[vague] -= limit
    whole_errors = errors
    if len(discs.clusters) < len(discs.values):
        whole_errors = np.fmax(errors, _errors_of_clusters(discs, digits.above, net + limit))
    digits = digits._replace(net=net)
    signs = np.zeros(len(logs), dtype=int)
    sides = _Sides.of(discs, digits, outside, errors, limit)
    low, high, near, inside = (side.tolist() for side in sides)
    verdicts, on_axis = [], np.zeros(len(logs), dtype=np.bool_)
    for cluster in discs.clusters:
        if len(cluster) == 1:
            i = int(cluster[0])
            verdict = _single_verdict(discs, low[i], high[i], near[i], inside[i], limit, cluster, krein)
            on_axis[i] = near[i]
        else:
            verdict, on_axis[cluster] = _joint_verdict(discs, digits, sides, limit, cluster, krein)
        if verdict.krein:
            signs[cluster] = verdict.krein
        verdicts.append(verdict)
    net[on_axis] = np.where(outside[on_axis] > 0.0, net[on_axis], -limit)
    logs[on_axis] = net[on_axis] + limit + 1j * np.abs(logs[on_axis].imag)
    upper = logs.imag >= 0.0
    return _verdict(
        system,
        method,
        verdicts,
        net=np.concatenate([net + 1j * logs.imag, -net - 2.0 * limit - 1j * logs.imag]),
        errors=np.concatenate([whole_errors, whole_errors]),
        signs=np.concatenate([np.where(upper, signs, -signs), np.where(upper, -signs, signs)]),
        damping=freed[1],
        cost=cost,
    )


def _are_vague(values: Complexes, radii: Floats) -> Bools:
    """Return which discs of y are too large for a derivative of the logarithm, beside others that grow fast."""
    return np.asarray(radii > 0.5 * np.maximum(1.0, np.abs(values)))


def _errors_of_clusters(discs: Discs, above: Complexes, growth: Floats) -> Floats:
    """Return errors of the logarithms of y where discs touch: any of a cluster may be anywhere in its discs.

    ``growth`` over a period is their real part.
    """
    reaches = discs.reaches
    errors, vague = multiplier_pairs.log_errors(discs.values, above, reaches), _are_vague(discs.values, reaches)
    low, high = multiplier_pairs.growth_bounds(discs.values[vague], reaches[vague])
    errors[vague] = np.hypot(np.maximum(high - growth[vague], growth[vague] - low), math.pi)
    return errors


class _Sides(NamedTuple):
    """Of each number y: bounds of its net growth, whether it may be bounded, and whether it must be if real, (n,)."""

    low: Floats
    high: Floats
    near: Bools
    inside: Bools

    @classmethod
    def of(cls, discs: Discs, digits: ManyDigits, outside: Floats, errors: Floats, limit: float) -> _Sides:
        """Return the sides of all numbers y."""
        within = (
            multiplier_pairs.decided(multiplier_pairs.excess(discs.values.real, digits.above.real), discs.radii) < 0
        )
        low = np.maximum(-limit, digits.net - errors)
        return cls(low, digits.net + errors, outside <= discs.radii, within)


def _single_verdict(
    discs: Discs,
    low: float,
    high: float,
    near: bool,
    inside: bool,
    limit: float,
    cluster: NDArray[np.intp],
    krein: Krein | None,
) -> _ClusterVerdict:
    """Return the verdict on a y apart from all others, which is real where it is ``near``."""
    if not near:
        return _ClusterVerdict(low, high, False)
    if inside:
        return _ClusterVerdict(-limit, -limit, True, krein=krein(cluster) if krein else 0)
    i = cluster[0]
    edge = "+1" if discs.values[i].real > -0.5 else "-1"
    return _ClusterVerdict(-limit, high, False, _EDGE.format(math.sqrt(2.0 * discs.radii[i]), edge))


def _joint_verdict(
    discs: Discs, digits: ManyDigits, sides: _Sides, limit: float, cluster: NDArray[np.intp], krein: Krein | None
) -> tuple[_ClusterVerdict, bool]:
    """Return the verdict on a cluster of several y, and whether its members must be on the real axis."""
    low, high = float(sides.low[cluster].min()), float(sides.high[cluster].max())
    if not sides.near[cluster].any():
        return _ClusterVerdict(low, high, False), False
    inside = bool(sides.inside[cluster].all())
    sign = krein(cluster) if krein and inside else 0
    if sign:
        return _ClusterVerdict(-limit, -limit, True, krein=sign), True
    if len(cluster) == 2:
        value, error = digits.discriminant(cluster)
        if value < -error:
            return _ClusterVerdict(low, high, False), False
        if value > error and inside:
            return _ClusterVerdict(-limit, -limit, True), True
    return _ClusterVerdict(
        -limit, high, False, _MIXED.format(2 * len(cluster), _named(discs.values[cluster].mean()))
    ), False


def _named(y: complex) -> str:
    """Return where a cluster's multipliers are, in words."""
    angle = abs(multiplier_pairs.logarithms(complex(y)).imag)
    return f"exp(+-{angle:.4g} i)"


def classify_unitary(system: System, method: str, discs: Discs | None, *, cost: Cost) -> SystemStability:
    """Return the verdict on a system that keeps the norm, from `spectra.normal_discs` of its map over a period.

    Every multiplier is on the circle, and within the error of the one computed for it, also where several meet.
    """
    if discs is None:
        return SystemStability.declined(system, method, cost, "the map over a period is not finite")
    hamiltonian = system.structure == "hamiltonian"
    clusters = discs.clusters if hamiltonian else tuple(np.arange(len(discs.values))[:, None])
    sizes = np.abs(discs.values)
    radii = discs.radii + float(np.abs(sizes - 1.0).max())  # onto the circle, where both matrices are unitary
    logs = LogDiscs.of(discs.values / sizes, radii, clusters)
    krein = spectra.Signs(discs, krein_form, 1.0, 0.0) if hamiltonian else None
    return classify_multipliers(system, method, logs, krein=krein, cost=cost)


class LogDiscs(NamedTuple):
    """Logarithms of multipliers with errors."""

    values: Complexes  # (N,)
    low: Floats  # (N,), bounds of their real parts
    high: Floats
    radii: Floats  # (N,), of discs about the values; infinite where a multiplier cannot be distinguished from 0
    clusters: tuple[NDArray[np.intp], ...]  # indices of discs that touch

    @classmethod
    def of(
        cls, multipliers: Complexes, radii: Floats, clusters: tuple[NDArray[np.intp], ...], shift: float = 0.0
    ) -> LogDiscs:
        """Return the logarithms of multipliers in discs of these radii, less ``shift``."""
        sizes = np.abs(multipliers)
        with np.errstate(divide="ignore"):
            low, high = np.log(np.maximum(sizes - radii, 0.0)), np.log(sizes + radii)
            values = np.log(np.where(sizes > 0.0, multipliers, 5e-324))
            radii = np.where(radii < sizes, values.real - low, math.inf)
        return cls(np.asarray(values - shift), low - shift, high - shift, radii, clusters)

    @property
    def errors(self) -> Floats:
        """Errors of the logarithms, (N,), in a cluster as if each multiplier were anywhere in its discs.

        Infinite in a cluster that cannot be distinguished from 0.
        """
        if len(self.clusters) == len(self.values):
            return self.radii
        far = spectra.reaches(spectra.log_distances(self.values, self.values), self.radii, self.clusters)
        sides = np.maximum(self.highest - self.values.real, self.values.real - self.lowest)
        return np.fmin(far, np.hypot(sides, math.pi))  # of any angle

    @property
    def lowest(self) -> Floats:
        """Lower bounds of the real parts, (N,), one for each cluster."""
        return self._of_clusters(self.low, np.min)

    @property
    def highest(self) -> Floats:
        """Upper bounds of the real parts, (N,), one for each cluster."""
        return self._of_clusters(self.high, np.max)

    def _of_clusters(self, bounds: Floats, join: Callable[[Floats], Any]) -> Floats:
        joined = bounds.copy()
        for cluster in self.clusters:
            joined[cluster] = join(bounds[cluster])
        return joined

    @classmethod
    def about(cls, values: Complexes, radii: Floats, clusters: tuple[NDArray[np.intp], ...]) -> LogDiscs:
        """Return discs of these radii about logarithms."""
        return cls(values, values.real - radii, values.real + radii, radii, clusters)


def classify_multipliers(
    system: AnySystem,
    method: str,
    logs: LogDiscs | None,
    *,
    krein: Krein | None = None,
    cost: Cost,
    note: str = "",
    are_all: bool = True,
) -> SystemStability:
    """Return the verdict on a system from its multipliers.

    Where they come in mu, 1 / mu, a disc on the circle apart from all others holds a multiplier exactly on it, if
    ``are_all`` of them are in ``logs``; ``krein`` gives the Krein sign of a cluster on the circle, 0 where mixed.
    """
    # Discs are about log mu; with ``shift`` = damping times period they are those of the system without its damping,
    # whose multipliers come in mu, 1 / conj(mu) where ``freed`` is not None.  A cluster of discs is decided by the
    # first rule that holds: clear of the imaginary axis, inside or outside the circle; a single disc, apart from all
    # others, that meets its own mirror image: its multiplier and the image are one, on the circle; several of one Krein
    # sign: all on the circle (V. A. Yakubovich and V. M. Starzhinskii, Linear Differential Equations with Periodic
    # Coefficients, 1975, chapter III); else open, with a reason.  Multipliers proved on the circle lose the real part
    # of their logarithm, which is rounding.
    if logs is None:
        return SystemStability.declined(system, method, cost, "the eigenvectors cannot be computed accurately enough")
    freed = undamped_pairs(system) if are_all else None
    damping = freed[1] if freed else 0.0
    shift = damping * float(system.period)
    values = logs.values + shift
    signs = np.zeros(len(values), dtype=int)
    verdicts = []
    for cluster in logs.clusters:
        low, high = float(logs.low[cluster].min()) + shift, float(logs.high[cluster].max()) + shift
        if low > 0.0 or high < 0.0:
            verdicts.append(_ClusterVerdict(low - shift, high - shift, False))
            continue
        if freed and _on_circle(values, logs.radii, cluster):
            sign = krein(cluster) if krein else 0
            verdicts.append(_ClusterVerdict(-shift, -shift, True, krein=sign))
        elif freed and krein and len(cluster) > 1 and (sign := krein(cluster)):
            verdicts.append(_ClusterVerdict(-shift, -shift, True, krein=sign))
        else:
            uncertainty = float(np.expm1(min(high, 1.0)))
            alone = len(cluster) == 1
            text = _EDGE.format(uncertainty, "the unit circle") if alone else _CLUSTER.format(len(cluster), uncertainty)
            verdicts.append(_ClusterVerdict(low - shift, high - shift, False, text))
            continue
        values[cluster] = 1j * values[cluster].imag
        signs[cluster] = verdicts[-1].krein
    return _verdict(
        system,
        method,
        verdicts,
        net=values - shift,
        errors=logs.errors,
        highest=logs.highest,
        signs=signs,
        damping=damping,
        cost=cost,
        note=note,
        are_paired=freed is not None,
        are_all=are_all,
    )


def _on_circle(values: Complexes, radii: Floats, cluster: NDArray[np.intp]) -> bool:
    """Return whether a single disc meets its own mirror image in the circle and no other disc."""
    if len(cluster) != 1:
        return False
    i = int(cluster[0])
    others = np.arange(len(values)) != i
    distance = spectra.log_distances(values[others], values[cluster])[:, 0]
    return bool((distance > radii[others] + radii[i] + 2.0 * abs(values[i].real)).all())


def _verdict(
    system: AnySystem,
    method: str,
    verdicts: Sequence[_ClusterVerdict],
    *,
    net: Complexes,
    errors: Floats,
    signs: NDArray[Any],
    damping: float,
    cost: Cost,
    note: str = "",
    are_paired: bool = True,
    are_all: bool = True,
    highest: Floats | None = None,
) -> SystemStability:
    """Return the verdict on a system from its clusters and the net logarithms of its multipliers, damping included.

    ``highest`` are upper bounds of their real parts.  Exponents of infinite error are not known: NaN.
    """
    # A cluster's log |mu|, damping included, lies between low and high.  Unstable: one low above 0, or a pair proved
    # off the circle of an undamped system.  Stable: every high below 0, or the multipliers bounded on the circle
    # without damping.  What is open is left to rules about the matrices alone.  Exponents are net / period in 1/s, the
    # fastest first; logarithms of infinite error become NaN, with ``unknown_below`` the bound of what they may hide.
    period = float(system.period)
    damped = damping > 0.0
    # Solutions that keep their norm are bounded; a Hamiltonian matrix next to such a one need not keep it.
    stays = system.structure == "unitary" or all(
        verdict.high < 0.0 or (verdict.bounded and not damped) for verdict in verdicts
    )
    if isinstance(system, PeriodicSystem) and system.keeps_norm and are_all:
        verdicts, net = (
            [verdict._replace(low=0.0, high=0.0, bounded=True, reason="") for verdict in verdicts],
            np.asarray(0.0 + 1j * net.imag),
        )
    status: Status
    strongly: bool | None
    if any(
        verdict.low > 0.0 or (are_paired and not damped and not verdict.bounded and not verdict.reason)
        for verdict in verdicts
    ):
        status, strongly = "unstable", False
    elif all(verdict.high < 0.0 or (verdict.bounded and not damped) for verdict in verdicts):
        status, strongly = "stable", True if stays else None
    else:
        status, strongly = "undecided", None
        if not isinstance(system, DelaySystem | DelayedMoments):
            status = _status_of_matrices(system) or "undecided"
    reason = next(
        (verdict.reason for verdict in verdicts if verdict.reason), "growth equals the damping within the error"
    )
    lost = np.logical_not(np.isfinite(errors) & np.isfinite(net))
    known, unknown_below = errors, -math.inf
    if some_lost := bool(lost.any()):
        errors, net, known = np.where(lost, math.inf, errors), np.where(lost, 0.0, net), errors[~lost]
        unknown_below = math.inf if highest is None else float(highest[lost].max()) / period
    exponents = net / period
    fastest = max(0.0, float(exponents.real.max(initial=0.0))) if known.size else math.nan
    if some_lost:
        exponents = np.where(lost, complex(math.nan, math.nan), exponents)
    # By falling growth, then by rising frequency.
    order = np.lexsort((exponents.imag, -exponents.real))
    texts = [text for text in (note, reason if status == "undecided" else "", _not_known(lost, unknown_below)) if text]
    return SystemStability(
        equation=system,
        method=method,
        status=status,
        growth_rate=0.0 if status == "stable" else fastest,
        exponents=tuple(exponents[order].tolist()),
        exponent_errors=tuple((errors[order] / period + 4.0 * EPS * np.abs(net[order]) / period).tolist()),
        krein_signs=tuple(signs[order].tolist()),
        strongly_stable=strongly,
        unknown_below=unknown_below,
        growth_below=max((verdict.high for verdict in verdicts), default=math.inf) / period,
        period=period,
        error=float(known.max(initial=0.0)) if known.size else math.inf,
        cost=cost,
        note="; ".join(texts),
    )


def _not_known(lost: Bools, below: float) -> str:
    """Return a sentence on the multipliers of infinite error; "" without any."""
    count = int(np.count_nonzero(lost))
    if not count:
        return ""
    which = f"{count} multiplier{'' if count == 1 else 's'}"
    which += f" of exponents below {below:.4g}" if math.isfinite(below) else ""
    return f"{which} cannot be distinguished from 0 beside the largest: NaN"


MOST_SECONDS = 60.0
"""Longest estimated time of a map (a choice)."""


def too_long(system: System, method: str, seconds: float) -> SystemStability | None:
    """Return the undecided result of a method that would take too long, None where it would not."""
    if seconds <= MOST_SECONDS:
        return None
    note = f"would take about {seconds:.2g} s; take a shorter period, or fewer or softer equations"
    if seconds == math.inf:
        note = "solutions grow beyond doubles within a period"
    return SystemStability.declined(system, method, Cost(0, "periods"), note)


def _status_of_matrices(system: System) -> Status | None:
    """Return the verdict from the matrices alone, without the multipliers; None where they decide nothing."""
    if _contracts(in_first_order(system)) or (isinstance(system, HillSystem) and _is_overdamped(system)):
        return "stable"
    if _expands(system):
        return "unstable"
    return _without_variation(system) if system.is_constant else None


def _expands(system: System) -> bool:
    """Return whether the mean trace of A is positive, so that the product of all multipliers exceeds 1 (Liouville)."""
    first = in_first_order(system).real_form
    if first.pieces:
        return False
    values = np.diag(first.mean)
    slack = len(values) * (first.coefficient_error + 4.0 * EPS * float(np.abs(values).sum()))
    return math.fsum(values) > slack


def _contracts(system: PeriodicSystem) -> bool:
    """Return whether (A(t) + A(t)^T) / 2 is negative definite at all times, so that abs(x) decreases."""
    return all(
        spectra.symmetric_bounds(piece.mean)[1] + _swing(piece, system.coefficient_error) < 0.0
        for piece in map(_symmetric, by_pieces.in_time(system))
    )


def _symmetric(piece: TimedPiece) -> TimedPiece:
    """Return a piece with the symmetric parts of its matrices."""
    mean, harmonics = 0.5 * (piece.mean + piece.mean.T), 0.5 * (piece.harmonics + piece.harmonics.swapaxes(-1, -2))
    slope = None if piece.slope is None else 0.5 * (piece.slope + piece.slope.T)
    return piece._replace(mean=mean, harmonics=harmonics, slope=slope)


def _is_overdamped(system: HillSystem) -> bool:
    """Return whether damping makes every motion creep to rest, M = I or none, C and K symmetric.

    With s = q + C^-1 q' and w = C^-1 q' the energy s^T C s + w^T C w decreases at the rate 2 s^T K s + 2 w^T (C^2 - K)
    w: where C, K and C^2 - K are positive definite at all times.  With C = 2 c I it grows at no larger rate than
    -2 k / (2 c), k the lowest eigenvalue of K, while the lowest one of C^2 - K exceeds k: where the mean of k over the
    period is positive.
    """
    if system.mass is not None or system.gyroscopic is not None or system.damping is None or not system.is_symmetric:
        return False
    damping = system.damping
    if not np.array_equal(damping, damping.T):
        return False
    weakest = spectra.symmetric_bounds(damping)[0]
    total, lowest, highest = 0.0, math.inf, -math.inf
    for piece in by_pieces.in_time(system):
        low, high = spectra.symmetric_bounds(piece.mean)
        swing = _swing(piece, system.coefficient_error)
        lowest, highest = min(lowest, low - swing), max(highest, high + swing)
        alone = system.is_smooth and system.order == 1  # whose harmonics have no mean
        total += float(piece.length) * (low - (system.coefficient_error if alone else swing))
    if not (weakest > 0.0 and highest < 0.5 * weakest * weakest):
        return False
    return lowest > 0.0 or (system.uniform_damping is not None and -lowest < 0.5 * weakest * weakest and total > 0.0)


def _swing(piece: TimedPiece, error: float) -> float:
    """Return a bound of how far, in the 2-norm, the matrix of a piece is from its mean."""
    swing = len(piece.mean) * error + sum(spectra.spectral_norm(z) for z in piece.harmonics)
    if piece.slope is None:
        return swing
    farthest = float(max(abs(piece.begin - piece.origin), abs(piece.begin + piece.length - piece.origin)))
    return swing + farthest * spectra.spectral_norm(piece.slope)


def _without_variation(system: System) -> Status | None:
    """Return the verdict on constant coefficients, whose multipliers may meet by the mere choice of a period."""
    if isinstance(system, HillSystem) and system.damping is None and not system.stiffness.any() and not system.pieces:
        return _status_of_turning(system.gyroscopic)
    if isinstance(system, HillSystem) and system.gyroscopic is None and system.is_symmetric and system.undamped:
        return _static_status(system, *system.undamped)
    mean = in_first_order(system).real_form
    discs = spectra.eigenvalue_discs(mean.mean, mean.coefficient_error * mean.order)
    if discs is None:
        return None
    reach = discs.values.real
    if any((reach[cluster] - discs.radii[cluster] > 0.0).all() for cluster in discs.clusters):
        return "unstable"
    if (reach + discs.radii < 0.0).all():
        return "stable"
    if mean.structure == "hamiltonian":
        for cluster in discs.clusters:
            alone = len(cluster) == 1 and abs(discs.values[cluster[0]].imag) > discs.radii[cluster[0]]
            if not alone and not spectra.Signs(discs, krein_form, 1.0, 0.0)(cluster):
                return None
        return "stable"
    return None


def _status_of_turning(gyroscopic: Floats | None) -> Status | None:
    """Return the verdict on M q'' + G q' = 0: q' turns, and q is bounded where G is invertible; else q drifts."""
    if gyroscopic is None or len(gyroscopic) % 2:
        return "unstable"
    sizes = np.linalg.svd(gyroscopic, compute_uv=False)
    return "stable" if sizes[-1] > 8.0 * len(sizes) * EPS * sizes[0] else None


def _static_status(system: HillSystem, freed: HillSystem, damping: float) -> Status | None:
    """Return the verdict on M q'' + 2 c M q' + K q = 0: K's lowest eigenvalue decides, and no stiffness drifts."""
    if not system.stiffness.any(axis=0).all() and damping == 0.0:
        return "unstable"
    if not system.stiffness.any():
        return static_status(0.0, 0.0, damping)
    form = freed.even_form
    if form is None:
        return None
    values = np.linalg.eigvalsh(form.stiffness)
    limit = damping * damping
    slack = float(form.error) + 8.0 * EPS * system.order * float(np.abs(values).max()) + 4.0 * EPS * limit
    return static_status(float(values[0]) + limit, slack, damping)
