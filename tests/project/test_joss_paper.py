"""The paper on the package: what it cites is listed, what is listed is cited, and every publication has a link."""

from __future__ import annotations

import re
from pathlib import Path

FOLDER = Path(__file__).parents[2] / "docs/paper"
TEXT = (FOLDER / "paper.md").read_text(encoding="utf-8")
ENTRIES = dict(
    re.findall(r"(?m)^@\w+\{(\w+),\n(.*?)\n\}$", (FOLDER / "paper.bib").read_text(encoding="utf-8"), re.DOTALL)
)


def test_what_is_cited_is_what_is_listed() -> None:
    assert set(re.findall(r"(?<![\w.])@(\w+)", TEXT)) == set(ENTRIES)


def test_every_publication_has_a_permanent_link() -> None:
    for name, entry in ENTRIES.items():
        assert re.search(
            r"^  (?:doi = \{10\.\d{4,5}/\S+\}|url = \{https://\S+\}|isbn = \{\d{10}\}),?$", entry, re.MULTILINE
        ), name
        assert re.search(r"^  year = \{\d{4}\},?$", entry, re.MULTILINE), name


def test_it_has_the_sections_of_the_journal_and_its_length() -> None:
    sections = re.findall(r"(?m)^# (.+)$", TEXT)
    assert sections[:3] == ["Summary", "Statement of need", "State of the field"]
    assert sections[-2:] == ["Acknowledgements", "References"]
    assert 1000 < len(re.findall(r"\w+", TEXT)) < 2200
