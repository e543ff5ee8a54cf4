"""The rod's data sheet, and the equation of each of its modes."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import plain
from floquetrod.equations import Mathieu
from floquetrod.kernels import rod_modes as kernels
from floquetrod.rod.load import AxialLoad, load_array

NEGLIGIBLE_GROWTH = 1e-12  # growth in 1/s that modes left out may have: a doubling in 20,000 years
MOST_MODES = 20_000  # beyond it the unit of a length or a force is wrong (a choice)


_LEAST, _LARGEST = 1e-12, 1e15  # of any parameter in its SI unit: what is computed from them stays in range (a choice)
_UNITS = {
    "youngs_modulus": "Pa",
    "density": "kg/m^3",
    "radius": "m",
    "length": "m",
    "channel_radius": "m",
    "gravity": "m/s^2",
}


@dataclass(frozen=True)
class RodData:
    """Data sheet of a straight elastic rod on the floor of a horizontal circular channel, and its mode equations.

    Its parameters, in SI units, are described at `floquetrod.rod.Rod`, which adds the verdicts.

    Notes
    -----
    Eq. (1) of DOI 10.1115/1.4031710.  Force uniform along the rod, small angles.

    Examples
    --------
    >>> rod = RodData.nitinol()
    >>> round(rod.critical_force, 3), round(rod.critical_mode, 2)
    (1.696, 6.14)
    """

    youngs_modulus: float
    density: float
    radius: float
    length: float
    channel_radius: float
    gravity: float = 9.81
    damping_rate: float = 0.0

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        for name, unit in _UNITS.items():
            number = validate.positive(name, getattr(self, name), f"give it in {unit}")
            validate.within(name, number, _LEAST, _LARGEST, f"give it in {unit}")
            object.__setattr__(self, name, number)
        rate = validate.nonnegative("damping_rate", self.damping_rate, "give the decay rate in 1/s")
        object.__setattr__(self, "damping_rate", validate.within("damping_rate", rate, 0.0, _LARGEST))
        if self.radius >= self.channel_radius:
            raise ValueError(
                f"channel_radius must exceed the rod's radius, got channel_radius = {self.channel_radius:g} m and "
                f"radius = {self.radius:g} m; both are radii, not diameters"
            )

    @classmethod
    def nitinol(cls) -> Self:
        """Return the reference rod: Nitinol, 3.1 m long, in a plastic pipe.

        The paper's text calls 9.4 mm the channel radius; its own critical force (1.70 N) and mode (6) hold only if that
        is the diameter, so the radius here is 4.7 mm.
        """
        return cls(youngs_modulus=68e9, density=6500.0, radius=0.8e-3, length=3.1, channel_radius=4.7e-3)

    def replace(self, **changes: float) -> Self:
        """Return a copy with some parameters changed."""
        return replace(self, **changes)

    @property
    def area(self) -> float:
        """Area of the section, pi r^2, in m^2."""
        return math.pi * self.radius**2

    @property
    def second_moment(self) -> float:
        """Second moment of the section, I = pi r^4 / 4, in m^4."""
        return 0.25 * math.pi * self.radius**4

    @property
    def flexural_rigidity(self) -> float:
        """E I in N m^2."""
        return self.youngs_modulus * self.second_moment

    @property
    def mass_per_length(self) -> float:
        """Rho A in kg/m."""
        return self.density * self.area

    @property
    def radial_clearance(self) -> float:
        """R = channel radius - rod radius in m: the radius of the motion of the rod's axis."""
        return self.channel_radius - self.radius

    @property
    def pendulum_frequency(self) -> float:
        """Frequency sqrt(g / R) in rad/s at which a rigid rod swings in the channel."""
        return math.sqrt(self.gravity / self.radial_clearance)

    @property
    def critical_force(self) -> float:
        """F_cr = 2 sqrt(E I rho A g / R) in N: a constant push beyond it buckles a long rod."""
        return 2.0 * math.sqrt(self.flexural_rigidity * self.mass_per_length) * self.pendulum_frequency

    @property
    def critical_mode(self) -> float:
        """m_cr = [rho A g L^4 / (pi^4 R E I)]^(1/4), the mode (not rounded) that F_cr buckles."""
        stiffness = self.flexural_rigidity / self.mass_per_length
        return self.length / math.pi * math.sqrt(self.pendulum_frequency / math.sqrt(stiffness))

    @property
    def wave_speed(self) -> float:
        """Speed of axial waves, sqrt(E / rho), in m/s."""
        return math.sqrt(self.youngs_modulus / self.density)

    def wavenumber(self, mode: Any) -> Any:
        """Return w_m = m pi / L in 1/m."""
        return plain(_modes(mode) * (math.pi / self.length))

    def natural_frequency(self, mode: Any) -> Any:
        """Return the frequency in rad/s of free motion in a mode, without axial force or damping."""
        bending = self.flexural_rigidity / self.mass_per_length * self.wavenumber(mode) ** 4
        return plain((bending + self.pendulum_frequency**2) ** 0.5)

    def mode_parameters(self, load: AxialLoad, modes: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return alpha_m and beta_m of Eq. (4) as arrays over ``modes``."""
        validate.instance("load", load, AxialLoad)
        family = self.mode_family(load.mean, load.amplitude, load.frequency)
        alpha, beta = kernels.mode_coefficients(*family, _modes(modes, "modes"))
        return np.asarray(alpha), np.asarray(beta)

    def mode_equations(self, load: AxialLoad, modes: Iterable[int]) -> tuple[Mathieu, ...]:
        """Return the Mathieu equation (3) of each mode, in the time tau = omega t, damping included."""
        chosen = validate.integers("modes", modes, 1)
        alpha, beta = self.mode_parameters(load, chosen)
        self.require_in_reach(load.mean, load.amplitude, load.frequency)
        for mode, size in zip(chosen, np.maximum(abs(alpha), abs(beta)), strict=True):
            if size > validate.LARGEST:
                raise ValueError(
                    f"modes must have coefficients up to {validate.LARGEST:g}, got {size:.3g} for mode {mode} at "
                    f"frequency {load.frequency:g} rad/s; leave out modes so high, or check the units"
                )
        damping = self.damping_rate / load.frequency
        return tuple(Mathieu(float(a), float(b), damping) for a, b in zip(alpha, beta, strict=True))

    @property
    def mode_constants(self) -> tuple[float, float, float, float]:
        """What mode equations need of the rod: w_1^2 (1/m^2), mass per length, E I and the pendulum frequency."""
        w2 = (math.pi / self.length) ** 2
        return w2, self.mass_per_length, self.flexural_rigidity, self.pendulum_frequency

    def mode_family(self, mean: Any, amplitude: Any, frequency: Any) -> tuple[Any, Any, Any, Any]:
        """Return A, B, C, D of alpha_m = A m^2, beta_m = B m^2 - C m^4 - D: Eq. (4), for every use of it.

        Broadcasts over arrays of mean force (N), amplitude (N) and frequency (rad/s).
        """
        load = {"mean": mean, "amplitude": amplitude, "frequency": frequency}
        return kernels.mode_family(*self.mode_constants, *(plain(load_array(*item)) for item in load.items()))

    def require_in_reach(self, mean: Any, amplitude: Any, frequency: Any) -> None:
        """Raise ValueError for loads that need too many modes, or whose mode equations have too large coefficients.

        Over arrays of mean force (N), amplitude (N) and frequency (rad/s); the largest of all are taken together.
        """
        slowest = float(np.min(frequency, initial=math.inf))
        modes, fastest = self._extent(mean, amplitude)
        if modes > MOST_MODES:
            push = float(np.max(mean, initial=-math.inf) + np.max(amplitude, initial=0.0))
            raise ValueError(
                f"load needs more than {MOST_MODES} modes: mean and amplitude come to {push:g} N, far above the "
                f"critical force {self.critical_force:g} N of this rod; check units and length"
            )
        least = fastest / math.sqrt(validate.LARGEST)
        if slowest < least:
            raise ValueError(
                f"frequency must be at least {least:.3g} rad/s for this rod and load, got {slowest:g}: coefficients of "
                f"its mode equations would exceed {validate.LARGEST:g}; check the units"
            )
        bending = math.sqrt(self.flexural_rigidity / self.mass_per_length)
        most = bending * (MOST_MODES * math.pi / self.length) ** 2  # the natural frequency of the last mode
        if float(np.max(frequency, initial=0.0)) > most:
            raise ValueError(
                f"frequency must be at most {most:.3g} rad/s for this rod, got {float(np.max(frequency)):g}: it sets "
                f"off modes beyond {MOST_MODES}; check the units"
            )
        if self.damping_rate > math.sqrt(validate.LARGEST) * slowest:
            raise ValueError(
                f"damping_rate must be at most {math.sqrt(validate.LARGEST):.3g} times the frequency, got "
                f"{self.damping_rate:g} 1/s at {slowest:g} rad/s; check the units"
            )

    def loads_at_once(self, mean: Any, amplitude: Any, frequency: Any) -> int:
        """Return how many loads a thread takes at a time: the slower they are the fewer, so that Ctrl-C is heard."""
        modes, fastest = self._extent(mean, amplitude)
        rows = fastest / float(np.min(frequency, initial=math.inf))  # of Hill's matrix
        return max(1, int(4096.0 / (1.0 + 1e-4 * modes * rows)))

    def _extent(self, mean: Any, amplitude: Any) -> tuple[float, float]:
        """Return up to which mode the largest push outweighs bending, and a bound in rad/s on motion up to there."""
        push = max(0.0, float(np.max(mean, initial=-math.inf) + np.max(amplitude, initial=0.0)))
        force = float(np.max(np.abs(mean), initial=0.0) + np.max(amplitude, initial=0.0))
        w2, mass, rigidity, pendulum = self.mode_constants
        modes = math.sqrt(push / rigidity / w2)
        w2 *= max(1.0, modes) ** 2
        return modes, math.sqrt((force * w2 + rigidity * w2 * w2) / mass + pendulum**2)

    def modes_needed(self, load: AxialLoad, growth_tolerance: float = 0.0) -> tuple[int, float]:
        """Return how many modes decide a verdict, and a bound in 1/s on the growth of every mode beyond them.

        High modes sit in resonance tongues that grow, but exponentially slowly: the bound is that of
        `floquetrod.kernels.rod_modes.modes_left_out`, and M is the least for which it is below 1e-12 per second (or
        ``growth_tolerance``, if larger).  M grows like the length of the rod.

        M never falls as mean force, amplitude or frequency rise, so it serves every load below in each of them: at
        fixed q and mode a larger mean lowers a, a larger amplitude raises q, and both raise every factor of the bound;
        a, q and c^2 go like 1 / omega^2, so a higher frequency leaves fewer evanescent factors q / (a - k^2 - q), each
        larger, before a rate that in 1/s does not depend on it.
        """
        validate.instance("load", load, AxialLoad)
        growth_tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
        self.require_in_reach(load.mean, load.amplitude, load.frequency)
        family = self.mode_family(load.mean, load.amplitude, load.frequency)
        c = self.damping_rate / load.frequency
        a, b, stiffness, d = family
        d -= c * c
        target = c + max(growth_tolerance, NEGLIGIBLE_GROWTH) / load.frequency
        last = kernels.modes_needed(a, b, stiffness, d, target, 1)
        if last > MOST_MODES:
            raise ValueError(
                f"load needs {last} modes, more than {MOST_MODES}: its frequency {load.frequency:g} rad/s or its "
                f"forces are far beyond those of this rod; check the units"
            )
        bound = kernels.modes_left_out(a, b, stiffness, d, last)
        return last, max(0.0, bound - c) * load.frequency


def _modes(mode: Any, name: str = "mode") -> NDArray[np.float64]:
    return validate.array(name, mode, least=0.0, largest=10.0 * MOST_MODES)
