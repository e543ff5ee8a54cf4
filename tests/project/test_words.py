"""Words: the field's are used; those of our own over which readers stumbled stay out of pages, docstrings, messages."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
PRIVATE = {
    "along the level": "horizontal distance",
    "anew": "again",
    "as a part of": "as a fraction of",
    "as a share of": "as a fraction of",
    "bears": "is stable up to; carries",
    "borne": "stable up to; carried",
    "but for": "except for",
    "cannot be told": "determined",
    "could not be told": "determined",
    "does it get": "becomes",
    "fibre stressed most": "largest stress",
    "for granted": "assumed",
    "freed of": "without; removed",
    "judges": "decides; checks; includes",
    "knock": "kick",
    "lessens": "reduces",
    "looked at": "examined",
    "looked for": "searched for",
    "loud": "strong",
    "louder": "stronger",
    "loudest": "strongest; largest density",
    "lumps of force": "concentrated forces",
    "motion gets": "becomes",
    "must be told": "known",
    "now and then": "repeatedly; sometimes",
    "of the trade": "usual",
    "place by place": "local; at each depth",
    "thrown back": "reflected",
    "to the bit": "bit for bit",
    "told as": "given as",
    "what there is": "the results",
    "worst fibre": "largest stress",
}
"""What readers stumbled over, and what the field says; SciPy's and QuTiP's documentation use none of it."""


def private_words(text: str) -> dict[str, str]:
    """Return the private words of a text, each with what the field says."""
    text = text.lower()
    return {word: term for word, term in PRIVATE.items() if word in text and re.search(rf"\b{word}\b", text)}


def texts() -> Iterator[Path]:
    """Yield pages, examples and modules; what only kernels say of themselves, nobody reads without their code."""
    yield ROOT / "README.md"
    for folder, endings in (("docs", "*.md *.rst"), ("examples", "*.py"), ("floquetrod", "*.py"), ("studies", "*.py")):
        for path in (path for ending in endings.split() for path in (ROOT / folder).rglob(ending)):
            folders = set(path.relative_to(ROOT).parts)
            if not {"_build", "gallery", "kernels", "pages"} & folders and path.name != "changelog.md":
                yield path


def test_private_words_stay_out() -> None:
    said = {path.relative_to(ROOT).as_posix(): private_words(path.read_text(encoding="utf-8")) for path in texts()}
    assert len(said) > 400
    assert {path: words for path, words in said.items() if words} == {}


def test_a_private_word_is_seen() -> None:
    text = "A wave is thrown back; noise is borne, the loudest too, for clouds can be told apart."
    assert [*private_words(text)] == ["borne", "loudest", "thrown back"]
