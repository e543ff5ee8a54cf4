"""A verdict on one equation in a sentence: how fast it grows, which damping stabilises it, which forcing changes it."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import Any

from floquetrod.equations import Equation, Mathieu, MathieuAQ, Meissner
from floquetrod.floquet.margins import Margin, margin
from floquetrod.floquet.verdict import Stability, rate_in_words

_FORCING = {MathieuAQ: ("q", "a"), Mathieu: ("alpha", "beta"), Meissner: ("alpha", "beta")}
"""Names of forcing and mean in equations whose verdict does not depend on the forcing's sign."""

_LARGEST = 1e4  # forcing and mean up to which the margin and the damping take a second at most (measured)
_CHARTED = 100.0  # forcing and mean up to which a chart takes some seconds (measured)
_REACH = 4.0  # times the forcing: how far changes are searched (a choice)


def in_one_line(verdict: Stability) -> str:
    """Return the verdict, its growth or decay, the damping that stabilises and the margin in the forcing."""
    unit, sentence = f"per unit {verdict.unit}", verdict.status.upper()
    if verdict.status == "unstable":
        sentence += f": grows {rate_in_words(verdict.growth_rate)} {unit}"
        sentence += f", tenfold in {verdict._tenfold}" if verdict.growth_rate > 0.0 else ""
    elif verdict.status == "stable":
        rate = verdict.decay_rate
        sentence += f": decays at {rate:.6g} {unit}" if rate > 0.0 else ": every motion stays bounded"
    else:
        sentence += ": growth cannot be distinguished from none"
    changes = [damping_in_words(verdict), margin_in_words(verdict)] if has_quick_margins(verdict.equation) else []
    return "; ".join(filter(None, [sentence, *changes]))


def has_quick_margins(equation: Equation) -> bool:
    """Return whether damping and forcing that change the verdict are found in about a second."""
    names = _FORCING.get(type(equation))
    return names is not None and all(abs(getattr(equation, name)) <= _LARGEST for name in names)


def damping_in_words(verdict: Stability) -> str:
    """Return the damping that stabilises an unstable equation; "" where none is needed or none is known."""
    if verdict.status != "unstable" or not (more := verdict.damping_to_stabilise) > 0.0:
        return ""
    if math.isinf(more):
        return "strong damping does not stabilise it, as the mean coefficient alone is unstable; weak damping may"
    present = verdict.equation.damping
    added = f", {more:.6g} more" if present else ""
    return f"stable with a damping above {present + more:.6g} per unit {verdict.unit}{added}"


def margin_in_words(verdict: Stability) -> str:
    """Return the forcing at which the verdict changes, lower and higher; "" where the equation has no such number."""
    names = _FORCING.get(type(verdict.equation))
    if names is None or verdict.status == "undecided":
        return ""
    name, here = names[0], abs(getattr(verdict.equation, names[0]))
    distances = forcing_margin(verdict.equation)
    low, high = here - distances.searched[0], here + distances.searched[1]
    changes = []
    least = 1e-9 * max(1.0, here)  # below what the search tells from none
    if distances.below < least or distances.above < least:
        return f"on a boundary: changes with {name} as soon as its magnitude differs from {here:.6g}"
    if math.isfinite(distances.below):
        changes.append(f"at {low:.6g} ({distances.below:.4g} lower)")
    if math.isfinite(distances.above):
        changes.append(f"at {high:.6g} ({distances.above:.4g} higher)")
    symbol = name if getattr(verdict.equation, name) >= 0.0 else f"-{name}"
    if not changes:
        return f"no change with {symbol} from {low:.6g} to {high:.6g}, in steps of {distances.resolution:.2g}"
    end = "" if len(changes) == 2 else ", not higher" if math.isinf(distances.above) else ", not lower"
    end += f" up to {high:.6g}" if math.isinf(distances.above) else ""
    return f"changes with {symbol} {' and '.join(changes)}{end}, in steps of {distances.resolution:.2g}"


def forcing_margin(equation: Any) -> Margin:
    """Return how far the magnitude of the forcing may fall, to none, or rise until the verdict changes."""
    name = _FORCING[type(equation)][0]
    return margin(partial(replace, equation), name, (0.0, _top(equation)), **{name: abs(getattr(equation, name))})


def charted_ranges(equation: Equation) -> dict[str, tuple[float, float]]:
    """Return the forcing and the mean about the equation, by their names; none where a chart would take long."""
    names = _FORCING.get(type(equation))
    if names is None or any(abs(getattr(equation, name)) > _CHARTED for name in names):
        return {}
    forcing, mean = (getattr(equation, name) for name in names)
    top = _top(equation)
    room = max(2.0 * abs(forcing), 3.0 * (math.pi / float(equation.period)) ** 2)  # three times the first resonance
    ends = (0.0, top) if forcing >= 0.0 else (-top, 0.0)
    return dict(zip(names, (ends, (mean - room, mean + room)), strict=True))


def _top(equation: Equation) -> float:
    """Return the magnitude of the forcing up to which is searched and drawn."""
    forcing, mean = (abs(getattr(equation, name)) for name in _FORCING[type(equation)])
    return float(max(_REACH * forcing, 1.0 + mean))
