"""Results elsewhere: JSON by one schema, pickles, tables of pandas, notebooks, and axes of somebody else."""

from __future__ import annotations

import inspect
import json
import math
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod._util.interchange import by_keys, plain
from floquetrod._util.result_report import Reported
from tests.public.test_reports import RESULTS

ROD = fr.Rod.nitinol()
PIPE = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=60.0)
LEVEL = fr.WellPath.straight(length=300.0, inclination="80deg")
DAMPED = fr.HillSystem([[1.0]], damping=[[0.2]])

MORE: dict[str, Callable[[], Any]] = {
    "reach": lambda: PIPE.reach(LEVEL, 0.3, depth=[200.0, 300.0]),
    "mean force": lambda: PIPE.mean_force(LEVEL, 0.3),
    "path": lambda: LEVEL,
    "stress": lambda: PIPE.stress(fr.AxialLoad("20kN", "5kN", "1Hz")),
    "critical noise": lambda: fr.critical_noise(DAMPED, [([[1.0]], 1.0)]),
    "transition curves": lambda: fr.mathieu.transition_curves([0.1, 0.2], [1, 2]),
    "chart": lambda: fr.mathieu.chart((0.0, 1.0, 4), (-1.0, 0.0, 3)),
    "solution": lambda: fr.floquet_solutions(fr.Mathieu(0.5, -0.25))[0],
    "function": lambda: fr.mathieu.characteristic_function(3, 10.0, "a"),
    "margin": lambda: ROD.stability(fr.AxialLoad(0.34, 0.34, 150.0)).frequency_margin,
    "rod": lambda: ROD,
    "load": lambda: fr.AxialLoad(0.34, 0.34, 150.0),
    "equation": lambda: fr.Mathieu(0.5, -0.25),
}
COSTLY = {"coupled modes", "friction", "comparison of systems", "proof of a box", "safe box", "simulation", "findings"}
ALL = {**RESULTS, **MORE}
TAKEN = [pytest.param(name, marks=[pytest.mark.slow] * (name in COSTLY)) for name in ALL]


@pytest.mark.parametrize("name", TAKEN)
def test_every_result_goes_to_json_by_one_schema_and_pickles(name: str) -> None:
    result = ALL[name]()
    told = json.loads(fr.to_json(result))
    assert list(told) == ["schema", "schema_version", "floquetrod", "kind", "result"]
    assert (told["schema"], told["schema_version"]) == ("floquetrod result", 1)
    assert (told["floquetrod"], told["kind"]) == (fr.__version__, type(result).__name__)
    assert told["result"]
    if hasattr(result, "as_dict"):
        assert told["result"] == plain(result.as_dict())
    assert fr.to_json(pickle.loads(pickle.dumps(result)), indent=2) == fr.to_json(result, indent=2)


def public() -> Iterator[tuple[str, type]]:
    """Yield the public classes by name, those of the public modules too."""
    for module in (fr, fr.results, fr.mathieu, fr.simulation, fr.systems, fr.friction, fr.ensembles):
        for name in dir(module):
            found = getattr(module, name)
            if inspect.isclass(found) and found.__module__.startswith("floquetrod"):
                yield f"{module.__name__}.{name}", found


def test_what_says_itself_does_so_in_numbers_and_in_notebooks() -> None:
    saying = {name: found for name, found in public() if issubclass(found, Reported)}
    assert len(saying) > 15
    for name, found in saying.items():
        assert found.as_dict is not Reported.as_dict or found._keys, name
        assert found._repr_html_ is Reported._repr_html_, name  # one implementation for all


def test_everything_that_draws_takes_axes_or_a_figure_of_somebody_else() -> None:
    drawing = [(name, found, each) for name, found in public() for each in dir(found) if each.startswith("plot")]
    assert len(drawing) > 12
    for name, found, method in drawing:
        taken = inspect.signature(getattr(found, method)).parameters
        given = taken.get("ax", taken.get("figure"))
        assert given is not None, f"{name}.{method}"
        assert given.default is None, f"{name}.{method}"


@pytest.mark.slow
def test_pictures_go_where_they_are_told_and_leave_the_style_alone() -> None:
    import matplotlib as mpl
    from matplotlib import pyplot
    from matplotlib.figure import Figure

    before, windows = dict(mpl.rcParams), pyplot.get_fignums()
    for name in ("transition curves", "chart", "function"):
        ax = Figure().subplots()
        ALL[name]().plot(ax=ax)
        assert ax.lines or ax.collections or ax.images
    run, reach = ALL["simulation"](), ALL["reach"]()
    for draw in (run.plot, run.plot_energy, run.plot_growth):
        ax = Figure().subplots()
        assert draw(ax=ax) is ax
    for draw in (run.plot_run, reach.plot):
        left, right = Figure().subfigures(1, 2)
        assert draw(figure=right) is right
        assert right.axes
        assert not left.axes
    assert (dict(mpl.rcParams), pyplot.get_fignums()) == (before, windows)


def test_keys_are_names_of_attributes_with_their_units_or_of_others() -> None:
    keys = "mean_N amplitude_N frequency_rad_per_s is_uniform per_newton=mean"
    load = fr.AxialLoad(0.34, 0.2, 150.0)
    told = {"mean_N": 0.34, "amplitude_N": 0.2, "frequency_rad_per_s": 150.0, "is_uniform": True, "per_newton": 0.34}
    assert list(by_keys(load, keys).items()) == list(told.items())
    assert by_keys(None, keys) == dict.fromkeys(told)
    assert by_keys(ROD.stability(load), "mean_N=load.mean") == {"mean_N": 0.34}
    with pytest.raises(AttributeError, match="force"):
        by_keys(load, "force_N")


def test_what_json_has_no_word_for() -> None:
    given = {"a": math.inf, "b": 1.0 + 2.0j, "c": np.array([1.0, math.nan]), "d": np.float32(0.5), "e": (True, None)}
    told = {"a": None, "b": {"re": 1.0, "im": 2.0}, "c": [1.0, None], "d": 0.5, "e": [True, None]}
    assert plain(given) == told
    for wrong in (3.0, "text", fr.Rod, None):
        with pytest.raises(TypeError, match="result must be a result of floquetrod"):
            fr.to_json(wrong)
        with pytest.raises(TypeError, match="result must be a result of floquetrod"):
            fr.to_pandas(wrong)
    with pytest.raises(ValueError, match="indent"):
        fr.to_json(ROD, indent=-1)


def test_without_pandas_its_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"pip install floquetrod\[pandas\]"):
        fr.to_pandas(LEVEL)


@pytest.mark.slow
def test_tables_of_pandas() -> None:
    pytest.importorskip("pandas", reason="pip install floquetrod[pandas]")
    found = ALL["mean force"]()
    table = fr.to_pandas(found)
    assert table["depth_m"].tolist() == found.depth.tolist()
    assert {"force_N", "contact_N_per_m", "is_helix"} <= set(table.columns)
    assert len(fr.to_pandas(ALL["reach"]())) == 2
    assert fr.to_pandas(LEVEL)["depth"].tolist() == [0.0, 300.0]
    ranges = ALL["ranges"]()
    assert fr.to_pandas(ranges).iloc[:, :2].to_numpy().tolist() == [[each.low, each.high] for each in ranges]
    compared = ALL["comparison"]()
    methods = fr.to_pandas(compared)
    assert set(methods["method"]) >= {"reference", "monodromy"}
    assert methods["exponents_per_tau_0_re"].tolist() == [each.exponents[0].real for each in compared.results]
    chart = ALL["chart"]()
    points = fr.to_pandas(chart)
    assert points["stable"].tolist() == chart.stable.ravel().tolist()
    assert points.iloc[:, 0].tolist() == np.tile(chart.x.values, chart.y.values.size).tolist()
    assert points.iloc[:, 1].tolist() == np.repeat(chart.y.values, chart.x.values.size).tolist()
    assert len(fr.to_pandas(chart.bands)) == len(chart.bands) > 0
    tongues = fr.systems.first_order_tongues(fr.HillSystem(np.diag([1.0, 4.0]), cosines=[0.1 * np.ones((2, 2))]))
    assert fr.to_pandas(tongues)["frequency"].tolist() == [tongue.frequency for tongue in tongues]
    with pytest.raises(TypeError, match="must have a table"):
        fr.to_pandas(ALL["stress"]())


@pytest.mark.slow
def test_a_branch_is_a_table_with_a_row_for_each_orbit() -> None:
    pytest.importorskip("pandas", reason="pip install floquetrod[pandas]")

    def turning(_: float, x: np.ndarray, p: Mapping[str, float]) -> np.ndarray:
        return np.array([x[1] + x[0] * (p["size"] - x @ x), -x[0] + x[1] * (p["size"] - x @ x)])

    orbit = fr.periodic_orbit(fr.NonlinearSystem(turning, parameters={"size": 1.0}), [1.0, 0.0], period=6.28)
    branch = fr.follow(orbit, over={"size": (1.0, 1.1)})
    table = fr.to_pandas(branch)
    assert table["size"].tolist() == branch.values.tolist()
    assert table["largest_1"].tolist() == branch.largest[:, 1].tolist()
    first = branch.multipliers[:, 0]
    assert np.array_equal(table["multipliers_0_re"], first.real)
    assert np.array_equal(table["multipliers_0_im"], first.imag)


@pytest.mark.slow
def test_neither_pandas_nor_pint_is_imported() -> None:
    code = "import floquetrod as fr, sys; fr.to_json(fr.Rod.nitinol()); print({'pandas', 'pint'} & set(sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "set()\n"
