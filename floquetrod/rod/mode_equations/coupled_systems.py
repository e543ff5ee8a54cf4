"""Modes as systems of equations in seconds: status, growth and resonances of any number under many loads."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.compilation import cores, in_threads
from floquetrod._util.progress import Progress, shifted
from floquetrod.equations.batches import pick
from floquetrod.equations.hill_system import HillSystem, restricted
from floquetrod.floquet.multipliers.many_verdicts import ManyVerdicts
from floquetrod.floquet.multipliers.resonance_names import Resonance
from floquetrod.floquet.multipliers.resonating_modes import resonating
from floquetrod.floquet.verdict import tolerated
from floquetrod.rod.loads.load import Load, Loads, Quantity

SEVERAL = 60  # modes up to which a verdict on all takes less time than choosing some or following one (measured)
_LEAST_ON_LINE = 16  # loads: of fewer each gets a map of its own (measured)
_AT_ONCE = 1 << 22  # numbers in the matrices of systems that are held at once: 32 megabytes


class CoupledEquations(ABC):
    """The equations q'' + 2 c q' + K(t) q = 0 of so many modes under any load of a kind, as systems in seconds.

    Attributes
    ----------
    template : Load
        Gives all properties of the loads except mean, amplitude and frequency.
    count : int
        Number of modes: the number of equations, or less where further unknowns are added.
    """

    template: Load
    count: int

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of equations."""

    @property
    @abstractmethod
    def damping_rate(self) -> float:
        """Decay rate c of free motion in 1/s, the same in all."""

    @abstractmethod
    def damped(self, rate: float) -> Self:
        """Return the same equations with another decay rate."""

    @abstractmethod
    def system(self, loads: Loads) -> HillSystem:
        """Return the systems of flat loads as one batch, or a single one where there is one load of the shape ().

        The mean of K is affine in the mean force where `is_affine` says so, the rest proportional to the amplitude.
        """

    @abstractmethod
    def stiffness(self, mean: Floats) -> Floats:
        """Return the mean of K under mean forces in N, in 1/s^2: (loads, size, size)."""

    def shapes(self, x: Floats) -> Floats:
        """Return the deflection along the rod of each coordinate, at x = s / L: (size, len(x))."""
        raise ValueError(f"{type(self).__name__} does not say how its coordinates bend the rod, so there is no shape")

    def forced_angle(self, load: Load, system: HillSystem | None = None) -> float | None:
        """Return how far in rad a load moves the rod along its wall by itself; None where it only pushes along.

        ``system`` is that under the load, if it is known.
        """
        return None

    def is_affine(self, low: float, high: float) -> bool:
        """Return whether the mean of K is affine in the mean force between two, and the rest does not depend on it."""
        return True

    @property
    def are_apart(self) -> bool:
        """Whether the coordinates are the modes themselves, each with an equation of its own."""
        return False

    @property
    def are_nested(self) -> bool:
        """Whether the equations of fewer modes are the first of these, without what couples them to the others."""
        return False

    @property
    def added(self) -> int:
        """Coordinates that come before those named after modes."""
        return 0

    def answers(
        self,
        loads: Loads,
        growth_tolerance: float = 0.0,
        workers: int | None = None,
        *,
        quick: bool = False,
        progress: Progress | None = None,
    ) -> ManyVerdicts:
        """Return statuses and growth rates in 1/s of the fastest solutions, estimates where undecided.

        The status is 1 where no solution grows faster than the tolerance (1/s), 0 where one does, -1 where undecided.
        With ``quick`` no load takes long, and loads next to a boundary stay undecided.
        ``progress`` is called repeatedly with the numbers of loads done and of all.
        """
        status, growth = np.full(loads.size, -1, dtype=np.int8), np.full(loads.size, np.nan)
        for answered in (self._of_resonating, self._on_lines):
            left = np.flatnonzero(status == -1)
            told = shifted(progress, loads.size - left.size, loads.size - left.size)
            status[left], growth[left] = answered(loads.some(left), workers, told)
        left = np.flatnonzero(status == -1)
        done = loads.size - left.size
        for part in self._parts(left):
            told = shifted(progress, done, loads.size - part.size)
            status[part], growth[part] = self._answers(loads.some(part), workers, quick, told)
            done += part.size
            if progress is not None:
                progress(done, loads.size)
        status[tolerated(growth, growth_tolerance)] = 1
        return ManyVerdicts(status, growth)

    def _of_resonating(self, loads: Loads, workers: int | None, progress: Progress | None) -> ManyVerdicts:
        """Return statuses without tolerance, and growth rates, of loads under which most of many modes cannot resonate.

        They are verdicts by the quick rules on those that may; -1 and NaN of other loads, and where these are open.
        """
        from floquetrod.systems.batch_verdicts import verdicts

        status, growth = np.full(loads.size, -1, dtype=np.int8), np.full(loads.size, np.nan)
        shaken = np.flatnonzero(loads.amplitude > 0.0) if self.count > SEVERAL and not self.are_apart else ()
        for some in self._parts(np.asarray(shaken, dtype=np.intp)):
            systems = self.system(loads.some(some))

            def fill(place: int, i: int, systems: HillSystem = systems) -> None:
                system: Any = pick(systems, place)
                part = resonating(system)
                answer = None if part is None else verdicts(part.system, workers=1, quick=True)
                if answer is not None and answer.status[0] != -1:
                    status[i], growth[i] = answer.status[0], answer.growth[0]

            in_threads(fill, list(enumerate(some.tolist())), validate.workers(workers) or cores())
            if progress is not None:
                progress(int(np.count_nonzero(status != -1)), loads.size)
        return ManyVerdicts(status, growth)

    def _on_lines(self, loads: Loads, workers: int | None, progress: Progress | None) -> ManyVerdicts:
        """Return statuses without tolerance, and growth rates, of loads that differ in one force alone; else -1, NaN.

        Their systems lie on straight lines: the maps of a few systems on a line give the maps of all.
        """
        status, growth = np.full(loads.size, -1, dtype=np.int8), np.full(loads.size, np.nan)

        def fill(varied: Quantity, line: NDArray[np.intp]) -> None:
            along = self._along(loads.some(line), varied)
            if along is not None:
                status[line], growth[line] = along

        lines = [] if self.are_apart else list(loads.lines(_LEAST_ON_LINE))
        threads = validate.workers(workers) or cores()
        together = len(lines) if progress is None else threads
        for first in range(0, len(lines), max(1, together)):
            in_threads(fill, lines[first : first + together], threads)
            if progress is not None:
                progress(int(np.count_nonzero(status != -1)), loads.size)
        return ManyVerdicts(status, growth)

    def _along(self, loads: Loads, varied: Quantity) -> ManyVerdicts | None:
        """Return quick verdicts on loads that differ in the force ``varied`` alone, None if a line saves no time."""
        from floquetrod.floquet.multipliers.verdicts_along_lines import verdicts_along

        values: Floats = getattr(loads, varied)
        ends = loads.some(np.array([values.argmin(), values.argmax()]))
        low, high = getattr(ends, varied)
        if not low < high or (varied == "mean" and not self.is_affine(float(low), float(high))):
            return None
        return verdicts_along(self.system(ends), np.clip((values - low + (values - high)) / (high - low), -1.0, 1.0))

    def _answers(self, loads: Loads, workers: int | None, quick: bool, progress: Progress | None) -> ManyVerdicts:
        """Return statuses without tolerance, and growth rates, of loads whose matrices are held at once."""
        still = loads.amplitude == 0.0
        if not still.any():
            return self._judged(self.system(loads), workers, quick, progress)
        status, growth = np.empty(loads.size, dtype=np.int8), np.empty(loads.size)
        status[still], growth[still] = self.static_answers(loads.mean[still])
        if not still.all():
            at = np.flatnonzero(~still)
            told = shifted(progress, loads.size - at.size, loads.size - at.size)
            status[at], growth[at] = self._judged(self.system(loads.some(at)), workers, quick, told)
        return ManyVerdicts(status, growth)

    def static_answers(self, mean: Floats) -> ManyVerdicts:
        """Return statuses and growth rates in 1/s under mean forces (N) alone, from the least eigenvalue of stiffness.

        Undecided where rounding hides its sign; the growth rate is the largest possible one then.
        """
        squared = np.linalg.eigvalsh(self.stiffness(mean))
        error = self.size * np.finfo(np.float64).eps * np.abs(squared).max(axis=1)
        least, rate = squared[:, 0], self.damping_rate
        status = np.where(least > error, 1, np.where(least < -error, 0, -1)).astype(np.int8)
        against = np.maximum(0.0, np.where(status == -1, error - least, -least))
        return ManyVerdicts(status, against / (rate + np.sqrt(rate * rate + against) + (against == 0.0)))

    def growth_without_decay(self, loads: Loads) -> Floats:
        """Return the growth in 1/s of exp(c t) q, c the damping rate: the growth of q plus c; NaN where unknown."""
        system = self.system(loads)
        freed, _ = system.undamped or (system, 0.0)
        return self._judged(freed, None, quick=True).growth

    def _judged(
        self, system: HillSystem, workers: int | None, quick: bool, progress: Progress | None = None
    ) -> ManyVerdicts:
        """Return statuses and growth rates of systems, where modes are apart each by its own equation."""
        from floquetrod.systems.batch_verdicts import verdicts

        if not self.are_apart:
            return verdicts(system, workers=workers, quick=quick, progress=progress)
        status, growth = verdicts(_one_by_one(system), workers=workers, quick=quick)
        status, growth = status.reshape(-1, self.size), growth.reshape(-1, self.size)
        worst = np.where((status == 0).any(axis=1), 0, status.min(axis=1)).astype(np.int8)
        return ManyVerdicts(worst, growth.max(axis=1))

    def changed(self, bending: float, force: float, weight: float) -> Self:
        """Return the same modes with bending stiffness, weight along and weight across the rod changed by factors."""
        raise ValueError(f"{type(self).__name__} does not say what its equations owe to the rod, so it cannot change")

    def growth_of(self, load: Load, mode: int | None) -> float:
        """Return the growth in 1/s under one load: of the last mode, if it has an equation of its own, else of all."""
        from floquetrod.floquet.dispatch import stability

        if mode is not None and self.are_apart:
            return stability(restricted(self.system(Loads.single(load)), slice(-1, None))).growth_rate
        return float(self.answers(Loads.single(load)).growth[0])

    def resonances(self, load: Load) -> tuple[Resonance, ...]:
        """Return the resonances that grow under one load, the fastest first, modes numbered as without axial force."""
        from floquetrod.floquet.dispatch import stability

        system = self.system(Loads.single(load))
        return self.named(system, stability(system).resonances)

    def named(self, system: HillSystem, resonances: tuple[Resonance, ...]) -> tuple[Resonance, ...]:
        """Return resonances whose modes are counted by frequency under the mean force, with their own numbers."""
        if not resonances:
            return ()
        if self.are_apart:
            return _direct(system)
        left = np.abs(np.linalg.eigh(system.stiffness)[1])  # functions by modes
        names = {}
        for _ in range(len(left)):  # each mode is named after the function that it has most of, the clearest first
            function, mode = np.unravel_index(left.argmax(), left.shape)
            number = int(function) - self.added  # what is added comes after the modes
            names[int(mode) + 1] = number + 1 if number >= 0 else len(left) + number + 1
            left[function, :] = left[:, mode] = -1.0
        return tuple(r._replace(modes=tuple(sorted(names[i] for i in r.modes))) for r in resonances)

    def _parts(self, left: NDArray[np.intp]) -> list[NDArray[np.intp]]:
        """Return indices of loads in parts whose matrices are held at once."""
        each = self.size**2 * (1 + 2 * len(self.template.harmonics))
        step = max(1, _AT_ONCE // each)
        return [left[i : i + step] for i in range(0, left.size, step)]


def _direct(system: HillSystem) -> tuple[Resonance, ...]:
    """Return the growing modes of a system without coupling, the fastest first."""
    from floquetrod.systems.batch_verdicts import verdicts

    status, growth = verdicts(_one_by_one(system))
    resonances = []
    for i in np.argsort(-growth, kind="stable").tolist():
        if status[i] == 0:
            squared = float(system.stiffness[i, i])
            order = round(math.sqrt(max(squared, 0.0)) * float(system.period) / math.pi)
            kind: Literal["direct", "buckling"] = "direct" if squared > 0.0 else "buckling"
            resonances.append(Resonance(kind, (i + 1,), max(order, 1) if squared > 0.0 else 0, float(growth[i])))
    return tuple(resonances)


def _one_by_one(systems: HillSystem) -> HillSystem:
    """Return the diagonals of a system (n, n), or of a batch (b, n, n), as single equations (b n, 1, 1)."""

    def diagonal(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.diagonal(matrix, axis1=-2, axis2=-1).reshape(-1, 1, 1)

    damping = systems.damping
    return HillSystem(
        diagonal(systems.stiffness),
        [diagonal(matrix) for matrix in systems.cosines],
        [diagonal(matrix) for matrix in systems.sines],
        damping=None if damping is None else damping[..., :1, :1],
        period=np.repeat(systems.period, systems.order),
    )
