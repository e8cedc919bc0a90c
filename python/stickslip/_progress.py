"""A progress bar, in a terminal and in a notebook."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any

Report = Callable[[float], None]


class _Line:
    """A line on standard error, if that is a terminal."""

    def __init__(self, total: int | None, what: str, unit: str) -> None:
        self._total, self._what, self._unit = total, what, unit
        self._is_shown = sys.stderr.isatty()
        self._width = 0

    def update(self, done: int) -> None:
        if not self._is_shown:
            return
        of = "" if self._total is None else f"/{self._total}"
        line = f"{self._what}: {done}{of} {self._unit}"
        sys.stderr.write("\r" + line.ljust(self._width))
        sys.stderr.flush()
        self._width = len(line)

    def close(self) -> None:
        if self._width:
            sys.stderr.write("\n")


class _Bar:
    """A bar of tqdm, which also works in a notebook."""

    def __init__(self, tqdm: Any, total: int | None, what: str, unit: str) -> None:
        # None hides it where there is no terminal.
        self._bar = tqdm(total=total, desc=what, unit=unit, disable=None)

    def update(self, done: int) -> None:
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        self._bar.close()


def progress_report(
    progress: bool,
    what: str,
    unit: str,
    total: int | None = None,
    span: tuple[float, float] | None = None,
) -> AbstractContextManager[Report | None]:
    """The callback with which the engine reports its progress, or None.

    With a `span` of time the bar shows percent; otherwise it counts to `total`.
    """
    return _shown(what, unit, total, span) if progress else nullcontext()


@contextmanager
def _shown(
    what: str, unit: str, total: int | None, span: tuple[float, float] | None
) -> Iterator[Report]:
    if span is not None:
        total, unit = 100, "%"
    bar: Any
    try:
        from tqdm.auto import tqdm  # type: ignore[import-untyped,import-not-found,unused-ignore]
    except ImportError:
        bar = _Line(total, what, unit)
    else:
        bar = _Bar(tqdm, total, what, unit)
    last = 0

    def report(at: float) -> None:
        nonlocal last
        if span is not None:
            at = 100 * (at - span[0]) / (span[1] - span[0])
        done = max(last, int(min(max(at, 0.0), total or 1e18)))
        last = done
        bar.update(done)

    try:
        yield report
        if total is not None:
            report(span[1] if span is not None else total)
    finally:
        bar.close()
