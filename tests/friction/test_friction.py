"""Friction: closed forms, an independent integrator, the paper's leapfrog, symmetries, and no run without end."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp, trapezoid
from scipy.optimize import brentq

import floquetrod as fr
from floquetrod.friction import BOUNDED, ESCAPES, UNDECIDED
from tests.conftest import depth
from tests.strategies import decades, numbers

FRACTAL = fr.FrictionalMathieu(alpha=1.3817153980732138, beta=0.6107295815800908, gamma=1.0)
few = settings(max_examples=depth(25, 5))


def rest_and_motion(equation: fr.FrictionalMathieu, kick: float, end: float) -> tuple[float, float]:
    """Return A and A' at ``end`` by DOP853 with events; sticks and releases by root finding on the force."""
    a, b, g, c = equation.alpha, equation.beta, equation.gamma, equation.damping
    tau, x, v = 0.0, 0.0, kick
    while tau < end:
        if v == 0.0:
            force = (b + a * math.sin(tau)) * x
            side = math.copysign(1.0, force)
            if abs(force) <= g:
                times = np.linspace(tau, tau + 2.0 * math.pi, 4001)
                excess = np.abs((b + a * np.sin(times)) * x) - g
                freed = np.flatnonzero((excess[:-1] <= 0.0) & (excess[1:] > 0.0))
                if not freed.size:
                    return x, 0.0
                ends = times[freed[0]], times[freed[0] + 1]
                tau = brentq(lambda t, x=x: abs((b + a * math.sin(t)) * x) - g, *ends, xtol=1e-15)
                if tau >= end:
                    return x, 0.0
                jerk, short = a * math.cos(tau) * x, 1e-3
                side = math.copysign(1.0, jerk)
                # Too flat a start for an event finder: three terms of the Taylor series.
                snap = -a * math.sin(tau) * x - 2.0 * c * jerk
                x, v = x + jerk * short**3 / 6.0 + snap * short**4 / 24.0, jerk * short**2 / 2.0 + snap * short**3 / 6.0
                tau += short
            else:
                push, short = force - side * g, 1e-5
                x, v, tau = x + push * short**2 / 2.0, push * short, tau + short
        else:
            side = math.copysign(1.0, v)

        def motion(t: float, y: np.ndarray, s: float = side) -> list[float]:
            return [y[1], (b + a * math.sin(t)) * y[0] - g * s - 2.0 * c * y[1]]

        def stop(t: float, y: np.ndarray) -> float:
            return y[1]

        stop.terminal, stop.direction = True, -side  # type: ignore[attr-defined]
        flight = solve_ivp(
            motion, (tau, end), [x, v], method="DOP853", rtol=1e-10, atol=1e-12, events=stop, max_step=0.2
        )
        tau, (x, v) = flight.t[-1], flight.y[:, -1]
        if flight.status == 1:
            v = 0.0
    return float(x), float(v)


@pytest.mark.kernels
@pytest.mark.parametrize("beta", [0.09, 0.3, 2.0])
def test_a_constant_push_is_overcome_from_the_closed_form_on(beta: float) -> None:
    edge = 0.7 / math.sqrt(beta)
    kicks = edge * (1.0 + np.array([-1e-9, -1e-11, 1e-11, 1e-9]))
    found = [fr.friction.fate(fr.FrictionalMathieu(0.0, beta, 0.7), kick).status for kick in kicks]
    assert found == ["bounded", "bounded", "escapes", "escapes"]


def test_critical_kick_of_a_constant_push() -> None:
    beta = np.geomspace(1e-6, 1e6, depth(25, 5))
    assert fr.friction.critical_kick(0.0, beta, 3.0).smallest_found == pytest.approx(3.0 / np.sqrt(beta), rel=1e-10)


def test_fates_have_the_codes_of_every_status() -> None:
    assert (BOUNDED, ESCAPES, UNDECIDED) == (1, 0, -1)
    kicks = [0.98, 1.01]
    assert fr.friction.fates(FRACTAL.alpha, FRACTAL.beta, 1.0, kicks).tolist() == [1, 1]
    assert fr.friction.fates(FRACTAL.alpha, FRACTAL.beta, 1.0, kicks, max_steps=1).tolist() == [-1, -1]
    assert fr.friction.fates(0.0, 0.25, 1.0, 2.001) == 0


def test_escapes_lie_in_many_ranges() -> None:
    ranges = fr.friction.escape_ranges(FRACTAL, samples=2000)
    for edge, above in ((0.793243, ESCAPES), (0.999982, BOUNDED), (1.022013, ESCAPES)):
        around = fr.friction.fates(FRACTAL.alpha, FRACTAL.beta, 1.0, [edge - 1e-6, edge + 1e-6])
        assert around.tolist() == [ESCAPES + BOUNDED - above, above]
    # Caught in between, and above: each is confirmed by an independent integration, to rest for ever.
    rest = FRACTAL.gamma / (abs(FRACTAL.alpha) + abs(FRACTAL.beta))
    for kick in (0.98, 1.01, 1.08):
        x, v = rest_and_motion(FRACTAL, kick, 40.0)
        assert v == 0.0
        assert abs(x) < rest
        assert kick not in ranges
    for kick in (0.85, 1.03, 5.0, 12.0):
        assert kick in ranges
    assert fr.friction.critical_kick(FRACTAL.alpha, FRACTAL.beta).smallest_found == pytest.approx(0.793243, abs=5e-7)


def test_trajectories_agree_with_an_error_controlled_integrator(rng: np.random.Generator) -> None:
    stuck = 0
    for _ in range(12):
        equation = fr.FrictionalMathieu(rng.uniform(-2, 2), rng.uniform(-2, 0.5), 1.0, rng.choice([0.0, 0.05]))
        kick = rng.uniform(0.5, 4.0)
        motion = fr.friction.trajectory(equation, kick, periods=2)
        x, v = rest_and_motion(equation, kick, 4.0 * math.pi)
        stuck += bool((motion.state == 0).any())
        scale = max(1.0, np.abs(motion.A).max(), np.abs(motion.velocity).max())
        assert motion.tau[-1] == pytest.approx(4.0 * math.pi)
        assert motion.A[-1] == pytest.approx(x, abs=2e-5 * scale)
        assert motion.velocity[-1] == pytest.approx(v, abs=2e-5 * scale)
    assert stuck > 0


def test_both_solvers_agree_where_growth_is_fast(rng: np.random.Generator) -> None:
    alpha, beta = rng.uniform(0.3, 2.0, 60), rng.uniform(-1.0, 0.5, 60)
    kick = rng.uniform(0.5, 4.0, 60)
    fast = fr.mathieu.growth_rate(alpha, beta) > 0.06
    alpha, beta, kick = alpha[fast], beta[fast], kick[fast]
    # Leave out kicks beside an edge, where an error of the scheme decides.
    near = [fr.friction.fates(alpha, beta, 1.0, kick * (1.0 + d)) for d in (-3e-3, 0.0, 3e-3)]
    clear = (near[0] == near[1]) & (near[1] == near[2]) & (near[1] != UNDECIDED)
    assert clear.sum() > 10
    stepped = fr.friction.leapfrog_escapes(alpha[clear], beta[clear], 1.0, kick[clear], step=2e-3)
    wrong = stepped != (near[1][clear] == ESCAPES)
    assert wrong.mean() <= 0.05  # edges are fractal: a few lie closer than we looked


@few
@given(numbers(-3.0, 3.0), numbers(-3.0, 1.0), decades(1e-3, 1e3), decades(0.3, 30.0))
def test_only_the_ratio_of_kick_and_friction_matters(alpha: float, beta: float, gamma: float, kick: float) -> None:
    power = 2.0 ** round(math.log2(gamma))  # exact scaling
    kicks = kick * np.array([1.0, 1.1])  # two, which are compiled: one would be followed interpreted, slowly
    one, other = (fr.friction.fates(alpha, beta, gamma, gamma * kicks) for gamma in (1.0, power))
    assert one.tolist() == other.tolist()


@few
@given(numbers(-3.0, 3.0), numbers(-3.0, 1.0), decades(0.3, 30.0))
def test_kicks_to_either_side_are_mirror_images(alpha: float, beta: float, kick: float) -> None:
    equation = fr.FrictionalMathieu(alpha, beta, 1.0)
    one, other = (fr.friction.trajectory(equation, k, periods=2) for k in (kick, -kick))
    assert np.array_equal(one.A, -other.A)
    assert np.array_equal(one.state, -other.state)
    fates = fr.friction.fates(alpha, beta, 1.0, [kick, -kick])
    assert fates[0] == fates[1]


@few
@given(numbers(-3.0, 3.0), numbers(-3.0, 1.0))
def test_without_friction_it_is_the_floquet_verdict(alpha: float, beta: float) -> None:
    stable = fr.mathieu.is_stable(alpha, beta)
    assert (fr.friction.fates(alpha, beta, 0.0, 1.0) == BOUNDED) == stable
    low, high = fr.friction.certain_kicks(fr.FrictionalMathieu(alpha, beta, 1e-12))
    assume(stable or math.isfinite(high))  # else it grows too slowly, or linearly: any friction stops that
    assert fr.friction.fates(alpha, beta, 0.0, 0.0) == BOUNDED
    assert fr.friction.fates(alpha, beta, 1e-12, 1e6 if stable else 1.001 * high) == (BOUNDED if stable else ESCAPES)
    assert fr.friction.fates(alpha, beta, 1e-12, 0.999 * min(low, 1.0)) == BOUNDED


def drift(alpha: float, beta: float) -> tuple[float, np.ndarray, np.ndarray]:
    """Return the turn of a period, phases, and what friction does to a large amplitude in a period at each phase."""
    times = np.linspace(0.0, 2.0 * math.pi, 1501)

    def motion(t: float, y: np.ndarray) -> list[float]:
        p = beta + alpha * math.sin(t)
        return [y[1], p * y[0], y[3], p * y[2]]

    y = solve_ivp(motion, (0.0, times[-1]), [1, 0, 0, 1], t_eval=times, rtol=1e-9, atol=1e-11).y
    multipliers, vectors = np.linalg.eig(np.array([[y[0, -1], y[2, -1]], [y[1, -1], y[3, -1]]]))
    which = 0 if (vectors[0, 0].conj() * vectors[1, 0]).imag > 0.0 else 1
    f, df = (vectors[0, which] * y[k] + vectors[1, which] * y[k + 2] for k in (0, 1))
    phases = np.linspace(0.0, 2.0 * math.pi, 360, endpoint=False)
    zeta = np.exp(1j * phases)[:, None]
    push = 2.0 * np.sign((zeta * df).real) * f.conj() / (f * df.conj() - df * f.conj())
    return float(np.angle(multipliers[which])), phases, trapezoid((zeta.conj() * push).real, times, axis=1)


@pytest.mark.parametrize(("order", "trace"), [(2, 0.0), (3, 1.0), (3, -1.0), (4, math.sqrt(2.0))])
def test_friction_brakes_resonant_modes_at_every_phase(order: int, trace: float, rng: np.random.Generator) -> None:
    """Observed, not proved: where the turn of a period is pi k / m, the mean over the m phases is negative too."""
    alpha = rng.uniform(0.1, 5.0)
    betas = np.linspace(-3.0, 2.5, 800)
    beyond = fr.mathieu.discriminant(alpha, betas) > trace
    here = rng.choice(np.flatnonzero(beyond[1:] != beyond[:-1]))
    beta = brentq(lambda b: fr.mathieu.discriminant(alpha, b) - trace, betas[here], betas[here + 1], xtol=1e-14)
    turn, phases, change = drift(alpha, beta)
    means = [np.interp(phases + k * turn, phases, change, period=2.0 * math.pi) for k in range(order)]
    assert np.mean(change) < 0.0
    assert np.mean(means, axis=0).max() < 0.2 * np.mean(change)
    assert fr.friction.fates(alpha, beta, 1.0, 1e9) == BOUNDED


@settings(max_examples=depth(60, 15))
@given(
    st.just(0.0) | decades(1e-8, 1e4) | decades(1e-8, 1e4).map(lambda x: -x),
    st.just(0.0) | decades(1e-8, 1e4) | decades(1e-8, 1e4).map(lambda x: -x),
    st.just(0.0) | decades(1e-8, 1e8),
    st.just(0.0) | decades(1e-8, 1e8),
    st.just(0.0) | decades(1e-6, 10.0),
)
def test_every_run_ends(alpha: float, beta: float, gamma: float, kick: float, damping: float) -> None:
    found = fr.friction.fates([alpha] * 2, beta, gamma, kick, damping=damping, max_steps=20_000)
    assert found[0] in (BOUNDED, ESCAPES, UNDECIDED)
    if kick == 0.0:
        assert found[0] == BOUNDED


@few
@given(numbers(-3.0, 3.0), numbers(-3.0, 1.0), decades(0.3, 30.0))
def test_no_step_of_a_trajectory_goes_back_in_time(alpha: float, beta: float, kick: float) -> None:
    motion = fr.friction.trajectory(fr.FrictionalMathieu(alpha, beta, 1.0), kick, periods=4)
    assert (np.diff(motion.tau) >= 0.0).all()
    assert len(motion.tau) < 4 * 200
    held = motion.state == 0
    assert (motion.velocity[held] == 0.0).all()


@pytest.mark.slow
@few
@given(numbers(-3.0, 3.0), numbers(-3.0, 1.0), numbers(0.0, 1.0))
def test_certain_kicks_are_certain(alpha: float, beta: float, share: float) -> None:
    low, high = fr.friction.certain_kicks(fr.FrictionalMathieu(alpha, beta, 1.0))
    assume(math.isfinite(low))  # else nothing grows
    assert low <= high * (1.0 + 1e-12)
    assert (fr.friction.fates(alpha, beta, 1.0, low * np.array([share, 1.0])) == BOUNDED).all()
    critical = fr.friction.critical_kick(alpha, beta, samples=4, max_steps=2000).smallest_found
    assume(not math.isnan(critical))
    assert low * (1.0 - 1e-8) <= critical <= high * (1.0 + 1e-8)


@pytest.mark.kernels
def test_a_fate_and_a_trajectory_interpreted() -> None:
    fate = fr.friction.fate(FRACTAL, 1.08)
    assert (fate.status, fate.reversals, fate.sticks) == ("bounded", 2, 1)
    assert repr(fate).startswith("<bounded: sticks for all time; known after 1.29 periods and 2 stops>")
    motion = fr.friction.trajectory(FRACTAL, 1.08, periods=2)
    assert motion.A[-1] == pytest.approx(0.445993, abs=1e-6)
    assert not fr.friction.leapfrog_escapes(1.0, 0.3, 1.0, 0.5, periods=1, step=0.1)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("gamma", {"gamma": -1.0}),
        ("gamma", {"gamma": math.nan}),
        ("kick", {"kick": math.nan}),
        ("alpha", {"alpha": "x"}),
        ("kick", {"kick": [1.0, 2.0], "gamma": [1.0, 2.0, 3.0]}),
        ("must broadcast to one shape", {"alpha": [1.0, 2.0], "beta": [0.1, 0.2, 0.3]}),
    ],
)
def test_bad_input_is_named(name: str, change: dict[str, float]) -> None:
    values = {"alpha": 1.0, "beta": 0.3, "gamma": 1.0, "kick": 1.0} | change
    with pytest.raises((ValueError, TypeError), match=name):
        fr.friction.escapes(**values)


@pytest.mark.parametrize("largest", [0.0, -1.0, math.nan, "x", [1.0, 2.0, 3.0]])
def test_a_bad_limit_is_named(largest: object) -> None:
    with pytest.raises((ValueError, TypeError), match="largest"):
        fr.friction.critical_kick([1.0, 1.1], 0.3, largest=largest)


@pytest.mark.slow
@few
@given(numbers(-3.0, 3.0), numbers(-3.0, 1.0), numbers(1.0, 3.0))
def test_a_limited_search_finds_an_edge_below_its_limit(alpha: float, beta: float, share: float) -> None:
    floor, whole = fr.friction.critical_kick(alpha, beta, samples=4, max_steps=2000)
    assume(math.isfinite(whole))
    found = fr.friction.critical_kick(alpha, beta, largest=share * whole, samples=4, max_steps=2000).smallest_found
    assume(math.isfinite(found))
    assert floor * (1.0 - 1e-9) <= found <= share * whole * (1.0 + 2e-9)
    above = found * (1.0 + np.geomspace(1e-12, 1e-4, 30))
    assert (fr.friction.fates(alpha, beta, 1.0, above, max_steps=20_000) == ESCAPES).any()


def test_without_friction_the_slightest_kick_is_critical_or_none_is() -> None:
    found = fr.friction.critical_kick([1.0, 1.0, 0.0, 0.0], [0.3, -0.7, 0.0, 0.0], 0.0, damping=[0.0, 0.0, 0.0, 0.1])
    assert found.smallest_found.tolist() == [0.0, math.inf, 0.0, math.inf]


@pytest.mark.parametrize("above", [1e-8, 1e-7, 1e-6, 3e-6])
def test_motion_outwards_however_slow_is_not_bounded(above: float) -> None:
    # Comes to rest just beyond where the largest force holds it, and moves out by less than 1e-9 a period.
    equation = fr.FrictionalMathieu(2.5122443597386983, 0.6057077990479693, 1.0)
    kick = 0.6675718023393393 * (1.0 + above)
    rest = fr.friction.trajectory(equation, kick, periods=6)
    sizes = np.unique(np.abs(rest.A[rest.state == 0]))
    assert ((equation.alpha + equation.beta) * sizes > 1.0).all()
    assert (np.diff(sizes) > 0.0).sum() >= 4
    found = fr.friction.fate(equation, kick)
    assert found.status in (("undecided",) if above < 5e-8 else ("escapes",))


@pytest.mark.slow
def test_a_motion_ends_before_it_outgrows_a_double() -> None:
    for equation, kick in ((fr.FrictionalMathieu(0.0, 1e4, 1.0), 1.0), (fr.FrictionalMathieu(1.0, 0.3, 0.0), 1e308)):
        motion = fr.friction.trajectory(equation, kick)
        assert np.isfinite(motion.A).all()
        assert np.isfinite(motion.velocity).all()
        assert len(motion.tau) > 2
        assert motion.state[-1] != 0


def test_a_trajectory_says_what_was_followed() -> None:
    motion = fr.friction.trajectory(fr.FrictionalMathieu(0.0, 0.25, 1.0), 1.9, periods=1)
    assert repr(motion).startswith("<motion from A' = 1.9 over 1 periods")


def test_the_paper_s_test_takes_any_kick_and_needs_friction() -> None:
    assert fr.friction.leapfrog_escapes(1.0, 0.3, [1.0, 1e-308], 1e308, step=0.05).tolist() == [True, True]
    with pytest.raises(ValueError, match="gamma must be greater than zero"):
        fr.friction.leapfrog_escapes(1.0, 0.3, 0.0, 1.0)


def test_undecided_is_said_and_does_not_count() -> None:
    with pytest.warns(fr.UndecidedWarning, match="1 of 2"):
        found = fr.friction.escapes(FRACTAL.alpha, FRACTAL.beta, 1.0, [1.03, 0.1], max_steps=10)
    assert not found.any()
