"""pydiffsol: equations in DiffSL, compiled by LLVM.

Side, start and first time are parameters, and the boundary is a stop.
"""

import time

import numpy
import pydiffsol

from orbits import systems

VERSIONS = [("pydiffsol", pydiffsol.version())]
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-11, 1e-12, 1e-13)


def curves(problem, system):
    # The best of its methods here. On belt_sensitive at 1e-8, esdirk34 and tr_bdf2 are 7 and 17
    # times slower with a thousand times the error, and bdf stops with too small a step.
    for tolerance in TOLERANCES:

        def build(tolerance=tolerance):
            return prepare(problem, tolerance, system)

        yield "pydiffsol tsit45", "rtol = atol", tolerance, build


def prepare(problem, tolerance, system):
    begin = time.perf_counter()
    size = len(system.start)
    ode = pydiffsol.Ode(code(problem), ode_solver=pydiffsol.tsit45, scalar_type=pydiffsol.f64)
    compiled = time.perf_counter() - begin
    ode.rtol = ode.atol = tolerance
    parameters = numpy.empty(size + 2)

    def slip(side, t, x, t_end):
        parameters[0], parameters[1], parameters[2:] = side, t, x
        # Time runs from 0 in every phase; the parameter has the rest.
        run = ode.solve(parameters, t_end - t)
        x[:] = run.ys[:, -1]
        end = run.ts[-1]
        return t + end if end < t_end - t else None

    def call():
        return systems.integrate(system, slip)

    return call, compiled


def code(problem):
    p, model = problem["parameters"], problem["model"]
    names = [f"x{i}" for i in range(len(problem["start"]))]
    starts = ", ".join(f"start{name} = 0.0" for name in names)
    inputs = f"in_i {{ side = 1.0, first = 0.0, {starts} }}\n"
    constants = "".join(f"{name.replace('_', '')} {{ {value!r} }}\n" for name, value in p.items())
    state = "u_i { " + ", ".join(f"{name} = start{name}" for name in names) + " }\n"
    if model == "moving":
        field, stop = "-side * speed", "x0 - sin(first + t)"
    elif model == "bracket":
        force = "(1.0 - unloading * x2 - unloadingrate * x3)"
        friction = f"side * mu0 * {force} / (1.0 + delta * side * (x1 - beltspeed))"
        field = (
            f"x1, -x0 - coupling * (couplingdamping * (x1 + x3) + x2 + {friction}), x3, "
            "-mobility * (x0 + couplingdamping * x1 + bracketstiffness * x2 + bracketdamping * x3)"
        )
        stop = "x1 - beltspeed"
    else:
        z = "(x0 - amplitude * sin(omega * (first + t)))" if model == "forced" else "x0"
        sign = "-" if model == "forced" else ""
        spring = f"{sign}{z} * (k1 - k2 * {z} * {z})"
        field = f"x1, ({spring} - side * mu0 / (1.0 + delta * side * (x1 - beltspeed))) / mass"
        stop = "x1 - beltspeed"
    return inputs + constants + state + f"F_i {{ {field} }}\nstop_i {{ {stop} }}\n"
