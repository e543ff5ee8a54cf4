"""`floquetrod compare`: one equation, every method."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping

import floquetrod as fr
from floquetrod._util.waiting import Waiting
from floquetrod.cli.common import describe_command
from floquetrod.cli.messages import option
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser, real_number
from floquetrod.equations import Equation
from floquetrod.equations.mathieu import MATHIEU, MATHIEU_AQ, MATHIEU_DELTA
from floquetrod.parameter import REQUIRED, Parameter

_HELP = """\
Decide the stability of Mathieu's equation, or of the same with a square wave, by every method, and show where they
agree.

examples:
  floquetrod compare --a 1.2 --q 0.9
  floquetrod compare --alpha 0.5 --beta -0.25
  floquetrod compare --alpha 0.5 --beta -0.25 --damping 0.1 --waveform square
  floquetrod compare --delta 0.25 --epsilon 0.5 --json

The equation is in one of three forms, and growth is per unit of its own time:
  --a, --q             y'' + 2 c y' + (a - 2 q cos 2z) y = 0
  --alpha, --beta      A'' + 2 c A' = (beta + alpha sin tau) A
  --delta, --epsilon   x'' + 2 c x' + (delta + epsilon cos t) x = 0, answered in tau = t - pi / 2
"""

_FORMS: tuple[tuple[Mapping[str, Parameter], Callable[..., Equation]], ...] = (
    (MATHIEU_AQ, fr.Mathieu.from_aq),
    (MATHIEU, fr.Mathieu),
    (MATHIEU_DELTA, fr.Mathieu.from_delta_epsilon),
)
"""Forms of the equation: their parameters, and what makes the equation of them."""

_EVERY = {name: parameter for parameters, _ in _FORMS for name, parameter in parameters.items()}


_EXAMPLES = {"a": "--a 1.2 --q 0.9", "alpha": "--alpha 0.5 --beta -0.25", "delta": "--delta 0.25 --epsilon 0.5"}
"""Options with which each form is asked about, by its first parameter."""


def with_parameter(typed: str) -> str:
    """Return an example of the form that has a parameter, by its option; "" for the options that all forms have."""
    forms = (_required(parameters) for parameters, _ in _FORMS)
    return next((_EXAMPLES[names[0]] for names in forms if typed in map(option, names)), "")


def add(compare: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(compare, _HELP, _compare, ("a", "q", "alpha", "beta", "damping"))
    for name, parameter in _EVERY.items():
        if parameter.option is not None:
            help_, metavar, *_ = parameter.option
            compare.add_argument(option(name), metavar=metavar, type=real_number, help=help_)
    compare.add_argument(
        "--waveform", choices=("sine", "square"), default="sine", help="of --alpha: sin tau, or its sign (default sine)"
    )


def _compare(options: argparse.Namespace) -> Output:
    equation = _equation(options)
    with Waiting("asking every method"):
        comparison = fr.compare(equation)
    return output(options, comparison.report, comparison.as_dict)


def _equation(options: argparse.Namespace) -> Equation:
    """Return the equation in the form whose parameters were typed."""
    numbers = {name: number for name in _EVERY if (number := getattr(options, name)) is not None}
    names = _required(numbers)
    for parameters, make in _FORMS:
        if set(names) == set(_required(parameters)):
            if options.waveform == "sine":
                return make(**numbers)
            if parameters is MATHIEU:
                return fr.Meissner(**numbers)
            raise ValueError(
                f"--waveform square needs --alpha and --beta, got {_and(names)}: its coefficient is beta + alpha "
                "sign(sin tau)"
            )
        missing = [name for name in _required(parameters) if name not in names]
        if names and set(names) < set(_required(parameters)):
            raise ValueError(f"{_and(missing)} is required with {_and(names)} (see floquetrod compare --help)")
    pairs = ", or ".join(_and(_required(parameters)) for parameters, _ in _FORMS)
    raise ValueError(f"the equation needs {pairs}, got {_and(names) or 'none of them'}")


def _required(names: Iterable[str]) -> list[str]:
    """Return the names of parameters that a form needs."""
    return [name for name in names if _EVERY[name].default is REQUIRED]


def _and(names: Iterable[str]) -> str:
    return " and ".join(map(option, names))
