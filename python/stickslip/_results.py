"""The base of all results, and the conversion of the engine's output to results."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ._errors import InternalError, Interrupted, SolverWarning
from ._symbols import State
from ._system import System

_T = TypeVar("_T")


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        if value.size > 4 or value.dtype.names:
            return f"<{' × '.join(map(str, value.shape))}>"
        return np.array2string(value, precision=6, separator=", ")
    if isinstance(value, (list, tuple)) and len(value) > 4:
        return f"<{len(value)}>"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


class Result:
    """A result with named fields."""

    def __repr__(self) -> str:
        # The system has a representation of its own.
        names = [one.name for one in fields(self) if one.name != "system"]  # type: ignore[arg-type]
        shown = [f"{name}={_short(getattr(self, name))}" for name in names]
        return f"{type(self).__name__}({', '.join(shown)})"


def call_engine(function: Callable[..., _T], *of: Any) -> _T:
    """Calls the engine. A panic becomes an `InternalError`."""
    try:
        return function(*of)
    except KeyboardInterrupt as raised:
        # There is nothing to keep.
        raise Interrupted() from raised
    except BaseException as error:
        if type(error).__name__ != "PanicException":
            raise
        raise InternalError(f"a defect of stickslip: {error}") from None


def make_result(found: dict[str, Any], make: Callable[..., _T], **more: Any) -> _T:
    """Makes a result from the engine's output. An exception that ended the computation early is
    raised; Ctrl-C becomes `Interrupted` with the result so far."""
    raised = found.pop("raised", None)
    result = make(**found, **more)
    if raised is None:
        return result
    if isinstance(raised, KeyboardInterrupt):
        raise Interrupted("interrupted; `partial` has what was found", result) from raised
    raise raised


def warn_of_failures(reasons: Sequence[str], at: Callable[[int], str]) -> None:
    """Warns once about all failed runs, which have a reason; `at` describes the start of a run."""
    failed = [k for k, reason in enumerate(reasons) if reason]
    if failed:
        count = f"{len(failed)} of {len(reasons)} runs failed"
        message = f"{count}; the first, at {at(failed[0])}: {reasons[failed[0]]}"
        warnings.warn(message, SolverWarning, stacklevel=3)


@lru_cache(maxsize=256)
def _dtype(fields: tuple[tuple[str, Any, tuple[int, ...]], ...]) -> np.dtype[np.void]:
    return np.dtype(list(fields))


def structured(columns: Mapping[str, Any]) -> NDArray[np.void]:
    """Makes a structured array from columns of texts, numbers, or rows of numbers.

    Texts are a list, or a pair: the distinct ones, and for each entry its index among them.
    """
    types: list[tuple[str, Any, tuple[int, ...]]] = []
    for name, values in columns.items():
        words = values[0] if isinstance(values, tuple) else values
        if isinstance(words, list):
            types.append((name, f"U{max(map(len, words), default=0) or 1}", ()))
        else:
            types.append((name, values.dtype.str, values.shape[1:]))
    first = next(iter(columns.values()))
    count = len(first[1] if isinstance(first, tuple) else first)
    found = np.zeros(count, dtype=_dtype(tuple(types)))
    if count:
        for name, values in columns.items():
            found[name] = np.array(values[0])[values[1]] if isinstance(values, tuple) else values
    return found


def column(system: System, which: int | str | State) -> tuple[int, str]:
    """Number and name of a state."""
    names = system.states
    name = getattr(which, "name", which)
    if isinstance(name, str) and name in names:
        return names.index(str(name)), str(name)
    if isinstance(name, (int, np.integer)) and -len(names) <= name < len(names):
        return int(name) % len(names), names[name]
    raise ValueError(f"there is no state {which!r}: they are {', '.join(names)}")
