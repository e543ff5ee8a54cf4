"""Verdicts on systems: the same input, the same bits, whatever a process did before and asks numpy to raise."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.floquet.kernels import system_series
from tests.conftest import depth
from tests.seams import Tuned

_CALLS = depth(200, 20)  # of which two in five once differed from the others


def oscillators(n: int, **more: Any) -> fr.HillSystem:
    """Return n coupled oscillators; of two, those whose digits once changed from call to call."""
    if n == 2:
        return fr.HillSystem([[1, 0], [0, 4]], [[[0.1, 0.2], [0.2, 0.16]]], period=2.0, **more)
    wave = 0.1 + 0.05 * np.add.outer(np.arange(n), np.arange(n))
    return fr.HillSystem(np.diag(np.arange(1.0, n + 1.0)), [wave / n], period=2.0, **more)


def turned(n: int) -> fr.HillSystem:
    """Return oscillators with gyroscopic forces."""
    wave = np.triu(np.full((n, n), 0.1), 1)
    return oscillators(n, gyroscopic=wave - wave.T)


SYSTEMS: dict[str, Callable[[int], Any]] = {
    "undamped": oscillators,
    "damped": lambda n: oscillators(n, damping=np.diag(np.linspace(0.01, 0.02, n))),
    "gyroscopic": turned,
    "two phases": lambda n: oscillators(n, sines=[np.zeros((n, n)), np.full((n, n), 0.1)]),
    "first order": lambda n: fr.PeriodicSystem(-0.1 * np.eye(n), [np.full((n, n), 0.3)], period=2.0),
}


def bits(result: Any) -> list[bytes]:
    """Return all numbers of a verdict as bytes."""
    names = ("error", "growth_rate", "exponents", "exponent_errors", "krein_signs", "multipliers")
    return [np.asarray(getattr(result, name)).tobytes() for name in names]


def as_new(tuned: Tuned) -> None:
    """Let the process forget what it was asked, so that it interprets kernels before it takes compiled ones."""
    tuned(interpreted_work={}, is_series_kernel_on_disk=lambda function: False)
    system_series.OFTEN_ASKED.clear()


def asked(question: Callable[[], list[bytes]], rng: np.random.Generator, calls: int) -> set[bytes]:
    """Return the different answers to calls between which arrays of all lengths come and go."""
    kept: list[Any] = []
    found = set()
    for _ in range(calls):
        kept.append(np.empty(int(rng.integers(1, 60)), dtype=np.uint8 if rng.random() < 0.5 else float))
        if len(kept) > 20:
            del kept[int(rng.integers(20))]
        found.add(b"".join(question()))
    return found


@pytest.mark.parametrize("n", [1, *(pytest.param(n, marks=pytest.mark.slow) for n in (2, 3, 8))])
@pytest.mark.parametrize("kind", SYSTEMS)
def test_the_same_input_has_the_same_bits(kind: str, n: int, tuned: Tuned, rng: np.random.Generator) -> None:
    as_new(tuned)
    assert len(asked(lambda: bits(fr.stability(SYSTEMS[kind](n))), rng, _CALLS if n < 8 else depth(30, 15))) == 1


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["undamped", "damped"])
def test_every_method_and_arrays_have_the_same_bits(kind: str, tuned: Tuned, rng: np.random.Generator) -> None:
    as_new(tuned)

    def every() -> list[bytes]:
        system = SYSTEMS[kind](2)
        return [each for result in fr.compare(system).results for each in bits(result)]

    def arrays() -> list[bytes]:
        several = fr.systems.stack([SYSTEMS[kind](2)] * 3)
        return [np.asarray(ask(several)).tobytes() for ask in (fr.systems.growth_rate, fr.systems.multipliers)]

    assert len(asked(every, rng, depth(15, 6))) == 1
    as_new(tuned)
    assert len(asked(arrays, rng, _CALLS)) == 1
    rates, values = fr.systems.growth_rate(SYSTEMS[kind](2)), fr.systems.multipliers(SYSTEMS[kind](2))
    assert arrays() == [np.full(3, rates).tobytes(), np.tile(values, (3, 1)).tobytes()]


ROD = fr.Rod.nitinol()
LOAD = fr.AxialLoad(0.34, 0.34, 150.0)
FAINT, FAR, MANY = 1e-200, 1e-150, 30
QUESTIONS: dict[str, Callable[[], Any]] = {
    **{f"{kind} {n}": lambda kind=kind, n=n: fr.stability(SYSTEMS[kind](n)) for kind in SYSTEMS for n in (1, 2, 3)},
    "many": lambda: fr.stability(oscillators(MANY)),
    "many, of two phases": lambda: fr.stability(
        fr.HillSystem(np.diag(np.arange(1.0, 111.0)), [0.01 * np.eye(110)], [0.01 * np.ones((110, 110))], period=0.5)
    ),
    "faint": lambda: fr.compare(fr.HillSystem(np.eye(2), [[[FAINT, FAINT], [FAINT, 0.0]]], period=2.0)).results,
    "soft": lambda: [
        fr.stability(fr.HillSystem([[FAR]], [[[0.1 * FAR]]], period=2.0), name) for name in ("monodromy", "spectral")
    ],
    "massive": lambda: fr.stability(
        oscillators(2, mass=[[2.0, 1.0], [1.0, 2.0]], gyroscopic=[[0.0, FAINT], [-FAINT, 0.0]])
    ),
    "arrays": lambda: [
        ask(fr.systems.stack([fr.HillSystem([[1.0]], [[[size]]], period=2.0) for size in (FAINT, 0.1)])).tolist()
        for ask in (fr.systems.is_stable, fr.systems.growth_rate, fr.systems.multipliers)
    ],
    "a proof": lambda: fr.certify(oscillators(2)),
    "tongues": lambda: fr.systems.first_order_tongues(oscillators(2)),
    "equations": lambda: [fr.compare(e).results for e in (fr.Mathieu(0.5, -0.25), fr.Mathieu(FAINT, -0.3))],
    "a square wave": lambda: fr.compare(fr.Meissner(0.5, -0.25)).results,
    "mathieu": lambda: fr.mathieu.growth_rate([FAINT, 0.1, 3.0, 500.0], np.array([-1.0, -0.25, -2.0, -1e3])).tolist(),
    "a rod": lambda: ROD.stability(LOAD).growth_rate,
    "a rod against friction": lambda: ROD.stability(LOAD, friction=0.1, kick=0.05).status,
    "ranges": lambda: str(ROD.ranges("mean", amplitude=0.34, frequency=150.0)),
    "a map": lambda: fr.stability_map(
        ROD, mean=(0.0, 1.7, 4), amplitude=0.3, frequency=(20.0, 200.0, 5), growth=True
    ).growth_rate.tolist(),
}  # fmt: skip
"""Public verdicts, also where numbers underflow."""


LONG = ("many, of two phases", "two phases 3", "ranges", "equations")
"""Questions that take a tenth of a second and more."""


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in QUESTIONS])
def test_answers_do_not_depend_on_what_numpy_raises(name: str, tuned: Tuned) -> None:
    as_new(tuned)
    expected = QUESTIONS[name]()
    as_new(tuned)
    with np.errstate(all="raise"):
        found = QUESTIONS[name]()
    assert found == expected
