r"""
Shaw: stability of a driven block with friction
===============================================

S. W. Shaw added stability to Den Hartog's solution (Journal of Sound and Vibration 108, 1986,
305–325). The block obeys

.. math:: \ddot x + x + S\,\mathrm{sgn}\,\dot x = \cos\Omega t .

An orbit of amplitude :math:`A` turns at :math:`\pm A`, where friction changes its sign.
The acceleration there jumps from :math:`-A\Omega^2 - S` to :math:`-A\Omega^2 + S`. A small
deviation in velocity shrinks at the turn by their ratio :math:`r`. Over half a period
deviations are mapped by

.. math::

   \begin{pmatrix} 1 & 0 \\ 0 & r \end{pmatrix}
   \begin{pmatrix} \cos\theta & \sin\theta \\ -\sin\theta & \cos\theta \end{pmatrix},
   \qquad r = \frac{A\Omega^2 - S}{A\Omega^2 + S}, \qquad \theta = \frac{\pi}{\Omega} ,

and the multipliers of the orbit are the squares of the eigenvalues.
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

x, v = ss.states("x v")
S, O = ss.parameters(S=0.3, O=0.7)
floor = ss.Contact("floor", boundary=v, friction=S)
block = ss.System(
    {x: v, v: np.cos(O * ss.t) - x - floor.friction}, contacts=[floor], period=2 * ss.pi / O
)


def exact(omega, s):
    u = np.sin(np.pi / omega) / (omega * (1 + np.cos(np.pi / omega)))
    amplitude = np.sqrt(1 / (1 - omega**2) ** 2 - (s * u) ** 2)
    r = (amplitude * omega**2 - s) / (amplitude * omega**2 + s)
    cos, sin = np.cos(np.pi / omega), np.sin(np.pi / omega)
    return np.sort_complex(np.linalg.eigvals([[cos, sin], [-r * sin, r * cos]]) ** 2)


left, right = plt.figure().subplots(1, 2)
for s in [0.2, 0.5, 0.8]:
    system = block.with_parameters(S=s)
    orbit = ss.periodic_orbit(system, [0, 0])
    times = orbit.t + np.linspace(0, orbit.period, 800)
    sol = ss.solve_ivp(system, (times[0], times[-1]), orbit.y, t_eval=times)
    kind = "sticks twice" if "S" in sol.phases["mode"] else "never sticks"
    left.plot(*sol.y, label=f"S = {s}: {kind}")
left.set(xlabel="position $x$ [–]", ylabel=r"velocity $\dot x$ [–]", ylim=(-1.6, 2.6))
left.legend(loc="upper left")

# %%
# The multipliers come from the variational equation with the jump at each turn.
# Lines are the closed form. For S = 0.8, where the orbit sticks, one multiplier is zero.

worst, frequencies = 0.0, np.linspace(0.6, 1.9, 27)
for color, s in enumerate([0.2, 0.5]):
    for omega in frequencies[abs(frequencies - 1) > 0.08]:
        orbit = ss.periodic_orbit(block.with_parameters(S=s, O=omega), [0, 0], transient=400)
        found = np.sort_complex(orbit.multipliers)
        worst = max(worst, abs(found - exact(omega, s)).max())
        right.plot([omega] * 2, abs(orbit.multipliers), "o", color=f"C{color}", ms=3)
    for fine in [np.linspace(0.6, 0.93, 99), np.linspace(1.07, 1.9, 99)]:
        lines = right.plot(fine, [abs(exact(omega, s)) for omega in fine], color=f"C{color}", lw=1)
    lines[0].set_label(f"S = {s}")
right.set(xlabel=r"frequency $\Omega$ [–]", ylabel="|multiplier| [–]", ylim=(-0.03, 1))
right.legend(loc="lower right")

found = np.sort_complex(ss.periodic_orbit(block, [0, 0]).multipliers)
print(f"multipliers at Ω = 0.7, S = 0.3: {found.round(10)}")
print(f"closed form:                     {exact(0.7, 0.3).round(10)}")
lost = min(abs(ss.periodic_orbit(block.with_parameters(S=0.8), [0, 0]).multipliers))
print(f"largest error in the picture: {worst:.1e}; least multiplier for S = 0.8: {lost:.1e}")
assert abs(found - exact(0.7, 0.3)).max() < 1e-9
assert worst < 1e-7 and lost < 1e-12
plt.show()
