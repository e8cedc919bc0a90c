"""`fit` and its results: parameters and starts from measured motion."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Unpack

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._arguments import (
    Floats,
    Method,
    OptionsButMethod,
    array,
    by_name,
    checked,
    complete,
    settings,
)
from ._errors import SolverWarning
from ._plot import COLOURS, new_axes, several_axes
from ._results import Result, call_engine, make_result
from ._symbols import Expression, Input, Parameter, State, expression, number, whole
from ._system import System

#: Names of the column of times.
TIMES = ("t", "time")


@dataclass(frozen=True)
class Record:
    """One measured record, where it differs from the others by more than its data.

    Attributes
    ----------
    data : mapping, DataFrame or Series
        Times under "t" or "time", and the columns. With pandas the times may be an index of that
        name, and a Series is a single column. NaN is a missing value.
    parameters : dict, optional
        Values of parameters in this record.
    y0 : dict or array_like, optional
        Start values of states in this record: by state, or of all in their order.
    t0 : float, optional
        Time of the start; default as in the system, or 0.
    inputs : dict, optional
        Points ``(times, values)`` of inputs in this record, by input or its name. The system has
        these inputs as a `table`.
    """

    data: Any
    parameters: Mapping[Any, float] = field(default_factory=dict)
    y0: Mapping[Any, float] | ArrayLike = field(default_factory=dict)
    t0: float | None = None
    inputs: Mapping[Any, tuple[ArrayLike, ArrayLike]] = field(default_factory=dict)


def _name(one: Any) -> str:
    if isinstance(one, (str, Parameter, State, Input)):
        return one if isinstance(one, str) else one.name
    raise TypeError(
        f"fit: {one!r} is neither a parameter, nor a state, nor the name of one; the start time is "
        '"t0"'
    )


def _named(values: Any, what: str, example: str) -> dict[str, Any]:
    """Values by name. Errors name the argument by `what`, and show an example."""
    values = by_name(values, "index", what)
    if values is None:
        return {}
    if not isinstance(values, Mapping):
        raise TypeError(f"{what} must be a dict, as {{{example}}}, not {values!r}")
    return {_name(key): value for key, value in values.items()}


def _pairs(values: Any, what: str, example: str) -> list[tuple[str, float]]:
    named = _named(values, what, example)
    return [(name, number(value, f"{what}[{name}]")) for name, value in named.items()]


def _starts(system: System, y0: Any) -> list[tuple[str, float]]:
    """Start values of a record by state; a sequence has those of all states."""
    example = f'"{system.states[0]}": 0.1'
    given = by_name(y0, "index", "y0")
    if isinstance(given, (list, tuple, np.ndarray)) or hasattr(given, "to_numpy"):
        values = array(given, "y0")
        complete(system, values, "y0")
        return list(zip(system.states, values.tolist()))
    return _pairs(given, "y0", example)


def _inputs(given: Any) -> list[tuple[str, list[float], list[float]]]:
    """Names and points of the tables of a record."""
    found = []
    for name, points in _named(given, "inputs", '"u": (times, values)').items():
        try:
            times, values = points
        except (TypeError, ValueError):
            raise TypeError(f"inputs[{name}] must be (times, values), not {points!r}") from None
        times, values = (array(one, f"inputs[{name}]").tolist() for one in (times, values))
        found.append((name, times, values))
    return found


def _bounds(given: Any, name: str) -> tuple[float, float]:
    try:
        low, high = (float(end) for end in given)
    except (TypeError, ValueError):
        raise TypeError(f"bounds[{name}] must be (lowest, highest), not {given!r}") from None
    return low, high


def _columns_of(data: Any) -> list[Any] | None:
    """The names of the columns of a dict, a frame or a structured array; None of other data."""
    if isinstance(data, Mapping):
        return list(data)
    if hasattr(data, "to_numpy") and hasattr(data, "columns"):
        return list(data.columns)
    names = getattr(getattr(data, "dtype", None), "names", None)
    return None if names is None else list(names)


def _read(data: Any, columns: Sequence[str], which: int) -> list[Floats]:
    """Times, and the columns, of a record."""
    what = f"record {which}"
    if isinstance(data, (str, os.PathLike)):
        raise TypeError(
            f"{what} is the text {str(data)!r}, not data: read the file first, as "
            f"pandas.read_csv({str(data)!r})"
        )
    index = getattr(data, "index", None) if hasattr(data, "to_numpy") else None
    if index is not None and hasattr(data, "to_frame"):
        # A Series: its index are the times.
        if len(columns) > 1 or data.name not in (None, columns[0]):
            raise ValueError(
                f"{what} is a Series called {data.name!r}, and the columns are "
                f"{', '.join(columns)}: give a DataFrame with these columns"
            )
        data = data.to_frame(columns[0])
    known = _columns_of(data)
    if known is None:
        raise TypeError(
            f'{what} must be a dict, as {{"t": times, "{columns[0]}": values}}, or a DataFrame, '
            f"not {type(data).__name__}"
        )
    time = next((one for one in TIMES if one in known), None)
    if time is None and index is not None and index.name in TIMES:
        times = index.to_numpy()
    elif time is not None:
        times = data[time]
    else:
        help = ""
        if index is not None:
            help = '; where the times are the index, give it that name: data.rename_axis("t")'
        raise ValueError(
            f"{what} has no column 't' or 'time'; it has {', '.join(map(str, known))}{help}"
        )
    for name in columns:
        if name not in known:
            raise ValueError(f"{what} has no column {name!r}; it has {', '.join(map(str, known))}")
    found = [array(_column(times, "t", None), "t")]
    return found + [_column(data[name], name, len(found[0])) for name in columns]


@dataclass(frozen=True)
class SeenPhases:
    """Phases of a contact as the data show them, beside those at the fit.

    Attributes
    ----------
    column : str
        The column that shows them.
    data : list of (float, float, str)
        Start, end and mode of the phases of the data.
    fit : list of (float, float, str)
        Those of the fitted motion, seen in the same rows in the same way.
    """

    column: str
    data: list[tuple[float, float, str]]
    fit: list[tuple[float, float, str]]

    @property
    def same(self) -> bool:
        """Whether both have the same sequence of modes."""
        return [one[2] for one in self.data] == [one[2] for one in self.fit]

    @property
    def sticks(self) -> tuple[int, int]:
        """The number of sticks in the data and at the fit."""
        return sum(one[2] == "S" for one in self.data), sum(one[2] == "S" for one in self.fit)


@dataclass(frozen=True, repr=False, eq=False)
class FitResult(Result):
    """A fit of parameters, starts and offsets.

    Attributes
    ----------
    names : list of str
        What was fitted; with several records ``x@2`` is the start value in the second.
    x : ndarray, shape (k,)
        The fitted values.
    start : ndarray, shape (k,)
        Where the search began.
    std_errors : ndarray, shape (k,)
        Standard errors; NaN where there is none.
    intervals : ndarray, shape (k, 2)
        Intervals with 95 % confidence, for a model that is linear within them.
    bounds : ndarray, shape (k, 2)
        Lowest and highest value that the search allows; infinite without a bound.
    at_bound : list of bool
        Whether a value is one of its bounds.
    covariance, correlations : ndarray, shape (k, k)
        Of the values; NaN where there are none.
    undetermined : list of list of (str, float)
        Relative changes that leave the data as they are: what the data do not determine.
    no_errors : str or None
        Why there is no standard error at all.
    bend : float or None
        Distance from the linear model within a standard error, relative to the change.
    doubtful : bool
        Whether that distance is so large that the intervals are doubtful.
    t, data, model, residuals : list of dict of ndarray
        For each record, its times, and by column the data, the model and data minus model.
    rms, sigma, p_values : list of dict of float
        For each record, by column: the size of the residuals, the standard deviation of the noise,
        and the chance that independent noise has as unlikely an order of signs.
    phases : list of list of (float, float, str)
        Start, end and modes of the phases of each record.
    seen : list of dict
        For each record, by the name of a contact, the phases that the data show, where a column is
        the slip or the way of the contact and its noise does not hide it: a `SeenPhases`.
    phases_off : list of dict of list of (int, int, float, float)
        For each record, by column, the phases whose residuals are too large for the noise: the
        number of the phase from 0, that of its values, the size of their residuals over the
        deviation of the noise, and the chance that noise has as large ones.
    cost : float
        Half the sum of squares of the residuals over their deviations.
    mismatch : float or None
        With `segments`, where no single orbit follows the record: the largest mismatch of two
        parts, over the spread of the state.
    freedom : int
        Number of values minus number of unknowns.
    success : bool
        Whether a minimum was reached, and how the search ended in `end`.
    end : str
        "cost", "step", "gradient", "change" (of phases, at the minimum), "evaluations" or
        "notfinite".
    ending : str
        That end in words.
    work : (int, int, int)
        Steps, runs, and runs that failed.
    changes : (int, int, int or None)
        Steps that changed the sequence of phases, changes at which the residuals jump, and grazing
        impacts between start and result, at which the residuals have a square root.
    others : list of (list of float, float)
        Further minima of a search, with their costs.
    """

    names: list[str]
    x: Floats
    start: Floats
    std_errors: Floats
    intervals: Floats
    bounds: Floats
    at_bound: list[bool]
    covariance: Floats
    correlations: Floats
    undetermined: list[list[tuple[str, float]]]
    no_errors: str | None
    bend: float | None
    doubtful: bool
    t: list[Floats]
    data: list[dict[str, Floats]]
    model: list[dict[str, Floats]]
    residuals: list[dict[str, Floats]]
    rms: list[dict[str, float]]
    sigma: list[dict[str, float]]
    p_values: list[dict[str, float]]
    phases: list[list[tuple[float, float, str]]]
    seen: list[dict[str, SeenPhases]]
    phases_off: list[dict[str, list[tuple[int, int, float, float]]]]
    cost: float
    mismatch: float | None
    freedom: int
    success: bool
    end: str
    ending: str
    work: tuple[int, int, int]
    changes: tuple[int, int, int | None]
    others: list[tuple[list[float], float]]
    system: System

    @property
    def values(self) -> dict[str, float]:
        """The fitted values by name."""
        return dict(zip(self.names, self.x.tolist()))

    def __getitem__(self, name: str | Parameter | State) -> float:
        wanted = _name(name)
        if wanted not in self.names:
            known = ", ".join(self.names)
            raise KeyError(f"there is no fitted value {wanted!r}: they are {known}")
        return self.values[wanted]

    def keys(self) -> list[str]:
        """The names of what was fitted."""
        return list(self.names)

    def _columns(self) -> dict[str, Any]:
        return {
            "name": self.names,
            "value": self.x,
            "std_error": self.std_errors,
            "low": self.intervals[:, 0],
            "high": self.intervals[:, 1],
            "start": self.start,
            "lower_bound": self.bounds[:, 0],
            "upper_bound": self.bounds[:, 1],
            "at_bound": self.at_bound,
        }

    def _variables(self) -> tuple[dict[str, Any], dict[str, Any]]:
        columns = self._columns()
        names = columns.pop("name")
        variables: dict[str, Any] = {key: ("name", one) for key, one in columns.items()}
        variables["covariance"] = (("name", "other"), self.covariance)
        return variables, {"name": names, "other": names}

    def __repr__(self) -> str:
        width = max(map(len, self.names), default=0)
        rows = []
        for k, name in enumerate(self.names):
            if math.isfinite(self.std_errors[k]):
                low, high = self.intervals[k]
                more = f"± {self.std_errors[k]:.2g}  (95 %: {low:.6g} to {high:.6g})"
            else:
                more = "(on its bound)" if self.at_bound[k] else "(no standard error)"
            rows.append(f"  {name:{width}}  {self.x[k]:.8g} {more}")
        for direction in self.undetermined:
            parts = ", ".join(f"{name} by {part:+.3f}" for name, part in direction)
            rows.append(f"  not determined: relative changes of {parts}")
        if self.no_errors is not None:
            rows.append(f"  no standard errors: {self.no_errors}")
        elif self.doubtful and self.bend is not None:
            rows.append(
                "  errors doubtful: within one of them the model departs from a linear one by "
                f"{100 * self.bend:.0f} %"
            )
        for number, of_record in enumerate(self.p_values):
            for name, p_value in of_record.items():
                rms = self.rms[number][name]
                rest = f"a systematic remainder, p = {p_value:.0e}" if p_value < 0.01 else ""
                off = len(self.phases_off[number][name])
                rest += f"; too large in {off} of {len(self.phases[number])} phases" if off else ""
                rows.append(f"  {name} of record {number + 1}: rms {rms:.3e} {rest}".rstrip())
            for contact, seen in self.seen[number].items():
                data, fit = seen.sticks
                rest = "as at the fit" if seen.same else f"another sequence, {fit} at the fit"
                rows.append(f"  {contact} from {seen.column}: {data} sticks in the data, {rest}")
        for values, cost in self.others:
            ends = zip(self.names, values, self.bounds)
            pairs = (
                f"{name} = {value:.8g}" + ("" if low < value < high else " (on its bound)")
                for name, value, (low, high) in ends
            )
            rows.append(f"  another minimum: {', '.join(pairs)}, cost {cost:.4e}")
        steps, runs, failed = self.work
        rows.append(f"  {self.ending}: {steps} steps, {runs} runs, {failed} of which failed")
        if any(self.changes):
            crossings, jumps, grazes = self.changes
            roots = ""
            if grazes is None:
                roots = "; grazing impacts are not looked for in parts"
            elif grazes:
                roots = f"; grazing impacts, at which they have a square root: {grazes}"
            rows.append(
                f"  the sequence of phases changed in {crossings} steps; the residuals jumped at "
                f"{jumps} changes{roots}"
            )
        if self.mismatch is not None:
            rows.append(
                f"  no single orbit follows the record; mismatch {self.mismatch:.0e} of the spread"
            )
        found = "" if self.success else ", no minimum"
        return "\n".join([f"FitResult of {self.system.name or 'a system'}{found}:", *rows])

    def plot(self, record: int = 0, axes: Any = None) -> Any:
        """Draws data, model and residuals of a record, with the sticks behind them.

        Parameters
        ----------
        record : int, optional
            Number of the record, from 0.
        axes : sequence of Axes, optional
            Two for each column; new ones by default.

        Returns
        -------
        ndarray of Axes
        """
        if hasattr(record, "plot") or isinstance(record, (list, tuple, np.ndarray)):
            raise TypeError("record is a number, and the axes are given by name: plot(axes=axes)")
        if not 0 <= whole(record, "record", least=-1) < len(self.data):
            raise ValueError(f"record = {record}: there are {len(self.data)}, from 0")
        columns = list(self.data[record])
        if axes is not None:
            what = f"data and residuals of each of {', '.join(columns)}"
            axes = several_axes(axes, 2 * len(columns), what)
        else:
            first = new_axes()
            figure = first.figure
            first.remove()
            ratios = [2, 1] * len(columns)
            axes = figure.subplots(2 * len(columns), 1, sharex=True, height_ratios=ratios)
        times = self.t[record]
        for k, name in enumerate(columns):
            above, below = axes[2 * k], axes[2 * k + 1]
            for begin, end, mode in self.phases[record]:
                if "S" in mode and end > times[0]:
                    for one in (above, below):
                        one.axvspan(max(begin, times[0]), end, color="#fbe3c0", lw=0)
            above.plot(times, self.data[record][name], ".", color="black", label="measured")
            above.plot(times, self.model[record][name], color=COLOURS[0], label="fit")
            for seen in self.seen[record].values():
                lowest = min(np.nanmin(self.data[record][name]), np.min(self.model[record][name]))
                sticks = [one[:2] for one in seen.data if one[2] == "S"]
                if seen.column == name and sticks:
                    how: dict[str, Any] = {"lw": 3, "label": "sticks in the data"}
                    above.hlines([lowest] * len(sticks), *zip(*sticks), COLOURS[1], **how)
            above.set_ylabel(name)
            above.legend(frameon=False)
            below.plot(times, self.residuals[record][name], ".", color=COLOURS[5])
            below.axhline(0.0, color="black", lw=0.5)
            below.set_ylabel("residual")
        axes[-1].set_xlabel("t")
        return axes


def fit(
    system: System,
    data: Any,
    fit: Parameter | State | str | Sequence[Parameter | State | str],
    observe: Mapping[str, Any],
    *,
    sigma: float | Mapping[str, float] | None = None,
    bounds: Mapping[Any, tuple[float, float]] | None = None,
    start: Mapping[Any, float] | None = None,
    each: Sequence[Parameter | str] = (),
    loss: Literal["squares", "soft_l1", "huber"] = "squares",
    loss_scale: float = 1.0,
    search: int = 0,
    segments: int = 0,
    most_runs: int = 500,
    method: Method = "taylor",
    **options: Unpack[OptionsButMethod],
) -> FitResult:
    """Fits parameters, start values and offsets to measured motion, by least squares.

    Derivatives are exact, through slip, stick, crossings and jumps. Steps are those of Gauss and
    Newton within a trust region; a run that fails shortens a step.

    Parameters
    ----------
    system : System
        The system; its values are where the search begins.
    data : mapping, DataFrame, Series, Record, or a list of them
        Times under "t" or "time" and a column for each observable. With pandas the times may be an
        index of that name, and a Series is a single column. NaN is a missing value. With several
        records parameters are shared, and starts are of each.
    fit : sequence of Parameter, State or str
        Parameters, states (for their start values), and "t0" for the time of the start.
    observe : dict
        For each column what it measures: a formula of states, inputs, time and parameters.
        Parameters that the system does not have, as offsets, may stand here, and may be fitted.
    sigma : float or dict, optional
        Standard deviation of the noise, of all columns or by column. Default: estimated from the
        residuals of each column.
    bounds : dict, optional
        ``(low, high)`` by what is fitted, within the ranges of the parameters.
    start : dict, optional
        Where the search begins. Default: the values and the start of the system.
    each : sequence of Parameter or str, optional
        Those of `fit` that each record has for itself.
    loss : {"squares", "soft_l1", "huber"}, optional
        Weight of large residuals.
    loss_scale : float, optional
        Residual, in standard deviations, from which it counts as large.
    search : int, optional
        Number of further starts within the bounds; all minima are reported.
    segments : int, optional
        Parts of each record for multiple shooting, with which the search begins: for chaotic or
        long records, some periods each. Each part needs two rows with a value, and a run.
    most_runs : int, optional
        Most runs of all records from one start, in all stages of the search together.
    method : {"taylor", "dop853"}, optional
        The integration method.
    **options : Options
        Tolerances and other settings.

    Returns
    -------
    FitResult

    Raises
    ------
    ValueError
        For data that cannot be fitted: fewer values than unknowns, times that do not rise, a
        parameter without effect, a formula of unknown names.
    StickslipError
        If the run at the start of the search fails.
    Interrupted
        On Ctrl-C.

    Examples
    --------
    >>> import numpy as np, stickslip as ss
    >>> x, v = ss.states("x v")
    >>> k, = ss.parameters(k=3.0)
    >>> spring = ss.System({x: v, v: -k * x}, start=[1, 0])
    >>> t = np.linspace(0.1, 4, 40)
    >>> found = ss.fit(spring, {"t": t, "x": np.cos(2 * t)}, [k], {"x": x})
    >>> round(found["k"], 9)
    4.0
    """
    made = settings({"method": method, **options})
    core = checked(system)._core
    given = [fit] if isinstance(fit, (str, Parameter, State)) else list(fit)
    names = [_name(one) for one in given]
    if not isinstance(observe, Mapping) or not observe:
        raise TypeError('observe must be a dict of formulas by column, as {"x": x}')
    formulas = {name: expression(one) for name, one in observe.items()}
    extra = {
        part.name: part.value
        for formula in [*formulas.values(), *(one for one in given if isinstance(one, Expression))]
        for part in formula.parts
        if isinstance(part, Parameter) and part.name not in system.parameters
    }
    for formula in formulas.values():
        system._check_symbols(formula)
    sigmas = sigma if isinstance(sigma, Mapping) else dict.fromkeys(formulas, sigma)
    for name in sigmas.keys() - formulas.keys():
        raise ValueError(f"sigma has {name!r}, which is no column of observe")
    observables = [
        (name, one.text, None if sigmas.get(name) is None else number(sigmas[name], "sigma"))
        for name, one in formulas.items()
    ]
    first = names[0] if names else "mu"
    ends = _named(bounds, "bounds", f'"{first}": (0, 1)')
    starts = _named(start, "start", f'"{first}": 0.5')
    own = [_name(one) for one in ([each] if isinstance(each, (str, Parameter)) else each)]
    for what, known in (("bounds", ends), ("start", starts), ("each", own)):
        for name in known:
            if name not in names:
                raise ValueError(f"{what} has {name!r}, which is not among fit")
    unknowns = []
    for name in names:
        low, high = _bounds(ends.get(name, (-math.inf, math.inf)), name)
        begin = number(starts[name], f"start[{name}]") if name in starts else None
        unknowns.append((name, begin, low, high, name in own))
    several = data if isinstance(data, (list, tuple)) else [data]
    records, measured, times = [], [], []
    for number_of, one in enumerate(several):
        record = one if isinstance(one, Record) else Record(one)
        rows, *values = _read(record.data, list(formulas), number_of + 1)
        times.append(rows)
        measured.append(dict(zip(formulas, values)))
        records.append(
            (
                times[-1].tolist(),
                [values.tolist() for values in measured[-1].values()],
                _pairs(record.parameters, "parameters", '"mu": 0.5'),
                _starts(system, record.y0),
                None if record.t0 is None else number(record.t0, "t0"),
                _inputs(record.inputs),
            )
        )
    how = (
        loss,
        number(loss_scale, "loss_scale"),
        whole(search, "search", least=0),
        whole(segments, "segments", least=0),
        whole(most_runs, "most_runs"),
    )
    found = call_engine(
        _core.fit, core, records, observables, unknowns, list(extra.items()), how, made
    )
    at = list(zip(found.pop("records"), found.pop("observables")))
    columns = list(formulas)
    seen: list[dict[str, SeenPhases]] = [{} for _ in several]
    for (record_number, contact, column), in_data, at_fit in found["seen"]:
        seen[record_number][contact] = SeenPhases(columns[column], in_data, at_fit)
    found["seen"] = seen
    for name in ("model", "residuals", "rms", "sigma", "p_values", "phases_off"):
        values, by_record = found.pop(name), [{} for _ in several]  # type: ignore[var-annotated]
        for (record_number, column), value in zip(at, values):
            by_record[record_number][columns[column]] = value
        found[name] = by_record
    result = make_result(found, FitResult, t=times, data=measured, system=system)
    if not result.success:
        message = f"no minimum was found ({result.end}): begin nearer to it, or give bounds"
        warnings.warn(message, SolverWarning, stacklevel=2)
    return result


def _column(values: ArrayLike, name: str, count: int | None) -> Floats:
    """A column of numbers, of which NaN are missing."""
    found = np.asarray(values, dtype=np.float64)
    if found.ndim != 1 or (count is not None and len(found) != count):
        of = "" if count is None else f" of {count} values, one for each time"
        raise ValueError(f"the column {name!r} must be one row{of}; its shape is {found.shape}")
    return found
