"""Periodic orbits, Poincaré maps, and branches."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._arguments import Floats, Options, checked, name_of, pair, real, settings, start, state
from ._errors import SolverWarning
from ._plot import new_axes
from ._progress import progress_report
from ._results import Result, call_engine, column, make_result, states_of, structured
from ._run import Event, Solution, section_of, solve_ivp, variables
from ._symbols import Contact, Expression, Parameter, State, number, out_of_bounds, readable, whole
from ._system import System
from ._tables import Table, as_html


@dataclass(frozen=True, repr=False, eq=False)
class PeriodicOrbit(Result):
    """A periodic orbit.

    Attributes
    ----------
    t : float
        Time of the state `y`.
    y : ndarray, shape (n,)
        A state on the orbit.
    period : float
        Period.
    residual : float
        Largest component of the difference of the states at both ends of a period.
    family : int
        Dimension of the family of periodic orbits that contains it; 0 for an isolated orbit.
    monodromy : ndarray, shape (n, n)
        Derivative of the state after a period with respect to the state at `t`.
    multipliers : ndarray of complex, shape (n,)
        Floquet multipliers. For an autonomous system the first one is trivial.
    multiplier_uncertainties : ndarray, shape (n,), or None
        Uncertainty of each, by half the steps; NaN where the orbit is not found again.
    stability : str
        ``"stable"``, ``"unstable"``, or ``"neutral"`` if the largest modulus of a multiplier is 1,
        up to 1e-6.
    phases : str
        Phases in letters. The text does not depend on where in the cycle `t` is.
    in_stick : float
        Fraction of the period in which a contact sticks.
    y_min, y_max : ndarray, shape (n,)
        Minimum and maximum of each state.
    dperiod : ndarray, shape (k,), or None
        With `derivatives`: those of the period by each of the k parameters.
    dy : ndarray, shape (n, k), or None
        Derivatives of `y`: at a fixed phase of a drive, whole periods after the start of the
        search, else on the plane through `y` perpendicular to the flow.
    dy_min, dy_max : ndarray, shape (n, k), or None
        Derivatives of `y_min` and `y_max`.
    dmultipliers : ndarray of complex, shape (n, k), or None
        Derivatives of `multipliers`, by differences of exact orbits. NaN where no orbit with the
        same phases is beside; a warning says why.
    system : System
        The system.
    """

    t: float
    y: Floats
    period: float
    residual: float
    family: int
    monodromy: Floats
    multipliers: NDArray[np.complex128]
    stability: str
    phases: str
    in_stick: float
    y_min: Floats
    y_max: Floats
    system: System
    dperiod: Floats | None = None
    dy: Floats | None = None
    dy_min: Floats | None = None
    dy_max: Floats | None = None
    dmultipliers: NDArray[np.complex128] | None = None
    multiplier_uncertainties: Floats | None = None

    def _columns(self) -> dict[str, Any]:
        return self.solution()._columns()

    def to_pandas(self) -> Any:
        """The orbit over one period as a `pandas.DataFrame`.

        Returns
        -------
        pandas.DataFrame
        """
        return self.solution().to_pandas()

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        return self.solution()._variables()

    def _attributes(self) -> dict[str, Any]:
        names = ("period", "multipliers", "multiplier_uncertainties", "stability", "phases")
        more = ("in_stick", "family", "residual")
        found = {name: getattr(self, name) for name in (*names, *more)}
        return {name: value for name, value in found.items() if value is not None}

    def to_xarray(self) -> Any:
        """The orbit over one period as an `xarray.Dataset`.

        Returns
        -------
        xarray.Dataset
            Period, multipliers, stability and phases are its attributes.
        """
        return super().to_xarray()

    def _repr_html_(self) -> str:
        names = [name for name in self.keys() if name != "system"]
        return as_html({"field": names, "value": [self[name] for name in names]})

    def solution(self, points: int = 500) -> Solution:
        """The orbit over one period.

        Parameters
        ----------
        points : int, optional
            Number of times, at equal distances.

        Returns
        -------
        Solution
        """
        end = self.t + self.period
        times = np.linspace(self.t, end, whole(points, "points", least=2))
        return solve_ivp(self.system, (self.t, end), self.y, t_eval=times)

    def plot(self, axes: Any = None) -> Any:
        """Draws the first two states against each other, with stick in another colour."""
        axes = new_axes(axes)
        sol = self.solution()
        names = self.system.states
        y, name = (sol.y[1], names[1]) if len(names) > 1 else (sol.y[0], names[0])
        x, label = (sol.y[0], names[0]) if len(names) > 1 else (sol.t, "t")
        axes.plot(x, y)
        sticks = np.zeros(len(sol.t), dtype=bool)
        for phase in sol.phases:
            if "S" in phase["mode"]:
                sticks |= (sol.t >= phase["t_start"]) & (sol.t <= phase["t_end"])
        if sticks.any():
            axes.plot(np.where(sticks, x, np.nan), y, lw=3, label="stick")
            axes.legend()
        axes.set(xlabel=label, ylabel=name)
        return axes


@dataclass(frozen=True, repr=False, eq=False)
class PoincareMap(Result):
    """Crossings of a section, each mapped to the next.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times of the crossings.
    y : ndarray, shape (m, n)
        States at the crossings.
    mode : list of str
        Modes at the crossings, in letters.
    derivatives : ndarray, shape (m, n, n), or None
        Derivative of each crossing with respect to the previous state, if requested.
    system : System
        The system.
    """

    t: Floats
    y: Floats
    mode: list[str]
    derivatives: Floats | None
    system: System

    def _columns(self) -> dict[str, Any]:
        return {"t": self.t, **states_of(self.system, self.y), "mode": self.mode}

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        variables: dict[str, Any] = {
            "y": (("crossing", "state"), self.y),
            "mode": ("crossing", self.mode),
        }
        own = {"t": ("crossing", self.t), "state": list(self.system.states)}
        return variables, own

    def plot(self, axes: Any = None) -> Any:
        """Draws the first two states of the crossings; for one state, each against the last."""
        axes = new_axes(axes)
        names = self.system.states
        if len(names) > 1:
            axes.plot(self.y[:, 0], self.y[:, 1], ".", ms=3)
            axes.set(xlabel=names[0], ylabel=names[1])
        else:
            axes.plot(self.y[:-1, 0], self.y[1:, 0], ".", ms=3)
            axes.set(xlabel=names[0], ylabel=f"next {names[0]}")
        return axes


@dataclass(frozen=True, repr=False, eq=False)
class Branch(Result):
    """A branch of periodic orbits, from its lower end to its upper end.

    Attributes
    ----------
    parameter : ndarray, shape (m,)
        Parameter value of each orbit.
    period : ndarray, shape (m,)
        Period of each orbit.
    y_min, y_max : ndarray, shape (m, n)
        Minimum and maximum of each state on each orbit.
    t, y : ndarray, shapes (m,) and (m, n)
        A state on each orbit, and its time.
    multipliers : list of ndarray of complex
        Multipliers of each orbit, except the trivial one.
    multiplier_uncertainties : list of ndarray
        Their uncertainties, by half the steps; NaN where an orbit is not found again.
    stability : list of str
        ``"stable"``, ``"neutral"`` or ``"unstable"``, as in `PeriodicOrbit`.
    phases : list of str
        Its phases in letters.
    special : Table
        Special orbits, and bifurcations at which the branch ends: ``name``, ``parameter``,
        ``uncertainty``, ``period``, ``contacts`` of a change of the phases, ``angle`` of the
        multipliers of a Neimark-Sacker bifurcation (else NaN), ``criticality`` of these and of
        flips (``"supercritical"``, ``"subcritical"``, or empty where that is not determined),
        phases ``before`` and ``after``, a state ``y`` (NaN at an end), and ``behind``, the number
        of orbits of the branch before it.
    stops : (str, str)
        Why the branch ends, downwards and upwards: ``"range"`` at a bound, ``"points"`` after
        `most_points`, ``"closed"`` where it began, ``"flip"`` of the orbit of half the period,
        ``"equilibrium"`` in a Hopf bifurcation, ``"boundary equilibrium"``, ``"two-fold"``,
        ``"homoclinic"``, ``"rest"`` of a driven system, ``"friction"`` where static friction falls
        below kinetic, ``"sequence ends"`` where the phases change and none were found beyond,
        ``"no convergence"``.
    branches : list of Branch
        With `branches`: those that begin at its flips, with twice the period, and at its branch
        points. `begins` of each is the index of that orbit in `special`. With a `depth` above 1
        they have `branches` of their own.
    curves : list of BifurcationCurve
        With `also`: its special orbits in two parameters, except branch points, and its homoclinic
        and two-fold ends.
    begins : int or None
        Index of the special orbit of another branch at which it begins.
    bubble : int or None
        Index of the other flip of that branch in which it ends. The same branch begins there, and
        is in `branches` once.
    name : str
        The parameter.
    system : System
        The system.
    """

    parameter: Floats
    period: Floats
    y_min: Floats
    y_max: Floats
    t: Floats
    y: Floats
    multipliers: list[NDArray[np.complex128]]
    multiplier_uncertainties: list[Floats]
    stability: list[str]
    phases: list[str]
    special: Table
    stops: tuple[str, str]
    branches: list[Branch]
    curves: list[BifurcationCurve]
    begins: int | None
    bubble: int | None
    name: str
    system: System

    def _columns(self) -> dict[str, Any]:
        return {
            self.name: self.parameter,
            "period": self.period,
            "stability": self.stability,
            "phases": self.phases,
            "t": self.t,
            **states_of(self.system, self.y),
            **states_of(self.system, self.y_min, ".min"),
            **states_of(self.system, self.y_max, ".max"),
            **_complex_columns("multiplier", self.multipliers),
            **_real_columns("multiplier_uncertainty", self.multiplier_uncertainties),
        }

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        of_states = ("orbit", "state")
        variables: dict[str, Any] = {
            "period": ("orbit", self.period),
            "stability": ("orbit", self.stability),
            "phases": ("orbit", self.phases),
            "t": ("orbit", self.t),
            "y": (of_states, self.y),
            "y_min": (of_states, self.y_min),
            "y_max": (of_states, self.y_max),
            "multipliers": (("orbit", "multiplier"), _padded(self.multipliers)),
            "multiplier_uncertainties": (
                ("orbit", "multiplier"),
                _padded(self.multiplier_uncertainties).real,
            ),
        }
        own = {self.name: ("orbit", self.parameter), "state": list(self.system.states)}
        return variables, own

    def plot(self, axes: Any = None, what: int | str | State = 0) -> Any:
        """Draws minimum and maximum of a state over the parameter. Stable orbits are solid, others
        dashed; special orbits have markers.

        Parameters
        ----------
        what : int, str or State, optional
            The state, by number or name; or ``"period"``.
        """
        axes = new_axes(axes)
        # A state compares with no text.
        if isinstance(what, str) and what == "period":
            curves, label = [self.period], "period"
        else:
            k, label = column(self.system, what)
            curves = [self.y_max[:, k], self.y_min[:, k]]
        _draw(self, axes, curves, lambda there: self._between(curves[0], there))
        axes.set(xlabel=self.name, ylabel=label)
        return axes

    def _between(self, curve: Floats, special: NDArray[np.void]) -> Floats:
        """Values of the curve at special orbits, interpolated between the orbits on both sides."""
        last = len(self.parameter) - 1
        one, other = (np.clip(special["behind"] - k, 0, last) for k in (1, 0))
        way = self.parameter[other] - self.parameter[one]
        part = (special["parameter"] - self.parameter[one]) / np.where(way == 0, 1.0, way)
        part = np.clip(part, 0.0, 1.0)
        found: Floats = (1 - part) * curve[one] + part * curve[other]
        return found


@dataclass(frozen=True, repr=False, eq=False)
class EquilibriumBranch(Result):
    """A branch of equilibria, from its lower end to its upper end.

    Attributes
    ----------
    parameter : ndarray, shape (m,)
        Parameter value of each equilibrium.
    y : ndarray, shape (m, n)
        Its states.
    mode : list of str
        Its mode, as in `Solution`. If a contact sticks, it is an equilibrium of the sliding field.
    eigenvalues : list of ndarray of complex
        Eigenvalues of the field in that mode, along the boundaries of the contacts that stick.
    stability : list of str
        ``"stable"``, ``"neutral"`` or ``"unstable"``.
    special : Table
        Bifurcations: ``name`` (``"fold"``, ``"branch point"``, ``"Hopf"``,
        ``"boundary equilibrium"``, ``"unresolved crossing"``), ``parameter``, ``uncertainty``,
        ``frequency`` of a Hopf bifurcation, ``contact`` of a boundary equilibrium with the modes
        ``before`` and ``after``, the state ``y``, and ``behind``, the number of equilibria of the
        branch before it.
    stops : (str, str)
        Why the branch ends, downwards and upwards: ``"range"`` at a bound, ``"points"`` after
        `most_points`, ``"boundary equilibrium"`` at a boundary beyond which there is none,
        ``"no convergence"``.
    curves : list of EquilibriumCurve
        With `also`: its special equilibria in two parameters, except branch points.
    name : str
        The parameter.
    system : System
        The system.
    """

    parameter: Floats
    y: Floats
    mode: list[str]
    eigenvalues: list[NDArray[np.complex128]]
    stability: list[str]
    special: Table
    stops: tuple[str, str]
    curves: list[EquilibriumCurve]
    name: str
    system: System

    def _columns(self) -> dict[str, Any]:
        return {
            self.name: self.parameter,
            "mode": self.mode,
            "stability": self.stability,
            **states_of(self.system, self.y),
            **_complex_columns("eigenvalue", self.eigenvalues),
        }

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        variables: dict[str, Any] = {
            "y": (("point", "state"), self.y),
            "mode": ("point", self.mode),
            "stability": ("point", self.stability),
            "eigenvalues": (("point", "eigenvalue"), _padded(self.eigenvalues)),
        }
        own = {self.name: ("point", self.parameter), "state": list(self.system.states)}
        return variables, own

    def plot(self, axes: Any = None, what: int | str | State = 0) -> Any:
        """Draws a state over the parameter. Stable equilibria are solid, others dashed; special
        equilibria have markers.

        Parameters
        ----------
        what : int, str or State, optional
            The state, by number or name.
        """
        axes = new_axes(axes)
        k, label = column(self.system, what)
        _draw(self, axes, [self.y[:, k]], lambda there: there["y"][:, k])
        axes.set(xlabel=self.name, ylabel=label)
        return axes


@dataclass(frozen=True, repr=False, eq=False)
class BifurcationCurve(Result):
    """A special orbit of a branch, followed in two parameters.

    Attributes
    ----------
    what : str
        The bifurcation.
    parameter : ndarray, shape (m,)
        The parameter of the branch.
    other : ndarray, shape (m,)
        The second parameter. Without points, no curve was found.
    uncertainty : ndarray, shape (m,)
        Uncertainty of `parameter` where that is extrapolated to the end of a branch; NaN elsewhere.
    period : ndarray, shape (m,)
        Period of each orbit.
    t, y : ndarray, shapes (m,) and (m, n)
        A state on each orbit, and its time.
    special : Table
        Special points: their ``name``, such as ``"cusp"``, ``parameter`` and ``other`` with
        ``uncertainty`` and ``other_uncertainty``, ``period``, ``t`` and a state ``y``, and
        ``behind``, the number of points before it.
    stops : (str, str) or None
        Why the curve ends at its first and last point: ``"range"`` of a parameter, ``"points"``,
        ``"closed"`` where it began, ``"flip"`` of the orbit of half the period, ``"resonance"``
        where the multipliers of a torus become real, ``"another change"`` at the same orbit,
        ``"no convergence"``.
    begins : int
        Index of the special orbit or end of the branch at which it begins, in its `special`.
    names : (str, str)
        The parameter of the branch and the second one.
    system : System
        The system.
    """

    what: str
    parameter: Floats
    other: Floats
    uncertainty: Floats
    period: Floats
    t: Floats
    y: Floats
    special: Table
    stops: tuple[str, str] | None
    begins: int
    names: tuple[str, str]
    system: System

    def _columns(self) -> dict[str, Any]:
        return {
            self.names[0]: self.parameter,
            self.names[1]: self.other,
            "uncertainty": self.uncertainty,
            "period": self.period,
            "t": self.t,
            **states_of(self.system, self.y),
        }

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        variables: dict[str, Any] = {
            "uncertainty": ("orbit", self.uncertainty),
            "period": ("orbit", self.period),
            "t": ("orbit", self.t),
            "y": (("orbit", "state"), self.y),
        }
        own = {
            self.names[0]: ("orbit", self.parameter),
            self.names[1]: ("orbit", self.other),
            "state": list(self.system.states),
        }
        return variables, own

    def plot(self, axes: Any = None) -> Any:
        """Draws the curve in the plane of both parameters."""
        return _draw_curve(self, axes)


def _draw_curve(curve: BifurcationCurve | EquilibriumCurve, axes: Any) -> Any:
    axes = new_axes(axes)
    axes.plot(curve.parameter, curve.other, label=curve.what)
    for name in dict.fromkeys(curve.special["name"]):
        there = curve.special[curve.special["name"] == name]
        axes.plot(there["parameter"], there["other"], "o", label=name)
    axes.set(xlabel=curve.names[0], ylabel=curve.names[1])
    axes.legend()
    return axes


@dataclass(frozen=True, repr=False, eq=False)
class EquilibriumCurve(Result):
    """A special equilibrium of a branch, followed in two parameters.

    Attributes
    ----------
    what : str
        The bifurcation.
    parameter : ndarray, shape (m,)
        The parameter of the branch.
    other : ndarray, shape (m,)
        The second parameter. Without points, no curve was found.
    frequency : ndarray, shape (m,)
        Absolute value of the imaginary eigenvalues of a Hopf bifurcation; NaN for others.
    y : ndarray, shape (m, n)
        States of each equilibrium.
    special : Table
        Special points: their ``name``, such as ``"cusp"``, ``parameter`` and ``other`` with
        ``uncertainty`` and ``other_uncertainty``, the state ``y``, and ``behind``, the number of
        points before it.
    stops : (str, str) or None
        Why the curve ends at its first and last point: ``"range"`` of a parameter, ``"points"``,
        ``"closed"`` where it began, ``"Bogdanov-Takens"`` where the eigenvalues of a Hopf
        bifurcation become real, ``"another change"`` at another boundary, ``"no convergence"``.
    begins : int
        Index of the special equilibrium of the branch at which it begins.
    names : (str, str)
        The parameter of the branch and the second one.
    system : System
        The system.
    """

    what: str
    parameter: Floats
    other: Floats
    frequency: Floats
    y: Floats
    special: Table
    stops: tuple[str, str] | None
    begins: int
    names: tuple[str, str]
    system: System

    def _columns(self) -> dict[str, Any]:
        return {
            self.names[0]: self.parameter,
            self.names[1]: self.other,
            "frequency": self.frequency,
            **states_of(self.system, self.y),
        }

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        variables: dict[str, Any] = {
            "frequency": ("point", self.frequency),
            "y": (("point", "state"), self.y),
        }
        own = {
            self.names[0]: ("point", self.parameter),
            self.names[1]: ("point", self.other),
            "state": list(self.system.states),
        }
        return variables, own

    def plot(self, axes: Any = None) -> Any:
        """Draws the curve in the plane of both parameters."""
        return _draw_curve(self, axes)


@dataclass(frozen=True, repr=False, eq=False)
class Tangents(Result):
    """Tangent points and stick zones on the boundary of a contact, along a state.

    Attributes
    ----------
    points : Table
        Points at which a field is tangent to the boundary: its ``side``, ``visibility``
        (``"visible"``, ``"invisible"``, ``"degenerate"``), the state ``y``, and the number of the
        ``branch`` of the boundary.
    zones : Table
        Parts of the boundary: their ``kind``, ``"stick"`` where both fields point towards it and
        ``"repelling"`` where both lead away, from ``low`` to ``high``, and their ``branch``.
    rates : Table
        Rates of the boundary function with the fields ``below`` and ``above``, where the state is
        ``at``, and their ``branch``.
    along : str
        The state along which the search goes.
    solved : str
        The state for which the equation of the boundary is solved.
    contact : str
        The contact.
    system : System
        The system.
    """

    points: Table
    zones: Table
    rates: Table
    along: str
    solved: str
    contact: str
    system: System

    def _columns(self) -> dict[str, Any]:
        return {name: self.points[name] for name in self.points.dtype.names or ()}

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        points, zones = self.points, self.zones
        variables: dict[str, Any] = {
            "side": ("point", points["side"]),
            "visibility": ("point", points["visibility"]),
            "y": (("point", "state"), points["y"]),
            "kind": ("zone", zones["kind"]),
            "low": ("zone", zones["low"]),
            "high": ("zone", zones["high"]),
        }
        return variables, {"state": list(self.system.states)}

    def plot(self, axes: Any = None) -> Any:
        """Draws the rates of both fields, with the zones as bands and markers at the points."""
        axes = new_axes(axes)
        for zone in self.zones:
            colour = "#f6d9a8" if zone["kind"] == "stick" else "0.85"
            axes.axvspan(zone["low"], zone["high"], color=colour, lw=0, zorder=0)
        for branch in np.unique(self.rates["branch"]):
            own = self.rates[self.rates["branch"] == branch]
            for side, style in (("below", "C0"), ("above", "C5")):
                label = f"field {side}" if branch == 0 else None
                axes.plot(own["at"], own[side], style, label=label)
        at = self.points[f"y.{self.along}"]
        axes.plot(at, np.zeros(len(at)), "ko", label="tangent points")
        axes.axhline(0, color="0.7", lw=0.8)
        axes.set(xlabel=self.along, ylabel="rate through the boundary")
        axes.legend()
        return axes


def _padded(several: list[NDArray[np.complex128]]) -> NDArray[np.complex128]:
    """Rows of different lengths, filled up with NaN."""
    found = np.full((len(several), max(map(len, several), default=0)), np.nan + 0j)
    for row, values in zip(found, several):
        row[: len(values)] = values
    return found


def _complex_columns(name: str, several: list[NDArray[np.complex128]]) -> dict[str, Any]:
    padded = _padded(several)
    return {f"{name}{k + 1}": padded[:, k] for k in range(padded.shape[1])}


def _real_columns(name: str, several: list[Floats]) -> dict[str, Any]:
    padded = _padded(several).real
    return {f"{name}{k + 1}": padded[:, k] for k in range(padded.shape[1])}


def _draw(
    branch: Branch | EquilibriumBranch,
    axes: Any,
    curves: list[Floats],
    height: Callable[[NDArray[np.void]], Any],
) -> None:
    """Draws curves along a branch, solid where stable, and markers at special points."""
    stable = np.array([one == "stable" for one in branch.stability], dtype=bool)
    # A line extends to the first point after a change.
    for of_kind, style in ((stable, "-"), (~stable, "--")):
        drawn = of_kind.copy()
        drawn[1:] |= of_kind[:-1]
        for curve in curves:
            axes.plot(branch.parameter, np.where(drawn, curve, np.nan), style, color="C0")
    for name in dict.fromkeys(branch.special["name"]):
        there = branch.special[branch.special["name"] == name]
        axes.plot(there["parameter"], height(there), "o", label=name)
    if len(branch.special):
        axes.legend()


def _range(
    system: System, parameter: str | Parameter, bounds: tuple[float, float]
) -> tuple[str, float, float]:
    """The parameter of a branch and its bounds, which must contain its present value."""
    low, high = pair(bounds, "bounds", "the branch is followed both ways between them")
    name = name_of(parameter)
    value = checked(system).parameters.get(name, low)
    if not low <= value <= high:
        bound = f"in the bounds {readable(low)} to {readable(high)} of the branch"
        raise out_of_bounds(name, value, bound, "; set it by with_parameters")
    return name, low, high


def _search(
    system: System,
    transient: float | None,
    period: float | None,
    longest: float,
    periods: int | None,
) -> tuple[float | None, float | None, float, int | None]:
    if period is not None and not number(period, "period") > 0:
        raise out_of_bounds("period", period, "positive")
    if periods is not None and not system._core.depends_on_time:
        raise ValueError(f"periods = {periods}: the system does not depend on time; leave it out")
    return (
        None if transient is None else real(transient, "transient"),
        None if period is None else float(period),
        real(longest, "longest"),
        None if periods is None else whole(periods, "periods"),
    )


def periodic_orbit(
    system: System,
    y0: ArrayLike | Mapping[State, float] | None = None,
    *,
    t0: float = 0.0,
    period: float | None = None,
    periods: int | None = None,
    transient: float | None = None,
    longest: float = 100.0,
    derivatives: Parameter | str | Sequence[Parameter | str] | None = None,
    **options: Unpack[Options],
) -> PeriodicOrbit:
    """Finds the periodic orbit that the run from a start approaches, by shooting.

    Parameters
    ----------
    system : System
        The system.
    y0 : array_like, shape (n,), or dict, optional
        Start state, in order or as ``{x: 1, v: 0}``. Default: the start of the system.
        Discrete states may be left out.
    t0 : float, optional
        Start time.
    period : float, optional
        Guess of the period. For a driven system it is the exact period.
    periods : int, optional
        Period of the orbit in periods of the drive. Default: the smallest number after which the
        run returns, at most 16.
    transient : float, optional
        Length of the run before the search. The default is 200, but at most 1000 periods of a drive
        or, without a drive, 1000 transitions.
    longest : float, optional
        Longest time of return, for a system that does not depend on time.
    derivatives : sequence of Parameter or str, optional
        Parameters by which period, state, extremes and multipliers are differentiated. A driven
        system needs its period as a formula of them.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    StickslipError
        If there is none. The message names the motion that the run approaches instead.
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
    found = call_engine(
        _core.periodic_orbit,
        checked(system)._core,
        start(system, t0, y0),
        _search(system, transient, period, longest, periods),
        variables(derivatives),
        settings(options),
    )
    slopes = found.pop("derivatives", {})
    for why in slopes.pop("missing", ()):
        message = f"the multipliers have no derivative: {why}"
        warnings.warn(message, SolverWarning, stacklevel=2)
    if slopes:
        slopes["dmultipliers"] = np.array(slopes["dmultipliers"]).T
    return make_result({**found, **slopes}, PeriodicOrbit, system=system)


def poincare_map(
    system: System,
    section: Event | Expression,
    y0: ArrayLike | Mapping[State, float] | None = None,
    *,
    returns: int = 100,
    t0: float = 0.0,
    longest: float = 1000.0,
    derivative: bool = False,
    progress: bool = False,
    **options: Unpack[Options],
) -> PoincareMap:
    """Computes the next crossings of a section.

    Parameters
    ----------
    system : System
        The system.
    section : Event or Expression
        The section, such as ``ss.event(v, direction=1)``.
    y0 : array_like, shape (n,), or dict, optional
        Start state, in order or as ``{x: 1, v: 0}``. Default: the start of the system.
        Discrete states may be left out.
    returns : int, optional
        Number of crossings.
    t0 : float, optional
        Start time.
    longest : float, optional
        Longest time to the next crossing.
    derivative : bool, optional
        Whether to compute the derivative of the map.
    progress : bool, optional
        Whether to show the number of finished crossings.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    PoincareMap

    Raises
    ------
    StickslipError
        If the orbit does not return within `longest`.
    Interrupted
        On Ctrl-C; `partial` has the crossings so far.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, v = ss.states("x v")
    >>> found = ss.poincare_map(ss.System({x: v, v: -x}), ss.event(x, 1), [0, 1], returns=2)
    >>> (found.t / (2 * np.pi)).round(12)
    array([1., 2.])
    """
    count = whole(returns, "returns")
    with progress_report(progress, "returns", "", total=count) as report:
        found = call_engine(
            _core.poincare_map,
            section_of(checked(system), section),
            start(system, t0, y0),
            (count, real(longest, "longest"), bool(derivative)),
            settings(options),
            report,
        )
    if not derivative:
        found["derivatives"] = None
    return make_result(found, PoincareMap, system=system)


def continuation(
    system: System,
    parameter: str | Parameter,
    bounds: tuple[float, float],
    y0: ArrayLike | Mapping[State, float] | None = None,
    *,
    t0: float = 0.0,
    period: float | None = None,
    periods: int | None = None,
    transient: float | None = None,
    longest: float = 100.0,
    step: float = 0.02,
    most_points: int = 1000,
    also: tuple[str | Parameter, tuple[float, float]] | None = None,
    branches: bool = False,
    depth: int = 1,
    progress: bool = False,
    **options: Unpack[Options],
) -> Branch:
    """Continues a periodic orbit along a parameter, in both directions, stable or not.

    Equilibria are followed by `equilibrium_continuation`. The program's ``continue`` computes the
    same.

    Parameters
    ----------
    system : System
        The system, at a value of the parameter at which `periodic_orbit` finds the orbit.
    parameter : str or Parameter
        The parameter.
    bounds : (float, float)
        Lower and upper bound of the parameter, at which the branch ends.
    y0, t0, period, periods, transient, longest
        As for `periodic_orbit`.
    step : float, optional
        Longest step, as a fraction of the bounds and of the orbit's size. A small orbit that moves
        far takes many steps.
    most_points : int, optional
        Largest number of orbits in each direction.
    also : (str or Parameter, (float, float)), optional
        A second parameter with its bounds: each special orbit, except branch points, is followed in
        both parameters.
    branches : bool, optional
        Whether the branches that begin at flips and branch points are followed, too.
    depth : int, optional
        With `branches`: at 2 the flips of these branches are followed, too, and so on.
    progress : bool, optional
        Whether to show the number of orbits so far.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    Branch

    Raises
    ------
    OptionError
        If the parameter is outside `bounds`, or these are not the lower and the upper one.
    StickslipError
        If no periodic orbit is found at the start.
    Interrupted
        On Ctrl-C; `partial` is the branch so far.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, y = ss.states("x y")
    >>> s = x * x + y * y
    >>> grows = ss.parameter("p", 0.5) + 2 * s - s * s
    >>> system = ss.System({x: x * grows - y, y: y * grows + x})
    >>> branch = ss.continuation(system, "p", (-1.5, 1), [1, 0], transient=10)
    >>> branch.special["name"], branch.special["parameter"].round(6) + 0
    (array(['Hopf', 'fold'], dtype='<U4'), array([ 0., -1.]))
    """
    name, low, high = _range(system, parameter, bounds)
    second = None if also is None else _second(system, name, also)
    with progress_report(progress, "continuation", "orbits") as report:
        found = call_engine(
            _core.continuation,
            system._core,
            start(system, t0, y0),
            _search(system, transient, period, longest, periods),
            (name, low, high),
            (real(step, "step"), whole(most_points, "most_points", least=2)),
            second,
            whole(depth, "depth", least=1) if branches else None,
            settings(options),
            report,
        )
    curves, others = found.pop("curves"), found.pop("branches")
    first = found["first_special"]
    whole_branch: dict[str, Any] = {"name": name, "system": system}
    found = _branch(found, system)
    # Each begins on one before it; the rows of its special orbits may begin with an end.
    all_branches: list[list[Branch]] = [[]]
    firsts = [first]
    for one in others:
        parent, begins, to = one.pop("parent"), one.pop("begins"), one.pop("to")
        shift = firsts[parent]
        firsts.append(one["first_special"])
        all_branches.append([])
        all_branches[parent].append(
            Branch(
                **_branch(one, system),
                branches=all_branches[-1],
                curves=[],
                begins=shift + begins,
                bubble=None if to is None else shift + to,
                **whole_branch,
            )
        )
    found["branches"] = all_branches[0]
    kinds = found["special"]["name"]
    found["curves"] = [
        BifurcationCurve(
            **{**one, "special": structured(one["special"], system.states)},
            what=str(kinds[begins]),
            begins=begins,
            names=(name, "" if second is None else second[0]),
            system=system,
        )
        for one in curves
        for begins in [one.pop("begins")]
    ]
    return make_result(found, Branch, begins=None, bubble=None, **whole_branch)


def _branch(found: dict[str, Any], system: System) -> dict[str, Any]:
    """The fields of a branch from the engine's output."""
    found.pop("first_special")
    found["special"] = structured(found["special"], system.states)
    return found


def _second(
    system: System, name: str, also: tuple[str | Parameter, tuple[float, float]]
) -> tuple[str, float, float]:
    """The second parameter of a branch and its bounds."""
    try:
        parameter, bounds = also
    except (TypeError, ValueError):
        message = "also must be a parameter and its bounds, as (vp, (0.1, 0.5))"
        raise TypeError(message) from None
    found = _range(system, parameter, bounds)
    if found[0] == name:
        raise ValueError(f"also = {name}: it is the parameter of the branch; give another one")
    return found


def equilibrium_continuation(
    system: System,
    parameter: str | Parameter,
    bounds: tuple[float, float],
    y0: ArrayLike | Mapping[State, float] | None = None,
    *,
    transient: float | None = None,
    step: float = 0.02,
    most_points: int = 1000,
    also: tuple[str | Parameter, tuple[float, float]] | None = None,
    **options: Unpack[Options],
) -> EquilibriumBranch:
    """Continues an equilibrium along a parameter, in both directions, stable or not.

    It is also followed into the sliding field of contacts and out of it. The program's
    ``continue --equilibrium`` computes the same.

    Parameters
    ----------
    system : System
        The system; it may not depend on time.
    parameter : str or Parameter
        The parameter.
    bounds : (float, float)
        Lower and upper bound of the parameter, at which the branch ends.
    y0 : array_like, shape (n,), or dict, optional
        Start state, in order or as ``{x: 1, v: 0}``. Default: the start of the system.
    transient : float, optional
        Length of the run that searches the equilibrium. The default is 2000; the run ends when it
        has reached the equilibrium. With 0 there is no run: the equilibrium near `y0` is used.
    step : float, optional
        Longest step, as a fraction of the bounds and of the size of the first equilibrium.
    most_points : int, optional
        Largest number of equilibria in each direction.
    also : (str or Parameter, (float, float)), optional
        A second parameter and its bounds: each fold, Hopf bifurcation and boundary equilibrium is
        followed in both. They are `curves` of the branch.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    EquilibriumBranch

    Raises
    ------
    OptionError
        If the parameter is outside `bounds`, or these are not the lower and the upper one.
    ValueError
        If the system depends on time.
    StickslipError
        If the run approaches another motion, or the equilibrium belongs to a set of equilibria.
    Interrupted
        On Ctrl-C, after the branch is computed (some 0.1 ms per point); nothing is kept.

    Examples
    --------
    >>> import stickslip as ss
    >>> x = ss.state("x")
    >>> p = ss.parameter("p", 1.0)
    >>> branch = ss.equilibrium_continuation(ss.System({x: p - x**2}), p, (-1, 2), [0.5])
    >>> branch.special["name"], branch.special["parameter"].round(9) + 0
    (array(['fold'], dtype='<U4'), array([0.]))
    """
    along = _range(system, parameter, bounds)
    second = None if also is None else _second(system, along[0], also)
    found = call_engine(
        _core.equilibrium_continuation,
        system._core,
        state(system, y0),
        None if transient is None else number(transient, "transient"),
        along,
        (real(step, "step"), whole(most_points, "most_points", least=2)),
        second,
        settings(options),
    )
    found["special"] = structured(found["special"], system.states)
    kinds = found["special"]["name"]
    found["curves"] = [
        EquilibriumCurve(
            **{**one, "special": structured(one["special"], system.states)},
            what=str(kinds[one["begins"]]),
            names=(along[0], "" if second is None else second[0]),
            system=system,
        )
        for one in found["curves"]
    ]
    return make_result(found, EquilibriumBranch, name=along[0], system=system)


def tangents(
    system: System,
    contact: str | Contact | None = None,
    along: str | State | None = None,
    bounds: tuple[float, float] | None = None,
    y0: ArrayLike | Mapping[State, float] | None = None,
    *,
    t0: float = 0.0,
) -> Tangents:
    """Finds the tangent points and stick zones on the boundary of a contact.

    The search goes along one state on the boundary, at one time. Further states keep their values
    of the start, and further contacts slip on the side where the start is. The program's
    ``tangents`` computes the same.

    Parameters
    ----------
    system : System
        The system.
    contact : str or Contact, optional
        The contact. Default: the first.
    along : str or State, optional
        The state along which to search. Default: the first that the equation of the boundary leaves
        free.
    bounds : (float, float), optional
        Lowest and highest value of that state. Default: its range in the file.
    y0 : array_like, shape (n,), or dict, optional
        The start. Default: the start of the system.
    t0 : float, optional
        The time.

    Returns
    -------
    Tangents

    Raises
    ------
    ValueError
        If there is no contact, no such state, or no line to search along.

    Examples
    --------
    >>> import stickslip as ss
    >>> x, v = ss.states("x v")
    >>> belt = ss.Contact("belt", boundary=v - 0.2, friction=0.4)
    >>> system = ss.System({x: v, v: -x - belt.friction}, contacts=[belt], start=[0, 0])
    >>> found = ss.tangents(system, bounds=(-1, 1))
    >>> found.points["visibility"], found.points["y.x"].round(9)
    (array(['visible', 'invisible'], dtype='<U9'), array([ 0.4, -0.4]))
    >>> found.zones["kind"], found.zones["low"].round(9), found.zones["high"].round(9)
    (array(['stick'], dtype='<U5'), array([-0.4]), array([0.4]))
    """
    contacts = checked(system).contacts
    if not contacts:
        raise ValueError("the system has no contact, and so no boundary with tangent points")
    name = contacts[0] if contacts and contact is None else getattr(contact, "name", contact)
    if name not in contacts:
        raise ValueError(f"there is no contact {name}: they are {', '.join(contacts)}")
    found = call_engine(
        _core.tangents,
        system._core,
        start(system, t0, y0),
        contacts.index(name),
        None if along is None else column(system, along)[0],
        None if bounds is None else pair(bounds, "bounds", "the search goes between them"),
    )
    for table in ("points", "zones", "rates"):
        found[table] = structured(found[table], system.states)
    return make_result(found, Tangents, contact=name, system=system)
