"""Random systems of every structure, the same systems written otherwise, and their maps by an integrator of scipy."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import floquetrod as fr
from floquetrod.equations import Varying
from tests.fuzz.rods import decades

System = fr.HillSystem | fr.PeriodicSystem
Array = NDArray[np.float64]

KINDS = (
    *("hamiltonian", "gyroscopic", "damped", "evenly damped", "massive", "massive and gyroscopic", "identical"),
    *("nearly identical", "follower", "general", "first order", "canonical", "function", "constant", "uncoupled"),
)

_MANTISSA = 20  # binary digits of the parameters: what is then doubled, or divided by 4, stays exact


def short(values: Any) -> Any:
    """Return numbers with few digits, so that sums and products of two of them are exact."""
    array = np.asarray(values, dtype=float)
    _, exponent = np.frexp(array)
    step = np.ldexp(1.0, exponent - _MANTISSA)
    return np.round(array / step) * step


def symmetric(rng: np.random.Generator, n: int, size: float) -> Array:
    """Return a random symmetric matrix."""
    matrix = rng.normal(size=(n, n))
    return np.asarray(short(0.5 * size * (matrix + matrix.T)))


def draw(rng: np.random.Generator, most: int = 6) -> System:
    """Return a system of any kind, weakly or strongly forced; every third at a boundary, to a double or nearly."""
    system = anywhere(rng, str(rng.choice(KINDS)), most)
    if rng.random() < 0.25:
        system = jumping(system, rng)
    if rng.random() < 0.35 and not system.is_constant:
        system = at_a_boundary(system, rng) or system
    return system


def anywhere(rng: np.random.Generator, kind: str, most: int) -> System:
    """Return a system of this kind."""
    n = int(rng.integers(1, most + 1))
    size, period = decades(rng, 1e-6 if rng.random() < 0.2 else 1e-3, 5.0), 2.0 * math.pi / decades(rng, 0.5, 5.0)
    count = int(rng.choice([1, 1, 2, 3]))
    turn = np.linalg.qr(rng.normal(size=(n, n)))[0] if rng.random() < 0.8 else np.eye(n)
    stiffness = (turn * rng.uniform(0.2, 3.0, n) ** 2) @ turn.T
    if rng.random() < 0.15:
        stiffness = stiffness - rng.uniform(0.0, 3.0) * np.eye(n)
    stiffness = short(0.5 * (stiffness + stiffness.T))
    cosines = [symmetric(rng, n, size / k) for k in range(1, count + 1)]
    sines = [symmetric(rng, n, size / k) for k in range(1, count + 1)] if rng.random() < 0.4 else []
    given: dict[str, Any] = {"period": period}
    factor, skew = rng.normal(size=(n, n)), short(rng.normal(size=(n, n)) * decades(rng, 0.1, 3.0))
    if kind in ("gyroscopic", "massive and gyroscopic"):
        given["gyroscopic"] = skew - skew.T
    if kind in ("massive", "massive and gyroscopic"):
        mass = short(factor @ factor.T + np.eye(n))
        given["mass"] = 0.5 * (mass + mass.T)
    if kind == "damped":
        damping = short(factor @ factor.T * decades(rng, 1e-4, 0.5))
        given["damping"] = 0.5 * (damping + damping.T)
    if kind == "evenly damped":
        given["damping"] = short(decades(rng, 1e-4, 0.5)) * np.eye(n)
    if kind in ("identical", "nearly identical"):
        stiffness, cosines, sines = stiffness[0, 0] * np.eye(n), [m[0, 0] * np.eye(n) for m in cosines], []
    if kind == "nearly identical":
        stiffness = stiffness + np.diag(rng.normal(size=n) * decades(rng, 1e-15, 1e-6))
    if kind == "follower":
        stiffness, sines = stiffness + short(rng.normal(size=(n, n)) * decades(rng, 1e-3, 1.0)), []
    if kind == "general":
        stiffness = stiffness + short(rng.normal(size=(n, n)) * 0.3)
        given["damping"] = short(rng.normal(size=(n, n)) * 0.1)
    if kind == "uncoupled":
        stiffness, cosines, sines = (
            np.diag(np.diag(stiffness)),
            *([np.diag(np.diag(m)) for m in s] for s in (cosines, sines)),
        )
    if kind == "constant":
        cosines, sines = [], []
        if rng.random() < 0.5:
            given["gyroscopic"] = skew - skew.T
    if kind == "canonical":
        unit = np.block([[np.zeros((n, n)), np.eye(n)], [-np.eye(n), np.zeros((n, n))]])
        mean, *waves = (symmetric(rng, 2 * n, s) for s in (1.0, *[size] * count))
        return fr.PeriodicSystem(unit @ mean, [unit @ m for m in waves], period=period)
    if kind in ("first order", "function"):
        mean = short(0.5 * rng.normal(size=(n, n)) - rng.uniform(0.0, 1.5) * np.eye(n))
        waves = [short(min(size, 2.0) * rng.normal(size=(n, n))) for _ in range(count)]
        if kind == "first order":
            return fr.PeriodicSystem(mean, waves[:1], waves[1:], period=period)
        return fr.PeriodicSystem.from_function(functools.partial(bumps, mean, waves, period), period)
    return fr.HillSystem(stiffness, cosines, sines, **given)


def bumps(mean: Array, waves: list[Array], period: float, t: float) -> Array:
    """Return a matrix that varies with many harmonics."""
    wave = math.cos(2.0 * math.pi * t / period)
    return np.asarray(mean + sum(m / (1.5 + wave) ** k for k, m in enumerate(waves, start=1)))


def jumping(system: System, rng: np.random.Generator) -> System:
    """Return a system whose matrix jumps between pieces of the period; some of them slope, or have harmonics too."""
    mean = np.asarray(getattr(system, system.MEAN))
    waves = [*system.cosines, *system.sines] or [short(0.1 * mean)]
    durations = short(rng.uniform(0.1, 1.0, int(rng.integers(2, 5))) * system.period)
    pieces = []
    for duration in durations.tolist():
        level = short(mean + float(short(rng.uniform(-2.0, 2.0))) * waves[0])
        slope = short(rng.uniform(-1.0, 1.0) / duration) * waves[-1] if rng.random() < 0.3 else None
        pieces.append((duration, Varying(None, slope, waves[:1] if rng.random() < 0.2 else [], start=level)))
    if rng.random() < 0.3:
        pieces = [(duration, Varying(value.start)) for duration, value in (*pieces, *pieces[::-1])]  # even
    return rewritten(system, pieces=pieces)


def forced(system: System, factor: float) -> System:
    """Return the system with all that varies multiplied."""
    if system.pieces:
        mean = np.asarray(getattr(system, system.MEAN))
        return mapped(system, lambda m: mean + factor * (m - mean), lambda m: factor * m)
    series = ([factor * m for m in system.cosines], [factor * m for m in system.sines])
    return rewritten(system, cosines=series[0], sines=series[1])


def rewritten(system: System, **changes: Any) -> System:
    """Return the system with some of its parameters replaced."""
    if system.pieces or "pieces" in changes:
        longer = changes.pop("period", system.period) / system.period
        if longer != 1.0:
            changes["pieces"] = [(longer * duration, value) for duration, value in system.pieces]
        kept = ("mass", "damping", "gyroscopic", "coefficient_error", "pieces")
        made = {name: getattr(system, name) for name in kept if hasattr(system, name)} | changes
        return type(system).from_pieces(made.pop("pieces"), **made)
    names = ("cosines", "sines", "period")
    if isinstance(system, fr.PeriodicSystem):
        given = {name: getattr(system, name) for name in ("mean", "coefficient_error", *names)}
        return fr.PeriodicSystem(**given | changes)
    given = {name: getattr(system, name) for name in ("stiffness", "mass", "damping", "gyroscopic", *names)}
    return fr.HillSystem(**given | changes)


def mapped(
    system: System, mean: Callable[[Array], Array], others: Callable[[Array], Array], fast: float = 1.0
) -> System:
    """Return a system in pieces with functions applied to the matrices of each, and with durations divided."""
    return rewritten(
        system, pieces=[(duration / fast, value.mapped(mean, others)) for duration, value in system.pieces]
    )


def at_a_boundary(system: System, rng: np.random.Generator) -> System | None:
    """Return the system with a forcing at which its verdict changes, or beside it; None where none is found."""
    low, high = None, None
    for factor in decades_of(rng, 0.01, 10.0, 8):
        status = fr.stability(forced(system, factor), "monodromy").status
        low, high = (factor if status == "stable" else low), (factor if status == "unstable" else high)
    if low is None or high is None:
        return None
    for _ in range(60):
        middle = 0.5 * (low + high)
        status = fr.stability(forced(system, middle), "monodromy").status
        if status == "undecided":
            break
        low, high = (middle, high) if status == "stable" else (low, middle)
    return forced(system, 0.5 * (low + high) * (1.0 + decades(rng, 1e-16, 1e-2) * float(rng.choice([-1.0, 1.0]))))


def decades_of(rng: np.random.Generator, low: float, high: float, count: int) -> list[float]:
    """Return several numbers, uniform in their logarithms."""
    return [decades(rng, low, high) for _ in range(count)]


def alike(system: System, rng: np.random.Generator) -> Iterator[tuple[str, System, float]]:
    """Yield the system written otherwise, exactly: what was done, the system, and by what its time runs faster."""
    if system.pieces:
        yield from alike_in_pieces(system, rng)
        return
    n = system.order

    def both(change: Callable[[Array], Array]) -> dict[str, Any]:
        names = ("mean",) if isinstance(system, fr.PeriodicSystem) else ("stiffness", "mass", "damping", "gyroscopic")
        found: dict[str, Any] = {k: None if (m := getattr(system, k)) is None else change(m) for k in names}
        return found | {k: [change(m) for m in getattr(system, k)] for k in ("cosines", "sines")}

    def turned(signs: tuple[float, float]) -> dict[str, Any]:
        return {
            name: [m if k % 2 else sign * m for k, m in enumerate(getattr(system, name))]
            for name, sign in zip(("cosines", "sines"), signs, strict=True)
        }

    half = {name: [(-1.0) ** k * m for k, m in enumerate(getattr(system, name), 1)] for name in ("cosines", "sines")}
    yield "half a period later", rewritten(system, **half), 1.0
    order, signs = rng.permutation(n), rng.choice([-1.0, 1.0], n)
    yield "in another order", rewritten(system, **both(lambda m: m[np.ix_(order, order)])), 1.0
    yield "with other signs", rewritten(system, **both(lambda m: signs[:, None] * m * signs)), 1.0
    back = {"sines": [-m.T for m in system.sines], "cosines": [m.T for m in system.cosines]}
    names = ("mean",) if isinstance(system, fr.PeriodicSystem) else ("stiffness", "damping", "gyroscopic")
    others = {k: None if (m := getattr(system, k)) is None else m.T for k in names}
    yield "adjoint, backwards", rewritten(system, **back, **others), 1.0
    fast = float(2.0 ** rng.integers(-20, 21))
    if isinstance(system, fr.PeriodicSystem):
        faster = both(lambda m: fast * m) | {"coefficient_error": fast * system.coefficient_error}
        yield "in another unit of time", rewritten(system, **faster, period=system.period / fast), fast
        units = 2.0 ** rng.integers(-3, 4, n)
        if not system.coefficient_error:
            yield "in other units", rewritten(system, **both(lambda m: units[:, None] * m / units)), 1.0
        return
    series = {k: [fast * fast * m for m in getattr(system, k)] for k in ("cosines", "sines")}
    speeds = {k: None if (m := getattr(system, k)) is None else fast * m for k in ("damping", "gyroscopic")}
    faster = series | speeds | {"stiffness": fast * fast * system.stiffness, "period": system.period / fast}
    yield "in another unit of time", rewritten(system, **faster), fast
    heavier = both(lambda m: 0.125 * m)
    heavier["mass"] = 0.125 * (np.eye(n) if system.mass is None else system.mass)
    yield "in another unit of mass", rewritten(system, **heavier), 1.0
    units = 2.0 ** rng.integers(-3, 4, n)
    scaled = both(lambda m: units[:, None] * m * units)
    scaled["mass"] = units[:, None] * (np.eye(n) if system.mass is None else system.mass) * units
    yield "in other units", rewritten(system, **scaled), 1.0


def alike_in_pieces(system: System, rng: np.random.Generator) -> Iterator[tuple[str, System, float]]:
    """Yield a system in pieces written otherwise, as `alike` does."""
    n = system.order
    speeds = [name for name in ("damping", "gyroscopic") if getattr(system, name, None) is not None]
    masses = ["mass"] if getattr(system, "mass", None) is not None else []

    def every(change: Callable[[Array], Array]) -> System:
        others = {name: change(getattr(system, name)) for name in (*speeds, *masses)}
        return rewritten(mapped(system, change, change), **others)

    order, signs = rng.permutation(n), rng.choice([-1.0, 1.0], n)
    yield "in another order", every(lambda m: m[np.ix_(order, order)]), 1.0
    yield "with other signs", every(lambda m: signs[:, None] * m * signs), 1.0
    if all(value.is_constant for _, value in system.pieces):
        yield "from the next piece on", rewritten(system, pieces=[*system.pieces[1:], system.pieces[0]]), 1.0
    fast = float(2.0 ** rng.integers(-20, 21))
    power = fast if isinstance(system, fr.PeriodicSystem) else fast * fast
    faster = [
        (
            duration / fast,
            Varying(
                None,
                fast * power * value.slope_or_zero,
                [power * m for m in value.cosines],
                start=power * value.start,
            ),
        )
        for duration, value in system.pieces
    ]
    changes = {name: fast * getattr(system, name) for name in speeds} | {
        "coefficient_error": power * system.coefficient_error
    }
    yield "in another unit of time", rewritten(system, pieces=faster, **changes), fast


def integrated(system: System) -> Array:
    """Return the map over a period by DOP853, from the definition of the system alone."""
    pieces = system.pieces or (
        (system.period, Varying(getattr(system, system.MEAN), None, system.cosines, system.sines)),
    )
    product, begin = np.eye(system.order * (1 if isinstance(system, fr.PeriodicSystem) else 2)), 0.0
    for duration, value in pieces:
        product = _over_piece(system, value, begin, float(duration)) @ product
        begin += float(duration)
    return product


def _over_piece(system: System, value: Varying, begin: float, duration: float) -> Array:
    """Return the map over a piece that begins some time after the period."""
    w, zero = 2.0 * math.pi / system.period, np.zeros((system.order, system.order))

    def varying(t: float) -> Array:
        waves = [m * math.cos(k * w * (begin + t)) for k, m in enumerate(value.cosines, start=1)]
        waves += [m * math.sin(k * w * (begin + t)) for k, m in enumerate(value.sines, start=1)]
        return np.asarray(value.start + t * value.slope_or_zero + sum(waves, zero))

    if isinstance(system, fr.PeriodicSystem):
        first, size = varying, system.order
    else:
        n = system.order
        size, inverse = 2 * n, np.eye(n) if system.mass is None else np.linalg.inv(system.mass)
        drag = sum((m for m in (system.damping, system.gyroscopic) if m is not None), zero)

        def first(t: float) -> Array:
            lower = [-inverse @ varying(t), -inverse @ drag]
            return np.block([[zero, np.eye(n)], lower])

    def slope(t: float, x: Array) -> Array:
        return np.asarray((first(t) @ x.reshape(size, size)).ravel())

    done = solve_ivp(slope, (0.0, duration), np.eye(size).ravel(), method="DOP853", rtol=1e-12, atol=1e-14)
    return np.asarray(done.y[:, -1].reshape(size, size))
