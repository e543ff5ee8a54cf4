"""Charts filled a few rows at a time, so that scratch memory stays small and Ctrl-C works."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.version import __version__
from floquetrod.plane.axes import Axis, require_bearable
from floquetrod.plane.chart import BandSource, Chart, Progress
from floquetrod.plane.judging import VERTEX, Judge, Namer
from floquetrod.plane.tracing import TracedBands

_AT_ONCE = 1 << 18  # points computed between two reports of progress: about a megabyte an array


def fill_rows(
    compute: Callable[[NDArray[np.float64]], Sequence[NDArray[Any]]],
    y: NDArray[np.float64],
    columns: int,
    dtypes: Sequence[Any],
    progress: Progress | None,
    rows_at_once: int | None = None,
) -> list[NDArray[Any]]:
    """Compute arrays of ``len(y)`` rows a few rows at a time, so that scratch memory stays small and Ctrl-C works."""
    require_bearable(y.size * columns, "the number of points")
    results = [np.empty((y.size, columns), dtype=dtype) for dtype in dtypes]
    rows = rows_at_once or max(1, _AT_ONCE // columns)
    for start in range(0, y.size, rows):
        for result, piece in zip(results, compute(y[start : start + rows, None]), strict=True):
            result[start : start + rows] = piece
        if progress is not None:
            progress(min(y.size, start + rows) * columns, y.size * columns)
    return results


def charted(
    x: Axis,
    y: Axis,
    classify: Callable[[NDArray[np.float64]], Sequence[NDArray[Any]]],
    *,
    growth: bool,
    growth_tolerance: float,
    growth_unit: str,
    subject: Callable[[], dict[str, Any]],
    criterion: str = "",
    rows_at_once: int | None = None,
    progress: Progress | None,
    source: BandSource | None = None,
    judge: Judge | None = None,
    quick: Judge | None = None,
    prompt: bool = True,
    name: Namer | None = None,
    vertex: float = VERTEX,
) -> Chart:
    """Return the chart of verdicts that ``classify`` computes, a few rows at a time.

    Parameters
    ----------
    classify : callable (values of y, one a row) -> (status, growth rate)
        Status 1 where stable, 0 where not, -1 where undecided.
    subject : callable () -> dict
        What is charted, asked when all is classified.
    growth, growth_tolerance, growth_unit, criterion
        As in `Chart`; whether to keep growth rates.
    source : callable, optional
        What finds the bands of the chart.
    judge : callable (x (n,), y (n,)) -> (status, growth rate), optional
        What judges any points; in place of a source, it lets the bands be traced.
    quick, name : callable, optional
    prompt, vertex
        As in `TracedBands`.
    """
    kinds = np.int8, np.float64
    status, rate = fill_rows(classify, y.values, x.values.size, kinds, progress, rows_at_once)
    if judge is not None:
        source = TracedBands(
            judge,
            x,
            y,
            status == 0,
            growth_unit,
            growth_tolerance,
            quick=quick,
            vertex=vertex,
            prompt=prompt,
            name=name,
        )
    return Chart(
        x,
        y,
        status == 1,
        rate if growth else None,
        None,
        growth_unit,
        subject(),
        growth_tolerance,
        criterion,
        int((status < 0).sum()),
        __version__,
        source,
    )
