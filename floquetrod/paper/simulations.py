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

from floquetrod._util.compilation import cores
from floquetrod.rod.load import AxialLoad
from floquetrod.rod.rod import Rod
from floquetrod.rod.stability import growth_of_modes
from floquetrod.simulation.integration import Progress
from floquetrod.simulation.problem import Simulation, SimulationProblem
from floquetrod.simulation.start import Perturbation

ROD = Rod.nitinol()
SPEED, HIGHEST = 0.05, 20
"""Of the perturbations with friction: v_0 in m/s, and the last mode that case C kicks, which the paper leaves open."""

FIGURE_4 = {85.0: (0.10, 0.25, 0.40, 0.55, 0.70), 150.0: (0.05, 0.20, 0.34, 0.52, 0.63)}
"""Mean forces at each frequency (rad/s); those at 85 rad/s are ours, on both sides of the 0.45 of claim F3-a."""

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

    def carry_out(self, progress: Progress | None = None) -> Outcome:
        """Simulate it; ``progress`` is called with the steps done and to do."""
        run = self.problem.run(progress)
        return Outcome(self, run.buckled, run.dominant_mode if run.buckled else 0, run)

    def __str__(self) -> str:
        """Return what distinguishes it from the others."""
        return f"{self.frequency:g} rad/s, mean {self.mean:g} Fcr, friction {self.problem.friction:g}, {self.case}"


@dataclass(frozen=True)
class Outcome:
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


def figure_4(seed: int = 1, speed: float = 1e-3, duration: float = 2.0, segments: int = 250) -> list[Trial]:
    """Return the ten frictionless simulations, dF = 0.2 F_cr, with the verdict on the mode equations as expectation.

    Random speeds up to ``speed`` (m/s) start the motion.  Expected is buckling where a mode grows by a factor of 100
    within ``duration``; what grows more slowly does not leave the linear regime in that time.
    """
    kick, trials = Perturbation.random(speed, seed), []
    for frequency, means in FIGURE_4.items():
        for mean in means:
            load = _load(mean, 0.2, frequency)
            modes = ROD.independent_modes(load).modes
            rates = zip(modes, growth_of_modes(ROD, load, modes), strict=True)
            grow = tuple(mode for mode, rate in rates if rate * duration > np.log(100.0))
            problem = SimulationProblem(ROD, load, duration=duration, perturbation=kick, segments=segments)
            trials.append(Trial(problem, mean, f"random, seed {seed}", grow))
    return trials


def figure_7(
    cases: Sequence[str] = ("A", "B", "C first", "C 10", "D"),
    seed: int = 1,
    duration: float = 4.0,
    segments: int = 250,
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
            problem = SimulationProblem(
                ROD, load, duration=duration, friction=0.1, perturbation=kick, segments=segments
            )
            trials.append(Trial(problem, mean, name, modes))
    return trials


def _load(mean: float, amplitude: float, frequency: float) -> AxialLoad:
    """Return a load from parts of the critical force and a frequency in rad/s."""
    return AxialLoad(mean * ROD.critical_force, amplitude * ROD.critical_force, frequency)


def carry_out(
    trials: Sequence[Trial], workers: int | None = None, progress: Callable[[Trial, int], None] | None = None
) -> list[Outcome]:
    """Simulate in threads, by default as many as there are processors; return the outcomes in the order of the trials.

    ``progress`` is called after each with the trial and the number done.  Ctrl-C ends the runs under way, too.
    """
    stopped = threading.Event()

    def heed(done: int, total: int) -> None:
        if stopped.is_set():
            raise KeyboardInterrupt  # which ends a run as Ctrl-C would in the main thread

    with ThreadPoolExecutor(workers or cores()) as pool:
        running = {pool.submit(trial.carry_out, heed): trial for trial in trials}
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
    """What twist and shear hold of the elastic energy of bending, twist and shear (claim E).

    Stretch is left out, which would only make it smaller.  ``overall``: of the energy summed over all frames; ``most``:
    at the instant at which it is most, of those with more than a hundredth of the largest energy of bending; ``bend``:
    the energy of bending at that instant, of its largest; ``twist``: what twist alone holds of twist and shear,
    overall.
    """

    overall: float
    most: float
    bend: float
    twist: float


def torsion_and_shear_share(run: Simulation) -> MinorShare:
    """Return what twist and shear hold of the elastic energy of a run."""
    minor, bend = run.energy["twist"] + run.energy["shear"], run.energy["bend"]
    held = np.flatnonzero(bend > 0.01 * bend.max())
    shares = minor[held] / (minor[held] + bend[held])
    at = held[shares.argmax()]
    overall = minor.sum() / (minor.sum() + bend.sum())
    twist = run.energy["twist"].sum() / minor.sum()
    return MinorShare(float(overall), float(shares.max()), float(bend[at] / bend.max()), float(twist))
