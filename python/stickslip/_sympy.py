"""Systems from expressions of SymPy."""

from __future__ import annotations

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
    expression,
    pi,
    t,
)

#: SymPy's functions by name, on symbols.
_FUNCTIONS: dict[str, Any] = {
    **{name: getattr(np, name) for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp")},
    **{"asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2},
    **{"log": np.log, "Abs": np.abs},
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

    def __getitem__(self, one: Any) -> Expression:
        """The formula of a symbol, or of any expression of the same symbols."""
        return _formula(one, self._known)


def from_sympy(
    equations: Any, parameters: Mapping[Any, float] | None = None
) -> SympySystem:
    """Makes the rates of a system from expressions of SymPy.

    Parameters
    ----------
    equations : dict, or KanesMethod or LagrangesMethod of sympy.physics.mechanics
        The rate of each state, ``{x: v, v: -x}``, with symbols or `dynamicsymbols` as states; or a
        method whose equations of motion are formed.
    parameters : dict, optional
        The value of each further symbol, by symbol or name.

    Returns
    -------
    SympySystem

    Raises
    ------
    ValueError
        If a symbol has no value, or an expression has no formula, such as a sign or a condition.

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
    rates = equations if isinstance(equations, Mapping) else _of_method(equations)
    known: dict[Any, Expression] = {one: State(_name(one)) for one in rates}
    values = {_name(key): value for key, value in (parameters or {}).items()}
    import sympy

    found: set[Any] = set()
    for rate in rates.values():
        found |= sympy.sympify(rate).free_symbols
    time = sympy.Symbol("t")
    for one in sorted(found - known.keys(), key=str):
        if one == time or one.name == "t":
            known[one] = t
            continue
        if one.name not in values:
            raise ValueError(f"the symbol {one} is no state and has no value: add it to parameters")
        known[one] = Parameter(one.name, values.pop(one.name))
    for name, value in values.items():
        # It may stand in contacts and jumps alone.
        known[sympy.Symbol(name)] = Parameter(name, value)
    formulas = {known[one]: _formula(rate, known) for one, rate in rates.items()}
    states = tuple(one for one in formulas if isinstance(one, State))
    own = [one for one in known.values() if isinstance(one, Parameter)]
    own.sort(key=lambda one: one.name)
    return SympySystem({one: formulas[one] for one in states}, states, tuple(own), known)


def _name(one: Any) -> str:
    """The name of a symbol, or of a function of time."""
    if isinstance(one, str):
        return one
    return str(getattr(one, "name", None) or one.func.__name__)


def _of_method(method: Any) -> dict[Any, Any]:
    """The rates of a method of sympy.physics.mechanics."""
    import sympy

    if not (hasattr(method, "mass_matrix_full") and hasattr(method, "forcing_full")):
        raise TypeError(
            f"equations must be {{state: rate, …}} or a method of sympy.physics.mechanics, not "
            f"{type(method).__name__}"
        )
    q = list(method.q)
    # Lagrange's speeds are derivatives, which become states of their own.
    speeds = getattr(method, "u", None)
    derivatives = [one.diff() for one in q] if not speeds else []
    names = {one: sympy.Symbol(f"d{_name(of)}") for one, of in zip(derivatives, q)}
    u = list(speeds) if speeds else list(names.values())
    kinematic = getattr(method, "kindiffdict", None)
    replaced = {**names, **(kinematic() if kinematic else {})}
    solved = method.mass_matrix_full.LUsolve(method.forcing_full)
    solved = [sympy.simplify(one.subs(replaced)) for one in solved]
    return dict(zip([*q, *u], solved))


def _formula(one: Any, known: Mapping[Any, Expression]) -> Expression:
    """The formula of an expression of SymPy."""
    import sympy

    one = sympy.sympify(one)
    if one in known:
        return known[one]
    part, rest = one.as_coeff_Mul()
    if part == -1 and rest != 1:
        return -_formula(rest, known)
    of: Sequence[Expression] = ()
    kind = one.func.__name__
    if one.is_Number:
        return expression(float(one))
    if one is sympy.pi:
        return pi
    if one.is_NumberSymbol:
        return expression(float(one))
    if kind not in _INSTEAD:
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
