"""What the mode equations need of a rod, which loads are refused, and how many modes decide a verdict."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arguments import Mention, Message
from floquetrod.rod.kernels import independent_modes as kernels
from floquetrod.rod.loads.load import Load, Loads
from floquetrod.rod.model import formulas
from floquetrod.rod.model.data import MOST_MODES as MOST_MODES
from floquetrod.rod.model.data import RodData

NEGLIGIBLE_GROWTH = 1e-12  # growth in 1/s that modes left out may have: a doubling in 20,000 years
SLOW_GROWTH = 1e-6
"""Growth in 1/s, tenfold in a month, up to which a tongue is negligible: searches leave it out, and count it."""

_MOST_PER_CYCLE = math.sqrt(validate.LARGEST)  # rates in frequencies of the load: their squares are coefficients


class ModeConstants(NamedTuple):
    """What the equations of a rod's modes need of it: q'' + 2 c q' + (c1 m^4 - c2 (m^2 - m_0^2) F(t) + Omega^2) q = 0.

    F is a compression, m the number of half waves between hinged ends; of coupled modes integrals of their functions
    stand in place of its powers.  Where the channel bends a compression holds modes longer than m_0 down, and drives
    the others.  The numbers are floats, or what `of` was given: arrays, intervals.
    """

    bending: Any  # c1 = (E I / m_t) (pi / L)^4 in 1/s^2
    per_newton: Any  # c2 = (pi / L)^2 / m_t in 1/(N s^2)
    restoring: Any  # Omega^2 in 1/s^2, of all that restores a rod across, over its inertia
    neutral_squared: Any  # m_0^2 = (L / pi)^2 curvature / R, zero in a straight channel, negative where it drops
    damping_rate: Any  # c in 1/s, of the decay of free motion
    weight: Any  # share of Omega^2 by which the weight alone presses the rod to the low side

    @classmethod
    def of(
        cls, parameters: Mapping[str, Any], *, pi: Any = math.pi, sin: Callable[[Any], Any] = math.sin
    ) -> ModeConstants:
        """Return them from `RodData.parameters`, some replaced: floats, arrays or intervals, with their pi and sine.

        Masses are per area of the material, so that most of a section's size cancels: without a bore or fluids each
        parameter occurs once in each number, and enclosures are tight.
        """
        p = parameters
        outer, inner = p["radius"] ** 2, p["inner_radius"] ** 2
        bore = inner / (outer - inner)
        own = formulas.own_mass(p["density"], p["fluid_inside"], 1.0, bore)
        mass = formulas.inertia(own, p["fluid_outside"], p["added_mass_coefficient"], 1.0 + bore)
        # Weight over inertia is `weighing_mass` over ``mass``, with own mass in one place: exactly 1 without a fluid.
        displaced = (1.0 + p["added_mass_coefficient"]) * p["fluid_outside"] * (1.0 + bore) / mass
        masses = formulas.Masses(formulas.ring(p["radius"], p["inner_radius"], pi) * mass, 1.0 - displaced)
        w = formulas.first_wavenumber(p["length"], pi)
        room = formulas.clearance(p["radius"], p["channel_radius"])
        return cls(
            p["youngs_modulus"] * (0.25 * (outer + inner)) / mass * w**4,
            w**2 / masses.inertia,
            formulas.restoring(p, masses, sin),
            formulas.neutral_mode_squared(p["curvature"], room, w),
            p["damping_rate"],
            formulas.weight_across(p, masses, sin),
        )

    @property
    def equation(self) -> tuple[Any, Any, Any, Any, Any]:
        """The five numbers of the equation of a mode, c1, c2, Omega^2, m_0^2 and c."""
        return self[:5]

    def pressed(self, weight: Any) -> ModeConstants:
        """Return the constants of a rod pressed to its wall by another ``weight``, all other stiffness unchanged."""
        return self._replace(restoring=weight + (self.restoring - self.weight), weight=weight)

    def on_side(self, side: Any) -> ModeConstants:
        """Return the constants of a rod that lies on the low side, 1, or on the high side, -1."""
        return self.pressed(side * self.weight)._replace(neutral_squared=side * self.neutral_squared)

    def sides(self, mean: Any, amplitude: Any) -> Any:
        """Return on which side a rod lies at all times, 1 low, -1 high, 0 where it leaves the wall, under forces in N.

        By its contact force over inertia and clearance: the force of the weight + c2 m_0^2 F.
        """
        bend = self.per_newton * self.neutral_squared
        press, lost = self.weight + bend * mean, np.abs(bend) * amplitude
        return np.where(press - lost > 0.0, 1, np.where(press + lost < 0.0, -1, 0))

    def modes_below(self, frequency: float, mean: float) -> int:
        """Return about how many modes swing below a frequency in rad/s under a compression in N."""
        push = 0.5 * self.per_newton * mean
        rest = frequency**2 - self.restoring - 2.0 * push * self.neutral_squared
        squared = max(0.0, push + math.sqrt(max(0.0, push * push + self.bending * rest))) / self.bending
        return math.floor(math.sqrt(squared))

    def modes_needed(self, load: Load, growth_tolerance: float) -> tuple[int, float]:
        """Return how many modes decide a verdict and a bound in 1/s on all others; see `Rod.modes_needed`.

        A tolerance below zero asks for all modes that may decay more slowly than that.
        """
        self.require_in_reach(Loads.single(load))
        a, b, stiffness, d, neutral_squared = kernels.mode_family(*self[:4], load.mean, load.amplitude, load.frequency)
        c = self.damping_rate / load.frequency
        d -= c * c
        slowest = growth_tolerance if growth_tolerance < 0.0 else max(growth_tolerance, NEGLIGIBLE_GROWTH)
        target = max(c + slowest / load.frequency, NEGLIGIBLE_GROWTH / load.frequency)
        last = kernels.modes_needed(a, b, stiffness, d, neutral_squared, target, 1)
        if last > MOST_MODES:
            raise validate.wrong_value(
                "load",
                f"needs {last} modes, more than {MOST_MODES}: its frequency {load.frequency:g} rad/s or its "
                f"forces are far beyond those of this rod; check the units",
            )
        bound = kernels.modes_left_out(a, b, stiffness, d, neutral_squared, last)
        return last, max(0.0, bound - c) * load.frequency

    def require_in_reach(self, loads: Loads) -> None:
        """Raise ValueError for loads that need too many modes, or whose mode equations have too large coefficients.

        The largest mean, amplitude and frequency are taken together, and the lowest frequency.
        """
        slowest = float(np.min(loads.frequency, initial=math.inf))
        modes, fastest = self._extent(loads)
        if modes > MOST_MODES:
            push = float(np.max(loads.mean, initial=-math.inf) + np.max(loads.amplitude, initial=0.0))
            half = 0.5 * self.neutral_squared * self.bending
            critical = 2.0 * (half + math.sqrt(max(0.0, half * half + self.bending * self.restoring)))
            critical /= self.per_newton
            raise validate.wrong_value(
                "load",
                Message(
                    f"needs more than {MOST_MODES} modes: ",
                    Mention("mean"),
                    " and ",
                    Mention("amplitude"),
                    f" come to {push:g} N, far above the critical force {critical:g} N of this rod; check units and "
                    "length",
                ),
            )
        least = fastest / _MOST_PER_CYCLE
        if slowest < least:
            raise validate.wrong_value(
                "frequency",
                f"must be at least {least:.3g} rad/s for this rod and load, got {slowest:g}: coefficients of "
                f"its mode equations would exceed {validate.LARGEST:g}; check the units",
            )
        most = float(highest_frequency(self.bending))
        highest = float(np.max(loads.frequency, initial=0.0))
        if highest > most:
            raise validate.wrong_value(
                "frequency",
                f"must be at most {most:.3g} rad/s for this rod, got {highest:g}: it sets "
                f"off modes beyond {MOST_MODES}; check the units",
            )
        if self.damping_rate > _MOST_PER_CYCLE * slowest:
            raise validate.wrong_value(
                "damping_rate",
                f"must be at most {_MOST_PER_CYCLE:.3g} times the frequency, got "
                f"{self.damping_rate:g} 1/s at {slowest:g} rad/s; check the units",
            )

    def loads_at_once(self, loads: Loads) -> int:
        """Return how many loads a thread takes at a time: the slower they are the fewer, so that Ctrl-C is handled."""
        modes, fastest = self._extent(loads)
        return at_once(modes, fastest / float(np.min(loads.frequency, initial=math.inf)))

    def interpreted_ms(self, loads: Loads) -> float:
        """Return about how many milliseconds each load takes an interpreted kernel, no less (measured)."""
        modes, fastest = self._extent(loads)
        turns = fastest / float(np.min(loads.frequency, initial=math.inf))
        return 1e-3 * (1.0 + modes) * (20.0 + 0.1 * turns)

    def _extent(self, loads: Loads) -> tuple[float, float]:
        """Return `extent` for the largest mean, in size too, and the largest amplitude taken together."""
        strongest = np.max(loads.amplitude, initial=0.0)
        push = max(0.0, float(np.max(loads.mean, initial=-math.inf) + strongest))
        force = float(np.max(np.abs(loads.mean), initial=0.0) + strongest)
        modes, fastest = extent(self, push, force)
        return float(modes), float(fastest)


def extent(constants: ModeConstants, push: Any, force: Any) -> tuple[Any, Any]:
    """Return up to which mode a push outweighs bending, and a bound in rad/s on motion up to there.

    Of one rod or of many: ``push`` is the largest compression in N, zero or more, ``force`` the largest force in size.
    """
    bending, per_newton, restoring, neutral_squared, _ = constants.equation
    with np.errstate(over="ignore"):  # infinite is out of reach, too
        modes = np.sqrt(push * per_newton / bending + np.abs(neutral_squared))
        highest = np.maximum(1.0, modes) ** 2
        bent = np.abs(restoring) + per_newton * force * np.abs(neutral_squared)
        return modes, np.sqrt(per_newton * force * highest + bending * highest * highest + bent)


def highest_frequency(bending: Any) -> Any:
    """Return the natural frequency of the last mode that is examined, in rad/s: no load may be faster."""
    return np.sqrt(bending) * MOST_MODES**2


def are_in_reach(constants: ModeConstants, extents: tuple[Any, Any], frequency: Any) -> NDArray[np.bool_]:
    """Return what `ModeConstants.require_in_reach` asks of one load, for arrays; ``extents`` is what `extent` gives."""
    modes, fastest = extents
    return np.asarray(
        (modes <= MOST_MODES)
        & (frequency >= fastest / _MOST_PER_CYCLE)
        & (frequency <= highest_frequency(constants.bending))
        & (constants.damping_rate <= _MOST_PER_CYCLE * frequency)
    )


@functools.lru_cache(maxsize=64)
def mode_constants(rod: RodData) -> ModeConstants:
    """Return the constants of one rod."""
    return ModeConstants.of(rod.parameters)


@functools.lru_cache(maxsize=64)
def softest_constants(rod: RodData) -> ModeConstants:
    """Return the constants of a uniform rod that needs at least as many modes: of several sections the extreme ones."""
    if not rod.varies:
        return mode_constants(rod)
    every = [ModeConstants.of({**part.rod.parameters, "length": rod.length}) for part in rod.uniform_parts]
    bending, per_newton, restoring, neutral_squared, _, weight = zip(*every, strict=True)
    return ModeConstants(
        min(bending), max(per_newton), min(restoring), min(neutral_squared), rod.damping_rate, min(weight)
    )


def at_once(modes: float, rows: float) -> int:
    """Return how many loads a thread takes at a time, from how many modes and rows of Hill's matrix each may take."""
    return max(1, int(4096.0 / (1.0 + 1e-4 * modes * rows)))
