"""The report on the study: claims and figures as Markdown, JSON and one HTML page that needs no other file."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from floquetrod._util.files import atomic_file
from floquetrod._util.version import __version__
from floquetrod.floquet.references import STUDY_DOI as DOI
from floquetrod.floquet.references import STUDY_TITLE as SOURCE
from studies.claims import Claim

FILES = ("claims.md", "claims.json", "report.html")

_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #111; }
table { border-collapse: collapse; width: 100%; font-size: 0.9rem; }
th, td { border: 1px solid #999; padding: 0.4rem 0.6rem; text-align: left; vertical-align: top; }
th { background: #eee; }
img { max-width: 100%; height: auto; }
.wide { overflow-x: auto; }
"""


def write_report(folder: Path, claims: Sequence[Claim], pictures: dict[str, Path]) -> list[Path]:
    """Write claims.md, claims.json and report.html; return their paths.

    ``pictures`` are PNG files by the title they carry.
    """
    texts = markdown(claims, pictures), as_json(claims), page(claims, pictures)
    for name, text in zip(FILES, texts, strict=True):
        with atomic_file(folder / name) as file:
            file.write(text.encode())
    return [folder / name for name in FILES]


def verdict(claim: Claim) -> str:
    """Return the result of a claim in a few words."""
    found = "agrees" if claim.agrees else "differs"
    return found if claim.holds else f"NO LONGER FOUND ({found} now)"


def markdown(claims: Sequence[Claim], pictures: dict[str, Path]) -> str:
    """Return the claims as a Markdown table, the figures linked below."""
    lines = [
        "# The published claims, computed",
        "",
        f"{SOURCE}, [DOI {DOI}](https://doi.org/{DOI}), by floquetrod {__version__}.",
        "",
        "| id | claim | computed | verdict | why |",
        "| --- | --- | --- | --- | --- |",
        *(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in _cells(claim))} |" for claim in claims),
        "",
        *(f"![{title}]({path.name})\n" for title, path in pictures.items()),
    ]
    return "\n".join(lines)


def as_json(claims: Sequence[Claim]) -> str:
    """Return the claims as JSON."""
    record = {"source": SOURCE, "doi": DOI, "version": __version__, "claims": [asdict(claim) for claim in claims]}
    return json.dumps(record, indent=2, allow_nan=False) + "\n"


def page(claims: Sequence[Claim], pictures: dict[str, Path]) -> str:
    """Return the whole report as one HTML page with its pictures inside."""
    head = "".join(f"<th>{name}</th>" for name in ("id", "claim", "computed", "verdict", "why"))
    rows = "\n".join(
        f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in _cells(claim))}</tr>" for claim in claims
    )
    images = "\n".join(
        f'<h2>{html.escape(title)}</h2>\n<img alt="{html.escape(title)}" src="data:image/png;base64,'
        f'{base64.b64encode(path.read_bytes()).decode()}">'
        for title, path in pictures.items()
    )
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>The published claims, computed</title>
<style>{_STYLE}</style>
</head>
<body>
<h1>The published claims, computed</h1>
<p>{html.escape(SOURCE)}, <a href="https://doi.org/{DOI}">DOI {DOI}</a>, by floquetrod {__version__}.</p>
<div class="wide"><table>
<tr>{head}</tr>
{rows}
</table></div>
{images}
</body>
</html>
"""


def _cells(claim: Claim) -> tuple[str, ...]:
    return claim.id, claim.says, claim.computed, verdict(claim), claim.why
