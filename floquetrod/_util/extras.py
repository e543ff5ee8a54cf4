"""Libraries of extras, which an installation may lack."""

from __future__ import annotations

from typing import Any


def xarray(extra: str = "xarray") -> Any:
    """Return the module xarray, or raise ImportError with the command that installs it."""
    try:
        import xarray
    except ImportError:
        raise ImportError(f"this needs xarray: pip install floquetrod[{extra}]", name="xarray") from None
    return xarray
