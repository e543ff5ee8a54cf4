"""The explorer: a load moved by sliders; map, modes, growth, verdict and command follow."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from floquetrod import units as known
from floquetrod._util import validate
from floquetrod.explorer.background import Background, Stale, ViewParts
from floquetrod.explorer.commands import command
from floquetrod.explorer.limits import Scale, step
from floquetrod.explorer.verdict_words import margin_words
from floquetrod.explorer.view import View
from floquetrod.floquet.margins import Margin
from floquetrod.plotting.explorer_page import ExplorerWindow
from floquetrod.rod.answers.reports import shown_in
from floquetrod.rod.loads.load import QUANTITIES, AnyLoad, Load, require_load
from floquetrod.rod.rod import Rod


class Explorer:
    """A rod under a load that can be moved.

    Longer computations (curves in place of points, margins, coupled modes) run while the sliders rest, and their
    results are shown as they arrive.

    Parameters
    ----------
    rod : Rod
    load : AxialLoad, AxialWave or ForceRecord, optional
        Where to begin; by default a sine of 0.2 critical forces of both kinds at three times the pendulum frequency, of
        a short rod 0.2 of its buckling force at three times the frequency of its first mode.  At most 50 such forces,
        and between a thousandth of that frequency and a thousand times it.  Waveform and axial waves stay as they are.
    units : mapping, optional
        Units of axes and sliders, by quantity: ``{"mean": "Fcr", "frequency": "Hz"}``; by default N and rad/s.
    options : sequence of str, optional
        Options of the terminal that name the rod, and the measured force if there is one, for `command`:
        ``["--rod", "my_rod.toml"]``.

    Attributes
    ----------
    window : floquetrod.plotting.explorer_page.ExplorerWindow
        The figure and its sliders.
    load : AxialLoad or AxialWave
        The load shown.

    Raises
    ------
    TypeError, ValueError
        For loads out of range, and for unknown units.
    """

    def __init__(
        self,
        rod: Rod,
        load: AnyLoad | None = None,
        units: Mapping[str, str] | None = None,
        *,
        options: Sequence[str] | None = None,
    ) -> None:
        """Open the window."""
        self.rod = validate.instance("rod", rod, Rod)
        scale = Scale.of(rod)
        self._units = _units(rod, {} if units is None else units)
        self.load: Load = scale.first_load(self._units) if load is None else require_load("load", load)
        scale.require(self.load)
        if self.load.noise or self.load.second is not None:
            raise rod._modes_under(self.load).refusal("load")
        self._options = options
        limits = _rounded(scale.limits(self.load), self._units)
        self._view = View(rod, self.load, limits)
        self._background = Background()
        self._margins: dict[str, Margin] = {}
        steps = {name: step(*(unit.of(end) for end in limits[name])) for name, unit in self._units.items()}
        first = self._at_once()
        self.window = ExplorerWindow(
            limits,
            self._units,
            steps,
            self._view.panels,
            rod.length,
            first["load"],
            self._moved,
            self._begin,
            self._fetched,
        )
        self.window.show(first)
        self.window.when_closed(self._background.stop)

    @property
    def command(self) -> str:
        """The command that checks exactly this load, the terminal's, or Python's where the terminal has no name for it.

        >>> import matplotlib
        >>> matplotlib.use("agg")
        >>> Explorer(Rod.nitinol(), None, {"mean": "Fcr", "amplitude": "Fcr", "frequency": "rad/s"}).command[:47]
        'floquetrod check --rod nitinol --mean 0.2Fcr --'
        """
        return command(self.rod, self.load, self._units, self._options)

    def refine(self) -> None:
        """Compute and show at once what a window computes while its sliders rest: for pictures, and without a window.

        Some tenths of a second where modes are independent, up to minutes where they are coupled.
        """
        for parts in self._background.run(self._in_time):
            self.window.show(self._with_margins(parts))
        self.window.show({"busy": False})

    def _at_once(self) -> ViewParts:
        numbers = {name: getattr(self.load, name) for name in self._units}
        return self._view.at_once(self.load) | {"load": numbers, "command": self.command}

    def _in_time(self, stale: Stale) -> Iterator[ViewParts]:
        return self._view.in_time(self.load, stale)

    def _moved(self, name: str, value: float) -> ViewParts:
        """Return the panels shown at once when a quantity, in SI units, has been moved, and start on the rest."""
        numbers = {each: getattr(self.load, each) for each in self._units} | {name: value}
        self.load = self.load.with_numbers(**numbers)
        self._margins = {}
        parts = self._at_once()
        if self.window.is_live:
            self._begin()
            parts["busy"] = True
        return parts

    def _begin(self) -> None:
        self._background.start(self._in_time)

    def _fetched(self) -> ViewParts:
        """Return the panels finished since the last call, and whether more are to come."""
        finished, busy = self._background.fetch()
        parts: ViewParts = {}
        for each in finished:
            parts |= self._with_margins(each)
        return parts | {"busy": busy}

    def _with_margins(self, parts: ViewParts) -> ViewParts:
        """Return the same parts, a margin in words and together with those found before it."""
        if "margin" not in parts:
            return parts
        name, margin = parts["margin"]
        self._margins[name] = margin
        return {"details": margin_words(self._margins, self.load, self._units)}


def _rounded(limits: dict[str, tuple[float, float]], units: dict[str, known.Unit]) -> dict[str, tuple[float, float]]:
    """Return limits moved outwards to whole steps of their sliders."""
    rounded = {}
    for name, (low, high) in limits.items():
        unit = units[name]
        size = step(unit.of(low), unit.of(high))
        first, last = math.floor(unit.of(low) / size + 1e-9), math.ceil(unit.of(high) / size - 1e-9)
        # A frequency is never zero.
        rounded[name] = (float(unit.si(first * size)) if first or not low else low, float(unit.si(last * size)))
    return rounded


def _units(rod: Rod, names: Mapping[str, str]) -> dict[str, known.Unit]:
    if isinstance(names, Mapping) and not names.keys() <= {*QUANTITIES}:
        raise validate.wrong_value("units", f"must be of mean, amplitude and frequency, got {dict(names)!r}")
    shown = shown_in(names, rod)
    return {name: shown[name] for name in QUANTITIES}
