"""Threads, forks, fresh processes and signals; and every result pickled, compared and asked for its truth."""

from __future__ import annotations

import functools
import math
import multiprocessing
import os
import pickle
import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import floquetrod as fr
from tests.fuzz import apart, runs
from tests.fuzz.calls import CLAMPED, FIRST_ORDER, LOAD, ROD, SYSTEM, oscillators, simulation, table
from tests.fuzz.core import Found, told

CASES = 60
QUICK = 8

PROMPT = 300.0
"""Seconds within which Ctrl-C has to be answered: the pieces of work between are far shorter on the busiest machine."""
_AGAIN = 3.0  # seconds until it is sent once more

ANSWERED = 300.0
"""Seconds within which a forked process has to answer a question that takes far less."""

QUIET = {"Explorer", "simulate", "compare", "Bands.to_csv", "Chart.save", "Simulation.save"}
"""Calls that write or draw, or say how long they took: not for many threads or processes at once."""


def check(rng: np.random.Generator) -> Found:
    """Make one of the attacks."""
    kinds = (threads, forks, forks_beside, interrupts, _results)
    weights = (0.4, 0.15, 0.15, 0.1, 0.2)
    return kinds[int(rng.choice(len(kinds), p=weights))](rng)


def see(name: str) -> Any:
    """Return the answer to one call of the table, of a picture its pixels."""
    return _seen(ask(name))


def _calls() -> list[str]:
    return sorted(name for name in table() if name not in QUIET)


def ask(name: str) -> Any:
    """Return the answer to one call of the table, and what it raised as text."""
    call = table()[name]
    return call.function(**call.arguments)


def threads(rng: np.random.Generator) -> Found:
    """Let eight threads ask the same few questions in any order: each answer is that of one thread alone."""
    names = [str(name) for name in rng.choice(_calls(), 6, replace=False)]
    alone = {name: see(name) for name in names}
    order = [str(name) for name in rng.permutation(names * 4)]
    with ThreadPoolExecutor(8) as pool:
        answers = [_seen(answer) for answer in list(pool.map(ask, order))]
    wrong = sorted({name for name, found in zip(order, answers, strict=True) if not _alike(alone[name], found)})
    return Found(len(order), [f"in eight threads {name} answers something else" for name in wrong])


def forks(rng: np.random.Generator) -> Found:
    """Ask in a fork, and now and then in a fresh process: the answer comes back, and is the same."""
    names = [str(name) for name in rng.choice(_calls(), 3, replace=False)]
    fresh = rng.random() < 0.1
    failures = []
    for name in names:
        done, found = _spawned(name) if fresh else apart.answer(functools.partial(see, name))
        if not done:
            failures.append(f"{name} in a fork: {found}")
        elif not _alike(see(name), found):
            failures.append(f"{name} in another process answers something else")
    return Found(len(names), failures)


def forks_beside(rng: np.random.Generator) -> Found:
    """Fork while four threads ask a question again and again: the child, which has none of them, answers it, too.

    Each asks once before, so that what is imported on first use is there: a child waits for ever for what another
    thread was importing, which Python itself does not mend.
    """
    name = "Rod.stability" if rng.random() < 0.5 else str(rng.choice(_calls()))
    ask(name)
    stop = threading.Event()
    others = [threading.Thread(target=_asking, args=(name, stop), daemon=True) for _ in range(4)]
    for other in others:
        other.start()
    time.sleep(float(rng.uniform(0.0, 0.1)))
    process, reader = apart.start(functools.partial(_asked, name))
    late = not apart.ended(process, ANSWERED)
    if late:
        os.kill(process, signal.SIGKILL)
    stop.set()
    for other in others:
        other.join()
    done, found = apart.finish(process, reader)
    if late:
        return Found(1, [f"{name} in a fork beside threads that ask it does not answer within {ANSWERED:g} s"])
    return Found(1, [] if done else [f"{name} in a fork beside threads that ask it: {found}"])


def _asking(name: str, stop: threading.Event) -> None:
    """Ask a question until told to stop."""
    while not stop.is_set():
        ask(name)


def _asked(name: str) -> None:
    """Ask a question and leave the answer where it is: there is no reader yet, and a pipe holds little."""
    ask(name)


def _spawned(name: str) -> tuple[bool, Any]:
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        task = pool.submit(see, name)
        return (False, task.exception()) if task.exception() else (True, task.result())


def _alike(one: Any, other: Any) -> bool:
    """Return whether two answers are the same."""
    if type(one) is not type(other):
        return False
    try:
        return runs.same(one, other)
    except (ValueError, TypeError):
        return False


def _seen(answer: Any) -> Any:
    """Return an answer; of a figure, its axes or an array of axes the pixels, and close the figure.

    To be called in one thread, since matplotlib draws in one only, and once, since a second layout may move axes.
    """
    first = answer.flat[0] if isinstance(answer, np.ndarray) and answer.dtype == object and answer.size else answer
    figure = first.get_figure(root=True) if isinstance(first, Axes) else first
    if not isinstance(figure, Figure):
        return answer
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    pyplot.close(figure)
    return np.array(canvas.buffer_rgba())


LONG: dict[str, Callable[[], Any]] = {
    "stability_map": lambda: fr.stability_map(
        ROD, mean=(0.0, 1.7, 4000), amplitude=0.34, frequency=(20.0, 200.0, 4000), growth=True
    ),
    "friction.fates": lambda: fr.friction.fates(1.0, 0.3, 1.0, np.linspace(0.5, 3.0, 2_000_000)),
    "mathieu.chart": lambda: fr.mathieu.chart((0.0, 5.0, 4000), (-4.0, 1.0, 4000), growth=True),
    "critical_kick": lambda: ROD.critical_kick(
        mean=np.linspace(0.1, 1.6, 300), amplitude=np.linspace(0.1, 1.2, 300)[:, None], frequency=150.0, friction=0.1
    ),
    "chart": lambda: fr.chart(oscillators, {"omega": (0.5, 5.0, 2000), "epsilon": (0.0, 0.5, 2000)}),
    "systems.is_stable": lambda: fr.systems.is_stable(
        fr.HillSystem(np.eye(8), [0.1 * np.ones((8, 8))], period=np.linspace(1.0, 9.0, 200_000))
    ),
    "coupled loads": lambda: CLAMPED.is_stable(
        mean=np.linspace(0.1, 0.2, 3_000_000) * CLAMPED.critical_force, amplitude=100.0, frequency=20.0
    ),
    "compare": lambda: [fr.compare(fr.Mathieu(0.5, -0.25 - 1e-6 * k)) for k in range(10_000)],
    "stability": lambda: [ROD.stability(LOAD) for _ in range(10_000)],
    "simulate": lambda: _whole(fr.simulate(ROD, LOAD, duration=1000.0, segments=100)),
}
"""Calls that take long, each of which Ctrl-C has to end."""


def _whole(run: fr.Simulation) -> None:
    """Say like the others that Ctrl-C ended a simulation, which returns what it has."""
    if not run.complete:
        raise KeyboardInterrupt


def interrupts(rng: np.random.Generator) -> Found:
    """Send Ctrl-C to a long call, as often as a person would.

    Python itself loses one that arrives in a callback of its garbage collector: tools of tests have such callbacks.
    """
    name = str(rng.choice(sorted(LONG)))
    begun, begins = os.pipe()
    process, reader = apart.start(functools.partial(_hearing, LONG[name], begins))
    os.close(begins)
    os.read(begun, 1)  # before, Ctrl-C would end the fork of the process that asks
    os.close(begun)
    time.sleep(float(rng.uniform(0.3, 0.8)))
    os.kill(process, signal.SIGINT)
    late = True
    for _ in range(math.ceil(PROMPT / _AGAIN)):
        if apart.ended(process, min(PROMPT, _AGAIN)):
            late = False
            break
        os.kill(process, signal.SIGINT)
    if late:
        os.kill(process, signal.SIGKILL)
    done, found = apart.finish(process, reader)
    if late:
        return Found(1, [f"{name} does not hear Ctrl-C within {PROMPT:g} s"])
    if done or not str(found).startswith("KeyboardInterrupt"):
        return Found(1, [f"{name} answers Ctrl-C with {found!r:.300}"])
    return Found(1, [])


def _hearing(call: Callable[[], Any], begins: int) -> Any:
    """Say through a pipe that the call begins, and call, hearing Ctrl-C even in the background, as is inherited."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    os.write(begins, b".")
    return call()


@functools.cache
def values() -> dict[str, Any]:
    """Return one of every kind of problem and result."""
    mpl.use("Agg")
    kick = fr.FrictionalMathieu(1.0, 0.3, 1.0)
    return {
        "Rod": ROD,
        "AxialLoad": LOAD,
        "Perturbation": fr.Perturbation.case("C"),
        "FiniteTimeCriterion": fr.FiniteTimeCriterion(),
        "Mathieu": fr.Mathieu(0.5, -0.25),
        "Meissner": fr.Meissner(0.5, -0.25),
        "Hill": fr.Hill(-0.25, (0.1,), (0.2,)),
        "FrictionalMathieu": kick,
        "HillSystem": SYSTEM,
        "PeriodicSystem": FIRST_ORDER,
        "SystemStability": fr.stability(SYSTEM),
        "Proof of a system": fr.certify(SYSTEM),
        "Comparison of a system": fr.compare(SYSTEM),
        "chart of systems": fr.chart(oscillators, {"omega": (2.5, 3.5, 4), "epsilon": (0.1, 0.3, 3)}, growth=True),
        "FirstOrderTongue": fr.systems.first_order_tongues(SYSTEM)[0],
        "Stability": fr.stability(fr.Mathieu(0.5, -0.25)),
        "Proof": fr.certify(fr.Mathieu(0.5, -0.25)),
        "Comparison": fr.compare(fr.Mathieu(0.5, -0.25)),
        "RodStability": ROD.stability(LOAD),
        "FrictionalRodStability": ROD.stability(LOAD, friction=0.1, kick=0.05),
        "StabilityIntervals": ROD.ranges("mean", amplitude=0.34, frequency=150.0, growth_tolerance=0.1),
        "InstabilityProbability": fr.probability_of_instability(ROD, LOAD, {"mean": (0.3, 0.4)}, samples=100, seed=1),
        "Margin": ROD.stability(LOAD, growth_tolerance=0.1).mean_force_margin,
        "Chart": fr.mathieu.chart((0.0, 1.0, 5), (-1.0, 0.0, 4), growth=True),
        "map": fr.stability_map(ROD, mean=(0.0, 1.7, 4), amplitude=0.3, frequency=(20.0, 200.0, 5), growth=True),
        "TransitionCurves": fr.mathieu.transition_curves([0.1, 0.2], 3),
        "Simulation": simulation(),
        "GrowthFit": simulation().growth_rate(3),
        "Fate": fr.friction.fate(kick, 1.5),
        "EscapeRanges": fr.friction.escape_ranges(kick, samples=20),
        "Trajectory": fr.friction.trajectory(kick, 1.5),
    }


def _results(rng: np.random.Generator) -> Found:
    """Pickle one value, compare it with its copy and with another, and ask whether it is true."""
    name = str(rng.choice(sorted(values())))
    return Found(1, [f"{name}: {line}" for line in handled(values()[name])])


VERDICTS = (
    *(
        "Stability",
        "SystemStability",
        "Proof",
        "Comparison",
        "RodStability",
        "FrictionalRodStability",
        "StabilityIntervals",
        "InstabilityProbability",
    ),
    *("Fate", "EscapeRanges", "Chart", "Simulation"),
)
"""Classes of results whose truth would be taken for a verdict."""


def handled(value: Any) -> list[str]:
    """Return what is wrong about how a value is pickled, compared and taken for true."""
    wrong = []
    copy = pickle.loads(pickle.dumps(value))
    if not runs.same(value, copy):
        wrong.append("pickled and back it is another")
    try:
        if not isinstance(value == copy, bool) or value != copy:
            wrong.append("is not equal to its copy")
        if value == "something else":
            wrong.append("is equal to a string")
    except Exception as error:
        wrong.append(f"== raises {told(error)}")
    if type(value).__name__ in VERDICTS:
        try:
            wrong.append(f"bool() gives {bool(value)}")
        except TypeError as error:
            if not any(f".{name}" in str(error) for name in dir(value)):
                wrong.append(f"bool() raises without a remedy: {error}")
    return wrong
