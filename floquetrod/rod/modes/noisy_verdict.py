"""The verdict in mean square on a rod under a force that is partly random: that on the second moments of each mode."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from floquetrod._util.arguments import wrong_value
from floquetrod._util.arrays import Floats
from floquetrod._util.progress import Progress
from floquetrod._util.result_report import Table, number
from floquetrod.equations.batches import pick
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.multipliers.resonance_names import Resonance
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.verdict import Cost, Status, tolerated
from floquetrod.rod.answers.intervals import Search
from floquetrod.rod.answers.margins import Edge
from floquetrod.rod.answers.verdict import Evidence, RodStability
from floquetrod.rod.loads.load import Load, Loads, Quantity
from floquetrod.rod.mode_equations.noisy_modes import NoisyModes
from floquetrod.rod.model.assumptions import assumptions
from floquetrod.rod.model.contact import constants_under, up_to_wall
from floquetrod.rod.modes.independent_verdict import EachMode
from floquetrod.rod.modes.mode_model import ModeModel
from floquetrod.rod.modes.noisy_search import HALVINGS, Effort, first_change

_SAMPLES = 65  # of each piece of a search for a margin (a choice)
_STEP = 16  # modes that are examined before the bounds on others are asked again (a choice)
_LISTED = 5  # modes in a report besides those that grow, those next to growth

IN_MEAN_SQUARE = "growth is that of second moments, twice that of amplitudes: the verdict is in mean square"

ASSUMED = (
    IN_MEAN_SQUARE,
    "the random force acts on each mode as white noise of its density at twice the mode's frequency (Ito's sense and "
    "Stratonovich's are the same)",
)
"""What is assumed of noise."""

HIGH_MODES_GROW = (
    "all high modes grow at {:.3g} 1/s in mean square: the noise has this density at every frequency; give pairs of "
    "frequency and density where it has not"
)


class UnderNoise(Evidence):
    """Modes under noise: what grows has no name, and margins are found by samples."""

    model: Any

    @property
    def load(self) -> Load:
        """The load."""
        load: Load = self.model.like
        return load

    @property
    def resonances(self) -> tuple[Resonance, ...]:
        """Nothing, as noise may make modes grow that resonate with nothing."""
        return ()

    def damping_to_stabilise(self, verdict: RodStability) -> float:
        """Return a damping rate in 1/s above which this load is stable in mean square, to nine digits."""
        return float(self.model.damping_required(self.load, verdict.growth_tolerance))

    def effort(self, seconds: float, longest: float) -> Effort:
        """Return what a part of a search for a margin takes.

        ``longest`` is the longest period of its loads over that of this one.
        """
        return Effort(_SAMPLES, HALVINGS)

    def edge(
        self,
        verdict: RodStability,
        varied: Quantity,
        piece: tuple[float, float],
        seconds: float,
        progress: Progress | None,
    ) -> Edge:
        """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``, by samples."""
        piece = up_to_wall(verdict.rod, self.load, varied, piece)
        longest = max(1.0, self.load.frequency / min(piece)) if varied == "frequency" else 1.0
        effort = self.effort(seconds, longest)
        if piece[0] == piece[1] or not effort.samples:
            return Edge(None, piece[0], 0.0)
        edge = first_change(
            self.model,
            Search(varied, self.load, piece, verdict.margin_tolerance),
            np.linspace(*piece, effort.samples),
            verdict.status == "stable",
            known=piece[0] == getattr(self.load, varied),
            at_once=self.model.at_once,
            halvings=effort.halvings,
            refused=ValueError,  # too many modes, or loads too large or too slow: nothing is known of them
            progress=progress,
        )
        return edge._replace(seconds=effort.seconds)


@dataclass(frozen=True)
class NoisyEvidence(UnderNoise, EachMode):
    """Independent modes under noise, the second moments of each with its own verdict.

    Attributes
    ----------
    model : ModeModel
    numbered : tuple of int
        Modes examined.
    mode_verdicts : tuple of SystemStability
        Verdict on the second moments of each of them, in units of time in which its own frequency is 1.
    mode_growth_rates : ndarray
        Growth rate of the second moments of each mode in 1/s, negative where they decay.
    mode_intensities : ndarray
        s of each mode, q'' + ... = s q xi, in 1/s^1.5.
    left_out_bound : float
        Bound in 1/s on the growth of every other mode in mean square, infinite where the modes were chosen.
    """

    kind: ClassVar[str] = "modes under noise"

    model: ModeModel = field(compare=False)
    numbered: tuple[int, ...]
    mode_verdicts: tuple[SystemStability, ...]
    mode_growth_rates: Floats = field(compare=False)
    mode_intensities: Floats = field(compare=False)
    left_out_bound: float

    @property
    def modes(self) -> tuple[int, ...]:
        """Modes examined."""
        return self.numbered

    @property
    def cutoff(self) -> str:
        """Why these modes and no others."""
        if math.isinf(self.left_out_bound):
            return f"the {len(self.modes)} modes requested; others were not checked"
        if self.left_out_bound > 0.0:
            growth = f"every higher mode grows at less than {self.left_out_bound:.2g} per second"
            return f"modes 1 to {self.modes[-1]}, in mean square: {growth}"
        return f"modes 1 to {self.modes[-1]}, in mean square: no higher mode can grow"

    def fastest_mode(self, verdict: RodStability) -> int | None:
        """Return the mode that grows fastest, None when none grows."""
        fastest = int(self.mode_growth_rates.argmax())
        rate = self.mode_growth_rates[fastest]
        return self.modes[fastest] if rate > 0.0 and rate >= verdict.growth_rate else None

    def growth_of(self, verdict: RodStability, mode: int) -> float:
        """Return the growth rate of the second moments of a mode in 1/s."""
        return self.model.growth_of_modes(self.load, [mode])[0]

    def plot(self, verdict: RodStability, ax: Any = None) -> Any:
        """Raise ValueError: there is no shape to draw where modes are independent."""
        raise wrong_value("plot", "draws the shape in which coupled modes grow, and these modes are independent")

    def headline(self, verdict: RodStability) -> str:
        """Return the modes that grow."""
        if verdict.status != "unstable":
            return "in mean square"
        return f"in mean square, {self._growing(verdict)}"

    def fastest_in_words(self, verdict: RodStability) -> str:
        """Return the mode that grows fastest."""
        mode = verdict.fastest_mode
        return f"{'all high modes grow' if mode is None else f'mode {mode} grows'} in mean square"

    def grows_in(self, verdict: RodStability) -> str:
        """Return in which mode."""
        mode = verdict.fastest_mode
        return " in mean square" + ("" if mode is None else f" in mode {mode}")

    def method(self, verdict: RodStability) -> str:
        """Return the methods, and how good the growth rates are."""
        methods = ", ".join(sorted({each.method for each in self.mode_verdicts}))
        return f"second moments, {methods}; growth good to {verdict.error:.0e} 1/s"

    @property
    def table(self) -> Table:
        """The modes that grow and the five nearest to growth, in order."""
        troubled = sum(verdict.status != "stable" for verdict in self.mode_verdicts)
        nearest = np.argsort(-self.mode_growth_rates, kind="stable")[: max(_LISTED, min(troubled, 4 * _LISTED))]
        columns = [("mode", ">4"), ("noise 1/s^1.5", ">14"), ("where", "<10"), ("growth of q^2 1/s", ">18")]
        return Table(
            columns,
            [
                (
                    str(self.modes[i]),
                    f"{self.mode_intensities[i]:.5g}",
                    self.mode_verdicts[i].status,
                    f"{self.mode_growth_rates[i]:.5g}",
                )
                for i in sorted(nearest.tolist())
            ],
        )

    def numbers(self, verdict: RodStability) -> dict[str, Any]:
        """Return the bound on modes left out, every mode, and the kind of load."""
        rows = zip(self.modes, self.mode_verdicts, self.mode_growth_rates, self.mode_intensities, strict=True)
        return {
            "in_mean_square": True,
            "growth_rate_error_per_s": number(verdict.error),
            "left_out_growth_bound_per_s": number(self.left_out_bound),
            "load": self.load.kind_as_dict(),
            "modes": [
                {
                    "mode": mode,
                    "status": each.status,
                    "growth_of_second_moments_per_s": number(float(rate)),
                    "noise_per_s_1.5": float(s),
                    "method": each.method,
                }
                for mode, each, rate, s in rows
            ],
            "note": verdict.note,
        }

    def sentence(self, verdict: RodStability) -> str:
        """Return status, growth and the modes that grow."""
        if verdict.status != "unstable":
            return f"{verdict.status} in mean square"
        rate = f"{verdict.growth_rate:.6g} 1/s, tenfold in {verdict.time_to_grow():.3g} s"
        mode = "" if verdict.fastest_mode is None else f"mode {verdict.fastest_mode} at "
        return f"unstable in mean square: {self._growing(verdict)}; {mode}{rate}"

    def _growing(self, verdict: RodStability) -> str:
        names = verdict.unstable_modes
        model: Any = self.model
        beyond = math.isfinite(self.left_out_bound) and model.growth_beyond(self.load) > verdict.growth_tolerance
        if not names:
            return "all high modes grow" if beyond else f"mode {verdict.fastest_mode} grows"
        others = ", and all high modes" if beyond else ""
        if len(names) > 3:
            return f"{len(names)} modes grow, {names[0]} to {names[-1]}{others}"
        return (f"modes {', '.join(map(str, names))} grow" if len(names) > 1 else f"mode {names[0]} grows") + others


def classify_noisy(
    model: ModeModel, load: Load, chosen: tuple[int, ...] | None, growth_tolerance: float, progress: Progress | None
) -> RodStability:
    """Classify the second moments of every mode that matters and put the verdicts together."""
    equations = NoisyModes(constants_under(model.rod, load.mean), load)
    examined = _Examined(equations, load)
    limit, left_out = -math.inf, math.inf
    if chosen:
        examined.add(chosen, len(chosen), progress)
    else:
        bounds = equations.growth_bounds(Loads.single(load))
        limit, best = bounds.limit, bounds.least
        while len(examined.modes) < (last := int(bounds.modes_needed(best, growth_tolerance)[0])):
            first = len(examined.modes) + 1
            examined.add(range(first, min(last, first + _STEP - 1) + 1), last, progress)
            best = np.maximum(best, examined.rates.max(initial=-math.inf))
        left_out = float(bounds.left_out(np.array([len(examined.modes)]))[0])
    rates = examined.rates
    status, note = _concluded(examined, (limit, left_out), growth_tolerance)
    exponents = [*examined.exponents, *([complex(limit)] if limit > rates.max() else [])]
    costs = (verdict.cost.amount for verdict in examined.verdicts)
    return RodStability(
        rod=model.rod,
        evidence=NoisyEvidence(
            model,
            tuple(examined.modes),
            tuple(examined.verdicts),
            rates,
            np.array(examined.intensities),
            max(0.0, left_out),
        ),
        growth_tolerance=growth_tolerance,
        status=status,
        growth_rate=max(0.0, float(rates.max()), limit),
        exponents=tuple(sorted(exponents, key=lambda exponent: -exponent.real)),
        period=2.0 * math.pi / load.frequency,
        error=examined.error((limit, -math.inf if chosen else left_out)),
        cost=Cost(sum(costs), "operations"),
        note=note,
        assumptions=(*assumptions(model.rod, load), *ASSUMED),
    )


class _Examined:
    """Modes under a load: the verdict on the second moments of each, and their growth in 1/s between bounds."""

    def __init__(self, equations: NoisyModes, load: Load) -> None:
        """Take the equations; nothing is examined yet."""
        self.equations, self.load = equations, load
        self.modes: list[int] = []
        self.verdicts: list[SystemStability] = []
        self.intensities: list[float] = []
        self.exponents: list[complex] = []
        self.rates, self.low, self.high = np.zeros((3, 0))

    def add(self, modes: Sequence[int], total: int, progress: Progress | None) -> None:
        """Examine more modes; the bounds that hold for high ones are often closer than the errors of verdicts."""
        parts = self.equations.parts(Loads.single(self.load), modes)
        every = parts.moments(np.ones((1, len(modes)), dtype=np.bool_))
        units = np.broadcast_to(parts.rate, (1, len(modes)))[0].tolist()
        found = []
        for i, unit in enumerate(units):
            verdict = stability(pick(every, i))
            self.verdicts.append(verdict)
            self.exponents.extend(unit * exponent for exponent in verdict.exponents)
            known = bool(verdict.exponents)
            rate, error = (verdict.exponents[0].real, verdict.exponent_errors[0]) if known else (-math.inf, math.inf)
            found.append((unit * rate, unit * error))
            if progress is not None:
                progress(len(self.verdicts), total)
        low, high = (bound[0] for bound in parts.growth_bounds)
        rates, errors = np.array(found).T
        self.rates = np.append(self.rates, np.clip(rates, low, high))
        status = np.array([verdict.status for verdict in self.verdicts[len(self.modes) :]])
        low, high = np.fmax(low, rates - errors), np.fmin(high, rates + errors)
        self.low = np.append(self.low, np.where(status == "unstable", np.maximum(low, 0.0), low))
        self.high = np.append(self.high, np.where(status == "stable", np.minimum(high, 0.0), high))
        self.modes.extend(modes)
        self.intensities.extend(parts.intensity[0].tolist())

    def error(self, others: tuple[float, float]) -> float:
        """Return the error in 1/s of the growth rate, no less than of the fastest mode's.

        Of the other modes the limit of high ones and a bound.
        """
        limit, left_out = others
        fastest = int(self.rates.argmax())
        rate, low, high = (
            max(0.0, *values)
            for values in (
                (float(self.rates.max()), limit),
                (float(self.low.max()), limit),
                (float(self.high.max()), left_out),
            )
        )
        own = max(self.high[fastest] - self.rates[fastest], self.rates[fastest] - self.low[fastest])
        return float(max(rate - low, high - rate, own if self.rates[fastest] >= limit else 0.0))


def _concluded(examined: _Examined, others: tuple[float, float], growth_tolerance: float) -> tuple[Status, str]:
    """Return the verdict on all modes, and what to know of it; ``others`` grow at least, and at most, so fast."""
    limit, left_out = others
    verdicts, rates = examined.verdicts, examined.rates.tolist()
    if limit > growth_tolerance:
        return "unstable", HIGH_MODES_GROW.format(limit)
    grows = (
        v.status == "unstable" and not tolerated(rate, growth_tolerance)
        for v, rate in zip(verdicts, rates, strict=True)
    )
    if any(grows) or examined.low.max() > growth_tolerance:
        return "unstable", ""
    unsure = [
        v
        for v, high in zip(verdicts, examined.high, strict=True)
        if v.status == "undecided" and not high < growth_tolerance
    ]
    if unsure:
        return "undecided", "; ".join(dict.fromkeys(v.note for v in unsure))
    if growth_tolerance < left_out < math.inf:
        return "undecided", f"higher modes may grow at up to {left_out:.2g} 1/s in mean square"
    return "stable", ""
