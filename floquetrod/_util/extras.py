"""Libraries of optional extras, imported where an installation has them."""

from __future__ import annotations

from typing import Any


def xarray(extra: str = "xarray") -> Any:
    """Return the module xarray, or raise ImportError with the command that installs it."""
    try:
        import xarray
    except ImportError:
        raise ImportError(f"this needs xarray: pip install floquetrod[{extra}]", name="xarray") from None
    return xarray


def pandas(extra: str = "pandas") -> Any:
    """Return the module pandas, or raise ImportError with the command that installs it."""
    try:
        import pandas
    except ImportError:
        raise ImportError(f"this needs pandas: pip install floquetrod[{extra}]", name="pandas") from None
    return pandas
