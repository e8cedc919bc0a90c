"""Lyapunov exponents from the equations and from a series."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Unpack

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._arguments import Floats, Options, array, as_array, checked, real, settings, start
from ._errors import SolverWarning
from ._plot import new_axes
from ._progress import progress_report
from ._results import Result, call_engine, make_result
from ._symbols import State, number, out_of_bounds, whole
from ._system import System


@dataclass(frozen=True, repr=False, eq=False)
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

    def _columns(self) -> dict[str, Any]:
        return {
            "exponent": self.exponents,
            "std_error": self.std_errors,
            "uncertainty": self.uncertainties,
        }

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        variables: dict[str, Any] = {name: ("number", one) for name, one in self._columns().items()}
        variables["running"] = (("elapsed", "number"), self.running)
        return variables, {"elapsed": self.elapsed}

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


@dataclass(frozen=True, repr=False, eq=False)
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
    eps_sensitivity : ndarray, shape (d,)
        Change of each exponent with neighbourhoods of twice the size, a measure of bias.
    by_rank : ndarray, shape (d,)
        The exponents by the fit of fixed rank; NaN beyond that rank.
    residual_ratio : float
        Part of the motion that local maps do not predict: near 0 for states of a smooth
        deterministic system, near 1 for noise.
    balance : (int, float, float) or None
        With `divergence`: number of exponents that the series does not determine, their sum, and
        its standard error. Without such exponents, what the sum exceeds the divergence by. None for
        delayed values.
    surrogate_p : float or None
        With `surrogates`: probability of so small a residual in linear noise.
    surrogate_residuals : ndarray or None
        Residual ratios of the surrogates.
    diverging_neighbours : dict or None
        The largest exponent from the divergence of neighbours, which fits no maps: ``rosenstein``
        and ``kantz`` (exponent and standard error, or None), ``rosenstein_curve``,
        ``kantz_curves`` (a list, of growing radii) and ``saturation``, the mean logarithm of the
        distance of any two points. A curve is a dict: ``t`` and ``log_distance`` (arrays),
        ``radius``, ``references``, and ``straight`` (``from``, ``to``, ``slope``, ``stderr``,
        ``scatter``, or None). None for fewer than 50 points.
    """

    exponents: Floats
    std_errors: Floats
    status: list[str]
    dimension: int
    embedding: tuple[int, int] | None
    eps_sensitivity: Floats
    by_rank: Floats
    residual_ratio: float
    balance: tuple[int, float, float] | None
    surrogate_p: float | None
    surrogate_residuals: Floats | None
    diverging_neighbours: dict[str, Any] | None

    def _columns(self) -> dict[str, Any]:
        return {
            "exponent": self.exponents,
            "std_error": self.std_errors,
            "eps_sensitivity": self.eps_sensitivity,
            "status": self.status,
            "by_rank": self.by_rank,
        }

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        return {name: ("number", one) for name, one in self._columns().items()}, {}

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
    columns: Sequence[int | str] | None = None,
    eps: float | None = None,
    neighbours: int | tuple[int, int] | None = None,
    step: int | None = None,
    theiler: int | None = None,
    affine: bool = False,
    rank_tolerance: float | None = None,
    estimator: Literal["extrapolated", "sano-sawada"] = "extrapolated",
    degree: Literal["linear", "quadratic"] | None = None,
    divergence: float | None = None,
    ridge: float = 0.0,
    rank: int | None = None,
    stride: int | None = None,
    references: int | None = None,
    surrogates: int | None = None,
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
    columns : sequence of int or str, optional
        Columns to use, by number from 0, or by name of a table of pandas. Default: all.
    eps : float, optional
        Radius of the neighbourhoods over the spread of the series. Default 0.1.
    neighbours : int or (int, int), optional
        The number of nearest neighbours, or the fewest and most in the ball. Default: 12 for
        states, 40 for delayed values, and fewer for those below 4000 points.
    step : int, optional
        Number of points that a map predicts ahead. Default: 1, the delay for delayed values.
    theiler : int, optional
        Points closer in time than this are no neighbours. Default: the time in which the
        autocorrelation falls to 1/e.
    affine : bool, optional
        Whether linear maps have a constant term, too.
    rank_tolerance : float, optional
        Singular values below this fraction of the largest are zero.
    estimator : {"extrapolated", "sano-sawada"}, optional
        Maps of two sizes of neighbourhoods, extrapolated to size zero, or linear maps of one size
        without correction.
    degree : {"linear", "quadratic"}, optional
        Degree of the maps that are extrapolated. Default: quadratic in a long enough series.
    divergence : float, optional
        Mean divergence of the system, to which the exponents must add up: the trace of the Jacobian
        per unit of time; of a map, ``ln |det J|``. The columns must be the state of the system.
    ridge : float, optional
        Tikhonov term over the largest singular value.
    rank : int, optional
        Rank of the second fit. Default: the number of tangent directions.
    stride : int, optional
        Distance between reference points. Default: 1, more for delayed values.
    references : int, optional
        Most reference points, at least 20. Default: all.
    surrogates : int, optional
        Number of surrogates of linear noise to compare with, at least 19. Each takes as long as the
        series.
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
    rows = _series(series, columns)

    def whole_or_none(one: int | None, name: str) -> int | None:
        return None if one is None else whole(one, name)

    def real_or_none(one: float | None, name: str) -> float | None:
        return None if one is None else number(one, name)

    counts = {
        "delay": delay,
        "dimension": dimension,
        "step": step,
        "theiler": theiler,
        "rank": rank,
        "stride": stride,
        "references": references,
        "surrogates": surrogates,
    }
    if isinstance(neighbours, tuple):
        fewest, most = (whole(one, "neighbours") for one in neighbours)
        ball: tuple[int, int | None] | None = (fewest, most)
    else:
        ball = None if neighbours is None else (whole(neighbours, "neighbours"), None)
    if ball is not None and ball[1] is None and eps is not None:
        raise ValueError(
            f"neighbours = {neighbours} takes the nearest points and no ball, so that eps has no "
            f"meaning: give a pair, such as neighbours=({neighbours}, {2 * ball[0]}), or no eps"
        )
    for name, value, known in (
        ("estimator", estimator, ("extrapolated", "sano-sawada")),
        ("degree", degree, (None, "linear", "quadratic")),
    ):
        if value not in known:
            words = " or ".join(str(one) for one in known if one is not None)
            raise ValueError(f"{name} = {value!r}: it is {words}")
    options = {
        **{name: whole_or_none(value, name) for name, value in counts.items()},
        "estimator": estimator,
        "degree": degree,
        "eps": real_or_none(eps, "eps"),
        "neighbours": ball,
        "affine": bool(affine),
        "rank_tolerance": real_or_none(rank_tolerance, "rank_tolerance"),
        "ridge": number(ridge, "ridge"),
    }
    sum_of_all = real_or_none(divergence, "divergence")
    # Parts of a thousand steps each.
    parts = (0, 4000 if surrogates is None else 5000)
    with progress_report(progress, "lyapunov_from_data", "", span=parts) as report:
        found = call_engine(
            _core.lyapunov_from_data, rows, number(dt, "dt"), sum_of_all, options, report
        )
    return make_result(found, DataSpectrum)


def _series(series: Any, columns: Sequence[int | str] | None) -> Floats:
    """The wanted columns of a series as rows."""
    names = [str(name) for name in getattr(series, "columns", [])]
    given = as_array(series, "series")
    given = given[:, None] if given.ndim == 1 else given
    if columns is not None:
        numbers = []
        for one in columns:
            if isinstance(one, str) and one not in names:
                known = ", ".join(names) if names else "without names"
                raise ValueError(f"there is no column {one!r} of series: they are {known}")
            at = names.index(one) if isinstance(one, str) else whole(one, "columns", least=0)
            if at >= given.shape[-1]:
                bound = f"less than the {given.shape[-1]} columns of series"
                raise out_of_bounds("columns", at, bound)
            numbers.append(at)
        given = given[:, numbers]
    rows = array(given, "series", 2)
    if rows.shape[1] > len(rows):
        raise ValueError(
            f"series has {len(rows)} rows of {rows.shape[1]} values: it must have a row for each "
            "point; of a solution it is sol.y.T"
        )
    return rows
