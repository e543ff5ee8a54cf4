"""A verdict on one equation in a sentence: how fast it grows, which damping stabilises it, how far changes are."""

from __future__ import annotations

import math
from dataclasses import replace

from floquetrod.equations import Equation, Mathieu, MathieuAQ, Meissner
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.margins import Margin, status_change
from floquetrod.floquet.verdict import Stability, rate_in_words

_FORCING = {MathieuAQ: ("q", "a"), Mathieu: ("alpha", "beta"), Meissner: ("alpha", "beta")}
"""Names of forcing and mean in equations whose verdict does not depend on the forcing's sign."""

_LARGEST = 1e4  # forcing and mean up to which the margin and the damping take a second at most (measured)
_CHARTED = 100.0  # forcing and mean up to which a chart takes some seconds (measured)
_REACH = 4.0  # times the forcing: how far changes are searched (a choice)
_SAMPLES = 65  # verdicts on either side of the forcing or the mean (a choice)


def in_one_line(verdict: Stability) -> str:
    """Return the verdict, its growth or decay, the damping that stabilises and the margins, the nearest first."""
    unit, sentence = f"per unit {verdict.unit}", verdict.status.upper()
    if verdict.status == "unstable":
        sentence += f": grows {rate_in_words(verdict.growth_rate)} {unit}"
        sentence += f", tenfold in {verdict._tenfold}" if verdict.growth_rate > 0.0 else ""
    elif verdict.status == "stable":
        rate = verdict.decay_rate
        sentence += f": decays at {rate:.6g} {unit}" if rate > 0.0 else ": every motion stays bounded"
    else:
        sentence += ": growth cannot be distinguished from none"
    if not has_quick_margins(verdict.equation):
        return sentence
    needed = damping_in_words(verdict) if verdict.status == "unstable" or verdict.equation.damping else ""
    return "; ".join(filter(None, [sentence, needed, *margins_in_words(verdict)]))


def has_quick_margins(equation: Equation) -> bool:
    """Return whether damping and forcing that change the verdict are found in about a second."""
    names = _FORCING.get(type(equation))
    return names is not None and all(abs(getattr(equation, name)) <= _LARGEST for name in names)


def damping_in_words(verdict: Stability) -> str:
    """Return the damping above which the equation is stable; "" where it is not known."""
    equation = verdict.equation
    present, unit = equation.damping, f"per unit {verdict.unit}"
    if verdict.status == "undecided":
        return ""
    if verdict.status == "stable":
        undamped = stability(replace(equation, damping=0.0)) if present else verdict
        if undamped.status == "stable":
            return "stable without damping"
        least = undamped.damping_to_stabilise
        known = undamped.status == "unstable" and 0.0 < least <= present
        return f"stable with a damping above {least:.6g} {unit}, {present - least:.6g} less" if known else ""
    if not (more := verdict.damping_to_stabilise) > 0.0:
        return ""
    if math.isinf(more):
        return "strong damping does not stabilise it, as the mean coefficient alone is unstable; weak damping may"
    added = f", {more:.6g} more" if present else ""
    return f"stable with a damping above {present + more:.6g} {unit}{added}"


def margins_in_words(verdict: Stability) -> list[str]:
    """Return the means and forcings at which the verdict changes, the nearest first; none without such numbers."""
    names = _FORCING.get(type(verdict.equation))
    if names is None or verdict.status == "undecided":
        return []
    forcing, mean = names
    here = {mean: getattr(verdict.equation, mean), forcing: abs(getattr(verdict.equation, forcing))}
    margins = {mean: mean_margin(verdict), forcing: forcing_margin(verdict)}
    if margins[forcing].nearest < _indistinct(here[forcing]):
        return [f"on a boundary: changes with {forcing} as soon as its magnitude differs from {here[forcing]:.6g}"]
    if margins[mean].nearest < _indistinct(here[mean]):
        return [f"on a boundary: changes with {mean} as soon as it differs from {here[mean]:.6g}"]
    symbols = {mean: mean, forcing: forcing if getattr(verdict.equation, forcing) >= 0.0 else f"-{forcing}"}
    return [
        _margin_in_words(margins[name], symbols[name], here[name])
        for name in sorted(margins, key=lambda name: margins[name].nearest)
    ]


def _margin_in_words(margin: Margin, symbol: str, here: float) -> str:
    """Return where the verdict changes along one number, and how far and in which steps was searched."""
    low, high = (
        0.0 if abs(end) < _indistinct(here) else end for end in (here - margin.searched[0], here + margin.searched[1])
    )
    sides = sorted(zip(margin, (low, high), ("lower", "higher"), strict=True))
    changes = [f"at {at:.6g} ({distance:.4g} {side})" for distance, at, side in sides if math.isfinite(distance)]
    steps = f", in steps of {margin.resolution:.2g}" if margin.resolution else ""
    if not changes:
        return f"no change with {symbol} from {low:.6g} to {high:.6g}{steps}"
    end = ""
    if math.isinf(margin.below) and low < here:
        end = f", none lower down to {low:.6g}"
    elif math.isinf(margin.above):
        end = f", none higher up to {high:.6g}"
    return f"changes with {symbol} {' and '.join(changes)}{end}{steps}"


def _indistinct(here: float) -> float:
    """Return the distance from a number below which a search tells nothing."""
    return 1e-9 * max(1.0, abs(here))


def forcing_margin(verdict: Stability) -> Margin:
    """Return how far the magnitude of the forcing may fall, to none, or rise until the verdict changes."""
    forcing, _ = _FORCING[type(verdict.equation)]
    return _margin(verdict, forcing, abs(getattr(verdict.equation, forcing)), (0.0, _top(verdict.equation)))


def mean_margin(verdict: Stability) -> Margin:
    """Return how far the mean may fall or rise until the verdict changes."""
    _, mean = _FORCING[type(verdict.equation)]
    here, room = getattr(verdict.equation, mean), _room(verdict.equation)
    margin = _margin(verdict, mean, here, (here - room, here + room))
    # Without damping the number of transition curves below the mean rises with it, so that none is passed over.
    return Margin(*margin, searched=margin.searched, errors=margin.errors) if _is_counted(verdict) else margin


def _margin(verdict: Stability, name: str, here: float, within: tuple[float, float]) -> Margin:
    """Return how far one number may fall or rise until the verdict, or without damping the tongue, is another."""
    counted = _is_counted(verdict)

    def status(value: float) -> str:
        at = stability(replace(verdict.equation, **{name: value}))
        return f"{at.status} {at.interval}" if counted and at.status != "undecided" else at.status

    own = f"{verdict.status} {verdict.interval}" if counted else verdict.status
    below, above = (status_change(status, own, (here, end), _SAMPLES) for end in within)
    return Margin.between(below, above, here)


def _is_counted(verdict: Stability) -> bool:
    """Return whether the tongue tells between which transition curves the equation lies."""
    forcing, _ = _FORCING[type(verdict.equation)]
    forced = getattr(verdict.equation, forcing) != 0.0
    return forced and verdict.equation.damping == 0.0 and verdict.interval is not None


def charted_ranges(equation: Equation) -> dict[str, tuple[float, float]]:
    """Return the forcing and the mean about the equation, by their names; none where a chart would take long."""
    names = _FORCING.get(type(equation))
    if names is None or any(abs(getattr(equation, name)) > _CHARTED for name in names):
        return {}
    forcing, mean = (getattr(equation, name) for name in names)
    top = _top(equation)
    room = _room(equation)
    ends = (0.0, top) if forcing >= 0.0 else (-top, 0.0)
    return dict(zip(names, (ends, (mean - room, mean + room)), strict=True))


def _top(equation: Equation) -> float:
    """Return the magnitude of the forcing up to which is searched and drawn."""
    forcing, mean = (abs(getattr(equation, name)) for name in _FORCING[type(equation)])
    return float(max(_REACH * forcing, 1.0 + mean))


def _room(equation: Equation) -> float:
    """Return how far from the mean is searched and drawn: three times the first resonance at least."""
    forcing = abs(getattr(equation, _FORCING[type(equation)][0]))
    return float(max(2.0 * forcing, 3.0 * (math.pi / float(equation.period)) ** 2))
