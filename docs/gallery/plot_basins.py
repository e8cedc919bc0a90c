r"""
bSTAB: which start leads to which motion
========================================

M. Stender and N. Hoffmann measure basins of attraction by the share of starts that each attractor
takes (bSTAB, Nonlinear Dynamics 107, 2022, 1451–1468). One of their examples is a damped block on a
belt:

.. math::

   \ddot x + 0.1\,\dot x + x = -\mathrm{sgn}(v_r)\left(\tfrac12 + \tfrac12 e^{-2|v_r|}\right),
   \qquad v_r = \dot x - v_d .

Starts are drawn from :math:`[-2, 2] \times [0, 2]`. At the belt speed 1.5 their 5000 random starts
end in steady sliding with the share 0.304. At 1.85 and above all do.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

x, v = ss.states("x v")
(vd,) = ss.parameters(vd=1.5)
slip = v - vd
belt = ss.Contact("belt", boundary=slip, friction=lambda side: 0.5 + 0.5 * np.exp(-2 * side * slip))
block = ss.System({x: v, v: -x - 0.1 * v - belt.friction}, contacts=[belt])


def grid(count):
    """Centres of count × count cells."""
    cells = (np.arange(count) + 0.5) / count
    return np.stack(np.meshgrid(4 * cells - 2, 2 * cells), axis=-1)


def sliding(basins):
    rest = [name.startswith("equilibrium") for name in basins.kind]
    return float(basins.shares[rest].sum())


# %%
# Attractors are recognised where the orbit returns to what it has visited. Sliding is the one
# equilibrium; the other attractor is a stick–slip cycle.

starts = grid(70)
basins = ss.basins_of_attraction(block, starts, longest=2000, rtol=1e-8)
left, right = plt.figure().subplots(1, 2)
rest = np.array([name.startswith("equilibrium") for name in basins.kind])
left.pcolormesh(*starts.transpose(2, 0, 1), rest[basins.reached], cmap="cividis", rasterized=True)
cycle = ss.periodic_orbit(block, [2, 1])
sol = ss.solve_ivp(block, (0, cycle.period), cycle.y, t_eval=np.linspace(0, cycle.period, 800))
left.plot(*sol.y, color="w")
left.text(0.6, 0.5, "steady sliding", ha="center")
left.text(-1.9, 1.8, "stick–slip cycle", color="w")
left.set(xlabel="position $x$ [–]", ylabel=r"velocity $\dot x$ [–]", xlim=(-2, 2), ylim=(0, 2))

published = {1.1: 0, 1.25: 0.08, 1.4: 0.213, 1.55: 0.3544, 1.7: 0.4922, 1.85: 1}
found = []
for speed in published:
    system = block.with_parameters(vd=speed)
    found.append(sliding(ss.basins_of_attraction(system, grid(20), longest=2000, rtol=1e-8)))
right.plot(list(published), list(published.values()), "k_", ms=12, label="published")
right.plot(list(published), found, "o", label="grid of 20 × 20")
right.plot(1.5, sliding(basins), "s", color="C1", label="picture on the left")
right.plot(1.5, 0.304, "k_", ms=12)
right.set(xlabel="belt speed $v_d$ [–]", ylabel="share of steady sliding [–]")
right.legend()

# %%
# The published share of 5000 random starts has a standard error of 0.0065.

share = sliding(basins)
print(f"share of steady sliding at 1.5: {share:.4f}, published 0.304 with an error of 0.0065")
print(f"largest difference of the others: {max(abs(found - np.array([*published.values()]))):.3f}")
assert len(basins.kind) == 2 and basins.reached.min() >= 0
assert abs(share - 0.304) < 3 * 0.0065
assert found[0] == 0 and found[-1] == 1
plt.show()
