"""Quantities of pint stand wherever a string with a unit does."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod import units
from tests.conftest import depth

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


def test_arrays_do_not_drop_units() -> None:
    rod = fr.Rod(**NITINOL)
    expected = rod.growth_rate(mean=4.0, amplitude=2.0, frequency=32.0 * math.pi)
    assert expected > 1.0
    for one in (Measured(0.004, "kN"), "0.004kN", Measured(np.array(0.004), "kN"), [Measured(4.0, "N")], ["4N"]):
        found = rod.growth_rate(mean=one, amplitude=Measured(0.002, "kN"), frequency=Measured(16.0, "hertz"))
        assert np.ravel(found)[0] == pytest.approx(expected, rel=1e-12)
    for wrong in (Measured(4.0, "m"), [Measured(4.0, "m")], Measured(np.array([4.0]), "m"), "4m"):
        with pytest.raises(ValueError, match=r"mean.* must be a number with a force unit"):
            rod.is_stable(mean=wrong, amplitude=2.0, frequency=100.0)
    with pytest.raises(ValueError, match=r"mean\[1\] must be a number with a force unit"):
        rod.is_stable(mean=["4N", Measured(4.0, "m")], amplitude=2.0, frequency=100.0)
    with pytest.raises(ValueError, match=r"mean\[0\] must have a unit of force .* times rod\.critical_force"):
        rod.is_stable(mean=["0.2Fcr"], amplitude=2.0, frequency=100.0)


def test_numbers_without_unit_refuse_what_has_one() -> None:
    for value in (Measured(1.0, "N"), [Measured(1.0, "N")], Measured(np.ones(2), "N"), ([0.5, Measured(1.0, "N")],)):
        with pytest.raises(ValueError, match=r"alpha\S* must have no unit, got"):
            fr.mathieu.is_stable(value, -0.3)
    with pytest.raises(ValueError, match="alpha must have no unit, got"):
        fr.Mathieu(Measured(1.0, "N"), -0.3)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"stiffness.* must have no unit, got"):
        fr.HillSystem(Measured(np.eye(2), "N/m"))
    assert fr.Mathieu(Measured(50.0, "percent"), -0.3) == fr.Mathieu(0.5, -0.3)  # type: ignore[arg-type]
    assert fr.mathieu.is_stable([Measured(50.0, "percent")], -0.3) == fr.mathieu.is_stable([0.5], -0.3)


def test_ranges_take_texts_and_quantities() -> None:
    rod = fr.Rod(**NITINOL)
    plain = fr.stability_map(rod, mean=(0.0, 1.0, 5), amplitude=0.3, frequency=(60.0, 90.0, 4))
    for mean, amplitude, frequency in (
        (("0N", "1N", 5), "0.3N", ("60rad/s", "90rad/s", 4)),
        ((0.0, "0.001kN", 5), Measured(0.3, "N"), (Measured(60.0, "rad/s"), 90.0, 4)),
        ([0.0, "0.25N", "0.5N", 0.75, 1.0], 0.3, Measured(np.linspace(60.0, 90.0, 4), "rad/s")),
    ):
        found = fr.stability_map(rod, mean=mean, amplitude=amplitude, frequency=frequency)
        np.testing.assert_array_equal(found.stable, plain.stable)
        np.testing.assert_allclose(found.x.values, plain.x.values, rtol=1e-15)
        np.testing.assert_allclose(found.y.values, plain.y.values, rtol=1e-15)
    with pytest.raises(ValueError, match=r"mean\[1\] must be a number with a force unit"):
        fr.stability_map(rod, mean=("0N", "1m", 5), amplitude=0.3, frequency=(60.0, 90.0, 4))
    ranges = rod.ranges("mean", amplitude="0.3N", frequency="24Hz", bounds=("0.1N", Measured(1.7e-3, "kN")))
    numbers = rod.ranges("mean", amplitude=0.3, frequency=48.0 * math.pi, bounds=(0.1, 1.7))
    assert [part.low for part in ranges.intervals] == pytest.approx([part.low for part in numbers.intervals])
    for value in (0.2, 0.5, 0.9):
        assert (f"{value!r}N" in ranges) == (Measured(value, "N") in ranges) == (value in ranges)
    with pytest.raises(ValueError, match="value must be a number with a force unit"):
        _ = Measured(1.0, "m") in ranges


def test_records_keep_their_time() -> None:
    time = np.linspace(0.0, 1.0, 200)
    force = 3.0 + np.sin(2.0 * math.pi / 0.209 * time)
    plain = fr.ForceRecord(time, force)
    record = fr.ForceRecord(Measured(1e3 * time, "ms"), Measured(1e-3 * force, "kN"), frequency="30rad/s")
    assert record.period == pytest.approx(0.209, rel=1e-9)
    expected = plain.force([0.3, 0.4])
    for times in (["300ms", Measured(0.4, "s")], Measured(np.array([300.0, 400.0]), "ms"), np.array(["0.3s", "400ms"])):
        np.testing.assert_allclose(record.force(times), expected, rtol=1e-12)
    with pytest.raises(ValueError, match="time must be a number with a time unit"):
        fr.ForceRecord(Measured(time, "m"), force)


def test_hertz_are_hertz() -> None:
    for frequency in (24.0, "24Hz", Measured(24.0, "hertz"), f"{48.0 * math.pi!r}rad/s"):
        assert fr.AxialLoad.hertz(1.0, 1.0, frequency).frequency == pytest.approx(48.0 * math.pi, rel=1e-15)  # type: ignore[arg-type]
    noise = (("0Hz", "1N^2/Hz"), (Measured(20.0, "hertz"), Measured(2.0, "N^2/Hz")))
    assert fr.AxialLoad(1.0, 1.0, 1.0, noise=noise).noise == ((0.0, 1.0), (20.0, 2.0))  # type: ignore[arg-type]


kinds = st.sampled_from(
    [("force", "kN", 1e3), ("time", "ms", 1e-3), ("length", "ft", 0.3048), ("pressure", "MPa", 1e6)]
)
nested = st.recursive(st.floats(-1e6, 1e6), lambda inner: st.lists(inner, min_size=2, max_size=2), max_leaves=8)


@given(kinds, nested, st.integers(0, 2**31))
@settings(max_examples=depth(2000, 100), deadline=None)
def test_the_entrance_of_arrays_converts_each_value_however_it_is_written(
    kind: tuple[str, str, float], values: Any, seed: int
) -> None:
    """Nested lists of numbers, texts and quantities, mixed by chance; ragged ones are refused as before."""
    name, unit, size = kind
    rng = np.random.default_rng(seed)

    def plain(value: Any) -> Any:
        return [plain(each) for each in value] if isinstance(value, list) else size * value

    def mixed(value: Any) -> Any:
        if isinstance(value, list):
            return tuple(map(mixed, value)) if rng.integers(2) else [mixed(each) for each in value]
        return (size * value, f"{value!r}{unit}", Measured(value, unit), Measured(np.array(value), unit))[
            rng.integers(4)
        ]

    try:
        expected = np.array(plain(values))
    except ValueError:
        with pytest.raises(ValueError, match="x must be an array or nested lists of equal lengths"):
            units.array("x", mixed(values), name, -1e15, 1e15)
        return
    np.testing.assert_allclose(units.array("x", mixed(values), name, -1e15, 1e15), expected, rtol=1e-14)
    if isinstance(values, list) and np.ndim(expected) == 1:
        bad = mixed(values)
        at = int(rng.integers(len(values)))
        bad = [*bad[:at], Measured(1.0, "candela"), *bad[at + 1 :]]
        with pytest.raises(ValueError, match=rf"^x\[{at}\] must be a number with a {name} unit"):
            units.array("x", bad, name, -1e15, 1e15)


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
