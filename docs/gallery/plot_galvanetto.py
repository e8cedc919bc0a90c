r"""
Galvanetto: two blocks on a belt
================================

U. Galvanetto and S. R. Bishop studied two coupled blocks on one belt as a model of a fault
(International Journal of Mechanical Sciences 36, 1994, 683–698). Each block has a spring to the
wall, a third spring joins them, and friction weakens with the slip speed. With numbers chosen here,

.. math::

   \ddot x_1 + x_1 + 1.2\,(x_1 - x_2) &= -F(1, \dot x_1 - v_b), \\
   \ddot x_2 + x_2 + 1.2\,(x_2 - x_1) &= -F(1.3, \dot x_2 - v_b), \qquad
   F(f, w) = \frac{f\,\mathrm{sgn}\,w}{1 + 3\,|w|} .

While both blocks ride the belt their distance :math:`d = x_2 - x_1` does not change. It alone
decides what follows, so each attractor is an orbit of a map of one number.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

x1, v1, x2, v2 = ss.states("x1 v1 x2 v2")
(vb,) = ss.parameters(vb=0.2)


def belt(name, velocity, strength):
    slip = velocity - vb
    return ss.Contact(name, boundary=slip, friction=lambda side: strength / (1 + 3 * side * slip))


first, second = belt("first", v1, 1.0), belt("second", v2, 1.3)
blocks = ss.System(
    {
        x1: v1,
        v1: -x1 - 1.2 * (x1 - x2) - first.friction,
        x2: v2,
        v2: -x2 - 1.2 * (x2 - x1) - second.friction,
    },
    contacts=[first, second],
)
start = [0, 0, 0.3, 0]


def distances(speed, duration):
    """Distances of the blocks at the entries into common stick, after a transient."""
    sol = ss.solve_ivp(blocks.with_parameters(vb=speed), (0, duration), start)
    entries = sol.transitions[sol.transitions["to_mode"] == "S|S"]
    entries = entries[entries["t"] > 0.4 * duration]
    return entries["y"][:, 2] - entries["y"][:, 0]


# %%
# Left: these distances over the belt speed. Right: each distance against the one before, on the
# chaotic attractor at :math:`v_b = 0.1`. The points fill a curve: the map has one dimension.

left, right = plt.figure().subplots(1, 2)
for speed in np.linspace(0.08, 0.24, 65):
    found = distances(speed, 400)
    left.plot(np.full(len(found), speed), found, ".", color="C0", ms=1)
left.set(xlabel="belt speed $v_b$ [–]", ylabel="distance $d$ in common stick [–]")
chaos = distances(0.1, 3000)
right.plot(chaos[:-1], chaos[1:], ".", ms=2)
right.plot([-0.35, 0.6], [-0.35, 0.6], "k", lw=0.6)
right.set(xlabel="distance $d_n$ [–]", ylabel="next distance $d_{n+1}$ [–]")

# %%
# The reference period comes from SciPy's DOP853 with events and modes by hand, in steps of at most
# 0.001.

cycle = ss.periodic_orbit(blocks, start)
print(f"period at a belt speed of 0.2: {cycle.period:.9f} (reference 11.896216218)")
assert abs(cycle.period - 11.896216218) < 1e-9
assert cycle.stability == "stable"
plt.show()
