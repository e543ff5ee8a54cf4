"""Systems with delays: truth tables, closed forms, agreement of two methods, and what is refused."""

from __future__ import annotations

import cmath
import math
import pickle
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.equations.system_files import read_system
from tests.conftest import depth

TURN = 2.0 * math.pi


def delayed_mathieu(d: float, e: float, b: float, a: float) -> fr.DelaySystem:
    """X'' + a x' + (d + e cos t) x = b x(t - 2 pi)."""
    return fr.DelaySystem([[d]], [[[e]]], damping=[[a]], delayed=[(TURN, [[-b]])])


def hayes(a: float, b: float) -> fr.DelaySystem:
    """X' = a x + b x(t - 1)."""
    return fr.DelaySystem.first_order([[a]], delayed=[(1.0, [[b]])], period=1.0)


@pytest.mark.parametrize(
    ("numbers", "multiplier"),
    [
        ((3.0, 2.0, -0.15, 0.1), -0.46166813735772 + 0.22149508481922j),
        ((1.2, 0.5, 0.2, 0.05), 0.95231647428693 + 0.00655823618886j),
    ],
)
def test_multipliers_are_those_of_the_table(numbers: tuple[float, float, float, float], multiplier: complex) -> None:
    """Collocation with 40 and 60 nodes found them, to eleven digits; the stated error holds what they leave."""
    found = fr.stability(delayed_mathieu(*numbers))
    gap, error = min(
        (abs(mu - multiplier), error) for mu, error in zip(found.multipliers, found.multiplier_errors, strict=True)
    )
    assert gap < 1e-11
    assert gap <= error + 1e-13 < 2e-11


@pytest.mark.parametrize("omega", [0.3, 1.0, 1.5707963267948966, 2.0, 2.9])
@pytest.mark.parametrize(("push", "status"), [(-1e-9, "stable"), (1e-9, "unstable")])
def test_hayes_boundary_is_sharp(omega: float, push: float, status: str) -> None:
    """At a = w cot w, b = -w / sin w a root i w crosses; b a billionth beyond is unstable."""
    a, b = omega / math.tan(omega), -omega / math.sin(omega)
    assert fr.stability(hayes(a, b * (1.0 + push))).status == status
    assert fr.stability(hayes(a, b)).status == "undecided"


def test_characteristic_roots_solve_their_equation() -> None:
    """Exponents of constant coefficients are roots, not only up to turns of the map; whatever the period."""
    for period in (1.0, 0.3, 7.0):
        system = fr.DelaySystem([[4.0]], damping=[[0.3]], delayed=[(1.7, [[0.4]]), (math.pi, [[-0.2]])], period=period)
        found = fr.stability(system)
        assert len(found.exponents) > 1
        assert found.exponent_errors[0] < 1e-10
        pairs = zip(found.exponents, found.exponent_errors, found.multipliers, strict=True)
        for s, error, mu in pairs:
            value = s * s + 0.3 * s + 4.0 + 0.4 * cmath.exp(-1.7 * s) - 0.2 * cmath.exp(-math.pi * s)
            slope = 2.0 * s + 0.3 - 0.68 * cmath.exp(-1.7 * s) + 0.2 * math.pi * cmath.exp(-math.pi * s)
            assert abs(value / slope) <= error + 1e-13
            assert abs(mu - cmath.exp(s * period)) < 1e-12


def test_no_delayed_term_is_the_ordinary_system() -> None:
    matrices = {"cosines": [[[0.1, 0.2], [0.2, 0.16]]], "damping": [[0.02, 0.0], [0.01, 0.03]], "period": 2.3}
    stiffness = [[1.0, 0.0], [0.0, 4.0]]
    plain = fr.stability(fr.HillSystem(stiffness, **matrices))
    for delayed in ([], [(0.7, np.zeros((2, 2)))]):
        found = fr.stability(fr.DelaySystem(stiffness, **matrices, delayed=delayed))
        assert found.status == plain.status
        assert found.exponents[0].real == pytest.approx(plain.exponents[0].real, abs=1e-11)


def test_terms_of_one_delay_add_up() -> None:
    whole = fr.DelaySystem([[2.0]], damping=[[0.2]], delayed=[(1.0, [[0.5]])], period=3.0)
    halves = fr.DelaySystem([[2.0]], damping=[[0.2]], delayed=[(1.0, [[0.2]]), (1.0, [[0.3]])], period=3.0)
    assert fr.stability(halves).exponents[0] == pytest.approx(fr.stability(whole).exponents[0], abs=1e-12)


def test_verdicts_say_themselves() -> None:
    found = fr.stability(delayed_mathieu(3.0, 2.0, -0.15, 0.1))
    assert "1 equation of second order, general, 1 harmonic, 1 delayed term" in str(found.report())
    assert found.as_dict(damping=True)["delays"] == [TURN]
    assert "collocation" in str(fr.compare(found.equation).report())


def test_first_and_second_order_say_the_same() -> None:
    cut, rest = [[0.0, 0.0], [-0.4, 0.0]], [[0.0, 0.0], [0.0, 0.0]]
    first = fr.DelaySystem.first_order_from_pieces(
        [(1.0, [[0.0, 1.0], [-2.0, -0.1]]), (Fraction(1, 3), [[0.0, 1.0], [-1.0, -0.1]])],
        delayed=[(1.6, [(1.0, cut), (Fraction(1, 3), rest)])],
    )
    second = fr.DelaySystem.from_pieces(
        [(1.0, [[2.0]]), (Fraction(1, 3), [[1.0]])],
        damping=[[0.1]],
        delayed=[(1.6, [(1.0, [[0.4]]), (Fraction(1, 3), [[0.0]])])],
    )
    one, other = fr.stability(first), fr.stability(second)
    assert one.multipliers[0].real == pytest.approx(other.multipliers[0].real, abs=one.error + other.error + 1e-13)


def random_system(rng: np.random.Generator) -> fr.DelaySystem:
    """Draw a system of one or two equations with one or two delays, with jumps or without."""
    n, period = int(rng.integers(1, 3)), float(rng.uniform(0.5, 4.0))
    shares = rng.choice([0.25, 0.5, 1.0, 1.5, 2.0, 0.3819660113, 1.6180339887, rng.uniform(0.1, 2.5)], 2)
    delays = (shares * period)[: int(rng.integers(1, 3))].tolist()

    def matrix(size: float) -> list[list[float]]:
        return (size * rng.normal(size=(n, n))).tolist()

    stiffness = np.diag(rng.uniform(0.5, 6.0, n))
    damping = (rng.uniform(0.02, 0.3) * np.eye(n)).tolist()
    if rng.random() < 0.5:
        terms = [(tau, matrix(0.6), [matrix(0.4)]) for tau in delays]
        return fr.DelaySystem(stiffness, [matrix(0.4)], damping=damping, period=period, delayed=terms)
    cut = Fraction(period) * Fraction(float(rng.uniform(0.2, 0.8)))
    rest = Fraction(period) - cut

    def pieces(mean: object, size: float) -> list[tuple[Fraction, object]]:
        return [(length, np.asarray(mean) + matrix(size)) for length in (cut, rest)]

    terms = [(tau, pieces(np.zeros((n, n)), 0.7)) for tau in delays]
    return fr.DelaySystem.from_pieces(pieces(stiffness, 0.3), damping=damping, delayed=terms)


def check_against_second_method(count: int, seed: int) -> tuple[int, int]:
    """Compare verdicts and the largest multiplier on random systems; return how many are stable and undecided."""
    rng, stable, undecided = np.random.default_rng(seed), 0, 0
    for number in range(count):
        system = random_system(rng)
        one, other = fr.stability(system), fr.stability(system, "semi_discretisation")
        assert {one.status, other.status} != {"stable", "unstable"}, (number, system)
        stable, undecided = stable + (one.status == "stable"), undecided + (one.status == "undecided")
        if other.exponents and one.exponents:
            gaps = [
                (abs(mu - other.multipliers[0]) - error)
                for mu, error in zip(one.multipliers, one.multiplier_errors, strict=True)
            ]
            assert min(gaps) <= other.multiplier_errors[0], (number, system, min(gaps))
    return stable, undecided


@pytest.mark.slow
def test_methods_agree_on_some_systems() -> None:
    stable, undecided = check_against_second_method(4, 3)
    assert 0 < stable < 4
    assert undecided == 0


@pytest.mark.slow
def test_methods_agree_on_many_systems() -> None:
    count = depth(75, 50)
    stable, undecided = check_against_second_method(count, 32)
    assert 0.1 * count < stable < 0.9 * count
    assert undecided < 0.01 * count


def test_solution_from_a_history() -> None:
    """Of x' = -x(t - 1), x = 1 before: polynomials piece by piece; and growth is that of the leading multiplier."""
    solution = fr.solve(hayes(0.0, -1.0), [1.0], 3.0)
    assert solution([1.0, 2.0, 3.0])[:, 0] == pytest.approx([0.0, -0.5, -1.0 / 6.0], abs=1e-14)
    assert solution.error < 1e-13
    system = delayed_mathieu(0.6, 0.5, 0.2, 0.05)
    found = fr.solve(system, (lambda t: [math.cos(t)], [0.0]), 30.0 * TURN)
    mu = fr.stability(system).multipliers[0]
    x0, x1, x2 = (found((27.0 + turn) * TURN + 0.3)[0] for turn in range(3))
    assert x2 - 2.0 * mu.real * x1 + abs(mu) ** 2 * x0 == pytest.approx(0.0, abs=1e-9 * abs(x2))
    assert found(1.0, 1).shape == (1,)


def test_damping_to_stabilise() -> None:
    system = fr.DelaySystem([[1.0]], damping=[[0.01]], delayed=[(1.3, [[0.3]])])
    rate = fr.stability(system).damping_to_stabilise
    assert fr.stability(system.damped(1.001 * rate)).status == "stable"
    assert fr.stability(system.damped(0.999 * rate)).status == "unstable"
    assert fr.stability(hayes(0.5, -0.4)).damping_to_stabilise == pytest.approx(0.1, abs=1e-9)
    pushed = fr.DelaySystem([[1.0]], damping=[[0.1]], delayed=[(1.0, [[-1.5]])])
    assert fr.stability(pushed).damping_to_stabilise == math.inf


def test_names_of_instabilities() -> None:
    names = [str(fr.stability(hayes(a, b)).resonances[0]) for a, b in ((-1.0, -2.5), (0.5, -0.2))]
    assert names == ["Hopf instability", "growth without oscillation"]
    doubling = fr.DelaySystem.first_order([[0.0]], [[[-0.9]]], period=2.0, delayed=[(2.0, [[-2.0]])])
    assert {name.kind for name in fr.stability(doubling).resonances} <= {"hopf", "flip"}


def test_values_are_equal_by_content_and_can_be_pickled() -> None:
    system = delayed_mathieu(1.0, 0.2, 0.1, 0.05)
    again = pickle.loads(pickle.dumps(system))
    assert again == system
    assert hash(again) == hash(system)
    assert fr.stability(again) == fr.stability(system)


def test_chart_of_a_family_with_delays() -> None:
    chart = fr.chart(hayes, over={"a": (-2.0, 2.0, 5), "b": (-3.0, 1.0, 4)})
    assert chart.heading == "system of 1 equation of first order with delays"
    for i, b in enumerate(chart.y.values):
        for j, a in enumerate(chart.x.values):
            if abs(b) < -a:
                assert chart.stable[i, j]
            if a + b > 0.0:
                assert not chart.stable[i, j]


SERIES = """
[system]
stiffness = [[3.0]]
cosines = [[[2.0]]]
damping = [[0.1]]
period = 6.25
[[system.delayed]]
delay = "6.25s"
matrix = [[0.15]]
sines = [[[0.1]]]
"""
PIECES = """
[system]
[[system.pieces]]
duration = 1.0
mean = [[-1.0]]
[[system.pieces]]
duration = 0.5
mean = [[0.2]]
[[system.delayed]]
delay = 0.75
[[system.delayed.pieces]]
duration = 1.0
matrix_start = [[0.3]]
slope = [[0.1]]
[[system.delayed.pieces]]
duration = 0.5
matrix = [[0.0]]
"""


def test_files_hold_systems_with_delays(tmp_path: Path) -> None:
    path = tmp_path / "system.toml"
    path.write_text(SERIES, encoding="utf-8")
    wave = [[[0.1]]]
    expected = fr.DelaySystem([[3.0]], [[[2.0]]], damping=[[0.1]], period=6.25, delayed=[(6.25, [[0.15]], (), wave)])
    assert read_system(path) == expected
    path.write_text(PIECES, encoding="utf-8")
    back = [(1.0, fr.equations.Varying(start=[[0.3]], slope=[[0.1]])), (0.5, [[0.0]])]
    pieces = [(1.0, [[-1.0]]), (0.5, [[0.2]])]
    assert read_system(path) == fr.DelaySystem.first_order_from_pieces(pieces, delayed=[(0.75, back)])


def test_arrays_hold_systems_with_delays(tmp_path: Path) -> None:
    path, wave = tmp_path / "system.npz", [[[0.1]]]
    arrays = {"stiffness": [[3.0]], "delays": [0.5, 2.0], "delayed": [[[0.15]], [[0.2]]], "delayed_sines": [wave, wave]}
    np.savez(path, period=6.25, **arrays)
    terms = [(0.5, [[0.15]], (), wave), (2.0, [[0.2]], (), wave)]
    assert read_system(path) == fr.DelaySystem([[3.0]], period=6.25, delayed=terms)
    np.savez(path, period=6.25, **arrays | {"delayed_sines": [wave]})
    with pytest.raises(ValueError, match=r"'delayed_sines' must have 2 terms as delays has, got shape \(1, 1, 1, 1\)"):
        read_system(path)


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (SERIES, 'delay = "6.25s"', "", r"delayed\[0\]: key 'delay' is missing"),
        (SERIES, 'delay = "6.25s"', 'delay = "0s"', r"delayed\[0\]: delay must be greater than zero"),
        (SERIES, "matrix", "matrices", r"delayed\[0\]: unknown key 'matrices'"),
        (SERIES, "[[0.15]]", "[[0.15, 1.0]]", r"delayed\[0\]"),
        (PIECES, "slope", "mean", r"delayed\[0\]: pieces\[0\]: unknown key 'mean'"),
        (PIECES, "delay = 0.75", "delay = 0.75\nmatrix = [[1.0]]", "key 'matrix' does not go with pieces"),
    ],
)
def test_bad_files_are_refused(tmp_path: Path, text: str, old: str, new: str, message: str) -> None:
    (tmp_path / "system.toml").write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        read_system(tmp_path / "system.toml")


@pytest.mark.slow
def test_near_boundaries_verdicts_are_right_or_undecided() -> None:
    """On either side of Hayes' curve, and of a delayed oscillator's, by 1e-3 down to 1e-14 of the delayed term."""
    rng, undecided = np.random.default_rng(8), 0
    for _ in range(depth(150, 100)):
        w, step = float(rng.uniform(0.1, 3.0)), 10.0 ** -float(rng.uniform(3.0, 14.0))
        a, b = w / math.tan(w), -w / math.sin(w)
        for side, wanted in ((-step, "stable"), (step, "unstable")):
            status = fr.stability(hayes(a, b * (1.0 + side))).status
            assert status in (wanted, "undecided"), (w, side)
            undecided += status == "undecided"
            assert status == wanted or abs(side) < 1e-9, (w, side)
    assert undecided


@pytest.mark.slow
def test_bands_of_a_chart_lie_on_hayes_curve() -> None:
    chart = fr.chart(hayes, over={"a": (-4.0, 2.0, 40), "b": (-5.0, 5.0, 40)})
    (band,) = chart.bands.bands
    inside = (band.x > -3.999) & (band.x < 1.999) & (np.abs(band.y) < 4.999)
    for a, b in zip(band.x[inside].tolist(), band.y[inside].tolist(), strict=True):
        # 1e-7 from the boundary; at a = 1, b = -1 two roots meet, and growth is the square root of the distance.
        assert fr.stability(hayes(a, b)).exponents[0].real == pytest.approx(0.0, abs=math.sqrt(2e-7))


def holds_for_all(proof: fr.results.Proof) -> bool:
    """Whether it is proved that a system is stable whatever its delays are."""
    return proof.status == "stable" and "whatever the delays" in proof.statement


@pytest.mark.slow
def test_proofs_of_stability_for_all_delays_are_sharp() -> None:
    """Of q'' + 2 z q' + q + d q(t - tau) = 0 for d up to 2 z sqrt(1 - z^2), of x' = -x + b x(t - tau) up to 1."""
    bound = 0.2 * math.sqrt(0.99)
    for share, proved in ((0.999, True), (1.001, False)):
        system = fr.DelaySystem([[1.0]], damping=[[0.2]], delayed=[(2.7, [[share * bound]])])
        assert holds_for_all(fr.certify(system)) == holds_for_all(fr.certify(hayes(-1.0, -share))) == proved
    proof = fr.certify(hayes(-1.0, 0.5))
    assert proof.statement == "every solution decays, whatever the delays are: a quadratic functional decreases"
    assert len(proof.references) > 1
    for system in (hayes(0.0, 0.0), hayes(-1.0, 1.0)):
        assert fr.certify(system).status == "undecided"


def test_proofs_take_variation_mass_and_jumps_into_account() -> None:
    """What varies counts as what is delayed does."""
    for wave, proved in ((0.9, True), (1.0, False)):  # beside 0.2; 1.12 is borne
        system = fr.DelaySystem([[4.0]], [[[wave]]], mass=[[2.0]], damping=[[0.8]], delayed=[(1.0, [[0.2]])])
        assert holds_for_all(fr.certify(system)) == proved
    for jump, proved in ((0.1, True), (1.2, False)):
        pieces, back = [(1.0, [[2.0 + jump]]), (2.0, [[2.0]])], [(1.0, [[0.1]]), (2.0, [[0.0]])]
        system = fr.DelaySystem.from_pieces(pieces, damping=[[0.5]], delayed=[(0.7, back)])
        assert holds_for_all(fr.certify(system)) == proved


@pytest.mark.slow
def test_what_is_proved_is_stable_with_random_delays() -> None:
    rng, proved = np.random.default_rng(4), 0
    for _ in range(depth(160, 100)):
        n, size = int(rng.integers(1, 4)), 10.0 ** rng.uniform(-2.5, 0.0)
        delays = rng.uniform(0.1, 8.0, 2).tolist()
        system = fr.DelaySystem(
            np.diag(rng.uniform(0.5, 4.0, n)),
            [0.3 * size * rng.normal(size=(n, n))],
            damping=rng.uniform(0.1, 1.0) * np.eye(n),
            period=float(rng.uniform(0.5, 4.0)),
            delayed=[(delay, size * rng.normal(size=(n, n))) for delay in delays],
        )
        if fr.certify(system).status == "stable":
            proved += 1
            assert fr.stability(system).status == "stable", system
    assert proved > 20


def test_what_has_no_answer_is_said() -> None:
    system = delayed_mathieu(1.0, 0.2, 0.1, 0.05)
    with pytest.raises(TypeError, match="without delays"):
        _ = fr.stability(system).monodromy


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: fr.DelaySystem([[1.0]], delayed=[(0.0, [[1.0]])]), r"delayed\[0\]\[0\] must be greater than zero"),
        (lambda: fr.DelaySystem([[1.0]], delayed=[(-1.0, [[1.0]])]), r"delayed\[0\]\[0\] must be greater than zero"),
        (lambda: fr.DelaySystem([[1.0]], delayed=[(math.nan, [[1.0]])]), r"delayed\[0\]\[0\] must be finite"),
        (lambda: fr.DelaySystem([[1.0]], delayed=[(1.0, np.eye(2))]), r"delayed\[0\]\[1\] must be 1 x 1"),
        (lambda: fr.DelaySystem([[1.0]], delayed=[(1.0, [[math.nan]])]), r"delayed\[0\]\[1\]"),
        (lambda: fr.DelaySystem([[1.0]], delayed=[1.0]), "delayed must be a sequence of"),
        (lambda: fr.DelaySystem([[1.0]], delayed=2.0), "delayed must be a sequence of"),
        (lambda: fr.DelaySystem([[[1.0]], [[2.0]]]), "single system"),
        (
            lambda: fr.DelaySystem.from_pieces([(1.0, [[1.0]]), (1.0, [[2.0]])], delayed=[(1.0, [(1.0, [[1.0]])])]),
            r"delayed\[0\]\[1\] must add up to the period 2.0, got 1.0",
        ),
        (lambda: fr.solve(hayes(0.0, -1.0), [1.0], -3.0), "span must go forward"),
        (lambda: fr.solve(hayes(0.0, -1.0), [1.0, 2.0], 3.0), "initial must be a vector of 1"),
        (lambda: fr.solve(delayed_mathieu(1.0, 0.2, 0.1, 0.05), [1.0], 3.0), r"initial must be \(history, rate\)"),
        (lambda: fr.stability(hayes(0.0, -1.0), "monodromy"), "method must be"),
        (lambda: fr.stability(hayes(0.0, -1.0), "collocation", above=2.0), "above must lie between"),
    ],
)
def test_bad_input_has_one_clear_error(call: object, message: str) -> None:
    assert callable(call)
    with pytest.raises((TypeError, ValueError), match=message):
        call()
