"""`fr.response`: the steady motion under a force beside the parametric one, by any method."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import shaped
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.result_report import Report, Reported, number
from floquetrod.equations import DelaySystem, PeriodicSystem
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.problems import Problem, require_problem
from floquetrod.floquet.references import references
from floquetrod.floquet.status import Status
from floquetrod.responses import methods
from floquetrod.responses.forces import Force, force_of
from floquetrod.responses.motions import Motion

_LATEST = 1e14  # periods
_LARGEST_ERROR = 1e-2  # relative, beyond which there is no answer (a choice)


@dataclass(frozen=True, eq=False, repr=False)
class Response(ByContent, NoTruthValue, Reported):
    """The steady motion x(t) = exp(i w t) u(t) under a force, u of the period of the coefficients.

    Of a force of the period itself, without a frequency w of its own, x is real and periodic.

    Attributes
    ----------
    equation : Equation, HillSystem, PeriodicSystem or DelaySystem
        The problem without the force.
    force : Force
        The force, as a mean and harmonics, as pieces or as amplitudes of its frequency.
    method : str
        "hill" or "monodromy".
    status : {"stable", "unstable", "undecided"}
        Verdict on the problem without the force.  Where it is unstable, free motion grows away from this one, which
        nobody then sees.
    distance : float
        Of exp(i w T), 1 without a frequency, from the nearest multiplier; NaN where multipliers are not known.
    error : float
        Estimate of the largest error of a coordinate over time, as a fraction of its largest value: of each by the
        method "hill", of the largest coordinate by "monodromy".
    note : str
        What to know before relying on it.
    """

    ask: ClassVar[str] = ".largest, .mean or .solution"

    equation: Problem
    force: Force
    method: str
    status: Status
    distance: float
    error: float
    note: str
    _motion: Motion = field(repr=False)

    @property
    def frequency(self) -> float | None:
        """The frequency w of the force, in radians per unit of time; None for a force of the period."""
        return self.force.frequency

    @property
    def period(self) -> float:
        """The period T of the coefficients."""
        return self._motion.period

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite, in plain text with DOI, floquetrod first, then the sources of the method."""
        return references(methods.sources(self.equation, self.method))

    def solution(self, time: Any, derivative: int = 0) -> Any:
        """Return the steady motion at times (array_like), or its first derivative.

        Real; complex with a frequency, where its real part is the motion under the real part of the force.  Of a scalar
        equation in the shape of ``time``, of a system with its n coordinates in a last axis.

        Parameters
        ----------
        time : array_like
            Any times, in the unit of the equation.
        derivative : int
            1 for the first derivative.

        Returns
        -------
        float, complex or ndarray
            In the shape of ``time``, of a system (..., n).

        Raises
        ------
        TypeError, ValueError
            For times other than finite numbers, and for a derivative other than 0 and 1.
        """
        limit = _LATEST * self.period
        times = validate.array("time", time, least=-limit, largest=limit)
        derivative = validate.integer("derivative", derivative, 0, 1)
        motion = self._motion.values(times.ravel(), derivative)
        values: Any = motion.real if self.frequency is None else motion
        if self._scalar:
            return shaped(values[:, 0], times.shape)
        return shaped(values, (*times.shape, self.force.order))

    @cached_property
    def harmonics(self) -> dict[int, Any]:
        """Complex amplitudes of exp(i (w + 2 pi k / T) t) by k, each a number, of a system (n,).

        For a force of amplitude one they are the harmonic transfer functions: the signal k = 0, the idlers k = -1, ...
        """
        amplitudes = self._motion.amplitudes
        middle = len(amplitudes) // 2
        rows = amplitudes[:, 0].tolist() if self._scalar else [row.copy() for row in amplitudes]
        return dict(zip(range(-middle, middle + 1), rows, strict=True))

    @cached_property
    def mean(self) -> Any:
        """Mean over time, a number, of a system (n,); complex, and mostly zero, with a frequency."""
        middle = len(self._motion.amplitudes) // 2
        if self.frequency is None:
            return self._of(self._motion.amplitudes[middle].real)
        turns = self.frequency * self.period / (2.0 * math.pi)
        k = round(-turns)
        steady = abs(turns + k) <= 1e-12 * max(1.0, abs(turns)) and abs(k) <= middle
        mean = self._motion.amplitudes[middle + k] if steady else np.zeros(self.force.order, dtype=complex)
        return self._of(mean.copy())

    @cached_property
    def largest(self) -> Any:
        """Largest magnitude over all times, a true extreme, a number, of a system (n,).

        With a frequency the largest modulus, which the real motion reaches, or comes as near to as is wanted.
        """
        return self._of(self._motion.largest())

    @cached_property
    def rms(self) -> Any:
        """Root mean square over time, a number, of a system (n,); of a complex motion from its modulus."""
        return self._of(np.sqrt(self._motion.mean_squares()))

    @property
    def letter(self) -> str:
        """Symbol of the coordinates in figures, A, q or x."""
        present = getattr(self.equation, "present", self.equation)
        return "A" if self._scalar else "x" if isinstance(present, PeriodicSystem) else "q"

    @property
    def _scalar(self) -> bool:
        return methods.is_scalar(self.equation)

    def _of(self, vector: Any) -> Any:
        return vector.item() if self._scalar else vector

    def plot(self, ax: Any = None) -> Any:
        """Draw the motion over a period, and its mean, on ``ax`` or on new axes; with a frequency its modulus.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.

        Examples
        --------
        >>> import floquetrod as fr
        >>> fr.response(fr.Mathieu(0.3, -0.6, 0.01), 1.0).plot().get_ylabel()
        'steady motion $A$'
        """
        from floquetrod.plotting.response_plot import draw_response

        return draw_response(self, ax)

    def report(self) -> Report:
        """Return the response in lines: size, mean, harmonics, distance from resonance, method."""
        largest, rms, mean = (np.atleast_1d(value) for value in (self.largest, self.rms, self.mean))
        lines = [("equation", repr(self.equation)), ("force", str(self.force)), ("rms", _numbers(rms))]
        if self.frequency is None:
            lines.append(("mean", _numbers(mean)))
        lines.append(("waves", self._waves()))
        lines.append(("distance", f"{self.distance:.3g} of {self._target} from the nearest multiplier"))
        lines.append(("method", f"{self.method}, error {self.error:.1g} of the largest"))
        lines += [("note", self.note)] if self.note else []
        return Report(f"largest {_numbers(largest)}", lines)

    def _waves(self) -> str:
        """Return the largest harmonics, as frequencies and amplitudes."""
        amplitudes = self._motion.amplitudes
        middle = len(amplitudes) // 2
        sizes = np.linalg.norm(amplitudes, axis=1)
        order = [k for k in np.argsort(-sizes, kind="stable").tolist() if self.frequency is not None or k > middle][:3]
        factor = 1.0 if self.frequency is not None else 2.0
        texts = [f"k = {k - middle}: {_numbers(factor * np.abs(amplitudes[k]))}" for k in order if sizes[k] > 0.0]
        return "; ".join(texts) or "none"

    @property
    def _target(self) -> str:
        return "1" if self.frequency is None else "exp(i w T)"

    def as_dict(self) -> dict[str, Any]:
        """Return the response as numbers for JSON; None for infinite or unknown ones."""
        middle = len(self._motion.amplitudes) // 2
        top = float(np.abs(self._motion.amplitudes).max(initial=0.0))
        return {
            "method": self.method,
            "status": self.status,
            "frequency_per_unit_time": self.frequency,
            "period": self.period,
            "largest": np.asarray(self.largest).tolist(),
            "rms": np.asarray(self.rms).tolist(),
            "mean": _parts(self.mean),
            "harmonics": [
                {"k": k - middle, "amplitude": [_parts(value) for value in row.tolist()]}
                for k, row in enumerate(self._motion.amplitudes)
                if np.abs(row).max() > 1e-12 * top
            ],
            "distance": number(self.distance),
            "error": number(self.error),
            "note": self.note,
        }

    def __repr__(self) -> str:
        """Return the response as a sentence."""
        what = "response" if self.frequency is None else f"response at {self.frequency:.6g}"
        text = f"{what}: largest {_numbers(np.atleast_1d(self.largest))}, error {self.error:.1g}; {self.method}"
        return f"<{text}; {self.note}>" if self.note else f"<{text}>"


def _numbers(vector: Any) -> str:
    texts = [f"{value:.6g}" for value in np.real_if_close(vector).tolist()[:6]]
    return texts[0] if len(vector) == 1 else f"({', '.join(texts)}{', ...' if len(vector) > 6 else ''})"


def _parts(value: Any) -> Any:
    """Return a number or numbers for JSON, complex ones by their parts."""
    if isinstance(value, np.ndarray):
        return [_parts(entry) for entry in value.tolist()]
    return {"re": value.real, "im": value.imag} if isinstance(value, complex) else float(value)


def response(
    equation: Problem,
    force: Any,
    frequency: float | None = None,
    *,
    cosines: Any = (),
    sines: Any = (),
    jumps: Any = (),
    method: str = "auto",
    unstable: bool = False,
) -> Response:
    """Return the steady motion of an equation or a system under a force beside the parametric one.

    Of A'' + 2 c A' = p(tau) A + f(tau) for a scalar equation, M q'' + (C + G) q' + K(t) q = f(t) for a `HillSystem`,
    x' = A(t) x + f(t) for a `PeriodicSystem`, and likewise with delays: the one motion of the period of the
    coefficients, or x = exp(i w t) u(t) under a force of the frequency w, which remains when free motion has died away.

    Parameters
    ----------
    equation : Equation, HillSystem, PeriodicSystem or DelaySystem
        The problem, one and not a batch.
    force : float, array_like (n,) or callable
        A constant force; the mean of a Fourier series; a function f(t) of the period, each value a number,
        or n of a system; with a ``frequency`` its complex amplitude, one for each coordinate, of exp(i w t).
    frequency : float, optional
        w, any frequency, in radians per unit of time; none by default, where the force has the period of the
        coefficients.
    cosines : sequence of float or of array_like (n,)
        Coefficients of the cosines of the force, from the first harmonic of the coefficients' period on.
    sines : sequence of float or of array_like (n,)
        Coefficients of the sines, likewise.
    jumps : sequence of float
        Instants from 0 up to the period at which a force that is a function jumps, or has a kink.
    method : {"auto", "hill", "monodromy"}
        Hill's matrix, for coefficients and forces that are Fourier series; or the map over a period, for all.  "auto"
        takes the first where it serves.
    unstable : bool
        Whether to answer where free motion grows, so that nobody sees the motion returned.

    Returns
    -------
    Response

    Raises
    ------
    TypeError, ValueError
        For forces that do not fit, for unstable problems, and on a resonance, where exp(i w T), 1 for a force of the
        period, is a multiplier and no motion is bounded.

    Examples
    --------
    >>> import floquetrod as fr
    >>> steady = fr.response(fr.Mathieu(alpha=0.3, beta=-0.6, damping=0.01), 1.0)
    >>> f"{steady.mean:.9f}, {steady.largest:.8f}", steady.error < 1e-12
    ('1.400370874, 2.51484507', True)

    A signal and its idler near a degenerate parametric amplifier's resonance:

    >>> amplifier = fr.HillSystem([[1.0]], sines=[[[0.03]]], damping=[[0.02]], period=3.141592653589793)
    >>> waves = fr.response(amplifier, 1.0, frequency=0.999).harmonics
    >>> f"{abs(waves[0][0]):.6f}, {abs(waves[-1][0]):.6f}"
    '106.554422, 79.450295'
    """
    require_problem(equation)
    driving = force_of(equation, force, frequency, cosines, sines, jumps)
    return respond(equation, driving, method, unstable=unstable)


def respond(equation: Problem, force: Force, method: str, *, unstable: bool) -> Response:
    """Return the response to a checked force."""
    method = validate.choice("method", method, ("auto", *methods.BY_NAME))
    unstable = validate.flag("unstable", unstable)
    if method == "auto":
        name = next(m.name for m in methods.METHODS if m.refusal(equation, force) is None)
    else:
        name = method
        refused = methods.BY_NAME[name].refusal(equation, force)
        if refused:
            raise TypeError(refused)
    verdict = stability(equation)
    if verdict.status == "unstable" and not unstable:
        raise ValueError(
            f"equation must be stable, or free motion grows, at {verdict.growth_rate:.6g} per unit of time, and nobody "
            "sees the steady motion; unstable=True returns it"
        )
    distance, nearest = _distance(equation, force, verdict)
    with np.errstate(all="ignore"):
        motion, error = methods.BY_NAME[name].call(equation, force)
    if not error <= _LARGEST_ERROR:
        target = "1" if force.frequency is None else f"exp(i frequency period) = {_target(equation, force):.6g}"
        raise ValueError(
            f"{'force' if force.frequency is None else 'frequency'} must not be on a resonance, where no motion is "
            f"bounded: {target} lies {distance:.2g} from the multiplier {nearest:.9g}, and the error of the steady "
            f"motion is {error:.2g} of it"
        )
    return Response(equation, force, name, verdict.status, distance, error, _note(verdict), motion)


def _note(verdict: Any) -> str:
    """Return what to know of a steady motion beside free ones that do not decay."""
    if verdict.status == "unstable":
        return f"unstable: free motion grows at {verdict.growth_rate:.6g} per unit of time, away from this one"
    if verdict.status == "undecided":
        return "whether free motion decays could not be decided"
    slowest = max((e.real for e in verdict.exponents if e == e), default=-math.inf)
    return "free motion does not decay beside it" if slowest >= 0.0 else ""


def _target(equation: Problem, force: Force) -> complex:
    """Return exp(i w T)."""
    return cmath.exp(1j * (force.frequency or 0.0) * float(equation.period))


def _distance(equation: Problem, force: Force, verdict: Any) -> tuple[float, complex]:
    """Return how far exp(i w T) is from the nearest multiplier, and that."""
    target, period = _target(equation, force), float(equation.period)
    known = [cmath.exp(complex(min(e.real * period, 600.0), e.imag * period)) for e in verdict.exponents if e == e]
    if not known:
        return (1.0, 0j) if isinstance(equation, DelaySystem) else (math.nan, complex(math.nan))
    nearest = min(known, key=lambda mu: abs(mu - target))
    return abs(nearest - target), nearest
