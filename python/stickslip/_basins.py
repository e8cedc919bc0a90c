"""Basins in numbers: boundaries, pushes out of basins, edge states, shares along a parameter."""

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
    checked,
    complete,
    name_of,
    nonempty_array,
    real,
    rows_of_starts,
    settings,
    state as state_of,
    threads,
)
from ._plot import colours_of, new_axes
from ._progress import progress_report
from ._results import (
    Result,
    call_engine,
    column,
    make_result,
    states_of,
    warn_of_failures,
)
from ._symbols import Parameter, State, number, out_of_bounds
from ._system import System


@dataclass(frozen=True, repr=False, eq=False)
class BasinEntropy(Result):
    """Basin entropy of a grid of starts, in boxes of one size.

    Attributes
    ----------
    sb, sb_std_error : float
        Mean entropy of all boxes and its standard error, by the place of the boxes.
    sbb, sbb_std_error : float
        The same of the boxes from which starts lead to two attractors or more; NaN without any.
    boxes, boundary_boxes : int
        Numbers of all boxes and of those on boundaries.
    shows_fractal : bool
        Whether ``sbb`` is above ln 2 by more than two standard errors: the boundary is then
        fractal at this scale. The converse does not hold.
    """

    sb: float
    sb_std_error: float
    sbb: float
    sbb_std_error: float
    boxes: int
    boundary_boxes: int
    shows_fractal: bool

    def _columns(self) -> dict[str, Any]:
        return {name: [getattr(self, name)] for name in self.keys()}

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        return {name: ((), getattr(self, name)) for name in self.keys()}, {}

    def plot(self, axes: Any = None) -> Any:
        """Draws both entropies with their standard errors, and ln 2, above which the boundary is
        fractal."""
        axes = new_axes(axes)
        labels = [f"all {self.boxes}", f"{self.boundary_boxes} on boundaries"]
        errors = [self.sb_std_error, self.sbb_std_error]
        axes.bar(labels, [self.sb, self.sbb], yerr=errors, capsize=4, width=0.5)
        axes.axhline(np.log(2), color="0.5", ls="--", label="ln 2")
        axes.set(xlabel="boxes", ylabel="basin entropy")
        axes.legend()
        return axes


@dataclass(frozen=True, repr=False, eq=False)
class UncertaintyExponent(Result):
    """Uncertainty exponent and dimension of the boundaries of basins; NaN without a boundary.

    Attributes
    ----------
    exponent : float
        The exponent α of f ~ ε^α.
    dimension : float
        Dimension of the boundary: that of the grid less α.
    std_error : float
        Standard error of both.
    steps : ndarray of int, shape (m,)
        Distances ε, in steps of the grid.
    uncertain : ndarray, shape (m,)
        Fraction f of the pairs of starts at that distance that lead to different attractors.
    """

    exponent: float
    dimension: float
    std_error: float
    steps: NDArray[np.int64]
    uncertain: Floats

    def _columns(self) -> dict[str, Any]:
        return {"steps": self.steps, "uncertain": self.uncertain}

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        names = ("exponent", "dimension", "std_error")
        numbers = {name: ((), getattr(self, name)) for name in names}
        return {"uncertain": ("steps", self.uncertain), **numbers}, {"steps": self.steps}

    def plot(self, axes: Any = None) -> Any:
        """Draws the fractions over the distances, and the power law."""
        axes = new_axes(axes)
        axes.loglog(self.steps, self.uncertain, "o")
        if len(self.steps):
            logs = np.log(self.uncertain) - self.exponent * np.log(self.steps)
            law = np.exp(logs.mean()) * self.steps**self.exponent
            axes.loglog(self.steps, law, label=f"α = {self.exponent:.3f} ± {self.std_error:.3f}")
            axes.legend()
        axes.set(xlabel="distance in steps of the grid", ylabel="fraction uncertain")
        return axes


@dataclass(frozen=True, repr=False, eq=False)
class LeastPushes(Result):
    """The least push out of a basin along each of some directions.

    Attributes
    ----------
    directions : ndarray, shape (m, n)
        The directions.
    size : ndarray, shape (m,)
        The least push, in lengths of the direction; NaN if none changes the attractor.
    uncertainty : ndarray, shape (m,)
        Half of the width to which the boundary was bisected.
    beyond : list of str
        The kind of motion beyond the boundary, as in `BifurcationDiagram`; empty without one, and
        "stop" where the ray ends at a stop: no start lies behind it.
    y_beyond : ndarray, shape (m, n)
        A point of the attractor beyond; NaN without one.
    system : System
        The system.
    """

    directions: Floats
    size: Floats
    uncertainty: Floats
    beyond: list[str]
    y_beyond: Floats
    system: System

    def _columns(self) -> dict[str, Any]:
        return {
            **states_of(self.system, self.directions, "_direction"),
            "size": self.size,
            "uncertainty": self.uncertainty,
            "beyond": self.beyond,
            **states_of(self.system, self.y_beyond, "_beyond"),
        }

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        variables: dict[str, Any] = {
            "direction": (("push", "state"), self.directions),
            "size": ("push", self.size),
            "uncertainty": ("push", self.uncertainty),
            "beyond": ("push", self.beyond),
            "y_beyond": (("push", "state"), self.y_beyond),
        }
        return variables, {"state": list(self.system.states)}

    def plot(self, axes: Any = None) -> Any:
        """Draws the least push along each direction as a bar; none where nothing changes."""
        axes = new_axes(axes)
        places = np.arange(len(self.size))
        axes.bar(places, np.nan_to_num(self.size))
        labels = [f"({', '.join(f'{part:g}' for part in row)})" for row in self.directions]
        axes.set_xticks(places, labels)
        axes.set(xlabel="direction", ylabel="least push")
        return axes


@dataclass(frozen=True, repr=False, eq=False)
class EdgeState(Result):
    """The state between two basins to which the motion on their boundary leads.

    Attributes
    ----------
    kind : str
        ``"equilibrium"``, ``"periodic"``, or ``"undecided"`` if neither was found.
    y : ndarray, shape (n,)
        The equilibrium, a state on the periodic orbit, or the last state of the track.
    period : float
        Period of a periodic orbit, else NaN.
    unstable : int
        Number of unstable directions; 1 for a saddle whose stable manifold is the boundary.
    t, track : ndarray, shapes (m,) and (m, n)
        The track along the boundary.
    bisections : int
        Number of bisections.
    beside : (str, str)
        The kinds of motion on both sides of the boundary.
    system : System
        The system.
    """

    kind: str
    y: Floats
    period: float
    unstable: int
    t: Floats
    track: Floats
    bisections: int
    beside: tuple[str, str]
    system: System

    def _columns(self) -> dict[str, Any]:
        return {"t": self.t, **states_of(self.system, self.track)}

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        coordinates = {"t": self.t, "state": list(self.system.states)}
        return {"track": (("t", "state"), self.track), "y": ("state", self.y)}, coordinates

    def _attributes(self) -> dict[str, Any]:
        names = ("kind", "period", "unstable", "bisections", "beside")
        return {name: getattr(self, name) for name in names}

    def plot(self, axes: Any = None, states: Sequence[int | str | State] = (0, 1)) -> Any:
        """Draws the track and the edge state over two states; a single state over time.

        Parameters
        ----------
        states : (int, str or State, int, str or State), optional
            The two states, by number or name.
        """
        axes = new_axes(axes)
        if len(self.system.states) == 1:
            axes.plot(self.t, self.track[:, 0])
            axes.set(xlabel="t", ylabel=self.system.states[0])
            return axes
        (first, across), (second, up) = (column(self.system, one) for one in states)
        axes.plot(self.track[:, first], self.track[:, second])
        axes.plot([self.y[first]], [self.y[second]], "ko", ms=4)
        axes.set(xlabel=across, ylabel=up)
        return axes


@dataclass(frozen=True, repr=False, eq=False)
class BasinShares(Result):
    """Shares of basins along a parameter.

    Attributes
    ----------
    parameter : ndarray, shape (m,)
        The values of the parameter.
    shares, std_errors : ndarray, shape (m, k)
        Share of each band at each value, and its standard error; 0 where the band is not there.
    kind, phases : list of str
        Kind of motion and phases of each band where it first appears.
    first, last : ndarray, shape (k,)
        First and last value at which a band is there.
    value, band, starts : ndarray of int, shape (r,)
        A row for each attractor at each value: indices of value and band, and number of starts.
    kinds, row_phases : list of str
        Kind of motion and phases of each row.
    period, in_stick : ndarray, shape (r,)
        Period and fraction of time in stick of each row, as in `BifurcationDiagram`.
    returns : ndarray of int, shape (r,)
        Number of section points in a period of each row, else 0.
    reason : list of str
        Why the runs of each row failed; else empty.
    points : list of ndarray, shape (·, n)
        Points of each row's attractor.
    name : str
        The parameter.
    system : System
        The system.
    """

    parameter: Floats
    shares: Floats
    std_errors: Floats
    kind: list[str]
    phases: list[str]
    first: Floats
    last: Floats
    value: NDArray[np.int64]
    band: NDArray[np.int64]
    starts: NDArray[np.int64]
    kinds: list[str]
    row_phases: list[str]
    period: Floats
    in_stick: Floats
    returns: NDArray[np.int64]
    reason: list[str]
    points: list[Floats]
    name: str
    system: System

    def _columns(self) -> dict[str, Any]:
        return {
            self.name: self.parameter[self.value],
            "band": self.band,
            "kind": self.kinds,
            "phases": self.row_phases,
            "period": self.period,
            "returns": self.returns,
            "in_stick": self.in_stick,
            "starts": self.starts,
            "share": self.shares[self.value, self.band],
            "std_error": self.std_errors[self.value, self.band],
            **states_of(self.system, first_points(self.points, len(self.system.states))),
            "reason": self.reason,
        }

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        variables = {
            "shares": ((self.name, "band"), self.shares),
            "std_errors": ((self.name, "band"), self.std_errors),
            "kind": ("band", self.kind),
            "phases": ("band", self.phases),
        }
        return variables, {self.name: self.parameter}

    def plot(self, axes: Any = None) -> Any:
        """Draws the shares as stacked bands."""
        axes = new_axes(axes)
        names = [f"{kind} {phases}".strip() for kind, phases in zip(self.kind, self.phases)]
        colours = colours_of(names)
        axes.stackplot(self.parameter, self.shares.T, labels=names, colors=colours)
        axes.set(xlabel=self.name, ylabel="share of starts", ylim=(0, 1))
        axes.legend(fontsize="small")
        return axes


def least_push(
    system: System,
    y0: ArrayLike | Mapping[State, float],
    directions: ArrayLike | Sequence[ArrayLike],
    *,
    largest: float,
    parts: int = 64,
    longest: float = 2000.0,
    workers: int = -1,
    progress: bool = False,
    **options: Unpack[Options],
) -> LeastPushes:
    """Finds the least push from a state along each direction that changes the attractor.

    The attractor from ``y0 + s * direction`` is sought at equally spaced s, and the first change is
    bisected. If the ray crosses boundaries several times, the push is thus the least one. A part of
    another basin narrower than ``largest / parts`` may hide between two samples. Orbits that
    escape, fail or are undecided have left the basin.

    Parameters
    ----------
    system : System
        The system.
    y0 : array_like, shape (n,), or dict
        The state that is pushed, such as one of `Basins.points`. Each run starts at t = 0.
    directions : array_like, shape (m, n)
        The directions. Their lengths are the unit of the push.
    largest : float
        Largest push that is tried.
    parts : int, optional
        Number of equal parts of a ray at whose ends the attractor is sought.
    longest : float, optional
        Time after which an orbit without an attractor is undecided.
    workers : int, optional
        Number of threads; -1 for all cores. The result does not depend on it.
    progress : bool, optional
        Whether to show the number of finished directions.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    LeastPushes

    Raises
    ------
    OptionError
        If a setting is not allowed, or a direction has no length.

    References
    ----------
    Klinshov, Nekorkin & Kurths, New Journal of Physics 18 (2016) 013004.

    Examples
    --------
    >>> import stickslip as ss
    >>> x = ss.states("x")
    >>> wells = ss.System({x: x - x**3})
    >>> ss.least_push(wells, [1.0], [[-1.0], [1.0]], largest=3).size.round(6)
    array([ 1., nan])
    """
    begin = state_of(checked(system), y0)
    given = array(directions, "directions", 2)
    rows = complete(system, given, "directions")
    # Discrete states that are left out are not pushed.
    rows[:, given.shape[1] :] = 0.0
    with progress_report(progress, "least_push", "directions", total=len(rows)) as report:
        found = call_engine(
            _core.least_push,
            system._core,
            begin,
            rows,
            (real(largest, "largest"), _count(parts, "parts"), real(longest, "longest"))
            + (threads(workers),),
            settings(options),
            report,
        )
    return make_result(found, LeastPushes, directions=rows, system=system)


def _count(given: Any, name: str) -> int:
    if isinstance(given, bool) or not isinstance(given, (int, np.integer)) or given < 1:
        raise out_of_bounds(name, given, "a whole number, 1 at least")
    return int(given)


def edge_state(
    system: System,
    y0: ArrayLike | Mapping[State, float],
    y1: ArrayLike | Mapping[State, float],
    *,
    track: float = 2000.0,
    near: float = 1e-8,
    apart: float = 1e-5,
    longest: float = 2000.0,
    **options: Unpack[Options],
) -> EdgeState:
    """Finds the edge state between the basins of two states, by bisection and tracking.

    The segment between the states is bisected to the boundary of the first one's basin. Two orbits
    on both sides of it follow the boundary, and are bisected again whenever they are apart, until
    they come to an equilibrium or a periodic orbit on the boundary. Newton's iteration refines
    that.

    Parameters
    ----------
    system : System
        The system.
    y0, y1 : array_like, shape (n,), or dict
        States that lead to different attractors.
    track : float, optional
        Longest time of the track.
    near, apart : float, optional
        Distances to which a bisection goes, and at which the two orbits are bisected again, as
        parts of the distance between the two states.
    longest : float, optional
        Time after which an orbit without an attractor is undecided.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    EdgeState

    Raises
    ------
    OptionError
        If both states lead to the same attractor.

    References
    ----------
    Skufca, Yorke & Eckhardt, Physical Review Letters 96 (2006) 174101.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, y = ss.states("x y")
    >>> u = x - y**2 / 3
    >>> wells = ss.System({x: u - u**3 - 2 / 3 * y**2, y: -y})
    >>> found = ss.edge_state(wells, [-1, 1], [2, 1])
    >>> found.kind, found.unstable, bool(abs(found.y).max() < 1e-9)
    ('equilibrium', 1, True)
    """
    states = (state_of(checked(system), y0), state_of(system, y1))
    distances = (real(near, "near"), real(apart, "apart"))
    found = call_engine(
        _core.edge_state,
        system._core,
        states,
        (*distances, number(track, "track"), real(longest, "longest")),
        settings(options),
        None,
    )
    return make_result(found, EdgeState, system=system)


def basin_shares(
    system: System,
    parameter: str | Parameter,
    values: ArrayLike,
    starts: ArrayLike | Sequence[ArrayLike],
    *,
    longest: float = 2000.0,
    workers: int = -1,
    progress: bool = False,
    **options: Unpack[Options],
) -> BasinShares:
    """Computes the shares of the basins of all attractors at values of a parameter.

    An attractor keeps its band if the orbit from it leads to it at the next value, and back. Where
    only one of them holds, the motions must be of the same kind and phases. An attractor that no
    start reaches is kept as long as the orbit from its last value reaches it.

    Parameters
    ----------
    system : System
        The system.
    parameter : str or Parameter
        The parameter.
    values : array_like, shape (m,)
        Values of the parameter, in the order of the computation.
    starts : array_like, shape (…, n)
        The starts, which are the same at all values. Standard errors hold for random ones.
    longest : float, optional
        Time after which an orbit without an attractor is undecided.
    workers : int, optional
        Number of threads; -1 for all cores. The result does not depend on it.
    progress : bool, optional
        Whether to show the number of finished values.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    BasinShares

    Raises
    ------
    SystemError
        If a parameter value is not allowed, or the period of a drive is unknown.
    Interrupted
        On Ctrl-C; `partial` has the finished values.

    References
    ----------
    Menck, Heitzig, Marwan & Kurths, Nature Physics 9 (2013) 89; Stender & Hoffmann, Nonlinear
    Dynamics 107 (2022) 1451.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> x = ss.states("x")
    >>> p = ss.parameter("p", 0.0)
    >>> wells = ss.System({x: -(x + 1) * (x - p) * (x - 1)})
    >>> starts = np.linspace(-1.99, 1.99, 200)[:, None]
    >>> ss.basin_shares(wells, p, [-0.5, 0.5], starts).shares
    array([[0.375, 0.625],
           [0.625, 0.375]])
    """
    name = name_of(parameter)
    given = nonempty_array(values, "values", f"np.linspace(0.1, 0.5, 50) for {name}")
    rows, _ = rows_of_starts(system, starts)
    with progress_report(progress, "basin_shares", "values", total=len(given)) as report:
        found = call_engine(
            _core.basin_shares,
            system._core,
            rows,
            (name, given.tolist()),
            (real(longest, "longest"), threads(workers)),
            settings(options),
            report,
        )
    value, band = found["value"], found["band"]
    warn_of_failures(found["reason"], lambda k: f"{name} = {given[value[k]]:g}")
    bands = int(band.max()) + 1 if len(band) else 0
    shares = np.zeros((len(found["parameter"]), bands))
    errors = np.zeros_like(shares)
    shares[value, band] = found.pop("share")
    errors[value, band] = found.pop("std_error")
    ends = [np.flatnonzero(band == k)[[0, -1]] for k in range(bands)]
    phases, kinds = found.pop("phases"), found.pop("kind")
    return make_result(
        found,
        BasinShares,
        shares=shares,
        std_errors=errors,
        kind=[kinds[first] for first, _ in ends],
        phases=[phases[first] for first, _ in ends],
        first=np.array([given[value[first]] for first, _ in ends]),
        last=np.array([given[value[last]] for _, last in ends]),
        kinds=kinds,
        row_phases=phases,
        name=name,
        system=system,
    )


def first_points(points: list[Floats], states: int) -> Floats:
    """The first point of each attractor; NaN where there is none."""
    nowhere = np.full(states, np.nan)
    rows = [own[0] if len(own) else nowhere for own in points]
    return np.array(rows).reshape(len(rows), states)


def entropy(reached: NDArray[np.int64], side: int) -> BasinEntropy:
    """Basin entropy of a grid of numbers of attractors."""
    numbers, shape = _grid(reached)
    found = call_engine(_core.basin_entropy, numbers, shape, _count(side, "side"))
    return make_result(found, BasinEntropy)


def exponent(reached: NDArray[np.int64]) -> UncertaintyExponent:
    """Uncertainty exponent of a grid of numbers of attractors."""
    found = call_engine(_core.uncertainty_exponent, *_grid(reached))
    return make_result(found, UncertaintyExponent)


def _grid(reached: NDArray[np.int64]) -> tuple[list[int], list[int]]:
    # Starts that Ctrl-C left out count as an outcome of their own.
    return (reached.ravel() - reached.min(initial=0)).tolist(), list(reached.shape)
