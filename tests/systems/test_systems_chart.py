"""`fr.chart`: verdicts on any family over the plane of two parameters."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot

import floquetrod as fr
from floquetrod.plotting.chart_plot import draw_chart
from floquetrod.systems import batch_verdicts
from tests.inside import half_period

mpl.use("Agg")

OVER = {"omega": (2.0, 4.0, 5), "epsilon": (0.1, 0.3, 3)}


def coupled(omega: float, epsilon: float, c: tuple[float, float] = (0.0, 0.0)) -> fr.HillSystem:
    """Return two coupled Mathieu equations."""
    forcing = epsilon * np.array([[0.5, 1.0], [1.0, 0.8]])
    return fr.HillSystem(np.diag([1.0, 4.0]), [forcing], damping=2.0 * np.diag(c), period=2.0 * math.pi / omega)


def blade(advance: float, lock: float) -> fr.PeriodicSystem:
    """Return the flapping of a rotor blade."""
    g, m = lock / 8.0, 4.0 / 3.0 * advance
    return fr.PeriodicSystem(
        [[0.0, 1.0], [-1.0, -g]],
        [[[0.0, 0.0], [-g * m, 0.0]]],
        [[[0.0, 0.0], [0.0, -g * m]], [[0.0, 0.0], [-g * advance**2, 0.0]]],
    )


def test_a_chart_is_its_verdicts() -> None:
    chart = fr.chart(coupled, over=OVER, growth=True)
    assert chart.stable.shape == (3, 5)
    assert chart.growth_rate is not None
    for row, epsilon in enumerate(chart.y.values):
        for column, omega in enumerate(chart.x.values):
            result = fr.stability(coupled(omega, epsilon))
            assert chart.stable[row, column] == result.stable
            assert chart.growth_rate[row, column] == pytest.approx(result.growth_rate, rel=1e-9, abs=1e-12)
    assert chart.stable[1].tolist() == [False, True, False, True, False]
    assert chart.growth_rate[1, 2] == pytest.approx(0.03532777753665963, rel=1e-9)
    assert (chart.x.name, chart.y.name) == ("omega", "epsilon")
    assert (chart.x.label, chart.y.label) == (r"$\omega$", r"$\epsilon$")
    assert chart.growth_unit == "per unit time"
    share = f"{100.0 * chart.stable.mean():.1f} %"
    assert repr(chart) == f"<epsilon over omega; system of 2 equations: {share} of 15 points stable>"
    assert fr.chart(coupled, over=OVER).growth_rate is None
    assert fr.chart(coupled, over=OVER, workers=1) == fr.chart(coupled, over=OVER, workers=2)


@pytest.mark.slow
def test_bands_are_named_by_their_resonance(tmp_path: Path) -> None:
    """Of natural frequencies 1 and 2 a symmetric coupling forces the sum, an antisymmetric one the difference."""

    def skew(omega: float, epsilon: float) -> fr.HillSystem:
        return fr.HillSystem(
            np.diag([1.0, 4.0]), [epsilon * np.array([[0.0, 1.0], [-1.0, 0.0]])], period=math.tau / omega
        )

    for family, where, names in (
        (coupled, (2.7, 4.2), {"modes 1 + 2, tongue 1": 3.0, "mode 2, tongue 1": 4.0}),
        (skew, (0.8, 1.2), {"modes 2 - 1, tongue 1": 1.0}),
    ):
        chart = fr.chart(family, over={"omega": (*where, 31), "epsilon": (0.2, 0.4, 3)})
        found = {band.name: band.place[0] for band in chart.bands}
        assert found == pytest.approx(names, abs=0.1)
        chart.save(tmp_path / "chart.npz")
        assert [band.name for band in fr.Chart.load(tmp_path / "chart.npz").bands] == list(found)
    with pytest.raises(ValueError, match=r"over\['omega'\] must be .* without a number of points"):
        fr.chart(coupled, over={"omega": (2.0, 4.0), "epsilon": (0.1, 0.3, 3)})


def test_a_tolerance_of_zero_excuses_no_drift() -> None:
    def free(stiffness: float, mass: float) -> fr.HillSystem:
        return fr.HillSystem([[stiffness]], mass=[[mass]])

    over = {"stiffness": [0.0, 1.0], "mass": [1.0, 2.0]}
    result = fr.stability(free(0.0, 1.0))
    assert (result.status, result.growth_rate) == ("unstable", 0.0)
    assert fr.chart(free, over=over).stable.tolist() == [[False, True]] * 2
    assert fr.chart(free, over=over, growth_tolerance=1e-3).stable.all()

    def equation(alpha: float, beta: float) -> fr.Mathieu:
        return fr.Mathieu(alpha=alpha, beta=beta)

    over = {"alpha": [0.0, 1e-3], "beta": [-0.1, 0.0]}
    assert fr.stability(equation(0.0, 0.0)).status == "unstable"
    assert not fr.chart(equation, over=over).stable[1, 0]
    assert fr.chart(equation, over=over, growth_tolerance=1e-3).stable[1, 0]


def test_systems_of_first_order_and_equations() -> None:
    over = {"advance": [0.5, 1.0, 1.5, 2.0], "lock": (8.0, 12.0, 2)}
    chart = fr.chart(blade, over=over, growth=True)
    assert chart.stable.tolist() == [[True, True, False, False], [True, True, False, False]]
    assert chart.caption.startswith("system of 2 equations of first order: 50.0 % of 8 points stable")
    assert chart.x.label == "advance"
    scalar = fr.chart(
        lambda alpha, beta: fr.Mathieu(alpha, beta), over={"alpha": (0.1, 2.0, 5), "beta": (-1.0, 0.0, 4)}
    )
    assert np.array_equal(scalar.stable, fr.mathieu.is_stable(scalar.x.values, scalar.y.values[:, None]))
    assert scalar.growth_unit == "per tau"
    assert scalar.caption.startswith("Mathieu's equation: ")


def test_a_scalar_family_and_its_system_have_one_chart() -> None:
    def equation(a: float, b: float) -> fr.Hill:
        return fr.Hill(b, sines=(a, 0.4 * a), damping=0.05)

    over = {"a": (0.1, 1.5, 6), "b": (-1.5, -0.05, 5)}
    scalar = fr.chart(equation, over=over, growth=True)
    system = fr.chart(lambda **point: equation(**point).as_system(), over=over, growth=True)
    mathieu = fr.mathieu.chart(over["a"], over["b"], equation=lambda a, b, c: equation(a, b), growth=True)
    assert np.array_equal(scalar.stable, system.stable)
    assert np.array_equal(scalar.stable, mathieu.stable)
    assert scalar.growth_rate is not None
    assert system.growth_rate is not None
    assert np.allclose(scalar.growth_rate, system.growth_rate, rtol=1e-8, atol=1e-9)
    assert system.caption.startswith("system of 1 equation: ")


def test_families_of_several_orders_are_named_so() -> None:
    def chain(size: float, epsilon: float) -> fr.HillSystem:
        n = round(size)
        return fr.HillSystem(np.diag(np.arange(1.0, n + 1.0)), [epsilon * np.eye(n)], period=1.0)

    chart = fr.chart(chain, over={"size": [1.0, 2.0], "epsilon": [0.1, 0.2]})
    assert chart.caption.startswith("system of 1 equation, system of 2 equations: ")


def test_growth_up_to_the_tolerance_is_stable() -> None:
    tolerant = fr.chart(coupled, over=OVER, growth_tolerance=0.04)
    strict = fr.chart(coupled, over=OVER, growth=True)
    assert strict.growth_rate is not None
    assert np.array_equal(tolerant.stable, strict.growth_rate <= 0.04)
    assert (tolerant.stable != strict.stable).any()
    assert "growth up to 0.04 per unit time counts as stable" in tolerant.caption


def test_undecided_points_are_counted_and_not_called_stable(monkeypatch: pytest.MonkeyPatch) -> None:
    """At omega = 3 two multipliers of opposite Krein signs meet, and the forcing is too weak to tell what follows."""
    monkeypatch.setattr(batch_verdicts, "judge", lambda system, **digits: half_period(system))
    chart = fr.chart(coupled, over={"omega": [2.9, 3.0, 3.1], "epsilon": [1e-15, 0.01]}, growth=True)
    assert chart.undecided == 1
    assert not chart.stable[0, 1]
    assert "; 1 undecided" in chart.caption


def test_rows_are_reported_and_can_be_stopped() -> None:
    seen: list[tuple[int, int]] = []
    fr.chart(coupled, over=OVER, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(5, 15), (10, 15), (15, 15)]

    def interrupted(omega: float, epsilon: float) -> fr.HillSystem:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fr.chart(interrupted, over=OVER)


@pytest.mark.parametrize("growth", [True, False])
def test_a_saved_chart_loads_identically(growth: bool, tmp_path: Path) -> None:
    chart = fr.chart(coupled, over=OVER, growth=growth)
    assert chart.subject["name"] == "coupled"
    assert fr.Chart.load(chart.save(tmp_path / "chart.npz")) == chart


def test_a_function_of_no_module_is_charted_under_its_name() -> None:
    known = {"coupled": coupled}
    exec("def by_hand(omega, epsilon): return coupled(omega, epsilon)", known)
    assert known["by_hand"].__module__ is None
    assert fr.chart(known["by_hand"], over=OVER).subject["name"] == "by_hand"


@pytest.mark.slow
@pytest.mark.parametrize("omega", [(5.0, 6.0, 3), (2.9, 3.1, 3)])
def test_a_plot_has_a_bar_of_growth_where_something_grows(omega: tuple[float, float, int]) -> None:
    chart = fr.chart(coupled, over={"omega": omega, "epsilon": (0.2, 0.3, 3)}, growth=True)
    grows = bool((~chart.stable).any())
    assert grows is (omega[0] < 5.0)
    for axes in (chart.plot(), draw_chart(chart)):
        bars = [other for other in axes.figure.axes if "growth rate" in other.get_ylabel()]
        assert [bar.get_ylim()[0] for bar in bars] == [0.0] * grows
        axes.figure.canvas.draw()
        pyplot.close(axes.figure)


@pytest.mark.slow
def test_a_plot_is_labelled() -> None:
    chart = fr.chart(coupled, over=OVER, growth=True)
    axes = chart.plot()
    assert (axes.get_xlabel(), axes.get_ylabel()) == (r"$\omega$", r"$\epsilon$")
    assert "growth rate per unit of time" in [other.get_ylabel() for other in axes.figure.axes]
    assert axes.get_title().startswith("coupled: system of 2 equations")
    unnamed = fr.chart(lambda **point: coupled(**point), over=OVER).plot()
    assert unnamed.get_title().startswith("system of 2 equations")
    ours = fr.chart(fr.Mathieu.from_aq, over={"q": (0.0, 1.0, 3), "a": (0.5, 1.5, 3)}).plot()
    assert ours.get_title() == "Mathieu's equation"
    axes.figure.canvas.draw()
    pyplot.close(axes.figure)


@pytest.mark.parametrize(
    ("name", "label"),
    [
        pytest.param("omega", r"$\omega$", marks=pytest.mark.slow),
        ("omega_1", r"$\omega_{1}$"),
        pytest.param("q_x", "$q_{x}$", marks=pytest.mark.slow),
        pytest.param("k", "$k$", marks=pytest.mark.slow),
        pytest.param("k2", "$k_{2}$", marks=pytest.mark.slow),
        pytest.param("Omega", r"$\Omega$", marks=pytest.mark.slow),
        pytest.param("load_factor", "load_factor", marks=pytest.mark.slow),
        pytest.param("advance", "advance", marks=pytest.mark.slow),
    ],
)
def test_axes_bear_symbols_or_words(name: str, label: str) -> None:
    over = {name: [1.0, 2.0], "other": [0.1, 0.2]}
    chart = fr.chart(lambda **point: fr.HillSystem([[point[name]]], [[[point["other"]]]]), over=over)
    assert chart.x.label == label
    axes = chart.plot()
    axes.figure.canvas.draw()  # where mathematics that cannot be read would show
    pyplot.close(axes.figure)


def sometimes(wrong: Any) -> Any:
    """Return a family with another answer at one point."""
    return lambda omega, epsilon: wrong if (omega, epsilon) == (3.0, 0.2) else coupled(omega, epsilon)


def failing(omega: float, epsilon: float) -> fr.HillSystem:
    return coupled(omega, epsilon if omega < 3.0 else [[1.0 / 0.0]])


@pytest.mark.parametrize(
    ("family", "over", "error", "message"),
    [
        (1.0, OVER, TypeError, "family must be a function, got 1.0"),
        (coupled, [("omega", 1.0)], TypeError, "over must be a mapping of two parameters such as"),
        (coupled, {"omega": (0.0, 1.0, 2)}, ValueError, "over must hold two parameters .* got 1: omega"),
        (coupled, {}, ValueError, "over must hold two parameters .* got 0: none"),
        (coupled, {1: (0.0, 1.0, 2), 2: (0.0, 1.0, 2)}, TypeError, "over must name parameters of the family"),
        (coupled, {"a b": (0.0, 1.0, 2), "c": (0.0, 1.0, 2)}, TypeError, "over must name parameters of the family"),
        (coupled, OVER | {"omega": [2.0, 1.0]}, ValueError, r"over\['omega'\] must increase from value to value"),
        (coupled, OVER | {"omega": 1.0}, ValueError, r"over\['omega'\] must be \(low, high, number\)"),
        (coupled, OVER | {"epsilon": (0.0, 1.0, 1)}, ValueError, r"over\['epsilon'\]\[2\] must be 2 or more"),
        (
            coupled,
            {"w": (1.0, 2.0, 2), "epsilon": (0.0, 1.0, 2)},
            ValueError,
            r"family\(w=1, epsilon=0\) raised TypeError: .*unexpected keyword argument 'w'",
        ),
        (failing, OVER, ValueError, r"family\(omega=3, epsilon=0.1\) raised ZeroDivisionError: "),
        (
            lambda omega, epsilon: fr.HillSystem([[omega]], mass=[[3.0 - omega]]),
            OVER,
            ValueError,
            r"family\(omega=3, epsilon=0.1\) raised ValueError: mass must be positive definite",
        ),
        (sometimes(None), OVER, TypeError, r"family\(omega=3, epsilon=0.2\) must return a HillSystem, .* got None"),
        (sometimes(fr.Mathieu(1.0, 1.0)), OVER, TypeError, r"family\(omega=3, epsilon=0.2\) must return a system"),
        (
            sometimes(fr.HillSystem(np.ones((3, 1, 1)))),
            OVER,
            ValueError,
            r"family\(omega=3, epsilon=0.2\) must return one system, got a batch of shape \(3,\)",
        ),
    ],
)
def test_bad_input(family: Any, over: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        fr.chart(family, over=over)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"growth": 1}, TypeError, "growth must be True or False"),
        ({"growth_tolerance": -1.0}, ValueError, "growth_tolerance must be zero or more"),
        ({"workers": 0}, ValueError, "workers must be 1 or more"),
        ({"progress": 1}, TypeError, "progress must be a function"),
    ],
)
def test_bad_options(options: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        fr.chart(coupled, over=OVER, **options)


def test_the_cause_of_a_failure_is_kept() -> None:
    with pytest.raises(ValueError, match=re.escape("family(omega=3, epsilon=0.1)")) as caught:
        fr.chart(failing, over=OVER)
    assert isinstance(caught.value.__cause__, ZeroDivisionError)


@pytest.mark.slow
def test_a_side_that_has_closed_is_not_followed() -> None:
    # About omega = 1 two outlines meet while a wide side waits to be followed: it had no direction any more.
    def two_meissner(omega: float, epsilon: float) -> fr.HillSystem:
        forcing, half = epsilon * np.array([[0.5, 1.0], [1.0, 0.8]]), math.pi / omega
        mean = np.diag([1.0, 4.0])
        return fr.HillSystem.from_pieces([(half, mean + forcing), (half, mean - forcing)])

    values = {"omega": np.linspace(0.8, 5.0, 80), "epsilon": np.linspace(0.0, 0.8, 60)}
    found = fr.chart(two_meissner, over=values).find_bands()
    assert len(found) >= 8


@pytest.mark.slow
def test_one_equation_has_the_tongues_of_its_verdicts_and_of_its_system() -> None:
    over = {"q": (0.0, 10.0, 40), "a": (-5.0, 10.0, 30)}
    chart = fr.chart(lambda q, a: fr.Mathieu.from_aq(a, q), over=over, growth=True)
    same = fr.chart(lambda q, a: fr.Mathieu.from_aq(a, q).as_system(), over=over, growth=True)
    for band in chart.bands:
        q, a = band.place
        assert fr.stability(fr.Mathieu.from_aq(a, q)).interval == ("tongue", band.tongue)
    assert sorted(band.name for band in chart.bands) == ["tongue 0", "tongue 1", "tongue 2", "tongue 3"]
    assert {band.tongue or 0 for band in same.bands} == {0, 1, 2, 3}
