"""What the analyses return."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._plot import classes, new_axes
from ._run import Floats, Solution, solve_ivp
from ._system import System


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        if value.size > 4 or value.dtype.names:
            return f"<{' × '.join(map(str, value.shape))}>"
        return np.array2string(value, precision=6, separator=", ")
    if isinstance(value, (list, tuple)) and len(value) > 4:
        return f"<{len(value)}>"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


class _Result:
    """A result of named fields."""

    def __repr__(self) -> str:
        # What was analysed is shown by its own name.
        names = [one.name for one in fields(self) if one.name != "system"]  # type: ignore[arg-type]
        shown = [f"{name}={_short(getattr(self, name))}" for name in names]
        return f"{type(self).__name__}({', '.join(shown)})"


@dataclass(frozen=True, repr=False)
class PeriodicOrbit(_Result):
    """A periodic orbit.

    Attributes
    ----------
    t : float
        A time at which it is at `y`.
    y : ndarray, shape (n,)
        A state on it.
    period : float
        Its period.
    residual : float
        Largest component of what a run over one period leaves open.
    family : int
        Dimension of the family of periodic orbits that it is one of; 0 of an isolated one.
    monodromy : ndarray, shape (n, n)
        Derivative of the state after a period by the state at `t`.
    multipliers : ndarray of complex, shape (n,)
        Floquet multipliers; the first of a system that does not depend on time is the trivial one.
    stability : str
        As ``"stable"``.
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
    system: System

    def solution(self, points: int = 500) -> Solution:
        """The orbit over one period.

        Parameters
        ----------
        points : int, optional
            At so many times, equally apart.

        Returns
        -------
        Solution
        """
        end = self.t + self.period
        times = np.linspace(self.t, end, points)
        return solve_ivp(self.system, (self.t, end), self.y, t_eval=times)

    def plot(self, axes: Any = None) -> Any:
        """Draws the first two states against each other, stick in another colour.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to; new axes unless given.

        Returns
        -------
        matplotlib.axes.Axes
        """
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


@dataclass(frozen=True, repr=False)
class PoincareMap(_Result):
    """Returns to a section.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times of the returns.
    y : ndarray, shape (m, n)
        States there.
    mode : list of str
        Modes there, in letters.
    derivatives : ndarray, shape (m, n, n), or None
        Of each return by the state that it came from, if asked for.
    system : System
        The system.
    """

    t: Floats
    y: Floats
    mode: list[str]
    derivatives: Floats | None
    system: System

    def plot(self, axes: Any = None) -> Any:
        """Draws the first two states of the returns; of a single state, each against the last.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to; new axes unless given.

        Returns
        -------
        matplotlib.axes.Axes
        """
        axes = new_axes(axes)
        names = self.system.states
        if len(names) > 1:
            axes.plot(self.y[:, 0], self.y[:, 1], ".", ms=3)
            axes.set(xlabel=names[0], ylabel=names[1])
        else:
            axes.plot(self.y[:-1, 0], self.y[1:, 0], ".", ms=3)
            axes.set(xlabel=names[0], ylabel=f"next {names[0]}")
        return axes


@dataclass(frozen=True, repr=False)
class Branch(_Result):
    """A branch of periodic orbits, from its lower end along the parameter to its upper one.

    Attributes
    ----------
    parameter : ndarray, shape (m,)
        The parameter of each orbit.
    period : ndarray, shape (m,)
        Its period.
    t, y : ndarray, shapes (m,) and (m, n)
        A state on it, and the time at which it is there.
    multipliers : list of ndarray of complex
        Its multipliers besides the trivial one.
    stability : list of str
        As ``"stable"``.
    phases : list of str
        Its phases in letters.
    special : ndarray, structured
        What is special on the branch: ``name``, ``parameter``, ``uncertainty``, ``period``.
    stops : (str, str)
        Why the branch ends, downwards and upwards.
    name : str
        The parameter.
    """

    parameter: Floats
    period: Floats
    t: Floats
    y: Floats
    multipliers: list[NDArray[np.complex128]]
    stability: list[str]
    phases: list[str]
    special: NDArray[np.void]
    stops: tuple[str, str]
    name: str

    def plot(self, axes: Any = None) -> Any:
        """Draws the period along the parameter: stable orbits solid, others dashed, and what is
        special by its name.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to; new axes unless given.

        Returns
        -------
        matplotlib.axes.Axes
        """
        axes = new_axes(axes)
        stable = np.array([one == "stable" for one in self.stability], dtype=bool)
        # A line goes on to the first orbit behind a change.
        for kind, style in ((stable, "-"), (~stable, "--")):
            reached = kind.copy()
            reached[1:] |= kind[:-1]
            axes.plot(self.parameter, np.where(reached, self.period, np.nan), style, color="C0")
        for name in dict.fromkeys(self.special["name"]):
            there = self.special[self.special["name"] == name]
            axes.plot(there["parameter"], there["period"], "o", label=name)
        if len(self.special):
            axes.legend()
        axes.set(xlabel=self.name, ylabel="period")
        return axes


@dataclass(frozen=True, repr=False)
class LyapunovSpectrum(_Result):
    """Lyapunov exponents, per unit of time.

    Attributes
    ----------
    exponents : ndarray, shape (n,)
        In descending order; -inf where stick takes a direction to zero.
    std_errors : ndarray, shape (n,)
        Standard errors from the means of blocks; NaN of an exponent of -inf.
    uncertainties : ndarray, shape (n,)
        By how much each may be off: four standard errors, or what an end leaves.
    duration : float
        Time measured.
    defect : float
        What their sum differs from the rate of volumes, which is found without them.
    stick_entries : int
        Entries into stick in that time.
    stick_fraction : float
        Part of the time in stick.
    elapsed : ndarray, shape (k,)
        Times since measuring began.
    running : ndarray, shape (k, n)
        The exponents as they stood then.
    """

    exponents: Floats
    std_errors: Floats
    uncertainties: Floats
    duration: float
    defect: float
    stick_entries: int
    stick_fraction: float
    elapsed: Floats
    running: Floats

    def plot(self, axes: Any = None) -> Any:
        """Draws the exponents as they settled.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to; new axes unless given.

        Returns
        -------
        matplotlib.axes.Axes
        """
        axes = new_axes(axes)
        for k, values in enumerate(self.running.T, 1):
            finite = np.where(np.isfinite(values), values, np.nan)
            axes.plot(self.elapsed, finite, label=f"$\\lambda_{k}$")
        axes.axhline(0, color="0.7", lw=0.8)
        axes.set(xlabel="time measured", ylabel="exponent")
        axes.legend()
        return axes


@dataclass(frozen=True, repr=False)
class BifurcationDiagram(_Result):
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
    exponent, std_error : ndarray, shape (m,)
        Largest Lyapunov exponent and its standard error; NaN where it was not measured.
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
    changes: NDArray[np.void]
    name: str
    system: System

    def plot(self, axes: Any = None, state: int = 0) -> Any:
        """Draws a state at the points of the section, and lines where the attractor changes.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to; new axes unless given.
        state : int, optional
            Which component.

        Returns
        -------
        matplotlib.axes.Axes
        """
        axes = new_axes(axes)
        counts = [len(points) for points in self.points]
        values = np.concatenate([*(points[:, state] for points in self.points), []])
        axes.plot(np.repeat(self.parameter, counts), values, ".", ms=2)
        for change in self.changes:
            if np.isfinite(change["parameter"]):
                axes.axvline(change["parameter"], color="0.7", lw=0.8, zorder=0)
        axes.set(xlabel=self.name, ylabel=self.system.states[state])
        return axes


@dataclass(frozen=True, repr=False)
class Basins(_Result):
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
        return counts / max(1, counts.sum())

    def plot(self, axes: Any = None) -> Any:
        """Draws the basins over the two states that the starts go through, and the attractors.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to; new axes unless given.

        Returns
        -------
        matplotlib.axes.Axes
        """
        axes = new_axes(axes)
        rows = self.starts.reshape(-1, self.starts.shape[-1])
        varied = [k for k in range(rows.shape[1]) if np.ptp(rows[:, k]) > 0]
        first, second = [*varied, *(k for k in range(rows.shape[1]) if k not in varied)][:2]
        x, y = self.starts[..., first], self.starts[..., second]
        names = [
            f"{kind} {phases}: {share:.1%}".replace(" :", ":")
            for kind, phases, share in zip(self.kind, self.phases, self.shares)
        ]
        is_grid = self.reached.ndim == 2
        classes(axes, x, y, self.reached if is_grid else self.reached.ravel(), names)
        for points in self.points:
            axes.plot(points[:, first], points[:, second], "k.", ms=3)
        names = list(self.system.states)
        axes.set(xlabel=names[first], ylabel=names[second])
        return axes


@dataclass(frozen=True, repr=False)
class ParameterMap(_Result):
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
    phases : ndarray of str, shape (k, m)
        Its phases in letters.
    in_stick : ndarray, shape (k, m)
        Part of the time in stick; NaN where there is no attractor.
    exponent, std_error : ndarray, shape (k, m)
        Largest Lyapunov exponent and its standard error.
    names : (str, str)
        The parameters.
    """

    x: Floats
    y: Floats
    kind: NDArray[np.str_]
    period: Floats
    phases: NDArray[np.str_]
    in_stick: Floats
    exponent: Floats
    std_error: Floats
    names: tuple[str, str]

    def plot(self, axes: Any = None, what: str = "kind") -> Any:
        """Draws the plane by kinds of motion with their phases, or by a number.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to; new axes unless given.
        what : {"kind", "exponent", "in_stick", "period"}, optional
            What the colours show.

        Returns
        -------
        matplotlib.axes.Axes
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
        elif what in ("exponent", "in_stick", "period"):
            values = np.ma.masked_invalid(getattr(self, what))
            drawn = axes.pcolormesh(self.x, self.y, values, shading="nearest")
            axes.figure.colorbar(drawn, ax=axes, label=what)
        else:
            raise ValueError(f"what = {what!r}: it is kind, exponent, in_stick or period")
        axes.set(xlabel=self.names[0], ylabel=self.names[1])
        return axes


@dataclass(frozen=True, repr=False)
class DataSpectrum(_Result):
    """Lyapunov exponents of a measured series, per unit of time.

    Attributes
    ----------
    exponents, std_errors : ndarray, shape (d,)
        The exponents and their standard errors.
    status : list of str
        Which of them mean something: ``"ok"``, or why not.
    dimension : int
        Dimension of the embedding.
    """

    exponents: Floats
    std_errors: Floats
    status: list[str]
    dimension: int

    def plot(self, axes: Any = None) -> Any:
        """Draws the exponents with four standard errors; those that mean nothing are open.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to; new axes unless given.

        Returns
        -------
        matplotlib.axes.Axes
        """
        axes = new_axes(axes)
        numbers = np.arange(1, len(self.exponents) + 1)
        for k, value, error, status in zip(numbers, self.exponents, self.std_errors, self.status):
            face = "C0" if status == "ok" else "white"
            axes.errorbar(k, value, yerr=4 * error, fmt="o", color="C0", mfc=face)
        axes.axhline(0, color="0.7", lw=0.8)
        axes.set(xlabel="number", ylabel="exponent", xticks=numbers)
        return axes
