"""Verdicts, growth rates and discriminants over arrays; one call; the start of the program.  All on one thread."""

from __future__ import annotations

import subprocess
import sys

import numpy as np

import floquetrod as fr
from benchmarks import peers
from benchmarks.measure import Row, best_of

STANDARD = np.linspace(0.0, 5.0, 100), np.linspace(-4.0, 1.0, 100)
HARD = np.linspace(0.5, 400.0, 100), np.linspace(-400.0, -0.5, 100)
NEAR = np.linspace(0.1, 4.9, 4), np.linspace(-3.9, 0.9, 5)  # where the slow peers are sampled
LOAD = ["--rod", "nitinol", "--mean", "0.2Fcr", "--amplitude", "0.2Fcr", "--frequency", "150"]


def run() -> list[Row]:
    """Return the figures of the issue's list, with what was promised."""
    return [*maps("standard map", *STANDARD), *maps("hard map", *HARD), *rods(), *slow_peers(), *starts()]


def rods() -> list[Row]:
    """Return the time of 10,000 random loads on the reference rod, every relevant mode looked at."""
    rod, rng = fr.Rod.nitinol(), np.random.default_rng(1)
    shares = rng.uniform(0.0, 1.0, 10_000), rng.uniform(0.0, 0.5, 10_000)
    loads = {name: share * rod.critical_force for name, share in zip(("mean", "amplitude"), shares, strict=True)}
    loads["frequency"] = rng.uniform(20.0, 300.0, 10_000)
    stable = best_of(lambda: rod.is_stable(**loads, workers=1))
    growth = best_of(lambda: rod.growth_rate(**loads, workers=1))
    return [
        Row("10,000 rod loads: verdicts", 1e3 * stable, "ms", at_most=50.0),
        Row("10,000 rod loads: growth rates", 1e3 * growth, "ms"),
    ]


def maps(name: str, alpha: np.ndarray, beta: np.ndarray) -> list[Row]:
    """Verdict, growth and discriminant a point on a map, with the number of wrong verdicts."""
    grid = alpha[:, None], beta[None, :]
    points = alpha.size * beta.size
    ours = best_of(lambda: fr.mathieu.is_stable(*grid, workers=1)) / points
    scipys = best_of(lambda: peers.scipy_curves(alpha, beta), repeats=3) / points
    verdicts, curves = fr.mathieu.is_stable(*grid, workers=1), peers.scipy_curves(alpha, beta)
    right = peers.judge_map(alpha, beta, verdicts, curves)
    growth = best_of(lambda: fr.mathieu.growth_rate(*grid, workers=1)) / points
    discriminant = best_of(lambda: fr.mathieu.discriminant(*grid, workers=1)) / points
    return [
        Row(f"{name}: verdict", 1e9 * ours, "ns", "SciPy's curves", 1e9 * scipys, at_most=20.0, ratio_at_least=8.0),
        Row(f"{name}: wrong verdicts", int((verdicts != right).sum()), "points", at_most=0.0),
        Row(f"{name}: wrong verdicts of SciPy's curves", int((curves != right).sum()), "points"),
        Row(f"{name}: growth rate", 1e6 * growth, "us", at_most=1.0),
        Row(f"{name}: discriminant", 1e6 * discriminant, "us", at_most=1.0),
        Row(f"{name}: discriminant, worst relative error of 25", worst_error(alpha, beta), "", at_most=1e-10),
    ]


def worst_error(alpha: np.ndarray, beta: np.ndarray) -> float:
    """Return the largest error of the discriminant relative to max(1, |D|) over a coarse map, against 50 digits."""
    errors = []
    for x in alpha[5::23]:
        for y in beta[5::23]:
            exact = fr.stability(fr.Mathieu(alpha=x, beta=y), method="reference", digits=50)
            value = fr.mathieu.discriminant(x, y)
            errors.append(abs(value - exact.discriminant) / max(1.0, abs(exact.discriminant)))
    return float(max(errors))


def slow_peers() -> list[Row]:
    """Return what a verdict costs the ways people usually take, extrapolated from a few points of the standard map."""
    alpha, beta = NEAR
    points = [(float(x), float(y)) for x in alpha for y in beta]
    ours = best_of(lambda: fr.mathieu.is_stable(STANDARD[0][:, None], STANDARD[1], workers=1)) / 1e4
    dop853 = best_of(lambda: [peers.dop853(*point) for point in points], repeats=3) / len(points)
    leapfrog = best_of(lambda: peers.leapfrog(0.5, -0.2), repeats=3)
    return [
        Row("verdict, against a monodromy matrix", 1e9 * ours, "ns", "solve_ivp, DOP853", 1e9 * dop853),
        Row("verdict, against the paper's test", 1e9 * ours, "ns", "compiled leapfrog", 1e9 * leapfrog),
    ]


def starts() -> list[Row]:
    """Return the time of one scalar call, of importing the package beyond numpy, and of an answer in the terminal."""
    call = best_of(lambda: fr.mathieu.is_stable(0.5, -0.2))
    clock = "import numpy, time; t = time.perf_counter(); import floquetrod; print(time.perf_counter() - t)"
    extra = min(float(python("-c", clock)) for _ in range(10))
    cold = best_of(lambda: python("-m", "floquetrod", "check", *LOAD), repeats=5)
    return [
        Row("one scalar is_stable", 1e6 * call, "us", at_most=10.0),
        Row("import floquetrod beyond numpy", 1e3 * extra, "ms", at_most=50.0),
        Row("floquetrod check in a new process", cold, "s", at_most=0.7),
    ]


def python(*arguments: str) -> str:
    """Return what a new interpreter prints."""
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=True).stdout
