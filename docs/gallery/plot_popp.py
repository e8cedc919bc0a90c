r"""
Popp: a belt oscillator over the belt speed
===========================================

K. Popp and co-workers studied the block on a belt with friction that falls and then rises with the
slip speed (N. Hinrichs, M. Oestreich and K. Popp, Journal of Sound and Vibration 216, 1998,
435–459). With numbers chosen here, without a drive and without dimensions it reads

.. math::

   \ddot x + x = -\mathrm{sgn}(v_r)\,\mu(v_r), \qquad v_r = \dot x - v_b, \qquad
   \mu(v) = \frac{0.3}{1+1.42\,|v|} + 0.1 + 0.01\,v^2 .

Steady sliding loses stability where the slope of friction vanishes, :math:`\mu'(v_b) = 0`:

.. math:: 0.02\,v_b\,(1 + 1.42\,v_b)^2 = 0.426 .

The bifurcation is subcritical: stick–slip and steady sliding are both stable above that speed.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

x, v = ss.states("x v")
(vb,) = ss.parameters(vb=0.5)
slip = v - vb
belt = ss.Contact(
    "belt",
    boundary=slip,
    friction=lambda side: 0.3 / (1 + 1.42 * side * slip) + 0.1 + 0.01 * slip**2,
)
block = ss.System({x: v, v: -x - belt.friction}, contacts=[belt])

# %%
# The branch starts from the stick–slip cycle at :math:`v_b = 0.5`. It turns where the cycle only
# touches the belt's speed. It comes back as an unstable cycle without stick, and ends in the Hopf
# bifurcation of steady sliding.

branch = ss.continuation(block, vb, (0.1, 3), [0, 0], step=0.05)
graze = branch.special[branch.special["name"] == "grazing-sliding"]["parameter"][0]
size = 0.5 * (branch.y_max[:, 0] - branch.y_min[:, 0])
stable = np.array([name == "stable" for name in branch.stability])

axes = plt.figure().subplots()
axes.plot(branch.parameter[stable], size[stable], label="cycle with stick, stable")
axes.plot(branch.parameter[~stable], size[~stable], "--", label="cycle without stick, unstable")
hopf = max(np.roots(np.polyadd(np.polymul([0.02, 0], np.poly1d([1.42, 1]) ** 2), [-0.426])).real)
axes.plot([0.1, hopf], [0, 0], "k--", lw=1)
axes.plot([hopf, 3], [0, 0], "k", label="steady sliding")
axes.plot(hopf, 0, "ko", clip_on=False)
axes.annotate("Hopf", (hopf, 0), (hopf - 0.1, 0.25), ha="right", arrowprops={"arrowstyle": "->"})
axes.annotate(
    "grazes the belt", (graze, graze), (2.35, 1.7), arrowprops={"arrowstyle": "->"}, va="top"
)
axes.set(xlabel="belt speed $v_b$ [–]", ylabel="half width of the cycle [–]", ylim=(0, 2.8))
axes.legend(loc="upper left")

# %%
# The branch ends in the Hopf bifurcation at the speed that the slope of friction predicts.

found = branch.special["parameter"][-1]
print(f"Hopf bifurcation at a belt speed of {found:.8f}, closed form {hopf:.8f}")
print(f"stick ends in a grazing bifurcation at a belt speed of {graze:.8f}")
assert abs(found - hopf) < 1e-9
assert branch.special["name"].tolist()[-2:] == ["grazing-sliding", "Hopf"]
assert branch.stops == ("range", "equilibrium") and stable[0] != stable[-1]
plt.show()
