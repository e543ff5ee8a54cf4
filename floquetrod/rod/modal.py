"""From a rod and a load to equations of motion, of independent or of coupled modes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from floquetrod._util import validate
from floquetrod._util.caching import cached_property
from floquetrod.equations import HillSystem
from floquetrod.rod.axial import AxialResponse, axial_response
from floquetrod.rod.constants import HAIRLINE_GROWTH
from floquetrod.rod.coupled import CoupledModes, RodNumbers, chosen_count
from floquetrod.rod.data import RodData
from floquetrod.rod.load import AnyLoad, Load, Loads, kind, require_load
from floquetrod.rod.modes import ModalSystem, ModalSystems


@dataclass(frozen=True, init=False, repr=False)
class ModalRod(RodData):
    """A rod with its modal systems; `floquetrod.Rod` adds the verdicts."""

    @cached_property
    def coupled_numbers(self) -> RodNumbers:
        """What coupled modes need of the rod."""
        return RodNumbers(
            self.mode_constants,
            self.end_conditions,
            self.length,
            self.critical_mode,
            self.weight_along,
            self.wave_speed,
        )

    def modal_system(self, load: AnyLoad, modes: Iterable[int] | None = None) -> ModalSystem | HillSystem:
        """Return the equations of the rod's modes under a load.

        Parameters
        ----------
        load : AxialLoad, AxialWave or ForceRecord
        modes : iterable of int, optional
            Mode numbers, 1 to 20,000; by default all that can matter, see `modes_needed`.  Of coupled modes 1 to n.

        Returns
        -------
        ModalSystem or HillSystem
            Independent equations where the ends are hinged and the force is a sine, uniform along the rod.  Otherwise
            one system in seconds, its coordinates those of beam functions and a few polynomials, see
            `floquetrod.rod.beam`.

        Raises
        ------
        ValueError
            For numbers that are no modes, and for loads that need more than 20,000 modes or too large coefficients.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = ModalRod.nitinol()
        >>> load = fr.AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0)
        >>> system = rod.modal_system(load, modes=(6, 7))
        >>> round(system.equations[1].alpha, 4), system.damping
        (0.0513, 0.0)
        >>> rod.replace(ends="clamped").modal_system(load).structure
        'hamiltonian'
        """
        load = require_load("load", load)
        if not self.coupled_numbers.has_mathieu_modes(load):
            count = (
                self.coupled_numbers.modes_needed(Loads.single(load), load, 0.0)
                if modes is None
                else chosen_count(modes)
            )
            return CoupledModes(self.coupled_numbers, load, count).system(Loads.single(load))
        return self.independent_modes(load, modes)

    def independent_modes(self, load: Load, modes: Iterable[int] | None = None) -> ModalSystem:
        """Return what `modal_system` does, under a load under which the modes are independent."""
        constants = self.mode_constants
        if modes is not None:
            chosen = validate.modes(modes)
            constants.require_in_reach(Loads.single(load))
            return ModalSystem(constants, load, chosen)
        last, left_out = constants.modes_needed(load, 0.0)
        return ModalSystem(constants, load, tuple(range(1, last + 1)), left_out)

    def modal_systems(self, mean: Any, amplitude: Any, frequency: Any, *, like: AnyLoad | None = None) -> ModalSystems:
        """Return the modal systems over arrays of loads (N, N, rad/s) that broadcast; all else is that of ``like``.

        Raises ValueError where modes are coupled, and for loads that need more than 20,000 modes, or too large
        coefficients.
        """
        if not self.coupled_numbers.has_mathieu_modes(kind(like)):
            raise ValueError(
                f"modal_systems is for rods whose modes are independent, got ends={self.ends!r} and inclination = "
                f"{self.inclination:g}; use modal_system, one load at a time"
            )
        loads = Loads.of(mean, amplitude, frequency)
        self.mode_constants.require_in_reach(loads)
        return ModalSystems(self.mode_constants, loads)

    def modes_needed(self, load: AnyLoad, growth_tolerance: float = 0.0) -> tuple[int, float]:
        """Return how many modes decide a verdict, and a bound in 1/s on the growth of every mode beyond them.

        High modes sit in resonance tongues that grow, but exponentially slowly: the bound is that of
        `floquetrod.kernels.rod_modes.modes_left_out`, and M is the least for which it is below 1e-12 per second (or
        ``growth_tolerance``, if larger).  M grows like the length of the rod.

        M never falls as mean force, amplitude or frequency rise, so it serves every load below in each of them: at
        fixed q and mode a larger mean lowers a, a larger amplitude raises q, and both raise every factor of the bound;
        a, q and c^2 go like 1 / omega^2, so a higher frequency leaves fewer evanescent factors q / (a - k^2 - q), each
        larger, before a rate that in 1/s does not depend on it.
        """
        load = require_load("load", load)
        if not self.coupled_numbers.has_mathieu_modes(load):
            tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
            count = self.coupled_numbers.modes_needed(Loads.single(load), load, tolerance)
            return count, max(tolerance, HAIRLINE_GROWTH)
        return self.mode_constants.modes_needed(load, validate.tolerance("growth_tolerance", growth_tolerance))

    def axial_response(self, load: AnyLoad) -> AxialResponse:
        """Return how large the vibration of a load becomes along the rod, where, and the nearest axial resonances.

        Parameters
        ----------
        load : AxialLoad, AxialWave or ForceRecord

        Returns
        -------
        AxialResponse
            Its ``largest`` in N at ``position`` (m from the upper end), ``factor`` times the vibration at the driven
            end; its ``resonances`` in rad/s, by the formulas of `AxialWave`: cos(omega L / c_0) = 0 with the far end
            held, sin(omega L / c_0) = 0 free, cos(omega L / (2 c_0)) = 0 driven.  The force of an `AxialLoad` is
            uniform and has none.

        Examples
        --------
        >>> import floquetrod as fr
        >>> tubing = ModalRod.catalogue("2.00x0.156 CT90", bore="4.778in", length=600.0)
        >>> response = tubing.axial_response(fr.AxialWave(0.0, "2kN", "15Hz"))
        >>> round(response.factor, 1), [round(r.hertz, 2) for r in response.resonances]
        (60.3, [14.98, 19.26])
        """
        load = require_load("load", load)
        return axial_response(load, self.wave_speed, self.length, self.critical_force)


def refusal(rod: ModalRod, name: str, load: Load) -> ValueError:
    """Return the error for what independent modes are needed for, under a load that couples them."""
    found = rod.coupled_numbers.departures(load)
    remedy = "; mean_at=None neglects the weight along the rod" if "weight along the rod" in found else ""
    return ValueError(
        f"{name} needs independent modes, those of hinged ends under a sine that is uniform along the rod, got "
        f"{', '.join(found)}{remedy}"
    )
