"""The verdict on a measured force, and the error that its noise makes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from floquetrod._util.progress import Progress, shifted
from floquetrod.floquet.status import STATUS_CODES
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import LOAD, AxialLoad, Loads
from floquetrod.rod.loads.record import ForceRecord
from floquetrod.rod.modes.mode_model import ModeModel

NOISE_DRAWS = 20
"""Forces drawn (a choice)."""

_ERRORS = 2.0  # standard errors by which they depart from the fit, and which enter the error of growth: 95 %


def record_verdict(
    model: ModeModel,
    record: ForceRecord,
    modes: Iterable[int] | None,
    growth_tolerance: float,
    progress: Progress | None,
) -> RodStability:
    """Return the verdict on the fit of a record, with the error that the noise of the record makes.

    Twenty forces are drawn, the same ones in every call, whose mean, frequency and harmonics, their sizes and phases,
    depart from the fit's by two standard errors.  The root mean square of the change in growth adds to the
    error; where one of them has another verdict, it is undecided.  ``progress`` is called with the numbers of verdicts
    and of forces decided and to decide.
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
    for done, load in enumerate(_drawn(record), start=1):
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
    return replace(
        verdict,
        status="undecided" if others else verdict.status,
        error=verdict.error + noise,
        note="; ".join(filter(None, [verdict.note, note])),
    )


def _status_and_growth(
    model: ModeModel, load: AxialLoad, modes: Sequence[int] | None, tolerance: float
) -> tuple[int, float]:
    """Return the code of the status under a load and the growth in 1/s, NaN where unknown."""
    if modes is not None:
        verdict = model.under(load).verdict(load, modes, tolerance)
        return STATUS_CODES[verdict.status], verdict.growth_rate
    status, growth, _ = (column.item() for column in model.under(load).answers(Loads.single(load), tolerance))
    return int(status), float(growth)


def _drawn(record: ForceRecord) -> Iterator[AxialLoad]:
    """Yield loads whose numbers are drawn about the numbers of the fit, with twice their standard errors."""
    random, fit, kept = np.random.default_rng(0), record.load, np.array(record.harmonic_numbers) - 1
    slowest = LOAD["frequency"].least
    for _ in range(NOISE_DRAWS):
        shift = random.standard_normal((kept.size, 2)) @ np.array([1.0, 1j])
        harmonics = record.harmonics.copy()
        harmonics[kept] += _ERRORS * record.harmonic_errors[kept] * shift
        spread = _ERRORS * record.mean_error, _ERRORS * record.frequency_error
        mean, omega = random.normal((fit.mean, fit.frequency), spread).tolist()
        waveform = tuple((harmonics[: len(record.waveform)] / record.amplitude).tolist())
        yield replace(fit, mean=mean, frequency=max(omega, slowest), waveform=waveform)
