"""The critical value of a quantity of the load, with the resolution and the error of the search for it."""

from __future__ import annotations

import math
from typing import Any, Literal, TypeAlias

from floquetrod._util.interchange import plain, with_unit
from floquetrod.rod.loads.load import LOAD, Quantity
from floquetrod.units import AnswerUnits, InUnits, Unit

_UNDECIDED = 1e-3  # error of a factor, relative to it, that is no error of a search (a choice)

Searched: TypeAlias = Quantity | Literal["noise"]
"""Quantities that have a critical value."""


class CriticalValue(InUnits, float):
    """The value of one quantity of the load at which something begins to grow; infinite where nothing is seen to.

    Of a mean force or an amplitude the smallest from zero up, in N; of the noise the largest factor at which a rod is
    stable in mean square.  A float, with the resolution and the error of the search for it.

    Attributes
    ----------
    quantity : "mean", "amplitude" or "noise"
        The quantity that varies.
    resolution : float
        Unstable bands below it up to this width may have been passed over, in N; 0 where none can be.
    searched : float
        Value up to which was searched: itself where something grows.
    error : float
        Of the factor of the noise: with ``factor - error`` the verdict is stable, with ``factor + error`` unstable.
        Where noise in a narrow band leaves verdicts above the factor undecided the error reaches to one that is
        unstable, infinite where none was found; those below the factor are stable all the same.
    mode : int or None
        Mode that grows beyond the factor of the noise; None where all high modes or coupled ones do.
    """

    quantity: Searched
    resolution: float
    searched: float
    error: float
    mode: int | None

    def __new__(
        cls,
        value: float,
        quantity: Searched = "mean",
        resolution: float = 0.0,
        searched: float | None = None,
        *,
        error: float = 0.0,
        mode: int | None = None,
    ) -> CriticalValue:
        """Return a number with the resolution and the error of the search for it."""
        critical = super().__new__(cls, value)
        critical.quantity, critical.resolution, critical.error, critical.mode = quantity, resolution, error, mode
        critical.searched = float(value) if searched is None else searched
        return critical

    def __repr__(self) -> str:
        """Return the number, or up to where nothing grows, and how good it is."""
        name, unit = "noise", Unit("times the noise", 1.0)
        if self.quantity != "noise":
            name, unit = LOAD[self.quantity].words, AnswerUnits.named(given=self.given_units).force
        if math.isinf(self):
            size = f"no critical {name} up to {unit.show(self.searched)}"
        else:
            size = f"critical {name} {unit.show(float(self), 9)}"
            if self.quantity == "noise":
                is_sharp = self.error <= _UNDECIDED * self
                grows = "begins to grow" if is_sharp else "may begin to grow"
                mode = "" if self.mode is None else f", where mode {self.mode} {grows}"
                size += f", to {self.error:.1g}{mode}" if is_sharp else mode
                if not is_sharp:
                    end = f"up to {float(self) + self.error:.3g} times" if math.isfinite(self.error) else "beyond"
                    size += f"; verdicts are undecided {end}"
        missed = f"unstable bands narrower than {unit.show(self.resolution, 2)} may have been missed"
        return f"<{size}; {missed}>" if self.resolution else f"<{size}>"

    def as_dict(self) -> dict[str, Any]:
        """Return the number with its resolution or error for JSON, units in the keys; None for infinite.

        Returns
        -------
        dict of str
            Numbers by name.
        """
        if self.quantity == "noise":
            return {
                "critical_noise_factor": plain(float(self)),
                "error": plain(self.error),
                "mode": self.mode,
                "searched": self.searched,
            }
        limits = LOAD[self.quantity]
        return {
            with_unit(f"critical {limits.words}", limits.unit): plain(float(self)),
            with_unit("resolution", limits.unit): self.resolution,
            with_unit("searched", limits.unit): self.searched,
        }
