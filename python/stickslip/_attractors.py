"""Attractors: along a parameter, over a plane of two, and from many starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._arguments import (
    Floats,
    Options,
    array,
    as_array,
    checked,
    complete,
    name_of,
    real,
    settings,
    several,
    start_of_each,
    threads,
)
from ._plot import classes, new_axes
from ._progress import shown
from ._results import Result, called, column, kept, structured, warn_of_failures
from ._symbols import Parameter, State, number, out_of_bounds
from ._system import System


@dataclass(frozen=True, repr=False)
class BifurcationDiagram(Result):
    """The attractor at each value of a parameter.

    Attributes
    ----------
    parameter : ndarray, shape (m,)
        The values, in the order in which they were gone through.
    kind : list of str
        The kind of motion: ``"periodic"``, ``"equilibrium"``, ``"recurrent"`` (quasi-periodic or
        chaotic), ``"escape"``, …
    period : ndarray, shape (m,)
        Period of a periodic one, else NaN.
    returns : ndarray of int, shape (m,)
        Points of the section in a period, else 0.
    phases : list of str
        Phases of a period in letters, the same text wherever the cycle was found to begin.
    in_stick : ndarray, shape (m,)
        Part of the time in which a contact sticks; NaN where there is no attractor.
    points : list of ndarray, shape (k, n)
        Points of the section: transitions, flashes of the drive's strobe, or turning points.
    exponent, std_error, uncertainty : ndarray, shape (m,)
        Largest Lyapunov exponent, its standard error and its uncertainty: four standard errors, and
        at least the effect of a growth factor of 30 over the measured time. NaN where it was not
        measured.
    changes : ndarray, structured
        Where the attractor changes: ``name``, ``parameter`` (NaN where it was not located),
        ``uncertainty``, ``from_value`` and ``to_value`` (the values of the diagram that it lies
        between), ``period``, phases ``before`` and ``after``, a state ``y``.
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
    changes: NDArray[np.void]
    name: str
    system: System

    def plot(self, axes: Any = None, state: int | str | State = 0) -> Any:
        """Draws a state at the points of the section, and lines where the attractor changes.

        Parameters
        ----------
        state : int, str or State, optional
            Which state, by number or name.
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


@dataclass(frozen=True, repr=False)
class Basins(Result):
    """Which attractor each start leads to.

    Attributes
    ----------
    starts : ndarray, shape (…, n)
        The starts.
    reached : ndarray of int, shape (…)
        The number of each start's attractor in the lists; -1 of one that Ctrl-C left out.
    kind, period, returns, phases, in_stick, points
        Of each attractor, as in `BifurcationDiagram`. Escapes are one, and failures are one.
    system : System
        The system.
    """

    starts: Floats
    reached: NDArray[np.int64]
    kind: list[str]
    period: Floats
    returns: NDArray[np.int64]
    phases: list[str]
    in_stick: Floats
    points: list[Floats]
    system: System

    @property
    def shares(self) -> Floats:
        """The part of the starts that each attractor takes."""
        counts = np.bincount(self.reached[self.reached >= 0], minlength=len(self.kind))
        shares: Floats = counts / max(1, counts.sum())
        return shares

    def plot(self, axes: Any = None) -> Any:
        """Draws the basins over the two states that the starts go through, and the attractors."""
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
        classes(axes, x, y, cells, names, dots if len(points) else ())
        axes.set(xlabel=states[first], ylabel=states[others[0]] if others else "attractor")
        return axes


@dataclass(frozen=True, repr=False)
class ParameterMap(Result):
    """What the orbit from a start comes to, over a plane of two parameters.

    Attributes
    ----------
    x, y : ndarray, shapes (m,) and (k,)
        Values of the two parameters.
    kind : ndarray of str, shape (k, m)
        The kind of motion in each cell, as in `BifurcationDiagram`; empty where Ctrl-C left a cell
        out.
    period : ndarray, shape (k, m)
        Period of a periodic one, else NaN.
    returns : ndarray of int, shape (k, m)
        Points of the section in a period, else 0.
    phases : ndarray of str, shape (k, m)
        Its phases in letters.
    in_stick : ndarray, shape (k, m)
        Part of the time in stick; NaN where there is no attractor.
    exponent, std_error, uncertainty : ndarray, shape (k, m)
        Largest Lyapunov exponent, its standard error and its uncertainty, as in
        `BifurcationDiagram`.
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
    names: tuple[str, str]

    def plot(self, axes: Any = None, what: str = "kind") -> Any:
        """Draws the plane by kinds of motion with their phases, or by a number.

        Parameters
        ----------
        what : {"kind", "exponent", "in_stick", "period", "returns"}, optional
            What the colours show.
        """
        axes = new_axes(axes)
        if what == "kind":
            names = np.char.strip(np.char.add(np.char.add(self.kind, " "), self.phases))
            # The most frequent ones have colours.
            found, numbers, counts = np.unique(names, return_inverse=True, return_counts=True)
            order = np.argsort(-counts, kind="stable")
            rank = np.empty_like(order)
            rank[order] = np.arange(len(order))
            classes(axes, self.x, self.y, rank[numbers].reshape(names.shape), list(found[order]))
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
    locate: bool = True,
    progress: bool = False,
    **options: Unpack[Options],
) -> BifurcationDiagram:
    """Follows an attractor through values of a parameter, from t = 0 on at each.

    The orbit at a value begins where that at the value before ended. Values up and values down show
    hysteresis where they differ. It is what the program's ``bifurcation`` does in one direction.

    Parameters
    ----------
    system : System
        The system.
    parameter : str or Parameter
        The parameter.
    values : array_like, shape (m,)
        Its values, in the order in which they are gone through.
    y0 : array_like, shape (n,), or dict, optional
        State at the start, in order or as ``{x: 1, v: 0}``; that of the system unless given.
        Discrete states may be left out.
    longest : float, optional
        Time after which an orbit is called undecided.
    duration : float, optional
        Time over which the largest Lyapunov exponent is measured; it is not, unless given.
    locate : bool, optional
        Whether changes of the attractor are located and named.
    progress : bool, optional
        Whether to show how many values there are.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    BifurcationDiagram

    Raises
    ------
    SystemError
        If a parameter is not allowed, or the period of a drive is not known.
    Interrupted
        On Ctrl-C; `partial` is the diagram until then.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, = ss.states("x")
    >>> p = ss.parameter("p", 1.0)
    >>> found = ss.bifurcation_diagram(ss.System({x: p * x - x**3}), p, [1, 4], [0.5])
    >>> found.kind, [float(points[0, 0].round(6)) for points in found.points]
    (['equilibrium', 'equilibrium'], [1.0, 2.0])
    """
    name = name_of(parameter)
    given = several(values, "values", f"np.linspace(0.1, 0.5, 50) for {name}")
    begin = start_of_each(checked(system), y0)
    with shown(progress, "bifurcation_diagram", "values", total=len(given)) as report:
        found = called(
            _core.bifurcation_diagram,
            system._core,
            begin,
            (name, given.tolist()),
            (real(longest, "longest"), _duration(duration), bool(locate)),
            settings(options),
            report,
        )
    warn_of_failures(found.pop("reason"), lambda k: f"{name} = {given[k]:g}")
    found["changes"] = structured(found["changes"])
    return kept(found, BifurcationDiagram, name=name, system=system)


def _duration(duration: float | None) -> float | None:
    if duration is not None and not number(duration, "duration") > 0:
        raise out_of_bounds("duration", duration, "positive, or None for no measurement")
    return duration


def basins_of_attraction(
    system: System,
    starts: ArrayLike | Sequence[ArrayLike],
    *,
    longest: float = 2000.0,
    workers: int = -1,
    progress: bool = False,
    **options: Unpack[Options],
) -> Basins:
    """Which attractor each of many starts leads to, from t = 0 on.

    Attractors are found by recurrence; none need be named.

    Parameters
    ----------
    system : System
        The system.
    starts : array_like, shape (…, n)
        The starts, as ``np.stack(np.meshgrid(x, v), axis=-1)``. Discrete states, the last of the
        n, may be left out: they start as the system says.
    longest : float, optional
        Time after which an orbit is called undecided.
    workers : int, optional
        Number of threads; -1 for all cores. The result does not depend on it.
    progress : bool, optional
        Whether to show how many starts are done.
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
        On Ctrl-C; `partial` has the starts that were done.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, = ss.states("x")
    >>> found = ss.basins_of_attraction(ss.System({x: x - x**3}), [[-2.0], [-0.1], [0.1]])
    >>> found.reached, found.shares.round(2)
    (array([0, 0, 1]), array([0.67, 0.33]))
    """
    names = checked(system).states
    if _is_meshgrid(starts):
        raise ValueError("starts is a meshgrid: stack it, np.stack(np.meshgrid(x, v), axis=-1)")
    given = as_array(starts, "starts")
    discrete = len(system.discrete)
    if given.ndim == 0 or given.shape[-1] not in (len(names), len(names) - discrete):
        help = f"; the last {discrete}, discrete, may be left out" if discrete else ""
        raise ValueError(
            f"the last axis of starts must be the {len(names)} states: {', '.join(names)}{help}; "
            f"the shape is {given.shape}; a grid is np.stack(np.meshgrid(x, v), axis=-1)"
        )
    if not given.size:
        raise ValueError("starts is empty: give at least one state")
    rows = complete(system, array(given.reshape(-1, given.shape[-1]), "starts", 2), "starts")
    with shown(progress, "basins_of_attraction", "starts", total=len(rows)) as report:
        found = called(
            _core.basins,
            system._core,
            rows,
            (real(longest, "longest"), threads(workers)),
            settings(options),
            report,
        )
    reasons = [*found.pop("reason"), ""]
    each = [reasons[k] for k in found["reached"]]
    warn_of_failures(each, lambda k: f"the start {rows[k].tolist()}")
    found["reached"] = found["reached"].reshape(given.shape[:-1])
    starts = rows.reshape(*given.shape[:-1], len(names))
    return kept(found, Basins, starts=starts, system=system)


def _is_meshgrid(starts: Any) -> bool:
    """Whether np.meshgrid returns it for two axes. Its last axis may be as long as states."""
    if not isinstance(starts, (list, tuple)) or len(starts) != 2:
        return False
    a, b = starts
    is_plane = all(isinstance(one, np.ndarray) and one.ndim == 2 for one in starts)
    return is_plane and a.shape == b.shape and bool((a == a[:1]).all() and (b == b[:, :1]).all())


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
    """What the orbit from a start comes to, over a plane of two parameters.

    It is what the program's ``map`` computes.

    Parameters
    ----------
    system : System
        The system.
    x, y : (str or Parameter, array_like)
        Two parameters and their values, as ``(mu0, np.linspace(0.1, 0.2, 50))``.
    y0 : array_like, shape (n,), or dict, optional
        State at the start; that of the system, at each cell's parameters, unless given. Discrete
        states may be left out.
    longest : float, optional
        Time after which an orbit is called undecided.
    duration : float or None, optional
        Time over which the largest Lyapunov exponent is measured; None leaves it out.
    workers : int, optional
        Number of threads; -1 for all cores. The result does not depend on it.
    progress : bool, optional
        Whether to show how many cells are done.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    ParameterMap

    Raises
    ------
    SystemError
        If a parameter is not allowed, or the period of a drive is not known.
    Interrupted
        On Ctrl-C; `partial` has the cells that were done.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, = ss.states("x")
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
    with shown(progress, "parameter_map", "cells", total=shape[0] * shape[1]) as report:
        found = called(
            _core.parameter_map,
            system._core,
            begin,
            ((first, columns.tolist()), (second, lines.tolist())),
            (real(longest, "longest"), _duration(duration), threads(workers)),
            settings(options),
            report,
        )
    at = lambda k: f"{first} = {columns[k % shape[1]]:g}, {second} = {lines[k // shape[1]]:g}"
    warn_of_failures(found.pop("reason"), at)
    raised = {"raised": found.pop("raised", None)}
    cells: dict[str, Any] = {name: np.reshape(values, shape) for name, values in found.items()}
    return kept(raised, ParameterMap, x=columns, y=lines, names=(first, second), **cells)


def _axis(given: Any, name: str) -> tuple[str, Floats]:
    try:
        parameter, values = given
    except (TypeError, ValueError):
        raise TypeError(
            f"{name} must be a parameter and its values, as (mu0, np.linspace(0.1, 0.2, 50))"
        ) from None
    found = name_of(parameter)
    return found, several(values, f"{name}[1]", f"np.linspace(0.1, 0.2, 50) for {found}")
