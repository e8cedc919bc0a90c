"""Checks of arguments, with errors that name the argument; settings of the solver."""

from __future__ import annotations

import math
import numbers
import os
from collections.abc import Mapping
from typing import Any, Literal, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._symbols import Expression, Parameter, State, number, out_of_bounds, readable, whole
from ._system import System

Floats = NDArray[np.float64]
Method = Literal["taylor", "dop853"]


class OptionsButMethod(TypedDict, total=False):
    """Settings of the solver, for functions with an argument `method`."""

    rtol: float
    atol: float | ArrayLike | None
    max_step: float
    escape: float
    at_repelling: Literal["stop", "below", "above"]
    at_pile_up: Literal["stop", "rest"]
    most_events: int
    most_steps: int


class Options(OptionsButMethod, total=False):
    """Settings of the solver. Every computation accepts them as keywords.

    Attributes
    ----------
    rtol : float
        Relative tolerance. Default 1e-12.
    atol : float or array_like
        Absolute tolerance, of all states or of each in their order; discrete ones may be left out.
        Default as in the file, or `rtol`.
    method : {"taylor", "dop853"}
        Taylor series, of an order that depends on the tolerance, or the Dormand–Prince method of
        order 8.
    max_step : float
        Longest step, in units of time.
    escape : float
        A run fails if a state exceeds this. Default 1e6.
    at_repelling : {"stop", "below", "above"}
        What to do where the boundary repels, so that the future is not unique. ``"stop"`` ends the
        run with status 2; the others continue on that side.
    at_pile_up : {"stop", "rest"}
        What to do where infinitely many transitions accumulate (Zeno), as for a bouncing ball.
        ``"stop"`` fails; ``"rest"`` continues at rest.
    most_events, most_steps : int
        A run with more transitions or steps fails.
    """

    method: Method


_DEFAULTS: Options = {
    "rtol": 1e-12,
    "atol": None,
    "method": "taylor",
    "max_step": math.inf,
    "escape": 1e6,
    "at_repelling": "stop",
    "at_pile_up": "stop",
    "most_events": 200_000,
    "most_steps": 10_000_000,
}


_INSTEAD = {
    "args": "values are parameters of the system, by ss.parameters and system.with_parameters",
    "first_step": "the solver finds it; max_step bounds all steps",
    "jac": "derivatives come from the formulas",
    "vectorized": "formulas are not called",
    "tol": "the tolerances are rtol and atol",
}


def settings(options: Options) -> dict[str, Any]:
    """All settings of a run. Those that are not given have the program's defaults."""
    if options.keys() - _DEFAULTS.keys():
        unknown = sorted(options.keys() - _DEFAULTS.keys())[0]
        help = _INSTEAD.get(unknown, f"they are {', '.join(_DEFAULTS)}")
        raise TypeError(f"{unknown!r} is no option: {help}")
    made: dict[str, Any] = {**_DEFAULTS, **options}
    for name in ("rtol", "max_step", "escape"):
        made[name] = real(made[name], name)
    if made["atol"] is not None:
        made["atol"] = absolute(made["atol"])
    for name in ("most_events", "most_steps"):
        made[name] = whole(made[name], name)
    for name in ("method", "at_repelling", "at_pile_up"):
        made[name] = str(made[name])
    return made


def absolute(atol: Any) -> float | list[float]:
    """An absolute tolerance: a number, or one for each state."""
    if np.ndim(as_array(atol, "atol")) == 0:
        return real(atol, "atol")
    return [float(value) for value in array(atol, "atol")]


def real(value: Any, name: str) -> float:
    """A number, which may be infinite."""
    if type(value) is float and value > -math.inf:
        return value
    is_infinite = isinstance(value, numbers.Real) and value == math.inf
    return math.inf if is_infinite else number(value, name)


def threads(workers: Any) -> int:
    """A number of threads, 0 for all."""
    count = whole(workers, "workers", least=-1)
    if count == 0:
        raise out_of_bounds("workers", 0, "a number of threads, or -1 for all cores")
    return max(count, 0)


def as_array(values: Any, name: str) -> NDArray[Any]:
    """A NumPy array of the values."""
    if isinstance(values, np.ma.MaskedArray):
        raise TypeError(f"{name} is a masked array: give its values, {name}.filled(…)")
    try:
        return np.asarray(values)
    except ValueError as error:
        raise ValueError(f"{name} must be an array of numbers: {error}") from None


def array(values: ArrayLike, name: str, dimensions: int = 1) -> Floats:
    """A copy as an array of finite doubles with this number of dimensions, in row order."""
    given = as_array(values, name)
    if given.dtype.kind not in "fiub":
        kind: Any = given.dtype
        if kind == object and given.size:
            kind = repr(given.flat[0])
        raise TypeError(f"{name} must be real numbers, not {kind}")
    if given.ndim != dimensions:
        wanted = "a sequence of numbers" if dimensions == 1 else f"of {dimensions} dimensions"
        raise ValueError(f"{name} must be {wanted}, and its shape is {given.shape}")
    copy = np.array(given, dtype=np.float64, order="C")
    # A reduction takes longer than a few numbers do.
    is_short = dimensions == 1 and copy.size <= 16
    if not (all(map(math.isfinite, copy.tolist())) if is_short else np.isfinite(copy).all()):
        place = tuple(int(k) for k in np.argwhere(~np.isfinite(copy))[0])
        at = f"{name}[{', '.join(map(str, place))}]"
        raise out_of_bounds(at, float(copy[place]), "finite")
    return copy


def few(values: Any) -> list[float] | None:
    """The values of a list or tuple of finite Python numbers. `array` takes all others, and longer
    than these few take."""
    if type(values) not in (list, tuple):
        return None
    if not all(type(one) is float or type(one) is int and abs(one) < 2**53 for one in values):
        return None
    return [float(one) for one in values] if all(map(math.isfinite, values)) else None


def nonempty_array(values: ArrayLike, name: str, example: str) -> Floats:
    """A sequence of numbers that is not empty."""
    found = array(values, name)
    if not len(found):
        raise ValueError(f"{name} is empty: give values, as {example}")
    return found


def pair(values: Any, name: str, help: str) -> tuple[float, float]:
    """Two numbers, the smaller one first."""
    both = array(values, name)
    if len(both) != 2:
        raise ValueError(f"{name} has {len(both)} values: it must be two, from and to")
    low, high = (float(one) for one in both)
    if not low < high:
        bound = f"larger than {name}[0] = {readable(low)}"
        raise out_of_bounds(f"{name}[1]", high, bound, f"; {help}")
    return low, high


def checked(system: System) -> System:
    """The system, if it is one."""
    if isinstance(system, System):
        return system
    help = ""
    if callable(system):
        help = "; write the right-hand side with symbols: ss.System({x: v, v: -x})"
    if isinstance(system, (str, os.PathLike)):
        help = f"; a file or a shipped model is ss.System.from_toml({str(system)!r})"
    raise TypeError(f"system must be a stickslip.System, not {type(system).__name__}{help}")


def state(system: System, y0: ArrayLike | Mapping[Any, Any] | None) -> list[float]:
    """The start state: values in order, values by name, or the start of the system. Discrete states
    without a value start at their own values."""
    names = checked(system).states
    if y0 is None:
        if system.start is None:
            raise ValueError(f"the system has no start: give y0, the states {', '.join(names)}")
        return list(system.start)
    plain = few(y0)
    if plain is not None and len(plain) == len(names):
        return plain
    y0 = by_name(y0, "index", "y0")
    if isinstance(y0, Mapping):
        starts = zip(names, system._core.starts)
        given: dict[Any, Any] = {name: value for name, value in starts if value is not None}
        given |= {getattr(key, "name", key): value for key, value in y0.items()}
        for name in given.keys() ^ set(names):
            what = "has no value of the state" if name in names else "has a value of"
            help = "" if name in names else f", which is no state: they are {', '.join(names)}"
            raise ValueError(f"y0 {what} {name}{help}")
        return [number(given[name], f"y0[{name}]") for name in names]
    values = array(y0, "y0")
    row = values if values.size == len(names) else complete(system, values, "y0")[0]
    return [float(value) for value in row]


def by_name(values: Any, axis: str, name: str) -> Any:
    """Values with labels, as pandas has them, as a dict by label, unless they are only numbered."""
    labels = getattr(values, axis, None)
    if labels is None or callable(labels):
        return values
    labels = list(labels)
    if all(isinstance(one, numbers.Integral) for one in labels) and labels == [*range(len(labels))]:
        return values
    for label in labels:
        if not isinstance(label, (str, Expression)):
            raise ValueError(
                f"the {axis} of {name} has {label!r}: it must have the names of states, or none "
                f"({name}.to_numpy() has the values in order)"
            )
    if len(set(labels)) < len(labels):
        raise ValueError(f"the {axis} of {name} has a name twice: {labels}")
    columns = np.asarray(values).T
    return dict(zip(labels, columns))


def in_order(system: System, columns: Mapping[Any, Any]) -> NDArray[Any]:
    """Columns by the names of states as rows of states."""
    named = {getattr(key, "name", key): column for key, column in columns.items()}
    for name in named.keys() - set(system.states):
        raise ValueError(f"starts has values of {name}, which is no state of the system")
    return np.stack([named[name] for name in system.states if name in named], axis=-1)


def complete(system: System, states: Floats, name: str) -> Floats:
    """Rows of states. The start values of discrete states are appended if they are left out."""
    rows, names = np.atleast_2d(states), system.states
    if rows.shape[1] == len(names):
        return rows
    discrete = len(system.discrete)
    if rows.shape[1] == len(names) - discrete:
        starts = np.array(system._core.starts[-discrete:], dtype=np.float64)
        return np.hstack([rows, np.tile(starts, (len(rows), 1))])
    help = f"; the last {discrete}, discrete, may be left out" if discrete else ""
    raise ValueError(
        f"{name} has {rows.shape[1]} values, and there are {len(names)} states: "
        f"{', '.join(names)}{help}"
    )


def rows_of_starts(system: System, starts: Any) -> tuple[Floats, tuple[int, ...]]:
    """Starts as rows of states, and the shape of the array of starts."""
    names = checked(system).states
    if _is_meshgrid(starts):
        raise ValueError("starts is a meshgrid: stack it, np.stack(np.meshgrid(x, v), axis=-1)")
    starts = by_name(starts, "columns", "starts")
    if isinstance(starts, dict):
        starts = in_order(system, starts)
    given = as_array(starts, "starts")
    discrete = len(system.discrete)
    if given.ndim == 0 or given.shape[-1] not in (len(names), len(names) - discrete):
        help = f"; the last {discrete}, discrete, may be left out" if discrete else ""
        raise ValueError(
            f"the last axis of starts must be the {len(names)} states: {', '.join(names)}{help}; "
            f"the shape is {given.shape}; a grid is np.stack(np.meshgrid(x, v), axis=-1)"
        )
    if not given.size:
        raise ValueError("starts is empty: give at least one state")
    rows = complete(system, array(given.reshape(-1, given.shape[-1]), "starts", 2), "starts")
    return rows, given.shape[:-1]


def _is_meshgrid(starts: Any) -> bool:
    """Whether it is the result of np.meshgrid for two axes. Its last axis may have the length of a
    state."""
    if not isinstance(starts, (list, tuple)) or len(starts) != 2:
        return False
    a, b = starts
    is_plane = all(isinstance(one, np.ndarray) and one.ndim == 2 for one in starts)
    return is_plane and a.shape == b.shape and bool((a == a[:1]).all() and (b == b[:, :1]).all())


def start(
    system: System, t0: Any, y0: ArrayLike | Mapping[Any, Any] | None
) -> tuple[float, list[float]]:
    """Time and state at the start."""
    return number(t0, "t0"), state(system, y0)


def start_of_each(system: System, y0: ArrayLike | Mapping[Any, Any] | None) -> list[float] | None:
    """The start state; None for the start of the system, which may depend on parameters."""
    if y0 is None and system.start is not None:
        return None
    return state(system, y0)


def name_of(parameter: str | Parameter) -> str:
    """The name of a parameter."""
    if isinstance(parameter, Expression) and not isinstance(parameter, Parameter):
        kind = "state" if isinstance(parameter, State) else "formula"
        raise TypeError(f"parameter must be a parameter or its name; {parameter} is a {kind}")
    if not isinstance(parameter, (str, Parameter)):
        raise TypeError(f"parameter must be a parameter or its name, not {parameter!r}")
    return parameter.name if isinstance(parameter, Parameter) else parameter
