"""What an ensemble varies: named values of a problem, its load, its rod and its start, and the problem of each run."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.caching import cached_property
from floquetrod.parameter import unknown
from floquetrod.rod.distributions import quantile_function, quantiles
from floquetrod.rod.loads.load import LOAD
from floquetrod.rod.loads.tool import NUMBERS_OF_TOOL
from floquetrod.rod.model.parameters import GIVEN, INSTEAD, NUMBERS, ROD, warn_of_friction
from floquetrod.simulation.simulation_problem import SimulationProblem
from floquetrod.simulation.start import Perturbation

LAYOUTS = ("grid", "list")
MOST_RUNS = 10**7  # of an ensemble: a gigabyte of results
_MOST_TRIED = 1000  # problems made before anything runs, to see whether any can be: a second at most
_LARGEST = sys.float_info.max
_NUMBERS = {"float": float, "int": int, "float | None": float, "int | None": int, "float | Intervals": float}
RUN_KINDS = {
    "duration": "time",
    "time_step": "time",
    "friction": "ratio",
    "poisson_ratio": "ratio",
    "indentation": "ratio",
    "contact_damping": "ratio",
    "feed_speed": "speed",
    "far_force": "force",
}
"""Kinds of the quantities of a problem; `floquetrod.units` has the units of each kind."""

TOOL_KINDS = {f"tool_{name}": parameter.kind for name, parameter in NUMBERS_OF_TOOL.items()}
VARIED_KINDS = {
    **{name: parameter.kind for name, parameter in GIVEN.items() if parameter.kind},
    **{name: parameter.kind for name, parameter in LOAD.items() if parameter.kind},
    **RUN_KINDS,
    **TOOL_KINDS,
    "kick": "speed",
}
"""Kinds of the quantities that may be varied; integers have none."""

OF_TOOL = {f"tool_{name}": name for name in NUMBERS_OF_TOOL}
START = ("kick", "seed")
RUN_SEED = "run_seed"
"""Name of the seeds of runs where every sample has seeds of its own."""


class VariedAxis(NamedTuple):
    """The values of one quantity along dimension ``dim``."""

    name: str
    dim: str
    values: NDArray[Any]

    @property
    def unit(self) -> str:
        """Its unit, "1" for a number without."""
        return units.unit("", self.name, VARIED_KINDS.get(self.name, "ratio")).name or "1"


def names_of(problem: SimulationProblem) -> dict[str, tuple[str, ...]]:
    """Return the names that may be varied, by what they belong to: "problem", "load", "rod", "tool", "start"."""
    ignored = {parameter.name for parameter in unknown(ROD, "simulation")}
    return {
        "problem": tuple(part.name for part in fields(problem) if part.type in _NUMBERS),
        "load": tuple(part.name for part in fields(problem.load) if part.type in _NUMBERS),
        "rod": tuple(name for name in (*NUMBERS, *INSTEAD) if INSTEAD.get(name, name) not in ignored),
        "tool": () if problem.tool is None else tuple(OF_TOOL),
        "start": START,
    }


@dataclass(frozen=True, eq=False)
class Design:
    """A problem and the axes along which it is varied; runs are numbered in the order of ``dims``, the last fastest."""

    problem: SimulationProblem
    axes: tuple[VariedAxis, ...]
    seed: int = 0  # of the values drawn

    @cached_property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions."""
        return tuple(dict.fromkeys(axis.dim for axis in self.axes))

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        lengths = {axis.dim: axis.values.size for axis in self.axes}
        return tuple(lengths[dim] for dim in self.dims)

    @cached_property
    def size(self) -> int:
        """Number of runs."""
        return int(np.prod(self.shape))

    def values(self, run: int) -> dict[str, float | int]:
        """Return the values of the varied quantities in a run, by name."""
        place = dict(zip(self.dims, np.unravel_index(run, self.shape), strict=True))
        quantities = {axis.name: axis.values[place[axis.dim]].item() for axis in self.axes}
        if self.has_own_seeds:
            quantities["seed"] = _own_seed(self.seed, int(place["sample"]), quantities["seed"])
        return quantities

    @property
    def has_own_seeds(self) -> bool:
        """Whether every sample has seeds of its own, so that runs of different samples are independent."""
        return {"sample", "seed"} <= set(self.dims)

    @cached_property
    def own_seeds(self) -> NDArray[np.int64]:
        """The seed of every run where samples have seeds of their own, (samples, seeds)."""
        by_dim = {axis.dim: axis.values for axis in self.axes}
        samples, seeds = len(by_dim["sample"]), by_dim["seed"].tolist()
        every = [[_own_seed(self.seed, sample, seed) for seed in seeds] for sample in range(samples)]
        return np.array(every, dtype=np.int64)

    def tried_first(self) -> Iterator[int]:
        """Yield runs that show whether any can be made: the first, then along every dimension, at most a thousand."""
        yield 0
        stride, left = self.size, _MOST_TRIED
        for length in self.shape:
            stride //= length
            for place in range(1, min(length, left)):
                yield place * stride
            left -= min(length, left)

    def require_possible(self) -> None:
        """Raise what making the first problem raises, unless another one can be made."""
        first: ValueError | None = None
        for run in self.tried_first():
            try:
                varied(self.problem, self.values(run))
                return
            except ValueError as error:
                first = first or error
        raise validate.wrong_value("over", f"makes only runs that are impossible, as far as tried; the first: {first}")


def varied(problem: SimulationProblem, values: Mapping[str, float | int]) -> SimulationProblem:
    """Return the problem of a run: pure in both arguments, whatever process it is called in."""
    names = names_of(problem)
    changes: dict[str, dict[str, Any]] = {
        part: {name: value for name, value in values.items() if name in known} for part, known in names.items()
    }
    own, load, rod, tool = (changes[part] for part in ("problem", "load", "rod", "tool"))
    if load:
        own["load"] = replace(problem.load, **load)
    if rod:
        own["rod"] = problem.rod.replace(**rod)
    if tool and problem.tool is not None:
        own["tool"] = replace(problem.tool, **{OF_TOOL[name]: value for name, value in tool.items()})
    kick = problem.perturbation
    if "seed" in values:
        # The first noise has this seed, others seeds that follow from it.
        seed = validate.integer("seed", int(values["seed"]), 0)
        seeds = [seed, *np.random.SeedSequence(seed).generate_state(len(kick.noises) - 1).tolist()]
        noises = tuple((speed, new) for (speed, _), new in zip(kick.noises, seeds, strict=True))
        own["perturbation"] = kick = replace(kick, noises=noises)
    changed = problem.replace(**own) if own else problem
    if "kick" not in values:
        return changed
    return changed.replace(perturbation=_scaled(kick, float(values["kick"]), changed.mesh.segments))


def _own_seed(drawn_with: int, sample: int, seed: int) -> int:
    """Return the seed of the run of a sample and a seed, of 62 bits, in an ensemble drawn with another seed."""
    low, high = seed & 0xFFFFFFFF, seed >> 32  # of known lengths: other numbers make other entropy
    words = np.random.SeedSequence([sample, low, high, drawn_with]).generate_state(1, np.uint64)
    return int(words[0]) >> 2


def _scaled(kick: Perturbation, speed: float, segments: int) -> Perturbation:
    """Return a perturbation scaled so that its largest speed is ``speed`` in m/s."""
    speed = validate.nonnegative("kick", speed, "in m/s")
    largest = float(np.abs(kick.velocities(segments)).max())
    if largest == 0.0:
        raise ValueError("kick scales the perturbation of the problem, which is zero; give it one")
    factor = speed / largest
    return Perturbation(
        tuple((mode, factor * own) for mode, own in kick.speeds),
        tuple((factor * own, seed) for own, seed in kick.noises),
    )


def design_of(problem: SimulationProblem, over: Any, layout: str, samples: Any, seed: Any) -> Design:
    """Return what the arguments of `floquetrod.ensemble` ask for, checked."""
    validate.instance("problem", problem, SimulationProblem, "fr.SimulationProblem(rod, load, duration=2.0), say")
    layout = validate.choice("layout", layout, LAYOUTS)
    seed = validate.integer("seed", seed, 0, 2**128 - 1)
    if not isinstance(over, Mapping):
        raise validate.wrong_type(
            "over", f"must map names to values such as {{'friction': [0.1, 0.2]}}, got {validate.short(over)}"
        )
    if not over:
        raise validate.wrong_value(
            "over", "must name at least one quantity to vary, got none; problem.run() makes a single run"
        )
    known = [name for names in names_of(problem).values() for name in names]
    for name in over:
        if name not in known:
            raise validate.wrong_value(
                "over", f"must name what can be varied, {', '.join(known)}; got {validate.short(name)}"
            )
    if "seed" in over and not problem.perturbation.noises:
        raise validate.wrong_value(
            "over", "varies the seed, but nothing is random: give the problem a Perturbation.random"
        )
    given = {name: _values(problem, name, value) for name, value in over.items() if quantile_function(value) is None}
    drawn = {name: value for name, value in over.items() if name not in given}
    count = _samples(samples, drawn, given if layout == "list" else {})
    given |= {name: _whole(problem, name, values) for name, values in _draw(drawn, count, seed)}
    if "friction" in drawn:  # values drawn are not checked one by one: a median as it would be typed stands for them
        warn_of_friction(float(f"{np.median(given['friction']):.2g}"))
    if layout == "list":
        lengths = {name: values.size for name, values in given.items()}
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{name} has {length:,}" for name, length in lengths.items())
            raise validate.wrong_value(
                "over", f"must hold as many values of each name where layout is 'list', got: {listed}"
            )
    dim = dims_of(over, layout)
    study = Design(problem, tuple(VariedAxis(name, dim[name], given[name]) for name in over), seed)
    runs = float(np.prod([float(length) for length in study.shape]))
    if runs > MOST_RUNS:
        raise validate.wrong_value("over", f"makes {runs:,.0f} runs, at most {MOST_RUNS:,} are made; vary less")
    study.require_possible()
    return study


def dims_of(over: Mapping[str, Any], layout: str) -> dict[str, str]:
    """Return the dimension along which each name varies: its own, "sample" of distributions, "run" of a list."""
    own = {name: name if quantile_function(given) is None else "sample" for name, given in over.items()}
    return dict.fromkeys(over, "run") if layout == "list" else own


def _values(problem: SimulationProblem, name: str, given: Any) -> NDArray[Any]:
    """Return the values given for a name, one-dimensional and not empty."""
    argument = f"over[{name!r}]"
    if isinstance(given, str | bytes | Mapping | set | frozenset) or not validate.iterable(given):
        raise validate.wrong_type(
            argument,
            f"must be a sequence of numbers such as [0.1, 0.2], or a frozen distribution such as "
            f"scipy.stats.uniform(0.1, 0.1), got {validate.short(given)}",
        )
    if name in VARIED_KINDS:
        given = units.si(given, argument, VARIED_KINDS[name])
    array = validate.array(argument, given, least=-_LARGEST, largest=_LARGEST)
    if array.ndim != 1 or not array.size:
        raise validate.wrong_value(argument, f"must have one dimension and at least one value, got shape {array.shape}")
    if _kind(problem, name) is int:
        return validate.integer_array(argument, given, 0, 2**62)
    return array


def _whole(problem: SimulationProblem, name: str, values: NDArray[np.float64]) -> NDArray[Any]:
    """Return values that were drawn, as integers where the name asks for them."""
    if _kind(problem, name) is not int:
        return values
    if not (values == np.floor(values)).all():
        raise ValueError(
            f"over[{name!r}] must be the distribution of an integer such as scipy.stats.randint(1, 100), got "
            f"{validate.short(values[0].item())} from it"
        )
    return values.astype(np.int64)


def _kind(problem: SimulationProblem, name: str) -> type:
    """Return float or int: what the values of a name are."""
    kinds = {part.name: _NUMBERS[str(part.type)] for part in fields(problem) if part.type in _NUMBERS}
    return int if name == "seed" else kinds.get(name, float)


def _samples(samples: Any, drawn: Mapping[str, Any], columns: Mapping[str, NDArray[Any]]) -> int:
    """Return how many values are drawn, 0 for none; in a list, as many as ``columns`` have unless told."""
    if not drawn:
        if samples is not None:
            raise validate.wrong_value(
                "samples", f"is for distributions, of which over has none, got {validate.short(samples)}"
            )
        return 0
    if samples is None and columns:
        return next(iter(columns.values())).size
    if samples is None:
        raise validate.wrong_value(
            "samples", f"must say how often {', '.join(drawn)} is to be drawn; give samples=100, say"
        )
    return validate.integer("samples", samples, 1, MOST_RUNS)


def _draw(drawn: Mapping[str, Any], count: int, seed: int) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Yield the names of the distributed quantities with the values drawn for them."""
    for name, given in drawn.items():  # parameters of several distributions would fit some number of levels
        for tried in (2, 3):
            quantiles(f"over[{name!r}]", given, np.linspace(0.25, 0.75, tried))
    levels = np.random.default_rng(seed).random((len(drawn), count))
    for (name, given), level in zip(drawn.items(), levels, strict=True):
        # 0 could be an infinite quantile
        yield name, quantiles(f"over[{name!r}]", given, np.maximum(level, 2.0**-54))
