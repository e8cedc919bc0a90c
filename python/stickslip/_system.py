"""Systems from symbols or from a text. The engine receives the text."""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NoReturn

import numpy as np

from . import _core
from ._symbols import (
    Condition,
    Contact,
    Curve,
    DiscreteState,
    Expression,
    Input,
    Jump,
    Parameter,
    State,
    Stop,
    Switch,
    expression,
    number,
    written,
)


class System:
    """A system with its parameters.

    Parameters, inputs, switches and discrete states are collected from the formulas. A pickle
    contains the text of the system and the values of its parameters.

    Parameters
    ----------
    rates : dict
        The rate of each state, in the order of the states: ``{x: v, v: -x}``.
    contacts : Contact or a sequence of them, optional
        All contacts that occur in the rates.
    jumps : Jump or a sequence of them, optional
        Instantaneous changes of the state.
    stops : Stop or a sequence of them, optional
        Unilateral constraints with impacts. Each adds a discrete state, behind all others.
    start : dict or sequence, optional
        Start state, which may depend on parameters. Discrete states may be left out: they start at
        their own values. In a sequence they come last, sorted by name.
    period : float or Expression, optional
        Period in time. Attractors of a system that depends on time need it.
    name : str, optional
        Name of the system.
    """

    def __init__(
        self,
        rates: Mapping[State, Any],
        *,
        contacts: Contact | Iterable[Contact] = (),
        jumps: Jump | Iterable[Jump] = (),
        stops: Stop | Iterable[Stop] = (),
        start: Mapping[State, Any] | Sequence[Any] | None = None,
        period: Any = None,
        name: str = "system",
    ) -> None:
        several = (
            _all(contacts, Contact, "contacts"),
            _all(jumps, Jump, "jumps"),
            _all(stops, Stop, "stops"),
        )
        text = _text(rates, several, start, period, str(name))
        self._set(str(name), text, {})

    def _set(self, origin: str, text: str, settings: Mapping[str, float]) -> None:
        self._origin, self._text, self._settings = origin, text, dict(settings)
        self._core = _core.System(origin, text, list(settings.items()))
        self._states = tuple(self._core.states)
        self._sections: dict[tuple[Any, ...], _core.System] = {}

    def _with_sections(self, sections: Iterable[tuple[Expression, int]]) -> _core.System:
        """Compile the system with sections, stored for further runs."""
        wanted = [(one.text, direction, one) for one, direction in sections]
        key = tuple((text, direction, one.parts) for text, direction, one in wanted)
        if not key:
            return self._core
        if key not in self._sections:
            for _, _, function in wanted:
                self._check_symbols(function)
            if len(self._sections) >= 64:
                self._sections.clear()
            pairs = [(text, direction) for text, direction, _ in wanted]
            self._sections[key] = self._core.with_sections(pairs)
        return self._sections[key]

    def _check_symbols(self, formula: Expression) -> None:
        """Rejects symbols that the system has with another value or as something else."""
        parts = _parts([formula])
        if any(isinstance(one, (Contact, Stop)) for one in parts):
            # The engine rejects sides, and knows the stops.
            return
        if all(type(one) is State and one.text in self._core.states for one in parts):
            return
        rates: dict[State, Any] = {one: 0.0 for one in parts if isinstance(one, State)}
        mine = tomllib.loads(_text({**rates, State("_"): formula}, ((), (), ()), None, None, ""))
        text = tomllib.loads(self._text)
        kinds = ["definitions", "switches", "inputs", "curves", "parameters", "discrete", "states"]
        known = {name: kind for kind in kinds for name in text.get(kind, {})}
        for kind, name in [(kind, name) for kind in kinds for name in mine.get(kind, {})]:
            there = known.get(name, kind)
            if there != kind and (kind != "states" or there == "parameters"):
                raise ValueError(
                    f"{name} is among the {there} of the system, and among the {kind} of the "
                    f"formula {formula}: give one of them another name"
                )
            if kind == "states" or name not in known:
                continue
            one, other = mine[kind][name], text[kind][name]
            if kind == "parameters":
                # A system with another value of a parameter has the symbol of the original one.
                first = System._of(self._origin, self._text, {}) if self._settings else self
                other, one = self.parameters[name], one["value"] if isinstance(one, dict) else one
                other = one if one == first.parameters[name] else other
            if _plain(one) != _plain(other):
                raise ValueError(
                    f"{name} is {other} in the system and {one} in the formula {formula}: use the "
                    "system's symbol, or give one of them another name"
                )

    @classmethod
    def _of(cls, origin: str, text: str, settings: Mapping[str, float]) -> System:
        system = cls.__new__(cls)
        system._set(origin, text, settings)
        return system

    @classmethod
    def from_toml(cls, source: str | os.PathLike[str]) -> System:
        """Reads a system from a file.

        Parameters
        ----------
        source : str or path
            Path of a file, name of a shipped model such as ``"belt"``, or a text of several lines.

        Returns
        -------
        System

        Raises
        ------
        SystemError
            If the file cannot be read or is wrong. The message shows the place.
        """
        if isinstance(source, str) and "\n" in source:
            return cls._of("text", source, {})
        path = os.fspath(source)
        return cls._of(path, _core.System.text_of(path), {})

    def to_toml(self) -> str:
        """The text of a file for the program `stickslip`. It contains the original values of the
        parameters; pass those of `with_parameters` to the program by `--set`."""
        return self._text

    def with_parameters(
        self, values: Mapping[Any, float] | None = None, /, **more: float
    ) -> System:
        """Copy the system with other values of some parameters.

        Parameters
        ----------
        values : dict, optional
            Values by parameter or name, such as ``{mu0: 0.3}``.
        **more : float
            Values by name, such as ``mu0=0.3``.

        Returns
        -------
        System

        Raises
        ------
        SystemError
            If there is no such parameter, or its value is not allowed.
        OptionError
            If a value is infinite or NaN.
        """
        given: dict[Any, float] = {} if values is None else dict(values)
        checked = {
            name: number(value, name, "the parameter ")
            for key, value in (given | more).items()
            for name in [getattr(key, "name", key)]
        }
        return self._of(self._origin, self._text, {**self._settings, **checked})

    @property
    def name(self) -> str:
        """Name of the system."""
        return self._core.name

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states in their order; discrete ones come last."""
        return self._states

    @property
    def discrete(self) -> tuple[str, ...]:
        """Names of the discrete states. A start may leave them out."""
        return tuple(self._core.discrete)

    @property
    def parameters(self) -> Mapping[str, float]:
        """Values of the parameters by name, to read. `with_parameters` sets them."""
        return _Values(self._core.parameters)

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
        """Start state, if the system defines one."""
        start = tuple(one for one in self._core.starts if one is not None)
        return start if len(start) == len(self.states) else None

    @property
    def period(self) -> float | None:
        """Period in time of a driven system."""
        return self._core.period

    def check(self, y0: Any = None) -> list[str]:
        """Warnings about the system, as the program's ``check`` prints them.

        They concern friction that drives the slip, static friction below kinetic friction,
        dependent boundaries, a wrong period, and jumps that are past their zero at the start.

        Parameters
        ----------
        y0 : array_like, shape (n,), or dict, optional
            Start state, in order or as ``{x: 1, v: 0}``. Default: the start of the system. Without
            a start, friction and jumps are not checked.

        Returns
        -------
        list of str
            The warnings.

        Examples
        --------
        >>> import stickslip as ss
        >>> x, v = ss.states("x v")
        >>> floor = ss.Contact("floor", boundary=v, friction=0.4)
        >>> ss.System({x: v, v: -x - floor.friction}, contacts=[floor], start=[1, 0]).check()
        []
        """
        from ._arguments import state

        given = None if y0 is None and self.start is None else state(self, y0)
        return self._core.check(given)

    def __repr__(self) -> str:
        def listed(names: list[str]) -> str:
            few = names if len(names) <= 8 else [*names[:7], f"… ({len(names)})"]
            return ", ".join(few)

        states = listed(list(self.states))
        values = listed([f"{name}={value:g}" for name, value in self.parameters.items()])
        return f"<System {self.name!r}: states {states}; {values or 'no parameters'}>"

    def _repr_latex_(self) -> str:
        from ._latex import system_latex

        return system_latex(tomllib.loads(self._text))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, System):
            return NotImplemented
        return (self._text, self.parameters) == (other._text, other.parameters)

    def __hash__(self) -> int:
        return hash((self._text, tuple(self.parameters.items())))

    def __reduce__(self) -> Any:
        return System._of, (self._origin, self._text, self._settings)


class _Values(dict[str, float]):
    """Values of parameters, to read only."""

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError(
            "the parameters of a system are only read here: system.with_parameters(name=value) is "
            "the system with another value"
        )

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> Any:
        return dict, (dict(self),)


def _quoted(value: Any) -> str:
    # JSON and TOML basic strings have the same escapes.
    is_formula = isinstance(value, (Expression, Condition))
    return json.dumps(value.text if is_formula else value, ensure_ascii=False)


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
            shown = _list(value)
        elif isinstance(value, dict):
            shown = "{ " + ", ".join(_table(value)) + " }"
        else:
            shown = _quoted(value)
        lines.append(f"{_key(key)} = {shown}")
    return lines


def _list(values: list[Any]) -> str:
    """A list of numbers, or of such lists."""
    shown = (_list(one) if isinstance(one, list) else written(one) for one in values)
    return "[" + ", ".join(shown) + "]"


def _key(name: str) -> str:
    """A name as a key of TOML, where other letters than A to Z stand in quotes."""
    return name if name.isascii() else _quoted(name)


def _text(
    rates: Mapping[State, Any],
    several: tuple[Sequence[Contact], Sequence[Jump], Sequence[Stop]],
    start: Mapping[State, Any] | Sequence[Any] | None,
    period: Any,
    name: str,
) -> str:
    contacts, jumps, stops = several
    if not isinstance(rates, Mapping) or not rates:
        raise TypeError("rates must be {state: rate, …} with a rate for each state")
    for state in rates:
        if not isinstance(state, State):
            raise TypeError(f"{state!r} is no state: the keys of rates are made by ss.states")
    field = {state.name: expression(rate) for state, rate in rates.items()}
    whole = None if period is None else expression(period)

    given: list[Any] = [*field.values(), *([] if whole is None else [whole])]
    for jump in jumps:
        given += [jump.when, *jump.set.values()]
        given += [] if jump.condition is None else [jump.condition]
        given += [state for state in jump.set if isinstance(state, DiscreteState)]
    used = _parts([*given, *contacts, *stops])
    discrete = {one for one in used if isinstance(one, DiscreteState)}
    starts = _starts([*rates, *sorted(discrete, key=lambda one: one.name)], len(rates), start)
    parts = _parts([*given, *starts.values(), *contacts, *stops])
    unknown = [one for one in parts if isinstance(one, State) and one not in rates]
    if unknown:
        raise ValueError(f"the state {unknown[0].name} has no rate: add it to rates")
    missing = [one for one in parts if isinstance(one, Contact) and one not in set(contacts)]
    if missing:
        raise ValueError(f"the contact {missing[0].name} is not among contacts=[…]")

    apart = [one for one in parts if isinstance(one, Stop) and one not in set(stops)]
    if apart:
        raise ValueError(f"the stop {apart[0].name} is not among stops=[…]")

    acting = _parts(field.values())
    for one in contacts:
        if one.law is not None and not any(one.friction.text in rate.text for rate in given):
            raise ValueError(
                f"the friction of the contact {one} acts nowhere: write {one}.friction in a rate"
            )
        if one not in acting:
            raise ValueError(
                f"the rates are the same on both sides of the contact {one}: write {one}.side, "
                f"{one}.friction or {one}.by_side(below, above) in a rate"
            )

    def of(kind: type) -> list[Any]:
        return sorted((one for one in parts if isinstance(one, kind)), key=lambda one: one.name)

    tables: list[tuple[str, dict[str, Any]]] = [
        ("states", {state.name: "" for state in rates}),
        ("discrete", {one.name: starts.pop(one.name, one.start) for one in of(DiscreteState)}),
        ("parameters", {one.name: _entry(one) for one in of(Parameter)}),
    ]
    for contact in contacts:
        laws = {
            "boundary": contact.boundary,
            "friction": contact.law,
            "static": contact.static,
            "normal_force": contact.normal_force,
        }
        entries: dict[str, Any] = {key: law for key, law in laws.items() if law is not None}
        tables.append((f"contacts.{_key(contact.name)}", entries))
    tables += [(f"inputs.{_key(one.name)}", one.entries) for one in of(Input)]
    tables += [(f"switches.{_key(one.name)}", {"function": one.function}) for one in of(Switch)]
    tables += [(f"curves.{_key(one.name)}", one.entries) for one in of(Curve)]
    for jump in jumps:
        tables.append((f"jumps.{_key(jump.name)}", jump._entries()))
        if jump.set:
            values = {state.name: value for state, value in jump.set.items()}
            tables.append((f"jumps.{_key(jump.name)}.set", values))
    for stop in stops:
        title = f"stops.{_key(stop.name)}"
        tables.append((title, {"gap": stop.gap, "restitution": stop.restitution}))
        acts = {state.name: value for state, value in stop.acts.items()}
        tables.append((f"{title}.acts", acts))
    tables.append(("field", field))
    tables.append(("start", starts))
    tables.append(("time", {} if whole is None else {"period": whole}))

    lines = [f"name = {_quoted(name)}"]
    for title, entries in tables:
        if entries:
            lines += ["", f"[{title}]", *_table(entries)]
    return "\n".join(lines) + "\n"


def _all(given: Any, kind: type[Any], what: str) -> tuple[Any, ...]:
    """One or several of a kind."""
    several = (given,) if isinstance(given, kind) else tuple(given)
    for one in several:
        if not isinstance(one, kind):
            raise TypeError(f"{what} must be made by ss.{kind.__name__}, and {one!r} is not")
    names = [one.name for one in several]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"{what} has two that are called {name}; give one another name")
    return several


def _entry(parameter: Parameter) -> Any:
    if parameter.range is None:
        return parameter.value
    return {"value": parameter.value, "range": list(parameter.range)}


def _starts(states: Sequence[Any], moving: int, start: Any) -> dict[str, Expression]:
    """Starts by name. Those behind the moving states are discrete, and may be left out."""
    if start is None:
        return {}
    names = [state.name for state in states]
    if isinstance(start, Mapping):
        start = {getattr(key, "name", key): value for key, value in start.items()}
    elif np.ndim(start) != 1 or len(start) not in (moving, len(states)):
        help = f"; the last {len(states) - moving}, discrete, may be left out"
        raise ValueError(
            f"start must be {len(states)} values, of the states {', '.join(names)}"
            + (help if len(states) > moving else "")
        )
    else:
        start = dict(zip(names, start))
    for name in names[:moving]:
        if name not in start:
            raise ValueError(f"start has no value of the state {name}")
    for name in start:
        if name not in names:
            raise ValueError(f"start has a value of {name}, which has no rate")
    return {name: expression(start[name]) for name in names if name in start}


def _parts(formulas: Iterable[Expression | Condition]) -> set[Any]:
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
                kinds = sorted({_kind(known), _kind(part)})
                what = f"two {kinds[0]}s"
                if len(kinds) > 1:
                    what = f"one {kinds[0]} and one {kinds[1]}"
                raise ValueError(f"{part.name} is the name of {what}; give one another name")
            continue
        found[part.name] = part
        for inner in _inner(part):
            waiting += inner.parts
    return set(found.values())


def _plain(entry: Any) -> Any:
    """An entry of a text, in which numbers and spaces may be written in several ways."""
    if isinstance(entry, dict):
        return {"between": "linear"} | {key: _plain(value) for key, value in entry.items()}
    if isinstance(entry, list):
        return [_plain(one) for one in entry]
    try:
        return float(entry)
    except ValueError:
        return "".join(entry.split())


def _kind(part: Any) -> str:
    return "discrete state" if isinstance(part, DiscreteState) else type(part).__name__.lower()


def _inner(part: Any) -> list[Expression]:
    if isinstance(part, Contact):
        laws = [part.boundary, part.law, part.static, part.normal_force]
        return [law for law in laws if law is not None]
    if isinstance(part, Stop):
        return [part.gap, *part.acts, *part.acts.values(), part.restitution]
    if isinstance(part, Switch):
        return [part.function]
    if isinstance(part, DiscreteState):
        return [part.start]
    if isinstance(part, Input):
        return [one for one in part.entries.values() if isinstance(one, Expression)]
    return []


def _described(part: Any) -> Any:
    if isinstance(part, Parameter):
        return part.value, part.range
    entries = part.entries.items() if isinstance(part, (Curve, Input)) else ()
    return [repr(one) for one in _inner(part)], repr(list(entries))
