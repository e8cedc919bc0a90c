r"""
Impact oscillator: period one, its flip, and a graze
====================================================

S. W. Shaw and P. J. Holmes studied an oscillator that hits a wall (Journal of Sound and Vibration
90, 1983, 129–155). Between impacts it is linear; an impact reverses the velocity and keeps a part
:math:`r` of it:

.. math:: \ddot x + x = \cos\omega t, \qquad x = 0: \; \dot x \to -r\,\dot x .

For one impact in each period :math:`T = 2\pi/\omega` the phase and the speed of the impact solve
two linear equations. With :math:`\dot x_-` before the impact and the drive :math:`\cos\varphi` at
it, the monodromy matrix has the determinant :math:`r^2` and the trace

.. math:: -2 r \cos T + (1 + r) \sin T\,\frac{\cos\varphi}{\dot x_-} .
"""

import matplotlib.pyplot as plt
import numpy as np
import stickslip as ss

x, v = ss.states("x v")
w, r, gap = ss.parameters(w=2.5, r=0.8, gap=0.5)
wall = ss.Jump("wall", when=x, direction="rising", set={v: -r * v})
ball = ss.System({x: v, v: np.cos(w * ss.t) - x}, jumps=[wall], period=2 * ss.pi / w)


def trace(omega, rest):
    c, s = np.cos(2 * np.pi / omega), np.sin(2 * np.pi / omega)
    gain = 1 / (1 - omega**2)
    matrix = gain * np.array([[1 - c, omega * s], [s, omega * (c - 1)]])
    phase = np.linalg.solve(matrix, [-s, -1 / rest - c])
    speed = -1 / np.hypot(*phase)
    return -2 * rest * c + s * (1 + rest) * phase[0] * speed / (-speed / rest)


def root(f, low, high):
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if f(middle) * f(low) > 0 else (low, middle)
    return low


# %%
# Left: the velocity once in each period. The period doubles where the trace is :math:`-1 - r^2`.
# Right: a damped oscillator grazes a wall where its free amplitude,
# :math:`1/\sqrt{(1-\omega^2)^2 + 0.01\,\omega^2}`, grows to the gap of 0.5.

stop = ss.Jump("stop", when=x - gap, direction="rising", set={v: -r * v})
damped = ss.System(
    {x: v, v: np.cos(w * ss.t) - x - 0.1 * v}, jumps=[stop], period=2 * ss.pi / w
)
exact_flip = root(lambda omega: trace(omega, 0.8) + 1 + 0.8**2, 2.5, 2.8)
exact_graze = root(lambda omega: (1 - omega**2) ** 2 + 0.01 * omega**2 - 4, 1.2, 2.5)


def draw(axes, system, values, start, exact, word):
    diagram = ss.bifurcation_diagram(system, w, values, start, longest=600)
    for omega, points in zip(diagram.parameter, diagram.points):
        axes.plot(np.full(len(points), omega), points[:, 1], ".", color="C0", ms=1.5)
    axes.axvline(exact, color="C1", lw=1, ls="--")
    axes.set(xlabel=r"frequency $\omega$ [–]", ylabel=r"velocity $\dot x$ at $t = nT$ [–]")
    axes.text(exact, axes.get_ylim()[1], f" {word}", color="C1", va="top")


left, right = plt.figure().subplots(1, 2)
draw(left, ball, np.linspace(2.5, 2.75, 126), [-0.3, 0], exact_flip, "flip")
free = 1 / (1 - 1.76**2 + 0.1j * 1.76)
begin = [free.real, -1.76 * free.imag]
draw(right, damped, np.linspace(1.76, 1.70, 61), begin, exact_graze, "graze")

orbit = ss.periodic_orbit(ball, [-0.3, 0])
found = orbit.multipliers.sum().real, orbit.multipliers.prod().real
flips = ss.continuation(ball, w, (2.4, 2.9), [-0.3, 0]).special
grazes = ss.continuation(damped.with_parameters(w=2.5), w, (1.2, 3), [0, 0]).special
print(f"trace {found[0]:.9f}, closed form {trace(2.5, 0.8):.9f}; determinant {found[1]:.9f}")
print(f"flip at ω = {flips['parameter'][0]:.10f}, closed form {exact_flip:.10f}")
print(f"graze at ω = {grazes['parameter'][0]:.10f}, closed form {exact_graze:.10f}")
assert abs(found[0] - trace(2.5, 0.8)) < 1e-9 and abs(found[1] - 0.8**2) < 1e-9
assert flips["name"].tolist() == ["flip"] and abs(flips["parameter"][0] - exact_flip) < 1e-9
assert abs(grazes["parameter"][0] - exact_graze) < 1e-10
plt.show()
