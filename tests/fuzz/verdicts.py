"""Verdicts, growth and discriminants against the oracle, and beside boundaries against thirty digits."""

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np

import floquetrod as fr
from floquetrod.floquet.registry import applicable, is_approximation
from tests.fuzz import oracle, precise, rods
from tests.fuzz.core import Found, limit

CASES = 40
QUICK = 2

AT_ONCE = 500
"""Equations of a case that go through the functions over arrays."""

_ROUNDED = 1e-5  # growth beside a curve that rounding explains: 1e-10 of the excess, of which it is the root
_RESOLVED = 1e-9  # distance to a boundary, relative, from which a double has to decide


def check(rng: np.random.Generator) -> Found:
    """Compare arrays with the oracle, then one equation, by all methods, with thirty digits."""
    failures = over_arrays(rng) + beside_curves(rng)
    equation = draw(rng)
    failures += [f"{equation!r}: {wrong}" for wrong in one(equation)]
    return Found(2 * AT_ONCE + 1, failures)


def over_arrays(rng: np.random.Generator) -> list[str]:
    """Compare verdict and growth of Mathieu's equation at random points, half of them beside curves."""
    alpha = np.exp(rng.uniform(math.log(1e-6), math.log(60.0), AT_ONCE)) * rng.choice([-1.0, 1.0], AT_ONCE)
    beta = rng.uniform(-60.0, 5.0, AT_ONCE)
    orders = rng.integers(0, 8, AT_ONCE)
    near = rng.random(AT_ONCE) < 0.5
    curve = -0.25 * fr.mathieu.characteristic_values(orders, 2.0 * alpha, "a")
    beta[near] = (curve + 10.0 ** rng.uniform(-7.0, -1.0, AT_ONCE) * rng.choice([-1.0, 1.0], AT_ONCE))[near]
    c = np.where(rng.random(AT_ONCE) < 0.5, 0.0, 10.0 ** rng.uniform(-6.0, 0.5, AT_ONCE))
    truth = oracle.growth(alpha, beta + c * c)
    stable, rate = fr.mathieu.is_stable(alpha, beta, c), fr.mathieu.growth_rate(alpha, beta, c)
    slack = 1e-12 + 1e-12 * np.abs(truth.middle)
    low, high = truth.low - c - slack, truth.high - c + slack
    wrong = (
        (stable & (low > 0.0))
        | (~stable & (high < 0.0))
        | (rate < np.minimum(low, 1e9))
        | (rate > np.maximum(high, 0.0))
    )
    return [
        f"Mathieu({float(alpha[i])!r}, {float(beta[i])!r}, {float(c[i])!r}): is_stable {bool(stable[i])}, growth "
        f"{float(rate[i])!r}, the oracle has {float(low[i])!r} to {float(high[i])!r}"
        for i in np.flatnonzero(wrong)[:3]
    ]


def beside_curves(rng: np.random.Generator) -> list[str]:
    """Compare verdict and growth, of arrays and of single points, a few units of rounding from transition curves."""
    alpha = np.exp(rng.uniform(math.log(1e-3), math.log(1e4), AT_ONCE))
    crests = np.sqrt(2.0 * alpha)  # about as many curves lie below those of the coefficient
    orders = (rng.uniform(0.0, 1.0, AT_ONCE) * (2.0 + 1.4 * crests)).astype(int)
    beta = -0.25 * np.where(
        rng.random(AT_ONCE) < 0.5,
        fr.mathieu.characteristic_values(orders, 2.0 * alpha, "a"),
        fr.mathieu.characteristic_values(orders + 1, 2.0 * alpha, "b"),
    )
    beta += rng.integers(-8, 9, AT_ONCE) * np.spacing(beta)
    c = np.where(rng.random(AT_ONCE) < 0.5, 0.0, 10.0 ** rng.uniform(-6.0, 0.0, AT_ONCE))
    beta -= c * c
    rate = fr.mathieu.growth_rate(alpha, beta, c)
    stable = fr.mathieu.is_stable(alpha, beta, c)
    for i in range(0, AT_ONCE, 50):
        stable[i] = fr.mathieu.is_stable(float(alpha[i]), float(beta[i]), float(c[i]))
    return disagreements(alpha, beta, c, stable, rate)


def disagreements(alpha: Any, beta: Any, c: Any, stable: Any, rate: Any) -> list[str]:
    """Return where a verdict of stable stands beside growth that no rounding explains."""
    return [
        f"Mathieu({float(alpha[i])!r}, {float(beta[i])!r}, {float(c[i])!r}) is stable and grows at {float(rate[i])!r}"
        for i in np.flatnonzero(stable & (rate > _ROUNDED))[:3]
    ]


def draw(rng: np.random.Generator) -> Any:
    """Return an equation of any kind, weak, strong or beside a boundary, damped or not."""
    c = float(rng.choice([0.0, rods.decades(rng, 1e-6, 0.5)]))
    alpha = rods.decades(rng, 1e-9, 20.0) * float(rng.choice([-1.0, 1.0]))
    beta = float(rng.uniform(-20.0, 2.0))
    kind = rng.random()
    if kind < 0.4:
        if rng.random() < 0.6:
            curve = -0.25 * float(fr.mathieu.characteristic_values(int(rng.integers(0, 6)), 2.0 * alpha, "a"))
            beta = curve + rods.decades(rng, 1e-15, 1e-3) * float(rng.choice([-1.0, 0.0, 1.0]))
        return fr.Mathieu(alpha, beta, c)
    if kind < 0.7:
        return fr.Meissner(float(rng.choice([alpha, beta, -beta])), beta, c)
    terms = [tuple(map(float, rng.uniform(-3.0, 3.0, int(rng.integers(0, 4))))) for _ in range(2)]
    period = 2.0 * math.pi * float(rng.choice([1.0, rods.decades(rng, 0.2, 3.0)]))
    return fr.Hill(float(rng.uniform(-6.0, 1.0)), *terms, period=period, damping=c)


def exact(equation: Any) -> tuple[Any, Any]:
    """Return net growth and (abs(D_u) - 2) / 4 of the equation freed of its damping, with thirty digits."""
    c = equation.damping
    period = equation.period if isinstance(equation, fr.Hill) else None  # a double; of the others the exact 2 pi
    if isinstance(equation, fr.Meissner):
        x = precise.square_excess(equation.alpha, equation.beta, c)
    else:
        hill = equation.as_hill()
        x = precise.excess(hill.mean, hill.harmonics, period, c)
    with mpmath.workdps(30):
        undamped = 2 * mpmath.asinh(mpmath.sqrt(x)) / precise.exact_length(period) if x > 0 else mpmath.mpf(0)
        return undamped - c, x


def one(equation: Any) -> list[str]:
    """Return what is wrong about the verdicts of every method on one equation, `certify` included."""
    rate, x = exact(equation)
    wrong = []
    for method in applicable(equation):
        with limit():
            wrong += [f"{method.name}: {what}" for what in judged(fr.stability(equation, method.name), rate, x)]
    with limit():
        wrong += [f"auto: {what}" for what in judged(fr.stability(equation), rate, x, decides=True)]
        proof = fr.certify(equation)
    if proof.status not in ("undecided", _truth(rate, x, equation.damping)):
        wrong.append(f"certify proves {proof.status}, growth is {mpmath.nstr(rate, 8)}")
    return wrong


def _truth(rate: Any, x: Any, damping: float) -> str:
    if damping > 0.0:
        return "unstable" if rate > 0 else "stable"
    return "unstable" if x > 0 else "stable"


def judged(result: fr.results.Stability, rate: Any, x: Any, decides: bool = False) -> list[str]:
    """Compare one verdict with the truth."""
    wrong = []
    damping = result.equation.damping
    truth = _truth(rate, x, damping)
    sees_all = not is_approximation(result.equation, result.method)
    if sees_all and result.status not in ("undecided", truth):
        wrong.append(f"{result.status}, growth is {mpmath.nstr(rate, 8)}")
    clear = abs(x) > _RESOLVED if damping == 0.0 else abs(rate) > _RESOLVED
    if decides and result.status == "undecided" and clear:
        wrong.append(f"undecided, growth is {mpmath.nstr(rate, 8)}, X {mpmath.nstr(x, 8)}")
    numbers = (result.growth_rate, result.discriminant, result.log_abs_discriminant, result.error)
    if any(map(math.isnan, numbers)):
        wrong.append(f"NaN among growth, discriminant, its logarithm and error: {numbers}")
    elif sees_all and math.isfinite(result.discriminant):
        with mpmath.workdps(30):
            length = precise.exact_length(result.period if isinstance(result.equation, fr.Hill) else None)
            size = (2 + 4 * x) * mpmath.exp(-damping * length)
            off = abs(abs(result.discriminant) - abs(size)) / max(1, abs(size))
        if off > result.error:
            wrong.append(f"states an error of {result.error:.3g}, has {mpmath.nstr(off, 3)}")
    return wrong
