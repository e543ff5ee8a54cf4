"""Boxes of the parameters of a family of equations or systems, proved stable or unstable.

The coefficients are affine in each parameter, so that over a box they lie between their values at its corners.  Every
system within these bounds is proved at once, in balls; a box that cannot be decided is halved across the side along
which its coefficients vary most.
"""

from __future__ import annotations

import heapq
import itertools
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod.equations import Equation, HillSystem, PeriodicSystem
from floquetrod.equations.complex_form import real_forms
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.problems import Problem, member, require_problem, require_without_delays
from floquetrod.floquet.proof.matrices_alone import norm_kept
from floquetrod.floquet.proof.proof import Proof
from floquetrod.floquet.proof.region_equation import concluded
from floquetrod.floquet.proof.region_proof import RegionProof, Shares, Side, side_ends
from floquetrod.floquet.proof.system_numbers import NotAffine, bounds_of, require_affine, system_problem
from floquetrod.floquet.proof.systems import status_of_all
from floquetrod.floquet.registry import proof_sources
from floquetrod.floquet.verdict import Status

_MOST_SIDES = 6  # 64 corners (a choice)
_CHECKED = 5  # points within the box at which the coefficients are checked (a choice)
_NARROWEST = 1e-12  # of a side, relative: below it halving shows rounding (a choice)

Point = dict[str, Any]
Box = dict[str, tuple[float, float]]

_ASSUMED = (
    "the coefficients are affine in each parameter over the box, which was checked at some points, and the family "
    "computes them to within eight units of rounding",
)


class _Family(NamedTuple):
    """A function that returns an equation, and its fixed arguments; the sides of the box are the others."""

    make: Callable[..., Any]
    given: Mapping[str, Any]

    def at(self, point: Mapping[str, float]) -> Problem:
        """Return the equation of a point of the box."""
        problem = member(self.make, {**self.given, **point}, argument="equation")
        require_problem(problem)
        require_without_delays(problem, "a proof over a box")
        return problem

    def system(self, point: Mapping[str, float]) -> HillSystem | PeriodicSystem:
        """Return the same as a system."""
        problem: Any = self.at(point)
        return problem.as_system() if isinstance(problem, Equation) else problem

    def corners(self, box: Box) -> list[HillSystem | PeriodicSystem]:
        """Return the systems at the corners of a box; where one is complex, their real forms."""
        return real_forms([self.system(point) for point in corners(box)])


def corners(box: Box) -> Iterator[dict[str, float]]:
    """Return the corners of a box, each once."""
    for ends in itertools.product(*(dict.fromkeys(side) for side in box.values())):
        yield dict(zip(box, ends, strict=True))


def certify_family(
    family: Callable[..., Any],
    sides: Mapping[str, Any],
    given: Mapping[str, Any],
    max_boxes: int,
    seconds: float,
    prove: Callable[[Problem], Proof],
) -> RegionProof | Proof:
    """Return the proof for all equations of a family in a box; for one equation where there are no ``sides``.

    ``given`` are the parameters that do not vary; ``prove`` proves one equation.
    """
    box: Box = {name: side_ends(name, value, validate.finite) for name, value in sides.items()}
    if len(box) > _MOST_SIDES:
        raise ValueError(f"{', '.join(box)} must be at most {_MOST_SIDES} ranges, got {len(box)}")
    made = _Family(family, given)
    if not box:
        return prove(made.at({}))
    _require_affine(made, box)
    return _Subdivision(made, box, prove).result(max_boxes, time.monotonic() + seconds)


def _require_affine(family: _Family, box: Box) -> None:
    """Raise ValueError where the coefficients are seen not to be affine in each parameter."""
    systems = {tuple(point.values()): family.system(point) for point in corners(box)}
    rng = np.random.default_rng(1)
    for share in [np.full(len(box), 0.5), *rng.uniform(0.0, 1.0, (_CHECKED - 1, len(box)))]:
        point = {n: low + s * (high - low) for s, (n, (low, high)) in zip(share.tolist(), box.items(), strict=True)}
        weights = {key: _weight(key, point, box) for key in systems}
        try:
            inner, *outer = real_forms([family.system(point), *systems.values()])
            require_affine(inner, [(weights[key], system) for key, system in zip(systems, outer, strict=True)])
        except NotAffine as reason:
            where = ", ".join(f"{name} = {value:.6g}" for name, value in point.items())
            raise ValueError(
                f"equation must be a family whose coefficients are affine in each parameter over the box, got {reason} "
                f"at {where}; take parameters in which they are, such as the square of a frequency"
            ) from None


def _weight(corner: tuple[float, ...], point: Mapping[str, float], box: Box) -> float:
    """Return the weight of a corner in the multilinear interpolation at a point."""
    weight = 1.0
    for end, (name, (low, high)) in zip(corner, box.items(), strict=True):
        share = (point[name] - low) / (high - low) if high > low else 0.0
        weight *= share if end == high and high > low else 1.0 - share
    return weight


class _Subdivision:
    """The subdivision of a box."""

    def __init__(self, family: _Family, box: Box, prove: Callable[[Problem], Proof]) -> None:
        """Take the family, the box, and what proves one equation."""
        self.family, self.box, self.prove = family, box, prove
        self.number = itertools.count()
        self.open: list[tuple[float, int, Box]] = [(-1.0, next(self.number), box)]
        self.share = {"stable": 0.0, "unstable": 0.0}
        self.example: dict[str, Proof] = {}
        self.examined, self.too_narrow = 0, False

    def result(self, max_boxes: int, deadline: float) -> RegionProof:
        """Halve the box until it is decided, or the work allowed is done."""
        while self.open and self.examined < max_boxes and time.monotonic() < deadline and len(self.example) < 2:
            self._examine()
        return concluded(
            self.family.make,
            tuple(Side(name, *ends, "") for name, ends in self.box.items()),
            Shares(self.share["stable"], self.share["unstable"]),
            self.examined,
            self.example.values(),
            finished=not self.open and not self.too_narrow and len(self.example) < 2,
            tolerance=0.0,
            unit="per unit of time",
            assumptions=_ASSUMED,
            sources=proof_sources(self.family.at(next(corners(self.box)))),
        )

    def _examine(self) -> None:
        """Prove the largest part that is open, or halve it; its middle may be an example."""
        negative, _, part = heapq.heappop(self.open)
        self.examined += 1
        middle = {name: 0.5 * (low + high) for name, (low, high) in part.items()}
        verdict = stability(self.family.system(middle))
        if verdict.status != "undecided" and verdict.status not in self.example:
            proof = self.prove(self.family.at(middle))
            if proof.status == verdict.status:
                self.example[proof.status] = proof
                if len(self.example) == 2:
                    return
        outer = self.family.corners(part)
        if all(norm_kept(system) for system in outer):  # and, since they are affine, by all systems between them
            status: Status | None = "stable"
        else:
            multipliers = np.array([mu for mu in verdict.multipliers if mu == mu])
            status = status_of_all(system_problem(*outer), multipliers)
        if status is not None:
            self.share[status] -= negative
            return
        name = self._widest(part)
        if name is None:
            self.too_narrow = True
            return
        (low, high), cut = part[name], middle[name]
        for ends in ((low, cut), (cut, high)):
            heapq.heappush(self.open, (0.5 * negative, next(self.number), part | {name: ends}))

    def _widest(self, part: Box) -> str | None:
        """Return the side along which the coefficients vary most, None where all are too narrow to be halved."""
        wide = [
            name
            for name, (low, high) in part.items()
            if high - low > _NARROWEST * max(abs(self.box[name][0]), abs(self.box[name][1]), abs(high))
        ]
        middle = {name: (0.5 * (low + high),) * 2 for name, (low, high) in part.items()}
        change = {name: bounds_of(self.family.corners(middle | {name: part[name]})).spread for name in wide}
        return max(wide, key=lambda name: change[name], default=None) if any(change.values()) else None
