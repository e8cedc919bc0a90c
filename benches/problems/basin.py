"""Starts of a friction oscillator, 200 x 200, that lead to its fixed point, not to its cycle.

x'' = -x - D x' - sgn(w) (0.5 + 0.5 exp(-2 |w|)), w = x' - VD. The peers' user knows the system:
an orbit that sticks twice is on the stick-slip cycle, for stick forgets all. One within NEAR of the
fixed point, which attracts there, has come to it.
"""

import heyoka as hy
import numpy as np
import stickslip as ss
from scipy.integrate import solve_ivp

VD, D, LATEST, NEAR = 1.5, 0.1, 2000.0, 1e-2
REST = 0.5 + 0.5 * np.exp(-2.0 * VD)
SIZE = 200


def starts():
    x, v = [low + (np.arange(SIZE) + 0.5) / SIZE * 2 * half for low, half in ((-2, 2), (0, 1))]
    return np.stack(np.meshgrid(x, v), axis=-1).reshape(-1, 2)


def is_other(found, right):
    return found != right


def with_stickslip(tol):
    x, v = ss.states("x v")
    belt = ss.Contact("belt", boundary=v - VD)
    friction = belt.side * (0.5 + 0.5 * np.exp(-2 * belt.side * (v - VD)))
    system = ss.System({x: v, v: -x - D * v - friction}, contacts=[belt])

    def run(starts):
        found = ss.basins_of_attraction(system, starts, workers=1, rtol=tol)
        return np.array(found.kind)[found.reached] == "equilibrium"

    return run


def with_scipy(tol, method="DOP853"):
    options = {"method": method, "rtol": tol, "atol": tol}

    def slip(t, y, side):
        friction = side * (0.5 + 0.5 * np.exp(-2 * side * (y[1] - VD)))
        return [y[1], -y[0] - D * y[1] - friction]

    def stick(t, y, side):
        return [VD, 0.0]

    def meets(t, y, side):
        return y[1] - VD

    def rests(t, y, side):
        return np.hypot(y[0] - REST, y[1]) - NEAR

    def released(t, y, side):
        return abs(y[0] + D * VD) - 1

    meets.terminal = rests.terminal = released.terminal = True
    rests.direction, released.direction = -1, 1

    def is_at_rest(y):
        t, side, sticks = 0.0, 1 if y[1] > VD else -1, 0
        while True:
            meets.direction = -side
            field, events = (slip, [meets, rests]) if side else (stick, [released])
            sol = solve_ivp(field, (t, LATEST), y, events=events, args=(side,), **options)
            if sol.status == 0 or len(sol.t_events) == 2 and len(sol.t_events[1]):
                return sol.status == 1
            t, y = sol.t[-1], [sol.y[0, -1], VD]
            holds = side and abs(y[0] + D * VD) < 1
            sticks += holds
            if sticks == 2:
                return False
            side = 0 if holds else -np.sign(y[0] + D * VD)

    return lambda starts: np.array([is_at_rest(y) for y in starts])


def with_heyoka(tol):
    x, v = hy.make_vars("x", "v")
    rests = hy.t_event((x - REST) ** 2 + v**2 - NEAR**2, direction=hy.event_direction.negative)
    sides = {}
    for side in (1, -1):
        friction = side * (0.5 + 0.5 * hy.exp(-2.0 * side * (v - VD)))
        towards = hy.event_direction.negative if side > 0 else hy.event_direction.positive
        meets = hy.t_event(v - VD, direction=towards, cooldown=1e-5)
        field = [(x, v), (v, -x - D * v - friction)]
        sides[side] = hy.taylor_adaptive(field, [0.0, 0.0], tol=tol, t_events=[meets, rests])
    released = hy.t_event((x + D * VD) ** 2 - 1.0, direction=hy.event_direction.positive)
    field = [(x, hy.expression(VD)), (v, hy.expression(0.0))]
    sides[0] = hy.taylor_adaptive(field, [0.0, 0.0], tol=tol, t_events=[released])

    def is_at_rest(y):
        t, side, sticks = 0.0, 1 if y[1] > VD else -1, 0
        while True:
            ta = sides[side]
            ta.time, ta.state[:] = t, y
            ta.reset_cooldowns()
            outcome = int(ta.propagate_until(LATEST)[0])
            # It may report the start, where the speed is that of the belt.
            while outcome == -1 and ta.time - t < 1e-5:
                outcome = int(ta.propagate_until(LATEST)[0])
            if outcome not in (-1, -2) or outcome == -2:
                return outcome == -2
            t, y = ta.time, [ta.state[0], VD]
            holds = side and abs(y[0] + D * VD) < 1
            sticks += holds
            if sticks == 2:
                return False
            side = 0 if holds else -int(np.sign(y[0] + D * VD))

    return lambda starts: np.array([is_at_rest(y) for y in starts])
