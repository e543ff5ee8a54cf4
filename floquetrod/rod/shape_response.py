"""How much a rod that is not straight moves while it is stable: its periodic motion under a load, and maps of it."""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arguments import Mention, wrong_value
from floquetrod._util.arrays import Bools, Complexes, Floats, Ints
from floquetrod._util.progress import Progress
from floquetrod.floquet.dispatch import stability
from floquetrod.responses.many import scalar_responses
from floquetrod.rod.answers.rod_response import RodResponse
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import AnyLoad, Load, Loads, LoadSource, require_load, require_one_sine
from floquetrod.rod.mode_equations.coupled_matrices import CoupledModes
from floquetrod.rod.mode_equations.forced_modes import ForcedModes, are_independent, is_driven, shape_force
from floquetrod.rod.mode_equations.modal_systems import ModalSystem
from floquetrod.rod.model.contact import constants_under
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.natural_shape import NaturalShape
from floquetrod.rod.modes.mode_model import ModeModel

_HALF_WAVES = 6.0, 3.0  # critical modes, for one load and for maps: what a bend drives falls like n^-5 (a choice)
_MORE = 12  # modes besides (a choice)
_FEWER = 0.8  # part of the modes of the second answer, with which the first is compared (a choice)
_MOST_COUPLED = 250  # functions: Hill's matrix of more takes minutes
_TURNS = 16  # instants for every harmonic that matters
_RESONANT = 0.1  # error of the motion, as a fraction of it, from which there is no answer (a choice)
_MATTERS = 1e-12  # part of the largest amplitude up to which a harmonic does not


class Field(NamedTuple):
    """Values that vary along a rod and in a period: amplitudes (patterns, 2 K + 1, p), one pattern or independent."""

    series: Complexes

    @property
    def trimmed(self) -> Complexes:
        """The series without harmonics that do not matter."""
        sizes = np.abs(self.series).max(axis=(0, 2))
        middle = len(sizes) // 2
        orders = np.flatnonzero(sizes > _MATTERS * sizes.max(initial=0.0))
        last = int(np.abs(orders - middle).max(initial=0))
        return np.asarray(self.series[:, middle - last : middle + last + 1])

    def on_grid(self) -> tuple[Floats, Floats]:
        """Return angles w t, (q,), and values (q, p): of several patterns the root of the sum of squares."""
        series = self.trimmed
        last = series.shape[1] // 2
        angles = 2.0 * math.pi * np.arange(_TURNS * (last + 1)) / (_TURNS * (last + 1))
        waves = np.exp(1j * angles[:, None] * _orders(series.shape[1]))
        if len(series) == 1:
            return angles, (waves @ series[0]).real
        squares = np.zeros((len(angles), series.shape[2]))
        for pattern in series:
            squares += (waves @ pattern).real ** 2
        return angles, np.sqrt(squares)

    def largest(self, x: Floats) -> tuple[float, int, float]:
        """Return the largest magnitude, the index of the node of the nodes ``x`` next to it, and its angle w t.

        Of one pattern between nodes and instants too: by Newton's method in time, and a polynomial through five nodes.
        """
        angles, values = self.on_grid()
        when, where = np.unravel_index(int(np.argmax(np.abs(values))), values.shape)
        size, angle = float(abs(values[when, where])), float(angles[when])
        if len(self.series) > 1 or size == 0.0:
            return size, int(where), angle
        size, angle = _peak(self.series[0, :, where], angle)
        near = slice(max(0, int(where) - 2), int(where) + 3)
        heights = np.abs((np.exp(1j * _orders(self.series.shape[1]) * angle) @ self.series[0, :, near]).real)
        middle, width = 0.5 * (x[near][0] + x[near][-1]), 0.5 * float(np.ptp(x[near]))
        fine = np.linspace(-1.0, 1.0, 201)
        inner = fine[np.abs(fine - (x[where] - middle) / width) <= 0.6]
        curve = np.polynomial.Polynomial.fit((x[near] - middle) / width, heights, len(heights) - 1)
        return max(size, float(curve(inner).max(initial=0.0))), int(where), angle


def response(
    model: ModeModel, given: AnyLoad, unstable: bool = False, verdict: RodStability | None = None
) -> RodResponse:
    """Return the motion under a load that the natural shape causes; see `floquetrod.Rod.response`.

    A verdict under the load that is known is not computed again.
    """
    load, rod = require_load("load", given), model.rod
    shape = require_shape(rod)
    _require_sines(given, load)
    verdict = model.verdict(load, None, 0.0, None) if verdict is None else verdict
    if verdict.status == "unstable" and not validate.flag("unstable", unstable):
        raise wrong_value(
            "load",
            f"must leave the rod stable: its motion grows at {verdict.growth_rate:.4g} 1/s whatever its shape; the "
            "motion with the period of the load, which nobody sees, is answered with unstable=True",
        )
    count = _modes_for(model, load, shape)
    modes = _modes_of(rod, load, count)
    motion = ForcedModes.of(modes, load, shape)
    distance = _distance(motion, load, verdict)
    if not motion.error < _RESONANT:
        raise wrong_value(
            "load",
            f"is on a resonance of the rod's shape: 1 is {distance:.3g} from the nearest multiplier, and the error of "
            f"the motion is {motion.error:.2g} of it; change the load, or give the rod a ",
            Mention("damping_rate"),
        )
    largest, where, when = _largest(motion)
    error = motion.error * largest
    if not (are_independent(modes) and shape.sines):
        fewer = _modes_of(rod, load, max(2, math.floor(_FEWER * count)))
        error += abs(_largest(ForcedModes.of(fewer, load, shape))[0] - largest) / (1.0 - _FEWER)
    nodes = modes.basis.nodes
    along = rod.along(nodes)
    bending = Field(motion.bending() / rod.length**2)
    moment = Field(bending.series * along.rigidity).largest(nodes)[0]
    stress, stressed_at, _ = Field(bending.series * along.fibre).largest(nodes)
    series = motion.along(modes.basis.values, shape.patterns(nodes, rod.length).deflection)
    angle = largest / rod.radial_clearance if not rod.varies else Field(series / along.clearance).largest(nodes)[0]
    return RodResponse(
        rod, load, verdict.status, largest, where * rod.length, when / load.frequency, error, angle, moment, stress,
        float(nodes[stressed_at]) * rod.length, _contact(motion, load, series), distance, nodes * rod.length,
        Field(series).trimmed, modes.size,
    )  # fmt: skip


def require_shape(rod: RodData) -> NaturalShape:
    """Return the natural shape of a rod; ValueError without one."""
    if rod.natural_shape is None:
        raise wrong_value(
            "natural_shape",
            "must be given for a response: a straight rod that is stable stays at rest; "
            'rod.replace(natural_shape={5: "0.1mm"}), say',
        )
    return rod.natural_shape


def _require_sines(given: AnyLoad, load: Load) -> None:
    """Raise ValueError for noise, which a periodic motion leaves out."""
    require_one_sine(load, "large motion")
    if load.noise or isinstance(given, LoadSource):
        raise wrong_value("load", "must be periodic without noise for a response; give an AxialLoad or an AxialWave")


def _modes_for(model: ModeModel, load: Load, shape: NaturalShape, *, quickly: bool = False) -> int:
    """Return how many modes to take: of independent ones those the shape drives, else enough for what follows it."""
    highest = shape.highest(model.rod.length)
    if model.prompt and shape.sines:
        return highest
    critical = math.ceil(_HALF_WAVES[quickly] * model.rod.critical_mode)
    if model.prompt:
        return max(critical, highest) + _MORE
    needed, _ = model.modes_needed(load, 0.0)
    count = max(needed, math.ceil(1.5 * highest) + _MORE)
    if count > _MOST_COUPLED:
        raise wrong_value(
            "rod",
            f"needs {count} coupled modes for its response, more than {_MOST_COUPLED}; ask for a shorter part of it",
        )
    return count


def _modes_of(rod: RodData, load: Load, count: int) -> CoupledModes:
    """Return so many modes, independent ones with the constants of the side of the channel on which the rod lies."""
    modes = CoupledModes.of(rod, load, count)
    return replace(modes, constants=constants_under(rod, load.mean)) if are_independent(modes) else modes


def _distance(motion: ForcedModes, load: Load, verdict: Any) -> float:
    """Return the distance of 1 from the nearest multiplier of the modes that move."""
    if are_independent(motion.modes):
        numbers = tuple((np.flatnonzero(is_driven(motion.straight)) + 1).tolist())
        equations = ModalSystem(motion.modes.constants, load, numbers).equations
        distances = (min(abs(1.0 - m) for m in stability(equation).multipliers) for equation in equations)
        return min(distances, default=math.inf)
    period = 2.0 * math.pi / load.frequency
    return float(min(abs(1.0 - np.exp(complex(e) * period)) for e in verdict.exponents))


def _largest(motion: ForcedModes) -> tuple[float, float, float]:
    """Return the largest deflection in m, with its place x = s / L and its angle w t, refined between the nodes."""
    nodes = motion.modes.basis.nodes
    values = motion.along(motion.modes.basis.values, motion.shape.patterns(nodes, motion.modes.rod.length).deflection)
    largest, where, angle = Field(values).largest(nodes)
    if len(values) > 1 or largest == 0.0:
        return largest, float(nodes[where]), angle
    from scipy.optimize import minimize_scalar

    def height(x: float) -> float:
        """Return the largest deflection at a place next to the angle, with the other sign."""
        return -_peak(motion.deflection(np.array([x]))[0, :, 0], angle)[0]

    low, high = (float(nodes[min(max(where + step, 0), len(nodes) - 1)]) for step in (-1, 1))
    low, high = (0.0 if where == 0 else low), (1.0 if where == len(nodes) - 1 else high)
    best = minimize_scalar(height, bounds=(low, high), method="bounded", options={"xatol": 1e-10})
    places = (float(best.x), float(nodes[where]))
    peaks = [_peak(motion.deflection(np.array([place]))[0, :, 0], angle) for place in places]
    highest = int(peaks[1][0] > peaks[0][0])
    return peaks[highest][0], places[highest], peaks[highest][1] % (2.0 * math.pi)


def _peak(series: Complexes, angle: float) -> tuple[float, float]:
    """Return the extreme of a real series next to an angle, by Newton's method, and where it is."""
    orders = _orders(len(series))
    step = 2.0 * math.pi / (_TURNS * (1 + len(series) // 2))
    at = angle
    for _ in range(6):
        waves = series * np.exp(1j * orders * at)
        slope, bend = float((1j * orders * waves).sum().real), float((-(orders**2) * waves).sum().real)
        if bend == 0.0:
            break
        at = min(max(at - slope / bend, angle - 2.0 * step), angle + 2.0 * step)
    ends = (angle, at)
    heights = [abs(float((series * np.exp(1j * orders * each)).sum().real)) for each in ends]
    best = int(heights[1] >= heights[0])
    return heights[best], ends[best]


def _contact(motion: ForcedModes, load: Load, series: Complexes) -> tuple[float, float] | None:
    """Return the least and the largest contact force in N/m along the rod over a period.

    With theta = y / R, w_n the weight across and F the compression, to second order in the angle

        N = w_n cos(theta) + m R theta_t^2 + F R theta_s^2 + E I R (3 theta_ss^2 + 4 theta_s theta_sss - theta_s^4)
            + E I y_0'''' sin(theta) .
    """
    modes, rod, shape = motion.modes, motion.modes.rod, motion.shape
    if len(series) > 1 or not rod.course.is_straight:
        return None
    basis, length = modes.basis, rod.length
    nodes, along, points = basis.nodes, rod.along(basis.nodes), basis.points_per_panel
    patterns = shape.patterns(nodes, length)
    angles, y = Field(series).on_grid()
    last = Field(series).trimmed.shape[1] // 2
    waves = np.exp(1j * angles[:, None] * _orders(2 * last + 1))
    kept = slice(motion.middle - last, motion.middle + last + 1)

    def over_time(amplitudes: Complexes) -> Floats:
        return np.asarray((waves @ amplitudes[0, kept]).real)

    speed = over_time(1j * _orders(series.shape[1])[:, None] * load.frequency * series)
    first = over_time(motion.along(basis.slopes, patterns.slope)) / length
    second = over_time(motion.along(basis.bends, patterns.bend)) / length**2
    third = _along_panels(second, nodes * length, points)
    straight = patterns.bend / length**2
    for _ in range(2):
        straight = _along_panels(straight, nodes * length, points)
    gap, theta = along.clearance, y / along.clearance
    bent = 3.0 * second**2 + 4.0 * first * third - first**4 / gap**2
    pressing = (
        along.weight * math.sin(rod.inclination) * np.cos(theta)
        + along.inertia * speed**2 / gap
        + _force_at(modes, load, angles) * first**2 / gap
        + along.rigidity * (bent / gap + straight[0] * np.sin(theta))
    )
    return float(pressing.min()), float(pressing.max())


def _orders(count: int) -> Floats:
    """Return the numbers k of 2 K + 1 harmonics, from -K to K."""
    return np.asarray(np.arange(count) - float(count // 2))


def _along_panels(values: Floats, x: Floats, points: int) -> Floats:
    """Return the derivative along x of values (..., p) at the nodes of a quadrature with so many in each panel."""
    derived = np.empty_like(values)
    for start in range(0, len(x), points):
        panel = slice(start, start + points)
        apart = x[panel, None] - x[None, panel]
        np.fill_diagonal(apart, 1.0)
        # Barycentric differentiation; sizes by logarithms, since products of many distances leave the range of doubles.
        sizes, signs = np.log(np.abs(apart)).sum(axis=1), np.prod(np.sign(apart), axis=1)
        matrix = np.exp(sizes[:, None] - sizes[None, :]) * signs[:, None] * signs[None, :] / apart
        np.fill_diagonal(matrix, 0.0)
        np.fill_diagonal(matrix, -matrix.sum(axis=1))
        derived[..., panel] = values[..., panel] @ matrix.T
    return derived


def _force_at(modes: CoupledModes, load: Load, angles: Floats) -> Floats:
    """Return the compression in N at the nodes at instants, (q, p)."""
    from floquetrod.rod.loads import axial

    rod, nodes = modes.rod, modes.basis.nodes
    every = axial.along(load, rod.axial_line, nodes * rod.length, load.frequency)
    force = np.broadcast_to(load.mean + modes._added, (len(angles), len(nodes))).copy()
    for k, wave in enumerate(every, start=1):
        force += load.amplitude * (np.exp(1j * k * angles)[:, None] * wave).real
    return force


# --- maps ---

_AT_ONCE = 1 << 19  # numbers held at once, of all modes and about 64 harmonics
_SEEN, _HIGH = 3e-4, 3e-2  # part of the largest amplitude from which a wave is followed, and closely
_PER_WAVE = 32  # instants and places in the shortest wave that is followed closely: sizes are 0.5 % low at most


def responses(
    model: ModeModel, loads: Loads, stable: Bools, progress: Progress | None, workers: int | None = None
) -> Floats:
    """Return the largest deflection in m under loads, to half a percent: NaN where the rod is not stable.

    Of a random shape the largest standard deviation.  Independent modes together, coupled ones load by load.
    """
    shape = require_shape(model.rod)
    sizes = np.full(loads.size, np.nan)
    wanted = np.flatnonzero(stable.ravel())
    if not model.prompt:
        for done, i in enumerate(wanted.tolist(), start=1):
            load = model.template.with_numbers(*(float(values[i]) for values in loads.flat))
            motion = ForcedModes.of(_modes_of(model.rod, load, _modes_for(model, load, shape)), load, shape)
            sizes[i] = _largest(motion)[0] if motion.error < _RESONANT else math.nan
            if progress is not None:
                progress(done, len(wanted))
        return sizes.reshape(loads.shape)
    modes = CoupledModes.of(model.rod, model.template, _modes_for(model, model.template, shape, quickly=True))
    _, straight = shape_force(modes, shape)
    driven = np.flatnonzero(is_driven(straight))
    block = max(1, _AT_ONCE // (64 * max(1, len(driven))))
    for first in range(0, len(wanted), block):
        part = wanted[first : first + block]
        for at, constants, some in model.on_sides(loads.some(part)):
            sizes[part[at]] = _largest_under(
                replace(modes, constants=constants), shape, some, driven + 1, straight[:, driven], workers
            )
        if progress is not None:
            progress(min(first + block, len(wanted)), len(wanted))
    return sizes.reshape(loads.shape)


def _largest_under(
    modes: CoupledModes, shape: NaturalShape, loads: Loads, numbers: Ints, straight: Floats, workers: int | None
) -> Floats:
    """Return the largest deflection in m under some loads of independent modes, by their numbers of half waves."""
    # q'' + 2 c q' + (c1 m^4 - c2 (m^2 - m_0^2) F(t) + Omega^2) q = c1 m^4 a, for a = 1: amplitudes (loads, 2 K + 1, n).
    c, m = modes.constants, numbers.astype(float)
    mean, amplitude, frequency = loads.flat
    count, n = loads.size, len(m)
    softened = c.per_newton * (m**2 - c.neutral_squared)
    stiffness = (c.bending * m**4 + c.restoring) - mean[:, None] * softened
    waves = (amplitude[:, None] * softened)[..., None] * modes.template.harmonics
    force, omega = np.tile(c.bending * m**4, count), np.repeat(frequency, n)
    every = scalar_responses(-stiffness.ravel(), waves.reshape(count * n, -1), c.damping_rate, omega, force, workers)
    unit = np.moveaxis(every.amplitudes[..., 0].reshape(count, n, -1), 1, 2)
    unit = np.where(every.error.reshape(count, 1, n) < _RESONANT, unit, np.nan)
    return np.array([_largest_of(each, m, straight, shape, modes.rod.length) for each in unit])


def _largest_of(unit: Complexes, m: Floats, straight: Floats, shape: NaturalShape, length: float) -> float:
    """Return the largest deflection in m of sum_m a_m unit_m(t) phi_m, unit (2 K + 1, n), a = straight (patterns, n).

    It is y_0 + sum_m a_m (unit_m(t) - 1) phi_m, whose terms fall like m^-5.
    Small waves are left out, and waves of middle size followed at fewer instants and places.
    """
    factors, middle = np.abs(straight).max(axis=0), len(unit) // 2
    whole = float((np.abs(unit) * factors).max(initial=0.0))
    if not whole < math.inf:
        return math.nan
    unit = unit.copy()
    unit[middle] -= 1.0
    orders, sizes = np.abs(np.arange(len(unit)) - middle), np.abs(unit) * factors
    seen, high = sizes > _SEEN * whole, sizes > _HIGH * whole
    last, fine = (int(orders[each.any(axis=1)].max(initial=0)) for each in (seen, high))
    among, tall = seen.any(axis=0), high.any(axis=0)
    unit, straight = unit[middle - last : middle + last + 1, among], straight[:, among]
    instants = max(_PER_WAVE * fine, _PER_WAVE // 4 * last, 1)
    angles = np.arange(instants) * (2.0 * math.pi / instants)
    moving = (np.exp(1j * angles[:, None] * _orders(2 * last + 1)) @ unit).real  # (q, n)
    half_waves = max(_PER_WAVE / 2 * m[tall].max(initial=1.0), _PER_WAVE / 8 * m[among].max(initial=1.0))
    m = m[among]
    places = 1 if len(shape.sines) == 1 else int(half_waves) + 1
    base, functions = _at_places(shape, length, places, tuple(m.tolist()))
    squares: Any = 0.0
    for pattern, rest in zip(straight, base, strict=True):
        squares = squares + (rest + (moving * pattern) @ functions) ** 2
    return math.sqrt(float(np.max(squares)))


@functools.lru_cache(maxsize=256)
def _at_places(shape: NaturalShape, length: float, places: int, numbers: tuple[float, ...]) -> tuple[Floats, Floats]:
    """Return a shape and functions at so many equal distances along a rod; at one alone, where the first is largest."""
    x = np.linspace(0.0, 1.0, places) if places > 1 else np.array([0.5 / numbers[0]])
    functions = math.sqrt(2.0) * np.sin(math.pi * np.array(numbers)[:, None] * x)
    return shape.patterns(x, length).deflection, functions
