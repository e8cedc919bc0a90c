from collections.abc import Callable, Sequence
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Dense",
    "System",
    "__version__",
    "_unwind",
    "basin_entropy",
    "basin_shares",
    "basins",
    "bifurcation_diagram",
    "continuation",
    "edge_state",
    "equilibrium_continuation",
    "end_of",
    "ensemble",
    "fit",
    "least_push",
    "lyapunov_from_data",
    "lyapunov_spectrum",
    "parameter_map",
    "periodic_orbit",
    "poincare_map",
    "share_error",
    "solve",
    "tangents",
    "uncertainty_exponent",
]

__version__: str

_Start = tuple[float, Sequence[float]]
_Search = tuple[float | None, float | None, float, int | None]
_Along = tuple[str, Sequence[float]]
_Settings = dict[str, Any]
_Report = Callable[[float], None] | None
_Found = dict[str, Any]

@final
class System:
    def __new__(cls, name: str, text: str, settings: Sequence[tuple[str, float]]) -> System: ...
    @staticmethod
    def text_of(path: str) -> str: ...
    def with_sections(self, sections: list[tuple[str, int]]) -> System: ...
    def check_values(self, names: Sequence[str], values: NDArray[np.float64]) -> None: ...
    def reversed(self) -> System: ...
    @property
    def name(self) -> str: ...
    @property
    def states(self) -> list[str]: ...
    @property
    def parameters(self) -> list[tuple[str, float]]: ...
    @property
    def contacts_and_jumps(self) -> tuple[list[str], list[str]]: ...
    @property
    def discrete(self) -> list[str]: ...
    @property
    def starts(self) -> list[float | None]: ...
    @property
    def period(self) -> float | None: ...
    @property
    def depends_on_time(self) -> bool: ...
    def check(self, start: Sequence[float] | None) -> list[str]: ...

@final
class Dense:
    def at(self, times: NDArray[np.float64]) -> NDArray[np.float64]: ...

def _unwind() -> None: ...
def end_of(memory: str) -> tuple[float, list[float]]: ...
def solve(
    system: System,
    start: _Start,
    until: tuple[float, float],
    most: Sequence[int],
    t_eval: NDArray[np.float64] | None,
    dense_output: bool,
    settings: _Settings,
    memory: str | None,
    derivatives: Sequence[str],
    report: _Report,
) -> _Found: ...
def periodic_orbit(
    system: System,
    start: _Start,
    search: _Search,
    derivatives: Sequence[str],
    settings: _Settings,
) -> _Found: ...
def poincare_map(
    system: System,
    start: _Start,
    how: tuple[int, float, bool],
    settings: _Settings,
    report: _Report,
) -> _Found: ...
def continuation(
    system: System,
    start: _Start,
    search: _Search,
    range: tuple[str, float, float],
    how: tuple[float, int],
    also: tuple[str, float, float] | None,
    branches: int | None,
    settings: _Settings,
    report: _Report,
) -> _Found: ...
def tangents(
    system: System,
    start: _Start,
    contact: int,
    along: int | None,
    bounds: tuple[float, float] | None,
) -> _Found: ...
def share_error(reached: Sequence[int], columns: int | None, number: int) -> float: ...
def ensemble(
    system: System,
    starts: NDArray[np.float64],
    parameters: tuple[Sequence[str], NDArray[np.float64]],
    span: tuple[float, float],
    most: Sequence[int],
    t_eval: NDArray[np.float64] | None,
    how: tuple[int, bool],
    settings: _Settings,
    report: _Report,
) -> _Found: ...
def equilibrium_continuation(
    system: System,
    x: Sequence[float],
    transient: float | None,
    range: tuple[str, float, float],
    how: tuple[float, int],
    also: tuple[str, float, float] | None,
    settings: _Settings,
) -> _Found: ...
def fit(
    system: System,
    records: Sequence[
        tuple[
            Sequence[float],
            Sequence[Sequence[float]],
            Sequence[tuple[str, float]],
            Sequence[tuple[str, float]],
            float | None,
            Sequence[tuple[str, Sequence[float], Sequence[float]]],
        ]
    ],
    observables: Sequence[tuple[str, str, float | None]],
    unknowns: Sequence[tuple[str, float | None, float, float, bool]],
    extra: Sequence[tuple[str, float]],
    how: tuple[str, float, int, int, int],
    settings: _Settings,
) -> _Found: ...
def lyapunov_spectrum(
    system: System,
    start: _Start,
    span: tuple[float, float],
    settings: _Settings,
    report: _Report,
) -> _Found: ...
def bifurcation_diagram(
    system: System,
    x: Sequence[float] | None,
    along: _Along,
    how: tuple[float, float | None, str],
    settings: _Settings,
    report: _Report,
) -> _Found: ...
def parameter_map(
    system: System,
    x: Sequence[float] | None,
    plane: tuple[_Along, _Along],
    how: tuple[float, float | None, int],
    settings: _Settings,
    report: _Report,
) -> _Found: ...
def basin_entropy(reached: Sequence[int], shape: Sequence[int], side: int) -> _Found: ...
def uncertainty_exponent(reached: Sequence[int], shape: Sequence[int]) -> _Found: ...
def least_push(
    system: System,
    x: Sequence[float],
    directions: NDArray[np.float64],
    how: tuple[float, int, float, int],
    settings: _Settings,
    report: _Report,
) -> _Found: ...
def edge_state(
    system: System,
    states: tuple[Sequence[float], Sequence[float]],
    how: tuple[float, float, float, float],
    settings: _Settings,
    report: _Report,
) -> _Found: ...
def basin_shares(
    system: System,
    starts: NDArray[np.float64],
    along: _Along,
    how: tuple[float, int],
    settings: _Settings,
    report: _Report,
) -> _Found: ...
def basins(
    system: System,
    starts: NDArray[np.float64],
    how: tuple[float, float | None, int],
    settings: _Settings,
    report: _Report,
) -> _Found: ...
def lyapunov_from_data(
    series: NDArray[np.float64],
    dt: float,
    sum_of_all: float | None,
    options: dict[str, Any],
    report: _Report,
) -> _Found: ...
