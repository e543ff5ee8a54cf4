"""Quantities as people write them: "0.2Fcr", "24Hz", "0.8mm", "68GPa"."""

from __future__ import annotations

import math
import re
from typing import Any

_UNITS: dict[str, dict[str, float]] = {
    "force": {"N": 1.0, "kN": 1e3, "mN": 1e-3, "lbf": 4.4482216152605},
    "frequency": {"rad/s": 1.0, "1/s": 1.0, "Hz": 2.0 * math.pi, "rpm": math.pi / 30.0},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "km": 1e3, "in": 0.0254, "ft": 0.3048},
    "pressure": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "psi": 6894.757293168},
    "density": {"kg/m3": 1.0, "kg/m^3": 1.0, "g/cm3": 1e3, "g/cm^3": 1e3},
    "acceleration": {"m/s2": 1.0, "m/s^2": 1.0},
    "rate": {"1/s": 1.0, "/s": 1.0},
    "speed": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "ft/s": 0.3048},
}
"""Kinds of quantity: units and their size in the SI unit, which comes first."""

ROD_KINDS = {
    "youngs_modulus": "pressure",
    "density": "density",
    "radius": "length",
    "length": "length",
    "channel_radius": "length",
    "gravity": "acceleration",
    "damping_rate": "rate",
}
"""Kind of each parameter of a rod."""

_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S*)\s*")


def quantity(value: Any, name: str, kind: str, *, critical_force: float | None = None) -> float:
    """Return a quantity in SI units.

    Parameters
    ----------
    value : str or number
        A number with a unit; a number alone is in the SI unit of its kind.
    name : str
        What it is called in messages.
    kind : str
        "force", "frequency" (angular, in rad/s), "length", "pressure", "density", "acceleration", "rate",
        "speed" or "time".
    critical_force : float, optional
        In N; with it, forces may be given in "Fcr".

    Raises
    ------
    ValueError
        For anything else, naming what is accepted.

    Examples
    --------
    >>> quantity("0.8mm", "radius", "length")
    0.0008
    >>> quantity("0.5Fcr", "mean", "force", critical_force=1.7)
    0.85
    """
    units = dict(_UNITS[kind])
    if kind == "force" and critical_force is not None:
        units["Fcr"] = critical_force
    if isinstance(value, int | float) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:  # an integer of more than 308 digits, which a rod file may hold
            raise ValueError(f"{name} must be finite, got an integer beyond 1e308") from None
    match = _NUMBER.fullmatch(value) if isinstance(value, str) else None
    unit = (match[2] or next(iter(units))) if match else ""
    if match is None or unit not in units:
        what = f"unit {unit!r}" if match else "this"
        raise ValueError(
            f"{name} must be a number with a {kind} unit ({', '.join(units)}; none means {next(iter(units))}), "
            f"got {value!r}: {what} is not understood"
        )
    return float(match[1]) * units[unit]


def unit_of(text: str) -> str | None:
    """Return the unit of a quantity as it is written, "" where it has none; None where it is no quantity.

    >>> unit_of("24Hz"), unit_of("150"), unit_of("fast")
    ('Hz', '', None)
    """
    match = _NUMBER.fullmatch(text)
    return match[2] if match else None
