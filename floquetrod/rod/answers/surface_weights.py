"""The weight of a string at the surface while it is picked up and slacked off, over the depth of its lower end."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.content import ByContent
from floquetrod._util.interchange import by_keys, plain
from floquetrod._util.result_report import Printed, Report, Table
from floquetrod.rod.answers.assembly import added_by, at_the_wellhead
from floquetrod.rod.answers.mean_force import ASSUMED, drag_of, force_in_newtons
from floquetrod.rod.answers.pushing import LOCK_UP, STATICS, Pushing
from floquetrod.rod.answers.string_reach import depths_of, far, weight_in_words
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.wellhead import Wellhead
from floquetrod.units import AnswerUnits, GivenUnits, InUnits
from floquetrod.wells import strings
from floquetrod.wells.drag import CHECKED, FRICTIONLESS, Drag, Friction
from floquetrod.wells.path import WellPath

_MOST_FACTORS = 12  # of friction (a choice: a chart of more cannot be read)
_ROWS = 12  # of the table


@dataclass(frozen=True, eq=False, repr=False)
class SurfaceWeights(Printed, ByContent, InUnits):
    """Pick-up and slack-off weights of a string over the depth of its lower end, for some factors of friction.

    Weights are what the hook or the injector carries, negative where it has to push.

    Attributes
    ----------
    path : WellPath
    depth : ndarray (n,)
        Measured depths of the lower end in m.
    friction : tuple of Friction
        Of the wall, one for each factor: coefficients, each from a measured depth in m on.
    pick_up : ndarray (m, n)
        Weights in N of a string pulled up, for each factor of friction.
    slack_off : ndarray (m, n)
        Weights in N of a string lowered or pushed down; minus infinite from the depth on at which it locks up.
    free : ndarray (n,)
        Weight in N of a string without friction, as of one that is rotated off the bottom.
    lock_up : ndarray (m,)
        Measured depth in m at which no push moves the lower end, as `Reach.lock_up`; infinite where it does not lock
        up, down to the deepest asked for.
    far_force : float
        Compression in N at the lower end.
    wellhead : Wellhead
        Pressure in Pa at the wellhead and friction of its stripper in N.
    wellhead_forces : tuple of float
        Push in N that these take at the injector, of a string that is picked up and of one that is slacked off.
    weight_per_length : float
        Weight of the string in its fluids in N/m.
    fluids : tuple of float
        Densities in kg/m^3 of the fluids inside and outside, 0 for none.
    error : float
        Estimated error of the weights in N, of the integration alone.
    """

    path: WellPath
    depth: Floats
    friction: tuple[Friction, ...]
    pick_up: Floats
    slack_off: Floats
    free: Floats
    lock_up: Floats
    far_force: float
    wellhead: Wellhead
    wellhead_forces: tuple[float, float]
    weight_per_length: float
    fluids: tuple[float, float]
    error: float

    def _in_words(self, shown: AnswerUnits) -> str:
        """Return the answer: the weights at the deepest depth."""
        deepest, force = f"{far(self.depth[-1], shown.length)} {shown.length.name}", shown.force
        weights = []
        for k, factor in enumerate(self.friction):
            text = f"{force.show(self.pick_up[k, -1], 4)} picked up, "
            if math.isfinite(self.lock_up[k]):
                text += f"slacked off it locks up at {far(self.lock_up[k], shown.length)} {shown.length.name}"
            else:
                text += f"{force.show(self.slack_off[k, -1], 4)} slacked off"
            weights.append(f"with friction {factor.in_words(shown.length)}: {text}")
        free = f"{force.show(self.free[-1], 4)} without friction"
        return f"What does the string weigh at {deepest}? {free}; {'; '.join(weights)}."

    def report(self, depth: str | None = None, force: str | None = None) -> Report:
        """Return the weights at the deepest depth, and a table of them; in the units of the question or those named.

        Parameters
        ----------
        depth : str, optional
            Unit of depths, such as "ft"; by default as in the question, see `floquetrod.units.AnswerUnits`, else m.
        force : str, optional
            Unit of forces, such as "lbf", else kN.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.

        Raises
        ------
        TypeError, ValueError
            For another unit.
        """
        shown = self._units(depth, force)
        lines = [("string", weight_in_words(self.weight_per_length, self.fluids, shown))]
        if any(self.wellhead_forces):
            up, down = (shown.force.show(push, 4) for push in self.wellhead_forces)
            lines.append(("wellhead", f"pressure and stripper take {up} of push in pick-up, {down} in slack-off"))
        return Report(self._in_words(shown), lines, self._table(shown), assumptions=self.assumptions)

    def _units(self, depth: str | None, force: str | None) -> AnswerUnits:
        def argument(name: str) -> str:
            return {"length": "depth"}.get(name, name)

        return AnswerUnits.named(force, depth, what=argument, given=self.given_units, usual_force="kN")

    def _table(self, shown: AnswerUnits) -> Table:
        unit = shown.force
        columns = [(f"depth {shown.length.name}", ">9"), (f"free {unit.name}", ">10")]
        for factor in self.friction:
            name = "/".join(f"{value:g}" for value in factor.values)
            columns += [(f"pick-up {unit.name}, {name}", ">10"), (f"slack-off {unit.name}, {name}", ">12")]
        rows = np.unique(np.linspace(0, self.depth.size - 1, _ROWS).round().astype(int))
        digits = max(0, round(math.log10(unit.size / 10.0)))

        def text(weight: float) -> str:
            return f"{unit.of(weight):.{digits}f}" if math.isfinite(weight) else "locked"

        every = []
        for k in rows.tolist():
            both = [text(column[k]) for pair in zip(self.pick_up, self.slack_off, strict=True) for column in pair]
            every.append([f"{shown.length.of(self.depth[k]):.0f}", text(self.free[k]), *both])
        return Table(columns, every)

    @property
    def assumptions(self) -> tuple[str, ...]:
        """Assumptions of the weights."""
        return (*ASSUMED[:-1], "the hook or the injector carries the string alone: no blocks, no tension of a reel")

    def plot(self, ax: Any = None, *, depth: str | None = None, force: str | None = None) -> Any:
        """Draw the weights over the depth, which grows downwards.

        Parameters
        ----------
        ax : Axes, optional
            By default the axes of a new figure.
        depth : str, optional
            Unit of depths, as in `report`.
        force : str, optional
            Unit of forces, as in `report`.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.

        Raises
        ------
        TypeError, ValueError
            For another unit.
        """
        from floquetrod.plotting.weights_plot import draw_weights

        return draw_weights(self, self._units(depth, force), ax)

    def as_dict(self) -> dict[str, Any]:
        """Return everything as numbers for JSON, units in the keys; a row of ``weights`` for each factor and depth.

        None where a weight is infinite.

        Returns
        -------
        dict of str
            Numbers, texts and lists by name.
        """
        rows = [
            {"friction": str(factor), "depth_m": depth, "pick_up_N": up, "slack_off_N": down, "free_N": free}
            for factor, ups, downs in zip(self.friction, self.pick_up, self.slack_off, strict=True)
            for depth, up, down, free in zip(self.depth, ups, downs, self.free, strict=True)
        ]
        keys = "lock_up_m far_force_N wellhead wellhead_forces_N weight_N_per_m=weight_per_length "
        rest = by_keys(self, keys + "fluids_kg_per_m3=fluids error_N assumptions")
        return {"weights": plain(rows), "friction": [str(factor) for factor in self.friction], **rest}


def surface_weights(
    rod: RodData, path: Any, friction: Any, far_force: Any, depth: Any, helical: Any, wellhead: Wellhead
) -> SurfaceWeights:
    """Return pick-up and slack-off weights; see `floquetrod.Rod.surface_weights`."""
    # The weight at the wellhead is minus the force at the upper end of a string that hangs to each depth, by one march
    # of y a motion: pulled, pushed, and standing without friction; once with the fine steps and once with the rough
    # ones, whose difference is the error.  Pick-up and slack-off (factors, depths) in N. Slack-off is minus infinity
    # below the depth at which the string locks up.
    factors = factors_of(friction)
    lowered = [drag_of(rod, path, factor, "pushed", helical, None, None) for factor in factors]
    compression, depths = force_in_newtons("far_force", far_force), depths_of(rod, path, depth)
    pushes = [Pushing(rod, drag, compression).reached(float(depths[-1]), STATICS) for drag in lowered]
    lock_up = np.array([reached.depth if reached.limit == LOCK_UP else math.inf for reached in pushes])

    def weights(drag: Drag, motion: str) -> tuple[Floats, Floats]:
        """Return the weights and their errors in N at all depths."""
        moved = replace(drag, motion=motion)
        ends = (strings.run(moved, path.start, depths, compression, np.empty(0), effort) for effort in CHECKED)
        fine, rough = (-moved.force(run.top_y) - added_by(wellhead, rod, moved, depths) for run in ends)
        return fine, np.abs(np.subtract(fine, rough, out=np.zeros(depths.size), where=np.isfinite(fine + rough)))

    free, free_error = weights(replace(lowered[0], friction=FRICTIONLESS), "standing")
    pick_up, up_error = np.transpose([weights(drag, "pulled") for drag in lowered], (1, 0, 2))
    slack_off, down_error = np.transpose([weights(drag, "pushed") for drag in lowered], (1, 0, 2))
    goes = depths <= lock_up[:, None]
    given, section = GivenUnits.of(length=depth, force=far_force), at_the_wellhead(rod, lowered[0], float(depths[-1]))
    return SurfaceWeights(
        path=path,
        depth=depths,
        friction=tuple(drag.friction for drag in lowered),
        pick_up=pick_up,
        slack_off=np.where(goes, slack_off, -math.inf),
        free=free,
        lock_up=lock_up,
        far_force=compression,
        wellhead=wellhead,
        wellhead_forces=(wellhead.added(section, "pulled"), wellhead.added(section, "pushed")),
        weight_per_length=rod.weight_per_length,
        fluids=(rod.fluids.inside, rod.fluids.outside),
        error=float(max(free_error.max(), up_error.max(), down_error[goes].max(initial=0.0))),
    ).given_in(given.or_else(wellhead.given_units, path.given_units, rod.given_units))


def factors_of(given: Any) -> list[Any]:
    """Return factors of friction, each as `mean_force.friction_along` takes it: one alone, or several in a list.

    Pairs of a depth and a coefficient are one factor, by depth.
    """
    is_sequence = isinstance(given, list | tuple)
    if not is_sequence and not (isinstance(given, np.ndarray) and given.ndim):
        return [given]
    if is_sequence and given and all(_is_pair(factor) for factor in given):
        return [given]
    if not 1 <= len(given) <= _MOST_FACTORS:
        raise validate.wrong_value(
            "friction", f"must be 1 to {_MOST_FACTORS} factors such as [0.2, 0.3, 0.4], got {len(given)}"
        )
    return [factor.item() if isinstance(factor, np.generic) else factor for factor in given]


def _is_pair(factor: Any) -> bool:
    return isinstance(factor, list | tuple) and not any(isinstance(part, list | tuple) for part in factor)
