"""Rods whose modes are coupled: known growth, beam numbers, and what finite differences need of a rod and a load."""

from __future__ import annotations

import functools
import math
from itertools import product
from typing import Any, NamedTuple

import floquetrod as fr
from tests import finite_differences as fd

WIRE = fr.Rod.nitinol()
FORCE = WIRE.critical_force
"""F_cr of the horizontal wire, the unit of its loads."""

TUBING = fr.Rod(
    207e9,
    7850.0,
    radius=25.4e-3,
    inner_radius=21.44e-3,
    length=60.0,
    channel_radius=62e-3,
    fluid_inside=1000.0,
    fluid_outside=1000.0,
    added_mass_coefficient=2.29,
)
ENDS = tuple(f"{upper}-{lower}" for upper, lower in product(("hinged", "clamped", "guided", "free"), repeat=2))


def solid_like(tube: fr.Rod) -> fr.Rod:
    """Return the solid rod without fluids that has the stiffness, inertia, weight and clearance of a tube."""
    radius = 0.02
    area, second = math.pi * radius**2, 0.25 * math.pi * radius**4
    return fr.Rod(
        tube.flexural_rigidity / second,
        tube.mass_per_length / area,
        radius,
        tube.length,
        radius + tube.radial_clearance,
        tube.weight_per_length / tube.mass_per_length,
        tube.damping_rate,
        inclination=tube.inclination,
        ends=tube.ends,
    )


class Known(NamedTuple):
    """A rod, a load and the growth rate in 1/s, known to half a unit of its last digit."""

    rod: fr.Rod
    load: Any
    growth: str

    @property
    def rate(self) -> float:
        """The growth rate in 1/s."""
        return float(self.growth)

    @property
    def slack(self) -> float:
        """Half a unit of the last digit."""
        return 0.5 * 10.0 ** -len(self.growth.partition(".")[2])


def known() -> dict[str, Known]:
    """Return growth rates by fourth-order Magnus integrators, converged in modes and steps to the digits given."""
    found = {}
    even = fr.AxialLoad(0.2 * FORCE, 0.2 * FORCE, 150.0)
    for degrees, weight, growth in ((90, 0.5, "4.2356815"), (75, 0.5, "4.0543558"), (60, 0.5, "2.816330")):
        rod = WIRE.replace(inclination=math.radians(degrees))
        found[f"wire at {degrees} degrees"] = Known(rod, fr.AxialLoad(*numbers(even), mean_at=weight), growth)
    light = fr.AxialLoad(*numbers(even), mean_at=None)
    found["wire at 60 degrees, even"] = Known(WIRE.replace(inclination=math.radians(60)), light, "2.827163")
    for mean, amplitude, frequency, growth in (
        (0.15, 0.40, 171.0, "6.7791456"),
        (0.60, 0.25, 133.0, "7.6875040"),
        (0.20, 0.20, 150.0, "4.2434927"),
    ):
        driven = fr.AxialWave(mean * FORCE, amplitude * FORCE, frequency, far_end="driven")
        found[f"wire driven at {frequency:g}"] = Known(WIRE, driven, growth)
    push = TUBING.critical_force
    tubing = {
        (60.0, 4.0): ("1.51964360", "1.32070245", "1.02622896"),
        # The last of these was first computed as 1.03344613; finite differences have 1.033446146 +- 5e-9.
        (120.0, 3.0): ("1.52839898", "1.32920967", "1.03344615"),
    }
    for (length, hertz), growths in tubing.items():
        tool = fr.AxialWave.hertz(0.5 * push, 0.3 * push, hertz, far_end="held")
        for damping, growth in zip((0.0, 0.2, 0.5), growths, strict=True):
            rod = TUBING.replace(length=length, damping_rate=damping)
            found[f"tubing of {length:g} m, c = {damping}"] = Known(rod, tool, growth)
    return found


def by_name(mean: Any, amplitude: Any, frequency: Any) -> dict[str, Any]:
    """Return the quantities of loads as arguments by name."""
    return {"mean": mean, "amplitude": amplitude, "frequency": frequency}


def numbers(load: Any) -> tuple[float, float, float]:
    """Return mean, amplitude and frequency of a load."""
    return load.mean, load.amplitude, load.frequency


def model(rod: fr.Rod, load: Any) -> fd.Model:
    """Return what finite differences need of a rod and a load, from their parameters alone."""
    line = fd.line(
        rod.youngs_modulus,
        rod.density,
        rod.radius,
        rod.inner_radius,
        rod.fluid_inside,
        rod.fluid_outside,
        rod.added_mass_coefficient,
        rod.gravity,
    )
    upper, _, lower = rod.ends.partition("-")
    at, slope = 0.5, 0.0
    if load.mean_at is not None and rod.inclination < math.pi / 2:
        at, slope = load.mean_at, line.weight * math.cos(rod.inclination)
    harmonics = (-1j,) if load.waveform == "sine" else load.waveform
    waves = []
    for k, h in enumerate(harmonics, start=1):
        if isinstance(load, fr.AxialLoad):
            waves.append(fd.even(load.amplitude * h))
        else:
            speed = math.sqrt(rod.youngs_modulus / rod.density)
            force, frequency = load.amplitude * h, k * load.frequency
            waves.append(fd.wave(force, frequency, rod.length, speed, load.axial_damping, load.far_end))
    return fd.Model(
        line.rigidity,
        line.inertia,
        line.weight * math.sin(rod.inclination) / (rod.channel_radius - rod.radius),
        rod.length,
        (upper, lower or upper),
        fd.leaning(load.mean, slope, at * rod.length),
        waves,
        load.frequency,
        rod.damping_rate,
    )


@functools.cache
def beam_wavenumbers(ends: str, count: int = 4) -> tuple[float, ...]:
    """Return the first k L > 0 of a free beam, from its characteristic equation.

    The two conditions at each end leave sin, cos, tan or a product of them and of their hyperbolic counterparts.
    """
    import mpmath as mp

    pair = frozenset(ends.split("-"))
    if pair in ({"clamped"}, {"free"}):
        return tuple(float(mp.findroot(lambda x: mp.cos(x) - mp.sech(x), (n + 0.5) * mp.pi)) for n in numbered(count))
    if pair == {"clamped", "free"}:
        starts = [1.875, *((n + 0.5) * mp.pi for n in range(1, count))]
        return tuple(float(mp.findroot(lambda x: mp.cos(x) + mp.sech(x), start)) for start in starts)
    if pair in ({"clamped", "hinged"}, {"hinged", "free"}):
        return tuple(float(mp.findroot(lambda x: mp.tan(x) - mp.tanh(x), (n + 0.25) * mp.pi)) for n in numbered(count))
    if pair in ({"clamped", "guided"}, {"guided", "free"}):
        return tuple(float(mp.findroot(lambda x: mp.tan(x) + mp.tanh(x), (n - 0.25) * mp.pi)) for n in numbered(count))
    shift = 0.5 if pair == {"hinged", "guided"} else 0.0
    return tuple((n - shift) * math.pi for n in numbered(count))


def numbered(count: int) -> range:
    """Return 1, 2, ... of so many modes."""
    return range(1, count + 1)


def rigid_motions(ends: str) -> int:
    """Return in how many ways a rod with these ends moves without bending."""
    pair = ends.split("-")
    shifts = set(pair) <= {"guided", "free"}
    turns = "free" in pair and set(pair) <= {"hinged", "free"}
    return shifts + turns


def buckling_load(ends: str) -> float:
    """Return the least compression, in EI / L^2, that buckles a rod free of its bed; 0 where it turns freely."""
    import mpmath as mp

    pair = frozenset(ends.split("-"))
    if "free" in pair and pair <= {"hinged", "free"}:
        return 0.0
    if pair == {"clamped", "hinged"}:
        return float(mp.findroot(lambda x: mp.sin(x) - x * mp.cos(x), 4.5)) ** 2
    if pair == {"clamped"}:
        return 4.0 * math.pi**2
    return 0.25 * math.pi**2 if pair in ({"clamped", "free"}, {"guided", "free"}, {"guided", "hinged"}) else math.pi**2
