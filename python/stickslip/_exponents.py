"""Lyapunov exponents, from the equations and from a series."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._arguments import Floats, Options, array, as_array, checked, real, settings, start
from ._plot import new_axes
from ._progress import shown
from ._results import Result, called, kept
from ._symbols import State, number, whole
from ._system import System


@dataclass(frozen=True, repr=False)
class LyapunovSpectrum(Result):
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
        """Draws the exponents as they settled."""
        axes = new_axes(axes)
        for k, values in enumerate(self.running.T, 1):
            finite = np.where(np.isfinite(values), values, np.nan)
            axes.plot(self.elapsed, finite, label=f"$\\lambda_{k}$")
        axes.axhline(0, color="0.7", lw=0.8)
        axes.set(xlabel="time measured", ylabel="exponent")
        axes.legend()
        return axes


@dataclass(frozen=True, repr=False)
class DataSpectrum(Result):
    """Lyapunov exponents of a measured series, per unit of time.

    Attributes
    ----------
    exponents, std_errors : ndarray, shape (d,)
        The exponents and their standard errors.
    status : list of str
        Which of them mean something: ``"ok"``, or why not.
    dimension : int
        In how many directions the series has points: so many exponents it can determine.
    embedding : (int, int) or None
        Delay in points and number of delayed values of each column; None if the columns are taken
        as they are.
    """

    exponents: Floats
    std_errors: Floats
    status: list[str]
    dimension: int
    embedding: tuple[int, int] | None

    def plot(self, axes: Any = None) -> Any:
        """Draws the exponents with four standard errors; those that mean nothing are open."""
        axes = new_axes(axes)
        numbers = np.arange(1, len(self.exponents) + 1)
        for k, value, error, status in zip(numbers, self.exponents, self.std_errors, self.status):
            face = "C0" if status == "ok" else "white"
            axes.errorbar(k, value, yerr=4 * error, fmt="o", color="C0", mfc=face)
        axes.axhline(0, color="0.7", lw=0.8)
        axes.set(xlabel="number", ylabel="exponent", xticks=numbers)
        return axes


def lyapunov_spectrum(
    system: System,
    y0: ArrayLike | Mapping[State, float] | None = None,
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
    y0 : array_like, shape (n,), or dict, optional
        State at the start, in order or as ``{x: 1, v: 0}``; that of the system unless given.
        Discrete states may be left out.
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
    t, x = start(checked(system), t0, y0)
    times = (real(transient, "transient"), real(duration, "duration"))
    with shown(progress, "lyapunov_spectrum", "", span=(t, t + sum(times))) as report:
        found = called(
            _core.lyapunov_spectrum, system._core, (t, x), times, settings(options), report
        )
    return kept(found, LyapunovSpectrum)


def lyapunov_from_data(
    series: ArrayLike,
    dt: float = 1.0,
    *,
    delay: int | None = None,
    dimension: int | None = None,
    progress: bool = False,
) -> DataSpectrum:
    """The Lyapunov exponents of a measured series.

    A single column, as of a sensor, is no state: it is embedded, which is to say that its values at
    t, t + delay, t + 2 delay, … are the state. Several columns are taken as they are, unless they
    lack one. It is what the program's ``spectrum`` computes.

    Parameters
    ----------
    series : array_like, shape (m,) or (m, d)
        The series: a number or a row for each point.
    dt : float, optional
        Time between two points.
    delay : int, optional
        Points between delayed values; the first minimum of the mutual information unless given.
    dimension : int, optional
        Delayed values of each column, 1 to take the columns as they are; the first number with less
        than 1 % false neighbours unless given.
    progress : bool, optional
        Whether to show how much is done.

    Returns
    -------
    DataSpectrum

    Raises
    ------
    StickslipError
        If the series is too short or does not move.
    Interrupted
        On Ctrl-C; nothing is kept.

    Examples
    --------
    >>> import stickslip as ss
    >>> series = [0.3]
    >>> while len(series) < 4000:
    ...     series.append(4 * series[-1] * (1 - series[-1]))
    >>> float(ss.lyapunov_from_data(series).exponents[0].round(1))
    0.7
    """
    given = as_array(series, "series")
    rows = array(given[:, None] if given.ndim == 1 else given, "series", 2)
    if rows.shape[1] > len(rows):
        raise ValueError(
            f"series has {len(rows)} rows of {rows.shape[1]} values: it must have a row for each "
            "point; of a solution it is sol.y.T"
        )
    embedding = tuple(
        None if one is None else whole(one, name)
        for name, one in (("delay", delay), ("dimension", dimension))
    )
    # Three parts of a thousand steps each.
    with shown(progress, "lyapunov_from_data", "", span=(0, 3000)) as report:
        found = called(_core.lyapunov_from_data, rows, number(dt, "dt"), embedding, report)
    return kept(found, DataSpectrum)
