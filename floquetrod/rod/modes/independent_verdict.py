"""The verdict on a rod whose modes are independent: that on each mode, and what follows from them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal

import numpy as np

from floquetrod._util.arguments import wrong_value
from floquetrod._util.arrays import Floats
from floquetrod._util.progress import Progress
from floquetrod._util.result_report import Table, number
from floquetrod._util.spans import complement
from floquetrod._util.suggest import listed
from floquetrod.equations import Mathieu
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.multipliers.resonance_names import Resonance
from floquetrod.floquet.references import united
from floquetrod.floquet.verdict import Cost, Stability, Status, tolerated
from floquetrod.rod.answers.margins import Edge
from floquetrod.rod.answers.verdict import Evidence, RodStability, Shape
from floquetrod.rod.loads.load import Load, Quantity
from floquetrod.rod.mode_equations.modal_systems import ModalSystem
from floquetrod.rod.mode_equations.tongues import unstable_loads
from floquetrod.rod.model.assumptions import assumptions
from floquetrod.rod.model.contact import constants_under, up_to_wall
from floquetrod.rod.model.data import RodData


class EachMode(Evidence):
    """Independent modes, each with its own verdict: of its motion, or of its second moments."""

    mode_verdicts: tuple[Any, ...]
    mode_growth_rates: Floats

    @property
    def references(self) -> tuple[str, ...]:
        """What to cite for the methods used."""
        return united(*(verdict.references for verdict in self.mode_verdicts))

    def unstable_modes(self, verdict: RodStability) -> tuple[int, ...]:
        """Return the modes that grow faster than the tolerance, drifting ones too where that is zero."""
        found = zip(self.modes, self.mode_verdicts, self.mode_growth_rates, strict=True)
        tolerance = verdict.growth_tolerance
        return tuple(m for m, v, rate in found if v.status == "unstable" and not tolerated(rate, tolerance))


@dataclass(frozen=True)
class ModeVerdicts(EachMode):
    """Independent modes, each with its own verdict.

    Attributes
    ----------
    system : ModalSystem
        The equations of the modes under the load; ``load``, ``modes`` and ``mode_equations`` are taken from it.
    mode_verdicts : tuple of Stability
        Verdict on each of them.
    mode_growth_rates : ndarray
        Growth rate of each mode in 1/s.
    """

    kind: ClassVar[str] = "independent modes"

    system: ModalSystem
    mode_verdicts: tuple[Stability, ...]
    mode_growth_rates: Floats = field(compare=False)

    @property
    def load(self) -> Load:
        """The load."""
        return self.system.load

    @property
    def modes(self) -> tuple[int, ...]:
        """Modes examined."""
        return self.system.modes

    @property
    def mode_equations(self) -> tuple[Mathieu, ...]:
        """Equation of each mode, in the time tau = omega t."""
        return self.system.equations

    @property
    def left_out_bound(self) -> float:
        """Bound in 1/s on the growth of every other mode, infinite where the modes were chosen by the caller."""
        return self.system.left_out_bound

    @property
    def cutoff(self) -> str:
        """Why these modes and no others."""
        return self.system.cutoff

    @property
    def resonances(self) -> tuple[Resonance, ...]:
        """What grows, the fastest first; each mode alone, its order that of its tongue."""
        found = []
        for i in np.argsort(-self.mode_growth_rates, kind="stable").tolist():
            verdict = self.mode_verdicts[i]
            if verdict.status == "unstable":
                order = _order(verdict, self.mode_equations[i])
                kind: Literal["direct", "buckling"] = "direct" if order else "buckling"
                found.append(Resonance(kind, (self.modes[i],), order, float(self.mode_growth_rates[i])))
        return tuple(found)

    def fastest_mode(self, verdict: RodStability) -> int | None:
        """Return the mode that grows fastest, None when none grows."""
        return self.modes[int(self.mode_growth_rates.argmax())] if verdict.growth_rate > 0.0 else None

    def damping_to_stabilise(self, verdict: RodStability) -> float:
        """Return the smallest damping rate in 1/s from which every larger one keeps all modes from growing.

        All modes that matter without damping are examined, or those the caller chose.
        """
        undamped = verdict.rod.replace(damping_rate=0.0)
        return replace(self.system, modes=self._modes_for(undamped, self.load, 0.0)).damping_to_stabilise

    def growth_of(self, verdict: RodStability, mode: int) -> float:
        """Return the growth rate of a mode in 1/s, examined or not."""
        return classify_modes(verdict.rod, replace(self.system, modes=(mode,)), 0.0).growth_rate

    def plot(self, verdict: RodStability, ax: Any = None) -> Any:
        """Draw the sine in which the fastest mode grows; ValueError where none does."""
        if verdict.growth_rate <= 0.0:
            raise wrong_value("plot", "draws the shape in which the rod grows, and of these modes none does")
        from floquetrod.plotting.rod_plot import draw_shape

        mode = self.modes[int(self.mode_growth_rates.argmax())]
        s = np.linspace(0.0, verdict.rod.length, 24 * mode + 1)
        sine = np.sin(math.pi * mode * s / s[-1])
        return draw_shape(verdict, Shape(s, sine, np.abs(sine)), f"mode {mode}", ax)

    has_exact_margins: ClassVar[bool] = True
    enough: ClassVar[str] = "stable at any rate above {}"

    def headline(self, verdict: RodStability) -> str:
        """Return the modes that grow."""
        if verdict.status != "unstable":
            return ""
        names = listed(verdict.unstable_modes)
        return f"modes {names} grow" if len(verdict.unstable_modes) > 1 else f"mode {names} grows"

    def fastest_in_words(self, verdict: RodStability) -> str:
        """Return the mode that grows fastest."""
        return f"mode {verdict.fastest_mode} grows"

    def grows_in(self, verdict: RodStability) -> str:
        """Return in which mode."""
        return f" in mode {verdict.fastest_mode}"

    def method(self, verdict: RodStability) -> str:
        """Return the methods, and how good discriminants are."""
        methods = ", ".join(sorted({verdict.method for verdict in self.mode_verdicts}))
        return f"{methods}; discriminants good to {verdict.error:.0e} relative"

    @property
    def table(self) -> Table:
        """The unstable modes and the five whose discriminants come nearest to the boundary, in order of mode."""
        rows = list(zip(self.modes, self.mode_equations, self.mode_verdicts, self.mode_growth_rates, strict=True))
        room = [-math.inf if v.status != "stable" else 2.0 - abs(v.discriminant) for v in self.mode_verdicts]
        troubled = sum(verdict.status != "stable" for verdict in self.mode_verdicts)
        chosen = sorted(sorted(range(len(rows)), key=room.__getitem__)[: max(5, troubled)])
        return Table(
            [("mode", ">4"), ("alpha", ">10"), ("beta", ">11"), ("where", "<21"), ("growth 1/s", ">10")],
            [
                (str(mode), f"{e.alpha:.5g}", f"{e.beta:.6g}", str(v.interval or v.status), f"{rate:.4g}")
                for mode, e, v, rate in (rows[i] for i in chosen)
            ],
        )

    def numbers(self, verdict: RodStability) -> dict[str, Any]:
        """Return the bound on modes left out, and every mode."""
        rows = zip(self.modes, self.mode_equations, self.mode_verdicts, self.mode_growth_rates, strict=True)
        return {
            "left_out_growth_bound_per_s": number(self.left_out_bound),
            "modes": [
                {
                    "mode": mode,
                    "alpha": equation.alpha,
                    "beta": equation.beta,
                    "status": each.status,
                    "interval": str(each.interval) if each.interval else None,
                    "growth_rate_per_s": float(rate),
                    "discriminant": number(each.discriminant),
                    "discriminant_relative_error": number(each.error),
                    "method": each.method,
                }
                for mode, equation, each, rate in rows
            ],
        }

    def _modes_for(self, rod: RodData, load: Load, growth_tolerance: float) -> tuple[int, ...]:
        """Return the modes that matter for another rod or load; those the caller chose stay as they are."""
        if math.isinf(self.left_out_bound):
            return self.modes
        last, _ = constants_under(rod, load.mean).modes_needed(load, growth_tolerance)
        return tuple(range(1, max(last, self.modes[-1]) + 1))

    def edge(
        self,
        verdict: RodStability,
        varied: Quantity,
        piece: tuple[float, float],
        seconds: float,
        progress: Progress | None,
    ) -> Edge:
        """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``, which takes milliseconds."""
        piece = up_to_wall(verdict.rod, self.load, varied, piece)
        low, high = sorted(piece)
        if low == high:
            return Edge(None, piece[0], 0.0)
        tolerance = verdict.margin_tolerance
        modes = self._modes_for(verdict.rod, self.load.varied(varied, high), tolerance)
        start = piece[0] if verdict.stable else None  # nothing beyond the first unstable part matters
        system = replace(self.system, modes=modes)
        found = unstable_loads(varied, system, tolerance, (low, high), union=True, nearest=start)
        stable = [gap[:2] for gap in complement((low, high), found.intervals)]
        if not stable:
            at = piece[0] if verdict.stable else None
        else:
            near, far = stable[0] if piece[0] == low else stable[-1][::-1]
            if not verdict.stable:
                at = near
            elif near != piece[0]:
                at = piece[0]
            else:
                at = far if far != piece[1] else None
        return Edge(at, piece[1] if at is None else at, found.resolution)


def classify_modes(rod: RodData, system: ModalSystem, growth_tolerance: float) -> RodStability:
    """Classify every mode and put the verdicts together."""
    verdicts = tuple(stability(equation) for equation in system.equations)
    rates = np.array([verdict.growth_rate for verdict in verdicts]) * system.frequency
    grows = [
        v.status == "unstable" and not tolerated(r, growth_tolerance) for v, r in zip(verdicts, rates, strict=True)
    ]
    unsure = [v.status == "undecided" and not r < growth_tolerance for v, r in zip(verdicts, rates, strict=True)]
    status: Status = "unstable" if any(grows) else "undecided" if any(unsure) else "stable"
    exponents = [exponent * system.frequency for verdict in verdicts for exponent in verdict.exponents]
    units = {verdict.cost.unit for verdict in verdicts}
    return RodStability(
        rod=rod,
        evidence=ModeVerdicts(system, verdicts, rates),
        growth_tolerance=growth_tolerance,
        status=status,
        growth_rate=float(rates.max()),
        exponents=tuple(sorted(exponents, key=lambda exponent: -exponent.real)),
        period=2.0 * math.pi / system.frequency,
        error=max(verdict.error for verdict in verdicts),
        cost=Cost(sum(verdict.cost.amount for verdict in verdicts), units.pop() if len(units) == 1 else "operations"),
        note="; ".join(dict.fromkeys(v.note for v, unknown in zip(verdicts, unsure, strict=True) if unknown)),
        assumptions=assumptions(rod, system.load),
    )


def _order(verdict: Stability, equation: Mathieu) -> int:
    """Return the order of the resonance that a mode is in, 0 for buckling: its tongue, or the nearest where unknown."""
    if verdict.interval is not None:
        return verdict.interval.order
    return max(1, round(2.0 * math.sqrt(-equation.beta))) if equation.beta < 0.0 else 0
