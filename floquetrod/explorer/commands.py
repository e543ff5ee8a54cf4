"""The load on show as a command that gives the same verdict."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence

from floquetrod.rod.loads.load import AxialWave, Load
from floquetrod.rod.rod import Rod
from floquetrod.units import Unit


def command(rod: Rod, load: Load, shown: Mapping[str, Unit], options: Sequence[str] | None) -> str:
    """Return the command that checks exactly this load: the terminal's where it can name rod and load, else Python's.

    ``options`` of the terminal name the rod and a measured force; None finds them for nitinol.
    """
    options = _named(rod) if options is None else options
    if options is None or (load.waveform != "sine" and "--force" not in options):
        return f"rod.stability(fr.{load!r})"
    words = ["floquetrod", "check", *options, *_kind(load)]
    for name, unit in shown.items():
        text = written(getattr(load, name), unit)
        words += [f"--{name}={text}"] if text.startswith("-") else [f"--{name}", text]
    return shlex.join(words)


def written(value: float, unit: Unit) -> str:
    """Return an SI value in a unit, in as few digits as give exactly this value; in SI where none do.

    >>> from floquetrod import units
    >>> written(0.3, units.unit("N", "--mean", "force")), written(0.1, units.unit("kN", "--mean", "force"))
    ('0.3N', '0.0001kN')
    """
    for digits in range(1, 18):
        text = repr(float(f"{unit.of(value):.{digits}g}")).removesuffix(".0")
        if float(unit.si(float(text))) == value:
            return f"{text}{unit.name}"
    return repr(value)


def _named(rod: Rod) -> list[str] | None:
    """Return the options that name a rod that the terminal knows by name, None for any other."""
    known = Rod.nitinol()
    if rod == known:
        return ["--rod", "nitinol"]
    if rod == known.replace(damping_rate=rod.damping_rate):
        return ["--rod", "nitinol", "--damping-rate", repr(rod.damping_rate)]
    return None


def _kind(load: Load) -> list[str]:
    """Return the options that say what kind of load it is."""
    words = [] if load.mean_at == 0.5 else ["--mean-at", "none" if load.mean_at is None else repr(load.mean_at)]
    if isinstance(load, AxialWave):
        words += ["--wave", load.far_end]
        words += ["--axial-damping", repr(load.axial_damping)] if load.axial_damping else []
    return words
