"""Event-exact integration of dry-friction (Filippov) systems.

>>> import stickslip as ss
>>> x, v = ss.states("x v")
>>> vp, = ss.parameters(vp=0.2)
>>> belt = ss.Contact("belt", boundary=v - vp)
>>> rate = -x - belt.side * 0.4 / (1 + belt.side * (v - vp))
>>> system = ss.System({x: v, v: rate}, contacts=[belt])
>>> ss.solve_ivp(system, (0, 50), [0.5, 0]).status
0
"""

from ._arguments import Options
from ._attractors import (
    Basins,
    BifurcationDiagram,
    ParameterMap,
    basins_of_attraction,
    bifurcation_diagram,
    parameter_map,
)
from ._basins import (
    BasinEntropy,
    BasinShares,
    EdgeState,
    LeastPushes,
    UncertaintyExponent,
    basin_shares,
    edge_state,
    least_push,
)
from ._core import __version__
from ._ensemble import Ensemble, ensemble
from ._errors import (
    InternalError,
    Interrupted,
    OptionError,
    SolverWarning,
    StickslipError,
    SystemError,
)
from ._exponents import DataSpectrum, LyapunovSpectrum, lyapunov_from_data, lyapunov_spectrum
from ._fit import FitResult, Record, SeenPhases, fit
from ._orbits import (
    BifurcationCurve,
    Branch,
    EquilibriumBranch,
    EquilibriumCurve,
    PeriodicOrbit,
    PoincareMap,
    Tangents,
    continuation,
    equilibrium_continuation,
    periodic_orbit,
    poincare_map,
    tangents,
)
from ._run import DenseOutput, Event, Solution, event, solve_ivp
from ._symbols import (
    Condition,
    Contact,
    Curve,
    DiscreteState,
    Expression,
    Input,
    Jump,
    Parameter,
    State,
    Stop,
    Switch,
    discrete,
    erf,
    parameter,
    parameters,
    pi,
    pulse,
    sawtooth,
    square,
    state,
    states,
    t,
    table,
    triangle,
)
from ._sympy import SympySystem, from_sympy
from ._system import System
from ._tables import Table

__all__ = [
    "BasinEntropy",
    "BasinShares",
    "Basins",
    "BifurcationCurve",
    "BifurcationDiagram",
    "Branch",
    "Condition",
    "Contact",
    "Curve",
    "DataSpectrum",
    "DenseOutput",
    "DiscreteState",
    "EdgeState",
    "Ensemble",
    "EquilibriumBranch",
    "EquilibriumCurve",
    "Event",
    "Expression",
    "FitResult",
    "Input",
    "InternalError",
    "Interrupted",
    "Jump",
    "LeastPushes",
    "LyapunovSpectrum",
    "OptionError",
    "Options",
    "Parameter",
    "ParameterMap",
    "PeriodicOrbit",
    "PoincareMap",
    "Record",
    "SeenPhases",
    "Solution",
    "SolverWarning",
    "State",
    "StickslipError",
    "Stop",
    "Switch",
    "SympySystem",
    "System",
    "SystemError",
    "Table",
    "Tangents",
    "UncertaintyExponent",
    "__version__",
    "basin_shares",
    "basins_of_attraction",
    "bifurcation_diagram",
    "continuation",
    "discrete",
    "edge_state",
    "ensemble",
    "equilibrium_continuation",
    "erf",
    "event",
    "fit",
    "from_sympy",
    "least_push",
    "lyapunov_from_data",
    "lyapunov_spectrum",
    "parameter",
    "parameter_map",
    "parameters",
    "periodic_orbit",
    "pi",
    "poincare_map",
    "pulse",
    "sawtooth",
    "solve_ivp",
    "square",
    "state",
    "states",
    "t",
    "table",
    "tangents",
    "triangle",
]
