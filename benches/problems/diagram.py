"""A bifurcation diagram of the impact oscillator over the frequency of its drive.

At each of 101 values, the state carried on from one to the next, the least and the greatest place
at the flashes of a strobe. The package finds the attractor by itself. The peers' user lets
TRANSIENT periods pass, as many as errors as small take, and looks at the next two.
"""

import heyoka as hy
import numpy as np
import stickslip as ss
from scipy.integrate import solve_ivp

START, TRANSIENT = [0.0, 0.0], 64
D, WALL, R = 0.1, 1.0, 0.7
VALUES = np.linspace(0.6, 1.6, 101)


def with_stickslip(tol):
    x, v = ss.states("x v")
    w = ss.parameter("w", VALUES[0])
    impact = ss.Jump("impact", when=x - WALL, direction="rising", set={v: -R * v})
    rates = {x: v, v: np.cos(w * ss.t) - D * v - x}
    system = ss.System(rates, jumps=[impact], period=2 * ss.pi / w)

    def run():
        found = ss.bifurcation_diagram(system, w, VALUES, START, locate=False, rtol=tol)
        return np.array([[one[:, 0].min(), one[:, 0].max()] for one in found.points])

    return run


def with_scipy(tol):
    options = {"method": "DOP853", "rtol": tol, "atol": tol}

    def field(t, y, w):
        return [y[1], np.cos(w * t) - D * y[1] - y[0]]

    def impact(t, y, w):
        return y[0] - WALL

    impact.terminal, impact.direction = True, 1

    def period_later(y, w):
        t, end = 0.0, 2 * np.pi / w
        while True:
            sol = solve_ivp(field, (t, end), y, events=impact, args=(w,), **options)
            if sol.status == 0:
                return sol.y[:, -1]
            t, y = sol.t[-1], [WALL, -R * sol.y[1, -1]]

    def run():
        y, found = START, []
        for w in VALUES:
            for _ in range(TRANSIENT):
                y = period_later(y, w)
            points = [y := period_later(y, w) for _ in range(2)]
            places = [point[0] for point in points]
            found.append([min(places), max(places)])
        return np.array(found)

    return run


def with_heyoka(tol):
    def jumps(ta, sign):
        ta.state[:] = [WALL, -R * ta.state[1]]
        return True

    x, v = hy.make_vars("x", "v")
    field = [(x, v), (v, hy.cos(hy.par[0] * hy.time) - D * v - x)]
    impact = hy.t_event(x - WALL, callback=jumps, direction=hy.event_direction.positive)
    ta = hy.taylor_adaptive(field, START, tol=tol, t_events=[impact])

    def run():
        ta.state[:] = START
        found = []
        for w in VALUES:
            ta.pars[0], ta.time = w, 0.0
            ta.reset_cooldowns()
            ta.propagate_until(TRANSIENT * 2 * np.pi / w)
            places = []
            for k in (1, 2):
                ta.propagate_until((TRANSIENT + k) * 2 * np.pi / w)
                places.append(ta.state[0])
            found.append([min(places), max(places)])
        return np.array(found)

    return run


def reference():
    global TRANSIENT
    few, TRANSIENT = TRANSIENT, 300
    found = with_heyoka(1e-15)()
    TRANSIENT = few
    return found
