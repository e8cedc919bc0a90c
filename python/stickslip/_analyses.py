"""The analyses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._errors import OptionError
from ._progress import shown
from ._results import (
    Basins,
    BifurcationDiagram,
    Branch,
    DataSpectrum,
    LyapunovSpectrum,
    ParameterMap,
    PeriodicOrbit,
    PoincareMap,
)
from ._run import Event, Floats, Options, array, called, event, kept, settings, state, structured
from ._symbols import Expression, Parameter, number
from ._system import System


def _name(parameter: str | Parameter) -> str:
    return parameter.name if isinstance(parameter, Parameter) else str(parameter)


def _start(system: System, y0: ArrayLike | None) -> list[float] | None:
    # A start that depends on the parameters is that of each system.
    return None if y0 is None else state(system, y0)


def _workers(workers: int) -> int:
    if workers == -1:
        return 0
    if workers < 1:
        raise ValueError(f"workers = {workers}: it is a number of threads, or -1 for all cores")
    return int(workers)


def _search(
    transient: float, period: float | None, longest: float, periods: int | None
) -> tuple[float, float | None, float, int | None]:
    if periods is not None and periods < 1:
        raise ValueError(f"periods = {periods}: an orbit takes one period of the drive at least")
    given = None if period is None else number(period, "period")
    return float(transient), given, float(longest), periods


def periodic_orbit(
    system: System,
    y0: ArrayLike | None = None,
    *,
    t0: float = 0.0,
    period: float | None = None,
    periods: int | None = None,
    transient: float = 200.0,
    longest: float = 100.0,
    **options: Unpack[Options],
) -> PeriodicOrbit:
    """The periodic orbit that the run from a start comes to, refined by shooting.

    Parameters
    ----------
    system : System
        The system.
    y0 : array_like, shape (n,), optional
        State at the start; that of the system unless given.
    t0 : float, optional
        Time at the start.
    period : float, optional
        A period near which that of the orbit is; of a driven system it is taken as it is.
    periods : int, optional
        Periods of the drive in one of the orbit; the fewest after which the run comes back, at most
        16, unless given.
    transient : float, optional
        How long the run is before the search.
    longest : float, optional
        Within what time the orbit comes back, of a system that does not depend on time.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    StickslipError
        If there is none; the message says what the run comes to instead.
    Interrupted
        On Ctrl-C; nothing is kept.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, v = ss.states("x v")
    >>> system = ss.System({x: v, v: (1 - x**2) * v - x})
    >>> orbit = ss.periodic_orbit(system, [1, 0], transient=50)
    >>> round(orbit.period, 6), orbit.stability
    (6.663287, 'stable')
    """
    search = _search(transient, period, longest, periods)
    start = (float(t0), state(system, y0))
    found = called(_core.periodic_orbit, system._core, start, search, settings(options))
    return PeriodicOrbit(system=system, **found)


def poincare_map(
    system: System,
    section: Event | Expression,
    y0: ArrayLike | None = None,
    *,
    returns: int = 100,
    t0: float = 0.0,
    longest: float = 1000.0,
    derivative: bool = False,
    progress: bool = False,
    **options: Unpack[Options],
) -> PoincareMap:
    """The next returns to a section.

    Parameters
    ----------
    system : System
        The system.
    section : Event or Expression
        The section, as ``ss.event(v, direction=1)``.
    y0 : array_like, shape (n,), optional
        State at the start; that of the system unless given.
    returns : int, optional
        How many.
    t0 : float, optional
        Time at the start.
    longest : float, optional
        Within what time each comes.
    derivative : bool, optional
        Whether the derivative of the map is wanted.
    progress : bool, optional
        Whether to show how many there are.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    PoincareMap

    Raises
    ------
    StickslipError
        If the orbit does not return.
    Interrupted
        On Ctrl-C; `partial` has the returns until then.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, v = ss.states("x v")
    >>> found = ss.poincare_map(ss.System({x: v, v: -x}), ss.event(x, 1), [0, 1], returns=2)
    >>> (found.t / (2 * np.pi)).round(12)
    array([1., 2.])
    """
    watched = section if isinstance(section, Event) else event(section)
    if returns < 1:
        raise ValueError(f"returns = {returns}: at least one is needed")
    with shown(progress, "returns", "", total=returns) as report:
        found = called(
            _core.poincare_map,
            system._section(watched.function.text, watched.direction),
            (float(t0), state(system, y0)),
            (int(returns), float(longest), bool(derivative)),
            settings(options),
            report,
        )
    result = PoincareMap(
        t=found["t"],
        y=found["y"],
        mode=found["mode"],
        derivatives=found["derivatives"] if derivative else None,
        system=system,
    )
    return kept(found, result)


def continuation(
    system: System,
    parameter: str | Parameter,
    bounds: tuple[float, float],
    y0: ArrayLike | None = None,
    *,
    t0: float = 0.0,
    period: float | None = None,
    periods: int | None = None,
    transient: float = 200.0,
    longest: float = 100.0,
    step: float = 0.02,
    most_points: int = 1000,
    progress: bool = False,
    **options: Unpack[Options],
) -> Branch:
    """Follows a periodic orbit along a parameter, both ways, stable or not.

    Parameters
    ----------
    system : System
        The system, at a value of the parameter at which `periodic_orbit` finds the orbit.
    parameter : str or Parameter
        The parameter.
    bounds : (float, float)
        The branch ends where the parameter leaves them.
    y0, t0, period, periods, transient, longest
        As for `periodic_orbit`.
    step : float, optional
        Longest step, as a part of the bounds and of the orbit's size.
    most_points : int, optional
        Most orbits in each direction.
    progress : bool, optional
        Whether to show how many orbits there are.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    Branch

    Raises
    ------
    StickslipError
        If there is no periodic orbit to begin with.
    Interrupted
        On Ctrl-C; `partial` is the branch until then.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, y = ss.states("x y")
    >>> s = x * x + y * y
    >>> grows = ss.parameter("p", 0.5) + 2 * s - s * s
    >>> system = ss.System({x: x * grows - y, y: y * grows + x})
    >>> branch = ss.continuation(system, "p", (-1.5, 1), [1, 0], transient=10)
    >>> branch.special["name"], branch.special["parameter"].round(6)
    (array(['fold'], dtype='<U4'), array([-1.]))
    """
    low, high = array(bounds, "bounds").tolist()
    name = _name(parameter)
    value = system.parameters.get(name, low)
    if not low <= value <= high:
        bound = f"in the bounds {low:g} to {high:g} of the branch"
        message = f"{name} = {value:g}: it must be {bound}; set it by with_parameters"
        raise OptionError(message, name, value, bound)
    with shown(progress, "continuation", "orbits") as report:
        found = called(
            _core.continuation,
            system._core,
            (float(t0), state(system, y0)),
            _search(transient, period, longest, periods),
            (name, low, high),
            (float(step), int(most_points)),
            settings(options),
            report,
        )
    raised = {"raised": found.pop("raised", None)}
    names = ("name", "parameter", "uncertainty", "period")
    special = structured({field: found.pop(f"special_{field}") for field in names})
    found["stops"] = tuple(found["stops"])
    return kept(raised, Branch(special=special, name=name, **found))


def lyapunov_spectrum(
    system: System,
    y0: ArrayLike | None = None,
    *,
    t0: float = 0.0,
    transient: float = 200.0,
    duration: float = 2000.0,
    progress: bool = False,
    **options: Unpack[Options],
) -> LyapunovSpectrum:
    """The Lyapunov exponents from the equations, through slip, stick and jumps.

    Parameters
    ----------
    system : System
        The system.
    y0 : array_like, shape (n,), optional
        State at the start; that of the system unless given.
    t0 : float, optional
        Time at the start.
    transient, duration : float, optional
        Time before measuring, and time measured.
    progress : bool, optional
        Whether to show how far the run is.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    LyapunovSpectrum

    Raises
    ------
    StickslipError
        If the run fails, or its future is not unique.
    Interrupted
        On Ctrl-C; nothing is kept.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, v = ss.states("x v")
    >>> spring = ss.System({x: v, v: -x - 0.2 * v})
    >>> ss.lyapunov_spectrum(spring, [1, 0], transient=0, duration=100 * np.pi).exponents.round(3)
    array([-0.1, -0.1])
    """
    span = (float(t0), float(t0) + float(transient) + float(duration))
    with shown(progress, "lyapunov_spectrum", "", span=span) as report:
        found = called(
            _core.lyapunov_spectrum,
            system._core,
            (float(t0), state(system, y0)),
            (float(transient), float(duration)),
            settings(options),
            report,
        )
    return LyapunovSpectrum(**found)


def bifurcation_diagram(
    system: System,
    parameter: str | Parameter,
    values: ArrayLike,
    y0: ArrayLike | None = None,
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
    y0 : array_like, shape (n,), optional
        State at the start; that of the system unless given.
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
    given = array(values, "values")
    with shown(progress, "bifurcation_diagram", "values", total=len(given)) as report:
        found = called(
            _core.bifurcation_diagram,
            system._core,
            _start(system, y0),
            (_name(parameter), given.tolist()),
            (float(longest), None if duration is None else float(duration), bool(locate)),
            settings(options),
            report,
        )
    raised = {"raised": found.pop("raised", None)}
    result = BifurcationDiagram(
        parameter=found.pop("value"),
        changes=structured(found.pop("changes")),
        name=_name(parameter),
        system=system,
        **found,
    )
    return kept(raised, result)


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
        The starts, as ``np.stack(np.meshgrid(x, v), axis=-1)``.
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
    given = np.asarray(starts)
    if given.ndim == 0 or given.shape[-1] != len(system.states):
        raise ValueError(f"the last axis of starts must be the {len(system.states)} states")
    rows = array(given.reshape(-1, given.shape[-1]), "starts", 2)
    with shown(progress, "basins_of_attraction", "starts", total=len(rows)) as report:
        found = called(
            _core.basins,
            system._core,
            rows,
            (float(longest), _workers(workers)),
            settings(options),
            report,
        )
    raised = {"raised": found.pop("raised", None)}
    found["reached"] = found["reached"].reshape(given.shape[:-1])
    result = Basins(starts=rows.reshape(given.shape), system=system, **found)
    return kept(raised, result)


def parameter_map(
    system: System,
    x: tuple[str | Parameter, ArrayLike],
    y: tuple[str | Parameter, ArrayLike],
    y0: ArrayLike | None = None,
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
    y0 : array_like, shape (n,), optional
        State at the start; that of the system, at each cell's parameters, unless given.
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
    names = (_name(x[0]), _name(y[0]))
    if names[0] == names[1]:
        raise ValueError(f"x and y are both {names[0]}: a map has two parameters")
    columns, lines = array(x[1], "x[1]"), array(y[1], "y[1]")
    shape = (len(lines), len(columns))
    with shown(progress, "parameter_map", "cells", total=shape[0] * shape[1]) as report:
        found = called(
            _core.parameter_map,
            system._core,
            _start(system, y0),
            ((names[0], columns.tolist()), (names[1], lines.tolist())),
            (float(longest), None if duration is None else float(duration), _workers(workers)),
            settings(options),
            report,
        )
    raised = {"raised": found.pop("raised", None)}
    cells: dict[str, Any] = {name: np.reshape(values, shape) for name, values in found.items()}
    return kept(raised, ParameterMap(x=columns, y=lines, names=names, **cells))


def lyapunov_from_data(series: ArrayLike, dt: float = 1.0) -> DataSpectrum:
    """The Lyapunov exponents of a measured series.

    Parameters
    ----------
    series : array_like, shape (m,) or (m, d)
        The series: a number or a row for each point.
    dt : float, optional
        Time between two points.

    Returns
    -------
    DataSpectrum

    Raises
    ------
    StickslipError
        If the series is too short or does not move.

    Examples
    --------
    >>> import stickslip as ss
    >>> series = [0.3]
    >>> while len(series) < 4000:
    ...     series.append(4 * series[-1] * (1 - series[-1]))
    >>> float(ss.lyapunov_from_data(series).exponents[0].round(1))
    0.7
    """
    given = np.asarray(series)
    rows: Floats = array(given[:, None] if given.ndim == 1 else given, "series", 2)
    return DataSpectrum(**called(_core.lyapunov_from_data, rows, number(dt, "dt")))
