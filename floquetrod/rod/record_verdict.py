"""The verdict on a measured force, and the error that its noise makes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, cast

import numpy as np

from floquetrod._util.progress import Progress, shifted
from floquetrod.floquet.status import STATUS_CODES
from floquetrod.rod.answers.evidence import NoisyCoupledEvidence, NoisyEvidence
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import Load, Loads, LoadSource, Second, noise_in_words
from floquetrod.rod.loads.record_period import IN_A_FINE_BAND
from floquetrod.rod.modes.mode_model import ModeModel
from floquetrod.units import AnswerUnits

NOISE_DRAWS = 20
"""Forces drawn (a choice)."""

_EVEN = 3.0  # largest and mean density of noise, and mean and least, are less than this apart if it is even (a choice)
_MEANS = 65  # mean forces tried between both ends of a record that drifts (a choice)

NOISE_OF_SENSOR = (
    "noise taken as an error of the sensor; if the force itself is random: --noise spectrum (Python: record.noisy_load)"
)
"""What a verdict on the fit of a record, without noise on the rod, takes the noise for."""

_LONGER = "a longer record has smaller errors"

_NOISE_BESIDE_SECOND = (
    "noise taken as an error of the sensor; what a random force does beside a second sine is not known"
)

_NAMES = {code: name for name, code in STATUS_CODES.items()}


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
    square of the change in growth adds to the error.  The verdict is undecided where one of them has another verdict or
    where the growth is within this error of the tolerance, of which under noise only that towards another verdict
    counts.  So it is where a line of the record, a sine that the fit does not hold, changes the verdict, or where that
    is not known; where a mean force between those at both ends of a record with a trend does; where noise that is no
    sensor's, taken as a random force, does; and where the densities of a measured noise over few frequencies, larger by
    their errors, do.  ``progress`` is called with the numbers of verdicts and of forces decided and to decide.
    """
    trials = 0

    def fit_progress(done: int, total: int) -> None:
        nonlocal trials
        trials = done
        if progress is not None:
            progress(done, total + NOISE_DRAWS)

    fit = record.load
    verdict = replace(
        model.verdict(fit, modes, growth_tolerance, fit_progress), left_out=record._left_out_in_words(fit)
    )
    if verdict.status == "undecided":
        return verdict
    code, chosen = STATUS_CODES[verdict.status], None if modes is None else verdict.modes
    draw_progress = shifted(progress, trials, trials)
    _, fit_growth = _status_and_growth(model, fit, chosen, growth_tolerance)
    if math.isnan(fit_growth):
        fit_growth = verdict.growth_rate
    changes, others, fastest = [], 0, 0.0
    for done, load in enumerate(record._within_errors(NOISE_DRAWS), start=1):
        status, growth = _status_and_growth(model, load, chosen, growth_tolerance)
        if status != code:
            others, fastest = others + 1, max(fastest, growth)
        changes.append(growth - fit_growth)
        if draw_progress is not None:
            draw_progress(done, NOISE_DRAWS)
    noise = math.sqrt(float(np.mean(np.square(changes))))
    note = f"noise in the record makes the growth rate uncertain by {noise:.2g} 1/s"
    if noise == verdict.growth_rate == 0.0:
        note = "" if others else f"noise in the record: no mode grows at {NOISE_DRAWS} forces within its errors either"
    doubts = []
    if others:
        counted = f"the fit is {verdict.status}, but {others} of {NOISE_DRAWS} forces within its errors are not"
        if verdict.status == "stable" and fastest > growth_tolerance:
            counted = f"{counted}, under which the rod grows at up to {fastest:.2g} 1/s"
        remedies = [_LONGER, _one_density(fit)] if fit.noise else [_LONGER]
        by_mean = _by_mean(model, record, chosen, growth_tolerance, code)
        note = "; ".join(filter(None, [note, counted, by_mean, *remedies]))
        doubts.append("forces within the errors of the fit have another verdict")
    elif 0.0 < abs(fit_growth - growth_tolerance) <= noise + _error_towards_another(verdict):
        doubts.append("the noise in the record makes the growth rate too uncertain")
    if not fit.noise:
        note = f"{note}; {NOISE_OF_SENSOR if fit.second is None else _NOISE_BESIDE_SECOND}"
    trials_of_others = [
        *(_with_line(model, record, line, chosen, growth_tolerance) for line in record.lines),
        *_with_means(model, record, chosen, growth_tolerance, code),
        *_with_residual(model, record, chosen, growth_tolerance),
        *_with_fine_noise(model, record, chosen, growth_tolerance),
    ]
    changing = [trial for trial in trials_of_others if trial.status != code]
    doubts += [trial.doubt for trial in changing]
    off = max((abs(trial.growth - fit_growth) for trial in trials_of_others if trial.adds), default=0.0)
    said = (trial.note for trial in trials_of_others if trial.adds or trial in changing)
    return replace(
        verdict,
        status="undecided" if doubts else verdict.status,
        undecided_by=doubts[0] if doubts else "",
        left_out=verdict.left_out or "what leaves the verdict undecided" * bool(doubts),
        error=verdict.error + noise + off,
        note="; ".join(filter(None, [verdict.note, note, *said])),
    )


def _error_towards_another(verdict: RodStability) -> float:
    """Return the error in 1/s of the growth under noise towards another verdict, 0 without noise.

    Less growth changes an unstable verdict, more of it a stable one.
    """
    match verdict.evidence:
        case NoisyEvidence(growth_errors=(less, more)):
            return less if verdict.status == "unstable" else more
        case NoisyCoupledEvidence():
            return verdict.error
        case _:
            return 0.0


def _by_mean(model: ModeModel, record: LoadSource, modes: Sequence[int] | None, tolerance: float, code: int) -> str:
    """Return that the error of the mean force alone changes the verdict, "" where it does not."""
    load, off = record.load, 2.0 * record._mean_error
    ends = [replace(load, mean=load.mean + way * off) for way in (-1.0, 1.0)]
    if not off or all(_status_and_growth(model, end, modes, tolerance)[0] == code for end in ends):
        return ""
    force = AnswerUnits.named(given=load.given_units).force
    known = f"{force.of(load.mean):.4g} +- {force.show(record._mean_error, 2)}"
    typed = force.show(load.mean, 4).replace(" ", "")
    return f"the error of the mean force alone, {known}, leaves that open; a mean that is known decides: --mean {typed}"


class _Trial(NamedTuple):
    """A verdict on a force that the record may mean as well: status, growth, and both in words.

    ``doubt`` says what changes the verdict; the growth counts as an error of the verdict where it ``adds``.
    """

    status: int
    growth: float
    note: str
    doubt: str
    adds: bool


def _with_line(
    model: ModeModel, record: LoadSource, line: Second, modes: Sequence[int] | None, tolerance: float
) -> _Trial:
    """Return the verdict with a line of a record as the second sine.

    The status is undecided and the growth infinite where no verdict is known: beside noise or another second sine, with
    coupled modes, in a bend or along a wave.
    """
    sine = record._line_in_words(line)
    doubt = f"the sine {sine} that the record holds beside the fit may change the verdict"
    unknown = STATUS_CODES["undecided"], math.inf
    if record.load.noise:
        alone = f"--second {sine} without --noise"
        if record.load.waveform == "sine":  # no harmonic was fitted
            alone = f"--force-frequency {line[1] / (2.0 * math.pi):.6g}Hz without --amplitude and --noise"
        note = f"the sine {sine} beside the fit may change the verdict: what it does beside noise is not known; ask "
        return _Trial(*unknown, f"{note}about it alone: {alone}", doubt, True)
    try:
        if record.load.second is not None:
            raise ValueError("a load has one second sine at most")
        load, rod = replace(record.load, second=line), cast("Any", model.rod)
        verdict = rod._modes_under(load).verdict(load, modes, tolerance)
    except ValueError:
        note = f"the sine {sine} beside the fit may change the verdict: what it does to this rod and load is not known"
        return _Trial(*unknown, note, doubt, True)
    said = f"with the sine {sine} that the record holds beside the fit: {_in_words(verdict)}"
    note = f"{said}; --second {sine.partition('@')[2]} (Python: second= of the record) tells more"
    return _Trial(STATUS_CODES[verdict.status], verdict.growth_rate, note, said, True)


def _with_means(
    model: ModeModel, record: LoadSource, modes: Sequence[int] | None, tolerance: float, code: int
) -> Iterator[_Trial]:
    """Yield the verdict with a mean force between those at the ends of a record that drifts, where one is another.

    A tongue between two of the means tried is passed over.
    """
    if not record._means:
        return
    begin, end = record._means
    means, load = np.linspace(begin, end, _MEANS), record.load
    if modes is None:
        loads = Loads((_MEANS,), means, np.full(_MEANS, load.amplitude), np.full(_MEANS, load.frequency))
        statuses, growths, _ = model.under(load).answers(loads, tolerance)
    else:
        each = [_status_and_growth(model, replace(load, mean=float(mean)), modes, tolerance) for mean in means]
        statuses, growths = map(np.array, zip(*each, strict=True))
    others = np.flatnonzero(statuses != code)
    if not others.size:
        return
    first, last = means[others[[0, -1]]].tolist()
    force = AnswerUnits.named(given=load.given_units).force
    low, high = sorted((first, last))
    where = force.show(low, 4) if low == high else f"{force.of(low):.4g} to {force.show(high, 4)}"
    names = " or ".join(dict.fromkeys(_NAMES[int(statuses[k])] for k in others))
    drift = f"{force.of(begin):.4g} to {force.show(end, 4)}"
    said = f"the mean force of the record drifts from {drift}, and with means of {where} the rod is {names}"
    yield _Trial(int(statuses[others[0]]), float(np.nanmax(growths)), said, said, False)


def _with_residual(
    model: ModeModel, record: LoadSource, modes: Sequence[int] | None, tolerance: float
) -> Iterator[_Trial]:
    """Yield the verdict with the residual of the fit as a random force, where it is too uneven for a sensor's noise.

    Beside a second sine, where noise is not known, that of the random force and the first sine alone, unless stable.
    """
    if not record._is_uneven or record.lines:
        return
    without = "" if record.load.second is None else ", without the second sine,"
    noisy, rod = record._with_residual(), cast("Any", model.rod)
    try:
        under = rod._modes_under(noisy.load)
        verdict = under.verdict(noisy.load, modes, tolerance)
        if verdict.status == "stable":  # as the errors of its densities leave it
            verdict = record_verdict(under, noisy, modes, tolerance, None)
    except ValueError:  # not known along a wave, say
        return
    if without and verdict.status == "stable":  # which says nothing about both sines
        return
    said = f"with what the fit leaves as a random force{without} the rod is in mean square {_in_words(verdict)}"
    if verdict.status == "undecided":
        said = "what the fit leaves may, as a random force, make the rod unstable in mean square"
    note = f"{said}; its spectrum is too uneven for the noise of a sensor"
    yield _Trial(STATUS_CODES[verdict.status], verdict.growth_rate, note, said, False)


def _with_fine_noise(
    model: ModeModel, record: LoadSource, modes: Sequence[int] | None, tolerance: float
) -> Iterator[_Trial]:
    """Yield the verdict with densities averaged over few frequencies alone, plus their errors, where the rod grows.

    A narrow band too weak to be told from chance, in which noise is taken as even, counts here.
    """
    load = record._with_fine_noise()
    growth = 0.0 if load is None else _status_and_growth(model, load, modes, tolerance)[1]
    if growth > tolerance:
        said = f"with densities over {IN_A_FINE_BAND} frequencies, and their errors, the rod may grow in mean square"
        note = f"{said}, at {growth:.2g} 1/s: the excess there may be chance; {_LONGER}"
        yield _Trial(STATUS_CODES["unstable"], growth, note, said, False)


def _in_words(verdict: RodStability) -> str:
    """Return status and growth."""
    rate = f", {verdict.growth_rate:.3g} 1/s" if verdict.growth_rate > 0.0 else ""
    return f"{verdict.status}{rate}"


def _one_density(load: Load) -> str:
    """Return how to give noise of a spectrum that is even by its mean density, "" for an uneven or a single one.

    A mean of all bands has a smaller error than each.
    """
    if not isinstance(load.noise, tuple):
        return ""
    hertz, densities = np.array(load.noise).T
    area = 0.5 * (densities[1:] + densities[:-1]) @ np.diff(hertz)
    mean = float(area) / float(hertz[-1] - hertz[0]) if hertz.size > 1 else math.nan
    if not (densities.max() < _EVEN * mean < _EVEN**2 * densities.min()):
        return ""
    unit = AnswerUnits.named(given=load.given_units).force.name
    text = noise_in_words(mean, unit).removeprefix("noise of ").replace(" ", "")
    return (
        "where the random force is known to have one density at all frequencies, give that: "
        f'--noise {text} (Python: noise="{text}" of the load)'
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
