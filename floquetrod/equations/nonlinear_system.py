"""Nonlinear systems x' = f(t, x, p) as values: forced, with a period, or autonomous."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.calling import constructor_hints
from floquetrod._util.content import ByContent
from floquetrod._util.formulas import Formula
from floquetrod._util.suggest import did_you_mean
from floquetrod.equations.hill_system import HillSystem
from floquetrod.equations.rates import RateFunction

_ALL_AT_ONCE = ("p", "params", "parameters")  # names of an argument that takes all parameters
_TIMES = ("t", "time")  # names of the first argument


@constructor_hints(frequency="period is 2 pi / frequency, as in period='2*pi/frequency'")
@dataclass(frozen=True, eq=False, repr=False)
class NonlinearSystem(ByContent):
    """The system x' = f(t, x, p) of n equations of first order, its parameters p by name.

    Forced where f has a period in t, autonomous where none is given: then f must not depend on t.

    Parameters
    ----------
    function : callable (t, x, and parameters by name) -> n numbers
        f.  It is called with many instants at once, t (k,) and x (n, k), where that gives the same as one at a time:
        write it with numpy, ``def f(t, x, mu): return x[1], mu * (1 - x[0] ** 2) * x[1] - x[0]``.  One compiled by
        numba is called from compiled code, with x (n,).  A function ``f(t, x, p)``, or with ``parameters`` in place
        of ``p``, is given all of them there, as a mapping: ``p["mu"]``.
    jacobian : callable (t, x, and parameters by name) -> (n, n), optional
        Derivatives, df_i / dx_j in row i and column j; checked against differences of ``function``.  Left out, they are
        computed by complex steps where f allows that, to rounding, else by differences.
    period : float, str or callable (of parameters by name), optional
        Period of f in t.  Where it depends on parameters: a formula such as "2*pi/omega", or a function of some.
    parameters : mapping of str to float
        Values of the parameters, by the names with which f takes them.

    Raises
    ------
    TypeError, ValueError
        For a function that does not take its arguments, a period not above 0, and parameters that are not
        numbers.

    Examples
    --------
    >>> def duffing(t, x, omega):
    ...     return x[1], np.cos(omega * t) - 0.2 * x[1] - x[0] - x[0] ** 3
    >>> system = NonlinearSystem(duffing, period="2*pi/omega", parameters={"omega": 1.2})
    >>> round(system.with_parameters(omega=2.0).period, 9)
    3.141592654
    """

    function: Callable[..., Any]
    jacobian: Callable[..., Any] | None = None
    given_period: Any = None
    parameters: Mapping[str, float] = field(default_factory=dict)
    evaluated: RateFunction = field(init=False, compare=False)

    def __init__(
        self,
        function: Callable[..., Any],
        jacobian: Callable[..., Any] | None = None,
        period: Any = None,
        parameters: Mapping[str, float] | None = None,
    ) -> None:
        """Check the parameters."""
        validate.function("function", function)
        if jacobian is not None:
            validate.function("jacobian", jacobian)
        given = _numbers(parameters)
        function, jacobian = _by_name(function, given), _by_name(jacobian, given)
        for name, call in (("function", function), ("jacobian", jacobian)):
            _require_names(name, call, given)
        _take(self, function, jacobian, period, given, RateFunction(function, jacobian))
        _ = self.period

    @classmethod
    def from_sympy(
        cls,
        equations: Sequence[Any],
        states: Sequence[Any],
        *,
        time: Any = None,
        period: Any = None,
        parameters: Mapping[Any, float] | None = None,
    ) -> NonlinearSystem:
        """Return the system whose rates are sympy expressions; sympy derives their derivatives.

        Parameters
        ----------
        equations : sequence of sympy expressions
            The rates, one for each state.
        states : sequence of sympy symbols
        time : sympy symbol, optional
            Needed where the rates depend on time.
        period : float, str or sympy expression, optional
            As of the system.
        parameters : mapping of sympy symbols or str to float
            Values of all other symbols.

        Returns
        -------
        NonlinearSystem
            With the jacobian that sympy derives.

        Raises
        ------
        TypeError, ValueError
            For symbols without a value, and where the rates are not as many as the states.

        Examples
        --------
        >>> import sympy
        >>> x, v, mu = sympy.symbols("x v mu")
        >>> NonlinearSystem.from_sympy([v, mu * (1 - x**2) * v - x], [x, v], parameters={mu: 1.0})
        NonlinearSystem([v, mu*v*(1 - x**2) - x], parameters={'mu': 1.0})
        """
        from floquetrod.equations.symbolic import lambdified

        given = {str(name): value for name, value in _mapping(parameters).items()}
        function, jacobian = lambdified(equations, states, time, given)
        if period is not None and not isinstance(period, str) and not callable(period) and not _is_number(period):
            period = str(period)
        return cls(function, jacobian, period, given)

    @classmethod
    def from_hill(
        cls,
        system: HillSystem,
        force: Callable[..., Any],
        *,
        period: Any = "of the system",
        parameters: Mapping[str, float] | None = None,
    ) -> NonlinearSystem:
        """Return M q'' + (C + G) q' + K(t) q = force(t, q, q', p) in first order, x = (q, q').

        Parameters
        ----------
        system : HillSystem
            The linear part.
        force : callable (t, q, velocity, and parameters by name) -> n numbers
            The nonlinear part and the forcing, on the right side; of arrays q (n, k) as a function of a system.
        period : float, str or callable, optional
            Period of both together; by default the period of the linear part, None where its coefficients are constant
            and the force does not depend on time either.
        parameters : mapping of str to float
            Of the force.

        Returns
        -------
        NonlinearSystem
            Of 2 n equations of first order.

        Raises
        ------
        TypeError, ValueError
            For anything but a system, a force that does not take its arguments, and parameters that are not
            numbers.

        Examples
        --------
        >>> pendulum = HillSystem([[1.0]], damping=[[0.2]])
        >>> system = NonlinearSystem.from_hill(pendulum, lambda t, q, v: np.cos(t) - q**3, period=2 * np.pi)
        >>> system.rates([0.0], [[1.0, 0.0]]).tolist()
        [[0.0, -1.0]]
        """
        from floquetrod.equations.linear_part import WithLinearPart

        validate.instance("system", system, HillSystem)
        validate.function("force", force)
        given = _numbers(parameters)
        _require_names("force", force, given, "t, q and velocity")
        if isinstance(period, str) and period == "of the system":
            period = None if system.is_constant else float(system.period)
        function = WithLinearPart(system, force)
        nonlinear = object.__new__(cls)
        _take(nonlinear, function, None, period, given, RateFunction(function, None))
        _ = nonlinear.period
        return nonlinear

    @property
    def is_autonomous(self) -> bool:
        """Whether no period is given."""
        return self.given_period is None

    @cached_property
    def period(self) -> float | None:
        """Period of f in t at the values of the parameters; None where it is autonomous."""
        given = self.given_period
        if given is None:
            return None
        if isinstance(given, str):
            given = _formula(given, self.parameters)
        elif callable(given):
            wanted = inspect.signature(given).parameters
            takes_all = any(parameter.kind is parameter.VAR_KEYWORD for parameter in wanted.values())
            known = {name: value for name, value in self.parameters.items() if takes_all or name in wanted}
            try:
                given = given(**known)
            except TypeError as error:
                raise TypeError(f"period must be a function of parameters, called by their names: {error}") from error
        return validate.positive("period", given)

    def with_parameters(self, **parameters: float) -> NonlinearSystem:
        """Return the same system with other values of some parameters.

        Returns
        -------
        NonlinearSystem
            With the same function.

        Raises
        ------
        TypeError, ValueError
            For a name that is no parameter, and for values that are not numbers.

        Examples
        --------
        >>> system = NonlinearSystem(lambda t, x, a: (-a * x[0],), parameters={"a": 1.0})
        >>> dict(system.with_parameters(a=2.0).parameters)
        {'a': 2.0}
        """
        for name in parameters:
            self.require_parameter(name)
        changed = {**self.parameters, **_numbers(parameters)}
        system = object.__new__(type(self))
        _take(system, self.function, self.jacobian, self.given_period, changed, self.evaluated)
        return system

    def require_parameter(self, name: Any, argument: str = "parameters") -> None:
        """Raise ValueError, about an argument, where there is no parameter of this name."""
        if name not in self.parameters:
            known = ", ".join(self.parameters) or "none"
            hint = did_you_mean(str(name), list(self.parameters)) or f"; it has {known}"
            raise ValueError(f"{argument} has {validate.short(name)}, which is no parameter{hint}")

    def rates(self, times: Any, states: Any) -> Floats:
        """Return f at k instants, times (k,) and states (k, n), as an array (k, n).

        Returns
        -------
        ndarray
            (k, n).
        """
        return self.evaluated.values(np.asarray(times, float), np.asarray(states, float), self.parameters)

    def jacobians(self, times: Any, states: Any) -> Floats:
        """Return the derivatives of f at k instants, (k, n, n).

        Returns
        -------
        ndarray
            df_i / dx_j in row i and column j.
        """
        return self.evaluated.derivatives(np.asarray(times, float), np.asarray(states, float), self.parameters)

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields, with parameters as a dictionary."""
        return {**vars(self), "parameters": dict(self.parameters)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take it over."""
        vars(self).update(state, parameters=MappingProxyType(state["parameters"]))

    def __repr__(self) -> str:
        """Return the call that makes the system."""
        name = getattr(self.function, "__name__", None) or repr(self.function)
        arguments = [name]
        arguments += [] if self.given_period is None else [f"period={self.given_period!r}"]
        arguments += [f"parameters={dict(self.parameters)!r}"] if self.parameters else []
        return f"NonlinearSystem({', '.join(arguments)})"


def _take(
    system: NonlinearSystem,
    function: Any,
    jacobian: Any,
    period: Any,
    parameters: Mapping[str, float],
    rates: RateFunction,
) -> None:
    """Fill in the fields of a new system."""
    vars(system).update(
        function=function,
        jacobian=jacobian,
        given_period=period,
        parameters=MappingProxyType(dict(parameters)),
        evaluated=rates,
    )


def _mapping(parameters: Any) -> Mapping[Any, Any]:
    """Return a mapping, an empty one for None."""
    if parameters is None:
        return {}
    if not isinstance(parameters, Mapping):
        raise TypeError(f"parameters must be a mapping of names to numbers, got {validate.short(parameters)}")
    return parameters


def _numbers(parameters: Any) -> dict[str, float]:
    """Return parameters, checked."""
    parameters = _mapping(parameters)
    for name in parameters:
        if not isinstance(name, str) or not name.isidentifier():
            raise TypeError(f"parameters must have names as Python's arguments have, got {validate.short(name)}")
    return {name: validate.finite(f"parameters['{name}']", value) for name, value in parameters.items()}


@dataclass(frozen=True)
class _WithMapping:
    """A function of t, x and a mapping of all parameters, called with them by name."""

    function: Callable[..., Any]

    def __call__(self, t: Any, x: Any, **parameters: float) -> Any:
        """Return the function's value."""
        return self.function(t, x, parameters)


def _by_name(function: Any, given: Mapping[str, float]) -> Any:
    """Return a function that takes parameters by name: the given one, or a wrapper where it takes a mapping."""
    if function is None or hasattr(function, "py_func"):
        return function
    try:
        wanted = list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError):  # it does not say
        return function
    names = [parameter.name for parameter in wanted[2:] if parameter.kind is not parameter.VAR_KEYWORD]
    takes_mapping = len(names) == 1 and names[0] in _ALL_AT_ONCE and names[0] not in given
    return _WithMapping(function) if takes_mapping else function


def _require_names(argument: str, function: Any, given: Mapping[str, float], others: str = "t and x") -> None:
    """Raise ValueError where a function does not take a parameter, or needs one that is not given."""
    if function is None:
        return
    try:
        wanted = inspect.signature(getattr(function, "py_func", function)).parameters.values()
    except (TypeError, ValueError):  # it does not say
        return
    positional = [
        parameter
        for parameter in wanted
        if parameter.kind in (parameter.POSITIONAL_ONLY, parameter.POSITIONAL_OR_KEYWORD)
    ]
    first = len(others.replace(" and", ",").split(","))
    if len(positional) < first and not any(parameter.kind is parameter.VAR_POSITIONAL for parameter in wanted):
        raise TypeError(f"{argument} must take {others}, and then the parameters by name")
    if any(parameter.name in _TIMES for parameter in positional[1:first]):
        came = ", ".join(parameter.name for parameter in positional[:first])
        raise TypeError(f"{argument} must take {others} in this order, got one that takes ({came})")
    named = [*positional[first:], *(parameter for parameter in wanted if parameter.kind is parameter.KEYWORD_ONLY)]
    names = [parameter.name for parameter in named]
    takes_all = any(parameter.kind is parameter.VAR_KEYWORD for parameter in wanted)
    for name in given:
        if name not in names and not takes_all:
            hint = did_you_mean(name, names) or f"; it takes {', '.join(names) or others + ' only'}"
            raise ValueError(f"parameters has {name!r}, which {argument} does not take{hint}")
    for parameter in named:
        if parameter.default is parameter.empty and parameter.name not in given:
            raise ValueError(f"parameters must have a value of {parameter.name!r}, which {argument} takes")


def _formula(text: str, parameters: Mapping[str, float]) -> Any:
    """Return the value of a formula of parameters."""
    try:
        return Formula.read(text).value(parameters)
    except ValueError as error:
        raise ValueError(f"period must be a number or a formula such as '2*pi/omega', got {error}") from None


def _is_number(value: Any) -> bool:
    try:
        float(value)
    except TypeError:
        return False
    return True
