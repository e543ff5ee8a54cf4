"""One load on a rod: the verdict, of a measured force within its noise, and the smallest kick that buckles the rod."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, cast

from floquetrod._util import validate
from floquetrod._util.progress import Progress
from floquetrod.rod.answers.verdict import RodStability
from floquetrod.rod.friction.mode_friction import friction_and_kick
from floquetrod.rod.loads.load import AnyLoad, Load, LoadSource, require_load
from floquetrod.rod.model.assumptions import warn_unless_uniform
from floquetrod.rod.model.parts import friction_coefficient
from floquetrod.rod.model.plausibility import warn_of_hertz, warn_of_load
from floquetrod.rod.modes.mode_model import ModeModel

# Loaded by what needs them: a first verdict takes a quarter of the package.
if TYPE_CHECKING:
    from floquetrod.rod.friction.kicks import CriticalKick, FrictionalRodStability
    from floquetrod.rod.loads.record import ForceRecord


def stability(
    model: ModeModel,
    given: AnyLoad,
    modes: Iterable[int] | None,
    growth_tolerance: float,
    friction: float | None,
    kick: float | None,
    progress: Progress | None,
) -> RodStability | FrictionalRodStability:
    """Return the verdict under a load or a record; see `floquetrod.Rod.stability`."""
    load, rod = require_load("load", given), model.rod
    frictional = friction_and_kick(friction, kick)
    tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
    validate.progress(progress)
    record = cast("ForceRecord", given) if isinstance(given, LoadSource) else None
    warn_unless_uniform(rod, load)
    warn_of_load(rod, load if record is None or record.force_unit_named else record)
    if friction is not None:
        model.require("friction")
    if record is not None:
        from floquetrod.rod.record_noise import classify_record

        return classify_record(model, record, modes, tolerance, progress)
    linear = model.verdict(load, modes, tolerance, progress)
    if linear.stable and modes is None and model.prompt:
        warn_of_hertz(rod, load, tolerance)
    return linear if frictional is None else model.with_kick(linear, *frictional)


def critical_kick(model: ModeModel, load: Load, friction: float, growth_tolerance: float) -> CriticalKick:
    """Return the smallest kick that buckles the rod; see `floquetrod.Rod.critical_kick`."""
    from floquetrod.rod.friction import kicks

    coefficient = friction_coefficient(friction)
    model.require("friction")
    linear = stability(model, load, None, growth_tolerance, None, None, None)
    return kicks.critical_kick(cast("RodStability", linear), coefficient)
