r"""
Welander: a box of the ocean
============================

P. Welander found that heat and salt alone can make a column of the ocean oscillate (Dynamics of
Atmospheres and Oceans 6, 1982, 233–242). The box mixes with the deep water while its density
exceeds a threshold. The piecewise-smooth form is that of M. di Bernardo, C. J. Budd,
A. R. Champneys and P. Kowalczyk (Piecewise-smooth Dynamical Systems, 2008, Sect. 1.2):

.. math::

   \dot T = 1 - T - kT, \qquad \dot S = \tfrac12(1 - S) - kS, \qquad
   k = \begin{cases}
   1 & S - \tfrac45 T > \varepsilon, \\ 0 & S - \tfrac45 T < \varepsilon.
   \end{cases}

With mixing the box tends to :math:`(T, S) = (\tfrac12, \tfrac13)`. That equilibrium lies on the
threshold at :math:`\varepsilon = \tfrac13 - \tfrac25 = -\tfrac1{15}`. The oscillation ends there.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

T, S = ss.states("T S")
(eps,) = ss.parameters(eps=-0.01)
mixing = ss.Contact("mixing", boundary=S - 0.8 * T - eps)
k = mixing.by_side(0, 1)
ocean = ss.System({T: 1 - T - k * T, S: 0.5 * (1 - S) - k * S}, contacts=[mixing])

# %%
# Left: the oscillation for three thresholds. Right: its period along the branch, which grows
# without bound towards the equilibrium with mixing.

left, right = plt.figure().subplots(1, 2)
for color, value in enumerate([-0.01, -0.03, -0.06]):
    system = ocean.with_parameters(eps=value)
    cycle = ss.periodic_orbit(system, [0.9, 0.6])
    times = np.linspace(0, cycle.period, 600)
    sol = ss.solve_ivp(system, (0, cycle.period), cycle.y, t_eval=times)
    left.plot(*sol.y, label=rf"$\varepsilon$ = {value}")
    edge = np.array([0.45, 0.95])
    left.plot(edge, 0.8 * edge + value, color=f"C{color}", lw=0.7, ls="--")
left.plot(1 / 2, 1 / 3, "ko")
left.annotate("mixed equilibrium", (1 / 2, 1 / 3), (0.56, 0.33), va="center")
left.set(xlabel="temperature $T$ [–]", ylabel="salinity $S$ [–]")
left.legend()

branch = ss.continuation(ocean, eps, (-0.09, -0.001), [0.9, 0.6])
right.plot(branch.parameter, branch.period)
right.axvline(-1 / 15, color="k", lw=0.8, ls="--")
right.text(-1 / 15 + 0.001, 0.5, r"$-\frac{1}{15}$", fontsize=12)
right.set(xlabel=r"threshold $\varepsilon$ [–]", ylabel="period [–]", ylim=(0, 4.5))


# %%
# Below the threshold the box comes to rest. Bisection between rest and oscillation finds it.


def oscillates(value):
    sol = ss.solve_ivp(ocean.with_parameters(eps=value), (0, 200), [0.9, 0.6])
    return len(sol.transitions) > 4


low, high = -0.09, -0.01
while high - low > 1e-12:
    middle = 0.5 * (low + high)
    low, high = (low, middle) if oscillates(middle) else (middle, high)
print(f"the oscillation ends at ε = {high:.10f}, exactly -1/15 = {-1 / 15:.10f}")
assert abs(high + 1 / 15) < 1e-9
plt.show()
