"""Charts of a family, filled a few rows or columns at a time, so that scratch memory stays small and Ctrl-C works."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.progress import Progress
from floquetrod._util.version import __version__
from floquetrod.plane.chart import Chart
from floquetrod.plane.family import Family
from floquetrod.plane.plane_axes import Axis, require_bearable
from floquetrod.plane.sources import FamilyBands


def charted(family: Family, x: Axis, y: Axis, *, growth: bool = False, progress: Progress | None = None) -> Chart:
    """Return the chart of a family over a plane.

    Parameters
    ----------
    family : Family
    x, y : Axis
        Columns and rows.
    growth : bool
        Whether to keep growth rates, and the modes that grow fastest where there are modes.
    progress : callable, optional
        Called with the numbers of points done and to do.
    """
    rows, columns = y.values.size, x.values.size
    require_bearable(rows * columns, "the number of points")
    kept: dict[str, NDArray[Any]] = {"status": np.empty((rows, columns), dtype=np.int8)}
    if growth:
        kept |= {"growth": np.empty((rows, columns)), "mode": np.empty((rows, columns), dtype=np.int64)}
    lines, length = (columns, rows) if family.by_columns else (rows, columns)
    together = max(1, family.points_at_once // length)
    for start in range(0, lines, together):
        part, every = slice(start, start + together), slice(None)
        place = (every, part) if family.by_columns else (part, every)
        verdicts = family.verdicts(x.values[place[1]], y.values[place[0], None], growth=growth)
        if verdicts.mode is None:
            kept.pop("mode", None)
        for name, array in kept.items():
            array[place] = getattr(verdicts, name)
        if progress is not None:
            progress(min(lines, start + together) * length, rows * columns)
    status = kept["status"]
    return Chart(
        x,
        y,
        status == 1,
        kept.get("growth"),
        kept.get("mode"),
        family.growth_unit,
        family.subject(),
        family.growth_tolerance,
        family.criterion,
        int((status < 0).sum()),
        __version__,
        FamilyBands(family, x, y, status),
    )
