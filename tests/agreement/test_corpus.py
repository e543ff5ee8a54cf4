"""The answers kept in `tests/corpus` still hold, and the comparison finds what no longer does."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.corpus import __main__ as corpus
from tests.corpus import answers, snapshot
from tests.corpus.kinds import KINDS

ENTRIES = corpus.stored()


def differing(old: Any, new: Any, kind: str = "equation") -> list[bool]:
    """Return of each finding whether it is allowed."""
    return [finding.allowed for finding in corpus.Entry(kind, "", old).findings(new)]


def test_what_is_cheap_answers_as_it_did(rng: np.random.Generator) -> None:
    cheap = [entry for entry in ENTRIES if KINDS[entry.kind].cheap]
    sample = [cheap[i] for i in rng.choice(len(cheap), 100, replace=False)]
    assert corpus.compare(sample) == 0


@pytest.mark.slow
@pytest.mark.parametrize("what", [["--interface"], *(["--only", name] for name in KINDS)], ids=lambda words: words[-1])
def test_everything_answers_as_it_did(what: list[str]) -> None:
    assert corpus.main(["compare", *what]) == 0


def test_every_kind_is_kept_as_often_as_the_table_says() -> None:
    kept = {name: sum(entry.kind == name for entry in ENTRIES) for name in KINDS}
    assert kept == {name: kind.count for name, kind in KINDS.items()}


def test_questions_are_drawn_from_fixed_seeds() -> None:
    last = {entry.kind: entry for entry in ENTRIES}
    for name in ("system", "coupled rod", "record"):
        assert KINDS[name].question(name, KINDS[name].count - 1) == last[name].question


@pytest.mark.parametrize("name", KINDS)
def test_a_wrong_number_in_any_answer_is_found(name: str) -> None:
    """A thousandth more than the errors allow is found in every answer that has a number or a truth value."""
    spoilt = [(entry, spoil(entry.answer)) for entry in ENTRIES if entry.kind == name]
    told = [(entry, list(entry.findings(answer))) for entry, answer in spoilt if answer != entry.answer]
    missed = [entry for entry, found in told if all(finding.allowed for finding in found)]
    assert not missed


def spoil(answer: Any) -> Any:
    """Return an answer in which every finite number that may not be anything, and every truth value, is another."""
    if isinstance(answer, dict) and "error" in answer:
        key = "spectrum" if "spectrum" in answer else "value"
        value, error = np.asarray(answer[key], dtype=float), np.asarray(answer["error"], dtype=float)
        shift = 4.0 * (error[..., None] if key == "spectrum" else error) + 1e-3 * (1.0 + abs(value))
        return answer | {key: (value + shift).tolist()} if np.isfinite(error).all() else answer
    if isinstance(answer, dict):
        return {name: spoil(part) for name, part in answer.items()}
    if isinstance(answer, list):
        return [spoil(part) for part in answer]
    if isinstance(answer, float) and np.isfinite(answer):
        return answer + 1e-3 * (1.0 + abs(answer))
    if isinstance(answer, bool):
        return not answer
    return answer


@pytest.mark.parametrize(("old", "new"), [("stable", "unstable"), ("unstable", "undecided"), (True, False), (7, 8)])
def test_a_flipped_status_is_found(old: Any, new: Any) -> None:
    assert differing({"status": old}, {"status": new}) == [False]
    assert differing([[old]], [[new]]) == [False]


def test_undecided_may_become_decided_and_a_refusal_an_answer() -> None:
    assert differing({"status": "undecided", "growth": 1.0}, {"status": "stable", "growth": 0.0}) == [True]
    assert differing(["undecided"], ["stable"]) == [True]
    assert differing("refused: ValueError", {"status": "stable"}) == [True]
    assert differing("refused: ValueError", "refused: TypeError") == [False]
    assert differing({"status": "stable"}, "refused: ValueError") == [False]


def test_what_disappears_differs_and_what_appears_is_told() -> None:
    assert differing({"a": 1.0}, {}) == [False]
    assert differing({}, {"a": 1.0}) == [True]
    assert differing([1.0], [1.0, 2.0]) == [False]


def test_numbers_may_differ_by_the_sum_of_their_errors_and_no_more() -> None:
    old = answers.number(1.0, 1e-6)
    assert differing(old, answers.number(1.0 + 1.9e-6, 1e-6)) == []
    assert differing(old, answers.number(1.0 + 2.1e-6, 1e-6)) == [False]
    assert differing(old, answers.number(1.0, 1e-3)) == [False], "an error that grows would let everything pass"
    assert differing(old, answers.number(float("nan"), 1e-6)) == [False]
    assert differing(answers.number(np.inf, 0.0), answers.number(np.inf, 0.0)) == []


def test_multipliers_have_no_order() -> None:
    old = {"spectrum": [[1.0, 2.0], [3.0, 4.0]], "error": [1e-9, 1e-9]}
    assert differing(old, {"spectrum": [[3.0, 4.0], [1.0, 2.0]], "error": [1e-9, 1e-9]}) == []
    assert differing(old, {"spectrum": [[3.0, 4.0], [1.0, 2.1]], "error": [1e-9, 1e-9]}) == [False]
    assert differing(old, {"spectrum": [[3.0, 4.0]], "error": [1e-9]}) == [False]


def test_the_interface_is_as_it_was() -> None:
    broken, _ = snapshot.changes(snapshot.stored()["interface"], snapshot.interface())
    assert not broken


@pytest.mark.parametrize(
    "name",
    [
        "floquetrod.stability",
        "floquetrod.Rod.stability(load)",
        "floquetrod.rod.Stress.share_of_yield",
        "floquetrod check --kick",
        "floquetrod ensemble STUDY",
        "rod file damping_rate",
    ],
)
def test_a_removed_name_is_found(name: str) -> None:
    kept = snapshot.stored()["interface"]
    broken, more = snapshot.changes(kept, {n: what for n, what in kept.items() if n != name})
    assert len(broken) == 1
    assert name in broken[0]
    assert not more


def test_a_changed_default_is_found_and_an_option_more_is_told() -> None:
    kept = snapshot.stored()["interface"]
    parameter = "floquetrod.Rod.stability(growth_tolerance)"
    broken, _ = snapshot.changes(kept, kept | {parameter: "by name = 1.0"})
    assert len(broken) == 1
    option = "floquetrod map --points"
    assert kept[option] == "COLUMNSxROWS = 400x300"
    broken, _ = snapshot.changes(kept, kept | {option: "COLUMNSxROWS, required"})
    assert len(broken) == 1
    broken, more = snapshot.changes(kept, kept | {"floquetrod.stability(new)": "by name = None"})
    assert (len(broken), len(more)) == (0, 1)
    broken, _ = snapshot.changes(kept, kept | {"floquetrod.stability(new)": "place 2"})
    assert len(broken) == 1


def test_the_command_tells_a_difference_with_the_line_that_asks_again(capsys: pytest.CaptureFixture[str]) -> None:
    entry = next(entry for entry in ENTRIES if entry.kind == "equation")
    planted = entry._replace(answer=entry.answer | {"status": "neither"})
    assert corpus.compare([planted, entry]) == 1
    printed = capsys.readouterr().out
    assert entry.question in printed
    assert "answer.status: was neither" in printed
