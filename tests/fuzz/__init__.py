"""The attack on the package as a tool: ``make fuzz SEEDS=3``, or ``PYTHONPATH=tests python -m fuzz --help``.

Each attack is a module with a function ``check(rng) -> Found`` that draws one question, asks the package, compares the
answer with something independent and returns how many answers it compared and a line for each that is wrong.  A case is
reproduced by the name of the attack, the seed and the number of the case.
"""
