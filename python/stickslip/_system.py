"""Systems: built from symbols or read from a text, and handed to the engine as that text."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from . import _core
from ._symbols import (
    Contact,
    DiscreteState,
    Expression,
    Input,
    Jump,
    Parameter,
    State,
    Switch,
    expression,
    number,
    written,
)


class System:
    """A system with its parameters.

    `rates` has the rate of each state, in the order of the states. Parameters, inputs, switches and
    discrete states are found in the formulas; contacts and jumps are given. A pickle is the text of
    the system and the values of its parameters.
    """

    def __init__(
        self,
        rates: Mapping[State, Any],
        *,
        contacts: Iterable[Contact] = (),
        jumps: Iterable[Jump] = (),
        start: Mapping[State, Any] | Sequence[Any] | None = None,
        period: Any = None,
        name: str = "system",
    ) -> None:
        text = _text(rates, tuple(contacts), tuple(jumps), start, period, name)
        self._set(name, text, {})

    def _set(self, origin: str, text: str, settings: Mapping[str, float]) -> None:
        self._origin, self._text, self._settings = origin, text, dict(settings)
        self._core = _core.System(origin, text, list(settings.items()))
        self._sections: dict[tuple[str, int], _core.System] = {}

    def _section(self, function: str, direction: int) -> _core.System:
        """The same with a section, kept for further runs."""
        key = (function, direction)
        if key not in self._sections:
            if len(self._sections) >= 64:
                self._sections.clear()
            self._sections[key] = self._core.with_section(*key)
        return self._sections[key]

    @classmethod
    def _of(cls, origin: str, text: str, settings: Mapping[str, float]) -> System:
        system = cls.__new__(cls)
        system._set(origin, text, settings)
        return system

    @classmethod
    def from_toml(cls, source: str | os.PathLike[str]) -> System:
        """The system of a file, of a shipped model by its name, or of a text."""
        if isinstance(source, str) and "\n" in source:
            return cls._of("text", source, {})
        path = os.fspath(source)
        return cls._of(path, _core.System.text_of(path), {})

    def to_toml(self) -> str:
        """The text that the program `stickslip` reads. It has the values that the system was
        built with; those of `with_parameters` are given to the program by `--set`."""
        return self._text

    def with_parameters(self, **values: float) -> System:
        """The same system with other values of some parameters."""
        checked = {name: number(value, f"the parameter {name}") for name, value in values.items()}
        return self._of(self._origin, self._text, {**self._settings, **checked})

    @property
    def name(self) -> str:
        """What it is called."""
        return self._core.name

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states, in their order; discrete ones stand last."""
        return tuple(self._core.states)

    @property
    def parameters(self) -> dict[str, float]:
        """Values of the parameters by name."""
        return dict(self._core.parameters)

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the contacts."""
        return tuple(self._core.contacts_and_jumps[0])

    @property
    def jumps(self) -> tuple[str, ...]:
        """Names of the jumps."""
        return tuple(self._core.contacts_and_jumps[1])

    @property
    def start(self) -> tuple[float, ...] | None:
        """Where runs begin, if the system says so."""
        start = self._core.start[1]
        return None if start is None else tuple(start)

    @property
    def period(self) -> float | None:
        """Period in time, of a driven system."""
        return self._core.start[3]

    def __repr__(self) -> str:
        def listed(names: list[str]) -> str:
            few = names if len(names) <= 8 else [*names[:7], f"… ({len(names)})"]
            return ", ".join(few)

        states = listed(list(self.states))
        values = listed([f"{name}={value:g}" for name, value in self.parameters.items()])
        return f"<System {self.name!r}: states {states}; {values or 'no parameters'}>"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, System):
            return NotImplemented
        return (self._text, self.parameters) == (other._text, other.parameters)

    def __hash__(self) -> int:
        return hash((self._text, tuple(self.parameters.items())))

    def __reduce__(self) -> Any:
        return System._of, (self._origin, self._text, self._settings)


def _quoted(value: Any) -> str:
    # What JSON escapes TOML's basic strings escape alike.
    return json.dumps(value.text if isinstance(value, Expression) else value, ensure_ascii=False)


def _table(entries: Mapping[str, Any]) -> list[str]:
    lines = []
    for key, value in entries.items():
        if isinstance(value, bool):
            shown = "true" if value else "false"
        elif isinstance(value, float):
            shown = written(value)
        elif isinstance(value, int):
            shown = str(value)
        elif isinstance(value, list):
            shown = "[" + ", ".join(written(one) for one in value) + "]"
        else:
            shown = _quoted(value)
        lines.append(f"{key} = {shown}")
    return lines


def _text(
    rates: Mapping[State, Any],
    contacts: Sequence[Contact],
    jumps: Sequence[Jump],
    start: Mapping[State, Any] | Sequence[Any] | None,
    period: Any,
    name: str,
) -> str:
    if not isinstance(rates, Mapping) or not rates:
        raise TypeError("rates must be {state: rate, …} with a rate for each state")
    for state in rates:
        if not isinstance(state, State):
            raise TypeError(f"{state!r} is no state: the keys of rates are made by ss.states")
    field = {state.name: expression(rate) for state, rate in rates.items()}
    starts = _starts(list(rates), start)
    whole = None if period is None else expression(period)

    given = [*field.values(), *starts.values(), *([] if whole is None else [whole])]
    for jump in jumps:
        given += [jump.when, *jump.set.values()]
        given += [state for state in jump.set if isinstance(state, DiscreteState)]
    parts = _parts([*given, *contacts])
    unknown = [one for one in parts if isinstance(one, State) and one not in rates]
    if unknown:
        raise ValueError(f"the state {unknown[0].name} has no rate: add it to rates")
    missing = [one for one in parts if isinstance(one, Contact) and one not in contacts]
    if missing:
        raise ValueError(f"the contact {missing[0].name} is not among contacts=[…]")

    def of(kind: type) -> list[Any]:
        return sorted((one for one in parts if isinstance(one, kind)), key=lambda one: one.name)

    tables: list[tuple[str, dict[str, Any]]] = [
        ("states", {state.name: "" for state in rates}),
        ("discrete", {one.name: one.start for one in of(DiscreteState)}),
        ("parameters", {one.name: one.value for one in of(Parameter)}),
    ]
    for contact in contacts:
        laws = {
            "boundary": contact.boundary,
            "friction": contact.law,
            "static": contact.static,
            "normal_force": contact.normal_force,
        }
        entries: dict[str, Any] = {key: law for key, law in laws.items() if law is not None}
        tables.append((f"contacts.{contact.name}", entries))
    tables += [(f"inputs.{one.name}", one.entries) for one in of(Input)]
    tables += [(f"switches.{one.name}", {"function": one.function}) for one in of(Switch)]
    for jump in jumps:
        entries = dict[str, Any](when=jump.when, direction=jump.direction)
        if jump.stop:
            entries["stop"] = True
        if jump.count is not None:
            entries["count"] = int(jump.count)
        tables.append((f"jumps.{jump.name}", entries))
        if jump.set:
            values = {state.name: value for state, value in jump.set.items()}
            tables.append((f"jumps.{jump.name}.set", values))
    tables.append(("field", field))
    tables.append(("start", starts))
    tables.append(("time", {} if whole is None else {"period": whole}))

    lines = [f"name = {_quoted(name)}"]
    for title, entries in tables:
        if entries:
            lines += ["", f"[{title}]", *_table(entries)]
    return "\n".join(lines) + "\n"


def _starts(states: list[State], start: Any) -> dict[str, Expression]:
    if start is None:
        return {}
    if not isinstance(start, Mapping):
        if len(start) != len(states):
            raise ValueError(f"start has {len(start)} values, and there are {len(states)} states")
        start = dict(zip(states, start))
    missing = [state.name for state in states if state not in start]
    if missing:
        raise ValueError(f"start has no value of the state {missing[0]}")
    return {state.name: expression(start[state]) for state in states}


def _parts(formulas: Iterable[Expression]) -> set[Any]:
    """All named objects that formulas are made of, and those that these are made of."""
    found: dict[str, Any] = {}
    waiting = [part for formula in formulas for part in formula.parts]
    while waiting:
        part = waiting.pop()
        known = found.get(part.name)
        if known is part:
            continue
        if known is not None:
            same = type(known) is type(part) and _described(known) == _described(part)
            if not same:
                raise ValueError(f"two different things are called {part.name}")
            continue
        found[part.name] = part
        for inner in _inner(part):
            waiting += inner.parts
    return set(found.values())


def _inner(part: Any) -> list[Expression]:
    if isinstance(part, Contact):
        laws = [part.boundary, part.law, part.static, part.normal_force]
        return [law for law in laws if law is not None]
    if isinstance(part, Switch):
        return [part.function]
    if isinstance(part, DiscreteState):
        return [part.start]
    if isinstance(part, Input):
        return [one for one in part.entries.values() if isinstance(one, Expression)]
    return []


def _described(part: Any) -> Any:
    if isinstance(part, Parameter):
        return part.value
    entries = part.entries.items() if isinstance(part, Input) else ()
    return [repr(one) for one in _inner(part)], repr(list(entries))
