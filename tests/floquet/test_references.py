"""Every result says what to cite, for every method there is."""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from typing import Any

import pytest

import floquetrod as fr
from floquetrod.floquet import references
from floquetrod.floquet.problems import KINDS
from floquetrod.floquet.references import FLOQUETROD, STUDY
from floquetrod.floquet.registry import METHODS, methods_for, sources

MATHIEU = fr.Mathieu(0.5, -0.25)
SYSTEM = fr.HillSystem([[1.0, 0.0], [0.0, 4.0]], cosines=[[[0.1, 0.2], [0.2, 0.16]]])
ROD = fr.Rod.nitinol()
LOAD = fr.AxialLoad(0.34, 0.34, 150.0)


def test_every_method_has_sources_and_a_sentence_and_an_accuracy() -> None:
    for kind in KINDS:
        assert kind.proof_sources or kind.field == "delayed_moments"  # of which there are no proofs
        for method in methods_for(kind.field):
            service = getattr(method, kind.field)
            assert service.sources
            assert service.does
            assert 0.0 < service.accuracy < 1e-3
    with pytest.raises(KeyError):
        sources(MATHIEU, "guess")
    with pytest.raises(ValueError, match="segmented is a method for systems, not for scalar equations"):
        sources(MATHIEU, "segmented")


def test_every_method_is_named_where_people_look() -> None:
    shown = runpy.run_path(str(Path(__file__).parents[2] / "docs/method_list.py"))["described"]
    for kind in KINDS:
        lines = "\n".join(shown(kind.field))
        for method in methods_for(kind.field):
            assert f'"{method.name}"' in str(fr.stability.__doc__)
            assert f".{method.name}\n" in f"{lines}\n"
    assert {method.name for method in methods_for("equations")} < set(fr.methods.__all__)


def test_floquetrod_is_cited_as_its_own_file_says() -> None:
    text = (Path(__file__).parents[2] / "CITATION.cff").read_text(encoding="utf-8")
    for key in ("title", "version"):
        found = re.search(rf'^{key}: "?(.*?)"?$', text, re.MULTILINE)
        assert found
        assert found[1] in FLOQUETROD
    assert re.search(r"name: (.*)", text)[1] in FLOQUETROD  # type: ignore[index]
    assert STUDY.rpartition("doi:")[2] in text


def test_dois_are_stated_elsewhere_in_the_code_too() -> None:
    root = Path(fr.__file__).parent
    text = "".join(path.read_text(encoding="utf-8") for path in root.rglob("*.py") if path.name != "references.py")
    publications = {text for text in vars(references).values() if isinstance(text, str) and "doi:" in text}
    publications |= {text for method in METHODS for service in method[1:] if service for text in service.sources}
    for source in publications:
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
