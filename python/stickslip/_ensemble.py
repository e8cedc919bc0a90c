"""Orbits from many starts."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._arguments import (
    Floats,
    Options,
    array,
    checked,
    name_of,
    pair,
    rows_of_starts,
    settings,
    state,
    threads,
)
from ._plot import new_axes
from ._progress import progress_report
from ._results import (
    Result,
    call_engine,
    column,
    make_result,
    states_of,
    warn_of_doubts,
    warn_of_failures,
)
from ._run import Event, Solution, event
from ._symbols import Expression, Parameter, State, out_of_bounds, readable
from ._system import System
from ._tables import Table, structured

#: Orbits that are followed before their results are passed on. It bounds the memory of `reduce`.
AT_ONCE = 4096
#: Most curves of a figure.
MOST_CURVES = 200


@dataclass(frozen=True, repr=False, eq=False)
class Ensemble(Result):
    """Orbits from many starts. Each has the bits of a run by `solve_ivp`.

    Attributes
    ----------
    t : ndarray, shape (m,)
        The requested times.
    y : ndarray, shape (n, k, m), or None
        States of the k orbits at these times; NaN where an orbit has ended before. None with
        `reduce`.
    y0 : ndarray, shape (n, k)
        The starts.
    parameters : dict of ndarray, shape (k,)
        Values of the parameters that vary, by name.
    t_end : ndarray, shape (k,)
        Time at which each orbit ended.
    y_end : ndarray, shape (n, k)
        State at that time.
    status : ndarray of int, shape (k,)
        As of a `Solution`. An orbit that fails has -1 and keeps the others.
    message : list of str
        The same in words.
    nfev : ndarray, shape (k,)
        Numbers of evaluations of the field; NaN for failed orbits.
    t_events : list of list of ndarray, or None
        Times of each event in each orbit: ``t_events[event][orbit]``.
    y_events : list of list of ndarray, or None
        States at the events, each of shape (j, n).
    transitions : Table or None
        Changes of mode and jumps as in `Solution`, with the number of the ``orbit``, from 0.
    phases : Table or None
        Phases as in `Solution`, with the number of the ``orbit``.
    reduced : ndarray or None
        What `reduce` returned for each orbit, on the first axis.
    system : System
        The system.
    """

    t: Floats
    y: Floats | None
    y0: Floats
    parameters: dict[str, Floats]
    t_end: Floats
    y_end: Floats
    status: NDArray[np.int64]
    message: list[str]
    nfev: Floats
    t_events: list[list[Floats]] | None
    y_events: list[list[Floats]] | None
    transitions: Table | None
    phases: Table | None
    reduced: NDArray[Any] | None
    system: System

    @property
    def success(self) -> NDArray[np.bool_]:
        """Whether each orbit reached the end time, a terminal event or a jump that ends it."""
        good: NDArray[np.bool_] = (self.status == 0) | (self.status == 1)
        return good

    def _columns(self) -> dict[str, Any]:
        ends = states_of(self.system, self.y_end.T, ".end")
        starts = states_of(self.system, self.y0.T)
        return {
            **self.parameters,
            **starts,
            "t.end": self.t_end,
            **ends,
            "status": self.status,
            **self._reduced_columns(),
        }

    def _reduced_columns(self) -> dict[str, Any]:
        """A column for each number of `reduced`."""
        found = self._reduced_of_all()
        if found is None or found.ndim == 1:
            return {} if found is None else {"reduced": found}
        return {
            ".".join(["reduced", *map(str, place)]): found[(slice(None), *place)]
            for place in np.ndindex(found.shape[1:])
        }

    def _reduced_of_all(self) -> NDArray[Any] | None:
        """`reduced` with a row for each orbit. An interrupted ensemble has none for the last."""
        if self.reduced is None:
            return None
        missing = len(self.status) - len(self.reduced)
        if missing == 0:
            return self.reduced
        if self.reduced.dtype == object:
            return np.append(self.reduced, np.full(missing, None, dtype=object))
        shape = (missing, *self.reduced.shape[1:])
        return np.concatenate([self.reduced, np.full(shape, np.nan)]) if len(self.reduced) else None

    def to_pandas(self) -> Any:
        """The states at all times as a `pandas.DataFrame`, with orbit and time as its index.

        Returns
        -------
        pandas.DataFrame
            With `reduce`, a row for each orbit: its start, its end and what was kept of it, as
            ``reduced``, or ``reduced.0``, ``reduced.1`` for an array.
        """
        if self.y is None:
            return super().to_pandas()
        from ._tables import pandas

        orbits = range(self.y.shape[1])
        index = pandas().MultiIndex.from_product([orbits, self.t], names=["orbit", "t"])
        rows = self.y.transpose(1, 2, 0).reshape(-1, self.y.shape[0])
        return pandas().DataFrame(rows, index=index, columns=list(self.system.states))

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        variables: dict[str, Any] = {
            "y0": (("state", "orbit"), self.y0),
            "t_end": ("orbit", self.t_end),
            "y_end": (("state", "orbit"), self.y_end),
            "status": ("orbit", self.status),
        }
        if self.y is not None:
            variables["y"] = (("state", "orbit", "t"), self.y)
        reduced = self._reduced_of_all()
        if reduced is not None:
            axes = [f"reduced_{k}" for k in range(reduced.ndim - 1)]
            variables["reduced"] = (("orbit", *axes), reduced)
        coordinates: dict[str, Any] = {
            "state": list(self.system.states),
            "orbit": np.arange(len(self.status)),
            "t": self.t,
        }
        for name, values in self.parameters.items():
            coordinates[name] = ("orbit", values)
        return variables, coordinates

    def plot(self, axes: Any = None, state: int | str | State = 0) -> Any:
        """Draws a state of the orbits against time; without `y`, the ends against the starts.

        Parameters
        ----------
        state : int, str or State, optional
            The state, by number or name.
        """
        axes = new_axes(axes)
        k, name = column(self.system, state)
        if self.y is None or len(self.t) < 2:
            axes.plot(self.y0[k], self.y_end[k], ".", ms=3)
            axes.set(xlabel=f"{name} at the start", ylabel=f"{name} at the end")
        else:
            axes.plot(self.t, self.y[k, :MOST_CURVES].T, lw=0.7)
            axes.set(xlabel="t", ylabel=name)
        return axes


def _values(
    system: System, parameters: Mapping[Any, ArrayLike] | None, orbits: int | None
) -> tuple[list[str], Floats]:
    """Names of the parameters that vary, and a row of values for each orbit."""
    given = {name_of(key): np.atleast_1d(value) for key, value in (parameters or {}).items()}
    columns = {name: array(values, f"parameters[{name}]") for name, values in given.items()}
    for name in columns:
        if name not in system.parameters:
            known = ", ".join(system.parameters) or "none"
            raise ValueError(f"there is no parameter {name}: there are {known}")
    lengths = {len(values) for values in columns.values()} - {1}
    if orbits not in (None, 1):
        lengths |= {int(orbits or 0)}
    if len(lengths) > 1:
        several = ", ".join(f"{len(values)} of {name}" for name, values in columns.items())
        starts = "" if orbits is None else f" and {orbits} starts"
        raise ValueError(
            f"parameters has {several}{starts}: give one value, or as many as there are orbits"
        )
    count = next(iter(lengths), 1)
    rows = [np.broadcast_to(values, count) for values in columns.values()]
    return list(columns), np.array(rows, dtype=np.float64).reshape(len(rows), count).T.copy()


def _start(system: System, own: dict[str, float]) -> list[float]:
    """The start of the system with these values of parameters."""
    return state(system.with_parameters(own) if own else system, None)


def _times(t_eval: ArrayLike | None, t0: float, t_end: float) -> Floats:
    if t_eval is None:
        return np.array([t_end])
    times = array(t_eval, "t_eval")
    for k in np.flatnonzero((times < t0) | (times > t_end))[:1]:
        bound = f"within t_span, {readable(t0)} to {readable(t_end)}"
        raise out_of_bounds(f"t_eval[{k}]", float(times[k]), bound)
    if (np.diff(times) <= 0).any():
        raise ValueError("values in t_eval are not sorted, each larger than the one before")
    return times


def _split(rows: NDArray[Any], counts: NDArray[np.int64]) -> list[Any]:
    """The rows of each orbit."""
    return np.split(rows, np.cumsum(counts)[:-1])


def _table(columns: dict[str, Any], counts: Any, first: int, system: System) -> Table:
    orbits = np.repeat(np.arange(first, first + len(counts)), counts)
    return structured({"orbit": orbits, **columns}, system.states)


def _joined(tables: list[Table]) -> Table:
    # Texts of the tables may have different lengths.
    joined: Table = np.concatenate([np.asarray(one) for one in tables]).view(Table)
    return joined


def _solutions(
    found: dict[str, Any],
    several: bool,
    system: System,
    values: list[dict[str, float]],
) -> list[Solution]:
    """Each orbit as the result of `solve_ivp`."""
    tables = {
        name: _split(structured(found[table], system.states), found[counts])
        for name, table, counts in (
            ("transitions", "transitions", "transition_counts"),
            ("phases", "phases", "phase_counts"),
        )
    }
    t, y = (_split(found[name], found["points"]) for name in ("t", "y"))
    forces = _split(found["forces"], found["points"]) if "forces" in found else None
    acting = tuple(found.get("acting", ()))
    events = [
        [_split(one[name], one["counts"]) for one in found["events"]] for name in ("t", "y")
    ]
    return [
        Solution(
            t=t[k],
            y=y[k].T,
            sol=None,
            t_events=[one[k] for one in events[0]] if several else None,
            y_events=[one[k] for one in events[1]] if several else None,
            nfev=None if math.isnan(found["nfev"][k]) else int(found["nfev"][k]),
            status=int(found["status"][k]),
            message=found["message"][k],
            transitions=tables["transitions"][k],
            phases=tables["phases"][k],
            system=system.with_parameters(own) if own else system,
            forces=None if forces is None else forces[k].T,
            _acting=acting,
        )
        for k, own in enumerate(values)
    ]


def ensemble(
    system: System,
    starts: ArrayLike | Sequence[ArrayLike] | None,
    t_span: tuple[float, float],
    t_eval: ArrayLike | None = None,
    events: Event | Expression | Sequence[Event | Expression] | None = None,
    *,
    parameters: Mapping[Any, ArrayLike] | None = None,
    reduce: Callable[[Solution], Any] | None = None,
    workers: int = -1,
    progress: bool = False,
    **options: Unpack[Options],
) -> Ensemble:
    """Integrates the orbits from many starts, on all cores.

    Each orbit has the bits that it has by `solve_ivp`. With the Taylor method, orbits of a system
    without jumps and inputs that have the same parameters are computed side by side in vectors.

    Parameters
    ----------
    system : System
        The system.
    starts : array_like, shape (k, n), or None
        A row for each orbit, or a single state for all; a table of pandas goes by its names.
        Discrete states, the last of the n, may be left out. None is the start of the system, with
        the parameters of each orbit.
    t_span : (float, float)
        Start time and end time, the same for all.
    t_eval : array_like, shape (m,), optional
        Times of the output, sorted, within `t_span`. Default: the end time. With `reduce`, the ends
        of steps.
    events : Event, Expression or a sequence of them, optional
        Events to locate, as for `solve_ivp`. A terminal one ends the orbit in which it occurs.
    parameters : dict, optional
        Values of parameters, by parameter or name: one, or one for each orbit.
    reduce : function, optional
        It receives the `Solution` of each orbit, with `forces`, in the order of the starts, and
        returns a number or an array. These are kept, and orbits, transitions and events are not: the memory does not
        grow with their length.
    workers : int, optional
        Number of threads; -1 for all cores. The result does not depend on it.
    progress : bool, optional
        Whether to show the number of finished orbits.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    Ensemble

    Raises
    ------
    SystemError
        If a parameter value is not allowed, before any orbit is followed; it names the orbit.
    ValueError
        If starts and parameters are not for the same number of orbits.
    Interrupted
        On Ctrl-C; `partial` has the finished orbits, and the others with status -1.

    Warns
    -----
    SolverWarning
        Once, if orbits fail.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, v = ss.states("x v")
    >>> k, = ss.parameters(k=1.0)
    >>> spring = ss.System({x: v, v: -k * x})
    >>> found = ss.ensemble(spring, [[1.0, 0.0], [2.0, 0.0]], (0, np.pi))
    >>> found.y.shape, found.y[0, :, 0].round(9)
    ((2, 2, 1), array([-1., -2.]))
    >>> found = ss.ensemble(spring, [1.0, 0.0], (0, 10), events=v, parameters={k: [1, 4]})
    >>> [len(times) for times in found.t_events[0]]
    [3, 6]
    """
    t0, t_end = pair(t_span, "t_span", "the orbits go forwards")
    made = settings(options)
    rows = None if starts is None else rows_of_starts(system, starts)[0]
    names, values = _values(checked(system), parameters, None if rows is None else len(rows))
    # Before any orbit is followed, since a refusal keeps none.
    system._core.check_values(names, values)
    each = [dict(zip(names, row)) for row in values.tolist()]
    if rows is None:
        rows = np.array([_start(system, own) for own in each])
    count = max(len(rows), len(each))
    rows = np.ascontiguousarray(np.broadcast_to(rows, (count, rows.shape[1])))
    values = np.ascontiguousarray(np.broadcast_to(values, (count, len(names))))
    each = each * count if len(each) == 1 else each
    times = _times(t_eval, t0, t_end)
    given = [] if events is None else events if isinstance(events, (list, tuple)) else [events]
    watched = [one if isinstance(one, Event) else event(one) for one in given]
    core = system._with_sections((one.function, one.direction) for one in watched)
    wanted = None if reduce is not None and t_eval is None else times

    waves: list[dict[str, Any]] = []
    reduced: list[Any] = []
    raised = None
    with progress_report(progress, "ensemble", "orbits", total=count) as report:
        for first in range(0, count, AT_ONCE):
            part = slice(first, min(first + AT_ONCE, count))
            done = None if report is None else lambda at, first=first: report(first + at)
            found = call_engine(
                _core.ensemble,
                core,
                rows[part],
                (names, values[part]),
                (t0, t_end),
                [one.terminal for one in watched],
                wanted,
                (threads(workers), reduce is not None),
                made,
                done,
            )
            raised = found.pop("raised", None)
            if reduce is not None:
                solutions = _solutions(found, events is not None, system, each[part])
                reduced += [] if raised else [reduce(one) for one in solutions]
                for name in ("t", "y", "transitions", "phases", "events"):
                    del found[name]
                found.pop("forces", None)
            waves.append(found)
            if raised is not None:
                break
    done_rows = min(count, AT_ONCE * len(waves))

    def together(name: str) -> Any:
        return np.concatenate([one[name] for one in waves])

    def where(k: int) -> str:
        return f"orbit {k}, from {rows[k].tolist()}"

    message = [one for wave in waves for one in wave["message"]]
    result: dict[str, Any] = {
        "y": None,
        "t_events": None,
        "y_events": None,
        "transitions": None,
        "phases": None,
        "raised": raised,
    }
    if reduce is None:
        result["y"] = np.full((rows.shape[1], done_rows, len(times)), np.nan)
        _fill(result, waves, system, events is not None)
    failures = [one if status < 0 else "" for one, status in zip(message, together("status"))]
    if raised is None:
        warn_of_failures(failures, where)
    doubts = [one for wave in waves for one in wave["doubtful"]]
    warn_of_doubts(doubts, where)
    return make_result(
        result,
        Ensemble,
        t=times,
        y0=rows[:done_rows].T,
        parameters={name: values[:done_rows, k] for k, name in enumerate(names)},
        t_end=together("t_end"),
        y_end=together("y_end").T,
        status=together("status"),
        message=message,
        nfev=together("nfev"),
        reduced=_array(reduced) if reduce is not None else None,
        system=system,
    )


def _fill(
    result: dict[str, Any], waves: list[dict[str, Any]], system: System, several: bool
) -> None:
    """Fills in what is kept of orbits that are not reduced."""
    first = 0
    tables: dict[str, list[Table]] = {"transitions": [], "phases": []}
    result["t_events"] = [[] for _ in waves[0]["events"]] if several else None
    result["y_events"] = [[] for _ in waves[0]["events"]] if several else None
    for wave in waves:
        for k, states in enumerate(_split(wave["y"], wave["points"]), first):
            result["y"][:, k, : len(states)] = states.T
        for table, counts in (("transitions", "transition_counts"), ("phases", "phase_counts")):
            tables[table].append(_table(wave[table], wave[counts], first, system))
        for number, one in enumerate(wave["events"] if several else ()):
            result["t_events"][number] += _split(one["t"], one["counts"])
            result["y_events"][number] += _split(one["y"], one["counts"])
        first += len(wave["status"])
    for table, parts in tables.items():
        result[table] = _joined(parts)


def _array(values: list[Any]) -> NDArray[Any]:
    """Values of one shape as an array with the orbits first; others as an array of objects."""
    arrays = [np.asarray(one) for one in values]
    if len({one.shape for one in arrays}) <= 1:
        return np.array(arrays)
    found = np.empty(len(values), dtype=object)
    for k, one in enumerate(values):
        found[k] = one
    return found
