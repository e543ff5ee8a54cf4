"""Numbers of a rod and a load that are distributed: their quantiles, and the verdicts on samples of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.caching import cached_property
from floquetrod.rod.loads.load import LIMITS, Load, Loads
from floquetrod.rod.model import formulas, parts
from floquetrod.rod.model.constants import mode_constants
from floquetrod.rod.modes.mode_model import ModeModel
from floquetrod.rod.rod import Rod

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
        return rod.modes_under(self.load)

    @property
    def at_once(self) -> int:
        """How many samples are judged at a time."""
        return self.model.samples_at_once

    def verdicts(self, levels: Floats) -> NDArray[np.int8]:
        """Return 1, 0 or -1, stable, unstable or undecided, at levels of probability (quantities, samples)."""
        values = {
            name: quantiles(name, given, level)
            for (name, given), level in zip(self.parameters.items(), levels, strict=True)
        }
        loads = [np.broadcast_to(values.get(name, getattr(self.load, name)), levels.shape[1:]) for name in LIMITS]
        rods: dict[str, Any] = {name: values.get(name, known) for name, known in self.rod.parameters.items()}
        self._require(self._exist(rods, loads), values)
        return self.model.sample_status(
            rods,
            Loads.of(*loads),
            self.growth_tolerance,
            self.workers,
            lambda good: self._require(good, values),
        )

    def _exist(self, rods: Mapping[str, Any], loads: list[Floats]) -> NDArray[np.bool_]:
        """Return which samples are a rod under a load."""
        good = np.ones(loads[0].shape, dtype=np.bool_)
        for values, limits in zip(loads, LIMITS.values(), strict=True):
            good &= (limits.least <= values) & (values <= limits.largest)
        for name, values in rods.items():
            least, largest = parts.LIMITS[name]
            good &= (least <= values) & (values <= largest)
        if good.all():
            radii = rods["radius"], rods["inner_radius"]
            area, bore, outer = formulas.ring(*radii), formulas.disc(radii[1]), formulas.disc(radii[0])
            own = formulas.own_mass(rods["density"], rods["fluid_inside"], area, bore)
            weighing = formulas.weighing_mass(own, rods["fluid_outside"], outer)
            good &= formulas.has_wall(*radii)
            good &= formulas.fits(rods["radius"], rods["channel_radius"])
            good &= formulas.sinks(own, weighing)
        return good

    def _require(self, good: NDArray[np.bool_], values: Mapping[str, Floats]) -> None:
        """Raise ValueError unless all samples are good: what a rod or load made of the first that is not raises."""
        if good.all():
            return
        sample = {name: float(several[np.argmin(good)]) for name, several in values.items()}
        try:
            self._refuse(sample)
        except ValueError as error:
            listed = ", ".join(f"{name} = {value:.6g}" for name, value in sample.items())
            remedy = ".  Truncate the distribution, with scipy.stats.truncnorm for example" if good.any() else ""
            raise validate.wrong_value(
                "parameters",
                f"must describe possible rods and loads, but {np.count_nonzero(~good):,} of {good.size:,} "
                f"samples do not, such as {listed}: {error}{remedy}",
            ) from None

    def _refuse(self, sample: Mapping[str, float]) -> NoReturn:
        """Raise ValueError for a sample that is not a possible rod and load."""
        rod = self.rod.replace(**{name: value for name, value in sample.items() if name not in LIMITS})
        load = self.load.with_numbers(*(sample.get(name, getattr(self.load, name)) for name in LIMITS))
        mode_constants(rod).require_in_reach(Loads.single(load))
        raise ValueError("it is out of range")


def quantiles(name: str, given: Any, levels: Floats, argument: str = "parameters") -> Floats:
    """Return the quantiles of what ``argument[name]`` is distributed by, at levels between 0 and 1."""
    if isinstance(given, tuple):
        low, high = given
        return np.asarray(low + (high - low) * levels)
    try:
        found: NDArray[Any] = np.asarray(quantile_function(given)(levels))
    except ValueError:  # parameters of several distributions, which do not broadcast
        found = np.empty(0)
    if found.shape != levels.shape or found.dtype.kind not in "iuf":
        problem = f"must be the distribution of one number, {_EXAMPLE}; got several"
        raise validate.wrong_type(f"{argument}[{name!r}]", problem)
    return found.astype(np.float64, copy=False)


def quantile_function(given: Any) -> Any:
    """Return the quantile function of a distribution of either kind of SciPy's, None of anything else."""
    found = getattr(given, "ppf", None) or getattr(given, "icdf", None)
    loose = isinstance(given, type) or hasattr(given, "freeze")  # a family of distributions
    return found if callable(found) and not loose else None


def distributions(parameters: Any) -> dict[str, Any]:
    """Return the argument ``parameters``, checked, its pairs as tuples of floats."""
    if not isinstance(parameters, Mapping):
        raise validate.wrong_type("parameters", f"must map names to distributions, got {validate.short(parameters)}")
    if not parameters:
        raise validate.wrong_value("parameters", "must name at least one number of the rod or the load, got none")
    allowed = (*LIMITS, *parts.LIMITS)
    checked: dict[str, Any] = {}
    for name, given in parameters.items():
        if name not in allowed:
            raise validate.wrong_value("parameters", f"must be among {', '.join(allowed)}, got {validate.short(name)}")
        argument = f"parameters[{name!r}]"
        if isinstance(given, tuple | list):
            checked[name] = validate.interval(argument, given)
            continue
        if quantile_function(given) is None:
            raise validate.wrong_type(argument, f"must be {_EXAMPLE}, got {validate.short(given)}")
        quantiles(name, given, np.array([0.25, 0.5, 0.75]))
        checked[name] = given
    return checked
