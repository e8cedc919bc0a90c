"""Event times of belt oscillators to thirty digits, for the tests and benchmarks of the solver: writes belt.csv.

x'' = k1 x - k2 x^3 - friction, with friction mu0/(1 + |x' - vp|) (all parameters as the doubles that the library uses):

belt      the default of model 1 with vp = 0.4, from (0.5, 1.5) to t = 30: enlarges errors by thousands
decaying  k1 = -1, k2 = 0, mu0 = 1, vp = 0.2, from (0.04, -0.01) to t = 40: a limit cycle with stick

Taylor series of order 40 in 45 digits, steps of an eighth of the radius of convergence,
events as roots of the velocity's polynomial. Needs mpmath. Run: python3 belt.py
"""

import math
from pathlib import Path

from mpmath import mp, mpf

mp.dps = 45
ORDER = 40


class Belt:
    def __init__(self, k1, k2, mu0, vp):
        self.k1, self.k2, self.mu0, self.vp = mpf(k1), mpf(k2), mpf(mu0), mpf(vp)

    def spring(self, x):
        return self.k1 * x - self.k2 * x**3

    def exits(self, x):
        """Positions ahead of x at which the spring overcomes friction, with the side of release."""
        for released, force in ((-1, self.mu0), (1, -self.mu0)):
            terms = [-self.k2, 0, self.k1, force] if self.k2 else [self.k1, force]
            for root in mp.polyroots(terms, maxsteps=200, extraprec=200):
                if abs(mp.im(root)) < mpf(10) ** -30 and mp.re(root) > x:
                    yield mp.re(root), released


def series(belt, side, x, v):
    """Coefficients of position and velocity on one side of the belt's speed (-1 below, 1 above)."""
    xs, vs, square, reciprocal = [x], [v], [], []
    for k in range(ORDER):
        slip = [(vs[0] - belt.vp) * side + 1] + [c * side for c in vs[1:]]
        square.append(sum(xs[j] * xs[k - j] for j in range(k + 1)))
        one = mpf(1 if k == 0 else 0)
        rest = sum(slip[j] * reciprocal[k - j] for j in range(1, k + 1))
        reciprocal.append((one - rest) / slip[0])
        cube = sum(xs[j] * square[k - j] for j in range(k + 1))
        force = belt.k1 * xs[k] - belt.k2 * cube - belt.mu0 * side * reciprocal[k]
        xs.append(vs[k] / (k + 1))
        vs.append(force / (k + 1))
    return xs, vs


def value(c, s):
    total = mpf(0)
    for a in reversed(c):
        total = total * s + a
    return total


def radius(*rows):
    return min(
        (abs(row[k]) ** (mpf(-1) / k) for row in rows for k in (ORDER - 1, ORDER) if row[k] != 0),
    )


def first_root(vp, side, vs, h, leaving):
    """First time in (0, h] at which the velocity is back at the belt's: by sampling finely, then bisection and Newton."""
    c = [vs[0] - vp] + list(vs[1:])
    if leaving:
        order = next(k for k in range(ORDER) if abs(c[k]) > mpf(10) ** -30)
        c = c[order:]
    parts = 400
    for i in range(1, parts + 1):
        a, b = h * (i - 1) / parts, h * i / parts
        if value(c, a) * side > 0 >= value(c, b) * side:
            for _ in range(180):
                middle = (a + b) / 2
                if value(c, middle) * side > 0:
                    a = middle
                else:
                    b = middle
            return (a + b) / 2
    return None


def events(belt, x, v, t_end):
    t, x, v, t_end = mpf(0), mpf(x), mpf(v), mpf(t_end)
    side, leaving = (1 if v > belt.vp else -1), False
    while t < t_end:
        xs, vs = series(belt, side, x, v)
        h = min(radius(xs, vs) / 8, t_end - t)
        s = first_root(belt.vp, side, vs, h, leaving)
        if s is None:
            t, x, v, leaving = t + h, value(xs, h), value(vs, h), False
            continue
        t, x, v, leaving = t + s, value(xs, s), belt.vp, True
        below, above = belt.spring(x) + belt.mu0, belt.spring(x) - belt.mu0
        if not below > 0 > above:
            side = 1 if below > 0 else -1
            yield "Crossing", t, x
            continue
        yield "StickEntry", t, x
        # The position rides with the belt until the spring overcomes friction.
        root, side = min(belt.exits(x))
        t, x = t + (root - x) / belt.vp, root
        if t < t_end:
            yield "StickExit", t, x


def main():
    runs = {
        "belt": (Belt(1, 1, math.sqrt(3.0) / 9.0, 0.4), 0.5, 1.5, 30),
        "decaying": (Belt(-1, 0, 1, 0.2), 0.04, -0.01, 40),
    }
    lines = ["problem,kind,t,x"]
    for name, run in runs.items():
        for kind, t, x in events(*run):
            lines.append(f"{name},{kind},{mp.nstr(t, 30)},{mp.nstr(x, 30)}")
    out = Path(__file__).with_suffix(".csv")
    partial = out.with_suffix(".csv.part")
    partial.write_text("\n".join(lines) + "\n")
    partial.rename(out)


if __name__ == "__main__":
    main()
