"""The one table of what is asked: how a question is drawn, how its answer is read, and how many are kept.

The i-th question of a kind depends on its kind and on i alone, so that a kind may get more and keep what it has.
"""

from __future__ import annotations

import contextlib
import io
import json
import shlex
import shutil
import tempfile
import warnings
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import floquetrod as fr
from floquetrod.rod.model.data import wavenumber

from . import answers
from . import questions as q

ROOT = Path(__file__).parents[2]

NOT_KEPT = {
    "version",
    "note",
    "statement",
    "assumptions",
    "method",
    "cost",
    "seconds",
    "wall_time_s",
    "boxes",
    "modes_checked",
}
"""Names in the JSON of the terminal whose values are no answers: texts, work done, choices of a method."""


def terminal(command: str) -> Any:
    """Return exit status and JSON of a command, but for `NOT_KEPT`; run in a folder of its own beside the examples."""
    from floquetrod.cli import main

    out, err = io.StringIO(), io.StringIO()
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "floquetrod/examples", Path(folder) / "examples")
        with contextlib.chdir(folder), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = main(shlex.split(command))
    return {"exit": status, "json": _kept(json.loads(out.getvalue() or "null"))}


def _kept(found: Any) -> Any:
    if isinstance(found, list):
        return [_kept(part) for part in found]
    if not isinstance(found, dict):
        return found
    left_out = [n for n in found if n in NOT_KEPT or "error" in n or "bound" in n or "seconds" in n]
    return {name: _kept(part) for name, part in found.items() if name not in left_out}


class Kind(NamedTuple):
    """A kind of question.

    Attributes
    ----------
    draw : callable (rng, i) -> str
        Draws the i-th question.
    read : callable (result) -> JSON
        What is kept of the result.
    count : int
    relative, floor : float
        Floats that state no error may differ by ``relative`` times their size, or times ``floor`` where that is more.
    reason : str
        Why that much.
    cheap : bool
        Whether one takes milliseconds, so that `make test` asks some again.
    """

    draw: Callable[[np.random.Generator, int], str]
    read: Callable[[Any], Any]
    count: int
    relative: float = 1e-12
    floor: float = 0.0
    reason: str = "rounding alone: no float without a stated error, or a formula"
    cheap: bool = False

    def question(self, name: str, i: int) -> str:
        """Return the i-th question of this kind, whose name seeds the drawing."""
        return str(self.draw(np.random.default_rng([zlib.crc32(name.encode()), i]), i))

    def ask(self, question: str) -> Any:
        """Return the answer of today as JSON."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                result = eval(question, {"fr": fr, "np": np, "terminal": terminal, "wavenumber": wavenumber})
                return self.read(result)
            except (ValueError, TypeError, ArithmeticError) as error:
                return f"refused: {type(error).__name__}"


EDGE = "edges are found to 1e-10 of themselves or of the interval searched, and tongues' edges by bisection"
DEEP = "no stated error: eight digits, which a change of method keeps and a wrong formula does not"
STATED = "relative accuracy 1e-8 where the undamped rate exceeds 1e-9, says its docstring"
UNITS = "some units of rounding of max(1, abs(a), abs(q)), says the docstring; the floor is the largest q"

KINDS: dict[str, Kind] = {
    "equation": Kind(lambda rng, i: q.call("fr.stability", q.equation(rng, i)), answers.equation, 1200, cheap=True),
    "method of an equation": Kind(q.by_method, answers.equation, 240, cheap=True),
    "comparison": Kind(lambda rng, i: q.call("fr.compare", q.equation(rng, i)), answers.comparison, 24),
    "arrays: stable": Kind(q.arrays("is_stable"), answers.statuses, 20, cheap=True),
    "arrays: growth": Kind(q.arrays("growth_rate"), answers.plain, 20, 2e-8, 1e-9, STATED, cheap=True),
    "arrays: multipliers": Kind(
        q.arrays("discriminant", "multipliers", "exponents"), answers.plain, 30, 1e-8, 1.0, DEEP
    ),
    "transition curves": Kind(q.curves, answers.plain, 24, 1e-12, 1.0, UNITS, cheap=True),
    "system": Kind(lambda rng, i: q.call("fr.stability", q.system(rng, i)), answers.system, 520),
    "method of a system": Kind(q.system_by_method, answers.system, 120),
    "systems: stable": Kind(lambda rng, i: q.call("fr.systems.is_stable", q.system(rng, i, 12)), answers.statuses, 30),
    "systems: growth": Kind(
        lambda rng, i: q.call("fr.systems.growth_rate", q.system(rng, i, 12)), answers.plain, 30, 1e-8, 1e-2, DEEP
    ),
    "systems: multipliers": Kind(
        lambda rng, i: f"np.abs({q.call('fr.systems.multipliers', q.system(rng, i, 6))})",
        answers.plain,
        18,
        1e-8,
        1.0,
        DEEP,
    ),
    "proof": Kind(lambda rng, i: q.call("fr.certify", q.equation(rng, i)), answers.proof, 120),
    "proof of a system": Kind(lambda rng, i: q.call("fr.certify", q.system(rng, i)), answers.proof, 30),
    "proof of a box": Kind(q.proved_box, answers.fields("status"), 40),
    "safe box": Kind(q.safe_box, answers.safe_box, 8),
    "rod": Kind(q.of_rod("stability"), answers.rod, 640, cheap=True),
    "rod: required damping": Kind(q.of_rod("stability", ".damping_to_stabilise"), answers.plain, 60, 1e-8, 1e-6, DEEP),
    "rod: margin of the mean": Kind(q.of_rod("stability", ".margin('mean')"), answers.margin, 40, 1e-8, 1e-3, EDGE),
    "rod: margin of the amplitude": Kind(
        q.of_rod("stability", ".margin('amplitude')"), answers.margin, 30, 1e-8, 1e-3, EDGE
    ),
    "rod: margin of the frequency": Kind(
        q.of_rod("stability", ".margin('frequency')"), answers.margin, 30, 1e-8, 1e-3, EDGE
    ),
    "rod: over loads": Kind(q.over_loads("verdicts", "is_stable"), answers.statuses, 30, cheap=True),
    "rod: growth over loads": Kind(
        q.over_loads("growth_rate", "growth_rate return_mode"), answers.plain, 30, 1e-7, 1e-6, STATED
    ),
    "coupled rod": Kind(q.of_coupled("stability"), answers.rod, 240),
    "coupled rod: required damping": Kind(
        q.of_coupled("stability", ".damping_to_stabilise"), answers.plain, 20, 1e-8, 1e-6, "found to ten digits"
    ),
    "coupled rod: margin": Kind(
        q.of_coupled("stability", ".margin('mean', seconds=0.2)", 2), answers.margin, 10, 1e-8, 1e-3, EDGE
    ),
    "coupled rod: over loads": Kind(q.over_loads("verdicts", waves=True), answers.statuses, 8),
    "coupled rod: growth over loads": Kind(q.over_loads("growth_rate", waves=True), answers.plain, 8, 1e-7, 1e-3, DEEP),
    "ranges": Kind(q.along, answers.ranges, 60, 1e-8, 0.0, EDGE),
    "ranges of coupled modes": Kind(lambda rng, i: q.along(rng, i, True), answers.ranges, 3, 1e-7, 0.0, EDGE),
    "critical load": Kind(q.critical, answers.plain, 40, 1e-8, 0.0, EDGE),
    "kicked rod": Kind(q.kick, answers.kicked, 160),
    "critical kick of a rod": Kind(q.critical_kick, answers.plain, 24, 1e-8, 0.0, "an edge accurate to 1e-9"),
    "fates": Kind(q.frictional("fates"), answers.fates, 60, cheap=True),
    "fate": Kind(q.frictional("fate"), answers.fields("status", "reversals"), 150, cheap=True),
    "critical kick": Kind(q.frictional("critical_kick"), answers.plain, 80, 4e-9, 0.0, "an edge accurate to 1e-9"),
    "certain kicks": Kind(q.frictional("certain_kicks"), answers.plain, 80, 1e-9, 0.0, DEEP, cheap=True),
    "escape ranges": Kind(
        q.frictional("escape_ranges"),
        answers.fields("intervals", "bounded_up_to", "escapes_above", "undecided"),
        12,
        4e-10,
        0.0,
        "bisected to 1e-10",
    ),
    "trajectory": Kind(
        q.frictional("trajectory"), answers.fields("tau", "A", "velocity", "state"), 40, 1e-8, 1.0, DEEP
    ),
    "map": Kind(q.mapped, answers.chart, 12, 1e-7, 1e-6, STATED),
    "chart": Kind(q.charted, answers.chart, 8, 1e-7, 1e-3, DEEP),
    "bands": Kind(q.banded, answers.bands, 4, 1e-4, 0.0, "the fastest growth is found to some 1e-5, among points"),
    "probability": Kind(q.likely, answers.fields("probability", "interval", "unstable", "undecided"), 8, 1e-12),
    "section": Kind(q.of_section, answers.plain, 120, 1e-12, 0.0, "formulas: rounding alone", cheap=True),
    "notation": Kind(q.converted, answers.plain, 40, 1e-15, 1.0, "two roundings", cheap=True),
    "characteristic values": Kind(q.of_order(0.01, 10.0), answers.plain, 60, 2e-14, 10.0, UNITS, cheap=True),
    "characteristic values far out": Kind(q.of_order(10.0, 1e4), answers.plain, 30, 2e-14, 1e4, UNITS, cheap=True),
    "widths of tongues": Kind(
        q.tongue_widths, answers.plain, 20, 1e-11, 0.0, "accurate relative to itself; eleven digits"
    ),
    "Floquet solution": Kind(q.floquet, answers.plain, 60, 1e-10, 1.0, "no stated error; values are of order one"),
    "delayed system": Kind(lambda rng, i: q.call("fr.stability", q.delayed(rng, i)), answers.growth, 60),
    "proof of a delayed system": Kind(lambda rng, i: q.call("fr.certify", q.delayed(rng, i)), answers.proof, 20),
    "second moments": Kind(lambda rng, i: q.call("fr.stability", q.noisy(rng, i)), answers.growth, 40),
    "critical noise": Kind(q.critical_noise, answers.plain, 12, 1e-9, 0.0, "between two verdicts, mostly to 1e-11"),
    "filtered noise": Kind(q.filtered, answers.plain, 8, 1e-7, 1e-2, "orders are raised until 1e-8 apart"),
    "noisy rod": Kind(q.noisy_rod, answers.noisy_rod, 40),
    "milling": Kind(q.milled, answers.plain, 8, 1e-6, 0.0, "depths are bisected, of a multiplier to some digits"),
    "well": Kind(q.of_well, answers.plain, 40, 1e-11, 1e3, "formulas; metres of a well of some km", cheap=True),
    "rod in a bend": Kind(q.in_bend, answers.bent_rod, 40),
    "reach": Kind(q.reached, answers.fields("reach", "injector", "bit"), 8, 1e-6, 1.0, "integrals along the well"),
    "periodic orbit": Kind(q.orbit, answers.orbit, 30),
    "solution": Kind(q.solved, answers.solution, 60),
    "first-order tongues": Kind(
        lambda rng, i: q.call("fr.systems.first_order_tongues", q.system(rng, 6 * i, n=2 + i % 2)),
        answers.tongues,
        20,
        1e-9,
        1e-3,
        DEEP,
    ),
    "record": Kind(
        lambda rng, i: q.measured(rng, q.numbers(rng, q.rod(rng)), 0.02), answers.record, 12, 1e-9, 0.0, "least squares"
    ),
    "simulation": Kind(q.simulated, answers.simulation, 6, 1e-8, 1.0, DEEP),
    "terminal": Kind(q.commanded, answers.plain, len(q.COMMANDS), 1e-7, 1e-3, DEEP),
}
