"""The simulations of DOI 10.1115/1.4031710: Figure 4 (no friction), Figure 7 (friction), and what torsion and shear do.

Forces are parts of the critical force of the reference rod.  What the paper leaves open is an argument here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from floquetrod.load import AxialLoad
from floquetrod.perturbation import Perturbation
from floquetrod.rod import Rod
from floquetrod.simulation import Simulation
from floquetrod.simulator import simulate

Report = Callable[[str], None]
"""Called with what is about to be simulated."""

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
class Outcome:
    """What one simulation found, beside what was expected of it.

    Attributes
    ----------
    mean, amplitude, frequency : float
        The load: parts of the critical force, and rad/s.
    case : str
        The perturbation.
    expected_modes : tuple of int
        The modes one of which was expected to win; none when the rod was expected to stay.
    buckled : bool
    mode : int
        The dominant mode where it buckled, 0 otherwise.
    run : Simulation
    """

    mean: float
    amplitude: float
    frequency: float
    case: str
    expected_modes: tuple[int, ...]
    buckled: bool
    mode: int
    run: Simulation = field(repr=False, compare=False)

    @property
    def agrees(self) -> bool:
        """Whether it stayed or buckled as expected, into a mode expected."""
        return self.mode in self.expected_modes if self.expected_modes else not self.buckled


def figure_4(
    seed: int = 1,
    speed: float = 1e-3,
    duration: float = 2.0,
    segments: int = 250,
    loads: dict[float, Sequence[float]] | None = None,
    report: Report | None = None,
) -> Iterator[Outcome]:
    """Yield the ten frictionless simulations, dF = 0.2 F_cr, against the verdict on the mode equations.

    Random speeds up to ``speed`` (m/s) set the rod moving.  Expected is buckling where a mode grows by a factor of 100
    within ``duration``; what grows more slowly does not leave the linear regime in that time.
    """
    rod = Rod.nitinol()
    force = rod.critical_force
    for frequency, means in (loads or FIGURE_4).items():
        for mean in means:
            load = AxialLoad(mean * force, 0.2 * force, frequency)
            if report is not None:
                report(f"{frequency:g} rad/s, mean {mean:g} Fcr, no friction")
            verdict = rod.stability(load)
            rates = zip(verdict.modes, verdict.mode_growth_rates, strict=True)
            grow = tuple(mode for mode, rate in rates if rate * duration > np.log(100.0))
            run = simulate(rod, load, duration, 0.0, Perturbation.random(speed, seed), segments)
            yield _outcome(run, (mean, 0.2, frequency), f"random, seed {seed}", grow)


def figure_7(
    cases: Sequence[str] = ("A", "B", "C first", "C 10", "D"),
    seed: int = 1,
    highest: int = 20,
    duration: float = 4.0,
    segments: int = 250,
    report: Report | None = None,
) -> Iterator[Outcome]:
    """Yield the simulations with friction, dF = 0.7 F_cr, mu = 0.1, kicks of 50 mm/s, against the paper's table.

    ``seed`` draws the speeds of cases C and D, ``highest`` is the last mode that C kicks, which the paper leaves open;
    "C first" is C with the mode of A: 6 at 85 rad/s, 8 at 150 rad/s.
    """
    rod = Rod.nitinol()
    force = rod.critical_force
    for (frequency, mean), expected in FIGURE_7.items():
        first = 6 if frequency < 100.0 else 8
        for case in cases:
            name = case.replace("first", str(first))
            letter, _, mode = name.partition(" ")
            kick = Perturbation.case(letter, 0.05, int(mode or first), seed, highest)
            if report is not None:
                report(f"{frequency:g} rad/s, mean {mean:g} Fcr, friction 0.1, case {name}")
            run = simulate(rod, AxialLoad(mean * force, 0.7 * force, frequency), duration, 0.1, kick, segments)
            modes = (expected[name],) if expected[name] else ()
            yield _outcome(run, (mean, 0.7, frequency), name, modes)


def torsion_and_shear_share(run: Simulation) -> float:
    """Return the part of the elastic energy of bending, twist and shear that twist and shear hold (claim E).

    The largest over the frames in which the rod holds more than a hundredth of its largest energy of bending.  Stretch
    is left out, which would only make the part smaller.
    """
    energy = run.energy
    minor, bend = energy["twist"] + energy["shear"], energy["bend"]
    held = bend > 0.01 * bend.max()
    return float((minor[held] / (minor[held] + bend[held])).max())


def _outcome(run: Simulation, load: tuple[float, float, float], case: str, modes: tuple[int, ...]) -> Outcome:
    mean, amplitude, frequency = load
    return Outcome(
        mean=mean,
        amplitude=amplitude,
        frequency=frequency,
        case=case,
        expected_modes=modes,
        buckled=run.buckled,
        mode=run.dominant_mode if run.buckled else 0,
        run=run,
    )
