"""`fr.simulate`: the whole nonlinear rod, step by step, as a confirmation independent of the mode analysis."""

from __future__ import annotations

import inspect
from dataclasses import fields
from pathlib import Path
from typing import Any

from floquetrod.rod.loads.load import AnyLoad, require_load
from floquetrod.rod.rod import Rod
from floquetrod.simulation.integration import Progress
from floquetrod.simulation.problem import Simulation, SimulationProblem


def simulate(
    rod: Rod, load: AnyLoad, *, progress: Progress | None = None, checkpoint: str | Path | None = None, **options: Any
) -> Simulation:
    """Simulate a rod in its channel: stretch, bending and twist, contact with the wall, Coulomb friction.

    Parameters
    ----------
    rod : Rod
    load : AxialLoad, AxialWave or ForceRecord
    progress : callable, optional
        See `SimulationProblem.run`.
    checkpoint : path, optional
        See `SimulationProblem.run`.
    **options
        Those of `SimulationProblem`: ``duration`` in s, ``friction``, ``perturbation``, ``segments`` and so on.

    Returns
    -------
    Simulation

    Raises
    ------
    TypeError
        For an option that there is not; besides what `SimulationProblem` and its method ``run`` raise.

    Examples
    --------
    >>> rod = Rod.nitinol()
    >>> from floquetrod.rod.loads.load import AxialLoad
    >>> load = AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0)
    >>> run = simulate(rod, load, duration=0.01, segments=60, frames=5)
    >>> run.angle.shape, run.complete
    ((5, 61), True)
    """
    known = [part.name for part in fields(SimulationProblem) if part.kw_only]
    if unknown := [name for name in options if name not in known]:
        raise TypeError(f"simulate has no option {unknown[0]!r}; the options are {', '.join(known)}")
    return SimulationProblem(rod, require_load("load", load), **options).run(progress, checkpoint)


def _signature() -> inspect.Signature:
    """Return the signature of `simulate` with the options of the problem spelled out."""
    problem, own = inspect.signature(SimulationProblem), inspect.signature(simulate)
    extra = [own.parameters[name] for name in ("progress", "checkpoint")]
    return own.replace(parameters=[*problem.parameters.values(), *extra])


simulate.__signature__ = _signature()  # type: ignore[attr-defined]
