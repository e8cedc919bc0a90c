r"""
Your own system: from equations to a bifurcation diagram
========================================================

A ball bounces on a table that shakes, a classical road to chaos (P. J. Holmes, Journal of Sound and
Vibration 84, 1982, 173–189). The steps here are the same for any system.

First come the equations. The ball of height :math:`h` flies freely. Where it meets the table
:math:`A\sin\omega t`, the relative velocity is reversed and a part :math:`r` of it is kept:

.. math::

   \ddot h = -g, \qquad
   h = A\sin\omega t: \; \dot h \to -r\,\dot h + (1+r) A\omega\cos\omega t .

States and parameters are symbols, and what happens at a bounce is a jump.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

g, r, omega = 9.81, 0.8, 2 * np.pi * 20
h, v = ss.states("h v")
(A,) = ss.parameters(A=0.4e-3)
bounce = ss.Jump(
    "bounce",
    when=h - A * np.sin(omega * ss.t),
    direction="falling",
    set={v: -r * v + (1 + r) * A * omega * np.cos(omega * ss.t)},
)
ball = ss.System({h: v, v: -g}, jumps=[bounce], period=2 * np.pi / omega)

# %%
# Second, run it and look. A run of twenty periods shows one bounce in each.

start = [5e-4, 0.2]
settled = ss.solve_ivp(ball, (0, 200 * ball.period), start).y[:, -1]
sol = ss.solve_ivp(ball, (0, 4 * ball.period), settled, t_eval=np.linspace(0, 0.2, 2000))
axes = plt.figure(figsize=(7.2, 2.4)).subplots()
axes.plot(1e3 * sol.t, 1e3 * sol.y[0], label="ball")
axes.plot(1e3 * sol.t, 0.4 * np.sin(omega * sol.t), color="C5", label="table")
axes.set(xlabel="time [ms]", ylabel="height [mm]")
axes.legend(ncols=2, loc="lower right", bbox_to_anchor=(1, 1))

# %%
# Third, find the periodic orbit. Its multipliers say that it is stable. A bounce multiplies areas
# in the phase plane by :math:`r^2`, which is the product of the multipliers.

orbit = ss.periodic_orbit(ball, start, transient=10)
print(f"{orbit.stability}, product of the multipliers {orbit.multipliers.prod().real:.12f}")
assert abs(orbit.multipliers.prod() - r**2) < 1e-9

# %%
# Fourth, follow it along a parameter, and sweep the attractor beside it. A sweep starts each value
# where the one before has ended. At the fold the bounce is at :math:`t = nT`, so the two branches
# have the velocities before and after it. In empty columns the ball comes to rest on the table by
# infinitely many bounces; a jump does not say what follows.

branch = ss.continuation(ball, A, (0.1e-3, 0.85e-3), start, transient=10, step=0.01)
values = np.linspace(0.4e-3, 0.85e-3, 151)
diagram = ss.bifurcation_diagram(ball, A, values, orbit.y, longest=20)



def at_whole_periods(k):
    system = ball.with_parameters(A=branch.parameter[k])
    t = branch.t[k]
    return ss.solve_ivp(system, (t, (t // ball.period + 1) * ball.period), branch.y[k]).y[1, -1]


axes = plt.figure().subplots()
for value, points in zip(diagram.parameter, diagram.points):
    axes.plot(np.full(len(points), 1e3 * value), points[:, 1], ".", color="C0", ms=1.5)
stable = np.array(branch.stability) == "stable"
velocity = np.array([at_whole_periods(k) for k in range(len(stable))])
for part, style, word in [(stable, "-", "stable"), (~stable, "--", "unstable")]:
    shown = np.where(part, velocity, np.nan)
    axes.plot(1e3 * branch.parameter, shown, style, color="C1", lw=1, label=word)
axes.plot([], [], ".", color="C0", label="attractor")
axes.set(xlabel="amplitude $A$ [mm]", ylabel="velocity at $t = nT$ [m/s]")
axes.legend(loc="upper left")

# %%
# Last, check a number. The orbit of one bounce a period exists from :math:`A\omega^2 = a` on, where
# :math:`a = \pi g (1-r)/(1+r)`. Its period doubles at
# :math:`A\omega^2 = \sqrt{a^2 + \bigl(2g(1+r^2)/(1+r)^2\bigr)^2}`.

a = np.pi * g * (1 - r) / (1 + r)
exact = {"fold": a, "flip": np.hypot(a, 2 * g * (1 + r**2) / (1 + r) ** 2)}
for row in branch.special:
    name, found = str(row["name"]), row["parameter"]
    print(f"{name} at {1e3 * found:.10f} mm, closed form {1e3 * exact[name] / omega**2:.10f} mm")
    assert abs(found - exact[name] / omega**2) < 1e-12
assert sorted(branch.special["name"]) == ["flip", "fold"]
plt.show()
