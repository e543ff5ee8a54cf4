"""The pages of the site: what they state is checked, a false statement stops the build, and links lead somewhere."""

from __future__ import annotations

import ast
import re
import runpy
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
WRITTEN = [path for path in sorted(DOCS.rglob("*.md")) if not {"_build", "gallery"} & set(path.relative_to(DOCS).parts)]
PAGES = [path.relative_to(DOCS).as_posix() for path in WRITTEN if "{code-cell}" in path.read_text(encoding="utf-8")]
# Signs and factors wrong, one at a time, in each derivation: page, what it says, what it must not.
MISTAKES = [
    ("theory/rod.md", "(-1, height)", "(1, height)"),
    ("theory/real_rods.md", "(1 - kappa * r * sp.cos(phi))", "(1 + kappa * r * sp.cos(phi))"),
    ("theory/real_rods.md", "+ F * theta.diff(s) ** 2", "- F * theta.diff(s) ** 2"),
    ("theory/real_rods.md", "sp.cos(k * (L - s)) / sp.cos(k * L)", "sp.cos(k * (L - s)) / sp.sin(k * L)"),
    ("theory/real_rods.md", "-4 * slope * i * j", "4 * slope * i * j"),
    ("how_to/well.md", "return 4.0 * mass * half", "return 2.0 * mass * half"),
    ("theory/floquet.md", "u.diff(tau, 2) - (p + c**2) * u", "u.diff(tau, 2) - (p - c**2) * u"),
    ("theory/hill.md", "chain(1, 5, shift=-q)", "chain(1, 5, shift=q)"),
    ("theory/systems.md", "2 * I + 4 * b.T * c", "2 * I - 4 * b.T * c"),
    ("theory/systems.md", "s + c2 - sp.I * D / 2", "s + c2 + sp.I * D / 2"),
    ("theory/systems.md", "(c1 + c2) ** 2 * (G2 / (c1 * c2) - 1)", "(c1 + c2) ** 2 * (G2 / (c1 * c2) + 1)"),
    ("theory/square_wave.md", "(p / q - q / p)", "(p / q + q / p)"),
    ("theory/leapfrog.md", "w + w**3 * h**2 / 24", "w - w**3 * h**2 / 24"),
    ("theory/friction.md", "A * (psi.diff(tau) - 2 * c * psi)", "A * (psi.diff(tau) + 2 * c * psi)"),
    ("theory/friction.md", "(-2 * c * W + S)", "(-2 * c * W - S)"),
    ("theory/friction.md", "(1 - p * at) / S", "(1 + p * at) / S"),
    ("theory/friction.md", "excess = d - a * t**2", "excess = d + a * t**2"),
    ("theory/friction.md", "2 / sp.pi * sp.sin(u)", "4 / sp.pi * sp.sin(u)"),
    ("theory/friction.md", "found[dz] - sp.I * sigma", "found[dz] + sp.I * sigma"),
    ("theory/simulator.md", "E * I * k**2 - rho * I * w2", "E * I * k**2 + rho * I * w2"),
    ("theory/simulator.md", "- (x(3 * l / 2) - x(-3 * l / 2))", "+ (x(3 * l / 2) - x(-3 * l / 2))"),
    ("theory/simulator.md", "K0, K1, K2 = 2 * d0", "K0, K1, K2 = d0"),
    ("theory/simulator.md", "(12 * end - 1) * d[1]", "(12 * end + 1) * d[1]"),
    ("theory/simulator.md", "[-27 * f[0], -f[0], *f]", "[27 * f[0], -f[0], *f]"),
    ("theory/simulator.md", "R * rate / r", "R * rate / (2 * r)"),
    ("theory/simulator.md", "(depth + C * speed)", "(depth - C * speed)"),
    ("how_to/uncertainty.md", "(c1 * m**4 + pendulum_squared)", "(c1 * m**4 - pendulum_squared)"),
]


def cells(text: str) -> Iterator[str]:
    """Yield the code of a page, cell by cell, without the options that begin with a colon."""
    for cell in re.findall(r"^```\{code-cell\}.*?\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
        yield "".join(line for line in cell.splitlines(keepends=True) if not line.startswith(":"))


def execute(text: str) -> dict[str, object]:
    """Run all cells of a page in one namespace, as its notebook would, and return it."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    names: dict[str, object] = {"__name__": "__main__"}
    try:
        for number, cell in enumerate(cells(text)):
            exec(compile(cell, f"cell {number}", "exec"), names)
    finally:
        pyplot.close("all")
    return names


@pytest.mark.parametrize("page", [page for page in PAGES if page != "theory/agreement.md"])  # that is test_agreement's
def test_pages_execute(page: str) -> None:
    execute((DOCS / page).read_text(encoding="utf-8"))


def with_mistake(page: str, right: str, wrong: str) -> str:
    """Return the text of a page with one thing wrong."""
    text = (DOCS / page).read_text(encoding="utf-8")
    assert text.count(right) == 1, f"{page} says {right!r} {text.count(right)} times"
    return text.replace(right, wrong)


@pytest.mark.parametrize(("page", "right", "wrong"), MISTAKES)
def test_a_mistake_in_a_derivation_is_found(page: str, right: str, wrong: str) -> None:
    with pytest.raises(AssertionError):
        execute(with_mistake(page, right, wrong))


def build(site: Path, page: str, example: str) -> subprocess.CompletedProcess[str]:
    """Build a site of one page and one example with the real configuration, as `make docs` does."""
    docs, examples = site / "docs", site / "examples"
    docs.mkdir()
    examples.mkdir()
    for name in ("conf.py", "gallery_order.py", "custom.css"):
        shutil.copy(DOCS / name, docs)
    shutil.copy(ROOT / "examples/GALLERY_HEADER.rst", examples)
    (examples / "one.py").write_text(f'"""\nOne\n===\n\nAn example.\n"""\n\n{example}\n', encoding="utf-8")
    (docs / "page.md").write_text(page, encoding="utf-8")
    (docs / "index.md").write_text("# Site\n\n```{toctree}\npage\ngallery/index\n```\n", encoding="utf-8")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-T", "-q", "docs", "html"]
    return subprocess.run(command, capture_output=True, text=True, cwd=site)


@pytest.mark.slow
def test_the_site_builds_and_its_links_resolve(tmp_path: Path) -> None:
    run = build(tmp_path, (DOCS / "theory/leapfrog.md").read_text(encoding="utf-8"), "assert 1 + 1 == 2")
    assert run.returncode == 0, run.stderr
    assert faults(tmp_path / "html") == []
    page = (tmp_path / "html/page.html").read_text(encoding="utf-8")
    assert "tex-svg-full.js" in page
    assert (tmp_path / "html/_static/tex-svg-full.js").stat().st_size > 1_000_000
    (tmp_path / "html/_static/tex-svg-full.js").unlink()
    assert {fault.why for fault in faults(tmp_path / "html")} == {"no such file"}


@pytest.mark.slow
def test_a_mistake_in_a_derivation_fails_the_build(tmp_path: Path) -> None:
    mistake = next(mistake for mistake in MISTAKES if mistake[0] == "theory/leapfrog.md")
    run = build(tmp_path, with_mistake(*mistake), "assert 1 + 1 == 2")
    assert run.returncode != 0
    assert "AssertionError" in run.stdout + run.stderr


@pytest.mark.slow
def test_a_mistake_in_an_example_fails_the_build(tmp_path: Path) -> None:
    run = build(tmp_path, "# Page\n", "assert 1 + 1 == 3")
    assert run.returncode != 0
    assert "AssertionError" in run.stdout + run.stderr


def faults(site: Path) -> list:
    return runpy.run_path(str(DOCS / "check_site.py"))["faults"](site)


def test_broken_and_remote_references_are_found(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "index.html").write_text(
        """<h1 id="top">Here</h1> <a href="#top">a</a> <a href="sub/">b</a> <a href="https://example.org">c</a>
        <a href="#nowhere">d</a> <img src="absent.png"> <script src="https://example.org/x.js"></script>
        <link rel="canonical" href="https://example.org/">""",
        encoding="utf-8",
    )
    (tmp_path / "sub/index.html").write_text('<a href="../index.html#top">a</a> <a href="../index.html#no">b</a>')
    assert [tuple(fault) for fault in faults(tmp_path)] == [
        ("index.html", "absent.png", "no such file"),
        ("index.html", "https://example.org/x.js", "would be fetched from elsewhere"),
        ("index.html", "#nowhere", "no such anchor"),
        ("sub/index.html", "../index.html#no", "no such anchor"),
    ]


def docstrings() -> Iterator[tuple[str, bool, str]]:
    """Yield the place of every docstring, whether it is that of a property, and its text."""
    for path in sorted((ROOT / "floquetrod").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and (text := ast.get_docstring(node)):
                decorators = {ast.unparse(decorator).split(".")[-1] for decorator in node.decorator_list}
                yield f"{path.name}, {node.name}", not decorators.isdisjoint({"property", "cached_property"}), text


def test_docstrings_are_shown_as_they_are_written() -> None:
    for place, is_property, text in docstrings():
        assert not (is_property and ":" in text.splitlines()[0]), f"{place}: what precedes a colon would be its type"
        assert not re.search(r"^ *[A-Za-z]\.$", text, re.MULTILINE), f"{place}: a letter and a dot would begin a list"
