"""How questions are drawn: expressions in `fr`, `np` and `terminal`, their numbers with six digits.

What is stored is what was asked; every structure of a system, every coupling of modes has its turn.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import floquetrod as fr

Rng = np.random.Generator

COMMANDS = (Path(__file__).parent / "commands.txt").read_text(encoding="utf-8").splitlines()


class Code(str):
    """An expression, which stays as it is inside lists and mappings."""

    __repr__ = str.__str__


def call(name: str, *positional: Any, **named: Any) -> Code:
    """Return a call as an expression."""
    shown = [*map(repr, map(short, positional)), *(f"{key}={short(value)!r}" for key, value in named.items())]
    return Code(f"{name}({', '.join(shown)})")


def short(value: Any) -> Any:
    """Return numbers, also within arrays and lists, with six digits."""
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, np.ndarray | np.generic):
        return short(value.tolist())
    return type(value)(map(short, value)) if type(value) in (list, tuple) else value


def decades(rng: Rng, low: float, high: float, size: int | None = None) -> Any:
    """Return numbers uniform in their logarithm."""
    return np.exp(rng.uniform(math.log(low), math.log(high), size))


def one_of(rng: Rng, *choices: Any) -> Any:
    """Return one of some things."""
    return choices[int(rng.integers(len(choices)))]


def point(rng: Rng, size: int | None = None) -> tuple[Any, Any, Any]:
    """Return alpha, beta and damping: tongues and intervals of every width, rarely far out, half of them damped."""
    far = one_of(rng, 1.0, 1.0, 1.0, 1000.0)
    c = one_of(rng, 0.0, decades(rng, 1e-4, 0.3))
    return far * decades(rng, 1e-3, 5.0, size), far * rng.uniform(-4.0, 0.5, size), c


def equation(rng: Rng, i: int) -> Code:
    """Return an equation of one of four kinds, in turn."""
    if i % 20 == 0:  # on a transition curve, as closely as doubles can say
        q = short(float(decades(rng, 0.01, 20.0)))
        a = fr.mathieu.characteristic_values(int(rng.integers(1, 6)), q, one_of(rng, "a", "b"))
        return Code(f"fr.Mathieu.from_aq({a!r}, {q!r})")
    if i % 4 == 3:
        harmonics = [rng.normal(size=n) * decades(rng, 0.01, 1.0) for n in (i // 4 % 3 + 1, i // 12 % 3)]
        period = one_of(rng, 2.0 * math.pi, decades(rng, 1.0, 10.0))
        cosines, sines = (tuple(h.tolist()) for h in harmonics)
        return call("fr.Hill", rng.uniform(-3.0, 0.3), cosines, sines, period=period, damping=point(rng)[2])
    return call(("fr.Mathieu", "fr.Mathieu", "fr.Meissner")[i % 4], *point(rng))


def by_method(rng: Rng, i: int) -> Code:
    """Return a question about an equation to one method, in turn."""
    method = ("spectral", "determinant", "monodromy", "square_wave", "leapfrog", "reference")[i % 6]
    a, b, c = point(rng)
    return call(
        "fr.stability", call("fr.Meissner" if i % 6 == 3 else "fr.Mathieu", min(a, 5.0), max(b, -4.0), c), method
    )


def system_by_method(rng: Rng, i: int) -> Code:
    """Return a question about a system to one method, in turn."""
    method = ("half_period", "monodromy", "segmented", "spectral", "reference")[i % 5]
    return call("fr.stability", system(rng, i // 5, n=1 if method == "reference" else 1 + i % 3), method)


def curves(rng: Rng, i: int) -> str:
    """Return transition curves, or in turn the paper's test over arrays."""
    if i % 2:
        return call("fr.FiniteTimeCriterion().is_stable", *point(rng, 15))
    return f"[{call('fr.mathieu.transition_curves', decades(rng, 0.01, 5.0, 4), 4)}.{('even', 'odd')[i // 2 % 2]}]"


def arrays(*functions: str) -> Callable[[Rng, int], Code]:
    """Return a drawing of calls of these functions, in turn, over arrays of Mathieu's equations."""
    return lambda rng, i: call(f"fr.mathieu.{functions[i % len(functions)]}", *point(rng, 25))


def system(rng: Rng, i: int, batch: int | None = None, n: int | None = None) -> Code:
    """Return a system of one of six structures, in turn, of one to four oscillators."""
    n = n or int(rng.integers(1, 5))
    kind, size = i % 6, decades(rng, 0.05, 1.5)
    w = np.sort(decades(rng, 0.5, 4.0, n))

    def matrix(symmetric: bool = True) -> Any:
        m = rng.normal(size=(n, n))
        return 0.5 * (m + m.T) if symmetric else m

    period = decades(rng, 1.0, 8.0, batch)
    if kind == 5:
        mean = np.block([[np.zeros((n, n)), np.eye(n)], [-np.diag(w**2), -0.1 * np.diag(rng.uniform(size=n))]])
        wave = np.vstack([np.zeros((n, 2 * n)), size * rng.normal(size=(n, 2 * n))])
        return call("fr.PeriodicSystem", mean, [wave], period=period)
    more: dict[str, Any] = {}
    if rng.random() < 0.3:
        m = matrix()
        more["mass"] = np.eye(n) + 0.1 * m @ m
    if kind == 1:
        more["damping"] = np.diag(rng.uniform(0.0, 0.2, n))
    if kind == 2:
        g = rng.normal(size=(n, n))
        more["gyroscopic"] = g - g.T
    if kind == 3:
        more["sines"] = [size * matrix()]
    return call("fr.HillSystem", np.diag(w**2), [size * matrix(kind != 4)], **more, period=period)


def rod(rng: Rng, modes: tuple[float, float] = (1.5, 14.0), **changes: Any) -> fr.Rod:
    """Return a rod about as realistic as the reference rod, whose critical mode lies between two numbers."""
    radius = decades(rng, 3e-4, 5e-3)
    numbers = (
        decades(rng, 1e9, 2.5e11),
        decades(rng, 900.0, 9000.0),
        radius,
        1.0,
        radius * (1 + decades(rng, 0.3, 10.0)),
    )
    found = fr.Rod(*map(short, map(float, numbers)))
    damping = found.pendulum_frequency * one_of(rng, 0.0, decades(rng, 1e-3, 0.3))
    length = decades(rng, *modes) / found.critical_mode
    return found.replace(length=short(float(length)), damping_rate=short(float(damping)), **changes)


def as_code(value: Any) -> Code:
    """Return a rod or a load as an expression."""
    return Code("fr." + repr(value))


def numbers(rng: Rng, rod: fr.Rod, size: int | None = None) -> dict[str, Any]:
    """Return mean, amplitude and frequency of the order of the rod's own."""
    force, pendulum = rod.critical_force, rod.pendulum_frequency
    amplitude = decades(rng, 0.05, 1.0) * force
    named = {"mean": rng.uniform(-0.2, 1.1, size) * force, "amplitude": amplitude}
    return {name: short(value) for name, value in named.items()} | {
        "frequency": short(decades(rng, 0.7, 3.5) * pendulum)
    }


def tolerance(rng: Rng, rod: fr.Rod) -> float:
    """Return a growth tolerance in 1/s, often none."""
    return float(short(one_of(rng, 0.0, float(decades(rng, 1e-4, 0.05) * rod.pendulum_frequency))))


ENDS = [f"{a}-{b}" for a in ("hinged", "clamped", "guided", "free") for b in ("hinged", "clamped", "guided", "free")]


def coupled(rng: Rng, i: int) -> tuple[fr.Rod, Code]:
    """Return a rod and a load whose modes are coupled, in turn by ends, inclination, waves, waveform and a record."""
    why = i % 5
    found = rod(rng, (1.5, 4.0))
    changes: dict[str, Any] = {"ends": ENDS[1 + i // 5 % 15]} if why == 0 else {}
    if why == 1 or i % 3 == 0:
        changes["inclination"] = short(float(rng.uniform(0.6, 1.5)))
    if i % 4 == 0:
        changes |= {"inner_radius": short(found.radius * 0.8), "fluid_inside": 1000.0, "fluid_outside": 800.0}
    found = found.replace(damping_rate=short(0.02 * found.pendulum_frequency), **changes)
    load = numbers(rng, found)
    if why == 2:
        end = one_of(rng, "held", "free", "driven")
        return found, call("fr.AxialWave", *load.values(), end, axial_damping=short(0.1 * load["frequency"]))
    if why == 3:
        waveform = tuple(complex(*short(rng.uniform(-0.5, 0.5, 2).tolist())) for _ in range(3))
        return found, call("fr.AxialLoad", *load.values(), waveform=waveform)
    if why == 4:
        return found, measured(rng, load, 0.01)
    return found, call("fr.AxialLoad", *load.values())


def measured(rng: Rng, load: dict[str, Any], noise: float) -> Code:
    """Return a record of 160 samples over some ten periods with a second harmonic, noise and six digits."""
    w, f = load["frequency"], load["amplitude"]
    t = np.linspace(0.0, float(rng.uniform(8.0, 11.0)) * 2.0 * math.pi / w, 160)
    force = load["mean"] + f * (np.sin(w * t) + 0.3 * np.cos(2.0 * w * t + 1.0) + noise * rng.normal(size=t.size))
    return call("fr.ForceRecord", t, force, harmonics=3, frequency=w)


# --- questions about rods ---------------------------------------------------------------------------------------------


def of_rod(method: str, after: str = "") -> Callable[[Rng, int], str]:
    """Return a drawing of ``rod.stability(load)``, and what is asked of it."""

    def draw(rng: Rng, i: int) -> str:
        found = rod(rng)
        limit = tolerance(rng, found)
        named = {"growth_tolerance": limit} if limit else {}
        load = call("fr.AxialLoad", *numbers(rng, found).values())
        return f"{call(f'{as_code(found)}.{method}', load, **named)}{after}"

    return draw


def of_coupled(method: str, after: str = "", step: int = 1, **named: Any) -> Callable[[Rng, int], str]:
    """Return a drawing of ``rod.stability(load)`` with coupled modes, every ``step``-th kind of coupling."""

    def draw(rng: Rng, i: int) -> str:
        found, load = coupled(rng, step * i)
        return f"{call(f'{as_code(found)}.{method}', load, **named)}{after}"

    return draw


def over_loads(*methods: str, waves: bool = False) -> Callable[[Rng, int], Code]:
    """Return a drawing of methods of a rod, with flags after a space, over loads, or waves, which couple the modes."""

    def draw(rng: Rng, i: int) -> Code:
        method, *flags = methods[i % len(methods)].split()
        more = dict.fromkeys(flags, True)
        if not waves:
            found = rod(rng)
            return call(f"{as_code(found)}.{method}", **numbers(rng, found, 15), **more)
        found, wave = coupled(rng, 5 * (i // len(methods)) + 2)
        return call(f"{as_code(found)}.{method}", wave, **numbers(rng, found, 8), **more)

    return draw


def along(rng: Rng, i: int, coupled_modes: bool = False) -> str:
    """Return a question for ranges along one quantity, in turn."""
    found = coupled(rng, 5 * i)[0] if coupled_modes else rod(rng, (1.5, 8.0))
    load = numbers(rng, found)
    vary = ("mean", "amplitude", "frequency")[i % 3]
    bounds = {"mean": (0.0, found.critical_force), "amplitude": (0.0, 0.5 * found.critical_force)}
    centre = load.pop(vary)
    span = bounds.get(vary, (0.7 * centre, 1.4 * centre))
    named = {"growth_tolerance": 0.01 * found.pendulum_frequency}
    return call(f"{as_code(found)}.ranges", vary, **load, bounds=tuple(map(float, span)), **named)


def critical(rng: Rng, i: int) -> str:
    """Return a question for the least mean force or amplitude at which a rod grows."""
    found = rod(rng, (1.5, 8.0))
    load = numbers(rng, found)
    quantity = ("mean", "amplitude")[i % 2]
    del load[quantity]
    return call(f"{as_code(found)}.critical", quantity, **load, growth_tolerance=0.01 * found.pendulum_frequency)


def kick(rng: Rng, i: int) -> str:
    """Return a question about a rod whose modes are kicked, by much and by little."""
    found = rod(rng, (1.5, 8.0))
    load = call("fr.AxialLoad", *numbers(rng, found).values())
    speed = decades(rng, 0.1, 5.0) * found.radial_clearance * found.pendulum_frequency
    mu = {"friction": float(rng.uniform(0.02, 0.3))}
    return call(f"{as_code(found)}.stability", load, **mu, kick=float(speed))


def critical_kick(rng: Rng, i: int) -> str:
    """Return a question for the smallest kicks that buckle a rod under some loads."""
    found = rod(rng, (1.5, 6.0))
    return call(f"{as_code(found)}.critical_kick", **numbers(rng, found, 3), friction=float(rng.uniform(0.02, 0.3)))


def with_friction(rng: Rng) -> tuple[float, float, float, float]:
    """Return alpha, beta, gamma and damping of an equation with friction, most of which have growing solutions."""
    return (
        decades(rng, 0.05, 2.0),
        rng.uniform(-1.0, 0.6),
        decades(rng, 0.1, 3.0),
        one_of(rng, 0.0, decades(rng, 1e-3, 0.1)),
    )


def frictional(function: str) -> Callable[[Rng, int], Code]:
    """Return a drawing of questions about Mathieu's equation with friction."""

    def draw(rng: Rng, i: int) -> Code:
        a, b, g, c = with_friction(rng)
        where, v = f"fr.friction.{function}", g * decades(rng, 0.1, 10.0)
        if function in ("fates", "escapes"):
            return call(where, a, b, g, g * decades(rng, 0.1, 10.0, 20), damping=c)
        if function == "critical_kick":
            return call(where, a, b, g, damping=c)
        equation = call("fr.FrictionalMathieu", a, b, g, c)
        if function == "escape_ranges":
            return call(where, equation, samples=60, max_steps=20000)
        if function == "trajectory":
            return call(where, equation, v, periods=3)
        return call(where, equation, v) if function == "fate" else call(where, equation)

    return draw


def mapped(rng: Rng, i: int) -> str:
    """Return a map of a rod, in turn with growth, with friction, with proved cells."""
    found = rod(rng, (1.5, 6.0)).replace(damping_rate=0.3)
    load = numbers(rng, found)
    unit, w = found.critical_force, load["frequency"]
    axes = {"mean": (0.0, unit, 12), "amplitude": load["amplitude"], "frequency": (0.6 * w, 1.5 * w, 12)}
    clearance = found.radial_clearance * found.pendulum_frequency
    more = ({"growth": True}, {"friction": 0.1, "kick": 0.2 * clearance}, {"certified": True}, {"damping": 0.5})[i % 4]
    return call("fr.stability_map", as_code(found), **axes, **more)


def charted(rng: Rng, i: int) -> str:
    """Return a chart of Mathieu's, Meissner's or a Hill's equation, or of a family of systems."""
    c, e = short(one_of(rng, 0.0, 0.05)), short(float(decades(rng, 0.05, 0.3)))
    if i % 4 == 3:
        waves = f"[[[{e} * x, x], [x, {e} * x]]]"
        family = Code(f"lambda w, x: fr.HillSystem([[1.0, 0.0], [0.0, 4.0]], {waves}, period=2 * np.pi / w)")
        return call("fr.chart", family, over={"w": (0.8, 4.5, 14), "x": (0.05, 0.4, 8)}, growth=True)
    hill = Code(f"lambda a, b, c: fr.Hill(b, sines=(a, {e} * a), damping=c)")
    family = {0: Code("fr.Mathieu"), 1: Code("fr.Meissner"), 2: hill}[i % 4]
    return call("fr.mathieu.chart", (0.0, 2.0, 14), (-1.5, 0.3, 14), c, equation=family, growth=True)


def banded(rng: Rng, i: int) -> str:
    """Return the bands of a chart of Mathieu's equation or of a map of a rod."""
    if i % 2:
        return f"{call('fr.mathieu.chart', (0.0, 2.0, 20), (-1.5, 0.3, 20), 0.02)}.find_bands(accuracy=0.003)"
    return f"{mapped(rng, 4 * i + 3)}.find_bands(accuracy=0.003)"


def proved_box(rng: Rng, i: int) -> str:
    """Return a box of loads to prove, or of Mathieu's equations."""
    if i % 3 == 2:
        a, b = float(decades(rng, 0.05, 1.0)), rng.uniform(-1.5, 0.1)
        return call(
            "fr.certify", Code("fr.Mathieu"), alpha=(a, 1.05 * a), beta=(b - 0.02, b), damping=0.02, max_boxes=2000
        )
    found = rod(rng, (1.5, 5.0)).replace(damping_rate=0.5)
    load = numbers(rng, found)
    wide = 0.03 * found.critical_force
    load["mean"] = (load["mean"], load["mean"] + wide)
    more = {"rod": {"length": short((found.length, 1.002 * found.length))}} if i % 3 else {}
    return call(f"{as_code(found)}.certify", **load, growth_tolerance=0.1, max_boxes=2000, **more)


def safe_box(rng: Rng, i: int) -> str:
    """Return a question for the largest safe box about a load of a well damped rod."""
    found = rod(rng, (1.5, 4.0))
    found = found.replace(damping_rate=short(0.3 * found.pendulum_frequency))
    load = numbers(rng, found) | {"amplitude": short(0.05 * found.critical_force)}
    vary = (("mean",), ("mean", "frequency"))[i % 2]
    return call(f"{as_code(found)}.largest_safe_box", call("fr.AxialLoad", *load.values()), vary=vary, accuracy=0.05)


def likely(rng: Rng, i: int) -> str:
    """Return a question for a probability of instability, in turn of a distributed rod and a distributed load."""
    found = rod(rng, (1.5, 6.0))
    load = numbers(rng, found)
    length, mean = found.length, load["mean"]
    of_length, of_mean = (0.95 * length, 1.05 * length), (mean, mean + 0.3 * found.critical_force)
    where = {"mean": short(of_mean)} if i % 2 else {"length": short(of_length)}
    load = call("fr.AxialLoad", *load.values())
    return call("fr.probability_of_instability", as_code(found), load, where, samples=2000, seed=i)


def of_section(rng: Rng, i: int) -> str:
    """Return a question about a rod itself: forces, lock-up, modes, a wave along it, its data sheet."""
    found, wave = coupled(rng, 5 * i + 2)
    mu, rod_code = short(float(rng.uniform(0.1, 0.5))), as_code(found)
    asked = (
        f"{{name: b.force for name, b in {rod_code}.critical_forces.items()}}",
        f"{rod_code}.lock_up({mu}).length",
        f"{rod_code}.lock_up({mu}, 1.0).force(10.0)",
        f"{rod_code}.natural_frequency([1, 2, 3])",
        f"wavenumber({rod_code}, [1, 2, 3])",
        f"{rod_code}.axial_response({wave}).as_dict()",
        f"{rod_code}.modes_needed({wave})[0]",
        f"{rod_code}.as_dict()",
        f"{rod_code}.pendulum_frequency",
        f"{rod_code}.critical_mode",
    )
    return asked[i % len(asked)]


def converted(rng: Rng, i: int) -> str:
    """Return a conversion between notations."""
    name = ("to_aq", "from_aq", "to_delta_epsilon", "from_delta_epsilon")[i % 4]
    return call(f"fr.conventions.{name}", rng.normal(size=3), rng.normal(size=3))


def of_order(low: float, high: float) -> Callable[[Rng, int], Code]:
    """Return a drawing of questions for characteristic values, in turn of whole and real orders, at such q."""

    def draw(rng: Rng, i: int) -> Code:
        q = decades(rng, low, high, 10)
        if i % 3 == 2:
            return call("fr.mathieu.real_order_values", rng.uniform(0.1, 20.0, 10), q)
        return call("fr.mathieu.characteristic_values", rng.integers(1, 60, 10).tolist(), q, "ab"[i % 3])

    return draw


def tongue_widths(rng: Rng, i: int) -> Code:
    """Return a question for widths of tongues, the thinnest among them."""
    return call("fr.mathieu.tongue_widths", rng.integers(1, 30, 10).tolist(), decades(rng, 0.01, 100.0, 10))


def floquet(rng: Rng, i: int) -> str:
    """Return values of ce, se or me, or, in turn, the exponent of what grows fastest."""
    if i % 4 == 3:
        equation = call("fr.Mathieu", decades(rng, 0.1, 2.0), rng.uniform(-2.0, 0.2))
        return f"fr.mathieu.floquet_solutions({equation})[0].exponent"
    order = int(rng.integers(1, 12)) if i % 4 < 2 else rng.uniform(0.1, 6.0)
    function = call("fr.mathieu.characteristic_function", order, decades(rng, 0.1, 200.0), ("a", "b", "floquet")[i % 4])
    return f"{function}(np.linspace(0.1, 1.4, 5))"


# --- delays, noise, wells, orbits -------------------------------------------------------------------------------------


def delayed(rng: Rng, i: int) -> Code:
    """Return a system with delays: one or two terms, of a share of the period or of none, every third constant."""
    n, period = 1 + i % 2, short(float(decades(rng, 1.0, 8.0)))
    w, size = decades(rng, 0.5, 3.0, n), decades(rng, 0.05, 1.0)

    def matrix(scale: float) -> Any:
        return scale * rng.normal(size=(n, n))

    terms: list[Any] = []
    for _ in range(1 + i % 4 // 3):
        delay = period * one_of(rng, 0.5, 1.0, 1.5, 0.25) if i % 5 else float(decades(rng, 0.3, 3.0)) * period
        terms.append((delay, matrix(0.2).tolist(), [matrix(0.1).tolist()] if i % 3 else []))
    waves = [(size * (m + m.T)).tolist() for m in [matrix(0.5)]] if i % 3 else []
    named = {"damping": np.diag(rng.uniform(0.0, 0.3, n)), "period": period, "delayed": terms}
    return call("fr.DelaySystem", np.diag(w**2), waves, **named)


def noisy(rng: Rng, i: int) -> Code:
    """Return the second moments of a system with one or two sources of noise, of two structures in turn."""
    n, kind = 1 + i % 2, (0, 1, 5)[i % 3]
    order = 2 * n if kind == 5 else n
    sources = [(rng.normal(size=(order, order)).tolist(), float(decades(rng, 0.01, 0.5))) for _ in range(1 + i % 2)]
    return call("fr.second_moments", system(rng, kind, n=n), sources)


def critical_noise(rng: Rng, i: int) -> str:
    """Return a question for the noise that an oscillator bears whose stiffness varies a little."""
    k, c = float(decades(rng, 0.5, 4.0)), float(decades(rng, 0.02, 0.3))
    oscillator = call("fr.HillSystem", [[k]], [[[0.1 * c]]], damping=[[c]], period=float(decades(rng, 1.0, 8.0)))
    return f"{call('fr.critical_noise', oscillator, [([[1.0]], 1.0)])}.factor"


def filtered(rng: Rng, i: int) -> str:
    """Return a question for the growth of second moments under noise of some correlation time."""
    k, rate = float(decades(rng, 0.5, 4.0)), float(decades(rng, 0.5, 5.0))
    oscillator = call("fr.HillSystem", [[k]], [[[0.2]]], damping=[[0.1]], period=float(decades(rng, 1.0, 8.0)))
    return f"{call('fr.filtered_growth', oscillator, [[1.0]], ([[-rate]], [1.0], [0.2 * rate]))}.rate"


def noisy_rod(rng: Rng, i: int) -> str:
    """Return the verdict on a damped rod under white noise, or in turn under noise in bands."""
    found = rod(rng, (1.5, 6.0))
    found = found.replace(damping_rate=short(0.05 * found.pendulum_frequency))
    high_modes = 8.0 * found.damping_rate * found.flexural_rigidity * found.mass_per_length
    density = high_modes * float(decades(rng, 0.02, 2.0))
    w = found.pendulum_frequency / 2.0 / math.pi
    noise = [(0.0, density), (2.0 * w, density), (2.1 * w, 0.0)] if i % 3 == 2 else density
    load = call("fr.AxialLoad", *numbers(rng, found).values(), noise=noise)
    return call(f"{as_code(found)}.stability", load)


def milled(rng: Rng, i: int) -> str:
    """Return the critical depths of a cutter of one or two modes at three speeds."""
    x, y = ([call("fr.ToolMode", f * 922.0, 0.011, 0.03993)] for f in (1.0, 1.0 + 0.3 * rng.random()))
    named: dict[str, Any] = {"x": x, "teeth": 2 + i % 3, "tangential": 6e8, "radial": 2e8}
    named |= {"immersion": float(rng.uniform(0.1, 1.0)), "direction": ("up", "down")[i % 2]}
    cutter = call("fr.Milling", **(named | {"y": y} if i % 2 else named))
    speeds = short((rng.uniform(4000.0, 20000.0, 2) * 2.0 * math.pi / 60.0).tolist())
    return f"[{cutter}.critical_depth(speed) for speed in {speeds}]"


def path(rng: Rng, i: int) -> Code:
    """Return a well of some stations that builds, and in turn drops or turns."""
    depth = np.concatenate([[0.0], np.cumsum(rng.uniform(200.0, 800.0, 4))])
    inclination = np.array([0.0, 0.0, *np.sort(rng.uniform(0.2, 1.6, 2)), 1.5 if i % 2 else 0.8])
    azimuth = rng.uniform(0.0, 0.6, 5) if i % 3 else 0.0
    return call("fr.WellPath", depth, inclination, azimuth)


def of_well(rng: Rng, i: int) -> str:
    """Return a question about the geometry of a well."""
    name = ("position", "curvature", "inclination_at", "azimuth_at", "dogleg_severity")[i % 5]
    found = f"{path(rng, i)}.{name}"
    return found if name == "dogleg_severity" else call(found, rng.uniform(0.0, 800.0, 3))


def tubing(rng: Rng, **changes: Any) -> Code:
    """Return tubing of 60 mm or so in a channel of 120 mm."""
    radius = short(float(rng.uniform(0.022, 0.032)))
    named: dict[str, Any] = {"youngs_modulus": 2.06e11, "density": 7850.0, "radius": radius, "channel_radius": 0.06}
    return call("fr.Rod", **named, inner_radius=0.85 * radius, **changes)


def in_bend(rng: Rng, i: int) -> str:
    """Return the verdict on tubing in a bend: independent modes, or coupled by the ends or by gravity along it."""
    inclination = float(rng.uniform(0.7, 1.4))
    bend = call("fr.WellPath.arc", length=150.0, inclination=(inclination, inclination + float(rng.uniform(-0.2, 0.2))))
    ends = ("hinged", "clamped", "hinged-clamped")[i % 3]
    found = tubing(rng, length=100.0, path=bend, depth=20.0, ends=ends, damping_rate=0.05)
    load = (float(decades(rng, 5e3, 8e4)), float(decades(rng, 1e3, 2e4)), float(decades(rng, 2.0, 20.0)))
    return call(f"{found}.stability", call("fr.AxialLoad", *load))


def reached(rng: Rng, i: int) -> str:
    """Return how far tubing can be pushed into a well, and the forces at its upper end."""
    mu, well = float(rng.uniform(0.15, 0.35)), path(rng, i)
    return call(f"{tubing(rng, length=3000.0)}.reach", well, mu, depth=[700.0, 1200.0])


ORBITS = (
    ("lambda t, x, mu: (x[1], mu * (1 - x[0] ** 2) * x[1] - x[0])", "mu", (0.2, 3.0), None, [2.0, 0.0]),
    (
        "lambda t, x, f: (x[1], f * np.cos(1.3 * t) - 0.2 * x[1] - x[0] - x[0] ** 3)",
        "f",
        (0.05, 0.6),
        "2*pi/1.3",
        [0.0, 0.0],
    ),
    ("lambda t, x, c: (-x[1] - x[2], x[0] + 0.2 * x[1], 0.2 + x[2] * (x[0] - c))", "c", (2.3, 2.8), None, [3.0, 0, 0]),
)
"""Van der Pol's, Duffing's and Roessler's equations with a parameter and a start."""


def orbit(rng: Rng, i: int) -> Code:
    """Return a periodic orbit of one of three equations, in turn."""
    function, name, bounds, period, start = ORBITS[i % 3]
    parameters = {name: short(float(rng.uniform(*bounds)))}
    return call("fr.periodic_orbit", call("fr.NonlinearSystem", Code(function), None, period, parameters), start)


def solved(rng: Rng, i: int) -> str:
    """Return an initial value problem of an equation or a system."""
    if i % 2:
        n = 1 + i % 3
        start = rng.normal(size=(2, n)) if i % 6 != 5 else rng.normal(size=2 * n)
        return call("fr.solve", system(rng, i, n=n), start, 15.0)
    return call("fr.solve", equation(rng, i // 2), (1.0, 0.5), 15.0)


def simulated(rng: Rng, i: int) -> str:
    """Return a short simulation of the reference rod."""
    found = fr.Rod.nitinol().replace(damping_rate=short(float(rng.uniform(0.0, 0.5))))
    load = call(
        "fr.AxialLoad", *(short(x) for x in (rng.uniform(0.1, 0.6), rng.uniform(0.1, 0.5), rng.uniform(80, 160)))
    )
    start = call("fr.Perturbation.modes", {int(rng.integers(2, 8)): short(float(decades(rng, 1e-3, 0.05)))})
    named = {"friction": (0.0, 0.1)[i % 2], "duration": 0.02, "segments": 40, "frames": 3}
    return call("fr.simulate", as_code(found), load, perturbation=start, **named)


def commanded(rng: Rng, i: int) -> str:
    """Return the i-th command: these are not drawn."""
    return f"terminal({COMMANDS[i] + ' --json'!r})"
