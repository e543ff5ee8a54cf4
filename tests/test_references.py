"""Every result says what to cite, for every method there is."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

import floquetrod as fr
from floquetrod.floquet.references import FLOQUETROD, SOURCES, STUDY, references
from floquetrod.floquet.registry import METHODS

MATHIEU = fr.Mathieu(0.5, -0.25)
SYSTEM = fr.HillSystem([[1.0, 0.0], [0.0, 4.0]], cosines=[[[0.1, 0.2], [0.2, 0.16]]])
ROD = fr.Rod.nitinol()
LOAD = fr.AxialLoad(0.34, 0.34, 150.0)


def test_every_method_has_sources_and_no_others_have() -> None:
    named = {("equation", method.name) for method in METHODS if method.equations is not None}
    named |= {("system", method.name) for method in METHODS if method.systems is not None}
    named |= {("delays", method.name) for method in METHODS if method.delays is not None}
    others = {("equation", "certify"), ("system", "certify"), ("any", "solve"), ("any", "noise"), ("rod", "model")}
    others |= {("delays", "certify"), ("delays", "solve")}
    others.add(("orbit", "collocation"))
    assert SOURCES.keys() == named | others
    assert all(SOURCES.values())
    with pytest.raises(KeyError):
        references(("equation", "guess"))


def test_every_method_is_named_where_people_look() -> None:
    page = (Path(__file__).parents[1] / "docs/reference/verdicts.rst").read_text(encoding="utf-8")
    systems = (Path(__file__).parents[1] / "docs/reference/systems.rst").read_text(encoding="utf-8")
    delays = (Path(__file__).parents[1] / "docs/reference/delays.rst").read_text(encoding="utf-8")
    for method in METHODS:
        assert f'"{method.name}"' in str(fr.stability.__doc__)
        assert method.equations is None or f"floquetrod.methods.{method.name}\n" in page
        assert method.delays is None or f"methods.delay_{method.name}.{method.name}\n" in delays
        assert method.systems is None or f"methods.system_{method.name}.{method.name}\n" in systems


def test_floquetrod_is_cited_as_its_own_file_says() -> None:
    text = (Path(__file__).parents[1] / "CITATION.cff").read_text(encoding="utf-8")
    for key in ("title", "version"):
        found = re.search(rf'^{key}: "?(.*?)"?$', text, re.MULTILINE)
        assert found
        assert found[1] in FLOQUETROD
    assert re.search(r"name: (.*)", text)[1] in FLOQUETROD  # type: ignore[index]
    assert STUDY.rpartition("doi:")[2] in text


def test_dois_are_stated_elsewhere_in_the_code_too() -> None:
    root = Path(fr.__file__).parent
    text = "".join(path.read_text(encoding="utf-8") for path in root.rglob("*.py") if path.name != "references.py")
    for source in {each for every in SOURCES.values() for each in every}:
        assert "doi:" not in source or source.rpartition("doi:")[2] in text


RESULTS: list[Any] = [
    fr.stability(MATHIEU),
    fr.stability(MATHIEU, "square_wave"),
    fr.stability(SYSTEM),
    fr.certify(MATHIEU),
    fr.certify(SYSTEM),
    fr.solve(MATHIEU, (1.0, 0.0), 2.0),
    ROD.stability(LOAD),
    ROD.stability(LOAD, friction=0.1, kick=0.05),
    ROD.replace(ends="clamped").stability(LOAD, range(1, 7)),
]


@pytest.mark.parametrize("result", RESULTS, ids=lambda result: type(result).__name__)
def test_results_say_what_to_cite(result: Any) -> None:
    assert result.references[0] == FLOQUETROD
    assert len(result.references) > 1
    assert all(isinstance(each, str) for each in result.references)
    assert len(set(result.references)) == len(result.references)


def test_a_rod_cites_the_study_and_its_methods() -> None:
    found = ROD.stability(LOAD)
    assert STUDY in found.references
    assert set(found.mode_verdicts[0].references) <= set(found.references)
    every = fr.compare(MATHIEU)
    assert {each for result in every.results for each in result.references} == set(every.references)
