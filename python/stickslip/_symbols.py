"""Symbols, whose arithmetic writes the formulas that the engine reads."""

from __future__ import annotations

import math
import numbers
import operator
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ._errors import OptionError

Direction = Literal["rising", "falling", "both"]

# Precedence of operators.
_SUM, _PRODUCT, _SIGN, _POWER, _ATOM = range(5)

_STEPS = (
    "formulas have no steps. A remainder of time is period * ss.sawtooth(name, period). An angle x "
    "is taken back by ss.Jump(name, when=x - 2*ss.pi, direction=1, set={x: 0}). What counts or "
    "rounds is a discrete state that jumps set (ss.discrete)"
)
_SIDES = (
    "a sign is the `.side` of a Contact (of a state) or a Switch (of time), so that each side's "
    "formula goes on smoothly; two formulas are contact.by_side(below, above)"
)
_COMPARED = (
    "A field with two sides is written with a Contact: contact.by_side(below, above). Bounds are "
    "np.minimum and np.maximum of single symbols. Events and jumps are where a formula is zero, "
    "with a direction. A comparison is the condition of a ss.Jump, or chooses what it sets: "
    "np.where(a < b, then, otherwise); several are joined by &, | and ~"
)
_OF_SYMPY = (
    "a formula cannot have both. ss.from_sympy makes formulas from expressions of SymPy, and a "
    "parameter is made by ss.parameter"
)


def _refuses(operation: str, remedy: str) -> Callable[..., Any]:
    """A method that raises with a remedy; `{}` in the operation stands for the formula."""

    def method(self: Expression, *of: Any) -> Any:
        raise TypeError(f"{operation.format(self.text)} is no formula: {remedy}")

    return method


class Expression:
    """A formula of states, parameters and time.

    Operators and NumPy's functions on it make further formulas. Comparisons by ``<``, ``<=``,
    ``>`` and ``>=`` make a `Condition`. Signs and remainders are no formulas: they raise a
    `TypeError` that says what to write instead.

    Attributes
    ----------
    text : str
        The formula as text.
    parts : frozenset
        The states, parameters, contacts and inputs in it.
    """

    __slots__ = ("text", "_binds", "parts")

    # If several operands have an `__array_ufunc__`, this one is called.
    __array_priority__ = 1000

    def __init__(self, text: str, binds: int = _ATOM, parts: frozenset[Any] = frozenset()) -> None:
        self.text = text
        self._binds = binds
        self.parts = parts

    def __repr__(self) -> str:
        return self.text

    def _repr_latex_(self) -> str:
        from ._latex import latex

        return f"${latex(self.text)}$"

    def __add__(self, other: Any) -> Expression:
        return _binary(self, "+", other, _SUM)

    def __radd__(self, other: Any) -> Expression:
        return _binary(other, "+", self, _SUM)

    def __sub__(self, other: Any) -> Expression:
        return _binary(self, "-", other, _SUM)

    def __rsub__(self, other: Any) -> Expression:
        return _binary(other, "-", self, _SUM)

    def __mul__(self, other: Any) -> Expression:
        return _binary(self, "*", other, _PRODUCT)

    def __rmul__(self, other: Any) -> Expression:
        return _binary(other, "*", self, _PRODUCT)

    def __truediv__(self, other: Any) -> Expression:
        return _binary(self, "/", other, _PRODUCT)

    def __rtruediv__(self, other: Any) -> Expression:
        return _binary(other, "/", self, _PRODUCT)

    def __pow__(self, other: Any) -> Expression:
        return _binary(self, "^", other, _POWER)

    def __rpow__(self, other: Any) -> Expression:
        return _binary(other, "^", self, _POWER)

    def __neg__(self) -> Expression:
        return Expression("-" + _within(self, _SIGN), _SIGN, self.parts)

    def __pos__(self) -> Expression:
        return self

    def __abs__(self) -> Expression:
        return _call("abs", self)

    def __bool__(self) -> bool:
        raise TypeError(
            f"`{self.text}` has no truth value: it is a formula, not a number. What changes where "
            "a function is zero is a Contact (its sign is `.side`), a Jump or a Switch; bounds are "
            "np.minimum and np.maximum"
        )

    def __lt__(self, other: Any) -> Condition:
        return _comparison(self, "<", other)

    def __le__(self, other: Any) -> Condition:
        return _comparison(self, "<=", other)

    def __gt__(self, other: Any) -> Condition:
        return _comparison(self, ">", other)

    def __ge__(self, other: Any) -> Condition:
        return _comparison(self, ">=", other)

    __and__ = __rand__ = _refuses("a condition (`&` with `{}`)", _COMPARED)
    __or__ = __ror__ = _refuses("a condition (`|` with `{}`)", _COMPARED)
    __invert__ = _refuses("a condition (`~{}`)", _COMPARED)
    __xor__ = __rxor__ = _refuses("`^` with `{}`", "a power is x**2")
    __mod__ = __rmod__ = _refuses("a remainder (`%` with `{}`)", _STEPS)
    __floordiv__ = __rfloordiv__ = _refuses("a floored quotient (`//` with `{}`)", _STEPS)
    __divmod__ = __rdivmod__ = _refuses("`divmod` of `{}`", _STEPS)
    __round__ = _refuses("`round` of `{}`", _STEPS)
    __floor__ = _refuses("`floor` of `{}`", _STEPS)
    __ceil__ = _refuses("`ceil` of `{}`", _STEPS)
    __trunc__ = _refuses("`trunc` of `{}`", _STEPS)

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        raise TypeError(f"a comparison (`==` with `{self.text}`) is no formula: {_COMPARED}")

    __hash__ = object.__hash__

    def __float__(self) -> Any:
        raise TypeError(
            f"`{self.text}` is a formula, not a number. Functions that take it are NumPy's, as "
            "np.sin, and not those of math, scipy and np.linalg; an array of formulas has "
            "dtype=object"
        )

    __int__ = __index__ = __complex__ = __float__

    def _sympy_(self) -> Any:
        # SymPy calls it to convert an operand.
        raise TypeError(f"`{self.text}` is a formula, not an expression of SymPy: {_OF_SYMPY}")

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            # On an array of objects, np.sin calls the method `sin` of each.
            function = vars(np).get(name)
            if isinstance(function, np.ufunc):
                return partial(function, self)
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        if method != "__call__" or options:
            return NotImplemented
        if any(isinstance(one, np.ndarray) and one.ndim > 0 for one in inputs):
            arrays = [one if isinstance(one, np.ndarray) else _object(one) for one in inputs]
            return np.frompyfunc(
                lambda *of: self.__array_ufunc__(ufunc, method, *of), len(inputs), 1
            )(*arrays)
        name = ufunc.__name__
        if name in _OPERATORS and len(inputs) == 2:
            sign, binds = _OPERATORS[name]
            return _binary(inputs[0], sign, inputs[1], binds)
        if name in _COMPARISONS and len(inputs) == 2:
            return _comparison(inputs[0], _COMPARISONS[name], inputs[1])
        if name in _FUNCTIONS:
            return _call(_FUNCTIONS[name], *inputs)
        if name in _COMPOSED:
            return _COMPOSED[name](*(expression(one) for one in inputs))
        raise TypeError(f"np.{name} of a formula: {_INSTEAD.get(name, _KNOWN)}")

    def __array_function__(self, function: Any, types: Any, of: Any, options: Any) -> Any:
        name = getattr(function, "__name__", str(function))
        if name in _FUNCTIONS and not options:
            return _call(_FUNCTIONS[name], *of)
        raise TypeError(f"np.{name} of a formula: {_INSTEAD.get(name, _KNOWN)}")


_OPERATORS = {
    "add": ("+", _SUM),
    "subtract": ("-", _SUM),
    "multiply": ("*", _PRODUCT),
    "divide": ("/", _PRODUCT),
    "power": ("^", _POWER),
    "float_power": ("^", _POWER),
}

_COMPARISONS = {"less": "<", "less_equal": "<=", "greater": ">", "greater_equal": ">="}

_FUNCTIONS = {
    "sin": "sin",
    "cos": "cos",
    "tan": "tan",
    "arcsin": "asin",
    "arccos": "acos",
    "arctan": "atan",
    "arctan2": "atan2",
    # Of SciPy.
    "erf": "erf",
    "sinh": "sinh",
    "cosh": "cosh",
    "tanh": "tanh",
    "exp": "exp",
    "log": "ln",
    "log10": "log10",
    "hypot": "hypot",
    "sqrt": "sqrt",
    "absolute": "abs",
    "fabs": "abs",
    "maximum": "max",
    "minimum": "min",
    "fmax": "max",
    "fmin": "min",
    "clip": "clamp",
}

# Functions that are composed of others, exact up to rounding.
_COMPOSED: dict[str, Callable[..., Expression]] = {
    "negative": lambda x: -x,
    "positive": lambda x: x,
    "conjugate": lambda x: x,
    "square": lambda x: x**2,
    "reciprocal": lambda x: 1 / x,
    "log2": lambda x: _call("ln", x) / _call("ln", 2),
    "exp2": lambda x: _call("exp", x * _call("ln", 2)),
    **dict.fromkeys(["deg2rad", "radians"], lambda x: x * (pi / 180)),
    **dict.fromkeys(["rad2deg", "degrees"], lambda x: x * (180 / pi)),
}

_KNOWN = "the functions are np." + ", np.".join(
    sorted({*_FUNCTIONS, *_COMPOSED} - {"erf", "fabs", "fmax", "fmin", "negative", "positive"})
) + " and ss.erf"
_INSTEAD = {
    **dict.fromkeys(["sign", "copysign", "signbit", "heaviside"], _SIDES),
    **dict.fromkeys(["where", "select", "piecewise", "choose"], _SIDES),
    **dict.fromkeys(["equal", "not_equal", "isclose", "allclose"], _COMPARED),
    **dict.fromkeys(["logical_and", "logical_or", "logical_not", "logical_xor"], _COMPARED),
    **dict.fromkeys(["bitwise_and", "bitwise_or", "invert"], _COMPARED),
    **dict.fromkeys(["remainder", "fmod", "floor_divide", "divmod", "modf"], _STEPS),
    **dict.fromkeys(["floor", "ceil", "trunc", "rint", "round", "around", "fix"], _STEPS),
    **dict.fromkeys(
        ["sum", "prod", "mean", "dot", "matmul"],
        "it takes a list of symbols, as np.sum([x, v]) and K @ [x, v]",
    ),
    "interp": "a table of time is ss.table, one of another argument is ss.Curve",
    "bitwise_xor": "a power is x**2",
    "cbrt": "write x**(1/3), for x > 0",
    "sinc": "write np.sin(np.pi*x) / (np.pi*x); it has no value at 0",
    "expm1": "write np.exp(x) - 1; near 0 it has few digits",
    "log1p": "write np.log(1 + x); near 0 it has few digits",
    "arcsinh": "write np.log(x + np.sqrt(x**2 + 1)); for x < 0 it has few digits",
    "arccosh": "write np.log(x + np.sqrt(x**2 - 1))",
    "arctanh": "write np.log((1 + x) / (1 - x)) / 2",
    "logaddexp": "write np.log(np.exp(x) + np.exp(y))",
}


def _object(value: Any) -> np.ndarray[Any, Any]:
    array = np.empty((), dtype=object)
    array[()] = value
    return array


def out_of_bounds(
    name: str, value: float, bound: str, help: str = "", what: str = ""
) -> OptionError:
    """The error for an argument out of its bounds."""
    text = f"{what}{name} = {readable(value)}: it must be {bound}{help}"
    return OptionError(text, name, value, bound)


def readable(value: float) -> str:
    """A number in 15 digits, or in those that distinguish it from others."""
    return short if float(short := f"{value:.15g}") == value else repr(float(value))


def number(value: Any, name: str = "a number", what: str = "") -> float:
    """A finite number. Errors name the argument by `what` and `name`."""
    if type(value) is not float and not isinstance(value, numbers.Real):
        raise TypeError(f"{what}{name} must be a number, not {value!r}")
    result = float(value)
    if not math.isfinite(result):
        raise out_of_bounds(name, result, "finite", what=what)
    return result


def whole(value: Any, name: str, least: int = 1) -> int:
    """A whole number of at least 1, or of another bound."""
    try:
        result = operator.index(value)
    except TypeError:
        if isinstance(value, (float, np.floating)) and not np.isfinite(value):
            bound = f"a whole number of at least {least}"
            raise out_of_bounds(name, float(value), bound) from None
        if not (isinstance(value, (float, np.floating)) and float(value).is_integer()):
            raise TypeError(f"{name} must be a whole number, not {value!r}") from None
        result = int(value)
    if result < least:
        raise out_of_bounds(name, result, f"at least {least}")
    return result


def written(value: float) -> str:
    """A number as text that reads back to the last bit."""
    return repr(float(value))


def expression(value: Any, name: str = "a number in a formula") -> Expression:
    """A formula from a symbol or a number. Errors name the argument by `name`."""
    if isinstance(value, Expression):
        return value
    if isinstance(value, np.ndarray) and value.ndim == 0:
        return expression(value.item(), name)
    if isinstance(value, Condition):
        raise value._refusal()
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(
            f"{value!r} cannot stand in a formula: write 0 or 1, and compare no symbols"
        )
    if isinstance(value, numbers.Real):
        value = number(value, name)
        return Expression(written(value), _ATOM if np.copysign(1.0, value) > 0 else _SIGN)
    if hasattr(value, "free_symbols"):
        raise TypeError(f"{value!r} is an expression of SymPy, not a formula: {_OF_SYMPY}")
    raise TypeError(f"{value!r} cannot stand in a formula: symbols and numbers can")


def varying(value: Any, what: str) -> Expression:
    """A formula of states or time, whose zeros `what` has."""
    formula = expression(value)
    if all(isinstance(part, (Parameter, Curve)) for part in formula.parts):
        raise ValueError(f"{what} {formula} is constant: it has neither a state nor time")
    return formula


def _within(value: Expression, binds: int) -> str:
    return value.text if value._binds >= binds else f"({value.text})"


def _binary(left: Any, sign: str, right: Any, binds: int) -> Expression:
    for one in (left, right):
        if isinstance(one, np.ndarray) and one.ndim > 0:
            return NotImplemented  # type: ignore[no-any-return]
        if isinstance(one, Condition):
            raise one._refusal()
    try:
        a, b = expression(left), expression(right)
    except TypeError:
        return NotImplemented  # type: ignore[no-any-return]
    # Sums and products group to the left, powers to the right; nothing is simplified.
    if sign == "^":
        text = f"{_within(a, _ATOM)}^{_within(b, _ATOM)}"
    else:
        # A sign to the left of a factor is that of the whole product, with the same bits.
        text = f"{_within(a, binds)} {sign} {_within(b, binds + 1)}"
    return Expression(text, binds, a.parts | b.parts)


def _comparison(left: Any, sign: str, right: Any) -> Condition:
    for one in (left, right):
        if isinstance(one, Condition):
            raise one._refusal()
    try:
        a, b = expression(left), expression(right)
    except TypeError:
        return NotImplemented  # type: ignore[no-any-return]
    return Condition(f"{a.text} {sign} {b.text}", a.parts | b.parts)


class Condition:
    """A comparison of formulas, or several that are joined by ``&``, ``|`` and ``~``.

    It is judged once, at a jump: as the `condition` of a `Jump`, or in what one sets, by
    ``np.where(condition, then, otherwise)``. Elsewhere it raises a `TypeError` that says what to
    write instead.

    Attributes
    ----------
    text : str
        The condition as text.
    parts : frozenset
        The states, parameters and inputs in it.
    """

    __slots__ = ("text", "parts")

    def __init__(self, text: str, parts: frozenset[Any] = frozenset()) -> None:
        self.text = text
        self.parts = parts

    def __repr__(self) -> str:
        return self.text

    def _repr_latex_(self) -> str:
        from ._latex import latex

        return f"${latex(self.text)}$"

    def _joined(self, word: str, other: Any) -> Condition:
        if not isinstance(other, Condition):
            raise TypeError(
                f"`{self.text}` and {other!r} are joined by `{word}`: both must be comparisons, "
                "with brackets around each, as in (a < b) & (c < d)"
            )
        return Condition(f"({self.text}) {word} ({other.text})", self.parts | other.parts)

    def __and__(self, other: Any) -> Condition:
        return self._joined("and", other)

    def __or__(self, other: Any) -> Condition:
        return self._joined("or", other)

    def __invert__(self) -> Condition:
        return Condition(f"not ({self.text})", self.parts)

    def _refusal(self) -> TypeError:
        return TypeError(f"a comparison (`{self.text}`) is no formula: {_COMPARED}")

    def _refuse(self, *_: Any) -> Any:
        raise self._refusal()

    __bool__ = __float__ = __int__ = __index__ = __complex__ = _refuse
    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = _refuse
    __truediv__ = __rtruediv__ = __pow__ = __rpow__ = __neg__ = __pos__ = __abs__ = _refuse
    __lt__ = __le__ = __gt__ = __ge__ = __rand__ = __ror__ = _refuse

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        words = {"logical_and": "and", "logical_or": "or"}
        if method == "__call__" and not options:
            if ufunc.__name__ in words and isinstance(inputs[0], Condition):
                return inputs[0]._joined(words[ufunc.__name__], inputs[1])
            if ufunc.__name__ == "logical_not":
                return ~self
        raise self._refusal()

    def __array_function__(self, function: Any, types: Any, of: Any, options: Any) -> Any:
        if getattr(function, "__name__", "") != "where" or len(of) != 3 or of[0] is not self:
            raise self._refusal()
        then, otherwise = expression(of[1]), expression(of[2])
        text = f"if({self.text}, {then.text}, {otherwise.text})"
        return Expression(text, _ATOM, self.parts | then.parts | otherwise.parts)


def erf(x: Any) -> Expression:
    """The error function of a formula.

    Parameters
    ----------
    x : Expression or float
        The argument.

    Returns
    -------
    Expression
    """
    return _call("erf", x)


def _call(name: str, *of: Any) -> Expression:
    arguments = [expression(one) for one in of]
    parts = frozenset[Any]().union(*(one.parts for one in arguments))
    return Expression(f"{name}({', '.join(one.text for one in arguments)})", _ATOM, parts)


class Symbol(Expression):
    """A name in formulas."""

    __slots__ = ("name",)

    def __init__(self, name: str) -> None:
        self.name = check_name(name)
        super().__init__(self.name, _ATOM, frozenset([self]))

    def __reduce__(self) -> Any:
        return type(self), (self.name,)

    def __eq__(self, other: object) -> bool:
        # Sets and dicts compare those with the same hash. Symbols with the same name but other
        # values are different, so that a system rejects them.
        if type(other) is type(self) and hash(other) == hash(self):
            return repr(self.__reduce__()[1]) == repr(other.__reduce__()[1])
        return super().__eq__(other)

    def __hash__(self) -> int:
        return hash((type(self), self.name))


def check_name(name: str) -> str:
    """The name, as the engine reads it, which replaces the micro sign by the Greek letter."""
    letters = name.replace("_", "a") if isinstance(name, str) else ""
    is_good = letters[:1].isalpha() and all(
        one.isalpha() or one in "0123456789₀₁₂₃₄₅₆₇₈₉" for one in letters
    )
    if not is_good:
        raise ValueError(f"{name!r} is no name: a letter, and behind it letters, digits and _")
    return name.replace("\u00b5", "μ")


class State(Symbol):
    """A component of the state."""

    __slots__ = ()


class Parameter(Symbol):
    """A parameter with its value, and its range of allowed values or None."""

    __slots__ = ("value", "range")

    def __init__(
        self, name: str, value: float, range: tuple[float, float] | None = None
    ) -> None:
        super().__init__(name)
        self.value = number(value, name, "the parameter ")
        self.range = None if range is None else _interval(range, self)

    def __reduce__(self) -> Any:
        return type(self), (self.name, self.value, self.range)


def _interval(range: Any, of: Parameter) -> tuple[float, float]:
    what = f"the range of the parameter {of.name}"
    try:
        low, high = (float(end) for end in range)
    except (TypeError, ValueError):
        raise TypeError(f"{what} must be (lowest, highest), not {range!r}") from None
    for end in (low, high):
        if end != end:
            raise out_of_bounds(what, end, "a number")
    if not low < high:
        raise ValueError(f"{what} = ({low:g}, {high:g}): the lower end must come first")
    if not low <= of.value <= high:
        bound = f"within its range, {readable(low)} to {readable(high)}"
        raise out_of_bounds(of.name, of.value, bound, what="the parameter ")
    return low, high


def states(names: str | Sequence[str]) -> Any:
    """Makes states from names: ``x, v = ss.states("x v")``.

    Parameters
    ----------
    names : str or sequence of str
        The names, separated by spaces or commas.

    Returns
    -------
    tuple of State, or State
        A text of one name gives that state: ``x = ss.states("x")``.

    Raises
    ------
    ValueError
        If a name is invalid or occurs twice.
    """
    if isinstance(names, str) and len(names.split()) == 1 and "," not in names:
        return State(names.strip())
    each = names.replace(",", " ").split() if isinstance(names, str) else list(names)
    if len(set(each)) < len(each):
        raise ValueError(f"the states {', '.join(each)} must have different names")
    return tuple(State(name) for name in each)


def state(name: str) -> State:
    """Makes a single state. States with the same name are equal."""
    return State(name)


def parameters(**values: float) -> tuple[Parameter, ...]:
    """Makes parameters with their values: ``k, mu0 = ss.parameters(k=1.0, mu0=0.4)``.

    Parameters
    ----------
    **values : float
        The value of each parameter.

    Returns
    -------
    tuple of Parameter

    Raises
    ------
    OptionError
        If a value is infinite or NaN.
    """
    return tuple(Parameter(name, value) for name, value in values.items())


def parameter(
    name: str, value: float, range: tuple[float, float] | None = None
) -> Parameter:
    """Makes a single parameter. A `range` (lowest, highest) bounds its later values; an end may be
    infinite."""
    return Parameter(name, value, range)


class DiscreteState(Symbol):
    """A state that only jumps change.

    Attributes
    ----------
    start : Expression
        Its start value, a formula of parameters. Default 0.
    """

    __slots__ = ("start",)

    def __init__(self, name: str, start: Any = 0.0) -> None:
        super().__init__(name)
        self.start = expression(start)

    def __reduce__(self) -> Any:
        return type(self), (self.name, self.start)


def discrete(**starts: Any) -> tuple[DiscreteState, ...]:
    """Makes discrete states with their start values: ``heater, = ss.discrete(heater=1)``.

    Parameters
    ----------
    **starts : float or Expression
        The start value of each, a number or a formula of parameters.

    Returns
    -------
    tuple of DiscreteState
        In the system they follow the other states, sorted by name.
    """
    return tuple(DiscreteState(name, start) for name, start in starts.items())


class Contact(Symbol):
    """A contact. The system can stick where `boundary` is zero.

    The rates depend on its side through `side`, `friction` or `by_side`.

    Parameters
    ----------
    name : str
        Name in formulas and results.
    boundary : Expression
        The function whose zero is the boundary, such as the relative velocity `v - vp`.
    friction : Expression, float or function, optional
        Magnitude of the friction force in slip. A function takes the side, -1 or +1, as in
        ``lambda side: mu0 / (1 + side * (v - vp))``.
    static : Expression, float or function, optional
        Largest friction force in stick. Default: the force in slip.
    normal_force : Expression, optional
        Normal force. Friction is zero where it is not positive. It does not stand beside friction
        that follows the reaction of a `Stop`, which has the normal force in it.
    """

    __slots__ = ("boundary", "law", "static", "normal_force")

    def __init__(
        self,
        name: str,
        boundary: Any,
        friction: Any = None,
        static: Any = None,
        normal_force: Any = None,
    ) -> None:
        super().__init__(name)
        self.boundary = expression(boundary)
        # A friction law may depend on the side of its contact, so a function is called with it.
        self.law = self._law("friction", friction)
        self.static = self._law("static", static)
        self.normal_force = None if normal_force is None else expression(normal_force)

    def _law(self, what: str, law: Any) -> Expression | None:
        if law is None:
            return None
        law = law(self.side) if callable(law) else law
        if isinstance(law, numbers.Real) and law < 0:
            help = "; a friction law is a size, and acts against the slip"
            raise out_of_bounds(what, float(law), "at least 0", help, f"{self.name}: ")
        return expression(law)

    def __reduce__(self) -> Any:
        of = (self.name, self.boundary, self.law, self.static, self.normal_force)
        return type(self), of

    @property
    def side(self) -> Expression:
        """-1 where the boundary function is negative, +1 where it is positive."""
        return Expression(self.name, _ATOM, self.parts)

    @property
    def friction(self) -> Expression:
        """The friction force: the side times the law."""
        if self.law is None:
            raise ValueError(f"the contact {self.name} has no friction: give friction=…")
        return Expression(f"friction({self.name})", _ATOM, self.parts)

    @property
    def force(self) -> Expression:
        """The friction force along an orbit, in stick too: for `observe` of a fit, not for rates.

        The system has this contact alone.
        """
        return Expression(f"{self.name}.force", _ATOM, self.boundary.parts)

    def by_side(self, below: Any, above: Any) -> Expression:
        """`below` where the boundary function is negative, `above` where it is positive."""
        a, b = expression(below), expression(above)
        text = f"by_side({self.name}, {a.text}, {b.text})"
        return Expression(text, _ATOM, self.parts | a.parts | b.parts)


class Stop(Symbol):
    """A stop: `gap` is never negative, by impacts and by a reaction while it is zero.

    Impacts that accumulate come to rest. The reaction is the force that keeps the gap closed, and
    the body lifts off where it vanishes.

    Parameters
    ----------
    name : str
        Name in formulas and results.
    gap : Expression
        Positive in flight, a position: its second derivative by time has the reaction in it.
    acts : dict
        What a unit of the reaction adds to the rates of states, as in ``{v: 1 / m}``.
    restitution : float, Expression or function, optional
        Part of the approach speed that an impact gives back, from 0 to 1. A function takes the
        approach speed. Default 0.
    """

    __slots__ = ("gap", "acts", "restitution")

    def __init__(
        self,
        name: str,
        gap: Any,
        acts: Mapping[State, Any],
        restitution: Any = 0.0,
    ) -> None:
        super().__init__(name)
        if not isinstance(acts, Mapping) or not acts:
            raise TypeError(f"acts must be {{state: rate, …}}, not {acts!r}")
        for state in acts:
            if not isinstance(state, State):
                raise TypeError(f"{state!r} is no state: the keys of acts are made by ss.states")
        if callable(restitution):
            restitution = restitution(Expression("approach", _ATOM, frozenset()))
        self.gap = varying(gap, "the gap")
        self.acts = {state: expression(value) for state, value in acts.items()}
        self.restitution = expression(restitution)

    def __reduce__(self) -> Any:
        return type(self), (self.name, self.gap, self.acts, self.restitution)

    @property
    def force(self) -> Expression:
        """The reaction, 0 while the stop is open."""
        return Expression(f"{self.name}.force", _ATOM, self.parts)

    @property
    def closed(self) -> Expression:
        """1 while the stop carries, else 0."""
        return Expression(f"{self.name}.closed", _ATOM, self.parts)


class Switch(Symbol):
    """The sign of a function of time alone.

    Parameters
    ----------
    name : str
        Name in formulas and results.
    function : Expression
        A formula of time and parameters. Steps of the solver end at its zeros.
    """

    __slots__ = ("function",)

    def __init__(self, name: str, function: Any) -> None:
        super().__init__(name)
        self.function = expression(function)

    def __reduce__(self) -> Any:
        return type(self), (self.name, self.function)

    @property
    def side(self) -> Expression:
        """-1 where the function is negative, +1 where it is positive."""
        return self


class Input(Symbol):
    """An input that depends on time alone and is linear between its kinks.

    `square`, `triangle`, `sawtooth`, `pulse` and `table` make inputs.
    """

    __slots__ = ("entries",)

    def __init__(self, name: str, entries: Mapping[str, Any]) -> None:
        super().__init__(name)
        self.entries = dict(entries)

    def __reduce__(self) -> Any:
        return type(self), (self.name, self.entries)


def _repeated(name: str, shape: str, period: Any, phase: Any, **more: Any) -> Input:
    entries = {"shape": shape, "period": expression(period), **more}
    if phase is not None:
        entries["phase"] = expression(phase)
    return Input(name, entries)


def square(name: str, period: Any, phase: Any = None) -> Input:
    """An input that is 1 in the first half of each period, -1 in the second.

    Parameters
    ----------
    name : str
        Name in formulas and results.
    period : float or Expression
        A number or a formula of parameters.
    phase : float or Expression, optional
        Fraction of the period that has passed at time 0. Default 0.
    """
    return _repeated(name, "square", period, phase)


def triangle(name: str, period: Any, phase: Any = None) -> Input:
    """An input that rises from 0 to 1, falls to -1 and returns to 0 in each period.

    Parameters
    ----------
    name : str
        Name in formulas and results.
    period : float or Expression
        A number or a formula of parameters.
    phase : float or Expression, optional
        Fraction of the period that has passed at time 0. Default 0.
    """
    return _repeated(name, "triangle", period, phase)


def sawtooth(name: str, period: Any, phase: Any = None) -> Input:
    """An input that rises from 0 to 1 in each period.

    ``period * ss.sawtooth("clock", period)`` is the remainder ``t % period``.

    Parameters
    ----------
    name : str
        Name in formulas and results.
    period : float or Expression
        A number or a formula of parameters.
    phase : float or Expression, optional
        Fraction of the period that has passed at time 0. Default 0.
    """
    return _repeated(name, "sawtooth", period, phase)


def pulse(name: str, period: Any, width: Any, phase: Any = None) -> Input:
    """An input that is 1 in the first part of each period, 0 in the rest.

    Parameters
    ----------
    name : str
        Name in formulas and results.
    period : float or Expression
        A number or a formula of parameters.
    width : float or Expression
        Fraction of the period in which it is 1, between 0 and 1: a number or a formula of
        parameters.
    phase : float or Expression, optional
        Fraction of the period that has passed at time 0. Default 0.
    """
    return _repeated(name, "pulse", period, phase, width=expression(width, "width"))


def table(
    name: str,
    times: Any,
    values: Any,
    between: Literal["linear", "constant"] = "linear",
) -> Input:
    """An input through points in time. It is constant before the first and after the last.

    Parameters
    ----------
    name : str
        Name in formulas and results.
    times, values : array_like, shape (m,)
        The points, sorted by time. Two points at one time are a step.
    between : {"linear", "constant"}, optional
        Interpolation: a line between two points, or the value of the first.
    """
    lists = {
        what: [number(one, f"{what}[{k}]") for k, one in enumerate(np.asarray(given).ravel())]
        for what, given in (("times", times), ("values", values))
    }
    return Input(name, {"shape": "table", **lists, "between": between})


class Curve:
    """A function of one argument through points, as measured: ``mu(slip)`` is a formula.

    Parameters
    ----------
    name : str
        Name in formulas.
    x, y : array_like, shape (m,)
        The points, sorted by `x`.
    between : {"linear", "monotone"}, optional
        Straight lines, at whose ends steps of the solver end, or cubics without overshoot (those of
        SciPy's ``PchipInterpolator``).
    beyond : {"hold", "extend", "error"}, optional
        What it is beyond its points: the value at the end, the line or cubic at the end, or an
        error of the run.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, v = ss.states("x v")
    >>> mu = ss.Curve("mu", [0, 0.5, 2], [0.4, 0.3, 0.35])
    >>> floor = ss.Contact("floor", boundary=v, friction=lambda side: mu(side * v))
    >>> floor.law
    mu(floor * v)

    Raises
    ------
    ValueError
        For fewer than two points, an `x` that does not rise, or an unknown interpolation.
    """

    __slots__ = ("name", "x", "y", "between", "beyond")

    def __init__(
        self,
        name: str,
        x: Any,
        y: Any,
        between: Literal["linear", "monotone"] = "linear",
        beyond: Literal["hold", "extend", "error"] = "hold",
    ) -> None:
        self.name = check_name(name)
        self.x, self.y = (
            [number(one, f"{what}[{k}]") for k, one in enumerate(np.asarray(given).ravel())]
            for what, given in (("x", x), ("y", y))
        )
        if len(self.x) != len(self.y):
            raise ValueError(
                f"the curve {name} has {len(self.x)} values of x and {len(self.y)} of y: each "
                "point has both"
            )
        if len(self.x) < 2:
            raise ValueError(
                f"the curve {name} has {len(self.x)} points: it needs two at least; what is "
                "constant is a parameter"
            )
        for k, (one, after) in enumerate(pairwise(self.x), 1):
            if not one < after:
                raise ValueError(
                    f"the points of the curve {name} are not in order: {readable(one)} comes "
                    f"before {readable(after)}, as number {k} and {k + 1} of {len(self.x)}; each x "
                    "must be larger than the one before it"
                )
        for what, value, known in (
            ("between", between, ("linear", "monotone")),
            ("beyond", beyond, ("hold", "extend", "error")),
        ):
            if value not in known:
                raise ValueError(
                    f"{what} = {value!r} of the curve {name}: it must be one of {', '.join(known)}"
                )
        self.between, self.beyond = between, beyond

    def __reduce__(self) -> Any:
        return type(self), (self.name, self.x, self.y, self.between, self.beyond)

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self.__reduce__() == other.__reduce__()

    def __hash__(self) -> int:
        return hash((type(self), self.name))

    def __repr__(self) -> str:
        return f"<Curve {self.name} of {len(self.x)} points>"

    def __call__(self, argument: Any) -> Expression:
        made = _call(self.name, argument)
        return Expression(made.text, _ATOM, made.parts | {self})

    @property
    def entries(self) -> dict[str, Any]:
        """The curve as a table of a file."""
        points = [list(point) for point in zip(self.x, self.y)]
        return {"points": points, "between": self.between, "beyond": self.beyond}


_DIRECTIONS: list[Direction] = ["both", "rising", "falling"]


def sign_of(direction: float | Direction) -> int:
    """1 for rising, -1 for falling, 0 for both."""
    if isinstance(direction, str):
        if direction not in _DIRECTIONS:
            raise ValueError(f"direction = {direction!r}: it is 'rising', 'falling' or 'both'")
        return (0, 1, -1)[_DIRECTIONS.index(direction)]
    return int(np.sign(number(direction, "direction")))


class Jump:
    """A jump. When `when` passes through zero, the states in `set` take new values.

    Parameters
    ----------
    name : str
        Name in results.
    when : Expression
        The function whose zero triggers it.
    set : dict, optional
        New values by state, such as ``{v: -0.8 * v}``. Other states keep their values.
        ``np.where(v < 0.1, 0, v)`` chooses one of two.
    direction : float or {"rising", "falling", "both"}, optional
        The sign changes that count, as for `event`.
    stop : bool, optional
        Whether the run ends at the jump.
    count : int, optional
        The run ends after this number of jumps.
    condition : Condition, optional
        A comparison such as ``v < 0.1``, judged at the zero on the state before the jump. Where it
        does not hold, nothing happens.

    Raises
    ------
    ValueError
        If `when` is constant, or the jump neither sets a state nor ends the run.
    """

    def __init__(
        self,
        name: str,
        when: Any,
        set: Mapping[State | DiscreteState, Any] | None = None,
        direction: float | Direction = "both",
        stop: bool = False,
        count: int | None = None,
        condition: Condition | None = None,
    ) -> None:
        values = {} if set is None else set
        if not isinstance(values, Mapping):
            raise TypeError(f"set must be {{state: value, …}}, not {set!r}")
        for state in values:
            if not isinstance(state, (State, DiscreteState)):
                raise TypeError(f"{state!r} is no state: the keys of set are made by ss.states")
        self.name = check_name(name)
        self.when = varying(when, "the jump's function")
        self.set = {state: expression(value) for state, value in values.items()}
        self.direction = _DIRECTIONS[sign_of(direction)]
        self.stop = bool(stop)
        self.count = None if count is None else whole(count, "count")
        if not (condition is None or isinstance(condition, Condition)):
            raise TypeError(f"condition must be a comparison such as v < 0.1, not {condition!r}")
        self.condition = condition
        if self.stop and self.count is not None:
            raise ValueError("stop and count say the same: stop=True is count=1")
        if not (self.set or self.stop or self.count):
            raise ValueError(
                f"the jump {name} sets no state: give set={{v: -v}}, or stop=True to end the run"
            )

    def __repr__(self) -> str:
        return f"<Jump {self.name} at {self.when} = 0>"

    def _repr_latex_(self) -> str:
        from ._latex import jump_latex

        values = {state.name: value for state, value in self.set.items()}
        return f"${': '.join(jump_latex({**self._entries(), 'set': values}))}$"

    def _entries(self) -> dict[str, Any]:
        """The entries of its table in a file, without `set`."""
        entries: dict[str, Any] = {"when": self.when, "direction": self.direction}
        if self.condition is not None:
            entries["if"] = self.condition
        if self.stop:
            entries["stop"] = True
        if self.count is not None:
            entries["count"] = self.count
        return entries


class Time(Symbol):
    """Time."""

    __slots__ = ()


#: Time.
t = Time("t")
#: The number π.
pi: Expression = Expression("pi")
