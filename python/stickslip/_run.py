"""Runs: `solve_ivp`, and what it returns."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal, TypedDict, TypeVar, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._errors import InternalError, Interrupted, SolverWarning
from ._plot import new_axes
from ._progress import shown
from ._symbols import Expression, expression
from ._system import System

Floats = NDArray[np.float64]
Method = Literal["taylor", "dop853"]
_T = TypeVar("_T")


@dataclass(frozen=True)
class Event:
    """A function whose zeros are located; made by `event`.

    Attributes
    ----------
    function : Expression
        The function.
    direction : int
        1 for rising, -1 for falling, 0 for both.
    terminal : int
        The run ends at the passage of that number; 0 never.
    """

    function: Expression
    direction: int = 0
    terminal: int = 0


def event(function: Any, direction: float = 0, terminal: bool | int = False) -> Event:
    """An event of a run, or a section: where a formula passes through zero.

    Parameters
    ----------
    function : Expression
        A formula of states, parameters and time.
    direction : float, optional
        As SciPy's: positive for rising, negative for falling, 0 for both.
    terminal : bool or int, optional
        Whether the run ends there, or at the passage of which number.

    Returns
    -------
    Event

    Raises
    ------
    ValueError
        If the formula is constant, or `terminal` negative.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, v = ss.states("x v")
    >>> ss.event(v, direction=-1)
    Event(function=v, direction=-1, terminal=0)
    """
    formula = expression(function)
    if not formula.parts:
        raise ValueError(f"the event {formula} is constant")
    count = int(terminal)
    if count < 0:
        raise ValueError(f"terminal = {terminal!r}: it is True, False or a number of passages")
    return Event(formula, int(np.sign(direction)), count)


class Options(TypedDict, total=False):
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

    rtol: float
    atol: float | None
    method: Method
    max_step: float
    escape: float
    at_repelling: Literal["stop", "below", "above"]
    at_pile_up: Literal["stop", "rest"]
    most_events: int
    most_steps: int


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


def settings(options: Options) -> dict[str, Any]:
    """All settings of a run, with the program's defaults."""
    unknown = options.keys() - _DEFAULTS.keys()
    if unknown:
        names = ", ".join(_DEFAULTS)
        raise TypeError(f"{sorted(unknown)[0]!r} is no option: they are {names}")
    made: dict[str, Any] = {**_DEFAULTS, **options}
    for name in ("rtol", "max_step", "escape"):
        made[name] = float(made[name])
    made["atol"] = made["rtol"] if made["atol"] is None else float(made["atol"])
    made["method"] = str(made["method"]).lower()
    return made


def called(function: Callable[..., _T], *of: Any) -> _T:
    """A call of the engine, of which a panic is an `InternalError`."""
    try:
        return function(*of)
    except KeyboardInterrupt as raised:
        # There is nothing to keep.
        raise Interrupted() from raised
    except BaseException as error:
        if type(error).__name__ != "PanicException":
            raise
        raise InternalError(f"a defect of stickslip: {error}") from None


def kept(found: dict[str, Any], result: _T) -> _T:
    """The result; where something has ended the computation early, that is raised, and Ctrl-C as
    `Interrupted` with the result."""
    raised = found.get("raised")
    if raised is None:
        return result
    if isinstance(raised, KeyboardInterrupt):
        raise Interrupted("interrupted; `partial` has what was found", result) from raised
    raise raised


def array(values: ArrayLike, name: str, dimensions: int = 1) -> Floats:
    """Finite doubles of so many dimensions, in order."""
    found = np.asarray(values)
    if found.dtype.kind not in "fiub":
        raise TypeError(f"{name} must be real numbers, not {found.dtype}")
    if found.ndim != dimensions:
        raise ValueError(f"{name} must have {dimensions} dimension(s), not {found.ndim}")
    # A sum is finite where all are, and where it overflows they are looked at one by one.
    if not math.isfinite(found.sum()) and not np.isfinite(found).all():
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
    """The solution at any time of a run, with an error as that of the steps.

    Attributes
    ----------
    t_min, t_max : float
        Where it begins and ends.

    Notes
    -----
    A pickle is the system, the start and the settings. The run is made again where the solution is
    asked for first, with the same bits.
    """

    def __init__(self, run: tuple[Any, ...], t_max: float, core: _core.Dense | None = None) -> None:
        self._run, self._core = run, core
        self.t_min: float = run[1][0]
        self.t_max = t_max

    def __call__(self, t: ArrayLike) -> Floats:
        """The state at a time, or at several.

        Parameters
        ----------
        t : float or array_like, shape (m,)
            Times of the run.

        Returns
        -------
        ndarray, shape (n,) or (n, m)

        Raises
        ------
        ValueError
            For a time before or after the run.
        """
        times = np.asarray(t, dtype=np.float64)
        outside = ~((times >= self.t_min) & (times <= self.t_max))
        if outside.any():
            first = float(times[outside].flat[0])
            raise ValueError(f"t = {first}: the run goes from {self.t_min} to {self.t_max}")
        if self._core is None:
            system, start, t_end, options = self._run
            until, nothing = (t_end, self.t_max), np.empty(0)
            again = called(
                _core.solve, system._core, start, until, [], nothing, True, options, None
            )
            self._core = again["sol"]
        found = called(self._core.at, np.ascontiguousarray(times.ravel()))
        return found[0] if times.ndim == 0 else found.T

    def __reduce__(self) -> Any:
        return type(self), (self._run, self.t_max)

    def __copy__(self) -> DenseOutput:
        return self

    def __deepcopy__(self, memo: Any) -> DenseOutput:
        # It never changes.
        return self

    def __repr__(self) -> str:
        return f"<DenseOutput from t = {self.t_min:g} to {self.t_max:g}>"


@dataclass(frozen=True, repr=False)
class Solution:
    """An orbit, with SciPy's names.

    Attributes
    ----------
    t : ndarray, shape (m,)
        The times asked for, or ends of steps.
    y : ndarray, shape (n, m)
        States there. Of a system with jumps, each jump is twice in `t` and `y`: before and after.
    sol : DenseOutput or None
        The solution at any time, with ``dense_output=True``.
    t_events : list of ndarray, or None
        Times of each event.
    y_events : list of ndarray, shape (k, n), or None
        States there.
    nfev : int or None
        Evaluations of the field; unknown of a run that failed.
    status : int
        0 at the end, 1 at a terminal event or jump, 2 where the future is not unique, -1 of a run
        that failed or was interrupted.
    message : str
        The same in words.
    transitions : ndarray, structured
        Each change of a mode and each jump: ``t``, ``kind``, ``contact``, ``from_mode``,
        ``to_mode``, ``y`` (behind it), ``residual`` of the boundary function.
    phases : ndarray, structured
        The run in one mode after the other: ``t_start``, ``t_end``, ``mode``, ``y_start``,
        ``y_end``. A mode is ``-`` or ``+`` for slip below or above, ``S`` for stick; of several
        contacts with ``|`` between.
    system : System
        What was run.
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
        """Draws the states against time, and stick as bands.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to; new axes unless given.

        Returns
        -------
        matplotlib.axes.Axes
        """
        axes = new_axes(axes)
        for name, row in zip(self.system.states, self.y):
            axes.plot(self.t, row, label=name)
        for phase in self.phases:
            if "S" in phase["mode"]:
                axes.axvspan(phase["t_start"], phase["t_end"], color="0.9", lw=0, zorder=0)
        axes.set_xlabel("t")
        axes.legend()
        return axes


@lru_cache(maxsize=256)
def _dtype(fields: tuple[tuple[str, Any, tuple[int, ...]], ...]) -> np.dtype[np.void]:
    return np.dtype(list(fields))


def structured(columns: Mapping[str, Any]) -> NDArray[np.void]:
    """A structured array of columns: texts, numbers, or rows of numbers.

    Texts are a list, or a pair: the distinct ones, and for each entry its index among them.
    """
    types: list[tuple[str, Any, tuple[int, ...]]] = []
    for name, values in columns.items():
        words = values[0] if isinstance(values, tuple) else values
        if isinstance(words, list):
            types.append((name, f"U{max(map(len, words), default=0) or 1}", ()))
        else:
            types.append((name, "f8", values.shape[1:]))
    first = next(iter(columns.values()))
    count = len(first[1] if isinstance(first, tuple) else first)
    found = np.zeros(count, dtype=_dtype(tuple(types)))
    if count:
        for name, values in columns.items():
            found[name] = np.array(values[0])[values[1]] if isinstance(values, tuple) else values
    return found


def solve_ivp(
    system: System,
    t_span: tuple[float, float],
    y0: ArrayLike | None = None,
    method: Method = "taylor",
    t_eval: ArrayLike | None = None,
    dense_output: bool = False,
    events: Event | Expression | Sequence[Event | Expression] | None = None,
    *,
    progress: bool = False,
    **options: Unpack[Options],
) -> Solution:
    """Follows an orbit, as `scipy.integrate.solve_ivp` does.

    Parameters
    ----------
    system : System
        What to run. There is no function of a state: transitions between slip and stick, jumps and
        inputs are parts of the system and located to rounding.
    t_span : (float, float)
        Start and end, the end later.
    y0 : array_like, shape (n,), optional
        State at the start; that of the system unless given.
    method : {"taylor", "dop853"}, optional
        How steps are made.
    t_eval : array_like, shape (m,), optional
        Times at which the state is wanted, sorted, within `t_span`; ends of steps unless given.
    dense_output : bool, optional
        Whether to keep the solution over all steps. Memory grows with the number of steps then, and
        otherwise only with what is asked for and with transitions.
    events : Event, Expression or a sequence of them, optional
        What else to locate. Each event but one costs a run of its own, of the same orbit.
    progress : bool, optional
        Whether to show how far the run is; with tqdm installed as a bar.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    Solution

    Raises
    ------
    ValueError, TypeError
        For an argument that cannot be, by its name.
    StickslipError
        If the run fails at its start. If it fails later, it warns and returns the orbit until then.
    Interrupted
        On Ctrl-C; `partial` is the orbit up to there.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, v = ss.states("x v")
    >>> sol = ss.solve_ivp(ss.System({x: v, v: -x}), (0, 4), [0, 1], events=x - 0.5)
    >>> (sol.t_events[0] * 6 / np.pi).round(12)
    array([1., 5.])
    """
    if not isinstance(system, System):
        raise TypeError(f"system must be a stickslip.System, not {type(system).__name__}")
    t0, t_end = array(t_span, "t_span").tolist()
    if not t_end > t0:
        raise ValueError(f"t_span = ({t0}, {t_end}): the end must be later than the start")
    start = (t0, state(system, y0))
    times = None
    if t_eval is not None:
        times = array(t_eval, "t_eval")
        if times.size and (times.min() < t0 or times.max() > t_end):
            raise ValueError("values in t_eval are not within t_span")
        if (np.diff(times) <= 0).any():
            raise ValueError("values in t_eval are not sorted, each larger than the one before")
    given = [events] if isinstance(events, (Event, Expression)) else list(events or [])
    watched = [one if isinstance(one, Event) else event(one) for one in given]
    sections = [
        (system._section(one.function.text, one.direction), one.terminal) for one in watched
    ]
    options["method"] = method
    made = settings(options)
    with shown(progress, "solve_ivp", "", span=(t0, t_end)) as report:
        found = called(
            _core.solve,
            system._core,
            start,
            (t_end, math.inf),
            sections,
            times,
            dense_output,
            made,
            report,
        )
    status, message, end = found["status"], found["message"], found["t_end"]
    if "raised" in found:
        status, message = -1, f"The run was interrupted at t = {end}."
    elif status < 0:
        warnings.warn(message, SolverWarning, stacklevel=2)
    rows, phases = found["transitions"], found["phases"]
    passed = found["events"] if events is not None else None
    run = (system, start, t_end, made)
    result = Solution(
        t=found["t"],
        y=found["y"].T,
        sol=DenseOutput(run, end, found["sol"]) if dense_output else None,
        t_events=None if passed is None else [one[0] for one in passed],
        y_events=None if passed is None else [one[1] for one in passed],
        nfev=found["nfev"],
        status=status,
        message=message,
        transitions=structured(rows),
        phases=structured(phases),
        system=system,
    )
    return kept(found, result)
