"""Ten series of one column from systems of known spectrum.

    python series.py

prints the exponents from the variational equations, along an orbit of a million points, beside
those that are taken for true.
"""

import math
from dataclasses import dataclass
from typing import Callable

import numpy as np
from numba import njit

# Runge-Kutta steps between two points of a flow's series.
SUBSTEPS = 8
# Points left out before a series begins.
TRANSIENT = 3000


@njit
def henon(s, out, jac):
    x, y = s
    out[0], out[1] = 1.0 - 1.4 * x * x + y, 0.3 * x
    jac[:] = np.array([[-2.8 * x, 1.0], [0.3, 0.0]])


@njit
def ikeda(s, out, jac):
    x, y = s
    q = 1.0 + x * x + y * y
    turn, steep = 0.4 - 6.0 / q, 12.0 / (q * q)
    c, d = math.cos(turn), math.sin(turn)
    u, v = x * c - y * d, x * d + y * c
    out[0], out[1] = 1.0 + 0.9 * u, 0.9 * v
    first = [c - v * steep * x, -d - v * steep * y]
    second = [d + u * steep * x, c + u * steep * y]
    jac[:] = 0.9 * np.array([first, second])


@njit
def logistic(s, out, jac):
    out[0] = 3.9 * s[0] * (1.0 - s[0])
    jac[0, 0] = 3.9 * (1.0 - 2.0 * s[0])


@njit
def coupled(s, out, jac):
    x, y = s
    f, g = 3.9 * x * (1.0 - x), 3.8 * y * (1.0 - y)
    a, b = 3.9 * (1.0 - 2.0 * x), 3.8 * (1.0 - 2.0 * y)
    out[0], out[1] = 0.95 * f + 0.05 * g, 0.95 * g + 0.05 * f
    jac[:] = np.array([[0.95 * a, 0.05 * b], [0.05 * a, 0.95 * b]])


def lorenz(sigma, r, b):
    @njit
    def field(s, out, jac):
        x, y, z = s
        out[0], out[1], out[2] = sigma * (y - x), x * (r - z) - y, x * y - b * z
        jac[:] = np.array([[-sigma, sigma, 0.0], [r - z, -1.0, -x], [y, x, -b]])

    return field


@njit
def roessler(s, out, jac):
    x, y, z = s
    out[0], out[1], out[2] = -y - z, x + 0.2 * y, 0.2 + z * (x - 5.7)
    jac[:] = np.array([[0.0, -1.0, -1.0], [1.0, 0.2, 0.0], [z, 0.0, x - 5.7]])


@njit
def pendulum(s, out, jac):
    angle, velocity, phase = s
    out[0] = velocity
    out[1] = 1.5 * math.cos(phase) - 0.5 * velocity - math.sin(angle)
    out[2] = 2.0 / 3.0
    second = [-math.cos(angle), -0.5, -1.5 * math.sin(phase)]
    jac[:] = np.array([[0.0, 1.0, 0.0], second, [0.0, 0.0, 0.0]])


@njit
def chua(s, out, jac):
    x, y, z = s
    outer = x - min(max(x, -1.0), 1.0)
    inside = outer == 0.0
    diode = -8.0 / 7.0 * x + 3.0 / 7.0 * outer
    slope = -8.0 / 7.0 if inside else -5.0 / 7.0
    out[0], out[1], out[2] = 15.6 * (y - x - diode), x - y + z, -28.0 * y
    jac[:] = np.array([[15.6 * (-1.0 - slope), 15.6, 0.0], [1.0, -1.0, 1.0], [0.0, -28.0, 0.0]])


@njit
def circle(s, out, jac):
    x, y = s
    growth = 1.0 - x * x - y * y
    out[0], out[1] = x * growth - y, y * growth + x
    first = [growth - 2.0 * x * x, -2.0 * x * y - 1.0]
    second = [1.0 - 2.0 * x * y, growth - 2.0 * y * y]
    jac[:] = np.array([first, second])


@njit
def product(a, b):
    """Product of small matrices, for which a call of the library's takes longer than this."""
    out = np.zeros_like(b)
    for i in range(a.shape[0]):
        for k in range(a.shape[1]):
            for j in range(b.shape[1]):
                out[i, j] += a[i, k] * b[k, j]
    return out


def flow(field, dt):
    """The map over `dt` by the classical Runge-Kutta method, for state and tangent vectors."""
    h = dt / SUBSTEPS

    @njit
    def step(s, vectors):
        n = len(s)
        ks, kv = np.empty((4, n)), np.empty((4, n, n))
        jac = np.zeros((n, n))
        for _ in range(SUBSTEPS):
            for stage in range(4):
                at, tangents = s, vectors
                if stage > 0:
                    part = h if stage == 3 else 0.5 * h
                    at, tangents = s + part * ks[stage - 1], vectors + part * kv[stage - 1]
                field(at, ks[stage], jac)
                kv[stage] = product(jac, tangents)
            s = s + h / 6.0 * (ks[0] + 2.0 * ks[1] + 2.0 * ks[2] + ks[3])
            vectors = vectors + h / 6.0 * (kv[0] + 2.0 * kv[1] + 2.0 * kv[2] + kv[3])
        return s, vectors

    return step


def iteration(function):
    @njit
    def step(s, vectors):
        n = len(s)
        out, jac = np.empty(n), np.zeros((n, n))
        function(s, out, jac)
        return out, product(jac, vectors)

    return step


@njit
def orthonormalise(vectors, sums):
    """Gram-Schmidt on the columns. Adds the logarithms of their lengths to `sums`."""
    n = len(sums)
    for i in range(n):
        for k in range(i):
            along = 0.0
            for r in range(n):
                along += vectors[r, i] * vectors[r, k]
            for r in range(n):
                vectors[r, i] -= along * vectors[r, k]
        length = 0.0
        for r in range(n):
            length += vectors[r, i] * vectors[r, i]
        length = math.sqrt(length)
        for r in range(n):
            vectors[r, i] /= length
        sums[i] += math.log(length)


@dataclass(frozen=True)
class Case:
    """A system, the observed column, and the embedding for packages that choose none themselves."""

    name: str
    step: Callable
    dt: float
    start: tuple
    observed: Callable
    # True exponents, descending.
    known: tuple
    source: str
    # The first so many are compared: a column does not show the strong contractions of a flow.
    compared: int
    dimension: int
    delay: int

    def states(self, points):
        step, s = self.step, np.array(self.start)
        n = len(s)

        @njit
        def run(s, transient, points):
            states, vectors = np.empty((points, n)), np.zeros((n, n))
            for _ in range(transient):
                s, _v = step(s, vectors)
            for i in range(points):
                states[i] = s
                s, _v = step(s, vectors)
            return states

        return run(s, TRANSIENT, points)

    def column(self, points):
        return np.array([self.observed(s) for s in self.states(points)])

    def exponents(self, points):
        """Exponents from the variational equations."""
        step, s, dt = self.step, np.array(self.start), self.dt
        n = len(s)

        @njit
        def run(s, transient, points):
            vectors, sums = np.eye(n), np.zeros(n)
            for i in range(transient + points):
                if i == transient:
                    sums[:] = 0.0
                s, vectors = step(s, vectors)
                orthonormalise(vectors, sums)
            return sums / (points * dt)

        return np.sort(run(s, TRANSIENT, points))[::-1]


def first(s):
    return s[0]


SPROTT = "Sprott 2003"
EQUATIONS = "variational equations"

CASES = (
    Case("Henon", iteration(henon), 1.0, (0.1, 0.1), first, (0.4192, -1.6232), SPROTT, 2, 2, 1),
    Case("Ikeda", iteration(ikeda), 1.0, (0.5, -0.3), first, (0.5076, -0.7184), EQUATIONS, 2, 4, 1),
    Case("logistic", iteration(logistic), 1.0, (0.3,), first, (0.4960,), EQUATIONS, 1, 2, 1),
    Case("coupled logistic", iteration(coupled), 1.0, (0.3, 0.6), first,
         (0.4146, 0.3082), EQUATIONS, 2, 4, 1),
    Case("Lorenz", flow(lorenz(10.0, 28.0, 8.0 / 3.0), 0.02), 0.02, (1.0, 1.0, 20.0), first,
         (0.9056, 0.0, -14.5723), SPROTT, 2, 3, 8),
    Case("Lorenz (Wolf)", flow(lorenz(16.0, 45.92, 4.0), 0.01), 0.01, (1.0, 1.0, 40.0), first,
         (1.5025, 0.0, -22.5025), EQUATIONS, 2, 3, 10),
    Case("Roessler", flow(roessler, 0.1), 0.1, (1.0, 1.0, 0.0), first,
         (0.0714, 0.0, -5.3943), SPROTT, 2, 3, 14),
    Case("driven pendulum", flow(pendulum, 0.1), 0.1, (0.2, 0.1, 0.0), lambda s: s[1],
         (0.1130, 0.0, -0.6130), EQUATIONS, 2, 4, 12),
    Case("Chua", flow(chua, 0.05), 0.05, (0.7, 0.0, 0.0), first,
         (0.4325, 0.0, -4.2234), EQUATIONS, 2, 4, 6),
    Case("limit cycle", flow(circle, 0.1), 0.1, (0.5, 0.0), first,
         (0.0, -2.0), "closed form", 1, 2, 15),
)


if __name__ == "__main__":
    for case in CASES:
        exponents = case.exponents(1_000_000)
        texts = (f"{v:9.5f}" for v in exponents)
        print(f"{case.name:17s}{case.known!s:30s}{case.source:23s}", *texts)
