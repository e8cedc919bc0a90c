"""Systems from expressions of SymPy."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from operator import add, mul
from typing import Any

import numpy as np

from ._symbols import (
    Expression,
    Parameter,
    State,
    check_name,
    erf,
    expression,
    pi,
    t,
)

#: SymPy's functions by name, on symbols.
_FUNCTIONS: dict[str, Any] = {
    **{name: getattr(np, name) for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp")},
    **{"asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2},
    **{"log": np.log, "Abs": np.abs, "erf": erf},
    "sec": lambda x: 1 / np.cos(x),
    "csc": lambda x: 1 / np.sin(x),
    "cot": lambda x: np.cos(x) / np.sin(x),
    "Max": lambda *of: reduce(np.maximum, of),
    "Min": lambda *of: reduce(np.minimum, of),
}
_INSTEAD = {
    "sign": "a sign is the side of a Contact: leave the friction out, and add contact.friction",
    "Heaviside": "two formulas are contact.by_side(below, above) of a Contact",
    "Piecewise": "two formulas are contact.by_side(below, above) of a Contact",
    "DiracDelta": "an instantaneous change is a Jump",
}


@dataclass(frozen=True)
class SympySystem:
    """Rates from SymPy as formulas, and the symbols in them.

    Attributes
    ----------
    rates : dict
        The rate of each state, as `System` takes it. Contacts may be added to them.
    states : tuple of State
        The states, in the order of the rates.
    parameters : tuple of Parameter
        The parameters, sorted by name.
    """

    rates: dict[State, Expression]
    states: tuple[State, ...]
    parameters: tuple[Parameter, ...]
    _known: dict[Any, Expression] = field(repr=False)
    _equations: dict[Any, Any] = field(default_factory=dict, repr=False)

    def __getitem__(self, one: Any) -> Expression:
        """The formula of a symbol, or of any expression of the same symbols."""
        return _formula(_resolved(one, self._equations), self._known)


def from_sympy(
    equations: Any, parameters: Mapping[Any, float] | None = None
) -> SympySystem:
    """Makes the rates of a system from expressions of SymPy.

    Parameters
    ----------
    equations : dict, or KanesMethod or LagrangesMethod of sympy.physics.mechanics
        The rate of each state, ``{x: v, v: -x}``, with symbols, `dynamicsymbols` or their
        derivatives as states; or a method whose equations of motion are formed. The derivative
        ``q.diff()`` as a state is called ``dq``. The derivative of a state in a rate is its rate.
    parameters : dict, optional
        The value of each further symbol, by symbol or name.

    Returns
    -------
    SympySystem

    Raises
    ------
    ValueError
        If a symbol has no value, two symbols have one name, a name cannot stand in formulas, or
        an expression has no formula, such as a sign or a condition.

    Examples
    --------
    >>> import sympy
    >>> import stickslip as ss
    >>> x, v, k = sympy.symbols("x v k")
    >>> made = ss.from_sympy({x: v, v: -k * sympy.sin(x)}, {k: 2})
    >>> made.rates
    {x: v, v: -(k * sin(x))}
    >>> floor = ss.Contact("floor", boundary=made[v], friction=0.1)
    >>> made.rates[made[v]] -= floor.friction
    >>> ss.System(made.rates, contacts=[floor]).states
    ('x', 'v')
    """
    import sympy

    given = equations if isinstance(equations, Mapping) else _of_method(equations)
    given = {sympy.Symbol(one) if isinstance(one, str) else one: of for one, of in given.items()}
    owners: dict[str, Any] = {}
    known: dict[Any, Expression] = {one: State(_own_name(one, owners)) for one in given}
    if "t" in owners:
        raise ValueError(f"the state {owners['t']} has the name of time: rename it")
    rates = {one: _resolved(rate, given) for one, rate in given.items()}
    values: dict[str, Any] = {}
    for key, value in (parameters or {}).items():
        name = _name(key)
        if name in values:
            raise ValueError(f"parameters has {name} twice: give one value")
        if name in owners or name == "t":
            what = "time" if name == "t" else "a state"
            raise ValueError(f"parameters has a value of {name}, which is {what}: rename one")
        values[name] = value

    found: set[Any] = set()
    for rate in rates.values():
        found |= rate.free_symbols
    for one in sorted(found - known.keys(), key=str):
        if one.name == "t":
            known[one] = t
            continue
        name = _own_name(one, owners)
        if name not in values:
            raise ValueError(f"the symbol {one} is no state and has no value: add it to parameters")
        known[one] = Parameter(name, values.pop(name))
    for name, value in values.items():
        # It may stand in contacts and jumps alone.
        own = [key for key in parameters or {} if not isinstance(key, str) and _name(key) == name]
        known[own[0] if own else sympy.Symbol(name)] = Parameter(name, value)
    known.setdefault(sympy.Symbol("t"), t)
    formulas = {known[one]: _formula(rate, known) for one, rate in rates.items()}
    states = tuple(one for one in formulas if isinstance(one, State))
    made = [one for one in known.values() if isinstance(one, Parameter)]
    made.sort(key=lambda one: one.name)
    return SympySystem({one: formulas[one] for one in states}, states, tuple(made), known, rates)


def _name(one: Any) -> str:
    """The name of a symbol, of a function of time, or of its derivative."""
    import sympy

    if isinstance(one, sympy.Derivative):
        return "d" * one.derivative_count + _name(one.expr)
    if isinstance(one, str):
        name = one
    elif isinstance(one, sympy.Symbol):
        name = one.name
    elif isinstance(one, sympy.core.function.AppliedUndef):
        name = one.func.__name__
    else:
        raise TypeError(f"{one!r} is no symbol of SymPy and no function of time")
    try:
        return check_name(name)
    except ValueError:
        like = re.sub(r"\W", "", name).strip("_")
        help = f", as sympy.Symbol({like!r})" if like[:1].isalpha() else ""
        raise ValueError(
            f"the symbol {name} of SymPy has a name that cannot stand in formulas: rename it{help}"
        ) from None


def _own_name(one: Any, owners: dict[str, Any]) -> str:
    """The name of a symbol, which no other symbol among `owners` has."""
    name = _name(one)
    if owners.setdefault(name, one) != one:
        other = owners[name]
        how = "which have other assumptions" if str(other) == str(one) else f"{other} and {one}"
        raise ValueError(f"two symbols would be called {name}, {how}: rename one")
    return name


def _of_method(method: Any) -> dict[Any, Any]:
    """The rates of a method of sympy.physics.mechanics."""
    import sympy

    if not (hasattr(method, "mass_matrix_full") and hasattr(method, "forcing_full")):
        raise TypeError(
            f"equations must be {{state: rate, …}} or a method of sympy.physics.mechanics, not "
            f"{type(method).__name__}"
        )
    q = list(method.q)
    # Older versions of SymPy do not list Lagrange's speeds, which are derivatives.
    u = list(getattr(method, "u", None) or [one.diff() for one in q])
    kinematic = getattr(method, "kindiffdict", None)
    replaced = kinematic() if kinematic else {}
    solved = method.mass_matrix_full.LUsolve(method.forcing_full)
    solved = [sympy.simplify(one.subs(replaced)) for one in solved]
    return dict(zip([*q, *u], solved))


def _resolved(one: Any, rates: Mapping[Any, Any]) -> Any:
    """An expression without derivatives, except those that are states: the derivative of a state is
    its rate."""
    import sympy

    one = sympy.sympify(one)
    # Each pass goes at least one rate deeper, unless rates refer to each other in a circle.
    for _ in range(len(rates) + 1):
        apart = [each for each in one.atoms(sympy.Derivative) if each not in rates]
        if not apart:
            return one
        one = one.xreplace({each: _rate_of(each, rates) for each in apart})
    raise ValueError(
        f"{apart[0]} depends on itself: solve the equations for the rates first, by sympy.solve"
    )


def _rate_of(derivative: Any, rates: Mapping[Any, Any]) -> Any:
    """The derivative of a state by its rate."""
    import sympy

    base, by = derivative.expr, derivative.variables
    if any(str(one) != "t" for one in by):
        raise ValueError(f"{derivative} has no formula: it is no derivative by time")
    # The highest derivative that is a state, else the function itself.
    for count in range(len(by) - 1, -1, -1):
        lower = base.diff(*by[:count]) if count else base
        if lower in rates:
            rest = by[count + 1 :]
            rate = sympy.sympify(rates[lower])
            return rate.diff(*rest) if rest else rate
    done = derivative.doit()
    if done == derivative:
        raise ValueError(
            f"{derivative} is the derivative of {base}, which is no state: add it to the rates"
        )
    return done


def _formula(one: Any, known: Mapping[Any, Expression]) -> Expression:
    """The formula of an expression of SymPy."""
    import sympy

    one = sympy.sympify(one)
    if one in known:
        return known[one]
    kind = one.func.__name__
    if kind not in _INSTEAD and not isinstance(one, sympy.Expr):
        is_condition = isinstance(one, sympy.logic.boolalg.Boolean)
        help = _INSTEAD["Piecewise"] if is_condition else "it is no number"
        raise ValueError(f"{one} has no formula: {help}")
    part, rest = one.as_coeff_Mul()
    if part == -1 and rest != 1:
        return -_formula(rest, known)
    of: Sequence[Expression] = ()
    if one.is_Number:
        return expression(float(one))
    if one is sympy.pi:
        return pi
    if one.is_NumberSymbol:
        return expression(float(one))
    if kind not in _INSTEAD and all(isinstance(part, sympy.Expr) for part in one.args):
        of = [_formula(part, known) for part in one.args]
    if one.is_Add:
        return reduce(add, of)
    if one.is_Mul:
        return reduce(mul, of)
    if one.is_Pow:
        if one.exp == sympy.Rational(1, 2):
            return np.sqrt(of[0])  # type: ignore[no-any-return]
        if one.exp == -1:
            return 1 / of[0]
        return of[0] ** of[1]
    if kind in _FUNCTIONS:
        return _FUNCTIONS[kind](*of)  # type: ignore[no-any-return]
    help = _INSTEAD.get(kind, f"the functions are {', '.join(sorted(_FUNCTIONS))}, sqrt")
    if one.is_Symbol or isinstance(one, sympy.core.function.AppliedUndef):
        help = "it is no state and no parameter: add it to the rates or to parameters"
    raise ValueError(f"{one} has no formula: {help}")
