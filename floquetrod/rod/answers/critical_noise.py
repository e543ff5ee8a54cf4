"""The critical noise of a rod: a factor, its error, and the mode that grows beyond it."""

from __future__ import annotations

import math
from typing import Any

from floquetrod._util.interchange import plain


class CriticalFactor(float):
    """Largest factor of the noise of a load at which a rod is stable in mean square; infinite where none is found.

    A float, with what is known of it.

    Attributes
    ----------
    error : float
        Of the factor: with ``factor - error`` the verdict is stable, with ``factor + error`` unstable.
    mode : int or None
        Mode that grows beyond it; None where all high modes or coupled ones do.
    searched : float
        Factor up to which was searched: itself where something grows.
    """

    error: float
    mode: int | None
    searched: float

    def __new__(
        cls, value: float, error: float = 0.0, mode: int | None = None, searched: float | None = None
    ) -> CriticalFactor:
        """Return a number with what is known of it."""
        factor = super().__new__(cls, value)
        factor.error, factor.mode = error, mode
        factor.searched = float(value) if searched is None else searched
        return factor

    def __repr__(self) -> str:
        """Return the number and its error, or up to where nothing grows, and the mode that grows."""
        if math.isinf(self):
            return f"<no critical noise up to {self.searched:.6g} times the noise>"
        mode = "" if self.mode is None else f", where mode {self.mode} begins to grow"
        return f"<critical noise {float(self):.9g} times the noise, to {self.error:.1g}{mode}>"

    def as_dict(self) -> dict[str, Any]:
        """Return the number, its error, the mode and the end of the search for JSON; None for infinite."""
        return {
            "critical_noise_factor": plain(float(self)),
            "error": plain(self.error),
            "mode": self.mode,
            "searched": self.searched,
        }
