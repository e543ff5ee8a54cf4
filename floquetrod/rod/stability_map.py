"""`fr.stability_map`: a rod's verdicts over a plane of loads."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.progress import Progress
from floquetrod.mathieu.paper_criterion import FiniteTimeCriterion
from floquetrod.plane import Axis, Chart, axis_values, charted
from floquetrod.rod import motion_map
from floquetrod.rod.friction.mode_friction import friction_and_kick
from floquetrod.rod.large_orbits import require_possible
from floquetrod.rod.load_plane import AXES, LoadPlane
from floquetrod.rod.loads.axial import require_off_resonance
from floquetrod.rod.loads.load import LOAD, QUANTITIES, AnyLoad, Loads
from floquetrod.rod.loads.template import replaced
from floquetrod.rod.model.assumptions import warn_unless_uniform
from floquetrod.rod.modes.mode_model import ModeModel
from floquetrod.rod.rod import Rod
from floquetrod.rod.shape_response import require_shape, responses


def stability_map(
    rod: Rod,
    load: AnyLoad | None = None,
    *,
    mean: Any = None,
    amplitude: Any = None,
    frequency: Any = None,
    growth: bool = False,
    growth_tolerance: float = 0.0,
    damping: float | None = None,
    criterion: FiniteTimeCriterion | None = None,
    friction: float | None = None,
    kick: float | None = None,
    certified: bool = False,
    large_motion: bool = False,
    response: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Chart:
    """Return the stability of a rod over two of mean force, amplitude and frequency, the third fixed.

    Parameters
    ----------
    rod : Rod
    load : AxialLoad, AxialWave or ForceRecord, optional
        Gives the quantity that is not named below, and all other properties of the loads; by default a sine, uniform
        except for the weight along the rod, and all three are named.
    mean : float, tuple (low, high, number) or increasing array, optional
        F_ave in N or with units.  Exactly one of the three quantities is a single number.
    amplitude : float, tuple (low, high, number) or increasing array, optional
        dF in N or with units, 0 or more.
    frequency : float, tuple (low, high, number) or increasing array, optional
        omega in rad/s or with units, greater than 0.  All modes that can matter are examined, everywhere.
    growth : bool
        Whether to compute the growth rate (1/s) and the fastest mode too.
    growth_tolerance : float
        Growth rate in 1/s up to which a mode counts as stable.
    damping : float, optional
        Decay rate of free motion in 1/s, in place of the rod's.
    criterion : FiniteTimeCriterion, optional
        The paper's test in place of stability for all time.
    friction : float, optional
        Coefficient of friction, 0 or more; it needs a ``kick``.  Not together with ``growth``, which is that without
        friction.
    kick : float, optional
        Transverse velocity in m/s that every mode is given, 0 or more; it needs ``friction``.
    certified : bool
        Whether to prove, too, the status of the cell about every point, see `Chart.cells`: nothing between the points
        is then missed.  For independent modes and stability for all time, with damping or a growth tolerance: without
        either, tongues too thin to matter are everywhere.
    large_motion : bool
        Whether to look, too, for loads under which the rod at rest is stable and carries a large motion that a kick may
        find: `Chart.large_motion`, hatched in its picture, NaN where the rod at rest is not stable.  In each mode
        alone, on the wall, to some percent of the angle; a search, in some milliseconds a point.  For stability for all
        time without friction.
    response : bool
        Whether to compute, too, how much a rod with a ``natural_shape`` moves where it is stable: `Chart.response`, the
        largest deflection in m to half a percent, as lines in its picture.  Coupled modes take some ten milliseconds a
        point.
    workers : int, optional
        Threads; by default one for each core when there is enough to do.
    progress : callable, optional
        Called with the numbers of points, then of cells, then of stable points, done and to do.

    Returns
    -------
    Chart
        ``stable`` at every point; the first quantity that varies is along x, the second along y.

    Raises
    ------
    TypeError, ValueError
        For anything but a rod and a load, numbers out of range, axes that do not increase, unless exactly one
        quantity is a single number, and for friction or a criterion where they do not apply.

    Examples
    --------
    >>> import floquetrod as fr
    >>> rod, load = Rod.nitinol(), fr.AxialLoad(mean="0.3N", amplitude="0.34N", frequency="24Hz")
    >>> stability_map(rod, load, mean=(0.0, "1.7N", 4), frequency=("4Hz", "32Hz", 5)).stable.shape
    (4, 5)
    """
    validate.instance("rod", rod, Rod)
    growth = validate.flag("growth", growth)
    if criterion is not None:
        validate.instance("criterion", criterion, FiniteTimeCriterion)
    template, given = replaced(load, mean, amplitude, frequency)
    in_units = units.GivenUnits.of(force=(mean, amplitude), frequency=frequency)
    mu_and_kick = friction_and_kick(friction, kick)
    workers = validate.workers(workers)
    validate.progress(progress)
    if mu_and_kick is not None and growth:
        raise validate.wrong_value("growth", "is that of the rod without friction; leave out either growth or friction")
    given = {name: units.si(values, name, LOAD[name].kind) for name, values in given.items()}
    largest = max(LOAD[name].largest for name in QUANTITIES)  # the number of points, too, is among the values
    fixed = [
        name for name, value in given.items() if validate.array(name, value, least=-largest, largest=largest).ndim == 0
    ]
    if len(fixed) != 1:
        raise ValueError(
            "exactly one of mean, amplitude and frequency must be a single number and the others (low, high, number) "
            f"or arrays; single numbers here: {', '.join(fixed) or 'none'}"
        )
    tolerance = units.tolerance("growth_tolerance", growth_tolerance)
    if damping is not None:
        rod = rod.replace(damping_rate=damping)
    across, up = (name for name in AXES if name not in fixed)
    x, y = (Axis(*AXES[name], axis_values(name, given[name])) for name in (across, up))
    value = validate.finite(fixed[0], given[fixed[0]])
    most = {fixed[0]: value, across: float(x.values[-1]), up: float(y.values[-1])}
    warn_unless_uniform(rod, template.with_numbers(**most))
    model = rod._modes_under(template)
    if validate.flag("certified", certified):
        _require_provable(model, tolerance, criterion=criterion, friction=mu_and_kick)
    if fixed[0] == "frequency":
        require_off_resonance(model.template, rod.axial_line, value)
    friction, kick = mu_and_kick or (None, None)
    plane = LoadPlane(rod, across, up, fixed[0], value, tolerance, criterion, friction, kick, template, workers)
    if validate.flag("large_motion", large_motion):
        _require_plain("large_motion", criterion=criterion, friction=mu_and_kick)
        require_possible(rod, model.template)
    if validate.flag("response", response):
        _require_plain("response", criterion=criterion, friction=mu_and_kick)
        require_shape(rod)
    chart = charted(plane, x, y, growth=growth, progress=progress)
    if certified:
        from floquetrod.rod.answers.certified_map import certified_cells

        edges = {across: x, up: y}
        cells = certified_cells(rod, model.template, edges, (fixed[0], value), tolerance, workers, progress)
        chart = replace(chart, cells=cells)
    given = {across: x.values, up: y.values[:, None], fixed[0]: np.array(value)}
    loads = Loads.of(*(given[name] for name in QUANTITIES))
    if large_motion:
        angles = motion_map.large_motion(rod, model.template, loads, chart.stable, progress)
        chart = replace(chart, large_motion=angles)
    if response:
        chart = replace(chart, response=responses(model, loads, chart.stable, progress, workers))
    return chart.given_in(in_units)


def _require_plain(argument: str, **others: Any) -> None:
    """Raise ValueError where a criterion or friction are given."""
    given = [name for name, value in others.items() if value is not None]
    if given:
        raise validate.wrong_value(
            argument, f"is about stability for all time without friction; leave out either it or {given[0]}"
        )


def _require_provable(model: ModeModel, tolerance: float, **others: Any) -> None:
    """Raise ValueError for a map whose cells cannot be proved."""
    _require_plain("certified", **others)
    model.require("certified")
    if tolerance == 0.0 and model.rod.damping_rate == 0.0:
        raise validate.wrong_value(
            "certified",
            "needs a growth_tolerance above 0, 1e-6 1/s say, or a rod with damping: without, tongues too "
            "thin to matter are everywhere, and no cell is stable",
        )
