"""Many systems on a straight line: polynomials through a few maps against maps of their own."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod._util.arrays import norms
from floquetrod.floquet.multipliers import verdicts_along_lines
from floquetrod.floquet.multipliers.verdicts_along_lines import SystemLine, maps_along, verdicts_along
from floquetrod.systems.batch_verdicts import verdicts
from tests.conftest import depth
from tests.coupled_cases import known
from tests.inside import CoupledModes, Loads, Quantity
from tests.system_cases import beam

PERIOD = 3.0
PLACES = np.concatenate([np.linspace(-1.0, 1.0, 46), [0.123456, -0.987654]])


def ends(seed: int, n: int = 3, *, even: bool = True, damping: float = 0.0, strength: float = 0.4) -> fr.HillSystem:
    """Return two systems of n equations with frequencies up to about three of the forcing, as a batch."""
    rng = np.random.default_rng(seed)

    def drawn(size: float) -> np.ndarray:
        matrices = size * rng.normal(size=(2, n, n))
        return matrices + matrices.swapaxes(1, 2)

    stiffness = np.diag(rng.uniform(0.1, 3.0, n) ** 2) + drawn(0.1)
    sines = [] if even else [drawn(strength / n)]
    friction = 2.0 * damping * np.eye(n) if damping else None
    return fr.HillSystem(stiffness, [drawn(strength / n)], sines, damping=friction, period=PERIOD)


def between(both: fr.HillSystem, places: np.ndarray) -> fr.HillSystem:
    """Return the systems at places from -1 to 1 of the line between two."""
    share = 0.5 * (1.0 + places)[:, None, None]

    def mixed(pair: np.ndarray) -> np.ndarray:
        return np.asarray((1.0 - share) * pair[0] + share * pair[1])

    series = [[mixed(pair) for pair in part] for part in (both.cosines, both.sines)]
    return fr.HillSystem(mixed(both.stiffness), *series, damping=both.damping, period=PERIOD)


@pytest.mark.parametrize("even", [True, False])
def test_a_polynomial_leaves_out_less_than_it_says(even: bool) -> None:
    line = SystemLine.between(ends(1, n=2, even=even))
    assert line is not None
    assert line.is_even == even
    exact = line.nodes(line.degree() + 4)
    assert exact is not None
    true, _ = maps_along(line, exact, PLACES)
    told = []
    for degree in (4, line.degree()):
        nodes = line.nodes(degree)
        assert nodes is not None
        found, error = maps_along(line, nodes, PLACES)
        wrong = np.linalg.norm(found - true, 2, axis=(1, 2))
        assert (wrong <= error).all()
        assert line.left_out(degree) > 3.0 * wrong.max() or degree == line.degree()
        told.append(line.left_out(degree))
    assert told == sorted(told, reverse=True)
    assert told[-1] <= 1e-12


@settings(max_examples=depth(100, 5))
@given(
    seed=st.integers(0, 10**6),
    n=st.integers(1, 3),
    even=st.booleans(),
    damping=st.sampled_from([0.0, 0.02]),
    strength=st.floats(0.05, 1.2),
)
def test_verdicts_along_a_line_are_those_of_each_system(
    seed: int, n: int, even: bool, damping: float, strength: float
) -> None:
    both = ends(seed, n, even=even, damping=damping, strength=strength)
    found = verdicts_along(both, PLACES)
    assume(found is not None)
    assert found is not None
    each = verdicts(between(both, PLACES), quick=True)
    decided = (found.status >= 0) & (each.status >= 0)
    assert decided.mean() > 0.9
    assert (found.status == each.status)[decided].all()
    assert np.allclose(found.growth[decided], each.growth[decided], rtol=1e-8, atol=1e-8)


def test_the_beam_between_two_loads() -> None:
    one, other = beam(40.0), beam(136.25)
    assert one.period != other.period
    pair = fr.HillSystem(
        np.stack([one.stiffness, one.stiffness + 30.0 * np.eye(4)]), [one.cosines[0]], period=one.period
    )
    found = verdicts_along(pair, np.linspace(-1.0, 1.0, 101))
    assert found is not None
    assert found.status[0] == 0
    assert found.growth[0] == pytest.approx(1.123052773707724, rel=1e-11)


def test_no_line_is_found_where_there_is_none_or_it_would_save_nothing() -> None:
    both = ends(2)
    assert verdicts_along(both, PLACES[:8]) is None
    for changed in (
        fr.HillSystem(both.stiffness, both.cosines, mass=2.0 * np.eye(3), period=PERIOD),
        fr.HillSystem(both.stiffness, both.cosines, damping=np.diag([1.0, 0.0, 0.0]), period=PERIOD),
        fr.HillSystem(both.stiffness, both.cosines, period=np.array([1.0, 2.0])),
        fr.HillSystem(both.stiffness + np.triu(np.ones((3, 3)), 1), both.cosines, period=PERIOD),
        fr.HillSystem(1e6 * both.stiffness, both.cosines, period=PERIOD),
    ):
        assert verdicts_along(changed, PLACES) is None


# --- rods ---

PLAIN = fr.Rod(207e9, 7850.0, 0.01, 7.0, 0.05, inclination=1.0)
UNIT, SWING = PLAIN.critical_force, PLAIN.pendulum_frequency
WAVE = fr.AxialWave(0.0, 0.0, 1.0, far_end="held", axial_damping=3.0)


def test_loads_are_sorted_into_lines_of_one_force() -> None:
    mean, frequency = (part.ravel() for part in np.meshgrid(np.arange(4.0), [1.0, 2.0]))
    loads = Loads.of(np.append(mean, 7.0), 1.0, np.append(frequency, 9.0))
    found = [(varied, line.tolist()) for varied, line in loads.lines(3)]
    assert found == [("mean", [0, 1, 2, 3]), ("mean", [4, 5, 6, 7])]
    assert [(varied, line.size) for varied, line in Loads.of(1.0, np.arange(5.0), 2.0).lines(3)] == [("amplitude", 4)]
    assert list(Loads.of(np.arange(5.0), 0.0, 2.0).lines(3)) == []


@pytest.mark.parametrize(
    ("ends", "damping", "tolerance", "like"),
    [
        ("hinged", 0.0, 0.0, None),
        pytest.param("clamped", 0.02 * SWING, 0.0, None, marks=pytest.mark.slow),
        pytest.param("clamped-free", 0.0, 0.01 * SWING, None, marks=pytest.mark.slow),
        ("guided-hinged", 0.01 * SWING, 0.002 * SWING, WAVE),
    ],
)
@pytest.mark.parametrize("varied", ["mean", "amplitude"])
def test_loads_on_a_line_get_the_answers_of_each_alone(
    varied: Quantity, ends: str, damping: float, tolerance: float, like: fr.AxialWave | None, rng: np.random.Generator
) -> None:
    rod = PLAIN.replace(ends=ends, damping_rate=damping)
    model = rod._modes_under(like)
    modes = CoupledModes.of(rod, model.template, 5)
    fast_enough = rng.uniform(1.2, 2.5) * SWING  # that a line of 40 loads saves time
    numbers = {"mean": 0.3 * UNIT, "amplitude": 0.2 * UNIT, "frequency": fast_enough}
    loads = Loads.of(**numbers | {varied: np.sort(rng.uniform(0.02, 0.6, 40)) * UNIT})
    assert modes._along(loads, varied) is not None
    together = modes.answers(loads, tolerance)
    each = [modes.answers(loads.some(slice(i, i + 1)), tolerance) for i in range(loads.size)]
    assert together.status.tolist() == [int(one.status[0]) for one in each]
    assert together.growth == pytest.approx([float(one.growth[0]) for one in each], rel=1e-8, abs=1e-9 * SWING)


def test_what_a_line_leaves_open_is_judged_load_by_load(monkeypatch: pytest.MonkeyPatch) -> None:
    rod = PLAIN.replace(ends="clamped")
    modes = CoupledModes.of(rod, rod._modes_under(None).template, 5)
    loads = Loads.of(np.linspace(0.0, 0.6, 40) * UNIT, 0.2 * UNIT, 2.0 * SWING)
    expected = modes.answers(loads)

    def rough(line: SystemLine, nodes: verdicts_along_lines.Nodes, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        maps, error = maps_along(line, nodes, places)
        return maps, np.where(np.arange(places.size) % 2, error, 1e-2 * norms(maps))

    monkeypatch.setattr(verdicts_along_lines, "maps_along", rough)
    undecided = modes._along(loads, "mean")
    assert undecided is not None
    assert (undecided.status[::2] == -1).any()
    found = modes.answers(loads)
    assert found.status.tolist() == expected.status.tolist()
    assert found.growth == pytest.approx(expected.growth, rel=1e-8, abs=1e-9 * SWING)


@pytest.mark.slow
def test_a_map_is_that_of_its_loads_one_by_one() -> None:
    rod = PLAIN.replace(ends="clamped", damping_rate=0.02 * SWING)
    found = fr.stability_map(
        rod, mean=(0.0, 0.6 * UNIT, 40), amplitude=0.2 * UNIT, frequency=np.array([1.7, 2.1]) * SWING
    )
    x, y = found.x.values, found.y.values
    each = [[fr.Rod.verdicts(rod, mean=mean, amplitude=0.2 * UNIT, frequency=w) == 1 for w in x] for mean in y[::13]]
    assert (found.stable[::13] == np.array(each)).all()


@pytest.mark.parametrize("name", ["wire at 75 degrees", "wire at 60 degrees, even", "tubing of 60 m, c = 0.2"])
@pytest.mark.parametrize("varied", ["mean", "amplitude"])
def test_growth_along_a_line_is_that_of_an_independent_integrator(name: str, varied: Quantity) -> None:
    case = known()[name]
    value = getattr(case.load, varied)
    loads = Loads.along(case.load, varied, np.append(np.linspace(0.6, 1.3, 32) * value, value))
    model = case.rod._modes_under(case.load)
    found = model.in_modes(model.count_for(loads, 0.0))._along(loads, varied)
    assert found is not None
    assert found.growth[-1] == pytest.approx(case.rate, abs=case.slack + 1e-7)
