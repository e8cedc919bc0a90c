r"""
A Stribeck law from a noisy record
==================================

A block on a belt, with friction that falls from a static value to a kinetic one:

.. math:: F(v_r) = F_k + (F_s - F_k) e^{-|v_r|/v_s}.

Which of the three values can a record of the position tell? On a slow belt the block sticks for most
of the time, and its slips are slow. A second, fast belt shows friction at high speeds, where it is
kinetic alone.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

x, v = ss.states("x v")
Fs, Fk, vs, speed = ss.parameters(Fs=0.9, Fk=0.55, vs=0.25, speed=0.1)
belt = ss.Contact("belt", boundary=v - speed)
slip = belt.side * (v - speed)
law = Fk + (Fs - Fk) * np.exp(-slip / vs)
block = ss.System(
    {x: v, v: -x - 0.1 * v - belt.side * law}, contacts=[belt], start=[0, 0.1], name="Stribeck"
)

# %%
# The record: 30 units of time of a slow belt, with noise of 2 % of the motion.
true = {"Fs": 1.0, "Fk": 0.5, "vs": 0.3}
times = np.linspace(0.1, 30, 300)
noise = np.random.default_rng(7)


def measured(speed):
    system = block.with_parameters(**true, speed=speed)
    run = ss.solve_ivp(system, (0, 30), [0, speed], t_eval=times)
    return {"t": times, "x": run.y[0] + noise.normal(0, 0.01, times.size)}


slow = measured(0.1)
alone = ss.fit(block, slow, [Fs, Fk, vs], {"x": x})
print(alone)
assert alone.success and np.abs((alone.x - list(true.values())) / alone.std_errors).max() < 4
alone.plot()

# %%
# The static value stands out: it is where the block lets go. The other two cannot be told apart. A
# slip sees their combination, the friction at the speeds that it passes. The model is even so curved
# within their errors that the intervals are doubtful, which `bend` says.
assert alone.correlations[1, 2] < -0.99 and alone.bend > 0.3

# %%
# With a record of a fast belt both are told apart: the slips pass more speeds.
fast = ss.Record(measured(1.5), parameters={"speed": 1.5}, y0={"x": 0, "v": 1.5})
both = ss.fit(block, [slow, fast], [Fs, Fk, vs], {"x": x})
print(both)
gain = alone.std_errors / both.std_errors
assert both.success and gain[1] > 10 and both.bend < 0.3

figure, axes = plt.subplots()
speeds = np.linspace(0, 1.5, 100)
for found, colour, label in ((alone, "C0", "slow belt"), (both, "C1", "both belts")):
    one, other, width = found.x
    draws = noise.multivariate_normal(found.x, found.covariance, 200)
    laws = draws[:, 1:2] + (draws[:, :1] - draws[:, 1:2]) * np.exp(-speeds / draws[:, 2:])
    low, high = np.percentile(laws, [2.5, 97.5], axis=0)
    axes.fill_between(speeds, low, high, color=colour, alpha=0.3, lw=0)
    axes.plot(speeds, other + (one - other) * np.exp(-speeds / width), color=colour, label=label)
axes.set_xlabel("slip speed")
axes.set_ylabel("friction")
axes.legend()
