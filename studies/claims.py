"""What the study claims about the rod without friction, each claim computed.

The study is DOI 10.1115/1.4031710; ids name its figures.  A claim *holds* while the computation gives what this file
says it gives, agreement and difference alike: a change of the package that alters a finding is noticed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floquetrod import mathieu
from floquetrod.equations import Mathieu
from floquetrod.floquet.methods.determinant import determinant
from floquetrod.floquet.methods.monodromy import monodromy_matrix
from floquetrod.floquet.methods.square_wave import square_wave
from floquetrod.floquet.proof import certify
from floquetrod.floquet.verdict import Stability
from floquetrod.mathieu.paper_criterion import FiniteTimeCriterion
from floquetrod.rod.loads.load import AxialLoad
from floquetrod.rod.mode_equations.modal_systems import ModalSystem
from floquetrod.rod.mode_equations.unstable_loads import unstable_loads
from floquetrod.rod.model.constants import mode_constants
from floquetrod.rod.rod import Rod

ROD = Rod.nitinol()
UNIT = ROD.critical_force
EXACT = FiniteTimeCriterion()
LEAPFROG = FiniteTimeCriterion(by="leapfrog")
WINDOW = (0.0, 5.0), (-4.0, 1.0)
"""alpha and beta of Figures 2 and 8."""


@dataclass(frozen=True)
class Claim:
    """One claim: what the study says, what was computed, whether they agree and, if not, why."""

    id: str
    says: str
    computed: str
    agrees: bool
    why: str
    holds: bool


def window(points: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return alpha as a row and beta as a column over the window of Figures 2 and 8."""
    return np.linspace(*WINDOW[0], points), np.linspace(*WINDOW[1], points)[:, None]


def f2_a() -> Claim:
    """Without forcing a mode is unstable exactly where beta > 0."""
    beta = np.linspace(-4.0, 1.0, 5001)
    beta = beta[np.abs(beta) > 1e-12]
    wrong = int((mathieu.is_stable(0.0, beta) != (beta < 0.0)).sum())
    return Claim(
        "F2-a",
        "Without vibration a mode is unstable when beta > 0",
        f"{wrong} of {beta.size} values of beta in [-4, 1] differ",
        wrong == 0,
        "",
        wrong == 0,
    )


def f2_b() -> Claim:
    """At beta = -0.25 the slightest forcing destabilises."""
    equation = Mathieu(1e-8, -0.25)
    proof, growth = certify(equation), float(mathieu.growth_rate(1e-8, -0.25))
    noise = float(np.trace(monodromy_matrix(equation))) + 2.0
    passes = bool(LEAPFROG.is_stable(1e-8, -0.25))
    return Claim(
        "F2-b",
        "At beta = -0.25 even alpha = 1e-8 destabilises",
        f"proved {proof.status} by interval arithmetic; growth {growth:.3g} per unit tau",
        proof.status == "unstable",
        f"True, but not to be seen in 100 periods (the test says {'stable' if passes else 'unstable'}) nor in double "
        f"precision: trace + 2 is {noise:.1e}, rounding.",
        proof.status == "unstable" and abs(growth - 5e-9) < 1e-12 and passes and abs(noise) < 1e-13,
    )


def f2_c() -> Claim:
    """At beta = -0.80 the mode is stable up to alpha = 1.5."""
    from scipy.optimize import bisect

    below = bool(mathieu.is_stable(np.linspace(0.0, 1.5, 15001), -0.8).all())
    inside, outside = mathieu.is_stable([1.5, 1.7], -0.8)
    crossing = bool(inside > outside)
    end = float(bisect(lambda a: 0.5 - mathieu.is_stable(a, -0.8), 1.5, 1.7, xtol=1e-13)) if crossing else np.nan
    return Claim(
        "F2-c",
        "At beta = -0.80 a mode is stable up to alpha = 1.5",
        f"stable at all of 15001 values up to 1.5; the boundary is at alpha = {end:.10f}",
        below,
        "",
        below and 1.58 < end < 1.6,
    )


def f2_d() -> Claim:
    """Vibration stabilises some beta > 0."""
    top = -0.25 * float(mathieu.characteristic_values(0, 2.0, "a"))
    alpha, beta = window(401)
    share = float(mathieu.is_stable(alpha, beta[beta > 0.0][:, None]).mean())
    return Claim(
        "F2-d",
        "Vibration can stabilise a mode that the mean force alone would buckle, beta > 0",
        f"{100.0 * share:.1f} % of the window with beta > 0 is stable; at alpha = 1, up to beta = {top:.6f}",
        share > 0.0,
        "",
        0.01 < share < 0.016 and abs(top - 0.378489) < 1e-6,
    )


def first_failure(amplitude: float, frequency: float, criterion: FiniteTimeCriterion, upto: float) -> float:
    """Return the first mean force in F_cr, of a fine grid to ``upto``, at which the test fails; inf if none."""
    mean = np.linspace(0.0, upto, round(upto / 5e-4) + 1)
    failing = np.flatnonzero(
        ~ROD.is_stable(mean=mean * UNIT, amplitude=amplitude * UNIT, frequency=frequency, criterion=criterion)
    )
    return float(mean[failing[0]]) if failing.size else float("inf")


def f3_a() -> Claim:
    """At 85 rad/s and 0.2 F_cr the rod is stable below 0.45 F_cr."""
    by_test = first_failure(0.2, 85.0, LEAPFROG, 0.6)
    load = AxialLoad(0.0, 0.2 * UNIT, 85.0)
    last = ROD.modes_needed(AxialLoad(0.6 * UNIT, 0.2 * UNIT, 85.0))[0]
    system = ModalSystem(mode_constants(ROD), load, tuple(range(1, last + 1)))
    bands = unstable_loads("mean", system, 0.0, (0.0, 0.6 * UNIT)).intervals
    main = min(band for band in bands if band.low <= by_test * UNIT < band.high)  # in which the test fails further on
    below = sum(band.high < main.low for band in bands)
    thin = np.linspace(0.0, 0.99 * main.low, 4501)
    growth, mode = ROD.growth_rate(mean=thin, amplitude=0.2 * UNIT, frequency=85.0, return_mode=True)
    at = int(growth.argmax())
    place, rate, fastest = float(thin[at]) / UNIT, growth[at] / 85.0, int(mode[at])
    return Claim(
        "F3-a",
        "dF = 0.2 F_cr at 85 rad/s: stable below F_ave = 0.45 F_cr",
        f"the test first fails at {by_test:.4f} F_cr, in a tongue of mode {main.mode} that begins at "
        f"{main.low / UNIT:.4f}; exactly, {below} thinner bands lie below, the strongest in mode {fastest} "
        f"around {place:.3f} F_cr with growth {rate:.4f} per unit tau",
        False,
        f"The 100-period test cannot see growth below about {EXACT.threshold:.3f} per unit tau.",
        abs(by_test - 0.459) < 2e-3 and fastest == 8 and abs(rate - 0.007) < 5e-4 and 0.27 < place < 0.3,
    )


def f3_b() -> Claim:
    """At 150 rad/s stable and unstable forces alternate."""
    forces = np.array([0.05, 0.34, 0.63, 0.20, 0.52])
    exact = ROD.is_stable(mean=forces * UNIT, amplitude=0.2 * UNIT, frequency=150.0)
    test = ROD.is_stable(mean=forces * UNIT, amplitude=0.2 * UNIT, frequency=150.0, criterion=LEAPFROG)
    expected = np.array([True, True, True, False, False])
    agrees = bool((exact == expected).all() and (test == expected).all())
    words = ", ".join(f"{f:.2f} {'stable' if s else 'unstable'}" for f, s in zip(forces, exact, strict=True))
    return Claim(
        "F3-b",
        "dF = 0.2 F_cr at 150 rad/s: stable at 0.05, 0.34, 0.63 F_cr, unstable at 0.20, 0.52",
        f"exactly and by the test: {words}",
        agrees,
        "",
        agrees,
    )


def f3_c() -> Claim:
    """Near 120 rad/s the rod is unstable at once, near 20 rad/s only from 0.8 F_cr on."""
    omega = np.linspace(110.0, 140.0, 301)
    growth, _ = ROD.growth_rate(mean=0.0, amplitude=0.2 * UNIT, frequency=omega, return_mode=True)
    visible = omega[growth > EXACT.threshold * omega]
    failing = omega[~ROD.is_stable(mean=0.0, amplitude=0.2 * UNIT, frequency=omega, criterion=LEAPFROG)]
    slow = first_failure(0.2, 20.0, LEAPFROG, 1.0)
    firsts = {
        rate: ROD.critical("mean", amplitude=0.2 * UNIT, frequency=20.0, growth_tolerance=rate * 20.0) / UNIT
        for rate in (0.022, 1e-3, 2e-4)
    }
    thin = ", ".join(f"{force:.3f} F_cr by more than {rate:g}" for rate, force in firsts.items())
    return Claim(
        "F3-c",
        "dF = 0.2 F_cr: unstable from F_ave = 0 on near 120 rad/s; stable to 0.8 F_cr near 20 rad/s",
        f"at F_ave = 0 growth exceeds the test's threshold from {visible[0]:.1f} to {visible[visible < 125][-1]:.1f} "
        f"and from {visible[visible > 125][0]:.1f} rad/s on; the test itself fails from {failing[0]:.1f} to "
        f"{failing[-1]:.1f} rad/s.  At 20 rad/s it first fails at {slow:.3f} F_cr; exactly, modes grow from {thin} per "
        "unit tau",
        True,
        "Near 120 rad/s the growing mode passes through zero at the end of the 100th period, so that the test lets it "
        "pass.  Near 20 rad/s tongues thinner than the test can see begin lower.",
        118.0 < visible[0] < 119.5
        and 120.5 < visible[visible < 125][-1] < 122.0
        and 134.5 < failing[0] < 136.5
        and abs(slow - 0.76) < 2e-3
        and abs(firsts[1e-3] - 0.594) < 2e-3
        and abs(firsts[2e-4] - 0.470) < 2e-3,
    )


def f3_d(points: int) -> Claim:
    """Larger amplitudes shrink the stable region; the unstable modes lie near the critical one."""
    mean, omega = np.linspace(0.0, 1.1, points)[:, None] * UNIT, np.linspace(20.0, 200.0, points)
    shares, modes = [], []
    for amplitude in (0.1, 0.2, 0.3, 0.4, 0.5):
        passing = ROD.is_stable(mean=mean, amplitude=amplitude * UNIT, frequency=omega, criterion=EXACT)
        shares.append(float(passing.mean()))
        modes.append(
            ROD.growth_rate(mean=mean, amplitude=amplitude * UNIT, frequency=omega, return_mode=True)[1][~passing]
        )
    found = np.concatenate(modes)
    near = float((np.abs(found - ROD.critical_mode) < 2.5).mean())
    common = int(np.bincount(found).argmax())
    falling = bool((np.diff(shares) < 0.0).all())
    return Claim(
        "F3-d",
        "The stable region shrinks from dF = 0.1 to 0.5 F_cr; the unstable modes lie near m = 6",
        f"{', '.join(f'{100.0 * s:.0f}' for s in shares)} % of loads pass the test at dF = 0.1 ... 0.5 F_cr; the "
        f"mode that grows fastest is most often {common}, and within 2.5 of m_cr = {ROD.critical_mode:.2f} in "
        f"{100.0 * near:.0f} % of the others",
        falling and common in (6, 7),
        "",
        falling and common in (6, 7) and near > 0.7,
    )


def f3_map(points: int) -> Claim:
    """Classify ``points`` squared loads by leapfrog and exactly."""
    mean, omega = np.linspace(0.0, 1.1, points)[:, None] * UNIT, np.linspace(20.0, 200.0, points)
    growth = ROD.growth_rate(mean=mean, amplitude=0.2 * UNIT, frequency=omega) / omega
    leapfrog, exact = (
        ROD.is_stable(mean=mean, amplitude=0.2 * UNIT, frequency=omega, criterion=by) for by in (LEAPFROG, EXACT)
    )
    stable = ROD.is_stable(mean=mean, amplitude=0.2 * UNIT, frequency=omega)
    sides = leapfrog != (growth <= EXACT.threshold)
    away = float(np.abs(growth[sides] - EXACT.threshold).max(initial=0.0))
    missed = leapfrog & ~stable
    return Claim(
        "F3-map",
        "(Our check) The 100-period leapfrog test shows which loads are stable",
        f"of {stable.size:,} loads at dF = 0.2 F_cr it passes {int(missed.sum())} that are unstable, with growth up to "
        f"{growth[missed].max():.4f} per unit tau, and fails none that are stable.  Against growth above "
        f"{EXACT.threshold:.4f} it differs at {int(sides.sum())}, all within {away:.4f} of it; against the same test "
        f"carried out exactly at {int((leapfrog != exact).sum())}",
        False,
        "The test finds every instability that grows a millionfold in 100 periods. Thinner tongues pass.",
        not (stable & ~leapfrog).any() and away < 0.015 and int((leapfrog != exact).sum()) <= 2,
    )


def f8_a(points: int) -> Claim:
    """Hill's determinants of 40 and 41 rows agree with leapfrog."""
    alpha, beta = window(points)
    exact, growth = mathieu.is_stable(alpha, beta), mathieu.growth_rate(alpha, beta)
    hill, undecided = each(alpha, beta, lambda equation: determinant(equation, terms=40))
    test = LEAPFROG.is_stable(alpha, beta)
    differ = (hill != test) & ~undecided
    largest = float(growth[differ].max(initial=0.0))
    wrong, reach = int(((hill != exact) & ~undecided).sum()), forty_terms_reach(12)
    return Claim(
        "F8-a",
        "Hill's determinants of 40 and 41 rows and leapfrog give the same chart",
        f"{int(differ.sum())} of {test.size} points differ, each with growth below {largest:.4f} per unit tau; 40 "
        f"terms differ from the exact count at {wrong} and leave {int(undecided.sum())} undecided, where two curves "
        f"meet.  They are too few, or say so, from where beta reaches {-reach[0]:.0f} (small alpha) or, in the worst "
        f"direction, where 4 (alpha - beta) = {reach[1]:.0f}",
        True,
        f"Leapfrog over 100 periods is blind below about {EXACT.threshold:.3f} per unit tau; the determinants are not. "
        "40 terms carry waves up to index 79, so that they end where -4 beta nears 79^2 = 6241; with strong "
        "forcing the rows left out matter earlier, and the verdict is undecided.",
        wrong == 0
        and largest < 0.0247
        and not (exact & ~test).any()
        and 1300.0 < reach[0] < 1600.0
        and 1400.0 < reach[1] < 6241.0,
    )


def f8_b(points: int) -> Claim:
    """Replace the sine by a square wave: reasonable."""
    alpha, beta = window(points)
    exact = mathieu.is_stable(alpha, beta)
    shares = []
    for factor in (1.0, np.pi / 4.0):
        square, _ = each(factor * alpha, beta, square_wave)
        shares.append(float((square != exact).mean()))
    gentle = alpha <= 1.0
    square, _ = each(alpha[gentle], beta, square_wave)
    mild = float((square != exact[:, gentle]).mean())
    return Claim(
        "F8-b",
        "A square wave in place of the sine gives a reasonable chart",
        f"{100.0 * shares[0]:.1f} % of the chart is classified otherwise, {100.0 * mild:.1f} % for alpha up to 1; "
        f"{100.0 * shares[1]:.1f} % once its amplitude is multiplied by pi/4",
        True,
        "A square wave of amplitude alpha has a first harmonic of 4/pi alpha, so that its tongues are wider. Matching "
        "the first harmonic removes nearly half of the difference; the higher harmonics remain.",
        0.05 < shares[0] < 0.2 and shares[1] < shares[0] and mild < shares[0],
    )


def each(
    alpha: NDArray[np.float64], beta: NDArray[np.float64], method: Callable[[Mathieu], Stability]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return where a scalar method says stable, and where it is undecided, over alpha (row) and beta (column)."""
    status = np.array([[method(Mathieu(float(x), float(y))).status for x in alpha] for y in beta.ravel()])
    return status == "stable", status == "undecided"


def forty_terms_reach(rays: int) -> tuple[float, float]:
    """Return how far 40 terms suffice: the least -beta without forcing to speak of, and the least 4 (alpha - beta).

    Along rays from the origin into alpha > 0, beta < alpha / 2: the first of geometric steps at which the verdict is
    wrong or open.
    """
    ends = []
    for angle in np.linspace(1e-4, 0.5 * np.pi + 0.4, rays):
        for size in 200.0 * 1.02 ** np.arange(200.0):
            alpha, beta = size * np.sin(angle), -size * np.cos(angle)
            result = determinant(Mathieu(alpha, beta), terms=40)
            if result.stable is not bool(mathieu.is_stable(float(alpha), float(beta))):
                break
        ends.append((float(-beta), float(4.0 * (alpha - beta))))
    return ends[0][0], min(end[1] for end in ends)


def frictionless_claims(points: int) -> dict[str, Callable[[], Claim]]:
    """Return the claims as functions to call, in the order of the figures; maps take ``points`` squared loads."""
    return {
        "F2-a": f2_a,
        "F2-b": f2_b,
        "F2-c": f2_c,
        "F2-d": f2_d,
        "F3-a": f3_a,
        "F3-b": f3_b,
        "F3-c": f3_c,
        "F3-d": lambda: f3_d(points),
        "F3-map": lambda: f3_map(points),
        "F8-a": lambda: f8_a(100),
        "F8-b": lambda: f8_b(100),
    }
