"""Maps over a period with delays, found from piece to piece, held against all unknowns at once."""

from __future__ import annotations

import numpy as np
import pytest

from floquetrod.floquet.multipliers.delay_maps import Coefficients, maps_by_piece, period_maps
from floquetrod.floquet.multipliers.delay_mesh import mesh, piece_mesh
from tests.conftest import depth


@pytest.mark.slow
@pytest.mark.parametrize("derivatives", [1, 2])
def test_maps_by_piece_are_those_of_all_unknowns_at_once(derivatives: int, rng: np.random.Generator) -> None:
    for _ in range(depth(300, 50)):
        pieces, count, n, batch = (int(rng.integers(*ends)) for ends in ((1, 7), (3, 9), (1, 4), (1, 4)))
        breaks = (0.0, *np.sort(rng.uniform(0.05, 0.95, pieces - 1)).tolist(), 1.0)
        # Delays shorter than a piece, than the period, and longer than two.
        delays = tuple(rng.choice([0.03, 0.2, 0.45, 1.0, 1.3, 2.4], 2, replace=False).tolist())
        active = tuple(tuple((rng.random(pieces) < 0.7).tolist()) for _ in delays)
        whole, by_piece = (make(breaks, count, derivatives, delays, active) for make in (mesh, piece_mesh))
        assert by_piece.size == whole.size
        assert by_piece.nodes == pytest.approx(whole.nodes, abs=1e-15)
        shape = batch, len(whole.nodes), n, n
        on = np.repeat(np.asarray(active), count, axis=1)
        delayed = tuple(3.0 * rng.standard_normal(shape) * there[:, None, None] for there in on)
        rate = rng.standard_normal(shape) if derivatives == 2 and rng.random() < 0.7 else None
        coefficients = Coefficients(4.0 * rng.standard_normal(shape), rate, delayed)
        one, other = period_maps(whole, coefficients), maps_by_piece(by_piece, coefficients)
        assert one.shape == other.shape
        assert np.abs(one - other).max() < 1e-9 * max(1.0, np.abs(one).max())
