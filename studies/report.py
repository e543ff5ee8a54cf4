"""The report on the study: claims and figures as Markdown, JSON and one HTML page that needs no other file."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple

from floquetrod._util.result_report import Report
from floquetrod._util.sealed_files import atomic_file
from floquetrod._util.version import __version__
from floquetrod.floquet.references import STUDY_DOI as DOI
from floquetrod.floquet.references import STUDY_TITLE as SOURCE
from floquetrod.plotting import document
from floquetrod.plotting.document import Document, DocumentSection, Illustration
from studies.claims import Claim

FILES = ("claims.md", "claims.json", "report.html")
TITLE = "The published claims, computed"
_COLUMNS = ("claim", "computed", "verdict", "why")


class Picture(NamedTuple):
    """A figure, and the PNG file it was written to."""

    figure: Any
    path: Path


def write_report(folder: Path, claims: Sequence[Claim], pictures: Mapping[str, Picture]) -> list[Path]:
    """Write claims.md, claims.json and report.html; return their paths.

    ``pictures`` are figures and their PNG files by the title they carry.
    """
    texts = markdown(claims, pictures), as_json(claims)
    for name, text in zip(FILES, texts, strict=False):
        with atomic_file(folder / name) as file:
            file.write(text.encode())
    agree = sum(claim.agrees for claim in claims)
    answer = f"{agree} of {len(claims)} claims agree"
    page = Document(TITLE, [f"floquetrod {__version__}"], [answer], list(sections(claims, pictures)))
    document.save(folder / FILES[-1], page)
    return [folder / name for name in FILES]


def verdict(claim: Claim) -> str:
    """Return the result of a claim in a few words."""
    found = "agrees" if claim.agrees else "differs"
    return found if claim.holds else f"NO LONGER FOUND ({found} now)"


def markdown(claims: Sequence[Claim], pictures: Mapping[str, Picture]) -> str:
    """Return the claims as a Markdown table, the figures linked below."""
    lines = [
        f"# {TITLE}",
        "",
        f"{SOURCE}, [DOI {DOI}](https://doi.org/{DOI}), by floquetrod {__version__}.",
        "",
        f"| id | {' | '.join(_COLUMNS)} |",
        "| --- | --- | --- | --- | --- |",
        *(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in _cells(claim))} |" for claim in claims),
        "",
        *(f"![{title}]({picture.path.name})\n" for title, picture in pictures.items()),
    ]
    return "\n".join(lines)


def as_json(claims: Sequence[Claim]) -> str:
    """Return the claims as JSON."""
    record = {"source": SOURCE, "doi": DOI, "version": __version__, "claims": [asdict(claim) for claim in claims]}
    return json.dumps(record, indent=2, allow_nan=False) + "\n"


def sections(claims: Sequence[Claim], pictures: Mapping[str, Picture]) -> Iterator[DocumentSection]:
    """Yield the sections of the page: the source, the claims, the figures."""
    lines = ("paper", SOURCE), ("DOI", f"https://doi.org/{DOI}"), ("made by", f"floquetrod {__version__}")
    yield DocumentSection("Source", Report("", lines))
    for claim in claims:
        name, *texts = _cells(claim)
        yield DocumentSection(name, Report("", [*filter(itemgetter(1), zip(_COLUMNS, texts, strict=True))]))
    for title, picture in pictures.items():
        yield DocumentSection(title, illustrations=[Illustration(partial(_finished, picture), title)])


def _finished(picture: Picture, _: Any) -> Any:
    return picture.figure


def _cells(claim: Claim) -> tuple[str, ...]:
    return claim.id, claim.says, claim.computed, verdict(claim), claim.why
