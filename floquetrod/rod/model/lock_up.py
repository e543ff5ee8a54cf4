"""How far a string can be pushed along a channel before friction against its own helix stops it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod import units
from floquetrod._util.arrays import shaped
from floquetrod._util.caching import cached_property
from floquetrod._util.interchange import by_keys, plain
from floquetrod._util.result_report import Printed, Report
from floquetrod.units import AnswerUnits

_LARGEST = 1e15  # of forces in N and distances in m (a choice)


@dataclass(frozen=True, repr=False)
class LockUp(units.InUnits, Printed):
    """Friction of a string that is pushed down a channel from its upper end, and the length at which it locks up.

    With xi the distance from the far end, where the compression is F_0, and F_p the critical force,

        dF/dxi = mu w_across (1 + F^2 / F_p^2) - w_along

    where the string is compressed: a helix pressed against the wall by its own force, R F^2 / (4 E I) per length on top
    of its weight.  Where it is pulled it lies straight, and the term in F^2 is absent.  Solved in closed form.

    Attributes
    ----------
    friction : float
        Coefficient of friction mu along the channel.
    far_force : float
        F_0, effective compression at the far end in N; negative for a pull.
    critical_force : float
        F_p in N.
    weight_across : float
        Weight in fluid across the channel in N/m, w_e sin(inclination).
    weight_along : float
        Weight in fluid along it in N/m, w_e cos(inclination).

    Examples
    --------
    >>> import floquetrod as fr
    >>> tubing = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=1000.0, fluid_inside=1e3, fluid_outside=1e3)
    >>> found = tubing.lock_up(friction=0.3)
    >>> found
    <locks up 1626 m from the far end with friction 0.3>
    >>> round(found.force(1000.0)), round(found.pushed_length(2.0 * tubing.critical_force))
    (17603, 1146)
    """

    friction: float
    far_force: float
    critical_force: float
    weight_across: float
    weight_along: float

    def __post_init__(self) -> None:
        """Check and clean the force at the far end; the rod's numbers have been checked."""
        far_force = units.number("far_force", self.far_force, "force", -_LARGEST, _LARGEST, "give the force in N")
        object.__setattr__(self, "far_force", far_force)

    def _in_words(self, shown: AnswerUnits) -> str:
        far = f" and {shown.force.show(self.far_force)} at that end" if self.far_force else ""
        what = f"friction {self.friction:g}{far}"
        if math.isinf(self.length):
            return f"never locks up with {what.replace('that', 'the far')}"
        return f"locks up {shown.length.show(self.length, 4)} from the far end with {what}"

    @property
    def length(self) -> float:
        """Distance in m from the far end at which the force becomes infinite; infinite where it never does."""
        return self.critical_force * self._reach

    def force(self, distance: Any) -> Any:
        """Return the effective compression in N at distances in m from the far end, infinite from `length` on.

        At the distance of the pushed end, this is the force that it takes to push a string so long.

        Returns
        -------
        float or ndarray
            In N, in the shape of ``distance``.

        Raises
        ------
        TypeError, ValueError
            For negative distances, and for other units.
        """
        distances = units.array("distance", distance, "length", 0.0, _LARGEST)
        scaled = [self._force(x) for x in (distances.ravel() / self.critical_force).tolist()]
        return shaped(self.critical_force * np.array(scaled), distances.shape)

    def pushed_length(self, force: Any) -> Any:
        """Return the greatest length in m that forces (N) at the upper end can push.

        Zero where the force is less than that at the far end, and infinite where weight carries the string.

        Returns
        -------
        float or ndarray
            In m, in the shape of ``force``.

        Raises
        ------
        TypeError, ValueError
            For forces that are not finite, and for other units.
        """
        forces = units.array("force", force, "force", -_LARGEST, _LARGEST)
        scaled = [self._length(f) for f in (forces.ravel() / self.critical_force).tolist()]
        return shaped(self.critical_force * np.array(scaled), forces.shape)

    def report(self, push: float | None = None, *, length: str | None = None, force: str | None = None) -> Report:
        """Return the length in words; also the length that a ``push`` in N can push.

        ``length`` and ``force`` are the units to answer in, such as "ft" and "lbf", by default as in the question,
        see `floquetrod.units.AnswerUnits`.
        """
        shown = AnswerUnits.named(force, length, given=self.given_units)
        lines = []
        if push is not None:
            push = units.number("push", push, "force", -_LARGEST, _LARGEST, "give the force in N")
            reach = float(self.pushed_length(push))
            string = "a string of any length" if math.isinf(reach) else shown.length.show(reach, 4)
            lines.append(("pushed", f"{shown.force.show(push)} at the upper end pushes {string}"))
        return Report(self._in_words(shown), lines, assumptions=self.assumptions)

    def as_dict(self, push: float | None = None) -> dict[str, Any]:
        """Return everything as numbers for JSON, units in the keys; None for a length that is infinite.

        Also the length that a ``push`` in N can push.
        """
        push = None if push is None else units.number("push", push, "force", -_LARGEST, _LARGEST)
        pushed = {"push_N": push, "pushed_length_m": None if push is None else plain(self.pushed_length(push))}
        found = by_keys(self, "length_m friction far_force_N critical_force_N")
        return found | pushed | by_keys(self, "assumptions")

    @property
    def assumptions(self) -> tuple[str, ...]:
        """Assumptions of the formula."""
        return (
            "effective force, of a string that slides down the channel all along and is pushed at its upper end",
            "a helix wherever it is compressed; one forms only above the helical critical force, and below that the "
            "contact force is smaller, so that the string goes further",
            "straight where it is pulled",
            "straight channel, friction along it alone, no torque, no vibration",
            "linear elasticity: yielding is not checked",
        )

    # Forces in critical forces and distances over the critical force: df/dx = a + b f^2 for f >= 0, a for f < 0.

    @cached_property
    def _rates(self) -> tuple[float, float, float]:
        """A and b in N/m, and sqrt(|a b|)."""
        b = self.friction * self.weight_across
        a = b - self.weight_along
        return a, b, math.sqrt(abs(a)) * math.sqrt(b)

    @cached_property
    def _reach(self) -> float:
        """Scaled distance at which the force becomes infinite."""
        a, b, kappa = self._rates
        start = self.far_force / self.critical_force
        straight = 0.0
        if start < 0.0:
            if a <= 0.0:
                return math.inf
            straight, start = -start / a, 0.0
        if a > 0.0:
            return straight + math.atan2(kappa, b * start) / kappa
        if b * start <= kappa:  # also where nothing rubs, or nothing presses
            return math.inf
        return math.atanh(kappa / (b * start)) / kappa if kappa else 1.0 / (b * start)

    def _travel(self, start: float, stop: float) -> float:
        """Return the scaled distance over which the force of a compressed string changes from one value to another."""
        a, b, kappa = self._rates
        change, base = stop - start, a + b * start * stop
        if a > 0.0:
            return math.atan2(kappa * change, base) / kappa
        if not kappa:
            return change / base
        ratio = kappa * change / base
        return math.atanh(ratio) / kappa if ratio < 1.0 else math.inf

    def _length(self, force: float) -> float:
        """Return the greatest scaled length that a force can push."""
        a, b, _ = self._rates
        start = self.far_force / self.critical_force
        slope = a + b * max(start, 0.0) ** 2
        if slope < 0.0 or (slope == 0.0 and force >= start):
            return math.inf
        if force <= start:
            return 0.0
        straight = (min(force, 0.0) - start) / a if start < 0.0 else 0.0
        bent = self._travel(max(start, 0.0), force) if force > 0.0 else 0.0
        return min(straight + bent, self._reach)

    def _force(self, x: float) -> float:
        """Return the scaled force at a scaled distance."""
        a, b, kappa = self._rates
        start = self.far_force / self.critical_force
        if x >= self._reach:
            return math.inf
        if start < 0.0:
            if a <= 0.0 or x <= -start / a:
                return start + a * x
            x, start = x + start / a, 0.0
        turn = x
        if kappa:
            turn = (math.tan(kappa * x) if a > 0.0 else math.tanh(kappa * x)) / kappa
        below = 1.0 - b * start * turn
        if below <= 0.0:  # at the length to rounding
            return math.inf
        force = (start + a * turn) / below
        return force if force >= 0.0 else a * (x - self._travel(start, 0.0))
