"""Units of muds, strings and wells: against definitions, as they are written, and a rod given by its weight."""

from __future__ import annotations

import json
import math
import re
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.cli.main import main
from floquetrod.units import heading, is_unit, quantity, unit, units_of

INCH, POUND, GRAVITY = Fraction(254, 10_000), Fraction(45_359_237, 100_000_000), Fraction(980_665, 100_000)
FOOT = 12 * INCH  # the international foot, 1959
FORCE = POUND * GRAVITY  # the pound-force, by the standard acceleration of gravity (ISO 80000-3)
GALLON = 231 * INCH**3  # the US gallon
PSI, TURN = FORCE / INCH**2, 2.0 * math.pi
DEFINITIONS: dict[str, dict[str, Fraction | float]] = {
    "force": {
        "N": 1, "kN": 1000, "MN": 10**6, "mN": Fraction(1, 1000), "daN": 10, "lbf": FORCE, "klbf": 1000 * FORCE,
        "kip": 1000 * FORCE, "kgf": GRAVITY, "tf": 1000 * GRAVITY,
    },
    "frequency": {
        "rad/s": 1, "1/s": 1, "Hz": TURN, "kHz": 1e3 * TURN, "MHz": 1e6 * TURN, "GHz": 1e9 * TURN, "rpm": TURN / 60,
    },
    "time": {"s": 1, "ms": Fraction(1, 1000), "us": Fraction(1, 10**6), "min": 60, "h": 3600},
    "length": {
        "m": 1, "mm": Fraction(1, 1000), "cm": Fraction(1, 100), "um": Fraction(1, 10**6), "km": 1000, "in": INCH,
        "ft": FOOT, "ftUS": Fraction(1200, 3937),
    },
    "mass": {"kg": 1, "g": Fraction(1, 1000), "mg": Fraction(1, 10**6), "lb": POUND},
    "stiffness": {"N/m": 1, "N/mm": 1000, "kN/m": 1000, "N/um": 10**6, "MN/m": 10**6, "lbf/in": FORCE / INCH},
    "pressure": {
        "Pa": 1, "kPa": 1000, "MPa": 10**6, "GPa": 10**9, "bar": 10**5, "psi": PSI, "ksi": 1000 * PSI,
        "Mpsi": 10**6 * PSI, "Msi": 10**6 * PSI,
    },
    "density": {
        "kg/m3": 1, "kg/m^3": 1, "g/cm3": 1000, "g/cm^3": 1000, "g/cc": 1000, "kg/l": 1000, "sg": 1000,
        "lb/gal": POUND / GALLON, "ppg": POUND / GALLON, "lb/ft3": POUND / FOOT**3, "pcf": POUND / FOOT**3,
        "lb/in3": POUND / INCH**3, "psi/ft": PSI / FOOT / GRAVITY, "kPa/m": 1000 / GRAVITY, "bar/m": 10**5 / GRAVITY,
    },
    "weight": {
        "N/m": 1, "kN/m": 1000, "daN/m": 10, "kg/m": GRAVITY, "kgf/m": GRAVITY, "lb/ft": FORCE / FOOT,
        "lbf/ft": FORCE / FOOT, "ppf": FORCE / FOOT,
    },
    "acceleration": {"m/s2": 1, "m/s^2": 1, "ft/s2": FOOT},
    "rate": {"1/s": 1, "/s": 1},
    "speed": {
        "m/s": 1, "cm/s": Fraction(1, 100), "mm/s": Fraction(1, 1000), "ft/s": FOOT, "in/s": INCH,
        "m/min": Fraction(1, 60), "ft/min": FOOT / 60, "m/h": Fraction(1, 3600), "ft/h": FOOT / 3600,
    },
    "angle": {"rad": 1, "deg": TURN / 360},
    "curvature": {
        "1/m": 1, "rad/m": 1, "deg/m": TURN / 360, "deg/10m": TURN / 3600, "deg/30m": TURN / 10_800,
        "deg/100m": TURN / 36_000, "deg/100ft": TURN / 360 / float(100 * FOOT),
    },
    "force density": {
        "N^2/Hz": 1, "N2/Hz": 1, "kN^2/Hz": 10**6, "mN^2/Hz": Fraction(1, 10**6), "lbf^2/Hz": FORCE**2,
    },
}  # fmt: skip
EVERY = [(kind, name) for kind, sizes in DEFINITIONS.items() for name in sizes]


def test_every_unit_has_its_definition_here() -> None:
    for kind, sizes in DEFINITIONS.items():
        assert units_of(kind).keys() == sizes.keys()


@pytest.mark.parametrize("kind", DEFINITIONS)
def test_units_have_the_size_of_their_definition(kind: str) -> None:
    for name, size in DEFINITIONS[kind].items():
        digits = 6e-14 if re.search("[pkM]si", name) else 4e-16  # a pound over a square inch is kept with 13 digits
        assert units_of(kind)[name] == pytest.approx(float(size), rel=digits)


@given(st.sampled_from(EVERY), st.floats(1e-6, 1e6))
def test_a_quantity_reads_what_a_unit_shows(of: tuple[str, str], value: float) -> None:
    kind, name = of
    shown = unit(name, "x", kind)
    assert quantity(shown.show(value, 17), "x", kind) == pytest.approx(value, rel=1e-15)
    assert quantity(f"{value!r} {name.upper() if name[0] not in 'mM' else name}", "x", kind) == pytest.approx(
        shown.si(value), rel=1e-15
    )


@pytest.mark.parametrize(
    ("text", "kind", "same"),
    [
        ("1.2sg", "density", "1200kg/m3"),
        ("1.2 S.G.", "density", "1200kg/m3"),
        ("0.5 psi / ft", "density", "0.5psi/ft"),
        ("62.4pcf", "density", "62.4lb/ft3"),
        ("10.2 lbm/gal", "density", "10.2ppg"),
        ("1.2KG/L", "density", "1.2g/cc"),
        ("40fpm", "speed", "40ft/min"),
        ("12 m/hr", "speed", "12m/h"),
        ("30 M/min", "speed", "30m/min"),
        ("12klbs", "force", "12kip"),
        ("3kp", "force", "3kgf"),
        ("500 daN", "force", "5kN"),
        ("1200 metres", "length", "1200m"),
        ("1200 Meters", "length", "1.2km"),
        ("1 foot", "length", "1ft"),
        ("1200mRKB", "length", "1200m"),
        ("3937usft", "length", "1200m"),
        ("90\N{MASCULINE ORDINAL INDICATOR}", "angle", "90deg"),
        ("90\N{RING ABOVE}", "angle", "90deg"),
        ("3\N{RING ABOVE}/30m", "curvature", "3deg/30m"),
        ("19.5 #/ft", "weight", "19.5ppf"),
        ("2 hours", "time", "120min"),
    ],
)
def test_units_as_people_write_them(text: str, kind: str, same: str) -> None:
    assert quantity(text, "x", kind) == pytest.approx(quantity(same, "x", kind), rel=1e-15)


@pytest.mark.parametrize("text", ["m RKB", "mMD", "mRKB", "M", "METRES", "m MD RKB", "m-KB", "meters MD"])
def test_lengths_may_name_their_datum(text: str) -> None:
    assert is_unit(text, "length")
    assert unit(text, "depth_unit", "length").name == "m"
    assert heading(f"Depth ({text})", "length") == ("Depth", text)


@pytest.mark.parametrize(
    "text", ["MD", "RKB", "mTVD", "m TVDSS", "km RKB", "min", "ftmd x", "tonf", "bbl", "Nm", "m/hour RKB", "mPa"]
)
def test_other_words_are_no_lengths(text: str) -> None:
    assert not is_unit(text, "length")


# --- weight ---

TUBE = {"diameter": "5in", "inner_diameter": "4.276in", "length": "30m", "channel_diameter": "8.5in"}


@given(st.floats(10.0, 40.0), st.sampled_from(["lb/ft", "ppf", "lbf/ft"]))
def test_a_rod_given_by_its_weight_has_the_density_of_that_mass_per_length(pounds: float, name: str) -> None:
    rod = fr.Rod(207e9, weight=f"{pounds!r}{name}", fluid_inside="1.2sg", fluid_outside="1.2sg", **TUBE)
    kilograms = pounds * float(POUND / FOOT)
    assert rod.mass_along == pytest.approx(kilograms, rel=1e-14)
    assert rod.replace(weight=f"{kilograms!r}kg/m").density == pytest.approx(rod.density, rel=1e-14)
    same = fr.Rod(207e9, rod.density, fluid_inside=1200.0, fluid_outside=1200.0, **TUBE)
    assert same == rod
    assert rod.weight_per_length == pytest.approx(
        9.81 * (kilograms + 1200.0 * (rod.section.inner_area - rod.section.outer_area)), rel=1e-13
    )


def test_weight_in_python_in_a_file_and_in_the_terminal(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    pipe = fr.Rod.catalogue("5.00x0.362 S135", bore="8.5in", length="30m", weight="22.6lb/ft")
    assert pipe.mass_along == pytest.approx(22.6 * float(POUND / FOOT), rel=1e-14)
    file = tmp_path / "pipe.toml"
    file.write_text('catalogue = "5.00x0.362 S135"\nbore = "8.5in"\nlength = "30m"\nweight = "22.6lb/ft"\n', "utf-8")
    assert fr.Rod.from_toml(file) == pipe
    file.write_text(
        'youngs_modulus = "207GPa"\nweight = "22.6lb/ft"\ndiameter = "5in"\nwall_thickness = "0.362in"\n'
        'channel_diameter = "8.5in"\nlength = "30m"\nyield_strength = "135ksi"\n',
        "utf-8",
    )
    assert fr.Rod.from_toml(file).density == pytest.approx(pipe.density, rel=1e-14)
    load = ["--mean", "0.3Fcr", "--amplitude", "0.1Fcr", "--frequency", "4Hz", "--json", "--no-margins"]
    by_name = ["--rod", "5.00x0.362 S135", "--bore", "8.5in", "--length", "30m"]
    answers = []
    for words in ([*by_name, "--weight", "22.6lb/ft"], ["--rod", str(file), "--weight", "33.632505kg/m"], by_name):
        assert main(["check", *words, *load]) == 0
        answers.append(json.loads(capsys.readouterr().out)["rod"]["density"])
    assert answers[0] == pipe.density
    assert answers[1] == pytest.approx(pipe.density, rel=1e-6)
    assert answers[2] == 7850.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"density": 7850.0}, "weight must not be given with density, got '22lb/ft' and 7850.0; give one of them"),
        ({"weight": "0lb/ft"}, "weight must be greater than zero"),
        ({"weight": "22lb"}, "weight must be a number with a weight unit .*; did you mean|it is a unit of"),
        ({"weight": "22kg/m3"}, "unit 'kg/m3' is not understood; it is a unit of density"),
        ({"inner_diameter": "5in"}, "inner_radius must be less than the outer radius"),
    ],
)
def test_a_wrong_weight_is_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fr.Rod(207e9, **{"weight": "22lb/ft", **TUBE, **change})  # type: ignore[arg-type]


def test_without_density_or_weight_both_are_named() -> None:
    with pytest.raises(TypeError, match=r"^density must be given, in kg/m3, or weight, or sections$"):
        fr.Rod(207e9, **TUBE)  # type: ignore[arg-type]
