"""`fr.simulate`: the whole nonlinear rod, step by step, as a confirmation independent of the mode analysis."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from floquetrod._util.progress import Progress
from floquetrod.rod.loads.load import AnyLoad, require_load
from floquetrod.rod.loads.tool import VibrationTool
from floquetrod.rod.rod import Rod
from floquetrod.simulation.simulation_problem import Simulation, SimulationProblem
from floquetrod.simulation.start import Perturbation
from floquetrod.simulation.start_state import StartState


def simulate(
    rod: Rod,
    load: AnyLoad,
    *,
    duration: float = SimulationProblem.duration,
    friction: Any = SimulationProblem.friction,
    perturbation: Perturbation | None = None,
    segments: int | None = None,
    time_step: float | None = None,
    frames: int = SimulationProblem.frames,
    poisson_ratio: float = SimulationProblem.poisson_ratio,
    indentation: float = SimulationProblem.indentation,
    contact_damping: float = SimulationProblem.contact_damping,
    feed_speed: float | None = None,
    far_force: float | None = None,
    tool: VibrationTool | None = None,
    stop_early: bool = False,
    natural_curvature: float | str = SimulationProblem.natural_curvature,
    start: Simulation | StartState | str | Path | None = None,
    progress: Progress | None = None,
    checkpoint: str | Path | None = None,
) -> Simulation:
    """Simulate a rod in its channel: stretch, bending and twist, contact with the wall, Coulomb friction.

    All but the last two arguments make a `SimulationProblem`, which describes them, and raises errors for invalid ones.

    Parameters
    ----------
    rod : Rod
    load : AxialLoad, AxialWave or ForceRecord
    duration : float
        In s.
    friction : float or sequence of (float or str, float)
        mu, static = kinetic, along the channel and around it; or pairs of a depth in m, measured down the well or the
        channel, and the coefficient from there on, the first at 0.
    perturbation : Perturbation, optional
        Speeds at the start; by default Perturbation.random(1e-3, seed=1).
    segments : int, optional
        Of the rod; by default as many as the modes that may grow need.
    time_step : float, optional
        The largest step to take, in s; by default the critical one with a margin.
    frames : int
        Frames kept, the start and the end among them.
    poisson_ratio : float
        In (-1, 0.5]; with Young's modulus it gives the shear modulus.
    indentation : float
        Depth to which the weight of the rod at rest indents the floor, as a fraction of the radial clearance.
    contact_damping : float
        Damping of small motion against the wall about rest, as a fraction of the critical damping.
    feed_speed : float, optional
        Speed in m/s at which the upper end is moved down the channel, in place of the force there.
    far_force : float, optional
        Mean effective compression at the lower end in N, where that end is pushed; by default the mean of the load.
    tool : VibrationTool, optional
        In the rod, which it pushes and pulls along the channel.
    stop_early : bool
        Whether the run ends once the rod has buckled, or friction holds it at rest.
    natural_curvature : float, str or "path"
        Curvature in 1/m, or with its unit, of a rod with a path when no load acts; "path" is the curvature of the well.
    start : Simulation or path, optional
        Another run of the same rod, or its npz file, from whose last state this one goes on, under this load.
    progress : callable, optional
        Called with the numbers of steps done and to do.
    checkpoint : path, optional
        A file kept up to date, with which the run continues; see `SimulationProblem.run`.

    Returns
    -------
    Simulation

    Raises
    ------
    TypeError, ValueError
        As `SimulationProblem`, and for a checkpoint as `SimulationProblem.run`.
    SimulationDiverged
        Where the motion leaves the range of doubles.

    Examples
    --------
    >>> rod = Rod.nitinol()
    >>> from floquetrod.rod.loads.load import AxialLoad
    >>> load = AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0)
    >>> run = simulate(rod, load, duration=0.01, segments=60, frames=5)
    >>> run.angle.shape, run.complete
    ((5, 61), True)
    """
    problem = SimulationProblem(
        rod,
        require_load("load", load),
        duration=duration,
        friction=friction,
        perturbation=perturbation,  # type: ignore[arg-type]  # None stands for the default
        segments=segments,  # type: ignore[arg-type]
        time_step=time_step,
        frames=frames,
        poisson_ratio=poisson_ratio,
        indentation=indentation,
        contact_damping=contact_damping,
        feed_speed=feed_speed,
        far_force=far_force,
        tool=tool,
        stop_early=stop_early,
        natural_curvature=natural_curvature,
        start=start,  # type: ignore[arg-type]  # a run or its file stand for its last state
    )
    return problem.run(progress, checkpoint)
