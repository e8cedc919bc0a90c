"""Derivatives of orbits through events to 40 digits: derivatives.csv.

    python derivatives.py > derivatives.csv

Taylor series of order 80 in 120 digits, with events by Newton's iteration on the series. Derivatives
are central differences over 1e-30, whose error is about 1e-60. Needs mpmath.
"""

from mpmath import cos, mp, mpf, nstr, pi, sin, sqrt

mp.dps = 120
ORDER = 80
STEP = mpf(1) / 8
CHANGE = mpf(10) ** -30


def product(a, b, k):
    """Coefficient k of a product of series."""
    return sum(a[i] * b[k - i] for i in range(k + 1))


def belt(t, x, v, side, p):
    """Series of the block on a belt from here: x' = v, v' = x - x**3 - side mu0/(1 + delta slip)."""
    xs, vs, squares, frictions = [x], [v], [], []
    for k in range(ORDER):
        squares.append(product(xs, xs, k))
        cube = product(squares, xs, k)
        # friction * (1 + delta side (v - vp)) = mu0
        speed = [p["delta"] * side * one for one in vs]
        speed[0] += 1 - p["delta"] * side * p["vp"]
        known = sum(frictions[i] * speed[k - i] for i in range(k))
        frictions.append(((p["mu0"] if k == 0 else 0) - known) / speed[0])
        rate = xs[k] - cube - side * frictions[k]
        xs.append(vs[k] / (k + 1))
        vs.append(rate / (k + 1))
    return xs, vs


def floor(t, x, v, side, p):
    """Series of Den Hartog's oscillator: x' = v, v' = cos(O t) - x - side S."""
    xs, vs, drive = [x], [v], [cos(p["O"] * t), -p["O"] * sin(p["O"] * t)]
    for k in range(ORDER):
        drive.append(-p["O"] ** 2 * drive[k] / ((k + 1) * (k + 2)))
        rate = drive[k] - xs[k] - (side * p["S"] if k == 0 else 0)
        xs.append(vs[k] / (k + 1))
        vs.append(rate / (k + 1))
    return xs, vs


def at(series, h):
    value = mpf(0)
    for one in reversed(series):
        value = value * h + one
    return value


def zero(function, slope, h):
    """A simple zero near h."""
    for _ in range(12):
        h -= function(h) / slope(h)
    return h


def run(model, p, t, x, v, side, until):
    """Times of events, and the state at the end. The model slips first."""
    speed = p.get("vp", mpf(0))
    events = []
    while True:
        # Slip, until the velocity is that of the surface.
        while True:
            xs, vs = model(t, x, v, side, p)
            h = min(STEP, until - t)
            samples = [h * k / 64 for k in range(1, 65)]
            passed = [one for one in samples if side * (at(vs, one) - speed) < 0]
            if passed:
                break
            t, x, v = t + h, at(xs, h), at(vs, h)
            if t >= until:
                return events, x, v
        rates = [k * one for k, one in enumerate(vs)][1:]
        h = zero(lambda h: at(vs, h) - speed, lambda h: at(rates, h), passed[0])
        t, x, v = t + h, at(xs, h), speed
        events.append(t)
        # The force that friction must balance, and its slope while the block sticks.
        if model is belt:
            limit = p["mu0"]
            force = lambda s: (x + speed * s) - (x + speed * s) ** 3
            slope = lambda s: speed * (1 - 3 * (x + speed * s) ** 2)
        else:
            limit = p["S"]
            force = lambda s: cos(p["O"] * (t + s)) - x
            slope = lambda s: -p["O"] * sin(p["O"] * (t + s))
        if abs(force(0)) > limit:
            side = -side
            continue
        s = mpf(0)
        while abs(force(s)) <= limit and t + s < until:
            s += mpf(1) / 256
        if t + s >= until:
            return events, x + speed * (until - t), speed
        side = 1 if force(s) > 0 else -1
        s = zero(lambda s: force(s) - side * limit, slope, s)
        t, x = t + s, x + speed * s
        events.append(t)


CASES = [
    ("belt", belt, {"mu0": sqrt(mpf(3)) / 9, "delta": mpf(1), "vp": mpf(1)}, ("0.5", "1.5"), 12),
    ("den-hartog", floor, {"O": mpf("0.7"), "S": mpf("0.2")}, ("0", "0"), 14),
]

print("system,by,events,last event,x,v")
for name, model, values, start, until in CASES:
    x, v = map(mpf, start)
    for by in [*values, "x"]:
        both = []
        for sign in (1, -1):
            p = dict(values)
            x0 = x
            if by == "x":
                x0 += sign * CHANGE
            else:
                p[by] += sign * CHANGE
            # The floor is left at once: the force is larger than friction.
            both.append(run(model, p, mpf(0), x0, v, 1, mpf(until)))
        (events, *one), (others, *other) = both
        assert len(events) == len(others)
        pairs = [(events[-1], others[-1]), *zip(one, other)]
        slopes = [(a - b) / (2 * CHANGE) for a, b in pairs]
        print(name, by, len(events), *(nstr(slope, 40) for slope in slopes), sep=",")
