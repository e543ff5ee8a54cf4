"""What the noise of a measured force leaves open of a verdict."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TypeVar

import numpy as np

from floquetrod.rod.coupled import CoupledLoads
from floquetrod.rod.load import AxialLoad, Loads
from floquetrod.rod.modal import ModalRod
from floquetrod.rod.record import ForceRecord
from floquetrod.rod.verdict import RodVerdict

_ERRORS = 2.0  # standard errors by which each number of the fit is varied (a choice: some 95 of 100 lie within)

AnyVerdict = TypeVar("AnyVerdict", bound=RodVerdict)


def with_noise(rod: ModalRod, verdict: AnyVerdict, record: ForceRecord) -> AnyVerdict:
    """Return a verdict on the fit of a record with the error that its noise makes.

    Mean, frequency and each harmonic, its size and its phase, are varied by two standard errors, one at a time.  The
    root of the sum of the squares of the changes in growth adds to the error; where one of them alone changes the
    verdict, it is undecided.
    """
    if verdict.status == "undecided":
        return verdict
    squares, sure = 0.0, True
    for pair in _varied(record):
        changes = []
        for load in pair:
            one = CoupledLoads(rod.coupled_numbers, load, Loads.single(load), verdict.growth_tolerance)
            status, growth = (column[0] for column in one.answers())
            sure &= bool(status == (verdict.status == "stable"))
            changes.append(abs(float(growth) - verdict.growth_rate))
        squares += max(changes) ** 2
    noise = math.sqrt(squares)
    note = f"within two standard errors of the record growth varies by {noise:.2g} 1/s"
    if not sure:
        note = f"{note}, and the verdict with it: by its fit alone the rod is {verdict.status}"
    return replace(
        verdict,
        status=verdict.status if sure else "undecided",
        error=verdict.error + noise,
        note="; ".join(filter(None, [verdict.note, note])),
    )


def _varied(record: ForceRecord) -> Iterator[tuple[AxialLoad, AxialLoad]]:
    """Yield the fitted load with one number of the fit lower and higher by its error."""
    fit, amplitude = record.load, record.amplitude
    for name, error in (("mean", record.mean_error), ("frequency", record.frequency_error)):
        here, change = getattr(fit, name), _ERRORS * error
        yield fit.varied(name, here - change), fit.varied(name, here + change)  # type: ignore[arg-type]
    for number in record.kept:
        harmonic, change = record.harmonics[number - 1], _ERRORS * record.harmonic_errors[number - 1]
        for direction in (1.0, 1j):
            pair = []
            for step in (-change, change):
                waveform = np.array(record.waveform)
                waveform[number - 1] = (harmonic + step * direction * harmonic / abs(harmonic)) / amplitude
                pair.append(replace(fit, waveform=tuple(waveform.tolist())))
            yield pair[0], pair[1]
