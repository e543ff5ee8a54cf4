"""`floquetrod chart`: families of systems from files, held against the same families in Python."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod import cli
from floquetrod.cli.common import bands_listed
from floquetrod.equations.system_files import read_family
from tests.conftest import depth

EXAMPLE = Path(__file__).parents[2] / "floquetrod/examples/family.toml"
TEXT = EXAMPLE.read_text(encoding="utf-8")


def oscillators(omega: float, epsilon: float) -> fr.HillSystem:
    coupling = [[[0.5 * epsilon, epsilon], [epsilon, 0.8 * epsilon]]]
    damping = [[0.02, 0.0], [0.0, 0.04]]
    return fr.HillSystem([[1.0, 0.0], [0.0, 4.0]], coupling, damping=damping, period=2.0 * np.pi / omega)


def charted(capsys: pytest.CaptureFixture[str], tmp_path: Path, text: str, *options: str) -> tuple[Any, fr.Chart]:
    """Return what the terminal says in JSON of a family of systems, and the chart in its npz file."""
    path, out = tmp_path / "family.toml", tmp_path / "chart.npz"
    path.write_text(text, encoding="utf-8")
    assert cli.main(["chart", "--system", str(path), "--out", str(out), "--json", *options]) == 0
    return json.loads(capsys.readouterr().out), fr.Chart.load(out)


def alike(one: fr.Chart, other: fr.Chart) -> None:
    """Assert that two charts have the same axes and verdicts, and growth to rounding: texts have 17 digits."""
    for axis, same in ((one.x, other.x), (one.y, other.y)):
        assert (axis.name, axis.symbol) == (same.name, same.symbol)
        assert axis.values == pytest.approx(same.values, rel=1e-15)
    assert one.stable.tolist() == other.stable.tolist()
    assert one.undecided == other.undecided
    assert (one.growth_rate is None) == (other.growth_rate is None)
    if one.growth_rate is not None and other.growth_rate is not None:
        assert np.abs(one.growth_rate - other.growth_rate).max() < 1e-10


def test_the_example_is_the_chart_of_the_same_function(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    said, chart = charted(capsys, tmp_path, TEXT, "--points", "13x7", "--growth", "--pixels")
    expected = fr.chart(oscillators, over={"omega": (1.5, 4.5, 13), "epsilon": (0.0, 0.6, 7)}, growth=True)
    alike(chart, expected)
    assert said["stable_share"] == expected.stable.mean()
    assert said["undecided"] == 0
    assert said["bands"] is None
    assert said["written"] == [str(tmp_path / "chart.npz")]
    assert not chart.stable.all()


@pytest.mark.slow
def test_bands_are_found_unless_pixels_are_wanted(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    vertices = tmp_path / "bands.csv"
    columns, rows = depth(13, 7), depth(7, 4)
    said, chart = charted(capsys, tmp_path, TEXT, "--points", f"{columns}x{rows}", "--out", str(vertices))
    expected = fr.chart(oscillators, over={"omega": (1.5, 4.5, columns), "epsilon": (0.0, 0.6, rows)}).find_bands()
    assert said["bands"] == len(chart.bands) == len(expected) > 1
    for band, same in zip(chart.bands, expected, strict=True):
        assert np.abs(band.x - same.x).max() < 1e-9
        assert np.abs(band.y - same.y).max() < 1e-9
    assert vertices.stat().st_size > 500
    for listed, band in zip(said["unstable"], chart.bands, strict=True):
        assert (listed["name"], listed["mode"], listed["partner"], listed["tongue"]) == (
            band.name,
            band.mode,
            band.partner,
            band.tongue,
        )
        assert (listed["omega"], listed["epsilon"]) == ([band.x.min(), band.x.max()], [band.y.min(), band.y.max()])
        assert listed["largest_growth_per_unit_time"] == pytest.approx(band.largest_growth)
    text = bands_listed(chart.bands)
    assert text.startswith(chart.bands.caption)
    fastest = max(chart.bands, key=lambda band: band.largest_growth)
    assert text.splitlines()[3].startswith(fastest.name)
    assert len(text.splitlines()) == 3 + len(chart.bands)
    first = chart.bands.bands[0]
    shifted = replace(first, x=first.x - first.x.min() + 3e-13)  # from zero, but for an error of rounding
    assert "  0 to " in bands_listed(replace(chart.bands, bands=(shifted,)))
    before = str(chart)
    chart.plot()
    assert str(chart) == before


def test_growth_up_to_a_tolerance_counts_as_stable(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    over = {"omega": (1.5, 4.5, 13), "epsilon": (0.0, 0.6, 7)}
    for tolerance in (0.05, 1.0):
        _, chart = charted(capsys, tmp_path, TEXT, "--points", "13x7", "--pixels", "--growth-tolerance", str(tolerance))
        alike(chart, fr.chart(oscillators, over, growth_tolerance=tolerance))
    assert chart.stable.all()


# --- drawn families ---


def entry(rng: np.random.Generator, scale: float) -> tuple[str, Callable[[float, float], float]]:
    """Return an entry of a matrix as a file has it, and as a function of both parameters."""
    c, d = (scale * rng.uniform(-1.0, 1.0, 2)).round(4).tolist()
    texts: list[tuple[str, Callable[[float, float], float]]] = [
        (f"{c!r}", lambda mu, nu: c),
        (f'"{c!r}*mu"', lambda mu, nu: c * mu),
        (f'"{c!r} * sin(nu) + {d!r}*mu**2"', lambda mu, nu: c * np.sin(nu) + d * mu**2),
        (f'"({c!r} - nu*{d!r})/(1 + mu)"', lambda mu, nu: (c - nu * d) / (1 + mu)),
    ]
    return texts[rng.integers(4)]


class Matrix:
    """A matrix of drawn entries, as text and as a function."""

    def __init__(self, rng: np.random.Generator, n: int, scale: float, diagonal: float = 0.0) -> None:
        entries = [[entry(rng, scale) for _ in range(n)] for _ in range(n)]
        entries[0][1] = (f'"{scale!r}*mu*nu"', lambda mu, nu: scale * mu * nu)  # both occur
        shift = [
            [f'"{diagonal * (i + 1)!r} + 0.1*nu"' if i == j and diagonal else "" for j in range(n)] for i in range(n)
        ]
        rows = [[shift[i][j] or entries[i][j][0] for j in range(n)] for i in range(n)]
        self.text = "[" + ", ".join(f"[{', '.join(row)}]" for row in rows) + "]"
        self.value = lambda mu, nu: [
            [diagonal * (i + 1) + 0.1 * nu if shift[i][j] else entries[i][j][1](mu, nu) for j in range(n)]
            for i in range(n)
        ]


PARAMETERS = '[parameters]\nmu = "0.1:0.9"\nnu = "1 : pi"\n'
OVER = {"mu": (0.1, 0.9, 4), "nu": (1.0, np.pi, 3)}


def family(kind: str, rng: np.random.Generator) -> tuple[str, Callable[..., Any]]:
    """Return a family of a kind as a file and as a function."""
    n = int(rng.integers(2, 4))
    a, b = Matrix(rng, n, 0.3, 1.5), Matrix(rng, n, 0.2)
    if kind == "second order":
        text = f'[system]\nstiffness = {a.text}\nsines = [{b.text}]\nfrequency = "nu*2"\n'
        return text, lambda mu, nu: fr.HillSystem(a.value(mu, nu), sines=[b.value(mu, nu)], period=2 * np.pi / (nu * 2))
    if kind == "complex":
        mean = '[["-0.1 + i*mu", "0.3i*nu"], ["0.2i", "-0.2"]]'
        text = f'[system]\nmean = {mean}\ncosines = [[["mu*i", 0], [0, 0.4]]]\nperiod = "nu"\n'
        return text, lambda mu, nu: fr.PeriodicSystem(
            [[-0.1 + 1j * mu, 0.3j * nu], [0.2j, -0.2]], [[[mu * 1j, 0], [0, 0.4]]], period=nu
        )
    if kind == "delay":
        text = f'[system]\nmean = {b.text}\nperiod = "2s"\ncosines = [{b.text}]\n'
        term = f'[[system.delayed]]\ndelay = "nu/2"\nmatrix = {b.text}\n'
        return text + term, lambda mu, nu: fr.DelaySystem.first_order(
            b.value(mu, nu), [b.value(mu, nu)], period=2.0, delayed=[(nu / 2, b.value(mu, nu))]
        )
    pieces = [("nu", a), ("0.5s", b)]
    text = "".join(f'[[system.pieces]]\nduration = "{time}"\nstiffness = {matrix.text}\n' for time, matrix in pieces)
    return text, lambda mu, nu: fr.HillSystem.from_pieces([(nu, a.value(mu, nu)), (0.5, b.value(mu, nu))])


@pytest.mark.parametrize("kind", ["second order", "complex", "delay", "pieces"])
def test_drawn_families_have_the_same_chart_in_the_terminal_and_in_python(
    kind: str, rng: np.random.Generator, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for _ in range(depth(12, 2)):
        text, function = family(kind, rng)
        _, chart = charted(capsys, tmp_path, text + PARAMETERS, "--points", "4x3", "--growth", "--pixels")
        alike(chart, fr.chart(function, over=OVER, growth=True))


@pytest.mark.parametrize(
    ("value", "expected"), [("2*pi*1.5", 3.0 * np.pi), ("omega*2/3", 3.4 / 3.0), ("2**2*omega", 6.8), ("2*omega", 3.4)]
)
def test_a_frequency_may_be_a_formula_that_begins_with_a_number(value: str, expected: float, tmp_path: Path) -> None:
    (tmp_path / "family.toml").write_text(TEXT.replace('frequency = "omega"', f'frequency = "{value} + 0*omega"'))
    system = read_family(tmp_path / "family.toml").system(omega=1.7, epsilon=0.1)
    assert 2.0 * np.pi / system.period == pytest.approx(expected, rel=1e-14)


# --- files that are none ---


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[parameters]", "[parameter]", "unknown key 'parameter'; did you mean parameters?"),
        ('omega = "1.5:4.5"', "omega = 1.5", "two parameters must have ranges such as \"1.5:4.5\", got epsilon"),
        ("zeta = 0.01", 'zeta = "0:0.1"', "two parameters must have ranges"),
        ('"1.5:4.5"', '"4.5:1.5"', "omega must be a number or a range from less to more"),
        ('"1.5:4.5"', '"1.5:4.5:9"', "omega must be a number or a range from less to more"),
        ('"1.5:4.5"', '"1.5Hz:4.5Hz"', "omega must be a number without a unit, or a formula of numbers such as 2*pi"),
        ("zeta = 0.01", "zeta = true", "zeta must"),
        ("zeta = 0.01", "zeta = nan", "zeta must"),
        ("zeta = 0.01", "pi = 3", "must have names of letters such as omega"),
        ("zeta = 0.01", "zeta = 0.01\nextra = 1", "no formula of the system has the parameter 'extra'"),
        ('"4*zeta"', '"4*zet"', "got '4*zet' has 'zet', which is no parameter; did you mean zeta?"),
        ('"4*zeta"', '"__import__(\'os\').system(\'touch harm\')"', "not a formula"),
        ('"4*zeta"', '"2i"', "not a formula"),
        ('"2*zeta"', '"sqrt(omega - 2)"', "family(omega=1.5, epsilon=0) raised ValueError"),
        ('frequency = "omega"', 'frequency = "omega - 3"', "frequency must"),
        ("stiffness", "stiffnes", "did you mean stiffness"),
        ("[system]", "[sytem]", "unknown key 'sytem'; did you mean system?"),
        ("[system]", "[system", "cannot be read"),
    ],
)  # fmt: skip
def test_bad_files_are_refused(
    old: str,
    new: str,
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert old in TEXT
    path = tmp_path / "my_family.toml"
    path.write_text(TEXT.replace(old, new), encoding="utf-8")
    assert cli.main(["chart", "--system", str(path), "--points", "4x3", "--pixels"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("floquetrod: error: ")
    assert len(said.splitlines()) == 1
    assert message in said
    assert sorted(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "the following arguments are required: --system"),
        (["--system", "missing.toml"], "--system must be a TOML file, got 'missing.toml': there is no such file"),
        (["--system", str(EXAMPLE.with_name("system.toml"))], "it has no table [parameters]"),
        (["--system", str(EXAMPLE), "--points", "7"], "--points must be columns x rows"),
        (["--system", str(EXAMPLE), "--points", "61 41"], "got '61 41'; write 61x41"),
        (["--system", str(EXAMPLE), "--points", "61,41"], "got '61,41'; write 61x41"),
        (["--system", str(EXAMPLE), "--points", "61", "41"], "'41' belongs to no option; did you mean --points 61x41?"),
        (["--system", str(EXAMPLE), "--out", "chart.doc"], "--out must end in"),
        (["--system", str(EXAMPLE), "--pixels", "--out", "bands.csv"], "leave out --pixels"),
        (["--system", str(EXAMPLE), "--growth-tolerance", "-1"], "--growth-tolerance must"),
    ],
)
def test_bad_options_are_refused(words: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["chart", *words]) == 2
    assert message in capsys.readouterr().err


def test_check_says_which_command_takes_a_family(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["check", "--system", str(EXAMPLE)]) == 2
    assert "give it one, in the terminal --set omega=3, or draw them all by floquetrod chart" in capsys.readouterr().err
