"""A string that a tool shakes: its pieces, the nodes of its waves, and all at any depth once they have settled."""

from __future__ import annotations

import numpy as np

from floquetrod._util.arrays import Bools, Complexes, Floats, Ints
from floquetrod._util.compilation import compiled
from floquetrod.wells.drag import Drag, Fineness, Shaking
from floquetrod.wells.kernels import shaken_march as kernels
from floquetrod.wells.kernels import tool_wave
from floquetrod.wells.kernels.wall_contact import LOCKED
from floquetrod.wells.minimum_curvature import Points

_SAME = 1e-6  # m, from which two heights differ, far above the rounding of depths (a choice)
_LEAST = 1e-6  # damping ratio: without friction and damping a resonance is infinite (a choice)

_SOFT = 1e-4  # least rounding of the corner of friction of two waves, of which the other one rounds it more


class ShakenString:
    """A string with a tool, between measured depths ``top`` and ``bottom`` in m, with y at its lower end.

    ``nodes`` (n + 1,) are the heights of the nodes of its waves above the lower end in m, one wave for each frequency;
    friction has a mean along each of ``pieces``.
    """

    def __init__(self, drag: Drag, shaking: Shaking, top: float, bottom: float, y: float, fineness: Fineness) -> None:
        """Set pieces and nodes, ``fineness.cells`` to a wave, or to 300 m of a long one; nodes where sections meet."""
        self.shaking, self.bottom = shaking, bottom
        self.soft = fineness.soft if shaking.second is None else max(fineness.soft, _SOFT)
        self.sliding, self.pieces = drag.sliding, _pieces(drag, shaking, top, bottom, fineness.cells)
        length, size = bottom - top, self.pieces.friction.size
        longest = float(np.minimum(shaking.divided, length)) / fineness.cells
        meets = np.empty(0) if drag.assembly is None else drag.assembly.inner
        ends = np.unique([0.0, shaking.above_end, length])
        ends = np.union1d(ends, _apart(meets[meets < length], ends))
        number = np.ceil(np.diff(ends) / longest).astype(int)
        number[-1] = max(2, number[-1])
        stretches = zip(ends[:-1], ends[1:], number, strict=True)
        self.nodes = np.append(np.concatenate([np.linspace(a, b, n + 1)[:-1] for a, b, n in stretches]), length)
        below = int(np.searchsorted(self.nodes, shaking.above_end))
        self.impedance, self.wave_speed = _along(drag, shaking, bottom, 0.5 * (ends[:-1] + ends[1:]))
        cells = number, np.diff(ends) / number, self.impedance, self.wave_speed
        low, high, helix, pressed = np.zeros((4, size))
        self.marched = kernels.Marched(np.full(size + 1, y), low, high, helix, pressed, np.full(size, fineness.share))
        balance = tool_wave.empty_balance(self.nodes.size - 1)
        waves = []
        for amplitude, frequency in shaking.sines:
            force = tool_wave.ShakingForce(amplitude, shaking.speed, shaking.impedance, below)
            own = tool_wave.empty_balance(self.nodes.size - 1)._replace(most=balance.most)
            q = np.zeros(self.nodes.size, complex)
            waves.append(tool_wave.Wave(_cells(shaking, frequency, *cells), force, q, own))
        self.waves = tuple(waves)

    @property
    def edges(self) -> Floats:
        """Heights of the parts of cells above the lower end in m."""
        inner = self.nodes[:-1, None] + np.arange(tool_wave.PARTS) / tool_wave.PARTS * np.diff(self.nodes)[:, None]
        return np.append(inner.ravel(), self.nodes[-1])

    def settle(self, stays: float, turns: int) -> bool:
        """Compute force and waves; return whether all have settled, y to ``stays``, in at most ``turns`` turns."""
        run = compiled(kernels.settle)
        tuning = self.soft, stays, turns
        return bool(run(self.sliding, self.pieces, self.waves, self.edges, *tuning, self.marched))

    def y_at(self, depth: Floats) -> Floats:
        """Return y at measured depths, NaN where the string is not, by cubics within pieces."""
        ends, (y, low, high, *_) = self.pieces.up, self.marched
        up = self.bottom - depth
        i = np.clip(np.searchsorted(ends, up) - 1, 0, ends.size - 2)
        length = ends[i + 1] - ends[i]
        share, rise = (up - ends[i]) / length, y[i + 1] - y[i]
        bend = length * (low[i] * (1.0 - share) - high[i] * share) - rise * (1.0 - 2.0 * share)
        y_there = np.minimum(y[i] + share * rise + share * (1.0 - share) * bend, LOCKED)
        return np.where(self._has(up), y_there, np.nan)

    def wave_at(self, depth: Floats) -> Floats:
        """Return velocity in m/s, force in N and share of friction left at measured depths, (5, m), else NaN.

        Velocity and force are the largest: amplitudes, of two waves their sums.  The last two rows are velocity and
        force of the second wave, 0 without.
        """
        up = self.bottom - depth
        frequencies = (frequency for _, frequency in self.shaking.sines)
        amplitudes = [self._amplitudes(*each, up) for each in zip(self.waves, frequencies, strict=True)]
        share = self.shaking.left(*(speed for speed, _ in amplitudes))
        second = amplitudes[1] if len(amplitudes) > 1 else np.zeros((2, up.size))
        return np.where(self._has(up), [*np.sum(amplitudes, axis=0), share, *second], np.nan)

    def _amplitudes(self, wave: tool_wave.Wave, frequency: float, up: Floats) -> Floats:
        """Return the amplitudes of the velocity in m/s and of the force in N at heights above the lower end, (2, m)."""
        q = wave.q
        cell = np.clip(np.searchsorted(self.nodes, up, side="right") - 1, 0, self.nodes.size - 2)
        kind = wave.cells.kind[cell]
        wavenumber = frequency / self.wave_speed[kind]
        low, high = q[cell], q[cell + 1]
        done, whole = wavenumber * (up - self.nodes[cell]), wavenumber * np.diff(self.nodes)[cell]
        left = whole - done
        speed = low * np.sin(left) + high * np.sin(done)
        force = self.impedance[kind] * (high * np.cos(done) - low * np.cos(left))
        lower, upper = _forces_by_damping(wave)
        damped = 1j * (upper[cell] * done - lower[cell] * left) / whole
        return np.abs([speed / np.sin(whole), force / np.sin(whole) + damped])

    def _has(self, up: Floats) -> Bools:
        """Return where the string is, of heights above its lower end."""
        return np.asarray((up >= 0.0) & (up <= self.nodes[-1]))


def _forces_by_damping(wave: tool_wave.Wave) -> Complexes:
    """Return forces in N by damping in the cells of a wave at their lower and upper ends, complex, (2, n)."""
    kind = wave.cells.kind
    below, above = wave.cells.below[kind], wave.cells.above[kind]
    within = below * wave.q[:-1, None] + above * wave.q[1:, None]
    force = (wave.balance.damping.reshape(within.shape) + wave.cells.loss[kind][:, None]) * within
    return np.array([np.sum(basis * force, axis=1) for basis in (below, above)])


def _pieces(drag: Drag, shaking: Shaking, top: float, bottom: float, cells: int) -> kernels.Pieces:
    """Return pieces, no longer than three for four cells, that end at stations, where friction or bore changes.

    Those of several sections also end where sections meet.
    """
    inner = drag.edges
    ends = np.array([0.0, bottom - top])
    ends = np.union1d(ends, _apart(bottom - inner[(inner > top) & (inner < bottom)], ends))
    if drag.assembly is not None:
        meets = drag.assembly.inner
        ends = np.union1d(ends, _apart(meets[meets < bottom - top], ends))
    gaps, longest = np.diff(ends), float(np.minimum(shaking.divided, bottom - top)) / (0.75 * cells)
    number = np.ceil(gaps / longest).astype(int)
    counted = np.arange(number.sum()) - np.repeat(np.cumsum(number) - number, number)  # from 0 in every gap
    up = np.append(np.repeat(ends[:-1], number) + np.repeat(gaps / number, number) * counted, ends[-1])
    middle, arcs = bottom - 0.5 * (up[:-1] + up[1:]), drag.path.arcs
    arc = arcs.at(middle).arc
    depths = np.stack([bottom - up[:-1], middle, bottom - up[1:]], axis=-1)
    places = np.stack(Points(arcs, arc[:, None], depths - arcs.start[arc][:, None]).seen, axis=-1)
    there = drag.at(middle, np.asarray(bottom)).sliding
    weight, wound = (np.broadcast_to(each, middle.shape).copy() for each in (there.weight, there.wound))
    return kernels.Pieces(up, drag.friction.at(middle), places, weight, wound)


def _apart(heights: Floats, others: Floats) -> Floats:
    """Return the heights that differ from all increasing others by more than rounding: between them no piece fits."""
    k = np.clip(np.searchsorted(others, heights), 1, others.size - 1)
    return heights[np.minimum(np.abs(heights - others[k - 1]), np.abs(heights - others[k])) > _SAME]


def _along(drag: Drag, shaking: Shaking, bottom: float, up: Floats) -> tuple[Floats, Floats]:
    """Return impedance in N s/m and speed of axial waves in m/s at heights above the lower end."""
    if drag.assembly is None:
        return np.full(up.size, shaking.impedance), np.full(up.size, shaking.wave_speed)
    section = drag.assembly.section_at(bottom - up, np.asarray(bottom))
    return drag.assembly.impedance[section], drag.assembly.wave_speed[section]


def _cells(
    shaking: Shaking, frequency: float, number: Ints, length: Floats, z: Floats, wave_speed: Floats
) -> tool_wave.Cells:
    """Return cells of several kinds, a number of each, of a length in m and with an impedance and a wave speed."""
    wavenumber = frequency / wave_speed
    damping = max(shaking.damping, _LEAST * frequency)
    loss = 2.0 * damping * z / wave_speed * length / tool_wave.PARTS
    parts, phase = (np.arange(tool_wave.PARTS) + 0.5) / tool_wave.PARTS, np.maximum(wavenumber * length, 1e-9)[:, None]
    below, above = np.sin(phase * (1.0 - parts)) / np.sin(phase), np.sin(phase * parts) / np.sin(phase)
    kind = np.repeat(np.arange(number.size), number)
    return tool_wave.Cells(kind, z / np.tan(phase[:, 0]), z / np.sin(phase[:, 0]), below, above, loss)
