"""Rods, loads, tools, equations, systems and charts show themselves in a notebook, by the report that results have."""

from __future__ import annotations

import dataclasses

import pytest
from matplotlib import pyplot

import floquetrod as fr
from floquetrod._util.result_report import ShownInNotebook
from tests.public.test_reports import Reader

WELL = fr.WellPath([0.0, 900.0, 1800.0], ["0deg", "0deg", "90deg"])
STRING = fr.Rod(
    sections=[
        fr.Section("2.00x0.156", length="35m"),
        fr.Section(diameter="2.875in", inner_diameter="1in", length="5m"),
    ],
    channel_diameter="4.778in",
    fluid_inside="8.6ppg",
)
MATRICES = ([[1.0, 0.0], [0.0, 4.0]], [[[0.1, 0.2], [0.2, 0.16]]])
VALUES = {
    "rod": (fr.Rod.nitinol(), ["1.6 mm rod, 3.1 m, in a 9.4 mm bore", "68 GPa", "6500 kg/m3", "1.696 N", "mode 6.14"]),
    "rod in feet": (
        fr.Rod.catalogue("2.00x0.156", bore="4.778in", length="200ft"),
        ["200 ft", "4.778 in", "Mpsi", "lbf"],
    ),
    "string": (STRING, ["string of 2 sections", "fluid inside", "section", "weight in fluid"]),
    "rod in a well": (
        fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length="60m", path=WELL, depth=1200.0),
        ["60 m", "yield", "1200 m"],
    ),
    "load": (fr.AxialLoad("4N", "2N", "16Hz"), ["AxialLoad", "mean", "4 N", "2 N", "16 Hz"]),
    "load in lbf": (fr.AxialLoad("400lbf", "200lbf", "16Hz"), ["400 lbf", "16 Hz"]),
    "wave": (
        fr.AxialWave(6e3, 2e3, "18Hz", mean_at=0.2, far_end="driven"),
        ["AxialWave", "driven", "0.2 of the length"],
    ),
    "tool": (fr.VibrationTool("5kN", "18Hz", "30m"), ["vibration tool", "5 kN", "18 Hz", "30 m above the lower end"]),
    "Mathieu": (fr.Mathieu(0.5, -0.25), ["Mathieu's equation", "alpha", "0.5", "beta", "-0.25", "period 6.28319"]),
    "Mathieu in (a, q)": (fr.Mathieu.from_aq(1.2, 0.9), ["Mathieu's equation", "a 1.2", "q 0.9", "period 3.14159"]),
    "Meissner": (fr.Meissner(0.5, -0.25), ["Meissner's equation", "beta -0.25"]),
    "Hill": (fr.Hill(-0.3, cosines=(0.1, 0.2)), ["Hill's equation", "(0.1, 0.2)"]),
    "HillSystem": (
        fr.HillSystem(*MATRICES, period=2.0),
        ["HillSystem of order 2, 1 harmonic", "[[1.0, 0.0], [0.0, 4.0]]"],
    ),
    "PeriodicSystem": (fr.PeriodicSystem([[0.0, 1.0], [-1.0, -0.1]], period=2.0), ["order 2, constant coefficients"]),
    "well": (WELL, ["well path of 3 stations", "inc deg"]),
}


@pytest.mark.parametrize("name", VALUES)
def test_a_value_shows_itself(name: str) -> None:
    value, words = VALUES[name]
    reader = Reader()
    reader.feed(value._repr_html_())
    assert not reader.open
    shown = " ".join(reader.words.split())
    assert [each for each in words if each not in shown] == []
    assert value._repr_html_.__func__ is ShownInNotebook._repr_html_


def test_a_notebook_takes_nothing_in_an_equation_for_tags() -> None:
    @dataclasses.dataclass(frozen=True)
    class Own(fr.Mathieu):
        note: str = "<b>1 < 2</b>"

    assert "&lt;b&gt;1 &lt; 2&lt;/b&gt;" in Own(0.5, -0.25)._repr_html_()


@pytest.mark.parametrize("growth", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_a_chart_shows_its_picture_once(growth: bool) -> None:
    chart = fr.chart(fr.Mathieu, over={"alpha": [0.1, 0.2, 0.3], "beta": [-0.4, -0.3, -0.2]}, growth=growth)
    for value in (chart, chart.bands):
        assert value._repr_png_().startswith(b"\x89PNG")
    assert pyplot.get_fignums() == []  # a figure of pyplot would be shown a second time
