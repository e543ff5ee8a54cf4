"""Second moments of systems with delays and multiplicative white noise, whose equations are not closed.

Those of x(t), x(t - tau) and all values between belong together; `floquetrod.stability` decides about their growth by
the renewal equation of the products of noise alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, ClassVar, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.content import ByContent
from floquetrod.equations.delay_system import DelayedTerm, DelaySystem, delay_of, terms_of, with_terms
from floquetrod.equations.matrices import Matrix, Structure
from floquetrod.equations.periodic_system import PeriodicSystem
from floquetrod.equations.second_moments import INTERPRETATIONS, NoiseSource, checked_source, given_sources, with_drift

_EXAMPLE = "[(matrix, intensity), ...] or [(matrix, intensity, [(delay, matrix), ...]), ...]"


class DelayedNoise(NamedTuple):
    """A source of white noise: s (G x(t) + sum_k H_k x(t - tau_k)) xi(t), or the same of q.

    Attributes
    ----------
    present : ndarray (n, n)
        Matrix G of the present values.
    delayed : tuple of (float or Fraction, ndarray)
        Delays tau_k, exactly, and matrices H_k (n, n).
    intensity : float
        Intensity s.
    """

    present: Matrix
    delayed: tuple[tuple[float | Fraction, Matrix], ...]
    intensity: float


@dataclass(frozen=True, eq=False, repr=False)
class DelayedMoments(ByContent):
    """The second moments of a system with delays under white noise in its coefficients, in Ito's sense.

    The ``equation`` of a verdict by ``floquetrod.stability(system, noise=...)`` where the system has delays.

    Attributes
    ----------
    system : DelaySystem
        The system without noise; in Stratonovich's sense with the drift that noise adds.
    noise : tuple of DelayedNoise
        The sources, independent of each other.
    """

    MEANING: ClassVar[str] = "mean-square"

    system: DelaySystem
    noise: tuple[DelayedNoise, ...]

    @property
    def order(self) -> int:
        """Number of equations of the system."""
        return self.system.order

    @property
    def period(self) -> float:
        """Period of the coefficients."""
        return self.system.period

    @property
    def is_second_order(self) -> bool:
        """Whether the equations of the system are of second order."""
        return self.system.is_second_order

    @property
    def delays(self) -> tuple[float | Fraction, ...]:
        """Every delay, of the system in the order of its terms, then others of the noise."""
        others = (delay for source in self.noise for delay, _ in source.delayed)
        return tuple(dict.fromkeys((*self.system.delays, *others)))

    @property
    def structure(self) -> Structure:
        """The word "general"."""
        return "general"

    @property
    def pieces(self) -> tuple[Any, ...]:
        """Pieces of the coefficients without delay."""
        return self.system.pieces

    @property
    def harmonics(self) -> Any:
        """Harmonics of the coefficients without delay."""
        return self.system.harmonics

    @property
    def variation(self) -> str:
        """How the coefficients vary, how many delays there are, and how many sources of noise, in words."""
        count = len(self.noise)
        return f"{self.system.variation}, {count} noise source{'' if count == 1 else 's'}"

    def times(self, factor: float) -> DelayedMoments:
        """Return the moments under noise of intensities multiplied by a factor, with the same drift."""
        stronger = tuple(source._replace(intensity=factor * source.intensity) for source in self.noise)
        return replace(self, noise=stronger)

    def __repr__(self) -> str:
        """Return the system and the number of its sources of noise."""
        return f"<second moments of {self.system!r} under {len(self.noise)} noise source(s)>"


def delayed_moments(system: DelaySystem, noise: Any, interpretation: str = "ito") -> DelayedMoments:
    """Return the second moments of a system with delays under noise, checked, as `floquetrod.stability` takes them."""
    interpretation = validate.choice("interpretation", interpretation, INTERPRETATIONS)
    sources = []
    for name, given in given_sources(noise, (2, 3), _EXAMPLE):
        names = (name, f"{name}[0]", f"{name}[1]")
        matrix, intensity = checked_source(system.present, given[0], given[1], names)
        if matrix.ndim > 2 or intensity.ndim:
            shape = f"matrix {matrix.shape}, intensity {intensity.shape}"
            raise ValueError(f"{name} must be one matrix and one intensity for a system with delays, got {shape}")
        sources.append(DelayedNoise(matrix, _delayed(f"{name}[2]", given[2:], system), float(intensity)))
    if interpretation == "stratonovich" and not system.is_second_order:
        system = _with_drift(system, sources)
    return DelayedMoments(system, tuple(sources))


def _delayed(name: str, given: Any, system: DelaySystem) -> tuple[tuple[float | Fraction, Matrix], ...]:
    """Return the delays and matrices of a source, each delay once."""
    terms: dict[float | Fraction, Matrix] = {}
    for each, (delay, value) in terms_of(given[0], (2,), "(delay, matrix)", name) if given else []:
        matrix, _ = checked_source(system.present, value, 0.0, (each, f"{each}[1]", name))
        if matrix.ndim > 2:
            raise ValueError(f"{each}[1] must be one matrix, got shape {matrix.shape}")
        delay = delay_of(f"{each}[0]", delay, "noise of the present values belongs to the first matrix of its source")
        terms[delay] = terms.get(delay, 0.0) + matrix
    return tuple(terms.items())


def _with_drift(system: DelaySystem, sources: list[DelayedNoise]) -> DelaySystem:
    """Return a system of first order with the drift of Stratonovich's noise, sum_i s_i^2 G_i (G_i x + H_i x_tau) / 2.

    Values in the past do not depend on the noise of the moment: G_i alone is differentiated.
    """
    present, rounding = with_drift(
        system.present,  # type: ignore[arg-type]
        [NoiseSource(source.present, 0.0, np.array(source.intensity)) for source in sources],
        0.5,
    )
    added: dict[float | Fraction, Matrix] = {}
    for source in sources:
        for delay, matrix in source.delayed:
            drift = 0.5 * source.intensity**2 * (source.present @ matrix)
            added[delay] = added.get(delay, 0.0) + drift
            rounding += 1e-15 * system.order * float(np.abs(drift).max())
    terms = [
        DelayedTerm(delay, PeriodicSystem(drift, period=system.present.period))
        for delay, drift in added.items()
        if drift.any()
    ]
    present = replace(present, coefficient_error=present.coefficient_error + rounding)
    return with_terms(system, present, terms)
