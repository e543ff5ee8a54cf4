"""Quantities as people write them."""

from __future__ import annotations

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from floquetrod.units import kind_of, label, quantity, unit, unit_of, units_of
from floquetrod.units.table import UNITS, _folded, meant


@given(st.floats(-1e6, 1e6, allow_nan=False))
def test_a_number_alone_is_in_the_si_unit(value: float) -> None:
    assert quantity(repr(value), "mean", "force") == value
    assert quantity(value, "mean", "force") == value
    assert quantity(f" {value!r} kN ", "mean", "force") == pytest.approx(1e3 * value)


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("24Hz", "frequency", 48.0 * math.pi),
        ("150 rad/s", "frequency", 150.0),
        ("60rpm", "frequency", 2.0 * math.pi),
        ("0.8mm", "length", 0.8e-3),
        ("68GPa", "pressure", 68e9),
        ("6.5g/cm3", "density", 6500.0),
        ("-.5e-1N", "force", -0.05),
        ("0.2Fcr", "force", 0.4),
        ("3/s", "rate", 3.0),
        ("2.5us", "time", 2.5e-6),
        ("2.375in", "length", 0.060325),
        ("10ft", "length", 3.048),
        ("100 lbf", "force", 444.82216152605),
        ("1psi", "pressure", 6894.757293168),
        ("80ksi", "pressure", 80e3 * 6894.757293168),
        ("30Mpsi", "pressure", 30e6 * 6894.757293168),
        ("29.5 Msi", "pressure", 29.5e6 * 6894.757293168),
        ("29.5MSI", "pressure", 29.5e6 * 6894.757293168),
        ("8.6 lb/gal", "density", 8.6 * 0.45359237 / (231 * 0.0254**3)),
        ("8.6ppg", "density", 8.6 * 0.45359237 / (231 * 0.0254**3)),
        ("60deg", "angle", math.radians(60.0)),
        ("1.5", "angle", 1.5),
        ("2.29", "ratio", 2.29),
        ("3deg/30m", "curvature", math.radians(0.1)),
        ("3deg/100m", "curvature", math.radians(0.03)),
        ("3 \N{DEGREE SIGN} / 100 ft", "curvature", math.radians(3.0) / 30.48),
        # In any case but that of M for mega and m for milli.
        ("0.2FCR", "force", 0.4),
        ("3KN", "force", 3e3),
        ("24hz", "frequency", 48.0 * math.pi),
        ("60RPM", "frequency", 2.0 * math.pi),
        ("2IN", "length", 0.0508),
        ("30MPSI", "pressure", 30e6 * 6894.757293168),
        ("68gpa", "pressure", 68e9),
        ("68MPA", "pressure", 68e6),
        ("8.6PPG", "density", 8.6 * 0.45359237 / (231 * 0.0254**3)),
        ("60Deg", "angle", math.radians(60.0)),
        ("2MN", "force", 2e6),
        ("2mn", "force", 2e-3),
        ("7850KG/M3", "density", 7850.0),
        # As people write them.
        ("3lb", "force", 3.0 * 4.4482216152605),
        ("2kips", "force", 2e3 * 4.4482216152605),
        ("2 hertz", "frequency", 4.0 * math.pi),
        ("1kHz", "frequency", 2e3 * math.pi),
        ("150rad/sec", "frequency", 150.0),
        ('2.375"', "length", 0.060325),
        ("2 inches", "length", 0.0508),
        ("30 feet", "length", 9.144),
        ("0.284 lb/in3", "density", 0.284 * 0.45359237 / 0.0254**3),
        ("490lb/ft3", "density", 490.0 * 0.45359237 / 0.3048**3),
        ("32.174ft/s2", "acceleration", 32.174 * 0.3048),
        ("207e3 N/mm2", "pressure", 207e9),
        ("60\N{DEGREE SIGN}", "angle", math.radians(60.0)),
        ("800\N{MICRO SIGN}m", "length", 800e-6),
        ("800\N{GREEK SMALL LETTER MU}m", "length", 800e-6),
        ("7850kg/m\N{SUPERSCRIPT THREE}", "density", 7850.0),
        ("9.81 m/s\N{SUPERSCRIPT TWO}", "acceleration", 9.81),
        ("20%", "force", 0.4),
        ("30 %", "ratio", 0.3),
        ("3/4in", "length", 0.75 * 0.0254),
        ("2-3/8in", "length", 2.375 * 0.0254),
        ("9500ft 6in", "length", 9500.5 * 0.3048),
        ("-3000'6\"", "length", -3000.5 * 0.3048),
        ("12 feet 1.5 inches", "length", 12.125 * 0.3048),
        ("2 3/8in", "length", 2.375 * 0.0254),
        ('2 - 3/8 "', "length", 2.375 * 0.0254),
        ("-1/2 IN", "length", -0.0127),
        ("1/2ft", "length", 0.1524),
    ],
)
def test_units(text: str, kind: str, value: float) -> None:
    assert quantity(text, "x", kind, critical_force=2.0) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["1.1/2in", "3/4", "2-3/8", "2 3/8", "3/4m", "1/0in", "1/2'"])
def test_other_slashes_are_told_how_fractions_are_written(text: str) -> None:
    with pytest.raises(ValueError, match="fractions are those of inches and feet, such as 3/4in, 2-3/8in or 2 3/8in"):
        quantity(text, "diameter", "length")
    assert unit_of("2-3/8in") == "in"


@pytest.mark.parametrize("text", ["", "N", "1 2", "0x10", "nan", "inf", "1Fxr", "1 kg", "\u0663", None, [1], True])
def test_anything_else_is_refused_with_what_is_accepted(text: object) -> None:
    with pytest.raises(
        ValueError,
        match=r"^--mean must be a number with a force unit \(N, kN, .*, klbf, kip, kgf, tf; none means N\)",
    ):
        quantity(text, "--mean", "force")


@pytest.mark.parametrize(
    ("text", "kind"),
    [("1Mlbf", "force"), ("1mpa", "pressure"), ("1mpsi", "pressure"), ("1Mm", "length"), ("1Ms", "time")],
)
def test_the_case_of_mega_and_milli_counts(text: str, kind: str) -> None:
    with pytest.raises(ValueError, match="is not understood"):
        quantity(text, "x", kind)


@pytest.mark.parametrize("kind", UNITS)
def test_no_two_units_of_a_kind_differ_by_case_alone(kind: str) -> None:
    names = [_folded(name) for name in units_of(kind, 1.0)]
    assert len(set(names)) == len(names)
    assert [meant(name, units_of(kind, 1.0)) for name in units_of(kind, 1.0)] == list(units_of(kind, 1.0))


def test_units_are_shown_as_they_are_written_here() -> None:
    assert unit("HZ", "x", "frequency").name == "Hz"
    assert (kind_of("HZ"), kind_of("LBF"), kind_of("fcr"), kind_of(""), kind_of("mn")) == (
        ("frequency", "force", "force", None, "force")
    )


@given(st.integers(0, 10**6), st.integers(1, 9))
def test_a_percentage_is_the_same_number_as_the_share_in_decimals(digits: int, places: int) -> None:
    percent = f"{digits // 10**places}.{digits % 10**places:0{places}d}"
    assert quantity(f"{percent}%", "friction", "ratio") == float(f"{percent}e-2")


def test_a_percentage_is_one_of_what_is_known() -> None:
    assert quantity("1%", "length", "length", nominal=3.1) == pytest.approx(0.031, rel=1e-15)
    assert quantity("1%", "mean", "force", nominal=3.0, critical_force=2.0) == pytest.approx(0.03, rel=1e-15)
    assert unit("%", "mean", "force", 2.0).name == "Fcr"
    assert unit("%", "length", "length").name == "m"
    for text, kind, known, message in (
        ("5%", "frequency", {}, "unit '%' is not understood; a percentage needs something it is a part of"),
        ("5%", "force", {}, "unit '%' is not understood; a percentage needs something it is a part of"),
        ("5%", "rate", {"nominal": 0.0}, "x must not be a percentage of zero, got '5%'; give a number with its unit"),
        ("-1%", "force", {"critical_force": 2.0, "least": 0.0}, "x must be zero or more, got '-1%'"),
    ):
        with pytest.raises(ValueError, match=re.escape(message)):
            quantity(text, "x", kind, **known)


@pytest.mark.parametrize(
    ("text", "kind", "hint"),
    [
        ("24herz", "frequency", "; did you mean hertz?"),
        ("68gpascal", "pressure", "unit 'gpascal' is not understood"),
        ("1mpa", "pressure", "; did you mean MPa?"),
        ("24N", "frequency", "; it is a unit of force"),
        ("0,2N", "force", "a comma is not understood; write a point"),
        ("1,000", "force", "a comma is not understood; write a point"),
    ],
)
def test_what_may_be_meant_is_named(text: str, kind: str, hint: str) -> None:
    with pytest.raises(ValueError, match=re.escape(hint)):
        quantity(text, "x", kind)


def test_a_ratio_has_no_unit() -> None:
    with pytest.raises(
        ValueError,
        match=r"^x must be a number with no unit, got '2 m': unit 'm' is not understood; it is a unit of length$",
    ):
        quantity("2 m", "x", "ratio")


def test_an_integer_beyond_a_double_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^length must be finite, got an integer beyond 1e308$"):
        quantity(10**400, "length", "length")


def test_fcr_needs_a_rod() -> None:
    with pytest.raises(ValueError, match=r"mean must have a unit of force .* times rod\.critical_force"):
        quantity("1Fcr", "mean", "force")


@pytest.mark.parametrize(
    ("text", "bounds", "message"),
    [
        ("1e400N", {}, "--mean must be finite, got '1e400N'"),
        ("1e308kN", {}, "--mean must be finite, got '1e308kN'"),
        ("-1e400", {"least": 0.0}, "--mean must be finite, got '-1e400'"),
        ("0", {"least": 1e-9}, "--mean must be greater than zero, got '0'"),
        ("1e-400N", {"least": 1e-9}, "--mean must be greater than zero, got '1e-400N'"),
        ("-1kN", {"least": 0.0}, "--mean must be zero or more, got '-1kN'"),
        ("5kN", {"least": 0.0, "largest": 1e3}, "--mean must lie between 0 and 1000 N, got '5kN'; check its unit"),
        (float("nan"), {}, "--mean must be finite, got nan"),
    ],
)
def test_bounds_quote_what_was_typed(text: object, bounds: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        quantity(text, "--mean", "force", **bounds)


@pytest.mark.parametrize(
    ("value", "bounds", "message"),
    [
        (50, (1e-6, 1.0), 'x must lie between 1e-06 and 1, got 50; write "50%" for percent'),
        ("12.5", (0.0, 0.999), "x must lie between 0 and 0.999, got '12.5'; write \"12.5%\" for percent"),
        ("150%", (0.0, 1.0), "x must lie between 0 and 1, got '150%'"),
        (1.2, (0.0, 1.0), "x must lie between 0 and 1, got 1.2"),
        (5000, (0.0, 1.0), "x must lie between 0 and 1, got 5000"),
        (50, (0.6, 1.0), "x must lie between 0.6 and 1, got 50"),
        (-50, (-1.0, 1.0), "x must lie between -1 and 1, got -50"),
    ],
)
def test_what_has_no_unit_is_led_to_percent(value: object, bounds: tuple[float, float], message: str) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        quantity(value, "x", "ratio", least=bounds[0], largest=bounds[1])
    if "write" in message:
        assert bounds[0] <= quantity(re.findall('"(.*)"', message)[0], "x", "ratio") <= bounds[1]


@given(st.floats(-1e6, 1e6), st.sampled_from(["Hz", "rpm", "rad/s", "1/s"]))
def test_a_unit_shows_what_quantity_reads(value: float, name: str) -> None:
    shown = unit(name, "x", "frequency")
    assert shown.of(quantity(f"{value!r} {name}", "x", "frequency")) == pytest.approx(value)
    assert quantity(shown.show(value, 17), "x", "frequency") == pytest.approx(value)
    assert shown.si(shown.of(value)) == pytest.approx(value)


def test_an_unknown_unit_is_refused_with_what_is_known() -> None:
    with pytest.raises(
        ValueError,
        match=r"^--unit must be a unit of force \(N, kN, .*, tf, Fcr\), got 'Hz'; it is a unit of frequency$",
    ):
        unit("Hz", "--unit", "force", 2.0)
    assert unit("", "x", "force").name == "N"


@pytest.mark.parametrize(
    ("name", "expected"),
    [("Hz", r"f $\omega/2\pi$ / Hz"), ("rad/s", r"f $\omega$ / (rad/s)"), ("Fcr", r"f $\omega$ / $F_\mathrm{cr}$")],
)
def test_labels(name: str, expected: str) -> None:
    assert label("f", r"\omega", name) == expected
