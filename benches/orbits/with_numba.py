"""Everything compiled by numba, with the mode machine.

One solver is Runge-Kutta of order 4 with a fixed step and Henon's step onto the boundary. The other
is DOP853 with SciPy's coefficients and step-size control; Newton's method on the length of the last
step locates events.
"""

import time

import llvmlite
import numba
import numpy
from numba import njit
from scipy.integrate._ivp import dop853_coefficients as coefficients

from orbits import systems

VERSIONS = [("numba", numba.__version__), ("llvmlite", llvmlite.__version__)]
STEPS = (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4)
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14)
KINDS = ("crossing", "entry", "exit")
# Most events of a run.
EVENT_LIMIT = 10_000

STAGES = coefficients.N_STAGES
A = coefficients.A[:STAGES, :STAGES].copy()
B = coefficients.B.copy()
C = coefficients.C[:STAGES].copy()
E3 = coefficients.E3.copy()
E5 = coefficients.E5.copy()


def curves(problem, system):
    built = {}

    def builder(name, make_slip, parameter):
        def build():
            compiled = 0.0
            if name not in built:
                begin = time.perf_counter()
                run = machine(problem, make_slip)
                run(parameter)
                compiled = time.perf_counter() - begin
                built[name] = run, compiled
            run, compiled = built[name]

            def call():
                kinds, times = run(parameter)
                return [(KINDS[kind], t) for kind, t in zip(kinds.tolist(), times.tolist())]

            return call, compiled

        return build

    for step in STEPS:
        yield "numba RK4 + Henon", "fixed step", step, builder("rk4", rk4_slip, step)
    for tolerance in TOLERANCES:
        yield "numba DOP853", "rtol = atol", tolerance, builder("dop853", dop853_slip, tolerance)


def machine(problem, make_slip):
    system = systems.make(problem, njit)
    normal, boundary, stick = system.normal, system.boundary, system.stick
    start, t_start, t_end = numpy.array(system.start), system.t_start, system.t_end
    on_velocity, speed = system.speed is not None, system.speed or 0.0
    slip = make_slip(system, len(start))

    @njit
    def run(parameter):
        kinds, times = numpy.empty(EVENT_LIMIT, numpy.int64), numpy.empty(EVENT_LIMIT)
        count = 0
        t, x = t_start, start.copy()
        memory = numpy.zeros(1)
        h = boundary(t, x)
        if h != 0.0:
            mode = 1.0 if h > 0.0 else -1.0
        elif normal(-1.0, t, x) > 0.0 and normal(1.0, t, x) < 0.0:
            mode = 0.0
        else:
            mode = 1.0 if normal(1.0, t, x) > 0.0 else -1.0
        while count < EVENT_LIMIT:
            if mode == 0.0:
                t, mode = stick(t, x, t_end)
                if mode == 0.0:
                    break
                kind = 2
            else:
                t, found = slip(mode, t, x, t_end, parameter, memory)
                if not found:
                    break
                if on_velocity:
                    x[1] = speed
                if normal(-1.0, t, x) > 0.0 and normal(1.0, t, x) < 0.0:
                    mode = 0.0
                    kind = 1
                else:
                    mode = -mode
                    kind = 0
            kinds[count] = kind
            times[count] = t
            count += 1
        return kinds[:count].copy(), times[:count].copy()

    return run


def rk4_slip(system, size):
    field, boundary, normal = system.field, system.boundary, system.normal

    @njit
    def rk4(side, t, x, h, k, trial, new):
        field(side, t, x, k[0])
        for i in range(size):
            trial[i] = x[i] + 0.5 * h * k[0, i]
        field(side, t + 0.5 * h, trial, k[1])
        for i in range(size):
            trial[i] = x[i] + 0.5 * h * k[1, i]
        field(side, t + 0.5 * h, trial, k[2])
        for i in range(size):
            trial[i] = x[i] + h * k[2, i]
        field(side, t + h, trial, k[3])
        for i in range(size):
            new[i] = x[i] + h / 6.0 * (k[0, i] + 2.0 * k[1, i] + 2.0 * k[2, i] + k[3, i])

    @njit
    def henon(side, t, x, k, trial):
        """Runge-Kutta with h as the independent variable, from beyond the boundary back onto it."""
        length = -boundary(t, x)
        parts = numpy.empty(4)
        parts[0] = 1.0 / normal(side, t, x)
        field(side, t, x, k[0])
        for stage in range(1, 4):
            share = 1.0 if stage == 3 else 0.5
            for i in range(x.size):
                trial[i] = x[i] + share * length * k[stage - 1, i] * parts[stage - 1]
            time = t + share * length * parts[stage - 1]
            parts[stage] = 1.0 / normal(side, time, trial)
            field(side, time, trial, k[stage])
        sixth = length / 6.0
        for i in range(x.size):
            x[i] += sixth * (
                k[0, i] * parts[0]
                + 2.0 * k[1, i] * parts[1]
                + 2.0 * k[2, i] * parts[2]
                + k[3, i] * parts[3]
            )
        return t + sixth * (parts[0] + 2.0 * parts[1] + 2.0 * parts[2] + parts[3])

    @njit
    def slip(side, t, x, t_end, step, memory):
        k, trial, new = numpy.empty((4, size)), numpy.empty(size), numpy.empty(size)
        while t < t_end:
            last = t + step >= t_end
            h = t_end - t if last else step
            rk4(side, t, x, h, k, trial, new)
            t = t_end if last else t + h
            for i in range(size):
                x[i] = new[i]
            if side * boundary(t, x) < 0.0:
                for _ in range(3):
                    t = henon(side, t, x, k, trial)
                return t, True
        return t, False

    return slip


def dop853_slip(system, size):
    field, boundary, normal = system.field, system.boundary, system.normal
    stages = STAGES

    @njit
    def step(side, t, x, h, k, trial, new):
        """k[0] is given."""
        for s in range(1, stages):
            for i in range(size):
                total = 0.0
                for j in range(s):
                    total += A[s, j] * k[j, i]
                trial[i] = x[i] + h * total
            field(side, t + C[s] * h, trial, k[s])
        for i in range(size):
            total = 0.0
            for j in range(stages):
                total += B[j] * k[j, i]
            new[i] = x[i] + h * total

    @njit
    def error(x, new, h, k, tolerance):
        five, three = 0.0, 0.0
        for i in range(size):
            scale = tolerance * (1.0 + max(abs(x[i]), abs(new[i])))
            e5, e3 = 0.0, 0.0
            for j in range(stages + 1):
                e5 += E5[j] * k[j, i]
                e3 += E3[j] * k[j, i]
            five += (e5 / scale) ** 2
            three += (e3 / scale) ** 2
        if five == 0.0 and three == 0.0:
            return 0.0
        return abs(h) * five / numpy.sqrt((five + 0.01 * three) * size)

    @njit
    def land(side, t, x, high, k, trial, new):
        """Moves x onto the boundary, which a step of `high` crosses, and returns the time."""
        low, s = 0.0, high
        for _ in range(60):
            step(side, t, x, s, k, trial, new)
            h = boundary(t + s, new)
            if side * h < 0.0:
                high = s
            else:
                low = s
            if h == 0.0:
                break
            following = s - h / normal(side, t + s, new)
            if not (low < following < high):
                following = 0.5 * (low + high)
            if abs(following - s) <= 1e-16 * (1.0 + abs(t)):
                break
            s = following
        for i in range(size):
            x[i] = new[i]
        return t + s

    @njit
    def slip(side, t, x, t_end, tolerance, memory):
        k, trial, new = numpy.empty((stages + 1, size)), numpy.empty(size), numpy.empty(size)
        field(side, t, x, k[0])
        # The last step of the previous phase is a good first one.
        h = memory[0] if memory[0] > 0.0 else 0.01
        toward = side * normal(side, t, x)
        while t < t_end:
            h = min(h, t_end - t)
            last = t + h >= t_end
            step(side, t, x, h, k, trial, new)
            field(side, t + h, new, k[stages])
            size_of_error = error(x, new, h, k, tolerance)
            if not size_of_error <= 1.0:
                is_number = size_of_error == size_of_error
                h *= max(0.2, 0.9 * size_of_error**-0.125) if is_number else 0.2
                if h < 1e-14 * (1.0 + abs(t)):
                    return t, False
                continue
            now = side * normal(side, t + h, new)
            if side * boundary(t + h, new) < 0.0:
                memory[0] = h
                return land(side, t, x, h, k, trial, new), True
            if toward < 0.0 < now:
                # The boundary came nearer and receded: test the minimum that the rates predict.
                nearest = h * toward / (toward - now)
                kept = k[stages].copy()
                end = new.copy()
                step(side, t, x, nearest, k, trial, new)
                if side * boundary(t + nearest, new) < 0.0:
                    memory[0] = h
                    return land(side, t, x, nearest, k, trial, new), True
                for i in range(size):
                    k[stages, i], new[i] = kept[i], end[i]
            toward = now
            t = t_end if last else t + h
            for i in range(size):
                x[i] = new[i]
                k[0, i] = k[stages, i]
            h *= min(10.0, 0.9 * size_of_error**-0.125) if size_of_error > 0.0 else 10.0
        return t, False

    return slip
