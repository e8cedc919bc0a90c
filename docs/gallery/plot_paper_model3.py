r"""
Olejnik and Awrejcewicz, model 3: spectra through stick
=======================================================

Model 3 of the paper (Nonlinear Dynamics 73, 2013, 723–736) couples the block to a rotating bracket
that takes load off the contact. With the signs that the mechanics demand, Eqs. (27)–(28) read

.. math::

   \ddot x_1 &= -x_1 - \xi_1 \bigl[x_3 + N\mu\,\mathrm{sgn}\,v_r\bigr], \qquad
   \ddot x_3 = -\xi_3\,(x_1 + \xi_4 x_3), \\
   \mu &= \frac{\mu_0}{1 + \delta |v_r|}, \qquad N = 1 - \frac{\xi_6}{\mu_0} x_3, \qquad
   v_r = \dot x_1 - v_p .

Figs. 11 and 12 show a motion that is quasi-periodic and one that is chaotic. By the paper the
first has two exponents of about zero, and the second has a positive one.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss


def rig(xi1, xi3, xi4, mu0, xi6, delta, vp):
    x1, x2, x3, x4 = ss.states("x1 x2 x3 x4")
    load = 1 - xi6 / mu0 * x3
    belt = ss.Contact(
        "belt",
        boundary=x2 - vp,
        friction=lambda side: load * mu0 / (1 + delta * side * (x2 - vp)),
        normal_force=load,
    )
    rates = {
        x1: x2,
        x2: -x1 - xi1 * (x3 + belt.friction),
        x3: x4,
        x4: -xi3 * (x1 + xi4 * x3),
    }
    return ss.System(rates, contacts=[belt])


fig11 = rig(0.413, 1.069, 1.980, 0.707, 0.693, 0.101, 0.707)
fig12 = rig(0.222, 0.575, 3.333, 2.900, 6.766, 0.976, 0.689)

# %%
# A section shows the class: returns to :math:`x_1 = 0` fill a closed curve on a torus, and a cloud
# in chaos. The contact is lost where the load vanishes, which happens in the second motion only.

left, right = plt.figure().subplots(1, 2)
for axes, system, start in [
    (left, fig11, [0, 0, 0, -0.1]),
    (right, fig12, [0, -0.1, 0, -0.1]),
]:
    section = ss.event(ss.state("x1"), direction=1)
    settled = ss.solve_ivp(system, (0, 500), start).y[:, -1]
    returns = ss.poincare_map(system, section, settled, returns=800)
    axes.plot(returns.y[:, 2], returns.y[:, 3], ".", ms=1.5)
    axes.set(xlabel="$x_3$ [–] at $x_1 = 0$", ylabel="$x_4$ [–]")

# %%
# In stick the block cannot leave the belt's speed. One direction is lost there, and its exponent
# is minus infinity.

for name, system, start in [
    ("Fig. 11", fig11, [0, 0, 0, -0.1]),
    ("Fig. 12", fig12, [0, -0.1, 0, -0.1]),
]:
    found = ss.lyapunov_spectrum(system, start, transient=500, duration=3000)
    first, second, third, last = found.exponents
    errors = ", ".join(f"{error:.4f}" for error in found.std_errors[:3])
    print(f"{name}: {first:+.4f}, {second:+.4f}, {third:+.4f}, {last}; standard errors {errors}")
    assert last == -np.inf
    if name == "Fig. 11":
        assert abs(first) < 1e-3 and abs(second) < 1e-3 and third < -5e-3
    else:
        assert first > 5 * found.std_errors[0] and abs(second) < 2e-3
plt.show()
