"""Verdicts, growth rates and multipliers over batches of systems."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import Bools, Complexes, Floats, Ints, shaped
from floquetrod._util.caching import cached_property
from floquetrod._util.compilation import cores, in_threads
from floquetrod._util.progress import Progress
from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.equations.batches import System, pick
from floquetrod.equations.hill_system import EvenForm, in_first_order, states
from floquetrod.equations.matrices import flat
from floquetrod.floquet.dispatch import judge
from floquetrod.floquet.kernels.constant_matrices import MOST_ROWS, piece_multipliers
from floquetrod.floquet.kernels.constant_pieces import piece_pairs
from floquetrod.floquet.kernels.system_even import pair_numbers
from floquetrod.floquet.multiplier_pairs import logarithms, slopes
from floquetrod.floquet.multipliers import half_period_maps, many_verdicts, whole_period_maps
from floquetrod.floquet.multipliers.classification import MOST_SECONDS
from floquetrod.floquet.multipliers.many_verdicts import ManyVerdicts
from floquetrod.floquet.multipliers.whole_period_maps import PeriodMaps
from floquetrod.floquet.problems import undamped_pairs
from floquetrod.floquet.status import STABLE, STATUS_CODES, UNDECIDED, UNSTABLE, are

_ACCURACY = 1e-12
_MOST_DIGITS = 60  # for an undecided system: the square of a double's last digit and as much again (a choice)
_SMALL = 1e-8  # of the largest multiplier, below which errors are computed (a choice: half the digits of a double)
_VAGUE = 0.5  # of max(1, abs(y)): error of y above which its multipliers are not known (a choice)
_SURE = 1e-7  # of a growth rate: bound of its error up to which it is taken (a choice)
_AT_ONCE = 1 << 14  # entries of maps in a thread at a time (heuristic): some milliseconds of work
_REPORTS = 50  # calls of ``progress`` by the quick rules (a choice)


def is_stable(systems: System, *, workers: int | None = None, progress: Progress | None = None) -> Any:
    """Return whether every solution stays bounded, of each system of a batch.

    Parameters
    ----------
    systems : HillSystem or PeriodicSystem
        One system, or a batch: its matrices and period are arrays with a leading shape.
    workers : int, optional
        Threads; by default one for each core when there is enough to do.
    progress : callable, optional
        Called repeatedly with the numbers of systems done and to do: systems on a boundary to rounding are decided one
        by one, with up to 60 digits, which takes a tenth of a second of two equations, and seconds of many.  An
        exception raised by it ends the work.

    Returns
    -------
    bool or ndarray of bool
        In the leading shape; a Python bool for a single system.

    Raises
    ------
    TypeError, ValueError
        For anything but systems, and fewer workers than 1.

    Warns
    -----
    UndecidedWarning
        When some could not be decided, on a boundary to 60 digits or where multipliers cannot be distinguished: False
        there means "not known to be stable"; `floquetrod.stability` of one says why, and continues to 120 digits.

    Examples
    --------
    >>> import numpy as np
    >>> omega = np.array([1.0, 2.0, 3.0])
    >>> forcing = 0.2 * np.array([[0.5, 1.0], [1.0, 0.8]])
    >>> is_stable(HillSystem(np.diag([1.0, 4.0]), cosines=[forcing], period=2 * np.pi / omega))
    array([ True, False, False])
    """
    stable = shaped(verdicts(systems, workers=workers, progress=progress).status, systems.shape)
    what = "systems could not be decided and count as not stable"
    return are("stable", stable, what, "floquetrod.stability of one says why, and continues to more digits")


def growth_rate(systems: System, *, workers: int | None = None, progress: Progress | None = None) -> Any:
    """Return the growth rate of the fastest solution, per unit of time; 0 where stable, an estimate where undecided.

    Arguments as in `is_stable`.  NaN for systems that would take too long.

    Returns
    -------
    float or ndarray of float
        In the leading shape.

    Raises
    ------
    TypeError, ValueError
        As `is_stable`.

    Examples
    --------
    >>> forcing = [[0.1, 0.2], [0.2, 0.16]]
    >>> round(growth_rate(HillSystem([[1.0, 0.0], [0.0, 4.0]], cosines=[forcing], period=2 * np.pi / 3.0)), 10)
    0.0353277775
    """
    return shaped(verdicts(systems, workers=workers, progress=progress).growth, systems.shape)


@np.errstate(under="ignore")  # as in `floquet.dispatch.run`
def multipliers(systems: System, *, workers: int | None = None, progress: Progress | None = None) -> Any:
    """Return the multipliers, complex (..., N), N the number of equations of first order; the largest first.

    Arguments as in `is_stable`.  NaN, and last, are multipliers lost in the rounding of the largest one, which
    `floquetrod.stability` of one system returns, and multipliers whose squares may be beyond doubles; all are NaN of
    systems that would take too long.

    Returns
    -------
    ndarray of complex
        (..., N), behind the leading shape.

    Raises
    ------
    TypeError, ValueError
        As `is_stable`.
    """
    workers = validate.workers(workers)
    validate.progress(progress)
    batch = _batch(systems)
    largest_first = np.empty((len(batch.period), batch.order), complex)

    def fill(chunk: slice) -> None:
        values = batch.multipliers(chunk)
        if batch.damping > 0.0:
            values *= np.exp(-batch.damping * batch.period[chunk])[:, None]
        order = np.argsort(-np.abs(values), axis=1, kind="stable")
        largest_first[chunk] = values[np.arange(len(values))[:, None], order]

    size = len(batch.period)
    _over(size, batch, fill, workers, progress and (lambda stop: progress(stop, size)))
    return largest_first.reshape(*systems.shape, batch.order)


@np.errstate(under="ignore")  # as in `floquet.dispatch.run`
def verdicts(
    systems: System, *, workers: int | None = None, progress: Progress | None = None, quick: bool = False
) -> ManyVerdicts:
    """Return status (1 stable, 0 unstable, -1 undecided) and growth rate of each system, flat in C order.

    Systems that the quick rules leave undecided are judged as by `floquetrod.stability`, with 60 digits at most; not if
    ``quick``.
    """
    workers = validate.workers(workers)
    validate.progress(progress)
    batch = _batch(systems)
    size = len(batch.period)
    status, growth = np.empty(size, dtype=np.int8), np.empty(size)

    def fill(chunk: slice) -> None:
        status[chunk], growth[chunk] = batch.verdicts(chunk)

    def done(stop: int) -> None:
        if progress is not None:
            progress(int((status[:stop] != UNDECIDED).sum()), size)

    _over(size, batch, fill, workers, progress and done)
    if isinstance(batch, _ConstantPieceBatch) and (left := np.flatnonzero(status == UNDECIDED)).size:
        general = batch.general

        def fill_left(chunk: slice) -> None:
            status[left[chunk]], growth[left[chunk]] = general.verdicts(left[chunk])

        _over(left.size, batch, fill_left, workers, progress and (lambda _: done(size)))
    # One after another, and not in threads: their many digits are Python's, and Ctrl-C is heard at once.
    open_ones = () if quick else np.flatnonzero(status == UNDECIDED).tolist()
    decided = size - len(open_ones)
    for judged, i in enumerate(open_ones, 1):
        result = judge(pick(systems, i), most_digits=_MOST_DIGITS)
        status[i] = STATUS_CODES[result.status]
        growth[i] = result.growth_rate
        if progress is not None:
            progress(decided + judged, size)
    if quick and progress is not None:
        progress(size, size)
    return ManyVerdicts(status, growth)


class _Batch(ABC):
    """Systems with uniform damping removed, flat: periods (b,), the damping, and first-order equations in each."""

    period: Floats
    damping: float
    order: int

    @abstractmethod
    def multipliers(self, chunk: slice) -> Complexes:
        """Return the multipliers of a chunk of systems, without damping; NaN where that would take too long."""

    @abstractmethod
    def verdicts(self, chunk: slice) -> ManyVerdicts:
        """Return the verdicts on a chunk of systems by the quick rules."""


class _EvenPart(NamedTuple):
    """Even systems: mean stiffness, amplitudes, periods, and the error of these coefficients."""

    stiffness: Floats
    amplitudes: Floats
    period: Floats
    uncertainty: Floats

    @property
    def are_simple(self) -> bool:
        """Whether the kernel for two equations applies."""
        return self.stiffness.shape[-1] == 2 and not self.uncertainty.any()


class _EvenBatch(_Batch):
    """Systems for which half a period is enough."""

    def __init__(self, system: HillSystem, form: EvenForm, damping: float) -> None:
        shape = system.shape
        self.stiffness, self.amplitudes = flat(form.stiffness, shape, 2), flat(form.amplitudes, shape, 3)
        self.uncertainty, self.period, self.damping = flat(form.error, shape, 0), flat(system.period, shape, 0), damping
        self.order = 2 * system.order

    @cached_property
    def _single(self) -> _EvenPart:
        """The first system, as by `_checked`."""
        return self._checked(slice(0, 1))

    def _part(self, chunk: slice) -> _EvenPart:
        """Return a chunk of systems as by `_checked`, of one system from what is kept."""
        return self._single if len(self.period) == 1 else self._checked(chunk)

    def _checked(self, chunk: slice) -> _EvenPart:
        """Return a chunk of systems; with zero matrices and infinite uncertainty where they would take too long."""
        stiffness, amplitudes, period = self.stiffness[chunk], self.amplitudes[chunk], self.period[chunk]
        long = half_period_maps.seconds_needed(stiffness, amplitudes, period) > MOST_SECONDS
        if not long.any():
            return _EvenPart(stiffness, amplitudes, period, self.uncertainty[chunk])
        uncertainty = np.where(long, np.inf, self.uncertainty[chunk])
        return _EvenPart(_without(long, stiffness), _without(long, amplitudes), period, uncertainty)

    def multipliers(self, chunk: slice) -> Complexes:
        systems = self._part(chunk)
        if systems.are_simple:
            x, errors, _ = pair_numbers(*systems[:3], _ACCURACY)
            y = np.asarray(0.25 * (x - 2.0))
            y[0.25 * errors > _VAGUE * np.maximum(1.0, np.abs(y))] = np.nan
            if not np.isfinite(x).all():
                lost = np.logical_not(np.isfinite(x).all(axis=1))
                left = _EvenPart(*(array[lost] for array in systems))
                y[lost] = self._pairs(left)
        else:
            y = self._pairs(systems)
            y[np.isinf(systems.uncertainty)] = np.nan
        logs = logarithms(y)
        return np.asarray(np.exp(np.concatenate([logs, -logs], axis=1)))

    def _pairs(self, systems: _EvenPart) -> Complexes:
        """Return the numbers y of the pairs; NaN where they are lost in the rounding of the largest."""
        matrices = half_period_maps.pair_matrices(*systems, _ACCURACY)
        y = _eigenvalues(matrices.matrix)
        doubtful = np.flatnonzero(np.abs(matrices.matrix).max(axis=(1, 2)) > 1.0 / _SMALL)
        if doubtful.size:
            discs = many_verdicts.many_discs(matrices.matrix[doubtful], matrices.error[doubtful])
            lost = discs.radii > _VAGUE * np.maximum(1.0, np.abs(discs.values))
            y[doubtful] = np.where(lost, np.nan, discs.values)
        return y

    def verdicts(self, chunk: slice) -> ManyVerdicts:
        systems = self._part(chunk)
        if systems.are_simple:
            x, errors, _ = pair_numbers(*systems[:3], _ACCURACY)
            discs = many_verdicts.pair_discs(0.25 * (x - 2.0), 0.25 * errors)
        else:
            matrices = half_period_maps.pair_matrices(*systems, _ACCURACY)
            discs = many_verdicts.many_discs(matrices.matrix, matrices.error)
        return many_verdicts.pair_verdicts(discs, systems.period, self.damping)


class _FirstOrderBatch(_Batch):
    """Systems in first order, for maps over a whole period."""

    def __init__(self, system: PeriodicSystem, damping: float, *, paired: bool) -> None:
        self.pieces, self.period = by_pieces.of_batch(system), flat(system.period, system.shape, 0)
        self.uncertainty, self.paired, self.damping = system.coefficient_error, paired, damping
        self.order, self.keeps_norm, self.is_complex = system.order, system.keeps_norm, system.is_complex

    def _maps(self, chunk: slice | Ints) -> PeriodMaps:
        """Return the maps over a period, with infinite error where they would take too long."""
        pieces = self.pieces.some(chunk)
        long = np.asarray(whole_period_maps.seconds_needed(pieces) > MOST_SECONDS)
        uncertainty = np.where(long, np.inf, self.uncertainty)
        pieces = pieces._replace(
            mean=_without(long, pieces.mean),
            slope=None if pieces.slope is None else _without(long, pieces.slope),
            harmonics=_without(long, pieces.harmonics),
        )
        maps = whole_period_maps.period_maps(pieces, uncertainty, _ACCURACY, paired=self.paired)
        return whole_period_maps.of_complex(maps) if self.is_complex else maps

    def multipliers(self, chunk: slice) -> Complexes:
        maps = self._maps(chunk)
        values = _eigenvalues(maps.matrix)
        values[np.isinf(maps.error)] = np.nan
        if self.keeps_norm:
            return values / np.abs(values)
        # Multipliers that cannot be distinguished from 0 beside the largest one are NaN.
        largest = np.abs(maps.matrix).max(axis=(1, 2))
        doubtful = np.flatnonzero(np.abs(values).min(axis=1) < _SMALL * largest)
        if doubtful.size:
            discs = many_verdicts.many_discs(maps.matrix[doubtful], maps.error[doubtful])
            values[doubtful] = np.where(many_verdicts.touch_zero(discs), np.nan, discs.values)
        return values

    def verdicts(self, chunk: slice | Ints) -> ManyVerdicts:
        if self.keeps_norm:
            count = len(self.period[chunk])
            return ManyVerdicts(np.full(count, STABLE, dtype=np.int8), np.zeros(count))
        maps = self._maps(chunk)
        discs = many_verdicts.many_discs(maps.matrix, maps.error)
        return many_verdicts.multiplier_verdicts(discs, self.period[chunk], paired=self.paired, damping=self.damping)


class _ConstantPieceBatch(_Batch):
    """Systems of few equations, constant on each piece: verdicts by compiled maps, multipliers by the general ones."""

    def __init__(self, system: System, damping: float, *, paired: bool) -> None:
        self.system, self.damping, self.paired = system, damping, paired
        self.order = states(system)

    @cached_property
    def _first_order_system(self) -> PeriodicSystem:
        """The same systems in first order, of mass 1."""
        return in_first_order(self.system)

    @cached_property
    def general(self) -> _FirstOrderBatch:
        """The batch of the same systems for multipliers, and for verdicts that the compiled maps leave open."""
        return _FirstOrderBatch(self._first_order_system, self.damping, paired=self.paired)

    def multipliers(self, chunk: slice) -> Complexes:
        return self.general.multipliers(chunk)


class _OscillatorPieceBatch(_ConstantPieceBatch):
    """One or two equations u'' + K u = 0, K symmetric and constant on each piece: maps in closed form."""

    def __init__(self, system: HillSystem, damping: float) -> None:
        super().__init__(system, damping, paired=True)
        n = system.order
        if system.mass is None:
            pieces, error = by_pieces.of_batch(system), system.error_norm
            self.stiffness = pieces.mean
        else:
            pieces, error = by_pieces.of_batch(self._first_order_system), n * self._first_order_system.coefficient_error
            self.stiffness = -pieces.mean[:, :, n:, :n]
        self.length, self.period, self.uncertainty = pieces.length, pieces.period, flat(error, system.shape, 0)

    def verdicts(self, chunk: slice) -> ManyVerdicts:
        values, radii = piece_pairs(self.stiffness[chunk], self.length[chunk], self.uncertainty[chunk])
        return many_verdicts.pair_verdicts(many_verdicts.pair_discs(values, radii), self.period[chunk], self.damping)


class _MatrixPieceBatch(_ConstantPieceBatch):
    """Up to four equations x' = A x, A constant on each piece: exponentials by series, multipliers by polynomials."""

    def __init__(self, system: PeriodicSystem, damping: float, *, paired: bool) -> None:
        super().__init__(system, damping, paired=paired)
        pieces = by_pieces.of_batch(system)
        self.matrices, self.length, self.period = pieces.mean, pieces.length, pieces.period
        entries = whole_period_maps.uncertain_entries(pieces.mean)
        self.uncertainty: Floats = np.where(entries, system.coefficient_error, 0.0)

    def verdicts(self, chunk: slice) -> ManyVerdicts:
        period = self.period[chunk]
        found = piece_multipliers(self.matrices[chunk], self.length[chunk], self.uncertainty, paired=self.paired)
        if found is None:
            return ManyVerdicts(np.full(len(period), UNDECIDED, dtype=np.int8), np.zeros(len(period)))
        values, radii = found
        discs = many_verdicts.pair_discs(values, radii)
        if self.paired:
            judged = many_verdicts.pair_verdicts(discs, period, self.damping)
            sizes, errors = np.abs(logarithms(values).real), slopes(values, 1.0 + values, radii)
        else:
            judged = many_verdicts.multiplier_verdicts(discs, period, paired=False, damping=0.0)
            sizes = np.abs(values)
            with np.errstate(divide="ignore", invalid="ignore"):
                errors = radii / sizes
        fastest = np.arange(len(sizes)), sizes.argmax(axis=1)
        with np.errstate(over="ignore", invalid="ignore"):
            vague = np.logical_not(errors[fastest] <= _SURE * judged.growth * period)
        judged.status[vague & (judged.status == UNSTABLE)] = UNDECIDED
        return judged


def _eigenvalues(matrices: NDArray[Any]) -> Complexes:
    """Return the eigenvalues of matrices (b, n, n), NaN where one is not finite."""
    lost = np.logical_not(np.isfinite(matrices).all(axis=(1, 2)))
    values = np.linalg.eigvals(_without(lost, matrices)).astype(np.complex128)
    values[lost] = np.nan
    return values


def _without(rows: Bools, array: NDArray[Any]) -> NDArray[Any]:
    """Return an array with zeros in the rows marked in ``rows``."""
    return np.where(rows.reshape(-1, *(1,) * (array.ndim - 1)), 0.0, array) if rows.any() else array


def _batch(systems: Any) -> _Batch:
    """Return systems, checked, in the form of the fastest method; of one system it is kept with it."""
    if not isinstance(systems, HillSystem | PeriodicSystem):
        raise TypeError(
            f"systems must be a HillSystem or PeriodicSystem, one or a batch of them, got {validate.short(systems)}; "
            "floquetrod.systems.stack makes a batch of a list"
        )
    kept: _Batch | None = vars(systems).get("_batch")
    if kept is None:
        kept = _formed(systems)
        if not systems.shape:  # of many systems it would keep as much memory as they take
            vars(systems)["_batch"] = kept
    return kept


def _formed(systems: System) -> _Batch:
    """Return systems in the form of the fastest method that serves all of them."""
    pairs = undamped_pairs(systems)
    subject, damping = pairs if pairs is not None else (systems, 0.0)
    if isinstance(subject, HillSystem):
        if pairs is not None and subject.even_form is not None:
            return _EvenBatch(subject, subject.even_form, damping)
        symmetric = subject.is_symmetric and subject.gyroscopic is None
        if pairs is not None and subject.order <= 2 and symmetric and _has_constant_pieces(subject):
            return _OscillatorPieceBatch(subject, damping)
        subject = subject.as_periodic_system()
    few = subject.order * (1 + subject.is_complex) <= MOST_ROWS
    if few and _has_constant_pieces(subject) and not subject.keeps_norm:
        return _MatrixPieceBatch(subject, damping, paired=pairs is not None)
    return _FirstOrderBatch(subject, damping, paired=pairs is not None)


def _has_constant_pieces(system: System) -> bool:
    """Return whether the matrix of the system is constant on every piece."""
    return bool(system.pieces) and all(value.is_constant for _, value in system.pieces)


def _over(
    size: int, batch: _Batch, fill: Callable[[slice], None], workers: int | None, done: Callable[[int], Any] | None
) -> None:
    """Call ``fill`` with parts of ``size`` systems, in threads if it pays; ``done`` hears how many are done."""
    step = max(1, _AT_ONCE // batch.order**2)
    chunks = [(slice(start, min(size, start + step)),) for start in range(0, size, step)]
    threads = workers or cores()
    together = len(chunks) if done is None else max(4 * threads, len(chunks) // _REPORTS)
    for first in range(0, len(chunks), max(1, together)):
        group = chunks[first : first + together]
        in_threads(fill, group, threads)
        if done is not None:
            done(group[-1][0].stop)
