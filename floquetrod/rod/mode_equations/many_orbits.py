"""Large orbits of one mode of a rod under many loads at once: from averages over a period, by Newton's method.

With the first harmonic of the vibration, f = Re(F e^(i w t)), motion a = Re(B e^(i s t)) of half that frequency,
s = w / 2, obeys on average (S(|B|) - s^2 + 2 i c s) B = F conj(B) / 2, S the stiffness at that size, J |B|^2 s^2 / 2
less by the inertia of shortening: a size for either sign of the root of |F|^2 / 4 - (2 c s)^2, and a phase (A. H.
Nayfeh and D. T. Mook, Nonlinear Oscillations, Wiley 1979, 5.7).  Motion of the frequency of the load itself has about
the size at which it is as fast, at a phase that is tried.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.rod.mode_equations.one_mode import LARGEST, LIMIT, Driven, OneMode, Orbit, derivative

_SIZES = np.linspace(0.003, 1.0, 48)  # squares of angles as parts of the largest's, between which sizes are found
_PHASES = 0.25 * math.pi * np.arange(4)  # tried for motion of the load's own frequency
_TOGETHER = 400  # starts in Newton's method: tens of megabytes
_FINER = 4  # instants to one of the equation, in steps of half of which deviations are followed


class ModeLoads(NamedTuple):
    """Loads as a mode feels them: mean forces in N, frequencies in rad/s (k,), and parts of the vibration (k, 2 H).

    Of the vibration what each part takes from the stiffness.
    """

    mean: Floats
    frequency: Floats
    vibration: Floats

    def some(self, kept: Any) -> ModeLoads:
        """Return some of them."""
        return ModeLoads(self.mean[kept], self.frequency[kept], self.vibration[kept])


def smallest_stable(equation: OneMode, loads: ModeLoads) -> list[Orbit | None]:
    """Return the smallest stable orbit but rest that is found under each load, of one period of it or two."""
    orbits: list[Orbit | None] = [None] * len(loads.mean)
    for turns in (2, 1):
        which, starts = _starts(equation, loads, turns)
        for first in range(0, len(which), _TOGETHER):
            some = slice(first, first + _TOGETHER)
            for k, orbit in _stable(equation, loads.some(which[some]), starts[some], turns):
                place = int(which[some][k])
                known = orbits[place]
                if known is None or orbit.amplitude < known.amplitude:
                    orbits[place] = orbit
    return orbits


def _added(equation: OneMode, loads: ModeLoads) -> Floats:
    """Return the stiffness due to the mean forces, (k, 1)."""
    per_newton = equation.motion.pushed_alike[0, 0]
    return np.asarray((equation.motion.load.mean - loads.mean)[:, None] * per_newton)


def _starts(equation: OneMode, loads: ModeLoads, turns: int) -> tuple[Any, Floats]:
    """Return which load each start is for, and the starts (m, count)."""
    s, c = loads.frequency / turns, equation.motion.rod.damping_rate
    half = loads.vibration.shape[1] // 2
    force = 0.5 * (loads.vibration[:, 0] - 1j * loads.vibration[:, half])
    gap = (_averaged(equation, s) + _added(equation, loads) - s[:, None] ** 2).T  # (sizes, loads)
    room = np.abs(force) ** 2 - (2.0 * c * s) ** 2
    wave = 2.0 * math.pi * np.arange(equation.instants(turns)) / equation.instants(turns)
    every = []
    roots = (np.sqrt(np.maximum(room, 0.0)), -np.sqrt(np.maximum(room, 0.0))) if turns == 2 else (np.zeros(len(s)),)
    for root in roots:
        over = gap - root
        at, which = np.nonzero((over[:-1] * over[1:] <= 0.0) & ((room > 0.0) | (turns == 1)))
        share = over[at, which] / (over[at, which] - over[at + 1, which] + 1e-300)
        size = np.sqrt(_SIZES[at] + share * (_SIZES[at + 1] - _SIZES[at])) * LARGEST / equation.peak
        own = 0.5 * np.angle(force[which] / (root[which] + 2j * c * s[which] + 1e-300))
        phases = [own] if turns == 2 else [own + phase for phase in _PHASES]
        every += [(which, size[:, None] * np.cos(wave + phase[:, None])) for phase in phases]
    return np.concatenate([which for which, _ in every]), np.concatenate([a for _, a in every])


def _averaged(equation: OneMode, s: Floats) -> Floats:
    """Return the average stiffness of harmonic motion of each size, less the inertia of shortening, (k, sizes)."""
    n = np.arange(len(equation.hardening))
    means = np.array([math.comb(2 * k + 2, k + 1) / 2.0 ** (2 * k + 1) for k in n.tolist()])
    stiff = np.polynomial.polynomial.polyval(_SIZES, equation.hardening * means)
    squares = _SIZES * (LARGEST / equation.peak) ** 2
    return np.asarray(stiff - 0.5 * equation.shortening * squares * s[:, None] ** 2)


def _stable(equation: OneMode, loads: ModeLoads, starts: Floats, turns: int) -> list[tuple[int, Orbit]]:
    """Return the stable orbits that starts lead to, and which of them."""
    count, half = starts.shape[1], loads.vibration.shape[1] // 2
    wave = turns * 2.0 * math.pi * np.arange(count * _FINER) / (count * _FINER)
    phases = np.multiply.outer(np.arange(1, half + 1), wave)
    parts = loads.vibration @ np.concatenate([np.cos(phases), np.sin(phases)])
    driven = Driven(loads.frequency[:, None] / turns, _added(equation, loads), parts[:, ::_FINER])
    a, of = equation.solved(starts, driven)
    if not len(a):
        return []
    size = np.abs(a).max(axis=1) * equation.peak
    fine = Driven(driven.rate[of], driven.added[of], parts[of])
    multipliers = _multipliers(equation, _refined(a), fine)
    v = driven.rate[of] * (a @ derivative(count).T)
    orbits = [
        Orbit(turns, np.stack([a[k], v[k]], axis=1), float(size[k]), multipliers[k])
        for k in range(len(a))
        if size[k] <= LIMIT
    ]
    places = of[size <= LIMIT].tolist()
    return [(place, orbit) for place, orbit in zip(places, orbits, strict=True) if orbit.is_stable]


def _refined(a: Floats) -> Floats:
    """Return motions (k, count) at more instants, by their Fourier series."""
    count = a.shape[1]
    return np.asarray(_FINER * np.fft.irfft(np.fft.rfft(a, axis=1), _FINER * count, axis=1))


def _multipliers(equation: OneMode, a: Floats, driven: Driven) -> Any:
    """Return the multipliers of deviations from motions (k, N), by Runge and Kutta in steps of two instants, (k, 2)."""
    waves = 1j * np.fft.rfftfreq(a.shape[1], 1.0 / a.shape[1])
    v, w = (driven.rate**n * np.fft.irfft(waves**n * np.fft.rfft(a, axis=1), a.shape[1], axis=1) for n in (1, 2))
    stiff = equation.stiffness(a) + driven.added - driven.force
    inertia, drag, slope = equation.beside(a, v, w, stiff)
    matrices = np.zeros((a.shape[1] + 1, len(a), 2, 2))
    matrices[:-1, :, 0, 1] = 1.0
    matrices[:-1, :, 1, 0], matrices[:-1, :, 1, 1] = -(slope / inertia).T, -(drag / inertia).T
    matrices[-1] = matrices[0]
    step = (4.0 * math.pi / a.shape[1] / driven.rate)[:, :, None]
    whole = np.broadcast_to(np.eye(2), (len(a), 2, 2))
    for i in range(0, a.shape[1], 2):
        begin, middle, end = matrices[i : i + 3]
        k1 = begin @ whole
        k2 = middle @ (whole + 0.5 * step * k1)
        k3 = middle @ (whole + 0.5 * step * k2)
        whole = whole + step / 6.0 * (k1 + 2.0 * (k2 + k3) + end @ (whole + step * k3))
    return np.linalg.eigvals(whole)
