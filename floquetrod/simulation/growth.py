"""The growth rate of a simulated rod from its recorded motion, by the recurrence that Floquet solutions obey."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats
from floquetrod.rod.loads.load import Load
from floquetrod.rod.rod import Rod
from floquetrod.simulation.model_error import model_errors
from floquetrod.simulation.recorded_motion import RecordedMotion
from floquetrod.simulation.start import SEGMENTS_TO_SEE

LEAST_PER_PERIOD = 8  # frames in a forcing period: interpolation between them costs the rate less than 1e-4
_LINEAR_UP_TO = (0.005, 0.01, 0.02, 0.05)  # rad; the one with the least error is taken (a choice)
_LEAST_PERIODS = 3
_LEAST_FRAMES = 9  # under a constant force, where every frame counts as a period
_MARGIN = 4  # frames at both ends to which an interpolated recurrence does not reach (heuristic)
_MOST_PAIRS = 6  # fitted (a choice)
_LEAST_ROWS = 6  # frames for each pair (a choice)
_LEAST_SHARE = 0.01  # of the motion that a pair must make up: the cube of a growing mode grows three times as fast
_ROUNDING = 1e-6  # of a frame, up to which a lag counts as whole frames
_SEEN = 0.01  # of the largest amplitude, above which a mode's growth is examined (a choice)
_TINY = 1e-300  # keeps 0 / 0 out
_MOST_NODES = 64  # whose motion is followed where modes are coupled (a choice)


class GrowthFit(NamedTuple):
    """The growth rate of a simulated motion, and its largest distance from the rate of the linear equations.

    Attributes
    ----------
    rate : float
        In 1/s, zero where nothing grows.
    start : float
        Time in s at which the fit begins.
    end : float
        Time in s up to which.
    fit_error : float
        Estimate in 1/s of the fit's part of the error, from its residual and the disagreement of its halves.
    model_error : float
        Estimate in 1/s, by theory, of the difference of the simulated rod from the linear equations by the segments,
        the floor indented by the weight, strain, large angles, and edges of sections and bores;
        `floquetrod.simulation.model_error`.
    """

    rate: float
    start: float
    end: float
    fit_error: float
    model_error: float

    @property
    def error(self) -> float:
        """Both errors together in 1/s, an estimate of the distance from the linear equations with axial waves."""
        return self.fit_error + self.model_error

    def __repr__(self) -> str:
        """Return, say, "4.22 +- 0.0003 1/s between 0 s and 1.2 s"."""
        return f"{self.rate:.6g} +- {self.error:.1g} 1/s between {self.start:.3g} s and {self.end:.3g} s"


def growth_of_motion(
    motion: RecordedMotion,
    rod: Rod,
    load: Load,
    mode: int | None,
    duration: float,
    frames: int,
    indentation: float,
    lifted: float = 0.0,
) -> GrowthFit:
    """Return the growth rate of a recorded motion while it is linear: of a mode or, with None, of the whole rod.

    Of the whole rod it is the rate of its nodes together where modes are coupled; where they are independent, the
    fastest of all modes that hold at least a hundredth of the largest amplitude in the end.
    ``duration`` in s and ``frames`` belong to the whole run.  Raises ValueError where there are fewer than
    three periods of linear motion, or fewer than 8 frames in each.  ``lifted`` is the part of the rod that rests off
    the wall.
    """
    step = duration / (frames - 1)
    vibrates = load.amplitude > 0.0
    period = 2.0 * math.pi / load.frequency if vibrates else step
    if vibrates and period < LEAST_PER_PERIOD * step:
        needed = math.ceil(LEAST_PER_PERIOD * duration / period) + 1
        raise ValueError(f"growth_rate needs {LEAST_PER_PERIOD} frames a forcing period: ask for {needed} frames")
    sizes = motion.largest_angle
    longest = _frames_up_to(_LINEAR_UP_TO[-1], sizes)
    nodes = motion.positions.shape[1]
    apart = rod._modes_under(load).modes_apart(range(1, (nodes - 1) // SEGMENTS_TO_SEE + 1)) if mode is None else ()
    if apart:
        last_quarter = slice(longest - math.ceil(longest / 4), longest)
        amplitudes = motion.mode_amplitudes(apart)[last_quarter]
        power = np.sum(amplitudes**2, axis=0)
        seen = np.flatnonzero(power >= _SEEN**2 * power.max())
        every = [growth_of_motion(motion, rod, load, apart[m], duration, frames, indentation) for m in seen]
        return max(every, key=lambda fit: fit.rate)
    segment = rod.length / (nodes - 1)
    if mode is None and longest > 0:
        amplitudes = motion.angle[:, :: math.ceil(nodes / _MOST_NODES)]
        largest = int(np.argmax(np.sum(motion.angle[:longest] ** 2, axis=1)))
        # Of the shape theta(s): k^2 = sum theta''^2 / sum theta'^2.
        shape = motion.positions[largest, :, 1] if rod.varies else motion.angle[largest]
        slopes = np.diff(shape) / segment
        bends = np.diff(slopes) / segment
        wavenumber = math.sqrt(float(np.sum(bends**2) / max(float(np.sum(slopes**2)), _TINY)))
    else:
        mode = 1 if mode is None else mode
        amplitudes, wavenumber = motion.mode_amplitudes([mode]), mode * math.pi / rod.length
    # Motion below each of these angles is fitted: more frames lower the error of a fit, small angles that of linearity.
    least = _LEAST_PERIODS * period / step if vibrates else _LEAST_FRAMES - 1
    counts = {_frames_up_to(angle, sizes) for angle in _LINEAR_UP_TO}
    fits = {
        count: fit_growth(motion.time[:count], amplitudes[:count], period, rod.damping_rate)
        for count in counts
        if count - 1 >= least
    }
    fits = {count: fit for count, fit in fits.items() if math.isfinite(fit.fit_error)}
    if not fits:
        have = f"{max(0, longest - 1) * step / period:.2g}" if vibrates else f"{longest} frames"
        raise ValueError(
            f"growth_rate needs three forcing periods, and some frames, of motion below {_LINEAR_UP_TO[-1]:g} rad, "
            f"{_LEAST_FRAMES} frames where the force is constant, got {have}; simulate longer, or from a smaller "
            "perturbation"
        )
    # The fit counts whose error is least in all, the error of the model at its largest angle included.
    fastest = max(fit.rate for fit in fits.values())
    errors = model_errors(rod, load, mode, wavenumber, segment, indentation, fastest, lifted)
    with_errors = [fit._replace(model_error=errors.up_to(float(sizes[:count].max()))) for count, fit in fits.items()]
    return min(with_errors, key=lambda fit: fit.error)


def fit_growth(time: Floats, amplitudes: Floats, period: float, damping_rate: float) -> GrowthFit:
    """Return the growth rate of motion sampled at equal times, (frames,) or (frames, amplitudes).

    The multipliers of a Floquet system of ``period`` T, damped in proportion to its mass at a ``damping_rate`` c, come
    in pairs z, 1 / z once its decay is removed, B(t) = e^(c t) A(t).  With Y B(t) = B(t + n T) + B(t - n T)
    and any n, a pair obeys Y B = D B, D = z^n + z^-n, whatever the phase.  Of the functions B, Y B, ..., Y^(p-1) B,
    all amplitudes with the same factors, those mixtures are found that Y multiplies by numbers, in the least-squares
    sense: p pairs, which may be complex.  The rate follows from the largest z.  n is as large as p allows, which
    separates growth from what stays bounded.  Of p = 1 to 6 the one with the least error is taken.

    The error is what the residual allows, and the disagreement of two halves of equal weight.  Motion must show what
    grows: a solution still hidden under others at the end is not seen, and the slower of two solutions
    excited alike must have fallen behind.
    """
    motion = np.reshape(amplitudes, (time.size, -1)) * np.exp(damping_rate * (time - time[-1]))[:, None]
    in_frames = period / float(time[1] - time[0])
    tried = [_fastest_pair(motion, in_frames, pairs) for pairs in range(1, _MOST_PAIRS + 1)]
    best = min((pair for pair in tried if pair is not None), key=lambda pair: pair.error, default=_Pair(0.0, math.inf))
    rate = best.growth / period - damping_rate
    error = max(0.0, best.error / period + min(0.0, rate))  # what decays is said to grow at the rate zero
    return GrowthFit(max(0.0, rate), float(time[0]), float(time[-1]), error, 0.0)


class _Pair(NamedTuple):
    """A pair of multipliers: its growth in a period, without damping, and the error of that."""

    growth: float
    error: float


def _fastest_pair(motion: Floats, period: float, pairs: int) -> _Pair | None:
    """Return the fastest of so many pairs in motion (frames, amplitudes) of a period in frames; None for too few."""
    lag = max(1, math.floor((len(motion) - 1) / period / (2 * pairs + 1) + _ROUNDING))
    powers = _powers(motion, lag * period, pairs)
    frames = len(powers)
    if frames < _LEAST_ROWS * pairs:
        return None
    size = np.linalg.norm(powers[..., :-1], axis=(0, 1)) + _TINY
    functions, images = powers[..., :-1] / size, powers[..., 1:] / size
    roots, mixtures = _eigen(functions, images)
    mixed = functions @ mixtures
    norms = np.linalg.norm(mixed, axis=(0, 1))
    # B is the sum of the mixtures with these factors.
    shares = np.abs(np.linalg.pinv(mixtures)[:, 0]) * norms
    growths = np.where(shares >= _LEAST_SHARE, _growths(roots), -1.0)
    place = int(growths.argmax())
    root, growth = roots[place], float(growths[place])
    # As far as Y is from multiplying the mixture by D, D may be from a number by which it does.
    left = float(np.linalg.norm(images @ mixtures[:, place] - root * mixed[..., place]))
    shift = left / max(float(norms[place]), _TINY)
    allowed = float(np.abs(_growths(root + shift * np.array([1.0, -1.0, 1j, -1j])) - growth).max())
    weight = np.cumsum(np.sum(powers[..., 0] ** 2, axis=1))
    middle = int(np.clip(np.searchsorted(weight, 0.5 * weight[-1]), frames // 4, frames - frames // 4))
    first, second = (
        float(_growths(_eigen(functions[half], images[half])[0]).max()) for half in (slice(middle), slice(middle, None))
    )
    return _Pair(growth / lag, (allowed + abs(first - second)) / lag)


def _eigen(functions: Floats, images: Floats) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Return numbers D and mixtures of functions (..., k) that their images come closest to multiplying by D."""
    k = functions.shape[-1]
    matrix = np.linalg.lstsq(functions.reshape(-1, k), images.reshape(-1, k), rcond=None)[0]
    values, vectors = np.linalg.eig(matrix)
    return values.astype(complex), vectors.astype(complex)


def _powers(motion: Floats, lag: float, pairs: int) -> Floats:
    """Return Y^k B, k = 0 to ``pairs``, at the frames it reaches, (frames, amplitudes, powers); the lag in frames."""
    from scipy.interpolate import make_interp_spline

    lags, last = pairs * lag, len(motion) - 1
    is_integer = abs(lag - round(lag)) < _ROUNDING
    # The ends of an interpolating spline are its worst part.
    margin = 0 if is_integer else _MARGIN
    places = np.arange(math.ceil(lags - _ROUNDING) + margin, math.floor(last - lags + _ROUNDING) - margin + 1)
    if is_integer or not places.size:
        shifted = [motion[places + k * round(lag)] for k in range(-pairs, pairs + 1)]
    else:
        curve = make_interp_spline(np.arange(last + 1), motion, k=7)
        shifted = [curve(places + k * lag) for k in range(-pairs, pairs + 1)]
    powers = np.zeros((len(places), motion.shape[1], pairs + 1))
    for k in range(pairs + 1):
        for j in range(k + 1):
            powers[..., k] += math.comb(k, j) * shifted[pairs + k - 2 * j]
    return powers


def _growths(roots: Any) -> Floats:
    """Return log of the larger abs(z) with z + 1 / z = D, for every D."""
    return np.asarray(np.abs(np.arccosh(0.5 * roots).real))


def _frames_up_to(angle: float, sizes: Floats) -> int:
    """Return how many frames come before the first with a larger angle."""
    beyond = np.flatnonzero(sizes > angle)
    return int(beyond[0]) if beyond.size else sizes.size
