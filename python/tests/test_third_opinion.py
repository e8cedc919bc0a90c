"""Random hybrid systems by the engine and by brute force, which shares no code with it.

`STICKSLIP_DRAWS` is the number of systems; the gate draws few.
"""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import stickslip as ss

sys.path.insert(0, str(Path(__file__).parent))
from brute_force import STEP, Clock, Contact, Instant, Jump, Model, Record, orbit

COUNT = int(os.environ.get("STICKSLIP_DRAWS", 60))
FIRST = int(os.environ.get("STICKSLIP_FIRST_DRAW", 0))
END = 6.0
#: Allowed differences of times and states.
CLOSE = 1e-6
#: The engine's runs in pieces and in one may differ by this.
SAME = 1e-9
#: Least time between two instants where a run is cut.
GAP = 0.01


@dataclass
class Draw:
    """A model, and how its inputs are written for the engine. Discrete states come last."""

    states: list[str]
    discrete: list[str]
    start: list[float]
    rate: Callable[..., Any]
    contacts: list[Contact] = field(default_factory=list)
    jumps: list[Jump] = field(default_factory=list)
    clocks: list[Clock] = field(default_factory=list)
    inputs: list[Any] = field(default_factory=list)

    def model(self) -> Model:
        def rate(t, y, forces, inputs):
            return [*self.rate(t, y, forces, inputs), *(0.0 for _ in self.discrete)]

        return Model(rate, self.contacts, self.jumps, self.clocks)

    def system(self) -> ss.System:
        """System for the engine, from the same formulas."""
        states = [ss.state(name) for name in self.states]
        y = [*states, *(ss.DiscreteState(name) for name in self.discrete)]
        contacts, forces = [], []
        for one in self.contacts:
            laws: dict[str, Any] = {}
            if not one.name.startswith("relay"):
                laws["friction"] = lambda side, one=one: one.law(ss.t, y, side)
            if one.static is not None:
                laws["static"] = lambda side, one=one: one.static(ss.t, y, side)
            contacts.append(ss.Contact(one.name, boundary=one.slip(ss.t, y), **laws))
            forces.append(contacts[-1].friction if laws else contacts[-1].side)
        signs = {1: "rising", -1: "falling", 0: "both"}
        jumps = [
            ss.Jump(
                one.name,
                when=one.when(ss.t, y, self.inputs),
                direction=signs[one.direction],
                set={y[k]: new for k, new in one.set(ss.t, y).items()},
            )
            for one in self.jumps
        ]
        rates = dict(zip(states, self.rate(ss.t, y, forces, self.inputs)))
        # A discrete state that nothing else uses is a state, too.
        rates[states[0]] = rates[states[0]] + sum(0 * one for one in y[len(states) :])
        return ss.System(rates, contacts=contacts, jumps=jumps)


class Drawing:
    """Draws parts of systems."""

    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng([63, seed])

    def between(self, low: float, high: float) -> float:
        return round(float(self.random.uniform(low, high)), 4)

    def one_of(self, *of: Any) -> Any:
        return of[int(self.random.integers(len(of)))]

    def chance(self, share: float) -> bool:
        return bool(self.random.random() < share)

    def clock(self, number: int) -> tuple[Clock, Any]:
        """An input and how the engine writes it."""
        name, kind = f"u{number}", self.one_of("switch", "square", "pulse", "sawtooth", "table")
        period, phase = self.between(0.7, 4), self.one_of(0.0, self.between(0.05, 0.95))
        cycles = np.arange(-1, END / period + 2)
        if kind == "switch":
            w, shift, level = self.between(0.8, 4), self.between(0, 6), self.between(-0.8, 0.8)
            turns = np.arange(-2, END * w / (2 * np.pi) + 2) * 2 * np.pi
            rise = np.arcsin(level)
            flips = np.sort([(turns + a - shift) / w for a in (rise, np.pi - rise)], axis=None)
            flips = flips[flips >= 0]
            first = np.sign(np.sin(shift) - level)
            value = lambda k, t: first * (-1) ** k
            symbol = ss.Switch(name, np.sin(w * ss.t + shift) - level)
        elif kind in ("square", "pulse"):
            width = 0.5 if kind == "square" else self.between(0.1, 0.9)
            flips = np.sort([(cycles + a - phase) * period for a in (0, width)], axis=None)
            flips = flips[flips >= 0]
            # Before the first flip it is the opposite of what begins there.
            begins = bool(np.isclose((flips[0] / period + phase + 1e-9) % 1, 0, atol=1e-8))
            low, high = (-1.0, 1.0) if kind == "square" else (0.0, 1.0)
            value = lambda k, t: high if (k % 2 == 1) == begins else low
            more = {} if kind == "square" else {"width": width}
            symbol = getattr(ss, kind)(name, period=period, phase=phase, **more)
        elif kind == "sawtooth":
            flips = (cycles - phase) * period
            flips = flips[flips >= 0]
            at_first = 1 - flips[0] / period
            value = lambda k, t: t / period + at_first - k
            symbol = ss.sawtooth(name, period=period, phase=phase)
        else:
            flips = np.cumsum([self.between(0.3, 2) for _ in range(5)])
            values = [self.between(-1, 1) for _ in flips]
            value = lambda k, t: values[max(k - 1, 0)]
            symbol = ss.table(name, flips, values, between="constant")
        return Clock(name, [float(one) for one in flips], value), symbol

    def speed(self) -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
        """Speed of a belt, and its rate."""
        kind = self.one_of("rests", "constant", "swings", "swings")
        mean = 0.0 if kind == "rests" else self.between(-0.4, 0.4)
        size = self.between(0.05, 0.5) if kind == "swings" else 0.0
        w, shift = self.between(0.7, 3), self.between(0, 6)
        if not size:
            return lambda t: mean, lambda t: 0.0
        return (
            lambda t: mean + size * np.sin(w * t + shift),
            lambda t: size * w * np.cos(w * t + shift),
        )

    def friction(self, name: str, weights: Sequence[float], speed=None) -> Contact:
        size, fall = self.between(0.1, 0.9), self.one_of(0.0, 0.0, self.between(0.1, 0.8))
        moves, accelerates = speed or self.speed()
        above = self.one_of(None, None, self.between(1.05, 1.5))

        def slip(t, y):
            return sum(w * one for w, one in zip(weights, y) if w) - moves(t)

        def law(t, y, side):
            return size / (1 + fall * side * slip(t, y)) if fall else size

        static = None if above is None else lambda t, y, side: size * above
        return Contact(name, weights, law, static, moves, accelerates)


def blocks(draw: Drawing, count: int) -> Draw:
    """Blocks in a row, on belts or on each other, with springs, forces, walls and collisions."""
    n = count
    mass = [1.0 if draw.chance(0.5) else draw.between(0.4, 2) for _ in range(n)]
    spring = [draw.one_of(0.0, draw.between(0.3, 2.5)) for _ in range(n)]
    link = [draw.one_of(0.0, draw.between(0.2, 1.5)) for _ in range(n - 1)]
    damping, constant = draw.one_of(0.0, draw.between(0, 0.2)), draw.between(-0.3, 0.3)
    push = [draw.between(0.0, 1.6) for _ in range(n)]
    w, shift = draw.between(0.6, 2.6), draw.between(0, 6)
    clocks = [draw.clock(k) for k in range(draw.one_of(0, 1, 1, 2))]
    gain = [[draw.between(-0.8, 0.8) for _ in clocks] for _ in range(n)]
    memory = draw.one_of(0.0, draw.between(-0.6, 0.6))

    # The contact between blocks k and k - 1, or of block k on a belt.
    contacts, acts = [], []
    for k in range(n):
        if draw.chance(0.85 if k == 0 else 0.6):
            on = k - 1 if k and draw.chance(0.5) else None
            weights = [0.0] * (2 * n + 1)
            weights[n + k] = 1.0
            if draw.chance(0.15):
                # Jumps set the speed of the belt.
                weights[2 * n] = -draw.between(-0.6, 0.6)
            if on is not None:
                weights[n + on] = -1.0
            speed = (lambda t: 0.0, lambda t: 0.0) if on is not None else None
            contacts.append(draw.friction(f"c{k}", weights, speed))
            acts.append((k, on))

    def rate(t, y, forces, inputs):
        x, v, m = y[:n], y[n : 2 * n], y[2 * n]
        drive = np.sin(w * t + shift)
        total = []
        for k in range(n):
            force = push[k] * drive + constant - spring[k] * x[k] - damping * v[k]
            for g, u in zip(gain[k], inputs):
                force = force + g * u
            if k == 0 and memory:
                force = force + memory * m
            if k > 0:
                force = force + link[k - 1] * (x[k - 1] - x[k])
            if k < n - 1:
                force = force + link[k] * (x[k + 1] - x[k])
            for one, (body, on) in zip(forces, acts):
                if body == k:
                    force = force - one
                elif on == k:
                    force = force + one
            total.append(force / mass[k])
        return [*v, *total]

    names = [f"x{k}" for k in range(n)] + [f"v{k}" for k in range(n)]
    start = [draw.between(-1, 1) for _ in names]
    for k, one in enumerate(contacts):
        if draw.chance(0.4):
            body, on = acts[k]
            start[n + body] = float(one.speed(0.0)) + (start[n + on] if on is not None else 0.0)
    made = Draw(names, ["m", "n"], [*start, 0.0, 0.0], rate, contacts, [],
                [one for one, _ in clocks], [one for _, one in clocks])  # fmt: skip
    for number in range(draw.one_of(0, 1, 1, 2, 2, 3, 4)):
        made.jumps.append(block_jump(draw, made, n, number, mass))
    if made.jumps and draw.chance(0.3):
        # A second map at the same zeros, or at some of them.
        twin = draw.one_of(*made.jumps)
        effect = block_effect(draw, n, made)
        first = draw.chance(0.5)
        one = Jump("twin", twin.when, draw.one_of(twin.direction, 0), effect, twin.is_of_time)
        made.jumps.insert(0 if first else len(made.jumps), one)
    return made


def block_effect(draw: Drawing, n: int, made: Draw) -> Callable[[Any, Any], dict[int, Any]]:
    k, a = draw.one_of(*range(n)), draw.between(-0.6, 0.6)
    x, v, m, count = k, n + k, 2 * n, 2 * n + 1
    kind = draw.one_of("count", "count", "toggle", "kick", "damp", "shift", "stop", "both",
                       "sample")  # fmt: skip
    if kind == "stop" and made.contacts:
        one = draw.one_of(*made.contacts)
        if sum(map(bool, one.weights[: 2 * n])) == 1:
            which = next(k for k, w in enumerate(one.weights) if w)
            by_memory = one.weights[m]
            return lambda t, y: {which: one.speed(t) - by_memory * y[m], count: y[count] + 1}
    return {
        "toggle": lambda t, y: {m: 1 - y[m]},
        "sample": lambda t, y: {m: a * y[x] - 0.5 * y[v], count: y[count] + 1},
        "kick": lambda t, y: {v: y[v] + a, count: y[count] + 1},
        "damp": lambda t, y: {v: a * y[v]},
        "shift": lambda t, y: {x: y[x] + a / 2, m: 1 - y[m]},
        "both": lambda t, y: {v: a * y[v], m: 1 - y[m], count: y[count] + 1},
    }.get(kind, lambda t, y: {count: y[count] + 1})


def block_jump(draw: Drawing, made: Draw, n: int, number: int, mass: list[float]) -> Jump:
    name, k, a = f"j{number}", draw.one_of(*range(n)), draw.between(-0.8, 0.8)
    x, v, count = k, n + k, 2 * n + 1
    direction, keeps = draw.one_of(1, -1, 0), draw.between(0.1, 0.95)
    effect = block_effect(draw, n, made)
    kinds = ["wall", "wall", "moving wall", "velocity", "mixed", "energy", "time", "clock", "count"]
    kind = draw.one_of(*kinds, *["flip", "level"] * bool(made.clocks),
                       *["surface", "surface", "near stick"] * bool(made.contacts),
                       *["collision"] * 3 * (n > 1))  # fmt: skip
    if kind == "wall":
        a, side = draw.between(0.1, 1), draw.one_of(1, -1)
        if draw.chance(0.25):
            made.start[x], made.start[v] = side * a, side * abs(made.start[v])
        bounce = lambda t, y: {v: -keeps * y[v], count: y[count] + 1}
        return Jump(name, lambda t, y, u: y[x] - side * a, side, bounce)
    if kind == "moving wall":
        size, w = draw.between(0.05, 0.3), draw.between(0.5, 2)
        speed = lambda t: size * w * np.cos(w * t)
        bounce = lambda t, y: {v: speed(t) - keeps * (y[v] - speed(t))}
        return Jump(name, lambda t, y, u: y[x] - 0.5 - size * np.sin(w * t), 1, bounce)
    if kind == "collision":
        k = draw.one_of(*range(n - 1))
        gap, e = draw.between(0.1, 0.8), draw.one_of(1.0, keeps)
        p, q = mass[k], mass[k + 1]
        left, right = n + k, n + k + 1

        def collide(t, y):
            impulse = (1 + e) * p * q / (p + q) * (y[left] - y[right])
            return {left: y[left] - impulse / p, right: y[right] + impulse / q}

        return Jump(name, lambda t, y, u: y[k] - y[k + 1] - gap, 1, collide)
    if kind == "level":
        # A level that an input sets: it steps or moves.
        at, gain = draw.one_of(*range(len(made.clocks))), draw.between(0.2, 0.8)
        when = lambda t, y, u: y[x] - a / 2 - gain * u[at]
        return Jump(name, when, direction, effect)
    if kind == "velocity":
        return Jump(name, lambda t, y, u: y[v] - a / 2, direction, effect)
    if kind == "mixed":
        b = draw.between(-1, 1)
        return Jump(name, lambda t, y, u: y[x] + b * y[v] - a, direction, effect)
    if kind == "energy":
        level = abs(a) + 0.1
        return Jump(name, lambda t, y, u: y[x] * y[x] + y[v] * y[v] - level, direction, effect)
    if kind == "surface":
        one = draw.one_of(*made.contacts)
        return Jump(name, lambda t, y, u: one.slip(t, y), direction, effect)
    if kind == "near stick":
        # A velocity that the contact imposes: the level of the belt's speed at some time.
        one, level = draw.one_of(*made.contacts), draw.one_of(0.0, draw.between(-0.3, 0.3))
        which = max(k for k, w in enumerate(one.weights[: 2 * n]) if w)
        at = float(one.speed(draw.between(0, END)))
        return Jump(name, lambda t, y, u: y[which] + level * y[x] - at, direction, effect)
    if kind == "count":
        return Jump(name, lambda t, y, u: y[count] - 2.5, 1, lambda t, y: {count: 0.0, v: y[v] + a})
    if kind == "flip":
        clock = draw.one_of(*made.clocks)
        at = draw.one_of(*clock.flips[1:4])
        return Jump(name, lambda t, y, u: t - at, 1, effect, is_of_time=True)
    if kind == "clock":
        w = draw.between(1, 5)
        return Jump(name, lambda t, y, u: np.sin(w * t), direction, effect, is_of_time=True)
    at = draw.between(0.2, END)
    return Jump(name, lambda t, y, u: t - at, 1, effect, is_of_time=True)


def relay(draw: Drawing) -> Draw:
    """Three states with one or two relays that act on planes, and jumps in sliding."""
    n = 3
    matrix = [[draw.between(-0.8, 0.8) - 0.4 * (i == j) for j in range(n)] for i in range(n)]
    w, wave = draw.between(0.5, 2), [draw.between(-0.8, 0.8) for _ in range(n)]
    contacts, gains = [], []
    for k in range(draw.one_of(1, 1, 2)):
        weights = [float(k == i) if draw.chance(0.5) else draw.between(-1, 1) for i in range(n)]
        moves, accelerates = draw.speed()
        law = lambda t, y, side: 1.0
        contacts.append(Contact(f"relay{k}", weights, law, None, moves, accelerates))
        gains.append([draw.between(0.2, 1) * one for one in weights])
    clocks = [draw.clock(k) for k in range(draw.one_of(0, 0, 1))]

    def rate(t, y, forces, inputs):
        found = []
        for i in range(n):
            one = wave[i] * np.sin(w * t)
            for a, x in zip(matrix[i], y):
                one = one + a * x
            for gain, force in zip(gains, forces):
                one = one - gain[i] * force
            if i == 0:
                one = one + 0.5 * y[n]
                for u in inputs:
                    one = one + 0.4 * u
            found.append(one)
        return found

    jumps = []
    for number in range(draw.one_of(0, 1, 2, 2)):
        i, j = draw.one_of(*range(n)), draw.one_of(*range(n))
        a, b, size = draw.between(-0.5, 0.5), draw.between(-1, 1), draw.between(-0.9, 0.9)
        when = draw.one_of(
            lambda t, y, u, i=i, a=a: y[i] - a,
            lambda t, y, u, i=i, j=j, a=a, b=b: y[i] + b * y[j] - a,
            lambda t, y, u: contacts[0].slip(t, y),
            lambda t, y, u, a=a, i=i: contacts[0].slip(t, y) + y[i] - a,
        )
        effect = draw.one_of(
            lambda t, y: {n: 1 - y[n], n + 1: y[n + 1] + 1},
            lambda t, y: {n + 1: y[n + 1] + 1},
            lambda t, y, j=j, size=size: {j: size * y[j]},
            lambda t, y, j=j, size=size: {j: y[j] + size},
        )
        jumps.append(Jump(f"j{number}", when, draw.one_of(1, -1, 0), effect))
    start = [draw.between(-1, 1) for _ in range(n)]
    return Draw(["x", "y", "z"], ["m", "n"], [*start, 0.0, 0.0], rate, contacts, jumps,
                [one for one, _ in clocks], [one for _, one in clocks])  # fmt: skip


def position(draw: Drawing) -> Draw:
    """A relay and a jump on one surface of the position, with or without friction."""
    at, push, w = draw.between(-0.5, 0.5), draw.between(0.2, 1.5), draw.between(0.5, 2.5)
    wave, spring = draw.between(0, 1), draw.one_of(0.0, draw.between(0, 1.5))
    keeps = draw.between(0.3, 1)
    contacts = [Contact("relay", [1.0, 0.0], lambda t, y, s: 1.0, None, lambda t: at)]
    if draw.chance(0.5):
        contacts.insert(draw.one_of(0, 1), draw.friction("floor", [0.0, 1.0]))
    which = [one.name for one in contacts].index("relay")

    def rate(t, y, forces, inputs):
        total = wave * np.sin(w * t) - spring * y[0] - push * forces[which]
        for k, force in enumerate(forces):
            total = total - force if k != which else total
        return [y[1], total + 0.2 * y[2]]

    effect = draw.one_of(
        lambda t, y: {1: keeps * y[1], 3: y[3] + 1},
        lambda t, y: {1: -keeps * y[1], 3: y[3] + 1},
        lambda t, y: {2: 1 - y[2], 3: y[3] + 1},
        lambda t, y: {1: keeps * y[1], 2: 1 - y[2], 3: y[3] + 1},
    )
    jumps = [Jump("hit", lambda t, y, u: y[0] - at, draw.one_of(1, -1, 0, 0), effect)]
    if draw.chance(0.4):
        b, a = draw.between(-1, 1), draw.between(-0.8, 0.8)
        kick = lambda t, y: {1: y[1] + a}
        jumps.append(Jump("kick", lambda t, y, u: y[0] + b * y[1] - a, draw.one_of(1, -1), kick))
    start = [draw.one_of(at, draw.between(-1, 1)), draw.between(-1, 1)]
    return Draw(["x", "v"], ["m", "n"], [*start, 0.0, 0.0], rate, contacts, jumps)


def drawn(seed: int) -> Draw:
    draw = Drawing(seed)
    if seed % 10 == 7:
        return position(draw)
    return relay(draw) if seed % 5 == 4 else blocks(draw, draw.one_of(1, 1, 1, 2, 2, 3))


def agreed(draw: Draw) -> tuple[Record, list[Instant], float]:
    """What two sizes of steps find alike: the record, its instants, and a time up to which these
    are all, away from the next one."""
    fine, coarse = (orbit(draw.model(), (0.0, END), draw.start, h) for h in (STEP, 2 * STEP))
    until, instants = min(fine.t, coarse.t), []
    for one, other in zip(fine.instants, coarse.instants):
        alike = (one.jumps, one.before, one.after) == (other.jumps, other.before, other.after)
        if not alike or abs(one.t - other.t) > CLOSE / 3:
            until = min(until, one.t, other.t)
            break
        instants.append(one)
    else:
        more = fine.instants[len(instants) :] + coarse.instants[len(instants) :]
        until = min([until, *(one.t for one in more)])
    if not (fine.undecided or coarse.undecided) and until == END:
        return fine, instants, END
    while instants and until - instants[-1].t < GAP:
        until = instants.pop().t
    until = 0.5 * (until + (instants[-1].t if instants else 0.0))
    return orbit(draw.model(), (0.0, until), draw.start), instants, until


def solved(system: ss.System, span, y0, method: str) -> ss.Solution:
    with warnings.catch_warnings():
        warnings.simplefilter("error", ss.SolverWarning)
        # A velocity that starts in stick may be the rounding of zero.
        warnings.filterwarnings("ignore", "the state .* its motion is not resolved")
        # A jump of time alone is not carried out at the start by either.
        warnings.filterwarnings("ignore", ".* due by time alone at the start")
        return ss.solve_ivp(system, span, y0, method=method)


def instants_of(sol: ss.Solution) -> list[Instant]:
    """Transitions of one time together, and those that change nothing left out."""
    found: list[Instant] = []
    for row in sol.transitions:
        t, before, after = float(row["t"]), str(row["from_mode"]), str(row["to_mode"])
        is_jump = row["kind"] == "jump"
        if not is_jump:
            which = list(sol.system.contacts).index(row["contact"])
            names = {"S+": "stick exit", "S-": "stick exit", "+S": "stick entry",
                     "-S": "stick entry", "-+": "crossing", "+-": "crossing"}  # fmt: skip
            ends = before.split("|")[which] + after.split("|")[which]
            assert row["kind"] == names.get(ends, row["kind"]), row
        if not found or found[-1].t != t:
            y = row["y_before"].tolist()
            found.append(Instant(t, [], before, after, y, y))
        found[-1].jumps += [str(row["contact"])] * is_jump
        found[-1].after, found[-1].y_after = after, row["y"].tolist()
    return [one for one in found if one.jumps or one.before != one.after]


def difference(found: Sequence[Instant], wanted: Sequence[Instant], within: float) -> str:
    """The first of the instants that are not the same."""
    for k in range(max(len(found), len(wanted))):
        one, other = (of[k] if k < len(of) else None for of in (found, wanted))
        if one is None or other is None:
            return f"instant {k}: {one} in place of {other}"
        alike = (one.jumps, one.before, one.after) == (other.jumps, other.before, other.after)
        states = [one.y_before + one.y_after, other.y_before + other.y_after]
        far = not np.allclose(*states, rtol=0, atol=10 * within)
        if not alike or abs(one.t - other.t) > within or far:
            return f"instant {k}: {one} in place of {other}"
    return ""


def disagreement(seed: int) -> tuple[str, str, int]:
    """Differences of the engine from brute force, why they are undecided, and the instants."""
    draw = drawn(seed)
    record, instants, until = agreed(draw)
    if until < GAP:
        return "", record.undecided or "at the start", 0
    undecided = "" if until == END else "cut"
    system, faults = draw.system(), []
    for method in ("taylor", "dop853"):
        try:
            sol = solved(system, (0, until), draw.start, method)
            found = instants_of(sol)
            fault = difference(found, instants, CLOSE)
            if not fault and not np.allclose(sol.y[:, -1], record.y, rtol=0, atol=10 * CLOSE):
                fault = f"end: {sol.y[:, -1]} in place of {record.y}"
            if fault:
                faults.append(f"{method}: {fault}")
                continue
            if fault := of_pieces(system, draw, sol, found, until, method):
                faults.append(f"{method}, in pieces: {fault}")
        except (ss.StickslipError, ss.SolverWarning, ss.InternalError, AssertionError) as error:
            faults.append(f"{method}: {type(error).__name__}: {error}")
    return "\n".join(faults), undecided, len(instants)


def of_pieces(system, draw, sol, found, until, method) -> str:
    """Differences if the run is cut in the middle of phases."""
    times = [0.0, *(one.t for one in found), until]
    cuts = [(a + b) / 2 for a, b in zip(times, times[1:]) if b - a > GAP]
    cuts = cuts[:: max(1, len(cuts) // 4)]
    y, pieces = draw.start, []
    for span in zip([0.0, *cuts], [*cuts, until]):
        part = solved(system, span, y, method)
        pieces += instants_of(part)
        y = part.y[:, -1]
    fault = difference(pieces, found, SAME)
    if not fault and not np.allclose(y, sol.y[:, -1], rtol=0, atol=10 * SAME):
        fault = f"end: {y} in place of {sol.y[:, -1]}"
    return fault and f"cut at {cuts}: {fault}"


@pytest.mark.parametrize("count", [COUNT])
def test_engine_and_brute_force_agree_on_random_systems(count):
    faults, instants, undecided = [], 0, 0
    for seed in range(FIRST, FIRST + count):
        fault, why, several = disagreement(seed)
        instants += several
        undecided += bool(why)
        if fault:
            faults.append(f"draw {seed}:\n{fault}")
    assert not faults, "\n".join(faults)
    assert instants > 5 * count and undecided < 0.4 * count, (instants, undecided)
