"""The analyses, and what they return."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._run import Event, Floats, array, called, event, settings, state, structured
from ._symbols import Expression, Parameter, number
from ._system import System


class _Result:
    """A result of named arrays."""

    def __repr__(self) -> str:
        shown = []
        for one in fields(self):  # type: ignore[arg-type]
            value = getattr(self, one.name)
            if isinstance(value, np.ndarray) and value.size > 6:
                value = f"<{' × '.join(map(str, value.shape))}>"
            elif isinstance(value, (list, tuple)) and len(value) > 6:
                value = f"<{len(value)}>"
            shown.append(f"{one.name}={value}")
        return f"{type(self).__name__}({', '.join(shown)})"


@dataclass(frozen=True, repr=False)
class PeriodicOrbit(_Result):
    """A periodic orbit: at time `t` it is at `y`."""

    t: float
    y: Floats
    period: float
    residual: float
    family: int
    monodromy: Floats
    multipliers: NDArray[np.complex128]
    stability: str


def _search(system: System, transient: float, period: Any, periods: int, longest: float) -> Any:
    drive = system.period if system._core.depends_on_time else None
    if period is not None:
        period = number(period, "period")
    elif drive is not None:
        period = periods * drive
    elif system._core.depends_on_time:
        raise ValueError("the system depends on time: give its period")
    return float(transient), period, float(longest)


def periodic_orbit(
    system: System,
    y0: ArrayLike | None = None,
    *,
    t0: float = 0.0,
    period: float | None = None,
    periods: int = 1,
    transient: float = 200.0,
    longest: float = 100.0,
    **options: Any,
) -> PeriodicOrbit:
    """The periodic orbit that the run from `y0` comes to, refined by shooting.

    Of a driven system it takes so many `periods` of the drive. Otherwise its `period` is found, or
    is near the one given; `longest` is the time within which the run must come back.
    """
    search = _search(system, transient, period, periods, longest)
    start = (float(t0), state(system, y0))
    found = called(_core.periodic_orbit, system._core, start, search, settings(**options))
    return PeriodicOrbit(**found)


@dataclass(frozen=True, repr=False)
class PoincareMap(_Result):
    """Returns to a section: a row of `y` for each; `derivatives` of the map, if asked for."""

    t: Floats
    y: Floats
    mode: list[str]
    derivatives: Floats | None


def poincare_map(
    system: System,
    section: Event | Expression,
    y0: ArrayLike | None = None,
    *,
    returns: int = 100,
    t0: float = 0.0,
    longest: float = 1000.0,
    derivative: bool = False,
    **options: Any,
) -> PoincareMap:
    """The next returns to a section, which is an event: `ss.event(v, direction=1)`."""
    watched = section if isinstance(section, Event) else event(section)
    found = called(
        _core.poincare_map,
        system._core,
        (float(t0), state(system, y0)),
        (watched.function.text, watched.direction),
        (int(returns), float(longest), bool(derivative)),
        settings(**options),
    )
    if not derivative:
        found["derivatives"] = None
    return PoincareMap(**found)


@dataclass(frozen=True, repr=False)
class Branch(_Result):
    """A branch of periodic orbits; `special` is a structured array of its bifurcations."""

    parameter: Floats
    period: Floats
    t: Floats
    y: Floats
    multipliers: list[NDArray[np.complex128]]
    stability: list[str]
    phases: list[str]
    special: NDArray[np.void]
    stops: tuple[str, str]


def _name(parameter: str | Parameter) -> str:
    return parameter.name if isinstance(parameter, Parameter) else str(parameter)


def continuation(
    system: System,
    parameter: str | Parameter,
    bounds: tuple[float, float],
    y0: ArrayLike | None = None,
    *,
    t0: float = 0.0,
    period: float | None = None,
    periods: int = 1,
    transient: float = 200.0,
    longest: float = 100.0,
    step: float = 0.02,
    most_points: int = 1000,
    **options: Any,
) -> Branch:
    """Follows the periodic orbit that `periodic_orbit` finds along a parameter, both ways."""
    low, high = (float(value) for value in array(bounds, "bounds"))
    found = called(
        _core.continuation,
        system._core,
        (float(t0), state(system, y0)),
        _search(system, transient, period, periods, longest),
        (_name(parameter), low, high),
        (float(step), int(most_points)),
        settings(**options),
    )
    names = found.pop("special_name")
    columns = [
        (name, found.pop(f"special_{name}")) for name in ("parameter", "uncertainty", "period")
    ]
    special = structured([("name", names), *columns], len(names), 0)
    found["stops"] = tuple(found["stops"])
    return Branch(special=special, **found)


@dataclass(frozen=True, repr=False)
class LyapunovSpectrum(_Result):
    """Lyapunov exponents; -inf where stick takes a direction to zero."""

    exponents: Floats
    std_errors: Floats
    uncertainties: Floats
    duration: float
    defect: float
    stick_entries: int
    stick_fraction: float


def lyapunov_spectrum(
    system: System,
    y0: ArrayLike | None = None,
    *,
    t0: float = 0.0,
    transient: float = 200.0,
    duration: float = 2000.0,
    **options: Any,
) -> LyapunovSpectrum:
    """The Lyapunov exponents from the equations, through slip, stick and jumps."""
    found = called(
        _core.lyapunov_spectrum,
        system._core,
        (float(t0), state(system, y0)),
        (float(transient), float(duration)),
        settings(**options),
    )
    return LyapunovSpectrum(**found)


@dataclass(frozen=True, repr=False)
class BifurcationDiagram(_Result):
    """The attractor at each value of a parameter; `points[k]` are those of the section."""

    parameter: Floats
    kind: list[str]
    phases: list[str]
    in_stick: Floats
    points: list[Floats]


def bifurcation_diagram(
    system: System,
    parameter: str | Parameter,
    values: ArrayLike,
    y0: ArrayLike | None = None,
    *,
    longest: float = 2000.0,
    **options: Any,
) -> BifurcationDiagram:
    """Follows an attractor through values of a parameter, in their order, from t = 0 on."""
    found = called(
        _core.bifurcation_diagram,
        system._core,
        state(system, y0),
        (_name(parameter), array(values, "values").tolist()),
        float(longest),
        settings(**options),
    )
    return BifurcationDiagram(**found)


@dataclass(frozen=True, repr=False)
class Basins(_Result):
    """Which attractor each start leads to, by its number in the lists."""

    reached: NDArray[np.int64]
    kind: list[str]
    phases: list[str]
    in_stick: Floats
    points: list[Floats]

    @property
    def shares(self) -> Floats:
        """The part of the starts that each attractor takes."""
        counts = np.bincount(self.reached.ravel(), minlength=len(self.kind))
        return counts / max(1, self.reached.size)


def basins_of_attraction(
    system: System,
    starts: ArrayLike | Sequence[ArrayLike],
    *,
    longest: float = 2000.0,
    workers: int = -1,
    **options: Any,
) -> Basins:
    """Which attractor each of many starts leads to, from t = 0 on.

    `starts` is an array whose last axis is the state, as `np.stack(np.meshgrid(x, v), axis=-1)`;
    `reached` has the shape of the others. -1 workers are all cores.
    """
    given = np.asarray(starts)
    if given.ndim == 0 or given.shape[-1] != len(system.states):
        raise ValueError(f"the last axis of starts must be the {len(system.states)} states")
    rows = array(given.reshape(-1, given.shape[-1]), "starts", 2)
    found = called(
        _core.basins,
        system._core,
        rows,
        (float(longest), max(0, int(workers))),
        settings(**options),
    )
    found["reached"] = found["reached"].reshape(given.shape[:-1])
    return Basins(**found)


@dataclass(frozen=True, repr=False)
class DataSpectrum(_Result):
    """Lyapunov exponents of a series; `status` says which of them mean something."""

    exponents: Floats
    std_errors: Floats
    status: list[str]
    dimension: int


def lyapunov_from_data(series: ArrayLike, dt: float = 1.0) -> DataSpectrum:
    """The Lyapunov exponents of a measured series: a row for each point, `dt` between two."""
    given = np.asarray(series)
    rows = array(given[:, None] if given.ndim == 1 else given, "series", 2)
    return DataSpectrum(**called(_core.lyapunov_from_data, rows, number(dt, "dt")))
