"""The shape y_0(s) that a rod takes across its channel without load: what it is made of, and what it bends.

It acts like a force that does not move: bending stores E I (y'' - y_0'')^2 / 2 per length, so that motion in functions
phi_j of x = s / L is driven by int (E I / L^4) (d^2 y_0 / dx^2) phi_j'' dx.  What of it is straight drives nothing.

A random shape is y_0 = sum a_m sin(m pi s / L) with independent a_m of variance

    (2 / L) S(m pi / L),    S(k) = sqrt(2 pi) l sigma^2 exp(-k^2 l^2 / 2),

S the spectral density of deflection of the root mean square sigma whose correlation over a distance d is
exp(-d^2 / (2 l^2)): a stationary shape far from the ends of a rod much longer than l.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import error_in, wrong_type, wrong_value
from floquetrod._util.arrays import Floats

FORMS = (
    '{5: "0.1mm"} for sines of so many half waves, a list of deflections at equal distances from the upper to the '
    'lower end, {"curvature": "0.1rad/m", "direction": "90deg"} for a bend of the reel, or {"rms": "0.1mm", '
    '"correlation_length": "0.5m"} for a random shape'
)
"""The forms in which a shape may be given, as messages name them."""

_MOST_HALF_WAVES = 2000  # of a sine (a choice: as many as coupled modes)
_FEWEST_SAMPLES = 6  # of a deflection: a spline of the fifth degree goes through them
_MOST_RANDOM = 200  # sines of a random shape (a choice)


class Patterns(NamedTuple):
    """Shapes across the channel in m at places, (patterns, len(x)) each, and their derivatives by x = s / L.

    A random shape is a sum of patterns with independent factors of variance 1; another is one pattern.
    """

    deflection: Floats
    slope: Floats
    bend: Floats


@dataclass(frozen=True)
class NaturalShape:
    """The deflection y_0(s) of a rod without load, across the floor of its channel.

    Parameters
    ----------
    sines : tuple of (int, float)
        Number of half waves m and amplitude in m of each sin(m pi s / L).
    deflection : tuple of float
        In m, at equal distances from the upper to the lower end; a spline of the fifth degree lies between them.
    curvature : float
        Of a bend in one plane, as of tubing from its reel, in 1/m.
    direction : float
        Angle in rad of the plane of the bend from the vertical plane along the channel; pi/2 bends across the floor.
        What bends the rod up or down is not part of the motion across, and left out.
    rms : float
        Root mean square of a random deflection in m.
    correlation_length : float
        Distance in m over which its correlation falls to exp(-1/2).
    """

    sines: tuple[tuple[int, float], ...] = ()
    deflection: tuple[float, ...] = ()
    curvature: float = 0.0
    direction: float = 0.5 * math.pi
    rms: float = 0.0
    correlation_length: float = 0.0

    @classmethod
    def of(cls, given: Any) -> NaturalShape | None:
        """Return the shape that an argument describes, in one of `FORMS`; None for None.

        ValueError or TypeError, naming ``natural_shape``, for anything else.
        """
        if given is None or isinstance(given, cls):
            return given
        try:
            if isinstance(given, Mapping):
                return cls._of_mapping(dict(given))
            if isinstance(given, list | tuple | np.ndarray) and _is_flat(given):
                return cls(deflection=_deflections(given))
        except (TypeError, ValueError) as error:
            raise error_in("natural_shape", error) from None
        raise wrong_type("natural_shape", f"must be {FORMS}, got {validate.short(given)}")

    @classmethod
    def _of_mapping(cls, given: dict[Any, Any]) -> NaturalShape:
        """Return the shape that a mapping describes."""
        keys = {str(key) for key in given}
        if keys and keys <= {"deflection"}:
            return cls(deflection=_deflections(given["deflection"]))
        if "curvature" in keys and keys <= {"curvature", "direction"}:
            curvature = units.number("curvature", given["curvature"], "curvature", -1e3, 1e3, "give it in 1/m")
            angle = units.number(
                "direction", given.get("direction", 0.5 * math.pi), "angle", -math.tau, math.tau,
                'give it in rad, or as "90deg"'
            )  # fmt: skip
            if curvature == 0.0:
                raise wrong_value("curvature", "must not be 0; leave natural_shape out for a straight rod")
            return cls(curvature=curvature, direction=angle)
        if keys == {"rms", "correlation_length"}:
            sizes = [_length(name, given[name]) for name in ("rms", "correlation_length")]
            return cls(rms=sizes[0], correlation_length=sizes[1])
        if not keys or not all(key.strip().isdigit() for key in keys):
            raise wrong_value("keys", f"must be those of {FORMS}, got {validate.short(sorted(keys))}")
        sines = {}
        for key, value in given.items():
            number = int(str(key))
            if not 1 <= number <= _MOST_HALF_WAVES:
                raise wrong_value("half waves", f"must be from 1 to {_MOST_HALF_WAVES}, got {number}")
            sines[number] = units.number(f"the amplitude of {number} half waves", value, "length", hint="give it in m")
        return cls(sines=tuple(sorted(sines.items())))

    def as_dict(self) -> dict[Any, Any]:
        """Return the argument that makes an equal shape, in SI units."""
        if self.sines:
            return {str(number): amplitude for number, amplitude in self.sines}
        if self.deflection:
            return {"deflection": list(self.deflection)}
        if self.curvature:
            return {"curvature": self.curvature, "direction": self.direction}
        return {"rms": self.rms, "correlation_length": self.correlation_length}

    def in_words(self, shown: units.AnswerUnits) -> str:
        """Return what it is, in the units of an answer.

        >>> NaturalShape.of({5: "0.1mm"}).in_words(units.AnswerUnits.named())
        '0.1 mm sin(5 pi s / L)'
        """
        if self.sines:
            return " + ".join(f"{shown.across.show(a, 4)} sin({m} pi s / L)" for m, a in self.sines[:3]) + (
                f" + {len(self.sines) - 3} more" if len(self.sines) > 3 else ""
            )
        if self.deflection:
            largest = max(map(abs, self.deflection))
            return f"deflection at {len(self.deflection)} places, {shown.across.show(largest, 4)} at most"
        if self.curvature:
            radius, angle = shown.length.show(1.0 / abs(self.curvature), 4), math.degrees(self.direction)
            return f"bend of radius {radius}, {angle:.4g} deg from the vertical plane"
        rms, length = shown.across.show(self.rms, 4), shown.length.show(self.correlation_length, 4)
        return f"random with {rms} rms, correlated over {length}"

    def __str__(self) -> str:
        """Return what it is in SI units."""
        return self.in_words(units.AnswerUnits.named())

    @property
    def is_random(self) -> bool:
        """Whether only the statistics of the shape are known."""
        return self.rms > 0.0

    def patterns(self, x: Floats, length: float) -> Patterns:
        """Return the shape at places x = s / L of a rod of a length in m."""
        if self.sines or self.is_random:
            numbers, amplitudes = self._random(length) if self.is_random else np.array(self.sines).T
            k = numbers[:, None] * math.pi
            waves, slopes = amplitudes[:, None] * np.sin(k * x), amplitudes[:, None] * k * np.cos(k * x)
            every = waves, slopes, -(k**2) * waves
            if self.is_random:
                return Patterns(*every)
            return Patterns(*(each.sum(axis=0, keepdims=True) for each in every))
        if self.curvature:
            bend = self.curvature * math.sin(self.direction) * length**2
            return Patterns(*(each[None] for each in (0.5 * bend * x * (x - 1.0), bend * (x - 0.5), bend + 0.0 * x)))
        from scipy.interpolate import make_interp_spline

        curve = make_interp_spline(np.linspace(0.0, 1.0, len(self.deflection)), self.deflection, k=5)
        return Patterns(*(np.asarray(curve(x, nu))[None] for nu in range(3)))

    def highest(self, length: float) -> int:
        """Return the largest number of half waves of the sines it is made of, 1 of other shapes."""
        if self.is_random:
            return int(self._random(length)[0][-1])
        return self.sines[-1][0] if self.sines else 1

    def _random(self, length: float) -> tuple[Floats, Floats]:
        """Return numbers of half waves and standard deviations in m of the sines of a random shape."""
        # The density falls like exp(-(k l)^2 / 2): beyond k l = 4 it has 6e-5 of the variance.
        last = max(8, math.ceil(4.0 * length / (math.pi * self.correlation_length)))
        if last > _MOST_RANDOM:
            raise wrong_value(
                "natural_shape",
                f"has a correlation_length of {self.correlation_length:g} m on a rod of {length:g} m, which takes "
                f"{last} sines, more than {_MOST_RANDOM}; give a longer one",
            )
        numbers = np.arange(1.0, last + 1.0)
        k, correlated = numbers * math.pi / length, self.correlation_length
        density = math.sqrt(math.tau) * correlated * self.rms**2 * np.exp(-0.5 * (k * correlated) ** 2)
        return numbers, np.sqrt(2.0 * density / length)


def _is_flat(values: Any) -> bool:
    """Return whether the elements are no lists, without going through those that are."""
    return values.ndim == 1 if isinstance(values, np.ndarray) else not any(isinstance(v, list | tuple) for v in values)


def _length(name: str, value: Any) -> float:
    """Return a positive length in m."""
    return units.number(name, value, "length", math.ulp(0.0), hint="give it in m")


def _deflections(values: Any) -> tuple[float, ...]:
    """Return deflections in m, each given as a number or with its unit."""
    values = list(values)
    if len(values) < _FEWEST_SAMPLES:
        raise wrong_value("deflection", f"must have {_FEWEST_SAMPLES} values at least, got {len(values)}")
    return tuple(
        units.number(f"deflection[{i}]", value, "length", hint="give it in m") for i, value in enumerate(values)
    )
