"""Attractors along a parameter, over a plane of two parameters, and from many starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._arguments import (
    Floats,
    Options,
    checked,
    name_of,
    real,
    settings,
    nonempty_array,
    rows_of_starts,
    start_of_each,
    threads,
)
from ._basins import BasinEntropy, UncertaintyExponent, entropy, exponent, first_points
from ._plot import draw_classes, new_axes
from ._progress import progress_report
from ._results import (
    Result,
    call_engine,
    column,
    make_result,
    states_of,
    structured,
    warn_of_failures,
)
from ._symbols import Parameter, State, number, out_of_bounds
from ._system import System
from ._tables import Table, pandas


@dataclass(frozen=True, repr=False, eq=False)
class BifurcationDiagram(Result):
    """The attractor at each value of a parameter.

    Attributes
    ----------
    parameter : ndarray, shape (m,)
        The values, in the order of the computation.
    kind : list of str
        The kind of motion: ``"periodic"``, ``"equilibrium"``, ``"recurrent"`` (quasi-periodic or
        chaotic), ``"escape"``, …
    period : ndarray, shape (m,)
        Period of a periodic attractor, else NaN.
    returns : ndarray of int, shape (m,)
        Number of section points in a period, else 0.
    phases : list of str
        Phases of a period in letters. The text does not depend on the phase at which it begins.
    in_stick : ndarray, shape (m,)
        Fraction of time in which a contact sticks; NaN if there is no attractor.
    points : list of ndarray, shape (k, n)
        Points of the section: transitions, states at each period of the drive, or turning points.
    exponent, std_error, uncertainty : ndarray, shape (m,)
        Largest Lyapunov exponent, its standard error and its uncertainty. The uncertainty is four
        standard errors, or ln 30 divided by the measured time if that is larger. NaN without a
        measurement.
    reason : list of str
        Why the run failed or its exponent could not be measured; else empty.
    changes : Table
        Changes of the attractor: ``name``, ``parameter`` (NaN if not located), ``uncertainty``,
        ``contacts`` at which the phases change, ``from_value`` and ``to_value`` (the values of the
        diagram on both sides), ``period``,
        ``criticality`` of a flip or torus, phases ``before`` and ``after``, and a state ``y``.
    sticks : Table
        Phases of the periodic attractors in which a contact sticks: the value of the ``parameter``,
        the ``duration``, and the ``length``, the change of each state.
    name : str
        The parameter.
    system : System
        The system.
    """

    parameter: Floats
    kind: list[str]
    period: Floats
    returns: NDArray[np.int64]
    phases: list[str]
    in_stick: Floats
    points: list[Floats]
    exponent: Floats
    std_error: Floats
    uncertainty: Floats
    reason: list[str]
    changes: Table
    sticks: Table
    name: str
    system: System

    def _columns(self) -> dict[str, Any]:
        return {
            self.name: self.parameter,
            "kind": self.kind,
            "period": self.period,
            "returns": self.returns,
            "phases": self.phases,
            "in_stick": self.in_stick,
            "exponent": self.exponent,
            "std_error": self.std_error,
            "uncertainty": self.uncertainty,
            "reason": self.reason,
        }

    def to_pandas(self, points: bool = False) -> Any:
        """The diagram as a `pandas.DataFrame`, with a row for each value of the parameter.

        Parameters
        ----------
        points : bool, optional
            Whether there is a row for each point of the section instead, with its state.

        Returns
        -------
        pandas.DataFrame
        """
        if not points:
            return super().to_pandas()
        values, rows = self._points()
        return pandas().DataFrame({self.name: values, **states_of(self.system, rows)})

    def _points(self) -> tuple[Floats, Floats]:
        """Values of the parameter and states of all points of the section."""
        values = np.repeat(self.parameter, [len(points) for points in self.points])
        return values, np.concatenate([*self.points, np.empty((0, len(self.system.states)))])

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        columns = self._columns()
        coordinates = {self.name: columns.pop(self.name), "state": list(self.system.states)}
        variables: dict[str, Any] = {name: (self.name, one) for name, one in columns.items()}
        values, rows = self._points()
        variables["y"] = (("point", "state"), rows)
        variables[f"{self.name}_of_point"] = ("point", values)
        return variables, coordinates

    def plot(self, axes: Any = None, state: int | str | State = 0) -> Any:
        """Draws a state at the section points, and lines where the attractor changes.

        Parameters
        ----------
        state : int, str or State, optional
            The state, by number or name.
        """
        axes = new_axes(axes)
        k, label = column(self.system, state)
        counts = [len(points) for points in self.points]
        values = np.concatenate([*(points[:, k] for points in self.points), []])
        axes.plot(np.repeat(self.parameter, counts), values, ".", ms=2)
        for change in self.changes:
            if np.isfinite(change["parameter"]):
                axes.axvline(change["parameter"], color="0.7", lw=0.8, zorder=0)
        axes.set(xlabel=self.name, ylabel=label)
        return axes


@dataclass(frozen=True, repr=False, eq=False)
class Basins(Result):
    """The attractor that each start leads to.

    Attributes
    ----------
    starts : ndarray, shape (…, n)
        The starts.
    reached : ndarray of int, shape (…)
        Index of each start's attractor in the lists; -1 if Ctrl-C came before its computation.
    kind, period, returns, phases, in_stick, points, reason
        Of each attractor, as in `BifurcationDiagram`. All escapes are one entry, and so are all
        failures, with the reason of the first.
    system : System
        The system.
    return_time : ndarray, shape (…), or None
        Time after which the orbit from each start stays within ``return_within`` of its attractor;
        NaN where it does not, or the attractor is neither an equilibrium nor periodic. None if it
        was not asked for.
    """

    starts: Floats
    reached: NDArray[np.int64]
    kind: list[str]
    period: Floats
    returns: NDArray[np.int64]
    phases: list[str]
    in_stick: Floats
    points: list[Floats]
    reason: list[str]
    system: System
    return_time: Floats | None = None

    @property
    def shares(self) -> Floats:
        """Fraction of the starts that lead to each attractor."""
        counts = self._counts()
        shares: Floats = counts / max(1, counts.sum())
        return shares

    def _counts(self) -> NDArray[np.int64]:
        """Number of the starts that lead to each attractor."""
        return np.bincount(self.reached[self.reached >= 0], minlength=len(self.kind))

    @property
    def std_errors(self) -> Floats:
        """Standard error of each share, as the program's ``basin`` computes it.

        Of an even grid over two states, only cells at the boundaries of basins are uncertain. Other
        starts count as independent and random.
        """
        done = self.reached.ravel()
        columns = self.reached.shape[1] if self._is_grid() else None
        if (done < 0).any():
            done, columns = done[done >= 0], None
        if not len(done):
            return np.full(len(self.kind), np.nan)
        reached = done.tolist()
        return np.array([_core.share_error(reached, columns, k) for k in range(len(self.kind))])

    def entropy(self, side: int) -> BasinEntropy:
        """Basin entropy, in boxes of so many starts along each axis of the array of starts.

        In a box of which the part p_j leads to attractor j, the entropy is −Σ p_j ln p_j. Sb is its
        mean over all boxes, Sbb that over boxes on boundaries (Daza, Wagemakers, Georgeot,
        Guéry-Odelin & Sanjuán, Scientific Reports 6 (2016) 31416).

        Parameters
        ----------
        side : int
            Number of starts, 2 at least, that divides each axis into 2 boxes or more.

        Returns
        -------
        BasinEntropy

        Raises
        ------
        OptionError
            If the boxes do not fit.
        """
        return entropy(self.reached, side)

    def uncertainty_exponent(self) -> UncertaintyExponent:
        """Uncertainty exponent and dimension of the boundaries, of starts on an even grid.

        Starts at a distance ε along an axis lead to different attractors with the frequency
        f ~ ε^α, and the boundary has the dimension D − α (Grebogi, McDonald, Ott & Yorke, Physics
        Letters A 99 (1983) 415). It needs 64 starts along each axis.

        Returns
        -------
        UncertaintyExponent

        Raises
        ------
        OptionError
            If there are fewer starts.
        """
        return exponent(self.reached)

    def _is_grid(self) -> bool:
        """Whether the starts are an even grid over two states, along the axes of the array."""
        if self.reached.ndim != 2 or min(self.reached.shape) < 2:
            return False
        starts = self.starts
        steps = [starts[1, 0] - starts[0, 0], starts[0, 1] - starts[0, 0]]
        down, right = (np.arange(count)[:, None] for count in self.reached.shape)
        even = starts[0, 0] + (down * steps[0])[:, None] + (right * steps[1])[None]
        size = np.abs(starts).max(axis=(0, 1)) + np.abs(steps).max(axis=0)
        varied = [np.flatnonzero(step) for step in steps]
        apart = [len(one) == 1 for one in varied] == [True, True] and varied[0] != varied[1]
        return bool(apart) and bool((np.abs(starts - even) <= 1e-9 * size).all())

    @property
    def attractors(self) -> Table:
        """A table of the attractors: ``kind``, ``phases``, ``period``, ``returns``, ``in_stick``,
        number of ``starts``, ``share`` and its ``std_error``, ``reason`` of failures, and a state
        ``y``, NaN without one. With return times also ``mean_return``, its standard error
        ``mean_return_error`` and ``largest_return``; NaN where no start returns."""
        columns = {
            "kind": list(self.kind),
            "phases": list(self.phases),
            "period": self.period,
            "returns": self.returns,
            "in_stick": self.in_stick,
            "starts": self._counts(),
            "share": self.shares,
            "std_error": self.std_errors,
            "reason": list(self.reason),
            "y": first_points(self.points, len(self.system.states)),
        }
        if self.return_time is not None:
            each = [self.return_time[self.reached == k] for k in range(len(self.kind))]
            each = [times[np.isfinite(times)] for times in each]
            mean = [times.mean() if len(times) else np.nan for times in each]
            error = [
                times.std(ddof=1) / np.sqrt(len(times)) if len(times) > 1 else np.nan
                for times in each
            ]
            columns["mean_return"] = np.array(mean)
            columns["mean_return_error"] = np.array(error)
            columns["largest_return"] = np.array([times.max(initial=-np.inf) for times in each])
            columns["largest_return"][np.isneginf(columns["largest_return"])] = np.nan
        return structured(columns, self.system.states)

    def _columns(self) -> dict[str, Any]:
        reached = self.reached.ravel()
        kinds = np.array([*self.kind, ""])
        phases = np.array([*self.phases, ""])
        rows = self.starts.reshape(-1, self.starts.shape[-1])
        times = {} if self.return_time is None else {"return_time": self.return_time.ravel()}
        return {
            **states_of(self.system, rows),
            "reached": reached,
            "kind": kinds[reached],
            "phases": phases[reached],
            **times,
        }

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        names = self.system.states
        table = self.attractors
        columns = [name for name in table.dtype.names or () if not name.startswith("y.")]
        variables: dict[str, Any] = {name: ("attractor", table[name]) for name in columns}
        variables["y"] = (("attractor", "state"), table["y"])
        if self._is_grid():
            axes = [names[int(np.ptp(self.starts, axis=k).max(axis=0).argmax())] for k in (0, 1)]
            first, second = (names.index(name) for name in axes)
            along = [self.starts[:, 0, first], self.starts[0, :, second]]
            variables |= self._of_starts(tuple(axes), self.reached.shape)
            return variables, {**dict(zip(axes, along)), "state": list(names)}
        rows = self.starts.reshape(-1, self.starts.shape[-1])
        variables |= self._of_starts(("start",), (len(rows),))
        own = {name: ("start", rows[:, k]) for k, name in enumerate(names)}
        return variables, {**own, "state": list(names)}

    def _of_starts(self, axes: tuple[str, ...], shape: tuple[int, ...]) -> dict[str, Any]:
        """The variables that each start has, along these axes."""
        found: dict[str, Any] = {"reached": (axes, self.reached.reshape(shape))}
        if self.return_time is not None:
            found["return_time"] = (axes, self.return_time.reshape(shape))
        return found

    def plot(self, axes: Any = None) -> Any:
        """Draws the basins over the two states that vary among the starts, and the attractors."""
        axes = new_axes(axes)
        states = list(self.system.states)
        rows = self.starts.reshape(-1, self.starts.shape[-1])
        varied = [k for k in range(rows.shape[1]) if np.ptp(rows[:, k]) > 0]
        first, *others = [*varied, *(k for k in range(rows.shape[1]) if k not in varied)]
        x = self.starts[..., first]
        y = self.starts[..., others[0]] if others else self.reached
        names = [
            f"{kind} {phases}: {share:.1%}".replace(" :", ":")
            for kind, phases, share in zip(self.kind, self.phases, self.shares)
        ]
        is_grid = self.reached.ndim == 2 and len(others) > 0
        points = np.concatenate([*self.points, np.empty((0, rows.shape[1]))])
        of = np.repeat(np.arange(len(self.points)), [len(one) for one in self.points])
        heights = points[:, others[0]] if others else of
        dots = axes.plot(
            points[:, first], heights, "k.", ms=7, mec="w", mew=0.5, label="on the attractors"
        )
        cells = self.reached if is_grid else self.reached.ravel()
        draw_classes(axes, x, y, cells, names, dots if len(points) else ())
        axes.set(xlabel=states[first], ylabel=states[others[0]] if others else "attractor")
        return axes


@dataclass(frozen=True, repr=False, eq=False)
class ParameterMap(Result):
    """The attractor of the orbit from a start, over a plane of two parameters.

    Attributes
    ----------
    x, y : ndarray, shapes (m,) and (k,)
        Values of the two parameters.
    kind : ndarray of str, shape (k, m)
        The kind of motion in each cell, as in `BifurcationDiagram`; empty for cells that Ctrl-C
        left out.
    period : ndarray, shape (k, m)
        Period of a periodic attractor, else NaN.
    returns : ndarray of int, shape (k, m)
        Number of section points in a period, else 0.
    phases : ndarray of str, shape (k, m)
        Phases in letters.
    in_stick : ndarray, shape (k, m)
        Fraction of time in stick; NaN if there is no attractor.
    exponent, std_error, uncertainty : ndarray, shape (k, m)
        Largest Lyapunov exponent, its standard error and its uncertainty, as in
        `BifurcationDiagram`.
    reason : ndarray of str, shape (k, m)
        Why the run of each cell failed or its exponent could not be measured; else empty.
    names : (str, str)
        The parameters.
    """

    x: Floats
    y: Floats
    kind: NDArray[np.str_]
    period: Floats
    returns: NDArray[np.int64]
    phases: NDArray[np.str_]
    in_stick: Floats
    exponent: Floats
    std_error: Floats
    uncertainty: Floats
    reason: NDArray[np.str_]
    names: tuple[str, str]

    def _cells(self) -> dict[str, Any]:
        names = ("kind", "period", "returns", "phases", "in_stick")
        measured = ("exponent", "std_error", "uncertainty", "reason")
        return {name: getattr(self, name) for name in (*names, *measured)}

    def _columns(self) -> dict[str, Any]:
        x, y = np.meshgrid(self.x, self.y)
        cells = {name: values.ravel() for name, values in self._cells().items()}
        return {self.names[0]: x.ravel(), self.names[1]: y.ravel(), **cells}

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        dimensions = self.names[::-1]
        variables = {name: (dimensions, values) for name, values in self._cells().items()}
        return variables, dict(zip(self.names, (self.x, self.y)))

    def plot(self, axes: Any = None, what: str = "kind") -> Any:
        """Draws the plane by kinds of motion with their phases, or by a number.

        Parameters
        ----------
        what : {"kind", "exponent", "in_stick", "period", "returns"}, optional
            The quantity that colours show.
        """
        axes = new_axes(axes)
        if what == "kind":
            names = np.char.strip(np.char.add(np.char.add(self.kind, " "), self.phases))
            # The most frequent motions have colours.
            found, numbers, counts = np.unique(names, return_inverse=True, return_counts=True)
            order = np.argsort(-counts, kind="stable")
            rank = np.empty_like(order)
            rank[order] = np.arange(len(order))
            cells = rank[numbers].reshape(names.shape)
            draw_classes(axes, self.x, self.y, cells, list(found[order]))
        elif what in ("exponent", "in_stick", "period", "returns"):
            values = np.ma.masked_invalid(getattr(self, what))
            drawn = axes.pcolormesh(self.x, self.y, values, shading="nearest")
            axes.figure.colorbar(drawn, ax=axes, label=what)
        else:
            raise ValueError(
                f"what = {what!r}: it is kind, exponent, in_stick, period or returns"
            )
        axes.set(xlabel=self.names[0], ylabel=self.names[1])
        return axes


def bifurcation_diagram(
    system: System,
    parameter: str | Parameter,
    values: ArrayLike,
    y0: ArrayLike | Mapping[State, float] | None = None,
    *,
    longest: float = 2000.0,
    duration: float | None = None,
    locate: Literal["all", "periodic", "none"] | bool = "periodic",
    progress: bool = False,
    **options: Unpack[Options],
) -> BifurcationDiagram:
    """Follows an attractor through values of a parameter. Each run starts at t = 0.

    The orbit at each value starts from the last state at the value before. Hysteresis shows as a
    difference between rising and falling values. The program's ``bifurcation`` does both.

    Parameters
    ----------
    system : System
        The system.
    parameter : str or Parameter
        The parameter.
    values : array_like, shape (m,)
        Values of the parameter, in the order of the computation.
    y0 : array_like, shape (n,), or dict, optional
        Start state, in order or as ``{x: 1, v: 0}``. Default: the start of the system.
        Discrete states may be left out.
    longest : float, optional
        Time after which an orbit without an attractor is undecided.
    duration : float, optional
        Time over which the largest Lyapunov exponent is measured. Default: no measurement.
    locate : {"periodic", "all", "none"}, optional
        Which changes of the attractor are located and named. "periodic": those of orbits of few
        loops, in about as many integration steps as the attractors take, and 1 000 000 more; what
        is left out is named "not followed". "all": each, however long it takes. True is "periodic",
        False "none".
    progress : bool, optional
        Whether to show the number of finished values.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    BifurcationDiagram

    Raises
    ------
    SystemError
        If a parameter value is not allowed, or the period of a drive is unknown.
    Interrupted
        On Ctrl-C; `partial` is the diagram so far.

    Examples
    --------
    >>> import stickslip as ss
    >>> x = ss.states("x")
    >>> p = ss.parameter("p", 1.0)
    >>> found = ss.bifurcation_diagram(ss.System({x: p * x - x**3}), p, [1, 4], [0.5])
    >>> found.kind, [float(points[0, 0].round(6)) for points in found.points]
    (['equilibrium', 'equilibrium'], [1.0, 2.0])
    """
    name = name_of(parameter)
    given = nonempty_array(values, "values", f"np.linspace(0.1, 0.5, 50) for {name}")
    begin = start_of_each(checked(system), y0)
    which = {True: "periodic", False: "none"}.get(locate, locate)
    if which not in ("all", "periodic", "none"):
        raise ValueError(f"locate = {locate!r}: it is periodic, all or none")
    with progress_report(progress, "bifurcation_diagram", "values", total=len(given)) as report:
        found = call_engine(
            _core.bifurcation_diagram,
            system._core,
            begin,
            (name, given.tolist()),
            (real(longest, "longest"), _duration(duration), which),
            settings(options),
            report,
        )
    warn_of_failures(found["reason"], lambda k: f"{name} = {given[k]:g}")
    for table in ("changes", "sticks"):
        found[table] = structured(found[table], system.states)
    return make_result(found, BifurcationDiagram, name=name, system=system)


def _duration(duration: float | None) -> float | None:
    if duration is not None and not number(duration, "duration") > 0:
        raise out_of_bounds("duration", duration, "positive, or None for no measurement")
    return duration


def basins_of_attraction(
    system: System,
    starts: ArrayLike | Sequence[ArrayLike],
    *,
    longest: float = 2000.0,
    return_within: float | None = None,
    workers: int = -1,
    progress: bool = False,
    **options: Unpack[Options],
) -> Basins:
    """Finds the attractor that each of many starts leads to. Each run starts at t = 0.

    Attractors are found by recurrence and need not be known before.

    Parameters
    ----------
    system : System
        The system.
    starts : array_like, shape (…, n)
        The starts, such as ``np.stack(np.meshgrid(x, v), axis=-1)``. Discrete states, the last of
        the n, may be left out: they start at their own values.
    longest : float, optional
        Time after which an orbit without an attractor is undecided.
    return_within : float, optional
        Distance to the attractor, Euclidean in the units of the states. The result then has the
        time after which each orbit stays so near. With a drive, states are compared at whole
        periods. Default: no such times.
    workers : int, optional
        Number of threads; -1 for all cores. The result does not depend on it.
    progress : bool, optional
        Whether to show the number of finished starts.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    Basins

    Raises
    ------
    ValueError
        If the last axis of `starts` is not the state.
    Interrupted
        On Ctrl-C; `partial` has the finished starts.

    Examples
    --------
    >>> import stickslip as ss
    >>> x = ss.states("x")
    >>> found = ss.basins_of_attraction(ss.System({x: x - x**3}), [[-2.0], [-0.1], [0.1]])
    >>> found.reached, found.shares.round(2)
    (array([0, 0, 1]), array([0.67, 0.33]))
    """
    rows, shape = rows_of_starts(system, starts)
    with progress_report(progress, "basins_of_attraction", "starts", total=len(rows)) as report:
        found = call_engine(
            _core.basins,
            system._core,
            rows,
            (real(longest, "longest"), _distance(return_within), threads(workers)),
            settings(options),
            report,
        )
    reasons = [*found["reason"], ""]
    each = [reasons[k] for k in found["reached"]]
    warn_of_failures(each, lambda k: f"the start {rows[k].tolist()}")
    found["reached"] = found["reached"].reshape(shape)
    if return_within is not None:
        found["return_time"] = found["return_time"].reshape(shape)
    starts = rows.reshape(*shape, rows.shape[1])
    return make_result(found, Basins, starts=starts, system=system)


def _distance(distance: float | None) -> float | None:
    if distance is not None and not number(distance, "return_within") > 0:
        raise out_of_bounds("return_within", distance, "positive, or None for no times")
    return distance


def parameter_map(
    system: System,
    x: tuple[str | Parameter, ArrayLike],
    y: tuple[str | Parameter, ArrayLike],
    y0: ArrayLike | Mapping[State, float] | None = None,
    *,
    longest: float = 2000.0,
    duration: float | None = 500.0,
    workers: int = -1,
    progress: bool = False,
    **options: Unpack[Options],
) -> ParameterMap:
    """Finds the attractor of the orbit from a start, over a plane of two parameters.

    The program's ``map`` computes the same.

    Parameters
    ----------
    system : System
        The system.
    x, y : (str or Parameter, array_like)
        Two parameters and their values, such as ``(mu0, np.linspace(0.1, 0.2, 50))``.
    y0 : array_like, shape (n,), or dict, optional
        Start state. Default: the start of the system with the parameters of each cell. Discrete
        states may be left out.
    longest : float, optional
        Time after which an orbit without an attractor is undecided.
    duration : float or None, optional
        Time over which the largest Lyapunov exponent is measured; None for no measurement.
    workers : int, optional
        Number of threads; -1 for all cores. The result does not depend on it.
    progress : bool, optional
        Whether to show the number of finished cells.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    ParameterMap

    Raises
    ------
    SystemError
        If a parameter value is not allowed, or the period of a drive is unknown.
    Interrupted
        On Ctrl-C; `partial` has the finished cells.

    Examples
    --------
    >>> import stickslip as ss
    >>> x = ss.states("x")
    >>> a, b = ss.parameters(a=1.0, b=1.0)
    >>> found = ss.parameter_map(ss.System({x: a - b * x}), (a, [1, 2]), (b, [-1, 1, 2]), [0])
    >>> found.kind
    array([['escape', 'escape'],
           ['equilibrium', 'equilibrium'],
           ['equilibrium', 'equilibrium']], dtype='<U11')
    >>> found.exponent[1:].round(6)
    array([[-1., -1.],
           [-2., -2.]])
    """
    (first, columns), (second, lines) = _axis(x, "x"), _axis(y, "y")
    if first == second:
        raise ValueError(f"x and y are both {first}: a map has two parameters")
    shape = (len(lines), len(columns))
    begin = start_of_each(checked(system), y0)
    with progress_report(progress, "parameter_map", "cells", total=shape[0] * shape[1]) as report:
        found = call_engine(
            _core.parameter_map,
            system._core,
            begin,
            ((first, columns.tolist()), (second, lines.tolist())),
            (real(longest, "longest"), _duration(duration), threads(workers)),
            settings(options),
            report,
        )
    at = lambda k: f"{first} = {columns[k % shape[1]]:g}, {second} = {lines[k // shape[1]]:g}"
    warn_of_failures(found["reason"], at)
    raised = {"raised": found.pop("raised", None)}
    cells: dict[str, Any] = {name: np.reshape(values, shape) for name, values in found.items()}
    return make_result(raised, ParameterMap, x=columns, y=lines, names=(first, second), **cells)


def _axis(given: Any, name: str) -> tuple[str, Floats]:
    try:
        parameter, values = given
    except (TypeError, ValueError):
        raise TypeError(
            f"{name} must be a parameter and its values, as (mu0, np.linspace(0.1, 0.2, 50))"
        ) from None
    found = name_of(parameter)
    return found, nonempty_array(values, f"{name}[1]", f"np.linspace(0.1, 0.2, 50) for {found}")
