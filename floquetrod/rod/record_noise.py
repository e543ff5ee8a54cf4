"""What the noise of a measured force leaves open of a verdict."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from floquetrod._util.progress import Progress, shifted
from floquetrod.floquet.status import STATUS_CODES
from floquetrod.rod.answers.verdict import RodStability
from floquetrod.rod.loads.load import LIMITS, AxialLoad, Loads
from floquetrod.rod.loads.record import ForceRecord
from floquetrod.rod.modes.mode_model import ModeModel

NOISE_DRAWS = 20
"""Forces drawn (a choice)."""

_ERRORS = 2.0  # standard errors by which they depart from the fit, and which enter the error of growth: 95 %


def with_noise(
    model: ModeModel,
    verdict: RodStability,
    record: ForceRecord,
    modes: Sequence[int] | None = None,
    progress: Progress | None = None,
) -> RodStability:
    """Return a verdict on the fit of a record, of some modes or all, with the error that its noise makes.

    Twenty forces are drawn, the same ones in every call, whose mean, frequency and harmonics, their sizes and phases,
    depart from those of the fit by two standard errors.  The root mean square of the change in growth adds to the
    error; where one of them has another verdict, it is undecided.  ``progress`` is called with the numbers of forces
    decided and to decide.
    """
    if verdict.status == "undecided":
        return verdict
    _, fitted = _answer(model, record.load, modes, verdict.growth_tolerance)
    if math.isnan(fitted):
        fitted = verdict.growth_rate
    changes, others = [], 0
    for done, load in enumerate(_drawn(record), start=1):
        status, growth = _answer(model, load, modes, verdict.growth_tolerance)
        others += status != STATUS_CODES[verdict.status]
        changes.append(growth - fitted)
        if progress is not None:
            progress(done, NOISE_DRAWS)
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


def classify_record(
    model: ModeModel,
    record: ForceRecord,
    modes: Iterable[int] | None,
    growth_tolerance: float,
    progress: Progress | None,
) -> RodStability:
    """Return the verdict on a record: that on its fit, with what its noise leaves open."""
    trials = 0

    def of_the_fit(done: int, total: int) -> None:
        nonlocal trials
        trials = done
        if progress is not None:
            progress(done, total + NOISE_DRAWS)

    fitted = model.verdict(record.load, modes, growth_tolerance, of_the_fit)
    chosen = None if modes is None else fitted.modes
    return with_noise(model, fitted, record, chosen, shifted(progress, trials, trials))


def _answer(model: ModeModel, load: AxialLoad, modes: Sequence[int] | None, tolerance: float) -> tuple[int, float]:
    """Return the code of the status under a load and the growth in 1/s, NaN where unknown."""
    of_load = model.under(load)
    if modes is not None:
        verdict = of_load.verdict(load, modes, tolerance)
        return STATUS_CODES[verdict.status], verdict.growth_rate
    status, growth, _ = (column.item() for column in of_load.answers(Loads.single(load), tolerance))
    return int(status), float(growth)


def _drawn(record: ForceRecord) -> Iterator[AxialLoad]:
    """Yield loads whose numbers are drawn about those of the fit, with twice their standard errors."""
    random, fit, kept = np.random.default_rng(0), record.load, np.array(record.harmonic_numbers) - 1
    slowest = LIMITS["frequency"].least
    for _ in range(NOISE_DRAWS):
        shift = random.standard_normal((kept.size, 2)) @ np.array([1.0, 1j])
        harmonics = record.harmonics.copy()
        harmonics[kept] += _ERRORS * record.harmonic_errors[kept] * shift
        spread = _ERRORS * record.mean_error, _ERRORS * record.frequency_error
        mean, omega = random.normal((fit.mean, fit.frequency), spread).tolist()
        waveform = tuple((harmonics[: len(record.waveform)] / record.amplitude).tolist())
        yield replace(fit, mean=mean, frequency=max(omega, slowest), waveform=waveform)
