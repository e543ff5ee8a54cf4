"""Answers of the package with their stated errors, kept, and compared with what it answers now.

Kept are some 5,100 questions over everything public with the answers given when they were made, the public interface,
and ratios of speed.  A question is a Python expression, stored with its answer as a line of JSON, so that no comparison
depends on how questions were drawn.  `kinds.py` has the one table of what is asked, `questions.py`
draws questions, `answers.py` says how a result becomes JSON and when two answers differ, `snapshot.py` what the public
interface is, and the ratios of speed.

`python -m tests.corpus compare` asks everything again, with `--only KIND` one kind: a number may differ by the sum of
the errors stated, or by the tolerance of its kind (`kinds.py`, with its reason); a status may not, unless it was
undecided. `make slow` does so, `make test` with a hundred of them.

`python -m tests.corpus make` answers anew and writes, `--only KIND` one kind, `--interface` names and speed
alone.  That is allowed where an answer was wrong or a name is removed by intent, which the changelog says, or for
more kinds; never for an answer that merely differs: compare first, and only what the changelog names may differ.
"""
