"""The study's figures with friction, Figures 5 and 6 of DOI 10.1115/1.4031710, and one it lacks: the critical kick."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod import friction, mathieu
from floquetrod.plotting import palette
from floquetrod.rod.friction.mode_friction import kicks_of
from floquetrod.rod.loads.load import AxialLoad
from studies import drawing
from studies.claims import ROD, UNIT, WINDOW, window
from studies.figures import FORCES, FREQUENCIES, bands
from studies.friction_claims import AMPLITUDE, FRICTION, GAMMA, KICK, KICKS

SLOWEST = 0.01
"""Growth in 1/s up to which a mode is left out of the maps: no kick of interest destabilises it there."""

HARDEST = 200.0
"""Kick over friction beyond which Figure 6(e)-(f) does not look: more than a metre a second."""


def figure_5(points: int) -> Any:
    """Draw which points of the chart a kick escapes from, at four kicks."""
    figure, axes = drawing.panels(2, 2, (8.0, 7.4))
    alpha, beta = window(points)
    curves = mathieu.transition_curves(np.linspace(*WINDOW[0], 400), range(7))
    for ax, kick in zip(axes, KICKS, strict=True):
        escapes = friction.fates(alpha, beta, GAMMA, kick) == friction.ESCAPES
        drawing.draw_plane(ax, alpha, beta.ravel(), escapes, curves)
        ax.set_title(rf"$\epsilon = {kick:g}$", fontsize="medium")
    drawing.caption(
        figure,
        f"Points of a {points} x {points} chart from which a kick escapes for good against friction gamma = {GAMMA:g} "
        "(orange), under the transition curves without friction. Friction holds what grows too little to throw it off.",
        112,
    )
    return figure


def figure_6(points: int) -> Any:
    """Draw maps over frequency and mean force with more and less friction, and the kick each mode needs."""
    figure, axes = drawing.panels(3, 2, (8.0, 10.4))
    omega, force = np.linspace(*FREQUENCIES, points), np.linspace(*FORCES, points)
    loads: dict[str, Any] = {"mean": force[:, None] * UNIT, "amplitude": AMPLITUDE * UNIT, "frequency": omega}
    for ax, (mu, kick) in zip(axes, ((FRICTION, KICK), (None, None), (0.1, 0.035), (0.05, 0.05)), strict=False):
        if kick is None:
            drawing.draw_map(ax, omega, force, None, bands(AMPLITUDE, SLOWEST).bands, palette.UNSTABLE)
            ax.set_title("no friction", fontsize="medium")
            continue
        escapes = ~ROD.is_stable(**loads, growth_tolerance=SLOWEST, friction=mu, kick=kick)
        drawing.draw_map(ax, omega, force, escapes, [], palette.UNSTABLE)
        ax.set_title(rf"$\mu = {mu:g}$, {1e3 * kick:g} mm/s", fontsize="medium")
    for ax, frequency in zip(axes[4:], (85.0, 150.0), strict=True):
        shares = np.linspace(0.0, 1.1, 2 * points)
        drawing.draw_kicks(ax, shares, mode_kicks(shares, frequency), 1e3 * KICK)
        ax.set_title(rf"$\omega = {frequency:g}$ rad/s, $\mu = {FRICTION:g}$", fontsize="medium")
    drawing.caption(
        figure,
        f"The reference rod at an amplitude of {AMPLITUDE:g} F_cr. (a)-(d) Loads under which a kick buckles it "
        f"(orange), decided for all time; modes that grow by less than {SLOWEST:g} 1/s are left out. (e), (f) The kick "
        "that each mode needs, numbered where it needs least; the dashed line is 50 mm/s.",
        112,
    )
    return figure


def mode_kicks(shares: NDArray[np.float64], frequency: float) -> dict[int, NDArray[np.float64]]:
    """Return the critical kick in mm/s of every mode over the mean force (F_cr), infinite where none in reach does."""
    top = AxialLoad(float(shares[-1]) * UNIT, AMPLITUDE * UNIT, frequency)
    systems = ROD.modal_system(mean=shares * UNIT, amplitude=top.amplitude, frequency=frequency)
    kicks = {}
    for mode in range(1, ROD.modes_needed(top)[0] + 1):
        alpha, beta = systems.coefficients(mode)
        ratio = friction.critical_kick(alpha, beta, largest=HARDEST).smallest_found
        kicks[mode] = 1e3 * kicks_of(ROD, FRICTION, top.amplitude, frequency, ratio)
    return {mode: values for mode, values in kicks.items() if np.isfinite(values).any()}


def figure_kick(points: int) -> Any:
    """Draw the map of the smallest kick that buckles the rod."""
    figure, axes = drawing.panels(1, 1, (7.0, 5.4))
    omega, force = np.linspace(*FREQUENCIES, points), np.linspace(*FORCES, points)
    kick = ROD.critical_kick(
        mean=force[:, None] * UNIT,
        amplitude=AMPLITUDE * UNIT,
        frequency=omega,
        friction=FRICTION,
        growth_tolerance=SLOWEST,
    ).kick
    drawing.draw_kick_map(axes[0], omega, force, 1e3 * kick)
    drawing.caption(
        figure,
        f"The smallest transverse kick that buckles the reference rod for good, at an amplitude of {AMPLITUDE:g} F_cr "
        f"and mu = {FRICTION:g}; hatched: no mode grows by more than {SLOWEST:g} 1/s (at isolated points: "
        "undecided). The paper has no such figure.",
        100,
    )
    return figure
