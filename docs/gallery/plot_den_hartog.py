r"""
Den Hartog: a driven block on a rough floor
===========================================

J. P. Den Hartog found in closed form how a block with dry friction answers a harmonic force
(Philosophical Magazine 9, 1930, 801–817). Without dimensions the block obeys

.. math:: \ddot x + x + S\,\mathrm{sgn}\,\dot x = \cos\Omega t .

An orbit that never sticks has the amplitude

.. math::

   A^2 = V^2 - S^2 U^2, \qquad V = \frac{1}{1-\Omega^2}, \qquad
   U = \frac{\sin(\pi/\Omega)}{\Omega\,(1+\cos(\pi/\Omega))} .

Friction is the ``floor`` contact: its boundary function is the velocity of the block.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

x, v = ss.states("x v")
S, O = ss.parameters(S=0.2, O=0.7)
floor = ss.Contact("floor", boundary=v, friction=S)
block = ss.System(
    {x: v, v: np.cos(O * ss.t) - x - floor.friction}, contacts=[floor], period=2 * ss.pi / O
)


def amplitude(omega, s):
    u = np.sin(np.pi / omega) / (omega * (1 + np.cos(np.pi / omega)))
    return np.sqrt(1 / (1 - omega**2) ** 2 - (s * u) ** 2)


# %%
# The periodic orbit is found by shooting, then followed for one period.
# Its amplitude is the largest :math:`x` at the zeros of the velocity.


def computed(omega, s):
    system = block.with_parameters(O=omega, S=s)
    orbit = ss.periodic_orbit(system, [0, 0])
    sol = ss.solve_ivp(system, (orbit.t, orbit.t + orbit.period), orbit.y, events=v)
    sticks = any("S" in mode for mode in sol.phases["mode"])
    return max(sol.y_events[0][:, 0], default=0.0), sticks


axes = plt.figure().subplots()
worst = 0.0
for color, s in enumerate([0.2, 0.45, 0.6]):
    for low, high in [(0.55, 0.93), (1.07, 2.0)]:
        for omega in np.linspace(low, high, 12):
            size, sticks = computed(omega, s)
            if not sticks:
                worst = max(worst, abs(size - amplitude(omega, s)))
            axes.plot(omega, size, "o", color=f"C{color}", mfc="w" if sticks else f"C{color}")
        fine = np.linspace(low, high, 200)
        line = axes.plot(fine, amplitude(fine, s), color=f"C{color}", lw=1)[0]
    line.set_label(f"S = {s}")
axes.plot([], [], "ko", label="never sticks")
axes.plot([], [], "ko", mfc="w", label="sticks in each period")
axes.set(xlabel=r"frequency $\Omega$ [–]", ylabel="amplitude $A$ [–]", ylim=(0, 6))
axes.legend(loc="upper right")

# %%
# Filled points lie on Den Hartog's curves. Open points stick in each period, and the formula
# does not hold for them.

size, _ = computed(0.7, 0.2)
print(f"A(0.7, 0.2) = {size:.10f}, closed form {amplitude(0.7, 0.2):.10f}")
print(f"largest error of all orbits without stick: {worst:.1e}")
assert abs(size - 1.9277745179) < 1e-10
assert worst < 1e-8
plt.show()
