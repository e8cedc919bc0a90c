"""Event times of the benchmark problems to 30 decimals.

Writes one CSV file per problem of problems.json beside this file: problem,event,kind,t,x1,x2,... with one row per
event. Parameters are the doubles of problems.json, taken exactly.

Belt, forced and bracket: Taylor series with mpmath, mode by mode, an event being the first root of the boundary's (or,
while it sticks, a guard's) polynomial. Moving boundary: closed form between events, roots by Newton's method. Every
problem is computed twice, with different precision, order and steps; a file is written only where the two agree to
AGREEMENT.

    python3 generate.py [problem ...]
"""

import json
import pathlib
import sys

from mpmath import findroot, floor, log, mp, mpf, nstr, sin, cos, pi

HERE = pathlib.Path(__file__).parent
AGREEMENT = mpf(10) ** -30
# (decimal digits, order of the series, decimal exponent of the truncation error, share of a step in the radius)
FIRST = (45, 44, -38)
SECOND = (56, 56, -47)
CROSSING, ENTRY, EXIT = "crossing", "entry", "exit"
SCANNED = 64


def product(a, b, k):
    return mp.fdot(zip(a[: k + 1], b[k::-1]))


class Series:
    """Taylor coefficients of a mode; subclasses know the equations."""

    def __init__(self, parameters):
        self.p = {name: mpf(value) for name, value in parameters.items()}

    def boundary(self, state):
        h = list(state[1])
        h[0] -= self.p["belt_speed"]
        return h

    def slip_inverse(self, side, v, r, k):
        """Coefficient k of 1/(1 + δ|v - vp|), given those of v up to k and of itself up to k - 1."""
        p = self.p
        first = 1 + p["delta"] * side * (v[0] - p["belt_speed"])
        if k == 0:
            return 1 / first
        rest = mp.fdot((p["delta"] * side * v[i], r[k - i]) for i in range(1, k + 1))
        return -rest / first


class Oscillator(Series):
    """m x'' = sign (k1 z - k2 z³) - T, z = x - A sin ωt; sign 1 for the belt, -1 for the forced oscillator."""

    def expand(self, mode, t, start, order):
        p = self.p
        sign = -1 if "omega" in p else 1
        amplitude, omega = p.get("amplitude", mpf(0)), p.get("omega", mpf(0))
        wave = self.wave(amplitude, omega, t, order)
        x, v = [start[0]], [start[1]]
        z, u, w, r, above, below = [], [], [], [], [], []
        for k in range(order):
            z.append(x[k] - wave[k])
            u.append(product(z, z, k))
            w.append(product(z, u, k))
            spring = sign * (p["k1"] * z[k] - p["k2"] * w[k]) / p["mass"]
            friction = p["mu0"] / p["mass"]
            at_rest = friction if k == 0 else mpf(0)
            above.append(spring - at_rest)
            below.append(spring + at_rest)
            x.append(v[k] / (k + 1))
            if mode == 0:
                v.append(mpf(0))
            else:
                r.append(self.slip_inverse(mode, v, r, k))
                v.append((spring - mode * friction * r[k]) / (k + 1))
        return [x, v], above, below

    @staticmethod
    def wave(amplitude, omega, t, order):
        values = [sin(omega * t), cos(omega * t), -sin(omega * t), -cos(omega * t)]
        scale, wave = amplitude, []
        for k in range(order):
            wave.append(scale * values[k % 4])
            scale = scale * omega / (k + 1)
        return wave


class Bracket(Series):
    """Model 3; the normal force must stay positive, which is checked at the start of every step."""

    def expand(self, mode, t, start, order):
        p = self.p
        state = [[value] for value in start]
        n, r, above, below = [], [], [], []
        for k in range(order):
            x1, x2, x3, x4 = (poly[k] for poly in state)
            n.append((1 if k == 0 else 0) - p["unloading"] * x3 - p["unloading_rate"] * x4)
            if k == 0 and n[0] <= 0:
                raise ArithmeticError("contact is lost")
            linear = -x1 - p["coupling"] * (p["coupling_damping"] * (x2 + x4) + x3)
            limit = p["coupling"] * p["mu0"] * n[k]
            above.append(linear - limit)
            below.append(linear + limit)
            pull = x1 + p["coupling_damping"] * x2 + p["bracket_stiffness"] * x3 + p["bracket_damping"] * x4
            if mode == 0:
                acceleration = mpf(0)
            else:
                r.append(self.slip_inverse(mode, state[1], r, k))
                acceleration = linear - mode * p["coupling"] * p["mu0"] * product(n, r, k)
            for poly, rate in zip(state, [x2, acceleration, x4, -p["mobility"] * pull]):
                poly.append(rate / (k + 1))
        return state, above, below


def value(poly, s):
    return mp.polyval(poly[::-1], s)


def slope(poly):
    return [k * c for k, c in enumerate(poly)][1:]


def newton(poly, guess):
    rate = slope(poly)
    for _ in range(60):
        step = value(poly, guess) / value(rate, guess)
        guess -= step
        if abs(step) < mpf(10) ** (4 - mp.dps) * max(1, abs(guess)):
            return guess
    raise ArithmeticError("Newton's method does not converge")


def bisected(poly, low, high):
    sign = value(poly, low) > 0
    for _ in range(12):
        middle = (low + high) / 2
        if (value(poly, middle) > 0) == sign:
            low = middle
        else:
            high = middle
    return newton(poly, (low + high) / 2)


def first_root(poly, length):
    """First root in (0, length]. Roots at 0, where the phase starts, are divided out. A dip between two samples that
    does not show as a change of sign is found by the root of the slope."""
    poly = list(poly)
    while abs(poly[0]) < mpf(10) ** -30:
        poly.pop(0)
    places = [length * i / SCANNED for i in range(SCANNED + 1)]
    values = [value(poly, s) for s in places]
    for i in range(SCANNED):
        if (values[i] > 0) != (values[i + 1] > 0):
            return bisected(poly, places[i], places[i + 1])
        rate = slope(poly)
        start, end = value(rate, places[i]), value(rate, places[i + 1])
        if start * values[i] < 0 < end * values[i]:
            lowest = bisected(rate, places[i], places[i + 1])
            if (value(poly, lowest) > 0) != (values[i] > 0):
                return bisected(poly, places[i], lowest)
    return None


def run_series(problem, order, exponent):
    system = {"belt": Oscillator, "forced": Oscillator, "bracket": Bracket}[problem["model"]](problem["parameters"])
    t, x, t_end = mpf(0), [mpf(v) for v in problem["start"]], mpf(problem["t_end"])
    vp = system.p["belt_speed"]
    if x[1] == vp:
        raise ArithmeticError("the start must lie off the boundary")
    mode = 1 if x[1] > vp else -1
    events = []
    while t < t_end:
        state, above, below = system.expand(mode, t, x, order)
        size = max(abs(poly[order]) for poly in state)
        before = max(abs(poly[order - 1]) for poly in state)
        # Where the series ends before its order does (a polynomial), any step is good.
        reach = [(mpf(10) ** exponent / c) ** (mpf(1) / k) for c, k in ((size, order), (before, order - 1)) if c > 0]
        step = min(reach + [mpf(1) / 2, t_end - t])
        if mode == 0:
            roots = [(first_root(above, step), 1), (first_root(below, step), -1)]
        else:
            roots = [(first_root(system.boundary(state), step), 0)]
        roots = [root for root in roots if root[0] is not None and root[0] <= step]
        if not roots:
            t, x = t + step, [value(poly, step) for poly in state]
            continue
        root, side = min(roots)
        t, x = t + root, [value(poly, root) for poly in state]
        x[1] = vp
        if mode == 0:
            kind, mode = EXIT, side
        else:
            _, above, below = system.expand(0, t, x, 1)
            if below[0] > 0 > above[0]:
                kind, mode = ENTRY, 0
            else:
                kind, mode = CROSSING, -mode
        events.append((kind, t, x))
    return events


def run_moving(problem, scan):
    """x' = a below, -a above, boundary x - sin t, started on it where it slides."""
    a, t_end = mpf(problem["parameters"]["speed"]), mpf(problem["t_end"])
    t, mode, events = mpf(problem["t_start"]), 0, []
    x = mpf(problem["start"][0])
    while True:
        if mode == 0:
            # It slides until |cos t| = a; which comes next is plain from the period.
            angle = mp.acos(a)
            turns = floor(t / pi) + 1
            candidates = [k * pi + sign * angle for k in range(int(turns) - 2, int(turns) + 3) for sign in (-1, 1)]
            t = min(c for c in candidates if c > t + mpf(10) ** -20)
            x = sin(t)
            # Falls faster than -a: the body is left above; rises faster than a: below.
            mode = 1 if cos(t) < 0 else -1
            kind = EXIT
        else:
            t0, x0 = t, x

            def h(s):
                return x0 - mode * a * (s - t0) - sin(s)

            s = t0 + scan / 7
            while h(s) * mode > 0:
                s += scan
            t = findroot(h, (s - scan, s), solver="anderson", tol=mpf(10) ** (-2 * mp.dps + 8))
            x = sin(t)
            # Normal speeds a - cos t below and -a - cos t above.
            if a - cos(t) > 0 > -a - cos(t):
                kind, mode = ENTRY, 0
            else:
                kind, mode = CROSSING, -mode
        if t >= t_end:
            return events
        events.append((kind, t, [x]))


def run(problem, setting):
    digits, order, exponent = setting
    mp.dps = digits
    if problem["model"] == "moving":
        return run_moving(problem, mpf(1) / order)
    return run_series(problem, order, exponent)


def write(name, problem):
    first, second = run(problem, FIRST), run(problem, SECOND)
    if [event[0] for event in first] != [event[0] for event in second]:
        raise ArithmeticError(f"{name}: the two runs differ in their events")
    apart = max(abs(p - q) for one, two in zip(first, second) for p, q in zip([one[1]] + one[2], [two[1]] + two[2]))
    print(f"{name}: {len(second)} events, the two runs agree to {nstr(apart, 2)}", flush=True)
    if apart > AGREEMENT:
        raise ArithmeticError(f"{name}: the two runs do not agree to {nstr(AGREEMENT, 2)}")

    def text(number):
        whole = 1 if abs(number) < 1 else int(floor(log(abs(number), 10))) + 1
        return nstr(number, 30 + whole, strip_zeros=False, min_fixed=-99, max_fixed=99)

    states = [f"x{i + 1}" for i in range(len(second[0][2]))]
    lines = [",".join(["problem", "event", "kind", "t"] + states)]
    for index, (kind, t, x) in enumerate(second):
        lines.append(",".join([name, str(index + 1), kind, text(t)] + [text(v) for v in x]))
    (HERE / f"{name}.csv").write_text("\n".join(lines) + "\n")


def main():
    problems = json.loads((HERE / "problems.json").read_text())
    wanted = sys.argv[1:] or list(problems)
    for name in wanted:
        write(name, problems[name])


if __name__ == "__main__":
    main()
