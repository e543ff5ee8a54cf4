"""The pages of the site: what they state is checked, a false statement stops the build, and links lead somewhere."""

from __future__ import annotations

import ast
import contextlib
import importlib.util
import inspect
import pkgutil
import re
import runpy
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import floquetrod as fr
from tests.conftest import some

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
MADE = {"_build", "gallery", "pages"}
"""Folders of what is made from the pages."""

WRITTEN = [path for path in sorted(DOCS.rglob("*.md")) if not MADE & set(path.relative_to(DOCS).parts)]
PAGES = [path.relative_to(DOCS).as_posix() for path in WRITTEN if "{code-cell}" in path.read_text(encoding="utf-8")]
# Signs and factors wrong, one at a time, in each derivation: page, what it says, what it must not.
MISTAKES = [
    ("theory/rod.md", "(-1, height)", "(1, height)"),
    ("theory/real_rods.md", "(1 - kappa * r * sp.cos(phi))", "(1 + kappa * r * sp.cos(phi))"),
    ("theory/real_rods.md", "+ F * theta.diff(s) ** 2", "- F * theta.diff(s) ** 2"),
    ("theory/real_rods.md", "sp.cos(k * (L - s)) / sp.cos(k * L)", "sp.cos(k * (L - s)) / sp.sin(k * L)"),
    ("theory/real_rods.md", "-4 * slope * i * j", "4 * slope * i * j"),
    ("theory/surface_weights.md", "F - p_i * A_i", "F + p_i * A_i"),
    ("theory/surface_weights.md", "axial, radial, hoop = A - F / A_s", "axial, radial, hoop = A + F / A_s"),
    ("theory/surface_weights.md", "+ P * (l - s)", "+ 2 * P * (l - s)"),
    ("how_to/well.md", "return 4.0 * mass * half", "return 2.0 * mass * half"),
    ("theory/floquet.md", "u.diff(tau, 2) - (p + c**2) * u", "u.diff(tau, 2) - (p - c**2) * u"),
    ("theory/hill.md", "chain(1, 5, shift=-q)", "chain(1, 5, shift=q)"),
    ("theory/systems.md", "2 * I + 4 * b.T * c", "2 * I - 4 * b.T * c"),
    ("theory/systems.md", "s + c2 - sp.I * D / 2", "s + c2 + sp.I * D / 2"),
    ("theory/systems.md", "(c1 + c2) ** 2 * (G2 / (c1 * c2) - 1)", "(c1 + c2) ** 2 * (G2 / (c1 * c2) + 1)"),
    ("theory/systems.md", "- (ratio + 1 / ratio)", "+ (ratio + 1 / ratio)"),
    ("theory/systems.md", "(x**2 - (2 * sp.I) ** 2)", "(x**2 + (2 * sp.I) ** 2)"),
    ("theory/noise.md", "-2 * c * v - k * y", "-2 * c * v + k * y"),
    ("theory/noise.md", "K * q**2 - g * q * Q", "K * q**2 + g * q * Q"),
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
    ("how_to/uncertainty.md", "(c1 * m**4 + restoring)", "(c1 * m**4 - restoring)"),
]


BLOCKS = SimpleNamespace(**runpy.run_path(str(DOCS / "forge_pages.py")))
"""What reads the prose and the cells of a page."""


def cells(text: str) -> list[str]:
    """Return the code of a page, cell by cell."""
    return [cell.code for cell in BLOCKS.cells(text)]


@contextlib.contextmanager
def namespace() -> Iterator[dict[str, object]]:
    """Yield a namespace for the cells of a page, without windows; close what they draw."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    try:
        yield {"__name__": "__main__"}
    finally:
        pyplot.close("all")


def execute(text: str) -> dict[str, object]:
    """Run all cells of a page in one namespace, as its notebook would, and return it."""
    with namespace() as names:
        continued(names, cells(text))
    return names


def continued(names: dict[str, object], code: list[str]) -> None:
    """Run cells in a namespace."""
    for cell in code:
        exec(compile(cell, "cell", "exec"), names)


STORIES = ["my_rod", "ion_trap", "recorded_force", "cluster", "two_equations"]
ELSEWHERE = {"theory/agreement.md"} | {f"how_to/{story}.md" for story in STORIES}
"""Pages that test_agreement and test_stories execute."""


LONG = {
    "index.md",
    "how_to/my_equation.md",
    "how_to/driven_qubit.md",
    "theory/validation.md",
    "theory/orbits.md",
    "how_to/limit_cycle.md",
    "how_to/how_large.md",
    "how_to/not_straight.md",
    "theory/simulator.md",
    "theory/simulated_wells.md",
    "theory/real_rods.md",
    "theory/bends.md",
    "theory/friction.md",
    "theory/thin_tongues.md",
    "theory/regions.md",
    "how_to/ensembles.md",
    "how_to/system_forms.md",
    "how_to/conventions.md",
    "how_to/milling.md",
    "theory/delays.md",
    "how_to/reach.md",
    "how_to/weights.md",
    "how_to/three_jobs.md",
    "theory/surface_weights.md",
    "how_to/noisy_force.md",
    "theory/noise.md",
    "theory/two_frequencies.md",
    "theory/mean_force.md",
    "theory/large_motion.md",
    "how_to/well.md",
    "how_to/uncertainty.md",
    "how_to/explorer.md",
    "theory/rod.md",
    "theory/systems.md",
    "theory/hill.md",
    "theory/maps.md",
    "theory/leapfrog.md",
    "theory/ranges.md",
    "how_to/tapered_string.md",
    "theory/response.md",
    "theory/bands.md",
    "how_to/questions.md",
    "theory/sections.md",
    "theory/trust.md",
    "reference/units.md",
}
"""Pages that take some tenths of a second and more; `make slow` and `make docs` execute them."""


def quick(pages: list[str]) -> list[Any]:
    """Return pages as parameters, the long ones marked."""
    marks = {page: [pytest.mark.slow] * (page in LONG) for page in pages}
    return [pytest.param(page, marks=marks[page]) for page in pages]


@pytest.mark.parametrize(
    "page", quick([page for page in PAGES if page not in {*ELSEWHERE, *(row[0] for row in MISTAKES)}])
)
def test_pages_execute(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # where `make docs` runs each in a folder of its own, too
    execute((DOCS / page).read_text(encoding="utf-8"))


def with_mistake(page: str, right: str, wrong: str) -> str:
    """Return the text of a page with one thing wrong."""
    text = (DOCS / page).read_text(encoding="utf-8")
    assert text.count(right) == 1, f"{page} says {right!r} {text.count(right)} times"
    return text.replace(right, wrong)


@pytest.mark.slow
@pytest.mark.parametrize("page", quick(sorted({page for page, _, _ in MISTAKES})))
def test_a_page_executes_and_each_mistake_in_its_derivations_is_found(page: str) -> None:
    # What precedes a mistake is run once: before a cell is run, so is each wrong one in its place, and what follows it.
    text = (DOCS / page).read_text(encoding="utf-8")
    code, every = cells(text), [row[1:] for row in MISTAKES if row[0] == page]
    assert all(text.count(right) == 1 for right, _ in every)
    left = some(every, (len(every) + 1) // 2, 1)
    with namespace() as names:
        for number, cell in enumerate(code):
            for right, wrong in [mistake for mistake in left if mistake[0] in cell]:
                with pytest.raises(AssertionError):
                    continued(dict(names), [cell.replace(right, wrong), *code[number + 1 :]])
                left.remove((right, wrong))
            continued(names, [cell])
    assert left == []


needs_sphinx = pytest.mark.skipif(
    importlib.util.find_spec("sphinx") is None, reason="pip install floquetrod[docs]: builds a site with Sphinx"
)


def build(site: Path, page: str, example: str) -> subprocess.CompletedProcess[str]:
    """Build a site of one page and one example with the real configuration, as `make docs` does."""
    docs, examples = site / "docs", site / "examples"
    docs.mkdir(exist_ok=True)
    examples.mkdir(exist_ok=True)
    for path in [*DOCS.glob("*.py"), *DOCS.glob("*.css"), *DOCS.glob("*.js")]:
        shutil.copy(path, docs)
    shutil.copy(ROOT / "examples/GALLERY_HEADER.rst", examples)
    (examples / "one.py").write_text(f'"""\nOne\n===\n\nAn example.\n"""\n\n{example}\n', encoding="utf-8")
    (docs / "page.md").write_text(page, encoding="utf-8")
    (docs / "index.md").write_text(
        "# Site\n\n```{toctree}\npage\ngallery/index\nreference/commands/index\n```\n", encoding="utf-8"
    )
    return rebuild(site)


def rebuild(site: Path) -> subprocess.CompletedProcess[str]:
    """Build the site again with what is there."""
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-T", "-q", "docs", "html"]
    return subprocess.run(command, capture_output=True, text=True, cwd=site)


@pytest.mark.slow
@needs_sphinx
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
@needs_sphinx
def test_a_mistake_in_a_derivation_fails_the_build(tmp_path: Path) -> None:
    mistake = next(mistake for mistake in MISTAKES if mistake[0] == "theory/leapfrog.md")
    run = build(tmp_path, with_mistake(*mistake), "assert 1 + 1 == 2")
    assert run.returncode != 0
    assert "AssertionError" in run.stdout + run.stderr


@pytest.mark.slow
@needs_sphinx
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
        <a href="#nowhere">d</a> <img src="absent.png" alt=""> <script src="https://example.org/x.js"></script>
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


def test_pages_too_large_too_far_or_undescribed_are_found(tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text(
        '<a href="one.html"></a> <img src="one.html"> <img src="one.html" alt="a.png">'
    )
    (tmp_path / "one.html").write_text('<a href="two.html"></a> <img src="one.html" alt="A rod">')
    (tmp_path / "two.html").write_text('<a href="three.html"></a>')
    (tmp_path / "three.html").write_text(" " * 170_001)
    assert [(fault.page, fault.why.partition(";")[0]) for fault in faults(tmp_path)] == [
        ("index.html", "has no text in place of the picture"),
        ("index.html", "has no text in place of the picture"),
        ("three.html", "has 170001 bytes"),
        ("three.html", "is more than 2 clicks away"),
    ]


@pytest.mark.parametrize("path", [*WRITTEN, ROOT / "README.md"], ids=lambda path: path.relative_to(ROOT).as_posix())
def test_code_fits_its_column(path: Path) -> None:
    """At 120 columns nothing scrolls sideways on a desktop; `make look` sees it in a browser."""
    blocks = re.findall(r"^```.*\n((?s:.*?))^```", path.read_text(encoding="utf-8"), re.MULTILINE)
    lines = [line for block in blocks for line in block.splitlines() if not line.startswith(":")]
    assert [line for line in lines if len(line) > 120] == []


@pytest.mark.parametrize("page", [page for page in PAGES if page.startswith("theory/")])
def test_derivations_are_folded(page: str) -> None:
    text = (DOCS / page).read_text(encoding="utf-8")
    for cell in BLOCKS.cells(text):
        derives = "assert" in cell.code or "sp." in cell.code
        assert not derives or cell.tags in ({"hide-input"}, {"remove-cell"}), cell.code


@pytest.mark.slow
@needs_sphinx
def test_every_formula_typeset_is_one_that_a_docstring_writes() -> None:
    module = runpy.run_path(str(DOCS / "formulas.py"))
    lines = [line for _, _, text in docstrings() for line in text.splitlines()]
    met = {found for line in lines for found in module["_ANY"].findall(line)}
    assert module["PLAIN"] - met == set()
    assert module["typeset"]("p(tau) = beta + alpha sin tau; x").replace(" ", "") == (
        r":math:`p(\tau)=\beta+\alpha\sin\tau`;x"
    )
    written = {
        "exp(-2 c period)": r"e^{-2c\,\mathtt{period}}",
        "d_k = D_k - a - q^2 / d_(k-1)": r"d_{k}=D_{k}-a-q^{2}/d_{k-1}",
        "0 <= C T^-1 C* <= C C* / delta": r"0\leCT^{-1}\,C^*\leCC^*/\delta",
        "F_cr = 2 sqrt(E I w_e sin(inclination) / R)": r"F_{cr}=2\sqrt{EIw_{e}\,\sin(\mathtt{inclination})/R}",
    }
    assert {plain: module["latex"](plain).replace(" ", "") for plain in written} == written


@pytest.mark.slow
@needs_sphinx
def test_a_page_for_every_command_says_what_its_help_says(tmp_path: Path) -> None:
    sys.path.insert(0, str(DOCS))
    try:
        import command_pages
    finally:
        sys.path.remove(str(DOCS))
    (tmp_path / "gone.rst").write_text("a command that is no more")
    command_pages.write(tmp_path)
    _, commands = command_pages.parsers()
    assert {path.stem for path in tmp_path.glob("*.rst")} == {*commands, "index"}
    table = (DOCS / "start/first_ten_minutes.md").read_text(encoding="utf-8")
    assert [name for name in commands if f"| `floquetrod {name}` |" not in table] == []
    for name, (_, parser) in commands.items():
        page = (tmp_path / f"{name}.rst").read_text(encoding="utf-8")
        assert max(map(len, re.findall(r"^   .*(?:\\|floquetrod.*)$", page, re.MULTILINE))) <= 120
        plain = " ".join(re.sub(r"[`*\\]", "", page).split())
        for action in parser._actions:
            assert all(option in plain for option in action.option_strings)
        for sentence in re.split(r"(?<=\.)\s+", parser.epilog or ""):
            if "\n  " not in sentence:
                assert re.sub(r"[`*\\]", "", " ".join(sentence.split())) in plain


@pytest.mark.slow
@needs_sphinx
def test_the_search_reads_what_a_page_says(tmp_path: Path) -> None:
    texts = runpy.run_path(str(DOCS / "search_excerpts.py"))["texts"]
    (tmp_path / "page.html").write_text(
        """<nav>menu</nav><article><section id="a"><h1>Rods<a class="headerlink" href="#a">#</a></h1><p>of
        <b>steel</b> <img src="x.png"> wire</p><section id="b">and string</section><script>no()</script></section>
        </article>footer""",
        encoding="utf-8",
    )
    assert texts(tmp_path, ["page", "absent"]) == {"page": {"#a": "Rods of steel wire", "#b": "and string"}}


def definitions(node: ast.AST) -> Iterator[ast.FunctionDef | ast.ClassDef]:
    """Yield the functions and classes in a syntax tree: they are statements, which have no expression above them."""
    for below in ast.iter_child_nodes(node):
        if isinstance(below, ast.FunctionDef | ast.ClassDef):
            yield below
        if isinstance(below, ast.stmt | ast.excepthandler):
            yield from definitions(below)


def docstrings() -> Iterator[tuple[str, bool, str]]:
    """Yield the place of every docstring, whether it is that of a property, and its text."""
    for path in sorted((ROOT / "floquetrod").rglob("*.py")):
        for node in definitions(ast.parse(path.read_text(encoding="utf-8"))):
            if text := ast.get_docstring(node):
                decorators = {ast.unparse(decorator).split(".")[-1] for decorator in node.decorator_list}
                yield f"{path.name}, {node.name}", not decorators.isdisjoint({"property", "cached_property"}), text


@pytest.mark.slow
def test_docstrings_are_shown_as_they_are_written() -> None:
    for place, is_property, text in docstrings():
        assert not (is_property and ":" in text.splitlines()[0]), f"{place}: what precedes a colon would be its type"
        assert not re.search(r"^ *[A-Za-z]\.$", text, re.MULTILINE), f"{place}: a letter and a dot would begin a list"


def entries(thing: object) -> Iterator[str]:
    """Yield the names of the entries of parameters and fields in a docstring."""
    lines = inspect.cleandoc(thing.__doc__ or "").splitlines()
    for heading in {"Parameters", "Attributes"} & set(lines):
        below = lines[lines.index(heading) + 2 :]
        end = next((i for i, line in enumerate(below) if line.startswith("---")), len(below))
        yield from (line.split(" : ")[0] for line in below[:end] if re.match(r"\w+(, \w+)*( : |$)", line))


def reference_text(path: Path) -> str:
    """Return a page of the reference with the methods that its directive lists."""
    described = runpy.run_path(str(DOCS / "method_list.py"))["described"]
    text = path.read_text(encoding="utf-8")
    return re.sub(r"^\.\. methods:: (\w+)$", lambda match: "\n".join(described(match[1])), text, flags=re.MULTILINE)


def referred() -> Iterator[tuple[str, object]]:
    """Yield functions and classes of the reference, and the public methods of the classes."""
    for path in sorted(DOCS.glob("reference/*.rst")):
        for name in re.findall(r"auto(?:class|function):: (\S+)", reference_text(path)):
            thing = pkgutil.resolve_name(name)
            yield name, thing
            for method in vars(thing) if inspect.isclass(thing) else ():
                if not method.startswith("_") and callable(getattr(thing, method)):
                    yield f"{name}.{method}", getattr(thing, method)


def test_parameters_and_fields_have_an_entry_each() -> None:
    """Nobody finds the unit of a length in an entry "radius, length"; of a field Sphinx would make it a type."""
    found = [(place, entry) for place, thing in referred() for entry in entries(thing)]
    assert [(place, entry) for place, entry in found if "," in entry] == []
    assert len(found) > 500


def test_reference_has_one_entry_for_every_parameter_of_a_rod_and_of_friction() -> None:
    """Those without an entry of their own have that of the docstring referred to, or one that many share."""
    page = runpy.run_path(str(DOCS / "parameters.py"))
    lacking, used = [], set()
    for name, thing in referred():
        if inspect.isclass(thing):
            continue
        found = page["own"](page["parted"](page["filled"](name, thing, inspect.getdoc(thing)))[1])
        for each in page["parameters"](thing):
            entry = page["shared"](name, each)
            used |= {(entry[1], each.name)} if entry and entry[1] == "\n".join(found[each.name][1:]) else set()
            lacking += [(name, each.name)] if each.name not in found else []
    assert [each for each in lacking if each[0].startswith(("floquetrod.Rod.", "floquetrod.friction."))] == []
    assert len(lacking) < 120
    assert {name for entries in page["SHARED"].values() for name in entries} <= {name for _, name in used}


def test_defaults_and_entries_of_other_docstrings_are_shown() -> None:
    page = runpy.run_path(str(DOCS / "parameters.py"))

    def section(thing: Any, place: str) -> str:
        return page["parted"](page["filled"](place, thing, inspect.getdoc(thing)))[1]

    kicks = section(fr.friction.escapes, "floquetrod.friction.escapes")
    assert "max_steps : int, default 500000\n    Steps" in kicks
    growth = section(fr.Rod.growth_rate, "floquetrod.Rod.growth_rate")
    assert "frequency : array_like, optional\n    Angular frequency in rad/s" in growth
    assert "return_mode : bool, default False\n" in growth
    examples = page["filled"]("floquetrod.Rod.verdicts", fr.Rod.verdicts, inspect.getdoc(fr.Rod.verdicts))
    assert "Examples\n--------\n>>> Rod" in examples


def lost_names(text: str) -> list[str]:
    """Return names of the package, of members of its classes and of files that a page mentions and nobody finds."""
    lost = []
    for name in re.findall(r"(?<![\w.])(?:fr|floquetrod)\.(\w+(?:\.\w+)*)", text):
        try:
            pkgutil.resolve_name(f"floquetrod.{name}")
        except (ImportError, AttributeError):
            lost += [] if name == "compile" else [name]  # the name of a logger
    for owner, member in re.findall(r"`([A-Z]\w+)\.(\w+)", text):
        thing = getattr(fr, owner, None)
        known = {*dir(thing), *getattr(thing, "__dataclass_fields__", ()), *getattr(thing, "__annotations__", ())}
        lost += [f"{owner}.{member}"] if thing and member not in known else []
    folders = (ROOT, ROOT / "floquetrod", ROOT / "floquetrod/floquet/multipliers", DOCS, ROOT / "tests")
    for path in re.findall(r"`([\w.]+/[\w./]*\.(?:py|md|rst))\b", text):
        lost += [] if any((folder / path).is_file() for folder in folders) else [path]
    return lost


def test_what_pages_name_exists() -> None:
    pages = [*WRITTEN, *DOCS.glob("reference/*.rst"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    assert {page.name: lost for page in pages if (lost := lost_names(page.read_text(encoding="utf-8")))} == {}
    wrong = "`fr.no`, `Rod.no(1)`, `rod/no.py`, `fr.Rod.stability`, `rod/rod.py`"
    assert lost_names(wrong) == ["no", "Rod.no", "rod/no.py"]


def test_what_is_executed_depends_on_code_and_on_nothing_that_a_reader_of_it_only_sees(tmp_path: Path) -> None:
    module = runpy.run_path(str(DOCS / "executed.py"))
    package = tmp_path / "package"
    package.mkdir()
    digests = []
    for text in ('def f():\n    """Say."""\n    return 1', "def f():\n    return 1  # so", "def f():\n    return 2"):
        (package / "one.py").write_text(text, encoding="utf-8")
        digests.append(module["digest"].__wrapped__(package, tmp_path))
    assert digests[0] == digests[1] != digests[2]
    for name in ("package/rods.toml", "tests/strategies.py", "benchmarks/peers/one.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("a = 1", encoding="utf-8")
        digests.append(module["digest"].__wrapped__(package, tmp_path))
    assert len(set(digests)) == 5


def test_what_pages_take_from_the_tests_is_in_the_digest() -> None:
    """A page that imports a module of the tests is executed again where that module changes."""
    covered = {
        path.stem for pattern in runpy.run_path(str(DOCS / "executed.py"))["BESIDE"] for path in ROOT.glob(pattern)
    }
    modules = {path.stem for path in (ROOT / "tests").glob("*.py")}
    used = {name for page in WRITTEN for name in re.findall(r"^from tests import (\w+)", page.read_text("utf-8"), re.M)}
    assert {"published"} <= used & modules <= covered


@pytest.mark.slow
@needs_sphinx
def test_what_did_not_change_is_not_executed_again(tmp_path: Path) -> None:
    head = "---\nfile_format: mystnb\nkernelspec: {name: python3}\n---\n\n# Page\n\n"
    page = f"{head}```{{code-cell}}\nimport time\ntime.time_ns()\n```\n"
    example = "import time\nprint(time.time_ns())"

    def said() -> list[str]:
        texts = [(tmp_path / "html" / name).read_text(encoding="utf-8") for name in ("page.html", "gallery/one.html")]
        return [re.findall(r"\b\d{19}\b", re.sub("<[^>]+>", "", text))[0] for text in texts]

    assert build(tmp_path, page, example).returncode == 0
    first = said()
    build(tmp_path, page, example)
    assert said() == first
    build(tmp_path, page + "\nMore.\n", example.replace("print", "print  "))
    assert [now == then for now, then in zip(said(), first, strict=True)] == [True, False]
    with (tmp_path / "docs/thumbnails.py").open("a", encoding="utf-8") as file:
        file.write("\nMORE = 1\n")
    rebuild(tmp_path)
    assert not set(said()) & set(first)
