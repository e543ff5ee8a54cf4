"""Special points of a branch of orbits: where a multiplier crosses the unit circle."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from floquetrod._util.arrays import Floats
from floquetrod._util.content import ByContent
from floquetrod.orbits.arclength import Measure
from floquetrod.orbits.collocation import Step
from floquetrod.orbits.extents import extent
from floquetrod.orbits.orbit import PeriodicOrbit
from floquetrod.orbits.switching import Kind, Origin, switched


@dataclass(frozen=True, eq=False, repr=False)
class SpecialPoint(ByContent):
    """A point of a branch where a multiplier of the orbit crosses the unit circle.

    Attributes
    ----------
    kind : {"fold", "branch point", "period doubling", "Neimark-Sacker"}
        At +1 where the parameter turns back; at +1 where another branch crosses; at -1; a complex pair, where motion
        with a second frequency appears.
    parameter : str
        Name of the parameter.
    value : float
        Its value there.
    error : float
        Estimate of the error of ``value``: of the multiplier, of the zero it was located by, and of the orbit.
    multiplier : complex
        The one that crosses, of a pair that with the positive imaginary part.
    orbit : PeriodicOrbit
        The orbit there, whose verdict as a rule is undecided.
    after : int
        The point lies between this orbit of the branch and the next one.
    """

    kind: Kind
    parameter: str
    value: float
    error: float
    multiplier: complex
    orbit: PeriodicOrbit
    direction: Step = field(compare=False)
    measure: Measure = field(compare=False)
    after: int = field(default=0, compare=False)

    @property
    def period(self) -> float:
        """Period of the orbit there."""
        return self.orbit.period

    @property
    def least(self) -> Floats:
        """Least value of each state over the period (n,), to about 1e-6 of its range."""
        return extent(self.orbit)[0]

    @property
    def largest(self) -> Floats:
        """Largest value of each state over the period (n,), likewise."""
        return extent(self.orbit)[1]

    @property
    def amplitude(self) -> Floats:
        """Half the difference between the largest and the least value of each state (n,)."""
        return 0.5 * (self.largest - self.least)

    def switch(self, *, side: int = 1, distance: float = 0.05) -> PeriodicOrbit:
        """Return an orbit on the branch that begins or crosses here, near this point, for `floquetrod.follow`.

        Parameters
        ----------
        side : {1, -1}
            To which side of this branch, of two; of a doubled orbit they are the same half a period later.
            Where the branch is that of doubled orbits, the orbit of half the period is returned.
        distance : float
            How far away, as a fraction of the largest magnitudes of the states, from 1e-4 to 1; less where there is no
            orbit so far out.

        Raises
        ------
        ValueError
            At folds, where nothing crosses; at Neimark-Sacker points, where the new motion is not periodic; and where
            no orbit was found.
        """
        origin = Origin(self.kind, self.parameter, self.value, self.orbit, self.direction, self.measure)
        return switched(origin, side, distance)

    def as_dict(self) -> dict[str, Any]:
        """Return the point as numbers for JSON."""
        mu = [self.multiplier.real, self.multiplier.imag]
        return {"kind": self.kind, "value": self.value, "error": self.error, "multiplier": mu, "after": self.after}

    def __str__(self) -> str:
        return repr(self)

    def __repr__(self) -> str:
        """Return, say, "fold at omega = 2.2036 +- 1e-11"."""
        return f"{self.kind} at {self.parameter} = {self.value:.10g} +- {self.error:.1g}"
