"""A pressure relief valve at many flows q: an ensemble of orbits with impacts.

y' = v, v' = -KAPPA v - (y + DELTA) + p, p' = BETA (q - y sqrt(p)) for y > 0; an impact turns the
speed v into -R v. An orbit ends with its return number RETURNS, a greatest opening. F. Hegedus and
others time solvers of ensembles by this model (MPGOS, tutorial ImpactDynamics; the repository
nnagyd/ode_solver_tests). The peers' user writes the loop over the flows.
"""

import heyoka as hy
import numpy as np
import stickslip as ss
from scipy.integrate import solve_ivp
from tables import VALVE_ORBITS
from tables import VALVE_RETURNS as RETURNS

START, LATEST = [0.2, 0.0, 10.0], 1e4
KAPPA, DELTA, BETA, R = 1.25, 10.0, 20.0, 0.8


def starts():
    return np.linspace(0.5, 10, VALVE_ORBITS)


def is_other(found, right):
    """Whether openings differ. Orbits that take up errors exponentially make some differ."""
    return ~(abs(found - right) <= 1e-6)


def with_stickslip(tol):
    y, v, p = ss.states("y v p")
    q = ss.parameter("q", 1.0)
    seat = ss.Jump("seat", when=y, direction="falling", set={v: -R * v})
    rates = {y: v, v: -KAPPA * v - (y + DELTA) + p, p: BETA * (q - y * np.sqrt(p))}
    valve = ss.System(rates, jumps=[seat])
    last = ss.event(v, "falling", terminal=RETURNS)

    def run(flows):
        options = {"parameters": {q: flows}, "workers": 1, "rtol": tol}
        return ss.ensemble(valve, START, (0, LATEST), events=last, **options).y_end[0]

    return run


def with_scipy(tol):
    options = {"method": "DOP853", "rtol": tol, "atol": tol}

    def field(t, y, q):
        return [y[1], -KAPPA * y[1] - (y[0] + DELTA) + y[2], BETA * (q - y[0] * np.sqrt(y[2]))]

    def impact(t, y, q):
        return y[0]

    def returns(t, y, q):
        return y[1]

    impact.terminal, impact.direction, returns.direction = True, -1, -1

    def opening(q):
        t, y, found = 0.0, START, []
        while len(found) < RETURNS:
            # Longer than any flight.
            sol = solve_ivp(field, (t, t + 100), y, events=[impact, returns], args=(q,), **options)
            # The start, at rest, counts where the first step goes down.
            found += list(sol.y_events[1][sol.t_events[1] > 0])
            t, y = sol.t[-1], sol.y[:, -1]
            if sol.status == 1:
                y = [0.0, -R * y[1], y[2]]
        return found[RETURNS - 1][0]

    return lambda flows: np.array([opening(q) for q in flows])


def with_heyoka(tol):
    def jumps(ta, sign):
        ta.state[:2] = [0.0, -R * ta.state[1]]
        return True

    count = 0

    def counts(ta, sign):
        nonlocal count
        # The start counts, too.
        count += ta.time > 0
        return count < RETURNS

    y, v, p = hy.make_vars("y", "v", "p")
    rates = [(y, v), (v, -KAPPA * v - (y + DELTA) + p)]
    rates += [(p, BETA * (hy.par[0] - y * hy.sqrt(p)))]
    falling = hy.event_direction.negative
    impact = hy.t_event(y, callback=jumps, direction=falling)
    returns = hy.t_event(v, callback=counts, direction=falling)
    ta = hy.taylor_adaptive(rates, START, tol=tol, t_events=[impact, returns])

    def opening(q):
        nonlocal count
        count, ta.time, ta.state[:], ta.pars[0] = 0, 0.0, START, q
        ta.reset_cooldowns()
        ta.propagate_until(LATEST)
        return ta.state[0]

    return lambda flows: np.array([opening(q) for q in flows])
