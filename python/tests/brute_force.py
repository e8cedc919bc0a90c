"""A third opinion on orbits: Runge–Kutta steps of a fixed size, sampled events, and bisection.

It shares no code with the engine. The record of an orbit ends where the error of the steps decides
what follows: at a graze, a force at its limit, two events too close to each other, or a future that
is not unique.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

STEP = 0.01
#: Time from an event to where the sides of functions that vanish at it are read.
SETTLING = 1e-3
#: Functions below `ZERO` vanish. Between it and `CLEAR`, and in other decisions, all is undecided.
ZERO, CLEAR = 1e-8, 1e-6
#: Least distance of a function from zero where it turns back, and of events from each other.
GRAZE, APART = 1e-7, 1e-6
#: Samples below this are looked at more closely if they are the least of three.
SUSPECT = 5e-3
#: Events in one instant, and in an orbit.
MOST_AT_ONCE, MOST_EVENTS = 20, 400


class Undecided(Exception):
    """A consequence depends on less than the error of this integrator."""


@dataclass(frozen=True)
class Contact:
    """Friction at the slip velocity `weights @ y - speed(t)`, between `-limit` and `limit`."""

    name: str
    weights: Sequence[float]
    law: Callable[..., Any]
    static: Callable[..., Any] | None = None
    speed: Callable[[Any], Any] = lambda t: 0.0
    acceleration: Callable[[Any], Any] = lambda t: 0.0

    def slip(self, t: Any, y: Any) -> Any:
        return sum(w * one for w, one in zip(self.weights, y) if w) - self.speed(t)

    def slip_rate(self, t: float, rates: Sequence[float]) -> float:
        return sum(w * one for w, one in zip(self.weights, rates) if w) - self.acceleration(t)

    def limit(self, t: float, y: Sequence[float], side: int) -> float:
        return (self.static or self.law)(t, y, side)


@dataclass(frozen=True)
class Jump:
    """A map of the state where `when(t, y, inputs)` passes zero. `set` gives new values by index of
    the state."""

    name: str
    when: Callable[[Any, Any, Any], Any]
    direction: int
    set: Callable[[Any, Any], dict[int, Any]]
    is_of_time: bool = False


@dataclass(frozen=True)
class Clock:
    """An input. It is smooth but at the times `flips`; `value` takes how many of them are past."""

    name: str
    flips: Sequence[float]
    value: Callable[[int, float], float]


@dataclass(frozen=True)
class Model:
    """`rate(t, y, forces, inputs)` is affine in the forces of the contacts, by constants."""

    rate: Callable[..., Any]
    contacts: Sequence[Contact] = ()
    jumps: Sequence[Jump] = ()
    clocks: Sequence[Clock] = ()


@dataclass
class Instant:
    """Events at one time: the jumps in order, and the modes before and after."""

    t: float
    jumps: list[str]
    before: str
    after: str
    y_before: list[float]
    y_after: list[float]


@dataclass
class Record:
    """An orbit up to `t`, where it ends or is `undecided`."""

    instants: list[Instant] = field(default_factory=list)
    t: float = 0.0
    y: list[float] = field(default_factory=list)
    mode: str = ""
    undecided: str = ""


#: What happens: its kind, the number of contact, jump or clock, and the side that stick ends to.
Event = tuple[str, int, int]
Function = Callable[[float, list[float]], float]
Guard = tuple[Event, Function]
END: Event = ("end", 0, 0)


class Sample(NamedTuple):
    """A state on the way, and the functions there."""

    t: float
    y: list[float]
    values: list[float]


class Orbit:
    """An orbit under way. A mode has 0 for a contact that sticks, or its side."""

    def __init__(self, model: Model, t: float, y: Sequence[float], step: float) -> None:
        self.model, self.t, self.y, self.step = model, t, [float(one) for one in y], step
        self.past = [sum(flip <= t for flip in clock.flips) for clock in model.clocks]
        self.responses: dict[tuple[int, ...], list[list[float]] | None] = {}
        self.mode = [0] * len(model.contacts)
        self.mode = self.sides(self.y)
        self.decide({})

    def inputs(self, t: float) -> list[float]:
        return [one.value(k, t) for one, k in zip(self.model.clocks, self.past)]

    def rate(self, t: float, y: list[float], forces: Sequence[float]) -> list[float]:
        return self.model.rate(t, y, forces, self.inputs(t))

    def jump_functions(self) -> list[float]:
        inputs = self.inputs(self.t)
        return [one.when(self.t, self.y, inputs) for one in self.model.jumps]

    def forces(self, t: float, y: list[float]) -> list[float]:
        """Friction by the law where a contact slips; where it sticks, what keeps it so."""
        contacts, mode = self.model.contacts, self.mode
        forces = [side * one.law(t, y, side) if side else 0.0 for side, one in zip(mode, contacts)]
        held = [k for k, side in enumerate(mode) if not side]
        if not held:
            return forces

        def slip_rates() -> list[float]:
            rates = self.rate(t, y, forces)
            return [contacts[k].slip_rate(t, rates) for k in held]

        free = slip_rates()
        if tuple(mode) not in self.responses:
            # What a unit of each force does, one column for each.
            columns = []
            for k in held:
                forces[k] = 1.0
                columns.append([one - other for one, other in zip(slip_rates(), free)])
                forces[k] = 0.0
            matrix = np.array(columns).T
            singular = abs(np.linalg.det(matrix)) < 1e-9
            self.responses[tuple(mode)] = None if singular else np.linalg.inv(matrix).tolist()
        inverse = self.responses[tuple(mode)]
        if inverse is None:
            raise np.linalg.LinAlgError
        for k, row in zip(held, inverse):
            forces[k] = -sum(a * b for a, b in zip(row, free))
        return forces

    def advance(self, h: float) -> list[float]:
        """The state after a step of the classical Runge–Kutta method."""
        def slope(t, y):
            return self.rate(t, y, self.forces(t, y))

        t, y = self.t, self.y
        a = slope(t, y)
        b = slope(t + h / 2, [x + h / 2 * d for x, d in zip(y, a)])
        c = slope(t + h / 2, [x + h / 2 * d for x, d in zip(y, b)])
        d = slope(t + h, [x + h * d for x, d in zip(y, c)])
        return [x + h / 6 * (p + 2 * q + 2 * r + s) for x, p, q, r, s in zip(y, a, b, c, d)]

    def named(self) -> str:
        return "|".join("-S+"[side + 1] for side in self.mode) or "·"

    def sides(self, y: list[float]) -> list[int]:
        """Sides by the slip velocities, 0 where they vanish."""
        slips = [one.slip(self.t, y) for one in self.model.contacts]
        if any(ZERO < abs(slip) < CLEAR for slip in slips):
            raise Undecided("a slip velocity is nearly zero")
        return [0 if abs(slip) <= ZERO else 1 if slip > 0 else -1 for slip in slips]

    def decide(self, leaving: dict[int, int]) -> None:
        """The mode of the contacts at rest: stick within the static limit, else a slip that the
        forces drive. `leaving` has the directions of those whose stick has just ended."""
        resting = [k for k, side in enumerate(self.mode) if not side]
        choices = [[leaving[k]] if k in leaving else [0, -1, 1] for k in resting]
        possible = []
        for sides in itertools.product(*choices):
            for k, side in zip(resting, sides):
                self.mode[k] = side
            try:
                forces = self.forces(self.t, self.y)
            except np.linalg.LinAlgError:
                continue
            rates, margin = self.rate(self.t, self.y, forces), np.inf
            for k, side in zip(resting, sides):
                one, force = self.model.contacts[k], forces[k]
                if not side:
                    high, low = (one.limit(self.t, self.y, s) for s in (1, -1))
                    margin = min(margin, high - force, force + low)
                elif k not in leaving:
                    margin = min(margin, side * one.slip_rate(self.t, rates))
            if abs(margin) < CLEAR:
                raise Undecided("a force is at its limit")
            if margin > 0:
                possible.append(sides)
        # What rests goes on resting if static friction holds it, even if it could slip as well.
        chosen = [sides for sides in possible if not any(sides)] or possible
        if len(chosen) != 1:
            raise Undecided("no motion is possible" if not chosen else "several are possible")
        for k, side in zip(resting, chosen[0]):
            self.mode[k] = side

    def guards(self) -> list[Guard]:
        """Functions whose zeros are events. Those of contacts fall to zero."""
        found: list[Guard] = []
        for k, (side, one) in enumerate(zip(self.mode, self.model.contacts)):
            if side:
                found.append((("slip", k, 0), lambda t, y, s=side, one=one: s * one.slip(t, y)))
            for s in () if side else (1, -1):
                left = lambda t, y, s=s, k=k, one=one: one.limit(t, y, s) - s * self.forces(t, y)[k]
                found.append((("stick", k, s), left))
        for k, one in enumerate(self.model.jumps):
            found.append((("jump", k, 0), lambda t, y, one=one: one.when(t, y, self.inputs(t))))
        return found

    def phase(self, t_end: float) -> list[Event]:
        """Steps to the next instant. Returns what happens there; nothing at the end."""
        guards = self.guards()
        flips = [
            (flip, ("clock", k, 0))
            for k, (clock, past) in enumerate(zip(self.model.clocks, self.past))
            for flip in clock.flips[past : past + 1]
        ]
        halt = min([t_end, *(flip for flip, _ in flips)])
        values = [g(self.t, self.y) for _, g in guards]
        leaves, sides = self.first_sides(guards, values, halt)
        before: Sample | None = None
        h = SETTLING
        while True:
            h = min(h, halt - self.t)
            here, end = Sample(self.t, self.y, values), self.advance(h)
            after = [g(self.t + h, end) for _, g in guards]
            hits: list[tuple[float, Event]] = []
            for n, (what, g) in enumerate(guards):
                if before or not leaves[n]:
                    zeros = self.zeros(g, sides[n], n, before, h, after[n])
                    hits += [(t, what) for t, way in zeros if self.counts(what, way)]
            if self.t + h >= halt:
                hits += [(flip, what) for flip, what in flips if flip <= halt + APART]
                hits += [(t_end, END)] if halt + APART > t_end else []
            if hits:
                t = min(hits)[0]
                found = [(at, what) for at, what in hits if at <= t + APART]
                if max(found)[0] - t > 1e-9:
                    raise Undecided("two events are nearly at one time")
                if before and t < here.t:
                    self.t, self.y = before.t, before.y
                self.t, self.y = t, self.advance(t - self.t)
                events = [what for _, what in found]
                # Rounding may hide that a function vanishes at the end of a step.
                for n, (what, g) in enumerate(guards):
                    is_new = what not in events and (before or not leaves[n])
                    if is_new and abs(g(t, self.y)) <= ZERO and self.counts(what, -sides[n]):
                        events.append(what)
                if END in events and len(events) > 1:
                    raise Undecided("an event is nearly at the end")
                return [what for what in events if what != END]
            for n, value in enumerate(after):
                if before or not leaves[n]:
                    sides[n] = np.sign(value) or sides[n]
            before, values, self.t, self.y, h = here, after, self.t + h, end, self.step

    def first_sides(
        self, guards: list[Guard], values: list[float], halt: float
    ) -> tuple[list[bool], list[float]]:
        """Functions that vanish at the start of a phase, and the sides to which they go."""
        if any(ZERO < abs(value) < CLEAR for value in values):
            raise Undecided("a function is nearly zero")
        leaves, sides = [abs(value) <= ZERO for value in values], [*map(np.sign, values)]
        if any(leaves) and halt - self.t < SETTLING:
            raise Undecided("an instant follows too soon")
        parts = [SETTLING / 100, SETTLING / 10, SETTLING / 3, SETTLING] if any(leaves) else []
        later = [(self.t + part, self.advance(part)) for part in parts]
        for n, (what, g) in enumerate(guards):
            if leaves[n]:
                # A contact may leave so slowly that rounding hides the first of these.
                near = [g(*at) for at in later[what[0] != "jump" :]]
                sides[n] = np.sign(near[-1])
                is_inside = what[0] != "jump" and sides[n] < 0
                if is_inside or min(v * sides[n] for v in near) <= 0 or abs(near[-1]) < 1e-9:
                    raise Undecided("a function does not leave zero")
        return leaves, sides

    def zeros(
        self, g: Function, side: float, n: int, before: Sample | None, h: float, after: float
    ) -> list[tuple[float, float]]:
        """Zeros of a function in a step, with their directions: by a change of sign, or two where
        the least of three samples is near zero."""

        def along(s: float) -> float:
            return side * g(self.t + s, self.advance(s))

        if after * side <= 0:
            return [(self.t + brentq(along, 0, h, xtol=1e-14), -side)]
        if not before or before.values[n] * side <= 0:
            return []
        here, now = (self.t, self.y), g(self.t, self.y)
        if abs(now) >= min(SUSPECT, abs(before.values[n]), abs(after)):
            return []
        width = self.t + h - before.t
        self.t, self.y = before.t, before.y
        low = minimize_scalar(along, bounds=(0, width), options={"xatol": 1e-9})
        if abs(low.fun) < GRAZE:
            raise Undecided("a function grazes zero")
        ends = [(0, low.x), (low.x, width)] if low.fun < 0 else []
        found = [self.t + brentq(along, *ends_of, xtol=1e-14) for ends_of in ends]
        self.t, self.y = here
        return list(zip(found, (-side, side)))

    def counts(self, what: Event, way: float) -> bool:
        """Whether a zero in this direction is an event."""
        return what[0] != "jump" or self.model.jumps[what[1]].direction * way >= 0

    def due_at_start(self) -> list[Event]:
        """Jumps of the state whose functions vanish and go in their direction."""
        found = []
        for k, (one, value) in enumerate(zip(self.model.jumps, self.jump_functions())):
            if abs(value) <= ZERO and not one.is_of_time:
                t = self.t + SETTLING
                goes = one.when(t, self.advance(SETTLING), self.inputs(t))
                if abs(goes) < CLEAR:
                    raise Undecided("a jump at the start")
                if one.direction * goes >= 0:
                    found.append(("jump", k, 0))
        return found

    def way(self, k: int) -> float:
        """Direction in which the motion leads the function of a jump that vanishes now."""
        goes = self.model.jumps[k].when(
            self.t + SETTLING, self.advance(SETTLING), self.inputs(self.t)
        )
        if abs(goes) < CLEAR:
            raise Undecided("a function that vanishes and stays")
        return goes

    def pass_instant(self, hits: list[Event]) -> Instant:
        """Clocks, then jumps in their order, then those that these set off, then the mode anew.

        A function that vanishes is led on by its own jump. If another jump turns it round, so that
        it goes in its direction from zero, its jump happens."""
        before, y_before, fired = self.named(), list(self.y), []
        due = sorted(k for kind, k, _ in hits if kind == "jump")
        old = self.jump_functions()
        at_zero = {k for k, value in enumerate(old) if abs(value) <= ZERO}
        ways: dict[int, float] = {}

        def find_due(old: list[float], but: int | None) -> None:
            """Adds the jumps whose functions have passed zero at once."""
            for n, (one, was, new) in enumerate(zip(self.model.jumps, old, self.jump_functions())):
                if n in at_zero:
                    if abs(new) > ZERO:
                        at_zero.remove(n)
                elif abs(new) < CLEAR and abs(was - new) > 1e-12:
                    raise Undecided("a function is led to zero")
                elif was * new < 0 and one.direction * new >= 0 and n not in (*due, but):
                    due.append(n)

        for kind, k, _ in hits:
            if kind == "clock":
                self.past[k] += 1
        by_motion = len(due)
        find_due(old, None)
        if 0 < by_motion < len(due):
            raise Undecided("the order of jumps where an input steps")
        while due:
            if len(fired) == MOST_AT_ONCE:
                raise Undecided("jumps follow each other without end")
            k, old = due.pop(0), self.jump_functions()
            fired.append(self.model.jumps[k].name)
            y = list(self.y)
            for which, value in self.model.jumps[k].set(self.t, self.y).items():
                y[which] = float(value)
            self.y = y
            find_due(old, k)
            self.mode = self.sides(self.y)
            self.decide({})
            for n in at_zero - set(due):
                way, before_it = self.way(n), ways.get(n)
                turns = n != k and before_it is not None and way * before_it < 0
                if turns and self.model.jumps[n].direction * way >= 0:
                    due.append(n)
                ways[n] = way
        hit = {k for kind, k, _ in hits if kind == "slip"}
        leaving = {k: side for kind, k, side in hits if kind == "stick"}
        if fired:
            self.mode = self.sides(self.y)
            leaving = {}
        else:
            self.mode = [0 if k in hit else side for k, side in enumerate(self.mode)]
            if any(kind == "clock" for kind, _, _ in hits):
                leaving = {}
        self.decide(leaving)
        return Instant(self.t, fired, before, self.named(), y_before, list(self.y))


def orbit(
    model: Model, span: tuple[float, float], y0: Sequence[float], step: float = STEP
) -> Record:
    """The orbit from a start, as far as it is decided."""
    record, under_way = Record(t=span[0], y=list(y0)), None
    try:
        under_way = Orbit(model, span[0], y0, step)
        record.mode = under_way.named()
        hits = under_way.due_at_start() or under_way.phase(span[1])
        while hits:
            if len(record.instants) == MOST_EVENTS:
                raise Undecided("there are too many events")
            record.t = under_way.t
            instant = under_way.pass_instant(hits)
            if instant.jumps or instant.before != instant.after:
                record.instants.append(instant)
            hits = under_way.phase(span[1])
        record.t, record.y, record.mode = under_way.t, under_way.y, under_way.named()
    except Undecided as reason:
        record.undecided = str(reason)
        record.t = max(record.t, under_way.t) if under_way else record.t
    return record
