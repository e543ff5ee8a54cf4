"""Make the corpus, or compare with it what the package answers now."""

from __future__ import annotations

import argparse
import gzip
import json
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from . import answers, snapshot
from .kinds import KINDS

ANSWERS = Path(__file__).parent / "answers.jsonl.gz"


class Entry(NamedTuple):
    """A question of some kind and its answer."""

    kind: str
    question: str
    answer: Any

    def findings(self, new: Any) -> Iterator[answers.Finding]:
        """Yield in what a new answer differs from the one kept."""
        kind = KINDS[self.kind]
        yield from answers.differences(self.answer, new, kind.relative, kind.floor)


def stored() -> list[Entry]:
    """Return all that is kept."""
    with gzip.open(ANSWERS, "rt", encoding="utf-8") as file:
        return [Entry(*json.loads(line)) for line in file]


def make(names: list[str]) -> None:
    """Ask all questions of these kinds, print seconds of a processor, and write the answers beside those of others."""
    entries: dict[str, list[Entry]] = {name: [] for name in KINDS}
    for entry in stored() if ANSWERS.exists() else []:
        if entry.kind in KINDS and entry.kind not in names:
            entries[entry.kind].append(entry)
    for name in names:
        kind, begin = KINDS[name], time.process_time()
        questions = [kind.question(name, i) for i in range(kind.count)]
        entries[name] = [Entry(name, question, kind.ask(question)) for question in questions]
        print(f"{name:32} {kind.count:5} {time.process_time() - begin:6.1f} s", flush=True)
    lines = "".join(json.dumps(entry) + "\n" for asked in entries.values() for entry in asked)
    ANSWERS.write_bytes(gzip.compress(lines.encode(), 9, mtime=0))


def compare(entries: list[Entry]) -> int:
    """Print one line a kind, then every finding, and return how many of them are differences."""
    wrong, told = 0, []
    for name in dict.fromkeys(entry.kind for entry in entries):
        asked = [entry for entry in entries if entry.kind == name]
        found = [(entry, list(entry.findings(KINDS[name].ask(entry.question)))) for entry in asked]
        differ = sum(any(not f.allowed for f in findings) for _, findings in found)
        changed = sum(bool(findings) for _, findings in found) - differ
        print(f"{name:32} {len(asked):5} asked, {differ} differ, {changed} allowed to", flush=True)
        told += [(entry, findings) for entry, findings in found if findings]
        wrong += differ
    for entry, findings in told:
        print(f"\n{entry.question}  # {entry.kind}")
        for allowed, where, what in findings:
            print(f"    {'allowed' if allowed else 'DIFFERS'}: answer{where}: {what}")
    return wrong


def main(argv: list[str] | None = None) -> int:
    """Run the command; return 1 where something differs."""
    parser = argparse.ArgumentParser(prog="python -m tests.corpus", description=__doc__)
    parser.add_argument("command", choices=("make", "compare"))
    parser.add_argument("--only", choices=[*KINDS], help="one kind of question")
    parser.add_argument("--interface", action="store_true", help="the public interface and the speed alone")
    options = parser.parse_args(argv)
    names = [options.only] if options.only else [] if options.interface else [*KINDS]
    whole = options.only is None
    if options.command == "make":
        make(names)
        if whole:
            snapshot.write()
        return 0
    wrong = compare([entry for entry in stored() if entry.kind in names])
    if whole:
        wrong += snapshot.compare()
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
