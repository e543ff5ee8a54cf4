"""The verdict on a measured force, and the error that its noise makes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from floquetrod._util.progress import Progress, shifted
from floquetrod.floquet.status import STATUS_CODES
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import Load, Loads, LoadSource
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
    square of the change in growth adds to the error; where one of them has another verdict, it is undecided.
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
    return replace(
        verdict,
        status="undecided" if others else verdict.status,
        error=verdict.error + noise,
        note="; ".join(filter(None, [verdict.note, note])),
    )


def _status_and_growth(
    model: ModeModel, load: Load, modes: Sequence[int] | None, tolerance: float
) -> tuple[int, float]:
    """Return the code of the status under a load and the growth in 1/s, NaN where unknown."""
    if modes is not None:
        verdict = model.under(load).verdict(load, modes, tolerance)
        return STATUS_CODES[verdict.status], verdict.growth_rate
    status, growth, _ = (column.item() for column in model.under(load).answers(Loads.single(load), tolerance))
    return int(status), float(growth)
