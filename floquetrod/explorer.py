"""The explorer: a load moved by sliders, its map, modes, growth rates and verdict following live."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from floquetrod import mathieu
from floquetrod import units as known
from floquetrod._util import validate
from floquetrod.plotting.explorer import View, Window
from floquetrod.rod.load import AxialLoad, kind
from floquetrod.rod.map import stability_map
from floquetrod.rod.rod import Rod

_MAP = 120, 90  # columns and rows of the map: a few milliseconds
_CHART = 160, 120
_STRONGEST = 50.0  # critical forces of mean and amplitude (a choice)
_SLOWEST = 1000.0  # times slower than the pendulum, and faster (a choice)
_MODES = 14  # shown on the chart and as bars; the verdict looks at all that matter


class Explorer:
    """A rod under a load that can be moved.

    Parameters
    ----------
    rod : Rod
    load : AxialLoad, optional
        Where to begin; by default 0.2 critical forces of both kinds at three times the pendulum frequency.  At most
        50 critical forces, and between a thousandth of the pendulum frequency and a thousand times it.
    units : mapping, optional
        Units that axes and sliders speak, by quantity: ``{"mean": "Fcr", "frequency": "Hz"}``; by default N and rad/s.

    Attributes
    ----------
    window : floquetrod.plotting.explorer.Window
        The figure and its sliders.
    load : AxialLoad
        The load shown.

    Raises
    ------
    TypeError, ValueError
        For rods and loads whose modes are coupled, by ends that are not hinged or by weight along the rod say, for
        other loads than sines, and for loads and units out of reach.
    """

    def __init__(self, rod: Rod, load: AxialLoad | None = None, units: Mapping[str, str] | None = None) -> None:
        """Open the window."""
        validate.instance("rod", rod, Rod)
        if load is not None:
            validate.instance("load", load, AxialLoad)
        _require_independent(rod, load)
        shown = _units(rod, {} if units is None else units)
        unit, pendulum = rod.critical_force, rod.pendulum_frequency
        self.rod = rod
        self.load = load or AxialLoad(0.2 * unit, 0.2 * unit, 3.0 * pendulum)
        # Beyond these limits the map takes too long for interactive use.
        for name in ("mean", "amplitude"):
            force = getattr(self.load, name)
            validate.within(name, force, -_STRONGEST * unit, _STRONGEST * unit, "these are in N")
        slowest, fastest = pendulum / _SLOWEST, pendulum * _SLOWEST
        validate.within("frequency", self.load.frequency, slowest, fastest, "these are in rad/s")
        self._limits = {
            "mean": (0.0, max(1.1 * unit, self.load.mean)),
            "amplitude": (0.0, max(0.7 * unit, self.load.amplitude)),
            "frequency": (min(0.4 * pendulum, self.load.frequency), max(5.0 * pendulum, self.load.frequency)),
        }
        start = {"mean": self.load.mean, "amplitude": self.load.amplitude, "frequency": self.load.frequency}
        self._amplitude = float("nan")
        self.window = Window(self._limits, shown, self.view(start), self.view)

    def view(self, quantities: dict[str, float]) -> View:
        """Return what the window shows for a load: mean and amplitude in N, frequency in rad/s."""
        self.load = AxialLoad(quantities["mean"], quantities["amplitude"], quantities["frequency"])
        if self.load.amplitude != self._amplitude:
            self._amplitude = self.load.amplitude
            self._unstable = ~stability_map(
                self.rod,
                mean=(*self._limits["mean"], _MAP[1]),
                amplitude=self._amplitude,
                frequency=(*self._limits["frequency"], _MAP[0]),
            ).stable
        system = self.rod.independent_modes(self.load, range(1, _MODES + 1))
        alpha, beta, damping = system.alpha, system.beta, system.damping
        growth = mathieu.growth_rate(alpha, beta, damping) * self.load.frequency
        # In steps, so that the axes stay as they are for most moves.
        right = 0.1 * 2.0 ** math.ceil(math.log2(max(12.0 * float(alpha[-1]), 1.0)))
        bottom = -1.1 * 1.5 ** math.ceil(math.log(max(-float(beta.min()), 1.0)) / math.log(1.5))
        top = 0.3 * 2.0 ** math.ceil(math.log2(max(4.0 * float(beta.max()), 1.0)))
        chart_alpha, chart_beta = np.linspace(0.0, right, _CHART[0]), np.linspace(bottom, top, _CHART[1])
        chart = ~mathieu.is_stable(chart_alpha, chart_beta[:, None], damping)
        rate, mode = self.rod.fastest(self.load.mean, self.load.amplitude, self.load.frequency)
        verdict = f"unstable: mode {mode} grows at {rate:.3g} 1/s" if rate > 0.0 else "stable"
        return View(quantities, self._unstable, chart, (0.0, right), (bottom, top), alpha, beta, growth, verdict)


def _require_independent(rod: Rod, load: AxialLoad | None) -> None:
    """Raise ValueError for a rod or a load whose modes the window cannot show."""
    given = [kind(None)] if load is None else [kind(None), load]
    found = dict.fromkeys(name for each in given for name in rod.coupled_numbers.departures(each))
    if found:
        raise ValueError(
            f"rod must have independent modes to be explored, those of hinged ends under a sine that is uniform along "
            f"the rod, got {', '.join(found)}; Rod.stability and stability_map take it"
        )


def _units(rod: Rod, names: Mapping[str, str]) -> dict[str, known.Unit]:
    kinds = {"mean": "force", "amplitude": "force", "frequency": "frequency"}
    if not isinstance(names, Mapping):
        raise TypeError(f"units must be a mapping such as {{'mean': 'Fcr'}}, got {validate.short(names)}")
    if not names.keys() <= kinds.keys():
        raise ValueError(f"units must be of mean, amplitude and frequency, got {dict(names)!r}")
    return {
        name: known.unit(names.get(name, ""), f"units[{name!r}]", kind, rod.critical_force)
        for name, kind in kinds.items()
    }
