"""The published study made again: every claim comes out as documented, every picture is labelled."""

from __future__ import annotations

import dataclasses
import json
from html import escape
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.figure import Figure
from matplotlib.path import Path as Path2D

import floquetrod as fr
from studies import claims, figures, friction_claims, friction_figures, reproduction
from studies.__main__ import main
from studies.claims import ROD, UNIT
from studies.reproduction import reproduce

Steps = list[tuple[str, int, int]]
COARSE = reproduction.QUICK._replace(chart=12, rod=(8, 6), hill=8, friction=8, kicks=8)


CLAIMS = {
    **claims.frictionless_claims(reproduction.QUICK.maps),
    **friction_claims.friction_claims(reproduction.QUICK.maps),
}
DISAGREE = {"F3-a", "F3-map", "F6-b"}


LONG = {"F8-a", "F8-b", "F3-a", "F3-c", "F3-d", "F3-map", "F5", "F6/7"}
"""Claims that take some tenths of a second and more; `python -m studies` computes all."""


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in CLAIMS])
def test_every_claim_comes_out_as_documented(name: str) -> None:
    claim = CLAIMS[name]()
    assert claim.id == name
    assert claim.holds, claim.computed
    assert claim.agrees == (name not in DISAGREE)
    assert claim.agrees or claim.why


def blank() -> Figure:
    """Return a figure that costs nothing to draw."""
    return Figure(figsize=(1.0, 1.0))


def test_a_study_is_written_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The claims and figures themselves have their own tests; a slow one makes the whole study.
    drawings = [(title, name, blank) for title, name, _ in reproduction._drawings(COARSE)]
    monkeypatch.setattr(reproduction, "_drawings", lambda detail: drawings)
    one = claims.f2_c()
    copies = {name: lambda name=name: dataclasses.replace(one, id=name, computed=f"of {name}") for name in CLAIMS}
    monkeypatch.setattr(reproduction, "frictionless_claims", lambda points: copies)
    monkeypatch.setattr(reproduction, "friction_claims", lambda points: {})
    seen: Steps = []
    result = reproduce(tmp_path / "new", detail=COARSE, progress=lambda *step: seen.append(step))
    check_progress(result, seen)
    check_report(tmp_path / "new", result)


@pytest.mark.slow
def test_the_study_is_made_again(tmp_path: Path) -> None:
    folder = tmp_path / "new"
    seen: Steps = []
    result = reproduce(folder, detail=COARSE, progress=lambda *step: seen.append(step))
    assert not result.lost, [claim.computed for claim in result.lost]
    assert [claim.id for claim in result.claims] == list(CLAIMS)
    check_progress(result, seen)
    check_report(folder, result)


def check_progress(result: reproduction.Reproduction, seen: Steps) -> None:
    """Progress is told step by step and ends at the end."""
    total = seen[-1][2]
    assert [done for _, done, _ in seen] == list(range(total + 1))
    assert total == len(result.claims) + 6


def check_report(folder: Path, result: reproduction.Reproduction) -> None:
    """All that was written is there, and the report holds every claim and picture."""
    assert {path.name for path in folder.iterdir()} == {path.name for path in result.written}
    record = json.loads((folder / "claims.json").read_text())
    assert [claim["computed"] for claim in record["claims"]] == [claim.computed for claim in result.claims]
    table = [line for line in (folder / "claims.md").read_text().splitlines() if line.startswith("| F")]
    assert len(table) == len(result.claims)
    assert all(line.count(" | ") == 4 for line in table)

    class Page(HTMLParser):
        rows = images = 0
        outside: list[str] = []  # noqa: RUF012

        def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
            self.rows += tag == "tr"
            source = dict(attrs).get("src", "")
            if tag == "img":
                self.images += 1
                if not str(source).startswith("data:image/svg+xml;base64,"):
                    self.outside.append(str(source))

    page = Page()
    text = (folder / "report.html").read_text()
    page.feed(text)
    assert all(escape(said) in text for claim in result.claims for said in (claim.says, claim.computed, claim.why))
    rows = sum(4 if claim.why else 3 for claim in result.claims)
    assert (page.rows, page.images, page.outside) == (rows + 3, 6, [])


def test_a_lost_claim_makes_the_command_fail(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    right = claims.f2_c()
    wrong = dataclasses.replace(right, holds=False)
    monkeypatch.setattr(reproduction, "_drawings", lambda detail: [])
    for claim, status in ((right, 0), (wrong, 1)):
        monkeypatch.setattr(reproduction, "friction_claims", lambda points: {})
        monkeypatch.setattr(reproduction, "frictionless_claims", lambda points, claim=claim: {"F2-c": lambda: claim})
        assert main(["--quick", "--out", str(tmp_path / "out")]) == status
        assert ("NO LONGER FOUND" in capsys.readouterr().out) == bool(status)


def test_claims_hold_python_values() -> None:
    claim = friction_claims.f6_b()
    assert (type(claim.agrees), type(claim.holds)) == (bool, bool)  # JSON takes no others


def test_claims_notice_a_change(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        claims.mathieu, "is_stable", lambda alpha, beta, **_: np.full(np.broadcast(alpha, beta).shape, True)
    )
    assert not claims.f2_a().holds
    assert not claims.f2_c().holds


def test_out_must_be_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    assert main(["--quick", "--out", str(tmp_path / "file")]) == 2
    assert "--out must be a folder" in capsys.readouterr().err


@pytest.mark.slow
def test_intervals_and_tongues_are_the_exact_verdict(rng: np.random.Generator) -> None:
    wide = [band for band in figures.unstable_intervals(0.2, 85.0, 0.6) if band.high - band.low > 1e-9]
    assert len(wide) > 10
    for band in wide:
        middle, inside = 0.5 * (band.low + band.high), 0.49 * (band.high - band.low)
        equations = [
            ROD.modal_system(fr.AxialLoad(f * UNIT, 0.2 * UNIT, 85.0), [band.mode]).equations[0]
            for f in (middle - inside, middle, middle + inside)
        ]
        growth = [fr.stability(equation).growth_rate for equation in equations]
        assert min(growth) > (claims.EXACT.threshold if band.seen else 0.0)
    omega, force = rng.uniform(20.0, 200.0, 2000), rng.uniform(0.0, 1.1, 2000)
    growth = ROD.growth_rate(mean=force * UNIT, amplitude=0.2 * UNIT, frequency=omega)
    inside = np.zeros(omega.size, dtype=bool)
    for tongue in figures.tongues(0.2):
        inside |= Path2D(np.column_stack([tongue.x, tongue.y])).contains_points(np.column_stack([omega, force]))
    assert inside[growth > 0.01 * omega].all()
    assert (growth[inside] > 0.0).mean() > 0.99  # edges depart from the boundaries by half a pixel at most


@pytest.mark.slow
@pytest.mark.parametrize(
    "draw",
    [
        lambda: figures.figure_2(12),
        pytest.param(lambda: figures.figure_3((8, 6)), marks=pytest.mark.slow),
        pytest.param(lambda: figures.figure_8(8, 12), marks=pytest.mark.slow),
        lambda: friction_figures.figure_5(12),
        pytest.param(lambda: friction_figures.figure_6(8), marks=pytest.mark.slow),
        pytest.param(lambda: friction_figures.figure_kick(8), marks=pytest.mark.slow),
    ],
)
def test_figures_are_labelled(draw: object) -> None:
    figure = draw()  # type: ignore[operator]
    assert all((ax.get_xlabel() or ax.get_label() == "<colorbar>") and ax.get_ylabel() for ax in figure.axes)
    panels = [ax for ax in figure.axes if ax.get_label() != "<colorbar>"]
    letters = "abcdef"[: len(panels)] if len(panels) > 1 else ""
    assert "".join(ax.get_title(loc="left").strip("()") for ax in panels) == letters
    assert len(figure.get_supxlabel()) > 100
    assert not pyplot.get_fignums()  # no figure is left open behind the user's back
