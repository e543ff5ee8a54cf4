"""Calls as people get them wrong: every answer names the argument, what came and the way out."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import math
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr

ROD = fr.Rod.nitinol()
LOAD = fr.AxialLoad(0.34, 0.34, 150.0)
EQUATION = fr.Mathieu(0.5, -0.25)
TWO = [[1.0, 0.0], [0.0, 4.0]]
WAVE = [[[0.1, 0.2], [0.2, 0.16]]]
SIZES: dict[str, Any] = {"radius": 0.8e-3, "length": 3.1, "channel_radius": 4.7e-3}
pendulum: Any = lambda a, b: fr.Mathieu(a, b)  # noqa: E731

Call = Callable[[], Any]
MISTAKES: list[tuple[Call, str, str, str]] = [
    # the call; the argument, what came and the remedy that its answer names
    (lambda: fr.Rod("68GPa", 6500, radius="three", length=3.1, channel_radius=1), "radius", "'three'", "mm"),
    (lambda: fr.Rod("68GPa", 6500, radius="3 parsec", length=3.1, channel_radius=1), "radius", "parsec", "mm"),
    (lambda: fr.Rod(68e9, 6500, length=3.1, channel_radius=1), "radius", "must be given", "diameter"),
    (lambda: fr.Rod(density=6500, **SIZES), "youngs_modulus", "must be given, in Pa", "or sections"),
    (lambda: fr.Rod(68e9, **SIZES), "density", "must be given, in kg/m3", "or weight"),
    (lambda: fr.Rod(young_modulus=68e9, density=6500, **SIZES), "Rod()", "'young_modulus'", "youngs_modulus?"),
    (lambda: fr.Rod(68e9, 6500, **SIZES, dampingrate=1), "Rod()", "'dampingrate'", "did you mean damping_rate?"),
    (lambda: ROD.replace(lenght=3), "Rod()", "'lenght'", "did you mean length?"),
    (
        lambda: ROD.replace(damping_ratio=0.01),
        "Rod()",
        "'damping_ratio'",
        "give damping_rate in 1/s, the ratio times the",
    ),
    (lambda: ROD.replace(log_decrement=0.06), "Rod()", "'log_decrement'", "the decrement times the frequency in Hz"),
    (lambda: ROD.replace(outer_diameter=1e-3), "Rod()", "'outer_diameter'", "the outer diameter is diameter"),
    (lambda: ROD.replace(length=-3), "length", "-3", "give it in m"),
    (lambda: ROD.replace(length=True), "length", "True", "give it in m"),
    (lambda: ROD.replace(radius=9.4e-3), "channel_radius", "0.0094", "half of channel_diameter"),
    (lambda: ROD.replace(diameter=1e-3, radius=1e-3), "diameter", "0.001", "give one of them"),
    (lambda: ROD.replace(inclination=60), "inclination", "60", "radians"),
    (lambda: ROD.replace(ends="clampd"), "ends", "'clampd'", "did you mean clamped?"),
    (lambda: ROD.replace(fluid_outside=13.6e3), "fluid_outside", "13600", "lighter"),
    (lambda: fr.Rod.catalogue("2.00x0.15", bore=0.12, length=60), "name", "2.00x0.15", "2.00x0.156"),
    (lambda: fr.Rod.catalogue("2.00x0.156 CT95", bore=0.12, length=60), "name", "CT95", "CT90"),
    (lambda: fr.Rod.catalogue("2.00x0.156", bore=4.778, length="60 yards"), "length", "60 yards", "ft"),
    (lambda: fr.Rod.catalogue("2.00x0.156", bore=0.0254, length=60), "bore", "0.0254", "4.778in"),
    (lambda: fr.AxialLoad(mean=1, amp=2, frequency=3), "AxialLoad()", "'amp'", "amplitude"),
    (lambda: fr.AxialLoad(mean=1, amplitude=2, freqency=3), "AxialLoad()", "'freqency'", "did you mean frequency?"),
    (lambda: fr.AxialLoad(1.0, 2.0), "'frequency'", "missing", "mean, amplitude, frequency"),
    (lambda: fr.AxialLoad(1.0, 2.0, 0), "frequency", "0", "set amplitude=0"),
    (lambda: fr.AxialLoad(1.0, -2.0, 3), "amplitude", "-2", "give its size"),
    (lambda: fr.AxialLoad("0.2Fcr", 2.0, 3), "mean", "0.2Fcr", "times rod.critical_force"),
    (lambda: fr.AxialLoad(1.0, 2.0, "24 herz"), "frequency", "herz", "Hz"),
    (lambda: fr.AxialLoad.hertz(1.0, 2.0, "24N"), "frequency", "'24N'", "it is a unit of force"),
    (lambda: fr.AxialLoad(float("nan"), 2.0, 3), "mean", "nan", "give it in N"),
    (lambda: fr.AxialLoad([1.0, 2.0], 2.0, 3), "mean", "[1.0, 2.0]", "give it in N"),
    (lambda: ROD.stability(0.34), "load", "0.34", "AxialLoad"),
    (lambda: ROD.stability(500, 100, 6), "Rod.stability()", "given", "fr.AxialLoad(mean, amplitude, frequency)"),  # type: ignore[call-overload]
    (lambda: ROD.stability(mean=500), "Rod.stability()", "'mean'", "fr.AxialLoad(mean, amplitude, frequency)"),  # type: ignore[call-overload]
    (
        lambda: ROD.critical_kick(500, 100, 6, friction=0.1),
        "Rod.critical_kick()",
        "given",
        "mean=, amplitude=, frequency=",
    ),  # type: ignore[call-arg,misc]
    (lambda: ROD.stability([LOAD, LOAD]), "load", "[AxialLoad", "must be an AxialLoad"),
    (lambda: ROD.stability(LOAD, growth_tol=1), "Rod.stability()", "'growth_tol'", "unexpected keyword"),
    (lambda: ROD.stability(LOAD, friction=0.1), "kick", "friction", "kick"),
    (lambda: ROD.stability(LOAD, [0]), "modes[0]", "0", "1 or more"),
    (
        lambda: ROD.ranges("mean", amplitude=0.3, frequency=150.0, bounds=(1.0, 0.5)),
        "bounds",
        "(1, 0.5)",
        "lower end first",
    ),
    (lambda: fr.stability(0.5, -0.25), "equation", "0.5", "HillSystem"),  # type: ignore[call-overload]
    (lambda: fr.stability(LOAD), "equation", "AxialLoad", "Mathieu"),  # type: ignore[call-overload]
    (lambda: fr.stability(EQUATION, "monodrmy"), "method", "'monodrmy'", "did you mean monodromy?"),
    (lambda: fr.stability(EQUATION, "monodromy", tol=1e-9), "stability()", "'tol'", "unexpected keyword"),
    (lambda: fr.stability(EQUATION, rtol=1e-9), "method", "rtol", "name a method"),
    (lambda: fr.Mathieu(a=1.2, q=0.9), "Mathieu()", "'a'", "Mathieu.from_aq(a, q)"),
    (lambda: fr.Mathieu(delta=0.6, epsilon=0.2), "Mathieu()", "'delta'", "Mathieu.from_delta_epsilon(delta, epsilon)"),
    (lambda: fr.Meissner(delta=0.6, epsilon=0.2), "Meissner()", "'delta'", "beta is -delta"),
    (lambda: fr.FrictionalMathieu(delta=0.6, epsilon=0.2, gamma=1), "FrictionalMathieu()", "'delta'", "from_delta"),
    (lambda: fr.mathieu.is_stable(delta=0.6, epsilon=0.2), "is_stable()", "'delta'", "conventions.from_delta_epsilon"),
    (lambda: fr.Mathieu(alpha=0.5, betta=0.9), "Mathieu()", "'betta'", "did you mean beta?"),
    (lambda: fr.Mathieu(0.5 + 1j, 0.9), "alpha", "0.5+1j", "real number"),  # type: ignore[arg-type]
    (lambda: fr.Mathieu(0.5, 0.9, damping=-1), "damping", "-1", "zero or more"),
    (lambda: fr.Hill(-0.25, cosine=(0.1,)), "Hill()", "'cosine'", "did you mean cosines?"),
    (lambda: fr.HillSystem([[1.0, 0.0]], WAVE), "stiffness", "(1, 2)", "square"),
    (lambda: fr.HillSystem(TWO, WAVE, mass=[[1.0, 0.5], [0.0, 1.0]]), "mass", "0.5", "symmetric"),
    (lambda: fr.HillSystem(TWO, WAVE, periode=2), "HillSystem()", "'periode'", "did you mean period?"),
    (lambda: fr.HillSystem(TWO, WAVE, frequency=2), "HillSystem()", "'frequency'", "period is 2 pi / frequency"),
    (lambda: fr.solve(EQUATION, [1.0], 20.0), "initial", "1", "2"),
    (lambda: fr.solve(EQUATION, [1.0, 0.0], span=0.0), "span", "0", "from one time to another"),
    (lambda: fr.chart(pendulum, {"a": (1.0, 0.0, 5), "b": (0.0, 1.0, 5)}), "a", "1", "0"),
    (lambda: fr.chart(pendulum, {"a": (0.0, 1.0, 0), "b": (0.0, 1.0, 5)}), "a", "0", "or more"),
    (lambda: fr.mathiue, "floquetrod", "'mathiue'", "did you mean mathieu?"),  # type: ignore[attr-defined]
    (lambda: fr.AxialLoad("4:8N", 1, 1), "mean", "4:8N", "one value is needed"),  # type: ignore[arg-type]
    (lambda: fr.ensembles.Runs.load(Path(__file__).parent), "Runs.load", "folder", "open_zarr"),
    (
        lambda: ROD.replace(channel_diameter=1e-3),
        "channel_radius",
        "0.0005 m",
        "half of channel_diameter = 0.001 m and of diameter = 0.0016 m",
    ),
    (lambda: fr.mathieu.exponent, "mathieu", "'exponent'", "did you mean exponents?"),  # type: ignore[attr-defined]
    (lambda: fr.NonlinearSystem(lambda x, t: (x[1], -x[0])), "function", "(x, t)", "t and x in this order"),
    (lambda: fr.stable, "floquetrod", "'stable'", "did you mean stability?"),  # type: ignore[attr-defined]
    (lambda: ROD.stable(LOAD), "Rod", "'stable'", "did you mean is_stable?"),  # type: ignore[attr-defined]
    (lambda: LOAD.freq, "AxialLoad", "'freq'", "frequency"),  # type: ignore[attr-defined]
    (lambda: EQUATION.periods, "Mathieu", "'periods'", "did you mean period?"),  # type: ignore[attr-defined]
    (lambda: fr.stability(EQUATION).is_stable, "Stability", "'is_stable'", "stable?"),  # type: ignore[attr-defined]
    (lambda: fr.stability(EQUATION).eigenvalues, "Stability", "'eigenvalues'", "multipliers"),  # type: ignore[attr-defined]
    (lambda: bool(fr.stability(EQUATION)), "Stability", "truth value", "look at .stable"),
    (lambda: fr.certify(EQUATION, alpha=1), "alpha", "value", "class"),
    (lambda: fr.compare(), "'equation'", "missing", "1 required positional"),  # type: ignore[call-arg]
    (lambda: fr.mathieu.is_stable(0.5, np.array([0.1, np.nan])), "beta", "nan", "remove"),
    (lambda: ROD.stability(LOAD).plot(ax=3), "ax", "3", "pyplot.subplots()"),
    (lambda: fr.mathieu.chart((0, 1, 3), (-1, 0, 3)).plot("top"), "ax", "'top'", "pyplot.subplots()"),
    (lambda: ROD.stability(LOAD).report(margins="mean"), "margins", "'mean'", "verdict.margins()"),
    (lambda: ROD.stability(LOAD).as_dict(margins={"mean": 3}), "margins", "{'mean': 3}", "verdict.margins()"),
    (lambda: fr.save_report(ROD.stability(LOAD), "a.html", command=3), "command", "3", "leave it out"),
    (lambda: fr.save_report(ROD.stability(LOAD), "a.html", margins="mean"), "margins", "'mean'", "True or False"),
    (lambda: fr.methods.discriminant_excess(EQUATION, digits=math.inf), "digits", "inf", "integer"),
    (lambda: fr.methods.discriminant_excess(0.5), "equation", "0.5", "Mathieu"),  # type: ignore[arg-type]
]


@pytest.mark.parametrize(("call", "argument", "came", "remedy"), MISTAKES)
def test_mistakes_are_answered_with_the_way_out(call: Call, argument: str, came: str, remedy: str) -> None:
    with pytest.raises((TypeError, ValueError, AttributeError)) as answer:
        call()
    text = str(answer.value)
    assert argument in text
    assert came in text
    assert remedy in text


def test_the_same_words_for_a_rod_file(tmp_path: Path) -> None:
    path = tmp_path / "rod.toml"
    path.write_text('outer_diameter = "0.5in"\n', encoding="utf-8")
    with pytest.raises(ValueError, match="unknown key 'outer_diameter'; the outer diameter is diameter"):
        fr.Rod.from_toml(path)


@pytest.mark.parametrize("name", ["equations", "units", "plane"])
def test_modules_that_are_not_loaded_are_named(name: str) -> None:
    code = f"import floquetrod as fr; fr.{name}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert f"'{name}'; it is a module: import floquetrod.{name}" in done.stderr


def test_there_are_forty_of_them() -> None:
    assert len(MISTAKES) >= 40


def test_what_tells_remedies_is_otherwise_invisible() -> None:
    assert list(inspect.signature(fr.Mathieu).parameters) == ["alpha", "beta", "damping"]
    assert inspect.signature(fr.compare).return_annotation == "Comparison | ResponseComparison"
    for value in (ROD, LOAD, EQUATION, fr.stability(EQUATION)):
        assert pickle.loads(pickle.dumps(value)) == value == copy.deepcopy(value)
        assert not hasattr(value, "__array__")
    assert pickle.loads(pickle.dumps(fr.solve)) is fr.solve
    assert dataclasses.replace(EQUATION, alpha=0.3) == fr.Mathieu(0.3, -0.25)


def test_errors_from_within_keep_their_words() -> None:
    def wrong(a: float, b: float) -> fr.Mathieu:
        raise TypeError("unexpected: a wall of my own")

    with pytest.raises(ValueError, match=r"raised TypeError: unexpected: a wall of my own$"):
        fr.chart(wrong, {"a": (0.0, 1.0, 2), "b": (0.0, 1.0, 2)})


def test_attributes_that_fail_within_keep_their_words() -> None:
    class Broken(fr.Mathieu):
        @property
        def broken(self) -> Any:
            return ().missing  # type: ignore[attr-defined]

    with pytest.raises(AttributeError, match="'tuple' object has no attribute 'missing'"):
        _ = Broken(0.5, -0.25).broken  # type: ignore[call-arg]
