"""SciPy's solve_ivp: terminal events with a direction.

Right sides are compiled by numba if the system is. In a single process it is not, since compilation
takes longer than it saves there.
"""

import numpy
import scipy
from scipy.integrate import solve_ivp

from orbits import systems

VERSIONS = [("scipy", scipy.__version__), ("numpy", numpy.__version__)]
# Without Radau: at 1e-8 it takes 26 times as long as DOP853 on belt_sensitive for a fifth of the
# error. No problem here is stiff.
LADDERS = {
    "SciPy DOP853": ("DOP853", (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 3e-14)),
    "SciPy LSODA": ("LSODA", (1e-6, 1e-8, 1e-10, 1e-12, 3e-14)),
}


def curves(problem, system):
    for solver, (method, tolerances) in LADDERS.items():
        for tolerance in tolerances:

            def build(method=method, tolerance=tolerance):
                return prepare(system, method, tolerance)

            yield solver, "rtol = atol", tolerance, build


def prepare(system, method, tolerance):
    size = len(system.start)
    field, boundary = system.field, system.boundary

    if system.compiled:

        def right_side(t, x, side):
            out = numpy.empty(size)
            field(side, t, x, out)
            return out

    else:

        def right_side(t, x, side):
            out = [0.0] * size
            field(side, t, x.tolist(), out)
            return out

    def event(direction):
        def meets(t, x, side):
            return boundary(t, x)

        meets.terminal, meets.direction = True, direction
        return meets

    # A slip above ends when h falls, one below when it rises. The direction also keeps the start
    # from being an event.
    events = {1.0: event(-1.0), -1.0: event(1.0)}

    def slip(side, t, x, t_end):
        settings = {"method": method, "rtol": tolerance, "atol": tolerance}
        run = solve_ivp(
            right_side, (t, t_end), x, events=events[side], args=(side,), **settings
        )
        if run.status < 0:
            raise RuntimeError(run.message)
        x[:] = run.y[:, -1]
        return run.t[-1] if run.status == 1 else None

    def call():
        return systems.integrate(system, slip)

    return call, system.compile_seconds
