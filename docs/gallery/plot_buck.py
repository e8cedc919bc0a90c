r"""
Buck converter: the flip that leads to chaos
============================================

A DC–DC buck converter in voltage mode closes its switch when a ramp passes the amplified error of
the output voltage. E. Fossas and G. Olivar studied its route to chaos (IEEE Transactions on
Circuits and Systems I 43, 1996, 13–25). Its parts are :math:`R = 22` Ω, :math:`C = 47` µF and
:math:`L = 20` mH. With the period :math:`T = 400` µs and the input voltage :math:`E`,

.. math::

   C\dot v = i - v/R, \qquad L\,\dot i = E\,u - v, \qquad
   u = 1 \text{ while } 8.4\,(v - 11.3) < 3.8 + 4.4\,(t/T \bmod 1) .

The orbit of period one closes the switch at a phase that follows from linear circuits. With the
saltation matrix of that switch its monodromy matrix is exact, too. The period doubles where its
trace is :math:`-1 - e^{-T/RC}`.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

R, C, L, T = 22, 47e-6, 20e-3, 400e-6
v, i = ss.states("v i")
(on,) = ss.discrete(on=0)
(E,) = ss.parameters(E=20.0)
above = 8.4 * (v - 11.3) - (3.8 + 4.4 * ss.sawtooth("ramp", period=T))
converter = ss.System(
    {v: (i - v / R) / C, i: (E * on - v) / L},
    jumps=[
        ss.Jump("open", when=above, direction="rising", set={on: 0}),
        ss.Jump("close", when=above, direction="falling", set={on: 1}),
    ],
    period=T,
)

# %%
# The closed form: flow of the circuit, phase at which the switch closes, trace.

a, unit = np.array([[-1 / (R * C), 1 / C], [-1 / L, 0]]), np.eye(2)


def flow(time):
    values, vectors = np.linalg.eig(a)
    return (vectors * np.exp(values * time) @ np.linalg.inv(vectors)).real


def root(f, low, high):
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if f(middle) * f(low) > 0 else (low, middle)
    return low


def trace(voltage):
    b = np.array([0, voltage / L])

    def at_close(close):
        driven = np.linalg.solve(a, (flow(T - close) - unit) @ b)
        return flow(close) @ np.linalg.solve(unit - flow(T), driven)

    close = root(lambda at: 8.4 * (at_close(at)[0] - 11.3) - 3.8 - 4.4 * at / T, 0, T)
    rate = 8.4 * (a @ at_close(close))[0] - 4.4 / T
    saltation = unit + np.outer(b, [8.4, 0]) / rate
    return np.trace(flow(T - close) @ saltation @ flow(close))


exact = root(lambda voltage: trace(voltage) + 1 + np.exp(-T / (R * C)), 22, 27)

# %%
# The branch of period one is followed through the flip; the diagram shows the voltage once in each
# period of the ramp.

branch = ss.continuation(converter, E, (17, 27), [12, 0.55, 0], transient=0.1)
flip = branch.special[branch.special["name"] == "flip"]["parameter"]
voltages = np.linspace(22, 34, 97)
diagram = ss.bifurcation_diagram(converter, E, voltages, [12, 0.55, 0], longest=0.1)

axes = plt.figure().subplots()
for voltage, points in zip(diagram.parameter, diagram.points):
    axes.plot(np.full(len(points), voltage), points[:, 0], ".", color="C0", ms=1.5)
axes.axvline(exact, color="C1", lw=1, ls="--")
axes.text(exact + 0.1, 11.8, "flip", color="C1")
axes.set(xlabel="input voltage $E$ [V]", ylabel="output voltage $v$ at the ramp's start [V]")

print(f"flip at E = {flip[0]:.9f} V, closed form {exact:.9f} V")
assert len(flip) == 1 and abs(flip[0] - exact) < 1e-8
plt.show()
