"""Questions about one quantity of a load: its stability intervals, and its critical value from zero up."""

from __future__ import annotations

import math
from collections.abc import Mapping

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.progress import Progress
from floquetrod.rod.answers.critical_value import CriticalValue
from floquetrod.rod.answers.stability_intervals import Search, StabilityIntervals
from floquetrod.rod.loads.load import LOAD, Load, Loads, Quantity, load_bounds
from floquetrod.rod.model.assumptions import warn_unless_uniform
from floquetrod.rod.model.contact import constants_under, up_to_wall
from floquetrod.rod.modes.mode_model import ModeModel

_SEARCHED: dict[Quantity, float] = {"mean": 1.5, "amplitude": 1.0}
"""Up to how many critical forces is searched by default."""


def stable_intervals(
    model: ModeModel,
    varied: Quantity,
    others: Mapping[Quantity, float],
    bounds: tuple[float, float] | None,
    growth_tolerance: float,
    progress: Progress | None,
) -> StabilityIntervals:
    """Return the stability intervals of one quantity; see `floquetrod.Rod.ranges`."""
    fixed = units.GivenUnits.of(force=[others.get("mean"), others.get("amplitude")], frequency=others.get("frequency"))
    given = fixed.or_else(_given(model))
    if bounds is not None:  # which give the unit of what varies, of its kind alone
        kept = {kind: getattr(given, kind) for kind in ("force", "frequency") if kind != LOAD[varied].kind}
        given = units.GivenUnits.of(**{LOAD[varied].kind: bounds})._replace(**kept)
    if bounds is None and varied != "frequency":
        bounds = 0.0, _largest(model, varied, others)
    low, high = load_bounds(varied, bounds)
    largest = _load(model, {**others, varied: high})
    if varied == "frequency":
        constants_under(model.rod, largest.mean).require_in_reach(Loads.single(largest.varied(varied, low)))
    validate.progress(progress)
    search = Search(varied, largest, (low, high), units.tolerance("growth_tolerance", growth_tolerance))
    warn_unless_uniform(model.rod, largest)
    return model.ranges(search, progress).given_in(given)


def critical_load(
    model: ModeModel,
    varied: Quantity,
    others: Mapping[Quantity, float],
    growth_tolerance: float,
    progress: Progress | None = None,
) -> CriticalValue:
    """Return where one quantity, going up from zero, first meets growth; infinite without any."""
    largest = _load(model, {**others, varied: _largest(model, varied, others)})
    validate.progress(progress)
    tolerance = units.tolerance("growth_tolerance", growth_tolerance)
    warn_unless_uniform(model.rod, largest)
    search = Search(varied, largest, (0.0, getattr(largest, varied)), tolerance)
    change = model.first_unstable(search, _saying_how_far(progress, varied, largest))
    critical = CriticalValue(math.inf if change.at is None else change.at, varied, change.resolution, change.searched)
    return critical.given_in(_given(model))


def _given(model: ModeModel) -> units.GivenUnits:
    """Return the units in which the load and the rod were given."""
    return model.template.given_units.or_else(model.rod.given_units)


def _largest(model: ModeModel, varied: Quantity, others: Mapping[Quantity, float]) -> float:
    """Return up to which force in N is searched by default; where the channel bends at most until its wall is left."""
    most = _SEARCHED[varied] * model.rod.critical_force
    return up_to_wall(model.rod, _load(model, {**others, varied: most}), varied, (0.0, most), only_low=True)[1]


def _load(model: ModeModel, numbers: Mapping[Quantity, float]) -> Load:
    """Return a load of the kind of the model."""
    return model.template.with_numbers(numbers["mean"], numbers["amplitude"], numbers["frequency"])


def _saying_how_far(progress: Progress | None, varied: Quantity, largest: Load) -> Progress | None:
    """Return the progress of a search up from zero, which notes on an error of the caller up to where nothing grows."""
    if progress is None:
        return None

    def report(done: int, total: int) -> None:
        try:
            progress(done, total)
        except BaseException as error:
            at = done / total * getattr(largest, varied)
            error.add_note(f"up to {LOAD[varied].words} {at:.6g} {LOAD[varied].unit} nothing grows")
            raise

    return report
