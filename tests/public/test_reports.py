"""Results say themselves: in lines and tables for a terminal, as a table for a notebook, in numbers for JSON."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from typing import Any

import pytest

import floquetrod as fr
from floquetrod._util.result_report import Report, Table

ROD = fr.Rod.nitinol()
LOAD = fr.AxialLoad(0.34, 0.34, 150.0)
CLAMPED = fr.Rod(207e9, 7850.0, 0.01, 9.0, 0.05, ends="clamped-hinged")
SAFE = {"mean": (0.56, 0.59), "amplitude": 0.33, "frequency": 150.0, "growth_tolerance": 0.05}
SYSTEM = fr.HillSystem([[1.0, 0.0], [0.0, 4.0]], [[[0.1, 0.2], [0.2, 0.16]]], period=2.0)


def _run() -> fr.Simulation:
    return fr.SimulationProblem(ROD, LOAD, duration=0.01, segments=40, frames=5).run()


RESULTS = {
    "independent modes": lambda: ROD.stability(LOAD),
    "coupled modes": lambda: CLAMPED.stability(fr.AxialLoad(500.0, 700.0, 29.0)),
    "friction": lambda: ROD.stability(LOAD, friction=0.1, kick=0.05),
    "equation": lambda: fr.stability(fr.Mathieu(0.5, -0.3, 0.01)),
    "comparison": lambda: fr.compare(fr.Meissner(0.5, -0.3)),
    "comparison of systems": lambda: fr.compare(SYSTEM),
    "response": lambda: fr.response(SYSTEM, [1.0, 0.5], frequency=0.7, unstable=True),
    "gain": lambda: fr.gain(fr.HillSystem([[1.0]], damping=[[0.1]]), frequency=(0.9, 1.1)),
    "output noise": lambda: fr.output_noise(fr.Mathieu(0.3, -0.6, 0.1), 1.0),
    "comparison of responses": lambda: fr.compare(fr.Mathieu(0.3, -0.6, 0.01), force=1.0),
    "system": lambda: fr.stability(SYSTEM),
    "bands": lambda: fr.bands(fr.Hill(0.0, cosines=(1.0,)), phase=[0.0, 1.0], below=2.0),
    "proof": lambda: fr.certify(fr.Mathieu(0.5, -0.3)),
    "proof of a box": lambda: ROD.replace(damping_rate=0.5).certify(**SAFE),
    "proof of parameters": lambda: fr.certify(fr.Mathieu, alpha=(0.1, 0.6), beta=-0.25, damping=0.0),
    "safe box": lambda: ROD.replace(damping_rate=0.5).largest_safe_box(
        fr.AxialLoad(0.57, 0.33, 150.0), vary=["mean"], growth_tolerance=0.05, accuracy=0.5
    ),
    "ranges": lambda: ROD.ranges("mean", amplitude=0.34, frequency=150.0, bounds=(0.0, 2.0), growth_tolerance=0.1),
    "lock-up": lambda: ROD.lock_up(0.2),
    "simulation": _run,
    "findings": lambda: _run().findings(theory=False),
}


class Reader(HTMLParser):
    """Collects the words of a page, and which tags are open."""

    def __init__(self) -> None:
        """Begin with nothing read."""
        super().__init__()
        self.words, self.open = "", list[str]()

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        """Open a tag."""
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        """Close the tag opened last."""
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        """Take words."""
        self.words += f" {data}"


@pytest.mark.parametrize("name", RESULTS)
def test_a_result_says_itself(name: str) -> None:
    result = RESULTS[name]()
    report = result.report()
    reader = Reader()
    reader.feed(result._repr_html_())
    assert not reader.open
    assert reader.words.split()[:3] == str(report).split()[:3]
    for label, text in report.lines:
        assert f"{label:<8}  {text}" in str(report).splitlines()
    for _, layout in [] if report.table is None else report.table.columns:
        assert layout[:1] in ("<", ">", "^", "")  # a number alone would fill columns with its first digit
    assert json.loads(json.dumps(result.as_dict(), allow_nan=False))


def test_a_long_title_does_not_shift_its_column() -> None:
    table = Table([("long title", ">4"), ("", "<1")], [("1", "ab"), ("23", "")])
    assert str(table).splitlines() == ["long title", "         1  ab", "        23"]


def test_a_notebook_takes_no_words_for_tags() -> None:
    table = Table([("<b>", ""), ("&", ">4")], [("<i>", "1")], "<u>")
    html = Report("1 < 2", [("<p>", "a & b")], table, Report("<br>"))._repr_html_()
    reader = Reader()
    reader.feed(html)
    assert reader.words.split() == ["1", "<", "2", "<p>", "a", "&", "b", "<b>", "&", "<i>", "1", "<u>", "<br>"]


def test_lines_are_added_where_they_belong() -> None:
    report = Report("yes", [("one", "1"), ("", "more"), ("two", "2")])
    assert [label for label, _ in report.with_lines([("new", "")], before="two").lines] == ["one", "", "new", "two"]
    assert [label for label, _ in report.with_lines([("new", "")]).lines] == ["one", "", "two", "new"]


@pytest.mark.parametrize("name", ["independent modes", "coupled modes"])
def test_one_report_serves_every_kind_of_modes(name: str) -> None:
    verdict = RESULTS[name]()
    labels = [label for label, _ in verdict.report().lines if label]
    for each in ("rod", "load", "checked", "method"):
        assert each in labels
    assert str(verdict.report(units={"mean": "Fcr", "frequency": "Hz"})).count(" Hz (") >= 1
    with pytest.raises(ValueError, match="units must be of mean, amplitude, frequency, kick, force, length, pressure"):
        verdict.report(units={"weight": "N"})


def test_margins_are_said_with_the_damping_that_stabilises() -> None:
    verdict = ROD.stability(LOAD)
    done: list[int] = []
    margins = verdict.margins(progress=lambda hundredths, _: done.append(hundredths))
    assert done == sorted(done)
    assert done[-1] == 100
    assert margins["mean"] == verdict.mean_force_margin
    lines = dict(verdict.report(margins=margins).lines)
    assert lines["margins"].startswith("mean force  stable ")
    assert lines["damping"].startswith(f"stable with a damping_rate above {verdict.damping_to_stabilise:.6g} 1/s")
    assert verdict.as_dict(margins)["mean_force_margin_below_N"] == margins["mean"].below
    assert "mean_force_margin_below_N" not in verdict.as_dict()


def test_krein_signs_that_must_meet_before_anything_grows() -> None:
    found = fr.stability(fr.HillSystem([[1.0, 0.0], [0.0, 4.0]], [[[0.0, 0.0], [0.0, 0.0]]], period=2.0))
    # exp(2i) and exp(-4i) have the signs + and -; so have exp(4i) and exp(-2i), and 2 and -2 are 2 pi - 4 apart.
    assert found.opposite_signs_apart == pytest.approx(2.0 * 3.141592653589793 - 6.0, abs=1e-9)
    assert found.largest_multiplier_less_1 == 0.0
    assert fr.stability(fr.PeriodicSystem([[0.0, 1.0], [-1.0, -0.1]], period=2.0)).opposite_signs_apart is None


def test_no_heading_of_a_table_is_empty() -> None:
    """A screen reader says that there is one: lines and columns without a name begin with plain cells."""
    html = Report(
        "headline", [("label", "text"), ("", "more")], Table([("", "<4"), ("b", ">4")], [("1", "2")])
    )._repr_html_()
    assert "<th></th>" not in html
    assert html.count("<th>") == 2
