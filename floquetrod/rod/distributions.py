"""Distributed numbers of a rod, a load and a survey: their quantiles, and the verdicts on samples of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.caching import cached_property
from floquetrod.rod.loads.load import LOAD, QUANTITIES, Load, Loads
from floquetrod.rod.model.constants import mode_constants
from floquetrod.rod.model.parameters import GIVEN
from floquetrod.rod.model.possible_rod import are_possible, require_known_to_verdicts
from floquetrod.rod.modes.mode_model import ModeModel
from floquetrod.rod.rod import Rod
from floquetrod.wells.path import WellPath

SURVEY = {
    f"{column}_{kind}": (column, kind) for column in ("inclination", "azimuth") for kind in ("systematic", "random")
}
"""Errors of a survey by name: of which column, and whether all stations have the same or each its own."""

_ONE_BY_ONE = 1 << 6  # samples between two reports of progress, about a second (a choice)
_EXAMPLE = "a pair (low, high) or a frozen distribution such as scipy.stats.norm(3.1, 0.02)"


@dataclass(frozen=True)
class Sampling:
    """A rod and a load, some of whose numbers are distributed; ``parameters`` holds these by name."""

    rod: Rod
    load: Load
    parameters: Mapping[str, Any]
    growth_tolerance: float
    workers: int | None

    @cached_property
    def model(self) -> ModeModel:
        """The modes of one of the rods, which has weight along it if any of them has."""
        rod = self.rod.replace(inclination=0.5) if "inclination" in self.parameters else self.rod
        return rod._modes_under(self.load)

    @property
    def at_once(self) -> int:
        """How many samples are decided at a time."""
        return _ONE_BY_ONE if self.is_one_by_one else self.model.samples_at_once

    @cached_property
    def is_one_by_one(self) -> bool:
        """Whether each sample is a rod with modes of its own, which takes milliseconds."""
        of_rods = [name for name in self.parameters if name not in QUANTITIES]
        return any(name in SURVEY for name in of_rods) or bool(of_rods and self.model.coupling)

    @cached_property
    def rows(self) -> dict[str, slice]:
        """Which levels of probability each quantity takes, one, or one of each station."""
        return rows(self.parameters, self.rod.path)

    def verdicts(self, levels: Floats) -> NDArray[np.int8]:
        """Return 1, 0 or -1, stable, unstable or undecided, at levels of probability (rows, samples)."""
        values = drawn(self.parameters, self.rows, levels)
        if self.is_one_by_one:
            return np.array([self._verdict(sample) for sample in samples_of(values)], dtype=np.int8)
        loads = [np.broadcast_to(values.get(name, getattr(self.load, name)), levels.shape[1:]) for name in QUANTITIES]
        rods: dict[str, Any] = {name: values.get(name, known) for name, known in self.rod.parameters.items()}
        self._require(self._exist(rods, loads), values)
        return self.model.sample_status(
            rods, Loads.of(*loads), self.growth_tolerance, self.workers, lambda good: self._require(good, values)
        )

    def _verdict(self, sample: Mapping[str, Any]) -> np.int8:
        """Return 1, 0 or -1 of one sample; where it leaves its wall it is undecided."""
        try:
            load = self._load_of(sample)
            model = sampled_rod(self.rod, sample)._modes_under(load)
            loads = Loads((1,), *Loads.single(load).flat)
            return np.int8(model.status(loads, self.growth_tolerance, self.workers)[0])
        except ValueError as error:
            raise no_sample(sample, error) from None

    def _load_of(self, sample: Mapping[str, Any]) -> Load:
        """Return the load of one sample."""
        return replace(self.load, **{name: sample[name] for name in QUANTITIES if name in sample})

    def _exist(self, rods: Mapping[str, Any], loads: list[Floats]) -> Bools:
        """Return which samples are a rod under a load."""
        good = np.ones(loads[0].shape, dtype=np.bool_)
        for quantity, values in zip(QUANTITIES, loads, strict=True):
            good &= (LOAD[quantity].least <= values) & (values <= LOAD[quantity].largest)
        return good & are_possible(rods)

    def _require(self, good: Bools, values: Mapping[str, Floats]) -> None:
        """Raise ValueError unless all samples are good: what a rod or load made of the first that is not raises."""
        if good.all():
            return
        sample = {name: float(several[np.argmin(good)]) for name, several in values.items()}
        try:
            self._refuse(sample)
        except ValueError as error:
            many = f"{np.count_nonzero(~good):,} of {good.size:,} samples do not, such as"
            raise no_sample(sample, error, many, is_rare=bool(good.any())) from None

    def _refuse(self, sample: Mapping[str, float]) -> NoReturn:
        """Raise ValueError for a sample that is not a possible rod and load."""
        rod = self.rod.replace(**{name: value for name, value in sample.items() if name not in QUANTITIES})
        load = self._load_of(sample)
        require_known_to_verdicts(rod)
        mode_constants(rod).require_in_reach(Loads.single(load))
        raise ValueError("it is out of range")


def rows(parameters: Iterable[str], path: WellPath | None) -> dict[str, slice]:
    """Return which levels of probability each quantity takes: random errors of a survey one of each station."""
    slices, done = {}, 0
    for name in parameters:
        many = path.depth.size if path is not None and SURVEY.get(name, ("", ""))[1] == "random" else 1
        slices[name] = slice(done, done + many)
        done += many
    return slices


def drawn(parameters: Mapping[str, Any], rows: Mapping[str, slice], levels: Floats) -> dict[str, Floats]:
    """Return the quantities (samples,), or (stations, samples), at levels of probability (rows, samples)."""
    samples = {}
    for name, row in rows.items():
        level = levels[row][0] if row.stop - row.start == 1 else levels[row]
        samples[name] = quantiles(f"parameters[{name!r}]", parameters[name], level)
    return samples


def samples_of(values: Mapping[str, Floats]) -> Iterable[dict[str, Any]]:
    """Yield each sample of quantities (samples,) or (stations, samples): a number, or one of each station."""
    for i in range(next(iter(values.values())).shape[-1]):
        yield {name: several[..., i] if several.ndim > 1 else float(several[i]) for name, several in values.items()}


def sampled_rod(rod: Rod, sample: Mapping[str, Any]) -> Rod:
    """Return the rod of a sample, on the path of its survey."""
    changes = {name: value for name, value in sample.items() if name not in QUANTITIES and name not in SURVEY}
    if rod.path is not None and any(name in SURVEY for name in sample):
        changes["path"] = sampled_path(rod.path, sample)
    return rod.replace(**changes) if changes else rod


def sampled_path(path: WellPath, sample: Mapping[str, Any]) -> WellPath:
    """Return the path of a sample: the survey corrected by the errors drawn in ``sample``."""
    errors: dict[str, Any] = {}
    for name, (column, _) in SURVEY.items():
        if name in sample:
            errors[column] = errors.get(column, 0.0) + sample[name]
    return path.with_errors(**errors) if errors else path


def no_sample(
    sample: Mapping[str, Any],
    error: ValueError,
    many: str = "there is",
    what: str = "rods and loads",
    *,
    is_rare: bool = True,
) -> ValueError:
    """Return the error to raise for a sample that describes no possible rod, load or ``what``."""
    listed = ", ".join(f"{name} = {value:.6g}" for name, value in sample.items() if np.ndim(value) == 0)
    remedy = ".  Truncate the distribution, with scipy.stats.truncnorm for example" if is_rare else ""
    return validate.wrong_value("parameters", f"must describe possible {what}, but {many} {listed}: {error}{remedy}")


def quantiles(argument: str, given: Any, levels: Floats) -> Floats:
    """Return the quantiles of what an argument is distributed by, at levels between 0 and 1."""
    if isinstance(given, tuple):
        low, high = given
        return np.asarray(low + (high - low) * levels)
    try:
        values: NDArray[Any] = np.asarray(quantile_function(given)(levels))
    except ValueError:  # parameters of several distributions, which do not broadcast
        values = np.empty(0)
    if values.shape != levels.shape or values.dtype.kind not in "iuf":
        problem = f"must be the distribution of one number, {_EXAMPLE}; got several"
        raise validate.wrong_type(argument, problem)
    return values.astype(np.float64, copy=False)


def quantile_function(given: Any) -> Any:
    """Return the quantile function of a distribution of either kind of SciPy's, None of anything else."""
    function = getattr(given, "ppf", None) or getattr(given, "icdf", None)
    loose = isinstance(given, type) or hasattr(given, "freeze")  # a family of distributions
    return function if callable(function) and not loose else None


def distributions(parameters: Any, allowed: Iterable[str], path: WellPath | None) -> dict[str, Any]:
    """Return the argument ``parameters``, checked, its pairs as tuples of floats."""
    if not isinstance(parameters, Mapping):
        raise validate.wrong_type("parameters", f"must map names to distributions, got {validate.short(parameters)}")
    checked: dict[str, Any] = {}
    for name, given in parameters.items():
        if name not in allowed:
            raise validate.wrong_value("parameters", f"must be among {', '.join(allowed)}, got {validate.short(name)}")
        if name in SURVEY and path is None:
            raise validate.wrong_value(
                "parameters", f"names {name}, an error of a survey, and the rod is on no path; give it one"
            )
        checked[name] = distribution(f"parameters[{name!r}]", given, partial(_number, name))
    return checked


def distribution(argument: str, given: Any, element: Callable[[str, Any], float]) -> Any:
    """Return what an argument is distributed by, checked, a pair as floats that pass ``element``."""
    if isinstance(given, tuple | list):
        return validate.interval(argument, given, element)
    if quantile_function(given) is None:
        raise validate.wrong_type(argument, f"must be {_EXAMPLE}, got {validate.short(given)}")
    quantiles(argument, given, np.array([0.25, 0.5, 0.75]))
    return given


def _number(name: str, argument: str, value: Any) -> float:
    """Return a number in SI that is given as one or with its unit."""
    kind = LOAD[name].kind if name in QUANTITIES else "angle" if name in SURVEY else GIVEN[name].kind
    return units.number(argument, value, kind)
