r"""
Rocking block: impacts accumulate, then it stands
=================================================

A slender block that stands on a floor is tilted by :math:`\theta_0` and let go. It rocks from one
corner to the other (G. W. Housner, Bulletin of the Seismological Society of America 53, 1963,
403–417). For small angles,

.. math:: \ddot\theta = p^2(\theta - \alpha\,\mathrm{sgn}\,\theta),
   \qquad \theta = 0: \; \dot\theta \to r\,\dot\theta ,

where :math:`\alpha` is the angle at which it topples, and :math:`r` the part of its angular
velocity that an impact leaves. With :math:`\varphi = \theta/\alpha`, half a period lasts
:math:`2\,\mathrm{arcosh}(1/(1 - \varphi))/p`. From one to the next,

.. math:: 1 - (1 - \varphi_{n+1})^2 = r^2 \left(1 - (1 - \varphi_n)^2\right) .

There are infinitely many impacts until the block stands.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

p, toppling, kept, tilt = 2, 0.2, 0.9, 0.15
angle, rate = ss.states("angle rate")
foot = ss.Contact("foot", boundary=angle)
impact = ss.Jump("impact", when=angle, set={rate: kept * rate})
block = ss.System(
    {angle: rate, rate: p**2 * (angle - toppling * foot.side)}, contacts=[foot], jumps=[impact]
)

# %%
# The restoring moment does not vanish with the angle. So the floor holds the block where its
# impacts accumulate: ``at_pile_up="rest"`` goes on from there.

sol = ss.solve_ivp(
    block, (0, 12), [tilt, 0], at_pile_up="rest", t_eval=np.linspace(0, 12, 6001)
)
impacts = sol.transitions["t"][sol.transitions["contact"] == "impact"]
rest = sol.transitions["t"][sol.transitions["kind"] == "stick entry"][-1]

# Half a period takes as long as the rates of the impacts at its ends tell.
first = np.arccosh(1 / (1 - tilt / toppling)) / p
hits = kept ** (2 * np.arange(1, 2000)) * (1 - (1 - tilt / toppling) ** 2)
halves = 2 * np.arctanh(np.sqrt(hits)) / p
exact = first + halves.sum()

left, right = plt.figure().subplots(1, 2)
left.plot(sol.t, sol.y[0])
left.axvline(exact, color="C1", lw=1, ls="--")
left.set(xlabel="time [–]", ylabel=r"angle $\theta$ [rad]", xlim=(0, 12))
count = np.arange(1, len(impacts) + 1)
right.semilogy(count, exact - impacts, ".")
right.semilogy(count, halves[::-1].cumsum()[::-1][: len(impacts)], color="C1", lw=0.7)
right.set(xlabel="number of the impact", ylabel="time left until rest [–]")

print(f"{len(impacts)} impacts are followed, then rest at t = {rest:.12f}")
print(f"closed form:                             {exact:.12f}")
assert abs(exact - 11.040277103327) < 1e-12 and abs(rest - exact) < 1e-9
assert sol.status == 0 and np.all(sol.y[:, -1] == 0)
plt.show()
