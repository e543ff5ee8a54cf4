"""The rod on the channel floor: data sheet and load in, verdict over all modes that matter out."""

from __future__ import annotations

import math
import tomllib
import warnings
from collections.abc import Iterable
from dataclasses import MISSING, dataclass, fields, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arrays import broadcast, plain, shaped
from floquetrod._util.compilation import over_chunks
from floquetrod.friction.fates import UndecidedWarning
from floquetrod.kernels import rod_modes as kernels
from floquetrod.mathieu.criterion import FiniteTimeCriterion
from floquetrod.rod.coulomb import Coulomb, friction_coefficient
from floquetrod.rod.data import NEGLIGIBLE_GROWTH, RodData
from floquetrod.rod.friction import (
    CriticalKick,
    FrictionalRodStability,
    critical_kick,
    critical_kicks,
    judge_kick,
    kicked_loads,
)
from floquetrod.rod.load import LARGEST_FORCE, LARGEST_FREQUENCY, LEAST_FREQUENCY, AxialLoad, load_array
from floquetrod.rod.ranges import QUANTITIES, SafeRanges, safe_ranges
from floquetrod.rod.stability import RodStability, judge_modes
from floquetrod.rod.tongues import HAIRLINE_GROWTH, Progress, Quantity, unstable_loads

_PIECES: dict[Quantity, int] = {"mean": 32, "amplitude": 8}  # that the first edge is searched in, one by one (a choice)
_UNIFORM_UP_TO = 0.1  # ratio of forcing speed to wave speed up to which the force counts as uniform (heuristic)


class UniformForceWarning(UserWarning):
    """The load changes too fast for the axial force to be the same all along the rod."""


@dataclass(frozen=True)
class Rod(RodData):
    """A straight elastic rod of circular section on the floor of a horizontal circular channel, ends hinged.

    Parameters
    ----------
    youngs_modulus : float
        E in Pa.
    density : float
        rho in kg/m^3.
    radius, length : float
        r and L in m.
    channel_radius : float
        Inner radius of the channel in m, greater than the rod's.
    gravity : float
        g in m/s^2.
    damping_rate : float
        Decay rate of free motion in 1/s.

    Notes
    -----
    Eq. (1) of DOI 10.1115/1.4031710.  Properties and mode equations are those of `floquetrod.rod_data.RodData`.

    Examples
    --------
    >>> Rod.nitinol().modes_needed(AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0))[0]
    22
    """

    @classmethod
    def from_toml(cls, path: str | Path) -> Rod:
        """Read a rod from a TOML file.

        Keys are the parameters of `Rod`; values are numbers in SI units, or strings with a unit such as "68GPa" or
        "0.8mm".  Raises ValueError, naming file and key, for what cannot be read, is missing or is not known.
        """
        path = validate.path("path", path)
        try:
            table = tomllib.loads(path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise ValueError(f"rod file {path} cannot be read: {error}") from None
        known = {f.name: f.default is MISSING for f in fields(cls)}
        unknown = [key for key in table if key not in known]
        missing = [name for name, needed in known.items() if needed and name not in table]
        if unknown or missing:
            what = [f"unknown key {key!r}" for key in unknown] + [f"missing key {name!r}" for name in missing]
            raise ValueError(f"rod file {path}: {', '.join(what)}; the keys are {', '.join(known)}")
        try:
            return cls(**{key: units.quantity(value, key, units.ROD_KINDS[key]) for key, value in table.items()})
        except (TypeError, ValueError) as error:
            raise ValueError(f"rod file {path}: {error}") from None

    @overload
    def stability(
        self, load: AxialLoad, modes: Iterable[int] | None = None, growth_tolerance: float = 0.0, friction: None = None
    ) -> RodStability: ...

    @overload
    def stability(
        self,
        load: AxialLoad,
        modes: Iterable[int] | None = None,
        growth_tolerance: float = 0.0,
        *,
        friction: Coulomb,
    ) -> FrictionalRodStability: ...

    def stability(
        self,
        load: AxialLoad,
        modes: Iterable[int] | None = None,
        growth_tolerance: float = 0.0,
        friction: Coulomb | None = None,
    ) -> RodStability | FrictionalRodStability:
        """Judge the rod under a load: stable when every mode is.

        Parameters
        ----------
        load : AxialLoad
        modes : iterable of int, optional
            Modes to look at; by default all that can matter, see `modes_needed`.
        growth_tolerance : float
            Growth rate in 1/s up to which a mode counts as stable.
        friction : Coulomb, optional
            Friction with the floor, and the kick that every mode is given: stable when it sets off none of them.

        Returns
        -------
        RodStability, or FrictionalRodStability where friction is given

        Warns
        -----
        UniformForceWarning
            When omega L / (2 pi) exceeds a tenth of the axial wave speed (a heuristic limit).

        Examples
        --------
        >>> rod = Rod.nitinol()
        >>> load = AxialLoad(mean=0.2 * rod.critical_force, amplitude=0.2 * rod.critical_force, frequency=150.0)
        >>> rod.stability(load).unstable_modes
        (7,)
        """
        validate.instance("load", load, AxialLoad)
        friction = None if friction is None else _coulomb(friction)
        growth_tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
        self._warn_unless_uniform(load)
        if modes is None:
            last, left_out = self.modes_needed(load)  # the growth rate is that of all modes, tolerated or not
            chosen = tuple(range(1, last + 1))
            cutoff = (
                f"modes 1 to {last}: every higher mode grows at less than {left_out:.1g} per second"
                if left_out > 0.0
                else f"modes 1 to {last}: no higher mode can grow"
            )
        else:
            chosen = validate.modes(modes)
            left_out = math.inf
            cutoff = f"the {len(chosen)} modes asked for; nothing is said about others"
        equations = self.mode_equations(load, chosen)
        linear = judge_modes(self, load, chosen, equations, growth_tolerance, left_out, cutoff)
        return linear if friction is None else judge_kick(linear, friction)

    def critical_velocity(self, load: AxialLoad, mu: float, growth_tolerance: float = 0.0) -> CriticalKick:
        """Return the smallest transverse velocity in m/s found to buckle the rod against friction, and the mode.

        Every mode is taken to be kicked with that amplitude; infinite where nothing grows even without friction.
        Beside it stands the velocity up to which no kick buckles the rod, which is proved.

        Examples
        --------
        >>> rod = Rod.nitinol()
        >>> load = AxialLoad(mean=0.825 * rod.critical_force, amplitude=0.7 * rod.critical_force, frequency=150.0)
        >>> velocity, mode, none_up_to = rod.critical_velocity(load, mu=0.1)
        >>> round(1e3 * velocity, 1), mode, round(1e3 * none_up_to, 1)
        (32.1, 9, 27.8)
        """
        mu = friction_coefficient(mu)
        return critical_kick(self.stability(load, None, growth_tolerance), mu)

    def critical_velocities(
        self,
        mean: Any,
        amplitude: Any,
        frequency: Any,
        mu: float,
        *,
        growth_tolerance: float = 0.0,
        workers: int | None = None,
    ) -> CriticalKick:
        """Return what `critical_velocity` does over arrays of loads (N, N, rad/s) that broadcast; mode 0 for none."""
        mu = friction_coefficient(mu)
        tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
        shape, *loads = self._loads(mean, amplitude, frequency)
        found = critical_kicks(self, loads[:3], mu, tolerance, workers)
        return CriticalKick(*(shaped(part, shape) for part in found))

    def stable_mean_forces(
        self,
        amplitude: float,
        frequency: float,
        upto: float | None = None,
        growth_tolerance: float = HAIRLINE_GROWTH,
        *,
        progress: Progress | None = None,
    ) -> SafeRanges:
        """Return all stable intervals of the mean force from 0 to ``upto`` (N; by default 1.5 critical forces).

        Complete, with damping and tolerance too: tongues are found by counting, and inside one the growth is concave in
        the mean force (docs/ranges.md).

        Parameters
        ----------
        amplitude, frequency : float
            dF in N and omega in rad/s.
        growth_tolerance : float
            Growth rate in 1/s up to which a mode counts as stable.  The default leaves out, and counts, the hairlines
            in which nothing grows tenfold within a month; with 0 every tongue is resolved, which takes long where
            there are thousands, at low frequencies.
        progress : callable, optional
            Called with the numbers of modes searched and to search.

        Examples
        --------
        >>> rod = Rod.nitinol()
        >>> ranges = rod.stable_mean_forces(0.2 * rod.critical_force, 150.0, growth_tolerance=0.01)
        >>> len(ranges), 0.34 * rod.critical_force in ranges, 0.2 * rod.critical_force in ranges
        (5, True, False)
        """
        upto = 1.5 * self.critical_force if upto is None else _largest(upto)
        load = AxialLoad(upto, amplitude, frequency)
        return self._ranges("mean", load, (0.0, upto), growth_tolerance, progress)

    def stable_amplitudes(
        self,
        mean: float,
        frequency: float,
        upto: float | None = None,
        growth_tolerance: float = HAIRLINE_GROWTH,
        *,
        progress: Progress | None = None,
    ) -> SafeRanges:
        """Return all stable intervals of the amplitude from 0 to ``upto`` (N; by default one critical force).

        Complete for modes that the mean force alone would buckle.  For the others growth need not be concave in the
        amplitude: with damping or tolerance unstable parts narrower than the ``resolution`` of the result may be missed
        (docs/ranges.md).  See `stable_mean_forces` for the other arguments.
        """
        upto = self.critical_force if upto is None else _largest(upto)
        load = AxialLoad(mean, upto, frequency)
        return self._ranges("amplitude", load, (0.0, upto), growth_tolerance, progress)

    def stable_frequencies(
        self,
        mean: float,
        amplitude: float,
        between: tuple[float, float],
        growth_tolerance: float = HAIRLINE_GROWTH,
        *,
        progress: Progress | None = None,
    ) -> SafeRanges:
        """Return all stable intervals of the frequency within ``between`` (rad/s).

        Complete, with damping and tolerance too: as 1 / omega^2 grows eigenvalues pass zero in one direction only, so
        that counting finds every tongue, and inside one the growth per period is concave in 1 / omega^2
        (docs/ranges.md).  See `stable_mean_forces` for the other arguments.
        """
        low, high = validate.interval("between", between, _frequency)
        slowest = AxialLoad(mean, amplitude, low)
        self.require_in_reach(slowest.mean, slowest.amplitude, low)
        return self._ranges("frequency", replace(slowest, frequency=high), (low, high), growth_tolerance, progress)

    def critical_mean_force(
        self, amplitude: float, frequency: float, growth_tolerance: float = HAIRLINE_GROWTH
    ) -> float:
        """Return the smallest mean force from 0 up, in N, at which a mode grows faster than ``growth_tolerance``.

        Infinite where there is none up to 1.5 critical forces.
        """
        upto = 1.5 * self.critical_force
        return self._first_unstable("mean", AxialLoad(upto, amplitude, frequency), upto, growth_tolerance)

    def critical_amplitude(self, mean: float, frequency: float, growth_tolerance: float = HAIRLINE_GROWTH) -> float:
        """Return the smallest amplitude in N at which a mode grows faster than ``growth_tolerance``.

        Infinite where there is none up to one critical force.
        """
        upto = self.critical_force
        return self._first_unstable("amplitude", AxialLoad(mean, upto, frequency), upto, growth_tolerance)

    def _ranges(
        self,
        varied: Quantity,
        largest: AxialLoad,
        between: tuple[float, float],
        growth_tolerance: float,
        progress: Progress | None,
    ) -> SafeRanges:
        """Search with as many modes as the largest load needs."""
        validate.progress(progress)
        tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
        last, _ = self.modes_needed(largest, tolerance)
        modes = range(1, last + 1)
        found = unstable_loads(varied, self, largest, modes, tolerance, between, union=True, progress=progress)
        return safe_ranges(*QUANTITIES[varied], found, between, tolerance, last)

    def _first_unstable(self, varied: Quantity, largest: AxialLoad, upto: float, growth_tolerance: float) -> float:
        """Search upwards from zero, piece by piece, until something is found."""
        tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
        ends = np.linspace(0.0, upto, _PIECES[varied] + 1).tolist()
        for piece in pairwise(ends):
            modes = range(1, self.modes_needed(replace(largest, **{varied: piece[1]}), tolerance)[0] + 1)
            found = unstable_loads(varied, self, largest, modes, tolerance, piece, union=True, nearest=piece[0]).ranges
            if found:
                return min(part.low for part in found)
        return math.inf

    def is_stable(
        self,
        mean: Any,
        amplitude: Any,
        frequency: Any,
        *,
        growth_tolerance: float = 0.0,
        criterion: FiniteTimeCriterion | None = None,
        friction: Coulomb | None = None,
        workers: int | None = None,
    ) -> Any:
        """Return whether the rod is stable, over arrays of loads (N, N, rad/s) that broadcast, all relevant modes.

        A mode counts as stable up to ``growth_tolerance`` (1/s), or when it passes the ``criterion``.  With
        ``friction``: whether its kick sets off no mode; loads that cannot be decided are warned of and False, and
        `verdicts` tells which.

        >>> Rod.nitinol().is_stable([0.34, 0.9], 0.34, 150.0)
        array([False, False])
        """
        found = self.verdicts(
            mean,
            amplitude,
            frequency,
            growth_tolerance=growth_tolerance,
            criterion=criterion,
            friction=friction,
            workers=workers,
        )
        unsure = int(np.count_nonzero(np.equal(found, -1)))
        if unsure:
            warnings.warn(
                f"{unsure} of {np.size(found)} loads could not be decided and count as unstable; verdicts tells which",
                UndecidedWarning,
                stacklevel=2,
            )
        return plain(np.equal(found, 1))

    def verdicts(
        self,
        mean: Any,
        amplitude: Any,
        frequency: Any,
        *,
        growth_tolerance: float = 0.0,
        criterion: FiniteTimeCriterion | None = None,
        friction: Coulomb | None = None,
        workers: int | None = None,
    ) -> Any:
        """Return 1 where the rod is stable, 0 where it is not and -1 where that cannot be decided, as int8.

        Arguments as in `is_stable`; only kicks against friction are ever undecided.

        >>> Rod.nitinol().verdicts([0.2, 0.72], 1.187, 150.0, friction=Coulomb(mu=0.1, velocity=0.05))
        array([1, 0], dtype=int8)
        """
        tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
        friction = None if friction is None else _coulomb(friction)
        if criterion is not None:
            validate.instance("criterion", criterion, FiniteTimeCriterion)
            criterion.require_alone(growth_tolerance=tolerance, friction=0.0 if friction is None else friction.mu)
        shape, force, size, omega = self._loads(mean, amplitude, frequency)
        if friction is not None:
            return shaped(kicked_loads(self, (force, size, omega), friction, tolerance, workers), shape)
        if criterion is not None:
            family = tuple(np.broadcast_to(part, omega.shape) for part in self.mode_family(force, size, omega))
            passed = criterion.modes_are_stable(family, self.damping_rate / omega, workers=workers)
            return shaped(passed.astype(np.int8), shape)
        out = np.empty(omega.size, dtype=np.bool_)
        constants = (*self.mode_constants, self.damping_rate, tolerance, NEGLIGIBLE_GROWTH)
        loads = (force, size, omega)
        over_chunks(
            kernels.modes_stable_fill, loads, out, *constants, workers=workers, chunk=self.loads_at_once(*loads)
        )
        return shaped(out.view(np.int8), shape)

    def growth_rate(self, mean: Any, amplitude: Any, frequency: Any, *, workers: int | None = None) -> Any:
        """Return the growth rate in 1/s of the fastest mode over arrays of loads; 0 where stable."""
        return self.fastest(mean, amplitude, frequency, workers=workers)[0]

    def fastest(self, mean: Any, amplitude: Any, frequency: Any, *, workers: int | None = None) -> tuple[Any, Any]:
        """Return the growth rate in 1/s and the number of the fastest mode over arrays of loads; 0, 0 where stable."""
        shape, force, size, omega = self._loads(mean, amplitude, frequency)
        out = np.empty((omega.size, 2))
        constants = (*self.mode_constants, self.damping_rate, NEGLIGIBLE_GROWTH)
        loads = (force, size, omega)
        over_chunks(
            kernels.modes_growth_fill, loads, out, *constants, workers=workers, chunk=self.loads_at_once(*loads)
        )
        growth, mode = out[:, 0], out[:, 1].astype(np.int64)
        return shaped(growth, shape), shaped(mode, shape)

    def _loads(
        self, mean: Any, amplitude: Any, frequency: Any
    ) -> tuple[tuple[int, ...], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return the common shape of loads that broadcast, and their flat arrays."""
        shape, (force, size, omega) = broadcast(
            mean=load_array("mean", mean),
            amplitude=load_array("amplitude", amplitude),
            frequency=load_array("frequency", frequency),
        )
        self.require_in_reach(force, size, omega)
        return shape, force, size, omega

    def _warn_unless_uniform(self, load: AxialLoad) -> None:
        ratio = load.frequency * self.length / (2.0 * math.pi) / self.wave_speed
        if ratio > _UNIFORM_UP_TO:
            warnings.warn(
                f"omega L / (2 pi) is {ratio:.2g} of the axial wave speed {self.wave_speed:.0f} m/s: the force is not "
                f"uniform along the rod, as this theory takes it to be (fit for ratios below {_UNIFORM_UP_TO:g})",
                UniformForceWarning,
                stacklevel=3,
            )


def _largest(upto: Any) -> float:
    """Return the end of a range of forces in N."""
    return validate.within("upto", validate.positive("upto", upto), 0.0, LARGEST_FORCE, "give it in N")


def _frequency(name: str, value: Any) -> float:
    """Return an end of a range of frequencies in rad/s."""
    positive = validate.positive(name, value)
    return validate.within(name, positive, LEAST_FREQUENCY, LARGEST_FREQUENCY, "give it in rad/s")


def _coulomb(friction: Any) -> Coulomb:
    return validate.instance("friction", friction, Coulomb, "give Coulomb(mu=..., velocity=...)")
