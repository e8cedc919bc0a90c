"""Event times of model 1 to thirty digits, for the tests and benchmarks of the solver: writes belt.csv.

The belt oscillator with its default parameters but vp = 0.4 (all of them as the doubles that the library uses), from
(0.5, 1.5) at t = 0 to t = 30: Taylor series of order 40 in 45 digits, steps of an eighth of the radius of convergence,
events as roots of the velocity's polynomial. Needs mpmath. Run: python3 belt.py
"""

import math
from pathlib import Path

from mpmath import mp, mpf

mp.dps = 45
ORDER = 40
MU0 = mpf(math.sqrt(3.0) / 9.0)
VP = mpf(0.4)
T_END = mpf(30)


def series(side, x, v):
    """Coefficients of position and velocity on one side of the belt's speed (-1 below, 1 above)."""
    xs, vs, square, reciprocal = [x], [v], [], []
    for k in range(ORDER):
        slip = [(vs[0] - VP) * side + 1] + [c * side for c in vs[1:]]
        square.append(sum(xs[j] * xs[k - j] for j in range(k + 1)))
        one = mpf(1 if k == 0 else 0)
        rest = sum(slip[j] * reciprocal[k - j] for j in range(1, k + 1))
        reciprocal.append((one - rest) / slip[0])
        cube = sum(xs[j] * square[k - j] for j in range(k + 1))
        force = xs[k] - cube - MU0 * side * reciprocal[k]
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


def first_root(side, vs, h, leaving):
    """First time in (0, h] at which the velocity is back at the belt's: by sampling finely, then bisection and Newton."""
    c = [vs[0] - VP] + list(vs[1:])
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


def spring(x):
    return x - x**3


def main():
    t, x, v = mpf(0), mpf(0.5), mpf(1.5)
    side, leaving = 1, False
    events = []
    while t < T_END:
        xs, vs = series(side, x, v)
        h = min(radius(xs, vs) / 8, T_END - t)
        s = first_root(side, vs, h, leaving)
        if s is None:
            t, x, v, leaving = t + h, value(xs, h), value(vs, h), False
            continue
        t, x, v = t + s, value(xs, s), VP
        below, above = spring(x) + MU0, spring(x) - MU0
        if below > 0 > above:
            events.append(("StickEntry", t, x))
            # The position rides with the belt until the spring overcomes friction: the next root of a cubic.
            exits = [
                (root, released)
                for released, shift in ((-1, MU0), (1, -MU0))
                for root in mp.polyroots([-1, 0, 1, shift], maxsteps=200, extraprec=200)
                if abs(mp.im(root)) < mpf(10) ** -30 and mp.re(root) > x
            ]
            root, side = min(((mp.re(root), side) for root, side in exits))
            t, x = t + (root - x) / VP, root
            if t > T_END:
                break
            events.append(("StickExit", t, x))
        else:
            side = 1 if below > 0 else -1
            events.append(("Crossing", t, x))
        leaving = True
    lines = ["kind,t,x"] + [f"{kind},{mp.nstr(t, 30)},{mp.nstr(x, 30)}" for kind, t, x in events]
    out = Path(__file__).with_suffix(".csv")
    partial = out.with_suffix(".csv.part")
    partial.write_text("\n".join(lines) + "\n")
    partial.rename(out)


if __name__ == "__main__":
    main()
