"""Methods for systems, one per file, none of which calls another: from a system to a `SystemStability`."""

from __future__ import annotations

from floquetrod.floquet.system_methods.half_period import half_period
from floquetrod.floquet.system_methods.monodromy import monodromy
from floquetrod.floquet.system_methods.reference import reference
from floquetrod.floquet.system_methods.segmented import segmented
from floquetrod.floquet.system_methods.spectral import spectral

# Imported at once, not on first use: a module of the same name, imported later, would take the function's place.
__all__ = ["half_period", "monodromy", "reference", "segmented", "spectral"]
