"""Branches of a rod's large motion: held to steady motion and to the edges of tongues, interrupted and resumed."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import floquetrod as fr

ROD = fr.Rod.nitinol().replace(damping_rate=3.0)
SHORT = ROD.replace(length=1.2)
CRITICAL = ROD.critical_force
LOAD = fr.AxialLoad(0.1 * CRITICAL, 0.3 * CRITICAL, 110.0)


@pytest.fixture(scope="module")
def few() -> fr.results.RodBranches:
    def stop(done: int, total: int) -> None:
        assert 0 < done <= total
        if done == 3:
            raise KeyboardInterrupt

    return SHORT.follow(LOAD, {"frequency": (105.0, 115.0)}, progress=stop)


def test_what_was_found_is_kept_when_interrupted(few: fr.results.RodBranches) -> None:
    assert few.mode == 2
    assert few.modes == (2, 6)
    assert len(few.values) == 4
    assert not few.is_whole
    assert few.parts[0].ends[1].startswith("interrupted")
    assert (few.status == 1).all()
    assert (np.diff(few.values) * np.diff(few.amplitude) > 0.0).all()  # it hardens
    ((angle, status),) = few.at(110.0)
    assert angle == pytest.approx(0.11365, rel=1e-3)  # of steady_motion, in all modes
    assert status == "stable"
    assert few.at(f"{110.0 / (2.0 * math.pi)!r}Hz")[0][0] == pytest.approx(angle, rel=1e-9)
    assert few.at(200.0) == []
    with pytest.raises(ValueError, match="value must be"):
        few.at(math.nan)
    weight = SHORT.mass_per_length * SHORT.effective_gravity
    assert (0.9 * weight < few.contact).all()
    assert (few.contact < weight).all()
    assert (few.slope < 0.01).all()


def test_branches_are_said_and_drawn(few: fr.results.RodBranches) -> None:
    assert "1 branch of motion in mode 2" in repr(few)
    assert "4 stable" in str(few)
    assert few.as_dict()["branches"][0]["turns"] == 2
    assert few.to_xarray()["amplitude"].shape == few.values.shape
    with pytest.raises(TypeError, match="status"):
        bool(few)
    ax = few.plot(unit="Hz")
    assert ax.get_xlabel() == r"frequency $\omega/2\pi$ / Hz"
    (line,) = ax.lines
    assert line.get_xdata()[0] == pytest.approx(few.values[0] / (2.0 * math.pi))
    assert line.get_ydata()[-1] == pytest.approx(math.degrees(few.amplitude[-1]))
    with pytest.raises(ValueError, match="unit must be a unit of frequency"):
        few.plot(unit="N")


def test_branches_of_another_rod_or_quantity_are_refused(few: fr.results.RodBranches) -> None:
    with pytest.raises(ValueError, match="branches of this rod"):
        ROD.follow(few)
    with pytest.raises(ValueError, match=r"over has 'mean', which is no parameter; it has frequency"):
        SHORT.follow(few, {"mean": (0.1, 0.2)})
    with pytest.raises(ValueError, match="must contain the branch"):
        SHORT.follow(few, {"frequency": (112.0, 115.0)})


@pytest.mark.parametrize("given", [{"mode": 2}, {"all_modes": True}, {"indentation": 1e-3}])
def test_branches_are_continued_as_they_were_begun(few: fr.results.RodBranches, given: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=f"{next(iter(given))} must be left out where branches are continued"):
        SHORT.follow(few, **given)


@pytest.mark.parametrize("given", [{"steps": 10_001}, {"longest": 1e-4}, {"progress": 1}, {"mode": 0}])
def test_arguments_are_checked_where_branches_are_continued(few: fr.results.RodBranches, given: dict[str, Any]) -> None:
    with pytest.raises((ValueError, TypeError)) as begun:
        SHORT.follow(LOAD, {"frequency": (105.0, 115.0)}, **given)
    with pytest.raises((ValueError, TypeError)) as continued:
        SHORT.follow(few, **given)
    assert (begun.type, str(begun.value)) == (continued.type, str(continued.value))


@pytest.mark.parametrize(
    ("over", "error", "message"),
    [
        ({"frequenzy": (1.0, 2.0)}, ValueError, "did you mean frequency"),
        ({"frequency": (2.0, 1.0)}, ValueError, "must increase"),
        ({"frequency": 3.0}, TypeError, "two numbers"),
        ({"frequency": (math.nan, 1.0)}, ValueError, "finite"),
        ({}, TypeError, "one quantity of the load"),
        (None, TypeError, "one quantity of the load"),
    ],
)
def test_ranges_that_are_none(over: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        SHORT.follow(LOAD, over)


@pytest.mark.parametrize(
    ("rod", "load", "message"),
    [
        (ROD.replace(ends="clamped-free"), LOAD, "free"),
        (SHORT, LOAD.varied("amplitude", 0.0), "steady_motion"),
        (SHORT, LOAD.varied("amplitude", 1e-6), "found none"),
    ],
)
def test_loads_without_branches_are_refused(rod: fr.Rod, load: fr.AxialLoad, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        rod.follow(load, {"frequency": (20.0, 20.1)}, mode=2)


@pytest.mark.slow
def test_branches_go_on_where_they_were_left(few: fr.results.RodBranches) -> None:
    whole = SHORT.follow(few, longest=0.1)
    assert whole.is_whole
    assert set(few.values) <= set(whole.values)
    (part,) = whole.parts
    assert part.ends[0].startswith("motion shrinks to rest at frequency = ")
    (below,) = SHORT.ranges(
        "frequency", mean=LOAD.mean, amplitude=LOAD.amplitude, bounds=(105.0, 115.0), growth_tolerance=0.0
    )
    assert part.rests[0] == pytest.approx(below.high, rel=1e-5)


@pytest.mark.slow
def test_backbones_begin_at_the_edges_of_a_tongue_and_pass_through_steady_motion() -> None:
    load = fr.AxialLoad(0.2 * CRITICAL, 0.25 * CRITICAL, 140.0)
    found = ROD.follow(load, {"frequency": (120.0, 165.0)})
    assert found.is_whole
    stable, unstable = found.parts
    assert (stable.branch.status == 1).all()
    assert (unstable.branch.status == 0).all()
    assert all(part.branch.ends[1].startswith("the rod is about to leave its wall") for part in found.parts)
    _, above = ROD.ranges(
        "frequency", mean=load.mean, amplitude=load.amplitude, bounds=found.over, growth_tolerance=0.0
    )
    edges = [part.rests[0] for part in found.parts]
    assert edges == pytest.approx([138.026368, above.low], rel=1e-5)
    ((angle, _),) = found.at(140.0)
    assert angle == pytest.approx(ROD.steady_motion(load).amplitude, rel=2e-3)


@pytest.mark.slow
def test_all_modes_are_those_of_steady_motion() -> None:
    found = SHORT.follow(LOAD, {"frequency": (109.9, 110.1)}, steps=1, all_modes=True)
    assert found.modes == (2, 4, 6, 8, 10, 12)
    ((angle, _),) = found.at(110.0)
    motion = SHORT.steady_motion(LOAD)
    assert abs(angle - motion.amplitude) <= motion.error < 1e-5


INTERRUPTED = """
import floquetrod as fr
rod = fr.Rod.nitinol().replace(damping_rate=3.0, length=1.2)
load = fr.AxialLoad(0.1 * rod.critical_force, 0.3 * rod.critical_force, 110.0)
found = rod.follow(load, {"frequency": (105.0, 115.0)}, progress=lambda done, total: print(done, flush=True))
print(len(found.values), found.parts[0].ends[1])
"""


@pytest.mark.slow
def test_ctrl_c_returns_what_was_found() -> None:
    with subprocess.Popen([sys.executable, "-c", INTERRUPTED], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.strip() == "2":
                process.send_signal(signal.SIGINT)
                break
        *_, last = process.stdout.read().splitlines()
        assert process.wait() == 0
    count, _, end = last.partition(" ")
    assert int(count) >= 3
    assert end.startswith("interrupted")
