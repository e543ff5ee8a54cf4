"""The public interface as a table of names, and ratios of speed; both kept in snapshot.json.

Of Python it has every name of `floquetrod` and of its public modules, and every other name that the reference lists,
with methods, fields, parameters and defaults; of the terminal the commands with their arguments and options, what these
take and their defaults; of files the keys.
"""

from __future__ import annotations

import argparse
import dataclasses
import importlib
import inspect
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import floquetrod as fr
from floquetrod.cli.main import _parser
from floquetrod.equations.system_files import read_system

SNAPSHOT = Path(__file__).parent / "snapshot.json"
ROOT = Path(__file__).parents[2]
MODULES = (
    "conventions",
    "ensembles",
    "friction",
    "mathieu",
    "methods",
    "results",
    "rod.model.catalogue",
    "simulation",
    "systems",
    "units",
)

CONSTRUCTED = {
    "Rod",
    "AxialLoad",
    "AxialWave",
    "ForceRecord",
    "Mathieu",
    "Meissner",
    "SquareWave",
    "Hill",
    "HillSystem",
}
CONSTRUCTED |= {
    "PeriodicSystem",
    "FrictionalMathieu",
    "FiniteTimeCriterion",
    "Perturbation",
    "SimulationProblem",
    "Explorer",
    "DelaySystem",
    "Milling",
    "NonlinearSystem",
    "Section",
    "ToolMode",
    "VibrationTool",
    "WellPath",
}
"""Classes that people construct: of all others the arguments are the package's own business."""

RESULTS = {
    "AxialResponse": "ROD.axial_response(LOAD)",
    "CriticalKick": "ROD.critical_kick(LOAD, friction=0.1)",
    "FloquetSolution": "fr.mathieu.characteristic_function(1, 1.0, 'a')",
    "LockUp": "ROD.lock_up(0.2)",
    "Margin": "ROD.stability(LOAD).margin('mean')",
    "ModalSystem": "ROD.modal_system(LOAD)",
    "Pipe": "__import__('floquetrod.rod.model.catalogue').rod.model.catalogue.pipes()[0]",
    "Stress": "ROD.stress(LOAD)",
    "StabilityInterval": "RANGES.intervals[0]",
    "SystemStability": "fr.stability(fr.HillSystem([[1.0]], [[[0.2]]]))",
    "UnstableBand": "RANGES.unstable[0]",
}
"""Results whose classes are not among the public names, each with a question that returns one."""


def interface() -> dict[str, str]:
    """Return every public name with what it is: of parameters place and default, of options their values."""
    table = dict(_terminal()) | dict(_files())
    for name in fr.__all__:
        table |= _of(f"floquetrod.{name}", getattr(fr, name))
    for path in MODULES:
        module = importlib.import_module(getattr(getattr(fr, path, None), "__name__", f"floquetrod.{path}"))
        public = getattr(module, "__all__", None) or [
            n for n, v in vars(module).items() if not n.startswith("_") and _is_own(v, module.__name__)
        ]
        for name in public:
            table |= _of(f"floquetrod.{path}.{name}", getattr(module, name))
    for path in _documented():
        if path not in table:
            owner, _, name = path.rpartition(".")
            table |= _of(path, getattr(importlib.import_module(owner), name))
    rod = fr.Rod.nitinol()
    load = fr.AxialLoad(0.34, 0.34, 150.0)
    known = {
        "fr": fr,
        "ROD": rod,
        "LOAD": load,
        "RANGES": rod.ranges("frequency", mean=0.34, amplitude=0.34, bounds=(100.0, 160.0)),
    }
    for name, question in RESULTS.items():
        table |= _of(f"result {name}", type(eval(question, known)))
    return dict(sorted(table.items()))


def _documented() -> list[str]:
    """Return the functions and classes that the reference lists, by their full names."""
    pages = sorted((ROOT / "docs/reference").glob("*.rst"))
    text = "".join(page.read_text(encoding="utf-8") for page in pages)
    return re.findall(r"(?m)^\.\. auto(?:function|class|exception):: (floquetrod[\w.]+)", text)


def _is_own(value: Any, module: str) -> bool:
    return getattr(value, "__module__", None) == module and callable(value)


def _of(path: str, value: Any) -> dict[str, str]:
    """Return a public value and what belongs to it: parameters, fields, methods, properties."""
    if inspect.ismodule(value):
        return {path: "module"}
    if not inspect.isclass(value):
        return {path: "function"} | _parameters(path, value) if callable(value) else {path: "value"}
    table = {path: "class"} | (_parameters(path, value) if value.__name__ in CONSTRUCTED else {})
    names = set(dir(value)) | (
        {f.name for f in dataclasses.fields(value)} if dataclasses.is_dataclass(value) else set()
    )
    for name in sorted(n for n in names - set(dir(Exception)) - set(dir(tuple)) if not n.startswith("_")):
        member = getattr(value, name, None)
        if callable(member) and not inspect.isclass(member):
            table |= {f"{path}.{name}": "method"} | _parameters(f"{path}.{name}", member)
        else:
            table[f"{path}.{name}"] = "field"
    return table


def _parameters(path: str, function: Any) -> dict[str, str]:
    """Return parameters, those by position with their place; annotations are no part of it."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return {}
    found, place = {}, 0
    for p in parameters:
        if p.name.startswith("_") or (p.name == "self" and place == 0):
            continue
        kind = {p.KEYWORD_ONLY: "by name", p.VAR_KEYWORD: "others", p.VAR_POSITIONAL: "all"}.get(
            p.kind, f"place {place}"
        )
        place += kind.startswith("place")
        default = "" if p.default is p.empty else " = " + re.sub(r"<(\w+) '?([\w.]+).*>", r"<\1 \2>", repr(p.default))
        found[f"{path}({p.name})"] = kind + default
    return found


def _terminal() -> Iterator[tuple[str, str]]:
    """Yield the commands of the terminal, and their arguments and options with what they take and their defaults."""
    parser = _parser()
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, command in action.choices.items():
                yield f"floquetrod {name}", "command"
                for each in command._actions:
                    yield from _option(f"floquetrod {name}", each)
        else:
            yield from _option("floquetrod", action)


def _option(command: str, action: argparse.Action) -> Iterator[tuple[str, str]]:
    """Yield every name of an option, or of an argument, with what it takes and its default."""
    choices = "" if action.choices is None or action.metavar else "{" + ",".join(map(str, action.choices)) + "}"
    what = "flag" if action.nargs == 0 else choices or str(action.metavar or action.dest.upper())
    given = action.default if isinstance(action.default, list) else [action.default]
    said = ", ".join(str(value) for value in given if value not in (None, False, "", argparse.SUPPRESS))
    default = f" = {said}" if said else ""
    if action.required and action.nargs not in ("?", "*"):
        default = ", required"
    for name in action.option_strings or [what]:
        yield f"{command} {name}", f"{what if action.option_strings else 'argument'}{default}"


def _files() -> Iterator[tuple[str, str]]:
    """Yield the keys of files, which errors about an unknown key list."""
    asked: dict[str, tuple[Callable[[Path], Any], str, str]] = {
        "rod file": (fr.Rod.from_toml, "my_rod.toml", ""),
        "rod file [[sections]]": (fr.Rod.from_toml, "string.toml", "[[sections]]"),
        "tool file [tool]": (fr.Milling.from_toml, "tool.toml", "[tool]"),
        "tool file [[tool.x]]": (fr.Milling.from_toml, "tool.toml", "[[tool.x]]"),
        "system file [system]": (read_system, "system.toml", "[system]"),
        "study file": (fr.Study.from_toml, "study.toml", ""),
        "study file [load]": (fr.Study.from_toml, "study.toml", "[load]"),
        "study file [run]": (fr.Study.from_toml, "study.toml", "[run]"),
        "study file [start]": (fr.Study.from_toml, "study.toml", "[start]"),
        "study file [over]": (fr.Study.from_toml, "study.toml", "[over]"),
    }
    for where, (read, name, table) in asked.items():
        text = (ROOT / "floquetrod/examples" / name).read_text(encoding="utf-8")
        wrong = text.replace(table, f"{table}\nno_such_key = 1\n#", 1) if table else f"no_such_key = 1\n{text}"
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / name
            path.write_text(wrong, encoding="utf-8")
            try:
                read(path)
            except ValueError as error:
                keys = str(error).partition("keys are ")[2].split(", ")
        yield from ((f"{where} {key}", "key") for key in keys)


def changes(old: dict[str, str], new: dict[str, str]) -> tuple[list[str], list[str]]:
    """Return what breaks a caller, and what is only more: new names, and parameters that may be left out."""
    broken = [f"{name}: has disappeared, was {old[name]}" for name in old if name not in new]
    other = [name for name in old if name in new and new[name] != old[name]]
    may_be_left_out = [name for name in other if new[name] == old[name].removesuffix(", required")]
    broken += [f"{name}: was {old[name]}, is {new[name]}" for name in other if name not in may_be_left_out]
    more = [f"{name}: may be left out" for name in may_be_left_out]
    for name in new.keys() - old.keys():
        owner, _, parameter = name.partition("(")
        needed = bool(parameter) and owner in old and "=" not in new[name] and new[name] not in ("others", "all")
        (broken if needed else more).append(f"{name}: is new, {new[name]}")
    return sorted(broken), sorted(more)


# --- speed ------------------------------------------------------------------------------------------------------------


def speed() -> dict[str, float]:
    """Return how long some questions take, as ratios to a loop of plain Python in the same minute."""
    rod, load = fr.Rod.nitinol(), fr.AxialLoad(0.34, 0.34, 150.0)
    leaning = rod.replace(inclination=1.0)
    systems = {n: fr.HillSystem(np.diag(1.0 + np.arange(n)), [0.05 * np.ones((n, n))], period=2.0) for n in (2, 8)}
    alpha, beta = np.meshgrid(np.linspace(0.0, 2.0, 40), np.linspace(-2.0, 0.5, 40))
    plane: dict[str, Any] = {"mean": (0.1, 1.5, 20), "amplitude": 0.3, "frequency": (100.0, 200.0, 20)}
    asked: dict[str, Callable[[], Any]] = {
        "verdict on an equation": lambda: fr.stability(fr.Mathieu(0.5, -0.3, 0.01)),
        "verdicts, 1,600 equations": lambda: fr.mathieu.is_stable(alpha, beta, workers=1),
        "growth, 1,600 equations": lambda: fr.mathieu.growth_rate(alpha, beta, workers=1),
        "verdict on a system, n = 2": lambda: fr.stability(systems[2]),
        "verdict on a system, n = 8": lambda: fr.stability(systems[8]),
        "verdict on a rod": lambda: rod.stability(load),
        "verdict on a rod with coupled modes": lambda: leaning.stability(load),
        "map of a rod, 20 by 20": lambda: fr.stability_map(rod, **plane, workers=1),
        "map with friction, 20 by 20": lambda: fr.stability_map(rod, **plane, friction=0.1, kick=0.05, workers=1),
    }
    check = ["check", "--rod", "nitinol", "--mean", "0.2Fcr", "--amplitude", "0.2Fcr", "--frequency", "150rad/s"]
    asked["a cold check"] = lambda: subprocess.run(
        [sys.executable, "-m", "floquetrod", *check], capture_output=True, check=True
    )
    return {name: float(f"{_ratio(question):.3g}") for name, question in asked.items()}


def _ratio(question: Callable[[], Any]) -> float:
    """Return the seconds of a processor that a question takes over those of the loop, the least of five in turn."""
    question()  # compiles
    times = [(_seconds(question), _seconds(lambda: sum(map(math.sin, range(200_000))))) for _ in range(5)]
    return min(one for one, _ in times) / min(loop for _, loop in times)


def _seconds(question: Callable[[], Any]) -> float:
    """Return the seconds of a processor, those of child processes included."""
    begin = os.times()
    start = time.process_time()
    question()
    end = os.times()
    children = end.children_user + end.children_system - begin.children_user - begin.children_system
    return time.process_time() - start + children


def write(*, timed: bool = True) -> None:
    """Keep the interface of today and, ``timed``, its speed."""
    kept = {"interface": interface(), "speed": speed() if timed else stored()["speed"]}
    SNAPSHOT.write_text(json.dumps(kept, indent=0, ensure_ascii=False) + "\n", encoding="utf-8")


def stored() -> dict[str, Any]:
    """Return what is kept."""
    return dict(json.loads(SNAPSHOT.read_text(encoding="utf-8")))


def compare() -> int:
    """Print what has changed of the interface, and the speed for information; return how many changes break callers."""
    kept = stored()
    broken, more = changes(kept["interface"], interface())
    print(f"\n{'interface':32} {len(kept['interface']):5} names, {len(broken)} differ, {len(more)} new")
    print("".join(f"    DIFFERS: {line}\n" for line in broken) + "".join(f"    allowed: {line}\n" for line in more))
    print("speed, in loops of plain Python (never a difference)")
    for name, ratio in speed().items():
        print(f"    {name:40} was {kept['speed'].get(name, math.nan):8.3g}, is {ratio:8.3g}")
    return len(broken)
