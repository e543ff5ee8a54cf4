"""Axial waves along strings of sections: force, resonances, what is refused next to them, and verdicts."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import brentq

import floquetrod as fr
from floquetrod.rod.loads import axial
from floquetrod.rod.loads.axial_line import AxialLine, LinePiece
from tests.conftest import depth
from tests.inside import FAR_ENDS, Load, with_waves
from tests.seams import Tuned

STRING = fr.Rod(
    sections=[
        fr.Section("2.00x0.156 CT90", length="20m"),
        fr.Section("2.00x0.203 CT90", length="25m"),
        fr.Section(diameter="2.875in", inner_diameter="1in", length="15m"),
    ],
    channel_radius="3.092in",
    fluid_inside=1000.0,
    fluid_outside=1000.0,
)


def drawn_line(rng: np.random.Generator, most: int = 6) -> AxialLine:
    """Return a line of two to six pieces of several materials and cross-sections."""
    pieces = [
        LinePiece(*(float(rng.uniform(*span)) for span in ((2.0, 60.0), (3000.0, 5500.0), (1.0, 12.0))))
        for _ in range(int(rng.integers(2, most + 1)))
    ]
    return AxialLine(tuple(pieces))


def equal_pieces(lengths: np.ndarray, wave_speed: float) -> AxialLine:
    """Return a uniform line as several pieces, which differ by rounding alone so that they stay apart."""
    pair = itertools.cycle((1.0, math.nextafter(1.0, 2.0)))
    return AxialLine(tuple(LinePiece(float(length), wave_speed, next(pair)) for length in lengths))


def wave(far_end: str, frequency: float = 1.0, damping: float = 0.0, **others: Any) -> fr.AxialWave:
    return fr.AxialWave(0.0, 10.0, frequency, far_end=far_end, axial_damping=damping, **others)


def integrated(line: AxialLine, load: fr.AxialWave, frequency: float, s: np.ndarray) -> np.ndarray:
    """Return the force along a line by Runge and Kutta: E A u' = -P, P' = rho A (omega^2 - 2 i c_a omega) u.

    In scaled units, from the driven end down, for P = 1, u = 0 there and for P = 0, u = 1; together as the far end is.
    """
    inertia = complex(frequency**2, -2.0 * load.axial_damping * frequency)
    state, found = np.array([1.0, 0.0, 0.0, 1.0], dtype=complex), np.empty((2, s.size), dtype=complex)
    scale = line.pieces[0].impedance * frequency  # of displacement: u stands for u times it
    at = 0.0
    for piece in line.pieces:
        end = at + piece.length
        inside = np.flatnonzero((s >= at) & (s <= end))
        rigidity, mass = piece.impedance * piece.wave_speed, piece.impedance / piece.wave_speed

        def slope(_: float, y: np.ndarray, rigidity: float = rigidity, mass: float = mass) -> np.ndarray:
            force, moved = y[::2], y[1::2] / scale
            return np.stack([mass * inertia * moved, -force / rigidity * scale], axis=1).ravel()

        places = np.unique(np.append(s[inside], end))
        run = solve_ivp(slope, (at, end), state, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=places)
        state = run.y[:, -1]
        found[:, inside] = run.y[::2, : inside.size]
        at = end
    if load.far_end == "held":
        share = -state[1] / state[3]
    else:
        share = ((1.0 if load.far_end == "driven" else 0.0) - state[0]) / state[2]
    return np.asarray(found[0] + share * found[1])


def growth_by_finite_elements(rod: fr.Rod, load: Load, elements: int, modes: int) -> float:
    """Return the growth rate in 1/s of a horizontal rod with hinged ends: Hermite's cubics, their modes, DOP853."""
    cuts = [0.0]
    for part in rod.uniform_parts:
        number = max(2, round(elements * (part.end - part.start) / rod.length))
        cuts += np.linspace(part.start, part.end, number + 1)[1:].tolist()
    points, weights = np.polynomial.legendre.leggauss(6)
    t = 0.5 * (points + 1.0)
    value = np.array([1 - 3 * t**2 + 2 * t**3, t - 2 * t**2 + t**3, 3 * t**2 - 2 * t**3, t**3 - t**2])
    slope = np.array([6 * t**2 - 6 * t, 1 - 4 * t + 3 * t**2, 6 * t - 6 * t**2, 3 * t**2 - 2 * t])
    curvature = np.array([12 * t - 6, 6 * t - 4, 6 - 12 * t, 6 * t - 2])
    size = 2 * len(cuts)
    mass, stiff, push = (np.zeros((size, size)) for _ in range(3))
    cosines, sines = (np.zeros((len(load.harmonics), size, size)) for _ in range(2))
    for i, (start, end) in enumerate(itertools.pairwise(cuts)):
        h, s = end - start, start + (end - start) * t
        part = next(part.rod for part in rod.uniform_parts if part.start <= 0.5 * (start + end) <= part.end)
        scale, at = np.array([1.0, h, 1.0, h])[:, None], np.ix_(range(2 * i, 2 * i + 4), range(2 * i, 2 * i + 4))
        y, dy, ddy = value * scale, slope * scale / h, curvature * scale / h**2
        w = 0.5 * h * weights
        forces = load.amplitude * axial.along(load, rod.axial_line, s, load.frequency)
        mass[at] += part.mass_per_length * (y * w) @ y.T
        stiff[at] += part.flexural_rigidity * (ddy * w) @ ddy.T
        stiff[at] += part.weight_per_length / part.radial_clearance * (y * w) @ y.T
        push[at] += load.mean * (dy * w) @ dy.T
        for k, force in enumerate(forces):  # Re(f e^(i k w t))
            cosines[k][at] += (dy * (w * force.real)) @ dy.T
            sines[k][at] -= (dy * (w * force.imag)) @ dy.T
    free = np.setdiff1d(np.arange(size), [0, size - 2])
    mass, stiff, push = (matrix[np.ix_(free, free)] for matrix in (mass, stiff, push))
    _, q = eigh(stiff - push, mass, subset_by_index=(0, modes - 1))
    held = q.T @ (stiff - push) @ q
    pushes = [q.T @ matrix[np.ix_(free, free)] @ q for matrix in (*cosines, *sines)]
    period = 2.0 * math.pi / load.frequency

    def rate(time: float, x: np.ndarray) -> np.ndarray:
        position, velocity = x.reshape(2, modes, 2 * modes)
        phases = load.frequency * time * np.arange(1, len(load.harmonics) + 1)
        shares = np.concatenate([np.cos(phases), np.sin(phases)])
        pushed = held - sum(share * push for share, push in zip(shares.tolist(), pushes, strict=True))
        return np.concatenate([velocity, -pushed @ position - 2.0 * rod.damping_rate * velocity]).ravel()

    run = solve_ivp(rate, (0.0, period), np.eye(2 * modes).ravel(), method="DOP853", rtol=1e-10, atol=1e-12)
    multipliers = np.linalg.eigvals(run.y[:, -1].reshape(2 * modes, 2 * modes))
    return max(0.0, math.log(np.abs(multipliers).max()) / period)


# --- the force along a line ---


@pytest.mark.parametrize("far_end", FAR_ENDS)
def test_force_is_the_solution_of_the_wave_equation(far_end: str, rng: np.random.Generator) -> None:
    for damping in (0.0, 0.4, 20.0, 300.0):
        line = drawn_line(rng, 4)
        frequency = float(rng.uniform(0.1, 12.0)) * line.unit
        load = wave(far_end, frequency, damping)
        s = np.unique(np.append(np.linspace(0.0, line.length, 41), line.edges[1:-1]))
        expected = integrated(line, load, frequency, s)
        found = line.profile(load, s, frequency)
        size = np.abs(expected).max()
        if size > 1e4:  # next to a resonance the integration is not accurate enough
            continue
        assert found == pytest.approx(expected, abs=1e-9 * size**2)
        assert np.isrealobj(found) == (damping == 0.0)
        assert found[0] == pytest.approx(1.0, abs=1e-12 * size)


@pytest.mark.parametrize("far_end", FAR_ENDS)
def test_equal_pieces_are_the_closed_form(far_end: str, rng: np.random.Generator) -> None:
    for damping in (0.0, 3.0, 400.0, 1e6):
        for _ in range(depth(100, 10)):
            lengths = rng.uniform(2.0, 20.0, int(rng.integers(2, 7)))
            line = equal_pieces(lengths, 5135.0)
            assert len(line.pieces) == lengths.size
            load = wave(far_end, float(rng.uniform(1e-4, 20.0)) * line.unit, damping)
            s = np.linspace(0.0, line.length, 41)
            expected = load.profile(5135.0, line.length, s, load.frequency)
            # Driven at both ends, two waves of a free end are added, which are large next to all its resonances.
            beside = wave("free", load.frequency, damping) if far_end == "driven" else load
            size = np.abs(beside.profile(5135.0, line.length, s, load.frequency)).max()
            found = line.profile(load, s, load.frequency)
            assert np.abs(found - expected).max() < 1e-12 * max(1.0, size) ** 2


def test_strong_damping_neither_overflows_nor_loses_the_driven_end(rng: np.random.Generator) -> None:
    for far_end, damping in itertools.product(FAR_ENDS, (1e3, 1e6, 1e12)):
        line = drawn_line(rng)
        s = np.linspace(0.0, line.length, 301)
        found = line.profile(wave(far_end, 100.0, damping), s, 100.0)
        assert np.isfinite(found).all()
        assert found[0] == pytest.approx(1.0, abs=1e-12)
        assert np.abs(found).max() <= 2.0


def test_slow_waves_keep_their_digits(rng: np.random.Generator) -> None:
    # Without waves the force is uniform, or falls to a free end as inertia along the rod is accelerated.
    line = drawn_line(rng)
    s = np.append(line.edges, rng.uniform(0.0, line.length, 20))
    for frequency in (1e-9, 1e-5):
        assert line.profile(wave("held"), s, frequency) == pytest.approx(np.ones(s.size), abs=1e-9)
        assert line.profile(wave("driven"), s, frequency) == pytest.approx(np.ones(s.size), abs=1e-9)
        masses = [piece.impedance / piece.wave_speed * piece.length for piece in line.pieces]
        mass = np.interp(s, line.edges, np.append(0.0, np.cumsum(masses)))
        assert line.profile(wave("free"), s, frequency) == pytest.approx(1.0 - mass / mass.max(), abs=1e-9)


def velocity(line: AxialLine, load: fr.AxialWave, s: np.ndarray) -> np.ndarray:
    """Return the velocity along a line at places inside its pieces, the derivative of the force over i rho A omega."""
    near, frequency = 1e-4, load.frequency
    i = np.searchsorted(line.edges[1:-1], s)
    mass = np.array([piece.impedance / piece.wave_speed for piece in line.pieces])[i]
    above, below = (line.profile(load, s + side * near, frequency) for side in (-1.0, 1.0))
    inertia = complex(frequency**2, -2.0 * load.axial_damping * frequency)
    return np.asarray(1j * frequency * (below - above) / (2.0 * near) / (mass * inertia))


def test_what_arrives_is_what_is_lost_below(rng: np.random.Generator) -> None:
    # Power at a place: Re(P conj(v)) / 2, which damping takes below it, 2 c_a rho A |v|^2 / 2 a metre.
    points, weights = np.polynomial.legendre.leggauss(60)
    for far_end in ("held", "free"):
        line, damping = drawn_line(rng), float(rng.uniform(1.0, 50.0))
        load = wave(far_end, float(rng.uniform(0.5, 9.0)) * line.unit, damping)
        lost = 0.0
        for piece, start in zip(line.pieces, line.edges[:-1], strict=True):
            speeds = velocity(line, load, start + 0.5 * piece.length * (points + 1.0))
            lost += (
                damping * piece.impedance / piece.wave_speed * 0.5 * piece.length * float(weights @ abs(speeds) ** 2)
            )
        arrives = 0.5 * float(velocity(line, load, np.array([0.0]))[0].real)
        assert arrives == pytest.approx(lost, rel=1e-4)


def test_waves_are_reciprocal(rng: np.random.Generator) -> None:
    # A force at one of two free ends moves the other as a force there would move the first one.
    for damping in (0.0, 10.0):
        for _ in range(depth(50, 5)):
            line = drawn_line(rng)
            load = wave("free", float(rng.uniform(0.5, 9.0)) * line.unit, damping)
            if line.is_near_pole(load, load.frequency):
                continue
            pair = line, AxialLine(line.pieces[::-1])
            one, other = (velocity(each, load, np.array([each.length]))[0] for each in pair)
            assert one == pytest.approx(other, rel=1e-5, abs=1e-9)


def test_driven_ends_look_the_same_from_either_end(rng: np.random.Generator) -> None:
    for _ in range(depth(100, 10)):
        line = drawn_line(rng)
        mirrored, load = AxialLine(line.pieces[::-1]), wave("driven", 1.0, float(rng.choice([0.0, 30.0])))
        frequency, s = float(rng.uniform(0.5, 9.0)) * line.unit, np.linspace(0.0, line.length, 33)
        one, other = line.profile(load, s, frequency), mirrored.profile(load, line.length - s, frequency)
        assert one == pytest.approx(other, rel=1e-9, abs=1e-11 * np.abs(one).max() ** 2)


@pytest.mark.slow
def test_symmetric_lines_driven_at_both_ends_have_no_resonance_of_odd_motion() -> None:
    outer, middle = LinePiece(20.0, 5135.0, 2.0), LinePiece(30.0, 5135.0, 7.0)
    line, load = AxialLine((outer, middle, outer)), wave("driven")
    even = line.resonances(load, np.arange(6))
    every = line.resonances(wave("free"), np.arange(12))
    assert even == pytest.approx(every[::2], rel=1e-12)
    s = np.linspace(0.0, 70.0, 71)
    for frequency in every[1::2].tolist():  # finite, and the same from either end
        found = line.profile(load, s, frequency)
        assert found == pytest.approx(found[::-1], rel=1e-10)
        beside = 1.0001 * frequency
        assert found == pytest.approx(integrated(line, load, beside, s), abs=0.02 * np.abs(found).max())
        assert line.profile(load, s, beside) == pytest.approx(integrated(line, load, beside, s), abs=1e-7)
    almost = AxialLine((outer, middle, outer._replace(length=20.0001)))
    beside = 1.01 * float(every[3])
    assert almost.profile(load, s, beside) == pytest.approx(line.profile(load, s, beside), abs=1e-3)


# --- resonances ---


@pytest.mark.slow
def test_resonances_of_two_sections_solve_their_equation(rng: np.random.Generator) -> None:
    for _ in range(depth(100, 15)):
        line = drawn_line(rng, 2)
        (upper, lower), unit = line.pieces, line.unit
        a, b, z = upper.length / upper.wave_speed, lower.length / lower.wave_speed, upper.impedance / lower.impedance

        def held(w: float, a: float = a, b: float = b, z: float = z) -> float:
            return math.cos(w * a) * math.cos(w * b) - z * math.sin(w * a) * math.sin(w * b)

        def free(w: float, a: float = a, b: float = b, z: float = z) -> float:
            return math.cos(w * a) * math.sin(w * b) + z * math.sin(w * a) * math.cos(w * b)

        for far_end, zero in (("held", held), ("free", free)):
            fine = np.linspace(1e-6, 30.0, 30_001) * unit
            sizes = [zero(w) for w in fine.tolist()]
            expected = [
                brentq(zero, low, high, xtol=1e-13 * high, rtol=1e-14)
                for low, high, one, other in zip(fine, fine[1:], sizes, sizes[1:], strict=False)
                if (one > 0.0) != (other > 0.0)
            ]
            assert line.resonances(wave(far_end), np.arange(len(expected))) == pytest.approx(expected, rel=1e-11)
            assert line.passed(wave(far_end), 30.0 * unit) == len(expected)


@pytest.mark.slow
@pytest.mark.parametrize("far_end", FAR_ENDS)
def test_no_resonance_is_missed_by_a_count_or_a_fine_scan(far_end: str, rng: np.random.Generator) -> None:
    load = wave(far_end)
    for _ in range(depth(30, 4)):
        line = drawn_line(rng)
        found = line.resonances(load, np.arange(1 + line.passed(load, 20.0 * line.unit)))
        assert (np.diff(found) > 0.0).all()
        assert found[-2] <= 20.0 * line.unit < found[-1]
        fine = np.linspace(0.01, 20.0, 20_001) * line.unit
        peaks = line.largest(load, fine)
        tops = 1 + np.flatnonzero((peaks[1:-1] > peaks[:-2]) & (peaks[1:-1] > peaks[2:]) & (peaks[1:-1] > 200.0))
        for w in fine[tops].tolist():
            assert np.abs(found - w).min() < 0.002 * line.unit
        for w in found[:-1].tolist():
            assert line.largest(load, np.array([w * (1.0 - 1e-9), w * (1.0 + 1e-9)])).min() > 1e4


def test_the_largest_force_is_that_of_a_fine_grid(rng: np.random.Generator) -> None:
    for far_end, damping in itertools.product(FAR_ENDS, (0.0, 0.4, 20.0, 500.0)):
        line = drawn_line(rng)
        frequency = float(rng.uniform(0.05, 20.0)) * line.unit
        load = wave(far_end, frequency, damping)
        if axial.gaps(load, line, (frequency, frequency), 0.0):
            continue
        found = axial.axial_response(load, line, 100.0)
        s = np.unique(np.append(np.linspace(0.0, line.length, 40_001), line.edges))
        sizes = np.abs(line.profile(load, s, frequency))
        assert sizes.max() <= found.factor * (1.0 + 1e-9)
        assert found.factor == pytest.approx(sizes.max(), rel=1e-5)
        there = np.abs(line.profile(load, np.array([found.position]), frequency))
        assert there[0] == pytest.approx(found.factor, rel=1e-7)
        if not damping:
            assert line.largest(load, np.array([frequency]))[0] == pytest.approx(found.factor, rel=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize(
    "far_end", [pytest.param(end, marks=[pytest.mark.slow] * (k > 0)) for k, end in enumerate(FAR_ENDS)]
)
def test_gaps_are_where_verdicts_are_refused(far_end: str, rng: np.random.Generator) -> None:
    load = wave(far_end, waveform=(1.0, 0.0, 0.2))
    for _ in range(depth(20, 3)):
        line = drawn_line(rng)
        bounds = 0.1 * line.unit, 9.0 * line.unit
        found = axial.gaps(load, line, bounds)
        assert all(one.high < other.low for one, other in itertools.pairwise(found))
        frequencies = rng.uniform(*bounds, 2000)
        beyond = np.maximum(*(line.largest(load, k * frequencies) for k in (1, 3))) > axial.MOST_FACTOR
        inside = np.any([(gap.low < frequencies) & (frequencies < gap.high) for gap in found], axis=0)
        assert (inside == beyond).all()
        for gap in found:  # both ends are answered, to rounding
            for end, beside in ((gap.low, 1.0 - 1e-5), (gap.high, 1.0 + 1e-5)):
                if end not in bounds:
                    axial.require_off_resonance(load, line, end)
                    width = beside * end - end
                    inner = end - math.copysign(min(abs(width), 1e-3 * (gap.high - gap.low)), width)
                    with pytest.raises(ValueError, match=r"is (at the axial|where harmonic 3)"):
                        axial.require_off_resonance(load, line, inner)
            assert not {gap.low, gap.high}.isdisjoint(bounds) or gap.low < gap.resonance.frequency < gap.high


@pytest.mark.slow
def test_a_force_made_large_below_a_thin_section_is_refused_between_resonances() -> None:
    # A thin wire above a heavy tool: where the tool resonates by itself, the wire passes on next to nothing.
    line = AxialLine((LinePiece(30.0, 5000.0, 1.0), LinePiece(20.0, 5000.0, 300.0)))
    load = wave("held")
    bounds = 1.0, 4000.0
    found = axial.gaps(load, line, bounds)
    fine = np.linspace(*bounds, 400_001)
    beyond = line.largest(load, fine) > axial.MOST_FACTOR
    inside = np.any([(gap.low < fine) & (fine < gap.high) for gap in found], axis=0)
    assert (inside == beyond).all()


# --- rods ---


def test_a_rod_of_one_section_is_a_uniform_line() -> None:
    rod = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=60.0)
    (piece,) = rod.axial_line.pieces
    assert piece == (rod.length, rod.wave_speed, pytest.approx(rod.mass_along * rod.wave_speed, rel=1e-15))
    two_bores = rod.replace(bores=[(0.0, "4.778in"), (30.0, "6.184in")])
    assert two_bores.axial_line == rod.axial_line
    load = fr.AxialWave(0.0, 10.0, 60.0)
    assert two_bores.axial_response(load).factor == rod.axial_response(load).factor


def test_sections_become_pieces() -> None:
    pieces = STRING.axial_line.pieces
    assert [piece.length for piece in pieces] == [20.0, 25.0, 15.0]
    for piece, part in zip(pieces, STRING.uniform_parts, strict=True):
        rod = part.rod
        assert piece.impedance == pytest.approx(rod.area * math.sqrt(rod.youngs_modulus * rod.density), rel=1e-14)
    assert STRING.wave_speed == STRING.axial_line.wave_speed
    nitinol = fr.Section(diameter=0.05, youngs_modulus=68e9, density=6450.0, length=9.0)
    mixed = STRING.replace(sections=[*STRING.sections, nitinol])
    times = sum(piece.length / piece.wave_speed for piece in mixed.axial_line.pieces)
    assert mixed.wave_speed == pytest.approx(mixed.length / times, rel=1e-14)


def test_the_response_names_the_section() -> None:
    held = STRING.axial_response(fr.AxialWave(0.0, 10.0, 60.0))
    assert (held.position, held.section) == (60.0, 2)
    assert "at 60 m, in section 3" in held.in_words
    assert held.as_dict()["section"] == 2
    assert STRING.axial_response(fr.AxialLoad(0.0, 10.0, 60.0)).section == 0
    at_resonance = STRING.axial_response(fr.AxialWave(0.0, 10.0, held.resonances[0].frequency))
    assert at_resonance.section is None
    assert math.isinf(at_resonance.factor)
    tubing = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=60.0)
    uniform = tubing.axial_response(fr.AxialWave(0.0, 10.0, 60.0))
    assert uniform.section is None
    assert "section" not in uniform.as_dict()


# --- verdicts ---


def string(sections: list[fr.Section]) -> fr.Rod:
    return fr.Rod(sections=sections, channel_radius=0.0607, fluid_inside=1000.0, fluid_outside=1000.0)


WALLS = string([fr.Section("2.00x0.156 CT90", length=30.0), fr.Section("2.00x0.203 CT90", length=30.0)])
TOOL = string(
    [fr.Section("2.00x0.156 CT90", length=55.0), fr.Section(diameter="2.875in", inner_diameter="1in", length=5.0)]
)


def shaken(rod: fr.Rod, mean: float, amplitude: float, phase: float, far_end: str, damping: float) -> fr.AxialWave:
    """Return a wave under forces in critical forces, at so many radians of travel."""
    numbers = mean * rod.critical_force, amplitude * rod.critical_force, phase * rod.axial_line.unit
    return fr.AxialWave(*numbers, far_end=far_end, axial_damping=damping)


CASES = [
    (WALLS.replace(damping_rate=0.2), (0.5, 0.35, 0.45, "held", 0.0)),
    (WALLS, (0.4, 0.3, 1.1, "free", 0.0)),
    (TOOL.replace(damping_rate=0.1), (0.3, 0.3, 0.9, "driven", 5.0)),
    (TOOL, (0.2, 0.15, 0.3, "held", 2.0)),
]


@pytest.mark.parametrize("case", CASES[:1])
def test_growth_is_that_of_finite_elements(case: tuple[fr.Rod, tuple[Any, ...]]) -> None:
    rod, values = case
    load = shaken(rod, *values)
    assert rod.growth_rate(load) == pytest.approx(growth_by_finite_elements(rod, load, 240, 40), abs=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_growth_is_that_of_finite_elements_to_a_millionth(case: tuple[fr.Rod, tuple[Any, ...]]) -> None:
    rod, values = case
    load = shaken(rod, *values)
    coarse, fine = (growth_by_finite_elements(rod, load, elements, 60) for elements in (400, 800))
    verdict = rod.stability(load)
    assert verdict.growth_rate == pytest.approx(fine + (fine - coarse) / 15.0, abs=1e-6)  # cubics: errors like h^4


def recorded(rod: fr.Rod) -> fr.ForceRecord:
    """Return the record of a force of two harmonics."""
    unit, force = rod.axial_line.unit, rod.critical_force
    time = np.linspace(0.0, 20.0, 8001)
    angle = 0.3 * unit * time
    return fr.ForceRecord(time, force * (0.5 + 0.3 * np.sin(angle) + 0.1 * np.cos(2.0 * angle)))


@pytest.mark.slow
def test_a_force_record_grows_as_finite_elements_with_waves_and_without() -> None:
    rod = WALLS.replace(damping_rate=0.2)
    record = recorded(rod)
    for load in (record.load, with_waves(record.load, 2.0)):
        assert rod.growth_rate(load) == pytest.approx(growth_by_finite_elements(rod, load, 240, 40), abs=2e-5)


@pytest.mark.slow
def test_a_force_record_grows_as_its_load() -> None:
    rod = WALLS.replace(damping_rate=0.2)
    record = recorded(rod)
    verdict = rod.stability(record)
    assert verdict.growth_rate == pytest.approx(rod.growth_rate(record.load), rel=1e-6)
    assert verdict.growth_rate > 0.5
    response = rod.axial_response(with_waves(record.load, 2.0))
    assert response.factor > 1.01
    assert response.section in (0, 1)


@pytest.mark.parametrize(
    "far_end", [pytest.param(end, marks=[pytest.mark.slow] * (k > 0)) for k, end in enumerate(FAR_ENDS)]
)
def test_arrays_of_waves_are_answered_as_single_ones(far_end: str) -> None:
    rod = TOOL.replace(damping_rate=0.1)
    load = shaken(rod, 0.4, 0.1, 0.7, far_end, 0.0)
    (resonance,) = rod.axial_line.resonances(load, np.array([0])).tolist()
    frequencies = np.array([0.2 * resonance, 0.55 * resonance, resonance, 1.05 * resonance])
    grown = rod.growth_rate(load, frequency=frequencies)
    assert np.isnan(grown).tolist() == [False, False, True, False]
    status = rod.verdicts(load, frequency=frequencies)
    assert status[2] == -1
    for i in (0, 1, 3):
        single = load.varied("frequency", float(frequencies[i]))
        assert rod.growth_rate(single) == pytest.approx(grown[i], rel=1e-9, abs=1e-12)
        assert bool(rod.stability(single).stable) == (status[i] == 1)
    with pytest.raises(ValueError, match=r"is at the axial resonance of the rod at .* far end"):
        rod.stability(load.varied("frequency", resonance))


@pytest.mark.slow
def test_maps_ranges_and_limits_of_waves_hold_at_single_loads(tuned: Tuned) -> None:
    tuned(samples_of_ranges=9, least_samples_of_a_group=3, groups_of_frequencies=2)
    rod = WALLS.replace(damping_rate=0.2)
    load = shaken(rod, 0.3, 0.002, 1.0, "held", 0.0)
    (resonance,) = rod.axial_line.resonances(load, np.array([0])).tolist()
    ranges = rod.ranges("frequency", load, bounds=(0.97 * resonance, 1.03 * resonance))
    (gap,) = ranges.not_computed
    assert gap.low < resonance < gap.high
    assert rod.axial_line.largest(load, np.array(gap[:2])) == pytest.approx([100.0, 100.0], rel=1e-4)
    assert gap.resonance.frequency == pytest.approx(resonance, rel=1e-12)
    for part in ranges:
        assert rod.is_stable(load, frequency=0.5 * (part.low + part.high))
    limit = rod.critical("amplitude", load, mean=0.3 * rod.critical_force, frequency=0.8 * resonance)
    assert 0.0 < limit < rod.critical_force
    for share, is_stable in ((0.999, True), (1.001, False)):
        assert rod.is_stable(load, amplitude=share * limit, frequency=0.8 * resonance) == is_stable
    chart = fr.stability_map(
        rod,
        load,
        mean=(0.0, 0.5 * rod.critical_force, 3),
        amplitude=load.amplitude,
        frequency=(0.5 * resonance, 0.8 * resonance, 4),
    )
    for i, mean in enumerate(chart.y.values.tolist()):
        for j, frequency in enumerate(chart.x.values.tolist()):
            assert chart.stable[i, j] == rod.is_stable(load, mean=mean, frequency=frequency)


def test_a_string_driven_at_both_ends_grows_as_its_mirror_image() -> None:
    mirrored = TOOL.replace(sections=TOOL.sections[::-1])
    load = shaken(TOOL, 0.3, 0.3, 0.9, "driven", 5.0)
    assert mirrored.growth_rate(load) == pytest.approx(TOOL.growth_rate(load), rel=1e-6) != 0.0


def test_a_bore_that_changes_leaves_waves_as_they_are() -> None:
    tubing = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=60.0)
    same = tubing.replace(bores=[(0.0, "4.778in"), (30.0, 0.1213612 * (1.0 + 1e-12))])
    load = shaken(tubing, 0.5, 0.35, 0.45, "held", 0.0)
    assert same.varies
    assert same.growth_rate(load) == pytest.approx(tubing.growth_rate(load), rel=1e-6)
