"""`solve_ivp` and its results."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._arguments import (
    Floats,
    Method,
    OptionsButMethod,
    array,
    as_array,
    checked,
    few,
    settings,
    start,
)
from ._errors import SolverWarning
from ._plot import new_axes
from ._progress import progress_report
from ._results import Result, call_engine, make_result, states_of, structured
from ._symbols import (
    Direction,
    Expression,
    Parameter,
    State,
    out_of_bounds,
    readable,
    sign_of,
    varying,
    whole,
)
from ._system import System
from ._tables import Table


#: Parts of a step in a figure, and most points of its curves.
PARTS_PER_STEP = 16
MOST_DRAWN = 100_000

#: The tables of a solution.
_TABLES = ("transitions", "phases")


@dataclass(frozen=True)
class Event:
    """A function whose zeros are located. `event` makes it.

    Attributes
    ----------
    function : Expression
        The function.
    direction : int
        1 for rising, -1 for falling, 0 for both.
    terminal : int
        The run ends at this number of zeros; 0 for never.
    """

    function: Expression
    direction: int = 0
    terminal: int = 0


def event(
    function: Any, direction: float | Direction = 0, terminal: bool | int = False
) -> Event:
    """Makes an event of a run, or a section: the zeros of a formula.

    Parameters
    ----------
    function : Expression
        A formula of states, parameters and time.
    direction : float or {"rising", "falling", "both"}, optional
        As in SciPy: positive for rising, negative for falling, 0 for both.
    terminal : bool or int, optional
        Whether the run ends at the first zero, or the number of the zero at which it ends.

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
    if callable(function):
        raise TypeError("an event is a formula of symbols, as ss.event(v - 1), and no function")
    formula = varying(function, "the event")
    return Event(formula, sign_of(direction), whole(terminal, "terminal", least=0))


def section_of(system: System, watched: Event | Expression) -> _core.System:
    """The system with an event as its section."""
    watched = watched if isinstance(watched, Event) else event(watched)
    return system._with_sections([(watched.function, watched.direction)])


class DenseOutput:
    """The solution at any time of a run, as accurate as the steps.

    Attributes
    ----------
    t_min, t_max : float
        First and last time.

    Notes
    -----
    A pickle contains the system, the start and the settings. The run is repeated at the first
    evaluation, with the same bits.
    """

    def __init__(
        self,
        run: tuple[Any, ...],
        end: float,
        core: _core.Dense | None = None,
        is_reversed: bool = False,
    ) -> None:
        # Times of a run backwards are negative in the engine.
        self._run, self._end, self._core, self._is_reversed = run, end, core, is_reversed
        ends: list[float] = [run[1][0], end]
        self.t_min, self.t_max = sorted(0.0 - t if is_reversed else t for t in ends)

    def __call__(self, t: ArrayLike) -> Floats:
        """The state at one or several times.

        Parameters
        ----------
        t : float or array_like
            Times of the run.

        Returns
        -------
        ndarray, shape (n, …)
            The states on the first axis, the axes of `t` behind it.

        Raises
        ------
        OptionError
            For a time before or after the run.
        """
        times = as_array(t, "t").astype(np.float64)
        outside = ~((times >= self.t_min) & (times <= self.t_max))
        if outside.any():
            bound = f"within the run, {readable(self.t_min)} to {readable(self.t_max)}"
            raise out_of_bounds("t", float(times[outside].flat[0]), bound)
        if self._core is None:
            system, start, t_end, options, memory = self._run
            until, nothing = (t_end, self._end), np.empty(0)
            again = call_engine(
                _core.solve,
                system._core.reversed() if self._is_reversed else system._core,
                start,
                until,
                [],
                nothing,
                True,
                options,
                memory,
                [],
                None,
            )
            self._core = again["sol"]
        times = 0.0 - times if self._is_reversed else times
        found: Floats = call_engine(self._core.at, np.ascontiguousarray(times.ravel()))
        return found.T.reshape(found.shape[1], *times.shape)

    def __reduce__(self) -> Any:
        return type(self), (self._run, self._end, None, self._is_reversed)

    def __copy__(self) -> DenseOutput:
        return self

    def __deepcopy__(self, memo: Any) -> DenseOutput:
        # It never changes.
        return self

    def __repr__(self) -> str:
        return f"<DenseOutput from t = {self.t_min:g} to {self.t_max:g}>"


@dataclass(frozen=True, repr=False, eq=False)
class Solution(Result):
    """An orbit, with SciPy's names. ``sol["y"]`` is ``sol.y``.

    Attributes
    ----------
    t : ndarray, shape (m,)
        The requested times, or the ends of steps.
    y : ndarray, shape (n, m)
        States at these times. A jump appears twice in `t` and `y`: before and after.
    sol : DenseOutput or None
        The solution at any time, with ``dense_output=True``.
    t_events : list of ndarray, or None
        Times of each event.
    y_events : list of ndarray, shape (k, n), or None
        States at the events.
    nfev : int or None
        Number of evaluations of the field; None for a failed run.
    status : int
        0 at the end time, 1 at a terminal event or jump, 2 if the future is not unique, or
        backwards the past, -1 if the run failed or was interrupted.
    message : str
        The same in words.
    transitions : Table
        Changes of mode and jumps: ``t``, ``kind``, ``contact``, ``from_mode``, ``to_mode``,
        ``y_before`` and ``y`` (the states before and after it), ``residual`` of the boundary
        function. With stops, ``impulse`` has the impulse at each of them. Backwards they are in the
        order of the run.
    phases : Table
        Intervals of one mode: ``t_start``, ``t_end``, ``mode``, ``y_start``, ``y_end``. A mode is
        ``-`` or ``+`` for slip below or above, ``S`` for stick; ``|`` separates several contacts.
    system : System
        The system.
    forces : ndarray, shape (s, m), or None
        Reactions of the stops at `t`, in their order, then the friction of the contacts that have
        a law: in slip that law with the sign of its side, in stick what keeps the boundary's rate
        at zero. Where several contacts stick and the field is no sum of what each contributes, it
        is NaN. None without either.
    dy : ndarray, shape (n, m, k), or None
        With `derivatives`: those of the states at `t`, by each of the variables. `transitions` then
        also has ``dt`` (k), ``dy_before`` and ``dy`` (n, k): of the times, and of the states along
        with them.
    dt_events : list of ndarray, shape (j, k), or None
        Derivatives of the times of each event.
    dy_events : list of ndarray, shape (j, n, k), or None
        Derivatives of the states at the events, which move with their times.
    """

    t: Floats
    y: Floats
    sol: DenseOutput | None
    t_events: list[Floats] | None
    y_events: list[Floats] | None
    nfev: int | None
    status: int
    message: str
    transitions: Table
    phases: Table
    system: System
    forces: Floats | None = None
    dy: Floats | None = None
    dt_events: list[Floats] | None = None
    dy_events: list[Floats] | None = None
    _between: DenseOutput | None = None
    _memory: str | None = None
    _made: Any = None
    _by: tuple[str, ...] = ()
    _acting: tuple[str, ...] = ()
    _columns_of_tables: Any = None

    @classmethod
    def _of(cls, **fields: Any) -> Solution:
        """A solution with these fields; the others have their defaults. A frozen class sets each
        field by a call of its own, and all of them take as long as a short run."""
        made = object.__new__(cls)
        made.__dict__.update(fields)
        return made

    def __post_init__(self) -> None:
        for table in _TABLES:
            if self.__dict__[table] is None:
                object.__delattr__(self, table)

    if not TYPE_CHECKING:
        # Tables take longer than a short run: they are made when they are first asked for.
        def __getattr__(self, name: str) -> Any:
            columns = self.__dict__.get("_columns_of_tables")
            if name in _TABLES and columns is not None:
                table = structured(columns[name], self.system.states, self._by)
                object.__setattr__(self, name, table)
                return table
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    @property
    def success(self) -> bool:
        """Whether the run reached the end time, a terminal event or a jump that ends it."""
        return self.status in (0, 1)

    def __repr__(self) -> str:
        span = f"t = {self.t[0]:g} to {self.t[-1]:g}, " if len(self.t) else ""
        return (
            f"<Solution: {span}{len(self.t)} points, {len(self.phases)} phases, "
            f"{len(self.transitions)} transitions; status {self.status}>"
        )

    def _curve(self) -> tuple[Floats, Floats]:
        """Times and states of a smooth curve through the ends of steps, which may be far apart."""
        parts = min(PARTS_PER_STEP, MOST_DRAWN // max(len(self.t), 1))
        if self._between is None or len(self.t) < 2 or parts < 2:
            return self.t, self.y
        inside = np.linspace(self.t[:-1], self.t[1:], parts, endpoint=False, axis=1).ravel()
        # An end of a step is also the state behind a jump, which has two states.
        states = self._between(np.clip(inside, self._between.t_min, self._between.t_max))
        states[:, ::parts] = self.y[:, :-1]
        return np.append(inside, self.t[-1]), np.hstack([states, self.y[:, -1:]])

    def _columns(self) -> dict[str, Any]:
        columns = {"t": self.t, **states_of(self.system, self.y.T)}
        if self.forces is not None:
            columns |= {f"{name}.force": row for name, row in zip(self._acting, self.forces)}
        for k, name in enumerate(self._by):
            for state, values in zip(self.system.states, () if self.dy is None else self.dy):
                columns[f"d{state}/d{name}"] = values[:, k]
        return columns

    def to_pandas(self) -> Any:
        """The orbit as a `pandas.DataFrame`: a row for each time, a column for each state, and for
        the force of each stop and contact.

        Returns
        -------
        pandas.DataFrame
            `transitions` and `phases` have a `to_pandas` and a `to_xarray` of their own.
        """
        return super().to_pandas().set_index("t")

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        variables: dict[str, Any] = {"y": (("state", "t"), self.y)}
        coordinates: dict[str, Any] = {"t": self.t, "state": list(self.system.states)}
        if self.forces is not None:
            variables["forces"] = (("contact", "t"), self.forces)
            coordinates["contact"] = list(self._acting)
        if self.dy is not None:
            variables["dy"] = (("state", "t", "by"), self.dy)
            coordinates["by"] = list(self._by)
        return variables, coordinates

    def plot(self, axes: Any = None) -> Any:
        """Draws the states against time, and stick as bands.

        The curves are those of the solution, also between steps; without ``dense_output=True``
        the run is repeated for them. At the times of `t_eval`, they are polygons.
        """
        axes = new_axes(axes)
        t, y = self._curve()
        for name, row in zip(self.system.states, y):
            axes.plot(t, row, label=name)
        for phase in self.phases:
            if "S" in phase["mode"]:
                axes.axvspan(phase["t_start"], phase["t_end"], color="0.9", lw=0, zorder=0)
        axes.set_xlabel("t")
        axes.legend()
        return axes


def _end_of(
    sol: Solution, system: System, t0: Any, made: Any
) -> tuple[tuple[float, list[float]], str]:
    """The end of a run as a start, and what goes on from there with the same bits."""
    if sol._memory is None:
        raise ValueError(
            "the run in y0 has not reached its end time, so that none goes on from it: start at "
            "y0=sol.y[:, -1]"
        )
    last = sol.system
    if (last._text, last.parameters) != (system._text, system.parameters) or sol._made != made:
        raise ValueError(
            "the run in y0 is of another system, or with another method, tolerance or option: go "
            "on with the same, or start at y0=sol.y[:, -1]"
        )
    end = _core.end_of(sol._memory)
    if float(t0) != end[0]:
        raise ValueError(f"t_span begins at {t0!r}, and the run in y0 ended at {end[0]!r}")
    return end, sol._memory


def variables(derivatives: Any) -> list[str]:
    """Names of what an orbit is differentiated by."""
    single = isinstance(derivatives, (str, Parameter, State))
    given = [derivatives] if single else [] if derivatives is None else list(derivatives)
    for one in given:
        if not isinstance(one, (str, Parameter, State)):
            raise TypeError(
                f"derivatives: {one!r} is neither a parameter, nor a state, nor the name of one; "
                'the start time is "t0"'
            )
    return [one if isinstance(one, str) else one.name for one in given]


def _span(t_span: tuple[float, float]) -> tuple[float, float]:
    """Start time and end time of a run, which differ."""
    plain = few(t_span)
    ends = array(t_span, "t_span").tolist() if plain is None else plain
    if len(ends) != 2:
        raise ValueError(f"t_span has {len(ends)} values: it must be two, from and to")
    t0, t_end = ends
    if t0 == t_end:
        raise out_of_bounds("t_span[1]", t_end, f"other than t_span[0] = {readable(t0)}")
    return t0, t_end


def _in_forward_time(found: dict[str, Any]) -> None:
    """Replaces the times of a run backwards, which are negative in the engine."""

    def forward(t: Any) -> Any:
        return 0.0 - t

    for table, names in (("transitions", ["t"]), ("phases", ["t_start", "t_end"])):
        for name in names:
            found[table][name] = forward(found[table][name])
    found["t"], found["t_end"] = forward(found["t"]), forward(found["t_end"])
    found["events"] = [(forward(t), y) for t, y in found["events"]]
    # Nothing goes on from a run backwards.
    found["memory"] = None


def _of_events(
    slopes: list[dict[str, Floats] | None] | None, name: str, shape: tuple[int, ...]
) -> list[Floats] | None:
    """Derivatives at each event; none where there was no passage."""
    if slopes is None:
        return None
    return [np.empty((0, *shape)) if one is None else one[name] for one in slopes]


def solve_ivp(
    system: System,
    t_span: tuple[float, float],
    y0: ArrayLike | Mapping[State, float] | Solution | None = None,
    method: Method = "taylor",
    t_eval: ArrayLike | None = None,
    dense_output: bool = False,
    events: Event | Expression | Sequence[Event | Expression] | None = None,
    *,
    derivatives: Parameter | State | str | Sequence[Parameter | State | str] | None = None,
    progress: bool = False,
    **options: Unpack[OptionsButMethod],
) -> Solution:
    """Integrates an orbit, as `scipy.integrate.solve_ivp` does.

    Parameters
    ----------
    system : System
        The system, in place of SciPy's function. Transitions between slip and stick, jumps and
        inputs are parts of it and are located to rounding.
    t_span : (float, float)
        Start time and end time. An end before the start goes backwards, through crossings of
        contacts. A system with jumps, stops or inputs cannot, and a slide has no past: the run ends
        there with status 2 and a warning that names the time.
    y0 : array_like, shape (n,), dict or Solution, optional
        Start state, in order or as ``{x: 1, v: 0}``. Default: the start of the system.
        Discrete states may be left out. With a solution the run goes on from its end: orbit and
        end are those of a single run, bit for bit.
    method : {"taylor", "dop853"}, optional
        The integration method.
    t_eval : array_like, shape (m,), optional
        Times of the output, in the direction of the run, within `t_span`. Default: the ends of
        steps.
    dense_output : bool, optional
        Whether to keep the solution over all steps, for which memory grows with their number.
    events : Event, Expression or a sequence of them, optional
        Further events to locate in the same run, whose bits they do not change. The first terminal
        one along the run ends it, and directions are along the run, too. Symbols in them have the
        values that they have in the system.
    derivatives : sequence of Parameter, State or str, optional
        Parameters, states (for their start values), and "t0" for the start time, by which the orbit
        is differentiated, through all its events; see `Solution.dy`. The start state is held fixed,
        also where it is a formula of a parameter. At a graze, and where two contacts come to zero
        at once, there is no derivative: a warning says when, and what follows is NaN.
    progress : bool, optional
        Whether to show the progress of the run; as a bar if tqdm is installed.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    Solution

    Raises
    ------
    OptionError
        For a number that is out of bounds, NaN or infinite; other wrong arguments raise
        `ValueError` or `TypeError`.
    StickslipError
        If the run fails at its start. If it fails later, or its future is not unique, it warns and
        returns the orbit so far.
    Interrupted
        On Ctrl-C; `partial` is the orbit so far.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, v = ss.states("x v")
    >>> sol = ss.solve_ivp(ss.System({x: v, v: -x}), (0, 4), [0, 1], events=x - 0.5)
    >>> (sol.t_events[0] * 6 / np.pi).round(12)
    array([1., 5.])
    """
    t0, t_end = _span(t_span)
    is_reversed = t_end < t0
    made = settings({"method": method, **options})
    memory = None
    if isinstance(y0, Solution):
        if is_reversed:
            raise ValueError("a run backwards does not go on from another: give y0=sol.y[:, -1]")
        begin, memory = _end_of(y0, system, t0, made)
    else:
        begin = start(system, t0, y0)
    if derivatives is not None and (memory is not None or is_reversed):
        which = "backwards" if is_reversed else "that goes on from another one"
        raise ValueError(f"derivatives of a run {which} are not known")
    by = variables(derivatives)
    times = None
    if t_eval is not None:
        times = array(t_eval, "t_eval")
        low, high = sorted((t0, t_end))
        for k in np.flatnonzero((times < low) | (times > high))[:1]:
            bound = f"within t_span, {readable(t0)} to {readable(t_end)}"
            raise out_of_bounds(f"t_eval[{k}]", float(times[k]), bound)
        steps = np.diff(times) * (-1 if is_reversed else 1)
        if (steps <= 0).any():
            k = int(np.argmax(steps <= 0)) + 1
            raise ValueError(
                f"values in t_eval are not sorted, each {'smaller' if is_reversed else 'larger'} "
                f"than the one before: t_eval[{k}] = {float(times[k])!r} follows "
                f"{float(times[k - 1])!r}"
            )
    given = [] if events is None else events if isinstance(events, (list, tuple)) else [events]
    watched = [one if isinstance(one, Event) else event(one) for one in given]
    core = checked(system)._with_sections((one.function, one.direction) for one in watched)
    if is_reversed:
        core = core.reversed()
        begin, t_end = (0.0 - begin[0], begin[1]), 0.0 - t_end
        times = None if times is None else 0.0 - times
    with progress_report(progress, "solve_ivp", "", span=(begin[0], t_end)) as report:
        found = call_engine(
            _core.solve,
            core,
            begin,
            (t_end, math.inf),
            [one.terminal for one in watched],
            times,
            dense_output,
            made,
            memory,
            by,
            report,
        )
    if is_reversed:
        _in_forward_time(found)
    end = found.pop("t_end")
    if is_reversed and found["status"] == -1:
        found["message"] += " (the run goes backwards, and its times are the negatives of these)"
    if "raised" in found:
        found.update(status=-1, message=f"The run was interrupted at t = {end}.")
    elif found["status"] not in (0, 1):
        warnings.warn(found["message"], SolverWarning, stacklevel=2)
    for doubt in found.pop("doubtful"):
        warnings.warn(doubt, SolverWarning, stacklevel=2)
    passed, dense = found.pop("events"), found.pop("sol")
    found["y"] = found["y"].T
    if "forces" in found:
        found["forces"] = found["forces"].T
        found["_acting"] = tuple(found.pop("acting"))
    of_events = None
    if "derivatives" in found:
        slopes = found.pop("derivatives")
        found["dy"] = slopes["dy"].transpose(1, 0, 2)
        found["transitions"].update(slopes["transitions"])
        of_events = [slopes.get(f"event {k}") for k in range(len(watched))]
        if slopes["lost"] is not None and found["status"] in (0, 1, 2):
            message = f"there are no derivatives from there on: {slopes['lost']}"
            warnings.warn(message, SolverWarning, stacklevel=2)
    columns = {table: found.pop(table) for table in _TABLES}
    last = 0.0 - end if is_reversed else end
    between = DenseOutput((system, begin, t_end, made, memory), last, dense, is_reversed)
    found["_memory"] = found.pop("memory")
    return make_result(
        found,
        Solution._of,
        _columns_of_tables=columns,
        sol=between if dense_output else None,
        _between=between if times is None else None,
        t_events=None if events is None else [one[0] for one in passed],
        y_events=None if events is None else [one[1] for one in passed],
        dt_events=_of_events(of_events, "dt", (len(by),)),
        dy_events=_of_events(of_events, "dy", (found["y"].shape[0], len(by))),
        system=system,
        _made=made,
        _by=tuple(by),
    )
