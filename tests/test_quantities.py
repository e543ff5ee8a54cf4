"""Quantities of pint stand wherever a string with a unit does."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np
import pytest

import floquetrod as fr
from floquetrod import units

NITINOL = {"youngs_modulus": "68GPa", "density": 6500.0, "radius": "0.8mm", "length": "3.1m", "channel_radius": "4.7mm"}


_TIMES_PER_SECOND = {"rad/s": 1.0, "1/s": 1.0, "hertz": 1.0, "kilohertz": 1e3}  # to pint a hertz is 1/s


class Measured:
    """A quantity as pint has it, of a few units."""

    DIMENSIONS: ClassVar = {
        "force": {"N": 1.0, "kN": 1e3},
        "force density": {"N^2/Hz": 1.0},
        "1/time": _TIMES_PER_SECOND,
        "time": {"s": 1.0, "ms": 1e-3},
        "length": {"m": 1.0, "ft": 0.3048},
        "mass": {"kg": 1.0},
        "stiffness": {"N/m": 1.0},
        "pressure": {"Pa": 1.0, "MPa": 1e6},
        "density": {"kg/m^3": 1.0, "kg/m3": 1.0},
        "acceleration": {"m/s^2": 1.0, "m/s2": 1.0},
        "speed": {"m/s": 1.0, "mm/s": 1e-3},
        "none": {"dimensionless": 1.0, "": 1.0, "rad": 1.0, "percent": 0.01},
        "curvature": {"1/m": 1.0, "rad/m": 1.0},
        "light": {"candela": 1.0},
    }

    def __init__(self, magnitude: Any, unit: str) -> None:
        self.magnitude, self.units = magnitude, unit

    def to(self, target: str) -> Measured:
        """Return it in another unit."""
        sizes = next(sizes for sizes in self.DIMENSIONS.values() if self.units in sizes)
        if target not in sizes:
            raise ValueError(f"Cannot convert from '{self.units}' to '{target}'")
        return Measured(self.magnitude * (sizes[self.units] / sizes[target]), target)

    def __repr__(self) -> str:
        return f"<{self.magnitude} {self.units}>"


def test_what_says_its_unit_is_converted_without_pint() -> None:
    load = fr.AxialLoad(Measured(0.3, "N"), Measured(0.2, "N"), Measured(24.0, "hertz"))
    assert load == fr.AxialLoad("0.3N", "0.2N", "24Hz")
    assert units.quantity(Measured(0.024, "kilohertz"), "frequency", "frequency") == pytest.approx(48.0 * math.pi)
    for wrong, message in (
        ((Measured(1.0, "m"), 0.1, 24.0), "mean must be a number with a force unit"),
        ((1.0, 0.1, Measured(1.0, "N")), "frequency must be a number with a frequency unit"),
        ((1.0, 0.1, Measured(np.ones(2), "hertz")), "frequency must be a number with a frequency unit"),
    ):
        with pytest.raises(ValueError, match=message):
            fr.AxialLoad(*wrong)
    with pytest.raises(ValueError, match="damping_rate must be a number with a rate unit"):
        fr.Rod.nitinol().replace(damping_rate=Measured(1.0, "hertz"))  # a count is no rate, as in a string
    with pytest.raises(ValueError, match="mean must be finite"):
        fr.AxialLoad(Measured(math.nan, "N"), 0.1, 24.0)


def test_surveys_take_them_one_by_one_and_as_arrays() -> None:
    depths = [0.0, 300.0, 600.0]
    plain = fr.WellPath(depths, ["0deg"] * 3)
    assert fr.WellPath(Measured(np.array(depths), "m"), ["0deg"] * 3) == plain
    assert fr.WellPath([Measured(depth, "m") for depth in depths], ["0deg"] * 3) == plain


def test_with_pint() -> None:
    pint = pytest.importorskip(
        "pint", reason="pip install floquetrod[pint]: quantities are accepted without importing it"
    )
    q = pint.UnitRegistry().Quantity
    rod = fr.Rod(**NITINOL)
    given = fr.Rod(
        youngs_modulus=q(68, "GPa"), density=q(6.5, "g/cm^3"), radius=q(0.8, "mm"), length=q(3.1, "m"),
        channel_radius=q(4.7, "mm"), inclination=q(90, "degree"),
    )  # fmt: skip
    assert given.as_dict() == pytest.approx(rod.as_dict(), rel=1e-14)
    for unit, written in (("Hz", "24Hz"), ("rpm", "24rpm"), ("rad/s", "24"), ("cycle/s", "24Hz"), ("1/s", "24")):
        assert fr.AxialLoad(0.1, 0.1, q(24, unit)).frequency == pytest.approx(
            fr.AxialLoad(0.1, 0.1, written).frequency, rel=1e-14
        )
    assert fr.AxialLoad(q(2, "lbf"), 0.1, 1.0).mean == pytest.approx(fr.AxialLoad("2lbf", 0.1, 1.0).mean, rel=1e-14)
    assert fr.AxialLoad(0.0, 1.0, 9.0, noise=q(2.0, "N^2/Hz")) == fr.AxialLoad(0.0, 1.0, 9.0, noise="2 N^2/Hz")
    assert fr.VibrationTool(q(5, "kN"), q(18, "Hz"), q(30, "m")) == fr.VibrationTool("5kN", "18Hz", "30m")
    assert rod.replace(curvature=q(3, "deg") / q(30, "m")).curvature == pytest.approx(math.radians(0.1))
    assert rod.replace(damping_rate=q(2, "1/s")).damping_rate == 2.0
    mode = fr.ToolMode(q(922, "Hz"), q(1.1, "percent"), mass=q(39.93, "g"))
    assert (mode.damping_ratio, mode.mass) == pytest.approx((0.011, 0.03993), rel=1e-14)
    path = fr.WellPath(q([0.0, 1000.0, 2000.0], "ft"), q([0.0, 45.0, 90.0], "degree"))
    assert path.depth == pytest.approx([0.0, 304.8, 609.6])
    assert path.inclination == pytest.approx([0.0, math.pi / 4.0, math.pi / 2.0])
    with pytest.raises(ValueError, match=r"mean must be a number with a force unit .*Cannot convert"):
        fr.AxialLoad(q(1, "kg"), 1.0, 1.0)
    with pytest.raises((ValueError, TypeError), match="growth_tolerance"):
        rod.stability(fr.AxialLoad(0.1, 0.1, 24.0), growth_tolerance=q(1, "m"))
