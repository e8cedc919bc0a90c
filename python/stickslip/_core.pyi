from collections.abc import Sequence
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Dense",
    "System",
    "__version__",
    "basins",
    "bifurcation_diagram",
    "continuation",
    "lyapunov_from_data",
    "lyapunov_spectrum",
    "periodic_orbit",
    "poincare_map",
    "solve",
]

__version__: str

_Start = tuple[float, Sequence[float]]
_Search = tuple[float, float | None, float]

@final
class System:
    def __new__(cls, name: str, text: str, settings: Sequence[tuple[str, float]]) -> System: ...
    @staticmethod
    def text_of(path: str) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def states(self) -> list[str]: ...
    @property
    def parameters(self) -> list[tuple[str, float]]: ...
    @property
    def contacts_and_jumps(self) -> tuple[list[str], list[str]]: ...
    @property
    def start(self) -> tuple[float, list[float] | None, float | None, float | None]: ...
    @property
    def depends_on_time(self) -> bool: ...

@final
class Dense:
    @property
    def t_max(self) -> float: ...
    def at(self, times: NDArray[np.float64]) -> NDArray[np.float64]: ...

def solve(
    system: System,
    start: _Start,
    t_end: float,
    events: Sequence[tuple[str, int, int]],
    t_eval: NDArray[np.float64] | None,
    dense_output: bool,
    settings: dict[str, Any],
) -> dict[str, Any]: ...
def periodic_orbit(
    system: System, start: _Start, search: _Search, settings: dict[str, Any]
) -> dict[str, Any]: ...
def poincare_map(
    system: System,
    start: _Start,
    section: tuple[str, int],
    how: tuple[int, float, bool],
    settings: dict[str, Any],
) -> dict[str, Any]: ...
def continuation(
    system: System,
    start: _Start,
    search: _Search,
    range: tuple[str, float, float],
    how: tuple[float, int],
    settings: dict[str, Any],
) -> dict[str, Any]: ...
def lyapunov_spectrum(
    system: System, start: _Start, span: tuple[float, float], settings: dict[str, Any]
) -> dict[str, Any]: ...
def bifurcation_diagram(
    system: System,
    x: Sequence[float],
    along: tuple[str, Sequence[float]],
    longest: float,
    settings: dict[str, Any],
) -> dict[str, Any]: ...
def basins(
    system: System,
    starts: NDArray[np.float64],
    how: tuple[float, int],
    settings: dict[str, Any],
) -> dict[str, Any]: ...
def lyapunov_from_data(series: NDArray[np.float64], dt: float) -> dict[str, Any]: ...
