"""Answers of the package with their stated errors, kept, and compared with what it answers now.

`python -m tests.corpus compare` asks everything again; `python -m tests.corpus make` answers anew and writes, and when
that is allowed is in CONTRIBUTING.md.  A question is a Python expression, stored with its answer as a line of JSON, so
that no comparison depends on how questions were drawn.  `kinds.py` has the one table of what is asked, `questions.py`
draws questions, `answers.py` says how a result becomes JSON and when two answers differ, `snapshot.py` what the public
interface is, and the ratios of speed.
"""
