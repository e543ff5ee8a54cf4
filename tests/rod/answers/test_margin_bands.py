"""The unstable bands in which margins end: mode, tongue, and whether the band is thin."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import floquetrod as fr

_NITINOL = fr.Rod.nitinol()
_FORCE = _NITINOL.critical_force


def _drawn(rng: np.random.Generator) -> Any:
    """Return a stable verdict on a rod of drawn length under a drawn load."""
    while True:
        rod = _NITINOL.replace(length=float(rng.uniform(1.5, 4.0)), damping_rate=float(rng.choice([0.0, 0.05])))
        mean, amplitude = rng.uniform([0.0, 0.02], [0.7, 0.3]) * rod.critical_force
        verdict = rod.stability(fr.AxialLoad(float(mean), float(amplitude), float(rng.uniform(60.0, 250.0))))
        if verdict.stable:
            return verdict


@pytest.mark.slow
@pytest.mark.parametrize("quantity", ["mean", "amplitude", "frequency"])
def test_a_margin_names_the_band_at_its_edge_as_ranges_do(quantity: Any, rng: np.random.Generator) -> None:
    compared = 0
    while compared < 3:
        verdict = _drawn(rng)
        above = verdict.margin(quantity).above
        if not math.isfinite(above):
            continue
        compared += 1
        load, here = verdict.load, getattr(verdict.load, quantity)
        band = verdict.model.band_beyond(verdict, quantity, above)
        bounds = (here + 0.99 * above, here + above + 0.01 * abs(here + above))
        ranges = verdict.rod.ranges(quantity, load, bounds, growth_tolerance=verdict.margin_tolerance)
        assert band.cause == ranges.intervals[0].high_end, load
        assert band.is_thin == (len(ranges.intervals) > 1), load
        first = ranges.unstable[0]
        assert band.growth == pytest.approx(first.worst_growth, rel=1e-4), load


def test_a_report_and_its_numbers_say_where_a_margin_is_thin() -> None:
    rod = fr.Rod(youngs_modulus=193e9, density=8000.0, diameter=4e-3, length=8.0, channel_diameter=30e-3)
    verdict = rod.stability(fr.AxialLoad.hertz(0.3 * rod.critical_force, 0.15 * rod.critical_force, 18.0))
    margins = verdict.margins()
    said = str(verdict.report({"frequency": "Hz"}, margins))
    assert (
        "unstable 0.5716 Hz lower (mode 15, tongue 3: thin, 0.0018 1/s) or 0.1668 Hz higher (mode 9, tongue 1)" in said
    )
    numbers = verdict.as_dict(margins)["frequency_margin_ends_in"]
    assert numbers["below"]["is_thin"]
    assert not numbers["above"]["is_thin"]
    assert (numbers["below"]["mode"], numbers["below"]["tongue"]) == (15, 3)


def test_margins_of_an_unstable_load_name_no_band() -> None:
    verdict = _NITINOL.stability(fr.AxialLoad.hertz(0.3 * _FORCE, 0.15 * _FORCE, 18.0))
    assert not verdict.stable
    assert verdict.model.band_beyond(verdict, "frequency", 1.0) is None
