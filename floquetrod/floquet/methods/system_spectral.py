"""Eigenvalues of Hill's matrix, whose rows are the harmonics of Floquet solutions."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import Complexes, Floats
from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.equations.complex_form import complex_matrix
from floquetrod.equations.hill_system import in_first_order
from floquetrod.floquet.multipliers import independent_solutions, spectra
from floquetrod.floquet.multipliers.classification import classify_multipliers
from floquetrod.floquet.multipliers.independent_solutions import Solutions
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.multipliers.whole_period_maps import error_stretch
from floquetrod.floquet.problems import undamped_pairs
from floquetrod.floquet.proof.balls import Doubles
from floquetrod.floquet.proof.many_digits import TooMuchWork, Unresolved
from floquetrod.floquet.proof.system_counts import Counts, angles_between, count
from floquetrod.floquet.proof.system_numbers import system_problem
from floquetrod.floquet.verdict import Cost

_MOST_ROWS = 1000  # of Hill's matrix (a choice: about ten seconds)


class _Harmonics(NamedTuple):
    """A system in first order and balanced coordinates, and the scales of these.

    A(t) = mean + sum_k halves_k exp(i k w t) + behind_k exp(-i k w t), behind_k = conj(halves_k) where A is real.
    ``stretch`` is by how much errors of the coefficients are larger there.  ``keeps_norm``: coordinates are as given,
    and Hill's matrix is skew-Hermitian.
    """

    mean: NDArray[Any]
    halves: Complexes
    behind: Complexes
    keeps_norm: bool
    scales: Floats
    stretch: float
    period: float


def spectral(system: HillSystem | PeriodicSystem, *, rtol: float = 1e-12) -> SystemStability:
    """Classify by the eigenvalues of Hill's matrix, and by counts of its Hermitian form.

    A solution exp(s t) sum_k p_k exp(i k w t) of x' = A(t) x makes s an eigenvalue of the infinite matrix of blocks
    A_(j-k) - i k w delta_jk.  It is truncated where the harmonics of the solutions have decayed.  Each solution appears
    with every s + i k w; of these the one is taken whose harmonics are centred about k = 0.

    *Hamiltonian second-order systems.*  Where the counts of `floquetrod.floquet.proof.system_counts` vary by n they
    show strong stability, also where multipliers of one Krein sign coincide.

    Parameters
    ----------
    system : HillSystem or PeriodicSystem
        One whose truncated matrix has at most 1,000 rows; else the result is undecided.
    rtol : float
        Size of the neglected harmonics, times the largest rate in the system, from 1e-15 to 1e-3.

    Returns
    -------
    SystemStability
        Its errors are estimates: condition numbers of the eigenvalues times rounding and truncation, and the change to
        a longer truncation.

    Raises
    ------
    TypeError, ValueError
        For a system in several pieces, and an accuracy outside 1e-15 to 1e-3.

    Examples
    --------
    >>> spectral(HillSystem([[1.0, 0.0], [0.0, 4.0]], cosines=[[[0.1, 0.2], [0.2, 0.16]]])).strongly_stable
    True
    """
    rtol = validate.within("rtol", rtol, 1e-15, 1e-3)
    freed = undamped_pairs(system)
    subject, damping = freed or (system, 0.0)
    first = in_first_order(subject)
    balanced = _balanced(first)
    solutions, rows = _solutions(balanced, rtol, first.coefficient_error)
    cost = Cost(rows, "rows")
    if solutions is None:
        note = f"needs Hill matrices of more than {_MOST_ROWS} rows, or its solutions cannot be distinguished"
        return SystemStability.declined(system, "spectral", cost, note)
    logs = independent_solutions.log_discs(solutions, damping * balanced.period, are_real=not first.is_complex)
    hamiltonian = freed is not None and first.structure == "hamiltonian"
    turns = solutions.logs.imag / (2.0 * math.pi)
    counted = _counted(system, turns) if hamiltonian and isinstance(system, HillSystem) else None

    def krein(cluster: NDArray[np.intp]) -> int:
        if counted is not None and counted.variation == system.order:
            return counted.krein_sign(turns[cluster])
        return independent_solutions.krein_sign(solutions, cluster)

    return classify_multipliers(system, "spectral", logs, krein=krein if hamiltonian else None, cost=cost)


def _counted(system: HillSystem, turns: Floats) -> Counts | None:
    """Return counts at angles between the multipliers, damping removed; None where the matrices are too large."""
    problem: Any = system_problem(system)
    try:
        with np.errstate(all="ignore"):  # what is not finite is not counted
            freed = problem.oscillators(Doubles(), problem.period, freed=True)
            return count(Doubles(), freed, angles_between(np.exp(2j * math.pi * turns)))
    except (Unresolved, TooMuchWork, np.linalg.LinAlgError):
        return None


def _balanced(system: PeriodicSystem) -> _Harmonics:
    """Return a system in balanced coordinates, powers of two times those it has."""
    waves = system.real_form.harmonics
    ahead, behind = waves, waves.conj()
    if system.is_complex:
        ahead, behind = complex_matrix(ahead), complex_matrix(behind)
    sizes = np.abs(system.mean) + np.maximum(np.abs(ahead), np.abs(behind)).sum(axis=0)
    scales = np.ones(system.order) if system.keeps_norm else independent_solutions.balance(sizes)
    ratio = scales[None, :] / scales[:, None]
    stretch = float(error_stretch(system.mean[None, None], scales[None])[0])
    harmonics = 0.5 * ahead * ratio, 0.5 * behind * ratio
    return _Harmonics(system.mean * ratio, *harmonics, system.keeps_norm, scales, stretch, float(system.period))


def _solutions(system: _Harmonics, rtol: float, coefficient_error: float) -> tuple[Solutions | None, int]:
    """Return independent Floquet solutions in the system's own coordinates, and the rows of the last matrix."""
    w = 2.0 * math.pi / system.period
    norms = [max(float(np.linalg.norm(z, 2)) for z in pair) for pair in zip(system.halves, system.behind, strict=True)]
    rate = float(np.linalg.norm(system.mean, 2)) + 2.0 * sum(norms)
    fastest = float(np.abs(np.linalg.eigvals(system.mean).imag).max())
    cut = math.ceil(min(fastest / w, 1e9)) + min(len(norms), 4) + 6
    order = len(system.mean)
    rows = 0
    while order * (2 * cut + 1) <= _MOST_ROWS:
        rows = order * (2 * cut + 1)
        truncated = _truncated(system, cut, norms, coefficient_error)
        if truncated is None:
            return None, rows
        solutions, neglected = truncated
        if neglected <= max(rtol, 1e-15) * rate:
            return _compared(system, solutions, cut), rows
        cut += 4 + cut // 4
    return None, rows


def _compared(system: _Harmonics, solutions: Solutions, cut: int) -> Solutions:
    """Return solutions with the change to a longer truncation added to their errors."""
    longer = np.linalg.eigvals(_hill_matrix(system, cut + 2)).astype(np.complex128) * system.period
    change = spectra.log_distances(solutions.logs, longer).min(axis=1)
    return solutions._replace(radii=solutions.radii + change)


def _truncated(
    system: _Harmonics, cut: int, norms: list[float], coefficient_error: float
) -> tuple[Solutions, float] | None:
    """Return the solutions of a truncated matrix and the largest residual that truncation leaves, None where few."""
    order, count = len(system.mean), 2 * cut + 1
    discs_of = spectra.normal_discs if system.keeps_norm else spectra.diagonalised_discs
    discs = discs_of(_hill_matrix(system, cut), coefficient_error * order * system.stretch)
    if discs is None:
        return None
    harmonics = discs.right.reshape(count, order, -1)
    weights = np.square(np.abs(harmonics)).sum(axis=1)
    centre = np.abs(np.arange(-cut, cut + 1) @ weights)
    near = np.flatnonzero(centre < 0.5 * cut)
    chosen = independent_solutions.independent(harmonics.sum(axis=0)[:, near], centre[near])
    if chosen is None:
        return None
    chosen = near[chosen]
    neglected = np.zeros(order)
    for m, norm in enumerate(norms, start=1):
        outer = weights[:m, chosen].sum(axis=0) + weights[max(count - m, 0) :, chosen].sum(axis=0)
        neglected += norm * np.sqrt(outer)
    conditions = np.linalg.norm(discs.left[chosen], axis=1)
    radii = (discs.radii[chosen] + conditions * neglected) * system.period
    states = harmonics.sum(axis=0)[:, chosen] * system.scales[:, None]
    states = states / np.linalg.norm(states, axis=0)
    logs = independent_solutions.principal(discs.values[chosen] * system.period)
    return Solutions(logs, radii, states), float(neglected.max())


def _hill_matrix(system: _Harmonics, cut: int) -> Complexes:
    """Return the block of Hill's matrix of the harmonics -cut to cut."""
    order, w = len(system.mean), 2.0 * math.pi / system.period
    result = np.zeros((2 * cut + 1, order, 2 * cut + 1, order), dtype=np.complex128)
    for j in range(2 * cut + 1):
        result[j, :, j] = system.mean - 1j * w * (j - cut) * np.eye(order)
        for m, (half, behind) in enumerate(zip(system.halves, system.behind, strict=True), start=1):
            if j + m <= 2 * cut:
                result[j + m, :, j] = half
                result[j, :, j + m] = behind
    return result.reshape((2 * cut + 1) * order, (2 * cut + 1) * order)
