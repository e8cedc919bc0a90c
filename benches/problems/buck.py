"""A buck converter with pulse-width control: voltage and current after 100 periods of its clock.

C v' = i - v/R, L i' = -v + E where the control GAIN (v - VREF) is below the ramp, -v where it is
above. The ramp rises from LOW to HIGH in each period. Times are in milliseconds. Between switchings
there is a closed form.
"""

import heyoka as hy
import mpmath as mp
import numpy as np
import pydiffsol
import stickslip as ss
from scipy.integrate import solve_ivp

R, C, L, E = 22.0, 0.047, 20.0, 24.0
GAIN, VREF, LOW, HIGH, PERIOD = 8.4, 11.3, 3.8, 8.2, 0.4
START, PERIODS = [12.0, 0.55], 100
T_END = PERIODS * PERIOD


def with_stickslip(tol):
    v, i = ss.states("v i")
    ramp = LOW + (HIGH - LOW) * ss.sawtooth("ramp", period=PERIOD)
    comparator = ss.Contact("comparator", boundary=GAIN * (v - VREF) - ramp)
    on = (1 - comparator.side) / 2
    rates = {v: (i - v / R) / C, i: (E * on - v) / L}
    system = ss.System(rates, contacts=[comparator])

    def run():
        return ss.solve_ivp(system, (0, T_END), START, rtol=tol, t_eval=[T_END]).y[:, -1]

    return run


def with_scipy(tol):
    options = {"method": "DOP853", "rtol": tol, "atol": tol}

    def field(t, y, clock, on):
        return [(y[1] - y[0] / R) / C, (E * on - y[0]) / L]

    def comparator(t, y, clock, on):
        return GAIN * (y[0] - VREF) - LOW - (HIGH - LOW) * (t - clock) / PERIOD

    comparator.terminal = True

    def run():
        y = np.array(START)
        for k in range(PERIODS):
            clock, t, end = k * PERIOD, k * PERIOD, (k + 1) * PERIOD
            on = comparator(t, y, clock, 0) < 0
            while t < end:
                # The direction keeps the last switching from being found again.
                comparator.direction = 1 if on else -1
                sol = solve_ivp(field, (t, end), y, events=comparator, args=(clock, on), **options)
                t, y, on = sol.t[-1], sol.y[:, -1], not on
        return y

    return run


def with_heyoka(tol):
    def switches(ta, sign):
        ta.pars[0] = 0.0 if sign > 0 else 1.0
        return True

    v, i = hy.make_vars("v", "i")
    on, clock = hy.par[0], hy.par[1]
    field = [(v, (i - v / R) / C), (i, (E * on - v) / L)]
    control = GAIN * (v - VREF) - LOW - (HIGH - LOW) * (hy.time - clock) / PERIOD
    comparator = hy.t_event(control, callback=switches)
    ta = hy.taylor_adaptive(field, START, tol=tol, t_events=[comparator])

    def run():
        ta.time, ta.state[:] = 0.0, START
        for k in range(PERIODS):
            ta.pars[:] = [GAIN * (ta.state[0] - VREF) < LOW, k * PERIOD]
            ta.reset_cooldowns()
            ta.propagate_until((k + 1) * PERIOD)
        return ta.state.copy()

    return run


def with_diffsol(tol):
    code = f"""
        in_i {{ on = 1.0, phase = 0.0, v0 = 0.0, i0 = 0.0 }}
        u_i {{ v = v0, i = i0 }}
        F_i {{ (i - v / {R}) / {C}, ({E} * on - v) / {L} }}
        stop_i {{ {GAIN} * (v - {VREF}) - {LOW} - {HIGH - LOW} * (phase + t) / {PERIOD} }}
    """
    ode = pydiffsol.Ode(code, ode_solver=pydiffsol.tsit45, scalar_type=pydiffsol.f64)
    ode.rtol = ode.atol = tol

    def run():
        y = np.array(START)
        for _ in range(PERIODS):
            phase, on = 0.0, GAIN * (y[0] - VREF) < LOW
            while phase < PERIOD:
                sol = ode.solve(np.array([on, phase, *y]), PERIOD - phase)
                is_whole = sol.ts[-1] >= PERIOD - phase
                phase = PERIOD if is_whole else phase + sol.ts[-1]
                y, on = sol.ys[:, -1], not on
        return y

    return run


def reference():
    # The switchings that were found, each made exact from the one before.
    mp.mp.dps = 40
    r, c, l, e, gain, vref, low, high, period = map(
        mp.mpf, (R, C, L, E, GAIN, VREF, LOW, HIGH, PERIOD)
    )
    a = mp.matrix([[-1 / (r * c), 1 / c], [-1 / l, 0]])
    found = switchings()
    t, y = mp.mpf(0), mp.matrix(START)

    def after(t, y, on, at):
        rest = mp.matrix([e * on, e * on / r])
        return rest + mp.expm(a * (at - t)) * (y - rest)

    for k in range(PERIODS):
        clock = k * period
        on = gain * (y[0] - vref) < low
        for near in found[(found > k * PERIOD + 1e-9) & (found < (k + 1) * PERIOD - 1e-9)]:
            control = lambda at: (
                gain * (after(t, y, on, at)[0] - vref) - low - (high - low) * (at - clock) / period
            )
            at = mp.findroot(control, mp.mpf(float(near)))
            t, y, on = at, after(t, y, on, at), not on
        t, y = clock + period, after(t, y, on, clock + period)
    return np.array([float(one) for one in y])


def switchings():
    v, i = ss.states("v i")
    ramp = LOW + (HIGH - LOW) * ss.sawtooth("ramp", period=PERIOD)
    comparator = ss.Contact("comparator", boundary=GAIN * (v - VREF) - ramp)
    rates = {v: (i - v / R) / C, i: (E * (1 - comparator.side) / 2 - v) / L}
    sol = ss.solve_ivp(ss.System(rates, contacts=[comparator]), (0, T_END), START)
    return sol.transitions["t"]
