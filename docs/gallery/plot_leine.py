r"""
Leine: stick–slip with friction that weakens with speed
=======================================================

A block on a belt sticks until the spring is stronger than friction, and then slips back.
R. I. Leine, D. H. van Campen, A. de Kraker and L. van den Steen use it to compare models of
friction (Nonlinear Dynamics 16, 1998, 41–54). With mass, stiffness and static friction of 1,

.. math::

   \ddot x + x = -\frac{\mathrm{sgn}\,v_r}{1 + 3\,|v_r|}, \qquad v_r = \dot x - v_b ,

and the belt speed :math:`v_b = 0.2`. The block sticks while :math:`|x| < 1`, so every stick phase
ends at :math:`x = 1` exactly.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

x, v = ss.states("x v")
(vb,) = ss.parameters(vb=0.2)
belt = ss.Contact("belt", boundary=v - vb, friction=lambda side: 1 / (1 + 3 * side * (v - vb)))
block = ss.System({x: v, v: -x - belt.friction}, contacts=[belt])

# %%
# All starts lead to one cycle. It is reached exactly, in finite time: stick forgets everything
# but the position. The second multiplier is therefore zero.

cycle = ss.periodic_orbit(block, [0, 0])
left, right = plt.figure().subplots(1, 2)
for start in [[0.2, 0], [-1.5, 0.5], [1.4, -0.8]]:
    sol = ss.solve_ivp(block, (0, 25), start, t_eval=np.linspace(0, 25, 2000))
    left.plot(*sol.y, color="C5", lw=0.8)
sol = ss.solve_ivp(
    block, (0, cycle.period), cycle.y, t_eval=np.linspace(0, cycle.period, 2000), events=v
)
left.plot(*sol.y)
left.axhline(0.2, color="C1", lw=0.8, ls="--")
left.text(1.4, 0.25, "belt", color="C1", ha="right")
left.set(xlabel="position $x$ [–]", ylabel=r"velocity $\dot x$ [–]")

# %%
# The belt speed decides how much of a period is spent in stick.

speeds = np.linspace(0.05, 1.5, 59)
diagram = ss.bifurcation_diagram(block, vb, speeds, [0, 0])
crosses = np.array(["+" in phases for phases in diagram.phases])
right.plot(speeds[~crosses], diagram.in_stick[~crosses], "o", ms=3, label="one slip a period")
right.plot(speeds[crosses], diagram.in_stick[crosses], "o", ms=3, label="overtakes the belt, too")
branch = ss.continuation(block.with_parameters(vb=0.5), vb, (0.4, 0.9), [0, 0])
change = branch.special["parameter"][0]
right.axvline(change, color="C5", lw=0.8, ls="--")
right.set(xlabel="belt speed $v_b$ [–]", ylabel="share of time in stick [–]", ylim=(0, 1))
right.legend()

entry = sol.transitions[sol.transitions["kind"] == "stick entry"]
exits = sol.transitions[sol.transitions["kind"] == "stick exit"]
slip = (entry["t"][0] - exits["t"][0]) % cycle.period
top = sol.y_events[0][:, 0].max()
print(f"period        {cycle.period:.12f}   (reference 12.001031294831)")
print(f"slip          {slip:.12f}    (reference  4.295999525480)")
print(f"largest x     {top:.12f}    (reference  1.133944676442)")
print(f"stick begins  {entry['y'][0, 0]:.12f}   (reference -0.541006353870)")
print(f"stick ends    {exits['y'][0, 0]:.12f}    (exactly 1)")
print(f"the block overtakes the belt from a belt speed of {change:.8f} on")
assert abs(cycle.period - 12.001031294831) < 2e-12
assert abs(slip - 4.295999525480) < 2e-12
assert abs(top - 1.133944676442) < 2e-12
assert abs(entry["y"][0, 0] + 0.541006353870) < 2e-12
assert abs(exits["y"][0, 0] - 1) < 1e-13
assert branch.special["name"].tolist() == ["switching-sliding"]
plt.show()
