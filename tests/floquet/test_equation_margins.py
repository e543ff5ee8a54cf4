"""Margins of Mathieu's equation in its mean and its forcing, against counted tongues."""

import math

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.floquet.equation_margins import damping_in_words, forcing_margin, mean_margin
from floquetrod.mathieu import characteristic_values
from floquetrod.mathieu.tongue_intervals import along_mean

RANDOM = np.random.default_rng(3)


@pytest.mark.slow
def test_undamped_margins_in_the_mean_end_at_the_next_transition_curves() -> None:
    for a, q in RANDOM.uniform((-5.0, 0.5), (20.0, 6.0), (15, 2)).tolist():
        curves = np.sort(
            np.concatenate([characteristic_values(np.arange(kind == "b", 9), q, kind) for kind in ("a", "b")])
        )
        if np.min(np.abs(curves - a)) < 1e-6:
            continue
        room, below, above = max(2.0 * q, 3.0), curves[curves < a], curves[curves > a]
        expected = (a - below[-1] if below.size else math.inf, above[0] - a if above.size else math.inf)
        margin = mean_margin(fr.stability(fr.Mathieu.from_aq(a, -q)))
        for distance, exact in zip(margin, expected, strict=True):
            assert distance == (pytest.approx(exact, abs=1e-8) if exact < room else math.inf)
        assert margin.resolution == 0.0


def test_damped_margins_in_the_mean_end_at_the_tongues() -> None:
    for a, q, damping in RANDOM.uniform((-1.0, 0.3, 0.02), (12.0, 5.0, 0.4), (15, 3)).tolist():
        margin, room, c = mean_margin(fr.stability(fr.Mathieu.from_aq(a, q, damping))), max(2.0 * q, 3.0), 0.5 * damping
        low, high = (np.array([-0.25 * end + c * c]) for end in (a + room, a - room))
        tongues = along_mean(np.array([0.5 * q]), np.array([c]), low, high)
        ends = a - np.concatenate([-4.0 * (end - c * c) for end in (tongues.first, tongues.last)])
        ends = ends[np.abs(ends) < room * (1.0 - 1e-9)]
        if np.diff(np.sort(ends)).min(initial=1.0) < margin.resolution or np.abs(ends).min(initial=1.0) < 1e-6:
            continue
        assert margin.below == pytest.approx(ends[ends > 0.0].min(initial=math.inf), abs=1e-6)
        assert margin.above == pytest.approx((-ends[ends < 0.0]).min(initial=math.inf), abs=1e-6)


def test_a_stable_band_narrower_than_the_steps_is_not_passed_over() -> None:
    """Between tongues 0 and 1 at a = -3, where growth is fast on either side of a band 0.05 wide in q."""
    margin = forcing_margin(fr.stability(fr.Mathieu.from_aq(-3.0, 1.5)))
    q = 1.5 + margin.above
    assert q == pytest.approx(3.1180, abs=1e-4)
    assert float(characteristic_values(0, q, "a")) == pytest.approx(-3.0, abs=1e-7)


def test_a_damping_that_is_more_than_needed_is_told() -> None:
    words = damping_in_words(fr.stability(fr.Mathieu.from_aq(1.0, 0.3, 0.2)))
    assert words == "stable with a damping above 0.149274 per unit z, 0.0507257 less"
    assert fr.stability(fr.Mathieu.from_aq(1.0, 0.3, 0.1492)).status == "unstable"
    assert fr.stability(fr.Mathieu.from_aq(1.0, 0.3, 0.1493)).status == "stable"
    assert damping_in_words(fr.stability(fr.Mathieu.from_aq(5.0, 0.1, 0.2))) == "stable without damping"
