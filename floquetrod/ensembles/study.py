"""Study files: TOML tables of a simulated problem and of the quantities varied, with units."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import Message, argument_of, error_in
from floquetrod._util.calling import level_of_caller
from floquetrod._util.plausibility_warning import SILENCE, PlausibilityWarning
from floquetrod._util.tables import read_toml, require_keys
from floquetrod.ensembles.ensemble import ensemble
from floquetrod.ensembles.tasks import Summary
from floquetrod.ensembles.varied_axes import LAYOUTS, MOST_RUNS, RUN_KINDS, VARIED_KINDS, names_of
from floquetrod.parameter import unknown
from floquetrod.rod.loads.load import FAR_ENDS, LOAD, QUANTITIES
from floquetrod.rod.model.plausibility import suspicion_of_hertz, warn_of_record
from floquetrod.rod.model.rod_file import rod_of
from floquetrod.rod.reading import (
    LOAD_OPTIONS,
    is_pipe,
    named_rod,
    read_friction,
    read_kind,
    read_load,
    read_record,
    read_tool,
)
from floquetrod.rod.rod import Rod
from floquetrod.simulation.simulation_problem import SimulationProblem
from floquetrod.simulation.start_text import read_perturbation
from floquetrod.units import Unit

_TABLES = ("rod", "load", "run", "start", "over", "ensemble")
_IGNORED = {parameter.name for parameter in unknown(LOAD, "simulation")}
_LOAD = (*QUANTITIES, *(name for name in LOAD_OPTIONS if name not in _IGNORED))
_COUNTS = ("segments", "frames")
_START = ("kick", "random", "seed", "case")
_RUN = (*RUN_KINDS, *_COUNTS, "stop_early", "natural_curvature", "tool")
_OPTIONS: dict[str, Callable[[str, Any], Any]] = {
    "layout": partial(validate.choice, allowed=LAYOUTS),
    "samples": partial(validate.integer, least=1),
    "seed": partial(validate.integer, least=0),
    "frames": validate.flag,
}
"""Options of `floquetrod.ensemble`, each with what checks it."""

_INTEGERS = (*_COUNTS, "seed")
_ARGUMENTS = {
    **dict.fromkeys(_RUN, "run"),
    "rod": "rod",
    "load": "load",
    "perturbation": "start",
}
"""Arguments of `floquetrod.SimulationProblem`, and the tables that give them."""

_SPACINGS = ("linear", "log")
_DISTRIBUTIONS = {"uniform": ("low", "high"), "loguniform": ("low", "high"), "normal": ("mean", "deviation")}
_BOUNDS = ("low", "high")  # that a normal distribution may have


@dataclass(frozen=True, eq=False)
class Study:
    """A problem, the quantities varied, and options: the content of a study file.

    Attributes
    ----------
    problem : SimulationProblem
        Gives everything that ``over`` does not.
    over : mapping
        The quantities varied, by name: values in SI units, or a distribution.
    options : mapping
        Of `floquetrod.ensemble`: ``layout``, ``samples``, ``seed``, ``frames``.
    units : mapping of str to Unit
        The unit in which the file gives each quantity that is varied.
    path : path
        The file.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import floquetrod as fr
    >>> text = '''
    ... rod = "nitinol"
    ... load = {mean = "0.3Fcr", amplitude = "0.3Fcr", frequency = "24Hz"}
    ... run = {duration = "10ms", segments = 60, frames = 5}
    ... over = {kick = ["10mm/s", "20mm/s"], seed = {from = 1, to = 3}}
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "study.toml"
    ...     _ = path.write_text(text)
    ...     study = fr.Study.from_toml(path)
    >>> study.over, study.units["kick"].name
    ({'kick': [0.01, 0.02], 'seed': range(1, 4)}, 'mm/s')
    """

    problem: SimulationProblem
    over: Mapping[str, Any]
    options: Mapping[str, Any]
    units: Mapping[str, Unit]
    path: Path

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """Read a study file.

        Its tables are [rod], which may also be nitinol or the name of a rod file, [load], [run], [start], [over] and
        [ensemble]; ``floquetrod ensemble --help-all`` shows one.  Files that it names lie beside it.

        Returns
        -------
        Study
            Checked: each of its runs can begin.

        Raises
        ------
        TypeError, ValueError
            For a file that cannot be read, and for quantities that cannot be simulated or varied; the message names
            file, table and key.

        Warns
        -----
        PlausibilityWarning
            For numbers probably in another unit, such as a frequency without one, meant in Hz.
        """
        path = validate.path("path", path)
        tables = read_toml(path, "study file")
        with _naming(path):
            _require_tables(tables)
        with _naming(path, "rod"):
            rod = _rod(path, tables["rod"])
        with _naming(path, "load"):
            load = _load(path, tables["load"], rod)
        with _naming(path, "run"):
            settings = _settings(tables.get("run", {}), rod)
        with _naming(path, "start"):
            start = _start(tables.get("start", {}))
        with _naming(path):  # which names the argument that cannot be
            problem = SimulationProblem(rod, load, **(settings | start))
        with _naming(path, "over"):
            varied = _over(tables["over"], problem)
        with _naming(path, "ensemble"):
            options = _options(tables.get("ensemble", {}))
        values, written = ({name: each[i] for name, each in varied.items()} for i in (0, 1))
        _warn_of_hertz(path, tables, problem, values)
        return cls(problem, values, options, written, path)

    def run(
        self,
        *,
        layout: Literal["grid", "list"] | None = None,
        samples: int | None = None,
        seed: int | None = None,
        executor: Executor | None = None,
        workers: int | None = None,
        store: str | Path | None = None,
        summary: Summary | None = None,
        frames: bool | None = None,
        part: tuple[int, int] | None = None,
        retry_failed: bool = True,
        progress: Callable[[int, int], None] | None = None,
    ) -> Any:
        """Return the result of `floquetrod.ensemble` for this study, with the options of `ensemble`.

        Where ``layout``, ``samples``, ``seed`` and ``frames`` are None the file's are used.  Other arguments as
        in `ensemble`.

        Returns
        -------
        xarray.Dataset, or Runs where xarray is not installed
            As `ensemble` returns.

        Raises
        ------
        TypeError, ValueError
            As `ensemble`; ValueError names file and table where the file is the cause.
        """
        options = {"layout": layout, "samples": samples, "seed": seed, "frames": frames}
        given = {name: value for name, value in options.items() if value is not None}
        try:
            return ensemble(
                self.problem,
                self.over,
                **{**self.options, **given},
                executor=executor,
                workers=workers,
                store=store,
                summary=summary,
                part=part,
                retry_failed=retry_failed,
                progress=progress,
            )
        except (TypeError, ValueError) as error:
            raise self._naming_table(error, given) from None

    def _naming_table(self, error: TypeError | ValueError, given: Mapping[str, Any]) -> TypeError | ValueError:
        """Return an error that names file and table where it is about what the file says."""
        about = argument_of(error)
        if about is not None and about.name == "over":
            what = " ".join(filter(None, [about.place, about.problem]))
            return ValueError(f"study file {self.path}: [over] {what}")
        if about is not None and about.name in _OPTIONS and about.name not in given:
            return error_in(f"study file {self.path}: [ensemble]", error, " ")
        return error


def _require_tables(tables: Mapping[str, Any]) -> None:
    """Raise ValueError for unknown and missing tables, and for values in the place of a table."""
    require_keys(tables, _TABLES)
    for name in ("rod", "load", "over"):
        if name not in tables:
            raise ValueError(f"missing table [{name}]; the tables are {', '.join(f'[{t}]' for t in _TABLES)}")
    for name, table in tables.items():
        if not isinstance(table, dict) and name != "rod":
            raise ValueError(f"{name} must be a table, [{name}] with lines below it, got {validate.short(table)}")


@contextmanager
def _naming(path: Path, table: str = "") -> Iterator[None]:
    """Name file and table in errors: the table given, else the table of the argument at fault."""
    try:
        yield
    except (TypeError, ValueError, OSError, ArithmeticError) as error:
        about = argument_of(error)
        table = table or ("" if about is None else _ARGUMENTS.get(about.name, ""))
        raise ValueError(f"study file {path}: {f'[{table}] ' if table else ''}{error}") from None


def _rod(path: Path, given: Any) -> Rod:
    """Return the rod: a table as in rod files, or nitinol or the name of a rod file."""
    if isinstance(given, dict):
        return rod_of(given, Rod, path.parent)
    if not isinstance(given, str):
        raise ValueError(f"must be a table as in rod files, nitinol or a rod file, got {validate.short(given)}")
    if is_pipe(given):
        raise ValueError(f"{given!r} needs a table [rod] with catalogue = {given!r}, bore and length")
    return named_rod("rod", given, path.parent)


def _load(path: Path, table: Mapping[str, Any], rod: Rod) -> Any:
    """Return the load; a measured force is searched for beside the study file."""
    require_keys(table, _LOAD)
    given = {key: _scalar(key, table.get(key)) for key in _LOAD}
    if given["force"] is None and (missing := [key for key in QUANTITIES if given[key] is None]):
        raise ValueError(f"missing key{'s' if missing[1:] else ''} {', '.join(missing)}; or give a measured force")
    if given["wave"] is not None:
        validate.choice("wave", given["wave"], FAR_ENDS)
    texts = {key: None if given[key] is None else str(given[key]) for key in _LOAD if key not in (*QUANTITIES, "force")}
    force = None if given["force"] is None else str(path.parent / str(given["force"]))
    words: dict[str, Any] = given | texts | {"force": force}
    record = read_record(words)
    like = read_kind(words, record)
    load = read_load(words, rod, like)
    if record is not None:
        warn_of_record(rod, record, load)
    return load


def _warn_of_hertz(path: Path, tables: Mapping[str, Any], problem: SimulationProblem, over: Mapping[str, Any]) -> None:
    """Warn of the first frequency without a unit whose reading in Hz would change a verdict.

    Verdicts are on the study's own rod, at both ends of the ranges of its load.
    """
    rod, load = problem.rod, problem.load
    given = tables["over"].get("frequency", tables["load"].get("frequency"))
    if isinstance(given, dict):
        given = [number for key, number in given.items() if key not in (*_WORDS, "deviation")]
    typed = [str(number) for number in (given if isinstance(given, list) else [given])]
    forces = [_ends(over.get(name), getattr(load, name)) for name in ("mean", "amplitude")]
    for text in [text for text in typed if units.unit_of(text) == ""][:_READ_IN_HERTZ]:
        with suppress(ValueError):  # an impossible load is refused where the runs are made
            loads = [load.with_numbers(mean, amplitude, float(text)) for mean, amplitude in product(*forces)]
            suspicion = suspicion_of_hertz(f"study file {path}: frequency", text, rod, loads)
            if suspicion:
                warnings.warn(Message(suspicion, SILENCE), PlausibilityWarning, stacklevel=level_of_caller())
                return


def _ends(varied: Any, own: float) -> list[float]:
    """Return the smallest and the largest value of a quantity, its own value where it has no list of values."""
    return [float(np.min(varied)), float(np.max(varied))] if isinstance(varied, list | np.ndarray) else [own]


def _settings(table: Mapping[str, Any], rod: Rod) -> dict[str, Any]:
    """Return the options of the problem in the table [run]."""
    require_keys(table, _RUN)
    settings: dict[str, Any] = {}
    for key, value in table.items():
        if key == "natural_curvature" or (key == "friction" and isinstance(value, list)):
            settings[key] = value  # the problem checks it
        elif key == "friction" and isinstance(value, str):
            settings[key] = read_friction(value, key)
        elif key == "tool":
            settings[key] = read_tool(str(_scalar(key, value)), key)
        elif key in RUN_KINDS:
            settings[key] = _quantity(key, value, rod)
        elif key in _COUNTS:
            settings[key] = validate.integer(key, value, 2)
        else:
            settings[key] = validate.flag(key, value)
    return settings


def _start(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return the option of the problem that says how the rod is set moving, none for its default."""
    require_keys(table, _START)
    if not table:
        return {}
    kicks = table.get("kick", {})
    if not isinstance(kicks, dict):
        raise ValueError(f'kick must map modes to speeds such as {{8 = "50mm/s"}}, got {validate.short(kicks)}')
    given: dict[str, Any] = {
        "kick": [f"{mode}:{_scalar('kick', speed)}" for mode, speed in kicks.items()],
        **{key: None if key not in table else str(_scalar(key, table[key])) for key in ("random", "case")},
        "seed": None if "seed" not in table else validate.integer("seed", table["seed"], 0),
    }
    return {"perturbation": read_perturbation(given)}


def _options(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return the table [ensemble]: how values are combined, and how they are drawn."""
    require_keys(table, _OPTIONS)
    return {name: _OPTIONS[name](name, value) for name, value in table.items()}


def _over(table: Mapping[str, Any], problem: SimulationProblem) -> dict[str, tuple[Any, Unit]]:
    """Return the table [over]: of each key the values or the distribution, and the unit it is written in."""
    if not table:
        raise ValueError('needs at least one key such as frequency = ["19Hz", "24Hz"], got none')
    require_keys(table, [name for names in names_of(problem).values() for name in names])
    return {key: _varied(key, value, problem.rod) for key, value in table.items()}


def _varied(key: str, given: Any, rod: Rod) -> tuple[Any, Unit]:
    """Return the values or the distribution of a quantity, in SI units, and its unit in the file."""
    if not isinstance(given, list | dict):
        raise ValueError(
            f"{key} must be a list, a range such as {{from = 1, to = 9, steps = 5}} or a distribution such as "
            f'{{distribution = "uniform", low = 1, high = 9}}, got {validate.short(given)}; a single value belongs in '
            "the table of what it is a part of"
        )
    if key in _INTEGERS:
        return _integers(key, given), Unit("", 1.0)
    numbers = given if isinstance(given, list) else [v for k, v in given.items() if k not in _WORDS]
    written = (units.unit_of(value) or "" for value in numbers if isinstance(value, str))
    unit = units.unit(next(written, ""), key, VARIED_KINDS[key], rod.force_unit)
    if isinstance(given, list):
        return [_quantity(key, value, rod) for value in given], unit
    if "distribution" in given:
        return _distribution(key, given, rod), unit
    require_keys(given, ("from", "to", "steps", "spacing"))
    _require_all(key, given, ("from", "to", "steps"))
    first, last = (_quantity(f"{key}: {end}", given[end], rod, key) for end in ("from", "to"))
    steps = validate.integer(f"{key}: steps", given["steps"], 2, MOST_RUNS)
    spacing = validate.choice(f"{key}: spacing", given.get("spacing", "linear"), _SPACINGS)
    if spacing == "log" and not min(first, last) > 0.0:
        raise ValueError(f'{key}: spacing "log" needs ends above zero, got {given["from"]!r} and {given["to"]!r}')
    return (np.linspace if spacing == "linear" else np.geomspace)(first, last, steps), unit


_READ_IN_HERTZ = 100  # frequencies of a list that are; nobody types longer ones
_WORDS = ("steps", "spacing", "distribution")


def _integers(key: str, given: Any) -> Any:
    """Return integers: a list of them, or every one of a range."""
    if isinstance(given, list):
        return [validate.integer(key, value, 0) for value in given]
    require_keys(given, ("from", "to"))
    _require_all(key, given, ("from", "to"))
    first = validate.integer(f"{key}: from", given["from"], 0)
    return range(first, validate.integer(f"{key}: to", given["to"], first, first + MOST_RUNS) + 1)


def _distribution(key: str, given: Mapping[str, Any], rod: Rod) -> Any:
    """Return a distribution of SciPy's."""
    kind = validate.choice(f"{key}: distribution", given["distribution"], _DISTRIBUTIONS)
    needed = _DISTRIBUTIONS[kind]
    require_keys(given, ("distribution", *needed, *(_BOUNDS if kind == "normal" else ())))
    _require_all(key, given, needed)
    numbers = {
        name: _quantity(f"{key}: {name}", v, rod, key)
        for name, v in given.items()
        if name not in ("distribution", "deviation")
    }
    if "deviation" in given:  # in percent, of the mean
        mean = numbers["mean"]
        numbers["deviation"] = _quantity(f"{key}: deviation", given["deviation"], rod, key, abs(mean))
    low, high = numbers.get("low", -np.inf), numbers.get("high", np.inf)
    if not low < high:
        raise ValueError(f"{key}: low must lie below high, got {given['low']!r} and {given['high']!r}")
    from scipy import stats

    if kind == "uniform":
        return stats.uniform(low, high - low)
    if kind == "loguniform":
        if not low > 0.0:
            raise ValueError(f"{key}: low must be greater than zero in a loguniform distribution, got {given['low']!r}")
        return stats.loguniform(low, high)
    mean, deviation = numbers["mean"], validate.positive(f"{key}: deviation", numbers["deviation"])
    return stats.truncnorm((low - mean) / deviation, (high - mean) / deviation, mean, deviation)


def _require_all(key: str, given: Mapping[str, Any], needed: tuple[str, ...]) -> None:
    """Raise ValueError where one of the keys needed is missing."""
    missing = [name for name in needed if name not in given]
    if missing:
        raise ValueError(f"{key} needs {', '.join(needed)}, got {validate.short(dict(given))}")


def _quantity(name: str, value: Any, rod: Rod, key: str | None = None, nominal: float | None = None) -> float:
    """Return a quantity in SI units, of the kind of ``key`` where the name is another.

    A percentage is one of ``nominal``, else of the rod's own value, the critical force or one.
    """
    key = key or name
    own = rod.parameters.get(key) if nominal is None else nominal
    return units.quantity(value, name, VARIED_KINDS[key], critical_force=rod.force_unit, nominal=own)


def _scalar(key: str, value: Any) -> str | int | float | None:
    """Return a number or a text, which may be missing."""
    if value is None or (isinstance(value, str | int | float) and not isinstance(value, bool)):
        return value
    raise ValueError(f"{key} must be a number or a text with a unit, got {validate.short(value)}")
