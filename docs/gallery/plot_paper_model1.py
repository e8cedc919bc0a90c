r"""
Olejnik and Awrejcewicz, model 1: tangent points
================================================

P. Olejnik and J. Awrejcewicz (Nonlinear Dynamics 73, 2013, 723–736) study a block on a belt that a
double-well spring holds, their Eqs. (3)–(5):

.. math::

   \ddot x = x - x^3 - \frac{\mu_0\,\mathrm{sgn}\,v_r}{1 + |v_r|}, \qquad v_r = \dot x - v_p .

The block sticks where :math:`(x^3 - x)^2 < \mu_0^2`. The ends of these zones are the tangent
points. For :math:`\mu_0 = 1/(3\sqrt3)` they are, by Eq. (16),

.. math::

   \frac{2}{\sqrt3}\left\{\pm\cos\frac{\pi}{9},\; \pm\cos\frac{2\pi}{9},\;
   \pm\sin\frac{\pi}{18}\right\} .

A block that rides the belt to the right leaves it at the right end of its zone. On a belt that runs
to the left it leaves at the left end.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

x, v = ss.states("x v")
mu0, vp = ss.parameters(mu0=1 / (3 * np.sqrt(3)), vp=1.0)
belt = ss.Contact("belt", boundary=v - vp, friction=lambda side: mu0 / (1 + side * (v - vp)))
block = ss.System({x: v, v: x - x**3 - belt.friction}, contacts=[belt])
points = 2 / np.sqrt(3) * np.array([np.cos(np.pi / 9), np.cos(2 * np.pi / 9), np.sin(np.pi / 18)])
points = np.sort(np.concatenate([points, -points]))
zones = points.reshape(3, 2)

# %%
# A block is put on the belt in each of the three zones and followed until it slips. Its place
# there is a tangent point. The limit cycle, drawn in blue, does not stick, as the paper states.

axes = plt.figure().subplots()
times, exits = np.linspace(0, 3, 600), []
for low, high in zones:
    for speed in [-1, 1]:
        start = [0.5 * (low + high), speed]
        sol = ss.solve_ivp(block.with_parameters(vp=speed), (0, 3), start, t_eval=times)
        exits.append(sol.transitions["y"][0, 0])
    axes.plot(*sol.y, color="C5", lw=0.9)
cycle = ss.periodic_orbit(block, [0.5, 1.5])
sol = ss.solve_ivp(
    block, (0, cycle.period), cycle.y, t_eval=np.linspace(0, cycle.period, 2000)
)
axes.plot(*sol.y)
for low, high in zones:
    axes.plot([low, high], [1, 1], color="C1", lw=3, alpha=0.7)
axes.plot(points, np.ones(6), "o", color="C1")
for number, place in enumerate(points[::-1], start=1):
    axes.annotate(str(number), (place, 1), (0, 5), textcoords="offset points", ha="center")
axes.axhline(1, color="C1", lw=0.6, ls="--")
axes.set(xlabel="position $x_1$ [m]", ylabel="velocity $x_2$ [m/s]")

error = abs(np.array(exits) - points).max()
for number, (found, exact) in enumerate(zip(exits[::-1], points[::-1]), start=1):
    print(f"point {number}: stick ends at {found:+.15f}, Eq. (16) {exact:+.15f}")
print(f"largest difference {error:.1e}; phases of the cycle: {' '.join(sol.phases['mode'])}")
assert error < 1e-13
assert "S" not in sol.phases["mode"] and cycle.stability == "stable"
plt.show()
