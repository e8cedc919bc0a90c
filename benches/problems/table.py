"""A ball on a table that shakes, with impacts that accumulate and rest: throws and first impacts.

h'' = -1 above the table A sin t; an impact gives back the part E of the speed of approach. The
table throws the ball where A sin t = 1. The ball bounces until it rests, once in each period. In
flight there is a closed form.
"""

import functools
import inspect
import json
import subprocess

import mpmath as mp
import numpy as np
import stickslip as ss
from scipy.integrate import solve_ivp

A, E = 1.5, 0.5
PERIODS = 100
T_END = 2 * np.pi * PERIODS
# Without a stop, the ball counts as at rest once it leaves an impact as slowly as this.
SLOW = 1e-6
# heyoka has no part: its event detection misses most of the short flights, and with steps as short
# as these it takes minutes.


def with_stickslip(tol):
    h, v = ss.states("h v")
    table = ss.Stop("table", gap=h - A * np.sin(ss.t), acts={v: 1}, restitution=E)
    ball = ss.System({h: v, v: -1.0}, stops=[table], start=[0, A])

    def run():
        found = ss.solve_ivp(ball, (0, T_END), rtol=tol).transitions
        thrown = np.flatnonzero(found["contact"] == "table.lift-off")
        return found["t"][np.stack([thrown, thrown + 1])]

    return run


def with_scipy(tol):
    options = {"method": "DOP853", "rtol": tol, "atol": tol}

    def flight(t, y):
        return [y[1], -1.0]

    def gap(t, y):
        return y[0] - A * np.sin(t)

    def carried(t, y):
        return [y[1], -A * np.sin(t)]

    def reaction(t, y):
        return 1 - A * np.sin(t)

    for event in (gap, reaction):
        event.terminal, event.direction = True, -1

    def run():
        t, y, rests, found = 0.0, [0.0, A], True, []
        while t < T_END:
            if rests:
                y = [A * np.sin(t), A * np.cos(t)]
                sol = solve_ivp(carried, (t, T_END), y, events=reaction, **options)
                t, y = sol.t[-1], sol.y[:, -1]
                if sol.status == 1:
                    found.append([t, np.nan])
                rests = False
                # At a double zero of the gap no step is too short for the event.
                first = 1e-3
            else:
                sol = solve_ivp(flight, (t, T_END), y, events=gap, first_step=first, **options)
                t, y = sol.t[-1], sol.y[:, -1]
                if sol.status == 1:
                    if np.isnan(found[-1][1]):
                        found[-1][1] = t
                    left = -E * (y[1] - A * np.cos(t))
                    y = [A * np.sin(t), A * np.cos(t) + left]
                    rests, first = left < SLOW, 0.1 * left / (1 - A * np.sin(t))
        return np.array(found).T

    return run


def by_debian(function):
    """A solver that runs in the Python of Debian, of whose packages Siconos is one."""

    @functools.wraps(function)
    def stated(step):
        _, _, source = inspect.getsource(function).partition("\n")
        code = f"{source}\nimport json\nprint(json.dumps({function.__name__}({step})))"

        def run():
            command = ["/usr/bin/python3", "-c", code]
            done = subprocess.run(command, check=True, capture_output=True, text=True)
            return np.array(json.loads(done.stdout))

        return run

    return stated


@by_debian
def with_siconos(step):
    import math

    import numpy as np
    import siconos.kernel as sk

    # In the frame of the table. A throw leaves it slowly, but far: no bounce does both.
    a, e, periods, slow, far = 1.5, 0.5, 100, 0.05, 0.01
    ball = sk.LagrangianLinearTIDS([0.0], [0.0], np.eye(1))
    contact = sk.Interaction(sk.NewtonImpactNSL(e), sk.LagrangianLinearTIR(np.eye(1)))
    model = sk.NonSmoothDynamicalSystem(0.0, 2 * math.pi * periods)
    model.insertDynamicalSystem(ball)
    model.link(contact, ball)
    times = sk.TimeDiscretisation(0.0, step)
    stepping = sk.TimeStepping(model, times, sk.MoreauJeanOSI(0.5), sk.LCP())
    thrown, hit = [], []
    left, speed, is_far = 0.0, 0.0, False
    while stepping.hasNextEvent():
        t = stepping.nextTime()
        ball.setFExtPtr(np.array([a * math.sin(t) - 1]))
        stepping.computeOneStep()
        if contact.lambda_(1)[0] > 0:
            if is_far and speed < slow:
                thrown.append(left)
                hit.append(t)
            left, speed, is_far = t, ball.velocity()[0], False
        else:
            is_far = is_far or ball.q()[0] > far
        stepping.nextStep()
    return [thrown, hit]


# Its time is that of a process. Shorter steps take minutes.
with_siconos.tolerances = (1e-2, 1e-3)


def reference():
    mp.mp.dps = 30
    thrown = mp.asin(1 / mp.mpf(A))
    place = lambda t: (
        1 + A * mp.cos(thrown) * (t - thrown) - (t - thrown) ** 2 / 2 - A * mp.sin(t)
    )
    # The gap grows as the cube of the time at first.
    hit = mp.findroot(place, (thrown + 3.5, thrown + 5.0), solver="anderson")
    times = [[float(t + 2 * mp.pi * k) for k in range(PERIODS)] for t in (thrown, hit)]
    return np.array(times)
