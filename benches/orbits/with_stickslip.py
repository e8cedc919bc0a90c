"""Systems from formulas, as a user of Python states them."""

import time

import numpy as np
import stickslip as ss

VERSIONS = [("stickslip", ss.__version__)]
TOLERANCES = tuple(10.0**-k for k in range(4, 16))
KINDS = {"crossing": "crossing", "stick entry": "entry", "stick exit": "exit"}


def curves(problem, system):
    for tolerance in TOLERANCES:

        def build(tolerance=tolerance):
            return prepare(problem, tolerance)

        yield "stickslip formulas", "rtol = atol", tolerance, build


def prepare(problem, tolerance):
    begin = time.perf_counter()
    system = formulas(problem)
    stated = time.perf_counter() - begin
    span, start = (problem["t_start"], problem["t_end"]), problem["start"]

    def call():
        sol = ss.solve_ivp(system, span, start, rtol=tolerance, atol=tolerance)
        found, call.steps = sol.transitions, len(sol.t) - 1
        pairs = zip(found["kind"].tolist(), found["t"].tolist())
        # Touches change no mode, and the peers do not report them.
        return [(KINDS[kind], t) for kind, t in pairs if kind in KINDS]

    return call, stated


def formulas(problem):
    p, model = problem["parameters"], problem["model"]
    if model == "moving":
        x = ss.state("x")
        edge = ss.Contact("edge", boundary=x - np.sin(ss.t))
        return ss.System({x: -p["speed"] * edge.side}, contacts=[edge])
    if model == "bracket":
        x1, x2, x3, x4 = ss.states("x1 x2 x3 x4")
        belt = ss.Contact("belt", boundary=x2 - p["belt_speed"])
        force = 1 - p["unloading"] * x3 - p["unloading_rate"] * x4
        slip = belt.side * (x2 - p["belt_speed"])
        friction = belt.side * p["mu0"] * force / (1 + p["delta"] * slip)
        pull = p["coupling_damping"] * (x2 + x4) + x3 + friction
        load = x1 + p["coupling_damping"] * x2
        load = load + p["bracket_stiffness"] * x3 + p["bracket_damping"] * x4
        rates = {x1: x2, x2: -x1 - p["coupling"] * pull, x3: x4, x4: -p["mobility"] * load}
        return ss.System(rates, contacts=[belt])
    x, v = ss.states("x v")
    belt = ss.Contact("belt", boundary=v - p["belt_speed"])
    friction = belt.side * p["mu0"] / (1 + p["delta"] * belt.side * (v - p["belt_speed"]))
    sign, z = 1, x
    if model == "forced":
        sign, z = -1, x - p["amplitude"] * np.sin(p["omega"] * ss.t)
    spring = sign * z * (p["k1"] - p["k2"] * z * z)
    return ss.System({x: v, v: (spring - friction) / p["mass"]}, contacts=[belt])
