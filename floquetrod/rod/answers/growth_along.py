"""How fast waves across a string grow while a tool shakes it, at each depth of a well."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats, Ints
from floquetrod.rod.model.data import RodData
from floquetrod.wells.drag import StringProperties, WellGeometry

_TONGUES = 2  # subharmonics whose waves are examined closely: those of a higher order hardly grow
_CLOSE = np.linspace(-1.0, 1.0, 25)  # of a tongue's width about its middle
_WIDE = np.linspace(0.02, 1.5, 60)  # of the wavenumber that resonates
_FEW = np.array([-0.3, 0.0, 0.3]), np.array([0.0, 1.0 / 6.0, 1.0 / 3.0])
"""The same for a first look: about the middles of the tongues of alpha sin tau, of width alpha and alpha^2."""
_FEW_WIDE = np.linspace(0.1, 1.5, 8)
_LOOKED_AT = 8  # places of a string at which the first look sees most growth


class GrowthAlongString(NamedTuple):
    """Fastest growth in 1/s at each place, and the half wave in m that grows so; both 0 where none does."""

    rate: Floats
    half_wave: Floats


def growth_along(
    rod: RodData, place: WellGeometry, force: Floats, amplitude: Floats, frequency: Any
) -> GrowthAlongString:
    """Return the fastest growth at places under a mean compression and a vibration in N, without friction across.

    After the rod's damping rate; what friction takes is given by `sliding.damping_across`.

    Of all wavelengths, as if force and well were the same around: the waves that grow are short against both.  A wave
    k obeys Mathieu's equation with m beta w^2 = -(E I k^4 - F k^2 + N / R) and m alpha w^2 = dF (k^2 - N' / R), N the
    contact force of the string that lies and N' its slope over F.  The frequency in rad/s is one or of each place.
    """
    none = np.zeros(force.size)
    rates, squares = _rates(rod, place, force, amplitude, frequency, none, (_CLOSE,) * _TONGUES, _WIDE)
    best = np.argmax(rates, axis=1)[:, None]
    rate = np.take_along_axis(rates, best, axis=1)[:, 0]
    wave = np.sqrt(np.take_along_axis(squares, best, axis=1)[:, 0])
    return GrowthAlongString(rate, np.where(rate > 0.0, math.pi / wave, 0.0))


def fastest_along(
    rod: RodData, place: WellGeometry, force: Floats, amplitude: Floats, frequency: Floats, lost: Floats, string: Ints
) -> Floats:
    """Return the growth rate less the rate ``lost`` in 1/s, near its largest value along each string, else 0.

    A few waves are examined wherever they may grow, all of them where these come nearest to growth.  Places of a
    string, whose numbers increase, lie side by side.
    """
    free = rod.replace(damping_rate=0.0)
    seen = _rates(free, place, force, amplitude, frequency, lost, _FEW, _FEW_WIDE)[0].max(axis=1) - lost
    order = np.lexsort((-seen, string))
    nearest = order[np.arange(string.size) - np.searchsorted(string, string) < _LOOKED_AT]
    there, fastest = WellGeometry(*(each[nearest] for each in place)), np.zeros(string.size)
    grows = growth_along(rod, there, force[nearest], amplitude[nearest], frequency[nearest])
    fastest[nearest] = np.maximum(grows.rate - lost[nearest], 0.0)
    return fastest


def _rates(
    rod: RodData,
    place: WellGeometry,
    force: Floats,
    amplitude: Floats,
    frequency: Any,
    least: Floats,
    close: tuple[Floats, ...],
    wide: Floats,
) -> tuple[Floats, Floats]:
    """Return the growth in 1/s of waves at places, and the squares of their wavenumbers, (n, m).

    Where it is no more than ``least`` of a place, a bound no more than that.  Of A'' = (beta + alpha sin tau) A it is
    abs(alpha) / (pi w), w^2 = -beta: (A'^2 + w^2 A^2)' is at most abs(alpha sin tau) / w times that in brackets.
    """
    from floquetrod.mathieu import growth_rate

    pipe = StringProperties(rod.flexural_rigidity, rod.weight_per_length, rod.radial_clearance)
    held = pipe.lying(force, place) / pipe.clearance
    slope = contact_slope(pipe, place, force) / pipe.clearance
    frequency = np.broadcast_to(frequency, force.shape)
    scale = rod.mass_per_length * frequency**2
    squares = _squares(pipe.rigidity, (force, held, slope, amplitude), scale, close, wide)
    columns = (each[:, None] for each in (force, held, slope, amplitude, scale, frequency))
    mean, hold, tilt, size, scale, frequency = columns
    beta = -(pipe.rigidity * squares**2 - mean * squares + hold) / scale
    alpha = size * (squares - tilt) / scale
    limits = (np.abs(alpha) < 1e6) & (np.abs(beta) < 1e6)
    damping = rod.damping_rate / frequency
    alpha, beta = np.where(limits, alpha, 0.0), np.where(limits, beta, -0.1)
    stiff = np.sqrt(np.maximum(-(beta + damping**2), 1e-300))
    rates = frequency * np.maximum(np.abs(alpha) / (math.pi * stiff) - damping, 0.0)
    some = rates > least[:, None]
    damping, frequency = (np.broadcast_to(each, rates.shape)[some] for each in (damping, frequency))
    rates[some] = frequency * growth_rate(alpha[some], beta[some], damping)
    return rates, squares


def contact_slope(pipe: StringProperties, place: WellGeometry, force: Floats) -> Floats:
    """Return the change of the contact force with the compression, in 1/m."""
    bent, side = pipe.weight * place.sine + force * place.kappa_n, force * place.kappa_b
    contact = np.hypot(bent, side)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(contact > 0.0, (bent * place.kappa_n + side * place.kappa_b) / contact, 0.0)


def _squares(rigidity: float, at: tuple[Floats, ...], scale: Floats, close: tuple[Floats, ...], wide: Floats) -> Floats:
    """Return the squares of wavenumbers to look at in 1/m^2, (n, m).

    ``at`` are the force, N / R, its slope and the amplitude; ``close`` are shares of the width of each tongue about its
    middle, and ``wide`` of the wavenumber that resonates.
    """
    force, held, slope, amplitude = at
    squares = []
    for order, shares in enumerate(close, start=1):
        middle = (0.5 * order) ** 2
        for sign in (1.0, -1.0):
            centre = resonant_squares(rigidity, force, held, middle * scale, sign)
            alpha = np.abs(amplitude * (centre - slope) / scale)
            width = np.minimum(alpha**order, 0.9 * middle)
            shifted = (middle + shares * width[:, None]) * scale[:, None]
            squares.append(resonant_squares(rigidity, force[:, None], held[:, None], shifted, sign))
    top = resonant_squares(rigidity, force, held, scale, 1.0)
    squares.append((wide * np.sqrt(top)[:, None]) ** 2)
    return np.concatenate(squares, axis=1)


def resonant_squares(rigidity: float, force: Floats, held: Floats, inertia: Any, sign: float) -> Floats:
    """Return the squares k^2 of waves whose stiffness E I k^4 - F k^2 + N / R is ``inertia``; some square for none."""
    under = np.maximum(force**2 - 4.0 * rigidity * (held - inertia), 0.0)
    smallest = 1e-3 * np.sqrt((np.abs(held) + np.abs(inertia)) / rigidity)
    return np.asarray(np.maximum((force + sign * np.sqrt(under)) / (2.0 * rigidity), smallest))
