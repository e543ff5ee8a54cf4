"""The rod on the channel floor: data sheet and load in, verdict over all modes that matter out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, overload

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arrays import shaped
from floquetrod._util.calling import call_hints
from floquetrod._util.progress import Progress
from floquetrod._util.result_report import Report, ShownInNotebook
from floquetrod.equations import HillSystem
from floquetrod.floquet.proof.proof import MAX_BOXES
from floquetrod.floquet.status import are
from floquetrod.mathieu.paper_criterion import FiniteTimeCriterion
from floquetrod.rod import verdicts
from floquetrod.rod.loads.load import QUANTITIES, AnyLoad, Load, Quantity, kind, require_load, require_noise
from floquetrod.rod.loads.template import replaced, replaced_loads, require_no_record, require_one_load
from floquetrod.rod.mode_equations.coupling import WAVEFORM, coupling
from floquetrod.rod.mode_equations.modal_systems import ModalSystem
from floquetrod.rod.model.constants import SLOW_GROWTH
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.parameters import friction_coefficient
from floquetrod.rod.model.possible_rod import require_known_to_verdicts
from floquetrod.rod.model.rod_in_words import rod_report
from floquetrod.rod.modes.independent import IndependentModel
from floquetrod.rod.modes.mode_model import ModeModel

# Loaded by the methods that need them: a first verdict takes a quarter of the package.
if TYPE_CHECKING:
    from floquetrod.floquet.proof.region_proof import RegionProof
    from floquetrod.rod.answers.critical_value import CriticalValue
    from floquetrod.rod.answers.mean_force import MeanForce
    from floquetrod.rod.answers.rod_branches import RodBranches
    from floquetrod.rod.answers.rod_response import RodResponse
    from floquetrod.rod.answers.rod_stability import RodStability
    from floquetrod.rod.answers.safe_box import SafeBox
    from floquetrod.rod.answers.safe_kick import SafeKick
    from floquetrod.rod.answers.stability_intervals import StabilityIntervals
    from floquetrod.rod.answers.steady_motion import SteadyMotion
    from floquetrod.rod.answers.string_reach import Reach
    from floquetrod.rod.answers.surface_weights import SurfaceWeights
    from floquetrod.rod.friction.kicks import CriticalKick, FrictionalRodStability
    from floquetrod.rod.loads.tool import VibrationTool
    from floquetrod.wells.path import WellPath


def _model(rod: RodData, like: Load) -> ModeModel:
    """Return what the modes are; of a rod with hinged ends under a sine nothing else is loaded."""
    require_known_to_verdicts(rod)
    coupled = coupling(rod, like)
    if like.second is not None and set(coupled) <= {WAVEFORM} and rod.course.is_straight:
        from floquetrod.rod.modes.two_frequencies import TwoFrequencyModel

        return TwoFrequencyModel(rod, like)
    if like.second is not None:
        from floquetrod.rod.modes.two_frequencies_coupled import TwoFrequencyCoupledModel

        return TwoFrequencyCoupledModel(rod, like)
    if not coupled and not like.noise:
        return IndependentModel(rod, like)
    if not like.noise and coupled == (WAVEFORM,) and len(like.harmonics) == 1:
        from floquetrod.rod.modes.one_harmonic import OneHarmonicModel, has_one_harmonic

        if has_one_harmonic(like):
            return OneHarmonicModel(rod, like)
    if not like.noise:
        from floquetrod.rod.modes.coupled import CoupledModel

        return CoupledModel(rod, like)
    if set(coupled) <= {WAVEFORM}:
        from floquetrod.rod.modes.noisy_verdict import NoisyModel

        return NoisyModel(rod, like)
    from floquetrod.rod.modes.noisy_coupled import NoisyCoupledModel

    return NoisyCoupledModel(rod, like)


_ONE_LOAD = "its load is one value, such as fr.AxialLoad(mean, amplitude, frequency)"
_one_load_hints = call_hints(_ONE_LOAD, mean=_ONE_LOAD, amplitude=_ONE_LOAD, frequency=_ONE_LOAD)
_loads_hints = call_hints("give numbers and arrays by name: mean=, amplitude=, frequency=, after a load or without one")


@dataclass(frozen=True, init=False, repr=False)
class Rod(RodData, ShownInNotebook):
    """An elastic rod or tube of circular section on the floor of a circular channel, straight or bent.

    Parameters
    ----------
    youngs_modulus : float or str
        Young's modulus E in Pa, or a string with a unit such as "68GPa"; greater than 0.
    density : float or str
        Density rho of the material in kg/m^3, or with a unit such as "7.85g/cm3"; greater than 0.  Give it or
        ``weight``.
    radius : float or str
        Outer radius r_o in m, or with a unit such as "0.8mm"; greater than 0.  Give it or ``diameter``.
    length : float or str
        Length L in m, or with a unit such as "40ft"; greater than 0.
    channel_radius : float or str
        Inner radius of the channel in m, or with a unit; greater than ``radius``.  Give it or ``channel_diameter``.
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
        pi^2/3 - 1 = 2.29, the value for a cylinder touching a plane floor; more in a narrow gap.
    inclination : float or str
        Angle of the channel from the vertical in rad, or with a unit such as "60deg"; above 0 and at most pi/2, which
        is horizontal and the default.  In a channel that bends, the angle at the middle of the rod.
    ends : str
        "hinged", the default, "clamped", "guided" or "free", or two of them, the upper end first: "clamped-hinged".
        See `floquetrod.rod.EndConditions`.
    curvature : float or str
        Curvature of the channel in its vertical plane in 1/m, or with a unit such as "3deg/30m"; positive where it
        builds, 0 by default.  It and the weight across are taken as uniform, so that modes stay independent.
    path : WellPath, optional
        Path of the well in place of ``inclination`` and ``curvature``, or a mapping of its arguments.
    depth : float or str
        Measured depth of the upper end on the path in m, or with a unit, 0 by default.
    residual_curvature : float or str
        Curvature of the rod without load in 1/m, or with a unit such as "0.1rad/m", as of coiled tubing from its reel;
        0, straight, by default.  The channel holds it straight, which bends it, and presses its lower end to the wall
        (page `theory/surface_weights`); for strings in wells and stresses.
    natural_shape : mapping or sequence of (float or str), optional
        Deflection of the rod across its channel without load, by default none: ``{5: "0.1mm"}``, amplitudes of sines by
        their half waves; deflections in m, or with a unit, at equal distances from the upper to the lower end;
        ``{"curvature": "0.1rad/m", "direction": "90deg"}``, a bend in a plane at an angle from the vertical one; or
        ``{"rms": "0.1mm", "correlation_length": "0.5m"}``, a random one.  It moves a rod that is stable, see
        `response`, and changes no verdict.
    yield_strength : float or str, optional
        Yield strength of the material in Pa, or with a unit such as "620MPa", to which `stress` is compared; a pipe of
        the catalogue has the one of its grade.
    sections : sequence of Section or mapping, optional
        Sections of a string from its upper end down, see `floquetrod.Section`, in place of ``length``, radii, material
        and yield strength, which the first section then gives; like neighbours count as one.  The
        modes are coupled.
    bores : sequence of (float or str, float or str), optional
        Bores of the hole, each from a depth in m, or with a unit, and with a diameter, in place of ``channel_radius``:
        ``[("0m", "4.778in"), ("1500m", "6.184in")]``; measured depths in a well, and from the upper end without one.
    diameter : float or str, optional
        Outer diameter in m, or with a unit, in place of ``radius``.
    inner_diameter : float or str, optional
        Inner diameter in m, or with a unit, in place of ``inner_radius``.
    channel_diameter : float or str, optional
        Inner diameter of the channel in m, or with a unit, in place of ``channel_radius``.
    wall_thickness : float or str, optional
        Wall of a tube in m, or with a unit, in place of ``inner_radius``; at most the outer radius.
    weight : float or str, optional
        Weight in air per length in N/m, or with a unit such as "22.6lb/ft" or "33.6kg/m", in place of ``density``; it
        includes the joints, spread over the length.  The density is chosen to give this mass per length; the body
        alone displaces fluid.

    Raises
    ------
    TypeError, ValueError
        For numbers out of these ranges, other units, arguments that are missing or exclude each other, and a rod
        that floats; the message names the argument and the way out.

    Warns
    -----
    PlausibilityWarning
        When a parameter looks as if it were in another unit, or a diameter where a radius belongs.

    Notes
    -----
    Eq. (1) of DOI 10.1115/1.4031710, with the inertia, weight and bending stiffness of a tube in fluids.  The parts of
    a rod, and the quantities derived from them, are described at `floquetrod.rod.model.data.RodData`, the data sheet.

    Where the channel bends the force enters twice, m R theta_tt + E I R theta_ssss + (F R theta_s)_s + N theta = 0 with
    the contact force N = w_e sin(inclination) + F curvature per length: it restores long waves where the channel
    builds.  On a path that turns N = hypot(w_e sin(phi) + F kappa_n, F kappa_b), and verdicts concern small motion
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
    >>> string = Rod(
    ...     sections=[fr.Section("2.00x0.156 CT90", length="30m"), fr.Section("2.00x0.203 CT90", length="30m")],
    ...     channel_diameter="4.778in", fluid_inside=1000.0, fluid_outside=1000.0, damping_rate=0.2
    ... )
    >>> string.stability(fr.AxialLoad(mean="7.1kN", amplitude="3.84kN", frequency="2.55Hz"))
    <unstable: direct resonance of mode 6, order 1; 1.06... 1/s, tenfold in 2.1... s; 23 coupled modes; ...>
    >>> well = fr.WellPath.arc(length=600.0, inclination=("30deg", "90deg"), depth=1000.0)
    >>> round(tubing.replace(path=well, depth=1200.0).critical_force)
    14101
    """

    # --- modes ---

    def _at_hand(self) -> Report:
        """Return the rod for a notebook."""
        return rod_report(self)

    def _modes_under(self, template: AnyLoad | None = None) -> ModeModel:
        """Return the model of the modes under any load of the kind of the template, by default a sine.

        This is the one place where a model of the modes is chosen.

        >>> rod = Rod.nitinol().replace(ends="clamped")
        >>> type(rod._modes_under()).__name__, rod._modes_under().coupling
        ('CoupledModel', ('clamped ends',))
        """
        return _model(self, kind(template))

    @overload
    def modal_system(self, load: AnyLoad, modes: Iterable[int] | None = None) -> ModalSystem | HillSystem: ...

    @overload
    def modal_system(
        self,
        load: AnyLoad | None = None,
        modes: Iterable[int] | None = None,
        *,
        mean: Any = None,
        amplitude: Any = None,
        frequency: Any = None,
    ) -> Any: ...

    @_loads_hints
    def modal_system(
        self,
        load: AnyLoad | None = None,
        modes: Iterable[int] | None = None,
        *,
        mean: Any = None,
        amplitude: Any = None,
        frequency: Any = None,
    ) -> Any:
        """Return the equations of the rod's modes under a load, or under arrays of loads.

        Other arguments as in `is_stable`.

        Parameters
        ----------
        modes : iterable of int, optional
            Mode numbers, 1 to 20,000; by default all that can matter, see `modes_needed`.  Of coupled modes 1 to n.
            Under one load only.

        Returns
        -------
        ModalSystem or HillSystem
            Independent equations where the ends are hinged and the force is a sine, uniform along the rod.  Otherwise
            one system in seconds; its unknowns are the amplitudes of beam functions and a few others, see
            `floquetrod.rod.model.beam`.
        ModalSystems
            Of arrays of loads, under which modes are independent.

        Raises
        ------
        ValueError
            For invalid mode numbers, for loads that need more than 20,000 modes or too large coefficients, and for
            arrays of loads that couple the modes.

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
        template, loads, single = replaced_loads(load, mean, amplitude, frequency)
        if single is not None:
            return self._modes_under(template).equations(require_load("load", single), modes)
        require_one_load("modes", modes)
        return self._modes_under(template).systems(loads)

    def modes_needed(self, load: AnyLoad, growth_tolerance: float = 0.0) -> tuple[int, float]:
        """Return how many modes decide a verdict, and a bound in 1/s on the growth of every mode beyond them.

        High modes sit in resonance tongues that grow, but exponentially slowly.  `modes_left_out` of
        ``rod/mode_equations`` derives the bound, and M is the least number for which it is below 1e-12 per second (or
        ``growth_tolerance``, if larger).  M grows like the length of the rod.

        M never falls as mean force, amplitude or frequency rise, so it serves every load below in each of them: at
        fixed q and mode a larger mean lowers a, a larger amplitude raises q, and both raise every factor of the bound;
        a, q and c^2 go like 1 / omega^2, so a higher frequency leaves fewer evanescent factors q / (a - k^2 - q), each
        larger, before a rate that in 1/s does not depend on it.

        Returns
        -------
        tuple of (int, float)
            The number M, and the bound in 1/s.

        Raises
        ------
        TypeError, ValueError
            For anything but a load, and a negative tolerance.
        """
        load, tolerance = require_load("load", load), units.tolerance("growth_tolerance", growth_tolerance)
        return self._modes_under(load).modes_needed(load, tolerance)

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
        wellhead_pressure: float | str = 0.0,
        stripper: float | str = 0.0,
    ) -> MeanForce:
        """Return the mean force along a string of this section in a well, from the beginning of its path down.

        The rod's own length and inclination are not used.  A string of several sections has their lengths: they are
        counted from its lower end as it goes in, so that the section at a depth changes; its bores, and friction, are
        by measured depth.  What does not pass a bore on its way is refused.

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
            Measured depth of the lower end in m, no deeper than a string of several sections is long; by default the
            end of the path.
        depth : array_like, optional
            Measured depths in m, or each with a unit, at which the force is wanted, beside both ends; by default every
            10 m or so.
        tool : VibrationTool, optional
            It vibrates the string, and reduces friction where its speed exceeds the speed of sliding.  The ends of the
            string reflect its wave; friction and the rod's ``damping_rate`` damp it.  500 waves at most along the
            string.
        speed : float or str
            Speed of sliding in m/s, which is used with a tool only.
        helical : str
            When a pushed string becomes a helix: "energy", "loading" or "alone", from sqrt(2), 1.83 or 2 sqrt(2) times
            the force at which it begins to snake, see `critical_forces`; "always", wherever it is compressed.
        wellhead_pressure : float or str
            Pressure around the string below the stripper in Pa, or with a unit such as "3000psi", above the pressure
            of the air; times the cross-section pi r_o^2 it is the force that pushes the string out.
        stripper : float or str
            Friction of the stripper in N, or with a unit; against the motion.

        Returns
        -------
        MeanForce
            Force, contact and buckling at each depth; its ``at_top`` in N is the force at the upper end.

        Raises
        ------
        TypeError, ValueError
            For numbers out of range, naming the argument.

        Notes
        -----
        dF/ds = w cos(phi) - mu N with the contact force N = hypot(w sin(phi) + F kappa_n, F kappa_b), plus
        F^2 R / (4 E I) of a helix (page `theory/mean_force`).

        Examples
        --------
        >>> import floquetrod as fr
        >>> well = fr.WellPath([0.0, 1000.0, 1450.0, 3000.0], ["0deg", "0deg", "90deg", "90deg"])
        >>> tubing = Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
        >>> tubing.mean_force(well, 0.2)
        <string pushed to 3000 m needs 32.27 kN of pull at 0 m>
        """
        from floquetrod.rod.answers import mean_force
        from floquetrod.rod.model.wellhead import Wellhead

        drag = mean_force.drag_of(self, path, friction, motion, helical, tool, speed)
        wellhead = Wellhead.of(wellhead_pressure=wellhead_pressure, stripper=stripper)
        return mean_force.mean_force(self, drag, far_force, bottom, depth, wellhead)

    def surface_weights(
        self,
        path: WellPath,
        friction: Any,
        *,
        far_force: float | str = 0.0,
        depth: Any = None,
        helical: str = "energy",
        wellhead_pressure: float | str = 0.0,
        stripper: float | str = 0.0,
    ) -> SurfaceWeights:
        """Return the weights at which a string of this section is picked up and slacked off, over its depth in a well.

        A string of several sections is as in `mean_force`.  The ``plot`` is the chart by which measured weights tell
        the friction of a well.

        Parameters
        ----------
        path : WellPath
        friction : float or sequence
            Factors of friction with the wall, 12 at most, each as in `mean_force`: ``[0.2, 0.3]``, or with others by
            depth ``[[(0, 0.2), ("1500m", 0.3)], 0.25]``.
        far_force : float or str
            Compression at the lower end in N, negative for a pull; the same up and down.
        depth : array_like, optional
            Measured depths of the lower end in m, or each with a unit; 100 by default.
        helical : str
            When the string becomes a helix while slacked off, as in `mean_force`.
        wellhead_pressure : float or str
            Pressure around the string below the stripper in Pa, as in `mean_force`.
        stripper : float or str
            Friction of the stripper in N.

        Returns
        -------
        SurfaceWeights
            ``pick_up`` and ``slack_off`` in N, a row for each factor of friction.

        Raises
        ------
        TypeError, ValueError
            For numbers out of range, naming the argument.

        Examples
        --------
        >>> import floquetrod as fr
        >>> well = fr.WellPath([0.0, 1000.0, 1450.0, 2500.0], ["0deg", "0deg", "90deg", "90deg"])
        >>> tubing = Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
        >>> tubing.surface_weights(well, 0.2, wellhead_pressure="10MPa", stripper="5kN")
        <What does the string weigh at 2,500 m? 30.14 kN without friction; with friction 0.2: 45.56 kN picked up, ...>
        """
        from floquetrod.rod.answers import surface_weights
        from floquetrod.rod.model.wellhead import Wellhead

        wellhead = Wellhead.of(wellhead_pressure=wellhead_pressure, stripper=stripper)
        return surface_weights.surface_weights(self, path, friction, far_force, depth, helical, wellhead)

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
        wellhead_pressure: float | str = 0.0,
        stripper: float | str = 0.0,
        pressure_inside: float | str | None = None,
    ) -> Reach:
        """Return how far a string of this section can be pushed into a well, without and with a vibration tool.

        Arguments are as in `mean_force`, and besides:

        Parameters
        ----------
        push : float or str, optional
            Greatest compression in N that the injector gives, against pressure and stripper too; by default any.
        yield_share : float or None
            Largest stress anywhere along the string, of force, bending and pressure together, as a fraction of the
            rod's ``yield_strength``: more than 0, 1 at most, or None for any.  Without a yield strength nothing is
            limited.
        depth : array_like, optional
            Measured depths in m, or each with a unit such as "9000ft", of the lower end at which the force at the upper
            end is wanted; 100 by default.  The reach is sought down to the deepest of them, and does not depend on the
            others.
        pressure_inside : float or str, optional
            Pressure in the string at its upper end in Pa, or with a unit, above the pressure of the air, for von
            Mises' stress with the hoop and radial stress of a thick wall; ``wellhead_pressure`` is the pressure around
            it there, and both grow downwards with the weight of the fluids at rest.  By default both are taken as
            equal all along, which leaves axial and bending stress.

        Returns
        -------
        Reach
            Its ``reach`` and ``lock_up`` in m, ``reach_shaken`` with a tool, and the force at each depth.

        Raises
        ------
        TypeError, ValueError
            For numbers out of range, and for a string that does not pass a bore; the message names the argument.

        Notes
        -----
        The reach is the greatest depth within ``push`` and ``yield_share``; ``lock_up`` is the one at which no force
        moves the string, beyond which it does not go however strong it is.  A string of several sections is as in
        `mean_force`, each with its own yield strength; it reaches no deeper than it is long, and ``limiting_section``
        is the one that limits it.  Its joints go deeper together, so that two of the depths examined are a hundredth
        of the path apart at most, and a string stopped between two and no longer at the second is not seen to be.

        Examples
        --------
        >>> import floquetrod as fr
        >>> well = fr.WellPath([0.0, 1000.0, 1450.0, 4000.0], ["0deg", "0deg", "90deg", "90deg"])
        >>> tubing = Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
        >>> tubing.reach(well, 0.3, depth=[2000.0, 3000.0, 4000.0])
        <How far does the string go? To 2,990 m, where it locks up.>
        """
        from floquetrod.rod.answers import string_reach
        from floquetrod.rod.model.wellhead import Wellhead

        wellhead = Wellhead.of(wellhead_pressure=wellhead_pressure, stripper=stripper, pressure_inside=pressure_inside)
        string = self, path, friction, helical, tool, speed
        return string_reach.reach(*string, (far_force, push), depth, yield_share, wellhead)

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

    @_one_load_hints
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

        Under a load with noise it is the verdict in mean square, and growth is the rate of second moments, twice the
        rate of amplitudes (page `theory/noise`); `critical` finds the largest noise that is stable.  Under a load of
        two frequencies "stable" means that nothing grows faster than the tolerance, which damping or a
        ``growth_tolerance`` makes possible (page `theory/two_frequencies`).

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
            The second where a kick is given.  Modes are coupled by ends other than hinged, and by a force that varies
            along the rod or is no pure sine.

        Raises
        ------
        TypeError, ValueError
            For anything but a load, modes that are no whole numbers from 1, a negative tolerance, friction without
            a kick or a kick without friction, and friction where modes are coupled.

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
        model = self._modes_under(require_load("load", load))
        return verdicts.stability(model, load, modes, growth_tolerance, friction, kick, progress)

    @_loads_hints
    def critical_kick(
        self,
        load: AnyLoad | None = None,
        *,
        friction: float,
        mean: Any = None,
        amplitude: Any = None,
        frequency: Any = None,
        growth_tolerance: float = 0.0,
        workers: int | None = None,
    ) -> CriticalKick:
        """Return the smallest kick, a transverse velocity in m/s, found to buckle the rod against friction.

        Every mode is assumed to have the same kick; infinite where nothing grows even without friction.  The result
        also has the mode that the kick destabilises, and the proved kick up to which none buckles the rod; of arrays of
        loads, given as in `is_stable`, it has arrays, and mode 0 for none.

        Returns
        -------
        CriticalKick
            ``kick`` and ``none_up_to`` in m/s, and ``mode``.

        Raises
        ------
        TypeError, ValueError
            For friction that is negative, where modes are coupled, and as `is_stable`.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = Rod.nitinol()
        >>> load = fr.AxialLoad(mean=0.825 * rod.critical_force, amplitude=0.7 * rod.critical_force, frequency=150.0)
        >>> kick, mode, none_up_to = rod.critical_kick(load, friction=0.1)
        >>> round(1e3 * kick, 1), mode, round(1e3 * none_up_to, 1)
        (32.1, 9, 27.8)
        >>> rod.critical_kick(load, friction=0.1, mean=[0.0, load.mean]).mode
        array([7, 9])
        """
        from floquetrod.rod.friction import kicks

        mu, (template, loads, single) = friction_coefficient(friction), replaced_loads(load, mean, amplitude, frequency)
        self._modes_under(template).require("friction")
        validate.workers(workers)
        if single is not None:
            return kicks.critical_kick(self.stability(single, growth_tolerance=growth_tolerance), mu)
        return kicks.critical_kicks(self, self._modes_under(template).systems(loads), mu, growth_tolerance, workers)

    @_loads_hints
    def ranges(
        self,
        quantity: Quantity,
        load: AnyLoad | None = None,
        bounds: tuple[Any, Any] | None = None,
        *,
        mean: Any = None,
        amplitude: Any = None,
        frequency: Any = None,
        growth_tolerance: float = SLOW_GROWTH,
        progress: Progress | None = None,
    ) -> StabilityIntervals:
        """Return all stability intervals of one quantity of the load.

        Where modes are independent tongues are found by counting.  Of the mean force and the frequency all intervals
        are found, with damping and tolerance too: inside a tongue growth is concave in the mean force, and growth per
        period in 1 / omega^2.  Of the amplitude all are found of modes that the mean force alone would buckle.
        Elsewhere, and where modes are coupled, loads are sampled, and unstable parts narrower than the ``resolution``
        of the result may be missed (page `theory/ranges`).

        Parameters
        ----------
        quantity : "mean", "amplitude" or "frequency"
        load : AxialLoad, AxialWave or ForceRecord, optional
            Gives everything but the quantity; by default a sine, uniform except for the weight along the rod.
        bounds : pair of float or str, optional
            Values between which to search, (low, high) in N, in rad/s or with units; by default forces from 0 to 1.5
            critical forces, and amplitudes from 0 to one.  Frequencies have no default; the first is greater than 0.
        mean : float or str, optional
            Mean force in N or with a unit, in place of the load's own; without a load both other quantities are needed.
        amplitude : float or str, optional
            Amplitude in N or with a unit, likewise.
        frequency : float or str, optional
            Angular frequency in rad/s, or a frequency with a unit, likewise.
        growth_tolerance : float
            Growth rate in 1/s up to which a mode counts as stable.  The default leaves out, and counts, the tongues
            in which nothing grows tenfold within a month; with 0 every tongue is resolved, which takes long where
            there are thousands, at low frequencies.
        progress : callable, optional
            Called with the numbers of modes searched and to search.

        Returns
        -------
        StabilityIntervals
            ``intervals`` and ``unstable`` bands, in N or rad/s.

        Raises
        ------
        TypeError, ValueError
            For another quantity, bounds that do not increase, numbers out of range, and a frequency without bounds.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = Rod.nitinol()
        >>> load = fr.AxialLoad(mean=0.3, amplitude=0.2 * rod.critical_force, frequency=150.0)
        >>> means = rod.ranges("mean", load, growth_tolerance=0.01)
        >>> len(means), 0.34 * rod.critical_force in means, 0.2 * rod.critical_force in means
        (5, True, False)
        >>> len(rod.ranges("frequency", load, ("10Hz", "40Hz")))
        28
        """
        from floquetrod.rod.stable_loads import stable_intervals

        validate.choice("quantity", quantity, QUANTITIES)
        template, others = replaced(load, mean, amplitude, frequency, quantity)
        return stable_intervals(self._modes_under(template), quantity, others, bounds, growth_tolerance, progress)

    @overload
    def critical(
        self,
        quantity: Literal["mean", "amplitude"],
        load: AnyLoad | None = None,
        *,
        mean: Any = None,
        amplitude: Any = None,
        frequency: Any = None,
        growth_tolerance: float | None = None,
        progress: Progress | None = None,
    ) -> CriticalValue: ...

    @overload
    def critical(
        self,
        quantity: Literal["noise"],
        load: AnyLoad,
        *,
        mean: Any = None,
        amplitude: Any = None,
        frequency: Any = None,
        growth_tolerance: float | None = None,
        progress: Progress | None = None,
    ) -> CriticalValue: ...

    @_loads_hints
    def critical(
        self,
        quantity: Literal["mean", "amplitude", "noise"],
        load: AnyLoad | None = None,
        *,
        mean: Any = None,
        amplitude: Any = None,
        frequency: Any = None,
        growth_tolerance: float | None = None,
        progress: Progress | None = None,
    ) -> CriticalValue:
        """Return the smallest mean force or amplitude from 0 up at which a mode grows, or the largest stable noise.

        Forces are in N; noise is a factor on the load's noise, so that for a load of noise 1 it is a density in N^2/Hz.

        The search for a force goes outward from zero, up to 1.5 critical forces of the mean and one of the amplitude,
        in the pieces of `RodStability.margin`, each with as many modes as it needs.  Infinite where nothing grows.
        Where modes are coupled, or there is noise, or the amplitude is searched with damping or tolerance, loads are
        sampled: an unstable band narrower than ``CriticalValue.resolution`` may have been passed over, and
        ``CriticalValue.searched`` says how far was searched.

        The factor on the noise has an ``error``, mostly 1e-10 of it, within which the verdict changes from stable to
        unstable, for single loads as for arrays, and the ``mode`` that grows beyond; it is infinite where no change is
        found.  Where modes are coupled the error, mostly a millionth, comes from the number of modes; where the
        density depends on the frequency the factor is a lower bound.  Other arguments as in `ranges`.

        Parameters
        ----------
        quantity : "mean", "amplitude" or "noise"
            Of the noise, for a load that has some, the factor by which it may be multiplied.
        growth_tolerance : float, optional
            Growth rate in 1/s up to which a mode counts as stable: by default as in `ranges` for forces, and 0 for
            noise, where it is the growth of second moments.
        progress : callable, optional
            Called with the numbers of parts of the search done and of all.  An exception that it raises ends the
            search, with a note up to which force nothing grows.

        Returns
        -------
        CriticalValue
            A float, in N or a factor on the noise.

        Raises
        ------
        ValueError
            For noise where the load has none, and where the rod is not stable without it.

        Warns
        -----
        BucklingWarning
            Where the result is 0.0 since the weight along the rod, with the mean force if an amplitude is searched,
            buckles it without vibration.
        UndecidedWarning
            Where the result is 0.0 since it could not be decided whether the rod is stable at zero.

        Examples
        --------
        Of a rod that is pulled high modes decide: 8 c E I m, c the damping rate, m the mass per length in motion.

        >>> import floquetrod as fr
        >>> rod = Rod.nitinol().replace(damping_rate=1.0)
        >>> bound = 8.0 * rod.damping_rate * rod.flexural_rigidity * rod.mass_per_length
        >>> round(rod.critical("noise", fr.AxialLoad(-1.0, 0.0, 150.0, noise=1.0)) / bound, 6)
        1.0
        >>> round(Rod.nitinol().critical("mean", fr.AxialLoad(0.0, 0.3, 150.0)), 6)
        0.104749
        """
        validate.choice("quantity", quantity, ("mean", "amplitude", "noise"))
        if quantity == "noise":
            template, numbers = replaced(require_noise("load", load), mean, amplitude, frequency)
            noisy = template.with_numbers(**numbers)
            tolerance = units.tolerance("growth_tolerance", 0.0 if growth_tolerance is None else growth_tolerance)
            validate.progress(progress)
            return self._modes_under(noisy).critical_noise(noisy, tolerance, progress)
        from floquetrod.rod.stable_loads import critical_load

        template, others = replaced(load, mean, amplitude, frequency, quantity)
        return critical_load(
            self._modes_under(template),
            quantity,
            others,
            SLOW_GROWTH if growth_tolerance is None else growth_tolerance,
            progress,
        )

    @_loads_hints
    def is_stable(
        self,
        load: AnyLoad | None = None,
        *,
        mean: Any = None,
        amplitude: Any = None,
        frequency: Any = None,
        growth_tolerance: float = 0.0,
        criterion: FiniteTimeCriterion | None = None,
        friction: float | None = None,
        kick: float | None = None,
        workers: int | None = None,
        progress: Progress | None = None,
    ) -> Any:
        """Return whether the rod is stable under a load, or under arrays of loads, in all modes that matter.

        Loads that cannot be decided are False, with an UndecidedWarning that counts them; `verdicts` shows which.

        Parameters
        ----------
        load : AxialLoad, AxialWave or ForceRecord, optional
            The template of all loads; by default a sine, uniform except for the weight along the rod.  Of a record
            the load fitted to it, without its noise, which only `stability` counts; it needs a quantity below.
        mean : array_like, optional
            Mean force in N or with a unit, in place of the load's own; without a load all three are needed.  Arrays of
            the three broadcast.
        amplitude : array_like, optional
            Amplitude in N or with a unit, likewise.
        frequency : array_like, optional
            Angular frequency in rad/s, or a frequency with a unit, likewise.
        growth_tolerance : float
            Growth rate in 1/s up to which a mode counts as stable.
        criterion : FiniteTimeCriterion, optional
            The paper's test in place of stability for all time.
        friction : float, optional
            Coefficient of friction with the wall, as in `stability`.
        kick : float or str, optional
            Transverse velocity in m/s or with a unit: whether it destabilises no mode.  It needs ``friction``.
        workers : int, optional
            Threads; by default one for each core when there is enough to do.
        progress : callable, optional
            Called repeatedly with the numbers of loads done and of all; an exception that it raises ends the work.

        Returns
        -------
        bool or ndarray
            In the shape that the quantities broadcast to.

        Raises
        ------
        TypeError, ValueError
            For numbers out of range, shapes that do not broadcast, and a quantity that neither the load nor an
            argument gives.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod, load = Rod.nitinol(), fr.AxialLoad(mean="0.34N", amplitude="0.34N", frequency="24Hz")
        >>> rod.is_stable(load)
        False
        >>> rod.is_stable(load, amplitude=["0.01N", "0.34N"], frequency=[["24Hz"], ["40Hz"]], growth_tolerance=0.01)
        array([[ True, False],
               [ True,  True]])
        >>> rod.is_stable(mean=0.34, amplitude=0.01, frequency="24Hz", growth_tolerance=0.01)
        True
        """
        codes = self.verdicts(
            load,
            mean=mean,
            amplitude=amplitude,
            frequency=frequency,
            growth_tolerance=growth_tolerance,
            criterion=criterion,
            friction=friction,
            kick=kick,
            workers=workers,
            progress=progress,
        )
        what = "loads could not be decided and count as not stable"
        return are("stable", codes, what, "Rod.verdicts shows which, Rod.stability of one says why")

    @_loads_hints
    def verdicts(
        self,
        load: AnyLoad | None = None,
        *,
        mean: Any = None,
        amplitude: Any = None,
        frequency: Any = None,
        growth_tolerance: float = 0.0,
        criterion: FiniteTimeCriterion | None = None,
        friction: float | None = None,
        kick: float | None = None,
        workers: int | None = None,
        progress: Progress | None = None,
    ) -> Any:
        """Return 1 where the rod is stable, 0 where it is not and -1 where that cannot be decided, as int8.

        Arguments as in `is_stable`.  Undecided are some kicks against friction, and coupled modes on a boundary.

        Returns
        -------
        int or ndarray of int8
            In the shape that the quantities broadcast to.

        Raises
        ------
        TypeError, ValueError
            As `is_stable`.

        Examples
        --------
        >>> Rod.nitinol().verdicts(mean=[0.2, 0.72], amplitude=1.187, frequency=150.0, friction=0.1, kick="50mm/s")
        array([1, 0], dtype=int8)
        """
        require_no_record(load, (mean, amplitude, frequency))
        template, loads, _ = replaced_loads(load, mean, amplitude, frequency)
        return verdicts.statuses(
            self._modes_under(template),
            loads,
            growth_tolerance,
            criterion,
            friction,
            kick,
            workers,
            progress,
        )

    @_loads_hints
    def growth_rate(
        self,
        load: AnyLoad | None = None,
        *,
        mean: Any = None,
        amplitude: Any = None,
        frequency: Any = None,
        return_mode: bool = False,
        workers: int | None = None,
        progress: Progress | None = None,
    ) -> Any:
        """Return the growth rate in 1/s of the fastest mode under a load, or under arrays of loads; 0 where stable.

        NaN where it cannot be computed: of coupled modes under loads far too slow or too strong for doubles.  Other
        arguments as in `is_stable`.

        Parameters
        ----------
        return_mode : bool
            Whether to return (growth, mode), with the number of the fastest mode: 0 where nothing grows, and -1 where
            modes are coupled, which `stability` names.

        Returns
        -------
        float or ndarray of float
            In 1/s, in the shape that the quantities broadcast to; with ``return_mode`` a pair, the second of int.

        Raises
        ------
        TypeError, ValueError
            As `is_stable`.

        Examples
        --------
        >>> rod = Rod.nitinol()
        >>> growth, mode = rod.growth_rate(mean=[0.34, 0.6], amplitude=0.34, frequency=150.0, return_mode=True)
        >>> growth.round(3), mode
        (array([4.241, 0.268]), array([ 7, 11]))
        """
        validate.progress(progress)
        validate.flag("return_mode", return_mode)
        require_no_record(load, (mean, amplitude, frequency))
        template, loads, _ = replaced_loads(load, mean, amplitude, frequency)
        growth, mode = self._modes_under(template).fastest(loads, workers, progress)
        return (shaped(growth, loads.shape), shaped(mode, loads.shape)) if return_mode else shaped(growth, loads.shape)

    # --- a rod that is not straight ---

    @_one_load_hints
    def response(self, load: AnyLoad, *, unstable: bool = False) -> RodResponse:
        """Return how much a stable rod with a ``natural_shape`` moves under a load: with the period of the load.

        Parameters
        ----------
        load : AxialLoad or AxialWave
        unstable : bool
            Whether to answer under a load that makes motion grow, beside which nobody sees this one.

        Returns
        -------
        RodResponse
            Largest deflection in m and angle in rad, where and when, bending moment and stress, contact force, and the
            deflection along the rod over a period, in harmonics of the load.  Of a random shape standard deviations.

        Raises
        ------
        ValueError
            For a straight rod, for loads under which it is unstable, on a resonance, with the distance of the nearest
            multiplier from 1, under noise, and for strings that need more than 250 coupled modes.

        Notes
        -----
        The shape is a constant force on each mode, E I k_m^4 a_m per length for the part a_m sin(k_m s), so that the
        motion grows without bound towards static buckling and towards tongues of even order, where a multiplier is 1,
        and crosses the principal tongue's edge unaffected (page `theory/response`).  Small angles; modes and coupling
        as in `stability`.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = fr.Rod.nitinol().replace(damping_rate=0.5, natural_shape={5: "0.1mm"})
        >>> rod.response(fr.AxialLoad(mean="0.3N", amplitude="0.3N", frequency=60.0))
        <moves by up to ...>
        """
        from floquetrod.rod import shape_response

        return shape_response.response(self._modes_under(require_load("load", load)), load, unstable)

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
        (page `theory/large_motion`), in the modes next to ``mode`` and modes three times as short.  They agree with
        the simulator, whose force travels in axial waves, within half a percent of the angle with clamped ends, and one
        percent with hinged ends.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = Rod.nitinol().replace(damping_rate=3.0, length=1.2)
        >>> load = fr.AxialLoad(mean=0.1 * rod.critical_force, amplitude=0.3 * rod.critical_force, frequency=110.0)
        >>> rod.steady_motion(load)
        <moves by 6.512 degrees in mode 2>
        """
        from floquetrod.rod import motion

        return motion.steady_motion(self._modes_under(require_load("load", load)), load, mode, indentation)

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
        returns the part found.

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
        In two modes, ``mode`` and the mode three times as short, in some ten seconds; "stable" is against deviations in
        these two.  Compared with all modes, angles are within half a percent up to half the angle at which the rod
        leaves its wall, and within three percent there, where the simulator's angle is between the two.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = Rod.nitinol().replace(damping_rate=3.0, length=1.2)
        >>> load = fr.AxialLoad(mean=0.1 * rod.critical_force, amplitude=0.3 * rod.critical_force, frequency=110.0)
        >>> rod.follow(load, over={"frequency": (108.0, 111.0)}, steps=2)
        <1 branch of motion in mode 2, up to 6.5... degrees>
        """
        from floquetrod.rod import motion_branches
        from floquetrod.rod.answers.rod_branches import RodBranches

        if isinstance(load, RodBranches):
            return motion_branches.resumed(self, load, over, (mode, all_modes), indentation, steps, longest, progress)
        model = self._modes_under(require_load("load", load))
        return motion_branches.branches(model, load, over, (mode, all_modes), indentation, steps, longest, progress)

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

        return kicked_motion.safe_kick(self._modes_under(require_load("load", load)), load, indentation)

    # --- proofs ---

    def certify(
        self,
        load: AnyLoad | None = None,
        *,
        mean: Any = None,
        amplitude: Any = None,
        frequency: Any = None,
        growth_tolerance: float = SLOW_GROWTH,
        rod: Mapping[str, Any] | None = None,
        max_boxes: int = MAX_BOXES,
        progress: Progress | None = None,
    ) -> RegionProof:
        """Prove every load of a box stable or unstable, on this rod or on every rod within tolerances.

        Interval arithmetic, rounded outwards, over boxes halved until they are decided; all modes, those
        beyond a number by a bound (page `theory/regions`).

        Parameters
        ----------
        load : AxialLoad, optional
            Gives the quantities left out below, and all other properties: ``AxialLoad(0.3, 0.3, 150.0,
            mean_at=None)`` neglects the weight along an inclined rod.  By default a sine, and all three are named.
        mean : float or (low, high), optional
            F_ave in N or with a unit: a number, or both ends of its range.
        amplitude : float or (low, high), optional
            dF in N or with a unit, 0 or more: a number, or both ends of its range.
        frequency : float or (low, high), optional
            omega in rad/s or with a unit, greater than 0: a number, or both ends of its range.
        growth_tolerance : float
            Growth rate in 1/s up to which a mode counts as stable.  Without damping no box of positive size can be
            proved stable with 0: thin tongues are everywhere.
        rod : mapping, optional
            Parameters of the rod that vary, by name, each a number or (low, high) in SI units:
            ``{"length": (3.05, 3.15)}``; diameters may be given in place of radii.
        max_boxes : int
            Parts of the box to examine before it is given up.
        progress : callable, optional
            Called with the number of parts examined and ``max_boxes``.

        Returns
        -------
        RegionProof
            "stable": under every load of the box, on every rod, no mode grows faster than the tolerance; "unstable":
            under every one some mode does; "mixed": with a proved example of each; "undecided": with the share of the
            box that was proved.

        Raises
        ------
        ValueError
            For a box whose ends do not increase, that reaches zero frequency, or that holds impossible rods; for
            coupled modes; for loads that need more than 20,000 modes.
        TypeError
            For anything that is not a number.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = Rod.nitinol().replace(damping_rate=0.5)
        >>> load = fr.AxialLoad(mean=0.577, amplitude=0.339, frequency=150.0)
        >>> rod.certify(load, mean=(0.56, 0.59), amplitude=("0.32N", "0.35N")).status
        'stable'
        >>> rod.certify(mean=(0.56, 0.59), amplitude=(0.32, 0.35), frequency=(149.0, 151.0)).status
        'stable'
        """
        template, numbers = replaced(load, mean, amplitude, frequency)
        sides = numbers["mean"], numbers["amplitude"], numbers["frequency"]
        return self._modes_under(template).certify(sides, growth_tolerance, rod, max_boxes, progress)

    def largest_safe_box(
        self,
        load: AnyLoad,
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
        load : AxialLoad
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

        Returns
        -------
        SafeBox
            ``ranges``, one for each quantity, and their ``proof``.

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

        load = require_load("load", load)
        judge = partial(self._modes_under(load).verdict, load, None)
        self._modes_under(load).require("largest_safe_box")
        return largest_safe_box(self, load, judge, vary, growth_tolerance, rod, accuracy, progress)
