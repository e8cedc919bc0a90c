"""What can go wrong."""

from __future__ import annotations

from collections.abc import Sequence


class StickslipError(RuntimeError):
    """A computation failed; `t` and `y` say where, as far as that is known."""

    def __init__(
        self,
        message: str,
        t: float | None = None,
        y: Sequence[float] | None = None,
    ) -> None:
        super().__init__(message, t, y)
        self.message = message
        self.t = t
        self.y = y

    def __str__(self) -> str:
        return self.message


class SystemError(ValueError):
    """A system that cannot be used: the message shows the place in its text."""


class InternalError(RuntimeError):
    """A defect of stickslip itself."""


class SolverWarning(UserWarning):
    """A run failed; the result is the orbit up to there."""
