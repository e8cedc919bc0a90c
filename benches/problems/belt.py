"""A block on a belt, held by a double-well spring: the times of its transitions.

x'' = x - x^3 - T(x' - VP) with friction T(w) = sgn(w) MU0/(1 + |w|). The reference is
data/references/belt_periodic.csv.
"""

import csv
import pathlib

import heyoka as hy
import numpy as np
import pydiffsol
import stickslip as ss
from scipy.integrate import solve_ivp

START, T_END = [0.1, 0.0], 30.0
MU0, VP = 0.19245008972987523, 0.4


def with_stickslip(tol):
    x, v = ss.states("x v")
    belt = ss.Contact("belt", boundary=v - VP)
    friction = belt.side * MU0 / (1 + belt.side * (v - VP))
    system = ss.System({x: v, v: x - x**3 - friction}, contacts=[belt])

    def run():
        return ss.solve_ivp(system, (0, T_END), START, rtol=tol).transitions["t"]

    return run


def with_scipy(tol):
    options = {"method": "DOP853", "rtol": tol, "atol": tol}

    def slip(t, y, side):
        return [y[1], y[0] - y[0] ** 3 - side * MU0 / (1 + side * (y[1] - VP))]

    def stick(t, y, side):
        return [VP, 0.0]

    def meets(t, y, side):
        return y[1] - VP

    def released(t, y, side):
        return abs(y[0] - y[0] ** 3) - MU0

    meets.terminal = released.terminal = True
    released.direction = 1

    def run():
        t, y, side, times = 0.0, START, -1, []
        while True:
            # The direction keeps the start from being an event.
            meets.direction = -side
            field, event = (slip, meets) if side else (stick, released)
            sol = solve_ivp(field, (t, T_END), y, events=event, args=(side,), **options)
            if sol.status == 0:
                return np.array(times)
            t, y = sol.t[-1], [sol.y[0, -1], VP]
            times.append(t)
            pull = y[0] - y[0] ** 3
            holds = side and abs(pull) < MU0
            side = 0 if holds else np.sign(pull)

    return run


def with_heyoka(tol):
    x, v = hy.make_vars("x", "v")
    force = x - x**3
    sides = {}
    for side in (1, -1):
        friction = side * MU0 / (1.0 + side * (v - VP))
        towards = hy.event_direction.negative if side > 0 else hy.event_direction.positive
        # It may report the start, where the speed is that of the belt.
        meets = hy.t_event(v - VP, direction=towards, cooldown=1e-5)
        field = [(x, v), (v, force - friction)]
        sides[side] = hy.taylor_adaptive(field, START, tol=tol, t_events=[meets])
    released = hy.t_event(force**2 - MU0**2, direction=hy.event_direction.positive)
    field = [(x, hy.expression(VP)), (v, hy.expression(0.0))]
    sides[0] = hy.taylor_adaptive(field, START, tol=tol, t_events=[released])

    def run():
        t, y, side, times = 0.0, np.array(START), -1, []
        while True:
            ta = sides[side]
            ta.time, ta.state[:] = t, y
            ta.reset_cooldowns()
            outcome = ta.propagate_until(T_END)[0]
            while int(outcome) == -1 and ta.time - t < 1e-5:
                outcome = ta.propagate_until(T_END)[0]
            if outcome == hy.taylor_outcome.time_limit:
                return np.array(times)
            t, y = ta.time, np.array([ta.state[0], VP])
            times.append(t)
            pull = y[0] - y[0] ** 3
            holds = side and abs(pull) < MU0
            side = 0 if holds else int(np.sign(pull))

    return run


def with_diffsol(tol):
    slip = """
        in_i { side = 1.0, x0 = 0.0, v0 = 0.0 }
        u_i { x = x0, v = v0 }
        F_i { v, x - x * x * x - side * MU0 / (1.0 + side * (v - VP)) }
        stop_i { v - VP }
    """
    stick = """
        in_i { side = 1.0, x0 = 0.0, v0 = 0.0 }
        u_i { x = x0, v = v0 }
        F_i { VP, 0.0 * v }
        stop_i { (x - x * x * x) * (x - x * x * x) - MU0 * MU0 }
    """
    odes = {}
    for side, code in ((1, slip), (-1, slip), (0, stick)):
        code = code.replace("MU0", repr(MU0)).replace("VP", repr(VP))
        odes[side] = pydiffsol.Ode(code, ode_solver=pydiffsol.tsit45, scalar_type=pydiffsol.f64)
        odes[side].rtol = odes[side].atol = tol

    def run():
        t, y, side, times = 0.0, START, -1, []
        while True:
            sol = odes[side].solve(np.array([side, *y]), T_END - t)
            if sol.ts[-1] >= T_END - t:
                return np.array(times)
            t, y = t + sol.ts[-1], [sol.ys[0, -1], VP]
            times.append(t)
            pull = y[0] - y[0] ** 3
            holds = side and abs(pull) < MU0
            side = 0 if holds else np.sign(pull)

    return run


def reference():
    table = pathlib.Path(__file__).parents[2] / "data/references/belt_periodic.csv"
    with open(table, encoding="utf-8") as file:
        return np.array([float(row["t"]) for row in csv.DictReader(file)])
