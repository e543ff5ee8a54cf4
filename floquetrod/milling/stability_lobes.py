"""Stability lobes: spindle speeds and depths of cut judged together, critical depths, and the kind of each lobe."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Generator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import Complexes, Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.interpolation import chebyshev_points
from floquetrod._util.progress import Progress
from floquetrod._util.result_report import Report, Reported, Table
from floquetrod.floquet.multipliers import delay_growth, delay_many
from floquetrod.floquet.multipliers.delay_maps import Coefficients, maps_by_piece, period_maps
from floquetrod.floquet.multipliers.delay_mesh import Mesh, PieceMesh, mesh, piece_mesh
from floquetrod.floquet.multipliers.many_verdicts import ManyVerdicts
from floquetrod.floquet.status import STABLE, UNSTABLE
from floquetrod.milling.cutter import Cutter, cutting_by_delay, jumps, read_depth, read_speed
from floquetrod.milling.teeth import apart, part
from floquetrod.plane import Axis, Chart, Family, Verdicts, axis_values, charted

_MOST_BREAKS = 24  # of the cycle, beyond which kinks of delayed values are not among them (a choice)
_PHASE = 36.0  # rad that solutions turn by in a piece, at most (a choice)
_RESOLVED = 8, 0.5  # nodes with which some radians are resolved to about 1e-6: so many, and for each radian (measured)
_FEW = 4  # the first of these where kinks of uneven teeth cut the cycle into many short pieces (measured)
_STEPS, _REACH = 4, 50.0  # depths tried up to the least critical depth, and how many of these deep (a choice)
_MOST_VIBRATIONS = 120  # until teeth repeat: a critical depth then takes a quarter of a minute (measured)
_FARTHEST = 500.0  # times that depth up to which is searched (a choice)
_JUDGED_AT_ONCE = 512  # points of a chart (a choice)
_AT_ONCE = 16  # depths tried before deeper ones are (a choice)
_PRECISE = 1e-11  # of a critical depth, relative
_ENOUGH = 8  # nodes more, with which a boundary is known to some nine digits (measured)
ACCURACY = 1e-8  # relative error of critical depths: at most 2e-9 against twelve nodes more (measured)
_TRACED = 4  # nodes more, with which logarithms are known to 2e-7, with more kinks than `_MOST_BREAKS` 2e-5 (measured)
_SHOWN_ABOVE = 2.0  # least critical depths that a range suggested for a chart shows (a choice)
_STRONG = 0.1  # of the strongest vibration, from which others may name a lobe (a choice)
_NARROWEST = 1e-4  # of the highest speed: edges of lobes are halved to so much (a choice)
_HALVINGS, _END = 14, 1e-6  # of the distance to a neighbour at whose crossing a lobe is lowest; relative (a choice)
_AFTER_FOLD = 4.0  # times the last change of a depth that nears a fold of the curve as a root: 1 / (1 - sqrt(1/2))
_BESIDE = 0.01  # of depths of neighbours, by which shallower and deeper ones are tried first (a choice)
_SHALLOW = 0.5  # of the least depth of neighbours, from which depths between columns are tried (a choice)
_FINE = 1e-9  # of a critical depth between columns, relative: less fine ones name another lobe (a choice)
_JUMP = 0.03  # of the frequency of chatter between neighbours, beyond which a lobe may lie between them (a choice)
_INWARD, _PARABOLAS = 1e-3, 40  # of the distance of starts: the shortest step; how many are made (a choice)
_SEARCH = 15_000  # points of a chart that take as long as a search for lobes (measured, for the time that remains)
_USUAL = 12  # speeds tried until a lobe is known where it is lowest (measured, for the time that remains)
_GOLDEN = 0.5 * (3.0 - math.sqrt(5.0))  # of a bracket: a step of the golden section
_SAMPLED = 9  # speeds at which a critical depth is searched for where a chart has no lobe (a choice)
_NOT_REAL = 1e-6  # rad of a multiplier's angle, from 0 or pi

Kind = Literal["Hopf", "flip", "fold"]


class _Cut(NamedTuple):
    """A mesh for one number of pieces and nodes, and at its nodes H by delay (D, F, n, n)."""

    mesh: Mesh | PieceMesh
    cutting: Floats


class Lobe(NamedTuple):
    """A part of the boundary of chatter over which it begins in one way.

    Attributes
    ----------
    kind : {"Hopf", "flip", "fold"}
        How the vibration begins: with a frequency near a mode's, with twice the time between teeth as its period,
        or with that time; of uneven teeth the time until they repeat.
    number : int
        Whole vibrations between two teeth.  For unequal pitches the chatter frequency times the mean time between two
        teeth, rounded down.
    speeds : (float, float)
        Lowest and highest spindle speed, in rad/s, at which it was found; its edges lie up to a ten-thousandth beyond.
    depth : float
        Its least critical depth, in m, between columns too.
    at : float
        The speed there, in rad/s.
    frequency : float
        Chatter frequency there, angular, in rad/s.
    error : float
        Error of the depth, in m: 1e-8 of it, more where the lobe is lowest at its end beside a neighbour.
    """

    kind: Kind
    number: int
    speeds: tuple[float, float]
    depth: float
    at: float
    frequency: float
    error: float

    def __str__(self) -> str:
        """Return, say, "Hopf lobe 3"."""
        return f"{self.kind} lobe {self.number}"


@dataclass(frozen=True, eq=False, repr=False)
class Lobes(Reported, NoTruthValue, ByContent):
    """Stability lobes of a cutter.

    Attributes
    ----------
    milling : Milling
    chart : Chart
        Depth of cut in mm over spindle speed in rpm; its ``bands`` are of chatter.
    speeds : ndarray (m,)
        Spindle speeds of the chart, in rad/s.
    depths : ndarray (m,)
        The critical depth in m at each, infinite where none is found.
    lobes : tuple of Lobe
        The lobes between them, in the order of speeds.
    """

    ask = ".chart, .lobes"

    milling: Cutter
    chart: Chart
    speeds: Floats
    depths: Floats
    lobes: tuple[Lobe, ...]

    def plot(self, ax: Any = None) -> Any:
        """Draw the chart with its bands, each lobe named once, where it is lowest.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.
        """
        from floquetrod.plotting.lobes_plot import draw_lobes

        lowest = [min(parts, key=lambda part: part.depth) for parts in self._joined().values()]
        return draw_lobes(self, lowest, ax)

    def report(self) -> Report:
        """Return a table with a row for each lobe, its parts together; where there are none, why.

        Parts of one name whose chatter is nearest to one mode are one lobe: between them another one begins at less
        depth, or none in the chart.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.
        """
        if not self.lobes:
            return Report(f"{repr(self.milling).strip('<>')}: {self.none_in_range}")
        joined = self._joined()
        numbers = [mode.frequency / (2.0 * math.pi) for mode in self.milling.modes]
        rows = []
        for (name, mode), parts in joined.items():
            lowest = min(parts, key=lambda part: part.depth)
            ends = parts[0].speeds[0], parts[-1].speeds[1]
            rows.append(
                (
                    name,
                    f"{numbers[mode]:.6g}",
                    str(len(parts)),
                    " to ".join(dict.fromkeys(f"{_rpm(speed):.6g}" for speed in ends)),
                    f"{1e3 * lowest.depth:.6g}",
                    f"{1e3 * lowest.error:.0e}",
                    f"{_rpm(lowest.at):.6g}",
                    f"{lowest.frequency / (2.0 * math.pi):.6g}",
                )
            )
        heads = ["lobe", "mode / Hz", "parts", "speeds / rpm", "least depth / mm", "error / mm", "at / rpm"]
        heads.append("chatter / Hz")
        is_shown = [True, len(numbers) > 1, len(joined) < len(self.lobes), *[True] * 5]
        rest = [
            f"Edges of lobes lie up to {_rpm(edge_width(self.speeds)):.2g} rpm beyond these speeds.",
            f"Lobes narrower than {_rpm(self._width):.4g} rpm, the distance of columns of the chart, may be missed.",
            f"The relative error of a critical depth at a given speed is below {ACCURACY:.0e}.",
        ]
        if len(joined) < len(self.lobes):
            between = "Between parts of a lobe another one begins at less depth, or none in the chart"
            rest.insert(0, f"{between}; .lobes has each part.")
        columns = [(head, "<") for head in itertools.compress(heads, is_shown)]
        shown = [tuple(itertools.compress(row, is_shown)) for row in rows]
        headline = repr(self.milling).strip("<>")
        return Report(headline, [("deepest", self._deepest())], Table(columns, shown, "\n".join(rest)))

    def _joined(self) -> dict[tuple[str, int], list[Lobe]]:
        """Return the parts of each lobe, by its name and the mode whose frequency is nearest where it is lowest."""
        natural = np.array([mode.frequency for mode in self.milling.modes])
        joined: dict[tuple[str, int], list[Lobe]] = {}
        for lobe in self.lobes:
            joined.setdefault((str(lobe), int(np.abs(natural - lobe.frequency).argmin())), []).append(lobe)
        return joined

    def _deepest(self) -> str:
        """Return up to which depth nothing chatters at the best column of the chart, in words."""
        best = int(np.argmax(self.depths))
        if math.isfinite(self.depths[best]):
            return f"no chatter up to {1e3 * self.depths[best]:.6g} mm at {_rpm(self.speeds[best]):.6g} rpm"
        free = np.isinf(self.depths)
        runs = [list(group) for is_free, group in itertools.groupby(range(free.size), key=free.__getitem__) if is_free]
        longest = self.speeds[max(runs, key=len)]
        ends = " to ".join(dict.fromkeys(f"{_rpm(speed):.6g}" for speed in longest[[0, -1]]))
        return f"no chatter up to {self.chart.y.values[-1]:.4g} mm, the end of the chart, at {ends} rpm"

    @property
    def _width(self) -> float:
        """Distance of the columns of the chart in rad/s."""
        return float(self.speeds[1] - self.speeds[0])

    @cached_property
    def none_in_range(self) -> str:
        """Why no lobe begins within the chart, and depths between which one does; "" where there are lobes."""
        if self.lobes:
            return ""
        low, high = self.chart.y.values[[0, -1]]
        if (self.depths == 0.0).any():
            return f"no lobe in range: chatter begins below {low:.4g} mm; let the depths begin at 0 mm"
        speeds = self.speeds[np.unique(np.linspace(0, self.speeds.size - 1, _SAMPLED).astype(int))]
        depths = critical_depths(self.milling, speeds)
        i = int(np.argmin(depths))
        nothing = f"no lobe in range: nothing chatters up to {high:.4g} mm at these speeds"
        if not math.isfinite(depths[i]):
            return f"{nothing}, nor at any depth tried at {speeds.size} of them; take others"
        least = 1e3 * float(depths[i])
        return (
            f"{nothing}; at {_rpm(speeds[i]):.6g} rpm it does from {least:.4g} mm on: take depths up to "
            f"{_SHOWN_ABOVE * least:.2g} mm, say"
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the lobes for JSON, in rad/s and m.

        Returns
        -------
        dict of str
            Numbers and lists by name, units in the keys.
        """
        return {
            "lobes": [{"name": str(lobe), **lobe._asdict()} for lobe in self.lobes],
            "speeds_rad_per_s": self.speeds.tolist(),
            "column_width_rad_per_s": self._width,
            "edge_width_rad_per_s": edge_width(self.speeds),
            "critical_depths_m": [depth if math.isfinite(depth) else None for depth in self.depths.tolist()],
            "critical_depth_relative_error": ACCURACY,
            "stable_share": float(self.chart.stable.mean()),
            "undecided": self.chart.undecided,
        }

    def __repr__(self) -> str:
        """Return the axes of the chart and the number of lobes."""
        return f"<{self.chart.y.name} over {self.chart.x.name}: {len(self.lobes)} lobes; {self.chart.caption}>"


@dataclass(frozen=True)
class CuttingPlane(Family):
    """A cutter over spindle speeds in rad/s and depths of cut in m."""

    milling: Cutter
    growth_unit: str = "1/s"
    growth_tolerance: float = 0.0

    @property
    def vertex(self) -> float:
        """As near to the boundary as it takes few verdicts to come."""
        return 1e-7

    @property
    def points_at_once(self) -> int:
        """Points judged between two reports of progress, about a second for teeth of four pitches."""
        return _JUDGED_AT_ONCE

    @property
    def signed_growth(self) -> Callable[[Floats, Floats], Floats]:
        """Growth rates in 1/s at speeds and depths, with a number of nodes that verdicts need near the boundary."""
        return self._signed_growth

    def _signed_growth(self, speeds: Floats, depths: Floats) -> Floats:
        return _logs(self.milling, speeds, depths, _TRACED) * speeds / self.milling.cycle

    def subject(self) -> dict[str, Any]:
        """Say what the cutter is."""
        return {"kind": repr(self.milling).strip("<>"), "fixed": []}

    def verdicts(self, x: Floats, y: Floats, *, growth: bool = False, quick: bool = False) -> Verdicts:
        """Return verdicts, and growth rates in 1/s where they must be known or were needed."""
        speeds, depths = np.broadcast_arrays(x, y)
        verdicts = judged(self.milling, speeds.ravel(), depths.ravel(), growth=growth)
        periods = self.milling.cycle / speeds
        rates = np.maximum(verdicts.growth, 0.0).reshape(speeds.shape) / periods
        return Verdicts(verdicts.status.reshape(speeds.shape), rates)


def judged(milling: Cutter, speeds: Floats, depths: Floats, *, growth: bool = False) -> ManyVerdicts:
    """Return verdicts at speeds and depths (b,), growth until teeth repeat, where it was needed."""
    pieces, counts = _resolution(milling, speeds, depths)
    status, logs = np.zeros(speeds.size, dtype=np.int8), np.empty(speeds.size)
    for each in np.unique(pieces).tolist():
        some = np.flatnonzero(pieces == each)

        def maps(which: NDArray[np.intp], count: int, some: NDArray[np.intp] = some, each: int = each) -> Floats:
            return _maps(milling, speeds[some[which]], depths[some[which]], each, count)

        status[some], logs[some] = delay_many.judged(maps, counts[some], growth=growth)
    return ManyVerdicts(status, logs)


def _lags(milling: Cutter, depths: Floats) -> Floats:
    """Return the lag of upper ends of teeth at depths, in rad."""
    return np.asarray([milling.lag(depth) for depth in depths.tolist()]) if milling.helix else np.zeros(depths.size)


def _resolution(milling: Cutter, speeds: Floats, depths: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return into how many pieces the longest part between jumps is cut, and the nodes in each, of places (b,)."""
    stiffest = max(mode.frequency for mode in milling.modes)
    lightest = min(mode.mass for mode in milling.modes)
    lags, inverse = np.unique(_lags(milling, depths), return_inverse=True)
    longest = np.array([np.diff(_breaks(milling, 1, lag)).max() for lag in lags.tolist()])[inverse] * milling.cycle
    phase = longest / speeds * np.sqrt(stiffest**2 + depths * _largest_cutting(milling) / lightest)
    pieces = np.ceil(phase / _PHASE).astype(np.intp)
    alike = _has_equal_teeth(milling)
    nodes = (_RESOLVED[0] if alike else _FEW) + _RESOLVED[1] * phase / pieces
    return pieces, (4 * np.ceil(0.25 * nodes) if alike else 2 * np.ceil(0.5 * nodes)).astype(np.intp)


def _has_equal_teeth(milling: Cutter) -> bool:
    """Return whether teeth are straight and cut the surface of one delay, so that the cycle has few pieces."""
    return len(milling.delays) == 1 and milling.helix == 0.0


def _require_fast(milling: Cutter, speed: float) -> None:
    """Raise ValueError for a spindle so slow that a critical depth would take long."""
    turns = max(mode.frequency for mode in milling.modes) * milling.cycle / (2.0 * math.pi)
    slowest = turns / _MOST_VIBRATIONS
    if speed < slowest:
        raise validate.wrong_value(
            "speed",
            f"must be at least {30.0 * slowest / math.pi:.4g} rpm, {slowest:.4g} rad/s, got {speed:.4g} rad/s: slower, "
            f"the tool vibrates more than {_MOST_VIBRATIONS} times {_until(milling)}, and a depth takes minutes",
        )


def _until(milling: Cutter) -> str:
    """Return the time over which the cutter is judged, in words."""
    return "between two teeth" if milling.cycle == milling.pitch[0] else "until its teeth repeat"


@functools.lru_cache(maxsize=16)
def _largest_cutting(milling: Cutter) -> float:
    """Return about the largest norm of H, in Pa."""
    count = 64 * round(milling.cycle * milling.teeth / (2.0 * math.pi)) + 1
    return float(np.linalg.norm(milling.cutting(np.linspace(0.0, milling.cycle, count)), 2, axis=(1, 2)).max())


@functools.lru_cache(maxsize=1024)
def _breaks(milling: Cutter, pieces: int, lag: float = 0.0) -> tuple[float, ...]:
    """Return the ends of pieces as parts of the cycle, the longest part between jumps cut into some."""
    at = {0.0, *(angle / milling.cycle for angle in jumps(milling, lag)), 1.0}
    edges = sorted(at)
    images = _images(milling, at, lag)
    if images and len(at) + len(images) <= _MOST_BREAKS:
        edges = apart(sorted(at | images))
    longest = max(high - low for low, high in pairwise(edges))
    breaks = [0.0]
    for low, high in pairwise(edges):
        breaks += np.linspace(low, high, math.ceil(pieces * (high - low) / longest - 1e-9) + 1)[1:].tolist()
    return tuple(breaks)


def _images(milling: Cutter, at: set[float], lag: float) -> set[float]:
    """Return where delayed values have a kink, as parts of the cycle: one delay after H jumps, while they are cut."""
    images: set[float] = set()
    for i, delay in enumerate(milling.delays):
        share = part(delay, milling.cycle)
        if share.denominator == 1:
            continue
        after = sorted((edge + float(share)) % 1.0 for edge in at - {1.0})
        there = cutting_by_delay(milling, np.array(after) * milling.cycle, lag)[i]
        images |= {image for image, value in zip(after, there, strict=True) if value.any()}
    return {image for image in images if min(abs(image - edge) for edge in at) > 1e-9}


@functools.lru_cache(maxsize=32)
def _cut(milling: Cutter, pieces: int, count: int, lag: float = 0.0) -> _Cut:
    breaks = _breaks(milling, pieces, lag)
    middles = 0.5 * (np.asarray(breaks[1:]) + np.asarray(breaks[:-1]))
    active = (cutting_by_delay(milling, middles * milling.cycle, lag) != 0.0).any(axis=(2, 3))
    delays = tuple(float(part(delay, milling.cycle)) for delay in milling.delays)
    make = mesh if _has_equal_teeth(milling) else piece_mesh
    on = make(breaks, count, 2, delays, tuple(map(tuple, active.tolist())))
    return _Cut(on, cutting_by_delay(milling, on.nodes * milling.cycle, lag))


def _maps(milling: Cutter, speeds: Floats, depths: Floats, pieces: int, count: int) -> Floats:
    """Return the maps until teeth repeat, (b, S, S); smaller ones have zeros in more rows, and multipliers 0 more."""
    lags, inverse = np.unique(_lags(milling, depths), return_inverse=True)
    if lags.size == 1:
        return _maps_with_lag(milling, speeds, depths, pieces, count, float(lags[0]))
    of_lag = [np.flatnonzero(inverse == i) for i in range(lags.size)]
    made = [
        _maps_with_lag(milling, speeds[some], depths[some], pieces, count, lag)
        for some, lag in zip(of_lag, lags.tolist(), strict=True)
    ]
    rows = max(maps.shape[1] for maps in made)
    result = np.zeros((speeds.size, rows, rows))
    for some, maps in zip(of_lag, made, strict=True):
        result[some, : maps.shape[1], : maps.shape[1]] = maps
    return result


def _maps_with_lag(milling: Cutter, speeds: Floats, depths: Floats, pieces: int, count: int, lag: float) -> Floats:
    on, cutting = _cut(milling, pieces, count, lag)
    n = len(milling.modes)
    omega, ratio, mass = (np.array(column) for column in zip(*map(_numbers, milling.modes), strict=True))
    period = milling.cycle / speeds
    forces = [(period**2 * depths)[:, None, None, None] * (each / mass[:, None]) for each in cutting]
    free = (period**2)[:, None, None, None] * np.diag(omega**2)
    damping = -period[:, None, None, None] * np.diag(2.0 * ratio * omega)
    rate = np.broadcast_to(damping, (speeds.size, len(on.nodes), n, n))
    coefficients = Coefficients(-free - functools.reduce(np.add, forces), rate, tuple(forces))
    return maps_by_piece(on, coefficients) if isinstance(on, PieceMesh) else period_maps(on, coefficients)


def _numbers(mode: Any) -> tuple[float, float, float]:
    return mode.frequency, mode.damping_ratio, mode.mass


def depth_step(milling: Cutter) -> float:
    """Return the largest distance in m of the depths at which chatter is searched for."""
    return _least_critical_depth(milling) / _STEPS


def _least_critical_depth(milling: Cutter) -> float:
    """Return about the least critical depth in m of all speeds."""
    softest = min(2.0 * mode.damping_ratio * (1.0 + mode.damping_ratio) * mode.stiffness for mode in milling.modes)
    return softest / _largest_cutting(milling)


def critical_depths(milling: Cutter, speeds: Floats, most: float | None = None) -> Floats:
    """Return the least depths in m at which chatter begins at speeds in rad/s, infinite where none is found."""
    _require_fast(milling, float(speeds.min()))
    least = _least_critical_depth(milling)
    limit = min(_REACH * least, milling.deepest) if most is None else most
    milling.lag(limit * (1.0 - 1e-12))
    if limit > _FARTHEST * least:
        raise validate.wrong_value(
            "most",
            f"must be at most {_FARTHEST * least:.3g} m, {_FARTHEST:g} times the least critical depth of any speed, "
            f"got {limit:g} m",
        )
    tried = np.linspace(0.0, limit, max(2, math.ceil(limit / least * _STEPS) + 1))
    result = np.full(speeds.size, math.inf)
    for start in range(0, tried.size - 1, _AT_ONCE):  # deep cuts, which take longest, only where needed
        some, left = tried[start : start + _AT_ONCE + 1], np.flatnonzero(np.isinf(result))
        status = judged(milling, np.repeat(speeds[left], some.size), np.tile(some, left.size)).status
        result[left] = _first(milling, speeds[left], some, status.reshape(left.size, some.size))
    return result


def _first(milling: Cutter, speeds: Floats, tried: Floats, status: NDArray[np.int8]) -> Floats:
    """Return the first changes along the depths tried, status (speeds, depths), infinite where there is none."""
    chatter = status != STABLE
    first = chatter.argmax(axis=1)
    low, high = tried[np.maximum(first - 1, 0)], tried[first]
    result = np.where(chatter[:, 0], 0.0, math.inf)
    bracketed = chatter.any(axis=1) & ~chatter[:, 0]
    if bracketed.any():
        result[bracketed] = _crossed(milling, speeds[bracketed], low[bracketed], high[bracketed])
    return result


def _crossed(milling: Cutter, speeds: Floats, low: Floats, high: Floats, precise: float = _PRECISE) -> Floats:
    """Return depths between some at which nothing grows and some at which chatter does: the Illinois method.

    M. Dowell and P. Jarratt, BIT 11 (1971) 168, doi:10.1007/BF01934364.
    """
    ends = [_logs(milling, speeds, low), _logs(milling, speeds, high)]
    before = np.zeros(speeds.size)
    kept = np.zeros(speeds.size)  # which end stayed last: its logarithm counts half the next time
    for _ in range(60):
        wide = np.flatnonzero(high - low > precise * high)
        if not wide.size:
            break
        one, other = ends[0][wide], ends[1][wide]
        straight = one / (one - other)
        share = np.clip(straight, 1e-3, 1.0 - 1e-3)
        middle = low[wide] + (high - low)[wide] * share
        settled = (share == straight) & (np.abs(middle - before[wide]) <= precise * middle) & (precise > _PRECISE)
        before[wide] = middle
        logs = _logs(milling, speeds[wide], middle)
        grows = logs > 0.0
        ends[0][wide] = np.where(grows, np.where(kept[wide] > 0.0, 0.5 * one, one), logs)
        ends[1][wide] = np.where(grows, logs, np.where(kept[wide] < 0.0, 0.5 * other, other))
        low[wide], high[wide] = np.where(grows, low[wide], middle), np.where(grows, middle, high[wide])
        kept[wide] = np.where(grows, 1.0, -1.0)
        low[wide[settled]] = high[wide[settled]] = middle[settled]
        if (np.abs(logs) < 1e-12).all():
            low[wide], high[wide] = middle, middle
            break
    return np.asarray(0.5 * (low + high))


def _logs(milling: Cutter, speeds: Floats, depths: Floats, more: int = _ENOUGH) -> Floats:
    """Return the logarithms of the largest moduli (b,), with more nodes than verdicts begin with."""
    pieces, counts = _resolution(milling, speeds, depths)
    logs = np.empty(speeds.size)
    for each, count in {*zip(pieces.tolist(), counts.tolist(), strict=True)}:
        some = np.flatnonzero((pieces == each) & (counts == count))
        maps = _maps(milling, speeds[some], depths[some], each, count + more)
        logs[some] = np.log(delay_growth.moduli(maps))
    return logs


def lobes_of(milling: Cutter, speed: Any, depth: Any, *, growth: bool, progress: Progress | None) -> Lobes:
    """Return the stability lobes, see `Milling.lobes`."""
    across, up = _axis("speed", speed, read_speed), _axis("depth", depth, read_depth)
    _require_fast(milling, float(across.min()))
    x = Axis("spindle speed", r"\Omega", "rad/s", across)
    y = Axis("depth of cut", "a", "m", up)
    of_chart, of_search = _in_hundredths(across.size * up.size, progress)
    chart = charted(CuttingPlane(milling), x, y, growth=growth, progress=of_chart)
    depths = _first(milling, across, up, np.where(chart.stable, STABLE, UNSTABLE).T)
    lobes = tuple(_named(milling, across, depths, up, of_search))
    if progress is not None:
        progress(100, 100)
    return Lobes(milling, chart.in_units(spindle="rpm", depth="mm"), across, depths, lobes)


def _in_hundredths(points: int, progress: Progress | None) -> tuple[Progress | None, Progress | None]:
    """Return the progress of a chart of so many points and of the search for its lobes, in hundredths of both.

    The number of hundredths never falls, although the search may find that more is left than it expected.
    """
    if progress is None:
        return None, None
    share, most = points / (points + _SEARCH), 0

    def at_least(hundredths: float) -> None:
        nonlocal most
        most = max(most, int(hundredths))
        progress(most, 100)

    return (
        lambda done, total: at_least(100.0 * share * done / total),
        lambda done, total: at_least(100.0 * (share + (1.0 - share) * done / total)),
    )


def _axis(name: str, given: Any, read: Any) -> Floats:
    """Return the values of an axis given as (low, high, number), ends with units."""
    parts = validate.sequence(name, given, '("5000rpm", "10000rpm", 400)')
    if len(parts) != 3:
        raise ValueError(f"{name} must be (low, high, number), got {validate.short(given)}")
    return axis_values(name, (read(parts[0], f"{name}[0]"), read(parts[1], f"{name}[1]"), parts[2]))


class _Onset(NamedTuple):
    """How chatter begins at a speed: the angle of the multiplier, vibrations until teeth repeat, and half ones."""

    kind: Kind
    angle: float
    turns: float
    halves: float


class _Start(NamedTuple):
    """Where chatter begins at a speed: the least depth, 0 or infinite if outside the chart, and how it begins there."""

    speed: float
    depth: float
    onset: _Onset | None

    @property
    def branch(self) -> tuple[str, int]:
        """Kind of the beginning, and between which multiples of pi the angle lies that a vibration turns by."""
        if self.onset is None:
            return ("below" if self.depth == 0.0 else "above"), 0
        halves = self.onset.halves
        return self.onset.kind, math.floor(halves) if self.onset.kind == "Hopf" else round(halves)

    def is_apart(self, other: _Start) -> bool:
        """Return whether another lobe may lie between: neighbours begin in other ways, or their frequencies jump."""
        if self.onset is None or other.onset is None or self.branch != other.branch:
            return self.branch != other.branch
        one, another = self.onset.halves * self.speed, other.onset.halves * other.speed
        return abs(one - another) > _JUMP * max(one, another)


class _Place(NamedTuple):
    """A speed at which a start is searched, first near depths at which neighbours begin."""

    speed: float
    near: tuple[float, float]


_Search = Generator[_Place, _Start, Any]


class _Boundary:
    """The boundary of chatter over spindle speeds, searched over the depths of a chart."""

    def __init__(self, milling: Cutter, tried: Floats) -> None:
        """Keep the depths of rows of a chart, thinned to the step of a search."""
        self.milling = milling
        self.made = 0  # starts searched for
        self.between = 2.0 * math.pi / milling.teeth / milling.cycle  # two teeth, on average
        stride = max(1, int(depth_step(milling) / (tried[1] - tried[0])))
        self.rows = np.append(tried[:-1:stride], tried[-1])

    def name(self, start: _Start) -> tuple[str, int]:
        """Return kind and number of the lobe of a start; of none, whether chatter begins below or above the chart."""
        if start.onset is None:
            return start.branch
        return start.onset.kind, math.floor(start.onset.turns * self.between + _NOT_REAL)

    def start(self, speed: float, depth: float) -> _Start:
        """Return the start at a speed with its critical depth."""
        inside = math.isfinite(depth) and depth > 0.0
        return _Start(speed, depth, _onset(self.milling, speed, depth) if inside else None)

    def starts(self, places: list[_Place]) -> list[_Start]:
        """Return starts at places."""
        depths = np.full(len(places), math.inf)
        left = list(range(len(places)))
        rows = [self._rows(place.near) for place in places]
        low, high = np.zeros(len(places)), np.zeros(len(places))
        while left:
            tried = [rows[i].pop(0) for i in left]
            speeds = np.repeat([places[i].speed for i in left], [each.size for each in tried])
            status = judged(self.milling, speeds, np.concatenate(tried)).status
            ends = np.cumsum([each.size for each in tried])[:-1]
            for i, each, chatter in zip(left, tried, np.split(status != STABLE, ends), strict=True):
                first = int(chatter.argmax())
                if chatter[first] and (first or not rows[i]):
                    depths[i] = each[first] if first else 0.0
                    low[i], high[i], rows[i] = each[max(first - 1, 0)], each[first], []
            left = [i for i in left if rows[i]]
        inner = np.flatnonzero(np.isfinite(depths) & (depths > 0.0))
        if inner.size:
            at = np.array([places[i].speed for i in inner])
            depths[inner] = _crossed(self.milling, at, low[inner], high[inner], _FINE)
        return [self.start(place.speed, depth) for place, depth in zip(places, depths.tolist(), strict=True)]

    def _rows(self, near: tuple[float, float]) -> list[Floats]:
        """Return depths to try one after the other: those beside depths of neighbours, then all."""
        if not all(0.0 < depth < math.inf for depth in near):
            return [self.rows]
        beside = np.multiply.outer(near, 1.0 + _BESIDE * np.array([-1.0, -0.1, 0.1, 1.0])).ravel()
        between = self.rows[(self.rows > _SHALLOW * min(near)) & (self.rows < max(near))]
        return [np.unique(np.minimum(np.concatenate([beside, between]), self.rows[-1])), self.rows]

    def together(self, searches: list[_Search], usual: int, ahead: int, progress: Progress | None) -> list[Any]:
        """Return the results of searches, whose places are judged together.

        ``usual`` starts are expected of each, and ``ahead`` of all searches that follow.
        """
        results: list[Any] = [None] * len(searches)
        answers: dict[int, _Start | None] = dict.fromkeys(range(len(searches)))
        made = np.zeros(len(searches), dtype=int)
        while answers:
            places: dict[int, _Place] = {}
            for i, answer in answers.items():
                try:
                    places[i] = searches[i].send(answer)  # type: ignore[arg-type]  # None begins a search
                except StopIteration as end:
                    results[i] = end.value
            answers = dict(zip(places, self.starts(list(places.values())), strict=True))
            made[list(places)] += 1
            if progress is not None and places:
                left = sum(max(usual - int(made[i]), usual // 3, 1) for i in places)
                self.made += len(places)
                progress(100 * self.made // (self.made + left + ahead), 100)
        return results

    def refined(self, one: _Start, other: _Start, width: float) -> _Search:
        """Return starts between two, halved to a width wherever neighbours are apart.

        Along one curve the angle of a pair of multipliers is continuous: where it passes a multiple of pi the pair is
        real, and halves that keep the multiple between them lead to the flip or fold lobe there.
        """
        if not one.is_apart(other) or other.speed - one.speed <= width:
            return []
        middle = yield _Place(0.5 * (one.speed + other.speed), (one.depth, other.depth))
        before = yield from self.refined(one, middle, width)
        after = yield from self.refined(middle, other, width)
        return [*before, middle, *after]

    def lowest(self, before: _Start | None, members: list[_Start], after: _Start | None) -> _Search:
        """Return where a lobe is lowest, and the error of the depth in m; neighbours are None at ends of the chart."""
        errors: dict[float, float] = {}
        low = min(members, key=lambda start: start.depth)
        for neighbour, inward in ((before, members[:2]), (after, members[:-3:-1])):
            if neighbour is not None and low is inward[0]:
                outward, error = yield from self.end(inward[1] if inward[1:] else None, low, neighbour)
                errors[outward[-1].speed] = error
                members = sorted({*members, *outward})
        low = min(members, key=lambda start: start.depth)
        i = members.index(low)
        if len(members) > 1 and i in (0, len(members) - 1):  # does the depth fall inwards from the end?
            speed = low.speed + _INWARD * (members[1 if i == 0 else -2].speed - low.speed)
            start = yield _Place(speed, (low.depth, low.depth))
            if self.name(start) == self.name(low) and start.depth < low.depth:
                low, members = start, sorted({*members, start})
                i = members.index(low)
        if 0 < i < len(members) - 1:
            low, error = yield from self.valley(members[i - 1], low, members[i + 1])
            errors[low.speed] = error
        return low, max(errors.get(low.speed, 0.0), ACCURACY * low.depth)

    def end(self, inside: _Start | None, inner: _Start, outer: _Start) -> _Search:
        """Return starts of a lobe beyond its last one, up to the crossing with its neighbour, and the last's error."""
        starts, floor = [inner], float(self.rows[0])
        for _ in range(_HALVINGS):
            if 0.0 <= starts[-1].depth - max(outer.depth, floor) <= _END * outer.depth:
                break
            middle = yield _Place(0.5 * (starts[-1].speed + outer.speed), (starts[-1].depth, outer.depth))
            if self.name(middle) == self.name(inner):
                starts.append(middle)
            else:
                outer = middle
        fall = starts[-1].depth - max(outer.depth, floor)
        if starts[1:]:
            change = _AFTER_FOLD * abs(starts[-1].depth - starts[-2].depth)
        else:  # the end is so near that the root of its share of the way is left, at most
            change = _AFTER_FOLD * 0.5 ** (0.5 * _HALVINGS) * abs(inner.depth - inside.depth) if inside else math.inf
        return starts, min(fall, change) if fall >= 0.0 else change

    def valley(self, left: _Start, middle: _Start, right: _Start) -> _Search:
        """Return where a lobe is lowest between two starts, and its error: parabolas through a third one.

        As in Brent's method a step of the golden section follows where a parabola narrowed the bracket by too little,
        and where none is there: beside a start of another lobe that is lower, or above the chart.  Where the bracket
        ends up as narrow as rounding, the depths at its ends bound the error.
        """
        width = math.inf
        for _ in range(_PARABOLAS):
            below, above = middle.speed - left.speed, right.speed - middle.speed
            narrowed, width = below + above < 0.6 * width, below + above
            falls = (left.depth - middle.depth) / below, (right.depth - middle.depth) / above
            bend = sum(falls)
            step = _GOLDEN * above if above > below else -_GOLDEN * below
            if 0.0 < bend < math.inf:
                vertex = 0.5 * (falls[0] * above - falls[1] * below) / bend
                least = _INWARD * (above if vertex >= 0.0 else below)
                if abs(vertex) < least:  # so near that the other side is brought closer, too
                    vertex = 4.0 * least if above > below else -4.0 * least * below / max(below, above)
                middle_fall = bend * vertex * vertex / (above + below)
                if abs(vertex) <= 4.0 * least and middle_fall < 0.1 * ACCURACY * middle.depth:
                    return middle, 0.0
                if narrowed:
                    step = min(max(vertex, -0.9 * below), 0.9 * above)
            elif math.isfinite(bend) and _depth_beside(left, middle, right) < 0.1 * ACCURACY * middle.depth:
                break
            speed = middle.speed + step
            if speed in (left.speed, middle.speed, right.speed):
                break
            start = yield _Place(speed, (middle.depth, middle.depth))
            lower = self.name(start) == self.name(middle) and start.depth < middle.depth
            if lower:
                left, middle, right = (left, start, middle) if step < 0.0 else (middle, start, right)
            elif step < 0.0:
                left = start
            else:
                right = start
        return middle, _depth_beside(left, middle, right)


def _depth_beside(left: _Start, middle: _Start, right: _Start) -> float:
    """Return by how much depths differ at the ends of a bracket in which a lobe is lowest, in m.

    The least depth of the lobe lies that near to the depth in the middle: it is no lower than another lobe beside it.
    Of an end above the chart nothing is known; where both are, the least depth may be anywhere below the middle.
    """
    beside = [abs(end.depth - middle.depth) for end in (left, right) if math.isfinite(end.depth)]
    return max(beside, default=middle.depth)


def _named(
    milling: Cutter, speeds: Floats, depths: Floats, tried: Floats, progress: Progress | None = None
) -> list[Lobe]:
    """Return the lobes of a chart: neighbours that begin in one way, with as many whole vibrations."""
    boundary = _Boundary(milling, tried)
    columns = [boundary.start(*column) for column in zip(speeds.tolist(), depths.tolist(), strict=True)]
    width = edge_width(speeds)
    neighbours = list(pairwise(columns))
    halvings = math.ceil(math.log2(float(speeds[1] - speeds[0]) / width)) + 1
    changes = sum(one.is_apart(other) for one, other in neighbours)
    between = boundary.together(
        [boundary.refined(one, other, width) for one, other in neighbours], halvings, _USUAL * (changes + 1), progress
    )
    starts = columns[:1]
    for inner, column in zip(between, columns[1:], strict=True):
        starts += [*inner, column]
    groups = [list(group) for _, group in itertools.groupby(starts, key=boundary.name)]
    before = [None, *(group[-1] for group in groups[:-1])]
    after = [*(group[0] for group in groups[1:]), None]
    ends = zip(before, groups, after, strict=True)
    chattering = [end for end in ends if end[1][0].onset is not None]
    lobes = []
    lowest = boundary.together([boundary.lowest(*end) for end in chattering], _USUAL, 0, progress)
    for (_, members, _), (low, error) in zip(chattering, lowest, strict=True):
        kind, number = low.onset.kind, boundary.name(low)[1]
        edges = min(members[0].speed, low.speed), max(members[-1].speed, low.speed)
        frequency = low.onset.turns * 2.0 * math.pi * low.speed / milling.cycle
        lobes.append(Lobe(kind, number, edges, low.depth, low.speed, frequency, error))
    return lobes


def edge_width(speeds: Floats) -> float:
    """Return how far in rad/s edges of lobes may lie beyond their ends, over columns at some speeds."""
    return min(float(speeds[1] - speeds[0]), _NARROWEST * float(speeds[-1]))


def _onset(milling: Cutter, speed: float, depth: float) -> _Onset:
    """Return how chatter begins at a speed and its critical depth."""
    speeds, depths = np.array([speed]), np.array([depth])
    pieces, count = (int(each[0]) for each in _resolution(milling, speeds, depths))
    count += _ENOUGH
    lag = milling.lag(depth)
    values, vectors = np.linalg.eig(_maps(milling, speeds, depths, pieces, count)[0])
    leading = int(np.abs(values).argmax())
    angle = abs(float(np.angle(values[leading])))
    kind: Kind = "fold" if angle < _NOT_REAL else "flip" if math.pi - angle < _NOT_REAL else "Hopf"
    vector = vectors[:, leading] if values[leading].imag >= 0.0 else vectors[:, leading].conj()
    turns, halves = _turns(milling, vector, angle, speed, _cut(milling, pieces, count, lag).mesh)
    return _Onset(kind, angle, turns, halves)


def _turns(milling: Cutter, vector: Complexes, angle: float, speed: float, on: Mesh | PieceMesh) -> tuple[float, float]:
    """Return how often a solution vibrates until teeth repeat: of angle / 2 pi + k one that is strong in it.

    In deep cuts, which vary stiffness as much as the tool has, several are about as strong.  The one nearest to a
    natural frequency names the lobe, so that lobes of neighbouring speeds are numbered one after the other.
    """
    n, touched = len(milling.modes), np.asarray(on.kept, dtype=np.intp)
    count = len(on.nodes) // (len(on.breaks) - 1)
    kept, breaks = count + 2, np.asarray(on.breaks)
    values = vector[2 * n :][: touched.size * kept * n].reshape(-1, kept, n)
    times = breaks[touched, None] + np.diff(breaks)[touched, None] * (0.5 + 0.5 * chebyshev_points(kept))
    weights = np.sin(math.pi * np.arange(kept) / (kept - 1)) * np.diff(breaks)[touched, None]
    most = math.ceil(0.3 * len(on.nodes))  # more turns the nodes would not resolve
    tried = angle / (2.0 * math.pi) + np.arange(-most, most)
    waves = np.exp(-2j * math.pi * tried[:, None, None] * times)
    strength = np.square(np.abs(np.einsum("kpt,pt,ptn->kn", waves, weights, values))).sum(axis=1)
    natural = np.array([mode.frequency for mode in milling.modes]) * milling.cycle / (2.0 * math.pi * speed)
    away = np.abs(np.abs(tried)[:, None] - natural).min(axis=1)
    named = int(np.where(strength >= _STRONG * strength.max(), away, math.inf).argmin())
    turns = abs(float(tried[named]))
    # a pair turns by angle and -angle: beside a multiple of pi the stronger one tells on which side the solution is
    middle = 0.5 * round(2.0 * turns)
    mirrored = int(np.abs(tried + math.copysign(2.0 * middle - turns, tried[named])).argmin())
    strongest = turns if strength[named] >= strength[mirrored] else 2.0 * middle - turns
    return turns, 2.0 * strongest


def _rpm(speed: float) -> float:
    return 30.0 * speed / math.pi
