r"""
Chain of blocks: how slip begins to travel
==========================================

R. Burridge and L. Knopoff modelled earthquakes by a chain of blocks on a rough floor (Bulletin of
the Seismological Society of America 57, 1967, 341–371). One end is fixed, the other is pulled:

.. math::

   \ddot x_i = k\,(x_{i+1} - 2x_i + x_{i-1}) - F_i\,\mathrm{sgn}\,\dot x_i, \qquad
   x_0 = 0, \quad x_{n+1} = V t .

The last block moves first, when the spring has the force of its friction: :math:`k V t = F_n`.
Each block has a contact of its own. Wherever one changes, all that are at rest are decided
together.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss


def chain(strengths, k=2.0, speed=0.5):
    count = len(strengths)
    x = np.array(ss.states([f"x{i}" for i in range(1, count + 1)]))
    v = np.array(ss.states([f"v{i}" for i in range(1, count + 1)]))
    floor = [
        ss.Contact(f"floor{i + 1}", boundary=v[i], friction=strengths[i]) for i in range(count)
    ]
    springs = -k * (2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1))
    pull = np.zeros(count, dtype=object)
    pull[-1] = k * speed * ss.t
    rates = springs @ x + pull - np.array([one.friction for one in floor])
    return ss.System(dict(zip([*x, *v], [*v, *rates])), contacts=floor)


# %%
# Three blocks with friction 0.5, 0.4, 0.6 start at rest. The seven transitions until t = 20 were
# computed with 25 digits in multiprecision.

reference = [
    0.6,
    1.763632290375991657,
    3.071659800739963201,
    5.340319046456603490,
    5.755584775331159973,
    12.49732068462146958,
    12.79464896270307905,
]
three = ss.solve_ivp(chain([0.5, 0.4, 0.6]), (0, 20), np.zeros(6))

# %%
# Twelve equal blocks, of which each line is one. Dots mark where a block begins to slip: the first
# front travels along the chain to the fixed end.

count = 12
times = np.linspace(0, 40, 2000)
sol = ss.solve_ivp(chain([0.5] * count), (0, 40), np.zeros(2 * count), t_eval=times)
axes = plt.figure(figsize=(7.2, 4)).subplots()
for i in range(count):
    moves = sol.y[count + i] != 0
    place = i + 1 + 0.35 * sol.y[i]
    axes.plot(sol.t, place, color="C5", lw=0.8)
    axes.plot(sol.t, np.where(moves, place, np.nan), color="C0")
    starts = sol.transitions[
        (sol.transitions["kind"] == "stick exit")
        & (sol.transitions["contact"] == f"floor{i + 1}")
    ]
    axes.plot(starts["t"], i + 1 + 0.35 * starts["y"][:, i], "o", color="C1", ms=3)
axes.plot([], [], color="C0", label="slips")
axes.plot([], [], color="C5", label="sticks")
axes.set(xlabel="time [–]", ylabel="block, displaced", yticks=range(1, count + 1))
axes.legend(loc="upper left")

error = abs(three.transitions["t"] - reference).max()
print(f"first slip at t = {three.transitions['t'][0]:.15f}, exactly 0.6")
print(f"largest error of the seven times: {error:.1e}")
assert len(three.transitions) == 7 and error < 1e-12
plt.show()
