"""Runs: `solve_ivp`, and what it returns."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._errors import InternalError, SolverWarning
from ._symbols import Expression, expression
from ._system import System

Floats = NDArray[np.float64]
Method = Literal["taylor", "dop853"]
_T = TypeVar("_T")


@dataclass(frozen=True)
class Event:
    """A function whose zeros are located; see `event`."""

    function: Expression
    direction: int = 0
    terminal: int = 0


def event(function: Any, direction: float = 0, terminal: bool | int = False) -> Event:
    """An event of a run: where a formula passes through zero.

    `direction` is as SciPy's: positive for rising, negative for falling, 0 for both. With
    `terminal` the run ends there, or at the passage of that number.
    """
    formula = expression(function)
    if not formula.parts:
        raise ValueError(f"the event {formula} is constant")
    count = int(terminal)
    if count < 0:
        raise ValueError(f"terminal = {terminal!r}: it is True, False or a number of passages")
    return Event(formula, int(np.sign(direction)), count)


def settings(
    rtol: float = 1e-12,
    atol: float | None = None,
    method: Method = "taylor",
    max_step: float = math.inf,
    escape: float = 1e6,
    at_repelling: Literal["stop", "below", "above"] = "stop",
    at_pile_up: Literal["stop", "rest"] = "stop",
    most_events: int = 200_000,
    most_steps: int = 1_000_000_000,
) -> dict[str, Any]:
    """The settings of a run, with the program's defaults; `atol` is `rtol` unless it is given."""
    return {
        "rtol": float(rtol),
        "atol": float(rtol if atol is None else atol),
        "method": str(method).lower(),
        "max_step": float(max_step),
        "escape": float(escape),
        "at_repelling": at_repelling,
        "at_pile_up": at_pile_up,
        "most_events": most_events,
        "most_steps": most_steps,
    }


def called(function: Callable[..., _T], *of: Any) -> _T:
    """A call of the engine, of which a panic is an `InternalError`."""
    try:
        return function(*of)
    except BaseException as error:
        if type(error).__name__ != "PanicException":
            raise
        raise InternalError(f"a defect of stickslip: {error}") from None


def array(values: ArrayLike, name: str, dimensions: int = 1) -> Floats:
    """Finite doubles of so many dimensions, in order."""
    found = np.asarray(values)
    if found.dtype.kind not in "fiub":
        raise TypeError(f"{name} must be real numbers, not {found.dtype}")
    if found.ndim != dimensions:
        raise ValueError(f"{name} must have {dimensions} dimension(s), not {found.ndim}")
    if not np.isfinite(found).all():
        place = tuple(int(k) for k in np.argwhere(~np.isfinite(found))[0])
        raise ValueError(f"{name}[{', '.join(map(str, place))}] = {found[place]} is not finite")
    return np.ascontiguousarray(found, dtype=np.float64)


def state(system: System, y0: ArrayLike | None) -> list[float]:
    """A state at the start: as given, or as the system says."""
    if y0 is None:
        if system.start is None:
            raise ValueError("the system has no start: give y0")
        return list(system.start)
    found = array(y0, "y0")
    names = system.states
    if len(found) != len(names):
        raise ValueError(
            f"y0 has {len(found)} values, and there are {len(names)} states: {', '.join(names)}"
        )
    return [float(value) for value in found]


class DenseOutput:
    """The solution at any time of the run: a state for a time, states × times for several."""

    def __init__(self, core: _core.Dense, t_min: float) -> None:
        self._core, self.t_min, self.t_max = core, t_min, core.t_max

    def __call__(self, t: ArrayLike) -> Floats:
        times = np.asarray(t, dtype=np.float64)
        found = called(self._core.at, np.ascontiguousarray(times.ravel()))
        return found[0] if times.ndim == 0 else found.T

    def __repr__(self) -> str:
        return f"<DenseOutput from t = {self.t_min:g} to {self.t_max:g}>"


@dataclass(frozen=True, repr=False)
class Solution:
    """An orbit, with SciPy's names.

    Of a system with jumps each of them is twice in `t` and `y`, before and behind it. `phases` and
    `transitions` are structured arrays. A status of 2 says that the future is not unique.
    """

    t: Floats
    y: Floats
    sol: DenseOutput | None
    t_events: list[Floats] | None
    y_events: list[Floats] | None
    nfev: int | None
    status: int
    message: str
    transitions: NDArray[np.void]
    phases: NDArray[np.void]
    system: System

    @property
    def success(self) -> bool:
        """Whether the run did not fail."""
        return self.status >= 0

    def __repr__(self) -> str:
        span = f"t = {self.t[0]:g} to {self.t[-1]:g}, " if len(self.t) else ""
        return (
            f"<Solution: {span}{len(self.t)} points, {len(self.phases)} phases, "
            f"{len(self.transitions)} transitions; status {self.status}>"
        )

    def plot(self, axes: Any = None) -> Any:
        """Draws the states against time, and stick as bands; needs matplotlib."""
        if axes is None:
            import matplotlib.pyplot as plt  # type: ignore[import-not-found,unused-ignore]

            _, axes = plt.subplots()
        for name, row in zip(self.system.states, self.y):
            axes.plot(self.t, row, label=name)
        for phase in self.phases:
            if "S" in phase["mode"]:
                axes.axvspan(phase["t_start"], phase["t_end"], alpha=0.15, lw=0)
        axes.set_xlabel("t")
        axes.legend()
        return axes


def structured(columns: Sequence[tuple[str, Any]], count: int, states: int) -> NDArray[np.void]:
    """A structured array of columns."""
    types: list[Any] = []
    for name, values in columns:
        if isinstance(values, list):
            width = max([1, *(len(text) for text in values)])
            types.append((name, f"U{width}"))
        elif values.ndim == 2:
            types.append((name, "f8", (states,)))
        else:
            types.append((name, "f8"))
    found = np.zeros(count, dtype=types)
    for name, values in columns:
        found[name] = values
    return found


def solve_ivp(
    system: System,
    t_span: tuple[float, float],
    y0: ArrayLike | None = None,
    method: Method = "taylor",
    t_eval: ArrayLike | None = None,
    dense_output: bool = False,
    events: Event | Expression | Sequence[Event | Expression] | None = None,
    **options: Any,
) -> Solution:
    """Follows an orbit from `t_span[0]` to `t_span[1]`.

    The arguments are those of `scipy.integrate.solve_ivp`; the options are `rtol`, `atol`,
    `max_step`, and others of `settings`. Transitions and events are located to rounding. Each event
    but one costs a run of its own, of the same orbit.
    """
    if not isinstance(system, System):
        raise TypeError(f"system must be a stickslip.System, not {type(system).__name__}")
    t0, t_end = (float(value) for value in array(t_span, "t_span"))
    if not t_end > t0:
        raise ValueError(f"t_span = ({t0}, {t_end}): the end must be later than the start")
    start = state(system, y0)
    times = None
    if t_eval is not None:
        times = array(t_eval, "t_eval")
        if times.size and (times.min() < t0 or times.max() > t_end):
            raise ValueError("values in t_eval are not within t_span")
        if (np.diff(times) <= 0).any():
            raise ValueError("values in t_eval are not sorted, each larger than the one before")
    given = [events] if isinstance(events, (Event, Expression)) else list(events or [])
    watched = [one if isinstance(one, Event) else event(one) for one in given]
    found = called(
        _core.solve,
        system._core,
        (t0, start),
        t_end,
        [(one.function.text, one.direction, one.terminal) for one in watched],
        times,
        dense_output,
        settings(method=method, **options),
    )
    if found["status"] < 0:
        warnings.warn(found["message"], SolverWarning, stacklevel=2)
    size = len(start)
    names = [*system.contacts, *system.jumps]
    rows, phases = found["transitions"], found["phases"]
    transitions = structured(
        [
            ("t", rows["t"]),
            ("kind", rows["kind"]),
            ("contact", [names[k] if k < len(names) else "" for k in rows["contact"]]),
            ("from_mode", rows["from_mode"]),
            ("to_mode", rows["to_mode"]),
            ("y", rows["y"]),
            ("residual", rows["residual"]),
        ],
        len(rows["t"]),
        size,
    )
    columns = [(name, phases[name]) for name in ("t_start", "t_end", "mode", "y_start", "y_end")]
    passed = found["events"] if events is not None else None
    return Solution(
        t=found["t"],
        y=found["y"].T,
        sol=DenseOutput(found["sol"], t0) if dense_output else None,
        t_events=None if passed is None else [one[0] for one in passed],
        y_events=None if passed is None else [one[1] for one in passed],
        nfev=found["nfev"],
        status=found["status"],
        message=found["message"],
        transitions=transitions,
        phases=structured(columns, len(phases["t_start"]), size),
        system=system,
    )
