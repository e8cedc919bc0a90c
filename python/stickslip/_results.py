"""The base of all results, and the conversion of the engine's output to results."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields
from typing import Any, TypeVar

import numpy as np

from ._errors import InternalError, Interrupted, SolverWarning
from ._symbols import State
from ._system import System
from ._tables import as_html, pandas, short, structured, xarray

__all__ = ["Result", "call_engine", "column", "make_result", "structured", "warn_of_failures"]

_T = TypeVar("_T")


class Result:
    """A result with named fields, which are also items: ``sol["y"]`` is ``sol.y``."""

    def keys(self) -> list[str]:
        """The names of the fields."""
        names = (one.name for one in fields(self))  # type: ignore[arg-type]
        return [name for name in names if not name.startswith("_")]

    def __getitem__(self, name: str) -> Any:
        if name not in self.keys():
            raise KeyError(f"there is no field {name!r}: they are {', '.join(self.keys())}")
        return getattr(self, name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.keys())

    def __contains__(self, name: object) -> bool:
        return name in self.keys()

    def __repr__(self) -> str:
        # The system has a representation of its own, and reasons are shown where there are some.
        names = [name for name in self.keys() if name != "system"]
        names = [name for name in names if not _is_blank(getattr(self, name))]
        shown = [f"{name}={short(getattr(self, name))}" for name in names]
        return f"{type(self).__name__}({', '.join(shown)})"

    def _columns(self) -> dict[str, Any]:
        """The columns of the result as a table."""
        raise NotImplementedError

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """The variables of the result as a data set, each with its dimensions; coordinates."""
        raise NotImplementedError

    def to_pandas(self) -> Any:
        """The result as a `pandas.DataFrame`.

        Returns
        -------
        pandas.DataFrame
        """
        return pandas().DataFrame(self._columns())

    def _attributes(self) -> dict[str, Any]:
        """What belongs to the data set as a whole."""
        return {}

    def to_xarray(self) -> Any:
        """The result as an `xarray.Dataset`.

        Returns
        -------
        xarray.Dataset
        """
        variables, coordinates = self._variables()
        return xarray().Dataset(variables, coordinates, self._attributes())

    def _repr_html_(self) -> str:
        return as_html(self._columns())


def _is_blank(value: Any) -> bool:
    """Whether a list has nothing but empty texts."""
    of_texts = isinstance(value, list) and len(value) > 0
    return of_texts and all(isinstance(one, str) and not one for one in value)


def states_of(system: System, y: Any, end: str = "") -> dict[str, Any]:
    """Columns of states, which are on the last axis."""
    return {name + end: y[..., k] for k, name in enumerate(system.states)}


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


def warn_of_doubts(doubts: Sequence[str], at: Callable[[int], str]) -> None:
    """Warns once about all runs of which something is doubtful."""
    doubtful = [k for k, doubt in enumerate(doubts) if doubt]
    if doubtful:
        count = f"{len(doubtful)} of {len(doubts)} runs are doubtful"
        message = f"{count}; the first, at {at(doubtful[0])}: {doubts[doubtful[0]]}"
        warnings.warn(message, SolverWarning, stacklevel=3)


def column(system: System, which: int | str | State) -> tuple[int, str]:
    """Number and name of a state."""
    names = system.states
    name = getattr(which, "name", which)
    if isinstance(name, str) and name in names:
        return names.index(str(name)), str(name)
    if isinstance(name, (int, np.integer)) and -len(names) <= name < len(names):
        return int(name) % len(names), names[name]
    raise ValueError(f"there is no state {which!r}: they are {', '.join(names)}")
