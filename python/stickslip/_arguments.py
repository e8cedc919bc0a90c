"""Checks of arguments, each error by the argument's name, and the settings of the solver."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._symbols import Expression, Parameter, State, number, whole
from ._system import System

Floats = NDArray[np.float64]
Method = Literal["taylor", "dop853"]


class OptionsButMethod(TypedDict, total=False):
    """Settings of the solver, where `method` is an argument of its own."""

    rtol: float
    atol: float | None
    max_step: float
    escape: float
    at_repelling: Literal["stop", "below", "above"]
    at_pile_up: Literal["stop", "rest"]
    most_events: int
    most_steps: int


class Options(OptionsButMethod, total=False):
    """Settings of the solver, which every computation takes as keywords.

    Attributes
    ----------
    rtol : float
        Relative tolerance; 1e-12 unless given.
    atol : float
        Absolute tolerance; `rtol` unless given.
    method : {"taylor", "dop853"}
        Taylor series of an order that fits the tolerance, or Dormand and Prince's pair of order 8.
    max_step : float
        Longest step, in units of time.
    escape : float
        A run fails where a component exceeds this; 1e6 unless given.
    at_repelling : {"stop", "below", "above"}
        Where the boundary repels and the future is not unique: end with status 2, or go on there.
    at_pile_up : {"stop", "rest"}
        Where transitions accumulate, as of a ball that comes to rest: fail, or stay there.
    most_events, most_steps : int
        A run fails that has more.
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
    "most_steps": 1_000_000_000,
}


_INSTEAD = {
    "args": "values are parameters of the system, by ss.parameters and system.with_parameters",
    "first_step": "the solver finds it; max_step bounds all steps",
    "jac": "derivatives come from the formulas",
    "vectorized": "formulas are not called",
    "tol": "the tolerances are rtol and atol",
}


def settings(options: Options) -> dict[str, Any]:
    """All settings of a run, with the program's defaults."""
    if options.keys() - _DEFAULTS.keys():
        unknown = sorted(options.keys() - _DEFAULTS.keys())[0]
        help = _INSTEAD.get(unknown, f"they are {', '.join(_DEFAULTS)}")
        raise TypeError(f"{unknown!r} is no option: {help}")
    made: dict[str, Any] = {**_DEFAULTS, **options}
    if made["atol"] is None:
        made["atol"] = made["rtol"]
    for name in ("rtol", "atol", "max_step", "escape"):
        made[name] = real(made[name], name)
    for name in ("most_events", "most_steps"):
        made[name] = whole(made[name], name)
    for name in ("method", "at_repelling", "at_pile_up"):
        made[name] = str(made[name])
    return made


def real(value: Any, name: str) -> float:
    """A number, which may be infinite."""
    return math.inf if value == math.inf else number(value, name)


def threads(workers: Any) -> int:
    """A number of threads, 0 for all."""
    if workers == -1:
        return 0
    found = whole(workers, "workers", least=-1)
    if found < 1:
        raise ValueError(f"workers = {found}: it is a number of threads, or -1 for all cores")
    return found


def array(values: ArrayLike, name: str, dimensions: int = 1) -> Floats:
    """Finite doubles of so many dimensions, in order."""
    try:
        found = np.asarray(values)
    except ValueError as error:
        raise ValueError(f"{name} must be an array of numbers: {error}") from None
    if found.dtype.kind not in "fiub":
        kind: Any = found.dtype
        if kind == object and found.size:
            kind = repr(found.flat[0])
        raise TypeError(f"{name} must be real numbers, not {kind}")
    if found.ndim != dimensions:
        wanted = "a sequence of numbers" if dimensions == 1 else f"of {dimensions} dimensions"
        raise ValueError(f"{name} must be {wanted}, and its shape is {found.shape}")
    # A sum is finite where all are, and where it overflows they are looked at one by one.
    if not math.isfinite(found.sum()) and not np.isfinite(found).all():
        place = tuple(int(k) for k in np.argwhere(~np.isfinite(found))[0])
        raise ValueError(f"{name}[{', '.join(map(str, place))}] = {found[place]} is not finite")
    return np.ascontiguousarray(found, dtype=np.float64)


def several(values: ArrayLike, name: str, example: str) -> Floats:
    """A sequence of numbers that is not empty."""
    found = array(values, name)
    if not len(found):
        raise ValueError(f"{name} is empty: give values, as {example}")
    return found


def pair(values: Any, name: str) -> tuple[float, float]:
    """Two numbers."""
    found = array(values, name)
    if len(found) != 2:
        raise ValueError(f"{name} has {len(found)} values: it must be two, from and to")
    return float(found[0]), float(found[1])


def checked(system: System) -> System:
    """The system, if it is one."""
    if isinstance(system, System):
        return system
    help = ""
    if callable(system):
        help = "; write the right-hand side with symbols: ss.System({x: v, v: -x})"
    raise TypeError(f"system must be a stickslip.System, not {type(system).__name__}{help}")


def state(system: System, y0: ArrayLike | Mapping[Any, Any] | None) -> list[float]:
    """A state at the start: as given in order, or by name, and otherwise as the system says.
    Discrete states that are not given begin at their own values."""
    names = checked(system).states
    if y0 is None:
        if system.start is None:
            raise ValueError(f"the system has no start: give y0, the states {', '.join(names)}")
        return list(system.start)
    discrete: list[float] = system._core.discrete
    if isinstance(y0, Mapping):
        given: dict[Any, Any] = dict(zip(names[len(names) - len(discrete) :], discrete))
        given |= dict(zip(names, system.start or ()))
        given |= {getattr(key, "name", key): value for key, value in y0.items()}
        for name in given.keys() ^ set(names):
            what = "has no value of the state" if name in names else "has a value of"
            help = "" if name in names else f", which is no state: they are {', '.join(names)}"
            raise ValueError(f"y0 {what} {name}{help}")
        return [number(given[name], f"y0[{name}]") for name in names]
    found = array(y0, "y0")
    if not is_of_states(system, len(found)):
        raise ValueError(f"y0 has {len(found)} values, and {states_of(system)}")
    return [float(value) for value in found] + discrete[: len(names) - len(found)]


def is_of_states(system: System, count: int) -> bool:
    """Whether so many values are a state. Discrete states may be left out."""
    return len(system.states) - count in (0, len(system._core.discrete))


def states_of(system: System) -> str:
    """What a state must be."""
    names, discrete = system.states, len(system._core.discrete)
    help = f"; the last {discrete}, discrete, may be left out" if discrete else ""
    return f"there are {len(names)} states: {', '.join(names)}{help}"


def start(
    system: System, t0: Any, y0: ArrayLike | Mapping[Any, Any] | None
) -> tuple[float, list[float]]:
    """Time and state at the start."""
    return number(t0, "t0"), state(system, y0)


def start_of_each(system: System, y0: ArrayLike | Mapping[Any, Any] | None) -> list[float] | None:
    """A state at the start; a start that depends on parameters is that of each system."""
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
