"""The main numbers of the replication once more, in plain Python.

Nothing here is shared with the Rust code but the golden files that the numbers are compared with.
`python3 second_opinion.py [GOLDEN_FOLDER]` needs the standard library only. Exit code 0: all agree.
"""
import math
import sys
from pathlib import Path


# ---- The Appendix's listing, under the semantics of Python: `xn = x` names one list twice. ----
# Added to the print: `i += 1`, the name of the last parameter, and a record of the stick phases.

def f(x, K1, K2, m, a, b, xs):
    return m * (-K1 * (x[1] - xs) + K2 * (x[1] - xs) ** 3 + b / (a - x[2]))


def harmonic(A, w, t):
    return A * math.sin(w * t)


def sigma(s, b2, m2):
    return 1 / m2 * (s ** 2 - b2)


def oscill_zone(x, T, xs):
    k = -1
    if x <= T[0] + xs:
        if x <= T[2] + xs:
            if x <= T[4] + xs:
                if x >= T[5] + xs:
                    k = 4
            elif x >= T[3] + xs:
                k = 2
        elif x >= T[1] + xs:
            k = 0
    return k


def rkf(x, K1, K2, m, a, b, h, h2, h6, xs):
    xn = x
    kx1 = xn[2]; kv1 = f(xn, K1, K2, m, a, b, xs)
    xn[1] = x[1] + h2 * kx1; xn[2] = x[2] + h2 * kv1
    kx2 = xn[2]; kv2 = f(xn, K1, K2, m, a, b, xs)
    xn[1] = x[1] + h2 * kx2; xn[2] = x[2] + h2 * kv2
    kx3 = xn[2]; kv3 = f(xn, K1, K2, m, a, b, xs)
    xn[1] = x[1] + h * kx3; xn[2] = x[2] + h * kv3
    kx4 = xn[2]; kv4 = f(xn, K1, K2, m, a, b, xs)
    x[1] = x[1] + h6 * (kx1 + 2 * (kx2 + kx3) + kx4)
    x[2] = x[2] + h6 * (kv1 + 2 * (kv2 + kv3) + kv4)
    return x


def rk_inv(x, K1, K2, m, a, b, h, xs):
    h2 = h * 0.5; h6 = h * 0.166666; xn = x
    kv1 = 1 / f(xn, K1, K2, m, a, b, xs); kx1 = xn[2] * kv1
    xn[1] = x[1] + h2 * kx1; xn[2] = x[2] + h2
    kv2 = 1 / f(xn, K1, K2, m, a, b, xs); kx2 = xn[2] * kv2
    xn[1] = x[1] + h2 * kx2; kv3 = 1 / f(xn, K1, K2, m, a, b, xs)
    kx3 = xn[2] * kv3; xn[1] = x[1] + h * kx3
    xn[2] = x[2] + h; kv4 = 1 / f(xn, K1, K2, m, a, b, xs)
    kx4 = xn[2] * kv4
    x[1] = x[1] + h6 * (kx1 + 2 * (kx2 + kx3) + kx4)
    x[0] = x[0] + h6 * (kv1 + 2 * (kv2 + kv3) + kv4)
    return x


def listing():
    """Entries and exits (t, x1) of the stick phases of the printed run."""
    N, h0, mass, a, K1, K2 = 63.3e4, 1e-4, 0.1, 0.4, 1, 1
    m, c, b = 1 / mass, 2 * math.sqrt(3) / 3, math.sqrt(3) / 9
    A, w = 4 * math.sqrt(3) / 3 * math.sin(math.pi / 18), 3 * math.pi / 2 / 1.2364
    T = [c * math.cos(math.pi / 9), c * math.cos(2 * math.pi / 9), c * math.sin(math.pi / 18)]
    T += [-T[2], -T[1], -T[0]]
    x = xn = [0, T[3], a]
    xso = harmonic(A, w, x[0])
    slip, aft, k, i = 1, 0, oscill_zone(x[1], T, xso), 0
    entries, exits = [(x[0], x[1])], []
    while i <= N:
        if slip == 1:
            xn[1] = x[1] + h0 * x[2]
            xn[0] = x[0] + h0
            xs = harmonic(A, w, xn[0])
            if not xn[1] < T[k] + xs:
                slip = 0
                xn[1] = T[k] + xs; h = xn[1] - x[1]
                xn[0] = x[0] + h / x[2]
                exits.append((xn[0], xn[1]))
                xs = harmonic(A, w, xn[0])
                aft = -1 if k != 2 else 1
        else:
            pole = a + 1 if aft == -1 else a - 1
            xn = rkf(x, K1, K2, m, pole, b, h0, h0 / 2, h0 / 6, xso)
            if (xn[2] >= a) if aft == -1 else (xn[2] <= a):
                h = a - x[2] if aft == -1 else x[2] - a
                xn = rk_inv(x, K1, K2, m, pole, b, h, xso)
                xn[2] = a; xs = harmonic(A, w, xn[0])
                s = -K1 * (xn[1] - xs) + K2 * (xn[1] - xs) ** 3
                if sigma(s, b ** 2, m ** 2) <= 0:
                    k = oscill_zone(xn[1], T, xs)
                    slip = 1
                    entries.append((xn[0], xn[1]))
                else:
                    aft = -aft
            else:
                xn[0] = x[0] + h0
                xs = harmonic(A, w, xn[0])
        x = xn; xso = xs
        i += 1
    return entries, exits


# ---- Accurate solutions: Runge-Kutta steps that end on the belt's speed, and saltation. ----

def rk4(g, t, y, h):
    k1 = g(t, y)
    k2 = g(t + h / 2, [a + h / 2 * b for a, b in zip(y, k1)])
    k3 = g(t + h / 2, [a + h / 2 * b for a, b in zip(y, k2)])
    k4 = g(t + h, [a + h * b for a, b in zip(y, k3)])
    return [a + h / 6 * (p + 2 * (q + r) + s) for a, p, q, r, s in zip(y, k1, k2, k3, k4)]


def landing(g, t, y, h, event):
    """The part of the step at which `event`, positive before, is zero, by bisection."""
    low, high = 0.0, h
    for _ in range(60):
        middle = (low + high) / 2
        before = event(t + middle, rk4(g, t, y, middle)) > 0
        low, high = (middle, high) if before else (low, middle)
    return high


class System:
    """States and tangent vectors one after the other; the belt's speed is that of component 1."""

    def __init__(self, n, vp, slip, stick, holds):
        self.n, self.vp, self.slip, self.stick, self.holds = n, vp, slip, stick, holds

    def field(self, mode):
        return self.stick if mode == 0 else lambda t, y: self.slip(mode, t, y)

    def run(self, t, y, mode, t_end, h, meet=None):
        """Runs to t_end; calls meet(t, y, mode before, mode after) at every event."""
        n, vp = self.n, self.vp
        while t < t_end - 1e-12:
            g = self.field(mode)
            event = self.holds if mode == 0 else lambda _, x: mode * (x[1] - vp)
            step = min(h, t_end - t)
            new = rk4(g, t, y, step)
            if event(t + step, new) > 0:
                t, y = t + step, new
                continue
            step = landing(g, t, y, step, event)
            t, y, before = t + step, rk4(g, t, y, step), mode
            y[1] = vp
            rates = {side: self.slip(side, t, y)[1] for side in (-1, 1)}
            if mode == 0:
                mode = 1 if rates[-1] + rates[1] > 0 else -1
            elif rates[-1] > 0 > rates[1]:
                mode = 0
            else:
                mode = -mode
            if before != 0:  # at the end of a stick phase both fields agree
                old, now = g(t, y), self.field(mode)(t, y)
                for v in range(n, len(y), n):
                    part = y[v + 1] / old[1]
                    y[v:v + n] = [a + part * (q - p) for a, p, q in zip(y[v:v + n], old, now)]
                if mode == 0:
                    y[n + 1::n] = [0.0] * len(y[n + 1::n])
            if meet:
                meet(t, y, before, mode)
        return t, y, mode


MU = math.sqrt(3) / 9


def one_mass(mass, vp, cubic, amplitude, omega):
    """Models 1 and 2: x'' = (cubic (z^3 - z) - T)/m, z = x - A sin wt."""
    def slip(side, t, y):
        z = y[0] - amplitude * math.sin(omega * t)
        d = 1 + side * (y[1] - vp)
        spring, damping = cubic * (3 * z * z - 1) / mass, MU / d ** 2 / mass
        rates = [y[1], (cubic * (z ** 3 - z) - side * MU / d) / mass]
        for v in range(2, len(y), 2):
            rates += [y[v + 1], spring * y[v] + damping * y[v + 1]]
        return rates

    def stick(t, y):
        return [rate for v in range(0, len(y), 2) for rate in (y[v + 1], 0.0)]

    def holds(t, x):
        z = x[0] - amplitude * math.sin(omega * t)
        return MU - abs(z ** 3 - z)
    return System(2, vp, slip, stick, holds)


def cycle(system, x, period, transient, h=1e-3):
    """The attracting cycle without stick, of a period of about so much, begun where it crosses the
    belt's speed upwards: time and state there, and at the two crossings that follow."""
    def crossings(t, y, mode, span):
        met = []
        system.run(t, y, mode, t + span, h, lambda t, y, _, to: met.append((t, list(y), to)))
        return met
    t, y, mode = system.run(0.0, x, -1, transient * period, h)
    t, y, _ = next(one for one in crossings(t, y, mode, 1.2 * period) if one[2] == 1)
    down, up = crossings(t, y + [1.0, 0.0, 0.0, 1.0], 1, 1.2 * period)[:2]
    return t, down, up


def bracket(caption):
    """Model 3 with three tangent vectors; the contact cannot pull."""
    xi1, xi3, xi4, mu0, xi6, delta, vp = caption
    nu = xi6 / mu0

    def slip(side, t, y):
        normal = 1 - nu * y[2]
        slope = -nu if normal > 0 else 0.0
        normal = max(normal, 0.0)
        d = 1 + delta * side * (y[1] - vp)
        force, by3 = side * mu0 * normal / d, side * mu0 * slope / d
        by2 = -mu0 * normal * delta / d ** 2
        rates = [y[1], -y[0] - xi1 * (y[2] + force), y[3], xi3 * (-y[0] - xi4 * y[2])]
        for v in range(4, len(y), 4):
            a, b, c, e = y[v:v + 4]
            rates += [b, -a - xi1 * (c + by3 * c + by2 * b), e, xi3 * (-a - xi4 * c)]
        return rates

    def stick(t, y):
        rates = []
        for v in range(0, len(y), 4):
            rates += [y[v + 1], 0.0, y[v + 3], xi3 * (-y[v] - xi4 * y[v + 2])]
        return rates

    def holds(_, x):
        return mu0 * max(1 - nu * x[2], 0.0) - abs(-x[0] / xi1 - x[2])
    return System(4, vp, slip, stick, holds)


def spectrum(system, x, transient, duration, h=0.02, turn=1.0):
    """Three exponents by Gram-Schmidt; stick annihilates the fourth direction."""
    t, y, mode = system.run(0.0, x + [0.0] * 12, -1, transient, h)
    y[4:] = [1.0, 0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0]
    sums, begin = [0.0] * 3, t
    while t < begin + duration:
        t, y, mode = system.run(t, y, mode, t + turn, h)
        frame = []
        for k in range(3):
            v = y[4 + 4 * k:8 + 4 * k]
            for u in frame:
                part = sum(a * b for a, b in zip(u, v))
                v = [a - part * b for a, b in zip(v, u)]
            size = math.sqrt(sum(a * a for a in v))
            sums[k] += math.log(size)
            frame.append([a / size for a in v])
        y[4:] = sum(frame, [])
    return [one / duration for one in sums]


# ---- The comparison. ----

def main(folder):
    def golden(name, reading, quantity):
        for line in (folder / f"{name}.snap").read_text().splitlines():
            cells = line.split()
            if cells[:2] == [quantity, reading]:
                return float(cells[2])
        sys.exit(f"second opinion: {folder}/{name}.snap has no {quantity} ({reading})")

    failures = []

    def compare(what, here, wanted, allowed):
        agrees = abs(here - wanted) <= allowed
        answer = "yes" if agrees else "NO"
        print(f"{what:34} {here:<20.12g} {wanted:<20.12g} {allowed:<8.0e} {answer}")
        if not agrees:
            failures.append(what)

    print(f"{'quantity':34} {'here':20} {'golden':20} {'allowed':8} agrees")
    entries, exits = listing()
    last = [(out[1] - into[1], out[0] - into[0]) for into, out in zip(entries, exits)][-2:]
    for k, (length, duration) in enumerate(sorted(last, reverse=True), 1):
        # The platform's sine may differ in its last bit.
        for name, value in (("length", length), ("duration", duration)):
            name = f"fig08.stick_{name}.{k}"
            compare(name, value, golden("fig08", "as-printed", name), 1e-9)

    t, down, up = cycle(one_mass(1.0, 1.0, -1.0, 0.0, 0.0), [0.0, 0.9], 7.7, 14)
    for name, value in (("crossing.left", up[1][0]), ("crossing.right", down[1][0]),
                        ("period", up[0] - t), ("multiplier", determinant(up[1]))):
        name = f"fig04.limit_cycle.{name}"
        compare(name, value, golden("fig04", "exact", name), 1e-9)

    omega = 3 * math.pi / 2.4728
    forced = one_mass(0.1, 0.4, 1.0, 4 * math.sqrt(3) / 3 * math.sin(math.pi / 18), omega)
    t, down, up = cycle(forced, [-0.2, 0.0], 2 * math.pi / omega, 70)
    g = lambda name: golden("fig08", "exact", f"fig08.{name}")
    compare("fig08.crossing.left", up[1][0], g("crossing.left"), 1e-9)
    compare("fig08.crossing.right", down[1][0], g("crossing.right"), 1e-9)
    compare("fig08.slip_duration.above", down[0] - t, g("slip_duration.above"), 1e-9)
    compare("fig08.slip_duration.below", up[0] - down[0], g("slip_duration.below"), 1e-9)
    product = g("multiplier.modulus.1") * g("multiplier.modulus.2")
    compare("fig08 product of multipliers", determinant(up[1]), product, 1e-9)

    torus = bracket((0.413, 1.069, 1.980, 0.707, 0.693, 0.101, 0.707))
    # A window of 3000 instead of 9000; end effects and the sampling of the torus remain.
    for k, value in enumerate(spectrum(torus, [0.0, 0.0, 0.0, -0.1], 1000.0, 3000.0), 1):
        name = f"fig11.lambda.{k}"
        compare(name, value, golden("fig11", "corrected/equations", name), 6e-4)
    if failures:
        sys.exit(f"second opinion: {', '.join(failures)} differ from the golden files")


def determinant(y):
    return y[2] * y[5] - y[3] * y[4]


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent / "golden"))
