"""Systems by SKHiPPR, the Koopman-Hill projection of Hill's matrix: wrong verdicts on a chart, and times by size.

Skipped where SKHiPPR is not installed.  Set OPENBLAS_NUM_THREADS=1 for times of one thread.
"""

from __future__ import annotations

import importlib.util
import math
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

import floquetrod as fr
from benchmarks.measure import Row, best_of
from benchmarks.systems import COUPLING, SIDE, as_first_order, dop853_multipliers

Floats = NDArray[np.float64]

PEER, HARMONICS, SAMPLES = "SKHiPPR", 12, 64  # its multipliers are then good to 2e-12 on the chart
INSTALL = (
    "skipped: SKHiPPR is not installed. With Python 3.12 or newer: git clone https://github.com/f-bayer/SKHiPPR && "
    "pip install -e SKHiPPR (editable, as `pip install .` of its version 2.0 leaves out most of its packages)"
)


def run() -> list[Row]:
    """Return wrong verdicts and times, ours and theirs; nothing where SKHiPPR is not installed."""
    if importlib.util.find_spec("skhippr") is None:
        print(f"\n{INSTALL}")
        return []
    return [*verdicts(), *times()]


def oscillators(strength: float, frequency: float) -> fr.HillSystem:
    """Return q'' + (diag(1, 4) + strength cos wt COUPLING) q = 0."""
    return fr.HillSystem(np.diag([1.0, 4.0]), cosines=[strength * COUPLING], period=2.0 * math.pi / frequency)


def chart() -> list[fr.HillSystem]:
    """Return the systems of a chart of 100 points, frequency 1 to 5 and strength 0.05 to 1."""
    return [oscillators(e, w) for e in np.linspace(0.05, 1.0, SIDE) for w in np.linspace(1.0, 5.0, SIDE)]


def verdicts() -> list[Row]:
    """Return how many verdicts on the chart differ from the proved ones, or from those of 50 digits."""
    systems = chart()
    right = np.array([truth(system) for system in systems])
    count = right.size

    def wrong(name: str, found: Any, at_most: float | None = None) -> Row:
        number = int((np.asarray(found, dtype=bool) != right).sum())
        return Row(f"wrong verdicts of {count}: {name}", number, "points", at_most=at_most)

    return [
        wrong("fr.systems.is_stable", fr.systems.is_stable(fr.systems.stack(systems)), at_most=0.0),
        wrong(f"{PEER} as it comes, |mu| < 1", [projection(system)()[0] for system in systems]),
        wrong(f"{PEER}, sorted exponents of Hill's matrix", [projection(system, sort=True)()[0] for system in systems]),
    ]


def truth(system: fr.HillSystem) -> bool:
    """Return whether a system is stable, by proof, or by 50 digits where the proof leaves it open."""
    status = fr.certify(system).status
    if status == "undecided":
        status = fr.stability(system, method="reference", digits=50).status
    if status == "undecided":
        raise RuntimeError(f"undecided with 50 digits: {system!r}")
    return status == "stable"


def times() -> list[Row]:
    """Return the times of a verdict by size: one call, and one of many systems, against those of both peers."""
    rows = []
    for n, many in ((2, SIDE**2), (8, 32), (32, 4)):
        systems = chart() if n == 2 else [sized(n, w) for w in np.linspace(2.3, 2.7, many)]
        one, batch = systems[0], fr.systems.stack(systems)
        alone = best_of(lambda one=one: fr.stability(one))
        together = best_of(lambda batch=batch: fr.systems.is_stable(batch, workers=1)) / len(systems)
        theirs = best_of(projection(one), repeats=3)
        other = best_of(lambda one=one: dop853(one), repeats=3)
        for name, ours in (("one call", alone), (f"{many} at once", together)):
            for peer, seconds in ((PEER, theirs), ("DOP853", other)):
                rows.append(Row(f"{n} equations, {name}", 1e3 * ours, "ms", peer, 1e3 * seconds))
    return rows


def sized(n: int, frequency: float) -> fr.HillSystem:
    """Return n coupled equations with frequencies up to 4."""
    random = np.random.default_rng(1).normal(size=(n, n)) / n
    stiffness = np.diag(16.0 * (np.arange(1.0, n + 1.0) / n) ** 2)
    return fr.HillSystem(stiffness, cosines=[0.2 * (random + random.T)], period=2.0 * math.pi / frequency)


def dop853(system: fr.HillSystem) -> NDArray[np.complex128]:
    """Return the eigenvalues of the monodromy matrix by solve_ivp, DOP853 with rtol 1e-10."""
    amplitudes = np.asarray(system.cosines)
    return dop853_multipliers(*as_first_order(np.asarray(system.stiffness), amplitudes, float(system.period)), 1e-10)


def projection(system: fr.HillSystem, *, sort: bool = False) -> Callable[[], tuple[bool, NDArray[np.complex128]]]:
    """Return a call of SKHiPPR: verdict and multipliers of the equilibrium, its Hill matrix computed each time.

    The matrices of the Fourier transform, the same for all systems of a size, are made beforehand, and no Newton
    iteration runs, since the equilibrium is known.
    """
    from skhippr.cycles.hbm import HBMEquation
    from skhippr.Fourier import Fourier
    from skhippr.odes.AbstractODE import AbstractODE
    from skhippr.stability.ClassicalHill import ClassicalHill
    from skhippr.stability.KoopmanHillProjection import KoopmanHillProjection

    n, w = system.order, 2.0 * math.pi / float(system.period)
    mean, harmonics, _ = as_first_order(np.asarray(system.stiffness), np.asarray(system.cosines), float(system.period))
    amplitude = harmonics[0].real

    class Linear(AbstractODE):
        def __init__(self) -> None:
            super().__init__(autonomous=False, n_dof=2 * n)
            self.t, self.x, self.omega = 0.0, np.zeros(2 * n), w

        def closed_form_derivative(self, variable: str, t: Any = None, x: Any = None) -> Floats:
            if variable != "x":
                raise NotImplementedError(variable)
            wave = np.cos(self.omega * np.asarray(self.t if t is None else t))
            matrix: Floats = np.multiply.outer(mean, np.ones_like(wave)) + np.multiply.outer(amplitude, wave)
            return matrix

        def dynamics(self, t: Any = None, x: Any = None) -> Floats:
            matrix = self.closed_form_derivative("x", t, x)
            rise: Floats = np.einsum("ij...,j...->i...", matrix, self.x if x is None else x)
            return rise

    fourier = Fourier(HARMONICS, SAMPLES, 2 * n)
    method = ClassicalHill(fourier, "imaginary") if sort else KoopmanHillProjection(fourier)
    rest = np.zeros(2 * n * (2 * HARMONICS + 1))

    def call() -> tuple[bool, NDArray[np.complex128]]:
        equation = HBMEquation(Linear(), w, fourier, initial_guess=rest, stability_method=method)
        equation.residual(update=True)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            stable, found = equation.determine_stability(update=True)
        return bool(stable), found

    return call
