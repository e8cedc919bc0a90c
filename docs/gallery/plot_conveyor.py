r"""
Vibratory conveyor: parts that walk
===================================

A conveyor that vibrates along a line inclined by :math:`\beta` moves parts forward (J. H. Booth and
H. McCallion, Proceedings of the Institution of Mechanical Engineers 178, 1963). On the way up the
part is heavy and sticks; on the way down it is light and slips. Under the vibration
:math:`A\sin\omega t` the velocity :math:`v` of the part obeys

.. math::

   \dot v = -\mu N\,\mathrm{sgn}(v - A\omega\cos\beta\cos\omega t), \qquad
   N = g - A\omega^2\sin\beta\sin\omega t .

With :math:`c = \cos\beta + \mu\sin\beta` it begins to slip at :math:`t_1` and sticks again at
:math:`t_2`, where

.. math::

   \sin\omega t_1 = \frac{\mu g}{A\omega^2 c}, \qquad
   c A\omega\,(\cos\omega t_1 - \cos\omega t_2) = \mu g\,(t_2 - t_1) .

The way that it slips in each period follows by integration.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

g, mu, beta, omega = 9.81, 0.6, np.pi / 4, 2 * np.pi * 25
v, s = ss.states("v s")
(A,) = ss.parameters(A=0.5e-3)
table = A * omega * np.cos(beta) * np.cos(omega * ss.t)
load = g - A * omega**2 * np.sin(beta) * np.sin(omega * ss.t)
deck = ss.Contact("deck", boundary=v - table, friction=mu * load, normal_force=load)
part = ss.System({v: -deck.friction, s: v - table}, contacts=[deck])
period = 2 * np.pi / omega


def exact(size):
    """Times of slip and stick, and the way slipped between them."""
    c = np.cos(beta) + mu * np.sin(beta)
    t1 = np.arcsin(mu * g / (size * omega**2 * c)) / omega
    low, high = t1 + 0.1 * period, t1 + period
    for _ in range(60):
        t2 = 0.5 * (low + high)
        excess = c * size * omega * (np.cos(omega * t1) - np.cos(omega * t2)) - mu * g * (t2 - t1)
        low, high = (t2, high) if excess > 0 else (low, t2)
    waves = omega * np.cos(omega * t1) * (t2 - t1) - np.sin(omega * t2) + np.sin(omega * t1)
    return t1, t2, c * size * waves - mu * g * (t2 - t1) ** 2 / 2


def walk(size, periods=4):
    system = part.with_parameters(A=size)
    times = np.linspace(0, periods * period, 2000)
    start = [size * omega * np.cos(beta), 0]
    return ss.solve_ivp(system, (0, times[-1]), start, t_eval=times)


# %%
# Left: velocities of deck and part; stick is shaded. Right: the mean speed over the amplitude.
# It starts where the deck first outpaces friction, and ends where the part would lift off.

left, right = plt.figure().subplots(1, 2)
sol = walk(0.5e-3)
left.plot(1e3 * sol.t, 0.5e-3 * omega * np.cos(beta) * np.cos(omega * sol.t), label="deck")
left.plot(1e3 * sol.t, sol.y[0], label="part")
for phase in sol.phases[sol.phases["mode"] == "S"]:
    left.axvspan(1e3 * phase["t_start"], 1e3 * phase["t_end"], color="C5", alpha=0.2, lw=0)
left.set(xlabel="time [ms]", ylabel="velocity [m/s]", xlim=(0, 100), ylim=(-0.06, 0.09))
left.legend(ncols=2, loc="upper center")
found_t1, found_t2 = sol.transitions["t"][:2]
t1, t2, way = exact(0.5e-3)

sizes, worst = np.linspace(0.22e-3, 0.56e-3, 18), 0.0
for size in sizes:
    found = walk(size).y[1, -1] / 4
    worst = max(worst, abs(found - exact(size)[2]))
    right.plot(1e3 * size, found / period, "o", color="C1")
fine = np.linspace(sizes[0], sizes[-1], 200)
right.plot(1e3 * fine, [exact(size)[2] / period for size in fine], color="C1", lw=1)
right.set(xlabel="amplitude $A$ [mm]", ylabel="mean speed [m/s]", ylim=(0, None))

print(f"slips at {1e3 * found_t1:.9f} ms, closed form {1e3 * t1:.9f} ms")
print(f"sticks at {1e3 * found_t2:.9f} ms, closed form {1e3 * t2:.9f} ms")
print(f"mean speed at 0.5 mm: {1e3 * way / period:.6f} mm/s; largest error of a way {worst:.1e} m")
assert abs(found_t1 - t1) < 1e-12 and abs(found_t2 - t2) < 1e-11
assert worst < 1e-13
plt.show()
