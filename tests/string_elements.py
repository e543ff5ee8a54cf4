"""A model of strings of several sections that shares nothing with the package: Hermite elements and Magnus series.

Cubic elements, condensed to vibrations without force and to static corrections, what a force makes of the lowest of
them; the map over a period by a Magnus series of order four, with two numbers of steps.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigh, expm

from floquetrod._util.arrays import Floats

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(6)
_STEPS = 1.0  # in a radian of the fastest vibration, the second time twice as many
_LOWEST = 12  # vibrations whose static corrections are taken
MARGIN = 1e-5  # relative, of the model's growth


class Part(NamedTuple):
    """A length in m with one section in one bore: E I, inertia, weight in fluid per length, clearance."""

    length: float
    rigidity: float
    inertia: float
    weight: float
    clearance: float


class Growth(NamedTuple):
    """The growth rate in 1/s, negative where motion decays, and an estimate of its error."""

    rate: float
    error: float


def part(
    length: float, tube: dict[str, float], bore: float, fluids: tuple[float, float], gravity: float = 9.81
) -> Part:
    """Return a part from radii, modulus and density of its tube, the diameter of the bore, and fluids in and out."""
    outer, inner = math.pi * tube["radius"] ** 2, math.pi * tube["inner_radius"] ** 2
    own = tube["density"] * (outer - inner) + fluids[0] * inner
    return Part(
        length,
        tube["youngs_modulus"] * math.pi / 4 * (tube["radius"] ** 4 - tube["inner_radius"] ** 4),
        own + (math.pi**2 / 3 - 1) * fluids[1] * outer,
        gravity * (own - fluids[1] * outer),
        bore / 2 - tube["radius"],
    )


class StringModel:
    """Matrices of a string in a channel of one inclination (rad) and curvature in its plane (1/m)."""

    def __init__(
        self,
        parts: list[Part],
        ends: tuple[str, str],
        inclination: float = math.pi / 2,
        curvature: float = 0.0,
        mean_at: float = 0.5,
        elements: int = 320,
        modes: int = 44,
    ) -> None:
        total = sum(p.length for p in parts)
        numbers = [max(2, round(elements * p.length / total)) for p in parts]
        lengths = np.repeat([p.length / n for p, n in zip(parts, numbers, strict=True)], numbers)
        of = np.repeat(np.arange(len(parts)), numbers)
        begin = np.concatenate([[0.0], np.cumsum(lengths)])
        size = 2 * len(begin)
        mass, bent, push, hang, rest, bend = (np.zeros((size, size)) for _ in range(6))
        along = np.array([p.weight for p in parts]) * math.cos(inclination)
        gained = np.concatenate([[0.0], np.cumsum(along[of] * lengths)])
        at = float(np.interp(mean_at * total, begin, gained))
        x = 0.5 * (_POINTS + 1.0)
        for i, h in enumerate(lengths):
            p, block = parts[of[i]], np.s_[2 * i : 2 * i + 4, 2 * i : 2 * i + 4]
            value = np.array(
                [1 - 3 * x**2 + 2 * x**3, h * (x - 2 * x**2 + x**3), 3 * x**2 - 2 * x**3, h * (x**3 - x**2)]
            )
            slope = np.array([6 * x * (x - 1), h * (1 - 4 * x + 3 * x**2), 6 * x * (1 - x), h * (3 * x**2 - 2 * x)]) / h
            curve = np.array([12 * x - 6, h * (6 * x - 4), 6 - 12 * x, h * (6 * x - 2)]) / h**2
            w = 0.5 * h * _WEIGHTS
            mass[block] += p.inertia * (value * w) @ value.T
            bent[block] += p.rigidity * (curve * w) @ curve.T
            push[block] += (slope * w) @ slope.T
            force = gained[i] + along[of[i]] * h * x - at
            hang[block] += (slope * (w * force)) @ slope.T
            held = (p.weight * math.sin(inclination) + curvature * force) / p.clearance
            rest[block] += (value * (w * held)) @ value.T
            bend[block] += curvature / p.clearance * (value * w) @ value.T
        fixed = []
        for node, end in ((0, ends[0]), (size - 2, ends[1])):
            fixed += [node] * (end in ("hinged", "clamped")) + [node + 1] * (end in ("clamped", "guided"))
        free = np.setdiff1d(np.arange(size), fixed)
        mass, bent, push, hang, rest, bend = (m[np.ix_(free, free)] for m in (mass, bent, push, hang, rest, bend))
        still, driving = bent + rest - hang, push - bend
        shift = 1e-3 * np.trace(rest) / np.trace(mass) + 1.0
        _, vectors = eigh(bent + rest, mass, subset_by_index=[0, modes - 1])
        corrected = np.linalg.solve(
            bent + rest + shift * mass, np.hstack([driving, hang]) @ np.kron(np.eye(2), vectors[:, :_LOWEST])
        )
        basis = np.hstack([vectors, corrected / np.linalg.norm(corrected, axis=0)])
        sizes, directions = eigh(basis.T @ mass @ basis)
        kept = sizes > 1e-11 * sizes[-1]
        basis = basis @ (directions[:, kept] / np.sqrt(sizes[kept]))
        self.still, self.driving = (basis.T @ m @ basis for m in (still, driving))

    def critical(self) -> float:
        """Return the least mean force in N at which the stiffness turns singular."""
        values = np.linalg.eigvals(np.linalg.solve(self.still, self.driving)).real  # its own weight may buckle it
        return float(1.0 / values.max())

    def growth(self, mean: float, amplitude: float, frequency: float, damping: float) -> Growth:
        """Return the growth under mean + amplitude sin(frequency t), forces in N, rad/s and 1/s."""
        squares, turn = np.linalg.eigh(self.still - mean * self.driving)
        shaken = amplitude * turn.T @ self.driving @ turn
        steps = 24 + math.ceil(_STEPS * math.sqrt(abs(squares[-1])) / frequency)
        few, many = (self._rate(squares - damping**2, shaken, frequency, n) for n in (steps, 2 * steps))
        rate = many + (many - few) / 15.0
        return Growth(rate - damping, abs(many - few) / 15.0 + MARGIN * abs(rate))

    @staticmethod
    def _rate(squares: Floats, shaken: Floats, frequency: float, steps: int) -> float:
        """Return the rate of the fastest solution of q'' + (K - S sin(w t)) q = 0, by Magnus series of order four."""
        n, h = squares.size, 2.0 * math.pi / frequency / steps
        still = np.block([[np.zeros((n, n)), np.eye(n)], [-np.diag(squares), np.zeros((n, n))]])
        drive = np.zeros((2 * n, 2 * n))
        drive[n:, :n] = shaken
        whole = np.eye(2 * n)
        cross = still @ drive - drive @ still
        for k in range(steps):
            one, two = (math.sin(frequency * h * (k + 0.5 + s * math.sqrt(3.0) / 6.0)) for s in (-1.0, 1.0))
            whole = (
                expm(h * (still + 0.5 * (one + two) * drive) - math.sqrt(3.0) / 12.0 * h * h * (two - one) * cross)
                @ whole
            )
        largest: Any = np.abs(np.linalg.eigvals(whole)).max()
        return float(math.log(largest) * frequency / (2.0 * math.pi))
