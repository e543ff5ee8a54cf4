"""What axial waves make of a force, and what is said, refused and gone round at their resonances."""

from __future__ import annotations

import contextlib
import io
import json
import math
import re
import threading
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod import cli
from floquetrod._util import waiting
from floquetrod.rod.loads import axial
from floquetrod.rod.modes import coupled_verdict as coupled_stability
from tests.inside import FAR_ENDS, CoupledModes, Loads, modes_needed, up_to_resonance
from tests.seams import Forbidden, Heard, Tuned

TUBING = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=60.0)
LONG = TUBING.replace(length=600.0)
UNIT = TUBING.wave_speed / TUBING.length
"""Rad/s at which a wave turns by one radian along the tubing."""

HELD = 0.5 * math.pi * UNIT
"""The first axial resonance of the tubing with the far end held."""


def wave(frequency: float, **others: Any) -> fr.AxialWave:
    return fr.AxialWave(0.0, 10.0, frequency, **others)


def denominator(far_end: str, phase: complex) -> complex:
    """Return what the force along the rod is divided by, of the phase kappa L."""
    return {"held": np.cos(phase), "free": np.sin(phase), "driven": np.cos(0.5 * phase)}[far_end]


# --- the response ---


@pytest.mark.slow
@pytest.mark.parametrize("damping", [0.0, 0.4, 20.0, 3000.0])
@pytest.mark.parametrize("far_end", FAR_ENDS)
def test_the_largest_force_is_that_of_a_fine_grid(far_end: str, damping: float, rng: np.random.Generator) -> None:
    for phase in rng.uniform(0.05, 40.0, 5):
        load = wave(phase * UNIT, far_end=far_end, axial_damping=damping)
        if not damping and abs(denominator(far_end, phase)) < 0.011:
            continue
        found = TUBING.axial_response(load)
        s = np.linspace(0.0, TUBING.length, 100_001)
        sizes = np.abs(load.profile(TUBING.wave_speed, TUBING.length, s, load.frequency))
        turned = 0.5 * (phase * s[1] / TUBING.length) ** 2  # what a grid may miss, twice over
        assert sizes.max() <= found.factor * (1.0 + 1e-9)
        assert found.factor == pytest.approx(sizes.max(), rel=turned + 1e-7)
        there = np.abs(load.profile(TUBING.wave_speed, TUBING.length, np.array([found.position]), load.frequency))
        assert there[0] == pytest.approx(found.factor, rel=1e-7)
        assert found.largest == found.factor * found.amplitude
        assert found.amplitude == load.amplitude
        assert found.critical_forces == found.largest / TUBING.critical_force


def test_harmonics_are_added_in_time() -> None:
    load = wave(0.8 * UNIT, waveform=(1.0, 0.4j, 0.0, -0.3))
    found = TUBING.axial_response(load)
    s, t = np.linspace(0.0, TUBING.length, 801), np.linspace(0.0, 2.0 * math.pi, 1601)
    force = sum(
        h * np.outer(load.profile(TUBING.wave_speed, TUBING.length, s, k * load.frequency), np.exp(1j * k * t))
        for k, h in enumerate(load.harmonics.tolist(), start=1)
        if h
    )
    sizes = np.abs(np.real(force)).max(axis=1)
    assert found.largest == pytest.approx(load.amplitude * sizes.max(), rel=5e-3)
    assert found.amplitude == pytest.approx(load.amplitude * sizes[0], rel=5e-3)
    assert found.factor == pytest.approx(sizes.max() / sizes[0], rel=1e-2)


@pytest.mark.parametrize("far_end", FAR_ENDS)
def test_resonances_are_zeros_of_the_denominator_and_none_lies_between(far_end: str, rng: np.random.Generator) -> None:
    for phase in rng.uniform(0.05, 40.0, 5):
        resonances = TUBING.axial_response(wave(phase * UNIT, far_end=far_end)).resonances
        for resonance in resonances:
            assert abs(denominator(far_end, resonance.frequency / UNIT)) < 1e-12
            assert (resonance.harmonic, resonance.factor) == (1, math.inf)
        between = np.linspace(phase, resonances[-1].frequency / UNIT, 50)[1:-1]
        assert np.unique(np.sign(denominator(far_end, between))).size == 1  # type: ignore[arg-type]
        if len(resonances) == 2:
            assert resonances[0].frequency <= phase * UNIT <= resonances[1].frequency
            between = np.linspace(resonances[0].frequency / UNIT, phase, 50)[1:-1]
            assert np.unique(np.sign(denominator(far_end, between))).size == 1  # type: ignore[arg-type]
        else:  # below the first
            assert phase * UNIT < resonances[0].frequency


@pytest.mark.parametrize("far_end", FAR_ENDS)
def test_with_damping_whole_waves_fit_the_rod_at_a_resonance(far_end: str) -> None:
    for damping in (0.1 * UNIT, 2.0 * UNIT):
        for resonance in TUBING.axial_response(wave(7.0 * UNIT, far_end=far_end, axial_damping=damping)).resonances:
            kappa = np.sqrt(complex(resonance.frequency**2, -2.0 * damping * resonance.frequency)) / UNIT
            assert abs(denominator(far_end, kappa.real)) < 1e-12
            there = wave(resonance.frequency, far_end=far_end, axial_damping=damping)
            assert TUBING.axial_response(there).factor == pytest.approx(resonance.factor, rel=1e-6)


def test_resonances_of_harmonics_count() -> None:
    load = wave(0.45 * HELD, waveform=(1.0, 0.5))
    below, above = TUBING.axial_response(wave(0.55 * HELD, waveform=(1.0, 0.5))).resonances
    assert (below.harmonic, above.harmonic) == (2, 1)
    assert (below.frequency, above.frequency) == (pytest.approx(0.5 * HELD), pytest.approx(HELD))
    assert str(below).endswith("of harmonic 2")
    assert [r.harmonic for r in TUBING.axial_response(load).resonances] == [2]
    assert below.hertz == below.frequency / (2.0 * math.pi)


def test_a_uniform_force_has_no_resonance() -> None:
    found = TUBING.axial_response(fr.AxialLoad(3.0, 2.0, HELD))
    assert (found.largest, found.factor, found.resonances) == (2.0, 1.0, ())


def test_next_to_a_resonance_the_response_says_so() -> None:
    found = TUBING.axial_response(wave(HELD))
    assert found.largest == found.factor == math.inf
    assert [r.frequency for r in found.resonances] == [pytest.approx(HELD)]
    assert found.as_dict()["largest_N"] is None
    assert "at the axial resonance" in repr(found)
    json.dumps(found.as_dict(), allow_nan=False)


def test_a_slow_wave_in_a_rod_with_a_free_end_is_no_resonance() -> None:
    s = np.linspace(0.0, 60.0, 7)
    found = wave(1e-7, far_end="free").profile(TUBING.wave_speed, 60.0, s, 1e-7)
    assert found == pytest.approx(1.0 - s / 60.0, abs=1e-14)


# --- verdicts ---


def test_verdicts_tell_the_largest_force() -> None:
    load = fr.AxialWave(0.2 * TUBING.critical_force, 0.05 * TUBING.critical_force, 0.6 * HELD)
    verdict = TUBING.stability(load, modes=range(1, 13))
    assert isinstance(verdict, fr.results.RodStability)
    assert verdict.axial == TUBING.axial_response(load)
    assert verdict.axial.factor == pytest.approx(1.0 / math.cos(0.3 * math.pi), rel=1e-9)
    assert verdict.axial.in_words in repr(verdict)
    assert f"{verdict.axial.critical_forces:.3g} critical forces" in repr(verdict)
    uniform = TUBING.replace(ends="clamped").stability(
        fr.AxialLoad(load.mean, load.amplitude, 25.0), modes=range(1, 13)
    )
    assert "axial resonance" not in repr(uniform)


@pytest.mark.parametrize("beside", [0.0, 1e-5, -5e-3])
def test_a_resonance_is_refused_by_its_name_before_anything_is_computed(beside: float, forbidden: Forbidden) -> None:
    forbidden(coupled_stability, "stability")
    forbidden(coupled_stability, "ModalSystems")
    rod = LONG.replace(damping_rate=0.3)
    load = fr.AxialWave(0.0, "2kN", 0.1 * HELD * (1.0 + beside))
    with pytest.raises(
        ValueError, match=r"is at the axial resonance of the rod at 13\.44\d* rad/s.*axial_damping"
    ) as told:
        rod.stability(load)
    assert "damping_rate" not in str(told.value)
    assert "coupled modes" not in str(told.value)


def test_a_resonance_with_little_damping_is_refused_by_its_name(forbidden: Forbidden) -> None:
    forbidden(coupled_stability, "ModalSystems")
    for rate in (3e-3, 1e-5):
        load = fr.AxialWave(0.0, "2kN", 0.1 * HELD, axial_damping=rate)
        with pytest.raises(
            ValueError, match=r"is next to an axial resonance of the rod.*give more axial_damping"
        ) as told:
            LONG.stability(load)
        assert "damping_rate" not in str(told.value)


def test_too_many_modes_for_other_reasons_are_told_with_remedies_that_are_left(tuned: Tuned) -> None:
    tuned(most_coupled_modes=5)
    load = fr.AxialWave(0.5 * TUBING.critical_force, 0.3 * TUBING.critical_force, 25.0)
    with pytest.raises(ValueError, match=r"load needs \d+ coupled modes.*its damping_rate, a growth_tolerance"):
        modes_needed(TUBING, load, Loads.single(load), 0.0)
    damped = TUBING.replace(damping_rate=1e-3)
    with pytest.raises(ValueError, match=r"load needs \d+ coupled modes") as told:
        modes_needed(damped, load, Loads.single(load), 1e-3)
    assert not re.search("damping_rate|growth_tolerance|resonance of", str(told.value))


def test_the_damping_that_stabilises_takes_few_evaluations(heard: Heard) -> None:
    evaluated = heard(CoupledModes, "growth_without_decay")
    load = fr.AxialWave(0.5 * TUBING.critical_force, 0.3 * TUBING.critical_force, 40.0)
    for rod, tolerance in ((TUBING, 0.0), (TUBING.replace(damping_rate=0.2), 0.3)):
        evaluated.clear()
        rate = rod.stability(load, modes=range(1, 25), growth_tolerance=tolerance).damping_to_stabilise
        assert 6 < len(evaluated) < 20
        for share, status in ((1.0 - 1e-8, 0), (1.0 + 1e-8, 1)):
            damped = CoupledModes.of(rod.replace(damping_rate=share * rate), load, 24)
            assert damped.answers(Loads.single(load), tolerance).status.tolist() == [status]


# --- searches ---


@pytest.fixture
def few(tuned: Tuned, heard: Heard) -> list[Any]:
    """Let ranges take few samples, and return what is judged: modes, loads and so on."""
    tuned(samples_of_ranges=17, least_samples_of_a_group=3, groups_of_frequencies=4)
    return heard(CoupledModes, "answers")


def test_ranges_go_round_a_resonance(few: list[Any]) -> None:
    bounds = (0.8 * HELD, 1.2 * HELD)
    reports: list[tuple[int, int]] = []
    like = fr.AxialWave(0.0, 0.0, 1.0)
    found = TUBING.ranges(
        "frequency", like, mean=0.0, amplitude=10.0, bounds=bounds, progress=lambda *done: reports.append(done)
    )
    (gap,) = found.not_computed
    assert gap.resonance.frequency == pytest.approx(HELD)
    for end in gap[:2]:
        assert abs(math.cos(end / UNIT)) == pytest.approx(0.01, rel=1e-4)
    asked = np.concatenate([loads.frequency for _, loads, *_ in few])
    assert not ((gap.low < asked) & (asked < gap.high)).any()
    assert (asked.min(), asked.max()) == bounds
    assert HELD not in found
    assert all(part.high <= gap.low or part.low >= gap.high for part in (*found, *found.unstable))
    assert {part.high_end for part in found if part.high == gap.low} <= {"axial resonance"}
    assert found[0].low == bounds[0] if hasattr(found, "__getitem__") else found.intervals[0].low == bounds[0]
    assert re.search(r"not computed: axial resonance at 134\.437", repr(found))
    assert re.search(r"not computed: axial resonance at 21\.39", found.table("Hz"))
    assert [done for done, _ in reports] == sorted(done for done, _ in reports)
    assert reports[-1][0] == reports[-1][1] > 0
    assert len({total for _, total in reports}) == 1


@pytest.mark.slow
def test_pieces_of_a_search_join(few: list[Any], tuned: Tuned) -> None:
    # Without resonance within: the same intervals, in one piece and in four.
    like = fr.AxialWave(0.3 * TUBING.critical_force, 0.2 * TUBING.critical_force, 1.0)
    bounds = (0.3 * HELD, 0.34 * HELD)
    found = TUBING.ranges("frequency", like, bounds)
    tuned(groups_of_frequencies=1)
    whole = TUBING.ranges("frequency", like, bounds)
    assert [(p.low_end, p.high_end) for p in found].count((None, None)) == [
        (p.low_end, p.high_end) for p in whole
    ].count((None, None))
    assert [part[:2] for part in found] == [pytest.approx(part[:2], rel=1e-6) for part in whole]
    assert found.not_computed == whole.not_computed == ()


@pytest.mark.slow
def test_ranges_go_round_a_damped_resonance_that_needs_too_many_modes(few: list[Any], tuned: Tuned) -> None:
    like = fr.AxialWave(0.0, 0.0, 1.0, axial_damping=0.01)
    tuned(most_coupled_modes=40)
    found = TUBING.ranges(
        "frequency", like, mean=0.0, amplitude=10.0, bounds=(0.97 * HELD, 1.03 * HELD), growth_tolerance=5.0
    )
    (gap,) = found.not_computed
    assert 0.97 * HELD < gap.low < HELD < gap.high < 1.03 * HELD
    assert gap.resonance.frequency == pytest.approx(HELD)
    assert 100.0 < gap.resonance.factor < math.inf
    with pytest.raises(ValueError, match="axial resonance"):
        TUBING.ranges(
            "frequency",
            like,
            mean=0.0,
            amplitude=10.0,
            bounds=((1.0 - 1e-7) * HELD, (1.0 + 1e-7) * HELD),
            growth_tolerance=5.0,
        )


def test_nothing_but_resonance_is_refused_by_its_name() -> None:
    with pytest.raises(ValueError, match="is at the axial resonance"):
        TUBING.ranges(
            "frequency", fr.AxialWave(0.0, 0.0, 1.0), mean=0.0, amplitude=10.0, bounds=(0.999 * HELD, 1.001 * HELD)
        )
    with pytest.raises(ValueError, match="is at the axial resonance"):
        TUBING.ranges("mean", fr.AxialWave(0.0, 0.0, 1.0), amplitude=10.0, frequency=HELD)
    with pytest.raises(ValueError, match=r"bounds hold \d+ axial resonances"):
        axial.gaps(wave(1.0), TUBING.axial_line, (1.0, 1e9))


def test_gaps_are_where_verdicts_are_refused(rng: np.random.Generator) -> None:
    load = wave(1.0, waveform=(1.0, 0.0, 0.2))
    line = TUBING.axial_line
    found = axial.gaps(load, line, (0.1 * UNIT, 12.0 * UNIT))
    assert len(found) == 11  # zeros of cos 3x up to 12, among them those of cos x
    for frequency in rng.uniform(0.1 * UNIT, 12.0 * UNIT, 2000):
        refused = any(gap.low < frequency < gap.high for gap in found)
        near = min(abs(math.cos(frequency / UNIT)), abs(math.cos(3.0 * frequency / UNIT))) < 0.01
        assert refused == near
    for gap in found:  # both ends are answered
        for end in gap[:2]:
            axial.require_off_resonance(load, line, end)


def test_margins_end_at_a_resonance() -> None:
    for piece, end in (((0.5 * HELD, 1.5 * HELD), 0.9936), ((1.5 * HELD, 0.5 * HELD), 1.0064)):
        cut = up_to_resonance(TUBING, wave(1.0), piece)
        assert cut == (piece[0], pytest.approx(end * HELD, rel=1e-4))
    away = (0.5 * HELD, 0.9 * HELD)
    assert up_to_resonance(TUBING, wave(1.0), away) == away
    verdict = TUBING.stability(wave(0.999 * 0.9936 * HELD), modes=range(1, 5))
    below, above = verdict.frequency_margin
    assert below > 0.0
    assert above > 0.0


def test_arrays_and_maps_leave_a_resonance_undecided() -> None:
    like = fr.AxialWave(0.0, 0.0, 1.0)
    frequency = np.array([0.5, 1.0, 1.1]) * HELD
    assert TUBING.verdicts(like, mean=0.0, amplitude=10.0, frequency=frequency).tolist()[1] == -1
    growth = TUBING.growth_rate(like, mean=0.0, amplitude=10.0, frequency=frequency)
    assert np.isnan(growth).tolist() == [False, True, False]
    assert growth[0] == TUBING.growth_rate(like, mean=0.0, amplitude=10.0, frequency=float(frequency[0]))
    chart = fr.stability_map(TUBING, like, mean=(0.0, 10.0, 2), amplitude=10.0, frequency=frequency, growth=True)
    assert (
        chart.undecided
        == 2 + np.isin(TUBING.verdicts(like, mean=[0.0, 10.0], amplitude=10.0, frequency=frequency[0]), -1).sum()
    )
    assert np.isnan(chart.growth_rate[:, 1]).all()
    with pytest.raises(ValueError, match="is at the axial resonance"):
        fr.stability_map(TUBING, like, mean=(0.0, 10.0, 2), amplitude=(1.0, 10.0, 2), frequency=HELD)
    with pytest.raises(ValueError, match="is at the axial resonance"):
        TUBING.is_stable(like, mean=0.0, amplitude=10.0, frequency=HELD)


# --- the terminal ---


def test_check_tells_the_largest_force(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "tubing.toml"
    path.write_text('catalogue = "2.00x0.156 CT90"\nbore = "4.778in"\nlength = "60m"\n')
    given = [
        "check",
        "--rod",
        str(path),
        "--mean",
        "0.2Fcr",
        "--amplitude",
        "500N",
        "--wave",
        "held",
        "--modes",
        "1-12",
    ]
    assert cli.main([*given, "--frequency", "16Hz", "--no-margins"]) == 0
    text = capsys.readouterr().out
    assert re.search(
        r"\n          vibration largest at 60 m: 1295\.72 N \(0\.09947 Fcr\), 2\.59 times the amplitude\n", text
    )
    assert re.search(r"\n          axial resonance nearby: 21\.39\d* Hz \(134\.4 rad/s\)\n", text)
    assert cli.main([*given, "--frequency", "16Hz", "--no-margins", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["axial_response"]
    assert found == TUBING.axial_response(fr.AxialWave.hertz(0.0, 500.0, 16.0)).as_dict()
    assert cli.main([*given, "--frequency", f"{HELD}rad/s"]) == 2
    message = capsys.readouterr().err
    assert "at the axial resonance of the rod at 134.437 rad/s" in message
    assert "give --axial-damping, or another frequency" in message


def test_ranges_list_what_is_not_computed(
    few: list[Any], tmp_path: Any, capsys: pytest.CaptureFixture[str], heard: Heard
) -> None:
    path = tmp_path / "tubing.toml"
    path.write_text('catalogue = "2.00x0.156 CT90"\nbore = "4.778in"\nlength = "60m"\n')
    calls = heard(waiting.Waiting, "__call__")
    given = ["ranges", "--rod", str(path), "--mean", "0N", "--amplitude", "10N", "--frequency", "20:23Hz"]
    assert cli.main([*given, "--wave", "held", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    (gap,) = found["not_computed"]
    assert gap["axial_resonance_rad_per_s"] == pytest.approx(HELD)
    assert gap["low_rad_per_s"] < HELD < gap["high_rad_per_s"]
    assert any(waited.what == "searching along the frequency" for waited, *_ in calls)


def test_lines_of_progress_where_stderr_is_no_terminal(monkeypatch: pytest.MonkeyPatch, tuned: Tuned) -> None:
    class Pipe(io.StringIO):
        said = threading.Event()

        def write(self, text: str) -> int:
            count = super().write(text)
            if text.endswith("\n"):
                self.said.set()
            return count

    pipe = Pipe()
    tuned(seconds_between_plain_lines=0.001)
    with contextlib.redirect_stderr(pipe), waiting.Waiting("searching", "loads") as progress:
        progress(3, 4)
        assert pipe.said.wait(60.0)
    assert re.match(r"floquetrod: searching: \d+ s(, 3 of 4 loads.*)? \(Ctrl-C ends it\)\n", pipe.getvalue())
    assert "\r" not in pipe.getvalue()


def test_pauses_between_lines_of_progress_double(monkeypatch: pytest.MonkeyPatch, tuned: Tuned) -> None:
    pauses: list[float] = []

    def wait(pause: float) -> bool:
        pauses.append(pause)
        return len(pauses) > 4

    pipe = io.StringIO()
    tuned(seconds_between_plain_lines=10.0)
    progress = waiting.Waiting("searching")
    monkeypatch.setattr(progress._left, "wait", wait)
    with contextlib.redirect_stderr(pipe):
        progress._speak()
    assert pauses == [10.0, 20.0, 40.0, 80.0, 160.0]
    assert pipe.getvalue().count("\n") == 4
