"""What a simulation is computed with has a version, which is raised whenever the numbers change.

`data/arithmetic.json` keeps that version, a digest of every function and kernel that a run calls, and numbers.  A
digest leaves out what computes nothing: docstrings, comments, layout, annotations, the texts of errors.  Where one has
changed, raise `floquetrod.simulation.arithmetic.VERSION` unless no problem can come out in other bits, and then
write the file anew: python -m tests.simulation.test_arithmetic
"""

from __future__ import annotations

import ast
import functools
import hashlib
import inspect
import json
import pickle
import sys
from collections.abc import Callable, Iterator
from dataclasses import fields
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.ensembles.tasks import results
from floquetrod.simulation import arithmetic, integration

KEPT = Path(__file__).parents[1] / "data" / "arithmetic.json"
PACKAGE = Path(fr.__file__).parent
AROUND = {"_util/compilation.py", "_util/validate.py", "_util/calling.py", "_util/caching.py"}
"""Files whose functions only check, compile or call: what they hand on is the same or an error."""

LOAD = fr.AxialLoad(0.3, 0.3, 150.0)
TIME = np.linspace(0.0, 1.0, 2001)
RECORD = fr.ForceRecord(TIME, 0.3 + 0.2 * np.cos(150.0 * TIME) + 0.1 * np.sin(300.0 * TIME))
KICKS = fr.Perturbation.modes({3: 0.02, 5: -0.1}) + fr.Perturbation.random(1e-2, seed=3)

PATH = fr.WellPath.arc(length=4.0, inclination=(1.2, 1.4), azimuth=(0.4, 0.6))
TOOL = fr.VibrationTool(0.1, 700.0, 1.0)
SECTIONS = [
    fr.Section(length=1.7, radius=8e-4, youngs_modulus=68e9, density=6500.0),
    fr.Section(length=1.4, radius=6e-4, youngs_modulus=180e9, density=7850.0),
]
STRING = fr.Rod(sections=SECTIONS, bores=[(0.0, 9.4e-3), (2.2, 10e-3)], damping_rate=3.0)

pytestmark = pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")  # a laboratory's bend


def problems() -> dict[str, fr.SimulationProblem]:
    """Return one problem for every way that a run is computed in."""
    rod, wave = fr.Rod.nitinol(), fr.AxialWave(0.3, 0.3, 150.0, far_end="held", axial_damping=2.0)

    def problem(rod: fr.Rod, load: Any, **options: Any) -> fr.SimulationProblem:
        return fr.SimulationProblem(rod, load, **{"duration": 0.02, "frames": 11, **options})

    return {
        "without friction": problem(rod, LOAD),
        "growing": problem(rod, LOAD, duration=0.3, frames=101),
        "with friction": problem(rod, LOAD, friction=0.1, perturbation=KICKS, segments=60),
        "clamped and damped": problem(rod.replace(ends="clamped", damping_rate=3.0), LOAD, contact_damping=0.5),
        "in a fluid, inclined": problem(rod.replace(inclination=0.5, fluid_outside=1000.0), LOAD, friction=0.1),
        "fed": problem(rod, fr.AxialLoad(0.3, 0.0, 1.0), feed_speed=1e-3, friction=0.2, indentation=1e-4),
        "wave to a held end": problem(rod, wave, segments=60),
        "wave to a driven end": problem(rod, fr.AxialWave(0.3, 0.3, 150.0, far_end="driven"), far_force=0.2),
        "wave to a free end": problem(rod, fr.AxialWave(0.3, 0.3, 150.0, far_end="free"), far_force=0.2),
        "measured": problem(rod, RECORD, friction=0.1),
        "stopped early": problem(rod, LOAD, duration=0.2, frames=101, perturbation=KICKS, stop_early=True),
        "in a well": problem(rod.replace(path=PATH, damping_rate=3.0), LOAD, friction=0.1, tool=TOOL),
        "of sections": problem(STRING, LOAD, friction=0.1),
        "of sections, without friction": problem(STRING.replace(ends="clamped"), LOAD),
        "of sections in a well": problem(STRING.replace(path=PATH), LOAD, tool=TOOL),
        "in a well, clamped": problem(rod.replace(path=PATH, ends="clamped"), wave, natural_curvature=0.3),
    }


def numbers(name: str) -> list[float]:
    """Return numbers of a problem: segments, steps, the results of an ensemble, and what the last frame holds."""
    return list(map(float, _numbers(problems()[name])))


def _numbers(problem: fr.SimulationProblem) -> Iterator[float]:
    run = problem.run()
    yield from (problem.segments, problem.time_steps.count, run.time.size)
    yield from (value for name, value in results(run).items() if name not in ("wall_time", "energy_error"))
    yield from (np.abs(values[-1]).mean() for values in (run.positions, run.velocities, run.end_forces))
    most = max(np.abs(values).max() for values in run.energy.values())
    yield from (values[-1] / most for values in run.energy.values())


class Called:
    """The functions of the package that a piece of work calls, kernels too: they are interpreted meanwhile."""

    def __init__(self) -> None:
        self.functions: dict[tuple[Path, str], dict[str, Any]] = {}
        self.known: set[CodeType] = set()

    def __call__(self, frame: FrameType, event: str, argument: Any) -> None:
        """Note the first call of each function."""
        code = frame.f_code
        if event != "call" or code in self.known:
            return
        self.known.add(code)
        path = Path(code.co_filename)
        if path.is_relative_to(PACKAGE) and code.co_flags & inspect.CO_OPTIMIZED:
            self.functions[path, code.co_qualname.partition(".<locals>")[0]] = frame.f_globals

    def by(self, work: Callable[[], object]) -> None:
        """Note what a piece of work calls."""
        sys.setprofile(self)
        try:
            work()
        finally:
            sys.setprofile(None)


@functools.cache
def digests() -> dict[str, str]:
    """Return a digest of every function that makes frames from a problem, and results from frames.

    Of growth by theory, to which results compare a fit, and by which segments are chosen where none are given, the
    numbers are kept alone.
    """
    frames, made = Called(), problems()["growing"].run()
    with pytest.MonkeyPatch.context() as interpreted:
        interpreted.setattr(integration, "compiled", lambda kernel: kernel)
        interpreted.setattr(integration, "compiled_for", lambda kernel, *arguments: kernel)
        for problem in problems().values():
            few = problem.replace(segments=48, time_step=1e-5, frames=2, duration=2e-5)
            fresh = pickle.loads(pickle.dumps(few))  # without what was computed when it was made
            _forget_computed(fresh.rod)
            _forget_computed(fresh.load)
            frames.by(lambda fresh=fresh: fresh._integration().run(None))
    shown = Called()
    shown.by(lambda: results(made))
    own = {key: scope for key, scope in shown.functions.items() if key[0].parent.name in ("simulation", "ensembles")}
    return {
        f"{path.relative_to(PACKAGE).as_posix()} {name}": digest(path, name, scope)
        for (path, name), scope in sorted((frames.functions | own).items())
        if path.relative_to(PACKAGE).as_posix() not in AROUND
    }


def _forget_computed(value: Any) -> None:
    """Leave of a value what it was made with, so that a run computes the rest, whatever has been asked of it before."""
    for name in value.__dict__.keys() - {part.name for part in fields(value)}:
        if hasattr(type(value), name):
            del value.__dict__[name]


def digest(path: Path, name: str, scope: dict[str, Any]) -> str:
    """Return what changes with what a function computes: its statements, and the constants of the module it reads."""
    node = _definitions(path)[name]
    read = sorted({part.id for part in ast.walk(node) if isinstance(part, ast.Name)} & scope.keys())
    constants = [(each, scope[each]) for each in read if _is_plain(scope[each])]
    return hashlib.sha256(repr((_essence(node), constants)).encode()).hexdigest()[:12]


def _is_plain(value: object) -> bool:
    """Return whether a value is a number, a text, or a tuple of such, which no other function has made."""
    return all(map(_is_plain, value)) if type(value) is tuple else isinstance(value, int | float | str | None)


@functools.cache
def _definitions(path: Path) -> dict[str, ast.AST]:
    """Return the functions of a file and of its classes by their qualified names."""
    found: dict[str, ast.AST] = {}

    def walk(node: ast.AST, prefix: str) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.FunctionDef):
                found[prefix + child.name] = child
            elif isinstance(child, ast.ClassDef):
                walk(child, f"{prefix}{child.name}.")
            else:
                walk(child, prefix)

    walk(ast.parse(path.read_text()), "")
    return found


_EMPTY = (ast.Pass, ast.Raise)
_LEFT_OUT = {"annotation", "returns", "type_comment", "type_params", "ctx", "kind", "simple"}


def _essence(part: Any) -> Any:
    """Return a syntax tree as plain data, without what computes nothing."""
    if isinstance(part, list):
        return [_essence(each) for each in part if not isinstance(each, _EMPTY) and not _is_text(each)]
    if not isinstance(part, ast.AST):
        return repr(part)
    named = ((name, value) for name, value in ast.iter_fields(part) if name not in _LEFT_OUT)
    return type(part).__name__, [(name, _essence(value)) for name, value in named if value not in (None, [])]


def _is_text(node: object) -> bool:
    """Return whether a statement is a docstring."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


@pytest.mark.slow
def test_the_code_of_simulations_has_changed_only_with_its_version() -> None:
    kept, now = json.loads(KEPT.read_text()), digests()
    assert kept["version"] == arithmetic.VERSION, __doc__
    changed = sorted(name for name in now.keys() | kept["digests"].keys() if now.get(name) != kept["digests"].get(name))
    assert not changed, f"{', '.join(changed)}; {__doc__}"


@pytest.mark.slow
def test_what_a_run_calls_is_seen() -> None:
    """Steps, contact with friction, what a rod is made of, an early end, results."""
    for name in (
        "kernels/rod_step.py advance",
        "kernels/rod_step.py rub",
        "kernels/well_anchors.py follow",
        "cross_section.py CrossSection.area",
    ):
        assert any(each.endswith(name) for each in digests())
    assert {"simulation/recorded_motion.py EarlyEnd.of", "simulation/growth.py fit_growth"} <= digests().keys()


def test_the_same_problems_are_kept() -> None:
    assert json.loads(KEPT.read_text())["numbers"].keys() == problems().keys()


@pytest.mark.parametrize(
    "name",
    # Compiling the kernel for a string of sections in a well takes ten seconds; its code is in the digests.
    [pytest.param(name, marks=[pytest.mark.slow] * (name == "of sections in a well")) for name in problems()],
)
def test_the_numbers_of_simulations_have_changed_only_with_their_version(name: str) -> None:
    """To six digits: a kick larger by 1e-13, far more than roundings of another processor, changes them by 4e-8."""
    np.testing.assert_allclose(numbers(name), json.loads(KEPT.read_text())["numbers"][name], rtol=1e-6, atol=1e-9)


def test_a_digest_changes_with_what_is_computed_and_with_nothing_else(tmp_path: Path) -> None:
    def of(text: str, limit: float = 2.0) -> str:
        path = tmp_path / f"{hashlib.sha256(text.encode()).hexdigest()}.py"
        path.write_text(text)
        return digest(path, "f", {"LIMIT": limit})

    plain = "def f(x):\n    if x < 0:\n        raise ValueError('negative')\n    return LIMIT * x\n"
    told = '"""A file."""\n\ndef f(x: float) -> float:\n    """Return twice x."""\n    if (x < 0):  # no root\n'
    told += '        raise ValueError(f"x must not be negative, got {x}")\n    return LIMIT * x\n'
    assert of(plain) == of(told)
    assert len({of(plain), of(plain, 2.5), of(plain.replace("<", "<=")), of(plain.replace("* x", "* x * x"))}) == 4


def _write() -> None:
    """Write the file anew; not with other numbers under the same version."""
    if KEPT.exists() and json.loads(KEPT.read_text())["version"] == arithmetic.VERSION:
        for name in problems():
            test_the_numbers_of_simulations_have_changed_only_with_their_version(name)
    every = {name: numbers(name) for name in problems()}
    content = {"version": arithmetic.VERSION, "digests": digests(), "numbers": every}
    KEPT.write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    _write()
