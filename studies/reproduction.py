"""Recompute the study: every figure, every claim, and the report."""

from __future__ import annotations

import functools
import io
import itertools
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from floquetrod._util.sealed_files import atomic_file, writable
from studies import figures, friction_figures, one_figure, simulation_claims, simulation_figures
from studies.claims import Claim, frictionless_claims
from studies.friction_claims import friction_claims
from studies.report import FILES, Picture, write_report

_DPI = 200


class Detail(NamedTuple):
    """Resolution of a reproduction: numbers of points along each side.

    Attributes
    ----------
    maps : int
        Of the maps and charts that claims rest on.
    chart : int
        Of the charts of Figures 2, 5 and 8.
    rod : tuple of int
        Of the maps of Figure 3, over frequency and mean force.
    hill : int
        Of the boundaries of Figure 8.
    friction, kicks : int
        Of the maps of Figure 6 and of the critical kick.
    few_runs : bool
        Whether to simulate half the random draws.
    """

    maps: int = 100
    chart: int = 100
    rod: tuple[int, int] = (480, 400)
    hill: int = 240
    friction: int = 200
    kicks: int = 100
    few_runs: bool = False


FULL = Detail()
QUICK = Detail(maps=50, rod=(120, 100), hill=60, friction=32, kicks=20, few_runs=True)


@dataclass(frozen=True)
class Reproduction:
    """What was found and what was written."""

    claims: tuple[Claim, ...]
    written: tuple[Path, ...]

    @property
    def lost(self) -> tuple[Claim, ...]:
        """Claims that no longer come out as this package says they do."""
        return tuple(claim for claim in self.claims if not claim.holds)


def reproduce(
    folder: Path,
    *,
    detail: Detail = FULL,
    simulations: bool = False,
    progress: Callable[[str, int, int], None] | None = None,
) -> Reproduction:
    """Compute claims and figures, and write them to a folder, which is made if it is not there.

    Parameters
    ----------
    folder : Path
        Where the figures (PNG), claims.md, claims.json and report.html go.
    detail : Detail
        How finely: `FULL`, `QUICK` or your own.
    simulations : bool
        Also simulate whole rods, for Figures 4 and 7 and the claims on them: some two minutes of processor time, in
        as many threads as there are processors.
    progress : callable, optional
        Called before each step with its name, its number and how many there are, and at the end.
    """
    folder.mkdir(parents=True, exist_ok=True)
    done = 0

    def say(what: str) -> None:
        nonlocal done
        if progress is not None:
            progress(what, done, total)
        done += 1

    study = functools.cache(lambda: simulation_claims.make_study(detail.few_runs, say))
    drawings = _drawings(detail)
    tests = frictionless_claims(detail.maps) | friction_claims(detail.maps)
    total = len(drawings) + len(tests)
    if simulations:
        drawings = sorted([*drawings, *_simulated(study)])  # by title
        tests |= simulation_claims.simulation_claims(study)
        total = len(drawings) + len(tests) + simulation_claims.runs(detail.few_runs)
    for name in [*FILES, *(name for _, name, _ in drawings)]:
        writable(folder / name)
    if simulations:
        study()
    pictures: dict[str, Picture] = {}
    for title, name, draw in drawings:
        say(title)
        pictures[title] = _save(draw(), folder / name)
    claims = []
    for name, compute in tests.items():
        say(f"Claim {name}")
        claims.append(compute())
    say("Report")
    reports = write_report(folder, claims, pictures)
    return Reproduction(tuple(claims), (*(picture.path for picture in pictures.values()), *reports))


def draw_one(
    folder: Path, name: str, *, detail: Detail = FULL, progress: Callable[[str, int, int], None] | None = None
) -> tuple[Path, ...]:
    """Draw a figure, or one panel of it, into a folder, and return the files: PNG, PDF and the data as CSV.

    Parameters
    ----------
    folder : Path
        Where the files go; it is made if it is not there.
    name : str
        A figure such as "3" or "kick", or a panel such as "3b".  Figures 4 and 7 are simulated first.
    detail, progress
        As `reproduce` takes them.
    """
    say = progress or (lambda what, done, total: None)
    runs = itertools.count()
    total = simulation_claims.runs(detail.few_runs)
    study = functools.cache(
        lambda: simulation_claims.make_study(detail.few_runs, lambda what: say(what, next(runs), total))
    )
    drawings = {
        file.removeprefix("figure_").removesuffix(".png"): (title, draw)
        for title, file, draw in sorted([*_drawings(detail), *_simulated(study)], key=lambda drawing: drawing[1])
    }
    figure_name, letter = (name, "") if name in drawings else (name[:-1], name[-1:])
    if figure_name not in drawings:
        raise ValueError(f"--only must name a figure, {', '.join(drawings)}, or a panel such as 3b, got {name!r}")
    paths = tuple(folder / f"figure_{name}.{kind}" for kind in ("png", "pdf", "csv"))
    folder.mkdir(parents=True, exist_ok=True)
    for path in paths:
        writable(path)
    title, draw = drawings[figure_name]
    say(title, 0, 1)
    figure = draw()
    if letter:
        letters = [each for each in one_figure.panels_of(figure) if each.isalpha()]
        if letter not in letters:
            there = f"it has {', '.join(letters)}" if letters else "it has no letters"
            raise ValueError(f"--only must name a panel of figure {figure_name}, got {name!r}; {there}")
        one_figure.keep_panel(figure, letter)
    for path in paths[:2]:
        _save(figure, path)
    with atomic_file(paths[2]) as file:
        text = io.StringIO()
        one_figure.write_data(figure, text)
        file.write(text.getvalue().encode())
    say("Done", 1, 1)
    return paths


def _drawings(detail: Detail) -> list[tuple[str, str, Callable[[], Any]]]:
    """Return title, file and function of each figure."""
    chart = detail.chart
    return [
        ("Figure 2: the stability chart and the modes", "figure_2.png", lambda: figures.figure_2(chart)),
        ("Figure 3: stability of the rod", "figure_3.png", lambda: figures.figure_3(detail.rod)),
        ("Figure 5: friction in the mode equation", "figure_5.png", lambda: friction_figures.figure_5(chart)),
        ("Figure 6: friction on the rod", "figure_6.png", lambda: friction_figures.figure_6(detail.friction)),
        ("The critical kick", "figure_kick.png", lambda: friction_figures.figure_kick(detail.kicks)),
        (
            "Figure 8: Hill's determinants and the square wave",
            "figure_8.png",
            lambda: figures.figure_8(detail.hill, chart),
        ),
    ]


def _simulated(study: Callable[[], simulation_claims.SimulationStudy]) -> list[tuple[str, str, Callable[[], Any]]]:
    """Return the same of the figures of simulated rods."""
    return [
        ("Figure 4: simulated rods", "figure_4.png", lambda: simulation_figures.figure_4(study())),
        ("Figure 7: simulated rods with friction", "figure_7.png", lambda: simulation_figures.figure_7(study())),
    ]


def _save(figure: Any, path: Path) -> Picture:
    with atomic_file(path) as file:
        figure.savefig(file, dpi=_DPI, format=path.suffix[1:])
    return Picture(figure, path)
