"""A driven oscillator that hits a wall: the times of its impacts.

x'' + D x' + x = cos(W t) for x < WALL; an impact turns the speed v into -R v. Between impacts there
is a closed form.
"""

import heyoka as hy
import mpmath as mp
import numpy as np
import pydiffsol
import stickslip as ss
from scipy.integrate import solve_ivp

START, T_END = [0.0, 0.0], 200.0
D, W, WALL, R = 0.1, 0.8, 1.0, 0.7


def with_stickslip(tol):
    x, v = ss.states("x v")
    impact = ss.Jump("impact", when=x - WALL, direction="rising", set={v: -R * v})
    system = ss.System({x: v, v: np.cos(W * ss.t) - D * v - x}, jumps=[impact])

    def run():
        return ss.solve_ivp(system, (0, T_END), START, rtol=tol).transitions["t"]

    return run


def with_scipy(tol):
    options = {"method": "DOP853", "rtol": tol, "atol": tol}

    def field(t, y):
        return [y[1], np.cos(W * t) - D * y[1] - y[0]]

    def impact(t, y):
        return y[0] - WALL

    impact.terminal, impact.direction = True, 1

    def run():
        t, y, times = 0.0, START, []
        while True:
            sol = solve_ivp(field, (t, T_END), y, events=impact, **options)
            if sol.status == 0:
                return np.array(times)
            t, y = sol.t[-1], [WALL, -R * sol.y[1, -1]]
            times.append(t)

    return run


def with_heyoka(tol):
    times = []

    def jumps(ta, sign):
        times.append(ta.time)
        ta.state[:] = [WALL, -R * ta.state[1]]
        return True

    x, v = hy.make_vars("x", "v")
    field = [(x, v), (v, hy.cos(W * hy.time) - D * v - x)]
    impact = hy.t_event(x - WALL, callback=jumps, direction=hy.event_direction.positive)
    ta = hy.taylor_adaptive(field, START, tol=tol, t_events=[impact])

    def run():
        times.clear()
        ta.time, ta.state[:] = 0.0, START
        ta.reset_cooldowns()
        ta.propagate_until(T_END)
        return np.array(times)

    return run


def with_diffsol(tol):
    code = """
        u_i { x = 0.0, v = 0.0 }
        F_i { v, cos(W * t) - D * v - x }
        stop_i { x - WALL }
        reset_i { WALL, -R * v }
    """
    for name, value in {"WALL": WALL, "W": W, "D": D, "R": R}.items():
        code = code.replace(name, repr(value))
    ode = pydiffsol.Ode(code, ode_solver=pydiffsol.tsit45, scalar_type=pydiffsol.f64)
    ode.rtol = ode.atol = tol

    def run():
        sol = ode.solve(np.array([]), T_END)
        # The state after a reset is on the wall to the last bit, and leaves it.
        return sol.ts[(sol.ys[0] == WALL) & (sol.ys[1] < 0)]

    return run


def reference():
    # The impacts that were found, each made exact from the one before.
    mp.mp.dps = 40
    d, w = mp.mpf(D), mp.mpf(W)
    gain = 1 / mp.mpc(1 - w * w, d * w)
    rate, turn = d / 2, mp.sqrt(1 - d * d / 4)
    forced = lambda t: mp.re(gain * mp.expj(w * t))
    forced_speed = lambda t: mp.re(mp.mpc(0, w) * gain * mp.expj(w * t))
    t0, x0, v0 = mp.mpf(0), mp.mpf(START[0]), mp.mpf(START[1])
    times = []
    for near in with_stickslip(1e-13)():
        a = x0 - forced(t0)
        b = (v0 - forced_speed(t0) + rate * a) / turn

        def place(t):
            wave = a * mp.cos(turn * (t - t0)) + b * mp.sin(turn * (t - t0))
            return forced(t) + mp.exp(-rate * (t - t0)) * wave

        t1 = mp.findroot(lambda t: place(t) - WALL, mp.mpf(float(near)))
        t0, x0, v0 = t1, mp.mpf(WALL), -mp.mpf(R) * mp.diff(place, t1)
        times.append(float(t1))
    return np.array(times)
