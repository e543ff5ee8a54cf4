"""The rod's data sheet: its parts, and what follows from them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import error_in
from floquetrod._util.arrays import shaped
from floquetrod._util.caching import cached_property
from floquetrod._util.calling import TellsAttributes, constructor_hints
from floquetrod.parameter import require_known
from floquetrod.rod.loads.axial import AxialResponse, axial_response
from floquetrod.rod.loads.axial_line import AxialLine, LinePiece
from floquetrod.rod.loads.load import AnyLoad, require_load
from floquetrod.rod.model import formulas
from floquetrod.rod.model.beam import EndConditions, wavenumbers
from floquetrod.rod.model.buckling import BucklingForce, buckling_forces, buckling_forces_in_a_bend
from floquetrod.rod.model.catalogue import pipe_in_a_hole
from floquetrod.rod.model.course import (
    Channel,
    Course,
    PathCourse,
    UniformCourse,
    course_of,
    critical_forces,
    critical_push,
)
from floquetrod.rod.model.cross_section import CrossSection, Fluids, Material
from floquetrod.rod.model.lock_up import LockUp
from floquetrod.rod.model.parameters import (
    INSTEAD,
    MEANT,
    NUMBERS,
    OF_A_LINE,
    OF_A_SECTION,
    ON_A_FLOOR,
    ROD,
    friction_coefficient,
    in_si,
    is_given,
    path_of,
    units_given,
    units_of_bores,
)
from floquetrod.rod.model.plausibility import warn_of_rod
from floquetrod.rod.model.possible_rod import FITS, require_possible
from floquetrod.rod.model.rod_file import read_rod
from floquetrod.rod.model.stress import Stress, stress

# Loaded by a rod of several sections, or one that is not straight, alone.
if TYPE_CHECKING:
    from floquetrod.rod.model.natural_shape import NaturalShape
    from floquetrod.rod.model.sections import Bore, Section
    from floquetrod.wells.path import WellPath

MOST_MODES = 20_000  # beyond it the unit of a length or a force is wrong (a choice)


@constructor_hints(**MEANT)
@dataclass(frozen=True, init=False, repr=False)
class RodData(units.InUnits, TellsAttributes):
    """Data sheet of an elastic rod or tube on the floor of a circular channel, straight or bent.

    Its parameters, in SI units, are described at `floquetrod.Rod`, which adds the verdicts.  Rods are typed, compared
    and stored by them; everything else is computed from the parts made of them, `material`, `section`, `fluids`,
    `channel` and `end_conditions`.

    Notes
    -----
    Eq. (1) of DOI 10.1115/1.4031710.  Force uniform along the rod, small angles.  Inertia is not weight: the fluid
    outside adds to inertia and takes from weight.  For a rod on a path that bends, ``inclination``, ``curvature`` and
    all quantities derived from them are taken where a constant push buckles the rod first.

    Examples
    --------
    >>> rod = RodData.nitinol()
    >>> round(rod.critical_force, 3), round(rod.critical_mode, 2)
    (1.696, 6.14)
    >>> rod.section
    CrossSection(radius=0.0008, inner_radius=0.0)
    """

    youngs_modulus: float
    density: float
    radius: float
    length: float
    channel_radius: float
    gravity: float = 9.81
    damping_rate: float = 0.0
    inner_radius: float = 0.0
    fluid_inside: float = 0.0
    fluid_outside: float = 0.0
    added_mass_coefficient: float = ON_A_FLOOR
    inclination: float = 0.5 * math.pi
    ends: str = "hinged"
    curvature: float = 0.0
    path: WellPath | None = None
    depth: float = 0.0
    residual_curvature: float = 0.0
    natural_shape: NaturalShape | None = None
    yield_strength: float | None = None
    sections: tuple[Section, ...] = ()
    bores: tuple[Bore, ...] = ()

    def __init__(
        self,
        youngs_modulus: float | str | None = None,
        density: float | str | None = None,
        radius: float | str | None = None,
        length: float | str | None = None,
        channel_radius: float | str | None = None,
        gravity: float | str = 9.81,
        damping_rate: float | str = 0.0,
        *,
        inner_radius: float | str | None = None,
        fluid_inside: float | str = 0.0,
        fluid_outside: float | str = 0.0,
        added_mass_coefficient: float | str = ON_A_FLOOR,
        inclination: float | str | None = None,
        ends: str = "hinged",
        curvature: float | str | None = None,
        path: WellPath | Mapping[str, Any] | None = None,
        depth: float | str = 0.0,
        residual_curvature: float | str = 0.0,
        natural_shape: NaturalShape | Mapping[Any, Any] | Sequence[float | str] | None = None,
        yield_strength: float | str | None = None,
        sections: Sequence[Section | Mapping[str, Any]] = (),
        bores: Sequence[tuple[float | str, float | str]] = (),
        diameter: float | str | None = None,
        inner_diameter: float | str | None = None,
        channel_diameter: float | str | None = None,
        wall_thickness: float | str | None = None,
        weight: float | str | None = None,
    ) -> None:
        """Check and clean the parameters."""
        given = dict(locals())  # every argument by its name, as in the records of `ROD`
        if is_given(sections) or is_given(bores):
            from floquetrod.rod.model.sections import at_the_upper_end

            given = at_the_upper_end(given)
        for name, number in in_si(given).items():
            object.__setattr__(self, name, number)
        object.__setattr__(self, "ends", str(EndConditions.of(ends)))
        object.__setattr__(self, "path", path_of(given, self.depth, self.length))
        if natural_shape is not None:
            from floquetrod.rod.model.natural_shape import NaturalShape

            natural_shape = NaturalShape.of(natural_shape)
        object.__setattr__(self, "natural_shape", natural_shape)
        object.__setattr__(self, "sections", given["sections"] or ())
        object.__setattr__(self, "bores", given["bores"] or ())
        inherited = (each.given_units for each in (*self.sections, *([self.path] if self.path else [])))
        self.given_in(units_given(given).or_else(units_of_bores(bores), *inherited))
        self._require_possible_parts()
        if self.path is not None:
            self._set_weakest_bend()
        warn_of_rod(self)

    def _require_possible_parts(self) -> None:
        """Raise ValueError where the rod is none; of several sections it names the first one that is not."""
        if not (self.sections or self.bores):
            require_possible(self.parameters)
            return
        shown = units.AnswerUnits.named(given=self.given_units)
        for part in self.uniform_parts:
            rod, named = part.rod, f"section {part.section + 1}" if self.sections else "the rod"
            if not FITS.holds(rod.parameters):
                hole, outer = (shown.across.show(2.0 * radius, 6) for radius in (rod.channel_radius, rod.radius))
                raise validate.wrong_value(
                    "bores" if self.bores else "channel_radius",
                    f"must leave room for every section, got a diameter of {hole} around {named} of {outer}, "
                    f"{shown.length.show(part.start, 6)} from the upper end; give a wider bore or a thinner section",
                )
            try:
                require_possible(rod.parameters)
            except ValueError as error:
                raise error_in(named, error) from None

    def _set_weakest_bend(self) -> None:
        """Set inclination and curvature to those where a push buckles the rod first."""
        course = self.course
        x, place = course.samples, course.sampled
        along = self.along(x)
        forces = critical_forces(place, along.rigidity, along.weight, along.clearance)
        weakest = int(np.argmin(forces))
        if not forces[weakest] > 0.0:
            raise validate.wrong_value(
                "path",
                f"must press the rod to a wall, and at {x[weakest] * self.length:.6g} m from its upper end, measured "
                f"depth {self.depth + x[weakest] * self.length:.6g} m, it is straight and vertical; choose depth and "
                "length off it",
            )
        sine = max(ROD["inclination"].least, float(place.sine[weakest]))
        inclination = float(course.inclination) if isinstance(course, UniformCourse) else math.asin(min(sine, 1.0))
        object.__setattr__(self, "inclination", inclination)
        object.__setattr__(self, "curvature", float(place.kappa_n[weakest]))
        object.__setattr__(self, "_least_force", float(forces[weakest]))
        object.__setattr__(self, "_weakest_at", float(x[weakest] * self.length))

    def __repr__(self) -> str:
        """Return the expression that makes this rod."""
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in self.as_dict().items())})"

    @classmethod
    def nitinol(cls) -> Self:
        """Return the reference rod: Nitinol, 3.1 m long, in a plastic pipe.

        The paper's text calls 9.4 mm the channel radius; its own critical force (1.70 N) and mode (6) hold only if that
        is the diameter, so the radius here is 4.7 mm.

        Returns
        -------
        Rod
            Without damping.
        """
        return cls(youngs_modulus=68e9, density=6500.0, radius=0.8e-3, length=3.1, channel_radius=4.7e-3)

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """Read a rod from a TOML file.

        Keys are the parameters of `floquetrod.Rod`, or diameters and a wall in place of radii; values are numbers in SI
        units, or strings with a unit such as "68GPa", "0.8mm", "2.375in" or "60deg".  With ``catalogue``, the name of a
        pipe, and ``bore`` they are the arguments of `catalogue`.

        Returns
        -------
        Rod
            The rod.

        Raises
        ------
        TypeError, ValueError
            For a file that cannot be read, and for keys that are missing, unknown or refused; the message names
            file and key.
        """
        return read_rod(path, cls)

    @classmethod
    def catalogue(cls, name: str, *, bore: float | str, length: float | str, **changes: Any) -> Self:
        """Return a steel pipe of the catalogue, `floquetrod.rod.model.catalogue.pipes`, in a hole.

        Parameters
        ----------
        name : str
            Outer diameter x wall thickness in inches, and a grade if wanted: "2.00x0.156 CT90".  The grade gives the
            yield strength, with which `stress` is compared; the rod stays linearly elastic.
        bore : float or str
            Inner diameter of the hole in m, or a string with a unit such as "4.778in".
        length : float or str
            Length in m, or a string with a unit such as "200ft".
        **changes
            Other parameters of a rod, which replace the pipe's; also with a unit.

        Returns
        -------
        Rod
            The pipe in the hole.

        Raises
        ------
        TypeError, ValueError
            For names outside the catalogue, and as `Rod`.

        Examples
        --------
        >>> pipe = RodData.catalogue("2.00x0.156 CT90", bore="4.778in", length="200ft", inclination="60deg")
        >>> round(pipe.flexural_rigidity), round(pipe.length, 2), round(pipe.yield_strength / 1e6)
        (33333, 60.96, 621)
        """
        return cls(**pipe_in_a_hole(name, bore, length, changes))

    def replace(self, **changes: Any) -> Self:
        """Return a copy with some parameters changed, also by ``diameter``, ``wall_thickness`` and so on.

        Returns
        -------
        Rod
            Of the same class.

        Raises
        ------
        TypeError, ValueError
            For a name that is no parameter, and as `Rod`.
        """
        replaced = {INSTEAD[name] for name in changes if name in INSTEAD}
        if changes.get("path") is not None:
            replaced |= set(OF_A_LINE)
        elif self.path is not None:
            replaced |= {*OF_A_LINE, *(("path", "depth") if set(OF_A_LINE) & changes.keys() else ())}
        if self.sections or changes.get("sections"):
            replaced |= set(OF_A_SECTION)
        if self.bores or changes.get("bores"):
            replaced |= {"channel_radius"}
        kept = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in replaced}
        changed = type(self)(**(kept | changes))
        return changed.given_in(changed.given_units.or_else(self.given_units))

    def as_dict(self) -> dict[str, Any]:
        """Return the data sheet that makes an equal rod: numbers in SI units and the word for its ends.

        Parameters of tubes, fluids, inclined channels and ends are left out where they have their defaults.

        Returns
        -------
        dict of str
            ``Rod(**sheet)`` is an equal rod.

        Examples
        --------
        >>> list(RodData.nitinol().replace(inner_radius=0.4e-3).as_dict())[-2:]
        ['damping_rate', 'inner_radius']
        """
        sheet: dict[str, Any] = {f.name: getattr(self, f.name) for f in fields(self)}
        usual = {f.name: f.default for f in fields(self) if f.name not in ("gravity", "damping_rate")}
        if self.path is not None:
            usual |= {"depth": None} | {name: sheet[name] for name in OF_A_LINE}
            sheet["path"] = self.path.as_dict()
        if self.sections:
            usual |= {name: sheet[name] for name in OF_A_SECTION}
            sheet["sections"] = [section.as_dict() for section in self.sections]
        if self.natural_shape is not None:
            sheet["natural_shape"] = self.natural_shape.as_dict()
        if self.bores:
            usual |= {"channel_radius": self.channel_radius}
            sheet["bores"] = [tuple(bore) for bore in self.bores]
        return {name: value for name, value in sheet.items() if value != usual.get(name, MISSING)}

    @property
    def parameters(self) -> dict[str, float]:
        """All numerical parameters, in SI units by name, without ends and path."""
        return {name: getattr(self, name) for name in NUMBERS}

    # --- along a rod of several sections, or in several bores ---

    @cached_property
    def uniform_parts(self) -> tuple[UniformPart, ...]:
        """The parts of the rod with one section in one bore each, from the upper end down; the rod itself if it is one.

        A part lies in a straight channel of the rod's inclination.
        """
        if not (self.sections or self.bores):
            return (UniformPart(0.0, self.length, 0, self),)
        from floquetrod.rod.model.sections import divided

        parts = []
        for start, end, number, diameter in divided(self.sections, self.bores, self.depth, self.length):
            own = self.sections[number] if self.sections else self
            changes = {name: getattr(own, name) for name in OF_A_SECTION} | {"length": end - start}
            changes |= {"channel_radius": 0.5 * diameter} if self.bores else {}
            parts.append(UniformPart(start, end, number, self._uniform(changes)))
        return tuple(parts)

    def in_cell(self, section: int, bore: int) -> RodData:
        """Return a section, numbered from the upper end, in a bore, numbered from the top, as a uniform rod."""
        own = self.sections[section] if self.sections else self
        changes = {name: getattr(own, name) for name in OF_A_SECTION}
        changes |= {"channel_radius": 0.5 * self.bores[bore].diameter} if self.bores else {}
        return self._uniform(changes)

    def _uniform(self, changes: Mapping[str, Any]) -> RodData:
        """Return a uniform rod with some parameters changed, which are not checked."""
        straight = {"path": None, "depth": 0.0, "sections": (), "bores": (), "natural_shape": None}
        part = object.__new__(type(self))
        for each in fields(RodData):
            value = straight[each.name] if each.name in straight else changes.get(each.name, getattr(self, each.name))
            object.__setattr__(part, each.name, value)
        return part.given_in(self.given_units)

    @property
    def varies(self) -> bool:
        """Whether sections or bores differ along the rod."""
        return bool(self.sections or self.bores) and len(self.uniform_parts) > 1

    @property
    def edges(self) -> tuple[float, ...]:
        """The places x = s / L, 0 and 1 included, between which the rod is uniform."""
        return (0.0, *(part.end / self.length for part in self.uniform_parts[:-1]), 1.0)

    def along(self, x: Any) -> PropertiesAlong:
        """Return what the mode equations need of the rod at places x = s / L, at an edge of the part below it.

        Returns
        -------
        PropertiesAlong
            An array of each property, in the shape of ``x``.

        Raises
        ------
        TypeError, ValueError
            For places other than finite numbers.
        """
        x = validate.array("x", x)
        index = np.searchsorted(self.edges[1:-1], x, side="right")
        every = [part.rod for part in self.uniform_parts]

        def column(name: str) -> NDArray[np.float64]:
            return np.asarray(np.array([getattr(rod, name) for rod in every])[index])

        return PropertiesAlong(
            column("flexural_rigidity"),
            column("mass_per_length"),
            column("weight_per_length"),
            column("radial_clearance"),
            column("youngs_modulus") * column("radius"),
        )

    def _require_uniform(self, name: str) -> None:
        """Raise ValueError for a number that differs along the rod."""
        if self.varies:
            raise validate.wrong_value(
                name,
                f"differs along a rod of {len(self.uniform_parts)} parts; ask one of them, uniform_parts[0].rod, say",
            )

    def _mean_along(self, name: str) -> float:
        """Return the mean along the rod of a number of its parts."""
        return float(
            sum((part.end - part.start) * getattr(part.rod, name) for part in self.uniform_parts) / self.length
        )

    # --- parts ---

    @cached_property
    def material(self) -> Material:
        """Young's modulus and density."""
        self._require_uniform("material")
        return Material(self.youngs_modulus, self.density)

    @cached_property
    def section(self) -> CrossSection:
        """Radii, areas and second moment."""
        self._require_uniform("section")
        return CrossSection(self.radius, self.inner_radius)

    @cached_property
    def fluids(self) -> Fluids:
        """Densities inside and outside, and how much of the outer fluid moves with the rod."""
        return Fluids(self.fluid_inside, self.fluid_outside, self.added_mass_coefficient)

    @cached_property
    def channel(self) -> Channel:
        """Inner radius, inclination, and gravity across it."""
        return Channel(self.channel_radius, self.gravity, self.inclination)

    @cached_property
    def course(self) -> Course:
        """The channel along the rod."""
        edges = self.edges[1:-1] if self.varies else ()
        return course_of(self.inclination, self.curvature, self.path, self.depth, self.length, edges)

    @cached_property
    def end_conditions(self) -> EndConditions:
        """How the ends are held."""
        return EndConditions.of(self.ends)

    # --- what follows from them ---

    @property
    def area(self) -> float:
        """Area of the material of the section in m^2."""
        return self.section.area

    @property
    def second_moment(self) -> float:
        """Second moment of the section, I, in m^4."""
        return self.section.second_moment

    @property
    def flexural_rigidity(self) -> float:
        """E I in N m^2."""
        return self.youngs_modulus * self.second_moment

    @property
    def axial_rigidity(self) -> float:
        """E A_s in N."""
        return self.youngs_modulus * self.area

    @property
    def mass_along(self) -> float:
        """Inertia rho A_s in kg/m of motion along the channel, of the material alone; of several sections the mean."""
        if self.varies:
            return self._mean_along("mass_along")
        return self.density * self.area

    @property
    def mass_per_length(self) -> float:
        """Inertia m_t = rho A_s + rho_i A_i + C_a rho_o A_o in kg/m, of material, fluid inside and added mass.

        Of several sections the mean along the rod.
        """
        if self.varies:
            return self._mean_along("mass_per_length")
        fluids = self.fluids
        outer = self.section.outer_area
        return float(formulas.inertia(self._own_mass, fluids.outside, fluids.added_mass_coefficient, outer))

    @property
    def weight_per_length(self) -> float:
        """Weight in fluid w_e = g (rho A_s + rho_i A_i - rho_o A_o) in N/m; of several sections the mean."""
        if self.varies:
            return self._mean_along("weight_per_length")
        return self.gravity * self._weighing

    @property
    def weight_along(self) -> float:
        """Weight in fluid along the channel, w_e cos(inclination) in N/m, by which compression grows downwards.

        On a path that bends, and of several sections, its mean along the rod.
        """
        if isinstance(self.course, PathCourse):
            return self.weight_per_length * self.course.fall / self.length
        if self.varies:
            return self._mean_along("weight_along")
        return self.channel.gravity_along * self._weighing

    @property
    def effective_gravity(self) -> float:
        """Weight across the channel over inertia, w_e sin(inclination) / m_t, in m/s^2."""
        return float(formulas.effective_gravity(self.channel.gravity_across, self._weighing / self.mass_per_length))

    @property
    def _own_mass(self) -> float:
        """Mass of the material and of the fluid inside, in kg/m."""
        bore = self.section.inner_area
        return float(formulas.own_mass(self.material.density, self.fluids.inside, self.area, bore))

    @property
    def _weighing(self) -> float:
        """Own mass less the mass of the fluid displaced, in kg/m."""
        return float(formulas.weighing_mass(self._own_mass, self.fluids.outside, self.section.outer_area))

    @property
    def radial_clearance(self) -> float:
        """R = channel radius - rod radius in m, the radius of the motion of the rod's axis."""
        self._require_uniform("radial_clearance")
        return float(formulas.clearance(self.radius, self.channel_radius))

    @property
    def pendulum_frequency(self) -> float:
        """Frequency sqrt(w_e sin(inclination) / (R m_t)) in rad/s at which a rigid rod swings in the channel.

        Of several sections the lowest.
        """
        if self.varies:
            return min(part.rod.pendulum_frequency for part in self.uniform_parts)
        masses = formulas.Masses(self.mass_per_length, self._weighing / self.mass_per_length)
        return math.sqrt(formulas.restoring(self.parameters, masses))

    @property
    def critical_force(self) -> float:
        """F_cr = 2 sqrt(E I w_e sin(inclination) / R) in N; a constant push beyond it buckles a long rod.

        In a channel that bends 2 E I (k + sqrt(k^2 + q / (E I))), k = curvature / R, q = w_e sin(inclination) / R,
        which solves F^2 = 4 E I (q + F k) (He & Kyllingstad 1995); along a path, and of several sections, the smallest
        along the rod.
        """
        self._require_known_to_force()
        if self.varies and self.path is None:
            return min(part.rod.critical_force for part in self.uniform_parts)
        if self.path is not None:
            return float(self._least_force)  # type: ignore[attr-defined]
        across = math.sqrt(self.flexural_rigidity * self.mass_per_length) * self.pendulum_frequency
        return float(critical_push(np.asarray(self._bend), np.asarray(across))) if self.curvature else 2.0 * across

    @property
    def weakest_at(self) -> float:
        """Where a constant push of `critical_force` buckles the rod first, in m from its upper end.

        Of several sections the upper end of the part that is weakest; 0 of a uniform rod in a uniform channel.
        """
        self._require_known_to_force()
        if self.path is not None:
            return float(self._weakest_at)  # type: ignore[attr-defined]
        return min(self.uniform_parts, key=lambda part: part.rod.critical_force).start

    @property
    def force_unit(self) -> float | None:
        """The critical force in N, by which forces may be given; None where it would ignore a parameter of the rod."""
        try:
            return self.critical_force
        except ValueError:
            return None

    def _require_known_to_force(self) -> None:
        """Raise ValueError where the critical force would ignore a parameter."""
        require_known(self, ROD, "critical force")
        if not self.course.is_straight:
            require_known(self, ROD, "bends")

    @property
    def _bend(self) -> float:
        """E I k in N, k = curvature / R."""
        return self.flexural_rigidity * self.curvature / self.radial_clearance

    @property
    def critical_mode(self) -> float:
        """m_cr = [w_e sin(inclination) L^4 / (pi^4 R E I)]^(1/4), the mode (not rounded) that F_cr buckles.

        In a channel that bends F_cr = 2 E I (pi m_cr / L)^2 all the same.  Of several sections the sum of the half
        waves of each, as if it were long.
        """
        self._require_known_to_force()
        if self.varies:
            return sum(part.rod.critical_mode for part in self.uniform_parts)
        if self.curvature or self.path is not None:
            return self.length / math.pi * math.sqrt(0.5 * self.critical_force / self.flexural_rigidity)
        stiffness = self.flexural_rigidity / self.mass_per_length
        return self.length / math.pi * math.sqrt(self.pendulum_frequency / math.sqrt(stiffness))

    @property
    def critical_half_wave(self) -> float:
        """L / m_cr in m, in a straight channel pi [E I R / (w_e sin(inclination))]^(1/4)."""
        return self.length / self.critical_mode

    @property
    def critical_forces(self) -> dict[str, BucklingForce]:
        """Constant forces at which the rod buckles, by every criterion known here, each with its source.

        From the literature, for long rods without vibration; the first is `critical_force`.

        Examples
        --------
        >>> for name, (force, _, source) in RodData.nitinol().critical_forces.items():
        ...     print(f"{name:16} {force:.3f} N  {source}")
        sinusoidal       1.696 N  Dawson & Paslay 1984
        helical, energy  2.399 N  Chen, Lin & Cheatham 1990
        helical, loading 3.104 N  Wu & Juvkam-Wold 1993
        helical, alone   4.797 N  Mitchell 1996
        vertical         0.138 N  Lubinski 1950
        """
        require_known(self, ROD, "helix")
        straight = buckling_forces(self.critical_force, self.flexural_rigidity, self.weight_per_length)
        if not self.curvature and self.path is None:
            return straight
        return buckling_forces_in_a_bend(straight, self._force_at)

    def _force_at(self, ratio: float) -> float:
        """Return the least force in N with F^2 = 4 ratio E I N(F) / R along the rod."""
        place = self.course.sampled
        rigidity = ratio * self.flexural_rigidity
        return float(critical_forces(place, rigidity, self.weight_per_length, self.radial_clearance).min())

    def lock_up(self, friction: float, far_force: float = 0.0) -> LockUp:
        """Return how far a string of this section, of any length, can be pushed down the channel from its upper end.

        ``friction`` is its coefficient along the channel, and ``far_force`` the effective compression at the lower end
        in N, negative for a pull.

        Returns
        -------
        LockUp
            Its ``length`` in m is infinite where the weight carries the string.

        Raises
        ------
        TypeError, ValueError
            For friction that is negative, a force that is not finite, and in a channel that bends.

        Examples
        --------
        >>> RodData.nitinol().lock_up(friction=0.2)
        <locks up 103.9 m from the far end with friction 0.2>
        """
        require_known(self, ROD, "helix")
        friction = friction_coefficient(friction)
        if not self.course.is_straight:
            raise validate.wrong_value(
                "friction",
                "is for a straight channel, and this one bends, where the closed form of lock-up does not hold; "
                "give the rod an inclination and no curvature",
            )
        across = self.channel.gravity_across * self._weighing
        found = LockUp(friction, far_force, self.critical_force, across, self.weight_along)
        return found.given_in(units.GivenUnits.of(force=far_force).or_else(self.given_units))

    @property
    def wave_speed(self) -> float:
        """Speed of axial waves, sqrt(E / rho), in m/s; of several sections the length over the time of travel."""
        return self.axial_line.wave_speed

    @cached_property
    def axial_line(self) -> AxialLine:
        """Length, speed of axial waves and impedance A sqrt(E rho) of each section, by which waves travel along it."""
        own = self.sections or (self,)
        return AxialLine(
            tuple(
                LinePiece(each.length, speed, each.density * CrossSection(each.radius, each.inner_radius).area * speed)
                for each in own
                for speed in [Material(each.youngs_modulus, each.density).wave_speed]
            )
        )

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
            held, sin(omega L / c_0) = 0 free, cos(omega L / (2 c_0)) = 0 driven; of several sections, where waves are
            reflected, by continuity of force and velocity, and ``section`` is the number of that at ``position``.
            The force of an `AxialLoad` is uniform and has none.

        Raises
        ------
        TypeError, ValueError
            For anything but a load.

        Examples
        --------
        >>> import floquetrod as fr
        >>> tubing = RodData.catalogue("2.00x0.156 CT90", bore="4.778in", length=600.0)
        >>> response = tubing.axial_response(fr.AxialWave(0.0, "2kN", "15Hz"))
        >>> round(response.factor, 1), [round(r.hertz, 2) for r in response.resonances]
        (60.3, [14.98, 19.26])
        """
        load = require_load("load", load)
        response = axial_response(load, self.axial_line, self.critical_force)
        return replace(response, section=_section_number(self, response.position))

    def stress(self, load: AnyLoad) -> Stress:
        """Return the largest stress along the rod under a load, axial and of bending with the channel, in Pa.

        The bending of a rod with a natural shape is part of its `response`.

        Parameters
        ----------
        load : AxialLoad, AxialWave or ForceRecord

        Returns
        -------
        Stress
            Its ``largest`` in Pa at ``position`` in m, and ``share_of_yield``.  Before the rod moves: growth or
            buckling bends it further.  Pressures inside and outside are taken as equal.

        Raises
        ------
        TypeError, ValueError
            For anything but a load.
        """
        require_known(self, ROD, "stress")
        return stress(self, require_load("load", load))

    def natural_frequency(self, mode: Any) -> Any:
        """Return the frequency in rad/s of free motion in a mode, without axial force or damping.

        Returns
        -------
        float or ndarray
            In rad/s, in the shape of ``mode``.

        Raises
        ------
        TypeError, ValueError
            For negative modes, and with ends other than hinged for all but whole numbers from 1; of a rod that varies
            along.
        """
        self._require_uniform("natural_frequency")
        bending = self.flexural_rigidity / self.mass_per_length * wavenumber(self, mode) ** 4
        return (bending + self.pendulum_frequency**2) ** 0.5


class UniformPart(NamedTuple):
    """A part of a rod with one section in one bore, from ``start`` to ``end`` in m from the rod's upper end."""

    start: float
    end: float
    section: int
    """Number of its section from the upper end, from 0."""
    rod: RodData
    """The part alone."""


class PropertiesAlong(NamedTuple):
    """What the mode equations need of a rod at some places."""

    rigidity: NDArray[np.float64]  # E I in N m^2
    inertia: NDArray[np.float64]  # m_t in kg/m
    weight: NDArray[np.float64]  # w_e in N/m
    clearance: NDArray[np.float64]  # R in m
    fibre: NDArray[np.float64]  # E r_o in N/m, the stress of the outer fibre over curvature


def _section_number(rod: RodData, s: float) -> int | None:
    """Return the number of the section at a place in m from the upper end, from 0; None where there is but one."""
    if not rod.sections or math.isnan(s):
        return None
    ends = np.cumsum([section.length for section in rod.sections[:-1]])
    return int(np.searchsorted(ends, s, side="right"))


def wavenumber(rod: RodData, mode: Any) -> Any:
    """Return the wavenumber in 1/m of free motion in a mode without axial force: m pi / L where ends are hinged.

    With other ends modes are whole numbers from 1 on, rigid motions, whose wavenumber is 0, before all others;
    ValueError for any other number.
    """
    rod._require_uniform("mode")
    modes = _modes(mode)
    if rod.end_conditions.are_hinged:
        return shaped(modes * formulas.first_wavenumber(rod.length), modes.shape)
    wrong = (modes < 1.0) | (modes != np.floor(modes))
    if wrong.any():
        raise validate.wrong_value(
            "mode",
            f"must be a whole number from 1 on for a rod with {rod.ends} ends, got {modes[wrong][0]:g}; "
            "modes in between have a wavenumber with hinged ends only",
        )
    chosen = modes.astype(np.int64)
    waves = wavenumbers(rod.end_conditions, int(chosen.max(initial=1))) / rod.length
    return shaped(waves[chosen - 1], modes.shape)


def _modes(mode: Any) -> NDArray[np.float64]:
    return validate.array("mode", mode, least=0.0, largest=10.0 * MOST_MODES)


def require_free(rod: RodData, names: Iterable[str], argument: str) -> None:
    """Raise ValueError where a parameter to vary is determined by the rod's path, or given section by section."""
    names = list(names)
    from_path = next((name for name in names if name in OF_A_LINE), None)
    if rod.path is not None and from_path is not None:
        raise validate.wrong_value(
            argument,
            f"must not name {from_path} of a rod on a path, which determines it; give an inclination instead",
        )
    for table, own in (("sections", OF_A_SECTION), ("bores", ("channel_radius",))):
        name = next((name for name in names if name in own), None)
        if getattr(rod, table) and name is not None:
            raise validate.wrong_value(
                argument,
                f"must not name {name} of a rod of several {table}, each of which has its own; what may vary is the "
                "load, and what the whole rod has, such as fluids and damping",
            )
