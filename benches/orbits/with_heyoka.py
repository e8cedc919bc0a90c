"""heyoka: a Taylor integrator for each side, with a terminal event of one direction.

The stick phase is in closed form.
"""

import time

import heyoka as hy

from orbits import systems

VERSIONS = [("heyoka", hy.__version__)]
SETTINGS = (
    ("tol", 1e-4),
    ("tol", 1e-6),
    ("tol", 1e-8),
    ("tol", 1e-10),
    ("tol", 1e-12),
    ("tol", 1e-14),
    ("tol", 2.220446049250313e-16),
    ("tol high_accuracy", 2.220446049250313e-16),
)
# After a stick phase the start is a double zero of the event function, which heyoka may report. An
# event within this time is the start, and as long no event is searched for again. heyoka would
# derive that time from the slope, which is zero.
COOLDOWN = 1e-5


def curves(problem, system):
    for setting, tolerance in SETTINGS:

        def build(setting=setting, tolerance=tolerance):
            return prepare(problem, tolerance, "high" in setting, system)

        yield "heyoka", setting, tolerance, build


def prepare(problem, tolerance, high_accuracy, system):
    begin = time.perf_counter()
    integrators = {
        side: integrator(problem, side, tolerance, high_accuracy) for side in (1.0, -1.0)
    }
    compiled = time.perf_counter() - begin

    def slip(side, t, x, t_end):
        ta = integrators[side]
        ta.time = t
        ta.state[:] = x
        ta.reset_cooldowns()
        for _ in range(5):
            outcome = ta.propagate_until(t_end)[0]
            if outcome == hy.taylor_outcome.time_limit:
                return None
            if int(outcome) >= 0 or outcome == hy.taylor_outcome.err_nf_state:
                raise RuntimeError(f"heyoka stopped with {outcome}")
            if ta.time - t > COOLDOWN:
                x[:] = ta.state
                return ta.time
        raise RuntimeError(f"the event at the start of a phase, t = {t!r}, is reported repeatedly")

    def call():
        return systems.integrate(system, slip)

    return call, compiled


def integrator(problem, side, tolerance, high_accuracy):
    equations, boundary = expressions(problem, side)
    direction = hy.event_direction.negative if side > 0.0 else hy.event_direction.positive
    return hy.taylor_adaptive(
        equations,
        problem["start"],
        tol=tolerance,
        high_accuracy=high_accuracy,
        compact_mode=False,
        t_events=[hy.t_event(boundary, direction=direction, cooldown=COOLDOWN)],
    )


def expressions(problem, side):
    p, model = problem["parameters"], problem["model"]
    if model == "moving":
        x = hy.make_vars("x")
        return [(x, hy.expression(-side * p["speed"]))], x - hy.sin(hy.time)
    if model == "bracket":
        x1, x2, x3, x4 = hy.make_vars("x1", "x2", "x3", "x4")
        force = 1.0 - p["unloading"] * x3 - p["unloading_rate"] * x4
        friction = side * p["mu0"] * force / (1.0 + p["delta"] * side * (x2 - p["belt_speed"]))
        second = -x1 - p["coupling"] * (p["coupling_damping"] * (x2 + x4) + x3 + friction)
        pull = x1 + p["coupling_damping"] * x2
        pull += p["bracket_stiffness"] * x3 + p["bracket_damping"] * x4
        return [(x1, x2), (x2, second), (x3, x4), (x4, -p["mobility"] * pull)], x2 - p["belt_speed"]
    x, v = hy.make_vars("x", "v")
    sign, z = 1.0, x
    if model == "forced":
        sign, z = -1.0, x - p["amplitude"] * hy.sin(p["omega"] * hy.time)
    spring = sign * z * (p["k1"] - p["k2"] * z * z)
    friction = side * p["mu0"] / (1.0 + p["delta"] * side * (v - p["belt_speed"]))
    return [(x, v), (v, (spring - friction) / p["mass"])], v - p["belt_speed"]
