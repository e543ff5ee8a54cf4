"""`SystemStability`, the verdict that every method for systems returns."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from floquetrod._util.caching import cached_property
from floquetrod._util.result_report import Report, Table, number
from floquetrod.equations import DelayedMoments, DelaySystem, PeriodicSystem
from floquetrod.equations.matrices import Structure
from floquetrod.equations.pieces import real_form
from floquetrod.floquet.multipliers import resonance_names
from floquetrod.floquet.multipliers.resonance_names import Resonance
from floquetrod.floquet.verdict import FloquetVerdict

_LISTED = 40
"""Multipliers in a report, the largest; all are among the numbers."""

_DELAYED = DelaySystem | DelayedMoments


def _second_order(system: Any) -> bool:
    """Return whether a system is of second order."""
    return system.is_second_order if isinstance(system, _DELAYED) else not isinstance(system, PeriodicSystem)


def _exponent(exponent: complex, error: float) -> str:
    """Return an exponent, without an imaginary part and with the real part 0 where these are within the error."""
    real, imag = (part if abs(part) > error else 0.0 for part in (exponent.real, exponent.imag))
    if real == imag == 0.0:
        return f"0 within {error:.0e}"
    return f"{real:.6g} {'-' if imag < 0.0 else '+'} {abs(imag):.6g}i" if imag else f"{real:.6g}"


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class SystemStability(FloquetVerdict):
    """Verdict on a system of equations, per unit of its time.

    Beside all fields of a `FloquetVerdict` it has as many exponents as equations of first order; with delays, the
    exponents of the multipliers above a modulus stated in the note, characteristic roots where coefficients are
    constant.  ``error`` is the relative error of the multipliers as they were computed: the largest finite one of
    ``exponent_errors`` times the period, except for the rounding of the exponents to doubles.  An exponent of infinite
    error is NaN.

    Attributes
    ----------
    krein_signs : tuple of int
        +1 or -1 for each multiplier on the unit circle whose Krein sign is known, else 0; a natural oscillator of
        frequency f has +1 at exp(i f period).  All 0 where the system is not Hamiltonian.
    unknown_below : float
        Upper bound of the real parts of the unknown exponents, which are NaN, as are their multipliers, and come last;
        minus infinity where all are known.
    along_orbit : bool
        Whether the system is linearised along a periodic orbit; ``resonances`` then are named as its special points.
    growth_below : float
        Upper bound of the real parts of all exponents; infinite without a bound.
    strongly_stable : bool or None
        Whether all small changes of the coefficients that keep the structure leave the system stable; with damping:
        whether every solution decays.  None when undecided.
    """

    exponent_errors: tuple[float, ...] = ()
    krein_signs: tuple[int, ...] = ()
    strongly_stable: bool | None = None
    unknown_below: float = -math.inf
    growth_below: float = math.inf
    along_orbit: bool = field(default=False, compare=False)

    @property
    def are_resolved(self) -> bool:
        """Whether every multiplier is known to a digit at least."""
        return bool(self.exponents) and all(error * self.period <= 1.0 for error in self.exponent_errors)

    @property
    def highest_rate(self) -> float:
        """Largest real part of the known exponents, an upper bound where none is known, NaN without exponents."""
        rates = [exponent.real for exponent in self.exponents if exponent == exponent]
        return max(rates, default=self.unknown_below if self.exponents else math.nan)

    @property
    def _slowest(self) -> float:
        """Largest real part of the exponents, or upper bound of it where some are not known."""
        return max(super()._slowest, self.unknown_below)

    @cached_property
    def resonances(self) -> tuple[Resonance, ...]:
        """Names of the growing solutions, the fastest first; they do not affect the verdict.

        They are heuristic, except for equations of second order that are coupled with no other, without jumps, whose
        tongues are counted.  None contradicts its multiplier: direct resonances and buckling are names of real ones, of
        the sign that belongs to the order, and complex pairs are named as combinations of two modes or not at all.
        Solutions whose growth is below its error have none, unless it is the fastest.
        """
        if self.status != "unstable":
            return ()
        exponents, errors = np.array(self.exponents), np.array(self.exponent_errors)
        certain = exponents.real > errors
        if not certain.any():
            certain[:1] = True
        return resonance_names.name(
            self.system, exponents[certain].tolist(), errors[certain].tolist(), of_orbit=self.along_orbit
        )

    @property
    def structure(self) -> Structure:
        """Structure that follows exactly from the matrices, such as "hamiltonian", "reversible" or "unitary"."""
        found: Structure = self.system.structure
        return found

    @property
    def quasienergies(self) -> tuple[float, ...]:
        """Quasienergies e of a "unitary" system, ascending, of its solutions exp(-i e t) u(t) with u of the period.

        In units of an angular frequency (of hbar), above -w / 2 and up to w / 2, w = 2 pi / period: minus the imaginary
        parts of the exponents.  Empty where the system is not unitary, as with losses, for which ``exponents`` hold
        decay rates and frequencies, and where nothing is known.

        Examples
        --------
        A two-level atom, H = sigma_z / 2 + cos(t) sigma_x / 4, and A = -i H:

        >>> import floquetrod as fr
        >>> atom = fr.PeriodicSystem([[-0.5j, 0], [0, 0.5j]], cosines=[[[0, -0.25j], [-0.25j, 0]]])
        >>> [round(e, 11) for e in fr.stability(atom).quasienergies]
        [-0.37524727817, 0.37524727817]
        """
        return tuple(energy for energy, _ in self._energies)

    @property
    def quasienergy_errors(self) -> tuple[float, ...]:
        """Error of each of ``quasienergies``."""
        return tuple(error for _, error in self._energies)

    @property
    def _energies(self) -> list[tuple[float, float]]:
        """Quasienergies with their errors."""
        if not isinstance(self.system, PeriodicSystem) or not self.system.keeps_norm:
            return []
        half = math.pi / self.period
        known = [(e.imag, error) for e, error in zip(self.exponents, self.exponent_errors, strict=True) if e == e]
        return sorted((half if rate >= half else 0.0 - rate, error) for rate, error in known)

    @property
    def largest_multiplier_less_1(self) -> float:
        """Magnitude of the largest multiplier less 1; 0 where all lie on the circle, NaN where not known."""
        rate = super()._slowest
        if rate == -math.inf:
            return math.nan
        if self.status == "stable" and rate * self.period > -self.error:
            return 0.0
        return math.expm1(min(rate * self.period, 700.0))

    @property
    def opposite_signs_apart(self) -> float | None:
        """Least angle in rad between multipliers of opposite Krein signs, which must meet before any can grow.

        None where a multiplier's sign is not known, or all signs are alike.
        """
        if not self.exponents or not all(self.krein_signs):
            return None
        signed = list(zip(self.exponents, self.krein_signs, strict=True))
        plus, minus = ([e.imag * self.period for e, sign in signed if sign == wanted] for wanted in (1, -1))
        return min((abs(math.remainder(a - b, 2.0 * math.pi)) for a in plus for b in minus), default=None)

    def report(self, *, damping: bool = False) -> Report:
        """Return the verdict in lines and a table of multipliers; with the ``damping`` that stabilises, a search."""
        system = self.system
        form = "second order" if _second_order(system) else "first order"
        kind = "complex equation" if isinstance(system, PeriodicSystem) and system.is_complex else "equation"
        equations = f"{system.order} {kind}{'' if system.order == 1 else 's'} of {form}"
        equations += ", of second moments" if system.MEANING else ""
        turns = f"period {self.period:.6g} (angular frequency {2.0 * math.pi / self.period:.6g})"
        lines = [("system", f"{equations}, {self.structure}, {system.variation}, {turns}")]
        if self.growth_rate > 0.0:
            tenfold = math.log(10.0) / self.growth_rate
            lines.append(("growth", f"{self.growth_rate:.6g} per unit time, tenfold in {tenfold:.4g}"))
        if self.decay_rate > 0.0:
            lines.append(("decay", f"{self.decay_rate:.6g} per unit time, the slowest motion"))
        for i, resonance in enumerate(self.resonances):
            nearest = "" if i or not resonance.modes else " (the nearest combination of frequencies)"
            lines.append(("" if i else "named", f"{resonance}, growth {resonance.growth_rate:.6g}{nearest}"))
        lines += self._energy_lines()
        lines.append(("margin", self._margin))
        lines += self._damping_lines() if damping else []
        known = math.isfinite(self.error)
        good = f"multipliers good to {self.error:.0e} relative" if known else "multipliers not known"
        lines.append(("method", f"{self.method}, {self.cost}; {good}"))
        lines += [("note", self.note)] if self.note else []
        return Report(self._headline, lines, self._table())

    def _energy_lines(self) -> list[tuple[str, str]]:
        """Return a line on the quasienergies of a complex system; without any, on its exponents."""
        known = [exponent for exponent in self.exponents if exponent == exponent]
        if not 0 < len(known) <= _LISTED or self.system.MEANING:
            return []
        if self.structure == "unitary":
            energies = ", ".join(f"{energy:.12g}" for energy in self.quasienergies)
            return [("energies", f"quasienergies {energies}, in angular frequency")]
        if not (isinstance(self.system, PeriodicSystem) and self.system.is_complex):
            return []
        errors = zip(self.exponents, self.exponent_errors, strict=True)
        exponents = ", ".join(_exponent(exponent, error) for exponent, error in errors if exponent == exponent)
        return [("energies", f"none, since the system has losses or gain; its exponents, per unit time: {exponents}")]

    def _damping_lines(self) -> list[tuple[str, str]]:
        """Return a line on the uniform damping that stabilises the system; none where it needs none."""
        rate = self.damping_to_stabilise
        if not rate > 0.0:
            return []
        if math.isinf(rate):
            if self.status == "stable":
                return []
            text = "strong damping does not stabilise it, as the mean stiffness alone is unstable; weak damping may"
            return [("damping", f"{text} (fr.margin searches it, over a parameter of the damping)")]
        if not _second_order(self.system):
            tried = "" if isinstance(self.system, PeriodicSystem) else "; larger ones were tried, not all"
            return [("damping", f"stable with A - c I in place of A, c above {rate:.6g} per unit time{tried}")]
        more = f"stable with more damping than {self._more_damping(2.0 * rate)}"
        added = f"which adds a decay rate of {rate:.6g} per unit time"
        return [("damping", f"{more}, {added}; larger rates were tried, not all")]

    def _more_damping(self, added: float) -> str:
        """Return the damping matrix with a multiple of the mass matrix added, and the sum where C is one too."""
        unit = "I" if getattr(self.system, "mass", None) is None else "M"
        present = getattr(self.system, "uniform_damping", None)
        return f"C + {added:.6g} {unit}" + (f" = {2.0 * present + added:.6g} {unit}" if present else "")

    @property
    def _headline(self) -> str:
        if self.system.MEANING and self.status != "undecided":
            what = f"grow at {self.growth_rate:.6g} per unit time"
            what = "decay" if self.largest_multiplier_less_1 < 0.0 else "stay bounded" if self.stable else what
            return f"{self.system.MEANING.upper()} {self.status.upper()}: the second moments {what}"
        if self.status == "unstable":
            return f"UNSTABLE: grows at {self.growth_rate:.6g} per unit time"
        if self.status == "undecided":
            return "UNDECIDED: a multiplier is too close to the unit circle, or two multipliers are too close together"
        if self.largest_multiplier_less_1 < 0.0:
            return "STABLE: every motion decays"
        if self.structure == "unitary":
            return "STABLE: every motion keeps its norm"
        if self.strongly_stable:
            return "STABLE, strongly: small changes of the coefficients leave every motion bounded"
        return "STABLE: every motion stays bounded"

    @property
    def _margin(self) -> str:
        largest = self.largest_multiplier_less_1
        if self.status == "undecided" and abs(largest) <= self.error < 1.0:
            return f"the largest multiplier lies on the unit circle within {self.error:.0e}"
        if largest == 0.0:
            apart = self.opposite_signs_apart
            text = "all multipliers lie on the unit circle"
            return text if apart is None else f"{text}; those of opposite Krein signs are {apart:.4g} rad apart or more"
        if math.isnan(largest):
            return "unknown"
        way = "outside" if largest > 0.0 else "inside"
        return f"the largest multiplier lies {abs(largest):.4g} {way} the unit circle"

    def _table(self) -> Table | None:
        rows = []
        multipliers = list(zip(self.multipliers, self.multiplier_errors, self.krein_signs, strict=True))
        for mu, error, sign in multipliers[:_LISTED]:
            if mu != mu:
                rows.append(("  not known", "", "", "", ""))
                continue
            written = f"{mu.real:+.9f} {mu.imag:+.9f}i" if abs(mu) < 1e4 else f"{mu.real:+.6e} {mu.imag:+.6e}i"
            angle = f"{math.atan2(mu.imag, mu.real) / math.pi:+.6f}"
            krein = {1: "+", -1: "-"}.get(sign, "")
            rows.append((f"  {written}", f"{abs(mu):.9g}", angle, f"{error:.0e}", krein))
        columns = [("  multiplier", "<31"), ("magnitude", "<13"), ("angle/pi", ">9"), ("error", ">8")]
        more = len(multipliers) - _LISTED
        rest = f"  and {more} more, which decay faster (the JSON lists them)" if more > 0 else ""
        return Table([*columns, ("Krein sign", ">5")], rows, rest) if rows else None

    def as_dict(self, *, damping: bool = False) -> dict[str, Any]:
        """Return the verdict as numbers for JSON, with None for infinite and unknown numbers.

        With the ``damping`` that stabilises, a search.
        """
        exponents = zip(self.exponents, self.exponent_errors, strict=True)
        multipliers = zip(self.multipliers, self.multiplier_errors, self.krein_signs, strict=True)
        return {
            "status": self.status,
            "strongly_stable": self.strongly_stable,
            "growth_rate_per_unit_time": number(self.growth_rate),
            "decay_rate_per_unit_time": self.decay_rate,
            **({"damping_to_stabilise_per_unit_time": number(self.damping_to_stabilise)} if damping else {}),
            "largest_multiplier_less_1": number(self.largest_multiplier_less_1),
            "opposite_krein_signs_apart_rad": self.opposite_signs_apart,
            "resonances": [resonance.as_dict() for resonance in self.resonances],
            "multipliers": [
                {
                    "real": number(mu.real),
                    "imag": number(mu.imag),
                    "error": number(error),
                    "exponent_real": number(exponent.real),
                    "exponent_imag": number(exponent.imag),
                    "exponent_error": number(exponent_error),
                    "krein_sign": sign,
                }
                for (mu, error, sign), (exponent, exponent_error) in zip(multipliers, exponents, strict=True)
            ],
            "equations": self.system.order,
            "structure": self.structure,
            **({"quasienergies": [*self.quasienergies]} if self.structure == "unitary" else {}),
            "harmonics": 0 if self.system.pieces else int(real_form(self.system).harmonics.shape[-3]),
            **({"pieces": len(self.system.pieces)} if self.system.pieces else {}),
            **({"delays": [*map(float, self.system.delays)]} if isinstance(self.system, _DELAYED) else {}),
            "period": self.period,
            "method": self.method,
            "relative_error": number(self.error),
            "cost": str(self.cost),
            "note": self.note,
        }

    @property
    def _status_in_words(self) -> str:
        if self.system.MEANING:
            return f"{self.system.MEANING} {self.status}"
        strongly = self.strongly_stable and self.status == "stable" and self.structure != "unitary"
        return "strongly stable" if strongly else self.status

    @property
    def _named(self) -> str:
        return f", {self.resonances[0]}" if self.resonances else ""

    @property
    def _known(self) -> str:
        size = f"{self.structure} system of {self.system.order}"
        return size + (
            f", multipliers +- {self.error:.1g} relative"
            if self.exponents and math.isfinite(self.error)
            else ", multipliers not computed"
        )
