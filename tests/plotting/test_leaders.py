"""Labels beside the points they name."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from floquetrod.plotting.labels import nearest_room, take
from floquetrod.plotting.leaders import add_leaders


@pytest.mark.parametrize("seed", range(20))
def test_a_label_stands_in_the_nearest_room(seed: int) -> None:
    """Among all rectangles of its size that cover nothing no other is nearer to the point."""
    rng = np.random.default_rng([50, seed])
    free = rng.random((24, 30)) < 0.93
    point, size = rng.uniform([0, 0], [29, 23]), rng.uniform([1.0, 1.0], [6.0, 4.0])
    w, h = np.ceil(size).astype(int)
    distances = {}
    for row in range(24 - h + 1):
        for column in range(30 - w + 1):
            if free[row : row + h, column : column + w].all():
                across = max(column - point[0], point[0] - (column + w - 1), 0.0)
                distances[column, row] = np.hypot(across, max(row - point[1], point[1] - (row + h - 1), 0.0))
    middle = nearest_room(free, point, size)
    assert middle is not None
    corner = tuple((middle - 0.5 * (np.array([w, h]) - 1)).round().astype(int).tolist())
    assert distances[corner] <= min(distances.values()) + 0.05  # half its size decides between equals
    take(free, middle, size)
    assert nearest_room(free, point, size) is None or not np.allclose(nearest_room(free, point, size), middle)


def test_no_room_at_all() -> None:
    assert nearest_room(np.ones((3, 3), dtype=bool), np.zeros(2), np.array([4.0, 1.0])) is None


def test_labels_keep_clear_of_lines_and_of_each_other() -> None:
    figure = Figure(figsize=(6.0, 4.0))
    ax = figure.subplots()
    ax.plot([0.0, 1.0, 2.0], [0.0, 1.0, 0.0], color="black")
    add_leaders(ax, ["the top", "also the top"], [(1.0, 1.0), (1.0, 1.0)])
    figure.draw_without_rendering()
    (labels,) = (each for each in ax.artists if type(each).__name__ == "Leaders")
    first, second = (text.get_window_extent() for text in labels.texts)
    assert not first.overlaps(second)
    line = ax.transData.transform(np.column_stack([np.linspace(0, 2, 500), 1 - abs(np.linspace(0, 2, 500) - 1)]))
    for box in (first, second):
        assert ax.get_window_extent().contains(box.x0, box.y0)
        assert not any(box.contains(x, y) for x, y in line)
