"""What a proof says: the verdict, a statement, and enclosures of the quantities that decided."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, NamedTuple

from floquetrod._util.result_report import Report, Reported
from floquetrod.equations import DelaySystem, Equation, HillSystem, PeriodicSystem
from floquetrod.floquet.references import references
from floquetrod.floquet.registry import proof_sources
from floquetrod.floquet.verdict import Answer, Interval, Status

MAX_BOXES = 100_000
"""Default number of parts of a box that are examined before a proof is given up: a second or a few (a choice)."""


SECONDS = 30.0
"""Default time after which a box of a family's parameters is given up (a choice)."""


class Enclosure(NamedTuple):
    """A quantity that decided, with two numbers of mpmath it lies between."""

    quantity: str
    low: Any
    high: Any

    def __str__(self) -> str:
        """Return, say, "smallest pivot in [0.5, 0.5001]"."""
        import mpmath

        return f"{self.quantity} in [{mpmath.nstr(self.low, 8)}, {mpmath.nstr(self.high, 8)}]"


@dataclass(frozen=True, repr=False)
class Proof(Reported, Answer):
    """A proved verdict, or why there is none.

    Attributes
    ----------
    equation : Equation, HillSystem, PeriodicSystem or DelaySystem
        The equation or system, its parameters taken as the exact binary numbers they are, except for those in
        ``exact``.
    status : {"stable", "unstable", "undecided"}
        The proved status; "stable": every solution stays bounded (decays, if damped and not at rest).
    interval : Interval or None
        Stability interval or tongue of the equation with its damping removed, where the proof was by counting.
    digits : int
        Decimal digits of the arithmetic that decided, or of the last attempt; 0 where no arithmetic was needed.
    statement : str
        The proved statement, in a sentence.
    enclosures : tuple of Enclosure
        The quantities whose signs decided.
    exact : tuple of (str, Fraction)
        Parameters other than binary numbers: the proof holds for these, ``equation`` has the nearest doubles.
    """

    equation: Equation | HillSystem | PeriodicSystem | DelaySystem
    status: Status
    interval: Interval | None
    digits: int
    statement: str
    enclosures: tuple[Enclosure, ...] = ()
    exact: tuple[tuple[str, Fraction], ...] = field(default=(), kw_only=True)

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite, in plain text with DOI, floquetrod first, then the sources of the methods used."""
        return references(proof_sources(self.equation))

    def report(self) -> Report:
        """Return the proof in lines."""
        head = "UNDECIDED" if self.status == "undecided" else f"PROVED {self.status.upper()}"
        return Report(f"{head}: {self.statement} ({self.digits} digits)")

    def as_dict(self) -> dict[str, Any]:
        """Return the proof for JSON."""
        return {"status": self.status, "statement": self.statement, "digits": self.digits}

    def where(self, _shown: Any = None, _sides: Any = ()) -> str:
        """Return the subject of the proof, as `RegionProof` writes its examples."""
        return repr(self.equation)

    def __repr__(self) -> str:
        """Return the proof as a sentence."""
        where = f", {self.interval}" if self.interval is not None else ""
        where += "".join(f", {name} = {value} exactly" for name, value in self.exact)
        return f"<{self.status}{where}: {self.statement} ({self.digits} digits)>"
