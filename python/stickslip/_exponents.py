"""Lyapunov exponents from the equations and from a series."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._arguments import Floats, Options, array, as_array, checked, real, settings, start
from ._errors import SolverWarning
from ._plot import new_axes
from ._progress import progress_report
from ._results import Result, call_engine, make_result
from ._symbols import State, number, whole
from ._system import System


@dataclass(frozen=True, repr=False)
class LyapunovSpectrum(Result):
    """Lyapunov exponents, per unit of time.

    Attributes
    ----------
    exponents : ndarray, shape (n,)
        In descending order; -inf for a direction that stick annihilates.
    std_errors : ndarray, shape (n,)
        Standard errors from block means; NaN for an exponent of -inf.
    uncertainties : ndarray, shape (n,)
        Four standard errors, ln 30 divided by `duration`, or the effect of rounding on equal
        exponents or of their growth by powers of time, whichever is largest.
    duration : float
        Duration of the measurement.
    ended : str or None
        Why the measurement ended before its duration; None if it did not.
    defect : float
        Difference of their sum from the mean growth rate of volumes, which is computed separately.
    stick_entries : int
        Number of entries into stick in that time.
    stick_fraction : float
        Fraction of time in stick.
    elapsed : ndarray, shape (k,)
        Times since the start of the measurement.
    running : ndarray, shape (k, n)
        The exponents measured up to these times.
    """

    exponents: Floats
    std_errors: Floats
    uncertainties: Floats
    duration: float
    ended: str | None
    defect: float
    stick_entries: int
    stick_fraction: float
    elapsed: Floats
    running: Floats

    def plot(self, axes: Any = None) -> Any:
        """Draws the running exponents against the time measured."""
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
        ``"ok"`` for each reliable exponent, else the reason why it is not.
    dimension : int
        Number of tangent directions of the series, which is the number of exponents it determines.
    embedding : (int, int) or None
        Delay in points and number of delayed values of each column; None without embedding.
    """

    exponents: Floats
    std_errors: Floats
    status: list[str]
    dimension: int
    embedding: tuple[int, int] | None

    def plot(self, axes: Any = None) -> Any:
        """Draws the exponents with four standard errors; unreliable ones have open markers."""
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
    """Computes the Lyapunov exponents from the equations, through slip, stick and jumps.

    Parameters
    ----------
    system : System
        The system.
    y0 : array_like, shape (n,), or dict, optional
        State at the start, in order or as ``{x: 1, v: 0}``; that of the system unless given.
        Discrete states may be left out.
    t0 : float, optional
        Start time.
    transient, duration : float, optional
        Time before the measurement, and its duration.
    progress : bool, optional
        Whether to show the progress of the run.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    LyapunovSpectrum

    Raises
    ------
    StickslipError
        If the run cannot begin.
    Interrupted
        On Ctrl-C; nothing is kept.

    Warns
    -----
    SolverWarning
        If the run fails or its future is not unique. The exponents are those of the time before.

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
    with progress_report(progress, "lyapunov_spectrum", "", span=(t, t + sum(times))) as report:
        found = call_engine(
            _core.lyapunov_spectrum, system._core, (t, x), times, settings(options), report
        )
    result = make_result(found, LyapunovSpectrum)
    if result.ended is not None:
        message = f"measured for {result.duration:g} of {times[1]:g} time units: {result.ended}"
        warnings.warn(message, SolverWarning, stacklevel=2)
    return result


def lyapunov_from_data(
    series: ArrayLike,
    dt: float = 1.0,
    *,
    delay: int | None = None,
    dimension: int | None = None,
    progress: bool = False,
) -> DataSpectrum:
    """Estimates the Lyapunov exponents of a measured series.

    A single column, such as that of a sensor, is embedded: the state is its values at t, t + delay,
    t + 2 delay, … Several columns are the state, unless their neighbours show that one is
    missing. The program's ``spectrum`` computes the same.

    Parameters
    ----------
    series : array_like, shape (m,) or (m, d)
        The series, with a number or a row for each point.
    dt : float, optional
        Time between two points.
    delay : int, optional
        Points between delayed values. Default: the first minimum of the mutual information.
    dimension : int, optional
        Number of delayed values of each column; 1 for no embedding. Default: the first number with
        less than 1 % false neighbours.
    progress : bool, optional
        Whether to show the progress.

    Returns
    -------
    DataSpectrum

    Raises
    ------
    StickslipError
        If the series is too short or constant.
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
    with progress_report(progress, "lyapunov_from_data", "", span=(0, 3000)) as report:
        found = call_engine(_core.lyapunov_from_data, rows, number(dt, "dt"), embedding, report)
    return make_result(found, DataSpectrum)
