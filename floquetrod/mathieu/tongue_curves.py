"""The edges of tongues as curves over a plane of loads: on every line across it, where growth exceeds a level.

A family of equations u'' = (-kappa + p sin(omega t)) u, its damping removed, with kappa = stiffness - gain * mean and
p = gain * amplitude: a mode of a rod, or Mathieu's equation itself with gain 1 and frequency 1.  Lines go along the
mean or along the frequency, where the part of a tongue above a level is one interval (page `theory/ranges`); what
tells one line from the next is the frequency or the amplitude.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.content import ByContent
from floquetrod.mathieu.kernels import tongue_edges as kernels
from floquetrod.mathieu.tongue_intervals import BISECTION, filled

_BEYOND = 4.0  # how far beyond the window lines along the frequency are searched, in 1 / omega^2 (a choice)
_SEARCH = 150.0  # what an edge where growth equals a level takes, in counts


class Window(NamedTuple):
    """A window of loads: lines ``along`` one quantity from ``low`` to ``high``, one for each value of another.

    That is the one they are ``over``, whose values are in ``span``; ``fixed`` is the third quantity.  An amplitude may
    be negative: it only shifts time.
    """

    along: Literal["mean", "frequency"]
    over: Literal["frequency", "amplitude"]
    fixed: float
    low: float
    high: float
    span: tuple[float, float]


class _Lines(NamedTuple):
    """Arguments of the kernels."""

    slope: Floats
    q0: Floats
    q1: Floats
    w0: Floats
    w1: Floats
    low: Floats
    high: Floats


@dataclass(frozen=True, eq=False)
class TongueCurves(ByContent):
    """The tongues ``order`` of equations with ``stiffness`` and ``gain``, one equation for each tongue."""

    window: Window
    order: Ints
    stiffness: Floats  # in 1/s^2
    gain: Floats  # what a unit of force takes off it
    rate: float  # the level in 1/s, compared with growth without damping

    def some(self, chosen: Ints | Bools | slice) -> TongueCurves:
        """Return some of the tongues."""
        return replace(self, order=self.order[chosen], stiffness=self.stiffness[chosen], gain=self.gain[chosen])

    def edges(self, i: Ints, at: Floats) -> tuple[Floats, Floats]:
        """Return the lower and the upper edges of the tongues ``i`` on the lines ``at``.

        Where nothing exceeds the level both are where growth is largest; the upper edge of tongue 0 along the mean is
        infinite.  Along the frequency, edges beyond the window may stand anywhere beyond it.
        """
        every = np.ones(at.size, dtype=np.bool_)
        ends = self._ends(i, at, every, every)
        return self._place(ends[:, 1], i, at), self._upper(ends[:, 0], i, at)

    def edge(self, i: Ints, at: Floats, top: Bools) -> Floats:
        """Return the upper of the `edges` where ``top``, else the lower."""
        ends = self._ends(i, at, top, ~top)
        return np.where(top, self._upper(ends[:, 0], i, at), self._place(ends[:, 1], i, at))

    def _upper(self, u: Floats, i: Ints, at: Floats) -> Floats:
        place = self._place(u, i, at)
        return np.where(self.order[i] == 0, np.inf, place) if self.window.along == "mean" else place

    def _ends(self, i: Ints, at: Floats, lower: Bools, upper: Bools) -> Floats:
        """Return both ends in u of the tongues requested."""
        lines, order = self._lines(i, at), self.order[i]
        inputs = order, *lines, np.full(order.size, self.rate**2), lower, upper
        cost = _SEARCH if self.rate else BISECTION
        return filled(kernels.edge_fill, inputs, np.empty((order.size, 2)), _extent(lines), cost, chunk=256)

    def ridge(self, i: Ints, at: Floats) -> Floats:
        """Return the square of the largest growth rate of the tongues ``i`` on the lines ``at``.

        Tongue 0 has none along the mean, which is infinite; along the frequency what lies far beyond the window is
        left out.
        """
        lines, order = self._lines(i, at), self.order[i]
        inputs = order, *lines
        out = filled(kernels.ridge_fill, inputs, np.empty(order.size), _extent(lines), _SEARCH, chunk=256)
        return np.where(order == 0, np.inf, out) if self.window.along == "mean" else out

    def summits(self, i: Ints, at: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
        """Return where between ``low`` and ``high`` on the lines growth is fastest, and the square of its rate."""
        lines = self._lines(i, at)
        u = [self._parameter(y, i, at) for y in (low, high)]
        lines = lines._replace(low=np.minimum(*u), high=np.maximum(*u))
        out = filled(kernels.summit_fill, lines, np.empty((at.size, 2)), _extent(lines), _SEARCH, chunk=256)
        return np.clip(self._place(out[:, 0], i, at), low, high), out[:, 1]

    def _forces(self, i: Ints, at: Floats) -> tuple[Floats, Floats]:
        """Return p and omega on the lines ``at``."""
        if self.window.over == "frequency":
            return self.gain[i] * self.window.fixed, at
        return self.gain[i] * np.abs(at), np.full(at.size, self.window.fixed)

    def _lines(self, i: Ints, at: Floats) -> _Lines:
        order = self.order[i].astype(np.float64)
        nothing, one = np.zeros(order.size), np.ones(order.size)
        if self.window.along == "mean":
            p, omega = self._forces(i, at)
            w0 = omega**-2.0
            q = 2.0 * p * w0
            # Tongue 0 reaches upwards for ever; at b = level^2 + alpha solutions grow at the level, or faster.
            low = np.where(order == 0.0, -(4.0 + 1e-6) * (self.rate**2 * w0 + 0.5 * q), order**2 - 2.0 * q)
            return _Lines(one, q, nothing, w0, nothing, low, order**2 + 2.0 * q)
        p = self.gain[i] * at
        kappa = self.stiffness[i] - self.gain[i] * self.window.fixed
        least, most = (self.window.high**-2.0 / _BEYOND, self.window.low**-2.0 * _BEYOND)
        with np.errstate(divide="ignore"):
            start = np.where(kappa + p > 0.0, (1.0 - 1e-9) * order**2 / (4.0 * (kappa + p)), np.inf)
        start = np.where(order == 0.0, least, np.clip(start, least, most))
        end = np.where((order == 0.0) & (kappa >= 0.0), least, most)
        return _Lines(4.0 * kappa, nothing, 2.0 * p, nothing, one, start, end)

    def _place(self, u: Floats, i: Ints, at: Floats) -> Floats:
        """Return the mean, or the frequency, of a place on the lines."""
        if self.window.along == "frequency":
            return np.asarray(u**-0.5)
        _, omega = self._forces(i, at)
        return np.asarray((self.stiffness[i] - 0.25 * omega * omega * u) / self.gain[i])

    def _parameter(self, y: Floats, i: Ints, at: Floats) -> Floats:
        """Return what `_place` takes to a mean, or to a frequency."""
        if self.window.along == "frequency":
            return np.asarray(y**-2.0)
        _, omega = self._forces(i, at)
        return np.asarray(4.0 * (self.stiffness[i] - self.gain[i] * y) / (omega * omega))


def _extent(lines: _Lines) -> tuple[Floats, Floats]:
    """Return the largest a and q on the lines."""
    return np.maximum(lines.slope * lines.low, lines.slope * lines.high), lines.q0 + lines.q1 * lines.high
