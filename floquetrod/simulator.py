"""`fr.simulate`: the whole nonlinear rod, step by step, as a confirmation that owes nothing to the mode analysis."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from floquetrod import _validate
from floquetrod.course import Course, Progress
from floquetrod.load import AxialLoad
from floquetrod.perturbation import Perturbation
from floquetrod.rod import Rod
from floquetrod.segmented import SegmentedRod
from floquetrod.simulation import Setting, Simulation

_LARGEST_STRAIN = 0.02  # that a load may cause: beyond it linear elasticity has no meaning (a choice)


def simulate(
    rod: Rod,
    load: AxialLoad,
    duration: float = 2.0,
    friction: float = 0.0,
    perturbation: Perturbation | None = None,
    segments: int = 250,
    time_step: float | None = None,
    frames: int = 400,
    progress: Progress | None = None,
    checkpoint: str | Path | None = None,
    poisson_ratio: float = 0.33,
    indentation: float = 1e-4,
    contact_damping: float = 0.3,
) -> Simulation:
    """Simulate a rod in its channel: stretch, shear, bending and twist, contact with the wall, Coulomb friction.

    The rod starts straight on the floor, squeezed by the mean force, with the speeds of ``perturbation``; its ends are
    hinged there, free to move along the channel, and pushed inwards by F(t).

    Parameters
    ----------
    rod : Rod
    load : AxialLoad
        Must strain the rod by less than 0.02.
    duration : float
        s.
    friction : float
        mu, static = kinetic, along the channel and around it.
    perturbation : Perturbation, optional
        By default Perturbation.random(1e-3, seed=1).
    segments : int
        At least 6 for every half wave of the critical mode and of those the perturbation names; none shorter than the
        rod's radius.
    time_step : float, optional
        The largest step to take, in s; by default the largest safe one.  Frames come at equal numbers of steps, so the
        step taken is a little smaller.  ValueError for one that is not safe.
    frames : int
        Frames kept, the start and the end among them.
    progress : callable, optional
        Called with the numbers of steps done and to do.
    checkpoint : path, optional
        A file that is kept up to date; when it is there at the start, the run goes on from it, to the bit the same as
        if it had never stopped.  ValueError when it is damaged or belongs to another run.
    poisson_ratio, indentation, contact_damping : float
        See `floquetrod.segmented.SegmentedRod`.

    Returns
    -------
    Simulation
        With ``complete`` False, and the frames so far, when interrupted by Ctrl-C.

    Raises
    ------
    SimulationDiverged
        When the rod leaves every sensible state; its ``simulation`` holds the frames before.

    Notes
    -----
    The model of section 3.3 of DOI 10.1115/1.4031710, for any rod; docs/simulator.md says how it is discretised.

    Examples
    --------
    >>> rod = Rod.nitinol()
    >>> load = AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0)
    >>> run = simulate(rod, load, duration=0.01, segments=60, frames=5)
    >>> run.angle.shape, run.complete
    ((5, 61), True)
    """
    setting = _setting(
        rod, load, duration, friction, perturbation, segments, time_step, frames, poisson_ratio, indentation,
        contact_damping,
    )  # fmt: skip
    return Course(setting, None if checkpoint is None else Path(checkpoint)).run(progress)


def _setting(
    rod: Rod,
    load: AxialLoad,
    duration: float,
    friction: float,
    perturbation: Perturbation | None,
    segments: int,
    time_step: float | None,
    frames: int,
    poisson_ratio: float,
    indentation: float,
    contact_damping: float,
) -> Setting:
    """Check what was asked for, and choose the step."""
    if not isinstance(rod, Rod):
        raise TypeError(f"rod must be a Rod, got {rod!r}")
    if not isinstance(load, AxialLoad):
        raise TypeError(f"load must be an AxialLoad, got {load!r}")
    kick = Perturbation.random(1e-3, seed=1) if perturbation is None else perturbation
    if not isinstance(kick, Perturbation):
        raise TypeError(f"perturbation must be a Perturbation such as Perturbation.modes({{8: 0.05}}), got {kick!r}")
    duration = _validate.positive("duration", duration, "in s")
    frames = _validate.integer("frames", frames, 2)
    strain = (abs(load.mean) + load.amplitude) / (rod.youngs_modulus * rod.area)
    if strain > _LARGEST_STRAIN:
        raise ValueError(
            f"load strains the rod by {strain:.2g}, must be at most {_LARGEST_STRAIN:g}; its critical force is "
            f"{rod.critical_force:.4g} N: check the units"
        )
    cut = SegmentedRod(rod, segments, poisson_ratio, indentation, contact_damping)
    safe, limit = cut.safe_step(float(np.abs(kick.velocities(cut.segments)).max()))
    if time_step is None:
        step = safe
    else:
        step, limit = _validate.positive("time_step", time_step, "in s"), "choice"
        if step > safe:
            raise ValueError(
                f"time_step must be at most {safe:.4g} s, got {step:.4g} s: a longer one is unstable, by "
                f"{cut.safe_step()[1]}; leave it out, or take fewer segments"
            )
    return Setting(
        rod=rod,
        load=load,
        perturbation=kick,
        duration=duration,
        friction=_validate.nonnegative("friction", friction, "mu is a coefficient such as 0.1"),
        segments=cut.segments,
        frames=frames,
        steps_per_frame=math.ceil(duration / (frames - 1) / step),
        poisson_ratio=cut.poisson_ratio,
        indentation=cut.indentation,
        contact_damping=cut.contact_damping,
        step_limit=limit,
    )
