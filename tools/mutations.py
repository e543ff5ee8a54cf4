"""How many small faults the suite notices: `python -m tools.mutations --number 100 --seed 1 --out mutations.json`.

A mutation changes one comparison, sign, number, `and`, condition or returned value of the package: kinds are drawn
equally often, and places within a kind.  Each is tried in a copy of the tree.  The test files likeliest to reach it,
from what they import and name and from their folder, and those of `ALWAYS` take turns until a test fails or `SECONDS`
are over.  A survivor is a missing test, a place that only slower tests reach, or a change without effect.  `--again
FILE` repeats the mutations of a record on this tree, by the same test files and more, first by what noticed them.  The
tests that noticed a mutation run without any at the end.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
FILES = 8
ALWAYS = ("agreement/test_equation_and_system.py", "agreement/test_agreement.py", "agreement/test_published.py")
LEFT_OUT = ("project/", "studies/", "simulation/test_arithmetic.py", "_util/test_compile.py")
"""Tests of the text of the code, which any change fails; of the study; and slow ones of compiling."""

SECONDS = 30.0
"""Processor time of the tests of a mutation; a process that takes three times as long, or waits so long, is stopped."""

FIRST = "FLOQUETROD_FIRST_TEST"
"""The variable with the test that noticed a mutation before."""

FLIPPED: dict[type, type] = {
    ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.LtE: ast.GtE, ast.GtE: ast.LtE, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip


@dataclass(frozen=True)
class Mutation:
    """A change of the text between two places, lines from 1 and columns in bytes, of a function in a file."""

    file: str
    function: str
    kind: str
    before: str
    after: str
    start: tuple[int, int]
    end: tuple[int, int]

    @property
    def name(self) -> tuple[str, str, str, str]:
        """What stays when the file changes elsewhere."""
        return self.file, self.function, self.kind, self.before

    def applied(self, source: bytes) -> bytes:
        """Return the source of the file with this change."""
        lines = source.splitlines(keepends=True)
        (first, left), (last, right) = self.start, self.end
        text = lines[first - 1][:left] + self.after.encode() + lines[last - 1][right:]
        return b"".join([*lines[: first - 1], text, *lines[last:]])


def changed(node: ast.AST, returns: str) -> Iterator[tuple[str, ast.expr, str]]:
    """Yield kind, expression and the text in its place for the mutations of a node."""
    if isinstance(node, ast.Compare):
        flipped = ast.Compare(node.left, [FLIPPED[type(node.ops[0])](), *node.ops[1:]], node.comparators)
        yield "comparison", node, f"({ast.unparse(flipped)})"
    elif isinstance(node, ast.BinOp) and type(node.op) in FLIPPED:
        if not any(isinstance(side, ast.Constant) and isinstance(side.value, str) for side in (node.left, node.right)):
            yield "sign", node, f"({ast.unparse(ast.BinOp(node.left, FLIPPED[type(node.op)](), node.right))})"
    elif isinstance(node, ast.BoolOp):
        yield "and / or", node, f"({ast.unparse(ast.BoolOp(FLIPPED[type(node.op)](), node.values))})"
    elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
        yield "number", node, repr(node.value + 1 if isinstance(node.value, int) else 1.5 * node.value or 1.0)
    elif isinstance(node, ast.If | ast.IfExp | ast.While):
        yield "condition", node.test, f"(not ({ast.unparse(node.test)}))"
    elif isinstance(node, ast.Return) and node.value is not None and returns in ("bool", "float", "Floats"):
        yield "returned value", node.value, f"({'not' if returns == 'bool' else '-'} ({ast.unparse(node.value)}))"


def mutations(root: Path) -> list[Mutation]:
    """Return all mutations of the package, in the order of its files."""
    found: list[Mutation] = []

    def visit(node: ast.AST, function: str, returns: str) -> None:
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            return
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            function = f"{function}.{node.name}".lstrip(".")
            returns = ast.unparse(node.returns) if isinstance(node, ast.FunctionDef) and node.returns else ""
        for kind, place, text in changed(node, returns):
            start, end = (place.lineno, place.col_offset), (place.end_lineno or 0, place.end_col_offset or 0)
            found.append(Mutation(file, function, kind, ast.unparse(place), text, start, end))
        for field, child in ast.iter_fields(node):
            if field in ("annotation", "returns", "decorator_list"):
                continue
            for each in child if isinstance(child, list) else [child]:
                if isinstance(each, ast.AST) and not isinstance(each, ast.JoinedStr | ast.Raise | ast.Slice):
                    visit(each, function, returns)

    for path in sorted((root / "floquetrod").rglob("*.py")):
        file = path.relative_to(root).as_posix()
        visit(ast.parse(path.read_text(encoding="utf-8")), "", "")
    return found


def drawn(every: list[Mutation], number: int, seed: int) -> list[Mutation]:
    """Return some of the mutations, as many of each kind."""
    rng = random.Random(seed)
    kinds = sorted({mutation.kind for mutation in every})
    shuffled = {kind: rng.sample(own, len(own)) for kind in kinds if (own := [m for m in every if m.kind == kind])}
    return [shuffled[kinds[index % len(kinds)]].pop() for index in range(number)]


def again(every: list[Mutation], record: list[dict[str, Any]]) -> list[Mutation | None]:
    """Return the mutations of a record in another tree, None where the place is not there, or not the only one."""
    named: dict[tuple[str, ...], list[Mutation]] = {}
    for mutation in every:
        for name in (mutation.name, mutation.name[1:]):  # in its file; elsewhere, if it has moved
            named.setdefault(name, []).append(mutation)
    chosen: list[Mutation | None] = []
    for row in record:
        name = (row["file"], row["function"], row["kind"], row["before"])
        here = named.get(name) or named.get(name[1:], [])
        chosen.append(here[row["which"]] if row["which"] < len(here) and (name in named or len(here) == 1) else None)
    return chosen


def likely(mutation: Mutation, root: Path) -> list[str]:
    """Return the test files likeliest to notice a mutation, the likeliest first, and those of `ALWAYS`."""
    module = mutation.file.removesuffix(".py").replace("/", ".").removesuffix(".__init__")
    package, _, stem = module.rpartition(".")
    names = [re.escape(name) for name in (module, package, stem)]
    importing = re.compile(r"from {0} import|import {0}\b|from {1} import [^\n]*\b{2}\b".format(*names))
    importers = [
        path.stem
        for path in (root / "floquetrod").rglob("*.py")
        if path.name != "__init__.py" and importing.search(path.read_text(encoding="utf-8"))
    ]
    words = [word for word in mutation.function.split(".") if len(word.strip("_")) > 3]
    source = ast.parse((root / mutation.file).read_text(encoding="utf-8"))
    given = [node.name for node in source.body if isinstance(node, ast.FunctionDef | ast.ClassDef)]
    given = [name for name in given if len(name) > 4 and not name.startswith("_") and name not in words]
    folder, weights = "/".join(mutation.file.split("/")[1:-1]).replace("/kernels", ""), {}
    for path in sorted((root / "tests").rglob("test_*.py")):
        file, text = path.relative_to(root / "tests").as_posix(), path.read_text(encoding="utf-8")
        if file.startswith(LEFT_OUT):
            continue
        weight = 8.0 * bool(importing.search(text))
        weight += sum(4.0 for word in words if re.search(rf"\b{word}\b", text))
        weight += min(4.0, sum(2.0 for name in given if re.search(rf"\b{name}\b", text)))
        weight += 2.0 * (file.split("/")[0] == folder.split("/")[0]) + 2.0 * (str(Path(file).parent) == folder)
        weight += 2.0 * len(set(path.stem.split("_")) & set(stem.split("_")))
        weight += min(2.0, sum(0.5 for name in importers if re.search(rf"\b{name}\b", text)))
        weights[file] = weight
    best = sorted(weights, key=lambda file: -weights[file])[:FILES]
    return [f"tests/{file}" for file in dict.fromkeys([*best, *ALWAYS])]


def pytest_configure() -> None:
    """Stop this process, whatever it computes, when it has taken too long (this module is a plugin where tests run)."""
    resource.setrlimit(resource.RLIMIT_CPU, (round(3 * SECONDS), round(3 * SECONDS) + 1))


def pytest_collection_modifyitems(items: list[Any]) -> None:
    """Let the files take turns of ten tests, the likelier ones more."""
    rank = {path: number for number, path in enumerate(dict.fromkeys(item.path for item in items), 3)}
    count = dict.fromkeys(rank, 0)
    turn = {}
    first = os.environ.get(FIRST, "")
    for item in items:
        count[item.path] += 1
        turn[item] = (count[item.path] + 9) // 10 * rank[item.path], rank[item.path]
        if first and item.nodeid.split("[")[0] == first.split("[")[0]:
            turn[item] = 0, rank[item.path]
    items.sort(key=turn.__getitem__)


def pytest_runtest_teardown(item: Any) -> None:
    """Stop when the time is over."""
    if sum(os.times()[:4]) > SECONDS:
        item.session.shouldstop = "the time is over"


def tried(mutation: Mutation, tree: Path, tests: list[str], first: str = "") -> dict[str, Any]:
    """Return what tests say of a mutation, in a copy of a tree that shares its files."""
    with tempfile.TemporaryDirectory(prefix="mutation", dir=tree.parent) as name:
        copy, log = Path(name) / "tree", Path(name) / "log"
        shutil.copytree(tree, copy, copy_function=os.link)
        path = copy / mutation.file
        source = mutation.applied(path.read_bytes())
        path.unlink()  # the file of the tree stays as it is
        path.write_bytes(source)
        for kept in path.parent.glob(f"__pycache__/{path.stem}.cpython*.pyc"):
            kept.unlink()
        options = ["-q", "-x", "--no-header", "-p", "no:cacheprovider", "-p", "tools.mutations", "-m", "not slow"]
        command = [sys.executable, "-m", "pytest", *options, *tests]
        environment = os.environ | {"PYTHONPATH": str(copy), FIRST: first}
        begun = time.monotonic()
        with log.open("wb") as file:
            run = subprocess.Popen(command, cwd=copy, env=environment, stdout=file, stderr=file, start_new_session=True)
            try:
                status = run.wait(20 * SECONDS)
            except subprocess.TimeoutExpired:
                status = -1
            with contextlib.suppress(ProcessLookupError):
                os.killpg(run.pid, signal.SIGKILL)
            run.wait()
        said = log.read_text(encoding="utf-8", errors="replace")
        for kept in copy.rglob("*.nbc"):  # compiled for types that no mutation met before; digests say what of it holds
            if not (own := tree / kept.relative_to(copy)).exists():
                own.parent.mkdir(exist_ok=True)
                os.link(kept, own)
    passed = re.findall(r"(\d+) passed", said[-300:])
    noticed = re.findall(r"^(?:FAILED|ERROR) (.+?)(?: - |$)", said, re.MULTILINE)
    outcome = (
        "timed out" if status in (-1, -signal.SIGXCPU) else "killed" if noticed or status not in (0, 2) else "survived"
    )
    by = noticed[0] if noticed else said[-300:] if outcome == "killed" else ""
    seconds = round(time.monotonic() - begun, 1)
    return {"outcome": outcome, "by": by, "passed": int(passed[0]) if passed else 0, "seconds": seconds}


def main() -> None:
    """Draw mutations, try each, and write the record after each; print a table of outcomes by kind."""
    parser = argparse.ArgumentParser(prog="python -m tools.mutations", description=__doc__)
    parser.add_argument("--number", type=int, default=100, help="how many to draw")
    parser.add_argument("--seed", type=int, default=1, help="of the draw")
    parser.add_argument("--again", type=Path, help="the record whose mutations are repeated")
    parser.add_argument("--out", type=Path, default=Path("mutations.json"), help="the record")
    options = parser.parse_args()
    every = mutations(ROOT)
    if options.again:
        old = json.loads(options.again.read_text(encoding="utf-8"))
        chosen = again(every, old)
    else:
        chosen = list(drawn(every, options.number, options.seed))
        old = [{}] * len(chosen)
    record = []
    with tempfile.TemporaryDirectory(prefix="mutations") as name:
        tree = Path(name) / "tree"
        shutil.copytree(ROOT, tree, ignore=shutil.ignore_patterns(".*", "_build"))
        for number, (mutation, row) in enumerate(zip(chosen, old, strict=True), 1):
            if mutation is None:
                record.append(row | {"outcome": "gone", "by": "", "passed": 0, "seconds": 0.0})
            else:
                same = [other for other in every if other.name == mutation.name]
                place = {key: getattr(mutation, key) for key in ("file", "function", "kind", "before", "after")}
                line = {"line": mutation.start[0], "which": same.index(mutation)}
                tests = [file for file in row.get("tests", []) if (tree / file).exists()]
                tests = [*dict.fromkeys([*tests, *likely(mutation, tree)])]
                record.append(place | line | tried(mutation, tree, tests, row.get("by", "")) | {"tests": tests})
            options.out.write_text(json.dumps(record, indent=1), encoding="utf-8")
            row = record[-1]
            print(f"{number:4d} {row['outcome']:10s} {row['file']}:{row['line']} {row['before'][:50]}", flush=True)
        failing = sorted({row["by"].split("[")[0] for row in record if "::" in row["by"]})
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "not slow", *failing]
        if failing:  # the tests that noticed something are right without it
            subprocess.run(command, cwd=tree, env=os.environ | {"PYTHONPATH": str(tree)}, check=False)
    outcomes = ("killed", "timed out", "survived", "gone")
    print(f"{'':16s}" + "".join(f"{outcome:>12s}" for outcome in outcomes))
    for kind in sorted({row["kind"] for row in record}):
        own = [row["outcome"] for row in record if row["kind"] == kind]
        print(f"{kind:16s}" + "".join(f"{own.count(outcome):12d}" for outcome in outcomes))


if __name__ == "__main__":
    main()
