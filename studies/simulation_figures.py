"""The study's simulated rods from above: Figures 4 and 7 of DOI 10.1115/1.4031710."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from studies import drawing
from studies.simulation_claims import SimulationStudy
from studies.simulations import FIGURE_4, FIGURE_7, ROD, SPEED, TrialOutcome


def figure_4(study: SimulationStudy) -> Any:
    """Draw the ten rods without friction, a column for each frequency."""
    columns = [f"{frequency:g} rad/s" for frequency in FIGURE_4]
    rows = len(next(iter(FIGURE_4.values())))
    figure, axes = drawing.strips(["$y$ / mm"] * rows, columns, (8.0, 7.0), ROD.radial_clearance)
    for column, frequency in enumerate(FIGURE_4):
        group = [outcome for outcome in study.figure_4 if outcome.trial.frequency == frequency]
        for row, outcome in enumerate(group):
            title = f"$F_\\mathrm{{ave}} = {outcome.trial.mean:g}\\,F_\\mathrm{{cr}}$: {_words(outcome, 'predicted')}"
            drawing.draw_strip(outcome.run, axes[row, column], title)
    trial, problem = study.figure_4[0].trial, study.figure_4[0].trial.problem
    drawing.caption(
        figure,
        f"Simulated rods without friction from above, {_segments(study.figure_4)}, amplitude {trial.amplitude:g} "
        f"F_cr, started with random speeds ({trial.case}): four times of the last quarter of {problem.duration:g} s, "
        "black where farthest out. The scale across is stretched; the forces at 85 rad/s, which the paper does not "
        "state, are ours.",
        112,
    )
    return figure


def figure_7(study: SimulationStudy) -> Any:
    """Draw the thirty rods with friction, a row for each load, a column for each perturbation."""
    columns = ["A", "B", "C, first mode", "C, mode 10", "D"]
    rows = [f"{frequency:g} rad/s\n{mean:g} $F_\\mathrm{{cr}}$" for frequency, mean in FIGURE_7]
    figure, axes = drawing.strips(rows, columns, (8.0, 7.6), ROD.radial_clearance)
    for place, outcome in enumerate(study.figure_7):
        drawing.draw_strip(outcome.run, axes.flat[place], _words(outcome, "paper"))
    trial, problem = study.figure_7[0].trial, study.figure_7[0].trial.problem
    drawing.caption(
        figure,
        f"Simulated rods with friction {problem.friction:g} from above, {_segments(study.figure_7)}, amplitude "
        f"{trial.amplitude:g} F_cr, kicks of {1e3 * SPEED:g} mm/s (columns), y in mm: four times of the last quarter "
        f"of {problem.duration:g} s, black where farthest out. The first mode of C is that of A: 6 at 85, 8 at 150 "
        "rad/s. Where the paper found something else, the title says what.",
        112,
    )
    return figure


def _words(outcome: TrialOutcome, source: str) -> str:
    """Return what was found and, where that is not what was expected, what was."""
    found = f"mode {outcome.mode}" if outcome.buckled else "stays"
    modes = outcome.trial.expected_modes
    expected = f"mode {' or '.join(map(str, modes))}" if modes else "stays"
    return found if outcome.agrees else f"{found} ({source}: {expected})"


def _segments(outcomes: Sequence[TrialOutcome]) -> str:
    """Return how many segments the rods have."""
    counts = [outcome.trial.problem.segments for outcome in outcomes]
    return f"{min(counts)} to {max(counts)} segments"
