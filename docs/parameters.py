"""One entry for every parameter in the reference, with its default.

Where a docstring has no entry of its own for a parameter the reference shows that of the docstring it refers to
("arguments as in `fates`"), or what SHARED says of parameters that stand in many methods alike.  Defaults are those of
the signature.
"""

from __future__ import annotations

import inspect
import pkgutil
import re
from typing import TYPE_CHECKING, Any

import floquetrod

if TYPE_CHECKING:
    import sphinx.application

LOADS = "A number, or an array of a shape that broadcasts with those of the other two."
TOLERANCE = "Growth rate in 1/s up to which a mode counts as stable; 0 or more."
SHARED = {
    "floquetrod.Rod.": {
        "load": (
            "AxialLoad, AxialWave or ForceRecord",
            "The axial force: mean and amplitude in N, frequency in rad/s.",
        ),
        "mean": ("{number}", "Mean force F_ave in N, positive in compression, any finite number.{loads}"),
        "amplitude": ("{number}", "Amplitude dF of the vibration in N, 0 or more.{loads}"),
        "frequency": ("{number}", "Angular frequency omega in rad/s, greater than 0.{loads}"),
        "growth_tolerance": ("float", TOLERANCE),
        "friction": ("float", "Coefficient of friction with the wall, without unit, static and kinetic; 0 or more."),
        "kick": ("float", "Transverse velocity in m/s that every mode is given, 0 or more.  It needs ``friction``."),
    },
    "floquetrod.friction.": {
        "equation": ("FrictionalMathieu", "Mathieu's equation with friction."),
        "kick": ("float", "Velocity A'(0) per unit tau, 0 or more."),
        "max_steps": ("int", "Stops and steps of an orbit after which it is left undecided; 1 or more."),
    },
    "floquetrod.FiniteTimeCriterion.": {
        "alpha": ("array_like", "Amplitude of the coefficient, without unit, any finite number."),
        "beta": ("array_like", "Mean of the coefficient, without unit, any finite number."),
        "damping": ("array_like", "Decay rate c per unit tau; any finite number."),
    },
    "floquetrod.WellPath.": {
        "depth": ("float, str or array_like", "Measured depth in m, or with a unit, on the path."),
    },
    "floquetrod.": {
        "path": ("str or Path", "The file."),
        "tau": (
            "float or array_like",
            "Dimensionless time, any finite number; the period is 2 pi unless another is given.",
        ),
        "t": ("float or array_like", "Time in s, or in the unit of the system, any finite number."),
        "figure": ("matplotlib.figure.Figure or SubFigure", "Figure to draw into; by default a new one."),
        "ax": ("matplotlib.axes.Axes", "Axes to draw into; by default those of a new figure."),
        "workers": ("int", "Threads, 1 or more; by default one for each processor."),
        "progress": (
            "callable",
            "Called repeatedly with the work done and all work; an exception that it raises ends the work.",
        ),
    },
}
"""Beginning of a public name: parameter: type and meaning, of any callable whose name begins so."""

LIKE = re.compile(r"(?:[Aa]rguments (?:are )?as in|(?:^|[.;] )See) `(\w+)`")
"""How a docstring refers to another one for its arguments."""

HEADING = re.compile(r"^([A-Z][a-z]+( [A-Z][a-z]+)?)\n-{3,}$", re.M)


def shared(place: str, parameter: inspect.Parameter) -> list[str]:
    """Return the entry that a parameter shares with others of its name, or nothing."""
    for prefix, entries in SHARED.items():
        if place.startswith(prefix) and parameter.name in entries:
            kind, text = entries[parameter.name]
            many = parameter.annotation in ("Any", Any)
            number = "float or array_like" if many else "float"
            said = text.format(loads=f"  {LOADS}" if many else "")
            return [f"{parameter.name} : {kind.format(number=number)}", f"    {said}"]
    return []


def referred(place: str, text: str) -> dict[str, list[str]]:
    """Return the entries of the docstring that a docstring refers to, or none."""
    found = LIKE.search(" ".join(text.split()))
    if not found:
        return {}
    beside = pkgutil.resolve_name(place.rpartition(".")[0])
    other = getattr(beside, found[1], None) or getattr(floquetrod, found[1])
    return own(parted(inspect.getdoc(other) or "")[1])


def with_default(entry: list[str], parameter: inspect.Parameter) -> list[str]:
    """Return an entry with the default of its parameter, where it does not say it itself."""
    default = parameter.default
    if default is None and "optional" not in entry[0]:
        return [f"{entry[0]}, optional", *entry[1:]]
    if isinstance(default, str | int | float | tuple) and "default" not in " ".join(entry):
        return [f"{entry[0]}, default {shown(default)}", *entry[1:]]
    return entry


def shown(default: Any) -> str:
    """Return a default as one would type it."""
    return f'"{default}"' if isinstance(default, str) else re.sub(r"(?<=\d)e([+-])0", r"e\1", repr(default))


def own(section: str) -> dict[str, list[str]]:
    """Return the entries of a section by the name of their parameter; parameters with one entry have one each."""
    entries: dict[str, list[str]] = {}
    names: list[str] = []
    for line in section.splitlines():
        if line and not line.startswith(" "):
            head, colon, kind = line.partition(" : ")
            names = head.split(", ")
            entries |= {name.strip("*"): [f"{name}{colon}{kind}"] for name in names}
        else:
            for name in names:
                entries[name.strip("*")].append(line)
    return entries


def parted(text: str) -> tuple[str, str, str]:
    """Return what precedes the section of parameters of a docstring, what stands in it, and what follows."""
    heads = list(HEADING.finditer(text))
    ends = [*(head.start() for head in heads), len(text)]
    for head, end in zip(heads, ends[1:], strict=True):
        if head[1] == "Parameters":
            return text[: head.start()], text[head.end() : end].strip("\n"), text[end:]
    example = re.search(r"^>>> ", text, re.M)
    end = min(ends[0], example.start() if example else len(text))
    return text[:end], "", text[end:]


def parameters(thing: Any) -> list[inspect.Parameter]:
    """Return the parameters one gives to a callable."""
    try:
        found = inspect.signature(thing).parameters.values()
    except (TypeError, ValueError):
        return []
    return [each for each in found if each.name not in ("self", "cls") and not each.name.startswith("_")]


def filled(place: str, thing: Any, text: str) -> str:
    """Return a docstring with an entry for every parameter that has one of its own or a shared one."""
    before, section, after = parted(text)
    entries, others = own(section), referred(place, text)
    for each in parameters(thing):
        entry = entries.pop(each.name, None) or others.get(each.name) or shared(place, each)
        entries |= {each.name: with_default(entry, each)} if entry else {}  # popped and put back: in their order
    if not entries:
        return text
    body = "\n".join(line for entry in entries.values() for line in entry).rstrip()
    after = f"Examples\n--------\n{after}" if after.startswith(">>>") else after
    return f"{before.rstrip()}\n\nParameters\n----------\n{body}\n\n{after}"


def fill(app: object, what: str, name: str, thing: Any, options: object, lines: list[str]) -> None:
    """Do so with what autodoc found, before napoleon reads it."""
    if what in ("function", "method", "class") and (what != "class" or "Parameters" in lines):
        lines[:] = filled(name, thing, "\n".join(lines)).splitlines()


def setup(app: sphinx.application.Sphinx) -> dict[str, bool]:
    """Fill docstrings in when the site is built."""
    app.connect("autodoc-process-docstring", fill, priority=400)
    return {"parallel_read_safe": True}
