r"""
Ball on a table: thrown, chattering, carried
============================================

A ball lies on a table that shakes as :math:`A\sin t`, in units in which gravity is 1. The table
carries it while the reaction :math:`1 - A\sin t` pushes, and throws it where that vanishes, at
:math:`\sin t = 1/A`. If the ball comes to rest within the period, the next one is the same: gap and
rate are forgotten, and all multipliers are zero. J. M. Luck and A. Mehta described such chatter
(Physical Review E 48, 1993, 3988–3997).
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

height, speed = ss.states("height speed")
size, kept = ss.parameters(size=1.5, kept=0.5)
table = ss.Stop("table", gap=height - size * np.sin(ss.t), acts={speed: 1}, restitution=kept)
ball = ss.System(
    {height: speed, speed: -1.0}, stops=[table], start=[0, 1.5], period=2 * ss.pi
)

# %%
# Left: one period of a hundred. Right: in a period the ball is carried for the shorter a time the
# larger the amplitude is (points). It would leave the table at :math:`\arcsin(1/A)` (line).

times = np.linspace(0, 200 * np.pi, 200001)
sol = ss.solve_ivp(ball, (0, 200 * np.pi), t_eval=times)
name, at = sol.transitions["contact"], sol.transitions["t"]
thrown, landed = at[name == "table.lift-off"], at[name == "table.landing"][1:]
late = sol.t > 198 * np.pi

left, right = plt.figure().subplots(1, 2)
since = sol.t[late] - 198 * np.pi
left.plot(since, 1.5 * np.sin(since), color="gray", lw=0.7, label="table")
left.plot(since, sol.y[0, late], label="ball")
left.plot(since, sol.forces[0, late], color="C1", label="reaction")
left.set(xlabel="time in the period [–]", ylabel="height [–], reaction [–]")
left.legend()
amplitudes = np.linspace(1.02, 1.58, 29)
for amplitude in amplitudes:
    found = ss.periodic_orbit(ball.with_parameters(size=amplitude), [0, amplitude])
    of = found.solution().transitions
    lifts = of["t"][of["contact"] == "table.lift-off"] % (2 * np.pi)
    right.plot(np.full(len(lifts), amplitude), lifts, ".", color="C0")
    assert np.abs(found.multipliers).max() < 1e-6
right.plot(amplitudes, np.arcsin(1 / amplitudes), color="C1", lw=0.7)
right.set(xlabel="amplitude $A$ [–]", ylabel="time of the throw [–]")

exact = np.arcsin(2 / 3) + 2 * np.pi * np.arange(100)
rests = 5.9001108442601 + 2 * np.pi * np.arange(100)
print(f"throw {thrown[0]:.12f}, closed form {exact[0]:.12f}")
print(f"at rest again {landed[0]:.10f}, reference {rests[0]:.10f}")
assert len(thrown) == 100 and np.abs(thrown - exact).max() < 1e-9
assert np.abs(landed - rests[: len(landed)]).max() < 1e-6
plt.show()
