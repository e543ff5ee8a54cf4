"""Outlines of tongues as the bands of a chart."""

from __future__ import annotations

from floquetrod._util.arrays import Ints
from floquetrod._util.progress import Progress
from floquetrod.mathieu.tongue_curves import Window
from floquetrod.mathieu.tongue_regions import UndampedEquations, unstable_regions
from floquetrod.plane import Band, FoundBands


def tongue_bands(
    oscillators: UndampedEquations,
    window: Window,
    across: str,
    accuracy: float,
    progress: Progress | None,
    *,
    modes: Ints | None,
) -> FoundBands:
    """Return the bands of all tongues, found by counts, so that none is missed.

    Parameters
    ----------
    oscillators, window, accuracy, progress
        As in `unstable_regions`.
    across : str
        The quantity along the horizontal axis of the chart.
    modes : ndarray of int or None
        The numbers of the modes that the oscillators are.
    """
    regions = unstable_regions(oscillators, window, accuracy, progress)
    shapes = regions.outlines
    ends = shapes.size.cumsum()
    lines_across = across == window.over  # x tells one line from the next
    bands = []
    for i, (start, end) in enumerate(zip((ends - shapes.size).tolist(), ends.tolist(), strict=True)):
        line, place = shapes.line[start:end], shapes.place[start:end]
        peak = float(shapes.peak[i, 0]), float(shapes.peak[i, 1])
        bands.append(
            Band(
                line if lines_across else place,
                place if lines_across else line,
                None if modes is None else int(modes[regions.which[i]]),
                int(regions.order[i]),
                float(shapes.growth[i]) - oscillators.damping,
                peak if lines_across else peak[::-1],
            )
        )
    return FoundBands(tuple(bands), regions.tongues_left_out, accuracy, (0.0, 0.0))
