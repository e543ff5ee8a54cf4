"""`fr.simulate`: the whole nonlinear rod, step by step, as a confirmation that owes nothing to the mode analysis."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from floquetrod._util import validate
from floquetrod.rod.coulomb import friction_coefficient
from floquetrod.rod.load import AxialLoad
from floquetrod.rod.rod import Rod
from floquetrod.simulation.integration import Course, Progress
from floquetrod.simulation.mesh import DiscreteRod
from floquetrod.simulation.result import Setting, Simulation
from floquetrod.simulation.start import Perturbation

_LARGEST_STRAIN = 0.02  # that a load may cause: beyond it linear elasticity has no meaning (a choice)
_MOST_MEMORY = 1 << 32  # bytes of all frames (a choice)
_MOST_WORK = 1e14  # steps times segments, of which a core does some 1e8 in a second: two weeks (a choice)
_SMALLEST_PART = 1e-9  # of the safe step: a smaller one adds nothing but rounding (a choice)


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
        if it had never stopped.  ValueError, before anything is computed, when nothing can be written there, and for a
        file that is damaged, belongs to another run, or cannot be continued to the bit here (docs/simulator.md says
        when).  A save that fails later warns with `CheckpointWarning`, is tried again, and costs no frame.
    poisson_ratio, indentation, contact_damping : float
        See `floquetrod.segmented.DiscreteRod`.

    Returns
    -------
    Simulation
        With ``complete`` False, and the frames so far, when interrupted by Ctrl-C.

    Raises
    ------
    SimulationDiverged
        When the rod leaves every sensible state; its ``simulation`` holds the frames before.
    ValueError
        Also for a run of more than 1e14 steps times segments, some two weeks, or of frames that take more than 4 GiB.

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
    where = None if checkpoint is None else validate.path("checkpoint", checkpoint)
    validate.progress(progress)
    return Course(setting, where).run(progress)


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
    duration = validate.positive("duration", duration, "in s")
    frames = validate.integer("frames", frames, 2)
    friction = friction_coefficient(friction)
    try:
        _require_small_strain(rod, load)
        cut = DiscreteRod(rod, segments, poisson_ratio, indentation, contact_damping)
        velocities = kick.velocities(cut.segments)
        _require_bearable_frames(frames, cut.segments)
        step, limit = _step(cut, time_step, float(np.abs(velocities).max()))
        per_frame = _steps_per_frame(cut.segments, duration, frames, step, asked=time_step is not None)
    except ArithmeticError as error:  # of a rod whose data lie further apart than a double reaches
        raise ValueError(
            f"rod, load, indentation or contact_damping too extreme to be simulated ({error.args[-1]}); check "
            f"the units of {rod}"
        ) from None
    return Setting(
        rod=rod,
        load=load,
        perturbation=kick,
        duration=duration,
        friction=friction,
        segments=cut.segments,
        frames=frames,
        steps_per_frame=per_frame,
        poisson_ratio=cut.poisson_ratio,
        indentation=cut.indentation,
        contact_damping=cut.contact_damping,
        step_limit=limit,
    )


def _require_small_strain(rod: Rod, load: AxialLoad) -> None:
    strain = (abs(load.mean) + load.amplitude) / (rod.youngs_modulus * rod.area)
    if strain > _LARGEST_STRAIN:
        raise ValueError(
            f"load strains the rod by {strain:.2g}, must be at most {_LARGEST_STRAIN:g}; its critical force is "
            f"{rod.critical_force:.4g} N: check the units"
        )


def _require_bearable_frames(frames: int, segments: int) -> None:
    """Raise ValueError for more frames than memory should hold."""
    frame = 6 * 8 * (segments + 1)
    most = _MOST_MEMORY // frame
    if frames > most:
        raise ValueError(
            f"frames must be at most {most:,} with {segments} segments, got {frames:,} of {frame:,} bytes each; take "
            "fewer"
        )


def _step(cut: DiscreteRod, asked: float | None, speed: float) -> tuple[float, str]:
    """Return the largest step to take in s, and what sets it."""
    safe, limit = cut.critical_time_step(speed)
    if not 0.0 < safe < math.inf:
        raise ArithmeticError(f"its safe step is {safe} s")
    if asked is None:
        return safe, limit
    step = validate.positive("time_step", asked, "in s")
    if step > safe:
        raise ValueError(
            f"time_step must be at most {safe:.4g} s, got {step:.4g} s: a longer one is unstable, by "
            f"{cut.critical_time_step()[1]}; leave it out, or take fewer segments"
        )
    if step < _SMALLEST_PART * safe:
        raise ValueError(f"time_step must be at least {_SMALLEST_PART * safe:.4g} s, got {step:.4g} s; leave it out")
    return step, "choice"


def _steps_per_frame(segments: int, duration: float, frames: int, step: float, *, asked: bool) -> int:
    """Return how many steps lie between frames; ValueError for a run that nobody will see the end of."""
    steps, most = max(duration / step, frames - 1.0), _MOST_WORK / segments
    if steps > most:
        name, value = ("time_step", step) if asked else ("duration", duration)
        raise ValueError(
            f"{name} of {value:.4g} s makes {steps:.4g} steps of {step:.4g} s, at most {most:.4g} are taken with "
            f"{segments} segments (about two weeks on one core); simulate a shorter time, or take a longer step or "
            "fewer segments"
        )
    between = duration / (frames - 1)
    if between < _SMALLEST_PART * step:
        raise ValueError(
            f"duration must be at least {(frames - 1) * _SMALLEST_PART * step:.4g} s with {frames} frames, got "
            f"{duration:.4g} s"
        )
    return math.ceil(between / step)
