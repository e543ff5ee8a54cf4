"""How much noise a system tolerates: the largest intensity at which its second moments do not grow."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod.equations import DelayedMoments, DelaySystem, Equation, SecondMoments, second_moments
from floquetrod.equations.delayed_moments import delayed_moments
from floquetrod.equations.matrices import require_one
from floquetrod.equations.second_moments import balanced_moments
from floquetrod.floquet.dispatch import judge, run, stability
from floquetrod.floquet.first_change import root_below, separation
from floquetrod.floquet.multipliers import renewal_equation
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.problems import Problem

_FARTHEST = 1e8  # intensities tried, in terms of what the decay rate suggests (a choice)
_NEAREST = 1e-12  # of verdicts on both sides, relative (a choice: what doubles decide)
_SILENT = "noise must have an intensity above zero and a matrix that is not zero, got none"


@dataclass(frozen=True, eq=False)
class CriticalNoise(ByContent, NoTruthValue):
    """The largest intensity of noise at which a system is stable in mean square.

    Attributes
    ----------
    factor : float
        By which the intensities that were given, all of them, may be multiplied; infinite where no change was found.
    error : float
        Of the factor: with ``factor - error`` the verdict is stable, with ``factor + error`` unstable.
    below : SystemStability or None
        Verdict with ``factor - error``; None where the factor is infinite.
    above : SystemStability or None
        That with ``factor + error``.
    searched : float
        Factor up to which a change was searched for.
    """

    factor: float
    error: float
    below: SystemStability | None
    above: SystemStability | None
    searched: float

    ask = ".factor, the largest factor of the intensities that is stable"


def critical_noise(system: Problem, noise: Any, interpretation: str = "ito") -> CriticalNoise:
    """Return the largest noise at which a system is still stable in mean square.

    Second moments grow faster with stronger noise, since their map keeps matrices positive semidefinite: in Ito's sense
    there is exactly one change.  In Stratonovich's noise may stabilise; there the first is found among factors that
    double from an estimate by the decay rate.

    With delays the factor is one over the root of the spectral radius of a renewal equation, found once.

    Parameters
    ----------
    system : Equation, HillSystem, PeriodicSystem or DelaySystem
        One system, whose motion decays without noise.
    noise : sequence of (matrix, intensity), or float
        As in `floquetrod.second_moments`, with delays as in `floquetrod.stability`; one intensity at least is not zero.
    interpretation : {"ito", "stratonovich"}
        Of the noise.  With delays and equations of first order "ito" alone.

    Returns
    -------
    CriticalNoise
        The factor of the intensities, between two verdicts, mostly to 1e-11.

    Raises
    ------
    TypeError, ValueError
        As `floquetrod.second_moments`, and where the motion does not decay without noise.

    Examples
    --------
    y'' + 0.2 y' + y = s y xi: s^2 = 0.4.

    >>> import floquetrod as fr
    >>> round(fr.critical_noise(fr.HillSystem([[1.0]], damping=[[0.2]]), [([[1.0]], 1.0)]).factor ** 2, 9)
    0.4
    """
    moments: Callable[[float], SecondMoments | DelayedMoments]
    if isinstance(system, DelaySystem):
        factor, error, moments = _of_delayed(system, noise, interpretation)
        searched = factor
    else:
        factor, searched, moments = _searched(system, noise, interpretation)
        error = 0.0
    if math.isinf(factor):
        return CriticalNoise(math.inf, math.inf, None, None, searched)
    if math.isnan(factor):
        raise ValueError("noise must have a largest stable intensity that growth can tell, got none: it is not known")
    verdicts: list[SystemStability] = []

    def is_apart(apart: float) -> bool:
        verdicts[:] = (judge(moments(factor * (1.0 + sign * apart))) for sign in (-1.0, 1.0))
        return [verdict.stable for verdict in verdicts] == [True, False]

    apart = separation(is_apart, max(_NEAREST, error / factor))
    if apart >= 0.5:
        raise ValueError("noise must have a largest stable intensity that verdicts can determine, got none")
    below, above = verdicts
    return CriticalNoise(factor, apart * factor, below, above, searched)


def _searched(
    system: Problem, noise: Any, interpretation: str
) -> tuple[float, float, Callable[[float], SecondMoments]]:
    """Return the first factor at which moments grow, the factor up to which it was searched, and the moments."""
    whole = second_moments(system, noise, interpretation)
    if not isinstance(system, Equation):
        require_one(system)
    if whole.shape:
        raise ValueError(f"noise must have one intensity for each source, got a batch of shape {whole.shape}")
    noiseless = _noiseless(system)

    def moments(factor: float) -> SecondMoments:
        return balanced_moments(system, _scaled(system, noise, factor), interpretation)

    def growth(factor: float) -> float:
        return float(run("monodromy", moments(factor)).highest_rate)

    size = float(np.abs(whole.mean - second_moments(system, _scaled(system, noise, 0.0), interpretation).mean).max())
    if size == 0.0:
        raise ValueError(_SILENT)
    first = math.sqrt(noiseless.decay_rate / size)
    high = first
    while not growth(high) > 0.0:
        high *= 2.0
        if high > _FARTHEST * first:
            return math.inf, 0.5 * high, moments
    return root_below(growth, high, _FARTHEST), high, moments


def _of_delayed(
    system: DelaySystem, noise: Any, interpretation: str
) -> tuple[float, float, Callable[[float], DelayedMoments]]:
    """Return the factor at which moments of a system with delays begin to grow, its error, and the moments."""
    whole = delayed_moments(system, noise, interpretation)
    if interpretation != "ito" and not system.is_second_order:
        raise ValueError(
            f"interpretation must be 'ito' for the critical noise of delayed equations of first order, got "
            f"{interpretation!r}; fr.stability takes both"
        )
    _noiseless(system)
    if not any(s.intensity and (s.present.any() or any(m.any() for _, m in s.delayed)) for s in whole.noise):
        raise ValueError(_SILENT)
    found = renewal_equation.refined(whole, lambda equation, _: equation.radius(0.0))
    if found is None or not math.isfinite(found.value) or not found.error < found.value:
        known = found is not None and found.value == 0.0
        return math.inf if known else math.nan, math.inf, whole.times
    factor = found.value**-0.5
    return factor, 0.5 * factor * found.error / found.value, whole.times


def _noiseless(system: Problem) -> Any:
    """Return the verdict without noise, on a system that decays."""
    verdict: Any = stability(system)
    if not verdict.decay_rate > 0.0:
        raise ValueError(f"system must decay without noise to have a critical one, got one that is {_told(verdict)}")
    return verdict


def _scaled(system: Problem, noise: Any, factor: float) -> Any:
    """Return noise of intensities multiplied by a factor."""
    if isinstance(system, Equation) and not validate.iterable(noise):
        return factor * float(noise)
    return [(matrix, factor * np.asarray(intensity, dtype=float)) for matrix, intensity in noise]


def _told(verdict: Any) -> str:
    return "only bounded; give it damping" if verdict.stable else f"{verdict.status}: {verdict!r}"
