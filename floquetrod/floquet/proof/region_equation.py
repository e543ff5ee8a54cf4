"""Boxes of parameters of Mathieu's equation, proved stable or unstable."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import fields, replace
from fractions import Fraction
from typing import Any, NamedTuple

from floquetrod._util import validate
from floquetrod._util.interval import RealInterval
from floquetrod.equations import Mathieu
from floquetrod.floquet.problems import KINDS
from floquetrod.floquet.proof.exact_equation import Parameters, exact_number
from floquetrod.floquet.proof.proof import Proof
from floquetrod.floquet.proof.region_proof import ModeBox, RegionProof, RegionStatus, Shares, Side, side_ends, subdivide

_NAMES = ("alpha", "beta", "damping")


class ExactSides(NamedTuple):
    """Exact ends of the parameters of A'' + 2 c A' = (beta + alpha sin tau) A."""

    alpha: tuple[Fraction, Fraction]
    beta: tuple[Fraction, Fraction]
    damping: tuple[Fraction, Fraction]


def certify_box(
    parameters: dict[str, Any], tolerance: float, max_boxes: int, prove: Callable[[Parameters], Proof]
) -> RegionProof:
    """Return the proof for Mathieu's equation over a box of its parameters.

    ``prove`` proves one equation, by its exact parameters.
    """
    sides = _sides(parameters)
    alpha, beta, damping = (RealInterval.hull(ends) for ends in sides)
    # A mode of a rod with c1 = Omega^2 = m_0 = 0, c2 = 1 and omega = 1; the sign of alpha only shifts time.
    unit, none = RealInterval.of(1.0), RealInterval.of(0.0)
    numbers = (beta, abs(alpha), unit, none, unit, none, none, damping)
    box = ModeBox(*((side.low, side.high) for side in numbers))
    searched = subdivide(box, 1, tolerance, max_boxes)
    parts = (("stable", searched.stable_box), ("unstable", searched.unstable_box))
    return concluded(
        Mathieu,
        tuple(Side(name, float(low), float(high), "") for name, (low, high) in zip(_NAMES, sides, strict=True)),
        searched.shares,
        searched.boxes,
        (_example(sides, wanted, part, tolerance, prove) for wanted, part in parts if part is not None),
        finished=searched.finished,
        tolerance=tolerance,
        unit="per tau",
        assumptions=(),
    )


def concluded(
    subject: Any,
    box: tuple[Side, ...],
    shares: Shares,
    boxes: int,
    examples: Iterable[Proof | None],
    *,
    finished: bool,
    tolerance: float,
    unit: str,
    assumptions: tuple[str, ...],
    sources: tuple[str, ...] = KINDS[0].proof_sources,
) -> RegionProof:
    """Return what follows from the shares of a box of equations or systems that were proved.

    Parameters
    ----------
    subject, box, boxes
        As of `RegionProof`.
    shares : Shares
        Of parts that were proved; ``finished``: all were.
    examples : iterable of Proof or None
        One stable and one unstable point at most, asked for where the box is not decided.
    tolerance : float
        Growth, in ``unit``, that counts as none.
    assumptions : tuple of str
        Beside the assumption of the arithmetic.
    sources : tuple of str
        Publications behind the proof.
    """
    status: RegionStatus = "undecided"
    if finished and not shares.unstable:
        status = "stable"
    elif finished and not shares.stable:
        status = "unstable"
    shown = () if status != "undecided" else tuple(each for each in examples if each is not None)
    status = "mixed" if len(shown) == 2 else status
    shares = shares.with_status(status)
    return RegionProof(
        subject=subject,
        status=status,
        box=box,
        examples=shown,
        growth_tolerance=tolerance,
        growth_unit=unit,
        modes=1,
        left_out_bound=0.0,
        boxes=boxes,
        shares=shares,
        statement=statement_on(status, box, tolerance),
        note=note_on(status, shares, boxes),
        assumptions=(*assumptions, "doubles are added, multiplied and divided as IEEE 754 says, rounded to nearest"),
        _sources=sources,
    )


class _ProofInAQ(Proof):
    """A proof that is an example of a box of a, q and k."""

    def where(self, _shown: Any = None, _sides: Any = ()) -> str:
        """Return a, q and the damping."""
        equation: Any = self.equation
        damping = f", damping = {2.0 * equation.damping!r}" if equation.damping else ""
        return f"a = {0.0 - 4.0 * equation.beta!r}, q = {2.0 * equation.alpha!r}{damping}"


def in_aq(proof: Proof | RegionProof) -> Proof | RegionProof:
    """Return a proof on Mathieu's equation with alpha, beta and c written as a, q and k, and growth per unit z."""
    if isinstance(proof, Proof):
        exact = tuple((_IN_AQ[name][0], _IN_AQ[name][1] * x) for name, x in proof.exact)
        return replace(proof, exact=exact, statement=_per_z(proof.statement))
    alpha, beta, damping = proof.box
    box = (
        Side("a", 0.0 - 4.0 * beta.high, 0.0 - 4.0 * beta.low, ""),
        Side("q", 2.0 * alpha.low, 2.0 * alpha.high, ""),
        Side("damping", 2.0 * damping.low, 2.0 * damping.high, ""),
    )
    examples = [
        {field.name: getattr(each, field.name) for field in fields(each)} for each in map(in_aq, proof.examples)
    ]
    tolerance, unit = 2.0 * proof.growth_tolerance, "per z"
    return replace(
        proof,
        box=box,
        examples=tuple(_ProofInAQ(**each) for each in examples),
        growth_tolerance=tolerance,
        growth_unit=unit,
        statement=statement_on(proof.status, box, tolerance, unit),
    )


def _per_z(statement: str) -> str:
    """Return a statement on growth per unit tau as one per unit z, twice as large."""
    return re.sub(r"(\S+) per tau", lambda match: f"{2.0 * float(match[1]):g} per z", statement)


_IN_AQ = {"alpha": ("q", 2), "beta": ("a", -4), "damping": ("damping", 2)}
"""What is written in place of alpha, beta and c, and times what."""


def _sides(parameters: dict[str, Any]) -> ExactSides:
    """Return the exact ends of all parameters."""
    unknown = [name for name in parameters if name not in _NAMES]
    if unknown:
        raise TypeError(f"{', '.join(unknown)} is not a parameter of Mathieu; they are {', '.join(_NAMES)}")
    missing = [name for name in _NAMES[:2] if name not in parameters]
    if missing:
        raise TypeError(f"{missing[0]} must be given, a number or (low, high)")
    given = {"damping": 0} | parameters
    sides = ExactSides(*(side_ends(name, given[name], exact_number) for name in _NAMES))
    for name, ends in zip(_NAMES, sides, strict=True):
        for end in ends:
            validate.within(name, end, -validate.LARGEST, validate.LARGEST)
    if sides.damping[0] < 0:
        raise ValueError("damping must be zero or more, got less; growth of the free motion is not damping")
    return sides


def _example(
    sides: ExactSides, status: str, part: ModeBox, tolerance: float, prove: Callable[[Parameters], Proof]
) -> Proof | None:
    """Return the proof of one point, in the middle of a part; None where it does not have this status."""
    beta, alpha, damping = (Fraction(0.5 * sum(ends)) for ends in (part.mean, part.amplitude, part.damping_rate))
    if -alpha >= sides.alpha[0] and not alpha <= sides.alpha[1]:
        alpha = -alpha
    point = [min(max(x, low), high) for x, (low, high) in zip((alpha, beta, damping), sides, strict=True)]
    alpha, beta, damping = point
    # Growth above the tolerance is growth of the equation whose damping is larger by it.
    level = damping + Fraction(tolerance)
    proof = prove({"alpha": alpha, "beta": beta + damping**2 - level**2, "damping": level})
    if proof.status != status:
        return None
    equation = Mathieu(*(float(x) for x in point))
    exact = tuple((name, x) for name, x in zip(_NAMES, point, strict=True) if x != Fraction(float(x)))
    if tolerance == 0.0:
        return proof
    limit = f"{tolerance:g} per tau"
    statement = f"no solution grows faster than {limit}" if proof.stable else f"a solution grows faster than {limit}"
    return Proof(equation, proof.status, proof.interval, proof.digits, statement, proof.enclosures, exact=exact)


def statement_on(status: RegionStatus, box: tuple[Side, ...], tolerance: float, unit: str = "per tau") -> str:
    """Return what was proved, in a sentence; the tolerance of growth is in ``unit``."""
    sides = ", ".join(map(str, box))
    where = f"for every {sides}"
    grows = f"grows faster than {tolerance:g} {unit}" if tolerance else "grows"
    return {
        "stable": f"{where} no solution {grows}",
        "unstable": f"{where} a solution {grows}",
        "mixed": f"within {sides} at some points a solution {grows}, at some none",
        "undecided": f"within {sides} nothing is proved of all",
    }[status]


def note_on(status: RegionStatus, shares: Shares, boxes: int) -> str:
    """Return why nothing was decided."""
    if status != "undecided":
        return ""
    return (
        f"stopped after {boxes} parts; {100.0 * shares.stable:.3g} % of it proved stable, "
        f"{100.0 * shares.unstable:.3g} % unstable"
    )
