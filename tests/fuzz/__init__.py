"""The attack on the package as a tool: ``make fuzz SEEDS=3``, or ``python -m tests.fuzz --help``.

Each attack is a module with a function ``check(rng) -> Found`` that draws one question, asks the package, compares the
answer with something independent and returns how many answers it compared and a line for each that is wrong.  A case is
reproduced by the name of the attack, the seed and the number of the case.

The thirteen attacks: junk to every public callable, mutated command lines, damaged files, kills, full disks, ranges
against scans by an oracle that shares nothing with the package, verdicts against it and against many digits, kicks
against scans, the same question in every way it can be asked, threads, forks and signals.  A failure is one line that
begins with the command that draws its case again, `python -m tests.fuzz --only ranges --seed 17 --case 5`.  `make test`
runs a short piece of each.

A new public callable needs a line in `calls.py`, a new guarantee one in the table of `docs/theory/trust.md`, with the
test that would fail if it were broken: the suite checks both.
"""
