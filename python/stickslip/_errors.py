"""Errors and warnings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


class StickslipError(RuntimeError):
    """A computation failed.

    Attributes
    ----------
    message : str
        The cause, with the values that explain it.
    kind : str
        Kind of failure, such as ``"Escaped"``, ``"NoUniqueFuture"``, ``"NotConverged"``.
    t : float or None
        Time of the failure, if known.
    y : sequence of float or None
        State at that time, if known.
    """

    def __init__(
        self,
        message: str,
        kind: str = "",
        t: float | None = None,
        y: Sequence[float] | None = None,
    ) -> None:
        super().__init__(message, kind, t, y)
        self.message = message
        self.kind = kind
        self.t = t
        self.y = y

    def __str__(self) -> str:
        return self.message


class OptionError(ValueError):
    """A number among the arguments is out of bounds: NaN, infinite, too small or too large.

    Attributes
    ----------
    message : str
        What is wrong.
    name : str
        The argument or option, such as ``"rtol"`` or ``"y0[1]"``.
    value : float
        Its value.
    bound : str
        The allowed values.
    """

    def __init__(self, message: str, name: str, value: float, bound: str) -> None:
        super().__init__(message, name, value, bound)
        self.message = message
        self.name = name
        self.value = value
        self.bound = bound

    def __str__(self) -> str:
        return self.message


class SystemError(ValueError):
    """A system that cannot be used. The message shows the place in its text."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C ended a computation.

    It is a `KeyboardInterrupt`, so that a script ends as with any other library. Catch it to keep
    the result so far.

    Attributes
    ----------
    partial : result or None
        The result so far, of the type that the function returns. None if a part of the result is
        useless (`periodic_orbit`, `lyapunov_spectrum`, `lyapunov_from_data`).

    Examples
    --------
    >>> import stickslip as ss
    >>> try:  # doctest: +SKIP
    ...     found = ss.basins_of_attraction(system, starts)
    ... except ss.Interrupted as stop:
    ...     found = stop.partial
    """

    def __init__(self, message: str = "interrupted", partial: Any = None) -> None:
        super().__init__(message, partial)
        self.message = message
        self.partial = partial

    def __str__(self) -> str:
        return self.message


class InternalError(RuntimeError):
    """A defect of stickslip itself."""


class SolverWarning(RuntimeWarning):
    """A run failed, its future is not unique, or its friction became negative. `solve_ivp` returns
    the orbit so far. In results of many runs, the kind of a failed one is ``"failure"``, and one
    warning counts them."""
