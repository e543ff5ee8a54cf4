"""What the study claims about the rod with friction, as far as the mode equation goes, each claim computed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from floquetrod import friction, mathieu
from floquetrod.rod.friction.mode_friction import mode_friction
from floquetrod.rod.loads.load import AxialLoad
from studies.claims import ROD, UNIT, Claim, window

GAMMA = 0.01
KICKS = 0.005, 0.01, 0.05, 0.5
"""Friction and kicks of Figure 5; the second and third kick are our choice."""

FRICTION, KICK = 0.1, 0.05
AMPLITUDE = 0.7
"""Friction, kick (m/s) and amplitude (F_cr) of Figures 6 and 7."""

FORCES = 0.118, 0.424, 0.825
"""Mean forces in F_cr of the runs with friction."""


def f5(points: int) -> Claim:
    """Small kicks enlarge the stable set; from 0.05 on friction hardly matters."""
    alpha, beta = window(points)
    free = mathieu.is_stable(alpha, beta)
    gained, lost = [], 0
    for kick in KICKS:
        bounded = friction.fates(alpha, beta, GAMMA, kick) == friction.BOUNDED
        gained.append(float((bounded & ~free).sum() / (~free).sum()))
        lost += int((free & ~bounded).sum())
    words = ", ".join(f"{100.0 * share:.1f} % at eps = {kick:g}" for kick, share in zip(KICKS, gained, strict=True))
    return Claim(
        "F5",
        "gamma = 0.01: small kicks enlarge the stable set, from eps = 0.05 on the rod is nearly as without friction",
        f"of the points unstable without friction a kick leaves bounded {words}; none that are stable without "
        f"friction escape ({lost})",
        gained[0] > 0.2 > 0.1 > gained[2],
        "",
        bool(np.all(np.diff(gained) < 0.0)) and lost == 0 and gained[2] < 0.1 < gained[0],
    )


def f6_7() -> Claim:
    """Find the modes that a kick of 50 mm/s destabilises under six loads."""
    found: dict[tuple[float, float], dict[int, float]] = {}
    for omega in (85.0, 150.0):
        for force in FORCES:
            load = AxialLoad(force * UNIT, AMPLITUDE * UNIT, omega)
            speeds = ROD.stability(load, friction=FRICTION, kick=KICK).critical_kicks
            found[omega, force] = {m: 1e3 * v for m, v in speeds.items() if v < KICK}
    mode_8 = 1e3 * speeds[8]  # of the last load
    said = {(85.0, 0.118), (85.0, 0.424), (150.0, 0.118)}
    agrees = all((not modes) == (key in said) for key, modes in found.items())
    words = "; ".join(
        f"{force:.3f} F_cr at {omega:g} rad/s: "
        + (", ".join(f"mode {m} ({v:.1f} mm/s)" for m, v in sorted(modes.items())) or "stable")
        for (omega, force), modes in found.items()
    )
    last = found[150.0, 0.825]
    return Claim(
        "F6/7",
        "dF = 0.7 F_cr, mu = 0.1, 50 mm/s: stable at 0.118 F_cr; at 0.424 stable at 85 rad/s and unstable at 150; at "
        "0.825 unstable at both, in modes 8 and 9 at 150",
        f"modes destabilised by less than 50 mm/s, with the kick each needs: {words}",
        agrees,
        f"Under the last load mode 10 escapes as well, and mode 8 just does not: it needs {mode_8:.2f} mm/s. From 49.8 "
        "mm/s on it comes to rest ever farther out and moves back for more than 100 periods before it rests for good.",
        agrees
        and set(last) == {9, 10}
        and all(abs(last[m] - v) < 0.1 for m, v in ((9, 32.1), (10, 48.8)))
        and abs(mode_8 - 51.06) < 0.01
        and 8 in found[150.0, 0.424],
    )


def f6_b() -> Claim:
    """Frequency acts through gamma and epsilon, not through the axial sliding."""
    speeds, shares = [], []
    for omega in (85.0, 150.0):
        inside = mode_friction(ROD, FRICTION, KICK, AMPLITUDE * UNIT, omega)
        speeds.append(1e3 * float(inside.v_a))
        shares.append(1.0 - float(inside.mu_theta) / FRICTION)
    return Claim(
        "F6-b",
        "With friction the frequency acts through the axial sliding speed v_a",
        f"v_a is {speeds[0]:.2f} mm/s at 85 rad/s and {speeds[1]:.2f} mm/s at 150 rad/s against a kick of 50 mm/s: it "
        f"lowers mu_theta by {max(shares):.1e} of mu",
        False,
        "For this rod v_a is negligible. The frequency acts through gamma, which goes like 1 / omega^2, and the kick "
        "eps, which goes like 1 / omega.",
        max(speeds) < 0.8 and max(shares) < 2e-4,
    )


def friction_claims(points: int) -> dict[str, Callable[[], Claim]]:
    """Return the claims as functions to call; charts take ``points`` squared points."""
    return {"F5": lambda: f5(points), "F6/7": f6_7, "F6-b": f6_b}
