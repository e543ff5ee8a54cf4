"""What a run found: its growth, and what theory says of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from floquetrod._util.interchange import by_keys
from floquetrod._util.result_report import Printed, Report
from floquetrod._util.suggest import listed
from floquetrod.rod.answers.reports import answer_units, load_lines, shown_in
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.friction.kicks import CriticalKick
from floquetrod.rod.loads.load import AxialLoad, with_waves
from floquetrod.rod.model.rod_in_words import special_parameters
from floquetrod.simulation.growth import GrowthFit
from floquetrod.simulation.outcome import BUCKLED_ANGLE, DEFINITION
from floquetrod.units import Unit

STABLE_LOAD = (
    "by theory nothing grows under this load: what moves the rod is its kick, or a large motion that the linear "
    "equations do not know; simulate longer, or kick less"
)
"""What is said of a rod that has buckled under a load that is stable without friction."""


_STABLE_LOAD_NOW = (
    "by theory nothing grows under this load: the rod goes on with the motion that another run left it with, or with a "
    "large motion that the linear equations do not know; simulate longer"
)


class _Growing(NamedTuple):
    """What a rod that has not buckled yet is on its way to."""

    rate: float
    words: str
    until: float  # s: when it will have buckled, growing on as it does


@dataclass(frozen=True, repr=False)
class Findings(Printed):
    """A run, its growth, and the comparison with theory.

    Attributes
    ----------
    run : Simulation
    growth : GrowthFit or None
    not_fitted : str
        Why there is no growth.
    linear : Verdict or None
        That on the load, without friction.
    predicted : float or None
        Growth in 1/s of the dominant mode, or of all modes where they are coupled.
    with_wave : float or None
        The same with inertia along the rod kept, where the load neglects it and the fastest mode is dominant.
    needed : CriticalKick or None
        With friction.
    no_theory : str
        Why something of this is missing.
    """

    run: Any
    growth: GrowthFit | None
    not_fitted: str
    linear: RodStability | None = None
    predicted: float | None = None
    with_wave: float | None = None
    needed: CriticalKick | None = None
    no_theory: str = "not requested"

    @classmethod
    def of(cls, run: Any, *, theory: bool) -> Findings:
        """Return the growth of a run and, if requested, of theory."""
        bare = cls(run, *_growth(run))
        if not theory:
            return bare
        problem, rod = run.problem, run.rod
        if problem.feed_speed is not None or problem.far_force is not None:
            return replace(bare, no_theory="none: theory needs the force of the load at both ends")
        if problem.tool is not None:
            return replace(bare, no_theory="none: theory knows no tool inside the rod")
        try:
            linear = rod.stability(problem.load)
        except ValueError as error:
            return replace(bare, no_theory=f"none: {error}")
        if isinstance(problem.friction, tuple):
            return replace(bare, linear=linear, no_theory="no critical kick: theory has one coefficient of friction")
        if problem.friction > 0.0:
            try:
                needed = rod.critical_kick(problem.load, friction=problem.friction)
            except ValueError as error:
                return replace(bare, linear=linear, no_theory=f"no critical kick: {error}")
            return replace(bare, linear=linear, needed=needed, no_theory="")
        mode = run.named_mode
        predicted = linear.growth_rate if mode is None else linear.growth_of(mode)
        wave = _with_wave(run) if linear.is_fastest(mode) else None
        return replace(bare, linear=linear, predicted=predicted, with_wave=wave, no_theory="")

    @property
    def _growing(self) -> _Growing | None:
        """How a rod that has not buckled grows, as fitted or, where that shows nothing, by theory; None without."""
        run, fit, linear = self.run, self.growth, self.linear
        if run.outcome.kind != "quiet" or run.problem.wall_friction.largest > 0.0:
            return None
        if fit is not None and fit.rate > fit.error:
            rate, words = fit.rate, f"mode {run.dominant_mode} at {fit.rate:.4g} 1/s"
        elif linear is not None and linear.status == "unstable" and linear.growth_rate > 0.0:
            mode = linear.fastest_mode
            rate, words = (
                linear.growth_rate,
                f"{f'mode {mode}, ' * (mode is not None)}by theory at {linear.growth_rate:.4g} 1/s",
            )
        else:
            return None
        last = run.time.size - 1 - int(run.largest_angle[::-1][: max(1, run.time.size // 4)].argmax())
        angle = float(run.largest_angle[last])
        until = float(run.time[last]) + math.log(BUCKLED_ANGLE / angle) / rate if angle > 0.0 else math.inf
        return _Growing(rate, words, max(until, float(run.time[-1])))

    def report(self, units: Mapping[str, str] | None = None) -> Report:
        """Return the findings in lines: the outcome, the load, growth, theory, energy, cost.

        ``units`` in which to show mean, amplitude, frequency and kick: ``{"mean": "Fcr", "kick": "mm/s"}``.
        """
        run = self.run
        problem, steps, rod = run.problem, run.time_steps, run.rod
        shown = shown_in(units, rod, problem.load)
        special = special_parameters(rod, answer_units(shown))
        lines = [("rod", special)] if special else []
        lines += load_lines(problem.load, shown, rod)
        lines += [("", text) for text in _ends(run, shown)]
        off, work = float(abs(run.energy_error).max()), float(abs(run.energy["work"]).max())
        lines += [
            ("start", f"{problem.start_words}; friction {problem.wall_friction}"),
            ("growth", self._growth_text()),
            ("theory", self._theory(shown["kick"])),
            ("energy", f"kinetic + potential + dissipated - work off by {off:.1g} J, of {work:.3g} J of work"),
            ("step", f"{1e6 * steps.size:.3g} us, set by {_BOUNDS[steps.limit]}"),
            (
                "cost",
                f"{run.seconds:.3g} s of wall time for {_simulated(run):.4g} s of {problem.segments} segments",
            ),
        ]
        if run.outcome.kind != "quiet":
            lines.append(("buckled", f"means {DEFINITION}"))
        lines += [("note", text) for text in (run.outcome.doubt, self._against_theory, run.note) if text]
        return Report(self._outcome, lines)

    @property
    def _outcome(self) -> str:
        run, growing = self.run, self._growing
        angle = f"largest angle {math.degrees(float(run.largest_angle.max())):.3g} degrees"
        if growing is not None:
            soon = f", 5 degrees at about {growing.until:.3g} s" if math.isfinite(growing.until) else ""
            status = f"GROWING, not yet buckled after {run.time[-1]:.4g} s: {growing.words}{soon}; {angle}"
        else:
            leads = "" if run.named_mode is None else f"mode {run.named_mode} leads, "
            words = run.outcome.words.replace("not buckled", "NOT BUCKLED")
            status = f"BUCKLED: {leads}{angle}" if run.buckled else f"{words}: {angle}"
        if run.complete:
            return status
        return f"INTERRUPTED at {_simulated(run):.4g} s of {run.problem.duration:g} s; so far {status}"

    @property
    def _against_theory(self) -> str:
        """Why a rod that has buckled should not have, by theory; "" without a reason."""
        if not (self.run.buckled and self.linear is not None and self.linear.status == "stable"):
            return ""
        return STABLE_LOAD if self.run.problem.start is None else _STABLE_LOAD_NOW

    def _growth_text(self) -> str:
        fit, run = self.growth, self.run
        if fit is None:
            return f"not fitted: {self.not_fitted}"
        text = f"{fit.rate:.5g} +- {fit.error:.1g} 1/s in mode {run.dominant_mode} up to {fit.end:.3g} s"
        if self.predicted is None:
            return text
        if self.with_wave is None:
            return f"{text}; predicted {self.predicted:.5g} 1/s{_off(fit.rate, self.predicted)}"
        return (
            f"{text}; predicted {self.with_wave:.5g} 1/s{_off(fit.rate, self.with_wave)} with inertia along the rod, "
            f"{self.predicted:.5g} 1/s without"
        )

    def _theory(self, speed: Unit) -> str:
        linear, needed = self.linear, self.needed
        if linear is None:
            return self.no_theory
        modes = linear.unstable_modes
        which = f"modes {listed(modes)} grow" if len(modes) > 1 else f"mode {modes[0]} grows" if modes else ""
        text = f"{linear.status}{which and ': '}{which}"
        if self.run.problem.wall_friction.largest == 0.0:
            return text
        text = f"without friction {text}"
        if needed is None:
            return f"{text}; {self.no_theory}"
        if not math.isfinite(needed.kick):
            return text
        kick = f"{speed.show(needed.kick, 3)} in mode {needed.mode} alone"
        return f"{text}; against friction the smallest kick found to buckle it is {kick}"

    def as_dict(self) -> dict[str, Any]:
        """Return everything as numbers for JSON, units in the keys; None for unknown values."""
        run, growing = self.run, self._growing
        return {
            "buckled": run.buckled,
            "outcome": run.outcome.kind,
            "angle_in_the_end_degrees": math.degrees(run.outcome.angle),
            "buckled_means": DEFINITION,
            "outcome_doubt": run.outcome.doubt or None,
            "against_theory": self._against_theory or None,
            "growing": run.buckled or growing is not None,
            **by_keys(growing, "buckles_at_about_s=until"),
            **by_keys(run, "dominant_mode=named_mode note"),
            "largest_angle_degrees": math.degrees(float(run.largest_angle.max())),
            **by_keys(
                self.growth,
                "growth_rate_per_s=rate growth_rate_error_per_s=error growth_rate_fit_error_per_s=fit_error "
                "growth_rate_model_error_per_s=model_error growth_fitted_until_s=end",
            ),
            "growth_not_fitted_because": self.not_fitted or None,
            **by_keys(self, "predicted_growth_rate_per_s=predicted predicted_with_axial_wave_per_s=with_wave"),
            **by_keys(
                self.linear,
                "predicted_status=status predicted_unstable_modes=unstable_modes predicted_fastest_mode=fastest_mode",
            ),
            **by_keys(self.needed, "critical_kick_m_per_s=kick critical_kick_mode=mode"),
            "no_theory_because": self.no_theory or None,
            "perturbation": str(run.problem.perturbation),
            **by_keys(run.problem.load, "mean_N amplitude_N frequency_rad_per_s"),
            "load": run.problem.load.kind_as_dict(),
            **by_keys(run.problem, "feed_speed_m_per_s far_force_N tool"),
            "largest_end_forces_N": run.end_forces.max(axis=0).tolist(),
            **by_keys(run, "mu=problem.friction complete"),
            "simulated_s": _simulated(run),
            "start_s": float(run.time[0]),
            **by_keys(run.problem, "duration_s segments"),
            "frames": int(run.time.size),
            **by_keys(run.time_steps, "time_step_s=size time_step_set_by=limit steps=count"),
            "energy_error_J": float(abs(run.energy_error).max()),
            "energy_work_J": float(abs(run.energy["work"]).max()),
            **by_keys(run, "wall_time_s=seconds"),
        }


def _simulated(run: Any) -> float:
    """Return the time simulated in s."""
    return float(run.time[-1] - run.time[0])


def _growth(run: Any) -> tuple[GrowthFit | None, str]:
    """Return the fitted growth, or why there is none."""
    if run.problem.wall_friction.largest > 0.0:
        return None, "with friction nothing grows exponentially"
    if run.named_mode is None:
        return None, "it has left the wall, and modes are those of a rod that lies against it"
    try:
        return run.growth_rate(), ""
    except ValueError as error:
        return None, str(error)


def _with_wave(run: Any) -> float | None:
    """Return the growth rate in 1/s with the axial wave that both ends send; None where the load is waves already."""
    load = run.problem.load
    if not isinstance(load, AxialLoad) or load.amplitude == 0.0:
        return None
    try:
        return float(run.rod.stability(with_waves(load, run.rod.damping_rate)).growth_rate)
    except ValueError:  # at a resonance of the wave
        return None


_BOUNDS = {
    "stretch": "stretch: waves along the rod must not pass a segment in one step",
    "bend": "bending: neighbouring nodes moving against each other are the fastest motion",
    "contact": "contact: the wall is stiffer than the rod",
    "choice": "the time step asked for",
}


def _ends(run: Any, shown: Mapping[str, Unit]) -> list[str]:
    """Return lines about ends moved at a speed, or pushed by another force than the load's."""
    problem, lines = run.problem, []
    if problem.feed_speed is not None:
        most = shown["mean"].show(float(run.end_forces[:, 0].max()))
        lines.append(f"upper end moved at {shown['kick'].show(problem.feed_speed)}, which took at most {most}")
    if problem.far_force is not None:
        lines.append(f"lower end pushed by {shown['mean'].show(problem.far_force)}")
    if (tool := problem.tool) is not None:
        sines = (f"{shown['mean'].show(size)} at {shown['frequency'].show(often)}" for size, often in tool.sines)
        lines.append(f"tool of {' and '.join(sines)}, {shown['length'].show(tool.above_end)} above the lower end")
    return lines


def _off(rate: float, predicted: float) -> str:
    return f" ({100.0 * (rate / predicted - 1.0):+.2f} %)" if predicted > 0.0 else ""
