"""What every method for systems returns."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

from floquetrod._util.caching import cached_property
from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.equations.matrices import Structure
from floquetrod.floquet.references import references
from floquetrod.floquet.systems.damping import damping_to_stabilise
from floquetrod.floquet.verdict import Verdict, pace


class Resonance(NamedTuple):
    """The name of an instability: the combination of natural frequencies of the mean system that explains it best.

    Attributes
    ----------
    kind : {"direct", "sum", "difference", "buckling"}
        2 w_i = k w; w_i + w_j = k w; w_i - w_j = k w (k = 0: flutter of the mean system); negative mean stiffness.
    modes : tuple of int
        Modes of the mean system, counted from 1 in the order of their frequencies.
    order : int
        k, in terms of w = 2 pi / period; 0 for buckling.
    growth_rate : float
        Of the solution it names, per unit of time.
    """

    kind: Literal["direct", "sum", "difference", "buckling"]
    modes: tuple[int, ...]
    order: int
    growth_rate: float

    def __str__(self) -> str:
        """Return, say, "sum resonance of modes 1 and 2, order 1"."""
        if self.kind == "buckling":
            return f"buckling of mode {self.modes[0]}"
        if self.kind == "direct":
            return f"direct resonance of mode {self.modes[0]}, order {self.order}"
        modes = f"modes {self.modes[0]} and {self.modes[1]}"
        return f"{self.kind} resonance of {modes}, order {self.order}" if self.order else f"flutter of {modes}"


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class SystemStability(Verdict):
    """Verdict on a system of equations, per unit of its time.

    Attributes
    ----------
    system : HillSystem or PeriodicSystem
        The system classified.
    method : str
        Name of the method.
    structure : {"hamiltonian", "reversible", "damped", "general"}
        What is exactly so of its matrices.
    exponent_errors : tuple of float
        Error of each exponent: a bound or an estimate, the method says which.
    krein_signs : tuple of int
        +1 or -1 for each multiplier on the unit circle whose Krein sign is known, else 0; a natural oscillator of
        frequency f has +1 at exp(i f period).  All 0 where the system is not Hamiltonian.
    resonances : tuple of Resonance
        Names of the growing solutions, the fastest first; of a heuristic kind, never a ground for the verdict.
    strongly_stable : bool or None
        Whether all small changes of the coefficients that keep the structure leave the system stable; with damping:
        whether every solution decays.  None when undecided.
    status, growth_rate, exponents, multipliers, period, error, cost, note, assumptions
        As in every `Verdict`; as many exponents as equations of first order, and ``error`` is the largest of
        ``exponent_errors``, times the period: the relative error of the multipliers.
    """

    system: HillSystem | PeriodicSystem
    method: str
    structure: Structure
    exponent_errors: tuple[float, ...]
    krein_signs: tuple[int, ...]
    resonances: tuple[Resonance, ...]
    strongly_stable: bool | None

    @property
    def references(self) -> tuple[str, ...]:
        """What to cite, in plain text with DOI, floquetrod first, then the sources of what was used."""
        return references(("system", self.method))

    @property
    def multiplier_errors(self) -> tuple[float, ...]:
        """Error of each multiplier, in the sense of ``exponent_errors``."""
        return tuple(
            abs(mu) * math.expm1(min(error * self.period, 700.0))
            for mu, error in zip(self.multipliers, self.exponent_errors, strict=True)
        )

    @cached_property
    def damping_to_stabilise(self) -> float:
        """Uniform damping rate, per unit of time, that it takes to keep the system from growing; 0 where none.

        The rate c is added to what damping there is: as C + 2 c M in a `HillSystem`, as A - c I in a `PeriodicSystem`,
        where it is the growth rate itself.  That of a `HillSystem` is searched, to ten digits: nothing grows at larger
        rates among those tried, which are two, four and eight times the growth rate, and those from the fastest
        frequency down in 12 steps by halves.  Damping can destabilise: of a stable system it need not be 0.

        Infinite where the mean stiffness alone is unstable, which damping only slows down.  NaN where the search would
        take more than about a minute, where growth is not known, or cannot be told from none at some rate.

        Examples
        --------
        >>> import floquetrod as fr
        >>> found = fr.stability(HillSystem([[1.0]], cosines=[[[0.3]]], period=3.141592653589793))
        >>> round(found.growth_rate, 6), round(found.damping_to_stabilise, 6)
        (0.074803, 0.074908)
        """
        if isinstance(self.system, PeriodicSystem) or math.isnan(self.growth_rate):
            return self.growth_rate
        return damping_to_stabilise(self.system, self.growth_rate)

    def __repr__(self) -> str:
        """Return the verdict as a sentence."""
        verdict: str = "strongly stable" if self.strongly_stable and self.status == "stable" else self.status
        if self.status == "unstable":
            verdict += f": grows {pace(self.growth_rate)} per unit time"
        elif self.status == "undecided" and self.exponents:
            verdict += f": growth {self.growth_rate:.3g} per unit time cannot be told from none"
        if self.resonances:
            verdict += f", {self.resonances[0]}"
        size = f"{self.structure} system of {self.system.order}"
        size += f", multipliers +- {self.error:.1g} relative" if self.exponents else ", multipliers not computed"
        text = f"{verdict}; {size}; {self.method}, {self.cost}"
        return f"<{text}; {self.note}>" if self.note else f"<{text}>"
