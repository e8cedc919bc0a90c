r"""
Relay feedback with many slides
===============================

K. H. Johansson, A. Rantzer and K. J. Åström showed that a relay in a feedback loop can switch fast
several times in each half period (Automatica 35, 1999, 539–552). The loop is

.. math::

   \dot x = \begin{pmatrix} -(2\zeta\omega + \lambda) & 1 & 0 \\
   -(2\zeta\omega\lambda + \omega^2) & 0 & 1 \\ -\lambda\omega^2 & 0 & 0 \end{pmatrix} x
   - \begin{pmatrix} 1 \\ -2 \\ 1 \end{pmatrix} \mathrm{sgn}\,x_1 .

Fast switching means sliding along :math:`x_1 = 0`. There :math:`x_2' = 2 x_2 + x_3` and
:math:`x_3' = -x_2`. The slide ends where :math:`|x_2| = 1`.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss


def loop(zeta, omega, lam):
    x = np.array(ss.states("x1 x2 x3"))
    relay = ss.Contact("relay", boundary=x[0])
    a = np.array(
        [
            [-(2 * zeta * omega + lam), 1, 0],
            [-(2 * zeta * omega * lam + omega**2), 0, 1],
            [-lam * omega**2, 0, 0],
        ]
    )
    return ss.System(dict(zip(x, a @ x - np.array([1, -2, 1]) * relay.side)), contacts=[relay])


# %%
# With :math:`\zeta = 0.05`, :math:`\omega = 25`, :math:`\lambda = 1` the loop slides seven times in
# each half period. Slides are shaded.

system = loop(0.05, 25, 1)
cycle = ss.periodic_orbit(system, [0, 0.5, 0])
entry = ss.solve_ivp(system, (0, 10), cycle.y).transitions
begin = entry[(entry["kind"] == "stick exit") & (entry["y"][:, 1] > 0)][0]
times = np.linspace(0, cycle.period, 4000)
sol = ss.solve_ivp(system, (0, cycle.period), begin["y"], t_eval=times)
slides = sol.phases[(sol.phases["mode"] == "S") & (sol.phases["t_end"] - sol.phases["t_start"] > 0)]

top, bottom = plt.figure(figsize=(7.2, 4.2)).subplots(2, sharex=True)
top.plot(sol.t, sol.y[0])
bottom.plot(sol.t, sol.y[1])
for axes in (top, bottom):
    for phase in slides:
        axes.axvspan(phase["t_start"], phase["t_end"], color="C1", alpha=0.3, lw=0)
bottom.axhline(1, color="k", lw=0.6, ls="--")
bottom.axhline(-1, color="k", lw=0.6, ls="--")
top.set(ylabel="$x_1$ [–]")
bottom.set(xlabel="time [–]", ylabel="$x_2$ [–]")

# %%
# Started at :math:`(0, \tfrac12, 0)`, sliding gives :math:`x_2 = \tfrac12 (1 + t) e^t`. The slide
# ends when :math:`(1 + t) e^t = 2`. Two cycles have periods known from other computations.

free = ss.solve_ivp(loop(-0.07, 10, 0.05), (0, 1), [0, 0.5, 0])
leaves = free.transitions["t"][0]
slow = ss.periodic_orbit(loop(1, 1, 1), [0, 0.5, 0])
print(f"the slide ends at t = {leaves:.12f}, (1 + t) exp(t) = {(1 + leaves) * np.exp(leaves):.12f}")
print(f"slides in a period: {len(slides)}, period {cycle.period:.6f} (reference 5.961837)")
print(f"ζ = ω = λ = 1: period {slow.period:.12f} (reference 8.860706454134)")
assert abs((1 + leaves) * np.exp(leaves) - 2) < 1e-12
assert len(slides) == 14 and abs(cycle.period - 5.961837) < 1e-6
assert abs(slow.period - 8.86070645413363) < 1e-12
plt.show()
