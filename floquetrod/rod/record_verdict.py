"""The verdict on a measured force, and the error that its noise makes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np

from floquetrod._util.progress import Progress, shifted
from floquetrod.floquet.status import STATUS_CODES
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import Load, Loads, LoadSource, Second
from floquetrod.rod.modes.mode_model import ModeModel

NOISE_DRAWS = 20
"""Forces drawn (a choice)."""

NOISE_OF_SENSOR = (
    "noise taken as an error of the sensor; if the force itself is random: --noise spectrum (Python: record.noisy_load)"
)
"""What a verdict on the fit of a record, without noise on the rod, takes the noise for."""


def record_verdict(
    model: ModeModel,
    record: LoadSource,
    modes: Iterable[int] | None,
    growth_tolerance: float,
    progress: Progress | None,
) -> RodStability:
    """Return the verdict on the fit of a record, with the error that the noise of the record makes.

    Twenty forces are drawn, the same ones in every call, whose mean, frequency and harmonics, their sizes and phases,
    depart from the fit's by two standard errors; numbers that replace the record's are the same in all.  The root mean
    square of the change in growth adds to the error; where one of them has another verdict, it is undecided.  So it is
    where a line of the record, a sine that the fit does not hold, changes the verdict, or where that is not known.
    ``progress`` is called with the numbers of verdicts and of forces decided and to decide.
    """
    trials = 0

    def fit_progress(done: int, total: int) -> None:
        nonlocal trials
        trials = done
        if progress is not None:
            progress(done, total + NOISE_DRAWS)

    verdict = model.verdict(record.load, modes, growth_tolerance, fit_progress)
    if verdict.status == "undecided":
        return verdict
    chosen, draw_progress = None if modes is None else verdict.modes, shifted(progress, trials, trials)
    _, fit_growth = _status_and_growth(model, record.load, chosen, growth_tolerance)
    if math.isnan(fit_growth):
        fit_growth = verdict.growth_rate
    changes, others = [], 0
    for done, load in enumerate(record._within_errors(NOISE_DRAWS), start=1):
        status, growth = _status_and_growth(model, load, chosen, growth_tolerance)
        others += status != STATUS_CODES[verdict.status]
        changes.append(growth - fit_growth)
        if draw_progress is not None:
            draw_progress(done, NOISE_DRAWS)
    noise = math.sqrt(float(np.mean(np.square(changes))))
    note = f"noise in the record makes the growth rate uncertain by {noise:.2g} 1/s"
    if noise == verdict.growth_rate == 0.0:
        note = f"noise in the record: no mode grows at {NOISE_DRAWS} forces within its errors either"
    if others:
        note = f"{note}; the fit is {verdict.status}, but {others} of {NOISE_DRAWS} forces within its errors are not"
    if not record.load.noise:
        note = f"{note}; {NOISE_OF_SENSOR}"
    lines = [_with_line(model, record, line, chosen, growth_tolerance) for line in record.lines]
    agree = all(status == STATUS_CODES[verdict.status] for status, _, _ in lines)
    off = max((abs(growth - fit_growth) for _, growth, _ in lines), default=0.0)
    return replace(
        verdict,
        status="undecided" if others or not agree else verdict.status,
        error=verdict.error + noise + off,
        note="; ".join(filter(None, [verdict.note, note, *(said for _, _, said in lines)])),
    )


def _with_line(
    model: ModeModel, record: LoadSource, line: Second, modes: Sequence[int] | None, tolerance: float
) -> tuple[int, float, str]:
    """Return the code of the status with a line of a record as the second sine, the growth, and both in words.

    The status is undecided and the growth infinite where no verdict is known: beside noise or another second sine, with
    coupled modes, in a bend or along a wave.
    """
    sine = record._line_in_words(line)
    try:
        if record.load.second is not None:
            raise ValueError("a load has one second sine at most")
        load, rod = replace(record.load, second=line), cast("Any", model.rod)
        verdict = rod._modes_under(load).verdict(load, modes, tolerance)
    except ValueError:
        note = f"the sine {sine} beside the fit may change the verdict: what it does to this rod and load is not known"
        return STATUS_CODES["undecided"], math.inf, note
    growth = verdict.growth_rate
    rate = f", {growth:.3g} 1/s" if growth > 0.0 else ""
    said = f"with the sine {sine} that the record holds beside the fit: {verdict.status}{rate}"
    return STATUS_CODES[verdict.status], growth, f"{said}; --second {sine} (Python: second=) tells more"


def _status_and_growth(
    model: ModeModel, load: Load, modes: Sequence[int] | None, tolerance: float
) -> tuple[int, float]:
    """Return the code of the status under a load and the growth in 1/s, NaN where unknown."""
    if modes is not None:
        verdict = model.under(load).verdict(load, modes, tolerance)
        return STATUS_CODES[verdict.status], verdict.growth_rate
    status, growth, _ = (column.item() for column in model.under(load).answers(Loads.single(load), tolerance))
    return int(status), float(growth)
