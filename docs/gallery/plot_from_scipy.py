r"""
From SciPy to this package
==========================

A block on a belt (R. I. Leine and others, Nonlinear Dynamics 16, 1998, 41–54) with SciPy in two
ways, and then with this package:

.. math::

   \ddot x + x = -\frac{\mathrm{sgn}\,v_r}{1 + 3\,|v_r|}, \qquad v_r = \dot x - 0.2 .

The period of its stick–slip cycle is 12.001031294831.
"""

import matplotlib.pyplot as plt
import numpy as np
import scipy.integrate
import stickslip as ss

PERIOD = 12.001031294831


def period_of(t_events):
    return t_events[-1] - t_events[-2]


# %%
# The first way with SciPy replaces the sign by a steep smooth function. The equation becomes
# stiff, and its cycle is another one: friction is below its limit exactly where stick ends.


def turns(t, y, *_):
    return y[1]


turns.direction = 1


def smoothed(steepness):
    def field(t, y):
        slip = y[1] - 0.2
        sign = 2 / np.pi * np.arctan(steepness * slip)
        return [y[1], -y[0] - sign / (1 + 3 * abs(slip))]

    return scipy.integrate.solve_ivp(
        field, (0, 40), [0, 0], method="LSODA", events=turns, rtol=1e-8, atol=1e-10
    )


# %%
# The second way handles modes by hand: one field and one event for each, and rules for what
# follows. Each further contact doubles the number of cases.


def by_hand(t_end, state):
    t, mode, found = 0.0, -1, []
    while t < t_end:

        def field(t, y, mode):
            slip = mode * (y[1] - 0.2)
            return [y[1], -y[0] - mode / (1 + 3 * slip) if mode else 0.0]

        def leaves(t, y, mode):
            return mode * (y[1] - 0.2) if mode else 1 - abs(y[0])

        leaves.terminal, leaves.direction = True, -1
        run = scipy.integrate.solve_ivp(
            field, (t, t_end), state, args=(mode,), events=[leaves, turns], rtol=1e-10, atol=1e-12
        )
        found += list(run.t_events[1])
        t, state = run.t[-1], run.y[:, -1]
        if run.status == 0:
            break
        if mode:  # the block has the belt's speed: it sticks if the spring lets it
            state[1] = 0.2
            mode = 0 if abs(state[0]) <= 1 else -int(np.sign(state[0]))
        else:
            mode = -int(np.sign(state[0]))
    return found


# %%
# Here friction is a contact, and the call has SciPy's names. Stick, its end and the events are
# located to rounding.

x, v = ss.states("x v")
belt = ss.Contact("belt", boundary=v - 0.2, friction=lambda side: 1 / (1 + 3 * side * (v - 0.2)))
block = ss.System({x: v, v: -x - belt.friction}, contacts=[belt])
sol = ss.solve_ivp(
    block, (0, 40), [0, 0], t_eval=np.linspace(0, 40, 4000), events=[ss.event(v, direction=1)]
)

left, right = plt.figure().subplots(1, 2)
smooth = smoothed(1000)
left.plot(*smooth.y[:, smooth.t > 15], color="C1", label="smoothed, steepness 1000")
left.plot(*sol.y[:, sol.t > 15], color="C0", label="exact")
left.set(xlabel="position $x$ [–]", ylabel=r"velocity $\dot x$ [–]", ylim=(-0.9, 0.6))
left.legend(loc="upper center")
steepness = np.logspace(2, 6, 9)
errors = [abs(period_of(smoothed(each).t_events[0]) - PERIOD) for each in steepness]
by_modes = period_of(by_hand(40, [0.0, 0.0]))
hand, ours = abs(by_modes - PERIOD), abs(period_of(sol.t_events[0]) - PERIOD)
right.loglog(steepness, errors, "o-", color="C1", label="SciPy, smoothed")
right.axhline(hand, color="C2", label="SciPy, modes by hand")
right.axhline(max(ours, 1e-15), color="C0", label="stickslip")
right.set(xlabel="steepness [–]", ylabel="error of the period [–]", ylim=(1e-14, 1e3))
right.legend()

print(f"smoothed, steepness 1000: period {period_of(smooth.t_events[0]):.12f}")
print(f"modes by hand:            period {by_modes:.12f}, error {hand:.1e}")
print(f"stickslip:                period {period_of(sol.t_events[0]):.12f}, error {ours:.1e}")
assert ours < 2e-12
assert hand < 1e-6 and errors[2] > 0.5
plt.show()
