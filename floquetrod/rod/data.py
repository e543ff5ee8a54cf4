"""The rod's data sheet: its parts, what follows from them, and the modal system of a load."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable
from dataclasses import MISSING, dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arrays import shaped
from floquetrod.rod.constants import MOST_MODES, ModeConstants
from floquetrod.rod.load import AxialLoad, Loads
from floquetrod.rod.modes import ModalSystem, ModalSystems
from floquetrod.rod.parts import Channel, Ends, Material, Section, decay_rate, parameter


@dataclass(frozen=True)
class RodData:
    """Data sheet of a straight elastic rod on the floor of a horizontal circular channel, and its modal systems.

    Its parameters, in SI units, are described at `floquetrod.Rod`, which adds the verdicts.  They are what is typed,
    compared and stored; the parts made of them, `material`, `section`, `channel` and `ends`, are what everything else
    is computed from.

    Notes
    -----
    Eq. (1) of DOI 10.1115/1.4031710.  Force uniform along the rod, small angles.

    Examples
    --------
    >>> rod = RodData.nitinol()
    >>> round(rod.critical_force, 3), round(rod.critical_mode, 2)
    (1.696, 6.14)
    >>> rod.section
    Section(radius=0.0008)
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
        cleaned = {
            "youngs_modulus": self.material.youngs_modulus,
            "density": self.material.density,
            "radius": self.section.radius,
            "length": parameter("length", self.length, "m"),
            "channel_radius": self.channel.radius,
            "gravity": self.channel.gravity,
            "damping_rate": decay_rate(self.damping_rate),
        }
        self.channel.clearance(self.section)  # raises where the rod does not fit
        for name, number in cleaned.items():
            object.__setattr__(self, name, number)

    @classmethod
    def nitinol(cls) -> Self:
        """Return the reference rod: Nitinol, 3.1 m long, in a plastic pipe.

        The paper's text calls 9.4 mm the channel radius; its own critical force (1.70 N) and mode (6) hold only if that
        is the diameter, so the radius here is 4.7 mm.
        """
        return cls(youngs_modulus=68e9, density=6500.0, radius=0.8e-3, length=3.1, channel_radius=4.7e-3)

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """Read a rod from a TOML file.

        Keys are the parameters of `floquetrod.Rod`; values are numbers in SI units, or strings with a unit such as
        "68GPa" or "0.8mm".  Raises ValueError, naming file and key, for what cannot be read, is missing or unknown.
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

    def replace(self, **changes: float) -> Self:
        """Return a copy with some parameters changed."""
        return replace(self, **changes)

    # --- parts ---

    @cached_property
    def material(self) -> Material:
        """Young's modulus and density."""
        return Material(self.youngs_modulus, self.density)

    @cached_property
    def section(self) -> Section:
        """Radius, area and second moment."""
        return Section(self.radius)

    @cached_property
    def channel(self) -> Channel:
        """Inner radius, and gravity across it."""
        return Channel(self.channel_radius, self.gravity)

    @cached_property
    def ends(self) -> Ends:
        """How the ends are held."""
        return Ends()

    # --- what follows from them ---

    @property
    def area(self) -> float:
        """Area of the section in m^2."""
        return self.section.area

    @property
    def second_moment(self) -> float:
        """Second moment of the section, I, in m^4."""
        return self.section.second_moment

    @property
    def flexural_rigidity(self) -> float:
        """E I in N m^2."""
        return self.material.youngs_modulus * self.section.second_moment

    @property
    def mass_per_length(self) -> float:
        """Rho A in kg/m."""
        return self.material.density * self.section.area

    @property
    def radial_clearance(self) -> float:
        """R = channel radius - rod radius in m, the radius of the motion of the rod's axis."""
        return self.channel.clearance(self.section)

    @property
    def pendulum_frequency(self) -> float:
        """Frequency sqrt(g / R) in rad/s at which a rigid rod swings in the channel."""
        return self.channel.pendulum_frequency(self.section)

    @property
    def critical_force(self) -> float:
        """F_cr = 2 sqrt(E I rho A g / R) in N; a constant push beyond it buckles a long rod."""
        return self.mode_constants.critical_force

    @property
    def critical_mode(self) -> float:
        """m_cr = [rho A g L^4 / (pi^4 R E I)]^(1/4), the mode (not rounded) that F_cr buckles."""
        stiffness = self.flexural_rigidity / self.mass_per_length
        return self.length / math.pi * math.sqrt(self.pendulum_frequency / math.sqrt(stiffness))

    @property
    def wave_speed(self) -> float:
        """Speed of axial waves, sqrt(E / rho), in m/s."""
        return self.material.wave_speed

    def wavenumber(self, mode: Any) -> Any:
        """Return w_m = m pi / L in 1/m."""
        modes = _modes(mode)
        return shaped(modes * self.ends.first_wavenumber(self.length), modes.shape)

    def natural_frequency(self, mode: Any) -> Any:
        """Return the frequency in rad/s of free motion in a mode, without axial force or damping."""
        bending = self.flexural_rigidity / self.mass_per_length * self.wavenumber(mode) ** 4
        return (bending + self.pendulum_frequency**2) ** 0.5

    # --- modal systems ---

    @cached_property
    def mode_constants(self) -> ModeConstants:
        """What the mode equations need of the rod."""
        return ModeConstants(
            self.ends.first_wavenumber(self.length) ** 2,
            self.mass_per_length,
            self.flexural_rigidity,
            self.pendulum_frequency,
            self.damping_rate,
        )

    def modal_system(self, load: AxialLoad, modes: Iterable[int] | None = None) -> ModalSystem:
        """Return the equations of the rod's modes under a load.

        Parameters
        ----------
        load : AxialLoad
        modes : iterable of int, optional
            Mode numbers, 1 to 20,000; by default all that can matter, see `modes_needed`.

        Raises
        ------
        ValueError
            For numbers that are no modes, and for loads that need more than 20,000 modes or too large coefficients.

        Examples
        --------
        >>> rod = RodData.nitinol()
        >>> system = rod.modal_system(AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0), modes=(6, 7))
        >>> round(system.equations[1].alpha, 4), system.damping
        (0.0513, 0.0)
        """
        validate.instance("load", load, AxialLoad)
        constants = self.mode_constants
        if modes is not None:
            chosen = validate.modes(modes)
            constants.require_in_reach(Loads.single(load))
            return ModalSystem(constants, load, chosen)
        last, left_out = constants.modes_needed(load, 0.0)
        return ModalSystem(constants, load, tuple(range(1, last + 1)), left_out)

    def modal_systems(self, mean: Any, amplitude: Any, frequency: Any) -> ModalSystems:
        """Return the modal systems over arrays of loads (N, N, rad/s) that broadcast.

        Raises ValueError for loads that need more than 20,000 modes, or too large coefficients.
        """
        loads = Loads.of(mean, amplitude, frequency)
        self.mode_constants.require_in_reach(loads)
        return ModalSystems(self.mode_constants, loads)

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
        return self.mode_constants.modes_needed(load, validate.tolerance("growth_tolerance", growth_tolerance))


def _modes(mode: Any) -> NDArray[np.float64]:
    return validate.array("mode", mode, least=0.0, largest=10.0 * MOST_MODES)
