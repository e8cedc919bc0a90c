"""The problems as Python functions, written so that numba can compile them.

A system is a namespace of functions made by `make(problem, jit)`. `jit` is numba.njit or a function
that changes nothing. Sides are 1.0 (above the boundary) and -1.0 (below).

    field(side, t, x, out)         derivative of the state
    boundary(t, x)                 h, negative below, positive above
    normal(side, t, x)             rate of h along the field of a side
    stick(t, x, t_end)             sticking in closed form: (end, side), side 0.0 if it lasts until
                                   t_end; moves x there
"""

import json
import math
import time
import types

# Halvings that take any interval here to neighbouring doubles.
HALVINGS = 80
# Time between two evaluations of the guards of a stick phase without closed form: an eightieth of
# the shortest period here, the forcing of model 2.
GUARD_INTERVAL = 0.02


def load(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def plain(function):
    return function


def make(problem, jit=plain):
    makers = {"belt": belt, "forced": forced, "moving": moving, "bracket": bracket}
    system = makers[problem["model"]](problem["parameters"], jit)
    system.start = problem["start"]
    system.t_start, system.t_end = problem["t_start"], problem["t_end"]
    system.compiled, system.compile_seconds = jit is not plain, 0.0
    return system


def make_compiled(problem, jit):
    """Systems on numpy arrays, compiled, with the time of compilation."""
    import numpy

    begin = time.perf_counter()
    system = make(problem, jit)
    system.start = numpy.array(system.start)
    x, out = system.start.copy(), system.start.copy()
    system.field(1.0, system.t_start, x, out)
    system.boundary(system.t_start, x)
    system.normal(1.0, system.t_start, x)
    system.stick(system.t_start, x, system.t_start)
    system.compile_seconds = time.perf_counter() - begin
    return system


def first_guard(jit, above, below):
    """The end of a stick phase: `above(t, t0, x)` rises through 0, or `below` falls through it."""

    @jit
    def find(t0, x, t_end):
        before = t0
        while before < t_end:
            after = min(before + GUARD_INTERVAL, t_end)
            end, side = t_end + 1.0, 0.0
            for candidate in (1.0, -1.0):
                # Both as functions that are negative while it sticks.
                last = above(after, t0, x) if candidate > 0.0 else -below(after, t0, x)
                if last > 0.0:
                    low, high = before, after
                    for _ in range(HALVINGS):
                        middle = 0.5 * (low + high)
                        if middle <= low or middle >= high:
                            break
                        value = above(middle, t0, x) if candidate > 0.0 else -below(middle, t0, x)
                        if value > 0.0:
                            high = middle
                        else:
                            low = middle
                    if high < end:
                        end, side = high, candidate
            if side != 0.0:
                return end, side
            before = after
        return t_end, 0.0

    return find


def cubic_ends(k1, k2, mu0):
    """Positions at which k1 x - k2 x³ is mu0 or -mu0, in ascending order.

    With each comes the side to which the body is released: above, where the spring pulls forward
    with more than the static friction.
    """
    ends = []
    for force, side in ((mu0, 1.0), (-mu0, -1.0)):
        if k2 == 0.0:
            roots = [force / k1]
        else:
            import numpy

            roots = numpy.roots([-k2, 0.0, k1, -force])
            roots = [root.real for root in roots if abs(root.imag) < 1e-6]
        for root in roots:
            for _ in range(3):
                slope = k1 - 3.0 * k2 * root * root
                if slope != 0.0:
                    root -= (k1 * root - k2 * root**3 - force) / slope
            # Beyond the root the force must exceed static friction.
            slope = k1 - 3.0 * k2 * root * root
            if slope * side > 0.0:
                ends.append((root, side))
    return sorted(ends)


def belt(p, jit):
    mass, k1, k2, mu0, delta, vp = (
        p[name] for name in ("mass", "k1", "k2", "mu0", "delta", "belt_speed")
    )
    ends = cubic_ends(k1, k2, mu0)
    positions = tuple(position for position, _ in ends)
    sides = tuple(side for _, side in ends)

    @jit
    def field(side, t, x, out):
        v = x[1]
        friction = side * mu0 / (1.0 + delta * side * (v - vp))
        out[0] = v
        out[1] = (x[0] * (k1 - k2 * x[0] * x[0]) - friction) / mass

    @jit
    def boundary(t, x):
        return x[1] - vp

    @jit
    def normal(side, t, x):
        friction = side * mu0 / (1.0 + delta * side * (x[1] - vp))
        return (x[0] * (k1 - k2 * x[0] * x[0]) - friction) / mass

    @jit
    def stick(t, x, t_end):
        side, position = 0.0, x[0] + vp * (t_end - t)
        for i in range(len(positions)):
            if x[0] < positions[i] <= position:
                position, side = positions[i], sides[i]
        end = t_end if side == 0.0 else t + (position - x[0]) / vp
        x[0], x[1] = position, vp
        return end, side

    return types.SimpleNamespace(
        field=field, boundary=boundary, normal=normal, stick=stick, speed=vp
    )


def forced(p, jit):
    mass, k1, k2, mu0, delta, vp, amplitude, omega = (
        p[name] for name in ("mass", "k1", "k2", "mu0", "delta", "belt_speed", "amplitude", "omega")
    )
    sin = math.sin

    @jit
    def field(side, t, x, out):
        v = x[1]
        z = x[0] - amplitude * sin(omega * t)
        out[0] = v
        out[1] = (z * (k2 * z * z - k1) - side * mu0 / (1.0 + delta * side * (v - vp))) / mass

    @jit
    def boundary(t, x):
        return x[1] - vp

    @jit
    def normal(side, t, x):
        z = x[0] - amplitude * sin(omega * t)
        return (z * (k2 * z * z - k1) - side * mu0 / (1.0 + delta * side * (x[1] - vp))) / mass

    @jit
    def above(t, t0, x):
        z = x[0] + vp * (t - t0) - amplitude * sin(omega * t)
        return z * (k2 * z * z - k1) - mu0

    @jit
    def below(t, t0, x):
        z = x[0] + vp * (t - t0) - amplitude * sin(omega * t)
        return z * (k2 * z * z - k1) + mu0

    find = first_guard(jit, above, below)

    @jit
    def stick(t, x, t_end):
        end, side = find(t, x, t_end)
        x[0] += vp * (end - t)
        x[1] = vp
        return end, side

    return types.SimpleNamespace(
        field=field, boundary=boundary, normal=normal, stick=stick, speed=vp
    )


def moving(p, jit):
    speed = p["speed"]
    sin, cos, pi, angle = math.sin, math.cos, math.pi, math.acos(p["speed"])

    @jit
    def field(side, t, x, out):
        out[0] = -side * speed

    @jit
    def boundary(t, x):
        return x[0] - sin(t)

    @jit
    def normal(side, t, x):
        return -side * speed - cos(t)

    @jit
    def stick(t, x, t_end):
        # It ends where |cos t| rises to the speed: at a multiple of pi less the angle.
        turn = math.floor((t + angle) / pi) + 1.0
        end = turn * pi - angle
        if end > t_end:
            x[0] = sin(t_end)
            return t_end, 0.0
        x[0] = sin(end)
        side = 1.0 if cos(end) < 0.0 else -1.0
        return end, side

    return types.SimpleNamespace(
        field=field, boundary=boundary, normal=normal, stick=stick, speed=None
    )


def bracket(p, jit):
    coupling, damping, mobility, stiffness, bracket_damping, mu0, unloading, rate, delta, vp = (
        p[name]
        for name in (
            "coupling",
            "coupling_damping",
            "mobility",
            "bracket_stiffness",
            "bracket_damping",
            "mu0",
            "unloading",
            "unloading_rate",
            "delta",
            "belt_speed",
        )
    )
    if damping != 0.0 or bracket_damping != 0.0:
        raise ValueError("the closed form of sticking is for a bracket without dampers")
    sin, cos = math.sin, math.cos
    frequency = math.sqrt(mobility * stiffness)

    @jit
    def acceleration(side, x):
        force = max(1.0 - unloading * x[2] - rate * x[3], 0.0)
        friction = side * mu0 * force / (1.0 + delta * side * (x[1] - vp))
        return -x[0] - coupling * (damping * (x[1] + x[3]) + x[2] + friction)

    @jit
    def field(side, t, x, out):
        out[0] = x[1]
        out[1] = acceleration(side, x)
        out[2] = x[3]
        out[3] = -mobility * (x[0] + damping * x[1] + stiffness * x[2] + bracket_damping * x[3])

    @jit
    def boundary(t, x):
        return x[1] - vp

    @jit
    def normal(side, t, x):
        return acceleration(side, x)

    @jit
    def stuck(t, t0, x):
        # x3'' = -mobility (stiffness x3 + x1), where x1 grows linearly: a line and an oscillation
        # about it.
        time = t - t0
        line, slope = -x[0] / stiffness, -vp / stiffness
        cosine, sine = x[2] - line, (x[3] - slope) / frequency
        c, s = cos(frequency * time), sin(frequency * time)
        return (
            x[0] + vp * time,
            line + slope * time + cosine * c + sine * s,
            slope + frequency * (sine * c - cosine * s),
        )

    @jit
    def above(t, t0, x):
        x1, x3, x4 = stuck(t, t0, x)
        return -x1 - coupling * (x3 + mu0 * (1.0 - unloading * x3 - rate * x4))

    @jit
    def below(t, t0, x):
        x1, x3, x4 = stuck(t, t0, x)
        return -x1 - coupling * (x3 - mu0 * (1.0 - unloading * x3 - rate * x4))

    find = first_guard(jit, above, below)

    @jit
    def stick(t, x, t_end):
        end, side = find(t, x, t_end)
        x1, x3, x4 = stuck(end, t, x)
        x[0], x[1], x[2], x[3] = x1, vp, x3, x4
        return end, side

    return types.SimpleNamespace(
        field=field, boundary=boundary, normal=normal, stick=stick, speed=vp
    )


def starting_mode(system, t, x):
    """The mode at a start: 0.0 where it sticks."""
    h = system.boundary(t, x)
    if h != 0.0:
        return 1.0 if h > 0.0 else -1.0
    if system.normal(-1.0, t, x) > 0.0 > system.normal(1.0, t, x):
        return 0.0
    return 1.0 if system.normal(1.0, t, x) > 0.0 else -1.0


def integrate(system, slip):
    """The events of an orbit, phase by phase.

    `slip(side, t, x, t_end)` moves x along a side until the boundary and returns the time, or None
    if t_end comes first.
    """
    t, x = system.t_start, system.start.copy()
    mode, events = starting_mode(system, t, x), []
    while True:
        if mode == 0.0:
            t, mode = system.stick(t, x, system.t_end)
            if mode == 0.0:
                return events
            events.append(("exit", t))
            continue
        t = slip(mode, t, x, system.t_end)
        if t is None:
            return events
        if system.speed is not None:
            x[1] = system.speed
        if system.normal(-1.0, t, x) > 0.0 > system.normal(1.0, t, x):
            mode = 0.0
            events.append(("entry", t))
        else:
            mode = -mode
            events.append(("crossing", t))
        if len(events) > 10_000:
            raise RuntimeError("10000 events: transitions accumulate at the boundary")
