"""The simulations of DOI 10.1115/1.4031710: Figure 4 (no friction), Figure 7 (friction), and what torsion and shear do.

Forces are parts of the critical force of the reference rod.  What the paper leaves open is an argument here.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.compilation import cores
from floquetrod._util.progress import Progress
from floquetrod.ensembles.ensemble import ensemble
from floquetrod.ensembles.variables import PENDING
from floquetrod.rod.loads.load import AxialLoad
from floquetrod.rod.rod import Rod
from floquetrod.simulation.simulation_problem import Simulation, SimulationProblem
from floquetrod.simulation.start import Perturbation

ROD = Rod.nitinol()
SPEED, HIGHEST = 0.05, 20
"""Of the perturbations with friction: v_0 in m/s, and the last mode that case C kicks, which the paper leaves open."""

FIGURE_4 = {85.0: (0.10, 0.25, 0.40, 0.55, 0.70), 150.0: (0.05, 0.20, 0.34, 0.52, 0.63)}
"""Mean forces at each frequency (rad/s); those at 85 rad/s are ours, on both sides of the 0.45 of claim F3-a."""

_FRAMES_4 = 601  # of 3 s: more than 8 in each of 72 periods of 150 rad/s, as fits of growth need

FIGURE_7 = {
    (85.0, 0.118): {"A": 0, "B": 0, "C 6": 0, "C 10": 0, "D": 0},
    (85.0, 0.424): {"A": 0, "B": 0, "C 6": 0, "C 10": 0, "D": 0},
    (85.0, 0.825): {"A": 6, "B": 6, "C 6": 6, "C 10": 6, "D": 0},
    (150.0, 0.118): {"A": 0, "B": 0, "C 8": 0, "C 10": 0, "D": 0},
    (150.0, 0.424): {"A": 8, "B": 8, "C 8": 8, "C 10": 0, "D": 0},
    (150.0, 0.825): {"A": 8, "B": 8, "C 8": 9, "C 10": 9, "D": 0},
}
"""What the paper found at (frequency, mean force): the mode it buckled into, 0 for none, for every perturbation."""


@dataclass(frozen=True)
class Trial:
    """One simulation to be made, and what is expected of it.

    Attributes
    ----------
    problem : SimulationProblem
    mean : float
        The mean force as the paper states it, a part of the critical force.
    case : str
        The perturbation in a word.
    expected_modes : tuple of int
        The modes one of which is expected to win; none when the rod is expected to stay.
    """

    problem: SimulationProblem
    mean: float
    case: str
    expected_modes: tuple[int, ...]

    @property
    def frequency(self) -> float:
        """Frequency of the load in rad/s."""
        return self.problem.load.frequency

    @property
    def amplitude(self) -> float:
        """Amplitude of the load, a part of the critical force."""
        return self.problem.load.amplitude / ROD.critical_force

    def run(self, progress: Progress | None = None) -> TrialOutcome:
        """Simulate it; ``progress`` is called with the steps done and to do."""
        run = self.problem.run(progress)
        return TrialOutcome(self, run.buckled, run.dominant_mode if run.buckled else 0, run)

    def __str__(self) -> str:
        """Return what distinguishes it from the others."""
        return f"{self.frequency:g} rad/s, mean {self.mean:g} Fcr, friction {self.problem.friction:g}, {self.case}"


@dataclass(frozen=True)
class TrialOutcome:
    """What a simulation found: whether the rod buckled, and into which mode (0 where it did not)."""

    trial: Trial
    buckled: bool
    mode: int
    run: Simulation = field(repr=False, compare=False)

    @property
    def agrees(self) -> bool:
        """Whether it stayed or buckled as expected, into a mode expected."""
        expected = self.trial.expected_modes
        return self.mode in expected if expected else not self.buckled


def figure_4(seed: int = 1, speed: float = 1e-3, duration: float = 3.0) -> list[Trial]:
    """Return the ten frictionless simulations, dF = 0.2 F_cr, with the verdict on the mode equations as expectation.

    Random speeds up to ``speed`` (m/s) start the motion.  Expected is buckling where a mode grows by a factor of 100
    within ``duration``; what grows more slowly does not leave the linear regime in that time.  Runs end beyond 45
    degrees, where modes mix.
    """
    kick, trials = Perturbation.random(speed, seed), []
    for frequency, means in FIGURE_4.items():
        for mean in means:
            load = _load(mean, 0.2, frequency)
            linear = ROD.stability(load)
            rates = zip(linear.modes, linear.mode_growth_rates.tolist(), strict=True)
            grow = tuple(mode for mode, rate in rates if rate * duration > np.log(100.0))
            problem = SimulationProblem(
                ROD, load, duration=duration, frames=_FRAMES_4, perturbation=kick, stop_early=True
            )
            trials.append(Trial(problem, mean, f"random, seed {seed}", grow))
    return trials


class Draws(NamedTuple):
    """What came of a trial with one draw of its speeds after another: whether the rod buckled, and its leading mode."""

    trial: Trial
    buckled: NDArray[np.bool_]
    modes: NDArray[np.int16]

    @property
    def agree(self) -> int:
        """How many draws ended as expected."""
        expected = self.trial.expected_modes
        return int(np.sum(self.buckled & np.isin(self.modes, expected) if expected else ~self.buckled))


def redraw(trials: Sequence[Trial], draws: int, progress: Progress | None = None) -> list[Draws]:
    """Make trials at one frequency that differ in the mean force alone, each with so many draws of its speeds."""
    first = trials[0].problem
    means = [trial.problem.load.mean for trial in trials]
    found = ensemble(first, over={"mean": means, "seed": range(1, draws + 1)}, progress=progress)
    if np.any(np.asarray(found["status"]) == PENDING):
        raise KeyboardInterrupt  # which ended the ensemble
    every = zip(trials, np.asarray(found["buckled"]), np.asarray(found["dominant_mode"]), strict=True)
    return [Draws(*each) for each in every]


def figure_7(
    cases: Sequence[str] = ("A", "B", "C first", "C 10", "D"), seed: int = 1, duration: float = 4.0
) -> list[Trial]:
    """Return the simulations with friction, dF = 0.7 F_cr, mu = 0.1, kicks of 50 mm/s, with the paper's table.

    ``seed`` draws the speeds of cases C and D; "C first" is C with the mode of A: 6 at 85 rad/s, 8 at 150 rad/s.
    """
    trials = []
    for (frequency, mean), expected in FIGURE_7.items():
        first = 6 if frequency < 100.0 else 8
        for case in cases:
            name = case.replace("first", str(first))
            letter, _, mode = name.partition(" ")
            kick = Perturbation.case(letter, SPEED, int(mode or first), seed, HIGHEST)
            modes = (expected[name],) if expected[name] else ()
            load = _load(mean, 0.7, frequency)
            problem = SimulationProblem(ROD, load, duration=duration, friction=0.1, perturbation=kick)
            trials.append(Trial(problem, mean, name, modes))
    return trials


def _load(mean: float, amplitude: float, frequency: float) -> AxialLoad:
    """Return a load from parts of the critical force and a frequency in rad/s."""
    return AxialLoad(mean * ROD.critical_force, amplitude * ROD.critical_force, frequency)


def run_trials(
    trials: Sequence[Trial], workers: int | None = None, progress: Callable[[Trial, int], None] | None = None
) -> list[TrialOutcome]:
    """Simulate in threads, by default as many as there are processors; return the outcomes in the order of the trials.

    ``progress`` is called after each with the trial and the number done.  Ctrl-C ends the runs under way, too.
    """
    stopped = threading.Event()

    def stop_if_told(done: int, total: int) -> None:
        if stopped.is_set():
            raise KeyboardInterrupt  # which ends a run as Ctrl-C would in the main thread

    with ThreadPoolExecutor(workers or cores()) as pool:
        running = {pool.submit(trial.run, stop_if_told): trial for trial in trials}
        try:
            for done, task in enumerate(as_completed(running), start=1):
                task.result()
                if progress is not None:
                    progress(running[task], done)
        except BaseException:
            stopped.set()
            pool.shutdown(cancel_futures=True)
            raise
    return [task.result() for task in running]


class MinorShare(NamedTuple):
    """What torsion and shear hold of the elastic energy of bending, torsion and shear (claim E).

    Stretch is left out, which would only make it smaller.  ``overall``: of the energy summed over all frames; ``most``:
    at the instant at which it is most, of those with more than a hundredth of the largest energy of bending; ``bend``:
    the energy of bending at that instant, of its largest; ``torsion``: what torsion alone holds of torsion and shear,
    overall.
    """

    overall: float
    most: float
    bend: float
    torsion: float


def torsion_and_shear_share(run: Simulation) -> MinorShare:
    """Return what torsion and shear hold of the elastic energy of a run, estimated by `torsion` and `shear`."""
    twisted, sheared, bend = torsion(run), shear(run), run.energy["bend"]
    minor = twisted + sheared
    held = np.flatnonzero(bend > 0.01 * bend.max())
    shares = minor[held] / (minor[held] + bend[held])
    at = held[shares.argmax()]
    overall = minor.sum() / (minor.sum() + bend.sum())
    return MinorShare(
        float(overall), float(shares.max()), float(bend[at] / bend.max()), float(twisted.sum() / minor.sum())
    )


def shear(run: Simulation) -> NDArray[np.float64]:
    """Return the energy in J that the shear forces of a run would store in a rod that they can shear, (frames,).

    The simulated rod cannot shear.  The force across it is EI r''', by differences.
    """
    mesh, rod = run.problem.mesh, run.rod
    directions = _directions(run)
    mirrored = np.pad(directions, ((0, 0), (1, 1), (0, 0)), mode="edge")  # at hinged ends
    forces = rod.flexural_rigidity * np.diff(mirrored, 2, axis=1) / mesh.segment_length**2
    across = forces - np.sum(forces * directions, axis=2, keepdims=True) * directions
    ratio = mesh.poisson_ratio
    rigidity = 6.0 * (1.0 + ratio) / (7.0 + 6.0 * ratio) * mesh.shear_modulus * rod.area  # Cowper's, of a full circle
    return np.asarray(0.5 * mesh.segment_length / rigidity * np.sum(across**2, axis=(1, 2)))


def torsion(run: Simulation) -> NDArray[np.float64]:
    """Return the most energy in J that torsion can hold in a run whose rod has come as it has, (frames,).

    A rod is twisted by the spin of its sections, which is simulated, and by its change of shape where its sections
    cannot spin: the area between the directions of neighbouring segments on the sphere, as they move.  The simulated
    rod has only the first.  Their energies add up to at most the square of the sum of their roots.
    """
    mesh, directions = run.problem.mesh, _directions(run)
    a, b = directions[:-1, :-1], directions[:-1, 1:]
    c, d = directions[1:, 1:], directions[1:, :-1]
    swept = np.cumsum(_area(a, b, c) + _area(a, c, d), axis=0)
    by_shape = 0.5 * mesh.torsional_rigidity / mesh.segment_length * np.sum(swept**2, axis=1)
    return np.asarray((np.sqrt(run.energy["twist"]) + np.sqrt(np.concatenate([[0.0], by_shape]))) ** 2)


def _directions(run: Simulation) -> NDArray[np.float64]:
    """Return the directions of all segments, (frames, segments, 3)."""
    tangents = np.diff(run.positions, axis=1)
    return np.asarray(tangents / np.linalg.norm(tangents, axis=2, keepdims=True))


def _area(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the signed area of triangles on the unit sphere."""
    volume = np.sum(a * np.cross(b, c), axis=-1)
    return np.asarray(2.0 * np.arctan2(volume, 1.0 + np.sum(a * b + b * c + c * a, axis=-1)))
