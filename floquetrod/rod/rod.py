"""The rod on the channel floor: data sheet and load in, verdict over all modes that matter out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, overload

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arrays import shaped
from floquetrod._util.calling import call_hints
from floquetrod._util.progress import Progress
from floquetrod.equations import HillSystem
from floquetrod.floquet.proof.proof import MAX_BOXES
from floquetrod.floquet.status import are
from floquetrod.mathieu.criterion import FiniteTimeCriterion
from floquetrod.rod import verdicts
from floquetrod.rod.loads.load import QUANTITIES, AnyLoad, Load, Loads, Quantity, kind, require_load, require_noise
from floquetrod.rod.mode_equations.coupling import WAVEFORM, coupling
from floquetrod.rod.mode_equations.modal_systems import ModalSystem, ModalSystems
from floquetrod.rod.model.constants import SLOW_GROWTH
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.parts import friction_coefficient
from floquetrod.rod.modes.independent import IndependentModel
from floquetrod.rod.modes.mode_model import ModeModel

# Loaded by the methods that need them: a first verdict takes a quarter of the package.
if TYPE_CHECKING:
    from floquetrod.floquet.proof.region_proof import RegionProof
    from floquetrod.rod.answers.critical_noise import CriticalFactor
    from floquetrod.rod.answers.margins import CriticalLoad
    from floquetrod.rod.answers.mean_force import MeanForce
    from floquetrod.rod.answers.reach import Reach
    from floquetrod.rod.answers.rod_branches import RodBranches
    from floquetrod.rod.answers.safe_box import SafeBox
    from floquetrod.rod.answers.safe_kick import SafeKick
    from floquetrod.rod.answers.steady_motion import SteadyMotion
    from floquetrod.rod.answers.verdict import RodStability
    from floquetrod.rod.friction.kicks import CriticalKick, FrictionalRodStability
    from floquetrod.rod.loads.tool import VibrationTool
    from floquetrod.rod.ranges import StabilityIntervals
    from floquetrod.wells.path import WellPath


def _model(rod: RodData, like: Load) -> ModeModel:
    """Return what the modes are; of a rod with hinged ends under a sine nothing else is loaded."""
    coupled = coupling(rod, like)
    if not coupled and not like.noise:
        return IndependentModel(rod, like)
    if not like.noise:
        from floquetrod.rod.modes.coupled import CoupledModel

        return CoupledModel(rod, like)
    if set(coupled) <= {WAVEFORM}:
        from floquetrod.rod.modes.noisy import NoisyModel

        return NoisyModel(rod, like)
    from floquetrod.rod.modes.noisy_together import NoisyTogetherModel

    return NoisyTogetherModel(rod, like)


_NO_LOAD = "its load is one value, such as fr.AxialLoad(mean, amplitude, frequency)"
_load_hints = call_hints(_NO_LOAD, mean=_NO_LOAD, amplitude=_NO_LOAD, frequency=_NO_LOAD)


@dataclass(frozen=True, init=False, repr=False)
class Rod(RodData):
    """An elastic rod or tube of circular section on the floor of a circular channel, straight or bent.

    Parameters
    ----------
    youngs_modulus : float or str
        Young's modulus E in Pa, or a string with a unit such as "68GPa"; greater than 0.
    density : float or str
        Density rho of the material in kg/m^3, or with a unit such as "7.85g/cm3"; greater than 0.
    radius : float or str
        Outer radius r_o in m, or with a unit such as "0.8mm"; greater than 0.  Give it or ``diameter``.
    length : float or str
        Length L in m, or with a unit such as "40ft"; greater than 0.
    channel_radius : float or str
        Inner radius of the channel in m, or with a unit; greater than that of the rod.  Give it or
        ``channel_diameter``.
    gravity : float or str
        g in m/s^2, or with a unit; greater than 0, by default 9.81.
    damping_rate : float or str
        Decay rate c of free motion in 1/s, or with a unit; 0 or more, by default 0.
    inner_radius : float or str
        Inner radius r_i of a tube in m, or with a unit; from 0, a solid rod and the default, to less than ``radius``.
    fluid_inside : float or str
        Density of the fluid inside a tube in kg/m^3, or with a unit such as "10ppg"; 0 or more, by default 0, nothing.
        With a fluid inside or outside the load is the effective force F_wall + p_i A_i - p_o A_o.
    fluid_outside : float or str
        Density of the fluid around the rod in kg/m^3, or with a unit; 0 or more, by default 0, nothing.  A rod that
        floats is refused.
    added_mass_coefficient : float
        Mass of the outer fluid that moves with the rod over the mass displaced, without unit; 0 or more, by default
        pi^2/3 - 1 = 2.29, that of a cylinder touching a plane floor; more in a narrow gap.
    inclination : float or str
        Angle of the channel from the vertical in rad, or with a unit such as "60deg"; above 0 and at most pi/2, which
        is horizontal and the default.  Of a channel that bends that in the middle of the rod.
    ends : str
        "hinged", the default, "clamped", "guided" or "free", or two of them, the upper end first: "clamped-hinged".
        See `floquetrod.rod.Ends`.
    curvature : float or str
        Curvature of the channel in its vertical plane in 1/m, or with a unit such as "3deg/30m"; positive where it
        builds, 0 by default.  It and the weight across are taken as uniform, so that modes stay independent.
    path : WellPath, optional
        Path of the well in place of ``inclination`` and ``curvature``, or a mapping of its arguments.
    depth : float or str
        Measured depth of the upper end on the path in m, or with a unit, 0 by default.
    yield_strength : float or str, optional
        Yield strength of the material in Pa, or with a unit such as "620MPa", to which `stress` is compared; a pipe of
        the catalogue has that of its grade.
    diameter : float or str, optional
        Outer diameter in m, or with a unit, in place of ``radius``.
    inner_diameter : float or str, optional
        Inner diameter in m, or with a unit, in place of ``inner_radius``.
    channel_diameter : float or str, optional
        Inner diameter of the channel in m, or with a unit, in place of ``channel_radius``.
    wall_thickness : float or str, optional
        Wall of a tube in m, or with a unit, in place of ``inner_radius``; at most the outer radius.

    Warns
    -----
    PlausibilityWarning
        When a parameter looks as if it were in another unit, or a diameter where a radius belongs.

    Notes
    -----
    Eq. (1) of DOI 10.1115/1.4031710, with the inertia, weight and bending stiffness of a tube in fluids.  Its parts,
    and the quantities derived from them, are those of `floquetrod.rod.model.data.RodData`, the data sheet.

    Where the channel bends the force enters twice, m R theta_tt + E I R theta_ssss + (F R theta_s)_s + N theta = 0 with
    the contact force N = w_e sin(inclination) + F curvature per length: it restores long waves where the channel
    builds.  On a path that turns N = hypot(w_e sin(phi) + F kappa_n, F kappa_b), and verdicts are those on small motion
    about the mean position.  On an arc the inclination changes along the rod, which couples the modes.

    Examples
    --------
    >>> import floquetrod as fr
    >>> Rod.nitinol().modes_needed(fr.AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0))[0]
    22
    >>> tubing = Rod(
    ...     207e9, 7850.0, diameter=50.8e-3, wall_thickness=3.96e-3, length=60.0, channel_diameter=0.124,
    ...     fluid_inside=1000.0, fluid_outside=1000.0
    ... )
    >>> round(tubing.critical_force), round(tubing.weight_per_length, 3)
    (11941, 39.158)
    >>> well = fr.WellPath.arc(length=600.0, inclination=("30deg", "90deg"), depth=1000.0)
    >>> round(tubing.replace(path=well, depth=1200.0).critical_force)
    14101
    """

    # --- modes ---

    def modes_under(self, like: AnyLoad | None = None) -> ModeModel:
        """Return the model of the modes under any load of the kind of ``like``, by default a sine.

        This is the one place where a model of the modes is chosen.

        >>> import floquetrod as fr
        >>> rod = Rod.nitinol().replace(ends="clamped")
        >>> type(rod.modes_under()).__name__, rod.modes_under().coupling
        ('CoupledModel', ('clamped ends',))
        """
        return _model(self, kind(like))

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
            one system in seconds, its coordinates those of beam functions and a few others, see
            `floquetrod.rod.model.beam`.

        Raises
        ------
        ValueError
            For numbers that are no modes, and for loads that need more than 20,000 modes or too large coefficients.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = Rod.nitinol()
        >>> load = fr.AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0)
        >>> system = rod.modal_system(load, modes=(6, 7))
        >>> round(system.equations[1].alpha, 4), system.damping
        (0.0513, 0.0)
        >>> rod.replace(ends="clamped").modal_system(load).structure
        'hamiltonian'
        """
        load = require_load("load", load)
        return self.modes_under(load).equations(load, modes)

    def modal_systems(self, mean: Any, amplitude: Any, frequency: Any, *, like: AnyLoad | None = None) -> ModalSystems:
        """Return the modal systems over arrays of loads (N, N, rad/s) that broadcast; all else as in ``like``.

        Raises ValueError where modes are coupled, and for loads that need more than 20,000 modes, or too large
        coefficients.
        """
        return self.modes_under(like).systems(Loads.of(mean, amplitude, frequency))

    def modes_needed(self, load: AnyLoad, growth_tolerance: float = 0.0) -> tuple[int, float]:
        """Return how many modes decide a verdict, and a bound in 1/s on the growth of every mode beyond them.

        High modes sit in resonance tongues that grow, but exponentially slowly: the bound is that of
        `modes_left_out` of ``rod/mode_equations``, and M is the least for which it is below 1e-12 per second (or
        ``growth_tolerance``, if larger).  M grows like the length of the rod.

        M never falls as mean force, amplitude or frequency rise, so it serves every load below in each of them: at
        fixed q and mode a larger mean lowers a, a larger amplitude raises q, and both raise every factor of the bound;
        a, q and c^2 go like 1 / omega^2, so a higher frequency leaves fewer evanescent factors q / (a - k^2 - q), each
        larger, before a rate that in 1/s does not depend on it.
        """
        load, tolerance = require_load("load", load), units.tolerance("growth_tolerance", growth_tolerance)
        return self.modes_under(load).modes_needed(load, tolerance)

    # --- along a well ---

    def mean_force(
        self,
        path: WellPath,
        friction: Any = 0.0,
        *,
        motion: str = "pushed",
        far_force: float | str = 0.0,
        bottom: float | str | None = None,
        depth: Any = None,
        tool: VibrationTool | None = None,
        speed: float | str = 0.05,
        helical: str = "energy",
    ) -> MeanForce:
        """Return the mean force along a string of this section in a well, from the beginning of its path down.

        The rod's own length and inclination are not used.

        Parameters
        ----------
        path : WellPath
        friction : float or sequence of (float or str, float)
            Coefficient of friction with the wall; or pairs of a measured depth in m and the coefficient from there on,
            the first depth 0: ``[(0, 0.2), ("1500m", 0.35)]`` for a well cased to 1500 m.
        motion : str
            "pushed" down, "pulled" up, or "standing" without friction.
        far_force : float or str
            Compression at the lower end in N, negative for a pull.
        bottom : float or str, optional
            Measured depth of the lower end in m; by default the end of the path.
        depth : array_like, optional
            Measured depths in m, or each with a unit, at which the force is wanted, beside both ends; by default every
            10 m or so.
        tool : VibrationTool, optional
            It vibrates the string, and reduces friction where its speed exceeds that of sliding.  The ends of the
            string reflect its wave; friction and the rod's ``damping_rate`` damp it.  500 waves at most along the
            string.
        speed : float or str
            Speed of sliding in m/s, which is used with a tool only.
        helical : str
            When a pushed string becomes a helix: "energy", "loading" or "alone", from sqrt(2), 1.83 or 2 sqrt(2) times
            the force at which it begins to snake, see `critical_forces`; "always", wherever it is compressed.

        Raises
        ------
        TypeError, ValueError
            For numbers out of range, naming the argument.

        Notes
        -----
        dF/ds = w cos(phi) - mu N with the contact force N = hypot(w sin(phi) + F kappa_n, F kappa_b), plus
        F^2 R / (4 E I) of a helix (docs/theory/mean_force.md).

        Examples
        --------
        >>> import floquetrod as fr
        >>> well = fr.WellPath([0.0, 1000.0, 1450.0, 3000.0], ["0deg", "0deg", "90deg", "90deg"])
        >>> tubing = Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
        >>> tubing.mean_force(well, 0.2)
        <string pushed to 3000 m needs 32.27 kN of pull at 0 m>
        """
        from floquetrod.rod.answers import mean_force

        drag = mean_force.drag_of(self, path, friction, motion, helical, tool, speed)
        force, end = mean_force.force_in_newtons("far_force", far_force), mean_force.lower_end(path, bottom)
        return mean_force.mean_force(drag, force, end, depth)

    def reach(
        self,
        path: WellPath,
        friction: Any,
        *,
        tool: VibrationTool | None = None,
        speed: float | str = 0.05,
        far_force: float | str = 0.0,
        push: float | str | None = None,
        yield_share: float | None = 0.8,
        depth: Any = None,
        helical: str = "energy",
    ) -> Reach:
        """Return how far a string of this section can be pushed into a well, without and with a vibration tool.

        Arguments are as in `mean_force`, and besides:

        Parameters
        ----------
        push : float or str, optional
            Greatest compression in N that the upper end can be given; by default any.
        yield_share : float or None
            Largest stress anywhere along the string, axial and bending together, as a fraction of the rod's
            ``yield_strength``: more than 0, 1 at most, or None for any.  Without a yield strength nothing is limited.
        depth : array_like, optional
            Measured depths in m, or each with a unit such as "9000ft", of the lower end at which the force at the upper
            end is wanted; 100 by default.  The reach is sought down to the deepest of them, and does not depend on the
            others.

        Notes
        -----
        The reach is the greatest depth within ``push`` and ``yield_share``; ``lock_up`` is the one at which no force
        moves the string, beyond which it does not go however strong it is.

        Examples
        --------
        >>> import floquetrod as fr
        >>> well = fr.WellPath([0.0, 1000.0, 1450.0, 4000.0], ["0deg", "0deg", "90deg", "90deg"])
        >>> tubing = Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
        >>> tubing.reach(well, 0.3, depth=[2000.0, 3000.0, 4000.0])
        <can be pushed to 2990.4 m, where it locks up>
        """
        from floquetrod.rod.answers import reach

        return reach.reach(self, path, friction, helical, tool, speed, (far_force, push), depth, yield_share)

    # --- verdicts ---

    @overload
    def stability(
        self,
        load: AnyLoad,
        modes: Iterable[int] | None = None,
        *,
        growth_tolerance: float = 0.0,
        friction: float | None = None,
        kick: None = None,
        progress: Progress | None = None,
    ) -> RodStability: ...

    @overload
    def stability(
        self,
        load: AnyLoad,
        modes: Iterable[int] | None = None,
        *,
        growth_tolerance: float = 0.0,
        friction: float,
        kick: float,
        progress: Progress | None = None,
    ) -> FrictionalRodStability: ...

    @_load_hints
    def stability(
        self,
        load: AnyLoad,
        modes: Iterable[int] | None = None,
        *,
        growth_tolerance: float = 0.0,
        friction: float | None = None,
        kick: float | None = None,
        progress: Progress | None = None,
    ) -> RodStability | FrictionalRodStability:
        """Return the verdict on the rod under a load: stable when every mode is.

        Under a load with noise it is the verdict in mean square, and growth is that of second moments, twice that of
        amplitudes (docs/theory/noise.md); `critical_noise` is the largest noise that is stable.

        Parameters
        ----------
        load : AxialLoad, AxialWave or ForceRecord
            The noise of a record enters the error, and makes the verdict undecided where it would change it.
        modes : iterable of int, optional
            Modes to examine; by default all that can matter, see `modes_needed`.  Where modes are coupled, 1 to n.
        growth_tolerance : float
            Growth rate in 1/s up to which a mode counts as stable.
        friction : float, optional
            Coefficient of friction with the floor, static and kinetic, 0 or more.  Friction holds every undisturbed
            rod, so it needs a ``kick``.  For independent modes only.
        kick : float, optional
            Transverse velocity in m/s that every mode is given, 0 or more: stable when it destabilises none of them.
            It needs ``friction``.
        progress : callable, optional
            Called, where modes are coupled, with the numbers of verdicts reached and to reach: with two numbers of
            modes, and more while these disagree; for a record also on forces within its noise.  A verdict on
            kilometres of tubing takes minutes.

        Returns
        -------
        RodStability or FrictionalRodStability
            The second where a kick is given.  Modes are coupled by ends that are not hinged, by a force that varies
            along the rod, or where it is no pure sine.

        Warns
        -----
        UniformForceWarning
            When the rod is longer than a tenth of an axial wavelength (a heuristic limit).
        PlausibilityWarning
            When the load looks as if it were in another unit: Hz for rad/s, kN or mN for N.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = Rod.nitinol()
        >>> load = fr.AxialLoad(mean=0.2 * rod.critical_force, amplitude=0.2 * rod.critical_force, frequency=150.0)
        >>> rod.stability(load).unstable_modes
        (7,)
        """
        model = self.modes_under(require_load("load", load))
        return verdicts.stability(model, load, modes, growth_tolerance, friction, kick, progress)

    @_load_hints
    def critical_kick(self, load: AnyLoad, *, friction: float, growth_tolerance: float = 0.0) -> CriticalKick:
        """Return the smallest kick, a transverse velocity in m/s, found to buckle the rod against friction.

        Every mode is assumed to have the same kick; infinite where nothing grows even without friction.  The result
        also has the mode that the kick destabilises, and the proved kick up to which none buckles the rod.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = Rod.nitinol()
        >>> load = fr.AxialLoad(mean=0.825 * rod.critical_force, amplitude=0.7 * rod.critical_force, frequency=150.0)
        >>> kick, mode, none_up_to = rod.critical_kick(load, friction=0.1)
        >>> round(1e3 * kick, 1), mode, round(1e3 * none_up_to, 1)
        (32.1, 9, 27.8)
        """
        from floquetrod.rod.friction import kicks

        load, mu = require_load("load", load), friction_coefficient(friction)
        self.modes_under(load).require("friction")
        return kicks.critical_kick(self.stability(load, growth_tolerance=growth_tolerance), mu)

    def critical_kicks(
        self,
        mean: Any,
        amplitude: Any,
        frequency: Any,
        *,
        friction: float,
        growth_tolerance: float = 0.0,
        like: AnyLoad | None = None,
        workers: int | None = None,
    ) -> CriticalKick:
        """Return the results of `critical_kick` over arrays of loads (N, N, rad/s) that broadcast; mode 0 for none."""
        from floquetrod.rod.friction import kicks

        mu, tolerance = friction_coefficient(friction), units.tolerance("growth_tolerance", growth_tolerance)
        model, loads = self.modes_under(like), Loads.of(mean, amplitude, frequency)
        model.require("friction")
        return kicks.critical_kicks(self, model.systems(loads), mu, tolerance, workers)

    def stable_mean_forces(
        self,
        amplitude: float,
        frequency: float,
        bounds: tuple[float, float] | None = None,
        *,
        growth_tolerance: float = SLOW_GROWTH,
        like: AnyLoad | None = None,
        progress: Progress | None = None,
    ) -> StabilityIntervals:
        """Return all stability intervals of the mean force.

        Complete where modes are independent, with damping and tolerance too: tongues are found by counting, and inside
        one the growth is concave in the mean force (docs/theory/ranges.md).

        Parameters
        ----------
        amplitude : float
            dF in N, 0 or more.
        frequency : float
            omega in rad/s, greater than 0.
        bounds : tuple of float, optional
            Mean forces between which to search, (low, high) in N; by default from 0 to 1.5 critical forces.
        growth_tolerance : float
            Growth rate in 1/s up to which a mode counts as stable.  The default leaves out, and counts, the tongues
            in which nothing grows tenfold within a month; with 0 every tongue is resolved, which takes long where
            there are thousands, at low frequencies.
        like : AxialLoad, AxialWave or ForceRecord, optional
            Gives all other properties of the load; by default a sine, uniform except for the weight along the rod.
            Where modes are coupled loads are sampled, and the ``resolution`` of the result says how wide a band may be
            missed.
        progress : callable, optional
            Called with the numbers of modes searched and to search.

        Examples
        --------
        >>> rod = Rod.nitinol()
        >>> found = rod.stable_mean_forces(0.2 * rod.critical_force, 150.0, growth_tolerance=0.01)
        >>> len(found), 0.34 * rod.critical_force in found, 0.2 * rod.critical_force in found
        (5, True, False)
        """
        from floquetrod.rod.ranges import stable_values

        others: dict[Quantity, float] = {"amplitude": amplitude, "frequency": frequency}
        return stable_values(self.modes_under(like), "mean", others, bounds, growth_tolerance, progress)

    def stable_amplitudes(
        self,
        mean: float,
        frequency: float,
        bounds: tuple[float, float] | None = None,
        *,
        growth_tolerance: float = SLOW_GROWTH,
        like: AnyLoad | None = None,
        progress: Progress | None = None,
    ) -> StabilityIntervals:
        """Return all stability intervals of the amplitude.

        Complete for independent modes that the mean force alone would buckle.  For others growth need not be concave in
        the amplitude: with damping or tolerance unstable parts narrower than the ``resolution`` of the result may be
        missed (docs/theory/ranges.md).  Other arguments as in `stable_mean_forces`.

        Parameters
        ----------
        bounds : tuple of float, optional
            Amplitudes between which to search, (low, high) in N; by default from 0 to one critical force.
        """
        from floquetrod.rod.ranges import stable_values

        others: dict[Quantity, float] = {"mean": mean, "frequency": frequency}
        return stable_values(self.modes_under(like), "amplitude", others, bounds, growth_tolerance, progress)

    def stable_frequencies(
        self,
        mean: float,
        amplitude: float,
        bounds: tuple[float, float],
        *,
        growth_tolerance: float = SLOW_GROWTH,
        like: AnyLoad | None = None,
        progress: Progress | None = None,
    ) -> StabilityIntervals:
        """Return all stability intervals of the frequency.

        Complete where modes are independent, with damping and tolerance too: as 1 / omega^2 grows eigenvalues pass zero
        in one direction only, so that counting finds every tongue, and inside one the growth per period is concave in
        1 / omega^2 (docs/theory/ranges.md).  Other arguments as in `stable_mean_forces`.

        Parameters
        ----------
        bounds : tuple of float
            Frequencies between which to search, (low, high) in rad/s, the first greater than 0.
        """
        from floquetrod.rod.ranges import stable_values

        others: dict[Quantity, float] = {"mean": mean, "amplitude": amplitude}
        return stable_values(self.modes_under(like), "frequency", others, bounds, growth_tolerance, progress)

    def critical_mean_force(
        self,
        amplitude: float,
        frequency: float,
        *,
        growth_tolerance: float = SLOW_GROWTH,
        like: AnyLoad | None = None,
        progress: Progress | None = None,
    ) -> CriticalLoad:
        """Return the smallest mean force from 0 up, in N, at which a mode grows faster than ``growth_tolerance``.

        Infinite where there is none up to 1.5 critical forces.  ``like`` as in `stable_mean_forces`.  0.0 with a
        BucklingWarning where the weight along the rod alone buckles it, and with an UndecidedWarning where it could not
        be decided whether it is stable at zero.

        The search goes outward from zero in the pieces of `RodStability.margin`, each with as many modes as it needs.
        Where modes are coupled, or there is noise, loads are sampled: an unstable band narrower than
        ``CriticalLoad.resolution`` may have been passed over, and ``CriticalLoad.searched`` says how far was searched.

        ``progress`` is called with the numbers of parts of the search done and of all.  An exception that it raises
        ends the search, with a note up to which force nothing grows.
        """
        from floquetrod.rod.ranges import first_unstable

        others: dict[Quantity, float] = {"amplitude": amplitude, "frequency": frequency}
        return first_unstable(self.modes_under(like), "mean", others, growth_tolerance, progress)

    def critical_amplitude(
        self,
        mean: float,
        frequency: float,
        *,
        growth_tolerance: float = SLOW_GROWTH,
        like: AnyLoad | None = None,
        progress: Progress | None = None,
    ) -> CriticalLoad:
        """Return the smallest amplitude in N at which a mode grows faster than ``growth_tolerance``.

        Infinite where there is none up to one critical force.  ``like`` as in `stable_mean_forces`.  0.0 with a
        BucklingWarning where the weight along the rod, alone or with the mean force, buckles it without vibration.

        Searched as `critical_mean_force` is; ``CriticalLoad.resolution`` is not zero for independent modes either where
        damping or tolerance make `stable_amplitudes` state one.

        ``progress`` as in `critical_mean_force`.
        """
        from floquetrod.rod.ranges import first_unstable

        others: dict[Quantity, float] = {"mean": mean, "frequency": frequency}
        return first_unstable(self.modes_under(like), "amplitude", others, growth_tolerance, progress)

    def is_stable(
        self,
        mean: Any,
        amplitude: Any,
        frequency: Any,
        *,
        growth_tolerance: float = 0.0,
        criterion: FiniteTimeCriterion | None = None,
        friction: float | None = None,
        kick: float | None = None,
        like: AnyLoad | None = None,
        workers: int | None = None,
        progress: Progress | None = None,
    ) -> Any:
        """Return whether the rod is stable, over arrays of loads (N, N, rad/s) that broadcast, all relevant modes.

        A mode counts as stable up to ``growth_tolerance`` (1/s), or when it passes the ``criterion``.  With
        ``friction`` and a ``kick`` (m/s): whether the kick destabilises no mode.  Loads that cannot be decided are
        False, with an UndecidedWarning that counts them; `verdicts` shows which.  ``like`` (AxialLoad or AxialWave)
        gives all other properties of the loads; by default a sine, uniform except for the weight along the rod.
        ``progress`` is called repeatedly with the numbers of loads done and of all; an exception that it raises
        ends the work.

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
            kick=kick,
            like=like,
            workers=workers,
            progress=progress,
        )
        what = "loads could not be decided and count as not stable"
        return are("stable", found, what, "Rod.verdicts shows which, Rod.stability of one says why")

    def verdicts(
        self,
        mean: Any,
        amplitude: Any,
        frequency: Any,
        *,
        growth_tolerance: float = 0.0,
        criterion: FiniteTimeCriterion | None = None,
        friction: float | None = None,
        kick: float | None = None,
        like: AnyLoad | None = None,
        workers: int | None = None,
        progress: Progress | None = None,
    ) -> Any:
        """Return 1 where the rod is stable, 0 where it is not and -1 where that cannot be decided, as int8.

        Arguments as in `is_stable`.  Undecided are some kicks against friction, and coupled modes on a boundary.

        >>> Rod.nitinol().verdicts([0.2, 0.72], 1.187, 150.0, friction=0.1, kick=0.05)
        array([1, 0], dtype=int8)
        """
        numbers = mean, amplitude, frequency
        return verdicts.statuses(
            self.modes_under(like), numbers, growth_tolerance, criterion, friction, kick, workers, progress
        )

    def growth_rate(
        self,
        mean: Any,
        amplitude: Any,
        frequency: Any,
        *,
        like: AnyLoad | None = None,
        workers: int | None = None,
        progress: Progress | None = None,
    ) -> Any:
        """Return the growth rate in 1/s of the fastest mode over arrays of loads; 0 where stable.

        NaN where it cannot be computed: of coupled modes under loads far too slow or too strong for doubles.
        ``progress`` as in `is_stable`.
        """
        return self.fastest(mean, amplitude, frequency, like=like, workers=workers, progress=progress)[0]

    def fastest(
        self,
        mean: Any,
        amplitude: Any,
        frequency: Any,
        *,
        like: AnyLoad | None = None,
        workers: int | None = None,
        progress: Progress | None = None,
    ) -> tuple[Any, Any]:
        """Return the growth rate in 1/s and the number of the fastest mode over arrays of loads; 0, 0 where stable.

        Where modes are coupled their number is -1: `stability` names them.  ``progress`` as in `is_stable`.
        """
        validate.progress(progress)
        loads = Loads.of(mean, amplitude, frequency)
        growth, mode = self.modes_under(like).fastest(loads, workers, progress)
        return shaped(growth, loads.shape), shaped(mode, loads.shape)

    # --- after the onset ---

    def steady_motion(self, load: AnyLoad, mode: int | None = None, *, indentation: float = 1e-4) -> SteadyMotion:
        """Return how large the motion under a load becomes: a periodic orbit of the rod on its wall.

        Parameters
        ----------
        load : AxialLoad or AxialWave
        mode : int, optional
            Mode that moves most, from 1; by default the one that grows fastest, and where nothing grows the lowest that
            has a large orbit, which only a kick reaches.
        indentation : float
            Depth to which the weight of the rod at rest indents the wall, as a fraction of the radial clearance, from
            1e-8 to 0.1, as in `floquetrod.simulate`: next to hinged ends the rod lifts off a little.

        Returns
        -------
        SteadyMotion
            With its largest angle in rad, contact force in N/m, shortening in m, and whether it is stable against all
            modes; of amplitude 0 where the rod stays at rest, and a search finds no large orbit.

        Raises
        ------
        ValueError
            Where the rod moves further than 40 degrees; for free ends, and for channels that bend.

        Notes
        -----
        Lagrange's equations at finite angles and small slopes, with the inertia of shortening
        (docs/theory/large_motion.md), in the modes next to ``mode`` and those three times as short.  Against the
        simulator, whose force is that of axial waves, angles are within half a percent with clamped ends, and one with
        hinged ones.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = Rod.nitinol().replace(damping_rate=3.0, length=1.2)
        >>> load = fr.AxialLoad(mean=0.1 * rod.critical_force, amplitude=0.3 * rod.critical_force, frequency=110.0)
        >>> rod.steady_motion(load)
        <moves by 6.512 degrees in mode 2>
        """
        from floquetrod.rod import motion

        return motion.steady_motion(self.modes_under(require_load("load", load)), load, mode, indentation)

    def follow(
        self,
        load: AnyLoad | RodBranches,
        over: Mapping[str, tuple[float, float]] | None = None,
        mode: int | None = None,
        *,
        all_modes: bool = False,
        indentation: float = 1e-4,
        steps: int = 200,
        longest: float = 0.3,
        progress: Progress | None = None,
    ) -> RodBranches:
        """Return how large motion becomes over a range of loads: the branches of periodic motion in one mode.

        Orbits, stable and unstable ones, are searched for at a few loads of the range, and followed by
        `floquetrod.follow` through it and round folds, until motion shrinks to rest, the rod presses on its wall with
        less than a third of its weight and is about to leave it, or angles exceed 40 degrees.  If a load has two stable
        orbits, or one and a stable state of rest, the motion depends on the initial conditions: hysteresis.  Ctrl-C
        returns what has been found.

        Parameters
        ----------
        load : AxialLoad, AxialWave or RodBranches
            Where the search begins, or next to it in the range; other quantities are not varied.  Or branches of this
            rod, to be continued from their ends with their modes and indentation.
        over : mapping of str to (float, float)
            "frequency", "mean" or "amplitude", and the range in rad/s or N; of branches their own by default.
        mode : int, optional
            Mode that moves, as in `steady_motion`.
        all_modes : bool
            Whether to take all modes of `steady_motion`, in some minutes.
        indentation : float
            As in `steady_motion`.
        steps : int
            Largest number of orbits on each side of the start of a branch.
        longest : float
            Length of the longest step, in units of the range and of the largest magnitudes of the states.
        progress : callable, optional
            Called with the number of orbits found and the most there can be.

        Returns
        -------
        RodBranches
            With the largest angles in rad, verdicts, and where the rod leaves its wall.

        Raises
        ------
        ValueError
            Where no orbit is found, where nothing vibrates, and where `steady_motion` raises it.

        Notes
        -----
        In two modes, that which moves and the one three times as short, in some ten seconds; "stable" is against
        deviations in these.  Angles are within half a percent of those of all modes up to half of where the rod leaves
        its wall, and within three percent there, where those of the simulator are between the two.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = Rod.nitinol().replace(damping_rate=3.0, length=1.2)
        >>> load = fr.AxialLoad(mean=0.1 * rod.critical_force, amplitude=0.3 * rod.critical_force, frequency=110.0)
        >>> rod.follow(load, over={"frequency": (108.0, 111.0)}, steps=2)
        <1 branch of motion in mode 2, up to 6.5... degrees>
        """
        from floquetrod.rod import branches
        from floquetrod.rod.answers.rod_branches import RodBranches

        if isinstance(load, RodBranches):
            return branches.resumed(self, load, over, (mode, all_modes), indentation, steps, longest, progress)
        model = self.modes_under(require_load("load", load))
        return branches.branches(model, load, over, (mode, all_modes), indentation, steps, longest, progress)

    def safe_kick(self, load: AnyLoad, *, indentation: float = 1e-4) -> SafeKick:
        """Return the kicks after which a stable rod was found to come to rest, and those that lead to a large motion.

        A search for large stable orbits of each mode alone, up to 40 degrees, and for each mode that has one a scan
        over kicks of that mode and phases of the load: up to ``safe_up_to`` all that were tried came to rest, at
        ``escapes_at`` one did not.  The first is not proved: kicks between those tried, and in several modes at once,
        may lead to a large motion.

        Parameters
        ----------
        load : AxialLoad or AxialWave
        indentation : float
            As in `steady_motion`.

        Returns
        -------
        SafeKick
            Kicks in m/s, transverse velocities; infinite where no mode alone has a large orbit up to 40 degrees.

        Raises
        ------
        ValueError
            Where the rod at rest is not stable, without damping, and where `steady_motion` raises it.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = Rod.nitinol().replace(damping_rate=3.0, length=1.2)
        >>> rod.safe_kick(fr.AxialLoad(mean=0.1, amplitude=0.01, frequency=40.0))
        <no large motion of one mode found up to 40 degrees>
        """
        from floquetrod.rod import kicked_motion

        return kicked_motion.safe_kick(self.modes_under(require_load("load", load)), load, indentation)

    def critical_noise(
        self, load: AnyLoad, *, growth_tolerance: float = 0.0, progress: Progress | None = None
    ) -> CriticalFactor:
        """Return the factor by which the noise of a load may be multiplied with the rod still stable in mean square.

        Of noise 1 that is the largest density in N^2/Hz.  It is a number that knows its ``error``, within which the
        verdict, and that of arrays, changes from stable to unstable, mostly 1e-10 of it, and the ``mode`` that grows
        beyond; infinite where no change is found.  Where modes are coupled the error is that of the modes a verdict
        takes, mostly a millionth; of a density that depends on the frequency a lower bound.

        Parameters
        ----------
        load : AxialLoad
            With noise.
        growth_tolerance : float
            Growth of second moments in 1/s up to which a mode counts as stable.
        progress : callable, optional
            Called with the numbers of parts of the search done and of all that are known of.

        Raises
        ------
        ValueError
            For a load without noise, and where the rod is not stable without it.

        Examples
        --------
        Of a rod that is pulled high modes decide: 8 c E I m, c the damping rate, m the mass per length in motion.

        >>> import floquetrod as fr
        >>> rod = Rod.nitinol().replace(damping_rate=1.0)
        >>> bound = 8.0 * rod.damping_rate * rod.flexural_rigidity * rod.mass_per_length
        >>> round(rod.critical_noise(fr.AxialLoad(-1.0, 0.0, 150.0, noise=1.0)) / bound, 6)
        1.0
        """
        found, tolerance = require_noise("load", load), units.tolerance("growth_tolerance", growth_tolerance)
        validate.progress(progress)
        return self.modes_under(found).critical_noise(found, tolerance, progress)

    # --- proofs ---

    def certify(
        self,
        mean: Any,
        amplitude: Any,
        frequency: Any,
        *,
        growth_tolerance: float = SLOW_GROWTH,
        rod: Mapping[str, Any] | None = None,
        like: AnyLoad | None = None,
        max_boxes: int = MAX_BOXES,
        progress: Progress | None = None,
    ) -> RegionProof:
        """Prove every load of a box stable or unstable, on this rod or on every rod within tolerances.

        Interval arithmetic, rounded outwards, over boxes that are halved until they are decided; all modes, those
        beyond a number by a bound (docs/theory/regions.md).

        Parameters
        ----------
        mean : float or (low, high)
            F_ave in N: a number, or both ends of its range.
        amplitude : float or (low, high)
            dF in N, 0 or more: a number, or both ends of its range.
        frequency : float or (low, high)
            omega in rad/s, greater than 0: a number, or both ends of its range.
        growth_tolerance : float
            Growth rate in 1/s up to which a mode counts as stable.  Without damping no box of positive size can be
            proved stable with 0: thin tongues are everywhere.
        rod : mapping, optional
            Parameters of the rod that vary, by name, each a number or (low, high) in SI units:
            ``{"length": (3.05, 3.15)}``; diameters may be given in place of radii.
        like : AxialLoad, optional
            Gives all other properties of the load: ``AxialLoad(0, 0, 1, mean_at=None)`` neglects the weight
            along an inclined rod.
        max_boxes : int
            Parts of the box to examine before it is given up.
        progress : callable, optional
            Called with the numbers of parts examined and of those allowed.

        Returns
        -------
        RegionProof
            "stable": under every load of the box, on every rod, no mode grows faster than the tolerance; "unstable":
            under every one some mode does; "mixed": with a proved example of each; "undecided": with the share of the
            box that was proved.

        Raises
        ------
        ValueError
            For a box whose ends do not increase, that reaches zero frequency, or that holds impossible rods; for modes
            that are coupled; for loads that need more than 20,000 modes.
        TypeError
            For anything that is not a number.

        Examples
        --------
        >>> rod = Rod.nitinol().replace(damping_rate=0.5)
        >>> rod.certify(mean=(0.56, 0.59), amplitude=(0.32, 0.35), frequency=(149.0, 151.0)).status
        'stable'
        """
        sides = mean, amplitude, frequency
        return self.modes_under(like).certify(sides, growth_tolerance, rod, max_boxes, progress)

    def largest_safe_box(
        self,
        around: AnyLoad,
        *,
        vary: Iterable[Quantity] = QUANTITIES,
        growth_tolerance: float = SLOW_GROWTH,
        rod: Mapping[str, Any] | None = None,
        accuracy: float = 0.01,
        progress: Progress | None = None,
    ) -> SafeBox:
        """Return a box of loads about a working point that is proved safe, and cannot be widened on any one side.

        First the widest window of the same relative width in each quantity; then each side alone is moved outwards,
        in turn, as far as the proof goes.  Forces are searched up to a critical force away, frequencies from half to
        twice.

        Parameters
        ----------
        around : AxialLoad
            The working point.
        vary : iterable of "mean", "amplitude", "frequency"
            Quantities that may vary.
        growth_tolerance : float
            Growth rate in 1/s up to which a mode counts as stable.
        rod : mapping, optional
            Tolerances of the rod, as in `certify`: the box is safe for every rod within them.
        accuracy : float
            How closely sides are found, as a fraction of the width of the box, 1e-4 to 0.5.
        progress : callable, optional
            Called with the numbers of sides moved and of those to move at most.

        Raises
        ------
        ValueError
            Where the load itself is not proved stable, on every rod within the tolerances; and as `certify` does.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = Rod.nitinol().replace(damping_rate=0.5)
        >>> safe = rod.largest_safe_box(fr.AxialLoad(0.577, 0.339, 150.0), vary=("mean", "frequency"), accuracy=0.1)
        >>> safe.proof.status
        'stable'
        """
        from floquetrod.rod.answers.safe_box import largest_safe_box

        load = require_load("around", around)
        judge = partial(self.modes_under(load).verdict, load, None)
        self.modes_under(load).require("largest_safe_box")
        return largest_safe_box(self, load, judge, vary, growth_tolerance, rod, accuracy, progress)
