r"""
Block on a block: two contacts that decide each other
=====================================================

A block lies on a driven block, which lies on a rough floor. The floor acts on the lower block, and
friction between the two acts on both. F. Pfeiffer and C. Glocker treat such contacts as one
complementarity problem (Multibody Dynamics with Unilateral Contacts, 1996). With the relative
velocities :math:`h_1 = \dot x_1` and :math:`h_2 = \dot x_2 - \dot x_1`,

.. math::

   \ddot x_1 &= -x_1 + \cos(0.8\,t) - 0.2\,\mathrm{sgn}\,h_1 + 0.15\,\mathrm{sgn}\,h_2, \\
   0.5\,\ddot x_2 &= -0.4\,x_2 - 0.15\,\mathrm{sgn}\,h_2 .

Where the lower block turns, its friction on the floor jumps. That jump can be enough to throw the
upper block off at the same instant.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

x1, v1, x2, v2 = ss.states("x1 v1 x2 v2")
floor = ss.Contact("floor", boundary=v1, friction=0.2)
top = ss.Contact("top", boundary=v2 - v1, friction=0.15)
blocks = ss.System(
    {
        x1: v1,
        v1: -x1 + np.cos(0.8 * ss.t) - floor.friction + top.friction,
        x2: v2,
        v2: (-0.4 * x2 - top.friction) / 0.5,
    },
    contacts=[floor, top],
)
times = np.linspace(0, 40, 4000)
sol = ss.solve_ivp(blocks, (0, 40), np.zeros(4), t_eval=times)

# %%
# Bands mark where the blocks move together. Dots mark where the turn of the lower block releases
# the upper one: the contact ``floor`` crosses and ``top`` leaves stick, at one time.

released = [
    row
    for row in sol.transitions
    if row["contact"] == "floor" and row["from_mode"].endswith("|S") and row["to_mode"][-1] != "S"
]
axes = plt.figure().subplots()
for phase in sol.phases:
    if phase["mode"].endswith("|S"):
        axes.axvspan(phase["t_start"], phase["t_end"], color="C5", alpha=0.2, lw=0)
axes.plot(sol.t, sol.y[1], label="lower block")
axes.plot(sol.t, sol.y[3], label="upper block")
axes.plot([row["t"] for row in released], [row["y"][1] for row in released], "ko")
axes.set(xlabel="time [–]", ylabel="velocity [–]", xlim=(0, 40), ylim=(-3.2, 4.2))
axes.legend(ncols=2, loc="upper left")

# %%
# The reference, of 30 events with 25 digits, was computed in multiprecision.

reference = [19.84532944356162407, 23.51416571206017705, 27.24309558838133865]
end = [1.705310546758702374, -0.1015536659194994229, 1.241037523528370290, -0.8835450846944176417]
error = abs(np.array([row["t"] for row in released]) - reference).max()
print(f"times of release: {', '.join(f'{row[0]:.12f}' for row in released)}")
print(f"largest error of these times {error:.1e}, of the end {abs(sol.y[:, -1] - end).max():.1e}")
assert len(released) == 3 and error < 1e-11
assert len(set(sol.transitions["t"])) == 30
assert abs(sol.y[:, -1] - end).max() < 1e-11
plt.show()
