"""Results compare by content, hash alike when equal, and survive pickling."""

from __future__ import annotations

import copy
import dataclasses
import importlib
import math
import pickle
import pkgutil
import re
import typing
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import floquetrod as fr
from floquetrod._util.content import ByContent
from floquetrod.simulation.checkpoints import CheckpointWarning
from floquetrod.simulation.rod_mesh import DiscreteRod
from studies.simulations import TrialOutcome, figure_4

ROD = fr.Rod.nitinol()
FCR = ROD.critical_force
LOAD = fr.AxialLoad(0.2 * FCR, 0.2 * FCR, 150.0)
EQUATION = fr.Mathieu(0.5, -0.25)
TIME = np.linspace(0.0, 1.0, 200)
RUBBING = fr.FrictionalMathieu(0.5, -0.25, gamma=1.0)


def short_run(seed: int = 1) -> fr.Simulation:
    return fr.simulate(ROD, LOAD, duration=1e-3, segments=40, frames=3, perturbation=fr.Perturbation.random(1e-3, seed))


def small_map(growth: bool = True) -> fr.Chart:
    return fr.stability_map(
        ROD, mean=(0.0, 1.1 * FCR, 12), amplitude=0.2 * FCR, frequency=(20.0, 200.0, 17), growth=growth
    )


def outcome() -> TrialOutcome:
    return TrialOutcome(figure_4()[0], False, 0, short_run())


MADE: dict[str, Callable[[], Any]] = {
    "Mathieu": lambda: EQUATION,
    "Meissner": lambda: fr.Meissner(0.5, -0.25),
    "Hill": lambda: fr.Hill(0.5, sines=(0.1,)),
    "FrictionalMathieu": lambda: RUBBING,
    "Stability": lambda: fr.stability(EQUATION),
    "Stability, infinite": lambda: fr.stability(fr.Mathieu(1.0, 1e6)),
    "Comparison": lambda: fr.compare(EQUATION),
    "Response": lambda: fr.response(fr.Mathieu(0.3, -0.6, 0.01), 1.0),
    "Gain": lambda: fr.gain(fr.HillSystem([[1.0]], damping=[[0.1]]), frequency=(0.9, 1.1)),
    "OutputNoise": lambda: fr.output_noise(fr.Mathieu(0.3, -0.6, 0.1), 1.0),
    "ResponseComparison": lambda: fr.compare(fr.Mathieu(0.3, -0.6, 0.01), force=1.0),
    "Proof": lambda: fr.certify(EQUATION),
    "Chart": small_map,
    "Chart of verdicts": lambda: small_map(False),
    "Chart of an equation": lambda: fr.mathieu.chart((0.0, 3.0, 8), (-2.0, 0.5, 6), growth=True),
    "Axis": lambda: small_map().x,
    "TransitionCurves": lambda: fr.mathieu.transition_curves([0.0, 0.5], 2),  # NaN among them
    "Rod": lambda: ROD,
    "AxialLoad": lambda: LOAD,
    "ForceRecord": lambda: fr.ForceRecord(TIME, 3.0 + np.sin(40.0 * TIME)),
    "RodStability": lambda: ROD.stability(LOAD),
    "FrictionalRodStability": lambda: ROD.stability(LOAD, friction=0.1, kick=0.05),
    "StabilityIntervals": lambda: ROD.ranges("mean", amplitude=LOAD.amplitude, frequency=150.0),
    "InstabilityProbability": lambda: fr.probability_of_instability(
        ROD, LOAD, {"mean": (0.0, 1.0)}, samples=100, seed=1
    ),
    "FiniteTimeCriterion": fr.FiniteTimeCriterion,
    "Perturbation": lambda: fr.Perturbation.case("C"),
    "Fate": lambda: fr.friction.fate(RUBBING, 3.0),
    "EscapeRanges": lambda: fr.friction.escape_ranges(RUBBING),
    "Trajectory": lambda: fr.friction.trajectory(RUBBING, 3.0),
    "Simulation": short_run,
    "SimulationProblem": lambda: short_run().problem,
    "DiscreteRod": lambda: DiscreteRod(ROD, 100),
    "TrialOutcome": outcome,
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in ("EscapeRanges", "Comparison"))) for name in MADE]
)
def test_equal_content_is_equal(name: str) -> None:
    one, other = MADE[name](), MADE[name]()
    for twin in (one, other, pickle.loads(pickle.dumps(one)), copy.deepcopy(one)):
        assert (one == twin) is True
        assert (one != twin) is False
        assert hash(one) == hash(twin)
    assert (one == 1) is False
    assert (one == None) is False  # noqa: E711 - the operator is what is tested
    assert one in [other]
    assert repr(pickle.loads(pickle.dumps(one))) == repr(one)


def small_changes(result: Any) -> Iterator[Any]:
    """Yield copies of a result in each of which one compared field holds something else."""
    for field in dataclasses.fields(result):
        value = getattr(result, field.name)
        if not field.compare or value is None:
            continue
        if isinstance(value, np.ndarray):
            changed = value.copy()
            changed.flat[-1] = not changed.flat[-1] if value.dtype == bool else changed.flat[-1] + 1
        elif isinstance(value, dict):
            name = list(value)[-1]
            changed = {**value, name: np.append(value[name], 0.0) if isinstance(value[name], np.ndarray) else "else"}
        elif isinstance(value, bool):
            changed = not value
        elif isinstance(value, int | float):
            changed = value + 1
        else:
            changed = "something else"
        yield dataclasses.replace(result, **{field.name: changed})


@pytest.mark.parametrize("name", ["Axis", "Chart", "Chart of verdicts", "TransitionCurves", "Trajectory", "Simulation"])
def test_every_field_counts(name: str) -> None:
    result = MADE[name]()
    assert isinstance(result, ByContent)
    changes = list(small_changes(result))
    assert len(changes) >= 4
    for changed in changes:
        assert result != changed
        assert not changed == result  # noqa: SIM201 - both operators
    assert len({result, *changes}) == len(changes) + 1


def test_nan_is_equal_to_nan_and_to_nothing_else() -> None:
    curves = fr.mathieu.transition_curves([0.0, 0.5], 1)
    assert np.isnan(curves.odd[0]).all()
    other = dataclasses.replace(curves, odd=np.where(np.isnan(curves.odd), 0.0, curves.odd))
    assert curves != other
    motion = dataclasses.replace(fr.friction.trajectory(RUBBING, 3.0), kick=math.nan)
    assert motion == pickle.loads(pickle.dumps(motion))
    assert hash(motion) == hash(pickle.loads(pickle.dumps(motion)))


def test_the_hash_stays_when_somebody_writes_into_an_array() -> None:
    chart = small_map()
    seen = {chart}
    chart.stable[0, 0] = not chart.stable[0, 0]
    assert chart in seen


def test_exceptions_that_carry_runs_are_pickled_whole() -> None:
    run = short_run()
    for error in (fr.SimulationDiverged("gone", run), CheckpointWarning("full", run), CheckpointWarning("full")):
        again = pickle.loads(pickle.dumps(error))
        assert (type(again), str(again), again.simulation) == (type(error), str(error), error.simulation)


def dataclasses_of_the_package() -> Iterator[type]:
    for module in pkgutil.walk_packages(fr.__path__, "floquetrod."):
        if module.name != "floquetrod.__main__":
            for value in vars(importlib.import_module(module.name)).values():
                if isinstance(value, type) and dataclasses.is_dataclass(value) and value.__module__ == module.name:
                    yield value


def holds_arrays(hint: Any) -> bool:
    return typing.get_origin(hint) in (np.ndarray, NDArray) or any(map(holds_arrays, typing.get_args(hint)))


def test_no_dataclass_compares_arrays_by_their_truth() -> None:
    found = []
    for kind in dataclasses_of_the_package():
        module = vars(importlib.import_module(kind.__module__))
        names = {
            name: hint
            for base in reversed(kind.__mro__)
            for name, hint in vars(base).get("__annotations__", {}).items()
        }
        for field in dataclasses.fields(kind):
            text = str(names[field.name])
            hint = eval(text, module) if re.search(r"NDArray|Floats|Ints|Bools", text) else None
            if field.compare and hint is not None and holds_arrays(hint):
                found.append(kind.__name__)
                assert issubclass(kind, ByContent), f"{kind.__name__}.{field.name} is an array: derive from ByContent"
                assert kind.__eq__ is ByContent.__eq__, f"declare {kind.__name__} with eq=False"
                assert kind.__hash__ is ByContent.__hash__
    assert {"Axis", "Chart", "TransitionCurves", "Trajectory", "Simulation"} <= set(found)
