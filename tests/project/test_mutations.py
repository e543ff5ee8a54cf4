"""`python -m tools.mutations`: what it changes, what it finds again in another tree, which tests it tries first."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from tools.mutations import ROOT, Mutation, again, drawn, likely, mutations

SOURCE = '''"""What is counted."""

from __future__ import annotations


def known(value: float, most: int = 3) -> bool:
    """Return whether `value` is between 0 and 1, and few."""
    if value < 0.0 or most > 5:
        raise ValueError(f"{value + 1}")
    return value * 2 <= 1.0


def é(value: float) -> float:
    return "é" and value - 1.5
'''


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    (tmp_path / "floquetrod/a").mkdir(parents=True)
    (tmp_path / "floquetrod/a/b.py").write_text(SOURCE, encoding="utf-8")
    (tmp_path / "tests").mkdir()
    return tmp_path


def test_each_changes_one_expression(tree: Path) -> None:
    every = mutations(tree)
    source = SOURCE.encode()
    for mutation in every:
        before, after = ast.parse(source), ast.parse(mutation.applied(source))
        assert ast.dump(before) != ast.dump(after)
        assert len(before.body) == len(after.body)
    kinds = [mutation.kind for mutation in every]
    assert {kind: kinds.count(kind) for kind in sorted(set(kinds))} == {
        "and / or": 2,
        "comparison": 3,
        "condition": 1,
        "number": 6,  # the default too; not the one in a message
        "returned value": 2,
        "sign": 2,
    }


def test_as_many_of_each_kind_are_drawn_and_the_same_for_a_seed(tree: Path) -> None:
    every = [mutation for mutation in mutations(tree) for _ in range(3)]
    chosen = drawn(every, 12, seed=4)
    assert {sum(other.kind == mutation.kind for other in chosen) for mutation in chosen} == {2}
    assert chosen == drawn(every, 12, seed=4) != drawn(every, 12, seed=5)


def row(mutation: Mutation, which: int = 0) -> dict[str, object]:
    return {key: getattr(mutation, key) for key in ("file", "function", "kind", "before")} | {"which": which}


def test_they_are_found_again_where_code_has_moved(tree: Path) -> None:
    old = mutations(tree)
    record = [row(mutation) for mutation in old]
    (tree / "floquetrod/a/b.py").unlink()
    (tree / "floquetrod/c.py").write_text("# Moved.\n\n" + SOURCE.replace("most > 5", "most > 6"), encoding="utf-8")
    found = again(mutations(tree), record)
    for mutation, now in zip(old, found, strict=True):
        if now is not None:
            assert (now.function, now.kind, now.before, now.start[0]) == (
                mutation.function, mutation.kind, mutation.before, mutation.start[0] + 2
            )  # fmt: skip
    gone = {mutation.before for mutation, now in zip(old, found, strict=True) if now is None}
    assert gone == {"value < 0.0 or most > 5", "most > 5", "5"}


@pytest.mark.slow
def test_what_imports_a_module_is_tried_first() -> None:
    mutation = Mutation("floquetrod/_util/spans.py", "runs", "number", "1", "2", (1, 0), (1, 1))
    files = likely(mutation, ROOT)
    assert files[0] == "tests/_util/test_parts.py"
    assert all((ROOT / file).is_file() for file in files)
