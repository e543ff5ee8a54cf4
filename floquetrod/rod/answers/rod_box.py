"""A box of loads and of rods, checked as `Rod.certify` takes it, and as intervals of the constants of modes.

Kernels (`floquet/proof/kernels`) bisect the intervals and prove the parts.  The result is in
`floquet/proof/region_proof.py`, also for boxes of parameters, of Mathieu's equation or of any family, which
`floquet/proof/family_boxes.py` halves.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, NamedTuple

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.interchange import by_keys
from floquetrod._util.interval import PI, RealInterval
from floquetrod.floquet.proof.region_proof import ModeBox, Side, side_ends
from floquetrod.parameter import REQUIRED, require_known
from floquetrod.rod.loads.load import LOAD, QUANTITIES, Load, Quantity, load_number
from floquetrod.rod.mode_equations.coupling import coupling, refusal
from floquetrod.rod.model.constants import ModeConstants
from floquetrod.rod.model.data import RodData, require_free
from floquetrod.rod.model.parameters import DIAMETERS, GIVEN, ROD
from floquetrod.rod.model.possible_rod import require_known_to_verdicts
from floquetrod.units import Unit

_SINE_TERMS = 14  # of the series of the sine up to pi/2: what is left out is far below a unit of the last place


class RodExample(NamedTuple):
    """One load on one rod of a box, with its proof in words.

    Attributes
    ----------
    status : {"stable", "unstable"}
    load : AxialLoad
    rod : Rod
    statement : str
    """

    status: str
    load: Load
    rod: RodData
    statement: str

    def where(self, shown: Mapping[str, Unit], sides: Sequence[Side]) -> str:
        """Return the load in units, and the parameters of the rod among the ``sides`` of the box."""
        numbers = [f"{name} {shown[name].show(getattr(self.load, name))}" for name in QUANTITIES]
        sizes = [f"{s.name.replace('_', ' ')} {shown[s.name].show(getattr(self.rod, s.name))}" for s in sides]
        return ", ".join(numbers + sizes)

    def as_dict(self) -> dict[str, Any]:
        """Return it for JSON, units in the keys."""
        loads = "mean_N=load.mean amplitude_N=load.amplitude frequency_rad_per_s=load.frequency"
        return by_keys(self, f"status {loads} rod statement")


@dataclass(frozen=True)
class RodBox:
    """Every load of a box on every rod of another."""

    rod: RodData  # gives the parameters that do not vary
    template: Load  # gives everything of the loads but their numbers
    loads: Mapping[Quantity, RealInterval]  # mean force and amplitude in N, frequency in rad/s
    parameters: Mapping[str, RealInterval]  # parameters of the rod that were given, in SI units

    @classmethod
    def of(
        cls,
        rod: RodData,
        template: Load,
        mean: Any,
        amplitude: Any,
        frequency: Any,
        parameters: Mapping[str, Any] | None,
    ) -> RodBox:
        """Return the box that the arguments of `Rod.certify` describe; ValueError and TypeError where they do not."""
        given: dict[Quantity, Any] = {"mean": mean, "amplitude": amplitude, "frequency": frequency}
        loads = {name: _load_side(name, value) for name, value in given.items()}
        box = cls(rod, template.with_numbers(0.0, 0.0, 1.0), loads, _rod_sides(rod, parameters))
        for extreme_rod in box._extreme_rods():
            require_known(extreme_rod, ROD, "proofs")
            require_known_to_verdicts(extreme_rod)
            coupled_by = coupling(extreme_rod, box.template)
            if coupled_by:
                raise refusal("certify", coupled_by)
        return box

    @property
    def sides(self) -> tuple[Side, ...]:
        """The sides, loads first, in SI units."""
        of_loads = [Side(name, *_ends(self.loads[name]), LOAD[name].unit) for name in QUANTITIES]
        of_rods = [Side(name, *_ends(side), _unit(name)) for name, side in self.parameters.items()]
        return (*of_loads, *of_rods)

    @property
    def varied_parameters(self) -> tuple[str, ...]:
        """Names of the parameters of the rod that vary."""
        return tuple(name for name, side in self.parameters.items() if side.width > 0.0)

    def constants(self) -> ModeConstants:
        """Return intervals of what the mode equations need of the rods."""
        numbers = {name: RealInterval.of(value) for name, value in self.rod.parameters.items()} | dict(self.parameters)
        return ModeConstants.of(numbers, pi=PI, sin=_sine)

    def mode_box(self) -> ModeBox:
        """Return the ends of all numbers in the equations of the modes."""
        return ModeBox(
            *(_ends(each) for each in (*(self.loads[name] for name in QUANTITIES), *self.constants().equation))
        )

    def halves(self) -> tuple[RodBox, RodBox]:
        """Return both halves of the rods, of the parameter that widens what the modes depend on most."""
        name = max(self.varied_parameters, key=self._effect)
        low, high = (
            replace(self, parameters={**self.parameters, name: half}) for half in self.parameters[name].halves()
        )
        return low, high

    def _effect(self, name: str) -> float:
        """Return how far the numbers of the modes vary, relatively, with one parameter."""
        others = {n: RealInterval.of(side.middle) for n, side in self.parameters.items() if n != name}
        constants = replace(self, parameters={**self.parameters, **others}).constants()
        sizes = ((side.width, max(abs(side.low), abs(side.high))) for side in constants.equation)
        return float(sum(width / size for width, size in sizes if size > 0.0))

    def point(self, load: Load, rod: RodData) -> RodBox:
        """Return the box of one load on one of the rods."""
        return RodBox(rod, load, {name: RealInterval.of(getattr(load, name)) for name in QUANTITIES}, {})

    def middle_rod(self) -> RodData:
        """Return the rod in the middle of the box."""
        return self.rod.replace(**{name: side.middle for name, side in self.parameters.items()})

    def corner_rods(self) -> Iterator[RodData]:
        """Yield the rod in the middle, and those whose varied parameters are all low, or all high."""
        yield self.middle_rod()
        if self.varied_parameters:
            for end in ("low", "high"):
                yield self.rod.replace(**{name: getattr(side, end) for name, side in self.parameters.items()})

    def _extreme_rods(self) -> Iterator[RodData]:
        """Yield rods of the box that are the first to be impossible or unknown: floating, without room or wall, bent.

        Whichever parameters may differ from their defaults, the last rod differs in all of them.
        """
        ends = {name: {"low": side.low, "high": side.high} for name, side in self.parameters.items()}
        radii = [name for name in ("radius", "inner_radius") if name in ends]
        for chosen in product(("low", "high"), repeat=len(radii)):
            lightest = {"fluid_outside": "high"} | dict(zip(radii, chosen, strict=True))
            yield self.rod.replace(**{name: pair[lightest.get(name, "low")] for name, pair in ends.items()})
        heaviest = {"fluid_outside": "low"} | dict.fromkeys(radii, "low")
        yield self.rod.replace(**{name: pair[heaviest.get(name, "high")] for name, pair in ends.items()})
        yield self.rod.replace(**{name: _unusual(name, side) for name, side in self.parameters.items()})


def _unusual(name: str, side: RealInterval) -> float:
    """Return the end of a side that is farther from the default of its parameter."""
    default = ROD[name].default
    return side.high if default is REQUIRED else max(_ends(side), key=lambda end: abs(end - default))


def _load_side(name: Quantity, value: Any) -> RealInterval:
    """Return one side of a box of loads."""
    return RealInterval(*side_ends(name, value, lambda word, number: load_number(name, number, word)))


def _rod_sides(rod: RodData, given: Mapping[str, Any] | None) -> dict[str, RealInterval]:
    """Return the sides of a box of rods."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise validate.wrong_type(
            "rod", f'must be a mapping such as {{"length": (3.05, 3.15)}}, got {validate.short(given)}'
        )
    require_free(rod, given, "rod")
    sides: dict[str, RealInterval] = {}
    for word, value in given.items():
        name = DIAMETERS.get(word, word)
        if name not in rod.parameters:
            also = "; give inner_radius in place of it" if word == "wall_thickness" else ""
            also = "; the ends of a rod are not a number" if word == "ends" else also
            raise validate.wrong_value(
                "rod", f"must name parameters of a rod ({', '.join(rod.parameters)}), got {validate.short(word)}{also}"
            )
        if name in sides:
            raise validate.wrong_value("rod", f"must give {name} once, got it also as {word}")
        ends = side_ends(word, value, functools.partial(units.number, kind=GIVEN[word].kind))
        sides[name] = RealInterval(*(0.5 * end if word in DIAMETERS else end for end in ends))
    return sides


@functools.lru_cache(maxsize=64)
def _sine(angle: RealInterval) -> RealInterval:
    """Return an enclosure of the sine, which rises from 0 to pi/2."""
    low, high = (_sine_of(RealInterval.of(end)) for end in _ends(angle))
    return RealInterval(max(0.0, low.low), min(1.0, high.high))


def _sine_of(x: RealInterval) -> RealInterval:
    """Return the series of the sine; its terms alternate and, up to pi/2, fall, so that the next one is a bound."""
    term = total = x
    for n in range(1, _SINE_TERMS):
        term = term * x * x / float(2 * n * (2 * n + 1))
        total = total - term if n % 2 else total + term
    return total + RealInterval(-term.high, term.high)


def _ends(interval: RealInterval) -> tuple[float, float]:
    return interval.low, interval.high


def _unit(name: str) -> str:
    """Return the SI unit of a parameter of a rod."""
    return ROD[name].unit
