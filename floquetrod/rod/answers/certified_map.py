"""Maps whose cells are proofs: blocks of cells first, what a block leaves open in quarters, down to single cells."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.compilation import over_chunks
from floquetrod._util.progress import Progress
from floquetrod.floquet.proof.kernels import regions as kernels
from floquetrod.plane import Axis
from floquetrod.plane.chart import CELLS
from floquetrod.rod.answers.rod_box import RodBox
from floquetrod.rod.loads.load import QUANTITIES, Load, Quantity
from floquetrod.rod.model.constants import MOST_MODES
from floquetrod.rod.model.data import RodData

_FIRST = 16  # cells along a side of the first blocks (a choice)
_PARTS = 64  # parts of a single cell examined before it is given up (a choice)
_AT_ONCE = 4096  # boxes between two reports of progress (a choice)
_CHUNK = 64  # boxes a thread takes at a time: some milliseconds


def certified_cells(
    rod: RodData,
    like: Load,
    axes: Mapping[Quantity, Axis],
    fixed: tuple[Quantity, float],
    tolerance: float,
    workers: int | None = None,
    progress: Progress | None = None,
) -> NDArray[np.int8]:
    """Return the proof of every cell of a map, int8 (rows, columns), see `floquetrod.plane.chart.CELLS`.

    ``axes`` has the quantity to the right, then the one upwards, whose `Axis.cell_edges` bound the cells; ``fixed`` is
    the third one with its value.
    """
    # Blocks of size x size cells, quartered where nothing is proved: a block proved stable or unstable decides all its
    # cells, and most of a map lies far from boundaries.  ``left`` (2, blocks) are rows and columns where blocks begin.
    # Single cells come last and may be subdivided into `_PARTS` boxes by the kernel; what is undecided then stays so.
    (across, x), (up, y) = axes.items()
    edges = {across: x.cell_edges, up: y.cell_edges}
    shape = y.values.size, x.values.size
    constants = np.array(RodBox.of(rod, like, 0.0, 0.0, 1.0, None).mode_box()[3:])
    cells = np.full(shape, CELLS["undecided"], dtype=np.int8)
    size = _FIRST
    left = np.stack(
        [index.ravel() for index in np.meshgrid(*(np.arange(0, n, size) for n in cells.shape), indexing="ij")]
    )
    while left.shape[1]:
        parts = _PARTS if size == 1 else 1
        open_blocks = []
        for start in range(0, left.shape[1], _AT_ONCE):
            row, column = block = left[:, start : start + _AT_ONCE]
            ends: dict[Quantity, tuple[NDArray[np.float64], NDArray[np.float64]]] = {
                across: (edges[across][column], edges[across][np.minimum(column + size, shape[1])]),
                up: (edges[up][row], edges[up][np.minimum(row + size, shape[0])]),
                fixed[0]: (np.full(row.size, fixed[1]), np.full(row.size, fixed[1])),
            }
            inputs = [end for name in QUANTITIES for end in ends[name]]
            cell_status = np.empty(row.size, dtype=np.int8)
            over_chunks(
                kernels.certify_cells,
                inputs,
                cell_status,
                constants,
                tolerance,
                tolerance,
                0.0,
                MOST_MODES,
                parts,
                workers=workers,
                chunk=_CHUNK,
                interpret_up_to=0,
            )
            decided = (cell_status == CELLS["proved stable"]) | (cell_status == CELLS["proved unstable"]) | (size == 1)
            for i, j, status in zip(*(block[:, decided].tolist()), cell_status[decided].tolist(), strict=True):
                cells[i : i + size, j : j + size] = status
            open_blocks.append(block[:, ~decided])
            if progress is not None:
                progress(_done(cells, open_blocks, left[:, start + _AT_ONCE :], size), cells.size)
        left = _quarters(np.concatenate(open_blocks, axis=1), size // 2, cells.shape)
        size //= 2
    return cells


def _quarters(blocks: NDArray[np.int64], size: int, shape: tuple[int, ...]) -> NDArray[np.int64]:
    """Return the corners of the quarters of blocks, those that begin within the map."""
    if not size:
        return blocks[:, :0]
    quarters = np.concatenate([blocks + size * np.array([[i], [j]]) for i in (0, 1) for j in (0, 1)], axis=1)
    return quarters[:, (quarters[0] < shape[0]) & (quarters[1] < shape[1])]


def _done(cells: NDArray[np.int8], open_blocks: list[NDArray[np.int64]], waiting: NDArray[np.int64], size: int) -> int:
    """Return how many cells are done: all that lie in no block that is open or waits."""
    blocks = np.concatenate([*open_blocks, waiting], axis=1)
    rows, columns = (np.minimum(size, n - corner) for n, corner in zip(cells.shape, blocks, strict=True))
    return int(cells.size - (rows * columns).sum())
