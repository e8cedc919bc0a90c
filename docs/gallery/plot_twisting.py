r"""
Twisting control: infinitely many switches in finite time
=========================================================

The twisting controller of A. Levant brings a mass to rest in finite time (International Journal of
Control 58, 1993, 1247–1263):

.. math:: \ddot x = -10\,\mathrm{sgn}\,x - 3\,\mathrm{sgn}\,\dot x .

Both signs switch. On the way out the mass brakes with 13, on the way back it gains speed with 7.
From an excursion :math:`X` the next one is :math:`\tfrac{7}{13} X`, and the times shrink by
:math:`q = \sqrt{7/13}`. Infinitely many switches end at

.. math::

   t_\infty = \frac{v_0}{13} + \frac{1}{1-q}
   \left(\sqrt{\tfrac{2}{7} X} + \tfrac{1}{13}\sqrt{14 X}\right),
   \qquad X = x_0 + \frac{v_0^2}{26} .
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

x, v = ss.states("x v")
place, speed = ss.Contact("place", boundary=x), ss.Contact("speed", boundary=v)
mass = ss.System({x: v, v: -10 * place.side - 3 * speed.side}, contacts=[place, speed])

# %%
# The solver locates the point where the switches pile up. With ``at_pile_up="rest"`` the run goes
# on at rest from there; by default it ends with status -1 and says why.

sol = ss.solve_ivp(mass, (0, 15), [10, 10], at_pile_up="rest", t_eval=np.linspace(0, 15, 6000))
rest = sol.transitions[sol.transitions["kind"] == "stick entry"]["t"][-1]
largest = 10 + 10**2 / 26
q = np.sqrt(7 / 13)
exact = 10 / 13 + (np.sqrt(2 / 7 * largest) + np.sqrt(14 * largest) / 13) / (1 - q)

left, right = plt.figure().subplots(1, 2)
left.plot(*sol.y)
left.plot(0, 0, "o", color="C1")
left.set(xlabel="position $x$ [–]", ylabel=r"velocity $\dot x$ [–]")
switches = sol.transitions["t"][sol.transitions["t"] < rest]
right.semilogy(np.arange(1, len(switches) + 1), rest - switches, ".")
right.set(xlabel="number of the switch", ylabel="time left until rest [–]")

print(f"{len(switches)} switches are followed, then rest at t = {rest:.12f}")
print(f"closed form:                             {exact:.12f}")
assert abs(rest - exact) < 1e-10
assert sol.status == 0 and np.all(sol.y[:, -1] == 0)
plt.show()
