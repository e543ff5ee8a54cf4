"""Verdicts on a rod: under one load, of a measured force within its noise, and over arrays of loads."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arrays import shaped
from floquetrod._util.progress import Progress
from floquetrod.mathieu.paper_criterion import FiniteTimeCriterion
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.friction.mode_friction import friction_and_kick
from floquetrod.rod.loads.load import AnyLoad, Loads, LoadSource, require_load
from floquetrod.rod.model.assumptions import warn_unless_uniform
from floquetrod.rod.model.plausibility import warn_of_hertz, warn_of_load
from floquetrod.rod.modes.mode_model import ModeModel

# Loaded by what needs them: a first verdict takes a quarter of the package.
if TYPE_CHECKING:
    from floquetrod.rod.friction.kicks import FrictionalRodStability


def stability(
    model: ModeModel,
    source: AnyLoad,
    modes: Iterable[int] | None,
    growth_tolerance: float,
    friction: float | None,
    kick: float | None,
    progress: Progress | None,
) -> RodStability | FrictionalRodStability:
    """Return the verdict under a load or a record; see `floquetrod.Rod.stability`."""
    load, rod = require_load("load", source), model.rod
    friction_kick = friction_and_kick(friction, kick)
    tolerance = units.tolerance("growth_tolerance", growth_tolerance)
    validate.progress(progress)
    record = source if isinstance(source, LoadSource) else None
    warn_unless_uniform(rod, load)
    warn_of_load(rod, load, record)
    if friction is not None:
        model.require("friction")
    if record is not None:
        from floquetrod.rod.record_verdict import record_verdict

        return record_verdict(model, record, modes, tolerance, progress)
    linear = model.verdict(load, modes, tolerance, progress)
    if linear.stable and modes is None and model.prompt:
        warn_of_hertz(rod, load, tolerance)
    if friction_kick is None:
        return linear
    from floquetrod.rod.friction.kicks import classify_kick

    return classify_kick(linear, *friction_kick)


def statuses(
    model: ModeModel,
    loads: Loads,
    growth_tolerance: float,
    criterion: FiniteTimeCriterion | None,
    friction: float | None,
    kick: float | None,
    workers: int | None,
    progress: Progress | None,
) -> Any:
    """Return the status under each load; see `floquetrod.Rod.verdicts`."""
    tolerance = units.tolerance("growth_tolerance", growth_tolerance)
    friction_kick = friction_and_kick(friction, kick)
    validate.progress(progress)
    if criterion is not None:
        validate.instance("criterion", criterion, FiniteTimeCriterion)
        criterion.require_alone(growth_tolerance=tolerance, friction=0.0 if friction_kick is None else friction_kick[0])
    if friction_kick is not None:
        from floquetrod.rod.friction.kicks import kicked_loads

        model.require("friction")
        blocks = loads.in_parts(progress)
        status = np.concatenate(
            [kicked_loads(model.rod, model.systems(block), *friction_kick, tolerance, workers) for block in blocks]
        )
    elif criterion is not None:
        status = model.passing(loads, criterion, workers, progress)
    else:
        status = model.status(loads, tolerance, workers, progress)
    return shaped(status, loads.shape)
