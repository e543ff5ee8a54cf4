"""Systems of equations by all methods, by proof, in batches and by an integrator: no two contradict each other."""

from __future__ import annotations

import functools
import math
from dataclasses import fields
from typing import Any

import numpy as np

import floquetrod as fr
from floquetrod.equations import Varying
from floquetrod.floquet.registry import applicable
from tests.fuzz import neutral, system_draws
from tests.fuzz.core import LONGEST, Found, limit
from tests.fuzz.system_draws import System

CASES = 60
QUICK = 3

_SLOW = ("spectral", "reference")  # asked of small systems, and not always
_INTEGRATED = 1e-9  # of the map by scipy, relative to its norm: the integrator is asked for 1e-12
_NONE = 1e-7  # growth over a period that is none, on the coarser map of a batch
_ROUNDING = 1e-12  # of exponents times the period, beside the errors that are stated


def check(rng: np.random.Generator) -> Found:
    """Ask about one system in all ways, or about one whose exponents are known."""
    warm()
    if rng.random() < 0.3:
        return Found(1, neutral.disagreements(rng))
    system = system_draws.draw(rng)
    lines = disagreements(system, rng)
    return Found(1, [f"{told(system)}: {line}" for line in lines])


@functools.cache
def warm() -> None:
    """Compile what the methods run, which no limit of time is for."""
    wave = np.array([[0.1, 0.2], [0.2, 0.16]])
    for n in (1, 2, 3, 20):
        mean, waves = np.diag(np.arange(1.0, n + 1.0)), [np.full((n, n), 0.01)] if n != 2 else [wave]
        for more in ({}, {"sines": [0.5 * waves[0], waves[0]]}, {"damping": mean, "sines": [waves[0], waves[0]]}):
            system = fr.HillSystem(mean, waves, **more)
            for method in applicable(system):
                if method.name not in _SLOW:
                    fr.stability(system, method.name)
            fr.systems.is_stable(fr.systems.stack([system] * 70))
            fr.systems.multipliers(system)


def told(system: System) -> str:
    """Return a system in full, as an expression."""
    if system.pieces:
        pieces = ", ".join(f"({duration!r}, {_varying(value)})" for duration, value in system.pieces)
        names = ("mass", "damping", "gyroscopic", "coefficient_error")
        others = {name: value for name in names if (value := getattr(system, name, None)) is not None}
        said = "".join(f", {name}={np.asarray(value).tolist()!r}" for name, value in others.items())
        return f"fr.{type(system).__name__}.from_pieces([{pieces}]{said})"
    parts = []
    for name in (field.name for field in fields(system)):
        value = getattr(system, name)
        if isinstance(value, tuple):
            parts += [f"{name}={[m.tolist() for m in value]!r}"] if value else []
        elif isinstance(value, np.ndarray):
            parts.append(f"{name}={value.tolist()!r}")
        elif value is not None and (name != "coefficient_error" or value):
            parts.append(f"{name}={value!r}")
    return f"fr.{type(system).__name__}({', '.join(parts)})"


def _varying(value: Varying) -> str:
    slope = None if value.slope is None else value.slope.tolist()
    series = ([m.tolist() for m in matrices] for matrices in (value.cosines, value.sines))
    return f"fr.equations.Varying(None, {slope!r}, {', '.join(map(repr, series))}, start={value.start.tolist()!r})"


def disagreements(system: System, rng: np.random.Generator) -> list[str]:
    """Return every pair of answers about a system that contradict each other, each on a line."""
    results = {}
    for method in (each.name for each in applicable(system)):
        slow = method in _SLOW
        if not slow or (system.order <= 3 and rng.random() < 0.3):
            with limit(60.0 if slow else LONGEST):
                results[method] = fr.stability(system, method)
    with limit(60.0):
        results["auto"] = fr.stability(system)
    lines = between(results)
    lines += against_scipy(system, results["auto"])
    lines += _batch(system, results["auto"], rng)
    lines += _proof(system, results["auto"])
    return lines


def between(results: dict[str, Any]) -> list[str]:
    """Compare verdicts, growth and exponents of methods with each other."""
    names = list(results)
    lines = [f"{name}: {line}" for name, result in results.items() for line in sound(result)]
    for i, one in enumerate(names):
        for other in names[i + 1 :]:
            a, b = results[one], results[other]
            if {a.status, b.status} == {"stable", "unstable"}:
                lines.append(f"{one} says {a.status}, {other} {b.status}; growth {a.growth_rate!r}, {b.growth_rate!r}")
            apart = farther(a, b)
            if apart:
                lines.append(f"{one} and {other} differ {apart}")
    return lines


def sound(result: Any) -> list[str]:
    """Return what is wrong about one result by itself."""
    lines = []
    if result.status == "undecided" and not result.note:
        lines.append("undecided without a reason")
    if result.unknown_below == math.inf:  # all is lost in rounding, which the note says
        lines += [] if result.status == "undecided" else [f"{result.status} without a known exponent"]
    elif result.exponents:
        count = 2 * result.system.order if isinstance(result.system, fr.HillSystem) else result.system.order
        lengths = {len(getattr(result, n)) for n in ("exponents", "exponent_errors", "krein_signs", "multipliers")}
        if lengths != {count}:
            lines.append(f"has {lengths} exponents, of {count}")
        pairs = list(zip(result.exponents, result.exponent_errors, strict=True))
        known = [number for pair in pairs if pair[1] != math.inf for number in pair]  # others are NaN, below a bound
        if any(map(np.isnan, (*known, result.growth_rate, result.error))):
            lines.append("NaN among known exponents, their errors and growth")
        if 2 * len(pairs) > len(known) and not math.isfinite(result.unknown_below):
            lines.append("unknown exponents without a bound")
    if result.status == "unstable" and not result.growth_rate >= 0.0:
        lines.append(f"unstable, growth {result.growth_rate!r}")
    return lines


def farther(one: Any, other: Any) -> str:
    """Return by how much two results differ beyond their errors, "" where they do not."""
    if not (one.exponents and other.exponents):
        return ""
    a, b = (np.array(r.exponents) * r.period for r in (one, other))
    ea, eb = (np.array(r.exponent_errors) * r.period for r in (one, other))
    gap = a[:, None] - b
    angle = np.remainder(gap.imag + math.pi, 2.0 * math.pi) - math.pi
    beyond = np.abs(gap.real + 1j * angle) - ea[:, None] - eb
    worst = max(beyond.min(axis=0).max(), beyond.min(axis=1).max())
    rates = np.sort(a.real) - np.sort(b.real)
    worst = max(worst, float(np.abs(rates).max()) - ea.max() - eb.max())
    slack = _ROUNDING * (1.0 + float(np.abs(a.real).max()))
    return f"by {worst:.3g} more than their errors, {ea.max():.3g} and {eb.max():.3g}" if worst > slack else ""


def against_scipy(system: System, result: Any) -> list[str]:
    """Compare verdict and multipliers with the map of an integrator.

    A multiplier with an error e is one of a map within e, and as a map is far from singular less no eigenvalue of it,
    the least singular value of map less multiplier is at most e and the integrator's error.
    """
    found = system_draws.integrated(system)
    size = max(1.0, float(np.linalg.norm(found, 2)))
    slack = _INTEGRATED * size + 10.0 * float(getattr(system, "coefficient_error", 0.0)) * system.period * size
    lines = []
    for mu, error in zip(result.multipliers, result.multiplier_errors, strict=True):
        if not np.isfinite(mu):  # unknown, below a bound, or beyond the range of doubles
            continue
        least = float(np.linalg.svd(found - mu * np.eye(len(found)), compute_uv=False)[-1])
        if least > slack + error:
            lines.append(f"{mu!r} +- {error:.3g} is no multiplier: scipy's map is {least:.3g} from having it")
            break
    rate = float(np.log(np.abs(np.linalg.eigvals(found)).max()))
    doubt = 1e-2 * math.sqrt(_INTEGRATED * size) + 10.0 * (_INTEGRATED * size) ** (1.0 / len(found))
    truth = "unstable" if rate > doubt else "stable" if rate < -doubt else ""
    if truth and result.status not in ("undecided", truth):
        lines.append(f"{result.status}, scipy has growth {rate!r} over a period")
    return lines


def _batch(system: System, result: Any, rng: np.random.Generator) -> list[str]:
    """Compare the system, and the same written otherwise, with what the functions over batches say of them."""
    variants = list(system_draws.alike(system, rng))
    picked = sorted(rng.choice(len(variants), 2, replace=False))
    names, variants, speeds = zip(("as it is", system, 1.0), *[variants[i] for i in picked], strict=True)
    lines = []
    for name, variant, speed in zip(names[1:], variants[1:], speeds[1:], strict=True):
        with limit(60.0):
            other = fr.stability(variant)
        lines += [f"{name}: {line}" for line in _same(result, other, speed)]
    with limit(60.0):
        together = fr.systems.stack(variants)
        stable, rates = fr.systems.is_stable(together), fr.systems.growth_rate(together)
        multipliers = fr.systems.multipliers(together)
        alone = [fr.systems.is_stable(system), fr.systems.growth_rate(system), fr.systems.multipliers(system)]
    stable, rates = np.append(stable, alone[0]), np.append(rates, alone[1])
    for name, yes, rate, speed in zip((*names, "alone"), stable, rates, (*speeds, 1.0), strict=True):
        grows = rate * result.period / speed > _NONE  # less is how a batch says undecided
        if (result.status == "unstable" and yes) or (result.status == "stable" and grows and not yes):
            lines.append(f"{name}, in a batch is_stable {bool(yes)}, growth {rate!r}; stability says {result.status}")
        doubt = 2.0 * max(result.error, _NONE) / result.period
        if result.status != "undecided" and not abs(rate / speed - result.growth_rate) <= doubt:
            lines.append(f"{name}, in a batch the growth is {rate!r}, stability has {result.growth_rate!r}")
    lost = np.isnan(multipliers)  # in the rounding of the largest one: the last ones
    if np.isinf(multipliers).any() or lost[..., 0].any() or (lost[..., :-1] & ~lost[..., 1:]).any():
        lines.append("multipliers of a batch are not finite, or unknown before known ones")
    return lines


def _same(one: Any, other: Any, speed: float) -> list[str]:
    """Compare the results of one system written in two ways."""
    lines = []
    if {one.status, other.status} == {"stable", "unstable"}:
        lines.append(f"was {one.status}, is {other.status}; growth {one.growth_rate!r}, {other.growth_rate!r}")
    doubt = (one.error + other.error + _ROUNDING) / one.period
    if "undecided" not in (one.status, other.status) and abs(one.growth_rate - other.growth_rate / speed) > doubt:
        lines.append(f"grew at {one.growth_rate!r}, grows at {other.growth_rate / speed!r}, errors {doubt:.3g}")
    return lines


def _proof(system: System, result: Any) -> list[str]:
    with limit(60.0):
        proof = fr.certify(system)
    if {proof.status, result.status} == {"stable", "unstable"}:
        return [f"certify proves {proof.status}, stability says {result.status}"]
    return []
