"""The study's figures without friction, recomputed: Figures 2, 3 and 8 of DOI 10.1115/1.4031710."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from floquetrod import mathieu
from floquetrod.equations import Mathieu
from floquetrod.floquet.methods.determinant import determinant
from floquetrod.floquet.methods.square_wave import square_wave
from floquetrod.floquet.status import STATUS_CODES
from floquetrod.floquet.verdict import Stability
from floquetrod.plane import Axis, Band, Bands, charted
from floquetrod.plane.family import Judged
from floquetrod.plotting import palette
from floquetrod.rod.loads.load import AxialLoad
from floquetrod.rod.mode_equations.modal_systems import ModalSystem
from floquetrod.rod.mode_equations.unstable_loads import unstable_loads
from floquetrod.rod.model.constants import mode_constants
from floquetrod.rod.stability_map import stability_map
from studies import drawing
from studies.claims import EXACT, LEAPFROG, ROD, UNIT, WINDOW, window
from studies.drawing import UnstableForces

LOADS = (0.288, 85.0), (0.20, 150.0), (0.34, 150.0)
"""Mean forces in F_cr and frequencies in rad/s of Figure 2(b)-(d), all at 0.2 F_cr: our choice.

The first is unstable in a tongue the 100-period test cannot see, the others are of claim F3-b.
"""

FREQUENCIES, FORCES = (20.0, 200.0), (0.0, 1.1)
"""What the maps of Figures 3 and 6 range over: rad/s and F_cr."""


SHOWN = 1e-4
"""Growth per unit tau from which Figure 3(a)-(d) shows a tongue: the many weaker ones would cover the page."""


def figure_2(chart: int) -> Any:
    """Draw the stability chart by leapfrog under the exact curves, and the first ten modes under three loads."""
    figure, axes = drawing.panels(2, 2, (8.0, 7.4))
    alpha, beta = window(chart)
    curves = mathieu.transition_curves(np.linspace(*WINDOW[0], 400), range(7))
    axes[0].set_title("leapfrog and exact curves", fontsize="medium")
    drawing.draw_plane(axes[0], alpha, beta.ravel(), ~LEAPFROG.is_stable(alpha, beta), curves)
    for ax, (force, frequency) in zip(axes[1:], LOADS, strict=True):
        load = AxialLoad(force * UNIT, 0.2 * UNIT, frequency)
        system = ModalSystem(mode_constants(ROD), load, tuple(range(1, 11)))
        mode_alpha, mode_beta = system.alpha, system.beta
        upto, lowest = 1.25 * mode_alpha[-1], mode_beta.min()
        bands = mathieu.chart((0.0, upto, 2), (1.1 * lowest, -0.3 * lowest, 2)).bands
        drawing.draw_exact_plane(ax, bands, mathieu.transition_curves(np.linspace(0.0, upto, 500), range(4)))
        drawing.draw_modes(ax, mode_alpha, mode_beta, ~mathieu.is_stable(mode_alpha, mode_beta))
        words = rf"$F_\mathrm{{ave}} = {force:g}\,F_\mathrm{{cr}}$, $\omega = {frequency:g}$ rad/s"
        ax.set_title(words, fontsize="medium")
    drawing.caption(
        figure,
        f"(a) Unstable points (orange) of a {chart} x {chart} chart by the 100-period leapfrog test, and the exact "
        "transition curves of orders 0 to 6. (b)-(d) The first ten modes of the reference rod under three loads of "
        "amplitude 0.2 F_cr on the exact chart (orange: unstable): filled where unstable, which is mode 8 in (b), in a "
        "tongue the test is blind to, and mode 7 in (c).",
        112,
    )
    return figure


def figure_3(points: tuple[int, int]) -> Any:
    """Draw maps over frequency and mean force at four amplitudes, and the unstable modes at two frequencies."""
    figure, axes = drawing.panels(3, 2, (8.0, 10.4))
    omega, force = np.linspace(*FREQUENCIES, points[0]), np.linspace(*FORCES, points[1])
    for ax, amplitude in zip(axes, (0.1, 0.2, 0.3, 0.5), strict=False):
        failing = ~ROD.is_stable(
            mean=force[:, None] * UNIT, amplitude=amplitude * UNIT, frequency=omega, criterion=EXACT
        )
        drawing.draw_map(ax, omega, force, failing, tongues(amplitude), palette.UNSEEN)
        ax.set_title(rf"$\Delta F = {amplitude}\,F_\mathrm{{cr}}$", fontsize="medium")
    for ax, frequency in zip(axes[4:], (85.0, 150.0), strict=True):
        drawing.draw_intervals(ax, unstable_intervals(0.2, frequency, 1.1), 1.1)
        ax.set_title(rf"$\Delta F = 0.2\,F_\mathrm{{cr}}$, $\omega = {frequency:g}$ rad/s", fontsize="medium")
    drawing.caption(
        figure,
        "(a)-(d) The reference rod: dark the points where the 100-period test fails, light the bands, between their "
        "exact boundaries, where the rod is unstable but grows "
        f"too slowly for it (between {SHOWN:g} and about {EXACT.threshold:.3f} per unit tau; weaker tongues are left "
        "out). (e), (f) The unstable modes against the mean force, exact and complete: dark where growth passes that "
        "threshold.",
        112,
    )
    return figure


def unstable_intervals(amplitude: float, frequency: float, upto: float) -> list[UnstableForces]:
    """Return every unstable interval of the mean force (all in F_cr), mode by mode, thin ones first."""
    last = ROD.modes_needed(AxialLoad(upto * UNIT, amplitude * UNIT, frequency))[0]
    system = ModalSystem(mode_constants(ROD), AxialLoad(0.0, amplitude * UNIT, frequency), tuple(range(1, last + 1)))
    return [
        UnstableForces(r.low / UNIT, r.high / UNIT, r.mode, tolerance > 0.0)
        for tolerance in (0.0, EXACT.threshold * frequency)
        for r in unstable_loads("mean", system, tolerance, (0.0, upto * UNIT)).intervals
    ]


def bands(amplitude: float, growth_tolerance: float) -> Bands:
    """Return the unstable bands over frequency (rad/s) and mean force (F_cr) of Figures 3 and 6."""
    ends = (*FREQUENCIES, 2), (FORCES[0] * UNIT, FORCES[1] * UNIT, 2)  # two points: bands are not made of them
    chart = stability_map(
        ROD, mean=ends[1], amplitude=amplitude * UNIT, frequency=ends[0], growth_tolerance=growth_tolerance
    )
    return chart.in_units(mean="Fcr").bands


def tongues(amplitude: float) -> list[Band]:
    """Return every unstable band that grows by more than `SHOWN` where it grows fastest."""
    return [band for band in bands(amplitude, 0.0) if band.largest_growth > SHOWN * band.place[0]]


def figure_8(points: int, chart: int) -> Any:
    """Draw the boundaries by Hill's determinants and by the square wave over the leapfrog chart."""
    figure, axes = drawing.panels(1, 2, (8.0, 4.4))
    alpha, beta = window(chart)
    unstable = ~LEAPFROG.is_stable(alpha, beta)
    for ax, name, method in (
        (axes[0], "Hill, 40 and 41 rows", functools.partial(determinant, terms=40)),
        (axes[1], "square wave", square_wave),
    ):
        drawing.draw_plane(ax, alpha, beta.ravel(), unstable)
        drawing.draw_outlines(ax, _traced(method, points))
        ax.set_title(name, fontsize="medium")
    drawing.caption(
        figure,
        "Unstable points (orange) by the 100-period leapfrog test, and the boundaries (black) traced by (a) Hill's "
        "determinants of 40 and 41 rows and (b) a square wave in place of the sine, from tongues met by a grid of "
        f"{points} x {points} points.",
        112,
    )
    return figure


def _traced(method: Callable[[Mathieu], Stability], points: int) -> Bands:
    """Return the bands of the chart that a method finds unstable, traced from its verdicts."""

    def status(alpha: float, beta: float) -> int:
        return STATUS_CODES[method(Mathieu(alpha, beta)).status]

    judge = np.vectorize(status, otypes=[np.int8])
    alpha, beta = (values.ravel() for values in window(points))
    family = Judged(lambda x, y: (judge(x, y), np.nan))
    return charted(family, Axis("alpha", r"\alpha", "", alpha), Axis("beta", r"\beta", "", beta)).bands
