"""Formulas in LaTeX, for notebooks."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

# Precedence of operators, as formulas have it: `-x^2` is `-(x^2)`. A choice by cases ends nowhere,
# so that it stands in brackets within any other formula. A decimal with a power of ten is a product
# that needs no brackets as a factor. Roots and fractions are no bases of powers: an exponent beside
# them reads as one of the numerator or of what is under the root.
_CASES, _OR, _AND, _NOT, _COMPARED, _SUM, _PRODUCT, _SIGN, _DECIMAL, _POWER, _ATOM = range(11)

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_TOKEN = re.compile(rf"\s*(?:({_NUMBER})|([^\W\d][\w.]*)|([<>]=|.))")
_SIGNS = {"<": "<", "<=": r"\le", ">": ">", ">=": r"\ge"}
_GREEK = {
    *"alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho".split(),
    *"sigma tau upsilon phi chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Phi Psi".split(),
    "Omega",
}
_NAMES = {
    **{name: f"\\{name}" for name in "sin cos tan sinh cosh tanh exp ln min".split()},
    **{"max": r"\max", "asin": r"\arcsin", "acos": r"\arccos", "atan": r"\arctan"},
    **{"log10": r"\log_{10}", "friction": "F"},
}


def symbol(name: str) -> str:
    """A name: Greek where it is the name of a letter, with digits and further words as an index."""
    head, _, tail = name.replace(".", "_").partition("_")
    digits = re.fullmatch(r"(\D+?)(\d+)", head)
    if digits and not tail:
        head, tail = digits.groups()
    text = f"\\{head}" if head in _GREEK else head if len(head) == 1 else rf"\mathrm{{{head}}}"
    return f"{text}_{{{_words(tail)}}}" if tail else text


def _words(text: str) -> str:
    plain = text.replace("_", r"\ ")
    return plain if text.isdigit() or len(text) == 1 else rf"\mathrm{{{plain}}}"


#: Reads a part of a formula: its LaTeX and its precedence.
_Reader = Callable[[], tuple[str, int]]


class _Parser:
    """Reads a formula and writes it again, each part with its precedence."""

    def __init__(self, text: str) -> None:
        self._tokens = [match.groups() for match in _TOKEN.finditer(text.strip())]
        self._at = 0

    def _peek(self) -> str:
        if self._at >= len(self._tokens):
            return ""
        return next(one for one in self._tokens[self._at] if one is not None)

    def _next(self) -> tuple[str | None, str | None, str | None]:
        self._at += 1
        number, name, sign = self._tokens[self._at - 1]
        return number, name, sign

    def whole(self) -> tuple[str, int]:
        """A formula, or a condition."""
        return self._joined("or", r"\lor", _OR, self._conjunction)

    def _conjunction(self) -> tuple[str, int]:
        return self._joined("and", r"\land", _AND, self._negation)

    def _joined(self, word: str, sign: str, joint: int, part: _Reader) -> tuple[str, int]:
        left, binds = part()
        while self._peek() == word:
            self._next()
            right, inner = part()
            a, b = _within(left, binds, joint), _within(right, inner, joint + 1)
            left, binds = rf"{a} {sign} {b}", joint
        return left, binds

    def _negation(self) -> tuple[str, int]:
        if self._peek() == "not":
            self._next()
            inner, binds = self._negation()
            return rf"\lnot {_within(inner, binds, _ATOM)}", _NOT
        left, binds = self._sum()
        if self._peek() in _SIGNS:
            sign = _SIGNS[self._peek()]
            self._next()
            right = _within(*self._sum(), _SUM)
            return f"{_within(left, binds, _SUM)} {sign} {right}", _COMPARED
        return left, binds

    def _sum(self) -> tuple[str, int]:
        left, binds = self._product()
        while self._peek() in ("+", "-"):
            sign = self._next()[2]
            right, inner = self._product()
            left = _within(left, binds, _SUM)
            left, binds = f"{left} {sign} {_unsigned(right, inner, _PRODUCT)}", _SUM
        return left, binds

    def _product(self) -> tuple[str, int]:
        left, binds = self._signed()
        while self._peek() in ("*", "/", "·", "×"):
            sign = self._next()[2]
            right, inner = self._signed()
            if sign == "/":
                left, binds = rf"\frac{{{left}}}{{{right}}}", _POWER
            else:
                left, binds = _product(left, binds, right, inner), _PRODUCT
        return left, binds

    def _signed(self) -> tuple[str, int]:
        if self._peek() == "-":
            self._next()
            inner, binds = self._signed()
            return f"-{_unsigned(inner, binds, _PRODUCT)}", _SIGN
        return self._power()

    def _power(self) -> tuple[str, int]:
        base, binds = self._atom()
        if self._peek() == "^":
            self._next()
            exponent = self._signed()[0]
            return f"{_within(base, binds, _ATOM)}^{{{exponent}}}", _POWER
        return base, binds

    def _atom(self) -> tuple[str, int]:
        number, name, sign = self._next()
        if number is not None:
            return _number(number)
        if name is not None:
            return self._named(name)
        if sign != "(":
            return str(sign), _ATOM
        inner, binds = self.whole()
        self._next()
        return inner, binds

    def _named(self, name: str) -> tuple[str, int]:
        if self._peek() != "(":
            stop = name.removesuffix(".force")
            return symbol(name) if stop == name else _reaction(stop), _ATOM
        of = []
        while self._next()[2] in ("(", ","):
            of.append(self.whole()[0])
        return _call(name, of)


def _call(name: str, of: list[str]) -> tuple[str, int]:
    if name == "sqrt":
        return rf"\sqrt{{{of[0]}}}", _POWER
    if name == "abs":
        return rf"\left|{of[0]}\right|", _ATOM
    if name == "friction":
        return rf"F_{{{of[0]}}}", _ATOM
    if name == "if":
        rows = rf"{of[1]} & \text{{if }} {of[0]} \\ {of[2]} & \text{{otherwise}}"
        return rf"\begin{{cases}} {rows} \end{{cases}}", _CASES
    if name == "by_side":
        below, above = (rf"{of[k]} & {of[0]} {sign} 0" for k, sign in ((1, "<"), (2, ">")))
        return rf"\begin{{cases}} {below} \\ {above} \end{{cases}}", _CASES
    known = _NAMES.get(name, rf"\operatorname{{{name}}}")
    return rf"{known}\left({', '.join(of)}\right)", _ATOM


def _number(text: str) -> tuple[str, int]:
    plain = text.removesuffix(".0")
    digits, _, power = plain.lower().partition("e")
    return (rf"{digits} \cdot 10^{{{int(power)}}}", _DECIMAL) if power else (plain, _ATOM)


def _product(left: str, binds: int, right: str, inner: int) -> str:
    """A product. Before a bracket there is a sign, so that it is no call of a function."""
    a, b = _within(left, binds, _PRODUCT), _within(right, inner, _DECIMAL)
    # A number and a fraction side by side would be read as their sum.
    is_mixed = a[-1:].isdigit() and b.startswith(r"\frac")
    is_apart = b[:1].isdigit() or b.startswith(r"\left(") or is_mixed
    return rf"{a} \cdot {b}" if is_apart else rf"{a}\,{b}"


def _within(text: str, binds: int, least: int) -> str:
    return text if binds >= least else rf"\left({text}\right)"


def _unsigned(text: str, binds: int, least: int) -> str:
    """A part behind a sign, which does not begin with another one."""
    return _within(text, _OR if text.startswith("-") else binds, least)


def latex(text: str) -> str:
    """A formula in LaTeX."""
    return _Parser(text).whole()[0]


def _formula(value: Any) -> str:
    return latex(str(value))


def _side(value: Any) -> str:
    """A formula as a side of an equation or a term of a sum."""
    return _within(*_Parser(str(value)).whole(), _SUM)


def _reaction(stop: str) -> str:
    return rf"\lambda_{{{symbol(stop)}}}"


def _times(left: str, value: Any) -> str:
    """The product of a symbol and a formula."""
    return _product(left, _ATOM, *_Parser(str(value)).whole())


def _added(left: str, factor: str) -> str:
    """A term of a sum: the product of a symbol and a formula, whose sign comes first."""
    text, binds = _Parser(factor).whole()
    sign = "-" if binds == _SIGN else "+"
    if binds == _SIGN:
        text, binds = text[1:], _ATOM
    return f" {sign} {left if text == '1' else _product(left, _ATOM, text, binds)}"


def system_latex(file: Mapping[str, Any]) -> str:
    """The equations of a system, from the tables of its file."""
    stops = file.get("stops", {})
    lines = []
    for state, rate in file["field"].items():
        acting = [name for name, stop in stops.items() if state in stop.get("acts", {})]
        text = _side(rate) if acting else _formula(rate)
        for name in acting:
            text += _added(_reaction(name), str(stops[name]["acts"][state]))
        lines.append(rf"\dot{{{symbol(state)}}} &= {text}")
    for name, value in file.get("definitions", {}).items():
        lines.append(rf"{symbol(name)} &= {_formula(value)}")
    for name, contact in file.get("contacts", {}).items():
        side = symbol(name)
        lines.append(rf"{side} &= \operatorname{{sgn}}\left({_formula(contact['boundary'])}\right)")
        if "friction" in contact:
            lines.append(rf"F_{{{side}}} &= {_times(side, contact['friction'])}")
    for name, stop in stops.items():
        gap = rf"g_{{{symbol(name)}}}"
        lines.append(rf"{gap} &= {_formula(stop['gap'])}")
        lines.append(rf"0 &\le {gap} \perp {_reaction(name)} \ge 0")
        speed = rf"\dot{{{gap}}}"
        factor = _Parser(str(stop.get("restitution", 0))).whole()
        product = _unsigned(_product(*factor, speed, _ATOM), _PRODUCT, _PRODUCT)
        behind = "0" if factor[0] == "0" else f"-{product}"
        lines.append(rf"{gap} = 0 &: {speed} \to {behind}")
    lines += [" &: ".join(jump_latex(jump)) for jump in file.get("jumps", {}).values()]
    return "$$\\begin{aligned} " + r" \\ ".join(lines) + " \\end{aligned}$$"


def jump_latex(jump: Mapping[str, Any]) -> tuple[str, str]:
    """Where a jump happens, and what it does."""
    when = f"{_side(jump['when'])} = 0"
    if jump.get("direction", "both") != "both":
        when += rf"\ \text{{({jump['direction']})}}"
    if "if" in jump:
        when += rf"\ \text{{if}}\ {_formula(jump['if'])}"
    values = jump.get("set", {}).items()
    changes = [rf"{symbol(state)} \to {_formula(value)}" for state, value in values]
    if jump.get("stop"):
        changes.append(r"\text{end}")
    if "count" in jump:
        changes.append(rf"\text{{end after {jump['count']}}}")
    return when, r",\ ".join(changes)
