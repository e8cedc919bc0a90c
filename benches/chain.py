"""The chain of blocks of crates/stickslip/examples/chain.rs by SciPy's solve_ivp.

Events and modes are written by hand.

    target/bench-venv/bin/python benches/chain.py [blocks ...] [--events]

`make bench-peers` makes that environment. Ours beside it: `cargo bench -p stickslip --bench chain`,
and the example.

Each contact has an event function: the slip speed where it slips, and the friction that is left
where it sticks. After each event its contact decides for itself. That is right here, because each
block's friction acts on that block alone.

Left out: friction of blocks on one another, where the contacts must be decided together; contacts
that reach zero at the same time; touches, from which a guard returns within one step, and two zeros
of a guard in one step, both of which signs at the ends of steps do not show; static friction;
moving boundaries.
"""

import argparse
import time

import numpy
from scipy.integrate import solve_ivp

BELT_SPEED, COUPLING, LEAF, FRICTION, WEAKENING = 0.05, 0.5, 1.0, 1.0, 3.0


def springs(x):
    force = -LEAF * x
    stretch = COUPLING * numpy.diff(x)
    force[:-1] += stretch
    force[1:] -= stretch
    return force


def integrate(blocks, tolerance, t_end):
    """Events as (time, block, sides afterwards), and the number of steps; side 0 sticks."""
    sides = numpy.zeros(blocks)

    def field(_t, state):
        x, v = state[:blocks], state[blocks:]
        friction = sides * FRICTION / (1.0 + WEAKENING * (v - BELT_SPEED) * sides)
        return numpy.concatenate((v, numpy.where(sides == 0.0, 0.0, springs(x) - friction)))

    def event(i):
        def guard(_t, state):
            if sides[i] == 0.0:
                return FRICTION - abs(springs(state[:blocks])[i])
            return (state[blocks + i] - BELT_SPEED) * sides[i]

        guard.terminal, guard.direction = True, -1.0
        return guard

    guards = [event(i) for i in range(blocks)]
    t, events, steps = 0.0, [], 0
    positions = 0.05 * numpy.sin(5.0 * numpy.arange(1, blocks + 1))
    state = numpy.concatenate((positions, numpy.full(blocks, BELT_SPEED)))
    settings = {"method": "DOP853", "rtol": tolerance, "atol": tolerance, "events": guards}
    while t < t_end:
        run = solve_ivp(field, (t, t_end), state, **settings)
        if run.status < 0:
            raise RuntimeError(run.message)
        steps += len(run.t) - 1
        t, state = run.t[-1], run.y[:, -1].copy()
        for i in range(blocks):
            if len(run.t_events[i]):
                pull = springs(state[:blocks])[i]
                is_held = sides[i] != 0.0 and abs(pull) < FRICTION
                sides[i] = 0.0 if is_held else numpy.sign(pull)
                state[blocks + i] = BELT_SPEED
                events.append((t, i, sides.copy()))
    return events, steps


def main():
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("blocks", type=int, nargs="*", default=[1, 2, 4, 8])
    parser.add_argument("--events", action="store_true", help="print every event")
    parser.add_argument("--tolerance", type=float, default=1e-10)
    wanted = parser.parse_args()
    for blocks in wanted.blocks:
        best = float("inf")
        for _ in range(3):
            begin = time.perf_counter()
            events, steps = integrate(blocks, wanted.tolerance, 100.0)
            best = min(best, time.perf_counter() - begin)
        if wanted.events:
            for t, i, sides in events:
                signs = "".join("<=>"[int(side) + 1] for side in sides)
                print(f"t = {t:12.8f}  block {i}  {signs}")
        per_step = 1e6 * best / max(steps, 1)
        print(
            f"SciPy, {blocks} blocks: {len(events)} events, {steps} steps, {best:.3f} s, "
            f"{per_step:.0f} us a step"
        )


if __name__ == "__main__":
    main()
