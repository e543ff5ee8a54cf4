"""One colour, one meaning: only the palette names colours of areas, and they differ in grey too."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from matplotlib.colors import to_rgb

from floquetrod.plotting import palette

ROOT = Path(__file__).parents[2]
HOME = ROOT / "floquetrod/plotting/palette.py"
DRAWN = [
    path
    for folder, pattern in (
        *(("floquetrod", "**/*.py"), ("docs", "**/*.md")),
        *((folder, "*.py") for folder in ("studies", "examples", "docs")),
    )
    for path in sorted((ROOT / folder).glob(pattern))
    if path != HOME
]
PAGES = [*DRAWN, ROOT / "README.md"]

AREAS = r"(?:axvspan|axhspan|fill_between|broken_barh|pcolormesh|imshow|contourf|set_facecolor|barh?|patch\.set)\("
NAMED = r"""(?:color|facecolor|colors|cmap|markerfacecolor)["']?\s*[=:]\s*["'](?!none)(?!black["'])"""
FORBIDDEN = {
    "a colour by its number": r"#[0-9a-fA-F]{6}\b",
    "a map of colours": r"cmap\s*=\s*[\"']|colormaps?\[|get_cmap|(?:gray|viridis|Greys|cividis)(?:_r)?[\"']",
    "a named colour but black": r"[\"'](?:white|red|green|blue|orange|tab:\w+|C\d)[\"']",
    "a colour of an area": rf"{AREAS}[^\n]*{NAMED}",
}


def found(pages: list[Path], pattern: str) -> list[str]:
    """Return where a pattern stands in files, and what stands there."""
    texts = ((path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")) for path in pages)
    return [f"{name}: {match[0]}" for name, text in texts for match in re.finditer(pattern, text)]


@pytest.mark.slow
@pytest.mark.parametrize("what", FORBIDDEN)
def test_only_the_palette_names_colours(what: str) -> None:
    assert found(DRAWN, FORBIDDEN[what]) == []


@pytest.mark.slow
def test_nothing_unstable_is_called_grey() -> None:
    assert found(PAGES, r"unstable[^.\n]{0,20}\bgr[ea]y|\bgr[ea]y[^.\n]{0,20}unstable") == []


@pytest.mark.parametrize(
    "line",
    [
        'axes.axvspan(low, high, color="0.88", linewidth=0.0)',
        'axes.pcolormesh(x, y, z, cmap="gray_r")',
        'axes.plot(x, y, color="#e08a2e")',
        'axes.plot(x, y, "o", markerfacecolor="white")',
        'ax.broken_barh(a, b, facecolor="0.5", edgecolor="none")',
    ],
)
def test_the_search_finds_what_it_is_for(line: str) -> None:
    assert any(re.search(pattern, line) for pattern in FORBIDDEN.values())


def lightness(colour: object) -> float:
    """Return the luminance that a picture turned grey shows."""
    red, green, blue = to_rgb(colour)
    return 0.299 * red + 0.587 * green + 0.114 * blue


# What protanopes and deuteranopes see (Machado, Oliveira and Fernandes 2009, doi:10.1109/TVCG.2009.113, severity 1).
BLIND = {
    "protanopia": ((0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998)),
    "deuteranopia": ((0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.011820, 0.042940, 0.968881)),
}


@pytest.mark.parametrize("eyes", ["grey", *BLIND])
def test_colours_differ_for_everybody(eyes: str) -> None:
    def seen(colour: object) -> tuple[float, ...]:
        if eyes == "grey":
            return (lightness(colour),)
        return tuple(sum(w * c for w, c in zip(row, to_rgb(colour), strict=True)) for row in BLIND[eyes])

    verdicts = [palette.STABLE, palette.UNSEEN, palette.UNSTABLE, palette.FASTEST]
    for i, one in enumerate(verdicts):
        for other in verdicts[i + 1 :]:
            assert max(abs(a - b) for a, b in zip(seen(one), seen(other), strict=True)) > 0.12


def test_growth_is_darker_the_faster() -> None:
    shades = [lightness(colour[:3]) for colour in palette.shades()([i / 20.0 for i in range(21)])]
    assert shades == sorted(shades, reverse=True)
    assert shades[0] < lightness(palette.STABLE) - 0.12  # the slowest growth does not look stable
    assert to_rgb(palette.verdicts()(0.0)) == to_rgb(palette.STABLE)
    assert to_rgb(palette.verdicts()(1.0)) == to_rgb(palette.UNSTABLE)
