"""What Newton's method starts from: one period of about the orbit, from a point, a record of motion, or an orbit."""

from __future__ import annotations

import math
import warnings
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod.equations import NonlinearSystem
from floquetrod.orbits.return_time import CLOSE, require_no_rotation, returned, sizes

_SAMPLES = 200  # of a period (a choice)
_MOST_SAMPLES = 10_000
_SEEN = 1e-2  # of the motion, that every other sample may miss (a choice)
_RTOL = 1e-8
_STIFF = 1e-12  # relative error of motion that jumps
_MORE_PERIODS = 3
_DIRECTLY = 0.2  # gap after a period, part of the motion, up to which a start is taken to be near an orbit (a choice)
_MOST_PERIODS = 300  # that motion is given to settle (a choice)
_PERIODS_SEARCHED = 60  # of motion, for the best return after one of them (a choice)
_MOST_CHUNKS = 18  # each twice as long as the one before, in which motion without a period may return
_MOST_SLOW_CHUNKS = 40  # where it has not turned back yet
_FEW_TURNS = 8  # of motion that has hardly turned back (a choice)
_GROWN = 1e3  # of a motion since its beginning: where it cannot be followed any more, it flows away (a choice)
_SLOWEST = 1e6  # times as long as at the speed of the start, in which a rotation must be complete (a choice)
_INVARIANT = 1e-9  # of the rates, up to which they do not depend on a shift
_LARGEST = 1e100  # of a state, beyond which a motion has flown away


class Guess(NamedTuple):
    """About one period of an orbit: times (k,) from 0 to the period, states (k, n), and their rates (k, n)."""

    times: Floats
    states: Floats
    rates: Floats
    jumps: bool = False  # whether the samples do not resolve it
    by_steps: bool = False  # whether the times are the steps of an integrator, short where motion jumps

    @property
    def period(self) -> float:
        """Its length."""
        return float(self.times[-1])

    @property
    def gap(self) -> float:
        """By how much it does not close, as a fraction of the motion."""
        return _gap(self.states)

    def at(self, shares: Floats, growth: Floats | None = None) -> Floats:
        """Return states (k, n) at shares of the period, closed by a drift that takes out the gap.

        Closed means that the last state is the first, or differs from it by the growth (n,) of a motion that rotates.
        """
        times = shares * self.period
        place = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, len(self.times) - 2)
        steps = np.diff(self.times)[place][:, None]
        s = (times - self.times[place])[:, None] / steps
        states = (
            (1.0 + 2.0 * s) * (1.0 - s) ** 2 * self.states[place]
            + s * (1.0 - s) ** 2 * steps * self.rates[place]
            + s**2 * (3.0 - 2.0 * s) * self.states[place + 1]
            + s**2 * (s - 1.0) * steps * self.rates[place + 1]
        )
        gap = self.states[-1] - self.states[0]
        return np.asarray(states - shares[:, None] * (gap if growth is None else gap - growth))


def guessed(system: NonlinearSystem, start: Any, period: float | None) -> Guess:
    """Return about one period of an orbit from a state (n,) or a record (times, states), and its period if known."""
    if isinstance(start, tuple) and len(start) == 2 and validate.dimensions("start", start[1]) == 2:
        return _from_record(system, *_record(*start), period)
    state = validate.array("start", start, least=-_LARGEST, largest=_LARGEST)
    if state.ndim != 1 or not state.size:
        raise ValueError(
            f"start must be a state, one number for each of the equations, or a record (times, states), got shape "
            f"{state.shape}"
        )
    system.evaluated.start(0.0, state, system.parameters)
    if system.is_autonomous:
        _require_moving(system, state)
    guess = _autonomous(system, state) if period is None else _settled(system, state, period)
    return _resolved(system, guess)


def require_invariant(system: NonlinearSystem, state: Floats, growth: Floats) -> None:
    """Raise ValueError where the rates at a state change with the growth of states in a period."""
    here = system.rates([0.0, 0.0], np.stack([state, state + growth]))
    change = float(np.abs(here[1] - here[0]).max())
    if not change <= _INVARIANT * max(float(np.abs(here).max()), 1e-300):
        raise ValueError(
            f"winding must leave the rates as they are: from start they change by {change:.3g} with that shift of the "
            "states"
        )


def rotating(system: NonlinearSystem, state: Floats, period: float | None, growth: Floats) -> Guess:
    """Return about one period of a motion that rotates, after it has settled: its states grow by ``growth``."""
    chief = int(np.argmax(np.abs(growth)))
    if period is not None:
        for turn in range(_MOST_PERIODS):
            motion = _marched(system, state, period, f"in period {turn + 1}, each of {period:.6g},")
            gap = np.abs(motion.states[-1] - motion.states[0] - growth) / sizes(motion.states)
            if float(gap.max()) <= 0.1 * CLOSE:
                break
            state = motion.states[-1]
        return motion
    amount, sign = abs(float(growth[chief])), math.copysign(1.0, growth[chief])
    turn_time = amount / max(float(np.abs(system.rates([0.0], state[None])[0, chief])), 1e-300)
    span, has_turned = 4.0 * turn_time, False
    for turn in range(_MOST_PERIODS):
        motion = _marched(system, state, span, f"in period {turn + 1}", samples=4 * _SAMPLES)
        grown = sign * (motion.states[:, chief] - motion.states[0, chief])
        ahead = np.flatnonzero(grown >= amount)
        if not ahead.size:
            span *= 2.0
            if span > _SLOWEST * turn_time:
                break
            continue
        i = int(ahead[0])
        share = (amount - grown[i - 1]) / (grown[i] - grown[i - 1])
        length = float(motion.times[i - 1] + share * (motion.times[i] - motion.times[i - 1]))
        motion = _marched(system, state, length, "")
        after = motion.states[-1] - growth
        if has_turned and float((np.abs(after - motion.states[0]) / sizes(motion.states)).max()) <= 0.1 * CLOSE:
            return motion
        has_turned, state, span = True, after, 1.5 * length
    raise ValueError(
        f"start leads to motion that does not rotate by {growth[chief]:.6g} of state {chief} again and again; give a "
        "closer start"
    )


def _resolved(system: NonlinearSystem, guess: Guess) -> Guess:
    """Return a guess with as many samples as it takes to see its jumps."""
    samples = len(guess.times) - 1
    every_other = Guess(guess.times[::2], guess.states[::2], guess.rates[::2])
    closed = guess.states - (guess.times / guess.period)[:, None] * (guess.states[-1] - guess.states[0])
    missed = np.abs(every_other.at(guess.times / guess.period) - closed) / sizes(guess.states)
    if float(missed.max()) < _SEEN:
        return guess
    if samples > _MOST_SAMPLES:
        return guess._replace(jumps=True)
    return _resolved(system, _marched(system, guess.states[0], guess.period, "", 4 * samples))


def jumping(system: NonlinearSystem, guess: Guess) -> Guess | None:
    """Return a guess of motion that jumps, by many digits and at an integrator's steps; None where it does not return.

    A jump must be known to a part of its width, which may be a millionth of the period.
    """
    from scipy.integrate import solve_ivp

    def rates(t: float, x: Floats) -> Floats:
        return np.asarray(system.function(t, x, **system.parameters), dtype=float)

    size = sizes(guess.states)
    start, span = guess.states[0], guess.period
    if system.period is not None:  # after some more periods it has settled to as many digits
        start = solve_ivp(rates, (0.0, _MORE_PERIODS * span), start, "LSODA", rtol=_STIFF, atol=_STIFF * size).y[:, -1]
    normal = rates(0.0, start) / size**2

    def ahead(t: float, x: Floats) -> float:
        return float((x - start) @ normal)

    end = 1.05 * span if system.is_autonomous else span
    motion = solve_ivp(rates, (0.0, end), start, "LSODA", rtol=_STIFF, atol=_STIFF * size, events=ahead)
    times, states = motion.t, motion.y.T
    if system.is_autonomous:
        back = np.flatnonzero(np.abs(motion.t_events[0] - span) < 0.05 * span)
        if not back.size:
            return None
        last = back[np.abs(motion.t_events[0][back] - span).argmin()]
        period, state = motion.t_events[0][last], motion.y_events[0][last]
        before = times < period * (1.0 - 1e-14)
        times, states = np.append(times[before], period), np.concatenate([states[before], state[None]])
    guess = Guess(times, states, system.rates(times, states), by_steps=True)
    return guess if len(times) > 2 and guess.gap < CLOSE else None


def _record(times: Any, states: Any) -> tuple[Floats, Floats]:
    """Return a record of motion, checked."""
    instants = validate.array("start[0]", times, least=-1e15, largest=1e15)
    motion = validate.array("start[1]", states, least=-_LARGEST, largest=_LARGEST)
    if instants.ndim != 1 or len(instants) != len(motion) or len(instants) < 8:
        raise ValueError(
            f"start must be a record (times, states) of 8 instants or more, times (k,) and states (k, n), got shapes "
            f"{instants.shape} and {motion.shape}"
        )
    if not (np.diff(instants) > 0.0).all():
        raise ValueError("start must have times that increase")
    return instants, motion


def _from_record(system: NonlinearSystem, times: Floats, states: Floats, period: float | None) -> Guess:
    """Return the last period of a record."""
    system.evaluated.start(float(times[0]), states[0], system.parameters)
    rates = system.rates(times, states)
    if period is None:
        return_time = returned(times, states, rates)
        if return_time is None:
            raise ValueError("start must be a record of two periods or more, got one that does not return; give period")
        period = return_time
    if times[-1] - times[0] < period * (1.0 - 1e-9):
        raise ValueError(f"start must cover a period of {period:.6g}, got a record of {times[-1] - times[0]:.6g}")
    begin = times[-1] - period
    if system.period is not None:  # from a time at which the forcing begins again
        begin = math.floor(begin / period + 1e-9) * period
        begin = begin if begin >= times[0] - 1e-9 * period else begin + period
    whole = Guess(times - times[0], states, rates)
    wanted = np.linspace(0.0, 1.0, 2 * _SAMPLES + 1) * period + begin - times[0]
    inside = np.minimum(wanted, whole.period)
    drift = states[-1] - states[0]
    found_states = whole.at(inside / whole.period) + (inside / whole.period)[:, None] * drift
    shifted = wanted - wanted[0]
    return Guess(shifted, found_states, system.rates(shifted, found_states))


def _settled(system: NonlinearSystem, state: Floats, period: float) -> Guess:
    """Return the motion over one period from a state, or after as many periods as it takes to settle."""
    if system.is_autonomous:
        return _near_return(system, state, period)
    best: Guess | None = None
    strobed = [state]
    for turn in range(_MOST_PERIODS):
        motion = _marched(system, state, period, f"in period {turn + 1}, each of {period:.6g},")
        best = motion if best is None or motion.gap < best.gap else best
        if motion.gap <= (CLOSE if turn else _DIRECTLY):
            return motion
        state = motion.states[-1]
        strobed.append(state)
        if turn > 50 and (turns := _returns_after(np.array(strobed[-13:]), motion)):
            raise ValueError(
                f"start leads to motion that returns after {turns} periods, not after one; give period = "
                f"{turns} * {period:.6g}, or follow the orbit of one period by fr.follow from where it is stable"
            )
    return best if best is not None else motion


def _near_return(system: NonlinearSystem, state: Floats, period: float) -> Guess:
    """Return the motion over about one period from a state, or where motion from it returns best after about one."""
    march = _marched(system, state, period, f"within a period of {period:.6g}")
    if march.gap <= _DIRECTLY:
        return march
    motion = _marched(system, march.states[-1], _PERIODS_SEARCHED * period, "", _PERIODS_SEARCHED * _SAMPLES // 2)
    _require_no_rotation(system, motion, slice(len(motion.times) // 3, None))
    size, lag = sizes(motion.states), _SAMPLES // 2
    lags = range(3 * lag // 4, 5 * lag // 4 + 1)
    gaps = [(np.abs(motion.states[each:] - motion.states[:-each]) / size).max(axis=1) for each in lags]
    best = min(range(len(lags)), key=lambda k: float(gaps[k].min()))
    begin = motion.states[int(gaps[best].argmin())]
    return _marched(system, begin, lags[best] * float(motion.times[1]), "")


def _returns_after(strobed: Floats, motion: Guess) -> int:
    """Return after how many periods, two to six, motion returns; 0 where it does not."""
    size = np.maximum(np.ptp(motion.states, axis=0), 1e-300)
    for turns in range(2, 7):
        if float((np.abs(strobed[-1] - strobed[-1 - turns]) / size).max()) < 1e-4:
            return turns
    return 0


def _autonomous(system: NonlinearSystem, state: Floats) -> Guess:
    """Return about one period of the motion that a state leads to, whose period is estimated."""
    matrix = system.jacobians([0.0], state[None])[0]
    fastest = float(np.abs(np.linalg.eigvals(matrix)).max())
    size, speed = float(np.linalg.norm(state)), float(np.linalg.norm(system.rates([0.0], state[None])[0]))
    rate = max(fastest, speed / size) if size > 0.0 else fastest or speed  # at 0 a speed says nothing of the size
    span = 20.0 / max(rate, 1e-300)
    for count in range(_MOST_SLOW_CHUNKS):
        motion = _marched(system, state, span, f"within {span:.4g}", samples=4000)
        last = slice(len(motion.times) // 3, None)
        if _rests(motion):
            raise ValueError(
                f"start leads to a state of rest at {_in_words(motion.states[-1])}, not to a periodic orbit: give a "
                "start farther from it, or parameters with which it is unstable"
            )
        period = returned(motion.times[last], motion.states[last], motion.rates[last])
        if period is not None:
            return _marched(system, motion.states[-1], period, "")
        _require_no_rotation(system, motion, last)
        if count >= _MOST_CHUNKS - 1 and not _is_slow(motion):
            break
        state, span = motion.states[-1], 2.0 * span
    raise ValueError("start leads to motion that does not return near where it was; give period and a closer start")


def _require_moving(system: NonlinearSystem, state: Floats) -> None:
    """Raise ValueError where an autonomous system stays at a state; its equations for an orbit are singular there."""
    instants = [0.0, 1.0]  # at both, of a function that should not depend on time and may
    if not system.rates(instants, np.stack([state, state])).any():
        raise ValueError(
            f"start is a state of rest, {_in_words(state)}, where nothing moves: give a start away from it, such as "
            f"{_in_words(state + 0.1 * max(1.0, float(np.abs(state).max())) * (np.arange(state.size) == 0))}"
        )


def _in_words(state: Floats) -> str:
    """Return a state in parentheses, the first six numbers of a long one."""
    return f"({', '.join(f'{value:.6g}' for value in state[:6])}{', ...' if state.size > 6 else ''})"


def _require_no_rotation(system: NonlinearSystem, motion: Guess, last: slice) -> None:
    """Raise ValueError where the last samples of motion return except for coordinates that grow."""

    def march(state: Floats, span: float) -> Floats:
        return _marched(system, state, span, "").states

    require_no_rotation(system, motion.times[last], motion.states[last], motion.rates[last], march)


def _is_slow(motion: Guess) -> bool:
    """Return whether motion has hardly turned back yet, as between the jumps of a relaxation oscillation."""
    middle = 0.5 * (motion.states.min(axis=0) + motion.states.max(axis=0))
    signs = motion.states > middle
    return bool((signs[1:] != signs[:-1]).sum(axis=0).max() <= _FEW_TURNS)


def _rests(motion: Guess) -> bool:
    """Return whether motion has come to rest: it moves far less at the end than it did, and than its size."""
    moves, size = np.ptp(motion.states[-400:], axis=0).max(), np.abs(motion.states).max()
    return bool(moves <= 1e-7 * size) or bool(size == 0.0)


def _marched(system: NonlinearSystem, state: Floats, span: float, when: str, samples: int = _SAMPLES) -> Guess:
    """Return the motion from a state at time 0, by LSODA; ValueError where it flows away."""
    # x' = f(t, x) with variable order and step: LSODA (L. Petzold, SIAM Journal on Scientific and Statistical Computing
    # 4 (1983) 136, doi:10.1137/0904010), relative error `_RTOL`, absolute error that part of the size of the motion.  A
    # guess need not be accurate: Newton's method corrects it.  The size is that of the start, or, from rest at 0, that
    # of the way which the first velocity goes in the span.  states (samples + 1, n); where the march ends early,
    # ``reached`` is the last time asked for, and the rows after it are not set.
    from scipy.integrate import odeint

    call, given = system.function, dict(system.parameters)
    times = np.linspace(0.0, span, samples + 1)
    reached = 0.0
    largest = float(np.abs(state).max())
    moved = span * float(np.abs(system.rates([0.0], state[None])).max())  # from rest at 0 the size is not known yet
    size = max(1e-3 * max(largest, 1e-3 * moved if math.isfinite(moved) else 0.0), 1e-9)

    def rates(t: float, x: Floats) -> Floats:
        nonlocal reached
        reached = reached if math.isnan(t) else t
        return np.asarray(call(t, x, **given), dtype=float)

    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that it did not arrive, which the message says too
        states, said = odeint(
            rates,
            state,
            times,
            tfirst=True,
            rtol=_RTOL,
            atol=_RTOL * size,
            full_output=True,
            mxstep=50_000,
            printmessg=False,
        )
    arrived = said["message"] == "Integration successful."
    if not arrived:  # the rows after the one it failed in are not set
        states = states[: np.searchsorted(times, reached, side="right") + 1]
        if np.abs(states).max() <= _GROWN * np.abs(states[: len(states) // 10 + 1]).max():
            raise ValueError(
                f"start leads to motion that cannot be followed over a period of {span:.4g}: does the function jump, "
                "or change too fast?"
            )
    if not (arrived and (np.abs(states) <= _LARGEST).all()):
        raise ValueError(
            f"start diverges: {when + ' ' if when else ''}the motion grows without bounds, or is not finite"
        )
    return Guess(times, states, system.rates(times, states))


def _gap(states: Floats) -> float:
    """Return by how much motion does not close, as a fraction of how far it goes."""
    return float((np.abs(states[-1] - states[0]) / sizes(states)).max())
