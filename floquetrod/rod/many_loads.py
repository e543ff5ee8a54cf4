"""Arrays of loads on a rod: statuses, growth rates and critical kicks, in the shape of the loads."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import shaped
from floquetrod._util.progress import Progress
from floquetrod.mathieu.criterion import FiniteTimeCriterion
from floquetrod.rod.friction.mode_friction import friction_and_kick
from floquetrod.rod.loads.load import Loads
from floquetrod.rod.model.parts import friction_coefficient
from floquetrod.rod.modes.mode_model import ModeModel

if TYPE_CHECKING:
    from floquetrod.rod.friction.kicks import CriticalKick


def verdicts(
    model: ModeModel,
    numbers: tuple[Any, Any, Any],
    growth_tolerance: float,
    criterion: FiniteTimeCriterion | None,
    friction: float | None,
    kick: float | None,
    workers: int | None,
    progress: Progress | None,
) -> Any:
    """Return the status under each load; see `floquetrod.Rod.verdicts`."""
    tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
    frictional = friction_and_kick(friction, kick)
    validate.progress(progress)
    if criterion is not None:
        validate.instance("criterion", criterion, FiniteTimeCriterion)
        criterion.require_alone(growth_tolerance=tolerance, friction=0.0 if frictional is None else frictional[0])
    loads = Loads.of(*numbers)
    if frictional is not None:
        parts = loads.in_parts(progress)
        found = np.concatenate([model.kicked(part, *frictional, tolerance, workers) for part in parts])
    elif criterion is not None:
        found = np.concatenate([model.passing(part, criterion, workers) for part in loads.in_parts(progress)])
    else:
        found = model.status(loads, tolerance, workers, progress)
    return shaped(found, loads.shape)


def fastest(
    model: ModeModel, numbers: tuple[Any, Any, Any], workers: int | None, progress: Progress | None
) -> tuple[Any, Any]:
    """Return growth and number of the fastest mode under each load; see `floquetrod.Rod.fastest`."""
    validate.progress(progress)
    loads = Loads.of(*numbers)
    growth, mode = model.fastest(loads, workers, progress)
    return shaped(growth, loads.shape), shaped(mode, loads.shape)


def critical_kicks(
    model: ModeModel, numbers: tuple[Any, Any, Any], friction: float, growth_tolerance: float, workers: int | None
) -> CriticalKick:
    """Return the smallest kick that buckles the rod under each load; see `floquetrod.Rod.critical_kicks`."""
    coefficient = friction_coefficient(friction)
    tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
    loads = Loads.of(*numbers)
    found = model.critical_kicks(loads, coefficient, tolerance, workers)
    return found._replace(**{name: shaped(part, loads.shape) for name, part in found._asdict().items()})
